//! One joint of a set: its rows, and what it does with them alone.

use super::desc::{AxisDesc, BallDesc, JointKind, MotorTarget, SpringDesc};
use super::direct::{ROWS, invert};
use super::extra::{Extra, Extras, Sweep, gains, push};
use super::local::Local;
use super::rows::{Ends, Hard, Row, Start};
use super::set::Constants;
use super::state::Joint;
use super::{ball, distance, fixed, generic, hinge, path, pulley, slider, spring, wheel};
use crate::room::rigid::state::Motion;
use jounce_math::{Vec3, scalar::f32s};

/// A joint of a set, in this step.
#[derive(Clone, Debug)]
pub(crate) struct Solve {
    pub id: u32,
    /// Bodies of the set.
    pub a: usize,
    pub b: usize,
    pub start: Start,
    /// Pulleys: from the wheels to the centres of mass at the start.
    pub wheels: [Vec3; 2],
    pub hard: Hard,
    /// M⁻¹ Jᵀ of the turns of the rows that hold.
    pub(super) ia: [Vec3; HARD],
    pub(super) ib: [Vec3; HARD],
    /// One-sided rows: +1 pushes, −1 pulls, 0 both.
    pub(super) sign: f32,
    /// Its points are pulled each at its own anchor.
    torn: bool,
    /// The rows that hold take part.
    pub(super) active: bool,
    pub(super) soft: Option<SpringDesc>,
    /// Compliance of each row, (velocity per impulse): 0 rigid, infinite: takes no part.
    pub(super) give_way: [f32; HARD],
    /// Iterative: (J M⁻¹ Jᵀ + compliance)⁻¹.
    pub(super) inverse: [f64; HARD * HARD],
    pub extra: Vec<Extra>,
    pub(super) scratch: Vec<Extra>,
    /// Rows of the direct solve: those that hold by number, the others from [`HARD`] on.
    pub(super) packed: [u8; ROWS],
    pub(super) count: usize,
    /// Impulses of this substep on the rows that hold.
    pub lambda: [f32; HARD],
    pub(super) before: [f32; HARD],
    /// What the errors after the substep will be beyond c + h J u.
    pub(super) bend: [f32; HARD],
    pub coordinate: f32,
    /// The coordinate is a length, not an angle.
    pub slides: bool,
    /// A rod or rope: its pull turns with it.
    pub(super) rod: bool,
    /// Σ over the step of impulse and moment about the anchor, on B.
    pub force: Vec3,
    pub torque: Vec3,
    /// Sizes of both in this substep and the one before.
    pub last: [f32; 2],
    /// Broke in this step.
    pub broke: bool,
    /// Neither body gives way: it is here for the gears on it, which follow its coordinate.
    pub led: bool,
}

impl Solve {
    pub fn new(id: u32, a: usize, b: usize) -> Self {
        Self {
            id,
            a,
            b,
            start: Start::default(),
            wheels: [Vec3::ZERO; 2],
            hard: Hard::default(),
            ia: [Vec3::ZERO; HARD],
            ib: [Vec3::ZERO; HARD],
            sign: 0.0,
            torn: false,
            active: true,
            soft: None,
            give_way: [0.0; HARD],
            inverse: [0.0; HARD * HARD],
            extra: Vec::new(),
            scratch: Vec::new(),
            packed: [0; ROWS],
            count: 0,
            lambda: [0.0; HARD],
            before: [0.0; HARD],
            bend: [0.0; HARD],
            coordinate: 0.0,
            slides: false,
            rod: false,
            force: Vec3::ZERO,
            torque: Vec3::ZERO,
            last: [0.0; 2],
            broke: false,
            led: false,
        }
    }

    /// What a joint remembers from the last step.
    pub fn begin(&mut self, j: &Joint) {
        self.soft = j.desc.softness;
        self.rod = matches!(j.desc.kind, JointKind::Distance { .. });
        self.give_way = [0.0; HARD];
        if self.rod {
            self.give_way[1..3].fill(f32::INFINITY);
        }
        self.slides = matches!(j.desc.kind, JointKind::Slider(_));
        self.coordinate = j.coordinate;
        self.lambda = j.hard;
        self.last = j.last;
        (self.force, self.torque, self.broke) = (Vec3::ZERO, Vec3::ZERO, false);
        self.extra.clear();
    }

