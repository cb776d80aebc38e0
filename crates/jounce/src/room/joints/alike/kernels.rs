//! The kernels of a pass, but for the matrix.

use super::pattern::{Kind, Link};
use super::{Band, Bodies, JointLanes, NOBODY, Pass, Row};
use crate::room::contacts::rows::{LANES, Lane, LaneVec, Wide3};
use crate::room::joints::active::TAUT_SPEED;
use crate::room::joints::ball::TORN;
use crate::room::joints::lanes::{
    Sym, WideQuat, bounded, clamped, inverse, select3, turned, twice_atan, zero3,
};
use crate::room::joints::set::Constants;
use crate::room::joints::solve::TOUCH;
use crate::room::rigid::state::BodyState;
use jounce_lanes::{Kernel, Lanes, Mask, three};

/// Velocities and places of the bodies, and inertia as it is now. What contacts and forces changed came through the inertia of the
/// step's start: as momentum, I₀ Δω, it is taken over (see `room/rigid/solve.rs`).
pub(super) struct Take<'a> {
    pub band: &'a mut Band,
    pub states: &'a [BodyState],
}

impl Kernel for Take<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        for b in &mut self.band.bodies {
            for at in (0..LANES).step_by(L::WIDTH) {
                take::<L>(b, self.states, at);
            }
        }
    }
}

#[inline(always)]
fn state_of(states: &[BodyState], row: u32) -> &BodyState {
    if row == NOBODY { &BodyState::FIXED } else { &states[row as usize] }
}

#[inline(always)]
fn take<L: Lanes>(b: &mut Bodies, states: &[BodyState], at: usize) {
    let rows = b.rows;
    let hot = L::gather8(
        #[inline(always)]
        |i| &state_of(states, rows[at + i]).hot,
    );
    let motion = L::gather8(
        #[inline(always)]
        |i| &state_of(states, rows[at + i]).motion,
    );
    let v = Wide3::new(hot[0], hot[1], hot[2]);
    let w = Wide3::new(hot[3], hot[4], hot[5]);
    let q = WideQuat { v: Wide3::new(motion[4], motion[5], motion[6]), w: motion[7] };
    Wide3::new(hot[6], hot[7], motion[0]).store(&mut b.dp, at);
    Wide3::new(motion[1], motion[2], motion[3]).store(&mut b.dr, at);
    q.store(&mut b.dq, at);
    let tensor = q.turn(Sym::load(&b.inverse, at));
    tensor.store(&mut b.tensor, at);
    let known = L::load(&b.known[at..]).gt(L::zero());
    let old = Wide3::load(&b.known_w, at);
    let gain = Sym::load(&b.inertia, at).times(w.sub(old));
    let gain = select3(known, gain, zero3());
    gain.store(&mut b.gain, at);
    // Where nothing changed it stays as it is.
    let moved = gain.dot(gain).gt(L::zero());
    let w = select3(moved, old.add(tensor.times(gain)), w);
    for to in [&mut b.v, &mut b.v0] {
        v.store(to, at);
    }
    for to in [&mut b.w, &mut b.w0] {
        w.store(to, at);
    }
}

/// What the momenta gain by the pass.
pub(super) struct Gain<'a>(pub &'a mut Band);

impl Kernel for Gain<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        for b in &mut self.0.bodies {
            for at in (0..LANES).step_by(L::WIDTH) {
                let q = WideQuat::<L>::load(&b.dq, at);
                let dw = Wide3::<L>::load(&b.w, at).sub(Wide3::load(&b.w0, at));
                // I_now Δω = R I₀ Rᵀ Δω.
                let now = q.rotate(Sym::load(&b.inertia, at).times(q.conjugate().rotate(dw)));
                Wide3::load(&b.gain, at).add(now).store(&mut b.gain, at);
            }
        }
    }
}

#[inline(always)]
fn place<L: Lanes>(b: &Bodies, at: usize) -> (Wide3<L>, WideQuat<L>) {
    (Wide3::load(&b.dp, at), WideQuat::load(&b.dq, at))
}

#[inline(always)]
fn place_ahead<L: Lanes>(b: &Bodies, at: usize, h: L) -> (Wide3<L>, WideQuat<L>) {
    let (p, q) = place::<L>(b, at);
    (p.add(Wide3::load(&b.v, at).scale(h)), turned(Wide3::load(&b.w, at).scale(h), q))
}

/// Inertia as it is now, and geometric stiffness: see the text of [`crate::room::joints::set`].
pub(super) struct Stiffen<'a> {
    pub band: &'a mut Band,
    pub h: f32,
}

