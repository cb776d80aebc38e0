//! Adding, changing and removing characters; the move that games make themselves.

use super::around::{Around, MoveScratch};
use super::desc::{CharacterDesc, CharacterInput, CharacterKind, CharacterMove, CharacterMover};
use super::solve::{Walk, Wish};
use super::state::Character;
use crate::command::Command;
use crate::error::{Error, Result, check};
use crate::handle::CharacterId;
use crate::limits;
use crate::query::QueryFilter;
use crate::room::contacts::desc::{Combine, Filter, Material, ShapeDesc};
use crate::room::rigid::desc::{AxisLocks, BodyDesc, BodyKind, check_position};
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_geometry::Shape;
use jounce_math::{DVec3, Pose, Quat, Vec3, scalar::f32s};
use jounce_tasks::FloatEnv;

/// How high a dynamic character's capsule floats over its foot, m.
pub(crate) fn leg_length(d: &CharacterDesc) -> f32 {
    match d.kind {
        CharacterKind::Walker => 0.0,
        CharacterKind::Dynamic { .. } => d.mover.step_height,
    }
}

/// The capsule of a character of some height, and where it is over the foot (body frame).
fn capsule_over_foot(d: &CharacterDesc, height: f32) -> (Shape, Pose) {
    let leg = f32s::min(leg_length(d), height - 2.0 * d.mover.radius);
    let middle = Vec3::new(0.0, 0.5 * (height + leg), 0.0);
    (d.mover.capsule(height - leg), Pose::from_translation(middle))
}

impl World {
    pub(crate) fn character_id(&self, index: u32) -> CharacterId {
        CharacterId { index, generation: self.characters.table.generation(index) }
    }
    pub(crate) fn character_slot(&self, id: CharacterId) -> Result<u32> {
        if self.characters.table.is_live(id.index, id.generation) {
            return Ok(id.index);
        }
        Err(Error::Stale { what: "character", index: id.index, generation: id.generation })
    }

    pub(crate) fn do_add_character(&mut self, mut d: CharacterDesc) -> Result<CharacterId> {
        d.check()?;
        if self.characters.table.len() >= limits::CHARACTERS_MAX {
            return Err(Error::Limit { what: "characters", limit: limits::CHARACTERS_MAX });
        }
        d.mover.up = d.mover.unit_up();
        let (shape, pose) = capsule_over_foot(&d, d.mover.height);
        let walker = d.kind == CharacterKind::Walker;
        // Legs hold it: its own surface slips.
        let surface = Material {
            static_friction: 0.0,
            kinetic_friction: 0.0,
            friction_combine: Combine::Multiply,
            ..Material::default()
        };
        let material = if walker { Material::default() } else { surface };
        let shape = ShapeDesc::new(shape).at(pose.p).mass(d.mass).material(material).filter(d.filter);
        let mut body = BodyDesc::new(if walker { BodyKind::Kinematic } else { BodyKind::Dynamic })
            .at(d.position)
            .rotated(d.rotation(d.heading))
            .locks(if walker { AxisLocks::NONE } else { AxisLocks::ROTATION })
            .gravity_scale(d.gravity_scale)
            .can_sleep(walker)
            .user_data(d.user_data)
            .shape(shape);
        body.name = d.name.clone();
        let id = self.do_add_body(body)?;
        let shape = self.shape_id(self.bodies[id.index].shapes[0]);
        let (index, generation) = self.characters.table.insert(Character {
            body: id.index,
            shape,
            input: CharacterInput::default(),
            foot: d.position,
            heading: d.heading,
            velocity: Vec3::ZERO,
            ground: None,
            load: 0.0,
            crouched: false,
            air_time: 0.0,
            passing: None,
            on_steep: false,
            hit_ceiling: false,
            squeezed: false,
            stepped: 0.0,
            hits: Vec::with_capacity(limits::CHARACTER_HITS_MAX),
            desc: d,
        });
        Ok(CharacterId { index, generation })
    }

