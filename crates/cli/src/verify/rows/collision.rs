//! Impacts: restitution, pairs, rows of balls, and surfaces that are pushed apart.

use super::{EPS, G, ball, run, substep, world};
use crate::verify::{Law, Row, Rows};
use jounce::prelude::*;
use jounce::{Result, Settings};

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "collision", name: "elastic bounces", run: elastic },
    Law { topic: "collision", name: "bounces to a stop", run: to_a_stop },
    Law { topic: "collision", name: "elastic and plastic pairs", run: pairs },
    Law { topic: "collision", name: "Coulomb impact", run: coulomb },
    Law { topic: "collision", name: "pushed back to the plane", run: pushed_back },
    Law { topic: "collision", name: "Newton's cradle", run: cradle },
];

/// A ball above a plane, without a threshold of restitution.
fn bouncing(rate_hz: f64, e: f32) -> Result<(World, BodyId)> {
    let gravity = Vec3::new(0.0, -G as f32, 0.0);
    let settings = Settings { sleep: false, restitution_speed: 0.0, ..Settings::default() };
    let mut w = World::new(WorldDesc { gravity, rate_hz, settings, ..WorldDesc::default() })?;
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).friction(0.0)))?;
    let id = w.add_body(BodyDesc::dynamic().at([0.0, 1.5, 0.0]).shape(ball(0.5).restitution(e)))?;
    Ok((w, id))
}

/// Heights of the apexes, metres above rest, until `limit_s`; the time when it last moved faster than `slow`.
fn bounces(w: &mut World, id: BodyId, limit_s: f64, slow: f64) -> Result<(Vec<f64>, f64)> {
    let (mut apexes, mut last) = (Vec::new(), 0.0);
    let mut before = w.body(id)?.velocity().y;
    let mut highest = f64::MIN;
    while w.time() < limit_s {
        w.step()?;
        let b = w.body(id)?;
        let v = b.velocity().y;
        highest = highest.max(b.position().y - 0.5);
        if f64::from(v.abs()) > slow {
            last = w.time();
        }
        if before < 0.0 && v > 0.0 {
            highest = f64::MIN;
        }
        if before > 0.0 && v <= 0.0 {
            apexes.push(highest);
        }
        before = v;
    }
    Ok((apexes, last))
}

fn elastic() -> Rows {
    let (mut w, id) = bouncing(60.0, 1.0)?;
    let v = (2.0 * G).sqrt();
    let (apexes, _) = bounces(&mut w, id, 11.0, 0.0)?;
    let source = "Kr = 1 returns to its height";
    // Speed off by 2 g h/v a bounce, so height by 4 g h/v of itself; never above 1 %.
    let tolerance = (4.0 * G * substep(&w) / v).min(0.01);
    let first = apexes.first().copied().unwrap_or(f64::NAN);
    let tenth = apexes.get(9).copied().unwrap_or(f64::NAN);
    Ok(vec![
        Row::relative("height after 1 bounce, e = 1", 1.0, first, tolerance, "m", source),
        Row::relative("height after 10 bounces, e = 1", 1.0, tenth, tolerance, "m", source),
    ])
}

fn to_a_stop() -> Rows {
    let mut rows = Vec::new();
    for rate in [60.0, 960.0] {
        let (mut w, id) = bouncing(rate, 0.5)?;
        let h = substep(&w);
        let v0 = (2.0 * G).sqrt();
        // Slower than this a bounce is shorter than four substeps.
        let slow = 2.0 * G * h;
        let (apexes, last) = bounces(&mut w, id, 4.0, slow)?;
        let path: f64 = 1.0 + 2.0 * apexes.iter().sum::<f64>();
        let expected = 3.0 * (2.0 / G).sqrt();
        // A bounce at v lasts 2 v/g, so an error of 2 g h/v of it is 4 h; as many bounces as are faster than `slow`,
        // and what is left of the geometric series below it.
        let count = (v0 / slow).log2().ceil();
        let time = 4.0 * h * count + 2.0 * slow / G / 0.5;
        // Heights v²/2g by twice that: Σ 2 (v²/2g)(4 g h/v) = Σ 4 v h over v = v0/2, v0/4, ….
        let way = 4.0 * h * v0;
        let source = "t = √(2h/g) (1+e)/(1−e), s = h (1+e²)/(1−e²); 2gΔt/v a bounce";
        let name = |what: &str| format!("{what}, h = 1, e = 0.5, {rate} Hz");
        rows.push(Row::new(&name("bounces stop after"), expected, last, time, "s", source));
        rows.push(Row::new(&name("path of the bounces"), 5.0 / 3.0, path, way, "m", source));
        let first = apexes.first().copied().unwrap_or(f64::NAN);
        let tolerance = (2.0 * 2.0 * G * h / v0).min(0.01);
        rows.push(Row::relative(&name("first bounce"), 0.25, first, tolerance, "m", "e² h"));
    }
    Ok(rows)
}

