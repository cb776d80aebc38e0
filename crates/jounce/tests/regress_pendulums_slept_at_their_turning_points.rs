//! A ton on a chain fell asleep centimetres off plumb. Bodies on joints were taken for resting where they were slower than the speed of
//! sleep, 0.05 m/s, for half a second; at its turning point a long pendulum is that slow for as long, and its load hung askew from then on.

use jounce::prelude::*;

/// Hangs plumb, and swings by so much.
fn pendulum(w: &mut World, length: f64, off: f64, damping: f32) -> BodyId {
    let post = w.add_body(BodyDesc::fixed()).expect("valid");
    let speed = (off * (9.81 / length).sqrt()) as f32;
    let bob = BodyDesc { linear_damping: damping, ..BodyDesc::dynamic() };
    let bob = bob.at([0.0, -length, 0.0]).velocity([speed, 0.0, 0.0]);
    let bob = w.add_body(bob.shape(ShapeDesc::sphere(0.1).mass(10.0))).expect("valid");
    w.add_joint(JointDesc::ball(post, bob, [0.0; 3])).expect("valid");
    bob
}

#[test]
fn a_swinging_pendulum_stays_awake() {
    for (length, off) in [(3.0, 0.06), (3.0, 0.04), (10.0, 0.12), (1.0, 0.025)] {
        let mut w = World::new(WorldDesc::default()).expect("valid");
        let bob = pendulum(&mut w, length, off, 0.0);
        for i in 0..1200 {
            w.step().expect("steps");
            assert!(w.body(bob).expect("alive").is_awake(), "{length} m by {off} m: asleep after {i} steps");
        }
    }
}

#[test]
fn one_that_came_to_rest_sleeps_near_plumb() {
    let mut w = World::new(WorldDesc::default()).expect("valid");
    let bob = pendulum(&mut w, 3.0, 0.5, 0.5);
    while w.body(bob).expect("alive").is_awake() {
        w.step().expect("steps");
        assert!(w.time() < 30.0, "still awake");
    }
    let off = w.body(bob).expect("alive").position().x;
    assert!(off.abs() < 0.035, "asleep {off} m off plumb");
}