    /// Which end of a rope, a strut or a pulley it is about now.
    pub(super) fn side(&self, j: &Joint, e: &Ends) -> f32 {
        match &j.desc.kind {
            JointKind::Distance { min, max } => distance::side(*min, *max, e),
            JointKind::Pulley { .. } => -1.0,
            _ => 0.0,
        }
    }

    /// Rows that hold, at these ends.
    pub(super) fn rows(&self, j: &Joint, e: &Ends, dp: [Vec3; 2], s: &mut f32, out: &mut Hard) {
        out.n = 0;
        if self.led {
            return;
        }
        match &j.desc.kind {
            JointKind::Fixed => fixed::rows(e, out),
            JointKind::Ball(_) => ball::rows(e, out),
            JointKind::Hinge(_) => hinge::rows(e, out),
            JointKind::Slider(_) => slider::rows(e, out),
            JointKind::Distance { min, max } => distance::rows(*min, *max, self.sign, e, out),
            JointKind::Wheel { suspension, steer, .. } => wheel::rows(suspension, steer, e, out),
            JointKind::Generic { linear, angular } => generic::rows(linear, angular, e, out),
            JointKind::Pulley { ratio, length, .. } => {
                let [a, b] = [self.wheels[0] + dp[0] + e.ra, self.wheels[1] + dp[1] + e.rb];
                out.push(pulley::row(e, a, b, *ratio, length.unwrap_or(0.0)));
            }
            JointKind::Path(p) => {
                if let Some(curve) = &j.curve {
                    path::rows(p.aligned, &path::slide(curve, e, s), out);
                }
            }
            JointKind::Spring { .. } | JointKind::Gear { .. } => {}
        }
    }

    /// Springs, motors, ends and friction at these ends, put behind what is in the list; `coordinate` goes from where it was last.
    pub(super) fn ends(&self, j: &Joint, e: &Ends, coordinate: &mut f32, list: &mut Vec<Extra>) {
        let before = list.len();
        let mut out = Extras { list };
        match &j.desc.kind {
            JointKind::Ball(d) => ball::extras(d, e, &mut out),
            JointKind::Hinge(x) => hinge::extras(x, e, coordinate, &mut out),
            JointKind::Slider(x) => slider::extras(x, e, coordinate, &mut out),
            JointKind::Spring { rest, spring: s, limit } => {
                spring::extras(*rest, *s, *limit, e, &mut out);
            }
            JointKind::Wheel { suspension, spin, steer } => {
                wheel::extras([suspension, spin, steer], e, coordinate, &mut out);
            }
            JointKind::Generic { linear, angular } => {
                generic::extras(linear, angular, e, coordinate, &mut out);
            }
            JointKind::Path(p) => {
                if let Some(curve) = &j.curve {
                    let slid = path::slide(curve, e, coordinate).ends;
                    let mut row = slid.along(slid.axis_a(0));
                    row.c = *coordinate;
                    out.axis(&p.axis, row);
                }
            }
            _ => {}
        }
        if self.led {
            list.truncate(before);
        }
    }

    /// Ways of the substep are straight.
    pub(super) fn straighten(&mut self) {
        self.bend = [0.0; HARD];
        self.extra.iter_mut().for_each(|x| x.bend = 0.0);
    }

    /// How far errors and the ends' coordinates will be from c + h J u, by the present velocities.
    pub(super) fn bend(&mut self, j: &Joint, bodies: &[Local], k: &Constants) {
        let (a, b) = (&bodies[self.a].m, &bodies[self.b].m);
        if self.soft.is_none() && self.hard.n > 0 {
            let ahead = self.ahead(j, a, b, k);
            for (i, bend) in self.bend[..self.hard.n].iter_mut().enumerate() {
                let row = &self.hard.rows[i];
                *bend = ahead.rows[i].c - row.c - k.h * row.speed(a, b);
            }
        }
        self.bend_of_ends(j, bodies, k);
    }

    /// A rope that pushes, a strut that pulls.
    pub(super) fn has_to_let_go(&self) -> bool {
        self.active && self.sign * self.lambda[0] < 0.0
    }

