//! What users write to make a character, and what a move tells.

use crate::error::{Result, check};
use crate::handle::{BodyId, ShapeId};
use crate::limits;
use crate::room::contacts::desc::Filter;
use jounce_geometry::Shape;
use jounce_math::{DVec3, Quat, Vec3, scalar::f32s};

/// The size of a character and what it can do. Lengths in metres, angles in radians.
///
/// Used by [`crate::World::move_character`] and by the characters of a world ([`CharacterDesc`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CharacterMover {
    /// Radius of the capsule, m. Default 0.3.
    pub radius: f32,
    /// Height from foot to crown, m, at least two radii. Default 1.8.
    pub height: f32,
    /// Unit direction from foot to crown (normalised on entry). Default +Y.
    pub up: Vec3,
    /// Steepest ground to stand and walk on, rad, 0 to π/2. Default 45°. Steeper ground is a wall, and slid down.
    pub slope_max: f32,
    /// Highest step that is climbed, m; 0 for none. Default 0.35.
    pub step_height: f32,
    /// How far down it is kept on the ground when the ground falls away, m; 0 for not at all. Default 0.4.
    pub snap: f32,
    /// Gap that is kept to everything, m. Default 0.01. Larger is more robust.
    pub skin: f32,
    /// Layers of platforms that only carry from above (see [`crate::Filter::layers`]); it passes through them from below and from
    /// the sides. Default none.
    pub one_way_layers: u32,
}

impl Default for CharacterMover {
    fn default() -> Self {
        Self {
            radius: 0.3,
            height: 1.8,
            up: Vec3::Y,
            slope_max: core::f32::consts::FRAC_PI_4,
            step_height: 0.35,
            snap: 0.4,
            skin: 0.01,
            one_way_layers: 0,
        }
    }
}

impl CharacterMover {
    /// Refuses numbers that no character can have.
    ///
    /// # Errors
    /// Names the field, its value and what was expected.
    pub fn check(&self) -> Result<()> {
        let what = "character";
        check((1e-3..=1e3).contains(&self.radius), what, "radius", self.radius, "0.001 to 1000 m")?;
        let ok = self.height >= 2.0 * self.radius && self.height <= 1e4;
        check(ok, what, "height", self.height, "at least twice the radius, at most 10000 m")?;
        let l = self.up.length();
        check(l > 1e-6 && l < 1e6, what, "up", self.up, "a finite vector that is not zero")?;
        let right = core::f32::consts::FRAC_PI_2;
        check((0.0..=right).contains(&self.slope_max), what, "slope_max", self.slope_max, "0 to π/2 rad")?;
        check((0.0..=1e3).contains(&self.step_height), what, "step_height", self.step_height, "0 to 1000 m")?;
        check((0.0..=1e3).contains(&self.snap), what, "snap", self.snap, "0 to 1000 m")?;
        let ok = self.skin >= 1e-3 * self.radius && self.skin <= 0.5 * self.radius;
        check(ok, what, "skin", self.skin, "0.001 to 0.5 of the radius, m")
    }

    pub(crate) fn unit_up(&self) -> Vec3 {
        self.up.normalize_or(Vec3::Y)
    }
    pub(crate) fn cos_slope(&self) -> f32 {
        // A slope of just that angle, rounded, is walked.
        f32s::cos(self.slope_max) - 1e-3
    }
    /// The capsule at a height from foot to crown.
    pub(crate) fn capsule(&self, height: f32) -> Shape {
        Shape::Capsule { half_height: f32s::max(0.5 * height - self.radius, 0.0), radius: self.radius }
    }
}

/// How a character moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CharacterKind {
    /// Led by its own rules: a kinematic body. Exact on slopes, steps and platforms.
    Walker,
    /// Led by forces: a dynamic body that cannot turn, floating at its step height on a spring. It is pushed as any body is, and what
    /// it stands on feels its weight and its steps.
    Dynamic {
        /// Stiffness of the leg, Hz.
        leg_hertz: f32,
        /// Damping ratio of the leg.
        leg_damping_ratio: f32,
        /// Strength of walking, N.
        force: f32,
    },
}

impl CharacterKind {
    /// A dynamic character: leg of 6 Hz, critically damped, walking with 2000 N.
    pub const DYNAMIC: Self = Self::Dynamic { leg_hertz: 6.0, leg_damping_ratio: 1.0, force: 2000.0 };
}

