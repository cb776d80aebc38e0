//! A world and its clone went different ways (random world 1744): continuous collision borrowed the narrow phase's memory for
//! its own contact tests, and did without those tests where there was none. A clone starts without memory, so in a step
//! without any pair the clone stopped a ball at a surface that the original let graze it.

use jounce::prelude::*;

#[test]
fn a_clone_lets_a_ball_graze_where_the_original_does() {
    for gap in 1..40 {
        let mut world = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
        let slab = ShapeDesc::cuboid([100.0, 1.0, 100.0]);
        world.add_body(BodyDesc::fixed().at([0.0, -1.0, 0.0]).shape(slab)).unwrap();
        // A contact, so that the original has memory; then it goes.
        let pebble =
            world.add_body(BodyDesc::dynamic().at([50.0, 0.1, 0.0]).shape(ShapeDesc::sphere(0.1))).unwrap();
        world.step().unwrap();
        world.remove_body(pebble).unwrap();
        world.step().unwrap();
        // 6 cm a step, more than half the radius: swept.
        let height = 0.1 + 0.005 * f64::from(gap);
        let mut ball = BodyDesc::dynamic().at([0.0, height, 0.0]).shape(ShapeDesc::sphere(0.1));
        ball.velocity = Vec3::new(0.0, -3.6, 0.0);
        world.add_body(ball).unwrap();
        let mut clone = world.clone();
        for step in 0..4 {
            world.step().unwrap();
            clone.step().unwrap();
            assert_eq!(world.hash(), clone.hash(), "gap of {gap} × 5 mm, step {step}");
        }
    }
}
