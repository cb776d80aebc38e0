//! Contact manifolds, one file per pair of shapes.

use crate::{ManifoldSet, PairCache, Shape};
use jounce_math::Pose;

/// Manifolds of A and B (pose of B in A's frame) for all points closer than `margin` metres, written to
/// `out.manifolds` (cleared first).
/// At least one of the shapes must be solid; other pairs give nothing.
pub fn collide(
    a: &Shape,
    b: &Shape,
    b_in_a: &Pose,
    margin: f32,
    cache: &mut PairCache,
    out: &mut ManifoldSet,
) {
    let _ = (a, b, b_in_a, margin, cache);
    out.clear();
}
