//! A = L D Lᵀ and A λ = r in lanes, block by block, f32.
//!
//! Column k of joint rows n: its diagonal block is factored as L D Lᵀ; the blocks below become X = B L⁻ᵀ, then W = X D⁻¹, and what
//! they meet changes by A_ij −= W_i X_jᵀ. In place: below the diagonal L and W, on it D⁻¹. A pivot that vanishes gives D⁻¹ = 0: the
//! row takes no impulse.

use super::{Band, ROWS};
use crate::room::contacts::rows::{LANES, Lane};
use crate::room::joints::lanes::inverse;
use jounce_lanes::{Kernel, Lanes, three};

/// A pivot below this part of its diagonal belongs to a row that others make superfluous.
const PIVOT_MIN: f32 = 1e-6;

/// The matrix of the rows that take part, in factors.
pub(super) struct Factor<'a>(pub &'a mut Band);

impl Kernel for Factor<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        for at in (0..LANES).step_by(L::WIDTH) {
            assemble::<L>(self.0, at);
            factor::<L>(self.0, at);
        }
    }
}

#[inline(always)]
fn get<L: Lanes>(m: &[Lane], i: usize, at: usize) -> L {
    L::load(&m[i][at..])
}

#[inline(always)]
fn assemble<L: Lanes>(band: &mut Band, at: usize) {
    let Band { pattern, bodies, joints, matrix, .. } = band;
    for m in matrix.iter_mut() {
        L::zero().store(&mut m[at..]);
    }
    for m in &pattern.meets {
        let (i, k) = (m.i as usize, m.k as usize);
        let (ji, jk) = (&joints[i], &joints[k]);
        let (rows, columns) = (pattern.rows(i), pattern.rows(k));
        let inv_mass = L::load(&bodies[m.body as usize].inv_mass[at..]);
        let lin = if m.i_is_a == m.k_is_a { inv_mass } else { -inv_mass };
        let first_end = pattern.first_end(k);
        for c in 0..columns {
            let row = &jk.rows[c];
            let inv = if m.k_is_a { &row.ia } else { &row.ib };
            let mut inv = three(
                #[inline(always)]
                |x: usize| L::load(&inv.0[x][at..]),
            );
            if c >= first_end {
                let acts = L::load(&row.acts[at..]);
                inv = three(
                    #[inline(always)]
                    |x| inv[x] * acts,
                );
            }
            // Diagonal blocks: the lower half.
            for r in if i == k { c } else { 0 }..rows {
                let j = if m.i_is_a { &ji.rows[r].ja } else { &ji.rows[r].jb };
                let j = three(
                    #[inline(always)]
                    |x: usize| L::load(&j.0[x][at..]),
                );
                let mut value = j[0] * inv[0] + j[1] * inv[1] + j[2] * inv[2];
                if r == c && r < 3 {
                    value = value + lin;
                }
                if r >= pattern.first_end(i) {
                    value = value * L::load(&ji.rows[r].acts[at..]);
                }
                let to = &mut matrix[m.at as usize + r * columns + c][at..];
                (L::load(to) + value).store(to);
            }
        }
    }
    for s in &pattern.steps {
        let n = pattern.rows(s.joint);
        for r in pattern.first_end(s.joint)..n {
            let to = &mut matrix[s.diagonal + r * (n + 1)][at..];
            let acts = L::load(&joints[s.joint].rows[r].acts[at..]);
            (L::load(to) + (L::splat(1.0) - acts)).store(to);
        }
    }
}

