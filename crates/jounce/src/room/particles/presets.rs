//! Ready emitters: effects that games want, with physics that a reader can follow.
//!
//! Every function gives descriptions, to be changed at will and added one by one:
//!
//! ```
//! use jounce::{particles, prelude::*};
//!
//! # fn main() -> jounce::Result<()> {
//! let mut world = World::new(WorldDesc::default())?;
//! for emitter in particles::fire(DVec3::ZERO, 1.0, 7) {
//!     world.add_emitter(emitter)?;
//! }
//! world.step()?;
//! # Ok(())
//! # }
//! ```
//!
//! `scale` is the size of the whole in metres, about: the height of a flame, the reach of a spray. Speeds follow from it:
//! what flies under gravity alone keeps its form when speeds grow as √scale (Froude's rule), what drifts, as scale/time.

use super::desc::{
    Burst, Curve, EmitDirection, EmitterDesc, EmitterShape, Gradient, Heat, HitResponse, ParticleCollision,
    Turbulence,
};
use jounce_math::{DVec3, Quat, Vec3, scalar::f32s};

/// √(g · scale), m/s: the speed of what falls or rises through about half of `scale`.
fn fall_speed(scale: f32) -> f32 {
    f32s::sqrt(9.81 * scale)
}

fn base(position: DVec3, seed: u64, name: &str) -> EmitterDesc {
    EmitterDesc { name: Some(name.to_owned()), ..EmitterDesc::new().at(position).seed(seed) }
}

fn ball(radius: f32) -> EmitterShape {
    EmitterShape::Sphere { radius, surface: false }
}

fn bounce(restitution: f32, friction: f32) -> ParticleCollision {
    ParticleCollision { restitution, friction, ..ParticleCollision::default() }
}

/// A flash, a fire ball, sparks and a cloud of smoke that rises from it. All burst once; every emitter removes itself.
pub fn explosion(position: DVec3, scale: f32, seed: u64) -> Vec<EmitterDesc> {
    let v = fall_speed(scale);
    let once = |name| EmitterDesc {
        auto_remove: true,
        direction: EmitDirection::Outward,
        ..base(position, seed, name)
    };
    let flash = EmitterDesc {
        bursts: vec![Burst { time_s: 0.0, count: 12 }],
        shape: ball(0.2 * scale),
        lifetime_s: [0.05, 0.12],
        radius: [0.3 * scale, 0.5 * scale],
        gravity_scale: 0.0,
        color_over_life: Gradient::new([(0.0, [8.0, 7.0, 5.0, 1.0]), (1.0, [4.0, 2.0, 0.5, 0.0])]),
        ..once("flash")
    };
    let fire = EmitterDesc {
        bursts: vec![Burst { time_s: 0.0, count: 700 }],
        shape: ball(0.12 * scale),
        speed: [0.3 * v, 4.0 * v],
        lifetime_s: [0.3, 1.1],
        radius: [0.03 * scale, 0.08 * scale],
        linear_drag: 6.0,
        heat: Some(Heat { excess: 900.0, ambient: 293.0, cooling_s: 0.6 }),
        turbulence: Some(Turbulence { speed: 0.4 * v, size: 0.25 * scale, time_s: 0.3, seed }),
        size_over_life: Curve::new([(0.0, 0.5), (0.3, 1.3), (1.0, 2.4)]),
        // It burns out to soot: below 1 nothing glows any more, and the cloud turns dark.
        color_over_life: Gradient::new([
            (0.0, [6.0, 4.5, 2.0, 0.9]),
            (0.2, [4.0, 1.3, 0.15, 0.6]),
            (0.45, [1.6, 0.22, 0.02, 0.6]),
            (0.7, [0.10, 0.05, 0.035, 0.5]),
            (1.0, [0.04, 0.04, 0.04, 0.0]),
        ]),
        ..once("fire ball")
    };
    let mut out = vec![flash, fire];
    out.extend(sparks(position, scale, seed).into_iter().map(|mut s| {
        (s.rate, s.direction, s.auto_remove) = (0.0, EmitDirection::Outward, true);
        s.bursts = vec![Burst { time_s: 0.0, count: 200 }];
        s.speed = [2.0 * v, 6.0 * v];
        s
    }));
    let mut cloud = smoke(position, scale, seed);
    for s in &mut cloud {
        (s.rate, s.delay_s, s.auto_remove) = (0.0, 0.15, true);
        s.bursts = vec![Burst { time_s: 0.0, count: 120 }];
        (s.shape, s.direction, s.speed) = (ball(0.5 * scale), EmitDirection::Outward, [0.1 * v, 0.8 * v]);
    }
    out.extend(cloud);
    out
}

