//! Vehicles against closed forms, and against themselves.
//!
//! Sources: Gillespie, Fundamentals of Vehicle Dynamics, 1992 (axle loads, braking); Howe, The New Skiing Mechanics, 2001.

mod common;

use common::rng::Rng;
use jounce::math::scalar::{f32s, f64s};
use jounce::prelude::*;
use jounce::vehicles::{self, VehicleKit, carry};
use jounce::{AxisLocks, Command, DifferentialKind, Error, FieldDesc, FieldLaw, TyreDesc};

const G: f64 = 9.81;

fn world() -> World {
    World::new(WorldDesc::default()).unwrap()
}

fn road(w: &mut World, friction: f32) -> BodyId {
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).friction(friction))).unwrap()
}

fn steps(w: &mut World, seconds: f64) {
    for _ in 0..(seconds / w.dt()).round() as usize {
        w.step().unwrap();
    }
}

fn chassis(w: &World, v: VehicleId) -> BodyId {
    w.vehicle(v).unwrap().chassis()
}

fn position(w: &World, v: VehicleId) -> DVec3 {
    w.body(chassis(w, v)).unwrap().center_of_mass()
}

fn loads(w: &World, v: VehicleId) -> Vec<f64> {
    w.vehicle(v).unwrap().wheels().map(|t| f64::from(t.load)).collect()
}

/// A car without engine, air and rolling resistance, of tyres of friction μ.
fn plain(mu: f32) -> VehicleKit {
    let mut kit = vehicles::car();
    let v = &mut kit.vehicle;
    (v.drive, v.abs, v.traction) = (None, None, None);
    v.aero.clear();
    for w in &mut v.wheels {
        (w.tyre.static_friction, w.tyre.kinetic_friction) = (mu, mu);
        w.tyre.rolling_resistance = 0.0;
    }
    kit
}

fn going(w: &mut World, kit: VehicleKit, speed: f32) -> VehicleId {
    let v = kit.add(w, [0.0; 3], Quat::IDENTITY).unwrap();
    let b = chassis(w, v);
    w.set_velocity(b, Vec3::new(0.0, 0.0, speed)).unwrap();
    v
}

/// Highest that the centre of mass comes above where it was, after a ridge of 4 cm across the road at 25 m/s; the start is moved by a part of a step's way.
fn over_a_ridge(rate_hz: f64, phase: f64) -> f64 {
    let mut w = World::new(WorldDesc { rate_hz, ..WorldDesc::default() }).unwrap();
    road(&mut w, 1.0);
    let ridge = BodyDesc::fixed().at([0.0, 0.0, 20.0 + phase * 25.0 / 60.0]);
    w.add_body(ridge.shape(ShapeDesc::cuboid(Vec3::new(3.0, 0.04, 0.1)))).unwrap();
    let v = going(&mut w, plain(1.0), 0.0);
    steps(&mut w, 1.0);
    let (b, rest) = (chassis(&w, v), position(&w, v).y);
    w.set_velocity(b, Vec3::new(0.0, 0.0, 25.0)).unwrap();
    let mut high = rest;
    for _ in 0..(2.0 * rate_hz) as usize {
        w.step().unwrap();
        high = f64s::max(high, position(&w, v).y);
    }
    high - rest
}

/// Wheels look at the ground in every substep: where in a step they come to a ridge makes little difference. With one look a step it was 2.8 to 5.4 mm.
#[test]
fn a_ridge_is_met_in_the_substep() {
    let fine = over_a_ridge(960.0, 0.0);
    for i in 0..8 {
        let high = over_a_ridge(60.0, f64::from(i) / 8.0);
        println!("{high:.5} of {fine:.5} m");
        assert!((high / fine - 1.0).abs() < 0.15, "{high} m of {fine} m, {i}/8 of a step on");
    }
}

#[test]
fn axles_carry_their_shares() {
    let mut w = world();
    road(&mut w, 1.0);
    let v = plain(1.0).add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
    steps(&mut w, 4.0);
    let n = loads(&w, v);
    // m = 1300 kg, L = 2.6 m, centre 1.4 m before the rear axle.
    let (front, rear) = (1300.0 * G * 1.4 / 2.6, 1300.0 * G * 1.2 / 2.6);
    println!("front {:.1} for {front:.1}, rear {:.1} for {rear:.1}", n[0] + n[1], n[2] + n[3]);
    assert!(((n[0] + n[1]) / front - 1.0).abs() < 2e-3);
    assert!(((n[2] + n[3]) / rear - 1.0).abs() < 2e-3);
    assert!((n[0] - n[1]).abs() < 0.5 && (n[2] - n[3]).abs() < 0.5, "{n:?}");
}

#[test]
fn braking_moves_load_forward() {
    let mut w = world();
    road(&mut w, 1.0);
    let v = going(&mut w, plain(1.0), 30.0);
    steps(&mut w, 1.0);
    w.set_vehicle_input(v, VehicleInput::brake(0.35)).unwrap();
    steps(&mut w, 1.2);
    let (mut a, mut front, mut height) = (0.0, 0.0, 0.0);
    for _ in 0..30 {
        let before = w.body(chassis(&w, v)).unwrap().velocity().z;
        w.step().unwrap();
        a += f64::from(before - w.body(chassis(&w, v)).unwrap().velocity().z) / w.dt() / 30.0;
        let n = loads(&w, v);
        front += (n[0] + n[1]) / 30.0;
        height += position(&w, v).y / 30.0;
    }
    let want = 1300.0 * G * 1.4 / 2.6 + 1300.0 * a * height / 2.6;
    println!("front axle {front:.1} N for {want:.1} N at {a:.3} m/s², height {height:.3} m");
    assert!(a > 3.0 && (front / want - 1.0).abs() < 0.01);
}

