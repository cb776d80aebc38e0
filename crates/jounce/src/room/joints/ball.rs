//! A point held: C = p_b − p_a = 0.
//!
//! Three rows along A's axes n: C = n·d, J = (−n, −(r_a + d) × n, n, r_b × n). Where something stronger tore the two apart, both are
//! pulled at their own anchors along the world's axes, J = (−n, −r_a × n, n, r_b × n): no lever grows with d, and dC/dt = J u still. (Axes
//! that turn with A swept C by metres within a substep, which was asked back at once: 235 J became 50 kJ.) Which of the two it is, the
//! start of the substep says, for the error ahead too: measured along other axes than it is pulled, a worm of 30 balls gained 9,500 times
//! its energy.
//! Limits: the cone C = γ − angle(x_a, x_b) ≥ 0 with j = x_a × x_b / |x_a × x_b|, and the twist about x between two angles.
//! Motor: the rotation vector from the wanted pose, about A's axes.
//!
//! Source: Baraff, Linear-time dynamics using Lagrange multipliers, 1996; limits as swing and twist: Dobrowolski, Swing-twist
//! decomposition in Clifford algebra, 2015.

use super::desc::{BallDesc, LimitDesc};
use super::extra::{Duty, Extras};
use super::rows::{Ends, Hard, Row, unit};
use crate::room::joints::desc::MotorTarget;

pub(crate) fn rows(e: &Ends, out: &mut Hard) {
    for i in 0..3 {
        let n = unit(i);
        out.push(if e.torn { Row { c: n.dot(e.d), ..e.beside(n) } } else { e.along(e.axis_a(i)) });
    }
}

impl BallDesc {
    /// No cone keeps its two x axes within 150°.
    pub(super) fn may_point_apart(&self) -> bool {
        self.cone_spring.is_some() || self.cone.is_none_or(|c| c > WIDE)
    }
}

pub(crate) fn extras(b: &BallDesc, e: &Ends, out: &mut Extras<'_>) {
    if let Some(cone) = b.cone {
        out.push(e.cone(), Duty::Limit(LimitDesc { min: -1.0, max: cone, spring: b.cone_spring }));
    }
    if let Some(twist) = b.twist {
        let row = if b.may_point_apart() { e.fading_twist(0.5 * (twist.min + twist.max)) } else { e.twist() };
        out.push(row, Duty::Limit(twist));
    }
    if let Some(m) = &b.motor {
        let rows = match m.rotation {
            Some(q) => e.turn_from(q.normalize()),
            None => [0, 1, 2].map(|i| e.about(i)),
        };
        for (i, row) in rows.into_iter().enumerate() {
            let velocity = m.velocity[i];
            let target = match m.rotation {
                Some(_) => MotorTarget::Position { position: 0.0, velocity, spring: m.spring },
                None => MotorTarget::Velocity(velocity),
            };
            out.push(row, Duty::motor(target, m.max_torque));
        }
    }
    if b.friction > 0.0 {
        for i in 0..3 {
            out.push(e.about(i), Duty::motor(MotorTarget::Velocity(0.0), b.friction));
        }
    }
}

/// Cone beyond which a twist fades, rad: 150°.
const WIDE: f32 = 2.617;
/// Gap from which a point is torn, m.
pub(super) const TORN: f32 = 0.05;
