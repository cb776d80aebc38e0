//! The comparison's scenes: the same bodies in the same order as every other engine's program builds them.
//!
//! Common: 1/60 s steps, 4 substeps, gravity −10 m/s², friction 0.6, restitution 0, density 1000 kg/m³, sleeping and
//! continuous collision on, unless the scene says otherwise. "Half" means half extents; metres and kg/m³; y is up.

use super::quality::Quality;
use super::terrain;
use crate::error::Failure;
use jounce::geometry::{Hull, Shape};
use jounce::math::scalar::f32s::{cos, sin};
use jounce::math::{DVec3, Quat, Vec3};
use jounce::{BodyDesc, BodyId, Filter, JointDesc, Settings, ShapeDesc, World, WorldDesc};
use std::f32::consts::PI;
use std::sync::Arc;

/// What a scene does before step `k`.
pub(crate) type Before = Box<dyn FnMut(&mut World, usize) -> Result<(), Failure>>;
/// A world and what happens to it.
pub(crate) type Built = Result<(World, Before), Failure>;

/// A named scene.
pub(crate) struct Scene {
    pub name: &'static str,
    pub steps: usize,
    pub build: fn() -> Built,
    pub quality: Quality,
}

const fn scene(name: &'static str, steps: usize, build: fn() -> Built) -> Scene {
    Scene { name, steps, build, quality: Quality::Heights }
}

/// Every scene, in the order of `all`.
pub(crate) const SCENES: &[Scene] = &[
    Scene { quality: Quality::Top, ..scene("large_pyramid", 200, large_pyramid) },
    Scene {
        quality: Quality::Tops(SMALL_ROWS * (SMALL_ROWS + 1) / 2),
        ..scene("many_pyramids", 100, many_pyramids)
    },
    scene("joint_grid", 100, joint_grid),
    scene("rain", 400, terrain::rain),
    scene("junkyard", 500, junkyard),
    scene("washer", 1000, washer),
    scene("convex_pile", 500, convex_pile),
    scene("trees100", 500, terrain::trees100),
    scene("trees50", 500, terrain::trees50),
    scene("trees25", 500, terrain::trees25),
    scene("large_world", 500, large_world),
    scene("jolt_pyramid", 500, jolt_pyramid),
    scene("convex_vs_mesh", 500, terrain::convex_vs_mesh),
    Scene { quality: Quality::Sink, ..scene("heavy_on_light", 600, heavy_on_light) },
];

pub(super) fn world(gravity_y: f32, sleep: bool) -> Result<World, Failure> {
    let settings = Settings { sleep, ..Settings::default() };
    let gravity = Vec3::new(0.0, gravity_y, 0.0);
    Ok(World::new(WorldDesc { gravity, rate_hz: 60.0, substeps: 4, settings })?)
}

pub(super) fn nothing() -> Before {
    Box::new(|_, _| Ok(()))
}

pub(super) fn at(x: f32, y: f32, z: f32) -> DVec3 {
    Vec3::new(x, y, z).as_dvec3()
}

/// A fixed box whose top face is the plane y = 0.
fn ground(world: &mut World, half_x: f32, half_z: f32, friction: f32) -> Result<(), Failure> {
    let shape = ShapeDesc::cuboid([half_x, 1.0, half_z]).friction(friction);
    world.add_body(BodyDesc::fixed().at([0.0, -1.0, 0.0]).shape(shape))?;
    Ok(())
}

fn cube(half: f32, density: f32) -> ShapeDesc {
    ShapeDesc::cuboid([half; 3]).density(density)
}

fn large_pyramid() -> Built {
    const ROWS: usize = 100;
    let mut world = world(-10.0, false)?;
    ground(&mut world, 400.0, 400.0, 0.6)?;
    for i in 0..ROWS {
        let y = (2.0 * i as f32 + 1.0) * 0.5;
        for j in i..ROWS {
            let x = (i as f32 + 1.0) * 0.5 + (j - i) as f32 - 50.0;
            world.add_body(BodyDesc::dynamic().at(at(x, y, 0.0)).shape(cube(0.5, 100.0)))?;
        }
    }
    Ok((world, nothing()))
}

/// Rows of each of the many pyramids.
const SMALL_ROWS: usize = 10;

fn many_pyramids() -> Built {
    const SIDE: usize = 14;
    let mut world = world(-10.0, true)?;
    ground(&mut world, 77.0, 77.0, 0.6)?;
    for row in 0..SIDE {
        let z = -76.0 + row as f32 * (2.0 * 76.0 / 13.0);
        for column in 0..SIDE {
            let centre_x = -76.0 + 11.0 * column as f32;
            for i in 0..SMALL_ROWS {
                let y = (2.0 * i as f32 + 1.0) * 0.5;
                for j in i..SMALL_ROWS {
                    let x = (i as f32 + 1.0) * 0.5 + (j - i) as f32 + centre_x - 0.5;
                    let body = BodyDesc::dynamic().at(at(x, y, z)).can_sleep(false);
                    world.add_body(body.shape(cube(0.5, 100.0)))?;
                }
            }
        }
    }
    Ok((world, nothing()))
}

