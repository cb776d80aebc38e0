//! Integrators against closed forms: the lecture's loop, orders, stability, adaptive steps, stiff systems.
#![expect(clippy::disallowed_methods, reason = "the reference side of a test may use std's functions")]

use jounce_math::DVec3;
use jounce_motion::integrate::{Dopri5, Integrator, Measure, Method, Options};
use jounce_motion::{Error, limits};

/// The lecture: F = 10, m = 1, Δt = 1, from rest.
fn lecture(method: Method, passes: u32) -> (f64, f64) {
    let (mut x, mut v) = (0.0, 0.0);
    let mut integrator = Integrator::new(method);
    for n in 0..passes {
        integrator.step_point(f64::from(n), 1.0, &mut x, &mut v, |_, _, _| 10.0 / 1.0).expect("steps");
    }
    (x, v)
}

#[test]
fn the_lectures_loop_gives_450_and_550() {
    // The loop runs while t ≤ 10: eleven passes. Exact: ½·10·t² = 500 and 605.
    assert_eq!(lecture(Method::LectureLoop, 10), (450.0, 100.0));
    assert_eq!(lecture(Method::LectureLoop, 11), (550.0, 110.0));
    assert_eq!(lecture(Method::ExplicitEuler, 10), (450.0, 100.0));
    assert_eq!(lecture(Method::SemiImplicitEuler, 10), (550.0, 100.0));
    assert_eq!(lecture(Method::ImplicitEuler, 10), (550.0, 100.0));
    for exact in [Method::VelocityVerlet, Method::Midpoint, Method::Rk4, Method::Dopri5] {
        assert!((lecture(exact, 10).0 - 500.0).abs() < 1e-10, "{exact}");
        assert!((lecture(exact, 11).0 - 605.0).abs() < 1e-10, "{exact}");
    }
}

#[test]
fn explicit_eulers_error_is_half_a_t_dt() {
    let (a, dt, n) = (3.0, 0.25, 64);
    for (method, sign) in [(Method::ExplicitEuler, -1.0), (Method::SemiImplicitEuler, 1.0)] {
        let (mut x, mut v) = (2.0, -1.0);
        let mut integrator = Integrator::new(method);
        for i in 0..n {
            integrator.step_point(f64::from(i) * dt, dt, &mut x, &mut v, |_, _, _| a).expect("steps");
        }
        let t = dt * f64::from(n);
        let exact = 2.0 - t + 0.5 * a * t * t;
        // All numbers are short binary fractions: no rounding, so to the bit.
        assert_eq!(x - exact, sign * 0.5 * a * t * dt, "{method}");
    }
}

/// Largest error of (x, v/ω) on t ∈ [0, 5] of a harmonic oscillator with ω = 2.
fn oscillator_error(method: Method, dt: f64) -> f64 {
    let w: f64 = 2.0;
    let (mut x, mut v) = (1.0, 0.0);
    let mut integrator = Integrator::new(method);
    let (mut worst, steps) = (0.0f64, (5.0 / dt).round() as u32);
    for n in 0..steps {
        integrator.step_point(f64::from(n) * dt, dt, &mut x, &mut v, |_, x, _| -w * w * x).expect("steps");
        let phase = w * f64::from(n + 1) * dt;
        worst = worst.max((x - phase.cos()).hypot(v / w + phase.sin()));
    }
    worst
}

#[test]
fn orders_are_those_of_theory() {
    // dt small enough for the leading term, large enough for errors above rounding (1e-13).
    let cases = [
        (Method::ExplicitEuler, 5e-4),
        (Method::LectureLoop, 5e-4),
        (Method::SemiImplicitEuler, 5e-4),
        (Method::ImplicitEuler, 5e-4),
        (Method::Midpoint, 5e-3),
        (Method::VelocityVerlet, 5e-3),
        (Method::Rk4, 1e-2),
        (Method::Dopri5, 2e-2),
    ];
    for (method, dt) in cases {
        let slope = (oscillator_error(method, dt) / oscillator_error(method, 0.5 * dt)).log2();
        assert!((slope - f64::from(method.order())).abs() < 0.1, "{method}: slope {slope}");
    }
}

