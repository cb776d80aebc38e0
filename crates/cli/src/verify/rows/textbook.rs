//! The textbook: `jounce_motion` beside its closed forms. No world runs here; ε = 2⁻⁵³ rounds one f64 operation.

use crate::verify::{Law, Row, Rows};
use jounce::math::DMat3;
use jounce::prelude::DVec3;
use jounce_motion::ballistics::{
    Air, Projectile, Target, aim, aim_in_air, angle_for_height, angles_for_range, fly, lead, slowest,
};
use jounce_motion::collide::{Plane, respond};
use jounce_motion::force;
use jounce_motion::integrate::{Integrator, Method, Options};
use jounce_motion::kinematics::{constant_velocity, displacement, varying_acceleration};
use jounce_motion::momentum::{RigidBody, push};
use jounce_motion::nbody::{NBody, NBodyDesc};
use jounce_motion::springs::{Elasticity, MassSpring};
use std::f64::consts::{PI, TAU};

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "kinematics", name: "integrals of motion", run: || told(integrals()) },
    Law { topic: "integrators", name: "Euler family", run: || told(euler_family()) },
    Law { topic: "integrators", name: "orders", run: || told(orders()) },
    Law { topic: "integrators", name: "adaptive Euler", run: || told(adaptive_euler()) },
    Law { topic: "integrators", name: "stability", run: || told(stability()) },
    Law { topic: "ballistics", name: "projectile in vacuum", run: || told(vacuum()) },
    Law { topic: "ballistics", name: "aim and lead", run: || told(aimed()) },
    Law { topic: "ballistics", name: "ball in air", run: || told(ball_in_air()) },
    Law { topic: "drag", name: "drag and terminal speed", run: || told(drag()) },
    Law { topic: "friction", name: "static friction on a slope", run: || told(slope()) },
    Law { topic: "buoyancy", name: "Archimedes", run: || told(archimedes()) },
    Law { topic: "rotation", name: "circle", run: || told(circle()) },
    Law { topic: "gravitation", name: "pull of two masses", run: || told(pull()) },
    Law { topic: "gravitation", name: "gravitation of Kepler", run: || told(kepler()) },
    Law { topic: "springs", name: "spring between two masses", run: || told(spring()) },
    Law { topic: "rotation", name: "ball on a string", run: || told(string()) },
    Law { topic: "collision", name: "bounce of a particle", run: || told(bounce()) },
    Law { topic: "momentum form", name: "linear momentum form", run: || told(momentum_form()) },
    Law { topic: "rigid motion", name: "angular momentum form", run: || told(angular_form()) },
    Law { topic: "rotating frame", name: "textbook's rotating frame", run: || told(rotating_frame()) },
];

pub(super) type Found = jounce_motion::Result<Vec<Row>>;

/// Rounding of one f64 operation, relative.
pub(super) const EPS64: f64 = 0.5 * f64::EPSILON;
const G: DVec3 = DVec3::new(0.0, -super::G, 0.0);

pub(super) fn told(found: Found) -> Rows {
    found.map_err(|e| jounce::Error::BadValue {
        what: "textbook",
        field: "law",
        value: e.to_string(),
        expected: "numbers that it can be computed for",
    })
}

fn integrals() -> Found {
    let still = constant_velocity(DVec3::ZERO, DVec3::new(3.0, 4.0, 0.0), 10.0);
    let s = displacement(|t| DVec3::X * t.sin(), 0.0, PI, 1e-12)?;
    let (p, v) = varying_acceleration(DVec3::ZERO, DVec3::X, |t| DVec3::X * t.cos(), 2.0, 1e-12)?;
    Ok(vec![
        Row::new(
            "textbook: way at constant velocity",
            50.0,
            still.length(),
            8.0 * EPS64 * 50.0,
            "m",
            "P0 + v t",
        ),
        Row::new("textbook: way at v = sin t", 2.0, s.value.x, 1e-12, "m", "∫ v dt, tolerance asked"),
        Row::new("textbook: velocity at a = cos t", 1.0 + 2f64.sin(), v.x, 1e-12, "m/s", "v0 + ∫ a dt"),
        Row::new("textbook: way at a = cos t", 3.0 - 2f64.cos(), p.x, 2e-12, "m", "∫ (t − s) a ds"),
    ])
}

