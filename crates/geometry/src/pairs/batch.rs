//! Tests of many pairs: those of boxes, of balls and of capsules several at a time.

use super::box_axes::{self, BoxAxis};
use super::capsule::{self, Nearest};
use super::wide::PairRow;
use super::{box_box, capsules_of};
use crate::pairs::{Near, collide_again};
use crate::{ManifoldSet, PairCache, Shape};
use jounce_lanes::Width;
use jounce_math::Pose;

/// Pairs that are tested together. What is found of each is what [`collide_again`] finds, in every width.
///
/// ```
/// use jounce_geometry::{Batch, ManifoldSet, PairCache, Shape};
/// use jounce_lanes::Width;
/// use jounce_math::{Pose, Quat, Vec3};
///
/// let ball = Shape::Sphere { radius: 0.5 };
/// let pose = Pose::new(Vec3::new(0.0, 0.99, 0.0), Quat::IDENTITY);
/// let (mut cache, mut near, mut set) = (PairCache::default(), None, ManifoldSet::new());
/// let mut batch = Batch::default();
/// let k = batch.push(&ball, &ball, &pose, 0.02, &cache);
/// batch.run(Width::detect());
/// batch.collide(k, &ball, &ball, &mut cache, &mut near, &mut set);
/// assert_eq!(set.manifolds[0].count, 1);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Batch {
    pairs: Vec<(Pose, f32, Kind)>,
    boxes: Vec<PairRow>,
    axes: Vec<BoxAxis>,
    capsules: Vec<PairRow>,
    nearest: Vec<Nearest>,
}

/// Where a pair is.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Boxes(usize),
    Capsules(usize),
    Others,
}

impl Batch {
    /// Forgets the pairs, keeps the memory.
    pub fn clear(&mut self) {
        self.pairs.clear();
        self.boxes.clear();
        self.axes.clear();
        self.capsules.clear();
        self.nearest.clear();
    }

    /// Adds a pair of shapes: pose of B in A's frame, margin in metres. Gives its number.
    pub fn push(&mut self, a: &Shape, b: &Shape, b_in_a: &Pose, margin: f32, cache: &PairCache) -> usize {
        let kind = match (a, b) {
            _ if !b_in_a.is_finite() => Kind::Others,
            (Shape::Box { half: ha }, Shape::Box { half: hb }) => {
                self.boxes.push(box_box::row(*ha, *hb, b_in_a, margin, cache));
                Kind::Boxes(self.boxes.len() - 1)
            }
            _ => match capsules_of(a, b) {
                Some(both) => {
                    self.capsules.push(capsule::row(both, b_in_a, margin));
                    Kind::Capsules(self.capsules.len() - 1)
                }
                None => Kind::Others,
            },
        };
        self.pairs.push((*b_in_a, margin, kind));
        self.pairs.len() - 1
    }

    /// Tests what is tested several at a time, in lanes of `width`.
    pub fn run(&mut self, width: Width) {
        self.axes.resize(self.boxes.len(), BoxAxis::default());
        box_axes::find(width, &self.boxes, &mut self.axes);
        self.nearest.resize(self.capsules.len(), Nearest::default());
        capsule::find(width, &self.capsules, &mut self.nearest);
    }

    /// The manifolds of pair `k`, of those that were pushed before [`run`](Self::run), written to `out.manifolds` (cleared first). The shapes are those it
    /// was pushed with, and so is what is known of it.
    ///
    /// # Panics
    /// If there is no such pair, or it was pushed after the last [`run`](Self::run) and is one of those that are tested together.
    pub fn collide(
        &self,
        k: usize,
        a: &Shape,
        b: &Shape,
        cache: &mut PairCache,
        near: &mut Option<Box<Near>>,
        out: &mut ManifoldSet,
    ) {
        let (pose, margin, kind) = &self.pairs[k];
        let found = match *kind {
            Kind::Boxes(i) => {
                cache.gap = 0.0;
                box_box::at_axis(&self.boxes[i], &self.axes[i], cache)
            }
            Kind::Capsules(i) => {
                cache.gap = 0.0;
                capsule::at_points(&self.capsules[i], &self.nearest[i], cache)
            }
            Kind::Others => return collide_again(a, b, pose, *margin, cache, near, out),
        };
        out.clear();
        out.manifolds.extend(found);
    }
}
