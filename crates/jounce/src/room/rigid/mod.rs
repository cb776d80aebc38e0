//! Rigid bodies: free motion.
//!
//! State: centre of mass c (world, f64), rotation q, velocity v, angular velocity ω.
//!
//! * v′ = g + F/m − c_d v,  ω′ = I⁻¹ τ − c_a ω + gyroscopic part,  c′ = v,  q′ = ½ ω q.
//! * Semi-implicit Euler per substep h: first v and ω from forces, then constraints, then c and q from the new v and ω.
//! * Damping is implicit: v ← v / (1 + c h), which never reverses a velocity.
//! * The gyroscopic part is a torque-free turn by symmetric splitting, and what contacts and forces change of ω is taken over
//!   as angular momentum; see [`free`].
//!
//! A body's velocity is that of its centre of mass; its *position* in the API is that of its origin.

pub mod desc;
pub(crate) mod finish;
pub(crate) mod free;
pub(crate) mod mass;
pub(crate) mod pass;
pub(crate) mod solve;
pub(crate) mod state;
pub(crate) mod turn;
