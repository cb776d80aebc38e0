//! Solid cone: base disc of radius r at y = −h, tip at y = +h.
//!
//! With the height H = 2h: m = ρ π r² H/3, centre of mass H/4 above the base (y = −h/2), I_yy = 3/10 m r²,
//! I_xx = I_zz = 3/20 m r² + 3/80 m H² about it. Side: ϱ = k (h − y) with k = r/H; its outward normal in the half
//! plane (ϱ, y) is (H, r)/√(H² + r²).

use super::{Hit, MassProperties, PointHit, cylinder::disc_half, radial};
use crate::{Aabb, NO_SUB};
use core::f64::consts::PI;
use jounce_math::{
    DVec3, Pose, Vec3,
    scalar::{f32s, f64s},
};

/// Unit outward normal (ϱ, y) of the side.
pub(super) fn side_normal(half_height: f32, radius: f32) -> (f32, f32) {
    let (n, _) = Vec3::new(2.0 * half_height, radius, 0.0).try_normalize().unwrap_or((Vec3::X, 0.0));
    (n.x, n.y)
}

pub(super) fn aabb(half_height: f32, radius: f32, pose: &Pose) -> Aabb {
    let m = pose.q.to_mat3();
    let tip = m.cy * half_height;
    let disc = Aabb::from_center(-tip, disc_half(m.cx, m.cz, radius));
    let b = disc.union(&Aabb::new(tip, tip));
    Aabb::new(b.min + pose.p, b.max + pose.p)
}

pub(super) fn mass(half_height: f32, radius: f32, density: f64) -> MassProperties {
    let (h, r) = (f64::from(half_height), f64::from(radius));
    let m = density * PI * r * r * 2.0 * h / 3.0;
    let ixx = 0.15 * m * (r * r + h * h);
    MassProperties::from_diagonal(m, DVec3::new(0.0, -0.5 * h, 0.0), DVec3::new(ixx, 0.3 * m * r * r, ixx))
}

/// Volume and centroid.
pub(super) fn volume(half_height: f32, radius: f32) -> (f64, DVec3) {
    let (h, r) = (f64::from(half_height), f64::from(radius));
    (PI * r * r * 2.0 * h / 3.0, DVec3::new(0.0, -0.5 * h, 0.0))
}

/// Ball around the centre of mass: h/2 to the base, 3/2 h r/√(H² + r²) to the side.
pub(super) fn inner_radius(half_height: f32, radius: f32) -> f32 {
    f32s::min(0.5 * half_height, 1.5 * half_height * side_normal(half_height, radius).1)
}

/// The ray's interval in the slab |y| ≤ h, cut with its interval inside the cone, in `f64`. With s = h − y
/// (depth below the tip) the side is g(t) = ϱ² − k² s² = 0; between the slab's planes s ≥ 0, so only the cone's
/// lower half counts and the inside is g ≤ 0.
pub(super) fn ray(half_height: f32, radius: f32, origin: Vec3, dir: Vec3, max_t: f32) -> Option<Hit> {
    let (d, h, r) = (dir.as_dvec3(), f64::from(half_height), f64::from(radius));
    // Start at the point nearest the cone's middle: keeps the quadratic's coefficients at the shape's scale.
    let shift = -origin.as_dvec3().dot(d);
    let o = origin.as_dvec3() + d * shift;
    let (mut t0, mut t1) = (f64::NEG_INFINITY, f64::INFINITY);
    if d.y == 0.0 {
        if o.y.abs() > h {
            return None;
        }
    } else {
        t0 = (-h.copysign(d.y) - o.y) / d.y;
        t1 = (h.copysign(d.y) - o.y) / d.y;
    }
    let mut on_base = d.y > 0.0;
    let k2 = r * r / (4.0 * h * h);
    let s = h - o.y;
    let a = d.x * d.x + d.z * d.z - k2 * d.y * d.y;
    let b = o.x * d.x + o.z * d.z + k2 * s * d.y;
    let c = o.x * o.x + o.z * o.z - k2 * s * s;
    let (lo, hi) = side_interval(a, b, c, d.y > 0.0)?;
    if lo > t0 {
        (t0, on_base) = (lo, false);
    }
    if hi < t1 {
        t1 = hi;
    }
    t0 += shift;
    t1 += shift;
    if t0 > t1 || t1 <= 0.0 || t0 > f64::from(max_t) {
        return None;
    }
    if t0 < 0.0 {
        return Some(Hit::inside(dir));
    }
    if on_base {
        return Some(Hit { t: t0 as f32, normal: -Vec3::Y, sub: NO_SUB });
    }
    let p = origin.as_dvec3() + d * t0;
    let u = DVec3::new(p.x, 0.0, p.z).as_vec3().normalize_or(Vec3::ZERO);
    let (nr, ny) = side_normal(half_height, radius);
    // At the tip itself the radial direction is undefined.
    let normal = if u == Vec3::ZERO { Vec3::Y } else { u * nr + Vec3::Y * ny };
    Some(Hit { t: t0 as f32, normal, sub: NO_SUB })
}

