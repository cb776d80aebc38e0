//! Ends a step: bounds of what moved, sensors, hits; the clock.

use super::Step;
use crate::edit::margin_of;
use crate::event::Event;
use crate::room::contacts::state::{Contact, Place};
use crate::room::rigid::state::{BodyFrame, BodyStep};
use crate::world::World;
use jounce_geometry::Aabb;
use jounce_math::{Vec3, scalar::f32s};
use std::sync::{Mutex, PoisonError};

/// Bodies in a unit: few where there are few, since each may have many shapes.
fn unit_of(bodies: usize) -> usize {
    (bodies / 64).clamp(4, 128)
}

pub(crate) fn run(world: &mut World, step: &Step) {
    bounds(world, step);
    super::sensors::run(world);
    hits(world);
    world.step_count += 1;
    world.fields.time = world.time();
}

/// What left its bounds among a unit of bodies.
#[derive(Debug, Default)]
pub(crate) struct Moves(Vec<Mutex<Left>>);

impl Clone for Moves {
    /// Memory, not state: a clone starts without.
    fn clone(&self) -> Self {
        Self::default()
    }
}

#[derive(Debug, Default)]
struct Left {
    /// Shapes that left their fat bounds: slot, leaf and new bounds.
    bounded: Vec<(u32, u32, Aabb)>,
    unbounded: Vec<u32>,
}

/// Moves the fat bounds of shapes that left theirs.
fn bounds(world: &mut World, step: &Step) {
    let mut steps = core::mem::take(&mut world.awake.step);
    let mut moves = core::mem::take(&mut world.scratch.bounds);
    let unit = unit_of(steps.len());
    let units = steps.len().div_ceil(unit);
    moves.0.resize_with(units.max(moves.0.len()), Mutex::default);
    let shared: &World = world;
    let lists = &moves.0;
    shared.tasks.for_each_chunk(&mut steps, unit, |first, chunk| {
        // A unit locks its own list, so no lock is ever waited for.
        let mut left = lists[first / unit].lock().unwrap_or_else(PoisonError::into_inner);
        left.bounded.clear();
        left.unbounded.clear();
        for (i, b) in chunk.iter_mut().enumerate() {
            b.moved = moved(&shared.frames[b.body as usize], b.radius);
            b.room = look(shared, step, b, shared.awake.state[first + i].v(), &mut left);
        }
    });
    world.awake.step = steps;
    let mut count = 0;
    for left in &mut moves.0[..units] {
        let left = left.get_mut().unwrap_or_else(PoisonError::into_inner);
        count += left.bounded.len();
        left.unbounded.iter().for_each(|&s| world.mark_moved(s));
        for &(s, _, fat) in &left.bounded {
            world.fat[s as usize] = fat;
            world.list_moved(s);
        }
    }
    let left = moves.0[..units].iter_mut().map(|l| l.get_mut().unwrap_or_else(PoisonError::into_inner));
    let leaves = left.flat_map(|l| &l.bounded).map(|&(_, leaf, fat)| (leaf, fat));
    world.moving_tree.enlarge_all(count, leaves);
    world.scratch.bounds = moves;
}

/// The room that a body still has; what left its bounds goes into the list. What has not moved as far as it has room is not looked at.
fn look(world: &World, step: &Step, b: &BodyStep, v: Vec3, left: &mut Left) -> f32 {
    let room = b.room - b.moved;
    let ahead = v * step.dt;
    // Room for a step ahead, which most have, will do for those that do not look ahead, too.
    if room > ahead.length() {
        return room;
    }
    // Bouncing pairs must be seen a step ahead.
    let far = world.bouncy > 0 || world.frames[b.body as usize].looks_ahead;
    if !far && room > 0.0 {
        return room;
    }
    let ahead = if far { ahead } else { Vec3::ZERO };
    let mut room = f32::INFINITY;
    for &s in &world.bodies[b.body].shapes {
        let r = &world.shapes[s];
        let leaf = match r.place {
            Place::MovingTree(leaf) => leaf,
            Place::Unbounded => {
                left.unbounded.push(s);
                room = 0.0;
                continue;
            }
            _ => continue,
        };
        let tight = world.tight_bounds(s);
        let next = tight.union(&Aabb::new(tight.min + ahead, tight.max + ahead));
        let mut fat = world.fat[s as usize];
        if !fat.contains(&next) {
            fat = next.expanded(margin_of(&next, world.settings.length_unit));
            left.bounded.push((s, leaf, fat));
        }
        // The radius is that of the solid shapes.
        room = f32s::min(room, if r.sensor { 0.0 } else { slack(&fat, &tight) });
    }
    room
}

/// How far the farthest point of a body went in the step, at most, m.
pub(crate) fn moved(f: &BodyFrame, radius: f32) -> f32 {
    let way = (f.center - f.center0).length() as f32;
    // A turn by θ moves a point by 2 R sin(θ/2), which is the vector part of its quaternion.
    let turn = (f.rotation * f.rotation0.conjugate()).xyz().length();
    1.001 * (way + 2.0 * radius * turn)
}

/// The way in any direction that keeps `inner` in `outer`, but for the rounding of both.
fn slack(outer: &Aabb, inner: &Aabb) -> f32 {
    let least = f32s::min((inner.min - outer.min).min_component(), (outer.max - inner.max).min_component());
    let size = f32s::max(outer.min.abs().max_component(), outer.max.abs().max_component());
    least - 4.0 * f32::EPSILON * size
}

fn hits(world: &mut World) {
    if world.telling == 0 {
        return;
    }
    let threshold = world.settings.hit_event_speed;
    for row in 0..world.contacts.len() {
        let c = &world.contacts[row];
        if c.hit_speed >= threshold
            && (world.shapes[c.shape_a].hit_events || world.shapes[c.shape_b].hit_events)
        {
            let event = hit(world, c);
            world.events.push(event);
        }
    }
}

fn hit(world: &World, c: &Contact) -> Event {
    let fa = &world.frames[c.body_a as usize];
    let (mut impulse, mut most, mut at, mut normal) = (0.0, -1.0, jounce_math::Vec3::ZERO, c.manifold.normal);
    for m in c.manifolds() {
        for (anchor, total) in m.anchors.iter().zip(m.totals).take(usize::from(m.count)) {
            impulse += total;
            if total > most {
                (most, at, normal) = (total, anchor.on_a, m.normal);
            }
        }
    }
    Event::ContactHit {
        a: world.shape_id(c.shape_a),
        b: world.shape_id(c.shape_b),
        point: fa.center + fa.rotation.rotate(at).as_dvec3(),
        normal,
        speed: c.hit_speed,
        impulse,
    }
}
