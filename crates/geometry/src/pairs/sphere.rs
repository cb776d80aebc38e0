//! Spheres against spheres, capsules and boxes, in closed form. The sphere is B; one point each.

use super::one_point;
use crate::convex::core::sign;
use crate::{FACE_A, Manifold};
use jounce_math::{Vec3, scalar::f32s};

/// Ball of radius `ra` at `a` and ball of radius `rb` at `b`.
pub(crate) fn balls(a: Vec3, ra: f32, b: Vec3, rb: f32, margin: f32, feature: u32) -> Option<Manifold> {
    let d = b - a;
    let reach = ra + rb + margin;
    if d.length_squared() > reach * reach {
        return None;
    }
    // Concentric balls have no direction; any one pushes them apart.
    let (n, l) = d.try_normalize().unwrap_or((Vec3::Y, 0.0));
    let s = l - ra - rb;
    (s <= margin).then(|| one_point(n, a + n * (ra + 0.5 * s), s, feature, 0))
}

/// Capsule A along y, sphere B at `p`.
pub(crate) fn capsule_sphere(h: f32, ra: f32, rb: f32, p: Vec3, margin: f32) -> Option<Manifold> {
    let near = Vec3::new(0.0, f32s::clamp(p.y, -h, h), 0.0);
    if let Some(m) = (near == p).then_some(Vec3::X) {
        // The centre lies on the axis: leave sideways.
        let s = -ra - rb;
        return Some(one_point(m, near + m * (ra + 0.5 * s), s, 0, 0));
    }
    balls(near, ra, p, rb, margin, 0)
}

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