/// A net of spheres that hangs from its upper edge and never collides.
fn joint_grid() -> Built {
    const SIDE: usize = 100;
    let mut world = world(-10.0, false)?;
    let ghost = Filter { layers: 2, mask: !2, group: 0 };
    let mut bodies = Vec::with_capacity(SIDE * SIDE);
    for k in 0..SIDE {
        for i in 0..SIDE {
            let body = if i == 0 { BodyDesc::fixed() } else { BodyDesc::dynamic() };
            let shape = ShapeDesc::sphere(0.4).filter(ghost);
            let body = world.add_body(body.at(at(k as f32, -(i as f32), 0.0)).shape(shape))?;
            if i > 0 {
                let above = bodies[bodies.len() - 1];
                world.add_joint(JointDesc::ball(above, body, at(k as f32, 0.5 - i as f32, 0.0)))?;
            }
            if k > 0 {
                let before = bodies[bodies.len() - SIDE];
                world.add_joint(JointDesc::ball(before, body, at(k as f32 - 0.5, -(i as f32), 0.0)))?;
            }
            bodies.push(body);
        }
    }
    Ok((world, nothing()))
}

pub(super) fn hull(points: &[Vec3]) -> Result<ShapeDesc, Failure> {
    let hull = Hull::new(points).map_err(|e| Failure::bad(e.to_string()))?;
    Ok(ShapeDesc::new(Shape::Hull(Arc::new(hull))))
}

fn junkyard() -> Built {
    let mut world = world(-10.0, true)?;
    let mut yard = BodyDesc::fixed().at([0.0, -1.0, 0.0]).shape(ShapeDesc::cuboid([120.0, 1.0, 120.0]));
    for x in [-50.0, 50.0] {
        yard = yard.shape(ShapeDesc::cuboid([1.0, 8.0, 50.0]).at([x, 8.0, 0.0]));
    }
    for z in [-50.0, 50.0] {
        yard = yard.shape(ShapeDesc::cuboid([50.0, 8.0, 1.0]).at([0.0, 8.0, z]));
    }
    world.add_body(yard)?;
    let rock = rock(1.5)?;
    for layer in 0..24 {
        for x in 0..21 {
            for z in 0..21 {
                let (x, z) = (-40.0 + 4.0 * x as f32, -40.0 + 4.0 * z as f32);
                let position = at(x, 4.0 * layer as f32 + 25.0, z);
                world.add_body(BodyDesc::dynamic().at(position).shape(rock.clone()))?;
            }
        }
    }
    let corners = (0..16).map(|k| 2.0 * PI * k as f32 / 16.0).map(|a| (4.0 * cos(a), 4.0 * sin(a)));
    let points: Vec<Vec3> =
        corners.flat_map(|(x, z)| [Vec3::new(x, 0.0, z), Vec3::new(x, 24.0, z)]).collect();
    let pusher: BodyId = world.add_body(BodyDesc::kinematic().at([35.0, 0.0, 0.0]).shape(hull(&points)?))?;
    let mut degrees = 0.0_f32;
    let before = move |world: &mut World, _| {
        degrees -= 6.0 / 60.0;
        let a = degrees.to_radians();
        Ok(world.move_to(pusher, at(35.0 * cos(a), 0.0, 35.0 * sin(a)), Quat::IDENTITY)?)
    };
    Ok((world, Box::new(before)))
}

/// Ten points of a Fibonacci lattice on a sphere.
fn rock(radius: f32) -> Result<ShapeDesc, Failure> {
    const COUNT: usize = 10;
    let theta = 2.0 * PI / ((1.0 + 5.0_f32.sqrt()) / 2.0);
    let point = |i: usize| {
        let z = 1.0 - (2.0 * i as f32 + 1.0) / COUNT as f32;
        let ring = (1.0 - z * z).sqrt();
        let a = i as f32 * theta;
        Vec3::new(radius * ring * cos(a), radius * ring * sin(a), radius * z)
    };
    hull(&(0..COUNT).map(point).collect::<Vec<_>>())
}

/// `(x, y)` turned about z by an angle in degrees.
fn turned((x, y): (f32, f32), degrees: f32) -> (f32, f32) {
    let a = degrees.to_radians();
    (cos(a) * x - sin(a) * y, sin(a) * x + cos(a) * y)
}

/// The hull between two radii along two directions, 20 m long in z.
fn slab(radii: [f32; 2], directions: [(f32, f32); 2]) -> Result<ShapeDesc, Failure> {
    let mut points = Vec::with_capacity(8);
    for z in [-10.0, 10.0] {
        for (x, y) in directions {
            points.extend(radii.map(|r| Vec3::new(r * x, r * y, z)));
        }
    }
    hull(&points)
}

