//! Particles from outside: closed forms, conserved quantities, bounds, bad input.

use jounce::math::scalar::f64s;
use jounce::prelude::*;
use jounce::{
    Burst, Command, EmitDirection, Error, HitResponse, Output, ParticleSpawn, ParticleView, Turbulence, Width,
};
use std::sync::Arc;

const DT: f64 = 1.0 / 60.0;

fn empty() -> World {
    World::new(WorldDesc::default()).expect("valid")
}

fn weightless() -> World {
    World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).expect("valid")
}

fn floor(world: &mut World) -> BodyId {
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).expect("valid")
}

fn spawn(position: [f64; 3], velocity: [f32; 3]) -> ParticleSpawn {
    ParticleSpawn {
        position: position.into(),
        velocity: velocity.into(),
        lifetime_s: 1e3,
        mass: 0.01,
        radius: 0.05,
    }
}

/// An emitter with one particle.
fn one(world: &mut World, desc: EmitterDesc, s: ParticleSpawn) -> EmitterId {
    let e = world.add_emitter(desc).expect("valid");
    world.emit_particles(e, vec![s]).expect("valid");
    e
}

fn only(world: &World) -> ParticleView {
    let mut all = world.particles();
    let p = all.next().expect("a particle");
    assert!(all.next().is_none());
    p
}

fn steps(world: &mut World, n: usize) {
    for _ in 0..n {
        world.step().expect("steps");
    }
}

/// Semi-implicit Euler gives v_n = v₀ + g n h and x_n = x₀ + v₀ t + g t (t + h)/2 exactly; f32 rounding is what is left:
/// 2⁻²⁴ of the position a step.
#[test]
fn flight_is_that_of_the_integrator() {
    let mut world = empty();
    one(&mut world, EmitterDesc::new(), spawn([0.0, 1.0, 0.0], [3.0, 20.0, -1.0]));
    for n in 1..=120u32 {
        world.step().expect("steps");
        let t = f64::from(n) * DT;
        let p = only(&world);
        let y = 1.0 + 20.0 * t - 9.81 * t * (t + DT) / 2.0;
        let expected = DVec3::new(3.0 * t, y, -t);
        assert!((p.position - expected).length() < 1e-5 * f64::from(n), "{n}: {} {expected:?}", p.position.y);
        assert!((f64::from(p.velocity.y) - (20.0 - 9.81 * t)).abs() < 1e-5 * f64::from(n));
        assert!((f64::from(p.age) - t).abs() < 1e-5);
    }
}

#[test]
fn rate_times_time_is_the_number_born() {
    for (rate, delay) in [(100.0, 0.0), (7.0, 0.0), (1000.0, 0.25), (59.94, 0.0), (0.3, 0.1)] {
        let mut world = weightless();
        let mut d = EmitterDesc::new().rate(rate).lifetime(100.0, 100.0);
        d.delay_s = delay;
        let e = world.add_emitter(d).expect("valid");
        for n in 1..=600u32 {
            world.step().expect("steps");
            let time = f64::from(n) / 60.0 - delay;
            let expected = (rate * f64s::max(time, 0.0) + 1e-9).floor() as u64;
            assert_eq!(world.emitter(e).expect("alive").born(), expected, "{rate} {delay} {n}");
        }
    }
}

/// At 1000 a second and 2 m/s without gravity, particles fly 2 mm apart, whatever the steps: also across their ends.
#[test]
fn births_within_a_step_are_evenly_spaced() {
    let mut world = weightless();
    let e =
        world.add_emitter(EmitterDesc::new().rate(1000.0).speed(2.0, 2.0).lifetime(9.0, 9.0)).expect("valid");
    steps(&mut world, 30);
    let y: Vec<f64> = world.emitter(e).expect("alive").particles().map(|p| p.position.y).collect();
    assert_eq!(y.len(), 500);
    for w in y.windows(2) {
        assert!((w[0] - w[1] - 0.002).abs() < 1e-6, "{w:?}");
    }
    assert!(y[499].abs() < 1e-6, "the last is born at the very end");
}

#[test]
fn bursts_come_at_their_times_and_recur() {
    let mut world = weightless();
    let d = EmitterDesc { looping: true, ..EmitterDesc::new().burst(0.0, 5).burst(0.31, 2).timing(0.1, 0.5) };
    let e = world.add_emitter(EmitterDesc { lifetime_s: [99.0, 99.0], ..d }).expect("valid");
    // Starts at 0.1, 0.6, 1.1 and 1.6 s, and 0.41, 0.91, 1.41 and 1.91 s.
    for (step, born) in [(5, 0), (7, 5), (24, 5), (25, 7), (37, 12), (55, 14), (120, 28)] {
        let so_far = world.step_count() as usize;
        steps(&mut world, step - so_far);
        assert_eq!(world.emitter(e).expect("alive").born(), born, "step {step}");
    }
    assert!(!world.emitter(e).expect("alive").is_finished());
}

