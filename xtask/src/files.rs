//! The tracked files: small enough to clone, and free of what belongs to one machine alone.

use crate::{Note, Outcome, root};
use std::process::Command;

/// Largest tracked file, in bytes.
const SIZE_MAX: u64 = 5_000_000;
/// Top folders that exist on one machine and not on the next; spelled without slashes, so that this file passes.
const MACHINE_FOLDERS: [&str; 6] = ["work", "root", "farm", "tmp", "home", "Users"];
/// Where a locked dependency may come from.
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// Sizes, machine paths and dependency sources of every tracked file.
pub fn check() -> Outcome {
    let tracked = tracked()?;
    let mut wrong = Vec::new();
    for name in &tracked {
        // Tracked and not there: deleted in the working tree.
        let Ok(bytes) = std::fs::read(root().join(name)) else { continue };
        if bytes.len() as u64 > SIZE_MAX {
            wrong.push(format!("{name}: {} bytes, above {SIZE_MAX}", bytes.len()));
        }
        let Ok(text) = str::from_utf8(&bytes) else { continue };
        for (i, line) in text.lines().enumerate() {
            if let Some(folder) = machine_path(line) {
                wrong.push(format!("{name}:{}: a path of one machine (/{folder}/…)", i + 1));
            }
            if name.ends_with("Cargo.lock") && line.starts_with("source = ") && !line.contains(REGISTRY) {
                wrong.push(format!("{name}:{}: {line}: expected {REGISTRY}", i + 1));
            }
        }
    }
    if wrong.is_empty() {
        Ok(Note::Passed(format!("{} files", tracked.len())))
    } else {
        Err(format!("{} findings\n  {}", wrong.len(), wrong.join("\n  ")))
    }
}

fn tracked() -> Result<Vec<String>, String> {
    let mut git = Command::new("git");
    let output =
        git.args(["ls-files", "-z"]).current_dir(root()).output().map_err(|e| format!("git: {e}"))?;
    if !output.status.success() {
        return Err(format!("git ls-files: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    let names = String::from_utf8_lossy(&output.stdout);
    Ok(names.split('\0').filter(|name| !name.is_empty()).map(str::to_string).collect())
}

/// The machine folder that an absolute path in `line` begins with.
fn machine_path(line: &str) -> Option<&'static str> {
    MACHINE_FOLDERS.into_iter().find(|folder| {
        line.match_indices(&format!("/{folder}/")).any(|(at, found)| {
            let before = line[..at].chars().next_back();
            let after = line[at + found.len()..].chars().next();
            // After a letter or a dot the folder is part of a relative path or of an address.
            !before.is_some_and(|c| c.is_ascii_alphanumeric() || "._-".contains(c))
                && after.is_some_and(|c| c.is_ascii_alphanumeric() || c == '.')
        })
    })
}

#[cfg(test)]
mod tests {
    use super::machine_path;

    #[test]
    fn finds_absolute_paths_of_a_machine_and_no_others() {
        for folder in super::MACHINE_FOLDERS {
            assert_eq!(machine_path(&format!("see /{folder}/me/x")), Some(folder));
            assert_eq!(machine_path(&format!("/{folder}/.cache")), Some(folder));
            assert_eq!(machine_path(&format!("crates/{folder}/src")), None);
            assert_eq!(machine_path(&format!("../{folder}/src")), None);
        }
    }
}
