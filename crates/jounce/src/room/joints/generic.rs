//! Six axes, each locked or free.
//!
//! Locked lines: C = n·d along A's x, y, z. Turns locked about all three: C = 2 v_i of q_a⁻¹ q_b; about y or z alone, x_b stays
//! across the other: C = z_a·x_b or y_a·x_b; about x alone the twist is 0. Free turns are measured as twist about x and as swings
//! asin(y_a·x_b) about z and −asin(z_a·x_b) about y.
//!
//! Source: the 6-DOF joints of PhysX and Bullet.

use super::desc::AxisDesc;
use super::extra::Extras;
use super::rows::{Ends, Hard};

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
    if angular[0].locked {
        out.push(e.twist());
    }
    if angular[1].locked {
        out.push(e.across(2));
    }
    if angular[2].locked {
        out.push(e.across(1));
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
    let twist = super::hinge::angle(e, *coordinate);
    *coordinate = twist.c;
    out.axis(&angular[0], twist);
    out.axis(&angular[1], e.swing(1));
    out.axis(&angular[2], e.swing(2));
}
