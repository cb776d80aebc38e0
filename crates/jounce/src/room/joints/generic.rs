//! Six axes, each locked or free.
//!
//! Locked lines: C = n·d along A's x, y, z. Turns locked about all three: C = 2 v_i of q_a⁻¹ q_b. About two: a hinge about the third e, C =
//! e_b·n for both others n of A. About one, y or z: x_b stays across the other, C = z_a·x_b or y_a·x_b; x: the twist is 0, but for where
//! x_a and x_b point apart by 150° and more, and it comes to mean nothing. A turn that is free beside two locked ones is
//! measured as a hinge's; else the twist about x, and as swings the parts about y and z of the rotation vector from x_a to x_b.
//!
//! Source: the 6-DOF joints of PhysX and Bullet.

use super::desc::AxisDesc;
use super::extra::Extras;
use super::rows::{Ends, Hard, Row};

/// The only axis that turns freely.
pub(super) fn hinge(angular: &[AxisDesc; 3]) -> Option<usize> {
    let mut free = (0..3).filter(|&i| !angular[i].locked);
    free.next().filter(|_| free.next().is_none())
}

/// The turn that is the joint's coordinate: that of its hinge, or the twist.
pub(crate) fn coordinate(angular: &[AxisDesc; 3], e: &Ends, last: f32) -> Row {
    super::hinge::angle(e.twist_about(hinge(angular).unwrap_or(0)), last)
}

pub(crate) fn rows(linear: &[AxisDesc; 3], angular: &[AxisDesc; 3], e: &Ends, out: &mut Hard) {
    for (i, axis) in linear.iter().enumerate() {
        if axis.locked {
            out.push(e.along(e.axis_a(i)));
        }
    }
    if angular.iter().all(|a| a.locked) {
        e.no_turn().into_iter().for_each(|r| out.push(r));
        return;
    }
    if let Some(free) = hinge(angular) {
        out.push(e.across(free, (free + 1) % 3));
        out.push(e.across(free, (free + 2) % 3));
        return;
    }
    if angular[1].locked {
        out.push(e.across(0, 2));
    }
    if angular[2].locked {
        out.push(e.across(0, 1));
    }
    if angular[0].locked && !e.points_back() {
        out.push(e.twist());
    }
}

pub(crate) fn extras(
    linear: &[AxisDesc; 3],
    angular: &[AxisDesc; 3],
    e: &Ends,
    coordinate: &mut f32,
    out: &mut Extras<'_>,
) {
    for (i, axis) in linear.iter().enumerate() {
        out.axis(axis, e.along(e.axis_a(i)));
    }
    let turn = self::coordinate(angular, e, *coordinate);
    *coordinate = turn.c;
    if let Some(free) = hinge(angular) {
        out.axis(&angular[free], turn);
        return;
    }
    let middle = angular[0].limit.map_or(0.0, |l| 0.5 * (l.min + l.max));
    let fades = e.fading_twist(middle);
    out.axis(&angular[0], if fades.jb == turn.jb { turn } else { fades });
    out.axis(&angular[1], e.swing(1));
    out.axis(&angular[2], e.swing(2));
}
