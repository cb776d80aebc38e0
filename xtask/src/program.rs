//! Runs the built program as its users do: every scene, the showcase, the table of laws.

use crate::{Note, Outcome, cargo, root, run};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// Longest a scene may take, in seconds of wall time.
const SCENE_TIME_MAX_S: f64 = 20.0;
/// Longest the program may take without arguments, in seconds of wall time.
const SHOWCASE_TIME_MAX_S: f64 = 30.0;
/// Largest picture the showcase may write, in bytes.
const SHOWCASE_SIZE_MAX: u64 = 4_000_000;
/// Names of the rows of `jounce verify` that are known to miss.
const KNOWN_MISSES: &str = "docs/known_misses.txt";
/// Expectations of scenes that are known to miss: `scene: expectation`. It may only shrink.
const KNOWN_SCENE_MISSES: &str = "docs/known_scene_misses.txt";

/// Builds the program in a profile ("dev" or "release") and says where it lies.
pub fn build(profile: &str) -> Result<PathBuf, String> {
    run(&mut cargo(&["build", "--quiet", "--profile", profile, "--package", "jounce_cli"]))?;
    let folder = if profile == "dev" { "debug" } else { profile };
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    Ok(target.join(folder).join(format!("jounce{}", std::env::consts::EXE_SUFFIX)))
}

/// Runs a program in the root of the checkout and waits for its output.
pub fn start(program: &Path, words: &[&str]) -> Result<(Output, Duration), String> {
    let start = Instant::now();
    let output = Command::new(program).args(words).current_dir(root()).output();
    Ok((output.map_err(|e| format!("{} {}: {e}", program.display(), words.join(" ")))?, start.elapsed()))
}

/// The last line that is not blank.
pub fn last_line(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).lines().rfind(|l| !l.trim().is_empty()).unwrap_or("").trim().to_string()
}

/// Every scene file of the repository, sorted, relative to the root.
pub fn scene_files() -> Result<Vec<String>, String> {
    let mut found = Vec::new();
    let mut folders = vec![PathBuf::from("scenes")];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = std::fs::read_dir(root().join(&folder)) else { continue };
        for entry in entries {
            let entry = entry.map_err(|e| format!("{}: {e}", folder.display()))?;
            let path = folder.join(entry.file_name());
            if entry.path().is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "json") && !path.ends_with("schema.json") {
                found.push(path.to_string_lossy().replace('\\', "/"));
            }
        }
    }
    found.sort();
    Ok(found)
}

/// The JSON object `jounce run` prints for one scene.
pub fn run_scene(program: &Path, scene: &str, threads: &str) -> Result<(Value, Duration), String> {
    let (output, time) = start(program, &["run", scene, "--json", "--threads", threads])?;
    let value = serde_json::from_slice(&output.stdout).map_err(|e| {
        format!("{scene}: stdout is not one JSON object ({e}); stderr: {}", last_line(&output.stderr))
    })?;
    // Exit 1 says that an expectation misses, and nothing else does.
    let misses = expectations(&value).iter().any(|row| row["pass"] != true);
    let wanted = if misses { 1 } else { 0 };
    if output.status.code() == Some(wanted) {
        return Ok((value, time));
    }
    Err(format!("{scene}: {}, expected exit {wanted}: {}", output.status, last_line(&output.stderr)))
}

fn expectations(value: &Value) -> &[Value] {
    value["expectations"].as_array().map(Vec::as_slice).unwrap_or_default()
}

/// Expectations that miss and are not known to, and those that hold and are said to miss.
fn wrong_expectations(scene: &str, value: &Value, known: &BTreeSet<String>) -> Vec<String> {
    let mut wrong = Vec::new();
    for row in expectations(value) {
        let name = format!("{scene}: {}", row["name"].as_str().unwrap_or(""));
        match (row["pass"] == true, known.contains(&name)) {
            (false, false) => wrong.push(format!("misses: {row}")),
            (true, true) => wrong.push(format!("{name} holds now: take it off {KNOWN_SCENE_MISSES}")),
            _ => {}
        }
    }
    wrong
}

/// What is wrong with a scene's result, if anything is.
fn fault(scene: &str, value: &Value, time: Duration, known: &BTreeSet<String>) -> Option<String> {
    if value["skipped"].is_string() {
        return None;
    }
    let rows = expectations(value).len();
    let wrong = wrong_expectations(scene, value, known);
    let hash = value["hash"].as_str().unwrap_or("");
    if rows == 0 {
        Some(format!("{scene}: expects nothing"))
    } else if !wrong.is_empty() {
        Some(format!("{scene}: {}", wrong.join("\n    ")))
    } else if !is_hash(hash) {
        Some(format!("{scene}: hash \"{hash}\": expected 0x and 16 hex digits"))
    } else if time.as_secs_f64() > SCENE_TIME_MAX_S {
        Some(format!("{scene}: took {:.1} s, above {SCENE_TIME_MAX_S}", time.as_secs_f64()))
    } else {
        None
    }
}

