//! Bad numbers are refused at the door or contained: no panic, and everything else goes on.
//!
//! Each float parameter of each public function of the world gets each of 24 special values. `JOUNCE_PROVE=1` steps every world
//! 600 times afterwards instead of 3, and 600 instead of 60 for poisoned bodies.

mod support;

use jounce::geometry::{MassProperties, Shape};
use jounce::math::Mat3;
use jounce::prelude::*;
use jounce::{Command, Settings};
use support::*;

/// Zeros, subnormals, extremes, infinities, NaNs of several payloads, and ordinary numbers where they do not belong.
fn specials() -> [f32; 24] {
    [
        0.0,
        -0.0,
        f32::from_bits(1),
        -f32::from_bits(1),
        f32::MIN_POSITIVE,
        -f32::MIN_POSITIVE,
        1e-30,
        -1e-30,
        1e30,
        -1e30,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        -f32::NAN,
        f32::from_bits(0x7f80_0001),
        f32::from_bits(0xffff_ffff),
        1e15,
        -1e15,
        -1.0,
        16_777_217.0,
        f32::EPSILON,
        3.5e9,
    ]
}

fn prove() -> bool {
    std::env::var_os("JOUNCE_PROVE").is_some()
}

struct Stage {
    world: World,
    body: BodyId,
    shape: ShapeId,
    platform: BodyId,
    bystander: BodyId,
}

fn stage() -> Stage {
    let mut w = world();
    ground(&mut w);
    let body = add_box(&mut w, [0.0, 0.5, 0.0], 0.5);
    add_box(&mut w, [0.0, 1.5, 0.0], 0.5);
    let bystander = add_box(&mut w, [4.0, 0.5, 0.0], 0.5);
    let platform = BodyDesc::kinematic().at([-4.0, 0.5, 0.0]).shape(ShapeDesc::cuboid([0.5; 3]));
    let platform = w.add_body(platform).expect("a platform");
    let shape = w.body(body).expect("alive").shapes().next().expect("a shape");
    step(&mut w, 2);
    Stage { world: w, body, shape, platform, bystander }
}

fn all_finite(w: &World) {
    for id in w.bodies() {
        let b = w.body(id).expect("alive");
        let ok = b.pose().is_finite() && b.velocity().is_finite() && b.angular_velocity().is_finite();
        assert!(ok, "{id:?}: {:?} {:?} {:?}", b.pose(), b.velocity(), b.angular_velocity());
    }
}

/// `v` with component `i` replaced.
fn with(mut v: Vec3, i: usize, x: f32) -> Vec3 {
    v[i] = x;
    v
}

fn wide(v: Vec3) -> DVec3 {
    v.as_dvec3()
}

fn quat(i: usize, x: f32) -> Quat {
    let mut a = [0.0, 0.0, 0.0, 1.0];
    a[i] = x;
    Quat::from_array(a)
}

