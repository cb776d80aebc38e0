//! Force laws, kinematics and frames against closed forms.
#![expect(clippy::disallowed_methods, reason = "the reference side of a test may use std's functions")]

use jounce_math::{DQuat, DVec3};
use jounce_motion::force::*;
use jounce_motion::integrate::{Integrator, Method};
use jounce_motion::kinematics::*;

#[test]
fn a_pair_exchanges_no_momentum() {
    let (x1, x2) = (DVec3::new(1.0, 2.0, -3.0), DVec3::new(-0.3, 0.7, 11.0));
    for softening in [0.0, 0.5] {
        let f = gravitation(G, 3.7, 91.0, x2 - x1, softening);
        assert_eq!(f, -gravitation(G, 91.0, 3.7, x1 - x2, softening), "the third law to the bit");
        assert!(f.dot(x2 - x1) > 0.0);
    }
    assert_eq!(gravitation(G, 1.0, 1.0, DVec3::ZERO, 0.0), DVec3::ZERO);
    assert_eq!(gravitation(G, 1.0, 1.0, DVec3::ZERO, 1.0), DVec3::ZERO);
    // Far out of the range in which r³ is a number.
    let far = gravitation(1.0, 1e150, 1e150, DVec3::X * 1e140, 0.0);
    assert!((far.x / 1e20 - 1.0).abs() < 1e-12, "{far:?}");
    // The lecture's constant is 1.9e-4 below CODATA's.
    assert!((G_LECTURE / G - 0.999_805).abs() < 1e-6);
    // Earth: g = G M/R².
    let g = gravitation(G, 1.0, 5.972_2e24, DVec3::X * 6.371_0e6, 0.0);
    assert!((g.x - 9.820).abs() < 0.001);
}

#[test]
fn terminal_speeds() {
    // Steel, 1 mm, in glycerin: .0101115 m/s, τ = m/b = 1.2293 ms.
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 1e-9;
    let (mass, b) = (7800.0 * volume, stokes_coefficient(1.41, 1e-3));
    let g = DVec3::Y * -9.81;
    let net = uniform_gravity(mass, g) + buoyancy(1260.0, volume, g);
    let v = terminal_speed(-net.y, b, 0.0);
    assert!((v - 0.010_111_5).abs() < 5e-8, "{v}");
    assert!((mass / b - 1.229_3e-3).abs() < 5e-8);
    // The implicit step has exactly this fixed point, at any step.
    for dt in [1e-5, 1.0 / 240.0, 10.0] {
        let mut fall = DVec3::ZERO;
        for _ in 0..10_000 {
            fall = implicit_drag(fall, net / mass, b / mass, 0.0, dt);
        }
        assert!((fall.y + v).abs() < 1e-14, "{dt}: {fall:?}");
    }
    let (b, c, f) = (2.0, 3.0, 5.0);
    let v = terminal_speed(f, b, c);
    assert!((b * v + c * v * v - f).abs() < 1e-14);
    assert_eq!(terminal_speed(0.0, 0.0, 0.0), 0.0);
    assert_eq!(terminal_speed(1.0, 0.0, 0.0), f64::INFINITY);
}

#[test]
fn implicit_drag_solves_its_equation_and_never_turns_round() {
    let mut seed = 12345u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    for _ in 0..10_000 {
        let v = DVec3::new(random() - 0.5, random() - 0.5, random() - 0.5) * 100.0;
        let a = DVec3::new(random() - 0.5, random() - 0.5, random() - 0.5) * 20.0;
        let (k1, k2) = (10.0f64.powf(6.0 * random() - 3.0), 10.0f64.powf(6.0 * random() - 3.0));
        let dt = 10.0f64.powf(4.0 * random() - 3.0);
        let new = implicit_drag(v, a, k1, k2, dt);
        let w = v + a * dt;
        let back = new + (new * k1 + new * (k2 * new.length())) * dt;
        assert!((back - w).length() <= 1e-13 * w.length(), "{v:?} {a:?} {k1} {k2} {dt}");
        assert!(new.dot(w) >= 0.0 && new.length() <= w.length());
    }
    assert_eq!(implicit_drag(DVec3::ZERO, DVec3::ZERO, 1.0, 1.0, 1.0), DVec3::ZERO);
    assert_eq!(implicit_drag(DVec3::X, DVec3::Y, 0.0, 0.0, 0.5), DVec3::new(1.0, 0.5, 0.0));
}

