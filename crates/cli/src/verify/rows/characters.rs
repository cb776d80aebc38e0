//! Characters: slopes, steps, platforms, seams, jumps, and weight.

use super::{G, world};
use crate::verify::{Law, Row, Rows};
use jounce::math::scalar::f64s;
use jounce::prelude::*;
use jounce::{CharacterDesc, CharacterId, CharacterInput, Result};

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "characters", name: "slopes", run: slopes },
    Law { topic: "characters", name: "steps", run: stairs },
    Law { topic: "characters", name: "jump", run: jump },
    Law { topic: "characters", name: "platforms", run: platforms },
    Law { topic: "characters", name: "seams of tiles", run: seams },
    Law { topic: "characters", name: "weight", run: weight },
];

/// Gap that characters keep, m.
const SKIN: f64 = 0.01;

fn floor(w: &mut World) -> Result<BodyId> {
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))
}

fn hero(w: &mut World, at: [f64; 3], velocity: [f32; 3]) -> Result<CharacterId> {
    let c = w.add_character(CharacterDesc::at(at))?;
    w.set_character_input(c, CharacterInput::walk(velocity))?;
    Ok(c)
}

fn steps(w: &mut World, seconds: f64) -> Result<()> {
    for _ in 0..(seconds / w.dt()).round() as usize {
        w.step()?;
    }
    Ok(())
}

/// A ramp through (2, 0).
fn ramp(w: &mut World, degrees: f64) -> Result<()> {
    let q = Quat::from_axis_angle(Vec3::Z, (degrees as f32).to_radians());
    let middle = Vec3::new(2.0, 0.0, 0.0) + q.rotate(Vec3::new(10.0, -1.0, 0.0));
    let d = BodyDesc::fixed().at(middle.as_dvec3()).rotated(q).shape(ShapeDesc::cuboid([10.0, 1.0, 4.0]));
    w.add_body(d).map(|_| ())
}

fn slopes() -> Rows {
    let mut rows = Vec::new();
    for degrees in [10.0, 20.0, 30.0, 40.0_f64] {
        let mut w = world(G, 60.0)?;
        floor(&mut w)?;
        ramp(&mut w, degrees)?;
        let c = hero(&mut w, [0.0, SKIN, 0.0], [3.0, 0.0, 0.0])?;
        steps(&mut w, 1.5)?;
        let from = w.character(c)?.position();
        steps(&mut w, 1.0)?;
        let got = (w.character(c)?.position() - from).length();
        let name = format!("walking up {degrees}°: speed along the ground");
        rows.push(Row::relative(&name, 3.0, got, 0.001, "m/s", "the wanted speed, along the ground"));
    }
    for degrees in [50.0, 60.0] {
        let mut w = world(G, 60.0)?;
        floor(&mut w)?;
        ramp(&mut w, degrees)?;
        let c = hero(&mut w, [0.0, SKIN, 0.0], [3.0, 0.0, 0.0])?;
        steps(&mut w, 3.0)?;
        let name = format!("walking against {degrees}°, beyond the steepest of 45°: height");
        // The skin, and as much as its round foot rolls up.
        rows.push(Row::at_most(&name, 0.05, w.character(c)?.position().y, "m", "it stays below"));
    }
    Ok(rows)
}

fn stairs() -> Rows {
    let mut rows = Vec::new();
    for rise in [0.1, 0.2, 0.3, 0.35, 0.4, 0.5_f64] {
        let mut w = world(G, 60.0)?;
        floor(&mut w)?;
        for i in 0..5 {
            let top = 0.5 * rise * f64::from(i + 1);
            let at = [2.0 + 0.4 * f64::from(i) + 5.0, top, 0.0];
            w.add_body(BodyDesc::fixed().at(at).shape(ShapeDesc::cuboid([5.0, top as f32, 2.0])))?;
        }
        let c = hero(&mut w, [0.0, SKIN, 0.0], [2.0, 0.0, 0.0])?;
        steps(&mut w, 3.0)?;
        let up = if rise <= 0.35 { 5.0 * rise } else { 0.0 };
        let name = format!("five steps of {rise} m, at most 0.35 m: height");
        let got = w.character(c)?.position().y;
        rows.push(Row::new(&name, up + SKIN, got, 2e-3, "m", "climbed, or not"));
    }
    Ok(rows)
}

fn jump() -> Rows {
    let mut w = world(G, 60.0)?;
    floor(&mut w)?;
    let c = hero(&mut w, [0.0, SKIN, 0.0], [0.0; 3])?;
    steps(&mut w, 0.1)?;
    w.set_character_input(c, CharacterInput::default().jump(5.0))?;
    let mut top = 0.0_f64;
    for _ in 0..60 {
        w.step()?;
        top = f64s::max(top, w.character(c)?.position().y);
    }
    // A character moves once a step: ½ v Δt.
    let tolerance = 0.5 * 5.0 * w.dt() + 1e-3;
    Ok(vec![Row::new("jump at 5 m/s: height", 25.0 / (2.0 * G) + SKIN, top, tolerance, "m", "v²/2g; ½ v Δt")])
}

