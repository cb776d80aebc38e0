//! Joints of a scene file: templates, their copies, and the names that probes and actions know them by.

use crate::bodies::{Census, Names, Target, color, resolve_name};
use crate::error::{Checked, Under, Wrong};
use crate::limits;
use crate::shapes::rotation;
use crate::spec::{
    AxisSpec, AxisSpringSpec, BallJointSpec, BallMotorSpec, Count, DistanceJointSpec, GearSpec,
    GenericJointSpec, JointAxisSpec, JointFrameSpec, JointRepeatSpec, JointSolverSpec, JointSpec, LimitSpec,
    MotorSpec, PathSpec, PulleySpec, SetJointSpec, SetMotorSpec, SpringJointSpec, StiffnessSpec,
    WheelJointSpec,
};
use jounce::limits::{NAME_MAX, POSITION_MAX};
use jounce::math::{DVec3, Pose, Quat, Vec3, WorldPose};
use jounce::{
    AxisDesc, BallDesc, BallMotor, BodyId, JointDesc, JointFrames, JointId, JointKind, JointSolver,
    LimitDesc, MotorDesc, MotorTarget, PathDesc, SpringDesc,
};
use std::collections::BTreeMap;

/// A joint to be copied, or a single one.
#[derive(Clone, Debug)]
pub(crate) struct JointGroup {
    pub name: Option<String>,
    /// A single joint is `name`; copies are `name[n]`.
    pub single: bool,
    pub color: Option<[f32; 3]>,
    pub width: Option<f32>,
    /// With bodies of no world.
    desc: JointDesc,
    measure: Measure,
    count: [u64; 3],
    repeated: Count,
    step: [f64; 3],
    steps: [[i64; 3]; 2],
    ends: [End; 2],
}

/// Lengths that are measured when the joint is added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Measure {
    min: bool,
    max: bool,
    rest: bool,
}

/// One of two bodies (of a gear: joints): the first copy's, by name.
#[derive(Clone, Debug, Default)]
struct End {
    name: String,
    index: Option<i64>,
    /// Made by the same timed spawn: so many each time.
    own: Option<i64>,
}

/// Which copy of a name an end of a joint is; none: the only one.
pub(crate) struct Wanted<'a> {
    pub name: &'a str,
    pub index: usize,
}

impl JointGroup {
    /// Number of joints.
    pub(crate) fn len(&self) -> usize {
        self.count.iter().product::<u64>() as usize
    }
    pub(crate) fn is_gear(&self) -> bool {
        matches!(self.desc.kind, JointKind::Gear { .. })
    }
    fn cell(&self, n: usize) -> [i64; 3] {
        let [x, y, _] = self.count.map(|c| c as usize);
        [n % x, n / x % y, n / (x * y)].map(|i| i as i64)
    }
    /// Which body (of a gear: joint) is the end `e` of copy `n`.
    pub(crate) fn end(&self, n: usize, e: usize, occurrence: u64) -> Wanted<'_> {
        let end = &self.ends[e];
        let made = end.own.map_or(0, |each| each * occurrence as i64);
        Wanted { name: &end.name, index: (end.index_of(self.cell(n), self.steps[e]) + made) as usize }
    }
    /// What copy `n` is called; `made` copies were made before.
    pub(crate) fn label(&self, n: usize, made: usize) -> Option<String> {
        let name = self.name.as_ref()?;
        Some(if self.single { name.clone() } else { format!("{name}[{}]", made + n) })
    }
    /// Copy `n` between two bodies as they stand.
    pub(crate) fn joint(&self, n: usize, bodies: [(BodyId, WorldPose); 2], made: usize) -> JointDesc {
        let mut d = self.shifted(n);
        (d.body_a, d.body_b) = (bodies[0].0, bodies[1].0);
        d.name = self.label(n, made);
        let [pa, pb] = match d.frames {
            JointFrames::Anchors(a, b) => [a, b],
            JointFrames::Local(a, b) => [bodies[0].1.transform_point(a.p), bodies[1].1.transform_point(b.p)],
            JointFrames::World(w) => [w.p, w.p],
        };
        measured(&mut d.kind, self.measure, (pb - pa).length() as f32);
        d
    }
    /// Copy `n` of a gear.
    pub(crate) fn gear(&self, n: usize, joints: [JointId; 2], made: usize) -> JointDesc {
        let mut d = self.shifted(n);
        d.name = self.label(n, made);
        if let JointKind::Gear { a, b, .. } = &mut d.kind {
            [*a, *b] = joints;
        }
        d
    }
    fn shifted(&self, n: usize) -> JointDesc {
        let mut d = self.desc.clone();
        let cell = self.cell(n).map(|x| x as f64);
        let by = DVec3::from_array(self.repeated.shift(cell, self.step));
        match &mut d.frames {
            JointFrames::World(w) => w.p += by,
            JointFrames::Anchors(a, b) => (*a, *b) = (*a + by, *b + by),
            JointFrames::Local(..) => {}
        }
        if let JointKind::Pulley { wheel_a, wheel_b, .. } = &mut d.kind {
            (*wheel_a, *wheel_b) = (*wheel_a + by, *wheel_b + by);
        }
        d
    }
}

