//! A blast on particles: Δv = p f(r) πr²/m along the line from the centre, f = (1 − d/R)² ([`Explosion`]), for those that no
//! fixed body shields.

use super::state::{LANES, Particles};
use crate::limits;
use crate::query::{QueryFilter, Ray};
use crate::room::fields::desc::Explosion;
use crate::world::World;
use jounce_math::{Vec3, scalar::f32s};

/// Blocks per unit.
const BLOCKS: usize = 4;

/// Changes the velocities of the particles in reach, at once.
pub(crate) fn push_by_explosion(world: &mut World, x: &Explosion) {
    if world.particles.count == 0 {
        return;
    }
    let mut particles = core::mem::take(&mut world.particles);
    let Particles { emitters, pool, .. } = &mut particles;
    let shared: &World = world;
    let walls = QueryFilter { kinematic: false, dynamic: false, ..QueryFilter::default() };
    shared.tasks.for_each(pool, BLOCKS, |_, b| {
        let Some(e) = emitters.get(b.emitter).filter(|e| e.desc.layers & x.layers != 0) else { return };
        let center = (x.center - e.origin).as_vec3();
        for l in 0..b.count.min(LANES) {
            let away = b.place(l) - center;
            let (way, distance) = away.try_normalize().unwrap_or((Vec3::Y, 0.0));
            if distance >= x.radius {
                continue;
            }
            let at = e.origin + b.place(l).as_dvec3();
            if x.occlusion && distance > 0.0 && shared.ray_blocked(&Ray::between(x.center, at), &walls) {
                continue;
            }
            let f = 1.0 - distance / x.radius;
            let area = core::f32::consts::PI * b.radius[l] * b.radius[l];
            let speed = x.impulse * f * f * area / b.mass[l];
            let most = 0.5 * limits::SPEED_MAX;
            let v = b.velocity(l) + way * f32s::clamp(speed, -most, most);
            let fast = f32s::max(v.length() / limits::SPEED_MAX, 1.0);
            b.put(l, b.place(l), v * (1.0 / fast));
        }
    });
    world.particles = particles;
}
