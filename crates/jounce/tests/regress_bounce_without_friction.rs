//! Friction of a bounce was bounded by the impulse that stopped the approach alone; the impulse that throws the body back
//! bears friction as well: Δv_t = μ (1 + e) v_n (Coulomb).

use jounce::AxisLocks;
use jounce::prelude::*;

#[test]
fn a_bounce_is_braked_by_both_halves_of_its_impulse() {
    let mut world = World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() })
        .expect("a world without gravity");
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).friction(0.2))).expect("ground");
    let body = BodyDesc::dynamic().at([0.0, 1.0, 0.0]).velocity([3.0, -4.0, 0.0]).locks(AxisLocks::ROTATION);
    let shape = ShapeDesc::cuboid([0.5; 3]).friction(0.2).restitution(0.5);
    let body = world.add_body(body.shape(shape)).expect("a box");
    for _ in 0..30 {
        world.step().expect("steps");
    }
    let v = world.body(body).expect("alive").velocity();
    assert!((v.x - (3.0 - 0.2 * 1.5 * 4.0)).abs() < 1e-4, "{v:?}");
    assert!((v.y - 2.0).abs() < 1e-4, "{v:?}");
}
