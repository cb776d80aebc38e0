//! Free motion of one substep.
//!
//! Torque-free turn. The angular momentum L is constant in the world, so in body axes ℓ = Rᵀ L turns with −ω,
//! ω = I⁻¹ ℓ. With principal moments Iᵢ and the middle one I_m the energy is
//!
//! |ℓ|²/2I_m + Σ ½ (1/Iᵢ − 1/I_m) ℓᵢ²   over the other two axes i.
//!
//! The first part turns the body about the fixed L by |ℓ| h/I_m and leaves ℓ; the others turn ℓ and the body about axis i by
//! φ = ℓᵢ h (1/Iᵢ − 1/I_m). All exactly, and the first commutes with the others: only the order of those two matters, and
//! symmetric composition (½ of i, k, ½ of i) makes it second order, symplectic, with |ℓ| kept by construction. A body with two
//! equal moments, however slender, turns exactly. (Splitting into three axes, Touma & Wisdom 1994 and Dullweber, Leimkuhler &
//! McLachlan 1997, errs by h² I_across/I_along: a rod of 1:50 lost its energy.)
//!
//! Impulses are momentum. Contacts, forces and fields change ω through the inverse inertia that is frozen within the step,
//! I₀⁻¹. A slender body turns away from it: read as a change of ω, a twist about what was its axis would be a throw across
//! it by now, with hundreds of times the energy. So what is taken over from them is ΔL = I₀ Δω, and ω follows from L.
//!
//! The usual implicit gyroscopic step loses |L|; this one does not. Rotations are rational: with t ≈ tan(φ/2) the
//! quaternion (t, 1)/√(1+t²) turns by 2 atan t; t = x(15 − x²)/(15 − 6x²), x = φ/2, is the [3/2] Padé form
//! of tan, so the phase error is of order x⁷ and no transcendental is needed.

