//! The substeps: velocities, warm start, solve, positions, relax; then restitution and the impulses' way back.

use super::{Scratch, Step, articulated};
use crate::event::Event;
use crate::room::contacts::rows::{Block, LANES, Outcome};
use crate::room::contacts::solve::{Pass, Sweep};
use crate::room::contacts::state::Contact;
use crate::room::contacts::{finish, impact};
use crate::room::rigid::finish as rigid;
use crate::room::rigid::free::{self, Ends, Free, Top, Turns};
use crate::room::rigid::pass::{Drive, Go, Pushed, Todo, Way};
use crate::room::rigid::solve::{SpeedLimits, Substep, integrate_position};
use crate::room::rigid::state::BodyState;
use crate::world::World;
use jounce_lanes::{Width, dispatch, prefetch};
use jounce_math::scalar::f32s;
use jounce_tasks::{ColorSets, Owning, Row, Tasks};

/// Bodies per unit; rows in one fit a byte.
const BODIES: usize = 128;
/// Blocks of rows per unit.
const BLOCKS: usize = 4;
/// So few blocks of a colour are not worth a stage.
const FEW: usize = 2;

pub(crate) fn run(world: &mut World, step: &Step) {
    impacts(world, step);
    super::siblings::part(world, step);
    articulated::prepare(world);
    begin(world, step);
    // Who else acts in the substeps. Bodies are brought up to date for them only.
    let fields = super::fields::act_now(world);
    let others = !world.joints.is_empty() || !world.vehicles.is_empty();
    let mut bodies = Bodies { todo: Todo::default() };
    for i in 0..step.substeps {
        if bodies.todo.go {
            // Without contacts nothing else has asked for it.
            bodies.now(world, step);
        }
        bodies.todo.drive = true;
        if fields {
            bodies.now(world, step);
            super::fields::act(world, step, i);
        }
        if articulated::any(world) {
            bodies.now(world, step);
            articulated::renew(world, step);
        }
        // Levers and inertia stay as they are within a step, so what the rows gave a body in one substep they give it again in the next: the warm
        // start of those that follow is one addition a body, not a pass over all rows. Joints, which turn with their bodies, have their own.
        if i == 0 {
            bodies.counted(world, Pass::Warm, step);
        } else {
            bodies.todo.push = !world.scratch.rows.is_empty();
        }
        if others {
            bodies.now(world, step);
            super::joints::solve(world, step, i);
            super::vehicles::act(world, step);
            articulated::solve(world, step);
        }
        bodies.counted(world, Pass::Solve, step);
        if others {
            bodies.now(world, step);
            super::joints::answer(world, step);
            super::vehicles::go(world);
        }
        bodies.todo.go = true;
        if others {
            bodies.now(world, step);
            super::joints::relax(world, step, i + 1 == step.substeps);
            articulated::relax(world, step);
        }
        bodies.counted(world, Pass::Relax, step);
        if others {
            bodies.now(world, step);
            super::vehicles::follow(world, step);
        }
    }
    bodies.now(world, step);
}

/// What is to be done with all bodies before they are looked at again: several things in one pass where nobody looks in between.
struct Bodies {
    todo: Todo,
}

