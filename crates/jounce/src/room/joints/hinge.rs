//! Turns about x alone.
//!
//! Three rows hold the point as in a ball joint; two hold the axis: C = y_a·x_b and z_a·x_b, j = x_b × y_a and x_b × z_a. The
//! coordinate is the twist θ = 2 atan2(v_x, w) of q_a⁻¹ q_b = (v, w), counted over turns, j = (x_a + x_b)/(1 + x_a·x_b).
//!
//! Source: Catto, Modeling and solving constraints, GDC 2009.

use super::desc::AxisDesc;
use super::extra::Extras;
use super::rows::{Ends, Hard, Row};

pub(crate) fn rows(e: &Ends, out: &mut Hard) {
    super::ball::rows(e, out);
    out.push(e.across(0, 1));
    out.push(e.across(0, 2));
}

/// θ next to where it was last.
pub(crate) fn angle(mut row: Row, last: f32) -> Row {
    let turn = 2.0 * core::f32::consts::PI;
    row.c += turn * ((last - row.c) / turn).round();
    row
}

pub(crate) fn extras(axis: &AxisDesc, e: &Ends, coordinate: &mut f32, out: &mut Extras<'_>) {
    let row = angle(e.twist(), *coordinate);
    *coordinate = row.c;
    out.axis(axis, row);
}