#[test]
fn an_emitter_that_has_ended_says_so_once_and_goes() {
    let mut world = weightless();
    let d = EmitterDesc { auto_remove: true, ..EmitterDesc::new().burst(0.1, 10).lifetime(0.2, 0.2) };
    let e = world.add_emitter(d).expect("valid");
    let mut told = 0;
    for _ in 0..30 {
        world.step().expect("steps");
        told += world.events().iter().filter(|x| **x == Event::EmitterFinished { emitter: e }).count();
    }
    assert_eq!(told, 1);
    assert!(matches!(world.emitter(e), Err(Error::Stale { what: "emitter", .. })));
    assert_eq!((world.counts().emitters, world.counts().particles), (0, 0));
}

/// The apexes over the floor fall by K_r² a bounce. The way between two places is taken straight, so a bounce is up to
/// g h²/8 = 0.3 mm off in height, and as much again in each that follows.
#[test]
fn bounce_heights_follow_k_r() {
    for restitution in [0.5, 0.8, 1.0] {
        let mut world = empty();
        floor(&mut world);
        let c = ParticleCollision { restitution, friction: 0.0, ..ParticleCollision::default() };
        one(&mut world, EmitterDesc::new().collision(c), spawn([0.0, 2.05, 0.0], [0.0; 3]));
        let mut apexes = Vec::new();
        let mut y = [2.05, 2.05];
        for _ in 0..600 {
            world.step().expect("steps");
            let now = only(&world).position.y;
            if y[0] < y[1] && y[1] >= now {
                // The parabola through three places.
                let (a, b) = ((y[0] + now) * 0.5 - y[1], (now - y[0]) * 0.5);
                apexes.push(y[1] - b * b / (4.0 * a) - 0.05);
            }
            y = [y[1], now];
        }
        let mut height = 2.0;
        for (i, apex) in apexes.iter().take(5).enumerate() {
            height *= f64::from(restitution * restitution);
            // It starts with half a step's speed less than a stone, g h²/8.
            let tolerance = 0.0007 * (i + 1) as f64;
            assert!((apex - height).abs() < tolerance, "K_r {restitution}, {i}: {apex} {height}");
        }
        assert!(apexes.len() >= 3);
    }
}

/// The lecture's V_b = (1 − K_f) V_t − K_r V_n, without gravity to the digit.
#[test]
fn a_bounce_is_the_lectures() {
    let mut world = weightless();
    floor(&mut world);
    let c = ParticleCollision { restitution: 0.7, friction: 0.25, ..ParticleCollision::default() };
    one(&mut world, EmitterDesc::new().collision(c), spawn([0.0, 1.0, 0.0], [3.0, -2.0, 1.0]));
    steps(&mut world, 60);
    let v = only(&world).velocity;
    assert!((v - Vec3::new(2.25, 1.4, 0.75)).length() < 1e-5, "{v:?}");
}

#[test]
fn terminal_speed_is_exact() {
    // Linear: g/k.
    let mut world = empty();
    one(&mut world, EmitterDesc::new().linear_drag(4.0), spawn([0.0, 1000.0, 0.0], [0.0; 3]));
    steps(&mut world, 600);
    assert!((only(&world).velocity.y + 9.81 / 4.0).abs() < 1e-5);
    // However stiff, a velocity never turns round.
    let mut world = weightless();
    one(&mut world, EmitterDesc::new().linear_drag(1e6), spawn([0.0; 3], [5.0, 0.0, 0.0]));
    steps(&mut world, 3);
    let v = only(&world).velocity;
    assert!(v.x >= 0.0 && v.x < 1e-6, "{v:?}");
}

/// What particles lose the body gains: over a shower of 500 grains on a free block, to the roundings.
#[test]
fn pushes_conserve_momentum() {
    let mut world = weightless();
    let block = ShapeDesc::cuboid([0.5, 0.5, 0.5]).mass(2.0);
    let b = world.add_body(BodyDesc::dynamic().shape(block)).expect("valid");
    let c = ParticleCollision { push: true, restitution: 0.5, friction: 0.2, ..ParticleCollision::default() };
    let mut d = EmitterDesc::new().at([-2.0, 0.1, 0.05]).direction(EmitDirection::Along(Vec3::X));
    (d.spread, d.mass, d.lifetime_s, d.radius) = (0.2, 0.004, [99.0, 99.0], [0.01, 0.02]);
    world.add_emitter(d.burst(0.0, 500).speed(5.0, 8.0).collision(c)).expect("valid");
    let momentum = |w: &World| {
        let p = w.particles().fold(DVec3::ZERO, |p, x| p + x.velocity.as_dvec3() * f64::from(x.mass));
        p + w.momentum().linear
    };
    world.step().expect("steps");
    let before = momentum(&world);
    steps(&mut world, 60);
    let after = momentum(&world);
    assert!(world.body(b).expect("alive").velocity().x > 0.5, "it was pushed");
    assert!((after - before).length() < 1e-4, "{before:?} {after:?}");
}