/// Describes a character of a world.
#[derive(Clone, Debug, PartialEq)]
pub struct CharacterDesc {
    /// Walker or dynamic. Default walker.
    pub kind: CharacterKind,
    /// Size and skills.
    pub mover: CharacterMover,
    /// Where its foot stands, world, m.
    pub position: DVec3,
    /// Its turn about up, rad, from the shortest turn of +Y to `up`.
    pub heading: f32,
    /// Its weight on what it stands on, and its share where it meets moving bodies, kg. Default 80.
    pub mass: f32,
    /// Most force on a body in its way, N. Default 300: a box of 10 kg goes, one of 1000 kg stays.
    pub push_force: f32,
    /// Height while it crouches, m. Default 1.0.
    pub crouch_height: f32,
    /// How fast it changes its velocity on the ground, m/s². Default 60.
    pub acceleration: f32,
    /// How fast in the air, m/s². Default 5.
    pub air_acceleration: f32,
    /// Factor on the world's gravity, along up. Default 1.
    pub gravity_scale: f32,
    /// Fastest fall, m/s. Default 60.
    pub fall_speed_max: f32,
    /// Does it turn with a platform that turns? Default true.
    pub turns_with_ground: bool,
    /// Whom it meets.
    pub filter: Filter,
    /// Free for the caller (the body's number).
    pub user_data: u128,
    /// Free for the caller (the body's name).
    pub name: Option<String>,
}

impl Default for CharacterDesc {
    fn default() -> Self {
        Self {
            kind: CharacterKind::Walker,
            mover: CharacterMover::default(),
            position: DVec3::ZERO,
            heading: 0.0,
            mass: 80.0,
            push_force: 300.0,
            crouch_height: 1.0,
            acceleration: 60.0,
            air_acceleration: 5.0,
            gravity_scale: 1.0,
            fall_speed_max: 60.0,
            turns_with_ground: true,
            filter: Filter::default(),
            user_data: 0,
            name: None,
        }
    }
}

impl CharacterDesc {
    /// A walker with default size and skills, its foot at a point (m).
    pub fn at(position: impl Into<DVec3>) -> Self {
        Self { position: position.into(), ..Self::default() }
    }
    /// Makes it a dynamic one.
    pub fn dynamic(mut self) -> Self {
        self.kind = CharacterKind::DYNAMIC;
        self
    }
    /// Sets size and skills.
    pub fn mover(mut self, mover: CharacterMover) -> Self {
        self.mover = mover;
        self
    }

    /// Refuses numbers that no character can have.
    ///
    /// # Errors
    /// Names the field, its value and what was expected.
    pub fn check(&self) -> Result<()> {
        let what = "character";
        self.mover.check()?;
        let p = self.position;
        let ok = p.is_finite() && p.abs().max_component() <= limits::POSITION_MAX;
        check(ok, what, "position", p, "finite, within ±1e9 m")?;
        check(self.heading.abs() <= 1e4, what, "heading", self.heading, "within ±10000 rad")?;
        check((1e-3..=1e9).contains(&self.mass), what, "mass", self.mass, "0.001 to 1e9 kg")?;
        check((0.0..=1e12).contains(&self.push_force), what, "push_force", self.push_force, "0 to 1e12 N")?;
        let (h, r) = (self.crouch_height, self.mover.radius);
        let ok = h >= 2.0 * r && h <= self.mover.height;
        check(ok, what, "crouch_height", h, "from twice the radius to the height, m")?;
        let rate = |field, v: f32| check((0.0..=1e6).contains(&v), what, field, v, "0 to 1e6 m/s²");
        rate("acceleration", self.acceleration)?;
        rate("air_acceleration", self.air_acceleration)?;
        let g = self.gravity_scale;
        check((0.0..=1e6).contains(&g), what, "gravity_scale", g, "0 to 1e6")?;
        let v = self.fall_speed_max;
        check((0.0..=limits::SPEED_MAX).contains(&v), what, "fall_speed_max", v, "0 to 1e5 m/s")?;
        if let Some(n) = &self.name {
            check(n.len() <= limits::NAME_MAX, what, "name", n.len(), "at most 256 bytes")?;
        }
        let CharacterKind::Dynamic { leg_hertz, leg_damping_ratio, force } = self.kind else { return Ok(()) };
        check((0.1..=100.0).contains(&leg_hertz), what, "leg_hertz", leg_hertz, "0.1 to 100 Hz")?;
        let z = leg_damping_ratio;
        check((0.0..=100.0).contains(&z), what, "leg_damping_ratio", z, "0 to 100")?;
        check((0.0..=1e12).contains(&force), what, "force", force, "0 to 1e12 N")?;
        let room = self.mover.height - 2.0 * self.mover.radius;
        let s = self.mover.step_height;
        check(
            s <= room,
            what,
            "step_height",
            s,
            "at most the height less two radii, where a leg carries it, m",
        )
    }

