//! A box fell asleep on a kinematic platform that may not sleep. Their contact stayed among the awake ones with no body that it
//! could move: it found no colour ("a contact of a body with itself" in debug builds), and in release builds impulses were
//! read back from another contact's solver row. And a platform that then set off left the sleeping box in the air.
//! Found by random worlds, seed 39.

use jounce::prelude::*;

#[test]
fn a_box_sleeps_on_a_waking_platform_and_is_carried_off() -> jounce::Result<()> {
    let mut world = World::new(WorldDesc::default())?;
    let platform =
        world.add_body(BodyDesc::kinematic().can_sleep(false).shape(ShapeDesc::cuboid([2.0, 0.5, 2.0])))?;
    let rider = world.add_body(BodyDesc::dynamic().at([0.0, 1.0, 0.0]).shape(ShapeDesc::cuboid([0.5; 3])))?;
    for _ in 0..120 {
        world.step()?;
    }
    assert!(!world.body(rider)?.is_awake() && world.body(platform)?.is_awake());
    world.set_velocity(platform, Vec3::new(0.5, 0.0, 0.0))?;
    for _ in 0..120 {
        world.step()?;
    }
    let (p, r) = (world.body(platform)?.position(), world.body(rider)?.position());
    assert!((p.x - 1.0).abs() < 1e-3 && (r.x - p.x).abs() < 0.05, "platform {p:?}, rider {r:?}");
    Ok(())
}
