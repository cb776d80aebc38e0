//! Fast and thin: nothing goes through.

use super::{G, prove, run, world};
use crate::verify::{Law, Row, Rows};
use jounce::geometry::{TriMesh, TriMeshOptions};
use jounce::prelude::*;
use jounce::{Filter, Result};
use std::sync::Arc;

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "fast and thin", name: "shots at walls", run: shots },
    Law { topic: "fast and thin", name: "coins on a mesh", run: coins },
];

/// The same numbers every time: a linear congruence (Knuth, MMIX), upper bits, to [0, 1).
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
    fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.roll()
    }
}

/// Bodies that meet the walls only, never each other.
const ALONE: Filter = Filter { layers: 1, mask: 1, group: -1 };
const WALL: Filter = Filter { layers: 1, mask: 1, group: 0 };

#[derive(Clone, Copy, PartialEq)]
enum Wall {
    Box,
    Tiles,
    Mesh,
}

/// A wall 0.1 m thick, 200 m high and wide, its near face at x = 0.
fn wall(w: &mut World, kind: Wall) -> Result<()> {
    match kind {
        Wall::Box => {
            let shape = ShapeDesc::cuboid([0.05, 100.0, 100.0]).filter(WALL);
            w.add_body(BodyDesc::fixed().at([0.05, 0.0, 0.0]).shape(shape))?;
        }
        Wall::Tiles => {
            for i in 0..400 {
                let at = [0.05, f64::from(i % 20) * 10.0 - 95.0, f64::from(i / 20) * 10.0 - 95.0];
                w.add_body(BodyDesc::fixed().at(at).shape(ShapeDesc::cuboid([0.05, 5.0, 5.0]).filter(WALL)))?;
            }
        }
        Wall::Mesh => {
            // Two sheets that face outwards.
            let s = 100.0;
            let sheet = |x: f32| [[x, -s, -s], [x, s, -s], [x, s, s], [x, -s, s]];
            let corners: Vec<Vec3> = sheet(0.0).into_iter().chain(sheet(0.1)).map(Vec3::from_array).collect();
            let triangles = [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]];
            let mesh = TriMesh::new(&corners, &triangles, TriMeshOptions::default())?;
            w.add_body(BodyDesc::fixed().shape(ShapeDesc::mesh(Arc::new(mesh)).filter(WALL)))?;
        }
    }
    Ok(())
}

/// Shots at 250 m/s from all directions within 60° of the normal; how many are behind the wall after half a second.
fn through(kind: Wall, count: usize, dice: &mut Dice) -> Result<f64> {
    let mut behind = 0;
    let mut left = count;
    while left > 0 {
        let batch = left.min(500);
        left -= batch;
        let mut w = world(0.0, 60.0)?;
        wall(&mut w, kind)?;
        let mut ids = Vec::new();
        for _ in 0..batch {
            let radius = dice.between(0.02, 0.3);
            let (tilt, around) =
                (dice.between(0.0, 60.0).to_radians(), dice.between(0.0, std::f64::consts::TAU));
            let dir = DVec3::new(tilt.cos(), tilt.sin() * around.cos(), tilt.sin() * around.sin());
            let target = DVec3::new(0.0, dice.between(-60.0, 60.0), dice.between(-60.0, 60.0));
            let at = target - dir * dice.between(1.0, 9.0) - DVec3::X * radius;
            let shape =
                ShapeDesc::sphere(radius as f32).filter(ALONE).restitution(dice.between(0.0, 1.0) as f32);
            ids.push(w.add_body(BodyDesc::dynamic().at(at).velocity((dir * 250.0).as_vec3()).shape(shape))?);
        }
        run(&mut w, 0.5)?;
        for id in ids {
            behind += usize::from(w.body(id)?.position().x > 0.0);
        }
    }
    Ok(behind as f64)
}

fn shots() -> Rows {
    let n: usize = if prove() { 10_000 } else { 1_000 };
    let mut dice = Dice(1);
    let mut rows = Vec::new();
    let source = "none may pass";
    for (kind, what, count) in [
        (Wall::Box, "a box", n * 4 / 10),
        (Wall::Tiles, "boxes side by side", n * 3 / 10),
        (Wall::Mesh, "a mesh", n * 3 / 10),
    ] {
        let name = format!("of {count} balls at 250 m/s through 0.1 m of {what}");
        rows.push(Row::at_most(&name, 0.0, through(kind, count, &mut dice)?, "balls", source));
    }
    Ok(rows)
}

/// Coins 5 mm thick, thrown down in all attitudes onto a floor of triangles.
fn coins() -> Rows {
    let n = if prove() { 1_000 } else { 200 };
    let mut dice = Dice(2);
    let mut w = world(G, 60.0)?;
    // Wide enough that none rolls over the border.
    let cells = 80_u32;
    let mut corners = Vec::new();
    for i in 0..=cells {
        for j in 0..=cells {
            corners.push(Vec3::new(i as f32 - 40.0, 0.0, j as f32 - 40.0));
        }
    }
    let mut triangles = Vec::new();
    for i in 0..cells {
        for j in 0..cells {
            let a = i * (cells + 1) + j;
            let b = a + cells + 1;
            triangles.extend([[a, a + 1, b], [b, a + 1, b + 1]]);
        }
    }
    let mesh = TriMesh::new(&corners, &triangles, TriMeshOptions::default())?;
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::mesh(Arc::new(mesh)).filter(WALL)))?;
    let mut ids = Vec::new();
    for _ in 0..n {
        let at = [dice.between(-8.0, 8.0), dice.between(0.1, 1.0), dice.between(-8.0, 8.0)];
        let mut axis = || dice.between(-1.0, 1.0) as f32;
        let (x, y, z, s) = (axis(), axis(), axis(), axis());
        let q = Quat::new(x, y, z, s).normalize();
        let down = [0.0, -dice.between(0.0, 30.0) as f32, 0.0];
        let spin = [dice.between(-20.0, 20.0) as f32, 0.0, dice.between(-20.0, 20.0) as f32];
        let coin = ShapeDesc::cylinder(0.0025, 0.012).density(8000.0).filter(ALONE);
        ids.push(w.add_body(
            BodyDesc::dynamic().at(at).rotated(q).velocity(down).angular_velocity(spin).shape(coin),
        )?);
    }
    run(&mut w, 5.0)?;
    let mut fell = 0;
    for id in ids {
        fell += u32::from(w.body(id)?.position().y < 0.0);
    }
    let name = format!("of {n} coins of 5 mm through a mesh floor");
    Ok(vec![Row::at_most(&name, 0.0, f64::from(fell), "coins", "none may pass")])
}
