//! Ragdolls of a scene file: their bones, checked, the poses that drive them, the ways they are led, and hands that hold bodies.

mod acts;
mod lead;

use crate::bodies::{
    Bearers, Census, Group, Place, Target, Template, check_name, color, grid, masses, resolve_name,
};
use crate::error::{Checked, Under, Wrong};
use crate::joints::{JointNames, frame, stiffness};
use crate::plan::Named;
use crate::shapes::{Library, rotation, unknown};
use crate::spec::{BoneJointSpec, BoneSpec, RagdollPresetSpec, RagdollSpec};
pub(crate) use acts::{Bones, Hold, Posing, grab, held, pose, relax, release};
use jounce::limits::BONES_MAX;
use jounce::math::{DVec3, Pose, Vec3};
use jounce::{BodyDesc, BoneDesc, BoneJoint, BoneJointKind, Ragdoll, RagdollDesc, ShapeDesc, World};
pub(crate) use lead::{Leading, Led, is_led, lead, turn_between};
use std::collections::BTreeMap;

/// One entry: a ragdoll, or copies of it.
#[derive(Clone, Debug)]
pub(crate) struct RagdollGroup {
    pub name: Option<String>,
    pub single: bool,
    desc: RagdollDesc,
    /// The group of copy 0; each further copy has the next lower one.
    collision_group: i32,
    places: Vec<Place>,
    /// The bodies as a group: a template for each bone, in turn. Its names are "doll" and "doll.head".
    pub bodies: Group,
}

impl RagdollGroup {
    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }
    pub(crate) fn bones(&self) -> usize {
        self.desc.bones.len()
    }
    /// Joints of all copies.
    pub(crate) fn joints(&self) -> usize {
        self.len() * self.desc.bones.iter().filter(|b| b.joint.is_some()).count()
    }
    /// Ragdoll `n` of all that are made, its bones named as the bodies are.
    pub(crate) fn ragdoll(&self, n: usize) -> RagdollDesc {
        let (place, mut d) = (&self.places[n % self.places.len()], self.desc.clone());
        d.position += place.position;
        d.rotation = (place.rotation * d.rotation).normalize();
        d.velocity += place.velocity;
        d.group = self.collision_group - n as i32;
        for b in &mut d.bones {
            let own = joint_name(self.name.as_deref(), &b.name).unwrap_or_else(|| b.name.clone());
            b.name = if self.single { own } else { format!("{own}[{n}]") };
        }
        d
    }
    /// What a bone of a name is.
    pub(crate) fn desc_of(&self, t: &Target) -> Option<BodyDesc> {
        let bone = match self.name.as_ref()? == &t.name {
            true => Some(t.index.unwrap_or(0) % self.bones()),
            false => (0..self.bones()).find(|&i| self.bone_name(i).as_ref() == Some(&t.name)),
        };
        let mut desc = BodyDesc::dynamic();
        desc.shapes.clone_from(&self.desc.bones[bone?].shapes);
        Some(desc)
    }
    /// "doll.head", for bone `i`.
    pub(crate) fn bone_name(&self, i: usize) -> Option<String> {
        joint_name(self.name.as_deref(), &self.desc.bones[i].name)
    }
}

fn joint_name(doll: Option<&str>, bone: &str) -> Option<String> {
    doll.map(|d| format!("{d}.{bone}"))
}

/// Names of ragdolls: how many bear each, and which entry they are of.
#[derive(Clone, Debug, Default)]
pub(crate) struct RagdollNames {
    all: BTreeMap<String, (u64, usize)>,
    /// How many groups of their own were given.
    groups: i32,
}

impl RagdollNames {
    /// The ragdolls that a text names: `name` (all of them) or `name[n]`.
    pub(crate) fn resolve(&self, text: &str) -> Checked<Target> {
        let known = self.all.keys().map(String::as_str);
        resolve_name("ragdoll", text, known, |name| self.all.get(name).map(|r| r.0))
    }
    fn entry(&self, t: &Target) -> usize {
        self.all.get(&t.name).map_or(0, |r| r.1)
    }
}

