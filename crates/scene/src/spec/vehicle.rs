//! Vehicles: what is between a body and the ground, who drives it, and where to.

use super::{Layers, MassPropertiesSpec, RepeatSpec};
use schemars::JsonSchema;
use serde::Deserialize;

/// A vehicle, or many equal ones. With `preset` it brings its own chassis, and every other key changes something of the preset;
/// without, `body` names the chassis and `wheels` or `board` say what is under it. Forward is the chassis' z, up its y.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VehicleSpec {
    /// Name for probes, the camera and the timeline, also of a preset's chassis; with `repeat` the copies are `name[0]`,
    /// `name[1]`, ….
    pub name: Option<String>,
    /// A vehicle to start from.
    pub preset: Option<VehiclePresetSpec>,
    /// Name of a dynamic body that is the chassis, instead of a preset's own.
    pub body: Option<String>,
    /// Where the point on the ground under the middle of a preset's chassis is, m. Default [0, 0, 0].
    pub position: Option<[f64; 3]>,
    /// Turn about fixed x, then y, then z, degrees.
    pub rotation_deg: Option<[f32; 3]>,
    /// The same as a quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    /// Of a preset's chassis, m/s; wheels stand still at first.
    pub velocity: Option<[f32; 3]>,
    /// rad/s.
    pub angular_velocity: Option<[f32; 3]>,
    /// Mass of a preset's chassis, wheels too; the springs carry it.
    pub mass_properties: Option<MassPropertiesSpec>,
    /// Colour of a preset's chassis, "#rrggbb".
    pub color: Option<String>,
    /// Where it drives to, in the chassis' axes. Default [0, 0, 1].
    pub forward: Option<[f32; 3]>,
    /// Up, across `forward`. Default [0, 1, 0].
    pub up: Option<[f32; 3]>,
    /// What all wheels have.
    pub wheel: Option<Box<WheelSpec>>,
    /// Wheels one by one: changes of a preset's, in its order (front left, front right, rear left, rear right; of a motorcycle
    /// front, rear; of a tank the left side, then the right, front to rear); without a preset the wheels themselves.
    #[serde(default)]
    pub wheels: Vec<WheelSpec>,
    /// Anti-roll bars.
    pub anti_roll: Option<Vec<AntiRollSpec>>,
    /// Engine; what is absent is the preset's, or the `car`'s. Without a preset an engine needs `axles`.
    pub engine: Option<EngineSpec>,
    /// Clutch.
    pub clutch: Option<ClutchSpec>,
    /// Gearbox.
    pub gearbox: Option<GearboxSpec>,
    /// Driven axles.
    pub axles: Option<Vec<DifferentialSpec>>,
    /// What shares torque between neighbouring axles.
    pub center: Option<DifferentialKindSpec>,
    /// Wheels that turn as one.
    pub tracks: Option<Vec<TrackSpec>>,
    /// Steering by the difference of two tracks.
    pub track_steer: Option<TrackSteerSpec>,
    /// 1: wheels are steered about one point; 0: all by the same angle. Default 1.
    pub ackermann: Option<f32>,
    /// Keeps braked wheels from locking.
    pub abs: Option<SlipControlSpec>,
    /// Keeps driven wheels from spinning.
    pub traction: Option<SlipControlSpec>,
    /// Drag and downforce.
    pub aero: Option<Vec<AeroSurfaceSpec>>,
    /// Lean of a motorcycle; what is absent is the `motorcycle`'s.
    pub lean: Option<LeanSpec>,
    /// A snowboard instead of wheels; what is absent is the `snowboard`'s.
    pub board: Option<BoardSpec>,
    /// Layers of shapes to stand on. Default all.
    pub ground_layers: Option<Layers>,
    /// Takes part. Default true.
    pub enabled: Option<bool>,
    /// What the driver does from the start.
    pub input: Option<VehicleInputSpec>,
    /// A driver who follows a line, until the first `drive` of the timeline.
    pub route: Option<Box<RouteSpec>>,
    /// Copies of a preset, on a grid as bodies.
    pub repeat: Option<RepeatSpec>,
}

/// Vehicles to start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum VehiclePresetSpec {
    /// 1,300 kg, front-wheel drive, automatic gearbox, ABS, traction control.
    Car,
    /// 1,200 kg, rear-wheel drive, limited-slip differential, wings, no electronics.
    SportsCar,
    /// 2,000 kg, all wheels driven and locked, long travel.
    OffRoad,
    /// 260 kg with its rider, leans into its turns.
    Motorcycle,
    /// 20 t on two tracks of five wheels.
    Tank,
    /// A rider of 80 kg on a board of 8 m side-cut.
    Snowboard,
}

