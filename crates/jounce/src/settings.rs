//! What a world is made with.

use crate::error::{Result, check};
use crate::limits;
use jounce_math::Vec3;

/// Describes a new world.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldDesc {
    /// Uniform gravity, m/s². Default (0, −9.81, 0).
    pub gravity: Vec3,
    /// Steps per second, 1…10 000. Default 60.
    pub rate_hz: f64,
    /// Substeps of a step, 1…64. Default 4.
    pub substeps: u32,
    /// Everything else.
    pub settings: Settings,
}

impl Default for WorldDesc {
    fn default() -> Self {
        Self {
            gravity: Vec3::new(0.0, -9.81, 0.0),
            rate_hz: 60.0,
            substeps: 4,
            settings: Settings::default(),
        }
    }
}

impl WorldDesc {
    /// Refuses numbers that no world can have.
    ///
    /// # Errors
    /// Names the field.
    pub fn check(&self) -> Result<()> {
        let g = self.gravity;
        check(
            g.is_finite() && g.abs().max_component() <= 1e6,
            "world",
            "gravity",
            g,
            "finite, at most 1e6 m/s²",
        )?;
        check(
            (1.0..=10_000.0).contains(&self.rate_hz),
            "world",
            "rate_hz",
            self.rate_hz,
            "1 to 10000 steps per second",
        )?;
        let n = self.substeps;
        check((1..=limits::SUBSTEPS_MAX).contains(&n), "world", "substeps", n, "1 to 64")?;
        self.settings.check()
    }
}

/// Constants of the solver. The defaults were tuned over years by the soft-step engines; lengths scale with
/// [`Settings::length_unit`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Length of a typical object in metres ÷ 1 m: scales slop, margins and speed thresholds. Default 1.
    pub length_unit: f32,
    /// Stiffness of contacts between moving bodies, Hz. Default 30.
    pub contact_hertz: f32,
    /// Damping ratio of contacts between moving bodies. Default 10.
    pub contact_damping_ratio: f32,
    /// Stiffness of contacts against fixed and kinematic bodies, Hz. Default 60.
    pub static_contact_hertz: f32,
    /// Damping ratio of contacts against fixed and kinematic bodies. Default 5.
    pub static_contact_damping_ratio: f32,
    /// Stiffness of joints where they are solved row by row, Hz. Default 60. (Directly solved, they are rigid.)
    pub joint_hertz: f32,
    /// Damping ratio of joints where they are solved row by row. Default 2.
    pub joint_damping_ratio: f32,
    /// Fastest speed at which overlap is pushed out, m/s. Default 3.
    pub push_out_speed: f32,
    /// Approach speed below which contacts do not bounce, m/s. Default 1.
    pub restitution_speed: f32,
    /// Slip speed below which a sliding contact sticks again, m/s. Default 0.02.
    pub stick_speed: f32,
    /// Approach speed from which a contact reports a hit event, m/s. Default 1.
    pub hit_event_speed: f32,
    /// Bodies at rest fall asleep. Default true.
    pub sleep: bool,
    /// Speed of the farthest point of a body below which it counts as resting, m/s. Default 0.05.
    pub sleep_speed: f32,
    /// How long a whole island must rest before it sleeps, s. Default 0.5.
    pub sleep_time_s: f32,
    /// Continuous collision of fast bodies against fixed ones (bullets: against all). Default true.
    pub continuous: bool,
    /// Start each substep from the last impulses. Default true; false only to study convergence.
    pub warm_starting: bool,
    /// Recycle contacts whose bodies hardly moved against each other. Default true.
    pub recycle_contacts: bool,
    /// Speed limit of bodies, m/s. Default 400.
    pub linear_speed_max: f32,
    /// Spin limit as rotation per step, radians; bodies on joints may turn so far in a substep. Default π/4. Spheres and bodies with
    /// `fast_rotation` are exempt.
    pub rotation_per_step_max: f32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            length_unit: 1.0,
            contact_hertz: 30.0,
            contact_damping_ratio: 10.0,
            static_contact_hertz: 60.0,
            static_contact_damping_ratio: 5.0,
            joint_hertz: 60.0,
            joint_damping_ratio: 2.0,
            push_out_speed: 3.0,
            restitution_speed: 1.0,
            stick_speed: 0.02,
            hit_event_speed: 1.0,
            sleep: true,
            sleep_speed: 0.05,
            sleep_time_s: 0.5,
            continuous: true,
            warm_starting: true,
            recycle_contacts: true,
            linear_speed_max: 400.0,
            rotation_per_step_max: core::f32::consts::FRAC_PI_4,
        }
    }
}

impl Settings {
    /// Refuses numbers out of range.
    ///
    /// # Errors
    /// Names the field.
    pub fn check(&self) -> Result<()> {
        let range = |field, v: f32, lo: f32, hi: f32, expected| {
            check(v >= lo && v <= hi, "settings", field, v, expected)
        };
        range("length_unit", self.length_unit, 1e-4, 1e4, "1e-4 to 1e4")?;
        range("contact_hertz", self.contact_hertz, 0.1, 1e4, "0.1 to 10000 Hz")?;
        range("contact_damping_ratio", self.contact_damping_ratio, 0.0, 1e3, "0 to 1000")?;
        range("static_contact_hertz", self.static_contact_hertz, 0.1, 1e4, "0.1 to 10000 Hz")?;
        range("static_contact_damping_ratio", self.static_contact_damping_ratio, 0.0, 1e3, "0 to 1000")?;
        range("joint_hertz", self.joint_hertz, 0.1, 1e4, "0.1 to 10000 Hz")?;
        range("joint_damping_ratio", self.joint_damping_ratio, 0.0, 1e3, "0 to 1000")?;
        range("push_out_speed", self.push_out_speed, 0.0, 1e4, "0 to 10000 m/s")?;
        range("restitution_speed", self.restitution_speed, 0.0, 1e4, "0 to 10000 m/s")?;
        range("stick_speed", self.stick_speed, 0.0, 1e3, "0 to 1000 m/s")?;
        range("hit_event_speed", self.hit_event_speed, 0.0, 1e5, "0 to 100000 m/s")?;
        range("sleep_speed", self.sleep_speed, 0.0, 1e3, "0 to 1000 m/s")?;
        range("sleep_time_s", self.sleep_time_s, 0.0, 1e6, "0 to 1e6 s")?;
        range("linear_speed_max", self.linear_speed_max, 1e-3, limits::SPEED_MAX, "0.001 to 1e5 m/s")?;
        range("rotation_per_step_max", self.rotation_per_step_max, 1e-3, 1.5, "0.001 to 1.5 rad")
    }

    /// Overlap that is left alone, metres.
    pub fn slop(&self) -> f32 {
        0.005 * self.length_unit
    }
    /// How far ahead contacts are made, metres.
    pub fn speculative_margin(&self) -> f32 {
        0.02 * self.length_unit
    }
}
