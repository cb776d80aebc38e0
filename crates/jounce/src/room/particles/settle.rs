//! After the blocks: pushes and events in the order of emitters and births, then gaps closed.
//!
//! A hit on a dynamic body is settled by the bodies' velocities as the hits before it left them, with
//! 1/m_e = 1/m + 1/M + (I⁻¹(r × n) × r)·n, so a thousand grains in one step cannot push a body faster than they fly, and the
//! momentum that a particle loses is what the body gains.

use super::ball::Around;
use super::collide::{self, Hit, Obstacle, bounced, fly, onward};
use super::desc::HitResponse;
use super::prepare::Rules;
use super::solve::Scratch;
use super::state::{LANES, Particles};
use crate::command::Command;
use crate::event::Event;
use crate::handle::EmitterId;
use crate::limits;
use crate::room::rigid::state::{InvInertia, lock_bits};
use crate::world::World;
use jounce_math::{DVec3, Vec3};

/// Settles what an emitter's particles did to others, and counts them.
/// `told`: hits that were reported in this step so far.
pub(crate) fn emitter(
    world: &mut World,
    particles: &mut Particles,
    scratch: &Scratch,
    slot: u32,
    told: &mut usize,
) {
    let generation = particles.emitters[slot].generation;
    let id = EmitterId { index: slot, generation };
    let mut crowded = false;
    for k in 0..particles.emitters[slot].blocks.len() {
        let i = particles.emitters[slot].blocks[k] as usize;
        let Some(out) = scratch.outs.get(i) else { continue };
        particles.emitters[slot].lost += u64::from(out.lost);
        crowded |= out.crowded;
        let Some(Some(step)) = scratch.steps.get(slot as usize) else { continue };
        let Some(rules) = &step.rules else { continue };
        for h in &out.hits {
            let Some(o) = out.obstacles.get(h.obstacle as usize) else { continue };
            if h.told && *told < limits::PARTICLE_HIT_EVENTS_MAX {
                *told += 1;
                let point = step.origin + (h.way.from - h.normal * h.way.radius).as_dvec3();
                let shape = world.shape_id(o.slot);
                let (normal, speed) = (h.normal, h.speed);
                world.events.push(Event::ParticleHit { emitter: id, shape, point, normal, speed });
            }
            if h.push {
                let moved = push(world, h, o, &out.obstacles, rules, step.origin);
                if let (Some(l), Some((p, v))) = (h.lane, moved) {
                    particles.pool[i].put(usize::from(l), p, v);
                }
            }
        }
    }
    if crowded {
        world.events.push(Event::LimitReached { what: "shapes near particles" });
    }
}

/// Exchanges momentum, and gives the particle's place and velocity at the end of the step where it flies on.
fn push(
    world: &mut World,
    h: &Hit,
    o: &Obstacle,
    obstacles: &[Obstacle],
    rules: &Rules,
    origin: DVec3,
) -> Option<(Vec3, Vec3)> {
    let body = &world.bodies[o.body];
    let f = &world.frames[o.body as usize];
    let at = origin + (h.way.from - h.normal * h.way.radius).as_dvec3();
    let lever = (at - f.center).as_vec3();
    let (v, w) = world.velocities(body);
    let surface = v + w.cross(lever);
    let relative = h.way.u - surface;
    let bounces = rules.desc.response == HitResponse::Bounce;
    let speed = -h.normal.dot(relative);
    let pressed = -h.normal.dot(h.way.a);
    let rests = rules.desc.restitution * speed <= 0.5 * pressed * rules.dt;
    let stays = rests && speed <= 2.0 * pressed * rules.dt;
    // Nothing to give where the hits before this one have pushed the body away.
    let after = if bounces { bounced(relative, h.normal, stays, rests, rules) } else { Vec3::ZERO };
    let change = if speed > 0.0 { after - relative } else { Vec3::ZERO };
    let m = body.mass;
    let tensor = InvInertia::new(f.rotation, &m.inv_inertia, m.inv_mass, lock_bits(&body.locks));
    let per_mass = |n: Vec3| {
        let turn = tensor.mul(lever.cross(n)).cross(lever);
        1.0 / h.way.mass + m.inv_mass + turn.dot(n)
    };
    let impulse = match change.try_normalize() {
        Some((n, size)) => n * (size / per_mass(n)),
        None => Vec3::ZERO,
    };
    let id = world.body_id(o.body);
    let taken = world.apply(Command::AddImpulse(id, -impulse, Some(at))).is_ok();
    let u = h.way.u + if taken { impulse * (1.0 / h.way.mass) } else { change };
    if !bounces {
        return None;
    }
    let way = onward(h.way, u, h.normal, rests, rules.dt);
    let mut rules = *rules;
    (rules.desc.hit_events, rules.desc.push) = (false, false);
    let shape = |slot: u32| &world.shapes[slot].shape;
    match fly(way, None, &rules, obstacles, &shape, &mut Around::new(), &mut Vec::new()) {
        collide::End::Flies(p, v) => Some((p, v)),
        _ => Some((h.way.from, u)),
    }
}

/// Closes gaps: empty blocks go back to the pool, neighbours that are half empty become one. Removes what has ended.
pub(crate) fn tidy(particles: &mut Particles) {
    let Particles { emitters, pool, free, count, .. } = particles;
    *count = 0;
    for e in emitters.values_mut() {
        let mut kept = 0;
        e.count = 0;
        for k in 0..e.blocks.len() {
            let i = e.blocks[k] as usize;
            e.count += pool[i].count;
            if pool[i].count > 0 && kept > 0 {
                let before = e.blocks[kept - 1] as usize;
                // A part stays free, so that blocks are not merged one step and split the next.
                if pool[before].count + pool[i].count <= LANES * 3 / 4
                    && let Ok([a, b]) = pool.get_disjoint_mut([before, i])
                {
                    a.append(b);
                }
            }
            if pool[i].count == 0 {
                pool[i].emitter = super::state::FREE;
                free.push(i as u32);
            } else {
                e.blocks[kept] = i as u32;
                kept += 1;
            }
        }
        e.blocks.truncate(kept);
        *count += e.count;
    }
}
