//! Any two convex shapes.
//!
//! 1. What polyhedra touched with last time, where it holds ([`super::held`]).
//! 2. The axis: GJK while the cores are apart; when they overlap, separating axes for polyhedra and segments and EPA
//!    for the rest.
//! 3. The contact: if a flat face of either shape separates almost as well as the axis, its normal is taken and what
//!    the other shape shows (a face, an edge, a point) is clipped against its sides. Two parallel edges give two
//!    points. All else gives the pair of witness points.

use super::capsule;
use super::feature::{Convex, Corner, FlatFace, REFERENCE_LINE};
use super::held::{self, KIND, face_kind};
use super::hull_hull::{Axis, separating_axis};
use super::poly::Poly;
use super::reduce::reduce;
use crate::convex::core::Core;
use crate::convex::epa::Penetration;
use crate::convex::gjk::{Difference, Gjk, Simplex};
use crate::{FACE_A, Manifold, ManifoldPoint, NO_SUB, PairCache};
use jounce_math::{Pose, Vec3, scalar::f32s};

/// Polygons in work.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    pub reference: Vec<Corner>,
    pub incident: Vec<Corner>,
    /// Face of B that was shown last, and its corners in A's frame.
    shown: Option<u32>,
    shown_corners: Vec<Corner>,
    other: Vec<Corner>,
    pub points: Vec<ManifoldPoint>,
}

/// Above this many edge pairs EPA finds the axis faster than trying them all.
const EDGE_PAIRS_MAX: usize = 500;

/// Cosine of the most that a face may lean against the axis of two edges and still be asked for points along one of them (3.6°).
const ALONG: f32 = 0.998;

/// Does a face whose normal has this cosine with the axis of two edges lie along it? They are no deeper in one another than they may be apart, and
/// another point, a part of the thinner shape's thickness `away`, would be within the margin.
pub(super) fn lies_along(cosine: f32, gap: f32, away: f32, margin: f32) -> bool {
    gap > -margin && cosine > ALONG && (1.0 - cosine * cosine) * away * away < margin * margin
}

/// Is the contact of such a face that of the edges, and more than their one point?
pub(super) fn holds_edges(m: &Manifold, deepest: f32, tolerance: f32) -> bool {
    let least = m.points().iter().fold(f32::INFINITY, |s, p| f32s::min(p.separation, s));
    m.count > 1 && (least - deepest).abs() <= 2.0 * tolerance
}

pub(crate) const KIND_FACE_A: u32 = 1;
pub(crate) const KIND_FACE_B: u32 = 2;
const KIND_POINT: u32 = 3;
/// Two edges of polyhedra.
pub(crate) const KIND_EDGES: u32 = 4;

/// Few enough for trying all pairs of edges.
pub(crate) fn few_edges(a: &Poly, b: &Poly) -> bool {
    a.edges.len() * b.edges.len() <= EDGE_PAIRS_MAX
}

/// Contact of convex A and B.
pub(crate) fn convex(
    a: &Convex,
    b: &Convex,
    pose: &Pose,
    margin: f32,
    cache: &mut PairCache,
    scratch: &mut Scratch,
) -> Option<Manifold> {
    if let Some(known) = held::face(a, b, pose, margin, cache, scratch) {
        return known;
    }
    let axis = match held::edges(a, b, pose, margin, cache) {
        Some(known) => known?,
        None => axis(a, b, pose, margin, cache)?,
    };
    let m = contact(a, b, pose, margin, &axis, cache, scratch);
    if cache.kind == KIND_POINT {
        held::remember_edges(a, b, pose, &axis, cache);
    }
    m
}

