//! What is nearest to a point?

use super::{QueryFilter, part, reachable, rounding, widened};
use crate::handle::{BodyId, ShapeId};
use crate::world::World;
use jounce_geometry::PointHit;
use jounce_math::{DVec3, Vec3, scalar::f32s};
use jounce_tasks::FloatEnv;

/// Points per unit of a batch.
const CHUNK: usize = 64;

/// The nearest point of a shape's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// The shape.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// The point on its surface, world.
    pub point: DVec3,
    /// Distance, metres; negative where the query point is inside a solid.
    pub distance: f32,
    /// Unit outward normal at the point, world axes.
    pub normal: Vec3,
    /// Triangle of a mesh, cell triangle of a height field, or child of a compound.
    pub triangle: Option<u32>,
}

impl World {
    /// The nearest surface within `max_distance` metres; inside of solids, the one the point is deepest in. The lowest slot
    /// of equals.
    pub fn closest_point(
        &self,
        point: DVec3,
        max_distance: f32,
        filter: &QueryFilter<'_>,
    ) -> Option<ClosestPoint> {
        let _mode = FloatEnv::set_default();
        self.nearest(point, max_distance, filter)
    }

    /// [`World::closest_point`] for many points, on [`World::tasks`]; one answer per point, in order.
    pub fn closest_points(
        &self,
        points: &[DVec3],
        max_distance: f32,
        filter: &QueryFilter<'_>,
    ) -> Vec<Option<ClosestPoint>> {
        let mut out = vec![None; points.len()];
        self.tasks.for_each(&mut out, CHUNK, |i, hit| *hit = self.nearest(points[i], max_distance, filter));
        out
    }

    fn nearest(&self, point: DVec3, max_distance: f32, filter: &QueryFilter<'_>) -> Option<ClosestPoint> {
        if !reachable(point) || max_distance.is_nan() {
            return None;
        }
        let mut best: Option<(u32, PointHit)> = None;
        let mut limit = max_distance;
        let mut see = |slot: u32| {
            if self.sees(slot, filter) {
                let r = &self.shapes[slot];
                let hit = r.shape.closest_point(self.pose_of(r).inverse_transform_point(point));
                if let Some(h) = hit.filter(|h| h.distance <= limit)
                    && best.is_none_or(|(s, b)| (h.distance, slot) < (b.distance, s))
                {
                    limit = h.distance;
                    best = Some((slot, h));
                }
            }
            limit
        };
        let mut bound = max_distance;
        for &plane in &self.unbounded {
            bound = see(plane);
        }
        let center = point.as_vec3();
        // A box is never farther than what it holds, but for the rounding of the point. Inside of solids the bound is
        // negative: any box around the point may hold a deeper one.
        let slack = 2.0 * rounding(center).length();
        let squared = |bound: f32| {
            let d = widened(f32s::max(bound, 0.0)) + slack;
            d * d
        };
        let mut reach = squared(bound);
        self.fixed_tree.nearest(center, reach, |slot, _| {
            reach = squared(see(slot));
            reach
        });
        self.moving_tree.get().nearest(center, reach, |slot, _| squared(see(slot)));
        let (slot, h) = best?;
        let r = &self.shapes[slot];
        let pose = self.pose_of(r);
        Some(ClosestPoint {
            shape: self.shape_id(slot),
            body: self.body_id(r.body),
            point: pose.transform_point(h.point),
            distance: h.distance,
            normal: pose.q.rotate(h.normal),
            triangle: part(h.sub),
        })
    }
}
