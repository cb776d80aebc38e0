//! Starts a step for every awake body: remembers where it was, turns forces into accelerations, aims kinematic bodies.

use super::Step;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::{BodyFrame, BodyState, BodyStep, lock_bits};
use crate::world::World;
use jounce_math::{Quat, Vec3, scalar::f32s};
use jounce_tasks::Owning;

/// Bodies per unit.
const BODIES: usize = 128;

pub(crate) fn run(world: &mut World, step: &Step) {
    let (gravity, bodies) = (world.gravity, &world.bodies);
    let found = &mut world.scratch.found;
    found.begin(world.awake.step.len().div_ceil(BODIES), 0);
    let found = &*found;
    let a = &mut world.awake;
    let frames = Owning(&mut world.frames, &world.row_of);
    let travel = Owning(&mut world.travel, &world.row_of);
    let columns = (&mut a.state[..], &mut a.step[..], frames, travel);
    world.tasks.for_each_piece(columns, BODIES, |first, (states, steps, mut frames, mut travel)| {
        for (i, (s, b)) in states.iter_mut().zip(steps).enumerate() {
            let (row, slot) = (first + i, b.body as usize);
            s.rewind();
            if let Some(way) = travel.get(row, slot) {
                way.iter_mut().zip(core::mem::take(&mut b.moved)).for_each(|(sum, x)| *sum += f64::from(x));
            }
            let Some(f) = frames.get(row, slot) else { continue };
            f.reset_interpolation();
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
                        found.of(first / BODIES).push(b.body);
                    }
                    debug_assert_eq!(b.locks, lock_bits(&bodies[b.body].locks));
                }
            }
        }
    });
    let mut bad = Vec::new();
    world.scratch.found.gather(&mut bad);
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
