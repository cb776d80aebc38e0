//! Vehicles of a scene file: presets and what is changed of them, the names that probes and actions know them by, and drivers.

mod driver;
mod parts;

use crate::bodies::{Census, Group, Names, Place, Target, Template, color, given_twice, grid, resolve_name};
use crate::error::{Checked, Under, Wrong};
use crate::shapes::rotation;
use crate::spec::{DriveSpec, VehicleInputSpec, VehiclePresetSpec, VehicleSpec};
pub(crate) use driver::{Driver, Route};
use jounce::limits::{GEARS_MAX, UNSPRUNG_PART_MAX};
use jounce::math::scalar::f32s;
use jounce::math::{DVec3, Vec3};
use jounce::vehicles::{VehicleKit, car, carry, motorcycle, off_road, snowboard, sports_car, tank};
use jounce::{BodyDesc, BodyId, BodyKind, VehicleDesc, VehicleId, VehicleInput};
use std::collections::BTreeMap;

/// One entry: a vehicle, or copies of a preset.
#[derive(Clone, Debug)]
pub(crate) struct VehicleGroup {
    pub name: Option<String>,
    /// A single vehicle is `name`; copies are `name[n]`.
    pub single: bool,
    /// With a chassis of no world.
    pub desc: VehicleDesc,
    pub chassis: Chassis,
    pub input: VehicleInput,
    pub route: Option<Route>,
}

/// What a vehicle's body is.
#[derive(Clone, Debug)]
pub(crate) enum Chassis {
    /// Bodies of its own.
    Own(Group),
    /// A body of the scene.
    Of(Target),
}

impl VehicleGroup {
    pub(crate) fn len(&self) -> usize {
        match &self.chassis {
            Chassis::Own(g) => g.len(),
            Chassis::Of(_) => 1,
        }
    }
    /// Bodies that come with it.
    pub(crate) fn own_bodies(&self) -> usize {
        match &self.chassis {
            Chassis::Own(g) => g.len(),
            Chassis::Of(_) => 0,
        }
    }
    /// Vehicle `n` on its body.
    pub(crate) fn vehicle(&self, n: usize, chassis: BodyId) -> VehicleDesc {
        let name =
            self.name.as_ref().map(|name| if self.single { name.clone() } else { format!("{name}[{n}]") });
        VehicleDesc { chassis, name, ..self.desc.clone() }
    }
}

/// Names of vehicles and how many bear each.
#[derive(Clone, Debug, Default)]
pub(crate) struct VehicleNames(BTreeMap<String, u64>);

impl VehicleNames {
    /// The vehicles that a text names: `name` (all of them) or `name[n]`.
    pub(crate) fn resolve(&self, text: &str) -> Checked<Target> {
        resolve_name("vehicle", text, self.0.keys().map(String::as_str), |name| self.0.get(name).copied())
    }
}

/// The vehicles of a scene, by name.
#[derive(Clone, Debug, Default)]
pub(crate) struct VehicleRecords {
    names: BTreeMap<String, Vec<VehicleId>>,
}

impl VehicleRecords {
    pub(crate) fn add(&mut self, name: Option<&String>, id: VehicleId) {
        if let Some(name) = name {
            self.names.entry(name.clone()).or_default().push(id);
        }
    }
    /// The vehicles of a target; some may be removed by now.
    pub(crate) fn of(&self, target: &Target) -> &[VehicleId] {
        let all = self.names.get(&target.name).map_or(&[][..], Vec::as_slice);
        match target.index {
            None => all,
            Some(i) => all.get(i..=i).unwrap_or(&[]),
        }
    }
    /// The vehicles of `name`, or the one of `name[n]`.
    pub(crate) fn by_text(&self, text: &str) -> &[VehicleId] {
        let all = |name: &str| self.names.get(name).map_or(&[][..], Vec::as_slice);
        match text.strip_suffix(']').and_then(|t| t.split_once('[')) {
            Some((name, n)) => n.parse().ok().and_then(|n: usize| all(name).get(n..=n)).unwrap_or(&[]),
            None => all(text),
        }
    }
}

