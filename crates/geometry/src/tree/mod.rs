//! Bounding volume trees.
//!
//! A node holds the boxes of its two children in one cache line, so a visit decides about both without
//! touching them. Leaves have no node: a child with the bit [`LEAF`] names a leaf id, and a table by leaf id holds the
//! data and the way back up.
//!
//! * Building: binned surface-area heuristic (`build.rs`).
//! * Moving: leaves get their boxes in place, and the part of the tree that grew is fitted to them, which keeps its form; once its nodes have
//!   become large for that, it is built anew over what did not grow (Catto, Box2D v3, "dynamic tree rebuild"; Kopta et al. 2012).
//! * Insertion: descends to the sibling that adds least area, then rotates subtrees on the way up where that
//!   saves area (Kopta et al. 2012, "Fast, Effective BVH Updates for Animated Scenes"; Catto 2019, "Dynamic BVH").

mod build;
mod probe;
mod query;
mod stack;
#[cfg(test)]
mod tests;

use crate::Aabb;

/// Grown nodes per enlarged leaf from which tidying is worth it.
const TIDY_PART: u32 = 2;
/// Leaves per moved leaf up to which all that moved are put into the tree together.
const CROWD: usize = 32;
/// Area of the grown nodes, in what it was as they were built, from which they are built anew.
const WORN: f64 = 1.25;
/// No node, no leaf.
const NONE: u32 = u32::MAX;
/// Set in a child that is a leaf. [`NONE`] has it too and is asked about first.
const LEAF: u32 = 1 << 31;

/// Two children. Only the root of a tree with a single leaf has an empty slot (the second).
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Node {
    boxes: [Aabb; 2],
    children: [u32; 2],
    /// For a free node: the next free one.
    parent: u32,
    /// A leaf below was enlarged since the last [`Bvh::tidy`]; then so says its parent.
    grown: bool,
}

impl Node {
    fn new(parent: u32) -> Self {
        Self { boxes: [Aabb::EMPTY; 2], children: [NONE; 2], parent, grown: false }
    }
    #[inline(always)]
    fn bounds(&self) -> Aabb {
        self.boxes[0].union(&self.boxes[1])
    }
}

#[derive(Clone, Copy, Debug)]
struct Leaf {
    data: u32,
    /// Node that holds the box; [`NONE`] for a free id.
    node: u32,
}

/// A bounding volume hierarchy of axis-aligned boxes with `u32` user data on the leaves. Build, insert,
/// remove, move, refit, query. Traversal order is fixed by the tree; callers that need an order of their own sort.
/// At most 2³¹ − 1 leaves; boxes must not be NaN.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    /// By node: area of its bounds as it was built; 0 where that is not known.
    built: Vec<f32>,
    leaves: Vec<Leaf>,
    root: u32,
    free_node: u32,
    free_leaves: Vec<u32>,
    /// Grown nodes, and leaves enlarged, since the last tidying.
    grown: u32,
    enlarged: u32,
    work: build::Work,
}

impl Default for Bvh {
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            built: Vec::new(),
            leaves: Vec::new(),
            root: NONE,
            free_node: NONE,
            free_leaves: Vec::new(),
            grown: 0,
            enlarged: 0,
            work: build::Work::default(),
        }
    }
}

