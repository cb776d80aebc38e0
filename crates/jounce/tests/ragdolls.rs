//! Ragdolls: built, dropped, driven to poses, dragged, led.
//!
//! What must hold: no joint's ends are passed by more than 3°, no two anchors part by more than 1 cm, what lies sleeps.

use jounce::geometry::HeightField;
use jounce::math::scalar::{f32s, f64s};
use jounce::prelude::*;
use jounce::{BoneJointKind, BonePose, MassSpec, PoseDrive, Ragdoll, RagdollDesc, blend_poses};
use std::f64::consts::TAU;
use std::sync::Arc;

fn world() -> World {
    World::new(WorldDesc::default()).unwrap()
}

fn weightless() -> World {
    World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap()
}

fn run(w: &mut World, seconds: f64) {
    for _ in 0..(seconds * 60.0).round() as usize {
        w.step().unwrap();
    }
}

/// How far a joint is beyond its ends, degrees.
fn beyond(w: &World, j: JointId) -> f32 {
    let r = w.joint(j).unwrap();
    let (a, b) = (r.frame_a().q, r.frame_b().q);
    let out = |v: f32, lo: f32, hi: f32| f32s::max(f32s::max(lo - v, v - hi), 0.0);
    let q = a.inverse_mul(b);
    let s = if q.w < 0.0 { -1.0 } else { 1.0 };
    let twist = 2.0 * f32s::atan2(s * q.x, s * q.w);
    let excess = match r.kind() {
        JointKind::Ball(b) => {
            let cone = out(r.coordinate(), 0.0, b.cone.unwrap());
            f32s::max(cone, b.twist.map_or(0.0, |t| out(twist, t.min, t.max)))
        }
        JointKind::Hinge(x) => x.limit.map_or(0.0, |l| out(r.coordinate(), l.min, l.max)),
        _ => 0.0,
    };
    excess.to_degrees()
}

/// Worst gap, m, and worst excess, degrees.
fn worst(w: &World, doll: &Ragdoll) -> (f32, f32) {
    doll.joints
        .iter()
        .flatten()
        .fold((0.0, 0.0), |(g, e), &j| (f32s::max(g, w.joint(j).unwrap().gap()), f32s::max(e, beyond(w, j))))
}

#[test]
fn a_human_stands_together() {
    let mut w = weightless();
    let d = RagdollDesc::human().at([1.0, 2.0, 3.0]).group(-1);
    let doll = w.add_ragdoll(&d).unwrap();
    assert_eq!((doll.bodies.len(), doll.joints.iter().flatten().count()), (14, 13));
    let (gap, excess) = worst(&w, &doll);
    // Rounding of the table: six digits of unit quaternions.
    assert!(gap < 1e-4 && excess < 0.01, "{gap} m, {excess}°");
    let mass: f32 = doll.bodies.iter().map(|&b| w.body(b).unwrap().mass()).sum();
    // Capsules of 1000 kg/m³, each whole: those of neighbours overlap.
    let volume = |s: &ShapeDesc| match s.shape {
        Shape::Capsule { half_height, radius: r } => {
            core::f32::consts::PI * r * r * (2.0 * half_height + 4.0 / 3.0 * r)
        }
        _ => panic!("a capsule"),
    };
    let want: f32 = d.bones.iter().flat_map(|b| &b.shapes).map(|s| 1000.0 * volume(s)).sum();
    assert!((mass / want - 1.0).abs() < 1e-4, "{mass} kg for {want}");
    let head = w.body(doll.bodies[d.bone("head").unwrap()]).unwrap().position();
    assert!((head.y - 2.0 - 1.65).abs() < 0.05, "{head:?}");
    run(&mut w, 1.0);
    // At rest nothing but the rest springs of the arms acts.
    let p = w.momentum();
    assert!(p.linear.length() < 1e-3, "{p:?}");
    w.remove_ragdoll(&doll).unwrap();
    assert_eq!((w.counts().bodies, w.counts().joints), (0, 0));
}

