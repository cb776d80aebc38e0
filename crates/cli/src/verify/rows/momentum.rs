//! Momentum: forces and impulses, pairs, and everything that only pushes on itself.

use super::{EPS, ball, run, world};
use crate::verify::{Law, Row, Rows};
use jounce::prelude::*;
use jounce::{Momentum, Result};

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "momentum", name: "force and impulse", run: force },
    Law { topic: "momentum", name: "a pair", run: pair },
    Law { topic: "momentum", name: "an isolated system", run: isolated },
];

fn force() -> Rows {
    let mut w = world(0.0, 60.0)?;
    let pushed = w.add_body(BodyDesc::dynamic().shape(ball(0.5).mass(2.0)))?;
    let hit = w.add_body(BodyDesc::dynamic().at([5.0, 0.0, 0.0]).shape(ball(0.5).mass(2.0)))?;
    w.add_impulse(hit, Vec3::new(0.0, 0.0, 6.0), None)?;
    for _ in 0..120 {
        w.add_force(pushed, Vec3::new(3.0, 0.0, 0.0), None)?;
        w.step()?;
    }
    let v = |id| Ok::<_, jounce::Error>(w.body(id)?.velocity().as_dvec3());
    // One rounding a substep.
    let tolerance = EPS * 480.0 * 3.0;
    Ok(vec![
        Row::new("3 N for 2 s on 2 kg", 3.0, v(pushed)?.x, tolerance, "m/s", "P += F Δt, v = P/m"),
        Row::new("6 N s on 2 kg", 3.0, v(hit)?.z, 0.0, "m/s", "v = J/m"),
    ])
}

/// What rounding may do to the sum of momenta in a step: of every manifold up to 4 normal rows and one of friction, twist and
/// rolling each are applied in 3 passes of every substep (and once more for restitution), and each rounds the
/// velocity of both bodies.
fn rounding(world: &World, scale: f64, manifolds: f64) -> f64 {
    let rows = manifolds * 2.0 * (7.0 * 3.0 * f64::from(world.substeps()) + 4.0);
    EPS * rows * scale
}

/// Largest change of linear and angular momentum in a step.
fn worst(w: &mut World, steps: usize) -> Result<(f64, f64)> {
    let (mut dp, mut dl) = (0.0_f64, 0.0_f64);
    let mut before = w.momentum();
    for _ in 0..steps {
        w.step()?;
        let now: Momentum = w.momentum();
        dp = dp.max(now.linear.distance(before.linear));
        dl = dl.max(now.angular.distance(before.angular));
        before = now;
    }
    Ok((dp, dl))
}

fn pair() -> Rows {
    let mut rows = Vec::new();
    for (name, shape, offset) in [
        ("two balls head-on", ShapeDesc::sphere(0.5).restitution(1.0), 0.0),
        ("two balls off centre, rough", ShapeDesc::sphere(0.5).restitution(0.5), 0.4),
        ("two boxes off centre, rough", ShapeDesc::cuboid([0.5; 3]).restitution(0.3), 0.4),
    ] {
        let mut w = world(0.0, 60.0)?;
        w.add_body(
            BodyDesc::dynamic().at([-2.0, 0.0, 0.0]).velocity([4.0, 0.0, 0.0]).shape(shape.clone().mass(1.0)),
        )?;
        w.add_body(
            BodyDesc::dynamic().at([2.0, offset, 0.0]).velocity([-4.0, 0.0, 0.0]).shape(shape.mass(2.0)),
        )?;
        let limit = rounding(&w, 12.0, 1.0);
        let (dp, _) = worst(&mut w, 90)?;
        let name = format!("Δp in a step: {name}");
        rows.push(Row::at_most(&name, limit, dp, "kg m/s", "Newton's third law; rounding of f32"));
    }
    Ok(rows)
}

fn isolated() -> Rows {
    let mut w = world(0.0, 60.0)?;
    let (mut sum, mut arm) = (0.0, 0.0);
    for i in 0..27 {
        let at =
            DVec3::new(f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9)) * 1.6 - DVec3::splat(1.6);
        // Everything runs into the middle, with a swirl.
        let v = DVec3::new(-at.x - 0.7 * at.y, -at.y + 0.7 * at.x, -at.z + 0.3 * at.x) * 1.5;
        let shape = match i % 3 {
            0 => ShapeDesc::sphere(0.5).restitution(0.5),
            1 => ShapeDesc::cuboid([0.5, 0.4, 0.3]),
            _ => ShapeDesc::capsule(0.3, 0.3),
        };
        w.add_body(
            BodyDesc::dynamic()
                .at(at)
                .velocity(v.as_vec3())
                .angular_velocity([0.3, -0.5, 0.2])
                .shape(shape.mass(1.0)),
        )?;
        sum += v.length();
        arm += at.length() * v.length();
    }
    let (p0, l0) = (w.momentum().linear, w.momentum().angular);
    let pairs = 60.0;
    // Rounding of each body's share, so the scale is the mean speed; a body meets about 2 · 60/27 others.
    let limit = rounding(&w, sum / 27.0, pairs);
    let limit_l = rounding(&w, arm / 27.0, pairs);
    let (dp, dl) = worst(&mut w, 240)?;
    run(&mut w, 1.0)?;
    let p = w.momentum();
    let source = "conservation; rounding of f32";
    Ok(vec![
        Row::at_most("Δp in a step, 27 bodies colliding", limit, dp, "kg m/s", source),
        Row::at_most("ΔL in a step, 27 bodies colliding", limit_l, dl, "kg m²/s", source),
        Row::at_most("p after 5 s, 27 bodies", limit * 17.3, p.linear.distance(p0), "kg m/s", source),
        Row::at_most("L after 5 s, 27 bodies", limit_l * 17.3, p.angular.distance(l0), "kg m²/s", source),
    ])
}
