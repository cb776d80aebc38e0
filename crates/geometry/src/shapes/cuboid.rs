//! Box of half extents (a, b, c) around the origin.
//!
//! m = ρ 8abc, I_xx = m/3 (b² + c²) and so on.

use super::{Hit, MassProperties, PointHit};
use crate::{Aabb, NO_SUB};
use jounce_math::{DVec3, Pose, Vec3};

pub(super) fn aabb(half: Vec3, pose: &Pose) -> Aabb {
    let m = pose.q.to_mat3();
    Aabb::from_center(pose.p, m.cx.abs() * half.x + m.cy.abs() * half.y + m.cz.abs() * half.z)
}

pub(super) fn mass(half: Vec3, density: f64) -> MassProperties {
    let h = half.as_dvec3();
    let m = density * 8.0 * h.x * h.y * h.z;
    let (x, y, z) = (h.x * h.x, h.y * h.y, h.z * h.z);
    MassProperties::from_diagonal(m, DVec3::ZERO, DVec3::new(y + z, z + x, x + y) * (m / 3.0))
}

/// Volume and centroid.
pub(super) fn volume(half: Vec3) -> (f64, DVec3) {
    let h = half.as_dvec3();
    (8.0 * h.x * h.y * h.z, DVec3::ZERO)
}

/// Kay and Kajiya's slabs, one axis after the other. An axis the ray is parallel to only decides in or out.
pub(super) fn ray(half: Vec3, origin: Vec3, dir: Vec3, max_t: f32) -> Option<Hit> {
    let (mut t0, mut t1) = (f32::NEG_INFINITY, f32::INFINITY);
    let mut axis = 0;
    for i in 0..3 {
        if dir[i] == 0.0 {
            if origin[i].abs() > half[i] {
                return None;
            }
            continue;
        }
        let inv = 1.0 / dir[i];
        let near = (-half[i].copysign(dir[i]) - origin[i]) * inv;
        let far = (half[i].copysign(dir[i]) - origin[i]) * inv;
        if near > t0 {
            (t0, axis) = (near, i);
        }
        if far < t1 {
            t1 = far;
        }
    }
    if t0 > t1 || t1 <= 0.0 || t0 > max_t {
        return None;
    }
    if t0 < 0.0 {
        return Some(Hit::inside(dir));
    }
    let mut normal = Vec3::ZERO;
    normal[axis] = 1.0f32.copysign(-dir[axis]);
    Some(Hit { t: t0, normal, sub: NO_SUB })
}

pub(super) fn closest(half: Vec3, point: Vec3) -> PointHit {
    let q = point.clamp(-half, half);
    if let Some((normal, distance)) = (point - q).try_normalize() {
        return PointHit { point: q, distance, normal, sub: NO_SUB };
    }
    let depth = half - point.abs();
    let axis = if depth.x <= depth.y && depth.x <= depth.z {
        0
    } else if depth.y <= depth.z {
        1
    } else {
        2
    };
    let side = if point[axis] < 0.0 { -1.0 } else { 1.0 };
    let (mut p, mut normal) = (point, Vec3::ZERO);
    p[axis] = side * half[axis];
    normal[axis] = side;
    PointHit { point: p, distance: -depth[axis], normal, sub: NO_SUB }
}
