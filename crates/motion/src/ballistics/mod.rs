//! Projectiles: where they go, and how to make them go there.
//!
//! In vacuum P(t) = P₀ + v₀ t + ½ g t², so with g downwards and α the launch angle above the horizontal
//!
//! | question | answer |
//! |---|---|
//! | time of the apex | v_y/g |
//! | height of the apex | y₀ + v_y²/2g |
//! | range on level ground | 2 v_x v_y/g = s² sin 2α/g |
//! | angles for a range r | α = ½ asin(r g/s²) and π/2 − α |
//! | angle for an apex h | α = asin(√(2 g (h − y₀))/s) |
//! | any target at d | t² = 2 (B ± √(B² − g² d²))/g², B = s² + d·g, v₀ = d/t − ½ g t |
//! | least speed for it | s² = \|g\|\|d\| − d·g |
//!
//! s: launch speed, m/s. The form with t² has no angle in it and so no direction in which it fails: targets above,
//! below and anywhere in space are one case. The smaller t is the flat shot, the larger the high one.
//!
//! In air there is no closed form: [`fly`] follows the path by Dormand–Prince and [`aim_in_air`] searches the angles.
//!
//! What cannot be reached is an answer too ([`Reach::No`]): how near a shot can come, and where.
//! Source: the lecture.

mod aim;
mod aim_air;
mod air;
mod roots;

pub use aim::{
    Angles, Miss, Reach, Shot, Shots, Target, aim, angle_for_height, angles_for_range, lead, slowest,
};
pub use aim_air::aim_in_air;
pub use air::{Air, Flight, Lift, angle_for_height_in_air, farthest_in_air, fly};

use crate::error::{Result, check, finite, finite_vector};
use crate::kinematics::constant_acceleration;
use jounce_math::DVec3;
use jounce_math::scalar::f64s::max;

/// A moment of a flight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Event {
    /// Since the launch, s.
    pub time: f64,
    /// Position, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
}

impl Event {
    fn is_finite(&self) -> bool {
        self.time.is_finite() && self.position.is_finite() && self.velocity.is_finite()
    }
}

/// A projectile at its launch.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::ballistics::Projectile;
/// // 30 m/s at 45°.
/// let v = 30.0 * 0.5f64.sqrt();
/// let ball = Projectile::new(DVec3::ZERO, DVec3::new(v, v, 0.0), DVec3::Y * -9.81)?;
/// assert!((ball.level_range() - 91.743).abs() < 1e-3);
/// assert!((ball.apex().position.y - 22.936).abs() < 1e-3);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projectile {
    position: DVec3,
    velocity: DVec3,
    gravity: DVec3,
}

impl Projectile {
    /// Launched at `position` in m with `velocity` in m/s, under `gravity` in m/s² of any direction.
    ///
    /// # Errors
    /// [`Error::BadValue`](crate::Error::BadValue) for vectors that are not finite, a gravity of zero, or a flight whose
    /// apex no `f64` can hold.
    pub fn new(position: DVec3, velocity: DVec3, gravity: DVec3) -> Result<Self> {
        finite_vector("projectile", "position", position)?;
        finite_vector("projectile", "velocity", velocity)?;
        check_gravity(gravity)?;
        let p = Self { position, velocity, gravity };
        let apex = p.apex();
        let usable = apex.is_finite() && p.level_range().is_finite();
        let expected = "a speed whose flight under this gravity stays within what f64 can hold";
        check(usable, "projectile", "velocity", velocity.to_array(), expected)?;
        Ok(p)
    }

    /// Position at the launch, m.
    pub fn start(&self) -> DVec3 {
        self.position
    }
    /// Velocity at the launch, m/s.
    pub fn launch_velocity(&self) -> DVec3 {
        self.velocity
    }
    /// Gravity, m/s².
    pub fn gravity(&self) -> DVec3 {
        self.gravity
    }
    /// Unit vector against gravity.
    pub fn up(&self) -> DVec3 {
        up(self.gravity)
    }

    /// Where it is `t` s after the launch, in vacuum.
    pub fn at(&self, t: f64) -> Event {
        let (position, velocity) = constant_acceleration(self.position, self.velocity, self.gravity, t);
        Event { time: t, position, velocity }
    }

    /// Highest point in vacuum: after v_y/g, or at the launch where it is not thrown upwards.
    pub fn apex(&self) -> Event {
        self.at(max(self.velocity.dot(self.up()) / self.gravity.length(), 0.0))
    }

    /// Horizontal distance in m until it is back at the height of its launch, in vacuum: 2 v_x v_y/g; 0 where it is not
    /// thrown upwards.
    pub fn level_range(&self) -> f64 {
        let up = self.up();
        let rise = self.velocity.dot(up);
        let forward = (self.velocity - up * rise).length();
        2.0 * forward * max(rise, 0.0) / self.gravity.length()
    }

    /// When it comes down to `height` in m above its launch, in vacuum; `None` where it never is so high.
    ///
    /// ```
    /// use jounce_math::DVec3;
    /// use jounce_motion::ballistics::Projectile;
    /// let ball = Projectile::new(DVec3::ZERO, DVec3::new(3.0, 10.0, 0.0), DVec3::Y * -10.0)?;
    /// let down = ball.falls_to(-15.0)?.expect("it falls");
    /// assert_eq!((down.time, down.position), (3.0, DVec3::new(9.0, -15.0, 0.0)));
    /// assert!(ball.falls_to(5.1)?.is_none());
    /// # Ok::<(), jounce_motion::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::BadValue`](crate::Error::BadValue) for a height that is not finite, or a fall that no `f64` can hold.
    pub fn falls_to(&self, height: f64) -> Result<Option<Event>> {
        finite("projectile", "height", height)?;
        let (rise, g) = (self.velocity.dot(self.up()), self.gravity.length());
        // h = v t − ½ g t², the later of its two times.
        let under = rise * rise - 2.0 * g * height;
        if under < 0.0 {
            return Ok(None);
        }
        let root = under.sqrt();
        // Without cancellation: (v + √)/g, or, for a throw downwards, 2h/(v − √).
        let t = if rise >= 0.0 { (rise + root) / g } else { 2.0 * height / (rise - root) };
        if t < 0.0 {
            return Ok(None);
        }
        let e = self.at(t);
        let expected = "a height whose fall stays within what f64 can hold";
        check(t >= 0.0 && e.is_finite(), "projectile", "height", height, expected)?;
        Ok(Some(e))
    }
}

pub(crate) fn up(gravity: DVec3) -> DVec3 {
    (-gravity).normalize_or(DVec3::Y)
}

pub(crate) fn check_gravity(gravity: DVec3) -> Result<()> {
    let usable = gravity.is_finite() && (1e-150..1e150).contains(&gravity.length());
    let expected = "a finite vector of 1e-150 to 1e150 m/s²";
    check(usable, "projectile", "gravity", gravity.to_array(), expected)
}
