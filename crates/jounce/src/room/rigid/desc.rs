//! What users write to make a rigid body.

use crate::error::{Result, check};
use crate::limits;
use crate::room::contacts::desc::ShapeDesc;
use jounce_geometry::MassProperties;
use jounce_math::{DVec3, Quat, Vec3};

/// How a body moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum BodyKind {
    /// Never moves by itself; infinite mass.
    Fixed = 0,
    /// Moves as it is told (velocity, [`crate::World::move_to`]); infinite mass; pushes dynamic bodies.
    Kinematic = 1,
    /// Moves by forces and contacts.
    Dynamic = 2,
}

/// Axes along or about which a body may not move (world axes).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AxisLocks {
    /// No motion along x, y, z.
    pub linear: [bool; 3],
    /// No turning about x, y, z.
    pub angular: [bool; 3],
}

impl AxisLocks {
    /// Nothing locked.
    pub const NONE: Self = Self { linear: [false; 3], angular: [false; 3] };
    /// Motion in the xy plane only (a 2-D game).
    pub const PLANE_XY: Self = Self { linear: [false, false, true], angular: [true, true, false] };
    /// No turning at all.
    pub const ROTATION: Self = Self { linear: [false; 3], angular: [true; 3] };
}

/// Describes a body. Build with [`BodyDesc::dynamic`], [`BodyDesc::fixed`], [`BodyDesc::kinematic`] and chain.
#[derive(Clone, Debug)]
pub struct BodyDesc {
    /// How it moves.
    pub kind: BodyKind,
    /// Position of the body's origin in the world, m.
    pub position: DVec3,
    /// Rotation (unit; normalised on entry).
    pub rotation: Quat,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vec3,
    /// Angular velocity in world axes, rad/s.
    pub angular_velocity: Vec3,
    /// Linear damping, 1/s: v′ = −c v.
    pub linear_damping: f32,
    /// Angular damping, 1/s.
    pub angular_damping: f32,
    /// Factor on the world's gravity.
    pub gravity_scale: f32,
    /// Locked axes.
    pub locks: AxisLocks,
    /// Instead of the sum over the shapes: mass (kg), centre (body frame) and inertia about it. No principal moment is above the sum of
    /// the other two (by more than a hundredth of it).
    pub mass: Option<MassProperties>,
    /// Continuous collision against moving bodies too.
    pub bullet: bool,
    /// Exempt from the spin limit (wheels, tops).
    pub fast_rotation: bool,
    /// May fall asleep.
    pub can_sleep: bool,
    /// Own sleep threshold, m/s, in place of `Settings::sleep_speed`.
    pub sleep_speed: Option<f32>,
    /// Starts asleep.
    pub asleep: bool,
    /// Takes part in the simulation.
    pub enabled: bool,
    /// Free for the caller.
    pub user_data: u128,
    /// Free for the caller; shown in messages.
    pub name: Option<String>,
    /// Shapes attached to the body.
    pub shapes: Vec<ShapeDesc>,
}

