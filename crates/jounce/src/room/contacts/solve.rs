//! The solver passes over blocks of rows; the equations are in the room's text.
//!
//! Written once over [`Lanes`]: one lane is the scalar reference, and every width gives its bits, since a row keeps to its
//! own lane and the order of operations within a row is that of this text. Rows of a block touch disjoint bodies.

use super::prepare::StepConstants;
use super::rows::{Block, Jacobian, LANES, Wide3};
use crate::room::rigid::state::BodyState;
use core::ops::Range;
use jounce_lanes::{Kernel, Lanes, Mask};
use jounce_tasks::Scatter;

/// No point pushes harder than to change its two bodies' speed by so much, m/s: far above all that is stacked or hit, far
/// below what overflows. A body larger than its room, between walls that push from opposite sides, has no solution, and its
/// impulses would grow from step to step until nothing is finite.
pub(crate) const SPEED_MOST: f32 = 1e6;

/// Impulse that may be given back ÷ e times the impulse that was taken.
const POISSON: f32 = 1.05;

/// Which pass of the substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pass {
    /// Applies the impulses of the last substep (or step).
    Warm,
    /// Normal rows with soft bias, no friction.
    Solve,
    /// Normal rows without bias, then twist, rolling and friction.
    Relax,
    /// After the last substep: what will bounce comes to rest at its points first.
    Compress,
    /// Then: gives back e V where the approach was fast enough and the contact pushed.
    Restitution,
}

/// One pass over one block.
pub(crate) struct Sweep<'a, 'b> {
    pub pass: Pass,
    pub access: &'a mut Scatter<'b, BodyState>,
    pub rows: Range<usize>,
    pub block: &'a mut Block,
    /// Lane of the first row.
    pub lane: usize,
    pub constants: &'a StepConstants,
}

impl Kernel for Sweep<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { pass, access, rows, block, lane, constants } = self;
        let mut done = 0;
        while done < rows.len().min(LANES) {
            let lanes = Gather { first: rows.start + done, end: rows.end };
            let at = lane + done;
            match pass {
                Pass::Warm => warm_start::<L>(block, at, access, lanes),
                Pass::Solve => solve::<L>(block, at, access, lanes, constants),
                Pass::Relax => relax::<L>(block, at, access, lanes, constants),
                Pass::Compress => restitution::<L>(block, at, access, lanes, false),
                Pass::Restitution => restitution::<L>(block, at, access, lanes, true),
            }
            done += L::WIDTH;
        }
    }
}

/// Rows `first..` of the colour, one per lane; lanes past `end` read a body at rest and write nothing.
#[derive(Clone, Copy)]
struct Gather {
    first: usize,
    end: usize,
}

/// Velocities of the two bodies of a row, changed by impulses.
#[derive(Clone, Copy)]
struct Pair<L> {
    va: Wide3<L>,
    wa: Wide3<L>,
    vb: Wide3<L>,
    wb: Wide3<L>,
    ma: L,
    mb: L,
    /// Δp.x and Δp.y ride along in the hot row.
    pa: [L; 2],
    pb: [L; 2],
}

/// Motion of B against A since the start of the step.
#[derive(Clone, Copy)]
struct Moved<L> {
    dp: Wide3<L>,
    ra: Wide3<L>,
    rb: Wide3<L>,
}

