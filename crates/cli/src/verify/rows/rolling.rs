//! A solid sphere on a slope: rolls without slipping iff tan θ ≤ 3.5 μ, then with 5/7 g sin θ.

use super::{G, ShapeFriction, Slope, run, threshold, world};
use crate::verify::{Law, Row, Rows};
use jounce::Result;
use jounce::prelude::*;

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "rolling", name: "sphere on a slope", run: sphere },
    Law { topic: "rolling", name: "angle of slip", run: slip_angle },
    Law { topic: "rolling", name: "from sliding to rolling", run: bowling },
];

const RADIUS: f64 = 0.5;

/// Mean acceleration and spin-up over a second after the first half, and the slip speed at the end.
fn roll(angle: f64, mu: f64, seconds: f64) -> Result<[f64; 3]> {
    let mut w = world(G, 60.0)?;
    let friction = ShapeFriction::same(mu);
    let slope = Slope::new(&mut w, angle, friction)?;
    let id = w.add_body(
        BodyDesc::dynamic()
            .at(slope.normal * RADIUS)
            .shape(ShapeDesc::sphere(RADIUS as f32).mass(1.0).material(friction.material())),
    )?;
    let state = |w: &World| -> Result<(f64, f64)> {
        let b = w.body(id)?;
        // Rolling down is a turn about −z.
        Ok((b.velocity().as_dvec3().dot(slope.down), -f64::from(b.angular_velocity().z)))
    };
    run(&mut w, 0.5)?;
    let (v0, w0) = state(&w)?;
    run(&mut w, seconds)?;
    let (v1, w1) = state(&w)?;
    Ok([(v1 - v0) / seconds, (w1 - w0) / seconds, v1 - w1 * RADIUS])
}

fn sphere() -> Rows {
    let a = 20.0_f64.to_radians();
    let [rolls, _, slip] = roll(a, 0.5, 1.0)?;
    let [slides, spins, _] = roll(a, 0.05, 1.0)?;
    let expected = 5.0 / 7.0 * G * a.sin();
    let source = "tan θ ≤ 3.5 μ: a = 5/7 g sin θ";
    let slipping = "tan θ > 3.5 μ: a = g (sin θ − μ cos θ), α = 5/2 μ g cos θ/r";
    Ok(vec![
        Row::relative("rolling at 20°, μ = 0.5", expected, rolls, 0.01, "m/s²", source),
        Row::at_most("slip while rolling", expected / 240.0, slip.abs(), "m/s", "v = ω r; one substep of a"),
        Row::relative(
            "slipping at 20°, μ = 0.05",
            G * (a.sin() - 0.05 * a.cos()),
            slides,
            0.01,
            "m/s²",
            slipping,
        ),
        Row::relative(
            "spin-up while slipping",
            2.5 * 0.05 * G * a.cos() / RADIUS,
            spins,
            0.01,
            "rad/s²",
            slipping,
        ),
    ])
}

fn slip_angle() -> Rows {
    let mut rows = Vec::new();
    for mu in [0.1_f64, 0.2] {
        let angle = (3.5 * mu).atan();
        // 1 % above the angle the slip grows by g Δθ/cos θ > 0.03 m/s².
        let rolls = |a: f64| Ok(roll(a, mu, 1.5)?[2] < 0.02);
        let got = threshold(0.9 * angle, 1.1 * angle, 1e-3 * angle, rolls)?;
        let name = format!("largest angle of rolling, μ = {mu}");
        rows.push(Row::relative(&name, angle.to_degrees(), got.to_degrees(), 0.01, "°", "tan θ = 3.5 μ"));
    }
    Ok(rows)
}

fn bowling() -> Rows {
    let mut w = world(G, 60.0)?;
    let friction = ShapeFriction::same(0.2);
    let slope = Slope::new(&mut w, 0.0, friction)?;
    let id = w.add_body(
        BodyDesc::dynamic()
            .at(slope.normal * RADIUS)
            .velocity([7.0, 0.0, 0.0])
            .shape(ShapeDesc::sphere(RADIUS as f32).mass(1.0).material(friction.material())),
    )?;
    run(&mut w, 5.0)?;
    let v = f64::from(w.body(id)?.velocity().x);
    Ok(vec![Row::relative("ball thrown at 7 m/s without spin ends at", 5.0, v, 0.01, "m/s", "5/7 v0")])
}
