//! Distances, overlaps and casts between two shapes.

mod cast;
pub(crate) mod core;
pub(crate) mod distance;
pub(crate) mod epa;
pub(crate) mod gjk;
mod impact;
mod over;
mod shallow;

pub use cast::cast_shape;
pub use distance::{distance, overlap};
pub use impact::time_of_impact;
use jounce_math::{Pose, Quat, Vec3};
pub use shallow::stays_shallow;

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
    /// They overlap, or are nearer than the target distance, at the start.
    Overlapped,
    /// They come to the target distance at this fraction, 0…1.
    Hit(f32),
    /// The iteration bound was reached; the fraction is safe (still separated there).
    Failed(f32),
}

impl Distance {
    /// The same seen from the other shape, where `b_in_a` is the pose of the second shape in the first one's frame.
    fn flipped(&self, b_in_a: &Pose) -> Self {
        Self {
            distance: self.distance,
            point_a: b_in_a.inverse_transform_point(self.point_b),
            point_b: b_in_a.inverse_transform_point(self.point_a),
            normal: -b_in_a.q.inverse_rotate(self.normal),
            sub_a: self.sub_b,
            sub_b: self.sub_a,
        }
    }
    /// The same with A in a frame of its own, `frame`.
    fn moved(&self, frame: &Pose) -> Self {
        Self {
            point_a: frame.transform_point(self.point_a),
            point_b: frame.transform_point(self.point_b),
            normal: frame.q.rotate(self.normal),
            ..*self
        }
    }
}
