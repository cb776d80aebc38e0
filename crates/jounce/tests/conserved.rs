//! What fields and particles must keep: momentum, energy, weight against buoyancy, the direction of what is slowed down.

mod common;

use common::rng::Rng;
use jounce::geometry::Hull;
use jounce::math::scalar::{f32s, f64s};
use jounce::prelude::*;
use jounce::{EmitDirection, HitResponse, ParticleSpawn, Settings};
use std::sync::Arc;

/// Rounding of one f32 operation, relative.
const EPS: f64 = 1.0 / 16_777_216.0;

fn weightless() -> World {
    let settings = Settings { sleep: false, ..Settings::default() };
    World::new(WorldDesc { gravity: Vec3::ZERO, settings, ..WorldDesc::default() }).expect("valid")
}

fn seeds() -> u64 {
    if common::prove() { 400 } else { 40 }
}

/// Σ m v of particles and bodies, and Σ m |v|, which scales the rounding.
fn momentum(w: &World) -> (DVec3, f64) {
    let (mut p, mut size) = (w.momentum().linear, 0.0);
    for b in w.bodies() {
        let b = w.body(b).expect("alive");
        size += f64::from(b.mass()) * f64::from(b.velocity().length());
    }
    for x in w.particles() {
        let mv = x.velocity.as_dvec3() * f64::from(x.mass);
        p += mv;
        size += mv.length();
    }
    (p, size)
}

/// Showers of all kinds on free bodies of all shapes: what particles lose the bodies gain, whatever K_r and K_f.
#[test]
fn particles_that_push_conserve_momentum() {
    let mut pushed = 0;
    for seed in 0..seeds() {
        let (mut w, mut rng) = (weightless(), Rng::new(seed));
        let mut bodies = Vec::new();
        for _ in 0..1 + rng.below(4) {
            let mass = rng.decades(-1.0, 2.0);
            let shape = match rng.below(4) {
                0 => ShapeDesc::sphere(0.4),
                1 => ShapeDesc::cuboid([0.5, 0.3, 0.4]),
                2 => ShapeDesc::capsule(0.3, 0.25),
                _ => ShapeDesc::cylinder(0.3, 0.4),
            };
            let d =
                BodyDesc::dynamic().at([rng.double(-0.5, 2.0), rng.double(-0.6, 0.6), rng.double(-0.6, 0.6)]);
            // Bodies do not meet one another here: contacts have their own tests.
            let d = d
                .rotated(rng.quat())
                .shape(shape.mass(mass).filter(Filter { group: -1, ..Filter::default() }));
            bodies.push(w.add_body(d).expect("valid"));
        }
        let c = ParticleCollision {
            push: true,
            restitution: *rng.pick(&[0.0, 0.5, 1.0]),
            friction: *rng.pick(&[0.0, 0.3, 1.0]),
            ..ParticleCollision::default()
        };
        let mut d = EmitterDesc::new().at([-3.0, 0.0, 0.0]).direction(EmitDirection::Along(Vec3::X));
        (d.spread, d.mass, d.lifetime_s) = (0.25, rng.decades(-4.0, -1.0), [99.0, 99.0]);
        (d.radius, d.drag_coefficient) = ([0.005, 0.03], 0.0);
        w.add_emitter(d.burst(0.0, 300).speed(4.0, 9.0).collision(c)).expect("valid");
        w.step().expect("steps");
        let (before, size) = momentum(&w);
        for _ in 0..90 {
            w.step().expect("steps");
        }
        let (after, _) = momentum(&w);
        // A hit rounds the velocity of a body, and a particle's; at most a dozen hits of each particle, by chance each way.
        let tolerance = 300.0 * 12.0 * EPS * size;
        assert!((after - before).length() < tolerance, "seed {seed}: {before:?} {after:?}, {tolerance}");
        pushed += usize::from(w.body(bodies[0]).expect("alive").velocity().length() > 0.0);
    }
    assert!(pushed as u64 * 2 > seeds(), "{pushed} bodies were hit");
}

