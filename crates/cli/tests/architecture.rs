//! Every path that ARCHITECTURE.md names exists: a map with a wrong street is worse than none.

use std::path::Path;

/// Names with these ends are files of the root even without a slash.
const ENDS: [&str; 6] = [".rs", ".md", ".toml", ".json", ".txt", ".lock"];

/// Paths between backticks: no spaces, no code, and a slash or a known end.
fn paths(text: &str) -> Vec<&str> {
    let mut fenced = false;
    let mut found = Vec::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            found.extend(line.split('`').skip(1).step_by(2).filter(|word| is_path(word)));
        }
    }
    found
}

fn is_path(word: &str) -> bool {
    let plain = word.chars().all(|c| c.is_ascii_alphanumeric() || "._-/".contains(c));
    let named = word.chars().any(|c| c.is_ascii_alphabetic());
    plain && named && (word.contains('/') || ENDS.iter().any(|end| word.ends_with(end)))
}

#[test]
fn every_path_in_architecture_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = std::fs::read_to_string(root.join("ARCHITECTURE.md")).expect("ARCHITECTURE.md can be read");
    let found = paths(&text);
    let missing: Vec<_> = found.iter().filter(|path| !root.join(path).exists()).collect();
    assert!(missing.is_empty(), "ARCHITECTURE.md names what is not there: {missing:?}");
    for folder in ["crates", "scenes", "bench", "docs", "xtask"] {
        let has =
            |path: &&str| path.trim_end_matches('/') == folder || path.starts_with(&format!("{folder}/"));
        assert!(
            !root.join(folder).exists() || found.iter().any(has),
            "ARCHITECTURE.md is silent on {folder}"
        );
    }
    for entry in std::fs::read_dir(root.join("crates")).expect("crates can be listed") {
        let name = format!("crates/{}", entry.expect("an entry").file_name().to_string_lossy());
        assert!(found.iter().any(|path| path.starts_with(&name)), "ARCHITECTURE.md is silent on {name}");
    }
}

#[test]
fn paths_are_told_from_code() {
    let text = "`crates/a/src/b.rs` and `World::step`, `1/60`, `a / b`, `Cargo.toml`, `hash()`\n```\n`x/y`\n```\n`docs/`";
    assert_eq!(paths(text), ["crates/a/src/b.rs", "Cargo.toml", "docs/"]);
}