/// The axis of the largest gap, `None` when the shapes are farther apart than `margin`.
pub(crate) fn axis(a: &Convex, b: &Convex, pose: &Pose, margin: f32, cache: &mut PairCache) -> Option<Axis> {
    let w = Difference { a: a.core, b: b.core, pose: *pose };
    let reach = a.radius + b.radius + margin;
    // Polyhedra that touched last time most likely overlap now, and then GJK tells nothing.
    if cache.kind != 0
        && let (Some(p), Some(q)) = (a.poly(), b.poly())
        && few_edges(&p, &q)
    {
        let x = separating_axis(&p, &q, pose, reach)?;
        if x.gap <= 0.0 || x.gap > reach {
            cache.axis = x.normal;
            if x.gap > reach {
                (cache.kind, cache.gap) = (0, x.gap - a.radius - b.radius);
            }
            return (x.gap <= reach).then_some(x);
        }
    }
    let found = match w.gjk(cache.axis, reach) {
        Gjk::Far(normal, gap) => {
            (cache.axis, cache.kind, cache.gap) = (normal, 0, gap - a.radius - b.radius);
            return None;
        }
        Gjk::Apart { distance, a: pa, b: pb, normal } if distance > 1e-3 * (a.radius + b.radius) => {
            Axis { normal, gap: distance, a: pa, b: pb, feature: 0 }
        }
        Gjk::Apart { distance, a: pa, b: pb, normal } => {
            let touching = Axis { normal, gap: distance, a: pa, b: pb, feature: 0 };
            overlapping(a, b, &w, reach, None).unwrap_or(touching)
        }
        Gjk::Overlap(s) => overlapping(a, b, &w, reach, Some(&s)).unwrap_or_else(|| {
            // Flat against flat: any direction does; the centres' is the likeliest.
            let normal = (pose.transform_point(b.center()) - a.center()).normalize_or(Vec3::Y);
            let p = a.core.support(normal);
            Axis { normal, gap: 0.0, a: p, b: p, feature: 0 }
        }),
    };
    cache.axis = found.normal;
    (found.gap <= reach).then_some(found)
}

/// The axis of cores that overlap, or touch from outside (no simplex: polyhedra name their features, for the others
/// GJK's direction is as good as its distance, and EPA needs an overlap).
fn overlapping(
    a: &Convex,
    b: &Convex,
    w: &Difference,
    reach: f32,
    simplex: Option<&Simplex>,
) -> Option<Axis> {
    let epa = || w.epa(simplex?).map(Axis::from);
    match (a.poly(), b.poly(), b.core) {
        (Some(p), Some(q), _) if few_edges(&p, &q) => separating_axis(&p, &q, &w.pose, reach),
        (Some(p), Some(q), _) => epa().or_else(|| separating_axis(&p, &q, &w.pose, reach)),
        (Some(p), _, Core::Segment(h)) => capsule::segment_axis(&p, capsule::ends(h, &w.pose)),
        (Some(p), _, Core::Point) => {
            let q = w.pose.p;
            let mut best: Option<Axis> = None;
            for (i, f) in p.real_faces().iter().enumerate() {
                let gap = f.normal.dot(q) - f.offset;
                if best.is_none_or(|b| gap > b.gap) {
                    best =
                        Some(Axis { normal: f.normal, gap, a: q - f.normal * gap, b: q, feature: i as u32 });
                }
            }
            best
        }
        _ => epa(),
    }
}

impl From<Penetration> for Axis {
    fn from(p: Penetration) -> Self {
        Self { normal: p.normal, gap: -p.depth, a: p.a, b: p.b, feature: 0 }
    }
}

/// How much worse than the axis a face may separate and still be taken, metres.
pub(crate) fn tolerance(a: &Convex, b: &Convex) -> f32 {
    f32s::min(1e-3 * f32s::min(a.thickness(), b.thickness()), 5e-4)
}

