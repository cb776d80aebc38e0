//! The passes over blocks; equations and symbols are in the text of [`super`].
//!
//! Written once over [`Lanes`]: one lane is the scalar reference, and every width gives its bits.

use super::two::{Two, bearable_turn, softness};
use super::{Block, Type};
use crate::room::contacts::prepare::Softness;
use crate::room::contacts::rows::{LANES, Wide3};
use crate::room::joints::lanes::{Sym, WideQuat, bounded, clamped, inverse};
use crate::room::rigid::state::BodyState;
use core::ops::Range;
use jounce_lanes::{Kernel, Lanes, Width, dispatch, three};
use jounce_tasks::Scatter;

/// Which pass of the substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pass {
    /// Applies the impulses of the last substep.
    Warm,
    /// With errors, springs and motors.
    Solve,
    /// The same without springs, which push once.
    Answer,
    /// Speeds alone, where the bodies have moved to; sums what the substep came to.
    Relax,
    /// The last of these in a step, which leaves impulses along A's axes, as the records have them.
    Last,
}

/// Numbers of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    pub h: f32,
    pub warm: f32,
    pub soft: Softness,
    /// Fastest way out of an end, rad/s.
    pub push_out: f32,
    /// Largest error of a point that is taken back at once, m.
    pub correct: f32,
    /// Points further apart than this are torn, m.
    pub torn: f32,
    /// Most that an impulse changes velocities and spins, m/s and rad/s, as in sets.
    pub speed_max: f32,
    pub spin_max: f32,
}

/// One pass over one block.
pub(crate) struct Sweep<'a, 'b> {
    pub pass: Pass,
    pub kind: Type,
    pub access: &'a mut Scatter<'b, BodyState>,
    pub rows: Range<usize>,
    pub block: &'a mut Block,
    /// Lane of the first row.
    pub lane: usize,
    pub constants: &'a Constants,
}

/// One pass over one block, in lanes of a width.
pub(crate) fn run(width: Width, sweep: Sweep<'_, '_>) {
    match sweep.pass {
        Pass::Warm => dispatch(width, Warm(sweep)),
        Pass::Solve | Pass::Answer => dispatch(width, Solve(sweep)),
        Pass::Relax | Pass::Last => dispatch(width, Relax(sweep)),
    }
}

impl Sweep<'_, '_> {
    /// Calls `f(pair, block, first lane)` for the rows, so many lanes at a time; with levers and frames followed to where the bodies have moved, or
    /// as they were.
    #[inline(always)]
    fn walk<L: Lanes, const FOLLOW: bool>(self, mut f: impl FnMut(&mut Pair<L>, &mut Block, usize)) {
        let Self { access, rows, block, lane, .. } = self;
        let mut done = 0;
        while done < rows.len().min(LANES) {
            let (row, at) = (rows.start + done, lane + done);
            let mut u = Pair::<L>::load::<FOLLOW>(block, at, access, row);
            f(&mut u, block, at);
            u.two.store(access, row);
            done += L::WIDTH;
        }
    }
}

// A kernel each: the compiler takes minutes over one that is all of them.
struct Warm<'a, 'b>(Sweep<'a, 'b>);
struct Solve<'a, 'b>(Sweep<'a, 'b>);
struct Relax<'a, 'b>(Sweep<'a, 'b>);

impl Kernel for Warm<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (kind, k) = (self.0.kind, self.0.constants);
        self.0.walk::<L, false>(
            #[inline(always)]
            |u, block, at| u.warm(block, at, kind, k),
        );
    }
}

impl Kernel for Solve<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (kind, k, first) = (self.0.kind, self.0.constants, self.0.pass == Pass::Solve);
        self.0.walk::<L, false>(
            #[inline(always)]
            |u, block, at| u.solve(block, at, kind, k, first),
        );
    }
}

