//! A kinematic body sent 1e6 m away by `move_to` was there after one step, and yet an event said that it had been held to the
//! speed limit.

mod support;

use jounce::prelude::*;
use support::*;

#[test]
fn a_body_that_arrives_was_not_held() {
    let mut w = world();
    let b = w.add_body(BodyDesc::kinematic().shape(ShapeDesc::cuboid([0.5; 3]))).expect("a platform");
    let there = DVec3::new(1e6, 0.0, 0.0);
    let half_turn = Quat::from_axis_angle(Vec3::Y, 3.0);
    w.move_to(b, there, half_turn).expect("kinematic");
    w.step().expect("steps");
    let seen = w.body(b).expect("alive");
    assert_eq!((seen.position(), seen.rotation()), (there, half_turn));
    // As documented: the velocity that contacts saw, within the limits.
    let most = w.settings().linear_speed_max;
    assert!(seen.velocity().length() <= most * 1.0001, "{:?}", seen.velocity());
    assert_eq!(w.events(), []);
    w.step().expect("steps");
    assert_eq!((w.body(b).expect("alive").velocity(), w.events()), (Vec3::ZERO, &[][..]));
    // Told a velocity, it is held, and that is told.
    w.set_velocity(b, Vec3::X * 1e3).expect("kinematic");
    w.step().expect("steps");
    assert_eq!(w.events(), [Event::SpeedLimited { body: b }]);
    let moved = w.body(b).expect("alive").position().x - there.x;
    assert!((moved - f64::from(most) / 60.0).abs() < 1e-3, "{moved} m");
}
