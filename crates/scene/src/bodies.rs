//! Bodies of a scene file: templates, and where their copies go.

use crate::error::{Checked, Under, Wrong};
use crate::limits;
use crate::random::Stream;
use crate::shapes::{Library, euler, rotation};
use crate::spec::{
    BodySpec, BodyTypeSpec, MassPropertiesSpec, PyramidSpec, RepeatSpec, ScatterRotationSpec, ScatterSpec,
};
use jounce::geometry::{MassProperties, limits::SIZE_MAX};
use jounce::math::{DVec3, Mat3, Quat, Vec3};
use jounce::{AxisLocks, BodyDesc, BodyKind, MassSpec, ShapeDesc};
use std::collections::{BTreeMap, HashMap};

/// A body to be copied.
#[derive(Clone, Debug)]
pub(crate) struct Template {
    pub desc: BodyDesc,
    pub color: Option<[f32; 3]>,
}

/// Where a copy goes, relative to its template.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub position: DVec3,
    pub rotation: Quat,
    pub velocity: Vec3,
    pub angular_velocity: Vec3,
}

impl Place {
    pub(crate) const HERE: Self = Self {
        position: DVec3::ZERO,
        rotation: Quat::IDENTITY,
        velocity: Vec3::ZERO,
        angular_velocity: Vec3::ZERO,
    };
}

/// Bodies that share a name: a single one, a grid of copies, or a scattered lot.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub name: Option<String>,
    pub templates: Vec<Template>,
    pub places: Vec<Place>,
    /// A single body is `name`; copies are `name[n]`.
    pub single: bool,
}

impl Group {
    /// Number of bodies.
    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }

    /// Which template copy `n` follows.
    pub(crate) fn template(&self, n: usize) -> &Template {
        &self.templates[n % self.templates.len()]
    }

    /// What a body of a name is, where the name is the group's or that of a template.
    pub(crate) fn desc_of(&self, t: &Target) -> Option<&BodyDesc> {
        if self.name.as_ref() == Some(&t.name) {
            return Some(&self.template(t.index.unwrap_or(0)).desc);
        }
        self.templates.iter().map(|x| &x.desc).find(|d| d.name.as_ref() == Some(&t.name))
    }

    /// The names that the group gives, and who bears each; `times` is how often it is made.
    pub(crate) fn names(&self, times: u64) -> Checked<Vec<(String, Bearers)>> {
        let mut names = Vec::new();
        let all = (self.len() as u64).saturating_mul(times);
        let kinds = || self.templates.iter().map(|t| t.desc.kind).collect();
        names.extend(self.name.iter().map(|n| (n.clone(), Bearers::new(all, kinds()))));
        if self.templates.len() > 1 || !self.single {
            let each = self.templates.len() as u64;
            for (t, template) in self.templates.iter().enumerate() {
                let own = template.desc.name.iter().filter(|n| Some(*n) != self.name.as_ref());
                let count = (all + each - 1 - t as u64) / each;
                names.extend(own.map(|n| (n.clone(), Bearers::new(count, vec![template.desc.kind]))));
            }
        }
        Ok(names)
    }

    /// Copy `n`, ready for the world; `made` copies were made before (by a repeated timed spawn).
    pub(crate) fn body(&self, n: usize, made: usize) -> BodyDesc {
        let (place, mut d) = (&self.places[n], self.template(n).desc.clone());
        d.position += place.position;
        d.rotation = (place.rotation * d.rotation).normalize();
        d.velocity += place.velocity;
        d.angular_velocity += place.angular_velocity;
        let copy = made + n;
        d.name = match (&self.name, d.name) {
            (Some(name), _) if self.single => Some(name.clone()),
            (Some(name), _) => Some(format!("{name}[{copy}]")),
            (None, Some(own)) => Some(format!("{own}[{}]", copy / self.templates.len())),
            (None, None) => None,
        };
        d
    }
}

/// Counts bodies and shapes of a scene against the limits, before anything is reserved.
#[derive(Default)]
pub(crate) struct Census {
    bodies: u64,
    shapes: u64,
    scattered: u64,
    joints: u64,
}

