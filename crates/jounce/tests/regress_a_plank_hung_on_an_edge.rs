//! A plank that tips over the edge of a block, turning at 2 rad/s: continuous collision stopped it in every step where it was, since its end swung into
//! what its contact did not see, and it hung in the air while gravity added to its velocity, up to 20 m/s. Cones on the edges of meshes did the
//! same, and kept heaps awake.

use jounce::math::scalar::f32s;
use jounce::prelude::*;

#[test]
fn regress_a_plank_hung_on_an_edge() {
    for x in [0.55, 0.6, 0.7] {
        let mut w = World::new(WorldDesc::default()).unwrap();
        w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap();
        w.add_body(BodyDesc::fixed().at([0.0, 0.45, 0.0]).shape(ShapeDesc::cuboid([0.5, 0.45, 0.5])))
            .unwrap();
        let plank = BodyDesc::dynamic().at([x, 0.95, 0.0]).angular_velocity([0.0, 0.0, -2.0]);
        let plank = w.add_body(plank.shape(ShapeDesc::cuboid([2.0, 0.05, 0.4]).mass(20.0))).unwrap();
        let mut fastest = 0.0;
        for _ in 0..240 {
            w.step().unwrap();
            fastest = f32s::max(fastest, w.body(plank).unwrap().velocity().length());
        }
        let b = w.body(plank).unwrap();
        // It lies on the edge and on its end: no more friction than it has can hold it there (tan 26° < 0.6).
        let end = b.position() + b.rotation().rotate(Vec3::new(2.0, -0.05, 0.0)).as_dvec3();
        let (slow, low) = (b.velocity().length() < 0.01, end.y < 0.01);
        println!("{x} m: up to {fastest} m/s, end at {} m", end.y);
        assert!(fastest < 3.0 && slow && low, "{x} m: {fastest} m/s, end at {} m", end.y);
    }
}
