//! The scenes: the same bodies in the same order as every other engine of the comparison builds them.
//!
//! "Half" means half extents; lengths are metres, densities kg/m³; y is up.

use super::parts::Kind::{Dynamic, Fixed, Kinematic};
use super::parts::{BodyOptions, Capacity, DT_S, Meets, Shape, ShapeOptions};
use super::terrain;
use crate::world::{Hull, World};
use serde_json::{Value, json};
use std::f32::consts::PI;

/// What a scene does before step `k`.
pub type Before = Box<dyn FnMut(&mut World, usize)>;
/// Makes the bodies, and hands back what happens before each step.
pub type Build = fn(&mut World) -> Result<Before, String>;
/// Reads, after the last step, the figures that say how well the engine held the scene.
pub type Quality = fn(&World) -> Value;

/// A named scene of the comparison.
pub struct Scene {
    pub name: &'static str,
    pub steps: usize,
    /// m/s² along y.
    pub gravity_y: f32,
    pub capacity: Capacity,
    pub build: Build,
    pub quality: Quality,
}

/// Every scene this program knows, in the order `all` runs them.
pub const SCENES: &[Scene] = &[
    Scene { build: large_pyramid, quality: top_quality, ..scene("large_pyramid", 200) },
    Scene { build: many_pyramids, quality: many_quality, ..scene("many_pyramids", 100) },
    Scene { build: joint_grid, ..scene("joint_grid", 100) },
    Scene { build: terrain::rain, ..scene("rain", 400) },
    Scene { build: junkyard, capacity: room(16, 24 * 21 * 21 + 1, 250 * 1024), ..scene("junkyard", 500) },
    Scene { build: washer, capacity: room(16, 10_000, 60_000), ..scene("washer", 1000) },
    Scene { build: convex_pile, capacity: room(0, 5120, 50 * 1024), ..scene("convex_pile", 500) },
    Scene { build: large_world, capacity: room(1_000_000, 100, 1024), ..scene("large_world", 500) },
    Scene { build: terrain::trees100, ..scene("trees100", 500) },
    Scene { build: terrain::trees50, ..scene("trees50", 500) },
    Scene { build: terrain::trees25, ..scene("trees25", 500) },
    Scene { build: terrain::convex_vs_mesh, gravity_y: -9.81, ..scene("convex_vs_mesh", 500) },
    Scene { build: jolt_pyramid, gravity_y: -9.81, ..scene("jolt_pyramid", 500) },
    Scene { build: heavy_on_light, quality: sink_quality, gravity_y: -9.81, ..scene("heavy_on_light", 600) },
];

const fn scene(name: &'static str, steps: usize) -> Scene {
    Scene {
        name,
        steps,
        gravity_y: -10.0,
        capacity: room(0, 0, 0),
        build: large_pyramid,
        quality: pile_quality,
    }
}

const fn room(fixed: u32, moving: u32, contacts: u32) -> Capacity {
    Capacity { fixed, moving, contacts }
}

pub fn nothing() -> Before {
    Box::new(|_, _| {})
}

/// A static box whose top face is the plane y = 0.
fn ground(world: &mut World, half_x: f32, half_z: f32, options: ShapeOptions) {
    let body = world.body(&BodyOptions::new(Fixed, 0.0, -1.0, 0.0));
    world.shape(body, &Shape::block(half_x, 1.0, half_z), options);
}

fn large_pyramid(world: &mut World) -> Result<Before, String> {
    const ROWS: usize = 100;
    world.disable_sleep();
    ground(world, 400.0, 400.0, ShapeOptions::default());
    let options = ShapeOptions { density: 100.0, ..Default::default() };
    for i in 0..ROWS {
        let y = (2.0 * i as f32 + 1.0) * 0.5;
        for j in i..ROWS {
            let x = (i as f32 + 1.0) * 0.5 + (j - i) as f32 - 50.0;
            let body = world.body(&BodyOptions::new(Dynamic, x, y, 0.0));
            world.shape(body, &Shape::block(0.5, 0.5, 0.5), options);
        }
    }
    Ok(nothing())
}

