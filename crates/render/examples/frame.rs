//! How long does a picture take? A thousand mixed bodies, 640 × 360 pixels.
//!
//! `cargo run --release -p jounce_render --example frame -- [PICTURE.png] [THREADS]`

use jounce::math::Vec3;
use jounce::{BodyDesc, ShapeDesc, World, WorldDesc};
use jounce_render::{Overlay, RenderOptions, Stage, render};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let threads = words.get(1).map_or(Ok(0), |w| w.parse())?;
    let mut world = World::new(WorldDesc::default())?;
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    for i in 0..1000_u32 {
        let shape = match i % 5 {
            0 => ShapeDesc::sphere(0.4),
            1 => ShapeDesc::cuboid([0.4, 0.3, 0.35]),
            2 => ShapeDesc::capsule(0.3, 0.25),
            3 => ShapeDesc::cylinder(0.3, 0.35),
            _ => ShapeDesc::cone(0.35, 0.4),
        };
        let (x, y, z) = (i % 10, i / 100, i / 10 % 10);
        let at = [f64::from(x) - 4.5, f64::from(y) + 0.6, f64::from(z) - 4.5];
        world.add_body(BodyDesc::dynamic().at(at).shape(shape.restitution(0.2)))?;
    }
    let start = Instant::now();
    for _ in 0..90 {
        world.step()?;
    }
    println!("90 steps: {:.2} s", start.elapsed().as_secs_f64());
    let options = RenderOptions { threads, ..RenderOptions::default() };
    let camera = Stage::camera(&world, 16.0 / 9.0);
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        let image = render(&Stage::new(&world), &camera, &Overlay::default(), &options)?;
        best = best.min(start.elapsed().as_secs_f64());
        if let Some(path) = words.first() {
            image.write_png(path.as_ref())?;
        }
    }
    println!("640x360 frame of 1,000 bodies: {best:.3} s, the fastest of 5");
    Ok(())
}