    pub(crate) fn do_remove_character(&mut self, id: CharacterId) -> Result<()> {
        let slot = self.character_slot(id)?;
        let body = self.body_id(self.characters.table[slot].body);
        self.do_remove_body(body)
    }

    /// A body goes: so does the character that it is, and nobody stands on it any more.
    pub(crate) fn drop_character_of(&mut self, body: u32) {
        for c in self.characters.table.values_mut() {
            if c.ground.is_some_and(|g| g.body.index() == body) {
                c.ground = None;
            }
        }
        let found = self.characters.table.iter().find(|(_, c)| c.body == body).map(|(i, _)| i);
        if let Some(i) = found {
            self.characters.table.remove(i);
        }
    }

    pub(crate) fn do_set_character_input(&mut self, id: CharacterId, input: CharacterInput) -> Result<()> {
        let slot = self.character_slot(id)?;
        input.check()?;
        self.characters.table[slot].input = input;
        Ok(())
    }

    pub(crate) fn do_set_character(&mut self, id: CharacterId, mut d: CharacterDesc) -> Result<()> {
        let slot = self.character_slot(id)?;
        d.check()?;
        let c = &self.characters.table[slot];
        let same = matches!(
            (c.desc.kind, d.kind),
            (CharacterKind::Walker, CharacterKind::Walker)
                | (CharacterKind::Dynamic { .. }, CharacterKind::Dynamic { .. })
        );
        check(same, "character", "kind", d.kind, "the kind that it has (remove it and add another)")?;
        let (body, shape) = (self.body_id(c.body), c.shape);
        self.shape_slot(shape)?;
        d.mover.up = d.mover.unit_up();
        let height = if c.crouched { d.crouch_height } else { d.mover.height };
        self.set_capsule(&d, shape, height)?;
        self.do_set_filter(shape, d.filter)?;
        self.apply(Command::SetGravityScale(body, d.gravity_scale))?;
        let c = &mut self.characters.table[slot];
        // Where it stands and what it is called are the body's.
        (d.position, d.heading) = (c.desc.position, c.desc.heading);
        c.desc = d;
        Ok(())
    }

    /// Gives a character's body the capsule of a height; the foot stays.
    pub(crate) fn set_capsule(
        &mut self,
        d: &CharacterDesc,
        shape: crate::ShapeId,
        height: f32,
    ) -> Result<()> {
        let (capsule, pose) = capsule_over_foot(d, height);
        self.do_set_shape(shape, capsule)?;
        self.do_set_shape_pose(shape, pose)
    }

