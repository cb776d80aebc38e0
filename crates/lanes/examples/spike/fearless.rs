//! The kernel of `contact.rs` over `fearless_simd`, with the same order of operations.
//!
//! `max` is written as a comparison and a selection: the crate's own follows the hardware, which differs between x86
//! and ARM for NaN and signed zeros.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd};
use jounce_lanes::LANES_MAX;

use crate::contact::{Block, Columns3, Substep, Velocity};

/// Runs the kernel in so many lanes, or says that the crate offers no such width on this machine.
pub fn solve_all(
    lanes: usize,
    work: &mut (Substep, &mut [Block], &mut [Velocity]),
) -> Result<(), &'static str> {
    let (step, blocks, velocities) = work;
    #[cfg(target_arch = "x86_64")]
    {
        let level = Level::new();
        match lanes {
            4 => {
                let simd = level.as_sse2().ok_or("no SSE2")?;
                simd.vectorize(
                    #[inline(always)]
                    || run(simd, *step, blocks, velocities),
                );
            }
            8 => {
                let simd = level.as_avx2().ok_or("no AVX2")?;
                simd.vectorize(
                    #[inline(always)]
                    || run(simd, *step, blocks, velocities),
                );
            }
            16 => {
                let simd = level.as_avx512().ok_or("no AVX-512 of the Ice Lake set")?;
                simd.vectorize(
                    #[inline(always)]
                    || run(simd, *step, blocks, velocities),
                );
            }
            _ => return Err("no such width"),
        }
        Ok(())
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        if lanes != 4 {
            return Err("no such width");
        }
        fearless_simd::dispatch!(Level::new(), simd => run(simd, *step, blocks, velocities));
        Ok(())
    }
}

type Vec3<S> = [<S as Simd>::f32s; 3];

#[inline(always)]
fn run<S: Simd>(simd: S, step: Substep, blocks: &mut [Block], velocities: &mut [Velocity]) {
    for block in blocks {
        for first in (0..LANES_MAX).step_by(S::f32s::LEN) {
            solve(simd, step, block, first, velocities);
        }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, from: &[f32; LANES_MAX], first: usize) -> S::f32s {
    S::f32s::from_slice(simd, &from[first..first + S::f32s::LEN])
}

#[inline(always)]
fn load3<S: Simd>(simd: S, from: &Columns3, first: usize) -> Vec3<S> {
    [load(simd, &from[0], first), load(simd, &from[1], first), load(simd, &from[2], first)]
}

#[inline(always)]
fn dot<S: Simd>(a: Vec3<S>, b: Vec3<S>) -> S::f32s {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn add_scaled<S: Simd>(to: Vec3<S>, v: Vec3<S>, s: S::f32s) -> Vec3<S> {
    [to[0] + v[0] * s, to[1] + v[1] * s, to[2] + v[2] * s]
}

#[inline(always)]
fn max<S: Simd>(a: S::f32s, b: S::f32s) -> S::f32s {
    a.simd_gt(b).select(a, b)
}

#[inline(always)]
fn gather<S: Simd>(
    simd: S,
    bodies: &[u32; LANES_MAX],
    first: usize,
    velocities: &[Velocity],
) -> [S::f32s; 8] {
    let mut flat = [[0.0; LANES_MAX]; 8];
    for lane in 0..S::f32s::LEN {
        let row = &velocities[bodies[first + lane] as usize];
        for c in 0..8 {
            flat[c][lane] = row[c];
        }
    }
    let mut out = [S::f32s::splat(simd, 0.0); 8];
    for c in 0..8 {
        out[c] = load(simd, &flat[c], 0);
    }
    out
}

#[inline(always)]
fn solve<S: Simd>(simd: S, step: Substep, block: &mut Block, first: usize, velocities: &mut [Velocity]) {
    let [zero, one] = [S::f32s::splat(simd, 0.0), S::f32s::splat(simd, 1.0)];
    let a = gather(simd, &block.bodies[0], first, velocities);
    let b = gather(simd, &block.bodies[1], first, velocities);
    let (mut va, mut wa): (Vec3<S>, Vec3<S>) = ([a[0], a[1], a[2]], [a[4], a[5], a[6]]);
    let (mut vb, mut wb): (Vec3<S>, Vec3<S>) = ([b[0], b[1], b[2]], [b[4], b[5], b[6]]);

    let normal: Vec3<S> = load3(simd, &block.normal, first);
    let mass_a = load(simd, &block.inverse_mass[0], first);
    let mass_b = load(simd, &block.inverse_mass[1], first);
    let bias_rate = load(simd, &block.bias_rate, first);
    let soft_mass = load(simd, &block.mass_scale, first);
    let soft_impulse = load(simd, &block.impulse_scale, first);
    let inverse_dt = S::f32s::splat(simd, step.inverse_dt);
    let push_out = S::f32s::splat(simd, -step.push_out_max);

    for point in &mut block.points {
        let arm: [Vec3<S>; 2] = [load3(simd, &point.arm[0], first), load3(simd, &point.arm[1], first)];
        let separation = load(simd, &point.separation, first);
        let impulse = load(simd, &point.impulse, first);
        let apart = separation.simd_gt(zero);
        let bias = apart.select(separation * inverse_dt, max::<S>(separation * bias_rate, push_out));
        let mass_scale = apart.select(one, soft_mass);
        let impulse_scale = apart.select(zero, soft_impulse);

        let relative: Vec3<S> = [vb[0] - va[0], vb[1] - va[1], vb[2] - va[2]];
        let vn = dot::<S>(normal, relative) + (dot::<S>(arm[1], wb) - dot::<S>(arm[0], wa));
        let mass = load(simd, &point.mass, first);
        let new = max::<S>(impulse - mass * mass_scale * (vn + bias) - impulse_scale * impulse, zero);
        let change = new - impulse;
        new.store_slice(&mut point.impulse[first..first + S::f32s::LEN]);

        va = add_scaled::<S>(va, normal, -(change * mass_a));
        wa = add_scaled::<S>(wa, load3(simd, &point.response[0], first), -change);
        vb = add_scaled::<S>(vb, normal, change * mass_b);
        wb = add_scaled::<S>(wb, load3(simd, &point.response[1], first), change);
    }

    for (side, v, w, old) in [(0, va, wa, a), (1, vb, wb, b)] {
        let columns = [v[0], v[1], v[2], old[3], w[0], w[1], w[2], old[7]];
        let mut flat = [[0.0; LANES_MAX]; 8];
        for c in 0..8 {
            columns[c].store_slice(&mut flat[c][..S::f32s::LEN]);
        }
        for lane in 0..S::f32s::LEN {
            let row = &mut velocities[block.bodies[side][first + lane] as usize];
            for c in 0..8 {
                row[c] = flat[c][lane];
            }
        }
    }
}
