//! A conveyor belt: `cargo run -p jounce --example conveyor`.
//!
//! The belt's body stands still; its surface moves. Friction brings a crate to the belt's speed and carries it off the end.

use jounce::prelude::*;

fn main() -> jounce::Result<()> {
    let mut world = World::new(WorldDesc::default())?;
    world.add_body(BodyDesc::fixed().at([0.0, -1.0, 0.0]).shape(ShapeDesc::half_space(Vec3::Y)))?;
    let rubber = Material { surface_velocity: Vec3::new(1.5, 0.0, 0.0), ..Material::default() };
    let belt = ShapeDesc::cuboid([3.0, 0.1, 0.5]).material(rubber);
    world.add_body(BodyDesc::fixed().at([0.0, -0.1, 0.0]).name("belt").shape(belt))?;
    let crate_ = ShapeDesc::cuboid([0.2; 3]).mass(10.0);
    let crate_ = world.add_body(BodyDesc::dynamic().at([-2.5, 0.2, 0.0]).shape(crate_))?;
    for step in 0..=300 {
        if step % 15 == 0 {
            let body = world.body(crate_)?;
            // Friction on the crate, N: μ m g while it is slower than the belt, then nothing.
            let contacts = world.contacts_of(crate_)?;
            let drag: f32 =
                contacts.iter().map(|c| if c.bodies[1] == crate_ { c.force().x } else { -c.force().x }).sum();
            let (x, y) = (body.position().x, body.position().y);
            println!(
                "{:.1} s: x {x:6.2} m, y {y:5.2} m, {:4.2} m/s, drag {drag:5.1} N",
                world.time(),
                body.velocity().x
            );
        }
        world.step()?;
    }
    Ok(())
}
