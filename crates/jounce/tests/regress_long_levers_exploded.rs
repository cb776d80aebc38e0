//! Small bodies on joints far from their centres: a blow leaves a spin whose way bends by more than a substep can have, and what was asked
//! for to take that back was up to ten times too much: 9 J became 4 kJ, 182 J became 796 kJ.

mod common;

use common::rng::Rng;
use jounce::math::scalar::f64s;
use jounce::prelude::*;
use jounce::{AxisDesc, BallDesc, JointDesc, LimitDesc};

fn ground() -> World {
    let mut w = World::new(WorldDesc::default()).unwrap();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap();
    w
}

/// The most energy over the given time, against the start; and the largest gap at its end.
fn run(w: &mut World, joints: &[JointId], seconds: usize) -> (f64, f32) {
    let start = w.energy().total();
    let mut most = 0.0;
    for _ in 0..60 * seconds {
        w.step().unwrap();
        most = f64s::max(most, w.energy().total());
    }
    let gaps = joints.iter().map(|&j| w.joint(j).unwrap().gap());
    (most / start, gaps.fold(0.0, jounce::math::scalar::f32s::max))
}

fn shape(rng: &mut Rng, small: f32, large: f32) -> ShapeDesc {
    let r = |rng: &mut Rng| rng.float(small, large);
    let mass = rng.float(0.2, 2.0);
    match rng.below(3) {
        0 => ShapeDesc::cuboid([r(rng), r(rng), r(rng)]),
        1 => ShapeDesc::sphere(r(rng)),
        _ => ShapeDesc::capsule(r(rng), r(rng)),
    }
    .mass(mass)
}

/// Two to six bodies of 5 to 30 cm, joined midway between them, up to two metres from each.
#[test]
fn random_trees_with_long_levers_keep_their_energy() {
    let mut worst = (0.0, 0.0_f32);
    for seed in 0..150 {
        let mut rng = Rng::new(seed);
        let mut w = ground();
        let n = 2 + rng.below(5);
        let mut bodies: Vec<(BodyId, Vec3)> = Vec::new();
        let mut joints = Vec::new();
        for i in 0..n {
            let at = rng.vec3(2.0) + Vec3::Y * 2.5;
            let s = shape(&mut rng, 0.05, 0.3);
            let body =
                w.add_body(BodyDesc::dynamic().at(at.as_dvec3()).rotated(rng.quat()).shape(s)).unwrap();
            if i > 0 {
                let (other, place) = bodies[rng.below(i)];
                let middle = ((at + place) * 0.5).as_dvec3();
                let kind = match seed % 4 {
                    0 => JointKind::Ball(BallDesc {
                        cone: Some(rng.float(0.1, 1.5)),
                        twist: Some(LimitDesc::new(-rng.float(0.0, 1.5), rng.float(0.01, 1.5))),
                        friction: rng.float(0.0, 3.0),
                        ..BallDesc::default()
                    }),
                    1 => JointKind::Hinge(AxisDesc::FREE.limited(-rng.float(0.0, 1.5), rng.float(0.01, 1.5))),
                    2 => {
                        JointKind::Slider(AxisDesc::FREE.limited(-rng.float(0.0, 1.0), rng.float(0.01, 1.0)))
                    }
                    _ => JointKind::Fixed,
                };
                let frame = WorldPose::new(middle, rng.quat());
                joints.push(w.add_joint(JointDesc::new(other, body, frame, kind)).unwrap());
            }
            bodies.push((body, at));
        }
        let (energy, gap) = run(&mut w, &joints, 8);
        worst = (f64s::max(worst.0, energy), jounce::math::scalar::f32s::max(worst.1, gap));
        assert!(energy < 1.3 && gap < 0.02, "seed {seed}: {energy} of the energy at the start, gap {gap} m");
    }
    println!("at most {:.3} of the energy at the start, gaps of {:.1e} m at the end", worst.0, worst.1);
}

/// Worms of balls on narrow cones that fall from 10 m: the short ones are solved side by side, in `f32`.
#[test]
fn worms_fall_without_gain() {
    for n in [6, 11, 12, 30] {
        let mut w = ground();
        let along = DVec3::new(0.0, -0.866, -0.5) * 0.25;
        let place = |i: f64| DVec3::new(0.0, 16.0, 0.0) + along * i;
        let bodies: Vec<BodyId> = (0..n)
            .map(|i| {
                let shape = ShapeDesc::sphere(0.1).density(1000.0);
                w.add_body(BodyDesc::dynamic().at(place(i as f64)).shape(shape)).unwrap()
            })
            .collect();
        let joints: Vec<JointId> = (1..n)
            .map(|i| {
                let kind = JointKind::Ball(BallDesc {
                    cone: Some(0.087),
                    twist: Some(LimitDesc::new(-0.017, 0.017)),
                    ..BallDesc::default()
                });
                let frame = WorldPose::new(place(i as f64 - 0.5), Quat::IDENTITY);
                w.add_joint(JointDesc::new(bodies[i - 1], bodies[i], frame, kind)).unwrap()
            })
            .collect();
        let (energy, gap) = run(&mut w, &joints, 6);
        println!("{n}: {energy:.3} of the energy at the start, gap {gap:.1e} m");
        assert!(energy < 1.05 && gap < 0.02, "{n}: {energy}, {gap}");
    }
}