/// The lecture's loop: F = 10, m = 1, Δt = 1, from rest.
fn passes(method: Method, n: u32) -> jounce_motion::Result<f64> {
    let (mut x, mut v) = (0.0, 0.0);
    let mut integrator = Integrator::new(method);
    for i in 0..n {
        integrator.step_point(f64::from(i), 1.0, &mut x, &mut v, |_, _, _| 10.0)?;
    }
    Ok(x)
}

fn euler_family() -> Found {
    let source = "sum of v Δt; whole numbers do not round";
    let mut rows = vec![
        Row::new(
            "textbook: lecture's loop, 10 passes",
            450.0,
            passes(Method::LectureLoop, 10)?,
            0.0,
            "m",
            source,
        ),
        Row::new(
            "textbook: lecture's loop, 11 passes",
            550.0,
            passes(Method::LectureLoop, 11)?,
            0.0,
            "m",
            source,
        ),
        Row::new(
            "textbook: semi-implicit Euler, 10 passes",
            550.0,
            passes(Method::SemiImplicitEuler, 10)?,
            0.0,
            "m",
            source,
        ),
    ];
    for (n, exact) in [(10, 500.0), (11, 605.0)] {
        let name = format!("textbook: velocity Verlet, {n} passes");
        // Exact for a constant force; three roundings a pass.
        let tolerance = 3.0 * f64::from(n) * EPS64 * exact;
        rows.push(Row::new(&name, exact, passes(Method::VelocityVerlet, n)?, tolerance, "m", "½ a t²"));
    }
    let (a, dt, n) = (super::G, 0.01, 300);
    for (method, sign) in [(Method::ExplicitEuler, -0.5), (Method::SemiImplicitEuler, 0.5)] {
        let (mut x, mut v) = (0.0, 0.0);
        let mut integrator = Integrator::new(method);
        for _ in 0..n {
            integrator.step_point(0.0, dt, &mut x, &mut v, |_, _, _| a)?;
        }
        let t = dt * f64::from(n);
        let error = x - 0.5 * a * t * t;
        let rounding = 4.0 * f64::from(n) * EPS64 * 0.5 * a * t * t;
        let name = format!("textbook: {method}'s error of a fall");
        rows.push(Row::new(&name, sign * a * t * dt, error, rounding, "m", "½ a t Δt, summed"));
    }
    Ok(rows)
}

/// Largest error of (x, v/ω) on t ∈ [0, 5] of an oscillator of ω = 2.
fn oscillator(method: Method, steps: u32) -> jounce_motion::Result<f64> {
    let (w, dt) = (2.0, 5.0 / f64::from(steps));
    let (mut x, mut v) = (1.0, 0.0);
    let mut integrator = Integrator::new(method);
    let mut worst = 0.0f64;
    for n in 0..steps {
        integrator.step_point(f64::from(n) * dt, dt, &mut x, &mut v, |_, x, _| -w * w * x)?;
        let phase = w * f64::from(n + 1) * dt;
        worst = worst.max((x - phase.cos()).hypot(v / w + phase.sin()));
    }
    Ok(worst)
}

fn orders() -> Found {
    let methods = [
        (Method::ExplicitEuler, 20_000),
        (Method::LectureLoop, 20_000),
        (Method::SemiImplicitEuler, 20_000),
        (Method::ImplicitEuler, 20_000),
        (Method::Midpoint, 1000),
        (Method::VelocityVerlet, 1000),
        (Method::Rk4, 500),
        (Method::Dopri5, 200),
    ];
    methods
        .into_iter()
        .map(|(method, steps)| {
            let slope = (oscillator(method, steps)? / oscillator(method, 2 * steps)?).log2();
            let order = f64::from(method.order());
            let w_dt = 10.0 / f64::from(steps);
            // The error is C Δtᵖ (1 + c Δt): halving Δt gives p + c Δt/(2 ln 2). c Δt is at most ω Δt for the higher
            // orders; the amplitude of first order is e^{x}, x = ωT ωΔt/2, whose next term is x/2.
            let next = if order == 1.0 { 10.0 * w_dt } else { w_dt };
            let name = format!("textbook: order of {method}");
            Ok(Row::new(&name, order, slope, next, "", "slope of the error, Δt halved"))
        })
        .collect()
}

