//! A platform to jump onto from below: `cargo run -p jounce --example one_way_platform`.
//!
//! A contact hook drops the contacts of whoever comes from below. Hooks run on any thread in any order, so they decide by
//! their arguments alone.

use jounce::prelude::*;
use jounce::{ContactHook, ContactView, Surface};
use std::sync::Arc;

/// The `user_data` that marks one-way platforms.
const ONE_WAY: u128 = 1;

fn one_way(view: &ContactView, _: &mut Surface) -> bool {
    let Some(side) = view.pair.user_data.iter().position(|&u| u == ONE_WAY) else { return true };
    // Normals and velocities go from the first shape to the second: turn them so that they lead out of the platform.
    let out = if side == 0 { 1.0 } else { -1.0 };
    let from_above = view.normal.y * out > 0.7;
    let going_up = view.relative_velocity.y * out > 0.5;
    from_above && !going_up && view.separation > -0.1
}

fn main() -> jounce::Result<()> {
    let mut world = World::new(WorldDesc::default())?;
    let hook: ContactHook = Arc::new(one_way);
    world.set_contact_hook(Some(("one way", hook)));
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    let slab = ShapeDesc::cuboid([2.0, 0.1, 2.0]);
    world.add_body(BodyDesc::fixed().at([0.0, 2.0, 0.0]).user_data(ONE_WAY).shape(slab))?;
    let jumper = ShapeDesc::capsule(0.3, 0.25).mass(60.0);
    let start = BodyDesc::dynamic().at([0.0, 0.56, 0.0]).locks(AxisLocks::ROTATION);
    let player = world.add_body(start.velocity([0.0, 8.0, 0.0]).shape(jumper))?;
    for step in 0..=120 {
        if step % 10 == 0 {
            let y = world.body(player)?.position().y;
            println!("{:.2} s: feet at {:.2} m", world.time(), y - 0.55);
        }
        world.step()?;
    }
    Ok(())
}