/// A wheel on its suspension; what is absent is the preset's, or that of a car's wheel of 0.3 m radius and 20 kg.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WheelSpec {
    /// Hub at rest, in the chassis' frame, m; its own for each wheel.
    pub position: Option<[f32; 3]>,
    /// m, to 10.
    pub radius: Option<f32>,
    /// m, to 10.
    pub width: Option<f32>,
    /// Unsprung mass, kg: a part of the chassis' mass.
    pub mass: Option<f32>,
    /// About the axle, kg m².
    pub inertia: Option<f32>,
    /// Way up from rest to the hard stop, m.
    pub bump: Option<f32>,
    /// Way down, m.
    pub droop: Option<f32>,
    /// Force of the spring at rest, N: the wheel's share of the weight. Needed without a preset.
    pub preload: Option<f32>,
    /// Spring, N/m.
    pub stiffness: Option<f32>,
    /// Damper on the way up, N s/m.
    pub bump_damping: Option<f32>,
    /// Damper on the way down, N s/m.
    pub rebound_damping: Option<f32>,
    /// Length of the rubber before the hard stop, m.
    pub bump_stop: Option<f32>,
    /// Spring of the rubber, N/m.
    pub bump_stop_stiffness: Option<f32>,
    /// Angle at full steering, degrees; negative steers the other way.
    pub steer_deg: Option<f32>,
    /// Torque at full brake, N m.
    pub brake: Option<f32>,
    /// Torque of the handbrake, N m.
    pub handbrake: Option<f32>,
    /// Tyre.
    pub tyre: Option<TyreSpec>,
    /// How it looks for the ground. Default cylinder.
    pub cast: Option<WheelCastSpec>,
}

/// How a wheel looks for the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WheelCastSpec {
    /// A cylinder of the wheel's size.
    Cylinder,
    /// A ball of the wheel's radius.
    Sphere,
    /// A ray from the hub.
    Ray,
}

/// A tyre.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TyreSpec {
    /// Coulomb coefficient while it grips.
    pub static_friction: Option<f32>,
    /// Coulomb coefficient when it slides; not above the static one.
    pub kinetic_friction: Option<f32>,
    /// Longitudinal force per slip ratio and load.
    pub slip_stiffness: Option<f32>,
    /// Lateral force per slip angle and load, 1/rad.
    pub cornering_stiffness: Option<f32>,
    /// Way on which a force builds up, m.
    pub relaxation_length: Option<f32>,
    /// Spring against the ground, N/m.
    pub radial_stiffness: Option<f32>,
    /// Damper likewise, N s/m.
    pub radial_damping: Option<f32>,
    /// Torque against rolling ÷ (load × radius).
    pub rolling_resistance: Option<f32>,
    /// Share of friction lost for each nominal load beyond the first.
    pub load_sensitivity: Option<f32>,
    /// N.
    pub nominal_load: Option<f32>,
}

/// A bar between two wheels.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AntiRollSpec {
    /// Number of a wheel, from 0.
    pub left: usize,
    /// Number of another.
    pub right: usize,
    /// Force per difference of travels, N/m.
    pub stiffness: f32,
}

/// An engine.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EngineSpec {
    /// Full torque: [1/min, N m], rising in 1/min, linear between.
    pub torque: Option<Vec<[f32; 2]>>,
    /// kg m².
    pub inertia: Option<f32>,
    /// Speed that it keeps by itself, 1/min.
    pub idle_rpm: Option<f32>,
    /// Speed from which it gets no fuel, 1/min.
    pub limit_rpm: Option<f32>,
    /// Torque against turning without throttle, N m.
    pub drag: Option<f32>,
}

/// A clutch.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClutchSpec {
    /// Most torque, N m.
    pub torque: Option<f32>,
    /// Closes by itself from the first to the second of these engine speeds, 1/min.
    pub auto_rpm: Option<[f32; 2]>,
    /// Left to the pedal instead. Default false.
    pub manual: Option<bool>,
}

/// A gearbox.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GearboxSpec {
    /// Ratios of the forward gears.
    pub forward: Option<Vec<f32>>,
    /// Ratio of the reverse gear.
    pub reverse: Option<f32>,
    /// Ratio from there to the wheels.
    pub final_drive: Option<f32>,
    /// Time without drive in a change of gear, s.
    pub shift_s: Option<f32>,
    /// Changes up and down by itself at these engine speeds, 1/min.
    pub auto_rpm: Option<[f32; 2]>,
    /// By hand instead. Default false.
    pub manual: Option<bool>,
}

/// A driven axle.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DifferentialSpec {
    /// Number of the left wheel.
    pub left: usize,
    /// Number of the right wheel; the same as `left` for a chain to one wheel.
    pub right: usize,
    /// How it shares torque. Default open.
    pub kind: Option<DifferentialKindSpec>,
    /// Part of the torque, 0 to 1; together 1. Default 1.
    pub share: Option<f32>,
}

/// What shares torque between two sides.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DifferentialKindSpec {
    /// The same torque on both.
    Open,
    /// The same speed on both.
    Locked,
    /// Holds the sides together up to a torque.
    LimitedSlip(LimitedSlipSpec),
}

/// A limited-slip differential: preload + lock × torque in.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitedSlipSpec {
    /// N m.
    pub preload: f32,
    /// 0 to 1 and above.
    pub lock: f32,
}

/// Wheels that turn at one surface speed.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrackSpec {
    /// Numbers of its wheels, at least two.
    pub wheels: Vec<usize>,
}

