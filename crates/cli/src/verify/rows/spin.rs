//! Turning bodies: v = ω × r, constant angular momentum, and the flips of an asymmetric body.

use super::{EPS, ball, prove, run, substep, world};
use crate::verify::{Law, Row, Rows};
use jounce::geometry::MassProperties;
use jounce::math::Mat3;
use jounce::prelude::*;

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "rotation", name: "v = ω × r", run: velocity_of_points },
    Law { topic: "rotation", name: "constant spin", run: constant_spin },
    Law { topic: "rigid motion", name: "flips of an asymmetric body", run: flips },
    Law { topic: "rigid motion", name: "three spins", run: three_spins },
];

fn mass(moments: [f32; 3]) -> MassProperties {
    MassProperties { mass: 1.0, center: Vec3::ZERO, inertia: Mat3::from_diagonal(Vec3::from_array(moments)) }
}

fn velocity_of_points() -> Rows {
    let mut w = world(0.0, 60.0)?;
    let spin = DVec3::new(0.4, 1.0, -0.6);
    let id = w.add_body(
        BodyDesc::dynamic().velocity([1.0, 0.0, 2.0]).angular_velocity(spin.as_vec3()).shape(ball(0.5)),
    )?;
    run(&mut w, 1.0)?;
    let b = w.body(id)?;
    // Where a point of the body went in the last step, against v + ω × r half-way.
    let local = Vec3::new(0.3, -0.2, 0.4);
    let (before, now) = (b.interpolated_pose(0.0), b.pose());
    let moved = (now.transform_point(local) - before.transform_point(local)) / w.dt();
    let middle = (now.q.rotate(local) + before.q.rotate(local)).as_dvec3() * 0.5;
    let expected = DVec3::new(1.0, 0.0, 2.0) + spin.cross(middle);
    // The chord of an arc is shorter by (ω Δt)²/24, its middle by (ω Δt)²/8; positions round to ε and are divided by Δt.
    let angle = spin.length() * w.dt();
    let tolerance = expected.length() * angle * angle / 6.0 + 8.0 * EPS * local.as_dvec3().length() / w.dt();
    let got = expected.length() + moved.distance(expected);
    let told = b.velocity_at(b.center_of_mass() + middle).as_dvec3();
    Ok(vec![
        Row::new(
            "velocity of a point of a turning body",
            expected.length(),
            got,
            tolerance,
            "m/s",
            "v + ω × r",
        ),
        Row::new(
            "velocity that the body tells for it",
            expected.length(),
            expected.length() + told.distance(expected),
            8.0 * EPS * expected.length(),
            "m/s",
            "v + ω × r",
        ),
    ])
}

fn constant_spin() -> Rows {
    let mut w = world(0.0, 60.0)?;
    let rate = 2.0 * std::f64::consts::PI;
    let id = w.add_body(BodyDesc::dynamic().angular_velocity([0.0, rate as f32, 0.0]).shape(ball(0.5)))?;
    run(&mut w, 10.0)?;
    let q = w.body(id)?.rotation();
    let off = 2.0 * f64::from(q.y.abs()).atan2(f64::from(q.w.abs()));
    // Two roundings of the quaternion a substep, each of half an angle of ε; and ω itself.
    let n = 10.0 / substep(&w);
    let tolerance = 4.0 * EPS * n + EPS * rate * 10.0;
    Ok(vec![Row::new("angle after ten turns", 0.0, off, tolerance, "rad", "θ = ω t")])
}

fn flips() -> Rows {
    let mut w = world(0.0, 60.0)?;
    let id =
        w.add_body(BodyDesc::dynamic().angular_velocity([0.01, 1.0, 0.0]).mass(mass([1.0, 2.0, 3.0])))?;
    let h = substep(&w);
    let about_y = |w: &World| {
        let b = w.body(id)?;
        Ok::<_, jounce::Error>(b.rotation().as_dquat().inverse_rotate(b.angular_velocity().as_dvec3()).y)
    };
    let (mut times, mut before) = (Vec::new(), about_y(&w)?);
    while times.len() < 5 && w.time() < 120.0 {
        w.step()?;
        let now = about_y(&w)?;
        if before * now <= 0.0 && before != now {
            times.push(w.time() - w.dt() * now / (now - before));
        }
        before = now;
    }
    let time = |i: usize| times.get(i).copied().unwrap_or(f64::NAN);
    // The splitting is second order: a part (ω h)² of the time, ω = 1. Rotation and momentum are kept in f64 meanwhile.
    let tolerance = |t: f64| h * h * t;
    let source = "Euler's equations, I = (1, 2, 3), ω = (0.01, 1, 0)";
    let period = 20.75461;
    Ok(vec![
        Row::new("first flip", 10.37730, time(0), tolerance(10.37730), "s", source),
        Row::new(
            "from the first flip to the second",
            period,
            time(1) - time(0),
            tolerance(period),
            "s",
            source,
        ),
        Row::new(
            "from the fourth flip to the fifth",
            period,
            time(4) - time(3),
            tolerance(period),
            "s",
            source,
        ),
    ])
}

fn three_spins() -> Rows {
    let steps: u32 = if prove() { 1_000_000 } else { 100_000 };
    let spins = [
        ("asymmetric body about its middle axis", [1.0, 2.0, 3.0], [0.01, 1.0, 0.0]),
        ("tumbling book", [0.4, 1.0, 1.3], [3.0, 2.0, 1.0]),
        ("wobbling coin", [1.0, 2.0, 1.0], [0.5, 8.0, 0.0]),
    ];
    let mut rows = Vec::new();
    for (name, moments, spin) in spins {
        let mut w = world(0.0, 60.0)?;
        let id = w.add_body(BodyDesc::dynamic().angular_velocity(spin).mass(mass(moments)))?;
        let start = w.momentum().angular;
        let energy = w.body(id)?.kinetic_energy();
        let (mut drift, mut gain) = (0.0_f64, 0.0_f64);
        for i in 0..steps {
            w.step()?;
            if i % 16 == 0 || i + 1 == steps {
                drift = drift.max(w.momentum().angular.distance(start) / start.length());
                gain = gain.max((w.body(id)?.kinetic_energy() / energy - 1.0).abs());
            }
        }
        let source = "torque-free: L is constant (vector)";
        rows.push(Row::at_most(&format!("ΔL/L in {steps} steps, {name}"), 1e-4, drift, "", source));
        // The splitting is symplectic: its energy error does not grow, and is (ω h)² of the energy at most. A rotation in f32
        // is off by about 4 ε after each step, at random, and a turn by dθ changes the energy by at most |ω| |L| dθ.
        let w2: f64 = spin.iter().map(|x| f64::from(*x) * f64::from(*x)).sum();
        let walk = 4.0 * EPS * f64::from(steps).sqrt() * w2.sqrt() * start.length() / energy;
        let limit = (w2 * substep(&w) * substep(&w) + walk).min(0.01);
        let source = "torque-free: energy; splitting of second order";
        rows.push(Row::at_most(&format!("ΔE/E in {steps} steps, {name}"), limit, gain, "", source));
    }
    Ok(rows)
}
