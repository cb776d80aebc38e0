//! Probes: numbers of a running world.

use crate::bodies::{Group, Target};
use crate::characters::CharacterRecords;
use crate::joints::JointRecords;
use crate::movers::{character_number, vehicle_number};
use crate::plan::{BodyValue, EmitterValue, JointValue, Look, WorldValue};
use crate::spec::{AggregateSpec, EventSpec};
use crate::systems::System;
use crate::vehicles::{Driver, VehicleRecords};
use jounce::math::{DVec3, Vec3, WorldPose};
use jounce::{BodyId, ContactInfo, EmitterId, Event, JointId, ShapeId, World};
use std::collections::BTreeMap;

/// What a scene knows of a body that the engine does not.
#[derive(Clone, Debug)]
pub(crate) struct Record {
    id: BodyId,
    pub color: [f32; 3],
    start: WorldPose,
    /// Indices into the names, and the copy under each.
    names: [Option<(usize, usize)>; 2],
}

/// Bodies by slot and by name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Records {
    slots: Vec<Option<Record>>,
    index: BTreeMap<String, usize>,
    bodies: Vec<Vec<BodyId>>,
}

impl Records {
    pub(crate) fn add(
        &mut self,
        g: &Group,
        n: usize,
        made: usize,
        id: BodyId,
        color: [f32; 3],
        start: WorldPose,
    ) {
        let own = g.template(n).desc.name.as_ref().filter(|t| Some(*t) != g.name.as_ref());
        let copies = g.templates.len();
        let named =
            [g.name.as_ref().map(|name| (name, made + n)), own.map(|name| (name, (made + n) / copies))];
        let names = named.map(|entry| entry.map(|(name, copy)| (self.name(name, copy, id), copy)));
        let slot = id.index() as usize;
        if self.slots.len() <= slot {
            self.slots.resize_with(slot + 1, || None);
        }
        self.slots[slot] = Some(Record { id, color, start, names });
    }

    fn name(&mut self, name: &str, copy: usize, id: BodyId) -> usize {
        let n = match self.index.get(name) {
            Some(&n) => n,
            None => {
                self.bodies.push(Vec::new());
                self.index.insert(name.into(), self.bodies.len() - 1);
                self.bodies.len() - 1
            }
        };
        // Copies come in order, so a name's bodies stand at their numbers.
        debug_assert_eq!(self.bodies[n].len(), copy);
        self.bodies[n].push(id);
        n
    }

    pub(crate) fn get(&self, id: BodyId) -> Option<&Record> {
        self.slots.get(id.index() as usize)?.as_ref().filter(|r| r.id == id)
    }

    /// The bodies of a target that were made so far; some may be removed by now.
    pub(crate) fn of(&self, target: &Target) -> &[BodyId] {
        let Some(all) = self.index.get(&target.name).map(|&n| self.bodies[n].as_slice()) else { return &[] };
        match target.index {
            None => all,
            Some(i) => all.get(i..=i).unwrap_or(&[]),
        }
    }

    /// The bodies of `name`, or the one of `name[n]`, made so far; some may be removed by now.
    pub(crate) fn by_text(&self, text: &str) -> &[BodyId] {
        let all = |name: &str| self.index.get(name).map_or(&[][..], |&n| self.bodies[n].as_slice());
        match text.strip_suffix(']').and_then(|t| t.split_once('[')) {
            Some((name, n)) => n.parse().ok().and_then(|n: usize| all(name).get(n..=n)).unwrap_or(&[]),
            None => all(text),
        }
    }

    /// The body of a name and number, if it was made; it may be removed by now.
    pub(crate) fn get_named(&self, name: &str, index: usize) -> Option<BodyId> {
        self.bodies[*self.index.get(name)?].get(index).copied()
    }

    fn is_of(&self, id: BodyId, target: &Target) -> bool {
        let Some(wanted) = self.index.get(&target.name) else { return false };
        let mut names = self.get(id).into_iter().flat_map(|r| r.names.iter().flatten());
        names.any(|(n, copy)| n == wanted && target.index.is_none_or(|i| i == *copy))
    }
}

