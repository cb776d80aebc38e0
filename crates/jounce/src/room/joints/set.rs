//! Joints that hang together, solved as one.
//!
//! A set is a connected part of the graph of joints over moving bodies. It works on copies of its bodies, so sets are solved side by
//! side, whatever else the bodies touch. Per substep, in this order:
//!
//! * solve: warm start; springs, motors, ends; then the rows that hold, directly: A λ = −C(t + h)/h, where C(t + h) is the error
//!   that the present velocities would lead to, curvature and all. One Newton step of the position constraint, then: what
//!   RATTLE solves for (Andersen 1983), and with the velocities made consistent at the new positions by the relaxing pass it is
//!   symplectic like it: a pendulum's energy does not drift;
//! * relax, after the positions moved: what the motion passed is put right ([`super::place`]); then all rows anew, J u = 0 on those
//!   that hold.
//!
//! Light links under a heavy load. A link of inertia I under the tension f, held at the lever r, swings across the pull at
//! ω = √(r·f/I); 20 g under 100 kg at 2,000 rad/s, which no substep resolves, and explicit motion would blow up. So tension acts implicitly
//! where h² r·f > I (across rods: h² f/L > m/4): G = h² Σ (r·f)(1 − n nᵀ), n = r/|r|, and only the part of G beyond I is added,
//! (I + G′) ω′ = I ω + Σ τ. (What hangs on one joint alone turns about that: I + m r² in place of I, or the bob of a pendulum would be damped, the smaller
//! the more.) It is implicit Euler's own treatment of those modes (geometric stiffness), damping included;
//! whatever moves slowly enough has no part in it. So the load may be ten tons, and no joint yields.
//!
//! Inertia is that of the moment, not of the start of the step: a slender body that turned within the step would otherwise seem to
//! yield about what was its axis.
//!
//! Sources: Tournier et al., Stable constrained dynamics, 2015; Andrews et al., Geometric stiffness for real-time constrained
//! multibody dynamics, 2017.

use super::alike::Link;
use super::articulated::Firm;
use super::desc::{JointKind, JointSolver};
use super::direct::{Numbers, Plan, ROWS};
use super::extra::Sweep;
use super::gear::Gear;
use super::local::Local;
use super::place::Kept;
use super::solve::{Solve, counts, dot64};
use super::state::Joints;
use crate::room::contacts::prepare::Softness;
use crate::room::rigid::state::NONE;
use jounce_math::{Vec3, scalar::f32s};

/// Numbers of a step that sets need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    pub h: f32,
    pub warm: f32,
    /// Rows that hold, iteratively.
    pub soft: Softness,
    /// Fastest correction of an error, m/s and rad/s.
    pub push_out: f32,
    pub correct: f32,
    /// Most that a pass changes velocities and spins, m/s and rad/s: the speed limit, and a turn in a substep. What asks for more
    /// (bodies torn apart by what is stronger) cannot be had, and grows from pass to pass.
    pub speed_max: f32,
    pub spin_max: f32,
}

/// See the module's text.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointSet {
    pub joints: Vec<Solve>,
    pub gears: Vec<Gear>,
    pub bodies: Vec<Local>,
    pub plan: Option<Plan>,
    pub(super) numbers: Numbers,
    /// Rows that the factors in `numbers` are of.
    factored: Vec<u64>,
    fresh: bool,
    /// The pass takes the way of the substep for straight.
    pub(super) straight: bool,
    /// The pass found no active set: ends hold both ways.
    pub(super) fixed: bool,
    /// One of its bodies is much heavier than another.
    pub(super) loaded: bool,
    /// Was put together again after continuous collision.
    pub placed: bool,
    /// All its joints are rigid welds that nothing breaks: one that would break cannot pass on what a contact stops.
    pub(super) welded: bool,
    /// Contacts are solved with all that is welded on its bodies.
    pub leaned: bool,
    pub firm: Firm,
    /// Factors of another matrix than that of the passes.
    pub(super) other: Numbers,
    /// Pairs of joints that share a moving body, and which.
    shared: Vec<(u32, u32, u32)>,
    pub(super) kept: Kept,
    /// Its joints where it is solved in a band of sets alike, else none.
    pub links: Vec<Link>,
    /// The same of the step before.
    pub links_before: Vec<Link>,
    /// It is solved as a net, in lanes: none of its joints and bodies is copied then.
    pub net: bool,
    /// Something else pushes its bodies in the substeps (of nets).
    pub pushed: bool,
    /// The kernels of nets know all its joints.
    pub known: bool,
}

