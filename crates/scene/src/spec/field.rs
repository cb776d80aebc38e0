//! Fields, and how shapes meet the medium around them.

use super::Layers;
use schemars::JsonSchema;
use serde::Deserialize;

/// A law that acts on everything in a region: exactly one of `uniform`, `point`, `n_body`, `wind`, `drag`, `water`, `vortex`
/// and `rotating_frame`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldSpec {
    /// Name for the timeline.
    pub name: Option<String>,
    /// The same acceleration everywhere, on top of gravity.
    pub uniform: Option<UniformSpec>,
    /// Attraction by a point: a = -mu d/(d² + softening²)^(3/2).
    pub point: Option<PointFieldSpec>,
    /// The bodies named attract one another.
    pub n_body: Option<NBodySpec>,
    /// The medium moves. Without a `drag` field it is air of 1.2 kg/m³.
    pub wind: Option<WindSpec>,
    /// A medium: drag and lift of everything that moves through it.
    pub drag: Option<MediumSpec>,
    /// Still water or another liquid below a plane: buoyancy and drag.
    pub water: Option<Box<WaterSpec>>,
    /// A whirl of the medium about an axis.
    pub vortex: Option<Box<VortexSpec>>,
    /// The world's axes turn: centrifugal, Coriolis and Euler forces.
    pub rotating_frame: Option<RotatingFrameSpec>,
    /// Where it acts. Default everywhere.
    pub region: Option<FieldRegionSpec>,
    /// Layers of the shapes and emitters it acts on. Default all.
    pub layers: Option<Layers>,
    /// Acts at all. Default true.
    pub enabled: Option<bool>,
}

/// Where a field acts: exactly one of `sphere` and `box`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldRegionSpec {
    /// A ball.
    pub sphere: Option<FieldSphereSpec>,
    /// A box along the axes.
    #[serde(rename = "box")]
    pub cuboid: Option<FieldBoxSpec>,
    /// Width of the rim in which the strength falls to zero, m. Default 0.
    pub falloff: Option<f64>,
}

/// A ball in the world.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldSphereSpec {
    /// m.
    pub center: [f64; 3],
    /// m.
    pub radius: f64,
}

/// A box in the world.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldBoxSpec {
    /// m.
    pub center: [f64; 3],
    /// Half extents, m.
    pub half: [f64; 3],
}

/// The same acceleration everywhere.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UniformSpec {
    /// m/s².
    pub acceleration: [f32; 3],
}

/// Attraction by a point: `mu`, or `mass` times the constant of gravitation.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointFieldSpec {
    /// m.
    pub center: [f64; 3],
    /// G M, m³/s²; negative repels.
    pub mu: Option<f64>,
    /// M, kg, instead of `mu`, with G = 6.67430e-11.
    pub mass: Option<f64>,
    /// m. Default 0.
    pub softening: Option<f64>,
}

/// Attraction of bodies by one another.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NBodySpec {
    /// Names of one or many bodies each.
    pub bodies: Vec<String>,
    /// Constant of gravitation, m³/(kg s²). Default 6.67430e-11.
    pub g: Option<f64>,
    /// m. Default 0.
    pub softening: Option<f64>,
}

/// A moving medium.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WindSpec {
    /// Steady part, m/s.
    pub velocity: [f32; 3],
    /// Irregular part.
    pub gust: Option<GustSpec>,
}

/// Irregular part of a wind.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GustSpec {
    /// Root mean square of each component, m/s.
    pub speed: f32,
    /// Size of an eddy, m. Default 5.
    pub size: Option<f32>,
    /// Time in which an eddy changes, s. Default 2.
    pub time_s: Option<f32>,
    /// Seed. Default 0.
    pub seed: Option<u64>,
}

/// A medium.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MediumSpec {
    /// kg/m³. Default 1.2: air.
    pub density: Option<f32>,
    /// Pa s. Default 1.81e-5: air.
    pub viscosity: Option<f32>,
}

/// A liquid with a surface.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaterSpec {
    /// Height of the surface, m (y up). Default 0.
    pub level: Option<f64>,
    /// A point of the surface, m, instead of `level`.
    pub surface: Option<[f64; 3]>,
    /// Normal of the surface, out of the water; any length. Default [0, 1, 0].
    pub normal: Option<[f32; 3]>,
    /// kg/m³. Default 1000.
    pub density: Option<f32>,
    /// Pa s. Default 0.001.
    pub viscosity: Option<f32>,
    /// Extra linear drag per mass of displaced water, 1/s. Default 0.5.
    pub linear_drag: Option<f32>,
    /// Velocity of the stream, m/s. Default [0, 0, 0].
    pub velocity: Option<[f32; 3]>,
}

/// A whirl about an axis.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VortexSpec {
    /// A point of the axis, m.
    pub center: [f64; 3],
    /// Direction of the axis; any length. Default [0, 1, 0].
    pub axis: Option<[f32; 3]>,
    /// Speed at the rim of the core, m/s.
    pub speed: f32,
    /// Radius of the core, m.
    pub core_radius: f32,
    /// Part of the speed that points to the axis. Default 0.
    pub inflow: Option<f32>,
    /// Speed along the axis in the core, m/s. Default 0.
    pub updraft: Option<f32>,
}

/// Turning axes.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotatingFrameSpec {
    /// A point of the axis, m. Default [0, 0, 0].
    pub origin: Option<[f64; 3]>,
    /// rad/s.
    pub angular_velocity: [f32; 3],
    /// rad/s². Default [0, 0, 0].
    pub angular_acceleration: Option<[f32; 3]>,
}

/// How a shape meets the medium around it.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AeroSpec {
    /// Drag coefficient. Default by kind: sphere 0.47, capsule 0.6, box 1.05, cylinder 0.9, cone 0.7, hull 0.9.
    pub drag: Option<f32>,
    /// Reference area, m². Default: the area of the shape's shadow along the flow.
    pub area: Option<f32>,
    /// Lift of spinning bodies, F = lift ½ρ A r ω×u; about 1 for balls. Default 0.
    pub lift: Option<f32>,
    /// Radius of Stokes' drag, m. Default: that of the ball of equal volume.
    pub stokes_radius: Option<f32>,
}

/// A blast.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExplodeSpec {
    /// m.
    pub center: [f64; 3],
    /// Reach, m.
    pub radius: f32,
    /// Impulse per exposed area at the centre, N s/m²; falls off as (1 - r/radius)².
    pub impulse: f32,
    /// Fixed bodies shield what is behind them. Default true.
    pub occlusion: Option<bool>,
    /// Layers of the shapes it acts on. Default all.
    pub layers: Option<Layers>,
}

/// Switches a field on or off.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetFieldSpec {
    /// Name of the field.
    pub field: String,
    /// On or off.
    pub enabled: bool,
}
