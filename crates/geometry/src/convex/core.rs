//! Cores: every convex shape is a core swept by a ball (a capsule is a segment and a radius, a box is
//! itself and radius 0). GJK and EPA see cores only, so round shapes stay exact.

use crate::{Hull, Shape};
use jounce_math::{Vec3, scalar::f32s};

/// A convex set given by its support function.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Core<'a> {
    /// The origin.
    Point,
    /// Segment along y, by half height.
    Segment(f32),
    /// Box by half extents.
    Box(Vec3),
    /// Cylinder by half height and radius.
    Cylinder(f32, f32),
    /// Cone by half height and radius of the base.
    Cone(f32, f32),
    /// Polyhedron.
    Hull(&'a Hull),
    /// Triangle.
    Triangle([Vec3; 3]),
}

#[inline(always)]
pub(crate) fn sign(x: f32) -> f32 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

impl<'a> Core<'a> {
    /// Core and radius of a convex shape; `None` for the others.
    pub fn of(shape: &'a Shape) -> Option<(Self, f32)> {
        Some(match shape {
            Shape::Sphere { radius } => (Core::Point, *radius),
            Shape::Capsule { half_height, radius } => (Core::Segment(*half_height), *radius),
            Shape::Box { half } => (Core::Box(*half), 0.0),
            Shape::Cylinder { half_height, radius } => (Core::Cylinder(*half_height, *radius), 0.0),
            Shape::Cone { half_height, radius } => (Core::Cone(*half_height, *radius), 0.0),
            Shape::Hull(h) => (Core::Hull(h), 0.0),
            _ => return None,
        })
    }

    /// A point well inside.
    pub fn center(&self) -> Vec3 {
        match self {
            Core::Hull(h) => h.center(),
            Core::Triangle(t) => (t[0] + t[1] + t[2]) * (1.0 / 3.0),
            // The centroid: the origin is halfway up, near the surface, and soon behind a floor that the cone lies on.
            Core::Cone(h, _) => Vec3::new(0.0, -0.5 * h, 0.0),
            _ => Vec3::ZERO,
        }
    }

    /// No point is farther from [`Core::center`].
    pub fn reach(&self) -> f32 {
        match self {
            Core::Point => 0.0,
            Core::Segment(h) => *h,
            Core::Box(h) => h.length(),
            Core::Cylinder(h, r) => h + r,
            Core::Cone(h, r) => 1.5 * h + r,
            Core::Hull(h) => (h.aabb().max - h.center()).max(h.center() - h.aabb().min).length(),
            Core::Triangle(t) => t.iter().fold(0.0, |m, p| f32s::max((*p - self.center()).length(), m)),
        }
    }

    /// Largest coordinate of the core, for tolerances.
    pub fn extent(&self) -> f32 {
        match self {
            Core::Point => 0.0,
            Core::Segment(h) => *h,
            Core::Box(h) => h.max_component(),
            Core::Cylinder(h, r) | Core::Cone(h, r) => h + r,
            Core::Hull(h) => (h.aabb().max.abs()).max(h.aabb().min.abs()).max_component(),
            Core::Triangle(t) => t[0].abs().max(t[1].abs()).max(t[2].abs()).max_component(),
        }
    }

    /// A point of the core farthest along `d` (of any length).
    #[inline]
    pub fn support(&self, d: Vec3) -> Vec3 {
        match *self {
            Core::Point => Vec3::ZERO,
            Core::Segment(h) => Vec3::new(0.0, sign(d.y) * h, 0.0),
            Core::Box(h) => Vec3::new(sign(d.x) * h.x, sign(d.y) * h.y, sign(d.z) * h.z),
            Core::Cylinder(h, r) => {
                let (x, z) = rim(d, r);
                Vec3::new(x, sign(d.y) * h, z)
            }
            Core::Cone(h, r) => {
                let (x, z) = rim(d, r);
                let base = Vec3::new(x, -h, z);
                let tip = Vec3::new(0.0, h, 0.0);
                if tip.dot(d) > base.dot(d) { tip } else { base }
            }
            Core::Hull(h) => h.vertices[h.corners.farthest(d)],
            Core::Triangle(t) => support_of(&t, d),
        }
    }
}

/// The point of the circle of radius `r` in the xz plane farthest along `d`.
#[inline]
pub(crate) fn rim(d: Vec3, r: f32) -> (f32, f32) {
    let m = if d.x.abs() > d.z.abs() { d.x.abs() } else { d.z.abs() };
    if m <= 0.0 {
        return (r, 0.0);
    }
    let (x, z) = (d.x / m, d.z / m);
    let s = r / (x * x + z * z).sqrt();
    (x * s, z * s)
}

#[inline]
fn support_of(points: &[Vec3], d: Vec3) -> Vec3 {
    let mut best = Vec3::ZERO;
    let mut far = f32::NEG_INFINITY;
    for &p in points {
        let s = p.dot(d);
        if s > far {
            (far, best) = (s, p);
        }
    }
    best
}
