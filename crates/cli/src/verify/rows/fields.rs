//! Gravitation, media, water and turning axes, as fields of the engine.
//!
//! The substep h is the method's step: semi-implicit Euler for accelerations (symplectic: an orbit's elements stay within
//! O(h n) of their values, n the largest angular speed), implicit Euler for drag (first order; its fixed point is exact).

use super::{EPS, G, crossing, run, substep, world};
use crate::verify::{Law, Row, Rows};
use core::f64::consts::{PI, TAU};
use jounce::Result;
use jounce::prelude::*;

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "gravitation", name: "orbits about a point", run: kepler },
    Law { topic: "gravitation", name: "two bodies about each other", run: two_bodies },
    Law { topic: "buoyancy", name: "floating spheres", run: floating },
    Law { topic: "buoyancy", name: "bodies under water", run: submerged },
    Law { topic: "drag", name: "Stokes", run: stokes },
    Law { topic: "drag", name: "quadratic", run: quadratic },
    Law { topic: "drag", name: "soccer ball in the field of air", run: ball_in_air },
    Law { topic: "drag", name: "wind carries along", run: wind },
    Law { topic: "lift", name: "spinning ball", run: magnus },
    Law { topic: "rotating frame", name: "free bodies", run: rotating_frame },
];

/// A body of one shape at a place, with a velocity.
fn put(w: &mut World, shape: ShapeDesc, at: [f64; 3], velocity: [f32; 3]) -> Result<BodyId> {
    w.add_body(BodyDesc::dynamic().at(at).velocity(velocity).shape(shape))
}

fn speck() -> ShapeDesc {
    ShapeDesc::sphere(0.01).mass(1.0)
}

/// From periapsis at 1 − e around μ = 1 with a = 1: back there after 2π.
fn kepler() -> Rows {
    let mut rows = Vec::new();
    for (e, v) in [(0.5, 1.732_050_8), (0.9, 4.358_898_9)] {
        let rate = if e > 0.6 { 4000.0 } else { 480.0 };
        let mut w = world(0.0, rate)?;
        w.add_field(FieldDesc::new(FieldLaw::Point { center: DVec3::ZERO, mu: 1.0, softening: 0.0 }))?;
        let id = put(&mut w, speck(), [1.0 - e, 0.0, 0.0], [0.0, v, 0.0])?;
        let start = w.energy().total();
        let (mut worst, mut farthest) = (0.0f64, 0.0f64);
        // y falls through zero at apoapsis; then through zero from below at the next periapsis.
        crossing(&mut w, 5.0, |w| Ok(w.body(id)?.position().y + if w.time() < 0.1 { 1.0 } else { 0.0 }))?;
        let half = w.time();
        let period = crossing(&mut w, 8.0, |w| {
            let p = w.body(id)?.position();
            let off = (w.energy().total() - start).abs();
            worst = if off > worst { off } else { worst };
            farthest = if p.length() > farthest { p.length() } else { farthest };
            Ok(-p.y)
        })?;
        // n at periapsis: v/r.
        let n = f64::from(v) / (1.0 - e);
        let hn = substep(&w) * n;
        let source = "Kepler, a = μ = 1: v = √((1 + e)/(1 − e)), T = 2π a^(3/2)/√μ";
        let _ = half;
        rows.push(Row::new(&format!("period, e = {e}"), TAU, period, TAU * hn, "s", source));
        rows.push(Row::new(&format!("farthest, e = {e}"), 1.0 + e, farthest, (1.0 + e) * hn, "m", source));
        // E = −½; a symplectic method's energy swings by no more than its first-order term, h v·a/2 at periapsis.
        let swing = substep(&w) * f64::from(v) / ((1.0 - e) * (1.0 - e));
        rows.push(Row::at_most(&format!("energy swing over an orbit, e = {e}"), swing, worst, "J", source));
    }
    Ok(rows)
}

