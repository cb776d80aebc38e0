//! Probes, timed actions and expectations, checked against the bodies of the scene before anything runs.

use crate::bodies::{Census, Group, Names, Target, group};
use crate::characters::{CharacterGroup, CharacterNames, Wish, characters, walk};
use crate::emitters::{Emitters, find as find_emitter};
use crate::error::{Checked, Under, Wrong, closest};
use crate::fields::{Field, explosion, find as find_field};
use crate::joints::{
    JointGroup, JointNames, Measure, NewMotor, find_ends, group as joint_group, set_joint, set_motor,
};
use crate::limits;
use crate::movers::{CharacterValue, VehicleValue, of_characters, of_vehicles};
use crate::ragdolls::{
    Bones, Hold, Leading, Posing, RagdollGroup, RagdollNames, grab, held, lead, pose, ragdolls, relax,
    release,
};
use crate::shapes::{Library, rotation, unknown};
use crate::spec::{
    AggregateSpec, CharacterSpec, EventSpec, ExpectSpec, Map, PlaceSpec, ProbeSpec, PushSpec, RagdollSpec,
    TimelineSpec, VehicleInputSpec, VehicleSpec,
};
use crate::systems::System;
use crate::vehicles::{VehicleGroup, VehicleNames, drive, find_bodies, vehicles};
use jounce::limits::{FORCE_MAX, POSITION_MAX, SPEED_MAX, SPIN_MAX};
use jounce::math::{DVec3, Quat, Vec3};
use jounce::{BodyKind, Explosion, JointKind};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// What a scene holds beside bodies, for those who name it.
#[derive(Clone, Copy)]
pub(crate) struct Sources<'a> {
    pub fields: &'a [Field],
    pub emitters: &'a [Emitters],
    pub systems: &'a [System],
    pub vehicles: (&'a VehicleNames, &'a [VehicleGroup]),
    pub characters: &'a CharacterNames,
    pub ragdolls: (&'a RagdollNames, &'a [RagdollGroup]),
}

/// Which of a scene's vehicles, characters and ragdolls.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Movers {
    pub vehicles: Range<usize>,
    pub characters: Range<usize>,
    pub ragdolls: Range<usize>,
}

impl Movers {
    fn is_empty(&self) -> bool {
        self.vehicles.is_empty() && self.characters.is_empty() && self.ragdolls.is_empty()
    }
}

/// All vehicles, characters and ragdolls of a scene, those of `spawn` after those of the start.
#[derive(Default)]
pub(crate) struct Cast {
    pub vehicles: (Vec<VehicleGroup>, VehicleNames),
    pub characters: (Vec<CharacterGroup>, CharacterNames),
    pub ragdolls: (Vec<RagdollGroup>, RagdollNames),
}

impl Cast {
    /// Adds entries that are made so many times, and their names.
    pub(crate) fn add(
        &mut self,
        (v, c, r): (&[VehicleSpec], &[CharacterSpec], &[RagdollSpec]),
        times: u64,
        library: &mut Library,
        census: &mut Census,
        named: &mut Named<'_>,
    ) -> Checked<Movers> {
        let from = [self.vehicles.0.len(), self.characters.0.len(), self.ragdolls.0.len()];
        vehicles(v, times, census, named.bodies, &mut self.vehicles)?;
        characters(c, times, census, named.bodies, &mut self.characters)?;
        ragdolls(r, times, library, census, named, &mut self.ragdolls)?;
        find_bodies(v, times, named.bodies, &mut self.vehicles.0, from[0])?;
        Ok(Movers {
            vehicles: from[0]..self.vehicles.0.len(),
            characters: from[1]..self.characters.0.len(),
            ragdolls: from[2]..self.ragdolls.0.len(),
        })
    }
}

/// Who bears which name.
pub(crate) struct Named<'a> {
    pub bodies: &'a mut Names,
    pub joints: &'a mut JointNames,
}

/// Numbers that one joint gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JointValue {
    Coordinate,
    CoordinateDeg,
    Force,
    Torque,
    ForceAlong(usize),
    TorqueAbout(usize),
    Gap,
    Broken,
    Enabled,
    Length,
}

const JOINT_VALUES: [(&str, JointValue); 8] = [
    ("coordinate", JointValue::Coordinate),
    ("coordinate_deg", JointValue::CoordinateDeg),
    ("force", JointValue::Force),
    ("torque", JointValue::Torque),
    ("gap", JointValue::Gap),
    ("broken", JointValue::Broken),
    ("enabled", JointValue::Enabled),
    ("length", JointValue::Length),
];

