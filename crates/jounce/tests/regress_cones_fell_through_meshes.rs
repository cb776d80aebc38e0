//! Cones that hit a mesh floor at 16 m/s on their side fell through it. A one-sided triangle does not count for a body whose
//! middle is behind it, and the middle of a cone was taken to be its origin, halfway up the axis: outside the bulk, and behind
//! the floor as soon as the tip swung down.

use jounce::geometry::{TriMesh, TriMeshOptions};
use jounce::prelude::*;
use std::sync::Arc;

#[test]
fn cones_stay_on_a_mesh() {
    let corners =
        [[-60.0, 0.0, -60.0], [60.0, 0.0, -60.0], [60.0, 0.0, 60.0], [-60.0, 0.0, 60.0]].map(Vec3::from);
    let floor = TriMesh::new(&corners, &[[0, 2, 1], [0, 3, 2]], TriMeshOptions::default()).expect("a floor");
    let mut world = World::new(WorldDesc::default()).expect("defaults are valid");
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::mesh(Arc::new(floor)))).expect("ground");
    let mut cones = Vec::new();
    for i in 0..400 {
        let f = i as f32;
        let turn = Quat::from_euler_xyz(Vec3::new(f * 0.37, f * 1.13, f * 0.71));
        let at =
            [f64::from(i % 20) * 2.0 - 20.0, 1.0 + f64::from(i % 7) * 0.05, f64::from(i / 20) * 2.0 - 20.0];
        let desc = BodyDesc::dynamic()
            .at(at)
            .rotated(turn)
            .velocity([0.0, -16.0, 0.0])
            .shape(ShapeDesc::cone(0.25, 0.24));
        cones.push(world.add_body(desc).expect("a cone"));
    }
    for _ in 0..120 {
        world.step().expect("steps");
    }
    let through = cones.iter().filter(|&&c| world.body(c).expect("alive").center_of_mass().y < 0.0).count();
    assert_eq!(through, 0);
}
