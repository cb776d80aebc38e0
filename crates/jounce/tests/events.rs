//! Events, wake rules, hooks and contact forces in situations with one outcome.

mod support;

use jounce::geometry::{Shape, TriMesh, TriMeshOptions};
use jounce::math::scalar::{f32s, f64s};
use jounce::prelude::*;
use jounce::{ContactHook, ContactView, FilterHook, PairView, Surface};
use std::sync::Arc;
use support::*;

fn first_shape(w: &World, b: BodyId) -> ShapeId {
    w.body(b).expect("alive").shapes().next().expect("a shape")
}

fn awake(w: &World, b: BodyId) -> bool {
    w.body(b).expect("alive").is_awake()
}

/// Steps until `f` finds something in the events; gives it and the number of the step.
fn until<T>(w: &mut World, most: usize, mut f: impl FnMut(&Event) -> Option<T>) -> Option<(usize, T)> {
    for i in 0..most {
        w.step().expect("steps");
        if let Some(t) = w.events().iter().find_map(&mut f) {
            return Some((i, t));
        }
    }
    None
}

#[test]
fn a_dropped_box_begins_hits_sleeps_wakes_and_ends() {
    let mut w = world();
    let floor = ground(&mut w);
    let shape = ShapeDesc::cuboid([0.5; 3]).hit_events(true).mass(2.0);
    let b = w.add_body(BodyDesc::dynamic().at([0.0, 2.5, 0.0]).shape(shape)).expect("a box");
    let pair = [first_shape(&w, floor), first_shape(&w, b)];

    let begin = until(&mut w, 120, |e| match *e {
        Event::ContactBegin { a, b } => Some([a, b]),
        _ => None,
    });
    assert_eq!(begin.map(|x| x.1), Some(pair));
    // v = √(2 g h), h = 2 m. The hit is told in the step of the contact or the one after it.
    let told = |e: &Event| match *e {
        Event::ContactHit { a, b, point, normal, speed, impulse } => {
            Some(([a, b], point, normal, speed, impulse))
        }
        _ => None,
    };
    let hit = w.events().iter().find_map(told).or_else(|| until(&mut w, 3, told).map(|x| x.1));
    let (shapes, point, normal, speed, impulse) = hit.expect("a hit");
    assert_eq!(shapes, pair);
    let v = (2.0f32 * 9.81 * 2.0).sqrt();
    assert!((speed - v).abs() < 0.25, "{speed} against {v}");
    assert!((impulse - 2.0 * speed).abs() < 0.2 * impulse, "{impulse} N s");
    assert!(normal.distance(Vec3::Y) < 1e-4 && point.y.abs() < 0.05, "{normal:?} {point:?}");

    let slept = until(&mut w, 240, |e| match *e {
        Event::Sleep { body } => Some(body),
        _ => None,
    });
    assert_eq!(slept.map(|x| x.1), Some(b));
    assert!(!awake(&w, b));
    step(&mut w, 5);
    assert!(w.events().is_empty(), "a sleeping world is silent: {:?}", w.events());

    w.add_impulse(b, Vec3::new(0.0, 20.0, 0.0), None).expect("alive");
    let woke = until(&mut w, 1, |e| (*e == Event::Wake { body: b }).then_some(()));
    assert!(woke.is_some(), "{:?}", w.events());
    let end = until(&mut w, 60, |e| match *e {
        Event::ContactEnd { a, b } => Some([a, b]),
        _ => None,
    });
    assert_eq!(end.map(|x| x.1), Some(pair));
}

#[test]
fn removing_a_touching_body_tells_of_the_end_and_wakes_the_rest() {
    let mut w = world();
    ground(&mut w);
    let boxes: Vec<BodyId> = (0..4).map(|i| add_box(&mut w, [0.0, 0.5 + f64::from(i), 0.0], 0.5)).collect();
    step(&mut w, 240);
    assert!(boxes.iter().all(|&b| !awake(&w, b)), "the stack sleeps");
    let gone = [first_shape(&w, boxes[0]), first_shape(&w, boxes[1])];
    w.remove_body(boxes[0]).expect("alive");
    assert!(boxes[1..].iter().all(|&b| awake(&w, b)));
    step(&mut w, 1);
    assert!(w.events().contains(&Event::ContactEnd { a: gone[0], b: gone[1] }), "{:?}", w.events());
    for &b in &boxes[1..] {
        assert!(w.events().contains(&Event::Wake { body: b }));
    }
    step(&mut w, 239);
    for (i, &b) in boxes[1..].iter().enumerate() {
        let y = w.body(b).expect("alive").position().y;
        assert!((y - 0.5 - i as f64).abs() < 0.02, "box {i} fell to {y}");
    }
}

