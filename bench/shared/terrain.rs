//! Scenes on meshes: ragdolls in the rain, tumbling trees, shapes on waves.

use super::human;
use super::parts::Kind::{Dynamic, Fixed};
use super::parts::{BodyOptions, Shape, ShapeOptions, V};
use super::scenes::{Before, nothing};
use crate::world::{Body, Hull, Mesh, World};
use std::f32::consts::PI;

/// Two triangles for each of nx × nz quads, from vertices in x-major order.
fn quads(nx: u32, nz: u32) -> Vec<[u32; 3]> {
    let v = |x: u32, z: u32| x * (nz + 1) + z;
    let cell = |x, z| {
        let (v00, v01, v10, v11) = (v(x, z), v(x, z + 1), v(x + 1, z), v(x + 1, z + 1));
        [[v00, v01, v11], [v11, v10, v00]]
    };
    (0..nx).flat_map(|x| (0..nz).flat_map(move |z| cell(x, z))).collect()
}

/// A flat grid of 8 × 8 quads of 1.875 m, centred.
fn grid() -> Result<Mesh, String> {
    const CELL: f32 = 1.875;
    let point = |x: u32, z: u32| [(x as f32 - 4.0) * CELL, 0.0, (z as f32 - 4.0) * CELL];
    let points: Vec<V> = (0..=8).flat_map(|x| (0..=8).map(move |z| point(x, z))).collect();
    Mesh::new(&points, &quads(8, 8))
}

/// A torus that stands upright: 16 × 16, ring 3.75 m, tube 1 m, axis z.
fn torus() -> Result<Mesh, String> {
    const N: u32 = 16;
    let angle = |i: u32| 2.0 * PI * i as f32 / N as f32;
    let point = |v: u32, u: u32| {
        let ring = 3.75 + angle(v).cos();
        [ring * angle(u).cos(), ring * angle(u).sin(), angle(v).sin()]
    };
    let points: Vec<V> = (0..N).flat_map(|v| (0..N).map(move |u| point(v, u))).collect();
    let at = |v: u32, u: u32| (v % N) * N + u % N;
    let cell = |v, u| {
        let (v00, v01, v11, v10) = (at(v, u), at(v, u + 1), at(v + 1, u + 1), at(v + 1, u));
        [[v00, v01, v11], [v11, v10, v00]]
    };
    let triangles: Vec<_> = (0..N).flat_map(|v| (0..N).flat_map(move |u| cell(v, u))).collect();
    Mesh::new(&points, &triangles)
}

/// Ragdolls fall on a field of tori, column by column; the first columns come again.
pub fn rain(world: &mut World) -> Result<Before, String> {
    const CELLS: usize = 10;
    const SPAN: f32 = 15.0;
    let (grid, torus) = (grid()?, torus()?);
    for i in 0..CELLS {
        for j in 0..CELLS {
            let [x, z] = [i, j].map(|n| -67.5 + SPAN * n as f32);
            let cell = world.body(&BodyOptions::new(Fixed, x, 0.0, z));
            world.mesh(cell, &grid, ShapeOptions::default());
            world.mesh(cell, &torus, ShapeOptions::default());
        }
    }
    let mut columns: Vec<Vec<[Body; 14]>> = vec![Vec::new(); CELLS];
    let mut next = 0;
    Ok(Box::new(move |world, k| {
        if k & 0x2F != 0 {
            return;
        }
        let column = next % CELLS;
        next += 1;
        for body in columns[column].drain(..).flatten() {
            world.remove(body);
        }
        for row in 0..CELLS {
            for m in 0..3 {
                let x = -75.0 + SPAN * (column as f32 + 0.5) + 0.75 * m as f32;
                let z = -75.0 + SPAN * (row as f32 + 0.5);
                let group = (column * CELLS + row) as u32;
                columns[column].push(human::spawn(world, [x, 20.0, z], group));
            }
        }
    }))
}

pub fn trees100(world: &mut World) -> Result<Before, String> {
    trees(world, 1)
}

pub fn trees50(world: &mut World) -> Result<Before, String> {
    trees(world, 2)
}

pub fn trees25(world: &mut World) -> Result<Before, String> {
    trees(world, 4)
}

