//! What a pair of polyhedra touched with last time, looked at before all directions are searched.
//!
//! With W = A − B the gap along a unit n is s(n) = −max n·w over W, and the contact's direction is the one of the largest
//! gap. Every point known to lie in W bounds all gaps from above. A face of A with the gap −d along its normal n is kept
//! where the points below leave no direction a gap beyond −d + T, T being what a face may be worse and still be taken; θ is
//! the direction's angle from n:
//!
//! - A point of B over the face, d' deep, gives the point d' n of W, so s ≤ −d' cos θ. Shapes that are apart, or no deeper than
//!   T/2, are done with this.
//! - Shifted on the face by ρ in all directions, that is a disc of W across n, d₂ deep, so s ≤ −d₂ cos θ − ρ sin θ; between
//!   the angle where the first bound ends and 90° it is greatest at one of the two, since −s is concave there.
//! - The balls inside A and B, of radii R together, give s ≤ e·n' − R for centres that lie e apart, at most |e across n| − R
//!   beyond 90° where e looks along n.
//!
//! ρ is the distance of the point from the face's sides, or the least width of the polygon in which A's face and B's
//! overlap: the differences of its points hold a disc of that radius. Two edges that cross make a parallelogram of W, for which
//! the same holds.

use super::capsule::segments;
use super::feature::{Convex, Corner, FlatFace};
use super::general::{self, KIND_EDGES, KIND_FACE_A, KIND_FACE_B, Scratch};
use super::hull_hull::Axis;
use super::poly::Poly;
use crate::{Manifold, PairCache};
use jounce_math::{Pose, Vec3, scalar::f32s};

/// Bits of [`PairCache::kind`] that say which kind; the number of a face, or those of two edges, stand above.
pub(crate) const KIND: u32 = 0xFF;

/// The cache's name of a face.
pub(crate) fn face_kind(kind: u32, face: u32) -> u32 {
    kind | face << 8
}

/// Contact on the face that was taken last time (`Some(None)`: it separates them), or `None` where that needs a search.
pub(crate) fn face(
    a: &Convex,
    b: &Convex,
    pose: &Pose,
    margin: f32,
    cache: &mut PairCache,
    scratch: &mut Scratch,
) -> Option<Option<Manifold>> {
    match cache.kind & KIND {
        KIND_FACE_A => {
            let m = on_face(a, b, pose, margin, cache, scratch)?;
            Some(m.ok())
        }
        KIND_FACE_B => {
            let inverse = pose.inverse();
            let m = on_face(b, a, &inverse, margin, cache, scratch)?;
            cache.axis = -pose.q.rotate(cache.axis);
            Some(m.ok().map(|m| m.flipped(&inverse)))
        }
        _ => None,
    }
}

/// They are farther apart than asked for.
struct Apart;

/// The same for a face of A. Leaves the face's normal as the cache's axis.
fn on_face(
    a: &Convex,
    b: &Convex,
    pose: &Pose,
    margin: f32,
    cache: &mut PairCache,
    scratch: &mut Scratch,
) -> Option<Result<Manifold, Apart>> {
    let (p, q) = (a.poly()?, b.poly()?);
    let index = cache.kind >> 8;
    let f = p.real_faces().get(index as usize)?;
    let face = FlatFace { normal: f.normal, offset: f.offset, index };
    let n = face.normal;
    let lowest = q.support(pose.q.inverse_rotate(-n));
    let gap = n.dot(pose.transform_point(q.vertices[lowest])) - face.offset;
    if gap > margin {
        *cache = PairCache { axis: n, kind: 0, gap, ..*cache };
        return Some(Err(Apart));
    }
    let shown = general::clip_to_face(a, &face, b, pose, scratch);
    let offset = pose.transform_point(b.center()) - a.center();
    let deep = Deep { depth: -gap, tolerance: general::tolerance(a, b), normal: n, offset };
    let inner = a.thickness() + b.thickness();
    let (deepest, least) = depths(&scratch.incident, &face)?;
    let discs = || {
        let room = inside(&scratch.reference, deepest.0, n);
        [(deepest.1, room), (least, width(&scratch.incident, n))]
    };
    if !deep.is_best(inner, deepest.1, discs) {
        return None;
    }
    let m = general::gather(&face, shown, (0.0, 0.0), margin, cache, scratch)?;
    cache.axis = n;
    Some(Ok(m))
}

