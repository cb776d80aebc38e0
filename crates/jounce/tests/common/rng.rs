//! A counter generator: the n-th number of a seed is a hash of (seed, n).

use jounce::math::scalar::f64s;
use jounce::prelude::*;

#[derive(Clone, Debug)]
pub struct Rng {
    seed: u64,
    n: u64,
}

impl Rng {
    pub fn new(seed: u64) -> Self {
        Self { seed: mix(seed ^ 0x5851_f42d_4c95_7f2d), n: 0 }
    }
    pub fn bits(&mut self) -> u64 {
        self.n += 1;
        mix(self.seed.wrapping_add(self.n.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }
    /// 0 … n − 1.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.bits()) * n as u128) >> 64) as usize
    }
    /// True once in n.
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
    /// lo … hi.
    pub fn double(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * ((self.bits() >> 11) as f64 / (1u64 << 53) as f64)
    }
    pub fn float(&mut self, lo: f32, hi: f32) -> f32 {
        self.double(f64::from(lo), f64::from(hi)) as f32
    }
    /// 10^lo … 10^hi, even in the exponent.
    pub fn decades(&mut self, lo: f64, hi: f64) -> f32 {
        f64s::pow(10.0, self.double(lo, hi)) as f32
    }
    pub fn vec3(&mut self, r: f32) -> Vec3 {
        Vec3::new(self.float(-r, r), self.float(-r, r), self.float(-r, r))
    }
    pub fn quat(&mut self) -> Quat {
        loop {
            let q = Quat::new(
                self.float(-1.0, 1.0),
                self.float(-1.0, 1.0),
                self.float(-1.0, 1.0),
                self.float(-1.0, 1.0),
            );
            let l = q.length();
            if l > 0.1 && l < 1.0 {
                return q.normalize();
            }
        }
    }
    pub fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }
}

/// The finaliser of splitmix64.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
