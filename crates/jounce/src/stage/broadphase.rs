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

pub(crate) fn run(world: &mut World, _: &Step) {
    if world.moved.is_empty() {
        return;
    }
    let units = world.moved.len().div_ceil(CHUNK);
    let mut lists = core::mem::take(&mut world.scratch.candidates);
    lists.resize_with(units.max(lists.len()), Vec::new);
    let shared: &World = world;
    shared.tasks.for_each(&mut lists[..units], 1, |unit, list| {
        list.clear();
        let from = unit * CHUNK;
        let to = (from + CHUNK).min(shared.moved.len());
        for &shape in &shared.moved[from..to] {
            search(shared, shape, list);
        }
    });
    // Which unit meets the next peak is chance: all lists keep room for twice the longest.
    let longest = lists.iter().map(Vec::len).max().unwrap_or(0);
    for list in &mut lists {
        list.reserve((2 * longest).saturating_sub(list.len()));
    }
    let mut keys = core::mem::take(&mut world.scratch.keys);
    keys.clear();
    for list in &lists[..units] {
        keys.extend_from_slice(list);
    }
    keys.sort_unstable();
    keys.dedup();
    for &key in &keys {
        make_contact(world, key);
    }
    (world.scratch.candidates, world.scratch.keys) = (lists, keys);
    for i in 0..world.moved.len() {
        let s = world.moved[i];
        world.shapes[s].moved = false;
    }
    world.moved.clear();
}

/// Collects the pairs of one shape that are new and allowed.
fn search(world: &World, shape: u32, out: &mut Vec<u64>) {
    let r = &world.shapes[shape];
    if r.sensor || r.place == Place::Nowhere {
        return;
    }
    let kind = world.bodies[r.body].kind;
    let mut see = |other: u32| {
        if may_meet(world, shape, other) {
            let key = pair_key(shape, other);
            if !world.pairs.contains(key) {
                out.push(key);
            }
        }
        true
    };
    if r.place == Place::Unbounded {
        for (other, _) in world.shapes.iter().filter(|(_, o)| matches!(o.place, Place::MovingTree(_))) {
            if near_plane(world, shape, other) {
                see(other);
            }
        }
        return;
    }
    world.moving_tree.query(&r.fat, &mut see);
    if kind == BodyKind::Dynamic {
        world.fixed_tree.query(&r.fat, &mut see);
    }
    for &plane in &world.unbounded {
        if near_plane(world, plane, shape) {
            see(plane);
        }
    }
}

/// Do a shape's fat bounds reach a half-space?
pub(crate) fn near_plane(world: &World, plane: u32, shape: u32) -> bool {
    let (p, s) = (&world.shapes[plane], &world.shapes[shape]);
    let Shape::HalfSpace { normal, offset } = p.shape else { return false };
    let pose = world.frames[p.body as usize].shape_pose(&p.pose);
    let n = pose.q.rotate(normal);
    let c = ((s.fat.min.as_dvec3() + s.fat.max.as_dvec3()) * 0.5 - pose.p).as_vec3();
    let reach = s.fat.half().dot(n.abs());
    n.dot(c) - offset <= reach + world.settings.speculative_margin()
}

/// Filters that do not depend on where the shapes are.
pub(crate) fn may_meet(world: &World, a: u32, b: u32) -> bool {
    let (ra, rb) = (&world.shapes[a], &world.shapes[b]);
    if ra.body == rb.body || ra.sensor || rb.sensor || !ra.filter.allows(&rb.filter) {
        return false;
    }
    let (ba, bb) = (&world.bodies[ra.body], &world.bodies[rb.body]);
    ba.kind == BodyKind::Dynamic || bb.kind == BodyKind::Dynamic
}

fn make_contact(world: &mut World, key: u64) {
    if world.pairs.contains(key) {
        return;
    }
    if world.pairs.len() >= limits::CONTACTS_MAX {
        world.events.push(Event::LimitReached { what: "contacts" });
        return;
    }
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
        cache: PairCache::default(),
        tested_pose: Pose::IDENTITY,
        tested_rotations: [Quat::IDENTITY; 2],
        tested: false,
        manifold: ContactManifold::default(),
        rest: Vec::new(),
        slop: f32s::min(0.005 * unit, 0.05 * thin),
        extent_b: rb.shape.outer_radius(center),
        recycle_tolerance: f32s::min(0.02 * unit, 0.1 * thin),
        deep: false,
        share: 1.0,
        hit_speed: 0.0,
    };
    world.link_contact(contact);
}
