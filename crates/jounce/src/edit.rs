//! The one path of edits: [`World::apply`].
//!
//! Every arm checks first and changes after, so a refused command changes nothing.

use crate::command::{Command, Output};
use crate::error::{Error, Result, check};
use crate::event::Event;
use crate::handle::{BodyId, ShapeId};
use crate::limits;
use crate::room::contacts::desc::{Filter, Material, ShapeDesc};
use crate::room::contacts::state::{Place, ShapeRecord};
use crate::room::particles::blast::push_by_explosion;
use crate::room::rigid::desc::{self, AxisLocks, BodyDesc, BodyKind};
use crate::room::rigid::mass;
use crate::room::rigid::state::{Body, BodyFrame, BodyState, BodyStep, InvInertia, Mass, NONE, lock_bits};
use crate::stage::broadphase::{NEVER, Tag};
use crate::stage::publish::moved;
use crate::world::World;
use jounce_geometry::{Aabb, MassProperties, Shape};
use jounce_math::{DVec3, Pose, Quat, Vec3, WorldPose, scalar::f32s};
use jounce_tasks::{ColorSets, FloatEnv};

impl World {
    /// Carries out one edit, at once. The methods of [`World`] are thin sugar over this.
    ///
    /// # Errors
    /// A stale handle or a value out of range, named. Nothing is changed then.
    pub fn apply(&mut self, command: Command) -> Result<Output> {
        use Command as C;
        let _mode = FloatEnv::set_default();
        match command {
            C::AddBody(d) => return self.do_add_body(*d).map(Output::Body),
            C::AddShape(b, d) => return self.do_add_shape(b, *d).map(Output::Shape),
            C::RemoveBody(b) => self.do_remove_body(b)?,
            C::RemoveShape(s) => self.do_remove_shape(s)?,
            C::Teleport(b, p, q) => self.do_teleport(b, p, q)?,
            C::MoveTo(b, p, q) => self.do_move_to(b, p, q)?,
            C::SetVelocity(b, v) => self.do_set_velocity(b, Some(v), None)?,
            C::SetAngularVelocity(b, w) => self.do_set_velocity(b, None, Some(w))?,
            C::AddForce(b, f, at) => self.do_force(b, f, Vec3::ZERO, at)?,
            C::AddTorque(b, t) => self.do_force(b, Vec3::ZERO, t, None)?,
            C::AddImpulse(b, j, at) => self.do_impulse(b, j, Vec3::ZERO, at)?,
            C::AddAngularImpulse(b, j) => self.do_impulse(b, Vec3::ZERO, j, None)?,
            C::SetKind(b, k) => self.do_set_kind(b, k)?,
            C::SetBodyEnabled(b, on) => {
                let slot = self.slot(b)?;
                self.enable_body(slot, on);
            }
            C::SetDamping(b, l, a) => self.do_set_damping(b, l, a)?,
            C::SetGravityScale(b, s) => {
                desc::check_gravity_scale(s)?;
                self.edit_body(b, true, |body| body.gravity_scale = s)?;
            }
            C::SetLocks(b, l) => self.do_set_locks(b, l)?,
            C::SetMass(b, m) => self.do_set_mass(b, m)?,
            C::SetBullet(b, on) => {
                self.edit_body(b, false, |body| body.bullet = on)?;
                self.forget_tests(b.index);
            }
            C::SetCanSleep(b, on) => self.edit_body(b, !on, |body| body.can_sleep = on)?,
            C::SetUserData(b, u) => self.edit_body(b, false, |body| body.user_data = u)?,
            C::SetName(b, n) => {
                let len = n.as_ref().map_or(0, String::len);
                check(len <= limits::NAME_MAX, "body", "name", len, "at most 256 bytes")?;
                self.edit_body(b, false, |body| body.name = n)?;
            }
            C::Wake(b) => {
                let slot = self.slot(b)?;
                self.wake_body(slot);
            }
            C::Sleep(b) => self.do_sleep(b)?,
            C::SetShape(s, g) => self.do_set_shape(s, *g)?,
            C::SetShapePose(s, p) => self.do_set_shape_pose(s, p)?,
            C::SetShapeEnabled(s, on) => self.do_enable_shape(s, on)?,
            C::SetMaterial(s, m) => self.do_set_material(s, m)?,
            C::SetFilter(s, f) => self.do_set_filter(s, f)?,
            C::SetAero(s, a) => {
                let slot = self.shape_slot(s)?;
                a.check()?;
                self.shapes[slot].aero = a;
                self.wake_body(self.shapes[slot].body);
            }
            C::AddField(d) => return self.do_add_field(*d).map(Output::Field),
            C::RemoveField(f) => self.do_remove_field(f)?,
            C::SetField(f, d) => self.do_set_field(f, *d)?,
            C::Explode(e) => {
                self.do_explode(&e)?;
                push_by_explosion(self, &e);
            }
            C::AddEmitter(d) => return self.do_add_emitter(*d).map(Output::Emitter),
            C::RemoveEmitter(e) => self.do_remove_emitter(e)?,
            C::SetEmitter(e, d) => self.do_set_emitter(e, *d)?,
            C::SetEmitterEnabled(e, on) => self.do_enable_emitter(e, on)?,
            C::EmitBurst(e, n) => self.do_emit_burst(e, n)?,
            C::EmitParticles(e, spawns) => self.do_emit_particles(e, &spawns)?,
            C::ClearParticles(e) => self.do_clear_particles(e)?,
            C::AddJoint(d) => return self.do_add_joint(*d).map(Output::Joint),
            C::RemoveJoint(j) => self.do_remove_joint(j)?,
            C::SetJoint(j, k) => self.do_set_joint(j, *k)?,
            C::SetJointEnabled(j, on) => self.do_enable_joint(j, on)?,
            C::AddVehicle(d) => return self.do_add_vehicle(*d).map(Output::Vehicle),
            C::RemoveVehicle(v) => self.do_remove_vehicle(v)?,
            C::SetVehicle(v, d) => self.do_set_vehicle(v, *d)?,
            C::SetVehicleInput(v, i) => self.do_set_vehicle_input(v, i)?,
            C::SetVehicleEnabled(v, on) => self.do_enable_vehicle(v, on)?,
            C::AddCharacter(d) => return self.do_add_character(*d).map(Output::Character),
            C::RemoveCharacter(c) => self.do_remove_character(c)?,
            C::SetCharacterInput(c, input) => self.do_set_character_input(c, input)?,
            C::SetCharacter(c, d) => self.do_set_character(c, *d)?,
            C::SetGravity(g) => self.do_set_gravity(g)?,
            C::SetSettings(s) => {
                s.check()?;
                self.settings = *s;
                self.wake_all();
                // How far ahead they look may be another now.
                self.contacts.iter_mut().for_each(|c| c.tested = false);
                self.heads.iter_mut().for_each(|h| h.until = f64::NEG_INFINITY);
            }
        }
        Ok(Output::Done)
    }

