//! Vehicles in the step: what wheels stand on, found once; then forces in every substep.

use super::Step;
use crate::handle::BodyId;
use crate::query::{QueryFilter, Ray};
use crate::room::contacts::desc::Combine;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::solve::{absorb, settle, turns_freely};
use crate::room::rigid::state::{InvInertia, NONE};
use crate::room::vehicles::board::STATIONS;
use crate::room::vehicles::desc::WheelCast;
use crate::room::vehicles::solve::{self, Foot, KAPPA_MIN, Mover, Numbers, Plane, Run};
use crate::room::vehicles::state::{Carried, Vehicle};
use crate::world::World;
use jounce_geometry::Shape;
use jounce_math::{DVec3, Quat, Vec3, WorldPose};

/// Memory that is reused from step to step and is not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct VehicleScratch {
    casts: Vec<Cast>,
    runs: Vec<Run>,
    /// Of `runs`, in this step.
    count: usize,
    wakes: Vec<u32>,
}

/// A wheel's, or station's, look at the ground.
#[derive(Clone, Copy, Debug)]
struct Cast {
    vehicle: u32,
    foot: usize,
    hit: Option<Hit>,
}

#[derive(Clone, Copy, Debug)]
struct Hit {
    shape: u32,
    part: Option<u32>,
    point: DVec3,
    normal: Vec3,
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
        cast(world, &mut s, step.dt);
        if s.wakes.is_empty() {
            break;
        }
    }
    world.scratch.vehicles = s;
}

/// All wheels look; what sleeps under one wakes.
fn cast(world: &mut World, s: &mut VehicleScratch, dt: f32) {
    s.casts.clear();
    for (i, v) in world.vehicles.table.iter().filter(|(_, v)| acts(world, v)) {
        s.casts.extend((0..v.feet().count()).map(|foot| Cast { vehicle: i, foot, hit: None }));
    }
    let shared: &World = world;
    shared.tasks.for_each(&mut s.casts, 4, |_, c| {
        let v = &shared.vehicles.table[c.vehicle];
        c.hit = if c.foot < v.wheels.len() {
            under_wheel(shared, v, c.foot, dt)
        } else {
            under_station(shared, v, c.foot - v.wheels.len())
        };
    });
    s.wakes.clear();
    for hit in s.casts.iter().filter_map(|c| c.hit) {
        let body = &world.bodies[world.shapes[hit.shape].body];
        if body.kind == BodyKind::Dynamic && body.island != NONE {
            s.wakes.push(world.shapes[hit.shape].body);
        }
    }
    for &body in &s.wakes {
        world.wake_body(body);
    }
}

fn moves(world: &World, body: u32) -> bool {
    let Some(row) = world.bodies.get(body).map(|b| b.row) else { return false };
    world.awake.state.get(row as usize).is_some_and(|s| s.v() != Vec3::ZERO || s.w() != Vec3::ZERO)
}

fn under_wheel(world: &World, v: &Vehicle, i: usize, dt: f32) -> Option<Hit> {
    let (d, s) = (&v.desc.wheels[i], &v.wheels[i]);
    let frame = &world.frames[v.chassis as usize];
    let q = frame.rotation;
    let up = q.rotate(v.desc.up);
    let (velocity, w) = world.velocities(&world.bodies[v.chassis]);
    let lever = q.rotate(d.position - frame.local_center);
    // Where the wheel will be in the middle of the step.
    let ahead = (velocity + w.cross(lever)) * (0.5 * dt);
    let top = frame.center + (lever + ahead + up * d.bump).as_dvec3();
    let way = d.bump + d.droop;
    let left = v.desc.up.cross(v.desc.forward);
    let axle = q.rotate(Quat::from_axis_angle(v.desc.up, s.steer).rotate(left));
    let shape = match d.cast {
        WheelCast::Ray => return ray(world, v, top, -up, way + d.radius, up),
        WheelCast::Sphere => Shape::Sphere { radius: d.radius },
        WheelCast::Cylinder => Shape::Cylinder { half_height: 0.4 * d.width, radius: d.radius },
    };
    let from = WorldPose::new(top, Quat::from_rotation_arc(Vec3::Y, axle));
    let motion = up * -(way + 0.1 * d.radius);
    with_filter(world, v, |filter| {
        let hit = world.cast_ground(&shape, &from, motion, filter, up, KAPPA_MIN)?;
        let hub = top + (motion * hit.t).as_dvec3();
        Some((hit, hub))
    })
    .map(|(hit, hub)| {
        let rough = Hit { shape: hit.shape.index, part: hit.triangle, point: hit.point, normal: hit.normal };
        // A face gives its own plane, to the last bit.
        let fine = ray(world, v, hub, -hit.normal, 1.5 * d.radius, hit.normal);
        fine.filter(|f| f.shape == rough.shape && f.normal.dot(rough.normal) > 0.999).unwrap_or(rough)
    })
    .or_else(|| ray(world, v, top, -up, way + d.radius, up))
}