impl Kernel for Stiffen<'_> {
    /// Is anything stiffened?
    type Output = bool;
    #[inline(always)]
    fn run<L: Lanes>(self) -> bool {
        let Band { pattern, bodies, joints, .. } = self.band;
        let (h, zero) = (L::splat(self.h), L::zero());
        let mut any = false;
        for (body, b) in bodies.iter_mut().enumerate() {
            for at in (0..LANES).step_by(L::WIDTH) {
                let q = WideQuat::<L>::load(&b.dq, at);
                let plain = q.turn(Sym::load(&b.inverse, at));
                let own = q.turn(Sym::load(&b.inertia, at));
                let mut added = own.scale(zero);
                for &(j, is_a) in &pattern.at_body[body] {
                    let j = &joints[j as usize];
                    let [x, y, z] = three(
                        #[inline(always)]
                        |i: usize| L::load(&j.rows[i].lambda[at..]),
                    );
                    let f = Wide3::new(x, y, z).scale(L::splat(if is_a { -1.0 } else { 1.0 }));
                    let r = q.rotate(Wide3::load(if is_a { &j.ra } else { &j.rb }, at));
                    let g = h * r.dot(f);
                    let n2 = r.dot(r);
                    let pulls = g.gt(zero) & n2.gt(zero);
                    let n = r.scale(L::splat(1.0) / L::select(pulls, n2, L::splat(1.0)).sqrt());
                    added = added.plus(Sym::across(n).scale(L::select(pulls, g, zero)));
                }
                let (g, i) = (added.trace(), own.trace());
                let over = g.gt(i);
                let mut tensor = plain;
                if over.any() {
                    any = true;
                    // Only the part that explicit motion cannot stand.
                    let part = L::select(over, L::splat(1.0) - i / L::select(over, g, L::splat(1.0)), zero);
                    let raised = own.plus(added.scale(part)).inverse();
                    tensor = Sym::select(over, raised, plain);
                }
                tensor.store(&mut b.tensor, at);
                tensor.store(&mut b.raised, at);
                L::select(over, L::splat(1.0), zero).store(&mut b.stiff[at..]);
            }
        }
        any
    }
}

/// The turns of what tension added to: (I + G′) ω′ = I ω.
pub(super) struct Damp<'a>(pub &'a mut Band);

impl Kernel for Damp<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        for b in &mut self.0.bodies {
            for at in (0..LANES).step_by(L::WIDTH) {
                let q = WideQuat::<L>::load(&b.dq, at);
                let w = Wide3::<L>::load(&b.w, at);
                let own = q.turn(Sym::load(&b.inertia, at));
                let slow = Sym::load(&b.raised, at).times(own.times(w));
                let stiff = L::load(&b.stiff[at..]).gt(L::zero());
                select3(stiff, slow, w).store(&mut b.w, at);
            }
        }
    }
}

/// Two ends of a joint at some time.
#[derive(Clone, Copy)]
struct Ends<L> {
    ra: Wide3<L>,
    rb: Wide3<L>,
    qa: WideQuat<L>,
    qb: WideQuat<L>,
    d: Wide3<L>,
}

impl<L: Lanes> Ends<L> {
    #[inline(always)]
    fn new(j: &JointLanes, at: usize, a: (Wide3<L>, WideQuat<L>), b: (Wide3<L>, WideQuat<L>)) -> Self {
        let ra = a.1.rotate(Wide3::load(&j.ra, at));
        let rb = b.1.rotate(Wide3::load(&j.rb, at));
        let d = Wide3::load(&j.offset, at).add(b.0.sub(a.0)).add(rb.sub(ra));
        Self { ra, rb, qa: a.1.times(WideQuat::load(&j.qa, at)), qb: b.1.times(WideQuat::load(&j.qb, at)), d }
    }
    #[inline(always)]
    fn now(j: &JointLanes, at: usize, a: &Bodies, b: &Bodies) -> Self {
        Self::new(j, at, place(a, at), place(b, at))
    }
    /// Where free motion with the present velocities would take them in `h` seconds.
    #[inline(always)]
    fn ahead(j: &JointLanes, at: usize, a: &Bodies, b: &Bodies, h: L) -> Self {
        Self::new(j, at, place_ahead(a, at, h), place_ahead(b, at, h))
    }
    #[inline(always)]
    fn relative(&self) -> WideQuat<L> {
        self.qa.conjugate().times(self.qb).shorter()
    }
    /// Angle of the two x axes.
    #[inline(always)]
    fn cone(&self) -> (Wide3<L>, L) {
        let (xa, xb) = (self.qa.x(), self.qb.x());
        let across = xb.cross(xa);
        let s = across.dot(across).sqrt();
        let far = s.gt(L::splat(1e-6));
        let inv = L::splat(1.0) / L::select(far, s, L::splat(1.0));
        let angle = twice_atan(s, (L::splat(1.0) + xa.dot(xb)).max(L::zero()));
        (select3(far, across.scale(inv), self.qa.y()), angle)
    }
    /// Twist about x, within ±π.
    #[inline(always)]
    fn twist(&self) -> L {
        let q = self.relative();
        let n = (q.v.x * q.v.x + q.w * q.w).sqrt();
        // φ/4 = atan(x / (n + w)).
        let half = twice_atan(q.v.x.abs(), n + q.w);
        let angle = half + half;
        L::select(q.v.x.lt(L::zero()), -angle, angle)
    }
    #[inline(always)]
    fn twist_axis(&self) -> Wide3<L> {
        let (xa, xb) = (self.qa.x(), self.qb.x());
        let s = L::splat(1.0) + xa.dot(xb);
        let ok = s.gt(L::splat(1e-2));
        let inv = L::splat(1.0) / L::select(ok, s, L::splat(1.0));
        select3(ok, xa.add(xb).scale(inv), xa)
    }
    /// x_b across y_a and z_a: errors.
    #[inline(always)]
    fn across(&self) -> [L; 2] {
        let x = self.qb.x();
        [self.qa.y().dot(x), self.qa.z().dot(x)]
    }
    /// Point from which A is pulled.
    #[inline(always)]
    fn lever_a(&self) -> Wide3<L> {
        let torn = self.d.dot(self.d).gt(L::splat(TORN * TORN));
        select3(torn, self.ra, self.ra.add(self.d))
    }
}

