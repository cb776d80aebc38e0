//! A point that attracts with all that the door lets pass (μ = 1e30 m³/s²), or bodies that attract one another so, pulled with
//! more than an f32 holds. The infinite acceleration met the contacts of the step, and up to 22 bodies of a heap were
//! quarantined by one. Components of what fields accelerate by are bounded now
//! ([`jounce::limits::FIELD_ACCELERATION_MAX`]); speeds meet their own limit. A hook that gives no number at all takes out its own
//! body only.

use jounce::prelude::*;

fn heap() -> (World, Vec<BodyId>) {
    let mut world = World::new(WorldDesc::default()).expect("valid");
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).expect("valid");
    let one = |i: u32| {
        let at = [f64::from(i % 3), 0.5 + f64::from(i / 9), f64::from(i / 3 % 3)];
        BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid([0.5; 3]))
    };
    let all = (0..27).map(|i| world.add_body(one(i)).expect("valid")).collect();
    (world, all)
}

fn taken_out(mut world: World) -> usize {
    let mut out = 0;
    for _ in 0..120 {
        world.step().expect("steps");
        out += world.events().iter().filter(|e| matches!(e, Event::Quarantine { .. })).count();
    }
    out
}

#[test]
fn nobody_is_taken_out_by_a_pull_without_bound() {
    for center in [[1.0, 1.5, 1.0], [1.0, 1.500_000_1, 1.0], [9.0, 0.1, 0.0]] {
        let (mut world, _) = heap();
        let law = FieldLaw::Point { center: center.into(), mu: 1e30, softening: 0.0 };
        world.add_field(FieldDesc::new(law)).expect("within the limits");
        assert_eq!(taken_out(world), 0, "{center:?}");
    }
    let (mut world, bodies) = heap();
    world
        .add_field(FieldDesc::new(FieldLaw::NBody { bodies, g: 1e20, softening: 0.0 }))
        .expect("within the limits");
    assert_eq!(taken_out(world), 0);
}

#[test]
fn a_hook_without_a_number_takes_out_its_own_body_only() {
    let (mut world, all) = heap();
    let victim = all[4].to_bits();
    let hook: jounce::FieldHook = std::sync::Arc::new(move |v| {
        if v.body.is_some_and(|b| b.to_bits() == victim) { Vec3::splat(f32::NAN) } else { Vec3::ZERO }
    });
    world.set_field_hook("no number", Some(hook));
    world.add_field(FieldDesc::new(FieldLaw::User { hook: "no number".to_owned() })).expect("registered");
    assert_eq!(taken_out(world), 1);
}