impl Kernel for Relax<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (kind, k, last) = (self.0.kind, self.0.constants, self.0.pass == Pass::Last);
        self.0.walk::<L, true>(
            #[inline(always)]
            |u, block, at| {
                u.relax(block, at, kind, k);
                if last {
                    u.turn_back(block, at, kind);
                }
            },
        );
    }
}

/// The two bodies of a joint, and its frames.
#[derive(Clone, Copy)]
struct Pair<L> {
    two: Two<L, Sym<L>>,
    /// Joint frames.
    qa: WideQuat<L>,
    qb: WideQuat<L>,
}

/// A turn's direction, its error and how its rows are counted.
#[derive(Clone, Copy)]
struct End<L> {
    j: Wide3<L>,
    gap: L,
    mass: L,
}

impl<L: Lanes> Pair<L> {
    #[inline(always)]
    fn load<const FOLLOW: bool>(
        block: &mut Block,
        at: usize,
        access: &Scatter<'_, BodyState>,
        row: usize,
    ) -> Self {
        let mass = [L::load(&block.inv_mass[0][at..]), L::load(&block.inv_mass[1][at..])];
        let turns = [Sym::load(&block.inertia[0], at), Sym::load(&block.inertia[1], at)];
        let mut two = Two::load(access, row, mass, turns);
        if FOLLOW {
            let [da, db] = two.follow(access, row, [&block.ra, &block.rb, &block.offset], at);
            let now = &mut block.now;
            two.ra.store(&mut now.ra, at);
            two.rb.store(&mut now.rb, at);
            two.d.store(&mut now.d, at);
            da.times(WideQuat::load(&block.qa, at)).store(&mut now.qa, at);
            db.times(WideQuat::load(&block.qb, at)).store(&mut now.qb, at);
        } else {
            let now = &block.now;
            two.stands([Wide3::load(&now.ra, at), Wide3::load(&now.rb, at), Wide3::load(&now.d, at)]);
        }
        let now = &block.now;
        Self { two, qa: WideQuat::load(&now.qa, at), qb: WideQuat::load(&now.qb, at) }
    }

    /// A moment on B.
    #[inline(always)]
    fn turn(&mut self, l: Wide3<L>) {
        self.two.turn(l);
    }
    /// The part of a moment on B that changes neither body by more than a pass may.
    #[inline(always)]
    fn bearable_turn(&self, l: Wide3<L>, k: &Constants) -> L {
        let two = &self.two;
        bearable_turn(two.ta.times(l), two.tb.times(l), k)
    }
    #[inline(always)]
    fn spin(&self) -> Wide3<L> {
        self.two.wb.sub(self.two.wa)
    }
    #[inline(always)]
    fn relative(&self) -> WideQuat<L> {
        self.qa.conjugate().times(self.qb).shorter()
    }

    /// x_b stays across y_a and z_a: directions.
    #[inline(always)]
    fn hinge_axes(&self) -> [Wide3<L>; 2] {
        let x = self.qb.x();
        [x.cross(self.qa.y()), x.cross(self.qa.z())]
    }

    /// Direction of the twist.
    #[inline(always)]
    fn twist(&self) -> Wide3<L> {
        let (xa, xb) = (self.qa.x(), self.qb.x());
        let s = L::splat(1.0) + xa.dot(xb);
        let ok = s.gt(L::splat(1e-2));
        let inv = L::splat(1.0) / L::select(ok, s, L::splat(1.0));
        let sum = xa.add(xb).scale(inv);
        Wide3::new(L::select(ok, sum.x, xa.x), L::select(ok, sum.y, xa.y), L::select(ok, sum.z, xa.z))
    }