#[test]
fn every_way_of_taking_the_support_away_wakes_the_stack() {
    type Take = fn(&mut World, BodyId, ShapeId);
    let ways: [(&str, Take); 9] = [
        ("remove body", |w, b, _| w.remove_body(b).expect("alive")),
        ("remove shape", |w, _, s| w.remove_shape(s).expect("alive")),
        ("disable body", |w, b, _| w.set_body_enabled(b, false).expect("alive")),
        ("disable shape", |w, _, s| w.set_shape_enabled(s, false).expect("alive")),
        ("teleport", |w, b, _| w.teleport(b, DVec3::new(50.0, 0.0, 0.0), Quat::IDENTITY).expect("alive")),
        ("filter", |w, _, s| w.set_filter(s, Filter { layers: 0, mask: 0, group: 0 }).expect("alive")),
        ("smaller shape", |w, _, s| w.set_shape(s, Shape::Sphere { radius: 0.1 }).expect("alive")),
        ("shape moved", |w, _, s| {
            w.set_shape_pose(s, Pose::from_translation(Vec3::new(0.0, -9.0, 0.0))).expect("alive");
        }),
        ("gravity sideways", |w, _, _| w.set_gravity(Vec3::new(9.81, 0.0, 0.0)).expect("valid")),
    ];
    for kind in [BodyKind::Fixed, BodyKind::Kinematic] {
        for (name, take) in ways {
            let mut w = world();
            let table = BodyDesc::new(kind).shape(ShapeDesc::cuboid([2.0, 0.5, 2.0]));
            let table = w.add_body(table).expect("a table");
            let a = add_box(&mut w, [0.0, 1.0, 0.0], 0.5);
            let b = add_box(&mut w, [0.0, 2.0, 0.0], 0.5);
            step(&mut w, 240);
            assert!(!awake(&w, a) && !awake(&w, b), "{name}: asleep first");
            let before = w.body(a).expect("alive").position();
            let s = first_shape(&w, table);
            take(&mut w, table, s);
            assert!(awake(&w, a) && awake(&w, b), "{name} of a {kind:?} body must wake what lies on it");
            step(&mut w, 60);
            assert!(w.body(a).expect("alive").position().distance(before) > 0.3, "{name}: the box falls");
        }
    }
}

#[test]
fn a_sleeper_wakes_when_hit_pushed_or_carried_off_and_not_otherwise() {
    let rest = || {
        let mut w = world();
        ground(&mut w);
        let b = add_box(&mut w, [0.0, 0.5, 0.0], 0.5);
        step(&mut w, 120);
        assert!(!awake(&w, b));
        (w, b)
    };
    let (mut w, b) = rest();
    add_box(&mut w, [5.0, 0.5, 0.0], 0.5);
    step(&mut w, 10);
    assert!(!awake(&w, b), "a neighbour 4 m away is none of its business");
    let (mut w, b) = rest();
    add_box(&mut w, [0.2, 2.0, 0.0], 0.5);
    assert!(until(&mut w, 60, |e| (*e == Event::Wake { body: b }).then_some(())).is_some(), "hit");
    let (mut w, b) = rest();
    let pusher = BodyDesc::kinematic().at([-2.0, 0.5, 0.0]).velocity([1.0, 0.0, 0.0]);
    w.add_body(pusher.shape(ShapeDesc::cuboid([0.5; 3]))).expect("a pusher");
    step(&mut w, 150);
    let x = w.body(b).expect("alive").position().x;
    assert!(awake(&w, b) && (x - 1.5).abs() < 0.05, "pushed along to {x}");
    for f in [Vec3::ZERO, Vec3::X] {
        let (mut w, b) = rest();
        w.add_force(b, f, None).expect("alive");
        assert_eq!(awake(&w, b), f != Vec3::ZERO, "a force of {f:?}");
        let (mut w, b) = rest();
        w.set_velocity(b, f).expect("alive");
        assert_eq!(awake(&w, b), f != Vec3::ZERO, "a velocity of {f:?}");
    }
    let (mut w, b) = rest();
    w.set_user_data(b, 3).expect("alive");
    w.set_name(b, Some("x".into())).expect("alive");
    assert!(!awake(&w, b), "a name wakes nobody");
}