/// All rows anew, where the bodies are now.
pub(super) struct Refresh<'a>(pub &'a mut Band);

impl Kernel for Refresh<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Band { pattern, bodies, joints, .. } = self.0;
        for (link, j) in pattern.joints.iter().zip(joints) {
            let (a, b) = (&bodies[link.a as usize], &bodies[link.b as usize]);
            for at in (0..LANES).step_by(L::WIDTH) {
                refresh::<L>(j, link.kind, a, b, at);
            }
        }
    }
}

#[inline(always)]
fn refresh<L: Lanes>(j: &mut JointLanes, kind: Kind, a: &Bodies, b: &Bodies, at: usize) {
    let e = Ends::<L>::now(j, at, a, b);
    let (ta, tb) = (Sym::<L>::load(&a.tensor, at), Sym::<L>::load(&b.tensor, at));
    let la = e.lever_a();
    for (i, c) in [e.d.x, e.d.y, e.d.z].into_iter().enumerate() {
        let ja = unit_cross(la, i).scale(L::splat(-1.0));
        put_row(&mut j.rows[i], at, ja, unit_cross(e.rb, i), c, ta, tb);
    }
    match kind {
        Kind::Ball { cone, twist } => {
            if cone {
                let (d, angle) = e.cone();
                let gap = L::load(&j.cone[at..]) - angle;
                put_turn(&mut j.rows[3], at, d, gap, ta, tb);
                L::splat(-1.0).store(&mut j.rows[3].sign[at..]);
            }
            if twist {
                put_twist(j, 3 + usize::from(cone), at, &e, ta, tb);
            }
        }
        Kind::Hinge { ends } => {
            let x = e.qb.x();
            let [c1, c2] = e.across();
            put_turn(&mut j.rows[3], at, x.cross(e.qa.y()), c1, ta, tb);
            put_turn(&mut j.rows[4], at, x.cross(e.qa.z()), c2, ta, tb);
            if ends {
                put_twist(j, 5, at, &e, ta, tb);
            }
        }
        Kind::Fixed => {
            let q = e.relative();
            let (v, w, two) = (q.v, q.w, L::splat(2.0));
            let axes = [
                (Wide3::new(w, v.z, -v.y), v.x),
                (Wide3::new(-v.z, w, v.x), v.y),
                (Wide3::new(v.y, -v.x, w), v.z),
            ];
            for (i, (axis, c)) in axes.into_iter().enumerate() {
                put_turn(&mut j.rows[3 + i], at, e.qa.rotate(axis), two * c, ta, tb);
            }
        }
    }
}

/// r × a unit vector.
#[inline(always)]
fn unit_cross<L: Lanes>(r: Wide3<L>, i: usize) -> Wide3<L> {
    let zero = L::zero();
    match i {
        0 => Wide3::new(zero, r.z, -r.y),
        1 => Wide3::new(-r.z, zero, r.x),
        _ => Wide3::new(r.y, -r.x, zero),
    }
}

#[inline(always)]
fn put_turn<L: Lanes>(row: &mut Row, at: usize, d: Wide3<L>, c: L, ta: Sym<L>, tb: Sym<L>) {
    put_row(row, at, d.scale(L::splat(-1.0)), d, c, ta, tb);
}

#[inline(always)]
fn put_twist<L: Lanes>(j: &mut JointLanes, i: usize, at: usize, e: &Ends<L>, ta: Sym<L>, tb: Sym<L>) {
    let (sign, gap) = nearer_end(j, at, e.twist());
    change_sides(&mut j.rows[i], at, sign);
    put_turn(&mut j.rows[i], at, e.twist_axis().scale(sign), gap, ta, tb);
}

/// Where the other end is the nearer one now, what this one pushed with goes.
#[inline(always)]
fn change_sides<L: Lanes>(row: &mut Row, at: usize, sign: L) {
    let same = L::load(&row.sign[at..]).eq(sign);
    sign.store(&mut row.sign[at..]);
    for x in [&mut row.lambda, &mut row.acts] {
        L::select(same, L::load(&x[at..]), L::zero()).store(&mut x[at..]);
    }
}

/// +1 for the lower and −1 for the upper end, and the gap to it.
#[inline(always)]
fn nearer_end<L: Lanes>(j: &JointLanes, at: usize, angle: L) -> (L, L) {
    let (low, high) = (angle - L::load(&j.twist[0][at..]), L::load(&j.twist[1][at..]) - angle);
    let lower = low.lt(high);
    (L::select(lower, L::splat(1.0), L::splat(-1.0)), L::select(lower, low, high))
}

#[inline(always)]
fn put_row<L: Lanes>(row: &mut Row, at: usize, ja: Wide3<L>, jb: Wide3<L>, c: L, ta: Sym<L>, tb: Sym<L>) {
    ja.store(&mut row.ja, at);
    jb.store(&mut row.jb, at);
    ta.times(ja).store(&mut row.ia, at);
    tb.times(jb).store(&mut row.ib, at);
    c.store(&mut row.c[at..]);
}

/// Right sides, and who acts at first.
pub(super) struct Aim<'a> {
    pub band: &'a mut Band,
    pub pass: Pass,
    pub k: &'a Constants,
}

