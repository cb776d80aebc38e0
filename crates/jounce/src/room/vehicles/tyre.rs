//! The tyre along the ground: brush model with combined slip, deflection that relaxes.
//!
//! Symbols: v velocity of the tread at the patch over the ground (x along, y across the wheel), V_r = |Ω R| speed at which tread runs
//! through the patch, e deflection of the carcass, L relaxation length, C slip stiffness (N), K = C/L, N load, μ friction.
//!
//! Deflection. ė = v − V_r e/L: what enters the patch is straight, what leaves it takes its deflection away. Rolling steadily
//! e = L v/V_r, so K e = C σ with the slip σ = v/V_r; at a standstill e is the way of the tread and K e a spring: static friction. No
//! case divides by a speed. Over a substep h, exactly for constant v:
//!
//! e′ = E e + β v,  E = exp(−V_r h/L),  β = h (1 − E)/(V_r h/L).
//!
//! Force. With w = K e′ + D v and z = |w|/(3 μ N) the brush gives
//!
//! F = −μ N f(z) w/|w|,  f = 3z − 3z² + z³ up to z = 1, then 1 (all of the patch slides),
//!
//! so |F| ≤ μN whatever the slip: the friction circle. D damps the standing wheel and fades with V_r. v is that after the impulse
//! h F (implicit): v′ = v + A h F, hence (1 + h G Q A) w = K E e + Q v with G = f/(3z), Q = K β + D: two unknowns, and z from
//! z + c f(z)/3 = z₀, which has one solution since f rises.
//!
//! Sources: Pacejka, Tyre and Vehicle Dynamics, 3rd ed. 2012, 3.2 (brush, combined slip) and 7.2 (single contact point, relaxation);
//! Besselink 2000 (damping at low speed).

use jounce_math::scalar::f32s;

/// Speed below which a standing tyre is damped, m/s.
const SLOW: f32 = 1.5;

/// A patch, before the solve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    /// v.
    pub v: [f32; 2],
    /// e.
    pub e: [f32; 2],
    /// V_r ≥ 0.
    pub rolling: f32,
    /// N h.
    pub load: f32,
    pub mu: f32,
    /// C, N.
    pub stiffness: [f32; 2],
    /// L.
    pub length: f32,
    /// Mass that rests on the patch, kg: scales D.
    pub mass: f32,
    /// A: velocity along x and y by unit impulses: xx, xy, yx, yy.
    pub a: [f32; 4],
    pub h: f32,
}

/// Impulse of the patch on the wheel, and how it will deflect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Hold {
    pub impulse: [f32; 2],
    /// E and β.
    keep: f32,
    beta: f32,
    /// K, and the size of K e at which all slides.
    k: [f32; 2],
    limit: f32,
}

impl Hold {
    /// e′, given the velocity that came out of all impulses. (With that of this wheel's own A, which knows of the others only by their
    /// number, a parked car would creep.)
    pub fn deflect(&self, e: [f32; 2], v: [f32; 2]) -> [f32; 2] {
        let e = [self.keep * e[0] + self.beta * v[0], self.keep * e[1] + self.beta * v[1]];
        let n = size([self.k[0] * e[0], self.k[1] * e[1]]);
        if n > self.limit { [e[0] * (self.limit / n), e[1] * (self.limit / n)] } else { e }
    }
}

fn size(w: [f32; 2]) -> f32 {
    (w[0] * w[0] + w[1] * w[1]).sqrt()
}

/// f(z)/(3z).
fn secant(z: f32) -> f32 {
    if z < 1.0 { 1.0 - z + z * z * (1.0 / 3.0) } else { 1.0 / (3.0 * z) }
}