const JOINT_AXIS_VALUES: [OfAxis<JointValue>; 2] =
    [("force", JointValue::ForceAlong), ("torque", JointValue::TorqueAbout)];

/// Numbers that points and springs give.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SystemValue {
    Position(usize),
    Velocity(usize),
    Momentum(usize),
    Speed,
    Distance,
    Radius,
    Lowest,
    KineticEnergy,
    ElasticEnergy,
    Energy,
}

const SYSTEM_VALUES: [(&str, SystemValue); 7] = [
    ("speed", SystemValue::Speed),
    ("distance", SystemValue::Distance),
    ("radius", SystemValue::Radius),
    ("lowest", SystemValue::Lowest),
    ("kinetic_energy", SystemValue::KineticEnergy),
    ("elastic_energy", SystemValue::ElasticEnergy),
    ("energy", SystemValue::Energy),
];

const SYSTEM_AXIS_VALUES: [OfAxis<SystemValue>; 3] = [
    ("position", SystemValue::Position),
    ("velocity", SystemValue::Velocity),
    ("momentum", SystemValue::Momentum),
];

/// Numbers that an emitter's particles give.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EmitterValue {
    Center(usize),
    Particles,
    Born,
    Highest,
    Lowest,
    Speed,
}

const EMITTER_VALUES: [(&str, EmitterValue); 5] = [
    ("particles", EmitterValue::Particles),
    ("born", EmitterValue::Born),
    ("highest", EmitterValue::Highest),
    ("lowest", EmitterValue::Lowest),
    ("speed", EmitterValue::Speed),
];

const EMITTER_AXIS_VALUES: [OfAxis<EmitterValue>; 1] = [("center", EmitterValue::Center)];

/// Numbers that one body gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BodyValue {
    Position(usize),
    Center(usize),
    Velocity(usize),
    AngularVelocity(usize),
    Momentum(usize),
    Speed,
    AngularSpeed,
    Height,
    Tilt,
    Angle,
    Distance,
    KineticEnergy,
    PotentialEnergy,
    Energy,
    Mass,
    Awake,
    Contacts,
    NormalForce,
    FrictionForce,
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// Numbers without an axis, by their names in scene files.
const BODY_VALUES: [(&str, BodyValue); 14] = [
    ("speed", BodyValue::Speed),
    ("angular_speed", BodyValue::AngularSpeed),
    ("height", BodyValue::Height),
    ("tilt", BodyValue::Tilt),
    ("angle", BodyValue::Angle),
    ("distance", BodyValue::Distance),
    ("kinetic_energy", BodyValue::KineticEnergy),
    ("potential_energy", BodyValue::PotentialEnergy),
    ("energy", BodyValue::Energy),
    ("mass", BodyValue::Mass),
    ("awake", BodyValue::Awake),
    ("contacts", BodyValue::Contacts),
    ("normal_force", BodyValue::NormalForce),
    ("friction_force", BodyValue::FrictionForce),
];

pub(crate) type OfAxis<T> = (&'static str, fn(usize) -> T);

const BODY_AXIS_VALUES: [OfAxis<BodyValue>; 5] = [
    ("position", BodyValue::Position),
    ("center", BodyValue::Center),
    ("velocity", BodyValue::Velocity),
    ("angular_velocity", BodyValue::AngularVelocity),
    ("momentum", BodyValue::Momentum),
];

/// Numbers that the whole world gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WorldValue {
    Momentum(usize),
    AngularMomentum(usize),
    Energy,
    KineticEnergy,
    PotentialEnergy,
    Bodies,
    Awake,
    Shapes,
    Contacts,
    Touching,
    Joints,
    Particles,
    Vehicles,
    Characters,
}

const WORLD_VALUES: [(&str, WorldValue); 12] = [
    ("vehicles", WorldValue::Vehicles),
    ("characters", WorldValue::Characters),
    ("joints", WorldValue::Joints),
    ("particles", WorldValue::Particles),
    ("energy", WorldValue::Energy),
    ("kinetic_energy", WorldValue::KineticEnergy),
    ("potential_energy", WorldValue::PotentialEnergy),
    ("bodies", WorldValue::Bodies),
    ("awake", WorldValue::Awake),
    ("shapes", WorldValue::Shapes),
    ("contacts", WorldValue::Contacts),
    ("touching", WorldValue::Touching),
];

const WORLD_AXIS_VALUES: [OfAxis<WorldValue>; 2] =
    [("momentum", WorldValue::Momentum), ("angular_momentum", WorldValue::AngularMomentum)];

