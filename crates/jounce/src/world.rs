//! The world: owns every table. No physics here; see [`crate::stage`].

use crate::command::{Command, Output};
use crate::error::{Error, Result};
use crate::event::Event;
use crate::handle::{BodyId, CharacterId, EmitterId, FieldId, JointId, ShapeId, VehicleId};
use crate::hooks::Hooks;
use crate::moving::MovingTree;
use crate::room::characters::desc::{CharacterDesc, CharacterInput};
use crate::room::characters::state::Characters;
use crate::room::contacts::state::{Contact, ContactPlace, PairHead, ShapeRecord};
use crate::room::fields::state::Fields;
use crate::room::joints::state::Joints;
use crate::room::particles::state::Particles;
use crate::room::rigid::state::{Awake, Body, BodyFrame, NONE};
use crate::room::vehicles::state::Vehicles;
use crate::settings::{Settings, WorldDesc};
use crate::stage::Scratch;
use crate::stage::broadphase::Tag;
use crate::table::{PairMap, Table};
use jounce_geometry::{Aabb, Bvh};
use jounce_lanes::Width;
use jounce_math::{DVec3, Quat, Vec3};
use jounce_tasks::Tasks;

/// A world of bodies, and everything that happens to them.
///
/// `Send + Sync + Clone`: a clone is an independent world with the same future.
#[derive(Clone, Debug)]
pub struct World {
    pub(crate) gravity: Vec3,
    pub(crate) rate_hz: f64,
    pub(crate) substeps: u32,
    pub(crate) settings: Settings,
    pub(crate) step_count: u64,
    /// Time not yet stepped by `advance`; not part of the state.
    pub(crate) accumulator: f64,

    pub(crate) bodies: Table<Body>,
    /// By body slot.
    pub(crate) frames: Vec<BodyFrame>,
    pub(crate) awake: Awake,
    pub(crate) islands: Table<Vec<u32>>,

    pub(crate) shapes: Table<ShapeRecord>,
    pub(crate) sensors: Vec<u32>,
    /// Shapes with restitution: while there are any, bounds look a step ahead.
    pub(crate) bouncy: usize,
    /// Shapes with a surface that runs, and shapes that tell of hits.
    pub(crate) running: usize,
    pub(crate) telling: usize,
    /// Fat bounds of shapes by slot, as they are in the trees.
    pub(crate) fat: Vec<Aabb>,
    /// The same as of the last pair search: pairs that met then have their contacts. NaN for what was put there since.
    pub(crate) fat_before: Vec<Aabb>,
    /// By shape slot.
    pub(crate) tags: Vec<Tag>,
    pub(crate) fixed_tree: Bvh,
    pub(crate) moving_tree: MovingTree,
    pub(crate) unbounded: Vec<u32>,
    /// Shapes whose bounds changed since the last pair search.
    pub(crate) moved: Vec<u32>,

    pub(crate) pairs: PairMap,
    /// Some pairs whose bounds meet may have no contact: a hook refused them, or there were too many.
    pub(crate) pairs_missing: bool,
    pub(crate) places: Vec<ContactPlace>,
    pub(crate) free_contacts: Vec<u32>,
    /// Contacts with an awake body, dense.
    pub(crate) contacts: Vec<Contact>,
    /// Beside `contacts`, row by row.
    pub(crate) heads: Vec<PairHead>,
    pub(crate) asleep_contacts: Vec<Contact>,
    /// By body: its row in the awake columns, or NONE; and that row as colours name it (shared, where the body is not dynamic).
    pub(crate) row_of: Vec<u32>,
    pub(crate) items: Vec<u32>,
    /// By body: the way that the farthest of its points has made over all steps, at most, m; and the sum of 2 sin(θ/2) of its turns.
    pub(crate) travel: Vec<[f64; 2]>,

    pub(crate) fields: Fields,
    pub(crate) particles: Particles,
    pub(crate) joints: Joints,
    pub(crate) vehicles: Vehicles,
    pub(crate) characters: Characters,

