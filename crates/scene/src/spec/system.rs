//! Points and springs of the textbook, and sources of particles.

use super::Layers;
use schemars::JsonSchema;
use serde::Deserialize;

/// Points and springs, integrated by a method of choice: exactly one of `points`, `cloth` and `jelly`. They feel the world's
/// gravity and fields and stay outside of its shapes, but push nothing.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SystemSpec {
    /// Name for probes.
    pub name: String,
    /// Single points, joined by `springs`.
    pub points: Option<Vec<PointSpec>>,
    /// Springs between points.
    #[serde(default)]
    pub springs: Vec<SpringSpec>,
    /// A cloth of structural, shear and bend springs.
    pub cloth: Option<Box<ClothSpec>>,
    /// A block of jelly of structural, shear and bend springs.
    pub jelly: Option<Box<JellySpec>>,
    /// How it is integrated. Default semi_implicit_euler.
    pub method: Option<MethodSpec>,
    /// Step of the method, s. Default: the world's substep.
    pub step_s: Option<f64>,
    /// Feels gravity and fields. Default true.
    pub fields: Option<bool>,
    /// Drag of every point against the flow, N s/m. Default 0.
    pub drag: Option<f64>,
    /// How points bounce off the world's shapes. Default: they pass through.
    pub collide: Option<SystemCollideSpec>,
    /// Radius of points in collisions, and half the width of what is drawn, m. Default 0.01.
    pub radius: Option<f32>,
    /// Colour in pictures, "#rrggbb".
    pub color: Option<String>,
    /// Draw the springs. Default: for points yes, for cloth and jelly no (their skin is drawn).
    pub show_springs: Option<bool>,
    /// Length of the trails behind points in pictures, s. Default none.
    pub trail_s: Option<f64>,
}

/// Methods of integration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MethodSpec {
    /// Position and velocity by the old slope.
    ExplicitEuler,
    /// The lecture's loop: position first, then velocity.
    LectureLoop,
    /// Velocity first, then position by the new velocity.
    SemiImplicitEuler,
    /// Second order, keeps the energy bounded.
    VelocityVerlet,
    /// Slope in the middle of the step.
    Midpoint,
    /// Runge and Kutta, fourth order.
    Rk4,
    /// By the slope at the end of the step; stable at any step.
    ImplicitEuler,
    /// Euler with steps of its own choice.
    AdaptiveEuler,
    /// Dormand and Prince, fifth order.
    Dopri5,
    /// Dormand and Prince with steps of its own choice.
    AdaptiveDopri5,
}

/// A point with mass.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointSpec {
    /// m.
    pub position: [f64; 3],
    /// m/s. Default [0, 0, 0].
    pub velocity: Option<[f64; 3]>,
    /// kg. Default 1.
    pub mass: Option<f64>,
    /// Stays where it is. Default false.
    pub frozen: Option<bool>,
}

/// A spring between two points.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringSpec {
    /// Numbers of two points.
    pub ends: [u32; 2],
    /// N/m.
    pub stiffness: f64,
    /// N s/m. Default 0.
    pub damping: Option<f64>,
    /// Length at rest, m. Default: the distance of the points.
    pub length: Option<f64>,
}

/// Stiffness and damping of a kind of spring.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElasticitySpec {
    /// N/m.
    pub stiffness: f64,
    /// N s/m. Default 0.
    pub damping: Option<f64>,
}

/// A rectangle of cloth.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClothSpec {
    /// Points along `across`.
    pub columns: u32,
    /// Points along `down`.
    pub rows: u32,
    /// First corner, m.
    pub origin: [f64; 3],
    /// The whole first row, m.
    pub across: [f64; 3],
    /// The whole first column, m.
    pub down: [f64; 3],
    /// Mass of the whole, kg.
    pub mass: f64,
    /// Springs between neighbours. Default 200 N/m, 0.02 N s/m.
    pub structural: Option<ElasticitySpec>,
    /// Springs along diagonals. Default 100 N/m, 0.02 N s/m.
    pub shear: Option<ElasticitySpec>,
    /// Springs to every other point. Default 10 N/m, 0.01 N s/m.
    pub bend: Option<ElasticitySpec>,
    /// What is held. Default nothing.
    pub pin: Option<PinSpec>,
}

