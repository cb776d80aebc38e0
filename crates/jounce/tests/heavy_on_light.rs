//! Heavy on light: a cube of 1,000 kg on cubes of 1 kg. The plain soft step sinks by 0.3 m here.

use jounce::prelude::*;

/// Depth of the highest cube below its ideal height after 10 s, metres.
fn sink(heavy: f32, light: usize) -> f64 {
    let mut world = World::new(WorldDesc::default()).expect("defaults are valid");
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).expect("ground");
    let mut top = None;
    for i in 0..=light {
        let mass = if i == light { heavy } else { 1.0 };
        let cube = ShapeDesc::cuboid([0.5; 3]).mass(mass);
        let desc = BodyDesc::dynamic().at([0.0, 0.5 + i as f64, 0.0]).can_sleep(false).shape(cube);
        top = Some(world.add_body(desc).expect("a cube"));
    }
    for _ in 0..600 {
        world.step().expect("steps");
    }
    0.5 + light as f64 - world.body(top.expect("cubes")).expect("alive").position().y
}

#[test]
fn a_thousand_to_one_sinks_less_than_a_centimetre() {
    for heavy in [20.0, 100.0, 1_000.0, 10_000.0] {
        let s = sink(heavy, 1);
        println!("{heavy} kg on 1 kg: {:.1} mm", 1e3 * s);
        assert!(s.abs() < 0.010, "{heavy} kg on 1 kg: {s} m");
    }
}

#[test]
fn weights_stay_true_under_a_heavy_load() {
    // The squeezed body's inertia is raised, its weight is not: the ground carries 1,001 kg.
    let mut world = World::new(WorldDesc::default()).expect("defaults are valid");
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).expect("ground");
    for (i, mass) in [1.0, 1000.0].into_iter().enumerate() {
        let cube = ShapeDesc::cuboid([0.5; 3]).mass(mass);
        let desc = BodyDesc::dynamic().at([0.0, 0.5 + i as f64, 0.0]).can_sleep(false).shape(cube);
        world.add_body(desc).expect("a cube");
    }
    for _ in 0..600 {
        world.step().expect("steps");
    }
    let p0 = world.momentum().linear.y;
    world.set_gravity(Vec3::ZERO).expect("finite");
    world.step().expect("steps");
    // Without gravity the contacts' last impulses lift the pair by at most one substep's weight.
    let gained = world.momentum().linear.y - p0;
    assert!(gained.abs() < 1001.0 * 9.81 / 60.0, "{gained} N s");
}

/// Bodies in one place squeeze one another by a hundred times their weight, but carry nothing: they fall, and keep their momentum. (As
/// treated bodies they hung in the air.)
#[test]
fn bodies_that_squeeze_one_another_fall() {
    let box_of = |half: [f32; 3], mass: f32, y: f32| ShapeDesc::cuboid(half).mass(mass).at([0.0, y, 0.0]);
    let one = vec![box_of([0.8, 0.3, 2.0], 1300.0, 0.0)];
    let two = vec![box_of([0.8, 0.3, 2.0], 1300.0, 0.0), box_of([0.7, 0.3, 1.0], 10.0, 0.5)];
    let four = vec![
        box_of([0.8, 0.3, 2.0], 800.0, 0.0),
        box_of([0.7, 0.3, 1.0], 100.0, 0.5),
        box_of([0.2, 0.6, 0.3], 200.0, -0.4),
        box_of([1.2, 0.1, 0.2], 100.0, 0.2),
    ];
    for (count, parts) in [(2, &two), (5, &two), (5, &four), (12, &one), (12, &four)] {
        let mut world = World::new(WorldDesc::default()).expect("defaults are valid");
        for i in 0..count {
            let at = [0.03 * f64::from(i % 4), 0.02 * f64::from(i % 3), 0.03 * f64::from(i / 4)];
            let body = parts.iter().fold(BodyDesc::dynamic().at(at), |b, s| b.shape(s.clone()));
            world.add_body(body).expect("a body");
        }
        let mass: f64 = world.bodies().map(|b| f64::from(world.body(b).expect("alive").mass())).sum();
        for step in 1..=240 {
            world.step().expect("steps");
            let p = world.momentum().linear;
            let fallen = DVec3::new(0.0, -mass * 9.81 * f64::from(step) / 60.0, 0.0);
            let off = (p - fallen).length() / (mass * 9.81);
            assert!(off < 1e-3, "{count} of {} shapes, step {step}: {p:?} for {fallen:?}", parts.len());
        }
    }
}
