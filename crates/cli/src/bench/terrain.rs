//! Scenes on meshes: ragdolls in the rain, tumbling trees, shapes on waves.

use super::scenes::{Before, Built, at, hull, nothing, world};
use crate::error::Failure;
use jounce::geometry::{TriMesh, TriMeshOptions};
use jounce::math::scalar::f32s::{cos, sin};
use jounce::math::{DVec3, Vec3};
use jounce::{BodyDesc, Ragdoll, RagdollDesc, ShapeDesc, World};
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

fn mesh(points: &[Vec3], triangles: &[[u32; 3]]) -> Result<ShapeDesc, Failure> {
    let mesh = TriMesh::new(points, triangles, TriMeshOptions::default());
    Ok(ShapeDesc::mesh(Arc::new(mesh.map_err(|e| Failure::bad(e.to_string()))?)))
}

/// nx × nz quads from vertices in x-major order, two triangles each.
fn quads(nx: u32, nz: u32) -> Vec<[u32; 3]> {
    let v = |x: u32, z: u32| x * (nz + 1) + z;
    let cell = |x, z| {
        let (v00, v01, v10, v11) = (v(x, z), v(x, z + 1), v(x + 1, z), v(x + 1, z + 1));
        [[v00, v01, v11], [v11, v10, v00]]
    };
    (0..nx).flat_map(|x| (0..nz).flat_map(move |z| cell(x, z))).collect()
}

/// A flat grid of 8 × 8 quads of 1.875 m, centred.
fn grid() -> Result<ShapeDesc, Failure> {
    const CELL: f32 = 1.875;
    let point = |x: u32, z: u32| Vec3::new((x as f32 - 4.0) * CELL, 0.0, (z as f32 - 4.0) * CELL);
    let points: Vec<Vec3> = (0..=8).flat_map(|x| (0..=8).map(move |z| point(x, z))).collect();
    mesh(&points, &quads(8, 8))
}

/// A torus that stands upright: 16 × 16, ring 3.75 m, tube 1 m, axis z.
fn torus() -> Result<ShapeDesc, Failure> {
    const N: u32 = 16;
    let point = |i: u32, j: u32| {
        let (u, v) = (TAU * i as f32 / N as f32, TAU * j as f32 / N as f32);
        let ring = 3.75 + cos(v);
        Vec3::new(ring * cos(u), ring * sin(u), sin(v))
    };
    let points: Vec<Vec3> = (0..N).flat_map(|i| (0..N).map(move |j| point(i, j))).collect();
    let at = |i: u32, j: u32| (i % N) * N + j % N;
    let cell = |i, j| {
        let (v00, v10, v11, v01) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        [[v00, v10, v11], [v11, v01, v00]]
    };
    let triangles: Vec<[u32; 3]> = (0..N).flat_map(|i| (0..N).flat_map(move |j| cell(i, j))).collect();
    mesh(&points, &triangles)
}

const CELLS: usize = 10;
const SPAN: f32 = 15.0;

/// Ragdolls fall on a field of tori, column by column; the first columns come again.
pub(super) fn rain() -> Built {
    let mut world = world(-10.0, true)?;
    let (grid, torus) = (grid()?, torus()?);
    for i in 0..CELLS {
        for j in 0..CELLS {
            let [x, z] = [i, j].map(|n| -67.5 + SPAN * n as f32);
            let cell = BodyDesc::fixed().at(at(x, 0.0, z));
            world.add_body(cell.shape(grid.clone()).shape(torus.clone()))?;
        }
    }
    let mut columns: Vec<Vec<Ragdoll>> = vec![Vec::new(); CELLS];
    let mut next = 0;
    let before = move |world: &mut World, k: usize| {
        if k & 0x2F != 0 {
            return Ok(());
        }
        let column = next % CELLS;
        next += 1;
        for doll in columns[column].drain(..) {
            world.remove_ragdoll(&doll)?;
        }
        for row in 0..CELLS {
            for m in 0..3 {
                let x = -75.0 + SPAN * (column as f32 + 0.5) + 0.75 * m as f32;
                let z = -75.0 + SPAN * (row as f32 + 0.5);
                let group = -1 - (column * CELLS + row) as i32;
                let mut human = RagdollDesc::human().at(at(x, 20.0, z)).group(group);
                // As the bones are given: the other engines close no gaps.
                human.close_gaps = false;
                columns[column].push(world.add_ragdoll(&human)?);
            }
        }
        Ok(())
    };
    Ok((world, Box::new(before) as Before))
}