    pub(crate) fn do_add_body(&mut self, d: BodyDesc) -> Result<BodyId> {
        d.check()?;
        let limit = |what, limit| Err(Error::Limit { what, limit });
        if self.bodies.len() >= limits::BODIES_MAX {
            return limit("bodies", limits::BODIES_MAX);
        }
        if self.shapes.len() + d.shapes.len() > limits::SHAPES_MAX {
            return limit("shapes", limits::SHAPES_MAX);
        }
        let body = Body {
            kind: d.kind,
            enabled: false,
            bullet: d.bullet,
            fast_rotation: d.fast_rotation,
            can_sleep: d.can_sleep,
            locks: d.locks,
            linear_damping: d.linear_damping,
            angular_damping: d.angular_damping,
            gravity_scale: d.gravity_scale,
            sleep_speed: d.sleep_speed,
            user_data: d.user_data,
            name: d.name,
            mass_override: d.mass,
            shapes: Vec::new(),
            contacts: Vec::new(),
            joints: Vec::new(),
            vehicle: NONE,
            row: NONE,
            island: NONE,
            velocity: if d.kind == BodyKind::Fixed { Vec3::ZERO } else { d.velocity },
            angular_velocity: if d.kind == BodyKind::Fixed { Vec3::ZERO } else { d.angular_velocity },
            mass: Mass::default(),
        };
        let (slot, generation) = self.bodies.insert(body);
        if self.frames.len() <= slot as usize {
            self.frames.resize(slot as usize + 1, BodyFrame::default());
            self.travel.resize(slot as usize + 1, [0.0; 2]);
            self.row_of.resize(slot as usize + 1, NONE);
            self.items.resize(slot as usize + 1, ColorSets::NONE);
        }
        let mut frame = BodyFrame { row: NONE, ..BodyFrame::default() };
        frame.place(d.position, d.rotation.normalize());
        self.frames[slot as usize] = frame;
        for s in d.shapes {
            self.attach(slot, s);
        }
        self.update_mass(slot);
        self.frames[slot as usize].reset_interpolation();
        if d.enabled {
            self.enable_body(slot, true);
            if d.asleep && d.kind != BodyKind::Fixed && d.can_sleep {
                self.sleep_bodies(vec![slot]);
            }
        }
        Ok(BodyId { index: slot, generation })
    }

