//! Free motion of one substep.
//!
//! Torque-free turn. The angular momentum L is constant in the world, so in body axes ℓ = Rᵀ L turns with −ω,
//! ω = I⁻¹ ℓ. With principal moments I₁, I₂, I₃ the energy splits into three parts ℓᵢ²/2Iᵢ, each of which turns
//! ℓ and the body about axis i by the angle φ = ℓᵢ h / Iᵢ, exactly. Symmetric composition (½ of 1, ½ of 2, 3, ½ of 2,
//! ½ of 1) is second order, symplectic, and keeps |ℓ| by construction
//! (Touma & Wisdom 1994; Dullweber, Leimkuhler & McLachlan 1997).
//!
//! The usual implicit gyroscopic step loses |L|; this one does not. Rotations are rational: with t ≈ tan(φ/2) the
//! quaternion (t, 1)/√(1+t²) turns by 2 atan t; t = x(15 − x²)/(15 − 6x²), x = φ/2, is the [3/2] Padé form
//! of tan, so the phase error is of order x⁷ and no transcendental is needed.

use super::desc::BodyKind;
use super::state::{Body, BodyFrame, BodyState, BodyStep, InvInertia, Mass, Motion, Turning};
use jounce_math::{DQuat, DVec3, Quat, Vec3};

/// Constants of one substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Substep {
    pub h: f32,
    pub linear_speed_max: f32,
    pub angular_speed_max: f32,
}

/// Below this spin (rad/s, squared) the gyroscopic turn is below f32 resolution over a substep.
const SPIN_MIN_SQUARED: f32 = 1e-10;

/// Quaternion of the turn by the rotation vector `r` (radians), rational.
#[inline(always)]
pub(crate) fn turn(r: Vec3) -> Quat {
    let x2 = 0.25 * r.length_squared();
    // tan(x)/x; past a quarter turn of x the series would fold back, and no step turns that far.
    let f = 0.5 * (15.0 - x2) / (15.0 - 6.0 * x2);
    Quat::new(r.x * f, r.y * f, r.z * f, 1.0).normalize()
}

/// Forces, gravity and damping to velocities. Gravity and forces per unit mass are in `step.acceleration`.
#[inline(always)]
pub(crate) fn integrate_velocity(s: &mut BodyState, b: &BodyStep, i: &InvInertia, h: f32) {
    if b.kind != BodyKind::Dynamic {
        return;
    }
    let v = (s.v() + b.acceleration * h) * (1.0 / (1.0 + h * b.linear_damping));
    let w = (s.w() + i.mul(b.torque) * h) * (1.0 / (1.0 + h * b.angular_damping));
    s.set_velocity(v, w);
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
    if v2 > sub.linear_speed_max * sub.linear_speed_max {
        s.v *= sub.linear_speed_max / v2.sqrt();
    }
    let w2 = s.w.length_squared();
    if w2 > sub.angular_speed_max * sub.angular_speed_max && !b.fast_rotation {
        s.w *= sub.angular_speed_max / w2.sqrt();
    }
    s.dp += s.v * sub.h;
    if b.isotropic || b.kind != BodyKind::Dynamic || b.locks & 56 != 0 || w2 < SPIN_MIN_SQUARED {
        let r = s.w * sub.h;
        s.dr += r;
        s.dq = turn_fast(r, w2, b.fast_rotation) * s.dq;
        s.dq = s.dq.normalize();
    } else {
        torque_free(&mut s, turning, &bodies[b.body].mass, frames[b.body as usize].rotation, sub.h);
    }
    state.put(&s);
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

/// Turns `l` (body axes) and `q` about principal axis `i` by the angle ℓᵢ h / Iᵢ.
#[inline(always)]
fn turn_about(i: usize, l: &mut DVec3, q: &mut DQuat, inv_moment: f64, h: f64) {
    let mut x = 0.5 * l[i] * inv_moment * h;
    // Past a radian the rational form is not tan any more; only exempt bodies come here.
    let mut turns = 1;
    while x.abs() > 1.0 && turns < 64 {
        x *= 0.5;
        turns *= 2;
    }
    let x2 = x * x;
    let t = x * (15.0 - x2) / (15.0 - 6.0 * x2);
    let n = 1.0 / (1.0 + t * t);
    let (c, s) = ((1.0 - t * t) * n, 2.0 * t * n);
    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
    let m = n.sqrt();
    let mut d = DQuat::new(0.0, 0.0, 0.0, m);
    match i {
        0 => d.x = t * m,
        1 => d.y = t * m,
        _ => d.z = t * m,
    }
    for _ in 0..turns {
        // The body turns by +φ, so its view of the constant L turns by −φ.
        let (lj, lk) = (l[j], l[k]);
        l[j] = c * lj + s * lk;
        l[k] = c * lk - s * lj;
        *q = *q * d;
    }
}

fn torque_free(s: &mut Motion, memory: &mut Option<Turning>, mass: &Mass, rotation: Quat, h: f32) {
    let moments = mass.moments;
    let frame = mass.principal.as_dquat().normalize();
    // While nothing changed the rotation or ω since the last turn, they are known exactly.
    let known = memory.filter(|t| t.rotation == rotation && t.dq == s.dq);
    let mut q = match known {
        Some(t) => t.q,
        None => (s.dq.as_dquat() * rotation.as_dquat() * frame).normalize(),
    };
    let world = match known {
        Some(t) if t.w == s.w => t.momentum,
        _ => {
            let w = q.inverse_rotate(s.w.as_dvec3());
            q.rotate(w.mul(moments))
        }
    };
    let mut l = q.inverse_rotate(world);
    let h64 = f64::from(h);
    let inv = DVec3::new(1.0 / moments.x, 1.0 / moments.y, 1.0 / moments.z);
    turn_about(0, &mut l, &mut q, inv.x, 0.5 * h64);
    turn_about(1, &mut l, &mut q, inv.y, 0.5 * h64);
    turn_about(2, &mut l, &mut q, inv.z, h64);
    turn_about(1, &mut l, &mut q, inv.y, 0.5 * h64);
    turn_about(0, &mut l, &mut q, inv.x, 0.5 * h64);
    let q = q.normalize();
    let w = q.rotate(q.inverse_rotate(world).mul(inv)).as_vec3();
    s.dr += (s.w + w) * (0.5 * h);
    s.dq = (q * (rotation.as_dquat() * frame).conjugate()).normalize().as_quat();
    s.w = w;
    *memory = Some(Turning { momentum: world, w, q, rotation, dq: s.dq });
}
