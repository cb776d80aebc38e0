//! Conserved quantities, dissipation, spins, and distance from the origin. `JOUNCE_PROVE=1` for full counts.

mod common;

use common::rng::Rng;
use jounce::math::scalar::f64s::max;
use jounce::math::{DVec3, Mat3};
use jounce::prelude::*;
use jounce::{Settings, Stage, StageObserver};

fn weightless() -> WorldDesc {
    WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }
}

fn add(world: &mut World, d: BodyDesc) -> BodyId {
    world.add_body(d).expect("valid")
}

/// Σ over the bodies of |m v| and of |c| |m v| + |I ω|: what roundings of the momenta are relative to.
fn scale(world: &World) -> (f64, f64) {
    let (mut p, mut l) = (0.0, 0.0);
    for b in world.bodies().filter_map(|id| world.body(id).ok()) {
        let mv = f64::from(b.mass()) * f64::from(b.velocity().length());
        p += mv;
        l += b.center_of_mass().length() * mv
            + f64::from((b.mass_properties().inertia * b.angular_velocity()).length());
    }
    (p, l)
}

/// Bodies that fly into one another, with restitution and friction, and nothing outside.
fn swarm() -> World {
    let (mut world, mut rng) = (World::new(weightless()).expect("valid"), Rng::new(31));
    for i in 0..40 {
        let at = rng.vec3(2.5);
        let shape = match i % 4 {
            0 => ShapeDesc::sphere(0.4),
            1 => ShapeDesc::cuboid([0.4, 0.3, 0.5]),
            2 => ShapeDesc::capsule(0.4, 0.2),
            _ => ShapeDesc::cylinder(0.3, 0.3),
        };
        let shape = shape.density(rng.decades(2.0, 4.0)).restitution(rng.float(0.0, 0.9));
        let d = BodyDesc::dynamic().at(at.as_dvec3()).rotated(rng.quat()).shape(shape);
        add(&mut world, d.velocity(at * -1.5 + rng.vec3(1.0)).angular_velocity(rng.vec3(3.0)));
    }
    world
}

/// An impulse acts on both bodies with the same bits, each then rounds its own velocity: per step and body at most
/// rounds × ε/2 of its momentum, with about 4 × (2 solves + gyroscopic) roundings per contact and substep, ~20 contacts per body:
/// 4 × 3 × 20 ε/2 ≈ 120 ε. As roundings are independent, the sum over 40 bodies stays below 30 ε of Σ|m v|.
#[test]
fn an_isolated_swarm_keeps_its_linear_momentum() {
    let mut world = swarm();
    let bound = 30.0 * f64::from(f32::EPSILON);
    let mut touched = 0;
    let mut worst = 0.0_f64;
    for _ in 0..600 {
        let (before, size) = (world.momentum(), scale(&world));
        world.step().expect("steps");
        touched += world.counts().touching;
        let (after, size) = (world.momentum(), max(size.0, scale(&world).0));
        worst = max(worst, (after.linear - before.linear).length() / size);
    }
    println!("Σp: worst step {worst:e}, bound {bound:e}");
    assert!(worst <= bound, "Σp changed by {worst:e} of Σ|p| in a step, bound {bound:e}");
    assert!(touched > 1000, "{touched} contacts in 600 steps");
}

/// A bound as for Σp; c × m v adds a rounding of its own.
#[test]
#[ignore = "misses: 4e-3 of Σ|L| in the worst step. Levers stay where they were at the start of a step while the bodies pass each other \
            (6 m/s × 1/60 s = 0.1 m against a radius of 0.4 m), so an impulse's two moments differ by that motion"]
fn an_isolated_swarm_keeps_its_angular_momentum() {
    let mut world = swarm();
    let bound = 100.0 * f64::from(f32::EPSILON);
    let mut worst = 0.0_f64;
    for _ in 0..600 {
        let (before, size) = (world.momentum(), scale(&world));
        world.step().expect("steps");
        let (after, size) = (world.momentum(), max(size.1, scale(&world).1));
        worst = max(worst, (after.angular - before.angular).length() / size);
    }
    println!("ΣL: worst step {worst:e}, bound {bound:e}");
    assert!(worst <= bound, "ΣL changed by {worst:e} of Σ|L| in a step, bound {bound:e}");
}

/// What overlaps is pushed out at `push_out_speed` at most: in a step this lifts a weight by no more than that speed × Δt.
#[test]
fn a_dissipative_pile_never_gains_energy() {
    let (mut world, mut rng) = (World::new(WorldDesc::default()).expect("valid"), Rng::new(32));
    add(&mut world, BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)));
    let mut weight = 0.0;
    for i in 0..60 {
        let at = [rng.double(-1.0, 1.0), 1.0 + 0.6 * f64::from(i), rng.double(-1.0, 1.0)];
        let shape = if i % 2 == 0 { ShapeDesc::cuboid([0.3; 3]) } else { ShapeDesc::cuboid([0.2, 0.3, 0.4]) };
        let id = add(&mut world, BodyDesc::dynamic().at(at).rotated(rng.quat()).shape(shape));
        weight += 9.81 * f64::from(world.body(id).expect("alive").mass());
    }
    let first = world.energy().total();
    let lift = weight * f64::from(world.settings().push_out_speed) * world.dt();
    let mut worst = f64::MIN;
    for step in 0..900 {
        let before = world.energy().total();
        world.step().expect("steps");
        let gain = world.energy().total() - before;
        worst = max(worst, gain);
        assert!(gain <= lift, "step {step}: gained {gain} J, pushing out lifts at most {lift}");
    }
    println!("largest gain {worst} J of {first} J; pushing out allows {lift} a step");
    let end = world.energy();
    assert!(end.total() < first && end.kinetic < 1e-3 * first, "from {first} J to {end:?}");
}

