//! Smoke, fire, sparks, a cloth on springs, a trail: what a picture can show beside rigid shapes, and how long it takes.
//!
//! `cargo run --release -p jounce_render --example matter -- [PICTURE.png] [THREADS] [SMOKE BALLS] [WIDTH]`

use jounce::math::scalar::{f32s, f64s};
use jounce::math::{DVec3, Vec3};
use jounce::{BodyDesc, ShapeDesc, World, WorldDesc};
use jounce_render::{Ball, Camera, Extras, Overlay, RenderOptions, Rod, Stage, render_with};
use std::time::Instant;

/// Numbers that look random, the same every time (Weyl sequences of square roots).
struct Spread(u32);

impl Spread {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        (((word >> 22) ^ word) >> 8) as f32 / 16_777_216.0
    }
    /// About normal, with variance 1.
    fn bell(&mut self) -> f32 {
        (self.next() + self.next() + self.next() + self.next() - 2.0) * 1.73
    }
}

fn mix(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t)
}

/// A plume that rises from a fire, grows, thins out and leans in the wind.
fn smoke(extras: &mut Extras, count: u32) {
    let mut random = Spread(1);
    for _ in 0..count {
        let age = random.next();
        let wide = 0.22 + 1.0 * age;
        let turn = age * 7.0;
        let curl = [0.25 * age * f32s::sin(turn), 0.25 * age * f32s::cos(turn * 0.8)];
        let at = Vec3::new(
            -2.2 + 1.7 * age * age + curl[0] + 0.33 * wide * random.bell(),
            0.9 + 4.6 * age + 0.2 * random.bell(),
            curl[1] + 0.33 * wide * random.bell(),
        );
        // A few dark puffs among many light ones give the cloud its lumps.
        let shade = random.next();
        let grey =
            mix([0.42, 0.40, 0.39], [0.78, 0.77, 0.77], f32s::min(age * 1.3, 1.0) * (0.5 + 0.5 * shade));
        let fade = f32s::min(age * 8.0, 1.0) * (1.0 - age);
        let size = (0.08 + 0.30 * age) * (0.5 + 1.0 * random.next());
        let opacity = fade * 0.26 * f32s::min(5000.0 / count as f32, 1.0);
        extras.balls.push(Ball::new(at.as_dvec3(), size, grey).soft().opacity(opacity));
    }
}

/// Flames: yellow where young, red where old, smaller with age.
fn fire(extras: &mut Extras) {
    let mut random = Spread(2);
    for _ in 0..900 {
        let age = random.next();
        let out = 0.30 * (1.0 - 0.75 * age);
        let at = Vec3::new(
            -2.2 + out * random.bell() * 0.8 + 0.08 * age,
            0.12 + 1.25 * age * (0.75 + 0.5 * random.next()),
            out * random.bell() * 0.8,
        );
        let color = if age < 0.35 {
            mix([1.0, 0.72, 0.20], [1.0, 0.45, 0.05], age / 0.35)
        } else {
            mix([1.0, 0.45, 0.05], [0.70, 0.10, 0.02], (age - 0.35) / 0.65)
        };
        let size = (0.17 - 0.10 * age) * (0.7 + 0.6 * random.next());
        let opacity = 0.20 * (1.0 - age * age);
        extras.balls.push(Ball::new(at.as_dvec3(), size, color).soft().opacity(opacity).glow(0.7));
    }
    for _ in 0..60 {
        let (age, turn) = (random.next(), random.next() * std::f32::consts::TAU);
        let out = age * (0.3 + 0.5 * random.next());
        let at = Vec3::new(
            -2.2 + out * f32s::cos(turn),
            0.3 + (0.6 + 1.6 * random.next()) * age,
            out * f32s::sin(turn),
        );
        let spark = Ball::new(at.as_dvec3(), 0.008, [1.0, 0.75, 0.35]);
        extras.balls.push(spark.glow(1.0).opacity(1.0 - 0.6 * age));
    }
}