/// Points of the contact along `axis`.
pub(crate) fn contact(
    a: &Convex,
    b: &Convex,
    pose: &Pose,
    margin: f32,
    axis: &Axis,
    cache: &mut PairCache,
    scratch: &mut Scratch,
) -> Option<Manifold> {
    let tolerance = tolerance(a, b);
    let n = axis.normal;
    let local = pose.q.inverse_rotate(-n);
    let face_a = a.flat_face(n).map(|f| {
        let q = pose.transform_point(b.core.support(pose.q.inverse_rotate(-f.normal)));
        (f, f.normal.dot(q) - f.offset)
    });
    let face_b = b.flat_face(local).map(|f| {
        let q = pose.inverse_transform_point(a.core.support(-pose.q.rotate(f.normal)));
        (f, f.normal.dot(q) - f.offset)
    });
    let bonus = |kind| if cache.kind & KIND == kind { tolerance } else { 0.0 };
    let floor = axis.gap - tolerance;
    let score = |f: &Option<(FlatFace, f32)>, kind| f.map_or(f32::NEG_INFINITY, |f| f.1) + bonus(kind);
    let (sa, sb) = (score(&face_a, KIND_FACE_A), score(&face_b, KIND_FACE_B));
    let b_first = sb > sa + 0.5 * tolerance;
    let deepest = axis.gap - a.radius - b.radius;
    let good = |m: &Manifold| m.points().iter().any(|p| p.separation <= deepest + 2.0 * tolerance);
    let mut on = |from_b: bool, f: &FlatFace| {
        if !from_b {
            return face_contact(a, f, b, pose, margin, cache, scratch);
        }
        let inverse = pose.inverse();
        face_contact(b, f, a, &inverse, margin, cache, scratch).map(|m| m.flipped(&inverse))
    };
    for from_b in [b_first, !b_first] {
        let (face, score, kind) =
            if from_b { (&face_b, sb, KIND_FACE_B) } else { (&face_a, sa, KIND_FACE_A) };
        if let Some((f, _)) = face.as_ref().filter(|_| score >= floor)
            && let Some(m) = on(from_b, f).filter(good)
        {
            cache.kind = face_kind(kind, f.index);
            return Some(m);
        }
    }
    // Where the axis beats a face that lies along it all but exactly, the face may be worse beyond its own bounds alone: a box across an edge that is
    // longer than it is. It touches along the edge; one point would jump from one end of it to the other.
    let away = 0.5 * f32s::min(a.thickness(), b.thickness());
    for from_b in [b_first, !b_first] {
        let (face, n) = if from_b { (&face_b, local) } else { (&face_a, n) };
        if let Some((f, _)) =
            face.as_ref().filter(|(f, _)| lies_along(f.normal.dot(n), deepest, away, margin))
            && let Some(m) = on(from_b, f).filter(|m| holds_edges(m, deepest, tolerance))
        {
            cache.kind = KIND_POINT;
            return Some(m);
        }
    }
    cache.kind = KIND_POINT;
    if face_a.is_none()
        && face_b.is_none()
        && let Some(m) = parallel_edges(a, b, pose, margin, axis, scratch)
    {
        return Some(m);
    }
    witness(a, b, margin, axis)
}

/// One point between the witness points.
fn witness(a: &Convex, b: &Convex, margin: f32, axis: &Axis) -> Option<Manifold> {
    let n = axis.normal;
    let s = axis.gap - a.radius - b.radius;
    let point = (axis.a + n * a.radius + axis.b - n * b.radius) * 0.5;
    (s <= margin).then(|| super::one_point(n, point, s, 1 << 30 | axis.feature, 0))
}

/// Contact on flat face `face` of A, with what B shows to it. The normal is the face's.
pub(crate) fn face_contact(
    a: &Convex,
    face: &FlatFace,
    b: &Convex,
    pose: &Pose,
    margin: f32,
    cache: &mut PairCache,
    scratch: &mut Scratch,
) -> Option<Manifold> {
    let shown = clip_to_face(a, face, b, pose, scratch);
    gather(face, shown, (a.radius, b.radius), margin, cache, scratch)
}

