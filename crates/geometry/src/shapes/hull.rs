//! Convex polyhedron.
//!
//! Mass properties are the sum over the tetrahedra (reference point, a, b, c) of the faces' triangles, signed by
//! the side of the reference point. With det = a·(b × c): volume det/6, ∫x = det/24 (a + b + c) and
//! ∫x xᵀ = det/120 (a aᵀ + b bᵀ + c cᵀ + s sᵀ), s = a + b + c. I = tr(C) 1 − C for the covariance C.

use super::{Hit, MassProperties, PointHit, triangle};
use crate::{Aabb, Hull, HullFace, NO_SUB};
use jounce_math::{DMat3, DVec3, Pose, Vec3};

pub(super) fn aabb(hull: &Hull, pose: &Pose) -> Aabb {
    let b = hull.corners.bounds(&pose.q.to_mat3());
    Aabb::new(b.min + pose.p, b.max + pose.p)
}

/// Mass, centre and inertia about the centre, in `f64`.
pub(crate) fn mass_f64(hull: &Hull, density: f64) -> (f64, DVec3, DMat3) {
    // About the middle of the bounds: sums about a far origin would cancel.
    let origin = hull.aabb.center().as_dvec3();
    let (mut six_v, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for face in &hull.faces {
        let corners = hull.face_vertices(face);
        let at = |k: usize| hull.vertices[usize::from(corners[k])].as_dvec3() - origin;
        let a = at(0);
        for k in 2..corners.len() {
            let (b, c) = (at(k - 1), at(k));
            let det = a.dot(b.cross(c));
            let s = a + b + c;
            six_v += det;
            first += s * det;
            let sum = DMat3::outer(a, a) + DMat3::outer(b, b) + DMat3::outer(c, c) + DMat3::outer(s, s);
            second = second + sum.scale(det);
        }
    }
    let c = first * (1.0 / (4.0 * six_v));
    let mass = density * six_v / 6.0;
    let covariance = second.scale(density / 120.0) - DMat3::outer(c, c).scale(mass);
    let trace = covariance.cx.x + covariance.cy.y + covariance.cz.z;
    (mass, c + origin, DMat3::from_diagonal(DVec3::splat(trace)) - covariance)
}

pub(super) fn mass(hull: &Hull, density: f64) -> MassProperties {
    let (mass, center, inertia) = mass_f64(hull, density);
    MassProperties::from_f64(mass, center, inertia)
}

/// The ray's interval inside all face planes (Cyrus and Beck).
pub(super) fn ray(hull: &Hull, origin: Vec3, dir: Vec3, max_t: f32) -> Option<Hit> {
    let (mut t0, mut t1) = (f32::NEG_INFINITY, f32::INFINITY);
    let mut normal = -dir;
    for f in &hull.faces {
        let height = f.normal.dot(origin) - f.offset;
        let rise = f.normal.dot(dir);
        if rise == 0.0 {
            if height > 0.0 {
                return None;
            }
            continue;
        }
        let t = -height / rise;
        if rise < 0.0 {
            if t > t0 {
                (t0, normal) = (t, f.normal);
            }
        } else if t < t1 {
            t1 = t;
        }
        if t0 > t1 {
            return None;
        }
    }
    if t1 <= 0.0 || t0 > max_t {
        return None;
    }
    Some(if t0 < 0.0 { Hit::inside(dir) } else { Hit { t: t0, normal, sub: NO_SUB } })
}

pub(super) fn closest(hull: &Hull, point: Vec3) -> PointHit {
    let mut best = PointHit { point, distance: f32::NEG_INFINITY, normal: Vec3::Y, sub: NO_SUB };
    let mut best_face = None;
    for f in &hull.faces {
        let height = f.normal.dot(point) - f.offset;
        if height > best.distance {
            best.distance = height;
            best.normal = f.normal;
            best_face = Some(f);
        }
    }
    // Inside, or straight above a face: its own normal is exact however near the point is.
    best.point = point - best.normal * best.distance;
    if best.distance <= 0.0 || best_face.is_some_and(|f| holds(hull, f, point)) {
        return best;
    }
    // Outside: the nearest point lies on a face that the point is in front of.
    let (mut d2_min, face_normal) = (f32::INFINITY, best.normal);
    for f in hull.faces.iter().filter(|f| f.normal.dot(point) > f.offset) {
        let corners = hull.face_vertices(f);
        for k in 2..corners.len() {
            let q = triangle::closest_point(
                &[0, k - 1, k].map(|k| hull.vertices[usize::from(corners[k])]),
                point,
            );
            let d2 = (point - q).length_squared();
            if d2 < d2_min {
                (d2_min, best.point) = (d2, q);
            }
        }
    }
    // Of a gap near rounding the direction means nothing.
    let noise = 1e-6 * (hull.aabb.max - hull.aabb.min).max_component();
    (best.normal, best.distance) = match (point - best.point).try_normalize() {
        Some((n, d)) if d > noise => (n, d),
        other => (face_normal, other.map_or(0.0, |(_, d)| d)),
    };
    best
}

/// Is the point above or below the inside of a face?
fn holds(hull: &Hull, face: &HullFace, point: Vec3) -> bool {
    let corners = hull.face_vertices(face);
    let mut a = hull.vertices[usize::from(corners[corners.len() - 1])];
    corners.iter().all(|&c| {
        let b = hull.vertices[usize::from(c)];
        let left = face.normal.cross(b - a).dot(point - a) >= 0.0;
        a = b;
        left
    })
}
