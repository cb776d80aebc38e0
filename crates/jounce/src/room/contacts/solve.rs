//! Scalar solver passes over blocks of rows; the equations are in the room's text.
//!
//! Row by row within a block: rows of a block touch disjoint bodies, so the order of the rows does not matter, and a
//! kernel of any width gives the same bits as this one if it keeps the order of operations of a row.

use super::prepare::StepConstants;
use super::rows::{Block, Jacobian, LANES, Lane};
use crate::room::rigid::state::BodyState;
use jounce_math::{Vec3, scalar::f32s};

/// Velocities of the two bodies of a row, changed by impulses.
struct Pair {
    va: Vec3,
    wa: Vec3,
    vb: Vec3,
    wb: Vec3,
    ma: f32,
    mb: f32,
}

impl Pair {
    #[inline(always)]
    fn load(block: &Block, l: usize, a: &BodyState, b: &BodyState) -> Self {
        Self { va: a.v, wa: a.w, vb: b.v, wb: b.w, ma: block.inv_mass_a[l], mb: block.inv_mass_b[l] }
    }
    #[inline(always)]
    fn store(&self, a: &mut BodyState, b: &mut BodyState) {
        (a.v, a.w, b.v, b.w) = (self.va, self.wa, self.vb, self.wb);
    }
    /// J u along a direction.
    #[inline(always)]
    fn speed(&self, dir: Vec3, j: &Jacobian, l: usize) -> f32 {
        dir.dot(self.vb - self.va) + j.b.get(l).dot(self.wb) - j.a.get(l).dot(self.wa)
    }
    /// u ← u + M⁻¹ Jᵀ λ.
    #[inline(always)]
    fn push(&mut self, dir: Vec3, j: &Jacobian, l: usize, lambda: f32) {
        self.va -= dir * (self.ma * lambda);
        self.wa -= j.ia.get(l) * lambda;
        self.vb += dir * (self.mb * lambda);
        self.wb += j.ib.get(l) * lambda;
    }
}

/// Applies the impulses of the last substep (or step).
#[inline(always)]
pub(crate) fn warm_start(block: &mut Block, l: usize, a: &mut BodyState, b: &mut BodyState) {
    let l = l % LANES;
    let n = block.normal.get(l);
    let mut u = Pair::load(block, l, a, b);
    for rows in block.points.iter().take(usize::from(block.count[l])) {
        u.push(n, &rows.j, l, rows.impulse[l]);
    }
    let t1 = block.tangent.get(l);
    let t2 = n.cross(t1);
    u.push(t1, &block.friction[0], l, block.friction_impulse[0][l]);
    u.push(t2, &block.friction[1], l, block.friction_impulse[1][l]);
    let twist = block.twist_impulse[l];
    u.wa -= block.twist_ia.get(l) * twist;
    u.wb += block.twist_ib.get(l) * twist;
    if block.any_rolling {
        let p = block.rolling_impulse.get(l);
        u.wa -= symmetric_mul(&block.rolling_ia, l, p);
        u.wb += symmetric_mul(&block.rolling_ib, l, p);
    }
    u.store(a, b);
}

#[inline(always)]
fn symmetric_mul(t: &[Lane; 6], l: usize, v: Vec3) -> Vec3 {
    let [xx, yy, zz, xy, xz, yz] = [t[0][l], t[1][l], t[2][l], t[3][l], t[4][l], t[5][l]];
    Vec3::new(xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z)
}

/// The first pass of a substep: normal rows with soft bias, no friction.
#[inline(always)]
pub(crate) fn solve(block: &mut Block, l: usize, a: &mut BodyState, b: &mut BodyState, k: &StepConstants) {
    let l = l % LANES;
    let n = block.normal.get(l);
    let dp = n.dot(b.dp - a.dp);
    let mut u = Pair::load(block, l, a, b);
    let (rate, sigma, iota) = (block.bias_rate[l], block.mass_scale[l], block.impulse_scale[l]);
    for rows in block.points.iter_mut().take(usize::from(block.count[l])) {
        let s = rows.separation[l] + dp + rows.j.b.get(l).dot(b.dr) - rows.j.a.get(l).dot(a.dr);
        let (bias, scale, soft) = if s > 0.0 {
            (s * k.inv_h, 1.0, 0.0)
        } else {
            (f32s::max(sigma * rate * s, -k.push_out_speed), sigma, iota)
        };
        let vn = u.speed(n, &rows.j, l);
        let old = rows.impulse[l];
        let new = f32s::max(old - rows.mass[l] * (scale * vn + bias) - soft * old, 0.0);
        rows.impulse[l] = new;
        u.push(n, &rows.j, l, new - old);
    }
    u.store(a, b);
}

