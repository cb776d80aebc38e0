//! `jounce run`: simulates a scene and says what came of it. Also what the other commands need to run a scene.

use crate::args::{Common, RunArgs};
use crate::error::{Done, Failure};
use crate::output::{Table, clean, note, number, print, print_json, progress};
use indicatif::ProgressBar;
use jounce::tasks::Tasks;
use jounce_render::write_whole;
use jounce_scene::{Expected, LoadOptions, Report, Scene, SceneError, Simulation};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Where `assets:` files are: as told, else beside the current folder or the checkout.
pub fn load_options(common: &Common) -> LoadOptions {
    let assets = common.assets.clone().unwrap_or_else(|| {
        let here = PathBuf::from("../shared/assets");
        let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets");
        if !here.is_dir() && checkout.is_dir() { checkout } else { here }
    });
    LoadOptions { assets }
}

/// A scene, or why it cannot be run here.
pub enum Loaded {
    Scene(Box<Scene>),
    Skipped(String),
}

/// Loads a scene; bad ones come back as a message with their place.
pub fn load(path: &Path, common: &Common) -> Done<Loaded> {
    match Scene::load(path, &load_options(common)) {
        Ok(scene) => Ok(Loaded::Scene(Box::new(scene))),
        Err(SceneError::Skipped(why)) => Ok(Loaded::Skipped(why)),
        Err(e) => Err(Failure::scene(path, &e)),
    }
}

/// A simulation of a scene on so many threads.
pub fn start(path: &Path, scene: &Scene, threads: u32) -> Done<Simulation> {
    Simulation::new(scene, Tasks::pool(threads as usize)).map_err(|e| Failure::scene(path, &e))
}

/// Makes `count` steps, with a look after each.
pub fn simulate(
    path: &Path,
    simulation: &mut Simulation,
    count: u64,
    bar: &ProgressBar,
    mut after: impl FnMut(&Simulation) -> Done,
) -> Done {
    for _ in 0..count {
        simulation.step().map_err(|e| Failure::scene(path, &e))?;
        after(simulation)?;
        bar.inc(1);
    }
    Ok(())
}

#[derive(Serialize)]
struct Skipped {
    scene: String,
    skipped: String,
}

/// Says that a scene cannot be run here; that is no failure.
pub fn say_skipped(path: &Path, why: &str, json: bool) -> Done {
    let scene = path.display().to_string();
    if json {
        return print_json(&Skipped { scene, skipped: why.into() });
    }
    print(&format!("{}: skipped: {}\n", clean(&scene), clean(why)))
}

/// The table of a report for people.
pub fn summary(r: &Report) -> String {
    let mut t = Table::new(["", &r.scene]).left(1);
    let mut row = |name: &str, value: String| t.row([name.into(), value]);
    row("simulated", format!("{} s in {} steps", number(r.seconds_simulated), r.steps));
    row("bodies", format!("{}, of which {} awake", r.bodies, r.awake));
    if r.particles > 0 {
        row("particles", r.particles.to_string());
    }
    row("touching pairs", r.contacts.to_string());
    row("step, median", format!("{:.3} ms", r.step_ms.median));
    row("step, 95 % / longest", format!("{:.3} / {:.3} ms", r.step_ms.p95, r.step_ms.max));
    row("energy", format!("{} → {} J", number(r.energy.start), number(r.energy.end)));
    row("momentum", format!("{} kg m/s", vector(&r.momentum.linear)));
    row("angular momentum", format!("{} kg m²/s", vector(&r.momentum.angular)));
    row("hash", r.hash.clone());
    let mut text = t.text();
    if !r.expectations.is_empty() {
        let mut t = Table::new(["expectation", "at", "expected", "got", "tolerance", ""]).left(5);
        for e in &r.expectations {
            let expected = match &e.expected {
                Expected::Value(v) => number(*v),
                Expected::Range(words) => words.clone(),
            };
            t.row([
                e.name.clone(),
                format!("{} s", number(e.at)),
                expected,
                e.got.map_or_else(|| "nothing".into(), number),
                number(e.tolerance),
                match e.pass {
                    Some(true) => "ok",
                    Some(false) => "MISS",
                    None => "not judged",
                }
                .into(),
            ]);
        }
        text += "\n";
        text += &t.text();
    }
    text
}

/// Says which expectations the run was too short for: that it ends well says nothing of them.
fn warn_of_the_rest(r: &Report) {
    let rest: Vec<String> = r.not_judged().map(|e| format!("{} (at {} s)", e.name, number(e.at))).collect();
    if !rest.is_empty() {
        let simulated = number(r.seconds_simulated);
        note(&format!("warning: {simulated} s are too short to judge: {}", rest.join(", ")));
    }
}

fn vector(v: &[f64; 3]) -> String {
    format!("({}, {}, {})", number(v[0]), number(v[1]), number(v[2]))
}

pub fn run(a: &RunArgs) -> Done {
    let scene = match load(&a.scene, &a.common)? {
        Loaded::Scene(scene) => scene,
        Loaded::Skipped(why) => return say_skipped(&a.scene, &why, a.json),
    };
    let mut simulation = start(&a.scene, &scene, a.common.threads.unwrap_or(1))?;
    let count = simulation.steps_for(a.seconds.unwrap_or_else(|| scene.seconds()));
    simulation.sample_every(a.every);
    let bar = progress(count, "simulate");
    simulate(&a.scene, &mut simulation, count, &bar, |_| Ok(()))?;
    bar.finish_and_clear();
    if let Some(path) = &a.csv {
        write_whole(path, simulation.samples().csv().as_bytes())?;
        note(&format!("wrote {}", path.display()));
    }
    let report = simulation.finish();
    report.warnings.iter().for_each(|w| note(&format!("warning: {w}")));
    warn_of_the_rest(&report);
    if a.json {
        print(&(report.json() + "\n"))?;
    } else {
        print(&summary(&report))?;
    }
    if report.passed() { Ok(()) } else { Err(Failure::Misses) }
}