fn hills(w: &mut World) {
    let n = 33;
    let heights = (0..n * n)
        .map(|k| {
            let (i, j) = ((k % n) as f32, (k / n) as f32);
            0.4 * f32s::sin(0.7 * i) * f32s::cos(0.5 * j)
        })
        .collect();
    let field = HeightField::new(n, n, [1.0, 1.0], heights).unwrap();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::new(Shape::HeightField(Arc::new(field))))).unwrap();
}

/// 2 m apart, so that none is in another; layers of eight, each 2 m above the last, fall on one another.
fn drop_dolls(w: &mut World, n: i32, height: f64) -> Vec<Ragdoll> {
    (0..n)
        .map(|i| {
            let y = height + 2.0 * f64::from(i / 8);
            let at = [f64::from(i % 4) * 2.0 - 3.0, y, f64::from(i / 4 % 2) * 2.0];
            let q = Quat::from_axis_angle(Vec3::new(0.3, 0.8, 0.52).normalize_or(Vec3::Y), 1.1 * i as f32);
            let d = RagdollDesc::human().at(at).rotated(q).velocity([1.0, 0.0, -0.5]).group(-1 - i);
            w.add_ragdoll(&d).unwrap()
        })
        .collect()
}

/// Worst gap, m, worst excess, degrees, fastest body, m/s, and the step at which all slept, within 30 s.
fn drop_on_hills(n: i32, height: f64) -> (f32, f32, f32, Option<usize>) {
    let mut w = world();
    hills(&mut w);
    let dolls = drop_dolls(&mut w, n, height);
    let (mut gap, mut excess, mut fastest) = (0.0, 0.0, 0.0);
    for i in 0..1800 {
        w.step().unwrap();
        for d in &dolls {
            let (g, e) = worst(&w, d);
            (gap, excess) = (f32s::max(gap, g), f32s::max(excess, e));
            for &b in &d.bodies {
                fastest = f32s::max(fastest, w.body(b).unwrap().velocity().length());
            }
        }
        if w.counts().awake == 0 {
            return (gap, excess, fastest, Some(i));
        }
    }
    (gap, excess, fastest, None)
}

#[test]
fn dropped_they_hold_together_and_fall_asleep() {
    let (gap, excess, fastest, asleep) = drop_on_hills(8, 1.5);
    println!("8: gap {gap:.2e} m, beyond ends {excess:.2}°, fastest {fastest:.1} m/s, asleep {asleep:?}");
    assert!(gap < 0.01, "{gap}");
    assert!(excess < 3.0, "{excess}");
    assert!(asleep.is_some());
}

#[test]
fn a_pile_of_them_holds_together_and_falls_asleep() {
    let n = if std::env::var_os("JOUNCE_PROVE").is_some() { 64 } else { 16 };
    let (gap, excess, fastest, asleep) = drop_on_hills(n, 2.5);
    println!("{n}: gap {gap:.2e} m, beyond ends {excess:.2}°, fastest {fastest:.1} m/s, asleep {asleep:?}");
    // From the highest: √(2 g h) with the throw, and a limb that swings about it.
    assert!(fastest < 25.0, "{fastest}");
    assert!(gap < 0.01, "{gap}");
    assert!(excess < 3.0, "{excess}");
    assert!(asleep.is_some());
}

/// A pose within the ends: arms lowered, knees bent.
fn pose(d: &RagdollDesc) -> Vec<Quat> {
    let rest: Vec<Quat> = d.rest_poses().iter().map(|p| p.q).collect();
    let mut out = rest.clone();
    for (i, b) in d.bones.iter().enumerate() {
        let Some(j) = &b.joint else { continue };
        let axis = (rest[j.parent] * j.on_parent.q).rotate(Vec3::X);
        let angle = match j.kind {
            BoneJointKind::Hinge { range } => 0.5 * (range[0] + range[1]),
            BoneJointKind::Ball { twist, .. } => 0.4 * (twist[0] + twist[1]),
            BoneJointKind::Fixed => 0.0,
        };
        // Against the parent as at rest, and turned about the joint's axis.
        let turn = Quat::from_axis_angle(axis, angle);
        let carried = out[j.parent] * rest[j.parent].conjugate();
        out[i] = carried * (turn * rest[i]);
    }
    out
}

