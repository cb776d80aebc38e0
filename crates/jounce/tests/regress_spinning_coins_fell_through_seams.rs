//! A coin that touched one triangle and turned onto its neighbour within the step was stopped only where it met the neighbour:
//! its centre was through the first triangle by then. One in three hundred fell through a mesh floor, all of them at
//! seams.

use jounce::geometry::{TriMesh, TriMeshOptions};
use jounce::prelude::*;
use std::sync::Arc;

/// One of those coins: its rim 0.3 mm over the floor, 8 mm from the seam x + z = 1 that it turns towards, at 22 m/s.
#[test]
fn a_coin_stays_over_a_seam() {
    let corners =
        [[-3.0, 0.0, 3.0], [-3.0, 0.0, 4.0], [-2.0, 0.0, 3.0], [-2.0, 0.0, 4.0]].map(Vec3::from_array);
    let floor = TriMesh::new(&corners, &[[0, 1, 2], [2, 1, 3]], TriMeshOptions::default()).expect("a square");
    let mut world = World::new(WorldDesc::default()).expect("defaults are valid");
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::mesh(Arc::new(floor)))).expect("a floor");
    let turned = Quat::new(0.588_833_8, -0.528_840_5, 0.606_894_25, 0.072_676_59);
    let coin = BodyDesc::dynamic()
        .at([-2.167_779_7, 0.012_183_039, 3.220_745_8])
        .rotated(turned)
        .velocity([0.0, -22.067, 0.0])
        .angular_velocity([-16.10, 0.34, 18.27])
        .shape(ShapeDesc::cylinder(0.0025, 0.012).density(8000.0));
    let coin = world.add_body(coin).expect("a coin");
    for step in 0..6 {
        world.step().expect("steps");
        let y = world.body(coin).expect("alive").position().y;
        assert!(y > 0.0, "at {y} m in step {step}");
    }
}
