//! Turbulence: an irregular flow, smooth in space and time, free of divergence, the same on every machine.
//!
//! u = ∇ × Ψ for a random potential Ψ (Bridson, Hourihan and Nordenstam 2007, "Curl-noise for procedural fluid flow"), so
//! ∇·u = 0 whatever Ψ is. Ψ is noise on a lattice whose cells are one eddy wide: every node carries a random vector c and a
//! random gradient g, and
//!
//! ```text
//! Ψ(x) = Σ w(x − n) (g·(x − n)) c      u(x) = Σ (∇w (g·(x − n)) + w g) × c
//! ```
//!
//! summed over the eight nodes n around x, with w the product over the axes of Perlin's quintic fade. The derivative is
//! written out, not differenced: it costs little more than Ψ and does not lose digits. (Random values alone, without g,
//! would leave the flow at rest in every node.)
//!
//! In time c goes from one random vector to the next, c = c₀ cos θ + c₁ sin θ, θ from 0 to π/2 by a smooth step, so that its
//! variance stays.
//!
//! Random numbers are hashes of the node's integer coordinates (the multiply–xor–shift rounds of Wellons' "lowbias32"), so
//! the flow has no period short of 2³² cells, and a place far from the origin is as good as one at it: whole cells are
//! counted in integers, and only the rest is a float.

use super::desc::Turbulence;
use crate::room::contacts::rows::Wide3;
use jounce_lanes::{Bits, Lanes};
use jounce_math::{DVec3, scalar::f64s};

/// 3·2²²: a float x with |x| < 2²² rounds to the nearest integer in x + MAGIC, and that sum's bits count integers.
const MAGIC: f32 = 12_582_912.0;
const MAGIC_BITS: u32 = 0x4b40_0000;
/// Farthest lattice coordinate from the emitter's origin: within it a float still resolves an eighth of a cell.
const FAR: f32 = 1_048_576.0;
/// One over the root mean square of |u| for random numbers of −2³¹…2³¹, from the integral
/// E|u|² = 2σ⁴ ∫ Σ (|∇w|² |x − n|² + 2 w ∇w·(x − n) + 3 w²) dx over a cell, with σ² = 2⁶²/3. A test measures it.
const NORM: f64 = 1.0 / 4_611_686_018_427_387_904.0 / RMS;
/// Root mean square for random numbers of −1…1.
const RMS: f64 = 0.704_412_327_534_391_4;

/// A flow at a time, as seen from an emitter's origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Noise {
    per_size: f32,
    /// The origin on the lattice: whole cells and the rest.
    cell: [u32; 3],
    rest: [f32; 3],
    /// Seeds of g, c₀ and c₁.
    seeds: [u32; 3],
    /// cos θ and sin θ, times speed and normalisation.
    weights: [f32; 2],
}

impl Noise {
    pub fn new(t: &Turbulence, origin: DVec3, time: f64) -> Self {
        let q = origin * (1.0 / f64::from(t.size));
        let q = q.to_array();
        let floor = q.map(f64::floor);
        let slice = time / f64::from(t.time_s);
        let (k, s) = (slice.floor(), slice - slice.floor());
        let theta = s * s * (3.0 - 2.0 * s) * core::f64::consts::FRAC_PI_2;
        let scale = NORM * f64::from(t.speed);
        let seed = |purpose: u64| super::birth::random(t.seed, purpose, 7) as u32;
        let k = k as i64 as u64;
        Self {
            per_size: 1.0 / t.size,
            // As integers they wrap, as the lattice does.
            cell: floor.map(|f| (f as i64 as u32).wrapping_sub(MAGIC_BITS)),
            rest: [0, 1, 2].map(|i| (q[i] - floor[i]) as f32),
            seeds: [seed(u64::MAX), seed(k), seed(k.wrapping_add(1))],
            weights: [(scale * f64s::cos(theta)) as f32, (scale * f64s::sin(theta)) as f32],
        }
    }