#[test]
fn braking_distance() {
    let mut w = world();
    road(&mut w, 0.9);
    let v = going(&mut w, plain(0.9), 0.0);
    steps(&mut w, 2.0);
    let b = chassis(&w, v);
    w.set_velocity(b, Vec3::new(0.0, 0.0, 100.0 / 3.6)).unwrap();
    let from = position(&w, v).z;
    w.set_vehicle_input(v, VehicleInput::brake(1.0)).unwrap();
    while w.body(b).unwrap().velocity().z > 1e-2 && w.time() < 20.0 {
        w.step().unwrap();
    }
    let got = position(&w, v).z - from;
    let want = (100.0_f64 / 3.6) * (100.0 / 3.6) / (2.0 * 0.9 * G);
    println!("100-0 km/h: {got:.3} m for {want:.3} m");
    assert!((got / want - 1.0).abs() < 0.03, "{got} for {want}");
}

#[test]
fn skid_pad() {
    let mut w = world();
    road(&mut w, 1.0);
    let mut kit = plain(1.0);
    // The centre in the middle and stiff tyres: both axles end together, at small angles.
    if let Some(m) = &mut kit.body.mass {
        m.center.z = 0.0;
    }
    carry(&mut kit.vehicle.wheels, 1300.0, 0.0);
    kit.vehicle.wheels.iter_mut().for_each(|x| x.tyre.cornering_stiffness = 60.0);
    let v = going(&mut w, kit, 12.0);
    steps(&mut w, 0.5);
    let b = chassis(&w, v);
    let center = position(&w, v) + DVec3::new(-30.0, 0.0, 0.0);
    let (mut best, mut heading) = (0.0_f64, 0.0);
    let start = w.time();
    while w.time() - start < 40.0 {
        let wanted = 12.0 + 0.2 * (w.time() - start);
        let r = position(&w, v) - center;
        let distance = (r.x * r.x + r.z * r.z).sqrt();
        let velocity = w.body(b).unwrap().velocity().as_dvec3();
        let speed = velocity.length();
        // Out of the circle: steer in (right), by place and by its rate.
        let out = velocity.dot(r) / distance;
        let error = distance - 30.0;
        heading += 0.02 * error * w.dt();
        let steer = f64s::clamp(0.15 + 0.3 * error + 0.25 * out + heading, -1.0, 1.0);
        w.set_vehicle_input(v, VehicleInput { steer: steer as f32, ..VehicleInput::default() }).unwrap();
        let push = velocity * (1300.0 * f64s::clamp(wanted - speed, -1.0, 1.0) * 4.0 / f64s::max(speed, 1.0));
        w.add_force(b, push.as_vec3(), None).unwrap();
        w.step().unwrap();
        if w.time() - start > 5.0 && error.abs() < 0.5 {
            best = f64s::max(best, speed * (30.0 / distance).sqrt());
        }
        if error > 3.0 {
            break;
        }
    }
    let want = (G * 30.0).sqrt();
    println!("skid pad R = 30 m: {best:.3} m/s for {want:.3} m/s");
    assert!((best / want - 1.0).abs() < 0.03, "{best} for {want}");
}

#[test]
fn no_tyre_leaves_its_circle() {
    for (k, kit) in [vehicles::car(), vehicles::sports_car(), vehicles::off_road(), vehicles::motorcycle()]
        .into_iter()
        .enumerate()
    {
        let mut w = world();
        road(&mut w, 1.0);
        let mut rng = Rng::new(7 + k as u64);
        for i in 0..20 {
            let at = [f64::from(rng.float(-20.0, 20.0)), 0.0, f64::from(i) * 6.0 + 10.0];
            let half = [rng.float(0.2, 2.0), rng.float(0.02, 0.12), rng.float(0.2, 1.0)];
            w.add_body(BodyDesc::fixed().at(at).shape(ShapeDesc::cuboid(half).friction(0.7))).unwrap();
        }
        let most = kit.vehicle.wheels[0].tyre.static_friction.sqrt();
        let v = kit.add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
        let mut seen: f32 = 0.0;
        for i in 0..1200 {
            if i % 30 == 0 {
                let input = VehicleInput {
                    throttle: rng.float(0.0, 1.0),
                    brake: if rng.one_in(3) { rng.float(0.0, 1.0) } else { 0.0 },
                    handbrake: if rng.one_in(5) { 1.0 } else { 0.0 },
                    steer: rng.float(-1.0, 1.0),
                    gear: 1 + (i / 200),
                    ..VehicleInput::default()
                };
                w.set_vehicle_input(v, input).unwrap();
            }
            w.step().unwrap();
            for t in w.vehicle(v).unwrap().wheels() {
                let f =
                    (t.longitudinal_force * t.longitudinal_force + t.lateral_force * t.lateral_force).sqrt();
                assert!(f <= t.friction * t.load * 1.000_1 + 1e-3, "step {i}: {f} N at {t:?}");
                assert!(t.friction <= most * 1.000_1);
                if t.load > 0.0 {
                    seen = f32s::max(seen, f / (t.friction * t.load + 1e-3));
                }
            }
        }
        assert!(seen > 0.95, "the limit was reached: {seen}");
    }
}

#[test]
fn parked_on_a_slope() {
    for degrees in [5.0_f32, 20.0] {
        let mut w = world();
        let slope = Quat::from_axis_angle(Vec3::X, -degrees.to_radians());
        w.add_body(BodyDesc::fixed().rotated(slope).shape(ShapeDesc::half_space(Vec3::Y).friction(1.0)))
            .unwrap();
        let v = vehicles::car().add(&mut w, [0.0; 3], slope).unwrap();
        w.set_vehicle_input(v, VehicleInput { handbrake: 1.0, brake: 1.0, ..VehicleInput::default() })
            .unwrap();
        let b = chassis(&w, v);
        w.set_can_sleep(b, false).unwrap();
        steps(&mut w, 4.0);
        let at = position(&w, v);
        steps(&mut w, 20.0);
        let crept = (position(&w, v) - at).length();
        println!("{degrees}°: {crept:e} m in 20 s");
        assert!(crept < 1e-3, "{crept}");
        w.set_can_sleep(b, true).unwrap();
        steps(&mut w, 2.0);
        assert!(!w.body(b).unwrap().is_awake(), "a parked car sleeps");
        let hash = w.body(b).unwrap().pose();
        steps(&mut w, 5.0);
        assert_eq!(hash, w.body(b).unwrap().pose());
        w.set_vehicle_input(v, VehicleInput::default()).unwrap();
        steps(&mut w, 3.0);
        assert!((position(&w, v) - at).length() > 0.5, "and rolls off when let go");
    }
}

