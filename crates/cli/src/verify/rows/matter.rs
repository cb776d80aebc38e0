//! Springs, cloth and particles: the textbook's systems beside what can be said of them in closed form, and the engine's
//! particles.
//!
//! ε = 2⁻⁵³ rounds one f64 operation, 2⁻²⁴ one of the engine's particles.

use super::textbook::{EPS64, Found, told};
use super::{EPS, G, world};
use crate::verify::{Law, Row, Rows};
use jounce::particles::snow;
use jounce::prelude::*;
use jounce::{HitResponse, ParticleCollision};
use jounce_motion::cloth::{Cloth, ClothDesc};
use jounce_motion::integrate::Method;
use jounce_motion::jelly::{Jelly, JellyDesc};
use jounce_motion::particles::{Particle, ParticleSystem, PointMass, Spring};
use jounce_motion::springs::{Elasticity, MassSpring};

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "springs", name: "Hooke", run: || told(hooke()) },
    Law { topic: "springs", name: "energy of a swing", run: || told(swing()) },
    Law { topic: "springs", name: "hanging weight", run: || told(hanging()) },
    Law { topic: "cloth", name: "hanging cloth", run: || told(curtain()) },
    Law { topic: "cloth", name: "falling cloth and jelly", run: || told(free()) },
    Law { topic: "particles", name: "the lecture's Euler step", run: || told(euler_step()) },
    Law { topic: "particles", name: "births and a fall", run: births },
    Law { topic: "particles", name: "flakes in still air", run: flakes },
    Law { topic: "particles", name: "one bounce", run: bounce },
];

const DOWN: DVec3 = DVec3::new(0.0, -G, 0.0);

fn hooke() -> Found {
    let mut rows = Vec::new();
    for (name, length, force) in [("stretched", 1.5, 5.0), ("compressed", 0.5, -5.0)] {
        let mut points = [PointMass::new(1.0, DVec3::ZERO)?, PointMass::new(1.0, DVec3::X * length)?];
        Spring::new([0, 1], 10.0, 0.0, 1.0)?.update(&mut points)?;
        let [on_first, on_second] = [0, 1].map(|i| points[i].force());
        let row = format!("textbook: force of a {name} spring");
        rows.push(Row::relative(&row, force, on_first.x, 8.0 * EPS64, "N", "k (|v| − rest) v/|v|"));
        let row = format!("textbook: both ends of a {name} spring");
        rows.push(Row::at_most(&row, 0.0, (on_first + on_second).length(), "N", "equal and opposite"));
    }
    Ok(rows)
}

/// A spring between a frozen and a free point of 1 kg, stretched by a tenth of its length.
fn pulled(method: Method, stiffness: f64) -> jounce_motion::Result<MassSpring> {
    let mut s = MassSpring::new(method);
    let (held, free) = (s.add_point(1.0, DVec3::ZERO)?, s.add_point(1.0, DVec3::X)?);
    s.freeze(held)?;
    s.add_spring([held, free], Elasticity { stiffness, damping: 0.0 })?;
    s.set_position(free, DVec3::X * 1.1)?;
    Ok(s)
}

/// On a spring explicit Euler multiplies the energy by 1 + (ωΔt)² in a step, implicit Euler divides it by that.
fn swing() -> Found {
    let (w_dt, n) = (0.05f64, 200);
    let factor = (1.0 + w_dt * w_dt).powi(n);
    let mut rows = Vec::new();
    for (method, expected) in [(Method::ExplicitEuler, factor), (Method::ImplicitEuler, 1.0 / factor)] {
        let mut s = pulled(method, 100.0)?;
        let start = s.energy().total();
        for _ in 0..n {
            s.step(0.1 * w_dt)?;
        }
        let name = format!("textbook: energy after 200 steps by {method}");
        // The stretch is a tenth of the length, so its rounding ten times as much; Newton ends at 1e-10 of the state.
        let step = if method == Method::ImplicitEuler { 10.0 * 1e-10 } else { 40.0 * EPS64 };
        let got = s.energy().total() / start;
        rows.push(Row::relative(
            &name,
            expected,
            got,
            2.0 * f64::from(n) * step,
            "",
            "(1 + (ωΔt)²)ⁿ, ωΔt = 0.05",
        ));
    }
    Ok(rows)
}

fn hanging() -> Found {
    let mut s = pulled(Method::ImplicitEuler, 100.0)?;
    s.set_gravity(DVec3::X * G)?;
    for _ in 0..2000 {
        s.step(0.05)?;
    }
    // ωΔt = ½: the swing shrinks by 1/√1.25 a step and is gone. Newton ends at 1e-10 of the state.
    let longer = s.positions()[1].x - 1.0;
    Ok(vec![Row::new(
        "textbook: a hanging weight stretches its spring",
        G / 100.0,
        longer,
        1e-9,
        "m",
        "m g/k",
    )])
}

