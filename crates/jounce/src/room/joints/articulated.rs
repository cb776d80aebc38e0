//! What a contact meets in a body of a welded set: the articulated inverse mass.
//!
//! A contact's row sees the two bodies that touch, g M⁻¹ gᵀ with g = (n, r × n). What is welded on them adds to that:
//!
//! u ← u + R λ, R = (M⁻¹ − M⁻¹ Jᵀ A⁻¹ J M⁻¹) gᵀ, 1/m′ = g R, A = J M⁻¹ Jᵀ.
//!
//! A foot of 1 kg that lands under 20 kg would have to be stopped dozens of times over: each time the load gives on what the foot weighs. Its
//! contact would be a spring for 1 kg under 20 kg: deep, and thrown back by it, whatever its restitution. With R a point's impulse moves
//! the whole set as it will, and a few sweeps over the points of a set, as over those of one body, stop it.
//!
//! Welds alone: what holds one way (ends, ropes, motors) would have to be part of the sweeps.
//!
//! J and A are made anew where a body has turned by more than a fiftieth since, and always together: A of a chain under a load is singular but for a millionth, and with another J than its
//! own, off by a hundredth, it would explode at a touch. What they no longer fit is put right by the passes over joints that follow.
//!
//! Sources: Featherstone, Rigid body dynamics algorithms, 2008 (articulated inertia, operational space); Tomcin, Sibbing & Kobbelt, Efficient
//! enforcement of hard articulation constraints in the presence of closed loops and contacts, 2014.

use super::active::bearable;
use super::direct::{Numbers, ROWS};
use super::extra::Sweep;
use super::local::Local;
use super::rows::Row;
use super::set::{Constants, JointSet};
use super::solve::{HARD, Solve, dot64};
use super::state::Joints;
use crate::room::rigid::state::InvInertia;
use jounce_math::{Vec3, scalar::f64s};

/// A motion, or an impulse and a moment, world axes.
pub(crate) type Six = [f64; 6];

/// The welds of a set, and how they answer to contacts; not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Firm {
    numbers: Numbers,
    /// Rows of each joint that take part, which, and where they were.
    packed: Vec<(usize, [u8; ROWS])>,
    rows: Vec<Row>,
    /// Tensors of then.
    tensors: Vec<InvInertia>,
    /// Bodies that contacts touch, and their velocities in a pass.
    pub bodies: Vec<usize>,
    places: Vec<usize>,
    pub u: Vec<Six>,
    /// What the pass has given each of them.
    pub given: Vec<Six>,
    /// R of each point, at each of those bodies.
    response: Vec<Six>,
    /// Was made anew in this substep.
    pub stale: bool,
    /// How far each body had turned in the step when it was made.
    turns: Vec<Vec3>,
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
    pub fn clear(&mut self, bodies: usize) {
        self.bodies.clear();
        self.places.clear();
        self.places.resize(bodies, usize::MAX);
        self.turns.clear();
    }
    /// A contact touches a body of the set.
    pub fn touch(&mut self, body: usize) {
        if self.places[body] == usize::MAX {
            self.places[body] = self.bodies.len();
            self.bodies.push(body);
        }
    }
    /// Which of those it is.
    pub fn place(&self, body: usize) -> usize {
        self.places[body]
    }
    /// Room for points.
    pub fn reserve(&mut self, points: usize) {
        let n = self.bodies.len();
        self.u.resize(n, [0.0; 6]);
        self.given.resize(n, [0.0; 6]);
        self.response.clear();
        self.response.resize(points * n, [0.0; 6]);
    }
}

impl JointSet {
    /// Do its contacts ask what hangs on what they touch?
    pub fn bears(&self) -> bool {
        self.plan.is_some() && self.is_alone() && self.welded
    }

    /// The factors of its welds, where they stand now.
    pub fn firm(&mut self, joints: &Joints, h: f32) {
        self.refresh(joints);
        self.joints.iter_mut().for_each(|s| s.pack(Sweep::Relax));
        core::mem::swap(&mut self.numbers, &mut self.firm.numbers);
        if let Some(plan) = &self.plan {
            plan.reserve(&mut self.numbers);
        }
        self.factor(h);
        core::mem::swap(&mut self.numbers, &mut self.firm.numbers);
        self.spoil();
        self.firm.packed.clear();
        self.firm.packed.extend(self.joints.iter().map(|s| (s.count, s.packed)));
        self.firm.rows.clear();
        self.firm
            .rows
            .extend(self.joints.iter().flat_map(|s| s.packed[..s.count].iter().map(|&c| *s.row(c))));
        self.firm.tensors.clear();
        self.firm.tensors.extend(self.bodies.iter().map(|b| b.tensor));
        self.firm.turns.clear();
        self.firm.turns.extend(self.bodies.iter().map(|b| b.m.dr));
    }

