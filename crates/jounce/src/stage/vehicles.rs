//! Vehicles in the step: what wheels stand on, and their forces, in every substep.

use super::Step;
use super::footing::{self, Hit, Look, Looks};
use crate::room::contacts::desc::Combine;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::free::{absorb, settle};
use crate::room::rigid::solve::turns_freely;
use crate::room::rigid::state::{BodyState, InvInertia, NONE};
use crate::room::vehicles::solve::{self, Foot, Mover, Numbers, Plane, Run};
use crate::room::vehicles::state::{Carried, Vehicle};
use crate::world::World;
use jounce_math::Vec3;

/// Memory that is reused from step to step and is not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct VehicleScratch {
    looks: Looks,
    runs: Vec<Run>,
    /// Of `runs`, in this step.
    count: usize,
    wakes: Vec<u32>,
}

/// Row of a dynamic body that is awake.
fn dynamic_row(world: &World, body: u32) -> u32 {
    let row = world.frames[body as usize].row;
    if row != NONE && world.awake.step[row as usize].kind == BodyKind::Dynamic { row } else { NONE }
}

fn acts(world: &World, v: &Vehicle) -> bool {
    v.enabled
        && dynamic_row(world, v.chassis) != NONE
        && v.desc.is_carried_by(world.bodies[v.chassis].mass.mass)
}

/// Looks for the ground; wakes vehicles whose ground moves, and sleepers that are driven on.
pub(crate) fn look(world: &mut World, step: &Step) {
    if world.vehicles.is_empty() {
        return;
    }
    let mut s = core::mem::take(&mut world.scratch.vehicles);
    s.wakes.clear();
    for (_, v) in world.vehicles.table.iter() {
        let asleep = world.bodies[v.chassis].row == NONE && world.bodies[v.chassis].enabled;
        if asleep && v.feet().any(|w| moves(world, w.ground)) {
            s.wakes.push(v.chassis);
        }
    }
    for &body in &s.wakes {
        world.wake_body(body);
    }
    // Sleepers that are driven on may wake vehicles that have not looked yet: those do, too.
    for _ in 0..2 {
        s.looks.gather(world, step, |v| acts(world, v));
        s.wakes.clear();
        s.wakes.extend(footing::sleepers(world, &s.looks));
        if s.wakes.is_empty() {
            break;
        }
        for &body in &s.wakes {
            world.wake_body(body);
        }
    }
    world.scratch.vehicles = s;
}

fn moves(world: &World, body: u32) -> bool {
    let Some(row) = world.bodies.get(body).map(|b| b.row) else { return false };
    world.awake.state.get(row as usize).is_some_and(|s| s.v() != Vec3::ZERO || s.w() != Vec3::ZERO)
}

/// Once per step: where everything stands.
pub(crate) fn prepare(world: &mut World, _: &Step) {
    let mut s = core::mem::take(&mut world.scratch.vehicles);
    s.count = 0;
    if world.vehicles.is_empty() {
        world.scratch.vehicles = s;
        return;
    }
    let mut vehicles = core::mem::take(&mut world.vehicles);
    let shared: &World = world;
    let mut from = 0;
    for group in s.looks.list().chunk_by(|a, b| a.vehicle == b.vehicle) {
        let id = group[0].vehicle;
        let looks = from..from + group.len();
        from = looks.end;
        let Some(v) = vehicles.table.get_mut(id) else { continue };
        if !acts(shared, v) {
            continue;
        }
        if s.runs.len() <= s.count {
            s.runs.push(Run::new());
        }
        let run = &mut s.runs[s.count];
        s.count += 1;
        (run.id, run.looks) = (id, looks);
        begin(shared, v, run);
        solve::begin(v, run);
    }
    world.vehicles = vehicles;
    world.scratch.vehicles = s;
}

fn begin(world: &World, v: &mut Vehicle, run: &mut Run) {
    let frame = &world.frames[v.chassis as usize];
    let q = frame.rotation;
    run.chassis = mover(world, v.chassis);
    run.grounds.clear();
    run.wheels.clear();
    run.stations.clear();
    (run.up, run.forward) = (q.rotate(v.desc.up), q.rotate(v.desc.forward));
    (run.origin, run.rotation) = (frame.center, q);
    // A jump since the last step is none of the wheels' doing.
    let same = |c: &Carried| (c.center - frame.center).length() < 1e-9 && c.rotation == q;
    v.carried = v.carried.filter(same);
    run.mass = world.bodies[v.chassis].mass.mass;
    let shapes = &world.bodies[v.chassis].shapes;
    let all = shapes.iter().fold(0, |l, &s| l | world.shapes[s].filter.layers);
    run.layers = if shapes.is_empty() { u32::MAX } else { all };
    run.gravity = world.gravity * world.bodies[v.chassis].gravity_scale;
    run.chassis.m = world.awake.state[run.chassis.row as usize].get();
    let hub = |local: Vec3| Foot { hub: q.rotate(local - frame.local_center), ..Foot::default() };
    run.wheels.extend(v.desc.wheels.iter().map(|w| hub(w.position)));
    run.stations.extend((0..v.stations.len()).map(|i| hub(footing::station(v, i))));
    run.stations.extend(v.desc.aero.iter().map(|a| hub(a.position)));
}

