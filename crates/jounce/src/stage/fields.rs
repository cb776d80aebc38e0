//! Fields on bodies: once when a step begins, for those who count with its acceleration; then in every substep.

use super::Step;
use crate::room::fields::bodies::{Acting, Feel, Mover, gust_can_move, view};
use crate::room::fields::desc::FieldLaw;
use crate::room::fields::point::bounded;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::mass;
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_math::{DVec3, Vec3};
use jounce_motion::force;

/// Bodies per unit.
const BODIES: usize = 64;

/// Memory of the stage; not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct FieldScratch {
    pub acting: Acting,
    /// By awake row.
    pub feels: Vec<Feel>,
    /// Acceleration by bodies on one another, by awake row.
    pub attraction: Vec<Vec3>,
    /// Who attracts: awake row (or NONE), position, mass; and what becomes of it.
    pub attractors: Vec<(u32, DVec3, f64)>,
    pub pulls: Vec<Vec3>,
    /// Bodies for which a hook has no number: they feel nothing in this step, and the guard takes them out.
    pub bad: Vec<u32>,
}

/// Starts a step: accelerations of fields join those of gravity and forces.
pub(crate) fn begin(world: &mut World) {
    let mut memory = core::mem::take(&mut world.scratch.fields);
    memory.acting = Acting::of(&world.fields);
    memory.feels.clear();
    world.fields.time = world.time();
    if memory.acting.any() {
        attract(world, &mut memory);
        for row in 0..world.awake.step.len() {
            let feel = start_body(world, &mut memory, row);
            memory.feels.push(feel);
        }
    }
    world.scratch.fields = memory;
}

fn start_body(world: &mut World, memory: &mut FieldScratch, row: usize) -> Feel {
    let step = &world.awake.step[row];
    if step.kind != BodyKind::Dynamic || step.inv_mass == 0.0 {
        return Feel::default();
    }
    let (slot, body) = (step.body, &world.bodies[step.body]);
    let all = body.shapes.iter().fold(0, |l, &s| l | world.shapes[s].filter.layers);
    let layers = if body.shapes.is_empty() { u32::MAX } else { all };
    let (v, center) = (world.awake.state[row].v(), world.frames[slot as usize].center);
    let view = view(center, v, body.mass.mass, world.fields.time, world.body_id(slot), body.user_data);
    let pull = world.fields.pull(&view, layers);
    let attraction = memory.attraction.get(row).copied().unwrap_or(Vec3::ZERO);
    let at_start = pull.gravity * step.gravity_scale + pull.other + attraction;
    if !at_start.is_finite() {
        memory.bad.push(slot);
        return Feel::default();
    }
    let restless = world.fields.acting(layers).any(|f| f.is_restless() && f.desc.region.weight(center) > 0.0)
        || memory.acting.gusts
            && body
                .shapes
                .iter()
                .any(|&s| gust_can_move(&world.fields, &world.shapes[s], center, body.mass.inv_mass));
    let step = &mut world.awake.step[row];
    // Coriolis' part turns the velocity in the substeps; contacts only have to know of it.
    step.acceleration += at_start;
    if restless {
        step.sleep_timer = 0.0;
    }
    Feel { layers, at_start }
}

/// Whether any acts in the substeps.
pub(crate) fn act_now(world: &World) -> bool {
    !world.scratch.fields.feels.is_empty()
}

/// One substep: `i` of `step.substeps`.
pub(crate) fn act(world: &mut World, step: &Step, i: u32) {
    if !act_now(world) {
        return;
    }
    let h = step.constants.h;
    world.fields.time = world.time() + f64::from(i) * f64::from(h);
    let mut memory = core::mem::take(&mut world.scratch.fields);
    if i > 0 {
        attract(world, &mut memory);
    }
    let mut states = core::mem::take(&mut world.awake.state);
    let shared: &World = world;
    let (feels, attraction) = (&memory.feels, &memory.attraction);
    shared.tasks.for_each(&mut states, BODIES, |row, s| {
        let Some(feel) = feels.get(row).filter(|f| f.layers != 0) else { return };
        let (b, inertia) = (&shared.awake.step[row], &shared.awake.inertia[row]);
        let (frame, body) = (&shared.frames[b.body as usize], &shared.bodies[b.body]);
        let motion = s.get();
        let center = frame.center + motion.dp.as_dvec3();
        let pulled = attraction.get(row).copied().unwrap_or(Vec3::ZERO);
        let view = view(
            center,
            motion.v,
            body.mass.mass,
            shared.fields.time,
            shared.body_id(b.body),
            body.user_data,
        );
        let pull = shared.fields.pull(&view, feel.layers);
        let mut mover = Mover {
            v: motion.v,
            w: motion.w,
            center,
            rotation: motion.dq * frame.rotation,
            local_center: frame.local_center,
            inertia,
            outer_radius: body.mass.outer_radius,
            gravity: shared.gravity + pull.gravity,
        };
        // A body that was given more mass for the load it carries is slower to follow.
        let scale = inertia.inv_mass * body.mass.mass;
        mover.pulls(&pull, b.gravity_scale, pulled, feel.at_start, scale, h);
        if memory.acting.medium || memory.acting.water {
            let shapes = body.shapes.iter().map(|&s| &shared.shapes[s]);
            mover.media(&shared.fields, shapes, memory.acting, h);
        }
        s.set_velocity(mover.v, mover.w);
    });
    world.awake.state = states;
    world.scratch.fields = memory;
}

/// Accelerations of chosen bodies by one another, where they are now.
fn attract(world: &World, memory: &mut FieldScratch) {
    memory.attraction.clear();
    if !memory.acting.attraction {
        return;
    }
    memory.attraction.resize(world.awake.step.len(), Vec3::ZERO);
    for f in world.fields.acting(u32::MAX) {
        let FieldLaw::NBody { bodies, g, softening } = &f.desc.law else { continue };
        memory.attractors.clear();
        for &id in bodies {
            let Ok(slot) = world.slot(id) else { continue };
            if world.bodies[slot].enabled {
                memory.attractors.push(attractor(world, slot));
            }
        }
        memory.pulls.clear();
        memory.pulls.resize(memory.attractors.len(), Vec3::ZERO);
        let all = &memory.attractors;
        world.tasks.for_each(&mut memory.pulls, 32, |i, pull| {
            let mut sum = DVec3::ZERO;
            for (j, other) in all.iter().enumerate() {
                if j != i {
                    sum += force::gravitation(*g, 1.0, other.2, other.1 - all[i].1, *softening);
                }
            }
            *pull = bounded(sum);
        });
        for (&(row, ..), &pull) in memory.attractors.iter().zip(&memory.pulls) {
            if let Some(a) = memory.attraction.get_mut(row as usize) {
                *a += pull;
            }
        }
    }
}

/// Row of a body that is moved (or NONE), where it is, and its mass.
pub(crate) fn attractor(world: &World, slot: u32) -> (u32, DVec3, f64) {
    let (body, frame) = (&world.bodies[slot], &world.frames[slot as usize]);
    let state = world.awake.state.get(body.row as usize).map(|s| s.get());
    let center = frame.center + state.map_or(DVec3::ZERO, |s| s.dp.as_dvec3());
    if body.kind == BodyKind::Dynamic {
        return (body.row, center, f64::from(body.mass.mass));
    }
    let shapes = body.shapes.iter().map(|&s| &world.shapes[s]);
    let mass = body.mass_override.or_else(|| mass::sum(shapes)).map_or(0.0, |m| f64::from(m.mass));
    (NONE, center, mass)
}