/// Events counted for probes since the start.
#[derive(Clone, Debug, Default)]
pub(crate) struct EventCounts {
    /// By probe; 0 for probes of other kinds.
    counts: Vec<u64>,
    /// Are there probes to count for?
    any: bool,
}

impl EventCounts {
    pub(crate) fn new(probes: &[(String, Look)]) -> Self {
        let any = probes.iter().any(|(_, l)| matches!(l, Look::Events { .. }));
        Self { counts: vec![0; probes.len()], any }
    }

    /// Takes in the world's events.
    pub(crate) fn add(&mut self, probes: &[(String, Look)], records: &Records, world: &World) {
        if !self.any {
            return;
        }
        for e in world.events() {
            for (count, (_, look)) in self.counts.iter_mut().zip(probes) {
                let Look::Events { kind, target } = look else { continue };
                let counted =
                    is_kind(e, *kind) && target.as_ref().is_none_or(|t| concerns(e, t, records, world));
                *count += u64::from(counted);
            }
        }
    }
}

fn is_kind(e: &Event, kind: EventSpec) -> bool {
    matches!(
        (e, kind),
        (Event::ContactBegin { .. }, EventSpec::ContactBegin)
            | (Event::ContactEnd { .. }, EventSpec::ContactEnd)
            | (Event::ContactHit { .. }, EventSpec::ContactHit)
            | (Event::SensorEnter { .. }, EventSpec::SensorEnter)
            | (Event::SensorLeave { .. }, EventSpec::SensorLeave)
            | (Event::Sleep { .. }, EventSpec::Sleep)
            | (Event::Wake { .. }, EventSpec::Wake)
            | (Event::Quarantine { .. }, EventSpec::Quarantine)
            | (Event::SpeedLimited { .. }, EventSpec::SpeedLimited)
            | (Event::LimitReached { .. }, EventSpec::LimitReached)
            | (Event::JointBreak { .. }, EventSpec::JointBreak)
    )
}

/// Is a body of the target part of the event? Shapes removed since then belong to nobody.
fn concerns(e: &Event, target: &Target, records: &Records, world: &World) -> bool {
    let body = |b: &BodyId| records.is_of(*b, target);
    let shape = |s: &ShapeId| world.shape(*s).is_ok_and(|r| body(&r.body()));
    match e {
        Event::ContactBegin { a, b } | Event::ContactEnd { a, b } | Event::ContactHit { a, b, .. } => {
            shape(a) || shape(b)
        }
        Event::SensorEnter { sensor, visitor } | Event::SensorLeave { sensor, visitor } => {
            shape(sensor) || shape(visitor)
        }
        Event::Sleep { body: b }
        | Event::Wake { body: b }
        | Event::Quarantine { body: b }
        | Event::SpeedLimited { body: b } => body(b),
        Event::JointBreak { joint, .. } => {
            world.joint(*joint).is_ok_and(|j| body(&j.body_a()) || body(&j.body_b()))
        }
        _ => false,
    }
}

/// What probes look at.
#[derive(Clone, Copy)]
pub(crate) struct Seen<'a> {
    pub world: &'a World,
    pub records: &'a Records,
    pub joints: &'a JointRecords,
    pub counts: &'a EventCounts,
    pub systems: &'a [System],
    /// Handles of each entry of `emitters`; those that removed themselves are stale.
    pub emitters: &'a [Vec<EmitterId>],
    pub vehicles: &'a VehicleRecords,
    pub drivers: &'a [Driver],
    pub characters: &'a CharacterRecords,
}

fn of_particles(v: EmitterValue, world: &World, ids: &[EmitterId]) -> f64 {
    let there = || ids.iter().filter_map(|id| world.emitter(*id).ok());
    let all = || there().flat_map(|e| e.particles());
    let count = || there().map(|e| e.len()).sum::<usize>() as f64;
    match v {
        EmitterValue::Particles => count(),
        EmitterValue::Born => there().map(|e| e.born()).sum::<u64>() as f64,
        EmitterValue::Center(k) => all().map(|p| p.position.to_array()[k]).sum::<f64>() / count(),
        EmitterValue::Speed => all().map(|p| f64::from(p.velocity.length())).sum::<f64>() / count(),
        EmitterValue::Highest => fold(all().map(|p| p.position.y), Some(AggregateSpec::Max)),
        EmitterValue::Lowest => fold(all().map(|p| p.position.y), Some(AggregateSpec::Min)),
    }
}

