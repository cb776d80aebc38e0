//! A step allocates nothing once the world has warmed up: a mixed heap in a turning drum, so that contacts come and go all the time.

mod common;

use common::rng::Rng;
use jounce::geometry::{TriMesh, TriMeshOptions};
use jounce::prelude::*;
use jounce::{Stage, StageObserver};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: forwards to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::SeqCst);
        // SAFETY: promised by the caller.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: promised by the caller.
        unsafe { System.dealloc(at, layout) }
    }
    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::SeqCst);
        // SAFETY: promised by the caller.
        unsafe { System.realloc(at, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Windows of 300 steps of which one must pass without an allocation.
const WINDOWS: usize = 4;

/// Counts per stage.
struct ByStage {
    last: usize,
    counts: [usize; Stage::ALL.len()],
}

impl StageObserver for ByStage {
    fn after(&mut self, stage: Stage, _: &World) {
        let now = ALLOCATIONS.load(Ordering::SeqCst);
        self.counts[stage as usize] += now - self.last;
        self.last = now;
    }
}

/// A drum with a mesh for a floor below it, a sensor, bouncing balls, and bodies that fall asleep and are woken.
fn world() -> World {
    let (mut world, mut rng) = (World::new(WorldDesc::default()).expect("valid"), Rng::new(21));
    // A car and a tank in circles, beside all that.
    let road = ShapeDesc::cuboid([60.0, 1.0, 60.0]).at([100.0, -7.0, 0.0]).friction(1.0);
    world.add_body(BodyDesc::fixed().shape(road)).expect("valid");
    for (kit, z) in [(jounce::vehicles::car(), -20.0), (jounce::vehicles::tank(), 20.0)] {
        let v = kit.add(&mut world, [100.0, -6.0, z], Quat::IDENTITY).expect("valid");
        world.set_vehicle_input(v, VehicleInput::drive(0.2, 1.0)).expect("valid");
    }
    // A chain with ends, friction and a motor on a turning body, and a ragdoll that is dragged through the heap.
    let crank = world
        .add_body(BodyDesc::kinematic().at([12.0, 0.0, 0.0]).angular_velocity([0.0, 0.0, 2.0]))
        .expect("valid");
    let links: Vec<BodyId> = (0..6)
        .map(|i| {
            let at = [12.5 + 0.5 * f64::from(i), 0.0, 0.0];
            world
                .add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid([0.2, 0.05, 0.05])))
                .expect("valid")
        })
        .collect();
    for (i, &b) in links.iter().enumerate() {
        let (a, at) = (if i == 0 { crank } else { links[i - 1] }, [12.25 + 0.5 * i as f64, 0.0, 0.0]);
        let j = JointDesc::hinge(a, b, at, Vec3::Z).limited(-1.0, 1.0);
        let j = if i == 2 { j.motor(jounce::MotorDesc::velocity(0.5, 1.0)) } else { j };
        world.add_joint(j).expect("valid");
    }
    let doll = world.add_ragdoll(&jounce::RagdollDesc::human().at([0.0, -5.0, 3.0])).expect("valid");
    let head = *doll.bodies.last().expect("bones");
    let at = world.body(head).expect("alive").center_of_mass();
    world.grab(head, at, jounce::SpringDesc::hertz(4.0, 1.0), 3000.0).expect("valid");
    let mut add = |d| world.add_body(d).expect("valid");
    let mut drum = BodyDesc::kinematic().angular_velocity([0.0, 0.0, 1.0]);
    for k in 0..8 {
        let turn = Quat::from_axis_angle(Vec3::Z, k as f32 * core::f32::consts::FRAC_PI_4);
        let wall = ShapeDesc::cuboid([1.4, 0.2, 2.0]).at(turn.rotate(Vec3::new(0.0, -3.0, 0.0)));
        drum = drum.shape(wall.rotated(turn));
    }
    for z in [-2.2, 2.2] {
        drum = drum.shape(ShapeDesc::cuboid([4.0, 4.0, 0.2]).at([0.0, 0.0, z]));
    }
    add(drum);
    for i in 0..60 {
        let at =
            [f64::from(i % 5) * 0.6 - 1.2, f64::from(i / 20) * 0.6 - 1.2, f64::from(i / 5 % 4) * 0.8 - 1.2];
        let shape = match i % 4 {
            0 => ShapeDesc::sphere(0.3).restitution(0.6).hit_events(true),
            1 => ShapeDesc::capsule(0.2, 0.2),
            2 => ShapeDesc::cylinder(0.25, 0.3),
            _ => ShapeDesc::cuboid([0.3, 0.2, 0.4]),
        };
        add(BodyDesc::dynamic().at(at).rotated(rng.quat()).bullet(i % 7 == 0).shape(shape));
    }
    add(BodyDesc::fixed().shape(ShapeDesc::cuboid([1.0, 1.0, 1.0]).at([0.0, -2.0, 0.0]).sensor()));
    let corner = |i: u32, j: u32| Vec3::new(i as f32 - 6.0, 0.3 * ((i * j) % 3) as f32, j as f32 - 6.0);
    let corners: Vec<Vec3> = (0..13).flat_map(|j| (0..13).map(move |i| corner(i, j))).collect();
    let cell = |a: u32| [[a, a + 13, a + 1], [a + 1, a + 13, a + 14]];
    let triangles: Vec<_> = (0..12).flat_map(|j| (0..12).flat_map(move |i| cell(13 * j + i))).collect();
    let floor = TriMesh::new(&corners, &triangles, TriMeshOptions::default()).expect("a bumpy floor");
    add(BodyDesc::fixed().at([0.0, -6.0, 0.0]).shape(ShapeDesc::mesh(Arc::new(floor))));
    for i in 0..8 {
        let at = [f64::from(i) - 4.0, -4.0, 0.3];
        add(BodyDesc::dynamic().at(at).rotated(rng.quat()).shape(ShapeDesc::cuboid([0.6, 0.2, 0.5])));
    }
    let turbulence = jounce::Turbulence { speed: 1.0, size: 0.5, time_s: 0.5, seed: 1 };
    let c = ParticleCollision { hit_events: true, ..ParticleCollision::default() };
    let d =
        EmitterDesc::new().at([0.0, 0.0, 0.5]).rate(2000.0).spread(2.0).lifetime(0.5, 2.0).linear_drag(0.3);
    world.add_emitter(d.turbulence(turbulence).collision(c)).expect("valid");
    for (i, at) in [[-3.0, -5.2, -3.0], [3.0, -5.2, -3.0], [0.0, -5.2, 4.0]].into_iter().enumerate() {
        let d = jounce::CharacterDesc::at(at);
        let c = world.add_character(if i == 2 { d.dynamic() } else { d }).expect("valid");
        let walk = jounce::CharacterInput::walk([0.3, 0.0, 0.2 * (i as f32 - 1.0)]);
        world.set_character_input(c, walk).expect("alive");
    }
    world
}

