//! Which rows hold: the active set of a pass.
//!
//! Ends push, ropes pull, motors and friction give what they can: A λ = r with bounds, a linear complementarity problem. Rows beyond
//! their bounds are held there and left out, those that would have to act again are let in, until nothing changes (block pivoting:
//! Júdice & Pires, A block principal pivoting algorithm for large-scale strictly monotone linear complementarity problems, 1994).
//! Motors and friction may come back in the first rounds alone; ends one at a time after some, and brake where that takes too long: so it ends.

use super::desc::LimitDesc;
use super::direct::Plan;
use super::extra::{Duty, Sweep};
use super::local::Local;
use super::place::GAP;
use super::set::{Constants, JointSet};
use super::solve::{HARD, give_extra, limited};
use super::state::Joints;
use jounce_math::{Vec3, scalar::f64s};

/// A one-sided row that held is taut as long as so little speed would close it within a substep, m/s.
pub(super) const TAUT_SPEED: f32 = 0.1;
/// Rounds of the active set, at least and at most, and the products of blocks that they may take: a chain of 60 has some 80 rounds.
const ROUNDS: [usize; 2] = [16, 128];
const PRODUCTS: usize = 10000;
/// Of these, those that let motors and friction act again, and those that change all ends that are wrong; then one at a time.
const ROUNDS_OF_MOTORS: usize = 2;
pub(super) const ROUNDS_OF_ENDS: usize = 8;
/// Rounds at most while places are looked for: that takes many steps, each with rounds of its own.
const ROUNDS_OF_PLACES: usize = 8;
/// The same of the others of its set.
const ROUNDING: f32 = 1e-6;
/// Error of a joint that closes a loop, and bend within a substep, which are let be, m or rad: rounding of f32 at some 10 m.
const LOOP_SLACK: f32 = 1e-5;
/// Bend that is looked at, s of correction: 1 mm.
pub(super) const BEND: f32 = 1e-4;
/// Part of the kinetic energy that a pass may spend on bend, and in a tight set on errors.
const COST: f64 = 0.01;
/// Speed that every body is taken to have besides, as part of that at which errors are taken back: what hangs still is put right too.
const STILL: f32 = 0.1;
/// Of the bend that is looked at, and of the gap from which places are put right, in a tight set.
const TIGHT: f32 = 0.05;
/// Newton's steps beyond the first, the error ahead that asks for one, s of correction: 0.01 mm; and the part of the kinetic energy that one may
/// spend.
const AGAIN: usize = 4;
const MISS: f32 = 1e-6;
const AGAIN_COST: f64 = 0.1;
/// Stands for all ends.
const ENDS: Duty = Duty::Limit(LimitDesc::new(0.0, 0.0));

impl JointSet {
    /// Which rows take part at the start of a pass.
    fn activate(&mut self, joints: &Joints, k: &Constants, sweep: Sweep) {
        for s in &mut self.joints {
            let (a, b) = (&self.bodies[s.a].m, &self.bodies[s.b].m);
            match sweep {
                // A rope that held stays a candidate, though the velocities do not yet stretch it: in a cable they are those of
                // free fall, alike at both its ends. The sign of its own pull lets it go.
                Sweep::Solve => {
                    let held =
                        (s.active && s.sign * s.hard.rows[0].c < TAUT_SPEED * k.h) || s.lambda[0] != 0.0;
                    s.active = true;
                    if s.sign != 0.0 && !held {
                        let ahead = s.ahead(&joints.table[s.id], a, b, k);
                        s.active = s.sign * ahead.rows[0].c < 0.0;
                    }
                }
                Sweep::Relax => s.active &= s.soft.is_none(),
                Sweep::Place => {
                    s.active = s.soft.is_none() && (s.sign == 0.0 || s.sign * s.hard.rows[0].c < 0.0);
                }
            }
            for i in 0..s.extra.len() {
                let taken = i < s.taken();
                let x = &mut s.extra[i];
                let v = x.row.speed(a, b);
                x.acts = taken
                    && x.mass > 0.0
                    && match x.duty {
                        Duty::Speed { .. } => match sweep {
                            Sweep::Solve => !x.gives_all(k.h),
                            Sweep::Relax => x.acts,
                            Sweep::Place => false,
                        },
                        Duty::Limit(LimitDesc { spring: Some(_), .. }) => false,
                        Duty::Spring { .. } => sweep == Sweep::Solve && x.in_direct(k.h),
                        Duty::Limit(l) => match sweep {
                            Sweep::Relax => {
                                l.holds_still() || x.impulse != 0.0 || x.gap() + k.h * x.away(v) < 0.0
                            }
                            _ => {
                                let pushed = x.impulse != 0.0 || (x.acts && x.gap() < TAUT_SPEED * k.h);
                                l.holds_still() || pushed || x.must_act(v, k, sweep)
                            }
                        },
                    };
            }
        }
    }

