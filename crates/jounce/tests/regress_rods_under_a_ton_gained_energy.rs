//! Rods and ropes between masses of up to 1,000 to 1 that swing: the light bodies were flung about by the load, crossed what was taut in a few
//! substeps, and the load was asked to make room for them: chains gained up to 6,000 times m g l.

mod common;

use common::rng::Rng;
use jounce::JointDesc;
use jounce::math::scalar::{f32s, f64s};
use jounce::prelude::*;

/// Balls that touch nothing, on rods or ropes of random directions and lengths, let go. Gives the most energy gained, and the most that a
/// joint was off.
fn swing(masses: &[f32], rope: bool, seed: u64) -> (f64, f32) {
    let mut rng = Rng::new(seed);
    let mut w = World::new(WorldDesc::default()).unwrap();
    let mut last = w.add_body(BodyDesc::fixed()).unwrap();
    let (mut at, mut joints) = (DVec3::ZERO, Vec::new());
    let mut scale = 0.0;
    for &m in masses {
        let dir = [rng.float(-1.0, 1.0), rng.float(-0.3, 0.0), rng.float(-1.0, 1.0)].map(f64::from);
        let dir: DVec3 = dir.into();
        let next = at + dir * (f64::from(rng.float(0.3, 1.2)) / dir.length());
        let filter = Filter { mask: 0, ..Filter::default() };
        let shape = ShapeDesc { filter, ..ShapeDesc::sphere(0.05).mass(m) };
        let body = w.add_body(BodyDesc::dynamic().at(next).can_sleep(false).shape(shape)).unwrap();
        let length = (next - at).length() as f32;
        joints.push(
            w.add_joint(if rope {
                JointDesc::rope(last, body, at, next, length)
            } else {
                JointDesc::rod(last, body, at, next)
            })
            .unwrap(),
        );
        scale += f64::from(m) * 9.81;
        (last, at) = (body, next);
    }
    let start = w.energy().total();
    let (mut most, mut gap) = (start, 0.0);
    for _ in 0..8 * 60 {
        w.step().unwrap();
        most = f64s::max(most, w.energy().total());
        gap = joints.iter().map(|&j| w.joint(j).unwrap().gap()).fold(gap, f32s::max);
    }
    ((most - start) / scale, gap)
}

#[test]
fn light_bodies_on_rods_and_ropes_do_not_feed_the_load() {
    let chains: [&[f32]; 7] = [
        &[1.0, 30.0, 1000.0],
        &[1.0, 1000.0],
        &[1.0, 1.0, 1000.0],
        &[30.0, 1.0, 1000.0],
        &[1000.0, 1.0, 1000.0],
        &[1.0, 100.0],
        &[1.0, 10.0, 100.0],
    ];
    for masses in chains {
        for rope in [false, true] {
            let (mut gain, mut gap) = (0.0, 0.0);
            for seed in 1..=6 {
                let (g, d) = swing(masses, rope, seed);
                (gain, gap) = (f64s::max(gain, g), f32s::max(gap, d));
            }
            println!("{masses:?} kg, ropes: {rope}: gains {gain:.3} m of height, gap {gap:.4} m");
            assert!(gain < 0.05, "{masses:?} kg, ropes: {rope}: gains {gain} m of height");
            assert!(gap < 0.25, "{masses:?} kg, ropes: {rope}: gap {gap} m");
        }
    }
}
