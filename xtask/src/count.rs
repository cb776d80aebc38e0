//! Instructions that a step takes: a gate that neither a busy machine nor a fast one moves.
//!
//! Cachegrind counts what `jounce bench` executes, for two numbers of steps of each scene; their difference, over the steps, leaves out what
//! building the scene takes. Four lanes, one thread: what every x86-64 machine has. A compiler of another version makes other code, so
//! the counts say which one they are of, and are compared with that alone.

use crate::program::{build, last_line};
use crate::{Note, Outcome, root};
use std::process::Command;

/// Scene, and the two numbers of steps.
const SCENES: [(&str, u32, u32); 6] = [
    ("large_pyramid", 2, 6),
    ("joint_grid", 2, 6),
    ("washer", 2, 6),
    ("convex_pile", 60, 64),
    ("rain", 60, 66),
    ("jolt_pyramid", 2, 12),
];
/// Where the counts lie: the compiler in the first line, then scene and instructions a step.
const COUNTS: &str = "bench/instructions.txt";
/// Part that a count may be above the one on record.
const MOST: f64 = 0.03;

/// Compares with what is on record.
pub fn check() -> Outcome {
    let path = root().join(COUNTS);
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{COUNTS}: {e}"))?;
    let mut lines = text.lines();
    let (of, now) = (lines.next().unwrap_or("").to_string(), compiler()?);
    if of != now {
        return Ok(Note::NotRun(format!(
            "{COUNTS} is of {of}, this is {now}; `cargo xtask count` renews it"
        )));
    }
    if !has_valgrind() {
        return Ok(Note::NotRun("no valgrind here".into()));
    }
    let mut known = std::collections::BTreeMap::new();
    for (i, line) in lines.enumerate() {
        let bad = || format!("{COUNTS}:{}: expected a scene and a number, found \"{line}\"", i + 2);
        let (name, n) = line.split_once(' ').ok_or_else(bad)?;
        known.insert(name.to_string(), n.trim().parse::<f64>().map_err(|_| bad())?);
    }
    let mut grown = Vec::new();
    let mut shrunk = 0;
    for (name, n) in counts()? {
        let Some(old) = known.get(name) else { return Err(format!("{COUNTS}: no line of {name}")) };
        let change = n as f64 / old - 1.0;
        eprintln!("{name}: {n} instructions a step, {:+.1} %", 100.0 * change);
        if change > MOST {
            grown.push(format!("{name} {:+.1} %", 100.0 * change));
        }
        shrunk += usize::from(change < -MOST);
    }
    if !grown.is_empty() {
        return Err(format!("more instructions a step than {COUNTS} says: {}", grown.join(", ")));
    }
    let renew = if shrunk > 0 { ", fewer in some: `cargo xtask count` renews the record" } else { "" };
    Ok(Note::Passed(format!("{} scenes within {} %{renew}", SCENES.len(), 100.0 * MOST)))
}

/// Counts anew and puts that on record.
pub fn renew() -> Outcome {
    if !has_valgrind() {
        return Err("no valgrind here; the package `valgrind` brings it".into());
    }
    let mut text = compiler()? + "\n";
    for (name, n) in counts()? {
        text += &format!("{name} {n}\n");
    }
    std::fs::write(root().join(COUNTS), text).map_err(|e| format!("{COUNTS}: {e}"))?;
    Ok(Note::Passed(format!("{COUNTS} written")))
}

fn has_valgrind() -> bool {
    Command::new("valgrind").arg("--version").output().is_ok_and(|o| o.status.success())
}

fn compiler() -> Result<String, String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).arg("--version").current_dir(root()).output();
    let line = last_line(&output.map_err(|e| format!("rustc --version: {e}"))?.stdout);
    Ok(format!("{line}, {}", std::env::consts::ARCH))
}

/// Instructions a step of each scene.
fn counts() -> Result<Vec<(&'static str, u64)>, String> {
    let program = build("release")?;
    let count = |scene: &str, steps: u32| {
        let steps = steps.to_string();
        let words = ["bench", scene, "--repeats", "1", "--steps", &steps];
        let output = Command::new("valgrind")
            .args(["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"])
            .arg(&program)
            .args(words)
            .env("JOUNCE_LANES", "4")
            .current_dir(root())
            .output()
            .map_err(|e| format!("valgrind: {e}"))?;
        let text = String::from_utf8_lossy(&output.stderr);
        let refs = text.lines().find_map(|l| l.split_once(" refs:").map(|(_, n)| n.trim().replace(',', "")));
        match refs.and_then(|n| n.parse::<u64>().ok()) {
            Some(n) if output.status.success() => Ok(n),
            _ => Err(format!("cachegrind of jounce {}: {}", words.join(" "), last_line(&output.stderr))),
        }
    };
    let mut all = Vec::new();
    for (scene, few, many) in SCENES {
        let (few_n, many_n) = (count(scene, few)?, count(scene, many)?);
        all.push((scene, many_n.saturating_sub(few_n) / u64::from(many - few)));
    }
    Ok(all)
}
