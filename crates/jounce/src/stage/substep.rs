//! The substeps: velocities, warm start, solve, positions, relax; then restitution and the impulses' way back.

use super::{Step, articulated};
use crate::event::Event;
use crate::room::contacts::rows::LANES;
use crate::room::contacts::solve::{Pass, Sweep};
use crate::room::contacts::{finish, impact};
use crate::room::rigid::finish as rigid;
use crate::room::rigid::solve::{SpeedLimits, Substep, integrate_position, integrate_velocity};
use crate::room::rigid::state::{BodyState, NONE};
use crate::world::World;
use jounce_lanes::{Width, dispatch};
use jounce_math::scalar::f32s;
use jounce_tasks::ColorSets;

/// Bodies per unit.
const BODIES: usize = 256;
/// Contacts per unit.
const CONTACTS: usize = 128;
/// Blocks of rows per unit.
const BLOCKS: usize = 4;

pub(crate) fn run(world: &mut World, step: &Step) {
    impacts(world, step);
    super::siblings::part(world, step);
    articulated::prepare(world);
    for i in 0..step.substeps {
        velocities(world, step);
        super::fields::act(world, step, i);
        articulated::renew(world, step);
        if i == 0 {
            push_rows(world, step);
        } else {
            push_again(world);
        }
        super::joints::solve(world, step, i);
        super::vehicles::act(world, step);
        articulated::solve(world, step);
        counted(world, Pass::Solve, step);
        super::joints::answer(world, step);
        super::vehicles::go(world);
        positions(world, step);
        super::joints::relax(world, step, i + 1 == step.substeps);
        articulated::relax(world, step);
        counted(world, Pass::Relax, step);
        super::vehicles::follow(world, step);
    }
}

/// Restitution, impulses back to the manifolds, motion back to the frames.
pub(crate) fn finish(world: &mut World, step: &Step) {
    super::restitution::run(world, step);
    collect(world);
    let stick_speed = world.settings.stick_speed;
    let mut contacts = core::mem::take(&mut world.contacts);
    let (blocks, heads) = (&world.scratch.blocks, &world.heads);
    world.tasks.for_each(&mut contacts, CONTACTS, |i, c| {
        if !heads.get(i).is_some_and(|h| h.touching) {
            return;
        }
        c.hit_speed = 0.0;
        if c.manifold.row == NONE {
            return;
        }
        let mut fastest = 0.0;
        for m in c.manifolds_mut() {
            let (block, lane) = (m.row as usize / LANES, m.row as usize % LANES);
            let outcome = &blocks[usize::from(m.color)][block].results[lane];
            fastest = f32s::max(fastest, finish::store(m, outcome, stick_speed));
        }
        c.hit_speed = fastest;
    });
    world.contacts = contacts;
    super::joints::finish(world, step);
    poses(world, step);
    super::vehicles::finish(world, step);
}

/// What the rows gave, row by row.
fn collect(world: &mut World) {
    let (scratch, width) = (&mut world.scratch, world.width);
    let states = &world.awake.state;
    for (color, blocks) in scratch.blocks.iter_mut().enumerate() {
        let rows = scratch.colors.rows(color);
        world.tasks.for_each(blocks, BLOCKS, |unit, block| {
            let mut bodies = [[&BodyState::FIXED; LANES]; 2];
            for (l, row) in rows[unit * LANES..].iter().enumerate().take(LANES) {
                for (side, item) in bodies.iter_mut().zip([row.a(), row.b()]) {
                    if let Some(i) = ColorSets::index(item) {
                        side[l] = &states[i];
                    }
                }
            }
            dispatch(width, finish::Collect { block, states: &bodies });
        });
    }
}

fn poses(world: &mut World, step: &Step) {
    let limits = speed_limits(world, step);
    let (a, bodies) = (&mut world.awake, &world.bodies);
    if world.tasks.is_serial() {
        for (((s, b), i), t) in a.state.iter_mut().zip(&mut a.step).zip(&mut a.inertia).zip(&mut a.turning) {
            let frame = &mut world.frames[b.body as usize];
            rigid::finish(s, b, t, i, frame, &bodies[b.body], step.dt, &limits);
        }
        return;
    }
    // Frames lie by slot: units make copies by row, which then go to their places.
    let (frames, ends) = (&world.frames, &mut world.scratch.ends_of_step);
    ends.clear();
    ends.extend(a.step.iter().map(|b| frames[b.body as usize]));
    let columns = (&mut a.state[..], &mut a.step[..], &mut a.inertia[..], &mut a.turning[..], &mut ends[..]);
    world.tasks.for_each5(columns, BODIES, |_, s, b, i, t, frame| {
        rigid::finish(s, b, t, i, frame, &bodies[b.body], step.dt, &limits);
    });
    for (b, end) in a.step.iter().zip(ends) {
        world.frames[b.body as usize] = *end;
    }
}

