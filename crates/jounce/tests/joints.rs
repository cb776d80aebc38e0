//! Joints against closed forms, and against themselves.
//!
//! Sources of the numbers: docs and `jounce verify`; periods of the pendulum by the arithmetic-geometric mean.

use jounce::math::scalar::{f32s, f64s};
use jounce::prelude::*;
use jounce::{AxisDesc, BallDesc, Command, JointKind, JointSolver, LimitDesc, PathDesc, SpringDesc};

fn world() -> World {
    World::new(WorldDesc::default()).unwrap()
}

fn anchor(w: &mut World) -> BodyId {
    w.add_body(BodyDesc::fixed()).unwrap()
}

fn ball(w: &mut World, at: [f64; 3], radius: f32, mass: f32) -> BodyId {
    w.add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::sphere(radius).mass(mass))).unwrap()
}

/// Period of a pendulum of length 1 by the arithmetic-geometric mean.
fn period(amplitude_deg: f64) -> f64 {
    let (mut a, mut b) = (1.0, f64s::cos(amplitude_deg.to_radians() / 2.0));
    for _ in 0..20 {
        (a, b) = ((a + b) / 2.0, (a * b).sqrt());
    }
    core::f64::consts::TAU / 9.81_f64.sqrt() / a
}

/// What holds the bob of a pendulum.
#[derive(Clone, Copy, Debug)]
enum Held {
    Rod,
    Ball,
    Hinge,
}

/// Mean period over some swings, of a bob of 1 cm at 1 m from a fixed point, by crossings of the vertical.
fn measured(held: Held, amplitude_deg: f64, swings: usize) -> (f64, f64) {
    let mut w = world();
    let hook = anchor(&mut w);
    let t = amplitude_deg.to_radians();
    let at = [f64s::sin(t), -f64s::cos(t), 0.0];
    let bob = ball(&mut w, at, 0.01, 1.0);
    let joint = match held {
        Held::Rod => JointDesc::rod(hook, bob, [0.0; 3], at),
        Held::Ball => JointDesc::ball(hook, bob, [0.0; 3]),
        Held::Hinge => JointDesc::hinge(hook, bob, [0.0; 3], Vec3::Z),
    };
    w.add_joint(joint).unwrap();
    w.apply(jounce::Command::SetCanSleep(bob, false)).unwrap();
    let e0 = w.energy().total();
    let (mut crossings, mut last) = (Vec::new(), at[0]);
    let mut drift = 0.0;
    while crossings.len() < 2 * swings + 1 && w.time() < 60.0 {
        w.step().unwrap();
        let x = w.body(bob).unwrap().position().x;
        if x.signum() != last.signum() {
            let part = last / (last - x);
            crossings.push(w.time() - w.dt() * (1.0 - part));
        }
        last = x;
        drift = f64s::max(drift, (w.energy().total() - e0).abs());
    }
    let n = crossings.len() - 1;
    ((crossings[n] - crossings[0]) / n as f64 * 2.0, drift)
}

/// Before, the bobs on balls and hinges lost an eighth of their energy in 20 s: tension acted implicitly on their own inertia alone.
#[test]
fn pendulums_keep_their_periods() {
    let all =
        [(5.0, 2e-3), (30.0, 2e-3), (60.0, 2e-3), (90.0, 2e-3), (120.0, 2e-3), (150.0, 2e-3), (170.0, 1e-2)];
    for held in [Held::Rod, Held::Ball, Held::Hinge] {
        for (amplitude, tolerance) in all {
            let (got, drift) = measured(held, amplitude, 4);
            let want = period(amplitude);
            println!(
                "{held:?} {amplitude}°: {got} for {want} ({:.5}), energy within {drift}",
                got / want - 1.0
            );
            assert!((got / want - 1.0).abs() < tolerance, "{held:?} {amplitude}°: {got} for {want}");
        }
    }
}

#[test]
fn a_double_pendulum_keeps_its_energy() {
    let mut w = world();
    let hook = anchor(&mut w);
    let a = ball(&mut w, [1.0, 0.0, 0.0], 0.01, 1.0);
    let b = ball(&mut w, [2.0, 0.0, 0.0], 0.01, 1.0);
    w.add_joint(JointDesc::rod(hook, a, [0.0; 3], [1.0, 0.0, 0.0])).unwrap();
    w.add_joint(JointDesc::rod(a, b, [1.0, 0.0, 0.0], [2.0, 0.0, 0.0])).unwrap();
    let e0 = w.energy().total();
    let mut worst: f64 = 0.0;
    let mut mean = [0.0; 60];
    for i in 0..3600 {
        w.step().unwrap();
        let e = w.energy().total() - e0;
        worst = f64s::max(worst, e.abs());
        mean[i / 60] += e / 60.0;
    }
    println!("double pendulum: worst {} of 4mgL; seconds {:?}", worst / (4.0 * 9.81), &mean[50..]);
    assert!(worst < 0.01 * 4.0 * 9.81, "{worst}");
}

#[test]
fn a_hundred_kilograms_hang_on_a_light_chain() {
    for load in [1.0_f32, 100.0, 10_000.0] {
        let mut w = world();
        let hook = anchor(&mut w);
        let mut last = hook;
        let n = 50;
        for i in 0..n {
            let y = -0.1 * f64::from(i);
            let link = w
                .add_body(
                    BodyDesc::dynamic()
                        .at([0.0, y - 0.05, 0.0])
                        .shape(ShapeDesc::capsule(0.04, 0.01).mass(0.02)),
                )
                .unwrap();
            w.add_joint(JointDesc::ball(last, link, [0.0, y, 0.0])).unwrap();
            last = link;
        }
        let y = -0.1 * f64::from(n);
        let weight = ball(&mut w, [0.0, y - 0.5, 0.0], 0.5, load);
        w.add_joint(JointDesc::ball(last, weight, [0.0, y, 0.0])).unwrap();
        w.add_impulse(weight, Vec3::new(load, 0.0, 0.0), None).unwrap();
        let mut stretch = 0.0;
        for i in 0..600 {
            w.step().unwrap();
            let p = w.body(weight).unwrap().position();
            let up = w.body(weight).unwrap().rotation().rotate(Vec3::Y).as_dvec3();
            let length = (p + up * 0.5).length();
            if i > 60 {
                stretch = f64s::max(stretch, (length - 5.0) / 5.0);
            }
        }
        println!("{load} kg: stretch {stretch:.6}");
        assert!(stretch < 0.01, "{load} kg: {stretch}");
    }
}

fn rod_body(w: &mut World, at: [f64; 3], half: [f32; 3], mass: f32) -> BodyId {
    w.add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid(Vec3::from(half)).mass(mass))).unwrap()
}

fn run(w: &mut World, seconds: f64) {
    let steps = (seconds * 60.0).round() as usize;
    for _ in 0..steps {
        w.step().unwrap();
    }
}

/// A swinging bar on a hinge: T = 2π √(I/(m g d)), thin rod about its end 2π √(2L/3g).
#[test]
fn a_bar_on_a_hinge_swings_as_a_rigid_body() {
    let mut w = world();
    let wall = anchor(&mut w);
    let t = 0.05_f64;
    let at = [0.5 * f64s::sin(t), -0.5 * f64s::cos(t), 0.0];
    let q = Quat::from_axis_angle(Vec3::Z, t as f32);
    let mut d = BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid(Vec3::new(0.005, 0.5, 0.005)).mass(1.0));
    d.rotation = q;
    d.can_sleep = false;
    let bar = w.add_body(d).unwrap();
    let hinge = w.add_joint(JointDesc::hinge(wall, bar, [0.0; 3], Vec3::Z)).unwrap();
    let (mut last, mut times) = (t as f32, Vec::new());
    while times.len() < 9 {
        w.step().unwrap();
        let now = w.joint(hinge).unwrap().coordinate() + t as f32;
        if now.signum() != last.signum() {
            times.push(w.time() - w.dt() * (1.0 - f64::from(last / (last - now))));
        }
        last = now;
    }
    let got = (times[8] - times[0]) / 4.0;
    let i: f64 = (1.0 + 0.01 * 0.01) / 12.0 + 0.25;
    let want = core::f64::consts::TAU * (i / (9.81 * 0.5)).sqrt() * (1.0 + t * t / 16.0);
    assert!((got / want - 1.0).abs() < 1e-3, "{got} for {want}");
}

#[test]
fn a_slider_falls_along_its_axis_and_stops_at_its_end() {
    let mut w = world();
    let wall = anchor(&mut w);
    let axis = Vec3::new(0.6, -0.8, 0.0);
    let b = rod_body(&mut w, [0.0, 0.0, 0.0], [0.1, 0.2, 0.3], 2.0);
    let j = w.add_joint(JointDesc::slider(wall, b, [0.3, 0.1, 0.0], axis).limited(-1.0, 3.0)).unwrap();
    run(&mut w, 0.5);
    let want = 0.5 * 9.81 * 0.8 * 0.25;
    let got = w.joint(j).unwrap().coordinate();
    assert!((got - want).abs() < 0.03, "{got} for {want}");
    run(&mut w, 3.0);
    let r = w.joint(j).unwrap();
    assert!((r.coordinate() - 3.0).abs() < 1e-3, "{}", r.coordinate());
    assert!(r.gap() < 1e-4, "{}", r.gap());
    // It rests on the end: the joint carries all the weight.
    assert!((r.force() - Vec3::new(0.0, 2.0 * 9.81, 0.0)).length() < 0.05, "{:?}", r.force());
    assert!(w.body(b).unwrap().rotation().angle() < 1e-4);
}