impl Bvh {
    /// An empty tree.
    pub fn new() -> Self {
        Self::default()
    }
    /// Builds a balanced tree (binned surface-area heuristic); leaf ids are positions in `items`.
    pub fn build(items: &[(Aabb, u32)]) -> Self {
        let leaves = items.iter().map(|&(_, data)| Leaf { data, node: NONE }).collect();
        let mut tree = Self { leaves, ..Self::default() };
        tree.build_inner(items.iter().zip(0u32..).map(|(&(b, _), leaf)| (b, leaf)).collect());
        tree
    }
    /// Adds a leaf and gives its id (stable until removed; the ids of removed leaves are used again).
    pub fn insert(&mut self, aabb: Aabb, data: u32) -> u32 {
        let leaf = self.free_leaves.pop().unwrap_or_else(|| {
            self.leaves.push(Leaf { data, node: NONE });
            self.leaves.len() as u32 - 1
        });
        self.leaves[leaf as usize].data = data;
        self.attach(leaf, aabb);
        leaf
    }
    /// Removes a leaf; an unknown id is ignored.
    pub fn remove(&mut self, leaf: u32) {
        if self.is_leaf(leaf) {
            self.detach(leaf);
            self.leaves[leaf as usize].node = NONE;
            self.free_leaves.push(leaf);
        }
    }
    /// Moves a leaf to a new box by re-insertion.
    pub fn update(&mut self, leaf: u32, aabb: Aabb) {
        if self.is_leaf(leaf) {
            self.detach(leaf);
            self.attach(leaf, aabb);
        }
    }
    /// Gives a leaf a new box in place and grows its ancestors where they do not hold it: cheap, but ancestors never shrink.
    /// [`Bvh::tidy`] mends that.
    pub fn enlarge(&mut self, leaf: u32, aabb: Aabb) {
        if !self.is_leaf(leaf) {
            return;
        }
        let mut n = self.leaves[leaf as usize].node;
        let mut slot = self.slot_of(n, LEAF | leaf);
        self.nodes[n as usize].boxes[slot] = aabb;
        self.enlarged += 1;
        loop {
            let known = core::mem::replace(&mut self.nodes[n as usize].grown, true);
            self.grown += u32::from(!known);
            let parent = self.nodes[n as usize].parent;
            if parent == NONE {
                return;
            }
            slot = self.slot_of(parent, n);
            let b = &mut self.nodes[parent as usize].boxes[slot];
            if !b.contains(&aabb) {
                *b = b.union(&aabb);
            } else if known {
                return;
            }
            n = parent;
        }
    }
    /// Fits the part of the tree that [`Bvh::enlarge`] has grown, or builds it anew where that has made its nodes large, once that was asked
    /// often enough to be worth it: as often as half that part has nodes. Subtrees in which nothing was enlarged stay.
    pub fn tidy(&mut self) {
        if self.enlarged == 0 || self.enlarged < self.grown / TIDY_PART {
            return;
        }
        let (now, built) = self.fit_grown();
        if now > WORN * built {
            self.build_grown();
        } else {
            self.accept_grown();
        }
    }
    /// Like [`Bvh::enlarge`] for `count` leaves and their boxes, then [`Bvh::tidy`]. Of many leaves, each only marks what is above it, and
    /// one pass over the marked nodes fits them.
    /// `leaves` is called once, with what takes a leaf and its box.
    pub fn enlarge_all(&mut self, count: usize, leaves: impl FnOnce(&mut dyn FnMut(u32, Aabb))) {
        if count * CROWD < self.len() {
            leaves(&mut |leaf, aabb| {
                self.enlarge(leaf, aabb);
            });
            self.tidy();
            return;
        }
        leaves(&mut |leaf, aabb| self.mark(leaf, aabb));
        if self.enlarged == 0 {
            return;
        }
        let (now, built) = self.fit_grown();
        if self.enlarged < self.grown / TIDY_PART {
            self.work.forget();
        } else if now > WORN * built {
            self.build_grown();
        } else {
            self.accept_grown();
        }
    }
    /// Gives a leaf a new box; the nodes above it are marked, and do not hold it yet.
    fn mark(&mut self, leaf: u32, aabb: Aabb) {
        if !self.is_leaf(leaf) {
            return;
        }
        let mut n = self.leaves[leaf as usize].node;
        let slot = self.slot_of(n, LEAF | leaf);
        self.nodes[n as usize].boxes[slot] = aabb;
        self.enlarged += 1;
        while let Some(node) = self.nodes.get_mut(n as usize)
            && !node.grown
        {
            node.grown = true;
            n = node.parent;
            self.grown += 1;
        }
    }
    /// Gives leaves new boxes and recomputes every ancestor exactly: `f(data, box)` returns the new box of a leaf.
    /// The tree's form stays.
    pub fn refit(&mut self, mut f: impl FnMut(u32, Aabb) -> Aabb) {
        let mut order = Vec::with_capacity(self.nodes.len());
        if self.root != NONE {
            order.push(self.root);
        }
        let mut k = 0;
        while let Some(&n) = order.get(k) {
            k += 1;
            for slot in [0, 1] {
                let child = self.nodes[n as usize].children[slot];
                if child == NONE {
                    continue;
                }
                if child & LEAF == 0 {
                    order.push(child);
                } else {
                    let b = self.nodes[n as usize].boxes[slot];
                    self.nodes[n as usize].boxes[slot] = f(self.leaves[(child & !LEAF) as usize].data, b);
                }
            }
        }
        for &n in order.iter().skip(1).rev() {
            let (b, p) = (self.nodes[n as usize].bounds(), self.nodes[n as usize].parent);
            let slot = self.slot_of(p, n);
            self.nodes[p as usize].boxes[slot] = b;
        }
    }
    /// Box of a leaf; empty for an unknown id.
    pub fn aabb(&self, leaf: u32) -> Aabb {
        if !self.is_leaf(leaf) {
            return Aabb::EMPTY;
        }
        let n = self.leaves[leaf as usize].node;
        self.nodes[n as usize].boxes[self.slot_of(n, LEAF | leaf)]
    }
    /// Data of a leaf; `None` for an unknown id.
    pub fn data(&self, leaf: u32) -> Option<u32> {
        self.leaves.get(leaf as usize).filter(|l| l.node != NONE).map(|l| l.data)
    }
    /// Box around all leaves; empty for an empty tree.
    pub fn bounds(&self) -> Aabb {
        self.nodes.get(self.root as usize).map_or(Aabb::EMPTY, Node::bounds)
    }
    /// Number of leaves.
    pub fn len(&self) -> usize {
        self.leaves.len() - self.free_leaves.len()
    }
    /// No leaves?
    pub fn is_empty(&self) -> bool {
        self.root == NONE
    }
    /// Rebuilds the inner nodes over the present leaves; ids stay.
    pub fn rebuild(&mut self) {
        let ids = 0..self.leaves.len() as u32;
        let boxes = ids.filter(|&l| self.is_leaf(l)).map(|l| (self.aabb(l), l)).collect();
        self.build_inner(boxes);
    }
    /// Sum of the inner nodes' areas relative to the root's: what a query visits on average; lower is better.
    pub fn cost(&self) -> f32 {
        let mut sum = 0.0f64;
        let mut todo = vec![self.root];
        while let Some(n) = todo.pop() {
            if let Some(node) = self.nodes.get(n as usize) {
                sum += f64::from(node.bounds().area());
                todo.extend(node.children.into_iter().filter(|&c| c & LEAF == 0));
            }
        }
        let root = f64::from(self.bounds().area());
        if root > 0.0 { (sum / root) as f32 } else { 0.0 }
    }