impl End {
    fn index_of(&self, cell: [i64; 3], step: [i64; 3]) -> i64 {
        self.index.map_or(0, |n| n + (0..3).map(|k| cell[k] * step[k]).sum::<i64>())
    }
}

/// Puts the length that two points have where none was given.
pub(crate) fn measured(kind: &mut JointKind, m: Measure, length: f32) {
    match kind {
        JointKind::Distance { min, max } => {
            if m.min {
                *min = if m.max || length < *max { length } else { *max };
            }
            if m.max {
                *max = if length > *min { length } else { *min };
            }
        }
        JointKind::Spring { rest, .. } if m.rest => *rest = length,
        _ => {}
    }
}

/// Names of joints: how many bear each, and of which kind they are.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointNames(BTreeMap<String, (u64, &'static str)>);

impl JointNames {
    /// The joints that a text names: `name` (all of them) or `name[n]`.
    pub(crate) fn resolve(&self, text: &str) -> Checked<Target> {
        let known = self.0.keys().map(String::as_str);
        resolve_name("joint", text, known, |name| self.0.get(name).map(|b| b.0))
    }
    fn kind(&self, t: &Target) -> &'static str {
        self.0.get(&t.name).map_or("", |b| b.1)
    }
    /// Gives a group its name; `times` is how often it is made.
    pub(crate) fn add(&mut self, g: &JointGroup, times: u64) -> Checked<()> {
        let Some(name) = &g.name else { return Ok(()) };
        if name.is_empty() || name.contains(['[', ']']) || name.len() > NAME_MAX - 12 {
            let expected = "1 to 244 bytes without square brackets";
            return Err(Wrong::new(format!("is {name:?}"), expected).key("name"));
        }
        if self.0.insert(name.clone(), (g.len() as u64 * times, g.desc.kind.name())).is_some() {
            let message = format!("\"{name}\" is given to two joints");
            return Err(Wrong::new(message, "a name of its own").key("name"));
        }
        Ok(())
    }
}

/// One entry of `joints`, without its ends: those are looked up when all names are known.
pub(crate) fn group(j: &JointSpec, census: &mut Census) -> Checked<JointGroup> {
    let (key, kind, measure) = kind(&Kinds::of(j))?;
    let mut desc = JointDesc::new(BodyId::from_bits(0), BodyId::from_bits(1), WorldPose::IDENTITY, kind);
    desc.frames = place(j, key)?;
    desc.collide = j.collide.unwrap_or(false);
    desc.enabled = j.enabled.unwrap_or(true);
    desc.softness = j.softness.as_ref().map(stiffness).transpose().key("softness")?;
    desc.break_force = j.break_force.unwrap_or(f32::INFINITY);
    desc.break_torque = j.break_torque.unwrap_or(f32::INFINITY);
    desc.solver = match j.solver.unwrap_or(JointSolverSpec::Auto) {
        JointSolverSpec::Auto => JointSolver::Auto,
        JointSolverSpec::Direct => JointSolver::Direct,
        JointSolverSpec::Iterative => JointSolver::Iterative,
    };
    desc.check()?;
    let count = j.repeat.as_ref().map_or(Ok([1; 3]), |r| copies(r)).key("repeat")?;
    census.joints(count.iter().product()).key("count").key("repeat")?;
    let step = j.repeat.as_ref().and_then(|r| r.step).unwrap_or([0.0; 3]);
    if step.iter().any(|s| s.abs() > 1e6) {
        return Err(Wrong::new(format!("is {step:?}"), "within ±1e6 m").key("step").key("repeat"));
    }
    let of = |steps: Option<[i64; 3]>| steps.unwrap_or([1, 0, 0]);
    let steps = j.repeat.as_ref().map_or([[0; 3]; 2], |r| [of(r.a_step), of(r.b_step)]);
    for (key, steps) in [("a_step", steps[0]), ("b_step", steps[1])] {
        if steps.iter().any(|s| s.unsigned_abs() > limits::SCENE_BODIES_MAX) {
            return Err(Wrong::new(format!("is {steps:?}"), "within ±524288").key(key).key("repeat"));
        }
    }
    if let Some(w) = j.width.filter(|w| !(0.0..=limits::TRAIL_WIDTH_MAX).contains(w)) {
        return Err(Wrong::new(format!("is {w}"), "0 to 1000 m").key("width"));
    }
    Ok(JointGroup {
        name: j.name.clone(),
        single: j.repeat.is_none(),
        color: j.color.as_deref().map(color).transpose().key("color")?,
        width: j.width,
        desc,
        measure,
        count,
        repeated: j.repeat.as_ref().map_or(Count::One(1), |r| r.count),
        step,
        steps,
        ends: [End::default(), End::default()],
    })
}

