//! Every number of every field, blast, emitter and particle with every special value: refused by a name that leads to it with
//! nothing changed, or taken, and then everything stays finite. No panic (arithmetic is checked here), bounded memory.
//!
//! `JOUNCE_PROVE=1` steps every world 600 times afterwards instead of 3.

mod common;

use common::look::not_finite;
use jounce::prelude::*;
use jounce::{
    Burst, Command, Curve, EmitDirection, Error, Gradient, Gust, Heat, ParticleSpawn, Turbulence, limits,
};

/// Zeros, the smallest and the largest, what is not finite, and ordinary numbers where they do not belong.
const SPECIALS: [f64; 26] = [
    0.0,
    -0.0,
    5e-324,
    -5e-324,
    f64::MIN_POSITIVE,
    1e-300,
    -1e-300,
    1e-45,
    1e-38,
    -1e-38,
    1e-30,
    1e12,
    -1e12,
    1e15,
    1e30,
    -1e30,
    3.5e38,
    1e300,
    -1e300,
    f64::MAX,
    f64::MIN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    -1.0,
    16_777_217.0,
];

/// Name that the refusal must have, and the command with the number in its place.
type Row = (&'static str, fn(&Stage, f64) -> Command);

struct Stage {
    world: World,
    field: FieldId,
    emitter: EmitterId,
    shape: ShapeId,
    body: BodyId,
}

/// A heap in a pond, with wind over it and particles about.
fn stage() -> Stage {
    let mut world = World::new(WorldDesc::default()).expect("valid");
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).expect("valid");
    let mut body = None;
    for i in 0..4 {
        let d = BodyDesc::dynamic().at([0.3 * f64::from(i), 0.6 + f64::from(i), 0.0]);
        body = Some(world.add_body(d.shape(ShapeDesc::cuboid([0.5; 3]).density(400.0))).expect("valid"));
    }
    let field = world.add_field(FieldDesc::wind([1.0, 0.0, 0.0])).expect("valid");
    world.add_field(FieldDesc::water(0.8)).expect("valid");
    let d = EmitterDesc::new().at([0.0, 3.0, 0.0]).lifetime(5.0, 9.0).rate(60.0);
    let emitter = world.add_emitter(d.collision(ParticleCollision::default())).expect("valid");
    let body = body.expect("a body");
    let shape = world.body(body).expect("alive").shapes().next().expect("a shape");
    let mut s = Stage { world, field, emitter, shape, body };
    for _ in 0..10 {
        s.world.step().expect("steps");
    }
    s
}

fn v3(x: f64) -> Vec3 {
    Vec3::new(0.0, x as f32, 0.0)
}

fn d3(x: f64) -> DVec3 {
    DVec3::new(0.0, 0.0, x)
}

fn law(law: FieldLaw) -> Command {
    Command::AddField(Box::new(FieldDesc::new(law)))
}

fn within(region: Region) -> Command {
    Command::AddField(Box::new(FieldDesc::air().within(region)))
}

fn gust(speed: f64, size: f64, time_s: f64) -> Command {
    let gust = Gust { speed: speed as f32, size: size as f32, time_s: time_s as f32, seed: 1 };
    law(FieldLaw::Wind { velocity: Vec3::X, gust: Some(gust) })
}

fn water(change: impl FnOnce(&mut FieldLaw)) -> Command {
    let mut d = FieldDesc::water(1.0);
    change(&mut d.law);
    Command::AddField(Box::new(d))
}

fn vortex(speed: f64, core_radius: f64, inflow: f64, updraft: f64) -> FieldLaw {
    let [speed, core_radius, inflow, updraft] = [speed, core_radius, inflow, updraft].map(|x| x as f32);
    FieldLaw::Vortex { center: DVec3::ZERO, axis: Vec3::Y, speed, core_radius, inflow, updraft }
}