    /// Right sides for the present velocities: −C(t + h)/h to solve, −J u to relax.
    fn residuals(&mut self, k: &Constants, sweep: Sweep) {
        let Some(plan) = &self.plan else { return };
        let (tight, loops) = (self.is_tight(), plan.has_loops());
        for (i, s) in self.joints.iter().enumerate() {
            let (a, b) = (&self.bodies[s.a].m, &self.bodies[s.b].m);
            for (r, &code) in s.packed[..s.count].iter().enumerate() {
                let row = s.row(code);
                let v = row.speed(a, b);
                let c = usize::from(code);
                let value = if c >= HARD {
                    let x = &s.extra[c - HARD];
                    if self.fixed && x.is_hard_end() { v } else { x.wanted(v, k, sweep) }
                } else if s.yields(c) {
                    v + s.give_way[c] * s.lambda[c]
                } else if sweep == Sweep::Relax {
                    v
                } else if let Some((gives, pull)) = s.softness(c, &self.bodies, k.h) {
                    v + gives * s.lambda[c] + pull
                } else {
                    // Errors that a teleport left are taken back at a bounded speed.
                    let error = if self.straight && tight { 0.0 } else { limited(row.c, k.correct * k.h) };
                    let bend = s.bend[c];
                    if loops {
                        // Rows that say again what others say would fight about rounding for ever.
                        let most = if plan.closes_loop(i) { LOOP_SLACK } else { ROUNDING };
                        let slack = limited(error, most) + limited(bend, most);
                        v + (error + bend - slack) / k.h
                    } else {
                        v + (error + bend) / k.h
                    }
                };
                plan.set(&mut self.numbers, i, r, -f64::from(value));
            }
        }
    }

    /// Active set. Each round starts from the same velocities: rows that hold are solved for and handed out on trial; rows beyond
    /// what they can give stay at that, those that would have to act again do; until nothing changes. Errors ahead are not linear
    /// in the velocities: their bend is that of the velocities that the pass found, so that all rounds ask the same.
    ///
    /// Where the way of the substep bends much, that is judged only once the velocities fit the joints: what a blow has left of a limb's spin on
    /// a long lever would ask for ten times what it needs.
    pub(super) fn direct(&mut self, joints: &Joints, k: &Constants, sweep: Sweep) {
        let tight = self.is_tight();
        let part = if tight { TIGHT } else { 1.0 };
        let open = tight && self.is_open(part * GAP * k.correct);
        if sweep == Sweep::Solve && (open || self.bends(joints, part, k)) {
            self.straight = true;
            self.rounds(joints, k, sweep);
            self.straight = false;
            self.rounds(joints, k, sweep);
            self.moderate(COST, k);
        } else {
            self.rounds(joints, k, sweep);
        }
        // In a tight set no further step converges.
        if sweep != Sweep::Solve || tight {
            return;
        }
        for _ in 0..AGAIN {
            if !self.misses(joints, k) {
                return;
            }
            self.rounds(joints, k, sweep);
            if self.moderate(AGAIN_COST, k) {
                return;
            }
        }
    }

    /// May forces along where the joints were at the start of the substep have no answer? Between a load and a hook, or around a loop, what is taut
    /// makes way for a light body that crosses it only by what is not light, or not at all.
    fn is_tight(&self) -> bool {
        self.loaded || self.plan.as_ref().is_some_and(Plan::has_loops)
    }

