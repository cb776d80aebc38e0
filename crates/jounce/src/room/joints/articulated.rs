//! What a contact meets in a body of a set: the articulated inverse mass.
//!
//! A contact's row sees the two bodies that touch, g M⁻¹ gᵀ with g = (n, r × n). What hangs on them by joints adds to that:
//!
//! u ← u + R λ, R = (M⁻¹ − M⁻¹ Jᵀ A⁻¹ J M⁻¹) gᵀ, 1/m′ = g R, A = J M⁻¹ Jᵀ,
//!
//! with J the rows of the set's joints that hold both ways (neither ends nor ropes nor motors, which may let go). A wheel of 2 kg that lands
//! under a chassis of 200 kg would have to be stopped dozens of times over: each time the chassis gives on what the wheel weighs. Its
//! contact would be a spring for 2 kg under 200 kg: deep, and thrown back by it, whatever its restitution. With R a point's impulse moves
//! the whole set as it will, and a few sweeps over the points of a set, as over those of one body, stop it.
//!
//! A is that of the start of the step. What it no longer fits is put right by the passes over joints that follow; the impulses on joints act
//! where the joints are now, so momentum is kept.
//!
//! Sources: Featherstone, Rigid body dynamics algorithms, 2008 (articulated inertia, operational space); Otter, Tomcin et al., Efficient
//! enforcement of hard articulation constraints in the presence of closed loops and contacts, 2014.

use super::direct::{Numbers, ROWS};
use super::set::JointSet;
use super::solve::{HARD, dot64};
use super::state::Joints;
use jounce_math::Vec3;

/// A motion, or an impulse and a moment, world axes.
pub(crate) type Six = [f64; 6];

/// What holds a set both ways, and how that answers to contacts; not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Firm {
    numbers: Numbers,
    /// Rows of each joint that take part.
    packed: Vec<(usize, [u8; ROWS])>,
    /// Bodies that contacts touch, and their velocities in a pass.
    pub bodies: Vec<usize>,
    pub u: Vec<Six>,
    /// What the pass has given each of them.
    pub given: Vec<Six>,
    /// R of each point, at each of those bodies.
    response: Vec<Six>,
}

impl Firm {
    /// R of a point at all bodies that contacts touch.
    pub fn response(&self, point: usize) -> &[Six] {
        let n = self.bodies.len();
        &self.response[point * n..(point + 1) * n]
    }
    /// An impulse of a point to the velocities of a pass.
    pub fn react(&mut self, point: usize, lambda: f64) {
        let n = self.bodies.len();
        for (u, r) in self.u.iter_mut().zip(&self.response[point * n..]) {
            u.iter_mut().zip(r).for_each(|(u, r)| *u += r * lambda);
        }
    }
    pub fn clear(&mut self) {
        self.bodies.clear();
        self.response.clear();
    }
}

impl JointSet {
    /// May its contacts need to know what hangs on what they touch?
    pub fn bears(&self) -> bool {
        self.uneven && self.plan.is_some() && self.is_alone()
    }

    /// The factors of what its joints hold both ways, where they stand now.
    pub fn firm(&mut self, joints: &Joints, h: f32) {
        self.refresh(joints);
        self.joints.iter_mut().for_each(super::solve::Solve::pack_firm);
        core::mem::swap(&mut self.numbers, &mut self.firm.numbers);
        if let Some(plan) = &self.plan {
            plan.reserve(&mut self.numbers);
        }
        self.factor(h);
        core::mem::swap(&mut self.numbers, &mut self.firm.numbers);
        self.spoil();
        self.firm.packed.clear();
        self.firm.packed.extend(self.joints.iter().map(|s| (s.count, s.packed)));
    }

    /// Adds a point: an impulse along `g` on one of the bodies that contacts touch.
    pub fn add_point(&mut self, place: usize, g: &Six) {
        self.bodies.iter_mut().for_each(|b| b.dv = [0.0; 6]);
        self.bodies[self.firm.bodies[place]].dv = *g;
        self.hold(|_, _, _| {});
        let Self { bodies, firm, .. } = self;
        firm.response.extend(firm.bodies.iter().map(|&b| bodies[b].dv));
    }

    /// Hands out what a pass has given, to all bodies: gives each one's change of velocity and spin.
    pub fn spread(&mut self, mut change: impl FnMut(u32, Vec3, Vec3)) {
        if self.firm.given.iter().all(|g| *g == [0.0; 6]) {
            return;
        }
        for b in &mut self.bodies {
            (b.dv, b.tensor, b.raw) = ([0.0; 6], b.raw, b.tensor);
        }
        for (&b, g) in self.firm.bodies.iter().zip(&self.firm.given) {
            self.bodies[b].dv = *g;
        }
        self.hold(|s, row, lambda| s.lambda[row] += lambda as f32);
        for b in &mut self.bodies {
            (b.tensor, b.raw) = (b.raw, b.tensor);
            let [vx, vy, vz, wx, wy, wz] = b.dv.map(|x| x as f32);
            if b.moves() {
                change(b.row, Vec3::new(vx, vy, vz), Vec3::new(wx, wy, wz));
            }
        }
    }

    /// Impulses on bodies to the changes that the joints leave of them: in and out in `dv`.
    fn hold(&mut self, mut give: impl FnMut(&mut super::solve::Solve, usize, f64)) {
        let Self { joints, bodies, plan, firm, .. } = self;
        let Some(plan) = plan else { return };
        plan.reserve(&mut firm.numbers);
        for (i, (s, (count, packed))) in joints.iter().zip(&firm.packed).enumerate() {
            let (a, b) = (bodies[s.a].changed(), bodies[s.b].changed());
            for (r, &code) in packed[..*count].iter().enumerate() {
                let speed = |(l, j): (Vec3, Vec3), (v, w): ([f64; 3], [f64; 3])| dot64(l, v) + dot64(j, w);
                let value = speed(s.end(code, true), a) + speed(s.end(code, false), b);
                plan.set(&mut firm.numbers, i, r, -value);
            }
        }
        plan.solve(&mut firm.numbers);
        for (i, (s, (count, packed))) in joints.iter_mut().zip(&firm.packed).enumerate() {
            for (r, &code) in packed[..*count].iter().enumerate() {
                let lambda = plan.get(&firm.numbers, i, r);
                for (body, (l, j)) in [(s.a, s.end(code, true)), (s.b, s.end(code, false))] {
                    bodies[body].push(l, j, lambda);
                }
                give(s, usize::from(code) % HARD, lambda);
            }
        }
        bodies.iter_mut().for_each(super::local::Local::give);
    }
}
