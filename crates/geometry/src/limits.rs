//! Every capacity and iteration bound of this crate.

/// Smallest accepted size of a shape, metres.
pub const SIZE_MIN: f32 = 1e-6;
/// Largest accepted size of a shape, metres.
pub const SIZE_MAX: f32 = 1e6;
/// Most vertices of a built hull.
pub const HULL_VERTICES_MAX: usize = 255;
/// Most input points of a hull.
pub const HULL_POINTS_MAX: usize = 1 << 20;
/// Most triangles of one mesh.
pub const MESH_TRIANGLES_MAX: usize = 1 << 24;
/// Most samples along one side of a height field.
pub const HEIGHT_FIELD_SIDE_MAX: usize = 1 << 13;
/// Most children of a compound.
pub const COMPOUND_CHILDREN_MAX: usize = 1 << 16;
/// Most iterations of GJK.
pub const GJK_ITERATIONS_MAX: usize = 32;
/// Most iterations of EPA.
pub const EPA_ITERATIONS_MAX: usize = 64;
/// Most advances of a shape cast or a time of impact.
pub const CAST_ITERATIONS_MAX: usize = 64;
/// Most manifolds of one pair (mesh, height field and compound pairs make several).
pub const MANIFOLDS_PER_PAIR_MAX: usize = 64;
