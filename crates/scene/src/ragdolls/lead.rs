//! Bones led along an animation.
//!
//! A pose of a skeleton is the turn of each bone against its parent, and the place and turn of each root. Between two poses turns go
//! at a constant rate and roots straight; the anchors of every joint meet, so limbs keep their lengths. On the way from where physics
//! left the bones, what their anchors gaped there is taken back evenly: both ends are exact.

use super::acts::{BoneList, find, find_bone, some_bones};
use super::{RagdollGroup, RagdollNames};
use crate::bodies::Target;
use crate::error::{Checked, Under, Wrong};
use crate::plan::{step_at, time, world_point};
use crate::shapes::rotation;
use crate::spec::{BoneTurnSpec, LeadKeySpec, LeadSpec, Map};
use jounce::math::{DVec3, Pose, Quat, Vec3, WorldPose};
use jounce::{BodyId, BodyKind, BoneDesc, Command, Ragdoll, World};
use std::sync::Arc;

/// An animation to be led along.
#[derive(Clone, Debug)]
pub(crate) struct Leading {
    pub target: Target,
    /// Which of the scene's entries the ragdolls are of.
    pub entry: usize,
    led: BoneList,
    here: bool,
    keys: Vec<Key>,
}

#[derive(Clone, Debug)]
struct Key {
    at: f64,
    position: Option<DVec3>,
    rotation: Option<Quat>,
    /// Bones that are not as at rest.
    turns: Vec<(usize, Quat)>,
}

impl Leading {
    /// How long it takes, s.
    pub(crate) fn lasts(&self) -> f64 {
        self.keys.last().map_or(0.0, |k| k.at)
    }
}

/// The action `lead`.
pub(crate) fn lead(s: &LeadSpec, names: &RagdollNames, all: &[RagdollGroup]) -> Checked<Leading> {
    let (target, entry, g) = find(&s.ragdoll, names, all)?;
    let led = some_bones(s.bones.as_ref(), g, find_bone)?;
    if s.keys.is_empty() {
        return Err(Wrong::new("is empty", "at least one key: when, and where to").key("keys"));
    }
    let mut keys: Vec<Key> = Vec::with_capacity(s.keys.len());
    for (n, k) in s.keys.iter().enumerate() {
        let before = keys.last().map_or(0.0, |k| k.at);
        keys.push(key(k, n, before, g).index(n).key("keys")?);
    }
    Ok(Leading { target, entry, led, here: s.here.unwrap_or(false), keys })
}

fn key(k: &LeadKeySpec, n: usize, before: f64, g: &RagdollGroup) -> Checked<Key> {
    let at = time(k.at).key("at")?;
    if at <= before {
        let expected = match n {
            0 => "more than 0: seconds after the action begins".into(),
            _ => format!("more than {before}, the time of the key before"),
        };
        return Err(Wrong::new(format!("is {at}"), expected).key("at"));
    }
    let turned = k.rotation_deg.is_some() || k.rotation.is_some();
    let turn = rotation(k.rotation_deg, k.rotation)?;
    Ok(Key {
        at,
        position: k.position.map(world_point).transpose().key("position")?,
        rotation: turned.then_some(turn),
        turns: turns(&k.bones, g).key("bones")?,
    })
}

fn turns(all: &Map<BoneTurnSpec>, g: &RagdollGroup) -> Checked<Vec<(usize, Quat)>> {
    let turn = |(name, b): &(String, BoneTurnSpec)| {
        let found = find_bone(name, g).and_then(|i| Ok((i, rotation(b.rotation_deg, b.rotation)?)));
        found.key(name)
    };
    all.0.iter().map(turn).collect()
}

/// A pose of a skeleton, bone by bone.
#[derive(Clone, Debug)]
struct Figure {
    /// Against the parent; of a root in the world.
    turns: Vec<Quat>,
    /// Of roots in the world, m.
    roots: Vec<DVec3>,
}