const FIELDS: &[Row] = &[
    ("acceleration", |_, x| law(FieldLaw::Uniform { acceleration: v3(x) })),
    ("center", |_, x| law(FieldLaw::Point { center: d3(x), mu: 1.0, softening: 0.0 })),
    ("mu", |_, x| law(FieldLaw::Point { center: DVec3::Y, mu: x, softening: 0.0 })),
    ("softening", |_, x| law(FieldLaw::Point { center: DVec3::Y, mu: 1.0, softening: x })),
    ("g", |s, x| law(FieldLaw::NBody { bodies: s.world.bodies().collect(), g: x, softening: 0.0 })),
    ("softening", |s, x| law(FieldLaw::NBody { bodies: vec![s.body], g: 1.0, softening: x })),
    ("velocity", |_, x| law(FieldLaw::Wind { velocity: v3(x), gust: None })),
    ("gust.speed", |_, x| gust(x, 1.0, 1.0)),
    ("gust.size", |_, x| gust(1.0, x, 1.0)),
    ("gust.time_s", |_, x| gust(1.0, 1.0, x)),
    ("density", |_, x| law(FieldLaw::Drag { density: x as f32, viscosity: 0.0 })),
    ("viscosity", |_, x| law(FieldLaw::Drag { density: 1.0, viscosity: x as f32 })),
    ("surface", |_, x| {
        water(|w| {
            if let FieldLaw::Water { surface, .. } = w {
                *surface = DVec3::Y * x;
            }
        })
    }),
    ("normal", |_, x| {
        water(|w| {
            if let FieldLaw::Water { normal, .. } = w {
                *normal = v3(x);
            }
        })
    }),
    ("density", |_, x| {
        water(|w| {
            if let FieldLaw::Water { density, .. } = w {
                *density = x as f32;
            }
        })
    }),
    ("viscosity", |_, x| {
        water(|w| {
            if let FieldLaw::Water { viscosity, .. } = w {
                *viscosity = x as f32;
            }
        })
    }),
    ("linear_drag", |_, x| {
        water(|w| {
            if let FieldLaw::Water { linear_drag, .. } = w {
                *linear_drag = x as f32;
            }
        })
    }),
    ("velocity", |_, x| {
        water(|w| {
            if let FieldLaw::Water { velocity, .. } = w {
                *velocity = v3(x);
            }
        })
    }),
    ("center", |_, x| {
        let mut v = vortex(1.0, 1.0, 0.0, 0.0);
        if let FieldLaw::Vortex { center, .. } = &mut v {
            *center = d3(x);
        }
        law(v)
    }),
    ("axis", |_, x| {
        let mut v = vortex(1.0, 1.0, 0.0, 0.0);
        if let FieldLaw::Vortex { axis, .. } = &mut v {
            *axis = v3(x);
        }
        law(v)
    }),
    ("speed", |_, x| law(vortex(x, 1.0, 0.0, 0.0))),
    ("core_radius", |_, x| law(vortex(1.0, x, 0.0, 0.0))),
    ("inflow", |_, x| law(vortex(1.0, 1.0, x, 0.0))),
    ("updraft", |_, x| law(vortex(1.0, 1.0, 0.0, x))),
    ("origin", |_, x| {
        let (angular_velocity, angular_acceleration) = (Vec3::Y, Vec3::ZERO);
        law(FieldLaw::RotatingFrame { origin: d3(x), angular_velocity, angular_acceleration })
    }),
    ("angular_velocity", |_, x| {
        let angular_acceleration = Vec3::ZERO;
        law(FieldLaw::RotatingFrame { origin: DVec3::X, angular_velocity: v3(x), angular_acceleration })
    }),
    ("angular_acceleration", |_, x| {
        let angular_velocity = Vec3::Y;
        law(FieldLaw::RotatingFrame { origin: DVec3::X, angular_velocity, angular_acceleration: v3(x) })
    }),
    ("center of the region", |_, x| within(Region::Sphere { center: d3(x), radius: 1.0, falloff: 0.0 })),
    ("radius of the region", |_, x| within(Region::Sphere { center: DVec3::ZERO, radius: x, falloff: 0.1 })),
    ("falloff", |_, x| within(Region::Sphere { center: DVec3::ZERO, radius: 1.0, falloff: x })),
    ("center of the region", |_, x| within(Region::Box { center: d3(x), half: DVec3::ONE, falloff: 0.0 })),
    ("half of the region", |_, x| {
        within(Region::Box { center: DVec3::ZERO, half: DVec3::new(1.0, x, 1.0), falloff: 0.5 })
    }),
    ("falloff", |_, x| within(Region::Box { center: DVec3::ZERO, half: DVec3::ONE, falloff: x })),
    // The same checks stand at the other doors.
    ("acceleration", |s, x| {
        let d = FieldDesc::new(FieldLaw::Uniform { acceleration: v3(x) });
        Command::SetField(s.field, Box::new(d))
    }),
    ("drag", |s, x| Command::SetAero(s.shape, Aero { drag: Some(x as f32), ..Aero::default() })),
    ("area", |s, x| Command::SetAero(s.shape, Aero { area: Some(x as f32), ..Aero::default() })),
    ("lift", |s, x| Command::SetAero(s.shape, Aero { lift: x as f32, ..Aero::default() })),
    ("stokes_radius", |s, x| {
        Command::SetAero(s.shape, Aero { stokes_radius: Some(x as f32), ..Aero::default() })
    }),
    ("drag", |_, x| {
        let aero = Aero { drag: Some(x as f32), ..Aero::default() };
        Command::AddBody(Box::new(
            BodyDesc::dynamic().at([0.0, 9.0, 0.0]).shape(ShapeDesc::sphere(0.5).aero(aero)),
        ))
    }),
    ("center", |_, x| Command::Explode(Explosion::new(d3(x), 3.0, 10.0))),
    ("radius", |_, x| Command::Explode(Explosion::new([0.0, 0.5, 0.0], x as f32, 10.0))),
    ("impulse", |_, x| Command::Explode(Explosion::new([0.0, 0.5, 0.0], 3.0, x as f32))),
];