pub(super) fn speed_limits(world: &World, step: &Step) -> SpeedLimits {
    let s = &world.settings;
    let turn = s.rotation_per_step_max;
    SpeedLimits {
        speed: s.linear_speed_max * s.length_unit,
        spin: turn / step.dt,
        spin_jointed: turn / step.constants.h,
    }
}

fn impacts(world: &mut World, step: &Step) {
    let threshold = step.constants.restitution_speed;
    if world.bouncy == 0 && world.hooks.contact.is_none() {
        return;
    }
    if !impact::resolve(
        &world.contacts,
        &world.frames,
        &mut world.awake,
        threshold,
        step.dt,
        &mut world.scratch.impacts,
    ) {
        world.events.push(Event::LimitReached { what: "rounds of simultaneous impacts" });
    }
}

fn velocities(world: &mut World, step: &Step) {
    let (steps, inertia) = (&world.awake.step, &world.awake.inertia);
    world.tasks.for_each(&mut world.awake.state, BODIES, |i, s| {
        integrate_velocity(s, &steps[i], &inertia[i], step.constants.h);
    });
}

fn positions(world: &mut World, step: &Step) {
    let sub = Substep { h: step.constants.h, limits: speed_limits(world, step) };
    let (bodies, frames) = (&world.bodies, &world.frames);
    let a = &mut world.awake;
    let steps = &a.step;
    world.tasks.for_each2((&mut a.state, &mut a.turning), BODIES, |i, s, turning| {
        integrate_position(s, &steps[i], turning, bodies, frames, &sub);
    });
}

/// The impulses of the last step, row by row.
///
/// Levers and inertia stay as they are within a step, so what the rows gave a body in one substep they give it again in the next: the warm start of
/// those that follow is one addition a body ([`push_again`]), not a pass over all rows. Joints, which turn with their bodies, have their own.
fn push_rows(world: &mut World, step: &Step) {
    world.scratch.pushed.clear();
    world.scratch.pushed.resize(world.awake.state.len(), [0.0; 8]);
    counted(world, Pass::Warm, step);
}

/// Adds to every body what contacts gave it in the last substep.
fn push_again(world: &mut World) {
    let pushed = &world.scratch.pushed;
    world.tasks.for_each(&mut world.awake.state, BODIES, |i, s| {
        let Some(p) = pushed.get(i) else { return };
        s.hot = core::array::from_fn(|k| s.hot[k] + p[k]);
    });
}

/// A pass over all rows; what it does to the bodies' velocities adds to what is pushed again.
fn counted(world: &mut World, pass: Pass, step: &Step) {
    if world.scratch.rows.is_empty() {
        return;
    }
    let before = &mut world.scratch.before;
    before.clear();
    before.extend(world.awake.state.iter().map(|s| s.hot));
    sweep(world, pass, step);
    let (before, states) = (&world.scratch.before, &world.awake.state);
    world.tasks.for_each(&mut world.scratch.pushed, BODIES, |i, p| {
        let (Some(s), Some(b)) = (states.get(i), before.get(i)) else { return };
        // The last two are places, which no pass changes.
        *p = core::array::from_fn(|k| p[k] + (s.hot[k] - b[k]));
    });
}

/// One pass over all colours, then the overflow rows in their order.
pub(super) fn sweep(world: &mut World, pass: Pass, step: &Step) {
    let width = world.width;
    let constants = &step.constants;
    let scratch = &mut world.scratch;
    let states = &mut world.awake.state;
    let all = !matches!(pass, Pass::Compress | Pass::Restitution);
    for (color, blocks) in scratch.blocks.iter_mut().enumerate().take(ColorSets::COLORS) {
        if blocks.is_empty() {
            continue;
        }
        scratch.colors.scatter(
            color,
            &world.tasks,
            LANES,
            states,
            BodyState::FIXED,
            blocks,
            |access, rows, block| {
                if !all && !block.live {
                    return;
                }
                dispatch(width, Sweep { pass, access, rows, block, lane: 0, constants });
            },
        );
    }
    let overflow = &mut scratch.blocks[ColorSets::COLORS];
    scratch.colors.scatter_overflow(LANES, states, BodyState::FIXED, overflow, |access, row, block| {
        if !all && !block.live {
            return;
        }
        let lane = row % LANES;
        dispatch(Width::X1, Sweep { pass, access, rows: row..row + 1, block, lane, constants });
    });
}