impl Kernel for Aim<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Band { pattern, bodies, joints, live, .. } = self.band;
        for (link, j) in pattern.joints.iter().zip(joints) {
            let (a, b) = (&bodies[link.a as usize], &bodies[link.b as usize]);
            for at in (0..LANES).step_by(L::WIDTH) {
                let live = L::load(&live[at..]);
                aim::<L>(j, link.kind, [a, b], at, live, self.pass, self.k);
            }
        }
    }
}

#[inline(always)]
fn aim<L: Lanes>(
    j: &mut JointLanes,
    kind: Kind,
    [a, b]: [&Bodies; 2],
    at: usize,
    live: L,
    pass: Pass,
    k: &Constants,
) {
    let (holds, ends) = kind.turns();
    let first_end = 3 + holds;
    let (h, inv_h, zero) = (L::splat(k.h), L::splat(1.0 / k.h), L::zero());
    let most = L::splat(k.correct * k.h);
    let mut next = [zero; 6];
    if pass.looks_ahead() {
        let e = Ends::<L>::ahead(j, at, a, b, h);
        (next[0], next[1], next[2]) = (e.d.x, e.d.y, e.d.z);
        match kind {
            Kind::Ball { cone, twist } => {
                if cone {
                    next[3] = L::load(&j.cone[at..]) - e.cone().1;
                }
                if twist {
                    let i = 3 + usize::from(cone);
                    next[i] = end_ahead(j, i, at, e.twist());
                }
            }
            Kind::Hinge { ends } => {
                [next[3], next[4]] = e.across();
                if ends {
                    next[5] = end_ahead(j, 5, at, e.twist());
                }
            }
            Kind::Fixed => {
                let q = e.relative();
                (next[3], next[4], next[5]) = (q.v.x + q.v.x, q.v.y + q.v.y, q.v.z + q.v.z);
            }
        }
    }
    let speeds = Speeds::<L>::now(a, b, at);
    for i in 0..first_end + ends {
        let row = &mut j.rows[i];
        let lambda = L::load(&row.lambda[at..]);
        lambda.store(&mut row.before[at..]);
        let v = speeds.along(row, i, at);
        let c = L::load(&row.c[at..]);
        let end = i >= first_end;
        let curve = if pass.looks_ahead() { next[i] - c - h * v } else { zero };
        curve.store(&mut row.curve[at..]);
        let bend = match pass {
            Pass::Relax => zero,
            Pass::Place => c,
            // Errors that a teleport left are taken back at a bounded speed.
            _ if !end => (clamped(c, most) + curve) * inv_h,
            _ => clamped(curve, most) * inv_h + (c * inv_h).max(L::splat(-k.push_out)),
        };
        bend.store(&mut row.bend[at..]);
        if !end {
            continue;
        }
        let pushed = !lambda.eq(zero);
        let acted = L::load(&row.acts[at..]).gt(zero);
        let acts = match pass {
            Pass::Relax => pushed | (c + h * v).lt(zero),
            Pass::Place => c.lt(L::splat(-TOUCH)),
            _ => {
                let taut = acted & c.lt(L::splat(TAUT_SPEED) * h);
                pushed | taut | ((v + bend) * h).lt(L::splat(-TOUCH))
            }
        };
        let acts = L::select(acts, L::splat(1.0), zero);
        L::select(live.gt(zero), acts, L::load(&row.acts[at..])).store(&mut row.acts[at..]);
    }
}

/// Gap to the end that is the nearer one now, at another angle, the shorter way.
#[inline(always)]
fn end_ahead<L: Lanes>(j: &JointLanes, i: usize, at: usize, angle: L) -> L {
    let sign = L::load(&j.rows[i].sign[at..]);
    let end = L::select(sign.gt(L::zero()), L::load(&j.twist[0][at..]), L::load(&j.twist[1][at..]));
    let gap = sign * (angle - end);
    let way = gap - L::load(&j.rows[i].c[at..]);
    let (pi, turn) = (core::f32::consts::PI, L::splat(core::f32::consts::TAU));
    let gap = L::select(way.gt(L::splat(pi)), gap - turn, gap);
    L::select(way.lt(L::splat(-pi)), gap + turn, gap)
}

/// Springs (once per substep), and motors of a velocity and friction.
pub(super) struct Push<'a> {
    pub band: &'a mut Band,
    /// Impulses of the last substep are given first, and springs push.
    pub first: bool,
    pub warm: f32,
}

impl Kernel for Push<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Band { pattern, bodies, joints, any_pull, any_drive, live, .. } = self.band;
        for at in (0..LANES).step_by(L::WIDTH) {
            let live = L::load(&live[at..]).gt(L::zero());
            if self.first && *any_drive {
                for (link, j) in pattern.joints.iter().zip(joints.iter_mut()) {
                    let pair = Pair::<L>::load(j, at, bodies, link.a, link.b);
                    let old = Wide3::<L>::load(&j.drive_impulse, at).scale(L::splat(self.warm));
                    old.store(&mut j.drive_impulse, at);
                    pair.turn(bodies, at, live, pair.e.qa.rotate(old));
                }
            }
            for (link, j) in pattern.joints.iter().zip(joints.iter_mut()) {
                if link.kind == Kind::Fixed {
                    continue;
                }
                let hinge = matches!(link.kind, Kind::Hinge { .. });
                if self.first && *any_pull {
                    let pair = Pair::<L>::load(j, at, bodies, link.a, link.b);
                    let l = pair.pull(j, at, hinge);
                    l.store(&mut j.pull_impulse, at);
                    pair.turn(bodies, at, live, l);
                }
                if *any_drive {
                    let pair = Pair::<L>::load(j, at, bodies, link.a, link.b);
                    let l = pair.drive(j, at, hinge, live);
                    pair.turn(bodies, at, live, l);
                }
            }
        }
    }
}

