//! Scene files: versioned JSON with a published schema, meshes from files, timed actions, probes and expectations.
//!
//! [`Scene::load`] reads and checks everything a file says and tells the first mistake with file, line, column, key
//! and what was expected.
#![forbid(unsafe_code)]
#![allow(dead_code)]

mod bodies;
mod error;
mod json;
pub mod limits;
mod load;
mod mesh;
mod plan;
mod random;
mod read;
mod shapes;
pub mod spec;

pub use error::{Fault, SceneError};
pub use json::{KeyPath, Position, Segment};
pub use load::{LoadOptions, Scene};
pub use mesh::MeshData;