/// In a substep: the ground that feet have come to.
fn stand(world: &World, v: &mut Vehicle, run: &mut Run, looks: &[Look]) {
    let wheels = v.wheels.len();
    for l in looks {
        let tyre = v.desc.wheels.get(l.foot).map(|w| [w.tyre.static_friction, w.tyre.kinetic_friction]);
        let plane = l.hit.map(|hit| plane(world, run, tyre, &hit));
        let (state, foot) = if l.foot < wheels {
            (&mut v.wheels[l.foot], &mut run.wheels[l.foot])
        } else {
            (&mut v.stations[l.foot - wheels], &mut run.stations[l.foot - wheels])
        };
        let ground = l.hit.map_or(NONE, |h| world.shapes[h.shape].body);
        foot.met = ground != state.ground;
        foot.plane = plane;
        (state.ground, state.shape) = (ground, l.hit.map_or(NONE, |h| h.shape));
    }
}

/// A plane where the step began: it goes with its body from there.
fn plane(world: &World, run: &mut Run, tyre: Option<[f32; 2]>, hit: &Hit) -> Plane {
    let r = &world.shapes[hit.shape];
    let body = r.body;
    let ground = run.grounds.iter().position(|g| g.slot == body).unwrap_or_else(|| {
        run.grounds.push(mover(world, body));
        run.grounds.len() - 1
    });
    let frame = &world.frames[body as usize];
    let moved = world.awake.state.get(frame.row as usize).unwrap_or(&BodyState::FIXED).get();
    let m = super::narrowphase::material(r, hit.part);
    let mu = tyre.map_or([0.0; 2], |[fixed, sliding]| {
        let rule = Combine::of(m.friction_combine, Combine::GeometricMean);
        [rule.apply(fixed, m.static_friction), rule.apply(sliding, m.kinetic_friction)]
    });
    let now = (hit.point - frame.center).as_vec3() - moved.dp;
    let lever = moved.dq.inverse_rotate(now);
    Plane {
        ground,
        point: (hit.point - run.origin).as_vec3() - moved.dp - (now - lever),
        lever,
        normal: moved.dq.inverse_rotate(hit.normal),
        mu,
        surface: frame.rotation.rotate(r.pose.q.rotate(m.surface_velocity)),
    }
}

/// A body as the step begins.
fn mover(world: &World, slot: u32) -> Mover {
    let mut b = Mover::new(slot);
    b.row = world.frames[slot as usize].row;
    let Some(inertia) = world.awake.inertia.get(b.row as usize) else { return b };
    let step = &world.awake.step[b.row as usize];
    if step.kind == BodyKind::Dynamic {
        let inv = |i: u8| if step.locks & (1 << i) == 0 { inertia.inv_mass } else { 0.0 };
        b.start_inv_mass = Vec3::new(inv(0), inv(1), inv(2));
        b.start_tensor = *inertia;
        b.free = turns_freely(step);
    }
    (b.inv_mass, b.tensor) = (b.start_inv_mass, b.start_tensor);
    b
}

/// Before the positions move. One vehicle after the other, in slot order: they may stand on each other.
pub(crate) fn act(world: &mut World, step: &Step) {
    if world.vehicles.is_empty() {
        return;
    }
    let mut s = core::mem::take(&mut world.scratch.vehicles);
    s.looks.renew(world, step);
    let mut vehicles = core::mem::take(&mut world.vehicles);
    let c = &step.constants;
    let k = Numbers { h: c.h, dt: step.dt, push_out_speed: c.push_out_speed };
    for run in &mut s.runs[..s.count] {
        let Some(v) = vehicles.table.get_mut(run.id) else { continue };
        stand(world, v, run, &s.looks.list()[run.looks.clone()]);
        load(world, &mut run.chassis);
        run.grounds.iter_mut().for_each(|g| load(world, g));
        let mut flows = core::mem::take(&mut run.flows);
        flows.clear();
        if !world.fields.is_empty() {
            flows.extend(solve::in_the_air(&v.desc, run).map(|(own, at)| {
                let (m, _) = world.fields.around(at, run.layers);
                (m.flow, if m.density > 0.0 { m.density } else { own })
            }));
        }
        run.flows = flows;
        solve::substep(v, run, &k);
        unload(world, &mut run.chassis);
        run.grounds.iter_mut().for_each(|g| unload(world, g));
    }
    world.vehicles = vehicles;
    world.scratch.vehicles = s;
}

