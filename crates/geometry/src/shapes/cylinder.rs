//! Solid cylinder of radius r from −h to +h along y.
//!
//! m = ρ π r² 2h, I_yy = m r²/2, I_xx = I_zz = m (r²/4 + h²/3).

use super::{Hit, MassProperties, PointHit, radial};
use crate::{Aabb, NO_SUB};
use core::f64::consts::PI;
use jounce_math::{DVec3, Pose, Vec3, scalar::f32s};

/// Half extent of a disc of radius r whose plane is spanned by the unit vectors u, v: r √(u_i² + v_i²).
pub(super) fn disc_half(u: Vec3, v: Vec3, radius: f32) -> Vec3 {
    let s = u.mul(u) + v.mul(v);
    Vec3::new(s.x.sqrt(), s.y.sqrt(), s.z.sqrt()) * radius
}

pub(super) fn aabb(half_height: f32, radius: f32, pose: &Pose) -> Aabb {
    let m = pose.q.to_mat3();
    Aabb::from_center(pose.p, m.cy.abs() * half_height + disc_half(m.cx, m.cz, radius))
}

pub(super) fn mass(half_height: f32, radius: f32, density: f64) -> MassProperties {
    let (h, r) = (f64::from(half_height), f64::from(radius));
    let m = density * PI * r * r * 2.0 * h;
    let ixx = m * (0.25 * r * r + h * h / 3.0);
    MassProperties::from_diagonal(m, DVec3::ZERO, DVec3::new(ixx, 0.5 * m * r * r, ixx))
}

/// Volume and centroid.
pub(super) fn volume(half_height: f32, radius: f32) -> (f64, DVec3) {
    let (h, r) = (f64::from(half_height), f64::from(radius));
    (PI * r * r * 2.0 * h, DVec3::ZERO)
}

/// The ray's interval inside the slab |y| ≤ h, cut with its interval inside the infinite cylinder; in `f64`,
/// since the quadratic cancels for near-axial rays.
pub(super) fn ray(half_height: f32, radius: f32, origin: Vec3, dir: Vec3, max_t: f32) -> Option<Hit> {
    let (o, d) = (origin.as_dvec3(), dir.as_dvec3());
    let (h, r) = (f64::from(half_height), f64::from(radius));
    let (mut t0, mut t1) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut on_cap = false;
    if d.y == 0.0 {
        if o.y.abs() > h {
            return None;
        }
    } else {
        t0 = (-h.copysign(d.y) - o.y) / d.y;
        t1 = (h.copysign(d.y) - o.y) / d.y;
        on_cap = true;
    }
    let dd = d.x * d.x + d.z * d.z;
    if dd == 0.0 {
        if o.x * o.x + o.z * o.z > r * r {
            return None;
        }
    } else {
        let tc = -(o.x * d.x + o.z * d.z) / dd;
        let (px, pz) = (o.x + d.x * tc, o.z + d.z * tc);
        let disc = r * r - (px * px + pz * pz);
        if disc < 0.0 {
            return None;
        }
        let half = (disc / dd).sqrt();
        if tc - half > t0 {
            (t0, on_cap) = (tc - half, false);
        }
        if tc + half < t1 {
            t1 = tc + half;
        }
    }
    if t0 > t1 || t1 <= 0.0 || t0 > f64::from(max_t) {
        return None;
    }
    if t0 < 0.0 {
        return Some(Hit::inside(dir));
    }
    let normal = if on_cap {
        Vec3::new(0.0, 1.0f32.copysign(-dir.y), 0.0)
    } else {
        DVec3::new(o.x + d.x * t0, 0.0, o.z + d.z * t0).as_vec3().normalize_or(-dir)
    };
    Some(Hit { t: t0 as f32, normal, sub: NO_SUB })
}

/// In the half plane (ϱ, y) the cylinder is the rectangle 0 ≤ ϱ ≤ r, |y| ≤ h.
pub(super) fn closest(half_height: f32, radius: f32, point: Vec3) -> PointHit {
    let (u, rho) = radial(point);
    let (q, qy) = (f32s::min(rho, radius), f32s::clamp(point.y, -half_height, half_height));
    let at = |a: f32, y: f32| u * a + Vec3::Y * y;
    if let Some((normal, distance)) = at(rho - q, point.y - qy).try_normalize() {
        return PointHit { point: at(q, qy), distance, normal, sub: NO_SUB };
    }
    let side = if point.y < 0.0 { -1.0 } else { 1.0 };
    let (to_side, to_cap) = (radius - rho, half_height - point.y.abs());
    if to_side < to_cap {
        PointHit { point: at(radius, point.y), distance: -to_side, normal: u, sub: NO_SUB }
    } else {
        let y = side * half_height;
        PointHit { point: at(rho, y), distance: -to_cap, normal: Vec3::Y * side, sub: NO_SUB }
    }
}