    /// Moves a capsule that is no body of this world by `motion` (m) from the foot point `from`, among the bodies as they stand:
    /// slides along walls, climbs steps, and, where `grounded` says that it stood, keeps to the ground. The world is not changed:
    /// see [`World::character_push`] for what the move does to bodies in its way. The part of `motion` along up is a jump or a
    /// fall; a character that is `grounded` is led down by the ground alone.
    ///
    /// ```
    /// use jounce::{CharacterMover, prelude::*};
    ///
    /// # fn main() -> jounce::Result<()> {
    /// let mut world = World::new(WorldDesc::default())?;
    /// world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    /// let mover = CharacterMover::default();
    /// let fall = world.move_character(
    ///     &mover, DVec3::new(0.0, 1.0, 0.0), Vec3::new(0.1, -2.0, 0.0), false, &QueryFilter::default())?;
    /// assert!(fall.ground.is_some() && (fall.position.y - 0.01).abs() < 1e-3);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// A mover, position or motion (at most 1000 m) out of range, named.
    pub fn move_character(
        &self,
        mover: &CharacterMover,
        from: DVec3,
        motion: Vec3,
        grounded: bool,
        filter: &QueryFilter<'_>,
    ) -> Result<CharacterMove> {
        let _mode = FloatEnv::set_default();
        mover.check()?;
        check_position(from)?;
        let ok = motion.is_finite() && motion.length() <= 1e3;
        check(ok, "character", "motion", motion, "finite, at most 1000 m")?;
        let mut scratch = MoveScratch::default();
        let up = mover.unit_up();
        let mut around = Around {
            world: self,
            mover,
            up,
            height: mover.height,
            capsule: mover.capsule(mover.height),
            turn: Quat::from_rotation_arc(Vec3::Y, up).normalize(),
            body: NONE,
            own: Filter { layers: u32::MAX, mask: u32::MAX, group: 0 },
            filter,
            ahead: &[],
            part: 1.0,
            ignored: NONE,
            resist: [0.0, 0.0, self.dt() as f32],
            scratch: &mut scratch,
        };
        around.look(from, motion.length() + mover.step_height + mover.snap + 8.0 * mover.skin);
        let mut hits = Vec::new();
        let mut walk = Walk::new(&mut around, &mut hits, from);
        let rise = motion.dot(up);
        let grounded = (grounded && rise <= 0.0).then_some(up);
        let floor = grounded.and_then(|_| walk.floor_normal());
        walk.go(&Wish { across: motion, rise, grounded: grounded.map(|u| floor.unwrap_or(u)) });
        let out = walk.out;
        Ok(CharacterMove {
            position: out.foot,
            ground: out.ground,
            on_steep: out.on_steep,
            hit_ceiling: out.hit_ceiling,
            stepped: out.stepped,
            squeezed: out.squeezed,
            hits,
        })
    }

    /// What a character that wanted to go at `velocity` (m/s) does to the bodies that it ran into in a step, with at most `force` (N):
    /// impulses as commands, for [`World::apply`] or a recording.
    pub fn character_push(&self, made: &CharacterMove, up: Vec3, velocity: Vec3, force: f32) -> Vec<Command> {
        let _mode = FloatEnv::set_default();
        let impulse = force * self.dt() as f32;
        let up = up.normalize_or(Vec3::Y);
        let mut out: Vec<Command> = Vec::new();
        for (i, h) in made.hits.iter().enumerate() {
            if made.hits[..i].iter().all(|o| o.body != h.body)
                && let Some((at, j)) = self.push_of(h, up, velocity, impulse)
            {
                out.push(Command::AddImpulse(h.body, j, Some(at)));
            }
        }
        out
    }

    /// Inverse mass of a body at a lever along a unit vector, 1/kg; 0 of what is not dynamic.
    pub(crate) fn give_of(&self, slot: u32, lever: Vec3, n: Vec3) -> f32 {
        let body = &self.bodies[slot];
        if body.kind != BodyKind::Dynamic {
            return 0.0;
        }
        let local = self.frames[slot as usize].rotation.inverse_rotate(lever.cross(n));
        body.mass.inv_mass + local.dot(body.mass.inv_inertia * local)
    }

    /// Impulse on a body in the way, and where: at the height of its centre of mass, so that it is shoved and not tipped.
    pub(crate) fn push_of(
        &self,
        h: &super::desc::CharacterHit,
        up: Vec3,
        velocity: Vec3,
        most: f32,
    ) -> Option<(DVec3, Vec3)> {
        let slot = self.slot(h.body).ok()?;
        let body = &self.bodies[slot];
        if body.kind != BodyKind::Dynamic || body.mass.inv_mass <= 0.0 {
            return None;
        }
        let flat = super::solve::across(h.normal, up);
        let (n, _) = flat.try_normalize()?;
        let center = self.frames[slot as usize].center;
        let lever = super::solve::across((h.point - center).as_vec3(), up);
        let (v, w) = self.velocities(body);
        let closing = (velocity - (v + w.cross(lever))).dot(-n);
        if closing <= 0.0 || !closing.is_finite() {
            return None;
        }
        let inv = self.give_of(slot, lever, n);
        let j = f32s::min(closing / inv, most);
        (j > 0.0).then(|| (center + lever.as_dvec3(), n * -j))
    }
}
