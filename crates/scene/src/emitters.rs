//! Emitters of a scene file, checked.

use crate::bodies::{Names, Target};
use crate::error::{Checked, Under, Wrong};
use crate::shapes::{Library, rotation, unknown};
use crate::spec::{
    BurstSpec, EmitterShapeSpec, EmitterSpec, HitResponseSpec, ParticleCollisionSpec, PresetSpec,
};
use jounce::limits::EMITTERS_MAX;
use jounce::math::{DVec3, Vec3, WorldPose};
use jounce::particles::{dust, explosion, fire, fountain, genesis, smoke, snow, sparks, spray};
use jounce::{
    Burst, Curve, EmitDirection, EmitterDesc, EmitterShape, Filter, Gradient, Heat, HitResponse,
    ParticleCollision, Turbulence,
};

/// One entry: the emitters that it makes, and the body that carries them.
#[derive(Clone, Debug)]
pub(crate) struct Emitters {
    pub name: Option<String>,
    pub descs: Vec<EmitterDesc>,
    pub body: Option<Target>,
}

pub(crate) fn emitters(all: &[EmitterSpec], library: &mut Library, names: &Names) -> Checked<Vec<Emitters>> {
    let mut out: Vec<Emitters> = Vec::with_capacity(all.len().min(EMITTERS_MAX));
    let mut made = 0;
    for (i, e) in all.iter().enumerate() {
        let built = entry(e, library, names).index(i).key("emitters")?;
        made += built.descs.len();
        if made > EMITTERS_MAX {
            let expected = format!("at most {EMITTERS_MAX}; a preset makes several");
            return Err(Wrong::new(format!("makes {made} emitters"), expected).index(i).key("emitters"));
        }
        if built.name.is_some() && out.iter().any(|o| o.name == built.name) {
            let message = format!("\"{}\" is given to two emitters", built.name.as_deref().unwrap_or(""));
            return Err(Wrong::new(message, "a name of its own").key("name").index(i).key("emitters"));
        }
        out.push(built);
    }
    Ok(out)
}

/// Which entry a name means.
pub(crate) fn find(name: &str, all: &[Emitters]) -> Checked<usize> {
    let known = all.iter().filter_map(|e| e.name.as_deref());
    all.iter().position(|e| e.name.as_deref() == Some(name)).ok_or_else(|| unknown("emitter", name, known))
}

fn entry(e: &EmitterSpec, library: &mut Library, names: &Names) -> Checked<Emitters> {
    let mut descs = match e.preset {
        Some(p) => preset(p, e)?,
        None => vec![described(e, library)?],
    };
    let body = e.body.as_deref().map(|b| names.resolve(b)).transpose().key("body")?;
    if let Some(b) = &body
        && b.count > 1
    {
        let message = format!("names {} bodies", b.count);
        return Err(Wrong::new(message, format!("one, such as {}", b.one)).key("body"));
    }
    for d in &mut descs {
        if e.preset.is_some() {
            // The parts of an effect keep their order.
            d.delay_s += e.delay_s.unwrap_or(0.0);
        }
        if let Some(c) = &e.collision {
            d.collision = Some(collision(c));
        }
        d.enabled = e.enabled.unwrap_or(true);
        d.check().map_err(|told| placed(told, e))?;
    }
    Ok(Emitters { name: e.name.clone(), descs, body })
}

/// The engine's complaint about an emitter, at the key that holds the value.
fn placed(told: jounce::Error, e: &EmitterSpec) -> Wrong {
    if let jounce::Error::Unsupported { what: "emitter: turbulence without drag", .. } = told {
        return Wrong::from(told).key("turbulence");
    }
    let jounce::Error::BadValue { field, value, expected, .. } = &told else { return told.into() };
    let within = |key: &str| Wrong::new(format!("is {value}"), *expected).key(key);
    match *field {
        "radius of the sphere" if e.shape.as_ref().is_some_and(|s| s.sphere_surface.is_some()) => {
            within("sphere_surface").key("shape")
        }
        "radius of the sphere" => within("sphere").key("shape"),
        "radius of the disc" => within("disc").key("shape"),
        "radius of the cone" => within("radius").key("cone").key("shape"),
        "half of the box" => within("box").key("shape"),
        "burst.time_s" => {
            let early = |b: &BurstSpec| !(0.0..=1e9).contains(&b.time_s.unwrap_or(0.0));
            let n = e.bursts.iter().position(early).unwrap_or(0);
            within("time_s").index(n).key("bursts")
        }
        _ => told.into(),
    }
}