    /// Gives leaves new ids and data 0, 1, 2, … in the order of a depth-first walk; says which data each had.
    pub(crate) fn renumber(&mut self) -> Vec<u32> {
        let mut old = Vec::with_capacity(self.len());
        let mut leaves = Vec::with_capacity(self.len());
        let mut todo: Vec<u32> = if self.root == NONE { Vec::new() } else { vec![self.root] };
        while let Some(n) = todo.pop() {
            for slot in [0, 1] {
                let child = self.nodes[n as usize].children[slot];
                if child != NONE && child & LEAF != 0 {
                    let id = leaves.len() as u32;
                    old.push(self.leaves[(child & !LEAF) as usize].data);
                    leaves.push(Leaf { data: id, node: n });
                    self.nodes[n as usize].children[slot] = LEAF | id;
                }
            }
            todo.extend(self.nodes[n as usize].children.into_iter().rev().filter(|&c| c & LEAF == 0));
        }
        self.leaves = leaves;
        self.free_leaves.clear();
        old
    }

    fn is_leaf(&self, leaf: u32) -> bool {
        self.leaves.get(leaf as usize).is_some_and(|l| l.node != NONE)
    }
    #[inline(always)]
    fn slot_of(&self, n: u32, child: u32) -> usize {
        debug_assert!(self.nodes[n as usize].children.contains(&child));
        usize::from(self.nodes[n as usize].children[0] != child)
    }
    /// Puts a child into a slot and tells it where it is.
    #[inline]
    fn set(&mut self, n: u32, slot: usize, aabb: Aabb, child: u32) {
        let node = &mut self.nodes[n as usize];
        node.boxes[slot] = aabb;
        node.children[slot] = child;
        if child == NONE {
        } else if child & LEAF != 0 {
            self.leaves[(child & !LEAF) as usize].node = n;
        } else {
            self.nodes[child as usize].parent = n;
        }
    }
    fn new_node(&mut self, parent: u32) -> u32 {
        if self.free_node == NONE {
            self.nodes.push(Node::new(parent));
            self.built.push(0.0);
            return self.nodes.len() as u32 - 1;
        }
        let n = self.free_node;
        self.free_node = self.nodes[n as usize].parent;
        self.nodes[n as usize] = Node::new(parent);
        self.built[n as usize] = 0.0;
        n
    }
    fn free(&mut self, n: u32) {
        self.grown -= u32::from(self.nodes[n as usize].grown);
        self.nodes[n as usize] = Node::new(self.free_node);
        self.free_node = n;
    }

