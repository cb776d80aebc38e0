//! Shapes and questions about them. Knows no bodies and no time.
//!
//! Everything is `f32` in the frame of a shape; a pair of shapes is described by the pose of B in the
//! frame of A, so a pair far from the world's origin is as exact as one at it.
//!
//! * [`Shape`]: the shapes, their bounds, mass properties, ray casts and closest points, the part of one below a liquid's
//!   surface ([`Shape::submerged`]) and the area of its shadow.
//! * [`Hull`], [`TriMesh`], [`HeightField`], [`Compound`]: shapes with data, built once and shared by `Arc`.
//! * [`collide`]: contact manifolds; [`distance`], [`overlap`], [`cast_shape`], [`time_of_impact`].
//! * [`Bvh`]: the bounding volume tree used by meshes, compounds and the engine's broad phase.
#![forbid(unsafe_code)]

mod aabb;
mod build;
mod convex;
mod error;
pub mod limits;
mod manifold;
mod pairs;
mod shapes;
mod tree;

pub use aabb::Aabb;
pub use build::hull::{Hull, HullEdge, HullFace};
pub use build::mesh::{TriMesh, TriMeshOptions};
pub use convex::{
    CastHit, Distance, Sweep, TimeOfImpact, cast_shape, distance, overlap, stays_shallow, time_of_impact,
};
pub use error::GeometryError;
pub use manifold::{FACE_A, FACE_B, Manifold, ManifoldPoint, ManifoldSet, NO_SUB, PairCache};
pub use pairs::{Batch, Near, collide, collide_again};
pub use shapes::compound::Compound;
pub use shapes::height_field::HeightField;
pub use shapes::submerged::Submerged;
pub use shapes::triangle::closest_point as closest_point_of_triangle;
pub use shapes::{MassProperties, PointHit, RayHit, Shape};
pub use tree::Bvh;
