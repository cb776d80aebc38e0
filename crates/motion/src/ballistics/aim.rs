//! Aiming in vacuum.
//!
//! A target at d + u t + ½ a t² is met by a shot of speed s when |d + u t + ½ (a − g) t²| = s t: a polynomial of fourth
//! degree in t, whose every positive root is a shot. Without a motion of the target it is one of second degree in t²,
//! solved in closed form. What lies beyond the parabola of safety, y = H − x²/4H with H = s²/2g, cannot be reached; the
//! nearest point that can lies on it, and is touched by the shot of tan α = 2H/x.

use super::roots::{bisect, real_roots};
use super::{check_gravity, up};
use crate::error::{Result, bad, check, finite_vector, positive};
use core::f64::consts::FRAC_PI_2;
use jounce_math::DVec3;
use jounce_math::scalar::f64s::{asin, atan2, clamp, max, min};

/// An answer, or how near one can come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach<T> {
    /// It can be done, like this.
    Yes(T),
    /// It cannot be done; this comes nearest.
    No(Miss),
}

impl<T> Reach<T> {
    /// The answer, if there is one.
    pub fn yes(self) -> Option<T> {
        match self {
            Self::Yes(answer) => Some(answer),
            Self::No(_) => None,
        }
    }

    /// The nearest approach, if there is no answer.
    pub fn no(self) -> Option<Miss> {
        match self {
            Self::Yes(_) => None,
            Self::No(miss) => Some(miss),
        }
    }
}

/// The shot that comes nearest to what cannot be reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Miss {
    /// Distance that is left, m.
    pub distance: f64,
    /// The shot.
    pub shot: Shot,
    /// Where the projectile is then, from the launch, m.
    pub closest: DVec3,
    /// Least speed that would do, m/s, where it is known.
    pub speed_needed: Option<f64>,
}

/// A way to launch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shot {
    /// Launch velocity, m/s.
    pub velocity: DVec3,
    /// Launch angle above the horizontal, rad.
    pub angle: f64,
    /// From the launch to the target, s.
    pub time: f64,
}

impl Shot {
    pub(super) fn new(velocity: DVec3, up: DVec3, time: f64) -> Self {
        let rise = velocity.dot(up);
        Self { velocity, angle: atan2(rise, (velocity - up * rise).length()), time }
    }
}

/// The two shots at a target that does not move; the same one where the speed is just enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shots {
    /// The flat one, which arrives first.
    pub low: Shot,
    /// The steep one.
    pub high: Shot,
}

/// Two launch angles above the horizontal, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angles {
    /// The flat one.
    pub low: f64,
    /// The steep one.
    pub high: f64,
}

/// An answer whose every number is one; else the question is refused, by its numbers.
trait Usable: Sized {
    fn is_finite(&self) -> bool;

    /// `fields` names the numbers that were given, in their order.
    fn checked(self, fields: &'static str, given: impl core::fmt::Debug) -> Result<Self> {
        let expected = "numbers whose squares and products f64 can hold";
        check(self.is_finite(), "projectile", fields, given, expected)?;
        Ok(self)
    }
}

impl Usable for f64 {
    fn is_finite(&self) -> bool {
        f64::is_finite(*self)
    }
}

impl Usable for Shot {
    fn is_finite(&self) -> bool {
        self.velocity.is_finite() && self.angle.is_finite() && self.time.is_finite()
    }
}

impl Usable for Shots {
    fn is_finite(&self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }
}

impl Usable for Angles {
    fn is_finite(&self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }
}

impl Usable for Vec<Shot> {
    fn is_finite(&self) -> bool {
        self.iter().all(Usable::is_finite)
    }
}

impl<T: Usable> Usable for Reach<T> {
    fn is_finite(&self) -> bool {
        match self {
            Self::Yes(answer) => answer.is_finite(),
            Self::No(m) => {
                let needed = m.speed_needed.is_none_or(f64::is_finite);
                needed && m.distance.is_finite() && m.closest.is_finite() && m.shot.is_finite()
            }
        }
    }
}

/// Something to hit, as seen from the launch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target {
    /// Position at the moment of the launch, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Acceleration, m/s²; the gravity itself for something that falls.
    pub acceleration: DVec3,
}

impl Target {
    /// One that stays where it is.
    pub fn fixed(position: DVec3) -> Self {
        Self { position, ..Self::default() }
    }

    /// One of constant velocity.
    pub fn moving(position: DVec3, velocity: DVec3) -> Self {
        Self { position, velocity, ..Self::default() }
    }