    /// The flow's velocity at places counted from the origin.
    #[inline(always)]
    pub fn at<L: Lanes>(&self, p: Wide3<L>) -> Wide3<L> {
        let axes = [p.x, p.y, p.z];
        let mut x = [Axis::<L>::nothing(); 3];
        for i in 0..3 {
            let q = axes[i] * L::splat(self.per_size) + L::splat(self.rest[i]);
            x[i] = Axis::new(q, self.cell[i], FACTORS[i]);
        }
        let [a, b, c] = self.seeds;
        let seeds = [L::Bits::splat(a), L::Bits::splat(b), L::Bits::splat(c)];
        let (w0, w1) = (L::splat(self.weights[0]), L::splat(self.weights[1]));
        let mut u = Wide3::new(L::zero(), L::zero(), L::zero());
        for k in 0..2 {
            for j in 0..2 {
                let w = x[1].w[j] * x[2].w[k];
                let wy = x[1].dw[j] * x[2].w[k];
                let wz = x[1].w[j] * x[2].dw[k];
                let hash = x[1].hash[j] ^ x[2].hash[k] ^ seeds[0];
                for i in 0..2 {
                    let h = mix(x[0].hash[i] ^ hash);
                    let (a, b) = (again(h ^ seeds[1]), again(h ^ seeds[2]));
                    let g = vector::<L>(h);
                    let c = vector::<L>(a).scale(w0).add(vector::<L>(b).scale(w1));
                    let d = g.x * x[0].d[i] + g.y * x[1].d[j] + g.z * x[2].d[k];
                    let weight = x[0].w[i] * w;
                    let slope = Wide3::new(x[0].dw[i] * w, x[0].w[i] * wy, x[0].w[i] * wz);
                    u = u.add(slope.scale(d).add(g.scale(weight)).cross(c));
                }
            }
        }
        u
    }
}

const FACTORS: [u32; 3] = [0x8da6_b343, 0xd816_3841, 0xcb1a_b31f];

/// One coordinate: the two nodes around it.
#[derive(Clone, Copy)]
struct Axis<L: Lanes> {
    /// Distance from each, in cells.
    d: [L; 2],
    /// Weight of each, and its derivative.
    w: [L; 2],
    dw: [L; 2],
    /// Share of each in the node's hash.
    hash: [L::Bits; 2],
}

impl<L: Lanes> Axis<L> {
    #[inline(always)]
    fn nothing() -> Self {
        let zero = [L::zero(); 2];
        Self { d: zero, w: zero, dw: zero, hash: [L::Bits::splat(0); 2] }
    }

    #[inline(always)]
    fn new(q: L, cell: u32, factor: u32) -> Self {
        let (one, magic) = (L::splat(1.0), L::splat(MAGIC));
        let q = q.max(L::splat(-FAR)).min(L::splat(FAR));
        let near = q + magic - magic;
        let low = L::select(near.gt(q), near - one, near);
        let t = q - low;
        let node = (low + magic).to_bits() + L::Bits::splat(cell);
        let hash = node * L::Bits::splat(factor);
        let fade = t * t * t * (t * (t * L::splat(6.0) - L::splat(15.0)) + L::splat(10.0));
        let back = t - one;
        let slope = L::splat(30.0) * (t * t) * (back * back);
        Self {
            d: [t, back],
            w: [one - fade, fade],
            dw: [-slope, slope],
            hash: [hash, hash + L::Bits::splat(factor)],
        }
    }
}

#[inline(always)]
fn mix<B: Bits>(h: B) -> B {
    let h = (h ^ h.shr::<16>()) * B::splat(0x7feb_352d);
    let h = (h ^ h.shr::<15>()) * B::splat(0x846c_a68b);
    h ^ h.shr::<16>()
}

/// A round for a second hash of bits that are mixed already.
#[inline(always)]
fn again<B: Bits>(h: B) -> B {
    let h = h * B::splat(0x2c1b_3c6d);
    h ^ h.shr::<15>()
}

/// Three numbers of −2³¹…2³¹ from a hash: its bits from the top, from the eleventh and from the twenty-second.
#[inline(always)]
fn vector<L: Lanes>(h: L::Bits) -> Wide3<L> {
    Wide3::new(h.signed_to_floats(), h.shl::<11>().signed_to_floats(), h.shl::<22>().signed_to_floats())
}

/// The flow at one place, for tests.
#[cfg(test)]
pub(crate) fn at_point(noise: &Noise, p: jounce_math::Vec3, width: jounce_lanes::Width) -> jounce_math::Vec3 {
    use jounce_math::Vec3;
    struct One<'a>(&'a Noise, Vec3);
    impl jounce_lanes::Kernel for One<'_> {
        type Output = Vec3;
        #[inline(always)]
        fn run<L: Lanes>(self) -> Vec3 {
            let p = Wide3::new(L::splat(self.1.x), L::splat(self.1.y), L::splat(self.1.z));
            let u = self.0.at(p);
            let mut out = [[0.0; 16]; 3];
            u.x.store(&mut out[0]);
            u.y.store(&mut out[1]);
            u.z.store(&mut out[2]);
            Vec3::new(out[0][0], out[1][0], out[2][0])
        }
    }
    jounce_lanes::dispatch(width, One(noise, p))
}