/// A cloth of structural springs alone hangs by its first row: spring i of a column of n bears the n + 1 − i points
/// below it.
fn curtain() -> Found {
    let (n, point, k) = (10.0, 0.01, 200.0);
    let all = ClothDesc {
        columns: 3,
        rows: 11,
        across: DVec3::X * 0.2,
        down: DVec3::Y * -1.0,
        mass: 33.0 * point,
        structural: Some(Elasticity { stiffness: k, damping: 1.0 }),
        ..ClothDesc::default()
    };
    let springs = Cloth::new(&all)?.system.spring_ends().len();
    let mut cloth = Cloth::new(&ClothDesc { shear: None, bend: None, ..all })?;
    cloth.system.set_gravity(DOWN)?;
    for column in 0..3 {
        let held = cloth.index(column, 0);
        cloth.system.freeze(held)?;
    }
    for _ in 0..1500 {
        cloth.system.step(0.05)?;
    }
    let [lowest, held] = [10, 0].map(|row| cloth.system.positions()[cloth.index(1, row)]);
    let longer = n * (n + 1.0) / 2.0 * point * G / k;
    // The slowest swing has ω = 22/s: implicit Euler takes it to 1/√(1 + (ωΔt)²) a step. Newton ends at 1e-10 of the state.
    Ok(vec![
        Row::new(
            "textbook: a hanging cloth is longer by",
            longer,
            -lowest.y - 1.0,
            1e-8,
            "m",
            "n (n + 1)/2 m g/k",
        ),
        Row::at_most(
            "textbook: its pinned row moves by",
            0.0,
            held.distance(DVec3::X * 0.1),
            "m",
            "frozen points",
        ),
        Row::new(
            "textbook: springs of 3 × 11 points",
            130.0,
            springs as f64,
            0.0,
            "",
            "52 structural, 40 shear, 38 bend",
        ),
    ])
}

/// Springs push and pull in pairs, so the middle of what nothing holds falls as a point does.
fn free() -> Found {
    let (dt, n) = (0.001, 1000);
    let mut cloth = Cloth::new(&ClothDesc {
        columns: 8,
        rows: 8,
        method: Method::SemiImplicitEuler,
        ..ClothDesc::default()
    })?;
    let mut jelly = Jelly::new(&JellyDesc { method: Method::SemiImplicitEuler, ..JellyDesc::default() })?;
    // Pulled out of shape.
    cloth.system.set_position(0, DVec3::new(-0.1, 0.1, 0.05))?;
    jelly.system.set_position(0, DVec3::splat(-0.4))?;
    let mut rows = Vec::new();
    for (name, system) in [("cloth", &mut cloth.system), ("jelly", &mut jelly.system)] {
        system.set_gravity(DOWN)?;
        let (start, mass) = (system.center_of_mass(), system.masses().iter().sum::<f64>());
        for _ in 0..n {
            system.step(dt)?;
        }
        let t = dt * f64::from(n);
        let fall = DOWN * (0.5 * t * (t + dt));
        // A step rounds each point's position, velocity and force, of at most 10, 10 and 10 in their units.
        let rounding = 30.0 * f64::from(n) * EPS64;
        let off = (system.center_of_mass() - start).distance(fall);
        rows.push(Row::at_most(
            &format!("textbook: fall of a wobbling {name}, off by"),
            rounding,
            off,
            "m",
            "½ g t (t + Δt)",
        ));
        let off = (system.momentum() - DOWN * (mass * t)).length();
        rows.push(Row::at_most(
            &format!("textbook: momentum of a wobbling {name}, off by"),
            rounding,
            off,
            "kg m/s",
            "m g t",
        ));
    }
    Ok(rows)
}

/// Position by the old velocity: the fall is short by ½ g t Δt.
fn euler_step() -> Found {
    let (dt, n) = (0.02, 100);
    let mut system = ParticleSystem::default();
    system.particles.push(Particle::new(0.4, DVec3::ZERO, DVec3::X)?);
    for _ in 0..n {
        system.add_force(|p| DOWN * p.mass());
        system.euler_step(dt)?;
    }
    let (t, rounding) = (dt * f64::from(n), 8.0 * f64::from(n) * EPS64 * 20.0);
    let p = &system.particles[0];
    Ok(vec![
        Row::new(
            "textbook: fall by EulerStep",
            -0.5 * G * t * (t - dt),
            p.position.y,
            rounding,
            "m",
            "½ g t² − ½ g t Δt",
        ),
        Row::new("textbook: way aside by EulerStep", t, p.position.x, rounding, "m", "v t"),
        Row::at_most(
            "textbook: accumulator after EulerStep",
            0.0,
            p.force_accumulator.length(),
            "N",
            "used and cleared",
        ),
    ])
}

