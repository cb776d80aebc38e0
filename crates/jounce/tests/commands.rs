//! Each command does what it says, is refused when it cannot, and handles that went stale stay stale.

mod support;

use jounce::geometry::{MassProperties, Shape};
use jounce::math::Mat3;
use jounce::prelude::*;
use jounce::{BodyRef, Command, Error, Output, Settings};
use support::*;

fn body(w: &World, b: BodyId) -> BodyRef<'_> {
    w.body(b).expect("alive")
}

fn shape_of(w: &World, b: BodyId) -> ShapeId {
    body(w, b).shapes().next().expect("a shape")
}

fn floating() -> (World, BodyId) {
    let mut w = world();
    w.set_gravity(Vec3::ZERO).expect("valid");
    let b = w
        .add_body(BodyDesc::dynamic().can_sleep(false).shape(ShapeDesc::cuboid([0.5; 3]).mass(2.0)))
        .expect("a box");
    (w, b)
}

#[test]
fn teleport_puts_the_body_there_without_interpolation() {
    let (mut w, b) = floating();
    w.set_velocity(b, Vec3::X).expect("alive");
    step(&mut w, 3);
    let (p, q) = (DVec3::new(4.0, 5.0, 6.0), Quat::from_axis_angle(Vec3::Y, 1.0));
    w.teleport(b, p, q).expect("valid");
    let r = body(&w, b);
    assert!(r.position().distance(p) < 1e-6 && r.interpolated_pose(0.0).p.distance(p) < 1e-6);
    assert_eq!(r.velocity(), Vec3::X, "the velocity is kept");
    assert!((r.rotation().dot(q) - 1.0).abs() < 1e-6);
}

#[test]
fn a_kinematic_body_is_at_its_target_after_one_step_and_stays() {
    let mut w = world();
    let k = w.add_body(BodyDesc::kinematic().shape(ShapeDesc::cuboid([1.0; 3]))).expect("a platform");
    let (p, q) = (DVec3::new(0.1, 0.2, -0.1), Quat::from_axis_angle(Vec3::Z, 0.1));
    w.move_to(k, p, q).expect("kinematic");
    step(&mut w, 1);
    assert!(body(&w, k).position().distance(p) < 1e-5, "{:?}", body(&w, k).position());
    assert!((body(&w, k).rotation().dot(q).abs() - 1.0).abs() < 1e-5);
    assert!((body(&w, k).velocity().x - 6.0).abs() < 1e-3, "it pushes with the speed of its motion");
    step(&mut w, 5);
    assert!(body(&w, k).position().distance(p) < 1e-5, "and then it stops");
    let (mut w, b) = floating();
    assert!(matches!(w.move_to(b, p, q), Err(Error::Unsupported { .. })));
}

#[test]
fn forces_last_one_step_and_impulses_act_at_once() {
    let (mut w, b) = floating();
    w.add_force(b, Vec3::new(120.0, 0.0, 0.0), None).expect("alive");
    assert_eq!(body(&w, b).velocity(), Vec3::ZERO);
    step(&mut w, 1);
    assert!((body(&w, b).velocity().x - 1.0).abs() < 1e-5, "F dt / m = 1");
    step(&mut w, 5);
    assert!((body(&w, b).velocity().x - 1.0).abs() < 1e-5, "the force is gone");
    w.add_impulse(b, Vec3::new(0.0, 4.0, 0.0), None).expect("alive");
    assert!((body(&w, b).velocity().y - 2.0).abs() < 1e-6, "J / m = 2, at once");

    // I = m a² / 6 = 1/3 for a cube of 1 m and 2 kg.
    let (mut w, b) = floating();
    w.add_torque(b, Vec3::new(0.0, 20.0, 0.0)).expect("alive");
    step(&mut w, 1);
    assert!((body(&w, b).angular_velocity().y - 1.0).abs() < 1e-4, "T dt / I = 1");
    w.add_angular_impulse(b, Vec3::new(0.0, 1.0, 0.0)).expect("alive");
    assert!((body(&w, b).angular_velocity().y - 4.0).abs() < 1e-4, "+ L / I = 3");
    let (mut w, b) = floating();
    w.add_impulse(b, Vec3::new(0.0, 0.0, 2.0), Some(DVec3::new(0.5, 0.0, 0.0))).expect("alive");
    let r = body(&w, b);
    assert!((r.velocity().z - 1.0).abs() < 1e-6 && (r.angular_velocity().y + 3.0).abs() < 1e-4, "r × J = −1");
    let (mut w, b) = floating();
    w.add_force(b, Vec3::new(0.0, 0.0, 120.0), Some(DVec3::new(0.5, 0.0, 0.0))).expect("alive");
    step(&mut w, 1);
    assert!((body(&w, b).angular_velocity().y + 3.0).abs() < 1e-3);
}

