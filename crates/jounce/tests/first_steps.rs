//! The first things anyone tries.

use jounce::prelude::*;

fn ground(world: &mut World) {
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).expect("a half-space");
}

#[test]
fn a_box_falls_and_rests_on_the_ground() {
    let mut world = World::new(WorldDesc::default()).expect("defaults are valid");
    ground(&mut world);
    let b = world
        .add_body(BodyDesc::dynamic().at([0.0, 2.0, 0.0]).shape(ShapeDesc::cuboid([0.5; 3])))
        .expect("a box");
    for _ in 0..300 {
        world.step().expect("steps");
    }
    let body = world.body(b).expect("alive");
    assert!((body.position().y - 0.5).abs() < 5e-3, "{:?}", body.position());
    assert!(!body.is_awake(), "a box at rest sleeps");
}

#[test]
fn twenty_boxes_stand_for_ten_minutes() {
    let mut world = World::new(WorldDesc::default()).expect("valid");
    ground(&mut world);
    let mut ids = Vec::new();
    for i in 0..20 {
        let at = [0.0, 0.5 + f64::from(i), 0.0];
        ids.push(
            world.add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid([0.5; 3]))).expect("a box"),
        );
    }
    let places = |world: &World| -> Vec<DVec3> {
        ids.iter().map(|&id| world.body(id).expect("alive").position()).collect()
    };
    for _ in 0..300 {
        world.step().expect("steps");
    }
    let settled = places(&world);
    for _ in 300..36_000 {
        world.step().expect("steps");
    }
    for (i, (a, b)) in settled.iter().zip(places(&world)).enumerate() {
        assert!(a.distance(b) < 1e-3, "box {i} went from {a:?} to {b:?}");
    }
}

#[test]
fn threads_do_not_change_bits() {
    let run = |tasks: Tasks| {
        let mut world = World::new(WorldDesc::default()).expect("defaults are valid");
        world.set_tasks(tasks);
        ground(&mut world);
        for i in 0..60 {
            let f = f64::from(i);
            let at = [(f * 0.37) % 2.0, 0.6 + 0.7 * f, (f * 0.61) % 2.0];
            let shape = match i % 3 {
                0 => ShapeDesc::cuboid([0.3, 0.2, 0.4]),
                1 => ShapeDesc::sphere(0.3).restitution(0.5),
                _ => ShapeDesc::capsule(0.2, 0.2),
            };
            world.add_body(BodyDesc::dynamic().at(at).shape(shape)).expect("a body");
        }
        let mut hashes = Vec::new();
        for _ in 0..240 {
            world.step().expect("steps");
            hashes.push(world.hash());
        }
        hashes
    };
    let one = run(Tasks::serial());
    for tasks in [Tasks::pool(2), Tasks::pool(4), Tasks::chaos(1), Tasks::chaos_pool(3, 2)] {
        assert_eq!(one, run(tasks));
    }
}
