//! Other engines: each a program of its own under `bench/peers`, built and started from here.

use super::{Plan, Sample};
use crate::error::{Done, Failure};
use crate::output::note;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What a peer's program ends with where its engine's build cannot do what was asked.
const CANNOT: i32 = 2;

/// A built program that times scenes in another engine.
pub(crate) struct Peer {
    pub name: String,
    program: PathBuf,
}

/// Builds the programs of these engines, unless they are built. All names are looked at before the first is built.
pub(crate) fn build(names: &[String]) -> Done<Vec<Peer>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../bench/peers");
    let entries = std::fs::read_dir(&folder).into_iter().flatten().flatten();
    let programs = entries.filter(|e| e.path().join("Cargo.toml").is_file());
    let mut known: Vec<String> = programs.filter_map(|e| e.file_name().into_string().ok()).collect();
    known.sort();
    names.iter().try_for_each(|name| check(name, &known))?;
    names.iter().map(|name| build_one(&folder.join(name), name)).collect()
}

fn check(name: &str, known: &[String]) -> Done {
    if known.iter().any(|k| k == name) {
        return Ok(());
    }
    let expected = if known.is_empty() {
        "there are none here, as a program outside its checkout has none".into()
    } else {
        format!("expected one of {}", known.join(", "))
    };
    Err(Failure::bad(format!("--against {name}: no such program in bench/peers; {expected}")))
}

fn build_one(folder: &Path, name: &str) -> Done<Peer> {
    note(&format!("building bench/peers/{name}"));
    // Inside its folder: its own cargo settings choose how the engine is compiled, and nothing else does.
    let built = Command::new("cargo")
        .args(["build", "--release", "--quiet", "--target-dir", "target"])
        .current_dir(folder)
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .env_remove("CARGO_BUILD_RUSTFLAGS")
        .stdout(Stdio::null())
        .status();
    match built {
        Ok(status) if status.success() => {}
        Ok(status) => return Err(Failure::bad(format!("building bench/peers/{name}: {status}"))),
        Err(e) => return Err(Failure::bad(format!("building bench/peers/{name}: cannot start cargo: {e}"))),
    }
    let file = format!("{name}-peer{}", std::env::consts::EXE_SUFFIX);
    Ok(Peer { name: name.into(), program: folder.join("target/release").join(file) })
}

impl Peer {
    /// Times a scene once; nothing where the engine's build cannot run it.
    pub fn run(&self, scene: &str, plan: Plan) -> Done<Option<Sample>> {
        let fail = |what: String| Failure::bad(format!("{} on {scene}: {what}", self.name));
        let output = Command::new(&self.program)
            .args([scene, "--repeats", "1", "--steps", &plan.steps.to_string()])
            .args(["--threads", &plan.threads.to_string()])
            .stdin(Stdio::null())
            .output()
            .map_err(|e| fail(format!("cannot start {}: {e}", self.program.display())))?;
        let message = String::from_utf8_lossy(&output.stderr);
        if output.status.code() == Some(CANNOT) {
            let why = message.lines().find(|l| !l.trim().is_empty()).unwrap_or("no reason given");
            note(&format!("{} skips {scene}: {why}", self.name));
            return Ok(None);
        }
        if !output.status.success() {
            return Err(fail(format!("{}\n{}", output.status, message.trim())));
        }
        sample(&String::from_utf8_lossy(&output.stdout)).map(Some).map_err(fail)
    }
}

/// Reads the last line of a program's output.
fn sample(text: &str) -> Result<Sample, String> {
    let line = text.lines().rfind(|l| !l.trim().is_empty()).ok_or("it printed nothing")?;
    let v: Value = serde_json::from_str(line).map_err(|e| format!("no JSON line: {e}"))?;
    let count = |key: &str| v[key].as_u64().ok_or(format!("no count \"{key}\" in its line"));
    let figures = v["quality"].as_object().into_iter().flatten();
    Ok(Sample {
        ms: v["ms_total_min"].as_f64().ok_or("no \"ms_total_min\" in its line")?,
        bodies: count("bodies")?,
        joints: count("joints")?,
        touching: count("touching")?,
        quality: figures.filter_map(|(name, v)| Some((name.clone(), v.as_f64()?))).collect(),
        stages: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(done: Done) -> String {
        match done {
            Err(Failure::Bad { message, .. }) => message,
            other => panic!("no refusal: {other:?}"),
        }
    }

    #[test]
    fn an_unknown_engine_is_told_which_there_are() {
        let known = ["box3d".to_string(), "rapier".to_string()];
        assert!(check("rapier", &known).is_ok());
        let text = message(check("rapier2", &known));
        assert!(text.contains("rapier2") && text.contains("box3d, rapier"), "{text}");
        assert!(message(check("box3d", &[])).contains("none here"));
    }

    #[test]
    fn a_program_that_is_not_there_is_an_error() {
        let peer = Peer { name: "ghost".into(), program: "no/such/ghost-peer".into() };
        let text =
            message(peer.run("rain", Plan { steps: 2, repeats: 1, threads: 1, profile: false }).map(drop));
        assert!(text.contains("ghost on rain") && text.contains("cannot start"), "{text}");
    }

    #[test]
    fn lines_are_read() {
        let line = r#"{"ms_total_min": 2.5, "bodies": 7, "joints": 6, "touching": 5,
            "quality": {"top_y": 1.5, "odd": null}}"#
            .replace('\n', "");
        let s = sample(&format!("noise\n{line}\n\n")).expect("read");
        assert_eq!((s.ms, s.bodies, s.joints, s.touching), (2.5, 7, 6, 5));
        assert_eq!(s.quality.into_iter().collect::<Vec<_>>(), [("top_y".to_string(), 1.5)]);
        for (text, word) in [("", "nothing"), ("{", "JSON"), ("{}", "ms_total_min")] {
            assert!(sample(text).expect_err(text).contains(word), "{text}");
        }
        assert!(sample(&line.replace("joints", "links")).expect_err("no joints").contains("joints"));
    }
}
