//! Ends a step: bounds of what moved, sensors, hits; the clock.

use super::Step;
use crate::edit::margin_of;
use crate::event::Event;
use crate::room::contacts::state::{Contact, Place};
use crate::room::rigid::state::BodyFrame;
use crate::world::World;
use jounce_geometry::Aabb;
use jounce_math::{Vec3, scalar::f32s};

pub(crate) fn run(world: &mut World, step: &Step) {
    bounds(world, step);
    super::sensors::run(world);
    hits(world);
    world.step_count += 1;
    world.fields.time = world.time();
}

/// Moves the fat bounds of shapes that left theirs. What has not moved as far as it has room is not looked at.
fn bounds(world: &mut World, step: &Step) {
    let sweep = world.bouncy > 0;
    for row in 0..world.awake.step.len() {
        let slot = world.awake.step[row].body;
        let body = &world.bodies[slot];
        // Bouncing pairs must be seen a step ahead.
        let ahead =
            if sweep || body.looks_ahead() { world.awake.state[row].v() * step.dt } else { Vec3::ZERO };
        let room = world.awake.step[row].room - moved(&world.frames[slot as usize], body.mass.outer_radius);
        if room > ahead.length() {
            world.awake.step[row].room = room;
            continue;
        }
        let mut room = f32::INFINITY;
        for i in 0..world.bodies[slot].shapes.len() {
            let s = world.bodies[slot].shapes[i];
            let Place::MovingTree(leaf) = world.shapes[s].place else {
                if world.shapes[s].place == Place::Unbounded {
                    world.mark_moved(s);
                    room = 0.0;
                }
                continue;
            };
            let tight = world.tight_bounds(s);
            let next = tight.union(&Aabb::new(tight.min + ahead, tight.max + ahead));
            if !world.fat[s as usize].contains(&next) {
                let margin = margin_of(&next, world.settings.length_unit);
                let fat = next.expanded(margin);
                world.fat[s as usize] = fat;
                world.moving_tree.enlarge(leaf, fat);
                world.mark_moved(s);
            }
            // The radius is that of the solid shapes.
            let left = if world.shapes[s].sensor { 0.0 } else { slack(&world.fat[s as usize], &tight) };
            room = f32s::min(room, left);
        }
        world.awake.step[row].room = room;
    }
    world.moving_tree.tidy();
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