    /// Cone, and both ends of the twist; `kind` hinge has no cone.
    #[inline(always)]
    fn ends(&self, block: &Block, at: usize, kind: Type) -> [End<L>; 3] {
        let t = self.two.ta.plus(self.two.tb);
        let zero = L::zero();
        let none = End { j: Wide3::new(zero, zero, zero), gap: zero, mass: zero };
        let mut out = [none; 3];
        if kind == Type::Ball {
            let (xa, xb) = (self.qa.x(), self.qb.x());
            let (across, cos) = (xb.cross(xa), xa.dot(xb));
            let sin = across.dot(across).sqrt();
            let limit = L::load(&block.cone[at..]);
            let ok = sin.gt(L::splat(1e-5)) & limit.gt(L::splat(-1.5));
            let inv = L::select(ok, L::splat(1.0) / L::select(ok, sin, L::splat(1.0)), zero);
            let j = across.scale(inv);
            out[0] = End { j, gap: (cos - limit) * inv, mass: inverse(j.dot(t.times(j))) };
        }
        let q = self.relative();
        let n2 = q.v.x * q.v.x + q.w * q.w;
        let inv = inverse(n2.sqrt());
        let j = self.twist();
        let mass = inverse(j.dot(t.times(j)));
        for (i, end) in block.ends.iter().enumerate() {
            let [c, s] = [L::load(&end[0][at..]), L::load(&end[1][at..])];
            let sign = L::splat(if i == 0 { 1.0 } else { -1.0 });
            let there = (c * c + s * s).gt(L::splat(0.5)) & n2.gt(L::splat(1e-8));
            let gap = sign * L::splat(2.0) * (q.v.x * c - q.w * s) * inv;
            out[i + 1] = End { j: j.scale(sign), gap, mass: L::select(there, mass, zero) };
        }
        out
    }

    #[inline(always)]
    fn warm(&mut self, block: &mut Block, at: usize, kind: Type, k: &Constants) {
        let part = L::splat(k.warm);
        let p = Wide3::<L>::load(&block.point, at).scale(part);
        p.store(&mut block.point, at);
        self.two.push(p);
        let l = Wide3::<L>::load(&block.turn, at).scale(part);
        l.store(&mut block.turn, at);
        match kind {
            Type::Ball => {}
            Type::Hinge => {
                let [y, z] = self.hinge_axes();
                self.turn(y.scale(l.x).add(z.scale(l.y)));
            }
            Type::Fixed => self.turn(l),
        }
        if block.any_drive {
            let d = Wide3::<L>::load(&block.drive_impulse, at).scale(part);
            d.store(&mut block.drive_impulse, at);
            self.turn(self.qa.rotate(d));
        }
        if block.any_ends {
            let ends = self.ends(block, at, kind);
            for (impulse, end) in block.end_impulse.iter_mut().zip(ends) {
                let x = L::load(&impulse[at..]) * part;
                let x = L::select(end.mass.gt(L::zero()), x, L::zero());
                x.store(&mut impulse[at..]);
                self.turn(end.j.scale(x));
            }
        }
    }

    #[inline(always)]
    fn solve(&mut self, block: &mut Block, at: usize, kind: Type, k: &Constants, first: bool) {
        if first && block.any_pull {
            self.pull(block, at, kind, k);
        }
        if block.any_drive {
            self.drive(block, at, kind, k);
        }
        if block.any_ends {
            self.push_ends(block, at, kind, k, true);
        }
        self.hold_turns(block, at, kind, k, true);
        self.hold_point(block, at, k, true);
    }

    #[inline(always)]
    fn relax(&mut self, block: &mut Block, at: usize, kind: Type, k: &Constants) {
        if block.any_drive {
            self.drive(block, at, kind, k);
        }
        if block.any_ends {
            self.push_ends(block, at, kind, k, false);
        }
        self.hold_turns(block, at, kind, k, false);
        self.hold_point(block, at, k, false);
        self.two.calm(k);
        self.account(block, at, kind, k);
    }