#[test]
fn sensors_tell_who_enters_and_who_leaves() {
    let mut w = world();
    let gate = BodyDesc::fixed().at([0.0, 5.0, 0.0]).shape(ShapeDesc::cuboid([1.0, 0.5, 1.0]).sensor());
    let gate = w.add_body(gate).expect("a gate");
    let ball = BodyDesc::dynamic().at([0.0, 8.0, 0.0]).shape(ShapeDesc::sphere(0.25));
    let ball = w.add_body(ball).expect("a ball");
    let (sensor, visitor) = (first_shape(&w, gate), first_shape(&w, ball));
    let mut log = Vec::new();
    for _ in 0..120 {
        w.step().expect("steps");
        let y = w.body(ball).expect("alive").position().y;
        let inside = y - 0.25 <= 5.5 && y + 0.25 >= 4.5;
        let listed = w.shape(sensor).expect("alive").visitors().any(|v| v == visitor);
        assert_eq!(inside, listed, "at {y}");
        log.extend(w.events().iter().copied());
    }
    let expected = [Event::SensorEnter { sensor, visitor }, Event::SensorLeave { sensor, visitor }];
    assert_eq!(log, expected, "the sensor touches nobody: no contact events");
    // Free fall was not disturbed: y = h − g t (t + dt) / 2 of the semi-implicit steps.
    let h = 1.0 / 240.0;
    let fallen = 8.0 - w.body(ball).expect("alive").position().y;
    let exact = 0.5 * 9.81 * 2.0 * (2.0 + h);
    assert!((fallen - exact).abs() < 0.05, "{fallen} against {exact}");
}

#[test]
fn a_removed_visitor_leaves_its_sensor() {
    for disable in [false, true] {
        let mut w = world();
        w.set_gravity(Vec3::ZERO).expect("valid");
        let zone = w.add_body(BodyDesc::fixed().shape(ShapeDesc::sphere(2.0).sensor())).expect("a zone");
        let b = add_box(&mut w, [0.5, 0.0, 0.0], 0.5);
        let (sensor, visitor) = (first_shape(&w, zone), first_shape(&w, b));
        step(&mut w, 1);
        assert!(w.events().contains(&Event::SensorEnter { sensor, visitor }));
        if disable {
            w.set_body_enabled(b, false).expect("alive");
        } else {
            w.remove_body(b).expect("alive");
        }
        step(&mut w, 1);
        assert!(w.events().contains(&Event::SensorLeave { sensor, visitor }), "{:?}", w.events());
        assert_eq!(w.shape(sensor).expect("alive").visitors().count(), 0);
    }
}

#[test]
fn normal_forces_add_up_to_the_weight() {
    for (n, mass) in [(1usize, 3.0f32), (5, 10.0)] {
        let mut w = world();
        let floor = ground(&mut w);
        let boxes: Vec<BodyId> = (0..n)
            .map(|i| {
                let shape = ShapeDesc::cuboid([0.5; 3]).mass(mass);
                let at = [0.0, 0.5 + i as f64, 0.0];
                w.add_body(BodyDesc::dynamic().at(at).can_sleep(false).shape(shape)).expect("a box")
            })
            .collect();
        step(&mut w, 300);
        for (i, &b) in boxes.iter().enumerate() {
            let below = if i == 0 { floor } else { boxes[i - 1] };
            let (s, t) = (first_shape(&w, below), first_shape(&w, b));
            let c = w.contact_between(s, t).expect("alive").expect("they touch");
            let load = (n - i) as f32 * mass * 9.81;
            let up = if c.bodies[1] == b { c.force() } else { -c.force() };
            assert!((c.normal_force() - load).abs() < 1e-3 * load, "{} N under {load} N", c.normal_force());
            assert!((up.y - load).abs() < 1e-3 * load && up.x.abs() + up.z.abs() < 1e-2 * load, "{up:?}");
            assert_eq!(c.manifolds[0].points.len(), 4);
            for p in &c.manifolds[0].points {
                assert!((p.point.y - i as f64).abs() < 0.01 && p.separation.abs() < 0.01, "{p:?}");
                assert!((p.normal_force - p.normal_impulse * 60.0).abs() < 1e-3);
            }
            assert_eq!(w.contacts_of(b).expect("alive").len(), if i + 1 < n { 2 } else { 1 });
        }
        assert_eq!(w.contacts_of(floor).expect("alive").len(), 1);
        assert_eq!(w.contacts().len(), n);
    }
}