#[test]
fn a_fall_against_quadratic_drag() {
    // v = v_t tanh(g t/v_t), drop = v_t²/g ln cosh(g t/v_t), with v_t = 20 and g = 9.81.
    let c = 9.81 / 400.0;
    let mut fall = Integrator::new(Method::AdaptiveDopri5);
    let (mut x, mut v, mut t) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for (until, speed, drop) in
        [(1.0, 9.092_264, 4.720_081), (2.0, 15.069_969, 17.100_391), (5.0, 19.705_802, 72.038_122)]
    {
        let force = |_: f64, _: DVec3, v: DVec3| DVec3::Y * -9.81 + quadratic_drag(c, v);
        fall.step_point(t, until - t, &mut x, &mut v, force).expect("falls");
        t = until;
        // Half of the last printed digit.
        assert!((v.y + speed).abs() < 5.1e-7, "{t} {v:?}");
        assert!((x.y + drop).abs() < 5.1e-7, "{t} {x:?}");
    }
}

#[test]
fn friction_holds_then_slides() {
    let (mass, g, mu_s, mu_k) = (2.0, 9.81, 0.6, 0.4);
    let angle = friction_angle(mu_s);
    for (slope, holds) in [(0.999 * angle, true), (1.001 * angle, false)] {
        let (load, normal) = (DVec3::X * (mass * g * slope.sin()), mass * g * slope.cos());
        match static_friction(mu_s, normal, load) {
            Friction::Holds(f) => assert!(holds && f == -load),
            Friction::Slips => {
                assert!(!holds);
                let a = (load + kinetic_friction(mu_k, normal, DVec3::X * 0.3)) / mass;
                assert!((a.x - g * (slope.sin() - mu_k * slope.cos())).abs() < 1e-14);
            }
        }
    }
    assert_eq!(kinetic_friction(0.5, 10.0, DVec3::ZERO), DVec3::ZERO);
    assert_eq!(kinetic_friction(0.5, -10.0, DVec3::X), DVec3::ZERO, "a pull presses nothing");
    assert_eq!(static_friction(0.5, -10.0, DVec3::X), Friction::Slips);
    assert_eq!(static_friction(0.5, 0.0, DVec3::ZERO), Friction::Holds(DVec3::ZERO));
}

#[test]
fn lift_of_spinning_balls() {
    // With C_L = 2 S the ball's form is Rubinow and Keller's k = π ρ r³.
    let (rho, r, w, v) = (1.2, 0.11, DVec3::new(1.0, 2.0, 40.0), DVec3::new(20.0, 3.0, -1.0));
    let cross = w.cross(v);
    let s = r * cross.length() / v.length_squared();
    let area = std::f64::consts::PI * r * r;
    let from_coefficient = cross / cross.length() * (0.5 * rho * area * 2.0 * s * v.length_squared());
    let slow = magnus(sphere_lift_factor(rho, r), w, v);
    assert!((slow - from_coefficient).length() < 1e-13 * slow.length());
    let f = ball_magnus(rho, r, w, v);
    assert!((f.length() / slow.length() - ball_lift_coefficient(s) / (2.0 * s)).abs() < 1e-13);
    assert!(f.dot(v).abs() < 1e-13 * f.length() * v.length(), "lift does no work");
    assert_eq!(ball_magnus(rho, r, DVec3::ZERO, v), DVec3::ZERO);
    assert_eq!(ball_magnus(rho, r, w, DVec3::ZERO), DVec3::ZERO);
    assert_eq!(ball_magnus(rho, r, v, v), DVec3::ZERO);
    assert!((ball_lift_coefficient(0.1) - 0.15).abs() < 1e-15, "the two branches meet");
}

#[test]
fn springs_pull_and_push() {
    let (k, c, rest) = (100.0, 3.0, 2.0);
    assert!(spring(k, c, rest, DVec3::X * 3.0, DVec3::ZERO).x < 0.0, "stretched: pulls back");
    assert!(spring(k, c, rest, DVec3::X, DVec3::ZERO).x > 0.0, "compressed: pushes apart");
    let f = spring(k, c, rest, DVec3::X * 2.0, DVec3::new(1.0, 5.0, 0.0));
    assert_eq!(f, DVec3::X * -3.0, "damping acts along the spring only");
    assert_eq!(spring(k, c, rest, DVec3::ZERO, DVec3::X), DVec3::ZERO);
}