#[test]
fn a_weld_holds_a_cantilever_and_tells_its_load() {
    let mut w = world();
    let wall = anchor(&mut w);
    let mut last = wall;
    let mut first = None;
    for i in 0..10 {
        let x = 0.2 * f64::from(i);
        let b = rod_body(&mut w, [x + 0.1, 0.0, 0.0], [0.1, 0.05, 0.05], 1.0);
        let j = w.add_joint(JointDesc::fixed(last, b, [x, 0.0, 0.0])).unwrap();
        first.get_or_insert(j);
        last = b;
    }
    run(&mut w, 2.0);
    let tip = w.body(last).unwrap().position();
    assert!((tip - DVec3::new(1.9, 0.0, 0.0)).length() < 1e-4, "{tip:?}");
    let j = w.joint(first.unwrap()).unwrap();
    assert!((j.force().y - 98.1).abs() < 0.1, "{:?}", j.force());
    // Σ m g x = 10 · 9.81 · 1.
    assert!((j.torque().z.abs() - 98.1).abs() < 0.2, "{:?}", j.torque());
}

#[test]
fn hinge_motors_reach_their_speed_and_stall_at_their_strength() {
    let mut w = world();
    let wall = anchor(&mut w);
    let b = rod_body(&mut w, [0.5, 0.0, 0.0], [0.5, 0.05, 0.05], 1.0);
    let motor = MotorDesc::velocity(3.0, 100.0);
    let j = w.add_joint(JointDesc::hinge(wall, b, [0.0; 3], Vec3::Y).motor(motor)).unwrap();
    run(&mut w, 1.0);
    let spin = w.body(b).unwrap().angular_velocity();
    assert!((spin - Vec3::new(0.0, 3.0, 0.0)).length() < 1e-3, "{spin:?}");
    assert!((w.joint(j).unwrap().coordinate() - 3.0).abs() < 0.06);
    // Half a turn is counted on: after 3 s it is past one turn.
    run(&mut w, 2.0);
    assert!(w.joint(j).unwrap().coordinate() > 8.5, "{}", w.joint(j).unwrap().coordinate());
    // 1 N m on I = m L²/3 and a bit.
    let mut w = world();
    let wall = anchor(&mut w);
    let b = rod_body(&mut w, [0.5, 0.0, 0.0], [0.5, 0.05, 0.05], 1.0);
    w.add_joint(JointDesc::hinge(wall, b, [0.0; 3], Vec3::Y).motor(MotorDesc::velocity(50.0, 1.0))).unwrap();
    run(&mut w, 1.0);
    let i = (1.0 + 0.01) / 12.0 + 0.25;
    let got = w.body(b).unwrap().angular_velocity().y;
    assert!((got - 1.0 / i).abs() < 0.02 / i, "{got} for {}", 1.0 / i);
}

#[test]
fn springs_swing_at_their_frequency() {
    let mut w = world();
    let wall = anchor(&mut w);
    let b = ball(&mut w, [0.0, -1.0, 0.0], 0.1, 2.0);
    let spring = SpringDesc::newton(200.0, 0.0);
    w.add_joint(JointDesc::spring(wall, b, [0.0; 3], [0.0, -1.0, 0.0], spring)).unwrap();
    let sag = 2.0 * 9.81 / 200.0;
    let (mut low, mut high, mut times, mut last) = (0.0_f64, -9.0_f64, Vec::new(), 0.0_f64);
    for _ in 0..1200 {
        w.step().unwrap();
        let y = w.body(b).unwrap().position().y;
        (low, high) = (f64s::min(low, y), f64s::max(high, y));
        let x = y + 1.0 + sag;
        if last < 0.0 && x >= 0.0 {
            times.push(w.time() - w.dt() * x / (x - last));
        }
        last = x;
    }
    let n = times.len() - 1;
    let got = (times[n] - times[0]) / n as f64;
    let want = core::f64::consts::TAU * (2.0_f64 / 200.0).sqrt();
    assert!((got / want - 1.0).abs() < 1e-3, "{got} for {want}");
    // No damper: after 20 s it still swings as far.
    assert!((high + 1.0).abs() < 0.01 && (low + 1.0 + 2.0 * sag).abs() < 0.01, "{low} {high}");
}

#[test]
fn ropes_go_slack_and_catch() {
    let mut w = world();
    let wall = anchor(&mut w);
    let b = ball(&mut w, [0.0, -0.5, 0.0], 0.1, 3.0);
    let j = w.add_joint(JointDesc::rope(wall, b, [0.0; 3], [0.0, -0.5, 0.0], 2.0)).unwrap();
    run(&mut w, 0.4);
    let y = w.body(b).unwrap().position().y;
    assert!((y + 0.5 + 0.5 * 9.81 * 0.16).abs() < 0.02, "falls freely: {y}");
    assert_eq!(w.joint(j).unwrap().force(), Vec3::ZERO);
    run(&mut w, 2.0);
    assert!((w.body(b).unwrap().position().y + 2.0).abs() < 1e-3, "{:?}", w.body(b).unwrap().position());
    assert!((w.joint(j).unwrap().force().y - 3.0 * 9.81).abs() < 0.05);
}

#[test]
fn gears_turn_together_and_keep_momentum() {
    let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
    let frame = rod_body(&mut w, [0.0, 0.0, 0.0], [1.0, 0.1, 0.1], 5.0);
    let wheel = |w: &mut World, x: f64, r: f32, m: f32| {
        let mut d = BodyDesc::dynamic().at([x, 0.0, 0.5]).shape(ShapeDesc::cylinder(0.05, r).mass(m));
        d.rotation = Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
        w.add_body(d).unwrap()
    };
    let a = wheel(&mut w, -0.5, 0.3, 1.0);
    let b = wheel(&mut w, 0.5, 0.6, 4.0);
    let ja = w.add_joint(JointDesc::hinge(frame, a, [-0.5, 0.0, 0.5], Vec3::Z)).unwrap();
    let jb = w.add_joint(JointDesc::hinge(frame, b, [0.5, 0.0, 0.5], Vec3::Z)).unwrap();
    w.add_joint(JointDesc::gear(ja, jb, 2.0)).unwrap();
    w.add_angular_impulse(a, Vec3::new(0.0, 0.0, 0.5)).unwrap();
    let before = w.momentum().angular;
    run(&mut w, 2.0);
    let (qa, qb) = (w.joint(ja).unwrap().coordinate(), w.joint(jb).unwrap().coordinate());
    assert!(qa.abs() > 1.0 && (qa + 2.0 * qb).abs() < 0.01, "{qa} {qb}");
    assert!((w.momentum().angular - before).length() < 2e-4, "{:?} for {before:?}", w.momentum().angular);
}

/// A wheel that is led turns its partner, however the hinges' ends are named and though the partner has fallen asleep before; at rest
/// it holds him. One led wheel turns partners who share nothing else.
#[test]
fn gears_follow_what_is_led() {
    for turned in [false, true] {
        let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
        let hinge = |w: &mut World, body: BodyId, at: [f64; 3]| {
            let post = w.add_body(BodyDesc::fixed()).unwrap();
            let (a, b) = if turned { (body, post) } else { (post, body) };
            w.add_joint(JointDesc::hinge(a, b, at, Vec3::Z)).unwrap()
        };
        let wheel =
            |d: BodyDesc, x: f64| d.at([x, 0.0, 0.0]).shape(ShapeDesc::cuboid([0.3, 0.3, 0.05]).mass(2.0));
        let led = w.add_body(wheel(BodyDesc::kinematic(), 0.0)).unwrap();
        let on_led = hinge(&mut w, led, [0.0; 3]);
        let partners = [(2.0, 2.0), (-2.0, -0.5)].map(|(x, ratio)| {
            let body = w.add_body(wheel(BodyDesc::dynamic(), x)).unwrap();
            let own = hinge(&mut w, body, [x, 0.0, 0.0]);
            w.add_joint(JointDesc::gear(on_led, own, ratio)).unwrap();
            (body, ratio)
        });
        run(&mut w, 2.0);
        assert!(partners.iter().all(|&(b, _)| !w.body(b).unwrap().is_awake()));
        w.set_angular_velocity(led, Vec3::new(0.0, 0.0, 3.0)).unwrap();
        run(&mut w, 4.0);
        let q = f64::from(w.joint(on_led).unwrap().coordinate());
        assert!((q.abs() - 12.0).abs() < 0.06, "{q}");
        for (body, ratio) in partners {
            let spin = w.body(body).unwrap().angular_velocity().z;
            assert!((spin + 3.0 / ratio).abs() < 0.01, "{spin} by {ratio}");
        }
        // It does not yield to what pushes the partner.
        w.set_angular_velocity(led, Vec3::ZERO).unwrap();
        run(&mut w, 0.5);
        w.add_angular_impulse(partners[0].0, Vec3::new(0.0, 0.0, 1.0)).unwrap();
        run(&mut w, 0.5);
        let spin = w.body(partners[0].0).unwrap().angular_velocity().z;
        assert!(spin.abs() < 0.01, "{spin}");
    }
}

#[test]
fn a_rack_follows_its_pinion() {
    let mut w = world();
    let wall = anchor(&mut w);
    let mut d = BodyDesc::dynamic().at([0.0, 0.0, 0.0]).shape(ShapeDesc::cylinder(0.05, 0.25).mass(1.0));
    d.rotation = Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
    let pinion = w.add_body(d).unwrap();
    let rack = rod_body(&mut w, [0.0, -0.3, 0.0], [1.0, 0.05, 0.05], 2.0);
    let hinge = w
        .add_joint(JointDesc::hinge(wall, pinion, [0.0; 3], Vec3::Z).motor(MotorDesc::velocity(2.0, 50.0)))
        .unwrap();
    let slider = w.add_joint(JointDesc::slider(wall, rack, [0.0, -0.3, 0.0], Vec3::X)).unwrap();
    // v = ω r: q_hinge − q_slider / r = 0.
    w.add_joint(JointDesc::gear(hinge, slider, -4.0)).unwrap();
    run(&mut w, 1.0);
    let (q, x) = (w.joint(hinge).unwrap().coordinate(), w.joint(slider).unwrap().coordinate());
    assert!((q - 2.0).abs() < 0.05 && (x - 0.25 * q).abs() < 2e-3, "{q} {x}");
}

