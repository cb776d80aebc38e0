//! Bodies, shapes, and many of them.

use super::{AeroSpec, Count, Layers, Map, Spacing};
use schemars::JsonSchema;
use serde::Deserialize;

/// How a body moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BodyTypeSpec {
    /// Never moves.
    Fixed,
    /// Moves as told, pushes dynamic bodies.
    Kinematic,
    /// Moves by forces and contacts.
    Dynamic,
}

/// A body, or many equal ones.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodySpec {
    /// Name for probes and the timeline; with `repeat` or `scatter` the copies are `name[0]`, `name[1]`, ….
    pub name: Option<String>,
    /// How the body moves.
    #[serde(rename = "type")]
    pub kind: BodyTypeSpec,
    /// Position of the body's origin, m. Default [0, 0, 0].
    pub position: Option<[f64; 3]>,
    /// Rotation about fixed x, then y, then z, degrees.
    pub rotation_deg: Option<[f32; 3]>,
    /// Rotation as a quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Option<[f32; 3]>,
    /// Angular velocity in world axes, rad/s.
    pub angular_velocity: Option<[f32; 3]>,
    /// Linear damping, 1/s. Default 0.
    pub linear_damping: Option<f32>,
    /// Angular damping, 1/s. Default 0.
    pub angular_damping: Option<f32>,
    /// Factor on gravity. Default 1.
    pub gravity_scale: Option<f32>,
    /// Axes along or about which the body may not move.
    pub locks: Option<Box<LocksSpec>>,
    /// Total mass, kg: the shapes' masses are scaled to this sum.
    pub mass: Option<f32>,
    /// Mass, centre and inertia instead of what the shapes give.
    pub mass_properties: Option<Box<MassPropertiesSpec>>,
    /// Continuous collision against moving bodies too. Default false.
    pub bullet: Option<bool>,
    /// Exempt from the spin limit. Default false.
    pub fast_rotation: Option<bool>,
    /// May fall asleep. Default true.
    pub can_sleep: Option<bool>,
    /// Own sleep threshold, m/s.
    pub sleep_speed: Option<f32>,
    /// Starts asleep. Default false.
    pub asleep: Option<bool>,
    /// Takes part in the simulation. Default true.
    pub enabled: Option<bool>,
    /// Colour in pictures, "#rrggbb".
    pub color: Option<String>,
    /// Shapes on the body.
    #[serde(default)]
    pub shapes: Vec<ShapeSpec>,
    /// Copies on a grid.
    pub repeat: Option<Box<RepeatSpec>>,
}

/// Locked axes, in world axes x, y, z.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LocksSpec {
    /// No motion along x, y, z.
    #[serde(default)]
    pub linear: [bool; 3],
    /// No turning about x, y, z.
    #[serde(default)]
    pub angular: [bool; 3],
}

/// Mass, centre of mass and inertia.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MassPropertiesSpec {
    /// kg.
    pub mass: f32,
    /// Centre of mass in the body's frame, m. Default [0, 0, 0].
    #[serde(default)]
    pub center: [f32; 3],
    /// Inertia about the centre, body axes, kg m²: [xx, yy, zz] or [xx, yy, zz, xy, xz, yz]. No principal moment is above the sum
    /// of the other two.
    pub inertia: Vec<f32>,
}

/// Copies on a grid: copy (i, j, k) is shifted by (i, j, k) times `step`, x fastest. With a single number as `count` they are
/// a row: copy i is shifted by i times the whole `step`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RepeatSpec {
    /// Number of copies, in a row or along x, y, z.
    pub count: Count,
    /// Distance of neighbours, m.
    pub step: [f64; 3],
    /// Rows of a pyramid: each level in y has one copy less, centred over the level below.
    pub pyramid: Option<PyramidSpec>,
    /// Turn of each copy against the one before it about fixed x, y, z, degrees.
    pub turn_deg: Option<[f32; 3]>,
    /// Seeded irregularity.
    pub jitter: Option<JitterSpec>,
}

/// Along which axes a pyramid gets narrower with height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PyramidSpec {
    /// A wall with the outline of a triangle.
    X,
    /// A pyramid with a square base.
    Xz,
}

/// Seeded irregularity of copies, uniform in ± the given amounts.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JitterSpec {
    /// Seed.
    pub seed: u64,
    /// Shift, m.
    pub position: Option<[f64; 3]>,
    /// Turn about fixed x, y, z, degrees.
    pub rotation_deg: Option<[f32; 3]>,
}

/// Bodies placed at random in a box; the templates take turns.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScatterSpec {
    /// Name of the whole group; body n is also `name[n]`.
    pub name: Option<String>,
    /// Number of bodies.
    pub count: u64,
    /// Seed: equal seeds give equal scenes, on every machine.
    pub seed: u64,
    /// Where the origins go.
    #[serde(rename = "box")]
    pub region: RegionSpec,
    /// Least distance of two origins, m.
    pub min_distance: Option<f64>,
    /// Random turns. Default any.
    pub rotation: Option<ScatterRotationSpec>,
    /// Largest random velocity along each axis, m/s, on top of the template's.
    pub velocity: Option<[f32; 3]>,
    /// Largest random angular velocity about each axis, rad/s, on top of the template's.
    pub angular_velocity: Option<[f32; 3]>,
    /// Templates; their `position` is added to the random place.
    pub bodies: Vec<BodySpec>,
}

/// Random turns of scattered bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScatterRotationSpec {
    /// As the template says.
    None,
    /// Any angle about y.
    Yaw,
    /// Any rotation.
    Any,
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegionSpec {
    /// Lowest corner, m.
    pub min: [f64; 3],
    /// Highest corner, m.
    pub max: [f64; 3],
}