#[test]
fn what_it_stands_on_is_pushed() {
    // In space: a car runs into a plank, its engine turns the wheels.
    let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
    let plank = ShapeDesc::cuboid([3.0, 0.1, 6.0]).mass(800.0).friction(1.0);
    let plank = w.add_body(BodyDesc::dynamic().at([0.0, -0.1, 0.5]).shape(plank)).unwrap();
    let mut kit = vehicles::car();
    kit.vehicle.aero.clear();
    let v = kit.add(&mut w, [0.2, 0.02, 0.0], Quat::IDENTITY).unwrap();
    let b = chassis(&w, v);
    w.set_velocity(b, Vec3::new(0.1, -1.5, 0.3)).unwrap();
    w.set_vehicle_input(v, VehicleInput::drive(1.0, 0.5)).unwrap();
    let before = w.momentum();
    let (mut worst, mut turn): (f64, f64) = (0.0, 0.0);
    for _ in 0..240 {
        w.step().unwrap();
        let now = w.momentum();
        worst = f64s::max(worst, (now.linear - before.linear).length());
        turn = f64s::max(turn, (now.angular - before.angular).length());
    }
    let gone = w.body(plank).unwrap().velocity();
    println!(
        "momentum within {worst:e} of {:.0} N s, angular within {turn:e}; plank {gone:?}",
        before.linear.length()
    );
    assert!(gone.y < -0.2, "the plank was pushed: {gone:?}");
    // Rounding: 960 substeps with some ten sums of f32 each; 1,300 kg at 1.5 m/s is 2,000 N s, whose last bit is 1e-4 N s, so at random
    // 1e-4 · √9600; levers of metres.
    assert!(worst < 0.02 && turn < 0.05, "{worst} {turn}");
}

#[test]
fn a_plank_on_ice_goes_back() {
    let mut w = world();
    road(&mut w, 0.0);
    let plank = ShapeDesc::cuboid([3.0, 0.1, 20.0]).mass(500.0).friction(1.0);
    let plank = w.add_body(BodyDesc::dynamic().at([0.0, 0.1, 10.0]).shape(plank)).unwrap();
    let mut kit = vehicles::car();
    kit.vehicle.aero.clear();
    let v = kit.add(&mut w, [0.0, 0.2, 0.0], Quat::IDENTITY).unwrap();
    steps(&mut w, 2.0);
    w.set_vehicle_input(v, VehicleInput::drive(0.7, 0.0)).unwrap();
    steps(&mut w, 2.0);
    let (car, back) = (w.body(chassis(&w, v)).unwrap().velocity().z, w.body(plank).unwrap().velocity().z);
    let sum = 1300.0 * car + 500.0 * back;
    println!("car {car:.3} m/s, plank {back:.3} m/s, together {sum:.3} N s");
    // The floor has a friction of √(0 · 1) = 0.
    assert!(car > 0.8 && back < -2.0 && sum.abs() < 0.01 * 1300.0 * car, "{car} {back}");
}

#[test]
fn two_cars_collide() {
    let mut w = world();
    road(&mut w, 1.0);
    let a = plain(1.0).add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
    let turned = Quat::from_axis_angle(Vec3::Y, core::f32::consts::PI);
    let b = plain(1.0).add(&mut w, [0.3, 0.0, 8.0], turned).unwrap();
    let (ca, cb) = (chassis(&w, a), chassis(&w, b));
    steps(&mut w, 1.0);
    w.set_velocity(ca, Vec3::new(0.0, 0.0, 15.0)).unwrap();
    steps(&mut w, 0.1);
    let before = w.momentum().linear.z;
    let rolling = w.body(ca).unwrap().velocity().z;
    while w.body(cb).unwrap().velocity().z < 3.0 && w.time() < 5.0 {
        w.step().unwrap();
    }
    let after = w.momentum().linear.z;
    println!("{rolling} m/s: momentum {before:.0} to {after:.0} N s");
    assert!((after / before - 1.0).abs() < 0.01, "{before} {after}");
    assert!(w.body(ca).unwrap().velocity().z < 10.0);
    steps(&mut w, 5.0);
    assert!(common::look::not_finite(&w).is_none());
}

#[test]
fn presets_drive_straight() {
    for (name, kit) in [
        ("car", vehicles::car()),
        ("sports car", vehicles::sports_car()),
        ("off-road", vehicles::off_road()),
        ("motorcycle", vehicles::motorcycle()),
        ("tank", vehicles::tank()),
    ] {
        let mut w = world();
        road(&mut w, 1.0);
        let v = kit.add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
        w.set_vehicle_input(v, VehicleInput::drive(1.0, 0.0)).unwrap();
        steps(&mut w, 6.0);
        let (p, t) = (position(&w, v), w.vehicle(v).unwrap().telemetry());
        println!(
            "{name}: {:.1} m/s after {:.1} m, {:.4} m aside, gear {}, {:.0} rpm",
            t.speed, p.z, p.x, t.gear, t.rpm
        );
        assert!(t.speed > 5.0 && p.x.abs() < 1e-3 * p.z, "{name}: {p:?} {t:?}");
        w.set_vehicle_input(v, VehicleInput::brake(1.0)).unwrap();
        steps(&mut w, 8.0);
        let (p2, t) = (position(&w, v), w.vehicle(v).unwrap().telemetry());
        assert!(t.speed.abs() < 0.05, "{name} stops: {t:?}");
        assert!((p2.x - p.x).abs() < 0.3, "{name} aside {:?}", p2);
    }
}

