//! Kinds of joints: what holds, ends, drives and springs, from the words of a scene file. Each value is shown to the engine alone, so
//! that a complaint has its place.

use super::{JointNames, Measure, point};
use crate::bodies::Target;
use crate::error::{Checked, Under, Wrong};
use crate::shapes::rotation;
use crate::spec::{
    AxisSpec, AxisSpringSpec, BallJointSpec, BallMotorSpec, DistanceJointSpec, GearSpec, GenericJointSpec,
    JointAxisSpec, JointSpec, LimitSpec, MotorSpec, PathSpec, PulleySpec, SetJointSpec, SetMotorSpec,
    SpringJointSpec, StiffnessSpec, WheelJointSpec,
};
use jounce::math::{Vec3, WorldPose};
use jounce::{
    AxisDesc, BallDesc, BallMotor, BodyId, JointDesc, JointId, JointKind, LimitDesc, MotorDesc, MotorTarget,
    PathDesc, SpringDesc,
};
use std::f32::consts::{FRAC_PI_2, PI};

/// The kinds that an entry gives.
pub(super) struct Kinds<'a> {
    /// Those that the entry may give.
    keys: &'static [&'static str],
    fixed: bool,
    ball: Option<&'a BallJointSpec>,
    hinge: Option<&'a AxisSpec>,
    slider: Option<&'a AxisSpec>,
    distance: Option<&'a DistanceJointSpec>,
    spring: Option<&'a SpringJointSpec>,
    wheel: Option<&'a WheelJointSpec>,
    generic: Option<&'a GenericJointSpec>,
    gear: Option<&'a GearSpec>,
    pulley: Option<&'a PulleySpec>,
    path: Option<&'a PathSpec>,
}

impl<'a> Kinds<'a> {
    pub(super) fn of(j: &'a JointSpec) -> Self {
        Self {
            keys: &KIND_KEYS,
            fixed: j.fixed.is_some(),
            ball: j.ball.as_deref(),
            hinge: j.hinge.as_deref(),
            slider: j.slider.as_deref(),
            distance: j.distance.as_ref(),
            spring: j.spring.as_deref(),
            wheel: j.wheel.as_deref(),
            generic: j.generic.as_deref(),
            gear: j.gear.as_deref(),
            pulley: j.pulley.as_deref(),
            path: j.path.as_deref(),
        }
    }
    fn of_action(j: &'a SetJointSpec) -> Self {
        Self {
            keys: &["ball", "hinge", "slider", "distance", "spring", "wheel", "generic", "pulley", "path"],
            fixed: false,
            ball: j.ball.as_deref(),
            hinge: j.hinge.as_deref(),
            slider: j.slider.as_deref(),
            distance: j.distance.as_ref(),
            spring: j.spring.as_deref(),
            wheel: j.wheel.as_deref(),
            generic: j.generic.as_deref(),
            gear: None,
            pulley: j.pulley.as_deref(),
            path: j.path.as_deref(),
        }
    }
}

const KIND_KEYS: [&str; 11] =
    ["fixed", "ball", "hinge", "slider", "distance", "spring", "wheel", "generic", "gear", "pulley", "path"];