/// What turns of a joint are about.
struct Pair<L> {
    a: usize,
    b: usize,
    ta: Sym<L>,
    tb: Sym<L>,
    e: Ends<L>,
    spin: Wide3<L>,
}

impl<L: Lanes> Pair<L> {
    #[inline(always)]
    fn load(j: &JointLanes, at: usize, bodies: &[Bodies], a: u16, b: u16) -> Self {
        let (a, b) = (a as usize, b as usize);
        let (x, y) = (&bodies[a], &bodies[b]);
        Self {
            a,
            b,
            ta: Sym::load(&x.tensor, at),
            tb: Sym::load(&y.tensor, at),
            e: Ends::now(j, at, x, y),
            spin: Wide3::load(&y.w, at).sub(Wide3::load(&x.w, at)),
        }
    }
    /// A moment on B.
    #[inline(always)]
    fn turn(&self, bodies: &mut [Bodies], at: usize, live: L::Mask, l: Wide3<L>) {
        let l = select3(live, l, zero3());
        let a = &mut bodies[self.a].w;
        Wide3::load(a, at).sub(self.ta.times(l)).store(a, at);
        let b = &mut bodies[self.b].w;
        Wide3::load(b, at).add(self.tb.times(l)).store(b, at);
    }
    #[inline(always)]
    fn mass_about(&self, j: Wide3<L>) -> L {
        inverse(j.dot(self.ta.plus(self.tb).times(j)))
    }
    /// The spring towards a rotation: λ = −M (a C + b (ω − ω₀)), C the rotation vector that is left.
    #[inline(always)]
    fn pull(&self, j: &JointLanes, at: usize, hinge: bool) -> Wide3<L> {
        let [a, b, max] = three(
            #[inline(always)]
            |i: usize| L::load(&j.pull[i][at..]),
        );
        let rest = WideQuat::load(&j.rest, at);
        let e = &self.e;
        let left = e.qa.conjugate().times(e.qb).times(rest.conjugate()).shorter().rotation_vector();
        let speed = Wide3::<L>::load(&j.pull_speed, at);
        if hinge {
            let axis = e.twist_axis();
            let x = -self.mass_about(axis) * (a * left.x + b * (axis.dot(self.spin) - speed.x));
            return axis.scale(clamped(x, max));
        }
        let c = e.qa.rotate(left);
        let v = self.spin.sub(e.qa.rotate(speed));
        let l = self.ta.plus(self.tb).solve(c.scale(-a).sub(v.scale(b)));
        // Strength about each of A's axes.
        e.qa.rotate(bounded(e.qa.conjugate().rotate(l), max))
    }
    /// A motor that holds a speed, or friction: what it adds now.
    #[inline(always)]
    fn drive(&self, j: &mut JointLanes, at: usize, hinge: bool, live: L::Mask) -> Wide3<L> {
        let max = L::load(&j.drive[at..]);
        let speed = Wide3::<L>::load(&j.drive_speed, at);
        let old = Wide3::<L>::load(&j.drive_impulse, at);
        let e = &self.e;
        if hinge {
            let axis = e.twist_axis();
            let change = self.mass_about(axis) * (axis.dot(self.spin) - speed.x);
            let new = L::select(live, clamped(old.x - change, max), old.x);
            Wide3::new(new, L::zero(), L::zero()).store(&mut j.drive_impulse, at);
            return axis.scale(new - old.x);
        }
        let v = self.spin.sub(e.qa.rotate(speed));
        let change = e.qa.conjugate().rotate(self.ta.plus(self.tb).solve(v));
        let new = select3(live, bounded(old.sub(change), max), old);
        new.store(&mut j.drive_impulse, at);
        e.qa.rotate(new.sub(old))
    }
}

/// A round of the active set: λ, and who acts after all. Lanes that change nothing any more are done.
pub(super) struct Try<'a> {
    pub band: &'a mut Band,
    pub pass: Pass,
    pub k: &'a Constants,
    /// Ends may be let in.
    pub lets_in: bool,
    /// What comes out stands.
    pub last: bool,
}

impl Kernel for Try<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        for at in (0..LANES).step_by(L::WIDTH) {
            try_rows::<L>(self.band, at, self.pass, self.k, self.lets_in, self.last);
        }
    }
}

/// Velocities of a joint's two bodies.
#[derive(Clone, Copy)]
struct Speeds<L> {
    va: Wide3<L>,
    wa: Wide3<L>,
    vb: Wide3<L>,
    wb: Wide3<L>,
}