/// |L| of a free spin drifts by at most 1e-4 over the run.
fn spin(name: &str, inertia: Vec3, w: Vec3) {
    let steps = if common::prove() { 1_000_000 } else { 20_000 };
    let mut world = World::new(WorldDesc {
        settings: Settings { sleep: false, rotation_per_step_max: 1.5, ..Settings::default() },
        ..weightless()
    })
    .expect("valid");
    let mass = jounce::geometry::MassProperties {
        mass: 1.0,
        center: Vec3::ZERO,
        inertia: Mat3::from_diagonal(inertia),
    };
    let mut d = BodyDesc::dynamic().mass(mass).angular_velocity(w).can_sleep(false);
    d.fast_rotation = true;
    let id = add(&mut world, d);
    let start = world.momentum().angular;
    let energy = world.energy().kinetic;
    let (mut length, mut turned) = (0.0_f64, 0.0_f64);
    for _ in 0..steps {
        world.step().expect("steps");
        let l = world.momentum().angular;
        length = max(length, (l.length() / start.length() - 1.0).abs());
        turned = max(turned, (l - start).length() / start.length());
    }
    let e = world.energy().kinetic / energy - 1.0;
    println!("{name}: {steps} steps: |L| drifts {length:e}, L turns {turned:e}, energy {e:e}");
    assert!(length <= 1e-4, "{name}: |L| drifted by {length:e} in {steps} steps");
    assert!(world.body(id).expect("alive").is_enabled());
}

#[test]
fn an_asymmetric_box_keeps_its_angular_momentum() {
    spin(
        "box 1 × 2 × 3, about the middle axis",
        Vec3::new(13.0, 10.0, 5.0) / 12.0,
        Vec3::new(0.01, 2.0, 0.01),
    );
}

#[test]
fn a_thin_rod_keeps_its_angular_momentum() {
    spin("rod, tumbling and rolling", Vec3::new(1.0, 1e-3, 1.0), Vec3::new(2.0, 8.0, 0.5));
}

#[test]
fn a_top_keeps_its_angular_momentum() {
    spin("top, nutating", Vec3::new(0.6, 1.0, 0.6), Vec3::new(0.8, 20.0, 0.3));
}

/// Steps until a stack of ten boxes, dropped a little, is asleep; and how far its top is from where it should be.
fn stack_sleeps(origin: DVec3) -> (usize, f64) {
    let mut world = World::new(WorldDesc::default()).expect("valid");
    add(&mut world, BodyDesc::fixed().at(origin).shape(ShapeDesc::cuboid([10.0, 1.0, 10.0])));
    let mut last = None;
    for i in 0..10 {
        let at = origin + DVec3::new(0.0, 1.52 + 1.02 * f64::from(i), 0.0);
        last = Some(add(&mut world, BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid([0.5; 3]))));
    }
    let top = last.expect("ten boxes");
    for step in 0..1200 {
        world.step().expect("steps");
        if world.counts().awake == 0 {
            let at = world.body(top).expect("alive").position();
            return (step + 1, at.distance(origin + DVec3::new(0.0, 10.5, 0.0)));
        }
    }
    (1200, f64::NAN)
}

#[test]
fn a_stack_far_away_sleeps_as_soon_as_at_the_origin() {
    let (near, off) = stack_sleeps(DVec3::ZERO);
    assert!(near < 600 && off < 0.05, "at the origin: {near} steps, the top is {off} m off");
    for far in [1e4, 1e6, 1e7] {
        let (steps, off) = stack_sleeps(DVec3::new(far, -0.4 * far, 0.7 * far));
        println!("{far:e} m: {steps} steps against {near}, the top {off} m off");
        let apart = steps.abs_diff(near) as f64 / near as f64;
        assert!(apart <= 0.05 && off < 0.05, "{far:e} m: {steps} steps against {near}, the top {off} m off");
    }
}

struct Work(usize);

impl StageObserver for Work {
    fn after(&mut self, stage: Stage, world: &World) {
        if stage == Stage::NarrowPhase {
            self.0 = self.0.max(world.counts().contacts);
        }
    }
}

/// A dense heap: the pairs of a body are bounded by how many bodies fit around it (12 touch, their neighbours' bounds may overlap
/// too: 26), so pairs stay below 26/2 per body plus its ground.
#[test]
fn the_work_of_a_step_is_bounded() {
    let (mut world, mut rng) = (World::new(WorldDesc::default()).expect("valid"), Rng::new(33));
    add(&mut world, BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)));
    for side in [Vec3::X, -Vec3::X, Vec3::Z, -Vec3::Z] {
        add(&mut world, BodyDesc::fixed().shape(ShapeDesc::half_space(side).at(side * -1.5)));
    }
    let n = 150;
    for i in 0..n {
        let at = [rng.double(-1.0, 1.0), 0.5 + 0.2 * f64::from(i), rng.double(-1.0, 1.0)];
        add(&mut world, BodyDesc::dynamic().at(at).rotated(rng.quat()).shape(ShapeDesc::cuboid([0.25; 3])));
    }
    let mut work = Work(0);
    for step in 0..600 {
        world.step_observed(&mut work).expect("steps");
        let pairs = work.0;
        assert!(pairs <= 13 * n as usize + 5 * n as usize, "step {step}: {pairs} pairs of {n} bodies");
    }
    println!("{} pairs of {n} bodies at most", work.0);
}