/// Where a bone is whose parent is there: the anchors meet.
fn hung(parent: &WorldPose, turn: Quat, on_parent: &Pose, on_bone: &Pose) -> WorldPose {
    let q = (parent.q * turn).normalize();
    WorldPose::new(parent.transform_point(on_parent.p) - q.rotate(on_bone.p).as_dvec3(), q)
}

impl Figure {
    /// At rest in a frame, turned as a key says.
    fn of_key(g: &RagdollGroup, key: &Key, frame: &WorldPose) -> Self {
        let rest = g.desc.rest_poses();
        let mut turned: Vec<Quat> = rest.iter().map(|p| p.q).collect();
        for (i, turn) in &key.turns {
            turned[*i] = *turn * rest[*i].q;
        }
        let turn = |(i, b): (usize, &BoneDesc)| match &b.joint {
            Some(j) => rest[j.parent].q.inverse_mul(turned[i]).normalize(),
            None => (frame.q * turned[i]).normalize(),
        };
        let turns = g.desc.bones.iter().enumerate().map(turn).collect();
        Self { turns, roots: rest.iter().map(|p| frame.transform_point(p.p)).collect() }
    }

    /// As the bones stand; one that is gone stands as in `otherwise`.
    fn of_bones(g: &RagdollGroup, there: &[Option<WorldPose>], otherwise: &Self) -> Self {
        let turn = |(i, b): (usize, &BoneDesc)| {
            let parent = b.joint.as_ref().map_or(Some(Quat::IDENTITY), |j| Some(there[j.parent]?.q));
            match (parent, there[i]) {
                (Some(parent), Some(own)) => parent.inverse_mul(own.q).normalize(),
                _ => otherwise.turns[i],
            }
        };
        let turns = g.desc.bones.iter().enumerate().map(turn).collect();
        let root = |(p, o): (&Option<WorldPose>, &DVec3)| p.map_or(*o, |p| p.p);
        Self { turns, roots: there.iter().zip(&otherwise.roots).map(root).collect() }
    }

    fn mix(&self, to: &Self, part: f64) -> Self {
        let turns = self.turns.iter().zip(&to.turns).map(|(a, b)| turn_between(*a, *b, part));
        let roots = self.roots.iter().zip(&to.roots).map(|(a, b)| *a + (*b - *a) * part);
        if part >= 1.0 { to.clone() } else { Self { turns: turns.collect(), roots: roots.collect() } }
    }

    fn poses(&self, bones: &[BoneDesc]) -> Vec<WorldPose> {
        let mut poses: Vec<WorldPose> = Vec::with_capacity(bones.len());
        for (i, b) in bones.iter().enumerate() {
            poses.push(match &b.joint {
                Some(j) => hung(&poses[j.parent], self.turns[i], &j.on_parent, &j.on_bone),
                None => WorldPose::new(self.roots[i], self.turns[i]),
            });
        }
        poses
    }
}

/// The rotation a part of the way, at a constant rate.
pub(crate) fn turn_between(from: Quat, to: Quat, part: f64) -> Quat {
    let mut turn = to * from.conjugate();
    if turn.w < 0.0 {
        turn = Quat::new(-turn.x, -turn.y, -turn.z, -turn.w);
    }
    let axis: Vec3 = turn.xyz().normalize_or(Vec3::Y);
    let q = Quat::from_axis_angle(axis, turn.angle() * part as f32) * from;
    if part >= 1.0 { to } else { q.normalize() }
}

/// A ragdoll that is being led.
#[derive(Clone, Debug)]
pub(crate) struct Led {
    way: Arc<Leading>,
    /// Its number of all of its entry.
    copy: usize,
    /// Those of its bones that it leads.
    pub bones: Vec<(usize, BodyId)>,
    from_step: u64,
    pub until: u64,
    /// Steps to each key.
    steps: Vec<u64>,
    from: Figure,
    /// How many of those that are meant are gone.
    pub lost: usize,
    /// Where the first bone was, with `here`.
    root: Option<DVec3>,
    /// How far each bone was from where its anchors meet, m.
    gaps: Vec<Vec3>,
}