#[test]
fn kinds_change() {
    let mut w = world();
    ground(&mut w);
    let b = add_box(&mut w, [0.0, 3.0, 0.0], 0.5);
    let m = body(&w, b).mass();
    w.set_kind(b, BodyKind::Fixed).expect("valid");
    step(&mut w, 30);
    assert_eq!((body(&w, b).position().y, body(&w, b).mass()), (3.0, 0.0));
    assert!(matches!(w.set_velocity(b, Vec3::X), Err(Error::Unsupported { .. })));
    w.set_kind(b, BodyKind::Kinematic).expect("valid");
    w.set_velocity(b, Vec3::X).expect("kinematic");
    step(&mut w, 60);
    let p = body(&w, b).position();
    assert!((p.x - 1.0).abs() < 1e-4 && p.y == 3.0, "{p:?}");
    w.set_kind(b, BodyKind::Dynamic).expect("valid");
    assert_eq!(body(&w, b).mass(), m);
    step(&mut w, 120);
    assert!((body(&w, b).position().y - 0.5).abs() < 0.02, "it falls again");
    let plane = w.bodies().next().expect("the ground");
    assert!(matches!(w.set_kind(plane, BodyKind::Dynamic), Err(Error::Unsupported { .. })));
}

#[test]
fn disabled_bodies_and_shapes_are_not_there() {
    let mut w = world();
    ground(&mut w);
    let b = add_box(&mut w, [0.0, 2.0, 0.0], 0.5);
    let s = shape_of(&w, b);
    w.set_body_enabled(b, false).expect("alive");
    step(&mut w, 30);
    assert_eq!(body(&w, b).position().y, 2.0);
    assert!(!body(&w, b).is_enabled() && !body(&w, b).is_awake());
    w.set_body_enabled(b, true).expect("alive");
    w.set_shape_enabled(s, false).expect("alive");
    assert!(!w.shape(s).expect("alive").is_enabled());
    step(&mut w, 90);
    assert!(body(&w, b).position().y < -1.0, "without its shape it falls through the ground");
    w.teleport(b, DVec3::new(0.0, 2.0, 0.0), Quat::IDENTITY).expect("alive");
    w.set_velocity(b, Vec3::ZERO).expect("alive");
    w.set_shape_enabled(s, true).expect("alive");
    step(&mut w, 120);
    assert!((body(&w, b).position().y - 0.5).abs() < 0.02);
}