    /// A rope that is slack, but would be too long.
    pub(super) fn has_to_hold(&self, a: &Motion, b: &Motion, k: &Constants, sweep: Sweep) -> bool {
        let row = &self.hard.rows[0];
        self.sign != 0.0
            && !self.active
            && self.soft.is_none()
            && sweep != Sweep::Relax
            && self.sign * (row.c + self.bend[0] + k.h * row.speed(a, b)) < -TOUCH
    }

    /// Cones and twists bend: what moves along a cone's rim leaves it by half the square of its angle. So those near enough are measured
    /// where the bodies would be.
    fn bend_of_ends(&mut self, j: &Joint, bodies: &[Local], k: &Constants) {
        if !matches!(j.desc.kind, JointKind::Ball(_) | JointKind::Generic { .. }) {
            return;
        }
        let (a, b) = (&bodies[self.a].m, &bodies[self.b].m);
        let most = k.h * (a.w.length() + b.w.length()) + TOUCH;
        let turns = |x: &Extra| x.is_hard_end() && x.row.la == Vec3::ZERO;
        let mut near = false;
        for x in &mut self.extra {
            x.bend = 0.0;
            near |= turns(x) && x.gap() < most;
        }
        if !near {
            return;
        }
        let e = Ends::predicted(&self.start, a, b, k.h);
        let (mut list, mut coordinate) = (core::mem::take(&mut self.scratch), self.coordinate);
        list.clear();
        self.ends(j, &e, &mut coordinate, &mut list);
        for (x, y) in self.extra.iter_mut().zip(&list).filter(|(x, _)| turns(x)) {
            let turn = 2.0 * core::f32::consts::PI;
            let way = y.row.c - x.row.c;
            let bend = way - turn * (way / turn).round() - k.h * x.row.speed(a, b);
            // What it asks for at once is bounded like an error.
            x.bend = limited(bend, k.correct * k.h);
        }
        self.scratch = list;
    }

    /// Turns the row of a narrow cone to where the present velocities lead, Σ of its swing and h (ω_b − ω_a) across its axis: what passes
    /// from one side of the cone to the other within a substep meets the rim there, not where it comes from. True where it did.
    pub(super) fn aim(&mut self, j: &Joint, bodies: &[Local], k: &Constants) -> bool {
        let JointKind::Ball(BallDesc { cone: Some(cone), cone_spring: None, .. }) = &j.desc.kind else {
            return false;
        };
        let Some(x) = self.extra.first_mut().filter(|_| *cone < NARROW) else { return false };
        let (a, b) = (&bodies[self.a], &bodies[self.b]);
        let e = Ends::now(&self.start, &a.m, &b.m);
        let (now, axis) = (e.cone(), e.axis_a(0));
        let swing = now.jb * now.c;
        let turn = (b.m.w - a.m.w) * k.h;
        let ahead = swing + turn - axis * axis.dot(turn);
        let size = ahead.length();
        if size < TOUCH {
            return false;
        }
        let n = ahead / size;
        x.impulse *= f32s::max(n.dot(x.row.jb), 0.0);
        x.row = Row { ja: -n, jb: n, c: n.dot(swing), ..now };
        weigh(x, a, b);
        true
    }

    /// Rows that hold, where the present velocities would take the bodies.
    pub(super) fn ahead(&self, j: &Joint, a: &Motion, b: &Motion, k: &Constants) -> Hard {
        let e = Ends { torn: self.torn, ..Ends::predicted(&self.start, a, b, k.h) };
        let mut ahead = Hard::default();
        let mut c = self.coordinate;
        self.rows(j, &e, [a.dp + a.v * k.h, b.dp + b.v * k.h], &mut c, &mut ahead);
        ahead
    }