fn adaptive_euler() -> Found {
    // v′ = −c v: one step leaves v (1 − c Δt), two leave v (1 − c Δt/2)², so E = v c² Δt²/4.
    let (c, dt, tolerance) = (3.0, 1e-3, 1e-4);
    let options = Options { tolerance, safety: 1.0, ..Options::default() };
    let mut euler = Integrator::with_options(Method::AdaptiveEuler, options)?;
    euler.step(0.0, dt, &mut [1.0], |_, y, dy| dy[0] = -c * y[0])?;
    let ideal = (tolerance / (0.25 * c * c * dt * dt)).sqrt() * dt;
    // E is a difference of two numbers near 1: rounding 2ε of it.
    let part = 2.0 * EPS64 / (0.25 * c * c * dt * dt);
    let kick = |t: f64| 200.0 * (-((t - 1.0) / 0.05) * ((t - 1.0) / 0.05)).exp();
    let options = Options { tolerance: 1e-2, dt_min: 1e-7, dt_max: 0.1, ..Options::default() };
    let mut pushed = Integrator::with_options(Method::AdaptiveEuler, options)?;
    let (mut x, mut v) = (0.0, 0.0);
    let (mut largest, mut quiet, mut busy) = (0.0f64, 0.0f64, f64::MAX);
    for n in 0..20 {
        let r = pushed.step_point(f64::from(n) * 0.1, 0.1, &mut x, &mut v, |t, _, _| kick(t))?;
        largest = largest.max(r.error_max);
        if n < 5 {
            quiet = quiet.max(r.dt_longest);
        } else if n < 11 {
            busy = busy.min(r.dt_shortest);
        }
    }
    let source = "Δt′ = √(E_tol/E) Δt";
    Ok(vec![
        Row::relative("textbook: next step of adaptive Euler", ideal, euler.dt_next(), part, "s", source),
        Row::at_most(
            "textbook: error of a step of adaptive Euler",
            1e-2,
            largest,
            "m/s",
            "E ≤ E_tol, else retried",
        ),
        Row::holds("textbook: steps shrink under a kick", busy < 0.1 * quiet, source),
    ])
}

/// Amplitude after so many steps of an undamped spring from (1, 0).
fn amplitude(method: Method, w_dt: f64, steps: u32) -> jounce_motion::Result<f64> {
    let (mut x, mut v) = (1.0, 0.0);
    let mut integrator = Integrator::new(method);
    for _ in 0..steps {
        integrator.step_point(0.0, w_dt, &mut x, &mut v, |_, x, _| -x)?;
    }
    Ok(f64::hypot(x, v))
}

fn stability() -> Found {
    let mut rows = Vec::new();
    for w_dt in [0.1f64, 1.0, 10.0] {
        let grown = (1.0 + w_dt * w_dt).powf(25.0);
        let got = amplitude(Method::ExplicitEuler, w_dt, 50)?;
        let name = format!("textbook: explicit Euler grows, ωΔt = {w_dt}");
        // Two products and two sums a step.
        rows.push(Row::relative(&name, grown, got, 4.0 * 50.0 * EPS64, "", "|1 + i ωΔt|ⁿ"));
        let got = amplitude(Method::ImplicitEuler, w_dt, 50)?;
        let name = format!("textbook: implicit Euler decays, ωΔt = {w_dt}");
        // Newton leaves 1e-10 of the state at every step.
        rows.push(Row::relative(&name, 1.0 / grown, got, 50.0 * 1e-10, "", "|1 + i ωΔt|⁻ⁿ"));
    }
    let (below, above) =
        (amplitude(Method::SemiImplicitEuler, 1.9, 10_000)?, amplitude(Method::SemiImplicitEuler, 2.1, 200)?);
    // x² + v² − ωΔt x v is kept: an ellipse whose longer axis squared is 1/(1 − ωΔt/2).
    let source = "x² + v² − ωΔt x v is kept";
    rows.push(Row::at_most(
        "textbook: semi-implicit Euler, ωΔt = 1.9",
        (1.0f64 / 0.05).sqrt(),
        below,
        "",
        source,
    ));
    rows.push(Row::holds("textbook: semi-implicit Euler diverges, ωΔt = 2.1", above > 1e9, source));
    Ok(rows)
}