    /// Adds a shape's record to a body; bounds and mass follow separately.
    fn attach(&mut self, body: u32, d: ShapeDesc) -> u32 {
        let mut pose = d.pose;
        pose.q = pose.q.normalize();
        let (middle, reach) = middle(&d.shape);
        let (slot, _) = self.shapes.insert(ShapeRecord {
            body,
            thickness: thickness(&d.shape),
            middle,
            reach,
            volume: d.shape.volume() as f32,
            ball_radius: d.shape.equal_volume_radius(),
            aero: d.aero,
            shape: d.shape,
            pose,
            mass: d.mass,
            material: d.material,
            triangle_materials: d.triangle_materials,
            filter: d.filter,
            sensor: d.sensor,
            enabled: d.enabled,
            contact_events: d.contact_events,
            hit_events: d.hit_events,
            user_data: d.user_data,
            place: Place::Nowhere,
            visitors: Vec::new(),
        });
        let slots = self.fat.len().max(slot as usize + 1);
        self.fat.resize(slots, Aabb::EMPTY);
        self.fat_before.resize(slots, NEVER);
        self.tags.resize(slots, Tag::default());
        self.fat[slot as usize] = Aabb::EMPTY;
        self.bouncy += usize::from(is_bouncy(&self.shapes[slot]));
        self.running += usize::from(runs(&self.shapes[slot]));
        self.telling += usize::from(self.shapes[slot].hit_events);
        self.bodies[body].shapes.push(slot);
        if d.sensor {
            let at = self.sensors.partition_point(|&s| s < slot);
            self.sensors.insert(at, slot);
        }
        slot
    }

    fn do_add_shape(&mut self, b: BodyId, d: ShapeDesc) -> Result<ShapeId> {
        let slot = self.slot(b)?;
        d.check_on(self.bodies[slot].kind)?;
        if self.shapes.len() >= limits::SHAPES_MAX {
            return Err(Error::Limit { what: "shapes", limit: limits::SHAPES_MAX });
        }
        if self.bodies[slot].shapes.len() >= limits::SHAPES_PER_BODY_MAX {
            return Err(Error::Limit { what: "shapes of a body", limit: limits::SHAPES_PER_BODY_MAX });
        }
        self.wake_body(slot);
        let s = self.attach(slot, d);
        self.update_mass(slot);
        self.place_shape(s);
        Ok(self.shape_id(s))
    }

    pub(crate) fn do_remove_body(&mut self, b: BodyId) -> Result<()> {
        let slot = self.slot(b)?;
        self.enable_body(slot, false);
        for j in self.bodies[slot].joints.clone() {
            self.drop_joint(j);
        }
        self.drop_vehicle(self.bodies[slot].vehicle);
        for s in self.bodies[slot].shapes.clone() {
            self.drop_shape(s);
        }
        self.bodies.remove(slot);
        self.drop_character_of(slot);
        Ok(())
    }

    fn do_remove_shape(&mut self, s: ShapeId) -> Result<()> {
        let slot = self.shape_slot(s)?;
        let body = self.shapes[slot].body;
        self.wake_neighbours(body);
        self.unplace_shape(slot);
        self.bodies[body].shapes.retain(|&x| x != slot);
        self.drop_shape(slot);
        self.update_mass(body);
        Ok(())
    }

    fn drop_shape(&mut self, slot: u32) {
        self.bouncy -= usize::from(is_bouncy(&self.shapes[slot]));
        self.running -= usize::from(runs(&self.shapes[slot]));
        self.telling -= usize::from(self.shapes[slot].hit_events);
        if self.shapes[slot].sensor {
            self.sensors.retain(|&x| x != slot);
        }
        self.shapes.remove(slot);
    }

    pub(crate) fn do_teleport(&mut self, b: BodyId, p: DVec3, q: Quat) -> Result<()> {
        let slot = self.slot(b)?;
        desc::check_position(p)?;
        desc::check_rotation(q)?;
        self.wake_neighbours(slot);
        self.frames[slot as usize].place(p, q.normalize());
        self.refresh_inertia(slot);
        self.refresh_bounds(slot);
        Ok(())
    }

    pub(crate) fn do_move_to(&mut self, b: BodyId, p: DVec3, q: Quat) -> Result<()> {
        let slot = self.slot(b)?;
        desc::check_position(p)?;
        desc::check_rotation(q)?;
        if self.bodies[slot].kind != BodyKind::Kinematic {
            return Err(Error::Unsupported {
                what: "move_to on a body that is not kinematic",
                advice: "use teleport, or make the body kinematic",
            });
        }
        let target = WorldPose::new(p, q.normalize());
        if self.frames[slot as usize].pose() == target && self.bodies[slot].row == NONE {
            return Ok(());
        }
        self.wake_mover(slot);
        if let Some(step) = self.step_mut(slot) {
            step.target = Some(target);
        }
        Ok(())
    }