#[test]
fn a_pulley_balances_by_its_ratio() {
    let mut w = world();
    let a = ball(&mut w, [-1.0, -1.0, 0.0], 0.1, 2.0);
    let b = ball(&mut w, [1.0, -1.0, 0.0], 0.1, 1.0);
    let kind = JointKind::Pulley {
        wheel_a: DVec3::new(-1.0, 1.0, 0.0),
        wheel_b: DVec3::new(1.0, 1.0, 0.0),
        ratio: 1.0,
        length: None,
    };
    let mut d = JointDesc::rod(a, b, [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]);
    d.kind = kind;
    let j = w.add_joint(d).unwrap();
    run(&mut w, 0.5);
    // Atwood: a = g (m₁ − m₂)/(m₁ + m₂) = g/3.
    let want = 9.81 / 3.0 * 0.5;
    let (va, vb) = (w.body(a).unwrap().velocity().y, w.body(b).unwrap().velocity().y);
    assert!((va + want).abs() < 0.01 && (vb - want).abs() < 0.01, "{va} {vb}");
    let JointKind::Pulley { length: Some(l), .. } = *w.joint(j).unwrap().kind() else { panic!() };
    assert!((l - 4.0).abs() < 1e-6);
}

#[test]
fn a_bead_stays_on_its_wire() {
    let mut w = world();
    let wall = anchor(&mut w);
    let points: Vec<Vec3> = (0..33)
        .map(|i| {
            let t = core::f32::consts::PI * (1.0 + i as f32 / 32.0);
            Vec3::new(f32s::cos(t), f32s::sin(t), 0.0)
        })
        .collect();
    let b = ball(&mut w, [-1.0, 0.0, 0.0], 0.05, 1.0);
    let path = PathDesc { points, closed: false, aligned: false, axis: AxisDesc::FREE };
    let mut d = JointDesc::ball(wall, b, [0.0; 3]).kind(JointKind::Path(Box::new(path)));
    d.frames = jounce::JointFrames::Local(Pose::IDENTITY, Pose::IDENTITY);
    let j = w.add_joint(d).unwrap();
    w.apply(jounce::Command::SetCanSleep(b, false)).unwrap();
    let e0 = w.energy().total();
    let mut off = 0.0;
    for _ in 0..600 {
        w.step().unwrap();
        let p = w.body(b).unwrap().position();
        off = f64s::max(off, (p.length() - 1.0).abs());
    }
    assert!(off < 2e-3, "{off}");
    // A circle of radius 1, frictionless: it swings to and fro, up to where it came from.
    let e = w.energy().total();
    assert!((e - e0).abs() < 0.15, "{e} for {e0}");
    assert!((0.0..=3.2).contains(&w.joint(j).unwrap().coordinate()));
}

#[test]
fn cone_and_twist_hold_a_limb() {
    let mut w = world();
    let wall = anchor(&mut w);
    let b = rod_body(&mut w, [0.5, 0.0, 0.0], [0.5, 0.05, 0.1], 1.0);
    let j = w.add_joint(JointDesc::ball(wall, b, [0.0; 3]).cone_twist(0.5, -0.3, 0.3)).unwrap();
    w.add_angular_impulse(b, Vec3::new(0.05, 0.0, 0.0)).unwrap();
    let (mut cone, mut twist) = (0.0_f32, 0.0_f32);
    for _ in 0..300 {
        w.step().unwrap();
        let r = w.joint(j).unwrap();
        cone = f32s::max(cone, r.coordinate());
        let q = w.body(b).unwrap().rotation();
        twist = f32s::max(twist, 2.0 * f32s::atan2(q.x, q.w).abs());
    }
    assert!(cone > 0.45 && cone < 0.5 + 0.05, "{cone}");
    assert!(twist > 0.2 && twist < 0.3 + 0.05, "{twist}");
}

#[test]
fn joints_break_at_their_force_and_not_before() {
    for (mass, breaks) in [(9.0, false), (11.0, true)] {
        let mut w = world();
        let wall = anchor(&mut w);
        let b = ball(&mut w, [0.0, -1.0, 0.0], 0.1, mass);
        let j =
            w.add_joint(JointDesc::ball(wall, b, [0.0, -1.0, 0.0]).breaks_at(98.1, f32::INFINITY)).unwrap();
        let mut told = 0;
        for _ in 0..60 {
            w.step().unwrap();
            told += w
                .events()
                .iter()
                .filter(|e| matches!(e, Event::JointBreak { joint, .. } if *joint == j))
                .count();
        }
        assert_eq!(told, usize::from(breaks), "{mass} kg");
        assert_eq!(w.joint(j).unwrap().is_broken(), breaks);
        if breaks {
            assert!(w.body(b).unwrap().position().y < -2.0);
        }
    }
}

#[test]
fn jointed_bodies_pass_through_each_other_until_the_joint_goes() {
    let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
    let a = ball(&mut w, [0.0, 0.0, 0.0], 0.5, 1.0);
    let b = ball(&mut w, [0.4, 0.0, 0.0], 0.5, 1.0);
    w.step().unwrap();
    assert_eq!(w.counts().contacts, 1);
    let j = w.add_joint(JointDesc::ball(a, b, [0.2, 0.0, 0.0])).unwrap();
    assert_eq!(w.counts().contacts, 0);
    run(&mut w, 0.2);
    let apart = (w.body(b).unwrap().position() - w.body(a).unwrap().position()).length();
    assert!(apart < 0.46, "{apart} {}", w.joint(j).unwrap().gap());
    w.remove_joint(j).unwrap();
    run(&mut w, 1.0);
    assert!((w.body(b).unwrap().position() - w.body(a).unwrap().position()).length() > 0.9);
}

#[test]
fn joined_bodies_sleep_and_wake_together() {
    let mut w = world();
    let wall = anchor(&mut w);
    let mut last = wall;
    let mut all = Vec::new();
    for i in 0..5 {
        let y = -0.3 * f64::from(i);
        let b = rod_body(&mut w, [0.0, y - 0.15, 0.0], [0.05, 0.15, 0.05], 1.0);
        w.add_joint(JointDesc::ball(last, b, [0.0, y, 0.0])).unwrap();
        all.push(b);
        last = b;
    }
    run(&mut w, 2.0);
    assert!(all.iter().all(|&b| !w.body(b).unwrap().is_awake()));
    w.add_impulse(all[4], Vec3::new(0.5, 0.0, 0.0), None).unwrap();
    assert!(all.iter().all(|&b| w.body(b).unwrap().is_awake()));
}

#[test]
fn a_kinematic_body_drags_what_hangs_on_it() {
    let mut w = world();
    let hand = w.add_body(BodyDesc::kinematic().at([0.0, 0.0, 0.0])).unwrap();
    let b = ball(&mut w, [0.0, -1.0, 0.0], 0.1, 1.0);
    w.add_joint(JointDesc::rod(hand, b, [0.0; 3], [0.0, -1.0, 0.0])).unwrap();
    run(&mut w, 2.0);
    assert!(!w.body(b).unwrap().is_awake());
    w.set_velocity(hand, Vec3::new(1.0, 0.0, 0.0)).unwrap();
    run(&mut w, 4.0);
    let (h, p) = (w.body(hand).unwrap().position(), w.body(b).unwrap().position());
    assert!(h.x > 3.9 && (p - h).length() < 1.001 && (p - h).length() > 0.999, "{h:?} {p:?}");
}

/// Four bars in a square, three hinges and a fourth that closes the loop, twice over-determined in space.
#[test]
fn loops_hold() {
    let mut w = world();
    let wall = anchor(&mut w);
    let mut d = BodyDesc::dynamic()
        .at([0.0, -0.5, 0.0])
        .shape(ShapeDesc::cuboid(Vec3::new(0.05, 0.5, 0.05)).mass(1.0));
    d.can_sleep = false;
    let left = w.add_body(d.clone()).unwrap();
    d.position = DVec3::new(1.0, -0.5, 0.0);
    let right = w.add_body(d).unwrap();
    let bottom = rod_body(&mut w, [0.5, -1.0, 0.0], [0.5, 0.05, 0.05], 1.0);
    let at = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, -1.0, 0.0]];
    let pairs = [(wall, left), (wall, right), (left, bottom), (right, bottom)];
    let joints: Vec<JointId> = at
        .iter()
        .zip(pairs)
        .map(|(p, (a, b))| w.add_joint(JointDesc::hinge(a, b, *p, Vec3::Z)).unwrap())
        .collect();
    w.add_impulse(bottom, Vec3::new(3.0, 0.0, 1.0), None).unwrap();
    let mut gap = 0.0;
    let mut swing = 0.0;
    for _ in 0..600 {
        w.step().unwrap();
        gap = joints.iter().map(|&j| w.joint(j).unwrap().gap()).fold(gap, f32s::max);
        swing = f64s::max(swing, w.body(bottom).unwrap().position().x - 0.5);
        let q = w.body(bottom).unwrap().rotation();
        assert!(q.angle() < 0.02, "a parallelogram's bar stays level: {q:?}");
    }
    assert!(gap < 1e-3 && swing > 0.3, "{gap} {swing}");
}

