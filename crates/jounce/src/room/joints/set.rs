//! Joints that hang together, solved as one.
//!
//! A set is a connected part of the graph of joints over moving bodies. It works on copies of its bodies, so sets are solved side by
//! side, whatever else the bodies touch. Per substep, in this order:
//!
//! * solve: warm start; springs, motors, ends; then the rows that hold, directly: A λ = −C(t + h)/h, where C(t + h) is the error
//!   that the present velocities would lead to, curvature and all. One Newton step of the position constraint, then: what
//!   RATTLE solves for (Andersen 1983), and with the velocities made consistent at the new positions by the relaxing pass it is
//!   symplectic like it: a pendulum's energy does not drift;
//! * relax, after the positions moved: all rows anew, J u = 0 on those that hold.
//!
//! Light links under a heavy load. A link of inertia I under the tension f, held at the lever r, swings across the pull at
//! ω = √(r·f/I); 20 g under 100 kg at 2,000 rad/s, which no substep resolves, and explicit motion would blow up. So tension acts implicitly
//! where h² r·f > I (on rods' ends: h² f/L > m): G = h² Σ (r·f)(1 − n nᵀ), n = r/|r|, and only the part of G beyond I is added,
//! (I + G′) ω′ = I ω + Σ τ. It is implicit Euler's own treatment of those modes (geometric stiffness), damping included;
//! whatever moves slowly enough has no part in it. So the load may be ten tons, and no joint yields.
//!
//! Inertia is that of the moment, not of the start of the step: a slender body that turned within the step would otherwise seem to
//! yield about what was its axis.
//!
//! Sources: Tournier et al., Stable constrained dynamics, 2015; Andrews et al., Geometric stiffness for real-time constrained
//! multibody dynamics, 2017.

use super::desc::LimitDesc;
use super::desc::{AxisDesc, JointKind, JointSolver, MotorTarget, SpringDesc};
use super::direct::{Numbers, Plan, ROWS, invert};
use super::extra::{Duty, Extra, Extras, Sweep, gains, push};
use super::rows::{Ends, Hard, Row, Start, turned};
use super::state::{Joint, Joints};
use super::{ball, distance, fixed, generic, hinge, path, pulley, slider, wheel};
use crate::room::contacts::prepare::Softness;
use crate::room::rigid::state::{InvInertia, Motion, NONE, Turning};
use jounce_math::{Mat3, Vec3, scalar::f32s};

/// A body of a set.
#[derive(Clone, Debug)]
pub(crate) struct Local {
    pub slot: u32,
    /// Awake row, or NONE for what does not move.
    pub row: u32,
    pub m: Motion,
    /// Inverse mass along each world axis: 0 along locked ones.
    pub inv_mass: Vec3,
    pub tensor: InvInertia,
    /// Torque-free memory, and the velocity it was told last.
    pub turning: Option<Turning>,
    /// Turns freely: inertia follows the rotation.
    pub free: bool,
    /// Both as the step began.
    pub start_inv_mass: Vec3,
    pub start_tensor: InvInertia,
    /// Turns are unlocked.
    pub turns: bool,
    /// World inertia now, where it may be raised: turns unlocked.
    pub inertia: Option<Mat3>,
    /// What tension adds to inertia in this substep.
    added_inertia: Mat3,
    /// Σ of the pass, f64: impulses of a heavy load through light links cancel to a millionth.
    dv: [f64; 6],
    /// Velocities that the rounds of the active set start from.
    before: [Vec3; 2],
}