    /// Where it is `t` s after the launch, m.
    pub fn at(&self, t: f64) -> DVec3 {
        self.position + self.velocity * t + self.acceleration * (0.5 * t * t)
    }

    pub(super) fn check(&self) -> Result<()> {
        finite_vector("target", "position", self.position)?;
        finite_vector("target", "velocity", self.velocity)?;
        finite_vector("target", "acceleration", self.acceleration)?;
        let d = self.position;
        check(d.length() > 0.0, "target", "position", d.to_array(), "a point apart from the launch")
    }
}

/// Both launch angles for a `range` in m on level ground: ½ asin(r g/s²) and its complement, at `speed` s in m/s and
/// gravity `g` in m/s². Beyond s²/g the answer is the shot at 45°, in the plane of x forward and y up.
///
/// ```
/// use jounce_motion::ballistics::angles_for_range;
/// let both = angles_for_range(30.0, 60.0, 9.81)?.yes().expect("within 91.7 m");
/// assert!((both.low.to_degrees() - 20.422).abs() < 1e-3);
/// assert!((both.high.to_degrees() - 69.578).abs() < 1e-3);
/// let short = angles_for_range(30.0, 100.0, 9.81)?.no().expect("too far");
/// assert!((short.distance - 8.257).abs() < 1e-3);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// [`Error::BadValue`](crate::Error::BadValue) for a speed or gravity not above 0, or a range below 0.
pub fn angles_for_range(speed: f64, range: f64, g: f64) -> Result<Reach<Angles>> {
    positive("projectile", "speed", speed)?;
    crate::error::not_negative("projectile", "range", range)?;
    positive("projectile", "gravity", g)?;
    let farthest = speed * speed / g;
    let sine = range / farthest;
    // A range computed from a launch at 45° may come out above the farthest by its rounding.
    if sine > 1.0 + 4.0 * f64::EPSILON {
        let half = speed * 0.5f64.sqrt();
        let velocity = DVec3::new(half, half, 0.0);
        return Reach::No(Miss {
            distance: range - farthest,
            shot: Shot { velocity, angle: 0.5 * FRAC_PI_2, time: 2.0 * half / g },
            closest: DVec3::X * farthest,
            speed_needed: Some((range * g).sqrt()),
        })
        .checked("range, speed, gravity", (range, speed, g));
    }
    let low = 0.5 * asin(clamp(sine, 0.0, 1.0));
    Reach::Yes(Angles { low, high: FRAC_PI_2 - low }).checked("range, speed, gravity", (range, speed, g))
}

/// Launch angle in rad whose apex is `height` in m above the launch: asin(√(2 g h)/s). Above s²/2g the answer is the
/// shot straight up, in the plane of x forward and y up.
///
/// ```
/// let angle = jounce_motion::ballistics::angle_for_height(20.0, 5.0, 10.0)?.yes().expect("within 20 m");
/// assert!((angle.to_degrees() - 30.0).abs() < 1e-12);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// [`Error::BadValue`](crate::Error::BadValue) for a speed or gravity not above 0, or a height below 0.
pub fn angle_for_height(speed: f64, height: f64, g: f64) -> Result<Reach<f64>> {
    positive("projectile", "speed", speed)?;
    crate::error::not_negative("projectile", "height", height)?;
    positive("projectile", "gravity", g)?;
    let needed = (2.0 * g * height).sqrt();
    let sine = needed / speed;
    if sine > 1.0 + 4.0 * f64::EPSILON {
        let highest = speed * speed / (2.0 * g);
        return Reach::No(Miss {
            distance: height - highest,
            shot: Shot { velocity: DVec3::Y * speed, angle: FRAC_PI_2, time: speed / g },
            closest: DVec3::Y * highest,
            speed_needed: Some(needed),
        })
        .checked("height, speed, gravity", (height, speed, g));
    }
    Reach::Yes(asin(clamp(sine, 0.0, 1.0))).checked("height, speed, gravity", (height, speed, g))
}