/// The number that probe `n` shows now; NaN where its body is not there.
pub(crate) fn evaluate(look: &Look, n: usize, seen: &Seen<'_>) -> f64 {
    let Seen { world, records, joints, counts, systems, emitters, .. } = *seen;
    match look {
        Look::System { system, point, value } => {
            systems.get(*system).map_or(f64::NAN, |s| s.value(*value, *point))
        }
        Look::Emitter { emitter, value } => {
            of_particles(*value, world, emitters.get(*emitter).map_or(&[], Vec::as_slice))
        }
        Look::Vehicle { target, wheel, value, aggregate } => {
            vehicle_number(*value, target, *wheel, *aggregate, world, seen.vehicles, seen.drivers)
        }
        Look::Character { target, value, aggregate } => {
            character_number(*value, target, *aggregate, world, seen.characters)
        }
        Look::World(v) => of_world(*v, world),
        Look::Joint { target, value, aggregate } => {
            let numbers = joints.of(target).iter().map(|j| of_joint(*value, *j, world));
            fold(numbers.filter(|x| x.is_finite()), *aggregate)
        }
        Look::Events { .. } => counts.counts.get(n).map_or(f64::NAN, |c| *c as f64),
        Look::Sensor(target) => records.of(target).iter().map(|b| visitors(world, *b)).sum::<usize>() as f64,
        Look::Body { target, value, aggregate } => {
            let numbers = records.of(target).iter().map(|b| of_body(*value, *b, world, records));
            fold(numbers.filter(|x| x.is_finite()), *aggregate)
        }
    }
}

pub(crate) fn fold(mut numbers: impl Iterator<Item = f64>, aggregate: Option<AggregateSpec>) -> f64 {
    let Some(aggregate) = aggregate else { return numbers.next().unwrap_or(f64::NAN) };
    let (mut n, mut sum, mut low, mut high, mut counted) =
        (0u64, 0.0, f64::INFINITY, f64::NEG_INFINITY, 0u64);
    for x in numbers {
        n += 1;
        sum += x;
        low = if x < low { x } else { low };
        high = if x > high { x } else { high };
        counted += u64::from(match aggregate {
            AggregateSpec::CountBelow(limit) => x < limit,
            AggregateSpec::CountAbove(limit) => x > limit,
            _ => false,
        });
    }
    match aggregate {
        AggregateSpec::CountBelow(_) | AggregateSpec::CountAbove(_) => counted as f64,
        AggregateSpec::Sum => sum,
        _ if n == 0 => f64::NAN,
        AggregateSpec::Min => low,
        AggregateSpec::Max => high,
        AggregateSpec::Mean => sum / n as f64,
        AggregateSpec::Spread => high - low,
    }
}

fn visitors(world: &World, body: BodyId) -> usize {
    let Ok(b) = world.body(body) else { return 0 };
    b.shapes().filter_map(|s| world.shape(s).ok()).map(|s| s.visitors().count()).sum()
}

fn of_world(v: WorldValue, world: &World) -> f64 {
    match v {
        WorldValue::Momentum(k) => world.momentum().linear.to_array()[k],
        WorldValue::AngularMomentum(k) => world.momentum().angular.to_array()[k],
        WorldValue::Energy => world.energy().total(),
        WorldValue::KineticEnergy => world.energy().kinetic,
        WorldValue::PotentialEnergy => world.energy().potential,
        WorldValue::Bodies => world.counts().bodies as f64,
        WorldValue::Awake => world.counts().awake as f64,
        WorldValue::Shapes => world.counts().shapes as f64,
        WorldValue::Contacts => world.counts().contacts as f64,
        WorldValue::Particles => world.counts().particles as f64,
        WorldValue::Joints => world.counts().joints as f64,
        WorldValue::Vehicles => world.counts().vehicles as f64,
        WorldValue::Characters => world.counts().characters as f64,
        WorldValue::Touching => world.counts().touching as f64,
    }
}

