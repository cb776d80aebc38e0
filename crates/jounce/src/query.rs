//! Questions about the world: rays, casts, overlaps, closest points. Ties go to the lowest slot; lists are sorted.

use crate::handle::{BodyId, ShapeId};
use crate::room::rigid::desc::BodyKind;
use crate::world::World;
use core::fmt;
use jounce_math::{DVec3, Vec3};

/// A ray: origin + t·dir, 0 ≤ t ≤ max_t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start, world.
    pub origin: DVec3,
    /// Direction; any length but zero. t counts in this length.
    pub dir: Vec3,
    /// Farthest t.
    pub max_t: f32,
}

impl Ray {
    /// A ray without end; t is in metres when `dir` is a unit vector.
    pub fn new(origin: impl Into<DVec3>, dir: impl Into<Vec3>) -> Self {
        Self { origin: origin.into(), dir: dir.into(), max_t: f32::MAX }
    }
}

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

/// Where a ray met a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayCastHit {
    /// The shape.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// Ray parameter.
    pub t: f32,
    /// Point, world.
    pub point: DVec3,
    /// Unit outward normal, world axes.
    pub normal: Vec3,
    /// Triangle of a mesh, cell triangle of a height field, or child of a compound.
    pub triangle: Option<u32>,
}

impl World {
    /// Does a query with this filter see the shape in a slot?
    pub(crate) fn sees(&self, slot: u32, filter: &QueryFilter<'_>) -> bool {
        let r = &self.shapes[slot];
        let kind = match self.bodies[r.body].kind {
            BodyKind::Fixed => filter.fixed,
            BodyKind::Kinematic => filter.kinematic,
            BodyKind::Dynamic => filter.dynamic,
        };
        kind && (filter.sensors || !r.sensor)
            && r.filter.layers & filter.layers != 0
            && filter.exclude != Some(self.body_id(r.body))
            && filter.predicate.is_none_or(|p| p(self.shape_id(slot)))
    }

    /// The ray against one shape, in the shape's own frame (the subtraction is in f64).
    fn ray_on_shape(&self, slot: u32, ray: &Ray, max_t: f32) -> Option<RayCastHit> {
        let r = &self.shapes[slot];
        let pose = self.frames[r.body as usize].shape_pose(&r.pose);
        let origin = pose.inverse_transform_point(ray.origin);
        let hit = r.shape.ray_cast(origin, pose.q.inverse_rotate(ray.dir), max_t)?;
        Some(RayCastHit {
            shape: self.shape_id(slot),
            body: self.body_id(r.body),
            t: hit.t,
            point: ray.origin + ray.dir.as_dvec3() * f64::from(hit.t),
            normal: pose.q.rotate(hit.normal),
            triangle: (hit.sub != jounce_geometry::NO_SUB).then_some(hit.sub),
        })
    }

    /// The first shape that a ray meets; the lowest slot of equals. `None` too for a ray that is not finite.
    pub fn cast_ray(&self, ray: &Ray, filter: &QueryFilter<'_>) -> Option<RayCastHit> {
        if !ray.origin.is_finite() || !ray.dir.is_finite() || ray.dir == Vec3::ZERO || ray.max_t.is_nan() {
            return None;
        }
        let mut best: Option<RayCastHit> = None;
        let mut see = |slot: u32, max_t: f32| {
            if !self.sees(slot, filter) {
                return max_t;
            }
            let Some(h) = self.ray_on_shape(slot, ray, max_t) else { return max_t };
            if best.is_none_or(|b| (h.t, h.shape.index) < (b.t, b.shape.index)) {
                best = Some(h);
            }
            h.t
        };
        let mut max_t = ray.max_t;
        for &plane in &self.unbounded {
            max_t = see(plane, max_t);
        }
        let origin = ray.origin.as_vec3();
        // The trees' boxes are rounded outward; growing them by the ray origin's own rounding keeps every hit.
        let slack = Vec3::splat(ray.origin.abs().max_component() as f32 * f32::EPSILON);
        self.fixed_tree.ray(origin, ray.dir, slack, max_t, |slot, t| {
            max_t = see(slot, t);
            max_t
        });
        self.moving_tree.ray(origin, ray.dir, slack, max_t, &mut see);
        best
    }
}