    /// What happened since the last step ended (edits), then in the step being made; told as it ends.
    pub(crate) events: Vec<Event>,
    pub(crate) told: Told,
    pub(crate) queue: Vec<Command>,
    pub(crate) hooks: Hooks,
    pub(crate) tasks: Tasks,
    /// Lanes of the solver's kernels; changes no bit.
    pub(crate) width: Width,
    pub(crate) scratch: Scratch,
}

/// The events of steps that have ended.
#[derive(Clone, Debug, Default)]
pub(crate) struct Told {
    list: Vec<Event>,
    /// Where those that users see begin.
    shown: usize,
    /// Where those of the last step begin.
    last: usize,
}

impl Told {
    fn shown(&self) -> &[Event] {
        &self.list[self.shown..]
    }
    /// Those of the last step: they do not depend on how steps were shared out over frames, and so are part of the hash.
    pub(crate) fn last(&self) -> &[Event] {
        &self.list[self.last..]
    }
    /// A call that will make steps, or none, begins with an empty list.
    pub(crate) fn begin(&mut self) {
        self.shown = self.list.len();
    }
    /// Takes in the events of a step; the other list is left empty.
    pub(crate) fn take(&mut self, events: &mut Vec<Event>) {
        if self.shown == self.list.len() {
            self.list.clear();
            self.shown = 0;
        }
        self.last = self.list.len();
        self.list.append(events);
    }
}

/// Kinetic and potential energy, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// ½ m v² + ½ ω·Iω over the dynamic bodies.
    pub kinetic: f64,
    /// −m g·c over the dynamic bodies, c from the world's origin, and their energy in uniform, point and n-body fields.
    pub potential: f64,
}

impl Energy {
    /// Their sum.
    pub fn total(&self) -> f64 {
        self.kinetic + self.potential
    }
}

/// Linear momentum, kg m/s, and angular momentum about the world's origin, kg m²/s; of vehicles, travel and spin of their wheels too.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Momentum {
    /// Σ m v.
    pub linear: DVec3,
    /// Σ c × m v + I ω.
    pub angular: DVec3,
}

/// How much of everything there is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Bodies of all kinds.
    pub bodies: usize,
    /// Awake kinematic and dynamic bodies.
    pub awake: usize,
    /// Shapes.
    pub shapes: usize,
    /// Pairs of shapes whose bounds overlap.
    pub contacts: usize,
    /// Pairs that touch (or are within the speculative margin).
    pub touching: usize,
    /// Sleeping islands.
    pub islands_asleep: usize,
    /// Colours in use in the last step.
    pub colors: usize,
    /// Solver rows that found no colour in the last step.
    pub overflow: usize,
    /// Joints, broken ones too.
    pub joints: usize,
    /// Vehicles.
    pub vehicles: usize,
    /// Characters.
    pub characters: usize,
    /// Emitters.
    pub emitters: usize,
    /// Particles of all emitters.
    pub particles: usize,
}

/// What [`World::advance`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Advance {
    /// Steps made.
    pub steps: u32,
    /// How far the frame is between the last two steps, 0…1: for [`crate::BodyRef::interpolated_pose`].
    pub alpha: f64,
    /// Time given up because more than the allowed steps were due, seconds.
    pub dropped_s: f64,
}

impl World {
    /// An empty world.
    ///
    /// # Errors
    /// A number out of range, named.
    pub fn new(desc: WorldDesc) -> Result<Self> {
        desc.check()?;
        Ok(Self {
            gravity: desc.gravity,
            rate_hz: desc.rate_hz,
            substeps: desc.substeps,
            settings: desc.settings,
            step_count: 0,
            accumulator: 0.0,
            bodies: Table::default(),
            frames: Vec::new(),
            awake: Awake::default(),
            islands: Table::default(),
            shapes: Table::default(),
            sensors: Vec::new(),
            bouncy: 0,
            running: 0,
            telling: 0,
            fat: Vec::new(),
            fat_before: Vec::new(),
            tags: Vec::new(),
            fixed_tree: Bvh::new(),
            moving_tree: MovingTree::default(),
            unbounded: Vec::new(),
            moved: Vec::new(),
            pairs: PairMap::default(),
            pairs_missing: false,
            places: Vec::new(),
            free_contacts: Vec::new(),
            contacts: Vec::new(),
            heads: Vec::new(),
            asleep_contacts: Vec::new(),
            row_of: Vec::new(),
            items: Vec::new(),
            travel: Vec::new(),
            fields: Fields::default(),
            particles: Particles::default(),
            joints: Joints::default(),
            vehicles: Vehicles::default(),
            characters: Characters::default(),
            events: Vec::new(),
            told: Told::default(),
            queue: Vec::new(),
            hooks: Hooks::default(),
            tasks: Tasks::serial(),
            width: Width::detect(),
            scratch: Scratch::default(),
        })
    }