#[test]
fn flips_and_stays_finite() {
    let mut w = world();
    road(&mut w, 1.0);
    for i in 0..4 {
        w.add_body(
            BodyDesc::fixed()
                .at([0.0, 0.0, 6.0 * f64::from(i) + 6.0])
                .shape(ShapeDesc::cuboid([0.5, 0.4, 0.5])),
        )
        .unwrap();
    }
    let mut ids = Vec::new();
    for (i, kit) in [
        vehicles::car(),
        vehicles::sports_car(),
        vehicles::motorcycle(),
        vehicles::tank(),
        vehicles::snowboard(),
    ]
    .into_iter()
    .enumerate()
    {
        let v =
            kit.add(&mut w, [4.0 * i as f64 - 8.0, 1.0, -6.0], Quat::from_axis_angle(Vec3::Z, 1.0)).unwrap();
        let b = chassis(&w, v);
        w.set_velocity(b, Vec3::new(0.0, 4.0, 25.0)).unwrap();
        w.set_angular_velocity(b, Vec3::new(3.0, 1.0, 6.0)).unwrap();
        w.set_vehicle_input(v, VehicleInput::drive(1.0, 0.7)).unwrap();
        ids.push(v);
    }
    for i in 0..900 {
        w.step().unwrap();
        assert!(common::look::not_finite(&w).is_none(), "step {i}");
        for &v in &ids {
            for t in w.vehicle(v).unwrap().wheels() {
                assert!(t.load.is_finite() && t.spin.is_finite() && t.travel.is_finite());
            }
            assert!(position(&w, v).length() < 1000.0 && position(&w, v).y > -1.0, "{:?}", position(&w, v));
        }
    }
    assert!(!w.events().iter().any(|e| matches!(e, Event::Quarantine { .. })));
}

#[test]
fn gears_change() {
    let mut w = world();
    road(&mut w, 1.0);
    let v = vehicles::car().add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
    w.set_vehicle_input(v, VehicleInput::drive(1.0, 0.0)).unwrap();
    let (mut gears, mut shifts) = (vec![], 0);
    for _ in 0..900 {
        w.step().unwrap();
        let t = w.vehicle(v).unwrap().telemetry();
        shifts += usize::from(t.shifting);
        if gears.last() != Some(&t.gear) {
            gears.push(t.gear);
        }
        assert!(t.rpm < 7000.0, "{t:?}");
        if t.gear > 1 && !t.shifting && t.clutch_torque > 20.0 && t.rpm > 2600.0 {
            // In gear the engine turns with the wheels, but for what the clutch slips after a change.
            let x = 0.5
                * (w.vehicle(v).unwrap().wheel(0).unwrap().spin
                    + w.vehicle(v).unwrap().wheel(1).unwrap().spin);
            let rpm = x * t.ratio * 30.0 / core::f32::consts::PI;
            assert!(rpm < t.rpm * 1.3 + 500.0 && rpm > 0.5 * t.rpm, "{rpm} {t:?}");
        }
    }
    println!("{gears:?}, {shifts} steps in changes");
    assert!(gears.starts_with(&[0, 1, 2, 3]), "{gears:?}");
    // Backwards.
    w.set_vehicle_input(v, VehicleInput::brake(1.0)).unwrap();
    steps(&mut w, 8.0);
    w.set_vehicle_input(v, VehicleInput { gear: -1, throttle: 0.6, ..VehicleInput::default() }).unwrap();
    steps(&mut w, 4.0);
    let t = w.vehicle(v).unwrap().telemetry();
    assert!(t.gear == -1 && t.speed < -2.0, "{t:?}");
    // Neutral: the engine revs up to its limit, alone.
    w.set_vehicle_input(v, VehicleInput { throttle: 1.0, brake: 1.0, ..VehicleInput::default() }).unwrap();
    steps(&mut w, 4.0);
    let t = w.vehicle(v).unwrap().telemetry();
    assert!(t.gear == 0 && t.rpm > 6000.0 && t.speed.abs() < 0.1, "{t:?}");
}

#[test]
fn right_mirrors_left() {
    // Wheels that steered right were once turned by half a turn: the car drove backwards in every right bend.
    let run = |steer: f32| {
        let mut w = world();
        road(&mut w, 1.0);
        let v = vehicles::car().add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
        w.set_vehicle_input(v, VehicleInput::drive(0.5, steer)).unwrap();
        steps(&mut w, 4.0);
        let r = w.vehicle(v).unwrap();
        let wheels: Vec<_> = r.wheels().collect();
        assert!(wheels.iter().all(|t| t.spin > 1.0), "all roll forward: {wheels:?}");
        (position(&w, v), wheels[0].steer, wheels[1].steer)
    };
    let ((l, ll, lr), (r, rl, rr)) = (run(-0.4), run(0.4));
    println!("left {l:?}, right {r:?}");
    assert!(l.x > 1.0 && (l.x + r.x).abs() < 1e-3 && (l.z - r.z).abs() < 1e-3, "{l:?} {r:?}");
    assert!(ll > lr && (ll + rr).abs() < 1e-6 && (lr + rl).abs() < 1e-6);
    // Ackermann: cot of the outer less cot of the inner angle is track over wheelbase.
    let cot = |x: f32| 1.0 / f32s::tan(x);
    assert!((cot(lr) - cot(ll) - 1.5 / 2.6).abs() < 1e-4, "{ll} {lr}");
}

/// Speed after 4 s, left wheels on ice, right ones on asphalt.
fn split(kind: DifferentialKind) -> (f32, f32, f32) {
    let mut w = world();
    for (x, mu) in [(50.0, 0.01), (-50.0, 1.0)] {
        let half = ShapeDesc::cuboid([50.0, 0.5, 200.0]).friction(mu);
        w.add_body(BodyDesc::fixed().at([x, -0.5, 100.0]).shape(half)).unwrap();
    }
    let mut kit = vehicles::car();
    kit.vehicle.traction = None;
    if let Some(d) = &mut kit.vehicle.drive {
        d.axles[0].kind = kind;
    }
    let v = kit.add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
    steps(&mut w, 1.0);
    w.set_vehicle_input(v, VehicleInput::drive(0.6, 0.0)).unwrap();
    steps(&mut w, 1.5);
    let r = w.vehicle(v).unwrap();
    let [a, b] = [0, 1].map(|i| r.wheel(i).unwrap());
    (r.telemetry().speed, a.spin - b.spin, a.longitudinal_force - b.longitudinal_force)
}