/// The one kind, with its key and the lengths that are still to be measured.
pub(super) fn kind(k: &Kinds<'_>) -> Checked<(&'static str, JointKind, Measure)> {
    let given = [
        k.fixed,
        k.ball.is_some(),
        k.hinge.is_some(),
        k.slider.is_some(),
        k.distance.is_some(),
        k.spring.is_some(),
        k.wheel.is_some(),
        k.generic.is_some(),
        k.gear.is_some(),
        k.pulley.is_some(),
        k.path.is_some(),
    ];
    let all: Vec<&str> = KIND_KEYS.iter().zip(given).filter(|(_, g)| *g).map(|(k, _)| *k).collect();
    let expected = || format!("exactly one of {}", k.keys.join(", "));
    let [key] = all[..] else {
        let message = match all.len() {
            0 => "the joint has no kind".to_string(),
            n => format!("the joint has {n} kinds: {}", all.join(", ")),
        };
        return Err(Wrong::new(message, expected()));
    };
    let mut m = Measure::default();
    let made = (|| {
        if let Some(s) = k.ball {
            return ball(s);
        }
        if let Some(s) = k.hinge {
            return unlocked(s).and_then(|()| turning(s)).map(JointKind::Hinge);
        }
        if let Some(s) = k.slider {
            return unlocked(s).and_then(|()| axis(s, false)).map(JointKind::Slider);
        }
        if let Some(s) = k.distance {
            (m.min, m.max) = (s.min.is_none(), s.max.is_none());
            // A length still to be measured stands for the one that is known, so that the check sees what is given.
            let known = s.max.or(s.min).unwrap_or(0.0);
            return Ok(JointKind::Distance { min: s.min.unwrap_or(known), max: s.max.unwrap_or(known) });
        }
        if let Some(s) = k.spring {
            m.rest = s.rest.is_none();
            let limit = s.limit.as_ref().map(|l| limit(l, false)).transpose().key("limit")?;
            let spring = stiffness(&StiffnessSpec {
                hertz: s.hertz,
                damping_ratio: s.damping_ratio,
                stiffness: s.stiffness,
                damping: s.damping,
            })?;
            return Ok(JointKind::Spring { rest: s.rest.unwrap_or(0.0), spring, limit });
        }
        if let Some(s) = k.wheel {
            let of = |a: &Option<AxisSpec>, make: MakeAxis, otherwise, key| {
                a.as_ref().map_or(Ok(otherwise), make).key(key)
            };
            return Ok(JointKind::Wheel {
                suspension: of(&s.suspension, moving, AxisDesc::FREE, "suspension")?,
                spin: of(&s.spin, turning, AxisDesc::FREE, "spin")?,
                steer: of(&s.steer, swinging, AxisDesc::LOCKED, "steer")?,
            });
        }
        if let Some(s) = k.generic {
            let three = |a: &Option<[AxisSpec; 3]>, make: [MakeAxis; 3], key| {
                let mut out = [AxisDesc::LOCKED; 3];
                for (i, spec) in a.iter().flatten().enumerate() {
                    out[i] = make[i](spec).index(i).key(key)?;
                }
                Ok::<_, Wrong>(out)
            };
            return Ok(JointKind::Generic {
                linear: three(&s.linear, [moving; 3], "linear")?,
                angular: three(&s.angular, [turning, swinging, swinging], "angular")?,
            });
        }
        if let Some(s) = k.gear {
            let [a, b] = [0, 1].map(JointId::from_bits);
            return Ok(JointKind::Gear { a, b, ratio: s.ratio.unwrap_or(1.0) });
        }
        if let Some(s) = k.pulley {
            return Ok(JointKind::Pulley {
                wheel_a: point(s.wheel_a).key("wheel_a")?,
                wheel_b: point(s.wheel_b).key("wheel_b")?,
                ratio: s.ratio.unwrap_or(1.0),
                length: s.length,
            });
        }
        if let Some(s) = k.path {
            return Ok(JointKind::Path(Box::new(PathDesc {
                points: s.points.iter().map(|p| Vec3::from_array(*p)).collect(),
                closed: s.closed.unwrap_or(false),
                aligned: s.aligned.unwrap_or(false),
                axis: s.along.as_ref().map_or(Ok(AxisDesc::FREE), |a| axis(a, false)).key("along")?,
            })));
        }
        Ok(JointKind::Fixed)
    })();
    let made = made.and_then(checked).key(key)?;
    Ok((key, made, m))
}

/// Lets the engine look at a kind alone.
fn checked(kind: JointKind) -> Checked<JointKind> {
    let d = JointDesc::new(BodyId::from_bits(0), BodyId::from_bits(1), WorldPose::IDENTITY, kind);
    d.check()?;
    Ok(d.kind)
}

fn unlocked(s: &AxisSpec) -> Checked<()> {
    if s.locked == Some(true) {
        return Err(Wrong::new("is true", "false (a fixed joint holds all)").key("locked"));
    }
    Ok(())
}

pub(crate) fn stiffness(s: &StiffnessSpec) -> Checked<SpringDesc> {
    let hooke = s.stiffness.is_some() || s.damping.is_some();
    let spring = match (s.hertz, hooke) {
        (Some(hertz), false) => SpringDesc::hertz(hertz, s.damping_ratio.unwrap_or(1.0)),
        (None, true) if s.damping_ratio.is_none() => {
            SpringDesc::newton(s.stiffness.unwrap_or(0.0), s.damping.unwrap_or(0.0))
        }
        (None, false) => {
            return Err(Wrong::new("the spring has no stiffness", "hertz, or stiffness with damping"));
        }
        _ => {
            let expected = "hertz with damping_ratio, or stiffness with damping";
            return Err(Wrong::new("the spring is given in two ways", expected));
        }
    };
    checked(JointKind::Spring { rest: 0.0, spring, limit: None })?;
    Ok(spring)
}

