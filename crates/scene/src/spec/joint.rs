//! Joints: what holds two bodies together.

use super::Count;
use schemars::JsonSchema;
use serde::Deserialize;

/// A joint, or many equal ones: exactly one kind of `fixed`, `ball`, `hinge`, `slider`, `distance`, `spring`, `wheel`,
/// `generic`, `gear`, `pulley` and `path`. Its place is one world frame (`at` with `axis`, `rotation_deg` or `rotation`), two
/// world points (`at_a`, `at_b`), or a frame on each body (`local_a`, `local_b`).
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointSpec {
    /// Name for probes, gears and the timeline; with `repeat` the copies are `name[0]`, `name[1]`, ….
    pub name: Option<String>,
    /// First body: `name` or `name[n]`. One of the two is dynamic. Not for gears.
    pub a: Option<String>,
    /// Second body. Not for gears.
    pub b: Option<String>,
    /// Place in the world as the bodies stand when the joint is added, m.
    pub at: Option<[f64; 3]>,
    /// Direction of the main axis (of a hinge, slider, wheel's axle, twist) in the world, of any length. Default x.
    pub axis: Option<[f32; 3]>,
    /// Instead of `axis`: turn of the frame about fixed x, then y, then z, degrees; its x is the main axis.
    pub rotation_deg: Option<[f32; 3]>,
    /// The same as a quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    /// World point held on `a`, m (with `at_b`).
    pub at_a: Option<[f64; 3]>,
    /// World point held on `b`, m (with `at_a`).
    pub at_b: Option<[f64; 3]>,
    /// Frame on `a`, in its own axes (with `local_b`).
    pub local_a: Option<Box<JointFrameSpec>>,
    /// Frame on `b`, in its own axes (with `local_a`).
    pub local_b: Option<Box<JointFrameSpec>>,
    /// Nothing moves.
    pub fixed: Option<FixedJointSpec>,
    /// A point is held, turns are free within limits.
    pub ball: Option<Box<BallJointSpec>>,
    /// Turns about the main axis.
    pub hinge: Option<Box<AxisSpec>>,
    /// Slides along the main axis.
    pub slider: Option<Box<AxisSpec>>,
    /// Keeps the distance of two points: a rod or a rope.
    pub distance: Option<DistanceJointSpec>,
    /// A spring and damper between two points.
    pub spring: Option<Box<SpringJointSpec>>,
    /// Spins about the main axis (the axle), springs along the frame's y, is steered about it.
    pub wheel: Option<Box<WheelJointSpec>>,
    /// Six axes, each locked or free.
    pub generic: Option<Box<GenericJointSpec>>,
    /// Couples two hinges or sliders.
    pub gear: Option<Box<GearSpec>>,
    /// A rope over two wheels that hang in the world.
    pub pulley: Option<Box<PulleySpec>>,
    /// `b` slides along a curve on `a`.
    pub path: Option<Box<PathSpec>>,
    /// Do the two bodies collide with each other? Default false.
    pub collide: Option<bool>,
    /// Takes part in the simulation. Default true.
    pub enabled: Option<bool>,
    /// What holds is a spring of this stiffness; rigid by default.
    pub softness: Option<StiffnessSpec>,
    /// Force that breaks it, N. Default: never.
    pub break_force: Option<f32>,
    /// Torque that breaks it, N m. Default: never.
    pub break_torque: Option<f32>,
    /// How it is solved. Default auto.
    pub solver: Option<JointSolverSpec>,
    /// Colour in pictures, "#rrggbb".
    pub color: Option<String>,
    /// Thickness in pictures, m; 0 hides it. Default: a 200th of the camera's distance from its target.
    pub width: Option<f32>,
    /// Copies.
    pub repeat: Option<Box<JointRepeatSpec>>,
}