impl Bodies {
    /// Brings the bodies up to date.
    fn now(&mut self, world: &mut World, step: &Step) {
        let todo = core::mem::take(&mut self.todo);
        if todo == Todo::default() {
            return;
        }
        let sub = Substep { h: step.constants.h, limits: speed_limits(world, step) };
        let (bodies, frames, width) = (&world.bodies, &world.frames, world.width);
        let (drives, ways, tops) = (&world.scratch.drives, &world.scratch.ways, &world.scratch.tops);
        let a = &mut world.awake;
        let steps = &a.step;
        let columns = (&mut a.state[..], &mut world.scratch.pushed[..], &mut a.turning[..]);
        world.tasks.for_each_chunk3(columns, BODIES, |first, states, pushed, turning| {
            let rows = first..first + states.len();
            let (drives, ways, tops) = (&drives[rows.clone()], &ways[rows.clone()], &tops[rows]);
            let (h, speed_most) = (sub.h, sub.limits.speed);
            todo.change(states, pushed, drives);
            if todo.go {
                dispatch(width, Go { states, ways, h, speed_most });
                for ((i, s), way) in states.iter_mut().enumerate().zip(ways) {
                    if way.goes_alone(s, h) {
                        integrate_position(s, &steps[first + i], &mut turning[i], bodies, frames, &sub);
                    }
                }
                let (mut turn, mut spin_most, mut n) = ([0; BODIES], [0.0; BODIES], 0);
                let ways = if ways.iter().any(|w| w.free) { ways } else { &[] };
                for (i, (s, way)) in states.iter().zip(ways).enumerate().filter(|(_, (s, w))| w.turns(s)) {
                    let slot = steps[first + i].body;
                    free::remember(s, &mut turning[i], || {
                        (&bodies[slot].mass, frames[slot as usize].rotation)
                    });
                    (turn[n], spin_most[n]) = (i as u8, way.spin_most);
                    n += 1;
                }
                if n > 0 {
                    let free = Free { states, turning, rows: &turn[..n] };
                    dispatch(width, Turns { free, tops, spin_most: &spin_most[..n], h });
                }
            }
            todo.keep(states, pushed);
        });
    }

    /// A pass over all rows; what it does to the bodies' velocities adds to what is pushed again.
    fn counted(&mut self, world: &mut World, pass: Pass, step: &Step) {
        self.todo.mark = !world.scratch.rows.is_empty();
        if self.todo.mark {
            self.now(world, step);
            sweep(world, pass, step);
            self.todo.count = true;
        }
    }
}

/// What the substeps ask of every body.
fn begin(world: &mut World, step: &Step) {
    let limits = speed_limits(world, step);
    let (a, bodies, frames, scratch) = (&mut world.awake, &world.bodies, &world.frames, &mut world.scratch);
    scratch.pushed.resize(a.state.len(), Pushed::NOTHING);
    scratch.drives.resize(a.state.len(), Drive::NOTHING);
    scratch.ways.resize(a.state.len(), Way::NOTHING);
    scratch.tops.resize(a.state.len(), Top::NOTHING);
    let (steps, inertia, h) = (&a.step, &a.inertia, step.constants.h);
    let columns = (
        &mut scratch.pushed[..],
        &mut scratch.drives[..],
        &mut scratch.ways[..],
        &mut scratch.tops[..],
        &mut a.turning[..],
    );
    world.tasks.for_each_piece(columns, BODIES, |first, (pushed, drives, ways, tops, turning)| {
        for i in 0..pushed.len() {
            let b = &steps[first + i];
            pushed[i] = Pushed::NOTHING;
            drives[i] = Drive::new(b, &inertia[first + i], h);
            ways[i] = Way::new(b, &bodies[b.body], &limits);
            if ways[i].free {
                tops[i] = Top::new(b, &bodies[b.body].mass, h);
                free::check(&mut turning[i], frames[b.body as usize].rotation);
            }
        }
    });
}

/// Restitution, impulses back to the manifolds, motion back to the frames.
pub(crate) fn finish(world: &mut World, step: &Step) {
    super::restitution::run(world, step);
    store(world);
    super::joints::finish(world, step);
    poses(world, step);
    super::vehicles::finish(world, step);
}