#[test]
fn differentials() {
    let (open, spin, force) = split(DifferentialKind::Open);
    let (limited, _, _) = split(DifferentialKind::LimitedSlip { preload: 400.0, lock: 0.3 });
    let (locked, same, _) = split(DifferentialKind::Locked);
    println!(
        "on split ground: open {open:.2} m/s (spin {spin:.1}, force {force:.0}), limited {limited:.2}, locked {locked:.2}"
    );
    assert!(spin > 20.0, "the wheel on ice spins: {spin}");
    assert!(same.abs() < 1e-3, "{same}");
    assert!(
        locked > 2.0 * open && limited > 1.2 * open && locked >= limited * 0.9,
        "{open} {limited} {locked}"
    );
}

#[test]
fn abs_keeps_wheels_turning() {
    let stop = |abs: bool| {
        let mut w = world();
        road(&mut w, 1.0);
        let mut kit = vehicles::car();
        if !abs {
            kit.vehicle.abs = None;
        }
        let v = going(&mut w, kit, 30.0);
        steps(&mut w, 0.5);
        let from = position(&w, v).z;
        w.set_vehicle_input(v, VehicleInput::brake(1.0)).unwrap();
        let mut locked = 0;
        for _ in 0..480 {
            w.step().unwrap();
            let r = w.vehicle(v).unwrap();
            let fast = r.telemetry().speed > 5.0;
            locked += usize::from(fast && r.wheels().any(|t| t.spin.abs() < 1.0));
        }
        (position(&w, v).z - from, locked)
    };
    let ((with, turning), (without, locked)) = (stop(true), stop(false));
    println!("30 m/s to 0: {with:.2} m with ABS ({turning} steps locked), {without:.2} m without ({locked})");
    assert!(with < without && turning < 5 && locked > 60);
}

#[test]
fn threads_and_clones_give_the_same_bits() {
    let build = || {
        let mut w = world();
        road(&mut w, 1.0);
        let mut rng = Rng::new(5);
        for i in 0..30 {
            let at = [f64::from(rng.float(-12.0, 12.0)), 0.3, f64::from(i) * 2.0 + 8.0];
            w.add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid([0.3; 3]).density(100.0))).unwrap();
        }
        let kits = [
            vehicles::car(),
            vehicles::off_road(),
            vehicles::motorcycle(),
            vehicles::tank(),
            vehicles::snowboard(),
        ];
        let ids: Vec<_> = kits
            .into_iter()
            .enumerate()
            .map(|(i, k)| k.add(&mut w, [5.0 * i as f64 - 10.0, 0.0, 0.0], Quat::IDENTITY).unwrap())
            .collect();
        (w, ids)
    };
    let run = |tasks: Tasks, clone: bool| {
        let (mut w, ids) = build();
        w.set_tasks(tasks);
        let mut rng = Rng::new(11);
        let mut hashes = Vec::new();
        for i in 0..300 {
            if i % 40 == 0 {
                for &v in &ids {
                    let input = VehicleInput {
                        lean: rng.float(-1.0, 1.0),
                        ..VehicleInput::drive(1.0, rng.float(-0.6, 0.6))
                    };
                    w.set_vehicle_input(v, input).unwrap();
                }
            }
            if clone && i % 50 == 25 {
                w = w.clone();
            }
            w.step().unwrap();
            hashes.push(w.hash());
        }
        hashes
    };
    let want = run(Tasks::serial(), false);
    assert_eq!(want, run(Tasks::serial(), true));
    for n in [2, 3] {
        assert_eq!(want, run(Tasks::pool(n), false));
    }
    assert_eq!(want, run(Tasks::chaos(3), false));
}

#[test]
fn bad_descriptions_are_refused_by_name() {
    let mut w = world();
    let mut refused = |f: &dyn Fn(&mut jounce::VehicleDesc), field: &str| {
        let mut kit = vehicles::car();
        f(&mut kit.vehicle);
        let bodies = w.counts().bodies;
        match kit.add(&mut w, [0.0; 3], Quat::IDENTITY) {
            Err(Error::BadValue { field: got, .. }) => assert_eq!(got, field),
            other => panic!("{field}: {other:?}"),
        }
        assert_eq!(w.counts().bodies, bodies);
    };
    refused(&|v| v.wheels.clear(), "wheels");
    refused(&|v| v.forward = Vec3::ZERO, "forward");
    refused(&|v| v.up = Vec3::Z, "up");
    refused(&|v| v.wheels[0].radius = f32::NAN, "radius");
    refused(&|v| v.wheels[0].radius = 10.1, "radius");
    refused(&|v| v.wheels[0].width = 10.1, "width");
    refused(&|v| v.wheels[1].position = v.wheels[0].position, "wheel position");
    refused(&|v| v.board = vehicles::snowboard().vehicle.board, "wheels");
    refused(&|v| v.wheels[1].mass = 0.0, "mass");
    refused(&|v| v.wheels[1].tyre.kinetic_friction = 2.0, "kinetic_friction");
    refused(
        &|v| v.wheels[1].tyre = TyreDesc { relaxation_length: 0.0, ..TyreDesc::default() },
        "relaxation_length",
    );
    refused(&|v| v.anti_roll[0].right = 9, "anti_roll right");
    refused(&|v| v.drive.as_mut().unwrap().engine.torque.clear(), "torque");
    refused(&|v| v.drive.as_mut().unwrap().axles[0].share = 0.5, "share");
    let on_two_axles = |v: &mut jounce::VehicleDesc, wheels: [usize; 2]| {
        v.drive = vehicles::off_road().vehicle.drive;
        let second = &mut v.drive.as_mut().unwrap().axles[1];
        [second.left, second.right] = wheels;
    };
    refused(&|v| on_two_axles(v, [1, 2]), "left");
    refused(&|v| on_two_axles(v, [2, 1]), "right");
    refused(&|v| v.drive.as_mut().unwrap().gearbox.forward.clear(), "forward");
    refused(&|v| v.drive.as_mut().unwrap().clutch.auto_rpm = Some((3.0, 2.0)), "auto_rpm");
    let v = vehicles::car().add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
    let bad = VehicleInput { throttle: 2.0, ..VehicleInput::default() };
    assert!(matches!(w.set_vehicle_input(v, bad), Err(Error::BadValue { field: "throttle", .. })));
    let twice = VehicleDesc { chassis: chassis(&w, v), ..vehicles::car().vehicle };
    assert!(matches!(w.add_vehicle(twice), Err(Error::BadValue { field: "chassis", .. })));
    let fixed = w.add_body(BodyDesc::fixed()).unwrap();
    let on_fixed = VehicleDesc { chassis: fixed, ..vehicles::car().vehicle };
    assert!(matches!(w.add_vehicle(on_fixed), Err(Error::Unsupported { .. })));
    w.remove_body(chassis(&w, v)).unwrap();
    assert!(matches!(w.vehicle(v), Err(Error::Stale { what: "vehicle", .. })));
    assert_eq!(w.counts().vehicles, 0);
}