#[test]
fn shapes_are_swapped_moved_added_and_removed() {
    let mut w = world();
    ground(&mut w);
    let b = add_box(&mut w, [0.0, 0.5, 0.0], 0.5);
    let s = shape_of(&w, b);
    step(&mut w, 120);
    w.set_shape(s, Shape::Box { half: Vec3::new(0.5, 1.0, 0.5) }).expect("valid");
    assert!((body(&w, b).mass() - 2000.0).abs() < 0.1, "twice the box, twice the mass");
    step(&mut w, 240);
    assert!((body(&w, b).position().y - 1.0).abs() < 0.02, "pushed out to its new size");
    w.set_shape(s, Shape::Box { half: Vec3::splat(0.5) }).expect("valid");
    w.set_shape_pose(s, Pose::from_translation(Vec3::new(0.0, 0.25, 0.0))).expect("valid");
    assert!((body(&w, b).mass_properties().center.y - 0.25).abs() < 1e-6);
    step(&mut w, 240);
    assert!((body(&w, b).position().y - 0.25).abs() < 0.02, "{}", body(&w, b).position().y);
    let t = w.add_shape(b, ShapeDesc::sphere(0.5).mass(500.0).at([0.0, 1.25, 0.0])).expect("valid");
    assert!((body(&w, b).mass() - 1500.0).abs() < 0.1);
    assert_eq!(body(&w, b).shapes().collect::<Vec<_>>(), [s, t]);
    w.remove_shape(s).expect("alive");
    assert!((body(&w, b).mass() - 500.0).abs() < 0.1);
    assert!(matches!(w.remove_shape(s), Err(Error::Stale { what: "shape", .. })));
}

#[test]
fn a_mass_override_counts_and_goes_back() {
    let (mut w, b) = floating();
    let m = MassProperties {
        mass: 10.0,
        center: Vec3::new(0.1, 0.0, 0.0),
        inertia: Mat3::from_diagonal(Vec3::splat(5.0)),
    };
    let before = body(&w, b).position();
    w.set_mass(b, Some(m)).expect("valid");
    assert_eq!(body(&w, b).mass_properties(), m);
    assert!(body(&w, b).position().distance(before) < 1e-6, "the origin stays");
    w.add_impulse(b, Vec3::new(20.0, 0.0, 0.0), None).expect("alive");
    assert!((body(&w, b).velocity().x - 2.0).abs() < 1e-6);
    w.add_angular_impulse(b, Vec3::new(0.0, 5.0, 0.0)).expect("alive");
    assert!((body(&w, b).angular_velocity().y - 1.0).abs() < 1e-6);
    w.set_mass(b, None).expect("valid");
    assert!((body(&w, b).mass() - 2.0).abs() < 1e-6);
}

/// I_x + I_y = I_z + 2 Σ m z² of all matter.
#[test]
fn moments_that_no_matter_has_are_refused() {
    let (mut w, b) = floating();
    let mass = |x, y, z| MassProperties {
        mass: 10.0,
        center: Vec3::ZERO,
        inertia: Mat3::from_diagonal(Vec3::new(x, y, z)),
    };
    for m in [mass(1.0, 1.0, 100.0), mass(3.0, 1.0, 1.0), mass(0.5, 2.0, 1.0)] {
        let told = w.set_mass(b, Some(m)).expect_err("refused").to_string();
        assert!(
            told.contains("mass.inertia is [[") && told.contains("above the sum of the other two"),
            "{told}"
        );
    }
    // A turned one, of principal moments 1, 1 and 3.
    let turned = Mat3::from_columns(Vec3::new(2.0, 1.0, 0.0), Vec3::new(1.0, 2.0, 0.0), Vec3::Z);
    assert!(w.set_mass(b, Some(MassProperties { inertia: turned, ..mass(1.0, 1.0, 1.0) })).is_err());
    // A plate, a rod, and numbers of two digits.
    for m in [mass(1.0, 2.0, 3.0), mass(1e-3, 1.0, 1.0), mass(0.33, 0.33, 0.665)] {
        w.set_mass(b, Some(m)).expect("valid");
    }
}