fn vacuum() -> Found {
    let (s, g) = (30.0, super::G);
    let half = s * 0.5f64.sqrt();
    let ball = Projectile::new(DVec3::ZERO, DVec3::new(half, half, 0.0), G)?;
    let rounding = 16.0 * EPS64;
    let mut rows = vec![
        Row::new("textbook: range at 45°", 91.743_119, ball.level_range(), 5e-7, "m", "s²/g, last digit"),
        Row::relative("textbook: time of the apex", half / g, ball.apex().time, rounding, "s", "v_y/g"),
        Row::relative(
            "textbook: height of the apex",
            half * half / (2.0 * g),
            ball.apex().position.y,
            rounding,
            "m",
            "v_y²/2g",
        ),
    ];
    let both = angles_for_range(s, 60.0, g)?.yes();
    for (name, angle) in [("low", both.map(|b| b.low)), ("high", both.map(|b| b.high))] {
        let angle = angle.unwrap_or(f64::NAN);
        let p = Projectile::new(DVec3::ZERO, DVec3::new(angle.cos(), angle.sin(), 0.0) * s, G)?;
        let name = format!("textbook: range by the {name} angle");
        rows.push(Row::relative(&name, 60.0, p.level_range(), rounding, "m", "α = ½ asin(r g/s²)"));
    }
    let angle = angle_for_height(s, 20.0, g)?.yes().unwrap_or(f64::NAN);
    let apex = (s * angle.sin()) * (s * angle.sin()) / (2.0 * g);
    rows.push(Row::relative(
        "textbook: apex by its angle",
        20.0,
        apex,
        rounding,
        "m",
        "α = asin(√(2 g h)/s)",
    ));
    let miss = angles_for_range(s, 100.0, g)?.no();
    let (short, needed) =
        miss.map_or((f64::NAN, f64::NAN), |m| (m.distance, m.speed_needed.unwrap_or(f64::NAN)));
    let source = "s²/g is the longest";
    let exact = 100.0 - s * s / g;
    rows.push(Row::new("textbook: 100 m are out of reach by", exact, short, 100.0 * rounding, "m", source));
    rows.push(Row::relative(
        "textbook: speed for 100 m",
        (100.0 * g).sqrt(),
        needed,
        rounding,
        "m/s",
        "√(r g)",
    ));
    Ok(rows)
}

fn aimed() -> Found {
    let (d, s) = (DVec3::new(30.0, 10.0, -20.0), 27.0);
    // Positions of up to a hundred metres, after a dozen operations.
    let rounding = 12.0 * EPS64 * 100.0;
    let shots = aim(d, s, G)?.yes();
    let mut rows = Vec::new();
    for (name, shot) in [("low", shots.map(|s| s.low)), ("high", shots.map(|s| s.high))] {
        let shot = shot.unwrap_or_default();
        let hit = Projectile::new(DVec3::ZERO, shot.velocity, G)?.at(shot.time);
        let row = format!("textbook: {name} shot at a point in space");
        rows.push(Row::at_most(&row, rounding, hit.position.distance(d), "m", "P0 + v t + ½ g t²"));
        let name = format!("textbook: speed of the {name} shot");
        rows.push(Row::relative(
            &name,
            s,
            shot.velocity.length(),
            100.0 * EPS64,
            "m/s",
            "the speed asked for",
        ));
    }
    let least = slowest(d, G)?.velocity.length();
    let exact = (super::G * (d.length() + d.y)).sqrt();
    rows.push(Row::relative(
        "textbook: least speed for it",
        exact,
        least,
        16.0 * EPS64,
        "m/s",
        "√(g (|d| + h))",
    ));
    let plane = Target::moving(DVec3::new(200.0, 80.0, 50.0), DVec3::new(-30.0, 0.0, 10.0));
    let met = lead(&plane, 100.0, G)?.yes().unwrap_or_default();
    let first = met.first().copied().unwrap_or_default();
    let hit = Projectile::new(DVec3::ZERO, first.velocity, G)?.at(first.time);
    let apart = hit.position.distance(plane.at(first.time));
    rows.push(Row::at_most(
        "textbook: lead on a moving target",
        4.0 * rounding,
        apart,
        "m",
        "|d + u t − ½ g t²| = s t",
    ));
    rows.push(Row::relative(
        "textbook: speed of the lead",
        100.0,
        first.velocity.length(),
        1e-12,
        "m/s",
        "bisected to rounding",
    ));
    Ok(rows)
}