fn platforms() -> Rows {
    let mut w = world(G, 60.0)?;
    let lift = BodyDesc::kinematic().at([0.0, -0.5, 0.0]).shape(ShapeDesc::cuboid([2.0, 0.5, 2.0]));
    let lift = w.add_body(lift)?;
    let c = hero(&mut w, [0.5, SKIN, 0.5], [0.0; 3])?;
    steps(&mut w, 0.1)?;
    w.set_velocity(lift, Vec3::new(2.0, 1.0, -1.0))?;
    let mut off = 0.0_f64;
    for _ in 0..120 {
        w.step()?;
        let d = w.character(c)?.position() - w.body(lift)?.position();
        off = f64s::max(off, (d - DVec3::new(0.5, 0.5 + SKIN, 0.5)).length());
    }
    let mut rows =
        vec![Row::at_most("on a platform at 2.4 m/s: slip", 2e-3, off, "m", "it is carried along")];
    let mut w = world(G, 60.0)?;
    let table = BodyDesc::kinematic().at([0.0, -0.5, 0.0]).shape(ShapeDesc::cylinder(0.5, 3.0));
    let table = w.add_body(table)?;
    let c = hero(&mut w, [2.0, SKIN, 0.0], [0.0; 3])?;
    steps(&mut w, 0.1)?;
    w.set_angular_velocity(table, Vec3::new(0.0, 1.0, 0.0))?;
    steps(&mut w, 3.0)?;
    let p = w.body(table)?.pose().inverse_transform_point(w.character(c)?.position());
    let off = f64::from((p - Vec3::new(2.0, (0.5 + SKIN) as f32, 0.0)).length());
    rows.push(Row::at_most("on a turntable for 3 rad: slip", 0.01, off, "m", "it is carried round"));
    let heading = f64::from(w.character(c)?.heading());
    rows.push(Row::new("on a turntable for 3 rad: heading", 3.0, heading, 0.02, "rad", "ω t"));
    Ok(rows)
}

fn seams() -> Rows {
    let mut w = world(G, 60.0)?;
    for i in -1..14 {
        for j in -2..5 {
            let at = [f64::from(i) + 0.5, -0.5, f64::from(j) + 0.5];
            w.add_body(BodyDesc::fixed().at(at).shape(ShapeDesc::cuboid([0.5, 0.5, 0.5])))?;
        }
    }
    let c = hero(&mut w, [0.3, 0.05, 0.2], [0.0; 3])?;
    steps(&mut w, 0.5)?;
    let (dir, across) = (DVec3::new(0.978, 0.0, 0.2085), DVec3::new(-0.2085, 0.0, 0.978));
    w.set_character_input(c, CharacterInput::walk(dir.as_vec3() * 5.0))?;
    steps(&mut w, 0.2)?;
    let (mut side, mut rise) = (0.0_f64, 0.0_f64);
    let mut last = w.character(c)?.position();
    for _ in 0..110 {
        w.step()?;
        let now = w.character(c)?.position();
        let v = (now - last) * 60.0;
        last = now;
        (side, rise) = (f64s::max(side, v.dot(across).abs()), f64s::max(rise, v.y.abs()));
    }
    Ok(vec![
        Row::at_most("5 m/s over tiles of 1 m: sideways speed", 1e-3, side, "m/s", "a plane"),
        Row::at_most("5 m/s over tiles of 1 m: vertical speed", 1e-3, rise, "m/s", "a plane"),
    ])
}

/// A dynamic character stands on a plate: the floor bears both weights.
fn weight() -> Rows {
    let mut w = world(G, 60.0)?;
    floor(&mut w)?;
    let plate = BodyDesc::dynamic().at([0.0, 0.1, 0.0]).shape(ShapeDesc::cuboid([1.0, 0.1, 1.0]).mass(50.0));
    let plate = w.add_body(plate)?;
    w.add_character(CharacterDesc::at([0.2, 0.2, 0.1]).dynamic())?;
    steps(&mut w, 3.0)?;
    let mut got = 0.0;
    for _ in 0..60 {
        w.step()?;
        let contacts = w.contacts_of(plate)?;
        got += contacts.iter().map(|c| f64::from(c.normal_force())).sum::<f64>() / 60.0;
    }
    Ok(vec![Row::relative("80 kg on a plate of 50 kg: force on the floor", 130.0 * G, got, 0.01, "N", "m g")])
}