#[test]
fn locks_damping_and_gravity_scale() {
    let (mut w, b) = floating();
    w.set_locks(b, AxisLocks::PLANE_XY).expect("alive");
    w.add_impulse(b, Vec3::ONE * 4.0, None).expect("alive");
    w.add_angular_impulse(b, Vec3::ONE).expect("alive");
    step(&mut w, 60);
    let r = body(&w, b);
    assert!((r.position().x - 2.0).abs() < 1e-3 && r.position().z.abs() < 1e-6, "{:?}", r.position());
    assert!(r.rotation().x.abs() + r.rotation().y.abs() < 1e-6 && r.rotation().z.abs() > 0.1);

    let (mut w, b) = floating();
    w.set_damping(b, 1.0, 2.0).expect("valid");
    assert_eq!(body(&w, b).damping(), (1.0, 2.0));
    w.set_velocity(b, Vec3::X).expect("alive");
    w.set_angular_velocity(b, Vec3::Y).expect("alive");
    step(&mut w, 60);
    // e⁻¹ and e⁻² after a second, to first order in the substep.
    let r = body(&w, b);
    assert!((r.velocity().x - 0.3679).abs() < 0.005, "{:?}", r.velocity());
    assert!((r.angular_velocity().y - 0.1353).abs() < 0.005, "{:?}", r.angular_velocity());

    let (mut w, b) = floating();
    w.set_gravity(Vec3::new(0.0, -10.0, 0.0)).expect("valid");
    w.set_gravity_scale(b, -0.5).expect("valid");
    step(&mut w, 60);
    assert!((body(&w, b).velocity().y - 5.0).abs() < 1e-3, "it rises");
}

#[test]
fn sleep_and_wake_by_hand() {
    let mut w = world();
    ground(&mut w);
    let b = add_box(&mut w, [0.0, 0.5, 0.0], 0.5);
    step(&mut w, 5);
    w.apply(Command::Sleep(b)).expect("alive");
    assert!(!body(&w, b).is_awake());
    step(&mut w, 5);
    assert!(!body(&w, b).is_awake());
    w.apply(Command::Wake(b)).expect("alive");
    assert!(body(&w, b).is_awake());
    w.apply(Command::SetCanSleep(b, false)).expect("alive");
    step(&mut w, 240);
    assert!(body(&w, b).is_awake());
    w.apply(Command::SetCanSleep(b, true)).expect("alive");
    step(&mut w, 240);
    assert!(!body(&w, b).is_awake());
    let still = Settings { sleep: false, ..Settings::default() };
    w.set_settings(still).expect("valid");
    assert!(body(&w, b).is_awake(), "new settings wake everything");
    step(&mut w, 240);
    assert!(body(&w, b).is_awake());
}

#[test]
fn names_numbers_materials_filters() {
    let (mut w, b) = floating();
    let s = shape_of(&w, b);
    w.set_name(b, Some("box".into())).expect("short");
    w.set_user_data(b, 42).expect("alive");
    assert_eq!((w.body_named("box"), body(&w, b).user_data()), (Some(b), 42));
    assert!(w.set_name(b, Some("x".repeat(257))).is_err());
    assert_eq!(body(&w, b).name(), Some("box"), "a refused command changes nothing");
    w.apply(Command::SetBullet(b, true)).expect("alive");
    assert!(body(&w, b).is_bullet());
    let m = Material { static_friction: 0.3, kinetic_friction: 0.2, ..Material::default() };
    w.set_material(s, m).expect("valid");
    assert_eq!(*w.shape(s).expect("alive").material(), m);
    let bad = Material { kinetic_friction: 0.4, ..m };
    assert!(w.set_material(s, bad).is_err(), "kinetic above static friction");
    assert_eq!(*w.shape(s).expect("alive").material(), m);
    let f = Filter { layers: 2, mask: 4, group: 0 };
    w.set_filter(s, f).expect("alive");
    assert_eq!(w.shape(s).expect("alive").filter(), f);
}

#[test]
fn the_queue_acts_at_the_next_step_in_order() {
    let (mut w, b) = floating();
    for v in [1.0, 2.0, 3.0] {
        w.queue(Command::SetVelocity(b, Vec3::X * v)).expect("room");
    }
    w.queue(Command::SetVelocity(BodyId::from_bits(77), Vec3::X)).expect("room: it is dropped later");
    w.queue(Command::AddImpulse(b, Vec3::X * 2.0, None)).expect("room");
    assert_eq!(body(&w, b).velocity(), Vec3::ZERO);
    step(&mut w, 1);
    assert_eq!(body(&w, b).velocity(), Vec3::X * 4.0);
    let new = w.apply(Command::AddBody(Box::new(BodyDesc::fixed()))).expect("valid");
    assert!(matches!(new, Output::Body(id) if w.body(id).is_ok()));
}

