//! What sets that are alike have in common.

use super::super::desc::{AxisDesc, JointDesc, JointKind, JointSolver, MotorTarget, SpringDesc};
use super::super::direct::{Plan, Step};

/// What a joint is, and which ends it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Ball { cone: bool, twist: bool },
    Hinge { ends: bool },
    Fixed,
}

impl Kind {
    /// The kind of a joint all of whose parts the kernels know; `h`: the substep, s.
    pub fn of(d: &JointDesc, h: f32) -> Option<Self> {
        if d.solver == JointSolver::Auto { Self::known(d, h) } else { None }
    }
    /// The same whatever solver is asked for.
    pub fn known(d: &JointDesc, h: f32) -> Option<Self> {
        if d.softness.is_some() {
            return None;
        }
        let gentle = |s: &SpringDesc| match *s {
            SpringDesc::Hertz { hertz, .. } => hertz * h < GENTLE,
            SpringDesc::Newton { .. } => false,
        };
        match &d.kind {
            JointKind::Fixed => Some(Self::Fixed),
            JointKind::Ball(b) => {
                let twist = b.twist.is_none_or(|t| {
                    t.spring.is_none()
                        && !t.holds_still()
                        && t.min.abs() <= HALF_TURN
                        && t.max.abs() <= HALF_TURN
                        && !b.may_point_apart()
                });
                let driven = b.motor.as_ref().is_some_and(|m| m.rotation.is_none());
                let pulled = b.motor.as_ref().is_none_or(|m| m.rotation.is_none() || gentle(&m.spring));
                let one = !(driven && b.friction > 0.0);
                let known = b.cone_spring.is_none() && twist && pulled && one;
                known.then_some(Self::Ball { cone: b.cone.is_some(), twist: b.twist.is_some() })
            }
            JointKind::Hinge(a) => is_plain(a, gentle).then_some(Self::Hinge { ends: a.limit.is_some() }),
            _ => None,
        }
    }
    /// Rows of turns that hold, then ends.
    #[inline(always)]
    pub(super) fn turns(self) -> (usize, usize) {
        match self {
            Self::Ball { cone, twist } => (0, usize::from(cone) + usize::from(twist)),
            Self::Hinge { ends } => (2, usize::from(ends)),
            Self::Fixed => (3, 0),
        }
    }
    #[inline(always)]
    pub(super) fn rows(self) -> usize {
        let (hold, ends) = self.turns();
        3 + hold + ends
    }
    /// Rows from here on are ends.
    #[inline(always)]
    pub(super) fn first_end(self) -> usize {
        3 + self.turns().0
    }
}

/// One pull, one drive, and ends within half a turn, where the angle is the angle whatever it was before.
fn is_plain(a: &AxisDesc, gentle: impl Fn(&SpringDesc) -> bool) -> bool {
    let within = |x: f32| x.abs() <= HALF_TURN;
    let ends =
        a.limit.is_none_or(|l| l.spring.is_none() && !l.holds_still() && within(l.min) && within(l.max));
    let mut pulls = u32::from(a.spring.is_some());
    let mut drives = u32::from(a.friction > 0.0);
    let mut known = a.spring.is_none_or(|(rest, s)| within(rest) && gentle(&s));
    match a.motor.map(|m| m.target) {
        Some(MotorTarget::Velocity(_)) => drives += 1,
        Some(MotorTarget::Position { position, spring, .. }) => {
            pulls += 1;
            known &= within(position) && gentle(&spring);
        }
        None => {}
    }
    // Without ends it may have turned many times.
    let counted = pulls == 0 || a.limit.is_some();
    !a.locked && ends && known && counted && pulls <= 1 && drives <= 1
}

/// Hertz times substep up to which a spring pushes once per substep.
const GENTLE: f32 = 0.07;
/// Angles up to here are told apart from those of other turns, rad.
const HALF_TURN: f32 = 3.0;

/// A joint of the pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Link {
    pub kind: Kind,
    /// Bodies of the set.
    pub a: u16,
    pub b: u16,
}

/// Two joints on one body: a block of the matrix gets J M⁻¹ Jᵀ over it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meet {
    /// Where the block is; its rows are joint `i`'s, its columns joint `k`'s.
    pub at: u32,
    pub i: u16,
    pub k: u16,
    pub body: u16,
    /// The body is A of that joint.
    pub i_is_a: bool,
    pub k_is_a: bool,
}

/// See the module's text.
#[derive(Clone, Debug)]
pub(crate) struct Pattern {
    pub joints: Vec<Link>,
    pub bodies: usize,
    /// The elimination, joint by joint.
    pub(super) steps: Vec<Step>,
    /// Blocks of two joints that share a body, and what elimination fills beside them: from, to.
    pub(super) meets: Vec<Meet>,
    pub(super) filled: Vec<(usize, usize)>,
    pub(super) floats: usize,
    /// Joints of each body, and whether it is A.
    pub(super) at_body: Vec<Vec<(u16, bool)>>,
}

impl Pattern {
    /// Joints of a set without loops whose bodies all move.
    pub fn new(joints: &[Link], bodies: usize) -> Option<Self> {
        let links: Vec<(u8, [u32; 2])> =
            joints.iter().map(|l| (l.kind.rows() as u8, [u32::from(l.a), u32::from(l.b)])).collect();
        let plan = Plan::new(&links, bodies, 6 * joints.len() + 64).filter(|p| !p.has_loops())?;
        let steps: Vec<Step> = plan.steps().collect();
        let mut meets = Vec::new();
        for (i, l) in joints.iter().enumerate() {
            for (k, m) in joints[..i].iter().enumerate() {
                for (body, i_is_a) in [(l.a, true), (l.b, false)] {
                    for (other, k_is_a) in [(m.a, true), (m.b, false)] {
                        if body == other {
                            let (at, row) = plan.place(i, k);
                            let meet = Meet { at: at as u32, i: i as u16, k: k as u16, body, i_is_a, k_is_a };
                            let turned =
                                Meet { i: meet.k, k: meet.i, i_is_a: k_is_a, k_is_a: i_is_a, ..meet };
                            meets.push(if row == i { meet } else { turned });
                        }
                    }
                }
            }
        }
        let mut filled = Vec::new();
        for s in &steps {
            for &(joint, at) in &s.below {
                if !meets.iter().any(|m: &Meet| m.at as usize == at) {
                    filled.push((at, at + joints[joint].kind.rows() * joints[s.joint].kind.rows()));
                }
            }
        }
        let mut at_body = vec![Vec::new(); bodies];
        for (i, l) in joints.iter().enumerate() {
            at_body[l.a as usize].push((i as u16, true));
            at_body[l.b as usize].push((i as u16, false));
        }
        Some(Self { joints: joints.to_vec(), bodies, steps, meets, filled, floats: plan.floats(), at_body })
    }
    #[inline(always)]
    pub(super) fn rows(&self, joint: usize) -> usize {
        self.joints[joint].kind.rows()
    }
    /// Rows from here on are ends.
    #[inline(always)]
    pub(super) fn first_end(&self, joint: usize) -> usize {
        self.joints[joint].kind.first_end()
    }
}