    /// Wakes a body that is about to move; a kinematic one, which no contact stops, with all that touch it.
    fn wake_mover(&mut self, slot: u32) {
        if self.bodies[slot].kind == BodyKind::Kinematic {
            self.wake_neighbours(slot);
        } else {
            self.wake_body(slot);
        }
    }

    pub(crate) fn do_set_velocity(&mut self, b: BodyId, v: Option<Vec3>, w: Option<Vec3>) -> Result<()> {
        let slot = self.slot(b)?;
        v.map_or(Ok(()), desc::check_velocity)?;
        w.map_or(Ok(()), desc::check_spin)?;
        if self.bodies[slot].kind == BodyKind::Fixed {
            return Err(Error::Unsupported {
                what: "a velocity on a fixed body",
                advice: "make it kinematic, or give its material a surface_velocity",
            });
        }
        let zero = v.unwrap_or(Vec3::ZERO) == Vec3::ZERO && w.unwrap_or(Vec3::ZERO) == Vec3::ZERO;
        if !zero {
            self.wake_mover(slot);
        }
        let body = &mut self.bodies[slot];
        if body.row == NONE {
            body.velocity = v.unwrap_or(body.velocity);
            body.angular_velocity = w.unwrap_or(body.angular_velocity);
            return Ok(());
        }
        let state = &mut self.awake.state[body.row as usize];
        state.set_velocity(v.unwrap_or(state.v()), w.unwrap_or(state.w()));
        Ok(())
    }

    /// Lever of a world point about the centre of mass.
    fn lever(&self, slot: u32, at: Option<DVec3>) -> Result<Vec3> {
        let Some(p) = at else { return Ok(Vec3::ZERO) };
        desc::check_position(p)?;
        Ok((p - self.frames[slot as usize].center).as_vec3())
    }

    pub(crate) fn do_force(&mut self, b: BodyId, f: Vec3, t: Vec3, at: Option<DVec3>) -> Result<()> {
        let slot = self.slot(b)?;
        check_force("force", f)?;
        check_force("torque", t)?;
        let torque = t + self.lever(slot, at)?.cross(f);
        check_force("torque of the force", torque)?;
        if self.bodies[slot].kind != BodyKind::Dynamic || (f == Vec3::ZERO && torque == Vec3::ZERO) {
            return Ok(());
        }
        self.wake_body(slot);
        if let Some(step) = self.step_mut(slot) {
            step.force += f;
            step.torque += torque;
        }
        Ok(())
    }

    pub(crate) fn do_impulse(&mut self, b: BodyId, j: Vec3, l: Vec3, at: Option<DVec3>) -> Result<()> {
        let slot = self.slot(b)?;
        check_force("impulse", j)?;
        check_force("angular impulse", l)?;
        let l = l + self.lever(slot, at)?.cross(j);
        check_force("moment of the impulse", l)?;
        let body = &self.bodies[slot];
        if body.kind != BodyKind::Dynamic || (j == Vec3::ZERO && l == Vec3::ZERO) {
            return Ok(());
        }
        let m = body.mass;
        let q = self.frames[slot as usize].rotation;
        let tensor = InvInertia::new(q, &m.inv_inertia, m.inv_mass, lock_bits(&body.locks));
        let (v, w) = self.velocities(body);
        let (v, w) = (v + j * m.inv_mass, w + tensor.mul(l));
        desc::check_velocity(v)?;
        desc::check_spin(w)?;
        self.do_set_velocity(b, Some(v), Some(w))
    }

    fn do_set_kind(&mut self, b: BodyId, kind: BodyKind) -> Result<()> {
        let slot = self.slot(b)?;
        for &s in &self.bodies[slot].shapes {
            let r = &self.shapes[s];
            let probe = ShapeDesc { sensor: r.sensor, ..ShapeDesc::new(r.shape.clone()) };
            probe.check_on(kind)?;
        }
        if self.bodies[slot].kind == kind {
            return Ok(());
        }
        let enabled = self.bodies[slot].enabled;
        self.enable_body(slot, false);
        self.bodies[slot].kind = kind;
        if kind == BodyKind::Fixed {
            (self.bodies[slot].velocity, self.bodies[slot].angular_velocity) = (Vec3::ZERO, Vec3::ZERO);
        }
        self.update_mass(slot);
        if enabled {
            self.enable_body(slot, true);
        }
        Ok(())
    }

