//! Reads everything a world shows and names the first value that is not finite.

use jounce::prelude::*;
use jounce::{BodyRef, ShapeRef};

/// The first value that is not finite, with its place.
pub fn not_finite(world: &World) -> Option<String> {
    let whole = [world.energy().kinetic, world.energy().potential, world.time()];
    if whole.iter().any(|x| !x.is_finite()) {
        return Some(format!("energy {:?}, time {}", world.energy(), world.time()));
    }
    let m = world.momentum();
    if !m.linear.is_finite() || !m.angular.is_finite() {
        return Some(format!("{m:?}"));
    }
    for id in world.bodies() {
        let b = world.body(id).expect("listed bodies are alive");
        if let Some(what) = body(&b) {
            return Some(format!("body {id:?} {what}: {}", shapes_of(world, &b)));
        }
    }
    for id in world.shapes() {
        let s = world.shape(id).expect("listed shapes are alive");
        if let Some(what) = shape(world, &s) {
            return Some(format!("shape {id:?} {what}"));
        }
    }
    let bad = |p: &jounce::ParticleView| {
        !(p.position.is_finite() && p.velocity.is_finite() && p.age >= 0.0 && p.drawn_radius.is_finite())
    };
    if let Some(p) = world.particles().find(bad) {
        return Some(format!("{p:?}"));
    }
    for id in world.vehicles() {
        let v = world.vehicle(id).expect("listed vehicles are alive");
        let t = v.telemetry();
        let all = [t.speed, t.rpm, t.clutch_torque, t.ratio, t.traction, t.lean];
        if all.iter().any(|x| !x.is_finite()) || v.wheels().any(|w| !wheel(&w)) {
            return Some(format!("vehicle {id:?} {t:?} {:?}", v.wheels().collect::<Vec<_>>()));
        }
    }
    for id in world.characters() {
        let c = world.character(id).expect("listed characters are alive");
        let ground = c.ground().is_none_or(|g| {
            g.point.is_finite()
                && g.normal.is_finite()
                && g.velocity.is_finite()
                && world.body(g.body).is_ok()
        });
        let all = c.position().is_finite() && c.velocity().is_finite() && c.heading().is_finite();
        if !all || !ground || !c.air_time().is_finite() {
            return Some(format!("character {id:?} {:?} {:?} {:?}", c.position(), c.velocity(), c.ground()));
        }
    }
    for id in world.joints() {
        let j = world.joint(id).expect("listed joints are alive");
        let [a, b] = j.anchors();
        let all = a.is_finite() && b.is_finite() && j.force().is_finite() && j.torque().is_finite();
        if !all || !j.coordinate().is_finite() || !j.gap().is_finite() {
            return Some(format!("joint {id:?} {:?} {:?} {:?}", j.force(), j.torque(), j.anchors()));
        }
    }
    world.events().iter().find_map(event)
}

fn wheel(w: &jounce::WheelTelemetry) -> bool {
    let all = [
        w.load,
        w.longitudinal_force,
        w.lateral_force,
        w.slip_ratio,
        w.slip_angle,
        w.friction,
        w.spin,
        w.angle,
        w.steer,
        w.travel,
        w.travel_speed,
        w.suspension_force,
        w.drive_torque,
        w.abs,
    ];
    all.iter().all(|x| x.is_finite()) && w.point.is_finite() && w.normal.is_finite() && w.load >= 0.0
}

fn shapes_of(world: &World, b: &BodyRef<'_>) -> String {
    b.shapes().filter_map(|s| world.shape(s).ok()).map(|s| format!("{:?} ", s.shape())).collect()
}

fn body(b: &BodyRef<'_>) -> Option<String> {
    let unit = (b.rotation().length() - 1.0).abs() < 1e-3;
    let between = b.interpolated_pose(0.5);
    let all = b.position().is_finite()
        && b.rotation().is_finite()
        && b.center_of_mass().is_finite()
        && b.velocity().is_finite()
        && b.angular_velocity().is_finite()
        && b.mass().is_finite()
        && b.mass_properties().inertia.is_finite()
        && between.p.is_finite()
        && between.q.is_finite()
        && b.kinetic_energy().is_finite();
    (!unit || !all)
        .then(|| format!("{:?} v {:?} w {:?} m {}", b.pose(), b.velocity(), b.angular_velocity(), b.mass()))
}

fn shape(world: &World, s: &ShapeRef<'_>) -> Option<String> {
    let pose = s.world_pose();
    let live = s.visitors().all(|v| world.shape(v).is_ok());
    (!pose.p.is_finite() || !pose.q.is_finite() || !live).then(|| format!("{pose:?}, visitors live: {live}"))
}

fn event(e: &Event) -> Option<String> {
    match e {
        Event::ContactHit { point, normal, speed, impulse, .. } => {
            let ok = point.is_finite() && normal.is_finite() && speed.is_finite() && impulse.is_finite();
            (!ok).then(|| format!("{e:?}"))
        }
        _ => None,
    }
}