const SMALL_ROWS: usize = 10;

fn many_pyramids(world: &mut World) -> Result<Before, String> {
    const SIDE: usize = 14;
    ground(world, 77.0, 77.0, ShapeOptions::default());
    let options = ShapeOptions { density: 100.0, ..Default::default() };
    for row in 0..SIDE {
        let z = -76.0 + row as f32 * (2.0 * 76.0 / 13.0);
        for column in 0..SIDE {
            let centre_x = -76.0 + 11.0 * column as f32;
            for i in 0..SMALL_ROWS {
                let y = (2.0 * i as f32 + 1.0) * 0.5;
                for j in i..SMALL_ROWS {
                    let x = (i as f32 + 1.0) * 0.5 + (j - i) as f32 + centre_x - 0.5;
                    let mut def = BodyOptions::new(Dynamic, x, y, z);
                    def.can_sleep = false;
                    let body = world.body(&def);
                    world.shape(body, &Shape::block(0.5, 0.5, 0.5), options);
                }
            }
        }
    }
    Ok(nothing())
}

/// A net of spheres that hangs from its upper edge and never collides.
fn joint_grid(world: &mut World) -> Result<Before, String> {
    const SIDE: usize = 100;
    world.disable_sleep();
    let options = ShapeOptions { meets: Meets::NotGhosts, ..Default::default() };
    let mut bodies = Vec::with_capacity(SIDE * SIDE);
    for k in 0..SIDE {
        for i in 0..SIDE {
            let kind = if i == 0 { Fixed } else { Dynamic };
            let body = world.body(&BodyOptions::new(kind, k as f32, -(i as f32), 0.0));
            world.shape(body, &Shape::Sphere { radius: 0.4 }, options);
            if i > 0 {
                let above = bodies[bodies.len() - 1];
                world.ball_joint((above, [0.0, -0.5, 0.0]), (body, [0.0, 0.5, 0.0]));
            }
            if k > 0 {
                let before = bodies[bodies.len() - SIDE];
                world.ball_joint((before, [0.5, 0.0, 0.0]), (body, [-0.5, 0.0, 0.0]));
            }
            bodies.push(body);
        }
    }
    Ok(nothing())
}

fn junkyard(world: &mut World) -> Result<Before, String> {
    let yard = world.body(&BodyOptions::new(Fixed, 0.0, -1.0, 0.0));
    let options = ShapeOptions::default();
    world.shape(yard, &Shape::block(120.0, 1.0, 120.0), options);
    for x in [-50.0, 50.0] {
        world.shape(yard, &Shape::Box { half: [1.0, 8.0, 50.0], centre: [x, 8.0, 0.0] }, options);
    }
    for z in [-50.0, 50.0] {
        world.shape(yard, &Shape::Box { half: [50.0, 8.0, 1.0], centre: [0.0, 8.0, z] }, options);
    }
    let rock = rock(1.5)?;
    for layer in 0..24 {
        for x in 0..21 {
            for z in 0..21 {
                let (x, z) = (-40.0 + 4.0 * x as f32, -40.0 + 4.0 * z as f32);
                let body = world.body(&BodyOptions::new(Dynamic, x, 4.0 * layer as f32 + 25.0, z));
                world.shape(body, &Shape::Hull(&rock), options);
            }
        }
    }
    let pusher = world.body(&BodyOptions::new(Kinematic, 35.0, 0.0, 0.0));
    let corners = (0..16).map(|k| 2.0 * PI * k as f32 / 16.0).map(|a| (4.0 * a.cos(), 4.0 * a.sin()));
    let points: Vec<_> = corners.flat_map(|(x, z)| [[x, 0.0, z], [x, 24.0, z]]).collect();
    world.shape(pusher, &Shape::Hull(&Hull::new(&points)?), options);
    let mut degrees = 0.0f32;
    Ok(Box::new(move |world, _| {
        degrees -= 6.0 * DT_S;
        let (sin, cos) = degrees.to_radians().sin_cos();
        world.move_to(pusher, 35.0 * cos, 0.0, 35.0 * sin);
    }))
}