/// Before the positions move, after all impulses: how treads will go.
pub(crate) fn go(world: &mut World) {
    each(world, |v, run| solve::go(v, run));
}

/// At the end of a substep: what has come of it.
pub(crate) fn follow(world: &mut World, step: &Step) {
    each(world, |v, run| solve::follow(v, run, step.constants.h));
}

/// Vehicles, where their bodies are now.
fn each(world: &mut World, f: impl Fn(&mut Vehicle, &mut Run)) {
    let mut s = core::mem::take(&mut world.scratch.vehicles);
    let mut vehicles = core::mem::take(&mut world.vehicles);
    for run in &mut s.runs[..s.count] {
        let Some(v) = vehicles.table.get_mut(run.id) else { continue };
        load(world, &mut run.chassis);
        run.grounds.iter_mut().for_each(|g| load(world, g));
        f(v, run);
    }
    world.vehicles = vehicles;
    world.scratch.vehicles = s;
}

fn load(world: &World, b: &mut Mover) {
    let Some(state) = world.awake.state.get(b.row as usize) else { return };
    b.m = state.get();
    (b.inv_mass, b.tensor) = (b.start_inv_mass, b.start_tensor);
    if !b.free {
        return;
    }
    let (frame, mass) = (&world.frames[b.slot as usize], &world.bodies[b.slot].mass);
    b.turning = world.awake.turning[b.row as usize];
    settle(&mut b.m, &mut b.turning, mass, frame.rotation);
    let inertia = &world.awake.inertia[b.row as usize];
    let raised = if mass.inv_mass > 0.0 { inertia.inv_mass / mass.inv_mass } else { 1.0 };
    b.tensor = InvInertia::new((b.m.dq * frame.rotation).normalize(), &mass.inv_inertia, inertia.inv_mass, 0)
        .scaled(raised);
}

fn unload(world: &mut World, b: &mut Mover) {
    if b.start_inv_mass == Vec3::ZERO && b.start_tensor == InvInertia::default() {
        return;
    }
    let row = b.row as usize;
    if b.free {
        let rotation = world.frames[b.slot as usize].rotation;
        absorb(&b.m, &mut b.turning, &world.bodies[b.slot].mass, rotation);
        world.awake.turning[row] = b.turning;
    }
    world.awake.state[row].put(&b.m);
}

/// After the poses: gears, and who may not rest.
pub(crate) fn finish(world: &mut World, step: &Step) {
    let s = core::mem::take(&mut world.scratch.vehicles);
    let mut vehicles = core::mem::take(&mut world.vehicles);
    for run in &s.runs[..s.count] {
        let Some(v) = vehicles.table.get_mut(run.id) else { continue };
        if !v.is_finite() {
            v.forget();
        }
        shift(v, step.dt);
        // From here on the chassis stands where its frame says.
        let frame = &world.frames[v.chassis as usize];
        if let Some(c) = &mut v.carried {
            c.angular += (frame.center - c.center).as_vec3().cross(c.linear) * -1.0;
            (c.center, c.rotation) = (frame.center, frame.rotation);
        }
        let standing = run.wheels.iter().chain(&run.stations).filter_map(|f| f.plane);
        let carried = standing.into_iter().any(|p| {
            let g = &run.grounds[p.ground];
            p.surface != Vec3::ZERO || (g.start_inv_mass == Vec3::ZERO && moves(world, g.slot))
        });
        let row = run.chassis.row as usize;
        let b = &mut world.awake.step[row];
        let turns = |i: usize| v.wheels[i].x.abs() * v.desc.wheels[i].radius > b.sleep_speed;
        let stands = |i: usize| v.wheels[i].seen.load > 0.0;
        let busy =
            (0..v.wheels.len()).any(|i| stands(i) && (turns(i) || v.wheels[i].u.abs() > b.sleep_speed));
        let driven = v.desc.drive.is_some() && v.input.throttle > 0.0 && v.shifter.gear != 0;
        if carried || busy || driven || v.shifter.is_shifting() {
            b.sleep_timer = 0.0;
        }
    }
    world.vehicles = vehicles;
    world.scratch.vehicles = s;
}

/// The gearbox, by the speed of its input.
fn shift(v: &mut Vehicle, dt: f32) {
    let Some(d) = &v.desc.drive else { return };
    let mut speed = 0.0;
    for a in &d.axles {
        speed += 0.5 * a.share * (v.wheels[a.left].x + v.wheels[a.right].x);
    }
    v.shifter.step(&d.gearbox, v.input.gear, speed, dt);
}