fn under_station(world: &World, v: &Vehicle, i: usize) -> Option<Hit> {
    let d = v.desc.board.as_ref()?;
    let frame = &world.frames[v.chassis as usize];
    let up = frame.rotation.rotate(v.desc.up);
    let p = frame.pose().transform_point(station(v, i)) + (up * d.reach).as_dvec3();
    ray(world, v, p, -up, 2.0 * d.reach, up)
}

/// In the chassis' frame.
fn station(v: &Vehicle, i: usize) -> Vec3 {
    let Some(d) = &v.desc.board else { return Vec3::ZERO };
    let left = v.desc.up.cross(v.desc.forward);
    let (x, y) = STATIONS[i];
    d.position + v.desc.forward * (0.5 * x * d.length) + left * (0.5 * y * d.width)
}

fn with_filter<T>(world: &World, v: &Vehicle, f: impl FnOnce(&QueryFilter<'_>) -> T) -> T {
    let chassis = v.chassis;
    let apart = move |s: crate::ShapeId| !world.are_parted(chassis, world.shapes[s.index].body);
    let exclude: BodyId = world.body_id(chassis);
    f(&QueryFilter::default().layers(v.desc.ground_layers).excluding(exclude).only(&apart))
}

fn ray(world: &World, v: &Vehicle, from: DVec3, dir: Vec3, length: f32, up: Vec3) -> Option<Hit> {
    let ray = Ray { origin: from, dir, max_t: length };
    let hit = with_filter(world, v, |filter| world.cast_ray(&ray, filter))?;
    let faces = hit.t > 0.0 && hit.normal.dot(up) > KAPPA_MIN;
    faces.then_some(Hit { shape: hit.shape.index, part: hit.triangle, point: hit.point, normal: hit.normal })
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
    for group in s.casts.chunk_by(|a, b| a.vehicle == b.vehicle) {
        let id = group[0].vehicle;
        let Some(v) = vehicles.table.get_mut(id) else { continue };
        if !acts(shared, v) {
            continue;
        }
        if s.runs.len() <= s.count {
            s.runs.push(Run::new());
        }
        let run = &mut s.runs[s.count];
        s.count += 1;
        run.id = id;
        begin(shared, v, run, group);
        solve::begin(v, run);
    }
    world.vehicles = vehicles;
    world.scratch.vehicles = s;
}

fn begin(world: &World, v: &mut Vehicle, run: &mut Run, casts: &[Cast]) {
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
    let wheels = v.wheels.len();
    for c in casts {
        let local =
            if c.foot < wheels { v.desc.wheels[c.foot].position } else { station(v, c.foot - wheels) };
        let hub = q.rotate(local - frame.local_center);
        let tyre = v.desc.wheels.get(c.foot).map(|w| [w.tyre.static_friction, w.tyre.kinetic_friction]);
        let plane = c.hit.map(|hit| plane(world, run, frame.center, tyre, &hit));
        let state = if c.foot < wheels { &mut v.wheels[c.foot] } else { &mut v.stations[c.foot - wheels] };
        (state.ground, state.shape) = c.hit.map_or((NONE, NONE), |h| (world.shapes[h.shape].body, h.shape));
        let list = if c.foot < wheels { &mut run.wheels } else { &mut run.stations };
        list.push(Foot { hub, plane });
    }
    for a in &v.desc.aero {
        run.stations.push(Foot { hub: q.rotate(a.position - frame.local_center), plane: None });
    }
}

fn plane(world: &World, run: &mut Run, center: DVec3, tyre: Option<[f32; 2]>, hit: &Hit) -> Plane {
    let r = &world.shapes[hit.shape];
    let body = r.body;
    let ground = run.grounds.iter().position(|g| g.slot == body).unwrap_or_else(|| {
        run.grounds.push(mover(world, body));
        run.grounds.len() - 1
    });
    let frame = &world.frames[body as usize];
    let m = super::narrowphase::material(r, hit.part.unwrap_or(0));
    let mu = tyre.map_or([0.0; 2], |[fixed, sliding]| {
        let rule = Combine::of(m.friction_combine, Combine::GeometricMean);
        [rule.apply(fixed, m.static_friction), rule.apply(sliding, m.kinetic_friction)]
    });
    Plane {
        ground,
        point: (hit.point - center).as_vec3(),
        lever: (hit.point - frame.center).as_vec3(),
        normal: hit.normal,
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
    let mut s = core::mem::take(&mut world.scratch.vehicles);
    let mut vehicles = core::mem::take(&mut world.vehicles);
    let c = &step.constants;
    let k = Numbers { h: c.h, dt: step.dt, push_out_speed: c.push_out_speed };
    for run in &mut s.runs[..s.count] {
        let Some(v) = vehicles.table.get_mut(run.id) else { continue };
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