/// The hull of a six-sided cylinder along y.
fn log(base: f32, height: f32, radius: f32) -> Result<ShapeDesc, Failure> {
    let corner = |k: usize, y: f32| {
        let a = TAU * k as f32 / 6.0;
        Vec3::new(radius * cos(a), y, radius * sin(a))
    };
    let points: Vec<Vec3> = (0..6).flat_map(|k| [corner(k, base), corner(k, base + height)]).collect();
    hull(&points)
}

/// Fifty trees of 22 logs each fall over on waves; `scale` cells to a metre.
fn trees(scale: u32) -> Built {
    let mut world = world(-10.0, true)?;
    let (nx, nz, cell) = (150 * scale, 200 * scale, 1.0 / scale as f32);
    let height = |ix: u32, iz: u32| {
        0.4 * sin(2.0 * PI * 0.1 * cell * ix as f32) * sin(2.0 * PI * 0.05 * cell * iz as f32)
    };
    let point = |ix: u32, iz: u32| {
        let [x, z] = [(ix, nx), (iz, nz)].map(|(i, n)| (i as f32 - 0.5 * n as f32) * cell);
        Vec3::new(x, height(ix, iz), z)
    };
    let points: Vec<Vec3> = (0..=nx).flat_map(|x| (0..=nz).map(move |z| point(x, z))).collect();
    world.add_body(BodyDesc::fixed().shape(mesh(&points, &quads(nx, nz))?.friction(0.9)))?;
    for k in 0..50 {
        let mut tree = BodyDesc::dynamic().at(at(0.0, 1.0, -70.0 + 3.0 * k as f32));
        let (mut y0, mut r, l) = (1.0, 0.75, 1.5);
        for _ in 0..22 {
            let mut log = log(y0 - r, l + 2.0 * r, r)?.density(1.0).friction(0.9);
            // A rolling resistance of 0.05, times the radius of the ball inside, as Box3D has it on meshes.
            log.material.rolling_friction = 0.05 * r * cos(PI / 6.0);
            tree = tree.shape(log);
            y0 += l + 2.0 * r;
            r *= 0.95;
        }
        tree.sleep_speed = Some(0.2);
        let body = world.add_body(tree)?;
        let sign = if k % 2 == 0 { -1.0 } else { 1.0 };
        let w = Vec3::new(0.0, 0.0, sign * 0.5 * (0.5 + 0.5 * k as f32 / 50.0));
        let b = world.body(body)?;
        let arm: DVec3 = b.center_of_mass() - b.position();
        world.set_angular_velocity(body, w)?;
        world.set_velocity(body, w.cross(arm.as_vec3()))?;
    }
    Ok((world, nothing()))
}

pub(super) fn trees100() -> Built {
    trees(1)
}
pub(super) fn trees50() -> Built {
    trees(2)
}
pub(super) fn trees25() -> Built {
    trees(4)
}

/// Boxes, balls, capsules and hulls on a mesh of steep waves.
pub(super) fn convex_vs_mesh() -> Built {
    const N: u32 = 100;
    let mut world = world(-9.81, true)?;
    let point = |x: u32, z: u32| {
        let y = 5.0 * sin(0.5 * x as f32) * cos(0.5 * z as f32);
        Vec3::new(3.0 * x as f32, y, 3.0 * z as f32)
    };
    let points: Vec<Vec3> = (0..=N).flat_map(|z| (0..=N).map(move |x| point(x, z))).collect();
    let cell = |x: u32, z: u32| {
        let s = x + z * (N + 1);
        [[s, s + N + 1, s + 1], [s + 1, s + N + 1, s + N + 2]]
    };
    let triangles: Vec<[u32; 3]> = (0..N).flat_map(|z| (0..N).flat_map(move |x| cell(x, z))).collect();
    let ground = mesh(&points, &triangles)?.friction(0.5).restitution(0.6);
    world.add_body(BodyDesc::fixed().at([-150.0, 5.0, -150.0]).shape(ground))?;
    let (x, z) = (Vec3::X, Vec3::Z);
    let shapes = [
        ShapeDesc::cuboid([0.5, 0.75, 1.0]),
        ShapeDesc::sphere(0.5),
        ShapeDesc::capsule(0.75, 0.5),
        hull(&[Vec3::Y, x, x * -1.0, z, z * -1.0])?,
    ];
    for i in -10..=10 {
        for j in -10..=10 {
            for (k, shape) in shapes.iter().enumerate() {
                let place = at(7.5 * i as f32, 15.0 + 2.0 * k as f32, 7.5 * j as f32);
                let shape = shape.clone().friction(0.5).restitution(0.6);
                world.add_body(BodyDesc::dynamic().at(place).shape(shape))?;
            }
        }
    }
    Ok((world, nothing()))
}
