//! Rays.

use super::{QueryFilter, part, reachable, rounding, widened};
use crate::handle::{BodyId, ShapeId};
use crate::limits;
use crate::world::World;
use jounce_geometry::{NO_SUB, RayHit, Shape};
use jounce_math::{DVec3, Vec3, WorldPose, scalar::f32s};
use jounce_tasks::FloatEnv;

/// Rays per unit of a batch.
const CHUNK: usize = 64;
/// Beyond this distance squared from the origin (1 km) a ray is followed to the shape in f64 first.
const FAR_SQUARED: f64 = 1e6;

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
    /// The segment from `a` (t = 0) to `b` (t = 1).
    pub fn between(a: impl Into<DVec3>, b: impl Into<DVec3>) -> Self {
        let origin = a.into();
        Self { origin, dir: (b.into() - origin).as_vec3(), max_t: 1.0 }
    }
    /// The point at t.
    pub fn at(&self, t: f32) -> DVec3 {
        self.origin + self.dir.as_dvec3() * f64::from(t)
    }
    fn is_usable(&self) -> bool {
        reachable(self.origin) && self.dir.is_finite() && self.dir != Vec3::ZERO && self.max_t >= 0.0
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
    /// Point, world: as exact as the shape's coordinates, even where t is so large that `Ray::at(t)` is rounded to metres.
    pub point: DVec3,
    /// Unit outward normal, world axes; towards the ray's origin on surfaces. −dir/|dir| where the ray starts inside.
    pub normal: Vec3,
    /// Triangle of a mesh, cell triangle of a height field, or child of a compound.
    pub triangle: Option<u32>,
}

impl World {
    /// The first shape that a ray meets; the lowest slot of equals. A ray that starts inside a solid meets it at t = 0.
    pub fn cast_ray(&self, ray: &Ray, filter: &QueryFilter<'_>) -> Option<RayCastHit> {
        let _mode = FloatEnv::set_default();
        self.first_hit_of(ray, filter)
    }

    /// Every shape that a ray meets, each at its first hit; sorted by t, then slot. At most
    /// [`limits::QUERY_HITS_MAX`], the nearest.
    pub fn cast_ray_all(&self, ray: &Ray, filter: &QueryFilter<'_>) -> Vec<RayCastHit> {
        let _mode = FloatEnv::set_default();
        let mut hits: Vec<(u32, Found)> = Vec::new();
        self.walk(ray, filter, |slot| {
            if let Some(h) = self.ray_on_shape(slot, ray, ray.max_t) {
                hits.push((slot, h));
            }
            Walk::On(ray.max_t)
        });
        hits.sort_unstable_by(|a, b| a.1.t.total_cmp(&b.1.t).then(a.0.cmp(&b.0)));
        hits.truncate(limits::QUERY_HITS_MAX);
        hits.into_iter().map(|(slot, h)| self.ray_result(slot, ray, &h)).collect()
    }

    /// Does the ray meet anything at all? Stops at whatever it finds first: for shadows and lines of sight.
    pub fn ray_blocked(&self, ray: &Ray, filter: &QueryFilter<'_>) -> bool {
        let _mode = FloatEnv::set_default();
        self.is_blocked(ray, filter)
    }

    /// [`World::cast_ray`] for many rays, on [`World::tasks`]; one answer per ray, in order.
    pub fn cast_rays(&self, rays: &[Ray], filter: &QueryFilter<'_>) -> Vec<Option<RayCastHit>> {
        let mut out = vec![None; rays.len()];
        self.tasks.for_each(&mut out, CHUNK, |i, hit| *hit = self.first_hit_of(&rays[i], filter));
        out
    }

    /// [`World::ray_blocked`] for many rays, on [`World::tasks`]; one answer per ray, in order.
    pub fn rays_blocked(&self, rays: &[Ray], filter: &QueryFilter<'_>) -> Vec<bool> {
        let mut out = vec![false; rays.len()];
        self.tasks.for_each(&mut out, CHUNK, |i, hit| *hit = self.is_blocked(&rays[i], filter));
        out
    }

    fn first_hit_of(&self, ray: &Ray, filter: &QueryFilter<'_>) -> Option<RayCastHit> {
        let mut best: Option<(u32, Found)> = None;
        let mut bound = ray.max_t;
        self.walk(ray, filter, |slot| {
            if let Some(h) = self.ray_on_shape(slot, ray, bound)
                && best.is_none_or(|(s, b)| (h.t, slot) < (b.t, s))
            {
                best = Some((slot, h));
                bound = f32s::min(widened(h.hit.t), bound);
            }
            Walk::On(bound)
        });
        best.map(|(slot, h)| self.ray_result(slot, ray, &h))
    }

    fn is_blocked(&self, ray: &Ray, filter: &QueryFilter<'_>) -> bool {
        let mut blocked = false;
        self.walk(ray, filter, |slot| {
            blocked = self.ray_on_shape(slot, ray, ray.max_t).is_some();
            if blocked { Walk::Stop } else { Walk::On(ray.max_t) }
        });
        blocked
    }

