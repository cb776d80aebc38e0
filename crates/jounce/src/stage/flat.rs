//! The moving bounds as a flat tree of sixteen branches, made anew in a step in which much moved, and joined with itself.
//!
//! Shapes lie in leaves in the order of a curve through space; a node holds the boxes of sixteen leaves or nodes by column, so that a few
//! wide comparisons decide about all. Each leaf is held against itself and against those behind it: every pair comes up once.

use super::broadphase::Curve;
use super::reach::{Sides, meets, put, sides};
use crate::world::World;
use jounce_geometry::Aabb;
use jounce_lanes::{LANES_MAX, Lanes, Mask};

/// Branches of a node, and boxes in a leaf.
const WIDE: usize = 16;
const _: () = assert!(WIDE.is_multiple_of(LANES_MAX), "a column is read in whole steps");
/// Levels of nodes: enough for 16⁷ leaves.
const LEVELS: usize = 7;
/// Fewer shapes than this are not worth it.
const LEAST: usize = 256;
/// Shapes per moved shape, and slots per shape, up to which it is.
const STILL: usize = 4;
const SPARSE: usize = 8;
/// Size of a shape, in the mean size, from which it is kept apart from the small ones.
const LARGE: f32 = 4.0;

/// Slots of shapes per unit.
const SLOTS: usize = 1024;
/// In place of a shape's: it is not in the tree.
const NOWHERE: u64 = u64::MAX;

type Part = (f32, f32, Aabb);

/// The six sides of sixteen boxes; empty boxes where there are fewer.
type Columns = Sides<WIDE>;

const NOTHING: Columns = {
    let (least, most) = ([f32::INFINITY; WIDE], [f32::NEG_INFINITY; WIDE]);
    [least, least, least, most, most, most]
};

/// Bit by box that meets another.
#[inline(always)]
fn hits<L: Lanes>(columns: &Columns, b: &[f32; 6]) -> u32 {
    let mut bits = 0;
    let mut at = 0;
    while at < WIDE {
        bits |= meets::<L, WIDE>(columns, at, b).bits() << at;
        at += L::WIDTH;
    }
    bits
}

#[inline(always)]
fn row(columns: &Columns, i: usize) -> [f32; 6] {
    jounce_lanes::six(
        #[inline(always)]
        |k| columns[k][i],
    )
}

/// Is a tree of the step made where so many shapes have moved?
pub(super) fn is_worth_it(world: &World, moved: usize) -> bool {
    let all = world.moving_tree.len();
    all >= LEAST && moved * STILL >= all && world.tags.len() <= all * SPARSE
}

/// Sixteen shapes: their bounds now, and as of the last pair search.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Leaf {
    now: Columns,
    before: Columns,
    slots: [u32; WIDE],
    len: usize,
    /// Some of them moved.
    moved: bool,
    bounds: Aabb,
}

impl Leaf {
    pub fn slots(&self) -> &[u32] {
        &self.slots[..self.len]
    }
    pub fn moved(&self) -> bool {
        self.moved
    }
    fn fill(world: &World, places: &[u64]) -> Self {
        let mut leaf = Self {
            now: NOTHING,
            before: NOTHING,
            slots: [0; WIDE],
            len: places.len().min(WIDE),
            moved: false,
            bounds: Aabb::EMPTY,
        };
        for (i, &place) in places.iter().take(WIDE).enumerate() {
            let s = place as u32;
            let fat = &world.fat[s as usize];
            put(&mut leaf.now, i, fat);
            put(&mut leaf.before, i, world.met_before(s));
            leaf.bounds = leaf.bounds.union(fat);
            leaf.slots[i] = s;
            leaf.moved |= world.tags[s as usize].moved();
        }
        leaf
    }
}

/// The tree.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flat {
    /// By unit of slots: sum of the sizes of shapes, their number, and the box around them.
    parts: Vec<Part>,
    places: Vec<u64>,
    leaves: Vec<Leaf>,
    /// Level by level, those over the leaves first.
    nodes: Vec<Columns>,
    /// Where each level begins.
    levels: Vec<usize>,
}

