//! New pairs: every shape whose bounds changed asks the trees whom it may meet.
//!
//! Shapes that moved are sorted along a space-filling curve, and neighbours on it go through a tree together: what meets the box
//! around them is held against each of them, many at a time; where much moved, a flat tree is made and joined with itself. A pair whose bounds met before the move has its contact already, and
//! is passed over without a look at a table. Units of the search write candidate keys into lists of their own; the keys are then
//! sorted, so that the order in which contacts are made depends on slots alone.

use super::Step;
use super::flat::{Flat, Join, Leaf};
use super::reach::{BLOCK, Block, Group, Kernel};
use crate::event::Event;
use crate::hooks::PairView;
use crate::limits;
use crate::room::contacts::state::{Contact, ContactManifold, Place, ShapeRecord};
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::table::pair_key;
use crate::world::World;
use jounce_geometry::{Aabb, Bvh, PairCache, Shape};
use jounce_lanes::dispatch;
use jounce_math::{Pose, Quat, Vec3, scalar::f32s};

/// Moved shapes per unit.
const CHUNK: usize = 64;
/// Leaves per unit.
const LEAVES: usize = 4;
/// So few are not worth sorting.
const FEW: usize = 16;

/// In place of a key: the unit stopped there.
const CUT: u64 = u64::MAX;
/// Room for keys that every unit keeps, whoever needed it: which one meets the next peak is chance.
const KEPT: usize = 1 << 10;
/// Units that keep room though they have nothing to do; a first step may have had thousands.
const USUAL: usize = 256;
/// Contacts whose list should not double: some 30 MB.
const MANY: usize = 1 << 16;
/// Bounds that met nothing: comparisons with them are false.
pub(crate) const NEVER: Aabb = Aabb::new(Vec3::splat(f32::NAN), Vec3::splat(f32::NAN));

/// What the pair search asks of a shape first, in a byte, where the records of shape and body are half a kilobyte each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tag(u8);

impl Tag {
    const MOVED: u8 = 1;
    const DYNAMIC: u8 = 2;
    const SOLID: u8 = 4;
    const UNBOUNDED: u8 = 8;
    const MOVER: u8 = 16;

    /// Of a shape that has just been given its place.
    pub fn new(kind: BodyKind, solid: bool, unbounded: bool) -> Self {
        let bits = [
            (kind == BodyKind::Dynamic, Self::DYNAMIC),
            (kind != BodyKind::Fixed, Self::MOVER),
            (solid, Self::SOLID),
            (unbounded, Self::UNBOUNDED),
        ];
        Self(bits.into_iter().filter(|b| b.0).fold(0, |all, b| all | b.1))
    }
    /// Is it in the tree of what moves, and no sensor?
    pub fn bounded_mover(self) -> bool {
        self.0 & (Self::MOVER | Self::SOLID | Self::UNBOUNDED) == Self::MOVER | Self::SOLID
    }
    fn has(self, bit: u8) -> bool {
        self.0 & bit != 0
    }
    /// In the move buffer.
    pub fn moved(self) -> bool {
        self.has(Self::MOVED)
    }
    pub fn set_moved(&mut self, on: bool) {
        self.0 = if on { self.0 | Self::MOVED } else { self.0 & !Self::MOVED };
    }
}