    fn do_set_damping(&mut self, b: BodyId, linear: f32, angular: f32) -> Result<()> {
        desc::check_damping("linear_damping", linear)?;
        desc::check_damping("angular_damping", angular)?;
        self.edit_body(b, false, |body| (body.linear_damping, body.angular_damping) = (linear, angular))
    }

    fn do_set_locks(&mut self, b: BodyId, locks: AxisLocks) -> Result<()> {
        self.edit_body(b, true, |body| body.locks = locks)?;
        self.refresh_inertia(b.index);
        Ok(())
    }

    fn do_set_mass(&mut self, b: BodyId, m: Option<MassProperties>) -> Result<()> {
        if let Some(m) = &m {
            desc::check_mass(m)?;
        }
        self.edit_body(b, true, |body| body.mass_override = m)?;
        self.update_mass(b.index);
        Ok(())
    }

    fn do_sleep(&mut self, b: BodyId) -> Result<()> {
        let slot = self.slot(b)?;
        if self.bodies[slot].row == NONE {
            return Ok(());
        }
        let island = self.touching_group(slot);
        self.sleep_bodies(island);
        Ok(())
    }

    pub(crate) fn do_set_shape(&mut self, s: ShapeId, g: Shape) -> Result<()> {
        let slot = self.shape_slot(s)?;
        let body = self.shapes[slot].body;
        let probe = ShapeDesc { sensor: self.shapes[slot].sensor, ..ShapeDesc::new(g) };
        probe.check_on(self.bodies[body].kind)?;
        self.wake_neighbours(body);
        self.unplace_shape(slot);
        let r = &mut self.shapes[slot];
        r.thickness = thickness(&probe.shape);
        (r.middle, r.reach) = middle(&probe.shape);
        (r.volume, r.ball_radius) = (probe.shape.volume() as f32, probe.shape.equal_volume_radius());
        r.shape = probe.shape;
        self.update_mass(body);
        self.place_shape(slot);
        Ok(())
    }

    pub(crate) fn do_set_shape_pose(&mut self, s: ShapeId, p: Pose) -> Result<()> {
        let slot = self.shape_slot(s)?;
        let probe = ShapeDesc { pose: p, ..ShapeDesc::new(self.shapes[slot].shape.clone()) };
        probe.check()?;
        let body = self.shapes[slot].body;
        self.wake_neighbours(body);
        self.unplace_shape(slot);
        self.shapes[slot].pose = Pose::new(p.p, p.q.normalize());
        self.update_mass(body);
        self.place_shape(slot);
        Ok(())
    }

    fn do_enable_shape(&mut self, s: ShapeId, on: bool) -> Result<()> {
        let slot = self.shape_slot(s)?;
        if self.shapes[slot].enabled == on {
            return Ok(());
        }
        self.wake_neighbours(self.shapes[slot].body);
        self.shapes[slot].enabled = on;
        if on {
            self.place_shape(slot);
        } else {
            self.unplace_shape(slot);
        }
        Ok(())
    }

    fn do_set_material(&mut self, s: ShapeId, m: Material) -> Result<()> {
        let slot = self.shape_slot(s)?;
        m.check()?;
        let before = [is_bouncy(&self.shapes[slot]), runs(&self.shapes[slot])].map(usize::from);
        self.shapes[slot].material = m;
        let now = [is_bouncy(&self.shapes[slot]), runs(&self.shapes[slot])].map(usize::from);
        self.bouncy = self.bouncy + now[0] - before[0];
        self.running = self.running + now[1] - before[1];
        self.wake_neighbours(self.shapes[slot].body);
        self.forget_tests(self.shapes[slot].body);
        Ok(())
    }

    pub(crate) fn do_set_filter(&mut self, s: ShapeId, f: Filter) -> Result<()> {
        let slot = self.shape_slot(s)?;
        self.wake_neighbours(self.shapes[slot].body);
        self.unplace_shape(slot);
        self.shapes[slot].filter = f;
        self.place_shape(slot);
        Ok(())
    }

    fn do_set_gravity(&mut self, g: Vec3) -> Result<()> {
        let ok = g.is_finite() && g.abs().max_component() <= 1e6;
        check(ok, "world", "gravity", g, "finite, at most 1e6 m/s²")?;
        self.gravity = g;
        self.wake_all();
        Ok(())
    }

    /// Edits the cold record and keeps the awake row in step with it.
    fn edit_body(&mut self, b: BodyId, wake: bool, f: impl FnOnce(&mut Body)) -> Result<()> {
        let slot = self.slot(b)?;
        if wake {
            self.wake_body(slot);
        }
        f(&mut self.bodies[slot]);
        self.refresh_row(slot);
        Ok(())
    }
}