/// d = 1, G(m₁ + m₂) = 4: ω = 2, T = π.
fn two_bodies() -> Rows {
    let mut w = world(0.0, 480.0)?;
    let a = put(&mut w, ShapeDesc::sphere(0.01).mass(3.0), [-0.25, 0.0, 0.0], [0.0, -0.5, 0.0])?;
    let b = put(&mut w, ShapeDesc::sphere(0.01).mass(1.0), [0.75, 0.0, 0.0], [0.0, 1.5, 0.0])?;
    w.add_field(FieldDesc::new(FieldLaw::NBody { bodies: vec![a, b], g: 1.0, softening: 0.0 }))?;
    let mut worst = 0.0f64;
    crossing(&mut w, 2.5, |w| Ok(w.body(b)?.position().y + if w.time() < 0.1 { 1.0 } else { 0.0 }))?;
    let period = crossing(&mut w, 5.0, |w| {
        let p = w.momentum().linear.length();
        worst = if p > worst { p } else { worst };
        Ok(-w.body(b)?.position().y)
    })?;
    let source = "Newton: ω² = G (m1 + m2)/d³, and action equals reaction";
    let h = substep(&w);
    // Each substep rounds two velocities of up to 1.5 m/s to f32.
    let rounding = EPS * (3.0 * 0.5 + 1.5) * (period / h);
    Ok(vec![
        Row::new("period of two bodies", PI, period, PI * 2.0 * h, "s", source),
        Row::at_most("momentum of two bodies", rounding, worst, "kg m/s", source),
    ])
}

/// Depth of the lowest point ÷ diameter: the root of V(d) = ratio V.
fn floating() -> Rows {
    let mut rows = Vec::new();
    for (ratio, depth) in [(0.25, 0.326_352), (0.5, 0.5), (0.75, 0.673_648)] {
        let mut w = world(G, 60.0)?;
        w.add_field(FieldDesc::water(0.0))?;
        let shape = ShapeDesc::sphere(0.5).density((1000.0 * ratio) as f32);
        let id = put(&mut w, shape, [0.0, 0.5 - depth + 0.05, 0.0], [0.0; 3])?;
        run(&mut w, 60.0)?;
        let got = 0.5 - w.body(id)?.position().y;
        // What is left of 5 cm after 60 s of damping, and the rounding of weight against lift over the waterplane's spring.
        let stiffness = PI * depth * (1.0 - depth) / (PI / 6.0 * ratio);
        let left = 0.05 * jounce::math::scalar::f64s::exp(-0.25 * 60.0);
        let tolerance = left + 64.0 * EPS / stiffness + 1e-6;
        let name = format!("depth/diameter of a floating sphere, density ratio {ratio}");
        rows.push(Row::new(&name, depth, got, tolerance, "", "Archimedes; spherical cap"));
    }
    Ok(rows)
}

/// Acceleration in the first substeps of a body held under: g (ρ_w/ρ − 1), so F/(ρ_w g V) = 1.
fn submerged() -> Rows {
    let points: Vec<Vec3> = (0..60u32)
        .map(|i| {
            let t = f64::from(i) * 2.399_963_229;
            let y = 1.0 - 2.0 * (f64::from(i) + 0.5) / 60.0;
            let r = (1.0 - y * y).sqrt();
            let (s, c) = (jounce::math::scalar::f64s::sin(t), jounce::math::scalar::f64s::cos(t));
            DVec3::new(r * c, 0.7 * y, 1.3 * r * s).as_vec3()
        })
        .collect();
    let hull = jounce::geometry::Hull::new(&points)?;
    let shapes = [
        ("hull of 60 points", ShapeDesc::new(Shape::Hull(hull.into()))),
        ("box", ShapeDesc::cuboid([0.3, 0.5, 0.2])),
        ("capsule", ShapeDesc::capsule(0.4, 0.3)),
        ("cylinder", ShapeDesc::cylinder(0.4, 0.3)),
        ("cone", ShapeDesc::cone(0.4, 0.3)),
    ];
    let mut rows = Vec::new();
    for (name, shape) in shapes {
        let mut w = world(G, 10_000.0)?;
        let mut water = FieldDesc::water(100.0);
        if let FieldLaw::Water { linear_drag, .. } = &mut water.law {
            *linear_drag = 0.0;
        }
        w.add_field(water)?;
        let still = Aero { drag: Some(0.0), stokes_radius: Some(0.0), ..Aero::default() };
        let id = put(&mut w, shape.density(500.0).aero(still), [0.0; 3], [0.0; 3])?;
        w.step()?;
        // Twice as dense as the body: it rises at g.
        let got = 1.0 + f64::from(w.body(id)?.velocity().y) / (G * w.dt());
        let tolerance = 1e-5 * 2.0;
        let name = format!("lift/weight, {name} under water");
        rows.push(Row::new(&name, 2.0, got, tolerance, "", "Archimedes: ρ g V, to 1e-5"));
    }
    Ok(rows)
}

