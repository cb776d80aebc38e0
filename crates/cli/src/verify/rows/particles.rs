//! Particles of the engine: terminal speeds, bounces, slides, counts and showers.
//!
//! A particle is stepped once a step of Δt: semi-implicit Euler, v = v₀ + a n Δt exactly and x = x₀ + v₀ t + ½ a t (t + Δt);
//! drag is implicit, its fixed point exact. Positions are f32 from the emitter's place.

use super::{EPS, G, run, world};
use crate::verify::{Law, Row, Rows};
use core::f64::consts::PI;
use jounce::prelude::*;
use jounce::{EmitDirection, ParticleSpawn, ParticleView, Result};

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "particles", name: "Stokes' drag on a particle", run: stokes },
    Law { topic: "particles", name: "quadratic drag on a particle", run: quadratic },
    Law { topic: "particles", name: "bounces of a particle", run: bounces },
    Law { topic: "particles", name: "slide of a particle", run: slide },
    Law { topic: "particles", name: "rate times time", run: rate },
    Law { topic: "particles", name: "middle of a burst", run: burst },
    Law { topic: "particles", name: "Genesis", run: genesis },
];

/// An emitter with one particle that does not age.
fn one(w: &mut World, desc: EmitterDesc, mass: f64, radius: f64, at: [f64; 3], v: [f32; 3]) -> Result<()> {
    let e = w.add_emitter(desc)?;
    let (mass, radius) = (mass as f32, radius as f32);
    let spawn = ParticleSpawn { position: at.into(), velocity: v.into(), lifetime_s: 1e5, mass, radius };
    w.emit_particles(e, vec![spawn])
}

/// The only particle, or one far away and as fast where it is lost: rows miss by it.
fn only(w: &World) -> (DVec3, DVec3) {
    let see = |p: ParticleView| (p.position, p.velocity.as_dvec3());
    w.particles().next().map_or((DVec3::splat(f64::NAN), DVec3::splat(f64::NAN)), see)
}

/// Steel in glycerin at 60 Hz: the time constant of 1.2293 ms is a fourteenth of a step.
fn stokes() -> Rows {
    let terminal = 0.010_111_5;
    let mut w = world(G, 60.0)?;
    let mut field = FieldDesc::water(1.0);
    if let FieldLaw::Water { density, viscosity, .. } = &mut field.law {
        (*density, *viscosity) = (1260.0, 1.41);
    }
    w.add_field(field)?;
    let creeping = EmitterDesc { drag_coefficient: 0.0, ..EmitterDesc::new() };
    one(&mut w, creeping, 7800.0 * 4.0 / 3.0 * PI * 1e-9, 1e-3, [0.0; 3], [0.0; 3])?;
    run(&mut w, 0.5)?;
    // Half of the reference's last digit, and a dozen roundings: mass, radius, volume, viscosity, weight less buoyancy.
    let tolerance = 5e-8 + 12.0 * EPS * terminal;
    let source = "Stokes: v = 2 r² g (ρ − ρ_f)/9η";
    Ok(vec![Row::new(
        "terminal speed of a particle, Stokes",
        terminal,
        -only(&w).1.y,
        tolerance,
        "m/s",
        source,
    )])
}

/// Fall with a terminal speed of 20 m/s: v = v_t tanh(g t/v_t).
fn quadratic() -> Rows {
    let mut w = world(G, 240.0)?;
    w.add_field(FieldDesc::new(FieldLaw::Drag { density: 1.2, viscosity: 0.0 }))?;
    // m g = ½ρ C_d π r² v_t².
    let r = 0.05;
    let mass = 0.5 * 1.2 * 0.47 * PI * r * r * 400.0 / G;
    one(&mut w, EmitterDesc::new(), mass, r, [0.0; 3], [0.0; 3])?;
    let source = "v = v_t tanh(g t/v_t), drop = v_t²/g ln cosh(g t/v_t)";
    // Implicit Euler: ½ Δt max|v″| t with max|v″| = 4/(3√3) g²/v_t.
    let slope = 0.5 * w.dt() * 0.7698 * G * G / 20.0;
    let (mut rows, mut before) = (Vec::new(), 0.0);
    for (t, v, drop) in
        [(1.0, 9.092_264, 4.720_081), (2.0, 15.069_969, 17.100_391), (5.0, 19.705_802, 72.038_122)]
    {
        run(&mut w, t - before)?;
        before = t;
        let ((p, u), error) = (only(&w), slope * t);
        rows.push(Row::new(&format!("speed of a particle after {t} s"), v, -u.y, error, "m/s", source));
        let tolerance = 0.5 * w.dt() * v + error * t;
        rows.push(Row::new(&format!("drop of a particle after {t} s"), drop, -p.y, tolerance, "m", source));
    }
    run(&mut w, 40.0)?;
    // Six roundings of v a step (sum, d, root, product, quotient, flow) against the pull of the law, 2 g Δt/v_t of what is
    // missing.
    let stall = 6.0 * 20.0 * EPS / (2.0 * G * w.dt() / 20.0);
    rows.push(Row::new(
        "terminal speed of a particle, quadratic",
        20.0,
        -only(&w).1.y,
        stall,
        "m/s",
        "m g = ½ρ C_d A v²",
    ));
    Ok(rows)
}

