//! Nanoseconds per question about a shape in a liquid:
//! `cargo run --release -p jounce_geometry --example submerged_times`.

// The clock times the library from outside; nothing in it reads one.
#![allow(clippy::disallowed_methods)]

use jounce_geometry::{Compound, Hull, Shape};
use jounce_math::{DQuat, DVec3, Pose, Quat, Vec3};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

const PLANES: usize = 1024;

/// Planes that cut a shape of about the unit ball's size.
fn planes() -> Vec<(DVec3, f64)> {
    let mut seed = 0x5EED_u64;
    let mut unit = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f64 / (1u64 << 23) as f64 - 1.0
    };
    (0..PLANES)
        .map(|_| {
            let q = DQuat::new(unit(), unit(), unit(), unit()).normalize();
            (q.rotate(DVec3::Y), 0.3 * unit())
        })
        .collect()
}

/// Hull of points spread evenly over a ball.
fn ball_hull(n: usize) -> Option<Shape> {
    let at = |i: usize| {
        let y = 1.0 - 2.0 * (i as f32 + 0.5) / n as f32;
        let side = Vec3::new((1.0 - y * y).sqrt(), y, 0.0);
        Quat::from_axis_angle(Vec3::Y, 2.399_963 * i as f32).rotate(side) * 0.5
    };
    Some(Shape::Hull(Arc::new(Hull::new(&(0..n).map(at).collect::<Vec<_>>()).ok()?)))
}

fn best_of_five(mut f: impl FnMut(&(DVec3, f64)), planes: &[(DVec3, f64)]) -> f64 {
    let mut best = f64::MAX;
    for _ in 0..5 {
        let start = Instant::now();
        for _ in 0..20 {
            planes.iter().for_each(&mut f);
        }
        let ns = start.elapsed().as_secs_f64() * 1e9 / (20 * planes.len()) as f64;
        best = if ns < best { ns } else { best };
    }
    best
}

fn main() {
    let (half_height, radius) = (0.5, 0.4);
    let cylinder = Shape::Cylinder { half_height, radius };
    let children = (0..4).map(|i| (Pose::from_translation(Vec3::X * (i as f32 - 1.5)), cylinder.clone()));
    let compound = Compound::new(children.collect()).ok().map(|c| Shape::Compound(Arc::new(c)));
    let shapes = [
        ("sphere", Some(Shape::Sphere { radius: 0.5 })),
        ("capsule", Some(Shape::Capsule { half_height, radius })),
        ("box", Some(Shape::Box { half: Vec3::new(0.4, 0.5, 0.6) })),
        ("cylinder", Some(cylinder)),
        ("cone", Some(Shape::Cone { half_height, radius })),
        ("hull, 12 corners", ball_hull(12)),
        ("hull, 64 corners", ball_hull(64)),
        ("hull, 255 corners", ball_hull(255)),
        ("compound, 4 cylinders", compound),
    ];
    let planes = planes();
    println!("{:<24} {:>12} {:>12}", "ns", "submerged", "shadow_area");
    for (name, shape) in shapes {
        let Some(shape) = shape else { continue };
        let a = best_of_five(|(n, d)| _ = black_box(shape.submerged(*n, black_box(*d))), &planes);
        let b = best_of_five(|(n, _)| _ = black_box(shape.shadow_area(n.as_vec3())), &planes);
        println!("{name:<24} {a:>12.0} {b:>12.0}");
    }
}
