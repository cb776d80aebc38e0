//! Particles: births, motion, hits, deaths. Runs when the bodies' motion over the step is known, so that particles meet shapes
//! where these go, and before islands fall asleep, so that a body that particles push stays awake.
//!
//! Blocks of particles are independent units. What they do to others (pushes, events) is written down, and settled one by one
//! in the order of emitters and births.

use super::Step;
use crate::event::Event;
use crate::room::fields::desc::{FieldLaw, Region};
use crate::room::particles::ball::Around;
use crate::room::particles::prepare::{EmitterStep, Rules, ends, schedule};
use crate::room::particles::solve::{self, Advance, Medium, Out, Scratch};
use crate::room::particles::state::{Block, Emitter, LANES, Particles};
use crate::room::particles::{collide, obstacles, on_plane, settle, view};
use crate::world::World;
use jounce_lanes::dispatch;
use jounce_math::{DVec3, Vec3};

/// Blocks per unit.
const BLOCKS: usize = 4;
/// Farthest an emitter may be from what its particles' positions count from, m: they resolve 0.06 mm there.
const DRIFT: f64 = 1024.0;

pub(crate) fn run(world: &mut World, step: &Step) {
    if world.particles.emitters.len() == 0 {
        return;
    }
    let mut particles = core::mem::take(&mut world.particles);
    let mut scratch = core::mem::take(&mut particles.scratch);
    scratch.steps.clear();
    scratch.runs.clear();
    let slots = particles.emitters.iter().map(|(i, _)| i).max().map_or(0, |i| i as usize + 1);
    for slot in 0..slots as u32 {
        let live = particles.emitters.get(slot).is_some();
        let prepared = live.then(|| prepare(world, &mut particles, slot, step, &mut scratch));
        scratch.steps.push(prepared);
    }
    solve_blocks(world, &mut particles, &mut scratch);
    let mut told = 0;
    for slot in 0..slots as u32 {
        if particles.emitters.get(slot).is_some() {
            settle::emitter(world, &mut particles, &scratch, slot, &mut told);
        }
    }
    settle::tidy(&mut particles);
    remove_ended(&mut particles, slots as u32);
    particles.scratch = scratch;
    world.particles = particles;
}

/// Emitters that asked to go when they have ended and nothing of them is left.
fn remove_ended(particles: &mut Particles, slots: u32) {
    for slot in 0..slots {
        let ended = |e: &Emitter| e.desc.auto_remove && e.finished && e.count == 0;
        if particles.emitters.get(slot).is_some_and(ended) {
            particles.clear(slot);
            particles.emitters.remove(slot);
        }
    }
}

/// Whether a law says the same of particles at every place and speed (bodies that attract one another say nothing).
fn is_uniform(law: &FieldLaw) -> bool {
    matches!(
        law,
        FieldLaw::Uniform { .. }
            | FieldLaw::Drag { .. }
            | FieldLaw::Wind { gust: None, .. }
            | FieldLaw::NBody { .. }
    )
}

/// All that the particles of an emitter have in common, and blocks for those to be born.
fn prepare(
    world: &mut World,
    particles: &mut Particles,
    slot: u32,
    step: &Step,
    scratch: &mut Scratch,
) -> EmitterStep {
    core::mem::swap(&mut world.particles, particles);
    let stand = world.emitter_stand(slot);
    let room = world.particle_room(slot);
    core::mem::swap(&mut world.particles, particles);
    let stale = particles.emitters[slot].desc.body.is_some_and(|b| world.slot(b).is_err());
    if !stale {
        rebase(particles, slot, stand.poses[1].p);
    }
    let e = &particles.emitters[slot];
    let mut s = EmitterStep::new(e, stand, world.gravity, step.dt, world.time());
    s.medium = uniform_medium(world, e);
    s.hook = e.desc.kill_hook.as_ref().and_then(|name| world.hooks.particle(name));
    if !e.desc.enabled || e.finished {
        return s;
    }
    if stale {
        finish(world, &mut particles.emitters[slot], slot);
        return s;
    }
    let from = scratch.runs.len();
    let wanted = schedule(e, world.rate_hz, &mut scratch.bursts, &mut scratch.runs);
    s.runs = (from, scratch.runs.len());
    let born = wanted.min(room as u64) as usize;
    if wanted > room as u64 {
        world.events.push(Event::LimitReached { what: "particles" });
    }
    place_births(particles, slot, born);
    let over = ends(&particles.emitters[slot], world.rate_hz);
    let e = &mut particles.emitters[slot];
    (e.clock, e.serial) = (e.clock + 1, e.serial + wanted);
    e.unborn += wanted - born as u64;
    if over {
        finish(world, e, slot);
    }
    s
}

fn finish(world: &mut World, e: &mut Emitter, slot: u32) {
    e.finished = true;
    let emitter = crate::EmitterId { index: slot, generation: e.generation };
    world.events.push(Event::EmitterFinished { emitter });
}

/// The fields at an emitter, where all that act on it are the same everywhere.
fn uniform_medium(world: &World, e: &Emitter) -> Option<crate::room::fields::point::FieldSample> {
    let fields = &world.fields;
    if fields.table.len() == 0 {
        return Some(Default::default());
    }
    let acting = fields.table.iter().map(|(_, f)| &f.desc);
    let mut acting = acting.filter(|f| f.enabled && f.layers & e.desc.layers != 0);
    let uniform = acting.all(|f| f.region == Region::Everywhere && is_uniform(&f.law));
    uniform.then(|| fields.sample(e.origin, Vec3::ZERO, e.desc.layers))
}

