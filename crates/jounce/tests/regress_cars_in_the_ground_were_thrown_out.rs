//! A car that began metres below the ground came up through it by contacts, at 3 m/s; as soon as its wheels saw the ground, tyres and bump
//! stops half a metre deep threw it out at up to 114 m/s. Depth that a wheel did not come to by moving now gives no force, and goes at the
//! speed at which contacts push out. A board met its springs the same way.

use jounce::Settings;
use jounce::math::scalar::{f32s, f64s};
use jounce::prelude::*;
use jounce::vehicles::{self, VehicleKit};

fn fastest(kit: &VehicleKit, ground: ShapeDesc, depth: f64, turned: Quat) -> (f32, f64) {
    let mut w = World::new(WorldDesc::default()).unwrap();
    w.add_body(BodyDesc::fixed().shape(ground)).unwrap();
    let v = kit.clone().add(&mut w, [0.0, -depth, 0.0], turned).unwrap();
    let b = w.vehicle(v).unwrap().chassis();
    let (mut most, mut high) = (0.0, -depth);
    for _ in 0..600 {
        w.step().unwrap();
        let r = w.body(b).unwrap();
        most = f32s::max(most, r.velocity().y);
        high = f64s::max(high, r.pose().p.y);
    }
    (most, high)
}

#[test]
fn what_is_in_the_ground_comes_out_slowly() {
    let push_out = Settings::default().push_out_speed;
    for (name, kit) in [
        ("car", vehicles::car()),
        ("off-road", vehicles::off_road()),
        ("motorcycle", vehicles::motorcycle()),
        ("snowboard", vehicles::snowboard()),
    ] {
        for depth in [0.1, 0.3, 0.6, 1.0, 2.0, 5.0] {
            for (ground, shape) in [
                ("plane", ShapeDesc::half_space(Vec3::Y)),
                ("box", ShapeDesc::cuboid([50.0, 10.0, 50.0]).at([0.0, -10.0, 0.0])),
            ] {
                let (most, high) = fastest(&kit, shape, depth, Quat::IDENTITY);
                println!("{name} {depth} m in the {ground}: {most:.2} m/s, up to {high:.2} m");
                // The springs' part of a push-out, and the height that such a speed gives.
                assert!(most < 2.0 * push_out, "{name} {depth} m in the {ground}: {most} m/s");
                assert!(high < 2.0, "{name} {depth} m in the {ground}: {high} m");
            }
        }
    }
}

#[test]
fn a_board_on_its_edge_is_not_thrown() {
    for degrees in [30.0_f32, 60.0, 80.0] {
        let kit = vehicles::snowboard();
        let turned = Quat::from_axis_angle(Vec3::Z, degrees.to_radians());
        let (most, high) = fastest(&kit, ShapeDesc::half_space(Vec3::Y), 0.1, turned);
        println!("{degrees}°: {most:.2} m/s, up to {high:.2} m");
        assert!(most < 2.0 * Settings::default().push_out_speed, "{degrees}°: {most} m/s");
    }
}

#[test]
fn ten_cars_in_one_place_part_slowly() {
    // The mean of some arrangements, millimetres apart: each is chaotic.
    let mean = |on: bool| (0..8).map(|k| ten_cars(on, 1e-3 * f64::from(k))).sum::<f32>() / 8.0;
    let (without, with) = (mean(false), mean(true));
    println!("at most {without:.2} m/s without wheels, {with:.2} m/s with them");
    // Ten chassis of two boxes each, all in one place, are thrown apart by their contacts; wheels do not add to that.
    assert!(with <= without, "{with} m/s with wheels, {without} m/s without");
}

fn ten_cars(on: bool, apart: f64) -> f32 {
    let mut w = World::new(WorldDesc::default()).unwrap();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap();
    let cars: Vec<_> = (0..10)
        .map(|i| {
            let v = vehicles::car().add(&mut w, [apart * f64::from(i), 0.0, 0.0], Quat::IDENTITY).unwrap();
            w.set_vehicle_enabled(v, on).unwrap();
            w.vehicle(v).unwrap().chassis()
        })
        .collect();
    let mut most = 0.0;
    for _ in 0..600 {
        w.step().unwrap();
        for &b in &cars {
            most = f32s::max(most, w.body(b).unwrap().velocity().length());
        }
    }
    println!("{apart}: {most} m/s");
    most
}