pub(crate) fn value<T: Copy>(text: &str, plain: &[(&'static str, T)], axes: &[OfAxis<T>]) -> Checked<T> {
    if let Some((_, v)) = plain.iter().find(|(n, _)| *n == text) {
        return Ok(*v);
    }
    if let Some((name, axis)) = text.rsplit_once('.') {
        let make = axes.iter().find(|(n, _)| *n == name);
        let axis = AXES.iter().position(|a| *a == axis);
        if let (Some((_, make)), Some(axis)) = (make, axis) {
            return Ok(make(axis));
        }
    }
    let mut all: Vec<String> = axes.iter().flat_map(|(n, _)| AXES.map(|a| format!("{n}.{a}"))).collect();
    all.extend(plain.iter().map(|(n, _)| n.to_string()));
    let expected = format!(
        "one of {}",
        axes.iter()
            .map(|(n, _)| format!("{n}.x|y|z"))
            .chain(plain.iter().map(|(n, _)| n.to_string()))
            .collect::<Vec<_>>()
            .join(", ")
    );
    let guess = closest(text, all.iter().map(String::as_str));
    Err(Wrong::new(format!("\"{text}\" is unknown"), expected).suggest(guess))
}

/// What a probe looks at.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Look {
    Body { target: Target, value: BodyValue, aggregate: Option<AggregateSpec> },
    Joint { target: Target, value: JointValue, aggregate: Option<AggregateSpec> },
    World(WorldValue),
    Sensor(Target),
    Events { kind: EventSpec, target: Option<Target> },
    System { system: usize, point: Option<usize>, value: SystemValue },
    Emitter { emitter: usize, value: EmitterValue },
    Vehicle { target: Target, wheel: Option<usize>, value: VehicleValue, aggregate: Option<AggregateSpec> },
    Character { target: Target, value: CharacterValue, aggregate: Option<AggregateSpec> },
}

pub(crate) fn probes(
    all: &Map<ProbeSpec>,
    names: &Named<'_>,
    sources: &Sources<'_>,
) -> Checked<Vec<(String, Look)>> {
    let mut out = Vec::with_capacity(all.0.len());
    for (name, p) in &all.0 {
        out.push((name.clone(), probe(p, names, sources).key(name).key("probes")?));
    }
    Ok(out)
}

/// A probe of points and springs, or of particles.
fn of_matter(p: &ProbeSpec, sources: &Sources<'_>) -> Checked<Look> {
    for (key, given) in [
        ("body", p.body.is_some()),
        ("joint", p.joint.is_some()),
        ("world", p.world.is_some()),
        ("sensor", p.sensor.is_some()),
        ("events", p.events.is_some()),
        ("aggregate", p.aggregate.is_some()),
    ] {
        if given {
            let expected = "value (and point) beside system; value beside emitter";
            return Err(Wrong::new("is given beside `system` or `emitter`", expected).key(key));
        }
    }
    let text = p.value.as_deref().unwrap_or("");
    if let Some(name) = &p.emitter {
        if p.system.is_some() || p.point.is_some() {
            return Err(Wrong::new("is given beside `system` or `point`", "value only").key("emitter"));
        }
        let emitter = find_emitter(name, sources.emitters).key("emitter")?;
        let value = value(text, &EMITTER_VALUES, &EMITTER_AXIS_VALUES).key("value")?;
        return Ok(Look::Emitter { emitter, value });
    }
    let name = p.system.as_deref().unwrap_or("");
    let known = sources.systems.iter().map(System::name);
    let Some(system) = sources.systems.iter().position(|s| s.name() == name) else {
        return Err(unknown("system", name, known).key("system"));
    };
    let value = value(text, &SYSTEM_VALUES, &SYSTEM_AXIS_VALUES).key("value")?;
    let points = sources.systems[system].points();
    if let Some(i) = p.point
        && i >= points as u64
    {
        return Err(Wrong::new(format!("is {i}"), format!("less than {points}")).key("point"));
    }
    Ok(Look::System { system, point: p.point.map(|i| i as usize), value })
}

/// A probe of joints.
fn of_joint(p: &ProbeSpec, name: &str, joints: &JointNames) -> Checked<Look> {
    for (key, given) in [
        ("body", p.body.is_some()),
        ("world", p.world.is_some()),
        ("sensor", p.sensor.is_some()),
        ("events", p.events.is_some()),
    ] {
        if given {
            return Err(Wrong::new("is given beside `joint`", "`value` alone").key(key));
        }
    }
    let target = joints.resolve(name).key("joint")?;
    let Some(text) = p.value.as_deref() else {
        return Err(Wrong::new("the key `value` is missing", "value beside joint"));
    };
    let value = value(text, &JOINT_VALUES, &JOINT_AXIS_VALUES).key("value")?;
    alone(&target, p.aggregate, "joints").key("joint")?;
    Ok(Look::Joint { target, value, aggregate: p.aggregate })
}

/// Several need to become one number.
pub(crate) fn alone(target: &Target, aggregate: Option<AggregateSpec>, what: &str) -> Checked<()> {
    if target.count > 1 && aggregate.is_none() {
        let message = format!("names {} {what}", target.count);
        let expected = format!("one, such as {}, or an aggregate (min, max, mean, …)", target.one);
        return Err(Wrong::new(message, expected));
    }
    Ok(())
}

fn probe(p: &ProbeSpec, named: &Named<'_>, sources: &Sources<'_>) -> Checked<Look> {
    let names = &*named.bodies;
    if let Some(name) = &p.character {
        return of_characters(p, name, sources.characters);
    }
    if let Some(name) = &p.vehicle {
        return of_vehicles(p, name, sources.vehicles.0, sources.vehicles.1);
    }
    if p.wheel.is_some() {
        return Err(Wrong::new("is given without `vehicle`", "wheel only beside vehicle").key("wheel"));
    }
    if p.system.is_some() || p.emitter.is_some() {
        return of_matter(p, sources);
    }
    if let Some(name) = &p.joint {
        return of_joint(p, name, named.joints);
    }
    if p.point.is_some() {
        return Err(Wrong::new("is given without `system`", "point only beside system").key("point"));
    }
    let target = p.body.as_deref().map(|b| names.resolve(b)).transpose().key("body")?;
    let ways = [p.value.is_some(), p.world.is_some(), p.sensor.is_some(), p.events.is_some()];
    if ways.iter().filter(|w| **w).count() != 1 {
        return Err(Wrong::new(
            "the probe has no clear subject",
            "exactly one of value (with body, joint, vehicle or character), world, sensor, events",
        ));
    }
    if p.aggregate.is_some() && p.value.is_none() {
        return Err(
            Wrong::new("is given without `value`", "aggregate only with body and value").key("aggregate")
        );
    }
    if target.is_some() && (p.world.is_some() || p.sensor.is_some()) {
        return Err(
            Wrong::new("is given beside `world` or `sensor`", "body only with value or events").key("body")
        );
    }
    if let Some(w) = &p.world {
        return value(w, &WORLD_VALUES, &WORLD_AXIS_VALUES).map(Look::World).key("world");
    }
    if let Some(s) = &p.sensor {
        return names.resolve(s).map(Look::Sensor).key("sensor");
    }
    if let Some(kind) = p.events {
        return Ok(Look::Events { kind, target });
    }
    let v = value(p.value.as_deref().unwrap_or(""), &BODY_VALUES, &BODY_AXIS_VALUES).key("value")?;
    let Some(target) = target else {
        return Err(Wrong::new("the key `body` is missing", "body beside value"));
    };
    alone(&target, p.aggregate, "bodies").key("body")?;
    Ok(Look::Body { target, value: v, aggregate: p.aggregate })
}

/// An expectation by steps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Expect {
    pub probe: usize,
    pub from: u64,
    pub at: u64,
}