    /// Marks a node as grown where the other is.
    fn mark_like(&mut self, n: u32, other: u32) {
        let grown = self.nodes[other as usize].grown;
        let known = core::mem::replace(&mut self.nodes[n as usize].grown, grown);
        self.grown = self.grown + u32::from(grown) - u32::from(known);
    }

    fn attach(&mut self, leaf: u32, aabb: Aabb) {
        if self.root == NONE {
            self.root = self.new_node(NONE);
            self.set(self.root, 0, aabb, LEAF | leaf);
            return;
        }
        if self.nodes[self.root as usize].children[1] == NONE {
            self.set(self.root, 1, aabb, LEAF | leaf);
            return;
        }
        match self.best_sibling(&aabb) {
            None => {
                let (old, b) = (self.root, self.bounds());
                self.root = self.new_node(NONE);
                self.mark_like(self.root, old);
                self.set(self.root, 0, b, old);
                self.set(self.root, 1, aabb, LEAF | leaf);
            }
            Some((n, slot)) => {
                let (b, child) = (self.nodes[n as usize].boxes[slot], self.nodes[n as usize].children[slot]);
                let m = self.new_node(n);
                self.mark_like(m, n);
                self.set(m, 0, b, child);
                self.set(m, 1, aabb, LEAF | leaf);
                self.set(n, slot, b.union(&aabb), m);
                self.refit_up(n);
            }
        }
    }

    /// The slot beside which a new box adds least area, the growth of its ancestors included; `None` for the
    /// whole tree. Descends where the lower bound of the cost is smallest, and stops when that is no
    /// better than the best slot so far: one path, almost always the one an exhaustive search would find.
    fn best_sibling(&self, aabb: &Aabb) -> Option<(u32, usize)> {
        let area = aabb.area();
        let root = self.bounds();
        let mut best = None;
        let mut best_cost = root.union(aabb).area();
        let mut inherited = best_cost - root.area();
        let mut n = self.root;
        loop {
            let node = &self.nodes[n as usize];
            let mut lowest = f32::INFINITY;
            let mut next = None;
            for slot in [0, 1] {
                let b = &node.boxes[slot];
                let direct = b.union(aabb).area();
                let cost = direct + inherited;
                if cost < best_cost {
                    (best_cost, best) = (cost, Some((n, slot)));
                }
                if node.children[slot] & LEAF == 0 {
                    // Everything below grows this child to `direct` and costs at least the new box itself.
                    let grown = inherited + direct - b.area();
                    // Equal bounds (say, the box lies in both) are settled by the nearer centre.
                    let bound = grown + area;
                    if bound < lowest || (bound == lowest && self.is_nearer(n, slot, aabb)) {
                        (lowest, next) = (bound, Some((node.children[slot], grown)));
                    }
                }
            }
            match next {
                Some((child, grown)) if lowest < best_cost => (n, inherited) = (child, grown),
                _ => return best,
            }
        }
    }
    fn is_nearer(&self, n: u32, slot: usize, aabb: &Aabb) -> bool {
        let node = &self.nodes[n as usize];
        let d2 = |k: usize| (node.boxes[k].center() - aabb.center()).length_squared();
        d2(slot) < d2(1 - slot)
    }

