//! Motion by momentum: identities, invariants, the tumbling body.
#![expect(clippy::disallowed_methods, reason = "the reference side of a test may use std's functions")]

use jounce_math::{DMat3, DQuat, DVec3};
use jounce_motion::momentum::{RigidBody, push, turn, world_inertia};

fn tumbler() -> RigidBody {
    let mut body = RigidBody::new(1.0, DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0))).expect("body");
    body.set_velocities(DVec3::ZERO, DVec3::new(0.01, 1.0, 0.0)).expect("velocities");
    body
}

/// Times at which the spin about the middle axis changes sign, in the body's frame.
fn flips(dt: f64, until: f64, step: impl Fn(&mut RigidBody, f64)) -> Vec<f64> {
    let mut body = tumbler();
    let middle = |b: &RigidBody| b.rotation().inverse_rotate(b.angular_velocity()).y;
    let (mut found, mut before) = (Vec::new(), middle(&body));
    for n in 1..=(until / dt) as u32 {
        step(&mut body, dt);
        let now = middle(&body);
        if before * now < 0.0 {
            found.push(f64::from(n) * dt - dt * now / (now - before));
        }
        before = now;
    }
    found
}

#[test]
fn the_middle_axis_flips_when_theory_says() {
    // Elliptic functions: first after 10.37730 s, then every 20.75461 s. The rule's phase error is (ω Δt)²/12 of the
    // time: 1e-7 of it for Δt = 1 ms.
    let found = flips(1e-3, 75.0, |b, dt| b.update_midpoint(dt).expect("turns"));
    for (n, t) in found.iter().enumerate() {
        let expected = 10.377_30 + 20.754_61 * n as f64;
        assert!((t - expected).abs() < 1e-5 * (2.0 + n as f64), "{n}: {t} against {expected}");
    }
    assert_eq!(found.len(), 4);
    // The lecture's loop is of first order: a hundred times as far off, and still there.
    let crude = flips(1e-3, 15.0, |b, dt| b.update(dt).expect("turns"));
    assert!((crude[0] - 10.377_30).abs() < 0.1 && (crude[0] - 10.377_30).abs() > 1e-4, "{crude:?}");
}

#[test]
fn the_midpoint_update_keeps_everything_at_any_step() {
    for dt in [1e-3, 0.1, 0.4, 3.0] {
        let mut body = tumbler();
        let (l, energy) = (body.angular_momentum(), body.kinetic_energy());
        for _ in 0..2000 {
            body.update_midpoint(dt).expect("turns");
        }
        assert_eq!(body.angular_momentum(), l, "L is state: it is not even touched");
        assert!((body.kinetic_energy() / energy - 1.0).abs() < 1e-12, "{dt}: {}", body.kinetic_energy());
        assert!((body.rotation().length() - 1.0).abs() < 1e-15);
        // L as it is seen from the body turns with the body.
        let seen = body.rotation().inverse_rotate(l);
        assert!((seen.length() / l.length() - 1.0).abs() < 1e-14);
    }
}

#[test]
fn the_midpoint_update_is_of_second_order() {
    let end = |dt: f64| {
        let mut body = tumbler();
        body.set_velocities(DVec3::ZERO, DVec3::new(0.5, 1.0, 0.3)).expect("velocities");
        for _ in 0..(4.0 / dt).round() as u32 {
            body.add_torque(DVec3::new(0.1, 0.0, -0.2));
            body.update_midpoint(dt).expect("turns");
        }
        body.rotation()
    };
    let exact = end(1.0 / 4096.0);
    let off = |dt: f64| {
        let (a, b) = (end(dt), exact);
        2.0 * (1.0 - a.dot(b) * a.dot(b)).abs().sqrt()
    };
    let slope = (off(1.0 / 64.0) / off(1.0 / 128.0)).log2();
    assert!((slope - 2.0).abs() < 0.1, "{slope}");
}

