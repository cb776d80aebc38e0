//! Gears, and rack and pinion: the coordinates of two joints go together, C = q_a + ρ q_b − q₀ = 0.
//!
//! q is the angle of a hinge, counted over its turns, or the way of a slider; ρ the ratio (of gears: teeth of b ÷ teeth of a; of a rack: rad/m);
//! q₀ where it stood as the gear was made. With J_a, J_b the rows of the two coordinates (dq/dt = J u; hinge: J = (0, −j, 0, j), j = (x_a + x_b)/(1 +
//! x_a·x_b); slider: J = (−n, −(r_a + d) × n, n, r_b × n), n = x_a), the row is
//!
//! J = J_a + ρ J_b over up to four bodies; what is in both joints (the frame of a gearbox) has the sum of its two parts.
//!
//! λ = −(J u + β C/h)/(J M⁻¹ Jᵀ), β = 1/5; the relaxing pass has no C. All the bodies get the reaction Jᵀ λ, so linear and angular momentum are kept: two
//! gears that drive one another turn their common frame.
//!
//! Solved between the passes over the rows that hold, which answer: a gear couples bodies that need not touch, and would fill the factors.
//!
//! Source: Catto, Box2D gear joint (2007 to v2.4), there in the plane.

use super::desc::JointKind;
use super::extra::Sweep;
use super::local::Local;
use super::rows::{Ends, Row};
use super::set::{Constants, JointSet};
use super::solve::{Solve, limited};
use crate::error::{Result, check};
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_math::Vec3;

/// Part of the error that a substep takes away.
const BETA: f32 = 0.2;

/// A gear between two joints of the set.
#[derive(Clone, Debug)]
pub(crate) struct Gear {
    pub id: u32,
    /// Places of the two joints.
    pub a: usize,
    pub b: usize,
    pub ratio: f32,
    /// q_a + ratio q_b where it stands right.
    pub rest: f32,
    pub impulse: f32,
}

impl JointSet {
    /// One after the other; `warm` gives them what they had last.
    pub(super) fn gears(&mut self, k: &Constants, sweep: Sweep, warm: bool) {
        for g in &mut self.gears {
            let parts = [(g.a, 1.0), (g.b, g.ratio)];
            let mut ends = [(0_usize, Vec3::ZERO, Vec3::ZERO); 4];
            let (mut n, mut c) = (0, -g.rest);
            for (place, scale) in parts {
                let s = &self.joints[place];
                let row = s.main_row(&self.bodies);
                c += scale * s.coordinate;
                for (body, l, j) in [(s.a, row.la, row.ja), (s.b, row.lb, row.jb)] {
                    let at = ends[..n].iter().position(|e| e.0 == body).unwrap_or(n);
                    if at == n {
                        (ends[n], n) = ((body, Vec3::ZERO, Vec3::ZERO), n + 1);
                    }
                    ends[at].1 += l * scale;
                    ends[at].2 += j * scale;
                }
            }
            let (mut inv, mut speed) = (0.0, 0.0);
            for (body, l, j) in &ends[..n] {
                let b = &self.bodies[*body];
                inv += l.dot(l.mul(b.inv_mass)) + j.dot(b.tensor.mul(*j));
                speed += l.dot(b.m.v) + j.dot(b.m.w);
            }
            if inv <= 0.0 {
                continue;
            }
            let d = if warm {
                g.impulse *= k.warm;
                g.impulse
            } else {
                let bias = if sweep == Sweep::Solve { limited(BETA * c / k.h, k.correct) } else { 0.0 };
                let d = -(speed + bias) / inv;
                g.impulse += d;
                d
            };
            for (body, l, j) in &ends[..n] {
                let b = &mut self.bodies[*body];
                b.m.v += l.mul(b.inv_mass) * d;
                b.m.w += b.tensor.mul(*j) * d;
            }
        }
    }
}

impl Solve {
    /// The row of its coordinate.
    fn main_row(&self, bodies: &[Local]) -> Row {
        let e = Ends::now(&self.start, &bodies[self.a].m, &bodies[self.b].m);
        if self.slides { e.along(e.axis_a(0)) } else { e.twist() }
    }
}

impl World {
    /// Bodies of a gear: those that its two joints move.
    pub(super) fn geared(&self, kind: &JointKind) -> Result<Option<[u32; 2]>> {
        let JointKind::Gear { a, b, .. } = kind else { return Ok(None) };
        let (a, b) = (self.joint_slot(*a)?, self.joint_slot(*b)?);
        for j in [a, b] {
            let kind = &self.joints.table[j].desc.kind;
            let ok = matches!(kind, JointKind::Hinge(_) | JointKind::Slider(_));
            check(ok, "gear", "joint", kind.name(), "a hinge or a slider")?;
        }
        let gives_way = |slot: u32| match self.bodies[slot].kind {
            BodyKind::Fixed => 0,
            BodyKind::Kinematic => 1,
            BodyKind::Dynamic => 2,
        };
        let moved = |joint: u32, but: u32| {
            let (body_a, body_b) = (self.joints.table[joint].body_a, self.joints.table[joint].body_b);
            let first = body_b == but || (body_a != but && gives_way(body_a) > gives_way(body_b));
            if first { body_a } else { body_b }
        };
        let a = moved(a, NONE);
        Ok(Some([a, moved(b, a)]))
    }
}