fn is_hash(text: &str) -> bool {
    text.strip_prefix("0x").is_some_and(|h| h.len() == 16 && h.bytes().all(|b| b.is_ascii_hexdigit()))
}

/// Checks and runs every scene, and holds each to its own expectations.
pub fn scenes() -> Outcome {
    let scenes = scene_files()?;
    if scenes.is_empty() {
        return Ok(Note::NotRun("no scenes/".into()));
    }
    let program = build("release")?;
    let words: Vec<&str> = std::iter::once("check").chain(scenes.iter().map(String::as_str)).collect();
    let (checked, _) = start(&program, &words)?;
    let list = std::fs::read_to_string(root().join(KNOWN_SCENE_MISSES)).unwrap_or_default();
    let known = names(&list);
    let mut wrong = Vec::new();
    if !checked.status.success() {
        wrong.push(format!("jounce check: {}", String::from_utf8_lossy(&checked.stderr).trim()));
    }
    let mut skipped = 0;
    for scene in &scenes {
        match run_scene(&program, scene, "2") {
            Err(why) => wrong.push(why),
            Ok((value, time)) => {
                let note =
                    value["skipped"].as_str().map_or_else(String::new, |why| format!("skipped: {why}"));
                skipped += usize::from(value["skipped"].is_string());
                eprintln!("  {scene:<44} {:>6.2} s  {note}", time.as_secs_f64());
                wrong.extend(fault(scene, &value, time, &known));
            }
        }
    }
    if wrong.is_empty() {
        Ok(Note::Passed(format!("{} scenes, {skipped} skipped", scenes.len())))
    } else {
        Err(wrong.join("\n  "))
    }
}

/// The README's first command: the program without arguments.
pub fn showcase() -> Outcome {
    if !root().join("scenes/showcase.json").exists() {
        return Ok(Note::NotRun("no scenes/showcase.json".into()));
    }
    let program = build("release")?;
    let picture = root().join("out/showcase.gif");
    // Absent or not: only the picture written now counts.
    let _ = std::fs::remove_file(&picture);
    let (output, time) = start(&program, &[])?;
    let seconds = time.as_secs_f64();
    if !output.status.success() {
        return Err(format!("jounce: {}: {}", output.status, last_line(&output.stderr)));
    }
    let size = std::fs::metadata(&picture).map_err(|e| format!("out/showcase.gif: {e}"))?.len();
    if size == 0 || size > SHOWCASE_SIZE_MAX {
        return Err(format!("out/showcase.gif: {size} bytes, expected 1 to {SHOWCASE_SIZE_MAX}"));
    }
    if seconds > SHOWCASE_TIME_MAX_S {
        return Err(format!("took {seconds:.1} s, above {SHOWCASE_TIME_MAX_S}"));
    }
    Ok(Note::Passed(format!("{size} bytes in {seconds:.1} s")))
}

/// The table of laws: rows that miss must be on the committed list, and rows on the list must miss.
pub fn verify() -> Outcome {
    laws(false)
}

/// The same with the full numbers of shots and steps.
pub fn verify_in_full() -> Outcome {
    laws(true)
}

fn laws(in_full: bool) -> Outcome {
    let Ok(list) = std::fs::read_to_string(root().join(KNOWN_MISSES)) else {
        return Ok(Note::NotRun(format!("no {KNOWN_MISSES}")));
    };
    let program = build("release")?;
    let mut words = Command::new(&program);
    words.args(["verify", "--json"]).current_dir(root());
    if in_full {
        words.env("JOUNCE_PROVE", "1");
    }
    let output = words.output().map_err(|e| format!("jounce verify: {e}"))?;
    let value: Value = serde_json::from_slice(&output.stdout).map_err(|e| {
        format!("verify: stdout is not one JSON object ({e}); stderr: {}", last_line(&output.stderr))
    })?;
    let rows = value["rows"].as_array().ok_or("verify: no rows")?;
    if rows.is_empty() {
        return Err("verify: no rows".into());
    }
    let known = names(&list);
    let wrong = compare(rows, &known, &removed_before());
    let missed = rows.iter().any(|row| row["pass"] != true);
    if output.status.success() == missed {
        return Err(format!(
            "verify: {} although {} row misses",
            output.status,
            if missed { "a" } else { "no" }
        ));
    }
    if wrong.is_empty() {
        Ok(Note::Passed(format!("{} rows, {} known to miss", rows.len(), known.len())))
    } else {
        Err(wrong.join("\n  "))
    }
}

