//! What happens, what is measured, what must come out, how it is shown.

use super::{
    BodySpec, BonesSpec, CharacterSpec, DriveSpec, EmitSpec, EnableJointSpec, ExplodeSpec, GrabSpec,
    JointSpec, LeadSpec, NamedJointSpec, PoseSpec, RagdollSpec, SetEmitterSpec, SetFieldSpec, SetJointSpec,
    SetMotorSpec, VehicleSpec, WalkSpec,
};
use schemars::JsonSchema;
use serde::Deserialize;

/// A timed action: exactly one of `spawn`, `push`, `set_velocity`, `remove`, `teleport`, `move_to`, `set_gravity`,
/// `wake`, `sleep`, `enable`, `explode`, `set_field`,
/// `emit`, `set_emitter`, `cut`, `set_motor`, `set_joint`, `enable_joint`, `enable_vehicle`, `drive`, `walk`, `pose`, `relax`, `lead`,
/// `release` and `grab`. An action leaves out what is not there (any more): a removed body, a joint that was cut, a ragdoll's lost bone; the run warns
/// once of each entry that did.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimelineSpec {
    /// When, s: acts before the first step that starts at or after this time.
    pub at: f64,
    /// Repeat with this period, s.
    pub every: Option<f64>,
    /// How often in all, with `every`. Default 1.
    pub times: Option<u64>,
    /// Adds bodies, joints, vehicles, characters and ragdolls.
    pub spawn: Option<Box<SpawnSpec>>,
    /// Applies an impulse at once, or a force or torque for a while, to dynamic bodies.
    pub push: Option<Box<PushSpec>>,
    /// Sets velocities of kinematic and dynamic bodies.
    pub set_velocity: Option<Box<SetVelocitySpec>>,
    /// Removes bodies.
    pub remove: Option<NamedSpec>,
    /// Puts bodies somewhere at once.
    pub teleport: Option<Box<PlaceSpec>>,
    /// Moves kinematic bodies to a pose, pushing what is in the way.
    pub move_to: Option<Box<PlaceSpec>>,
    /// Sets the world's gravity.
    pub set_gravity: Option<GravitySpec>,
    /// Wakes bodies.
    pub wake: Option<NamedSpec>,
    /// Puts bodies to sleep.
    pub sleep: Option<NamedSpec>,
    /// Takes bodies into the simulation or out of it.
    pub enable: Option<EnableSpec>,
    /// Lets off a blast.
    pub explode: Option<ExplodeSpec>,
    /// Switches a field on or off.
    pub set_field: Option<SetFieldSpec>,
    /// Lets an emitter bear particles at once.
    pub emit: Option<EmitSpec>,
    /// Switches an emitter on or off.
    pub set_emitter: Option<SetEmitterSpec>,
    /// Removes joints.
    pub cut: Option<NamedJointSpec>,
    /// Puts another motor on an axis of joints, or takes it off.
    pub set_motor: Option<Box<SetMotorSpec>>,
    /// Gives joints other ends, motors, springs, lengths.
    pub set_joint: Option<Box<SetJointSpec>>,
    /// Takes joints out of the simulation, or back in.
    pub enable_joint: Option<EnableJointSpec>,
    /// Takes the wheels of vehicles (or their boards) out of the simulation, or back in; the chassis stays, as a body.
    pub enable_vehicle: Option<EnableVehicleSpec>,
    /// What drivers of vehicles do from now on.
    pub drive: Option<Box<DriveSpec>>,
    /// What characters do from now on.
    pub walk: Option<Box<WalkSpec>>,
    /// Drives ragdolls to a pose.
    pub pose: Option<Box<PoseSpec>>,
    /// Lets ragdolls, or some of their bones, go limp but for friction and rest springs.
    pub relax: Option<BonesSpec>,
    /// Leads bones of ragdolls along an animation.
    pub lead: Option<Box<LeadSpec>>,
    /// Gives bones that were led back: they are dynamic again, with the speed that they have on their way.
    pub release: Option<BonesSpec>,
    /// Takes hold of a body.
    pub grab: Option<Box<GrabSpec>>,
}

/// Bodies, joints, vehicles, characters and ragdolls to add. Where the action repeats, names of what it adds go on: `ball[0]`, `ball[1]`, …
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpawnSpec {
    /// The bodies.
    #[serde(default)]
    pub bodies: Vec<BodySpec>,
    /// Joints between them and what is there; where the action repeats, names of these bodies and joints mean those of the same
    /// time.
    #[serde(default)]
    pub joints: Vec<JointSpec>,
    /// Vehicles, as at the top level.
    #[serde(default)]
    pub vehicles: Vec<VehicleSpec>,
    /// Characters, as at the top level.
    #[serde(default)]
    pub characters: Vec<CharacterSpec>,
    /// Ragdolls, as at the top level.
    #[serde(default)]
    pub ragdolls: Vec<RagdollSpec>,
}