    fn detach(&mut self, leaf: u32) {
        let n = self.leaves[leaf as usize].node;
        let other = 1 - self.slot_of(n, LEAF | leaf);
        let (b, sibling) = (self.nodes[n as usize].boxes[other], self.nodes[n as usize].children[other]);
        let parent = self.nodes[n as usize].parent;
        if parent != NONE {
            let slot = self.slot_of(parent, n);
            let before = self.nodes[parent as usize].boxes[slot];
            self.set(parent, slot, b, sibling);
            self.free(n);
            // Boxes that all coincide make a list of the tree: nothing above changes, so it is not walked.
            if b != before {
                self.refit_up(parent);
            }
        } else if sibling == NONE {
            self.free(n);
            self.root = NONE;
        } else if sibling & LEAF != 0 {
            self.set(n, 0, b, sibling);
            self.set(n, 1, Aabb::EMPTY, NONE);
        } else {
            self.root = sibling;
            self.nodes[sibling as usize].parent = NONE;
            self.free(n);
        }
    }

    /// Recomputes boxes from `n` to the root, rotating where it pays.
    fn refit_up(&mut self, mut n: u32) {
        loop {
            self.rotate(n);
            let (b, parent) = (self.nodes[n as usize].bounds(), self.nodes[n as usize].parent);
            if parent == NONE {
                return;
            }
            let slot = self.slot_of(parent, n);
            self.nodes[parent as usize].boxes[slot] = b;
            n = parent;
        }
    }

    /// Exchanges a child of `n` with a child of its other child where that shrinks the latter most.
    fn rotate(&mut self, n: u32) {
        let node = self.nodes[n as usize];
        let mut best_gain = 0.0;
        let mut best = None;
        for slot in [0, 1] {
            let inner = node.children[slot];
            if inner & LEAF != 0 {
                continue;
            }
            let area = node.boxes[slot].area();
            for k in [0, 1] {
                // Child k of `inner` goes up; the other child of `n` comes down beside 1 − k.
                let b = self.nodes[inner as usize].boxes[1 - k].union(&node.boxes[1 - slot]);
                let gain = area - b.area();
                if gain > best_gain {
                    (best_gain, best) = (gain, Some((slot, inner, k, b)));
                }
            }
        }
        let Some((slot, inner, k, b)) = best else { return };
        let (up_box, up) = (self.nodes[inner as usize].boxes[k], self.nodes[inner as usize].children[k]);
        // What comes down may have grown.
        self.mark_like(inner, n);
        self.set(inner, k, node.boxes[1 - slot], node.children[1 - slot]);
        self.set(n, 1 - slot, up_box, up);
        self.nodes[n as usize].boxes[slot] = b;
    }

    /// Checks every link and box; says what is wrong. For tests and debug builds.
    ///
    /// # Errors
    /// The first broken invariant, in words.
    pub fn validate(&self) -> Result<(), String> {
        let mut todo: Vec<u32> = if self.root == NONE { Vec::new() } else { vec![self.root] };
        let (mut nodes, mut leaves) = (0, 0);
        while let Some(n) = todo.pop() {
            nodes += 1;
            let node = self.nodes.get(n as usize).ok_or(format!("node {n} does not exist"))?;
            if n == self.root && node.parent != NONE {
                return Err("the root has a parent".into());
            }
            for slot in [0, 1] {
                let child = node.children[slot];
                if child == NONE {
                    if n != self.root || slot == 0 {
                        return Err(format!("node {n}: slot {slot} is empty"));
                    }
                } else if child & LEAF != 0 {
                    leaves += 1;
                    if self.leaves.get((child & !LEAF) as usize).is_none_or(|l| l.node != n) {
                        return Err(format!("leaf {} does not know its node {n}", child & !LEAF));
                    }
                } else {
                    let c = self.nodes.get(child as usize).ok_or(format!("node {child} does not exist"))?;
                    if c.grown && !node.grown {
                        return Err(format!("node {child} has grown, and its parent {n} does not say so"));
                    }
                    if c.parent != n {
                        return Err(format!("node {child} does not know its parent {n}"));
                    }
                    if !node.boxes[slot].contains(&c.bounds()) {
                        return Err(format!("node {child} sticks out of its parent's box"));
                    }
                    todo.push(child);
                }
            }
            if nodes > self.nodes.len() {
                return Err("the nodes make a loop".into());
            }
        }
        let grown = self.nodes.iter().filter(|n| n.grown).count();
        if grown != self.grown as usize {
            return Err(format!("{grown} nodes have grown, {} are counted", self.grown));
        }
        if leaves != self.len() {
            return Err(format!("{leaves} leaves are linked, {} exist", self.len()));
        }
        Ok(())
    }
}
