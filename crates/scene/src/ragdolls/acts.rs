//! What the timeline asks of ragdolls: poses, limp bones, hands that hold.

use super::{RagdollGroup, RagdollNames};
use crate::bodies::{Census, Group, Names, Place, Target, Template};
use crate::error::{Checked, Under, Wrong};
use crate::joints::stiffness;
use crate::limits::SPIN_POSED_MAX;
use crate::plan::bounded;
use crate::shapes::{rotation, unknown};
use crate::spec::{BonesSpec, GrabSpec, OthersSpec, PoseSpec, StiffnessSpec};
use jounce::limits::FORCE_MAX;
use jounce::math::{Quat, Vec3};
use jounce::{BodyDesc, BodyKind, BonePose, PoseDrive, Ragdoll, Result, SpringDesc, World};

/// A pose to drive ragdolls to.
#[derive(Clone, Debug)]
pub(crate) struct Posing {
    poses: Vec<BonePose>,
    drive: PoseDrive,
    strengths: Vec<f32>,
    /// Is each bone named?
    named: Vec<bool>,
    others: OthersSpec,
}

impl Posing {
    /// Drives a ragdoll, or a part of it.
    pub(crate) fn put(&self, doll: &Ragdoll, world: &mut World) -> Result<()> {
        let drive = |doll: &Ragdoll, world: &mut World| {
            doll.drive(world, &self.poses, &self.drive, &self.strengths)
        };
        if self.others == OthersSpec::Rest {
            return drive(doll, world);
        }
        if self.others == OthersSpec::Limp {
            part(doll, |i| !self.named[i]).relax(world)?;
        }
        drive(&part(doll, |i| self.named[i]), world)
    }
}

/// A ragdoll of which only some joints are known.
fn part(doll: &Ragdoll, known: impl Fn(usize) -> bool) -> Ragdoll {
    let mut doll = doll.clone();
    let joints = doll.joints.iter_mut().enumerate();
    joints.filter(|(i, _)| !known(*i)).for_each(|(_, j)| *j = None);
    doll
}

fn spring_or(s: Option<&StiffnessSpec>, otherwise: SpringDesc) -> Checked<SpringDesc> {
    s.map_or(Ok(otherwise), stiffness).key("spring")
}

/// The ragdolls that a text names, and the entry that they are of.
pub(super) fn find<'a>(
    text: &str,
    names: &RagdollNames,
    all: &'a [RagdollGroup],
) -> Checked<(Target, usize, &'a RagdollGroup)> {
    let target = names.resolve(text).key("ragdoll")?;
    let entry = names.entry(&target);
    match all.get(entry) {
        Some(g) => Ok((target, entry, g)),
        None => Err(Wrong::new("there is no such ragdoll", "the name of a ragdoll").key("ragdoll")),
    }
}

/// The place of a bone of a name.
pub(super) fn find_bone(name: &str, g: &RagdollGroup) -> Checked<usize> {
    let known = g.desc.bones.iter().map(|o| o.name.as_str());
    g.desc.bone(name).ok_or_else(|| unknown("bone", name, known))
}

/// The same of a bone that hangs on another.
fn find_hanging(name: &str, g: &RagdollGroup) -> Checked<usize> {
    let i = find_bone(name, g)?;
    if g.desc.bones[i].joint.is_none() {
        let message = format!("\"{name}\" is a root, which hangs on no bone");
        return Err(Wrong::new(message, "a bone with a parent; `lead` leads roots"));
    }
    Ok(i)
}

/// Some bones, or all where there is no list.
pub(super) fn some_bones(
    list: Option<&Vec<String>>,
    g: &RagdollGroup,
    find: fn(&str, &RagdollGroup) -> Checked<usize>,
) -> Checked<Vec<bool>> {
    let Some(list) = list else { return Ok(vec![true; g.bones()]) };
    if list.is_empty() {
        return Err(Wrong::new("is empty", "names of bones; without `bones` all are meant").key("bones"));
    }
    let mut some = vec![false; g.bones()];
    for (n, name) in list.iter().enumerate() {
        some[find(name, g).index(n).key("bones")?] = true;
    }
    Ok(some)
}

/// Bones of ragdolls.
#[derive(Clone, Debug)]
pub(crate) struct Bones {
    pub target: Target,
    /// Is each bone meant?
    pub some: Vec<bool>,
}

impl Bones {
    /// Lets them go limp.
    pub(crate) fn relax(&self, doll: &Ragdoll, world: &mut World) -> Result<()> {
        part(doll, |i| self.some[i]).relax(world)
    }
}

/// The action `relax`.
pub(crate) fn relax(s: &BonesSpec, names: &RagdollNames, all: &[RagdollGroup]) -> Checked<Bones> {
    let (target, _, g) = find(&s.ragdoll, names, all)?;
    Ok(Bones { target, some: some_bones(s.bones.as_ref(), g, find_hanging)? })
}