/// Every command with a float, with `x` in its place `i` of a vector.
fn commands(s: &Stage, x: f32, i: usize) -> Vec<Command> {
    use Command as C;
    let (b, k, sh) = (s.body, s.platform, s.shape);
    let v = with(Vec3::ZERO, i, x);
    let p = wide(with(Vec3::new(0.0, 2.0, 0.0), i, x));
    let q = quat(i, x);
    let one = Quat::IDENTITY;
    let mass = MassProperties { mass: 1.0, center: Vec3::ZERO, inertia: Mat3::from_diagonal(Vec3::ONE) };
    let mut tensor = Mat3::from_diagonal(Vec3::ONE);
    tensor.cx = with(tensor.cx, i, x);
    let material = Material::default();
    let mut list = vec![
        C::Teleport(b, p, one),
        C::Teleport(b, DVec3::Y, q),
        C::MoveTo(k, p, one),
        C::MoveTo(k, DVec3::Y, q),
        C::SetVelocity(b, v),
        C::SetAngularVelocity(b, v),
        C::SetVelocity(k, v),
        C::SetAngularVelocity(k, v),
        C::AddForce(b, v, None),
        C::AddForce(b, v, Some(DVec3::Y)),
        C::AddForce(b, Vec3::ONE, Some(p)),
        C::AddTorque(b, v),
        C::AddImpulse(b, v, None),
        C::AddImpulse(b, v, Some(DVec3::Y)),
        C::AddImpulse(b, Vec3::ONE, Some(p)),
        C::AddAngularImpulse(b, v),
        C::SetMass(b, Some(MassProperties { center: v, ..mass })),
        C::SetMass(b, Some(MassProperties { inertia: tensor, ..mass })),
        C::SetShapePose(sh, Pose::new(v, one)),
        C::SetShapePose(sh, Pose::new(Vec3::ZERO, q)),
        C::SetMaterial(sh, Material { surface_velocity: v, ..material }),
        C::SetGravity(v),
        C::SetShape(sh, Box::new(Shape::Box { half: with(Vec3::splat(0.5), i, x) })),
        C::SetShape(sh, Box::new(Shape::HalfSpace { normal: v, offset: 0.0 })),
    ];
    if i == 0 {
        list.extend([
            C::SetDamping(b, x, 0.0),
            C::SetDamping(b, 0.0, x),
            C::SetGravityScale(b, x),
            C::SetMass(b, Some(MassProperties { mass: x, ..mass })),
            C::SetShape(sh, Box::new(Shape::Sphere { radius: x })),
            C::SetShape(sh, Box::new(Shape::Capsule { half_height: x, radius: 0.5 })),
            C::SetShape(sh, Box::new(Shape::Capsule { half_height: 0.5, radius: x })),
            C::SetShape(sh, Box::new(Shape::Cylinder { half_height: x, radius: 0.5 })),
            C::SetShape(sh, Box::new(Shape::Cylinder { half_height: 0.5, radius: x })),
            C::SetShape(sh, Box::new(Shape::Cone { half_height: x, radius: 0.5 })),
            C::SetShape(sh, Box::new(Shape::Cone { half_height: 0.5, radius: x })),
            C::SetMaterial(sh, Material { static_friction: x, kinetic_friction: 0.0, ..material }),
            C::SetMaterial(sh, Material { static_friction: 1e4, kinetic_friction: x, ..material }),
            C::SetMaterial(sh, Material { restitution: x, ..material }),
            C::SetMaterial(sh, Material { rolling_friction: x, ..material }),
            C::SetMaterial(sh, Material { twist_friction: x, ..material }),
        ]);
        list.extend(descriptions(x).into_iter().map(|d| C::AddBody(Box::new(d))));
        list.extend(settings(x).into_iter().map(|d| C::SetSettings(Box::new(d))));
    }
    list
}

fn descriptions(x: f32) -> Vec<BodyDesc> {
    let ball = || ShapeDesc::sphere(0.5);
    let base = || BodyDesc::dynamic().at([0.0, 5.0, 0.0]);
    let mut list = vec![
        base().shape(ShapeDesc::sphere(x)),
        base().shape(ball().density(x)),
        base().shape(ball().mass(x)),
        base().shape(ball().friction(x)),
        base().shape(ball().restitution(x)),
        base().shape(ball()).damping(x, 0.0),
        base().shape(ball()).damping(0.0, x),
        base().shape(ball()).gravity_scale(x),
        BodyDesc { sleep_speed: Some(x), ..base().shape(ball()) },
    ];
    for i in 0..3 {
        let v = with(Vec3::ZERO, i, x);
        list.push(BodyDesc::dynamic().at(wide(v)).shape(ball()));
        list.push(base().velocity(v).shape(ball()));
        list.push(base().angular_velocity(v).shape(ball()));
        list.push(base().shape(ball().at(v)));
        list.push(base().rotated(quat(i, x)).shape(ball()));
        list.push(BodyDesc::fixed().at([0.0, -50.0, 0.0]).shape(ShapeDesc::half_space(v)));
    }
    list
}

fn settings(x: f32) -> Vec<Settings> {
    let d = Settings::default;
    vec![
        Settings { length_unit: x, ..d() },
        Settings { contact_hertz: x, ..d() },
        Settings { contact_damping_ratio: x, ..d() },
        Settings { static_contact_hertz: x, ..d() },
        Settings { static_contact_damping_ratio: x, ..d() },
        Settings { push_out_speed: x, ..d() },
        Settings { restitution_speed: x, ..d() },
        Settings { stick_speed: x, ..d() },
        Settings { hit_event_speed: x, ..d() },
        Settings { sleep_speed: x, ..d() },
        Settings { sleep_time_s: x, ..d() },
        Settings { linear_speed_max: x, ..d() },
        Settings { rotation_per_step_max: x, ..d() },
    ]
}