pub(crate) fn run(world: &mut World, _: &Step) {
    if world.moved.is_empty() {
        return;
    }
    // A hook may refuse what it did not refuse before.
    world.pairs_missing |= world.hooks.filter.is_some();
    let mut flat = core::mem::take(&mut world.scratch.flat);
    let mut aside = core::mem::take(&mut world.scratch.aside);
    let dense = flat.build(world);
    aside.clear();
    if dense {
        aside.extend(world.moved.iter().filter(|&&s| !world.tags[s as usize].bounded_mover()));
    } else {
        sort_moved(world);
    }
    let mut lists = core::mem::take(&mut world.scratch.candidates);
    let shared: &World = world;
    let searched = if dense { &aside[..] } else { &shared.moved[..] };
    let leaves = if dense { flat.leaves() } else { &[] };
    let some = searched.len().div_ceil(CHUNK);
    let units = some + leaves.len().div_ceil(LEAVES);
    let most = (2 * limits::CONTACTS_MAX / units).max(limits::FOUND_PAIRS_MAX);
    lists.resize_with(units.max(lists.len()), Vec::new);
    shared.tasks.for_each(&mut lists[..units], 1, |unit, list| {
        list.clear();
        if unit < some {
            let from = unit * CHUNK;
            search(shared, &searched[from..searched.len().min(from + CHUNK)], most, list);
        } else {
            let from = (unit - some) * LEAVES;
            join(shared, &flat, from..leaves.len().min(from + LEAVES), most, list);
        }
    });
    let usual = lists.len().min(units.max(USUAL));
    let longest = lists[..units].iter().map(Vec::len).max().unwrap_or(0);
    let room = (2 * longest).min(KEPT);
    let mut keys = core::mem::take(&mut world.scratch.keys);
    keys.clear();
    for list in &mut lists[..usual] {
        list.reserve(room.saturating_sub(list.len()));
    }
    for list in &lists[..units] {
        keys.extend_from_slice(list);
    }
    keys.sort_unstable();
    keys.dedup();
    let cut = keys.last() == Some(&CUT);
    if cut {
        keys.pop();
        world.events.push(Event::LimitReached { what: "new pairs of a step" });
    }
    let mut moved = core::mem::take(&mut world.moved);
    let (mut tags, mut before) = (core::mem::take(&mut world.tags), core::mem::take(&mut world.fat_before));
    let fat = core::mem::take(&mut world.fat);
    let mut settle = |stays: &dyn Fn(usize) -> bool| {
        let mut kept = 0;
        for i in 0..moved.len() {
            let s = moved[i];
            if stays(i / CHUNK) {
                moved[kept] = s;
                before[s as usize] = NEVER;
                kept += 1;
            } else {
                tags[s as usize].set_moved(false);
                before[s as usize] = fat[s as usize];
            }
        }
        moved.truncate(kept);
    };
    if cut {
        let full = make_contacts(world, &keys, limits::CONTACTS_MAX);
        // Who was cut short goes on in the next step.
        settle(&|unit| !full && (dense || lists[unit].last() == Some(&CUT)));
        world.pairs_missing |= full;
    } else {
        // What makes contacts asks nothing of the bounds.
        let tasks = world.tasks.clone();
        let make = || world.pairs_missing |= make_contacts(world, &keys, limits::CONTACTS_MAX);
        tasks.join(make, || settle(&|_| false));
    }
    (world.moved, world.tags, world.fat_before, world.fat) = (moved, tags, before, fat);
    (world.scratch.candidates, world.scratch.keys) = (lists, keys);
    (world.scratch.flat, world.scratch.aside) = (flat, aside);
}

/// A curve through a box that comes by all near one place before it goes to another (Morton).
pub(super) struct Curve {
    twice_min: Vec3,
    cells: f32,
}

impl Curve {
    pub fn over(b: &Aabb) -> Self {
        Self { twice_min: b.min * 2.0, cells: 511.5 / (b.max - b.min).max_component() }
    }
    /// Where it comes by the centre of a box.
    pub fn at(&self, b: &Aabb) -> u32 {
        let p = (b.min + b.max - self.twice_min) * self.cells;
        let [x, y, z] = [p.x, p.y, p.z].map(|v| spread(v as u32));
        x << 2 | y << 1 | z
    }
}

/// Sorts the move buffer along a curve through space: neighbours on it are neighbours there.
fn sort_moved(world: &mut World) {
    if world.moved.len() <= FEW {
        return;
    }
    let mut places = core::mem::take(&mut world.scratch.keys);
    places.clear();
    let fat = |&s: &u32| &world.fat[s as usize];
    let curve = Curve::over(&world.moved.iter().map(fat).fold(Aabb::EMPTY, |all, b| all.union(b)));
    places.extend(world.moved.iter().map(|s| (u64::from(curve.at(fat(s))) << 32) | u64::from(*s)));
    places.sort_unstable();
    world.moved.iter_mut().zip(&places).for_each(|(s, &p)| *s = p as u32);
    world.scratch.keys = places;
}

