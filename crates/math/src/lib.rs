//! Vectors, quaternions, matrices and poses with one fixed order of operations.
//!
//! Every function here gives the same bits on every machine: only IEEE-exact operations
//! (`+ − × ÷ √`) in a written order, no fused multiply-add, no approximate reciprocal, and
//! transcendentals from the pinned [`libm`] crate (re-exported through [`scalar`]), never from `std`.
//!
//! Two precisions: `f32` for everything local (rotations, velocities, anchors, vertices), `f64` for
//! positions in the world. [`Pose`] is a rigid transform between local frames; [`WorldPose`] places a
//! frame in the world.
#![forbid(unsafe_code)]

mod mat;
mod pose;
mod quat;
pub mod scalar;
mod vec;

pub use mat::{DMat3, Mat3};
pub use pose::{Pose, WorldPose};
pub use quat::{DQuat, Quat};
pub use vec::{DVec3, Vec3};

#[cfg(test)]
mod tests;