/// Keeps the origin that positions count from near the emitter.
fn rebase(particles: &mut Particles, slot: u32, to: DVec3) {
    let Particles { emitters, pool, .. } = particles;
    let e = &mut emitters[slot];
    if (to - e.origin).abs().max_component() <= DRIFT {
        return;
    }
    let by = (to - e.origin).as_vec3();
    e.origin += by.as_dvec3();
    for &i in &e.blocks {
        pool[i as usize].shift(by);
    }
}

/// Finds lanes for births: the rest of the last block, then new ones.
fn place_births(particles: &mut Particles, slot: u32, born: usize) {
    let mut first = 0;
    while first < born {
        let last = particles.emitters[slot].blocks.last().copied();
        let free = |i: u32| {
            let b = &particles.pool[i as usize];
            LANES - b.count - b.births
        };
        let i = last.filter(|&i| free(i) > 0).unwrap_or_else(|| particles.add_block(slot));
        let b = &mut particles.pool[i as usize];
        if b.births == 0 {
            b.first_birth = first;
        }
        let n = (LANES - b.count - b.births).min(born - first);
        b.births += n;
        first += n;
    }
}

fn solve_blocks(world: &World, particles: &mut Particles, scratch: &mut Scratch) {
    let Particles { emitters, pool, .. } = particles;
    let mut outs = core::mem::take(&mut scratch.outs);
    outs.resize_with(pool.len().max(outs.len()), Out::default);
    let shared: &Scratch = scratch;
    let reach =
        if shared.steps.iter().flatten().any(|s| s.rules.is_some()) { obstacles::reach(world) } else { 0.0 };
    let n = pool.len();
    world.tasks.for_each2((pool, &mut outs[..n]), BLOCKS, |_, block, out| {
        let Some(e) = emitters.get(block.emitter) else { return };
        let Some(Some(step)) = shared.steps.get(block.emitter as usize) else { return };
        solve_block(world, e, step, shared, block, out, reach);
    });
    scratch.outs = outs;
}

fn solve_block(
    world: &World,
    e: &Emitter,
    step: &EmitterStep,
    scratch: &Scratch,
    block: &mut Block,
    out: &mut Out,
    reach: f32,
) {
    out.hits.clear();
    (out.lost, out.crowded) = (0, false);
    solve::births(block, e, step, &scratch.runs, world.dt());
    if block.count == 0 {
        return;
    }
    let medium = match step.medium {
        Some(_) => None,
        None => Some(sample(world, step, block)),
    };
    let mut next = dispatch(world.width, Advance { block, step, medium: medium.as_ref() });
    let held = if step.sticks { hold(world, step, block, &mut next) } else { 0 };
    if let Some(rules) = &step.rules {
        obstacles::gather(world, e, step, rules, &next, reach, out);
        if !out.obstacles.is_empty() {
            let radius_scale = rules.desc.radius_scale;
            let near = collide::Near { block, next: &next, radius_scale, obstacles: &mut out.obstacles };
            dispatch(world.width, near);
            meet(world, block, rules, &mut next, held, out);
        }
    }
    solve::commit(block, &next);
    let mut alive = solve::in_use(block.count) & !next.dead;
    if let Some(hook) = &step.hook {
        let id = crate::EmitterId { index: block.emitter, generation: e.generation };
        for l in (0..block.count).filter(|l| next.dead >> l & 1 == 0) {
            if hook(&view::view(e, id, block, l)) {
                alive &= !(1 << l);
            }
        }
    }
    out.lost = (next.bad & solve::in_use(block.count)).count_ones();
    out.hits.iter_mut().for_each(|h| h.settle_on(alive));
    block.keep(alive);
}

/// What the fields say at each particle.
fn sample(world: &World, step: &EmitterStep, block: &Block) -> Medium {
    let mut m = Medium::NONE;
    for l in 0..block.count {
        let at = step.origin + block.place(l).as_dvec3();
        let s = world.fields.sample(at, block.velocity(l), step.layers);
        m.set(l, &s, step.weight, block.radius[l], block.mass[l]);
    }
    m
}

/// Particles that stick move with their shapes.
fn hold(world: &World, step: &EmitterStep, block: &mut Block, next: &mut solve::Next) -> u64 {
    solve::carry(block, next, step, |slot, generation, p| {
        if !world.shapes.is_live(slot, generation) {
            return None;
        }
        let o = obstacles::obstacle(world, slot, step.origin, false)?;
        Some((o.carry(p, 0.0), o.velocity_at(p)))
    })
}

/// The particles near obstacles, one by one.
fn meet(world: &World, block: &mut Block, rules: &Rules, next: &mut solve::Next, held: u64, out: &mut Out) {
    let near = out.obstacles.iter().fold(0, |bits, o| bits | o.near);
    let mut lanes = near & solve::in_use(block.count) & !next.dead & !held;
    lanes &= !on_plane::run(world.width, block, next, rules, &out.obstacles, lanes);
    let shape = |slot: u32| &world.shapes[slot].shape;
    let mut around = Around::new();
    while lanes != 0 {
        let l = lanes.trailing_zeros() as usize;
        lanes &= lanes - 1;
        let way = collide::way(block, l, next.place(l), next.velocity(l), next.age[l], rules);
        match collide::fly(way, Some(l), rules, &out.obstacles, &shape, &mut around, &mut out.hits) {
            collide::End::Flies(p, v) => next.put(l, p, v),
            collide::End::Sticks(p, v, slot) => {
                next.put(l, p, v);
                (block.anchor[l], block.anchor_generation[l]) = (slot, world.shapes.generation(slot));
            }
            collide::End::Dies => next.dead |= 1 << l,
        }
    }
}

// Lanes are bits of a word.
const _: () = assert!(LANES <= 64);
