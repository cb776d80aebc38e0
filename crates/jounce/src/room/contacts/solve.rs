//! The solver passes over blocks of rows; the equations are in the room's text.
//!
//! # A row's own frame
//! All points of a manifold share n and lie around the friction centre c, at e = x t₁ + y t₂ (what e has along n turns nothing about n × e). With
//! the arms r_A, r_B from the centres of mass to c,
//!
//! * V = v_B + ω_B × r_B − v_A − ω_A × r_A and Ω = ω_B − ω_A are the relative velocity and spin at c;
//! * a point's normal speed is v_i = n·V + y_i t₁·Ω − x_i t₂·Ω, and its gap follows from Δp and Δθ in the same way;
//! * an impulse λ_j changes it by A_ij λ_j, A_ij = J_i M⁻¹ J_jᵀ, which is kept from the start of the step;
//! * a pass gives the bodies its sum: the force F = n Σ λ and the moment M = t₁ Σ y λ − t₂ Σ x λ at c, by which
//!   v_A ← v_A − F/m_A, ω_A ← ω_A − I_A⁻¹ (M + r_A × F), and v_B, ω_B likewise with the other sign.
//!
//! So a point is five numbers, where its Jacobian with I⁻¹ Jᵀ of both bodies would be twelve: passes are bound by what they read. Friction acts at c
//! along t₁ and t₂, twist and rolling by a moment alone.
//!
//! Written once over [`Lanes`]: one lane is the scalar reference, and every width gives its bits, since a row keeps to its
//! own lane and the order of operations within a row is that of this text. Rows of a block touch disjoint bodies.

use super::prepare::StepConstants;
use super::rows::{Block, LANES, Wide3, basis, coupling, surface};
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
            let row = rows.start + done;
            let at = lane + done;
            match pass {
                Pass::Warm => warm_start::<L>(block, at, access, row),
                // The passes that are made again and again know how many points they go over.
                Pass::Solve => match block.points_max {
                    0 | 1 => solve::<L, 1>(block, at, access, row, constants),
                    2 => solve::<L, 2>(block, at, access, row, constants),
                    _ => solve::<L, 4>(block, at, access, row, constants),
                },
                Pass::Relax => match block.points_max {
                    0 | 1 => relax::<L, 1>(block, at, access, row, constants),
                    2 => relax::<L, 2>(block, at, access, row, constants),
                    _ => relax::<L, 4>(block, at, access, row, constants),
                },
                Pass::Compress => restitution::<L>(block, at, access, row, false),
                Pass::Restitution => restitution::<L>(block, at, access, row, true),
            }
            done += L::WIDTH;
        }
    }
}

/// n, t₁, t₂, and the arms to the friction centre.
#[derive(Clone, Copy)]
struct Frame<L> {
    n: Wide3<L>,
    t: [Wide3<L>; 2],
    ra: Wide3<L>,
    rb: Wide3<L>,
}

impl<L: Lanes> Frame<L> {
    #[inline(always)]
    fn load(block: &Block, at: usize) -> Self {
        let n = Wide3::load(&block.normal, at);
        let (t1, t2) = basis(n);
        Self { n, t: [t1, t2], ra: Wide3::load(&block.arm_a, at), rb: Wide3::load(&block.arm_b, at) }
    }
    /// Along the normal, at the first `n` points: of velocities, or of ways.
    #[inline(always)]
    fn at_points<const N: usize>(&self, block: &Block, at: usize, n: usize, m: &Relative<L>) -> [L; N] {
        let (middle, w1, w2) = (self.n.dot(m.v), self.t[0].dot(m.w), self.t[1].dot(m.w));
        let mut out = [L::zero(); N];
        for i in 0..n.min(N) {
            let p = &block.points[i];
            out[i] = middle + L::load(&p.y[at..]) * w1 - L::load(&p.x[at..]) * w2;
        }
        out
    }
}