/// A shower heavier than the body cannot make it faster than itself.
#[test]
fn many_hits_in_a_step_do_not_overshoot() {
    let mut world = weightless();
    let block = ShapeDesc::cuboid([0.5, 0.5, 0.5]).mass(0.1);
    // A body that spins may outrun what hits it off its centre.
    let block = BodyDesc { locks: AxisLocks::ROTATION, ..BodyDesc::dynamic().shape(block) };
    let b = world.add_body(block).expect("valid");
    let c = ParticleCollision { push: true, restitution: 0.0, friction: 0.0, ..ParticleCollision::default() };
    let mut d = EmitterDesc::new().at([-1.0, 0.0, 0.0]).direction(EmitDirection::Along(Vec3::X));
    d.shape = EmitterShape::Box { half: Vec3::new(0.0, 0.3, 0.3) };
    (d.mass, d.lifetime_s) = (0.1, [99.0, 99.0]);
    world.add_emitter(d.burst(0.0, 1000).speed(5.0, 5.0).collision(c)).expect("valid");
    for _ in 0..60 {
        world.step().expect("steps");
        assert!(world.body(b).expect("alive").velocity().length() < 5.01);
    }
    assert!(world.body(b).expect("alive").velocity().x > 4.5);
}

#[test]
fn a_push_wakes_a_sleeping_body() {
    let mut world = empty();
    floor(&mut world);
    let b = world
        .add_body(BodyDesc::dynamic().at([0.0, 0.5, 0.0]).shape(ShapeDesc::cuboid([0.5; 3]).mass(1.0)))
        .expect("valid");
    steps(&mut world, 120);
    assert!(!world.body(b).expect("alive").is_awake());
    let c = ParticleCollision { push: true, ..ParticleCollision::default() };
    one(
        &mut world,
        EmitterDesc::new().collision(c),
        ParticleSpawn { mass: 0.2, ..spawn([-3.0, 1.0, 0.0], [9.0, 1.0, 0.0]) },
    );
    let mut woke = false;
    for _ in 0..60 {
        world.step().expect("steps");
        woke |= world.events().contains(&Event::Wake { body: b });
    }
    assert!(woke && world.body(b).expect("alive").position().x > 0.01);
}

#[test]
fn particles_stick_and_ride() {
    let mut world = weightless();
    let lift = BodyDesc::kinematic().velocity([0.0, 1.0, 0.0]).angular_velocity([0.0, 0.5, 0.0]);
    let b = world.add_body(lift.shape(ShapeDesc::cuboid([1.0, 0.1, 1.0]))).expect("valid");
    let c = ParticleCollision { response: HitResponse::Stick, ..ParticleCollision::default() };
    one(&mut world, EmitterDesc::new().collision(c), spawn([0.5, 1.0, 0.0], [0.0, -3.0, 0.0]));
    steps(&mut world, 60);
    let local = |w: &World| {
        let pose = w.body(b).expect("alive").pose();
        pose.inverse_transform_point(only(w).position)
    };
    let at = local(&world);
    assert!((at.y - 0.15).abs() < 1e-3, "{at:?}");
    steps(&mut world, 120);
    // f32 rounding of 120 carries.
    assert!((local(&world) - at).length() < 1e-4, "{:?} {at:?}", local(&world));
    world.remove_body(b).expect("alive");
    let v = only(&world).velocity;
    steps(&mut world, 1);
    assert_eq!(only(&world).velocity, v, "let go with the velocity it had");
}

#[test]
fn fast_particles_do_not_pass_thin_things() {
    let mut world = weightless();
    let corners = [[-2.0, -2.0], [2.0, -2.0], [0.0, 3.0]].map(|[y, z]| Vec3::new(2.0, y, z));
    let mesh =
        jounce::geometry::TriMesh::new(&corners, &[[0, 1, 2]], Default::default()).expect("a triangle");
    let shapes = [
        ShapeDesc::mesh(Arc::new(mesh)),
        ShapeDesc::cuboid([1e-3, 1.0, 1.0]).at([2.0, 0.0, 0.0]),
        ShapeDesc::cylinder(1.0, 1e-3).at([2.0, 0.0, 0.0]),
        ShapeDesc::sphere(0.01).at([2.0, 0.0, 0.0]),
    ];
    for shape in shapes {
        let name = shape.shape.name();
        let b = world.add_body(BodyDesc::fixed().shape(shape)).expect("valid");
        let c = ParticleCollision { restitution: 1.0, friction: 0.0, ..ParticleCollision::default() };
        let s = ParticleSpawn { radius: 0.002, ..spawn([0.0, 0.0, 0.0], [900.0, 0.0, 0.0]) };
        let e = one(&mut world, EmitterDesc::new().collision(c), s);
        steps(&mut world, 2);
        let p = only(&world);
        assert!(p.velocity.x < 0.0, "{name}: {:?}", p.velocity);
        world.remove_emitter(e).expect("alive");
        world.remove_body(b).expect("alive");
    }
}