/// A push on bodies.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PushSpec {
    /// Name of one or many bodies.
    pub body: String,
    /// Impulse at once, N s.
    pub impulse: Option<[f32; 3]>,
    /// Angular impulse at once, N m s.
    pub angular_impulse: Option<[f32; 3]>,
    /// Force, N, over `duration`.
    pub force: Option<[f32; 3]>,
    /// Torque, N m, over `duration`.
    pub torque: Option<[f32; 3]>,
    /// How long force and torque act, s. Default one step.
    pub duration: Option<f64>,
    /// World point that the impulse or force acts at. Default the centre of mass.
    pub at_point: Option<[f64; 3]>,
}

/// New velocities.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetVelocitySpec {
    /// Name of one or many bodies.
    pub body: String,
    /// m/s.
    pub velocity: Option<[f32; 3]>,
    /// rad/s.
    pub angular_velocity: Option<[f32; 3]>,
}

/// Bodies by name.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NamedSpec {
    /// Name of one or many bodies.
    pub body: String,
}

/// A pose for bodies.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaceSpec {
    /// Name of one or many bodies.
    pub body: String,
    /// m. Default: where it is.
    pub position: Option<[f64; 3]>,
    /// Degrees about fixed x, then y, then z. Default: as it is.
    pub rotation_deg: Option<[f32; 3]>,
    /// Quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    /// `move_to`: how long the way takes, s. Default one step.
    pub duration: Option<f64>,
}

/// New gravity.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GravitySpec {
    /// m/s².
    pub gravity: [f32; 3],
}

/// Takes bodies in or out.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EnableSpec {
    /// Name of one or many bodies.
    pub body: String,
    /// In or out.
    pub enabled: bool,
}

/// Takes vehicles in or out.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EnableVehicleSpec {
    /// Name of one or many vehicles.
    pub vehicle: String,
    /// In or out.
    pub enabled: bool,
}

/// A number sampled every step: exactly one of `body`, `joint`, `system`, `emitter`, `vehicle` or `character` with `value`, and
/// `world`, `sensor`, and `events`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbeSpec {
    /// Name of a body, or of many with `aggregate`. With `events`: counts only events of these bodies.
    pub body: Option<String>,
    /// What of the body: position.x|y|z, center.x|y|z, velocity.x|y|z, angular_velocity.x|y|z, momentum.x|y|z, speed,
    /// angular_speed, height (against gravity), tilt (degrees between the body's y axis and up), angle (degrees from the
    /// rotation at the start), distance (from the place at the start), kinetic_energy, potential_energy, energy, mass,
    /// awake, contacts (touching pairs), normal_force (sum over the contacts, N), friction_force (size of the sum, N).
    pub value: Option<String>,
    /// Name of a joint, or of many with `aggregate`, with `value`: coordinate (where its main axis stands, m or rad),
    /// coordinate_deg, force and torque on `b` (sizes, N and N m) or force.x|y|z and torque.x|y|z, gap (how far it is from
    /// holding, m), broken, enabled (1 or 0), length (distance of its two points, m).
    pub joint: Option<String>,
    /// How many bodies or joints become one number.
    pub aggregate: Option<AggregateSpec>,
    /// Of the whole world: energy, kinetic_energy, potential_energy, momentum.x|y|z, angular_momentum.x|y|z, bodies,
    /// awake, shapes, contacts, touching, joints (broken ones too), particles, vehicles, characters.
    pub world: Option<String>,
    /// Name of a system of points and springs, with `value` (and `point`): position.x|y|z and velocity.x|y|z (of a point, or of
    /// the centre of mass), momentum.x|y|z, speed, distance (from the start), radius (from the origin; of all points the
    /// largest), lowest (y), kinetic_energy, elastic_energy, energy (both).
    pub system: Option<String>,
    /// Number of a point of the system.
    pub point: Option<u64>,
    /// Name of an emitter, with `value`: particles, born, highest, lowest, center.x|y|z, speed (mean).
    pub emitter: Option<String>,
    /// Name of a vehicle, or of many with `aggregate`, with `value`: speed (along it, m/s), rpm, gear, lean_deg (to the right),
    /// grounded (wheels on the ground), traction (throttle let through), clutch_torque (N m), route (way along it, m); and of
    /// wheels, with `wheel` or `aggregate`: load, longitudinal_force, lateral_force (left positive), suspension_force (N), slip_ratio,
    /// slip_angle_deg, friction (μ in force), grip_used (force ÷ μ load), spin (rad/s), steer_deg (left positive), travel (m, down
    /// positive), drive_torque (N m), abs (brake let through).
    pub vehicle: Option<String>,
    /// Number of a wheel, from 0; of a board: nose left, nose right, tail left, tail right.
    pub wheel: Option<u64>,
    /// Name of a character, or of many with `aggregate`, with `value`: position.x|y|z (of the foot), velocity.x|y|z, speed,
    /// heading_deg, grounded, crouched, on_steep, hit_ceiling, squeezed (1 or 0), air_time (s), stepped (m in the last step).
    pub character: Option<String>,
    /// Name of a body with sensor shapes: how many shapes are inside.
    pub sensor: Option<String>,
    /// Counts events of a kind since the start.
    pub events: Option<EventSpec>,
}