fn glycerin(w: &mut World) -> Result<BodyId> {
    let mut field = FieldDesc::water(1.0);
    if let FieldLaw::Water { density, viscosity, linear_drag, .. } = &mut field.law {
        (*density, *viscosity, *linear_drag) = (1260.0, 1.41, 0.0);
    }
    w.add_field(field)?;
    let creeping = Aero { drag: Some(0.0), ..Aero::default() };
    put(w, ShapeDesc::sphere(0.001).density(7800.0).aero(creeping), [0.0; 3], [0.0; 3])
}

/// Steel in glycerin: the time constant m/6πηr of 1.2293 ms is shorter than a substep of 4.17 ms.
fn stokes() -> Rows {
    let (terminal, tau) = (0.010_111_5, 1.2293e-3);
    let source = "Stokes: v = 2 r² g (ρ − ρ_f)/9η, τ = 2 r² ρ/9η";
    let mut w = world(G, 60.0)?;
    let id = glycerin(&mut w)?;
    run(&mut w, 0.5)?;
    let at_60 = -f64::from(w.body(id)?.velocity().y);
    let mut fine = world(G, 10_000.0)?;
    let id = glycerin(&mut fine)?;
    let goal = terminal * (1.0 - jounce::math::scalar::f64s::exp(-1.0));
    let time = crossing(&mut fine, 0.01, |w| Ok(goal + f64::from(w.body(id)?.velocity().y)))?;
    // Implicit Euler: (1 + h/τ)^(−t/h) instead of e^(−t/τ): the time constant is off by h/2, and by half a step of sampling.
    let tolerance = 0.5 * substep(&fine) + 0.5 * fine.dt() * 0.1;
    Ok(vec![
        Row::new("terminal speed at 60 Hz", terminal, at_60, terminal * 5e-5, "m/s", source),
        Row::new("time constant at 10 kHz", tau, time, tolerance, "s", source),
    ])
}

/// Fall with a terminal speed of 20 m/s: v = v_t tanh(g t/v_t).
fn quadratic() -> Rows {
    let mut w = world(G, 240.0)?;
    w.add_field(FieldDesc::new(FieldLaw::Drag { density: 1.2, viscosity: 0.0 }))?;
    // m g = ½ρ A C_d v_t².
    let area = 0.1;
    let cd = 2.0 * 1.0 * G / (1.2 * area * 400.0);
    let aero = Aero { drag: Some(cd as f32), area: Some(area as f32), ..Aero::default() };
    let id = put(&mut w, ShapeDesc::sphere(0.1).mass(1.0).aero(aero), [0.0; 3], [0.0; 3])?;
    let source = "v = v_t tanh(g t/v_t), drop = v_t²/g ln cosh(g t/v_t)";
    // Implicit Euler: ½ h max|v″| t with max|v″| = 4/(3√3) g²/v_t.
    let slope = 0.5 * substep(&w) * 0.7698 * G * G / 20.0;
    let mut rows = Vec::new();
    let mut before = 0.0;
    for (t, v, drop) in
        [(1.0, 9.092_264, 4.720_081), (2.0, 15.069_969, 17.100_391), (5.0, 19.705_802, 72.038_122)]
    {
        run(&mut w, t - before)?;
        before = t;
        let (body, error) = (w.body(id)?, slope * t);
        let speed = -f64::from(body.velocity().y);
        rows.push(Row::new(&format!("speed after {t} s"), v, speed, error, "m/s", source));
        // The position takes the new velocity: ½ h v too far, and the error of v over t.
        let tolerance = 0.5 * substep(&w) * v + error * t;
        rows.push(Row::new(&format!("drop after {t} s"), drop, -body.position().y, tolerance, "m", source));
    }
    let ever = {
        run(&mut w, 60.0)?;
        -f64::from(w.body(id)?.velocity().y)
    };
    // Two f32 roundings of v a substep against the pull of the law, 2 g h/v_t of what is missing.
    let stall = 2.0 * 20.0 * EPS / (2.0 * G * substep(&w) / 20.0);
    rows.push(Row::new("terminal speed", 20.0, ever, stall, "m/s", source));
    Ok(rows)
}