/// A direction, and what lies in W along it and across.
struct Deep {
    /// −gap.
    depth: f32,
    tolerance: f32,
    normal: Vec3,
    /// From the middle of A's inner ball to that of B's.
    offset: Vec3,
}

impl Deep {
    /// Is there no direction with a gap greater by more than the tolerance? `depth` is that of a point of W on the normal, and
    /// `discs` lie across it, as depth and radius.
    fn is_best(&self, inner: f32, depth: f32, discs: impl FnOnce() -> [(f32, f32); 2]) -> bool {
        let least = self.depth - self.tolerance;
        if depth < least {
            return false;
        }
        if depth + least <= 0.0 {
            return true;
        }
        if least > 0.0 {
            let cos = least / depth;
            let sin = f32s::max(1.0 - cos * cos, 0.0).sqrt();
            let holds = |(d, r): (f32, f32)| r >= least && d * cos + r * sin >= least;
            if !discs().into_iter().any(holds) {
                return false;
            }
        }
        let along = self.offset.dot(self.normal);
        let across = (self.offset - self.normal * along).length();
        along >= 0.0 && across + least <= inner
    }
}

/// Of a clipped polygon the deepest point on the face with its depth, and the least depth.
fn depths(polygon: &[Corner], face: &FlatFace) -> Option<((Vec3, f32), f32)> {
    let depth = |c: &Corner| face.offset - face.normal.dot(c.p);
    let first = polygon.first()?;
    let mut deepest = (first.p, depth(first));
    let mut least = deepest.1;
    for c in &polygon[1..] {
        let d = depth(c);
        if d > deepest.1 {
            deepest = (c.p, d);
        }
        least = f32s::min(least, d);
    }
    Some((deepest, least))
}

/// How far inside the polygon's sides, seen along `n`.
fn inside(polygon: &[Corner], at: Vec3, n: Vec3) -> f32 {
    let mut room = f32::MAX;
    for k in 0..polygon.len() {
        let p = polygon[k].p;
        let Some((side, _)) = (polygon[(k + 1) % polygon.len()].p - p).try_normalize() else { continue };
        room = f32s::min(n.cross(side).dot(at - p), room);
    }
    room
}

/// Least width of a convex polygon seen along `n`: its height over one of its sides. 0 for what is no polygon.
fn width(polygon: &[Corner], n: Vec3) -> f32 {
    if polygon.len() < 3 {
        return 0.0;
    }
    let mut least = f32::MAX;
    for k in 0..polygon.len() {
        let p = polygon[k].p;
        let side = polygon[(k + 1) % polygon.len()].p - p;
        let Some((up, _)) = n.cross(side).try_normalize() else { continue };
        let height = polygon.iter().fold(0.0, |h, c| f32s::max(up.dot(c.p - p).abs(), h));
        least = f32s::min(least, height);
    }
    if least < f32::MAX { least } else { 0.0 }
}

