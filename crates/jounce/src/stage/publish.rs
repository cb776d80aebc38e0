//! Ends a step: bounds of what moved, sensors, hits; the clock.

use super::Step;
use crate::edit::margin_of;
use crate::event::Event;
use crate::room::contacts::state::{Contact, Place};
use crate::room::rigid::state::BodyFrame;
use crate::world::World;
use jounce_geometry::Aabb;
use jounce_math::{Vec3, scalar::f32s};

/// Bodies in a unit.
const BODIES: usize = 128;

pub(crate) fn run(world: &mut World, step: &Step) {
    bounds(world, step);
    super::sensors::run(world);
    hits(world);
    world.step_count += 1;
    world.fields.time = world.time();
}

/// What a unit of bodies found out about their bounds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Moves {
    /// By row: how far it may still go.
    rooms: Vec<f32>,
    /// Shapes that left their fat bounds, and new ones.
    left: Vec<(u32, Aabb)>,
    unbounded: Vec<u32>,
}

/// Moves the fat bounds of shapes that left theirs.
fn bounds(world: &mut World, step: &Step) {
    let rows = world.awake.step.len();
    let units = rows.div_ceil(BODIES);
    let mut moves = core::mem::take(&mut world.scratch.bounds);
    moves.resize_with(units.max(moves.len()), Moves::default);
    let shared: &World = world;
    shared.tasks.for_each(&mut moves[..units], 1, |unit, m| {
        m.rooms.clear();
        m.left.clear();
        m.unbounded.clear();
        for row in unit * BODIES..rows.min((unit + 1) * BODIES) {
            let room = look(shared, step, row, m);
            m.rooms.push(room);
        }
    });
    let rooms = moves[..units].iter().flat_map(|m| &m.rooms);
    world.awake.step.iter_mut().zip(rooms).for_each(|(b, room)| b.room = *room);
    for m in &moves[..units] {
        m.unbounded.iter().for_each(|&s| world.mark_moved(s));
        for &(s, fat) in &m.left {
            world.fat[s as usize] = fat;
            if let Place::MovingTree(leaf) = world.shapes[s].place {
                world.moving_tree.enlarge(leaf, fat);
            }
            world.mark_moved(s);
        }
    }
    world.scratch.bounds = moves;
    world.moving_tree.tidy();
}

/// The room that a body still has; what left its bounds goes into the list. What has not moved as far as it has room is not looked at.
fn look(world: &World, step: &Step, row: usize, m: &mut Moves) -> f32 {
    let b = &world.awake.step[row];
    let body = &world.bodies[b.body];
    // Bouncing pairs must be seen a step ahead.
    let far = world.bouncy > 0 || body.looks_ahead();
    let ahead = if far { world.awake.state[row].v() * step.dt } else { Vec3::ZERO };
    let room = b.room - moved(&world.frames[b.body as usize], body.mass.outer_radius);
    if room > ahead.length() {
        return room;
    }
    let mut room = f32::INFINITY;
    for &s in &body.shapes {
        let r = &world.shapes[s];
        match r.place {
            Place::MovingTree(_) => {}
            Place::Unbounded => {
                m.unbounded.push(s);
                room = 0.0;
                continue;
            }
            _ => continue,
        }
        let tight = world.tight_bounds(s);
        let next = tight.union(&Aabb::new(tight.min + ahead, tight.max + ahead));
        let mut fat = world.fat[s as usize];
        if !fat.contains(&next) {
            fat = next.expanded(margin_of(&next, world.settings.length_unit));
            m.left.push((s, fat));
        }
        // The radius is that of the solid shapes.
        room = f32s::min(room, if r.sensor { 0.0 } else { slack(&fat, &tight) });
    }
    room
}

/// How far the farthest point of a body went in the step, at most, m.
fn moved(f: &BodyFrame, radius: f32) -> f32 {
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
        for p in m.points.iter().take(usize::from(m.count)) {
            impulse += p.total_impulse;
            if p.total_impulse > most {
                (most, at, normal) = (p.total_impulse, p.on_a, m.normal);
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