    /// Which threads the steps run on. Changes no simulated bit.
    pub fn set_tasks(&mut self, tasks: Tasks) {
        self.tasks = tasks;
    }
    /// How many lanes the solver's kernels use; the widest of the machine by default. Changes no simulated bit.
    pub fn set_width(&mut self, width: Width) {
        self.width = width;
    }
    /// The scheduler in use.
    pub fn tasks(&self) -> &Tasks {
        &self.tasks
    }
    /// Acts at the start of the next step, in the order of the calls. A command that fails then is dropped;
    /// use [`World::apply`] to learn why.
    ///
    /// # Errors
    /// The queue is full.
    pub fn queue(&mut self, command: Command) -> Result<()> {
        if self.queue.len() >= crate::limits::COMMAND_QUEUE_MAX {
            return Err(Error::Limit {
                what: "commands in the queue",
                limit: crate::limits::COMMAND_QUEUE_MAX,
            });
        }
        self.queue.push(command);
        Ok(())
    }
    /// What happened in the last step, or over all steps of the last [`World::advance`] (nothing where it made none). What
    /// edits between steps cause, such as the end of a contact by a removal, comes first in the list of the next step.
    ///
    /// ```
    /// use jounce::prelude::*;
    ///
    /// # fn main() -> jounce::Result<()> {
    /// let mut world = World::new(WorldDesc::default())?;
    /// world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    /// let ball = world.add_body(BodyDesc::dynamic().at([0.0, 0.5, 0.0]).shape(ShapeDesc::sphere(0.5)))?;
    /// world.step()?;
    /// world.remove_body(ball)?;
    /// world.step()?;
    /// assert!(matches!(world.events(), [Event::ContactEnd { .. }]));
    /// # Ok(())
    /// # }
    /// ```
    pub fn events(&self) -> &[Event] {
        self.told.shown()
    }
    /// Simulated time, seconds.
    pub fn time(&self) -> f64 {
        self.step_count as f64 / self.rate_hz
    }
    /// Steps made.
    pub fn step_count(&self) -> u64 {
        self.step_count
    }
    /// Length of a step, seconds.
    pub fn dt(&self) -> f64 {
        1.0 / self.rate_hz
    }
    /// Substeps of a step.
    pub fn substeps(&self) -> u32 {
        self.substeps
    }
    /// Uniform gravity, m/s².
    pub fn gravity(&self) -> Vec3 {
        self.gravity
    }
    /// Constants of the solver.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }
    /// All bodies, in slot order.
    pub fn bodies(&self) -> impl Iterator<Item = BodyId> + '_ {
        self.bodies.iter().map(|(i, _)| self.body_id(i))
    }
    /// All shapes, in slot order.
    pub fn shapes(&self) -> impl Iterator<Item = ShapeId> + '_ {
        self.shapes.iter().map(|(i, _)| self.shape_id(i))
    }
    /// How much of everything there is.
    pub fn counts(&self) -> Counts {
        let touching = |c: &[Contact]| c.iter().filter(|c| c.touching).count();
        Counts {
            bodies: self.bodies.len(),
            awake: self.awake.state.len(),
            shapes: self.shapes.len(),
            contacts: self.contacts.len() + self.asleep_contacts.len(),
            touching: touching(&self.contacts) + touching(&self.asleep_contacts),
            islands_asleep: self.islands.len(),
            colors: self.scratch.colors_used(),
            overflow: self.scratch.overflow_rows(),
            joints: self.joints.table.len(),
            vehicles: self.vehicles.table.len(),
            characters: self.characters.table.len(),
            emitters: self.particles.emitters.len(),
            particles: self.particles.count,
        }
    }
    /// Energy of the dynamic bodies.
    pub fn energy(&self) -> Energy {
        let mut e = Energy::default();
        for (i, b) in self.bodies.iter().filter(|(_, b)| b.enabled && b.mass.inv_mass > 0.0) {
            let f = &self.frames[i as usize];
            let (v, w) = self.velocities(b);
            let m = f64::from(b.mass.mass);
            let local = f.rotation.as_dquat().normalize().inverse_rotate(w.as_dvec3());
            e.kinetic +=
                0.5 * m * v.as_dvec3().length_squared() + 0.5 * local.dot(b.mass.inertia.as_dmat3() * local);
            e.potential -= m * f64::from(b.gravity_scale) * self.gravity.as_dvec3().dot(f.center);
        }
        e.potential += self.field_energy();
        e
    }
    /// Momentum of the dynamic bodies.
    pub fn momentum(&self) -> Momentum {
        let mut p = Momentum::default();
        for (i, b) in self.bodies.iter().filter(|(_, b)| b.enabled && b.mass.inv_mass > 0.0) {
            let f = &self.frames[i as usize];
            let (v, w) = self.velocities(b);
            let mv = v.as_dvec3() * f64::from(b.mass.mass);
            let q = f.rotation.as_dquat().normalize();
            let spin = q.rotate(b.mass.inertia.as_dmat3() * q.inverse_rotate(w.as_dvec3()));
            p.linear += mv;
            p.angular += f.center.cross(mv) + spin;
        }
        for (_, v) in self.vehicles.table.iter() {
            let f = &self.frames[v.chassis as usize];
            v.add_momentum(f, &mut p);
        }
        p
    }

    pub(crate) fn body_id(&self, index: u32) -> BodyId {
        BodyId { index, generation: self.bodies.generation(index) }
    }
    pub(crate) fn shape_id(&self, index: u32) -> ShapeId {
        ShapeId { index, generation: self.shapes.generation(index) }
    }
    /// Slot of a live handle.
    pub(crate) fn slot(&self, id: BodyId) -> Result<u32> {
        if self.bodies.is_live(id.index, id.generation) {
            return Ok(id.index);
        }
        Err(Error::Stale { what: "body", index: id.index, generation: id.generation })
    }
    pub(crate) fn shape_slot(&self, id: ShapeId) -> Result<u32> {
        if self.shapes.is_live(id.index, id.generation) {
            return Ok(id.index);
        }
        Err(Error::Stale { what: "shape", index: id.index, generation: id.generation })
    }
    pub(crate) fn velocities(&self, b: &Body) -> (Vec3, Vec3) {
        if b.row == NONE {
            return (b.velocity, b.angular_velocity);
        }
        let s = &self.awake.state[b.row as usize];
        (s.v(), s.w())
    }
}

