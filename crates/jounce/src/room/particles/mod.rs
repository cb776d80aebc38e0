//! Particles: points with mass and a radius that fly, are carried by the medium, bounce, and die.
//!
//! # Model
//! A particle is born by an emitter at its exact time within a step and moves by
//!
//! ```text
//! m dv/dt = m g + m a_fields − ρ V g (in a liquid) − m g ΔT/T (hot)
//!           − m k (v − u) − 6πηr (v − u) − ½ρ C_d πr² |v − u| (v − u)
//! dx/dt   = v
//! ```
//!
//! with u the flow of the medium and turbulence. It feels the bodies' world, shapes and fields, and not other particles.
//! It has no rotation.
//!
//! * Step: forces → acceleration → velocity → position (semi-implicit Euler), drag implicit and exact at terminal speed, wide
//!   (`solve.rs`).
//! * Hits: V_b = (1 − K_f) V_t − K_r V_n at the time of the hit, found by a swept ball against the shapes where they go in the
//!   step (`collide.rs`, `ball.rs`; on the ground wide, `on_plane.rs`).
//! * Pushes on dynamic bodies, one after the other, with the effective mass of both (`settle.rs`).
//! * Turbulence: the curl of a random potential (`noise.rs`). Heat: Boussinesq's approximation with Newton's cooling
//!   ([`desc::Heat`]).
//! * Random numbers: hashes of (seed, emitter, serial, purpose) (`birth.rs`).
//!
//! # Order
//! Emitters in slot order, particles in order of birth: that is the order of reading, of the hash, of events and of pushes.
//! Blocks of 64 are stepped in parallel; a block depends on no other.
//!
//! # Symbols
//! `p`, `v` position from the emitter's origin and velocity; `age`, `life` s; `u` velocity at a hit, `a` acceleration; `n`
//! normal out of the shape; `s` part of the step that is over, `t` part of a motion.
//!
//! # Sources
//! Course slides "Particle Systems", "Particle Dynamics Algorithm", "Collision Response"; Reeves 1983, "Particle systems" (ACM
//! TOG 2); Bridson et al. 2007, "Curl-noise for procedural fluid flow".

pub(crate) mod ball;
pub(crate) mod birth;
pub(crate) mod blast;
pub(crate) mod collide;
pub mod desc;
pub(crate) mod edit;
pub(crate) mod noise;
pub(crate) mod obstacles;
pub(crate) mod on_plane;
pub(crate) mod prepare;
pub mod presets;
pub(crate) mod settle;
pub(crate) mod solve;
pub(crate) mod state;
#[cfg(test)]
mod tests;
pub mod view;