/// A sticking or dying particle gives all of its momentum, against the body's own velocity.
#[test]
fn what_sticks_or_dies_has_given_its_momentum() {
    for response in [HitResponse::Stick, HitResponse::Kill] {
        let mut w = weightless();
        let d = BodyDesc::dynamic().shape(ShapeDesc::cuboid([0.5; 3]).mass(2.0));
        let b = w.add_body(d).expect("valid");
        let c = ParticleCollision { push: true, response, ..ParticleCollision::default() };
        let e = w.add_emitter(EmitterDesc::new().collision(c)).expect("valid");
        let (position, velocity) = (DVec3::new(-2.0, 0.0, 0.0), Vec3::X * 6.0);
        let s = ParticleSpawn { position, velocity, lifetime_s: 99.0, mass: 0.5, radius: 0.05 };
        w.emit_particles(e, vec![s]).expect("room");
        for _ in 0..60 {
            w.step().expect("steps");
        }
        // Plastic: both at 6 · 0.5/2.5. What sticks is carried from then on, and counts with the body's mass no more.
        let v = w.body(b).expect("alive").velocity();
        assert!((v - Vec3::X * 1.2).length() < 1e-5, "{response:?}: {v:?}");
    }
}

/// Bodies that attract one another: momentum and angular momentum to rounding, energy within the method's first order.
#[test]
fn bodies_that_attract_one_another_keep_momentum_and_energy() {
    let swing = |rate_hz: f64| {
        let settings = Settings { sleep: false, linear_speed_max: 1e4, ..Settings::default() };
        let desc = WorldDesc { gravity: Vec3::ZERO, rate_hz, settings, ..WorldDesc::default() };
        let (mut w, mut rng) = (World::new(desc).expect("valid"), Rng::new(8));
        let mut all = Vec::new();
        for i in 0..16 {
            let turn = Quat::from_axis_angle(Vec3::Y, i as f32 * core::f32::consts::TAU / 16.0);
            let at = turn.rotate(Vec3::new(4.0, rng.float(-0.3, 0.3), 0.0));
            let shape = ShapeDesc::sphere(0.05).mass(rng.float(0.5, 2.0));
            let v = turn.rotate(Vec3::new(0.0, 0.0, -1.2)) + rng.vec3(0.2);
            all.push(
                w.add_body(BodyDesc::dynamic().at(at.as_dvec3()).velocity(v).shape(shape)).expect("valid"),
            );
        }
        w.add_field(FieldDesc::new(FieldLaw::NBody { bodies: all, g: 1.0, softening: 0.5 })).expect("valid");
        let (start, e0) = (w.momentum(), w.energy().total());
        let (mut worst, mut size, mut steps) = (0.0f64, 0.0f64, 0.0);
        for _ in 0..(4.0 * rate_hz) as usize {
            w.step().expect("steps");
            worst = f64s::max(worst, (w.energy().total() - e0).abs());
            size = f64s::max(size, momentum(&w).1);
            steps += 4.0;
        }
        // Each substep rounds every velocity twice, at random: √n of 2 ε m v, six of them.
        let rounding = 6.0 * 2.0 * EPS * size * f64s::max(steps, 1.0).sqrt();
        let p = w.momentum();
        assert!(p.linear.distance(start.linear) < rounding, "{:?} {:?}", p.linear, start.linear);
        assert!(p.angular.distance(start.angular) < 5.0 * rounding, "{:?} {:?}", p.angular, start.angular);
        assert!(e0.abs() > 1.0 && worst < 0.1 * e0.abs(), "{worst} of {e0}");
        worst
    };
    // Symplectic Euler is of first order: twice the rate, half the swing, and what is of second order.
    let (coarse, fine) = (swing(60.0), swing(120.0));
    let order = f64s::ln(coarse / fine) / core::f64::consts::LN_2;
    assert!((order - 1.0).abs() < 0.1, "{coarse} {fine}: {order}");
}

/// Half as dense as the water: half of the volume is under, for every solid.
#[test]
fn a_body_of_half_the_density_floats_with_half_its_volume_under() {
    let mut rng = Rng::new(4);
    let points: Vec<Vec3> = (0..40).map(|_| rng.vec3(0.5)).collect();
    let hull = Hull::new(&points).expect("a hull");
    let shapes = [
        ("sphere", Shape::Sphere { radius: 0.4 }),
        ("capsule", Shape::Capsule { half_height: 0.4, radius: 0.25 }),
        ("box", Shape::Box { half: Vec3::new(0.5, 0.3, 0.4) }),
        ("cylinder", Shape::Cylinder { half_height: 0.3, radius: 0.4 }),
        ("cone", Shape::Cone { half_height: 0.4, radius: 0.4 }),
        ("hull", Shape::Hull(Arc::new(hull))),
    ];
    for (name, shape) in shapes {
        let settings = Settings { sleep: false, ..Settings::default() };
        let mut w = World::new(WorldDesc { settings, ..WorldDesc::default() }).expect("valid");
        let mut water = FieldDesc::water(0.0);
        if let FieldLaw::Water { linear_drag, .. } = &mut water.law {
            *linear_drag = 2.0;
        }
        w.add_field(water).expect("valid");
        let d = BodyDesc::dynamic().at([0.0, 0.1, 0.0]).rotated(rng.quat());
        let b = w.add_body(d.shape(ShapeDesc::new(shape.clone()).density(500.0))).expect("valid");
        for _ in 0..60 * 60 {
            w.step().expect("steps");
        }
        let body = w.body(b).expect("alive");
        let id = body.shapes().next().expect("a shape");
        let pose = w.shape(id).expect("alive").world_pose();
        let up = pose.q.as_dquat().normalize().inverse_rotate(DVec3::Y);
        let under = shape.submerged(up, -pose.p.y).volume / shape.volume();
        let speed = body.velocity().length();
        // At rest lift and weight agree to the f32 roundings of mass and volume; what moves still at v is off by the change of
        // velocity it has to lose, v per 1/k = ½ s of g: v · 2/9.81.
        let tolerance = 64.0 * EPS + 0.5 * f64::from(speed) * 2.0 / 9.81 + 1e-5;
        assert!(speed < 1e-2, "{name}: still {speed} m/s after a minute");
        assert!((under - 0.5).abs() < tolerance, "{name}: {under}, {tolerance}");
    }
}

