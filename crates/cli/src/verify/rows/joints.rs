//! Joints: pendulums, chains, ropes, springs, gears, beads on wires.
//!
//! Directly solved joints are symplectic to second order: a period's error is (ω h)²/24 and more for large swings, far below the
//! 0.2 % of a row (ω h = 0.013 at 240 substeps a second), and what is left is f32 and the line between two samples.

use super::{EPS, G, crossing, run, substep, world};
use crate::verify::{Law, Row, Rows};
use jounce::prelude::*;
use jounce::{AxisDesc, MotorDesc, PathDesc, Result, SpringDesc};
use std::f64::consts::{PI, TAU};

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "joints", name: "pendulum", run: pendulum },
    Law { topic: "joints", name: "thin rod", run: thin_rod },
    Law { topic: "joints", name: "double pendulum: modes", run: modes },
    Law { topic: "joints", name: "double pendulum: energy", run: double_energy },
    Law { topic: "joints", name: "100 kg on a light chain", run: light_chain },
    Law { topic: "joints", name: "a rope of 1 kg", run: light_rope },
    Law { topic: "joints", name: "bridge of 20 planks", run: bridge },
    Law { topic: "joints", name: "isolated joints", run: isolated },
    Law { topic: "joints", name: "Newton's cradle on rods", run: cradle },
    Law { topic: "joints", name: "Atwood's machine", run: atwood },
    Law { topic: "joints", name: "spring", run: spring },
    Law { topic: "joints", name: "gears", run: gears },
    Law { topic: "joints", name: "bead on a wire", run: bead },
    Law { topic: "far away", name: "pendulum at 1e6 m", run: far_pendulum },
];

fn ball_at(w: &mut World, at: DVec3, mass: f32) -> Result<BodyId> {
    w.add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::sphere(0.01).mass(mass)))
}

/// Mean period over four swings of a bob on a rod of 1 m.
fn period(at: DVec3, amplitude_deg: f64) -> Result<f64> {
    let mut w = world(G, 60.0)?;
    let hook = w.add_body(BodyDesc::fixed().at(at))?;
    let (sin, cos) = amplitude_deg.to_radians().sin_cos();
    let bob = ball_at(&mut w, at + DVec3::new(sin, -cos, 0.0), 1.0)?;
    let start = w.body(bob)?.position();
    w.add_joint(JointDesc::rod(hook, bob, at, start))?;
    let x = |w: &World| w.body(bob).map(|b| b.position().x - at.x);
    let first = crossing(&mut w, 60.0, x)?;
    let mut last = first;
    for _ in 0..4 {
        crossing(&mut w, 60.0, |w| x(w).map(|x| -x))?;
        last = crossing(&mut w, 60.0, x)?;
    }
    Ok((last - first) / 4.0)
}

fn pendulum() -> Rows {
    let all = [
        (5.0, 2.007_022),
        (30.0, 2.040_990),
        (60.0, 2.152_875),
        (90.0, 2.367_842),
        (120.0, 2.754_090),
        (150.0, 3.535_098),
        (170.0, 4.893_524),
    ];
    let mut rows = Vec::new();
    for (amplitude, expected) in all {
        let got = period(DVec3::ZERO, amplitude)?;
        // At 170° the period changes by 1 % for 0.17° of amplitude.
        let part = if amplitude > 160.0 { 0.01 } else { 0.002 };
        let name = format!("pendulum of 1 m, {amplitude}°: period");
        rows.push(Row::relative(&name, expected, got, part, "s", "2π √(L/g)/agm(1, cos θ/2)"));
    }
    Ok(rows)
}

fn far_pendulum() -> Rows {
    let (near, far) = (period(DVec3::ZERO, 60.0)?, period(DVec3::new(1e6, 1e6, -1e6), 60.0)?);
    Ok(vec![Row::relative("pendulum at 1e6 m: period", near, far, 1e-3, "s", "the same at the origin")])
}

