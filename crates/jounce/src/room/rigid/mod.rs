//! Rigid bodies.
pub mod desc;
