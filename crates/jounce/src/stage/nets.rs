//! Nets of joints that are solved row by row in lanes, by type and colour (see [`crate::room::joints::net`]).

use super::Step;
use super::joints::JointScratch;
use crate::room::contacts::rows::LANES;
use crate::room::joints::hinge;
use crate::room::joints::net::point::{self, Source};
use crate::room::joints::net::solve::{self, Constants, Pass, Sweep};
use crate::room::joints::net::{Rows, Type};
use crate::room::joints::rows::{Ends, Start};
use crate::room::joints::set::{self, JointSet, TORN};
use crate::room::rigid::state::{BodyState, InvInertia};
use crate::table::Entry;
use crate::world::World;
use jounce_lanes::Width;
use jounce_tasks::{ColorSets, Owning};

/// Joints per unit.
const JOINTS: usize = 128;

/// Is the set solved row by row, and all its joints of kinds that the kernels know?
pub(super) fn knows(world: &World, set: &JointSet, h: f32) -> bool {
    let known = |id: u32| Type::of(&world.joints.table[id].desc, h).is_some();
    set.plan.is_none() && set.gears.is_empty() && set.joints.iter().all(|s| known(s.id))
}

/// Do all its bodies move along and turn about every axis?
pub(super) fn is_unlocked(world: &World, set: &JointSet) -> bool {
    let row = |slot: u32| world.frames[slot as usize].row as usize;
    set.bodies.iter().all(|b| world.awake.step.get(row(b.slot)).is_none_or(|b| b.locks == 0))
}

/// Once per step: colours where anything changed, and blocks; what does not change within a joint only if `changed`. `still`: so are the awake
/// bodies as they were.
pub(super) fn prepare(world: &World, s: &mut JointScratch, step: &Step, changed: bool, still: bool) {
    let awake = &world.awake;
    // What is only read does not give way.
    let inertia = |item: u32| awake.inertia.get(item as usize).unwrap_or(&InvInertia::FIXED);
    let of = |id: u32| {
        let j = &world.joints.table[id];
        let bodies = [j.body_a, j.body_b];
        (bodies, bodies.map(|b| world.items[b as usize]))
    };
    let moved = (changed || !still) && s.points.arrange(awake.state.len(), of);
    let sets = &s.sets;
    let Rows { ids, sets: set_of, bodies, items, colors, blocks, .. } = &mut s.points;
    for (color, blocks) in blocks.iter_mut().enumerate() {
        let list = colors.rows(color);
        world.tasks.for_each(blocks, 4, |i, block| {
            let mut sources = [Source::NONE; LANES];
            for (l, (row, source)) in list[i * LANES..].iter().zip(&mut sources).enumerate() {
                let joint = row.payload() as usize;
                let [a, b] = bodies[joint].map(|slot| &world.frames[slot as usize]);
                if changed || moved {
                    block.describe(l, &world.joints.table[ids[joint]], [a.local_center, b.local_center]);
                }
                *source = Source::new(a, b, items[joint].map(inertia), sets[set_of[joint] as usize].pushed);
            }
            block.begin(world.width, &sources);
        });
    }
    for (rows, kind) in s.nets.iter_mut().zip(Type::ALL) {
        let moved = (changed || !still) && rows.arrange(awake.state.len(), of);
        let Rows { ids, items, colors, blocks, .. } = rows;
        for (color, blocks) in blocks.iter_mut().enumerate() {
            let list = colors.rows(color);
            world.tasks.for_each(blocks, 4, |i, block| {
                let joints = list[i * LANES..].iter().take(LANES).map(|row| row.payload() as usize);
                if changed || moved {
                    (block.any_ends, block.any_pull, block.any_drive) = (false, false, false);
                    for (l, joint) in joints.clone().enumerate() {
                        block.describe(l, kind, &world.joints.table[ids[joint]].desc, step.constants.h);
                    }
                }
                for (l, joint) in joints.enumerate() {
                    let j = &world.joints.table[ids[joint]];
                    let sides = items[joint].map(|i| (inertia(i).inv_mass, *inertia(i)));
                    block.begin(l, kind, j, &world.start(j), sides);
                }
            });
        }
    }
}

fn constants(world: &World, step: &Step) -> Constants {
    let set::Constants { h, warm, soft, push_out, correct, speed_max, spin_max } =
        super::joints::constants(world, step);
    Constants { h, warm, soft, push_out, correct: correct * h, torn: TORN * correct, speed_max, spin_max }
}

