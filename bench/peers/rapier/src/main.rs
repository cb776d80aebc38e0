//! Runs the comparison's scenes in Rapier and prints one JSON line a scene. `rapier_simd8` and
//! `rapier_simd8_mt` compile these sources too, with Rapier's fastest options.

#[path = "../../../shared/mod.rs"]
mod shared;
mod world;

use shared::Program;
use std::process::ExitCode;

fn main() -> ExitCode {
    let engine = env!("CARGO_BIN_NAME").trim_end_matches("-peer");
    Program { engine, threads: if cfg!(feature = "parallel") { 32 } else { 1 }, check }.main()
}

/// `simd8` without AVX runs as pairs of four lanes, slower than the default.
fn check() -> Result<(), String> {
    if cfg!(all(feature = "simd8", target_arch = "x86_64", not(target_feature = "avx2"))) {
        return Err("compiled without AVX2, so its times would be unfair: build inside its folder, where \
                    .cargo/config.toml sets it"
            .into());
    }
    Ok(())
}