    /// Calls `visit` for every visible shape whose box the ray meets, near boxes first within each tree; it tells how far
    /// the ray still goes.
    #[inline]
    fn walk(&self, ray: &Ray, filter: &QueryFilter<'_>, mut visit: impl FnMut(u32) -> Walk) {
        if !ray.is_usable() {
            return;
        }
        let mut bound = widened(ray.max_t);
        let mut see = |slot: u32, max_t: f32| {
            if !self.sees(slot, filter) {
                return max_t;
            }
            bound = match visit(slot) {
                Walk::On(t) => f32s::min(widened(t), bound),
                Walk::Stop => -1.0,
            };
            bound
        };
        let mut max_t = widened(ray.max_t);
        for &plane in &self.unbounded {
            max_t = see(plane, max_t);
            if max_t < 0.0 {
                return;
            }
        }
        let origin = ray.origin.as_vec3();
        let slack = rounding(origin);
        for tree in [&self.fixed_tree, self.moving_tree.get()] {
            if max_t < 0.0 {
                return;
            }
            tree.ray(origin, ray.dir, slack, max_t, |slot, t| {
                max_t = see(slot, t);
                max_t
            });
        }
    }

    #[inline]
    fn ray_on_shape(&self, slot: u32, ray: &Ray, max_t: f32) -> Option<Found> {
        self.ray_on_shape_at(slot, &self.pose_of(&self.shapes[slot]), ray, max_t)
    }

    /// The ray against one shape, which stands at `pose`, in its own frame (the subtraction is in f64).
    #[inline]
    pub(crate) fn ray_on_shape_at(
        &self,
        slot: u32,
        pose: &WorldPose,
        ray: &Ray,
        max_t: f32,
    ) -> Option<Found> {
        let r = &self.shapes[slot];
        let from = ray.origin - pose.p;
        let dir = pose.q.inverse_rotate(ray.dir);
        if from.length_squared() > FAR_SQUARED {
            return self.far_ray_on_shape(slot, ray, pose, dir, max_t);
        }
        r.shape.ray_cast(pose.q.inverse_rotate(from.as_vec3()), dir, max_t).map(Found::near)
    }

    /// From afar an origin in the shape's frame would be rounded to centimetres: the ray is followed to near the shape in f64,
    /// and cast from there.
    #[cold]
    fn far_ray_on_shape(
        &self,
        slot: u32,
        ray: &Ray,
        pose: &WorldPose,
        dir: Vec3,
        max_t: f32,
    ) -> Option<Found> {
        let r = &self.shapes[slot];
        if let Shape::HalfSpace { normal, offset } = r.shape {
            return far_ray_on_plane(normal, offset, ray, pose, max_t);
        }
        let d = ray.dir.as_dvec3();
        let length = d.length();
        let fat = &self.fat[slot as usize];
        let (lo, hi) = (fat.min.as_dvec3(), fat.max.as_dvec3());
        let to_center = (lo + hi) * 0.5 - ray.origin;
        let reach = (hi - lo).length() * 0.5 + 1.0;
        let start = to_center.dot(d) / (length * length) - reach / length;
        if start <= 0.0 {
            // Large shapes may be all around the origin.
            return r.shape.ray_cast(pose.inverse_transform_point(ray.origin), dir, max_t).map(Found::near);
        }
        let rest = f64::from(max_t) - start;
        if rest < 0.0 {
            return None;
        }
        let origin = pose.inverse_transform_point(ray.origin + d * start);
        let mut hit = r.shape.ray_cast(origin, dir, rest as f32)?;
        let t = start + f64::from(hit.t);
        hit.t = f32s::min(t as f32, max_t);
        Some(Found { hit, t })
    }

    fn ray_result(&self, slot: u32, ray: &Ray, found: &Found) -> RayCastHit {
        let (r, hit) = (&self.shapes[slot], &found.hit);
        RayCastHit {
            shape: self.shape_id(slot),
            body: self.body_id(r.body),
            t: hit.t,
            point: ray.origin + ray.dir.as_dvec3() * found.t,
            normal: self.pose_of(r).q.rotate(hit.normal),
            triangle: part(hit.sub),
        }
    }
}

/// A hit with its t before it was rounded: what lies metres apart may share a rounded one.
#[derive(Clone, Copy)]
pub(crate) struct Found {
    pub hit: RayHit,
    pub t: f64,
}

impl Found {
    fn near(hit: RayHit) -> Self {
        Self { hit, t: f64::from(hit.t) }
    }
}

/// A half-space has no bounds to go to first: its plane is met in f64.
fn far_ray_on_plane(normal: Vec3, offset: f32, ray: &Ray, pose: &WorldPose, max_t: f32) -> Option<Found> {
    let n = pose.q.as_dquat().normalize().rotate(normal.as_dvec3());
    let d = ray.dir.as_dvec3();
    let height = n.dot(ray.origin - pose.p) - f64::from(offset);
    if height < 0.0 {
        let inward = pose.q.inverse_rotate((d / d.length()).as_vec3());
        return Some(Found::near(RayHit { t: 0.0, normal: -inward, sub: NO_SUB }));
    }
    let fall = -n.dot(d);
    let t = height / fall;
    let met = fall > 0.0 && t <= f64::from(max_t);
    met.then_some(Found { hit: RayHit { t: t as f32, normal, sub: NO_SUB }, t })
}

/// What a visit of a shape says about the rest of the ray.
enum Walk {
    /// Go on, up to this t.
    On(f32),
    /// Enough.
    Stop,
}