/// Thin sugar over [`World::apply`].
impl World {
    /// Adds a body with its shapes.
    ///
    /// A dynamic body without mass (no shapes yet, or only shapes of density 0, or sensors; no mass of its own) is accepted: it
    /// keeps its velocity, and neither gravity nor forces nor contacts change it, until it is given mass. Scene files refuse it.
    ///
    /// # Errors
    /// A description out of range, named; nothing is added then.
    pub fn add_body(&mut self, desc: BodyDesc) -> Result<BodyId> {
        match self.apply(Command::AddBody(Box::new(desc)))? {
            Output::Body(id) => Ok(id),
            _ => Err(Error::Unsupported { what: "add_body", advice: "expected a body" }),
        }
    }
    /// Adds a shape to a body.
    ///
    /// # Errors
    /// A stale handle or a description out of range.
    pub fn add_shape(&mut self, body: BodyId, desc: ShapeDesc) -> Result<ShapeId> {
        match self.apply(Command::AddShape(body, Box::new(desc)))? {
            Output::Shape(id) => Ok(id),
            _ => Err(Error::Unsupported { what: "add_shape", advice: "expected a shape" }),
        }
    }
    /// Adds a field.
    ///
    /// # Errors
    /// A description out of range, a stale body, a hook that is not registered, or too many fields.
    pub fn add_field(&mut self, desc: FieldDesc) -> Result<FieldId> {
        match self.apply(Command::AddField(Box::new(desc)))? {
            Output::Field(id) => Ok(id),
            _ => Err(Error::Unsupported { what: "add_field", advice: "expected a field" }),
        }
    }
    /// Adds a joint.
    ///
    /// # Errors
    /// A stale handle or a description out of range, named.
    pub fn add_joint(&mut self, desc: JointDesc) -> Result<JointId> {
        match self.apply(Command::AddJoint(Box::new(desc)))? {
            Output::Joint(id) => Ok(id),
            _ => Err(Error::Unsupported { what: "add_joint", advice: "expected a joint" }),
        }
    }
    /// Adds a vehicle to a dynamic body. [`crate::vehicles`] has presets.
    ///
    /// # Errors
    /// A stale handle, a description out of range, named, or a body that cannot be a chassis.
    pub fn add_vehicle(&mut self, desc: VehicleDesc) -> Result<VehicleId> {
        match self.apply(Command::AddVehicle(Box::new(desc)))? {
            Output::Vehicle(id) => Ok(id),
            _ => Err(Error::Unsupported { what: "add_vehicle", advice: "expected a vehicle" }),
        }
    }
    /// Adds a character with its body.
    ///
    /// ```
    /// use jounce::{CharacterDesc, CharacterInput, prelude::*};
    ///
    /// # fn main() -> jounce::Result<()> {
    /// let mut world = World::new(WorldDesc::default())?;
    /// world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    /// let hero = world.add_character(CharacterDesc::at([0.0, 0.0, 0.0]))?;
    /// world.set_character_input(hero, CharacterInput::walk([3.0, 0.0, 0.0]))?;
    /// for _ in 0..60 {
    ///     world.step()?;
    /// }
    /// assert!(world.character(hero)?.is_grounded() && world.character(hero)?.position().x > 2.5);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// A description out of range, named.
    pub fn add_character(&mut self, desc: CharacterDesc) -> Result<CharacterId> {
        match self.apply(Command::AddCharacter(Box::new(desc)))? {
            Output::Character(id) => Ok(id),
            _ => Err(Error::Unsupported { what: "add_character", advice: "expected a character" }),
        }
    }
    /// Adds an emitter of particles.
    ///
    /// # Errors
    /// A stale handle or a description out of range, named.
    pub fn add_emitter(&mut self, desc: EmitterDesc) -> Result<EmitterId> {
        match self.apply(Command::AddEmitter(Box::new(desc)))? {
            Output::Emitter(id) => Ok(id),
            _ => Err(Error::Unsupported { what: "add_emitter", advice: "expected an emitter" }),
        }
    }
}