fn bouncing(restitution: f32, friction: f32) -> EmitterDesc {
    EmitterDesc::new().collision(ParticleCollision { restitution, friction, ..ParticleCollision::default() })
}

fn floor(w: &mut World) -> Result<BodyId> {
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))
}

/// Apexes after a fall of 1 m: K_r² of the height, bounce by bounce.
fn bounces() -> Rows {
    let mut rows = Vec::new();
    for (k_r, n) in [(0.5f32, 1), (0.8, 1), (0.8, 3), (1.0, 1), (1.0, 10)] {
        let (mut w, radius) = (world(G, 240.0)?, 0.05);
        floor(&mut w)?;
        one(&mut w, bouncing(k_r, 0.0), 0.01, radius, [0.0, 1.0 + radius, 0.0], [0.0; 3])?;
        let mut y = [1.0 + radius; 2];
        let (mut apexes, mut apex) = (0, f64::NAN);
        while apexes < n && w.time() < 20.0 {
            w.step()?;
            let now = only(&w).0.y;
            if y[0] < y[1] && y[1] >= now {
                // The parabola through three places, which is exact for the method.
                let (a, b) = ((y[0] + now) * 0.5 - y[1], (now - y[0]) * 0.5);
                (apexes, apex) = (apexes + 1, y[1] - b * b / (4.0 * a) - radius);
            }
            y = [y[1], now];
        }
        let height = (0..2 * n).fold(1.0, |h, _| h * f64::from(k_r));
        // Between two places the way is taken as straight: up to g Δt²/8 at a bounce; and the flight that begins on a grid of
        // steps is by as much lower than a stone's. Positions and speeds round to f32.
        let tolerance = f64::from(n) * (2.0 * G * w.dt() * w.dt() / 8.0 + 16.0 * EPS);
        let name = format!("apex of a particle after {n}, K_r = {k_r}");
        rows.push(Row::new(&name, height, apex, tolerance, "m", "h K_r²ⁿ"));
    }
    Ok(rows)
}

/// V_b = (1 − K_f) V_t − K_r V_n in one bounce; and along a floor, which counts as 60 bounces a second.
fn slide() -> Rows {
    let mut rows = Vec::new();
    let source = "V_b = (1 − K_f) V_t − K_r V_n";
    for k_f in [0.0f32, 0.25, 1.0] {
        let mut w = world(0.0, 60.0)?;
        floor(&mut w)?;
        one(&mut w, bouncing(0.7, k_f), 0.01, 0.05, [0.0, 1.0, 0.0], [3.0, -2.0, 1.0])?;
        run(&mut w, 1.0)?;
        let v = only(&w).1;
        // Four roundings of the speed: normal part, tangential part, factor, sum.
        let tolerance = 4.0 * EPS * 14.0f64.sqrt();
        let along = (1.0 - f64::from(k_f)) * 10.0f64.sqrt();
        let name = format!("speed along the plane after a bounce, K_f = {k_f}");
        rows.push(Row::new(&name, along, v.x.hypot(v.z), tolerance, "m/s", source));
        let name = format!("speed off the plane after it, K_f = {k_f}");
        rows.push(Row::new(&name, 0.7 * 2.0, v.y, tolerance, "m/s", source));
    }
    let (k_f, t) = (0.1f64, 0.5);
    let expected = 3.0 * jounce::math::scalar::f64s::pow(1.0 - k_f, 60.0 * t);
    for hz in [60.0, 240.0, 1000.0] {
        let mut w = world(G, hz)?;
        floor(&mut w)?;
        one(&mut w, bouncing(0.3, k_f as f32), 0.01, 0.05, [0.0, 0.05, 0.0], [3.0, 0.0, 0.0])?;
        run(&mut w, t)?;
        // It lies on the floor from the start, so every step counts; each rounds its factor and the speed.
        let tolerance = expected * 4.0 * EPS * t * hz;
        let name = format!("speed of a slide after 0.5 s, K_f = 0.1, {hz} Hz");
        rows.push(Row::new(&name, expected, only(&w).1.x, tolerance, "m/s", "(1 − K_f)^(60 t)"));
    }
    Ok(rows)
}

