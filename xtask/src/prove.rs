//! The long runs. The tests read `JOUNCE_PROVE` and take their full counts where it is set.

use crate::{Note, Outcome, Part, cargo, program, root, run};

/// Thread counts that must give the same bits.
const THREADS: [&str; 4] = ["1", "2", "4", "16"];

/// Everything `cargo xtask prove` runs.
pub const PARTS: &[Part] =
    &[("checked", checked), ("release", release), ("steps", steps), ("hashes", hashes), ("laws", laws)];

fn full_counts(words: &[&str]) -> Outcome {
    run(cargo(words).env("JOUNCE_PROVE", "1"))?;
    Ok(Note::Passed("full counts".into()))
}

/// With debug assertions and the validator. The steps of the scenes are a part of their own.
fn checked() -> Outcome {
    full_counts(&["test", "--workspace", "--no-fail-fast", "--", "--skip", "change_no_step"])
}

/// As users build it.
fn release() -> Outcome {
    full_counts(&["test", "--workspace", "--release", "--no-fail-fast", "--", "--skip", "change_no_step"])
}

/// Every scene has the same hash at every step: at every thread count, under shuffled schedules, checked and in release.
fn steps() -> Outcome {
    let folder = root().join("target/prove");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut chains = Vec::new();
    for profile in ["test", "release"] {
        let file = folder.join(format!("steps_{profile}.txt"));
        // Absent or not: only the hashes written now count.
        let _ = std::fs::remove_file(&file);
        let mut tests =
            cargo(&["test", "--profile", profile, "--package", "jounce_scene", "--test", "steps"]);
        run(tests.args(["--", "--nocapture"]).env("JOUNCE_PROVE", "1").env("JOUNCE_CHAINS", &file))?;
        chains.push(std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?);
    }
    match chains[0].lines().zip(chains[1].lines()).find(|(a, b)| a != b) {
        Some((a, b)) => Err(format!("checked {a}, release {b}")),
        None if chains[0] != chains[1] => Err("the builds ran different scenes".into()),
        None => {
            let scenes = chains[0].lines().count();
            Ok(Note::Passed(format!("{scenes} scenes: every step alike, checked and in release")))
        }
    }
}

/// The laws of `jounce verify` with the full numbers of shots and steps; misses that are known are allowed.
fn laws() -> Outcome {
    program::verify_in_full()
}

/// Every scene ends in the same bits at every thread count, in debug and in release.
fn hashes() -> Outcome {
    let scenes = program::scene_files()?;
    if scenes.is_empty() {
        return Ok(Note::NotRun("no scenes/".into()));
    }
    let builds = [("dev", program::build("dev")?), ("release", program::build("release")?)];
    let mut wrong = Vec::new();
    let mut skipped = 0;
    for (i, scene) in scenes.iter().enumerate() {
        eprintln!("  [{}/{}] {scene}", i + 1, scenes.len());
        let mut first: Option<(String, String)> = None;
        for (profile, program) in &builds {
            for threads in THREADS {
                let (value, _) = program::run_scene(program, scene, threads)?;
                if value["skipped"].is_string() {
                    skipped += 1;
                    continue;
                }
                let got = (format!("{profile}, {threads} threads"), value["hash"].to_string());
                match &first {
                    None => first = Some(got),
                    Some(first) if first.1 != got.1 => {
                        wrong
                            .push(format!("{scene}: {} with {}, {} with {}", first.1, first.0, got.1, got.0));
                    }
                    Some(_) => {}
                }
            }
        }
    }
    if !wrong.is_empty() {
        return Err(wrong.join("\n  "));
    }
    let runs = THREADS.len() * builds.len();
    Ok(Note::Passed(format!("{} scenes, {runs} runs each, {skipped} runs skipped", scenes.len())))
}
