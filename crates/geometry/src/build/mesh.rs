//! Triangle meshes: soup in, adjacency, edge flags and a tree out.

use crate::{Aabb, Bvh, GeometryError};
use jounce_math::Vec3;

/// How to build a [`TriMesh`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriMeshOptions {
    /// Vertices closer than this are one vertex, metres; 0 joins exact duplicates only.
    pub weld_distance: f32,
    /// Both sides of each triangle collide. Default: only the side that counter-clockwise corners face.
    pub double_sided: bool,
}

impl Default for TriMeshOptions {
    fn default() -> Self {
        Self { weld_distance: 0.0, double_sided: false }
    }
}

/// A static triangle mesh with adjacency, convex-edge flags and a bounding volume tree.
#[derive(Clone, Debug)]
pub struct TriMesh {
    pub(crate) vertices: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Neighbour across edge k (corner k to corner k+1), or `NO_SUB`.
    pub(crate) neighbors: Vec<[u32; 3]>,
    /// Bit k: edge k is convex or a border (contacts on it may use edge normals); clear: flat or concave.
    pub(crate) edge_flags: Vec<u8>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) materials: Vec<u16>,
    pub(crate) tree: Bvh,
    pub(crate) aabb: Aabb,
    pub(crate) double_sided: bool,
    /// Index of each kept triangle in the given list.
    pub(crate) source: Vec<u32>,
}

impl TriMesh {
    /// Builds a mesh. Degenerate triangles are dropped (their number is `dropped()`), triangle indices in
    /// results refer to the *given* list.
    ///
    /// # Errors
    /// Non-finite vertices, indices out of range, nothing left, or too many triangles.
    pub fn new(
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
        options: TriMeshOptions,
    ) -> Result<Self, GeometryError> {
        let _ = (vertices, triangles, options);
        Err(GeometryError::Unsupported { shape: "mesh", what: "not built yet" })
    }
    /// With a material index per triangle (same length as the given list); looked up by results' `sub`.
    ///
    /// # Errors
    /// A wrong length.
    pub fn with_materials(self, materials: &[u16]) -> Result<Self, GeometryError> {
        let _ = materials;
        Ok(self)
    }
    /// Material index of a triangle; 0 where none were given.
    pub fn material(&self, triangle: u32) -> u16 {
        self.materials.get(triangle as usize).copied().unwrap_or(0)
    }
    /// Bounds.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }
    /// Corners of a kept triangle.
    #[inline]
    pub fn triangle(&self, i: u32) -> [Vec3; 3] {
        self.triangles[i as usize].map(|v| self.vertices[v as usize])
    }
    /// Unit normal of a kept triangle.
    #[inline]
    pub fn normal(&self, i: u32) -> Vec3 {
        self.normals[i as usize]
    }
    /// Index of a kept triangle in the given list.
    #[inline]
    pub fn original_index(&self, i: u32) -> u32 {
        self.source[i as usize]
    }
}
