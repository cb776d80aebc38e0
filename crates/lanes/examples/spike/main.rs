//! Measures one solver kernel in every width: on the lanes of this crate, on `fearless_simd`, and on arrays that the
//! compiler may vectorise. `cargo run --release -p jounce_lanes --example spike`
#![allow(clippy::disallowed_methods, reason = "a measurement looks at the clock")]

mod contact;
mod fearless;

use std::time::Instant;

use contact::{Block, Solve, Substep, Velocity, hash, scene};
use jounce_lanes::{LANES_MAX, Width, dispatch, dispatch_arrays};

const STEP: Substep = Substep { inverse_dt: 240.0, push_out_max: 3.0 };
const ROUNDS: usize = 15;

/// A way to run the kernel once.
type Way<'a> = (String, Box<dyn Fn(&mut [Block], &mut [Velocity]) + 'a>);

fn ways() -> Vec<Way<'static>> {
    let mut ways: Vec<Way> = Vec::new();
    for width in Width::ALL {
        for (gather, transpose) in [("loops", false), ("transposed", true)] {
            ways.push((
                format!("lanes, gather by {gather:<10} x{width}"),
                Box::new(move |blocks, velocities| {
                    dispatch(width, Solve { step: STEP, blocks, velocities, transpose });
                }),
            ));
        }
    }
    for width in Width::ALL {
        ways.push((
            format!("arrays, gather by loops     x{width}"),
            Box::new(move |blocks, velocities| {
                dispatch_arrays(width, Solve { step: STEP, blocks, velocities, transpose: false });
            }),
        ));
    }
    for width in Width::ALL {
        let (mut blocks, mut velocities) = scene(1, 2 * LANES_MAX, 0);
        match fearless::solve_all(width.lanes(), &mut (STEP, &mut blocks, &mut velocities)) {
            Ok(()) => ways.push((
                format!("fearless_simd, by loops     x{width}"),
                Box::new(move |blocks, velocities| {
                    let _ = fearless::solve_all(width.lanes(), &mut (STEP, blocks, velocities));
                }),
            )),
            Err(why) => println!("fearless_simd x{width}: {why}"),
        }
    }
    ways
}

fn main() {
    println!("native width: {} lanes", Width::native());
    for (name, blocks, bodies) in
        [("in L2 (64 blocks)", 64, 1024), ("in memory (8,192 blocks)", 8192, 65_536)]
    {
        let start = scene(blocks, bodies, 1);
        let ways = ways();
        let passes = (8192 / blocks).max(4);
        let mut best = vec![f64::INFINITY; ways.len()];
        let mut hashes = vec![0; ways.len()];
        // Round robin, so that a noisy moment does not fall on one of them.
        for _ in 0..ROUNDS {
            for (i, (_, run)) in ways.iter().enumerate() {
                let (mut blocks, mut velocities) = start.clone();
                run(&mut blocks, &mut velocities);
                let begun = Instant::now();
                for _ in 1..passes {
                    run(&mut blocks, &mut velocities);
                }
                let seconds = begun.elapsed().as_secs_f64();
                let contacts = (blocks.len() * LANES_MAX * (passes - 1)) as f64;
                if seconds * 1e9 / contacts < best[i] {
                    best[i] = seconds * 1e9 / contacts;
                }
                hashes[i] = hash(&blocks, &velocities);
            }
        }
        println!("\n{name}: nanoseconds per contact of four points, best of {ROUNDS}");
        for ((name, _), (ns, hash)) in ways.iter().zip(best.iter().zip(&hashes)) {
            println!("  {name:<34} {ns:7.2}   {:5.2} x   {hash:#018x}", best[0] / ns);
        }
        assert!(hashes.iter().all(|&h| h == hashes[0]), "widths differ in bits");
    }
}