impl BodyDesc {
    /// A body of a kind, at the origin, at rest, without shapes.
    pub fn new(kind: BodyKind) -> Self {
        Self {
            kind,
            position: DVec3::ZERO,
            rotation: Quat::IDENTITY,
            velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
            linear_damping: 0.0,
            angular_damping: 0.0,
            gravity_scale: 1.0,
            locks: AxisLocks::NONE,
            mass: None,
            bullet: false,
            fast_rotation: false,
            can_sleep: true,
            sleep_speed: None,
            asleep: false,
            enabled: true,
            user_data: 0,
            name: None,
            shapes: Vec::new(),
        }
    }
    /// A body that moves by forces and contacts.
    pub fn dynamic() -> Self {
        Self::new(BodyKind::Dynamic)
    }
    /// A body that never moves.
    pub fn fixed() -> Self {
        Self::new(BodyKind::Fixed)
    }
    /// A body that moves as it is told.
    pub fn kinematic() -> Self {
        Self::new(BodyKind::Kinematic)
    }
    /// Sets the position.
    pub fn at(mut self, position: impl Into<DVec3>) -> Self {
        self.position = position.into();
        self
    }
    /// Sets the rotation.
    pub fn rotated(mut self, rotation: Quat) -> Self {
        self.rotation = rotation;
        self
    }
    /// Sets the velocity.
    pub fn velocity(mut self, velocity: impl Into<Vec3>) -> Self {
        self.velocity = velocity.into();
        self
    }
    /// Sets the angular velocity.
    pub fn angular_velocity(mut self, w: impl Into<Vec3>) -> Self {
        self.angular_velocity = w.into();
        self
    }
    /// Adds a shape.
    pub fn shape(mut self, shape: ShapeDesc) -> Self {
        self.shapes.push(shape);
        self
    }
    /// Sets linear and angular damping, 1/s.
    pub fn damping(mut self, linear: f32, angular: f32) -> Self {
        (self.linear_damping, self.angular_damping) = (linear, angular);
        self
    }
    /// Sets the factor on gravity.
    pub fn gravity_scale(mut self, scale: f32) -> Self {
        self.gravity_scale = scale;
        self
    }
    /// Sets the locked axes.
    pub fn locks(mut self, locks: AxisLocks) -> Self {
        self.locks = locks;
        self
    }
    /// Overrides mass, centre of mass and inertia.
    pub fn mass(mut self, mass: MassProperties) -> Self {
        self.mass = Some(mass);
        self
    }
    /// Continuous collision against moving bodies too.
    pub fn bullet(mut self, bullet: bool) -> Self {
        self.bullet = bullet;
        self
    }
    /// May it fall asleep?
    pub fn can_sleep(mut self, can_sleep: bool) -> Self {
        self.can_sleep = can_sleep;
        self
    }
    /// Sets the name.
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }
    /// Sets the caller's number.
    pub fn user_data(mut self, user_data: u128) -> Self {
        self.user_data = user_data;
        self
    }

    /// Refuses numbers that no body can have, shapes included.
    ///
    /// # Errors
    /// Names the field, its value and what was expected.
    pub fn check(&self) -> Result<()> {
        check_position(self.position)?;
        check_rotation(self.rotation)?;
        check_velocity(self.velocity)?;
        check_spin(self.angular_velocity)?;
        check_damping("linear_damping", self.linear_damping)?;
        check_damping("angular_damping", self.angular_damping)?;
        check_gravity_scale(self.gravity_scale)?;
        if let Some(m) = &self.mass {
            check_mass(m)?;
        }
        if let Some(s) = self.sleep_speed {
            check((0.0..=1e3).contains(&s), "body", "sleep_speed", s, "0 to 1000 m/s")?;
        }
        if let Some(n) = &self.name {
            check(n.len() <= limits::NAME_MAX, "body", "name", n.len(), "at most 256 bytes")?;
        }
        let n = self.shapes.len();
        check(n <= limits::SHAPES_PER_BODY_MAX, "body", "shapes", n, "at most 65536 shapes")?;
        self.shapes.iter().try_for_each(|s| s.check_on(self.kind))
    }
}

pub(crate) fn check_position(p: DVec3) -> Result<()> {
    let ok = p.is_finite() && p.abs().max_component() <= limits::POSITION_MAX;
    check(ok, "body", "position", p, "finite, within ±1e9 m")
}

pub(crate) fn check_rotation(q: Quat) -> Result<()> {
    let l = q.length();
    check(q.is_finite() && l > 1e-6 && l < 1e6, "body", "rotation", q, "a finite quaternion that is not zero")
}

pub(crate) fn check_velocity(v: Vec3) -> Result<()> {
    let ok = v.is_finite() && v.abs().max_component() <= limits::SPEED_MAX;
    check(ok, "body", "velocity", v, "finite, at most 1e5 m/s per axis")
}

pub(crate) fn check_spin(w: Vec3) -> Result<()> {
    let ok = w.is_finite() && w.abs().max_component() <= limits::SPIN_MAX;
    check(ok, "body", "angular_velocity", w, "finite, at most 1e5 rad/s per axis")
}

pub(crate) fn check_damping(field: &'static str, c: f32) -> Result<()> {
    check((0.0..=1e6).contains(&c), "body", field, c, "0 to 1e6 per second")
}

pub(crate) fn check_gravity_scale(s: f32) -> Result<()> {
    check((-1e6..=1e6).contains(&s), "body", "gravity_scale", s, "finite, within ±1e6")
}

pub(crate) fn check_mass(m: &MassProperties) -> Result<()> {
    let ok = m.mass >= limits::MASS_MIN && m.mass <= limits::MASS_MAX;
    check(ok, "body", "mass", m.mass, "a positive mass, 1e-12 to 1e15 kg")?;
    check(
        m.center.is_finite() && m.center.length() <= 1e6,
        "body",
        "mass.center",
        m.center,
        "finite, within 1e6 m",
    )?;
    let (d, _) = m.inertia.as_dmat3().symmetric_eigen();
    let (i, most) = (m.inertia, 1e-4 * d.max_component() as f32);
    let skew = Vec3::new(i.cx.y - i.cy.x, i.cy.z - i.cz.y, i.cz.x - i.cx.z);
    let symmetric = i.is_finite() && skew.abs().max_component() <= most;
    // The inverse must fit f32 with room for levers.
    let ok = symmetric && d.min_component() >= 1e-30 && d.max_component() <= 1e25;
    check(ok, "body", "mass.inertia", m.inertia, "a finite, symmetric, positive definite tensor")?;
    // Σ m (y² + z²) and its like add up: I_x + I_y = I_z + 2 Σ m z². A hundredth more forgives moments written with two digits.
    let largest = d.max_component();
    let ok = largest <= 1.01 * (d.x + d.y + d.z - largest);
    let expected = "no principal moment above the sum of the other two, as matter has them";
    check(ok, "body", "mass.inertia", m.inertia, expected)
}
