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

use super::rows::{Block, LANES, Lane, Outcome, Wide3, basis, surface, velocity};
use super::state::ContactManifold;
use crate::room::rigid::state::BodyState;
use jounce_lanes::{Kernel, Lanes};
use jounce_math::Vec3;

/// Slip that a sticking contact forgives, as a part of `Settings::stick_speed`: it comes from solving row by row.
const BREAKAWAY: f32 = 0.1;

/// What the rows of a block gave, row by row, as the manifolds want it.
pub(crate) struct Collect<'a> {
    pub block: &'a Block,
    /// The two bodies of every row, at the end of the step.
    pub states: &'a [[&'a BodyState; LANES]; 2],
    pub out: &'a mut [Outcome; LANES],
}

impl Kernel for Collect<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut at = 0;
        while at < self.block.rows {
            collect::<L>(self.block, self.states, self.out, at);
            at += L::WIDTH;
        }
    }
}

#[inline(always)]
fn collect<L: Lanes>(
    block: &Block,
    states: &[[&BodyState; LANES]; 2],
    out: &mut [Outcome; LANES],
    at: usize,
) {
    let (zero, one) = (L::zero(), L::splat(1.0));
    let (mut bound, mut hit, mut bounced) = (zero, zero, zero);
    let mut points = [zero; 8];
    for (i, (rows, sums)) in block.points.iter().zip(&block.sums).enumerate().take(block.points_max) {
        let total = L::load(&sums.total[at..]);
        points[i] = L::load(&rows.impulse[at..]);
        points[4 + i] = total;
        bound = bound + total;
        let gave = total.gt(zero);
        hit = L::select(gave, hit.max(L::load(&sums.approach[at..])), hit);
        if block.any_rebound {
            let back = L::load(&sums.rebound[at..]).gt(zero);
            bounced = L::select(gave & back, one, bounced);
        }
    }
    let n = Wide3::<L>::load(&block.normal, at);
    let (t1, t2) = basis(n);
    let tangents = [t1, t2];
    let friction = along(&block.friction_impulse, tangents, at);
    let total = along(&block.friction_total, tangents, at);
    let (va, wa) = velocity::<L>(&states[0], at);
    let (vb, wb) = velocity::<L>(&states[1], at);
    let (ra, rb) = (Wide3::load(&block.arm_a, at), Wide3::load(&block.arm_b, at));
    let dv = vb.sub(va).add(wb.cross(rb)).sub(wa.cross(ra));
    let wanted = surface::<L>(block, at);
    let slip = t1.scale(t1.dot(dv) - wanted[0]).add(t2.scale(t2.dot(dv) - wanted[1]));
    // Over the whole step: within one substep the normal impulse of a rocking body may dip, which means nothing.
    let limit = L::load(&block.mu[at..]) * bound;
    let saturated = L::select(total.dot(total).ge(L::splat(0.999) * limit * limit), one, zero);
    let twist = L::load(&block.twist_impulse[at..]);
    let rolling = if block.any_rolling {
        Wide3::load(&block.rolling_impulse, at)
    } else {
        Wide3::new(zero, zero, zero)
    };
    let results = &mut out[at..at + L::WIDTH];
    L::scatter8(
        points,
        #[inline(always)]
        |l, row| results[l].points = row,
    );
    L::scatter8(
        [friction.x, friction.y, friction.z, total.x, total.y, total.z, twist, hit],
        #[inline(always)]
        |l, row| results[l].friction = row,
    );
    L::scatter8(
        [slip.x, slip.y, slip.z, rolling.x, rolling.y, rolling.z, saturated, bounced],
        #[inline(always)]
        |l, row| results[l].slip = row,
    );
}

/// The sum of two impulses along the tangents.
#[inline(always)]
fn along<L: Lanes>(f: &[Lane; 2], t: [Wide3<L>; 2], at: usize) -> Wide3<L> {
    t[0].scale(L::load(&f[0][at..])).add(t[1].scale(L::load(&f[1][at..])))
}

/// Copies impulses back, and decides stick or slide. Gives the fastest approach of a point that pushed, m/s.
pub(crate) fn store(m: &mut ContactManifold, of: &Outcome, stick_speed: f32) -> f32 {
    let (mut pushed, mut total) = (false, 0.0);
    let count = usize::from(m.count).min(4);
    let (impulses, totals) = of.points.split_at(4);
    for (((p, t), impulse), sum) in m.points[..count].iter_mut().zip(&mut m.totals).zip(impulses).zip(totals)
    {
        (p.impulse, *t) = (*impulse, *sum);
        total += *sum;
        pushed |= *impulse > 0.0;
    }
    m.total = total;
    let [fx, fy, fz, tx, ty, tz, twist, hit] = of.friction;
    let [sx, sy, sz, rx, ry, rz, saturated, bounced] = of.slip;
    m.friction = Vec3::new(fx, fy, fz);
    m.total_friction = Vec3::new(tx, ty, tz);
    m.twist = twist;
    m.rolling = Vec3::new(rx, ry, rz);
    let (slip, saturated) = (Vec3::new(sx, sy, sz), saturated > 0.0);
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
    if bounced > 0.0 {
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