fn is_bouncy(s: &ShapeRecord) -> bool {
    s.material.restitution > 0.0 || s.triangle_materials.iter().any(|m| m.restitution > 0.0)
}

/// Has it a surface that runs?
fn runs(s: &ShapeRecord) -> bool {
    core::iter::once(&s.material).chain(&s.triangle_materials).any(|m| m.surface_velocity != Vec3::ZERO)
}

fn check_force(field: &'static str, f: Vec3) -> Result<()> {
    let ok = f.is_finite() && f.abs().max_component() <= limits::FORCE_MAX;
    check(ok, "body", field, f, "finite, at most 1e25")
}

/// Smallest thickness of a shape: twice the inner radius, or unlimited for surfaces.
fn thickness(s: &Shape) -> f32 {
    let r = s.inner_radius();
    if r > 0.0 { 2.0 * r } else { f32::MAX }
}

/// The middle of a shape's bounds and how far it reaches from there; of one without bounds, its origin.
fn middle(s: &Shape) -> (Vec3, f32) {
    let b = s.aabb(&Pose::IDENTITY);
    let c = b.center();
    let c = if b.min.is_finite() && b.max.is_finite() && c.is_finite() { c } else { Vec3::ZERO };
    (c, s.outer_radius(c))
}

/// Rows and bounds.
impl World {
    pub(crate) fn step_mut(&mut self, slot: u32) -> Option<&mut BodyStep> {
        let row = self.bodies.get(slot)?.row;
        self.awake.step.get_mut(row as usize)
    }

    /// Takes a body out of the simulation or back in.
    pub(crate) fn enable_body(&mut self, slot: u32, on: bool) {
        if self.bodies[slot].enabled == on {
            return;
        }
        // Joints of a body that is out do not act.
        self.joints.version += u64::from(!self.bodies[slot].joints.is_empty());
        if on {
            self.bodies[slot].enabled = true;
            if self.bodies[slot].kind != BodyKind::Fixed {
                self.push_row(slot);
            }
            for s in self.bodies[slot].shapes.clone() {
                self.place_shape(s);
            }
            return;
        }
        self.wake_neighbours(slot);
        for s in self.bodies[slot].shapes.clone() {
            self.unplace_shape(s);
        }
        if self.bodies[slot].row != NONE {
            self.remove_row(slot);
        }
        self.bodies[slot].enabled = false;
    }

    /// Gives a body a row in the awake columns.
    pub(crate) fn push_row(&mut self, slot: u32) {
        let b = &mut self.bodies[slot];
        debug_assert!(b.row == NONE && b.enabled && b.kind != BodyKind::Fixed);
        let (row, kind) = (self.awake.state.len() as u32, b.kind);
        b.row = row;
        self.awake.state.push(BodyState::new(b.velocity, b.angular_velocity));
        self.awake.step.push(BodyStep {
            force: Vec3::ZERO,
            torque: Vec3::ZERO,
            acceleration: Vec3::ZERO,
            inv_mass: 0.0,
            linear_damping: 0.0,
            angular_damping: 0.0,
            gravity_scale: 0.0,
            kind,
            locks: 0,
            isotropic: true,
            fast_rotation: false,
            body: slot,
            halted: 0,
            sleep_timer: 0.0,
            sleep_speed: 0.0,
            drift: [Vec3::ZERO; 2],
            swing: [Vec3::ZERO; 2],
            raised: 1.0,
            target: None,
            guided: false,
            room: 0.0,
            moved: [0.0; 2],
            radius: 0.0,
            reach: Vec3::ZERO,
        });
        self.awake.turning.push(None);
        self.awake.inertia.push(InvInertia::default());
        self.place_row(slot, row, kind);
        self.refresh_row(slot);
        self.refresh_inertia(slot);
    }

    /// Tells all that ask by body where its row is.
    fn place_row(&mut self, slot: u32, row: u32, kind: BodyKind) {
        self.frames[slot as usize].row = row;
        self.row_of[slot as usize] = row;
        self.items[slot as usize] = if kind == BodyKind::Dynamic { row } else { ColorSets::shared(row) };
        self.awake.changes += 1;
    }

