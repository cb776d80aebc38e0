//! Fields of a scene file, checked; those that name bodies wait for them to be there.

use crate::bodies::{Names, Target};
use crate::error::{Checked, Under, Wrong};
use crate::shapes::unknown;
use crate::spec::{AeroSpec, ExplodeSpec, FieldRegionSpec, FieldSpec, GustSpec, PointFieldSpec, WaterSpec};
use jounce::limits::{FIELDS_MAX, N_BODY_MAX};
use jounce::math::{DVec3, Vec3};
use jounce::{
    AIR_DENSITY, AIR_VISCOSITY, Aero, Explosion, FieldDesc, FieldLaw, Gust, Region, WATER_DENSITY,
    WATER_VISCOSITY,
};

/// Nature's constant of gravitation (CODATA 2022), m³/(kg s²).
const G: f64 = 6.674_30e-11;

/// A field, and the bodies that it names.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    pub desc: FieldDesc,
    pub bodies: Vec<Target>,
}

pub(crate) fn fields(all: &[FieldSpec], names: &Names) -> Checked<Vec<Field>> {
    if all.len() > FIELDS_MAX {
        let expected = format!("at most {FIELDS_MAX}");
        return Err(Wrong::new(format!("there are {}", all.len()), expected).key("fields"));
    }
    let mut out: Vec<Field> = Vec::with_capacity(all.len());
    for (i, f) in all.iter().enumerate() {
        let built = field(f, names).index(i).key("fields")?;
        let name = &built.desc.name;
        if name.is_some() && out.iter().any(|o| o.desc.name == *name) {
            let message = format!("\"{}\" is given to two fields", name.as_deref().unwrap_or(""));
            return Err(Wrong::new(message, "a name of its own").key("name").index(i).key("fields"));
        }
        out.push(built);
    }
    Ok(out)
}

/// Which field a name means.
pub(crate) fn find(name: &str, fields: &[Field]) -> Checked<usize> {
    let known = fields.iter().filter_map(|f| f.desc.name.as_deref());
    fields
        .iter()
        .position(|f| f.desc.name.as_deref() == Some(name))
        .ok_or_else(|| unknown("field", name, known))
}

fn field(f: &FieldSpec, names: &Names) -> Checked<Field> {
    let given = [
        ("uniform", f.uniform.is_some()),
        ("point", f.point.is_some()),
        ("n_body", f.n_body.is_some()),
        ("wind", f.wind.is_some()),
        ("drag", f.drag.is_some()),
        ("water", f.water.is_some()),
        ("vortex", f.vortex.is_some()),
        ("rotating_frame", f.rotating_frame.is_some()),
    ];
    let there: Vec<&str> = given.iter().filter(|(_, g)| *g).map(|(n, _)| *n).collect();
    let [kind] = there[..] else {
        let all: Vec<&str> = given.iter().map(|(n, _)| *n).collect();
        let message = match there.len() {
            0 => "the field has no law".to_string(),
            _ => format!("the field has {} laws: {}", there.len(), there.join(", ")),
        };
        return Err(Wrong::new(message, format!("exactly one of {}", all.join(", "))));
    };
    let mut bodies = Vec::new();
    let law = match &f.n_body {
        Some(n) => {
            for (i, name) in n.bodies.iter().enumerate() {
                bodies.push(names.resolve(name).index(i).key("bodies").key(kind)?);
            }
            let meant = bodies_meant(&bodies);
            if meant > N_BODY_MAX as u64 {
                let expected = format!("at most {N_BODY_MAX} that attract one another");
                return Err(Wrong::new(format!("names {meant} bodies"), expected).key("bodies").key(kind));
            }
            FieldLaw::NBody { bodies: Vec::new(), g: n.g.unwrap_or(G), softening: n.softening.unwrap_or(0.0) }
        }
        None => law(f)?,
    };
    let mut desc = FieldDesc::new(law);
    desc.name = f.name.clone();
    desc.layers = f.layers.map_or(u32::MAX, |l| l.0);
    desc.enabled = f.enabled.unwrap_or(true);
    if let Some(r) = &f.region {
        desc.region = region(r).key("region")?;
    }
    desc.check().map_err(|e| placed(e, &desc.region, kind))?;
    Ok(Field { desc, bodies })
}

/// The engine's complaint about a field, at the key that holds the value.
fn placed(e: jounce::Error, region: &Region, kind: &str) -> Wrong {
    let jounce::Error::BadValue { field, value, expected, .. } = &e else {
        return Wrong::from(e).key(kind);
    };
    let within = |key: &str| Wrong::new(format!("is {value}"), *expected).key(key);
    let shape = if matches!(region, Region::Box { .. }) { "box" } else { "sphere" };
    match *field {
        "name" => Wrong::from(e),
        "falloff" => within("falloff").key("region"),
        "center of the region" => within("center").key(shape).key("region"),
        "radius of the region" => within("radius").key(shape).key("region"),
        "half of the region" => within("half").key(shape).key("region"),
        _ => Wrong::from(e).key(kind),
    }
}