#[test]
fn driven_it_takes_a_pose_and_by_weak_strength_it_does_not() {
    for (strength, near) in [(3.0, true), (0.0, false)] {
        let mut w = weightless();
        let d = RagdollDesc::human().group(-1);
        let doll = w.add_ragdoll(&d).unwrap();
        let want = BonePose::from_rotations(&doll, &pose(&d));
        let drive = PoseDrive { strength, ..PoseDrive::default() };
        doll.drive(&mut w, &want, &drive, &[]).unwrap();
        run(&mut w, 3.0);
        let mut off: f32 = 0.0;
        for (i, b) in d.bones.iter().enumerate() {
            let Some(j) = &b.joint else { continue };
            let q = |k: usize| w.body(doll.bodies[k]).unwrap().rotation();
            let is = q(j.parent).inverse_mul(q(i));
            off = f32s::max(off, want[i].rotation.normalize().inverse_mul(is).angle());
        }
        println!("strength {strength}: off by {}°", off.to_degrees());
        assert_eq!(off < 0.12, near, "strength {strength}: {}°", off.to_degrees());
        doll.relax(&mut w).unwrap();
        run(&mut w, 0.1);
    }
}

/// Velocities are followed: an arm that swings as told lags by no more than its spring's time.
#[test]
fn driven_it_follows_a_motion() {
    let mut w = weightless();
    let mut d = RagdollDesc::human().group(-1);
    // Dry friction would hold a spring back by torque ÷ stiffness.
    d.bones.iter_mut().filter_map(|b| b.joint.as_mut()).for_each(|j| j.friction = 0.0);
    let doll = w.add_ragdoll(&d).unwrap();
    doll.set_led(&mut w, 0, true).unwrap();
    let bone = d.bone("lower_arm_l").unwrap();
    let j = d.bones[bone].joint.clone().unwrap();
    let rest = BonePose::from_rotations(&doll, &d.rest_poses().iter().map(|p| p.q).collect::<Vec<_>>());
    let axis = j.on_parent.q.rotate(Vec3::X);
    let mut worst: f32 = 0.0;
    for i in 0..240 {
        let t = i as f32 / 60.0;
        let (angle, speed) = (0.4 * (1.0 - f32s::cos(2.0 * t)), 0.8 * f32s::sin(2.0 * t));
        let mut want = rest.clone();
        want[bone] = BonePose {
            rotation: Quat::from_axis_angle(axis, angle) * rest[bone].rotation,
            velocity: axis * speed,
        };
        doll.drive(&mut w, &want, &PoseDrive::default(), &[]).unwrap();
        w.step().unwrap();
        if i > 30 {
            let is = w.joint(doll.joints[bone].unwrap()).unwrap().coordinate();
            worst = f32s::max(worst, (is - angle).abs());
        }
    }
    println!("follows within {worst} rad");
    // Told a step ahead at most, 0.8/60 rad, and a critically damped spring of 8 Hz behind an acceleration of 1.6 rad/s²: a/ω² is less
    // than a mrad; twice the step for the arm that gives way above it.
    assert!(worst < 2.0 * 0.8 / 60.0, "{worst}");
}