/// The ragdolls of a scene, by name.
#[derive(Clone, Debug, Default)]
pub(crate) struct RagdollRecords {
    names: BTreeMap<String, Vec<Ragdoll>>,
}

impl RagdollRecords {
    pub(crate) fn add(&mut self, name: Option<&String>, doll: Ragdoll) {
        if let Some(name) = name {
            self.names.entry(name.clone()).or_default().push(doll);
        }
    }
    /// The ragdolls of a target; some of their bones may be removed by now.
    pub(crate) fn of(&self, target: &Target) -> &[Ragdoll] {
        let all = self.names.get(&target.name).map_or(&[][..], Vec::as_slice);
        match target.index {
            None => all,
            Some(i) => all.get(i..=i).unwrap_or(&[]),
        }
    }
}

/// Entries of `ragdolls`, each made so many times. Their bodies and joints get their names.
pub(crate) fn ragdolls(
    all: &[RagdollSpec],
    times: u64,
    library: &mut Library,
    census: &mut Census,
    named: &mut Named<'_>,
    (out, ragdoll_names): &mut (Vec<RagdollGroup>, RagdollNames),
) -> Checked<()> {
    for (i, r) in all.iter().enumerate() {
        let mut g = entry(r, library, census).index(i).key("ragdolls")?;
        g.single &= times == 1;
        let more = (times - 1).saturating_mul(g.len() as u64);
        let shapes = g.desc.bones.iter().map(|b| b.shapes.len() as u64).sum::<u64>();
        let bones = g.bones() as u64;
        census.add(more.saturating_mul(bones), shapes.div_ceil(bones)).index(i).key("ragdolls")?;
        census.joints(more.saturating_mul((g.joints() / g.len().max(1)) as u64)).index(i).key("ragdolls")?;
        // Groups of their own begin where no scene's own are likely to be.
        g.collision_group = r.group.unwrap_or(-1_000_000 - ragdoll_names.groups);
        ragdoll_names.groups += g.len() as i32 * times as i32;
        if let Some(name) = &g.name {
            let all = g.len() as u64 * times;
            let first = g.bone_name(0).map(|b| if all > 1 { format!("{b}[0]") } else { b });
            let bearers = |n: &str, b: Bearers| match &first {
                Some(first) if n == name => b.of("ragdoll").one(first.clone()),
                _ => b.of("bone of a ragdoll"),
            };
            let bodies = g.bodies.names(times);
            bodies
                .and_then(|n| n.into_iter().try_for_each(|(n, b)| named.bodies.add(&n, bearers(&n, b))))
                .and_then(|()| name_joints(&g, name, times, named.joints))
                .index(i)
                .key("ragdolls")?;
            ragdoll_names.all.insert(name.clone(), (g.len() as u64 * times, out.len()));
        }
        out.push(g);
    }
    Ok(())
}

fn name_joints(g: &RagdollGroup, name: &str, times: u64, joints: &mut JointNames) -> Checked<()> {
    let n = g.len() as u64 * times;
    let jointed: Vec<_> = g.desc.bones.iter().filter_map(|b| Some((&b.name, b.joint.as_ref()?))).collect();
    for (bone, j) in &jointed {
        let kind = match j.kind {
            BoneJointKind::Ball { .. } => "ball",
            BoneJointKind::Hinge { .. } => "hinge",
            BoneJointKind::Fixed => "fixed",
        };
        joints.add_named(&format!("{name}.{bone}"), n, kind)?;
    }
    joints.add_named(name, n * jointed.len() as u64, "ragdoll")?;
    if let Some((bone, _)) = jointed.first() {
        joints.call_one(name, if n > 1 { format!("{name}.{bone}[0]") } else { format!("{name}.{bone}") });
    }
    Ok(())
}