/// A spring that is driven and damped by the square of the speed, x″ = sin t − x − ½ |v| v, against a very fine RK4.
fn driven_error(method: Method, dt: f64) -> f64 {
    let run = |method, dt: f64| {
        let (mut x, mut v) = (1.0, 0.0);
        let mut integrator = Integrator::new(method);
        for n in 0..(4.0 / dt).round() as u32 {
            let t = f64::from(n) * dt;
            integrator
                .step_point(t, dt, &mut x, &mut v, |t, x, v| t.sin() - x - 0.5 * v * v.abs())
                .expect("steps");
        }
        (x, v)
    };
    let (exact, got) = (run(Method::Rk4, 1e-3), run(method, dt));
    (got.0 - exact.0).hypot(got.1 - exact.1)
}

#[test]
fn orders_hold_with_forces_of_velocity_and_time() {
    // |v| v has a kink in its second derivative where v = 0, so orders above 2 are not asked here.
    for (method, dt) in [
        (Method::ExplicitEuler, 1e-3),
        (Method::SemiImplicitEuler, 1e-3),
        (Method::ImplicitEuler, 1e-3),
        (Method::Midpoint, 1e-2),
        (Method::VelocityVerlet, 1e-2),
    ] {
        let slope = (driven_error(method, dt) / driven_error(method, 0.5 * dt)).log2();
        assert!((slope - f64::from(method.order())).abs() < 0.1, "{method}: slope {slope}");
    }
}

/// Amplitude after 400 steps of an undamped spring.
fn amplitude(method: Method, w_dt: f64) -> f64 {
    let (mut x, mut v) = (1.0, 0.0);
    let mut integrator = Integrator::new(method);
    let mut largest = 0.0f64;
    for n in 0..400 {
        let done = integrator.step_point(f64::from(n) * w_dt, w_dt, &mut x, &mut v, |_, x, _| -x);
        if done.is_err() {
            return f64::INFINITY;
        }
        largest = largest.max(x.hypot(v));
    }
    largest
}

#[test]
fn stability_ranges() {
    for w_dt in [0.1f64, 0.5, 1.0, 1.9, 2.1, 5.0, 10.0] {
        // |1 + i ω Δt|ⁿ grows without bound.
        let grown = (1.0 + w_dt * w_dt).powf(200.0);
        assert!(amplitude(Method::ExplicitEuler, w_dt) > 0.9 * grown.min(1e300), "explicit {w_dt}");
        assert!(amplitude(Method::ImplicitEuler, w_dt) <= 1.0, "implicit {w_dt}");
        // The energy-like invariant x² + v² − ω Δt x v of the semi-implicit method is an ellipse below 2.
        let semi = amplitude(Method::SemiImplicitEuler, w_dt);
        let verlet = amplitude(Method::VelocityVerlet, w_dt);
        if w_dt < 2.0 {
            let bound = (2.0 / (2.0 - w_dt)).sqrt() * (1.0 + w_dt);
            assert!(semi < bound && verlet < bound, "{w_dt}: {semi} {verlet}");
        } else {
            assert!(semi > 1e6 && verlet > 1e6, "{w_dt}: {semi} {verlet}");
        }
    }
    // RK4's limit on the imaginary axis is 2√2.
    assert!(amplitude(Method::Rk4, 2.8) <= 1.01 && amplitude(Method::Rk4, 2.9) > 10.0);
}

#[test]
fn verlet_goes_back_where_it_came_from() {
    let force = |_: f64, x: DVec3, _: DVec3| x * (-1.0 / x.length().powi(3));
    let (x0, v0) = (DVec3::X, DVec3::Y * 0.9);
    let (mut x, mut v) = (x0, v0);
    let mut verlet = Integrator::new(Method::VelocityVerlet);
    for dt in [0.01, -0.01] {
        for _ in 0..500 {
            verlet.step_point(0.0, dt, &mut x, &mut v, force).expect("steps");
        }
    }
    assert!((x - x0).length() < 1e-11 && (v - v0).length() < 1e-11);
}

/// A body pulled hard once, at t = 1, for a tenth of a second.
fn kick(t: f64) -> f64 {
    let u = (t - 1.0) / 0.05;
    200.0 * (-u * u).exp()
}

