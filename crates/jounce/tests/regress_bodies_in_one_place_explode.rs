//! A hundred bodies made at one point flew apart at 69 m/s: each contact asked for its own push-out, and all along one line.

use jounce::math::Vec3;
use jounce::math::scalar::f32s;
use jounce::prelude::*;

/// Fastest speed in two seconds of `n` bodies of 1 m that start in one place, without gravity, and the sum of their momenta.
fn burst(n: usize, shape: ShapeDesc) -> (f32, f64) {
    let mut world = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap();
    for _ in 0..n {
        world.add_body(BodyDesc::dynamic().at([0.0, 1.0, 0.0]).shape(shape.clone())).unwrap();
    }
    let mut fastest = 0.0_f32;
    for _ in 0..120 {
        world.step().unwrap();
        let speeds = world.bodies().map(|b| world.body(b).unwrap().velocity().length());
        fastest = speeds.fold(fastest, f32s::max);
    }
    (fastest, world.momentum().linear.length())
}

#[test]
fn bodies_in_one_place_part_slowly() {
    let n = 100;
    // Neighbours part at the push-out speed, 3 m/s, and from the middle to the edge of a ball of n bodies are n^(1/3)/2 of them.
    let limit = 3.0 * 0.5 * f32s::pow(n as f32, 1.0 / 3.0);
    for shape in [ShapeDesc::sphere(0.5), ShapeDesc::cuboid(Vec3::splat(0.5)), ShapeDesc::capsule(0.25, 0.25)]
    {
        let name = format!("{shape:?}");
        let (fastest, momentum) = burst(n, shape.mass(1.0));
        assert!(fastest > 0.5, "they part, at {fastest} m/s: {name}");
        assert!(fastest < limit, "{fastest} m/s, at most {limit}: {name}");
        assert!(momentum < 1e-3, "{momentum} N s: {name}");
    }
}