/// Soccer ball, 0.43 kg, 0.22 m, C_d 0.25, 30 m/s at 45°.
fn ball_in_air() -> Rows {
    let mut w = world(G, 240.0)?;
    w.add_field(FieldDesc::new(FieldLaw::Drag { density: 1.2, viscosity: 0.0 }))?;
    let aero = Aero { drag: Some(0.25), ..Aero::default() };
    let v = (30.0 / 2.0f64.sqrt()) as f32;
    let id = put(&mut w, ShapeDesc::sphere(0.11).mass(0.43).aero(aero), [0.0; 3], [v, v, 0.0])?;
    let mut apex = 0.0f64;
    let (mut last, mut range) = ((0.0, 0.0), f64::NAN);
    let flight = crossing(&mut w, 6.0, |w| {
        let p = w.body(id)?.position();
        apex = if p.y > apex { p.y } else { apex };
        if p.y <= 0.0 && w.time() > 0.1 && range.is_nan() {
            let (x, y) = last;
            range = x + (p.x - x) * y / (y - p.y);
        }
        last = (p.x, p.y);
        Ok(if w.time() < 0.1 { 1.0 } else { p.y })
    })?;
    let source = "½ρ v² A C_d, integrated by RK4 with steps of 1e-5 s";
    // First order: the largest acceleration is g + c v²/m; half a substep of it over the flight.
    let a = G + 0.5 * 1.2 * PI * 0.0121 * 0.25 * 900.0 / 0.43;
    let (h, t) = (substep(&w), 3.589_42);
    let off = 0.5 * a * t * h;
    Ok(vec![
        Row::new("flight of a soccer ball", t, flight, off / 15.0, "s", source),
        Row::new("range of a soccer ball", 50.0127, range, off * 1.5, "m", source),
        Row::new("apex of a soccer ball", 15.9447, apex, off * 0.5, "m", source),
    ])
}

fn wind() -> Rows {
    let mut w = world(0.0, 60.0)?;
    w.add_field(FieldDesc::wind([6.0, 0.0, -8.0]))?;
    let id = put(&mut w, ShapeDesc::sphere(0.5).mass(0.1), [0.0; 3], [0.0; 3])?;
    let t = 2.0;
    run(&mut w, t)?;
    let slip = (w.body(id)?.velocity() - Vec3::new(6.0, 0.0, -8.0)).as_dvec3().length();
    // u′ = −k u − c u², from 10 m/s.
    let (k, c) = (6.0 * PI * 1.81e-5 * 0.5 / 0.1, 0.5 * 1.2 * 0.47 * PI * 0.25 / 0.1);
    let decay = jounce::math::scalar::f64s::exp(-k * t);
    let expected = k * 10.0 * decay / (k + c * 10.0 * (1.0 - decay));
    let h = substep(&w);
    // Implicit Euler adds h c (1 − h c u) to 1/u: in all h c ln(1 + c u₀ t) too little. Two roundings of 8 m/s a substep are
    // pulled back by 2 c u h.
    let late = expected * expected * h * c * jounce::math::scalar::f64s::ln(1.0 + c * 10.0 * t);
    let rounding = 2.0 * 8.0 * EPS / (2.0 * c * expected * h);
    let source = "u′ = −(6πηr u + ½ρ A C_d u²)/m";
    Ok(vec![Row::new("slip against the wind after 2 s", expected, slip, late + rounding, "m/s", source)])
}

/// ω across v: the path bends at ½ρ A r ω/m, and the speed stays.
fn magnus() -> Rows {
    let mut w = world(0.0, 240.0)?;
    w.add_field(FieldDesc::new(FieldLaw::Drag { density: 1.2, viscosity: 0.0 }))?;
    let aero = Aero { drag: Some(0.0), lift: 1.0, ..Aero::default() };
    let desc = BodyDesc::dynamic().velocity([20.0, 0.0, 0.0]).angular_velocity([0.0, 50.0, 0.0]);
    let id = w.add_body(desc.shape(ShapeDesc::sphere(0.11).mass(0.43).aero(aero)))?;
    run(&mut w, 2.0)?;
    let v = w.body(id)?.velocity().as_dvec3();
    let angle = jounce::math::scalar::f64s::atan2(-v.z, v.x);
    let expected = 2.0 * 0.5 * 1.2 * PI * 0.0121 * 0.11 * 50.0 / 0.43;
    let source = "F = C ½ρ A r ω×v, C = 1: the path turns at F/mv";
    // Per substep two roundings of each component, and of ω h.
    let steps = 2.0 / substep(&w);
    Ok(vec![
        Row::new("turn of the path in 2 s", expected, angle, 4.0 * EPS * steps, "rad", source),
        Row::new(
            "speed of a spinning ball after 2 s",
            20.0,
            v.length(),
            20.0 * 4.0 * EPS * steps,
            "m/s",
            source,
        ),
    ])
}