    /// All rows anew, where the bodies are now; `first` in the step fetches the impulses that it starts from.
    pub(super) fn refresh(&mut self, j: &Joint, bodies: &[Local], iterative: bool) {
        let (a, b) = (&bodies[self.a], &bodies[self.b]);
        let e = Ends::now(&self.start, &a.m, &b.m);
        let mut hard = self.hard;
        let mut slid = self.coordinate;
        self.sign = self.side(j, &e);
        self.torn = e.torn;
        self.rows(j, &e, [a.m.dp, b.m.dp], &mut slid, &mut hard);
        self.hard = hard;
        let mut list = core::mem::take(&mut self.extra);
        // New rows go behind the old ones, whose impulses then move over.
        let impulses = list.len();
        let mut coordinate = self.coordinate;
        self.ends(j, &e, &mut coordinate, &mut list);
        self.coordinate = coordinate;
        let n = list.len() - impulses;
        for i in 0..n {
            let (impulse, acts) = if impulses == n {
                (list[i].impulse, list[i].acts)
            } else {
                (j.extra.get(i).copied().unwrap_or(0.0), false)
            };
            (list[impulses + i].impulse, list[impulses + i].acts) = (impulse, acts);
        }
        list.drain(..impulses);
        self.extra = list;
        for x in &mut self.extra {
            weigh(x, a, b);
        }
        for i in 0..self.hard.n {
            self.ia[i] = a.tensor.mul(self.hard.rows[i].ja);
            self.ib[i] = b.tensor.mul(self.hard.rows[i].jb);
            // Along what is locked nothing moves; an impulse would only grow.
            let row = &self.hard.rows[i];
            if inverse_mass(row, self.ia[i], self.ib[i], a, b) <= UNMOVED * most_inverse_mass(row, a, b) {
                self.give_way[i] = f32::INFINITY;
            }
        }
        if iterative {
            let n = self.hard.n;
            for r in 0..n {
                for c in 0..n {
                    let out = self.give_way[r] == f32::INFINITY || self.give_way[c] == f32::INFINITY;
                    self.inverse[r * n + c] = if out { 0.0 } else { self.meets_itself(r, c, a, b) };
                }
                if self.give_way[r] < f32::INFINITY {
                    self.inverse[r * n + r] += f64::from(self.give_way[r]);
                }
            }
            invert(&mut self.inverse[..n * n], n);
        }
    }

    /// Direction along and about of a row of the direct solve on one of its bodies.
    pub(super) fn end(&self, code: u8, a: bool) -> (Vec3, Vec3) {
        let row = self.row(code);
        if a { (row.la, row.ja) } else { (row.lb, row.jb) }
    }
    pub(super) fn row(&self, code: u8) -> &Row {
        let i = usize::from(code);
        if i < HARD { &self.hard.rows[i] } else { &self.extra[i - HARD].row }
    }
    /// What a row gives way by, velocity per impulse.
    pub(super) fn compliance(&self, code: u8, bodies: &[Local], h: f32) -> f64 {
        match usize::from(code) {
            c if c < HARD => {
                f64::from(self.softness(c, bodies, h).map_or(self.give_way[c], |(gives, _)| gives))
            }
            c => self.extra[c - HARD].compliance(h),
        }
    }
    /// Impulse of a row in this substep.
    pub(super) fn impulse(&self, code: u8) -> f32 {
        match usize::from(code) {
            c if c < HARD => self.lambda[c],
            c => self.extra[c - HARD].impulse,
        }
    }
    /// Ends and motors that the direct solve may take.
    pub(super) fn taken(&self) -> usize {
        self.extra.len().min(ROWS - self.hard.n)
    }
    /// Which rows take part; those that hold first.
    pub(super) fn pack(&mut self, sweep: Sweep) {
        self.count = 0;
        for r in 0..self.hard.n {
            let dampers_rest = sweep != Sweep::Solve && self.yields(r);
            if self.active && self.give_way[r] < f32::INFINITY && !dampers_rest {
                self.packed[self.count] = r as u8;
                self.count += 1;
            }
        }
        for i in 0..self.taken() {
            if self.extra[i].acts {
                self.packed[self.count] = (HARD + i) as u8;
                self.count += 1;
            }
        }
    }

    /// J_r M⁻¹ J_cᵀ over both bodies.
    pub(super) fn meets_itself(&self, r: usize, c: usize, a: &Local, b: &Local) -> f64 {
        self.meets(r, true, self, c, true, a) + self.meets(r, false, self, c, false, b)
    }
    /// J_r M⁻¹ J_cᵀ over one body, of which this joint's and the other's ends are A or B.
    pub(super) fn meets(&self, r: usize, a: bool, o: &Self, c: usize, oa: bool, body: &Local) -> f64 {
        let (x, y) = (&self.hard.rows[r], &o.hard.rows[c]);
        let (l, j) = if a { (x.la, x.ja) } else { (x.lb, x.jb) };
        let (ol, i) = if oa { (y.la, o.ia[c]) } else { (y.lb, o.ib[c]) };
        dot64(l.mul(body.inv_mass), wide(ol)) + dot64(j, wide(i))
    }

