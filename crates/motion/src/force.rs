//! Force laws as pure functions.
//!
//! | law | equation |
//! |---|---|
//! | uniform gravity | F = m g |
//! | universal gravitation | F = G m₁ m₂ r / (r² + ε²)^{3/2}, r towards the other body, ε the softening length |
//! | buoyancy | F = −ρ_f V g |
//! | Stokes drag | F = −b v, b = 6 π η r |
//! | quadratic drag | F = −c \|v\| v, c = ½ ρ A C_d |
//! | Magnus | F = k ω × v |
//! | kinetic friction | F = −μ_k N v̂ |
//! | static friction | F = −F_t while \|F_t\| ≤ μ_s N |
//! | spring | F = −(K_s (\|x\| − L) + c v·x̂) x̂ |
//! | rotation | F = m ω×(ω×r) inwards; in the rotating frame −m ω×(ω×r), −2 m ω×v, −m α×r |
//!
//! Velocities of drag and lift are those of the body *relative to the fluid*. Units are SI throughout. A number that is
//! not finite comes out as one that is not finite: whoever owns the body checks it. Where a direction is undefined
//! (coincident points, no slip), the force is zero.

use core::f64::consts::PI;
use jounce_math::DVec3;
use jounce_math::scalar::f64s::{atan2, max};

/// Gravitational constant, m³/(kg s²) (CODATA 2018 and 2022).
pub const G: f64 = 6.674_30e-11;
/// Gravitational constant as the lecture prints it, m³/(kg s²) (CODATA 1998).
pub const G_LECTURE: f64 = 6.673e-11;
/// Standard acceleration of free fall, m/s² (3rd CGPM, 1901).
pub const STANDARD_GRAVITY: f64 = 9.806_65;
/// Density of dry air at 20 °C and 101 kPa, kg/m³, as textbooks round it.
pub const AIR_DENSITY: f64 = 1.2;
/// Dynamic viscosity of dry air at 20 °C, Pa s.
pub const AIR_VISCOSITY: f64 = 1.81e-5;
/// Density of water at 20 °C, kg/m³.
pub const WATER_DENSITY: f64 = 998.2;
/// Dynamic viscosity of water at 20 °C, Pa s.
pub const WATER_VISCOSITY: f64 = 1.002e-3;

/// Weight in a uniform field: m g, in newtons. `mass` in kg, `g` in m/s².
///
/// ```
/// use jounce_math::DVec3;
/// let weight = jounce_motion::force::uniform_gravity(2.0, DVec3::new(0.0, -9.8, 0.0));
/// assert_eq!(weight, DVec3::new(0.0, -19.6, 0.0));
/// ```
#[inline]
pub fn uniform_gravity(mass: f64, g: DVec3) -> DVec3 {
    g * mass
}

/// Universal gravitation: the force on body 1, in newtons, towards body 2.
///
/// `g` is the gravitational constant ([`G`], [`G_LECTURE`], or 1 in natural units), masses in kg, `to_other` the vector
/// from body 1 to body 2 in m, `softening` the Plummer length ε in m (0: point masses). Coincident points pull nothing.
/// Swapping the bodies gives the opposite force to the bit.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::force::{G, gravitation};
/// let f = gravitation(G, 1000.0, 2000.0, DVec3::new(10.0, 0.0, 0.0), 0.0);
/// assert!((f.x - G * 1000.0 * 2000.0 / 100.0).abs() < 1e-20);
/// ```
#[inline]
pub fn gravitation(g: f64, mass_1: f64, mass_2: f64, to_other: DVec3, softening: f64) -> DVec3 {
    let s = (to_other.length_squared() + softening * softening).sqrt();
    if s == 0.0 {
        return DVec3::ZERO;
    }
    // Divided one by one: s³ would overflow beyond 1e102 m and underflow below 1e-108 m.
    to_other / s * (g * (mass_1 * mass_2) / s / s)
}

/// Buoyancy by Archimedes: −ρ_f V g, in newtons, for a displaced `volume` in m³ of a fluid of `fluid_density` in kg/m³
/// in a field `gravity` in m/s².
///
/// ```
/// use jounce_math::DVec3;
/// let f = jounce_motion::force::buoyancy(1000.0, 0.5, DVec3::new(0.0, -10.0, 0.0));
/// assert_eq!(f, DVec3::new(0.0, 5000.0, 0.0));
/// ```
#[inline]
pub fn buoyancy(fluid_density: f64, volume: f64, gravity: DVec3) -> DVec3 {
    gravity * -(fluid_density * volume)
}

