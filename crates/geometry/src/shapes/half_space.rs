//! All points with n · x ≤ offset, |n| = 1.

use super::{Hit, PointHit};
use crate::{Aabb, NO_SUB};
use jounce_math::Vec3;

pub(super) fn aabb() -> Aabb {
    // A quarter of the range, so that centres and extents of the box stay finite.
    Aabb::from_center(Vec3::ZERO, Vec3::splat(f32::MAX / 4.0))
}

pub(super) fn ray(n: Vec3, offset: f32, origin: Vec3, dir: Vec3, max_t: f32) -> Option<Hit> {
    let height = n.dot(origin) - offset;
    if height < 0.0 {
        return Some(Hit::inside(dir));
    }
    let fall = -n.dot(dir);
    if fall <= 0.0 {
        return None;
    }
    let t = height / fall;
    (t <= max_t).then_some(Hit { t, normal: n, sub: NO_SUB })
}

pub(super) fn closest(n: Vec3, offset: f32, point: Vec3) -> PointHit {
    let distance = n.dot(point) - offset;
    PointHit { point: point - n * distance, distance, normal: n, sub: NO_SUB }
}
