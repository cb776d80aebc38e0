//! Runs the comparison's scenes in Rapier and prints one JSON line a scene. `rapier_simd8` compiles these sources
//! too, with Rapier's fastest options.

#[path = "../../../shared/mod.rs"]
mod shared;
mod world;

use shared::Program;
use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(feature = "fast")]
    let program = Program { engine: "rapier_simd8", threads: 32, check };
    #[cfg(not(feature = "fast"))]
    let program = Program { engine: "rapier", threads: 1, check };
    program.main()
}

/// `simd8` without AVX runs as pairs of four lanes, slower than the default.
fn check() -> Result<(), String> {
    if cfg!(all(feature = "fast", target_arch = "x86_64", not(target_feature = "avx2"))) {
        return Err(
            "compiled without AVX2, so its times would be unfair: build inside bench/peers/rapier_simd8, \
                    where .cargo/config.toml sets it"
                .into(),
        );
    }
    Ok(())
}