    pub(super) fn hold(&mut self, bodies: &mut [Local], k: &Constants, sweep: Sweep, first: bool) {
        let n = self.hard.n;
        if n == 0 || (self.soft.is_some() && (sweep != Sweep::Solve || !first)) {
            return;
        }
        let mut r = [0.0_f64; HARD];
        for (i, r) in r[..n].iter_mut().enumerate() {
            let row = &self.hard.rows[i];
            let v = row.speed(&bodies[self.a].m, &bodies[self.b].m);
            let c = limited(row.c, k.correct * k.h);
            if self.yields(i) {
                // A damper: once per substep it takes −λ/compliance.
                *r = if sweep == Sweep::Solve && self.give_way[i] < f32::INFINITY {
                    f64::from(v + self.give_way[i] * self.lambda[i])
                } else {
                    0.0
                };
                continue;
            }
            let open = self.sign * row.c > 0.0 && self.sign != 0.0;
            *r = f64::from(match (sweep, self.soft) {
                (_, _) if open => v + row.c / k.h,
                (Sweep::Relax, _) => v,
                (Sweep::Place, _) => v + row.c,
                (Sweep::Solve, None) => k.soft.mass_scale * (v + k.soft.bias_rate * c),
                (Sweep::Solve, Some(spring)) => {
                    let inv = self.meets_itself(i, i, &bodies[self.a], &bodies[self.b]);
                    let mass = if inv > 0.0 { (1.0 / inv) as f32 } else { 0.0 };
                    let (a, b) = gains(&spring, mass, k.h);
                    a * c + b * v
                }
            });
        }
        let fade = if sweep == Sweep::Solve && self.soft.is_none() { k.soft.impulse_scale } else { 0.0 };
        let mut change = [0.0_f32; HARD];
        for i in 0..n {
            let mut sum = 0.0;
            for (c, r) in r[..n].iter().enumerate() {
                sum += self.inverse[i * n + c] * r;
            }
            let mut new = self.lambda[i] - sum as f32 - fade * self.lambda[i];
            if self.sign != 0.0 && i == 0 {
                new = self.sign * f32s::max(self.sign * new, 0.0);
            }
            change[i] = new - self.lambda[i];
        }
        let part = self.bearable(bodies, &change, k);
        for (i, change) in change[..n].iter().enumerate() {
            self.lambda[i] += part * change;
            self.give(bodies, i, part * change);
        }
    }

    /// The part of these impulses that changes neither body by more than a pass may.
    fn bearable(&self, bodies: &[Local], change: &[f32; HARD], k: &Constants) -> f32 {
        let mut by = [[Vec3::ZERO; 2]; 2];
        for (i, change) in change[..self.hard.n].iter().enumerate() {
            let row = &self.hard.rows[i];
            by[0][0] += row.la.mul(bodies[self.a].inv_mass) * *change;
            by[0][1] += self.ia[i] * *change;
            by[1][0] += row.lb.mul(bodies[self.b].inv_mass) * *change;
            by[1][1] += self.ib[i] * *change;
        }
        bearable(by, k)
    }

    /// A soft row of the direct solve yields: v⁺ + γ λ + β = 0 with γ = (1/b − 1)/m, β = a C/b, which alone gives the spring's own
    /// λ = −m (a C + b v). As a velocity that the row must have, beside rigid rows and others of another softness, it blew up.
    pub(super) fn softness(&self, row: usize, bodies: &[Local], h: f32) -> Option<(f32, f32)> {
        let spring = self.soft?;
        let inv = self.meets_itself(row, row, &bodies[self.a], &bodies[self.b]) as f32;
        if inv <= 0.0 {
            return Some((0.0, 0.0));
        }
        let (a, b) = gains(&spring, 1.0 / inv, h);
        let b = f32s::max(b, UNDAMPED);
        Some(((1.0 / b - 1.0) * inv, a * self.hard.rows[row].c / b))
    }

    /// A damper across a rod.
    pub(super) fn yields(&self, row: usize) -> bool {
        self.rod && row > 0
    }