/// Leaves flat face `face` of A, and in its bounds what B shows to it, in `scratch`. Gives the number of what B shows.
pub(crate) fn clip_to_face(
    a: &Convex,
    face: &FlatFace,
    b: &Convex,
    pose: &Pose,
    scratch: &mut Scratch,
) -> u32 {
    let n = face.normal;
    a.feature(n, &mut scratch.reference);
    let shown = b.feature(pose.q.inverse_rotate(-n), &mut scratch.incident);
    for c in &mut scratch.incident {
        c.p = pose.transform_point(c.p);
    }
    clip(n, scratch);
    shown
}

/// The same on the triangle of unit normal `n` of a surface. Since [`Scratch::forget`], `b` and `pose` must not have changed.
pub(crate) fn triangle_contact(
    (corners, n): (&[Vec3; 3], Vec3),
    b: &Convex,
    pose: &Pose,
    margin: f32,
    scratch: &mut Scratch,
) -> Option<Manifold> {
    scratch.reference.clear();
    let corner = |k: u16| Corner { p: corners[usize::from(k)], before: (k + 2) % 3, after: k };
    scratch.reference.extend([0, 1, 2].map(corner));
    let local = pose.q.inverse_rotate(-n);
    let known = b.face_shown(local);
    let shown = if known.is_some() && known == scratch.shown {
        scratch.incident.clone_from(&scratch.shown_corners);
        known.unwrap_or(0)
    } else {
        let shown = b.feature(local, &mut scratch.incident);
        for c in &mut scratch.incident {
            c.p = pose.transform_point(c.p);
        }
        scratch.shown = known;
        scratch.shown_corners.clone_from(&scratch.incident);
        shown
    };
    let face = FlatFace { normal: n, offset: n.dot(corners[0]), index: 0 };
    clip(n, scratch);
    gather(&face, shown, (0.0, b.radius), margin, &mut PairCache::default(), scratch)
}

impl Scratch {
    /// Another shape, or another pose.
    pub fn forget(&mut self) {
        self.shown = None;
    }
}

/// Cuts the incident polygon off at the sides of the reference polygon.
fn clip(n: Vec3, scratch: &mut Scratch) {
    let Scratch { reference, incident, other, .. } = scratch;
    match incident.len() {
        0 => {}
        1 | 2 => clip_segment(incident, reference, n),
        _ => clip_polygon(incident, other, reference, n),
    }
}

/// Contact of the clipped polygon with the reference polygon on `face`.
pub(crate) fn gather(
    face: &FlatFace,
    shown: u32,
    (ra, rb): (f32, f32),
    margin: f32,
    cache: &mut PairCache,
    scratch: &mut Scratch,
) -> Option<Manifold> {
    let Scratch { incident, points, .. } = scratch;
    let n = face.normal;
    points.clear();
    let tag = (face.index.wrapping_mul(0x2F) ^ shown.wrapping_mul(0x1D) << 3) & 0xFFF;
    for c in incident.iter() {
        let gap = n.dot(c.p) - face.offset;
        let separation = gap - ra - rb;
        if separation <= margin {
            let point = c.p - n * (0.5 * (gap + rb - ra));
            let feature = tag << 18 | u32::from(c.before & 0x1FF) << 9 | u32::from(c.after & 0x1FF);
            points.push(ManifoldPoint { point, separation, feature });
        }
    }
    if points.is_empty() {
        return None;
    }
    let mut m = Manifold { normal: n, faces: FACE_A, sub_a: NO_SUB, sub_b: NO_SUB, ..Manifold::default() };
    reduce(points, &mut m, cache);
    Some(m)
}