/// Fifty trees of 22 logs each fall over on waves; `scale` cells to a metre.
fn trees(world: &mut World, scale: u32) -> Result<Before, String> {
    let (nx, nz, cell) = (150 * scale, 200 * scale, 1.0 / scale as f32);
    let wave = |i: u32, rate: f32| (2.0 * PI * rate * cell * i as f32).sin();
    let at = |i: u32, n: u32| (i as f32 - 0.5 * n as f32) * cell;
    let point = |i, j| [at(i, nx), 0.4 * wave(i, 0.1) * wave(j, 0.05), at(j, nz)];
    let points: Vec<_> = (0..=nx).flat_map(|i| (0..=nz).map(move |j| point(i, j))).collect();
    let ground = world.body(&BodyOptions::new(Fixed, 0.0, 0.0, 0.0));
    let options = ShapeOptions { friction: 0.9, rolling: 0.05, density: 1.0, ..Default::default() };
    world.mesh(ground, &Mesh::new(&points, &quads(nx, nz))?, options);
    for k in 0..50 {
        let mut def = BodyOptions::new(Dynamic, 0.0, 1.0, -70.0 + 3.0 * k as f32);
        def.sleep_speed = 0.2;
        let tree = world.body(&def);
        let (mut base, mut radius, length) = (1.0f32, 0.75f32, 1.5f32);
        for _ in 0..22 {
            let corner = |i: usize, y: f32| {
                let angle = 2.0 * PI * i as f32 / 6.0;
                [radius * angle.cos(), y, radius * angle.sin()]
            };
            let (low, high) = (base - radius, base + length + radius);
            let corners: Vec<_> = (0..6).flat_map(|i| [corner(i, low), corner(i, high)]).collect();
            world.shape(tree, &Shape::Hull(&Hull::new(&corners)?), options);
            base += length + 2.0 * radius;
            radius *= 0.95;
        }
        let sign = if k % 2 == 0 { -0.5 } else { 0.5 };
        let spin = sign * (0.5 + 0.5 * k as f32 / 50.0);
        // ω × c, for ω along z.
        let c = world.local_center(tree);
        world.set_velocity(tree, [-spin * c[1], spin * c[0], 0.0], [0.0, 0.0, spin]);
    }
    Ok(nothing())
}

/// Boxes, balls, capsules and hulls on a mesh of steep waves.
pub fn convex_vs_mesh(world: &mut World) -> Result<Before, String> {
    const SIDE: u32 = 100;
    let point = |x: u32, z: u32| {
        let y = 5.0 * (0.5 * x as f32).sin() * (0.5 * z as f32).cos();
        [3.0 * x as f32, y, 3.0 * z as f32]
    };
    let points: Vec<_> = (0..=SIDE).flat_map(|z| (0..=SIDE).map(move |x| point(x, z))).collect();
    let cell = |x: u32, z: u32| {
        let s = x + z * (SIDE + 1);
        [[s, s + SIDE + 1, s + 1], [s + 1, s + SIDE + 1, s + SIDE + 2]]
    };
    let triangles: Vec<_> = (0..SIDE).flat_map(|z| (0..SIDE).flat_map(move |x| cell(x, z))).collect();
    let options = ShapeOptions { friction: 0.5, restitution: 0.6, ..Default::default() };
    let ground = world.body(&BodyOptions::new(Fixed, -150.0, 5.0, -150.0));
    world.mesh(ground, &Mesh::new(&points, &triangles)?, options);
    let tips = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let hull = Hull::new(&tips)?;
    let shapes = [
        Shape::block(0.5, 0.75, 1.0),
        Shape::Sphere { radius: 0.5 },
        Shape::Capsule { a: [0.0, -0.75, 0.0], b: [0.0, 0.75, 0.0], radius: 0.5 },
        Shape::Hull(&hull),
    ];
    for i in -10..=10 {
        for j in -10..=10 {
            for (k, shape) in shapes.iter().enumerate() {
                let (x, y, z) = (7.5 * i as f32, 15.0 + 2.0 * k as f32, 7.5 * j as f32);
                let body = world.body(&BodyOptions::new(Dynamic, x, y, z));
                world.shape(body, shape, options);
            }
        }
    }
    Ok(nothing())
}
