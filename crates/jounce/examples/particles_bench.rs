//! A step of many particles with turbulence and collisions:
//! `cargo run --release -p jounce --example particles_bench [PARTICLES] [STEPS] [floor|boxes|mesh|free]`.
//!
//! Prints milliseconds of a step and of its particle stage, on one and on two threads.

use jounce::geometry::{TriMesh, TriMeshOptions};
use jounce::prelude::*;
use jounce::{Stage, StageObserver, Turbulence};
use std::sync::Arc;
use std::time::{Duration, Instant};

struct Timer {
    last: Instant,
    particles: Duration,
    all: Vec<Duration>,
}

impl StageObserver for Timer {
    #[allow(clippy::disallowed_methods)]
    fn after(&mut self, stage: Stage, _: &World) {
        let now = Instant::now();
        if stage == Stage::Particles {
            self.particles += now - self.last;
        }
        self.last = now;
    }
}

/// Bumps of half a metre, 200 m wide.
fn terrain() -> Arc<TriMesh> {
    let n = 200u32;
    let height = |i: u32, j: u32| 0.25 * ((i * 7 + j * 13) % 5) as f32 / 2.0;
    let corner = |i: u32, j: u32| Vec3::new(i as f32 - 100.0, height(i, j) - 0.5, j as f32 - 100.0);
    let corners: Vec<Vec3> = (0..=n).flat_map(|j| (0..=n).map(move |i| corner(i, j))).collect();
    let cell = |a: u32| [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]];
    let triangles: Vec<_> = (0..n).flat_map(|j| (0..n).flat_map(move |i| cell((n + 1) * j + i))).collect();
    Arc::new(TriMesh::new(&corners, &triangles, TriMeshOptions::default()).expect("a mesh"))
}

fn world(n: u32, what: &str) -> jounce::Result<World> {
    let mut world = World::new(WorldDesc::default())?;
    match what {
        "mesh" => {
            world.add_body(BodyDesc::fixed().shape(ShapeDesc::mesh(terrain())))?;
        }
        "free" => {}
        _ => {
            world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
        }
    }
    if what == "boxes" {
        for i in 0..100 {
            let at = [f64::from(i % 10) * 4.0 - 18.0, 0.5 + f64::from(i % 3), f64::from(i / 10) * 4.0 - 18.0];
            let shape = match i % 4 {
                0 => ShapeDesc::sphere(0.8),
                1 => ShapeDesc::capsule(0.6, 0.5),
                _ => ShapeDesc::cuboid([0.8, 0.6, 0.8]),
            };
            world.add_body(BodyDesc::fixed().at(at).shape(shape))?;
        }
    }
    let emitters = 16;
    for i in 0..emitters {
        let at = [f64::from(i % 4) * 10.0 - 15.0, 4.0, f64::from(i / 4) * 10.0 - 15.0];
        let turbulence = Turbulence { speed: 2.0, size: 1.5, time_s: 1.0, seed: 1 };
        let mut d = EmitterDesc::new().at(at).speed(2.0, 6.0).spread(1.2).lifetime(3.0, 5.0);
        d.radius = [0.02, 0.03];
        d = d.rate(f64::from(n) / 4.0 / f64::from(emitters)).linear_drag(0.8).turbulence(turbulence);
        if what != "free" {
            d = d.collision(ParticleCollision::default());
        }
        world.add_emitter(d.max_particles(n as usize))?;
    }
    Ok(world)
}

#[allow(clippy::disallowed_methods)]
fn main() -> jounce::Result<()> {
    let arg = |i: usize, d: u32| std::env::args().nth(i).and_then(|a| a.parse().ok()).unwrap_or(d);
    let (n, steps) = (arg(1, 250_000), arg(2, 200));
    let what = std::env::args().nth(3).unwrap_or_else(|| "boxes".to_owned());
    let mut warm = world(n, &what)?;
    warm.set_tasks(Tasks::pool(2));
    for _ in 0..330 {
        warm.step()?;
    }
    println!("{what}: {:?}", warm.counts());
    for threads in [1, 2] {
        let mut world = warm.clone();
        world.set_tasks(Tasks::pool(threads));
        for _ in 0..10 {
            world.step()?;
        }
        let mut timer = Timer { last: Instant::now(), particles: Duration::ZERO, all: Vec::new() };
        for _ in 0..steps {
            let start = Instant::now();
            timer.last = start;
            world.step_observed(&mut timer)?;
            timer.all.push(start.elapsed());
        }
        timer.all.sort_unstable();
        let ms = |d: Duration| d.as_secs_f64() * 1e3;
        println!(
            "{threads} threads: least {:.2}, median {:.2} ms a step, worst {:.2} ms; particles {:.2} ms; {} particles, hash {:#018x}",
            ms(timer.all[0]),
            ms(timer.all[timer.all.len() / 2]),
            ms(timer.all[timer.all.len() - 1]),
            ms(timer.particles) / f64::from(steps),
            world.counts().particles,
            world.hash()
        );
    }
    Ok(())
}