#[test]
fn an_isolated_ragdoll_of_joints_keeps_its_momentum() {
    let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
    let trunk = rod_body(&mut w, [0.0; 3], [0.2, 0.4, 0.1], 30.0);
    let mut limbs = Vec::new();
    for (x, y) in [(-1.0, 0.4), (1.0, 0.4), (-1.0, -0.4), (1.0, -0.4)] {
        let upper = rod_body(&mut w, [0.4 * x, y, 0.0], [0.2, 0.05, 0.05], 3.0);
        let lower = rod_body(&mut w, [0.8 * x, y, 0.0], [0.2, 0.04, 0.04], 2.0);
        w.add_joint(JointDesc::ball(trunk, upper, [0.2 * x, y, 0.0]).cone_twist(1.0, -0.5, 0.5)).unwrap();
        w.add_joint(JointDesc::hinge(upper, lower, [0.6 * x, y, 0.0], Vec3::Y).limited(-1.0, 1.0)).unwrap();
        limbs.push(lower);
    }
    w.add_impulse(limbs[0], Vec3::new(1.0, 8.0, 5.0), None).unwrap();
    w.add_impulse(limbs[3], Vec3::new(0.0, 3.0, -6.0), None).unwrap();
    let before = w.momentum();
    let (mut p, mut l) = (0.0, 0.0);
    for _ in 0..600 {
        w.step().unwrap();
        let now = w.momentum();
        p = f64s::max(p, (now.linear - before.linear).length());
        l = f64s::max(l, (now.angular - before.angular).length());
    }
    let (p0, l0) = (before.linear.length(), before.angular.length());
    println!("Δp {:.2e} of {p0:.2}, ΔL {:.2e} of {l0:.2}", p, l);
    assert!(p < 1e-5 * p0 && l < 1e-3 * l0, "{p} {l}");
}

/// Twelve by twelve balls of 0.2 kg, half a metre apart on ball joints, hung by the corners: balls, joints between them, those of the corners.
fn hung_net(w: &mut World) -> (Vec<BodyId>, Vec<JointId>, Vec<JointId>) {
    const N: u32 = 12;
    let hook = anchor(w);
    let mut grid = Vec::new();
    for y in 0..N {
        for x in 0..N {
            let at = [f64::from(x) * 0.5, 0.0, f64::from(y) * 0.5];
            grid.push(ball(w, at, 0.1, 0.2));
        }
    }
    let at = |w: &World, i: u32| w.body(grid[i as usize]).unwrap().position();
    let mut joints = Vec::new();
    for y in 0..N {
        for x in 0..N {
            let i = y * N + x;
            for (other, ok) in [(i + 1, x + 1 < N), (i + N, y + 1 < N)] {
                if ok {
                    let middle = (at(w, i) + at(w, other)) * 0.5;
                    let d = JointDesc::ball(grid[i as usize], grid[other as usize], middle);
                    joints.push(w.add_joint(d).unwrap());
                }
            }
        }
    }
    let hooks: Vec<JointId> = [0, N - 1, N * (N - 1), N * N - 1]
        .into_iter()
        .map(|i| w.add_joint(JointDesc::ball(hook, grid[i as usize], at(w, i))).unwrap())
        .collect();
    (grid, joints, hooks)
}

/// A hundred kilograms in the middle of a net of 28 kg: soft rows let it flow apart, so what is loaded is solved directly, from the step on
/// in which it is.
#[test]
fn a_light_net_holds_a_heavy_body() {
    let mut w = world();
    let (grid, joints, hooks) = hung_net(&mut w);
    let middle = grid[78];
    w.apply(Command::SetCanSleep(middle, false)).unwrap();
    run(&mut w, 2.0);
    let heavy = jounce::geometry::MassProperties {
        mass: 100.0,
        center: Vec3::ZERO,
        inertia: jounce::math::Mat3::IDENTITY.scale(0.4),
    };
    w.apply(Command::SetMass(middle, Some(heavy))).unwrap();
    w.step().unwrap();
    let mut other = w.clone();
    run(&mut w, 8.0);
    run(&mut other, 8.0);
    assert_eq!(w.hash(), other.hash());
    let gap = joints.iter().map(|&j| w.joint(j).unwrap().gap()).fold(0.0, f32s::max);
    assert!(gap < 1e-3, "{gap}");
    let pull: f32 = hooks.iter().map(|&j| w.joint(j).unwrap().force().y).sum();
    let weight = (100.0 + 143.0 * 0.2) * 9.81;
    println!("gap {:.1e} m, {:.1} N for {weight:.1}", gap, pull.abs());
    assert!((pull.abs() / weight - 1.0).abs() < 0.05, "{pull} N for {weight}");
    assert!(w.body(middle).unwrap().velocity().length() < 0.5);
}

/// A net of ball joints is solved row by row by itself, and a chain where that is asked for.
#[test]
fn the_iterative_solver_holds_too() {
    let mut w = world();
    let (grid, joints, hooks) = hung_net(&mut w);
    run(&mut w, 0.1);
    // The middle falls freely at first: the corners' pull comes later.
    let middle = grid[78];
    let v = w.body(middle).unwrap().velocity().y;
    assert!((v + 0.981).abs() < 0.05, "{v}");
    run(&mut w, 14.9);
    // It hangs: the corners carry its weight, and the middle is below them.
    let pull: f32 = hooks.iter().map(|&j| w.joint(j).unwrap().force().y).sum();
    let weight = 144.0 * 0.2 * 9.81;
    assert!((pull.abs() / weight - 1.0).abs() < 0.02, "{pull} N for {weight}");
    let sag = -w.body(middle).unwrap().position().y;
    assert!(sag > 0.5, "{sag}");
    let gap = joints.iter().map(|&j| w.joint(j).unwrap().gap()).fold(0.0, f32s::max);
    // Flat as it hangs, its pull is many times its weight; soft rows yield some centimetres of the 50 between two balls.
    assert!(gap < 0.05, "{gap}");
}