/// Entries of `vehicles`, each made so many times. Their own chassis get their names among the bodies; which bodies the others are on
/// is looked up when characters and ragdolls have their names too ([`find_bodies`]).
pub(crate) fn vehicles(
    all: &[VehicleSpec],
    times: u64,
    census: &mut Census,
    names: &mut Names,
    (out, vehicle_names): &mut (Vec<VehicleGroup>, VehicleNames),
) -> Checked<()> {
    for (i, v) in all.iter().enumerate() {
        let mut g = entry(v, census).index(i).key("vehicles")?;
        g.single &= times == 1;
        if let Chassis::Own(own) = &mut g.chassis {
            own.single &= times == 1;
            let (n, shapes) = (own.len() as u64, own.templates[0].desc.shapes.len() as u64);
            census.add((times - 1).saturating_mul(n), shapes).index(i).key("vehicles")?;
        }
        if let Some(name) = &g.name {
            if let Chassis::Own(own) = &g.chassis {
                let named = own
                    .names(times)
                    .and_then(|n| n.into_iter().try_for_each(|(n, b)| names.add(&n, b.of("vehicle"))));
                named.index(i).key("vehicles")?;
            } else {
                crate::bodies::check_name(name).index(i).key("vehicles")?;
            }
            if vehicle_names.0.insert(name.clone(), g.len() as u64 * times).is_some() {
                return Err(given_twice(name, "vehicle", "vehicle").index(i).key("vehicles"));
            }
        }
        out.push(g);
    }
    Ok(())
}

/// Looks up the bodies that the entries of a list name, the first of which is vehicle `from`.
pub(crate) fn find_bodies(
    all: &[VehicleSpec],
    times: u64,
    names: &Names,
    out: &mut [VehicleGroup],
    from: usize,
) -> Checked<()> {
    for (i, v) in all.iter().enumerate() {
        let Some(name) = &v.body else { continue };
        let target = names.resolve_only(name, &[BodyKind::Dynamic], "a dynamic body");
        let target = target.and_then(only).key("body").index(i).key("vehicles")?;
        only_one(&target, times, out).key("body").index(i).key("vehicles")?;
        if let Some(g) = out.get_mut(from + i) {
            g.chassis = Chassis::Of(target);
        }
    }
    Ok(())
}

/// A body of several.
fn only(target: Target) -> Checked<Target> {
    if target.count == 1 {
        return Ok(target);
    }
    let message = format!("names {} bodies", target.count);
    Err(Wrong::new(message, format!("one, such as {}", target.one)))
}

/// A body carries one vehicle. Of the others, those are known that bring their own and those whose were looked up.
fn only_one(body: &Target, times: u64, others: &[VehicleGroup]) -> Checked<()> {
    let same = |o: &VehicleGroup| match &o.chassis {
        Chassis::Own(g) => g.name.as_ref() == Some(&body.name),
        Chassis::Of(t) => t.name == body.name && t.index.unwrap_or(0) == body.index.unwrap_or(0),
    };
    if times == 1 && !others.iter().any(same) {
        return Ok(());
    }
    Err(Wrong::new(
        format!("\"{}\" is given to two vehicles", body.name),
        "a body that is of no other vehicle",
    ))
}

fn kit(p: VehiclePresetSpec) -> VehicleKit {
    match p {
        VehiclePresetSpec::Car => car(),
        VehiclePresetSpec::SportsCar => sports_car(),
        VehiclePresetSpec::OffRoad => off_road(),
        VehiclePresetSpec::Motorcycle => motorcycle(),
        VehiclePresetSpec::Tank => tank(),
        VehiclePresetSpec::Snowboard => snowboard(),
    }
}