impl JointSet {
    /// Is it solved here?
    pub fn is_alone(&self) -> bool {
        self.links.is_empty() && !self.net
    }
    /// After joints and bodies are in place: who meets whom, and whether that is solved directly.
    /// `inv_mass` is that of a body by slot, 0 where it is not dynamic.
    pub fn arrange(&mut self, joints: &Joints, inv_mass: impl Fn(u32) -> f32) {
        let size = |s: &Solve| {
            let kind = &joints.table[s.id].desc.kind;
            counts(kind).iter().sum::<usize>().min(ROWS)
        };
        let moving =
            |i: usize| if self.bodies[i].row != NONE && self.bodies[i].moves() { i as u32 } else { u32::MAX };
        let links: Vec<(u8, [u32; 2])> =
            self.joints.iter().map(|s| (size(s) as u8, [moving(s.a), moving(s.b)])).collect();
        let any = |k: JointSolver| self.joints.iter().any(|s| joints.table[s.id].solver() == k);
        let n = self.joints.len();
        self.loaded = self.is_loaded(inv_mass);
        self.welded = self.joints.iter().all(|s| {
            let d = &joints.table[s.id].desc;
            let holds = !d.break_force.is_finite() && !d.break_torque.is_finite();
            matches!(d.kind, JointKind::Fixed) && d.softness.is_none() && holds
        });
        let most = if any(JointSolver::Direct) {
            FILL_ASKED * n + FILL_SMALL
        } else if any(JointSolver::Iterative) {
            0
        } else {
            FILL_AUTO * n + if self.loaded { FILL_LOADED } else { FILL_SMALL }
        };
        self.plan = if most == 0 { None } else { Plan::new(&links, self.bodies.len(), most) };
        self.shared.clear();
        self.fresh = false;
        let Some(plan) = &self.plan else { return };
        plan.reserve(&mut self.numbers);
        let mut at = vec![Vec::new(); self.bodies.len()];
        for (i, (_, pair)) in links.iter().enumerate() {
            for &b in pair.iter().filter(|b| **b != u32::MAX) {
                at[b as usize].push(i as u32);
            }
        }
        for (b, list) in at.iter().enumerate() {
            for (x, &i) in list.iter().enumerate() {
                self.shared.extend(list[..=x].iter().map(|&k| (i, k, b as u32)));
            }
        }
    }

    /// Is one of its bodies much heavier than another?
    fn is_loaded(&self, inv_mass: impl Fn(u32) -> f32) -> bool {
        let masses = self.bodies.iter().map(|b| inv_mass(b.slot)).filter(|m| *m > 0.0);
        let (least, most) =
            masses.fold((f32::INFINITY, 0.0), |(least, most), m| (f32s::min(least, m), f32s::max(most, m)));
        most > LOAD * least
    }

    pub(super) fn refresh(&mut self, joints: &Joints) {
        let iterative = self.plan.is_none();
        for s in &mut self.joints {
            s.refresh(&joints.table[s.id], &self.bodies, iterative);
        }
        self.fresh = false;
    }

    /// The factors are of other rows.
    pub(super) fn spoil(&mut self) {
        self.fresh = false;
    }

    /// The matrix of the rows that take part, in factors.
    pub(super) fn factor(&mut self, h: f32) {
        let pattern = |s: &Solve| s.packed[..s.count].iter().fold(0_u64, |x, &c| x | (1 << c));
        let same = self.fresh
            && self.factored.len() == self.joints.len()
            && self.factored.iter().zip(&self.joints).all(|(f, s)| *f == pattern(s));
        if same {
            return;
        }
        self.fill(h);
        let Some(plan) = &self.plan else { return };
        plan.factor(&mut self.numbers, false);
        self.factored.clear();
        self.factored.extend(self.joints.iter().map(pattern));
        self.fresh = true;
    }

    /// A of the rows that take part.
    pub(super) fn fill(&mut self, h: f32) {
        let Some(plan) = &self.plan else { return };
        let n = &mut self.numbers;
        plan.clear(n, |j| self.joints[j].count);
        for &(i, k, body) in &self.shared {
            let (x, y) = (&self.joints[i as usize], &self.joints[k as usize]);
            let local = &self.bodies[body as usize];
            let (xa, ya) = (x.a == body as usize, y.a == body as usize);
            let mut columns = [([0.0; 3], [0.0; 3]); ROWS];
            for (column, &code) in columns.iter_mut().zip(&y.packed[..y.count]) {
                let (l, j) = y.end(code, ya);
                *column = local.moved_by(l, j);
            }
            plan.add(n, i as usize, k as usize, |r, c| {
                let (l, j) = x.end(x.packed[r], xa);
                dot64(l, columns[c].0) + dot64(j, columns[c].1)
            });
        }
        for (i, s) in self.joints.iter().enumerate() {
            for (r, &code) in s.packed[..s.count].iter().enumerate() {
                let c = s.compliance(code, &self.bodies, h);
                if c > 0.0 {
                    plan.add_diagonal(n, i, r, c);
                }
            }
        }
    }

