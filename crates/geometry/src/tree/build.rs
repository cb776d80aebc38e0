//! Top-down building by the binned surface-area heuristic.
//!
//! A split of n leaves with bounds area A costs A_left n_left + A_right n_right. The leaves' centres are sorted into
//! [`BINS`] bins along each axis and only the planes between bins are tried (Wald 2007, "On fast Construction of
//! SAH-based Bounding Volume Hierarchies").

use super::{Bvh, LEAF, NONE, Node};
use crate::Aabb;
use jounce_math::Vec3;

const BINS: usize = 16;
/// Below this depth leaves are halved by count, which bounds the depth by this + 32 whatever the input.
const SAH_DEPTH_MAX: u32 = 40;

/// A leaf (with [`LEAF`]) or a subtree.
#[derive(Clone, Copy, Debug)]
struct Item {
    aabb: Aabb,
    child: u32,
}

/// Memory of [`Bvh::build_grown`].
#[derive(Debug, Default)]
pub(super) struct Work {
    items: Vec<Item>,
    todo: Vec<u32>,
    jobs: Vec<Job>,
    made: Vec<u32>,
}

impl Clone for Work {
    /// Holds nothing between calls.
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Work {
    /// After [`Bvh::fit_grown`]: what grew stays marked.
    pub fn forget(&mut self) {
        self.made.clear();
    }
}

/// Items `first..end` go below slot `slot` of `parent`.
#[derive(Clone, Copy, Debug)]
struct Job {
    first: usize,
    end: usize,
    parent: u32,
    slot: usize,
    depth: u32,
}

impl Bvh {
    /// Makes the inner nodes over the present leaves anew; leaf ids stay.
    pub(super) fn build_inner(&mut self, mut boxes: Vec<(Aabb, u32)>) {
        self.nodes.clear();
        self.built.clear();
        self.free_node = NONE;
        self.root = NONE;
        (self.grown, self.enlarged) = (0, 0);
        let mut items: Vec<Item> =
            boxes.drain(..).map(|(aabb, leaf)| Item { aabb, child: LEAF | leaf }).collect();
        drop(boxes);
        if items.is_empty() {
            return;
        }
        self.root = 0;
        self.nodes.reserve(items.len());
        if let [only] = items[..] {
            self.nodes.push(Node::new(NONE));
            self.built.push(0.0);
            self.set(0, 0, only.aabb, only.child);
            return;
        }
        let mut jobs = vec![Job { first: 0, end: items.len(), parent: NONE, slot: 0, depth: 0 }];
        while let Some(job) = jobs.pop() {
            self.build_node(&mut items, &job, &mut jobs);
        }
        // Children stand behind their parents: one backward sweep gives every inner box.
        for n in (0..self.nodes.len()).rev() {
            let b = self.fit(n as u32);
            self.built.push(b.area());
        }
        self.built.reverse();
    }

    fn build_node(&mut self, items: &mut [Item], job: &Job, jobs: &mut Vec<Job>) {
        let range = &mut items[job.first..job.end];
        let n = self.nodes.len() as u32;
        self.nodes.push(Node::new(job.parent));
        if job.parent != NONE {
            self.nodes[job.parent as usize].children[job.slot] = n;
        }
        let middle = job.first + split(range, job.depth);
        for (slot, (first, end)) in [(0, (job.first, middle)), (1, (middle, job.end))].into_iter().rev() {
            if end - first == 1 {
                self.set(n, slot, items[first].aabb, items[first].child);
            } else {
                jobs.push(Job { first, end, parent: n, slot, depth: job.depth + 1 });
            }
        }
    }
}

impl Bvh {
    /// Builds the grown nodes anew, over the leaves and the other subtrees that hang on them.
    pub(super) fn build_grown(&mut self) {
        self.enlarged = 0;
        if self.root == NONE || self.nodes[self.root as usize].children[1] == NONE {
            // A single leaf has its box where it is.
            if let Some(root) = self.nodes.get_mut(self.root as usize) {
                self.grown -= u32::from(core::mem::take(&mut root.grown));
            }
            return;
        }
        let mut work = core::mem::take(&mut self.work);
        let Work { items, todo, jobs, made } = &mut work;
        made.clear();
        todo.push(self.root);
        while let Some(n) = todo.pop() {
            let node = self.nodes[n as usize];
            for (&child, &aabb) in node.children.iter().zip(&node.boxes) {
                if child & LEAF == 0 && self.nodes[child as usize].grown {
                    todo.push(child);
                } else {
                    items.push(Item { aabb, child });
                }
            }
            self.free(n);
        }
        jobs.push(Job { first: 0, end: items.len(), parent: NONE, slot: 0, depth: 0 });
        while let Some(job) = jobs.pop() {
            let n = self.new_node(job.parent);
            made.push(n);
            match self.nodes.get_mut(job.parent as usize) {
                Some(parent) => parent.children[job.slot] = n,
                None => self.root = n,
            }
            let middle = job.first + halve(&mut items[job.first..job.end], job.depth);
            for (slot, (first, end)) in [(0, (job.first, middle)), (1, (middle, job.end))] {
                if end - first == 1 {
                    self.set(n, slot, items[first].aabb, items[first].child);
                } else {
                    jobs.push(Job { first, end, parent: n, slot, depth: job.depth + 1 });
                }
            }
        }
        // Parents were made before their children.
        for &n in made.iter().rev() {
            self.built[n as usize] = self.fit(n).area();
        }
        items.clear();
        made.clear();
        self.work = work;
    }