fn emitter(change: impl FnOnce(&mut EmitterDesc)) -> Command {
    let mut d = EmitterDesc::new().at([0.0, 2.0, 0.0]).rate(50.0).collision(ParticleCollision::default());
    change(&mut d);
    Command::AddEmitter(Box::new(d))
}

fn spawn(s: &Stage, change: impl FnOnce(&mut ParticleSpawn)) -> Command {
    let mut p =
        ParticleSpawn { position: DVec3::Y, velocity: Vec3::X, lifetime_s: 1.0, mass: 0.01, radius: 0.02 };
    change(&mut p);
    Command::EmitParticles(s.emitter, vec![p])
}

const EMITTERS: &[Row] = &[
    ("position", |_, x| emitter(|d| d.pose.p.x = x)),
    ("rotation", |_, x| emitter(|d| d.pose.q.w = x as f32)),
    ("inherit_velocity", |s, x| {
        let b = s.body;
        emitter(|d| (d.body, d.inherit_velocity) = (Some(b), x as f32))
    }),
    ("direction", |_, x| emitter(|d| d.direction = EmitDirection::Along(v3(x)))),
    ("spread", |_, x| emitter(|d| d.spread = x as f32)),
    ("speed", |_, x| emitter(|d| d.speed = [x as f32, 1.0])),
    ("speed", |_, x| emitter(|d| d.speed = [0.0, x as f32])),
    ("rate", |_, x| emitter(|d| d.rate = x)),
    ("burst.time_s", |_, x| emitter(|d| d.bursts = vec![Burst { time_s: x, count: 5 }])),
    ("delay_s", |_, x| emitter(|d| d.delay_s = x)),
    ("duration_s", |_, x| emitter(|d| d.duration_s = Some(x))),
    ("duration_s", |_, x| {
        emitter(|d| {
            (d.duration_s, d.looping) = (Some(x), true);
            d.bursts = vec![Burst { time_s: 0.0, count: 5 }];
        })
    }),
    ("lifetime_s", |_, x| emitter(|d| d.lifetime_s = [x as f32, 1.0])),
    ("lifetime_s", |_, x| emitter(|d| d.lifetime_s = [1.0, x as f32])),
    ("mass", |_, x| emitter(|d| d.mass = x as f32)),
    ("radius", |_, x| emitter(|d| d.radius = [x as f32, 0.01])),
    ("radius", |_, x| emitter(|d| d.radius = [0.01, x as f32])),
    ("size_over_life", |_, x| emitter(|d| d.size_over_life = Curve::new([(x as f32, 1.0)]))),
    ("size_over_life", |_, x| emitter(|d| d.size_over_life = Curve::new([(0.5, x as f32)]))),
    ("color_over_life", |_, x| emitter(|d| d.color_over_life = Gradient::new([(x as f32, [1.0; 4])]))),
    ("color_over_life", |_, x| {
        emitter(|d| d.color_over_life = Gradient::new([(0.5, [1.0, x as f32, 1.0, 1.0])]))
    }),
    ("gravity_scale", |_, x| emitter(|d| d.gravity_scale = x as f32)),
    ("linear_drag", |_, x| emitter(|d| d.linear_drag = x as f32)),
    ("drag_coefficient", |_, x| emitter(|d| d.drag_coefficient = x as f32)),
    ("turbulence.speed", |_, x| emitter(|d| d.turbulence = Some(turbulence(x, 1.0, 1.0)))),
    ("turbulence.size", |_, x| emitter(|d| d.turbulence = Some(turbulence(1.0, x, 1.0)))),
    ("turbulence.time_s", |_, x| emitter(|d| d.turbulence = Some(turbulence(1.0, 1.0, x)))),
    ("heat.excess", |_, x| emitter(|d| d.heat = Some(heat(x, 293.0, 1.0)))),
    ("heat.ambient", |_, x| emitter(|d| d.heat = Some(heat(100.0, x, 1.0)))),
    ("heat.cooling_s", |_, x| emitter(|d| d.heat = Some(heat(100.0, 293.0, x)))),
    ("collision.restitution", |_, x| emitter(|d| rules(d).restitution = x as f32)),
    ("collision.friction", |_, x| emitter(|d| rules(d).friction = x as f32)),
    ("collision.radius_scale", |_, x| emitter(|d| rules(d).radius_scale = x as f32)),
    ("kill_below", |_, x| emitter(|d| d.kill_below = Some(x))),
    ("kill_outside", |_, x| emitter(|d| d.kill_outside = Some([DVec3::splat(x), DVec3::splat(9.0)]))),
    ("kill_outside", |_, x| emitter(|d| d.kill_outside = Some([DVec3::splat(-9.0), DVec3::splat(x)]))),
    ("radius of the sphere", |_, x| {
        emitter(|d| d.shape = EmitterShape::Sphere { radius: x as f32, surface: false })
    }),
    ("radius of the sphere", |_, x| {
        emitter(|d| d.shape = EmitterShape::Sphere { radius: x as f32, surface: true })
    }),
    ("radius of the disc", |_, x| emitter(|d| d.shape = EmitterShape::Disc { radius: x as f32 })),
    ("half_angle of the cone", |_, x| {
        emitter(|d| d.shape = EmitterShape::Cone { half_angle: x as f32, radius: 0.1 })
    }),
    ("radius of the cone", |_, x| {
        emitter(|d| d.shape = EmitterShape::Cone { half_angle: 0.5, radius: x as f32 })
    }),
    ("half of the box", |_, x| {
        emitter(|d| d.shape = EmitterShape::Box { half: Vec3::new(1.0, x as f32, 1.0) })
    }),
    ("rate", |s, x| Command::SetEmitter(s.emitter, Box::new(EmitterDesc::new().rate(x)))),
    ("position of a particle", |s, x| spawn(s, |p| p.position.z = x)),
    ("velocity of a particle", |s, x| spawn(s, |p| p.velocity = v3(x))),
    ("lifetime_s of a particle", |s, x| spawn(s, |p| p.lifetime_s = x as f32)),
    ("mass of a particle", |s, x| spawn(s, |p| p.mass = x as f32)),
    ("radius of a particle", |s, x| spawn(s, |p| p.radius = x as f32)),
];