use crate::room::contacts::desc::{Filter, Material, ShapeDesc};
use crate::room::fields::desc::{Aero, Explosion, FieldDesc};
use crate::room::joints::desc::{JointDesc, JointKind};
use crate::room::particles::desc::{EmitterDesc, ParticleSpawn};
use crate::room::rigid::desc::{AxisLocks, BodyDesc, BodyKind};
use crate::room::vehicles::desc::{VehicleDesc, VehicleInput};
use jounce_geometry::{MassProperties, Shape};

macro_rules! sugar {
    ($($(#[$doc:meta])* $name:ident($($arg:ident: $t:ty),*) => $command:expr;)*) => {
        impl World {
            $(
                $(#[$doc])*
                ///
                /// # Errors
                /// A stale handle, or a value out of range, named; nothing is changed then.
                pub fn $name(&mut self, $($arg: $t),*) -> Result<()> {
                    self.apply($command).map(|_| ())
                }
            )*
        }
    };
}

sugar! {
    /// Removes a body with its shapes and contacts.
    remove_body(body: BodyId) => Command::RemoveBody(body);
    /// Removes a shape.
    remove_shape(shape: ShapeId) => Command::RemoveShape(shape);
    /// Puts a body somewhere at once (no interpolation in between).
    teleport(body: BodyId, position: DVec3, rotation: Quat) => Command::Teleport(body, position, rotation);
    /// Kinematic bodies: moves to a pose within the next step, however far it is, pushing what is in the way: at no more than the
    /// speed limits of the settings, which is also the velocity that is then told of the body.
    move_to(body: BodyId, position: DVec3, rotation: Quat) => Command::MoveTo(body, position, rotation);
    /// Sets the velocity of the centre of mass, m/s.
    set_velocity(body: BodyId, velocity: Vec3) => Command::SetVelocity(body, velocity);
    /// Sets the angular velocity, rad/s, world axes.
    set_angular_velocity(body: BodyId, w: Vec3) => Command::SetAngularVelocity(body, w);
    /// Adds a force, N, for the next step only: accumulators are cleared by every step. At a world point, or
    /// (`None`) through the centre of mass.
    add_force(body: BodyId, force: Vec3, at: Option<DVec3>) => Command::AddForce(body, force, at);
    /// Adds a torque, N m, for the next step only.
    add_torque(body: BodyId, torque: Vec3) => Command::AddTorque(body, torque);
    /// Changes the momentum at once, N s; at a world point, or (`None`) through the centre of mass.
    add_impulse(body: BodyId, impulse: Vec3, at: Option<DVec3>) => Command::AddImpulse(body, impulse, at);
    /// Changes the angular momentum at once, N m s.
    add_angular_impulse(body: BodyId, impulse: Vec3) => Command::AddAngularImpulse(body, impulse);
    /// Changes how a body moves.
    set_kind(body: BodyId, kind: BodyKind) => Command::SetKind(body, kind);
    /// Takes a body out of the simulation, or back in.
    set_body_enabled(body: BodyId, enabled: bool) => Command::SetBodyEnabled(body, enabled);
    /// Sets linear and angular damping, 1/s.
    set_damping(body: BodyId, linear: f32, angular: f32) => Command::SetDamping(body, linear, angular);
    /// Sets the factor on gravity.
    set_gravity_scale(body: BodyId, scale: f32) => Command::SetGravityScale(body, scale);
    /// Sets locked axes.
    set_locks(body: BodyId, locks: AxisLocks) => Command::SetLocks(body, locks);
    /// Overrides the mass, or (`None`) goes back to the sum over the shapes.
    set_mass(body: BodyId, mass: Option<MassProperties>) => Command::SetMass(body, mass);
    /// Continuous collision against moving bodies too.
    set_bullet(body: BodyId, bullet: bool) => Command::SetBullet(body, bullet);
    /// May the body sleep?
    set_can_sleep(body: BodyId, can_sleep: bool) => Command::SetCanSleep(body, can_sleep);
    /// Sets the caller's number.
    set_user_data(body: BodyId, user_data: u128) => Command::SetUserData(body, user_data);
    /// Sets the name.
    set_name(body: BodyId, name: Option<String>) => Command::SetName(body, name);
    /// Wakes a body and what sleeps with it.
    wake(body: BodyId) => Command::Wake(body);
    /// Puts a body, and all that rests with it, to sleep.
    sleep(body: BodyId) => Command::Sleep(body);
    /// Swaps the geometry of a shape.
    set_shape(shape: ShapeId, geometry: Shape) => Command::SetShape(shape, Box::new(geometry));
    /// Moves a shape on its body.
    set_shape_pose(shape: ShapeId, pose: jounce_math::Pose) => Command::SetShapePose(shape, pose);
    /// Takes a shape out of the simulation, or back in.
    set_shape_enabled(shape: ShapeId, enabled: bool) => Command::SetShapeEnabled(shape, enabled);
    /// Sets a shape's surface.
    set_material(shape: ShapeId, material: Material) => Command::SetMaterial(shape, material);
    /// Sets whom a shape meets.
    set_filter(shape: ShapeId, filter: Filter) => Command::SetFilter(shape, filter);
    /// Sets how a shape meets the medium around it.
    set_aero(shape: ShapeId, aero: Aero) => Command::SetAero(shape, aero);
    /// Removes a field.
    remove_field(field: FieldId) => Command::RemoveField(field);
    /// Replaces a field's description.
    set_field(field: FieldId, desc: FieldDesc) => Command::SetField(field, Box::new(desc));
    /// Lets off a blast: one impulse on everything near.
    explode(explosion: Explosion) => Command::Explode(explosion);
    /// Removes an emitter with its particles.
    remove_emitter(emitter: EmitterId) => Command::RemoveEmitter(emitter);
    /// Replaces an emitter's description; its particles stay, and its clock goes on.
    set_emitter(emitter: EmitterId, desc: EmitterDesc) => Command::SetEmitter(emitter, Box::new(desc));
    /// Stops an emitter's births and its clock, or lets them go on.
    set_emitter_enabled(emitter: EmitterId, enabled: bool) => Command::SetEmitterEnabled(emitter, enabled);
    /// So many births at once.
    emit_burst(emitter: EmitterId, count: u32) => Command::EmitBurst(emitter, count);
    /// Adds particles as given.
    emit_particles(emitter: EmitterId, spawns: Vec<ParticleSpawn>) => Command::EmitParticles(emitter, spawns);
    /// Removes all particles of an emitter, or (`None`) of all.
    clear_particles(emitter: Option<EmitterId>) => Command::ClearParticles(emitter);
    /// Removes a joint, and the gears on it.
    remove_joint(joint: JointId) => Command::RemoveJoint(joint);
    /// Replaces a joint's kind by another of the same name: other ends, motors, springs.
    set_joint(joint: JointId, kind: JointKind) => Command::SetJoint(joint, Box::new(kind));
    /// Takes a joint out of the simulation, or back in (a broken one too).
    set_joint_enabled(joint: JointId, enabled: bool) => Command::SetJointEnabled(joint, enabled);
    /// Removes a vehicle; its chassis stays, as a body.
    remove_vehicle(vehicle: VehicleId) => Command::RemoveVehicle(vehicle);
    /// Replaces a vehicle's description by another with as many wheels.
    set_vehicle(vehicle: VehicleId, desc: VehicleDesc) => Command::SetVehicle(vehicle, Box::new(desc));
    /// What the driver does from now on.
    set_vehicle_input(vehicle: VehicleId, input: VehicleInput) => Command::SetVehicleInput(vehicle, input);
    /// Takes a vehicle out of the simulation, or back in; its wheels start anew.
    set_vehicle_enabled(vehicle: VehicleId, enabled: bool) => Command::SetVehicleEnabled(vehicle, enabled);
    /// Removes a character with its body.
    remove_character(character: CharacterId) => Command::RemoveCharacter(character);
    /// What a character is asked to do from the next step on.
    set_character_input(character: CharacterId, input: CharacterInput) => Command::SetCharacterInput(character, input);
    /// Replaces a character's description, but for its kind, place, heading, name and number.
    set_character(character: CharacterId, desc: CharacterDesc) => Command::SetCharacter(character, Box::new(desc));
    /// Sets the world's gravity, m/s².
    set_gravity(gravity: Vec3) => Command::SetGravity(gravity);
    /// Sets the solver's constants.
    set_settings(settings: Settings) => Command::SetSettings(Box::new(settings));
}

#[cfg(test)]
mod tests {
    use crate::room::contacts::rows::{Block, LANES};
    use crate::room::contacts::state::{Contact, PairHead, ShapeRecord};
    use crate::room::rigid::free::Top;
    use crate::room::rigid::pass::{Drive, Pushed, Way};
    use crate::room::rigid::state::{Body, BodyFrame, BodyState, BodyStep, InvInertia, Turning};
    use core::mem::size_of;
    use jounce_geometry::Aabb;

    /// What docs/performance.md says of memory.
    #[test]
    fn records_are_as_large_as_documented() {
        let cold = size_of::<Body>();
        let frame = size_of::<BodyFrame>() + 2 * size_of::<f64>() + 2 * size_of::<u32>();
        let awake = size_of::<BodyState>()
            + size_of::<BodyStep>()
            + size_of::<Option<Turning>>()
            + size_of::<InvInertia>();
        let scratch = size_of::<Pushed>() + size_of::<Drive>() + size_of::<Way>() + size_of::<Top>() + 4;
        let shape = size_of::<ShapeRecord>();
        let bounds = 2 * size_of::<Aabb>();
        let contact = size_of::<Contact>() + size_of::<PairHead>();
        let row = size_of::<Block>().div_ceil(LANES);
        let sizes = [cold, frame, awake, scratch, shape, bounds, contact, row];
        assert_eq!(sizes, [432, 128, 440, 172, 256, 48, 624, 368]);
    }
}