/// The axis of the two edges that touched last time (`Some(None)`: it separates them), or `None` where that needs a search.
pub(crate) fn edges(
    a: &Convex,
    b: &Convex,
    pose: &Pose,
    margin: f32,
    cache: &mut PairCache,
) -> Option<Option<Axis>> {
    if cache.kind & KIND != KIND_EDGES {
        return None;
    }
    let (pa, pb) = (a.poly()?, b.poly()?);
    let (i, j) = (cache.kind >> 8 & 0x3FF, cache.kind >> 18);
    let (ea, eb) = (pa.edges.get(i as usize)?, pb.edges.get(j as usize)?);
    let at = |k: u16| pa.vertices[usize::from(k)];
    let (p, u) = (at(ea.a), at(ea.b) - at(ea.a));
    let at = |k: u16| pose.transform_point(pb.vertices[usize::from(k)]);
    let (q, v) = (at(eb.a), at(eb.b) - at(eb.a));
    let (uu, vv) = (u.length_squared(), v.length_squared());
    let n = u.cross(v);
    let nn = n.length_squared();
    if nn <= 1e-4 * uu * vv {
        return None;
    }
    let area = nn.sqrt();
    let n = n * (1.0 / area);
    let out = pa.faces[usize::from(ea.left)].normal + pa.faces[usize::from(ea.right)].normal;
    let n = if n.dot(out) < 0.0 { -n } else { n };
    let far = pa.vertices[pa.support(n)];
    let near = pose.transform_point(pb.vertices[pb.support(pose.q.inverse_rotate(-n))]);
    let apart = n.dot(near - far);
    if apart > margin {
        *cache = PairCache { axis: n, kind: 0, gap: apart, ..*cache };
        return Some(None);
    }
    let gap = n.dot(q - p);
    let tolerance = general::tolerance(a, b);
    // The shapes must not reach over the edges.
    if gap - apart > 0.1 * tolerance {
        return None;
    }
    let (s, t) = segments(p, u, q, v);
    let within = |x: f32| f32s::min(x, 1.0 - x);
    let room = f32s::min(within(s) * area / vv.sqrt(), within(t) * area / uu.sqrt());
    if room <= 0.0 {
        return None;
    }
    let offset = pose.transform_point(b.center()) - a.center();
    let deep = Deep { depth: -gap, tolerance, normal: n, offset };
    if !deep.is_best(a.thickness() + b.thickness(), -gap, || [(-gap, room); 2]) {
        return None;
    }
    cache.axis = n;
    let feature = if gap <= 0.0 && general::few_edges(&pa, &pb) { 1 << 20 | i << 10 | j } else { 0 };
    Some(Some(Axis { normal: n, gap, a: p + u * s, b: q + v * t, feature }))
}

/// Names the edges that touch along `axis` for the next time, if any.
pub(crate) fn remember_edges(a: &Convex, b: &Convex, pose: &Pose, axis: &Axis, cache: &mut PairCache) {
    let (Some(p), Some(q)) = (a.poly(), b.poly()) else { return };
    let (i, j) = (edge_along(&p, axis.normal), edge_along(&q, pose.q.inverse_rotate(-axis.normal)));
    cache.kind = KIND_EDGES | i << 8 | j << 18;
}

