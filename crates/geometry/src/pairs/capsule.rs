//! Capsules against capsules and polyhedra. The capsule is B; up to two points.

use super::one_point;
use super::poly::Poly;
use crate::convex::core::Core;
use crate::convex::gjk::{Difference, Gjk};
use crate::{FACE_A, Manifold, ManifoldPoint, PairCache};
use jounce_math::{Pose, Vec3, scalar::f32s};

/// Normals closer than this to a face's normal (cosine; 1.1°) make a face contact.
const FACE_COSINE: f32 = 0.9998;

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
    if axis.y.abs() > FACE_COSINE
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

/// Polyhedron A (with its core), capsule B (half height `h`, radius `r`) at `pose`.
pub(crate) fn poly_capsule(
    a: &Poly,
    core: Core,
    (h, r): (f32, f32),
    pose: &Pose,
    margin: f32,
    cache: &mut PairCache,
) -> Option<Manifold> {
    let d = pose.q.rotate(Vec3::new(0.0, h, 0.0));
    let ends = [pose.p - d, pose.p + d];
    let w = Difference { a: core, b: Core::Segment(h), pose: *pose };
    match w.gjk(cache.axis, r + margin) {
        Gjk::Far(axis) => {
            cache.axis = axis;
            None
        }
        Gjk::Apart { distance, a: near, normal, .. } if distance > 1e-3 * r => {
            cache.axis = normal;
            let f = a.face_along(normal);
            let s = distance - r;
            // A steep segment just past the face's border loses its near end to the clip: then one point.
            if a.faces[f].normal.dot(normal) > FACE_COSINE
                && let Some(m) = face_segment(a, f, ends, r, margin)
                && m.points().iter().any(|p| p.separation < s + 5e-4 * r)
            {
                return Some(m);
            }
            Some(one_point(normal, near + normal * (0.5 * s), s, 0, 0))
        }
        _ => {
            let m = deep(a, ends, r, margin);
            cache.axis = m.map_or(Vec3::ZERO, |m| m.normal);
            m
        }
    }
}

/// The segment cuts the polyhedron: least overlap over face normals and edge × segment.
fn deep(a: &Poly, ends: [Vec3; 2], r: f32, margin: f32) -> Option<Manifold> {
    let (mut face, mut face_depth) = (0, f32::NEG_INFINITY);
    for (i, f) in a.faces.iter().enumerate() {
        let s = f32s::min(f.normal.dot(ends[0]), f.normal.dot(ends[1])) - f.offset;
        if s > face_depth {
            (face, face_depth) = (i, s);
        }
    }
    let direction = ends[1] - ends[0];
    let mut best: Option<(usize, Vec3)> = None;
    let mut edge_depth = f32::NEG_INFINITY;
    for (i, e) in a.edges.iter().enumerate() {
        let (p, q) = (a.vertices[usize::from(e.a)], a.vertices[usize::from(e.b)]);
        let axis = (q - p).cross(direction);
        if axis.length_squared() <= 1e-6 * (q - p).length_squared() * direction.length_squared() {
            continue;
        }
        let n = axis.normalize_or(Vec3::X);
        let n = if n.dot(p - a.center) < 0.0 { -n } else { n };
        let (fl, fr) = (a.faces[usize::from(e.left)].normal, a.faces[usize::from(e.right)].normal);
        // On the arc between the edge's two faces, or n is no outer normal of this edge.
        if n.dot(fl.cross(q - p)) > 1e-4 || n.dot((q - p).cross(fr)) > 1e-4 {
            continue;
        }
        let s = n.dot(ends[0] - p);
        if s > edge_depth {
            edge_depth = s;
            best = Some((i, n));
        }
    }
    if let Some((i, n)) = best
        && edge_depth > 0.98 * face_depth + 0.01 * r
    {
        let e = &a.edges[i];
        let (p, q) = (a.vertices[usize::from(e.a)], a.vertices[usize::from(e.b)]);
        let (s, _) = segments(p, q - p, ends[0], direction);
        let sep = edge_depth - r;
        let surface = p + (q - p) * s;
        return (sep <= margin).then(|| one_point(n, surface + n * (0.5 * sep), sep, 1 << 16 | i as u32, 0));
    }
    face_segment(a, face, ends, r, margin)
}

/// The part of the capsule's segment over face `f`, as one or two points.
fn face_segment(a: &Poly, f: usize, ends: [Vec3; 2], r: f32, margin: f32) -> Option<Manifold> {
    let n = a.faces[f].normal;
    let corners = a.face_loop(f);
    let d = ends[1] - ends[0];
    let (mut t0, mut t1) = (0.0f32, 1.0f32);
    for i in 0..corners.len() {
        let p = a.vertices[usize::from(corners[i])];
        let q = a.vertices[usize::from(corners[(i + 1) % corners.len()])];
        let out = (q - p).cross(n);
        let (x, dx) = (out.dot(ends[0] - p), out.dot(d));
        if dx > 0.0 {
            t1 = f32s::min(t1, -x / dx);
        } else if dx < 0.0 {
            t0 = f32s::max(t0, -x / dx);
        } else if x > 1e-4 * out.length() * d.length() {
            return None;
        }
    }
    if t0 > t1 {
        return None;
    }
    let mut m = Manifold {
        normal: n,
        faces: FACE_A,
        sub_a: crate::NO_SUB,
        sub_b: crate::NO_SUB,
        ..Manifold::default()
    };
    for (k, t) in [t0, t1].into_iter().enumerate() {
        let q = ends[0] + d * t;
        let s = n.dot(q) - a.faces[f].offset - r;
        if s <= margin {
            let point = q - n * (r + 0.5 * s);
            let feature = (f as u32 + 1) << 2 | k as u32;
            m.points[usize::from(m.count)] = ManifoldPoint { point, separation: s, feature };
            m.count += 1;
        }
        if t1 - t0 < 1e-3 {
            break;
        }
    }
    (m.count > 0).then_some(m)
}

/// Ball of radius `r` at each end: for half-spaces.
pub(crate) fn ends(h: f32, pose: &Pose) -> [Vec3; 2] {
    let d = pose.q.rotate(Vec3::new(0.0, h, 0.0));
    [pose.p - d, pose.p + d]
}
