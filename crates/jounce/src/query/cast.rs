//! Shapes pushed along a line.

use super::{QueryFilter, part, rounding, usable, widened};
use crate::edit::world_bounds;
use crate::handle::{BodyId, ShapeId};
use crate::limits;
use crate::world::World;
use jounce_geometry::{CastHit, Shape, cast_shape};
use jounce_math::{DVec3, Vec3, WorldPose, scalar::f32s};
use jounce_tasks::FloatEnv;

/// Where a moving shape first touched another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeCastHit {
    /// The shape that was hit.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// Fraction of the motion, 0…1; 0 for an overlap at the start.
    pub t: f32,
    /// Where they touch, world.
    pub point: DVec3,
    /// Unit normal out of the shape that was hit, world axes.
    pub normal: Vec3,
    /// Triangle of a mesh, cell triangle of a height field, or child of a compound.
    pub triangle: Option<u32>,
}

impl World {
    /// The first shape that `shape`, moved from `from` by `motion` (metres, without turning), touches; the lowest slot of
    /// equals.
    pub fn cast_shape(
        &self,
        shape: &Shape,
        from: &WorldPose,
        motion: Vec3,
        filter: &QueryFilter<'_>,
    ) -> Option<ShapeCastHit> {
        let mut best: Option<(u32, CastHit)> = None;
        let mut bound = 1.0;
        self.sweep(shape, from, motion, filter, |slot, h| {
            if best.is_none_or(|(s, b)| (h.t, slot) < (b.t, s)) {
                best = Some((slot, h));
                bound = f32s::min(widened(h.t), bound);
            }
            bound
        });
        best.map(|(slot, h)| self.cast_result(slot, &h))
    }

    /// Every shape that the moving shape touches on its way, each at its first touch; sorted by t, then slot. At most
    /// [`limits::QUERY_HITS_MAX`], the first ones.
    pub fn cast_shape_all(
        &self,
        shape: &Shape,
        from: &WorldPose,
        motion: Vec3,
        filter: &QueryFilter<'_>,
    ) -> Vec<ShapeCastHit> {
        let mut hits: Vec<(u32, CastHit)> = Vec::new();
        self.sweep(shape, from, motion, filter, |slot, h| {
            hits.push((slot, h));
            1.0
        });
        hits.sort_unstable_by(|a, b| a.1.t.total_cmp(&b.1.t).then(a.0.cmp(&b.0)));
        hits.truncate(limits::QUERY_HITS_MAX);
        hits.into_iter().map(|(slot, h)| self.cast_result(slot, &h)).collect()
    }

    /// Calls `found(slot, hit)` for the visible shapes in the way; it gives how far the motion still goes.
    fn sweep(
        &self,
        shape: &Shape,
        from: &WorldPose,
        motion: Vec3,
        filter: &QueryFilter<'_>,
        mut found: impl FnMut(u32, CastHit) -> f32,
    ) {
        let _mode = FloatEnv::set_default();
        let Some(from) = usable(shape, from) else { return };
        if !motion.is_finite() {
            return;
        }
        let mut see = |slot: u32, bound: f32| {
            if !self.sees(slot, filter) {
                return bound;
            }
            let pose = self.pose_of(&self.shapes[slot]);
            self.cast_on_shape(slot, &pose, shape, &from, motion).map_or(bound, |h| found(slot, h))
        };
        let mut bound = 1.0;
        for &plane in &self.unbounded {
            bound = see(plane, bound);
        }
        let bounds = world_bounds(shape, &from);
        let center = bounds.center();
        let half = bounds.half();
        // A cast ends within 1e-6 of the shapes' size: what it calls touching must not be a miss of the boxes.
        let half = half + rounding(center) * 2.0 + Vec3::splat(1e-5 * half.max_component());
        for tree in [&self.fixed_tree, self.moving_tree.get()] {
            tree.ray(center, motion, half, widened(bound), |slot, _| {
                bound = see(slot, bound);
                widened(bound)
            });
        }
    }

    /// The moving shape against one other, which stands at `pose`, in that one's frame.
    pub(crate) fn cast_on_shape(
        &self,
        slot: u32,
        pose: &WorldPose,
        shape: &Shape,
        from: &WorldPose,
        motion: Vec3,
    ) -> Option<CastHit> {
        cast_shape(&self.shapes[slot].shape, shape, &pose.relative(from), pose.q.inverse_rotate(motion))
    }

    fn cast_result(&self, slot: u32, hit: &CastHit) -> ShapeCastHit {
        let r = &self.shapes[slot];
        let pose = self.pose_of(r);
        ShapeCastHit {
            shape: self.shape_id(slot),
            body: self.body_id(r.body),
            t: hit.t,
            point: pose.transform_point(hit.point),
            normal: pose.q.rotate(hit.normal),
            triangle: part(hit.sub_a),
        }
    }
}
