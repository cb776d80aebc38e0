//! Piles: a stack that stands, the 100-row pyramid, heavy on light.

use super::{G, awake, run, world};
use crate::verify::{Law, Row, Rows};
use jounce::prelude::*;

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "stacks", name: "20 boxes for ten minutes", run: twenty },
    Law { topic: "stacks", name: "100-row pyramid", run: pyramid },
    Law { topic: "stacks", name: "heavy on light", run: heavy_on_light },
];

fn twenty() -> Rows {
    let mut w = world(G, 60.0)?;
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    let mut ids = Vec::new();
    for i in 0..20 {
        let at = [0.0, 0.5 + f64::from(i), 0.0];
        ids.push(w.add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid([0.5; 3])))?);
    }
    run(&mut w, 10.0)?;
    let settled: Vec<DVec3> =
        ids.iter().map(|&id| Ok(w.body(id)?.position())).collect::<jounce::Result<_>>()?;
    run(&mut w, 600.0)?;
    let mut drift = 0.0_f64;
    for (&id, at) in ids.iter().zip(&settled) {
        drift = drift.max(w.body(id)?.position().distance(*at));
    }
    Ok(vec![Row::at_most(
        "20 boxes, 10 min, never asleep: drift",
        1e-3,
        drift,
        "m",
        "at rest; promise of 1 mm",
    )])
}

/// The scene that engines are compared on: 100 rows of 1 m cubes, gravity 10 m/s².
fn pyramid() -> Rows {
    const ROWS: u32 = 100;
    let gravity = Vec3::new(0.0, -10.0, 0.0);
    let mut w = World::new(WorldDesc { gravity, settings: awake(), ..WorldDesc::default() })?;
    w.add_body(BodyDesc::fixed().at([0.0, -1.0, 0.0]).shape(ShapeDesc::cuboid([400.0, 1.0, 400.0])))?;
    let mut top = None;
    for i in 0..ROWS {
        for j in i..ROWS {
            let x = f64::from(i + 1) * 0.5 + f64::from(j - i) - 0.5 * f64::from(ROWS);
            let cube = ShapeDesc::cuboid([0.5; 3]).density(100.0);
            top = Some(w.add_body(BodyDesc::dynamic().at([x, f64::from(2 * i + 1) * 0.5, 0.0]).shape(cube))?);
        }
    }
    for _ in 0..200 {
        w.step()?;
    }
    let y = top.map_or(Ok(f64::NAN), |id| w.body(id).map(|b| b.position().y))?;
    let source = "Box3D on the same scene sags to 98.80 m";
    Ok(vec![Row::at_most("sag of the top of a 100-row pyramid, 200 steps", 0.70, 99.5 - y, "m", source)])
}

fn heavy_on_light() -> Rows {
    let mut w = world(G, 60.0)?;
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    let cube = |mass: f32| ShapeDesc::cuboid([0.5; 3]).mass(mass);
    let light = w.add_body(BodyDesc::dynamic().at([0.0, 0.5, 0.0]).shape(cube(1.0)))?;
    let heavy = w.add_body(BodyDesc::dynamic().at([0.0, 1.5, 0.0]).shape(cube(1000.0)))?;
    run(&mut w, 10.0)?;
    let sink = |id, from: f64| Ok::<_, jounce::Error>((from - w.body(id)?.position().y).abs());
    let source = "1,000 kg on 1 kg for 10 s: at most 10 mm; Box3D 341.9 and 69.2 mm";
    Ok(vec![
        Row::at_most("heavy on light: the heavy box sinks", 0.01, sink(heavy, 1.5)?, "m", source),
        Row::at_most("heavy on light: the light box sinks", 0.01, sink(light, 0.5)?, "m", source),
    ])
}
