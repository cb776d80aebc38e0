//! The long runs. The tests read `JOUNCE_PROVE` and take their full counts where it is set.

use crate::{Note, Outcome, Part, cargo, program, run};

/// Thread counts that must give the same bits.
const THREADS: [&str; 4] = ["1", "2", "4", "16"];

/// Everything `cargo xtask prove` runs.
pub const PARTS: &[Part] = &[("checked", checked), ("release", release), ("hashes", hashes)];

fn full_counts(words: &[&str]) -> Outcome {
    run(cargo(words).env("JOUNCE_PROVE", "1"))?;
    Ok(Note::Passed("full counts".into()))
}

/// With debug assertions and the validator.
fn checked() -> Outcome {
    full_counts(&["test", "--workspace", "--no-fail-fast"])
}

/// As users build it.
fn release() -> Outcome {
    full_counts(&["test", "--workspace", "--release", "--no-fail-fast"])
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