fn ball_in_air() -> Found {
    let air = Air::ball(0.43, 0.11, 0.25, force::AIR_DENSITY)?;
    let half = 30.0 * 0.5f64.sqrt();
    let kick = Projectile::new(DVec3::ZERO, DVec3::new(half, half, 0.0), G)?;
    let ground = Plane::new(DVec3::ZERO, DVec3::Y)?;
    let flight = fly(&kick, &air, &ground)?;
    let landing = flight.landing().unwrap_or_default();
    let source = "quadratic drag, ρ = 1.2; half of the last digit";
    let mut rows = vec![
        Row::new("textbook: football's time in air", 3.589_42, landing.time, 5e-6, "s", source),
        Row::new("textbook: football's range in air", 50.0127, landing.position.x, 5e-5, "m", source),
        Row::new("textbook: football's apex in air", 15.9447, flight.apex().position.y, 5e-5, "m", source),
    ];
    let shots = aim_in_air(&Target::fixed(DVec3::X * 40.0), 30.0, G, &air)?.yes().unwrap_or_default();
    for (name, i) in [("low", 0), ("high", 1)] {
        let shot = shots.get(i).copied().unwrap_or_default();
        let flown = fly(&Projectile::new(DVec3::ZERO, shot.velocity, G)?, &air, &ground)?;
        let name = format!("textbook: 40 m in air by the {name} angle");
        let got = flown.landing().unwrap_or_default().position.x;
        // Newton ends at 1e-9 of the distance, the flight's tolerance is 1e-10 a step.
        rows.push(Row::new(&name, 40.0, got, 40.0 * 1e-8, "m", "aimed, then flown"));
    }
    Ok(rows)
}

fn drag() -> Found {
    let volume = 4.0 / 3.0 * PI * 1e-9;
    let (mass, b) = (7800.0 * volume, force::stokes_coefficient(1.41, 1e-3));
    let net = force::uniform_gravity(mass, G) + force::buoyancy(1260.0, volume, G);
    let terminal = force::terminal_speed(net.length(), b, 0.0);
    let mut fall = DVec3::ZERO;
    for _ in 0..100 {
        fall = force::implicit_drag(fall, net / mass, b / mass, 0.0, 1.0 / 240.0);
    }
    let mut rows = vec![
        Row::new(
            "textbook: steel in glycerin",
            0.010_111_5,
            terminal,
            5e-8,
            "m/s",
            "6πηr; half of the last digit",
        ),
        Row::new(
            "textbook: its time constant",
            1.2293e-3,
            mass / b,
            5e-8,
            "s",
            "m/b; half of the last digit",
        ),
        Row::relative(
            "textbook: fixed point of implicit drag",
            terminal,
            fall.length(),
            8.0 * EPS64,
            "m/s",
            "m g/b, Δt = 3.4 τ",
        ),
    ];
    let (v_t, g) = (20.0, super::G);
    let c = g / (v_t * v_t);
    let mut solver = Integrator::new(Method::AdaptiveDopri5);
    let (mut x, mut v, mut t) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for until in [1.0, 2.0, 5.0] {
        solver.step_point(t, until - t, &mut x, &mut v, |_, _, v| G + force::quadratic_drag(c, v))?;
        t = until;
        // 1e-10 of the state a step, fewer than a hundred steps.
        let (speed, way) = (v_t * (g * t / v_t).tanh(), v_t * v_t / g * (g * t / v_t).cosh().ln());
        let name = format!("textbook: speed in air after {t} s");
        rows.push(Row::relative(&name, speed, v.length(), 1e-8, "m/s", "v_t tanh(g t/v_t)"));
        let name = format!("textbook: drop in air after {t} s");
        rows.push(Row::relative(&name, way, x.length(), 1e-8, "m", "v_t²/g ln cosh(g t/v_t)"));
    }
    Ok(rows)
}

fn slope() -> Found {
    let (mu, mass) = (0.6, 2.0);
    let slides = |angle: f64| {
        let load = DVec3::X * (mass * super::G * angle.sin());
        force::static_friction(mu, mass * super::G * angle.cos(), load) == force::Friction::Slips
    };
    let (mut holds, mut slips) = (0.0, 1.5);
    while slips - holds > 1e-14 {
        let mid = 0.5 * (holds + slips);
        if slides(mid) { slips = mid } else { holds = mid }
    }
    let source = "atan μ_s; bisected";
    Ok(vec![Row::new("textbook: slope at which it slides", mu.atan(), holds, 1e-14, "rad", source)])
}

/// Of a formula of a few operations.
const FEW: f64 = 8.0 * EPS64;

fn archimedes() -> Found {
    let lift = force::buoyancy(1000.0, 0.5, G).y;
    Ok(vec![Row::relative("textbook: buoyancy of half a cubic metre", 4905.0, lift, FEW, "N", "ρ_f V g")])
}

