//! Once per step and emitter: which births fall into it, and all numbers that its particles have in common.

use super::birth::Stand;
use super::desc::{HitResponse, ParticleCollision};
use super::noise::Noise;
use super::state::Emitter;
use crate::hooks::ParticleHook;
use crate::limits;
use crate::room::fields::point::Sample;
use jounce_math::{DVec3, Vec3, scalar::f32s, scalar::f64s};

/// Births with equal spacing in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Run {
    /// How many births of the step come before these.
    pub first: u64,
    pub count: u64,
    /// Time of the first, s into the step, and from one to the next.
    pub offset: f64,
    pub spacing: f64,
}

/// Slack for times that are multiples of a step but for rounding, s and births.
const EARLY: f64 = 1e-9;

/// Births by rate up to the end of `steps` steps.
fn by_rate(e: &Emitter, steps: u64, rate_hz: f64) -> u64 {
    let d = &e.desc;
    let mut time = f64s::max(steps as f64 / rate_hz - d.delay_s, 0.0);
    if let (Some(end), false) = (d.duration_s, d.looping) {
        time = f64s::min(time, end);
    }
    (d.rate * time + EARLY) as u64
}

/// Rounds of a burst before `time`, s.
fn rounds(e: &Emitter, burst: f64, time: f64) -> u64 {
    let since = time - e.desc.delay_s - burst - EARLY;
    match e.desc.duration_s {
        Some(round) if burst > round => 0,
        // A burst at the very end of a round is the first of the next.
        Some(round) if e.desc.looping => f64s::max((since / round).ceil(), 0.0) as u64,
        _ => u64::from(since > 0.0),
    }
}

/// The births of an emitter's next step, in order of time; gives their number.
pub(crate) fn schedule(e: &Emitter, rate_hz: f64, bursts: &mut Vec<(f64, u32)>, runs: &mut Vec<Run>) -> u64 {
    let d = &e.desc;
    let dt = 1.0 / rate_hz;
    let (t0, t1) = (e.clock as f64 / rate_hz, (e.clock + 1) as f64 / rate_hz);
    bursts.clear();
    for b in &d.bursts {
        for k in rounds(e, b.time_s, t0)..rounds(e, b.time_s, t1) {
            let round = if d.looping { d.duration_s.unwrap_or(0.0) } else { 0.0 };
            let at = d.delay_s + b.time_s + k as f64 * round - t0;
            bursts.push((f64s::clamp(at, 0.0, dt), b.count));
        }
    }
    bursts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut k, end) = (by_rate(e, e.clock, rate_hz) + 1, by_rate(e, e.clock + 1, rate_hz) + 1);
    let offset = |k: u64| f64s::clamp(d.delay_s + k as f64 / d.rate - t0, 0.0, dt);
    let mut total = 0;
    let mut add = |count: u64, offset: f64, spacing: f64| {
        if count > 0 {
            runs.push(Run { first: total, count, offset, spacing });
            total += count;
        }
    };
    for &(at, count) in bursts.iter() {
        let from = k;
        while k < end && offset(k) <= at {
            k += 1;
        }
        if k > from {
            add(k - from, offset(from), 1.0 / d.rate);
        }
        add(u64::from(count), at, 0.0);
    }
    if k < end {
        add(end - k, offset(k), 1.0 / d.rate);
    }
    total
}

/// Time of a birth of the step, s into it.
pub(crate) fn offset_of(runs: &[Run], birth: u64, dt: f64) -> f64 {
    let run = runs.iter().find(|r| birth < r.first + r.count);
    run.map_or(0.0, |r| f64s::min(r.offset + (birth - r.first) as f64 * r.spacing, dt))
}

/// Is the last birth by time over at the end of the next step?
pub(crate) fn ends(e: &Emitter, rate_hz: f64) -> bool {
    let d = &e.desc;
    let t1 = (e.clock + 1) as f64 / rate_hz;
    match d.duration_s {
        _ if d.looping => false,
        Some(duration) => t1 + EARLY >= d.delay_s + duration,
        None => d.rate == 0.0 && !d.bursts.is_empty() && d.bursts.iter().all(|b| rounds(e, b.time_s, t1) > 0),
    }
}

/// How the particles of an emitter meet shapes, for a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules {
    pub desc: ParticleCollision,
    /// Part of the tangential velocity that a particle keeps which stays on a surface for the step.
    pub kept: f32,
    pub dt: f32,
}

/// What the particles of an emitter have in common during a step.
#[derive(Clone)]
pub(crate) struct EmitterStep {
    pub origin: DVec3,
    pub dt: f32,
    /// Of the world, times the emitter's factor, m/s².
    pub gravity: Vec3,
    /// The world's, for buoyancy.
    pub weight: Vec3,
    /// What the fields say, where that does not depend on the place.
    pub medium: Option<Sample>,
    pub linear_drag: f32,
    /// 6π, and π/2 C_d.
    pub stokes: f32,
    pub quadratic: f32,
    pub noise: Option<Noise>,
    /// Cooling, as halvings per second, and rise at birth, m/s².
    pub heat: Option<(f32, Vec3)>,
    /// What is outside of these dies, m from the origin.
    pub lo: Vec3,
    pub hi: Vec3,
    pub layers: u32,
    pub rules: Option<Rules>,
    pub sticks: bool,
    pub hook: Option<ParticleHook>,
    pub stand: Stand,
    /// Births: where in the list of runs, and the serial of the first.
    pub runs: (usize, usize),
    pub first: u64,
}

impl EmitterStep {
    pub fn new(e: &Emitter, stand: Stand, gravity: Vec3, dt: f32, time: f64) -> Self {
        let d = &e.desc;
        let drags = d.linear_drag > 0.0 || d.drag_coefficient > 0.0;
        let heat = d.heat.map(|h| {
            let rise = gravity * (-h.excess / h.ambient);
            (core::f32::consts::LOG2_E / h.cooling_s, rise)
        });
        let (lo, hi) = bounds(e);
        let kept = |friction: f32| f32s::pow(1.0 - friction, 60.0 * dt);
        Self {
            origin: e.origin,
            dt,
            gravity: gravity * d.gravity_scale,
            weight: gravity,
            medium: None,
            linear_drag: d.linear_drag,
            stokes: 6.0 * core::f32::consts::PI,
            quadratic: 0.5 * core::f32::consts::PI * d.drag_coefficient,
            noise: d.turbulence.filter(|_| drags).map(|t| Noise::new(&t, e.origin, time)),
            heat,
            lo,
            hi,
            layers: d.layers,
            rules: d.collision.map(|desc| Rules { desc, kept: kept(desc.friction), dt }),
            sticks: d.collision.is_some_and(|c| c.response == HitResponse::Stick),
            hook: None,
            stand,
            runs: (0, 0),
            first: e.serial,
        }
    }
}

/// Where the particles of an emitter live, counted from its origin.
fn bounds(e: &Emitter) -> (Vec3, Vec3) {
    let world = DVec3::splat(limits::POSITION_MAX);
    let [mut lo, hi] = e.desc.kill_outside.unwrap_or([-world, world]);
    if let Some(y) = e.desc.kill_below {
        lo.y = f64s::max(lo.y, y);
    }
    ((lo - e.origin).as_vec3(), (hi - e.origin).as_vec3())
}
