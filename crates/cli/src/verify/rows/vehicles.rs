//! Vehicles: loads, grip, carving.
//!
//! Tyres are brushes with a spring of their own and relaxation, suspensions have dampers: what a row measures is a steady state of those,
//! reached within a few parts in a thousand after the seconds that it waits. A tyre holds μ N only as all of it slides, and pitch and
//! roll move the centre of mass by centimetres of its 0.5 m: where grip and transfer are measured, the tolerance is 3 %.

use super::{EPS, G, world};
use crate::verify::{Law, Row, Rows};
use jounce::math::scalar::{f32s, f64s};
use jounce::prelude::*;
use jounce::vehicles::{VehicleKit, car, carry, motorcycle, off_road, snowboard, sports_car};
use jounce::{Result, VehicleId};

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "vehicles", name: "axle loads", run: axle_loads },
    Law { topic: "vehicles", name: "load transfer", run: transfer },
    Law { topic: "vehicles", name: "braking distance", run: braking },
    Law { topic: "vehicles", name: "skid pad", run: skid_pad },
    Law { topic: "vehicles", name: "friction circle", run: friction_circle },
    Law { topic: "vehicles", name: "top speed", run: top_speed },
    Law { topic: "vehicles", name: "lean", run: lean },
    Law { topic: "vehicles", name: "board: glide", run: glide },
    Law { topic: "vehicles", name: "board: carve", run: carve },
    Law { topic: "vehicles", name: "board: jump", run: jump },
];

/// m of the car, kg; its wheelbase and its centre of mass before the rear axle, m.
const M: f64 = 1300.0;
const BASE: f64 = 2.6;
const BEFORE_REAR: f64 = 1.4;

fn road(w: &mut World, friction: f32) -> Result<BodyId> {
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).friction(friction)))
}

/// The car without engine, air, rolling resistance and electronics, on tyres of friction μ.
fn plain(mu: f32) -> VehicleKit {
    let mut kit = car();
    let v = &mut kit.vehicle;
    (v.drive, v.abs, v.traction) = (None, None, None);
    v.aero.clear();
    for w in &mut v.wheels {
        (w.tyre.static_friction, w.tyre.kinetic_friction) = (mu, mu);
        w.tyre.rolling_resistance = 0.0;
    }
    kit
}

fn steps(w: &mut World, seconds: f64) -> Result<()> {
    for _ in 0..(seconds / w.dt()).round() as usize {
        w.step()?;
    }
    Ok(())
}

fn chassis(w: &World, v: VehicleId) -> Result<BodyId> {
    Ok(w.vehicle(v)?.chassis())
}

fn axles(w: &World, v: VehicleId) -> Result<[f64; 2]> {
    let n: Vec<f64> = w.vehicle(v)?.wheels().map(|t| f64::from(t.load)).collect();
    Ok([n[0] + n[1], n[2] + n[3]])
}

fn axle_loads() -> Rows {
    let mut w = world(G, 60.0)?;
    road(&mut w, 1.0)?;
    let v = plain(1.0).add(&mut w, [0.0; 3], Quat::IDENTITY)?;
    steps(&mut w, 5.0)?;
    let [front, rear] = axles(&w, v)?;
    let want = |part: f64| M * G * part / BASE;
    Ok(vec![
        Row::relative("car at rest: front axle", want(BEFORE_REAR), front, 0.002, "N", "m g b/L"),
        Row::relative("car at rest: rear axle", want(BASE - BEFORE_REAR), rear, 0.002, "N", "m g a/L"),
    ])
}

fn transfer() -> Rows {
    let mut w = world(G, 60.0)?;
    road(&mut w, 1.0)?;
    let v = plain(1.0).add(&mut w, [0.0; 3], Quat::IDENTITY)?;
    let b = chassis(&w, v)?;
    w.set_velocity(b, Vec3::new(0.0, 0.0, 30.0))?;
    steps(&mut w, 1.0)?;
    w.set_vehicle_input(v, VehicleInput::brake(0.35))?;
    steps(&mut w, 1.2)?;
    let (mut a, mut front, mut height) = (0.0, 0.0, 0.0);
    for _ in 0..30 {
        let before = w.body(b)?.velocity().z;
        w.step()?;
        a += f64::from(before - w.body(b)?.velocity().z) / w.dt() / 30.0;
        front += axles(&w, v)?[0] / 30.0;
        height += w.body(b)?.center_of_mass().y / 30.0;
    }
    let want = M * G * BEFORE_REAR / BASE + M * a * height / BASE;
    let name = format!("car braking at {a:.2} m/s²: front axle");
    Ok(vec![Row::relative(&name, want, front, 0.03, "N", "m g b/L + m a h/L")])
}