fn washer() -> Built {
    const SIDE: usize = 20;
    let mut world = world(-10.0, true)?;
    ground(&mut world, 60.0, 60.0, 0.6)?;
    let mut drum = BodyDesc::kinematic()
        .at([0.0, 21.0, 0.0])
        .velocity([0.001, -0.002, 0.0])
        .angular_velocity([0.0, 0.0, 25.0_f32.to_radians()]);
    let mut u1 = (1.0, 0.0);
    for i in 0..36 {
        let u2 = if i == 35 { (1.0, 0.0) } else { turned(u1, 10.0) };
        drum = drum.shape(slab([16.0, 18.0], [turned(u1, -1.0), turned(u2, 1.0)])?);
        if i % 9 == 0 {
            drum = drum.shape(slab([14.0, 16.0], [u1, u2])?);
        }
        u1 = u2;
    }
    world.add_body(drum)?;
    for i in 0..SIDE {
        for j in 0..SIDE {
            for k in 0..SIDE {
                let place = at(-8.0 + 0.8 * i as f32, 13.0 + 0.8 * j as f32, -8.0 + 0.8 * k as f32);
                world.add_body(BodyDesc::dynamic().at(place).shape(cube(0.2, 1000.0)))?;
            }
        }
    }
    Ok((world, nothing()))
}

/// The next coordinate of the pile's point set, −0.5 to 0.5.
fn pile_random(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(2_147_001_325).wrapping_add(715_136_305);
    (*state & 0xffff) as f32 / 65535.0 - 0.5
}

fn convex_pile() -> Built {
    let mut world = world(-10.0, true)?;
    ground(&mut world, 250.0, 250.0, 0.6)?;
    let mut state = 42;
    let mut points = Vec::with_capacity(32);
    while points.len() < 32 {
        let p = Vec3::from_array(std::array::from_fn(|_| pile_random(&mut state)));
        let square = p.length_squared();
        if square <= 0.25 {
            points.push(p * (2.0 / square.sqrt()));
        }
    }
    let shape = hull(&points)?;
    for layer in 0..80 {
        for z in 0..8 {
            for x in 0..8 {
                let place = at((x as f32 - 4.0) * 4.0, 2.0 + 4.0 * layer as f32, (z as f32 - 4.0) * 4.0);
                world.add_body(BodyDesc::dynamic().at(place).shape(shape.clone()))?;
            }
        }
    }
    Ok((world, nothing()))
}

fn large_world() -> Built {
    const SIDE: usize = 1000;
    let mut world = world(-10.0, true)?;
    for i in 0..SIDE {
        for j in 0..SIDE {
            let [x, z] = [i, j].map(|n| -5000.0 + (n as f32 + 0.5) * 10.0);
            world.add_body(BodyDesc::fixed().at(at(x, 0.0, z)).shape(ShapeDesc::cuboid([5.0, 0.25, 5.0])))?;
        }
    }
    let mut dropped = 0;
    let before = move |world: &mut World, k: usize| {
        if dropped < 100 && k > 0 && k.is_multiple_of(5) {
            let [x, z] = [dropped % 10, dropped / 10].map(|n| -4000.0 + (n as f32 + 0.5) * 800.0);
            world.add_body(BodyDesc::dynamic().at(at(x, 1.5, z)).shape(ShapeDesc::sphere(0.5)))?;
            dropped += 1;
        }
        Ok(())
    };
    Ok((world, Box::new(before)))
}

fn jolt_pyramid() -> Built {
    let mut world = world(-9.81, true)?;
    ground(&mut world, 50.0, 50.0, 0.2)?;
    for i in 0..15_usize {
        let shift = if i % 2 == 1 { 1.0 } else { 0.0 };
        let range = i / 2..15 - i.div_ceil(2);
        for j in range.clone() {
            for k in range.clone() {
                let [x, z] = [j, k].map(|n| -15.0 + 2.0 * n as f32 + shift);
                let body = BodyDesc::dynamic().at(at(x, 1.0 + 2.5 * i as f32, z)).can_sleep(false);
                world.add_body(body.shape(cube(1.0, 1000.0).friction(0.2)))?;
            }
        }
    }
    Ok((world, nothing()))
}

/// A cubic metre of 1 kg at rest on the ground and one of 1,000 kg on it.
fn heavy_on_light() -> Built {
    let mut world = world(-9.81, true)?;
    ground(&mut world, 50.0, 50.0, 0.6)?;
    for (y, density) in [(0.5, 1.0), (1.5, 1000.0)] {
        world.add_body(BodyDesc::dynamic().at([0.0, y, 0.0]).shape(cube(0.5, density)))?;
    }
    Ok((world, nothing()))
}