/// Steering by the difference of two tracks' speeds.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrackSteerSpec {
    /// Number of a wheel of the left track.
    pub left: usize,
    /// And of the right one.
    pub right: usize,
    /// Difference of the wheels' speeds at full steering, rad/s.
    pub speed: f32,
    /// Most torque for it, N m.
    pub torque: f32,
}

/// Keeps slip within bounds.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SlipControlSpec {
    /// Slip ratio from which it lets go. Default 0.1.
    pub slip: Option<f32>,
    /// Full torques a second. Default 10.
    pub rate: Option<f32>,
    /// Default true; false takes a preset's off.
    pub enabled: Option<bool>,
}

/// Air on the chassis, at a point.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AeroSurfaceSpec {
    /// In the chassis' frame, m. Default [0, 0, 0].
    pub position: Option<[f32; 3]>,
    /// C_d A, m². Default 0.
    pub drag_area: Option<f32>,
    /// C_l A, m², pushing down. Default 0.
    pub down_area: Option<f32>,
    /// kg/m³. Default 1.2.
    pub density: Option<f32>,
}

/// Lean of a motorcycle.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeanSpec {
    /// Steepest lean, degrees.
    pub angle_max_deg: Option<f32>,
    /// How fast it gets there, Hz.
    pub hertz: Option<f32>,
    /// Damping ratio of that.
    pub damping_ratio: Option<f32>,
    /// From front to rear hub, m.
    pub wheelbase: Option<f32>,
}

/// A snowboard.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoardSpec {
    /// Middle of the base, in the chassis' frame, m.
    pub position: Option<[f32; 3]>,
    /// Length of the edges on the snow, m.
    pub length: Option<f32>,
    /// Width at the waist, m.
    pub width: Option<f32>,
    /// Radius of the side-cut, m.
    pub sidecut: Option<f32>,
    /// Friction along the base.
    pub friction: Option<f32>,
    /// Resistance of the snow against a set edge ÷ load.
    pub edge_friction: Option<f32>,
    /// Edge angle from which the edge is set in full, degrees.
    pub edge_angle_deg: Option<f32>,
    /// Steepest edge angle of the rider, degrees.
    pub lean_max_deg: Option<f32>,
    /// How fast the rider gets there, Hz.
    pub hertz: Option<f32>,
    /// Damping ratio of that.
    pub damping_ratio: Option<f32>,
    /// Stiffness of snow and legs, N/m.
    pub stiffness: Option<f32>,
    /// Damping likewise, N s/m.
    pub damping: Option<f32>,
    /// How far legs give, m.
    pub reach: Option<f32>,
    /// Speed of a jump, m/s.
    pub jump_speed: Option<f32>,
}

/// What a driver does; what is absent is 0.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VehicleInputSpec {
    /// 0 to 1.
    pub throttle: Option<f32>,
    /// 0 to 1.
    pub brake: Option<f32>,
    /// 0 to 1.
    pub handbrake: Option<f32>,
    /// −1 (full left) to 1 (full right).
    pub steer: Option<f32>,
    /// Clutch pedal, 0 to 1 (pressed).
    pub clutch: Option<f32>,
    /// −1 reverse, 0 neutral, 1 and on.
    pub gear: Option<i32>,
    /// Boards: edge angle, −1 (left edge) to 1 (right edge).
    pub lean: Option<f32>,
    /// Boards: jumps as it goes from 0 to 1.
    pub jump: Option<f32>,
}

/// What a driver does from now on; what is absent stays.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DriveSpec {
    /// Name of one or many vehicles.
    pub vehicle: String,
    /// 0 to 1.
    pub throttle: Option<f32>,
    /// 0 to 1.
    pub brake: Option<f32>,
    /// 0 to 1.
    pub handbrake: Option<f32>,
    /// −1 (full left) to 1 (full right).
    pub steer: Option<f32>,
    /// Clutch pedal, 0 to 1 (pressed).
    pub clutch: Option<f32>,
    /// −1 reverse, 0 neutral, 1 and on.
    pub gear: Option<i32>,
    /// Boards: edge angle, −1 (left edge) to 1 (right edge).
    pub lean: Option<f32>,
    /// Boards: jumps as it goes from 0 to 1.
    pub jump: Option<f32>,
    /// How long pedals, steering and lean take to get there, s. Default 0: at once.
    pub duration: Option<f64>,
}

/// A driver who follows a line: steers for the circle through a point ahead on it (pure pursuit), and brakes in time for slower
/// parts.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RouteSpec {
    /// Corners of the line, m; at least two.
    pub points: Vec<[f64; 3]>,
    /// Is the last point joined to the first? Default false: the vehicle brakes to a stop at the end.
    pub closed: Option<bool>,
    /// Speed, m/s.
    pub speed: Option<f32>,
    /// Speeds from each point to the next, m/s, instead of one `speed`.
    pub speeds: Option<Vec<f32>>,
    /// How far ahead the driver looks, m. Default 4.
    pub look_ahead: Option<f32>,
    /// And how far in addition, as a time at the present speed, s. Default 0.35.
    pub look_ahead_s: Option<f32>,
    /// Deceleration that the driver counts on before slower parts, m/s². Default 4.
    pub deceleration: Option<f32>,
}