impl<L: Lanes> Speeds<L> {
    #[inline(always)]
    fn now(a: &Bodies, b: &Bodies, at: usize) -> Self {
        let load = |v: &LaneVec| Wide3::load(v, at);
        Self { va: load(&a.v), wa: load(&a.w), vb: load(&b.v), wb: load(&b.w) }
    }
    /// Those on trial.
    #[inline(always)]
    fn tried(a: &Bodies, b: &Bodies, at: usize) -> Self {
        let load = |v: &LaneVec| Wide3::load(v, at);
        Self { va: load(&a.try_v), wa: load(&a.try_w), vb: load(&b.try_v), wb: load(&b.try_w) }
    }
    /// J u of a row; `i` < 3 are the point's.
    #[inline(always)]
    fn along(&self, row: &Row, i: usize, at: usize) -> L {
        let turns = Wide3::load(&row.ja, at).dot(self.wa) + Wide3::load(&row.jb, at).dot(self.wb);
        match i {
            0 => self.vb.x - self.va.x + turns,
            1 => self.vb.y - self.va.y + turns,
            2 => self.vb.z - self.va.z + turns,
            _ => turns,
        }
    }
    /// M⁻¹ Jᵀ x of a row; `m`: inverse masses.
    #[inline(always)]
    fn give(&mut self, row: &Row, i: usize, at: usize, m: [L; 2], x: L) {
        self.wa = self.wa.add(Wide3::load(&row.ia, at).scale(x));
        self.wb = self.wb.add(Wide3::load(&row.ib, at).scale(x));
        let (a, b) = (m[0] * x, m[1] * x);
        match i {
            0 => (self.va.x, self.vb.x) = (self.va.x - a, self.vb.x + b),
            1 => (self.va.y, self.vb.y) = (self.va.y - a, self.vb.y + b),
            2 => (self.va.z, self.vb.z) = (self.va.z - a, self.vb.z + b),
            _ => {}
        }
    }
    /// To the trial.
    #[inline(always)]
    fn try_on(&self, bodies: &mut [Bodies], link: &Link, at: usize) {
        let a = &mut bodies[link.a as usize];
        self.va.store(&mut a.try_v, at);
        self.wa.store(&mut a.try_w, at);
        let b = &mut bodies[link.b as usize];
        self.vb.store(&mut b.try_v, at);
        self.wb.store(&mut b.try_w, at);
    }
}

#[inline(always)]
fn inv_masses<L: Lanes>(bodies: &[Bodies], link: &Link, at: usize) -> [L; 2] {
    [link.a, link.b].map(
        #[inline(always)]
        |i| L::load(&bodies[i as usize].inv_mass[at..]),
    )
}

/// The trial begins where the bodies are; ends that pushed and no longer do take back what they gave.
#[inline(always)]
fn start<L: Lanes>(band: &mut Band, at: usize) {
    let zero = L::zero();
    let Band { pattern, bodies, joints, .. } = band;
    for b in bodies.iter_mut() {
        Wide3::<L>::load(&b.v, at).store(&mut b.try_v, at);
        Wide3::<L>::load(&b.w, at).store(&mut b.try_w, at);
    }
    for (link, j) in pattern.joints.iter().zip(joints.iter()) {
        for i in link.kind.first_end()..link.kind.rows() {
            let row = &j.rows[i];
            let idle = L::load(&row.acts[at..]).eq(zero);
            let back = L::select(idle, -L::load(&row.before[at..]), zero);
            if !back.eq(zero).all() {
                let [a, b] = [link.a, link.b].map(|i| &bodies[i as usize]);
                let mut speeds = Speeds::<L>::tried(a, b, at);
                speeds.give(row, i, at, inv_masses(bodies, link, at), back);
                speeds.try_on(bodies, link, at);
            }
        }
    }
}

/// The impulses in `x`.
#[inline(always)]
fn give_all<L: Lanes>(band: &mut Band, at: usize) {
    let Band { pattern, bodies, joints, used, .. } = band;
    for ((link, j), used) in pattern.joints.iter().zip(joints.iter()).zip(&*used) {
        let m = inv_masses(bodies, link, at);
        let mut speeds = Speeds::<L>::tried(&bodies[link.a as usize], &bodies[link.b as usize], at);
        for (i, row) in j.rows.iter().enumerate().take(usize::from(used[at % LANES])) {
            speeds.give(row, i, at, m, L::load(&row.x[at..]));
        }
        speeds.try_on(bodies, link, at);
    }
}

/// Nearly as far as a body may be taken, so that [`bearable`] is to be asked exactly.
const NEARLY: f32 = 0.99;

/// Does the trial of these lanes take some body that far from where the pass began, or to where nothing is finite?
#[inline(always)]
fn far<L: Lanes>(bodies: &[Bodies], at: usize, live: L::Mask, k: &Constants) -> bool {
    let [speed, spin] = [k.speed_max, k.spin_max].map(|most| L::splat(NEARLY * NEARLY * most * most));
    bodies.iter().any(|b| {
        let taken = |new: &LaneVec, old: &LaneVec| Wide3::<L>::load(new, at).sub(Wide3::load(old, at));
        let (dv, dw) = (taken(&b.try_v, &b.v), taken(&b.try_w, &b.w));
        (live & !(dv.dot(dv).lt(speed) & dw.dot(dw).lt(spin))).any()
    })
}

