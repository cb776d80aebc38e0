//! Questions about the world: rays, casts, overlaps, closest points.
//!
//! * Positions are subtracted in `f64` before anything is rounded, so answers are as good far from the origin as at it. The
//!   trees hold `f32` boxes rounded outward; queries grow by the rounding of their own coordinates, so that no box hides a
//!   shape.
//! * Of equally good answers the shape with the lowest slot wins, and lists are sorted: what the trees look like cannot be
//!   seen.
//! * The first question after a step in which much moved brings the tree of what moves up to date (`crate::moving`); others
//!   that are asked at that moment wait for it.
//! * Input that is not finite (or a shape that fails [`Shape::check`]) finds nothing.

mod cast;
mod overlap;
mod point;
mod ray;

pub use cast::ShapeCastHit;
pub use point::ClosestPoint;
pub use ray::{Ray, RayCastHit};

use crate::handle::{BodyId, ShapeId};
use crate::room::contacts::state::ShapeRecord;
use crate::room::rigid::desc::BodyKind;
use crate::world::World;
use core::fmt;
use jounce_geometry::{NO_SUB, Shape};
use jounce_math::{DVec3, Pose, Vec3, WorldPose};

/// What a query sees.
#[derive(Clone, Copy)]
pub struct QueryFilter<'a> {
    /// Layers to see (bits). Default all.
    pub layers: u32,
    /// A body not to see.
    pub exclude: Option<BodyId>,
    /// Sees fixed bodies. Default true.
    pub fixed: bool,
    /// Sees kinematic bodies. Default true.
    pub kinematic: bool,
    /// Sees dynamic bodies. Default true.
    pub dynamic: bool,
    /// Sees sensors. Default false.
    pub sensors: bool,
    /// Anything else: false hides a shape.
    pub predicate: Option<&'a (dyn Fn(ShapeId) -> bool + Sync)>,
}

impl<'a> QueryFilter<'a> {
    /// Sees these layers.
    pub fn layers(mut self, layers: u32) -> Self {
        self.layers = layers;
        self
    }
    /// Does not see this body.
    pub fn excluding(mut self, body: BodyId) -> Self {
        self.exclude = Some(body);
        self
    }
    /// Sees sensors too.
    pub fn with_sensors(mut self) -> Self {
        self.sensors = true;
        self
    }
    /// Sees only shapes for which `f` holds.
    pub fn only(mut self, f: &'a (dyn Fn(ShapeId) -> bool + Sync)) -> Self {
        self.predicate = Some(f);
        self
    }
}

impl Default for QueryFilter<'_> {
    fn default() -> Self {
        Self {
            layers: u32::MAX,
            exclude: None,
            fixed: true,
            kinematic: true,
            dynamic: true,
            sensors: false,
            predicate: None,
        }
    }
}

impl fmt::Debug for QueryFilter<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kinds = (self.fixed, self.kinematic, self.dynamic, self.sensors);
        f.debug_struct("QueryFilter")
            .field("layers", &self.layers)
            .field("exclude", &self.exclude)
            .field("kinds", &kinds)
            .finish()
    }
}

impl World {
    /// Does a query with this filter see the shape in a slot?
    #[inline]
    pub(crate) fn sees(&self, slot: u32, filter: &QueryFilter<'_>) -> bool {
        let r = &self.shapes[slot];
        if (r.sensor && !filter.sensors) || r.filter.layers & filter.layers == 0 {
            return false;
        }
        // Most queries ask for nothing else: the body's record stays out of the cache.
        if !(filter.fixed && filter.kinematic && filter.dynamic) {
            let kind = match self.bodies[r.body].kind {
                BodyKind::Fixed => filter.fixed,
                BodyKind::Kinematic => filter.kinematic,
                BodyKind::Dynamic => filter.dynamic,
            };
            if !kind {
                return false;
            }
        }
        filter.exclude.is_none_or(|b| b != self.body_id(r.body))
            && filter.predicate.is_none_or(|p| p(self.shape_id(slot)))
    }

    /// A shape's frame in the world; the same bits as [`crate::ShapeRef::world_pose`], without the products that most shapes do
    /// not need.
    #[inline]
    pub(crate) fn pose_of(&self, r: &ShapeRecord) -> WorldPose {
        let f = &self.frames[r.body as usize];
        if r.pose == Pose::IDENTITY && f.local_center == Vec3::ZERO {
            return WorldPose::new(f.center, f.rotation);
        }
        f.shape_pose(&r.pose)
    }
}

/// Triangle or child, where the shape has parts.
fn part(sub: u32) -> Option<u32> {
    (sub != NO_SUB).then_some(sub)
}

/// How far the rounding of a point to `f32` may have moved it, with as much again for the sum that uses it.
fn rounding(p: Vec3) -> Vec3 {
    p.abs() * f32::EPSILON
}

/// A bound widened by the roundings of a hit, so that equals behind it are still found.
fn widened(bound: f32) -> f32 {
    bound * (1.0 + 8.0 * f32::EPSILON)
}

/// A shape and pose that a query can use: everything finite, the rotation a unit quaternion.
fn usable(shape: &Shape, pose: &WorldPose) -> Option<WorldPose> {
    let l = pose.q.length();
    let turn = pose.q.is_finite() && l > 1e-6 && l < 1e6;
    let near = pose.p.is_finite() && pose.p.as_vec3().is_finite();
    (turn && near && shape.check().is_ok()).then(|| WorldPose::new(pose.p, pose.q.normalize()))
}

/// Is the point finite in the trees' coordinates too?
fn reachable(p: DVec3) -> bool {
    p.is_finite() && p.as_vec3().is_finite()
}