    /// Drops a body's row, keeping its velocity in the record; the last row takes its place.
    pub(crate) fn remove_row(&mut self, slot: u32) {
        let row = self.bodies[slot].row as usize;
        let (radius, reach) = (self.bodies[slot].mass.outer_radius, self.bodies[slot].mass.reach);
        let gone = moved(&self.frames[slot as usize], radius, reach);
        self.travel[slot as usize].iter_mut().zip(gone).for_each(|(sum, x)| *sum += f64::from(x));
        let state = self.awake.state.swap_remove(row);
        self.awake.step.swap_remove(row);
        self.awake.turning.swap_remove(row);
        self.awake.inertia.swap_remove(row);
        if let Some(moved) = self.awake.step.get(row) {
            let (body, kind) = (moved.body, moved.kind);
            self.bodies[body].row = row as u32;
            self.place_row(body, row as u32, kind);
        }
        self.frames[slot as usize].row = NONE;
        (self.row_of[slot as usize], self.items[slot as usize]) = (NONE, ColorSets::NONE);
        self.awake.changes += 1;
        let b = &mut self.bodies[slot];
        (b.velocity, b.angular_velocity, b.row) = (state.v(), state.w(), NONE);
    }

    /// Copies what the integrator needs from the record to the row.
    pub(crate) fn refresh_row(&mut self, slot: u32) {
        let b = &self.bodies[slot];
        // A ball looks the same however fast it spins.
        let center = self.frames[slot as usize].local_center;
        let ball = |&s: &u32| {
            let s = &self.shapes[s];
            matches!(s.shape, Shape::Sphere { radius } if (s.pose.p - center).length() <= 1e-4 * radius)
        };
        let round = !b.shapes.is_empty() && b.shapes.iter().all(ball);
        let Some(r) = self.awake.step.get_mut(b.row as usize) else { return };
        self.awake.changes += 1;
        r.inv_mass = b.mass.inv_mass;
        r.linear_damping = b.linear_damping;
        r.angular_damping = b.angular_damping;
        r.gravity_scale = b.gravity_scale;
        r.locks = lock_bits(&b.locks);
        r.isotropic = b.mass.isotropic;
        r.fast_rotation = b.fast_rotation || round;
        (r.radius, r.reach) = (b.mass.outer_radius, b.mass.reach);
        r.sleep_speed = b.sleep_speed.unwrap_or(self.settings.sleep_speed * self.settings.length_unit);
        if let Some(t) = self.awake.turning.get_mut(b.row as usize) {
            *t = None;
        }
    }

    pub(crate) fn refresh_inertia(&mut self, slot: u32) {
        let b = &self.bodies[slot];
        let Some(i) = self.awake.inertia.get_mut(b.row as usize) else { return };
        let q = self.frames[slot as usize].rotation;
        *i = InvInertia::new(q, &b.mass.inv_inertia, b.mass.inv_mass, lock_bits(&b.locks));
    }

    /// Recomputes mass and centre from the shapes; the body's origin stays, the velocity is carried to the new centre.
    pub(crate) fn update_mass(&mut self, slot: u32) {
        let body = &self.bodies[slot];
        let shapes = &self.shapes;
        let (m, center) = mass::prepare(body, body.shapes.iter().map(|&s| &shapes[s]));
        let frame = &mut self.frames[slot as usize];
        let shift = frame.rotation.rotate(center - frame.local_center);
        let shift0 = frame.rotation0.rotate(center - frame.local_center);
        frame.center += shift.as_dvec3();
        frame.center0 += shift0.as_dvec3();
        frame.local_center = center;
        self.forget_tests(slot);
        let body = &mut self.bodies[slot];
        // Masses decide how what they are joined to is solved.
        self.joints.version += u64::from(!body.joints.is_empty());
        body.mass = m;
        let w = self.awake.state.get(body.row as usize).map_or(body.angular_velocity, |s| s.w());
        let dv = w.cross(shift);
        match self.awake.state.get_mut(body.row as usize) {
            Some(s) => s.set_velocity(s.v() + dv, s.w()),
            None => body.velocity += dv,
        }
        self.refresh_row(slot);
        self.refresh_inertia(slot);
    }

    /// Puts a shape's bounds where they belong and into the move buffer.
    pub(crate) fn place_shape(&mut self, slot: u32) {
        let r = &self.shapes[slot];
        let body = &self.bodies[r.body];
        if r.place != Place::Nowhere || !r.enabled || !body.enabled {
            return;
        }
        let fixed = body.kind == BodyKind::Fixed;
        let place = if matches!(r.shape, Shape::HalfSpace { .. }) {
            let at = self.unbounded.partition_point(|&s| s < slot);
            self.unbounded.insert(at, slot);
            Place::Unbounded
        } else {
            let fat = self.fat_bounds(slot, fixed);
            self.fat[slot as usize] = fat;
            self.forget_room(self.shapes[slot].body);
            if fixed {
                Place::FixedTree(self.fixed_tree.insert(fat, slot))
            } else {
                Place::MovingTree(self.moving_tree.insert(fat, slot))
            }
        };
        let r = &mut self.shapes[slot];
        r.place = place;
        self.tags[slot as usize] = Tag::new(self.bodies[r.body].kind, !r.sensor, place == Place::Unbounded);
        self.mark_moved(slot);
        self.wake_near(slot);
    }