#[test]
fn dragged_by_a_limb_its_joints_hold() {
    let mut w = world();
    hills(&mut w);
    let d = RagdollDesc::human().at([0.0, 1.0, 0.0]).group(-1);
    let doll = w.add_ragdoll(&d).unwrap();
    run(&mut w, 2.0);
    for limb in ["lower_arm_r", "calf_l", "head"] {
        let body = doll.bodies[d.bone(limb).unwrap()];
        let start = w.body(body).unwrap().center_of_mass();
        let hand = w.grab(body, start, SpringDesc::hertz(4.0, 1.0), 3000.0).unwrap();
        let (mut gap, mut excess) = (0.0, 0.0);
        for i in 0..300 {
            let t = f64::from(i) / 60.0;
            // Up, and round in circles of 1 m, once a second.
            let up = f64s::min(2.5 * t, 2.5);
            let round = DVec3::new(f64s::cos(TAU * t) - 1.0, up, f64s::sin(TAU * t));
            w.drag(hand, start + round).unwrap();
            w.step().unwrap();
            let (g, e) = worst(&w, &doll);
            (gap, excess) = (f32s::max(gap, g), f32s::max(excess, e));
        }
        println!("dragged by {limb}: gap {gap:.2e} m, beyond ends {excess:.2}°");
        assert!(gap < 0.01, "{limb}: {gap}");
        assert!(excess < 3.0, "{limb}: {excess}");
        let hangs = w.body(doll.bodies[0]).unwrap().position().y;
        assert!(hangs > 0.5, "{limb}: lifted to {hangs}");
        w.let_go(hand).unwrap();
        run(&mut w, 1.0);
    }
    // A weak hand does not lift it.
    let body = doll.bodies[0];
    let start = w.body(body).unwrap().center_of_mass();
    let hand = w.grab(body, start, SpringDesc::hertz(4.0, 1.0), 100.0).unwrap();
    for i in 0..120 {
        w.drag(hand, start + DVec3::new(0.0, 0.05 * f64::from(i), 0.0)).unwrap();
        w.step().unwrap();
    }
    assert!(w.body(body).unwrap().position().y < start.y + 0.5);
}

#[test]
fn a_part_is_led_and_the_whole_gets_up() {
    let mut w = world();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap();
    let d = RagdollDesc::human().at([0.0, 0.5, 0.0]).group(-1);
    let doll = w.add_ragdoll(&d).unwrap();
    // Legs and pelvis are led along, the rest hangs on them.
    let led = ["pelvis", "thigh_l", "thigh_r", "calf_l", "calf_r"].map(|n| d.bone(n).unwrap());
    for b in led {
        doll.set_led(&mut w, b, true).unwrap();
    }
    let rest = doll.poses(&w).unwrap();
    let mut gap = 0.0;
    for i in 0..120 {
        let shift = DVec3::new(1.5 * f64::from(i + 1) / 60.0, 0.0, 0.0);
        let to: Vec<WorldPose> = rest.iter().map(|p| WorldPose::new(p.p + shift, p.q)).collect();
        doll.lead(&mut w, &to).unwrap();
        w.step().unwrap();
        gap = f32s::max(gap, worst(&w, &doll).0);
    }
    assert!(gap < 0.01, "{gap}");
    let head = w.body(doll.bodies[d.bone("head").unwrap()]).unwrap().position();
    assert!(head.x > 1.5, "{head:?}");
    for b in led {
        doll.set_led(&mut w, b, false).unwrap();
    }
    run(&mut w, 3.0);
    let lying = doll.poses(&w).unwrap();
    assert!(w.body(doll.bodies[0]).unwrap().position().y < 0.6);
    // Up again in a second.
    let stand = frame_poses(&d, DVec3::new(3.0, 0.02, 0.0));
    for b in 0..doll.bodies.len() {
        doll.set_led(&mut w, b, true).unwrap();
    }
    for i in 1..=60 {
        doll.lead(&mut w, &blend_poses(&lying, &stand, i as f32 / 60.0)).unwrap();
        w.step().unwrap();
    }
    for (p, q) in doll.poses(&w).unwrap().iter().zip(&stand) {
        assert!((p.p - q.p).length() < 1e-4, "{p:?} {q:?}");
    }
}

fn frame_poses(d: &RagdollDesc, at: DVec3) -> Vec<WorldPose> {
    let frame = WorldPose::new(at, Quat::IDENTITY);
    d.rest_poses().iter().map(|p| frame.compose(p)).collect()
}