/// Born in all: the whole part of rate × time, whatever the step.
fn rate() -> Rows {
    let mut rows = Vec::new();
    for (rate, hz, seconds) in
        [(100.0, 60.0, 7.0), (59.94, 60.0, 10.0), (1234.5, 240.0, 3.0), (0.3, 60.0, 20.0), (1e6, 60.0, 0.5)]
    {
        let mut w = world(0.0, hz)?;
        let d = EmitterDesc::new().rate(rate).lifetime(0.05, 0.05).max_particles(1_000_000);
        let e = w.add_emitter(d)?;
        run(&mut w, seconds)?;
        let name = format!("born in {seconds} s at {rate}/s and {hz} Hz");
        let expected = (rate * seconds + 1e-6).floor();
        rows.push(Row::new(&name, expected, w.emitter(e)?.born() as f64, 0.0, "", "⌊rate × time⌋, exactly"));
    }
    Ok(rows)
}

/// 100,000 particles from a ball into a cone: their middle falls like one stone thrown with the mean velocity.
fn burst() -> Rows {
    const N: u32 = 100_000;
    let (half, t) = (PI / 6.0, 1.0);
    let axis = DVec3::new(0.6, 0.8, 0.0);
    let mut w = world(G, 240.0)?;
    let mut d =
        EmitterDesc::new().speed(4.0, 6.0).lifetime(9.0, 9.0).max_particles(N as usize).at([1.0, 2.0, 3.0]);
    d.shape = EmitterShape::Sphere { radius: 0.5, surface: false };
    d.direction = EmitDirection::Along(axis.as_vec3());
    d.drag_coefficient = 0.0;
    w.add_emitter(d.spread(half as f32).burst(0.0, N))?;
    run(&mut w, t)?;
    let mut sum = DVec3::ZERO;
    w.particles().for_each(|p| sum += p.position);
    let got = sum / f64::from(N);
    // Evenly over the solid angle the mean of cos is (1 + cos α)/2.
    let mean = axis * (5.0 * 0.5 * (1.0 + half.cos()));
    let expected = DVec3::new(1.0, 2.0, 3.0) + mean * t - DVec3::Y * (0.5 * G * t * t);
    // Variance of a place: 3/5 R² of the ball, E s² − |mean|² of the velocities; four standard deviations of the mean; and
    // semi-implicit Euler's ½ g t Δt.
    let variance = 0.6 * 0.25 + ((16.0 + 24.0 + 36.0) / 3.0 - mean.length_squared()) * t * t;
    let tolerance = 4.0 * (variance / f64::from(N)).sqrt() + 0.5 * G * t * w.dt();
    let source = "P0 + v t + ½ g t² of the means";
    Ok(vec![
        Row::new(
            "particles of a burst",
            f64::from(N),
            w.counts().particles as f64,
            0.0,
            "",
            "as many as asked for",
        ),
        Row::at_most("middle of a burst after 1 s, off by", tolerance, got.distance(expected), "m", source),
    ])
}

/// The front passes each emitter at its time, and each bears rate × duration: two generations, nothing lost.
fn genesis() -> Rows {
    let (radius, mut w) = (10.0f32, world(0.0, 60.0)?);
    let mu = G * f64::from(radius) * f64::from(radius);
    w.add_field(FieldDesc::new(FieldLaw::Point { center: DVec3::ZERO, mu, softening: 0.0 }))?;
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::sphere(radius)))?;
    let mut emitters = Vec::new();
    for d in jounce::particles::genesis(DVec3::ZERO, radius, 5) {
        // By the place on the planet, not by what the preset says of its time.
        let angle = jounce::math::scalar::f64s::acos((d.pose.p.y / f64::from(radius)).clamp(-1.0, 1.0));
        let id = w.add_emitter(EmitterDesc { auto_remove: false, ..d })?;
        emitters.push((angle, id));
    }
    let begun = |w: &World| -> Result<f64> {
        let mut n = 0;
        for (_, e) in &emitters {
            n += i32::from(w.emitter(*e)?.born() > 0);
        }
        Ok(f64::from(n))
    };
    let (whole, mut rows) = (12.0, Vec::new());
    for part in [0.25, 0.5, 1.0] {
        let t = part * whole;
        let left = t - w.time();
        run(&mut w, left)?;
        // At 120/s the first particle comes 1/120 s after the front; f32 rounds the angle of an emitter.
        let front = |t: f64| PI * (t - 1.0 / 120.0) / whole;
        let expected = emitters.iter().filter(|(a, _)| *a <= front(t)).count() as f64;
        let unsure = emitters.iter().filter(|(a, _)| (a - front(t)).abs() < 32.0 * EPS * PI).count() as f64;
        let name = format!("Genesis: emitters that the front has passed after {t} s");
        rows.push(Row::new(&name, expected, begun(&w)?, unsure, "", "angle = π t/T, T = 12 s √(R/10 m)"));
    }
    run(&mut w, 2.0)?;
    let mut born = 0;
    for (_, e) in &emitters {
        born += w.emitter(*e)?.born();
    }
    let expected = 120.0 * 1.5 * emitters.len() as f64;
    rows.push(Row::new("Genesis: born in all", expected, born as f64, 0.0, "", "rate × duration × emitters"));
    Ok(rows)
}
