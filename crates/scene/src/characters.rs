//! Characters of a scene file, checked, and the names that probes and actions know them by.

use crate::bodies::{Bearers, Census, Group, Names, Place, Target, Template, color, grid, resolve_name};
use crate::error::{Checked, Under, Wrong};
use crate::spec::{CharacterSpec, RepeatSpec, WalkSpec};
use jounce::limits::SPEED_MAX;
use jounce::math::Vec3;
use jounce::{
    BodyDesc, BodyKind, CharacterDesc, CharacterId, CharacterInput, CharacterKind, CharacterMover, Filter,
};
use std::collections::BTreeMap;

/// One entry: a character, or copies of it.
#[derive(Clone, Debug)]
pub(crate) struct CharacterGroup {
    /// Where they are, and how their bodies look; the bodies are the characters' own.
    pub group: Group,
    desc: CharacterDesc,
    pub input: CharacterInput,
}

impl CharacterGroup {
    /// Character `n`, where so many were made before.
    pub(crate) fn character(&self, n: usize, made: usize) -> CharacterDesc {
        let mut d = self.desc.clone();
        d.position += self.group.places[n].position;
        let name = self.group.name.as_ref();
        d.name =
            name.map(|name| if self.group.single { name.clone() } else { format!("{name}[{}]", made + n) });
        d
    }
}

/// Names of characters and how many bear each.
#[derive(Clone, Debug, Default)]
pub(crate) struct CharacterNames(BTreeMap<String, u64>);

impl CharacterNames {
    /// The characters that a text names: `name` (all of them) or `name[n]`.
    pub(crate) fn resolve(&self, text: &str) -> Checked<Target> {
        let known = self.0.keys().map(String::as_str);
        resolve_name("character", text, known, |name| self.0.get(name).copied())
    }
}

/// The characters of a scene, by name.
#[derive(Clone, Debug, Default)]
pub(crate) struct CharacterRecords {
    names: BTreeMap<String, Vec<CharacterId>>,
}

impl CharacterRecords {
    pub(crate) fn add(&mut self, name: Option<&String>, id: CharacterId) {
        if let Some(name) = name {
            self.names.entry(name.clone()).or_default().push(id);
        }
    }
    /// The characters of a target; some may be removed by now.
    pub(crate) fn of(&self, target: &Target) -> &[CharacterId] {
        let all = self.names.get(&target.name).map_or(&[][..], Vec::as_slice);
        match target.index {
            None => all,
            Some(i) => all.get(i..=i).unwrap_or(&[]),
        }
    }
}

/// Entries of `characters`, each made so many times. Their bodies get their names among the bodies.
pub(crate) fn characters(
    all: &[CharacterSpec],
    times: u64,
    census: &mut Census,
    names: &mut Names,
    (out, character_names): &mut (Vec<CharacterGroup>, CharacterNames),
) -> Checked<()> {
    for (i, c) in all.iter().enumerate() {
        let mut g = entry(c, census).index(i).key("characters")?;
        g.group.single &= times == 1;
        let count = (g.group.len() as u64).saturating_mul(times);
        census.add(count - g.group.len() as u64, 1).index(i).key("characters")?;
        if let Some(name) = &g.group.name {
            let kind = g.group.templates[0].desc.kind;
            let bearers = Bearers::new(count, vec![kind]).of("character");
            names.add(name, bearers).index(i).key("characters")?;
            character_names.0.insert(name.clone(), count);
        }
        out.push(g);
    }
    Ok(())
}

fn entry(c: &CharacterSpec, census: &mut Census) -> Checked<CharacterGroup> {
    let mut d = CharacterDesc::at(c.position.unwrap_or([0.0; 3]));
    if let Some(k) = &c.dynamic {
        let CharacterKind::Dynamic { leg_hertz, leg_damping_ratio, force } = CharacterKind::DYNAMIC else {
            return Err(Wrong::new("there is no such character", "a walker"));
        };
        d.kind = CharacterKind::Dynamic {
            leg_hertz: k.leg_hertz.unwrap_or(leg_hertz),
            leg_damping_ratio: k.leg_damping_ratio.unwrap_or(leg_damping_ratio),
            force: k.force.unwrap_or(force),
        };
        d.check().map_err(Wrong::from).key("dynamic")?;
    }
    d.heading = heading(c.heading_deg)?.unwrap_or(0.0);
    d.mover = mover(c)?;
    d.mass = c.mass.unwrap_or(d.mass);
    d.push_force = c.push_force.unwrap_or(d.push_force);
    // A small character crouches less deep, unless it is said how.
    let low = 2.0 * d.mover.radius;
    let crouch = if d.crouch_height > d.mover.height { d.mover.height } else { d.crouch_height };
    d.crouch_height = c.crouch_height.unwrap_or(if crouch < low { low } else { crouch });
    d.acceleration = c.acceleration.unwrap_or(d.acceleration);
    d.air_acceleration = c.air_acceleration.unwrap_or(d.air_acceleration);
    d.gravity_scale = c.gravity_scale.unwrap_or(d.gravity_scale);
    d.fall_speed_max = c.fall_speed_max.unwrap_or(d.fall_speed_max);
    d.turns_with_ground = c.turns_with_ground.unwrap_or(d.turns_with_ground);
    let f = Filter::default();
    d.filter = Filter {
        layers: c.layer.map_or(f.layers, |l| l.0),
        mask: c.mask.map_or(f.mask, |m| m.0),
        group: c.group.unwrap_or(f.group),
    };
    d.check()?;
    let input = CharacterInput {
        walk: velocity(c.velocity)?.unwrap_or(Vec3::ZERO),
        crouch: c.crouch.unwrap_or(false),
        ..CharacterInput::default()
    };
    let places = match &c.repeat {
        None => census.add(1, 1).map(|()| vec![Place::HERE])?,
        Some(r) => upright(r).and_then(|()| grid(r, 1, census)).key("repeat")?,
    };
    let walker = d.kind == CharacterKind::Walker;
    let mut body = BodyDesc::new(if walker { BodyKind::Kinematic } else { BodyKind::Dynamic });
    body.name = c.name.clone();
    let color = c.color.as_deref().map(color).transpose().key("color")?;
    let group = Group {
        name: c.name.clone(),
        templates: vec![Template { desc: body, color }],
        places,
        single: c.repeat.is_none(),
    };
    Ok(CharacterGroup { group, desc: d, input })
}

