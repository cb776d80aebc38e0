//! A game loop in one page: `cargo run -p jounce --example game_loop`.
//!
//! A wall of boxes; the player picks one with the mouse (a ray) and kicks it. Frames come at an uneven pace, steps at 60 Hz.

use jounce::prelude::*;

fn main() -> jounce::Result<()> {
    let mut world = World::new(WorldDesc::default())?;
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    for x in -2..=2 {
        for y in 0..4 {
            let at = [f64::from(x), 0.5 + f64::from(y), 0.0];
            let shape = ShapeDesc::cuboid([0.5; 3]).mass(5.0).hit_events(true);
            world.add_body(BodyDesc::dynamic().at(at).name(format!("box {x} {y}")).shape(shape))?;
        }
    }

    let mut picked = None;
    for frame in 0..90 {
        // The game measures this; here every third frame is late.
        let frame_dt = if frame % 3 == 0 { 0.025 } else { 0.0125 };

        // Input first: what is under the crosshair of a camera 8 m in front of the wall?
        if frame == 20 {
            let crosshair = Ray::new([0.2, 2.6, 8.0], -Vec3::Z);
            if let Some(hit) = world.cast_ray(&crosshair, &QueryFilter::default()) {
                println!("picked {:?} at {:?}, {:.2} m away", name(&world, hit.body), hit.point, hit.t);
                // An impulse at the point: the box is kicked and turned.
                world.add_impulse(hit.body, Vec3::new(0.0, 0.0, -40.0), Some(hit.point))?;
                picked = Some(hit.body);
            }
        }

        // Zero, one or more steps of fixed length; what is left over becomes `alpha`.
        let advance = world.advance(frame_dt)?;

        // What happened in them: sounds, damage, score.
        for event in world.events() {
            if let Event::ContactHit { a, b, speed, impulse, .. } = *event {
                let (a, b) = (name(&world, world.shape(a)?.body()), name(&world, world.shape(b)?.body()));
                println!("frame {frame}: {a} hits {b} at {speed:.1} m/s, {impulse:.1} N s");
            }
        }

        // Draw between the last two steps, so that motion is smooth at any frame rate.
        if let Some(body) = picked.filter(|_| frame % 10 == 0) {
            let p = world.body(body)?.interpolated_pose(advance.alpha).p;
            println!("frame {frame}: the picked box is drawn at ({:.3}, {:.3}, {:.3})", p.x, p.y, p.z);
        }
    }
    println!("after {:.2} s: {:#018x}", world.time(), world.hash());
    Ok(())
}

fn name(world: &World, body: BodyId) -> &str {
    world.body(body).ok().and_then(|b| b.name()).unwrap_or("the ground")
}
