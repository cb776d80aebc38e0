//! Continuous collision stopped a fast bone where it met the ground, alone: the joint to its neighbour, which went on, was torn by the
//! way that the bone gave up, v Δt, up to 0.2 m in a ragdoll that fell. Bodies that hang together stop together now.

use jounce::math::scalar::f32s;
use jounce::prelude::*;

#[test]
fn a_fast_chain_meets_the_ground_in_one_piece() {
    let mut w = World::new(WorldDesc::default()).unwrap();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap();
    let mut last: Option<BodyId> = None;
    let mut joints = Vec::new();
    for i in 0..4 {
        let y = 1.0 + 0.4 * f64::from(i);
        let link = BodyDesc::dynamic().at([0.0, y, 0.0]).velocity([1.0, -15.0, 0.0]);
        let link = w.add_body(link.shape(ShapeDesc::capsule(0.15, 0.03))).unwrap();
        if let Some(last) = last {
            joints.push(w.add_joint(JointDesc::ball(last, link, [0.0, y - 0.2, 0.0])).unwrap());
        }
        last = Some(link);
    }
    let mut gap = 0.0;
    for _ in 0..120 {
        w.step().unwrap();
        gap = joints.iter().fold(gap, |g, &j| f32s::max(g, w.joint(j).unwrap().gap()));
    }
    // What a ragdoll is held to. One that stops alone gives up as much as 15/60 m.
    assert!(gap < 0.01, "{gap} m");
}