fn circle() -> Found {
    let (w, r) = (DVec3::Z * 3.0, DVec3::X * 2.0);
    let (outwards, along) = (force::centrifugal(0.5, w, r).x, force::point_velocity(w, r).y);
    Ok(vec![
        Row::relative("textbook: centrifugal force", 0.5 * 9.0 * 2.0, outwards, FEW, "N", "m ω² r"),
        Row::relative("textbook: velocity on a circle", 6.0, along, FEW, "m/s", "ω × r"),
    ])
}

fn pull() -> Found {
    let pull = |g: f64| force::gravitation(g, 5.0e3, 7.0e3, DVec3::new(3.0, 4.0, 0.0), 0.0).length();
    let lecture = pull(force::G_LECTURE);
    let exact = [6.673e-11, 6.674_30e-11].map(|g| g * 35e6 / 25.0);
    let source = "G M1 M2/d², the lecture's G";
    Ok(vec![
        Row::relative("textbook: pull of two masses", exact[0], lecture, FEW, "N", source),
        Row::relative(
            "textbook: pull of two masses, CODATA",
            exact[1],
            pull(force::G),
            FEW,
            "N",
            "G M1 M2/d², CODATA 2022",
        ),
    ])
}

/// A planet about a sun of G M = 1, a = 1, from the perihelion.
fn orbit(method: Method, e: f64) -> jounce_motion::Result<NBody> {
    let mut s = NBody::new(NBodyDesc { g: 1.0, method, ..NBodyDesc::default() })?;
    s.add(1.0, DVec3::ZERO, DVec3::ZERO)?;
    s.add(0.0, DVec3::X * (1.0 - e), DVec3::Y * ((1.0 + e) / (1.0 - e)).sqrt())?;
    Ok(s)
}

fn planet_energy(s: &NBody) -> f64 {
    0.5 * s.velocities()[1].length_squared() - 1.0 / s.positions()[1].length()
}

fn kepler() -> Found {
    let mut rows = Vec::new();
    for (e, speed) in [(0.5, 1.732_050_8), (0.9, 4.358_898_9)] {
        let mut s = orbit(Method::AdaptiveDopri5, e)?;
        let start = s.positions()[1];
        // Round once, then see the speed where it began.
        s.step(TAU)?;
        let name = format!("textbook: speed at the perihelion, e = {e}");
        // 1e-10 a step over a few hundred steps, stretched by the orbit's shear 3π v/(1−e).
        let shear = 3.0 * PI * speed / (1.0 - e);
        rows.push(Row::relative(
            &name,
            speed,
            s.velocities()[1].length(),
            1e-8 * shear,
            "m/s",
            "√((1+e)/(1−e))",
        ));
        let name = format!("textbook: gap after a period, e = {e}");
        rows.push(Row::at_most(&name, 1e-8 * shear, s.positions()[1].distance(start), "m", "T = 2π"));
    }
    let dt = TAU / 1000.0;
    let mut verlet = orbit(Method::VelocityVerlet, 0.5)?;
    let mut euler = orbit(Method::ExplicitEuler, 0.5)?;
    let (mut worst, mut early) = (0.0f64, 0.0);
    for n in 0..20_000 {
        verlet.step(dt)?;
        worst = worst.max((planet_energy(&verlet) + 0.5).abs());
        if n < 8000 {
            euler.step(dt)?;
        }
        if n == 1999 {
            early = planet_energy(&euler) + 0.5;
        }
    }
    let late = planet_energy(&euler) + 0.5;
    // Verlet keeps H + Δt² (v·V″v/12 − |V′|²/24); at the perihelion r = ½, v² = 3: V″ across is 1/r³, |V′| = 1/r².
    let bound = dt * dt * (3.0 * 8.0 / 12.0 + 16.0 / 24.0);
    rows.push(Row::at_most(
        "textbook: Verlet's energy, 20 orbits",
        bound,
        worst,
        "J",
        "Δt² (v² V″/12 + V′²/24)",
    ));
    rows.push(Row::holds(
        "textbook: explicit Euler's energy drifts",
        early > bound && late > 1.5 * early,
        "no invariant",
    ));
    Ok(rows)
}

