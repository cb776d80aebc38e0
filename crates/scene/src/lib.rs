//! Scene files: versioned JSON with a published schema, meshes from files, timed actions, probes and expectations.
//!
//! [`Scene::load`] reads and checks everything a file says and tells the first mistake with file, line, column, key
//! and what was expected.
#![forbid(unsafe_code)]

mod bodies;
mod characters;
mod color;
mod decompose;
mod emitters;
mod error;
mod fields;
mod joints;
mod json;
pub mod limits;
mod load;
mod mesh;
mod movers;
mod plan;
mod probe;
mod ragdolls;
mod random;
mod read;
mod report;
mod samples;
mod shapes;
mod simulation;
pub mod spec;
mod systems;
mod vehicles;

pub use error::{Fault, SceneError};
pub use joints::JointLook;
pub use json::{KeyPath, Position, Segment};
pub use load::{LoadOptions, Scene};
pub use mesh::MeshData;
pub use report::{Expectation, Expected, Momentum, Report, StartEnd, StepMs};
pub use samples::Samples;
pub use simulation::Simulation;
pub use systems::System;