#[test]
fn stale_handles_are_refused_by_every_command() {
    let (mut w, b) = floating();
    let s = shape_of(&w, b);
    w.remove_body(b).expect("alive");
    let hash = w.hash();
    let (p, q) = (DVec3::ZERO, Quat::IDENTITY);
    use Command as C;
    let commands = [
        C::RemoveBody(b),
        C::AddShape(b, Box::new(ShapeDesc::sphere(1.0))),
        C::RemoveShape(s),
        C::Teleport(b, p, q),
        C::MoveTo(b, p, q),
        C::SetVelocity(b, Vec3::X),
        C::SetAngularVelocity(b, Vec3::X),
        C::AddForce(b, Vec3::X, None),
        C::AddTorque(b, Vec3::X),
        C::AddImpulse(b, Vec3::X, None),
        C::AddAngularImpulse(b, Vec3::X),
        C::SetKind(b, BodyKind::Fixed),
        C::SetBodyEnabled(b, true),
        C::SetDamping(b, 0.0, 0.0),
        C::SetGravityScale(b, 1.0),
        C::SetLocks(b, AxisLocks::NONE),
        C::SetMass(b, None),
        C::SetBullet(b, true),
        C::SetCanSleep(b, true),
        C::SetUserData(b, 1),
        C::SetName(b, None),
        C::Wake(b),
        C::Sleep(b),
        C::SetShape(s, Box::new(Shape::Sphere { radius: 1.0 })),
        C::SetShapePose(s, Pose::IDENTITY),
        C::SetShapeEnabled(s, true),
        C::SetMaterial(s, Material::default()),
        C::SetFilter(s, Filter::default()),
    ];
    for c in commands {
        let name = format!("{c:?}");
        assert!(matches!(w.apply(c), Err(Error::Stale { .. })), "{name}");
    }
    assert!(w.contacts_of(b).is_err() && w.contact_between(s, s).is_err());
    assert_eq!(w.hash(), hash, "nothing was changed");
}

#[test]
fn handles_agree_with_a_model() {
    let prove = std::env::var_os("JOUNCE_PROVE").is_some();
    let mut w = world();
    let mut r = Random::new(9);
    let (mut live, mut dead): (Vec<(BodyId, u128)>, Vec<BodyId>) = (Vec::new(), Vec::new());
    for i in 0..if prove { 1_000_000u128 } else { 20_000 } {
        match r.below(5) {
            0 | 1 if live.len() < 200 => {
                let desc = BodyDesc::fixed().user_data(i).shape(ShapeDesc::sphere(0.1));
                live.push((w.add_body(desc).expect("valid"), i));
            }
            2 if !live.is_empty() => {
                let (id, _) = live.swap_remove(r.below(live.len()));
                w.remove_body(id).expect("alive");
                dead.push(id);
            }
            3 if !live.is_empty() => {
                let (id, n) = live[r.below(live.len())];
                assert_eq!(body(&w, id).user_data(), n);
            }
            4 if !dead.is_empty() => {
                let id = dead[r.below(dead.len())];
                assert!(w.body(id).is_err() && w.remove_body(id).is_err(), "{id:?} came back to life");
            }
            _ => {}
        }
        assert_eq!(w.counts().bodies, live.len());
    }
    assert!(dead.len() > 1000);
    // Numbers that never were handles.
    for bits in [0, u64::MAX, 1 << 32, 0xffff_ffff] {
        let known = live.iter().any(|(id, _)| id.to_bits() == bits);
        assert_eq!(w.body(BodyId::from_bits(bits)).is_ok(), known);
    }
}