fn entry(v: &VehicleSpec, census: &mut Census) -> Checked<VehicleGroup> {
    let mut kit = match (v.preset, &v.body) {
        (Some(p), _) => kit(p),
        (None, Some(_)) => {
            VehicleKit { body: BodyDesc::dynamic(), vehicle: VehicleDesc::new(BodyId::from_bits(u64::MAX)) }
        }
        (None, None) => {
            return Err(Wrong::new("the vehicle has no body", "`preset`, or the name of a `body`, or both"));
        }
    };
    let chassis = match &v.body {
        Some(_) => of_scene(v)?,
        None => Chassis::Own(own(v, &mut kit, census)?),
    };
    one_or_the_other(v, &kit.vehicle)?;
    parts::change(v, &mut kit.vehicle)?;
    if let Chassis::Own(g) = &chassis {
        light_wheels(v, &kit.vehicle, g)?;
    }
    let input = v.input.as_ref().map_or(Ok(VehicleInput::default()), |i| input(VehicleInput::default(), i));
    let input = input.key("input")?;
    let route = v.route.as_ref().map(|r| Route::new(r, &kit.vehicle)).transpose().key("route")?;
    Ok(VehicleGroup {
        name: v.name.clone(),
        single: v.repeat.is_none(),
        desc: kit.vehicle,
        chassis,
        input,
        route,
    })
}

/// A vehicle has wheels or a board.
fn one_or_the_other(v: &VehicleSpec, preset: &VehicleDesc) -> Checked<()> {
    if v.board.is_some() && !(v.wheels.is_empty() && preset.wheels.is_empty()) {
        let expected = "wheels or a board, not both";
        return Err(Wrong::new("the vehicle has wheels and a board", expected).key("board"));
    }
    let given = [("wheels", !v.wheels.is_empty()), ("wheel", v.wheel.is_some())];
    match given.iter().find(|(_, given)| *given) {
        Some((key, _)) if v.board.is_some() || preset.board.is_some() => {
            let message = "is given for a vehicle on a board, which has no wheels";
            Err(Wrong::new(message, "`board` with what is changed of it").key(key))
        }
        _ => Ok(()),
    }
}

/// Wheels are a part of the whole.
fn light_wheels(v: &VehicleSpec, d: &VehicleDesc, own: &Group) -> Checked<()> {
    let Some(mass) = own.templates[0].desc.mass.map(|m| m.mass) else { return Ok(()) };
    let wheels: f32 = d.wheels.iter().map(|w| w.mass).sum();
    if wheels <= UNSPRUNG_PART_MAX * mass {
        return Ok(());
    }
    let key = if v.wheel.as_ref().is_some_and(|w| w.mass.is_some()) { "wheel" } else { "wheels" };
    let message = format!("have {wheels} kg of the chassis' {mass} kg, of which they are a part");
    Err(Wrong::new(message, format!("at most {UNSPRUNG_PART_MAX} of it")).key(key))
}

/// A body of the scene as chassis, not yet looked up.
fn of_scene(v: &VehicleSpec) -> Checked<Chassis> {
    let others = [
        ("position", v.position.is_some()),
        ("rotation_deg", v.rotation_deg.is_some()),
        ("rotation", v.rotation.is_some()),
        ("velocity", v.velocity.is_some()),
        ("angular_velocity", v.angular_velocity.is_some()),
        ("mass_properties", v.mass_properties.is_some()),
        ("color", v.color.is_some()),
        ("repeat", v.repeat.is_some()),
    ];
    if let Some((key, _)) = others.iter().find(|(_, given)| *given) {
        return Err(Wrong::new("is given beside `body`", format!("{key} of the body itself")).key(key));
    }
    Ok(Chassis::Of(Target::default()))
}

/// A preset's own bodies.
fn own(v: &VehicleSpec, kit: &mut VehicleKit, census: &mut Census) -> Checked<Group> {
    let d = &mut kit.body;
    d.name = v.name.clone();
    d.position = DVec3::from_array(v.position.unwrap_or([0.0; 3]));
    d.rotation = rotation(v.rotation_deg, v.rotation)?;
    d.velocity = Vec3::from_array(v.velocity.unwrap_or([0.0; 3]));
    d.angular_velocity = Vec3::from_array(v.angular_velocity.unwrap_or([0.0; 3]));
    if let Some(m) = &v.mass_properties {
        let mass = crate::bodies::mass_properties(m).key("mass_properties")?;
        d.mass = Some(mass);
        carry(&mut kit.vehicle.wheels, mass.mass, mass.center.z);
        if let Some(i) = kit.vehicle.wheels.iter().position(|w| w.preload < 0.0) {
            let message = format!("wheel {i} would have to pull the chassis down");
            let expected = "a centre of mass between the axles";
            return Err(Wrong::new(message, expected).key("center").key("mass_properties"));
        }
        let most = 1e9;
        if let Some(w) = kit.vehicle.wheels.iter().find(|w| w.preload > most) {
            let message = format!("is {}: a wheel would carry {:e} N", mass.mass, w.preload);
            let expected = format!("at most {most:e} N on a wheel");
            return Err(Wrong::new(message, expected).key("mass").key("mass_properties"));
        }
    }
    d.check()?;
    let shapes = d.shapes.len() as u64;
    let places = match &v.repeat {
        None => census.add(1, shapes).map(|()| vec![Place::HERE])?,
        Some(r) => grid(r, shapes, census).key("repeat")?,
    };
    let color = v.color.as_deref().map(color).transpose().key("color")?;
    let templates = vec![Template { desc: d.clone(), color }];
    Ok(Group { name: v.name.clone(), templates, places, single: v.repeat.is_none() })
}

