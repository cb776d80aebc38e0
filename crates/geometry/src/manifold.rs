//! What two touching shapes tell the solver.

use crate::pairs::{MeshScratch, Scratch};
use jounce_math::Vec3;

/// `sub_a`/`sub_b` of a shape that has no parts.
pub const NO_SUB: u32 = u32::MAX;
/// Bit of [`Manifold::faces`]: the normal is a face normal of A.
pub const FACE_A: u8 = 1;
/// Bit of [`Manifold::faces`]: the normal is (minus) a face normal of B.
pub const FACE_B: u8 = 2;

/// One contact point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ManifoldPoint {
    /// Midway between the two surfaces, in A's frame, metres.
    pub point: Vec3,
    /// Gap along the normal, metres; negative when the shapes overlap.
    pub separation: f32,
    /// Names the pair of features that made the point; equal from step to step while they do.
    pub feature: u32,
}

/// Up to four points that share one normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Manifold {
    /// Unit normal from A to B, in A's frame.
    pub normal: Vec3,
    /// The points; the first `count` are valid.
    pub points: [ManifoldPoint; 4],
    /// Number of valid points, 1…4.
    pub count: u8,
    /// [`FACE_A`] and/or [`FACE_B`] where the normal is a face normal; 0 for an edge or vertex contact.
    pub faces: u8,
    /// Triangle or child of A that was hit (of the deepest point, when several were merged), or [`NO_SUB`].
    pub sub_a: u32,
    /// Triangle or child of B, likewise.
    pub sub_b: u32,
}

impl Manifold {
    /// The valid points.
    pub fn points(&self) -> &[ManifoldPoint] {
        &self.points[..usize::from(self.count).min(4)]
    }

    /// The same contact seen from the other side: `b_in_a` is the pose of B in A's frame.
    pub fn flipped(&self, b_in_a: &jounce_math::Pose) -> Self {
        let mut m = *self;
        m.normal = -b_in_a.q.inverse_rotate(self.normal);
        for p in &mut m.points[..usize::from(self.count).min(4)] {
            p.point = b_in_a.inverse_transform_point(p.point);
        }
        m.faces = ((self.faces & FACE_A) << 1) | ((self.faces & FACE_B) >> 1);
        (m.sub_a, m.sub_b) = (self.sub_b, self.sub_a);
        m
    }
}

/// What a pair remembers from its last test to make the next one cheap (a separating axis, a best
/// feature). Never changes a result beyond the choice between equals; zero is "nothing known".
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairCache {
    /// Last separating or least-overlap axis, in A's frame.
    pub axis: Vec3,
    /// Which kind of axis and which features (private to the pair's test).
    pub features: [u32; 2],
    /// 0: empty.
    pub kind: u32,
    /// Of shapes that were farther apart than asked for: how far at least, m; 0 where that is not known, and where they met.
    pub gap: f32,
}

/// Manifolds of one pair, with scratch memory that is reused from pair to pair.
#[derive(Clone, Debug, Default)]
pub struct ManifoldSet {
    /// The result: no manifold when the shapes are farther apart than the margin.
    pub manifolds: Vec<Manifold>,
    pub(crate) scratch: Scratch,
    pub(crate) mesh: MeshScratch,
}

impl ManifoldSet {
    /// An empty set.
    pub fn new() -> Self {
        Self::default()
    }
    /// Forgets the manifolds, keeps the memory.
    pub fn clear(&mut self) {
        self.manifolds.clear();
    }
}
