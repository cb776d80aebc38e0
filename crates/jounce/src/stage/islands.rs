//! Commits the narrow phase, serially and in row order: begin and end of touch, and who wakes whom.

use super::Step;
use crate::event::Event;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_math::Vec3;

pub(crate) fn run(world: &mut World, step: &Step) {
    super::joints::stir(world);
    let mut ends = core::mem::take(&mut world.scratch.ends);
    ends.clear();
    let mut wakes = core::mem::take(&mut world.scratch.wakes);
    wakes.clear();
    for row in 0..world.contacts.len() {
        let c = &mut world.contacts[row];
        if c.apart {
            ends.push(c.id);
            continue;
        }
        if c.now_touching == c.touching {
            if c.touching {
                let c = &world.contacts[row];
                wakes.extend(
                    carried(world, c.body_a, c.body_b).or_else(|| carried(world, c.body_b, c.body_a)),
                );
            }
            continue;
        }
        c.touching = c.now_touching;
        let (a, b, sa, sb) = (c.body_a, c.body_b, c.shape_a, c.shape_b);
        if !c.touching {
            world.report_end(sa, sb);
            continue;
        }
        if world.shapes[sa].contact_events && world.shapes[sb].contact_events {
            let (a, b) = (world.shape_id(sa), world.shape_id(sb));
            world.events.push(Event::ContactBegin { a, b });
        }
        wakes.extend([a, b].into_iter().filter(|&x| asleep(world, x)));
    }
    ends.sort_unstable();
    for &id in &ends {
        world.unlink_contact(id);
    }
    world.scratch.ends = ends;
    for &body in &wakes {
        world.wake_body(body);
    }
    world.scratch.wakes = wakes;
    super::vehicles::look(world, step);
}

/// A body that sleeps on a kinematic one that moves.
fn carried(world: &World, sleeper: u32, carrier: u32) -> Option<u32> {
    let row = world.frames[carrier as usize].row;
    if row == NONE || world.awake.step[row as usize].kind != BodyKind::Kinematic || !asleep(world, sleeper) {
        return None;
    }
    let s = &world.awake.state[row as usize];
    (s.v() != Vec3::ZERO || s.w() != Vec3::ZERO).then_some(sleeper)
}

fn asleep(world: &World, body: u32) -> bool {
    let b = &world.bodies[body];
    b.kind == BodyKind::Dynamic && b.island != NONE
}
