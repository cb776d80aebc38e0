//! Walks through the tree.

use super::probe::Probe;
use super::stack::Stack;
use super::{Bvh, LEAF, NONE};
use crate::Aabb;
use jounce_math::Vec3;

impl Bvh {
    /// Calls `f(data)` for every leaf whose box overlaps; stops when `f` returns false.
    #[inline]
    pub fn query(&self, aabb: &Aabb, mut f: impl FnMut(u32) -> bool) {
        self.query_leaves(aabb, |_, data| f(data));
    }

    /// Calls `f(leaf, data)` for every leaf whose box overlaps; stops when `f` returns false.
    #[inline]
    pub fn query_leaves(&self, aabb: &Aabb, mut f: impl FnMut(u32, u32) -> bool) {
        self.overlapping(aabb, |leaf, _| f(leaf, self.leaves[leaf as usize].data));
    }

    /// Calls `f(data, box)` for every leaf whose box overlaps; stops when `f` returns false.
    #[inline]
    pub fn query_boxes(&self, aabb: &Aabb, mut f: impl FnMut(u32, &Aabb) -> bool) {
        self.overlapping(aabb, |leaf, b| f(self.leaves[leaf as usize].data, b));
    }

    #[inline(always)]
    fn overlapping(&self, aabb: &Aabb, mut f: impl FnMut(u32, &Aabb) -> bool) {
        let mut stack = Stack::new(NONE);
        let mut current = self.root;
        let probe = Probe::new(aabb);
        loop {
            let Some(node) = self.nodes.get(current as usize) else { return };
            let meets = [probe.meets(&node.boxes[0]), probe.meets(&node.boxes[1])];
            let mut next = NONE;
            for k in [0, 1] {
                let child = node.children[k];
                if child == NONE || !meets[k] {
                    continue;
                }
                if child & LEAF != 0 {
                    if !f(child & !LEAF, &node.boxes[k]) {
                        return;
                    }
                } else if next == NONE {
                    next = child;
                } else {
                    stack.push(child);
                }
            }
            current = if next != NONE {
                next
            } else if let Some(n) = stack.pop() {
                n
            } else {
                return;
            };
        }
    }

    /// Walks leaves hit by the ray origin + t·dir, t ≤ `max_t`, near boxes first. `f(data, max_t)` returns the
    /// new `max_t` (smaller after a hit, the same otherwise, negative to stop). `half` grows every box (for
    /// casts of a shape whose bounds are ±half around the origin; zero for a ray).
    #[inline]
    pub fn ray(&self, origin: Vec3, dir: Vec3, half: Vec3, max_t: f32, mut f: impl FnMut(u32, f32) -> f32) {
        let inv = Vec3::new(1.0 / dir.x, 1.0 / dir.y, 1.0 / dir.z);
        self.walk(
            max_t,
            |b, max_t| Aabb::new(b.min - half, b.max + half).ray_entry(origin, inv, max_t),
            |data, max_t| {
                let t = f(data, max_t);
                (t >= 0.0).then_some(t)
            },
        );
    }

    /// Walks leaves near a point, nearest boxes first. `f(data, max_distance_squared)` returns the new bound.
    #[inline]
    pub fn nearest(&self, point: Vec3, max_d2: f32, mut f: impl FnMut(u32, f32) -> f32) {
        self.walk(
            max_d2,
            |b, max_d2| {
                let d2 = (point.clamp(b.min, b.max) - point).length_squared();
                (d2 <= max_d2).then_some(d2)
            },
            |data, max_d2| Some(f(data, max_d2)),
        );
    }

    /// Nearest boxes first, in the measure of `entry(box, bound)`, which gives `None` beyond the bound.
    /// `visit` returns the new bound, or `None` to stop.
    #[inline]
    fn walk(
        &self,
        mut bound: f32,
        entry: impl Fn(&Aabb, f32) -> Option<f32>,
        mut visit: impl FnMut(u32, f32) -> Option<f32>,
    ) {
        let mut stack = Stack::new((NONE, 0.0f32));
        let mut current = self.root;
        if current == NONE {
            return;
        }
        loop {
            if current & LEAF != 0 {
                match visit(self.leaves[(current & !LEAF) as usize].data, bound) {
                    Some(b) => bound = b,
                    None => return,
                }
            } else {
                let node = &self.nodes[current as usize];
                let e = [0, 1]
                    .map(|k| if node.children[k] == NONE { None } else { entry(&node.boxes[k], bound) });
                match e {
                    [Some(a), Some(b)] => {
                        let near = usize::from(b < a);
                        stack.push((node.children[1 - near], if near == 0 { b } else { a }));
                        current = node.children[near];
                        continue;
                    }
                    [Some(_), None] => {
                        current = node.children[0];
                        continue;
                    }
                    [None, Some(_)] => {
                        current = node.children[1];
                        continue;
                    }
                    [None, None] => {}
                }
            }
            // What was pushed under a wider bound may lie beyond it by now.
            current = loop {
                match stack.pop() {
                    Some((n, e)) if e <= bound => break n,
                    Some(_) => {}
                    None => return,
                }
            };
        }
    }
}
