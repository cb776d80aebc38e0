//! The normal rows of a four-point contact, sixteen contacts to a block.
//!
//! Soft step (Catto, "Solver2D", 2024). For a point with normal n and arms r_a, r_b, relative normal velocity
//! v_n = n·(v_b − v_a) + (r_b×n)·ω_b − (r_a×n)·ω_a, separation s, effective mass m, accumulated impulse λ:
//!
//! ```text
//! bias = s/h           if s > 0 (speculative: closes the gap in this substep and no further)
//!        max(β s, −p)  else     (soft push-out at no more than p)
//! λ'   = max(λ − m γ_m (v_n + bias) − γ_λ λ, 0)
//! ```
//!
//! where β, γ_m, γ_λ come from the contact's frequency and damping (the last two are 1 and 0 in a speculative point).
//! The points of a contact are solved one after another, and the impulse λ' − λ is applied to both bodies at once.
//! The Jacobians r×n and the responses I⁻¹(r×n) are computed once per step and read here.

use jounce_lanes::{Kernel, LANES_MAX, Lanes};

/// One float of each of sixteen contacts.
pub type Column = [f32; LANES_MAX];
/// x, y and z of each of sixteen contacts.
pub type Columns3 = [Column; 3];

/// Linear velocity, one float unused, angular velocity, one float unused.
pub type Velocity = [f32; 8];

/// One point of each contact.
#[derive(Clone)]
#[repr(C, align(64))]
pub struct Point {
    /// r_a × n and r_b × n.
    pub arm: [Columns3; 2],
    /// I_a⁻¹ (r_a × n) and I_b⁻¹ (r_b × n).
    pub response: [Columns3; 2],
    pub separation: Column,
    pub mass: Column,
    pub impulse: Column,
}

/// Sixteen contacts whose bodies are all different.
#[derive(Clone)]
#[repr(C, align(64))]
pub struct Block {
    pub bodies: [[u32; LANES_MAX]; 2],
    pub normal: Columns3,
    pub inverse_mass: [Column; 2],
    /// β, γ_m and γ_λ.
    pub bias_rate: Column,
    pub mass_scale: Column,
    pub impulse_scale: Column,
    pub points: [Point; 4],
}

/// What is the same for all contacts of a substep.
#[derive(Clone, Copy)]
pub struct Substep {
    pub inverse_dt: f32,
    pub push_out_max: f32,
}

/// Solves every block once.
pub struct Solve<'a> {
    pub step: Substep,
    pub blocks: &'a mut [Block],
    pub velocities: &'a mut [Velocity],
    /// Whether to use the transposing gather of the lanes or plain loops.
    pub transpose: bool,
}

impl Kernel for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for block in self.blocks {
            for first in (0..LANES_MAX).step_by(L::WIDTH) {
                solve::<L>(self.step, block, first, self.velocities, self.transpose);
            }
        }
    }
}

type Vec3<L> = [L; 3];

#[inline(always)]
fn load3<L: Lanes>(from: &Columns3, first: usize) -> Vec3<L> {
    [L::load(&from[0][first..]), L::load(&from[1][first..]), L::load(&from[2][first..])]
}

