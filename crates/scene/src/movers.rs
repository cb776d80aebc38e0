//! Numbers that vehicles and characters give to probes.

use crate::bodies::Target;
use crate::characters::{CharacterNames, CharacterRecords};
use crate::error::{Checked, Under, Wrong};
use crate::plan::{Look, OfAxis, alone, value};
use crate::probe::fold;
use crate::spec::{AggregateSpec, ProbeSpec};
use crate::vehicles::{Driver, VehicleGroup, VehicleNames, VehicleRecords};
use jounce::math::Vec3;
use jounce::{CharacterId, VehicleId, WheelTelemetry, World};

/// Of a vehicle as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum VehicleValue {
    Speed,
    Rpm,
    Gear,
    LeanDeg,
    Grounded,
    Traction,
    ClutchTorque,
    Route,
    Wheel(WheelValue),
}

/// Of one wheel, or one station of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WheelValue {
    Load,
    LongitudinalForce,
    LateralForce,
    SlipRatio,
    SlipAngleDeg,
    Friction,
    GripUsed,
    Spin,
    SteerDeg,
    Travel,
    SuspensionForce,
    DriveTorque,
    Abs,
}

const VEHICLE_VALUES: [(&str, VehicleValue); 21] = [
    ("speed", VehicleValue::Speed),
    ("rpm", VehicleValue::Rpm),
    ("gear", VehicleValue::Gear),
    ("lean_deg", VehicleValue::LeanDeg),
    ("grounded", VehicleValue::Grounded),
    ("traction", VehicleValue::Traction),
    ("clutch_torque", VehicleValue::ClutchTorque),
    ("route", VehicleValue::Route),
    ("load", VehicleValue::Wheel(WheelValue::Load)),
    ("longitudinal_force", VehicleValue::Wheel(WheelValue::LongitudinalForce)),
    ("lateral_force", VehicleValue::Wheel(WheelValue::LateralForce)),
    ("slip_ratio", VehicleValue::Wheel(WheelValue::SlipRatio)),
    ("slip_angle_deg", VehicleValue::Wheel(WheelValue::SlipAngleDeg)),
    ("friction", VehicleValue::Wheel(WheelValue::Friction)),
    ("grip_used", VehicleValue::Wheel(WheelValue::GripUsed)),
    ("spin", VehicleValue::Wheel(WheelValue::Spin)),
    ("steer_deg", VehicleValue::Wheel(WheelValue::SteerDeg)),
    ("travel", VehicleValue::Wheel(WheelValue::Travel)),
    ("suspension_force", VehicleValue::Wheel(WheelValue::SuspensionForce)),
    ("drive_torque", VehicleValue::Wheel(WheelValue::DriveTorque)),
    ("abs", VehicleValue::Wheel(WheelValue::Abs)),
];

/// Of a character.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CharacterValue {
    Position(usize),
    Velocity(usize),
    Speed,
    HeadingDeg,
    Grounded,
    AirTime,
    Crouched,
    OnSteep,
    HitCeiling,
    Squeezed,
    Stepped,
}

const CHARACTER_VALUES: [(&str, CharacterValue); 9] = [
    ("speed", CharacterValue::Speed),
    ("heading_deg", CharacterValue::HeadingDeg),
    ("grounded", CharacterValue::Grounded),
    ("air_time", CharacterValue::AirTime),
    ("crouched", CharacterValue::Crouched),
    ("on_steep", CharacterValue::OnSteep),
    ("hit_ceiling", CharacterValue::HitCeiling),
    ("squeezed", CharacterValue::Squeezed),
    ("stepped", CharacterValue::Stepped),
];

const CHARACTER_AXIS_VALUES: [OfAxis<CharacterValue>; 2] =
    [("position", CharacterValue::Position), ("velocity", CharacterValue::Velocity)];

/// Nothing but `value`, and what else is named, may stand beside a vehicle or a character.
fn only(p: &ProbeSpec, subject: &str) -> Checked<()> {
    let others = [
        ("body", p.body.is_some()),
        ("joint", p.joint.is_some()),
        ("world", p.world.is_some()),
        ("sensor", p.sensor.is_some()),
        ("events", p.events.is_some()),
        ("system", p.system.is_some()),
        ("emitter", p.emitter.is_some()),
        ("point", p.point.is_some()),
        ("vehicle", p.vehicle.is_some() && subject != "vehicle"),
        ("wheel", p.wheel.is_some() && subject != "vehicle"),
    ];
    match others.iter().find(|(_, given)| *given) {
        Some((key, _)) => {
            let message = format!("is given beside `{subject}`");
            Err(Wrong::new(message, "`value`, and for vehicles `wheel`").key(key))
        }
        None => Ok(()),
    }
}

/// A probe of vehicles.
pub(crate) fn of_vehicles(
    p: &ProbeSpec,
    name: &str,
    names: &VehicleNames,
    all: &[VehicleGroup],
) -> Checked<Look> {
    only(p, "vehicle")?;
    let target = names.resolve(name).key("vehicle")?;
    let value = value(p.value.as_deref().unwrap_or(""), &VEHICLE_VALUES, &[]).key("value")?;
    let many = target.count > 1;
    match (value, p.wheel) {
        (VehicleValue::Wheel(_), Some(w)) => {
            let group = all.iter().find(|g| g.name.as_ref() == Some(&target.name));
            let n = group.map_or(0, |g| if g.desc.board.is_some() { 4 } else { g.desc.wheels.len() });
            if w >= n as u64 {
                return Err(Wrong::new(format!("is {w}"), format!("less than {n}")).key("wheel"));
            }
        }
        (VehicleValue::Wheel(_), None) if p.aggregate.is_none() => {
            return Err(
                Wrong::new("is of all wheels", "`wheel`, or an aggregate (min, max, sum, …)").key("value")
            );
        }
        (VehicleValue::Wheel(_), None) => {}
        (_, Some(_)) => {
            return Err(Wrong::new("is given for a number of the whole vehicle", "no wheel").key("wheel"));
        }
        (_, None) => {}
    }
    if many {
        alone(&target, p.aggregate, "vehicles").key("vehicle")?;
    }
    Ok(Look::Vehicle { target, wheel: p.wheel.map(|w| w as usize), value, aggregate: p.aggregate })
}