#[test]
fn particles_rest_on_what_they_fall_on() {
    let mut world = empty();
    floor(&mut world);
    let tilt = Quat::from_axis_angle(Vec3::Z, 0.3);
    world
        .add_body(
            BodyDesc::fixed().at([3.0, 0.0, 0.0]).rotated(tilt).shape(ShapeDesc::cuboid([1.0, 0.5, 1.0])),
        )
        .expect("valid");
    let lift = BodyDesc::kinematic().at([-3.0, 0.0, 0.0]).velocity([0.0, 0.5, 0.0]);
    world.add_body(lift.shape(ShapeDesc::cuboid([1.0, 0.5, 1.0]))).expect("valid");
    let c = ParticleCollision { restitution: 0.2, friction: 0.3, ..ParticleCollision::default() };
    let e = world.add_emitter(EmitterDesc::new().collision(c)).expect("valid");
    let at = [[0.0, 1.0, 0.0], [-3.0, 3.0, 0.0], [5.0, 1.0, 0.0]];
    world.emit_particles(e, at.map(|p| spawn(p, [0.0; 3])).to_vec()).expect("valid");
    steps(&mut world, 300);
    let p: Vec<ParticleView> = world.particles().collect();
    assert!((p[0].position.y - 0.05).abs() < 1e-3 && p[0].velocity.length() < 1e-3, "{:?}", p[0]);
    assert!((p[1].position.y - 3.05).abs() < 2e-3 && (p[1].velocity.y - 0.5).abs() < 1e-3, "{:?}", p[1]);
    assert!((p[2].position.y - 0.05).abs() < 1e-3, "{:?}", p[2]);
}

#[test]
fn hits_are_told_and_killers_kill() {
    let mut world = empty();
    let ground = floor(&mut world);
    let shape = world.body(ground).expect("alive").shapes().next().expect("one");
    let c =
        ParticleCollision { response: HitResponse::Kill, hit_events: true, ..ParticleCollision::default() };
    let e = one(&mut world, EmitterDesc::new().collision(c), spawn([0.0, 1.05, 0.0], [2.0, 0.0, 0.0]));
    let mut hits = Vec::new();
    for _ in 0..60 {
        world.step().expect("steps");
        hits.extend(world.events().iter().copied().filter(|e| matches!(e, Event::ParticleHit { .. })));
    }
    let [Event::ParticleHit { emitter, shape: s, point, normal, speed }] = hits[..] else {
        panic!("{hits:?}")
    };
    assert_eq!((emitter, s, normal), (e, shape, Vec3::Y));
    // √(2 g · 1 m) = 4.43 m/s, half a step's g h early.
    assert!((speed - 4.43).abs() < 0.1 && point.y.abs() < 1e-4, "{speed} {point:?}");
    assert!(world.emitter(e).expect("alive").is_empty());
}

#[test]
fn hooks_and_bounds_kill() {
    let mut world = weightless();
    let d = EmitterDesc { kill_hook: Some("far".into()), ..EmitterDesc::new() };
    let e = one(&mut world, d, spawn([0.0; 3], [1.0, 0.0, 0.0]));
    steps(&mut world, 90);
    assert_eq!(world.emitter(e).expect("alive").len(), 1, "no such hook yet");
    world.set_particle_hook("far", Some(Arc::new(|p: &ParticleView| p.position.x > 2.0)));
    steps(&mut world, 28);
    assert_eq!(world.emitter(e).expect("alive").len(), 1);
    steps(&mut world, 5);
    assert_eq!(world.emitter(e).expect("alive").len(), 0);
    let d = EmitterDesc { kill_below: Some(-1.0), ..EmitterDesc::new() };
    let e = one(&mut world, d, spawn([0.0; 3], [0.0, -1.0, 0.0]));
    steps(&mut world, 59);
    assert_eq!(world.emitter(e).expect("alive").len(), 1);
    steps(&mut world, 2);
    assert!(world.emitter(e).expect("alive").is_empty());
    assert_eq!(world.emitter(e).expect("alive").lost(), 0, "it was to die there");
}

