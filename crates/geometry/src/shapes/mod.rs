//! The shapes and the questions that one shape answers alone.

pub mod compound;
pub mod height_field;

use crate::{Aabb, GeometryError, Hull, TriMesh};
use compound::Compound;
use height_field::HeightField;
use jounce_math::{Mat3, Pose, Vec3};
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
    /// Refuses numbers that no shape can have.
    ///
    /// # Errors
    /// Names the field, its value and what was expected.
    pub fn check(&self) -> Result<(), GeometryError> {
        Ok(())
    }
    /// Convex, bounded and solid: may move.
    pub fn is_convex(&self) -> bool {
        !matches!(self, Self::HalfSpace { .. } | Self::Mesh(_) | Self::HeightField(_) | Self::Compound(_))
    }
    /// Has volume, so it can give a body mass (convex shapes and compounds).
    pub fn is_solid(&self) -> bool {
        self.is_convex() || matches!(self, Self::Compound(_))
    }
    /// Bounds at a pose, tight. A half-space gives ±[`f32::MAX`]/4.
    pub fn aabb(&self, pose: &Pose) -> Aabb {
        let _ = pose;
        Aabb::EMPTY
    }
    /// Mass properties at uniform `density` (kg/m³), exact for each shape; `None` where the shape has no volume.
    pub fn mass_properties(&self, density: f32) -> Option<MassProperties> {
        let _ = density;
        None
    }
    /// Radius of the largest ball around the centre of mass that fits inside (0 for surfaces): sets slop and CCD.
    pub fn inner_radius(&self) -> f32 {
        0.0
    }
    /// Farthest distance of a point of the shape from `center` (the body's centre of mass in the shape's frame).
    pub fn outer_radius(&self, center: Vec3) -> f32 {
        let _ = center;
        0.0
    }
    /// First hit of the ray origin + t·dir, 0 ≤ t ≤ `max_t`, dir of any non-zero length. A ray that starts
    /// inside a solid hits at t = 0 with normal −dir/|dir|.
    pub fn ray_cast(&self, origin: Vec3, dir: Vec3, max_t: f32) -> Option<RayHit> {
        let _ = (origin, dir, max_t);
        None
    }
    /// Nearest surface point; `None` only for an empty mesh or a non-finite point.
    pub fn closest_point(&self, point: Vec3) -> Option<PointHit> {
        let _ = point;
        None
    }
    /// Is the point inside (or on) a solid? Surfaces contain nothing.
    pub fn contains_point(&self, point: Vec3) -> bool {
        self.closest_point(point).is_some_and(|h| h.distance <= 0.0)
    }
}
