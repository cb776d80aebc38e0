//! Box against box: from the axis that decides ([`super::box_axes`]) to a clipped face or one edge point.
//!
//! A face contact clips the other box's most opposed face against the sides of the reference face (I. Sutherland,
//! G. Hodgman, 1974), in two dimensions plus depth.

use super::box_axes::{self, BoxAxis};
use super::capsule::segments;
use super::general::{holds_edges, lies_along};
use super::one_point;
use super::reduce::reduce;
use super::wide::PairRow;
use crate::convex::core::{Core, sign};
use crate::convex::gjk::{Difference, Gjk};
use crate::{FACE_A, FACE_B, Manifold, ManifoldPoint, NO_SUB, PairCache};
use jounce_lanes::Width;
use jounce_math::{Mat3, Pose, Vec3, scalar::f32s};

/// Longest polygon: four corners and one more for each of four cuts.
const POLYGON_MAX: usize = 8;

/// Which axis the last test found.
fn known(cache: &PairCache) -> Option<u32> {
    cache.kind.checked_sub(1)
}

/// The pair of box A (half extents `ha`) and box B (`hb`) at `pose`, whose axis is to be found.
pub(super) fn row(ha: Vec3, hb: Vec3, pose: &Pose, margin: f32, cache: &PairCache) -> PairRow {
    box_axes::row([ha, hb], pose, margin, known(cache))
}

/// Their contact.
pub(super) fn box_box(row: &PairRow, cache: &mut PairCache) -> Option<Manifold> {
    let mut axis = [BoxAxis::default()];
    box_axes::find(Width::X1, core::slice::from_ref(row), &mut axis);
    at_axis(row, &axis[0], cache)
}

/// The same where the axis is found already.
pub(super) fn at_axis(row: &PairRow, axis: &BoxAxis, cache: &mut PairCache) -> Option<Manifold> {
    let Some(number) = axis.number else {
        cache.gap = axis.gap;
        return None;
    };
    let (ha, hb, pose, margin) = (row.a(), row.b(), &row.pose(), row.margin());
    let r = pose.q.to_mat3();
    cache.kind = 1 + number;
    let m = match number.checked_sub(6) {
        Some(k) => {
            let m = edge_contact(ha, hb, &r, pose.p, k as usize, axis.gap);
            m.map(|m| across(ha, hb, &r, pose.p, margin, &m, cache).unwrap_or(m))
        }
        None => face_contact(ha, hb, &r, pose.p, number as usize, margin, cache),
    };
    m.or_else(|| corner_contact(ha, hb, pose, margin))
}

fn edge_contact(ha: Vec3, hb: Vec3, r: &Mat3, p: Vec3, k: usize, gap: f32) -> Option<Manifold> {
    let (i, j) = (k / 3, k % 3);
    let columns = [r.cx, r.cy, r.cz];
    let mut e = Vec3::ZERO;
    e[i] = 1.0;
    let n = e.cross(columns[j]).try_normalize()?.0;
    let n = n * sign(n.dot(p));
    let mut id = (1 << 16) | (k as u32) << 6;
    let mut a = Vec3::ZERO;
    let mut b = p;
    for x in 0..3 {
        if x != i {
            let s = sign(n[x]);
            a[x] = s * ha[x];
            id |= u32::from(s > 0.0) << x;
        }
        if x != j {
            let s = -sign(n.dot(columns[x]));
            b += columns[x] * (s * hb[x]);
            id |= u32::from(s > 0.0) << (3 + x);
        }
    }
    let (da, db) = (e * (2.0 * ha[i]), columns[j] * (2.0 * hb[j]));
    let (a, b) = (a - e * ha[i], b - columns[j] * hb[j]);
    let (s, t) = segments(a, da, b, db);
    let (qa, qb) = (a + da * s, b + db * t);
    // Apart, and nearest at an end: no edge pair.
    if gap > 0.0 && (qb - qa).length_squared() > 1.0002 * gap * gap + 1e-12 {
        return None;
    }
    Some(one_point(n, (qa + qb) * 0.5, gap, id, 0))
}

/// A box across an edge that is longer than it is: the face lies along the axis of two edges all but exactly, and is worse beyond its own bounds alone. It
/// touches along the edge; one point would jump from one end of it to the other.
fn across(
    ha: Vec3,
    hb: Vec3,
    r: &Mat3,
    p: Vec3,
    margin: f32,
    edge: &Manifold,
    cache: &mut PairCache,
) -> Option<Manifold> {
    let (normal, deepest) = (edge.normal, edge.points[0].separation);
    // Half the thickness, which is the least half extent, as for other shapes.
    let away = 0.5 * f32s::min(ha.min_component(), hb.min_component());
    [(0, normal), (3, r.transpose_mul(normal))].into_iter().find_map(|(first, n)| {
        let i = n.abs().max_axis();
        if !lies_along(n[i].abs(), deepest, away, margin) {
            return None;
        }
        let m = face_contact(ha, hb, r, p, first + i, margin, cache);
        let tolerance = box_axes::tolerance(ha, hb);
        m.filter(|m| m.normal.dot(normal) > 0.0 && holds_edges(m, deepest, tolerance))
    })
}

/// A corner of the clipped polygon: position in the reference face, height over it, and the lines that meet there
/// (0–3 edges of the incident face, 4–7 sides of the reference face).
#[derive(Clone, Copy, Default)]
struct Corner {
    x: f32,
    y: f32,
    d: f32,
    before: u8,
    after: u8,
}

