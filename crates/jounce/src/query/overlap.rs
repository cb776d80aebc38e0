//! Who is here?

use super::{QueryFilter, reachable, usable};
use crate::edit::{round_down, round_up, world_bounds};
use crate::handle::ShapeId;
use crate::limits;
use crate::world::World;
use jounce_geometry::{Aabb, Shape, overlap};
use jounce_math::{DVec3, Pose, Vec3, WorldPose};
use jounce_tasks::FloatEnv;

impl World {
    /// Shapes that overlap or touch `shape` at `at`, sorted by slot.
    pub fn overlap_shape(&self, shape: &Shape, at: &WorldPose, filter: &QueryFilter<'_>) -> Vec<ShapeId> {
        let Some(at) = usable(shape, at) else { return Vec::new() };
        self.collect(&world_bounds(shape, &at), filter, |slot| {
            let r = &self.shapes[slot];
            overlap(&r.shape, shape, &self.pose_of(r).relative(&at))
        })
    }

    /// Shapes whose tight bounds meet the box from `min` to `max` (half-spaces: that reach into it), sorted by slot.
    pub fn overlap_aabb(&self, min: DVec3, max: DVec3, filter: &QueryFilter<'_>) -> Vec<ShapeId> {
        let ordered = min.x <= max.x && min.y <= max.y && min.z <= max.z;
        if !(reachable(min) && reachable(max) && ordered) {
            return Vec::new();
        }
        self.collect(&rounded_out(min, max), filter, |slot| self.bounds_meet(slot, min, max))
    }

    /// Solids that the point is inside (or on), sorted by slot.
    pub fn overlap_point(&self, point: DVec3, filter: &QueryFilter<'_>) -> Vec<ShapeId> {
        if !reachable(point) {
            return Vec::new();
        }
        self.collect(&rounded_out(point, point), filter, |slot| {
            let r = &self.shapes[slot];
            r.shape.contains_point(self.pose_of(r).inverse_transform_point(point))
        })
    }

    /// Visible shapes near the box for which `is_here` holds, sorted; at most [`limits::QUERY_HITS_MAX`].
    fn collect(
        &self,
        bounds: &Aabb,
        filter: &QueryFilter<'_>,
        is_here: impl Fn(u32) -> bool,
    ) -> Vec<ShapeId> {
        let _mode = FloatEnv::set_default();
        let mut found = Vec::new();
        let mut see = |slot: u32| {
            if self.sees(slot, filter) && is_here(slot) {
                found.push(slot);
            }
            true
        };
        for &plane in &self.unbounded {
            see(plane);
        }
        self.fixed_tree.query(bounds, &mut see);
        self.moving_tree.get().query(bounds, &mut see);
        found.sort_unstable();
        found.truncate(limits::QUERY_HITS_MAX);
        found.into_iter().map(|slot| self.shape_id(slot)).collect()
    }

    fn bounds_meet(&self, slot: u32, min: DVec3, max: DVec3) -> bool {
        let r = &self.shapes[slot];
        let pose = self.pose_of(r);
        if let Shape::HalfSpace { normal, offset } = r.shape {
            let n = pose.q.rotate(normal).as_dvec3();
            let low = |n: f64, min: f64, max: f64| if n > 0.0 { min } else { max };
            let corner = DVec3::new(low(n.x, min.x, max.x), low(n.y, min.y, max.y), low(n.z, min.z, max.z));
            return n.dot(corner - pose.p) <= f64::from(offset);
        }
        let local = r.shape.aabb(&Pose::new(Vec3::ZERO, pose.q));
        let (lo, hi) = (local.min.as_dvec3() + pose.p, local.max.as_dvec3() + pose.p);
        let meet = |a: f64, b: f64, c: f64, d: f64| a <= d && c <= b;
        meet(lo.x, hi.x, min.x, max.x) && meet(lo.y, hi.y, min.y, max.y) && meet(lo.z, hi.z, min.z, max.z)
    }
}

/// The smallest f32 box around a box.
fn rounded_out(min: DVec3, max: DVec3) -> Aabb {
    Aabb::new(
        Vec3::new(round_down(min.x), round_down(min.y), round_down(min.z)),
        Vec3::new(round_up(max.x), round_up(max.y), round_up(max.z)),
    )
}
