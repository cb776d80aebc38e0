//! A box against a sphere, in closed form: one point.

use super::one_point;
use crate::convex::core::sign;
use crate::{FACE_A, Manifold};
use jounce_math::Vec3;

/// Box A, sphere B at `p`.
pub(crate) fn box_sphere(h: Vec3, r: f32, p: Vec3, margin: f32) -> Option<Manifold> {
    let near = p.clamp(-h, h);
    let d = p - near;
    let reach = r + margin;
    let d2 = d.length_squared();
    if d2 > reach * reach {
        return None;
    }
    let inside = p.abs() - h;
    if inside.max_component() > 0.0
        && let Some((n, l)) = d.try_normalize()
    {
        let s = l - r;
        let outside = u8::from(inside.x > 0.0) + u8::from(inside.y > 0.0) + u8::from(inside.z > 0.0);
        let faces = if outside == 1 { FACE_A } else { 0 };
        return Some(one_point(n, near + n * (0.5 * s), s, 0, faces));
    }
    let i = inside.max_axis();
    let mut n = Vec3::ZERO;
    n[i] = sign(p[i]);
    let s = inside[i] - r;
    let mut surface = p;
    surface[i] = n[i] * h[i];
    Some(one_point(n, surface + n * (0.5 * s), s, 0, FACE_A))
}
