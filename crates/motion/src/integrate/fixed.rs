//! Methods of one given step.
//!
//! | method | y′ or (x′, v′) |
//! |---|---|
//! | explicit Euler | y + h f(t, y) |
//! | midpoint | y + h f(t + h/2, y + h/2 k₁) |
//! | RK4 | y + h/6 (k₁ + 2 k₂ + 2 k₃ + k₄) |
//! | lecture loop | x + h v, then v + h a(t, x, v) |
//! | semi-implicit Euler | v + h a(t, x, v), then x + h v′ |
//! | velocity Verlet | x + h v + h²/2 a, then v + h/2 (a + a(t + h, x′, v + h a)) |
//!
//! h is the step, k the slopes. With forces that depend on the velocity, Verlet's second acceleration is taken at the
//! predicted velocity v + h a, whose error h² keeps the method at second order.
//! Source: the lecture; E. Hairer, S. P. Nørsett and G. Wanner, *Solving Ordinary Differential Equations I*, II.1.

use super::Vector;

/// y += s k.
pub(super) fn add_scaled<V: Vector>(y: &mut [V], s: f64, k: &[V]) {
    for (y, k) in y.iter_mut().zip(k) {
        *y = *y + *k * s;
    }
}

/// out = y + s k.
pub(super) fn sum_scaled<V: Vector>(out: &mut [V], y: &[V], s: f64, k: &[V]) {
    for ((out, y), k) in out.iter_mut().zip(y).zip(k) {
        *out = *y + *k * s;
    }
}

pub(super) fn euler<V: Vector>(
    t: f64,
    h: f64,
    y: &mut [V],
    k: &mut [V],
    f: &mut impl FnMut(f64, &[V], &mut [V]),
) {
    f(t, y, k);
    add_scaled(y, h, k);
}

pub(super) fn midpoint<V: Vector>(
    t: f64,
    h: f64,
    y: &mut [V],
    [k, mid, ..]: &mut [Vec<V>; 8],
    f: &mut impl FnMut(f64, &[V], &mut [V]),
) {
    f(t, y, k);
    sum_scaled(mid, y, 0.5 * h, k);
    f(t + 0.5 * h, mid, k);
    add_scaled(y, h, k);
}

pub(super) fn rk4<V: Vector>(
    t: f64,
    h: f64,
    y: &mut [V],
    [k1, k2, k3, k4, at, ..]: &mut [Vec<V>; 8],
    f: &mut impl FnMut(f64, &[V], &mut [V]),
) {
    f(t, y, k1);
    sum_scaled(at, y, 0.5 * h, k1);
    f(t + 0.5 * h, at, k2);
    sum_scaled(at, y, 0.5 * h, k2);
    f(t + 0.5 * h, at, k3);
    sum_scaled(at, y, h, k3);
    f(t + h, at, k4);
    for (i, y) in y.iter_mut().enumerate() {
        *y = *y + (k1[i] + k2[i] * 2.0 + k3[i] * 2.0 + k4[i]) * (h / 6.0);
    }
}

/// The loop of the lecture, with the acceleration of the state that the pass begins with.
pub(super) fn lecture_loop<V: Vector>(
    t: f64,
    h: f64,
    x: &mut [V],
    v: &mut [V],
    k: &mut [V],
    a: &mut impl FnMut(f64, &[V], &[V], &mut [V]),
) {
    a(t, x, v, k);
    add_scaled(x, h, v);
    add_scaled(v, h, k);
}

pub(super) fn semi_implicit_euler<V: Vector>(
    t: f64,
    h: f64,
    x: &mut [V],
    v: &mut [V],
    k: &mut [V],
    a: &mut impl FnMut(f64, &[V], &[V], &mut [V]),
) {
    a(t, x, v, k);
    add_scaled(v, h, k);
    add_scaled(x, h, v);
}

pub(super) fn velocity_verlet<V: Vector>(
    t: f64,
    h: f64,
    x: &mut [V],
    v: &mut [V],
    [k1, k2, predicted, ..]: &mut [Vec<V>; 8],
    a: &mut impl FnMut(f64, &[V], &[V], &mut [V]),
) {
    let n = x.len();
    let (k1, k2, predicted) = (&mut k1[..n], &mut k2[..n], &mut predicted[..n]);
    a(t, x, v, k1);
    for i in 0..n {
        x[i] = x[i] + v[i] * h + k1[i] * (0.5 * h * h);
    }
    sum_scaled(predicted, v, h, k1);
    a(t + h, x, predicted, k2);
    for i in 0..n {
        v[i] = v[i] + (k1[i] + k2[i]) * (0.5 * h);
    }
}