/// z with z + c f(z)/3 = z₀.
fn balance(z0: f32, c: f32) -> f32 {
    // All slides.
    if z0 - c * (1.0 / 3.0) >= 1.0 {
        return z0 - c * (1.0 / 3.0);
    }
    let mut z = f32s::min(z0, 1.0);
    for _ in 0..8 {
        let f = z * (3.0 - 3.0 * z + z * z);
        let slope = 1.0 + c * (1.0 - z) * (1.0 - z);
        z = f32s::clamp(z - (z + c * f * (1.0 / 3.0) - z0) / slope, 0.0, 1.0);
    }
    z
}

/// See the module's text.
pub(crate) fn hold(p: &Patch) -> Hold {
    let most = p.mu * p.load;
    if !(most > 0.0 && p.h > 0.0) {
        return Hold::default();
    }
    let x = p.rolling * p.h / p.length;
    let keep = f32s::exp(-f32s::min(x, 80.0));
    let beta = if x < 1e-3 { p.h * (1.0 - 0.5 * x) } else { p.h * (1.0 - keep) / x };
    let fade = f32s::max(1.0 - p.rolling / SLOW, 0.0);
    let k = [p.stiffness[0] / p.length, p.stiffness[1] / p.length];
    let damp = |k: f32| fade * (k * p.mass).sqrt();
    let q = [k[0] * beta + damp(k[0]), k[1] * beta + damp(k[1])];
    let w0 = [k[0] * keep * p.e[0] + q[0] * p.v[0], k[1] * keep * p.e[1] + q[1] * p.v[1]];
    // Q A.
    let m = [q[0] * p.a[0], q[0] * p.a[1], q[1] * p.a[2], q[1] * p.a[3]];
    let limit = 3.0 * most / p.h;
    let mut g = secant(size(w0) / limit);
    let mut w = w0;
    for _ in 0..4 {
        let s = p.h * g;
        let (xx, xy, yx, yy) = (1.0 + s * m[0], s * m[1], s * m[2], 1.0 + s * m[3]);
        let det = xx * yy - xy * yx;
        if det.is_nan() || det <= 0.0 {
            return Hold::default();
        }
        w = [(yy * w0[0] - xy * w0[1]) / det, (xx * w0[1] - yx * w0[0]) / det];
        let n = size(w);
        if n <= 0.0 {
            break;
        }
        let d = [w[0] / n, w[1] / n];
        let c = p.h * (d[0] * (m[0] * d[0] + m[1] * d[1]) + d[1] * (m[2] * d[0] + m[3] * d[1]));
        let z = n / limit;
        g = secant(balance(z * (1.0 + c * g), c));
    }
    let mut j = [-p.h * g * w[0], -p.h * g * w[1]];
    let n = size(j);
    if n > most {
        j = [j[0] * (most / n), j[1] * (most / n)];
    }
    Hold { impulse: j, keep, beta, k, limit }
}

/// How far a tyre is from where all of its patch begins to slide (0) to where it slides as if locked (1), given the velocity v of the
/// tread over the ground, the faster of road and rim, C/N, and μ.
///
/// With the slip σ = |v|/speed and z as above the friction falls as 1/z from z = 1 on, and has come down at σ = 1: the part is
/// (1 − 1/z)/(1 − 1/z₁) with z₁ = z/σ, the z of a locked wheel.
pub(crate) fn sliding(v: [f32; 2], speed: f32, c: [f32; 2], mu: f32) -> f32 {
    let s = 1.0 / f32s::max(speed, 1.0);
    let z = size([c[0] * v[0] * s, c[1] * v[1] * s]) / f32s::max(3.0 * mu, 1e-6);
    let slip = size(v) * s;
    if z <= 1.0 {
        0.0
    } else if slip >= 1.0 {
        1.0
    } else {
        (z - 1.0) / (z - slip)
    }
}

