//! Writes the motion of a step back to the frames.

use super::desc::BodyKind;
use super::solve::SpeedLimits;
use super::state::{Body, BodyFrame, BodyState, BodyStep, InvInertia};
use jounce_math::{Quat, Vec3, scalar::f32s};

/// New pose (`precise` is the rotation of what turned freely) and inertia; spends the force accumulators; judges rest by the motion of the
/// farthest point.
pub(crate) fn finish(
    state: &mut BodyState,
    b: &mut BodyStep,
    precise: Option<Quat>,
    i: &mut InvInertia,
    f: &mut BodyFrame,
    body: &Body,
    dt: f32,
    limits: &SpeedLimits,
) {
    let mass = &body.mass;
    let mut s = state.get();
    f.center = f.center0 + s.dp.as_dvec3();
    f.rotation = precise.unwrap_or_else(|| (s.dq * f.rotation0).normalize());
    if let (BodyKind::Kinematic, Some(target)) = (b.kind, b.target.take()) {
        f.rotation = target.q;
        f.center = target.transform_point(f.local_center);
    }
    *i = InvInertia::new(f.rotation, &mass.inv_inertia, b.inv_mass, b.locks);
    (b.force, b.torque) = (Vec3::ZERO, Vec3::ZERO);
    // Restitution and the relaxing pass come after the limits of the last substep.
    let v2 = s.v.length_squared();
    if v2 > limits.speed * limits.speed {
        s.v *= limits.speed / v2.sqrt();
        state.put(&s);
    }
    let w2 = s.w.length_squared();
    let spin = limits.spin_of(b, body);
    if w2 > spin * spin {
        s.w *= spin / w2.sqrt();
        state.put(&s);
    }
    let mut speed = f32s::max(s.v.length(), s.w.length() * mass.outer_radius);
    if body.joints.is_empty() {
        (b.drift, b.swing) = ([Vec3::ZERO; 2], [Vec3::ZERO; 2]);
    } else {
        // Joints and contacts that disagree leave velocities that lead nowhere, and what closes a gap is a way without velocity. In a
        // heap they are never at one: what trembles on the spot rests.
        let part = f32s::min(dt / DRIFT_TIME, 1.0);
        b.drift[0] += (s.dp * (1.0 / dt) - b.drift[0]) * part;
        b.drift[1] += (s.dr * (1.0 / dt) - b.drift[1]) * part;
        let far = |d: [Vec3; 2]| f32s::max(d[0].length(), d[1].length() * mass.outer_radius);
        // A pendulum at its turning point is slow for as long as the timer takes; but it is about to go another way than it came.
        let part = f32s::min(dt / SWING_TIME, 1.0);
        // What was fast counts as just too fast, or it would be remembered for seconds after a sudden stop.
        let most = SWINGS * b.sleep_speed;
        let clipped = |d: Vec3, most: f32| d * f32s::min(most / f32s::max(d.length(), 1e-20), 1.0);
        b.swing[0] += (clipped(b.drift[0], most) - b.swing[0]) * part;
        b.swing[1] += (clipped(b.drift[1], most / f32s::max(mass.outer_radius, 1e-20)) - b.swing[1]) * part;
        let turns = TURNS * far([b.drift[0] - b.swing[0], b.drift[1] - b.swing[1]]);
        speed = f32s::max(LEADS_NOWHERE * speed, f32s::max(far(b.drift), turns));
    }
    b.sleep_timer = if body.can_sleep && speed < b.sleep_speed { b.sleep_timer + dt } else { 0.0 };
}

/// Time over which the ways of a body on joints are averaged, s.
pub(super) const DRIFT_TIME: f32 = 0.1;
/// Time over which they are averaged to tell what swings from what rests, s.
const SWING_TIME: f32 = 0.5;
/// How much what a body on joints is faster or slower than then counts as motion.
const TURNS: f32 = 2.0;
/// The fastest that is remembered, as a multiple of the speed below which bodies sleep.
const SWINGS: f32 = 3.0;
/// Part of the velocity of a body on joints that counts as motion, whatever way it made.
const LEADS_NOWHERE: f32 = 0.1;