impl Local {
    pub fn new(slot: u32) -> Self {
        let m = crate::room::rigid::state::BodyState::FIXED.get();
        Self {
            slot,
            row: NONE,
            m,
            inv_mass: Vec3::ZERO,
            tensor: InvInertia::default(),
            turning: None,
            free: false,
            start_inv_mass: Vec3::ZERO,
            start_tensor: InvInertia::default(),
            turns: false,
            inertia: None,
            added_inertia: Mat3::ZERO,
            dv: [0.0; 6],
            before: [Vec3::ZERO; 2],
        }
    }
    /// Keeps of what tension would add only what explicit motion cannot stand.
    fn raise_part(&mut self) {
        let Some(inertia) = &self.inertia else {
            self.added_inertia = Mat3::ZERO;
            return;
        };
        let g = 0.5 * trace(&self.added_inertia);
        let own = 0.5 * trace(inertia);
        let part = if g > own { 1.0 - own / g } else { 0.0 };
        self.added_inertia = self.added_inertia.scale(part);
    }
    /// Inertia with what tension adds.
    fn apply_added(&mut self) {
        if self.added_inertia == Mat3::ZERO {
            return;
        }
        if let Some(inv) = self.inertia.and_then(|i| (i + self.added_inertia).inverse()) {
            self.tensor = InvInertia {
                xx: inv.cx.x,
                yy: inv.cy.y,
                zz: inv.cz.z,
                xy: 0.5 * (inv.cx.y + inv.cy.x),
                xz: 0.5 * (inv.cx.z + inv.cz.x),
                yz: 0.5 * (inv.cy.z + inv.cz.y),
                ..self.tensor
            };
        }
    }
    /// Joints can change its velocity.
    pub fn moves(&self) -> bool {
        self.inv_mass != Vec3::ZERO || self.tensor.xx > 0.0 || self.tensor.yy > 0.0 || self.tensor.zz > 0.0
    }
}

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
    ia: [Vec3; HARD],
    ib: [Vec3; HARD],
    /// One-sided rows: +1 pushes, −1 pulls, 0 both.
    sign: f32,
    /// The rows that hold take part.
    active: bool,
    soft: Option<SpringDesc>,
    /// Compliance of each row, (velocity per impulse): 0 rigid, infinite: takes no part.
    give_way: [f32; HARD],
    /// Iterative: (J M⁻¹ Jᵀ + compliance)⁻¹.
    inverse: [f64; HARD * HARD],
    pub extra: Vec<Extra>,
    scratch: Vec<Extra>,
    /// Rows of the direct solve: those that hold by number, the others from [`HARD`] on.
    packed: [u8; ROWS],
    count: usize,
    /// Impulses of this substep on the rows that hold.
    pub lambda: [f32; HARD],
    before: [f32; HARD],
    pub coordinate: f32,
    /// The coordinate is a length, not an angle.
    pub slides: bool,
    /// A rod or rope: its pull turns with it.
    rod: bool,
    /// Σ over the step of impulse and moment about the anchor, on B.
    pub force: Vec3,
    pub torque: Vec3,
    /// Sizes of both in this substep and the one before.
    pub last: [f32; 2],
    /// Broke in this step.
    pub broke: bool,
}

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
}