#[test]
fn a_platform_carries_and_wakes_what_stands_on_it() {
    let mut w = world();
    let deck = ShapeDesc::cuboid([5.0, 0.5, 8.0]).friction(1.0);
    let deck = w.add_body(BodyDesc::kinematic().at([0.0, -0.5, 0.0]).shape(deck)).unwrap();
    let v = vehicles::car().add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
    w.set_vehicle_input(v, VehicleInput::park()).unwrap();
    steps(&mut w, 4.0);
    assert!(!w.body(chassis(&w, v)).unwrap().is_awake());
    w.set_velocity(deck, Vec3::new(1.0, 0.0, 0.5)).unwrap();
    steps(&mut w, 3.0);
    let u = w.body(chassis(&w, v)).unwrap().velocity();
    println!("carried at {u:?}");
    assert!((u - Vec3::new(1.0, 0.0, 0.5)).length() < 0.02, "{u:?}");
    // The ground goes.
    w.set_velocity(deck, Vec3::ZERO).unwrap();
    steps(&mut w, 4.0);
    assert!(!w.body(chassis(&w, v)).unwrap().is_awake());
    w.remove_body(deck).unwrap();
    steps(&mut w, 1.0);
    assert!(w.body(chassis(&w, v)).unwrap().velocity().y < -9.0);
}

#[test]
fn a_motorcycle_leans_into_its_turn() {
    let mut w = world();
    road(&mut w, 1.0);
    let v = going(&mut w, vehicles::motorcycle(), 15.0);
    steps(&mut w, 0.5);
    // Holding its speed.
    for i in 0..720 {
        let t = w.vehicle(v).unwrap().telemetry();
        let throttle = f32s::clamp(0.5 * (15.0 - t.speed) + 0.1, 0.0, 1.0);
        let steer = 0.06 * f32s::min(i as f32 / 120.0, 1.0);
        w.set_vehicle_input(v, VehicleInput::drive(throttle, steer)).unwrap();
        w.step().unwrap();
    }
    let b = w.body(chassis(&w, v)).unwrap();
    let (lean, rate) = (w.vehicle(v).unwrap().telemetry().lean, b.angular_velocity().y);
    let speed = b.velocity().length();
    let want = f32s::atan2(-rate * speed, 9.81);
    println!("lean {:.2}° for {:.2}° at {speed:.1} m/s", lean.to_degrees(), want.to_degrees());
    assert!(lean > 0.2 && (lean / want - 1.0).abs() < 0.05, "{lean} for {want}");
    assert!(b.position().y > -0.2);
}

#[test]
fn a_tank_turns_on_the_spot() {
    let mut w = world();
    road(&mut w, 1.0);
    let v = vehicles::tank().add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
    steps(&mut w, 1.0);
    w.set_vehicle_input(v, VehicleInput { steer: 1.0, ..VehicleInput::default() }).unwrap();
    steps(&mut w, 4.0);
    let b = w.body(chassis(&w, v)).unwrap();
    println!("{:?} rad/s at {:?}", b.angular_velocity(), b.position());
    assert!(b.angular_velocity().y < -0.3, "to the right: {:?}", b.angular_velocity());
    assert!(b.position().length() < 1.0);
    let r = w.vehicle(v).unwrap();
    let x: Vec<f32> = r.wheels().map(|t| t.spin).collect();
    assert!(
        x[..5].iter().all(|s| (s - x[0]).abs() < 1e-3) && x[5..].iter().all(|s| (s - x[5]).abs() < 1e-3),
        "{x:?}"
    );
}

fn snow(w: &mut World, degrees: f32) -> Quat {
    let slope = Quat::from_axis_angle(Vec3::X, degrees.to_radians());
    w.add_body(BodyDesc::fixed().rotated(slope).shape(ShapeDesc::half_space(Vec3::Y).friction(0.3))).unwrap();
    slope
}

#[test]
fn a_board_glides() {
    let mut w = world();
    let slope = snow(&mut w, 15.0);
    let mut kit = vehicles::snowboard();
    kit.vehicle.aero.clear();
    let v = kit.add(&mut w, [0.0; 3], slope).unwrap();
    steps(&mut w, 1.5);
    let b = chassis(&w, v);
    let (v0, t0) = (w.body(b).unwrap().velocity().length(), w.time());
    steps(&mut w, 2.0);
    let a = f64::from(w.body(b).unwrap().velocity().length() - v0) / (w.time() - t0);
    let angle = 15.0_f64.to_radians();
    let want = G * (f64s::sin(angle) - 0.04 * f64s::cos(angle));
    println!("glides at {a:.4} m/s² for {want:.4} m/s²");
    assert!((a / want - 1.0).abs() < 0.01, "{a} for {want}");
}

