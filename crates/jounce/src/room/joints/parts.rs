//! What rows a joint has beside those that hold, as the kernels in lanes take them.

use super::desc::{AxisDesc, BallDesc, JointKind, LimitDesc, MotorTarget, SpringDesc};
use crate::room::contacts::rows::Lane;
use jounce_math::{Quat, Vec3};

/// A spring towards a rotation: everything in A's axes.
pub(super) struct Pull {
    pub spring: SpringDesc,
    pub rest: Quat,
    pub speed: Vec3,
    pub max: f32,
}

/// A speed held with bounded torque.
pub(super) struct Drive {
    pub speed: Vec3,
    pub max: f32,
}

/// What the rows of a joint are beside those that hold. The numbers are places in its record's list of impulses, which is the list of
/// [`super::extra::Extras`].
#[derive(Default)]
pub(super) struct Parts {
    pub cone: Option<(usize, f32)>,
    pub twist: Option<(usize, LimitDesc)>,
    pub pull: Option<Pull>,
    pub drive: Option<(usize, Drive)>,
    pub count: usize,
}

impl Parts {
    pub fn of(kind: &JointKind) -> Self {
        match kind {
            JointKind::Ball(b) => Self::of_ball(b),
            JointKind::Hinge(a) => Self::of_axis(a),
            _ => Self::default(),
        }
    }

    fn next(&mut self, n: usize) -> usize {
        self.count += n;
        self.count - n
    }

    fn of_ball(b: &BallDesc) -> Self {
        let mut e = Self::default();
        e.cone = b.cone.map(|c| (e.next(1), c));
        e.twist = b.twist.map(|t| (e.next(1), t));
        if let Some(m) = &b.motor {
            let at = e.next(3);
            match m.rotation {
                Some(q) => {
                    let (rest, speed) = (q.normalize(), m.velocity);
                    e.pull = Some(Pull { spring: m.spring, rest, speed, max: m.max_torque });
                }
                None => e.drive = Some((at, Drive { speed: m.velocity, max: m.max_torque })),
            }
        }
        if b.friction > 0.0 {
            e.drive = Some((e.next(3), Drive { speed: Vec3::ZERO, max: b.friction }));
        }
        e
    }

    fn of_axis(a: &AxisDesc) -> Self {
        let about = |angle: f32| Quat::from_axis_angle(Vec3::X, angle);
        let mut e = Self::default();
        if let Some((rest, spring)) = a.spring {
            e.next(1);
            e.pull = Some(Pull { spring, rest: about(rest), speed: Vec3::ZERO, max: f32::INFINITY });
        }
        e.twist = a.limit.map(|t| (e.next(1), t));
        if let Some(m) = a.motor {
            let at = e.next(1);
            match m.target {
                MotorTarget::Velocity(v) => {
                    e.drive = Some((at, Drive { speed: Vec3::X * v, max: m.max_force }));
                }
                MotorTarget::Position { position, velocity, spring } => {
                    let (rest, speed) = (about(position), Vec3::X * velocity);
                    e.pull = Some(Pull { spring, rest, speed, max: m.max_force });
                }
            }
        }
        if a.friction > 0.0 {
            e.drive = Some((e.next(1), Drive { speed: Vec3::ZERO, max: a.friction }));
        }
        e
    }
}

pub(super) fn set_quat(to: &mut [Lane; 4], l: usize, q: Quat) {
    (to[0][l], to[1][l], to[2][l], to[3][l]) = (q.x, q.y, q.z, q.w);
}