/// The lowest 10 bits, two zeros after each.
fn spread(x: u32) -> u32 {
    let x = x.min(1023);
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Makes the contacts of new pairs, in the order of their keys, up to a limit; true where that was reached.
fn make_contacts(world: &mut World, keys: &[u64], limit: usize) -> bool {
    for &key in keys {
        if world.pairs.contains(key) {
            continue;
        }
        if world.pairs.len() >= limit {
            world.events.push(Event::LimitReached { what: "contacts" });
            return true;
        }
        // Many grow by a quarter: doubling would hold as much again in vain.
        let n = world.contacts.len();
        if n >= MANY && n == world.contacts.capacity() {
            world.contacts.reserve_exact(n / 4);
        }
        make_contact(world, key);
    }
    false
}

/// Collects the pairs of some shapes that are new and allowed, up to a length of the list.
fn search(world: &World, shapes: &[u32], most: usize, out: &mut Vec<u64>) {
    let mut found = Found { world, most, out, joined: false };
    let mut group = Group::new();
    for &s in shapes {
        let tag = world.tags[s as usize];
        if !tag.has(Tag::SOLID) {
            continue;
        }
        if tag.has(Tag::UNBOUNDED) {
            if !found.below_plane(s) {
                return;
            }
            continue;
        }
        let fat = &world.fat[s as usize];
        if !group.takes(fat) {
            if !found.around(&group) {
                return;
            }
            group.clear();
        }
        group.push(s, fat, world.met_before(s), tag.has(Tag::DYNAMIC));
    }
    found.around(&group);
}

/// The same for the shapes in some leaves of the flat tree.
fn join(world: &World, flat: &Flat, leaves: core::ops::Range<usize>, most: usize, out: &mut Vec<u64>) {
    let mut found = Found { world, most, out, joined: true };
    for leaf in leaves {
        let mut see = |a, b| found.see(a, b);
        if !dispatch(world.width, Join { flat, leaf, see: &mut see }) || !found.below(&flat.leaves()[leaf]) {
            return;
        }
    }
}

/// The pairs that a unit found.
struct Found<'a> {
    world: &'a World,
    most: usize,
    out: &'a mut Vec<u64>,
    /// All pairs in the tree of what moves come up once.
    joined: bool,
}