/// Mortar: welds wherever two of these bodies touch face to face, as strong as the area that they share. A weld of area A holds the
/// force σ A, and the moment σ A √A / 6.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MortarSpec {
    /// Name of all these welds for probes and the timeline, which know each as `name[0]`, `name[1]`, …: in the order of the bodies.
    pub name: Option<String>,
    /// Names, each of one or many bodies that are there from the start; some are dynamic.
    pub bodies: Vec<String>,
    /// Tensile strength σ, Pa: lime mortar 1e5, cement 1e6, wood glue 1e7.
    pub strength: f32,
    /// Widest gap that it fills, m. Default 0.005.
    pub gap: Option<f32>,
    /// Smallest area that it holds on, m²: edges and corners stay loose. Default 1e-4.
    pub area_min: Option<f32>,
    /// What holds is a spring.
    pub softness: Option<StiffnessSpec>,
}

/// A frame on a body; its x is the joint's main axis.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointFrameSpec {
    /// In the body's frame, m. Default [0, 0, 0].
    pub position: Option<[f32; 3]>,
    /// Direction of the main axis in the body's axes, of any length. Default x.
    pub axis: Option<[f32; 3]>,
    /// Instead of `axis`: turn about the body's x, then y, then z, degrees.
    pub rotation_deg: Option<[f32; 3]>,
    /// The same as a quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
}

/// Copies of a joint: copy (i, j, k), x fastest, has its world points shifted as copies of bodies are, and in place of
/// `name[n]` it joins `name[n + (i, j, k) · a_step]` (for `b`: `b_step`). A bare name is the same body in all copies. A gear
/// numbers its two joints so.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointRepeatSpec {
    /// Number of copies, in a row or along x, y, z.
    pub count: Count,
    /// Distance of neighbours, m. Default [0, 0, 0].
    pub step: Option<[f64; 3]>,
    /// By how much the number of `a` grows from copy to copy, along x, y, z. Default [1, 0, 0].
    pub a_step: Option<[i64; 3]>,
    /// By how much the number of `b` grows. Default [1, 0, 0].
    pub b_step: Option<[i64; 3]>,
}

/// How joints are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum JointSolverSpec {
    /// Directly where joints form trees, chains or few loops; row by row in dense nets.
    Auto,
    /// Directly: rigid, however heavy the load.
    Direct,
    /// Row by row, soft.
    Iterative,
}

/// How stiff a spring is: `hertz` with `damping_ratio`, or `stiffness` with `damping`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StiffnessSpec {
    /// Frequency of the two bodies along the spring, Hz.
    pub hertz: Option<f32>,
    /// 1 is critical damping. Default 1.
    pub damping_ratio: Option<f32>,
    /// N/m, or N m/rad about an axis.
    pub stiffness: Option<f32>,
    /// N s/m, or N m s/rad about an axis. Default 0.
    pub damping: Option<f32>,
}

/// Ends of an axis: m or rad, or degrees, both in one unit. A hinge, a wheel's spin and the twist of `generic` count their turns: their
/// ends may be turns apart, and leave room within ±180 degrees. Swings of `generic` and a wheel's steer end within ±90 degrees.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitSpec {
    /// Least, m or rad.
    pub min: Option<f32>,
    /// Most, m or rad.
    pub max: Option<f32>,
    /// Least, degrees.
    pub min_deg: Option<f32>,
    /// Most, degrees.
    pub max_deg: Option<f32>,
    /// Beyond the ends a spring pushes back; without it they are hard.
    pub spring: Option<StiffnessSpec>,
}

/// What drives an axis: a speed, or a coordinate by a spring.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotorSpec {
    /// m/s or rad/s; beside a position it is the speed on the way (default 0).
    pub velocity: Option<f32>,
    /// Where to, m or rad (with `spring`).
    pub position: Option<f32>,
    /// Where to, degrees (with `spring`).
    pub position_deg: Option<f32>,
    /// How stiff it holds the position.
    pub spring: Option<StiffnessSpec>,
    /// Its strength, N or N m. Default: as strong as it takes.
    pub max_force: Option<f32>,
}

