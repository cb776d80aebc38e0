//! A whole solver kernel gives the same bits in every width.

#[path = "../examples/spike/contact.rs"]
mod contact;

use contact::{Solve, Substep, hash, scene};
use jounce_lanes::{Width, dispatch, dispatch_arrays};

#[test]
fn contact_kernel_has_the_same_bits_in_every_width() {
    let step = Substep { inverse_dt: 240.0, push_out_max: 3.0 };
    for seed in 0..5 {
        let start = scene(40, 200, seed);
        let before = hash(&start.0, &start.1);
        let mut hashes = Vec::new();
        for width in Width::ALL {
            for (arrays, transpose) in [(false, false), (false, true), (true, false), (true, true)] {
                let (mut blocks, mut velocities) = start.clone();
                for _ in 0..10 {
                    let solve = Solve { step, blocks: &mut blocks, velocities: &mut velocities, transpose };
                    if arrays { dispatch_arrays(width, solve) } else { dispatch(width, solve) }
                }
                assert!(velocities.iter().flatten().all(|x| x.is_finite()), "the numbers stay sensible");
                hashes.push(hash(&blocks, &velocities));
            }
        }
        assert_ne!(hashes[0], before);
        assert!(hashes.iter().all(|&h| h == hashes[0]), "{hashes:x?}");
    }
}
