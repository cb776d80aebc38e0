//! Builders of shapes with data.
pub mod hull;
pub mod mesh;