#[test]
fn friction_on_a_slope_holds_m_g_sin() {
    let mut w = world();
    let angle = 20f32.to_radians();
    let tilt = Quat::from_axis_angle(Vec3::Z, angle);
    let floor = BodyDesc::fixed().rotated(tilt).shape(ShapeDesc::half_space(Vec3::Y).friction(0.8));
    let floor = w.add_body(floor).expect("a slope");
    let shape = ShapeDesc::cuboid([0.5, 0.25, 0.5]).mass(4.0).friction(0.8);
    let at = tilt.rotate(Vec3::new(0.0, 0.25, 0.0)).as_dvec3();
    let b = BodyDesc::dynamic().at(at).rotated(tilt).can_sleep(false).shape(shape);
    let b = w.add_body(b).expect("a box");
    step(&mut w, 240);
    let c = w.contact_between(first_shape(&w, floor), first_shape(&w, b)).expect("alive").expect("touch");
    let m = &c.manifolds[0];
    let weight = 4.0 * 9.81;
    let (sin, cos) = (f32s::sin(angle), f32s::cos(angle));
    assert!(m.stick);
    assert!((m.normal_force() - weight * cos).abs() < 2e-3 * weight, "{} N", m.normal_force());
    assert!((m.friction_force.length() - weight * sin).abs() < 2e-3 * weight, "{:?}", m.friction_force);
    let uphill = tilt.rotate(Vec3::X);
    assert!(m.friction_force.dot(uphill) > 0.99 * weight * sin, "friction points uphill");
    assert!((m.friction_impulse * 60.0).distance(m.friction_force) < 1e-3);

    // Kinetic: μ_k N, against the slip, and no longer stuck.
    w.set_velocity(b, uphill * -5.0).expect("alive");
    step(&mut w, 10);
    let c = w.contact_between(first_shape(&w, floor), first_shape(&w, b)).expect("alive").expect("touch");
    let m = &c.manifolds[0];
    assert!(!m.stick);
    assert!((m.friction_force.length() - 0.8 * m.normal_force()).abs() < 0.02 * weight, "{m:?}");
}

#[test]
fn contacts_with_a_mesh_name_the_triangle() {
    let mut w = world();
    let v = [
        Vec3::new(-5.0, 0.0, -5.0),
        Vec3::new(-5.0, 0.0, 5.0),
        Vec3::new(5.0, 0.0, 5.0),
        Vec3::new(5.0, 0.0, -5.0),
    ];
    let mesh = TriMesh::new(&v, &[[0, 1, 2], [0, 2, 3]], TriMeshOptions::default()).expect("a mesh");
    let floor = w.add_body(BodyDesc::fixed().shape(ShapeDesc::mesh(Arc::new(mesh)))).expect("a floor");
    let ball = BodyDesc::dynamic().at([-3.0, 0.5, 3.0]).shape(ShapeDesc::sphere(0.5).mass(1.0));
    let b = w.add_body(ball.can_sleep(false)).expect("a ball");
    step(&mut w, 120);
    let c = w.contact_between(first_shape(&w, b), first_shape(&w, floor)).expect("alive").expect("touch");
    let side = usize::from(c.bodies[1] == floor);
    assert_eq!(c.manifolds[0].parts[side], Some(0), "{c:?}");
    assert_eq!(c.manifolds[0].parts[1 - side], None);
    assert!((c.normal_force() - 9.81).abs() < 0.02);
}

#[test]
fn the_filter_hook_decides_who_meets() {
    let mut w = world();
    let hook: FilterHook = Arc::new(|p: &PairView| !p.user_data.contains(&7));
    w.set_filter_hook(Some(("no sevens", hook)));
    ground(&mut w);
    let ghost = add_box(&mut w, [0.0, 0.6, 0.0], 0.5);
    let solid = add_box(&mut w, [3.0, 0.6, 0.0], 0.5);
    let late = add_box(&mut w, [6.0, 3.0, 0.0], 0.5);
    w.set_user_data(ghost, 7).expect("alive");
    step(&mut w, 120);
    let y = |b| w.body(b).expect("alive").position().y;
    assert!(y(ghost) < -5.0, "the ghost falls through: {}", y(ghost));
    assert!((y(solid) - 0.5).abs() < 0.02 && (y(late) - 0.5).abs() < 0.02);
}

