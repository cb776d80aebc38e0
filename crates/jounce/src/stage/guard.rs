//! Quarantine: a body whose state is no longer finite, or out of the world, is put back to its last good pose and
//! disabled, before anything else can read it. Everything else goes on.

use super::{Step, substep};
use crate::event::Event;
use crate::limits::POSITION_MAX;
use crate::room::rigid::solve::SpeedLimits;
use crate::room::rigid::state::BodyStep;
use crate::world::World;
use jounce_math::Vec3;

/// Bodies per unit.
const BODIES: usize = 256;

pub(crate) fn run(world: &mut World, step: &Step) {
    let limits = substep::speed_limits(world, step);
    // Nearly all are well: all are looked at on all threads, and the others after that, in their order.
    let found = &mut world.scratch.found;
    found.begin(world.awake.step.len().div_ceil(BODIES), 0);
    let shared: &World = world;
    shared.tasks.for_each_piece(&shared.awake.step[..], BODIES, |first, steps| {
        for (i, b) in steps.iter().enumerate() {
            let row = first + i;
            if find(shared, row, b, &limits) != Finding::Well {
                shared.scratch.found.of(first / BODIES).push(row as u32);
            }
        }
    });
    let mut rows = core::mem::take(&mut world.scratch.ends);
    rows.clear();
    world.scratch.found.gather(&mut rows);
    let mut bad = core::mem::take(&mut world.scratch.fields.bad);
    for &row in &rows {
        let b = &world.awake.step[row as usize];
        match find(world, row as usize, b, &limits) {
            Finding::Well => {}
            Finding::Lost => bad.push(b.body),
            Finding::Limited => world.events.push(Event::SpeedLimited { body: world.body_id(b.body) }),
        }
    }
    world.scratch.ends = rows;
    bad.sort_unstable();
    bad.dedup();
    for &slot in &bad {
        quarantine(world, slot);
    }
    bad.clear();
    world.scratch.fields.bad = bad;
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Finding {
    Well,
    /// Not finite, or out of the world.
    Lost,
    /// As fast as it may be.
    Limited,
}

fn find(world: &World, row: usize, b: &BodyStep, limits: &SpeedLimits) -> Finding {
    let s = &world.awake.state[row];
    let f = &world.frames[b.body as usize];
    // A clamped speed is the limit up to rounding.
    let at = |v: Vec3, limit: f32| v.length_squared() >= 0.9999 * limit * limit;
    let inside = f.center.abs().max_component() <= POSITION_MAX;
    if !(inside && f.center.is_finite() && f.rotation.is_finite() && s.v().is_finite() && s.w().is_finite()) {
        Finding::Lost
    } else if b.guided {
        // A kinematic body arrives where `move_to` sent it, however far that is.
        Finding::Well
    } else if at(s.v(), limits.speed)
        || !b.fast_rotation && at(s.w(), limits.spin_of(b, &world.bodies[b.body]))
    {
        Finding::Limited
    } else {
        Finding::Well
    }
}

pub(crate) fn quarantine(world: &mut World, slot: u32) {
    let f = &mut world.frames[slot as usize];
    (f.center, f.rotation) = (f.center0, f.rotation0);
    let row = world.bodies[slot].row as usize;
    world.awake.state[row].set_velocity(Vec3::ZERO, Vec3::ZERO);
    for i in 0..world.bodies[slot].contacts.len() {
        forget_impulses(world, world.bodies[slot].contacts[i]);
    }
    for j in world.bodies[slot].joints.clone() {
        world.joints.table[j].forget();
    }
    let vehicle = world.bodies[slot].vehicle;
    if let Some(v) = world.vehicles.table.get_mut(vehicle) {
        v.forget();
    }
    world.enable_body(slot, false);
    world.events.push(Event::Quarantine { body: world.body_id(slot) });
}

/// What a poisoned body pushed its neighbours with must not start their next step.
fn forget_impulses(world: &mut World, id: u32) {
    if let crate::room::contacts::state::ContactPlace::Awake(row) = world.places[id as usize] {
        world.contacts[row as usize].manifold = Default::default();
        world.contacts[row as usize].rest.clear();
    }
}