/// A frame whose spin grows: Euler's force −Ω′×r joins the others.
fn sped_up() -> Result<(Row, Row)> {
    let (omega, alpha, t) = (0.3, 0.1, 4.0);
    let frame = |w: &mut World, angular_velocity: f64| {
        w.add_field(FieldDesc::new(FieldLaw::RotatingFrame {
            origin: DVec3::ZERO,
            angular_velocity: Vec3::Y * angular_velocity as f32,
            angular_acceleration: Vec3::Y * alpha as f32,
        }))
    };
    let mut w = world(0.0, 240.0)?;
    frame(&mut w, omega)?;
    // Among the stars: from (2, 0, 0) at 1 m/s along z.
    let id = put(&mut w, speck(), [2.0, 0.0, 0.0], [0.0, 0.0, 1.0 + 2.0 * omega as f32])?;
    run(&mut w, t)?;
    let (p, angle) = (w.body(id)?.position(), omega * t + 0.5 * alpha * t * t);
    let (s, c) = (jounce::math::scalar::f64s::sin(angle), jounce::math::scalar::f64s::cos(angle));
    let stars = DVec3::new(c * p.x + s * p.z, p.y, -s * p.x + c * p.z);
    let off = stars.distance(DVec3::new(2.0, 0.0, t));
    // First order: ½ h |a| t, a = Ω²r + 2Ωv + Ω′r with Ω to 0.7 rad/s, r to 4.5 m, v to 1 + Ωr; and the spin is that of the
    // substep's beginning, ½ h Ω′ t of an angle behind.
    let (h, spin, r) = (substep(&w), omega + alpha * t, 4.5);
    let a = spin * spin * r + 2.0 * spin * (1.0 + spin * r) + alpha * r;
    let tolerance = 0.5 * h * a * t + 0.5 * h * alpha * t * r;
    let source = "a = −Ω×(Ω×r) − 2Ω×v − Ω′×r";
    let way = Row::new("way among the stars in 4 s, spin that grows", 4.0, 4.0 + off, tolerance, "m", source);
    let mut still = world(0.0, 10_000.0)?;
    frame(&mut still, 0.0)?;
    let id = put(&mut still, speck(), [3.0, 0.0, 0.0], [0.0; 3])?;
    still.step()?;
    let a = f64::from(still.body(id)?.velocity().z) / still.dt();
    // From rest: only Ω = Ω′ Δt of the step itself turns it, by less than (Ω′Δt)² r.
    let tolerance = 16.0 * EPS * alpha * 3.0 + (alpha * still.dt()) * (alpha * still.dt()) * 3.0;
    Ok((way, Row::new("Euler's acceleration at 3 m", alpha * 3.0, a, tolerance, "m/s²", "−Ω′×r")))
}

fn rotating_frame() -> Rows {
    let omega = 0.5;
    let frame = |w: &mut World| {
        w.add_field(FieldDesc::new(FieldLaw::RotatingFrame {
            origin: DVec3::ZERO,
            angular_velocity: Vec3::Y * omega as f32,
            angular_acceleration: Vec3::ZERO,
        }))
    };
    let mut w = world(0.0, 240.0)?;
    frame(&mut w)?;
    // Among the stars: from (2, 0, 0) at 1 m/s along z. In the frame v = u − Ω×r = (0, 0, 1 + Ω 2).
    let id = put(&mut w, speck(), [2.0, 0.0, 0.0], [0.0, 0.0, 1.0 + 2.0 * omega as f32])?;
    let t = 4.0;
    run(&mut w, t)?;
    let p = w.body(id)?.position();
    let (s, c) = (jounce::math::scalar::f64s::sin(omega * t), jounce::math::scalar::f64s::cos(omega * t));
    let stars = DVec3::new(c * p.x + s * p.z, p.y, -s * p.x + c * p.z);
    let off = stars.distance(DVec3::new(2.0, 0.0, t));
    let source = "a = −Ω×(Ω×r) − 2Ω×v: a free body is straight among the stars";
    // First order: ½ h |a| t, a = Ω²r + 2Ωv with r to 4.5 m and v to 3.2 m/s.
    let tolerance = 0.5 * substep(&w) * (omega * omega * 4.5 + 2.0 * omega * 3.2) * t;
    let mut still = world(0.0, 10_000.0)?;
    frame(&mut still)?;
    let id = put(&mut still, speck(), [3.0, 0.0, 0.0], [0.0; 3])?;
    still.step()?;
    let a = f64::from(still.body(id)?.velocity().x) / still.dt();
    let (way, late) = sped_up()?;
    Ok(vec![
        way,
        late,
        Row::new("way among the stars in 4 s", 4.0, 4.0 + off, tolerance, "m", source),
        Row::new("centrifugal acceleration at 3 m", omega * omega * 3.0, a, 0.75 * 1e-4, "m/s²", source),
    ])
}
