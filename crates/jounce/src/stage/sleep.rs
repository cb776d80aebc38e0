//! Puts islands at rest to sleep.
//!
//! An island is a set of dynamic bodies joined by touching contacts. It sleeps when every one of its bodies has
//! rested for `Settings::sleep_time_s`, and none touches a moving kinematic body or a moving surface. Found by
//! union–find over the awake contacts, only in steps in which some body has rested long enough; so it needs no
//! memory between steps.

use super::Step;
use crate::groups::{root, unite};
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_math::{Vec3, scalar::f32s};

pub(crate) fn run(world: &mut World, _: &Step) {
    let needed = world.settings.sleep_time_s;
    if !world.settings.sleep || !world.awake.step.iter().any(|b| b.sleep_timer >= needed) {
        return;
    }
    keep_awake(world);
    let n = world.awake.step.len();
    let mut parent = core::mem::take(&mut world.scratch.parent);
    parent.clear();
    parent.extend(0..n as u32);
    for c in world.contacts.iter().filter(|c| c.touching) {
        let (a, b) = (dynamic_row(world, c.body_a), dynamic_row(world, c.body_b));
        if a != NONE && b != NONE {
            unite(&mut parent, a, b);
        }
    }
    let awake = world.awake.step.iter().flat_map(|b| &world.bodies[b.body].joints);
    for j in awake.map(|&id| &world.joints.table[id]).filter(|j| j.acts()) {
        let (a, b) = (dynamic_row(world, j.body_a), dynamic_row(world, j.body_b));
        if a != NONE && b != NONE {
            unite(&mut parent, a, b);
        }
    }
    for (_, v) in world.vehicles.table.iter().filter(|(_, v)| v.enabled) {
        let a = dynamic_row(world, v.chassis);
        for w in v.feet().filter(|w| w.ground != NONE) {
            let b = dynamic_row(world, w.ground);
            if a != NONE && b != NONE {
                unite(&mut parent, a, b);
            }
        }
    }
    let mut rest = core::mem::take(&mut world.scratch.rest);
    rest.clear();
    rest.resize(n, f32::MAX);
    for i in 0..n {
        let r = root(&mut parent, i as u32) as usize;
        rest[r] = f32s::min(rest[r], world.awake.step[i].sleep_timer);
    }
    let mut resting = core::mem::take(&mut world.scratch.resting);
    resting.clear();
    for i in 0..n {
        let r = root(&mut parent, i as u32);
        if rest[r as usize] >= needed {
            resting.push((r, i as u32, world.awake.step[i].body));
        }
    }
    resting.sort_unstable();
    for island in resting.chunk_by(|a, b| a.0 == b.0) {
        let mut bodies = world.scratch.lists.pop().unwrap_or_default();
        bodies.extend(island.iter().map(|&(_, _, body)| body));
        world.sleep_bodies(bodies);
    }
    (world.scratch.parent, world.scratch.rest, world.scratch.resting) = (parent, rest, resting);
}

fn dynamic_row(world: &World, body: u32) -> u32 {
    let row = world.frames[body as usize].row;
    if row != NONE && world.awake.step[row as usize].kind == BodyKind::Dynamic { row } else { NONE }
}

/// Bodies on a moving surface, or touched by a moving kinematic body, are not at rest.
fn keep_awake(world: &mut World) {
    for c in &world.contacts {
        if !c.touching {
            continue;
        }
        let rows = [c.body_a, c.body_b].map(|b| world.frames[b as usize].row);
        let carried = c.manifolds().any(|m| m.surface.velocity != Vec3::ZERO);
        let pushed = rows.iter().any(|&r| {
            r != NONE && {
                let (s, b) = (&world.awake.state[r as usize], &world.awake.step[r as usize]);
                b.kind == BodyKind::Kinematic && (s.v() != Vec3::ZERO || s.w() != Vec3::ZERO)
            }
        });
        if carried || pushed {
            for r in rows.into_iter().filter(|&r| r != NONE) {
                world.awake.step[r as usize].sleep_timer = 0.0;
            }
        }
    }
}
