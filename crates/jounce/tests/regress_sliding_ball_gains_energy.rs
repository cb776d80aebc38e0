//! A fast ball on a curved floor of triangles was stopped by continuous collision at every step: it kept its speed but not its
//! way, so gravity went on accelerating it, to twice the speed that its height allowed.

use jounce::geometry::{TriMesh, TriMeshOptions};
use jounce::math::scalar::{f32s, f64s};
use jounce::prelude::*;
use std::sync::Arc;

#[test]
fn a_ball_in_a_bowl_keeps_its_energy() {
    // A half-pipe of radius 2 m, the ball's centre on the circle of 1.98 m.
    let mut corners = Vec::new();
    for i in 0..=800_u16 {
        let angle = 3.2 * (f32::from(i) / 800.0 - 0.5);
        let (x, y) = (2.0 * f32s::sin(angle), -2.0 * f32s::cos(angle));
        corners.extend([Vec3::new(x, y, -1.0), Vec3::new(x, y, 1.0)]);
    }
    let triangles: Vec<[u32; 3]> =
        (0..800).flat_map(|i| [[2 * i, 2 * i + 1, 2 * i + 2], [2 * i + 1, 2 * i + 3, 2 * i + 2]]).collect();
    let mesh = TriMesh::new(&corners, &triangles, TriMeshOptions::default()).expect("a mesh");
    let mut world = World::new(WorldDesc { rate_hz: 480.0, ..WorldDesc::default() }).expect("valid");
    let floor = ShapeDesc::mesh(Arc::new(mesh)).friction(0.0);
    world.add_body(BodyDesc::fixed().shape(floor)).expect("a floor");
    let ball = BodyDesc::dynamic().at([-1.98, 0.0, 0.0]).shape(ShapeDesc::sphere(0.02).friction(0.0));
    let ball = world.add_body(ball).expect("a ball");
    let energy = |world: &World| {
        let b = world.body(ball).expect("alive");
        0.5 * f64::from(b.velocity().length_squared()) + 9.81 * b.position().y
    };
    let mut most = 0.0;
    for _ in 0..960 {
        world.step().expect("steps");
        most = f64s::max(most, energy(&world).abs());
    }
    // m g R = 19.4 J per kg; 1 % of it.
    assert!(most < 0.194, "energy off by {most} J per kg");
}
