//! The methods by name.

use crate::error::{Error, bad};
use core::fmt;
use core::str::FromStr;

/// How a step of Δt is taken.
///
/// ```
/// use jounce_motion::integrate::Method;
/// let method: Method = "velocity_verlet".parse()?;
/// assert_eq!(method, Method::VelocityVerlet);
/// assert_eq!(method.to_string(), "velocity_verlet");
/// assert_eq!(method.order(), 2);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Method {
    /// yₙ₊₁ = yₙ + Δt f(tₙ, yₙ). First order; gains energy on every oscillation.
    ExplicitEuler,
    /// The lecture's loop, `position += velocity * dt; velocity += acceleration * dt`: position first, hence explicit
    /// Euler to the bit.
    LectureLoop,
    /// Velocity first, then the position with the *new* velocity. First order; keeps energy bounded up to ω Δt = 2.
    #[default]
    SemiImplicitEuler,
    /// x′ = x + v Δt + ½ a Δt², v′ = v + ½ (a + a′) Δt. Second order, symplectic for forces of the position.
    VelocityVerlet,
    /// The slope in the middle of the step. Second order.
    Midpoint,
    /// The classical Runge–Kutta method. Fourth order.
    Rk4,
    /// yₙ₊₁ = yₙ + Δt f(tₙ₊₁, yₙ₊₁), by Newton's iteration with GMRES inside. First order; stable at any step, at the
    /// price of damping.
    ImplicitEuler,
    /// Explicit Euler that takes one step and two half steps, compares them and chooses Δt by itself.
    AdaptiveEuler,
    /// One step of Dormand and Prince's fifth-order formula, of the given length.
    Dopri5,
    /// Dormand and Prince with its own choice of steps.
    AdaptiveDopri5,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::ExplicitEuler,
        Self::LectureLoop,
        Self::SemiImplicitEuler,
        Self::VelocityVerlet,
        Self::Midpoint,
        Self::Rk4,
        Self::ImplicitEuler,
        Self::AdaptiveEuler,
        Self::Dopri5,
        Self::AdaptiveDopri5,
    ];

    /// The name in snake case, as it is parsed.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ExplicitEuler => "explicit_euler",
            Self::LectureLoop => "lecture_loop",
            Self::SemiImplicitEuler => "semi_implicit_euler",
            Self::VelocityVerlet => "velocity_verlet",
            Self::Midpoint => "midpoint",
            Self::Rk4 => "rk4",
            Self::ImplicitEuler => "implicit_euler",
            Self::AdaptiveEuler => "adaptive_euler",
            Self::Dopri5 => "dopri5",
            Self::AdaptiveDopri5 => "adaptive_dopri5",
        }
    }

    /// The power of Δt with which the error at a given time shrinks.
    pub const fn order(self) -> u32 {
        match self {
            Self::ExplicitEuler
            | Self::LectureLoop
            | Self::SemiImplicitEuler
            | Self::ImplicitEuler
            | Self::AdaptiveEuler => 1,
            Self::VelocityVerlet | Self::Midpoint => 2,
            Self::Rk4 => 4,
            Self::Dopri5 | Self::AdaptiveDopri5 => 5,
        }
    }

    /// True for the methods that choose the lengths of their steps within the Δt they are given.
    pub const fn is_adaptive(self) -> bool {
        matches!(self, Self::AdaptiveEuler | Self::AdaptiveDopri5)
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Method {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self, Error> {
        Self::ALL.into_iter().find(|m| m.name() == text).ok_or_else(|| {
            bad(
                "integrator",
                "method",
                text,
                "explicit_euler, lecture_loop, semi_implicit_euler, velocity_verlet, midpoint, rk4, implicit_euler, \
                 adaptive_euler, dopri5 or adaptive_dopri5",
            )
        })
    }
}
