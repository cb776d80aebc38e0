//! What users write to make a ragdoll, and how it is made.

use crate::error::{Error, Result, check};
use crate::handle::{BodyId, JointId};
use crate::limits;
use crate::room::contacts::desc::{MassSpec, ShapeDesc};
use crate::room::joints::desc::{
    AxisDesc, BallDesc, BallMotor, JointDesc, JointFrames, JointKind, LimitDesc, MotorDesc, MotorTarget,
    SpringDesc,
};
use crate::room::rigid::desc::{BodyDesc, check_position, check_rotation};
use crate::world::World;
use jounce_math::{DVec3, Pose, Quat, Vec3, WorldPose};
use jounce_tasks::FloatEnv;

/// How a bone turns against its parent. The joint's axis is the x axis of its frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoneJointKind {
    /// Swings within a cone and twists between two angles, rad.
    Ball {
        /// Largest angle between the two x axes, 0 to π.
        cone: f32,
        /// Least and largest twist, within ±π.
        twist: [f32; 2],
    },
    /// Turns about x between two angles, rad.
    Hinge {
        /// Least and largest angle.
        range: [f32; 2],
    },
    /// Does not turn.
    Fixed,
}

/// How a bone hangs on its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct BoneJoint {
    /// Place of the parent in the list of bones: before the bone itself.
    pub parent: usize,
    /// The joint's frame on the parent, in its own frame, m.
    pub on_parent: Pose,
    /// The joint's frame on the bone, in its own frame, m.
    pub on_bone: Pose,
    /// How it turns.
    pub kind: BoneJointKind,
    /// Dry friction about each axis, N m.
    pub friction: f32,
    /// A spring that pulls the two frames together while the bone is not driven.
    pub rest_spring: Option<SpringDesc>,
    /// Most torque of the spring and of pose matching about each axis, N m.
    pub strength: f32,
}

/// One bone.
#[derive(Clone, Debug)]
pub struct BoneDesc {
    /// Its name; also that of its body.
    pub name: String,
    /// Where it is at rest, in the ragdoll's frame, m.
    pub rest: Pose,
    /// Its shapes, with mass or density; one of them at least weighs something.
    pub shapes: Vec<ShapeDesc>,
    /// May meet those bones of the same ragdoll that do not hang on it. Two bones for which this is false never meet
    /// ([`RagdollDesc::group`]).
    pub meets_group: bool,
    /// How it hangs on its parent; `None` for a root.
    pub joint: Option<BoneJoint>,
}

/// Describes a ragdoll.
#[derive(Clone, Debug)]
pub struct RagdollDesc {
    /// The bones, parents before children, at most [`limits::BONES_MAX`].
    pub bones: Vec<BoneDesc>,
    /// Where its frame is in the world, m.
    pub position: DVec3,
    /// How it is turned.
    pub rotation: Quat,
    /// Velocity of all bones, m/s.
    pub velocity: Vec3,
    /// Collision group of the bones that do not meet each other: negative, and its own for each ragdoll that should meet the
    /// others with these bones; 0 for none.
    pub group: i32,
    /// Moves children, at rest, so that the two anchors of each joint meet. Default true: anchors that are apart are pulled
    /// together in the first step, and bones take that as speed.
    pub close_gaps: bool,
}

/// A ragdoll of a world: its handles, in the order of the description's bones.
#[derive(Clone, Debug, PartialEq)]
pub struct Ragdoll {
    /// Bodies of the bones.
    pub bodies: Vec<BodyId>,
    /// Their joints to their parents.
    pub joints: Vec<Option<JointId>>,
    /// What is known of each joint.
    pub(crate) links: Vec<Option<BoneJoint>>,
}

impl RagdollDesc {
    /// These bones at the origin.
    pub fn new(bones: Vec<BoneDesc>) -> Self {
        Self {
            bones,
            position: DVec3::ZERO,
            rotation: Quat::IDENTITY,
            velocity: Vec3::ZERO,
            group: 0,
            close_gaps: true,
        }
    }
    /// Sets the position, m.
    pub fn at(mut self, position: impl Into<DVec3>) -> Self {
        self.position = position.into();
        self
    }
    /// Sets the rotation.
    pub fn rotated(mut self, rotation: Quat) -> Self {
        self.rotation = rotation;
        self
    }
    /// Sets the velocity, m/s.
    pub fn velocity(mut self, velocity: impl Into<Vec3>) -> Self {
        self.velocity = velocity.into();
        self
    }
    /// Sets the collision group, negative.
    pub fn group(mut self, group: i32) -> Self {
        self.group = group;
        self
    }
    /// No two bones of the ragdoll meet.
    pub fn never_meets_itself(mut self) -> Self {
        self.bones.iter_mut().for_each(|b| b.meets_group = false);
        self
    }
    /// Place of a bone by its name.
    pub fn bone(&self, name: &str) -> Option<usize> {
        self.bones.iter().position(|b| b.name == name)
    }

    /// Refuses what no ragdoll can be. (Ranges of joints and shapes are checked as they are added.)
    ///
    /// # Errors
    /// Names the field, its value and what was expected.
    pub fn check(&self) -> Result<()> {
        let (n, what) = (self.bones.len(), "ragdoll");
        check((1..=limits::BONES_MAX).contains(&n), what, "bones", n, "1 to 1024 bones")?;
        check(self.group <= 0, what, "group", self.group, "a negative group, or 0 for none")?;
        check_position(self.position)?;
        check_rotation(self.rotation)?;
        for (i, b) in self.bones.iter().enumerate() {
            check(b.rest.is_finite(), what, "rest", b.rest, "a finite pose")?;
            check_rotation(b.rest.q)?;
            if !b.shapes.iter().any(weighs) {
                let value = format!("all without mass, of bone \"{}\"", b.name);
                let expected = "one at least that is no sensor, with density or mass above 0";
                return Err(Error::BadValue { what, field: "shapes", value, expected });
            }
            let Some(j) = &b.joint else { continue };
            check(j.parent < i, what, "parent", j.parent, "the place of a bone before this one")?;
            check((0.0..=1e25).contains(&j.strength), what, "strength", j.strength, "0 to 1e25 N m")?;
            for f in [&j.on_parent, &j.on_bone] {
                check(f.is_finite(), what, "joint frame", f, "a finite pose")?;
                check_rotation(f.q)?;
            }
        }
        Ok(())
    }

