//! A wheel's travel: spring, damper, bump stop and the tyre's own spring, solved together for one substep.
//!
//! Symbols: s travel, down positive, 0 at rest; u its speed; m unsprung mass; d direction of travel (down), n normal of the ground,
//! κ = −n·d; δ depth of the tyre in the ground, w its speed of closing; F₀ force of all springs at s; k, c stiffness and damping of the
//! suspension, k_t, c_t of the tyre; j_s, j_t impulses of both; K 1/mass of the chassis along d; G that of the ground along n.
//!
//! u′ = u + (j_s − κ j_t)/m
//! w′ = w + κ (j_s − κ j_t)/m − κ K j_s − (1 − κ²) K j_t − G j_t
//! j_s = h (F₀ − θ h k u′ − c u′),  j_t = h (k_t (δ + θ_t h w′) + c_t w′) ≥ 0
//!
//! Two linear equations. Dampers are implicit; springs too (θ = 1) where h ω > 1 would not be resolved, and semi-implicit (θ = 0, no
//! numerical damping) where h ω < ½. At the end of the bump the travel is given, u′ = (s_min − s)/h, and j_s follows: a hard stop.
//!
//! The wheel's momentum is m u d, *relative* to the chassis, whose mass has all of the vehicle: the sum is kept to rounding, weight and
//! load transfer are exact, and what is left out is m (g − dV/dt) on the travel: m/M of the frequency of the body's bounce.

use super::desc::WheelDesc;
use jounce_math::scalar::f32s;

/// What a wheel's travel meets in a substep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Travel {
    pub s: f32,
    pub u: f32,
    /// F of the anti-roll bars on the wheel, downward, and their stiffness.
    pub bar: f32,
    pub bar_stiffness: f32,
    /// There is ground.
    pub touches: bool,
    /// δ.
    pub depth: f32,
    pub closing: f32,
    pub kappa: f32,
    /// K, G.
    pub chassis: f32,
    pub ground: f32,
    pub h: f32,
}

/// Impulses of both springs, and the travel's speed after.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Spring {
    /// j_s.
    pub spring: f32,
    /// j_t.
    pub tyre: f32,
    /// u′.
    pub u: f32,
}

/// Force of spring and rubber at a travel, and their stiffness there.
pub(crate) fn force(w: &WheelDesc, s: f32) -> (f32, f32) {
    let mut f = w.preload - w.stiffness * s;
    let mut k = w.stiffness;
    // A spring does not pull the wheel up.
    if f < 0.0 {
        (f, k) = (0.0, 0.0);
    }
    let into = w.bump_stop - w.bump - s;
    if into > 0.0 {
        f += w.bump_stop_stiffness * into;
        k += w.bump_stop_stiffness;
    }
    (f, k)
}

/// θ for a spring of x = hω.
fn theta(x: f32) -> f32 {
    f32s::clamp(2.0 * x - 1.0, 0.0, 1.0)
}

pub(crate) fn solve(w: &WheelDesc, t: &Travel) -> Spring {
    let (h, m) = (t.h, w.mass);
    let (f, k) = force(w, t.s);
    let k = k + t.bar_stiffness;
    let f0 = f + t.bar;
    let c = if t.u < 0.0 { w.bump_damping } else { w.rebound_damping };
    let qs = h * (c + theta(h * (k / m).sqrt()) * h * k);
    let (kt, ct) = (w.tyre.radial_stiffness, w.tyre.radial_damping);
    let qt = h * (ct + theta(h * (kt / m).sqrt()) * h * kt);
    let touches = t.touches;
    let kappa = t.kappa;
    let side = (1.0 - kappa * kappa) * t.chassis + t.ground;
    let free = (h * f0 - qs * t.u) / (1.0 + qs / m);
    let mut out = Spring { spring: free, tyre: 0.0, u: t.u + free / m };
    if touches {
        let (a11, a12) = (1.0 + qs / m, -qs * kappa / m);
        let a21 = -qt * kappa * (1.0 / m - t.chassis);
        let a22 = 1.0 + qt * (kappa * kappa / m + side);
        let (b1, b2) = (h * f0 - qs * t.u, h * kt * t.depth + qt * t.closing);
        let det = a11 * a22 - a12 * a21;
        let jt = (a11 * b2 - a21 * b1) / det;
        if jt > 0.0 && det > 0.0 {
            let js = (b1 - a12 * jt) / a11;
            out = Spring { spring: js, tyre: jt, u: t.u + (js - kappa * jt) / m };
        }
    }
    // Hard ends of the travel.
    let (low, high) = ((-w.bump - t.s) / h, (w.droop - t.s) / h);
    if out.u < low || out.u > high {
        let u = f32s::clamp(out.u, low, high);
        let push = m * (u - t.u);
        let mut jt = 0.0;
        if touches {
            // w′ = w + κ (u′ − u) − κ K j_s − side j_t, j_s = push + κ j_t.
            let b = h * kt * t.depth + qt * (t.closing + kappa * (u - t.u) - kappa * t.chassis * push);
            jt = f32s::max(b / (1.0 + qt * (kappa * kappa * t.chassis + side)), 0.0);
        }
        out = Spring { spring: push + kappa * jt, tyre: jt, u };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settle(w: &WheelDesc, load: f32, mass: f32, h: f32) -> (f32, f32) {
        // A quarter of a car over flat ground at rest height R below the hub.
        let (mut y, mut v, mut s, mut u) = (0.0_f64, 0.0_f32, 0.0_f32, 0.0_f32);
        let mut last = Spring::default();
        for _ in 0..(20.0 / h) as usize {
            v -= 9.81 * h * (load / (9.81 * mass));
            let t = Travel {
                s,
                u,
                touches: s - y as f32 > 0.0,
                depth: s - y as f32,
                closing: u - v,
                kappa: 1.0,
                chassis: 1.0 / mass,
                h,
                ..Travel::default()
            };
            last = solve(w, &t);
            v += last.spring / mass;
            u = last.u;
            y += f64::from(v * h);
            s += u * h;
        }
        (last.tyre / h, s)
    }

    #[test]
    fn a_standing_wheel_carries_its_load() {
        let w = WheelDesc::new([0.0, 0.0, 0.0], 3000.0);
        for (load, h) in
            [(3000.0, 1.0 / 240.0), (3600.0, 1.0 / 240.0), (3000.0, 1.0 / 60.0), (3000.0, 1.0 / 30.0)]
        {
            let (n, s) = settle(&w, load, 300.0, h);
            assert!((n / load - 1.0).abs() < 1e-3, "{n} for {load}");
            let want = (3000.0 - load) / 30_000.0;
            assert!((s - want).abs() < 1e-4, "{s} for {want}");
        }
    }

    #[test]
    fn an_overloaded_wheel_stands_on_its_stop() {
        let mut w = WheelDesc::new([0.0, 0.0, 0.0], 3000.0);
        // 3 t on the tyre alone would bounce for a minute.
        w.tyre.radial_damping = 5000.0;
        let (n, s) = settle(&w, 30_000.0, 3000.0, 1.0 / 240.0);
        assert!((n / 30_000.0 - 1.0).abs() < 1e-2 && (s + w.bump).abs() < 1e-3, "{n} at {s}");
    }
}
