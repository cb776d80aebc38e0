//! The shapes and the questions that one shape answers alone.

mod capsule;
pub mod compound;
mod cone;
pub(crate) mod corners;
mod cuboid;
mod cylinder;
mod half_space;
pub mod height_field;
mod hull;
mod mesh;
mod shadow;
mod sphere;
pub mod submerged;
pub(crate) mod triangle;

pub(crate) use hull::mass_f64 as hull_mass;

use crate::{Aabb, GeometryError, Hull, NO_SUB, TriMesh, limits};
use compound::Compound;
use height_field::HeightField;
use jounce_math::{DMat3, DVec3, Mat3, Pose, Vec3, scalar::f32s};
use std::sync::Arc;

/// A shape in its own frame. Axial shapes run along y. Lengths in metres.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Ball of `radius` around the origin.
    Sphere {
        /// Radius.
        radius: f32,
    },
    /// Segment from −`half_height` to +`half_height` along y, swept by a ball.
    Capsule {
        /// Half length of the segment (without the caps).
        half_height: f32,
        /// Radius.
        radius: f32,
    },
    /// Box around the origin.
    Box {
        /// Half extents.
        half: Vec3,
    },
    /// Solid cylinder along y around the origin.
    Cylinder {
        /// Half height.
        half_height: f32,
        /// Radius.
        radius: f32,
    },
    /// Solid cone: base disc at y = −`half_height`, tip at y = +`half_height`.
    Cone {
        /// Half height.
        half_height: f32,
        /// Radius of the base.
        radius: f32,
    },
    /// Convex hull.
    Hull(Arc<Hull>),
    /// All points with normal · x ≤ offset. Fixed bodies only.
    HalfSpace {
        /// Unit normal, out of the solid.
        normal: Vec3,
        /// Distance of the surface from the origin along the normal.
        offset: f32,
    },
    /// Triangle mesh. Fixed and kinematic bodies only.
    Mesh(Arc<TriMesh>),
    /// Height field. Fixed and kinematic bodies only.
    HeightField(Arc<HeightField>),
    /// Several convex shapes that act as one.
    Compound(Arc<Compound>),
}

/// Mass, centre of mass and inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// kg.
    pub mass: f32,
    /// Centre of mass in the shape's frame, metres.
    pub center: Vec3,
    /// Inertia tensor about the centre of mass, axes of the shape's frame, kg m².
    pub inertia: Mat3,
}

impl MassProperties {
    /// From the mass, the centre and the principal moments about it, axes of the shape's frame.
    fn from_diagonal(mass: f64, center: DVec3, inertia: DVec3) -> Self {
        Self::from_f64(mass, center, DMat3::from_diagonal(inertia))
    }
    fn from_f64(mass: f64, center: DVec3, inertia: DMat3) -> Self {
        Self { mass: mass as f32, center: center.as_vec3(), inertia: inertia.as_mat3() }
    }
}

/// Where a ray met a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Ray parameter: the point is origin + t·dir.
    pub t: f32,
    /// Unit outward normal (towards the ray's origin for surfaces without inside).
    pub normal: Vec3,
    /// Triangle or child index, or [`crate::NO_SUB`].
    pub sub: u32,
}

use RayHit as Hit;

impl RayHit {
    /// A ray along the unit vector `dir` that starts inside.
    #[inline]
    fn inside(dir: Vec3) -> Self {
        Self { t: 0.0, normal: -dir, sub: NO_SUB }
    }
    /// The nearer of two; of equals the one with the lower part.
    #[inline]
    fn is_before(&self, o: &Self) -> bool {
        self.t < o.t || (self.t == o.t && self.sub < o.sub)
    }
}

/// Unit direction of a point away from the y axis (x where it lies on the axis), and its distance from it.
#[inline]
fn radial(p: Vec3) -> (Vec3, f32) {
    Vec3::new(p.x, 0.0, p.z).try_normalize().unwrap_or((Vec3::X, 0.0))
}

/// Refuses a size that is not positive, finite and within the limits.
fn check_size(shape: &'static str, field: &'static str, value: f32) -> Result<(), GeometryError> {
    if (limits::SIZE_MIN..=limits::SIZE_MAX).contains(&value) {
        return Ok(());
    }
    Err(GeometryError::BadNumber { shape, field, value, expected: "a length in metres from 1e-6 to 1e6" })
}

fn check_half_space(normal: Vec3, offset: f32) -> Result<(), GeometryError> {
    let (shape, length) = ("half_space", normal.length());
    if !(0.999..=1.001).contains(&length) {
        let (field, expected) = ("length of normal", "a unit vector");
        return Err(GeometryError::BadNumber { shape, field, value: length, expected });
    }
    if !offset.is_finite() {
        let (field, expected) = ("offset", "a finite number of metres");
        return Err(GeometryError::BadNumber { shape, field, value: offset, expected });
    }
    Ok(())
}