fn thin_rod() -> Rows {
    let mut w = world(G, 60.0)?;
    let wall = w.add_body(BodyDesc::fixed())?;
    let t = 0.02_f64;
    let (sin, cos) = t.sin_cos();
    let shape = ShapeDesc::cuboid([0.002, 0.5, 0.002]).mass(1.0);
    let turn = Quat::from_axis_angle(Vec3::Z, t as f32);
    let bar = w.add_body(BodyDesc::dynamic().at([0.5 * sin, -0.5 * cos, 0.0]).rotated(turn).shape(shape))?;
    w.add_joint(JointDesc::hinge(wall, bar, [0.0; 3], Vec3::Z))?;
    let x = |w: &World| w.body(bar).map(|b| b.position().x);
    let first = crossing(&mut w, 20.0, x)?;
    let mut last = first;
    for _ in 0..4 {
        crossing(&mut w, 20.0, |w| x(w).map(|x| -x))?;
        last = crossing(&mut w, 20.0, x)?;
    }
    // Amplitude 0.02 rad and thickness 4 mm change the period by 3e-5.
    let got = (last - first) / 4.0;
    Ok(vec![Row::relative("thin rod of 1 m on a hinge: period", 1.637_947, got, 0.002, "s", "2π √(2 L/3 g)")])
}

/// Two bobs of 1 kg on rods of 1 m at small angles.
fn two_bobs(angles: [f64; 2]) -> Result<(World, [BodyId; 2])> {
    let mut w = world(G, 60.0)?;
    let hook = w.add_body(BodyDesc::fixed())?;
    let (s, c) = angles[0].sin_cos();
    let p = DVec3::new(s, -c, 0.0);
    let (s, c) = angles[1].sin_cos();
    let q = p + DVec3::new(s, -c, 0.0);
    let (a, b) = (ball_at(&mut w, p, 1.0)?, ball_at(&mut w, q, 1.0)?);
    w.add_joint(JointDesc::rod(hook, a, DVec3::ZERO, p))?;
    w.add_joint(JointDesc::rod(a, b, p, q))?;
    Ok((w, [a, b]))
}

fn modes() -> Rows {
    let mut rows = Vec::new();
    // Modes of equal bobs and rods: θ₂ = ±√2 θ₁, ω² = (2 ∓ √2) g/L.
    for (name, sign, expected) in [("slow", 1.0, 2.397_199), ("fast", -1.0, 5.787_351)] {
        let (mut w, [a, _]) = two_bobs([0.02, sign * 0.02 * 2.0_f64.sqrt()])?;
        let x = |w: &World| w.body(a).map(|b| b.position().x);
        let first = crossing(&mut w, 20.0, x)?;
        let mut last = first;
        for _ in 0..4 {
            crossing(&mut w, 40.0, |w| x(w).map(|x| -x))?;
            last = crossing(&mut w, 40.0, x)?;
        }
        // The angles' squares: up to 1e-4; the fast mode has ω h = 0.024.
        let got = 4.0 * TAU / (last - first);
        let name = format!("double pendulum, {name} mode");
        rows.push(Row::relative(&name, expected, got, 0.002, "rad/s", "√((2 ∓ √2) g/L)"));
    }
    Ok(rows)
}

fn double_energy() -> Rows {
    let (mut w, _) = two_bobs([0.5 * PI, 0.5 * PI])?;
    let start = w.energy().total();
    let mut worst = 0.0_f64;
    for _ in 0..3600 {
        w.step()?;
        worst = worst.max((w.energy().total() - start).abs());
    }
    let name = "double pendulum from 90°, 60 s: energy drift";
    Ok(vec![Row::at_most(name, 0.01 * 4.0 * G, worst, "J", "conservation; 1 % of 4 m g L")])
}

/// Largest stretch of a chain of `n` links of `each` kg with a load on it that is pushed at 1 m/s, from 1 s to 10 s.
fn stretch(n: u32, length: f64, each: f32, load: f32) -> Result<f64> {
    let mut w = world(G, 60.0)?;
    let link = length / f64::from(n);
    let mut last = w.add_body(BodyDesc::fixed())?;
    for i in 0..n {
        let y = -link * f64::from(i);
        let shape = ShapeDesc::capsule(0.4 * link as f32, 0.1 * link as f32).mass(each);
        let b = w.add_body(BodyDesc::dynamic().at([0.0, y - 0.5 * link, 0.0]).shape(shape))?;
        w.add_joint(JointDesc::ball(last, b, [0.0, y, 0.0]))?;
        last = b;
    }
    let radius = 0.3;
    let weight = BodyDesc::dynamic().at([0.0, -length - f64::from(radius), 0.0]);
    let weight = w.add_body(weight.shape(ShapeDesc::sphere(radius).mass(load)))?;
    w.add_joint(JointDesc::ball(last, weight, [0.0, -length, 0.0]))?;
    w.add_impulse(weight, Vec3::new(load, 0.0, 0.0), None)?;
    run(&mut w, 1.0)?;
    let mut worst = 0.0_f64;
    for _ in 0..540 {
        w.step()?;
        let b = w.body(weight)?;
        let end = b.position() + b.rotation().rotate(Vec3::Y * radius).as_dvec3();
        worst = worst.max(end.length() / length - 1.0);
    }
    Ok(worst)
}