/// A net in flight falls as one body, and keeps its momentum and its spin.
#[test]
fn a_net_in_flight_keeps_its_momenta() {
    let mut w = world();
    let n = 10;
    let place = |x: usize, y: usize| [x as f64 * 0.5, 0.0, y as f64 * 0.5];
    let mut grid = Vec::new();
    for y in 0..n {
        for x in 0..n {
            let b = ball(&mut w, place(x, y), 0.1, 0.2);
            // Spins in its plane, and moves along.
            let r = Vec3::new(x as f32 * 0.5 - 2.25, 0.0, y as f32 * 0.5 - 2.25);
            w.set_velocity(b, Vec3::Y.cross(r) * 2.0 + Vec3::X * 3.0).unwrap();
            w.set_angular_velocity(b, Vec3::Y * 2.0).unwrap();
            grid.push(b);
        }
    }
    for y in 0..n {
        for x in 0..n {
            for (u, v) in [(x + 1, y), (x, y + 1)] {
                if u < n && v < n {
                    let [p, q] = [place(x, y), place(u, v)];
                    let middle = [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
                    w.add_joint(JointDesc::ball(grid[y * n + x], grid[v * n + u], middle)).unwrap();
                }
            }
        }
    }
    // About the centre of mass, which falls.
    let about = |w: &World| {
        let mass = (n * n) as f64 * 0.2;
        let c = grid.iter().map(|&b| w.body(b).unwrap().position()).fold(DVec3::ZERO, |s, p| s + p)
            / (n * n) as f64;
        let m = w.momentum();
        (c, m.linear, m.angular - c.cross(m.linear), mass)
    };
    let (c0, p0, l0, mass) = about(&w);
    run(&mut w, 1.0);
    let (c, p, l, _) = about(&w);
    // Semi-implicit steps of h fall by g t (t + h)/2.
    let fall = c - c0 - DVec3::new(3.0, -0.5 * 9.81 * (1.0 + 1.0 / 240.0), 0.0);
    assert!(fall.length() < 1e-3, "{fall:?}");
    let change = p - p0 - DVec3::new(0.0, -9.81 * mass, 0.0);
    assert!(change.length() < 1e-3 * p0.length(), "{change:?} of {p0:?}");
    assert!((l - l0).length() < 0.01 * l0.length(), "{l:?} for {l0:?}");
}

/// Row by row, a lever of hundreds of metres leaves of a light body's give along it only rounding: the block of the point was
/// indefinite, and impulses went to infinity.
#[test]
fn a_lever_of_300_metres_makes_no_energy() {
    let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
    let far = DVec3::new(180.0, 170.0, -165.0);
    let a = ball(&mut w, [0.0, 0.0, 0.0], 0.1, 0.2);
    let b = ball(&mut w, [far.x, far.y, far.z], 0.1, 0.2);
    w.add_joint(JointDesc::ball(a, b, DVec3::ZERO).solver(JointSolver::Iterative)).unwrap();
    w.set_velocity(a, Vec3::new(1.0, -2.0, 0.5)).unwrap();
    let start = w.energy().total();
    for _ in 0..240 {
        w.step().unwrap();
        let now = w.energy().total();
        assert!(now < 1.01 * start, "{now} J of {start}");
    }
}

/// A cable of ropes with weights gained energy out of nothing (from 0 to 100 J in a second): a rope took part only where the velocities
/// of free fall stretched it, so inner ones held in every other substep. Ropes that pull must do what rods do.
#[test]
fn a_cable_of_ropes_rests_as_one_of_rods() {
    let mut w = world();
    let hook = anchor(&mut w);
    let n = 9;
    let at = |k: i32| {
        let x = f64::from(k);
        let u = 2.0 * x / f64::from(n + 1) - 1.0;
        DVec3::new(x, 2.0 * u * u, 0.0)
    };
    let (mut last, mut p) = (hook, at(0));
    let mut all = Vec::new();
    for k in 1..=n {
        let (q, low) = (at(k), at(k) - DVec3::Y * 2.0);
        let node = ball(&mut w, q.to_array(), 0.1, 60.0);
        let load = ball(&mut w, low.to_array(), 0.3, 1600.0);
        w.add_joint(JointDesc::rope(node, load, q, low, 2.0)).unwrap();
        w.add_joint(JointDesc::rope(last, node, p, q, (q - p).length() as f32)).unwrap();
        all.extend([node, load]);
        (last, p) = (node, q);
    }
    let q = at(n + 1);
    w.add_joint(JointDesc::rope(last, hook, p, q, (q - p).length() as f32)).unwrap();
    all.iter().for_each(|&b| w.apply(jounce::Command::SetCanSleep(b, false)).map(drop).unwrap());
    let e0 = w.energy().total();
    for _ in 0..600 {
        w.step().unwrap();
        // Equal weights at equal distances hang in a parabola: it is at rest, to rounding of an energy of 2e5 J.
        let fastest = all.iter().map(|&b| w.body(b).unwrap().velocity().length()).fold(0.0, f32s::max);
        assert!(fastest < 0.05, "{fastest} m/s after {} s", w.time());
    }
    let gain = w.energy().total() - e0;
    assert!(gain < 1.0, "{gain} J");
}

/// Rods and ropes solved row by row were quarantined in their first step: the damper across a rod that takes no part has infinite
/// compliance, and infinity times no impulse is no number.
#[test]
fn rods_and_ropes_hang_row_by_row_too() {
    for rope in [false, true] {
        let mut w = world();
        let hook = anchor(&mut w);
        let a = ball(&mut w, [1.0, 0.0, 0.0], 0.1, 1.0);
        let b = ball(&mut w, [2.0, 0.0, 0.0], 0.1, 1.0);
        let points = [(hook, a, 0.0), (a, b, 1.0)];
        for (from, to, x) in points {
            let (p, q) = ([x, 0.0, 0.0], [x + 1.0, 0.0, 0.0]);
            let d = if rope { JointDesc::rope(from, to, p, q, 1.0) } else { JointDesc::rod(from, to, p, q) };
            w.add_joint(d.solver(JointSolver::Iterative)).unwrap();
        }
        let mut stretch = 0.0;
        for _ in 0..300 {
            w.step().unwrap();
            let told = w.events().iter().any(|e| matches!(e, Event::Quarantine { .. }));
            assert!(!told, "quarantined");
            stretch = w.joints().map(|j| w.joint(j).unwrap().gap()).fold(stretch, f32s::max);
        }
        // Soft rows of 60 Hz under a few times the weight: c = F/(m (2π f)²), some 0.3 mm a rod, more at the bottom of the swing.
        assert!(stretch < 0.02, "{stretch}");
        assert!(w.body(b).unwrap().position().length() > 1.0);
    }
}

#[test]
fn jointed_worlds_have_the_same_bits_on_any_thread_count_and_as_clones() {
    let build = || {
        let mut w = world();
        w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap();
        for k in 0..6 {
            let z = f64::from(k) * 2.0;
            let mut last = anchor(&mut w);
            for i in 0..8 {
                let x = f64::from(i);
                let b = rod_body(&mut w, [x + 0.5, 3.0, z], [0.45, 0.1, 0.2], 1.0 + i as f32);
                let joint = match (i + k) % 4 {
                    0 => JointDesc::hinge(last, b, [x, 3.0, z], Vec3::Z).limited(-0.5, 0.5),
                    1 => JointDesc::ball(last, b, [x, 3.0, z]).cone_twist(0.6, -0.2, 0.2),
                    2 => JointDesc::rope(last, b, [x - 0.1, 3.0, z], [x + 0.1, 3.0, z], 0.4),
                    _ => JointDesc::fixed(last, b, [x, 3.0, z]).breaks_at(400.0, 200.0),
                };
                w.add_joint(joint).unwrap();
                last = b;
            }
        }
        w
    };
    let mut one = build();
    let mut four = build();
    four.set_tasks(Tasks::pool(4));
    let mut chaos = build();
    chaos.set_tasks(Tasks::chaos(7));
    let mut copy = None;
    for i in 0..240 {
        one.step().unwrap();
        four.step().unwrap();
        chaos.step().unwrap();
        assert_eq!(one.hash(), four.hash(), "step {i}");
        assert_eq!(one.hash(), chaos.hash(), "step {i}");
        if i == 60 {
            copy = Some(one.clone());
        } else if let Some(copy) = &mut copy {
            copy.step().unwrap();
            assert_eq!(one.hash(), copy.hash(), "clone, step {i}");
        }
    }
    assert!(one.joints().any(|j| one.joint(j).unwrap().is_broken()));
}

/// A steering wheel goes round more than once from end to end.
#[test]
fn ends_of_a_hinge_may_be_turns_apart() {
    let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
    let a = anchor(&mut w);
    let b = rod_body(&mut w, [0.0; 3], [0.5, 0.1, 0.1], 1.0);
    let hinge = JointDesc::hinge(a, b, [0.0; 3], Vec3::Z).limited(-7.0, 7.0);
    let j = w.add_joint(hinge.motor(MotorDesc::velocity(4.0, 10.0))).unwrap();
    run(&mut w, 3.0);
    let angle = w.joint(j).unwrap().coordinate();
    assert!((angle - 7.0).abs() < 0.02, "{angle}");
}

#[test]
fn ends_that_no_body_reaches_are_refused() {
    let mut w = world();
    let a = anchor(&mut w);
    let b = ball(&mut w, [0.0; 3], 0.1, 1.0);
    let beyond = AxisDesc::FREE.limited(3.5, 7.0);
    let swung = AxisDesc::FREE.limited(-1.0, 2.0);
    let wheel = |spin, steer| JointKind::Wheel { suspension: AxisDesc::LOCKED, spin, steer };
    let turned = |angular| JointKind::Generic { linear: [AxisDesc::LOCKED; 3], angular };
    let free = AxisDesc::FREE;
    let room = "expected ends that leave room within ±π rad";
    let swing = "expected within ±π/2 rad, where a swing is measured";
    for (kind, part) in [
        (JointKind::Hinge(beyond), room),
        (JointKind::Hinge(free.limited(-7.0, -3.5)), room),
        (wheel(beyond, AxisDesc::LOCKED), room),
        (turned([beyond, free, free]), room),
        (wheel(free, swung), swing),
        (turned([free, swung, free]), swing),
        (turned([free, free, swung]), swing),
    ] {
        let told = w.add_joint(JointDesc::ball(a, b, [0.0; 3]).kind(kind.clone())).expect_err("refused");
        assert!(told.to_string().contains(part), "{kind:?}: {told}");
    }
    w.add_joint(JointDesc::ball(a, b, [0.0; 3]).kind(turned([swung, free.limited(-1.5, 1.5), free])))
        .unwrap();
}

#[test]
fn equal_points_of_a_path_are_named() {
    let mut w = world();
    let a = anchor(&mut w);
    let b = ball(&mut w, [0.0; 3], 0.1, 1.0);
    let mut told = |points: &[[f32; 3]], closed| {
        let points = points.iter().map(|p| Vec3::from(*p)).collect();
        let path = PathDesc { points, closed, aligned: false, axis: AxisDesc::FREE };
        let d = JointDesc::ball(a, b, [0.0; 3]).kind(JointKind::Path(Box::new(path)));
        w.add_joint(d).map_or_else(|e| e.to_string(), |_| String::new())
    };
    let (o, x, y) = ([0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]);
    let text = told(&[o, x, x, y], false);
    assert!(
        text.contains("points is [1.0, 0.0, 0.0] at both points[1] and points[2], expected points that"),
        "{text}"
    );
    let text = told(&[o, x, y, o], true);
    assert!(text.contains("at both points[3] and points[0]") && text.contains("goes back"), "{text}");
    assert_eq!((told(&[o, x, y, o], false), told(&[o, x, y], true)), (String::new(), String::new()));
}

#[test]
fn bad_joints_are_refused_by_name() {
    let mut w = world();
    let a = anchor(&mut w);
    let b = ball(&mut w, [0.0; 3], 0.1, 1.0);
    let gone = ball(&mut w, [1.0; 3], 0.1, 1.0);
    w.remove_body(gone).unwrap();
    let nan = f32::NAN;
    let bad = [
        JointDesc::ball(a, a, [0.0; 3]),
        JointDesc::ball(a, gone, [0.0; 3]),
        JointDesc::ball(a, b, [f64::NAN, 0.0, 0.0]),
        JointDesc::hinge(a, b, [0.0; 3], Vec3::ZERO),
        JointDesc::hinge(a, b, [0.0; 3], Vec3::X).limited(1.0, -1.0),
        JointDesc::hinge(a, b, [0.0; 3], Vec3::X).limited(nan, 1.0),
        JointDesc::hinge(a, b, [0.0; 3], Vec3::X).motor(MotorDesc::velocity(nan, 1.0)),
        JointDesc::hinge(a, b, [0.0; 3], Vec3::X).motor(MotorDesc::velocity(1.0, -1.0)),
        JointDesc::rope(a, b, [0.0; 3], [0.0; 3], -1.0),
        JointDesc::rope(a, b, [0.0; 3], [0.0; 3], nan),
        JointDesc::spring(a, b, [0.0; 3], [1.0; 3], SpringDesc::newton(-1.0, 0.0)),
        JointDesc::spring(a, b, [0.0; 3], [1.0; 3], SpringDesc::hertz(0.0, 0.0)),
        JointDesc::ball(a, b, [0.0; 3]).cone_twist(9.0, 0.0, 0.0),
        JointDesc::ball(a, b, [0.0; 3]).breaks_at(0.0, 1.0),
        JointDesc::ball(a, b, [0.0; 3]).named("x".repeat(300)),
        JointDesc::gear(JointId::from_bits(3), JointId::from_bits(4), 1.0),
    ];
    for d in bad {
        let kind = d.kind.clone();
        let error = w.add_joint(d).expect_err("accepted");
        let text = error.to_string();
        assert!(text.contains("joint") || text.contains("body") || text.contains("gear"), "{kind:?}: {text}");
    }
    assert_eq!(w.counts().joints, 0);
    let j = w.add_joint(JointDesc::ball(a, b, [0.0; 3])).unwrap();
    assert!(w.set_joint(j, JointKind::Fixed).is_err());
    w.remove_body(b).unwrap();
    assert!(w.joint(j).is_err());
}

/// A wall of glued bricks stands as one block, holds a push below its mortar's strength and falls apart beyond it.
#[test]
fn mortar_holds_a_wall_until_it_is_hit() {
    let build = |strength: f32| {
        let mut w = world();
        w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap();
        let mut bricks = Vec::new();
        for row in 0..10 {
            for i in 0..8 {
                let x = (f64::from(i) + 0.5 * f64::from(row % 2)) * 0.24;
                let at = [x, 0.05 + 0.1 * f64::from(row), 0.0];
                let shape = ShapeDesc::cuboid(Vec3::new(0.12, 0.05, 0.06)).density(1800.0);
                bricks.push(w.add_body(BodyDesc::dynamic().at(at).shape(shape)).unwrap());
            }
        }
        let joints = w.glue(&bricks, &jounce::GlueDesc::new(strength)).unwrap();
        // 7 in each row side by side, and 15 between two rows: a brick lies on two, those at one end on one.
        assert_eq!(joints.len(), 10 * 7 + 9 * 15);
        (w, bricks, joints)
    };
    let hit = |w: &mut World| {
        w.add_body(
            BodyDesc::dynamic()
                .at([0.9, 0.6, 2.0])
                .velocity(Vec3::new(0.0, 0.0, -10.0))
                .shape(ShapeDesc::sphere(0.15).mass(20.0)),
        )
        .unwrap();
    };
    let broken =
        |w: &World, joints: &[JointId]| joints.iter().filter(|&&j| w.joint(j).unwrap().is_broken()).count();
    let (mut w, bricks, joints) = build(1e5);
    run(&mut w, 2.0);
    assert_eq!(broken(&w, &joints), 0, "it stands");
    assert!(bricks.iter().all(|&b| !w.body(b).unwrap().is_awake()), "and sleeps");
    hit(&mut w);
    run(&mut w, 2.0);
    let gone = broken(&w, &joints);
    assert!(gone > 20, "{gone} of {} break", joints.len());
    // A hundredfold holds.
    let (mut w, _, joints) = build(1e8);
    hit(&mut w);
    run(&mut w, 2.0);
    assert_eq!(broken(&w, &joints), 0);
}

/// Friction only takes: a tree of bodies in free flight whose joints rub never gains energy, whatever the directions.
#[test]
fn friction_of_joints_only_takes_energy() {
    let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
    // They pass through one another: joints alone act.
    let filter = jounce::Filter { group: -1, ..Default::default() };
    let mut part = |at: [f64; 3], half: [f32; 3], mass| {
        let shape = ShapeDesc::cuboid(Vec3::from(half)).mass(mass).filter(filter);
        w.add_body(BodyDesc::dynamic().at(at).shape(shape)).unwrap()
    };
    let hub = part([0.0; 3], [0.3, 0.3, 0.3], 4.0);
    let (mut tips, mut links) = (Vec::new(), Vec::new());
    for (i, (x, z)) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)].into_iter().enumerate() {
        let along = |d: f64| [x * d, 0.0, z * d];
        let half = if z == 0.0 { [0.25, 0.06, 0.1] } else { [0.1, 0.06, 0.25] };
        let upper = part(along(0.6), half, 1.0);
        let lower = part(along(1.2), half, 0.7);
        links.push((hub, upper, along(0.3), 1.0));
        links.push((upper, lower, along(0.9), 0.2 * (1.0 + i as f32)));
        tips.push(lower);
    }
    for (a, b, at, friction) in links {
        let kind = JointKind::Ball(jounce::BallDesc { friction, ..Default::default() });
        w.add_joint(JointDesc::ball(a, b, at).kind(kind)).unwrap();
    }
    w.add_impulse(tips[0], Vec3::new(0.1, 1.5, 0.8), None).unwrap();
    w.add_impulse(tips[1], Vec3::new(0.5, 0.3, -1.2), None).unwrap();
    w.add_angular_impulse(tips[2], Vec3::new(0.05, 0.03, 0.08)).unwrap();
    w.add_angular_impulse(hub, Vec3::new(0.0, 1.5, 0.0)).unwrap();
    let (before, start) = (w.momentum(), w.energy().kinetic);
    let (mut last, mut gained) = (start, 0.0);
    for _ in 0..600 {
        w.step().unwrap();
        let now = w.energy().kinetic;
        gained += f64s::max(now - last, 0.0);
        last = now;
    }
    let l = (w.momentum().angular - before.angular).length() / before.angular.length();
    println!("{start:.2} J to {last:.2} J, gained {gained:.2e} on the way, ΔL {l:.1e}");
    // Rounding alone.
    assert!(gained < 1e-5 * start && l < 1e-5, "{gained} of {start}, {l}");
    assert!(last < 0.9 * start, "it rubs");
}

