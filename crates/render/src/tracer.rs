//! What the renderer asks of a world: where does this ray hit?

use crate::look::Skin;
use jounce::math::{DVec3, Vec3};

/// Where a ray met a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the unit ray, metres.
    pub t: f32,
    /// Unit outward normal.
    pub normal: Vec3,
    /// Which surface: an index of [`Tracer::skin`]; equal for points of one shape.
    pub surface: u32,
}

/// Anything that rays can be cast at.
pub trait Tracer: Sync {
    /// First hit of a ray with a unit direction within `max_t` metres.
    fn trace(&self, origin: DVec3, dir: Vec3, max_t: f32) -> Option<Hit>;
    /// Is anything hit within `max_t` metres?
    fn occluded(&self, origin: DVec3, dir: Vec3, max_t: f32) -> bool {
        self.trace(origin, dir, max_t).is_some()
    }
    /// How a surface looks.
    fn skin(&self, surface: u32) -> Skin;
    /// A world point in the surface's own frame, in which its pattern is fixed.
    fn to_local(&self, surface: u32, point: DVec3) -> Vec3;
}