impl<L: Lanes> Pair<L> {
    #[inline(always)]
    fn load(block: &Block, at: usize, access: &Scatter<'_, BodyState>, g: Gather) -> Self {
        let a = L::gather8(
            #[inline(always)]
            |i| if g.first + i < g.end { &access.a(g.first + i).hot } else { &BodyState::FIXED.hot },
        );
        let b = L::gather8(
            #[inline(always)]
            |i| if g.first + i < g.end { &access.b(g.first + i).hot } else { &BodyState::FIXED.hot },
        );
        Self {
            va: Wide3::new(a[0], a[1], a[2]),
            wa: Wide3::new(a[3], a[4], a[5]),
            vb: Wide3::new(b[0], b[1], b[2]),
            wb: Wide3::new(b[3], b[4], b[5]),
            ma: L::load(&block.inv_mass_a[at..]),
            mb: L::load(&block.inv_mass_b[at..]),
            pa: [a[6], a[7]],
            pb: [b[6], b[7]],
        }
    }
    #[inline(always)]
    fn moved(&self, access: &Scatter<'_, BodyState>, g: Gather) -> Moved<L> {
        let a = L::gather8(
            #[inline(always)]
            |i| if g.first + i < g.end { &access.a(g.first + i).motion } else { &BodyState::FIXED.motion },
        );
        let b = L::gather8(
            #[inline(always)]
            |i| if g.first + i < g.end { &access.b(g.first + i).motion } else { &BodyState::FIXED.motion },
        );
        Moved {
            dp: Wide3::new(self.pb[0] - self.pa[0], self.pb[1] - self.pa[1], b[0] - a[0]),
            ra: Wide3::new(a[1], a[2], a[3]),
            rb: Wide3::new(b[1], b[2], b[3]),
        }
    }
    #[inline(always)]
    fn store(self, access: &mut Scatter<'_, BodyState>, g: Gather) {
        let (a, b) = (self.va, self.vb);
        L::scatter8(
            [a.x, a.y, a.z, self.wa.x, self.wa.y, self.wa.z, self.pa[0], self.pa[1]],
            #[inline(always)]
            |i, hot| {
                if g.first + i < g.end {
                    let motion = access.a(g.first + i).motion;
                    access.store_a(g.first + i, BodyState { hot, motion });
                }
            },
        );
        L::scatter8(
            [b.x, b.y, b.z, self.wb.x, self.wb.y, self.wb.z, self.pb[0], self.pb[1]],
            #[inline(always)]
            |i, hot| {
                if g.first + i < g.end {
                    let motion = access.b(g.first + i).motion;
                    access.store_b(g.first + i, BodyState { hot, motion });
                }
            },
        );
    }
    /// J u along a direction.
    #[inline(always)]
    fn speed(&self, dir: Wide3<L>, j: &Jacobian, at: usize) -> L {
        dir.dot(self.vb.sub(self.va)) + Wide3::load(&j.b, at).dot(self.wb)
            - Wide3::load(&j.a, at).dot(self.wa)
    }
    /// u ← u + M⁻¹ Jᵀ λ.
    #[inline(always)]
    fn push(&mut self, dir: Wide3<L>, j: &Jacobian, at: usize, lambda: L) {
        self.va = self.va.sub(dir.scale(self.ma * lambda));
        self.wa = self.wa.sub(Wide3::load(&j.ia, at).scale(lambda));
        self.vb = self.vb.add(dir.scale(self.mb * lambda));
        self.wb = self.wb.add(Wide3::load(&j.ib, at).scale(lambda));
    }
}

#[inline(always)]
fn warm_start<L: Lanes>(block: &mut Block, at: usize, access: &mut Scatter<'_, BodyState>, g: Gather) {
    let n = Wide3::<L>::load(&block.normal, at);
    let mut u = Pair::load(block, at, access, g);
    for rows in &block.points[..block.points_max.min(4)] {
        u.push(n, &rows.j, at, taken(L::load(&rows.mass[at..]), L::load(&rows.impulse[at..]), L::zero()));
    }
    let t1 = Wide3::<L>::load(&block.tangent, at);
    let t2 = n.cross(t1);
    u.push(t1, &block.friction[0], at, L::load(&block.friction_impulse[0][at..]));
    u.push(t2, &block.friction[1], at, L::load(&block.friction_impulse[1][at..]));
    let twist = L::load(&block.twist_impulse[at..]);
    u.wa = u.wa.sub(Wide3::load(&block.twist_ia, at).scale(twist));
    u.wb = u.wb.add(Wide3::load(&block.twist_ib, at).scale(twist));
    if block.any_rolling {
        let p = Wide3::<L>::load(&block.rolling_impulse, at);
        u.wa = u.wa.sub(p.times(&block.inertia_a, at));
        u.wb = u.wb.add(p.times(&block.inertia_b, at));
    }
    u.store(access, g);
}

#[inline(always)]
fn solve<L: Lanes>(
    block: &mut Block,
    at: usize,
    access: &mut Scatter<'_, BodyState>,
    g: Gather,
    k: &StepConstants,
) {
    let n = Wide3::<L>::load(&block.normal, at);
    let mut u = Pair::load(block, at, access, g);
    let moved = u.moved(access, g);
    let dp = n.dot(moved.dp);
    let (zero, one) = (L::zero(), L::splat(1.0));
    let sigma = L::load(&block.mass_scale[at..]);
    let iota = L::load(&block.impulse_scale[at..]);
    let rate = sigma * L::load(&block.bias_rate[at..]);
    let (inv_h, push, most) = (L::splat(k.inv_h), L::load(&block.push_out[at..]), L::splat(SPEED_MOST));
    for rows in &mut block.points[..block.points_max.min(4)] {
        let turn =
            Wide3::<L>::load(&rows.j.b, at).dot(moved.rb) - Wide3::<L>::load(&rows.j.a, at).dot(moved.ra);
        let s = L::load(&rows.separation[at..]) + dp + turn;
        let open = s.gt(zero);
        let bias = L::select(open, s * inv_h, (rate * s).max(push));
        let scale = L::select(open, one, sigma);
        let soft = L::select(open, zero, iota);
        let vn = u.speed(n, &rows.j, at);
        let old = L::load(&rows.impulse[at..]);
        let mass = L::load(&rows.mass[at..]);
        let new = (old - mass * (scale * vn + bias) - soft * old).max(zero).min(mass * most);
        let new = taken(mass, new, old);
        new.store(&mut rows.impulse[at..]);
        u.push(n, &rows.j, at, new - old);
    }
    u.store(access, g);
}