/// What of a cloth is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PinSpec {
    /// The first column: a flag on its pole.
    FirstColumn,
    /// The first row: a curtain on its rail.
    FirstRow,
    /// The two ends of the first row.
    TwoCorners,
    /// All four corners.
    FourCorners,
}

/// A block of jelly.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JellySpec {
    /// Points along x, y and z.
    pub particles: [u32; 3],
    /// Middle, m.
    pub center: [f64; 3],
    /// Sides, m.
    pub size: [f64; 3],
    /// Mass of the whole, kg.
    pub mass: f64,
    /// Springs between neighbours. Default 100 N/m, 0.1 N s/m.
    pub structural: Option<ElasticitySpec>,
    /// Springs along diagonals. Default 50 N/m, 0.1 N s/m.
    pub shear: Option<ElasticitySpec>,
    /// Springs to every other point. Default 50 N/m, 0.1 N s/m.
    pub bend: Option<ElasticitySpec>,
}

/// Bounces of points: V_b = (1 - friction) V_t - restitution V_n.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SystemCollideSpec {
    /// K_r, 0 to 1. Default 0.
    pub restitution: Option<f64>,
    /// K_f, 0 to 1. Default 0.1.
    pub friction: Option<f64>,
}

/// A source of particles: a `preset`, or one described by everything else.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmitterSpec {
    /// Name for probes and the timeline.
    pub name: Option<String>,
    /// A ready effect; beside it there may be `name`, `body`, `position`, `scale`, `seed`, `delay_s`, `collision` and
    /// `enabled`.
    pub preset: Option<PresetSpec>,
    /// Size of a preset, m. Default 1.
    pub scale: Option<f32>,
    /// Where particles are born. Default a point.
    pub shape: Option<EmitterShapeSpec>,
    /// m. On a body: in its frame. Default [0, 0, 0].
    pub position: Option<[f64; 3]>,
    /// Degrees about fixed x, then y, then z.
    pub rotation_deg: Option<[f32; 3]>,
    /// Name of a body that carries it.
    pub body: Option<String>,
    /// Direction in the emitter's frame; any length. Default [0, 1, 0].
    pub direction: Option<[f32; 3]>,
    /// Away from the shape instead of along `direction`. Default false.
    pub outward: Option<bool>,
    /// Half angle around the direction, degrees. Default 0.
    pub spread_deg: Option<f32>,
    /// Lowest and highest speed, m/s. Default [1, 1].
    pub speed: Option<[f32; 2]>,
    /// Particles per second. Default 0.
    pub rate: Option<f64>,
    /// Many at once.
    #[serde(default)]
    pub bursts: Vec<BurstSpec>,
    /// s. Default 0.
    pub delay_s: Option<f64>,
    /// s. Default without end.
    pub duration_s: Option<f64>,
    /// Begins again after the duration. Default false.
    pub looping: Option<bool>,
    /// Shortest and longest lifetime, s. Default [1, 1].
    pub lifetime_s: Option<[f32; 2]>,
    /// Mass of a particle, kg. Default 0.001.
    pub mass: Option<f32>,
    /// Smallest and largest radius, m. Default [0.01, 0.01].
    pub radius: Option<[f32; 2]>,
    /// [time 0 to 1, factor] of what is drawn.
    pub size_over_life: Option<Vec<[f32; 2]>>,
    /// [time 0 to 1, red, green, blue, opacity]; linear light, above 1 it glows.
    pub color_over_life: Option<Vec<[f32; 5]>>,
    /// Factor on gravity. Default 1.
    pub gravity_scale: Option<f32>,
    /// Drag at a rate, 1/s. Default 0.
    pub linear_drag: Option<f32>,
    /// C_d in the medium of the fields. Default 0.47.
    pub drag_coefficient: Option<f32>,
    /// Irregular flow.
    pub turbulence: Option<TurbulenceSpec>,
    /// Hot particles rise.
    pub heat: Option<HeatSpec>,
    /// How particles meet shapes. Default not at all.
    pub collision: Option<ParticleCollisionSpec>,
    /// Particles below this height die, m.
    pub kill_below: Option<f64>,
    /// Layers it is on, for fields and blasts. Default 1 (layer 0).
    pub layers: Option<Layers>,
    /// Most particles at a time. Default 100000.
    pub max_particles: Option<u32>,
    /// Seed. Default 0.
    pub seed: Option<u64>,
    /// Bears particles. Default true.
    pub enabled: Option<bool>,
}

