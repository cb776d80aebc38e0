//! New pairs: every shape whose bounds changed asks the trees whom it may meet.
//!
//! Units of the search write candidate keys into lists of their own; the keys are then sorted, so that the order in which
//! contacts are made depends on slots alone.

use super::Step;
use crate::event::Event;
use crate::hooks::PairView;
use crate::limits;
use crate::room::contacts::state::{Contact, ContactManifold, Place};
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::table::pair_key;
use crate::world::World;
use jounce_geometry::{PairCache, Shape};
use jounce_math::{Pose, Quat, scalar::f32s};

/// Moved shapes per unit.
const CHUNK: usize = 32;

/// In place of a key: the unit stopped there.
const CUT: u64 = u64::MAX;
/// Room for keys that every unit keeps, whoever needed it: which one meets the next peak is chance.
const KEPT: usize = 1 << 10;
/// Units that keep room though they have nothing to do; a first step may have had thousands.
const USUAL: usize = 256;
/// Contacts whose list should not double: some 30 MB.
const MANY: usize = 1 << 16;

pub(crate) fn run(world: &mut World, _: &Step) {
    if world.moved.is_empty() {
        return;
    }
    let units = world.moved.len().div_ceil(CHUNK);
    let most = (2 * limits::CONTACTS_MAX / units).max(limits::FOUND_PAIRS_MAX);
    let mut lists = core::mem::take(&mut world.scratch.candidates);
    lists.resize_with(units.max(lists.len()), Vec::new);
    let shared: &World = world;
    shared.tasks.for_each(&mut lists[..units], 1, |unit, list| {
        list.clear();
        let from = unit * CHUNK;
        let to = (from + CHUNK).min(shared.moved.len());
        for &shape in &shared.moved[from..to] {
            search(shared, shape, most, list);
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
    let full = make_contacts(world, &keys, limits::CONTACTS_MAX);
    // Who was cut short goes on in the next step.
    let stays = |unit: usize| cut && !full && lists[unit].last() == Some(&CUT);
    let mut kept = 0;
    for i in 0..world.moved.len() {
        let s = world.moved[i];
        if stays(i / CHUNK) {
            world.moved[kept] = s;
            kept += 1;
        } else {
            world.shapes[s].moved = false;
        }
    }
    world.moved.truncate(kept);
    (world.scratch.candidates, world.scratch.keys) = (lists, keys);
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

/// Collects the pairs of one shape that are new and allowed, up to a length of the list.
fn search(world: &World, shape: u32, most: usize, out: &mut Vec<u64>) {
    let r = &world.shapes[shape];
    if r.sensor || r.place == Place::Nowhere || out.last() == Some(&CUT) {
        return;
    }
    let kind = world.bodies[r.body].kind;
    let mut see = |other: u32| {
        // Most are known; that takes one look, where all else takes one at each shape and body.
        let key = pair_key(shape, other);
        if world.pairs.contains(key) || !may_meet(world, shape, other) || finds_it_too(world, shape, other) {
            return true;
        }
        let room = out.len() < most;
        if room || out.last() != Some(&CUT) {
            out.push(if room { key } else { CUT });
        }
        room
    };
    let fat = &world.fat[shape as usize];
    if r.place == Place::Unbounded {
        for (other, _) in world.shapes.iter().filter(|(_, o)| matches!(o.place, Place::MovingTree(_))) {
            if near_plane(world, shape, other) && !see(other) {
                return;
            }
        }
        return;
    }
    world.moving_tree.query(fat, &mut see);
    if kind == BodyKind::Dynamic {
        world.fixed_tree.query(fat, &mut see);
    }
    for &plane in &world.unbounded {
        if near_plane(world, plane, shape) && !see(plane) {
            return;
        }
    }
}

/// A moved shape of a dynamic body finds all its pairs by itself; of two such, the one of the lower slot has them. So a floor does
/// not list all that lies on it.
fn finds_it_too(world: &World, shape: u32, other: u32) -> bool {
    let dynamic = |s: u32| world.bodies[world.shapes[s].body].kind == BodyKind::Dynamic;
    world.shapes[other].moved && dynamic(other) && !(dynamic(shape) && shape < other)
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
    let center = rb.pose.inverse_transform_point(world.frames[body_b as usize].local_center);
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
        extent_b: rb.shape.outer_radius(center),
        recycle_tolerance: f32s::min(0.02 * unit, 0.1 * thin),
        spare: 0.0,
        deep: false,
        share: 1.0,
        hit_speed: 0.0,
    };
    world.link_contact(contact);
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
        w.shapes[7].moved = false;
        let found = |shape: u32, most: usize, mut list: Vec<u64>| {
            search(&w, shape, most, &mut list);
            list
        };
        assert_eq!(found(0, 8, Vec::new()).len(), 8);
        let cut = found(0, 5, Vec::new());
        assert_eq!((cut.len(), cut.last()), (6, Some(&CUT)));
        assert_eq!(found(1, 5, cut.clone()), cut, "the rest of the unit waits");
        assert_eq!(found(8, 8, Vec::new()), [pair_key(7, 8)], "the others that moved find it themselves");
    }
}