impl Flat {
    /// Builds the tree where enough has moved; says whether it did.
    pub fn build(&mut self, world: &World) -> bool {
        if !is_worth_it(world, world.moved.len()) {
            return false;
        }
        self.place(world);
        let places = &self.places;
        world
            .tasks
            .map_chunks(places.len(), WIDE, &mut self.leaves, |range| Leaf::fill(world, &places[range]));
        self.grow();
        true
    }
    /// Sorts the shapes along the curve; the large ones first, which would make the boxes of small ones large.
    fn place(&mut self, world: &World) {
        let (tasks, tags, fat) = (&world.tasks, &world.tags[..], &world.fat[..]);
        let size = |b: &Aabb| (b.max - b.min).max_component();
        tasks.map_chunks(tags.len(), SLOTS, &mut self.parts, |range| {
            let bounds = tags[range.clone()].iter().zip(&fat[range]);
            let bounds = bounds.filter(|(t, _)| t.bounded_mover()).map(|(_, b)| b);
            bounds.fold((0.0, 0.0, Aabb::EMPTY), |(sum, count, around), b| {
                (sum + size(b), count + 1.0, around.union(b))
            })
        });
        let all = |(sum, count, around): Part, p: &Part| (sum + p.0, count + p.1, around.union(&p.2));
        let (sum, count, around) = self.parts.iter().fold((0.0, 0.0, Aabb::EMPTY), all);
        let large = LARGE * sum / count;
        let curve = Curve::over(&around);
        self.places.resize(tags.len(), NOWHERE);
        tasks.for_each_piece((&mut self.places[..], tags, fat), SLOTS, |first, (places, tags, fat)| {
            for (i, ((place, t), b)) in places.iter_mut().zip(tags).zip(fat).enumerate() {
                let small = u64::from(size(b) <= large);
                let at = (small << 62) | (u64::from(curve.at(b)) << 32) | (first + i) as u64;
                *place = if t.bounded_mover() { at } else { NOWHERE };
            }
        });
        self.places.retain(|&p| p != NOWHERE);
        // There may be none: sensors move in the tree that is counted, and are not in this one.
        if tasks.is_serial() || self.places.len() < LEAST {
            self.places.sort_unstable();
            return;
        }
        let middle = self.places.len() / 2;
        let (low, _, high) = self.places.select_nth_unstable(middle);
        tasks.join(|| low.sort_unstable(), || high.sort_unstable());
    }
    /// The nodes over the leaves.
    fn grow(&mut self) {
        self.nodes.clear();
        self.levels.clear();
        let mut first = 0;
        let leaves = self.leaves.len();
        self.levels.push(0);
        for k in 0..leaves.div_ceil(WIDE) {
            let mut node = NOTHING;
            for (i, leaf) in self.leaves[k * WIDE..leaves.min((k + 1) * WIDE)].iter().enumerate() {
                put(&mut node, i, &leaf.bounds);
            }
            self.nodes.push(node);
        }
        while self.nodes.len() - first > 1 {
            let end = self.nodes.len();
            self.levels.push(end);
            for k in 0..(end - first).div_ceil(WIDE) {
                let mut node = NOTHING;
                for i in 0..WIDE.min(end - first - k * WIDE) {
                    let below = &self.nodes[first + k * WIDE + i];
                    for c in 0..6 {
                        let side = below[c].iter().copied();
                        node[c][i] = if c < 3 {
                            side.fold(f32::INFINITY, |m, x| if x < m { x } else { m })
                        } else {
                            side.fold(f32::NEG_INFINITY, |m, x| if x > m { x } else { m })
                        };
                    }
                }
                self.nodes.push(node);
            }
            first = end;
        }
    }
    pub fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }
}

/// Tells of every pair of shapes that meet and did not meet before, one of them in a leaf, and the other there or behind it. Ends where it
/// is answered with false, and says so.
pub(super) struct Join<'a> {
    pub flat: &'a Flat,
    pub leaf: usize,
    pub see: &'a mut dyn FnMut(u32, u32) -> bool,
}

