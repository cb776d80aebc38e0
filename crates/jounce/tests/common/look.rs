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
    world.events().iter().find_map(event)
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