/// A column of smoke: warm puffs that rise, spread and thin out.
pub fn smoke(position: DVec3, scale: f32, seed: u64) -> Vec<EmitterDesc> {
    vec![EmitterDesc {
        rate: 40.0,
        shape: EmitterShape::Disc { radius: 0.12 * scale },
        spread: 0.3,
        speed: [0.1 * scale, 0.4 * scale],
        lifetime_s: [2.5, 4.0],
        mass: 1e-3,
        radius: [0.08 * scale, 0.12 * scale],
        // As heavy as the air that it is made of: only heat lifts it.
        gravity_scale: 0.0,
        linear_drag: 2.0,
        heat: Some(Heat { excess: 120.0, ambient: 293.0, cooling_s: 2.0 }),
        turbulence: Some(Turbulence { speed: 0.6 * scale, size: 0.6 * scale, time_s: 1.0, seed }),
        size_over_life: Curve::new([(0.0, 0.5), (1.0, 4.0)]),
        // A puff that is four times as wide holds the same smoke, so that less of it stops the light.
        color_over_life: Gradient::new([
            (0.0, [0.10, 0.10, 0.11, 0.0]),
            (0.08, [0.12, 0.12, 0.13, 0.6]),
            (0.5, [0.20, 0.20, 0.21, 0.3]),
            (1.0, [0.35, 0.35, 0.36, 0.0]),
        ]),
        ..base(position, seed, "smoke")
    }]
}

/// Flames with embers and smoke above them.
pub fn fire(position: DVec3, scale: f32, seed: u64) -> Vec<EmitterDesc> {
    let flames = EmitterDesc {
        rate: 200.0,
        shape: EmitterShape::Disc { radius: 0.25 * scale },
        spread: 0.2,
        speed: [0.3 * scale, 0.8 * scale],
        lifetime_s: [0.5, 1.0],
        radius: [0.08 * scale, 0.14 * scale],
        gravity_scale: 0.0,
        linear_drag: 3.0,
        heat: Some(Heat { excess: 700.0, ambient: 293.0, cooling_s: 0.5 }),
        turbulence: Some(Turbulence { speed: 0.8 * scale, size: 0.35 * scale, time_s: 0.35, seed }),
        size_over_life: Curve::new([(0.0, 0.6), (0.25, 1.2), (1.0, 0.4)]),
        // Light adds up where flames overlap: each is faint.
        color_over_life: Gradient::new([
            (0.0, [0.3, 0.5, 2.0, 0.1]),
            (0.12, [4.0, 1.7, 0.3, 0.3]),
            (0.5, [4.0, 0.9, 0.06, 0.28]),
            (0.8, [3.0, 0.3, 0.01, 0.12]),
            (1.0, [2.0, 0.1, 0.0, 0.0]),
        ]),
        ..base(position, seed, "flames")
    };
    let embers = EmitterDesc {
        rate: 15.0,
        lifetime_s: [1.0, 2.5],
        radius: [0.004 * scale, 0.01 * scale],
        size_over_life: Curve::default(),
        color_over_life: Gradient::new([(0.0, [6.0, 2.5, 0.4, 1.0]), (1.0, [1.5, 0.1, 0.0, 0.0])]),
        name: Some("embers".to_owned()),
        ..flames.clone()
    };
    let mut out = vec![flames, embers];
    for mut s in smoke(position + DVec3::Y * f64::from(0.7 * scale), scale, seed) {
        s.rate = 30.0;
        out.push(s);
    }
    out
}

/// A jet of drops along +x that falls in an arc and is slowed by air. The world needs air ([`crate::FieldDesc::air`]) for that.
pub fn spray(position: DVec3, scale: f32, seed: u64) -> Vec<EmitterDesc> {
    // Thrown at 30°, a range of `scale` needs v² = g scale / sin 60°.
    let v = fall_speed(scale) * 1.075;
    vec![EmitterDesc {
        rate: 2000.0,
        pose: jounce_math::WorldPose::new(
            position,
            Quat::from_axis_angle(Vec3::Z, -core::f32::consts::FRAC_PI_3),
        ),
        shape: EmitterShape::Cone { half_angle: 0.12, radius: 0.004 * scale },
        speed: [0.9 * v, 1.1 * v],
        lifetime_s: [1.5, 2.5],
        // Drops of 2 to 4 mm: 4/3 π r³ ρ.
        mass: 1.4e-5,
        radius: [0.001, 0.002],
        collision: Some(bounce(0.1, 0.4)),
        // Each is drawn as several: nobody simulates all the drops of a jet.
        size_over_life: Curve::new([(0.0, 3.0), (1.0, 5.0)]),
        color_over_life: Gradient::new([
            (0.0, [0.75, 0.88, 1.0, 0.7]),
            (0.7, [0.85, 0.93, 1.0, 0.5]),
            (1.0, [0.9, 0.95, 1.0, 0.0]),
        ]),
        ..base(position, seed, "spray")
    }]
}

