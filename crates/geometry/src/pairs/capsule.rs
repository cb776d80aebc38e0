//! Capsules against capsules, and the separating axes of a segment that cuts a polyhedron.

use super::hull_hull::Axis;
use super::one_point;
use super::poly::Poly;
use crate::{Manifold, ManifoldPoint};
use jounce_math::{Pose, Vec3, scalar::f32s};

/// Axes closer to each other than this (cosine; 1.1°) are parallel.
const PARALLEL_COSINE: f32 = 0.9998;

/// Parameters s, t in 0…1 of the closest points p1 + s d1 and p2 + t d2.
pub(crate) fn segments(p1: Vec3, d1: Vec3, p2: Vec3, d2: Vec3) -> (f32, f32) {
    let r = p1 - p2;
    let (a, e, f) = (d1.length_squared(), d2.length_squared(), d2.dot(r));
    let tiny = f32::MIN_POSITIVE;
    if a <= tiny && e <= tiny {
        return (0.0, 0.0);
    }
    if a <= tiny {
        return (0.0, f32s::clamp(f / e, 0.0, 1.0));
    }
    let c = d1.dot(r);
    if e <= tiny {
        return (f32s::clamp(-c / a, 0.0, 1.0), 0.0);
    }
    let b = d1.dot(d2);
    let denominator = a * e - b * b;
    let mut s =
        if denominator > 1e-7 * a * e { f32s::clamp((b * f - c * e) / denominator, 0.0, 1.0) } else { 0.5 };
    let mut t = (b * s + f) / e;
    if !(0.0..=1.0).contains(&t) {
        t = f32s::clamp(t, 0.0, 1.0);
        s = f32s::clamp((b * t - c) / a, 0.0, 1.0);
    }
    (s, t)
}

/// Capsule A along y (half height `ha`), capsule B at `pose`.
pub(crate) fn capsule_capsule(
    (ha, ra): (f32, f32),
    (hb, rb): (f32, f32),
    pose: &Pose,
    margin: f32,
) -> Option<Manifold> {
    let axis = pose.q.rotate(Vec3::Y);
    let (p1, d1) = (Vec3::new(0.0, -ha, 0.0), Vec3::new(0.0, 2.0 * ha, 0.0));
    let (p2, d2) = (pose.p - axis * hb, axis * (2.0 * hb));
    let (s, t) = segments(p1, d1, p2, d2);
    let (a, b) = (p1 + d1 * s, p2 + d2 * t);
    let d = b - a;
    let reach = ra + rb + margin;
    if d.length_squared() > reach * reach {
        return None;
    }
    // Crossing axes have no direction: use their common perpendicular.
    let Some((n, distance)) = d.try_normalize() else {
        let n = Vec3::Y.cross(axis).normalize_or(Vec3::X);
        return Some(one_point(n, a, -ra - rb, 0, 0));
    };
    // Nearly parallel: two points at the ends of the common stretch.
    if axis.y.abs() > PARALLEL_COSINE
        && n.y.abs() < 0.02
        && let Some(m) = parallel(ha, ra, (p2, d2), rb, n, margin)
    {
        return Some(m);
    }
    let sep = distance - ra - rb;
    (sep <= margin).then(|| one_point(n, a + n * (ra + 0.5 * sep), sep, 0, 0))
}

fn parallel(ha: f32, ra: f32, (p2, d2): (Vec3, Vec3), rb: f32, n: Vec3, margin: f32) -> Option<Manifold> {
    let side = Vec3::new(n.x, 0.0, n.z).try_normalize()?.0;
    let (y0, y1) = (p2.y, p2.y + d2.y);
    let clip = |y: f32| f32s::clamp(y, -ha, ha);
    let (lo, hi) = (clip(y0), clip(y1));
    if (hi - lo).abs() <= 0.1 * f32s::min(2.0 * ha, d2.y.abs()) {
        return None;
    }
    let mut m = Manifold { normal: side, sub_a: crate::NO_SUB, sub_b: crate::NO_SUB, ..Manifold::default() };
    for (k, y) in [lo, hi].into_iter().enumerate() {
        let q = p2 + d2 * ((y - y0) / (y1 - y0));
        let s = q.dot(side) - ra - rb;
        if s <= margin {
            let point = Vec3::new(0.0, y, 0.0) + side * (ra + 0.5 * s);
            m.points[usize::from(m.count)] = ManifoldPoint { point, separation: s, feature: 1 + k as u32 };
            m.count += 1;
        }
    }
    (m.count == 2).then_some(m)
}

/// The segment cuts polyhedron A: least overlap over face normals and edge × segment.
pub(crate) fn segment_axis(a: &Poly, ends: [Vec3; 2]) -> Option<Axis> {
    let mut best: Option<Axis> = None;
    for (i, f) in a.real_faces().iter().enumerate() {
        let (s, t) = (f.normal.dot(ends[0]), f.normal.dot(ends[1]));
        let (q, s) = if t < s { (ends[1], t) } else { (ends[0], s) };
        let gap = s - f.offset;
        if best.is_none_or(|b| gap > b.gap) {
            best = Some(Axis { normal: f.normal, gap, a: q - f.normal * gap, b: q, feature: i as u32 });
        }
    }
    let mut best = best?;
    let v = ends[1] - ends[0];
    for (i, e) in a.edges.iter().enumerate() {
        let p = a.vertices[usize::from(e.a)];
        let u = a.vertices[usize::from(e.b)] - p;
        let (left, right) = (a.faces[usize::from(e.left)].normal, a.faces[usize::from(e.right)].normal);
        // The normal lies between those of the edge's faces where the segment crosses that fan.
        if left.dot(v) * right.dot(v) >= 0.0 {
            continue;
        }
        let n = u.cross(v);
        let nn = n.length_squared();
        if nn <= 1e-6 * u.length_squared() * v.length_squared() {
            continue;
        }
        let n = n * (1.0 / nn.sqrt());
        let n = if n.dot(left) + n.dot(right) < 0.0 { -n } else { n };
        let gap = n.dot(ends[0] - p);
        if gap > best.gap {
            let (s, t) = segments(p, u, ends[0], v);
            best = Axis { normal: n, gap, a: p + u * s, b: ends[0] + v * t, feature: 1 << 20 | i as u32 };
        }
    }
    Some(best)
}

/// Ends of the segment.
pub(crate) fn ends(h: f32, pose: &Pose) -> [Vec3; 2] {
    let d = pose.q.rotate(Vec3::new(0.0, h, 0.0));
    [pose.p - d, pose.p + d]
}