/// The second pass: normal rows without bias, then twist, rolling and friction.
#[inline(always)]
pub(crate) fn relax(block: &mut Block, l: usize, a: &mut BodyState, b: &mut BodyState, k: &StepConstants) {
    let l = l % LANES;
    let n = block.normal.get(l);
    let dp = n.dot(b.dp - a.dp);
    let mut u = Pair::load(block, l, a, b);
    let (mut total, mut twist_limit) = (0.0, 0.0);
    for rows in block.points.iter_mut().take(usize::from(block.count[l])) {
        let s = rows.separation[l] + dp + rows.j.b.get(l).dot(b.dr) - rows.j.a.get(l).dot(a.dr);
        let bias = if s > 0.0 { s * k.inv_h } else { 0.0 };
        let vn = u.speed(n, &rows.j, l);
        let old = rows.impulse[l];
        let new = f32s::max(old - rows.mass[l] * (vn + bias), 0.0);
        rows.impulse[l] = new;
        rows.total[l] += new;
        total += new;
        twist_limit += rows.lever[l] * new;
        u.push(n, &rows.j, l, new - old);
    }
    twist(block, l, &mut u, n, block.mu[l] * (twist_limit + block.twist_patch[l] * total));
    if block.any_rolling {
        rolling(block, l, &mut u, block.rolling[l] * total);
    }
    friction(block, l, &mut u, n, block.mu[l] * total);
    u.store(a, b);
}

#[inline(always)]
fn twist(block: &mut Block, l: usize, u: &mut Pair, n: Vec3, limit: f32) {
    let old = block.twist_impulse[l];
    let new = f32s::clamp(old - block.twist_mass[l] * n.dot(u.wb - u.wa), -limit, limit);
    block.twist_impulse[l] = new;
    u.wa -= block.twist_ia.get(l) * (new - old);
    u.wb += block.twist_ib.get(l) * (new - old);
}

#[inline(always)]
fn rolling(block: &mut Block, l: usize, u: &mut Pair, limit: f32) {
    let old = block.rolling_impulse.get(l);
    let mut new = old - symmetric_mul(&block.rolling_mass, l, u.wb - u.wa);
    let size2 = new.length_squared();
    if size2 > limit * limit {
        new = new * (limit / size2.sqrt());
    }
    block.rolling_impulse.set(l, new);
    let d = new - old;
    u.wa -= symmetric_mul(&block.rolling_ia, l, d);
    u.wb += symmetric_mul(&block.rolling_ib, l, d);
}

#[inline(always)]
fn friction(block: &mut Block, l: usize, u: &mut Pair, n: Vec3, limit: f32) {
    let t1 = block.tangent.get(l);
    let t2 = n.cross(t1);
    let v1 = u.speed(t1, &block.friction[0], l) - block.surface_speed[0][l];
    let v2 = u.speed(t2, &block.friction[1], l) - block.surface_speed[1][l];
    let [xx, xy, yy] = [block.friction_mass[0][l], block.friction_mass[1][l], block.friction_mass[2][l]];
    let (old1, old2) = (block.friction_impulse[0][l], block.friction_impulse[1][l]);
    let mut new1 = old1 - (xx * v1 + xy * v2);
    let mut new2 = old2 - (xy * v1 + yy * v2);
    let size2 = new1 * new1 + new2 * new2;
    if size2 > limit * limit {
        let scale = limit / size2.sqrt();
        new1 *= scale;
        new2 *= scale;
    }
    block.friction_impulse[0][l] = new1;
    block.friction_impulse[1][l] = new2;
    block.friction_total[0][l] += new1;
    block.friction_total[1][l] += new2;
    u.push(t1, &block.friction[0], l, new1 - old1);
    u.push(t2, &block.friction[1], l, new2 - old2);
}

/// After the last substep: gives back e V where the approach was fast enough and the contact pushed.
#[inline(always)]
pub(crate) fn restitution(block: &mut Block, l: usize, a: &mut BodyState, b: &mut BodyState) {
    let l = l % LANES;
    let n = block.normal.get(l);
    let mut u = Pair::load(block, l, a, b);
    for rows in block.points.iter_mut().take(usize::from(block.count[l])) {
        if rows.rebound[l] == 0.0 || rows.total[l] == 0.0 {
            continue;
        }
        let vn = u.speed(n, &rows.j, l);
        let old = rows.impulse[l];
        let new = f32s::max(old - rows.mass[l] * (vn - rows.rebound[l]), 0.0);
        rows.impulse[l] = new;
        rows.total[l] += new - old;
        u.push(n, &rows.j, l, new - old);
    }
    u.store(a, b);
}