fn light_chain() -> Rows {
    let got = stretch(50, 5.0, 0.02, 100.0)?;
    let source = "rigid links: 20 g each under 100 kg; promise of 1 %";
    Ok(vec![Row::at_most("100 kg on a chain of 50 light links: stretch", 0.01, got, "", source)])
}

fn light_rope() -> Rows {
    let mut rows = Vec::new();
    for load in [1.0_f32, 10.0, 100.0, 1000.0, 10_000.0] {
        let got = stretch(20, 4.0, 0.05, load)?;
        let name = format!("rope of 1 kg in 20 pieces, load of {load} kg: stretch");
        rows.push(Row::at_most(&name, 0.01, got, "", "rigid whatever the load; promise of 1 %"));
    }
    Ok(rows)
}

/// n rods of length l and equal weight between points at the same height: tan θ_k = (k − (n−1)/2) W/H. Gives H/W and the sag.
fn polygon(n: u32, length: f64, span: f64) -> (f64, f64) {
    let slope = |h: f64, k: u32| ((f64::from(k) - 0.5 * f64::from(n - 1)) / h).atan();
    let (mut lo, mut hi) = (1e-3, 1e3);
    for _ in 0..200 {
        let mid = 0.5 * (lo + hi);
        let reach: f64 = (0..n).map(|k| length * slope(mid, k).cos()).sum();
        if reach < span { lo = mid } else { hi = mid }
    }
    (lo, -(0..n / 2).map(|k| length * slope(lo, k).sin()).sum::<f64>())
}

fn bridge() -> Rows {
    let (n, span, mass) = (20_u32, 18.0, 50.0_f32);
    let mut w = world(G, 60.0)?;
    let banks = w.add_body(BodyDesc::fixed())?;
    // Let go as a V: deeper than it will hang.
    let phi = (span / f64::from(n)).acos();
    let (sin, cos) = phi.sin_cos();
    let joint = |k: u32| {
        let fall = f64::from(k.min(n - k));
        DVec3::new(f64::from(k) * cos - 0.5 * span, -fall * sin, 0.0)
    };
    let mut last = banks;
    let mut all = Vec::new();
    for k in 0..n {
        let (a, b) = (joint(k), joint(k + 1));
        let turn = Quat::from_axis_angle(Vec3::Z, if k < n / 2 { -phi } else { phi } as f32);
        let mut d = BodyDesc::dynamic().at((a + b) * 0.5).rotated(turn);
        (d.linear_damping, d.angular_damping) = (0.4, 0.4);
        let plank = w.add_body(d.shape(ShapeDesc::cuboid([0.47, 0.04, 0.7]).mass(mass)))?;
        // The banks hold points: with hinges there too, the axes would be held twice over and share forces at random.
        w.add_joint(if k == 0 {
            JointDesc::ball(last, plank, a)
        } else {
            JointDesc::hinge(last, plank, a, Vec3::Z)
        })?;
        all.push(plank);
        last = plank;
    }
    w.add_joint(JointDesc::ball(last, banks, joint(n)))?;
    run(&mut w, 60.0)?;
    let first =
        w.joints().next().map_or(Ok(f64::NAN), |j| w.joint(j).map(|j| j.force().as_dvec3().length()))?;
    let b = w.body(all[n as usize / 2])?;
    let middle = (b.position() - b.rotation().rotate(Vec3::X * 0.5).as_dvec3()).y;
    let (h, sag) = polygon(n, 1.0, span);
    let weight = f64::from(mass) * G;
    // At rest (damped by 0.4/s for 60 s); joints hold to 0.1 % of a plank each, contacts there are none.
    let name = "20 planks between banks: sag";
    Ok(vec![
        Row::new(name, sag, -middle, 0.02, "m", "polygon of 20 rods; the catenary has 3.81418 m"),
        Row::relative(
            "20 planks between banks: pull on the bank",
            weight * h.hypot(0.5 * f64::from(n)),
            first,
            0.01,
            "N",
            "√(H² + (n m g/2)²)",
        ),
    ])
}