    pub(super) fn give(&self, bodies: &mut [Local], i: usize, lambda: f32) {
        let row = &self.hard.rows[i];
        let a = &mut bodies[self.a];
        a.m.v += row.la.mul(a.inv_mass) * lambda;
        a.m.w += self.ia[i] * lambda;
        let b = &mut bodies[self.b];
        b.m.v += row.lb.mul(b.inv_mass) * lambda;
        b.m.w += self.ib[i] * lambda;
    }

    /// Springs, motors and ends.
    pub(super) fn sweep_extra(&mut self, bodies: &mut [Local], k: &Constants, sweep: Sweep, direct: bool) {
        let taken = if direct { self.taken() } else { 0 };
        for (i, x) in self.extra.iter_mut().enumerate() {
            if i < taken && x.in_direct(k.h) {
                continue;
            }
            let v = x.row.speed(&bodies[self.a].m, &bodies[self.b].m);
            let d = push(x, v, sweep, k.h, k.push_out);
            let [va, vb] =
                [(x.row.la, self.a), (x.row.lb, self.b)].map(|(l, b)| l.mul(bodies[b].inv_mass) * d);
            let part = bearable([[va, x.ia * d], [vb, x.ib * d]], k);
            if part < 1.0 {
                x.impulse += (part - 1.0) * d;
            }
            give_extra(x, bodies, self.a, self.b, part * d);
        }
    }

    /// Impulses that the substep starts from.
    pub(super) fn warm(&mut self, bodies: &mut [Local], k: &Constants, direct: bool) {
        let taken = if direct { self.taken() } else { 0 };
        for (i, x) in self.extra.iter_mut().enumerate() {
            if i >= taken {
                x.impulse *= if x.may_hold() { k.warm } else { 0.0 };
            } else {
                // What gave all it could goes on so, what pushed stays a candidate.
                x.acts = x.impulse != 0.0;
                if !x.gives_all(k.h) {
                    x.impulse = 0.0;
                }
            }
            give_extra(x, bodies, self.a, self.b, x.impulse);
        }
        let keep = if direct || self.soft.is_some() { 0.0 } else { k.warm };
        for i in 0..self.hard.n {
            self.lambda[i] *= if self.yields(i) { 0.0 } else { keep };
            if self.lambda[i] != 0.0 {
                self.give(bodies, i, self.lambda[i]);
            }
        }
    }

    /// What the substep's impulses come to, and whether the joint stands it.
    pub(super) fn account(&mut self, j: &Joint, k: &Constants, rb: Vec3) {
        let (mut p, mut l) = (Vec3::ZERO, Vec3::ZERO);
        let hard = self.hard.rows.iter().zip(&self.lambda).take(self.hard.n);
        for (row, lambda) in hard.chain(self.extra.iter().map(|x| (&x.row, &x.impulse))) {
            p += row.lb * *lambda;
            l += (row.jb - rb.cross(row.lb)) * *lambda;
        }
        self.force += p;
        self.torque += l;
        let now = [p.length() / k.h, l.length() / k.h];
        let over = |i: usize, most: f32| f32s::min(now[i], self.last[i]) > most;
        self.broke |= over(0, j.desc.break_force) || over(1, j.desc.break_torque);
        self.last = now;
    }
}

/// What a row moves, and its effective mass: 0 where it moves nothing.
fn weigh(x: &mut Extra, a: &Local, b: &Local) {
    x.ia = a.tensor.mul(x.row.ja);
    x.ib = b.tensor.mul(x.row.jb);
    let inv = inverse_mass(&x.row, x.ia, x.ib, a, b);
    x.mass = if inv > UNMOVED * most_inverse_mass(&x.row, a, b) { 1.0 / inv } else { 0.0 };
}

/// The part of two bodies' changes of velocity and spin that a pass may make.
fn bearable(by: [[Vec3; 2]; 2], k: &Constants) -> f32 {
    let over = by.map(|[dv, dw]| f32s::max(dv.length() / k.speed_max, dw.length() / k.spin_max));
    let over = f32s::max(over[0], over[1]);
    if over.is_finite() { 1.0 / f32s::max(over, 1.0) } else { 0.0 }
}

pub(super) fn give_extra(x: &Extra, bodies: &mut [Local], a: usize, b: usize, d: f32) {
    if d == 0.0 {
        return;
    }
    let body = &mut bodies[a];
    body.m.v += x.row.la.mul(body.inv_mass) * d;
    body.m.w += x.ia * d;
    let body = &mut bodies[b];
    body.m.v += x.row.lb.mul(body.inv_mass) * d;
    body.m.w += x.ib * d;
}