/// μ while so much slides: from the static one to the kinetic one.
pub(crate) fn friction([fixed, kinetic]: [f32; 2], sliding: f32) -> f32 {
    fixed + (kinetic - fixed) * f32s::clamp(sliding, 0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch() -> Patch {
        Patch {
            v: [0.0, 0.0],
            e: [0.0, 0.0],
            rolling: 20.0,
            load: 4000.0 / 240.0,
            mu: 1.0,
            stiffness: [80_000.0, 60_000.0],
            length: 0.3,
            mass: 400.0,
            a: [1.0 / 400.0 + 0.09, 0.0, 0.0, 1.0 / 400.0],
            h: 1.0 / 240.0,
        }
    }

    #[test]
    fn steady_slip_gives_the_brush_curve() {
        for slip in [0.001_f32, 0.02, 0.05, 0.1, 0.3] {
            // A wheel that nothing moves: infinite mass.
            let mut p = Patch { a: [0.0; 4], v: [0.0, slip * 20.0], ..patch() };
            let mut out = Hold::default();
            for _ in 0..200 {
                out = hold(&p);
                p.e = out.deflect(p.e, p.v);
            }
            let z = f32s::min(60_000.0 * slip / (3.0 * 4000.0), 1.0);
            let want = 4000.0 * z * (3.0 - 3.0 * z + z * z);
            let got = -out.impulse[1] * 240.0;
            assert!((got / want - 1.0).abs() < 2e-3, "slip {slip}: {got} for {want}");
        }
    }

    #[test]
    fn force_builds_up_over_the_relaxation_length() {
        // After one relaxation length at small slip: 1 − 1/e.
        let mut p = Patch { a: [0.0; 4], v: [0.0, 0.02], ..patch() };
        let steps = (0.3 / 20.0 * 240.0 * 1000.0_f32).round() as usize;
        p.h /= 1000.0;
        p.load /= 1000.0;
        let mut out = Hold::default();
        for _ in 0..steps {
            out = hold(&p);
            p.e = out.deflect(p.e, p.v);
        }
        let part = -out.impulse[1] / p.h / (60_000.0 * 0.001);
        assert!((part - 0.632_12).abs() < 5e-3, "{part}");
    }

    #[test]
    fn a_locked_tyre_has_the_kinetic_friction() {
        for c in [3.5_f32, 8.0, 20.0, 60.0] {
            let at = |slip: f32| friction([0.9, 0.6], sliding([slip * 20.0, 0.0], 20.0, [c, c], 0.9));
            assert!((at(1.0) - 0.6).abs() < 1e-6, "locked: {} of C/N {c}", at(1.0));
            assert!((at(2.7 / c) - 0.9).abs() < 1e-5, "where all slides: {} of C/N {c}", at(2.7 / c));
            let mut last = 0.9 + 1e-6;
            for i in 0..=100 {
                let mu = at(0.01 * i as f32);
                assert!(mu <= last && mu >= 0.6 - 1e-6, "{mu} after {last} at slip {i} %");
                last = mu + 1e-6;
            }
        }
    }

    #[test]
    fn the_circle_holds_for_any_input() {
        let mut seed = 9_u64;
        let mut random = |lo: f32, hi: f32| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            lo + (hi - lo) * ((seed >> 40) as f32 / (1 << 24) as f32)
        };
        for _ in 0..200_000 {
            let p = Patch {
                v: [random(-60.0, 60.0), random(-60.0, 60.0)],
                e: [random(-0.5, 0.5), random(-0.5, 0.5)],
                rolling: f32s::max(random(-50.0, 80.0), 0.0),
                load: random(0.0, 100.0),
                mu: random(0.0, 2.0),
                stiffness: [random(1e2, 1e6), random(1e2, 1e6)],
                length: random(0.01, 2.0),
                mass: random(1.0, 2000.0),
                a: [random(0.0, 0.2), random(-0.01, 0.01), random(-0.01, 0.01), random(0.0, 0.2)],
                h: random(1e-4, 0.02),
            };
            let out = hold(&p);
            let n = (out.impulse[0] * out.impulse[0] + out.impulse[1] * out.impulse[1]).sqrt();
            assert!(n <= p.mu * p.load * 1.000_01, "{n} for {p:?}");
            assert!(out.deflect(p.e, p.v).iter().all(|e| e.is_finite()));
        }
    }
}
