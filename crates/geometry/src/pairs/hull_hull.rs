//! Separating axes of two polyhedra (hulls, boxes, triangles).
//!
//! Candidates are the face normals of both and the cross products of edge pairs. An edge pair is a face of the
//! Minkowski difference only where the arcs that their neighbouring face normals span on the Gauss sphere (those of B
//! negated) cross; with a, b and c, d the ends of the arcs that is: c and d on different sides of the plane of a, b, the
//! same for a and b, and both arcs on one half of the sphere. The planes' normals b × a and d × c are the edges
//! themselves, so four dot products reject almost all pairs (D. Gregorius, "The separating axis test between convex
//! polyhedra", GDC 2013).

use super::capsule::segments;
use super::poly::Poly;
use jounce_math::{Pose, Vec3};

/// The direction of the largest gap between two shapes' cores.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    /// Unit, from A to B.
    pub normal: Vec3,
    /// Distance of the cores along it, negative when they overlap.
    pub gap: f32,
    /// Witness points on A's and B's cores.
    pub a: Vec3,
    pub b: Vec3,
    /// Names the pair of features.
    pub feature: u32,
}

/// The axis of the largest gap; stops as soon as one beyond `margin` is found.
pub(crate) fn separating_axis(a: &Poly, b: &Poly, pose: &Pose, margin: f32) -> Option<Axis> {
    let mut best = face_axis(a, b, pose)?;
    if best.gap > margin {
        return Some(best);
    }
    let inverse = pose.inverse();
    if let Some(f) = face_axis(b, a, &inverse)
        && f.gap > best.gap
    {
        best = Axis {
            normal: -pose.q.rotate(f.normal),
            gap: f.gap,
            a: pose.transform_point(f.b),
            b: pose.transform_point(f.a),
            feature: f.feature | 1 << 8,
        };
        if best.gap > margin {
            return Some(best);
        }
    }
    Some(edge_axis(a, b, pose, &inverse, best))
}

/// Best of A's face normals.
fn face_axis(a: &Poly, b: &Poly, pose: &Pose) -> Option<Axis> {
    let mut best: Option<(usize, f32, usize)> = None;
    for (i, f) in a.real_faces().iter().enumerate() {
        let n = pose.q.inverse_rotate(f.normal);
        let v = b.support(-n);
        let gap = n.dot(b.vertices[v]) + f.normal.dot(pose.p) - f.offset;
        if best.is_none_or(|(_, g, _)| gap > g) {
            best = Some((i, gap, v));
        }
    }
    let (i, gap, v) = best?;
    let normal = a.faces[i].normal;
    let q = pose.transform_point(b.vertices[v]);
    Some(Axis { normal, gap, a: q - normal * gap, b: q, feature: i as u32 })
}

/// Best edge pair, if better than `floor`. Works in B's frame: A's edges are moved there one by one.
fn edge_axis(a: &Poly, b: &Poly, pose: &Pose, inverse: &Pose, floor: Axis) -> Axis {
    let mut gap = floor.gap;
    let mut found: Option<(usize, usize, Vec3)> = None;
    for (i, ea) in a.edges.iter().enumerate() {
        let p = inverse.transform_point(a.vertices[usize::from(ea.a)]);
        let u = inverse.q.rotate(a.vertices[usize::from(ea.b)] - a.vertices[usize::from(ea.a)]);
        let left = inverse.q.rotate(a.faces[usize::from(ea.left)].normal);
        let right = inverse.q.rotate(a.faces[usize::from(ea.right)].normal);
        let uu = u.length_squared();
        for (j, eb) in b.edges.iter().enumerate() {
            let cba = -b.faces[usize::from(eb.left)].normal.dot(u);
            let dba = -b.faces[usize::from(eb.right)].normal.dot(u);
            if cba * dba >= 0.0 {
                continue;
            }
            let q = b.vertices[usize::from(eb.a)];
            let v = b.vertices[usize::from(eb.b)] - q;
            let (adc, bdc) = (left.dot(v), right.dot(v));
            if adc * bdc >= 0.0 || cba * bdc <= 0.0 {
                continue;
            }
            let n = u.cross(v);
            let nn = n.length_squared();
            if nn <= 1e-6 * uu * v.length_squared() {
                continue;
            }
            let n = n * (1.0 / nn.sqrt());
            let n = if n.dot(left) + n.dot(right) < 0.0 { -n } else { n };
            let s = n.dot(q - p);
            if s > gap {
                gap = s;
                found = Some((i, j, n));
            }
        }
    }
    let Some((i, j, n)) = found else { return floor };
    let (ea, eb) = (&a.edges[i], &b.edges[j]);
    let (p, pe) = (a.vertices[usize::from(ea.a)], a.vertices[usize::from(ea.b)]);
    let (q, qe) = (b.vertices[usize::from(eb.a)], b.vertices[usize::from(eb.b)]);
    let (q, qe) = (pose.transform_point(q), pose.transform_point(qe));
    let (s, t) = segments(p, pe - p, q, qe - q);
    Axis {
        normal: pose.q.rotate(n),
        gap,
        a: p + (pe - p) * s,
        b: q + (qe - q) * t,
        feature: 1 << 20 | (i as u32 & 0x3FF) << 10 | (j as u32 & 0x3FF),
    }
}