/// A spring towards a coordinate of an axis.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisSpringSpec {
    /// Where it is at rest, m or rad. Default 0.
    pub rest: Option<f32>,
    /// Where it is at rest, degrees.
    pub rest_deg: Option<f32>,
    /// Frequency, Hz.
    pub hertz: Option<f32>,
    /// 1 is critical damping. Default 1.
    pub damping_ratio: Option<f32>,
    /// N/m or N m/rad.
    pub stiffness: Option<f32>,
    /// N s/m or N m s/rad. Default 0.
    pub damping: Option<f32>,
}

/// One degree of freedom.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisSpec {
    /// No motion at all (axes of `wheel` and `generic`). Default false.
    pub locked: Option<bool>,
    /// Where it ends.
    pub limit: Option<LimitSpec>,
    /// What drives it.
    pub motor: Option<MotorSpec>,
    /// A spring towards a coordinate.
    pub spring: Option<AxisSpringSpec>,
    /// Dry friction, N or N m. Default 0.
    pub friction: Option<f32>,
}

/// A weld. It has no keys of its own.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedJointSpec {}

/// What a ball joint adds to holding a point.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BallJointSpec {
    /// Largest angle between the two main axes, degrees, 0 to 180.
    pub cone_deg: Option<f32>,
    /// The cone pushes back as a spring; without it the stop is hard.
    pub cone_spring: Option<StiffnessSpec>,
    /// Twist about the main axis, within ±180 degrees.
    pub twist: Option<LimitSpec>,
    /// What turns it.
    pub motor: Option<BallMotorSpec>,
    /// Dry friction about each axis, N m. Default 0.
    pub friction: Option<f32>,
}

/// Turns a ball joint towards a pose.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BallMotorSpec {
    /// Wanted turn of `b`'s frame in `a`'s about x, then y, then z, degrees.
    pub rotation_deg: Option<[f32; 3]>,
    /// The same as a quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    /// Wanted angular velocity of `b` against `a`, in `a`'s frame, rad/s. Default [0, 0, 0].
    pub velocity: Option<[f32; 3]>,
    /// How stiff the pose is held.
    pub spring: StiffnessSpec,
    /// Strength about each axis, N m. Default: as strong as it takes.
    pub max_torque: Option<f32>,
}

/// The distance of two points: a rod where both ends are equal, a rope where `min` is 0.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DistanceJointSpec {
    /// Least, m. Default: as the points stand.
    pub min: Option<f32>,
    /// Most, m. Default: as the points stand, or `min` where that is more.
    pub max: Option<f32>,
}

/// A spring and damper between two points.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringJointSpec {
    /// Length without force, m. Default: as the points stand.
    pub rest: Option<f32>,
    /// Frequency, Hz.
    pub hertz: Option<f32>,
    /// 1 is critical damping. Default 1.
    pub damping_ratio: Option<f32>,
    /// N/m.
    pub stiffness: Option<f32>,
    /// N s/m. Default 0.
    pub damping: Option<f32>,
    /// Shortest and longest, m.
    pub limit: Option<LimitSpec>,
}

/// A wheel's three axes.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WheelJointSpec {
    /// Along the frame's y, m. Default free.
    pub suspension: Option<AxisSpec>,
    /// About the axle. Default free.
    pub spin: Option<AxisSpec>,
    /// About the frame's y. Default locked.
    pub steer: Option<AxisSpec>,
}

/// Six axes. Turns are twist about x, and swings about y and z, which keep within ±90 degrees unless locked.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GenericJointSpec {
    /// Along the frame's x, y, z. Default: all locked.
    pub linear: Option<[AxisSpec; 3]>,
    /// About x, y, z. Default: all locked.
    pub angular: Option<[AxisSpec; 3]>,
}