    /// Is there no matrix of it yet, or has some body turned by more since?
    pub fn has_turned(&self, most: f32) -> bool {
        let turned = |(b, t): (&Local, &Vec3)| (b.m.dr - *t).length_squared() > most * most;
        self.firm.turns.is_empty() || self.bodies.iter().zip(&self.firm.turns).any(turned)
    }

    /// A point: an impulse along `g` on one of the bodies that contacts touch. Gives what it alone would meet, g M⁻¹ gᵀ.
    pub fn respond(&mut self, point: usize, place: usize, g: &Six) -> f64 {
        self.bodies.iter_mut().for_each(|b| b.dv = [0.0; 6]);
        let body = &mut self.bodies[self.firm.bodies[place]];
        body.dv = *g;
        let (v, w) = body.changed();
        let own = g.iter().zip(v.into_iter().chain(w)).map(|(g, u)| g * u).sum();
        self.hold(|_, _, _| {});
        let Self { bodies, firm, .. } = self;
        let from = point * firm.bodies.len();
        firm.response[from..].iter_mut().zip(&firm.bodies).for_each(|(r, &b)| *r = bodies[b].dv);
        own
    }

    /// Hands out what a pass has given, to all bodies, as far as they bear it: gives each one's change of velocity and spin.
    pub fn spread(&mut self, k: &Constants, mut change: impl FnMut(u32, Vec3, Vec3)) {
        if self.firm.given.iter().all(|g| *g == [0.0; 6]) {
            return;
        }
        self.bodies.iter_mut().for_each(|b| b.dv = [0.0; 6]);
        for (&b, g) in self.firm.bodies.iter().zip(&self.firm.given) {
            self.bodies[b].dv = *g;
        }
        self.bodies.iter_mut().for_each(|b| b.before = [b.m.v, b.m.w]);
        self.hold(|s, row, lambda| s.lambda[row] += lambda as f32);
        let part = self.bodies.iter().map(|b| bearable(b, k)).fold(1.0, f64s::min);
        for b in self.bodies.iter().filter(|b| b.moves()) {
            let [vx, vy, vz, wx, wy, wz] = b.dv.map(|x| (part * x) as f32);
            change(b.row, Vec3::new(vx, vy, vz), Vec3::new(wx, wy, wz));
        }
    }

    /// Impulses on bodies to the changes that the joints leave of them: in and out in `dv`.
    fn hold(&mut self, mut give: impl FnMut(&mut Solve, usize, f64)) {
        let Self { joints, bodies, plan, firm, .. } = self;
        let Some(plan) = plan else { return };
        // The matrix is of the tensors of then, and may be singular but for a millionth.
        bodies.iter_mut().zip(&mut firm.tensors).for_each(|(b, t)| core::mem::swap(&mut b.tensor, t));
        plan.reserve(&mut firm.numbers);
        let mut rows = firm.rows.iter();
        for (i, (s, (count, _))) in joints.iter().zip(&firm.packed).enumerate() {
            let (a, b) = (bodies[s.a].changed(), bodies[s.b].changed());
            for (r, row) in rows.by_ref().take(*count).enumerate() {
                let speed = |l: Vec3, j: Vec3, (v, w): ([f64; 3], [f64; 3])| dot64(l, v) + dot64(j, w);
                let value = speed(row.la, row.ja, a) + speed(row.lb, row.jb, b);
                plan.set(&mut firm.numbers, i, r, -value);
            }
        }
        plan.solve(&mut firm.numbers);
        let mut rows = firm.rows.iter();
        for (i, (s, (count, packed))) in joints.iter_mut().zip(&firm.packed).enumerate() {
            for ((r, row), &code) in rows.by_ref().take(*count).enumerate().zip(packed) {
                let lambda = plan.get(&firm.numbers, i, r);
                bodies[s.a].push(row.la, row.ja, lambda);
                bodies[s.b].push(row.lb, row.jb, lambda);
                give(s, usize::from(code) % HARD, lambda);
            }
        }
        bodies.iter_mut().for_each(Local::give);
        bodies.iter_mut().zip(&mut firm.tensors).for_each(|(b, t)| core::mem::swap(&mut b.tensor, t));
    }
}