/// Against gravity; y where there is none.
fn up(world: &World) -> DVec3 {
    let g = world.gravity().as_dvec3();
    let l = g.length();
    if l > 0.0 { g * (-1.0 / l) } else { DVec3::Y }
}

fn of_body(v: BodyValue, id: BodyId, world: &World, records: &Records) -> f64 {
    let (Ok(b), Some(record)) = (world.body(id), records.get(id)) else { return f64::NAN };
    let axis = |v: Vec3, k: usize| f64::from(v.to_array()[k]);
    let kinetic = || b.kinetic_energy();
    let potential =
        || -f64::from(b.mass() * b.gravity_scale()) * world.gravity().as_dvec3().dot(b.center_of_mass());
    match v {
        BodyValue::Position(k) => b.position().to_array()[k],
        BodyValue::Center(k) => b.center_of_mass().to_array()[k],
        BodyValue::Velocity(k) => axis(b.velocity(), k),
        BodyValue::AngularVelocity(k) => axis(b.angular_velocity(), k),
        BodyValue::Momentum(k) => f64::from(b.mass()) * axis(b.velocity(), k),
        BodyValue::Speed => b.velocity().as_dvec3().length(),
        BodyValue::AngularSpeed => b.angular_velocity().as_dvec3().length(),
        BodyValue::Height => b.position().dot(up(world)),
        BodyValue::Tilt => {
            let y = b.rotation().rotate(Vec3::Y).as_dvec3().dot(up(world));
            degrees(jounce::math::scalar::f64s::acos(jounce::math::scalar::f64s::clamp(y, -1.0, 1.0)))
        }
        BodyValue::Angle => degrees(f64::from((b.rotation() * record.start.q.conjugate()).angle())),
        BodyValue::Distance => (b.position() - record.start.p).length(),
        BodyValue::KineticEnergy => kinetic(),
        BodyValue::PotentialEnergy => potential(),
        BodyValue::Energy => kinetic() + potential(),
        BodyValue::Mass => f64::from(b.mass()),
        BodyValue::Awake => f64::from(u8::from(b.is_awake())),
        BodyValue::Contacts => touching(world, id).len() as f64,
        BodyValue::NormalForce => touching(world, id).iter().map(|c| f64::from(c.normal_force())).sum(),
        BodyValue::FrictionForce => {
            let all = touching(world, id);
            let signed = |c: &ContactInfo| if c.bodies[1] == id { 1.0 } else { -1.0 };
            let of = |c: &ContactInfo| {
                let sum = c.manifolds.iter().fold(DVec3::ZERO, |f, m| f + m.friction_force.as_dvec3());
                sum * signed(c)
            };
            all.iter().fold(DVec3::ZERO, |f, c| f + of(c)).length()
        }
    }
}

fn of_joint(v: JointValue, id: JointId, world: &World) -> f64 {
    let Ok(j) = world.joint(id) else { return f64::NAN };
    let axis = |v: Vec3, k: usize| f64::from(v.to_array()[k]);
    match v {
        JointValue::Coordinate => f64::from(j.coordinate()),
        JointValue::CoordinateDeg => degrees(f64::from(j.coordinate())),
        JointValue::Force => j.force().as_dvec3().length(),
        JointValue::Torque => j.torque().as_dvec3().length(),
        JointValue::ForceAlong(k) => axis(j.force(), k),
        JointValue::TorqueAbout(k) => axis(j.torque(), k),
        JointValue::Gap => f64::from(j.gap()),
        JointValue::Broken => f64::from(u8::from(j.is_broken())),
        JointValue::Enabled => f64::from(u8::from(j.is_enabled())),
        JointValue::Length => {
            let [a, b] = j.anchors();
            (b - a).length()
        }
    }
}

fn touching(world: &World, id: BodyId) -> Vec<ContactInfo> {
    world.contacts_of(id).unwrap_or_default()
}

fn degrees(radians: f64) -> f64 {
    radians * (180.0 / core::f64::consts::PI)
}
