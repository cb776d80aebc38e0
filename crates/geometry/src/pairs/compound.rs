//! Compounds, child by child. The compound is A; B is any other shape, or a compound too.

use super::{MeshScratch, Scratch, append};
use crate::shapes::compound::Compound;
use crate::{Aabb, Manifold, PairCache, Shape};
use jounce_math::Pose;

/// Contacts of each child near B with B, in rising order of the children.
pub(crate) fn compound(
    a: &Compound,
    b: &Shape,
    pose: &Pose,
    bounds: &Aabb,
    margin: f32,
    (scratch, mesh): (&mut Scratch, &mut MeshScratch),
    out: &mut Vec<Manifold>,
) {
    let mut children = core::mem::take(&mut mesh.children);
    let first = children.len();
    a.tree.query(bounds, |i| {
        children.push(i);
        true
    });
    children[first..].sort_unstable();
    mesh.children = children;
    let last = mesh.children.len();
    for k in first..last {
        let index = mesh.children[k];
        let Some((frame, child)) = a.children().get(index as usize) else { continue };
        let start = out.len();
        let b_in_child = frame.relative(pose);
        let cache = (&mut PairCache::default(), None);
        append(child, b, &b_in_child, margin, cache, (&mut *scratch, &mut *mesh), out);
        for m in &mut out[start..] {
            m.normal = frame.q.rotate(m.normal);
            m.sub_a = index;
            for p in &mut m.points[..usize::from(m.count)] {
                p.point = frame.transform_point(p.point);
                p.feature ^= index.wrapping_mul(0x9E37_79B1);
            }
        }
    }
    mesh.children.truncate(first);
}
