//! Capsules and balls against one another, several pairs at a time, and the separating axes of a segment that cuts a polyhedron.

use super::hull_hull::Axis;
use super::one_point;
use super::poly::Poly;
use super::wide::{PairRow, Pairs};
use crate::{Manifold, ManifoldPoint, PairCache};
use jounce_lanes::{Array, Kernel, Lanes, Wide3, Width, dispatch};
use jounce_math::{Pose, Vec3, scalar::f32s};

/// Axes closer to each other than this (cosine; 1.1°) are parallel.
const PARALLEL_COSINE: f32 = 0.9998;

/// Where segments are nearly parallel, the points found of them are farther apart than the closest ones, by less than this part of the shorter
/// segment: below sin² of 1e-7 the middle is taken, where one of the ends may be nearer.
const PARALLEL_ERROR: f32 = 1e-3;

/// Parameters s, t in 0…1 of the closest points p1 + s d1 and p2 + t d2.
pub(crate) fn segments(p1: Vec3, d1: Vec3, p2: Vec3, d2: Vec3) -> (f32, f32) {
    let wide = |v: Vec3| {
        let [x, y, z] = [v.x, v.y, v.z].map(Array::<1>::splat);
        Wide3::new(x, y, z)
    };
    let (s, t) = segments_in(wide(p1), wide(d1), wide(p2), wide(d2));
    let mut out = [0.0; 2];
    s.store(&mut out[..1]);
    t.store(&mut out[1..]);
    (out[0], out[1])
}

/// The same in lanes.
#[inline(always)]
fn segments_in<L: Lanes>(p1: Wide3<L>, d1: Wide3<L>, p2: Wide3<L>, d2: Wide3<L>) -> (L, L) {
    let (zero, one, tiny) = (L::zero(), L::splat(1.0), L::splat(f32::MIN_POSITIVE));
    let r = p1.sub(p2);
    let (a, e, f) = (d1.dot(d1), d2.dot(d2), d2.dot(r));
    let (b, c) = (d1.dot(d2), d1.dot(r));
    let (is_point_1, is_point_2) = (a.le(tiny), e.le(tiny));
    let denominator = a * e - b * b;
    let crossing = denominator.gt(L::splat(1e-7) * a * e);
    let s = L::select(crossing, clamp((b * f - c * e) / denominator), L::splat(0.5));
    let t = (b * s + f) / e;
    let inside = t.ge(zero) & t.le(one);
    let t = L::select(inside, t, clamp(t));
    let s = L::select(inside, s, clamp((b * t - c) / a));
    // A point, or two.
    let s = L::select(is_point_2, clamp(-c / a), s);
    let t = L::select(is_point_1, clamp(f / e), t);
    (L::select(is_point_1, zero, s), L::select(is_point_2, zero, t))
}

#[inline(always)]
fn clamp<L: Lanes>(x: L) -> L {
    x.max(L::zero()).min(L::splat(1.0))
}

/// The closest points of two capsules' segments. A's is on its axis, y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Nearest {
    a: f32,
    b: Vec3,
    /// Unit, of B's segment.
    axis: Vec3,
    /// What the capsules are apart at least, m, where that is more than the margin.
    apart: Option<f32>,
}

/// The pair of two capsules by half heights and radii; balls have no height.
pub(super) fn row([(ha, ra), (hb, rb)]: [(f32, f32); 2], pose: &Pose, margin: f32) -> PairRow {
    PairRow::new(pose, margin, Vec3::new(ha, ra, 0.0), Vec3::new(hb, rb, 0.0), 0.0)
}

/// The closest points of every pair.
///
/// # Panics
/// Where `nearest` is not as long as `rows`.
pub(super) fn find(width: Width, rows: &[PairRow], nearest: &mut [Nearest]) {
    assert_eq!(rows.len(), nearest.len(), "a place for each pair's points");
    dispatch(width, Find { rows, nearest });
}

struct Find<'a> {
    rows: &'a [PairRow],
    nearest: &'a mut [Nearest],
}

impl Kernel for Find<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (rows, nearest) in self.rows.chunks(L::WIDTH).zip(self.nearest.chunks_mut(L::WIDTH)) {
            let columns = nearest_in(&Pairs::<L>::load(rows));
            L::scatter8(
                columns,
                #[inline(always)]
                |lane, [a, x, y, z, u, v, w, apart]| {
                    if let Some(to) = nearest.get_mut(lane) {
                        let (b, axis) = (Vec3::new(x, y, z), Vec3::new(u, v, w));
                        *to = Nearest { a, b, axis, apart: (apart > f32::NEG_INFINITY).then_some(apart) };
                    }
                },
            );
        }
    }
}

#[inline(always)]
fn nearest_in<L: Lanes>(pairs: &Pairs<L>) -> [L; 8] {
    let Pairs { p, q, margin, a: Wide3 { x: ha, y: ra, .. }, b: Wide3 { x: hb, y: rb, .. }, .. } = *pairs;
    let (zero, two) = (L::zero(), L::splat(2.0));
    let axis = q.rotate_y();
    let (p1, d1) = (Wide3::new(zero, -ha, zero), Wide3::new(zero, two * ha, zero));
    let (p2, d2) = (p.sub(axis.scale(hb)), axis.scale(two * hb));
    let (s, t) = segments_in(p1, d1, p2, d2);
    let (a, b) = (p1.y + d1.y * s, p2.add(d2.scale(t)));
    let d = Wide3::new(b.x, b.y - a, b.z);
    let squared = d.dot(d);
    let reach = ra + rb + margin;
    let gap = squared.sqrt() - ra - rb - L::splat(2.0 * PARALLEL_ERROR) * ha.min(hb);
    let apart = L::select(squared.gt(reach * reach), gap.max(L::zero()), L::splat(f32::NEG_INFINITY));
    [a, b.x, b.y, b.z, axis.x, axis.y, axis.z, apart]
}

/// The contact of two capsules, or balls.
pub(super) fn capsules(row: &PairRow, cache: &mut PairCache) -> Option<Manifold> {
    let mut nearest = [Nearest::default()];
    find(Width::X1, core::slice::from_ref(row), &mut nearest);
    at_points(row, &nearest[0], cache)
}

/// The same where the closest points are found already.
pub(super) fn at_points(row: &PairRow, near: &Nearest, cache: &mut PairCache) -> Option<Manifold> {
    if let Some(gap) = near.apart {
        cache.gap = gap;
        return None;
    }
    let (Vec3 { x: ha, y: ra, .. }, Vec3 { x: hb, y: rb, .. }, margin) = (row.a(), row.b(), row.margin());
    let (axis, a) = (near.axis, Vec3::new(0.0, near.a, 0.0));
    // What touches where axes cross has no direction: their common perpendicular parts them.
    let Some((n, distance)) = (near.b - a).try_normalize() else {
        let n = if ha + hb > 0.0 { Vec3::Y.cross(axis).normalize_or(Vec3::X) } else { Vec3::Y };
        return Some(one_point(n, a + n * (0.5 * (ra - rb)), -ra - rb, 0, 0));
    };
    // Nearly parallel: two points at the ends of the common stretch.
    if axis.y.abs() > PARALLEL_COSINE && n.y.abs() < 0.02 {
        let (p2, d2) = (row.pose().p - axis * hb, axis * (2.0 * hb));
        if let Some(m) = parallel(ha, ra, (p2, d2), rb, n, margin) {
            return Some(m);
        }
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