/// The entries of the list: a name a line; `#` begins a comment.
fn names(list: &str) -> BTreeSet<String> {
    let bare = list.lines().map(|line| line.split('#').next().unwrap_or("").trim());
    bare.filter(|name| !name.is_empty()).map(str::to_string).collect()
}

/// Entries that an earlier commit took off the list: a law once met stays met. Nothing in a shallow clone.
fn removed_before() -> BTreeSet<String> {
    let words = ["log", "-p", "--format=%x1e", "--", KNOWN_MISSES];
    let Ok(log) = Command::new("git").args(words).current_dir(root()).output() else {
        return BTreeSet::new();
    };
    String::from_utf8_lossy(&log.stdout).split('\u{1e}').flat_map(removed_by).collect()
}

/// Entries that one commit's patch takes off and does not put back with another comment.
fn removed_by(patch: &str) -> BTreeSet<String> {
    let side = |sign: char| {
        let header = [sign; 3].iter().collect::<String>();
        let lines = patch.lines().filter(|l| !l.starts_with(&header)).filter_map(|l| l.strip_prefix(sign));
        names(&lines.collect::<Vec<_>>().join("\n"))
    };
    side('-').difference(&side('+')).cloned().collect()
}

fn compare(rows: &[Value], known: &BTreeSet<String>, removed: &BTreeSet<String>) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut seen = BTreeSet::new();
    for row in rows {
        let name = row["name"].as_str().unwrap_or("");
        if !seen.insert(name.to_string()) {
            wrong.push(format!("{name}: two rows of that name"));
        }
        match (row["pass"] == true, known.contains(name)) {
            (false, false) => wrong.push(format!(
                "{name}: expected {}, got {}, tolerance {}",
                row["expected"], row["got"], row["tolerance"]
            )),
            (true, true) => wrong.push(format!("{name}: passes now; take it off {KNOWN_MISSES}")),
            _ => {}
        }
    }
    wrong.extend(known.difference(&seen).map(|name| format!("{name}: on {KNOWN_MISSES}, and no row")));
    wrong.extend(known.intersection(removed).map(|name| format!("{name}: came back to {KNOWN_MISSES}")));
    wrong
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_list_of_misses_can_only_shrink() {
        let rows = [json!({"name": "a", "pass": true}), json!({"name": "b", "pass": false})];
        let none = BTreeSet::new();
        assert_eq!(compare(&rows, &names("b # why\n"), &none), Vec::<String>::new());
        assert_eq!(compare(&rows, &names("# empty"), &none).len(), 1, "an unlisted miss");
        assert_eq!(compare(&rows, &names("a\nb"), &none).len(), 1, "a listed row that passes");
        assert_eq!(compare(&rows, &names("b\nc"), &none).len(), 1, "a listed row that is not there");
        assert_eq!(compare(&rows, &names("b"), &names("b")).len(), 1, "an entry that came back");
        let twice = [json!({"name": "a", "pass": true}), json!({"name": "a", "pass": true})];
        assert_eq!(compare(&twice, &none, &none).len(), 1, "two rows of one name");
    }

    #[test]
    fn a_new_comment_is_no_removal() {
        let patch = "--- a/list\n+++ b/list\n@@ -1,2 +1 @@\n-a # old\n-b\n+a # new\n";
        assert_eq!(removed_by(patch), names("b"));
    }

    #[test]
    fn a_scene_is_held_to_its_result() {
        let second = Duration::from_secs(1);
        let good = json!({"hash": "0x0123456789abcdef", "expectations": [{"pass": true}]});
        let none = BTreeSet::new();
        assert_eq!(fault("s", &good, second, &none), None);
        assert!(fault("s", &good, Duration::from_secs(21), &none).is_some());
        for (key, value) in [
            ("hash", json!("0x12")),
            ("expectations", json!([])),
            ("expectations", json!([{"pass": true}, {"pass": false}])),
        ] {
            let mut bad = good.clone();
            bad[key] = value;
            assert!(fault("s", &bad, second, &none).is_some(), "{bad}");
        }
        assert_eq!(fault("s", &json!({"skipped": "no meshes"}), second, &none), None);
        let miss = json!({"hash": "0x0123456789abcdef", "expectations": [{"name": "x", "pass": false}]});
        assert_eq!(fault("s", &miss, second, &names("s: x # why")), None);
        let held = json!({"hash": "0x0123456789abcdef", "expectations": [{"name": "x", "pass": true}]});
        assert!(fault("s", &held, second, &names("s: x")).is_some(), "a listed expectation that holds");
    }
}