/// Motion of B against A at the friction centre.
#[derive(Clone, Copy)]
struct Relative<L> {
    v: Wide3<L>,
    w: Wide3<L>,
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

impl<L: Lanes> Pair<L> {
    #[inline(always)]
    fn load(block: &Block, at: usize, access: &Scatter<'_, BodyState>, row: usize) -> Self {
        let bodies = access.gather::<LANES>(row, L::WIDTH);
        let a = L::gather8(
            #[inline(always)]
            |i| &bodies[i][0].hot,
        );
        let b = L::gather8(
            #[inline(always)]
            |i| &bodies[i][1].hot,
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
    /// V and Ω.
    #[inline(always)]
    fn relative(&self, f: &Frame<L>) -> Relative<L> {
        Relative {
            v: self.vb.sub(self.va).add(self.wb.cross(f.rb)).sub(self.wa.cross(f.ra)),
            w: self.wb.sub(self.wa),
        }
    }
    /// The same of the ways since the start of the step.
    #[inline(always)]
    fn moved(&self, f: &Frame<L>, access: &Scatter<'_, BodyState>, row: usize) -> Relative<L> {
        let bodies = access.gather::<LANES>(row, L::WIDTH);
        let a = L::gather8(
            #[inline(always)]
            |i| &bodies[i][0].motion,
        );
        let b = L::gather8(
            #[inline(always)]
            |i| &bodies[i][1].motion,
        );
        let (ta, tb) = (Wide3::new(a[1], a[2], a[3]), Wide3::new(b[1], b[2], b[3]));
        let dp = Wide3::new(self.pb[0] - self.pa[0], self.pb[1] - self.pa[1], b[0] - a[0]);
        Relative { v: dp.add(tb.cross(f.rb)).sub(ta.cross(f.ra)), w: tb.sub(ta) }
    }
    #[inline(always)]
    fn store(self, access: &mut Scatter<'_, BodyState>, row: usize) {
        let mut bodies = access.gather_mut::<LANES>(row, L::WIDTH);
        let (a, b) = (self.va, self.vb);
        L::scatter8(
            [a.x, a.y, a.z, self.wa.x, self.wa.y, self.wa.z, self.pa[0], self.pa[1]],
            #[inline(always)]
            |i, hot| {
                if let Some(body) = &mut bodies[i][0] {
                    body.hot = hot;
                }
            },
        );
        L::scatter8(
            [b.x, b.y, b.z, self.wb.x, self.wb.y, self.wb.z, self.pb[0], self.pb[1]],
            #[inline(always)]
            |i, hot| {
                if let Some(body) = &mut bodies[i][1] {
                    body.hot = hot;
                }
            },
        );
    }
    /// u ← u + M⁻¹ Jᵀ of a force at the friction centre and a moment.
    #[inline(always)]
    fn push(&mut self, f: &Frame<L>, block: &Block, at: usize, force: Wide3<L>, moment: Wide3<L>) {
        self.va = self.va.sub(force.scale(self.ma));
        self.vb = self.vb.add(force.scale(self.mb));
        let (a, b) = (moment.add(f.ra.cross(force)), moment.add(f.rb.cross(force)));
        self.wa = self.wa.sub(a.through(&block.inertia_a, block.round, at));
        self.wb = self.wb.add(b.through(&block.inertia_b, block.round, at));
    }
    /// The same of a moment alone.
    #[inline(always)]
    fn turn(&mut self, block: &Block, at: usize, moment: Wide3<L>) {
        self.wa = self.wa.sub(moment.through(&block.inertia_a, block.round, at));
        self.wb = self.wb.add(moment.through(&block.inertia_b, block.round, at));
    }
    #[inline(always)]
    fn push_points(&mut self, f: &Frame<L>, block: &Block, at: usize, sum: &Sum<L>) {
        let moment = f.t[0].scale(sum.m1).sub(f.t[1].scale(sum.m2));
        self.push(f, block, at, f.n.scale(sum.force), moment);
    }
    #[inline(always)]
    fn push_friction(&mut self, f: &Frame<L>, block: &Block, at: usize, d: [L; 2]) {
        let zero = L::zero();
        let force = f.t[0].scale(d[0]).add(f.t[1].scale(d[1]));
        self.push(f, block, at, force, Wide3::new(zero, zero, zero));
    }
}

/// Σ λ, Σ y λ, Σ x λ of points.
#[derive(Clone, Copy)]
struct Sum<L> {
    force: L,
    m1: L,
    m2: L,
}

impl<L: Lanes> Sum<L> {
    #[inline(always)]
    fn nothing() -> Self {
        Self { force: L::zero(), m1: L::zero(), m2: L::zero() }
    }
    /// Adds an impulse of point `i`, and what it does to the speeds of the points after it.
    #[inline(always)]
    fn add(&mut self, block: &Block, at: usize, i: usize, d: L, speeds: &mut [L]) {
        let p = &block.points[i];
        self.force = self.force + d;
        self.m1 = self.m1 + L::load(&p.y[at..]) * d;
        self.m2 = self.m2 + L::load(&p.x[at..]) * d;
        for j in i + 1..speeds.len() {
            speeds[j] = speeds[j] + L::load(&block.coupling[coupling(i, j)][at..]) * d;
        }
    }
}

#[inline(always)]
fn warm_start<L: Lanes>(block: &mut Block, at: usize, access: &mut Scatter<'_, BodyState>, row: usize) {
    let f = Frame::<L>::load(block, at);
    let mut u = Pair::load(block, at, access, row);
    let mut sum = Sum::nothing();
    for i in 0..block.points_max.min(4) {
        let p = &block.points[i];
        let given = taken(L::load(&p.mass[at..]), L::load(&p.impulse[at..]), L::zero());
        sum.add(block, at, i, given, &mut []);
    }
    let [f1, f2] = &block.friction_impulse;
    let friction = f.t[0].scale(L::load(&f1[at..])).add(f.t[1].scale(L::load(&f2[at..])));
    let mut moment = f.t[0].scale(sum.m1).sub(f.t[1].scale(sum.m2));
    moment = moment.add(f.n.scale(L::load(&block.twist_impulse[at..])));
    if block.any_rolling {
        moment = moment.add(Wide3::load(&block.rolling_impulse, at));
    }
    u.push(&f, block, at, f.n.scale(sum.force).add(friction), moment);
    u.store(access, row);
}

/// Numbers of the soft rows, lane by lane.
#[derive(Clone, Copy)]
struct Soft<L> {
    bias_rate: L,
    mass_scale: L,
    impulse_scale: L,
}

impl<L: Lanes> Soft<L> {
    /// Contacts with what cannot be moved are harder.
    #[inline(always)]
    fn load(u: &Pair<L>, k: &StepConstants, share: L) -> Self {
        let fixed = u.ma.eq(L::zero()) | u.mb.eq(L::zero());
        Self {
            bias_rate: either::<L>(fixed, k.fixed.bias_rate, k.moving.bias_rate) * share,
            mass_scale: either::<L>(fixed, k.fixed.mass_scale, k.moving.mass_scale),
            impulse_scale: either::<L>(fixed, k.fixed.impulse_scale, k.moving.impulse_scale),
        }
    }
}

#[inline(always)]
fn either<L: Lanes>(first: L::Mask, a: f32, b: f32) -> L {
    L::select(first, L::splat(a), L::splat(b))
}

#[inline(always)]
fn solve<L: Lanes, const N: usize>(
    block: &mut Block,
    at: usize,
    access: &mut Scatter<'_, BodyState>,
    row: usize,
    k: &StepConstants,
) {
    let f = Frame::<L>::load(block, at);
    let mut u = Pair::load(block, at, access, row);
    let moved = f.at_points::<N>(block, at, N, &u.moved(&f, access, row));
    let mut speeds = f.at_points::<N>(block, at, N, &u.relative(&f));
    let (zero, one) = (L::zero(), L::splat(1.0));
    let share = L::load(&block.share[at..]);
    let softness = Soft::load(&u, k, share);
    let sigma = softness.mass_scale;
    let rate = sigma * softness.bias_rate;
    let (inv_h, push, most) = (L::splat(k.inv_h), L::splat(-k.push_out_speed) * share, L::splat(SPEED_MOST));
    let mut sum = Sum::nothing();
    for i in 0..N {
        let rows = &mut block.points[i];
        let s = L::load(&rows.separation[at..]) + moved[i];
        let open = s.gt(zero);
        let bias = L::select(open, s * inv_h, (rate * s).max(push));
        let scale = L::select(open, one, sigma);
        let soft = L::select(open, zero, softness.impulse_scale);
        let old = L::load(&rows.impulse[at..]);
        let mass = L::load(&rows.mass[at..]);
        let new = (old - mass * (scale * speeds[i] + bias) - soft * old).max(zero).min(mass * most);
        let new = taken(mass, new, old);
        new.store(&mut rows.impulse[at..]);
        sum.add(block, at, i, new - old, &mut speeds);
    }
    u.push_points(&f, block, at, &sum);
    u.store(access, row);
}

/// Points without mass are none, or another's (`stage::articulated`): they keep what they have.
#[inline(always)]
fn taken<L: Lanes>(mass: L, new: L, old: L) -> L {
    L::select(mass.gt(L::zero()), new, old)
}

#[inline(always)]
fn relax<L: Lanes, const N: usize>(
    block: &mut Block,
    at: usize,
    access: &mut Scatter<'_, BodyState>,
    row: usize,
    k: &StepConstants,
) {
    let f = Frame::<L>::load(block, at);
    let mut u = Pair::load(block, at, access, row);
    let moved = f.at_points::<N>(block, at, N, &u.moved(&f, access, row));
    let mut speeds = f.at_points::<N>(block, at, N, &u.relative(&f));
    let zero = L::zero();
    let (inv_h, most) = (L::splat(k.inv_h), L::splat(SPEED_MOST));
    let (mut total, mut twist_limit) = (zero, zero);
    let mut sum = Sum::nothing();
    for i in 0..N {
        let (rows, sums) = (&mut block.points[i], &mut block.sums[i]);
        let bias = (L::load(&rows.separation[at..]) + moved[i]).max(zero) * inv_h;
        let old = L::load(&rows.impulse[at..]);
        let mass = L::load(&rows.mass[at..]);
        let new = taken(mass, (old - mass * (speeds[i] + bias)).max(zero).min(mass * most), old);
        new.store(&mut rows.impulse[at..]);
        (L::load(&sums.total[at..]) + new).store(&mut sums.total[at..]);
        total = total + new;
        twist_limit = twist_limit + L::load(&sums.lever[at..]) * new;
        sum.add(block, at, i, new - old, &mut speeds);
    }
    u.push_points(&f, block, at, &sum);
    let mu = L::load(&block.mu[at..]);
    twist(block, at, &mut u, f.n, mu * twist_limit);
    if block.any_rolling {
        let limit = L::load(&block.rolling[at..]) * total;
        rolling(block, at, &mut u, limit);
    }
    friction(block, at, &mut u, &f, mu * total);
    u.store(access, row);
}

#[inline(always)]
fn twist<L: Lanes>(block: &mut Block, at: usize, u: &mut Pair<L>, n: Wide3<L>, limit: L) {
    let old = L::load(&block.twist_impulse[at..]);
    let wanted = old - L::load(&block.twist_mass[at..]) * n.dot(u.wb.sub(u.wa));
    let new = wanted.max(-limit).min(limit);
    new.store(&mut block.twist_impulse[at..]);
    u.turn(block, at, n.scale(new - old));
}

#[inline(always)]
fn rolling<L: Lanes>(block: &mut Block, at: usize, u: &mut Pair<L>, limit: L) {
    let old = Wide3::<L>::load(&block.rolling_impulse, at);
    let wanted = old.sub(u.wb.sub(u.wa).times(&block.rolling_mass, at));
    let size2 = wanted.dot(wanted);
    let scale = L::select(size2.gt(limit * limit), limit / size2.sqrt(), L::splat(1.0));
    let new = wanted.scale(scale);
    new.store(&mut block.rolling_impulse, at);
    u.turn(block, at, new.sub(old));
}

#[inline(always)]
fn friction<L: Lanes>(block: &mut Block, at: usize, u: &mut Pair<L>, f: &Frame<L>, limit: L) {
    let new = friction_impulse(block, at, u, f, limit);
    let mut d = [L::zero(); 2];
    for i in 0..2 {
        let (total, impulse) = (&mut block.friction_total[i][at..], &mut block.friction_impulse[i][at..]);
        (L::load(total) + new[i]).store(total);
        d[i] = new[i] - L::load(impulse);
        new[i].store(impulse);
    }
    u.push_friction(f, block, at, d);
}

/// The friction impulse that stops the slip, within the bound.
#[inline(always)]
fn friction_impulse<L: Lanes>(block: &Block, at: usize, u: &Pair<L>, f: &Frame<L>, limit: L) -> [L; 2] {
    let v = u.relative(f).v;
    let surface = surface::<L>(block, at);
    let (v1, v2) = (f.t[0].dot(v) - surface[0], f.t[1].dot(v) - surface[1]);
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

/// The impulse of the rebound bears friction as the one that stopped the approach did: Δv_t ≤ μ (1 + e) v_n in all.
#[inline(always)]
fn rebound_friction<L: Lanes>(block: &mut Block, at: usize, u: &mut Pair<L>, f: &Frame<L>, added: L) {
    let mut total = L::zero();
    for i in 0..block.points_max.min(4) {
        total = total + L::load(&block.points[i].impulse[at..]);
    }
    let wanted = friction_impulse(block, at, u, f, L::load(&block.mu[at..]) * total);
    // Lanes that did not bounce keep theirs: a row must not depend on its neighbours.
    let bounced = added.gt(L::zero()) | added.lt(L::zero());
    let mut d = [L::zero(); 2];
    for i in 0..2 {
        let (total, impulse) = (&mut block.friction_total[i][at..], &mut block.friction_impulse[i][at..]);
        let old = L::load(impulse);
        let new = L::select(bounced, wanted[i], old);
        d[i] = new - old;
        (L::load(total) + d[i]).store(total);
        new.store(impulse);
    }
    u.push_friction(f, block, at, d);
}

#[inline(always)]
fn restitution<L: Lanes>(
    block: &mut Block,
    at: usize,
    access: &mut Scatter<'_, BodyState>,
    row: usize,
    back: bool,
) {
    let f = Frame::<L>::load(block, at);
    let mut u = Pair::load(block, at, access, row);
    let count = block.points_max.min(4);
    let mut speeds = f.at_points::<4>(block, at, count, &u.relative(&f));
    let zero = L::zero();
    let (mut added, mut change) = (zero, L::splat(-1.0));
    // Poisson's bound: what is given back is at most e times what was taken. Newton's law alone adds energy where friction
    // turns the body during the impact (Kane & Levinson 1985). The allowance is for gravity within the step.
    let e = L::load(&block.restitution[at..]);
    let mut budget = L::load(&block.compression[at..]) * (L::splat(1.0) + e * L::splat(POISSON));
    for i in 0..count {
        budget = budget - L::load(&block.sums[i].total[at..]);
    }
    let mut sum = Sum::nothing();
    for i in 0..count {
        let (rows, sums) = (&mut block.points[i], &mut block.sums[i]);
        let rebound = L::load(&sums.rebound[at..]);
        let total = L::load(&sums.total[at..]);
        let bounces = rebound.gt(zero) & total.gt(zero);
        if !bounces.any() {
            continue;
        }
        let old = L::load(&rows.impulse[at..]);
        let mass = L::load(&rows.mass[at..]);
        let target = if back { rebound } else { zero };
        let wanted = (old - mass * (speeds[i] - target)).max(zero).min(mass * L::splat(SPEED_MOST));
        let wanted = taken(mass, wanted, old);
        let wanted = if back { wanted.min(old + budget.max(zero)) } else { wanted.max(old) };
        let new = L::select(bounces, wanted, old);
        budget = budget - (new - old);
        new.store(&mut rows.impulse[at..]);
        // What is over of the last substep's impulse may be taken back, not the other substeps'.
        (total + (new - old)).store(&mut sums.total[at..]);
        added = added + (new - old);
        let moved = L::select(bounces & mass.gt(zero), (new - old).abs() / mass, L::splat(-1.0));
        change = change.max(moved);
        sum.add(block, at, i, new - old, &mut speeds[..count]);
    }
    change.store(&mut block.rebound_change[at..]);
    u.push_points(&f, block, at, &sum);
    rebound_friction(block, at, &mut u, &f, added);
    u.store(access, row);
}