/// Coefficient of Stokes drag on a small slow sphere: b = 6 π η r, in kg/s. `viscosity` η in Pa s, `radius` in m.
///
/// Holds for Reynolds numbers below about 1.
///
/// ```
/// // A steel ball of 1 mm in glycerin: it falls at (weight − buoyancy)/b.
/// let b = jounce_motion::force::stokes_coefficient(1.41, 0.001);
/// let net = (7800.0 - 1260.0) * 4.0 / 3.0 * std::f64::consts::PI * 1e-9 * 9.81;
/// assert!((net / b - 0.010_111_5).abs() < 1e-7);
/// ```
#[inline]
pub fn stokes_coefficient(viscosity: f64, radius: f64) -> f64 {
    6.0 * PI * viscosity * radius
}

/// Drag at low speed: −b v, in newtons. `b` in kg/s, `velocity` relative to the fluid in m/s.
///
/// ```
/// use jounce_math::DVec3;
/// let f = jounce_motion::force::stokes_drag(0.5, DVec3::new(4.0, 0.0, 0.0));
/// assert_eq!(f, DVec3::new(-2.0, 0.0, 0.0));
/// ```
#[inline]
pub fn stokes_drag(b: f64, velocity: DVec3) -> DVec3 {
    velocity * -b
}

/// Coefficient of quadratic drag: c = ½ ρ A C_d, in kg/m, so that the force is −c |v| v.
///
/// `density` of the fluid in kg/m³, reference `area` in m², `drag_coefficient` without unit.
///
/// ```
/// let c = jounce_motion::force::quadratic_coefficient(1.2, 0.5, 0.5);
/// assert!((c - 0.15).abs() < 1e-15);
/// ```
#[inline]
pub fn quadratic_coefficient(density: f64, area: f64, drag_coefficient: f64) -> f64 {
    0.5 * density * area * drag_coefficient
}

/// Drag at high speed: −c |v| v, in newtons. `c` in kg/m, `velocity` relative to the fluid in m/s.
///
/// The slide's formula has v² and v·v both, one too many: the force is ½ ρ A C_d (v·v) against v/|v|.
///
/// ```
/// use jounce_math::DVec3;
/// let f = jounce_motion::force::quadratic_drag(0.1, DVec3::new(0.0, -3.0, 4.0));
/// assert!((f - DVec3::new(0.0, 1.5, -2.0)).length() < 1e-15);
/// ```
#[inline]
pub fn quadratic_drag(c: f64, velocity: DVec3) -> DVec3 {
    velocity * -(c * velocity.length())
}

/// The speed at which drag b v + c v² balances a steady `force` in newtons; infinite without drag.
///
/// ```
/// let v = jounce_motion::force::terminal_speed(9.81, 0.0, 9.81 / 400.0);
/// assert!((v - 20.0).abs() < 1e-12);
/// ```
#[inline]
pub fn terminal_speed(force: f64, b: f64, c: f64) -> f64 {
    if force == 0.0 {
        return 0.0;
    }
    2.0 * force / (b + (b * b + 4.0 * c * force).sqrt())
}

/// One implicit step of drag: the velocity v′ in m/s that solves v′ = v + Δt (a − k₁ v′ − k₂ |v′| v′).
///
/// `velocity` is relative to the fluid, `acceleration` is that of all other forces in m/s², `linear` k₁ = b/m in 1/s,
/// `quadratic` k₂ = c/m in 1/m, `dt` in s. With w = v + Δt a and d = 1 + Δt k₁, v′ points along w and
/// Δt k₂ |v′|² + d |v′| − |w| = 0, hence |v′| = 2 |w| / (d + √(d² + 4 Δt k₂ |w|)): the root without cancellation.
///
/// Stable at any step: v′ never turns against w and is never longer, and its fixed point is the exact terminal speed.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::force::implicit_drag;
/// // The step is 1000 times the time constant, and still the ball ends at g/k₁.
/// let g = DVec3::new(0.0, -9.81, 0.0);
/// let mut v = DVec3::ZERO;
/// for _ in 0..20 {
///     v = implicit_drag(v, g, 100.0, 0.0, 10.0);
/// }
/// assert!((v.y + 0.0981).abs() < 1e-12);
/// ```
#[inline]
pub fn implicit_drag(velocity: DVec3, acceleration: DVec3, linear: f64, quadratic: f64, dt: f64) -> DVec3 {
    let w = velocity + acceleration * dt;
    let d = 1.0 + dt * linear;
    w * (2.0 / (d + (d * d + 4.0 * dt * quadratic * w.length()).sqrt()))
}