/// Chains on a motor's arms come to its speed and swing outward, friction in their joints or not; a strong motor is not outrun.
#[test]
fn a_motor_is_not_outrun_by_friction() {
    for friction in [0.0, 1.0, 4.0] {
        let mut w = world();
        let wall = anchor(&mut w);
        let wheel = rod_body(&mut w, [0.0; 3], [2.0, 0.1, 0.3], 50.0);
        let motor = MotorDesc::velocity(1.237, 4000.0);
        w.add_joint(JointDesc::hinge(wall, wheel, [0.0; 3], Vec3::Y).motor(motor)).unwrap();
        for x in [-2.0, 2.0] {
            let mut last = wheel;
            for i in 0..5 {
                let y = -0.3 * f64::from(i);
                let link = rod_body(&mut w, [x, y - 0.15, 0.0], [0.03, 0.15, 0.03], 0.3);
                let ball =
                    jounce::BallDesc { friction: friction / f32::from(1 + i as u8), ..Default::default() };
                w.add_joint(JointDesc::ball(last, link, [x, y, 0.0]).kind(JointKind::Ball(ball))).unwrap();
                last = link;
            }
            let seat = ball(&mut w, [x, -1.7, 0.0], 0.2, 20.0);
            w.add_joint(JointDesc::ball(last, seat, [x, -1.5, 0.0])).unwrap();
        }
        let mut fastest = 0.0;
        for _ in 0..900 {
            w.step().unwrap();
            fastest = f32s::max(fastest, w.body(wheel).unwrap().angular_velocity().y);
        }
        let now = w.body(wheel).unwrap().angular_velocity().y;
        assert!(
            fastest < 1.237 + 1e-3 && now > 1.2,
            "friction {friction}: at most {fastest}, in the end {now}"
        );
    }
}

/// How far a joint parts is told for every kind that holds a point.
#[test]
fn gaps_are_told_for_every_kind() {
    let off = [0.03, -0.04, 0.0];
    let gap = |kind: JointKind| {
        let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
        let wall = anchor(&mut w);
        let b = ball(&mut w, [1.0, 0.0, 0.0], 0.1, 1.0);
        let j = w.add_joint(JointDesc::ball(wall, b, [1.0, 0.0, 0.0]).kind(kind)).unwrap();
        assert!(w.joint(j).unwrap().gap() < 1e-6);
        w.teleport(b, DVec3::new(1.0 + off[0], off[1], off[2]), Quat::IDENTITY).unwrap();
        w.joint(j).unwrap().gap()
    };
    let near = |got: f32, want: f32| assert!((got - want).abs() < 1e-5, "{got} for {want}");
    let (free, locked) = (jounce::AxisDesc::FREE, jounce::AxisDesc::LOCKED);
    near(gap(JointKind::Fixed), 0.05);
    near(gap(JointKind::Slider(free)), 0.04);
    near(gap(JointKind::Generic { linear: [locked, free, locked], angular: [free; 3] }), 0.03);
    near(gap(JointKind::Generic { linear: [locked; 3], angular: [free; 3] }), 0.05);
    near(gap(JointKind::Wheel { suspension: free, spin: free, steer: locked }), 0.03);
    near(gap(JointKind::Wheel { suspension: locked, spin: free, steer: locked }), 0.05);
}

/// A gear keeps its joints; by a new ratio it stands right where it stands.
#[test]
fn gears_change_their_ratio_and_nothing_else() {
    let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
    let wall = anchor(&mut w);
    let wheels = [0.0, 1.0, 2.0].map(|x| rod_body(&mut w, [x, 0.0, 0.0], [0.2, 0.2, 0.05], 1.0));
    let hinges = [0, 1, 2]
        .map(|i| w.add_joint(JointDesc::hinge(wall, wheels[i], [i as f64, 0.0, 0.0], Vec3::Z)).unwrap());
    let gear = w.add_joint(JointDesc::gear(hinges[0], hinges[1], 2.0)).unwrap();
    w.set_angular_velocity(wheels[0], Vec3::Z).unwrap();
    run(&mut w, 1.0);
    let spin = |w: &World, i: usize| w.body(wheels[i]).unwrap().angular_velocity().z;
    assert!((spin(&w, 0) + 2.0 * spin(&w, 1)).abs() < 1e-4, "{} {}", spin(&w, 0), spin(&w, 1));
    let e = w.set_joint(gear, JointKind::Gear { a: hinges[0], b: hinges[2], ratio: 1.0 }).unwrap_err();
    assert!(e.to_string().contains("the joint that it has"), "{e}");
    let before = w.joint(hinges[0]).unwrap().coordinate();
    w.set_joint(gear, JointKind::Gear { a: hinges[0], b: hinges[1], ratio: -1.0 }).unwrap();
    run(&mut w, 1.0);
    assert!((spin(&w, 0) - spin(&w, 1)).abs() < 1e-4, "{} {}", spin(&w, 0), spin(&w, 1));
    // It did not jump to where the new ratio would have had it from the start.
    assert!((w.joint(hinges[0]).unwrap().coordinate() - before).abs() < 1.0);
    // With a joint, its gears go.
    w.remove_joint(hinges[1]).unwrap();
    assert!(w.joint(gear).is_err() && w.joint(hinges[0]).is_ok());
}

