//! The distance of two anchors: C = |d| − L, n = d/|d|, J = (−n, −r_a × n, n, r_b × n).
//!
//! Two rows across it, J = (−t, −r_a × t, t, r_b × t), take part only as dampers where a heavy load pulls on light ends (see `set`).
//!
//! A rod (min = max) holds both ways. A rope or a strut is one row that holds only while it would be over its bound, and only
//! pulls (λ ≤ 0) or pushes (λ ≥ 0).
//!
//! Source: Jakobsen, Advanced character physics, GDC 2001; one-sided rows: Baraff, Fast contact force computation for
//! nonpenetrating rigid bodies, 1994.

use super::rows::{Ends, Hard};

/// Sign of the bound that is nearer to being crossed: +1 pushes apart, −1 pulls together, 0 both.
pub(crate) fn side(min: f32, max: f32, e: &Ends) -> f32 {
    let length = e.d.length();
    if min >= max {
        0.0
    } else if length - min < max - length {
        1.0
    } else {
        -1.0
    }
}

/// The row of one bound, and those across.
pub(crate) fn rows(min: f32, max: f32, sign: f32, e: &Ends, out: &mut Hard) {
    let mut row = e.distance();
    let length = row.c;
    row.c = if sign > 0.0 { length - min } else { length - max };
    out.push(row);
    let (t, u) = row.lb.orthonormal_basis();
    out.push(e.beside(t));
    out.push(e.beside(u));
}