/// A coordinate that may be given in degrees where the axis turns; with its key.
fn coordinate(
    plain: Option<f32>,
    deg: Option<f32>,
    turns: bool,
    keys: [&str; 2],
) -> Checked<Option<(f32, &str)>> {
    match (plain, deg) {
        (Some(_), Some(_)) => Err(Wrong::new(
            format!("given beside `{}`", keys[0]),
            format!("{} or {}, not both", keys[0], keys[1]),
        )
        .key(keys[1])),
        (None, Some(_)) if !turns => {
            Err(Wrong::new("is given for an axis that does not turn", format!("{} in metres", keys[0]))
                .key(keys[1]))
        }
        (None, Some(d)) => Ok(Some((d.to_radians(), keys[1]))),
        (Some(x), None) => Ok(Some((x, keys[0]))),
        (None, None) => Ok(None),
    }
}

fn limit(s: &LimitSpec, turns: bool) -> Checked<LimitDesc> {
    let mixed = match (s.min, s.max, s.min_deg, s.max_deg) {
        (Some(_), None, None, Some(_)) => Some(("max_deg", "min")),
        (None, Some(_), Some(_), None) => Some(("min_deg", "max")),
        _ => None,
    };
    if let Some((deg, plain)) = mixed.filter(|_| turns) {
        let expected = "both ends in one unit: min and max in radians, or min_deg and max_deg";
        return Err(Wrong::new(format!("is given beside `{plain}`"), expected).key(deg));
    }
    let min = coordinate(s.min, s.min_deg, turns, ["min", "min_deg"])?;
    let max = coordinate(s.max, s.max_deg, turns, ["max", "max_deg"])?;
    let (Some((min, key)), Some((max, _))) = (min, max) else {
        return Err(Wrong::new("an end is missing", "min and max (or min_deg and max_deg)"));
    };
    if min > max {
        let given = if key == "min_deg" { s.min_deg } else { s.min };
        return Err(Wrong::new(format!("is {}", given.unwrap_or(min)), "not above the other end").key(key));
    }
    let desc = LimitDesc { min, max, spring: s.spring.as_ref().map(stiffness).transpose().key("spring")? };
    let mut axis = AxisDesc::FREE;
    axis.limit = Some(desc);
    if checked(JointKind::Slider(axis)).is_err() {
        return Err(Wrong::new(format!("is {min} to {max}"), "within ±1e6"));
    }
    Ok(desc)
}

fn motor(s: &MotorSpec, turns: bool) -> Checked<Option<MotorDesc>> {
    let position = coordinate(s.position, s.position_deg, turns, ["position", "position_deg"])?;
    let target = match (position, &s.spring) {
        (Some((position, _)), Some(spring)) => MotorTarget::Position {
            position,
            velocity: s.velocity.unwrap_or(0.0),
            spring: stiffness(spring).key("spring")?,
        },
        (Some((_, key)), None) => {
            return Err(Wrong::new("is given without `spring`", "`spring` beside it").key(key));
        }
        (None, Some(_)) => {
            return Err(
                Wrong::new("is given without a position", "spring only beside position").key("spring")
            );
        }
        (None, None) => match s.velocity {
            Some(v) => MotorTarget::Velocity(v),
            None => return Ok(None),
        },
    };
    let desc = MotorDesc { target, max_force: s.max_force.unwrap_or(f32::INFINITY) };
    checked(JointKind::Hinge(AxisDesc::FREE.motor(desc)))?;
    Ok(Some(desc))
}

fn axis_spring(s: &AxisSpringSpec, turns: bool) -> Checked<(f32, SpringDesc)> {
    let rest = coordinate(s.rest, s.rest_deg, turns, ["rest", "rest_deg"])?.map_or(0.0, |r| r.0);
    let spring = stiffness(&StiffnessSpec {
        hertz: s.hertz,
        damping_ratio: s.damping_ratio,
        stiffness: s.stiffness,
        damping: s.damping,
    })?;
    checked(JointKind::Hinge(AxisDesc::FREE.spring(rest, spring)))?;
    Ok((rest, spring))
}