/// An input with what is given.
pub(crate) fn input(mut now: VehicleInput, s: &VehicleInputSpec) -> Checked<VehicleInput> {
    let range = |v: Option<f32>, lo: f32, key: &str, to: &mut f32| {
        let Some(v) = v else { return Ok(()) };
        if !(lo..=1.0).contains(&v) {
            return Err(Wrong::new(format!("is {v}"), format!("{lo} to 1")).key(key));
        }
        *to = v;
        Ok(())
    };
    range(s.throttle, 0.0, "throttle", &mut now.throttle)?;
    range(s.brake, 0.0, "brake", &mut now.brake)?;
    range(s.handbrake, 0.0, "handbrake", &mut now.handbrake)?;
    range(s.steer, -1.0, "steer", &mut now.steer)?;
    range(s.clutch, 0.0, "clutch", &mut now.clutch)?;
    range(s.lean, -1.0, "lean", &mut now.lean)?;
    range(s.jump, 0.0, "jump", &mut now.jump)?;
    if let Some(g) = s.gear {
        if !(-1..=GEARS_MAX as i32).contains(&g) {
            return Err(Wrong::new(format!("is {g}"), "-1 (reverse) to 32").key("gear"));
        }
        now.gear = g;
    }
    Ok(now)
}

/// The action `drive`: whom, with what, and how long it takes to get there, s.
pub(crate) fn drive(s: &DriveSpec, names: &VehicleNames) -> Checked<(Target, VehicleInputSpec, f64)> {
    let target = names.resolve(&s.vehicle).key("vehicle")?;
    let given = VehicleInputSpec {
        throttle: s.throttle,
        brake: s.brake,
        handbrake: s.handbrake,
        steer: s.steer,
        clutch: s.clutch,
        gear: s.gear,
        lean: s.lean,
        jump: s.jump,
    };
    input(VehicleInput::default(), &given)?;
    let all = [s.throttle, s.brake, s.handbrake, s.steer, s.clutch, s.lean, s.jump];
    if s.gear.is_none() && all.iter().all(Option::is_none) {
        let expected = "throttle, brake, handbrake, steer, clutch, gear, lean or jump";
        return Err(Wrong::new("nothing is done", expected));
    }
    let duration = crate::plan::time(s.duration.unwrap_or(0.0)).key("duration")?;
    Ok((target, given, duration))
}

/// An input a part of the way, 0 to 1: what can be half pressed goes in a line, gears and jumps come at once.
pub(crate) fn toward(from: &VehicleInput, to: &VehicleInput, part: f64) -> VehicleInput {
    let t = part as f32;
    let mix = |a: f32, b: f32, lo: f32| if t >= 1.0 { b } else { f32s::clamp(a + (b - a) * t, lo, 1.0) };
    VehicleInput {
        throttle: mix(from.throttle, to.throttle, 0.0),
        brake: mix(from.brake, to.brake, 0.0),
        handbrake: mix(from.handbrake, to.handbrake, 0.0),
        steer: mix(from.steer, to.steer, -1.0),
        clutch: mix(from.clutch, to.clutch, 0.0),
        lean: mix(from.lean, to.lean, -1.0),
        gear: to.gear,
        jump: to.jump,
    }
}
