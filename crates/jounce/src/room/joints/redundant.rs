//! What each joint of a loop bears.
//!
//! Two hinges of a door say the same about five of its freedoms: of λ only Jᵀλ is determined, the load, and to it anything may be added that has
//! Jᵀλ₀ = 0. Rounding of the joints' places does: against one another they pull with thousands of newtons that move nothing, would
//! break what is to break, and pass for tension. So at the end of a substep
//!
//! λ′ = (A + E)⁻¹ A λ, A = J M⁻¹ Jᵀ, E = ε diag A,
//!
//! which has the same Jᵀλ up to ε and of all that do the least Σ A_ii λ_i²: two hinges bear the weight of a door in equal parts; of three bolts in a
//! row the middle one, which meets most mass, bears more. (Tikhonov's regularisation:
//! Tikhonov & Arsenin, Solutions of ill-posed problems, 1977; redundant constraints: Wojtyra, Joint reaction forces in multibody systems with
//! redundant constraints, 2005.)

use super::direct::Plan;
use super::set::{Constants, JointSet};
use super::solve::{HARD, dot64};
use jounce_math::Vec3;

impl JointSet {
    /// See the module's text; the rows are those of the pass before.
    pub(super) fn share_out(&mut self, k: &Constants) {
        if !self.plan.as_ref().is_some_and(Plan::has_loops) {
            return;
        }
        core::mem::swap(&mut self.numbers, &mut self.other);
        self.fill(k.h);
        core::mem::swap(&mut self.numbers, &mut self.other);
        let Self { plan, joints, bodies, other, .. } = self;
        let Some(plan) = plan else { return };
        plan.factor(other, true);
        plan.reserve(other);
        bodies.iter_mut().for_each(|b| b.dv = [0.0; 6]);
        for s in joints.iter() {
            for &code in &s.packed[..s.count] {
                let lambda = f64::from(s.impulse(code));
                for (body, (l, j)) in [(s.a, s.end(code, true)), (s.b, s.end(code, false))] {
                    bodies[body].push(l, j, lambda);
                }
            }
        }
        for (i, s) in joints.iter().enumerate() {
            let (a, b) = (bodies[s.a].changed(), bodies[s.b].changed());
            for (r, &code) in s.packed[..s.count].iter().enumerate() {
                let speed = |(l, j): (Vec3, Vec3), (v, w): ([f64; 3], [f64; 3])| dot64(l, v) + dot64(j, w);
                let own = s.compliance(code, bodies, k.h) * f64::from(s.impulse(code));
                plan.set(other, i, r, speed(s.end(code, true), a) + speed(s.end(code, false), b) + own);
            }
        }
        plan.solve(other);
        // What an end, a motor or a rope can give is its own affair.
        let fits = |(i, s): (usize, &super::solve::Solve)| {
            let rope = s.sign == 0.0 || s.count == 0 || s.sign * plan.get(other, i, 0) as f32 >= 0.0;
            rope && s.packed[..s.count].iter().enumerate().filter(|(_, c)| usize::from(**c) >= HARD).all(
                |(r, &c)| {
                    let x = &s.extra[usize::from(c) - HARD];
                    let lambda = plan.get(other, i, r) as f32;
                    x.allowed(lambda, k.h) == lambda
                },
            )
        };
        if !joints.iter().enumerate().all(fits) {
            return;
        }
        for (i, s) in joints.iter_mut().enumerate() {
            for r in 0..s.count {
                let lambda = plan.get(other, i, r) as f32;
                match usize::from(s.packed[r]) {
                    c if c < HARD => s.lambda[c] = lambda,
                    c => s.extra[c - HARD].impulse = lambda,
                }
            }
        }
    }
}