fn face_contact(
    ha: Vec3,
    hb: Vec3,
    r: &Mat3,
    p: Vec3,
    axis: usize,
    margin: f32,
    cache: &mut PairCache,
) -> Option<Manifold> {
    if axis < 3 {
        return clip_faces(ha, hb, r, p, axis, margin, 0, cache);
    }
    let m = clip_faces(hb, ha, &r.transpose(), -r.transpose_mul(p), axis - 3, margin, 1, cache)?;
    let mut m = Manifold { normal: -(*r * m.normal), faces: FACE_B, ..m };
    for q in &mut m.points[..usize::from(m.count)] {
        q.point = *r * q.point + p;
    }
    Some(m)
}

/// The reference box has half extents `h`; the incident box `hi` with axes `r` at `p` in the reference frame.
fn clip_faces(
    h: Vec3,
    hi: Vec3,
    r: &Mat3,
    p: Vec3,
    i: usize,
    margin: f32,
    which: u32,
    cache: &mut PairCache,
) -> Option<Manifold> {
    let (u, v) = ((i + 1) % 3, (i + 2) % 3);
    let side = sign(p[i]);
    let row = Vec3::new(r.cx[i], r.cy[i], r.cz[i]) * side;
    let j = row.abs().max_axis();
    let columns = [r.cx, r.cy, r.cz];
    let (ju, jv) = ((j + 1) % 3, (j + 2) % 3);
    let c = p - columns[j] * (sign(row[j]) * hi[j]);
    let (eu, ev) = (columns[ju] * hi[ju], columns[jv] * hi[jv]);
    let corner =
        |q: Vec3, k: u8| Corner { x: q[u], y: q[v], d: side * q[i] - h[i], before: (k + 3) & 3, after: k };
    let mut polygon = [Corner::default(); POLYGON_MAX];
    polygon[0] = corner(c + eu + ev, 0);
    polygon[1] = corner(c - eu + ev, 1);
    polygon[2] = corner(c - eu - ev, 2);
    polygon[3] = corner(c + eu - ev, 3);
    let mut n = 4;
    n = clip(&mut polygon, n, |q| q.x - h[u], 4);
    n = clip(&mut polygon, n, |q| q.y - h[v], 5);
    n = clip(&mut polygon, n, |q| -q.x - h[u], 6);
    n = clip(&mut polygon, n, |q| -q.y - h[v], 7);
    let face = 2 * i as u32 + u32::from(side > 0.0);
    let opposite = 2 * j as u32 + u32::from(row[j] < 0.0);
    let tag = which << 12 | face << 9 | opposite << 6;
    let mut normal = Vec3::ZERO;
    normal[i] = side;
    let mut points = [ManifoldPoint::default(); POLYGON_MAX];
    let mut count = 0;
    for q in &polygon[..n] {
        if q.d <= margin {
            let mut point = Vec3::ZERO;
            (point[u], point[v], point[i]) = (q.x, q.y, side * (h[i] + 0.5 * q.d));
            let feature = tag | u32::from(q.before) << 3 | u32::from(q.after);
            points[count] = ManifoldPoint { point, separation: q.d, feature };
            count += 1;
        }
    }
    if count == 0 {
        return None;
    }
    let mut m = Manifold { normal, faces: FACE_A, sub_a: NO_SUB, sub_b: NO_SUB, ..Manifold::default() };
    reduce(&points[..count], &mut m, cache);
    Some(m)
}

/// Cuts off what has positive `over`; `side` names the cutting line. Convex polygons only, so there are at most two
/// crossings.
#[inline(always)]
fn clip(polygon: &mut [Corner; POLYGON_MAX], n: usize, over: impl Fn(&Corner) -> f32, side: u8) -> usize {
    if n == 0 || polygon[..n].iter().all(|q| over(q) <= 0.0) {
        return n;
    }
    let old = *polygon;
    let mut count = 0;
    let mut put = |q: Corner| {
        if count < POLYGON_MAX {
            polygon[count] = q;
            count += 1;
        }
    };
    for k in 0..n {
        let (a, b) = (&old[k], &old[if k + 1 == n { 0 } else { k + 1 }]);
        let (da, db) = (over(a), over(b));
        if da <= 0.0 {
            put(*a);
        }
        if (da <= 0.0) != (db <= 0.0) {
            let t = da / (da - db);
            let (before, after) = if da <= 0.0 { (a.after, side) } else { (side, a.after) };
            put(Corner {
                x: a.x + (b.x - a.x) * t,
                y: a.y + (b.y - a.y) * t,
                d: a.d + (b.d - a.d) * t,
                before,
                after,
            });
        }
    }
    count
}

/// Apart, with a corner nearest to the other box: the one pair of closest points.
fn corner_contact(ha: Vec3, hb: Vec3, pose: &Pose, margin: f32) -> Option<Manifold> {
    let w = Difference { a: Core::Box(ha), b: Core::Box(hb), pose: *pose };
    match w.gjk(Vec3::ZERO, margin) {
        Gjk::Apart { distance, a, b, normal } if distance <= margin => {
            Some(one_point(normal, (a + b) * 0.5, distance, 1 << 17, 0))
        }
        _ => None,
    }
}
