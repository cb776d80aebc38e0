//! The project's own chores: `cargo xtask ci`, `cargo xtask prove`, `cargo xtask book`.

mod book;
mod ci;
mod count;
mod files;
mod program;
mod prove;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

const USAGE: &str = "usage: cargo xtask ci [PART…]     what every change must pass, or only some parts of it
       cargo xtask prove [PART…]  the long runs: full counts, debug and release
       cargo xtask book           the course book: docs/book becomes target/book
       cargo xtask count          instructions a step of some scenes, put on record
       cargo xtask files          sizes and texts of the tracked files

parts of ci: files fmt clippy own doctest doc scenes showcase verify book count
parts of prove: checked release steps hashes laws";

/// What a part of a run came to; `Err` says what failed.
pub type Outcome = Result<Note, String>;

/// How a part that did not fail ended.
pub enum Note {
    /// It ran; a few words on what was seen.
    Passed(String),
    /// It could not run here, and why.
    NotRun(String),
}

/// A named piece of a run.
pub type Part = (&'static str, fn() -> Outcome);

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let rest = words.get(1..).unwrap_or_default();
    let result = match words.first().map(String::as_str) {
        Some("ci") => named(ci::PARTS, rest).and_then(|parts| run_parts(&parts)),
        Some("prove") => named(prove::PARTS, rest).and_then(|parts| run_parts(&parts)),
        Some("book") if rest.is_empty() => run_parts(&[("book", book::book)]),
        Some("count") if rest.is_empty() => run_parts(&[("count", count::renew)]),
        Some("files") if rest.is_empty() => run_parts(&[("files", files::check)]),
        _ => Err(USAGE.to_string()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// All parts, or those named.
fn named(all: &[Part], names: &[String]) -> Result<Vec<Part>, String> {
    if names.is_empty() {
        return Ok(all.to_vec());
    }
    let find = |name: &String| {
        all.iter().find(|(known, _)| known == name).copied().ok_or_else(|| {
            let known: Vec<_> = all.iter().map(|(name, _)| *name).collect();
            format!("no part \"{name}\"; expected one of {}", known.join(", "))
        })
    };
    names.iter().map(find).collect()
}

/// Runs every part, also after one has failed, and closes with a table of all.
fn run_parts(parts: &[Part]) -> Result<(), String> {
    let mut table = Vec::new();
    let mut failed = Vec::new();
    for (i, (name, part)) in parts.iter().enumerate() {
        eprintln!("xtask [{}/{}] {name}", i + 1, parts.len());
        let start = Instant::now();
        let outcome = part();
        let seconds = start.elapsed().as_secs_f64();
        let (word, note) = match outcome {
            Ok(Note::Passed(note)) => ("ok", note),
            Ok(Note::NotRun(why)) => ("not run", why),
            Err(why) => {
                failed.push(*name);
                ("FAILED", why)
            }
        };
        table.push(format!("{name:<10} {word:<8} {seconds:>6.1} s  {note}"));
    }
    println!("{}", table.join("\n"));
    if failed.is_empty() { Ok(()) } else { Err(format!("failed: {}", failed.join(", "))) }
}

/// The root of the checkout.
pub fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_path_buf()
}

/// A cargo call in the root of the checkout.
pub fn cargo(words: &[&str]) -> Command {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(program);
    command.args(words).current_dir(root());
    command
}

/// Runs a command with its output shown; `Err` names the command and how it ended.
pub fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|e| format!("{command:?}: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{}: {status}", shown(command))) }
}

/// A command's words, without the folders of its program.
fn shown(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_name().unwrap_or_default();
    let words = std::iter::once(program).chain(command.get_args());
    words.map(|w| w.to_string_lossy()).collect::<Vec<_>>().join(" ")
}
