//! Runs the comparison's scenes in Box3D and prints one JSON line a scene.

#[path = "../../../shared/mod.rs"]
mod shared;
mod world;

use shared::Program;
use std::process::ExitCode;

fn main() -> ExitCode {
    world::log_to_stderr();
    Program { engine: "box3d", threads: 32, check }.main()
}

fn check() -> Result<(), String> {
    if world::box3d_has_asserts() {
        return Err("Box3D was compiled with assertions, so its times would be unfair: build inside \
                    bench/peers/box3d, where .cargo/config.toml sets -DNDEBUG"
            .into());
    }
    Ok(())
}
