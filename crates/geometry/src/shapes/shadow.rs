//! The area of a shape's shadow: what a stream along `dir` sees of it.
//!
//! θ the angle between `dir` and the axis, r the radius, h the half height:
//!
//! ```text
//! ball      π r²
//! box       Σ 4 b c |d_x|                                (a, b, c half extents, x y z in turn)
//! capsule   π r² + 4 r h sin θ
//! cylinder  π r² |cos θ| + 4 r h sin θ
//! cone      e = r |cos θ|, T = 2h sin θ:  π r e where T ≤ e, else r e (π − acos(e/T)) + r √(T² − e²)
//! hull      ½ Σ |A·d|                                    (A area times normal of each face)
//! ```
//!
//! A cone's shadow is the hull of the base's ellipse (half axes r and e) and the tip's image, T from the centre along
//! the axis e. Stretched by r/e it is a disc with the two tangents from a point. A ray that meets a convex polyhedron
//! passes two of its faces, whence the half (Cauchy 1841, "Mémoire sur la rectification des courbes et la quadrature des
//! surfaces courbes", whose theorem on the mean of all shadows the tests use).

use super::Shape;
use crate::Hull;
use core::f64::consts::PI;
use jounce_math::{DVec3, Vec3, scalar::f64s};

impl Shape {
    /// Area of the projection along the unit vector `dir` (shape's frame), m². A compound gives its children's sum:
    /// where they overlap, or one stands in another's shadow, the area counts twice. Shapes without inside give 0.
    ///
    /// ```
    /// use jounce_geometry::Shape;
    /// use jounce_math::Vec3;
    /// let brick = Shape::Box { half: Vec3::new(0.5, 1.0, 1.5) };
    /// assert_eq!(brick.shadow_area(Vec3::Y), 3.0);
    /// ```
    pub fn shadow_area(&self, dir: Vec3) -> f32 {
        self.shadow(dir.as_dvec3()) as f32
    }

    /// Radius of the ball of the same volume, metres; 0 for shapes without inside.
    pub fn equal_volume_radius(&self) -> f32 {
        match self {
            Self::Sphere { radius } => *radius,
            _ => f64s::pow(0.75 / PI * self.volume(), 1.0 / 3.0) as f32,
        }
    }

    fn shadow(&self, d: DVec3) -> f64 {
        let (sin, cos) = ((d.x * d.x + d.z * d.z).sqrt(), d.y.abs());
        match self {
            Self::Sphere { radius } => PI * f64::from(*radius) * f64::from(*radius),
            Self::Capsule { half_height, radius } => {
                let (h, r) = (f64::from(*half_height), f64::from(*radius));
                PI * r * r + 4.0 * r * h * sin
            }
            Self::Box { half } => {
                let h = half.as_dvec3();
                4.0 * DVec3::new(h.y * h.z, h.z * h.x, h.x * h.y).dot(d.abs())
            }
            Self::Cylinder { half_height, radius } => {
                let (h, r) = (f64::from(*half_height), f64::from(*radius));
                PI * r * r * cos + 4.0 * r * h * sin
            }
            Self::Cone { half_height, radius } => cone(f64::from(*half_height), f64::from(*radius), sin, cos),
            Self::Hull(h) => hull(h, d),
            Self::Compound(c) => c.children.iter().fold(0.0, |sum, (pose, shape)| {
                sum + shape.shadow(pose.q.as_dquat().normalize().inverse_rotate(d))
            }),
            Self::HalfSpace { .. } | Self::Mesh(_) | Self::HeightField(_) => 0.0,
        }
    }
}

fn cone(h: f64, r: f64, sin: f64, cos: f64) -> f64 {
    let (e, t) = (r * cos, 2.0 * h * sin);
    if t <= e {
        return PI * r * e;
    }
    let tangent = ((t - e) * (t + e)).sqrt();
    r * e * (PI - f64s::atan2(tangent, e)) + r * tangent
}

fn hull(hull: &Hull, d: DVec3) -> f64 {
    // Twice A·d of each face; corners about one vertex, since areas of far ones would cancel.
    let origin = hull.centroid;
    let mut four = 0.0;
    for face in &hull.faces {
        let mut corners =
            hull.face_vertices(face).iter().map(|&v| hull.vertices[usize::from(v)].as_dvec3() - origin);
        let (Some(a), Some(mut b)) = (corners.next(), corners.next()) else { continue };
        let mut twice = DVec3::ZERO;
        for c in corners {
            twice += (b - a).cross(c - a);
            b = c;
        }
        four += twice.dot(d).abs();
    }
    0.25 * four
}