fn turbulence(speed: f64, size: f64, time_s: f64) -> Turbulence {
    Turbulence { speed: speed as f32, size: size as f32, time_s: time_s as f32, seed: 2 }
}

fn heat(excess: f64, ambient: f64, cooling_s: f64) -> Heat {
    Heat { excess: excess as f32, ambient: ambient as f32, cooling_s: cooling_s as f32 }
}

fn rules(d: &mut EmitterDesc) -> &mut ParticleCollision {
    d.collision.get_or_insert_with(ParticleCollision::default)
}

/// Every row with every value; gives how many were taken and refused.
fn every_value(rows: &[Row]) -> [usize; 2] {
    let (s, mut count) = (stage(), [0; 2]);
    let (mut wrong, before) = (Vec::new(), s.world.hash());
    for (name, command) in rows {
        let mut refused = 0;
        for x in SPECIALS {
            let mut world = s.world.clone();
            match world.apply(command(&s, x)) {
                Ok(_) => {
                    count[0] += 1;
                    if !x.is_finite() {
                        wrong.push(format!("{name}: {x} is taken"));
                    }
                    for step in 0..if common::prove() { 600 } else { 3 } {
                        world.step().expect("steps");
                        if let Some(what) = not_finite(&world) {
                            wrong.push(format!("{name} = {x:e}, step {step}: {what}"));
                            break;
                        }
                    }
                    let out = world.bodies().filter(|b| !world.body(*b).expect("alive").is_enabled()).count();
                    if out > 0 {
                        wrong.push(format!("{name} = {x:e}: {out} bodies out"));
                    }
                }
                Err(e) => {
                    (count[1], refused) = (count[1] + 1, refused + 1);
                    let named = match &e {
                        Error::BadValue { field, value, expected, .. } => {
                            field == name && !value.is_empty() && !expected.is_empty()
                        }
                        _ => false,
                    };
                    if !named || world.hash() != before {
                        wrong.push(format!("{name} = {x:e}: {e}"));
                    }
                }
            }
        }
        // NaN and the two infinities at least.
        assert!(refused >= 3, "{name}: only {refused} values are refused");
    }
    assert!(wrong.is_empty(), "{} of them: {wrong:#?}", wrong.len());
    count
}