fn copies(r: &JointRepeatSpec) -> Checked<[u64; 3]> {
    let n = r.count.each();
    let all = n[0].checked_mul(n[1]).and_then(|m| m.checked_mul(n[2]));
    if all.is_none_or(|m| m == 0 || m > limits::SCENE_JOINTS_MAX) {
        let expected = format!("1 to {} joints in all", limits::SCENE_JOINTS_MAX);
        return Err(Wrong::new(format!("is {n:?}"), expected).key("count"));
    }
    Ok(n)
}

/// Looks up what a joint joins; `own` are the names that a timed spawn makes, with how many of each.
pub(crate) fn find_ends(
    g: &mut JointGroup,
    j: &JointSpec,
    names: &Names,
    joints: &JointNames,
    own: &BTreeMap<String, usize>,
) -> Checked<()> {
    if let Some(gear) = &j.gear {
        for (key, text, e) in [("a", &gear.a, 0), ("b", &gear.b, 1)] {
            let found = joints.resolve(text).and_then(|t| {
                let kind = joints.kind(&t);
                if !matches!(kind, "hinge" | "slider") {
                    return Err(Wrong::new(format!("\"{text}\" is a {kind} joint"), "a hinge or a slider"));
                }
                g.find(e, t, own.get(text.split('[').next().unwrap_or("")).copied())
            });
            found.key(key).key("gear")?;
        }
    } else {
        for (key, text, e) in [("a", &j.a, 0), ("b", &j.b, 1)] {
            let Some(text) = text else {
                return Err(Wrong::new(format!("the key `{key}` is missing"), "the name of a body"));
            };
            let own = own.get(text.split('[').next().unwrap_or("")).copied();
            names.resolve(text).and_then(|t| g.find(e, t, own)).key(key)?;
        }
    }
    let same = (0..g.len()).find(|&n| {
        let [a, b] = [0, 1].map(|e| g.end(n, e, 0));
        a.name == b.name && a.index == b.index
    });
    if let Some(n) = same {
        let end = g.end(n, 1, 0);
        let what = if j.gear.is_some() { "joint" } else { "body" };
        let copy = if g.single { String::new() } else { format!(" in copy {n}") };
        let message = format!("\"{}\" number {} is both ends{copy}", end.name, end.index);
        let w = Wrong::new(message, format!("another {what} than a"));
        return Err(if j.gear.is_some() { w.key("b").key("gear") } else { w.key("b") });
    }
    Ok(())
}

impl JointGroup {
    /// Takes a found name as an end, if all copies are there.
    fn find(&mut self, e: usize, t: Target, own: Option<usize>) -> Checked<()> {
        let there = own.map_or(t.count, |n| n as u64);
        let end = End { name: t.name, index: t.index.map(|i| i as i64), own: own.map(|n| n as i64) };
        if end.index.is_none() && there != 1 {
            let message = format!("names {there} of them");
            return Err(Wrong::new(message, format!("one, such as {}[0]", end.name)));
        }
        // A target with a number counts itself alone: whether a copy's number is there is looked up again.
        let index = |n: usize| end.index_of(self.cell(n), self.steps[e]);
        let (low, high) = (0..self.len()).map(index).fold((0, 0), |(l, h), i| (l.min(i), h.max(i)));
        let most = own.map_or(i64::MAX, |n| n as i64 - 1);
        let all = t.all.min(most as u64 + 1) as i64;
        if low < 0 || (end.index.is_some() && high >= all) {
            let wrong = if low < 0 { low } else { high };
            let message = format!("the copies reach {}[{wrong}]", end.name);
            return Err(Wrong::new(message, format!("{0}[0] to {0}[{1}]", end.name, all - 1)));
        }
        self.ends[e] = end;
        Ok(())
    }
}

