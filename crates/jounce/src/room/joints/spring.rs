//! A spring between two anchors: F = −k (|d| − L₀) − c d|d|/dt along n = d/|d|.
//!
//! Its row is that of the distance, C = |d| − L₀, J = (−n, −r_a × n, n, r_b × n), dC/dt = J u; k and c are given, or are those of ω and ζ
//! for the mass m = 1/(J M⁻¹ Jᵀ) that the two bodies have along it: k = m ω², c = 2 ζ ω m. A substep gives λ = −m (a C + b J u), with a and b for
//! which the row swings with exactly its frequency and decay ([`super::extra`]). It may have ends, at which it is a rope or a strut.
//!
//! Sources: Hooke's law; Catto, Soft constraints, GDC 2011 (ω and ζ).

use super::desc::{LimitDesc, MotorTarget, SpringDesc};
use super::extra::{Duty, Extras};
use super::rows::Ends;

pub(crate) fn extras(
    rest: f32,
    spring: SpringDesc,
    limit: Option<LimitDesc>,
    e: &Ends,
    out: &mut Extras<'_>,
) {
    let row = e.distance();
    let target = MotorTarget::Position { position: rest, velocity: 0.0, spring };
    out.push(row, Duty::motor(target, f32::INFINITY));
    if let Some(limit) = limit {
        out.push(row, Duty::Limit(limit));
    }
}
