//! Far from the origin: what happens at 10⁶ m happens at the same times as at the origin.

use super::{G, crossing, world};
use crate::verify::{Law, Row, Rows};
use jounce::Result;
use jounce::math::Mat3;
use jounce::prelude::*;

pub(crate) const LAWS: &[Law] = &[Law { topic: "far away", name: "times at 1e6 m", run: times }];

const FAR: DVec3 = DVec3::new(1e6, 1e6, -1e6);
const PART: f64 = 1e-3;

/// A stack of five is let fall from 5 cm each; time until all sleep.
fn stack(at: DVec3) -> Result<f64> {
    let mut w = World::new(WorldDesc::default())?;
    w.add_body(BodyDesc::fixed().at(at).shape(ShapeDesc::half_space(Vec3::Y)))?;
    let mut top = None;
    for i in 0..5 {
        let p = at + DVec3::new(0.0, 0.55 + 1.05 * f64::from(i), 0.0);
        top = Some(w.add_body(BodyDesc::dynamic().at(p).shape(ShapeDesc::cuboid([0.5; 3])))?);
    }
    while w.time() < 30.0 {
        w.step()?;
        if top.map_or(Ok(false), |id| w.body(id).map(|b| !b.is_awake()))? {
            return Ok(w.time());
        }
    }
    Ok(f64::NAN)
}

/// Third landing of an elastic ball: where its velocity turns from down to up is between steps, so the apex is timed.
fn bounce(at: DVec3) -> Result<f64> {
    let mut w = world(G, 60.0)?;
    w.add_body(BodyDesc::fixed().at(at).shape(ShapeDesc::half_space(Vec3::Y)))?;
    let p = at + DVec3::new(0.0, 1.5, 0.0);
    let id = w.add_body(BodyDesc::dynamic().at(p).shape(ShapeDesc::sphere(0.5).restitution(0.9)))?;
    let mut t = f64::NAN;
    for _ in 0..3 {
        t = crossing(&mut w, 20.0, |w| Ok(f64::from(w.body(id)?.velocity().y)))?;
    }
    Ok(t)
}

/// Second flip of a torque-free asymmetric body.
fn flip(at: DVec3) -> Result<f64> {
    let mut w = world(0.0, 60.0)?;
    let mass = jounce::geometry::MassProperties {
        mass: 1.0,
        center: Vec3::ZERO,
        inertia: Mat3::from_diagonal(Vec3::new(1.0, 2.0, 3.0)),
    };
    let id = w.add_body(BodyDesc::dynamic().at(at).angular_velocity([0.01, 1.0, 0.0]).mass(mass))?;
    let about_y = |w: &World| {
        let b = w.body(id)?;
        Ok(b.rotation().as_dquat().inverse_rotate(b.angular_velocity().as_dvec3()).y)
    };
    crossing(&mut w, 40.0, about_y)?;
    crossing(&mut w, 60.0, |w| about_y(w).map(|y| -y))
}

/// A block slides down a slope of 30° and passes 5 m.
fn slide(at: DVec3) -> Result<f64> {
    let mut w = world(G, 60.0)?;
    let (sin, cos) = 30.0_f64.to_radians().sin_cos();
    let plane = ShapeDesc::half_space(Vec3::new(sin as f32, cos as f32, 0.0)).friction(0.3);
    w.add_body(BodyDesc::fixed().at(at).shape(plane))?;
    let p = at + DVec3::new(sin, cos, 0.0) * 0.1;
    let turn = Quat::from_axis_angle(Vec3::Z, -30.0_f32.to_radians());
    let block = ShapeDesc::cuboid([0.5, 0.1, 0.5]).friction(0.3);
    let id = w.add_body(BodyDesc::dynamic().at(p).rotated(turn).shape(block))?;
    crossing(&mut w, 20.0, |w| Ok(5.0 - (w.body(id)?.position() - p).dot(DVec3::new(cos, -sin, 0.0))))
}

fn times() -> Rows {
    let row = |name: &str, f: fn(DVec3) -> Result<f64>| -> Result<Row> {
        Ok(Row::relative(name, f(DVec3::ZERO)?, f(FAR)?, PART, "s", "the same at the origin"))
    };
    Ok(vec![
        row("a stack falls asleep at 1e6 m", stack)?,
        row("apex after the third bounce at 1e6 m", bounce)?,
        row("second flip at 1e6 m", flip)?,
        row("block slides 5 m at 1e6 m", slide)?,
    ])
}
