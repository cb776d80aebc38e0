//! The scene file as Rust types. The published JSON Schema and `docs/scenes.md` follow from these types, and
//! their doc comments are its descriptions. Lengths are metres, times seconds, masses kilograms, angles degrees
//! where the key ends in `_deg`.

mod body;
mod character;
mod field;
mod joint;
mod ragdoll;
mod run;
mod system;
mod values;
mod vehicle;

pub use body::*;
pub use character::*;
pub use field::*;
pub use joint::*;
pub use ragdoll::*;
pub use run::*;
pub use system::*;
pub use values::*;
pub use vehicle::*;

use schemars::JsonSchema;
use serde::Deserialize;

/// A Jounce scene.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneSpec {
    /// Where editors find the schema of this file.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// Version of the format: 1.
    pub jounce: u32,
    /// Short name; by default that of the file.
    pub name: Option<String>,
    /// What the scene shows, and where its numbers come from.
    pub description: Option<String>,
    /// Length of a run in simulated seconds; by default up to the last `expect`, and 1 s beyond the end of the last action of
    /// `timeline`, or 5. Neither may name a later time.
    pub seconds: Option<f64>,
    /// Uniform gravity, m/s². Default [0, -9.81, 0].
    pub gravity: Option<[f32; 3]>,
    /// Steps and substeps.
    #[serde(default)]
    pub step: StepSpec,
    /// Constants of the solver.
    #[serde(default)]
    pub settings: SettingsSpec,
    /// Named surfaces.
    #[serde(default)]
    pub materials: Map<MaterialSpec>,
    /// Named meshes from files.
    #[serde(default)]
    pub meshes: Map<MeshFileSpec>,
    /// Bodies that are there from the start.
    #[serde(default)]
    pub bodies: Vec<BodySpec>,
    /// Bodies placed at random, from explicit seeds.
    #[serde(default)]
    pub scatter: Vec<ScatterSpec>,
    /// What holds bodies together: hinges, ropes, springs, gears, ….
    #[serde(default)]
    pub joints: Vec<JointSpec>,
    /// What glues bodies together that touch: walls, arches, towers.
    #[serde(default)]
    pub mortar: Vec<MortarSpec>,
    /// Cars, motorcycles, tanks, snowboards.
    #[serde(default)]
    pub vehicles: Vec<VehicleSpec>,
    /// Who walks.
    #[serde(default)]
    pub characters: Vec<CharacterSpec>,
    /// Bodies joined as bones are.
    #[serde(default)]
    pub ragdolls: Vec<RagdollSpec>,
    /// Laws that act on everything in a region: gravity of stars, wind, air, water, whirls.
    #[serde(default)]
    pub fields: Vec<FieldSpec>,
    /// Points and springs of the textbook: pairs, cloth, jelly.
    #[serde(default)]
    pub systems: Vec<SystemSpec>,
    /// Sources of particles.
    #[serde(default)]
    pub emitters: Vec<EmitterSpec>,
    /// Timed actions, in any order.
    #[serde(default)]
    pub timeline: Vec<TimelineSpec>,
    /// Named numbers, sampled every step.
    #[serde(default)]
    pub probes: Map<ProbeSpec>,
    /// Where pictures are taken from.
    pub camera: Option<CameraSpec>,
    /// How pictures look.
    pub render: Option<RenderSpec>,
    /// What must come out.
    #[serde(default)]
    pub expect: Vec<ExpectSpec>,
}

/// Time step.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StepSpec {
    /// Steps per second, 1 to 10000. Default 60.
    pub rate_hz: Option<f64>,
    /// Substeps of a step, 1 to 64. Default 4.
    pub substeps: Option<u32>,
}