fn entry(r: &RagdollSpec, library: &mut Library, census: &mut Census) -> Checked<RagdollGroup> {
    let mut d = match (r.preset, r.bones.is_empty()) {
        (Some(RagdollPresetSpec::Human), true) => RagdollDesc::human(),
        (None, false) => RagdollDesc::new(bones(&r.bones, library).key("bones")?),
        (Some(_), false) => {
            return Err(Wrong::new("is given beside `preset`", "bones or a preset, not both").key("bones"));
        }
        (None, true) => return Err(Wrong::new("the ragdoll has no bones", "`preset` or `bones`")),
    };
    if let Some(name) = &r.name {
        check_name(name)?;
        if name.contains('.') {
            let (plain, bone) = (name.replace('.', "_"), d.bones.first().map_or("", |b| &b.name));
            let expected =
                format!("a name without dots: a dot parts it from the name of a bone, as in {plain}.{bone}");
            return Err(Wrong::new(format!("is {name:?}"), expected).key("name"));
        }
        let longest = d.bones.iter().map(|b| b.name.len()).max().unwrap_or(0);
        check_name(&format!("{name}.{}", "x".repeat(longest)))?;
    }
    d.position = DVec3::from_array(r.position.unwrap_or([0.0; 3]));
    d.rotation = rotation(r.rotation_deg, r.rotation)?;
    d.velocity = Vec3::from_array(r.velocity.unwrap_or([0.0; 3]));
    d.close_gaps = r.close_gaps.unwrap_or(true);
    if r.self_collision == Some(false) {
        d = d.never_meets_itself();
    }
    if let Some(g) = r.group.filter(|g| !(-1_000_000_000..0).contains(g)) {
        return Err(Wrong::new(format!("is {g}"), "a negative group, to -1e9").key("group"));
    }
    d.group = r.group.unwrap_or(-1);
    d.check()?;
    // The engine looks at all of it once.
    let mut world = World::new(jounce::WorldDesc::default())?;
    world.add_ragdoll(&d)?;
    let shapes = d.bones.iter().map(|b| b.shapes.len() as u64).sum::<u64>();
    let (bones, jointed) =
        (d.bones.len() as u64, d.bones.iter().filter(|b| b.joint.is_some()).count() as u64);
    let places = match &r.repeat {
        None => vec![Place::HERE],
        // Counted below, with all bones.
        Some(rep) => grid(rep, 1, &mut Census::default()).key("repeat")?,
    };
    let copies = places.len() as u64;
    census.add(copies * bones, shapes.div_ceil(bones))?;
    census.joints(copies * jointed)?;
    let color = r.color.as_deref().map(color).transpose().key("color")?;
    let templates = d
        .bones
        .iter()
        .map(|b| {
            let mut desc = BodyDesc::dynamic();
            desc.name = joint_name(r.name.as_deref(), &b.name);
            Template { desc, color }
        })
        .collect();
    let all = vec![Place::HERE; places.len() * d.bones.len()];
    let bodies = Group { name: r.name.clone(), templates, places: all, single: false };
    Ok(RagdollGroup {
        name: r.name.clone(),
        single: r.repeat.is_none(),
        desc: d,
        collision_group: 0,
        places,
        bodies,
    })
}

fn bones(all: &[BoneSpec], library: &mut Library) -> Checked<Vec<BoneDesc>> {
    if all.len() > BONES_MAX {
        return Err(Wrong::new(format!("has {} bones", all.len()), format!("at most {BONES_MAX}")));
    }
    let mut out: Vec<BoneDesc> = Vec::with_capacity(all.len());
    for (i, b) in all.iter().enumerate() {
        out.push(bone(b, &out, all, library).index(i)?);
    }
    Ok(out)
}

