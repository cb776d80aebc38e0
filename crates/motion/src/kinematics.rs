//! Motion without its causes.
//!
//! | motion | equation |
//! |---|---|
//! | constant velocity | P(t) = P₀ + v t |
//! | constant acceleration | v(t) = v₀ + a t, P(t) = P₀ + v₀ t + ½ a t² |
//! | varying velocity | P(t) = P₀ + ∫ v dt |
//! | varying acceleration | v(t) = v₀ + ∫ a dt, P(t) = P₀ + v₀ t + ∫ (t − s) a(s) ds |
//! | the other way | v = dP/dt, a = dv/dt = d²P/dt² |
//!
//! P position, m; v velocity, m/s; a acceleration, m/s²; t time since the start, s. The last form of P is Cauchy's for
//! an integral taken twice. Integrals are Gauss–Kronrod sums (7 and 15 points) on intervals that are halved where the
//! two disagree; derivatives are central differences, extrapolated once after Richardson.
//! Source: the lecture; R. Piessens et al., *QUADPACK* (1983).

use crate::error::{Result, check, finite, positive};
use crate::limits::INTERVALS_MAX;
use jounce_math::DVec3;
use jounce_math::scalar::f64s::max;

/// Position after `t` s at constant velocity: P₀ + v t.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::kinematics::constant_velocity;
/// assert_eq!(constant_velocity(DVec3::X, DVec3::Y * 2.0, 3.0), DVec3::new(1.0, 6.0, 0.0));
/// ```
#[inline]
pub fn constant_velocity(p0: DVec3, v: DVec3, t: f64) -> DVec3 {
    p0 + v * t
}

/// Position and velocity after `t` s at constant acceleration: P₀ + v₀ t + ½ a t² and v₀ + a t.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::kinematics::constant_acceleration;
/// let (p, v) = constant_acceleration(DVec3::ZERO, DVec3::X, DVec3::Y * -10.0, 2.0);
/// assert_eq!((p, v), (DVec3::new(2.0, -20.0, 0.0), DVec3::new(1.0, -20.0, 0.0)));
/// ```
#[inline]
pub fn constant_acceleration(p0: DVec3, v0: DVec3, a: DVec3, t: f64) -> (DVec3, DVec3) {
    (p0 + v0 * t + a * (0.5 * t * t), v0 + a * t)
}

/// An integral and what is known of its error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Integral {
    /// The value.
    pub value: DVec3,
    /// Estimated error, in the unit of the value. Above the tolerance where
    /// [`INTERVALS_MAX`] intervals were not enough.
    pub error: f64,
}

/// Displacement in m from `t0` to `t1` in s: the integral of the velocity, to `tolerance` in m.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::kinematics::displacement;
/// // v = 3 t²: the displacement in 2 s is 8 m.
/// let s = displacement(|t| DVec3::X * (3.0 * t * t), 0.0, 2.0, 1e-9)?;
/// assert!((s.value.x - 8.0).abs() < 1e-12);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// [`Error::BadValue`](crate::Error::BadValue) for times that are not finite, a tolerance not above 0, or a velocity that
/// is not finite somewhere.
pub fn displacement(velocity: impl Fn(f64) -> DVec3, t0: f64, t1: f64, tolerance: f64) -> Result<Integral> {
    integral("displacement", "velocity", velocity, t0, t1, tolerance)
}

/// Change of velocity in m/s from `t0` to `t1` in s: the integral of the acceleration, to `tolerance` in m/s.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::kinematics::velocity_change;
/// let dv = velocity_change(|t| DVec3::Y * t, 0.0, 4.0, 1e-9)?;
/// assert!((dv.value.y - 8.0).abs() < 1e-12);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// As [`displacement`].
pub fn velocity_change(
    acceleration: impl Fn(f64) -> DVec3,
    t0: f64,
    t1: f64,
    tolerance: f64,
) -> Result<Integral> {
    integral("velocity_change", "acceleration", acceleration, t0, t1, tolerance)
}

/// Position in m and velocity in m/s after `t` s from `p0` and `v0`, under an acceleration that varies with time.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::kinematics::varying_acceleration;
/// // a = 6 t: v = 3 t², P = t³.
/// let (p, v) = varying_acceleration(DVec3::ZERO, DVec3::ZERO, |t| DVec3::X * (6.0 * t), 2.0, 1e-9)?;
/// assert!((p.x - 8.0).abs() < 1e-12 && (v.x - 12.0).abs() < 1e-12);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// As [`displacement`].
pub fn varying_acceleration(
    p0: DVec3,
    v0: DVec3,
    acceleration: impl Fn(f64) -> DVec3,
    t: f64,
    tolerance: f64,
) -> Result<(DVec3, DVec3)> {
    let what = "varying_acceleration";
    let dv = integral(what, "acceleration", &acceleration, 0.0, t, tolerance)?;
    let bend = integral(what, "acceleration", |s| acceleration(s) * (t - s), 0.0, t, tolerance)?;
    Ok((p0 + v0 * t + bend.value, v0 + dv.value))
}