    /// Will some point be off by more than [`MISS`] after the substep?
    fn misses(&self, joints: &Joints, k: &Constants) -> bool {
        let (most, limit) = (MISS * k.correct, k.correct * k.h);
        self.joints.iter().filter(|s| s.soft.is_none() && s.active).any(|s| {
            let (a, b) = (&self.bodies[s.a].m, &self.bodies[s.b].m);
            let ahead = s.ahead(&joints.table[s.id], a, b, k);
            let n = if s.rod { 1 } else { s.hard.n };
            (0..n).any(|i| ahead.rows[i].c.abs() > most && s.hard.rows[i].c.abs() < limit)
        })
    }

    /// Takes back what the bend asked for beyond a part of the energy there is, along with the errors of a tight set: u ← u₀ + s (u − u₀), with
    /// u₀ where the pass began and s² = c |u₀|²/|u − u₀|² in the metric of the masses, of a free set against its centre of mass. A light
    /// body that crosses a taut rope at 100 m/s is to be stopped by the rope; along the rope as it was, only the load at its
    /// other end could make room for it, at 40 m/s. What is left of the bend is put right as places are.
    /// True where it did.
    fn moderate(&mut self, most: f64, k: &Constants) -> bool {
        let mean = self.drift();
        let still = f64::from(STILL * k.correct * STILL * k.correct);
        let (mut cost, mut energy) = (0.0, 0.0);
        for b in self.bodies.iter().filter(|b| b.is_dynamic()) {
            let m = f64::from(1.0 / b.inv_mass.x);
            let [v, w] = b.before;
            let (dv, dw) = (b.m.v - v, b.m.w - w);
            cost += m * f64::from(dv.length_squared());
            energy += m * (f64::from((v - mean).length_squared()) + still);
            if let Some(i) = &b.inertia {
                cost += f64::from(dw.dot(*i * dw));
                energy += f64::from(w.dot(*i * w));
            }
        }
        if cost <= most * energy {
            return false;
        }
        let part = (most * energy / cost).sqrt() as f32;
        for b in &mut self.bodies {
            let [v, w] = b.before;
            (b.m.v, b.m.w) = (v + (b.m.v - v) * part, w + (b.m.w - w) * part);
        }
        for s in &mut self.joints {
            for (l, before) in s.lambda.iter_mut().zip(s.before) {
                *l = before + (*l - before) * part;
            }
            for x in &mut s.extra {
                x.impulse = x.before + (x.impulse - x.before) * part;
            }
        }
        true
    }

    /// Velocity of the centre of mass where the pass began; 0 of a set that is not free.
    fn drift(&self) -> Vec3 {
        let (mut p, mut mass) = (Vec3::ZERO, 0.0);
        for b in &self.bodies {
            if !b.is_dynamic() {
                return Vec3::ZERO;
            }
            p += b.before[0] * (1.0 / b.inv_mass.x);
            mass += 1.0 / b.inv_mass.x;
        }
        if mass > 0.0 { p / mass } else { Vec3::ZERO }
    }

    /// Does the way of some point bend by more than [`BEND`] in the substep?
    fn bends(&self, joints: &Joints, part: f32, k: &Constants) -> bool {
        let most = part * BEND * k.correct;
        self.joints.iter().filter(|s| s.soft.is_none() && s.active).any(|s| {
            let (a, b) = (&self.bodies[s.a].m, &self.bodies[s.b].m);
            let ahead = s.ahead(&joints.table[s.id], a, b, k);
            let rows = s.hard.rows[..s.hard.n].iter().zip(&ahead.rows);
            rows.into_iter().any(|(r, x)| (x.c - r.c - k.h * r.speed(a, b)).abs() > most)
        })
    }