fn bone(b: &BoneSpec, before: &[BoneDesc], all: &[BoneSpec], library: &mut Library) -> Checked<BoneDesc> {
    let plain = !b.name.is_empty() && b.name.len() <= 64 && !b.name.contains(['[', ']', '.']);
    if !plain {
        let expected = "1 to 64 bytes without dots and square brackets";
        return Err(Wrong::new(format!("is {:?}", b.name), expected).key("name"));
    }
    if before.iter().any(|o| o.name == b.name) {
        let message = format!("\"{}\" is given to two bones", b.name);
        return Err(Wrong::new(message, "a name of its own").key("name"));
    }
    let p = b.position.unwrap_or([0.0; 3]);
    if p.iter().any(|x| x.abs() > 1e6) {
        return Err(Wrong::new(format!("is {p:?}"), "within ±1e6 m").key("position"));
    }
    let mut shapes: Vec<ShapeDesc> = Vec::with_capacity(b.shapes.len());
    for (i, s) in b.shapes.iter().enumerate() {
        let built = library.shape(s).and_then(|shape| {
            BodyDesc::dynamic().shape(shape.clone()).check()?;
            Ok(shape)
        });
        shapes.push(built.index(i).key("shapes")?);
    }
    if shapes.is_empty() {
        return Err(Wrong::new("the bone has no shapes", "at least one, with mass or density").key("shapes"));
    }
    if masses(&shapes).iter().all(|m| *m <= 0.0) {
        let expected = "a shape that is no sensor, with density or mass above 0";
        return Err(Wrong::new("the bone has no mass", expected).key("shapes"));
    }
    let joint = match (&b.parent, &b.joint) {
        (None, None) => None,
        (Some(name), Some(j)) => {
            let known = before.iter().map(|o| o.name.as_str());
            let Some(parent) = before.iter().position(|o| o.name == *name) else {
                let expected = "parents before their children in the list";
                if *name == b.name {
                    return Err(Wrong::new(format!("\"{name}\" is the bone itself"), expected).key("parent"));
                }
                if all.iter().any(|o| o.name == *name) {
                    let message = format!("\"{name}\" comes after this bone");
                    return Err(Wrong::new(message, expected).key("parent"));
                }
                return Err(unknown("bone", name, known).key("parent"));
            };
            Some(bone_joint(j, parent).key("joint")?)
        }
        (Some(_), None) => {
            return Err(Wrong::new("is given without `joint`", "how the bone hangs on it").key("parent"));
        }
        (None, Some(_)) => {
            return Err(
                Wrong::new("is given without `parent`", "the bone that this one hangs on").key("joint")
            );
        }
    };
    Ok(BoneDesc {
        name: b.name.clone(),
        rest: Pose::new(Vec3::from_array(p), rotation(b.rotation_deg, b.rotation)?),
        shapes,
        meets_group: b.meets_group.unwrap_or(true),
        joint,
    })
}

fn bone_joint(j: &BoneJointSpec, parent: usize) -> Checked<BoneJoint> {
    let radians = |deg: f32, key: &str| {
        if deg.abs() <= 180.0 {
            return Ok(deg.to_radians());
        }
        Err(Wrong::new(format!("is {deg}"), "within ±180 degrees").key(key))
    };
    let ends = |deg: [f32; 2], key: &str| {
        if deg[0] > deg[1] {
            return Err(Wrong::new(format!("is {deg:?}"), "the least angle, then the largest").key(key));
        }
        Ok([radians(deg[0], key)?, radians(deg[1], key)?])
    };
    let kind = match (&j.ball, &j.hinge, &j.fixed) {
        (Some(b), None, None) => {
            if !(0.0..=180.0).contains(&b.cone_deg) {
                let wrong = Wrong::new(format!("is {}", b.cone_deg), "0 to 180 degrees");
                return Err(wrong.key("cone_deg").key("ball"));
            }
            let twist = ends(b.twist_deg, "twist_deg").key("ball")?;
            BoneJointKind::Ball { cone: b.cone_deg.to_radians(), twist }
        }
        (None, Some(h), None) => BoneJointKind::Hinge { range: ends(h.range_deg, "range_deg").key("hinge")? },
        (None, None, Some(_)) => BoneJointKind::Fixed,
        _ => return Err(Wrong::new("the joint has no clear kind", "exactly one of ball, hinge, fixed")),
    };
    let torque = |v: Option<f32>, otherwise: f32, key: &str| {
        let v = v.unwrap_or(otherwise);
        if !(0.0..=1e12).contains(&v) {
            return Err(Wrong::new(format!("is {v}"), "0 to 1e12 N m").key(key));
        }
        Ok(v)
    };
    Ok(BoneJoint {
        parent,
        on_parent: frame(Some(&j.on_parent)).key("on_parent")?,
        on_bone: frame(Some(&j.on_bone)).key("on_bone")?,
        kind,
        friction: torque(j.friction, 0.0, "friction")?,
        rest_spring: j.rest_spring.as_ref().map(stiffness).transpose().key("rest_spring")?,
        strength: torque(j.strength, 100.0, "strength")?,
    })
}