impl Found<'_> {
    /// False when the list is full.
    fn see(&mut self, shape: u32, other: u32) -> bool {
        let world = self.world;
        let key = pair_key(shape, other);
        if (!self.joined && finds_it_too(world, shape, other))
            || world.pairs.contains(key)
            || !may_meet(world, shape, other)
        {
            return true;
        }
        let room = self.out.len() < self.most;
        self.out.push(if room { key } else { CUT });
        room
    }
    /// What the bounds of a group meet.
    fn around(&mut self, group: &Group) -> bool {
        if group.is_empty() {
            return true;
        }
        let world = self.world;
        if (!self.joined && !self.among(world.moving_tree.get(), group, u32::MAX))
            || (group.dynamic != 0 && !self.among(&world.fixed_tree, group, group.dynamic))
        {
            return false;
        }
        let planes = || world.unbounded.iter().copied();
        group
            .slots()
            .iter()
            .all(|&s| planes().all(|plane| !near_plane(world, plane, s) || self.see(s, plane)))
    }
    /// What moved of a leaf, and what is fixed.
    fn below(&mut self, leaf: &Leaf) -> bool {
        let world = self.world;
        if !leaf.moved() || (world.fixed_tree.is_empty() && world.unbounded.is_empty()) {
            return true;
        }
        let mut group = Group::new();
        for &s in leaf.slots() {
            let tag = world.tags[s as usize];
            if tag.moved() {
                group.push(s, &world.fat[s as usize], world.met_before(s), tag.has(Tag::DYNAMIC));
            }
        }
        self.around(&group)
    }
    /// What those members of a group that are in a mask meet in a tree.
    fn among(&mut self, tree: &Bvh, group: &Group, members: u32) -> bool {
        if tree.is_empty() {
            return true;
        }
        let mut block = Block::new();
        let mut room = true;
        tree.query_boxes(group.bounds(), |other, fat| {
            block.push(other, fat, &self.world.fat_before[other as usize]);
            if block.len() == BLOCK {
                room = self.sift(&block, group, members);
                block.clear();
            }
            room
        });
        room && self.sift(&block, group, members)
    }
    /// Holds a block against the members of a group.
    fn sift(&mut self, block: &Block, group: &Group, members: u32) -> bool {
        let hits = dispatch(self.world.width, Kernel { block, group });
        for (m, &s) in group.slots().iter().enumerate() {
            let mut left = if members >> m & 1 == 0 { 0 } else { hits[m] };
            while left != 0 {
                let other = block.slots[left.trailing_zeros() as usize];
                debug_assert!(self.world.fat[s as usize].overlaps(&self.world.fat[other as usize]));
                if other != s && !self.see(s, other) {
                    return false;
                }
                left &= left - 1;
            }
        }
        true
    }
    /// All that is near a half-space.
    fn below_plane(&mut self, plane: u32) -> bool {
        let world = self.world;
        let mut bounded = world.shapes.iter().filter(|(_, o)| matches!(o.place, Place::MovingTree(_)));
        bounded.all(|(other, _)| !near_plane(world, plane, other) || self.see(plane, other))
    }
}

/// A moved shape of a dynamic body finds all its pairs by itself; of two such, the one of the lower slot has them. So a floor does
/// not list all that lies on it.
fn finds_it_too(world: &World, shape: u32, other: u32) -> bool {
    let (a, b) = (world.tags[shape as usize], world.tags[other as usize]);
    b.moved() && b.has(Tag::DYNAMIC) && !(a.has(Tag::DYNAMIC) && shape < other)
}

impl World {
    /// The bounds with which a shape met all that it has contacts with.
    pub(super) fn met_before(&self, shape: u32) -> &Aabb {
        if self.pairs_missing { &NEVER } else { &self.fat_before[shape as usize] }
    }
}

/// Do a shape's fat bounds reach a half-space?
pub(crate) fn near_plane(world: &World, plane: u32, shape: u32) -> bool {
    let (p, fat) = (&world.shapes[plane], &world.fat[shape as usize]);
    let Shape::HalfSpace { normal, offset } = p.shape else { return false };
    let pose = world.frames[p.body as usize].shape_pose(&p.pose);
    let n = pose.q.rotate(normal);
    let c = ((fat.min.as_dvec3() + fat.max.as_dvec3()) * 0.5 - pose.p).as_vec3();
    let reach = fat.half().dot(n.abs());
    n.dot(c) - offset <= reach + world.settings.speculative_margin()
}

/// Filters that do not depend on where the shapes are.
pub(crate) fn may_meet(world: &World, a: u32, b: u32) -> bool {
    let (ra, rb) = (&world.shapes[a], &world.shapes[b]);
    if ra.body == rb.body || ra.sensor || rb.sensor || !ra.filter.allows(&rb.filter) {
        return false;
    }
    let (ba, bb) = (&world.bodies[ra.body], &world.bodies[rb.body]);
    (ba.kind == BodyKind::Dynamic || bb.kind == BodyKind::Dynamic) && !world.are_parted(ra.body, rb.body)
}

