//! Sliding over the seams of a tiled floor: 100 m at 5 m/s without friction, 1 m tiles.

use super::{G, world};
use crate::verify::{Law, Row, Rows};
use jounce::Result;
use jounce::geometry::{TriMesh, TriMeshOptions};
use jounce::prelude::*;
use std::sync::Arc;

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "seams", name: "triangles of one mesh", run: one_mesh },
    Law { topic: "seams", name: "tiles of different bodies", run: many_bodies },
];

const LENGTH: u32 = 104;
const WIDTH: u32 = 22;

fn mesh_floor(w: &mut World) -> Result<()> {
    let mut corners = Vec::new();
    for i in 0..=LENGTH {
        for j in 0..=WIDTH {
            corners.push(Vec3::new(i as f32 - 2.0, 0.0, j as f32 - 2.0));
        }
    }
    let mut triangles = Vec::new();
    for i in 0..LENGTH {
        for j in 0..WIDTH {
            let a = i * (WIDTH + 1) + j;
            let b = a + WIDTH + 1;
            triangles.extend([[a, a + 1, b], [b, a + 1, b + 1]]);
        }
    }
    let mesh = TriMesh::new(&corners, &triangles, TriMeshOptions::default())?;
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::mesh(Arc::new(mesh)).friction(0.0)))?;
    Ok(())
}

fn tiled_floor(w: &mut World) -> Result<()> {
    for i in 0..LENGTH {
        for j in 0..WIDTH {
            let at = [f64::from(i) - 1.5, -0.5, f64::from(j) - 1.5];
            w.add_body(BodyDesc::fixed().at(at).shape(ShapeDesc::cuboid([0.5; 3]).friction(0.0)))?;
        }
    }
    Ok(())
}

/// Largest sideways and vertical speed, and the loss of forward speed, over 100 m at an angle to the tiles.
fn slide(floor: fn(&mut World) -> Result<()>, shape: ShapeDesc, angle: f64) -> Result<[f64; 3]> {
    let mut w = world(G, 60.0)?;
    floor(&mut w)?;
    let (sin, cos) = angle.sin_cos();
    let (along, across) = (DVec3::new(cos, 0.0, sin), DVec3::new(-sin, 0.0, cos));
    let id = w.add_body(
        BodyDesc::dynamic().at([0.3, 0.5, 0.4]).velocity((along * 5.0).as_vec3()).shape(shape.friction(0.0)),
    )?;
    let mut worst = [0.0_f64; 3];
    // A second to sink into the contact and come to rest there.
    while w.time() < 20.0 {
        w.step()?;
        let v = w.body(id)?.velocity().as_dvec3();
        if w.time() > 1.0 {
            for (most, now) in worst.iter_mut().zip([v.dot(across), v.y, v.dot(along) - 5.0]) {
                *most = most.max(now.abs());
            }
        }
    }
    Ok(worst)
}

fn rows(floor: fn(&mut World) -> Result<()>, what: &str) -> Rows {
    let mut rows = Vec::new();
    for (name, shape) in [("box", ShapeDesc::cuboid([0.5; 3])), ("sphere", ShapeDesc::sphere(0.5))] {
        for deg in [0.0_f64, 10.0] {
            let [side, up, loss] = slide(floor, shape.clone(), deg.to_radians())?;
            for (v, which) in [(side, "sideways"), (up, "vertical"), (loss, "lost")] {
                let name = format!("{which} speed of a {name} over {what} at {deg}°");
                rows.push(Row::at_most(&name, 1e-3, v, "m/s", "a flat floor has no seams"));
            }
        }
    }
    Ok(rows)
}

fn one_mesh() -> Rows {
    rows(mesh_floor, "one mesh")
}

fn many_bodies() -> Rows {
    rows(tiled_floor, "many bodies")
}