/// Where a t² + 2 b t + c ≤ 0 on the lower half of the double cone; `None` for nowhere.
fn side_interval(a: f64, b: f64, c: f64, upward: bool) -> Option<(f64, f64)> {
    let disc = b * b - a * c;
    if disc < 0.0 && a >= 0.0 {
        return None;
    }
    // q/a and c/q never subtract nearly equal numbers. A steep ray (a < 0) always has roots; less than zero
    // is rounding at the tip.
    let q = -(b + f64s::max(disc, 0.0).sqrt().copysign(b));
    if q == 0.0 {
        // The surface's line itself, or a ray that only touches the tip.
        return Some(if a == 0.0 { (f64::NEG_INFINITY, f64::INFINITY) } else { (0.0, 0.0) });
    }
    if a == 0.0 {
        // Parallel to the side: one root, and the sign of b tells on which side of it the inside is.
        return Some(if b > 0.0 { (f64::NEG_INFINITY, c / q) } else { (c / q, f64::INFINITY) });
    }
    let (r0, r1) = (q / a, c / q);
    let (lo, hi) = if r0 <= r1 { (r0, r1) } else { (r1, r0) };
    Some(match (a > 0.0, upward) {
        (true, _) => (lo, hi),
        // A steep ray is inside both halves, outside of (lo, hi); an upward one meets the lower half first.
        (false, true) => (f64::NEG_INFINITY, lo),
        (false, false) => (hi, f64::INFINITY),
    })
}

/// In the half plane (ϱ, y) the cone is a triangle with the corners (0, −h), (r, −h), (0, h).
pub(super) fn closest(half_height: f32, radius: f32, point: Vec3) -> PointHit {
    let (h, r) = (half_height, radius);
    let (u, rho) = radial(point);
    let (nr, ny) = side_normal(h, r);
    let at = |a: f32, y: f32| u * a + Vec3::Y * y;
    // Closest point on the side: foot on the segment from the rim (r, −h) along (−ny, nr) to the tip.
    let length = (4.0 * h * h + r * r).sqrt();
    let foot = (rho - r) * -ny + (point.y + h) * nr;
    let side = if foot <= 0.0 {
        (r, -h)
    } else if foot >= length {
        (0.0, h)
    } else {
        (r - ny * foot, -h + nr * foot)
    };
    let base = (f32s::min(rho, r), -h);
    let above_side = (rho - r) * nr + (point.y + h) * ny;
    if above_side <= 0.0 && point.y >= -h {
        return if -above_side < point.y + h {
            let q = at(rho - nr * above_side, point.y - ny * above_side);
            PointHit { point: q, distance: above_side, normal: at(nr, ny), sub: NO_SUB }
        } else {
            PointHit { point: at(rho, -h), distance: -(point.y + h), normal: -Vec3::Y, sub: NO_SUB }
        };
    }
    if above_side > 0.0 && foot > 0.0 && foot < length {
        let q = at(rho - nr * above_side, point.y - ny * above_side);
        return PointHit { point: q, distance: above_side, normal: at(nr, ny), sub: NO_SUB };
    }
    let d2 = |q: (f32, f32)| (rho - q.0) * (rho - q.0) + (point.y - q.1) * (point.y - q.1);
    let q = if d2(side) < d2(base) { side } else { base };
    // Of a gap near rounding the direction means nothing.
    let (normal, distance) = match at(rho - q.0, point.y - q.1).try_normalize() {
        Some((n, d)) if d > 1e-6 * (h + r) => (n, d),
        other => (at(nr, ny), other.map_or(0.0, |(_, d)| d)),
    };
    PointHit { point: at(q.0, q.1), distance, normal, sub: NO_SUB }
}
