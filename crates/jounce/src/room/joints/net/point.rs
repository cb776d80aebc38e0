//! Points alone: balls without ends, springs, motors and friction, which cannot break. Grids, flags and chains are made of them, and what
//! they take is the memory that a pass goes through: blocks hold what the point needs and nothing else, and one number for the inertia of
//! bodies that turn alike about all axes.

use super::solve::{Constants, Pass};
use super::two::{Round, Turns, Two};
use crate::room::contacts::rows::{LANES, Lane, LaneVec, Wide3};
use crate::room::joints::desc::{JointDesc, JointKind};
use crate::room::joints::lanes::{EASE, Sym, WideQuat, select3};
use crate::room::joints::parts::set_quat;
use crate::room::joints::state::Joint;
use crate::room::rigid::state::{BodyFrame, BodyState, InvInertia};
use core::ops::Range;
use jounce_lanes::{Kernel, Lanes, Mask, Width, dispatch};
use jounce_math::Vec3;
use jounce_tasks::Scatter;

/// Is the joint nothing but a point?
pub(crate) fn is_point(d: &JointDesc) -> bool {
    let JointKind::Ball(b) = &d.kind else { return false };
    let plain = b.cone.is_none() && b.twist.is_none() && b.motor.is_none() && b.friction <= 0.0;
    plain && d.break_force == f32::INFINITY && d.break_torque == f32::INFINITY
}

/// A pass takes a point's error back but for this part of its block's trace that the block is eased by, of what is left along the lever. Where that is
/// more than [`EASED`] of it, as on levers of many times what the body is long, the point needs a second pass.
const EASED: f32 = 0.01;

/// [`LANES`] joints of one colour, each field an array over them. Lanes without a joint are zero and change nothing.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct PointBlock {
    /// Levers and anchor to anchor where the bodies have been since they last moved, world axes.
    now: [LaneVec; 3],
    /// Impulse of this substep, world axes; after the last pass of a step, A's.
    impulse: LaneVec,
    inv_mass: [Lane; 2],
    /// Inverse inertia, where that is one number for both bodies of all rows.
    round: [Lane; 2],
    /// Levers as the step began, and from A to B.
    start: [LaneVec; 3],
    /// Σ over the step on B.
    force: LaneVec,
    /// Size of the force in the last substep, N.
    last: Lane,
    /// A's joint frame as the step began.
    qa: [Lane; 4],
    /// 1 where there is a second biased pass; and whether that is anywhere.
    answers: Lane,
    pub any_answers: bool,
    /// Anchors from the centres of mass, and A's joint frame: in the bodies' own axes.
    anchors: [LaneVec; 2],
    frame: [Lane; 4],
    inertia: [[Lane; 6]; 2],
    is_round: bool,
}

impl Default for PointBlock {
    fn default() -> Self {
        const V: LaneVec = LaneVec::ZERO;
        const Z: Lane = [0.0; LANES];
        Self {
            now: [V; 3],
            impulse: V,
            inv_mass: [Z; 2],
            round: [Z; 2],
            start: [V; 3],
            force: V,
            last: Z,
            qa: [Z, Z, Z, [1.0; LANES]],
            answers: Z,
            any_answers: false,
            anchors: [V; 2],
            frame: [Z, Z, Z, [1.0; LANES]],
            inertia: [[Z; 6]; 2],
            is_round: true,
        }
    }
}

/// What a step asks of the bodies of a joint, in rows that lanes load.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    /// Rotations of both.
    turns: [f32; 8],
    /// From A to B; 1 where something pushes the set.
    offset: [f32; 8],
    inertia: [&'a InvInertia; 2],
}