impl Census {
    pub(crate) fn add(&mut self, bodies: u64, shapes_each: u64) -> Checked<()> {
        self.bodies = self.bodies.saturating_add(bodies);
        self.shapes = self.shapes.saturating_add(bodies.saturating_mul(shapes_each));
        if self.bodies > limits::SCENE_BODIES_MAX {
            let limit = format!("at most {} bodies in a scene", limits::SCENE_BODIES_MAX);
            return Err(Wrong::new(format!("makes {} bodies", self.bodies), limit));
        }
        if self.shapes > limits::SCENE_SHAPES_MAX {
            let limit = format!("at most {} shapes in a scene", limits::SCENE_SHAPES_MAX);
            return Err(Wrong::new(format!("makes {} shapes", self.shapes), limit));
        }
        Ok(())
    }

    /// Joints, copies included.
    pub(crate) fn joints(&mut self, joints: u64) -> Checked<()> {
        self.joints = self.joints.saturating_add(joints);
        if self.joints > limits::SCENE_JOINTS_MAX {
            let limit = format!("at most {} joints in a scene", limits::SCENE_JOINTS_MAX);
            return Err(Wrong::new(format!("makes {} joints", self.joints), limit));
        }
        Ok(())
    }

    /// Bodies of a scatter group: their places are drawn, and kept, while the scene is read.
    fn scatter(&mut self, bodies: u64) -> Checked<()> {
        self.scattered = self.scattered.saturating_add(bodies);
        if self.scattered > limits::SCATTER_BODIES_MAX {
            let limit = format!("at most {} scattered bodies in a scene", limits::SCATTER_BODIES_MAX);
            return Err(Wrong::new(format!("makes {} scattered bodies", self.scattered), limit));
        }
        Ok(())
    }
}

/// The bodies that bear a name: how many, and of which kinds in turn.
#[derive(Clone, Debug)]
pub(crate) struct Bearers {
    count: u64,
    kinds: Vec<BodyKind>,
    /// What they are: "body", "vehicle", ….
    what: &'static str,
    /// How one of several is called, where that is not `name[0]`.
    one: Option<String>,
}

impl Bearers {
    pub(crate) fn new(count: u64, kinds: Vec<BodyKind>) -> Self {
        Self { count, kinds, what: "body", one: None }
    }
    /// What they are.
    pub(crate) fn of(mut self, what: &'static str) -> Self {
        self.what = what;
        self
    }
    /// How one of them is called.
    pub(crate) fn one(mut self, one: String) -> Self {
        self.one = Some(one);
        self
    }
}

/// A name that two things want.
pub(crate) fn given_twice(name: &str, first: &str, second: &str) -> Wrong {
    let whom = match second {
        _ if first != second => format!("a {first} and to a {second}"),
        "body" => "two bodies".into(),
        _ => format!("two {second}s"),
    };
    Wrong::new(format!("\"{name}\" is given to {whom}"), "a name of its own").key("name")
}

/// Names of bodies and who bears each.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names(BTreeMap<String, Bearers>);

impl Names {
    pub(crate) fn add(&mut self, name: &str, bearers: Bearers) -> Checked<()> {
        check_name(name)?;
        let what = bearers.what;
        match self.0.insert(name.into(), bearers) {
            Some(other) => Err(given_twice(name, other.what, what)),
            None => Ok(()),
        }
    }

    /// The bodies that a text names: `name` (all of them) or `name[n]`.
    pub(crate) fn resolve(&self, text: &str) -> Checked<Target> {
        let known = self.0.keys().map(String::as_str);
        let mut target = resolve_name("body", text, known, |name| self.0.get(name).map(|b| b.count))?;
        if let Some(one) = self.0.get(&target.name).and_then(|b| b.one.as_ref()) {
            target.one.clone_from(one);
        }
        Ok(target)
    }