/// Hinges, balls, a slider, a rope and a spring between bodies that nothing else touches.
fn isolated() -> Rows {
    let mut w = world(0.0, 60.0)?;
    let mut last = None;
    let mut all = Vec::new();
    for i in 0..8 {
        let at = DVec3::new(f64::from(i), 0.0, 0.0);
        let b =
            w.add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid([0.4, 0.15, 0.1]).mass(2.0)))?;
        if let Some(a) = last {
            let p = at - DVec3::new(0.5, 0.0, 0.0);
            let joint = match i % 4 {
                0 => JointDesc::hinge(a, b, p, Vec3::Z).limited(-0.8, 0.8),
                1 => JointDesc::ball(a, b, p).cone_twist(1.0, -0.4, 0.4),
                2 => JointDesc::slider(a, b, p, Vec3::X).limited(-0.2, 0.2),
                _ => JointDesc::rod(a, b, p - DVec3::X * 0.1, p + DVec3::X * 0.1),
            };
            w.add_joint(joint)?;
        }
        all.push(b);
        last = Some(b);
    }
    let (p, q) = (w.body(all[0])?.position(), w.body(all[4])?.position());
    w.add_joint(JointDesc::spring(all[0], all[4], p, q, SpringDesc::newton(30.0, 1.0)))?;
    w.add_impulse(all[7], Vec3::new(1.0, 6.0, 3.0), None)?;
    w.add_impulse(all[2], Vec3::new(-2.0, -4.0, 1.0), None)?;
    let (mut dp, mut dl) = (0.0_f64, 0.0_f64);
    let first = w.momentum();
    let mut before = first;
    for _ in 0..600 {
        w.step()?;
        let now = w.momentum();
        dp = dp.max(now.linear.distance(before.linear));
        dl = dl.max(now.angular.distance(before.angular));
        before = now;
    }
    // Every row's impulse is applied to two bodies in up to three passes of a substep and rounds each velocity once (v up to
    // 4 m/s on 2 kg): 8 joints of up to 8 rows. Levers reach 7 m from the origin. The turn itself, second order in the
    // substep, keeps L of a body to (ω h)³.
    let scale = EPS * 4.0 * 2.0;
    let limit = scale * 8.0 * 8.0 * 2.0 * 3.0 * f64::from(w.substeps());
    Ok(vec![
        Row::at_most("Δp in a step, 8 jointed bodies", limit, dp, "kg m/s", "conservation; rounding of f32"),
        Row::at_most(
            "ΔL in a step, 8 jointed bodies",
            limit * 7.0,
            dl,
            "kg m²/s",
            "conservation; rounding of f32",
        ),
    ])
}

fn cradle() -> Rows {
    let mut w = World::new(WorldDesc {
        gravity: Vec3::new(0.0, -G as f32, 0.0),
        rate_hz: 240.0,
        settings: jounce::Settings { sleep: false, restitution_speed: 0.0, ..jounce::Settings::default() },
        ..WorldDesc::default()
    })?;
    let (radius, length) = (0.25, 2.0);
    let frame = w.add_body(BodyDesc::fixed())?;
    let mut all = Vec::new();
    for i in 0..5 {
        let pivot = DVec3::new(2.0 * radius * f64::from(i), 0.0, 0.0);
        let (sin, cos) = if i == 0 { 60_f64.to_radians().sin_cos() } else { (0.0, 1.0) };
        let at = pivot + DVec3::new(-sin, -cos, 0.0) * length;
        let shape = ShapeDesc::sphere(radius as f32).mass(1.0).friction(0.0).restitution(1.0);
        let b = w.add_body(BodyDesc::dynamic().at(at).shape(shape))?;
        w.add_joint(JointDesc::rod(frame, b, pivot, at))?;
        all.push(b);
    }
    let v = (2.0 * G * length * 0.5).sqrt();
    // Just after the impact: the last ball has hardly begun to rise.
    let speed = |w: &World, i: usize| w.body(all[i]).map(|b| b.velocity().as_dvec3().length());
    while speed(&w, 4)? < 0.5 * v && w.time() < 3.0 {
        w.step()?;
    }
    w.step()?;
    let last = speed(&w, 4)?;
    let mut rest = 0.0_f64;
    for i in 0..4 {
        rest = rest.max(speed(&w, i)?);
    }
    let h = substep(&w);
    // A substep's gravity on the way, and 1 % for the chain of impacts.
    let name = "cradle on rods: the last ball's speed";
    Ok(vec![
        Row::new(name, v, last, 0.01 * v + G * h, "m/s", "equal masses, elastic: v = √(2 g L (1 − cos 60°))"),
        Row::at_most(
            "cradle on rods: the others' speed",
            0.01 * v,
            rest,
            "m/s",
            "equal masses: they stay; 1 %",
        ),
    ])
}

