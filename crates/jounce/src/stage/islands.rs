//! Commits the narrow phase, serially and in row order: begin and end of touch, and who wakes whom.
//!
//! Only contacts are looked at of which the narrow phase had news, and those by which a body that moves may wake what sleeps on it.

use super::{Step, narrowphase};
use crate::event::Event;
use crate::room::contacts::state::ContactPlace;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_math::Vec3;

pub(crate) fn run(world: &mut World, step: &Step) {
    let size = narrowphase::unit_of(world.contacts.len());
    let units = world.contacts.len().div_ceil(size);
    super::joints::stir(world);
    let mut rows = core::mem::take(&mut world.scratch.rows_told);
    rows.clear();
    world.scratch.news.told(units, |unit, i| rows.push((unit * size + i) as u32));
    carried(world, &mut rows);
    let mut ends = core::mem::take(&mut world.scratch.ends);
    ends.clear();
    let mut wakes = core::mem::take(&mut world.scratch.wakes);
    wakes.clear();
    for &row in &rows {
        let row = row as usize;
        let c = &mut world.contacts[row];
        if c.apart {
            ends.push(c.id);
            continue;
        }
        if c.now_touching == c.touching {
            let sides = [c.body_a, c.body_b];
            wakes.extend(sides.into_iter().filter(|&x| asleep(world, x)));
            continue;
        }
        c.touching = c.now_touching;
        c.hit_speed = 0.0;
        world.heads[row].touching = c.touching;
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
    world.unlink_contacts(&ends);
    world.scratch.ends = ends;
    for &body in &wakes {
        world.wake_body(body);
    }
    (world.scratch.wakes, world.scratch.rows_told) = (wakes, rows);
    super::vehicles::look(world, step);
}

/// Adds the contacts of bodies that sleep on kinematic ones that move, and keeps the rows in order.
fn carried(world: &World, rows: &mut Vec<u32>) {
    if world.islands.len() == 0 {
        return;
    }
    let told = rows.len();
    for (s, b) in world.awake.state.iter().zip(&world.awake.step) {
        if b.kind != BodyKind::Kinematic || (s.v() == Vec3::ZERO && s.w() == Vec3::ZERO) {
            continue;
        }
        for &id in &world.bodies[b.body].contacts {
            let ContactPlace::Awake(row) = world.places[id as usize] else { continue };
            let c = &world.contacts[row as usize];
            let still = c.touching && c.now_touching && !c.apart;
            if still && asleep(world, if c.body_a == b.body { c.body_b } else { c.body_a }) {
                rows.push(row);
            }
        }
    }
    if rows.len() > told {
        rows.sort_unstable();
    }
}

fn asleep(world: &World, body: u32) -> bool {
    let b = &world.bodies[body];
    b.kind == BodyKind::Dynamic && b.island != NONE
}
