//! Segment from −h to +h along y, swept by a ball of radius r.
//!
//! Cylinder part m_c = ρ π r² 2h, both caps together m_s = ρ 4/3 π r³ (centre of a half ball 3r/8 from its flat
//! side). I_yy = m_c r²/2 + 2/5 m_s r²; I_xx = I_zz = m_c (r²/4 + h²/3) + m_s (2/5 r² + h² + 3/4 h r).

use super::{Hit, MassProperties, PointHit, sphere};
use crate::{Aabb, NO_SUB};
use core::f64::consts::PI;
use jounce_math::{DVec3, Pose, Vec3, scalar::f32s};

pub(super) fn aabb(half_height: f32, radius: f32, pose: &Pose) -> Aabb {
    let axis = pose.q.rotate(Vec3::Y);
    Aabb::from_center(pose.p, axis.abs() * half_height + Vec3::splat(radius))
}

pub(super) fn mass(half_height: f32, radius: f32, density: f64) -> MassProperties {
    let (h, r) = (f64::from(half_height), f64::from(radius));
    let mc = density * PI * r * r * 2.0 * h;
    let ms = density * 4.0 / 3.0 * PI * r * r * r;
    let iyy = 0.5 * mc * r * r + 0.4 * ms * r * r;
    let ixx = mc * (0.25 * r * r + h * h / 3.0) + ms * (0.4 * r * r + h * h + 0.75 * h * r);
    MassProperties::from_diagonal(mc + ms, DVec3::ZERO, DVec3::new(ixx, iyy, ixx))
}

/// Volume and centroid.
pub(super) fn volume(half_height: f32, radius: f32) -> (f64, DVec3) {
    let (h, r) = (f64::from(half_height), f64::from(radius));
    (PI * r * r * (2.0 * h + r / 0.75), DVec3::ZERO)
}

/// The capsule is the union of its cylinder's side and two balls: the ray enters it at the side if that
/// point lies between the caps, else at the cap on that side.
pub(super) fn ray(half_height: f32, radius: f32, origin: Vec3, dir: Vec3, max_t: f32) -> Option<Hit> {
    let core = Vec3::new(0.0, f32s::clamp(origin.y, -half_height, half_height), 0.0);
    if (origin - core).length_squared() < radius * radius {
        return Some(Hit::inside(dir));
    }
    // Ray against the infinite cylinder, about the closest approach in the x-z plane; the parameter
    // along the ray is the planar one divided by |d_xz|².
    let dd = dir.x * dir.x + dir.z * dir.z;
    let rho2 = origin.x * origin.x + origin.z * origin.z;
    let b = origin.x * dir.x + origin.z * dir.z;
    let t_side = if dd > 1e-14 {
        let tc = -b / dd;
        let (px, pz) = (origin.x + dir.x * tc, origin.z + dir.z * tc);
        let disc = radius * radius - (px * px + pz * pz);
        if disc < 0.0 {
            return None;
        }
        let half = (disc / dd).sqrt();
        if tc + half < 0.0 {
            return None;
        }
        tc - half
    } else {
        if rho2 > radius * radius {
            return None;
        }
        f32::NEG_INFINITY
    };
    let t = f32s::max(t_side, 0.0);
    let y = origin.y + dir.y * t;
    if y.abs() <= half_height && t_side >= 0.0 {
        let p = origin + dir * t;
        let normal = Vec3::new(p.x, 0.0, p.z).normalize_or(-dir);
        return (t <= max_t).then_some(Hit { t, normal, sub: NO_SUB });
    }
    let cap = if y > 0.0 { half_height } else { -half_height };
    sphere::ray(Vec3::new(0.0, cap, 0.0), radius, origin, dir, max_t)
}

pub(super) fn closest(half_height: f32, radius: f32, point: Vec3) -> PointHit {
    let core = Vec3::new(0.0, f32s::clamp(point.y, -half_height, half_height), 0.0);
    let (normal, l) = (point - core).try_normalize().unwrap_or((Vec3::X, 0.0));
    PointHit { point: core + normal * radius, distance: l - radius, normal, sub: NO_SUB }
}
