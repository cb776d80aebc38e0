//! One room per kind of matter or law. Rooms never call rooms: they meet in [`crate::stage`].

pub mod characters;
pub mod contacts;
pub mod fields;
pub mod joints;
pub mod particles;
pub mod ragdoll;
pub mod rigid;
pub mod vehicles;