fn braking() -> Rows {
    let mut w = world(G, 60.0)?;
    road(&mut w, 0.9)?;
    let v = plain(0.9).add(&mut w, [0.0; 3], Quat::IDENTITY)?;
    steps(&mut w, 2.0)?;
    let b = chassis(&w, v)?;
    w.set_velocity(b, Vec3::new(0.0, 0.0, (100.0 / 3.6) as f32))?;
    let from = w.body(b)?.position().z;
    w.set_vehicle_input(v, VehicleInput::brake(1.0))?;
    let start = w.time();
    while w.body(b)?.velocity().z > 1e-2 && w.time() < start + 10.0 {
        w.step()?;
    }
    let got = w.body(b)?.position().z - from;
    let want = (100.0_f64 / 3.6) * (100.0 / 3.6) / (2.0 * 0.9 * G);
    Ok(vec![Row::relative("100 to 0 km/h at μ = 0.9", want, got, 0.03, "m", "v²/2 μ g")])
}

/// A car is held on a circle of 30 m while its speed grows by 0.1 m/s². Its speed is the mean of a second in which it kept
/// within half a metre of the circle, brought to 30 m by √(R/r).
fn skid_pad() -> Rows {
    let mut w = world(G, 60.0)?;
    road(&mut w, 1.0)?;
    let mut kit = plain(1.0);
    // The centre in the middle and stiff tyres: both axles end together, at small angles.
    if let Some(m) = &mut kit.body.mass {
        m.center.z = 0.0;
    }
    carry(&mut kit.vehicle.wheels, M as f32, 0.0);
    kit.vehicle.wheels.iter_mut().for_each(|x| x.tyre.cornering_stiffness = 60.0);
    let v = kit.add(&mut w, [0.0; 3], Quat::IDENTITY)?;
    let b = chassis(&w, v)?;
    w.set_velocity(b, Vec3::new(0.0, 0.0, 14.0))?;
    steps(&mut w, 0.5)?;
    let center = w.body(b)?.center_of_mass() + DVec3::new(-30.0, 0.0, 0.0);
    let (mut best, mut heading, start) = (0.0_f64, 0.0, w.time());
    let mut window: Vec<f64> = Vec::new();
    while w.time() - start < 60.0 {
        let body = w.body(b)?;
        let r = body.center_of_mass() - center;
        let distance = (r.x * r.x + r.z * r.z).sqrt();
        let velocity = body.velocity().as_dvec3();
        let speed = velocity.length();
        let (out, error) = (velocity.dot(r) / distance, distance - 30.0);
        if error > 3.0 {
            break;
        }
        // Steered by place, by its rate and its sum; pushed along its velocity, which turns nothing.
        heading += 0.02 * error * w.dt();
        let steer = f64s::clamp(0.15 + 0.3 * error + 0.25 * out + heading, -1.0, 1.0);
        w.set_vehicle_input(v, VehicleInput { steer: steer as f32, ..VehicleInput::default() })?;
        let wanted = 14.0 + 0.1 * (w.time() - start);
        let push = velocity * (M * f64s::clamp(wanted - speed, -1.0, 1.0) * 4.0 / f64s::max(speed, 1.0));
        w.add_force(b, push.as_vec3(), None)?;
        w.step()?;
        if error.abs() < 0.5 && w.time() - start > 5.0 {
            window.push(speed * (30.0 / distance).sqrt());
        } else {
            window.clear();
        }
        if window.len() >= 60 {
            best = f64s::max(best, window[window.len() - 60..].iter().sum::<f64>() / 60.0);
        }
    }
    let want = (G * 30.0).sqrt();
    Ok(vec![Row::relative("skid pad of 30 m at μ = 1: top speed", want, best, 0.03, "m/s", "√(μ g R)")])
}