/// Points without mass are none, or another's (`stage::articulated`): they keep what they have.
#[inline(always)]
fn taken<L: Lanes>(mass: L, new: L, old: L) -> L {
    L::select(mass.gt(L::zero()), new, old)
}

#[inline(always)]
fn relax<L: Lanes>(
    block: &mut Block,
    at: usize,
    access: &mut Scatter<'_, BodyState>,
    g: Gather,
    k: &StepConstants,
) {
    let n = Wide3::<L>::load(&block.normal, at);
    let mut u = Pair::load(block, at, access, g);
    let moved = u.moved(access, g);
    let dp = n.dot(moved.dp);
    let zero = L::zero();
    let (inv_h, most) = (L::splat(k.inv_h), L::splat(SPEED_MOST));
    let (mut total, mut twist_limit) = (zero, zero);
    for rows in &mut block.points[..block.points_max.min(4)] {
        let turn =
            Wide3::<L>::load(&rows.j.b, at).dot(moved.rb) - Wide3::<L>::load(&rows.j.a, at).dot(moved.ra);
        let s = L::load(&rows.separation[at..]) + dp + turn;
        let bias = s.max(zero) * inv_h;
        let vn = u.speed(n, &rows.j, at);
        let old = L::load(&rows.impulse[at..]);
        let mass = L::load(&rows.mass[at..]);
        let new = taken(mass, (old - mass * (vn + bias)).max(zero).min(mass * most), old);
        new.store(&mut rows.impulse[at..]);
        (L::load(&rows.total[at..]) + new).store(&mut rows.total[at..]);
        total = total + new;
        twist_limit = twist_limit + L::load(&rows.lever[at..]) * new;
        u.push(n, &rows.j, at, new - old);
    }
    let mu = L::load(&block.mu[at..]);
    let patch = L::load(&block.twist_patch[at..]);
    twist(block, at, &mut u, n, mu * (twist_limit + patch * total));
    if block.any_rolling {
        let limit = L::load(&block.rolling[at..]) * total;
        rolling(block, at, &mut u, limit);
    }
    friction(block, at, &mut u, n, mu * total);
    u.store(access, g);
}

#[inline(always)]
fn twist<L: Lanes>(block: &mut Block, at: usize, u: &mut Pair<L>, n: Wide3<L>, limit: L) {
    let old = L::load(&block.twist_impulse[at..]);
    let wanted = old - L::load(&block.twist_mass[at..]) * n.dot(u.wb.sub(u.wa));
    let new = wanted.max(-limit).min(limit);
    new.store(&mut block.twist_impulse[at..]);
    let d = new - old;
    u.wa = u.wa.sub(Wide3::load(&block.twist_ia, at).scale(d));
    u.wb = u.wb.add(Wide3::load(&block.twist_ib, at).scale(d));
}

#[inline(always)]
fn rolling<L: Lanes>(block: &mut Block, at: usize, u: &mut Pair<L>, limit: L) {
    let old = Wide3::<L>::load(&block.rolling_impulse, at);
    let wanted = old.sub(u.wb.sub(u.wa).times(&block.rolling_mass, at));
    let size2 = wanted.dot(wanted);
    let scale = L::select(size2.gt(limit * limit), limit / size2.sqrt(), L::splat(1.0));
    let new = wanted.scale(scale);
    new.store(&mut block.rolling_impulse, at);
    let d = new.sub(old);
    u.wa = u.wa.sub(d.times(&block.inertia_a, at));
    u.wb = u.wb.add(d.times(&block.inertia_b, at));
}

#[inline(always)]
fn friction<L: Lanes>(block: &mut Block, at: usize, u: &mut Pair<L>, n: Wide3<L>, limit: L) {
    let new = friction_impulse(block, at, u, n, limit);
    for (total, new) in block.friction_total.iter_mut().zip(new) {
        (L::load(&total[at..]) + new).store(&mut total[at..]);
    }
    push_friction(block, at, u, n, new);
}