/// Both shots at a fixed target, at `to_target` in m from the launch, with `speed` in m/s under `gravity` in m/s². Without
/// gravity both are the straight one.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::ballistics::{aim, Projectile};
/// let (target, g) = (DVec3::new(30.0, 10.0, -20.0), DVec3::Y * -9.81);
/// let shots = aim(target, 25.0, g)?.yes().expect("near enough");
/// for shot in [shots.low, shots.high] {
///     let hit = Projectile::new(DVec3::ZERO, shot.velocity, g)?.at(shot.time);
///     assert!((hit.position - target).length() < 1e-12);
/// }
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// [`Error::BadValue`](crate::Error::BadValue) for a target at the launch, a speed not above 0, or numbers that are not
/// finite.
pub fn aim(to_target: DVec3, speed: f64, gravity: DVec3) -> Result<Reach<Shots>> {
    positive("projectile", "speed", speed)?;
    finite_vector("projectile", "gravity", gravity)?;
    Target::fixed(to_target).check()?;
    let (d, g) = (to_target.length(), gravity.length());
    let drop = to_target.dot(gravity);
    let b = speed * speed + drop;
    // Within rounding of the parabola of safety counts as on it.
    let edge = 8.0 * f64::EPSILON * (speed * speed + drop.abs() + g * d);
    if b - g * d < -edge {
        let miss = nearest_on_parabola(to_target, speed, gravity);
        return Reach::No(miss)
            .checked("speed, target, gravity", (speed, to_target.to_array(), gravity.to_array()));
    }
    let root = (max(b - g * d, 0.0) * max(b + g * d, 0.0)).sqrt();
    let shot = |t: f64| Shot::new(to_target / t - gravity * (0.5 * t), up(gravity), t);
    // Their product is 4 d²/g⁴: the smaller one without its cancellation.
    let low = shot((2.0 / (b + root)).sqrt() * d);
    let high = if g > 0.0 { shot((2.0 * (b + root)).sqrt() / g) } else { low };
    Reach::Yes(Shots { low, high })
        .checked("speed, target, gravity", (speed, to_target.to_array(), gravity.to_array()))
}

/// The point of the parabola of safety that is nearest to a target beyond it, and the shot that touches it.
fn nearest_on_parabola(target: DVec3, speed: f64, gravity: DVec3) -> Miss {
    let (up, g) = (up(gravity), gravity.length());
    let y = target.dot(up);
    let flat = target - up * y;
    let (forward, x) = flat.try_normalize().unwrap_or((up.orthonormal_basis().0, 0.0));
    let h = speed * speed / (2.0 * g);
    // The distance is stationary where this is zero; it is below or at zero for 0, and above or at zero for x.
    let slope = |e: f64| e * e * e / (8.0 * h * h) + 0.5 * e * (1.0 + y / h) - x;
    let e = if x > 0.0 { bisect(0.0, x, true, |e| slope(e) < 0.0) } else { 0.0 };
    let closest = forward * e + up * (h - e * e / (4.0 * h));
    let long = (e * e + 4.0 * h * h).sqrt();
    let velocity = (forward * (e / long) + up * (2.0 * h / long)) * speed;
    Miss {
        distance: (target - closest).length(),
        shot: Shot::new(velocity, up, long / speed),
        closest,
        speed_needed: Some(least_speed(target, gravity)),
    }
}

fn least_speed(d: DVec3, gravity: DVec3) -> f64 {
    max(gravity.length() * d.length() - d.dot(gravity), 0.0).sqrt()
}

/// The slowest shot that reaches a fixed target: s² = |g||d| − d·g. Straight below, it is to let go.
///
/// ```
/// use jounce_math::DVec3;
/// // On level ground at 45°: s = √(r g).
/// let shot = jounce_motion::ballistics::slowest(DVec3::X * 40.0, DVec3::Y * -10.0)?;
/// assert!((shot.velocity - DVec3::new(200f64.sqrt(), 200f64.sqrt(), 0.0)).length() < 1e-12);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// [`Error::BadValue`](crate::Error::BadValue) for a target at the launch, no gravity, or numbers that are not finite.
pub fn slowest(to_target: DVec3, gravity: DVec3) -> Result<Shot> {
    check_gravity(gravity)?;
    Target::fixed(to_target).check()?;
    let t = (2.0 * to_target.length() / gravity.length()).sqrt();
    let shot = Shot::new(to_target / t - gravity * (0.5 * t), up(gravity), t);
    shot.checked("target, gravity", (to_target.to_array(), gravity.to_array()))
}