#[inline(always)]
fn factor<L: Lanes>(band: &mut Band, at: usize) {
    let Band { pattern, matrix, .. } = band;
    let mut scratch = [[L::zero(); ROWS]; ROWS];
    for s in &pattern.steps {
        let (n, d) = (pattern.rows(s.joint), s.diagonal);
        // L D Lᵀ of the diagonal block: l and 1/d in registers for what is below.
        let mut l = [[L::zero(); ROWS]; ROWS];
        let mut inv = [L::zero(); ROWS];
        let mut pivots = [L::zero(); ROWS];
        for j in 0..n {
            let whole: L = get(matrix, d + j * n + j, at);
            let mut pivot = whole;
            for k in 0..j {
                pivot = pivot - l[j][k] * l[j][k] * pivots[k];
            }
            let holds = pivot.gt(whole * L::splat(PIVOT_MIN));
            pivots[j] = L::select(holds, pivot, L::zero());
            inv[j] = inverse(pivots[j]);
            inv[j].store(&mut matrix[d + j * n + j][at..]);
            for i in j + 1..n {
                let mut sum: L = get(matrix, d + i * n + j, at);
                for k in 0..j {
                    sum = sum - l[i][k] * l[j][k] * pivots[k];
                }
                l[i][j] = sum * inv[j];
                l[i][j].store(&mut matrix[d + i * n + j][at..]);
            }
        }
        // X = B L⁻ᵀ.
        for &(joint, b) in &s.below {
            for r in 0..pattern.rows(joint) {
                let mut x = [L::zero(); ROWS];
                for c in 0..n {
                    let mut sum: L = get(matrix, b + r * n + c, at);
                    for e in 0..c {
                        sum = sum - x[e] * l[c][e];
                    }
                    x[c] = sum;
                    sum.store(&mut matrix[b + r * n + c][at..]);
                }
            }
        }
        let mut target = 0;
        for (m, &(joint, b)) in s.below.iter().enumerate() {
            let rows = pattern.rows(joint);
            for r in 0..rows {
                for c in 0..n {
                    scratch[r][c] = get::<L>(matrix, b + r * n + c, at) * inv[c];
                }
            }
            for &(other, o) in &s.below[..=m] {
                let to = s.targets[target];
                target += 1;
                let columns = pattern.rows(other);
                for c in 0..columns {
                    let mut x = [L::zero(); ROWS];
                    for e in 0..n {
                        x[e] = get(matrix, o + c * n + e, at);
                    }
                    for r in if o == b { c } else { 0 }..rows {
                        let t = to + r * columns + c;
                        let mut sum: L = get(matrix, t, at);
                        for e in 0..n {
                            sum = sum - scratch[r][e] * x[e];
                        }
                        sum.store(&mut matrix[t][at..]);
                    }
                }
            }
        }
        for &(joint, b) in &s.below {
            for r in 0..pattern.rows(joint) {
                for c in 0..n {
                    let to = &mut matrix[b + r * n + c][at..];
                    (L::load(to) * inv[c]).store(to);
                }
            }
        }
    }
}

/// Right sides in `x` of the rows to λ.
#[inline(always)]
pub(super) fn solve<L: Lanes>(band: &mut Band, at: usize) {
    let Band { pattern, joints, matrix, .. } = band;
    for s in &pattern.steps {
        let (n, d) = (pattern.rows(s.joint), s.diagonal);
        let mut y = [L::zero(); ROWS];
        for i in 0..n {
            let mut sum = L::load(&joints[s.joint].rows[i].x[at..]);
            for e in 0..i {
                sum = sum - get::<L>(matrix, d + i * n + e, at) * y[e];
            }
            y[i] = sum;
        }
        for &(joint, b) in &s.below {
            for r in 0..pattern.rows(joint) {
                let x = &mut joints[joint].rows[r].x[at..];
                let mut sum = L::load(x);
                for c in 0..n {
                    sum = sum - get::<L>(matrix, b + r * n + c, at) * y[c];
                }
                sum.store(x);
            }
        }
        for i in 0..n {
            (y[i] * get::<L>(matrix, d + i * n + i, at)).store(&mut joints[s.joint].rows[i].x[at..]);
        }
    }
    for s in pattern.steps.iter().rev() {
        let (n, d) = (pattern.rows(s.joint), s.diagonal);
        let mut z = [L::zero(); ROWS];
        for i in 0..n {
            z[i] = L::load(&joints[s.joint].rows[i].x[at..]);
        }
        for &(joint, b) in &s.below {
            for r in 0..pattern.rows(joint) {
                let x = L::load(&joints[joint].rows[r].x[at..]);
                for c in 0..n {
                    z[c] = z[c] - get::<L>(matrix, b + r * n + c, at) * x;
                }
            }
        }
        for i in (0..n).rev() {
            for e in i + 1..n {
                z[i] = z[i] - get::<L>(matrix, d + e * n + i, at) * z[e];
            }
            z[i].store(&mut joints[s.joint].rows[i].x[at..]);
        }
    }
}
