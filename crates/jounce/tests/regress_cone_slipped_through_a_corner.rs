//! A cone that slid with its base along one wall of a corner touched the other wall in points of the first one's plane
//! only. Such points were taken for a seam's and given the first wall's normal, however deep they were: the cone sank
//! through the floor.

use jounce::prelude::*;

/// Pressed 5 cm into the floor, its base flat on the wall, a body comes out again.
fn comes_out(shape: ShapeDesc, tilt: f32, kinematic: bool) -> f64 {
    let mut world = World::new(WorldDesc::default()).expect("defaults are valid");
    let wall = |half: [f32; 3], at: [f64; 3]| {
        let desc = if kinematic { BodyDesc::kinematic() } else { BodyDesc::fixed() };
        desc.at(at).shape(ShapeDesc::cuboid(half))
    };
    world.add_body(wall([3.0, 0.2, 3.0], [0.0, -0.2, 2.0])).expect("a floor");
    world.add_body(wall([3.0, 3.0, 0.2], [0.0, 2.0, -0.2])).expect("a wall");
    let turn = Quat::from_axis_angle(Vec3::X, std::f32::consts::FRAC_PI_2 + tilt);
    let body = BodyDesc::dynamic().at([0.0, 0.19, 0.25]).rotated(turn).shape(shape);
    let id = world.add_body(body).expect("a body");
    for _ in 0..5 {
        world.step().expect("steps");
    }
    world.body(id).expect("alive").position().y
}

#[test]
fn the_other_wall_holds() {
    for kinematic in [false, true] {
        for tilt in -5..=5 {
            let tilt = tilt as f32 * 0.004;
            let y = comes_out(ShapeDesc::cone(0.25, 0.24), tilt, kinematic);
            assert!(y > 0.2, "the cone is at {y} m, tilted by {tilt}");
        }
    }
}
