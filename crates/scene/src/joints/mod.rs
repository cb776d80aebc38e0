//! Joints of a scene file: templates, their copies, and the names that probes and actions know them by.

mod kinds;
mod mortar;

use crate::bodies::{Census, Names, Target, check_name, color, given_twice, resolve_name};
use crate::error::{Checked, Under, Wrong};
use crate::limits;
use crate::shapes::rotation;
use crate::spec::{Count, JointFrameSpec, JointRepeatSpec, JointSolverSpec, JointSpec};
use jounce::limits::POSITION_MAX;
use jounce::math::{DVec3, Pose, Quat, Vec3, WorldPose};
use jounce::{BodyId, JointDesc, JointFrames, JointId, JointKind, JointSolver};
use kinds::{Kinds, kind};
pub(crate) use kinds::{NewMotor, set_joint, set_motor, stiffness};
pub(crate) use mortar::{Mortar, mortar};
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
pub(crate) struct JointNames(BTreeMap<String, Bearers>);

/// The joints that bear a name.
#[derive(Clone, Debug)]
struct Bearers {
    count: u64,
    /// All of a ragdoll are of the kind "ragdoll".
    kind: &'static str,
    /// How one of several is called, where that is not `name[0]`.
    one: Option<String>,
}

impl JointNames {
    /// The joints that a text names: `name` (all of them) or `name[n]`.
    pub(crate) fn resolve(&self, text: &str) -> Checked<Target> {
        let known = self.0.keys().map(String::as_str);
        let mut target = resolve_name("joint", text, known, |name| self.0.get(name).map(|b| b.count))?;
        if let Some(one) = self.0.get(&target.name).and_then(|b| b.one.as_ref()) {
            target.one.clone_from(one);
        }
        Ok(target)
    }
    /// The joints that a text names, all of one kind.
    fn of_one_kind(&self, text: &str) -> Checked<(Target, &'static str)> {
        let target = self.resolve(text)?;
        let kind = self.0.get(&target.name).map_or("", |b| b.kind);
        if kind == "ragdoll" {
            let message = format!("\"{text}\" names joints of a ragdoll, each of its own kind");
            return Err(Wrong::new(message, format!("those of one bone, such as {}", target.one)));
        }
        Ok((target, kind))
    }
    /// How one of those that bear a name is called.
    pub(crate) fn call_one(&mut self, name: &str, one: String) {
        if let Some(b) = self.0.get_mut(name) {
            b.one = Some(one);
        }
    }
    /// Gives a group its name; `times` is how often it is made.
    pub(crate) fn add(&mut self, g: &JointGroup, times: u64) -> Checked<()> {
        let Some(name) = &g.name else { return Ok(()) };
        self.add_named(name, g.len() as u64 * times, g.desc.kind.name())
    }
    /// Gives so many joints of a kind a name.
    pub(crate) fn add_named(&mut self, name: &str, count: u64, kind: &'static str) -> Checked<()> {
        check_name(name)?;
        let what = |kind| if kind == "ragdoll" { kind } else { "joint" };
        match self.0.insert(name.into(), Bearers { count, kind, one: None }) {
            Some(other) => Err(given_twice(name, what(other.kind), what(kind))),
            None => Ok(()),
        }
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

/// Looks up what a joint of a list joins; `own` are the names that a timed spawn makes, with how many of each.
pub(crate) fn find_ends(
    g: &mut JointGroup,
    j: &JointSpec,
    all: &[JointSpec],
    names: &Names,
    joints: &JointNames,
    own: &BTreeMap<String, usize>,
) -> Checked<()> {
    if let Some(gear) = &j.gear {
        for (key, text, e) in [("a", &gear.a, 0), ("b", &gear.b, 1)] {
            let found = joints.of_one_kind(text).and_then(|(t, kind)| {
                if !matches!(kind, "hinge" | "slider") {
                    return Err(Wrong::new(format!("\"{text}\" is a {kind} joint"), "a hinge or a slider"));
                }
                g.find(e, t, own.get(text.split('[').next().unwrap_or("")).copied())
            });
            found.key(key).key("gear")?;
        }
        gear_can_act(&gear.a, &gear.b, all, names).key("b").key("gear")?;
    } else {
        for (key, text, e) in [("a", &j.a, 0), ("b", &j.b, 1)] {
            let Some(text) = text else {
                return Err(Wrong::new(format!("the key `{key}` is missing"), "the name of a body"));
            };
            let own = own.get(text.split('[').next().unwrap_or("")).copied();
            names.resolve(text).and_then(|t| g.find(e, t, own)).key(key)?;
        }
        if let (Some(a), Some(b)) = (&j.a, &j.b)
            && !(leads(j, all) && may_lead(a, b, names))
        {
            can_act(a, b, names).key("b")?;
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

/// The name of a group in the name of one of it.
fn group_of(text: &str) -> &str {
    text.split('[').next().unwrap_or("")
}

/// Is there a gear on a joint?
fn leads(j: &JointSpec, all: &[JointSpec]) -> bool {
    let on = |text: &str| j.name.as_deref() == Some(group_of(text));
    all.iter().filter_map(|o| o.gear.as_ref()).any(|gear| on(&gear.a) || on(&gear.b))
}

/// Is it a joint that a gear may follow though it moves neither body: does one of them go as it is led?
fn may_lead(a: &str, b: &str, names: &Names) -> bool {
    let of = [a, b].map(|text| names.unmoved(text));
    of.iter().all(Option::is_some) && of.contains(&Some("kinematic"))
}

/// Does a gear move anything?
fn gear_can_act(a: &str, b: &str, all: &[JointSpec], names: &Names) -> Checked<()> {
    let led = |text: &str| {
        let of = all.iter().find(|o| o.name.as_deref() == Some(group_of(text)));
        let ends = of.and_then(|o| Some((o.a.as_ref()?, o.b.as_ref()?)));
        ends.is_some_and(|(a, b)| may_lead(a, b, names))
    };
    if !(led(a) && led(b)) {
        return Ok(());
    }
    let message = format!("\"{b}\" and \"{a}\" both go as their kinematic bodies do: a gear moves neither");
    Err(Wrong::new(message, "a joint with a dynamic body at one end at least"))
}

/// Does a joint move anything? The engine takes one that does not, since a body's type may change there; in a scene it stays.
fn can_act(a: &str, b: &str, names: &Names) -> Checked<()> {
    let (Some(of_a), Some(of_b)) = (names.unmoved(a), names.unmoved(b)) else { return Ok(()) };
    if (of_a, of_b) == ("fixed", "fixed") {
        let message = format!("\"{b}\" is fixed, as \"{a}\" is");
        return Err(Wrong::new(message, "a body that can move, at one end at least"));
    }
    let message = format!("\"{b}\" is {of_b} and \"{a}\" is {of_a}: a joint moves neither");
    Err(Wrong::new(message, "a dynamic body at one end at least"))
}

impl JointGroup {
    /// Takes a found name as an end, if all copies are there.
    fn find(&mut self, e: usize, t: Target, own: Option<usize>) -> Checked<()> {
        let there = own.map_or(t.count, |n| n as u64);
        let end = End { name: t.name, index: t.index.map(|i| i as i64), own: own.map(|n| n as i64) };
        if end.index.is_none() && there != 1 {
            let message = format!("names {there} of them");
            return Err(Wrong::new(message, format!("one, such as {}", t.one)));
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

pub(crate) fn frame(s: Option<&JointFrameSpec>) -> Checked<Pose> {
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
    /// A joint of a name, that looks as joints do.
    pub(crate) fn add_named(&mut self, name: &str, id: JointId) {
        self.names.entry(name.into()).or_default().push(id);
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
