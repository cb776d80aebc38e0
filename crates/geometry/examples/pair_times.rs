//! Nanoseconds per contact test: `cargo run --release -p jounce_geometry --example pair_times`.

// The clock times the library from outside; nothing in it reads one.
#![allow(clippy::disallowed_methods)]

use jounce_geometry::{HeightField, Hull, ManifoldSet, PairCache, Shape, TriMesh, TriMeshOptions, collide};
use jounce_math::{Pose, Quat, Vec3};
use std::sync::Arc;
use std::time::Instant;

const POSES: usize = 512;
const ROUNDS: usize = 400;
const MARGIN: f32 = 0.02;

/// Poses that jitter around `at` as a resting body does.
fn poses(at: Vec3, turn: f32, spread: f32) -> Vec<Pose> {
    let mut seed = 0x5EED_u64;
    let mut unit = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    };
    (0..POSES)
        .map(|_| {
            let d = Vec3::new(unit(), unit() * 0.01, unit()) * spread;
            let q = Quat::from_axis_angle(Vec3::Y, turn * unit())
                .integrate(Vec3::new(unit(), 0.0, unit()) * 1e-3);
            Pose::new(at + d, q)
        })
        .collect()
}

fn time(name: &str, a: &Shape, b: &Shape, poses: &[Pose]) {
    let mut out = ManifoldSet::new();
    let mut caches = vec![PairCache::default(); poses.len()];
    let mut best = f64::MAX;
    let mut points = 0;
    for _ in 0..5 {
        let start = Instant::now();
        for _ in 0..ROUNDS / 5 {
            points = 0;
            for (pose, cache) in poses.iter().zip(&mut caches) {
                collide(a, b, pose, MARGIN, cache, &mut out);
                points += out.manifolds.iter().map(|m| usize::from(m.count)).sum::<usize>();
            }
        }
        let ns = start.elapsed().as_secs_f64() * 1e9 / (ROUNDS / 5 * poses.len()) as f64;
        best = if ns < best { ns } else { best };
    }
    println!("{name:<34} {best:>8.0} ns  {:.2} points", points as f64 / poses.len() as f64);
}

/// A flat square of `n` × `n` cells with sides of `cell` metres.
fn grid(n: u32, cell: f32) -> Shape {
    let half = n as f32 * cell * 0.5;
    let at = |i: u32, j: u32| Vec3::new(i as f32 * cell - half, 0.0, j as f32 * cell - half);
    let vertices: Vec<Vec3> = (0..=n).flat_map(|j| (0..=n).map(move |i| at(i, j))).collect();
    let v = |i: u32, j: u32| j * (n + 1) + i;
    let triangles: Vec<[u32; 3]> = (0..n)
        .flat_map(|j| (0..n).map(move |i| (i, j)))
        .flat_map(|(i, j)| [[v(i, j), v(i, j + 1), v(i + 1, j + 1)], [v(i, j), v(i + 1, j + 1), v(i + 1, j)]])
        .collect();
    let mesh = TriMesh::new(&vertices, &triangles, TriMeshOptions::default()).expect("a good grid");
    Shape::Mesh(Arc::new(mesh))
}

/// Hull of points spread evenly over a ball.
fn ball_hull(n: usize) -> Option<Shape> {
    let points: Vec<Vec3> = (0..n)
        .map(|i| {
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / n as f32;
            Quat::from_axis_angle(Vec3::Y, 2.399_963 * i as f32).rotate(Vec3::new(
                (1.0 - y * y).sqrt(),
                y,
                0.0,
            )) * 0.5
        })
        .collect();
    Some(Shape::Hull(Arc::new(Hull::new(&points).ok()?)))
}

fn main() {
    let cube = Shape::Box { half: Vec3::splat(0.5) };
    let sphere = Shape::Sphere { radius: 0.5 };
    let capsule = Shape::Capsule { half_height: 0.3, radius: 0.2 };
    let cylinder = Shape::Cylinder { half_height: 0.5, radius: 0.4 };
    let up = |y: f32| Vec3::new(0.0, y, 0.0);
    time("sphere sphere", &sphere, &sphere, &poses(up(0.99), 1.0, 0.1));
    time("box sphere", &cube, &sphere, &poses(up(0.99), 1.0, 0.2));
    time("box capsule", &cube, &capsule, &poses(up(0.99), 1.0, 0.2));
    time("box box, stacked", &cube, &cube, &poses(up(0.997), 0.002, 0.002));
    time("box box, stacked and shifted", &cube, &cube, &poses(up(0.997), 0.002, 0.4));
    time("box box, stacked and turned", &cube, &cube, &poses(up(0.997), 0.8, 0.2));
    time("box box, bricks", &cube, &cube, &poses(Vec3::new(0.5, 0.997, 0.0), 0.002, 0.002));
    time("box box, apart", &cube, &cube, &poses(up(1.1), 0.8, 0.1));
    let edge: Vec<Pose> = poses(Vec3::new(0.0, 1.4, 0.0), 0.01, 0.02)
        .iter()
        .map(|p| {
            let tilt = Quat::from_axis_angle(Vec3::X, std::f32::consts::FRAC_PI_4);
            Pose::new(p.p, p.q * tilt)
        })
        .collect();
    let leaning = Pose::new(Vec3::ZERO, Quat::from_axis_angle(Vec3::Z, std::f32::consts::FRAC_PI_4));
    let edge: Vec<Pose> = edge.iter().map(|p| leaning.relative(p)).collect();
    time("box box, crossing edges", &cube, &cube, &edge);
    time("box cylinder, standing", &cube, &cylinder, &poses(up(0.997), 1.0, 0.1));
    time("cylinder cylinder, standing", &cylinder, &cylinder, &poses(up(0.997), 1.0, 0.1));
    let plane = Shape::HalfSpace { normal: Vec3::Y, offset: 0.0 };
    time("half-space box", &plane, &cube, &poses(up(0.497), 1.0, 1.0));
    if let (Some(h8), Some(h32)) = (ball_hull(12), ball_hull(32)) {
        time("hull hull, 12 corners", &h8, &h8, &poses(up(0.85), 1.0, 0.1));
        time("hull hull, 32 corners", &h32, &h32, &poses(up(0.9), 1.0, 0.1));
        time("hull hull, 32 corners, apart", &h32, &h32, &poses(up(1.2), 1.0, 0.1));
        time("box hull, 32 corners", &cube, &h32, &poses(up(0.95), 1.0, 0.1));
    }
    for cell in [0.25, 1.0, 4.0] {
        let ground = grid(32, cell);
        time(&format!("mesh ({cell} m) box"), &ground, &cube, &poses(up(0.497), 1.0, 2.0));
        time(&format!("mesh ({cell} m) sphere"), &ground, &sphere, &poses(up(0.497), 1.0, 2.0));
        time(&format!("mesh ({cell} m) capsule"), &ground, &capsule, &poses(up(0.497), 1.0, 2.0));
    }
    let field = HeightField::new(33, 33, [1.0; 2], vec![0.0; 33 * 33]).expect("a good field");
    let field = Shape::HeightField(Arc::new(field));
    time("height field (1 m) box", &field, &cube, &poses(up(0.497), 1.0, 2.0));
}