/// Ten points of a Fibonacci lattice on a sphere.
fn rock(radius: f32) -> Result<Hull, String> {
    const COUNT: usize = 10;
    let golden = (1.0 + 5.0f32.sqrt()) / 2.0;
    let theta = 2.0 * PI / golden;
    let point = |i: usize| {
        let z = 1.0 - (2.0 * i as f32 + 1.0) / COUNT as f32;
        let ring = (1.0 - z * z).sqrt();
        let (sin, cos) = (i as f32 * theta).sin_cos();
        [radius * ring * cos, radius * ring * sin, radius * z]
    };
    Hull::new(&(0..COUNT).map(point).collect::<Vec<_>>())
}

/// `(x, y)` turned about z by an angle in degrees.
fn turned((x, y): (f32, f32), degrees: f32) -> (f32, f32) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    (cos * x - sin * y, sin * x + cos * y)
}

/// The hull between two radii along two directions, 20 m long in z.
fn slab(radii: [f32; 2], directions: [(f32, f32); 2]) -> Result<Hull, String> {
    let mut points = Vec::with_capacity(8);
    for z in [-10.0, 10.0] {
        for (x, y) in directions {
            points.extend(radii.map(|r| [r * x, r * y, z]));
        }
    }
    Hull::new(&points)
}

fn washer(world: &mut World) -> Result<Before, String> {
    const SIDE: usize = 20;
    let options = ShapeOptions::default();
    ground(world, 60.0, 60.0, options);
    let mut def = BodyOptions::new(Kinematic, 0.0, 21.0, 0.0);
    def.spin = [0.0, 0.0, 25.0f32.to_radians()];
    def.velocity = [0.001, -0.002, 0.0];
    let drum = world.body(&def);
    let mut u1 = (1.0, 0.0);
    for i in 0..36 {
        let u2 = if i == 35 { (1.0, 0.0) } else { turned(u1, 10.0) };
        let wall = slab([16.0, 18.0], [turned(u1, -1.0), turned(u2, 1.0)])?;
        world.shape(drum, &Shape::Hull(&wall), options);
        if i % 9 == 0 {
            world.shape(drum, &Shape::Hull(&slab([14.0, 16.0], [u1, u2])?), options);
        }
        u1 = u2;
    }
    for i in 0..SIDE {
        for j in 0..SIDE {
            for k in 0..SIDE {
                let [x, y, z] = [-8.0 + 0.8 * i as f32, 13.0 + 0.8 * j as f32, -8.0 + 0.8 * k as f32];
                let body = world.body(&BodyOptions::new(Dynamic, x, y, z));
                world.shape(body, &Shape::block(0.2, 0.2, 0.2), options);
            }
        }
    }
    Ok(nothing())
}

/// The next coordinate of the pile's point set, in -0.5..=0.5.
fn pile_random(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(2_147_001_325).wrapping_add(715_136_305);
    (*state & 0xffff) as f32 / 65535.0 - 0.5
}

fn convex_pile(world: &mut World) -> Result<Before, String> {
    let options = ShapeOptions::default();
    ground(world, 250.0, 250.0, options);
    let mut state = 42;
    let mut points = Vec::with_capacity(32);
    while points.len() < 32 {
        let [x, y, z] = std::array::from_fn(|_| pile_random(&mut state));
        let square = x * x + y * y + z * z;
        if square <= 0.25 {
            let scale = 2.0 / square.sqrt();
            points.push([scale * x, scale * y, scale * z]);
        }
    }
    let hull = Hull::new(&points)?;
    for layer in 0..80 {
        for z in 0..8 {
            for x in 0..8 {
                let (px, pz) = ((x as f32 - 4.0) * 4.0, (z as f32 - 4.0) * 4.0);
                let body = world.body(&BodyOptions::new(Dynamic, px, 2.0 + 4.0 * layer as f32, pz));
                world.shape(body, &Shape::Hull(&hull), options);
            }
        }
    }
    Ok(nothing())
}