impl Led {
    /// A ragdoll's way begins where it is; none where nothing of it is left to be led, or nothing to count from.
    pub(crate) fn start(
        way: &Arc<Leading>,
        g: &RagdollGroup,
        (copy, doll): (usize, &Ragdoll),
        world: &World,
        (now, rate_hz): (u64, f64),
    ) -> Option<Self> {
        let there: Vec<Option<WorldPose>> =
            doll.bodies.iter().map(|b| world.body(*b).ok().map(|b| b.pose())).collect();
        let mut bones: Vec<(usize, BodyId)> = doll.bodies.iter().copied().enumerate().collect();
        bones.retain(|(i, _)| way.led.has(*i));
        let meant = bones.len();
        bones.retain(|(i, _)| there[*i].is_some());
        if bones.is_empty() || (way.here && there[0].is_none()) {
            return None;
        }
        let root = there[0].filter(|_| way.here).map(|p| p.p);
        let frame = frame(g, &way.keys[0], copy, root);
        let from = Figure::of_bones(g, &there, &Figure::of_key(g, &way.keys[0], &frame));
        let hung = from.poses(&g.desc.bones);
        let gap = |(is, hung): (&Option<WorldPose>, &WorldPose)| {
            is.map_or(Vec3::ZERO, |is| (is.p - hung.p).as_vec3())
        };
        let gaps = there.iter().zip(&hung).map(gap).collect();
        let steps: Vec<u64> = way.keys.iter().map(|k| step_at(k.at, rate_hz).max(1)).collect();
        let until = now + steps.last().copied().unwrap_or(1);
        Some(Self {
            way: Arc::clone(way),
            copy,
            lost: meant - bones.len(),
            bones,
            from_step: now,
            until,
            steps,
            from,
            root,
            gaps,
        })
    }

    /// Which of the scene's entries it is of.
    pub(crate) fn entry(&self) -> usize {
        self.way.entry
    }

    /// What takes it on its way within the next step.
    pub(crate) fn go_on(&self, g: &RagdollGroup, world: &World, now: u64) -> Vec<Command> {
        let (next, keys) = (now + 1 - self.from_step, &self.way.keys);
        let figure = |k: usize| Figure::of_key(g, &keys[k], &frame(g, &keys[k], self.copy, self.root));
        // Of keys within one step the last counts.
        let to = self.steps.iter().copied().find(|s| *s >= next).unwrap_or(next);
        let last = self.steps.iter().rposition(|s| *s <= to).unwrap_or(0);
        let (from, begins) = match self.steps.iter().rposition(|s| *s < next) {
            Some(k) => (figure(k), self.steps[k]),
            None => (self.from.clone(), 0),
        };
        let part = (next - begins) as f64 / (to - begins) as f64;
        let mut poses = from.mix(&figure(last), part).poses(&g.desc.bones);
        if begins == 0 && part < 1.0 {
            let left = (1.0 - part) as f32;
            poses.iter_mut().zip(&self.gaps).for_each(|(p, gap)| p.p += (*gap * left).as_dvec3());
        }
        let led = self.bones.iter().filter(|(_, b)| is_led(world, *b));
        led.map(|(i, b)| Command::MoveTo(*b, poses[*i].p, poses[*i].q)).collect()
    }
}

/// Is the bone there, and led?
pub(crate) fn is_led(world: &World, bone: BodyId) -> bool {
    world.body(bone).is_ok_and(|b| b.kind() == BodyKind::Kinematic)
}

/// Where a key puts a ragdoll's frame; `root` is what `here` counts from.
fn frame(g: &RagdollGroup, key: &Key, copy: usize, root: Option<DVec3>) -> WorldPose {
    let place = &g.places[copy % g.places.len()];
    let q = (place.rotation * key.rotation.unwrap_or(g.desc.rotation)).normalize();
    let mut p = key.position.unwrap_or(g.desc.position) + place.position;
    if let Some(root) = root {
        let own = q.rotate(g.desc.rest_poses()[0].p).as_dvec3();
        let by = key.position.unwrap_or(DVec3::ZERO);
        (p.x, p.z) = (root.x - own.x + by.x, root.z - own.z + by.z);
    }
    WorldPose::new(p, q)
}
