//! `jounce` without a command: the showcase.

use crate::args::Common;
use crate::error::{Done, Failure};
use crate::output::{note, print};
use crate::render::{Painter, shoot_film};
use crate::run::{Loaded, load, say_skipped, start, summary};
use jounce_render::write_whole;
use std::path::{Path, PathBuf};

/// Pictures a second of the film.
const FPS: f64 = 15.0;

pub fn showcase(common: &Common) -> Done {
    let here = PathBuf::from("scenes/showcase.json");
    let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/showcase.json");
    let path = if here.exists() { here } else { checkout };
    if !path.exists() {
        return Err(Failure::bad(
            "scenes/showcase.json: there is no such file; run jounce in its checkout, or see `jounce --help`",
        ));
    }
    let scene = match load(&path, common)? {
        Loaded::Scene(scene) => scene,
        Loaded::Skipped(why) => return say_skipped(&path, &why, false),
    };
    let cores = std::thread::available_parallelism().map_or(1, |n| n.get().min(16) as u32);
    let threads = common.threads.unwrap_or(cores);
    let mut simulation = start(&path, &scene, threads)?;
    let mut painter = Painter::new(&scene, &simulation, (480, 270), Some(threads));
    let every = ((1.0 / (FPS * simulation.world().dt())).round() as u64).max(1);
    let count = simulation.steps_for(scene.seconds());
    let film = shoot_film(&path, &mut simulation, &mut painter, count, every)?;
    let output = PathBuf::from("out/showcase.gif");
    write_whole(&output, &film)?;
    let report = simulation.finish();
    print(&summary(&report))?;
    note("");
    note(&format!("wrote {} ({:.2} MB)", output.display(), film.len() as f64 / 1e6));
    for line in NEXT {
        note(line);
    }
    if report.passed() { Ok(()) } else { Err(Failure::Misses) }
}

/// What to try after the showcase.
const NEXT: [&str; 5] = [
    "try next:",
    "  jounce render scenes/showcase.json -o out/still.png --at 3   one picture",
    "  jounce run scenes/showcase.json --json                       numbers, and a hash that is the same everywhere",
    "  jounce verify                                                every law beside its closed form",
    "  jounce --help                                                everything else",
];