    fn rounds(&mut self, joints: &Joints, k: &Constants, sweep: Sweep) {
        if sweep != Sweep::Relax {
            for s in &mut self.joints {
                if self.straight {
                    s.straighten();
                } else {
                    s.bend(&joints.table[s.id], &self.bodies, k);
                }
            }
        }
        self.activate(joints, k, sweep);
        self.mark();
        self.fixed = false;
        let products = self.plan.as_ref().map_or(1, |p| p.products().max(1));
        let most = (PRODUCTS / products).clamp(ROUNDS[0], ROUNDS[1]);
        for round in 1..=if sweep == Sweep::Place { ROUNDS_OF_PLACES } else { most } {
            self.trial(k, sweep);
            if !self.correct(k, sweep, round) {
                return;
            }
            self.rewind();
        }
        // No answer was found: for this pass ends only brake, and whatever was an end in some round is one.
        self.fixed = true;
        self.joints
            .iter_mut()
            .flat_map(|s| &mut s.extra)
            .filter(|x| x.is_hard_end())
            .for_each(|x| x.acts = x.tried);
        for _ in 0..=ROUNDS_OF_MOTORS {
            self.trial(k, sweep);
            if !self.hold_back(k, |d| !matches!(d, Duty::Limit(_))) {
                return;
            }
            self.rewind();
        }
        self.trial(k, sweep);
    }

    fn trial(&mut self, k: &Constants, sweep: Sweep) {
        for s in &mut self.joints {
            s.pack(sweep);
            s.extra.iter_mut().for_each(|x| x.tried |= x.acts);
        }
        self.residuals(k, sweep);
        self.factor(k.h);
        let Some(plan) = &self.plan else { return };
        plan.solve(&mut self.numbers);
        self.hand_out(k);
    }

    /// Remembers where the rounds start from.
    fn mark(&mut self) {
        self.bodies.iter_mut().for_each(|b| b.before = [b.m.v, b.m.w]);
        for s in &mut self.joints {
            s.before = s.lambda;
            s.extra.iter_mut().for_each(|x| (x.before, x.tried) = (x.impulse, false));
        }
    }

    /// Back to where the rounds started from, but for the rows that are held at what they can give.
    fn rewind(&mut self) {
        let bodies = &mut self.bodies;
        bodies.iter_mut().for_each(|b| [b.m.v, b.m.w] = b.before);
        for s in &mut self.joints {
            if s.active || s.sign == 0.0 {
                s.lambda = s.before;
            } else {
                s.lambda[1..].copy_from_slice(&s.before[1..]);
                s.give(bodies, 0, s.lambda[0] - s.before[0]);
            }
            for x in &mut s.extra {
                if x.acts {
                    x.impulse = x.before;
                } else {
                    give_extra(x, bodies, s.a, s.b, x.impulse - x.before);
                }
            }
        }
    }

    /// Holds rows back at what they can give, or lets rows act again; true where that changes anything. Motors and friction go first:
    /// while one that is too weak stands in, an end beside it seems to pull. The later rounds let no motor in, and change one end each.
    fn correct(&mut self, k: &Constants, sweep: Sweep, round: usize) -> bool {
        if self.hold_back(k, |d| !matches!(d, Duty::Limit(_))) {
            return true;
        }
        if round > ROUNDS_OF_ENDS {
            return self.pivot(k, sweep);
        }
        self.hold_back(k, |d| matches!(d, Duty::Limit(_))) || self.let_in(k, sweep, round <= ROUNDS_OF_MOTORS)
    }

    /// The last end that is wrong, in or out: many at once may go round in circles, one by this rule does not (Murty, Note on a
    /// Bard-type scheme for solving the complementarity problem, 1974).
    fn pivot(&mut self, k: &Constants, sweep: Sweep) -> bool {
        for s in self.joints.iter_mut().rev() {
            let (a, b) = (&self.bodies[s.a].m, &self.bodies[s.b].m);
            let taken = s.taken();
            for x in s.extra[..taken].iter_mut().rev().filter(|x| x.is_hard_end() && x.mass > 0.0) {
                let allowed = x.allowed(x.impulse, k.h);
                let pulls = x.acts && allowed != x.impulse;
                if pulls {
                    x.impulse = allowed;
                }
                if pulls || (!x.acts && x.must_act(x.row.speed(a, b), k, sweep)) {
                    x.acts = !x.acts;
                    return true;
                }
            }
            if s.has_to_let_go() {
                (s.lambda[0], s.active) = (0.0, false);
                return true;
            }
            if s.has_to_hold(a, b, k, sweep) {
                s.active = true;
                return true;
            }
        }
        false
    }