/// The action `release`.
pub(crate) fn release(s: &BonesSpec, names: &RagdollNames, all: &[RagdollGroup]) -> Checked<Bones> {
    let (target, _, g) = find(&s.ragdoll, names, all)?;
    Ok(Bones { target, some: some_bones(s.bones.as_ref(), g, find_bone)? })
}

/// The action `pose`.
pub(crate) fn pose(s: &PoseSpec, names: &RagdollNames, all: &[RagdollGroup]) -> Checked<(Target, Posing)> {
    let (target, _, g) = find(&s.ragdoll, names, all)?;
    let strength = |v: Option<f32>| match v.unwrap_or(1.0) {
        v if (0.0..=1e6).contains(&v) => Ok(v),
        v => Err(Wrong::new(format!("is {v}"), "0 to 1e6").key("strength")),
    };
    let otherwise = PoseDrive::default();
    let drive = PoseDrive {
        spring: spring_or(s.spring.as_ref(), otherwise.spring)?,
        strength: strength(s.strength)?,
    };
    let others = s.others.unwrap_or(OthersSpec::Rest);
    if s.bones.0.is_empty() && others != OthersSpec::Rest {
        let expected = "`bones` beside it: those that are driven";
        return Err(Wrong::new("is given, and no bone is driven", expected).key("others"));
    }
    let rest: Vec<Quat> = g.desc.rest_poses().iter().map(|p| p.q).collect();
    let n = rest.len();
    let (mut turns, mut spins) = (vec![Quat::IDENTITY; n], vec![Vec3::ZERO; n]);
    let (mut strengths, mut named) = (vec![1.0; n], vec![false; n]);
    for (name, b) in &s.bones.0 {
        let told = |w: Wrong| w.key(name).key("bones");
        let i = find_hanging(name, g).map_err(told)?;
        turns[i] = rotation(b.rotation_deg, b.rotation).map_err(told)?;
        strengths[i] = strength(b.strength).map_err(told)?;
        let spin = b.angular_velocity.map_or(Ok(Vec3::ZERO), |w| bounded(w, SPIN_POSED_MAX, "rad/s"));
        spins[i] = spin.key("angular_velocity").map_err(told)?;
        named[i] = true;
    }
    let poses = g.desc.bones.iter().enumerate().map(|(i, b)| {
        let parent = b.joint.as_ref().map_or(Quat::IDENTITY, |j| rest[j.parent]);
        BonePose {
            rotation: parent.inverse_mul(turns[i] * rest[i]).normalize(),
            velocity: parent.inverse_rotate(spins[i]),
        }
    });
    Ok((target, Posing { poses: poses.collect(), drive, strengths, named, others }))
}

/// A hand to be.
#[derive(Clone, Debug)]
pub(crate) struct Hold {
    pub body: Target,
    pub point: Vec3,
    pub spring: SpringDesc,
    pub max_force: f32,
    /// The hand, as a group of bodies.
    pub hand: Group,
}

/// The action `grab`, made so many times; the hand gets its name.
pub(crate) fn grab(s: &GrabSpec, times: u64, census: &mut Census, names: &mut Names) -> Checked<Hold> {
    let mut hand = BodyDesc::kinematic();
    hand.name = Some(s.hand.clone());
    let hand = Group {
        name: Some(s.hand.clone()),
        templates: vec![Template { desc: hand, color: None }],
        places: vec![Place::HERE],
        single: times == 1,
    };
    hand.names(times)
        .and_then(|all| all.into_iter().try_for_each(|(n, b)| names.add(&n, b.of("hand"))))
        .map_err(|w| w.renamed("hand"))?;
    census.add(times, 0)?;
    census.joints(times)?;
    let p = s.point.unwrap_or([0.0; 3]);
    if p.iter().any(|x| x.abs() > 1e6) {
        return Err(Wrong::new(format!("is {p:?}"), "within ±1e6 m").key("point"));
    }
    let max_force = s.max_force.unwrap_or(f32::INFINITY);
    if !(max_force > 0.0 && (max_force <= FORCE_MAX || s.max_force.is_none())) {
        return Err(
            Wrong::new(format!("is {max_force}"), format!("above 0, to {FORCE_MAX:e} N")).key("max_force")
        );
    }
    Ok(Hold {
        body: Target { name: String::new(), index: None, count: 0, all: 0, one: String::new() },
        point: Vec3::from_array(p),
        spring: spring_or(s.spring.as_ref(), SpringDesc::hertz(5.0, 1.0))?,
        max_force,
        hand,
    })
}

/// Looks up whom a hand holds.
pub(crate) fn held(s: &GrabSpec, names: &Names) -> Checked<Target> {
    let target = names.resolve_only(&s.body, &[BodyKind::Dynamic], "a dynamic body").key("body")?;
    if target.count > 1 {
        let message = format!("names {} bodies", target.count);
        return Err(Wrong::new(message, format!("one, such as {}", target.one)).key("body"));
    }
    Ok(target)
}
