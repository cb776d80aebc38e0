//! Pictures of a world, made by casting rays at it with the engine's own queries; films and plots.
//!
//! * [`render()`]: a [`Camera`], a world (as a [`Stage`]; any [`Tracer`]) and an [`Overlay`] give an [`Image`].
//! * [`render_with()`] also draws [`Extras`]: particles, smoke, fire, springs, trails, cloth, water.
//! * [`add_joint()`]: rods, ropes, springs and axes of a world's joints, for the extras.
//! * [`add_vehicle()`], [`add_character()`]: wheels, tracks, boards and faces, for the extras.
//! * [`Trails`]: where moving points have been.
//! * [`Image`]: pixels, and PNG files; [`Film`]: animated GIFs.
//! * [`Plot`]: curves over time as SVG or as an [`Image`].
//!
//! No GPU, no display. The same input gives the same bytes with any number of threads.
#![forbid(unsafe_code)]

mod camera;
mod error;
mod extras;
mod film;
mod image;
mod joints;
mod look;
mod movers;
mod overlay;
mod parallel;
mod plot;
mod render;
mod text;
mod tracer;
mod trails;
mod water;
mod world;

pub use camera::Camera;
pub use error::{RenderError, Result};
pub use extras::{Ball, Extras, Face, Rod};
pub use film::Film;
pub use image::{Image, SIDE_MAX, write_whole};
pub use joints::add_joint;
pub use look::{Look, PALETTE, Pattern, Skin, palette, srgb};
pub use movers::{add_character, add_vehicle};
pub use overlay::{Dot, Line, Overlay};
pub use plot::{Plot, Series, Style};
pub use render::{RenderOptions, render, render_with};
pub use text::draw as draw_text;
pub use tracer::{Hit, Tracer};
pub use trails::Trails;
pub use water::Water;
pub use world::{Paint, Stage, contact_overlay, default_skin, sensor_overlay};

#[cfg(test)]
mod tests;
