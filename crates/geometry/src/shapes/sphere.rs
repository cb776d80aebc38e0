//! Ball of radius r around the origin.
//!
//! m = ρ 4/3 π r³, I = 2/5 m r² (about any axis).

use super::{Hit, MassProperties, PointHit};
use crate::{Aabb, NO_SUB};
use core::f64::consts::PI;
use jounce_math::{DVec3, Pose, Vec3};

pub(super) fn aabb(radius: f32, pose: &Pose) -> Aabb {
    Aabb::from_center(pose.p, Vec3::splat(radius))
}

pub(super) fn mass(radius: f32, density: f64) -> MassProperties {
    let r = f64::from(radius);
    let m = density * 4.0 / 3.0 * PI * r * r * r;
    MassProperties::from_diagonal(m, DVec3::ZERO, DVec3::splat(0.4 * m * r * r))
}

/// Volume and centroid.
pub(super) fn volume(radius: f32) -> (f64, DVec3) {
    let r = f64::from(radius);
    (PI / 0.75 * r * r * r, DVec3::ZERO)
}

/// |o + t d|² = r² with |d| = 1, expanded about the point of closest approach p = o − (o·d) d, so that a
/// far origin loses no digits of r² − |p|² (Haines et al. 2019, "Precision improvements for ray/sphere
/// intersection", Ray Tracing Gems).
#[inline]
pub(super) fn ray(center: Vec3, radius: f32, origin: Vec3, dir: Vec3, max_t: f32) -> Option<Hit> {
    let o = origin - center;
    if o.length_squared() < radius * radius {
        return Some(Hit::inside(dir));
    }
    let b = o.dot(dir);
    if b >= 0.0 {
        return None;
    }
    let p = o - dir * b;
    let disc = radius * radius - p.length_squared();
    if disc < 0.0 {
        return None;
    }
    let half_chord = disc.sqrt();
    let t = -b - half_chord;
    let t = if t > 0.0 { t } else { 0.0 };
    (t <= max_t).then(|| Hit { t, normal: (p - dir * half_chord).normalize_or(-dir), sub: NO_SUB })
}

pub(super) fn closest(center: Vec3, radius: f32, point: Vec3) -> PointHit {
    let (normal, l) = (point - center).try_normalize().unwrap_or((Vec3::Y, 0.0));
    PointHit { point: center + normal * radius, distance: l - radius, normal, sub: NO_SUB }
}