#[test]
fn circles() {
    let (m, w, r) = (0.7, DVec3::Z * 3.0, DVec3::new(2.0, 0.0, 5.0));
    // m ω² r and m v²/r, r across the axis; the part along it does not count.
    assert!((centripetal(m, w, r) + DVec3::X * (m * 9.0 * 2.0)).length() < 1e-14);
    let v = point_velocity(w, r);
    assert!((centrifugal(m, w, r).length() - m * v.length_squared() / 2.0).abs() < 1e-14);
    // The acceleration of a point that turns is the second derivative of its path.
    let path = |t: f64| DQuat::from_axis_angle(DVec3::Z, 3.0 * t + 0.5 * 0.8 * t * t).rotate(r);
    let a = acceleration_of(path, 0.0, 0.3);
    assert!((a - point_acceleration(DVec3::Z * 0.8, w, r)).length() < 1e-7, "{a:?}");
    assert!((velocity_of(path, 0.0, 0.3) - v).length() < 1e-9);
}

#[test]
fn a_free_particle_in_a_turning_frame_walks_a_straight_line() {
    // The frame turns about z by φ(t) = ω₀ t + ½ α t²; seen from it, the free particle feels all three forces.
    let (w0, alpha, m) = (1.3, 0.4, 2.0);
    let (start, walk) = (DVec3::new(1.0, -0.5, 0.2), DVec3::new(0.3, 0.8, -0.1));
    let omega = |t: f64| DVec3::Z * (w0 + alpha * t);
    let (mut x, mut v) = (start, walk - omega(0.0).cross(start));
    let mut rk4 = Integrator::new(Method::Rk4);
    let (dt, steps) = (1e-3, 5000);
    for n in 0..steps {
        rk4.step_point(f64::from(n) * dt, dt, &mut x, &mut v, |t, x, v| {
            (centrifugal(m, omega(t), x) + coriolis(m, omega(t), v) + euler_force(m, DVec3::Z * alpha, x)) / m
        })
        .expect("steps");
    }
    let t = dt * f64::from(steps);
    let seen = DQuat::from_axis_angle(DVec3::Z, w0 * t + 0.5 * alpha * t * t).rotate(x);
    assert!((seen - (start + walk * t)).length() < 1e-9, "{seen:?}");
}

#[test]
fn closed_forms_of_motion() {
    let (p0, v0, a) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-1.0, 0.5, 2.0), DVec3::new(0.0, -9.81, 1.0));
    let (p, v) = constant_acceleration(p0, v0, a, 3.0);
    let (q, w) = varying_acceleration(p0, v0, |_| a, 3.0, 1e-12).expect("integrates");
    assert!((p - q).length() < 1e-12 && (v - w).length() < 1e-12);
    assert_eq!(constant_velocity(p0, v0, 4.0), DVec3::new(-3.0, 4.0, 11.0));
    // ∫₀^π sin = 2; backwards it is −2.
    let s = displacement(|t| DVec3::X * t.sin(), 0.0, std::f64::consts::PI, 1e-12).expect("integrates");
    assert!((s.value.x - 2.0).abs() < 1e-13 && s.error < 1e-12);
    let s = displacement(|t| DVec3::X * t.sin(), std::f64::consts::PI, 0.0, 1e-12).expect("integrates");
    assert!((s.value.x + 2.0).abs() < 1e-13);
    // A velocity with a corner, √|t − 1/3|, whose integral is known; and one with a jump.
    let s = displacement(|t| DVec3::Y * (t - 1.0 / 3.0).abs().sqrt(), 0.0, 1.0, 1e-9).expect("integrates");
    let exact = 2.0 / 3.0 * ((1.0f64 / 3.0).powf(1.5) + (2.0f64 / 3.0).powf(1.5));
    assert!((s.value.y - exact).abs() < 1e-8, "{s:?} {exact}");
    let jump = velocity_change(|t| if t < 0.3 { DVec3::ZERO } else { DVec3::X }, 0.0, 1.0, 1e-9);
    assert!((jump.expect("integrates").value.x - 0.7).abs() < 1e-8);
    let none = displacement(|_| DVec3::X, 2.0, 2.0, 1e-9).expect("integrates");
    assert_eq!(none.value, DVec3::ZERO);
}

#[test]
fn bad_kinematics_is_refused() {
    let v = |_: f64| DVec3::X;
    assert!(displacement(v, f64::NAN, 1.0, 1e-9).is_err());
    assert!(displacement(v, 0.0, f64::INFINITY, 1e-9).is_err());
    assert!(displacement(v, 0.0, 1.0, 0.0).is_err());
    let e = displacement(|t| DVec3::X / t, -1.0, 1.0, 1e-9).expect_err("a pole").to_string();
    assert!(e.contains("velocity") && e.contains("finite"), "{e}");
}