/// Ready effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PresetSpec {
    /// Flash, fire ball, sparks and smoke.
    Explosion,
    /// A column of smoke.
    Smoke,
    /// Flames, embers and smoke.
    Fire,
    /// A jet of drops along x.
    Spray,
    /// Water thrown up.
    Fountain,
    /// Glowing grains.
    Sparks,
    /// A puff along the ground.
    Dust,
    /// Snow from a cloud.
    Snow,
    /// A wall of fire that spreads over a planet; `position` is its centre, `scale` its radius.
    Genesis,
}

/// Where particles are born: exactly one of them.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmitterShapeSpec {
    /// A ball by volume: radius, m.
    pub sphere: Option<f32>,
    /// The surface of a ball: radius, m.
    pub sphere_surface: Option<f32>,
    /// A disc across y: radius, m.
    pub disc: Option<f32>,
    /// A nozzle along y.
    pub cone: Option<NozzleSpec>,
    /// A box: half extents, m.
    #[serde(rename = "box")]
    pub cuboid: Option<[f32; 3]>,
    /// The surface of a mesh: its name.
    pub mesh: Option<String>,
}

/// A nozzle.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NozzleSpec {
    /// Degrees.
    pub half_angle_deg: f32,
    /// m. Default 0.
    pub radius: Option<f32>,
}

/// Many particles at one time.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BurstSpec {
    /// s. Default 0.
    pub time_s: Option<f64>,
    /// How many.
    pub count: u32,
}

/// Irregular flow without divergence.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurbulenceSpec {
    /// Root mean square speed, m/s.
    pub speed: f32,
    /// Size of an eddy, m.
    pub size: f32,
    /// Time in which an eddy changes, s. Default 1.
    pub time_s: Option<f32>,
    /// Seed. Default 0.
    pub seed: Option<u64>,
}

/// Heat of particles.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeatSpec {
    /// Temperature above the surroundings at birth, K.
    pub excess: f32,
    /// Temperature of the surroundings, K. Default 293.
    pub ambient: Option<f32>,
    /// Time in which the excess falls to 1/e, s.
    pub cooling_s: f32,
}

/// How particles meet shapes.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticleCollisionSpec {
    /// K_r, 0 to 1. Default 0.3.
    pub restitution: Option<f32>,
    /// K_f, 0 to 1. Default 0.1.
    pub friction: Option<f32>,
    /// What a hit does. Default bounce.
    pub response: Option<HitResponseSpec>,
    /// Hits push dynamic bodies. Default false.
    pub push: Option<bool>,
    /// Layers of shapes it meets. Default all.
    pub mask: Option<Layers>,
}

/// What a hit does to a particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HitResponseSpec {
    /// It bounces.
    Bounce,
    /// It stays where it hit.
    Stick,
    /// It dies.
    Kill,
}

/// Lets an emitter bear particles at once.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmitSpec {
    /// Name of the emitter.
    pub emitter: String,
    /// How many.
    pub count: u32,
}

/// Switches an emitter on or off.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetEmitterSpec {
    /// Name of the emitter.
    pub emitter: String,
    /// On or off.
    pub enabled: bool,
}
