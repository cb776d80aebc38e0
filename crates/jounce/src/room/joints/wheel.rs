//! A wheel: spins about x_b, moves along y_a, and may be steered about y_a.
//!
//! Rows: the anchor stays on A's y axis, C = x_a·d and z_a·d; the axle stays across y_a, C = y_a·x_b, j = x_b × y_a; without steering
//! also across z_a. Coordinates: y_a·d (suspension), the angle of x_b from x_a about y_a (steering), and the twist (spin).
//!
//! Source: Catto, Box2D v3 wheel joint; in space with steering as in Jolt's vehicle rows.

use super::desc::AxisDesc;
use super::extra::Extras;
use super::rows::{Ends, Hard};

pub(crate) fn rows(suspension: &AxisDesc, steer: &AxisDesc, e: &Ends, out: &mut Hard) {
    out.push(e.along(e.axis_a(0)));
    out.push(e.along(e.axis_a(2)));
    if suspension.locked {
        out.push(e.along(e.axis_a(1)));
    }
    out.push(e.across(0, 1));
    if steer.locked {
        out.push(e.across(0, 2));
    }
}

pub(crate) fn extras(axes: [&AxisDesc; 3], e: &Ends, coordinate: &mut f32, out: &mut Extras<'_>) {
    let [suspension, spin, steer] = axes;
    out.axis(suspension, e.along(e.axis_a(1)));
    out.axis(steer, e.swing(1));
    let mut row = super::hinge::angle(e.twist(), *coordinate);
    *coordinate = row.c;
    // About the axle itself: a steered wheel spins about where it points.
    row.jb = e.axis_b(0);
    row.ja = -row.jb;
    out.axis(spin, row);
}