    /// Rotation of the body: +Y to up, then about up.
    pub(crate) fn rotation(&self, heading: f32) -> Quat {
        let up = self.mover.unit_up();
        (Quat::from_axis_angle(up, heading) * Quat::from_rotation_arc(Vec3::Y, up)).normalize()
    }
}

/// What a character is asked to do, until it is asked otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CharacterInput {
    /// Wanted velocity against the ground, m/s, world axes; its part along up is left out.
    pub walk: Vec3,
    /// Leaves the ground (or the air: whether it may is the caller's business, see
    /// [`crate::CharacterRef::air_time`]) in the next step at this speed along up, m/s; spent by that step.
    pub jump: Option<f32>,
    /// Crouches; stands up again as soon as there is headroom.
    pub crouch: bool,
    /// Lets itself fall through the one-way platform it stands on; spent by the next step.
    pub drop_through: bool,
    /// Turn about up, rad, at once in the next step; `None` keeps it (it still turns with platforms).
    pub heading: Option<f32>,
}

impl CharacterInput {
    /// Walks with a velocity, m/s.
    pub fn walk(velocity: impl Into<Vec3>) -> Self {
        Self { walk: velocity.into(), ..Self::default() }
    }
    /// Jumps too, at a speed, m/s.
    pub fn jump(mut self, speed: f32) -> Self {
        self.jump = Some(speed);
        self
    }
    /// Crouches too.
    pub fn crouch(mut self) -> Self {
        self.crouch = true;
        self
    }

    pub(crate) fn check(&self) -> Result<()> {
        let what = "character input";
        let fine = |v: Vec3| v.is_finite() && v.length() <= limits::SPEED_MAX;
        check(fine(self.walk), what, "walk", self.walk, "finite, at most 1e5 m/s")?;
        if let Some(j) = self.jump {
            check((0.0..=limits::SPEED_MAX).contains(&j), what, "jump", j, "0 to 1e5 m/s")?;
        }
        if let Some(h) = self.heading {
            check(h.abs() <= 1e4, what, "heading", h, "within ±10000 rad")?;
        }
        Ok(())
    }
}

/// What a character stands on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CharacterGround {
    /// The body.
    pub body: BodyId,
    /// The shape.
    pub shape: ShapeId,
    /// Where they meet, world, m.
    pub point: DVec3,
    /// Unit normal of the contact, world axes. On an edge it leans; the face behind it may be walked on.
    pub normal: Vec3,
    /// Velocity of the ground at the point, m/s.
    pub velocity: Vec3,
}

/// What a character ran into on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CharacterHit {
    /// The body.
    pub body: BodyId,
    /// The shape.
    pub shape: ShapeId,
    /// Where, world, m.
    pub point: DVec3,
    /// Unit normal towards the character, world axes.
    pub normal: Vec3,
}

/// What came of [`crate::World::move_character`].
#[derive(Clone, Debug, PartialEq)]
pub struct CharacterMove {
    /// Where the foot is now, world, m.
    pub position: DVec3,
    /// What it stands on.
    pub ground: Option<CharacterGround>,
    /// It touched ground too steep to stand on.
    pub on_steep: bool,
    /// A ceiling ended its way up.
    pub hit_ceiling: bool,
    /// How far it climbed a step, m; 0 where it did not.
    pub stepped: f32,
    /// Surfaces from several sides left it no room: it overlaps some.
    pub squeezed: bool,
    /// What it ran into, in order, at most [`limits::CHARACTER_HITS_MAX`].
    pub hits: Vec<CharacterHit>,
}