/// Lift of a spinning body: k ω × v, in newtons. `lift_factor` k in kg, `angular_velocity` in rad/s, `velocity` relative
/// to the fluid in m/s. Backspin lifts.
///
/// ```
/// use jounce_math::DVec3;
/// // Flying along x, the top turning backwards: ω = +z.
/// let f = jounce_motion::force::magnus(0.01, DVec3::Z * 50.0, DVec3::X * 20.0);
/// assert_eq!(f, DVec3::Y * 10.0);
/// ```
#[inline]
pub fn magnus(lift_factor: f64, angular_velocity: DVec3, velocity: DVec3) -> DVec3 {
    angular_velocity.cross(velocity) * lift_factor
}

/// Lift factor of a slowly spinning, slow sphere: k = π ρ r³, in kg (Rubinow and Keller, J. Fluid Mech. 11, 1961).
///
/// ```
/// let k = jounce_motion::force::sphere_lift_factor(1.2, 0.11);
/// assert!((k - 0.005_017_7).abs() < 1e-6);
/// ```
#[inline]
pub fn sphere_lift_factor(density: f64, radius: f64) -> f64 {
    PI * density * radius * radius * radius
}

/// Lift coefficient C_L of a sports ball of spin parameter S = r ω⊥/v: 1.5 S up to S = 0.1, 0.09 + 0.6 S beyond
/// (Sawicki, Hubbard and Stronge, Am. J. Phys. 71, 1152, 2003; fitted to baseballs).
///
/// ```
/// assert!((jounce_motion::force::ball_lift_coefficient(0.2) - 0.21).abs() < 1e-15);
/// ```
#[inline]
pub fn ball_lift_coefficient(spin_parameter: f64) -> f64 {
    if spin_parameter <= 0.1 { 1.5 * spin_parameter } else { 0.09 + 0.6 * spin_parameter }
}

/// Lift of a spinning ball in newtons: ½ ρ A C_L v² along ω × v, with A = π r² and C_L of [`ball_lift_coefficient`].
///
/// `density` of the fluid in kg/m³, `radius` in m, `angular_velocity` in rad/s, `velocity` relative to the fluid in m/s.
/// Only the part of the spin across the flight lifts: S = r |ω × v| / v².
///
/// ```
/// use jounce_math::DVec3;
/// let f = jounce_motion::force::ball_magnus(1.2, 0.11, DVec3::Z * 60.0, DVec3::X * 30.0);
/// assert!(f.y > 4.0 && f.y < 5.0 && f.x == 0.0);
/// ```
#[inline]
pub fn ball_magnus(density: f64, radius: f64, angular_velocity: DVec3, velocity: DVec3) -> DVec3 {
    let v2 = velocity.length_squared();
    let Some((direction, cross)) = angular_velocity.cross(velocity).try_normalize() else {
        return DVec3::ZERO;
    };
    let lift = ball_lift_coefficient(radius * cross / v2);
    direction * (0.5 * density * PI * radius * radius * lift * v2)
}

/// Friction of a sliding contact: −μ_k N against the slip, in newtons. `normal_force` N in newtons (a pull counts as
/// none), `slip` the velocity of the body relative to the surface in m/s. Zero where there is no slip.
///
/// ```
/// use jounce_math::DVec3;
/// let f = jounce_motion::force::kinetic_friction(0.5, 20.0, DVec3::X * 3.0);
/// assert_eq!(f, DVec3::X * -10.0);
/// ```
#[inline]
pub fn kinetic_friction(mu_k: f64, normal_force: f64, slip: DVec3) -> DVec3 {
    slip.normalize_or(DVec3::ZERO) * -(mu_k * max(normal_force, 0.0))
}

/// What static friction does under a load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Friction {
    /// The contact holds with this force in newtons, equal and opposite to the load.
    Holds(DVec3),
    /// The load exceeds μ_s N: static friction is gone, and [`kinetic_friction`] acts.
    Slips,
}

/// Friction of a contact at rest: opposes the `tangential_load` in newtons up to |F| = μ_s N.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::force::{Friction, static_friction};
/// assert_eq!(static_friction(0.5, 20.0, DVec3::X * 9.0), Friction::Holds(DVec3::X * -9.0));
/// assert_eq!(static_friction(0.5, 20.0, DVec3::X * 11.0), Friction::Slips);
/// ```
#[inline]
pub fn static_friction(mu_s: f64, normal_force: f64, tangential_load: DVec3) -> Friction {
    if tangential_load.length() <= mu_s * max(normal_force, 0.0) {
        Friction::Holds(-tangential_load)
    } else {
        Friction::Slips
    }
}