use super::desc::BodyKind;
use super::state::{Body, BodyFrame, BodyState, BodyStep, Mass, Motion, Turning};
use crate::limits::SPIN_MAX;
use jounce_math::{DQuat, DVec3, Quat, Vec3};

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
        let damping = sub.h * b.angular_damping;
        let keep = if damping == 0.0 { 1.0 } else { 1.0 / (1.0 + f64::from(damping)) };
        torque_free(
            &mut s,
            turning,
            &bodies[b.body].mass,
            frames[b.body as usize].rotation,
            sub.h,
            keep,
            limit,
        );
    } else {
        if w2 > limit * limit {
            s.w *= limit / w2.sqrt();
        }
        let r = s.w * sub.h;
        s.dr += r;
        s.dq = turn_fast(r, w2, b.fast_rotation) * s.dq;
        s.dq = s.dq.normalize();
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

/// A half angle within a radian, where the rational tan holds, and how often to repeat it.
#[inline(always)]
fn reduced(mut x: f64) -> (f64, u32) {
    let mut turns = 1;
    while x.abs() > 1.0 && turns < 64 {
        x *= 0.5;
        turns *= 2;
    }
    (x, turns)
}

/// tan x = x y/z for |x| ≤ 1, rational; z within 0.6..1.
#[inline(always)]
fn tan(x2: f64) -> (f64, f64) {
    (1.0 - x2 * (1.0 / 15.0), 1.0 - x2 * 0.4)
}

/// Turns `l` (body axes) and `q` about principal axis `i` by the angle ℓᵢ h d. `q` is no unit quaternion afterwards: the turn by a half angle
/// of tangent y/z is (y, z), but for its length, which costs a root.
#[inline(always)]
fn turn_about(i: usize, l: &mut DVec3, q: &mut DQuat, d: f64, h: f64) {
    let (x, turns) = reduced(0.5 * l[i] * d * h);
    let (y, z) = tan(x * x);
    let y = x * y;
    let n = 1.0 / (z * z + y * y);
    let (c, s) = ((z * z - y * y) * n, 2.0 * y * z * n);
    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
    let mut d = DQuat::new(0.0, 0.0, 0.0, z);
    match i {
        0 => d.x = y,
        1 => d.y = y,
        _ => d.z = y,
    }
    for _ in 0..turns {
        // The body turns by +φ, so its view of the constant L turns by −φ.
        let (lj, lk) = (l[j], l[k]);
        l[j] = c * lj + s * lk;
        l[k] = c * lk - s * lj;
        *q = *q * d;
    }
}

/// The turn by the rotation vector `r` (radians), rational, but for its length.
#[inline(always)]
fn turn_by(r: DVec3) -> DQuat {
    let mut turns = 1;
    let (mut half, mut x2) = (r * 0.5, 0.25 * r.dot(r));
    while x2 > 1.0 && turns < 64 {
        (half, x2) = (half * 0.5, 0.25 * x2);
        turns *= 2;
    }
    let (y, z) = tan(x2);
    let step = DQuat::new(half.x * y, half.y * y, half.z * y, z);
    let mut q = step;
    for _ in 1..turns {
        q = step * q;
    }
    q
}

/// Axes of the largest and the smallest moment, and of the middle one; of two equal moments one is the middle one.
#[inline(always)]
fn outer_axes(m: DVec3) -> (usize, usize, usize) {
    let middle = if m.x == m.y {
        0
    } else if m.y == m.z {
        1
    } else if m.z == m.x {
        2
    } else if (m.x >= m.y) == (m.x <= m.z) {
        0
    } else if (m.y >= m.x) == (m.y <= m.z) {
        1
    } else {
        2
    };
    ((middle + 1) % 3, (middle + 2) % 3, middle)
}

/// World from principal axes.
pub(super) fn principal_axes(rotation: Quat, mass: &Mass) -> DQuat {
    (rotation.as_dquat() * mass.principal).normalize()
}

/// Angular momentum now: what the last turn left, and what impulses have added since through the frozen inertia; with the rotation of the
/// principal axes now, and as it is frozen.
#[inline(always)]
fn momentum(
    w: Vec3,
    dq: Quat,
    memory: Option<&Turning>,
    mass: &Mass,
    rotation: Quat,
) -> (DVec3, DQuat, DQuat) {
    // While nothing else turned the body since the last turn, its rotation and momentum are known exactly.
    if let Some(t) = memory.filter(|t| t.rotation == rotation && t.dq == dq) {
        if t.w == w {
            return (t.momentum, t.q, t.frozen);
        }
        let change = t.frozen.inverse_rotate(w.as_dvec3() - t.w.as_dvec3()).mul(mass.moments);
        return (t.momentum + t.frozen.rotate(change), t.q, t.frozen);
    }
    let frozen = principal_axes(rotation, mass);
    let q = (dq.as_dquat() * frozen).normalize();
    (q.rotate(q.inverse_rotate(w.as_dvec3()).mul(mass.moments)), q, frozen)
}

fn torque_free(
    s: &mut Motion,
    memory: &mut Option<Turning>,
    mass: &Mass,
    rotation: Quat,
    h: f32,
    keep: f64,
    limit: f32,
) {
    let (mut world, mut q, frozen) = momentum(s.w, s.dq, memory.as_ref(), mass, rotation);
    let inv = mass.inv_moments;
    world *= keep;
    let mut l = q.inverse_rotate(world);
    let (w, limit) = (l.mul(inv), f64::from(limit));
    let w2 = w.dot(w);
    let mut before = q.rotate(w);
    if w2 > limit * limit {
        let scale = limit / w2.sqrt();
        (world, l, before) = (world * scale, l * scale, before * scale);
    }
    let h64 = f64::from(h);
    let (i, k, middle) = outer_axes(mass.moments);
    let (di, dk) = (inv[i] - inv[middle], inv[k] - inv[middle]);
    // With two equal moments there is one turn about an axis of the body, and it is exact.
    if di == 0.0 {
        turn_about(k, &mut l, &mut q, dk, h64);
    } else if dk == 0.0 {
        turn_about(i, &mut l, &mut q, di, h64);
    } else {
        turn_about(i, &mut l, &mut q, di, 0.5 * h64);
        turn_about(k, &mut l, &mut q, dk, h64);
        turn_about(i, &mut l, &mut q, di, 0.5 * h64);
    }
    let q = (turn_by(world * (h64 * inv[middle])) * q).normalize();
    let w = q.rotate(q.inverse_rotate(world).mul(inv));
    s.dr += ((before + w) * (0.5 * h64)).as_vec3();
    s.dq = (q * frozen.conjugate()).as_quat();
    s.w = w.as_vec3();
    *memory = Some(Turning { momentum: world, w: s.w, q, rotation, dq: s.dq, frozen });
}

/// Takes over a change of ω that came through the inertia of the moment, not the frozen one.
pub(crate) fn absorb(s: &Motion, memory: &mut Option<Turning>, mass: &Mass, rotation: Quat) {
    if let Some(t) = memory
        && t.rotation == rotation
        && t.dq == s.dq
        && t.w != s.w
    {
        let change = t.q.inverse_rotate(s.w.as_dvec3() - t.w.as_dvec3()).mul(mass.moments);
        t.momentum += t.q.rotate(change);
        t.w = s.w;
    }
}

/// After the last substep: impulses that came since its turn become momentum, and ω follows.
pub(crate) fn settle(s: &mut Motion, memory: &mut Option<Turning>, mass: &Mass, rotation: Quat) {
    let (world, q, _) = momentum(s.w, s.dq, memory.as_ref(), mass, rotation);
    if let Some(t) = memory
        && t.rotation == rotation
        && t.dq == s.dq
        && t.w != s.w
    {
        s.w = q.rotate(q.inverse_rotate(world).mul(mass.inv_moments)).as_vec3();
        (t.momentum, t.w) = (world, s.w);
    }
}