/// Number of the step that ends nearest to a time.
pub(crate) fn step_at(time: f64, rate_hz: f64) -> u64 {
    (time * rate_hz).round() as u64
}

/// Number of steps before the first that starts at or after a time.
pub(crate) fn step_from(time: f64, rate_hz: f64) -> u64 {
    // The small part keeps 0.1 · 60 = 6.000000000000001 at step 6.
    (time * rate_hz - 1e-6).ceil() as u64
}

pub(crate) fn time(t: f64) -> Checked<f64> {
    if (0.0..=limits::SECONDS_MAX).contains(&t) {
        return Ok(t);
    }
    Err(Wrong::new(format!("is {t}"), "0 to 1e7 s"))
}

pub(crate) fn expects(all: &[ExpectSpec], probes: &[(String, Look)], rate_hz: f64) -> Checked<Vec<Expect>> {
    let mut out = Vec::with_capacity(all.len());
    for (i, e) in all.iter().enumerate() {
        out.push(expect(e, probes, rate_hz).index(i).key("expect")?);
    }
    Ok(out)
}

fn expect(e: &ExpectSpec, probes: &[(String, Look)], rate_hz: f64) -> Checked<Expect> {
    let known = probes.iter().map(|(n, _)| n.as_str());
    let Some(probe) = probes.iter().position(|(n, _)| *n == e.probe) else {
        return Err(unknown("probe", &e.probe, known).key("probe"));
    };
    let at = step_at(time(e.at).key("at")?, rate_hz);
    let from = step_at(time(e.from.unwrap_or(e.at)).key("from")?, rate_hz);
    if from > at {
        return Err(Wrong::new(format!("is {}", e.from.unwrap_or(0.0)), format!("not after at = {}", e.at))
            .key("from"));
    }
    if e.value.is_none() && e.min.is_none() && e.max.is_none() {
        return Err(Wrong::new("nothing is compared", "value with tolerance, min, or max"));
    }
    let tolerance = e.tolerance.unwrap_or(0.0);
    if tolerance < 0.0 {
        return Err(Wrong::new(format!("is {tolerance}"), "0 or more").key("tolerance"));
    }
    if e.tolerance.is_some() && e.value.is_none() {
        return Err(Wrong::new("is given without `value`", "tolerance only beside value").key("tolerance"));
    }
    if let (Some(min), Some(max)) = (e.min, e.max)
        && min > max
    {
        return Err(Wrong::new(format!("is {min}"), format!("not above max = {max}")).key("min"));
    }
    Ok(Expect { probe, from, at })
}