/// The slope in radians at which a body begins to slide: θ = atan μ_s.
///
/// ```
/// let angle = jounce_motion::force::friction_angle(1.0);
/// assert!((angle - std::f64::consts::FRAC_PI_4).abs() < 1e-15);
/// ```
#[inline]
pub fn friction_angle(mu: f64) -> f64 {
    atan2(mu, 1.0)
}

/// Hooke's law with damping along the spring: the force in newtons on the end at offset `x` in m from the other end,
/// moving at `v` in m/s relative to it. The other end feels the opposite.
///
/// `stiffness` K_s in N/m, `damping` in N s/m, `rest_length` in m. Coincident ends have no direction and no force.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::force::spring;
/// assert_eq!(spring(10.0, 0.0, 1.0, DVec3::X * 1.5, DVec3::ZERO), DVec3::X * -5.0);
/// assert_eq!(spring(10.0, 2.0, 1.0, DVec3::X * 1.5, DVec3::X), DVec3::X * -7.0);
/// ```
#[inline]
pub fn spring(stiffness: f64, damping: f64, rest_length: f64, x: DVec3, v: DVec3) -> DVec3 {
    let length = x.length();
    if length == 0.0 {
        return DVec3::ZERO;
    }
    let n = x / length;
    n * -(stiffness * (length - rest_length) + damping * v.dot(n))
}

/// Velocity in m/s of a point at `r` in m from the axis of a body that turns at `omega` in rad/s: ω × r.
///
/// ```
/// use jounce_math::DVec3;
/// assert_eq!(jounce_motion::force::point_velocity(DVec3::Z * 2.0, DVec3::X * 3.0), DVec3::Y * 6.0);
/// ```
#[inline]
pub fn point_velocity(omega: DVec3, r: DVec3) -> DVec3 {
    omega.cross(r)
}

/// Acceleration in m/s² of that point, with the angular acceleration `alpha` in rad/s²: α × r + ω × (ω × r).
///
/// The slide has α and ω exchanged: it is ω that appears twice.
///
/// ```
/// use jounce_math::DVec3;
/// let a = jounce_motion::force::point_acceleration(DVec3::Z, DVec3::Z * 2.0, DVec3::X * 3.0);
/// assert_eq!(a, DVec3::new(-12.0, 3.0, 0.0));
/// ```
#[inline]
pub fn point_acceleration(alpha: DVec3, omega: DVec3, r: DVec3) -> DVec3 {
    alpha.cross(r) + omega.cross(omega.cross(r))
}

/// The force in newtons that keeps `mass` on its circle: m ω × (ω × r), inwards; the tension of its string.
///
/// ```
/// use jounce_math::DVec3;
/// let f = jounce_motion::force::centripetal(0.5, DVec3::Z * 2.0, DVec3::X * 3.0);
/// assert_eq!(f, DVec3::X * -6.0);
/// ```
#[inline]
pub fn centripetal(mass: f64, omega: DVec3, r: DVec3) -> DVec3 {
    omega.cross(omega.cross(r)) * mass
}

/// Centrifugal force in newtons, in the frame that turns at `omega`: −m ω × (ω × r), outwards; m ω² r = m v²/r where r
/// is across the axis.
///
/// ```
/// use jounce_math::DVec3;
/// let f = jounce_motion::force::centrifugal(0.5, DVec3::Z * 2.0, DVec3::X * 3.0);
/// assert_eq!(f, DVec3::X * 6.0);
/// ```
#[inline]
pub fn centrifugal(mass: f64, omega: DVec3, r: DVec3) -> DVec3 {
    -centripetal(mass, omega, r)
}

/// Coriolis force in newtons on a mass that moves at `velocity` in m/s *in* the frame that turns at `omega`: −2 m ω × v.
///
/// ```
/// use jounce_math::DVec3;
/// let f = jounce_motion::force::coriolis(1.0, DVec3::Z, DVec3::X * 3.0);
/// assert_eq!(f, DVec3::Y * -6.0);
/// ```
#[inline]
pub fn coriolis(mass: f64, omega: DVec3, velocity: DVec3) -> DVec3 {
    omega.cross(velocity) * (-2.0 * mass)
}

/// Euler force in newtons, in a frame whose rotation changes at `alpha` in rad/s²: −m α × r.
///
/// ```
/// use jounce_math::DVec3;
/// let f = jounce_motion::force::euler_force(2.0, DVec3::Z, DVec3::X * 3.0);
/// assert_eq!(f, DVec3::Y * -6.0);
/// ```
#[inline]
pub fn euler_force(mass: f64, alpha: DVec3, r: DVec3) -> DVec3 {
    alpha.cross(r) * -mass
}
