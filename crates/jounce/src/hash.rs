//! The state hash: one `u64` over everything that orders arithmetic or affects the future.
//!
//! Not cryptographic: a 64×64→128 multiply folds each word into the state (the idea of wyhash). Words are
//! fed in a fixed order with explicit lengths, floats by their bits, so two worlds have the same hash exactly
//! when their states have the same bits.

use jounce_math::{DVec3, Pose, Quat, Vec3};

/// Incremental 64-bit hash of words.
#[derive(Clone, Copy, Debug)]
pub struct StateHasher {
    state: u64,
}

impl Default for StateHasher {
    fn default() -> Self {
        Self { state: 0x6a6f_756e_6365_0001 }
    }
}

impl StateHasher {
    /// Folds in one word.
    #[inline(always)]
    pub fn word(&mut self, w: u64) {
        let a = u128::from(self.state ^ w ^ 0xa076_1d64_78bd_642f) * u128::from(w.rotate_left(32) ^ 0xe703_7ed1_a0b4_28db);
        self.state = (a as u64) ^ ((a >> 64) as u64) ^ self.state.rotate_left(23).wrapping_mul(0x8ebc_6af0_9c88_c6e3);
    }
    /// Two `u32`.
    #[inline(always)]
    pub fn pair(&mut self, a: u32, b: u32) {
        self.word((u64::from(a) << 32) | u64::from(b));
    }
    /// Two `f32` by their bits.
    #[inline(always)]
    pub fn floats(&mut self, a: f32, b: f32) {
        self.pair(a.to_bits(), b.to_bits());
    }
    /// An `f64` by its bits.
    pub fn double(&mut self, a: f64) {
        self.word(a.to_bits());
    }
    /// A vector.
    pub fn vec3(&mut self, v: Vec3) {
        self.floats(v.x, v.y);
        self.pair(v.z.to_bits(), 0);
    }
    /// A world position.
    pub fn dvec3(&mut self, v: DVec3) {
        self.double(v.x);
        self.double(v.y);
        self.double(v.z);
    }
    /// A rotation.
    pub fn quat(&mut self, q: Quat) {
        self.floats(q.x, q.y);
        self.floats(q.z, q.w);
    }
    /// A local pose.
    pub fn pose(&mut self, p: &Pose) {
        self.vec3(p.p);
        self.quat(p.q);
    }
    /// The hash so far.
    pub fn finish(&self) -> u64 {
        let mut h = *self;
        h.word(0x9e37_79b9_7f4a_7c15);
        h.state
    }
}