/// A shape on a body: exactly one of `sphere`, `capsule`, `box`, `cylinder`, `cone`, `hull`, `half_space`, `mesh`,
/// `height_field`, `compound` and `decompose`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShapeSpec {
    /// A ball.
    pub sphere: Option<SphereSpec>,
    /// A capsule along y.
    pub capsule: Option<AxialSpec>,
    /// A box.
    #[serde(rename = "box")]
    pub cuboid: Option<BoxSpec>,
    /// A cylinder along y.
    pub cylinder: Option<AxialSpec>,
    /// A cone along y, tip up.
    pub cone: Option<AxialSpec>,
    /// A convex hull.
    pub hull: Option<Box<HullSpec>>,
    /// Everything on one side of a plane; fixed and kinematic bodies only.
    pub half_space: Option<HalfSpaceSpec>,
    /// A triangle mesh; fixed and kinematic bodies only.
    pub mesh: Option<Box<MeshSpec>>,
    /// A grid of heights; fixed and kinematic bodies only.
    pub height_field: Option<Box<HeightFieldSpec>>,
    /// Several convex shapes as one.
    pub compound: Option<Box<CompoundSpec>>,
    /// A mesh cut into convex parts, for dynamic bodies.
    pub decompose: Option<Box<DecomposeSpec>>,
    /// Position in the body's frame, m.
    pub position: Option<[f32; 3]>,
    /// Rotation about fixed x, then y, then z, degrees.
    pub rotation_deg: Option<[f32; 3]>,
    /// Rotation as a quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    /// Density, kg/m³. Default 1000.
    pub density: Option<f32>,
    /// Mass, kg, instead of density.
    pub mass: Option<f32>,
    /// Name of a material.
    pub material: Option<String>,
    /// Drag and lift in the media that fields bring.
    pub aero: Option<AeroSpec>,
    /// Reports who is inside, touches nobody. Default false.
    pub sensor: Option<bool>,
    /// Layers the shape is on. Default 1 (layer 0).
    pub layer: Option<Layers>,
    /// Layers it meets. Default all.
    pub mask: Option<Layers>,
    /// Shapes of one positive group always meet, of one negative group never. Default 0.
    pub group: Option<i32>,
    /// Takes part. Default true.
    pub enabled: Option<bool>,
    /// Reports contact begin and end. Default true.
    pub contact_events: Option<bool>,
    /// Reports hits. Default false.
    pub hit_events: Option<bool>,
}

/// A ball.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereSpec {
    /// m.
    pub radius: f32,
}

/// A capsule, cylinder or cone along y.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxialSpec {
    /// Half height, m (of a capsule: without the caps).
    pub half_height: f32,
    /// m.
    pub radius: f32,
}

/// A box.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// Half extents, m.
    pub half: [f32; 3],
}

/// A convex hull of points, or of a mesh's vertices.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HullSpec {
    /// Points, m.
    pub points: Option<Vec<[f32; 3]>>,
    /// Name of a mesh.
    pub mesh: Option<String>,
}

/// All points with normal · x ≤ offset.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpaceSpec {
    /// Normal out of the solid; any length.
    pub normal: [f32; 3],
    /// Distance of the surface from the origin along the normal, m. Default 0.
    pub offset: Option<f32>,
}

/// A triangle mesh, by name or written out.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshSpec {
    /// Name of a mesh.
    pub mesh: Option<String>,
    /// Vertices, m (instead of `mesh`).
    pub vertices: Option<Vec<[f32; 3]>>,
    /// Triangles as three vertex numbers each, counter-clockwise seen from outside.
    pub triangles: Option<Vec<[u32; 3]>>,
    /// Both sides of each written-out triangle collide. Default false.
    pub double_sided: Option<bool>,
    /// Material by the file's material name (`usemtl`, glTF material); others have the shape's.
    #[serde(default)]
    pub triangle_materials: Map<String>,
}

/// Heights over a regular grid in x (columns) and z (rows), centred on the origin.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeightFieldSpec {
    /// Samples along x.
    pub columns: u64,
    /// Samples along z.
    pub rows: u64,
    /// Distance of samples, m: one number, or x and z. Default 1.
    pub spacing: Option<Spacing>,
    /// Heights, m: row after row, columns × rows numbers; null is a hole.
    pub heights: Option<Vec<Option<f32>>>,
    /// Heights by a function instead.
    pub function: Option<HeightFunctionSpec>,
    /// Largest height of the function, m. Default 1.
    pub amplitude: Option<f32>,
    /// Length of the waves or of the coarsest noise, m. Default 8 samples.
    pub wavelength: Option<f32>,
    /// Seed of the noise. Default 0.
    pub seed: Option<u64>,
    /// Layers of noise, each half as long and half as high, 1 to 8. Default 4.
    pub octaves: Option<u32>,
}

/// Height functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HeightFunctionSpec {
    /// A plane at height 0.
    Flat,
    /// Product of a sine in x and a sine in z.
    Waves,
    /// A paraboloid, `amplitude` high at the middle of the nearer border.
    Bowl,
    /// Smooth seeded noise.
    Noise,
}

/// Several convex shapes as one.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompoundSpec {
    /// Children: shapes with `position` and `rotation` only.
    pub children: Vec<ShapeSpec>,
}

/// A mesh cut into convex parts.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DecomposeSpec {
    /// Name of a mesh.
    pub mesh: String,
    /// Largest accepted concavity as a part of the mesh's size, 0 to 1. Default 0.01.
    pub concavity: Option<f32>,
    /// Cells along the longest side, 8 to 128. Default 64.
    pub resolution: Option<u32>,
    /// Most parts, 1 to 256. Default 64.
    pub parts_max: Option<u32>,
}
