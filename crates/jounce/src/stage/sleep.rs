//! Puts islands at rest to sleep.
//!
//! An island is a set of dynamic bodies joined by touching contacts. It sleeps when every one of its bodies has
//! rested for `Settings::sleep_time_s`, and none touches a moving kinematic body or a moving surface. Found by a walk from each body that
//! has rested long enough over those it hangs together with, which ends at the first that has not, or that hangs together with one; so it
//! needs no memory between steps, and looks at little where most is awake.

use super::Step;
use crate::room::contacts::state::ContactPlace;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_math::Vec3;

/// What is known of an awake row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rest {
    /// Has not rested, or hangs together with one that has not.
    Stirs,
    /// Has rested; nothing is known of those it hangs together with.
    Rests,
    /// Of the island that the walk is at, or of one that falls asleep.
    Seen,
    /// Joins nothing.
    Kinematic,
}

pub(crate) fn run(world: &mut World, _: &Step) {
    let needed = world.settings.sleep_time_s;
    if !world.settings.sleep || !world.awake.step.iter().any(|b| b.sleep_timer >= needed) {
        return;
    }
    keep_awake(world);
    let mut rest = core::mem::take(&mut world.scratch.rest);
    let mut island = core::mem::take(&mut world.scratch.island);
    let mut resting = core::mem::take(&mut world.scratch.resting);
    let mut wheels = core::mem::take(&mut world.scratch.wheels);
    rest.clear();
    resting.clear();
    rest.extend(world.awake.step.iter().map(|b| match b.kind {
        BodyKind::Dynamic if b.sleep_timer >= needed => Rest::Rests,
        BodyKind::Dynamic => Rest::Stirs,
        _ => Rest::Kinematic,
    }));
    stands_on(world, &mut wheels);
    for (first, b) in world.awake.step.iter().enumerate() {
        let first = first as u32;
        let known = rest[first as usize];
        if known == Rest::Kinematic && b.sleep_timer >= needed {
            resting.push((first, first, b.body));
        } else if known == Rest::Rests && walk(world, &wheels, first, &mut rest, &mut island) {
            resting.extend(island.iter().map(|&r| (first, r, world.awake.step[r as usize].body)));
        }
    }
    resting.sort_unstable();
    for island in resting.chunk_by(|a, b| a.0 == b.0) {
        let mut bodies = world.scratch.lists.pop().unwrap_or_default();
        bodies.extend(island.iter().map(|&(_, _, body)| body));
        world.sleep_bodies(bodies);
    }
    let scratch = &mut world.scratch;
    (scratch.rest, scratch.island, scratch.resting, scratch.wheels) = (rest, island, resting, wheels);
}

/// Collects the island of a body at rest; false where some of it stirs.
fn walk(world: &World, wheels: &[(u32, u32)], first: u32, rest: &mut [Rest], island: &mut Vec<u32>) -> bool {
    island.clear();
    island.push(first);
    rest[first as usize] = Rest::Seen;
    let mut next = 0;
    let asleep = loop {
        let Some(&row) = island.get(next) else { break true };
        next += 1;
        let slot = world.awake.step[row as usize].body;
        // True where the body stirs.
        let mut meet = |other: u32| {
            let other = world.frames[other as usize].row;
            match rest.get_mut(other as usize) {
                Some(Rest::Stirs) => return true,
                Some(r @ Rest::Rests) => {
                    *r = Rest::Seen;
                    island.push(other);
                }
                _ => {}
            }
            false
        };
        let body = &world.bodies[slot];
        let on = wheels.partition_point(|w| w.0 < slot);
        let stirs = body.contacts.iter().any(|&id| {
            let h = world.places[id as usize].head(&world.heads);
            h.is_some_and(|h| h.touching && meet(h.other(slot)))
        }) || body.joints.iter().any(|&id| {
            let j = &world.joints.table[id];
            j.acts() && meet(if j.body_a == slot { j.body_b } else { j.body_a })
        }) || wheels[on..].iter().take_while(|w| w.0 == slot).any(|w| meet(w.1));
        if stirs {
            break false;
        }
    };
    if !asleep {
        island.iter().for_each(|&r| rest[r as usize] = Rest::Stirs);
    }
    asleep
}

/// Vehicles and what is under their wheels, both ways, in order.
fn stands_on(world: &World, wheels: &mut Vec<(u32, u32)>) {
    wheels.clear();
    for (_, v) in world.vehicles.table.iter().filter(|(_, v)| v.enabled) {
        for w in v.feet().filter(|w| w.ground != NONE) {
            wheels.extend([(v.chassis, w.ground), (w.ground, v.chassis)]);
        }
    }
    wheels.sort_unstable();
}

/// Bodies on a moving surface, or touched by a moving kinematic body, are not at rest.
fn keep_awake(world: &mut World) {
    if world.running > 0 {
        for row in 0..world.contacts.len() {
            let c = &world.contacts[row];
            if c.touching && c.manifolds().any(|m| m.surface.velocity != Vec3::ZERO) {
                stir(world, row);
            }
        }
    }
    for row in 0..world.awake.step.len() {
        let (s, b) = (&world.awake.state[row], &world.awake.step[row]);
        if b.kind != BodyKind::Kinematic || (s.v() == Vec3::ZERO && s.w() == Vec3::ZERO) {
            continue;
        }
        let body = b.body;
        for i in 0..world.bodies[body].contacts.len() {
            let id = world.bodies[body].contacts[i];
            if let ContactPlace::Awake(row) = world.places[id as usize]
                && world.heads[row as usize].touching
            {
                stir(world, row as usize);
            }
        }
    }
}

/// The two bodies of a contact are not at rest.
fn stir(world: &mut World, contact: usize) {
    let c = &world.contacts[contact];
    for body in [c.body_a, c.body_b] {
        let row = world.frames[body as usize].row;
        if let Some(b) = world.awake.step.get_mut(row as usize) {
            b.sleep_timer = 0.0;
        }
    }
}