/// One pass over all types and colours.
fn sweep(world: &mut World, step: &Step, pass: Pass) {
    let k = constants(world, step);
    let width = world.width;
    let states = &mut world.awake.state;
    let JointScratch { points, nets, .. } = &mut world.scratch.joints;
    for (color, blocks) in points.blocks.iter_mut().enumerate().take(ColorSets::COLORS) {
        if points.ids.is_empty() || blocks.is_empty() {
            continue;
        }
        points.colors.scatter(
            color,
            &world.tasks,
            LANES,
            states,
            BodyState::FIXED,
            blocks,
            |access, rows, block| {
                if pass != Pass::Answer || block.any_answers {
                    point::run(width, point::Sweep { pass, access, rows, block, lane: 0, constants: &k });
                }
            },
        );
    }
    if let Some(overflow) = points.blocks.get_mut(ColorSets::COLORS).filter(|_| !points.ids.is_empty()) {
        points.colors.scatter_overflow(LANES, states, BodyState::FIXED, overflow, |access, row, block| {
            let (lane, rows) = (row % LANES, row..row + 1);
            point::run(Width::X1, point::Sweep { pass, access, rows, block, lane, constants: &k });
        });
    }
    for (rows, kind) in nets.iter_mut().zip(Type::ALL) {
        if rows.ids.is_empty() {
            continue;
        }
        let colors = &rows.colors;
        for (color, blocks) in rows.blocks.iter_mut().enumerate().take(ColorSets::COLORS) {
            if blocks.is_empty() {
                continue;
            }
            colors.scatter(
                color,
                &world.tasks,
                LANES,
                states,
                BodyState::FIXED,
                blocks,
                |access, rows, block| {
                    solve::run(width, Sweep { pass, kind, access, rows, block, lane: 0, constants: &k });
                },
            );
        }
        let overflow = &mut rows.blocks[ColorSets::COLORS];
        colors.scatter_overflow(LANES, states, BodyState::FIXED, overflow, |access, row, block| {
            let lane = row % LANES;
            solve::run(
                Width::X1,
                Sweep { pass, kind, access, rows: row..row + 1, block, lane, constants: &k },
            );
        });
    }
}

/// Before the positions move.
pub(super) fn solve(world: &mut World, step: &Step) {
    sweep(world, step, Pass::Warm);
    sweep(world, step, Pass::Solve);
}

/// The same after contacts.
pub(super) fn answer(world: &mut World, step: &Step) {
    sweep(world, step, Pass::Answer);
}

/// After they moved.
pub(super) fn relax(world: &mut World, step: &Step, last: bool) {
    sweep(world, step, if last { Pass::Last } else { Pass::Relax });
}

/// Impulses back to the records, and what broke: joint, force, torque.
pub(super) fn finish(world: &mut World, s: &mut JointScratch, step: &Step) {
    let (states, frames, dt) = (&world.awake.state, &world.frames, step.dt);
    let table = &mut world.joints.table;
    let Rows { ids, places, owners, blocks, .. } = &s.points;
    let columns = (&ids[..], &places[..], Owning(table.entries_mut(), owners));
    world.tasks.for_each_piece(columns, JOINTS, |first, (ids, places, mut table)| {
        for (i, (&id, &(color, row))) in ids.iter().zip(places).enumerate() {
            let block = blocks[usize::from(color)].get(row as usize / LANES);
            if let (Some(block), Some(j)) =
                (block, table.get(first + i, id as usize).and_then(Entry::get_mut))
            {
                block.store(row as usize, j, dt);
            }
        }
    });
    for (rows, kind) in s.nets.iter().zip(Type::ALL) {
        let Rows { ids, places, owners, blocks, .. } = rows;
        world.scratch.found.begin(ids.len().div_ceil(JOINTS), 0);
        let found = &world.scratch.found;
        let columns = (&ids[..], &places[..], Owning(table.entries_mut(), owners));
        world.tasks.for_each_piece(columns, JOINTS, |first, (ids, places, mut table)| {
            for (i, (&id, &(color, row))) in ids.iter().zip(places).enumerate() {
                let block = blocks[usize::from(color)].get(row as usize / LANES);
                let joint = table.get(first + i, id as usize).and_then(Entry::get_mut);
                let (Some(block), Some(j)) = (block, joint) else { continue };
                if block.store(row as usize, j, dt) {
                    found.of(first / JOINTS).push(id);
                }
                if kind == Type::Hinge {
                    let state = |slot: u32| {
                        states.get(frames[slot as usize].row as usize).unwrap_or(&BodyState::FIXED).get()
                    };
                    let (fa, fb) = (&frames[j.body_a as usize], &frames[j.body_b as usize]);
                    let e = Ends::now(&Start::new(j, fa, fb), &state(j.body_a), &state(j.body_b));
                    j.coordinate = hinge::angle(e.twist(), j.coordinate).c;
                }
            }
        });
        let mut broke = Vec::new();
        world.scratch.found.gather(&mut broke);
        s.broke.extend(broke.iter().map(|&id| (id, table[id].force.length(), table[id].torque.length())));
    }
}