impl<'a> Source<'a> {
    pub const NONE: Self = Self {
        turns: [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        offset: [0.0; 8],
        inertia: [&InvInertia::FIXED; 2],
    };
    pub fn new(a: &BodyFrame, b: &BodyFrame, inertia: [&'a InvInertia; 2], pushed: bool) -> Self {
        let (p, q, d) = (a.rotation, b.rotation, (b.center - a.center).as_vec3());
        Self {
            turns: [p.x, p.y, p.z, p.w, q.x, q.y, q.z, q.w],
            offset: [d.x, d.y, d.z, f32::from(u8::from(pushed)), 0.0, 0.0, 0.0, 0.0],
            inertia,
        }
    }
}

impl PointBlock {
    /// What a joint is, in lane `l`, and the impulse that it starts from; the bodies' centres of mass in their own axes.
    pub fn describe(&mut self, l: usize, j: &Joint, centers: [Vec3; 2]) {
        self.anchors[0].set(l, j.frame_a.p - centers[0]);
        self.anchors[1].set(l, j.frame_b.p - centers[1]);
        set_quat(&mut self.frame, l % LANES, j.frame_a.q);
        self.impulse.set(l, Vec3::new(j.hard[0], j.hard[1], j.hard[2]));
    }

    /// Where the joints stand as a step starts. Impulses are those that the last step left (the records have the same).
    pub fn begin(&mut self, width: Width, sources: &[Source<'_>; LANES]) {
        self.is_round = sources.iter().all(|s| s.inertia.iter().all(|t| t.is_round()));
        self.any_answers = dispatch(width, Begin { block: self, sources });
    }

    /// Lane `l` back to the joint. The last pass has left its impulse along A's axes.
    pub fn store(&self, l: usize, j: &mut Joint, dt: f32) {
        let p = self.impulse.get(l);
        j.hard = [p.x, p.y, p.z, 0.0, 0.0, 0.0];
        j.extra.clear();
        (j.force, j.torque) = (self.force.get(l) * (1.0 / dt), Vec3::ZERO);
        j.last = [self.last[l % LANES], 0.0];
    }
}

struct Begin<'a> {
    block: &'a mut PointBlock,
    sources: &'a [Source<'a>; LANES],
}

impl Kernel for Begin<'_> {
    /// Is there a second biased pass for any?
    type Output = bool;
    #[inline(always)]
    fn run<L: Lanes>(self) -> bool {
        let Self { block, sources } = self;
        let mut any = false;
        for at in (0..LANES).step_by(L::WIDTH) {
            let q = L::gather8(
                #[inline(always)]
                |i| &sources[at + i].turns,
            );
            let o = L::gather8(
                #[inline(always)]
                |i| &sources[at + i].offset,
            );
            let (a, b) = (quat(q[0], q[1], q[2], q[3]), quat(q[4], q[5], q[6], q[7]));
            let (ra, rb) =
                (a.rotate(Wide3::load(&block.anchors[0], at)), b.rotate(Wide3::load(&block.anchors[1], at)));
            let d = Wide3::new(o[0], o[1], o[2]);
            for (to, from) in block.start.iter_mut().zip([ra, rb, d]) {
                from.store(to, at);
            }
            for (to, from) in block.now.iter_mut().zip([ra, rb, d.add(rb.sub(ra))]) {
                from.store(to, at);
            }
            let qa = a.times(WideQuat::load(&block.frame, at)).normalized();
            qa.store(&mut block.qa, at);
            qa.rotate(Wide3::load(&block.impulse, at)).store(&mut block.impulse, at);
            Wide3::new(L::zero(), L::zero(), L::zero()).store(&mut block.force, at);
            let mut give = [L::zero(); 2];
            for (side, r) in [ra, rb].into_iter().enumerate() {
                let t = L::gather8_of(
                    #[inline(always)]
                    |i| sources[at + i].inertia[side].lanes(),
                );
                t[6].store(&mut block.inv_mass[side][at..]);
                let turns = Sym { xx: t[0], yy: t[1], zz: t[2], xy: t[3], xz: t[4], yz: t[5] };
                if block.is_round {
                    t[0].store(&mut block.round[side][at..]);
                } else {
                    turns.store(&mut block.inertia[side], at);
                }
                give = [give[0] + t[6], give[1] + turns.moved_to(r).trace()];
            }
            let [along, around] = give;
            let trace = L::splat(3.0) * along + around;
            let stiff = (trace * L::splat(EASE)).gt(along * L::splat(EASED));
            let answers = o[3].gt(L::zero()) | stiff;
            any |= answers.any();
            L::select(answers, L::splat(1.0), L::zero()).store(&mut block.answers[at..]);
        }
        any
    }
}