/// The same shower a thousand kilometres away looks the same, to what f64 of the place and f32 of the rest leave.
#[test]
fn far_away_is_as_good_as_here() {
    let run = |at: DVec3| {
        let mut world = empty();
        world.add_body(BodyDesc::fixed().at(at).shape(ShapeDesc::half_space(Vec3::Y))).expect("valid");
        let ball = BodyDesc::fixed().at(at + DVec3::new(0.5, 0.3, 0.0)).shape(ShapeDesc::sphere(0.3));
        world.add_body(ball).expect("valid");
        let c = ParticleCollision { restitution: 0.5, ..ParticleCollision::default() };
        let d = EmitterDesc::new().at(at + DVec3::new(0.0, 1.0, 0.0)).rate(200.0).spread(0.8).speed(1.0, 3.0);
        world.add_emitter(d.lifetime(1.0, 3.0).collision(c)).expect("valid");
        steps(&mut world, 90);
        world.particles().map(|p| p.position - at).collect::<Vec<DVec3>>()
    };
    let (here, there) = (run(DVec3::ZERO), run(DVec3::new(1e6, -1e6, 0.5e6)));
    assert_eq!(here.len(), there.len());
    let off = here.iter().zip(&there).map(|(a, b)| (*a - *b).length());
    // A few graze the ball, and part there.
    let apart = off.filter(|&d| d > 1e-4).count();
    assert!(apart * 50 < here.len(), "{apart} of {}", here.len());
}

/// Births lie on the line that a moving emitter draws, at their times, and a passenger's speed is added.
#[test]
fn an_emitter_rides_on_a_body() {
    let mut world = weightless();
    let car = BodyDesc::dynamic().velocity([10.0, 0.0, 0.0]).shape(ShapeDesc::cuboid([0.5, 0.2, 0.3]));
    let b = world.add_body(car).expect("valid");
    let mut d = EmitterDesc::new().on(b).at([0.0, 1.0, 0.0]).rate(600.0).speed(0.0, 0.0).lifetime(9.0, 9.0);
    d.inherit_velocity = 0.0;
    let trail = world.add_emitter(d.clone()).expect("valid");
    let smoke = world.add_emitter(EmitterDesc { inherit_velocity: 1.0, ..d }).expect("valid");
    steps(&mut world, 30);
    let x: Vec<f64> = world.emitter(trail).expect("alive").particles().map(|p| p.position.x).collect();
    assert_eq!(x.len(), 300);
    for w in x.windows(2) {
        assert!((w[1] - w[0] - 10.0 / 600.0).abs() < 1e-5, "{w:?}");
    }
    for p in world.emitter(smoke).expect("alive").particles() {
        assert!((p.position.x - 5.0).abs() < 1e-4 && (p.velocity.x - 10.0).abs() < 1e-4, "{p:?}");
    }
    world.remove_body(b).expect("alive");
    steps(&mut world, 1);
    assert!(world.events().contains(&Event::EmitterFinished { emitter: trail }));
    steps(&mut world, 5);
    assert_eq!(world.emitter(trail).expect("alive").born(), 300);
}

#[test]
fn an_emitter_may_go_far_from_where_it_began() {
    let mut world = weightless();
    let settings = jounce::Settings { linear_speed_max: 1e5, ..Default::default() };
    world.set_settings(settings).expect("valid");
    let rocket = BodyDesc::dynamic().velocity([3e4, 0.0, 0.0]).shape(ShapeDesc::sphere(0.5));
    let b = world.add_body(rocket).expect("valid");
    let d = EmitterDesc::new().on(b).rate(120.0).speed(1.0, 1.0).lifetime(0.5, 0.5);
    let e = world.add_emitter(d).expect("valid");
    steps(&mut world, 300);
    let x = world.body(b).expect("alive").position().x;
    assert!(x > 1e5);
    for p in world.emitter(e).expect("alive").particles() {
        assert!((p.position.x - x).abs() < 1e-2 && p.position.y <= 0.5 + 1e-3, "{p:?} {x}");
    }
}

#[test]
fn what_there_is_no_room_for_is_told() {
    let mut world = weightless();
    let d = EmitterDesc::new().rate(1e7).lifetime(10.0, 10.0).max_particles(1000);
    let e = world.add_emitter(d).expect("valid");
    world.step().expect("steps");
    assert_eq!(world.emitter(e).expect("alive").len(), 1000);
    assert!(world.events().contains(&Event::LimitReached { what: "particles" }));
    world.emit_burst(e, 5).expect("told, not refused");
    let there = world.emitter(e).expect("alive");
    assert_eq!((there.born(), there.unborn()), (1000, 166_666 - 1000 + 5), "only what lived was born");
    assert_eq!(world.counts().particles, 1000);
    let refused = world.emit_particles(e, vec![spawn([0.0; 3], [0.0; 3])]);
    assert!(matches!(refused, Err(Error::Limit { .. })));
    world.clear_particles(None).expect("all");
    assert_eq!(world.counts().particles, 0);
}