/// Constants of the solver; what is absent keeps its default.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SettingsSpec {
    /// Length of a typical object in metres: scales slop, margins and speed thresholds. Default 1.
    pub length_unit: Option<f32>,
    /// Stiffness of contacts between moving bodies, Hz. Default 30.
    pub contact_hertz: Option<f32>,
    /// Damping ratio of contacts between moving bodies. Default 10.
    pub contact_damping_ratio: Option<f32>,
    /// Stiffness of contacts against fixed and kinematic bodies, Hz. Default 60.
    pub static_contact_hertz: Option<f32>,
    /// Damping ratio of contacts against fixed and kinematic bodies. Default 5.
    pub static_contact_damping_ratio: Option<f32>,
    /// Fastest speed at which overlap is pushed out, m/s. Default 3.
    pub push_out_speed: Option<f32>,
    /// Approach speed below which contacts do not bounce, m/s. Default 1.
    pub restitution_speed: Option<f32>,
    /// Slip speed below which a sliding contact sticks again, m/s. Default 0.02.
    pub stick_speed: Option<f32>,
    /// Approach speed from which a contact reports a hit event, m/s. Default 1.
    pub hit_event_speed: Option<f32>,
    /// Bodies at rest fall asleep. Default true.
    pub sleep: Option<bool>,
    /// Speed below which a body counts as resting, m/s. Default 0.05.
    pub sleep_speed: Option<f32>,
    /// How long an island must rest before it sleeps, s. Default 0.5.
    pub sleep_time_s: Option<f32>,
    /// Stiffness of joints where they are solved row by row, Hz. Default 60.
    pub joint_hertz: Option<f32>,
    /// Damping ratio of joints where they are solved row by row. Default 2.
    pub joint_damping_ratio: Option<f32>,
    /// Continuous collision of fast bodies against fixed ones. Default true.
    pub continuous: Option<bool>,
    /// Start each substep from the last impulses. Default true.
    pub warm_starting: Option<bool>,
    /// Recycle contacts whose bodies hardly moved against each other. Default true.
    pub recycle_contacts: Option<bool>,
    /// Speed limit of bodies, m/s. Default 400.
    pub linear_speed_max: Option<f32>,
    /// Spin limit as rotation per step, radians. Default pi/4.
    pub rotation_per_step_max: Option<f32>,
}

/// A surface; what is absent keeps its default.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialSpec {
    /// Static and kinetic friction at once.
    pub friction: Option<f32>,
    /// Coulomb coefficient that holds a resting contact. Default 0.6.
    pub static_friction: Option<f32>,
    /// Coulomb coefficient of a sliding contact. Default 0.6, or static_friction where that is smaller.
    pub kinetic_friction: Option<f32>,
    /// Speed after a bounce divided by the speed before, 0 to 1. Default 0.
    pub restitution: Option<f32>,
    /// Rolling friction as a length, m. Default 0.
    pub rolling_friction: Option<f32>,
    /// Friction against spinning on the spot, as an effective patch radius, m. Default 0.
    pub twist_friction: Option<f32>,
    /// Velocity of the surface in the shape's frame (a conveyor), m/s.
    pub surface_velocity: Option<[f32; 3]>,
    /// How friction combines with that of the other surface. Default geometric_mean.
    pub friction_combine: Option<CombineSpec>,
    /// How restitution combines with that of the other surface. Default max.
    pub restitution_combine: Option<CombineSpec>,
}

/// How two coefficients become one; where two surfaces differ, the later in this list wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CombineSpec {
    /// Square root of the product.
    GeometricMean,
    /// Mean.
    Average,
    /// Smaller.
    Min,
    /// Product.
    Multiply,
    /// Larger.
    Max,
}

/// A mesh from a file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFileSpec {
    /// `.obj`, `.stl`, `.gltf` or `.glb`; relative to the scene file, or `assets:…` in the assets folder.
    pub file: String,
    /// Factor on the file's coordinates (before `up`), one or one for each axis. Default 1.
    pub scale: Option<Scale>,
    /// Axis that points up in the file; it becomes y. Default y.
    pub up: Option<UpSpec>,
    /// Vertices closer than this become one, m. Default 0: exact duplicates only.
    pub weld_distance: Option<f32>,
    /// Both sides of each triangle collide. Default false: the side whose corners run counter-clockwise.
    pub double_sided: Option<bool>,
}

/// An axis of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum UpSpec {
    /// x up.
    X,
    /// y up: as it is.
    Y,
    /// z up (CAD, GIS, Blender).
    Z,
}

/// The JSON Schema of scene files, as published in `scenes/schema.json`.
pub fn schema() -> String {
    let schema = schemars::schema_for!(SceneSpec);
    let mut text = serde_json::to_string_pretty(&schema).unwrap_or_default();
    text.push('\n');
    text
}
