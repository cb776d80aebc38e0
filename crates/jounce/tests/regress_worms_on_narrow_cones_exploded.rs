//! Worms of thirty balls on cones of 0.3° to 3° buckled and flew apart: 1.2 kJ became 1 MJ. A substep crosses such a cone, so its rim has to be
//! met where the substep leads; the active set went round in circles; and what its rounds take back was counted as what a pass may give.

use jounce::math::scalar::f64s;
use jounce::prelude::*;
use jounce::{BallDesc, JointDesc, JointKind};

/// Balls of 10 cm and 4.2 kg on one another's poles; `up` or along x.
fn worm(n: usize, degrees: f32, up: bool, push: f32) -> World {
    let mut w = World::new(WorldDesc::default()).unwrap();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap();
    let (axis, first) = if up { (Vec3::Y, [0.0, 0.3, 0.0]) } else { (Vec3::X, [0.0, 1.0, 0.0]) };
    if !up {
        let post = ShapeDesc::cuboid(Vec3::new(0.1, 0.3, 1.0));
        w.add_body(BodyDesc::fixed().at([2.0, 0.3, 0.0]).shape(post)).unwrap();
    }
    let place = |s: f64| [0, 1, 2].map(|i| first[i] + s * f64::from(axis[i]));
    let bodies: Vec<BodyId> = (0..n)
        .map(|i| {
            let d = BodyDesc::dynamic().at(place(0.2 * i as f64)).velocity(Vec3::X * push);
            w.add_body(d.shape(ShapeDesc::sphere(0.1))).unwrap()
        })
        .collect();
    for (i, pair) in bodies.windows(2).enumerate() {
        let mut d = JointDesc::hinge(pair[0], pair[1], place(0.2 * i as f64 + 0.1), axis);
        d.kind = JointKind::Ball(BallDesc { cone: Some(degrees.to_radians()), ..BallDesc::default() });
        w.add_joint(d).unwrap();
    }
    w
}

#[test]
fn worms_keep_their_energy_and_lie_down() {
    let worms = [
        (30, 0.3, true, 1.0),
        (30, 1.0, true, 1.0),
        (40, 0.3, true, 0.3),
        (40, 1.0, true, 1.0),
        (60, 2.0, true, 1.0),
        (30, 1.0, false, 0.0),
        (30, 3.0, false, 0.0),
    ];
    for (n, degrees, up, push) in worms {
        let mut w = worm(n, degrees, up, push);
        let start = w.energy().total();
        let (mut most, mut fastest): (f64, f64) = (start, 0.0);
        for _ in 0..60 * 8 {
            w.step().unwrap();
            let e = w.energy();
            most = f64s::max(most, e.total());
            fastest = f64s::max(fastest, e.kinetic);
        }
        let end = w.energy().total();
        println!(
            "{n} on {degrees}°, up {up}: {start:.0} J, at most {most:.0}, kinetic {fastest:.0}, ends with {end:.0}"
        );
        assert!(most < 1.005 * start + 1.0, "{n} on {degrees}°, up {up}: {most} J of {start}");
        // It did fall.
        assert!(fastest > 0.2 * start && end < 0.6 * start, "{n} on {degrees}°, up {up}: {fastest}, {end}");
    }
}
