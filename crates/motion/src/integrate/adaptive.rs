//! Explicit Euler with adaptive step size, as in the lecture.
//!
//! One step of Δt gives y₁, two of Δt/2 give y₂. Both are off by something of order Δt², hence so is their difference,
//! E = |y₁ − y₂|, and the step that would just be tolerated is Δt′ = √(E_tol / E) Δt. A step with E > E_tol is taken
//! again, shorter; one within it is kept, with y₂, the better of the two.
//!
//! E_tol: tolerated error of a step; S: safety, a factor a little below 1, since E is an estimate; floor and ceiling
//! bound Δt. At the floor a step is kept whatever its error, and counted as forced.
//! In a mechanical system E is measured on the velocities, as on the slide, or on the whole state.

use super::fixed::{add_scaled, sum_scaled};
use super::{Options, Report, Vector};
use crate::error::{Error, Result};
use crate::limits::STEPS_MAX;
use core::ops::Range;
use jounce_math::scalar::f64s::{clamp, max, min};

/// Takes `y` from `t` over `dt` (above 0), in as many steps as the tolerance asks for; `next` is the step to try, kept
/// from call to call.
pub(super) fn adaptive_euler<V: Vector>(
    t: f64,
    dt: f64,
    y: &mut [V],
    measured: Range<usize>,
    o: &Options,
    next: &mut f64,
    [k, once, twice, ..]: &mut [Vec<V>; 8],
    f: &mut impl FnMut(f64, &[V], &mut [V]),
) -> Result<Report> {
    let (mut now, end) = (t, t + dt);
    let mut report = Report::default();
    let mut h = clamp(if *next > 0.0 { *next } else { dt }, o.dt_min, o.dt_max);
    for _ in 0..STEPS_MAX {
        let last = h >= end - now;
        let step = if last { end - now } else { h };
        f(now, y, k);
        sum_scaled(once, y, step, k);
        sum_scaled(twice, y, 0.5 * step, k);
        f(now + 0.5 * step, twice, k);
        add_scaled(twice, 0.5 * step, k);
        report.evaluations += 2;
        let e = measured.clone().fold(0.0, |s, i| {
            let d = once[i] - twice[i];
            s + d.dot(d)
        });
        let e = e.sqrt();
        if !e.is_finite() && step <= o.dt_min {
            return Err(not_finite(now));
        }
        let ideal = if e > 0.0 { o.safety * (o.tolerance / e).sqrt() * step } else { f64::INFINITY };
        if e <= o.tolerance || step <= o.dt_min {
            report.accept(step, e);
            report.forced += u64::from(e > o.tolerance);
            y.copy_from_slice(twice);
            now += step;
            h = clamp(ideal, o.dt_min, o.dt_max);
            if last {
                *next = h;
                return Ok(report);
            }
        } else {
            report.rejected += 1;
            // With a step that is not a number the formula gives none either.
            let shorter = if e.is_finite() { ideal } else { 0.1 * step };
            h = max(min(shorter, 0.9 * step), o.dt_min);
        }
    }
    Err(Error::Failed { what: "adaptive_euler", time: now, advice: TOO_MANY })
}

pub(super) const TOO_MANY: &str = "too many steps; raise the tolerance or dt_min, or shorten the time";

pub(super) fn not_finite(time: f64) -> Error {
    Error::Failed {
        what: "integration",
        time,
        advice: "the state is not finite; shorten dt, or take implicit_euler for stiff springs",
    }
}