/// One particle a burst, from a point at rest.
fn speck() -> EmitterDesc {
    EmitterDesc::new().burst(0.0, 1).speed(0.0, 0.0).lifetime(100.0, 100.0)
}

fn births() -> Rows {
    let mut w = world(G, 60.0)?;
    let id = w.add_emitter(EmitterDesc::new().rate(70.0).lifetime(0.5, 0.5))?;
    let fall = w.add_emitter(speck())?;
    for _ in 0..240 {
        w.step()?;
    }
    let (born, living) = (w.emitter(id)?.born() as f64, w.emitter(id)?.len() as f64);
    let (t, dt) = (w.time(), w.dt());
    let y = w.emitter(fall)?.particles().next().map_or(f64::NAN, |p| p.position.y);
    Ok(vec![
        // The one of the last moment may count or not.
        Row::new("births in 4 s at 70 a second", 280.0, born, 1.0, "", "rate × time"),
        Row::new("living ones", 35.0, living, 1.0, "", "rate × lifetime"),
        // Semi-implicit Euler by whole steps; each rounds positions of up to 80 m and speeds of up to 40 m/s.
        Row::new(
            "fall of a particle",
            -0.5 * G * t * (t + dt),
            y,
            240.0 * EPS * 80.0,
            "m",
            "½ g t² + ½ g t Δt",
        ),
    ])
}

/// Flakes of the preset sink with g/k where the air rests.
fn flakes() -> Rows {
    let mut w = world(G, 60.0)?;
    let mut flake = snow(DVec3::Y * 100.0, 4.0, 1).remove(0);
    (flake.turbulence, flake.collision) = (None, None);
    let rate = flake.linear_drag;
    let expected = G / f64::from(rate);
    let id = w.add_emitter(flake)?;
    for _ in 0..600 {
        w.step()?;
    }
    let old = w.emitter(id)?.particles().filter(|p| p.age > 3.0).map(|p| f64::from(p.velocity.y) + expected);
    let worst = old.fold(0.0, |worst: f64, off| if off.abs() > worst { off.abs() } else { worst });
    let count = w.emitter(id)?.particles().filter(|p| p.age > 3.0).count();
    // Born at 0.8 to 1.2 m/s: after 3 s the difference has shrunk by (1 + k Δt)^-180, which is 3e-12. A step rounds six
    // times, and keeps 1/(1 + k Δt) of what was off before: (1 + k Δt)/(k Δt) = 7 steps' worth add up.
    let k_dt = f64::from(rate) * w.dt();
    let rounding = 6.0 * EPS * (1.0 + k_dt) / k_dt * expected;
    Ok(vec![
        Row::at_most(
            "flakes sink at g/k, the worst off by",
            rounding,
            worst,
            "m/s",
            "implicit drag: its fixed point is exact",
        ),
        Row::holds("and there are some", count > 100, "10 a second and square metre"),
    ])
}

/// Dropped from 1 m with e = ½: up to a quarter of that.
fn bounce() -> Rows {
    let mut w = world(G, 240.0)?;
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    let collision = ParticleCollision {
        restitution: 0.5,
        friction: 0.0,
        response: HitResponse::Bounce,
        ..ParticleCollision::default()
    };
    let radius = 0.01;
    let id = w.add_emitter(EmitterDesc {
        collision: Some(collision),
        ..speck().at([0.0, 1.0 + radius, 0.0]).body_of_each(0.001, radius as f32)
    })?;
    let (mut highest, mut lowest, t0) = (0.0f64, f64::INFINITY, (2.0 / G).sqrt());
    while w.time() < 2.0 * t0 {
        w.step()?;
        let y = w.emitter(id)?.particles().next().map_or(f64::NAN, |p| p.position.y) - radius;
        lowest = if y < lowest { y } else { lowest };
        highest = if w.time() > 1.1 * t0 && y > highest { y } else { highest };
    }
    let (v, dt) = (G * t0, w.dt());
    Ok(vec![
        // The speed at the hit is off by at most g Δt, and so the height by twice that part; the apex lies between steps.
        Row::new(
            "height after a bounce, e = ½",
            0.25,
            highest,
            0.25 * (2.0 * G * dt / v) + 0.5 * G * dt * dt,
            "m",
            "e² h",
        ),
        Row::at_most(
            "depth of a particle in the ground",
            4.0 * EPS,
            f64::max(-lowest, 0.0),
            "m",
            "stopped at the time of the hit",
        ),
    ])
}