/// A timed action, checked.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub at: f64,
    pub every: f64,
    pub times: u64,
    pub action: Action,
}

impl Entry {
    /// When the last of its repeats is over, s.
    pub(crate) fn end(&self) -> f64 {
        let lasts = match &self.action {
            Action::Push { duration, .. }
            | Action::MoveTo { duration, .. }
            | Action::Drive { duration, .. } => *duration,
            Action::Lead(l) => l.lasts(),
            _ => 0.0,
        };
        self.at + self.every * (self.times - 1) as f64 + lasts
    }
}

#[derive(Clone, Debug)]
pub(crate) enum Action {
    Spawn(Vec<Group>, Vec<JointGroup>, Movers),
    Push { target: Target, push: Push, duration: f64 },
    SetVelocity { target: Target, velocity: Option<Vec3>, angular_velocity: Option<Vec3> },
    Remove(Target),
    Teleport { target: Target, position: Option<DVec3>, rotation: Option<Quat> },
    MoveTo { target: Target, position: Option<DVec3>, rotation: Option<Quat>, duration: f64 },
    SetGravity(Vec3),
    Wake(Target),
    Sleep(Target),
    Enable(Target, bool),
    Explode(Explosion),
    SetField(usize, bool),
    Emit(usize, u32),
    SetEmitter(usize, bool),
    Cut(Target),
    SetMotor(Target, NewMotor),
    SetJoint(Target, Box<JointKind>, Measure),
    EnableJoint(Target, bool),
    EnableVehicle(Target, bool),
    Drive { target: Target, input: VehicleInputSpec, duration: f64 },
    Walk(Target, Wish),
    Pose(Posing),
    Relax(Bones),
    Lead(Arc<Leading>),
    Release(Bones),
    Grab(Box<Hold>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Push {
    pub impulse: Option<Vec3>,
    pub angular_impulse: Option<Vec3>,
    pub force: Option<Vec3>,
    pub torque: Option<Vec3>,
    pub at: Option<DVec3>,
}

/// What an entry of the timeline makes: bodies, joints and movers, and a hand that holds.
pub(crate) type Made = ((Vec<Group>, Vec<JointGroup>, Movers), Option<Hold>);

/// Checks what the timeline makes: all of it gets its names before actions and joints look names up.
pub(crate) fn made(
    all: &[TimelineSpec],
    library: &mut Library,
    census: &mut Census,
    named: &mut Named<'_>,
    cast: &mut Cast,
) -> Checked<Vec<Made>> {
    let mut spawned = Vec::with_capacity(all.len());
    let mut total = 0u64;
    for (i, t) in all.iter().enumerate() {
        let times = repeats(t).index(i).key("timeline")?;
        total = total.saturating_add(times);
        if total > limits::TIMELINE_MAX {
            let limit = format!("at most {} actions in all", limits::TIMELINE_MAX);
            return Err(Wrong::new(format!("makes {total} actions"), limit)
                .key("times")
                .index(i)
                .key("timeline"));
        }
        let made = spawn(t, times, library, census, named, cast).key("spawn").index(i).key("timeline")?;
        let hand = t.grab.as_ref().map(|g| grab(g, times, census, named.bodies)).transpose();
        spawned.push((made, hand.key("grab").index(i).key("timeline")?));
    }
    Ok(spawned)
}

/// Checks the timeline, given what it makes.
pub(crate) fn timeline(
    all: &[TimelineSpec],
    spawned: Vec<Made>,
    named: &Named<'_>,
    sources: &Sources<'_>,
) -> Checked<Vec<Entry>> {
    let mut out = Vec::with_capacity(all.len());
    for (i, (t, spawned)) in all.iter().zip(spawned).enumerate() {
        let action = action(t, spawned, named, sources).index(i).key("timeline")?;
        out.push(Entry { at: t.at, every: t.every.unwrap_or(0.0), times: t.times.unwrap_or(1), action });
    }
    Ok(out)
}

fn repeats(t: &TimelineSpec) -> Checked<u64> {
    time(t.at).key("at")?;
    match (t.every, t.times) {
        (None, Some(n)) if n > 1 => Err(Wrong::new(format!("is {n}"), "`every` beside it").key("times")),
        (Some(e), _) if !(1e-6..=1e7).contains(&e) => {
            Err(Wrong::new(format!("is {e}"), "1e-6 to 1e7 s").key("every"))
        }
        (_, Some(0)) => Err(Wrong::new("is 0", "1 or more").key("times")),
        (_, n) => Ok(n.unwrap_or(1)),
    }
}

fn spawn(
    t: &TimelineSpec,
    times: u64,
    library: &mut Library,
    census: &mut Census,
    named: &mut Named<'_>,
    cast: &mut Cast,
) -> Checked<(Vec<Group>, Vec<JointGroup>, Movers)> {
    let (mut groups, mut joints) = (Vec::new(), Vec::new());
    for (i, b) in t.spawn.iter().flat_map(|s| &s.bodies).enumerate() {
        let under = |w: Wrong| w.index(i).key("bodies");
        let mut g = group(b, library, census).map_err(under)?;
        census.add((times - 1).saturating_mul(g.len() as u64), b.shapes.len() as u64).map_err(under)?;
        g.single &= times == 1;
        let all = g.names(times);
        all.and_then(|all| all.into_iter().try_for_each(|(n, b)| named.bodies.add(&n, b))).map_err(under)?;
        groups.push(g);
    }
    for (i, j) in t.spawn.iter().flat_map(|s| &s.joints).enumerate() {
        let under = |w: Wrong| w.index(i).key("joints");
        let mut g = joint_group(j, census).map_err(under)?;
        census.joints((times - 1).saturating_mul(g.len() as u64)).map_err(under)?;
        g.single &= times == 1;
        named.joints.add(&g, times).map_err(under)?;
        joints.push(g);
    }
    let movers = match &t.spawn {
        Some(s) => {
            let all = (&s.vehicles[..], &s.characters[..], &s.ragdolls[..]);
            cast.add(all, times, library, census, named)?
        }
        None => Movers::default(),
    };
    if t.spawn.is_some() && groups.is_empty() && joints.is_empty() && movers.is_empty() {
        return Err(Wrong::new("nothing is spawned", "bodies, joints, vehicles, characters or ragdolls"));
    }
    Ok((groups, joints, movers))
}

/// Looks up what spawned joints join.
fn spawned_ends(
    t: &TimelineSpec,
    groups: &[Group],
    joints: &mut [JointGroup],
    named: &Named<'_>,
) -> Checked<()> {
    let Some(s) = &t.spawn else { return Ok(()) };
    let mut own: BTreeMap<String, usize> = BTreeMap::new();
    own.extend(groups.iter().filter_map(|g| Some((g.name.clone()?, g.len()))));
    let own_joints = joints.iter().filter_map(|g| Some((g.name.clone()?, g.len()))).collect();
    for (i, (g, j)) in joints.iter_mut().zip(&s.joints).enumerate() {
        let own = if g.is_gear() { &own_joints } else { &own };
        find_ends(g, j, &s.joints, named.bodies, named.joints, own).index(i).key("joints").key("spawn")?;
    }
    Ok(())
}

fn action(
    t: &TimelineSpec,
    (spawned, hand): Made,
    named: &Named<'_>,
    sources: &Sources<'_>,
) -> Checked<Action> {
    let names = &*named.bodies;
    let given = [
        ("spawn", t.spawn.is_some()),
        ("push", t.push.is_some()),
        ("set_velocity", t.set_velocity.is_some()),
        ("remove", t.remove.is_some()),
        ("teleport", t.teleport.is_some()),
        ("move_to", t.move_to.is_some()),
        ("set_gravity", t.set_gravity.is_some()),
        ("wake", t.wake.is_some()),
        ("sleep", t.sleep.is_some()),
        ("enable", t.enable.is_some()),
        ("explode", t.explode.is_some()),
        ("set_field", t.set_field.is_some()),
        ("emit", t.emit.is_some()),
        ("set_emitter", t.set_emitter.is_some()),
        ("cut", t.cut.is_some()),
        ("set_motor", t.set_motor.is_some()),
        ("set_joint", t.set_joint.is_some()),
        ("enable_joint", t.enable_joint.is_some()),
        ("enable_vehicle", t.enable_vehicle.is_some()),
        ("drive", t.drive.is_some()),
        ("walk", t.walk.is_some()),
        ("pose", t.pose.is_some()),
        ("relax", t.relax.is_some()),
        ("lead", t.lead.is_some()),
        ("release", t.release.is_some()),
        ("grab", t.grab.is_some()),
    ];
    let n = given.iter().filter(|(_, there)| *there).count();
    if n != 1 {
        let all: Vec<&str> = given.iter().map(|(n, _)| *n).collect();
        return Err(Wrong::new(
            format!("the entry has {n} actions"),
            format!("exactly one of {}", all.join(", ")),
        ));
    }
    let find = |name: &str, key: &str| names.resolve(name).key("body").key(key);
    if let Some(p) = &t.push {
        return push(p, names).key("push");
    }
    if let Some(v) = &t.set_velocity {
        let velocity = v
            .velocity
            .map(|x| bounded(x, SPEED_MAX, "m/s"))
            .transpose()
            .key("velocity")
            .key("set_velocity")?;
        let angular = v.angular_velocity.map(|x| bounded(x, SPIN_MAX, "rad/s")).transpose();
        let angular_velocity = angular.key("angular_velocity").key("set_velocity")?;
        let moving = [BodyKind::Kinematic, BodyKind::Dynamic];
        let target = names.resolve_only(&v.body, &moving, "kinematic or dynamic bodies");
        return Ok(Action::SetVelocity {
            target: target.key("body").key("set_velocity")?,
            velocity,
            angular_velocity,
        });
    }
    if let Some(r) = &t.remove {
        return find(&r.body, "remove").map(Action::Remove);
    }
    if let Some(p) = &t.teleport {
        let target = find(&p.body, "teleport")?;
        let (position, rotation, _) = place(p).key("teleport")?;
        return Ok(Action::Teleport { target, position, rotation });
    }
    if let Some(p) = &t.move_to {
        let expected = "kinematic bodies; `teleport` puts any body somewhere";
        let target = names.resolve_only(&p.body, &[BodyKind::Kinematic], expected);
        let target = target.key("body").key("move_to")?;
        let (position, rotation, duration) = place(p).key("move_to")?;
        return Ok(Action::MoveTo { target, position, rotation, duration });
    }
    if let Some(g) = &t.set_gravity {
        return bounded(g.gravity, 1e6, "m/s²").map(Action::SetGravity).key("gravity").key("set_gravity");
    }
    if let Some(w) = &t.wake {
        return find(&w.body, "wake").map(Action::Wake);
    }
    if let Some(w) = &t.sleep {
        return find(&w.body, "sleep").map(Action::Sleep);
    }
    if let Some(e) = &t.enable {
        return Ok(Action::Enable(find(&e.body, "enable")?, e.enabled));
    }
    if let Some(e) = &t.explode {
        return explosion(e).map(Action::Explode).key("explode");
    }
    if let Some(f) = &t.set_field {
        return Ok(Action::SetField(
            find_field(&f.field, sources.fields).key("field").key("set_field")?,
            f.enabled,
        ));
    }
    if let Some(e) = &t.emit {
        let n = find_emitter(&e.emitter, sources.emitters).key("emitter").key("emit")?;
        return Ok(Action::Emit(n, e.count));
    }
    if let Some(e) = &t.set_emitter {
        let n = find_emitter(&e.emitter, sources.emitters).key("emitter").key("set_emitter")?;
        return Ok(Action::SetEmitter(n, e.enabled));
    }
    if let Some(c) = &t.cut {
        return named.joints.resolve(&c.joint).map(Action::Cut).key("joint").key("cut");
    }
    if let Some(m) = &t.set_motor {
        return set_motor(m, named.joints).map(|(j, m)| Action::SetMotor(j, m)).key("set_motor");
    }
    if let Some(s) = &t.set_joint {
        return set_joint(s, named.joints)
            .map(|(j, k, m)| Action::SetJoint(j, Box::new(k), m))
            .key("set_joint");
    }
    if let Some(e) = &t.enable_joint {
        let target = named.joints.resolve(&e.joint).key("joint").key("enable_joint")?;
        return Ok(Action::EnableJoint(target, e.enabled));
    }
    if let Some(e) = &t.enable_vehicle {
        let target = sources.vehicles.0.resolve(&e.vehicle).key("vehicle").key("enable_vehicle")?;
        return Ok(Action::EnableVehicle(target, e.enabled));
    }
    if let Some(d) = &t.drive {
        let (target, input, duration) = drive(d, sources.vehicles.0).key("drive")?;
        return Ok(Action::Drive { target, input, duration });
    }
    if let Some(w) = &t.walk {
        return walk(w, sources.characters).map(|(t, w)| Action::Walk(t, w)).key("walk");
    }
    if let Some(p) = &t.pose {
        let (names, all) = sources.ragdolls;
        return pose(p, names, all).map(Action::Pose).key("pose");
    }
    if let Some(r) = &t.relax {
        let (names, all) = sources.ragdolls;
        return relax(r, names, all).map(Action::Relax).key("relax");
    }
    if let Some(l) = &t.lead {
        let (names, all) = sources.ragdolls;
        return lead(l, names, all).map(|l| Action::Lead(Arc::new(l))).key("lead");
    }
    if let Some(r) = &t.release {
        let (names, all) = sources.ragdolls;
        return release(r, names, all).map(Action::Release).key("release");
    }
    if let (Some(g), Some(mut hand)) = (&t.grab, hand) {
        hand.body = held(g, names).key("grab")?;
        return Ok(Action::Grab(Box::new(hand)));
    }
    let (groups, mut joints, movers) = spawned;
    spawned_ends(t, &groups, &mut joints, named)?;
    Ok(Action::Spawn(groups, joints, movers))
}

pub(crate) fn bounded(v: [f32; 3], limit: f32, unit: &str) -> Checked<Vec3> {
    if v.iter().all(|x| x.abs() <= limit) {
        return Ok(Vec3::from_array(v));
    }
    Err(Wrong::new(format!("is {v:?}"), format!("within ±{limit:e} {unit}")))
}

pub(crate) fn world_point(p: [f64; 3]) -> Checked<DVec3> {
    if p.iter().all(|x| x.abs() <= POSITION_MAX) {
        return Ok(DVec3::from_array(p));
    }
    Err(Wrong::new(format!("is {p:?}"), "within ±1e9 m"))
}

fn push(p: &PushSpec, names: &Names) -> Checked<Action> {
    let expected = "dynamic bodies; others go as they are told";
    let target = names.resolve_only(&p.body, &[BodyKind::Dynamic], expected).key("body")?;
    let limited = |v: Option<[f32; 3]>, key: &str| v.map(|v| bounded(v, FORCE_MAX, "")).transpose().key(key);
    let push = Push {
        impulse: limited(p.impulse, "impulse")?,
        angular_impulse: limited(p.angular_impulse, "angular_impulse")?,
        force: limited(p.force, "force")?,
        torque: limited(p.torque, "torque")?,
        at: p.at_point.map(world_point).transpose().key("at_point")?,
    };
    let lasting = push.force.is_some() || push.torque.is_some();
    if !lasting && push.impulse.is_none() && push.angular_impulse.is_none() {
        return Err(Wrong::new("nothing is pushed with", "impulse, angular_impulse, force or torque"));
    }
    if p.duration.is_some() && !lasting {
        return Err(Wrong::new("is given without force or torque", "duration only with force or torque")
            .key("duration"));
    }
    let duration = time(p.duration.unwrap_or(0.0)).key("duration")?;
    Ok(Action::Push { target, push, duration })
}

type Placed = (Option<DVec3>, Option<Quat>, f64);

fn place(p: &PlaceSpec) -> Checked<Placed> {
    let turned = rotation(p.rotation_deg, p.rotation)?;
    let turned = (p.rotation_deg.is_some() || p.rotation.is_some()).then_some(turned);
    let position = p.position.map(world_point).transpose().key("position")?;
    if position.is_none() && turned.is_none() {
        return Err(Wrong::new("there is no pose", "position, rotation_deg or rotation"));
    }
    Ok((position, turned, time(p.duration.unwrap_or(0.0)).key("duration")?))
}