/// The kinds that an entry gives.
struct Kinds<'a> {
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
    fn of(j: &'a JointSpec) -> Self {
        Self {
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
fn kind(k: &Kinds<'_>) -> Checked<(&'static str, JointKind, Measure)> {
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
    let expected = || format!("exactly one of {}", KIND_KEYS.join(", "));
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
            return unlocked(s).and_then(|()| axis(s, true)).map(JointKind::Hinge);
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
            let of = |a: &Option<AxisSpec>, turns, otherwise, key| {
                a.as_ref().map_or(Ok(otherwise), |a| axis(a, turns)).key(key)
            };
            return Ok(JointKind::Wheel {
                suspension: of(&s.suspension, false, AxisDesc::FREE, "suspension")?,
                spin: of(&s.spin, true, AxisDesc::FREE, "spin")?,
                steer: of(&s.steer, true, AxisDesc::LOCKED, "steer")?,
            });
        }
        if let Some(s) = k.generic {
            let three = |a: &Option<[AxisSpec; 3]>, turns, key| {
                let mut out = [AxisDesc::LOCKED; 3];
                for (i, spec) in a.iter().flatten().enumerate() {
                    out[i] = axis(spec, turns).index(i).key(key)?;
                }
                Ok::<_, Wrong>(out)
            };
            return Ok(JointKind::Generic {
                linear: three(&s.linear, false, "linear")?,
                angular: three(&s.angular, true, "angular")?,
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
    let made = made.and_then(|kind| checked(kind)).key(key)?;
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

fn stiffness(s: &StiffnessSpec) -> Checked<SpringDesc> {
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
fn coordinate<'k>(
    plain: Option<f32>,
    deg: Option<f32>,
    turns: bool,
    keys: [&'k str; 2],
) -> Checked<Option<(f32, &'k str)>> {
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
    if checked(JointKind::Hinge(axis)).is_err() {
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
    if twist.is_some_and(|t| t.min < -3.1416 || t.max > 3.1416) {
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

fn point(p: [f64; 3]) -> Checked<DVec3> {
    if p.iter().all(|x| x.abs() <= POSITION_MAX) {
        return Ok(DVec3::from_array(p));
    }
    Err(Wrong::new(format!("is {p:?}"), "within ±1e9 m"))
}

/// A turn whose x is an axis, or as it is written out.
fn turn(axis: Option<[f32; 3]>, deg: Option<[f32; 3]>, q: Option<[f32; 4]>) -> Checked<Quat> {
    let Some(a) = axis else { return rotation(deg, q) };
    if deg.is_some() || q.is_some() {
        let expected = "axis, rotation_deg or rotation, only one of them";
        return Err(Wrong::new("given beside a rotation", expected).key("axis"));
    }
    let v = Vec3::from_array(a);
    let n = v.length();
    if !(n > 1e-6 && n < 1e6) {
        return Err(Wrong::new(format!("is {a:?}"), "a direction, 1e-6 to 1e6 long").key("axis"));
    }
    Ok(Quat::from_rotation_arc(Vec3::X, v / n))
}

fn frame(s: Option<&JointFrameSpec>) -> Checked<Pose> {
    let s = s.copied().unwrap_or_default();
    let p = s.position.unwrap_or([0.0; 3]);
    if p.iter().any(|x| x.abs() > 1e6) {
        return Err(Wrong::new(format!("is {p:?}"), "within ±1e6 m").key("position"));
    }
    Ok(Pose::new(Vec3::from_array(p), turn(s.axis, s.rotation_deg, s.rotation)?))
}

/// Where a joint of a kind is.
fn place(j: &JointSpec, kind: &str) -> Checked<JointFrames> {
    let turned = [
        ("axis", j.axis.is_some()),
        ("rotation_deg", j.rotation_deg.is_some()),
        ("rotation", j.rotation.is_some()),
    ];
    let world = j.at.is_some();
    let anchors = j.at_a.is_some() || j.at_b.is_some();
    let local = j.local_a.is_some() || j.local_b.is_some();
    let first = |all: &[(&'static str, bool)]| all.iter().find(|(_, there)| *there).map(|(k, _)| *k);
    if kind == "gear" {
        let all = [("a", j.a.is_some()), ("b", j.b.is_some()), ("at", world), ("at_a", j.at_a.is_some())];
        let more =
            [("at_b", j.at_b.is_some()), ("local_a", j.local_a.is_some()), ("local_b", j.local_b.is_some())];
        if let Some(key) = first(&all).or_else(|| first(&more)).or_else(|| first(&turned)) {
            let expected = "no bodies and no place: a gear has those of its two joints";
            return Err(Wrong::new("is given for a gear", expected).key(key));
        }
        return Ok(JointFrames::Local(Pose::IDENTITY, Pose::IDENTITY));
    }
    let points = matches!(kind, "distance" | "spring" | "pulley");
    let ways = if points {
        "at_a and at_b, or local_a and local_b"
    } else {
        "at, or at_a and at_b, or local_a and local_b"
    };
    if points && world {
        let message = format!("is given for a {kind} joint, which has two points");
        return Err(Wrong::new(message, ways).key("at"));
    }
    if usize::from(world) + usize::from(anchors) + usize::from(local) > 1 {
        return Err(Wrong::new("the joint's place is given in two ways", format!("one of {ways}")));
    }
    if !world && let Some(key) = first(&turned) {
        let expected = format!("{key} only beside `at`; local_a and local_b have their own");
        return Err(Wrong::new("is given without `at`", expected).key(key));
    }
    if let Some(at) = j.at {
        let q = turn(j.axis, j.rotation_deg, j.rotation)?;
        return Ok(JointFrames::World(WorldPose::new(point(at).key("at")?, q)));
    }
    if anchors {
        let (Some(a), Some(b)) = (j.at_a, j.at_b) else {
            let (there, missing) = if j.at_a.is_some() { ("at_a", "at_b") } else { ("at_b", "at_a") };
            return Err(Wrong::new(format!("is given without `{missing}`"), "both points").key(there));
        };
        return Ok(JointFrames::Anchors(point(a).key("at_a")?, point(b).key("at_b")?));
    }
    if !local && !points {
        return Err(Wrong::new("the joint has no place", ways));
    }
    let a = frame(j.local_a.as_deref()).key("local_a")?;
    Ok(JointFrames::Local(a, frame(j.local_b.as_deref()).key("local_b")?))
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
    let target = joints.resolve(&s.joint).key("joint")?;
    let axis = s.axis.unwrap_or(A::Main);
    let kind = joints.kind(&target);
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
    let target = joints.resolve(&s.joint).key("joint")?;
    let (key, kind, measure) = kind(&Kinds::of_action(s))?;
    let now = joints.kind(&target);
    if now != key {
        let message = format!("is given for a {now} joint");
        return Err(Wrong::new(message, format!("`{now}`: a joint keeps its kind")).key(key));
    }
    Ok((target, kind, measure))
}

/// Joints by name, and how they look.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointRecords {
    names: BTreeMap<String, Vec<JointId>>,
    looks: Vec<Option<(JointId, JointLook)>>,
}

/// How a joint looks in pictures; what is absent is the painter's choice.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointLook {
    /// Red, green, blue in 0…1 (sRGB).
    pub color: Option<[f32; 3]>,
    /// Thickness, m; 0 hides it.
    pub width: Option<f32>,
}

impl JointRecords {
    pub(crate) fn add(&mut self, g: &JointGroup, id: JointId) {
        if let Some(name) = &g.name {
            self.names.entry(name.clone()).or_default().push(id);
        }
        let slot = id.index() as usize;
        if self.looks.len() <= slot {
            self.looks.resize_with(slot + 1, || None);
        }
        self.looks[slot] = Some((id, JointLook { color: g.color, width: g.width }));
    }
    pub(crate) fn look(&self, id: JointId) -> JointLook {
        let entry = self.looks.get(id.index() as usize).copied().flatten();
        entry.filter(|(owner, _)| *owner == id).map_or_else(JointLook::default, |(_, l)| l)
    }
    /// The joint of a name and number, if it was made; it may be removed by now.
    pub(crate) fn get(&self, name: &str, index: usize) -> Option<JointId> {
        self.names.get(name)?.get(index).copied()
    }
    /// How many of a name were made.
    pub(crate) fn made(&self, name: Option<&String>) -> usize {
        name.and_then(|n| self.names.get(n)).map_or(0, Vec::len)
    }
    /// The joints of a target that were made so far; some may be removed by now.
    pub(crate) fn of(&self, target: &Target) -> &[JointId] {
        let all = self.names.get(&target.name).map_or(&[][..], Vec::as_slice);
        match target.index {
            None => all,
            Some(i) => all.get(i..=i).unwrap_or(&[]),
        }
    }
    /// The joints of `name`, or the one of `name[n]`.
    pub(crate) fn by_text(&self, text: &str) -> &[JointId] {
        let all = |name: &str| self.names.get(name).map_or(&[][..], Vec::as_slice);
        match text.strip_suffix(']').and_then(|t| t.split_once('[')) {
            Some((name, n)) => n.parse().ok().and_then(|n: usize| all(name).get(n..=n)).unwrap_or(&[]),
            None => all(text),
        }
    }
}