/// See the module's text.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointSet {
    pub joints: Vec<Solve>,
    pub gears: Vec<Gear>,
    pub bodies: Vec<Local>,
    pub plan: Option<Plan>,
    numbers: Numbers,
    /// Rows that the factors in `numbers` are of.
    factored: Vec<u64>,
    fresh: bool,
    /// Was put together again after continuous collision.
    pub placed: bool,
    /// Pairs of joints that share a moving body, and which.
    shared: Vec<(u32, u32, u32)>,
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
            coordinate: 0.0,
            slides: false,
            rod: false,
            force: Vec3::ZERO,
            torque: Vec3::ZERO,
            last: [0.0; 2],
            broke: false,
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
    fn side(&self, j: &Joint, e: &Ends) -> f32 {
        match &j.desc.kind {
            JointKind::Distance { min, max } => distance::side(*min, *max, e),
            JointKind::Pulley { .. } => -1.0,
            _ => 0.0,
        }
    }

    /// Rows that hold, at these ends.
    fn rows(&self, j: &Joint, e: &Ends, dp: [Vec3; 2], s: &mut f32, out: &mut Hard) {
        out.n = 0;
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
    fn ends(&self, j: &Joint, e: &Ends, coordinate: &mut f32, list: &mut Vec<Extra>) {
        let mut out = Extras { list };
        match &j.desc.kind {
            JointKind::Ball(d) => ball::extras(d, e, &mut out),
            JointKind::Hinge(x) => hinge::extras(x, e, coordinate, &mut out),
            JointKind::Slider(x) => slider::extras(x, e, coordinate, &mut out),
            JointKind::Spring { rest, spring, limit } => {
                distance::spring(*rest, *spring, *limit, e, &mut out);
            }
            JointKind::Wheel { suspension, spin, steer } => {
                wheel::extras([suspension, spin, steer], e, coordinate, &mut out);
            }
            JointKind::Generic { linear, angular } => {
                generic::extras(linear, angular, e, coordinate, &mut out);
            }
            JointKind::Path(p) => {
                if let Some(curve) = &j.curve {
                    let slid = path::slide(curve, e, coordinate);
                    let mut row = slid.along(slid.axis_a(0));
                    row.c = *coordinate;
                    out.axis(&p.axis, row);
                }
            }
            _ => {}
        }
    }

    /// How far the ends' coordinates will be from c + h J u, by the present velocities. Cones and twists bend: what moves along a cone's
    /// rim leaves it by half the square of its angle. So those near enough are measured where the bodies would be.
    fn bend(&mut self, j: &Joint, bodies: &[Local], k: &Constants) {
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

    /// Rows that hold, where the present velocities would take the bodies.
    fn ahead(&self, j: &Joint, a: &Motion, b: &Motion, k: &Constants) -> Hard {
        let e = Ends::predicted(&self.start, a, b, k.h);
        let mut ahead = Hard::default();
        let mut c = self.coordinate;
        self.rows(j, &e, [a.dp + a.v * k.h, b.dp + b.v * k.h], &mut c, &mut ahead);
        ahead
    }

    /// All rows anew, where the bodies are now; `first` in the step fetches the impulses that it starts from.
    fn refresh(&mut self, j: &Joint, bodies: &[Local], iterative: bool) {
        let (a, b) = (&bodies[self.a], &bodies[self.b]);
        let e = Ends::now(&self.start, &a.m, &b.m);
        let mut hard = self.hard;
        let mut slid = self.coordinate;
        self.sign = self.side(j, &e);
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
            x.ia = a.tensor.mul(x.row.ja);
            x.ib = b.tensor.mul(x.row.jb);
            let k = inverse_mass(&x.row, x.ia, x.ib, a, b);
            x.mass = if k > 0.0 { 1.0 / k } else { 0.0 };
        }
        for i in 0..self.hard.n {
            self.ia[i] = a.tensor.mul(self.hard.rows[i].ja);
            self.ib[i] = b.tensor.mul(self.hard.rows[i].jb);
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

    /// Direction along and about of a row of the direct solve on one of its bodies, and I⁻¹ times the latter.
    fn end(&self, code: u8, a: bool) -> (Vec3, Vec3, Vec3) {
        let i = usize::from(code);
        let (row, ia, ib) = if i < HARD {
            (&self.hard.rows[i], self.ia[i], self.ib[i])
        } else {
            let x = &self.extra[i - HARD];
            (&x.row, x.ia, x.ib)
        };
        if a { (row.la, row.ja, ia) } else { (row.lb, row.jb, ib) }
    }
    fn row(&self, code: u8) -> &Row {
        let i = usize::from(code);
        if i < HARD { &self.hard.rows[i] } else { &self.extra[i - HARD].row }
    }
    /// Ends and motors that the direct solve may take.
    fn taken(&self) -> usize {
        self.extra.len().min(ROWS - self.hard.n)
    }
    /// Which rows take part; those that hold first.
    fn pack(&mut self, sweep: Sweep) {
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
    fn meets_itself(&self, r: usize, c: usize, a: &Local, b: &Local) -> f64 {
        self.meets(r, true, self, c, true, a) + self.meets(r, false, self, c, false, b)
    }
    /// J_r M⁻¹ J_cᵀ over one body, of which this joint's and the other's ends are A or B.
    fn meets(&self, r: usize, a: bool, o: &Self, c: usize, oa: bool, body: &Local) -> f64 {
        let (x, y) = (&self.hard.rows[r], &o.hard.rows[c]);
        let (l, j) = if a { (x.la, x.ja) } else { (x.lb, x.jb) };
        let (ol, i) = if oa { (y.la, o.ia[c]) } else { (y.lb, o.ib[c]) };
        dot64(l.mul(body.inv_mass), ol) + dot64(j, i)
    }

    fn hold(&mut self, bodies: &mut [Local], k: &Constants, sweep: Sweep, first: bool) {
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
            self.lambda[i] = new;
        }
        for (i, change) in change[..n].iter().enumerate() {
            self.give(bodies, i, *change);
        }
    }

    /// A damper across a rod.
    fn yields(&self, row: usize) -> bool {
        self.rod && row > 0
    }

    fn give(&self, bodies: &mut [Local], i: usize, lambda: f32) {
        let row = &self.hard.rows[i];
        let a = &mut bodies[self.a];
        a.m.v += row.la.mul(a.inv_mass) * lambda;
        a.m.w += self.ia[i] * lambda;
        let b = &mut bodies[self.b];
        b.m.v += row.lb.mul(b.inv_mass) * lambda;
        b.m.w += self.ib[i] * lambda;
    }

    /// Springs, motors and ends.
    fn sweep_extra(&mut self, bodies: &mut [Local], k: &Constants, sweep: Sweep, direct: bool) {
        let taken = if direct { self.taken() } else { 0 };
        for (i, x) in self.extra.iter_mut().enumerate() {
            if i < taken && x.may_hold() {
                continue;
            }
            let v = x.row.speed(&bodies[self.a].m, &bodies[self.b].m);
            let d = push(x, v, sweep, k.h, k.push_out);
            give_extra(x, bodies, self.a, self.b, d);
        }
    }

    /// Impulses that the substep starts from.
    fn warm(&mut self, bodies: &mut [Local], k: &Constants, direct: bool) {
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
    fn account(&mut self, j: &Joint, k: &Constants, rb: Vec3) {
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

fn give_extra(x: &Extra, bodies: &mut [Local], a: usize, b: usize, d: f32) {
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

fn inverse_mass(row: &Row, ia: Vec3, ib: Vec3, a: &Local, b: &Local) -> f32 {
    row.la.dot(row.la.mul(a.inv_mass)) + row.ja.dot(ia) + row.lb.dot(row.lb.mul(b.inv_mass)) + row.jb.dot(ib)
}

fn trace(m: &Mat3) -> f32 {
    m.cx.x + m.cy.y + m.cz.z
}

fn dot64(a: Vec3, b: Vec3) -> f64 {
    f64::from(a.x) * f64::from(b.x) + f64::from(a.y) * f64::from(b.y) + f64::from(a.z) * f64::from(b.z)
}

fn limited(c: f32, most: f32) -> f32 {
    f32s::clamp(c, -most, most)
}

impl JointSet {
    /// After joints and bodies are in place: who meets whom, and whether that is solved directly.
    pub fn arrange(&mut self, joints: &Joints) {
        let size = |s: &Solve| {
            let kind = &joints.table[s.id].desc.kind;
            (row_count(kind) + extra_count(kind)).min(ROWS)
        };
        let moving =
            |i: usize| if self.bodies[i].row != NONE && self.bodies[i].moves() { i as u32 } else { u32::MAX };
        let links: Vec<(u8, [u32; 2])> =
            self.joints.iter().map(|s| (size(s) as u8, [moving(s.a), moving(s.b)])).collect();
        let any = |k: JointSolver| self.joints.iter().any(|s| joints.table[s.id].solver() == k);
        let n = self.joints.len();
        let most = if any(JointSolver::Direct) {
            FILL_ASKED * n + 64
        } else if any(JointSolver::Iterative) {
            0
        } else {
            FILL_AUTO * n + 64
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

    fn refresh(&mut self, joints: &Joints) {
        let iterative = self.plan.is_none();
        for s in &mut self.joints {
            s.refresh(&joints.table[s.id], &self.bodies, iterative);
        }
        self.fresh = false;
    }

    /// The matrix of the rows that take part, in factors.
    fn factor(&mut self) {
        let Some(plan) = &self.plan else { return };
        let pattern = |s: &Solve| s.packed[..s.count].iter().fold(0_u64, |x, &c| x | (1 << c));
        let same = self.fresh
            && self.factored.len() == self.joints.len()
            && self.factored.iter().zip(&self.joints).all(|(f, s)| *f == pattern(s));
        if same {
            return;
        }
        let n = &mut self.numbers;
        plan.clear(n, |j| self.joints[j].count);
        for &(i, k, body) in &self.shared {
            let (x, y) = (&self.joints[i as usize], &self.joints[k as usize]);
            let local = &self.bodies[body as usize];
            let (xa, ya) = (x.a == body as usize, y.a == body as usize);
            plan.add(n, i as usize, k as usize, |r, c| {
                let (l, j, _) = x.end(x.packed[r], xa);
                let (ol, _, oi) = y.end(y.packed[c], ya);
                dot64(l.mul(local.inv_mass), ol) + dot64(j, oi)
            });
        }
        for (i, s) in self.joints.iter().enumerate() {
            for (r, &code) in s.packed[..s.count].iter().enumerate() {
                let c = match usize::from(code) {
                    c if c < HARD => f64::from(s.give_way[c]),
                    c => s.extra[c - HARD].compliance(),
                };
                if c > 0.0 {
                    plan.add_diagonal(n, i, r, c);
                }
            }
        }
        plan.factor(n);
        self.factored.clear();
        self.factored.extend(self.joints.iter().map(pattern));
        self.fresh = true;
    }

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
                        Duty::Spring { .. } | Duty::Limit(LimitDesc { spring: Some(_), .. }) => false,
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
    fn residuals(&mut self, joints: &Joints, k: &Constants, sweep: Sweep, first: bool) {
        let Some(plan) = &self.plan else { return };
        for (i, s) in self.joints.iter().enumerate() {
            let (a, b) = (&self.bodies[s.a].m, &self.bodies[s.b].m);
            let ahead = if sweep != Sweep::Relax && s.soft.is_none() && s.count > 0 {
                s.ahead(&joints.table[s.id], a, b, k)
            } else {
                Hard::default()
            };
            for (r, &code) in s.packed[..s.count].iter().enumerate() {
                let row = s.row(code);
                let v = row.speed(a, b);
                let c = usize::from(code);
                let value = if c >= HARD {
                    s.extra[c - HARD].wanted(v, k, sweep)
                } else if s.yields(c) {
                    v + s.give_way[c] * s.lambda[c]
                } else if sweep == Sweep::Relax {
                    v
                } else if let Some(spring) = s.soft {
                    let inv = s.meets_itself(c, c, &self.bodies[s.a], &self.bodies[s.b]);
                    let mass = if inv > 0.0 { (1.0 / inv) as f32 } else { 0.0 };
                    let (ga, gb) = gains(&spring, mass, k.h);
                    // Once per substep.
                    if first { ga * row.c + gb * v } else { 0.0 }
                } else {
                    // Errors that a teleport left are taken back at a bounded speed.
                    let error = limited(row.c, k.correct * k.h);
                    let bend = ahead.rows[c].c - row.c - v * k.h;
                    if plan.has_loops() {
                        // Rows that say again what others say would fight about rounding for ever.
                        let most = if plan.closes_loop(i) { LOOP_SLACK } else { ROUNDING };
                        let slack = limited(error, most) + limited(bend, most);
                        v + (error + bend - slack) / k.h
                    } else {
                        (ahead.rows[c].c - (row.c - error)) / k.h
                    }
                };
                plan.set(&mut self.numbers, i, r, -f64::from(value));
            }
        }
    }

    /// Active set. Each round starts from the same velocities: rows that hold are solved for and handed out on trial; rows beyond
    /// what they can give stay at that, those that would have to act again do; until nothing changes. Errors ahead are not linear
    /// in the velocities, so those that a rejected trial leads to are never looked at.
    fn direct(&mut self, joints: &Joints, k: &Constants, sweep: Sweep, first: bool) {
        if sweep != Sweep::Relax {
            self.joints.iter_mut().for_each(|s| s.bend(&joints.table[s.id], &self.bodies, k));
        }
        self.activate(joints, k, sweep);
        self.mark();
        for round in 1..=ROUNDS {
            self.joints.iter_mut().for_each(|s| s.pack(sweep));
            self.residuals(joints, k, sweep, first);
            self.factor();
            let Some(plan) = &self.plan else { return };
            plan.solve(&mut self.numbers);
            self.hand_out();
            if round == ROUNDS || !self.correct(joints, k, sweep, round) {
                return;
            }
            self.rewind();
        }
    }

    /// Remembers where the rounds start from.
    fn mark(&mut self) {
        self.bodies.iter_mut().for_each(|b| b.before = [b.m.v, b.m.w]);
        for s in &mut self.joints {
            s.before = s.lambda;
            s.extra.iter_mut().for_each(|x| x.before = x.impulse);
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
    /// while one that is too weak stands in, an end beside it seems to pull. The last rounds let no motor in, so that they end.
    fn correct(&mut self, joints: &Joints, k: &Constants, sweep: Sweep, round: usize) -> bool {
        self.hold_back(k, |d| matches!(d, Duty::Speed { .. }))
            || self.hold_back(k, |d| matches!(d, Duty::Limit(_)))
            || (round <= ROUNDS_OF_ENDS && self.let_in(joints, k, sweep, round <= ROUNDS_OF_MOTORS))
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
            if which(&ENDS) && s.active && s.sign * s.lambda[0] < 0.0 {
                (s.lambda[0], s.active, changed) = (0.0, false, true);
            }
        }
        changed
    }

    fn let_in(&mut self, joints: &Joints, k: &Constants, sweep: Sweep, motors: bool) -> bool {
        let mut changed = false;
        for s in &mut self.joints {
            let (a, b) = (&self.bodies[s.a].m, &self.bodies[s.b].m);
            let taken = s.taken();
            for x in s.extra[..taken]
                .iter_mut()
                .filter(|x| !x.acts && x.mass > 0.0 && x.may_hold() && (motors || x.is_hard_end()))
            {
                x.acts = x.must_act(x.row.speed(a, b), k, sweep);
                changed |= x.acts;
            }
            if s.sign != 0.0 && !s.active && s.soft.is_none() && sweep != Sweep::Relax {
                s.active = s.sign * s.ahead(&joints.table[s.id], a, b, k).rows[0].c < -TOUCH;
                changed |= s.active;
            }
        }
        changed
    }

    fn hand_out(&mut self) {
        let Some(plan) = &self.plan else { return };
        self.bodies.iter_mut().for_each(|b| b.dv = [0.0; 6]);
        for (i, s) in self.joints.iter_mut().enumerate() {
            for r in 0..s.count {
                let code = s.packed[r];
                let lambda = plan.get(&self.numbers, i, r);
                let (la, _, ia) = s.end(code, true);
                let (lb, _, ib) = s.end(code, false);
                add(&mut self.bodies[s.a], la, ia, lambda);
                add(&mut self.bodies[s.b], lb, ib, lambda);
                let c = usize::from(code);
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
                m.v[i] = (f64::from(m.v[i]) + b.dv[i]) as f32;
                m.w[i] = (f64::from(m.w[i]) + b.dv[i + 3]) as f32;
            }
        }
    }

    fn gears(&mut self, k: &Constants, sweep: Sweep, warm: bool) {
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
                let bias = if sweep == Sweep::Solve { limited(0.2 * c / k.h, k.correct) } else { 0.0 };
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
                self.direct(joints, k, sweep, first && round == 0);
            } else {
                for s in &mut self.joints {
                    s.hold(&mut self.bodies, k, sweep, first && round == 0);
                }
            }
        }
    }

    /// Geometric stiffness: see the module's text.
    fn stiffen(&mut self, k: &Constants) {
        for b in &mut self.bodies {
            b.added_inertia = Mat3::ZERO;
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
                let g = k.h * r.dot(f);
                if g > 0.0 {
                    let n = r / r.length();
                    let across = Mat3::IDENTITY - Mat3::outer(n, n);
                    let b = &mut self.bodies[body];
                    b.added_inertia = b.added_inertia + across.scale(g);
                }
            }
            let (length, pull) = (e.d.length(), -s.lambda[0]);
            if s.rod && s.hard.n == 3 {
                let g = if length > 1e-6 { k.h * pull / length } else { 0.0 };
                for r in 1..3 {
                    let inv = s.meets_itself(r, r, &self.bodies[s.a], &self.bodies[s.b]) as f32;
                    // Beyond the mass that the ends have across the rod.
                    let over = if inv > 0.0 { g - 1.0 / inv } else { 0.0 };
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
    fn damp(&mut self) {
        for b in &mut self.bodies {
            if let Some(inertia) = b.inertia
                && b.added_inertia != Mat3::ZERO
            {
                b.m.w = b.tensor.mul(inertia * b.m.w);
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
        self.gears(k, Sweep::Solve, true);
        self.pass(joints, k, Sweep::Solve, true);
    }

    /// Before the positions move, after contacts.
    pub fn answer(&mut self, joints: &Joints, k: &Constants) {
        self.pass(joints, k, Sweep::Solve, false);
    }

    /// Bodies that were put elsewhere come together again, without a change of velocity: Newton's steps of C = 0, each body's share
    /// as its mass has it. Velocities of the copies are lost.
    pub fn place(&mut self, joints: &Joints) {
        let k = Constants {
            h: 1.0,
            warm: 0.0,
            soft: Softness { bias_rate: 1.0, mass_scale: 1.0, impulse_scale: 0.0 },
            push_out: f32::INFINITY,
            correct: f32::INFINITY,
        };
        let direct = self.plan.is_some();
        for _ in 0..if direct { PLACINGS } else { 4 * PLACINGS } {
            self.bodies.iter_mut().for_each(|b| (b.m.v, b.m.w) = (Vec3::ZERO, Vec3::ZERO));
            for s in &mut self.joints {
                s.lambda = [0.0; HARD];
                s.extra.iter_mut().for_each(|x| x.impulse = 0.0);
                if s.rod {
                    s.give_way[1..3].fill(f32::INFINITY);
                }
            }
            self.refresh(joints);
            if direct {
                self.direct(joints, &k, Sweep::Place, true);
            } else {
                for s in &mut self.joints {
                    s.active = true;
                    s.hold(&mut self.bodies, &k, Sweep::Place, true);
                }
            }
            for b in self.bodies.iter_mut().filter(|b| b.row != NONE) {
                b.m.dp += b.m.v;
                b.m.dq = (turned(b.m.w) * b.m.dq).normalize();
            }
        }
    }

    /// After they moved.
    pub fn relax(&mut self, joints: &Joints, k: &Constants) {
        self.stiffen(k);
        self.refresh(joints);
        self.pass(joints, k, Sweep::Relax, true);
        for s in &mut self.joints {
            let rb = self.bodies[s.b].m.dq.rotate(s.start.rb);
            s.account(&joints.table[s.id], k, rb);
        }
    }
}

impl Solve {
    /// The row of the coordinate that gears couple.
    fn main_row(&self, bodies: &[Local]) -> Row {
        let e = Ends::now(&self.start, &bodies[self.a].m, &bodies[self.b].m);
        if self.slides { e.along(e.axis_a(0)) } else { e.twist() }
    }
}

fn add(b: &mut Local, l: Vec3, i: Vec3, lambda: f64) {
    for k in 0..3 {
        b.dv[k] += f64::from(l[k]) * f64::from(b.inv_mass[k]) * lambda;
        b.dv[k + 3] += f64::from(i[k]) * lambda;
    }
}

/// Rows of a joint that hold, at most.
const HARD: usize = 6;
/// Blocks below the diagonal per joint up to which a set is solved directly by itself, and where that is asked for.
const FILL_AUTO: usize = 6;
const FILL_ASKED: usize = 64;
/// A one-sided row that held is taut as long as so little speed would close it within a substep, m/s.
const TAUT_SPEED: f32 = 0.1;
/// Rounds of the active set.
const ROUNDS: usize = 16;
/// Of these, those that let motors and friction act again, and those that let ends.
const ROUNDS_OF_MOTORS: usize = 2;
const ROUNDS_OF_ENDS: usize = 8;
/// The same of the others of its set.
const ROUNDING: f32 = 1e-6;
/// Error of a joint that closes a loop, and bend within a substep, which are let be, m or rad: rounding of f32 at some 10 m.
const LOOP_SLACK: f32 = 1e-5;
/// Newton's steps that bring bodies together again.
const PLACINGS: usize = 4;
/// How far beyond an end counts, m or rad.
pub(super) const TOUCH: f32 = 1e-6;
/// Stands for all ends.
const ENDS: Duty = Duty::Limit(LimitDesc::new(0.0, 0.0));

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