    /// Poses of the bones at rest, in the ragdoll's frame.
    pub fn rest_poses(&self) -> Vec<Pose> {
        let _mode = FloatEnv::set_default();
        let mut poses: Vec<Pose> = Vec::with_capacity(self.bones.len());
        for b in &self.bones {
            let mut pose = Pose::new(b.rest.p, b.rest.q.normalize());
            let parent = b.joint.as_ref().and_then(|j| Some((j, poses.get(j.parent)?)));
            if let (true, Some((j, parent))) = (self.close_gaps, parent) {
                pose.p += parent.transform_point(j.on_parent.p) - pose.transform_point(j.on_bone.p);
            }
            poses.push(pose);
        }
        poses
    }
}

/// Has a shape mass?
fn weighs(s: &ShapeDesc) -> bool {
    let (MassSpec::Density(x) | MassSpec::Mass(x)) = s.mass;
    !s.sensor && x > 0.0 && s.shape.volume() > 0.0
}

/// The joint's kind, not driven.
pub(crate) fn idle(j: &BoneJoint) -> JointKind {
    kind(j, None)
}

/// The joint's kind, pulled to a rotation of its frames (or left to its rest spring).
pub(crate) fn kind(j: &BoneJoint, drive: Option<(Quat, Vec3, SpringDesc, f32)>) -> JointKind {
    let rest = j.rest_spring.map(|s| (Quat::IDENTITY, Vec3::ZERO, s, 1.0));
    let drive = drive.or(rest);
    match j.kind {
        BoneJointKind::Fixed => JointKind::Fixed,
        BoneJointKind::Ball { cone, twist } => JointKind::Ball(BallDesc {
            cone: Some(cone),
            twist: Some(LimitDesc::new(twist[0], twist[1])),
            cone_spring: None,
            motor: drive.map(|(q, velocity, spring, part)| BallMotor {
                rotation: Some(q),
                velocity,
                spring,
                max_torque: j.strength * part,
            }),
            friction: j.friction,
        }),
        BoneJointKind::Hinge { range } => {
            let mut axis = AxisDesc::FREE.limited(range[0], range[1]).friction(j.friction);
            if let Some((q, velocity, spring, part)) = drive {
                let position = super::pose::twist(q);
                let target = MotorTarget::Position { position, velocity: velocity.x, spring };
                axis.motor = Some(MotorDesc { target, max_force: j.strength * part });
            }
            JointKind::Hinge(axis)
        }
    }
}

impl World {
    /// Adds a ragdoll: one command for each body and joint.
    ///
    /// ```
    /// use jounce::{RagdollDesc, prelude::*};
    ///
    /// # fn main() -> jounce::Result<()> {
    /// let mut world = World::new(WorldDesc::default())?;
    /// world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    /// let doll = world.add_ragdoll(&RagdollDesc::human().at([0.0, 1.0, 0.0]).group(-1))?;
    /// world.step()?;
    /// assert_eq!(doll.bodies.len(), 14);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// A description out of range, named; nothing is added then.
    pub fn add_ragdoll(&mut self, desc: &RagdollDesc) -> Result<Ragdoll> {
        let _mode = FloatEnv::set_default();
        desc.check()?;
        let mut doll = Ragdoll { bodies: Vec::new(), joints: Vec::new(), links: Vec::new() };
        match self.add_bones(desc, &mut doll) {
            Ok(()) => Ok(doll),
            Err(e) => {
                self.remove_ragdoll(&doll)?;
                Err(e)
            }
        }
    }

    fn add_bones(&mut self, desc: &RagdollDesc, doll: &mut Ragdoll) -> Result<()> {
        let frame = WorldPose::new(desc.position, desc.rotation.normalize());
        for (b, rest) in desc.bones.iter().zip(desc.rest_poses()) {
            let at = frame.compose(&rest);
            let mut body = BodyDesc::dynamic().at(at.p).rotated(at.q).velocity(desc.velocity).name(&b.name);
            body.shapes.clone_from(&b.shapes);
            if !b.meets_group && desc.group != 0 {
                body.shapes.iter_mut().for_each(|s| s.filter.group = desc.group);
            }
            let body = self.add_body(body)?;
            doll.bodies.push(body);
            let joint = match &b.joint {
                None => None,
                Some(j) => {
                    let mut d = JointDesc::ball(doll.bodies[j.parent], body, at.p);
                    d.frames = JointFrames::Local(j.on_parent, j.on_bone);
                    Some(self.add_joint(d.kind(idle(j)))?)
                }
            };
            doll.joints.push(joint);
            doll.links.push(b.joint.clone());
        }
        Ok(())
    }

    /// Removes a ragdoll's bodies and joints.
    ///
    /// # Errors
    /// A bone that is gone already; the others are removed all the same.
    pub fn remove_ragdoll(&mut self, doll: &Ragdoll) -> Result<()> {
        let mut result = Ok(());
        for &b in &doll.bodies {
            if let Err(e) = self.remove_body(b) {
                result = Err(e);
            }
        }
        result
    }
}
