//! Triangle mesh: a surface without inside.

use super::{Hit, PointHit, triangle};
use crate::TriMesh;
use jounce_math::Vec3;

pub(super) fn ray(mesh: &TriMesh, origin: Vec3, dir: Vec3, max_t: f32) -> Option<Hit> {
    let ray = triangle::TriangleRay::new(origin, dir);
    let mut best: Option<(f32, u32)> = None;
    mesh.tree.ray(origin, dir, Vec3::ZERO, max_t, |i, bound| {
        let Some(t) = ray.hit(&mesh.triangle(i)).filter(|&t| t >= 0.0 && t <= bound) else {
            return bound;
        };
        if best.is_none_or(|(s, j)| t < s || (t == s && mesh.original_index(i) < mesh.original_index(j))) {
            best = Some((t, i));
        }
        t
    });
    best.map(|(t, i)| {
        let n = mesh.normal(i);
        Hit { t, normal: if n.dot(dir) > 0.0 { -n } else { n }, sub: mesh.original_index(i) }
    })
}

pub(super) fn closest(mesh: &TriMesh, point: Vec3) -> Option<PointHit> {
    let mut best: Option<(f32, u32, Vec3)> = None;
    mesh.tree.nearest(point, f32::INFINITY, |i, bound| {
        let q = triangle::closest_point(&mesh.triangle(i), point);
        let d2 = (point - q).length_squared();
        let first = best
            .is_none_or(|(s, j, _)| d2 < s || (d2 == s && mesh.original_index(i) < mesh.original_index(j)));
        if first {
            best = Some((d2, i, q));
        }
        if d2 < bound { d2 } else { bound }
    });
    best.map(|(_, i, q)| {
        let (normal, distance) = (point - q).try_normalize().unwrap_or((mesh.normal(i), 0.0));
        PointHit { point: q, distance, normal, sub: mesh.original_index(i) }
    })
}