/// Sutherland–Hodgman against the planes through the reference polygon's sides.
fn clip_polygon(polygon: &mut Vec<Corner>, other: &mut Vec<Corner>, reference: &[Corner], n: Vec3) {
    for k in 0..reference.len() {
        let p = reference[k].p;
        let out = (reference[(k + 1) % reference.len()].p - p).cross(n);
        let over = |c: &Corner| out.dot(c.p - p);
        if polygon.iter().all(|c| over(c) <= 0.0) {
            continue;
        }
        let line = REFERENCE_LINE + k as u16;
        other.clear();
        for i in 0..polygon.len() {
            let (c, d) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            let (x, y) = (over(&c), over(&d));
            if x <= 0.0 {
                other.push(c);
            }
            if (x <= 0.0) != (y <= 0.0) {
                let (before, after) = if x <= 0.0 { (c.after, line) } else { (line, c.after) };
                other.push(Corner { p: c.p + (d.p - c.p) * (x / (x - y)), before, after });
            }
        }
        core::mem::swap(polygon, other);
        if polygon.is_empty() {
            return;
        }
    }
}

/// The same for a segment (whose ends keep their names) or a point.
fn clip_segment(ends: &mut Vec<Corner>, reference: &[Corner], n: Vec3) {
    let p0 = ends[0].p;
    let d = ends[ends.len() - 1].p - p0;
    let (mut t0, mut t1) = (0.0f32, 1.0f32);
    for k in 0..reference.len() {
        let p = reference[k].p;
        let side = reference[(k + 1) % reference.len()].p - p;
        let out = side.cross(n);
        let (x, dx) = (out.dot(p0 - p), out.dot(d));
        // Border points count as inside, or a point on the seam of two triangles would belong to neither.
        let slack = 1e-6 * side.length_squared();
        if dx.abs() <= 1e-6 * side.length() * d.length() {
            if x > slack {
                ends.clear();
                return;
            }
        } else if dx > 0.0 {
            t1 = f32s::min((slack - x) / dx, t1);
        } else {
            t0 = f32s::max((slack - x) / dx, t0);
        }
    }
    if t0 > t1 {
        ends.clear();
        return;
    }
    for (c, t) in ends.iter_mut().zip([t0, t1]) {
        c.p = p0 + d * t;
    }
    if t1 - t0 < 1e-3 {
        ends.truncate(1);
    }
}

/// Two straight edges side by side (capsules, sides of cylinders and cones): the ends of their common stretch.
fn parallel_edges(
    a: &Convex,
    b: &Convex,
    pose: &Pose,
    margin: f32,
    axis: &Axis,
    scratch: &mut Scratch,
) -> Option<Manifold> {
    let n = axis.normal;
    a.feature(n, &mut scratch.reference);
    b.feature(pose.q.inverse_rotate(-n), &mut scratch.incident);
    let ([p0, p1], [q0, q1]) = (&scratch.reference[..], &scratch.incident[..]) else { return None };
    let (p, u) = (p0.p, p1.p - p0.p);
    let (q, v) = (pose.transform_point(q0.p), pose.q.rotate(q1.p - q0.p));
    let (uu, uv, vv) = (u.length_squared(), u.dot(v), v.length_squared());
    if uv * uv < 0.9996 * uu * vv || u.dot(n).abs() > 0.02 * uu.sqrt() {
        return None;
    }
    let mut m = Manifold { normal: n, sub_a: NO_SUB, sub_b: NO_SUB, ..Manifold::default() };
    let reach = |x: Vec3| f32s::clamp(u.dot(x - p) / uu, 0.0, 1.0);
    let (s0, s1) = (reach(q), reach(q + v));
    if (s1 - s0).abs() < 0.05 {
        return None;
    }
    for (k, s) in [s0, s1].into_iter().enumerate() {
        let on_a = p + u * s;
        let on_b = q + v * (u.dot(on_a - q) / uv);
        let separation = n.dot(on_b - on_a) - a.radius - b.radius;
        if separation <= margin {
            let point = (on_a + n * a.radius + on_b - n * b.radius) * 0.5;
            m.points[usize::from(m.count)] = ManifoldPoint { point, separation, feature: k as u32 };
            m.count += 1;
        }
    }
    let deepest = axis.gap - a.radius - b.radius;
    (m.count == 2 && m.points().iter().any(|p| p.separation <= deepest + 2.0 * tolerance(a, b))).then_some(m)
}