#[inline(always)]
fn dot<L: Lanes>(a: Vec3<L>, b: Vec3<L>) -> L {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn add_scaled<L: Lanes>(to: Vec3<L>, v: Vec3<L>, s: L) -> Vec3<L> {
    [to[0] + v[0] * s, to[1] + v[1] * s, to[2] + v[2] * s]
}

#[inline(always)]
fn solve<L: Lanes>(
    step: Substep,
    block: &mut Block,
    first: usize,
    velocities: &mut [Velocity],
    transpose: bool,
) {
    let a = gather::<L>(&block.bodies[0], first, velocities, transpose);
    let b = gather::<L>(&block.bodies[1], first, velocities, transpose);
    let (mut va, mut wa) = ([a[0], a[1], a[2]], [a[4], a[5], a[6]]);
    let (mut vb, mut wb) = ([b[0], b[1], b[2]], [b[4], b[5], b[6]]);

    let normal: Vec3<L> = load3(&block.normal, first);
    let [mass_a, mass_b] =
        [L::load(&block.inverse_mass[0][first..]), L::load(&block.inverse_mass[1][first..])];
    let bias_rate = L::load(&block.bias_rate[first..]);
    let (soft_mass, soft_impulse) =
        (L::load(&block.mass_scale[first..]), L::load(&block.impulse_scale[first..]));
    let (inverse_dt, push_out) = (L::splat(step.inverse_dt), L::splat(-step.push_out_max));

    for point in &mut block.points {
        let arm: [Vec3<L>; 2] = [load3(&point.arm[0], first), load3(&point.arm[1], first)];
        let separation = L::load(&point.separation[first..]);
        let impulse = L::load(&point.impulse[first..]);
        let apart = separation.gt(L::zero());
        let bias = L::select(apart, separation * inverse_dt, (separation * bias_rate).max(push_out));
        let mass_scale = L::select(apart, L::splat(1.0), soft_mass);
        let impulse_scale = L::select(apart, L::zero(), soft_impulse);

        let relative = [vb[0] - va[0], vb[1] - va[1], vb[2] - va[2]];
        let vn = dot(normal, relative) + (dot(arm[1], wb) - dot(arm[0], wa));
        let mass = L::load(&point.mass[first..]);
        let new = (impulse - mass * mass_scale * (vn + bias) - impulse_scale * impulse).max(L::zero());
        let change = new - impulse;
        new.store(&mut point.impulse[first..]);

        va = add_scaled(va, normal, -(change * mass_a));
        wa = add_scaled(wa, load3(&point.response[0], first), -change);
        vb = add_scaled(vb, normal, change * mass_b);
        wb = add_scaled(wb, load3(&point.response[1], first), change);
    }

    let columns = [va[0], va[1], va[2], a[3], wa[0], wa[1], wa[2], a[7]];
    scatter(&block.bodies[0], first, velocities, transpose, columns);
    let columns = [vb[0], vb[1], vb[2], b[3], wb[0], wb[1], wb[2], b[7]];
    scatter(&block.bodies[1], first, velocities, transpose, columns);
}

#[inline(always)]
fn gather<L: Lanes>(
    bodies: &[u32; LANES_MAX],
    first: usize,
    velocities: &[Velocity],
    transpose: bool,
) -> [L; 8] {
    if transpose {
        return L::gather8(
            #[inline(always)]
            |lane| &velocities[bodies[first + lane] as usize],
        );
    }
    let mut flat = [[0.0; LANES_MAX]; 8];
    for lane in 0..L::WIDTH {
        let row = &velocities[bodies[first + lane] as usize];
        for c in 0..8 {
            flat[c][lane] = row[c];
        }
    }
    let mut out = [L::zero(); 8];
    for c in 0..8 {
        out[c] = L::load(&flat[c]);
    }
    out
}

#[inline(always)]
fn scatter<L: Lanes>(
    bodies: &[u32; LANES_MAX],
    first: usize,
    velocities: &mut [Velocity],
    transpose: bool,
    columns: [L; 8],
) {
    if transpose {
        return L::scatter8(
            columns,
            #[inline(always)]
            |lane, row| velocities[bodies[first + lane] as usize] = row,
        );
    }
    let mut flat = [[0.0; LANES_MAX]; 8];
    for c in 0..8 {
        columns[c].store(&mut flat[c]);
    }
    for lane in 0..L::WIDTH {
        let row = &mut velocities[bodies[first + lane] as usize];
        for c in 0..8 {
            row[c] = flat[c][lane];
        }
    }
}

/// Blocks and bodies with random but sensible numbers; the bodies of a block are all different.
pub fn scene(blocks: usize, bodies: usize, seed: u64) -> (Vec<Block>, Vec<Velocity>) {
    let mut state = seed;
    let mut bits = move || {
        // SplitMix64.
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    };
    let mut order: Vec<u32> = (0..bodies as u32).collect();
    let mut shuffled = Vec::new();
    while shuffled.len() < blocks * 2 * LANES_MAX {
        for i in (1..bodies).rev() {
            order.swap(i, (bits() % (i as u64 + 1)) as usize);
        }
        // Whole blocks only: the next shuffle may start with a body that this one ends with.
        shuffled.extend_from_slice(&order[..bodies / (2 * LANES_MAX) * 2 * LANES_MAX]);
    }
    let mut float = |low: f32, high: f32| low + (high - low) * ((bits() >> 40) as f32 / (1u64 << 24) as f32);
    let mut column = |low, high| std::array::from_fn(|_| float(low, high));
    let made = (0..blocks).map(|i| {
        let named = &shuffled[i * 2 * LANES_MAX..];
        let mut columns3 = |r: f32| [column(-r, r), column(-r, r), column(-r, r)];
        let normal = columns3(0.6);
        let mut point = || Point {
            arm: [columns3(0.5), columns3(0.5)],
            response: [columns3(2.0), columns3(2.0)],
            separation: [0.0; LANES_MAX],
            mass: [0.4; LANES_MAX],
            impulse: [0.0; LANES_MAX],
        };
        let mut points = [point(), point(), point(), point()];
        for point in &mut points {
            point.separation = column(-0.02, 0.01);
            point.impulse = column(0.0, 0.3);
        }
        Block {
            bodies: std::array::from_fn(|side| std::array::from_fn(|lane| named[2 * lane + side])),
            normal,
            inverse_mass: [column(0.5, 2.0), column(0.0, 2.0)],
            bias_rate: [20.0; LANES_MAX],
            mass_scale: [0.9; LANES_MAX],
            impulse_scale: [0.1; LANES_MAX],
            points,
        }
    });
    let made = made.collect();
    let velocities = (0..bodies).map(|_| std::array::from_fn(|_| float(-1.0, 1.0))).collect();
    (made, velocities)
}

/// Everything the kernel writes, folded into one number (FNV-1a over words).
pub fn hash(blocks: &[Block], velocities: &[Velocity]) -> u64 {
    let impulses = blocks.iter().flat_map(|block| block.points.iter().flat_map(|point| &point.impulse));
    impulses
        .chain(velocities.iter().flatten())
        .fold(0xcbf2_9ce4_8422_2325, |hash, x| (hash ^ u64::from(x.to_bits())).wrapping_mul(0x100_0000_01b3))
}