    /// "fixed" or "kinematic" where no body that a text names is moved by joints.
    pub(crate) fn unmoved(&self, text: &str) -> Option<&'static str> {
        let only = |kinds: &[BodyKind]| self.resolve_only(text, kinds, "").is_ok();
        match () {
            () if only(&[BodyKind::Fixed]) => Some("fixed"),
            () if only(&[BodyKind::Kinematic]) => Some("kinematic"),
            () if only(&[BodyKind::Fixed, BodyKind::Kinematic]) => Some("fixed or kinematic"),
            () => None,
        }
    }

    /// The bodies that a text names, all of which must be of these kinds; `expected` says so.
    pub(crate) fn resolve_only(&self, text: &str, kinds: &[BodyKind], expected: &str) -> Checked<Target> {
        let target = self.resolve(text)?;
        let all = self.0.get(&target.name).map_or(&[][..], |b| &b.kinds);
        let those = match target.index {
            None => &all[..all.len().min(target.count as usize)],
            Some(n) => core::slice::from_ref(&all[n % all.len()]),
        };
        let Some(wrong) = those.iter().find(|k| !kinds.contains(k)) else { return Ok(target) };
        let kind = match wrong {
            BodyKind::Fixed => "fixed",
            BodyKind::Kinematic => "kinematic",
            BodyKind::Dynamic => "dynamic",
        };
        Err(Wrong::new(format!("\"{text}\" names a {kind} body"), expected))
    }
}

/// Refuses what cannot be told from `name[n]`, or is too long with a number.
pub(crate) fn check_name(name: &str) -> Checked<()> {
    if name.is_empty() || name.contains(['[', ']']) || name.len() > jounce::limits::NAME_MAX - 12 {
        let expected = "1 to 244 bytes without square brackets";
        return Err(Wrong::new(format!("is {name:?}"), expected).key("name"));
    }
    Ok(())
}

/// The things that a text names: `name` (all of them) or `name[n]`.
pub(crate) fn resolve_name<'a>(
    what: &str,
    text: &str,
    known: impl Iterator<Item = &'a str> + Clone,
    count_of: impl Fn(&str) -> Option<u64>,
) -> Checked<Target> {
    let (name, index) = match text.strip_suffix(']').and_then(|t| t.split_once('[')) {
        Some((name, n)) => match n.parse::<usize>() {
            Ok(n) => (name, Some(n)),
            Err(_) => return Err(Wrong::new(format!("is \"{text}\""), "name or name[number]")),
        },
        None => (text, None),
    };
    let Some(all) = count_of(name) else { return Err(crate::shapes::unknown(what, name, known)) };
    if all == 0 {
        return Err(Wrong::new(
            format!("no {what} is made from \"{name}\""),
            format!("a {what} that is there"),
        ));
    }
    match index {
        Some(n) if n as u64 >= all => {
            Err(Wrong::new(format!("\"{text}\" is not there"), format!("{name}[0] to {name}[{}]", all - 1)))
        }
        _ => {
            let (count, one) = (if index.is_some() { 1 } else { all }, format!("{name}[0]"));
            Ok(Target { name: name.into(), index, count, all, one })
        }
    }
}

/// Bodies or joints by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Target {
    pub name: String,
    pub index: Option<usize>,
    /// How many are meant, of all that the scene makes.
    pub count: u64,
    /// How many bear the name.
    pub all: u64,
    /// How one of them is called.
    pub one: String,
}

/// One entry of `bodies`: a body, or a grid of them.
pub(crate) fn group(b: &BodySpec, library: &mut Library, census: &mut Census) -> Checked<Group> {
    let shapes = b.shapes.len() as u64;
    let places = match &b.repeat {
        None => census.add(1, shapes).map(|()| vec![Place::HERE])?,
        Some(r) => grid(r, shapes, census).key("repeat")?,
    };
    let templates = vec![template(b, library)?];
    Ok(Group { name: b.name.clone(), templates, places, single: b.repeat.is_none() })
}