/// An angle that the file gives in degrees, in radians.
fn degrees(v: f32, max: f32, key: &str) -> Checked<f32> {
    if !(0.0..=max).contains(&v) {
        return Err(Wrong::new(format!("is {v}"), format!("0 to {max} degrees")).key(key));
    }
    Ok(v.to_radians())
}

fn preset(p: PresetSpec, e: &EmitterSpec) -> Checked<Vec<EmitterDesc>> {
    let others = [
        ("shape", e.shape.is_some()),
        ("rotation_deg", e.rotation_deg.is_some()),
        ("direction", e.direction.is_some()),
        ("outward", e.outward.is_some()),
        ("spread_deg", e.spread_deg.is_some()),
        ("speed", e.speed.is_some()),
        ("rate", e.rate.is_some()),
        ("bursts", !e.bursts.is_empty()),
        ("duration_s", e.duration_s.is_some()),
        ("looping", e.looping.is_some()),
        ("lifetime_s", e.lifetime_s.is_some()),
        ("mass", e.mass.is_some()),
        ("radius", e.radius.is_some()),
        ("size_over_life", e.size_over_life.is_some()),
        ("color_over_life", e.color_over_life.is_some()),
        ("gravity_scale", e.gravity_scale.is_some()),
        ("linear_drag", e.linear_drag.is_some()),
        ("drag_coefficient", e.drag_coefficient.is_some()),
        ("turbulence", e.turbulence.is_some()),
        ("heat", e.heat.is_some()),
        ("kill_below", e.kill_below.is_some()),
        ("layers", e.layers.is_some()),
        ("max_particles", e.max_particles.is_some()),
    ];
    if let Some((key, _)) = others.iter().find(|(_, given)| *given) {
        let expected = "name, body, position, scale, seed, delay_s, collision and enabled beside `preset`";
        return Err(Wrong::new("is given beside `preset`", expected).key(key));
    }
    let scale = e.scale.unwrap_or(1.0);
    if !(0.01..=1e4).contains(&scale) {
        return Err(Wrong::new(format!("is {scale}"), "0.01 to 10000 m").key("scale"));
    }
    let (at, seed) = (DVec3::from_array(e.position.unwrap_or([0.0; 3])), e.seed.unwrap_or(0));
    let make = match p {
        PresetSpec::Explosion => explosion,
        PresetSpec::Smoke => smoke,
        PresetSpec::Fire => fire,
        PresetSpec::Spray => spray,
        PresetSpec::Fountain => fountain,
        PresetSpec::Sparks => sparks,
        PresetSpec::Dust => dust,
        PresetSpec::Snow => snow,
        PresetSpec::Genesis => genesis,
    };
    Ok(make(at, scale, seed))
}