#[test]
fn the_lectures_loop_keeps_momentum_but_not_energy() {
    let mut body = tumbler();
    body.set_velocities(DVec3::X, DVec3::new(0.5, 1.0, 0.3)).expect("velocities");
    let (l, energy) = (body.angular_momentum(), body.kinetic_energy());
    for _ in 0..1000 {
        body.update(0.01).expect("turns");
    }
    assert_eq!(body.angular_momentum(), l);
    assert!(
        (body.kinetic_energy() - energy).abs() > 1e-5,
        "were it kept, the better update would be for nothing"
    );
    assert!((body.position() - DVec3::X * 10.0).length() < 1e-12);
}

#[test]
fn momentum_form_is_the_velocity_form() {
    // P += F Δt; v = P/m against v += F/m Δt: the same to rounding, under a force that changes.
    let (mass, dt) = (3.7, 0.01);
    let (mut p, mut v, mut by_p) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    let (mut x, mut y) = (DVec3::ZERO, DVec3::ZERO);
    for n in 0..1000 {
        let s = f64::from(n % 17) - 8.0;
        let f = DVec3::new(s, 9.0 - s * s, 1.0);
        (p, by_p) = push(p, mass, f, dt);
        v += f / mass * dt;
        x += by_p * dt;
        y += v * dt;
    }
    // A thousand roundings of 1.1e-16 of numbers of at most 100.
    assert!((by_p - v).length() < 1e-11 && (x - y).length() < 1e-10);
}

#[test]
fn forces_and_torques_do_what_they_should() {
    let inertia = DMat3::from_diagonal(DVec3::splat(2.0));
    let mut body = RigidBody::new(4.0, inertia).expect("body");
    body.set_pose(DVec3::new(1.0, 0.0, 0.0), DQuat::new(0.0, 0.0, 2.0, 0.0)).expect("pose");
    // Force at an arm: both forms give the closed form of a ball.
    for step in [RigidBody::update, RigidBody::update_midpoint] {
        let mut b = body.clone();
        b.add_force_at(DVec3::Y * 8.0, DVec3::new(1.5, 0.0, 0.0));
        step(&mut b, 0.5).expect("moves");
        assert!((b.velocity() - DVec3::Y).length() < 1e-15);
        assert!((b.angular_velocity() - DVec3::Z).length() < 1e-15, "τ = r × F = 4, L = 2, ω = 1");
        assert!((b.velocity_at(DVec3::new(2.0, b.position().y, 0.0)) - DVec3::Y * 2.0).length() < 1e-14);
        let before = b.clone();
        step(&mut b, 0.5).expect("coasts");
        assert_eq!(b.velocity(), before.velocity(), "forces are spent");
    }
}

#[test]
fn tensors_turn_along() {
    let i0 = DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0));
    let r = turn(DVec3::new(0.3, -0.4, 1.2));
    let world = world_inertia(r, &i0);
    let w = DVec3::new(0.1, 0.2, 0.3);
    assert!((world * r.rotate(w) - r.rotate(i0 * w)).length() < 1e-15);
    assert_eq!(turn(DVec3::ZERO), DQuat::IDENTITY);
}

#[test]
fn bad_bodies_are_refused() {
    let good = DMat3::from_diagonal(DVec3::ONE);
    for mass in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let e = RigidBody::new(mass, good).expect_err("bad mass").to_string();
        assert!(e.contains("mass") && e.contains("above 0"), "{e}");
    }
    for inertia in [
        DMat3::ZERO,
        DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0)),
        DMat3::from_diagonal(DVec3::new(1.0, f64::NAN, 1.0)),
        DMat3::from_columns(DVec3::new(1.0, 0.5, 0.0), DVec3::Y, DVec3::Z),
    ] {
        assert!(RigidBody::new(1.0, inertia).is_err(), "{inertia:?}");
    }
    let mut body = RigidBody::new(1.0, good).expect("body");
    assert!(body.set_pose(DVec3::X * f64::NAN, DQuat::IDENTITY).is_err());
    assert!(body.set_pose(DVec3::X, DQuat::new(0.0, 0.0, 0.0, 0.0)).is_err());
    let before = body.clone();
    body.add_force(DVec3::X * f64::INFINITY);
    assert!(body.update(0.1).is_err() && body.update_midpoint(0.1).is_err());
    body.clear_forces();
    assert_eq!(body, before);
}