/// Hinges all round hold the planks' axes twice over. The force on the bank is yet the catenary's, and none is across.
#[test]
fn a_loop_of_hinges_tells_its_true_forces() {
    let (n, mass, half) = (20, 50.0_f32, 0.5_f64);
    let mut w = world();
    let banks = anchor(&mut w);
    let phi = f64s::acos(18.0 / f64::from(n));
    let (sin, cos) = (f64s::sin(phi), f64s::cos(phi));
    let at = |k: i32| DVec3::new(f64::from(k) * cos - 9.0, -f64::from(k.min(n - k)) * sin, 0.0);
    let mut last = banks;
    let mut joints = Vec::new();
    for k in 0..n {
        let turn = Quat::from_axis_angle(Vec3::Z, if k < n / 2 { -phi } else { phi } as f32);
        let mut d = BodyDesc::dynamic().at((at(k) + at(k + 1)) * half).rotated(turn);
        (d.linear_damping, d.angular_damping) = (0.4, 0.4);
        let plank = w.add_body(d.shape(ShapeDesc::cuboid([0.47, 0.04, 0.7]).mass(mass))).unwrap();
        joints.push(w.add_joint(JointDesc::hinge(last, plank, at(k), Vec3::Z)).unwrap());
        last = plank;
    }
    joints.push(w.add_joint(JointDesc::hinge(last, banks, at(n), Vec3::Z)).unwrap());
    run(&mut w, 30.0);
    let weight = f64::from(n) * f64::from(mass) * 9.81;
    let (mut up, mut across, mut moment) = (0.0, 0.0_f32, 0.0_f32);
    for (i, &j) in joints.iter().enumerate() {
        let r = w.joint(j).unwrap();
        if i == 0 || i == n as usize {
            up += f64::from(r.force().y).abs();
        }
        across = f32s::max(across, r.force().z.abs());
        moment = f32s::max(moment, r.torque().length());
    }
    let pull = w.joint(joints[0]).unwrap().force().length();
    println!("up {up:.1} N for {weight:.1}, across {across:.2} N, moments {moment:.2} N m, pull {pull:.1} N");
    assert!((up / weight - 1.0).abs() < 0.01, "{up} for {weight}");
    assert!(across < 0.01 * weight as f32 && moment < 0.01 * weight as f32, "{across} N, {moment} N m");
}

/// Hinges of one axis say the same; each bears its part. A door of 25 kg whose centre is 0.46 m from the axis, at 3 rad/s: m ω² r = 103.5 N across.
/// Before, two hinges pulled at one another with 7 kN.
#[test]
fn hinges_of_a_door_share_its_load() {
    for n in [1, 2, 3] {
        let mut w = world();
        let post = anchor(&mut w);
        let mut door = BodyDesc::dynamic().at([0.46, 1.0, 0.0]).velocity([0.0, 0.0, -1.38]);
        door = door.angular_velocity([0.0, 3.0, 0.0]);
        let door = w.add_body(door.shape(ShapeDesc::cuboid([0.45, 1.0, 0.02]).mass(25.0))).unwrap();
        let joints: Vec<_> = (0..n)
            .map(|i| [0.0, if n == 1 { 1.0 } else { 0.2 + 1.6 * f64::from(i) / f64::from(n - 1) }, 0.0])
            .map(|at| {
                w.add_joint(JointDesc::hinge(post, door, at, Vec3::Y).breaks_at(400.0, f32::INFINITY))
                    .unwrap()
            })
            .collect();
        for _ in 0..120 {
            w.step().unwrap();
            let mut sum = Vec3::ZERO;
            let mut most: f32 = 0.0;
            for &j in &joints {
                let f = w.joint(j).unwrap().force();
                sum += f;
                most = f32s::max(most, f.length());
            }
            let across = Vec3::new(sum.x, 0.0, sum.z).length();
            assert!((across / 103.5 - 1.0).abs() < 0.02, "{n}: {across} N across");
            assert!((sum.y / (25.0 * 9.81) - 1.0).abs() < 0.02, "{n}: {} N up", sum.y);
            // Nothing asks for more of one than all bear together.
            assert!(most < 1.05 * sum.length(), "{n}: {most} N in one of {} N", sum.length());
        }
    }
}

/// Four beams welded to a square turn about its middle: each corner pulls half its beams around, and nothing bends. Before, 776 N and 428 N m.
#[test]
fn a_welded_frame_that_turns_has_no_moments() {
    let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
    let spin = 5.0;
    let beams: Vec<_> = [(0.5, 0.0), (0.0, 0.5), (-0.5, 0.0), (0.0, -0.5)]
        .into_iter()
        .map(|(x, z): (f64, f64)| {
            let half = if x == 0.0 { [0.45, 0.05, 0.05] } else { [0.05, 0.05, 0.45] };
            let v = [spin * z as f32, 0.0, -spin * x as f32];
            let beam = BodyDesc::dynamic().at([x, 0.0, z]).velocity(v).angular_velocity([0.0, spin, 0.0]);
            w.add_body(beam.shape(ShapeDesc::cuboid(half).mass(5.0))).unwrap()
        })
        .collect();
    let corners = [[0.5, 0.0, 0.5], [-0.5, 0.0, 0.5], [-0.5, 0.0, -0.5], [0.5, 0.0, -0.5]];
    let joints: Vec<_> = (0..4)
        .map(|i| w.add_joint(JointDesc::fixed(beams[i], beams[(i + 1) % 4], corners[i])).unwrap())
        .collect();
    // A beam needs m ω² r = 62.5 N from two corners, each pulling towards the other's end: 62.5/√2.
    let want = 5.0 * spin * spin * 0.5 / core::f32::consts::SQRT_2;
    for _ in 0..120 {
        w.step().unwrap();
        for &j in &joints {
            let (f, t) = (w.joint(j).unwrap().force().length(), w.joint(j).unwrap().torque().length());
            assert!((f / want - 1.0).abs() < 0.02 && t < 0.5, "{f} N for {want}, {t} N m");
        }
    }
}

/// A stiff spring on a light body carries the heavy one that hangs on it: it stretches by m g/k.
#[test]
fn a_stiff_spring_carries_what_hangs_on_a_light_limb() {
    let mut w = world();
    let hook = anchor(&mut w);
    let (k, c) = (30_000.0, 300.0);
    let limb = ball(&mut w, [0.0, -1.0, 0.0], 0.05, 0.5);
    let body = ball(&mut w, [0.0, -2.0, 0.0], 0.3, 80.0);
    w.add_joint(JointDesc::spring(hook, limb, [0.0; 3], [0.0, -1.0, 0.0], SpringDesc::newton(k, c))).unwrap();
    w.add_joint(JointDesc::ball(limb, body, [0.0, -1.0, 0.0])).unwrap();
    // It would sleep before the last of the swing is gone.
    for b in [limb, body] {
        w.apply(jounce::Command::SetCanSleep(b, false)).map(drop).unwrap();
    }
    run(&mut w, 20.0);
    let sag = -1.0 - w.body(limb).unwrap().position().y;
    let want = 80.5 * 9.81 / f64::from(k);
    assert!((sag / want - 1.0).abs() < 0.005, "{sag} m for {want}");
}

/// What a torn set is calmed for does not touch joints that are soft, or ropes that are slack, by metres.
#[test]
fn soft_and_slack_joints_are_not_calmed() {
    let mut w = world();
    let hook = anchor(&mut w);
    let b = ball(&mut w, [0.0; 3], 0.2, 5.0);
    w.add_joint(JointDesc::ball(hook, b, [0.0; 3]).soft(SpringDesc::hertz(0.4, 0.0))).unwrap();
    // It falls by 2 g/ω², 3.1 m, and passes the middle at g/ω.
    let (mut fastest, mut lowest) = (0.0, 0.0);
    for _ in 0..75 {
        w.step().unwrap();
        let r = w.body(b).unwrap();
        fastest = f32s::max(fastest, r.velocity().length());
        lowest = f64s::min(lowest, r.position().y);
    }
    let omega = core::f64::consts::TAU * 0.4;
    assert!((f64::from(fastest) * omega / 9.81 - 1.0).abs() < 0.02, "{fastest} m/s");
    assert!((-lowest * omega * omega / (2.0 * 9.81) - 1.0).abs() < 0.02, "{lowest} m");
    for solver in [JointSolver::Direct, JointSolver::Iterative] {
        let mut w = world();
        let hook = anchor(&mut w);
        let b = ball(&mut w, [0.0, -0.5, 0.0], 0.2, 5.0);
        w.add_joint(JointDesc::rope(hook, b, [0.0; 3], [0.0, -0.5, 0.0], 8.0).solver(solver)).unwrap();
        run(&mut w, 1.0);
        let v = w.body(b).unwrap().velocity().y;
        assert!((v + 9.81).abs() < 0.01, "falls freely: {v}");
    }
}

/// What closes a gap is a way without velocity: it counts as motion, and nothing falls asleep half-way.
#[test]
fn a_gap_that_closes_keeps_its_bodies_awake() {
    for kind in [JointKind::Ball(Default::default()), JointKind::Fixed] {
        let mut w = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
        let hook = anchor(&mut w);
        let b = ball(&mut w, [30.0, 0.0, 0.0], 0.2, 1.0);
        let frames = jounce::JointFrames::Anchors([0.0; 3].into(), [30.0, 0.0, 0.0].into());
        let j = w
            .add_joint(JointDesc { frames, ..JointDesc::ball(hook, b, [0.0; 3]).kind(kind.clone()) })
            .unwrap();
        run(&mut w, 10.0);
        let (gap, awake) = (w.joint(j).unwrap().gap(), w.body(b).unwrap().is_awake());
        assert!(gap < 1e-3 && !awake, "{kind:?}: {gap} m, awake: {awake}");
    }
}

