//! What several tests share: a counter generator, random worlds, and a look at everything a world shows.
#![allow(dead_code, reason = "every test uses a part of this")]

pub mod fields;
pub mod look;
pub mod movers;
pub mod particles;
pub mod rng;
pub mod storm;

/// Full counts were asked for.
pub fn prove() -> bool {
    std::env::var_os("JOUNCE_PROVE").is_some()
}