type MakeAxis = fn(&AxisSpec) -> Checked<AxisDesc>;

/// An axis along a line.
fn moving(s: &AxisSpec) -> Checked<AxisDesc> {
    axis(s, false)
}

/// An axis whose turns are counted, from ±180° where it is added: its ends leave room there.
fn turning(s: &AxisSpec) -> Checked<AxisDesc> {
    let a = axis(s, true)?;
    if a.limit.is_some_and(|l| l.min > PI + 1e-5 || l.max < -PI - 1e-5) {
        let expected = "room within ±180 degrees (±π rad), where a joint begins to count its turns";
        return Err(Wrong::new(format!("is {}", ends(s)), expected).key("limit"));
    }
    Ok(a)
}

/// A swing, which is measured within ±90°.
fn swinging(s: &AxisSpec) -> Checked<AxisDesc> {
    let a = axis(s, true)?;
    if a.limit.is_some_and(|l| l.min < -FRAC_PI_2 - 1e-5 || l.max > FRAC_PI_2 + 1e-5) {
        let expected =
            "within ±90 degrees (±π/2 rad): such an axis is measured within them and turns no farther";
        return Err(Wrong::new(format!("is {}", ends(s)), expected).key("limit"));
    }
    Ok(a)
}

/// The ends of an axis as they are given.
fn ends(s: &AxisSpec) -> String {
    match s.limit {
        Some(LimitSpec { min_deg: Some(a), max_deg: Some(b), .. }) => format!("{a} to {b} degrees"),
        Some(LimitSpec { min: Some(a), max: Some(b), .. }) => format!("{a} to {b} rad"),
        _ => "open".into(),
    }
}

/// A degree of freedom that turns (rad) or moves (m).
fn axis(s: &AxisSpec, turns: bool) -> Checked<AxisDesc> {
    let made = match &s.motor {
        Some(m) => match motor(m, turns).key("motor")? {
            Some(m) => Some(m),
            None => {
                return Err(
                    Wrong::new("the motor has no aim", "velocity, or position with spring").key("motor")
                );
            }
        },
        None => None,
    };
    let desc = AxisDesc {
        locked: s.locked.unwrap_or(false),
        limit: s.limit.as_ref().map(|l| limit(l, turns)).transpose().key("limit")?,
        motor: made,
        spring: s.spring.as_ref().map(|x| axis_spring(x, turns)).transpose().key("spring")?,
        friction: s.friction.unwrap_or(0.0),
    };
    checked(JointKind::Hinge(AxisDesc::FREE.friction(desc.friction)))?;
    Ok(desc)
}

fn ball(s: &BallJointSpec) -> Checked<JointKind> {
    if let Some(c) = s.cone_deg.filter(|c| !(0.0..=180.0).contains(c)) {
        return Err(Wrong::new(format!("is {c}"), "0 to 180 degrees").key("cone_deg"));
    }
    let twist = s.twist.as_ref().map(|t| limit(t, true)).transpose().key("twist")?;
    if twist.is_some_and(|t| t.min < -PI || t.max > PI) {
        return Err(Wrong::new("goes beyond half a turn", "within ±180 degrees").key("twist"));
    }
    Ok(JointKind::Ball(BallDesc {
        cone: s.cone_deg.map(f32::to_radians),
        twist,
        cone_spring: s.cone_spring.as_ref().map(stiffness).transpose().key("cone_spring")?,
        motor: s.motor.as_ref().map(ball_motor).transpose().key("motor")?,
        friction: s.friction.unwrap_or(0.0),
    }))
}

fn ball_motor(s: &BallMotorSpec) -> Checked<BallMotor> {
    let turned = rotation(s.rotation_deg, s.rotation)?;
    let motor = BallMotor {
        rotation: (s.rotation_deg.is_some() || s.rotation.is_some()).then_some(turned),
        velocity: Vec3::from_array(s.velocity.unwrap_or([0.0; 3])),
        spring: stiffness(&s.spring).key("spring")?,
        max_torque: s.max_torque.unwrap_or(f32::INFINITY),
    };
    if motor.velocity.length() > 1e5 {
        return Err(
            Wrong::new(format!("is {:?}", motor.velocity.to_array()), "at most 1e5 rad/s").key("velocity")
        );
    }
    checked(JointKind::Ball(BallDesc { motor: Some(motor), ..BallDesc::default() }))?;
    Ok(motor)
}

