//! Geometric stiffness: tension acts implicitly where explicit motion could not stand it (see the text of `set`).

use super::rows::Ends;
use super::set::{Constants, JointSet};
use jounce_math::{Mat3, Vec3};

impl JointSet {
    /// Geometric stiffness: see the module's text.
    pub(super) fn stiffen(&mut self, k: &Constants) {
        for b in &mut self.bodies {
            (b.added_inertia, b.held, b.swung) = (Mat3::ZERO, 0, 0.0);
        }
        for s in &mut self.joints {
            let n = if s.rod { 1 } else { s.hard.n };
            let (mut fa, mut fb) = (Vec3::ZERO, Vec3::ZERO);
            for (row, l) in s.hard.rows[..n].iter().zip(&s.lambda) {
                fa += row.la * *l;
                fb += row.lb * *l;
            }
            let e = Ends::now(&s.start, &self.bodies[s.a].m, &self.bodies[s.b].m);
            for (body, r, f) in [(s.a, e.ra, fa), (s.b, e.rb, fb)] {
                let b = &mut self.bodies[body];
                (b.held, b.swung) = (b.held + 1, r.length_squared());
                let g = k.h * r.dot(f);
                if g > 0.0 {
                    let n = r / r.length();
                    let across = Mat3::IDENTITY - Mat3::outer(n, n);
                    b.added_inertia = b.added_inertia + across.scale(g);
                }
            }
            let (length, pull) = (e.d.length(), -s.lambda[0]);
            if s.rod && s.hard.n == 3 {
                let g = if length > 1e-6 { k.h * pull / length } else { 0.0 };
                for r in 1..3 {
                    let inv = s.meets_itself(r, r, &self.bodies[s.a], &self.bodies[s.b]) as f32;
                    // Beyond a part of the mass that the ends have across the rod.
                    let over = if inv > 0.0 { g - STOOD / inv } else { 0.0 };
                    s.give_way[r] = if over > 0.0 { 1.0 / over } else { f32::INFINITY };
                }
            }
        }
        for b in &mut self.bodies {
            b.raise_part();
            b.apply_added();
        }
    }

    /// The turns of what tension added to: (I + G′) ω′ = I ω.
    pub(super) fn damp(&mut self) {
        for b in &mut self.bodies {
            if let Some(inertia) = b.inertia
                && b.added_inertia != Mat3::ZERO
            {
                b.m.w = b.tensor.mul(inertia * b.m.w);
            }
        }
    }
}

/// h² f/L that explicit motion stands across a rod, as part of the mass there: ω h = 1/2, twelve substeps a swing. At ω h = 1 what is flung about by a load at the
/// rod's other end gained energy.
const STOOD: f32 = 0.25;
