//! Random fields of every law, shapes that meet the medium in every way, blasts; and random edits of them.

use super::rng::Rng;
use super::storm::Storm;
use jounce::prelude::*;
use jounce::{Command, FieldView, Gust};
use std::sync::Arc;

/// Names of the hooks that user fields ask for; the last one is never registered.
const HOOKS: [&str; 3] = ["swirl", "spring", "nobody"];

/// Registers the hooks that user fields name.
pub fn hooks(world: &mut World) {
    let swirl = |v: &FieldView| Vec3::Y.cross(v.velocity) * 0.5 + Vec3::X * ((v.user_data & 3) as f32 - 1.5);
    let spring = |v: &FieldView| {
        let pull = if v.body.is_some() { -0.5 } else { -2.0 };
        v.velocity * pull + Vec3::Y * (if v.time_s > 1.0 { 4.0 } else { -4.0 })
    };
    world.set_field_hook(HOOKS[0], Some(Arc::new(swirl)));
    world.set_field_hook(HOOKS[1], Some(Arc::new(spring)));
}

/// Adds, changes or removes fields, changes how a shape meets the medium, lets off a blast; sometimes with what must be
/// refused.
pub fn edit(storm: &mut Storm) {
    let Some(mut rng) = storm.fields.take() else { return };
    if let Some(command) = command(storm, &mut rng) {
        let queued = rng.one_in(4);
        (storm.around)(&mut || {
            let command = command.clone();
            let accepted =
                if queued { storm.world.queue(command).is_ok() } else { storm.world.apply(command).is_ok() };
            storm.edits[usize::from(!accepted)] += 1;
        });
    }
    // A hook that goes away leaves its fields without a law; one that comes back gives it back.
    if rng.one_in(60) {
        storm.world.set_field_hook(HOOKS[1], None);
    } else if rng.one_in(30) {
        hooks(&mut storm.world);
    }
    storm.fields = Some(rng);
}

fn command(storm: &mut Storm, rng: &mut Rng) -> Option<Command> {
    let all: Vec<FieldId> = storm.world.fields().collect();
    let any = |rng: &mut Rng| (!all.is_empty()).then(|| *rng.pick(&all));
    Some(match rng.below(12) {
        0..=3 if all.len() < 6 => Command::AddField(Box::new(field(storm, rng))),
        4 | 5 => Command::SetField(any(rng)?, Box::new(field(storm, rng))),
        6 => {
            // The same field, switched.
            let id = any(rng)?;
            let mut desc = storm.world.field(id).ok()?.clone();
            desc.enabled = !desc.enabled;
            Command::SetField(id, Box::new(desc))
        }
        7 | 8 => Command::RemoveField(any(rng)?),
        9 => {
            let shapes: Vec<ShapeId> = storm.world.shapes().collect();
            Command::SetAero(*(!shapes.is_empty()).then(|| rng.pick(&shapes))?, aero(rng, storm.size))
        }
        10 => Command::Explode(blast(storm, rng)),
        _ => return None,
    })
}

fn somewhere(storm: &Storm, rng: &mut Rng) -> DVec3 {
    storm.origin + rng.vec3(storm.extent).as_dvec3()
}

fn unit(rng: &mut Rng) -> Vec3 {
    rng.quat().rotate(Vec3::Y)
}

fn aero(rng: &mut Rng, size: f32) -> Aero {
    Aero {
        drag: rng.one_in(2).then(|| rng.decades(-2.0, 1.0)),
        area: rng.one_in(3).then(|| rng.decades(-2.0, 1.0) * size * size),
        lift: *rng.pick(&[0.0, 1.0, -3.0]),
        stokes_radius: rng.one_in(3).then(|| rng.decades(-2.0, 0.0) * size),
    }
}

fn blast(storm: &Storm, rng: &mut Rng) -> Explosion {
    let sign = if rng.one_in(6) { -1.0 } else { 1.0 };
    let mut e = Explosion::new(
        somewhere(storm, rng),
        rng.decades(-1.0, 1.0) * storm.extent,
        sign * rng.decades(-1.0, 4.0),
    );
    e.occlusion = rng.one_in(2);
    if rng.one_in(4) {
        e.layers = rng.bits() as u32;
    }
    e
}

