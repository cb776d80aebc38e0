//! Bodies that nothing touches: constant velocity, constant acceleration, projectiles.

use super::{EPS, G, ball, crossing, run, substep, world};
use crate::verify::{Law, Row, Rows};
use jounce::prelude::*;

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "motion", name: "constant velocity", run: constant_velocity },
    Law { topic: "motion", name: "constant acceleration", run: constant_acceleration },
    Law { topic: "motion", name: "order of the integrator", run: order },
    Law { topic: "projectile", name: "range, apex and time", run: projectile },
    Law { topic: "projectile", name: "both angles for a range", run: both_angles },
    Law { topic: "projectile", name: "angle for a height", run: angle_for_height },
];

/// Error of a position after `t` seconds at `speed` from rounding alone: each substep rounds v h and the sum, the
/// constant h is rounded once.
fn position_rounding(world: &World, speed: f64, t: f64) -> f64 {
    f64::from(world.substeps() + 2) * EPS * speed * t
}

fn constant_velocity() -> Rows {
    let (v, t) = (Vec3::new(3.0, -2.0, 1.5), 10.0);
    let mut w = world(0.0, 60.0)?;
    let id =
        w.add_body(BodyDesc::dynamic().velocity(v).angular_velocity([0.0, 2.0, 0.0]).shape(ball(0.5)))?;
    run(&mut w, t)?;
    let body = w.body(id)?;
    let expected = v.as_dvec3() * t;
    let tolerance = position_rounding(&w, v.as_dvec3().length(), t);
    let off = body.position().distance(expected);
    let dv = (body.velocity() - v).length() + (body.angular_velocity() - Vec3::new(0.0, 2.0, 0.0)).length();
    let source = "Newton's first law: P = P0 + v t";
    Ok(vec![
        Row::new(
            "way after 10 s without force",
            expected.length(),
            expected.length() + off,
            tolerance,
            "m",
            source,
        ),
        Row::at_most("change of v and ω without force", 0.0, f64::from(dv), "m/s", source),
    ])
}

fn fall(rate_hz: f64, t: f64) -> jounce::Result<(f64, f64, f64)> {
    let mut w = world(G, rate_hz)?;
    let id = w.add_body(BodyDesc::dynamic().velocity([0.0, 4.0, 0.0]).shape(ball(0.5)))?;
    run(&mut w, t)?;
    let body = w.body(id)?;
    Ok((body.position().y, f64::from(body.velocity().y), substep(&w)))
}

fn constant_acceleration() -> Rows {
    let (v0, t) = (4.0, 2.0);
    let (y, v, h) = fall(60.0, t)?;
    let exact = v0 * t - 0.5 * G * t * t;
    let source = "P = P0 + v0 t + a t²/2";
    // v is a sum of n = t/h roundings of numbers up to v; y of as many of that times t.
    let rounding = EPS * (t / h) * (v0 + G * t);
    let first_order = 0.5 * G * t * h;
    Ok(vec![
        Row::new("velocity after 2 s of fall", v0 - G * t, v, rounding, "m/s", "v = v0 + a t"),
        Row::new("height after 2 s of fall", exact, y, first_order + rounding * t, "m", source),
        Row::new(
            "error of the fall: a t h/2",
            -first_order,
            y - exact,
            rounding * t,
            "m",
            "semi-implicit Euler, summed",
        ),
    ])
}

fn order() -> Rows {
    let t = 2.0;
    let exact = 4.0 * t - 0.5 * G * t * t;
    let (coarse, _, h) = fall(10.0, t)?;
    let (fine, _, _) = fall(20.0, t)?;
    let (e1, e2) = ((coarse - exact).abs(), (fine - exact).abs());
    // Rounding of either error, seen through the logarithm.
    let rounding = 2.0 * EPS * (2.0 * t / h) * (4.0 + G * t) * t;
    let tolerance = 2.0 * rounding / (e2 * std::f64::consts::LN_2);
    let got = (e1 / e2).log2();
    Ok(vec![Row::new("order: error at 10 Hz against 20 Hz", 1.0, got, tolerance, "", "slope of log error")])
}

/// A shot from the origin: range, time of flight, apex height and apex time.
fn shot(speed: f64, angle: f64) -> jounce::Result<[f64; 4]> {
    let mut w = world(G, 60.0)?;
    let (sin, cos) = angle.sin_cos();
    let v = DVec3::new(speed * cos, speed * sin, 0.0).as_vec3();
    let id = w.add_body(BodyDesc::dynamic().velocity(v).shape(ball(0.1)))?;
    let apex_time = crossing(&mut w, 60.0, |w| Ok(f64::from(w.body(id)?.velocity().y)))?;
    // One of the two steps around the apex is the highest.
    let now = w.body(id)?;
    let height = now.position().y.max(now.interpolated_pose(0.0).p.y);
    let time = crossing(&mut w, 60.0, |w| Ok(w.body(id)?.position().y))?;
    let now = w.body(id)?;
    let (a, b) = (now.interpolated_pose(0.0).p, now.position());
    Ok([a.x + (b.x - a.x) * a.y / (a.y - b.y), time, height, apex_time])
}

/// Tolerances of range, time of flight, apex height and apex time: the half substep of semi-implicit Euler (the flight
/// ends h early, the apex is v h/2 low), and the parabola between two samples (g Δt²/8 in height).
fn shot_tolerances(speed: f64, angle: f64) -> [f64; 4] {
    let (dt, h) = (1.0 / 60.0, 1.0 / 240.0);
    let (sin, cos) = angle.sin_cos();
    let sag = G * dt * dt / 8.0;
    let time = h + sag / (speed * sin);
    let rounding = EPS * (2.0 * speed * sin / G / h) * speed;
    [speed * cos * time + rounding, time + rounding / G, 0.5 * speed * sin * h + sag + rounding, rounding / G]
}

fn projectile() -> Rows {
    let (s, a) = (30.0, std::f64::consts::FRAC_PI_4);
    let [range, time, height, apex] = shot(s, a)?;
    let t = shot_tolerances(s, a);
    let vy = s * a.sin();
    Ok(vec![
        Row::new("range, 30 m/s at 45°", s * s / G, range, t[0], "m", "2 vx vy/g"),
        Row::new("time of flight, 30 m/s at 45°", 2.0 * vy / G, time, t[1], "s", "2 vy/g"),
        Row::new("apex height, 30 m/s at 45°", vy * vy / (2.0 * G), height, t[2], "m", "vy²/2g"),
        Row::new("apex time, 30 m/s at 45°", vy / G, apex, t[3], "s", "vy/g"),
    ])
}

fn both_angles() -> Rows {
    let (s, r) = (30.0, 80.0);
    let low = 0.5 * (r * G / (s * s)).asin();
    let high = std::f64::consts::FRAC_PI_2 - low;
    let source = "α = asin(r g/s²)/2 and 90° − α";
    let row = |name, a| {
        Ok::<_, jounce::Error>(Row::new(name, r, shot(s, a)?[0], shot_tolerances(s, a)[0], "m", source))
    };
    Ok(vec![row("range 80 m at 30 m/s, low angle", low)?, row("range 80 m at 30 m/s, high angle", high)?])
}

fn angle_for_height() -> Rows {
    let (s, h) = (30.0, 20.0);
    let a = ((2.0 * G * h).sqrt() / s).asin();
    let got = shot(s, a)?[2];
    Ok(vec![Row::new("apex 20 m at 30 m/s", h, got, shot_tolerances(s, a)[2], "m", "α = asin(√(2 g h)/s)")])
}
