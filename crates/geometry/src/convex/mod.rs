//! Distances, overlaps and casts between two shapes.

pub(crate) mod core;
mod epa;
pub(crate) mod gjk;

use crate::Shape;
use jounce_math::{Pose, Quat, Vec3};

/// Closest points of two shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Gap, metres; 0 when they overlap.
    pub distance: f32,
    /// Closest point on A, in A's frame.
    pub point_a: Vec3,
    /// Closest point on B, in A's frame.
    pub point_b: Vec3,
    /// Unit direction from A to B (undefined, but unit, when they overlap), in A's frame.
    pub normal: Vec3,
    /// Triangle or child of A, or [`crate::NO_SUB`].
    pub sub_a: u32,
    /// Triangle or child of B, or [`crate::NO_SUB`].
    pub sub_b: u32,
}

/// First contact of a moving shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CastHit {
    /// Fraction of the motion, 0…1.
    pub t: f32,
    /// Contact point in A's frame.
    pub point: Vec3,
    /// Unit normal from A to B, in A's frame.
    pub normal: Vec3,
    /// Triangle or child of A, or [`crate::NO_SUB`].
    pub sub_a: u32,
    /// Triangle or child of B, or [`crate::NO_SUB`].
    pub sub_b: u32,
}

/// Motion of B in A's frame over one interval: the centre of mass moves on a line, the rotation is
/// interpolated (nlerp).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Centre of mass in B's own frame.
    pub local_center: Vec3,
    /// Centre of mass in A's frame at the start and the end.
    pub center: [Vec3; 2],
    /// Rotation of B in A's frame at the start and the end.
    pub rotation: [Quat; 2],
}

impl Sweep {
    /// Pose of B in A's frame at `t`, 0…1.
    pub fn pose(&self, t: f32) -> Pose {
        let q = self.rotation[0].nlerp(self.rotation[1], t);
        let c = self.center[0].lerp(self.center[1], t);
        Pose::new(c - q.rotate(self.local_center), q)
    }
}

/// Result of [`time_of_impact`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeOfImpact {
    /// They never come closer than the target distance.
    Separated,
    /// They overlap at the start.
    Overlapped,
    /// They come to the target distance at this fraction, 0…1.
    Hit(f32),
    /// The iteration bound was reached; the fraction is safe (still separated there).
    Failed(f32),
}

/// Closest points of A and B, where `b_in_a` is the pose of B in A's frame. `max_distance` bounds the
/// search (`f32::MAX` for none): `None` when they are farther apart.
pub fn distance(a: &Shape, b: &Shape, b_in_a: &Pose, max_distance: f32) -> Option<Distance> {
    let _ = (a, b, b_in_a, max_distance);
    None
}

/// Do they overlap or touch?
pub fn overlap(a: &Shape, b: &Shape, b_in_a: &Pose) -> bool {
    distance(a, b, b_in_a, 0.0).is_some()
}

/// B moves from `b_in_a` by `motion` (A's frame, no rotation): the first contact. An overlap at the start hits at
/// t = 0.
pub fn cast_shape(a: &Shape, b: &Shape, b_in_a: &Pose, motion: Vec3) -> Option<CastHit> {
    let _ = (a, b, b_in_a, motion);
    None
}

/// Conservative advancement of convex B (or a compound) against A along a sweep, to the distance `target` ± `tolerance`.
pub fn time_of_impact(a: &Shape, b: &Shape, sweep: &Sweep, target: f32, tolerance: f32) -> TimeOfImpact {
    let _ = (a, b, sweep, target, tolerance);
    TimeOfImpact::Separated
}