#[test]
fn every_number_of_fields_and_blasts() {
    let [taken, refused] = every_value(FIELDS);
    assert!(taken > 200 && refused > 400, "{taken} taken, {refused} refused");
}

#[test]
fn every_number_of_emitters_and_particles() {
    let [taken, refused] = every_value(EMITTERS);
    assert!(taken > 200 && refused > 400, "{taken} taken, {refused} refused");
}

/// Counts: none, too many, empty.
#[test]
fn counts_are_bounded_and_empty_lists_are_harmless() {
    let s = stage();
    let mut world = s.world.clone();
    let empty: &[Command] = &[
        law(FieldLaw::NBody { bodies: Vec::new(), g: 1.0, softening: 0.0 }),
        Command::EmitParticles(s.emitter, Vec::new()),
        Command::EmitBurst(s.emitter, 0),
        emitter(|d| (d.rate, d.bursts) = (0.0, Vec::new())),
        emitter(|d| d.size_over_life = Curve::new([])),
    ];
    for c in empty {
        world.apply(c.clone()).expect("nothing to do");
    }
    let long = "x".repeat(limits::NAME_MAX + 1);
    let refused: &[Command] = &[
        law(FieldLaw::User { hook: String::new() }),
        law(FieldLaw::User { hook: "unheard of".to_owned() }),
        law(FieldLaw::User { hook: long.clone() }),
        law(FieldLaw::NBody { bodies: vec![s.body, s.body], g: 1.0, softening: 0.0 }),
        law(FieldLaw::NBody { bodies: vec![s.body; limits::N_BODY_MAX + 1], g: 1.0, softening: 0.0 }),
        law(FieldLaw::NBody { bodies: vec![BodyId::from_bits(u64::MAX)], g: 1.0, softening: 0.0 }),
        Command::AddField(Box::new(FieldDesc { name: Some(long.clone()), ..FieldDesc::air() })),
        emitter(|d| d.name = Some(long.clone())),
        emitter(|d| d.kill_hook = Some(long.clone())),
        emitter(|d| d.kill_hook = Some(String::new())),
        emitter(|d| d.max_particles = 0),
        emitter(|d| d.max_particles = usize::MAX),
        emitter(|d| d.bursts = vec![Burst { time_s: 0.0, count: 1 }; limits::BURSTS_MAX + 1]),
        emitter(|d| d.size_over_life = Curve::new([(0.5, 1.0); limits::CURVE_KEYS_MAX + 1])),
        emitter(|d| d.color_over_life = Gradient::new([(0.5, [1.0; 4]); limits::CURVE_KEYS_MAX + 1])),
        emitter(|d| d.looping = true),
    ];
    let before = world.hash();
    for c in refused {
        let e = world.apply(c.clone()).expect_err("refused").to_string();
        assert!(e.len() > 10 && e.len() < 600, "{e}");
    }
    assert_eq!(world.hash(), before, "refused commands change nothing");
    // A burst beyond all bounds fills what there is room for and says so; memory stays that of the emitter's limit.
    let room = 1000;
    let d = EmitterDesc::new().lifetime(99.0, 99.0).max_particles(room);
    let d = EmitterDesc { bursts: vec![Burst { time_s: 0.0, count: u32::MAX }; limits::BURSTS_MAX], ..d };
    let e = world.add_emitter(d.rate(limits::EMITTER_RATE_MAX)).expect("valid");
    for _ in 0..3 {
        world.step().expect("steps");
        assert!(world.events().contains(&Event::LimitReached { what: "particles" }));
        assert_eq!(world.emitter(e).expect("alive").len(), room);
        world.emit_burst(e, u32::MAX).expect("told, not refused");
        assert_eq!(world.emitter(e).expect("alive").len(), room);
    }
    let spawn =
        ParticleSpawn { position: DVec3::Y, velocity: Vec3::X, lifetime_s: 1.0, mass: 0.01, radius: 0.02 };
    assert!(matches!(world.emit_particles(e, vec![spawn; 5]), Err(Error::Limit { .. })));
}