    /// The spring towards a rotation.
    #[inline(always)]
    fn pull(&mut self, block: &mut Block, at: usize, kind: Type, k: &Constants) {
        let [a, b, max] = three(
            #[inline(always)]
            |i: usize| L::load(&block.pull[i][at..]),
        );
        let rest = WideQuat::load(&block.rest, at);
        let left = self.qa.conjugate().times(self.qb).times(rest.conjugate()).shorter().rotation_vector();
        let speed = Wide3::<L>::load(&block.pull_speed, at);
        let t = self.two.ta.plus(self.two.tb);
        let l = if kind == Type::Hinge {
            let j = self.twist();
            let mass = inverse(j.dot(t.times(j)));
            let x = -mass * (a * left.x + b * (j.dot(self.spin()) - speed.x));
            j.scale(clamped(x, max))
        } else {
            let c = self.qa.rotate(left);
            let v = self.spin().sub(self.qa.rotate(speed));
            let l = t.eased().solve(c.scale(-a).sub(v.scale(b)));
            // Strength about each of A's axes.
            self.qa.rotate(bounded(self.qa.conjugate().rotate(l), max))
        };
        let l = l.scale(self.bearable_turn(l, k));
        l.store(&mut block.pull_impulse, at);
        self.turn(l);
    }

    /// A motor that holds a speed, or friction.
    #[inline(always)]
    fn drive(&mut self, block: &mut Block, at: usize, kind: Type, k: &Constants) {
        let max = L::load(&block.drive[at..]);
        let speed = Wide3::<L>::load(&block.drive_speed, at);
        let old = Wide3::<L>::load(&block.drive_impulse, at);
        let t = self.two.ta.plus(self.two.tb);
        if kind == Type::Hinge {
            let j = self.twist();
            let mass = inverse(j.dot(t.times(j)));
            let new = clamped(old.x - mass * (j.dot(self.spin()) - speed.x), max);
            let change = (new - old.x) * self.bearable_turn(j.scale(new - old.x), k);
            Wide3::new(old.x + change, L::zero(), L::zero()).store(&mut block.drive_impulse, at);
            self.turn(j.scale(change));
        } else {
            let v = self.spin().sub(self.qa.rotate(speed));
            let change = self.qa.conjugate().rotate(t.eased().solve(v));
            let change = bounded(old.sub(change), max).sub(old);
            let change = change.scale(self.bearable_turn(self.qa.rotate(change), k));
            old.add(change).store(&mut block.drive_impulse, at);
            self.turn(self.qa.rotate(change));
        }
    }

    #[inline(always)]
    fn push_ends(&mut self, block: &mut Block, at: usize, kind: Type, k: &Constants, solving: bool) {
        let ends = self.ends(block, at, kind);
        let (zero, one, inv_h) = (L::zero(), L::splat(1.0), L::splat(1.0 / k.h));
        for (impulse, end) in block.end_impulse.iter_mut().zip(ends) {
            let old = L::load(&impulse[at..]);
            let v = end.j.dot(self.spin());
            let open = end.gap.gt(zero);
            let (bias, scale, fade) = if solving {
                let rate = L::splat(k.soft.mass_scale * k.soft.bias_rate);
                let back = (rate * end.gap).max(L::splat(-k.push_out));
                (
                    L::select(open, end.gap * inv_h, back),
                    L::select(open, one, L::splat(k.soft.mass_scale)),
                    L::select(open, zero, L::splat(k.soft.impulse_scale)),
                )
            } else {
                (end.gap.max(zero) * inv_h, one, zero)
            };
            let change = (old - end.mass * (scale * v + bias) - fade * old).max(zero) - old;
            let change = change * self.bearable_turn(end.j.scale(change), k);
            (old + change).store(&mut impulse[at..]);
            self.turn(end.j.scale(change));
        }
    }