#[test]
fn bad_descriptions_are_refused() {
    let nan = f32::NAN;
    type Spoil = fn(&mut EmitterDesc);
    let spoils: &[(&str, Spoil)] = &[
        ("mass", |d| d.mass = -1.0),
        ("mass", |d| d.mass = 0.0),
        ("rate", |d| d.rate = 1e12),
        ("rate", |d| d.rate = f64::NAN),
        ("radius", |d| d.radius = [0.0, 0.0]),
        ("radius", |d| d.radius = [0.2, 0.1]),
        ("lifetime_s", |d| d.lifetime_s = [2.0, 1.0]),
        ("lifetime_s", |d| d.lifetime_s = [0.0, f32::INFINITY]),
        ("speed", |d| d.speed = [f32::NAN, 1.0]),
        ("spread", |d| d.spread = 4.0),
        ("direction", |d| d.direction = EmitDirection::Along(Vec3::ZERO)),
        ("position", |d| d.pose.p.x = f64::INFINITY),
        ("rotation", |d| d.pose.q.w = 3.0),
        ("bursts", |d| d.bursts = vec![Burst { time_s: 0.0, count: 1 }; 17]),
        ("burst.time_s", |d| d.bursts = vec![Burst { time_s: -1.0, count: 1 }]),
        ("delay_s", |d| d.delay_s = -1.0),
        ("duration_s", |d| d.duration_s = Some(0.0)),
        ("looping", |d| d.looping = true),
        ("max_particles", |d| d.max_particles = 0),
        ("max_particles", |d| d.max_particles = 1 << 30),
        ("linear_drag", |d| d.linear_drag = -1.0),
        ("size_over_life", |d| d.size_over_life.keys = vec![(0.5, 1.0), (0.2, 1.0)]),
        ("color_over_life", |d| d.color_over_life.keys = vec![(0.0, [f32::NAN; 4])]),
        ("turbulence.size", |d| {
            d.turbulence = Some(Turbulence { speed: 1.0, size: 0.0, time_s: 1.0, seed: 0 });
        }),
        ("collision.restitution", |d| {
            d.collision = Some(ParticleCollision { restitution: 1.5, ..Default::default() });
        }),
        ("kill_outside", |d| d.kill_outside = Some([DVec3::ONE, DVec3::ZERO])),
        ("radius of the sphere", |d| d.shape = EmitterShape::Sphere { radius: f32::NAN, surface: true }),
    ];
    let mut world = empty();
    let e = world.add_emitter(EmitterDesc::new()).expect("valid");
    let hash = world.hash();
    for (name, spoil) in spoils {
        let mut d = EmitterDesc::new();
        spoil(&mut d);
        for refused in [world.add_emitter(d.clone()).map(|_| ()), world.set_emitter(e, d)] {
            match refused {
                Err(Error::BadValue { what: "emitter", field, .. }) => assert_eq!(field, *name),
                other => panic!("{name}: {other:?}"),
            }
        }
    }
    let turbulence = Turbulence { speed: 1.0, size: 1.0, time_s: 1.0, seed: 0 };
    let d = EmitterDesc { drag_coefficient: 0.0, ..EmitterDesc::new().turbulence(turbulence) };
    assert!(matches!(world.add_emitter(d), Err(Error::Unsupported { .. })));
    for s in [
        ParticleSpawn { mass: -1.0, ..spawn([0.0; 3], [0.0; 3]) },
        ParticleSpawn { radius: nan, ..spawn([0.0; 3], [0.0; 3]) },
        ParticleSpawn { lifetime_s: 0.0, ..spawn([0.0; 3], [0.0; 3]) },
        spawn([f64::NAN; 3], [0.0; 3]),
        spawn([0.0; 3], [1e9; 3]),
    ] {
        assert!(world.emit_particles(e, vec![s]).is_err());
    }
    assert_eq!(world.hash(), hash, "refused commands change nothing");
    let b = world.add_body(BodyDesc::fixed()).expect("valid");
    world.remove_body(b).expect("alive");
    assert!(matches!(world.add_emitter(EmitterDesc::new().on(b)), Err(Error::Stale { what: "body", .. })));
    world.remove_emitter(e).expect("alive");
    for c in [
        Command::RemoveEmitter(e),
        Command::SetEmitterEnabled(e, true),
        Command::EmitBurst(e, 1),
        Command::EmitParticles(e, Vec::new()),
        Command::ClearParticles(Some(e)),
    ] {
        assert!(matches!(world.apply(c), Err(Error::Stale { what: "emitter", .. })));
    }
}

