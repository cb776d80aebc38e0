//! Implicit Euler: Newton's iteration with GMRES inside, without a matrix.
//!
//! Solves R(u) = u − u₀ − h F(u) = 0. Newton: J δ = −R, J = ∂R/∂u = 1 − h ∂F/∂u. GMRES needs J only as a product, and
//! J p ≈ p − h (F(u + ε p) − F(u))/ε, so that a cloth of thousands of springs needs no n × n storage and no derivative
//! of its forces. J of springs with friction or rotation is not symmetric and, of compressed springs, not definite;
//! hence GMRES and not conjugate gradients.
//!
//! u: unknown (the new velocities of a mechanical system, the new state of any other); h: step; ε: √(machine epsilon)
//! scaled with |u|; δ: Newton's correction; λ: the part of it that is taken.
//! Source: D. A. Knoll and D. E. Keyes, "Jacobian-free Newton–Krylov methods", J. Comput. Phys. 193 (2004);
//! Y. Saad and M. H. Schultz, "GMRES", SIAM J. Sci. Stat. Comput. 7 (1986).

use super::Vector;
use super::fixed::{add_scaled, sum_scaled};
use crate::limits::{BACKTRACKS_MAX, KRYLOV_MAX, KRYLOV_RESTARTS_MAX, NEWTON_MAX};
use jounce_math::scalar::f64s::max;

/// GMRES reduces the residual by this before Newton looks again. A hanging and a folded cloth took 5 and 3 times as many
/// forces with 1e-6: what is gained on the tangent is lost at the next look.
const FORCING: f64 = 0.1;
/// √(machine epsilon), the step of a finite difference.
const DIFFERENCE: f64 = 1.5e-8;

/// Scratch of the solver; grows to what was needed and stays.
#[derive(Clone, Debug, Default)]
pub(super) struct Newton<V> {
    /// −R(u).
    residual: Vec<V>,
    delta: Vec<V>,
    /// u + λ δ, and the point of a finite difference.
    trial: Vec<V>,
    /// F(u).
    force: Vec<V>,
    gmres: Gmres<V>,
}

/// Scratch of the linear solver.
#[derive(Clone, Debug, Default)]
struct Gmres<V> {
    /// Krylov directions, one after the other.
    basis: Vec<V>,
    /// J times the latest direction.
    image: Vec<V>,
    /// Hessenberg matrix by columns, turned into a triangle by Givens rotations.
    hessenberg: Vec<f64>,
    rotation: Vec<(f64, f64)>,
    rhs: Vec<f64>,
}

/// Euclidean length of a column.
pub(super) fn norm<V: Vector>(a: &[V]) -> f64 {
    dot(a, a).sqrt()
}

fn dot<V: Vector>(a: &[V], b: &[V]) -> f64 {
    a.iter().zip(b).fold(0.0, |s, (a, b)| s + a.dot(*b))
}

impl<V: Vector> Newton<V> {
    /// Solves u = u₀ + h F(u), from the guess in `u`. False where no answer within `tolerance` (relative to the size of
    /// the state and of the change) is found; `u` then holds nothing of use. Where rounding of F lets nothing get
    /// smaller, a residual up to `floor` is an answer.
    pub(super) fn solve(
        &mut self,
        u: &mut [V],
        u0: &[V],
        h: f64,
        tolerance: f64,
        floor: f64,
        f: &mut impl FnMut(&[V], &mut [V]),
    ) -> bool {
        for c in [&mut self.residual, &mut self.delta, &mut self.trial, &mut self.force] {
            c.resize(u.len(), V::default());
        }
        self.gmres.reserve(u.len());
        self.trial.copy_from_slice(u);
        let mut size = self.residual_of_trial(u0, h, f);
        // Squares of anything smaller than this leave the range of f64.
        let scale = max(norm(u0) + h.abs() * norm(&self.force), 1e-140);
        for _ in 0..NEWTON_MAX {
            if size <= tolerance * scale {
                return true;
            }
            let at = Linear { u, h, force: &self.force, u_size: norm(u) };
            self.gmres.solve(&at, &self.residual, &mut self.delta, &mut self.trial, f);
            let before = size;
            let mut part = 1.0;
            for _ in 0..BACKTRACKS_MAX {
                sum_scaled(&mut self.trial, u, part, &self.delta);
                size = self.residual_of_trial(u0, h, f);
                if size < before {
                    break;
                }
                part *= 0.5;
            }
            if size.is_nan() || size >= before {
                return before <= max(max(tolerance, 1e-9) * scale, floor);
            }
            u.copy_from_slice(&self.trial);
        }
        size <= max(max(tolerance, 1e-9) * scale, floor)
    }

    /// Leaves −R and F of `trial` behind, gives |R|.
    fn residual_of_trial(&mut self, u0: &[V], h: f64, f: &mut impl FnMut(&[V], &mut [V])) -> f64 {
        f(&self.trial, &mut self.force);
        for i in 0..u0.len() {
            self.residual[i] = u0[i] + self.force[i] * h - self.trial[i];
        }
        norm(&self.residual)
    }
}

