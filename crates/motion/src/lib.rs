//! The textbook in `f64`: motion as the lecture hall tells it, without a world.
//!
//! Closed forms, force laws, integrators, point masses and springs, collisions with planes, projectiles and rigid
//! rotation. Everything is a plain value or a pure function; nothing here knows shapes, contacts or time steps of an
//! engine, so the same laws can be called from the engine and held beside it.
//!
//! SI units, right-handed axes, angles in radians. Only IEEE-exact operations in a written order and the
//! transcendentals of [`jounce_math::scalar`]: the same bits on every machine.
#![forbid(unsafe_code)]

pub mod ballistics;
pub mod cloth;
pub mod collide;
mod error;
pub mod force;
pub mod integrate;
pub mod jelly;
pub mod kinematics;
pub mod limits;
pub mod momentum;
pub mod nbody;
mod octree;
pub mod particles;
pub mod springs;

pub use error::{Error, Result};