/// The point of a shape's surface nearest to a query point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointHit {
    /// Point on the surface.
    pub point: Vec3,
    /// Distance, metres; negative when the query point is inside a solid.
    pub distance: f32,
    /// Unit outward normal at the point.
    pub normal: Vec3,
    /// Triangle or child index, or [`crate::NO_SUB`].
    pub sub: u32,
}

impl Shape {
    /// The shape's name in scene files: "sphere", "half_space", ….
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Capsule { .. } => "capsule",
            Self::Box { .. } => "box",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Hull(_) => "hull",
            Self::HalfSpace { .. } => "half_space",
            Self::Mesh(_) => "mesh",
            Self::HeightField(_) => "height_field",
            Self::Compound(_) => "compound",
        }
    }
    /// Refuses numbers that no shape can have. Shapes with data were checked when they were built.
    ///
    /// # Errors
    /// Names the field, its value and what was expected.
    pub fn check(&self) -> Result<(), GeometryError> {
        let name = self.name();
        match *self {
            Self::Sphere { radius } => check_size(name, "radius", radius),
            Self::Capsule { half_height, radius }
            | Self::Cylinder { half_height, radius }
            | Self::Cone { half_height, radius } => {
                check_size(name, "half_height", half_height).and_then(|()| check_size(name, "radius", radius))
            }
            Self::Box { half } => check_size(name, "half.x", half.x)
                .and_then(|()| check_size(name, "half.y", half.y))
                .and_then(|()| check_size(name, "half.z", half.z)),
            Self::HalfSpace { normal, offset } => check_half_space(normal, offset),
            Self::Hull(_) | Self::Mesh(_) | Self::HeightField(_) | Self::Compound(_) => Ok(()),
        }
    }
    /// Convex, bounded and solid: may move.
    pub fn is_convex(&self) -> bool {
        !matches!(self, Self::HalfSpace { .. } | Self::Mesh(_) | Self::HeightField(_) | Self::Compound(_))
    }
    /// Has volume, so it can give a body mass (convex shapes and compounds).
    pub fn is_solid(&self) -> bool {
        self.is_convex() || matches!(self, Self::Compound(_))
    }
    /// Bounds at a pose, tight for every solid shape; a turned mesh or height field gets the box around its own
    /// turned box. A half-space gives ±[`f32::MAX`]/4.
    pub fn aabb(&self, pose: &Pose) -> Aabb {
        match self {
            Self::Sphere { radius } => sphere::aabb(*radius, pose),
            Self::Capsule { half_height, radius } => capsule::aabb(*half_height, *radius, pose),
            Self::Box { half } => cuboid::aabb(*half, pose),
            Self::Cylinder { half_height, radius } => cylinder::aabb(*half_height, *radius, pose),
            Self::Cone { half_height, radius } => cone::aabb(*half_height, *radius, pose),
            Self::Hull(h) => hull::aabb(h, pose),
            Self::HalfSpace { .. } => half_space::aabb(),
            Self::Mesh(m) => m.aabb.transformed(pose),
            Self::HeightField(h) => h.aabb().transformed(pose),
            Self::Compound(c) => c.aabb_at(pose),
        }
    }
    /// Mass properties at uniform `density` (kg/m³), exact for each shape; `None` where the shape has no volume.
    /// Overlapping children of a compound count twice.
    pub fn mass_properties(&self, density: f32) -> Option<MassProperties> {
        let rho = f64::from(density);
        match self {
            Self::Sphere { radius } => Some(sphere::mass(*radius, rho)),
            Self::Capsule { half_height, radius } => Some(capsule::mass(*half_height, *radius, rho)),
            Self::Box { half } => Some(cuboid::mass(*half, rho)),
            Self::Cylinder { half_height, radius } => Some(cylinder::mass(*half_height, *radius, rho)),
            Self::Cone { half_height, radius } => Some(cone::mass(*half_height, *radius, rho)),
            Self::Hull(h) => Some(hull::mass(h, rho)),
            Self::Compound(c) => Some(c.mass(density)),
            Self::HalfSpace { .. } | Self::Mesh(_) | Self::HeightField(_) => None,
        }
    }
    /// Radius of the largest ball around the centre of mass that fits inside: sets slop and CCD. A compound gives
    /// its thinnest child's, since its centre of mass may lie outside of it; shapes without mass give 0.
    pub fn inner_radius(&self) -> f32 {
        match self {
            Self::Sphere { radius } | Self::Capsule { radius, .. } => *radius,
            Self::Box { half } => half.min_component(),
            Self::Cylinder { half_height, radius } => f32s::min(*half_height, *radius),
            Self::Cone { half_height, radius } => cone::inner_radius(*half_height, *radius),
            Self::Hull(h) => h.inner_radius,
            Self::Compound(c) => c.inner_radius(),
            Self::HalfSpace { .. } | Self::Mesh(_) | Self::HeightField(_) => 0.0,
        }
    }
    /// Farthest distance of a point of the shape from `center` (the body's centre of mass in the shape's frame).
    /// A half-space gives [`f32::MAX`]/4.
    pub fn outer_radius(&self, center: Vec3) -> f32 {
        let rim = |y: f32, radius: f32| Vec3::new(radial(center).1 + radius, center.y - y, 0.0).length();
        match self {
            Self::Sphere { radius } => center.length() + *radius,
            Self::Capsule { half_height, radius } => {
                (center.abs() + Vec3::Y * *half_height).length() + *radius
            }
            Self::Box { half } => (center.abs() + *half).length(),
            Self::Cylinder { half_height, radius } => {
                f32s::max(rim(*half_height, *radius), rim(-*half_height, *radius))
            }
            Self::Cone { half_height, radius } => {
                f32s::max(rim(*half_height, 0.0), rim(-*half_height, *radius))
            }
            Self::Hull(h) => farthest(&h.vertices, center),
            Self::Mesh(m) => farthest(&m.vertices, center),
            Self::HeightField(h) => h.outer_radius(center),
            Self::Compound(c) => c.outer_radius(center),
            Self::HalfSpace { .. } => f32::MAX / 4.0,
        }
    }
    /// First hit of the ray origin + t·dir, 0 ≤ t ≤ `max_t`, dir of any non-zero length. A ray that starts
    /// inside a solid hits at t = 0 with normal −dir/|dir|. Triangles are hit from both sides, whatever side
    /// collides, and the normal faces the ray's origin. Of equal hits the lowest triangle or child wins.
    /// `None` also for a zero or non-finite ray.
    pub fn ray_cast(&self, origin: Vec3, dir: Vec3, max_t: f32) -> Option<RayHit> {
        let (unit, length) = dir.try_normalize()?;
        if !(origin.is_finite() && max_t >= 0.0) {
            return None;
        }
        let mut hit = self.ray_unit(origin, unit, max_t * length)?;
        hit.t = f32s::min(hit.t / length, max_t);
        Some(hit)
    }
    /// [`Shape::ray_cast`] for a unit direction.
    fn ray_unit(&self, origin: Vec3, dir: Vec3, max_t: f32) -> Option<RayHit> {
        match self {
            Self::Sphere { radius } => sphere::ray(Vec3::ZERO, *radius, origin, dir, max_t),
            Self::Capsule { half_height, radius } => capsule::ray(*half_height, *radius, origin, dir, max_t),
            Self::Box { half } => cuboid::ray(*half, origin, dir, max_t),
            Self::Cylinder { half_height, radius } => {
                cylinder::ray(*half_height, *radius, origin, dir, max_t)
            }
            Self::Cone { half_height, radius } => cone::ray(*half_height, *radius, origin, dir, max_t),
            Self::Hull(h) => hull::ray(h, origin, dir, max_t),
            Self::HalfSpace { normal, offset } => half_space::ray(*normal, *offset, origin, dir, max_t),
            Self::Mesh(m) => mesh::ray(m, origin, dir, max_t),
            Self::HeightField(h) => h.ray(origin, dir, max_t),
            Self::Compound(c) => c.ray(origin, dir, max_t),
        }
    }
    /// Nearest surface point; `None` only for a non-finite point or a height field that is all holes. Inside a
    /// compound it is that of the child the point is deepest in.
    pub fn closest_point(&self, point: Vec3) -> Option<PointHit> {
        if !point.is_finite() {
            return None;
        }
        match self {
            Self::Sphere { radius } => Some(sphere::closest(Vec3::ZERO, *radius, point)),
            Self::Capsule { half_height, radius } => Some(capsule::closest(*half_height, *radius, point)),
            Self::Box { half } => Some(cuboid::closest(*half, point)),
            Self::Cylinder { half_height, radius } => Some(cylinder::closest(*half_height, *radius, point)),
            Self::Cone { half_height, radius } => Some(cone::closest(*half_height, *radius, point)),
            Self::Hull(h) => Some(hull::closest(h, point)),
            Self::HalfSpace { normal, offset } => Some(half_space::closest(*normal, *offset, point)),
            Self::Mesh(m) => mesh::closest(m, point),
            Self::HeightField(h) => h.closest(point),
            Self::Compound(c) => c.closest(point),
        }
    }
    /// Is the point inside (or on) a solid? Surfaces contain nothing.
    pub fn contains_point(&self, point: Vec3) -> bool {
        (self.is_solid() || matches!(self, Self::HalfSpace { .. }))
            && self.closest_point(point).is_some_and(|h| h.distance <= 0.0)
    }
}

fn farthest(points: &[Vec3], center: Vec3) -> f32 {
    points.iter().fold(0.0f32, |m, &p| f32s::max((p - center).length_squared(), m)).sqrt()
}
