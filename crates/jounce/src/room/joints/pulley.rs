//! A rope over two wheels of the world: C = |p_a − g_a| + ρ |p_b − g_b| − L ≤ 0.
//!
//! n_a = (p_a − g_a)/|…|, n_b likewise: J = (n_a, r_a × n_a, ρ n_b, ρ r_b × n_b), λ ≤ 0: a rope pulls.
//!
//! Source: Catto, Box2D pulley joint; here the rope may go slack.

use super::rows::{Ends, Row};
use jounce_math::Vec3;

/// `da`, `db`: from the wheels to the anchors.
pub(crate) fn row(e: &Ends, da: Vec3, db: Vec3, ratio: f32, length: f32) -> Row {
    let unit = |d: Vec3| {
        let l = d.length();
        if l > 1e-6 { (d / l, l) } else { (Vec3::new(0.0, -1.0, 0.0), 0.0) }
    };
    let ((na, la), (nb, lb)) = (unit(da), unit(db));
    Row {
        la: na,
        ja: e.ra.cross(na),
        lb: nb * ratio,
        jb: e.rb.cross(nb) * ratio,
        c: la + ratio * lb - length,
    }
}