#[test]
fn ragdolls_have_the_same_bits_on_any_thread_count_and_as_clones() {
    let build = || {
        let mut w = world();
        hills(&mut w);
        let dolls = drop_dolls(&mut w, 6, 1.5);
        (w, dolls)
    };
    let (mut one, dolls) = build();
    let (mut four, _) = build();
    let (mut chaos, _) = build();
    four.set_tasks(Tasks::pool(4));
    chaos.set_tasks(Tasks::chaos(3));
    let mut copy: Option<World> = None;
    let drive = |w: &mut World, i: usize| {
        if i == 60 {
            let d = RagdollDesc::human();
            let want = BonePose::from_rotations(&dolls[0], &pose(&d));
            dolls[0].drive(w, &want, &PoseDrive::default(), &[]).unwrap();
        }
    };
    for i in 0..150 {
        for w in [&mut one, &mut four, &mut chaos] {
            drive(w, i);
            w.step().unwrap();
        }
        assert_eq!(one.hash(), four.hash(), "step {i}");
        assert_eq!(one.hash(), chaos.hash(), "step {i}");
        if i == 40 {
            copy = Some(one.clone());
        } else if let Some(copy) = &mut copy {
            drive(copy, i);
            copy.step().unwrap();
            assert_eq!(one.hash(), copy.hash(), "clone, step {i}");
        }
    }
}

#[test]
fn bad_ragdolls_are_refused_by_name() {
    let mut w = world();
    let refused = |w: &mut World, d: &RagdollDesc, word: &str| {
        let e = w.add_ragdoll(d).expect_err(word).to_string();
        assert!(e.contains(word), "{word}: {e}");
        assert_eq!((w.counts().bodies, w.counts().joints), (0, 0), "{word}");
    };
    refused(&mut w, &RagdollDesc::new(Vec::new()), "bones");
    refused(&mut w, &RagdollDesc::human().group(3), "group");
    refused(&mut w, &RagdollDesc::human().at([f64::NAN, 0.0, 0.0]), "position");
    let with = |f: &dyn Fn(&mut RagdollDesc)| {
        let mut d = RagdollDesc::human();
        f(&mut d);
        d
    };
    refused(&mut w, &with(&|d| d.bones[3].joint.as_mut().unwrap().parent = 3), "parent");
    refused(&mut w, &with(&|d| d.bones[3].joint.as_mut().unwrap().strength = f32::NAN), "strength");
    refused(
        &mut w,
        &with(&|d| d.bones[3].joint.as_mut().unwrap().on_bone.q = Quat::new(0.0, 0.0, 0.0, 0.0)),
        "rotation",
    );
    refused(&mut w, &with(&|d| d.bones[5].rest.p.x = f32::INFINITY), "rest");
    let cone = BoneJointKind::Ball { cone: -1.0, twist: [0.0, 0.0] };
    refused(&mut w, &with(&|d| d.bones[13].joint.as_mut().unwrap().kind = cone), "cone");
    for mass in [MassSpec::Mass(0.0), MassSpec::Density(0.0)] {
        refused(
            &mut w,
            &with(&|d| d.bones[5].shapes.iter_mut().for_each(|s| s.mass = mass)),
            "of bone \"head\"",
        );
    }
    refused(&mut w, &with(&|d| d.bones[5].shapes.iter_mut().for_each(|s| s.sensor = true)), "shapes");
    refused(&mut w, &with(&|d| d.bones[5].shapes.clear()), "shapes");
    let doll = w.add_ragdoll(&RagdollDesc::human()).unwrap();
    assert!(doll.drive(&mut w, &[], &PoseDrive::default(), &[]).is_err());
    assert!(doll.lead(&mut w, &[]).is_err() && doll.set_led(&mut w, 99, true).is_err());
    let nan = DVec3::new(f64::NAN, 0.0, 0.0);
    assert!(w.grab(doll.bodies[0], nan, SpringDesc::hertz(1.0, 1.0), 1.0).is_err());
    let bodies = w.counts().bodies;
    assert!(w.grab(doll.bodies[0], DVec3::ZERO, SpringDesc::hertz(-1.0, 1.0), 1.0).is_err());
    let head = w.body(doll.bodies[5]).unwrap().position();
    for away in [10.5, 1e6] {
        let told = w.grab(doll.bodies[5], head + DVec3::X * away, SpringDesc::hertz(1.0, 1.0), 1.0);
        let told = told.expect_err("too far").to_string();
        assert!(told.contains("grab: point is 1") && told.contains("expected within 10 m, or ten"), "{told}");
    }
    assert_eq!(w.counts().bodies, bodies);
    let ship = BodyDesc::dynamic().shape(ShapeDesc::cuboid([5.0, 5.0, 150.0]));
    let ship = w.add_body(ship.at([0.0, 0.0, 500.0])).unwrap();
    let bow = w.grab(ship, DVec3::new(0.0, 0.0, 650.0), SpringDesc::hertz(1.0, 1.0), 1.0).unwrap();
    w.let_go(bow).unwrap();
    w.remove_body(ship).unwrap();
    w.remove_ragdoll(&doll).unwrap();
    assert!(w.remove_ragdoll(&doll).is_err() && doll.poses(&w).is_err());
}

