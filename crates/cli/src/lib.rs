//! The command line: arguments in, reports out. `jounce --help` lists the commands.
//!
//! Standard output holds results only (with `--json` exactly one object); progress and messages go to standard
//! error. Exit code 0: done; 1: an expectation or a law misses; 2: bad input, or a file that cannot be written.
#![forbid(unsafe_code)]

mod args;
mod bench;
mod check;
mod error;
mod output;
mod plot;
mod render;
mod run;
mod showcase;
mod solve;
pub mod verify;

use args::{Args, Command};
use clap::Parser;
use error::Failure;
use std::ffi::OsString;
use std::process::ExitCode;

/// What `--json` prints of a call that was refused.
#[derive(serde::Serialize)]
struct Refused {
    error: check::Fault,
}

/// Runs the program with its arguments, the first of which is its name.
pub fn main(words: impl IntoIterator<Item = OsString>) -> ExitCode {
    let args = match Args::try_parse_from(words) {
        Ok(args) => args,
        Err(e) => {
            // Help and version go to standard output, mistakes to standard error; a closed pipe is no mistake.
            let _ = e.print();
            return ExitCode::from(e.exit_code() as u8);
        }
    };
    let json = match &args.command {
        Some(Command::Run(a)) => a.json,
        Some(Command::Verify(a)) => a.json,
        Some(Command::Bench(a)) => a.json,
        Some(Command::Solve(args::SolveArgs { question: args::Question::Projectile(a) })) => a.json,
        // `check` reports on each file, refused or not.
        _ => false,
    };
    let done = match args.command {
        None => showcase::showcase(&args.common),
        Some(Command::Run(a)) => run::run(&a),
        Some(Command::Render(a)) => render::render(&a),
        Some(Command::Plot(a)) => plot::plot(&a),
        Some(Command::Check(a)) => check::check(&a),
        Some(Command::Verify(a)) => verify::verify(&a),
        Some(Command::Bench(a)) => bench::bench(&a),
        Some(Command::Solve(a)) => solve::solve(&a),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Misses) => ExitCode::from(1),
        Err(Failure::ClosedPipe) => ExitCode::SUCCESS,
        Err(Failure::Bad { message, fault }) => {
            output::complain(&message);
            if json {
                // Whoever reads it may be gone; the exit code stays.
                let _ = output::print_json(&Refused { error: *fault });
            }
            ExitCode::from(2)
        }
    }
}