/// J at a point.
struct Linear<'a, V> {
    u: &'a [V],
    u_size: f64,
    h: f64,
    force: &'a [V],
}

impl<V: Vector> Linear<'_, V> {
    /// out = J p; `point` is scratch.
    fn product(&self, p: &[V], out: &mut [V], point: &mut [V], f: &mut impl FnMut(&[V], &mut [V])) {
        let p_size = norm(p);
        if p_size == 0.0 {
            return out.fill(V::default());
        }
        let e = DIFFERENCE * (1.0 + self.u_size) / p_size;
        sum_scaled(point, self.u, e, p);
        f(point, out);
        for i in 0..p.len() {
            out[i] = p[i] - (out[i] - self.force[i]) * (self.h / e);
        }
    }
}

impl<V: Vector> Gmres<V> {
    fn reserve(&mut self, n: usize) {
        self.basis.resize((KRYLOV_MAX + 1) * n, V::default());
        self.image.resize(n, V::default());
        self.hessenberg.resize((KRYLOV_MAX + 1) * KRYLOV_MAX, 0.0);
        self.rotation.resize(KRYLOV_MAX, (1.0, 0.0));
        self.rhs.resize(KRYLOV_MAX + 1, 0.0);
    }

    /// `delta` with J δ ≈ b, to `FORCING`, or as near as the restarts allow.
    fn solve(
        &mut self,
        j: &Linear<'_, V>,
        b: &[V],
        delta: &mut [V],
        point: &mut [V],
        f: &mut impl FnMut(&[V], &mut [V]),
    ) {
        let n = b.len();
        let wanted = FORCING * norm(b);
        delta.fill(V::default());
        let mut before = f64::INFINITY;
        for restart in 0..KRYLOV_RESTARTS_MAX {
            if restart == 0 {
                self.basis[..n].copy_from_slice(b);
            } else {
                j.product(delta, &mut self.image, point, f);
                sum_scaled(&mut self.basis[..n], b, -1.0, &self.image);
            }
            let left = norm(&self.basis[..n]);
            // What no longer shrinks is the noise of the differences; Newton's next look is worth more.
            if left.is_nan() || left <= wanted || left > 0.9 * before {
                return;
            }
            before = left;
            let used = self.cycle(j, left, wanted, point, f);
            self.add_combination(used, delta);
        }
    }

    /// One cycle of at most `KRYLOV_MAX` directions (modified Gram–Schmidt, Givens rotations). Gives how many.
    fn cycle(
        &mut self,
        j: &Linear<'_, V>,
        left: f64,
        wanted: f64,
        point: &mut [V],
        f: &mut impl FnMut(&[V], &mut [V]),
    ) -> usize {
        let n = self.image.len();
        for v in &mut self.basis[..n] {
            *v = *v * (1.0 / left);
        }
        self.rhs.fill(0.0);
        self.rhs[0] = left;
        for k in 0..KRYLOV_MAX {
            j.product(&self.basis[k * n..(k + 1) * n], &mut self.image, point, f);
            let column = &mut self.hessenberg[k * (KRYLOV_MAX + 1)..(k + 1) * (KRYLOV_MAX + 1)];
            for i in 0..=k {
                let direction = &self.basis[i * n..(i + 1) * n];
                column[i] = dot(&self.image, direction);
                add_scaled(&mut self.image, -column[i], direction);
            }
            let rest = norm(&self.image);
            for i in 0..k {
                let (c, s) = self.rotation[i];
                (column[i], column[i + 1]) =
                    (c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]);
            }
            let length = (column[k] * column[k] + rest * rest).sqrt();
            if !(length > 0.0 && length.is_finite()) {
                return k;
            }
            let (c, s) = (column[k] / length, rest / length);
            self.rotation[k] = (c, s);
            column[k] = length;
            (self.rhs[k], self.rhs[k + 1]) = (c * self.rhs[k], -s * self.rhs[k]);
            if self.rhs[k + 1].abs() <= wanted || rest == 0.0 {
                return k + 1;
            }
            for i in 0..n {
                self.basis[(k + 1) * n + i] = self.image[i] * (1.0 / rest);
            }
        }
        KRYLOV_MAX
    }

    /// Back substitution, then δ += Σ yᵢ vᵢ.
    fn add_combination(&mut self, used: usize, delta: &mut [V]) {
        let n = delta.len();
        for k in (0..used).rev() {
            let mut y = self.rhs[k];
            for i in k + 1..used {
                y -= self.hessenberg[i * (KRYLOV_MAX + 1) + k] * self.rhs[i];
            }
            self.rhs[k] = y / self.hessenberg[k * (KRYLOV_MAX + 1) + k];
        }
        for k in 0..used {
            add_scaled(delta, self.rhs[k], &self.basis[k * n..(k + 1) * n]);
        }
    }
}