/// The friction impulse that stops the slip, within the bound.
#[inline(always)]
fn friction_impulse<L: Lanes>(block: &Block, at: usize, u: &Pair<L>, n: Wide3<L>, limit: L) -> [L; 2] {
    let t1 = Wide3::<L>::load(&block.tangent, at);
    let t2 = n.cross(t1);
    let v1 = u.speed(t1, &block.friction[0], at) - L::load(&block.surface_speed[0][at..]);
    let v2 = u.speed(t2, &block.friction[1], at) - L::load(&block.surface_speed[1][at..]);
    let xx = L::load(&block.friction_mass[0][at..]);
    let xy = L::load(&block.friction_mass[1][at..]);
    let yy = L::load(&block.friction_mass[2][at..]);
    let old1 = L::load(&block.friction_impulse[0][at..]);
    let old2 = L::load(&block.friction_impulse[1][at..]);
    let wanted1 = old1 - (xx * v1 + xy * v2);
    let wanted2 = old2 - (xy * v1 + yy * v2);
    let size2 = wanted1 * wanted1 + wanted2 * wanted2;
    let scale = L::select(size2.gt(limit * limit), limit / size2.sqrt(), L::splat(1.0));
    [wanted1 * scale, wanted2 * scale]
}

/// Stores a friction impulse and applies its change.
#[inline(always)]
fn push_friction<L: Lanes>(block: &mut Block, at: usize, u: &mut Pair<L>, n: Wide3<L>, new: [L; 2]) {
    let t1 = Wide3::<L>::load(&block.tangent, at);
    for ((t, i), new) in [t1, n.cross(t1)].into_iter().zip(0..).zip(new) {
        let old = L::load(&block.friction_impulse[i][at..]);
        new.store(&mut block.friction_impulse[i][at..]);
        u.push(t, &block.friction[i], at, new - old);
    }
}

/// The impulse of the rebound bears friction as the one that stopped the approach did: Δv_t ≤ μ (1 + e) v_n in all.
#[inline(always)]
fn rebound_friction<L: Lanes>(block: &mut Block, at: usize, u: &mut Pair<L>, n: Wide3<L>, added: L) {
    let mut total = L::zero();
    for rows in &block.points[..block.points_max.min(4)] {
        total = total + L::load(&rows.impulse[at..]);
    }
    let wanted = friction_impulse(block, at, u, n, L::load(&block.mu[at..]) * total);
    // Lanes that did not bounce keep theirs: a row must not depend on its neighbours.
    let bounced = added.gt(L::zero()) | added.lt(L::zero());
    let old = [L::load(&block.friction_impulse[0][at..]), L::load(&block.friction_impulse[1][at..])];
    let new = [L::select(bounced, wanted[0], old[0]), L::select(bounced, wanted[1], old[1])];
    for i in 0..2 {
        (L::load(&block.friction_total[i][at..]) + (new[i] - old[i]))
            .store(&mut block.friction_total[i][at..]);
    }
    push_friction(block, at, u, n, new);
}

#[inline(always)]
fn restitution<L: Lanes>(
    block: &mut Block,
    at: usize,
    access: &mut Scatter<'_, BodyState>,
    g: Gather,
    back: bool,
) {
    let n = Wide3::<L>::load(&block.normal, at);
    let mut u = Pair::load(block, at, access, g);
    let zero = L::zero();
    let (mut added, mut change) = (zero, L::splat(-1.0));
    // Poisson's bound: what is given back is at most e times what was taken. Newton's law alone adds energy where friction
    // turns the body during the impact (Kane & Levinson 1985). The allowance is for gravity within the step.
    let e = L::load(&block.restitution[at..]);
    let mut budget = L::load(&block.compression[at..]) * (L::splat(1.0) + e * L::splat(POISSON));
    for rows in &block.points[..block.points_max.min(4)] {
        budget = budget - L::load(&rows.total[at..]);
    }
    for rows in &mut block.points[..block.points_max.min(4)] {
        let rebound = L::load(&rows.rebound[at..]);
        let total = L::load(&rows.total[at..]);
        let bounces = rebound.gt(zero) & total.gt(zero);
        if !bounces.any() {
            continue;
        }
        let vn = u.speed(n, &rows.j, at);
        let old = L::load(&rows.impulse[at..]);
        let mass = L::load(&rows.mass[at..]);
        let target = if back { rebound } else { zero };
        let wanted = (old - mass * (vn - target)).max(zero).min(mass * L::splat(SPEED_MOST));
        let wanted = taken(mass, wanted, old);
        let wanted = if back { wanted.min(old + budget.max(zero)) } else { wanted.max(old) };
        let new = L::select(bounces, wanted, old);
        budget = budget - (new - old);
        new.store(&mut rows.impulse[at..]);
        // What is over of the last substep's impulse may be taken back, not the other substeps'.
        (total + (new - old)).store(&mut rows.total[at..]);
        added = added + (new - old);
        let moved = L::select(bounces & mass.gt(zero), (new - old).abs() / mass, L::splat(-1.0));
        change = change.max(moved);
        u.push(n, &rows.j, at, new - old);
    }
    change.store(&mut block.rebound_change[at..]);
    rebound_friction(block, at, &mut u, n, added);
    u.store(access, g);
}