/// Nothing in the air turns a rider who goes head over heels: the spin stays. Before, 2 rad/s became 23.
#[test]
fn a_rider_in_flight_is_not_whirled_about() {
    let mut w = world();
    let mut kit = vehicles::snowboard();
    kit.vehicle.aero.clear();
    let v = kit.add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
    let b = chassis(&w, v);
    w.set_angular_velocity(b, Vec3::new(2.0, 0.0, 0.0)).unwrap();
    let mut most = 0.0;
    for _ in 0..240 {
        w.step().unwrap();
        most = f32s::max(most, w.body(b).unwrap().angular_velocity().length());
    }
    assert!((1.9..2.1).contains(&most), "{most} rad/s");
}

#[test]
fn a_board_carves_on_its_sidecut() {
    for lean in [0.5_f32, 0.8, -0.5] {
        let mut w = world();
        snow(&mut w, 0.0);
        let mut kit = vehicles::snowboard();
        kit.vehicle.aero.clear();
        if let Some(b) = &mut kit.vehicle.board {
            (b.friction, b.edge_friction) = (0.0, 3.0);
        }
        let v = kit.add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
        steps(&mut w, 0.5);
        let b = chassis(&w, v);
        w.set_velocity(b, Vec3::new(0.0, 0.0, 5.0)).unwrap();
        w.set_vehicle_input(v, VehicleInput { lean, ..VehicleInput::default() }).unwrap();
        steps(&mut w, 1.5);
        let (mut speed, mut rate, mut angle) = (0.0, 0.0, 0.0);
        for _ in 0..60 {
            w.step().unwrap();
            let body = w.body(b).unwrap();
            speed += f64::from(w.vehicle(v).unwrap().telemetry().speed) / 60.0;
            rate += f64::from(body.angular_velocity().y) / 60.0;
            angle += f64::from(w.vehicle(v).unwrap().telemetry().lean) / 60.0;
        }
        // The foot of the board, not the rider: v at the base.
        let body = w.body(b).unwrap();
        let base = body.velocity_at(body.position());
        let got = f64::from(base.length()) / rate.abs();
        let want = 8.0 * f64s::cos(angle);
        println!("edge {:.1}°: R = {got:.3} m for {want:.3} m at {speed:.2} m/s", angle.to_degrees());
        assert!((got / want - 1.0).abs() < 0.03, "{got} for {want}");
        assert!((rate < 0.0) == (lean > 0.0), "right edge, right turn");
    }
}

#[test]
fn a_board_jumps_and_lands() {
    let mut w = world();
    snow(&mut w, 0.0);
    let v = vehicles::snowboard().add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
    steps(&mut w, 1.0);
    let y0 = position(&w, v).y;
    w.set_vehicle_input(v, VehicleInput { jump: 1.0, ..VehicleInput::default() }).unwrap();
    let mut top: f64 = 0.0;
    for _ in 0..120 {
        w.step().unwrap();
        top = f64s::max(top, position(&w, v).y - y0);
    }
    println!("jumps {top:.3} m for {:.3} m", 9.0 / (2.0 * G));
    assert!((top / (9.0 / (2.0 * G)) - 1.0).abs() < 0.1, "{top}");
    assert!((position(&w, v).y - y0).abs() < 0.02, "and lands");
    assert!(w.vehicle(v).unwrap().telemetry().grounded == 4);
}

#[test]
fn commands_take_vehicles_in_and_out() {
    let mut w = world();
    road(&mut w, 1.0);
    let v = vehicles::car().add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
    steps(&mut w, 1.0);
    let high = position(&w, v).y;
    w.set_vehicle_enabled(v, false).unwrap();
    steps(&mut w, 1.0);
    assert!(position(&w, v).y < high - 0.1, "without its wheels it lies on its belly");
    w.set_vehicle_enabled(v, true).unwrap();
    steps(&mut w, 3.0);
    assert!((position(&w, v).y - high).abs() < 0.01);
    let mut d = w.vehicle(v).unwrap().desc().clone();
    d.wheels.iter_mut().for_each(|x| x.preload *= 1.3);
    w.apply(Command::SetVehicle(v, Box::new(d))).unwrap();
    steps(&mut w, 2.0);
    assert!(position(&w, v).y > high + 0.01, "stiffer");
    let body = chassis(&w, v);
    w.remove_vehicle(v).unwrap();
    assert!(w.vehicle(v).is_err());
    steps(&mut w, 1.0);
    assert!(w.body(body).unwrap().center_of_mass().y < high - 0.1);
}

#[test]
fn a_board_stands_as_deep_as_its_springs_say() {
    let mut w = world();
    snow(&mut w, 0.0);
    let v = vehicles::snowboard().add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
    let b = chassis(&w, v);
    w.set_can_sleep(b, false).unwrap();
    steps(&mut w, 4.0);
    // Its stations are at the origin's height; m g/k with 80 kg on 40 kN/m.
    let (sag, want) = (-w.body(b).unwrap().pose().p.y, 80.0 * G / 40_000.0);
    println!("sinks {sag:.5} m for {want:.5} m");
    assert!((sag / want - 1.0).abs() < 0.01, "{sag} for {want}");
    let n = loads(&w, v);
    let all: f64 = n.iter().sum();
    assert!((all / (80.0 * G) - 1.0).abs() < 1e-3, "{n:?}");
}

