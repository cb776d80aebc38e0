//! From solver rows back to manifolds, once per step; the stick bit.
//!
//! Static and kinetic friction. A manifold either *sticks* (bound μ_s N) or *slides* (bound μ_k N), decided here at the end of a
//! step and remembered:
//!
//! * stick → slide when the friction impulse of the step reached its bound, and the surfaces all the same slip, ever faster
//!   (while a body settles, normal impulses build up and friction falls short for a moment);
//! * slide → stick when friction stopped the slip within its bound, when the slip turned round, or when it is slower than
//!   `Settings::stick_speed` and not speeding up;
//! * a new manifold starts stuck below that speed.
//!
//! "Not speeding up" keeps a block that has just broken loose sliding; without the bit, a block slides for ever wherever
//! μ_k < tan θ < μ_s.

use super::rows::{Block, LANES};
use super::state::ContactManifold;
use crate::room::rigid::state::BodyState;
use jounce_math::{Vec3, scalar::f32s};

/// Slip that a sticking contact forgives, as a part of `Settings::stick_speed`: it comes from solving row by row.
const BREAKAWAY: f32 = 0.1;

/// Copies impulses back, and decides stick or slide. Gives the fastest approach of a point that pushed, m/s.
pub(crate) fn store(
    m: &mut ContactManifold,
    block: &Block,
    l: usize,
    a: &BodyState,
    b: &BodyState,
    stick_speed: f32,
) -> f32 {
    let l = l % LANES;
    let (mut bound, mut hit, mut pushed) = (0.0, 0.0, false);
    for (p, rows) in m.points.iter_mut().zip(&block.points).take(usize::from(m.count)) {
        p.impulse = rows.impulse[l];
        p.total_impulse = rows.total[l];
        bound += rows.total[l];
        pushed |= rows.impulse[l] > 0.0;
        if rows.total[l] > 0.0 {
            hit = f32s::max(hit, rows.approach[l]);
        }
    }
    let n = block.normal.get(l);
    let t1 = block.tangent.get(l);
    let t2 = n.cross(t1);
    let [f1, f2] = [block.friction_impulse[0][l], block.friction_impulse[1][l]];
    m.friction = t1 * f1 + t2 * f2;
    m.total_friction = t1 * block.friction_total[0][l] + t2 * block.friction_total[1][l];
    m.twist = block.twist_impulse[l];
    m.rolling = block.rolling_impulse.get(l);
    let slip_along = |t: Vec3, i: usize| {
        let j = &block.friction[i];
        t.dot(b.v() - a.v()) + j.b.get(l).dot(b.w()) - j.a.get(l).dot(a.w()) - block.surface_speed[i][l]
    };
    let slip = t1 * slip_along(t1, 0) + t2 * slip_along(t2, 1);
    // Over the whole step: within one substep the normal impulse of a rocking body may dip, which means nothing.
    let used = m.total_friction.length_squared();
    let saturated = used >= 0.999 * (block.mu[l] * bound) * (block.mu[l] * bound);
    let speed = slip.length();
    if pushed {
        m.stick = if m.stick {
            !saturated || speed < BREAKAWAY * stick_speed || speed <= m.slip.length()
        } else {
            let slowing = speed <= m.slip.length() || m.slip.dot(slip) < 0.0;
            !saturated || m.slip.dot(slip) < 0.0 || (speed < stick_speed && slowing)
        };
    } else {
        m.stick = speed < stick_speed;
    }
    m.slip = slip;
    let bounced = block.any_rebound && block.points.iter().any(|p| p.rebound[l] > 0.0 && p.total[l] > 0.0);
    if bounced {
        forget(m);
    }
    hit
}

/// What has bounced leaves: the impulses of the impact are no start for the next step, where the friction among them would turn
/// the body into the surface before it is taken back.
fn forget(m: &mut ContactManifold) {
    m.points.iter_mut().for_each(|p| p.impulse = 0.0);
    (m.friction, m.twist, m.rolling) = (Vec3::ZERO, 0.0, Vec3::ZERO);
}