fn pairs() -> Rows {
    let mut rows = Vec::new();
    for (e, m1, m2) in [(1.0, 1.0, 1.0), (1.0, 1.0, 3.0), (0.5, 1.0, 3.0), (0.0, 2.0, 1.0)] {
        let mut w = world(0.0, 60.0)?;
        let shape = |m: f64| ball(0.5).mass(m as f32).restitution(e as f32);
        let a =
            w.add_body(BodyDesc::dynamic().at([-2.0, 0.0, 0.0]).velocity([4.0, 0.0, 0.0]).shape(shape(m1)))?;
        let b = w.add_body(BodyDesc::dynamic().velocity([-1.0, 0.0, 0.0]).shape(shape(m2)))?;
        run(&mut w, 2.0)?;
        let (va, vb) = (f64::from(w.body(a)?.velocity().x), f64::from(w.body(b)?.velocity().x));
        let common = (4.0 * m1 - m2) / (m1 + m2);
        let (ea, eb) = (common - e * m2 * 5.0 / (m1 + m2), common + e * m1 * 5.0 / (m1 + m2));
        // 3 passes of 4 substeps and restitution, each a few roundings of a speed of 5.
        let tolerance = 5.0 * EPS * 64.0;
        let source = "v = (Σ m v ∓ e m Δv)/Σ m";
        let name = |n| format!("ball {n} after impact, e = {e}, {m1} kg on {m2} kg");
        rows.push(Row::new(&name(1), ea, va, tolerance, "m/s", source));
        rows.push(Row::new(&name(2), eb, vb, tolerance, "m/s", source));
    }
    Ok(rows)
}

/// A box that may not turn is thrown onto the ground.
fn thrown(mu: f64, e: f64) -> Result<(f64, f64)> {
    let gravity = Vec3::ZERO;
    let mut w = World::new(WorldDesc { gravity, settings: super::awake(), ..WorldDesc::default() })?;
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).friction(mu as f32)))?;
    let b =
        BodyDesc::dynamic().at([0.0, 1.0, 0.0]).velocity([3.0, -4.0, 0.0]).locks(jounce::AxisLocks::ROTATION);
    let id = w.add_body(b.shape(ShapeDesc::cuboid([0.5; 3]).friction(mu as f32).restitution(e as f32)))?;
    run(&mut w, 1.0)?;
    let v = w.body(id)?.velocity();
    Ok((f64::from(v.x), f64::from(v.y)))
}

fn coulomb() -> Rows {
    let mut rows = Vec::new();
    let tolerance = 5.0 * EPS * 64.0;
    for (mu, e) in [(0.2, 0.0), (0.2, 0.5), (2.0, 0.0)] {
        let (vt, vn) = thrown(mu, e)?;
        let kept = (3.0 - mu * (1.0 + e) * 4.0).max(0.0);
        let name = |what: &str| format!("{what} after impact, μ = {mu}, e = {e}");
        rows.push(Row::new(
            &name("tangential speed"),
            kept,
            vt,
            tolerance,
            "m/s",
            "vt − min(μ (1+e) vn, vt)",
        ));
        rows.push(Row::new(&name("normal speed"), e * 4.0, vn, tolerance, "m/s", "e vn"));
    }
    Ok(rows)
}

fn pushed_back() -> Rows {
    let mut w = world(G, 60.0)?;
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    let id = w.add_body(BodyDesc::dynamic().at([0.0, 0.3, 0.0]).shape(ShapeDesc::cuboid([0.5; 3])))?;
    run(&mut w, 2.0)?;
    let b = w.body(id)?;
    let slop = f64::from(w.settings().slop());
    Ok(vec![
        Row::new(
            "box set 0.2 m into the ground",
            0.5,
            b.position().y,
            slop,
            "m",
            "back to the plane; contact slop",
        ),
        Row::at_most(
            "speed after it",
            slop / 0.5,
            f64::from(b.velocity().length()),
            "m/s",
            "no energy from overlap",
        ),
    ])
}

/// Speeds of `n` touching balls on a frictionless floor after the first `k` came at 2 m/s.
fn row_of_balls(n: usize, k: usize) -> Result<Vec<f64>> {
    let mut w = world(G, 60.0)?;
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).friction(0.0)))?;
    let mut ids = Vec::new();
    for i in 0..n {
        let moving = i < k;
        let x = i as f64 - if moving { 1.0 } else { 0.0 };
        let v = [if moving { 2.0 } else { 0.0 }, 0.0, 0.0];
        ids.push(
            w.add_body(BodyDesc::dynamic().at([x, 0.5, 0.0]).velocity(v).shape(ball(0.5).restitution(1.0)))?,
        );
    }
    run(&mut w, 1.5)?;
    ids.iter().map(|&id| Ok(f64::from(w.body(id)?.velocity().x))).collect()
}

fn cradle() -> Rows {
    let source = "momentum and energy: as many leave as came";
    let mut rows = Vec::new();
    for k in [1, 2] {
        let v = row_of_balls(5, k)?;
        let (stay, leave) = v.split_at(5 - k);
        let slowest = leave.iter().fold(f64::MAX, |a, b| a.min(*b));
        let most = stay.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        rows.push(Row::relative(
            &format!("speed of the last, {k} of 5 at 2 m/s"),
            2.0,
            slowest,
            0.01,
            "m/s",
            source,
        ));
        rows.push(Row::at_most(&format!("speed of the others, {k} of 5"), 0.02, most, "m/s", source));
    }
    Ok(rows)
}