/// A motor on an axis.
#[derive(Clone, Debug)]
pub(crate) struct NewMotor {
    axis: JointAxisSpec,
    motor: Option<MotorDesc>,
}

impl NewMotor {
    /// A kind with the motor in its place.
    pub(crate) fn put(&self, kind: &JointKind) -> JointKind {
        let mut kind = kind.clone();
        let axis = match (&mut kind, self.axis) {
            (JointKind::Hinge(a) | JointKind::Slider(a), JointAxisSpec::Main) => Some(a),
            (JointKind::Path(p), JointAxisSpec::Main) => Some(&mut p.axis),
            (JointKind::Wheel { spin, .. }, JointAxisSpec::Main) => Some(spin),
            (JointKind::Wheel { suspension, .. }, JointAxisSpec::Suspension) => Some(suspension),
            (JointKind::Wheel { steer, .. }, JointAxisSpec::Steer) => Some(steer),
            (JointKind::Generic { linear, .. }, JointAxisSpec::LinearX) => Some(&mut linear[0]),
            (JointKind::Generic { linear, .. }, JointAxisSpec::LinearY) => Some(&mut linear[1]),
            (JointKind::Generic { linear, .. }, JointAxisSpec::LinearZ) => Some(&mut linear[2]),
            (JointKind::Generic { angular, .. }, JointAxisSpec::AngularX) => Some(&mut angular[0]),
            (JointKind::Generic { angular, .. }, JointAxisSpec::AngularY) => Some(&mut angular[1]),
            (JointKind::Generic { angular, .. }, JointAxisSpec::AngularZ) => Some(&mut angular[2]),
            _ => None,
        };
        if let Some(axis) = axis {
            axis.motor = self.motor;
        }
        kind
    }
}

/// The action `set_motor`.
pub(crate) fn set_motor(s: &SetMotorSpec, joints: &JointNames) -> Checked<(Target, NewMotor)> {
    use JointAxisSpec as A;
    let (target, kind) = joints.of_one_kind(&s.joint).key("joint")?;
    let axis = s.axis.unwrap_or(A::Main);
    let (ok, words) = match kind {
        "hinge" | "slider" | "path" => (axis == A::Main, "main"),
        "wheel" => (matches!(axis, A::Main | A::Suspension | A::Steer), "main, suspension or steer"),
        "generic" => (
            !matches!(axis, A::Main | A::Suspension | A::Steer),
            "linear_x, linear_y, linear_z, angular_x, angular_y or angular_z",
        ),
        "ball" => {
            let message = "is a ball joint, whose motor turns it to a pose";
            return Err(Wrong::new(message, "`set_joint` with `ball` and its `motor`").key("joint"));
        }
        _ => {
            let message = format!("is a {kind} joint, which has no motor");
            return Err(Wrong::new(message, "a hinge, slider, wheel, path or generic joint").key("joint"));
        }
    };
    if !ok {
        let key = if s.axis.is_some() { "axis" } else { "joint" };
        return Err(Wrong::new(format!("is no axis of a {kind} joint"), format!("axis {words}")).key(key));
    }
    let turns = match axis {
        A::Main => !matches!(kind, "slider" | "path"),
        A::Steer | A::AngularX | A::AngularY | A::AngularZ => true,
        _ => false,
    };
    let motor = motor(
        &MotorSpec {
            velocity: s.velocity,
            position: s.position,
            position_deg: s.position_deg,
            spring: s.spring,
            max_force: s.max_force,
        },
        turns,
    )?;
    Ok((target, NewMotor { axis, motor }))
}

/// The action `set_joint`.
pub(crate) fn set_joint(s: &SetJointSpec, joints: &JointNames) -> Checked<(Target, JointKind, Measure)> {
    let (target, now) = joints.of_one_kind(&s.joint).key("joint")?;
    if matches!(now, "fixed" | "gear") {
        let message = format!("\"{}\" is a {now} joint, which has nothing to set", s.joint);
        return Err(Wrong::new(message, "a joint of another kind").key("joint"));
    }
    let (key, kind, measure) = kind(&Kinds::of_action(s))?;
    if now != key {
        let message = format!("is given for a {now} joint");
        return Err(Wrong::new(message, format!("`{now}`: a joint keeps its kind")).key(key));
    }
    Ok((target, kind, measure))
}
