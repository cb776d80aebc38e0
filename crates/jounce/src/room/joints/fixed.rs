//! Nothing moves: the three rows of a ball joint and the three that stop all turning, C = 2 v_i of q_a⁻¹ q_b = (v, w).
//!
//! Source: Catto, Modeling and solving constraints, GDC 2009.

use super::rows::{Ends, Hard};

pub(crate) fn rows(e: &Ends, out: &mut Hard) {
    super::ball::rows(e, out);
    e.no_turn().into_iter().for_each(|r| out.push(r));
}