impl jounce_lanes::Kernel for Join<'_> {
    type Output = bool;
    #[inline(always)]
    fn run<L: Lanes>(self) -> bool {
        let Self { flat, leaf, see } = self;
        let a = &flat.leaves[leaf];
        let around = sides(&a.bounds);
        let top = flat.levels.len() - 1;
        // Node on each level, and which of its children are left.
        let mut path = [(0, 0_u32); LEVELS];
        let mut level = top;
        path[top] = (0, hits::<L>(&flat.nodes[flat.levels[top]], &around));
        loop {
            let (n, left) = path[level];
            if left == 0 {
                if level == top {
                    return true;
                }
                level += 1;
                continue;
            }
            path[level].1 = left & (left - 1);
            let child = n * WIDE + left.trailing_zeros() as usize;
            // All before the leaf have met it.
            if ((child + 1) << (4 * level)) <= leaf {
                continue;
            }
            if level > 0 {
                level -= 1;
                path[level] = (child, hits::<L>(&flat.nodes[flat.levels[level] + child], &around));
                continue;
            }
            let b = &flat.leaves[child];
            if !(a.moved || b.moved) {
                continue;
            }
            for m in 0..a.len {
                let mut new = hits::<L>(&b.now, &row(&a.now, m));
                if child == leaf {
                    // Of a leaf's own shapes, each meets those behind it.
                    new &= !1 << m;
                }
                if new != 0 {
                    new &= !hits::<L>(&b.before, &row(&a.before, m));
                }
                while new != 0 {
                    if !see(a.slots[m], b.slots[new.trailing_zeros() as usize]) {
                        return false;
                    }
                    new &= new - 1;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::pair_key;
    use crate::{BodyDesc, ShapeDesc, WorldDesc};
    use jounce_lanes::{Width, dispatch, dispatch_arrays};
    use jounce_math::Vec3;
    use jounce_tasks::Tasks;

    /// Bodies of many sizes, of which some moved: every width finds each new pair once, as one look at all of them does.
    #[test]
    fn joins_what_meets_and_did_not() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        for (n, wide) in [(300, 6.0), (777, 8.0), (5000, 16.0)] {
            let mut w = World::new(WorldDesc::default()).expect("valid");
            let mut boxes = Vec::new();
            for i in 0..n {
                let mut v = |s: f32| Vec3::new(random(), random(), random()) * s;
                let at = v(wide);
                let size = if i % 97 == 0 { 4.0 } else { 0.5 };
                let half = v(size) + Vec3::splat(0.05);
                let body =
                    BodyDesc::dynamic().at(at.as_dvec3()).shape(ShapeDesc::cuboid([half.x, half.y, half.z]));
                w.add_body(body).expect("valid");
                boxes.push(w.fat[i]);
            }
            // A third stayed, a third came from elsewhere, and a third is new there.
            for i in 0..n {
                match i % 3 {
                    0 => w.tags[i].set_moved(false),
                    1 => {}
                    _ => continue,
                }
                let by = if i % 3 == 0 { Vec3::ZERO } else { Vec3::splat(0.3) };
                w.fat_before[i] = Aabb::new(w.fat[i].min + by, w.fat[i].max + by);
            }
            let met =
                |i: usize, k: usize| i % 3 != 2 && k % 3 != 2 && w.fat_before[i].overlaps(&w.fat_before[k]);
            let mut want = Vec::new();
            for i in 0..n {
                want.extend((0..i).filter(|&k| boxes[i].overlaps(&boxes[k]) && !met(i, k)).map(|k| (k, i)));
            }
            let mut want: Vec<u64> = want.into_iter().map(|(k, i)| pair_key(k as u32, i as u32)).collect();
            want.sort_unstable();
            assert!(want.len() > n / 4, "{}", want.len());
            let mut flat = Flat::default();
            assert!(flat.build(&w));
            for width in Width::ALL {
                for arrays in [false, true] {
                    let mut got = Vec::new();
                    for leaf in 0..flat.leaves().len() {
                        let mut see = |a, b| {
                            got.push(pair_key(a, b));
                            true
                        };
                        let join = Join { flat: &flat, leaf, see: &mut see };
                        assert!(if arrays { dispatch_arrays(width, join) } else { dispatch(width, join) });
                    }
                    got.sort_unstable();
                    assert_eq!(got, want, "{n} shapes, {width} lanes, arrays: {arrays}");
                }
            }
        }
    }

    /// Sensors move in the tree that says whether a flat one is worth it, but are not in that: it may stay empty, on any number of threads.
    #[test]
    fn nothing_solid_may_move() {
        for tasks in [Tasks::serial(), Tasks::pool(2)] {
            let mut w = World::new(WorldDesc::default()).expect("valid");
            w.set_tasks(tasks);
            for i in 0..LEAST + 44 {
                let at = [(i % 20) as f64, (i / 20) as f64, 0.0];
                let sensor = ShapeDesc::sphere(0.4).sensor();
                w.add_body(BodyDesc::kinematic().at(at).velocity([9.0, 0.0, 0.0]).shape(sensor))
                    .expect("valid");
            }
            assert!(Flat::default().build(&w), "the case is not met");
            for _ in 0..5 {
                w.step().expect("valid");
            }
            assert!(w.contacts.is_empty());
        }
    }
}
