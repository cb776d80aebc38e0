//! Writes the motion of a step back to the frames.

use super::desc::BodyKind;
use super::state::{BodyFrame, BodyState, BodyStep, InvInertia, Mass};
use jounce_math::{Vec3, scalar::f32s};

/// New pose and inertia; spends the force accumulators; judges rest by the motion of the farthest point.
pub(crate) fn finish(
    s: &BodyState,
    b: &mut BodyStep,
    i: &mut InvInertia,
    f: &mut BodyFrame,
    mass: &Mass,
    can_sleep: bool,
    dt: f32,
) {
    let s = s.get();
    f.center = f.center0 + s.dp.as_dvec3();
    f.rotation = (s.dq * f.rotation0).normalize();
    if let (BodyKind::Kinematic, Some(target)) = (b.kind, b.target.take()) {
        f.rotation = target.q;
        f.center = target.transform_point(f.local_center);
    }
    *i = InvInertia::new(f.rotation, &mass.inv_inertia, b.inv_mass, b.locks);
    (b.force, b.torque) = (Vec3::ZERO, Vec3::ZERO);
    let speed = f32s::max(s.v.length(), s.w.length() * mass.outer_radius);
    b.sleep_timer = if can_sleep && speed < b.sleep_speed { b.sleep_timer + dt } else { 0.0 };
}
