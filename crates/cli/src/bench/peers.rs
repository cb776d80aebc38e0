//! Other engines: each a program of its own under `bench/peers`, built and started from here.

use super::Row;
use crate::error::{Done, Failure};
use crate::output::note;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A built program that times scenes in another engine.
pub(crate) struct Peer {
    name: String,
    program: PathBuf,
}

/// Builds the program of an engine, unless it is built.
pub(crate) fn find(name: &str) -> Done<Peer> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../bench/peers");
    let known: Vec<String> = std::fs::read_dir(&folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|e| e.path().join("Cargo.toml").is_file())
        .filter_map(|e| e.file_name().into_string().ok())
        .collect();
    if !known.iter().any(|k| k == name) {
        return Err(Failure::bad(format!(
            "--against {name}: no such program in bench/peers; expected one of {}",
            if known.is_empty() { "(none here)".into() } else { known.join(", ") }
        )));
    }
    let folder = folder.join(name);
    note(&format!("building bench/peers/{name}"));
    // Inside its folder: its own cargo settings choose how the engine is compiled.
    let built = Command::new("cargo")
        .args(["build", "--release", "--quiet"])
        .current_dir(&folder)
        .env_remove("CARGO_TARGET_DIR")
        .env_remove("RUSTFLAGS")
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
    /// Times a scene; nothing where the engine's program does not know it.
    pub fn run(&self, scene: &str, steps: usize, repeats: usize, threads: u32) -> Done<Option<Row>> {
        let words = [
            scene.to_string(),
            "--steps".into(),
            steps.to_string(),
            "--repeats".into(),
            repeats.to_string(),
            "--threads".into(),
            threads.to_string(),
        ];
        let fail = |what: String| Failure::bad(format!("{} on {scene}: {what}", self.name));
        let output = Command::new(&self.program)
            .args(words)
            .stdin(Stdio::null())
            .output()
            .map_err(|e| fail(format!("cannot start {}: {e}", self.program.display())))?;
        if !output.status.success() {
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            note(&format!("{} skips {scene}: {}", self.name, message.trim()));
            return Ok(None);
        }
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let line = text.lines().rfind(|l| !l.trim().is_empty()).unwrap_or("");
        let v: Value = serde_json::from_str(line).map_err(|e| fail(format!("not a JSON line: {e}")))?;
        let ms = v["ms_total_min"].as_f64().ok_or_else(|| fail("no ms_total_min".into()))?;
        let top = ["top_y", "highest_y", "top_y_lowest"];
        Ok(Some(Row {
            scene: scene.into(),
            engine: v["engine"].as_str().unwrap_or(&self.name).into(),
            threads,
            steps,
            ms_min: ms,
            ms_median: v["ms_total_median"].as_f64().unwrap_or(ms),
            ratio_to_best: None,
            bodies: v["bodies"].as_u64().unwrap_or(0),
            touching: v["touching"].as_u64().unwrap_or(0),
            top_y: top.iter().find_map(|k| v["quality"][k].as_f64()),
        }))
    }
}