/// However dense, viscous or large: in a still medium a body and a particle slow down along their line, and none turns round,
/// to the last bit; with levers and spins the energy only falls.
#[test]
fn drag_never_reverses_a_velocity() {
    for seed in 0..seeds() * 5 {
        let mut rng = Rng::new(seed ^ 0xd4a6);
        let mut w = weightless();
        let (density, viscosity) = (rng.decades(-3.0, 6.0), rng.decades(-6.0, 6.0));
        if rng.one_in(2) {
            w.add_field(FieldDesc::new(FieldLaw::Drag { density, viscosity })).expect("valid");
        } else {
            let mut water = FieldDesc::water(1e5);
            if let FieldLaw::Water { density: rho, viscosity: eta, linear_drag, .. } = &mut water.law {
                (*rho, *eta, *linear_drag) = (density, viscosity, rng.decades(-3.0, 4.0));
            }
            w.add_field(water).expect("valid");
        }
        let aero = Aero { drag: rng.one_in(2).then(|| rng.decades(-2.0, 4.0)), ..Aero::default() };
        let (speed, mass) = (rng.decades(-3.0, 2.5), rng.decades(-6.0, 3.0));
        let start = rng.quat().rotate(Vec3::X) * speed;
        let ball = ShapeDesc::sphere(rng.decades(-2.0, 0.5)).mass(mass).aero(aero);
        let b = w.add_body(BodyDesc::dynamic().velocity(start).shape(ball)).expect("valid");
        // Off its middle, turning, and of another shape: its energy is what counts.
        let odd = ShapeDesc::cuboid([0.3, 0.1, 0.5]).mass(mass).aero(aero).at(rng.vec3(0.3));
        let d = BodyDesc::dynamic().at([50.0, 0.0, 0.0]).velocity(start).angular_velocity(rng.vec3(20.0));
        let o = w.add_body(d.shape(odd)).expect("valid");
        let e = w.add_emitter(EmitterDesc::new().linear_drag(rng.decades(-2.0, 6.0))).expect("valid");
        let position = DVec3::new(-50.0, 0.0, 0.0);
        let radius = rng.decades(-4.0, -1.0);
        let p =
            ParticleSpawn { position, velocity: start, lifetime_s: 99.0, mass: mass * 1e-3 + 1e-9, radius };
        w.emit_particles(e, vec![p]).expect("room");
        let line = start.normalize_or(Vec3::X);
        let (mut fast, mut energy) = ([speed * 1.000_001; 2], f64::INFINITY);
        for step in 0..30 {
            w.step().expect("steps");
            let v = w.body(b).expect("alive").velocity();
            let u = w.particles().next().map_or(Vec3::ZERO, |p| p.velocity);
            for (i, v) in [v, u].into_iter().enumerate() {
                let (along, all) = (v.dot(line), v.length());
                let what =
                    format!("seed {seed}, step {step}, {}: {v:?} of {start:?}", ["body", "particle"][i]);
                assert!(along >= 0.0, "turned round: {what}");
                assert!(all <= fast[i] * 1.000_001, "faster: {what}");
                assert!((v - line * along).length() <= 1e-5 * speed, "off its line: {what}");
                fast[i] = f32s::min(fast[i], all);
            }
            let now = w.body(o).expect("alive").kinetic_energy();
            assert!(now <= energy * (1.0 + 1e-5), "seed {seed}, step {step}: energy {energy} → {now}");
            energy = now;
        }
    }
}
