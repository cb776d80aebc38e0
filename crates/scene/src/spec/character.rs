//! Characters: who walks.

use super::{Layers, RepeatSpec};
use schemars::JsonSchema;
use serde::Deserialize;

/// A character, or many equal ones: an upright capsule that walks.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CharacterSpec {
    /// Name for probes, the camera and the timeline, also of its body; with `repeat` the copies are `name[0]`, `name[1]`, ….
    pub name: Option<String>,
    /// Where its foot stands, m. Default [0, 0, 0].
    pub position: Option<[f64; 3]>,
    /// Turn about up, degrees; at 0 it looks along z. Default 0.
    pub heading_deg: Option<f32>,
    /// Led by forces, as a dynamic body on a spring leg. Without it the character is a kinematic walker.
    pub dynamic: Option<DynamicCharacterSpec>,
    /// Radius of the capsule, m. Default 0.3.
    pub radius: Option<f32>,
    /// From foot to crown, m. Default 1.8.
    pub height: Option<f32>,
    /// Height while it crouches, m. Default 1.
    pub crouch_height: Option<f32>,
    /// Direction from foot to crown. Default [0, 1, 0].
    pub up: Option<[f32; 3]>,
    /// Steepest ground to walk on, degrees, 0 to 90. Default 45.
    pub slope_max_deg: Option<f32>,
    /// Highest step that is climbed, m. Default 0.35.
    pub step_height: Option<f32>,
    /// How far down it is kept on falling ground, m. Default 0.4.
    pub snap: Option<f32>,
    /// Gap that is kept to everything, m. Default 0.01.
    pub skin: Option<f32>,
    /// Layers of platforms that only carry from above. Default none.
    pub one_way_layers: Option<Layers>,
    /// Its weight on what it stands on, kg. Default 80.
    pub mass: Option<f32>,
    /// Most force on what is in its way, N. Default 300.
    pub push_force: Option<f32>,
    /// How fast it changes its velocity on the ground, m/s². Default 60.
    pub acceleration: Option<f32>,
    /// And in the air, m/s². Default 5.
    pub air_acceleration: Option<f32>,
    /// Factor on gravity. Default 1.
    pub gravity_scale: Option<f32>,
    /// Fastest fall, m/s. Default 60.
    pub fall_speed_max: Option<f32>,
    /// Turns with a platform that turns. Default true.
    pub turns_with_ground: Option<bool>,
    /// Layers it is on. Default 1 (layer 0).
    pub layer: Option<Layers>,
    /// Layers it meets. Default all.
    pub mask: Option<Layers>,
    /// Shapes of one positive group always meet, of one negative group never. Default 0.
    pub group: Option<i32>,
    /// Velocity that it wants from the start, m/s. Default [0, 0, 0].
    pub velocity: Option<[f32; 3]>,
    /// Crouches from the start. Default false.
    pub crouch: Option<bool>,
    /// Colour, "#rrggbb".
    pub color: Option<String>,
    /// Copies, on a grid as bodies; they are not turned.
    pub repeat: Option<RepeatSpec>,
}

/// A spring leg.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DynamicCharacterSpec {
    /// Stiffness of the leg, Hz. Default 6.
    pub leg_hertz: Option<f32>,
    /// Damping ratio of the leg. Default 1.
    pub leg_damping_ratio: Option<f32>,
    /// Strength of walking, N. Default 2000.
    pub force: Option<f32>,
}

/// What characters do from now on; what is absent stays as it is.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WalkSpec {
    /// Name of one or many characters.
    pub character: String,
    /// Wanted velocity against the ground, m/s.
    pub velocity: Option<[f32; 3]>,
    /// Jumps once, at this speed, m/s.
    pub jump: Option<f32>,
    /// Crouches, or stands up as soon as there is headroom.
    pub crouch: Option<bool>,
    /// Falls once through the one-way platform it stands on. Default false.
    pub drop_through: Option<bool>,
    /// Turns at once, degrees.
    pub heading_deg: Option<f32>,
}