/// All widths and threads agree.
#[test]
fn widths_and_threads_agree() {
    let make = |width: Width, tasks: Tasks| {
        let mut world = empty();
        world.set_width(width);
        world.set_tasks(tasks);
        floor(&mut world);
        for i in 0..20 {
            let at = [f64::from(i % 5) - 2.0, 1.0 + f64::from(i / 5), 0.3];
            world
                .add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid([0.2, 0.3, 0.2])))
                .expect("valid");
        }
        let c = ParticleCollision { push: true, hit_events: true, ..ParticleCollision::default() };
        let turbulence = Turbulence { speed: 2.0, size: 0.7, time_s: 0.4, seed: 5 };
        let mut d = EmitterDesc::new().at([0.0, 3.0, 0.0]).rate(3000.0).spread(1.0).lifetime(0.3, 3.0);
        (d.linear_drag, d.heat) = (0.5, Some(jounce::Heat { excess: 300.0, ambient: 293.0, cooling_s: 0.7 }));
        let d = d.burst(0.5, 2000).turbulence(turbulence).collision(c);
        let out = world.apply(Command::AddEmitter(Box::new(d))).expect("valid");
        assert!(matches!(out, Output::Emitter(_)));
        (0..90)
            .map(|_| {
                world.step().expect("steps");
                world.hash()
            })
            .collect::<Vec<u64>>()
    };
    let reference = make(Width::X1, Tasks::serial());
    for width in Width::ALL {
        for tasks in [Tasks::pool(4), Tasks::chaos(7), Tasks::chaos_pool(3, 8)] {
            assert_eq!(make(width, tasks), reference, "{width:?}");
        }
    }
}

/// m g = ½ρ C_d π r² v² + 6πηr v in air, with the same root for the speed as the schoolbook's.
#[test]
fn terminal_speed_in_air_is_that_of_the_medium() {
    let mut world = empty();
    world.add_field(FieldDesc::air()).expect("valid");
    let s = ParticleSpawn { mass: 0.002, radius: 0.01, ..spawn([0.0, 5000.0, 0.0], [0.0; 3]) };
    one(&mut world, EmitterDesc::new(), s);
    steps(&mut world, 1200);
    let pi = core::f64::consts::PI;
    let (a, b, c) = (0.5 * 1.2 * 0.47 * pi * 1e-4, 6.0 * pi * 1.81e-5 * 0.01, 0.002 * 9.81);
    let expected = (-b + (b * b + 4.0 * a * c).sqrt()) / (2.0 * a);
    let got = -f64::from(only(&world).velocity.y);
    assert!((got / expected - 1.0).abs() < 1e-5, "{got} {expected}");
}

/// Particles with linear drag take the wind's speed, v = w (1 − 1/(1 + hk)ⁿ), here, there and in a region of its own.
#[test]
fn wind_carries_particles() {
    for within in [
        jounce::Region::Everywhere,
        jounce::Region::Box { center: DVec3::ZERO, half: DVec3::splat(1e3), falloff: 0.0 },
    ] {
        let mut world = weightless();
        world.add_field(FieldDesc::wind([4.0, 0.0, 0.0]).within(within)).expect("valid");
        let d = EmitterDesc { drag_coefficient: 0.0, ..EmitterDesc::new().linear_drag(2.0) };
        let s = ParticleSpawn { radius: 1e-6, ..spawn([0.0; 3], [0.0; 3]) };
        one(&mut world, d, s);
        steps(&mut world, 60);
        let expected = 4.0 * (1.0 - f64s::pow(1.0 + 2.0 / 60.0, -60.0));
        // Stokes' drag in the air that comes with the wind adds 6πηr/m = 3e-8 /s.
        assert!((f64::from(only(&world).velocity.x) - expected).abs() < 1e-4, "{:?}", only(&world));
    }
}

/// A bubble of a tenth of the water's density rises: m a = (ρ − ρ_b) V g at first; and a stone sinks by the same law.
#[test]
fn liquids_lift() {
    for density in [100.0f32, 2000.0] {
        let mut world = empty();
        world.add_field(FieldDesc::water(0.0)).expect("valid");
        let volume = 4.0 / 3.0 * core::f32::consts::PI * 0.05 * 0.05 * 0.05;
        let s = ParticleSpawn { mass: density * volume, radius: 0.05, ..spawn([0.0, -50.0, 0.0], [0.0; 3]) };
        one(&mut world, EmitterDesc { drag_coefficient: 0.0, ..EmitterDesc::new() }, s);
        steps(&mut world, 1);
        let a = only(&world).velocity.y * 60.0;
        let expected = 9.81 * (1000.0 / density - 1.0);
        assert!((a / expected - 1.0).abs() < 1e-3, "{a} {expected}");
    }
}