fn template(b: &BodySpec, library: &mut Library) -> Checked<Template> {
    let mut d = BodyDesc::new(match b.kind {
        BodyTypeSpec::Fixed => BodyKind::Fixed,
        BodyTypeSpec::Kinematic => BodyKind::Kinematic,
        BodyTypeSpec::Dynamic => BodyKind::Dynamic,
    });
    d.name = b.name.clone();
    d.position = DVec3::from_array(b.position.unwrap_or([0.0; 3]));
    d.rotation = rotation(b.rotation_deg, b.rotation)?;
    d.velocity = Vec3::from_array(b.velocity.unwrap_or([0.0; 3]));
    d.angular_velocity = Vec3::from_array(b.angular_velocity.unwrap_or([0.0; 3]));
    d.linear_damping = b.linear_damping.unwrap_or(d.linear_damping);
    d.angular_damping = b.angular_damping.unwrap_or(d.angular_damping);
    d.gravity_scale = b.gravity_scale.unwrap_or(d.gravity_scale);
    if let Some(l) = &b.locks {
        d.locks = AxisLocks { linear: l.linear, angular: l.angular };
    }
    d.bullet = b.bullet.unwrap_or(d.bullet);
    d.fast_rotation = b.fast_rotation.unwrap_or(d.fast_rotation);
    d.can_sleep = b.can_sleep.unwrap_or(d.can_sleep);
    d.sleep_speed = b.sleep_speed;
    d.asleep = b.asleep.unwrap_or(d.asleep);
    d.enabled = b.enabled.unwrap_or(d.enabled);
    d.check()?;
    d.shapes.reserve_exact(b.shapes.len());
    for (i, s) in b.shapes.iter().enumerate() {
        let built = library.shape(s).and_then(|shape| {
            let alone = BodyDesc::new(d.kind).shape(shape.clone());
            alone.check()?;
            Ok(shape)
        });
        d.shapes.push(built.index(i).key("shapes")?);
    }
    match (&b.mass_properties, b.mass) {
        (Some(_), Some(_)) => {
            return Err(
                Wrong::new("given beside `mass_properties`", "mass or mass_properties, not both").key("mass")
            );
        }
        (Some(m), None) => d.mass = Some(mass_properties(m).key("mass_properties")?),
        (None, Some(m)) => scale_mass(&mut d, m).key("mass")?,
        (None, None) => {}
    }
    if d.kind == BodyKind::Dynamic && d.mass.is_none() {
        if d.shapes.is_empty() {
            return Err(Wrong::new(
                "the dynamic body has no shapes",
                "at least one shape, or mass_properties",
            ));
        }
        if masses(&d.shapes).iter().all(|m| *m <= 0.0) {
            return Err(Wrong::new(
                "the dynamic body has no mass",
                "a shape that is no sensor, with density or mass above 0, or mass_properties",
            ));
        }
    }
    let color = b.color.as_deref().map(color).transpose().key("color")?;
    Ok(Template { desc: d, color })
}

/// What each shape weighs, kg.
pub(crate) fn masses(shapes: &[ShapeDesc]) -> Vec<f32> {
    let mass = |s: &ShapeDesc| match s.mass {
        _ if s.sensor => 0.0,
        MassSpec::Mass(m) => m,
        MassSpec::Density(x) => s.shape.mass_properties(x).map_or(0.0, |p| p.mass),
    };
    shapes.iter().map(mass).collect()
}

/// Scales the shapes' masses to a sum.
fn scale_mass(d: &mut BodyDesc, total: f32) -> Checked<()> {
    if !(jounce::limits::MASS_MIN..=jounce::limits::MASS_MAX).contains(&total) {
        return Err(Wrong::new(format!("is {total}"), "a positive mass, 1e-12 to 1e15 kg"));
    }
    let own = masses(&d.shapes);
    let sum: f32 = own.iter().sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return Err(Wrong::new(
            "no shape has mass to scale",
            "a shape with volume and density, or mass_properties",
        ));
    }
    let factor = total / sum;
    d.shapes
        .iter_mut()
        .zip(own)
        .filter(|(s, _)| !s.sensor)
        .for_each(|(s, m)| s.mass = MassSpec::Mass(m * factor));
    Ok(())
}

pub(crate) fn mass_properties(m: &MassPropertiesSpec) -> Checked<MassProperties> {
    let (xx, yy, zz, xy, xz, yz) = match m.inertia[..] {
        [xx, yy, zz] => (xx, yy, zz, 0.0, 0.0, 0.0),
        [xx, yy, zz, xy, xz, yz] => (xx, yy, zz, xy, xz, yz),
        _ => {
            let message = format!("has {} numbers", m.inertia.len());
            return Err(Wrong::new(message, "[xx, yy, zz] or [xx, yy, zz, xy, xz, yz]").key("inertia"));
        }
    };
    let inertia = Mat3::from_columns(Vec3::new(xx, xy, xz), Vec3::new(xy, yy, yz), Vec3::new(xz, yz, zz));
    let mass = MassProperties { mass: m.mass, center: Vec3::from_array(m.center), inertia };
    // The engine names the fields mass, mass.center and mass.inertia; here they are keys of one object.
    match BodyDesc::dynamic().mass(mass).check() {
        Err(jounce::Error::BadValue { field, value, expected, .. }) => {
            let key = field.rsplit('.').next().unwrap_or(field);
            let value = if key == "inertia" { format!("{:?}", m.inertia) } else { value };
            Err(Wrong::new(format!("is {value}"), expected).key(key))
        }
        other => other.map(|()| mass).map_err(Wrong::from),
    }
}