/// What the rows gave goes back to their manifolds. Within a colour a contact has one row: others have the same bodies.
fn store(world: &mut World) {
    let (states, tasks, width) = (&world.awake.state, &world.tasks, world.width);
    let stick_speed = world.settings.stick_speed;
    let Scratch { blocks, colors, rows: manifolds, owners, .. } = &mut world.scratch;
    let manifolds = &*manifolds;
    let collect = |block: &Block, rows: &[Row]| {
        let (mut bodies, mut out) = ([[&BodyState::FIXED; LANES]; 2], [Outcome::ZERO; LANES]);
        for (l, row) in rows.iter().enumerate() {
            for (side, item) in bodies.iter_mut().zip([row.a(), row.b()]) {
                if let Some(i) = ColorSets::index(item) {
                    side[l] = &states[i];
                }
            }
        }
        dispatch(width, finish::Collect { block, states: &bodies, out: &mut out });
        out
    };
    let keep = |c: &mut Contact, manifold: u32, of: &Outcome| {
        let hit = finish::store(c.get_mut(manifold as usize), of, stick_speed);
        c.hit_speed = f32s::max(c.hit_speed, hit);
    };
    let contacts = &mut world.contacts;
    owners.resize(contacts.len(), u32::MAX);
    for (color, list) in blocks.iter_mut().enumerate().filter(|(_, list)| !list.is_empty()) {
        let rows = colors.rows(color);
        if color == ColorSets::COLORS {
            for (block, rows) in list.iter().zip(rows.chunks(LANES)) {
                for (row, of) in rows.iter().zip(&collect(block, rows)) {
                    let (contact, manifold) = manifolds[row.payload() as usize];
                    keep(&mut contacts[contact as usize], manifold, of);
                }
            }
            continue;
        }
        for (i, row) in rows.iter().enumerate() {
            owners[manifolds[row.payload() as usize].0 as usize] = (i / LANES) as u32;
        }
        let columns = (&list[..], Owning(&mut contacts[..], owners));
        tasks.for_each_piece(columns, BLOCKS, |first, (blocks, mut contacts)| {
            for (i, block) in blocks.iter().enumerate() {
                let at = first + i;
                let rows = &rows[at * LANES..rows.len().min((at + 1) * LANES)];
                let of = |row: &Row| manifolds[row.payload() as usize];
                // Contacts lie anywhere: they are asked for before what the rows gave is found.
                for row in rows {
                    if let Some(c) = contacts.get(at, of(row).0 as usize) {
                        c.manifold.prefetch();
                        prefetch(&c.manifold.total_friction);
                    }
                }
                for (row, gave) in rows.iter().zip(&collect(block, rows)) {
                    let (contact, manifold) = of(row);
                    if let Some(c) = contacts.get(at, contact as usize) {
                        keep(c, manifold, gave);
                    }
                }
            }
        });
    }
}

fn poses(world: &mut World, step: &Step) {
    let limits = speed_limits(world, step);
    let (a, bodies, ways, width) = (&mut world.awake, &world.bodies, &world.scratch.ways, world.width);
    let frames = Owning(&mut world.frames, &world.row_of);
    let columns = (&mut a.state[..], &mut a.step[..], &mut a.inertia[..], &mut a.turning[..], frames);
    world.tasks.for_each_piece(columns, BODIES, |first, (states, steps, inertia, turning, mut frames)| {
        let (mut turned, mut ends, mut n) = ([false; BODIES], [0; BODIES], 0);
        let free = ways[first..first + states.len()].iter().any(|w| w.free);
        for (i, s) in states.iter().enumerate().filter(|_| free) {
            turned[i] = ways[first + i].free && turning[i].as_ref().is_some_and(|t| t.is_of(s));
            ends[n] = i as u8;
            n += usize::from(turned[i]);
        }
        if n > 0 {
            dispatch(width, Ends { free: Free { states, turning, rows: &ends[..n] }, steps, bodies });
        }
        for (i, (s, b)) in states.iter_mut().zip(steps).enumerate() {
            if let Some(frame) = frames.get(first + i, b.body as usize) {
                let precise = turning[i].as_ref().filter(|_| turned[i]).map(|t| t.rotation);
                rigid::finish(s, b, precise, &mut inertia[i], frame, &bodies[b.body], step.dt, &limits);
            }
        }
    });
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
        &world.heads,
        &world.frames,
        &mut world.awake,
        threshold,
        step.dt,
        &mut world.scratch.impacts,
    ) {
        world.events.push(Event::LimitReached { what: "rounds of simultaneous impacts" });
    }
}

/// One pass over all colours, then the overflow rows in their order.
pub(super) fn sweep(world: &mut World, pass: Pass, step: &Step) {
    let width = world.width;
    let constants = &step.constants;
    let scratch = &mut world.scratch;
    let states = &mut world.awake.state;
    let all = !matches!(pass, Pass::Compress | Pass::Restitution);
    let alone = Tasks::serial();
    for (color, blocks) in scratch.blocks.iter_mut().enumerate().take(ColorSets::COLORS) {
        let live = if all { blocks.len() } else { blocks.iter().filter(|b| b.live).count() };
        if live == 0 {
            continue;
        }
        scratch.colors.scatter(
            color,
            if live <= FEW { &alone } else { &world.tasks },
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