#[inline(always)]
fn quat<L: Lanes>(x: L, y: L, z: L, w: L) -> WideQuat<L> {
    WideQuat { v: Wide3::new(x, y, z), w }
}

/// One pass over one block.
pub(crate) struct Sweep<'a, 'b> {
    pub pass: Pass,
    pub access: &'a mut Scatter<'b, BodyState>,
    pub rows: Range<usize>,
    pub block: &'a mut PointBlock,
    /// Lane of the first row.
    pub lane: usize,
    pub constants: &'a Constants,
}

/// One pass over one block, in lanes of a width.
pub(crate) fn run(width: Width, sweep: Sweep<'_, '_>) {
    if sweep.block.is_round {
        dispatch(width, Rounds(sweep));
    } else {
        dispatch(width, Others(sweep));
    }
}

// A kernel each: the compiler takes long over one that is both.
struct Rounds<'a, 'b>(Sweep<'a, 'b>);
struct Others<'a, 'b>(Sweep<'a, 'b>);

impl Sweep<'_, '_> {
    #[inline(always)]
    fn walk<L: Lanes, T: Turns<L>>(self, turns: impl Fn(&PointBlock, usize, usize) -> T) {
        let Self { pass, access, rows, block, lane, constants } = self;
        let mut done = 0;
        while done < rows.len().min(LANES) {
            let (row, at) = (rows.start + done, lane + done);
            let turns = [turns(block, 0, at), turns(block, 1, at)];
            go(pass, block, at, access, row, turns, constants);
            done += L::WIDTH;
        }
    }
}

impl Kernel for Rounds<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.0.walk(
            #[inline(always)]
            |block, side, at| Round::<L>(L::load(&block.round[side][at..])),
        );
    }
}

impl Kernel for Others<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.0.walk(
            #[inline(always)]
            |block, side, at| Sym::<L>::load(&block.inertia[side], at),
        );
    }
}

#[inline(always)]
fn go<L: Lanes, T: Turns<L>>(
    pass: Pass,
    block: &mut PointBlock,
    at: usize,
    access: &mut Scatter<'_, BodyState>,
    row: usize,
    turns: [T; 2],
    k: &Constants,
) {
    let mass = [L::load(&block.inv_mass[0][at..]), L::load(&block.inv_mass[1][at..])];
    let mut u = Two::<L, T>::load(access, row, mass, turns);
    let old = Wide3::<L>::load(&block.impulse, at);
    if matches!(pass, Pass::Relax | Pass::Last) {
        let [ra, rb, offset] = &block.start;
        let [da, _] = u.follow(access, row, [ra, rb, offset], at);
        let p = u.hold(old, k, false);
        u.calm(k);
        Wide3::load(&block.force, at).add(p).store(&mut block.force, at);
        if pass == Pass::Last {
            (p.dot(p).sqrt() * L::splat(1.0 / k.h)).store(&mut block.last[at..]);
            let back = da.times(WideQuat::load(&block.qa, at)).conjugate();
            back.rotate(p).store(&mut block.impulse, at);
        } else {
            p.store(&mut block.impulse, at);
            for (to, from) in block.now.iter_mut().zip([u.ra, u.rb, u.d]) {
                from.store(to, at);
            }
        }
    } else {
        let [ra, rb, d] = &block.now;
        u.stands([Wide3::load(ra, at), Wide3::load(rb, at), Wide3::load(d, at)]);
        if pass == Pass::Warm {
            let p = old.scale(L::splat(k.warm));
            u.push(p);
            p.store(&mut block.impulse, at);
        } else {
            let before = u;
            let p = u.hold(old, k, true);
            if pass == Pass::Answer {
                let answers = L::load(&block.answers[at..]).gt(L::zero());
                u.keep(answers, &before);
                select3(answers, p, old).store(&mut block.impulse, at);
            } else {
                p.store(&mut block.impulse, at);
            }
        }
    }
    u.store(access, row);
}