#[test]
fn adaptive_euler_keeps_its_tolerance_and_follows_the_force() {
    let options = Options { tolerance: 1e-2, dt_min: 1e-7, dt_max: 0.1, ..Options::default() };
    let mut euler = Integrator::with_options(Method::AdaptiveEuler, options).expect("options");
    let (mut x, mut v) = (0.0, 0.0);
    let (mut quiet, mut busy) = (0.0f64, f64::MAX);
    let mut rejected = 0;
    for n in 0..20 {
        let t = f64::from(n) * 0.1;
        let r = euler.step_point(t, 0.1, &mut x, &mut v, |t, _, _| kick(t)).expect("steps");
        assert!(r.error_max <= 1e-2 && r.forced == 0, "{r:?}");
        rejected += r.rejected;
        if n < 5 {
            quiet = quiet.max(r.dt_longest);
        }
        if n == 9 || n == 10 {
            busy = busy.min(r.dt_shortest);
        }
    }
    assert!(rejected > 0, "a force that comes suddenly makes a step too long");
    assert!(quiet > 0.09 && busy < 0.01, "{quiet} {busy}");
    // Impulse of the kick: 200 · 0.05 √π. Every step is within 1e-2, and there are fewer than a hundred.
    let impulse = 200.0 * 0.05 * std::f64::consts::PI.sqrt();
    assert!((v - impulse).abs() < 0.5, "{v} against {impulse}");
}

#[test]
fn adaptive_euler_chooses_the_step_of_the_formula() {
    // v′ = −c v: one step leaves v(1 − cΔt), two leave v(1 − cΔt/2)²; E = v c²Δt²/4, and Δt′ = √(E_tol/E) Δt.
    let options = Options { tolerance: 1e-4, safety: 1.0, ..Options::default() };
    let mut euler = Integrator::with_options(Method::AdaptiveEuler, options).expect("options");
    let mut y = [1.0];
    let dt: f64 = 1e-3;
    euler.step(0.0, dt, &mut y, |_, y, dy| dy[0] = -3.0 * y[0]).expect("steps");
    let e = 9.0 * dt * dt / 4.0;
    let ideal = (1e-4 / e).sqrt() * dt;
    assert!((euler.dt_next() - ideal).abs() < 1e-9 * ideal, "{} against {ideal}", euler.dt_next());
    assert!((y[0] - (1.0 - 0.5 * 3.0 * dt).powi(2)).abs() < 1e-15, "the two half steps are kept");
}

#[test]
fn adaptive_euler_halves_its_steps_for_a_quarter_of_the_error() {
    let steps = |tolerance| {
        let options = Options { tolerance, measure: Measure::State, ..Options::default() };
        let mut euler = Integrator::with_options(Method::AdaptiveEuler, options).expect("options");
        let (mut x, mut v) = (1.0, 0.0);
        euler.step_point(0.0, 10.0, &mut x, &mut v, |_, x, _| -x).expect("steps").steps as f64
    };
    let ratio = steps(1e-6) / steps(4e-6);
    assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
}

#[test]
fn adaptive_euler_sees_only_velocities_unless_told() {
    // A constant force: velocities are exact, E = 0, the step grows to the ceiling; the state has an error to bound.
    let run = |measure| {
        let options = Options { measure, tolerance: 1e-3, dt_max: 1.0, ..Options::default() };
        let mut euler = Integrator::with_options(Method::AdaptiveEuler, options).expect("options");
        let (mut x, mut v) = (0.0, 0.0);
        euler.step_point(0.0, 4.0, &mut x, &mut v, |_, _, _| 10.0).expect("steps")
    };
    assert_eq!(run(Measure::Velocity).steps, 4);
    let whole = run(Measure::State);
    assert!(whole.error_max <= 1e-3 && whole.steps > 100, "{whole:?}");
}

#[test]
fn adaptive_euler_stops_at_its_floor_and_says_so() {
    let options = Options { tolerance: 1e-12, dt_min: 1e-2, measure: Measure::State, ..Options::default() };
    let mut euler = Integrator::with_options(Method::AdaptiveEuler, options).expect("options");
    let (mut x, mut v) = (1.0, 0.0);
    let r = euler.step_point(0.0, 1.0, &mut x, &mut v, |_, x, _| -x).expect("steps");
    assert!(r.forced >= 99 && r.error_max > 1e-12, "{r:?}");
}