/// Accelerations of a few g, flows of a few lengths a second; one field in ten at the ends of what is accepted, one in
/// twelve with what is not.
fn field(storm: &Storm, rng: &mut Rng) -> FieldDesc {
    let mut law = law(storm, rng);
    if rng.one_in(10) {
        extreme(&mut law);
    }
    let mut d = FieldDesc::new(law);
    let (center, rim) = (somewhere(storm, rng), f64::from(rng.float(0.0, storm.size)));
    d.region = match rng.below(4) {
        0 => Region::Sphere { center, radius: rng.double(0.1, 2.0) * f64::from(storm.extent), falloff: rim },
        1 => Region::Box {
            center,
            half: rng.vec3(storm.extent).abs().as_dvec3() + DVec3::splat(0.01),
            falloff: if rng.one_in(2) { 0.0 } else { rim },
        },
        _ => Region::Everywhere,
    };
    d.layers = if rng.one_in(4) { rng.bits() as u32 } else { u32::MAX };
    d.enabled = !rng.one_in(8);
    // What a user might get wrong.
    if rng.one_in(12) {
        match rng.below(4) {
            0 => d.region = Region::Sphere { center, radius: 0.0, falloff: 0.0 },
            1 => d.region = Region::Box { center, half: DVec3::splat(f64::NAN), falloff: 0.0 },
            2 => d.law = FieldLaw::Wind { velocity: Vec3::splat(f32::INFINITY), gust: None },
            _ => d.law = FieldLaw::User { hook: String::new() },
        }
    }
    d
}

fn law(storm: &Storm, rng: &mut Rng) -> FieldLaw {
    let size = storm.size;
    match rng.below(9) {
        0 => FieldLaw::Uniform { acceleration: rng.vec3(20.0) },
        1 => {
            // A few g at the place's rim.
            let e = f64::from(storm.extent);
            let softening = if rng.one_in(3) { 0.0 } else { f64::from(size) * rng.double(0.01, 1.0) };
            FieldLaw::Point { center: somewhere(storm, rng), mu: rng.double(-20.0, 30.0) * e * e, softening }
        }
        2 => {
            let bodies: Vec<BodyId> = storm.world.bodies().collect();
            let mut some: Vec<BodyId> = bodies.into_iter().filter(|_| !rng.one_in(3)).collect();
            if rng.one_in(10)
                && let Some(&b) = some.first()
            {
                some.push(b);
            }
            // G of a place where a body of this size and the density of water pulls with about g.
            let g = f64::from(rng.decades(-4.0, -1.0)) / f64::from(size);
            let softening = *rng.pick(&[0.0, 0.1, 1.0]) * f64::from(size);
            FieldLaw::NBody { bodies: some, g, softening }
        }
        3 => {
            let gust = rng.one_in(2).then(|| Gust {
                speed: rng.float(0.0, 10.0),
                size: rng.decades(-1.0, 2.0) * size,
                time_s: rng.decades(-2.0, 1.0),
                seed: rng.bits(),
            });
            FieldLaw::Wind { velocity: rng.vec3(15.0), gust }
        }
        4 => FieldLaw::Drag {
            density: *rng.pick(&[0.0, 1.2, 1000.0]),
            viscosity: *rng.pick(&[0.0, 1.81e-5, 1.4]),
        },
        5 => FieldLaw::Water {
            surface: somewhere(storm, rng),
            normal: if rng.one_in(3) { unit(rng) } else { Vec3::Y },
            density: *rng.pick(&[1000.0, 1000.0, 700.0, 13_600.0]),
            viscosity: 1e-3,
            linear_drag: *rng.pick(&[0.0, 0.5, 20.0]),
            velocity: if rng.one_in(2) { Vec3::ZERO } else { rng.vec3(3.0) },
        },
        6 => FieldLaw::Vortex {
            center: somewhere(storm, rng),
            axis: unit(rng),
            speed: rng.float(-20.0, 20.0),
            core_radius: rng.decades(-1.0, 0.5) * size,
            inflow: rng.float(-0.5, 1.0),
            updraft: rng.float(-5.0, 10.0),
        },
        7 => FieldLaw::RotatingFrame {
            origin: somewhere(storm, rng),
            angular_velocity: rng.vec3(3.0),
            angular_acceleration: if rng.one_in(3) { rng.vec3(0.5) } else { Vec3::ZERO },
        },
        _ => FieldLaw::User { hook: (*rng.pick(&HOOKS)).to_owned() },
    }
}

/// The numbers as large as the door lets them pass.
fn extreme(law: &mut FieldLaw) {
    match law {
        FieldLaw::Uniform { acceleration } => *acceleration = Vec3::new(1e6, -1e6, 1e6),
        FieldLaw::Point { mu, softening, .. } => (*mu, *softening) = (1e30, 0.0),
        FieldLaw::NBody { g, softening, .. } => (*g, *softening) = (1e20, 0.0),
        FieldLaw::Wind { velocity, .. } => *velocity = Vec3::splat(1e4),
        FieldLaw::Drag { density, viscosity } => (*density, *viscosity) = (1e6, 1e6),
        FieldLaw::Water { density, linear_drag, .. } => (*density, *linear_drag) = (1e6, 1e4),
        FieldLaw::Vortex { speed, inflow, updraft, .. } => (*speed, *inflow, *updraft) = (1e4, 10.0, 1e4),
        FieldLaw::RotatingFrame { angular_velocity, .. } => *angular_velocity = Vec3::splat(1e3),
        _ => {}
    }
}