#[test]
fn every_float_of_every_command_with_every_special_value() {
    let s = stage();
    let (mut taken, mut refused) = (0, 0);
    let mut spread = Vec::new();
    for x in specials() {
        for i in 0..3 {
            for c in commands(&s, x, i) {
                let mut w = s.world.clone();
                let hash = w.hash();
                let name = format!("{c:?}");
                let ok = w.apply(c).is_ok();
                if !ok {
                    refused += 1;
                    assert_eq!(w.hash(), hash, "refused, but something changed: {name}");
                    continue;
                }
                taken += 1;
                assert!(x.is_finite(), "accepted {x}: {name}");
                all_finite(&w);
                step(&mut w, if prove() { 600 } else { 3 });
                all_finite(&w);
                // What happens to one body does not take the others along.
                let quarantined = w.bodies().filter(|&b| !w.body(b).expect("alive").is_enabled()).count();
                if quarantined > 1 {
                    spread.push(format!("{quarantined} bodies disabled by {name}"));
                }
            }
        }
    }
    assert!(spread.is_empty(), "{} commands: {spread:#?}", spread.len());
    assert!(taken > 500 && refused > 1500, "{taken} taken, {refused} refused");
}

#[test]
fn new_worlds_and_frames_with_special_values() {
    for x in specials() {
        for i in 0..3 {
            let desc = WorldDesc { gravity: with(Vec3::ZERO, i, x), ..WorldDesc::default() };
            assert!(World::new(desc).is_err() || x.is_finite());
        }
        let desc = WorldDesc { rate_hz: f64::from(x), ..WorldDesc::default() };
        if let Ok(mut w) = World::new(desc) {
            add_box(&mut w, [0.0, 1.0, 0.0], 0.5);
            step(&mut w, 3);
            all_finite(&w);
        }
        let mut s = stage();
        let before = s.world.hash();
        match s.world.advance(f64::from(x)) {
            Ok(a) => assert!(x >= 0.0 && a.steps <= 8 && (0.0..=1.0).contains(&a.alpha), "{x}: {a:?}"),
            Err(_) => assert_eq!(s.world.hash(), before),
        }
        all_finite(&s.world);
        let b = s.world.body(s.body).expect("alive");
        assert!(b.interpolated_pose(f64::from(x)).is_finite() || x.is_nan());
        b.velocity_at(DVec3::splat(f64::from(x)));
    }
}

#[test]
fn a_poisoned_body_is_quarantined_within_a_step_and_the_rest_goes_on() {
    type Poison = fn(&mut World, BodyId);
    let ways: [(&str, Poison); 3] = [
        ("forces that add up beyond f32", |w, b| {
            for _ in 0..3 {
                w.add_force(b, Vec3::new(0.0, -1e25, 1e25), None).expect("within the limit");
                w.add_force(b, Vec3::Z * 1e24, Some(DVec3::new(0.0, 2.6, 0.0))).expect("within the limit");
            }
        }),
        ("a torque beyond reason", |w, b| w.add_torque(b, Vec3::splat(1e25)).expect("within the limit")),
        ("out of the world", |w, b| {
            w.set_settings(Settings { linear_speed_max: 1e5, ..Settings::default() }).expect("valid");
            w.teleport(b, DVec3::new(1e9, 0.0, 0.0), Quat::IDENTITY).expect("at the edge");
            w.set_velocity(b, Vec3::X * 1e5).expect("valid");
        }),
    ];
    for (name, poison) in ways {
        let mut s = stage();
        let feather = BodyDesc::dynamic().at([0.0, 2.5, 0.0]).shape(ShapeDesc::cuboid([0.5; 3]).mass(1e-10));
        let victim = s.world.add_body(feather).expect("a feather");
        step(&mut s.world, 30);
        poison(&mut s.world, victim);
        step(&mut s.world, 1);
        all_finite(&s.world);
        let told = s.world.events().contains(&Event::Quarantine { body: victim });
        let enabled = s.world.body(victim).expect("alive").is_enabled();
        // A finite state may also survive (speeds are clamped); then it goes on like any other.
        assert_eq!(told, !enabled, "{name}");
        if name == "out of the world" {
            assert!(told, "{name}: {:?}", s.world.body(victim).expect("alive").position());
        }
        for _ in 0..if prove() { 600 } else { 60 } {
            s.world.step().expect("steps");
            all_finite(&s.world);
        }
        let p = s.world.body(s.bystander).expect("alive").position();
        assert!(p.distance(DVec3::new(4.0, 0.5, 0.0)) < 0.1, "{name}: the bystander stays: {p:?}");
        // It can be put back.
        s.world.teleport(victim, DVec3::new(8.0, 0.5, 0.0), Quat::IDENTITY).expect("alive");
        s.world.set_body_enabled(victim, true).expect("alive");
        s.world.set_velocity(victim, Vec3::ZERO).expect("alive");
        step(&mut s.world, 60);
        all_finite(&s.world);
    }
}
