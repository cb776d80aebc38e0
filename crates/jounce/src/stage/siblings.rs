//! Joined bodies that turn far within the step, and together, do not look ahead to one another: a gap is foreseen along straight lines, and
//! blades of one rotor, which never meet, would brake it. What overlaps is pushed apart as ever.

use super::Step;
use crate::room::rigid::state::{BodyState, NONE};
use crate::world::World;
use jounce_math::{Vec3, scalar::f32s};

/// Turn within a step from which that is so, rad.
const TURN: f32 = 0.1;
/// Together: they turn against one another by no more than this part of it.
const TOGETHER: f32 = 0.5;

/// Once contacts have their rows.
pub(crate) fn part(world: &mut World, step: &Step) {
    if world.scratch.rows.is_empty() {
        return;
    }
    let mut owners = core::mem::take(&mut world.scratch.siblings);
    mark(world, step, &mut owners);
    if !owners.is_empty() {
        blind(world, step, &owners);
    }
    world.scratch.siblings = owners;
}

/// The set of each awake row, of sets in which something turns far; nothing where none does.
fn mark(world: &World, step: &Step, owners: &mut Vec<u32>) {
    let rows = world.awake.state.len();
    let spins = |row: u32| spin(world, row).length() > TURN / step.dt;
    owners.clear();
    for (i, set) in world.scratch.joints.sets.iter().enumerate() {
        let of_set = || set.bodies.iter().map(|b| world.row_of[b.slot as usize]).filter(|r| *r != NONE);
        if of_set().any(spins) {
            owners.resize(rows, NONE);
            of_set().for_each(|r| owners[r as usize] = i as u32);
        }
    }
}

fn spin(world: &World, row: u32) -> Vec3 {
    world.awake.state.get(row as usize).map_or(Vec3::ZERO, BodyState::w)
}

/// Takes the points that are apart from pairs of one set.
fn blind(world: &mut World, step: &Step, owners: &[u32]) {
    let mut blocks = core::mem::take(&mut world.scratch.blocks);
    let places = &world.scratch.places;
    for (at, h) in world.heads.iter().enumerate().filter(|(_, h)| h.touching) {
        let rows = h.bodies.map(|b| world.row_of[b as usize]);
        let [a, b] = rows.map(|r| owners.get(r as usize));
        if a.is_none_or(|&a| a == NONE) || a != b {
            continue;
        }
        let [a, b] = rows.map(|r| spin(world, r));
        let least = f32s::min(a.length(), b.length());
        if least < TURN / step.dt || (a - b).length() > TOGETHER * least {
            continue;
        }
        for place in (0..world.contacts[at].manifold_count()).filter_map(|k| places.get(at, k)) {
            let (block, lane) = place.lane();
            for p in &mut blocks[usize::from(place.color)][block].points {
                if p.separation[lane] > 0.0 {
                    (p.mass[lane], p.impulse[lane]) = (0.0, 0.0);
                }
            }
        }
    }
    world.scratch.blocks = blocks;
}