/// Bodies that names mean together: `star[0]` beside `star` is one of them.
fn bodies_meant(targets: &[Target]) -> u64 {
    let mut seen: Vec<(&str, Option<usize>, u64)> =
        targets.iter().map(|t| (t.name.as_str(), t.index, t.count)).collect();
    // The bare name comes first of its name.
    seen.sort_unstable();
    seen.dedup();
    let mut all = "";
    let mut sum = 0u64;
    for (name, index, count) in seen {
        if index.is_some() && all == name {
            continue;
        }
        if index.is_none() {
            all = name;
        }
        sum = sum.saturating_add(count);
    }
    sum
}

/// A direction of any length but zero.
fn unit(v: Option<[f32; 3]>, key: &str) -> Checked<Vec3> {
    let Some(v) = v else { return Ok(Vec3::Y) };
    let (n, _) =
        Vec3::from_array(v).try_normalize().ok_or_else(|| Wrong::new("is zero", "a direction").key(key))?;
    Ok(n)
}

fn law(f: &FieldSpec) -> Checked<FieldLaw> {
    let v3 = |v: Option<[f32; 3]>| Vec3::from_array(v.unwrap_or([0.0; 3]));
    if let Some(u) = &f.uniform {
        return Ok(FieldLaw::Uniform { acceleration: Vec3::from_array(u.acceleration) });
    }
    if let Some(p) = &f.point {
        return point(p).key("point");
    }
    if let Some(w) = &f.wind {
        return Ok(FieldLaw::Wind { velocity: Vec3::from_array(w.velocity), gust: w.gust.map(gust) });
    }
    if let Some(m) = &f.drag {
        return Ok(FieldLaw::Drag {
            density: m.density.unwrap_or(AIR_DENSITY),
            viscosity: m.viscosity.unwrap_or(AIR_VISCOSITY),
        });
    }
    if let Some(w) = &f.water {
        return water(w).key("water");
    }
    if let Some(v) = &f.vortex {
        return Ok(FieldLaw::Vortex {
            center: DVec3::from_array(v.center),
            axis: unit(v.axis, "axis").key("vortex")?,
            speed: v.speed,
            core_radius: v.core_radius,
            inflow: v.inflow.unwrap_or(0.0),
            updraft: v.updraft.unwrap_or(0.0),
        });
    }
    let Some(r) = &f.rotating_frame else { return Err(Wrong::new("the field has no law", "a law")) };
    Ok(FieldLaw::RotatingFrame {
        origin: DVec3::from_array(r.origin.unwrap_or([0.0; 3])),
        angular_velocity: Vec3::from_array(r.angular_velocity),
        angular_acceleration: v3(r.angular_acceleration),
    })
}

fn gust(g: GustSpec) -> Gust {
    Gust {
        speed: g.speed,
        size: g.size.unwrap_or(5.0),
        time_s: g.time_s.unwrap_or(2.0),
        seed: g.seed.unwrap_or(0),
    }
}

fn point(p: &PointFieldSpec) -> Checked<FieldLaw> {
    let mu = match (p.mu, p.mass) {
        (Some(mu), None) => mu,
        (None, Some(m)) => G * m,
        (Some(_), Some(_)) => {
            return Err(Wrong::new("given beside `mass`", "mu or mass, not both").key("mu"));
        }
        (None, None) => return Err(Wrong::new("nothing attracts", "mu or mass")),
    };
    Ok(FieldLaw::Point { center: DVec3::from_array(p.center), mu, softening: p.softening.unwrap_or(0.0) })
}

fn water(w: &WaterSpec) -> Checked<FieldLaw> {
    let surface = match (w.level, w.surface) {
        (Some(_), Some(_)) => {
            return Err(Wrong::new("given beside `surface`", "level or surface, not both").key("level"));
        }
        (_, Some(p)) => DVec3::from_array(p),
        (level, None) => DVec3::new(0.0, level.unwrap_or(0.0), 0.0),
    };
    Ok(FieldLaw::Water {
        surface,
        normal: unit(w.normal, "normal")?,
        density: w.density.unwrap_or(WATER_DENSITY),
        viscosity: w.viscosity.unwrap_or(WATER_VISCOSITY),
        linear_drag: w.linear_drag.unwrap_or(0.5),
        velocity: Vec3::from_array(w.velocity.unwrap_or([0.0; 3])),
    })
}

fn region(r: &FieldRegionSpec) -> Checked<Region> {
    let falloff = r.falloff.unwrap_or(0.0);
    match (&r.sphere, &r.cuboid) {
        (Some(s), None) => {
            Ok(Region::Sphere { center: DVec3::from_array(s.center), radius: s.radius, falloff })
        }
        (None, Some(b)) => {
            Ok(Region::Box { center: DVec3::from_array(b.center), half: DVec3::from_array(b.half), falloff })
        }
        _ => Err(Wrong::new("the region has no clear shape", "exactly one of sphere, box")),
    }
}

pub(crate) fn aero(a: &AeroSpec) -> Checked<Aero> {
    let aero =
        Aero { drag: a.drag, area: a.area, lift: a.lift.unwrap_or(0.0), stokes_radius: a.stokes_radius };
    aero.check()?;
    Ok(aero)
}

pub(crate) fn explosion(e: &ExplodeSpec) -> Checked<Explosion> {
    let mut out = Explosion::new(e.center, e.radius, e.impulse);
    out.occlusion = e.occlusion.unwrap_or(true);
    out.layers = e.layers.map_or(u32::MAX, |l| l.0);
    out.check()?;
    Ok(out)
}
