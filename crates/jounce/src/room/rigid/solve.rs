//! Free motion of one substep.
//!
//! Semi-implicit Euler: c ← c + v h, q ← turn(ω h) q with the velocities that forces and constraints left. What has unequal moments and
//! nothing locked turns torque-free ([`super::free`]).

use super::desc::BodyKind;
use super::free::{self, Free, SPIN_MIN_SQUARED, Top, Turns};
use super::state::{Body, BodyFrame, BodyState, BodyStep, Motion, Turning};
use crate::limits::SPIN_MAX;
use jounce_math::{Quat, Vec3};

/// Constants of one substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Substep {
    pub h: f32,
    pub limits: SpeedLimits,
}

/// Fastest motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpeedLimits {
    /// m/s.
    pub speed: f32,
    /// rad/s.
    pub spin: f32,
    /// The same of bodies on joints: so far in a substep, not in a step. Stopping one alone would turn it against the others, and a head
    /// of 10 cm that lands at 10 m/s does turn at 100 rad/s.
    pub spin_jointed: f32,
}

impl SpeedLimits {
    /// The fastest spin of a body, rad/s.
    #[inline(always)]
    pub fn spin_of(&self, b: &BodyStep, body: &Body) -> f32 {
        if b.fast_rotation {
            SPIN_MAX
        } else if body.joints.is_empty() {
            self.spin
        } else {
            self.spin_jointed
        }
    }
}

/// Quaternion of the turn by the rotation vector `r` (radians), rational.
#[inline(always)]
pub(crate) fn turn(r: Vec3) -> Quat {
    let x2 = 0.25 * r.length_squared();
    // tan(x)/x; past a quarter turn of x the series would fold back, and no step turns that far.
    let f = 0.5 * (15.0 - x2) / (15.0 - 6.0 * x2);
    Quat::new(r.x * f, r.y * f, r.z * f, 1.0).normalize()
}

/// Unequal moments, nothing locked: the angular velocity changes by itself.
#[inline(always)]
pub(crate) fn turns_freely(b: &BodyStep) -> bool {
    !b.isotropic && b.kind == BodyKind::Dynamic && b.locks & 56 == 0
}

/// Velocities to positions, with locks and speed limits; bodies with unequal moments turn torque-free.
#[inline(always)]
pub(crate) fn integrate_position(
    state: &mut BodyState,
    b: &BodyStep,
    turning: &mut Option<Turning>,
    bodies: &crate::table::Table<Body>,
    frames: &[BodyFrame],
    sub: &Substep,
) {
    let mut s = state.get();
    if b.locks != 0 {
        apply_locks(&mut s, b.locks);
    }
    let v2 = s.v.length_squared();
    if v2 > sub.limits.speed * sub.limits.speed {
        s.v *= sub.limits.speed / v2.sqrt();
    }
    s.dp += s.v * sub.h;
    let w2 = s.w.length_squared();
    let limit = sub.limits.spin_of(b, &bodies[b.body]);
    if turns_freely(b) && w2 >= SPIN_MIN_SQUARED {
        state.put(&s);
        let mass = &bodies[b.body].mass;
        free::remember(state, turning, || (mass, frames[b.body as usize].rotation));
        Turns {
            free: Free {
                states: core::slice::from_mut(state),
                turning: core::slice::from_mut(turning),
                rows: &[0],
            },
            tops: &[Top::new(b, mass, sub.h)],
            spin_most: &[limit],
            h: sub.h,
        }
        .alone();
    } else {
        if w2 > limit * limit {
            s.w *= limit / w2.sqrt();
        }
        let r = s.w * sub.h;
        s.dr += r;
        s.dq = turn_fast(r, w2, b.fast_rotation) * s.dq;
        s.dq = s.dq.normalize();
        state.put(&s);
    }
}

/// A turn that stays right however fast the body spins (only exempt bodies turn more than a radian a substep).
#[inline(always)]
fn turn_fast(r: Vec3, w2: f32, fast: bool) -> Quat {
    if fast && r.length_squared() > 1.0 && w2 > 0.0 {
        let angle = r.length();
        return Quat::from_axis_angle(r / angle, angle);
    }
    turn(r)
}

fn apply_locks(s: &mut Motion, locks: u8) {
    for i in 0..3 {
        if locks & (1 << i) != 0 {
            s.v[i] = 0.0;
        }
        if locks & (8 << i) != 0 {
            s.w[i] = 0.0;
        }
    }
}