/// Full pedals and full steering in turn, over kerbs.
fn friction_circle() -> Rows {
    let kits = [
        ("car", car()),
        ("sports car", sports_car()),
        ("off-road car", off_road()),
        ("motorcycle", motorcycle()),
    ];
    let mut rows = Vec::new();
    for (name, kit) in kits {
        let mut w = world(G, 60.0)?;
        road(&mut w, 1.0)?;
        for i in 0..12 {
            let side = if i % 2 == 0 { -1.0 } else { 1.0 };
            let kerb = ShapeDesc::cuboid([1.5, 0.06, 0.4]).friction(0.7);
            w.add_body(BodyDesc::fixed().at([side, 0.0, 15.0 + 9.0 * f64::from(i)]).shape(kerb))?;
        }
        let v = kit.add(&mut w, [0.0; 3], Quat::IDENTITY)?;
        let mut most = 0.0_f64;
        for i in 0..1200_u32 {
            let on = |every: u32, of: u32| (i / every).is_multiple_of(of);
            let input = VehicleInput {
                throttle: if on(40, 2) { 1.0 } else { 0.0 },
                brake: if on(30, 5) { 1.0 } else { 0.0 },
                handbrake: if on(25, 7) { 1.0 } else { 0.0 },
                steer: [0.0, 1.0, 0.3, -1.0, -0.4][(i / 35 % 5) as usize],
                gear: 1 + i as i32 / 300,
                ..VehicleInput::default()
            };
            w.set_vehicle_input(v, input)?;
            w.step()?;
            for t in w.vehicle(v)?.wheels().filter(|t| t.load > 1.0) {
                let (x, y) = (f64::from(t.longitudinal_force), f64::from(t.lateral_force));
                most = f64s::max(most, (x * x + y * y).sqrt() / (f64::from(t.friction) * f64::from(t.load)));
            }
        }
        // Reached where pedals and wheel are thrown about; beyond it is only the rounding of some sums.
        let name = format!("{name}: largest tyre force");
        rows.push(Row::new(&name, 1.0, most, 100.0 * EPS, "μ N", "friction circle"));
    }
    Ok(rows)
}

/// On the flat in neutral gear, pushed by a force: drag and rolling resistance hold it.
fn top_speed() -> Rows {
    let mut w = world(G, 60.0)?;
    road(&mut w, 1.0)?;
    let mut kit = car();
    kit.vehicle.drive = None;
    let v = kit.add(&mut w, [0.0; 3], Quat::IDENTITY)?;
    let b = chassis(&w, v)?;
    w.set_velocity(b, Vec3::new(0.0, 0.0, 40.6))?;
    let force = 800.0_f64;
    for _ in 0..(60.0 * 120.0) as usize {
        let forward = w.body(b)?.rotation().rotate(Vec3::Z);
        w.add_force(b, forward * force as f32, None)?;
        w.step()?;
    }
    // Air of 1.2 kg/m³ on 0.65 m². Against rolling a torque of 0.012 R times the load, on the lever R − δ of a tyre that gives by δ.
    let give = M * G / 4.0 / 200_000.0;
    let rolling = 0.012 * M * G * 0.3 / (0.3 - give);
    let want = (2.0 * (force - rolling) / (1.2 * 0.65)).sqrt();
    let got = f64::from(w.body(b)?.velocity().z);
    let source = "½ ρ v² C_d A + c_r m g R/(R − δ) = F";
    // τ = m/(ρ C_d A v) is 40 s; after three of them 5 % of the start's error are left, 0.01 m/s. Axles give unevenly, a few per cent
    // of the resistance to rolling, which is a fifth of all: half of that in the speed.
    Ok(vec![Row::relative("car pushed by 800 N: speed", want, got, 0.005, "m/s", source)])
}

fn lean() -> Rows {
    let mut w = world(G, 60.0)?;
    road(&mut w, 1.0)?;
    let v = motorcycle().add(&mut w, [0.0; 3], Quat::IDENTITY)?;
    let b = chassis(&w, v)?;
    w.set_velocity(b, Vec3::new(0.0, 0.0, 15.0))?;
    steps(&mut w, 0.5)?;
    for i in 0..720 {
        let t = w.vehicle(v)?.telemetry();
        let throttle = f32s::clamp(0.5 * (15.0 - t.speed) + 0.1, 0.0, 1.0);
        let steer = 0.06 * f32s::min(i as f32 / 120.0, 1.0);
        w.set_vehicle_input(v, VehicleInput::drive(throttle, steer))?;
        w.step()?;
    }
    let body = w.body(b)?;
    let want = f64s::atan2(f64::from(-body.angular_velocity().y * body.velocity().length()), G);
    let got = f64::from(w.vehicle(v)?.telemetry().lean);
    let degrees = 180.0 / std::f64::consts::PI;
    // Tyres are round: the point of contact wanders by half their width under a centre 0.6 m up.
    Ok(vec![Row::relative(
        "motorcycle in a turn: lean",
        want * degrees,
        got * degrees,
        0.03,
        "°",
        "atan(v ω/g)",
    )])
}