/// Δv = p (1 − d/R)² π r²/m, and nothing behind a wall.
#[test]
fn a_blast_throws_particles() {
    let mut world = weightless();
    let wall = ShapeDesc::cuboid([0.1, 2.0, 2.0]).at([-1.0, 0.0, 0.0]);
    world.add_body(BodyDesc::fixed().shape(wall)).expect("valid");
    let e = world.add_emitter(EmitterDesc::new()).expect("valid");
    let at = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 0.0, 5.0]];
    world.emit_particles(e, at.map(|p| spawn(p, [0.0; 3])).to_vec()).expect("valid");
    world.explode(Explosion::new(DVec3::ZERO, 4.0, 10.0)).expect("valid");
    let v: Vec<Vec3> = world.particles().map(|p| p.velocity).collect();
    let full = 10.0 * core::f32::consts::PI * 0.05 * 0.05 / 0.01;
    assert!((v[0] - Vec3::X * (full * 9.0 / 16.0)).length() < 1e-5, "{v:?}");
    assert!((v[1] - Vec3::Y * (full / 4.0)).length() < 1e-5, "{v:?}");
    assert_eq!(v[2..], [Vec3::ZERO; 2]);
}

/// Hot air rises: a = g ΔT/T at birth, and e^(−t/τ) of it later; with drag k it nears a/k.
#[test]
fn heat_lifts_and_cools() {
    let mut world = empty();
    let heat = jounce::Heat { excess: 100.0, ambient: 300.0, cooling_s: 2.0 };
    let d = EmitterDesc { gravity_scale: 0.0, heat: Some(heat), ..EmitterDesc::new() };
    one(&mut world, d, spawn([0.0; 3], [0.0; 3]));
    steps(&mut world, 120);
    // ∫ a e^(−t/τ) dt, by the right-hand rule of h = 1/60 s: off by h/2 of the first rate.
    let expected = 9.81 / 3.0 * 2.0 * (1.0 - jounce::math::scalar::f32s::exp(-1.0));
    assert!((only(&world).velocity.y - expected).abs() < 0.03, "{} {expected}", only(&world).velocity.y);
}

/// Every shape bears inside of itself and evenly: the mean of many is the middle.
#[test]
fn shapes_bear_evenly() {
    let corners = [[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vec3::from);
    let mesh =
        jounce::geometry::TriMesh::new(&corners, &[[0, 1, 2], [0, 2, 3]], Default::default()).expect("valid");
    // Areas 2 and 1, centroids (2/3, 0, 2/3) and (2/3, 1/3, 0).
    let middle = DVec3::new(2.0 / 3.0, 1.0 / 9.0, 4.0 / 9.0);
    let shapes = [
        (EmitterShape::Sphere { radius: 1.0, surface: false }, DVec3::ZERO, 0.6f64.sqrt()),
        (EmitterShape::Sphere { radius: 1.0, surface: true }, DVec3::ZERO, 1.0),
        (EmitterShape::Disc { radius: 1.0 }, DVec3::ZERO, 0.5f64.sqrt()),
        (EmitterShape::Box { half: Vec3::new(1.0, 2.0, 0.5) }, DVec3::ZERO, (5.25f64 / 3.0).sqrt()),
        (EmitterShape::Mesh(Arc::new(mesh)), middle, 0.0),
    ];
    for (shape, middle, rms) in shapes {
        let mut world = weightless();
        let name = format!("{shape:?}");
        let d = EmitterDesc::new().shape(shape).speed(0.0, 0.0).max_particles(20_000);
        let e = world.add_emitter(d).expect("valid");
        world.emit_burst(e, 20_000).expect("room");
        let n = 20_000.0;
        let mean = world.particles().fold(DVec3::ZERO, |s, p| s + p.position) * (1.0 / n);
        let square: f64 = world.particles().map(|p| p.position.length_squared()).sum();
        // 1/√20000 of the size, three times over.
        assert!((mean - middle).length() < 0.03, "{name}: {mean:?}");
        assert!(
            rms == 0.0 || ((square / n).sqrt() - rms).abs() < 0.02,
            "{name}: {} {rms}",
            (square / n).sqrt()
        );
    }
}

/// In a cone of 60° the mean of cos θ is (1 + cos 60°)/2.
#[test]
fn directions_fill_their_cone_evenly() {
    let mut world = weightless();
    let axis = Vec3::new(0.6, 0.0, 0.8);
    let d = EmitterDesc::new()
        .direction(EmitDirection::Along(axis))
        .spread(core::f32::consts::FRAC_PI_3)
        .speed(2.0, 2.0);
    let e = world.add_emitter(d.max_particles(20_000)).expect("valid");
    world.emit_burst(e, 20_000).expect("room");
    let (mut sum, mut least) = (0.0f64, 1.0f32);
    for p in world.particles() {
        let cos = p.velocity.dot(axis) * 0.5;
        sum += f64::from(cos);
        least = if cos < least { cos } else { least };
    }
    assert!((sum / 20_000.0 - 0.75).abs() < 0.005 && least > 0.4999 && least < 0.51, "{sum} {least}");
}