#[test]
fn dopri5_keeps_its_tolerance_and_knows_what_lies_between() {
    for tolerance in [1e-6, 1e-8, 1e-10] {
        let options = Options {
            relative_tolerance: tolerance,
            absolute_tolerance: tolerance,
            dt_min: 1e-14,
            ..Options::default()
        };
        let mut f = |_: f64, y: &[f64], dy: &mut [f64]| (dy[0], dy[1]) = (y[1], -y[0]);
        let mut solver = Dopri5::new(0.0, &[1.0, 0.0], options).expect("solver");
        let (mut worst, mut between) = (0.0f64, 0.0f64);
        while solver.time() < 20.0 {
            let r = solver.step(20.0, &mut f).expect("steps");
            assert!(r.error_max <= 1.0 && r.forced == 0);
            worst = worst.max((solver.state()[0] - solver.time().cos()).abs());
            for part in [0.25, 0.5, 0.8] {
                let t = solver.time_before() + part * (solver.time() - solver.time_before());
                let mut y = [0.0; 2];
                solver.state_at(t, &mut y);
                between = between.max((y[0] - t.cos()).abs());
            }
        }
        assert_eq!(solver.time(), 20.0);
        // At most every step errs by the tolerance in the same direction: 20 s of steps of at most 1 s; the dense
        // output is one order lower.
        assert!(worst < 100.0 * tolerance, "{tolerance}: {worst}");
        assert!(between < 100.0 * tolerance, "{tolerance}: {between}");
    }
}

#[test]
fn dopri5_takes_short_steps_near_the_sun() {
    // Kepler, a = GM = 1, e = 0.9: from the aphelion round once.
    let mut orbit = Integrator::new(Method::AdaptiveDopri5);
    let (x0, v0) = (DVec3::X * 1.9, DVec3::Y * (0.1f64 / 1.9).sqrt());
    let (mut x, mut v) = (x0, v0);
    let r = orbit
        .step_point(0.0, std::f64::consts::TAU, &mut x, &mut v, |_, x, _| x * (-1.0 / x.length().powi(3)))
        .expect("steps");
    assert!((x - x0).length() < 1e-6 && (v - v0).length() < 1e-6, "{x:?} {v:?}");
    assert!(r.dt_longest > 30.0 * r.dt_shortest, "{r:?}");
}

/// A chain of masses and stiff springs between two walls, started askew.
fn chain(n: usize) -> Vec<f64> {
    (0..n).map(|i| ((i * 7919) % 13) as f64 / 13.0).collect()
}

fn chain_force(x: &[f64], v: &[f64], a: &mut [f64]) {
    let n = x.len();
    for i in 0..n {
        let left = if i > 0 { x[i - 1] } else { 0.0 };
        let right = if i + 1 < n { x[i + 1] } else { 0.0 };
        a[i] = 1e6 * (left + right - 2.0 * x[i]) - 0.1 * v[i];
    }
}

#[test]
fn implicit_euler_solves_a_large_stiff_chain() {
    // ω Δt up to 2·1e3·0.01 = 20 on 3000 unknowns.
    let mut x = chain(3000);
    let mut v = vec![0.0; x.len()];
    let mut implicit = Integrator::new(Method::ImplicitEuler);
    let dt = 0.01;
    for n in 0..5 {
        let (x0, v0) = (x.clone(), v.clone());
        implicit
            .step_motion(f64::from(n) * dt, dt, &mut x, &mut v, |_, x, v, a| chain_force(x, v, a))
            .expect("solves");
        // The equation itself, not the solver's own residual.
        let mut a = vec![0.0; x.len()];
        chain_force(&x, &v, &mut a);
        let size = v.iter().map(|v| v * v).sum::<f64>().sqrt();
        let off = (0..x.len()).map(|i| (v[i] - v0[i] - dt * a[i]).powi(2)).sum::<f64>().sqrt();
        assert!(off < 1e-6 * size, "step {n}: {off} of {size}");
        assert!((x[7] - x0[7] - dt * v[7]).abs() < 1e-12);
    }
    let energy = |x: &[f64], v: &[f64]| {
        let kinetic: f64 = v.iter().map(|v| 0.5 * v * v).sum();
        kinetic + x.windows(2).map(|w| 0.5e6 * (w[1] - w[0]).powi(2)).sum::<f64>()
    };
    let start = chain(3000);
    assert!(energy(&x, &v) < energy(&start, &vec![0.0; 3000]), "implicit Euler never gains");
}