/// A probe of characters.
pub(crate) fn of_characters(p: &ProbeSpec, name: &str, names: &CharacterNames) -> Checked<Look> {
    only(p, "character")?;
    let target = names.resolve(name).key("character")?;
    let text = p.value.as_deref().unwrap_or("");
    let value = value(text, &CHARACTER_VALUES, &CHARACTER_AXIS_VALUES).key("value")?;
    alone(&target, p.aggregate, "characters").key("character")?;
    Ok(Look::Character { target, value, aggregate: p.aggregate })
}

fn degrees(radians: f32) -> f64 {
    f64::from(radians) * (180.0 / core::f64::consts::PI)
}

fn flag(on: bool) -> f64 {
    f64::from(u8::from(on))
}

pub(crate) fn vehicle_number(
    value: VehicleValue,
    target: &Target,
    wheel: Option<usize>,
    aggregate: Option<AggregateSpec>,
    world: &World,
    records: &VehicleRecords,
    drivers: &[Driver],
) -> f64 {
    let all = records.of(target).iter().copied();
    if let VehicleValue::Wheel(v) = value {
        let wheels = all.filter_map(|id| world.vehicle(id).ok()).flat_map(|v| {
            let some = v.wheels().enumerate().filter(|(i, _)| wheel.is_none_or(|w| w == *i)).map(|(_, t)| t);
            some.collect::<Vec<_>>()
        });
        return fold(wheels.map(|t| of_wheel(v, &t)), aggregate);
    }
    let numbers = all.map(|id| of_vehicle(value, id, world, drivers));
    fold(numbers.filter(|x| x.is_finite()), aggregate)
}

fn of_vehicle(value: VehicleValue, id: VehicleId, world: &World, drivers: &[Driver]) -> f64 {
    let Ok(v) = world.vehicle(id) else { return f64::NAN };
    let t = v.telemetry();
    match value {
        VehicleValue::Speed => f64::from(t.speed),
        VehicleValue::Rpm => f64::from(t.rpm),
        VehicleValue::Gear => f64::from(t.gear),
        VehicleValue::LeanDeg => degrees(t.lean),
        VehicleValue::Grounded => f64::from(t.grounded),
        VehicleValue::Traction => f64::from(t.traction),
        VehicleValue::ClutchTorque => f64::from(t.clutch_torque),
        VehicleValue::Route => drivers.iter().find(|d| d.vehicle == id).map_or(f64::NAN, |d| d.way),
        VehicleValue::Wheel(_) => f64::NAN,
    }
}

fn of_wheel(value: WheelValue, t: &WheelTelemetry) -> f64 {
    let (fx, fy) = (f64::from(t.longitudinal_force), f64::from(t.lateral_force));
    match value {
        WheelValue::Load => f64::from(t.load),
        WheelValue::LongitudinalForce => fx,
        WheelValue::LateralForce => fy,
        WheelValue::SlipRatio => f64::from(t.slip_ratio),
        WheelValue::SlipAngleDeg => degrees(t.slip_angle),
        WheelValue::Friction => f64::from(t.friction),
        WheelValue::GripUsed => {
            let most = f64::from(t.friction) * f64::from(t.load);
            if most > 0.0 { (fx * fx + fy * fy).sqrt() / most } else { 0.0 }
        }
        WheelValue::Spin => f64::from(t.spin),
        WheelValue::SteerDeg => degrees(t.steer),
        WheelValue::Travel => f64::from(t.travel),
        WheelValue::SuspensionForce => f64::from(t.suspension_force),
        WheelValue::DriveTorque => f64::from(t.drive_torque),
        WheelValue::Abs => f64::from(t.abs),
    }
}

pub(crate) fn character_number(
    value: CharacterValue,
    target: &Target,
    aggregate: Option<AggregateSpec>,
    world: &World,
    records: &CharacterRecords,
) -> f64 {
    let numbers = records.of(target).iter().map(|id| of_character(value, *id, world));
    fold(numbers.filter(|x| x.is_finite()), aggregate)
}

fn of_character(value: CharacterValue, id: CharacterId, world: &World) -> f64 {
    let Ok(c) = world.character(id) else { return f64::NAN };
    let axis = |v: Vec3, k: usize| f64::from(v.to_array()[k]);
    match value {
        CharacterValue::Position(k) => c.position().to_array()[k],
        CharacterValue::Velocity(k) => axis(c.velocity(), k),
        CharacterValue::Speed => c.velocity().as_dvec3().length(),
        CharacterValue::HeadingDeg => degrees(c.heading()),
        CharacterValue::Grounded => flag(c.is_grounded()),
        CharacterValue::AirTime => f64::from(c.air_time()),
        CharacterValue::Crouched => flag(c.is_crouched()),
        CharacterValue::OnSteep => flag(c.is_on_steep()),
        CharacterValue::HitCeiling => flag(c.hit_ceiling()),
        CharacterValue::Squeezed => flag(c.is_squeezed()),
        CharacterValue::Stepped => f64::from(c.stepped()),
    }
}