fn atwood() -> Rows {
    let mut w = world(G, 60.0)?;
    let (pa, pb) = (DVec3::new(-1.0, -3.0, 0.0), DVec3::new(1.0, -3.0, 0.0));
    let (a, b) = (ball_at(&mut w, pa, 3.0)?, ball_at(&mut w, pb, 2.0)?);
    let mut d = JointDesc::rod(a, b, pa, pb);
    d.kind = JointKind::Pulley {
        wheel_a: DVec3::new(-1.0, 0.0, 0.0),
        wheel_b: DVec3::new(1.0, 0.0, 0.0),
        ratio: 1.0,
        length: None,
    };
    w.add_joint(d)?;
    run(&mut w, 1.0)?;
    // v = a t exactly up to rounding and what the relaxation of a unilateral row lets by in its first step: a Δt.
    let expected = G / 5.0;
    let got = w.body(b)?.velocity().y;
    let source = "g (m₁ − m₂)/(m₁ + m₂)";
    Ok(vec![Row::new(
        "Atwood's machine, 3 and 2 kg: speed after 1 s",
        expected,
        f64::from(got),
        expected / 60.0,
        "m/s",
        source,
    )])
}

fn spring() -> Rows {
    let mut rows = Vec::new();
    for damping in [0.0_f32, 0.4] {
        let mut w = world(0.0, 60.0)?;
        let wall = w.add_body(BodyDesc::fixed())?;
        let b = ball_at(&mut w, DVec3::new(2.0, 0.0, 0.0), 2.0)?;
        let mut d = JointDesc::spring(wall, b, [0.0; 3], [2.0, 0.0, 0.0], SpringDesc::newton(200.0, damping));
        if let JointKind::Spring { rest, .. } = &mut d.kind {
            *rest = 1.5;
        }
        w.add_joint(d)?;
        let x = |w: &World| w.body(b).map(|b| b.position().x - 1.5);
        let first = crossing(&mut w, 20.0, x)?;
        let mut last = first;
        for _ in 0..10 {
            crossing(&mut w, 20.0, |w| x(w).map(|x| -x))?;
            last = crossing(&mut w, 20.0, x)?;
        }
        let (k, m, c) = (200.0_f64, 2.0, f64::from(damping));
        let decay = c / (2.0 * m);
        let expected = TAU / (k / m - decay * decay).sqrt();
        let got = (last - first) / 10.0;
        let name = format!("spring of 200 N/m with 2 kg, {damping} N s/m: period");
        // The spring is integrated exactly; what is left is the line between two samples, (ω Δt)²/8 of a step in 10 periods.
        rows.push(Row::relative(&name, expected, got, 1e-3, "s", "2π/√(k/m − (c/2m)²)"));
        if damping > 0.0 {
            // Amplitude over the next ten periods.
            let (mut low, mut high) = (0.0_f64, 0.0_f64);
            let start = w.time();
            while w.time() < start + 1.2 * expected {
                w.step()?;
                high = high.max(x(&w)?);
            }
            run(&mut w, 9.0 * expected)?;
            let then = w.time();
            while w.time() < then + 1.2 * expected {
                w.step()?;
                low = low.max(x(&w)?);
            }
            // Peaks are read at steps: off by (ω Δt)²/8 = 0.35 % at most; how many periods lie between is known to a step.
            let periods = ((then - start) / expected).round();
            let name = "spring with 0.4 N s/m: amplitude after its periods";
            rows.push(Row::relative(
                name,
                (-decay * periods * expected).exp(),
                low / high,
                0.01,
                "",
                "e^(−c t/2m)",
            ));
        }
    }
    Ok(rows)
}