/// All shots of `speed` in m/s that meet a moving target, the earliest first: up to four.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::ballistics::{lead, Projectile, Target};
/// let g = DVec3::Y * -9.81;
/// let plane = Target::moving(DVec3::new(200.0, 80.0, 50.0), DVec3::new(-30.0, 0.0, 10.0));
/// let shots = lead(&plane, 100.0, g)?.yes().expect("it can be met");
/// for shot in &shots {
///     let hit = Projectile::new(DVec3::ZERO, shot.velocity, g)?.at(shot.time);
///     assert!((hit.position - plane.at(shot.time)).length() < 1e-9);
/// }
/// assert!(shots.len() == 2 && shots[0].time < shots[1].time);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// [`Error::BadValue`](crate::Error::BadValue) for a target at the launch, a speed not above 0, or numbers that are not
/// finite.
pub fn lead(target: &Target, speed: f64, gravity: DVec3) -> Result<Reach<Vec<Shot>>> {
    positive("projectile", "speed", speed)?;
    finite_vector("projectile", "gravity", gravity)?;
    target.check()?;
    // In units of the time a straight shot takes to where the target is now, so that no coefficient is extreme.
    let scale = target.position.length() / speed;
    // Its fourth power counts below.
    let expected = "above 1e-75 of the target's distance a second";
    check(scale < 1e75, "projectile", "speed", speed, expected)?;
    let (d, u) = (target.position, target.velocity * scale);
    let c = (target.acceleration - gravity) * (scale * scale);
    // |d + u z + ½ c z²|² = Q(z), and the shot covers s·scale·z = |d| z.
    let q = [d.dot(d), 2.0 * d.dot(u), u.dot(u) + d.dot(c), u.dot(c), 0.25 * c.dot(c)].map(|q| q / d.dot(d));
    let mut meets = q;
    meets[2] -= 1.0;
    if meets.iter().any(|m| !m.is_finite()) {
        return Err(bad("target", "motion", target, "speeds and distances whose squares are finite"));
    }
    let up = up(gravity);
    let shot = |z: f64| {
        let t = z * scale;
        Shot::new((target.at(t) - gravity * (0.5 * t * t)) / t, up, t)
    };
    let roots = real_roots(&meets, bound(&meets));
    let shots: Vec<Shot> = roots.into_iter().filter(|&z| z > 0.0).map(shot).collect();
    if !shots.is_empty() {
        return Reach::Yes(shots).checked("speed, target, gravity", (speed, target, gravity.to_array()));
    }
    let miss: Reach<Vec<Shot>> = Reach::No(nearest_meeting(target, speed, gravity, &q, scale));
    miss.checked("speed, target, gravity", (speed, target, gravity.to_array()))
}

/// A number above every positive root (Cauchy), as far as it matters: times are in units of a straight shot's.
fn bound(c: &[f64]) -> f64 {
    let Some(n) = c.iter().rposition(|c| *c != 0.0) else { return 0.0 };
    let largest = c[..n].iter().fold(0.0, |m, x| max(m, (x / c[n]).abs()));
    min(1.0 + largest, 1e18)
}

/// The shot that comes nearest to a target that it never meets. At a time t the projectile can be anywhere at s t from
/// where it would have fallen to, hence √Q(z) − z is what is left, and it is least where Q′ = 2 √Q, or at once.
fn nearest_meeting(target: &Target, speed: f64, gravity: DVec3, q: &[f64; 5], scale: f64) -> Miss {
    let slope = [q[1], 2.0 * q[2], 3.0 * q[3], 4.0 * q[4]];
    // Q′² − 4 Q, whose roots include those of Q′ = −2 √Q; they only cost a look.
    let mut stationary = [0.0; 7];
    for (i, a) in slope.iter().enumerate() {
        for (j, b) in slope.iter().enumerate() {
            stationary[i + j] += a * b;
        }
    }
    for (i, q) in q.iter().enumerate() {
        stationary[i] -= 4.0 * q;
    }
    let left = |z: f64| max(q.iter().rev().fold(0.0, |s, c| s * z + c), 0.0).sqrt() - z;
    let mut best = 0.0;
    // A target that flees at the shot's own speed is only approached for ever: hence a last look far out.
    let far = if q[3] == 0.0 && q[4] == 0.0 { Some(1e6) } else { None };
    for z in real_roots(&stationary, bound(&stationary)).into_iter().chain(far) {
        if left(z) < left(best) {
            best = z;
        }
    }
    let t = best * scale;
    let free = gravity * (0.5 * t * t);
    let direction = (target.at(t) - free).normalize_or(up(gravity));
    let closest = direction * (speed * t) + free;
    let still = target.velocity == DVec3::ZERO && target.acceleration == DVec3::ZERO;
    Miss {
        distance: (target.at(t) - closest).length(),
        shot: Shot::new(direction * speed, up(gravity), t),
        closest,
        speed_needed: if still { Some(least_speed(target.position, gravity)) } else { None },
    }
}
