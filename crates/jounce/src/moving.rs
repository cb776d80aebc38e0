//! The tree of moving bounds, which catches up when somebody asks it.
//!
//! Where most of a world moves, pairs are found by a flat tree of the step (`stage::flat`), and nobody may ask this one for many steps. What moved is
//! listed then, and given to the tree when the first question comes. What the tree looks like cannot be seen in any answer (`query`), so neither can
//! when that was.

use jounce_geometry::{Aabb, Bvh};
use std::sync::{Mutex, OnceLock, PoisonError};

#[derive(Debug, Default)]
pub(crate) struct MovingTree {
    /// Empty while it is late.
    tree: OnceLock<Bvh>,
    late: Mutex<Late>,
    /// Leaves.
    count: usize,
}

/// A tree and what has moved since.
#[derive(Debug, Default)]
struct Late {
    /// Empty while nothing is late.
    tree: Bvh,
    /// Leaves and their boxes; each leaf at most once.
    boxes: Vec<(u32, Aabb)>,
    /// By leaf: one more than its place among the boxes, or 0.
    places: Vec<u32>,
}

impl Late {
    fn list(&mut self, leaf: u32, aabb: Aabb) {
        let at = leaf as usize;
        if at >= self.places.len() {
            self.places.resize(at + 1, 0);
        }
        if let Some(k) = self.places[at].checked_sub(1) {
            self.boxes[k as usize].1 = aabb;
        } else {
            self.boxes.push((leaf, aabb));
            self.places[at] = self.boxes.len() as u32;
        }
    }

    fn forget(&mut self, leaf: u32) {
        let place = self.places.get_mut(leaf as usize).map_or(0, core::mem::take);
        let Some(k) = place.checked_sub(1) else { return };
        self.boxes.swap_remove(k as usize);
        if let Some(&(moved, _)) = self.boxes.get(k as usize) {
            self.places[moved as usize] = place;
        }
    }

    fn catch_up(&mut self) -> Bvh {
        let Self { tree, boxes, places } = self;
        tree.enlarge_all(boxes.len(), |enlarge| boxes.iter().for_each(|&(leaf, b)| enlarge(leaf, b)));
        boxes.drain(..).for_each(|(leaf, _)| places[leaf as usize] = 0);
        core::mem::take(tree)
    }
}

impl MovingTree {
    /// The tree as of now.
    pub fn get(&self) -> &Bvh {
        self.tree.get_or_init(|| self.late.lock().unwrap_or_else(PoisonError::into_inner).catch_up())
    }

    fn late(&mut self) -> &mut Late {
        self.late.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    /// The tree to change, late or not.
    fn tree(&mut self) -> &mut Bvh {
        match self.tree.get_mut() {
            Some(tree) => tree,
            None => &mut self.late.get_mut().unwrap_or_else(PoisonError::into_inner).tree,
        }
    }

    /// Leaves.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Gives leaves new boxes, of which the tree hears when it is asked. `leaves` is called once, with what takes a leaf and its box.
    pub fn put_off(&mut self, leaves: impl FnOnce(&mut dyn FnMut(u32, Aabb))) {
        if let Some(tree) = self.tree.take() {
            self.late().tree = tree;
        }
        let late = self.late();
        leaves(&mut |leaf, aabb| late.list(leaf, aabb));
    }

    pub fn insert(&mut self, aabb: Aabb, data: u32) -> u32 {
        let leaf = self.tree().insert(aabb, data);
        self.count = self.tree().len();
        leaf
    }

    pub fn remove(&mut self, leaf: u32) {
        self.late().forget(leaf);
        self.tree().remove(leaf);
        self.count = self.tree().len();
    }

    pub fn update(&mut self, leaf: u32, aabb: Aabb) {
        self.late().forget(leaf);
        self.tree().update(leaf, aabb);
    }
}

impl Clone for MovingTree {
    fn clone(&self) -> Self {
        Self { tree: OnceLock::from(self.get().clone()), late: Mutex::default(), count: self.count }
    }
}

#[cfg(test)]
mod tests {
    use super::MovingTree;
    use jounce_geometry::Aabb;
    use jounce_math::Vec3;

    /// Boxes that move, come and go, with questions now and then: the answers are those of the boxes themselves, and a clone gives them too.
    #[test]
    fn answers_as_if_it_were_never_late() {
        let mut state = 1_u32;
        let mut random = move |n: u32| {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) % n
        };
        let mut tree = MovingTree::default();
        let mut there: Vec<Option<(u32, Aabb)>> = vec![None; 200];
        let mut late = 0;
        for round in 0..400 {
            let mut boxes = Vec::new();
            boxes.resize_with(200, || {
                let p = Vec3::new(random(100) as f32, random(100) as f32, random(100) as f32);
                Aabb::new(p, p + Vec3::splat(20.0))
            });
            for (i, slot) in there.iter_mut().enumerate() {
                match (random(8), *slot) {
                    (0, None) => *slot = Some((tree.insert(boxes[i], i as u32), boxes[i])),
                    (0, Some((leaf, _))) => {
                        tree.remove(leaf);
                        *slot = None;
                    }
                    (1, Some((leaf, _))) => {
                        tree.update(leaf, boxes[i]);
                        *slot = Some((leaf, boxes[i]));
                    }
                    _ => {}
                }
            }
            if random(4) > 0 {
                tree.put_off(|list| {
                    for (slot, b) in there.iter_mut().zip(&boxes).step_by(2) {
                        if let Some((leaf, old)) = slot {
                            *old = *b;
                            list(*leaf, *b);
                        }
                    }
                });
                late += 1;
            }
            assert_eq!(tree.len(), there.iter().flatten().count());
            if random(3) > 0 {
                continue;
            }
            let asked = boxes[0];
            let mut want: Vec<u32> =
                (0..200).filter(|&i| there[i as usize].is_some_and(|(_, b)| b.overlaps(&asked))).collect();
            want.sort_unstable();
            for tree in [&tree.clone(), &tree] {
                let mut got = Vec::new();
                tree.get().query(&asked, |i| {
                    got.push(i);
                    true
                });
                got.sort_unstable();
                assert_eq!(got, want, "round {round}");
            }
        }
        assert!(late > 200, "{late}");
    }
}