fn make_contact(world: &mut World, key: u64) {
    let (mut a, mut b) = ((key >> 32) as u32, key as u32);
    // The fixed body is A, so that normals point away from the ground and kinds of shapes meet in few orders.
    let dynamic = |s: u32| world.bodies[world.shapes[s].body].kind == BodyKind::Dynamic;
    if dynamic(a) && !dynamic(b) {
        core::mem::swap(&mut a, &mut b);
    }
    let (ra, rb) = (&world.shapes[a], &world.shapes[b]);
    let (body_a, body_b) = (ra.body, rb.body);
    if let Some((_, hook)) = &world.hooks.filter {
        let view = PairView {
            shapes: [world.shape_id(a), world.shape_id(b)],
            bodies: [world.body_id(body_a), world.body_id(body_b)],
            user_data: [world.bodies[body_a].user_data, world.bodies[body_b].user_data],
        };
        if !hook(&view) {
            return;
        }
    }
    let unit = world.settings.length_unit;
    let thin = f32s::min(ra.thickness, rb.thickness);
    let (middle_b, extent_b) = pivot(rb, world.frames[body_b as usize].local_center);
    // Only these have more than one manifold.
    let many = !(ra.shape.is_convex() && rb.shape.is_convex());
    let rest = if many { world.scratch.manifolds.pop() } else { None }.unwrap_or_default();
    let contact = Contact {
        id: NONE,
        shape_a: a,
        shape_b: b,
        body_a,
        body_b,
        edge: [NONE; 2],
        touching: false,
        now_touching: false,
        apart: false,
        fixed: !dynamic(a) || !dynamic(b),
        planes: [ra, rb].map(|r| r.place == Place::Unbounded),
        cache: PairCache::default(),
        tested_pose: Pose::IDENTITY,
        tested_rotations: [Quat::IDENTITY; 2],
        tested: false,
        manifold: ContactManifold::default(),
        rest,
        slop: f32s::min(0.005 * unit, 0.05 * thin),
        extent_b,
        middle_b,
        margin: 0.0,
        bouncy: false,
        near: None,
        recycle_tolerance: f32s::min(0.02 * unit, 0.1 * thin),
        spare: 0.0,
        deep: false,
        hit_speed: 0.0,
    };
    world.link_contact(contact);
}

/// The point about which the turns of a shape are counted, from the body's centre of mass in the body's axes, and how far the shape reaches
/// from there: the centre of mass, or the middle of a shape that is far from it.
fn pivot(r: &ShapeRecord, center: Vec3) -> (Vec3, f32) {
    let outer = r.shape.outer_radius(r.pose.inverse_transform_point(center));
    if r.shape.is_convex() && 2.0 * r.reach < outer {
        (r.pose.transform_point(r.middle) - center, r.reach)
    } else {
        (Vec3::ZERO, outer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BodyDesc, ShapeDesc, WorldDesc};

    #[test]
    fn pairs_beyond_the_limit_are_left_out_and_told_once() {
        let mut w = World::new(WorldDesc::default()).expect("valid");
        for _ in 0..4 {
            w.add_body(BodyDesc::dynamic().shape(ShapeDesc::sphere(1.0))).expect("valid");
        }
        let keys: Vec<u64> = (0..4).flat_map(|b| (0..b).map(move |a| pair_key(a, b))).collect();
        assert!(make_contacts(&mut w, &keys, 3));
        assert_eq!(w.pairs.len(), 3);
        assert_eq!(w.events, [Event::LimitReached { what: "contacts" }]);
        assert!(!make_contacts(&mut w, &keys[..3], 3), "those are there");
        w.validate();
    }

    #[test]
    fn a_search_that_is_cut_short_says_so() {
        let mut w = World::new(WorldDesc::default()).expect("valid");
        for _ in 0..9 {
            w.add_body(BodyDesc::dynamic().shape(ShapeDesc::sphere(1.0))).expect("valid");
        }
        w.tags[7].set_moved(false);
        let found = |shapes: &[u32], most: usize| {
            let mut list = Vec::new();
            search(&w, shapes, most, &mut list);
            list
        };
        assert_eq!(found(&[0], 8).len(), 8);
        let cut = found(&[0, 1], 5);
        assert_eq!((cut.len(), cut.last()), (6, Some(&CUT)), "the rest of the unit waits");
        assert_eq!(found(&[8], 8), [pair_key(7, 8)], "the others that moved find it themselves");
    }
}
