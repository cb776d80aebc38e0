//! Particles.

pub(crate) mod ball;
pub(crate) mod birth;
pub(crate) mod collide;
pub mod desc;
pub(crate) mod edit;
pub(crate) mod noise;
pub(crate) mod obstacles;
pub(crate) mod on_plane;
pub(crate) mod prepare;
pub(crate) mod settle;
pub(crate) mod solve;
pub(crate) mod state;
pub mod view;
