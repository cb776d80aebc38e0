//! A ball that rolled or slid along the seam of two tiles was bumped: the edge's normal leans towards the ball by less
//! than a degree there, and such small leanings were left alone. At 5 m/s a degree is 9 cm/s.

use jounce::math::scalar::f32s;
use jounce::prelude::*;

#[test]
fn a_ball_slides_along_seams_without_a_bump() {
    let mut world = World::new(WorldDesc::default()).expect("defaults are valid");
    for i in 0..24 {
        for j in 0..6 {
            let tile = ShapeDesc::cuboid([0.5; 3]).friction(0.0);
            let at = [f64::from(i) - 1.5, -0.5, f64::from(j) - 1.5];
            world.add_body(BodyDesc::fixed().at(at).shape(tile)).expect("a tile");
        }
    }
    let (sin, cos) = (0.17_f32, 0.985_44_f32);
    let ball = BodyDesc::dynamic().at([0.3, 0.5, 0.4]).velocity([5.0 * cos, 0.0, 5.0 * sin]);
    let ball = world.add_body(ball.shape(ShapeDesc::sphere(0.5).friction(0.0))).expect("a ball");
    let mut most = 0.0;
    for step in 0..230 {
        world.step().expect("steps");
        let v = world.body(ball).expect("alive").velocity();
        if step > 20 {
            let side = (v.x * sin - v.z * cos).abs();
            most = f32s::max(most, f32s::max(v.y.abs(), side));
        }
    }
    assert!(most < 1e-3, "bumped to {most} m/s");
}
