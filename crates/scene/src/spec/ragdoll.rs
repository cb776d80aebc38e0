//! Ragdolls: bodies joined as bones are.

use super::{Map, RepeatSpec, ShapeSpec, StiffnessSpec};
use schemars::JsonSchema;
use serde::Deserialize;

/// A ragdoll, or many equal ones. Its bodies and joints are known as `name.bone` (with `repeat`: `name.bone[0]`, …), all of
/// them together as `name`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RagdollSpec {
    /// Name for probes, the camera and the timeline, without dots.
    pub name: Option<String>,
    /// Bones to start from.
    pub preset: Option<RagdollPresetSpec>,
    /// The bones, parents first, instead of a preset.
    #[serde(default)]
    pub bones: Vec<BoneSpec>,
    /// Where its frame is, m. Default [0, 0, 0].
    pub position: Option<[f64; 3]>,
    /// Turn about fixed x, then y, then z, degrees.
    pub rotation_deg: Option<[f32; 3]>,
    /// The same as a quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    /// Of all bones, m/s.
    pub velocity: Option<[f32; 3]>,
    /// Do bones meet each other at all? Default true: those that do not hang on each other, but for those with `meets_group`
    /// false.
    pub self_collision: Option<bool>,
    /// Collision group of the bones with `meets_group` false, negative; copies count down from it. Default: one of its own.
    pub group: Option<i32>,
    /// Moves children at rest, so that the anchors of each joint meet. Default true.
    pub close_gaps: Option<bool>,
    /// Colour, "#rrggbb".
    pub color: Option<String>,
    /// Copies, on a grid as bodies.
    pub repeat: Option<RepeatSpec>,
}

/// Ragdolls to start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RagdollPresetSpec {
    /// A person of 1.75 m: 14 capsules, 13 joints, standing on the origin, looking along z. Bones: pelvis, spine_01, spine_02,
    /// spine_03, neck, head, thigh_l, calf_l, thigh_r, calf_r, upper_arm_l, lower_arm_l, upper_arm_r, lower_arm_r.
    Human,
}

/// A bone.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoneSpec {
    /// Name, without dots and square brackets.
    pub name: String,
    /// Name of the bone that it hangs on, written before it; none for a root.
    pub parent: Option<String>,
    /// At rest, in the ragdoll's frame, m. Default [0, 0, 0].
    pub position: Option<[f32; 3]>,
    /// Turn at rest about fixed x, then y, then z, degrees.
    pub rotation_deg: Option<[f32; 3]>,
    /// The same as a quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    /// Shapes in the bone's frame; one of them at least has mass.
    pub shapes: Vec<ShapeSpec>,
    /// May meet bones of the ragdoll that do not hang on it. Default true.
    pub meets_group: Option<bool>,
    /// How it hangs on its parent.
    pub joint: Option<Box<BoneJointSpec>>,
}

/// How a bone hangs on its parent: exactly one of `ball`, `hinge` and `fixed`. The main axis is the x of the frames.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoneJointSpec {
    /// Swings within a cone and twists.
    pub ball: Option<BoneBallSpec>,
    /// Turns about x.
    pub hinge: Option<BoneHingeSpec>,
    /// Does not turn.
    pub fixed: Option<super::FixedJointSpec>,
    /// Frame on the parent, in its own axes.
    pub on_parent: super::JointFrameSpec,
    /// Frame on the bone, in its own axes.
    pub on_bone: super::JointFrameSpec,
    /// Dry friction about each axis, N m. Default 0.
    pub friction: Option<f32>,
    /// Pulls to rest while the bone is not driven.
    pub rest_spring: Option<StiffnessSpec>,
    /// Most torque of that spring and of poses, N m. Default 100.
    pub strength: Option<f32>,
}

/// Limits of a ball joint.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoneBallSpec {
    /// Largest angle between the two x axes, degrees, 0 to 180.
    pub cone_deg: f32,
    /// Least and largest twist, degrees, within ±180.
    pub twist_deg: [f32; 2],
}