#[test]
fn the_contact_hook_makes_a_one_way_platform() {
    let mut w = world();
    let platform = BodyDesc::fixed().at([0.0, 2.0, 0.0]).shape(ShapeDesc::cuboid([2.0, 0.1, 2.0]));
    let platform = w.add_body(platform.user_data(1)).expect("a platform");
    let hook: ContactHook = Arc::new(|v: &ContactView, _: &mut Surface| {
        let Some(side) = v.pair.user_data.iter().position(|&u| u == 1) else { return true };
        // Out of the platform, and the other's velocity against it.
        let sign = if side == 0 { 1.0 } else { -1.0 };
        v.normal.y * sign > 0.7 && v.relative_velocity.y * sign < 0.5 && v.separation > -0.1
    });
    w.set_contact_hook(Some(("one way", hook)));
    let ball = BodyDesc::dynamic().at([0.0, 0.0, 0.0]).velocity([0.0, 10.0, 0.0]);
    let b = w.add_body(ball.shape(ShapeDesc::sphere(0.25))).expect("a ball");
    let mut top = 0.0f64;
    for _ in 0..240 {
        w.step().expect("steps");
        top = f64s::max(top, w.body(b).expect("alive").position().y);
    }
    assert!(top > 4.5, "nothing stopped it on the way up: {top}");
    let y = w.body(b).expect("alive").position().y;
    assert!((y - 2.35).abs() < 0.02, "it lies on the platform: {y}");
    assert_eq!(w.contacts_of(platform).expect("alive").len(), 1);
}

#[test]
fn the_contact_hook_may_change_the_surface() {
    let slide = |slippery: bool| {
        let mut w = world();
        ground(&mut w);
        if slippery {
            let hook: ContactHook = Arc::new(|_: &ContactView, s: &mut Surface| {
                (s.static_friction, s.kinetic_friction) = (0.0, 0.0);
                true
            });
            w.set_contact_hook(Some(("ice", hook)));
        }
        let b = add_box(&mut w, [0.0, 0.5, 0.0], 0.5);
        w.set_velocity(b, Vec3::new(2.0, 0.0, 0.0)).expect("alive");
        step(&mut w, 60);
        w.body(b).expect("alive").position().x
    };
    assert!((slide(true) - 2.0).abs() < 0.02, "ice: {}", slide(true));
    // v²/(2 μ g) with μ = 0.6.
    assert!((slide(false) - 4.0 / (2.0 * 0.6 * 9.81)).abs() < 0.03, "{}", slide(false));
}

#[test]
fn a_world_is_send_sync_clone_and_a_clone_has_the_same_future() {
    fn send_sync_clone<T: Send + Sync + Clone>() {}
    send_sync_clone::<World>();
    let mut w = random_world(8, 60, DVec3::ZERO, 4.0);
    for start in 0..4 {
        let mut copy = w.clone();
        assert_eq!(copy.hash(), w.hash());
        for i in 0..120 {
            if i % 10 == 3 {
                for world in [&mut w, &mut copy] {
                    let at = DVec3::new(0.0, 6.0, f64::from(i) * 0.01);
                    world.add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::sphere(0.3))).expect("a ball");
                }
            }
            w.step().expect("steps");
            copy.step().expect("steps");
            assert_eq!(copy.events(), w.events(), "events of step {i} after clone {start}");
            assert_eq!(copy.hash(), w.hash(), "step {i} after clone {start}");
        }
        // A clone is a world of its own.
        copy.set_gravity(Vec3::ZERO).expect("valid");
        copy.step().expect("steps");
        assert_ne!(copy.hash(), w.hash());
    }
}

#[test]
fn a_body_held_to_the_speed_limit_is_reported_every_step() {
    let mut w = world();
    let fast = BodyDesc::dynamic().at([0.0, 50.0, 0.0]).velocity([1e3, 0.0, 0.0]).gravity_scale(0.0);
    let fast = w.add_body(fast.shape(ShapeDesc::sphere(0.5))).expect("a fast ball");
    let slow = BodyDesc::dynamic().at([0.0, 60.0, 0.0]).velocity([399.0, 0.0, 0.0]).gravity_scale(0.0);
    w.add_body(slow.shape(ShapeDesc::sphere(0.5))).expect("a ball below the limit");
    for _ in 0..3 {
        w.step().expect("steps");
        assert_eq!(w.events(), [Event::SpeedLimited { body: fast }]);
    }
    let v = w.body(fast).expect("alive").velocity().length();
    assert!((v - w.settings().linear_speed_max).abs() < 0.01, "{v}");
}