fn snow(w: &mut World, degrees: f32) -> Result<Quat> {
    let slope = Quat::from_axis_angle(Vec3::X, degrees.to_radians());
    w.add_body(BodyDesc::fixed().rotated(slope).shape(ShapeDesc::half_space(Vec3::Y).friction(0.3)))?;
    Ok(slope)
}

fn glide() -> Rows {
    let angle = 15.0_f64.to_radians();
    let pull = G * (angle.sin() - 0.04 * angle.cos());
    let mut w = world(G, 60.0)?;
    let slope = snow(&mut w, 15.0)?;
    let mut kit = snowboard();
    kit.vehicle.aero.clear();
    let v = kit.add(&mut w, [0.0; 3], slope)?;
    steps(&mut w, 1.5)?;
    let b = chassis(&w, v)?;
    let v0 = w.body(b)?.velocity().length();
    steps(&mut w, 2.0)?;
    let got = f64::from(w.body(b)?.velocity().length() - v0) / 2.0;
    let mut rows = vec![Row::relative(
        "board on 15°, no air: acceleration",
        pull,
        got,
        0.01,
        "m/s²",
        "g (sin θ − μ cos θ)",
    )];
    let mut w = world(G, 60.0)?;
    let slope = snow(&mut w, 15.0)?;
    let v = snowboard().add(&mut w, [0.0; 3], slope)?;
    let b = chassis(&w, v)?;
    w.set_velocity(b, slope.rotate(Vec3::new(0.0, 0.0, 20.0)))?;
    steps(&mut w, 60.0)?;
    // 80 kg, ρ = 1.2 kg/m³, C_d A = 0.5 m²; τ = m/(ρ C_d A v) is 5.5 s.
    let want = (2.0 * 80.0 * pull / (1.2 * 0.5)).sqrt();
    let got = f64::from(w.body(b)?.velocity().length());
    let source = "√(2 m g (sin θ − μ cos θ)/(ρ C_d A))";
    rows.push(Row::relative("board on 15°: terminal speed", want, got, 0.01, "m/s", source));
    Ok(rows)
}

fn carve() -> Rows {
    let mut rows = Vec::new();
    for lean in [0.5_f32, 0.8, -0.5] {
        let mut w = world(G, 60.0)?;
        snow(&mut w, 0.0)?;
        let mut kit = snowboard();
        kit.vehicle.aero.clear();
        if let Some(b) = &mut kit.vehicle.board {
            (b.friction, b.edge_friction) = (0.0, 3.0);
        }
        let v = kit.add(&mut w, [0.0; 3], Quat::IDENTITY)?;
        steps(&mut w, 0.5)?;
        let b = chassis(&w, v)?;
        w.set_velocity(b, Vec3::new(0.0, 0.0, 5.0))?;
        w.set_vehicle_input(v, VehicleInput { lean, ..VehicleInput::default() })?;
        steps(&mut w, 1.5)?;
        let (mut rate, mut angle, mut speed) = (0.0, 0.0, 0.0);
        for _ in 0..60 {
            w.step()?;
            let body = w.body(b)?;
            rate += f64::from(body.angular_velocity().y).abs() / 60.0;
            angle += f64::from(w.vehicle(v)?.telemetry().lean) / 60.0;
            // At the base: the rider's weight is inside the turn.
            speed += f64::from(body.velocity_at(body.position()).length()) / 60.0;
        }
        let name = format!("board, {:.0}° of edge, side-cut 8 m: carve radius", angle.to_degrees());
        let source = "R_sidecut cos θ (Howe 2001)";
        // The ends of the edge stand by a board's length, 1.2 m, on the arc, not on its tangent.
        rows.push(Row::relative(&name, 8.0 * angle.cos(), speed / rate, 0.03, "m", source));
    }
    Ok(rows)
}

fn jump() -> Rows {
    let mut w = world(G, 60.0)?;
    snow(&mut w, 0.0)?;
    let v = snowboard().add(&mut w, [0.0; 3], Quat::IDENTITY)?;
    steps(&mut w, 1.0)?;
    let b = chassis(&w, v)?;
    let y0 = w.body(b)?.center_of_mass().y;
    w.set_vehicle_input(v, VehicleInput { jump: 1.0, ..VehicleInput::default() })?;
    let mut top = 0.0_f64;
    for _ in 0..60 {
        w.step()?;
        top = f64s::max(top, w.body(b)?.center_of_mass().y - y0);
    }
    // Legs of 40 kN/m are bent by 2 cm of weight; they give that back.
    Ok(vec![Row::new("board: jump at 3 m/s", 9.0 / (2.0 * G), top, 0.02, "m", "v²/2g; legs bent by m g/k")])
}
