//! Slides along A's x alone.
//!
//! Two rows hold the point across x: C = y_a·d, z_a·d, J = (−n, −(r_a + d) × n, n, r_b × n); three stop all turning: C = 2 v_i of
//! q_a⁻¹ q_b = (v, w), j = q_a (w e_i + v × e_i). The coordinate is x_a·d.
//!
//! Source: Catto, Modeling and solving constraints, GDC 2009.

use super::desc::AxisDesc;
use super::extra::Extras;
use super::rows::{Ends, Hard};

pub(crate) fn rows(e: &Ends, out: &mut Hard) {
    out.push(e.along(e.axis_a(1)));
    out.push(e.along(e.axis_a(2)));
    e.no_turn().into_iter().for_each(|r| out.push(r));
}

pub(crate) fn extras(axis: &AxisDesc, e: &Ends, coordinate: &mut f32, out: &mut Extras<'_>) {
    let row = e.along(e.axis_a(0));
    *coordinate = row.c;
    out.axis(axis, row);
}
