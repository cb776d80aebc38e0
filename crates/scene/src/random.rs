//! Seeded numbers by counting: number n of a stream is a hash of (seed, stream, n), so that no order of calls and
//! no machine can change a scene. The mixer is the finaliser of SplitMix64 (Steele, Lea, Flood 2014).

use jounce::math::{DVec3, Quat, Vec3};

#[derive(Clone, Copy, Debug)]
pub(crate) struct Stream {
    key: u64,
    n: u64,
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

impl Stream {
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        let key =
            mix(seed.wrapping_add(0x9E37_79B9_7F4A_7C15)) ^ mix(stream.wrapping_mul(0xD1B5_4A32_D192_ED03));
        Self { key: mix(key), n: 0 }
    }

    pub(crate) fn bits(&mut self) -> u64 {
        self.n = self.n.wrapping_add(1);
        mix(self.key.wrapping_add(self.n.wrapping_mul(0x9E37_79B9_7F4A_7C15)))
    }

    /// Uniform in [0, 1), 53 bits.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Uniform in [-1, 1).
    pub(crate) fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Uniform in ± `amount` along each axis.
    pub(crate) fn around(&mut self, amount: [f64; 3]) -> DVec3 {
        DVec3::new(self.signed() * amount[0], self.signed() * amount[1], self.signed() * amount[2])
    }

    /// As [`Self::around`], single precision.
    pub(crate) fn around_f32(&mut self, amount: [f32; 3]) -> Vec3 {
        self.around(amount.map(f64::from)).as_vec3()
    }

    /// Uniform over all rotations: a point of the unit ball in four dimensions, normalised (no sine needed).
    pub(crate) fn rotation(&mut self) -> Quat {
        for _ in 0..64 {
            let (x, y, z, w) = (self.signed(), self.signed(), self.signed(), self.signed());
            let l = x * x + y * y + z * z + w * w;
            if l > 1e-4 && l <= 1.0 {
                return Quat::new(x as f32, y as f32, z as f32, w as f32).normalize();
            }
        }
        Quat::IDENTITY
    }

    /// Uniform turn about y.
    pub(crate) fn yaw(&mut self) -> Quat {
        for _ in 0..64 {
            let (y, w) = (self.signed(), self.signed());
            let l = y * y + w * w;
            if l > 1e-4 && l <= 1.0 {
                return Quat::new(0.0, y as f32, 0.0, w as f32).normalize();
            }
        }
        Quat::IDENTITY
    }
}

/// Smooth value noise in −1…1 over the plane, with period-free lattice values from the seed.
pub(crate) fn noise(seed: u64, octave: u64, x: f64, z: f64) -> f64 {
    let (i, k) = (x.floor(), z.floor());
    let (fx, fz) = (smooth(x - i), smooth(z - k));
    let lattice = |di: f64, dk: f64| {
        let cell = (((i + di) as i64 as u64) << 32) ^ ((k + dk) as i64 as u64 & 0xFFFF_FFFF);
        Stream::new(seed, mix(cell).wrapping_add(octave)).signed()
    };
    let near = lattice(0.0, 0.0) * (1.0 - fx) + lattice(1.0, 0.0) * fx;
    let far = lattice(0.0, 1.0) * (1.0 - fx) + lattice(1.0, 1.0) * fx;
    near * (1.0 - fz) + far * fz
}

fn smooth(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_have_fixed_values_and_the_right_moments() {
        let n = 100_000;
        let mut s = Stream::new(7, 1);
        let (mut sum, mut square) = (0.0, 0.0);
        for _ in 0..n {
            let x = s.unit();
            sum += x;
            square += x * x;
        }
        // Standard errors: 1/√(12 n) = 9e-4 and about 9.4e-4.
        assert!((sum / f64::from(n) - 0.5).abs() < 0.005, "{sum}");
        assert!((square / f64::from(n) - 1.0 / 3.0).abs() < 0.005, "{square}");
        assert_eq!(Stream::new(7, 1).bits(), Stream::new(7, 1).bits());
        assert_ne!(Stream::new(7, 1).bits(), Stream::new(7, 2).bits());
        assert_ne!(Stream::new(7, 1).bits(), Stream::new(8, 1).bits());
    }

    #[test]
    fn noise_is_continuous_across_cells() {
        for i in -3..3 {
            let a = noise(5, 0, f64::from(i) - 1e-9, 0.3);
            let b = noise(5, 0, f64::from(i) + 1e-9, 0.3);
            assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
    }
}