/// As many fields and emitters as there may be, and one more.
#[test]
fn one_field_and_one_emitter_too_many() {
    let mut world = World::new(WorldDesc::default()).expect("valid");
    for _ in 0..limits::FIELDS_MAX {
        world.add_field(FieldDesc::new(FieldLaw::Uniform { acceleration: Vec3::ZERO })).expect("room");
    }
    assert!(matches!(world.add_field(FieldDesc::air()), Err(Error::Limit { what: "fields", .. })));
    for _ in 0..limits::EMITTERS_MAX {
        world.add_emitter(EmitterDesc::new()).expect("room");
    }
    assert!(matches!(world.add_emitter(EmitterDesc::new()), Err(Error::Limit { what: "emitters", .. })));
    world.step().expect("steps");
}

/// A hook that has no number: the body is out within the step, the rest of the heap does not notice.
#[test]
fn a_hook_without_a_number_is_contained() {
    for poison in [f32::NAN, f32::INFINITY, 1e38] {
        let s = stage();
        let mut world = s.world.clone();
        let victim = s.body.to_bits();
        let hook: jounce::FieldHook = std::sync::Arc::new(move |v| {
            if v.body.is_some_and(|b| b.to_bits() == victim) { Vec3::splat(poison) } else { Vec3::ZERO }
        });
        world.set_field_hook("poison", Some(hook));
        world.add_field(FieldDesc::new(FieldLaw::User { hook: "poison".to_owned() })).expect("registered");
        for _ in 0..60 {
            world.step().expect("steps");
            assert_eq!(not_finite(&world), None);
        }
        let out: Vec<BodyId> =
            world.bodies().filter(|b| !world.body(*b).expect("alive").is_enabled()).collect();
        assert_eq!(out, if poison.is_nan() { vec![s.body] } else { Vec::new() }, "{poison}");
    }
}