    /// Fits the boxes of the grown nodes to what is in them. The sum of their areas, and what that was as they were built.
    pub(super) fn fit_grown(&mut self) -> (f64, f64) {
        let mut work = core::mem::take(&mut self.work);
        work.made.clear();
        if self.root != NONE {
            work.todo.push(self.root);
        }
        while let Some(n) = work.todo.pop() {
            work.made.push(n);
            let inner = self.nodes[n as usize].children.into_iter().filter(|c| c & LEAF == 0);
            work.todo.extend(inner.filter(|&c| self.nodes[c as usize].grown));
        }
        let (mut now, mut built) = (0.0, 0.0);
        for &n in work.made.iter().rev() {
            let area = self.fit(n).area();
            let was = &mut self.built[n as usize];
            if *was == 0.0 {
                *was = area;
            }
            now += f64::from(area);
            built += f64::from(*was);
        }
        self.work = work;
        (now, built)
    }

    /// After [`Bvh::fit_grown`]: nothing has grown.
    pub(super) fn accept_grown(&mut self) {
        for &n in &self.work.made {
            self.nodes[n as usize].grown = false;
        }
        self.work.made.clear();
        (self.grown, self.enlarged) = (0, 0);
    }

    /// Gives a node's bounds to its parent.
    fn fit(&mut self, n: u32) -> Aabb {
        let (b, parent) = (self.nodes[n as usize].bounds(), self.nodes[n as usize].parent);
        if parent != NONE {
            let slot = self.slot_of(parent, n);
            self.nodes[parent as usize].boxes[slot] = b;
        }
        b
    }
}

/// Like [`split`], and much faster: at the middle of the longest side of the centres.
fn halve(items: &mut [Item], depth: u32) -> usize {
    if items.len() == 2 {
        return 1;
    }
    let centers = Aabb::from_points(items.iter().map(|i| twice_center(&i.aabb)));
    let extent = centers.max - centers.min;
    if depth < SAH_DEPTH_MAX && extent.max_component() > 0.0 && extent.is_finite() {
        let axis = extent.max_axis();
        let middle = 0.5 * (centers.min[axis] + centers.max[axis]);
        let count = partition(items, |i| i.aabb.min[axis] + i.aabb.max[axis] < middle);
        if count > 0 && count < items.len() {
            return count;
        }
    }
    median(items, extent.max_axis())
}

/// Half the items, those with the lesser centres, to the front.
fn median(items: &mut [Item], axis: usize) -> usize {
    let half = items.len() / 2;
    let key = |i: &Item| twice_center(&i.aabb)[axis];
    items.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.child.cmp(&b.child)));
    half
}

#[derive(Clone, Copy)]
struct Bin {
    aabb: Aabb,
    count: usize,
}

/// Reorders two or more items and says how many go left: at least one, not all.
fn split(items: &mut [Item], depth: u32) -> usize {
    if items.len() == 2 {
        return 1;
    }
    let centers = Aabb::from_points(items.iter().map(|i| twice_center(&i.aabb)));
    let extent = centers.max - centers.min;
    // Not positive: all centres coincide. Not finite: nothing sensible can be measured.
    if depth < SAH_DEPTH_MAX
        && extent.max_component() > 0.0
        && extent.is_finite()
        && let Some((axis, bin)) = best_plane(items, &centers)
    {
        let count = partition(items, |i| bin_of(&i.aabb, &centers, axis) < bin);
        if count > 0 && count < items.len() {
            return count;
        }
    }
    median(items, extent.max_axis())
}

#[inline(always)]
fn twice_center(b: &Aabb) -> Vec3 {
    b.min + b.max
}

#[inline(always)]
fn bin_of(b: &Aabb, centers: &Aabb, axis: usize) -> usize {
    let (lo, hi) = (centers.min[axis], centers.max[axis]);
    let x = (b.min[axis] + b.max[axis] - lo) / (hi - lo);
    ((x * BINS as f32) as usize).min(BINS - 1)
}

/// Axis and first bin of the right side of the cheapest plane.
fn best_plane(items: &[Item], centers: &Aabb) -> Option<(usize, usize)> {
    let mut best = None;
    let mut best_cost = f32::INFINITY;
    for axis in 0..3 {
        if centers.max[axis] <= centers.min[axis] {
            continue;
        }
        let mut bins = [Bin { aabb: Aabb::EMPTY, count: 0 }; BINS];
        for i in items {
            let bin = &mut bins[bin_of(&i.aabb, centers, axis)];
            bin.aabb = bin.aabb.union(&i.aabb);
            bin.count += 1;
        }
        let mut right_cost = [0.0f32; BINS];
        let (mut b, mut n) = (Aabb::EMPTY, 0);
        for k in (1..BINS).rev() {
            b = b.union(&bins[k].aabb);
            n += bins[k].count;
            right_cost[k] = if n == 0 { f32::INFINITY } else { b.area() * n as f32 };
        }
        (b, n) = (Aabb::EMPTY, 0);
        for k in 1..BINS {
            b = b.union(&bins[k - 1].aabb);
            n += bins[k - 1].count;
            if n == 0 {
                continue;
            }
            let cost = b.area() * n as f32 + right_cost[k];
            if cost < best_cost {
                (best_cost, best) = (cost, Some((axis, k)));
            }
        }
    }
    best
}

/// Moves the items that satisfy `left` to the front; gives their number.
fn partition(items: &mut [Item], left: impl Fn(&Item) -> bool) -> usize {
    let (mut i, mut j) = (0, items.len());
    while i < j {
        if left(&items[i]) {
            i += 1;
        } else {
            j -= 1;
            items.swap(i, j);
        }
    }
    i
}
