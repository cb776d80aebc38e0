//! Random emitters, and random edits of them.

use super::rng::Rng;
use super::storm::Storm;
use jounce::prelude::*;
use jounce::{
    Burst, Command, Curve, EmitDirection, Gradient, Heat, HitResponse, ParticleSpawn, ParticleView,
    Turbulence,
};
use std::sync::Arc;

/// Adds, changes or removes emitters and particles; sometimes with what must be refused.
pub fn edit(storm: &mut Storm) {
    let Some(mut rng) = storm.emitters.take() else { return };
    if let Some(command) = command(storm, &mut rng) {
        (storm.around)(&mut || {
            let accepted = storm.world.apply(command.clone()).is_ok();
            storm.edits[usize::from(!accepted)] += 1;
        });
    }
    if rng.one_in(40) {
        let hook = |p: &ParticleView| p.serial % 5 == 3 && p.age > 0.2;
        storm.world.set_particle_hook("some", Some(Arc::new(hook)));
    }
    storm.emitters = Some(rng);
}

fn command(storm: &mut Storm, rng: &mut Rng) -> Option<Command> {
    let all: Vec<EmitterId> = storm.world.emitters().collect();
    let any = |rng: &mut Rng| (!all.is_empty()).then(|| *rng.pick(&all));
    Some(match rng.below(12) {
        0..=2 if all.len() < 6 => Command::AddEmitter(Box::new(emitter(storm, rng))),
        3 => Command::SetEmitter(any(rng)?, Box::new(emitter(storm, rng))),
        4 => Command::SetEmitterEnabled(any(rng)?, rng.one_in(2)),
        5 => Command::EmitBurst(any(rng)?, rng.below(300) as u32),
        6 => {
            let spawns = (0..rng.below(20)).map(|_| spawn(storm, rng)).collect();
            Command::EmitParticles(any(rng)?, spawns)
        }
        7 => Command::ClearParticles(any(rng)),
        8 => Command::RemoveEmitter(any(rng)?),
        9 => Command::Explode(Explosion::new(somewhere(storm, rng), 3.0 * storm.size, rng.decades(0.0, 3.0))),
        _ => return None,
    })
}

fn somewhere(storm: &Storm, rng: &mut Rng) -> DVec3 {
    let mut p = rng.vec3(storm.extent);
    p.y = p.y.abs();
    storm.origin + p.as_dvec3()
}

fn spawn(storm: &Storm, rng: &mut Rng) -> ParticleSpawn {
    ParticleSpawn {
        position: somewhere(storm, rng),
        velocity: {
            let speed = *rng.pick(&[1.0, 10.0, 1e3, 2e5]);
            rng.vec3(speed)
        },
        lifetime_s: rng.decades(-2.0, 1.0),
        mass: rng.decades(-9.0, 2.0),
        radius: rng.decades(-4.0, 0.0) * storm.size,
    }
}

fn emitter(storm: &Storm, rng: &mut Rng) -> EmitterDesc {
    let size = storm.size;
    let shape = match rng.below(5) {
        0 => EmitterShape::Point,
        1 => EmitterShape::Sphere { radius: size, surface: rng.one_in(2) },
        2 => EmitterShape::Disc { radius: size },
        3 => EmitterShape::Cone { half_angle: rng.float(0.0, 1.5), radius: *rng.pick(&[0.0, 0.2]) * size },
        _ => EmitterShape::Box { half: rng.vec3(size).abs() },
    };
    let mut d =
        EmitterDesc::new().shape(shape).at(somewhere(storm, rng)).rotated(rng.quat()).seed(rng.bits());
    let bodies: Vec<BodyId> = storm.world.bodies().collect();
    if rng.one_in(3) && !bodies.is_empty() {
        d.body = Some(*rng.pick(&bodies));
        d.pose.p = rng.vec3(size).as_dvec3();
    }
    d.rate = f64::from(rng.decades(0.0, 4.0));
    d.max_particles = *rng.pick(&[1, 100, 1000]);
    d.bursts =
        (0..rng.below(3)).map(|i| Burst { time_s: 0.1 * i as f64, count: rng.below(200) as u32 }).collect();
    (d.duration_s, d.looping) = (rng.one_in(2).then_some(0.5), rng.one_in(3));
    (d.auto_remove, d.spread, d.inherit_velocity) =
        (rng.one_in(3), rng.float(0.0, 3.0), rng.float(-0.5, 1.5));
    if rng.one_in(3) {
        d.direction = EmitDirection::Outward;
    }
    let speed = rng.decades(-1.0, 1.5) * size;
    d.speed = [0.5 * speed, speed];
    d.lifetime_s = [0.1, rng.decades(-1.0, 0.7)];
    let radius = rng.decades(-3.0, -0.5) * size;
    (d.radius, d.mass) = ([0.5 * radius, radius], rng.decades(-7.0, 1.0));
    d.gravity_scale = *rng.pick(&[1.0, 1.0, 0.0, -1.0]);
    d.linear_drag = *rng.pick(&[0.0, 0.5, 10.0, 1e6]);
    if rng.one_in(2) {
        let (speed, time_s) = (rng.float(0.0, 5.0), rng.decades(-2.0, 1.0));
        d.turbulence = Some(Turbulence { speed, size: rng.decades(-2.0, 1.0), time_s, seed: rng.bits() });
    }
    if rng.one_in(4) {
        let (excess, cooling_s) = (rng.float(-100.0, 1000.0), rng.decades(-2.0, 1.0));
        d.heat = Some(Heat { excess, ambient: 293.0, cooling_s });
    }
    if !rng.one_in(4) {
        d.collision = Some(collision(rng));
    }
    if rng.one_in(6) {
        d.kill_below = Some(storm.origin.y - 0.1);
    }
    d.kill_hook = rng.one_in(5).then(|| "some".to_owned());
    d.size_over_life = Curve::new([(0.0, 1.0), (1.0, 0.0)]);
    d.color_over_life = Gradient::new([(0.5, [1.0, 0.5, 0.0, 1.0])]);
    // What a user might get wrong.
    if rng.one_in(10) {
        match rng.below(4) {
            0 => d.mass = -1.0,
            1 => d.rate = 1e12,
            2 => d.radius = [0.0, f32::NAN],
            _ => d.lifetime_s = [2.0, 1.0],
        }
    }
    d
}

fn collision(rng: &mut Rng) -> ParticleCollision {
    ParticleCollision {
        restitution: *rng.pick(&[0.0, 0.3, 1.0]),
        friction: *rng.pick(&[0.0, 0.3, 1.0]),
        response: *rng.pick(&[
            HitResponse::Bounce,
            HitResponse::Bounce,
            HitResponse::Stick,
            HitResponse::Kill,
        ]),
        filter: Filter::default(),
        push: rng.one_in(2),
        hit_events: rng.one_in(3),
        radius_scale: *rng.pick(&[1.0, 0.3]),
    }
}
