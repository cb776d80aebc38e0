//! Starts a step for every awake body: remembers where it was, turns forces into accelerations, aims kinematic bodies.

use super::Step;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::{BodyFrame, BodyState, BodyStep, lock_bits};
use crate::world::World;
use jounce_math::{Quat, Vec3, scalar::f32s};

pub(crate) fn run(world: &mut World, step: &Step) {
    let gravity = world.gravity;
    let mut bad = Vec::new();
    for i in 0..world.awake.step.len() {
        let (s, b) = (&mut world.awake.state[i], &mut world.awake.step[i]);
        let f = &mut world.frames[b.body as usize];
        f.reset_interpolation();
        s.rewind();
        world.travel[b.body as usize] += f64::from(core::mem::take(&mut b.moved));
        match b.kind {
            BodyKind::Kinematic => aim(s, b, f, step.dt),
            _ => {
                let falls = if b.inv_mass > 0.0 { b.gravity_scale } else { 0.0 };
                b.acceleration = gravity * falls + b.force * b.inv_mass;
                // A force that overflows would reach the neighbours within the step: contain it before it acts.
                if !(b.acceleration.is_finite()
                    && b.torque.is_finite()
                    && s.v().is_finite()
                    && s.w().is_finite())
                {
                    bad.push(b.body);
                }
                debug_assert_eq!(b.locks, lock_bits(&world.bodies[b.body].locks));
            }
        }
    }
    for body in bad {
        super::guard::quarantine(world, body);
    }
    super::fields::begin(world);
}

/// Velocity that brings a kinematic body to its target in one step.
fn aim(s: &mut BodyState, b: &mut BodyStep, f: &BodyFrame, dt: f32) {
    let Some(target) = b.target else {
        if b.guided {
            s.set_velocity(Vec3::ZERO, Vec3::ZERO);
            b.guided = false;
        }
        return;
    };
    b.guided = true;
    let center = target.transform_point(f.local_center);
    let v = (center - f.center).as_vec3() * (1.0 / dt);
    let mut d = target.q * f.rotation.conjugate();
    if d.w < 0.0 {
        d = Quat::new(-d.x, -d.y, -d.z, -d.w);
    }
    let sin = d.xyz().length();
    let angle = 2.0 * f32s::atan2(sin, d.w);
    let w = if sin > 1e-12 { d.xyz() * (angle / (sin * dt)) } else { d.xyz() * (2.0 / dt) };
    s.set_velocity(v, w);
}
