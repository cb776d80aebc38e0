//! Fields at a point: what particles and other matter without shape feel.

use super::state::Fields;
use jounce_math::{DVec3, Vec3};

/// What all fields together say at one place and time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sample {
    /// Acceleration by uniform, point, user and frame fields, without the world's own gravity, m/s².
    pub acceleration: Vec3,
    /// Velocity of the medium, m/s.
    pub flow: Vec3,
    /// Density of the medium, kg/m³; 0 in a vacuum.
    pub density: f32,
    /// Viscosity of the medium, Pa s.
    pub viscosity: f32,
    /// Under a liquid's surface: the medium is that liquid, and buoyancy is not in `acceleration`.
    pub submerged: bool,
}

impl Fields {
    /// What acts on matter of these layers at `at`, moving with `velocity`.
    pub fn sample(&self, at: DVec3, velocity: Vec3, layers: u32) -> Sample {
        let _ = (at, velocity, layers);
        Sample::default()
    }
}