    fn hold_back(&mut self, k: &Constants, which: impl Fn(&Duty) -> bool) -> bool {
        let mut changed = false;
        for s in &mut self.joints {
            for x in s.extra.iter_mut().filter(|x| x.acts && which(&x.duty)) {
                let allowed = x.allowed(x.impulse, k.h);
                if allowed != x.impulse {
                    (x.impulse, x.acts, changed) = (allowed, false, true);
                }
            }
            // Ropes pull and struts push, like ends.
            if which(&ENDS) && s.has_to_let_go() {
                (s.lambda[0], s.active, changed) = (0.0, false, true);
            }
        }
        changed
    }

    fn let_in(&mut self, k: &Constants, sweep: Sweep, motors: bool) -> bool {
        let mut changed = false;
        for s in &mut self.joints {
            let (a, b) = (&self.bodies[s.a].m, &self.bodies[s.b].m);
            let taken = s.taken();
            for x in s.extra[..taken]
                .iter_mut()
                .filter(|x| !x.acts && x.mass > 0.0 && x.in_direct(k.h) && (motors || x.is_hard_end()))
            {
                x.acts = x.must_act(x.row.speed(a, b), k, sweep);
                changed |= x.acts;
            }
            if s.has_to_hold(a, b, k, sweep) {
                (s.active, changed) = (true, true);
            }
        }
        changed
    }

    fn hand_out(&mut self, k: &Constants) {
        let Some(plan) = &self.plan else { return };
        self.bodies.iter_mut().for_each(|b| b.dv = [0.0; 6]);
        for (i, s) in self.joints.iter().enumerate() {
            for (r, &code) in s.packed[..s.count].iter().enumerate() {
                let lambda = plan.get(&self.numbers, i, r);
                let (la, ja) = s.end(code, true);
                let (lb, jb) = s.end(code, false);
                self.bodies[s.a].push(la, ja, lambda);
                self.bodies[s.b].push(lb, jb, lambda);
            }
        }
        self.bodies.iter_mut().for_each(Local::give);
        let part = self.bodies.iter().map(|b| bearable(b, k)).fold(1.0, f64s::min);
        for (i, s) in self.joints.iter_mut().enumerate() {
            for r in 0..s.count {
                let lambda = part * plan.get(&self.numbers, i, r);
                let c = usize::from(s.packed[r]);
                if c < HARD {
                    s.lambda[c] += lambda as f32;
                } else {
                    let x = &mut s.extra[c - HARD];
                    x.impulse = (f64::from(x.impulse) + lambda) as f32;
                }
            }
        }
        for b in &mut self.bodies {
            let m = &mut b.m;
            for i in 0..3 {
                m.v[i] = (f64::from(m.v[i]) + part * b.dv[i]) as f32;
                m.w[i] = (f64::from(m.w[i]) + part * b.dv[i + 3]) as f32;
            }
        }
    }
}

/// The part of a change of velocity and spin that takes a body no further from where the pass began than it may. (What rounds have taken
/// back may be more than that.)
pub(super) fn bearable(b: &Local, k: &Constants) -> f64 {
    let change = |now: Vec3, before: Vec3, d: &[f64]| {
        let [x, y, z] = [0, 1, 2].map(|i| f64::from(now[i]) - f64::from(before[i]) + d[i]);
        (x * x + y * y + z * z).sqrt()
    };
    let [v, w] = b.before;
    let over = f64s::max(
        change(b.m.v, v, &b.dv[..3]) / f64::from(k.speed_max),
        change(b.m.w, w, &b.dv[3..]) / f64::from(k.spin_max),
    );
    if !over.is_finite() {
        0.0
    } else if over > 1.0 {
        1.0 / over
    } else {
        1.0
    }
}