fn large_world(world: &mut World) -> Result<Before, String> {
    const SIDE: usize = 1000;
    let options = ShapeOptions { buffer_move: true, ..Default::default() };
    for i in 0..SIDE {
        for j in 0..SIDE {
            let [x, z] = [i, j].map(|n| -5000.0 + (n as f32 + 0.5) * 10.0);
            let body = world.body(&BodyOptions::new(Fixed, x, 0.0, z));
            world.shape(body, &Shape::block(5.0, 0.25, 5.0), options);
        }
    }
    let mut dropped = 0;
    Ok(Box::new(move |world, k| {
        if dropped < 100 && k > 0 && k.is_multiple_of(5) {
            let [x, z] = [dropped % 10, dropped / 10].map(|n| -4000.0 + (n as f32 + 0.5) * 800.0);
            let body = world.body(&BodyOptions::new(Dynamic, x, 1.5, z));
            world.shape(body, &Shape::Sphere { radius: 0.5 }, ShapeOptions::default());
            dropped += 1;
        }
    }))
}

fn jolt_pyramid(world: &mut World) -> Result<Before, String> {
    let options = ShapeOptions { friction: 0.2, ..Default::default() };
    ground(world, 50.0, 50.0, options);
    for i in 0..15usize {
        let shift = if i % 2 == 1 { 1.0 } else { 0.0 };
        let range = i / 2..15 - i.div_ceil(2);
        for j in range.clone() {
            for k in range.clone() {
                let [x, z] = [j, k].map(|n| -15.0 + 2.0 * n as f32 + shift);
                let mut def = BodyOptions::new(Dynamic, x, 1.0 + 2.5 * i as f32, z);
                def.can_sleep = false;
                let body = world.body(&def);
                world.shape(body, &Shape::block(1.0, 1.0, 1.0), options);
            }
        }
    }
    Ok(nothing())
}

/// A cube of 1 kg at rest on the ground and one of 1,000 kg at rest on it: both cubic metres.
fn heavy_on_light(world: &mut World) -> Result<Before, String> {
    ground(world, 50.0, 50.0, ShapeOptions::default());
    for (y, density) in [(0.5, 1.0), (1.5, 1000.0)] {
        let body = world.body(&BodyOptions::new(Dynamic, 0.0, y, 0.0));
        world.shape(body, &Shape::block(0.5, 0.5, 0.5), ShapeOptions { density, ..Default::default() });
    }
    Ok(nothing())
}

fn lowest(heights: &[f32]) -> f32 {
    heights.iter().copied().fold(f32::INFINITY, f32::min)
}

fn highest(heights: &[f32]) -> f32 {
    heights.iter().copied().fold(f32::NEG_INFINITY, f32::max)
}

fn mean(heights: &[f32]) -> f64 {
    heights.iter().map(|&y| f64::from(y)).sum::<f64>() / heights.len().max(1) as f64
}

fn top_quality(world: &World) -> Value {
    let heights = world.dynamic_heights();
    json!({"top_y": heights.last(), "mean_y": mean(&heights), "speed_max": world.speed_max()})
}

fn many_quality(world: &World) -> Value {
    let heights = world.dynamic_heights();
    let per_pyramid = SMALL_ROWS * (SMALL_ROWS + 1) / 2;
    let tops: Vec<f32> = heights.chunks(per_pyramid).filter_map(|c| c.last().copied()).collect();
    json!({"top_y_lowest": lowest(&tops), "top_y_mean": mean(&tops), "speed_max": world.speed_max()})
}

fn pile_quality(world: &World) -> Value {
    let heights = world.dynamic_heights();
    json!({"lowest_y": lowest(&heights), "mean_y": mean(&heights), "highest_y": highest(&heights),
           "speed_max": world.speed_max()})
}

/// How far the cubes stand below their exact places, in millimetres.
fn sink_quality(world: &World) -> Value {
    let heights = world.dynamic_heights();
    let sink = |i: usize, ideal: f64| heights.get(i).map(|&y| (ideal - f64::from(y)) * 1e3);
    json!({"sink_light_mm": sink(0, 0.5), "sink_heavy_mm": sink(1, 1.5), "speed_max": world.speed_max()})
}