/// What it would be if both bodies gave way in the row's directions as in their lightest.
fn most_inverse_mass(row: &Row, a: &Local, b: &Local) -> f32 {
    let of = |l: Vec3, j: Vec3, x: &Local| {
        let t = &x.tensor;
        l.length_squared() * x.inv_mass.max_component() + j.length_squared() * (t.xx + t.yy + t.zz)
    };
    of(row.la, row.ja, a) + of(row.lb, row.jb, b)
}

pub(super) fn inverse_mass(row: &Row, ia: Vec3, ib: Vec3, a: &Local, b: &Local) -> f32 {
    row.la.dot(row.la.mul(a.inv_mass)) + row.ja.dot(ia) + row.lb.dot(row.lb.mul(b.inv_mass)) + row.jb.dot(ib)
}

pub(super) fn dot64(a: Vec3, b: [f64; 3]) -> f64 {
    f64::from(a.x) * b[0] + f64::from(a.y) * b[1] + f64::from(a.z) * b[2]
}

pub(super) fn wide(v: Vec3) -> [f64; 3] {
    [f64::from(v.x), f64::from(v.y), f64::from(v.z)]
}

pub(super) fn limited(c: f32, most: f32) -> f32 {
    f32s::clamp(c, -most, most)
}

/// Rows of a joint that hold, at most.
pub(super) const HARD: usize = 6;
/// A row whose inverse mass is less than this part of what its bodies have in other directions moves nothing: locked axes, and rounding.
const UNMOVED: f32 = 1e-8;
/// Half-angle up to which a cone is narrow: a substep's turn may cross it, rad.
const NARROW: f32 = 0.1;
/// Part of its speed that a soft row takes at least in a substep.
const UNDAMPED: f32 = 1e-5;
/// How far beyond an end counts, m or rad.
pub(super) const TOUCH: f32 = 1e-6;

/// Ends and motors of a kind that may hold.
fn extra_count(kind: &JointKind) -> usize {
    let axis = |a: &AxisDesc| {
        let motor = a.motor.is_some_and(|m| matches!(m.target, MotorTarget::Velocity(_)));
        if a.locked {
            0
        } else {
            usize::from(a.limit.is_some())
                + usize::from(motor)
                + usize::from(a.friction > 0.0)
                + usize::from(a.spring.is_some())
                + usize::from(a.motor.is_some() && !motor)
        }
    };
    match kind {
        JointKind::Ball(b) => {
            let motor = if b.motor.is_some() { 3 } else { 0 };
            let friction = if b.friction > 0.0 { 3 } else { 0 };
            usize::from(b.cone.is_some()) + usize::from(b.twist.is_some()) + motor + friction
        }
        JointKind::Hinge(a) | JointKind::Slider(a) => axis(a),
        JointKind::Spring { limit, .. } => 1 + usize::from(limit.is_some()),
        JointKind::Wheel { suspension, spin, steer } => axis(suspension) + axis(spin) + axis(steer),
        JointKind::Generic { linear, angular } => linear.iter().chain(angular).map(axis).sum(),
        JointKind::Path(p) => axis(&p.axis),
        _ => 0,
    }
}

/// Rows that a kind holds, and its ends, motors, springs and friction: while they stay, so does the set's matrix.
pub(crate) fn counts(kind: &JointKind) -> [usize; 2] {
    [row_count(kind), extra_count(kind)]
}

/// Rows that a kind holds.
fn row_count(kind: &JointKind) -> usize {
    match kind {
        JointKind::Fixed => 6,
        JointKind::Ball(_) => 3,
        JointKind::Hinge(_) | JointKind::Slider(_) => 5,
        JointKind::Distance { .. } => 3,
        JointKind::Pulley { .. } => 1,
        JointKind::Wheel { suspension, steer, .. } => {
            3 + usize::from(suspension.locked) + usize::from(steer.locked)
        }
        JointKind::Generic { linear, angular } => linear.iter().chain(angular).filter(|a| a.locked).count(),
        JointKind::Path(p) => {
            if p.aligned {
                5
            } else {
                2
            }
        }
        JointKind::Spring { .. } | JointKind::Gear { .. } => 0,
    }
}