#[inline(always)]
fn try_rows<L: Lanes>(band: &mut Band, at: usize, pass: Pass, k: &Constants, lets_in: bool, last: bool) {
    let (zero, one, h) = (L::zero(), L::splat(1.0), L::splat(k.h));
    let live = L::load(&band.live[at..]).gt(zero);
    if !live.any() {
        return;
    }
    start::<L>(band, at);
    let Band { pattern, bodies, joints, used, .. } = band;
    // Rows that take part in none of these lanes have nothing to solve.
    for ((link, j), used) in pattern.joints.iter().zip(joints.iter_mut()).zip(&*used) {
        let speeds = Speeds::<L>::tried(&bodies[link.a as usize], &bodies[link.b as usize], at);
        for (i, row) in j.rows.iter_mut().enumerate().take(usize::from(used[at % LANES])) {
            let r = -(speeds.along(row, i, at) + L::load(&row.bend[at..]));
            L::select(L::load(&row.acts[at..]).gt(zero), r, zero).store(&mut row.x[at..]);
        }
    }
    super::matrix::solve::<L>(band, at);
    give_all::<L>(band, at);
    if far::<L>(&band.bodies, at, live, k) {
        // Once more: how much of it the bodies can bear.
        start::<L>(band, at);
        let Band { pattern, bodies, joints, used, .. } = &mut *band;
        let part = bearable::<L>(pattern, bodies, joints, used, at, k);
        for row in joints.iter_mut().flat_map(|j| &mut j.rows) {
            let x = L::load(&row.x[at..]) * part;
            // Nothing at all where something is not finite: no product of that with 0.
            L::select(part.gt(zero), x, zero).store(&mut row.x[at..]);
        }
        give_all::<L>(band, at);
    }
    let Band { pattern, bodies, joints, .. } = band;
    // Who pulls is let go; where nobody does, who is passed is let in.
    let mut held = zero;
    for (link, j) in pattern.joints.iter().zip(joints.iter_mut()) {
        for row in &mut j.rows[link.kind.first_end()..link.kind.rows()] {
            let acts = L::load(&row.acts[at..]);
            let total = L::load(&row.before[at..]) + L::load(&row.x[at..]);
            let pulls = live & acts.gt(zero) & total.lt(zero);
            if !last {
                L::select(pulls, zero, acts).store(&mut row.acts[at..]);
                held = L::select(pulls, one, held);
            }
        }
    }
    let mut changed = held;
    if lets_in && !last {
        let may = live & held.eq(zero);
        for (link, j) in pattern.joints.iter().zip(joints.iter_mut()) {
            let speeds = Speeds::<L>::tried(&bodies[link.a as usize], &bodies[link.b as usize], at);
            for i in link.kind.first_end()..link.kind.rows() {
                let row = &mut j.rows[i];
                let acts = L::load(&row.acts[at..]);
                let v = speeds.along(row, i, at);
                let passed = if pass == Pass::Relax {
                    L::load(&row.c[at..]).max(zero) + h * v
                } else {
                    (v + L::load(&row.bend[at..])) * h
                };
                let must = may & acts.eq(zero) & passed.lt(L::splat(-TOUCH));
                L::select(must, one, acts).store(&mut row.acts[at..]);
                changed = L::select(must, one, changed);
            }
        }
    }
    let done = live & changed.eq(zero);
    for b in bodies.iter_mut() {
        let (v, w) = (Wide3::<L>::load(&b.try_v, at), Wide3::<L>::load(&b.try_w, at));
        select3(done, v, Wide3::load(&b.v, at)).store(&mut b.v, at);
        select3(done, w, Wide3::load(&b.w, at)).store(&mut b.w, at);
    }
    for (link, j) in pattern.joints.iter().zip(joints.iter_mut()) {
        for row in &mut j.rows[..link.kind.rows()] {
            let acts = L::load(&row.acts[at..]).gt(zero);
            let total = L::load(&row.before[at..]) + L::load(&row.x[at..]);
            let new = L::select(acts, total, zero);
            L::select(done, new, L::load(&row.lambda[at..])).store(&mut row.lambda[at..]);
        }
    }
    L::select(done, zero, L::load(&band.live[at..])).store(&mut band.live[at..]);
}

/// The part of the impulses in `x` that takes no body further from where the pass began than it may. (What was taken back may be more.)
#[inline(always)]
fn bearable<L: Lanes>(
    pattern: &super::Pattern,
    bodies: &mut [Bodies],
    joints: &[JointLanes],
    used: &[[u8; LANES]],
    at: usize,
    k: &Constants,
) -> L {
    let (mut over, mut finite) = (L::zero(), L::zero());
    let (speed, spin) = (L::splat(1.0 / k.speed_max), L::splat(1.0 / k.spin_max));
    for body in 0..bodies.len() {
        let (mut dv, mut dw) = (zero3::<L>(), zero3::<L>());
        for &(j, is_a) in &pattern.at_body[body] {
            let (joint, used) = (&joints[j as usize], used[j as usize][at % LANES]);
            for (i, row) in joint.rows.iter().enumerate().take(usize::from(used)) {
                let x = L::load(&row.x[at..]);
                let inv = if is_a { &row.ia } else { &row.ib };
                dw = dw.add(Wide3::load(inv, at).scale(x));
                let x = if is_a { -x } else { x };
                match i {
                    0 => dv.x = dv.x + x,
                    1 => dv.y = dv.y + x,
                    2 => dv.z = dv.z + x,
                    _ => {}
                }
            }
        }
        let b = &bodies[body];
        let taken = |new: &LaneVec, old: &LaneVec| Wide3::<L>::load(new, at).sub(Wide3::load(old, at));
        let dv = dv.scale(L::load(&b.inv_mass[at..])).add(taken(&b.try_v, &b.v));
        let dw = dw.add(taken(&b.try_w, &b.w));
        let (v2, w2) = (dv.dot(dv), dw.dot(dw));
        over = over.max(v2.sqrt() * speed).max(w2.sqrt() * spin);
        finite = finite + (v2 + w2) * L::zero();
    }
    let one = L::splat(1.0);
    let part = L::select(over.gt(one), one / over.max(one), one);
    // What is not finite is not given.
    L::select(finite.eq(L::zero()), part, L::zero())
}