/// Five in one place, or a few millimetres from it, push one another apart gently and stay whole: bones that were made heavy under load
/// tore them, with millions of J.
#[test]
fn ragdolls_in_one_place_part_whole() {
    for k in 0..4 {
        let mut w = world();
        w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap();
        let dolls: Vec<Ragdoll> = (0..5)
            .map(|i| {
                let [x, z] = [0.004 * f64::from(k * i), 0.003 * f64::from(k * i * i)];
                w.add_ragdoll(&RagdollDesc::human().at([x, 1.0, z]).group(-1 - i)).unwrap()
            })
            .collect();
        let (start, mut most, mut gap) = (w.energy().total(), 0.0, 0.0);
        for _ in 0..720 {
            w.step().unwrap();
            most = f64s::max(most, w.energy().total());
            gap = dolls.iter().map(|d| worst(&w, d).0).fold(gap, f32s::max);
        }
        let end = w.energy().total();
        println!("{k}: {start:.1} J, at most {most:.1} J, then {end:.1} J, gap {gap:.2e} m");
        assert!(gap < 0.01, "{k}: {gap}");
        // Pushed apart at no more than 3 m/s each.
        let pushed = dolls
            .iter()
            .flat_map(|d| &d.bodies)
            .map(|&b| 0.5 * 9.0 * f64::from(w.body(b).unwrap().mass()))
            .sum::<f64>();
        assert!(most < start + pushed && end < start, "{k}: {start} J, {most} J, {end} J, pushed {pushed} J");
    }
}

/// Who is crushed by a press that leaves no room at all is torn, whatever holds him; his bones are calmed then, instead of being driven
/// round near the speed limit for ever.
#[test]
fn a_crushed_ragdoll_does_not_fly_about() {
    let mut w = world();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap();
    let plate = BodyDesc::kinematic().at([0.0, 3.0, 0.0]).shape(ShapeDesc::cuboid([2.0, 0.5, 2.0]));
    let plate = w.add_body(plate).unwrap();
    let d = w.add_ragdoll(&RagdollDesc::human().at([0.0, 0.5, 0.0]).group(-1)).unwrap();
    run(&mut w, 0.5);
    w.set_velocity(plate, Vec3::Y * -2.6).unwrap();
    run(&mut w, 1.0);
    w.set_velocity(plate, Vec3::ZERO).unwrap();
    run(&mut w, 3.5);
    let mass: f64 = d.bodies.iter().map(|&b| f64::from(w.body(b).unwrap().mass())).sum();
    let kinetic = w.energy().kinetic;
    let speed = (2.0 * kinetic / mass).sqrt();
    println!("crushed: {kinetic:.0} J, {speed:.0} m/s");
    // A tenth of the speed limit, in the mean.
    assert!(speed < 0.1 * f64::from(jounce::Settings::default().linear_speed_max), "{speed} m/s");
}