    /// Takes a shape out of its tree, with its contacts and its visits.
    pub(crate) fn unplace_shape(&mut self, slot: u32) {
        self.remove_contacts_of_shape(slot);
        match self.shapes[slot].place {
            Place::Nowhere => return,
            Place::FixedTree(leaf) => self.fixed_tree.remove(leaf),
            Place::MovingTree(leaf) => self.moving_tree.remove(leaf),
            Place::Unbounded => self.unbounded.retain(|&s| s != slot),
        }
        self.shapes[slot].place = Place::Nowhere;
        if core::mem::take(&mut self.tags[slot as usize]).moved() {
            // Their order is no state: the broad phase sorts what it finds.
            if let Some(at) = self.moved.iter().position(|&s| s == slot) {
                self.moved.swap_remove(at);
            }
        }
        let visitors = core::mem::take(&mut self.shapes[slot].visitors);
        let sensor = self.shape_id(slot);
        for (index, generation) in visitors {
            self.events.push(Event::SensorLeave { sensor, visitor: ShapeId { index, generation } });
        }
    }

    /// The next pair search looks at the shape, whoever it met before.
    pub(crate) fn mark_moved(&mut self, slot: u32) {
        self.fat_before[slot as usize] = NEVER;
        self.list_moved(slot);
    }

    /// The next pair search looks at whom the shape meets now and did not before.
    pub(crate) fn list_moved(&mut self, slot: u32) {
        let tag = &mut self.tags[slot as usize];
        if !tag.moved() {
            tag.set_moved(true);
            self.moved.push(slot);
        }
    }

    /// Tight bounds in the world, computed in f64 and rounded outward to f32.
    pub(crate) fn tight_bounds(&self, slot: u32) -> Aabb {
        let r = &self.shapes[slot];
        world_bounds(&r.shape, &self.frames[r.body as usize].shape_pose(&r.pose))
    }

    fn fat_bounds(&self, slot: u32, fixed: bool) -> Aabb {
        let tight = self.tight_bounds(slot);
        if fixed { tight } else { tight.expanded(margin_of(&tight, self.settings.length_unit)) }
    }

    /// The next step looks at all bounds of a body.
    fn forget_room(&mut self, body: u32) {
        let row = self.bodies[body].row as usize;
        if let Some(b) = self.awake.step.get_mut(row) {
            b.room = 0.0;
        }
    }

    /// After a jump: new bounds for all shapes of a body.
    pub(crate) fn refresh_bounds(&mut self, body: u32) {
        self.forget_room(body);
        for i in 0..self.bodies[body].shapes.len() {
            let s = self.bodies[body].shapes[i];
            let fixed = self.bodies[body].kind == BodyKind::Fixed;
            let fat = self.fat_bounds(s, fixed);
            match self.shapes[s].place {
                Place::Nowhere => continue,
                Place::Unbounded => {}
                Place::FixedTree(leaf) => self.fixed_tree.update(leaf, fat),
                Place::MovingTree(leaf) => self.moving_tree.update(leaf, fat),
            }
            if self.shapes[s].place != Place::Unbounded {
                self.fat[s as usize] = fat;
            }
            self.mark_moved(s);
            self.wake_near(s);
        }
        self.forget_tests(body);
    }
}

/// Broad-phase margin: min(0.05 m, 12.5 % of the largest extent).
pub(crate) fn margin_of(tight: &Aabb, length_unit: f32) -> f32 {
    f32s::min(0.05 * length_unit, 0.25 * tight.half().max_component())
}

/// Bounds of a shape at a world pose: the sum with the position is done in f64, then rounded outward.
pub(crate) fn world_bounds(shape: &Shape, pose: &WorldPose) -> Aabb {
    let local = shape.aabb(&Pose::new(Vec3::ZERO, pose.q));
    let (lo, hi) = (local.min.as_dvec3() + pose.p, local.max.as_dvec3() + pose.p);
    Aabb::new(
        Vec3::new(round_down(lo.x), round_down(lo.y), round_down(lo.z)),
        Vec3::new(round_up(hi.x), round_up(hi.y), round_up(hi.z)),
    )
}

pub(crate) fn round_down(x: f64) -> f32 {
    let y = x as f32;
    if f64::from(y) > x { y.next_down() } else { y }
}

pub(crate) fn round_up(x: f64) -> f32 {
    let y = x as f32;
    if f64::from(y) < x { y.next_up() } else { y }
}