/// Velocity in m/s at `t` s of a position given as a function of time: dP/dt. `scale` in s is the time over which the
/// motion changes its character (a period, the length of a manoeuvre); the relative error is about 1e-12.
///
/// ```
/// use jounce_math::DVec3;
/// let v = jounce_motion::kinematics::velocity_of(|t| DVec3::X * (t * t * t), 2.0, 1.0);
/// assert!((v.x - 12.0).abs() < 1e-9);
/// ```
pub fn velocity_of(position: impl Fn(f64) -> DVec3, t: f64, scale: f64) -> DVec3 {
    // Truncation h⁴ against rounding ε/h: h = ε^{1/5}.
    let h = 7e-4 * scale;
    let slope = |h: f64| (position(t + h) - position(t - h)) / (2.0 * h);
    (slope(0.5 * h) * 4.0 - slope(h)) / 3.0
}

/// Acceleration in m/s² at `t` s of a position given as a function of time: d²P/dt². `scale` as in [`velocity_of`]; the
/// relative error is about 1e-10.
///
/// ```
/// use jounce_math::DVec3;
/// let a = jounce_motion::kinematics::acceleration_of(|t| DVec3::X * (t * t * t), 2.0, 1.0);
/// assert!((a.x - 12.0).abs() < 1e-7);
/// ```
pub fn acceleration_of(position: impl Fn(f64) -> DVec3, t: f64, scale: f64) -> DVec3 {
    // Truncation h⁴ against rounding ε/h²: h = ε^{1/6}.
    let h = 2.5e-3 * scale;
    let bend = |h: f64| (position(t + h) - position(t) * 2.0 + position(t - h)) / (h * h);
    (bend(0.5 * h) * 4.0 - bend(h)) / 3.0
}

/// Nodes of Kronrod's rule on 0…1 of the half interval; the odd ones are Gauss's.
const NODES: [f64; 8] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
    0.0,
];
const KRONROD: [f64; 8] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_55,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_4,
    0.204_432_940_075_298_9,
    0.209_482_141_084_727_83,
];
const GAUSS: [f64; 4] =
    [0.129_484_966_168_869_7, 0.279_705_391_489_276_64, 0.381_830_050_505_118_94, 0.417_959_183_673_469_4];

/// Kronrod's sum on [a, b], and how far Gauss's is from it.
fn kronrod(f: &impl Fn(f64) -> DVec3, a: f64, b: f64) -> (DVec3, f64) {
    let (mid, half) = (0.5 * (a + b), 0.5 * (b - a));
    let (mut fine, mut coarse) = (DVec3::ZERO, DVec3::ZERO);
    for (i, &x) in NODES.iter().enumerate() {
        let at = if x == 0.0 { f(mid) } else { f(mid - half * x) + f(mid + half * x) };
        fine += at * KRONROD[i];
        if i % 2 == 1 {
            coarse += at * GAUSS[i / 2];
        }
    }
    (fine * half, ((fine - coarse) * half).length())
}

/// ∫ f dt. Intervals are finished from the left; one whose error is above its share is halved.
fn integral(
    what: &'static str,
    field: &'static str,
    f: impl Fn(f64) -> DVec3,
    t0: f64,
    t1: f64,
    tolerance: f64,
) -> Result<Integral> {
    finite(what, "start", t0)?;
    finite(what, "end", t1)?;
    positive(what, "tolerance", tolerance)?;
    let mut sum = Integral::default();
    // Halving the rightmost ones first keeps the list of waiting intervals as short as the depth.
    let mut waiting = vec![(t0, t1)];
    let mut used = 0;
    while let Some((a, b)) = waiting.pop() {
        let (value, error) = kronrod(&f, a, b);
        check(value.is_finite(), what, field, value.to_array(), "a finite value at every time")?;
        used += 1;
        let share = tolerance * ((b - a) / (t1 - t0)).abs();
        // Below this the two sums differ by rounding only.
        let floor = 1e-14 * value.length();
        let mid = 0.5 * (a + b);
        let splits = a != mid && mid != b && used + waiting.len() < INTERVALS_MAX;
        if error <= max(share, floor) || t0 == t1 || !splits {
            sum.value += value;
            sum.error += error;
        } else {
            waiting.push((mid, b));
            waiting.push((a, mid));
        }
    }
    Ok(sum)
}
