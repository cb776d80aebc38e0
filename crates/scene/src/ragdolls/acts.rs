//! What the timeline asks of ragdolls: poses, limp bones, hands that hold.

use super::{RagdollGroup, RagdollNames};
use crate::bodies::{Census, Group, Names, Place, Target, Template};
use crate::error::{Checked, Under, Wrong};
use crate::joints::stiffness;
use crate::limits::SPIN_POSED_MAX;
use crate::plan::bounded;
use crate::shapes::{rotation, unknown};
use crate::spec::{BonePoseSpec, BonesSpec, GrabSpec, OthersSpec, PoseSpec, StiffnessSpec};
use jounce::limits::FORCE_MAX;
use jounce::math::{Quat, Vec3};
use jounce::{BodyDesc, BodyKind, BonePose, PoseDrive, Ragdoll, Result, SpringDesc, World};

/// A pose to drive ragdolls to.
#[derive(Clone, Debug)]
pub(crate) struct Posing {
    pub target: Target,
    /// Which of the scene's entries the ragdolls are of.
    pub entry: usize,
    drive: PoseDrive,
    bones: Vec<BoneAim>,
    others: OthersSpec,
}

/// Where a bone is to be, and how fast, about the ragdoll's axes at rest; with a factor on the strength.
#[derive(Clone, Copy, Debug)]
struct BoneAim {
    bone: usize,
    turn: Quat,
    spin: Vec3,
    strength: f32,
}

impl Posing {
    /// Drives a ragdoll, or a part of it.
    pub(crate) fn put(&self, g: &RagdollGroup, doll: &Ragdoll, world: &mut World) -> Result<()> {
        let rest: Vec<Quat> = g.desc.rest_poses().iter().map(|p| p.q).collect();
        let mut aims: Vec<BoneAim> = (0..rest.len())
            .map(|bone| BoneAim { bone, turn: Quat::IDENTITY, spin: Vec3::ZERO, strength: 1.0 })
            .collect();
        let mut named = vec![self.others == OthersSpec::Rest; rest.len()];
        for aim in &self.bones {
            (aims[aim.bone], named[aim.bone]) = (*aim, true);
        }
        let pose = |aim: &BoneAim| {
            let joint = g.desc.bones[aim.bone].joint.as_ref();
            let parent = joint.map_or(Quat::IDENTITY, |j| rest[j.parent]);
            let rotation = parent.inverse_mul(aim.turn * rest[aim.bone]).normalize();
            BonePose { rotation, velocity: parent.inverse_rotate(aim.spin) }
        };
        let poses: Vec<BonePose> = aims.iter().map(pose).collect();
        let strengths: Vec<f32> = aims.iter().map(|a| a.strength).collect();
        if self.others == OthersSpec::Limp {
            part(doll, |i| !named[i]).relax(world)?;
        }
        part(doll, |i| named[i]).drive(world, &poses, &self.drive, &strengths)
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

/// Some bones, in order, or all where there is no list.
#[derive(Clone, Debug)]
pub(crate) struct BoneList(Option<Vec<usize>>);

impl BoneList {
    pub(crate) fn has(&self, bone: usize) -> bool {
        self.0.as_ref().is_none_or(|some| some.binary_search(&bone).is_ok())
    }
}

/// Looks up the bones of a list.
pub(super) fn some_bones(
    list: Option<&Vec<String>>,
    g: &RagdollGroup,
    find: fn(&str, &RagdollGroup) -> Checked<usize>,
) -> Checked<BoneList> {
    let Some(list) = list else { return Ok(BoneList(None)) };
    if list.is_empty() {
        return Err(Wrong::new("is empty", "names of bones; without `bones` all are meant").key("bones"));
    }
    let mut some = Vec::with_capacity(list.len());
    for (n, name) in list.iter().enumerate() {
        some.push(find(name, g).index(n).key("bones")?);
    }
    some.sort_unstable();
    Ok(BoneList(Some(some)))
}

/// Bones of ragdolls.
#[derive(Clone, Debug)]
pub(crate) struct Bones {
    pub target: Target,
    pub some: BoneList,
}

impl Bones {
    /// Lets them go limp.
    pub(crate) fn relax(&self, doll: &Ragdoll, world: &mut World) -> Result<()> {
        part(doll, |i| self.some.has(i)).relax(world)
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
pub(crate) fn pose(s: &PoseSpec, names: &RagdollNames, all: &[RagdollGroup]) -> Checked<Posing> {
    let (target, entry, g) = find(&s.ragdoll, names, all)?;
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
    let aim = |name: &str, b: &BonePoseSpec| {
        let spin = b.angular_velocity.map_or(Ok(Vec3::ZERO), |w| bounded(w, SPIN_POSED_MAX, "rad/s"));
        Ok(BoneAim {
            bone: find_hanging(name, g)?,
            turn: rotation(b.rotation_deg, b.rotation)?,
            spin: spin.key("angular_velocity")?,
            strength: strength(b.strength)?,
        })
    };
    let bones = s.bones.0.iter().map(|(name, b)| aim(name, b).key(name).key("bones"));
    Ok(Posing { target, entry, drive, bones: bones.collect::<Checked<_>>()?, others })
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