/// A joint that is enabled when its bodies are metres apart draws them together, and swings no wilder than they fell: what was asked for
/// with the turn of A's axes made 50 kJ of 235 J, and 426 m.
#[test]
fn a_joint_that_is_enabled_late_brings_its_bodies_together() {
    let mut w = world();
    let hook = anchor(&mut w);
    let at = w.body(hook).unwrap().position();
    let mut last = hook;
    let mut joints = Vec::new();
    for i in 0..2 {
        let x = 0.4 * f64::from(i);
        let body = BodyDesc::dynamic().at(at + DVec3::X * (x + 0.2));
        let body = w.add_body(body.shape(ShapeDesc::cuboid([0.1, 0.08, 0.08]).mass(1.0))).unwrap();
        joints.push(w.add_joint(JointDesc::ball(last, body, at + DVec3::X * x)).unwrap());
        last = body;
    }
    let start = w.energy().total();
    run(&mut w, 1.0);
    w.apply(Command::SetJointEnabled(joints[1], false)).unwrap();
    run(&mut w, 1.0);
    let gap = w.joint(joints[1]).unwrap().gap();
    assert!(gap > 3.0, "{gap}");
    w.apply(Command::SetJointEnabled(joints[1], true)).unwrap();
    let mut most = f64::NEG_INFINITY;
    for _ in 0..180 {
        w.step().unwrap();
        most = f64s::max(most, w.energy().total());
    }
    let gap = w.joint(joints[1]).unwrap().gap();
    assert!(gap < 1e-3, "{gap}");
    assert!(most - start < 200.0, "gains {} J", most - start);
}

/// Soft joints were velocities that their rows had to have: beside others of another softness four bodies of 1 kg went from 152 J to 3 MJ.
#[test]
fn softness_of_all_kinds_makes_no_energy() {
    let mut w = world();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).friction(1.2))).unwrap();
    let speeds = [[-2.29, -0.02, -1.04], [2.03, 2.68, -2.21], [-3.38, -3.8, 0.89], [-2.51, 3.55, 0.85]];
    let bodies: Vec<BodyId> = speeds
        .into_iter()
        .enumerate()
        .map(|(i, v)| {
            let shape = match i {
                0 => ShapeDesc::cuboid([0.115, 0.127, 0.134]),
                1 => ShapeDesc::sphere(0.18),
                _ => ShapeDesc::capsule(0.108, 0.072),
            };
            let d = BodyDesc::dynamic().at([0.45 * i as f64, 3.0, 0.0]).velocity(Vec3::from(v));
            w.add_body(d.shape(shape.mass(1.0).friction(1.2))).unwrap()
        })
        .collect();
    let soft = [(30.0, 1.0), (2.0, 0.1), (8.0, 0.1)];
    let springs = [(3.0, 0.0, 5.0), (0.5, 0.2, 5.0), (3.0, 0.2, 60.0_f32)];
    for (i, ((hertz, ratio), (pull, damping, end))) in soft.into_iter().zip(springs).enumerate() {
        let at = [0.45 * i as f64 + 0.225, 3.0, 0.0];
        let mut d = JointDesc::hinge(bodies[i], bodies[i + 1], at, Vec3::Y);
        let axis = AxisDesc {
            limit: Some(LimitDesc::new(-end.to_radians(), end.to_radians())),
            spring: Some((0.0, SpringDesc::hertz(pull, damping))),
            ..AxisDesc::default()
        };
        (d.kind, d.softness) = (JointKind::Hinge(axis), Some(SpringDesc::hertz(hertz, ratio)));
        w.add_joint(d).unwrap();
    }
    let start = w.energy().total();
    for _ in 0..60 * 8 {
        w.step().unwrap();
        let now = w.energy().total();
        assert!(now < 1.01 * start, "{now} J of {start}");
    }
    assert!(w.energy().total() < 0.2 * start);
}

/// A body hung by a ball whose twist has ends, and no cone: where its two axes come to point apart, the twist turns without bound. It went
/// from 0.04 to 430 J.
#[test]
fn a_twist_without_a_cone_makes_no_energy() {
    for spin in [[0.3, 3.0, 0.2], [1.0, -2.0, 3.0], [-3.0, 0.5, 1.0]] {
        let mut w = world();
        let hook = anchor(&mut w);
        let shape = ShapeDesc::cuboid([0.15, 0.1, 0.05]).mass(1.0);
        let d = BodyDesc::dynamic().at([0.0, -0.3, 0.0]).angular_velocity(Vec3::from(spin)).shape(shape);
        let body = w.add_body(d).unwrap();
        let mut d = JointDesc::hinge(hook, body, [0.0; 3], Vec3::Z);
        let end = 5.0_f32.to_radians();
        let twist = Some(LimitDesc::new(-end, end));
        d.kind = JointKind::Ball(BallDesc { twist, ..BallDesc::default() });
        w.add_joint(d).unwrap();
        w.apply(Command::SetCanSleep(body, false)).unwrap();
        let start = w.energy();
        for _ in 0..60 * 12 {
            w.step().unwrap();
            let gain = w.energy().total() - start.total();
            assert!(gain < 0.05 * start.kinetic, "{gain} J of {} at {}", start.kinetic, w.time());
        }
    }
}

/// Bodies of 10 cm in a curtain of rows and columns, hung at its upper edge, row by row in lanes; the last row stands `above` the floor. Joints are
/// points alone, or have a cone that nothing reaches.
fn curtain(w: &mut World, shape: &ShapeDesc, cone: Option<f32>, above: f64) -> (Vec<BodyId>, Vec<JointId>) {
    const SIDE: i32 = 7;
    const STEP: f64 = 0.3;
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap();
    let at = |k: i32, i: i32| {
        let below = f64::from(SIDE - 1 - i);
        DVec3::new(STEP * f64::from(k), STEP * below + 0.1 + above, 0.0)
    };
    let (mut bodies, mut joints) = (Vec::new(), Vec::new());
    for k in 0..SIDE {
        for i in 0..SIDE {
            let d = if i == 0 { BodyDesc::fixed() } else { BodyDesc::dynamic() };
            let b = w.add_body(d.at(at(k, i)).shape(shape.clone()).damping(0.5, 0.5)).unwrap();
            let beside = if i > 0 { Some((1, at(k, i) + DVec3::Y * (0.5 * STEP))) } else { None };
            let before = if k > 0 { Some((SIDE as usize, at(k, i) - DVec3::X * (0.5 * STEP))) } else { None };
            for (back, p) in beside.into_iter().chain(before) {
                if i == 0 {
                    continue;
                }
                let d = JointDesc::ball(bodies[bodies.len() - back], b, p).solver(JointSolver::Iterative);
                let kind = JointKind::Ball(BallDesc { cone, ..BallDesc::default() });
                joints.push(w.add_joint(d.kind(kind)).unwrap());
            }
            bodies.push(b);
        }
    }
    (bodies, joints)
}

/// Points alone have blocks and a kernel of their own; what they do is what balls with a cone out of reach do.
#[test]
fn points_alone_do_what_balls_do() {
    for shape in [ShapeDesc::sphere(0.1), ShapeDesc::capsule(0.1, 0.06)] {
        let [points, balls] = [None, Some(3.0)].map(|cone| {
            let mut w = world();
            // The last row lies on the floor: both have a pass after contacts.
            let (bodies, joints) = curtain(&mut w, &shape.clone().mass(0.4), cone, -0.002);
            for (i, b) in bodies.iter().enumerate() {
                if w.body(*b).unwrap().kind() == BodyKind::Dynamic {
                    w.set_velocity(*b, Vec3::new(0.0, 0.0, 0.1 * (i % 7) as f32)).unwrap();
                }
            }
            run(&mut w, 0.5);
            let at: Vec<DVec3> = bodies.iter().map(|b| w.body(*b).unwrap().position()).collect();
            let forces: Vec<Vec3> = joints.iter().map(|j| w.joint(*j).unwrap().force()).collect();
            (at, forces)
        });
        let way = points.0.iter().zip(&balls.0).map(|(a, b)| (*a - *b).length()).fold(0.0, f64s::max);
        let off = points.1.iter().zip(&balls.1).map(|(a, b)| (*a - *b).length()).fold(0.0, f32s::max);
        let most = balls.1.iter().map(|f| f.length()).fold(0.0, f32s::max);
        assert!(way < 1e-3 && off < 0.02 * most, "{shape:?}: {way} m, {off} N of {most} N");
    }
}

/// The joints at the upper edge carry what hangs on them, each column its own part.
#[test]
fn a_curtain_of_points_hangs_by_its_weight() {
    let mut w = world();
    let (_, joints) = curtain(&mut w, &ShapeDesc::sphere(0.1).mass(0.4), None, 1.0);
    run(&mut w, 4.0);
    // Of each column the first joint; the others stand one below the other, and from the second column on each has one to the side.
    let mut carried = 0.0;
    for j in joints {
        let j = w.joint(j).unwrap();
        assert!(j.gap() < 1e-3, "{} m", j.gap());
        if w.body(j.body_a()).unwrap().kind() == BodyKind::Fixed {
            carried += j.force().y;
        }
    }
    let weight = 7.0 * 6.0 * 0.4 * 9.81;
    assert!((carried / weight - 1.0).abs() < 0.01, "{carried} N of {weight} N");
}

/// A second biased pass is for what contacts push. What lies elsewhere does not change a bit of a net that nothing touches.
#[test]
fn a_net_does_not_feel_what_lies_elsewhere() {
    let [alone, together] = [false, true].map(|crate_too| {
        let mut w = world();
        let (bodies, _) = curtain(&mut w, &ShapeDesc::sphere(0.1).mass(0.4), None, 1.0);
        w.set_velocity(bodies[20], Vec3::new(0.5, 0.0, 1.0)).unwrap();
        if crate_too {
            let d = BodyDesc::dynamic().at([50.0, 0.5, 0.0]).shape(ShapeDesc::cuboid([0.5; 3]));
            w.add_body(d).unwrap();
        }
        run(&mut w, 1.0);
        let at = |b: &BodyId| w.body(*b).unwrap().position().to_array().map(f64::to_bits);
        bodies.iter().map(at).collect::<Vec<_>>()
    });
    assert_eq!(alone, together);
}
