//! Numbers for the tests of this folder.

use jounce_math::{Quat, Vec3};

/// The same row of numbers for the same seed (a linear congruential generator, its upper bits).
pub(super) struct Random(pub u32);

impl Random {
    /// From −1 to 1.
    pub fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (self.0 >> 8) as f32 / (1 << 23) as f32 - 1.0
    }
    pub fn vec(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
    /// A turn by up to an angle about any axis.
    pub fn quat(&mut self, angle: f32) -> Quat {
        Quat::from_axis_angle(self.vec().normalize_or(Vec3::Y), angle * self.next())
    }
}
