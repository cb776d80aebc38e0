//! The irregular part of a wind: value noise with unit variance everywhere.
//!
//! At each lattice point of a grid as wide as an eddy, and at each multiple of its lifetime, a random vector with
//! components uniform in [−√3, √3] (variance 1). Between them, with quintic weights wᵢ of the 8 corners and 2 times,
//! Σ wᵢ rᵢ / √(Σ wᵢ²): plain interpolation would be calm in the middle of the cells.

use super::desc::Gust;
use jounce_math::{DVec3, Vec3};

/// Scrambles 64 bits (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators": mix of SplitMix64).
#[inline(always)]
pub(crate) fn scramble(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Random vector of a lattice point, each component of variance 1.
fn corner(seed: u64, at: [i64; 4]) -> Vec3 {
    let mut h = seed ^ 0x9e37_79b9_7f4a_7c15;
    for a in at {
        h = scramble(h.wrapping_add(a as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    }
    let part = |shift: u32| {
        let bits = ((h >> shift) & 0x1f_ffff) as f32;
        (bits * (2.0 / 2_097_151.0) - 1.0) * 1.732_050_8
    };
    Vec3::new(part(0), part(21), part(42))
}

/// Whole part, and the quintic weight of the upper neighbour.
fn split(x: f64) -> (i64, f32) {
    let floor = x.floor();
    let t = (x - floor) as f32;
    (floor as i64, t * t * t * (t * (t * 6.0 - 15.0) + 10.0))
}

/// Irregular velocity at a place and time; the pattern is carried along by the steady wind.
pub(crate) fn velocity(g: &Gust, steady: Vec3, at: DVec3, time: f64) -> Vec3 {
    let carried = at - steady.as_dvec3() * time;
    let scale = 1.0 / f64::from(g.size);
    let (x, wx) = split(carried.x * scale);
    let (y, wy) = split(carried.y * scale);
    let (z, wz) = split(carried.z * scale);
    let (t, wt) = split(time / f64::from(g.time_s));
    let (mut sum, mut squares) = (Vec3::ZERO, 0.0);
    for i in 0..16i64 {
        let bit = |k: u32| (i >> k) & 1;
        let weight = |k: u32, w: f32| if bit(k) == 1 { w } else { 1.0 - w };
        let w = weight(0, wx) * weight(1, wy) * weight(2, wz) * weight(3, wt);
        let at =
            [x.wrapping_add(bit(0)), y.wrapping_add(bit(1)), z.wrapping_add(bit(2)), t.wrapping_add(bit(3))];
        sum += corner(g.seed, at) * w;
        squares += w * w;
    }
    sum * (g.speed / squares.sqrt())
}