/// Limits of a hinge.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoneHingeSpec {
    /// Least and largest angle, degrees.
    pub range_deg: [f32; 2],
}

/// Drives ragdolls to a pose: each bone against its parent as at rest, turned.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PoseSpec {
    /// Name of one or many ragdolls.
    pub ragdoll: String,
    /// Part of each joint's own strength, 0 or more. Default 1.
    pub strength: Option<f32>,
    /// Stiffness of every joint. Default 8 Hz, damping ratio 1.
    pub spring: Option<StiffnessSpec>,
    /// By bone; not of roots, which hang on no bone.
    #[serde(default)]
    pub bones: Map<BonePoseSpec>,
    /// What the bones do that are not in `bones`. Default rest.
    pub others: Option<OthersSpec>,
}

/// Where one bone should be, and how it goes on from there.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BonePoseSpec {
    /// Turn from rest about the ragdoll's x, then y, then z at rest, degrees. Default none.
    pub rotation_deg: Option<[f32; 3]>,
    /// The same as a quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    /// Angular velocity against the parent about the same axes, rad/s, that the joint's damping follows: a joint that turns freely
    /// goes ahead of the pose by damping / stiffness times this. Default none.
    pub angular_velocity: Option<[f32; 3]>,
    /// Factor on `strength`. Default 1.
    pub strength: Option<f32>,
}

/// What the bones do that a pose does not name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OthersSpec {
    /// They are driven to rest.
    Rest,
    /// They go limp, as by `relax`.
    Limp,
    /// They go on as they were: driven by an earlier pose, or limp.
    Keep,
}

/// Bones of ragdolls.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BonesSpec {
    /// Name of one or many ragdolls.
    pub ragdoll: String,
    /// Names of bones. Default: all.
    pub bones: Option<Vec<String>>,
}

/// Leads bones of ragdolls along an animation. They become kinematic, go from where they are to the first key, from there to the
/// next, and stay where the last one leaves them until they are released; the other bones hang on them.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeadSpec {
    /// Name of one or many ragdolls.
    pub ragdoll: String,
    /// Names of the bones that are led. Default: all.
    pub bones: Option<Vec<String>>,
    /// In all keys x and z of `position` count from where the first bone is as the action begins, at rest above them: a ragdoll gets up
    /// where it lies. Default false.
    pub here: Option<bool>,
    /// Where to, one after the other.
    pub keys: Vec<LeadKeySpec>,
}

/// Where a ragdoll is led to.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeadKeySpec {
    /// When it is there, s after the action began: later than the key before, and than 0.
    pub at: f64,
    /// Where the ragdoll's frame is, m; copies keep their distances. Default: the ragdoll's own `position` (with `here`, its y alone).
    pub position: Option<[f64; 3]>,
    /// Turn of the frame about fixed x, then y, then z, degrees. Default: the ragdoll's own.
    pub rotation_deg: Option<[f32; 3]>,
    /// The same as a quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    /// Turns of bones against their parents; those that are not named are as at rest.
    #[serde(default)]
    pub bones: Map<BoneTurnSpec>,
}

/// How one bone is turned.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoneTurnSpec {
    /// Turn from rest about the ragdoll's x, then y, then z at rest, degrees. Default none.
    pub rotation_deg: Option<[f32; 3]>,
    /// The same as a quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
}

/// Takes hold of a body by springs, as a mouse does. The hand is a kinematic body: `move_to` drags it, `remove` lets go.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GrabSpec {
    /// Name of one dynamic body.
    pub body: String,
    /// Name of the hand.
    pub hand: String,
    /// Point of the body that is held, in its frame, m: within 10 m, or ten of its own radii, of its centre of mass. Default its origin.
    pub point: Option<[f32; 3]>,
    /// Stiffness along each axis. Default 5 Hz, damping ratio 1.
    pub spring: Option<StiffnessSpec>,
    /// Most force along each axis, N. Default unlimited.
    pub max_force: Option<f32>,
}