fn described(e: &EmitterSpec, library: &mut Library) -> Checked<EmitterDesc> {
    if e.scale.is_some() {
        return Err(Wrong::new("is given without `preset`", "scale only beside preset").key("scale"));
    }
    let mut d = EmitterDesc::new();
    d.name = e.name.clone();
    if let Some(s) = &e.shape {
        d.shape = shape(s, library).key("shape")?;
    }
    let turned = rotation(e.rotation_deg, None)?;
    d.pose = WorldPose::new(DVec3::from_array(e.position.unwrap_or([0.0; 3])), turned);
    if let Some(v) = e.direction {
        let unit = Vec3::from_array(v).try_normalize();
        let (n, _) = unit.ok_or_else(|| Wrong::new("is zero", "a direction").key("direction"))?;
        d.direction = EmitDirection::Along(n);
    }
    if e.outward == Some(true) {
        d.direction = EmitDirection::Outward;
    }
    d.spread = degrees(e.spread_deg.unwrap_or(0.0), 180.0, "spread_deg")?;
    d.speed = e.speed.unwrap_or(d.speed);
    d.rate = e.rate.unwrap_or(d.rate);
    d.bursts = e.bursts.iter().map(|b| Burst { time_s: b.time_s.unwrap_or(0.0), count: b.count }).collect();
    d.delay_s = e.delay_s.unwrap_or(d.delay_s);
    d.duration_s = e.duration_s;
    d.looping = e.looping.unwrap_or(d.looping);
    d.lifetime_s = e.lifetime_s.unwrap_or(d.lifetime_s);
    d.mass = e.mass.unwrap_or(d.mass);
    d.radius = e.radius.unwrap_or(d.radius);
    if let Some(keys) = &e.size_over_life {
        d.size_over_life = Curve::new(keys.iter().map(|&[t, v]| (t, v)).collect::<Vec<_>>());
    }
    if let Some(keys) = &e.color_over_life {
        let keys: Vec<_> = keys.iter().map(|&[t, r, g, b, a]| (t, [r, g, b, a])).collect();
        d.color_over_life = Gradient::new(keys);
    }
    d.gravity_scale = e.gravity_scale.unwrap_or(d.gravity_scale);
    d.linear_drag = e.linear_drag.unwrap_or(d.linear_drag);
    d.drag_coefficient = e.drag_coefficient.unwrap_or(d.drag_coefficient);
    d.turbulence = e.turbulence.map(|t| Turbulence {
        speed: t.speed,
        size: t.size,
        time_s: t.time_s.unwrap_or(1.0),
        seed: t.seed.unwrap_or(0),
    });
    d.heat = e.heat.map(|h| Heat {
        excess: h.excess,
        ambient: h.ambient.unwrap_or(293.0),
        cooling_s: h.cooling_s,
    });
    d.kill_below = e.kill_below;
    d.layers = e.layers.map_or(d.layers, |l| l.0);
    d.max_particles = e.max_particles.map_or(d.max_particles, |n| n as usize);
    d.seed = e.seed.unwrap_or(0);
    Ok(d)
}

fn shape(s: &EmitterShapeSpec, library: &mut Library) -> Checked<EmitterShape> {
    let given = [
        s.sphere.is_some(),
        s.sphere_surface.is_some(),
        s.disc.is_some(),
        s.cone.is_some(),
        s.cuboid.is_some(),
        s.mesh.is_some(),
    ];
    if given.iter().filter(|g| **g).count() != 1 {
        let expected = "exactly one of sphere, sphere_surface, disc, cone, box, mesh";
        return Err(Wrong::new("the shape has no clear kind", expected));
    }
    if let Some(radius) = s.sphere {
        return Ok(EmitterShape::Sphere { radius, surface: false });
    }
    if let Some(radius) = s.sphere_surface {
        return Ok(EmitterShape::Sphere { radius, surface: true });
    }
    if let Some(radius) = s.disc {
        return Ok(EmitterShape::Disc { radius });
    }
    if let Some(c) = s.cone {
        return Ok(EmitterShape::Cone {
            half_angle: degrees(c.half_angle_deg, 90.0, "half_angle_deg").key("cone")?,
            radius: c.radius.unwrap_or(0.0),
        });
    }
    if let Some(half) = s.cuboid {
        return Ok(EmitterShape::Box { half: Vec3::from_array(half) });
    }
    let name = s.mesh.as_deref().unwrap_or("");
    library.tri_mesh(name).map(EmitterShape::Mesh)
}

fn collision(c: &ParticleCollisionSpec) -> ParticleCollision {
    let d = ParticleCollision::default();
    ParticleCollision {
        restitution: c.restitution.unwrap_or(d.restitution),
        friction: c.friction.unwrap_or(d.friction),
        response: match c.response {
            None | Some(HitResponseSpec::Bounce) => HitResponse::Bounce,
            Some(HitResponseSpec::Stick) => HitResponse::Stick,
            Some(HitResponseSpec::Kill) => HitResponse::Kill,
        },
        push: c.push.unwrap_or(false),
        filter: Filter { mask: c.mask.map_or(u32::MAX, |m| m.0), ..Filter::default() },
        ..d
    }
}