/// q_a + ratio · q_b stays: gears (two hinges), rack and pinion (a hinge and a slider).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GearSpec {
    /// Name of the first joint, a hinge or slider.
    pub a: String,
    /// Name of the second joint.
    pub b: String,
    /// Teeth of b by teeth of a; rad/m for a hinge with a slider. Below 0 they turn the same way. Default 1.
    pub ratio: Option<f32>,
}

/// A rope over two wheels: |p_a − wheel_a| + ratio |p_b − wheel_b| ≤ length.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PulleySpec {
    /// Where the rope leaves for `a`, world, m.
    pub wheel_a: [f64; 3],
    /// Where the rope leaves for `b`, world, m.
    pub wheel_b: [f64; 3],
    /// How many times as much rope the side of `b` has. Default 1.
    pub ratio: Option<f32>,
    /// Rope in all, m. Default: as the points stand.
    pub length: Option<f32>,
}

/// A curve on `a` that `b` follows.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PathSpec {
    /// Points that the curve (Catmull–Rom) goes through, in the joint's frame, m; 2 to 4096, none equal to the
    /// one before.
    pub points: Vec<[f32; 3]>,
    /// The last point is joined to the first, which is not written again. Default false.
    pub closed: Option<bool>,
    /// `b` is turned along the curve, y up; otherwise all turns are free. Default false.
    pub aligned: Option<bool>,
    /// Along the curve; the coordinate is the length from the first point, m.
    pub along: Option<AxisSpec>,
}

/// Which axis of a joint a motor is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum JointAxisSpec {
    /// A hinge's, slider's or path's only axis, a wheel's spin.
    Main,
    /// A wheel's suspension.
    Suspension,
    /// A wheel's steering.
    Steer,
    /// Of a generic joint: along x.
    LinearX,
    /// Along y.
    LinearY,
    /// Along z.
    LinearZ,
    /// About x.
    AngularX,
    /// About y.
    AngularY,
    /// About z.
    AngularZ,
}

/// Joints by name.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NamedJointSpec {
    /// Name of one or many joints.
    pub joint: String,
}

/// Takes joints out of the simulation, or back in (broken ones too).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EnableJointSpec {
    /// Name of one or many joints.
    pub joint: String,
    /// In or out.
    pub enabled: bool,
}

/// Another motor on an axis; without `velocity` and position the motor is taken off.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetMotorSpec {
    /// Name of one or many joints.
    pub joint: String,
    /// Which axis. Default main.
    pub axis: Option<JointAxisSpec>,
    /// m/s or rad/s.
    pub velocity: Option<f32>,
    /// Where to, m or rad (with `spring`).
    pub position: Option<f32>,
    /// Where to, degrees (with `spring`).
    pub position_deg: Option<f32>,
    /// How stiff it holds the position.
    pub spring: Option<StiffnessSpec>,
    /// Its strength, N or N m. Default: as strong as it takes.
    pub max_force: Option<f32>,
}

/// Another kind of the same name in place of a joint's: other ends, motors, springs, lengths. What is left out has its default;
/// a rod, rope, spring or pulley without a length takes the one that its points have then.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetJointSpec {
    /// Name of one or many joints.
    pub joint: String,
    /// Of ball joints.
    pub ball: Option<Box<BallJointSpec>>,
    /// Of hinges.
    pub hinge: Option<Box<AxisSpec>>,
    /// Of sliders.
    pub slider: Option<Box<AxisSpec>>,
    /// Of rods and ropes.
    pub distance: Option<DistanceJointSpec>,
    /// Of springs.
    pub spring: Option<Box<SpringJointSpec>>,
    /// Of wheels.
    pub wheel: Option<Box<WheelJointSpec>>,
    /// Of generic joints.
    pub generic: Option<Box<GenericJointSpec>>,
    /// Of pulleys.
    pub pulley: Option<Box<PulleySpec>>,
    /// Of paths.
    pub path: Option<Box<PathSpec>>,
}
