//! Half-space A against convex B: support points below the margin.

use super::capsule::ends;
use super::feature::Convex;
use super::general::Scratch;
use super::reduce::reduce;
use crate::{FACE_A, Manifold, ManifoldPoint, PairCache};
use jounce_math::{Pose, Vec3};

/// The plane, in A's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    pub normal: Vec3,
    pub offset: f32,
}

impl Plane {
    /// Contact of the surface point `p` (A's frame).
    fn point(&self, p: Vec3, feature: u32) -> ManifoldPoint {
        let separation = self.normal.dot(p) - self.offset;
        ManifoldPoint { point: p - self.normal * (0.5 * separation), separation, feature }
    }
    fn manifold(&self) -> Manifold {
        Manifold {
            normal: self.normal,
            faces: FACE_A,
            sub_a: crate::NO_SUB,
            sub_b: crate::NO_SUB,
            ..Manifold::default()
        }
    }
    fn gather(&self, points: impl Iterator<Item = ManifoldPoint>, margin: f32) -> Option<Manifold> {
        let mut m = self.manifold();
        for p in points.filter(|p| p.separation <= margin).take(4) {
            m.points[usize::from(m.count)] = p;
            m.count += 1;
        }
        (m.count > 0).then_some(m)
    }
}

/// Sphere B at `p`.
pub(crate) fn sphere(plane: &Plane, r: f32, p: Vec3, margin: f32) -> Option<Manifold> {
    plane.gather(core::iter::once(plane.point(p - plane.normal * r, 0)), margin)
}

/// Capsule B.
pub(crate) fn capsule(plane: &Plane, (h, r): (f32, f32), pose: &Pose, margin: f32) -> Option<Manifold> {
    let [p, q] = ends(h, pose).map(|e| e - plane.normal * r);
    plane.gather([plane.point(p, 0), plane.point(q, 1)].into_iter(), margin)
}

/// Box B: the four corners of the face that looks most at the plane. They hold the deepest corner.
pub(crate) fn boxed(plane: &Plane, h: Vec3, pose: &Pose, margin: f32) -> Option<Manifold> {
    let n = pose.q.inverse_rotate(plane.normal);
    let s = plane.normal.dot(pose.p) - plane.offset;
    if s - n.abs().dot(h) > margin {
        return None;
    }
    let i = n.abs().max_axis();
    let (u, v) = ((i + 1) % 3, (i + 2) % 3);
    let mut c = Vec3::ZERO;
    c[i] = if n[i] > 0.0 { -h[i] } else { h[i] };
    let corner = |k: u32| {
        let mut p = c;
        p[u] = if k & 1 != 0 { h[u] } else { -h[u] };
        p[v] = if k & 2 != 0 { h[v] } else { -h[v] };
        // Bits of the corner in x, y, z: the same corner keeps its name when another face looks down.
        let id = u32::from(p.x > 0.0) | u32::from(p.y > 0.0) << 1 | u32::from(p.z > 0.0) << 2;
        plane.point(pose.transform_point(p), id)
    };
    plane.gather([0, 1, 3, 2].into_iter().map(corner), margin)
}

/// Any other convex B: the corners of what it shows to the plane.
pub(crate) fn general(
    plane: &Plane,
    b: &Convex,
    pose: &Pose,
    margin: f32,
    cache: &mut PairCache,
    scratch: &mut Scratch,
) -> Option<Manifold> {
    let n = pose.q.inverse_rotate(plane.normal);
    let low = pose.transform_point(b.core.support(-n));
    if plane.point(low, 0).separation > margin {
        return None;
    }
    let Scratch { incident, points, .. } = scratch;
    let shown = b.feature(-n, incident);
    points.clear();
    for c in incident.iter() {
        let p = plane.point(pose.transform_point(c.p), shown << 10 | u32::from(c.after));
        if p.separation <= margin {
            points.push(p);
        }
    }
    let mut m = plane.manifold();
    reduce(points, &mut m, cache);
    (m.count > 0).then_some(m)
}
