//! Bodies described as asleep woke in the first step: their pairs with the ground were new, and a new pair without an
//! awake body used to wake both of its bodies (meant for a wall put next to a sleeper).

use jounce::prelude::*;

fn world() -> World {
    let mut world = World::new(WorldDesc::default()).expect("defaults are valid");
    world
        .add_body(BodyDesc::fixed().at([0.0, -1.0, 0.0]).shape(ShapeDesc::cuboid([10.0, 1.0, 10.0])))
        .expect("ground");
    for i in 0..3 {
        let mut desc =
            BodyDesc::dynamic().at([0.0, 0.5 + f64::from(i), 0.0]).shape(ShapeDesc::cuboid([0.5; 3]));
        desc.asleep = true;
        world.add_body(desc).expect("a cube");
    }
    world
}

#[test]
fn they_stay_asleep() {
    let mut world = world();
    for _ in 0..60 {
        world.step().expect("steps");
    }
    assert_eq!(world.counts().awake, 0);
}

#[test]
fn a_wall_put_into_them_wakes_them() {
    let mut world = world();
    world.step().expect("steps");
    let wall = BodyDesc::fixed().at([0.9, 1.5, 0.0]).shape(ShapeDesc::cuboid([0.5; 3]));
    world.add_body(wall).expect("a wall");
    world.step().expect("steps");
    assert!(world.counts().awake > 0);
}