/// Copies of characters stand upright.
fn upright(r: &RepeatSpec) -> Checked<()> {
    if r.turn_deg.is_some() {
        return Err(Wrong::new("is given for characters", "copies that are not turned").key("turn_deg"));
    }
    if r.jitter.is_some_and(|j| j.rotation_deg.is_some()) {
        let expected = "copies that are not turned";
        return Err(Wrong::new("is given for characters", expected).key("rotation_deg").key("jitter"));
    }
    Ok(())
}

fn mover(c: &CharacterSpec) -> Checked<CharacterMover> {
    let mut m = CharacterMover::default();
    m.radius = c.radius.unwrap_or(m.radius);
    m.height = c.height.unwrap_or(m.height);
    m.up = c.up.map_or(m.up, Vec3::from_array);
    if let Some(a) = c.slope_max_deg {
        if !(0.0..=90.0).contains(&a) {
            return Err(Wrong::new(format!("is {a}"), "0 to 90 degrees").key("slope_max_deg"));
        }
        m.slope_max = if a < 90.0 { a.to_radians() } else { core::f32::consts::FRAC_PI_2 };
    }
    m.step_height = c.step_height.unwrap_or(m.step_height);
    m.snap = c.snap.unwrap_or(m.snap);
    m.skin = c.skin.unwrap_or(m.skin);
    m.one_way_layers = c.one_way_layers.map_or(m.one_way_layers, |l| l.0);
    m.check()?;
    Ok(m)
}

fn heading(deg: Option<f32>) -> Checked<Option<f32>> {
    match deg {
        Some(a) if a.abs() > 5e5 => {
            Err(Wrong::new(format!("is {a}"), "within ±500000 degrees").key("heading_deg"))
        }
        a => Ok(a.map(f32::to_radians)),
    }
}

fn velocity(v: Option<[f32; 3]>) -> Checked<Option<Vec3>> {
    match v.map(Vec3::from_array) {
        Some(x) if x.length() > SPEED_MAX => {
            let message = format!("is {:?}", x.to_array());
            Err(Wrong::new(message, "at most 1e5 m/s").key("velocity"))
        }
        x => Ok(x),
    }
}

/// What a character is to do, where it is said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wish {
    walk: Option<Vec3>,
    jump: Option<f32>,
    crouch: Option<bool>,
    drop_through: bool,
    heading: Option<f32>,
}

impl Wish {
    /// What goes on, with what is new.
    pub(crate) fn put(&self, now: &CharacterInput) -> CharacterInput {
        CharacterInput {
            walk: self.walk.unwrap_or(now.walk),
            jump: self.jump,
            crouch: self.crouch.unwrap_or(now.crouch),
            drop_through: self.drop_through,
            heading: self.heading,
        }
    }
}

/// The action `walk`.
pub(crate) fn walk(s: &WalkSpec, names: &CharacterNames) -> Checked<(Target, Wish)> {
    let target = names.resolve(&s.character).key("character")?;
    if let Some(j) = s.jump.filter(|j| !(0.0..=SPEED_MAX).contains(j)) {
        return Err(Wrong::new(format!("is {j}"), "0 to 1e5 m/s").key("jump"));
    }
    let wish = Wish {
        walk: velocity(s.velocity)?,
        jump: s.jump,
        crouch: s.crouch,
        drop_through: s.drop_through.unwrap_or(false),
        heading: heading(s.heading_deg)?,
    };
    if wish == (Wish { walk: None, jump: None, crouch: None, drop_through: false, heading: None }) {
        let expected = "velocity, jump, crouch, drop_through or heading_deg";
        return Err(Wrong::new("nothing is done", expected));
    }
    Ok((target, wish))
}