fn spring() -> Found {
    let (m1, m2, k, dt) = (1.0, 3.0, 100.0f64, 1e-3);
    let exact = TAU * (m1 * m2 / ((m1 + m2) * k)).sqrt();
    let mut s = MassSpring::new(Method::VelocityVerlet);
    let (a, b) = (s.add_point(m1, DVec3::ZERO)?, s.add_point(m2, DVec3::X)?);
    s.add_spring([a, b], Elasticity { stiffness: k, damping: 0.0 })?;
    s.set_position(b, DVec3::X * 1.1)?;
    let (mut crossings, mut before) = (Vec::new(), 0.1);
    while crossings.len() < 11 && s.time() < 20.0 * exact {
        s.step(dt)?;
        let now = s.positions()[b].distance(s.positions()[a]) - 1.0;
        if before > 0.0 && now <= 0.0 {
            crossings.push(s.time() - dt * now / (now - before));
        }
        before = now;
    }
    let got = match crossings[..] {
        [first, .., last] => (last - first) / (crossings.len() - 1) as f64,
        _ => f64::NAN,
    };
    let w_dt = TAU / exact * dt;
    let moved = s.momentum().length();
    Ok(vec![
        // Verlet's phase error is (ωΔt)²/24; a straight line between two steps errs by (ωΔt)²/8 of a step.
        Row::relative(
            "textbook: period of a spring",
            exact,
            got,
            w_dt * w_dt / 24.0 + w_dt * w_dt * w_dt / 8.0,
            "s",
            "2π√(m1 m2/((m1+m2) k))",
        ),
        // Each step adds the same force to both with opposite signs: only m v rounds, at 30 N Δt.
        Row::at_most(
            "textbook: momentum of the pair",
            crossings.len() as f64 * exact / dt * EPS64 * 4.0,
            moved,
            "kg m/s",
            "third law",
        ),
    ])
}

/// A ball on a string, as a stiff spring about a point that stays: it pulls with m ω² r.
fn string() -> Found {
    let (m, k, w, r, dt) = (0.5, 1000.0, 6.0, 1.0, 1e-4);
    let tension = m * w * w * r;
    let mut s = MassSpring::new(Method::VelocityVerlet);
    let (hand, ball) = (s.add_point(m, DVec3::ZERO)?, s.add_point(m, DVec3::X * r)?);
    s.freeze(hand)?;
    s.add_spring_of_length([hand, ball], Elasticity { stiffness: k, damping: 0.0 }, r - tension / k)?;
    s.set_velocity(ball, DVec3::Z * (w * r))?;
    let turn = (TAU / w / dt).round() as u32;
    let (mut sum, mut worst) = (0.0, 0.0f64);
    for _ in 0..turn {
        s.step(dt)?;
        let pull = k * (s.positions()[ball].length() - (r - tension / k));
        sum += pull;
        worst = worst.max((pull - tension).abs());
    }
    // Verlet's circle is off by no more than (ωΔt)² of its radius, and the string's stiffness tells.
    let off = k * r * (w * dt) * (w * dt);
    let source = "m ω² r; a spring of 1000 N/m";
    Ok(vec![
        Row::new("textbook: tension of a string", tension, sum / f64::from(turn), off, "N", source),
        Row::at_most("textbook: swing of the tension over a turn", off, worst, "N", source),
    ])
}

fn bounce() -> Found {
    let v = DVec3::new(3.0, -4.0, 0.0);
    let (g, e) = (super::G, 0.5);
    let (mut speed, mut t, mut path) = ((2.0 * g).sqrt(), (2.0 / g).sqrt(), 1.0);
    for _ in 0..60 {
        speed = respond(DVec3::Y * -speed, DVec3::Y, e, 0.0).y;
        t += 2.0 * speed / g;
        path += speed * speed / g;
    }
    let source = "(1 − K_f) V_t − K_r V_n";
    let rounding = 200.0 * EPS64;
    Ok(vec![
        Row::at_most(
            "textbook: elastic bounce",
            rounding,
            respond(v, DVec3::Y, 1.0, 0.0).distance(DVec3::new(3.0, 4.0, 0.0)),
            "m/s",
            source,
        ),
        Row::at_most(
            "textbook: bounce that stops the tangent",
            rounding,
            respond(v, DVec3::Y, 0.5, 1.0).distance(DVec3::Y * 2.0),
            "m/s",
            source,
        ),
        Row::new("textbook: bouncing ends after", 1.354_571, t, 5e-7, "s", "√(2h/g) (1+e)/(1−e), last digit"),
        Row::relative("textbook: path of the bounces", 5.0 / 3.0, path, rounding, "m", "h (1+e²)/(1−e²)"),
    ])
}