/// "#rrggbb" as red, green, blue in 0…1 (sRGB, not linear).
pub(crate) fn color(text: &str) -> Checked<[f32; 3]> {
    let wrong = || Wrong::new(format!("is \"{text}\""), "a colour such as \"#3a86ff\"");
    let hex = text.strip_prefix('#').filter(|h| h.len() == 6 && h.is_ascii()).ok_or_else(wrong)?;
    let mut rgb = [0.0; 3];
    for (k, c) in rgb.iter_mut().enumerate() {
        *c = f32::from(u8::from_str_radix(&hex[2 * k..2 * k + 2], 16).map_err(|_| wrong())?) / 255.0;
    }
    Ok(rgb)
}

pub(crate) fn grid(r: &RepeatSpec, shapes: u64, census: &mut Census) -> Checked<Vec<Place>> {
    let n = r.count.each();
    let all = n[0].checked_mul(n[1]).and_then(|m| m.checked_mul(n[2]));
    let limit = format!("at most {} bodies in a scene", limits::SCENE_BODIES_MAX);
    match all {
        Some(0) => return Err(Wrong::new(format!("is {n:?}"), "1 or more").key("count")),
        Some(m) if m <= limits::SCENE_BODIES_MAX => {}
        _ => return Err(Wrong::new(format!("is {n:?}"), limit).key("count")),
    }
    if r.step.iter().any(|s| s.abs() > f64::from(SIZE_MAX)) {
        return Err(Wrong::new(format!("is {:?}", r.step), "within ±1e6 m").key("step"));
    }
    let turn = r.turn_deg.unwrap_or([0.0; 3]);
    if turn.iter().any(|a| a.abs() > 360.0) {
        return Err(Wrong::new(format!("is {turn:?}"), "within ±360 degrees").key("turn_deg"));
    }
    let there = |c: [u64; 3]| match r.pyramid {
        None => true,
        Some(PyramidSpec::X) => c[0] + c[1] < n[0],
        Some(PyramidSpec::Xz) => c[0] + c[1] < n[0] && c[2] + c[1] < n[2],
    };
    // x fastest, then y, then z.
    let cells = || {
        (0..all.unwrap_or(0)).map(|m| [m % n[0], m / n[0] % n[1], m / (n[0] * n[1])]).filter(|c| there(*c))
    };
    census.add(cells().count() as u64, shapes).key("count")?;
    let (lean_x, lean_z) = match r.pyramid {
        None => (0.0, 0.0),
        Some(PyramidSpec::X) => (0.5, 0.0),
        Some(PyramidSpec::Xz) => (0.5, 0.5),
    };
    let places = cells().enumerate().map(|(m, c)| {
        let [i, j, k] = c.map(|x| x as f64);
        let cell = [i + lean_x * j, j, k + lean_z * j];
        let position = DVec3::from_array(r.count.shift(cell, r.step));
        let rotation = if turn == [0.0; 3] { Quat::IDENTITY } else { euler(turn.map(|a| a * m as f32)) };
        jittered(r, m as u64, Place { position, rotation, ..Place::HERE })
    });
    Ok(places.collect())
}

fn jittered(r: &RepeatSpec, copy: u64, mut place: Place) -> Place {
    if let Some(j) = &r.jitter {
        let mut s = Stream::new(j.seed, copy);
        place.position += s.around(j.position.unwrap_or([0.0; 3]));
        let angles = s.around_f32(j.rotation_deg.unwrap_or([0.0; 3])).to_array();
        if angles != [0.0; 3] {
            place.rotation = (euler(angles) * place.rotation).normalize();
        }
    }
    place
}