/// How many bodies become one number.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AggregateSpec {
    /// Smallest.
    Min,
    /// Largest.
    Max,
    /// Mean.
    Mean,
    /// Sum.
    Sum,
    /// Largest less smallest.
    Spread,
    /// How many are below.
    CountBelow(f64),
    /// How many are above.
    CountAbove(f64),
}

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EventSpec {
    /// Two shapes began to touch.
    ContactBegin,
    /// Two shapes no longer touch.
    ContactEnd,
    /// Two shapes met fast.
    ContactHit,
    /// A shape entered a sensor.
    SensorEnter,
    /// A shape left a sensor.
    SensorLeave,
    /// A body fell asleep.
    Sleep,
    /// A body woke up.
    Wake,
    /// A body was taken out because its state was no longer finite.
    Quarantine,
    /// A body was held to the limit of speed or spin.
    SpeedLimited,
    /// A bound was reached inside a step.
    LimitReached,
    /// A joint was loaded beyond what it stands.
    JointBreak,
}

/// What a probe must show.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectSpec {
    /// Name for the report.
    pub name: String,
    /// Name of a probe.
    pub probe: String,
    /// When, s; compared after the step that ends nearest to this time.
    pub at: f64,
    /// `min` and `max` hold at every step from this time to `at`, s.
    pub from: Option<f64>,
    /// Right number, with `tolerance`.
    pub value: Option<f64>,
    /// Largest accepted difference from `value`. Default 0.
    pub tolerance: Option<f64>,
    /// Smallest accepted number.
    pub min: Option<f64>,
    /// Largest accepted number.
    pub max: Option<f64>,
    /// Where the number comes from: a law, a measurement, a formula of the method.
    pub source: Option<String>,
}

/// Where pictures are taken from.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraSpec {
    /// m.
    pub position: [f64; 3],
    /// Point in the middle of the picture, m. Default [0, 0, 0].
    pub target: Option<[f64; 3]>,
    /// Vertical field of view, degrees. Default 45.
    pub fov_deg: Option<f32>,
    /// Up. Default [0, 1, 0].
    pub up: Option<[f32; 3]>,
    /// Name of a body: camera and target move along with it.
    pub follow: Option<String>,
    /// Turn about the target, degrees per second.
    pub orbit_deg_per_s: Option<f32>,
}

/// How pictures look.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RenderSpec {
    /// Colour of the background, "#rrggbb".
    pub background: Option<String>,
    /// Draw lines of one metre on fixed ground. Default true.
    pub ground_grid: Option<bool>,
    /// Colour of the ground, "#rrggbb".
    pub ground_color: Option<String>,
    /// Direction towards the sun.
    pub sun: Option<[f32; 3]>,
    /// Brightness of the sun, 0 to 4. Default 1.
    pub sun_strength: Option<f32>,
    /// Draw outlines of sensors. Default false.
    pub sensors: Option<bool>,
    /// Draw joints: rods, ropes, springs, axes of hinges, rails. Default true.
    pub joints: Option<bool>,
    /// Draw where bodies have been.
    pub trails: Option<TrailsSpec>,
}

/// Lines behind moving bodies, in the bodies' colours.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrailsSpec {
    /// Names, each of one or many bodies.
    pub bodies: Vec<String>,
    /// How long a trail stays, s. Default: as long as the run.
    pub seconds: Option<f64>,
    /// Width, m. Default: a 200th of the camera's distance from its target.
    pub width: Option<f32>,
}
