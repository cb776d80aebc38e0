//! The `jounce` program.
#![forbid(unsafe_code)]

fn main() -> std::process::ExitCode {
    jounce_cli::main(std::env::args_os())
}