/// Velocities as ways: bodies are where they lead. The farthest goes to `way`.
pub(super) struct Move<'a> {
    pub band: &'a mut Band,
    pub way: &'a mut Lane,
}

impl Kernel for Move<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        for at in (0..LANES).step_by(L::WIDTH) {
            let mut way = L::zero();
            for b in &mut self.band.bodies {
                let (v, w) = (Wide3::<L>::load(&b.v, at), Wide3::<L>::load(&b.w, at));
                Wide3::load(&b.dp, at).add(v).store(&mut b.dp, at);
                Wide3::load(&b.dr, at).add(w).store(&mut b.dr, at);
                let moves = w.dot(w).gt(L::zero());
                let q = WideQuat::<L>::load(&b.dq, at);
                let t = turned(w, q).normalized();
                let q = WideQuat { v: select3(moves, t.v, q.v), w: L::select(moves, t.w, q.w) };
                q.store(&mut b.dq, at);
                way = way.max(v.dot(v)).max(w.dot(w));
            }
            way.store(&mut self.way[at..]);
        }
    }
}

/// Angular momentum about the centre of mass: kept before places are put right; after it, in the lanes in which they were, given back
/// as a rigid turn, which no joint notices.
pub(super) struct Spin<'a> {
    pub band: &'a mut Band,
    /// 1 in the lanes that are given back; none: keep.
    pub back: Option<&'a Lane>,
}

impl Kernel for Spin<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Band { bodies, angular, .. } = self.band;
        for at in (0..LANES).step_by(L::WIDTH) {
            let (mut mass, mut centre, mut p) = (L::zero(), zero3::<L>(), zero3::<L>());
            for b in bodies.iter() {
                let m = inverse(L::load(&b.inv_mass[at..]));
                mass = mass + m;
                centre = centre.add(Wide3::load(&b.at, at).add(Wide3::load(&b.dp, at)).scale(m));
                p = p.add(Wide3::load(&b.v, at).scale(m));
            }
            let inv = inverse(mass);
            let (centre, mean) = (centre.scale(inv), p.scale(inv));
            let mut l = zero3::<L>();
            let mut whole = Sym::across(zero3::<L>()).scale(L::zero());
            for b in bodies.iter() {
                let m = inverse(L::load(&b.inv_mass[at..]));
                let r = Wide3::load(&b.at, at).add(Wide3::load(&b.dp, at)).sub(centre);
                let own = WideQuat::load(&b.dq, at).turn(Sym::load(&b.inertia, at));
                let moving = r.cross(Wide3::load(&b.v, at).sub(mean)).scale(m);
                l = l.add(moving).add(own.times(Wide3::load(&b.w, at)));
                whole = whole.plus(own).plus(Sym::around(r).scale(m));
            }
            let Some(back) = self.back else {
                l.store(angular, at);
                continue;
            };
            let turn = whole.solve(Wide3::load(angular, at).sub(l));
            let turn = select3(L::load(&back[at..]).gt(L::zero()), turn, zero3());
            for b in bodies.iter_mut() {
                let r = Wide3::load(&b.at, at).add(Wide3::load(&b.dp, at)).sub(centre);
                Wide3::load(&b.v, at).add(turn.cross(r)).store(&mut b.v, at);
                Wide3::load(&b.w, at).add(turn).store(&mut b.w, at);
            }
        }
    }
}

/// What the substep came to.
pub(super) struct Account<'a> {
    pub band: &'a mut Band,
    pub h: f32,
}

impl Kernel for Account<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Band { pattern, bodies, joints, any_pull, any_drive, .. } = self.band;
        for (link, j) in pattern.joints.iter().zip(joints) {
            for at in (0..LANES).step_by(L::WIDTH) {
                let [x, y, z] = three(
                    #[inline(always)]
                    |i: usize| L::load(&j.rows[i].lambda[at..]),
                );
                let p = Wide3::new(x, y, z);
                let mut moment = zero3::<L>();
                for row in &j.rows[3..link.kind.rows()] {
                    let x = L::load(&row.lambda[at..]);
                    moment = moment.add(Wide3::load(&row.jb, at).scale(x));
                }
                if *any_pull {
                    moment = moment.add(Wide3::load(&j.pull_impulse, at));
                }
                if *any_drive {
                    let a = &bodies[link.a as usize];
                    let qa = WideQuat::load(&a.dq, at).times(WideQuat::load(&j.qa, at));
                    let drive = Wide3::load(&j.drive_impulse, at);
                    let hinge = matches!(link.kind, Kind::Hinge { .. });
                    moment = moment.add(if hinge { qa.x().scale(drive.x) } else { qa.rotate(drive) });
                }
                Wide3::<L>::load(&j.force, at).add(p).store(&mut j.force, at);
                Wide3::<L>::load(&j.torque, at).add(moment).store(&mut j.torque, at);
                let inv_h = L::splat(1.0 / self.h);
                let mut broke = L::load(&j.broke[at..]);
                for (i, v) in [p, moment].into_iter().enumerate() {
                    let now = v.dot(v).sqrt() * inv_h;
                    let over = now.min(L::load(&j.last[i][at..])).gt(L::load(&j.bound[i][at..]));
                    broke = L::select(over, L::splat(1.0), broke);
                    now.store(&mut j.last[i][at..]);
                }
                broke.store(&mut j.broke[at..]);
            }
        }
    }
}