#[test]
fn a_flat_board_slides_alike_in_all_directions() {
    // Coulomb: μ N against the slip, whichever way the board lies; along and across apart it was up to √2 μ N.
    let mut way = Vec::new();
    for degrees in [0.0_f32, 30.0, 45.0, 90.0] {
        let mut w = world();
        snow(&mut w, 0.0);
        let mut kit = vehicles::snowboard();
        kit.vehicle.aero.clear();
        if let Some(b) = &mut kit.vehicle.board {
            (b.friction, b.edge_friction) = (0.1, 0.1);
        }
        kit.body = kit.body.locks(AxisLocks { angular: [true; 3], ..AxisLocks::NONE });
        let turned = Quat::from_axis_angle(Vec3::Y, degrees.to_radians());
        let v = kit.add(&mut w, [0.0; 3], turned).unwrap();
        let b = chassis(&w, v);
        steps(&mut w, 2.0);
        w.set_velocity(b, Vec3::new(0.0, 0.0, 4.0)).unwrap();
        let from = position(&w, v);
        steps(&mut w, 3.0);
        for t in w.vehicle(v).unwrap().wheels() {
            let [x, y] = [t.longitudinal_force, t.lateral_force];
            let f = (x * x + y * y).sqrt();
            assert!(f <= t.friction * t.load * 1.000_1 + 1e-3, "{degrees}°: {f} N of {t:?}");
        }
        let gone = position(&w, v) - from;
        assert!(gone.x.abs() < 0.05, "{degrees}° goes aside by {}", gone.x);
        way.push(gone.z);
    }
    // v t − ½ μ g t² with t = 3 s.
    let want = 4.0 * 3.0 - 0.5 * 0.1 * G * 9.0;
    println!("ways {way:?} for {want:.3}");
    assert!(way.iter().all(|z| (z / want - 1.0).abs() < 0.02), "{way:?} for {want}");
}

#[test]
fn a_locked_wheel_slides_with_the_kinetic_friction() {
    let mut w = world();
    road(&mut w, 1.0);
    let mut kit = plain(1.0);
    for x in &mut kit.vehicle.wheels {
        (x.tyre.static_friction, x.tyre.kinetic_friction) = (0.9, 0.6);
        (x.tyre.load_sensitivity, x.brake) = (0.0, 1e5);
    }
    let v = going(&mut w, kit, 0.0);
    steps(&mut w, 2.0);
    let b = chassis(&w, v);
    w.set_velocity(b, Vec3::new(0.0, 0.0, 25.0)).unwrap();
    w.set_vehicle_input(v, VehicleInput::brake(1.0)).unwrap();
    steps(&mut w, 0.5);
    let from = w.body(b).unwrap().velocity().z;
    steps(&mut w, 1.0);
    let mu = f64::from(from - w.body(b).unwrap().velocity().z) / G;
    // The road's 1 and the tyre's μ: √(0.6 · 1).
    let want = 0.6_f64.sqrt();
    println!("locked: μ {mu:.4} for {want:.4}");
    assert!((mu / want - 1.0).abs() < 5e-3, "{mu} for {want}");
}

#[test]
fn wind_and_media_reach_the_air_on_a_vehicle() {
    let decelerates = |field: Option<FieldDesc>| {
        let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
        if let Some(f) = field {
            w.add_field(f).unwrap();
        }
        let mut kit = vehicles::car();
        kit.vehicle.aero[0].position = Vec3::new(0.0, 0.5, 0.1);
        // The shapes' own drag is not asked about.
        for s in &mut kit.body.shapes {
            s.aero.drag = Some(0.0);
        }
        let v = kit.add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
        let b = chassis(&w, v);
        w.set_velocity(b, Vec3::new(0.0, 0.0, 20.0)).unwrap();
        steps(&mut w, 0.5);
        f64::from(20.0 - w.body(b).unwrap().velocity().z)
    };
    // 1/v grows by ½ ρ C A t/m, v against the wind.
    let want = |rho: f64, wind: f64| {
        let v = 20.0 - wind;
        v - 1.0 / (1.0 / v + 0.5 * rho * 0.65 * 0.5 / 1300.0)
    };
    let air = f64::from(jounce::AIR_DENSITY);
    let dense = FieldDesc::new(FieldLaw::Drag { density: 100.0, viscosity: 0.0 });
    for (name, field, want) in [
        ("still", None, want(air, 0.0)),
        ("head wind", Some(FieldDesc::wind([0.0, 0.0, -15.0])), want(air, -15.0)),
        ("dense", Some(dense), want(100.0, 0.0)),
    ] {
        let got = decelerates(field);
        println!("{name}: {got:.5} m/s lost for {want:.5}");
        assert!((got / want - 1.0).abs() < 0.02, "{name}: {got} for {want}");
    }
}

/// What is hung on a parked car by a joint is part of it. Before, 150 kg welded on in front drew it along at 3.6 mm/s for ever.
#[test]
fn a_parked_car_with_a_load_on_a_joint_stays() {
    // In the air in front of it, and so low that it rests on the road too.
    for (mass, height) in [(50.0, 0.9), (150.0, 0.9), (500.0, 0.9), (50.0, 0.3)] {
        let mut w = world();
        road(&mut w, 1.0);
        let v = plain(1.0).add(&mut w, [0.0; 3], Quat::IDENTITY).unwrap();
        let car = chassis(&w, v);
        let nose = w.body(car).unwrap().position() + DVec3::new(0.0, height, 2.6);
        let load = BodyDesc::dynamic().at(nose).shape(ShapeDesc::cuboid([0.3; 3]).mass(mass));
        let load = w.add_body(load).unwrap();
        w.add_joint(JointDesc::fixed(car, load, nose - DVec3::new(0.0, 0.0, 0.3))).unwrap();
        w.apply(Command::SetCanSleep(car, false)).unwrap();
        w.set_vehicle_input(v, VehicleInput { brake: 1.0, handbrake: 1.0, ..VehicleInput::default() })
            .unwrap();
        steps(&mut w, 10.0);
        let before = position(&w, v);
        steps(&mut w, 10.0);
        let way = (position(&w, v) - before).length();
        println!("{mass} kg at {height} m: {:.4} mm in 10 s", 1e3 * way);
        assert!(way < 1e-3, "{mass} kg: {way} m");
    }
}