/// One entry of `scatter`.
pub(crate) fn scatter(s: &ScatterSpec, library: &mut Library, census: &mut Census) -> Checked<Group> {
    if s.bodies.is_empty() {
        return Err(Wrong::new("is empty", "at least one template").key("bodies"));
    }
    if s.count == 0 {
        return Err(Wrong::new("is 0", "1 or more").key("count"));
    }
    let shapes = s.bodies.iter().map(|b| b.shapes.len() as u64).max().unwrap_or(0);
    census.add(s.count, shapes).key("count")?;
    census.scatter(s.count).key("count")?;
    let (lo, hi) = (DVec3::from_array(s.region.min), DVec3::from_array(s.region.max));
    let ok = (hi - lo).min_component() >= 0.0
        && lo.abs().max_component() <= 1e9
        && hi.abs().max_component() <= 1e9;
    if !ok {
        let message = format!("runs from {:?} to {:?}", s.region.min, s.region.max);
        return Err(Wrong::new(message, "min not above max, within ±1e9 m").key("box"));
    }
    let mut templates = Vec::new();
    for (i, b) in s.bodies.iter().enumerate() {
        if b.repeat.is_some() {
            return Err(Wrong::new("is given in a scatter group", "`count` of the group instead")
                .key("repeat")
                .index(i)
                .key("bodies"));
        }
        templates.push(template(b, library).index(i).key("bodies")?);
    }
    let places = scattered(s, lo, hi)?;
    Ok(Group { name: s.name.clone(), templates, places, single: false })
}

fn scattered(s: &ScatterSpec, lo: DVec3, hi: DVec3) -> Checked<Vec<Place>> {
    let apart = s.min_distance.unwrap_or(0.0);
    if !(0.0..=1e6).contains(&apart) {
        return Err(Wrong::new(format!("is {apart}"), "0 to 1e6 m").key("min_distance"));
    }
    let mut taken = Neighbors { cell: apart, apart, cells: HashMap::new() };
    let mut places = Vec::with_capacity(s.count as usize);
    let mut draws = limits::SCATTER_TRIES_MAX + limits::SCATTER_TRIES_EACH * s.count;
    for n in 0..s.count {
        let mut random = Stream::new(s.seed, n);
        let mut position = None;
        for _ in 0..limits::SCATTER_TRIES_MAX.min(draws) {
            draws -= 1;
            let d = hi - lo;
            let p = lo + DVec3::new(d.x * random.unit(), d.y * random.unit(), d.z * random.unit());
            if apart == 0.0 || taken.put(p) {
                position = Some(p);
                break;
            }
        }
        let Some(position) = position else {
            let message = format!("the box has room for {n} of {} bodies", s.count);
            return Err(Wrong::new(message, "a larger box or a smaller min_distance").key("min_distance"));
        };
        let rotation = match s.rotation.unwrap_or(ScatterRotationSpec::Any) {
            ScatterRotationSpec::None => Quat::IDENTITY,
            ScatterRotationSpec::Yaw => random.yaw(),
            ScatterRotationSpec::Any => random.rotation(),
        };
        let velocity = random.around_f32(s.velocity.unwrap_or([0.0; 3]));
        let angular_velocity = random.around_f32(s.angular_velocity.unwrap_or([0.0; 3]));
        places.push(Place { position, rotation, velocity, angular_velocity });
    }
    Ok(places)
}

/// Points no closer than a distance, in cells of that size. The map is only looked up, never walked.
struct Neighbors {
    cell: f64,
    apart: f64,
    cells: HashMap<[i64; 3], Vec<DVec3>>,
}

impl Neighbors {
    fn put(&mut self, p: DVec3) -> bool {
        let key = |x: f64| (x / self.cell).floor() as i64;
        let at = [key(p.x), key(p.y), key(p.z)];
        for i in -1..=1 {
            for j in -1..=1 {
                for k in -1..=1 {
                    let near = self.cells.get(&[
                        at[0].saturating_add(i),
                        at[1].saturating_add(j),
                        at[2].saturating_add(k),
                    ]);
                    if near.is_some_and(|c| c.iter().any(|q| (p - *q).length() < self.apart)) {
                        return false;
                    }
                }
            }
        }
        self.cells.entry(at).or_default().push(p);
        true
    }
}