/// A cloth that hangs from a bar by springs.
fn cloth(extras: &mut Extras) {
    const N: usize = 25;
    let at = |i: usize, j: usize| {
        let (u, v) = (i as f64 / (N - 1) as f64, j as f64 / (N - 1) as f64);
        let wave = 0.20 * v * f64s::sin(u * 16.0 + v * 2.0) + 0.14 * v * f64s::sin(u * 7.0 - v * 6.0);
        DVec3::new(1.0 + 1.7 * u + 0.05 * v * f64s::sin(u * 6.0), 2.35 - 1.75 * v, wave - 0.3)
    };
    let points: Vec<DVec3> = (0..N * N).map(|k| at(k % N, k / N)).collect();
    let mut triangles = Vec::new();
    for j in 0..N - 1 {
        for i in 0..N - 1 {
            let k = (j * N + i) as u32;
            let n = N as u32;
            triangles.push([k, k + n, k + 1]);
            triangles.push([k + 1, k + n, k + n + 1]);
        }
    }
    extras.skin(&points, &triangles, [0.16, 0.42, 0.62]);
    let bar = [DVec3::new(0.8, 2.75, -0.3), DVec3::new(2.9, 2.75, -0.3)];
    extras.rods.push(Rod::new(bar[0], bar[1], 0.035, [0.35, 0.32, 0.30]));
    for i in (0..N).step_by(4) {
        let from = points[i];
        // A coil of eight turns.
        let coil = |s: f64| {
            let turn = s * 8.0 * std::f64::consts::TAU;
            let off = DVec3::new(f64s::cos(turn), 0.0, f64s::sin(turn)) * 0.035;
            from + DVec3::Y * ((2.75 - from.y) * s) + off
        };
        for k in 0..96 {
            let (a, b) = (coil(f64::from(k) / 96.0), coil(f64::from(k + 1) / 96.0));
            extras.rods.push(Rod::new(a, b, 0.007, [0.72, 0.73, 0.75]));
        }
    }
    // The web of springs below the cloth's lower hem, as balls and rods.
    for i in (0..N).step_by(4) {
        let hem = points[(N - 1) * N + i];
        let knot = hem - DVec3::new(0.0, 0.22, 0.0);
        extras.rods.push(Rod::new(hem, knot, 0.006, [0.8, 0.75, 0.6]));
        extras.balls.push(Ball::new(knot, 0.06, [0.85, 0.55, 0.18]));
    }
}

/// A bouncing ball's way, fading towards its tail; and a bubble.
fn trail(extras: &mut Extras) {
    let at = |k: i32| {
        let t = f64::from(k) / 60.0;
        let phase = (t * 1.25).fract();
        let y = 0.25 + 4.4 * phase * (1.0 - phase) * f64s::exp(-0.55 * (t * 1.25).floor());
        DVec3::new(-4.0 + 2.6 * t, y, 1.8)
    };
    for k in 0..150 {
        let fade = k as f32 / 150.0;
        extras.rods.push(Rod::new(at(k), at(k + 1), 0.03, [0.90, 0.28, 0.22]).opacity(fade * 0.9));
    }
    extras.balls.push(Ball::new(at(150), 0.25, [0.90, 0.28, 0.22]));
    extras.balls.push(Ball::new([0.1, 0.5, 1.2], 0.5, [0.55, 0.8, 0.95]).opacity(0.45));
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, default: u32| words.get(k).map_or(Ok(default), |w| w.parse::<u32>());
    let (threads, count, width) = (number(1, 0)?, number(2, 5000)?, number(3, 960)?);
    let mut world = World::new(WorldDesc::default())?;
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    for (x, half) in [(-2.55, 0.07), (-1.85, 0.07)] {
        world.add_body(BodyDesc::fixed().at([x, 0.07, 0.0]).shape(ShapeDesc::cuboid([0.45, half, 0.07])))?;
    }
    world.add_body(BodyDesc::dynamic().at([0.3, 0.35, 0.3]).shape(ShapeDesc::cuboid([0.35; 3])))?;
    let mut extras = Extras::default();
    smoke(&mut extras, count);
    fire(&mut extras);
    cloth(&mut extras);
    trail(&mut extras);
    let options = RenderOptions {
        width,
        height: width * 9 / 16,
        threads: threads as usize,
        light_samples: 1,
        ..RenderOptions::default()
    };
    let camera = Camera::new([0.6, 2.3, 9.2], [0.0, 2.05, 0.0]);
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        let image = render_with(&Stage::new(&world), &camera, &extras, &Overlay::default(), &options)?;
        best = best.min(start.elapsed().as_secs_f64());
        if let Some(path) = words.first() {
            image.write_png(path.as_ref())?;
        }
    }
    let (balls, rods, faces) = (extras.balls.len(), extras.rods.len(), extras.faces.len());
    println!("{width} pixels wide, {balls} balls, {rods} rods, {faces} faces: {best:.3} s, the fastest of 3");
    Ok(())
}