    fn pass(&mut self, joints: &Joints, k: &Constants, sweep: Sweep, first: bool) {
        // Gears see what the rows that hold make of them, and answer; row by row, so do ends and motors.
        let alone =
            self.gears.is_empty() && (self.plan.is_some() || self.joints.iter().all(|s| s.extra.is_empty()));
        let rounds = if alone { 1 } else { 2 };
        for round in 0..rounds {
            for s in &mut self.joints {
                s.sweep_extra(&mut self.bodies, k, sweep, self.plan.is_some());
            }
            self.gears(k, sweep, false);
            if self.plan.is_some() {
                self.direct(joints, k, sweep);
            } else {
                for s in &mut self.joints {
                    s.hold(&mut self.bodies, k, sweep, first && round == 0);
                }
            }
        }
    }

    fn aim(&mut self, joints: &Joints, k: &Constants) {
        if self.plan.is_some() {
            for s in &mut self.joints {
                self.fresh &= !s.aim(&joints.table[s.id], &self.bodies, k);
            }
        }
    }

    /// Before the positions move.
    pub fn solve(&mut self, joints: &Joints, k: &Constants, first: bool) {
        if first {
            self.refresh(joints);
            self.stiffen(k);
            self.refresh(joints);
        } else {
            self.bodies.iter_mut().for_each(Local::apply_added);
        }
        let direct = self.plan.is_some();
        for s in &mut self.joints {
            s.warm(&mut self.bodies, k, direct);
        }
        self.damp();
        self.aim(joints, k);
        self.gears(k, Sweep::Solve, true);
        self.pass(joints, k, Sweep::Solve, true);
    }

    /// Before the positions move, after contacts.
    pub fn answer(&mut self, joints: &Joints, k: &Constants) {
        self.aim(joints, k);
        self.pass(joints, k, Sweep::Solve, false);
    }

    /// Is a point so far from where it is held, m?
    pub(super) fn is_open(&self, most: f32) -> bool {
        let open = |s: &Solve| {
            let n = if s.rod { 1 } else { s.hard.n };
            // Soft ones stretch as they shall, ropes hang slack.
            let by = |c: f32| if s.sign == 0.0 { c.abs() } else { -s.sign * c };
            s.soft.is_none() && s.hard.rows[..n].iter().any(|r| r.lb != Vec3::ZERO && by(r.c) > most)
        };
        self.joints.iter().any(open)
    }

    /// Draws the velocities of a torn set towards that of its centre of mass: momentum stays, and what it swings with goes.
    fn calm(&mut self) {
        let (mut p, mut mass) = (Vec3::ZERO, 0.0);
        for b in self.bodies.iter().filter(|b| b.is_dynamic()) {
            let m = 1.0 / b.inv_mass.x;
            p += b.m.v * m;
            mass += m;
        }
        if mass <= 0.0 || !mass.is_finite() {
            return;
        }
        let mean = p / mass;
        for b in self.bodies.iter_mut().filter(|b| b.is_dynamic()) {
            b.m.v += (mean - b.m.v) * CALMING;
            if b.turns {
                b.m.w -= b.m.w * CALMING;
            }
        }
    }

    /// After they moved.
    pub fn relax(&mut self, joints: &Joints, k: &Constants) {
        self.turn_back(joints, k);
        self.stiffen(k);
        self.refresh(joints);
        self.pass(joints, k, Sweep::Relax, true);
        // What is stronger than any joint did that; rows with such levers are no longer linear in a substep, and would drive the bodies
        // round for ever.
        if self.is_open(TORN * k.correct) {
            self.calm();
        }
        if !self.leaned {
            self.account(joints, k);
        }
    }

    /// What joints gave in the substep, for who asks and for what breaks.
    pub fn account(&mut self, joints: &Joints, k: &Constants) {
        self.share_out(k);
        for s in &mut self.joints {
            let rb = self.bodies[s.b].m.dq.rotate(s.start.rb);
            s.account(&joints.table[s.id], k, rb);
        }
    }
}

/// Blocks below the diagonal up to which a set is solved directly by itself: for each joint, and besides; so small nets are, of some 60
/// joints, and those of some 300 where a heavy body hangs in a light net, which soft rows would let flow apart.
const FILL_AUTO: usize = 6;
const FILL_SMALL: usize = 64;
const FILL_LOADED: usize = 2048;
/// How many times the lightest body's mass makes a load.
const LOAD: f32 = 10.0;
/// Blocks for each joint where the direct solver is asked for.
const FILL_ASKED: usize = 64;
/// A joint is torn where it is off by more than errors are taken back in this time, s: a metre.
pub(crate) const TORN: f32 = 0.1;
/// Part of a torn set's velocities against one another that a substep takes.
pub(crate) const CALMING: f32 = 0.9;