    /// Rows that hold turns.
    #[inline(always)]
    fn hold_turns(&mut self, block: &mut Block, at: usize, kind: Type, k: &Constants, solving: bool) {
        let (scale, rate, fade) = softness::<L>(k, solving);
        let t = self.two.ta.plus(self.two.tb);
        match kind {
            Type::Ball => {}
            Type::Hinge => {
                let x = self.qb.x();
                let (y, z) = (self.qa.y(), self.qa.z());
                let (jy, jz) = (x.cross(y), x.cross(z));
                let (ty, tz) = (t.times(jy), t.times(jz));
                let (yy, yz, zz) = (jy.dot(ty), jy.dot(tz), jz.dot(tz));
                let ease = (yy + zz) * L::splat(1e-5);
                let (yy, zz) = (yy + ease, zz + ease);
                let inv = inverse(yy * zz - yz * yz);
                let spin = self.spin();
                let (vy, vz) = (jy.dot(spin) + rate * y.dot(x), jz.dot(spin) + rate * z.dot(x));
                let old = Wide3::<L>::load(&block.turn, at);
                let dy = -(scale * inv * (zz * vy - yz * vz)) - fade * old.x;
                let dz = -(scale * inv * (yy * vz - yz * vy)) - fade * old.y;
                let d = jy.scale(dy).add(jz.scale(dz));
                let part = self.bearable_turn(d, k);
                Wide3::new(old.x + part * dy, old.y + part * dz, L::zero()).store(&mut block.turn, at);
                self.turn(d.scale(part));
            }
            Type::Fixed => {
                let c = self.qb.times(self.qa.conjugate()).shorter().v.scale(L::splat(2.0));
                let old = Wide3::<L>::load(&block.turn, at);
                let v = self.spin().add(c.scale(rate));
                let d = t.eased().solve(v).scale(-scale).sub(old.scale(fade));
                let d = d.scale(self.bearable_turn(d, k));
                old.add(d).store(&mut block.turn, at);
                self.turn(d);
            }
        }
    }

    #[inline(always)]
    fn hold_point(&mut self, block: &mut Block, at: usize, k: &Constants, solving: bool) {
        let old = Wide3::<L>::load(&block.point, at);
        self.two.hold(old, k, solving).store(&mut block.point, at);
    }

    /// Impulses that are along the world's axes go to A's.
    #[inline(always)]
    fn turn_back(&self, block: &mut Block, at: usize, kind: Type) {
        let back = self.qa.conjugate();
        back.rotate(Wide3::load(&block.point, at)).store(&mut block.point, at);
        if kind == Type::Fixed {
            back.rotate(Wide3::load(&block.turn, at)).store(&mut block.turn, at);
        }
    }

    /// What the substep came to.
    #[inline(always)]
    fn account(&mut self, block: &mut Block, at: usize, kind: Type, k: &Constants) {
        let p = Wide3::<L>::load(&block.point, at);
        let l = Wide3::<L>::load(&block.turn, at);
        let mut moment = match kind {
            Type::Ball => l,
            Type::Hinge => {
                let [y, z] = self.hinge_axes();
                y.scale(l.x).add(z.scale(l.y))
            }
            Type::Fixed => l,
        };
        if block.any_pull {
            moment = moment.add(Wide3::load(&block.pull_impulse, at));
        }
        if block.any_drive {
            moment = moment.add(self.qa.rotate(Wide3::load(&block.drive_impulse, at)));
        }
        if block.any_ends {
            let ends = self.ends(block, at, kind);
            for (impulse, end) in block.end_impulse.iter().zip(ends) {
                moment = moment.add(end.j.scale(L::load(&impulse[at..])));
            }
        }
        Wide3::<L>::load(&block.force, at).add(p).store(&mut block.force, at);
        Wide3::<L>::load(&block.torque, at).add(moment).store(&mut block.torque, at);
        let inv_h = L::splat(1.0 / k.h);
        let mut broke = L::load(&block.broke[at..]);
        for (i, v) in [p, moment].into_iter().enumerate() {
            let now = v.dot(v).sqrt() * inv_h;
            let over = now.min(L::load(&block.last[i][at..])).gt(L::load(&block.bound[i][at..]));
            broke = L::select(over, L::splat(1.0), broke);
            now.store(&mut block.last[i][at..]);
        }
        broke.store(&mut block.broke[at..]);
    }
}