/// Water thrown up to a height of `scale` that falls back and splashes.
pub fn fountain(position: DVec3, scale: f32, seed: u64) -> Vec<EmitterDesc> {
    let v = f32s::sqrt(2.0 * 9.81 * scale);
    vec![EmitterDesc {
        rate: 3000.0,
        shape: EmitterShape::Cone { half_angle: 0.15, radius: 0.02 * scale },
        speed: [0.92 * v, v],
        lifetime_s: [2.4 * v / 9.81, 2.8 * v / 9.81],
        mass: 3.3e-5,
        radius: [0.002, 0.004],
        collision: Some(bounce(0.25, 0.3)),
        // As of a spray.
        size_over_life: Curve::new([(0.0, 2.0), (1.0, 3.0)]),
        color_over_life: Gradient::new([
            (0.0, [0.7, 0.86, 1.0, 0.8]),
            (0.8, [0.85, 0.93, 1.0, 0.6]),
            (1.0, [0.9, 0.95, 1.0, 0.0]),
        ]),
        ..base(position, seed, "fountain")
    }]
}

/// Glowing grains off a grinder: fast, heavy for their size, bouncing.
pub fn sparks(position: DVec3, scale: f32, seed: u64) -> Vec<EmitterDesc> {
    let v = fall_speed(scale);
    vec![EmitterDesc {
        rate: 500.0,
        spread: 0.6,
        speed: [1.0 * v, 2.5 * v],
        lifetime_s: [0.4, 1.2],
        // Iron, half a millimetre: 4/3 π r³ · 7900 kg/m³.
        mass: 4e-6,
        radius: [0.000_4, 0.000_6],
        linear_drag: 0.3,
        collision: Some(bounce(0.5, 0.1)),
        size_over_life: Curve::new([(0.0, 1.0), (1.0, 0.3)]),
        color_over_life: Gradient::new([
            (0.0, [8.0, 7.0, 4.0, 1.0]),
            (0.4, [6.0, 2.5, 0.3, 1.0]),
            (1.0, [1.0, 0.1, 0.0, 0.0]),
        ]),
        ..base(position, seed, "sparks")
    }]
}

/// A puff that a step or a landing raises: it spreads along the ground and settles.
pub fn dust(position: DVec3, scale: f32, seed: u64) -> Vec<EmitterDesc> {
    vec![EmitterDesc {
        bursts: vec![Burst { time_s: 0.0, count: 300 }],
        auto_remove: true,
        shape: EmitterShape::Disc { radius: 0.3 * scale },
        direction: EmitDirection::Outward,
        spread: 0.8,
        speed: [0.2 * scale, 2.0 * scale],
        lifetime_s: [1.0, 2.5],
        mass: 1e-6,
        radius: [0.03 * scale, 0.08 * scale],
        gravity_scale: 0.02,
        linear_drag: 4.0,
        turbulence: Some(Turbulence { speed: 0.3 * scale, size: 0.4 * scale, time_s: 0.7, seed }),
        collision: Some(ParticleCollision { radius_scale: 0.2, ..bounce(0.0, 0.2) }),
        size_over_life: Curve::new([(0.0, 0.6), (1.0, 2.5)]),
        color_over_life: Gradient::new([
            (0.0, [0.50, 0.40, 0.28, 0.0]),
            (0.08, [0.50, 0.40, 0.28, 0.5]),
            (0.5, [0.55, 0.46, 0.34, 0.25]),
            (1.0, [0.60, 0.52, 0.42, 0.0]),
        ]),
        ..base(position, seed, "dust")
    }]
}