/// Kicks what sleeps on the floor now and then, without a command's box.
fn kick(world: &mut World, bodies: &[BodyId], step: usize) {
    if step.is_multiple_of(60) {
        for &b in &bodies[bodies.len() - 11..bodies.len() - 3] {
            world.set_velocity(b, Vec3::new(0.0, 2.0, 0.0)).expect("alive");
        }
    }
}

/// Returns when every thread of a pool has started: starting one allocates.
fn meet(tasks: &Tasks) {
    let begun = AtomicUsize::new(0);
    tasks.run(tasks.threads(), &|_| {
        begun.fetch_add(1, Ordering::SeqCst);
        while begun.load(Ordering::SeqCst) < tasks.threads() {
            std::thread::yield_now();
        }
    });
}

/// One test, so that nothing else runs and allocates meanwhile.
#[test]
fn a_step_allocates_nothing() {
    for tasks in [Tasks::serial(), Tasks::pool(2)] {
        meet(&tasks);
        let mut world = world();
        world.set_tasks(tasks.clone());
        let bodies: Vec<BodyId> = world.bodies().collect();
        for step in 0..3000 {
            kick(&mut world, &bodies, step);
            world.step().expect("steps");
        }
        // A pile's peaks grow ever more rarely, but for ever: a list that meets a new one grows. What a step allocates
        // as a matter of course would show in every window.
        let mut by_stage = ByStage { last: 0, counts: [0; Stage::ALL.len()] };
        let (mut events, mut steps) = (0, 1);
        for _ in 0..WINDOWS {
            by_stage.counts = [0; Stage::ALL.len()];
            (events, steps) = (0, 0);
            for step in 0..300 {
                kick(&mut world, &bodies, step);
                let before = ALLOCATIONS.load(Ordering::SeqCst);
                by_stage.last = before;
                world.step_observed(&mut by_stage).expect("steps");
                steps += usize::from(ALLOCATIONS.load(Ordering::SeqCst) > before);
                events += world.events().len();
            }
            if steps == 0 {
                break;
            }
        }
        assert!(events > 300, "contacts come and go: {events} events");
        let named: Vec<_> =
            Stage::ALL.iter().map(|s| s.name()).zip(by_stage.counts).filter(|c| c.1 > 0).collect();
        assert_eq!(
            steps,
            0,
            "steps of 300 that allocate, on {} threads; by stage: {named:?}",
            tasks.threads()
        );
    }
}
