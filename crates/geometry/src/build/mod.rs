//! Builders of shapes with data.
pub mod hull;
mod merge;
pub mod mesh;
mod quickhull;
