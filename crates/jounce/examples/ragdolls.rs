//! Many ragdolls dropped on a mesh: `cargo run --release -p jounce --example ragdolls [COUNT] [OBJ]`.
//!
//! The mesh is a Z-up OBJ in centimetres (the voxel terrain of Box3D); a height field where there is none. Prints time per step,
//! the worst gap of a joint, the worst excess over an end, and when all sleep.

use jounce::geometry::{HeightField, TriMesh, TriMeshOptions};
use jounce::math::scalar::f32s;
use jounce::prelude::*;
use jounce::{Ragdoll, RagdollDesc};
use std::sync::Arc;
use std::time::Instant;

/// Triangles of an OBJ file, turned Y up, in metres.
fn obj(text: &str) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let p: Vec<f32> = words.filter_map(|w| w.parse().ok()).collect();
                if let [x, y, z, ..] = p[..] {
                    points.push(Vec3::new(0.01 * x, 0.01 * z, -0.01 * y));
                }
            }
            Some("f") => {
                let index = |w: &str| w.split('/').next()?.parse::<u32>().ok()?.checked_sub(1);
                let f: Vec<u32> = words.filter_map(index).collect();
                triangles.extend((1..f.len().max(2) - 1).map(|i| [f[0], f[i], f[i + 1]]));
            }
            _ => {}
        }
    }
    (points, triangles)
}

/// The ground, and the middle and height of where to drop.
fn ground(path: &str) -> jounce::Result<(ShapeDesc, Vec3)> {
    if let Ok(text) = std::fs::read_to_string(path) {
        let (points, triangles) = obj(&text);
        let mesh = TriMesh::new(&points, &triangles, TriMeshOptions::default())?;
        let (b, n) = (mesh.aabb(), mesh.len());
        println!("{path}: {n} triangles, {:?} to {:?}", b.min, b.max);
        let top = Vec3::new(b.center().x, b.max.y, b.center().z);
        return Ok((ShapeDesc::mesh(Arc::new(mesh)), top));
    }
    println!("skipped: no {path}; a height field instead");
    let n = 65;
    let wave = |k: usize| 0.5 * f32s::sin(0.7 * (k % n) as f32) * f32s::cos(0.5 * (k / n) as f32);
    let field = HeightField::new(n, n, [0.5, 0.5], (0..n * n).map(wave).collect())?;
    Ok((ShapeDesc::new(Shape::HeightField(Arc::new(field))), Vec3::new(0.0, 0.5, 0.0)))
}

/// Worst gap, m, and worst excess over an end, degrees.
fn worst(world: &World, doll: &Ragdoll) -> jounce::Result<(f32, f32)> {
    let (mut gap, mut excess) = (0.0, 0.0);
    for &j in doll.joints.iter().flatten() {
        let r = world.joint(j)?;
        let q = r.frame_a().q.inverse_mul(r.frame_b().q);
        let s = if q.w < 0.0 { -1.0 } else { 1.0 };
        let twist = 2.0 * f32s::atan2(s * q.x, s * q.w);
        let over = |v: f32, lo: f32, hi: f32| f32s::max(lo - v, v - hi);
        let e = match r.kind() {
            JointKind::Ball(b) => {
                let t = b.twist.map_or(0.0, |t| over(twist, t.min, t.max));
                f32s::max(t, b.cone.map_or(0.0, |c| r.coordinate() - c))
            }
            JointKind::Hinge(x) => x.limit.map_or(0.0, |l| over(r.coordinate(), l.min, l.max)),
            _ => 0.0,
        };
        (gap, excess) = (f32s::max(gap, r.gap()), f32s::max(excess, e.to_degrees()));
    }
    Ok((gap, excess))
}

#[expect(clippy::disallowed_methods, reason = "an example measures; the core reads no clock")]
fn main() -> jounce::Result<()> {
    let mut args = std::env::args().skip(1);
    let count: usize = args.next().and_then(|a| a.parse().ok()).unwrap_or(300);
    let path = args.next().unwrap_or_else(|| "../shared/assets/box3d/voxel_mesh_01.obj".to_owned());
    let mut world = World::new(WorldDesc::default())?;
    let (shape, top) = ground(&path)?;
    world.add_body(BodyDesc::fixed().shape(shape))?;
    let side = (1..).find(|n| n * n >= count.div_ceil(4)).unwrap_or(1);
    let mut dolls = Vec::new();
    for i in 0..count {
        let (layer, k) = (i % 4, i / 4);
        let cell = Vec3::new((k % side) as f32, layer as f32, (k / side) as f32);
        let middle = Vec3::new(0.5 * side as f32, 0.0, 0.5 * side as f32);
        let at = top + (cell - middle) * 1.2 + Vec3::new(0.0, 0.5 + 0.9 * layer as f32, 0.0);
        let q = Quat::from_axis_angle(Vec3::new(0.36, 0.48, 0.8), 0.7 * i as f32);
        let group = -1 - i as i32;
        dolls.push(world.add_ragdoll(&RagdollDesc::human().at(at.as_dvec3()).rotated(q).group(group))?);
    }
    let (mut gap, mut excess, mut slowest, mut total) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    for step in 1..=1800 {
        let start = Instant::now();
        world.step()?;
        let ms = start.elapsed().as_secs_f64() * 1e3;
        total += ms;
        slowest = if ms > slowest { ms } else { slowest };
        for d in &dolls {
            let (g, e) = worst(&world, d)?;
            (gap, excess) = (f32s::max(gap, g), f32s::max(excess, e));
        }
        let awake = world.counts().awake;
        if step % 60 == 0 || awake == 0 {
            let mean = total / f64::from(step);
            let energy = world.energy().kinetic;
            println!(
                "{:4.1} s: {awake} awake, kinetic {energy:.1} J, gap {gap:.4} m, beyond ends {excess:.2}°, {mean:.2} ms a step (at most {slowest:.1})",
                f64::from(step) / 60.0
            );
        }
        if awake == 0 {
            break;
        }
    }
    Ok(())
}