fn momentum_form() -> Found {
    let (mass, dt, n) = (3.7, 0.01, 1000);
    let (mut p, mut by_p, mut v) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    let mut largest = 0.0f64;
    for i in 0..n {
        let s = f64::from(i % 17) - 8.0;
        let f = DVec3::new(s, 9.0 - s * s, 1.0);
        (p, by_p) = push(p, mass, f, dt);
        v += f / mass * dt;
        largest = largest.max(v.length());
    }
    // Three roundings a step in each form.
    let rounding = 6.0 * f64::from(n) * EPS64 * largest;
    Ok(vec![Row::at_most(
        "textbook: momentum form against velocity form",
        rounding,
        by_p.distance(v),
        "m/s",
        "P += F Δt, v = P/m",
    )])
}

fn angular_form() -> Found {
    let dt = 1e-3;
    let mut body = RigidBody::new(1.0, DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0)))?;
    body.set_velocities(DVec3::ZERO, DVec3::new(0.01, 1.0, 0.0))?;
    let (l, energy) = (body.angular_momentum().length(), body.kinetic_energy());
    let middle = |b: &RigidBody| b.rotation().inverse_rotate(b.angular_velocity()).y;
    let (mut flips, mut before) = (Vec::new(), middle(&body));
    let mut drift = 0.0f64;
    for n in 1..=35_000 {
        body.update_midpoint(dt)?;
        let now = middle(&body);
        if before * now < 0.0 {
            flips.push(f64::from(n) * dt - dt * now / (now - before));
        }
        before = now;
        drift = drift.max((body.kinetic_energy() / energy - 1.0).abs());
    }
    let at = |i: usize| flips.get(i).copied().unwrap_or(f64::NAN);
    // The midpoint rule's phase error is (ωΔt)²/12 of the time; the digits of the reference end at 5e-6.
    let phase = |t: f64| dt * dt / 12.0 * t + 5e-6;
    let mut crude = RigidBody::new(1.0, DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0)))?;
    crude.set_velocities(DVec3::ZERO, DVec3::new(0.01, 1.0, 0.0))?;
    let kept = crude.angular_momentum();
    for _ in 0..10_000 {
        crude.update(dt)?;
    }
    let source = "Jacobi's elliptic functions, I = (1, 2, 3)";
    Ok(vec![
        Row::new("textbook: first flip", 10.377_30, at(0), phase(10.4), "s", source),
        Row::new("textbook: from flip to flip", 20.754_61, at(1) - at(0), phase(31.2), "s", source),
        Row::relative(
            "textbook: |L| after 35 s",
            l,
            body.angular_momentum().length(),
            4.0 * EPS64,
            "kg m²/s",
            "no torque",
        ),
        // A rotation is rounded and normalised at every step: a random walk of √n ε, of which ten are allowed for.
        Row::at_most(
            "textbook: drift of the energy",
            10.0 * 35_000f64.sqrt() * EPS64,
            drift,
            "",
            "quadratic, kept by midpoint",
        ),
        Row::at_most(
            "textbook: L of the lecture's loop",
            0.0,
            crude.angular_momentum().distance(kept),
            "kg m²/s",
            "L += τ Δt",
        ),
    ])
}

fn rotating_frame() -> Found {
    let (w0, alpha, mass, dt, n) = (1.3, 0.4, 2.0, 1e-3, 5000);
    let (start, walk) = (DVec3::new(1.0, -0.5, 0.2), DVec3::new(0.3, 0.8, -0.1));
    let omega = |t: f64| DVec3::Z * (w0 + alpha * t);
    let (mut x, mut v) = (start, walk - omega(0.0).cross(start));
    let mut rk4 = Integrator::new(Method::Rk4);
    for i in 0..n {
        rk4.step_point(f64::from(i) * dt, dt, &mut x, &mut v, |t, x, v| {
            let turning = force::centrifugal(mass, omega(t), x) + force::coriolis(mass, omega(t), v);
            (turning + force::euler_force(mass, DVec3::Z * alpha, x)) / mass
        })?;
    }
    let t = dt * f64::from(n);
    let turned = jounce_motion::momentum::turn(DVec3::Z * (w0 * t + 0.5 * alpha * t * t)).rotate(x);
    // RK4: (ωΔt)⁴/120 of the way per radian; ω is at most ω₀ + α t, and the frame's e^{ωt} does not grow in 3.3 m/s.
    let w = w0 + alpha * t;
    let step = w * dt;
    let tolerance = step * step * step * step / 120.0 * w * t * (start + walk * t).length() * w * t;
    Ok(vec![Row::at_most(
        "textbook: free particle in a turning frame",
        tolerance,
        turned.distance(start + walk * t),
        "m",
        "centrifugal + Coriolis + Euler",
    )])
}