/// Snow from a cloud `scale` wide, at `position`: flakes sink at about 1 m/s, drift, and lie where they land.
pub fn snow(position: DVec3, scale: f32, seed: u64) -> Vec<EmitterDesc> {
    let half = 0.5 * scale;
    // Ten flakes a second over each square metre, that live up to 25 s.
    let rate = 10.0 * scale * scale;
    vec![EmitterDesc {
        rate: f64::from(rate),
        max_particles: f32s::clamp(25.0 * rate, 100.0, 1e6) as usize,
        shape: EmitterShape::Box { half: Vec3::new(half, 0.02 * scale, half) },
        direction: EmitDirection::Along(-Vec3::Y),
        speed: [0.8, 1.2],
        lifetime_s: [15.0, 25.0],
        mass: 3e-6,
        radius: [0.002, 0.004],
        size_over_life: Curve::new([(0.0, 3.0)]),
        // g/k = 1 m/s.
        linear_drag: 9.81,
        turbulence: Some(Turbulence { speed: 0.5, size: 2.0, time_s: 2.0, seed }),
        collision: Some(ParticleCollision { response: HitResponse::Stick, ..bounce(0.0, 1.0) }),
        color_over_life: Gradient::new([
            (0.0, [0.95, 0.96, 1.0, 0.0]),
            (0.05, [0.95, 0.96, 1.0, 0.9]),
            (0.9, [0.95, 0.96, 1.0, 0.9]),
            (1.0, [0.95, 0.96, 1.0, 0.0]),
        ]),
        ..base(position, seed, "snow")
    }]
}

/// A wall of fire that spreads over a planet from the place of an impact, in rings.
///
/// The first particle system in film: Reeves 1983, "Particle systems — a technique for modeling a class of fuzzy objects"
/// (ACM Transactions on Graphics 2), for the "Genesis" sequence of *Star Trek II* (1982). As there, the system has two
/// generations: emitters lie in rings around the impact, so many as the ring is long, at random places in it, and each starts
/// when the front passes; each throws particles up in a cone about the planet's normal, which fall back in arcs while the
/// front goes on.
///
/// `center` and `radius` are the planet's; the impact is at the top (+y). A field must pull to the centre, such as
/// [`crate::FieldLaw::Point`] with μ = g · radius², in a world without gravity of its own; 9.81 m/s² is assumed for g.
/// 380 emitters; the front takes `12 s · √(radius/10 m)` to the far side.
pub fn genesis(center: DVec3, radius: f32, seed: u64) -> Vec<EmitterDesc> {
    const RINGS: usize = 14;
    const EQUATOR: f32 = 42.0;
    let v = f32s::sqrt(9.81 * radius);
    let duration = f64::from(12.0 * f32s::sqrt(radius / 10.0));
    let mut out = Vec::new();
    for ring in 0..RINGS {
        let angle = core::f32::consts::PI * (ring as f32 + 0.5) / RINGS as f32;
        let count = f32s::max(EQUATOR * f32s::sin(angle), 3.0) as usize;
        for k in 0..count {
            let n = out.len() as u64;
            let dice = |purpose| (super::birth::random(seed, n, purpose) >> 40) as f32 * (1.0 / 16_777_216.0);
            let turn = core::f32::consts::TAU * (k as f32 + 0.8 * dice(1)) / count as f32;
            let angle = angle + (dice(2) - 0.5) * core::f32::consts::PI / RINGS as f32;
            let (s, c) = (f32s::sin(angle), f32s::cos(angle));
            let up = Vec3::new(s * f32s::cos(turn), c, s * f32s::sin(turn));
            let delay = duration * f64::from(angle / core::f32::consts::PI);
            out.push(eruption(center, radius, up, v, delay, seed ^ n));
        }
    }
    out
}

/// One emitter of the second generation: a jet that dies down.
fn eruption(center: DVec3, radius: f32, up: Vec3, v: f32, delay_s: f64, seed: u64) -> EmitterDesc {
    let position = center + (up * radius).as_dvec3();
    EmitterDesc {
        pose: jounce_math::WorldPose::new(position, Quat::from_rotation_arc(Vec3::Y, up)),
        auto_remove: true,
        rate: 120.0,
        delay_s,
        duration_s: Some(1.5),
        shape: EmitterShape::Disc { radius: 0.1 * radius },
        spread: 0.5,
        // Arcs of 2 to 12 % of the radius: v²/2g.
        speed: [0.2 * v, 0.5 * v],
        lifetime_s: [0.6, 1.4],
        mass: 1e-3,
        radius: [0.012 * radius, 0.028 * radius],
        max_particles: 512,
        size_over_life: Curve::new([(0.0, 0.5), (0.25, 1.2), (1.0, 0.5)]),
        // Light adds up where flames overlap: each is faint.
        color_over_life: Gradient::new([
            (0.0, [5.0, 2.6, 0.7, 0.35]),
            (0.3, [5.0, 1.2, 0.12, 0.3]),
            (0.8, [4.0, 0.25, 0.03, 0.2]),
            (1.0, [2.0, 0.05, 0.02, 0.0]),
        ]),
        ..base(position, seed, "genesis")
    }
}