fn gears() -> Rows {
    let mut w = world(0.0, 60.0)?;
    let frame = w.add_body(BodyDesc::fixed())?;
    let mut wheel = |x: f64, r: f32| {
        let turn = Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
        let shape = ShapeDesc::cylinder(0.05, r).mass(r * 10.0);
        let b = w.add_body(BodyDesc::dynamic().at([x, 0.0, 0.0]).rotated(turn).shape(shape))?;
        w.add_joint(JointDesc::hinge(frame, b, [x, 0.0, 0.0], Vec3::Z))
    };
    let (a, b, c) = (wheel(0.0, 0.2)?, wheel(1.0, 0.4)?, wheel(2.0, 0.6)?);
    w.add_joint(JointDesc::gear(a, b, 2.0))?;
    w.add_joint(JointDesc::gear(b, c, 1.5))?;
    let axis = AxisDesc::FREE.motor(MotorDesc::velocity(3.0, 100.0));
    w.set_joint(a, JointKind::Hinge(axis))?;
    run(&mut w, 10.0)?;
    let q = |j| w.joint(j).map(|j| f64::from(j.coordinate()));
    let (qa, qb, qc) = (q(a)?, q(b)?, q(c)?);
    // Gears hold the coordinates themselves, so errors do not grow with the turns: rounding of angles of 30 rad in f32.
    let tolerance = 1e-3;
    Ok(vec![
        Row::relative("gears 1 : 2 after 30 rad", -0.5, qb / qa, tolerance, "", "q_a + 2 q_b = 0"),
        Row::relative(
            "gears 1 : 3 after 30 rad",
            1.0 / 3.0,
            qc / qa,
            tolerance,
            "",
            "the product of the ratios",
        ),
    ])
}

/// Time of a bead from rest on a wire through points until its x passes `end`.
fn slide(points: Vec<Vec3>, end: f64) -> Result<f64> {
    let mut w = world(G, 240.0)?;
    let wall = w.add_body(BodyDesc::fixed())?;
    let at = points.first().map_or(DVec3::ZERO, |p| p.as_dvec3());
    let bead = ball_at(&mut w, at, 1.0)?;
    let path = PathDesc { points, closed: false, aligned: false, axis: AxisDesc::FREE };
    let d = JointDesc::ball(wall, bead, [0.0; 3]).kind(JointKind::Path(Box::new(path)));
    w.add_joint(d.local(Pose::IDENTITY, Pose::IDENTITY))?;
    crossing(&mut w, 5.0, |w| w.body(bead).map(|b| end - b.position().x))
}

fn bead() -> Rows {
    let cycloid = |r: f64, from: f64, to: f64| -> Vec<Vec3> {
        // A little farther than it is timed.
        let phi = |i: u32| from + (to - from) * f64::from(i) / 60.0;
        (0..=62)
            .map(|i| Vec3::new((r * (phi(i) - phi(i).sin())) as f32, (-r * (1.0 - phi(i).cos())) as f32, 0.0))
            .collect()
    };
    let mut rows = Vec::new();
    for (x, straight, fastest) in [(1.0, 0.638_551, 0.582_895), (2.0, 1.009_638, 0.805_564)] {
        let line = (0..=62).map(|i| Vec3::new(x as f32, -1.0, 0.0) * (i as f32 / 60.0)).collect();
        let got = slide(line, x)?;
        let name = format!("bead on a straight wire to ({x}, 1)");
        // Half a substep of 1/960 s ahead, and the line between samples: below 0.2 %.
        rows.push(Row::relative(&name, straight, got, 0.002, "s", "√(2 (x² + y²)/(g y))"));
        let (mut lo, mut hi) = (0.1_f64, TAU - 0.1);
        for _ in 0..80 {
            let mid = 0.5 * (lo + hi);
            if (mid - mid.sin()) / (1.0 - mid.cos()) < x { lo = mid } else { hi = mid }
        }
        let got = slide(cycloid(1.0 / (1.0 - lo.cos()), 0.0, lo), x)?;
        let name = format!("bead on a cycloid to ({x}, 1)");
        // The spline through 60 points is off the cycloid near its cusp, where curvature has no bound: 1 %.
        rows.push(Row::relative(&name, fastest, got, 0.01, "s", "φ √(r/g)"));
    }
    for start in [0.5, 1.5, 2.5] {
        let got = slide(cycloid(1.0, start, PI), PI)?;
        let name = format!("bead on a cycloid from φ = {start} to the bottom");
        rows.push(Row::relative(&name, 1.003_033, got, 0.005, "s", "π √(r/g) from everywhere"));
    }
    Ok(rows)
}
