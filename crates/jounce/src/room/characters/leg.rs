//! The dynamic character: an upright body on a spring leg.
//!
//! Let e be the height of its foot over the ground (or below, negative) and v their relative speed along up. The leg gives
//!
//! a = −(ω² e + (2ζω + ω² Δt) v) / (1 + 2ζω Δt + ω² Δt²) − g·u,  ω = 2π f:
//!
//! the implicit Euler step of e″ = −ω² e − 2ζω e′, with the weight held besides. It pulls down with no more than the weight, so that
//! the character leaves the ground over an edge. Walking is a force m (v* − v)/Δt across up of bounded size. What it stands on gets
//! the opposite of both, at the contact. Where that gives way itself, with the inverse mass k along the force, spring and walking are those
//! of the mass that both have against one another, 1/(1/m + k): as if it were the ground, a box of 0.5 kg would be kicked away at 100 m/s.
//!
//! Source: implicit springs, Baraff and Witkin 1998; the form with effective mass, Catto, Soft constraints, GDC 2011.

use super::around::Hit;
use super::desc::{CharacterDesc, CharacterKind};
use super::solve::across;
use jounce_math::{Vec3, scalar::f32s};

/// What a step starts from.
#[derive(Clone, Copy)]
pub(crate) struct Stand<'a> {
    pub desc: &'a CharacterDesc,
    pub up: Vec3,
    pub gravity: Vec3,
    pub dt: f32,
    /// Velocity of the body, and of the ground below, m/s.
    pub velocity: Vec3,
    pub ground_velocity: Vec3,
    /// Wanted, against the ground, m/s.
    pub walk: Vec3,
    /// Height of the foot over the ground, where that carries.
    pub height: Option<f32>,
    /// Ground too steep to stand on.
    pub steep: Option<Vec3>,
    /// Inverse mass of what it stands on, at the foot and along a unit vector, 1/kg.
    pub give: &'a dyn Fn(Vec3) -> f32,
}

/// Most that a leg pushes, in weights.
const PUSH_MAX: f32 = 20.0;

/// Force on the character, N.
pub(crate) fn force(s: &Stand<'_>) -> Vec3 {
    let CharacterKind::Dynamic { leg_hertz, leg_damping_ratio, force } = s.desc.kind else {
        return Vec3::ZERO;
    };
    let g = f32s::max(-s.gravity.dot(s.up), 0.0);
    let relative = s.velocity - s.ground_velocity;
    let m = s.desc.mass;
    // Of what moves the two against one another, the part that is the character's.
    let part = |n: Vec3| 1.0 / (1.0 + m * (s.give)(n));
    let leg = s.height.map_or(0.0, |e| {
        let w = core::f32::consts::TAU * leg_hertz;
        let (k, c) = (w * w, 2.0 * leg_damping_ratio * w);
        let v = relative.dot(s.up);
        let a = -(k * e + (c + k * s.dt) * v) / (1.0 + c * s.dt + k * s.dt * s.dt);
        f32s::clamp(a * part(s.up) + g, -g, PUSH_MAX * f32s::max(g, 1.0))
    });
    let most = if s.height.is_some() { s.desc.acceleration } else { s.desc.air_acceleration };
    let change = (across(s.walk, s.up) - across(relative, s.up)) * (1.0 / s.dt);
    let change = change.try_normalize().map_or(Vec3::ZERO, |(n, size)| n * (size * part(n)));
    let mut a = clamped(change, f32s::min(most, force / m));
    // In the air nothing brakes what is not asked to move.
    if s.height.is_none() && s.walk == Vec3::ZERO {
        a = Vec3::ZERO;
    }
    if let Some(n) = s.steep {
        let n = across(n, s.up).normalize_or(Vec3::ZERO);
        a += n * f32s::max(-a.dot(n), 0.0);
    }
    (a + s.up * leg) * m
}

/// Height of the foot over what a sweep of the capsule down from `above` the foot met.
pub(crate) fn height_over(h: &Hit, above: f32) -> f32 {
    h.go - above
}

/// A vector no longer than that.
pub(crate) fn clamped(v: Vec3, most: f32) -> Vec3 {
    let l = v.length();
    if l > most { v * (most / l) } else { v }
}
