//! What a picture shows beside the world's shapes: particles, springs, trails, cloth.
//!
//! A caller fills an [`Extras`] for each picture and hands it to [`crate::render_with`]. The lists' order does not
//! change a bit of the picture. Items with numbers that nothing can have (NaN, a negative radius, no opacity) are
//! left out.
//!
//! Two kinds of items go two ways (`prepare.rs`):
//!
//! * *Solids*: hard, opaque and at least a pixel wide. Rays meet them as they meet the world's shapes (`solid.rs`), so
//!   they hide, are lit, and cast and receive shadows.
//! * *Layers*: soft, translucent, glowing, or too thin for one ray per pixel. All layers before the solid are gathered
//!   along the ray, sorted by distance and blended with what is behind (`layer.rs`). They dim the sun for what lies
//!   in their shadow and for each other; what only glows casts no shadow.

mod layer;
mod prepare;
mod solid;
mod sweep;
#[cfg(test)]
mod tests;
mod tiles;

pub(crate) use layer::Bag;
pub(crate) use prepare::{Props, is_extra};

use crate::water::Water;
use jounce::math::{DVec3, Vec3};

/// A particle or a ball.
///
/// ```
/// use jounce_render::{Ball, Extras};
/// let mut extras = Extras::default();
/// extras.balls.push(Ball::new([0.0, 1.0, 0.0], 0.5, [0.9, 0.3, 0.2]));
/// extras.balls.push(Ball::new([0.0, 2.0, 0.0], 0.8, [0.4; 3]).soft().opacity(0.2));
/// extras.balls.push(Ball::new([0.0, 3.0, 0.0], 0.3, [1.0, 0.5, 0.1]).soft().opacity(0.5).glow(0.9));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// World metres.
    pub center: DVec3,
    /// Metres; above 0.
    pub radius: f32,
    /// sRGB, 0…1.
    pub color: [f32; 3],
    /// Part of the light from behind that the middle of the ball stops, 0…1.
    pub opacity: f32,
    /// Part of the ball that shines, 0…1: it adds its colour to the picture and stops nothing. Flames against a
    /// bright sky look best around 0.8, sparks at 1.
    pub glow: f32,
    /// Density falls off towards the rim: smoke and fire. Soft balls fade where they meet solids.
    pub soft: bool,
}

impl Ball {
    /// A hard opaque ball.
    pub fn new(center: impl Into<DVec3>, radius: f32, color: [f32; 3]) -> Self {
        Self { center: center.into(), radius, color, opacity: 1.0, glow: 0.0, soft: false }
    }
    /// The ball with another opacity.
    pub fn opacity(self, opacity: f32) -> Self {
        Self { opacity, ..self }
    }
    /// The ball with a part that shines.
    pub fn glow(self, glow: f32) -> Self {
        Self { glow, ..self }
    }
    /// The ball with a density that falls off.
    pub fn soft(self) -> Self {
        Self { soft: true, ..self }
    }
}

/// A round bar: a spring, a rope's piece, a part of a trail. Opaque ones have round ends; translucent ones are cut
/// flat, so that the pieces of a line do not show twice where they meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rod {
    /// One end, world metres.
    pub a: DVec3,
    /// Other end.
    pub b: DVec3,
    /// Metres; above 0. However thin, a rod is at least about a pixel wide on the picture.
    pub radius: f32,
    /// sRGB, 0…1.
    pub color: [f32; 3],
    /// As of a [`Ball`].
    pub opacity: f32,
    /// As of a [`Ball`].
    pub glow: f32,
}

impl Rod {
    /// An opaque rod.
    pub fn new(a: impl Into<DVec3>, b: impl Into<DVec3>, radius: f32, color: [f32; 3]) -> Self {
        Self { a: a.into(), b: b.into(), radius, color, opacity: 1.0, glow: 0.0 }
    }
    /// The rod with another opacity.
    pub fn opacity(self, opacity: f32) -> Self {
        Self { opacity, ..self }
    }
    /// The rod with a part that shines.
    pub fn glow(self, glow: f32) -> Self {
        Self { glow, ..self }
    }
}

/// An opaque triangle seen from both sides: cloth, the skin of a jelly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Corner, world metres.
    pub a: DVec3,
    /// Corner.
    pub b: DVec3,
    /// Corner.
    pub c: DVec3,
    /// sRGB, 0…1.
    pub color: [f32; 3],
    /// Unit normals at the corners, on whichever side: the face looks bent. Without them it looks flat.
    pub normals: Option<[Vec3; 3]>,
}

impl Face {
    /// A flat face.
    pub fn new(a: impl Into<DVec3>, b: impl Into<DVec3>, c: impl Into<DVec3>, color: [f32; 3]) -> Self {
        Self { a: a.into(), b: b.into(), c: c.into(), color, normals: None }
    }
    /// The face with normals at its corners.
    pub fn normals(self, normals: [Vec3; 3]) -> Self {
        Self { normals: Some(normals), ..self }
    }
}

/// What a picture shows beside the world's shapes. At most 2³⁰ items of each kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extras {
    /// Particles.
    pub balls: Vec<Ball>,
    /// Springs and trails.
    pub rods: Vec<Rod>,
    /// Cloth and skins.
    pub faces: Vec<Face>,
    /// Waters.
    pub waters: Vec<Water>,
}

impl Extras {
    /// Nothing to draw?
    pub fn is_empty(&self) -> bool {
        self.balls.is_empty() && self.rods.is_empty() && self.faces.is_empty() && self.waters.is_empty()
    }

    /// Adds a smooth skin: triangles over shared points, whose normals are the means of the faces around them,
    /// weighted by area. A triangle that names a point beyond the list is left out.
    pub fn skin(&mut self, points: &[DVec3], triangles: &[[u32; 3]], color: [f32; 3]) {
        let corner = |k: u32| points.get(k as usize).copied();
        let corners = |t: &[u32; 3]| Some([corner(t[0])?, corner(t[1])?, corner(t[2])?]);
        let mut sums = vec![Vec3::ZERO; points.len()];
        for t in triangles {
            let Some([a, b, c]) = corners(t) else { continue };
            let area = (b - a).as_vec3().cross((c - a).as_vec3());
            t.iter().for_each(|&k| sums[k as usize] += area);
        }
        for t in triangles {
            let Some([a, b, c]) = corners(t) else { continue };
            let flat = (b - a).as_vec3().cross((c - a).as_vec3());
            let normals = [0, 1, 2].map(|k| sums[t[k] as usize].normalize_or(flat.normalize_or(Vec3::Y)));
            self.faces.push(Face { a, b, c, color, normals: Some(normals) });
        }
    }
}
