//! Convex hulls.

use crate::{Aabb, GeometryError};
use jounce_math::Vec3;

/// A planar face: its corners are `Hull::face_vertices(face)`, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullFace {
    /// Unit outward normal.
    pub normal: Vec3,
    /// normal · x = offset on the plane.
    pub offset: f32,
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// An edge between two faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullEdge {
    /// End vertices; `left` lies left of a→b seen from outside.
    pub a: u16,
    /// Other end.
    pub b: u16,
    /// Face whose loop runs a→b.
    pub left: u16,
    /// Face whose loop runs b→a.
    pub right: u16,
}

/// A closed convex polyhedron with merged coplanar faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    pub(crate) vertices: Vec<Vec3>,
    pub(crate) faces: Vec<HullFace>,
    pub(crate) loops: Vec<u16>,
    pub(crate) edges: Vec<HullEdge>,
    pub(crate) aabb: Aabb,
    pub(crate) center: Vec3,
    pub(crate) inner_radius: f32,
}

impl Hull {
    /// The convex hull of points (metres). Survives duplicates, collinear and coplanar input;
    /// refuses sets without volume by name. At most [`crate::limits::HULL_VERTICES_MAX`] vertices are kept.
    ///
    /// # Errors
    /// Non-finite points, fewer than four, too many, or no volume.
    pub fn new(points: &[Vec3]) -> Result<Self, GeometryError> {
        let _ = points;
        Err(GeometryError::Degenerate { what: "not built yet", extent: 0.0 })
    }
    /// Corner points.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }
    /// Faces.
    pub fn faces(&self) -> &[HullFace] {
        &self.faces
    }
    /// Edges, each once.
    pub fn edges(&self) -> &[HullEdge] {
        &self.edges
    }
    /// Corners of a face, as indices into [`Hull::vertices`], counter-clockwise from outside.
    pub fn face_vertices(&self, face: &HullFace) -> &[u16] {
        &self.loops[face.first as usize..(face.first + face.count) as usize]
    }
    /// Bounds.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }
    /// Centre of mass at uniform density.
    pub fn center(&self) -> Vec3 {
        self.center
    }
    /// Distance from the centre to the nearest face plane.
    pub fn inner_radius(&self) -> f32 {
        self.inner_radius
    }
}
