//! What every change must pass, after the README's own test command.

use crate::{Note, Outcome, Part, book, cargo, count, files, program, root, run};
use std::process::Stdio;

/// Everything `cargo xtask ci` runs.
pub const PARTS: &[Part] = &[
    ("files", files::check),
    ("fmt", fmt),
    ("clippy", clippy),
    ("own", own),
    ("doctest", doctest),
    ("doc", doc),
    ("scenes", program::scenes),
    ("showcase", program::showcase),
    ("verify", program::verify),
    ("book", book::book),
    ("count", count::check),
];

/// Whether this cargo has the subcommand: components of the toolchain can be absent.
fn has(subcommand: &str) -> bool {
    let mut probe = cargo(&[subcommand, "--version"]);
    probe.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|s| s.success())
}

fn absent(component: &str) -> Outcome {
    Ok(Note::NotRun(format!("no {component} here; `rustup component add {component}` brings it")))
}

fn fmt() -> Outcome {
    if !has("fmt") {
        return absent("rustfmt");
    }
    run(&mut cargo(&["fmt", "--all", "--check"]))?;
    // Workspaces of their own, outside the project's.
    for peer in std::fs::read_dir(root().join("bench/peers")).into_iter().flatten().flatten() {
        let manifest = peer.path().join("Cargo.toml");
        run(cargo(&["fmt", "--check", "--manifest-path"]).arg(manifest))?;
    }
    run(&mut cargo(&["fmt", "--check", "--manifest-path", "docs/book/builder/Cargo.toml"]))?;
    Ok(Note::Passed(String::new()))
}

fn clippy() -> Outcome {
    if !has("clippy") {
        return absent("clippy");
    }
    run(&mut cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))?;
    Ok(Note::Passed(String::new()))
}

/// The tests of this program itself, which a bare `cargo test` leaves out.
fn own() -> Outcome {
    run(&mut cargo(&["test", "--quiet", "--package", "xtask"]))?;
    Ok(Note::Passed(String::new()))
}

fn doctest() -> Outcome {
    run(&mut cargo(&["test", "--workspace", "--doc"]))?;
    Ok(Note::Passed(String::new()))
}

fn doc() -> Outcome {
    run(cargo(&["doc", "--no-deps", "--workspace"]).env("RUSTDOCFLAGS", "-D warnings"))?;
    Ok(Note::Passed(String::new()))
}