#[test]
fn implicit_euler_of_a_stiff_first_order_system() {
    // y′ = −1000 (y − cos t): the step is fifty times the time constant.
    let mut y = [0.0];
    let mut implicit = Integrator::new(Method::ImplicitEuler);
    for n in 0..40 {
        let t = f64::from(n) * 0.05;
        implicit.step(t, 0.05, &mut y, |t, y, dy| dy[0] = -1000.0 * (y[0] - t.cos())).expect("steps");
    }
    // The slow solution is cos t + O(1/1000); the method's error is Δt/1000 on top.
    assert!((y[0] - 2.0f64.cos()).abs() < 2e-3, "{}", y[0]);
}

#[test]
fn a_general_system_of_first_order_in_every_method_that_has_one() {
    // Lotka–Volterra, whose invariant x − ln x + y − ln y every good method keeps for a while.
    for method in Method::ALL {
        let mut y = [2.0, 1.0];
        let mut integrator = Integrator::new(method);
        let rate = |_: f64, y: &[f64], dy: &mut [f64]| {
            (dy[0], dy[1]) = (y[0] * (1.0 - y[1]), y[1] * (y[0] - 1.0));
        };
        let done =
            (0..1000).try_for_each(|n| integrator.step(f64::from(n) * 1e-3, 1e-3, &mut y, rate).map(|_| ()));
        if matches!(method, Method::SemiImplicitEuler | Method::VelocityVerlet) {
            assert!(matches!(done, Err(Error::Unsupported { .. })), "{method}");
        } else {
            done.expect("steps");
            let drift = y[0] - y[0].ln() + y[1] - y[1].ln() - (3.0 - 2.0f64.ln());
            assert!(drift.abs() < 2e-3, "{method}: {drift}");
        }
    }
}

#[test]
fn names_go_there_and_back() {
    for m in Method::ALL {
        assert_eq!(m.to_string().parse::<Method>().expect("parses"), m);
    }
    let e = "rk5".parse::<Method>().expect_err("no such method").to_string();
    assert!(e.contains("rk5") && e.contains("rk4"), "{e}");
}

#[test]
fn bad_input_is_refused_and_changes_nothing() {
    let (mut x, mut v) = ([1.0, f64::NAN], [0.0, 0.0]);
    for method in Method::ALL {
        let mut i = Integrator::new(method);
        assert!(i.step_motion(0.0, 0.1, &mut x, &mut v, |_, _, _, a| a.fill(0.0)).is_err(), "{method}");
        assert!(i.step_motion(0.0, f64::NAN, &mut [1.0], &mut [1.0], |_, _, _, a| a.fill(0.0)).is_err());
        assert!(i.step_motion(0.0, 0.1, &mut [1.0], &mut [], |_, _, _, a| a.fill(0.0)).is_err());
        let (mut p, mut q) = (1.0, 2.0);
        let e = i.step_point(0.0, 0.1, &mut p, &mut q, |_, _, _| f64::NAN);
        assert!(matches!(e, Err(Error::Failed { .. })), "{method}: {e:?}");
        assert_eq!((p, q), (1.0, 2.0), "{method}");
        i.step_motion(0.0, 0.1, &mut [], &mut [], |_, _, _, _| ()).expect("nothing to move");
    }
    assert!(
        Integrator::<f64>::with_options(Method::Rk4, Options { safety: 2.0, ..Options::default() }).is_err()
    );
    assert!(Dopri5::new(f64::NAN, &[1.0], Options::default()).is_err());
    // A pole: y′ = y² runs to infinity at t = 1.
    let mut y = [1.0];
    let far = Integrator::new(Method::AdaptiveDopri5).step(0.0, 2.0, &mut y, |_, y, dy| dy[0] = y[0] * y[0]);
    assert!(matches!(far, Err(Error::Failed { .. })), "{far:?}");
    assert_eq!(y, [1.0]);
    const { assert!(limits::STEPS_MAX >= 1_000_000) };
}
