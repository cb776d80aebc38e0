//! Ends a step: bounds of what moved, sensors, hits; the clock.

use super::Step;
use crate::edit::margin_of;
use crate::event::Event;
use crate::room::contacts::state::{Contact, Place};
use crate::world::World;
use jounce_geometry::Aabb;

pub(crate) fn run(world: &mut World, step: &Step) {
    bounds(world, step);
    super::sensors::run(world);
    hits(world);
    world.step_count += 1;
    world.fields.time = world.time();
}

/// Moves the fat bounds of shapes that left theirs.
fn bounds(world: &mut World, step: &Step) {
    let sweep = world.bouncy > 0;
    for row in 0..world.awake.step.len() {
        let body = world.awake.step[row].body;
        let motion = if sweep || world.bodies[body].looks_ahead() {
            world.awake.state[row].v() * step.dt
        } else {
            jounce_math::Vec3::ZERO
        };
        for i in 0..world.bodies[body].shapes.len() {
            let s = world.bodies[body].shapes[i];
            let Place::MovingTree(leaf) = world.shapes[s].place else {
                if world.shapes[s].place == Place::Unbounded {
                    world.mark_moved(s);
                }
                continue;
            };
            let mut tight = world.tight_bounds(s);
            // Bouncing pairs must be seen a step ahead.
            let ahead = Aabb::new(tight.min + motion, tight.max + motion);
            tight = tight.union(&ahead);
            if !world.fat[s as usize].contains(&tight) {
                let fat = tight.expanded(margin_of(&tight, world.settings.length_unit));
                world.fat[s as usize] = fat;
                world.moving_tree.enlarge(leaf, fat);
                world.mark_moved(s);
            }
        }
    }
    world.moving_tree.tidy();
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