/// The edge of which both ends are farthest along `n`.
fn edge_along(p: &Poly, n: Vec3) -> u32 {
    let (mut best, mut far) = (0, f32::NEG_INFINITY);
    for (k, e) in (0..).zip(p.edges) {
        let height = |v: u16| p.vertices[usize::from(v)].dot(n);
        let h = f32s::min(height(e.a), height(e.b));
        if h > far {
            (best, far) = (k, h);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::super::hull_hull::separating_axis;
    use super::super::random::Random;
    use super::*;
    use crate::{Hull, Shape, distance};
    use jounce_math::Quat;
    use std::sync::Arc;

    fn hull(r: &mut Random) -> Shape {
        let half = Vec3::new(1.0, 0.4 + 0.5 * r.next().abs(), 0.8);
        let mut point = || {
            let d = r.vec().normalize_or(Vec3::Y);
            Vec3::new(d.x * half.x, d.y * half.y, d.z * half.z)
        };
        let points: Vec<Vec3> = (0..12).map(|_| point()).collect();
        Shape::Hull(Arc::new(Hull::new(&points).expect("points all around")))
    }

    const MARGIN: f32 = 0.02;

    /// A kept direction's gap is the greatest but for the tolerance, over random walks of two shapes that touch. Gives how often
    /// one was kept, and how often it was searched for.
    fn walk(seed: u32, deepest: f32) -> (usize, usize) {
        let mut rng = Random(seed);
        let cube = Shape::Box { half: Vec3::new(0.6, 0.4, 0.8) };
        let (a, b) = (hull(&mut rng), if seed.is_multiple_of(3) { cube } else { hull(&mut rng) });
        let (x, y) = (Convex::of(&a).expect("convex"), Convex::of(&b).expect("convex"));
        let (p, q) = (x.poly().expect("flat faces"), y.poly().expect("flat faces"));
        let mut scratch = Scratch::default();
        let mut cache = PairCache::default();
        let (mut kept, mut searched) = (0, 0);
        let start = rng.vec().normalize_or(Vec3::Y) * 2.5;
        let mut pose = Pose::new(start, Quat::IDENTITY.integrate(rng.vec()));
        for step in 0..400 {
            pose.q = pose.q.integrate(rng.vec() * 0.03);
            // Together, until they are as deep as wanted, then apart.
            let best = separating_axis(&p, &q, &pose, f32::MAX).expect("faces");
            let apart = distance(&a, &b, &pose, f32::MAX).expect("convex").distance;
            let best = f32s::max(best.gap, if apart > 0.0 { apart } else { f32::NEG_INFINITY });
            let tolerance = general::tolerance(&x, &y);
            let along = |n: Vec3| {
                let near = pose.transform_point(y.core.support(pose.q.inverse_rotate(-n)));
                n.dot(near - x.core.support(n))
            };
            let mut known = cache;
            let found = match face(&x, &y, &pose, MARGIN, &mut known, &mut scratch) {
                Some(m) => Some(m.map(|m| m.normal)),
                None => edges(&x, &y, &pose, MARGIN, &mut known).map(|e| e.map(|e| e.normal)),
            };
            match found {
                Some(Some(n)) => {
                    kept += 1;
                    let lost = best - along(n);
                    assert!(lost <= 1.1 * tolerance + 1e-5, "{seed}, {step}: {lost} of {best}");
                }
                Some(None) => assert!(best > MARGIN - 1e-5, "{seed}, {step}: {best}"),
                None if best < MARGIN => searched += 1,
                None => {}
            }
            let m = general::convex(&x, &y, &pose, MARGIN, &mut cache, &mut scratch);
            assert_eq!(m.is_some(), best <= MARGIN, "{seed}, {step}: {best}");
            let way = if best > -deepest { -0.01 } else { 0.02 };
            pose.p += pose.p.normalize_or(Vec3::Y) * way + rng.vec() * 0.01;
        }
        (kept, searched)
    }

    #[test]
    fn what_is_kept_is_as_good_as_what_is_found() {
        let (mut kept, mut searched) = (0, 0);
        for seed in 1..60 {
            let (k, s) = walk(seed, [0.005, 0.02, 0.3][seed as usize % 3]);
            (kept, searched) = (kept + k, searched + s);
        }
        assert!(kept > searched / 2, "{kept} kept, {searched} searched");
    }

    #[test]
    fn room_and_width_of_a_square() {
        let corner = |x: f32, z: f32| Corner { p: Vec3::new(x, 0.0, z), before: 0, after: 0 };
        // Counter-clockwise from above.
        let square = [corner(0.0, 0.0), corner(0.0, 1.0), corner(2.0, 1.0), corner(2.0, 0.0)];
        assert_eq!(inside(&square, Vec3::new(1.5, 0.3, 0.25), Vec3::Y), 0.25);
        assert_eq!(inside(&square, Vec3::new(2.5, 0.3, 0.25), Vec3::Y), -0.5);
        assert_eq!(width(&square, Vec3::Y), 1.0);
        assert_eq!(width(&square[..2], Vec3::Y), 0.0);
    }

    /// A ball's worth of room, a disc's, or none: the bounds of the head of this file at their borders.
    #[test]
    fn bounds_hold_at_their_borders() {
        let deep = |depth: f32, across: f32| Deep {
            depth,
            tolerance: 0.01,
            normal: Vec3::Y,
            offset: Vec3::new(across, 1.0, 0.0),
        };
        let none = || [(f32::NEG_INFINITY, 0.0); 2];
        assert!(deep(-0.1, 9.0).is_best(0.0, -0.1, none));
        assert!(deep(0.004, 9.0).is_best(0.0, 0.004, none));
        assert!(!deep(0.1, 0.0).is_best(1.0, 0.1, none));
        assert!(deep(0.1, 0.0).is_best(1.0, 0.1, || [(0.1, 0.0901); 2]));
        assert!(!deep(0.1, 0.0).is_best(1.0, 0.1, || [(0.1, 0.0899); 2]));
        assert!(deep(0.1, 0.9).is_best(1.0, 0.1, || [(0.1, 0.0901); 2]));
        assert!(!deep(0.1, 0.92).is_best(1.0, 0.1, || [(0.1, 0.0901); 2]));
        assert!(!deep(0.1, 0.0).is_best(1.0, 0.08, || [(0.1, 0.2); 2]), "no point on the normal");
    }
}
