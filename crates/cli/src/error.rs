//! How a command ends when it does not end well.

use crate::check::Fault;
use jounce_render::RenderError;
use jounce_scene::SceneError;
use std::path::Path;

/// Why a command stopped.
#[derive(Debug)]
pub enum Failure {
    /// Everything ran, and something expected did not come out; the report says what. Exit code 1.
    Misses,
    /// Bad input, or a file that cannot be read or written. Exit code 2.
    Bad {
        /// For people.
        message: String,
        /// For programs: what `--json` prints.
        fault: Box<Fault>,
    },
    /// Whoever read our output went away. Exit code 0: that is how `jounce … | head` ends.
    ClosedPipe,
}

/// What commands give back.
pub type Done<T = ()> = Result<T, Failure>;

impl Failure {
    /// Bad input: what, where, what was expected.
    pub fn bad(message: impl Into<String>) -> Self {
        let message = message.into();
        Self::Bad { fault: Box::new(Fault::plain(&message)), message }
    }
    /// A scene's error with the lines around its place, where there is one.
    pub fn scene(path: &Path, e: &SceneError) -> Self {
        Self::Bad { message: excerpt(path, e), fault: Box::new(Fault::of(e)) }
    }
}

impl From<RenderError> for Failure {
    fn from(e: RenderError) -> Self {
        Self::bad(e.to_string())
    }
}

impl From<jounce::Error> for Failure {
    fn from(e: jounce::Error) -> Self {
        Self::bad(e.to_string())
    }
}

impl From<jounce_motion::Error> for Failure {
    fn from(e: jounce_motion::Error) -> Self {
        Self::bad(e.to_string())
    }
}

impl From<std::io::Error> for Failure {
    fn from(e: std::io::Error) -> Self {
        match e.kind() {
            std::io::ErrorKind::BrokenPipe => Self::ClosedPipe,
            _ => Self::bad(format!("cannot write the result: {e}")),
        }
    }
}

/// The message of a scene error, and under it the line it speaks of with a mark.
fn excerpt(path: &Path, e: &SceneError) -> String {
    let message = e.to_string();
    let Some(position) = e.fault().and_then(|f| f.position) else { return message };
    let Ok(text) = std::fs::read_to_string(path) else { return message };
    let line = position.line;
    let column = position.column;
    let Some(shown) = text.lines().nth(line.saturating_sub(1)) else { return message };
    // Long lines: only what is around the mark.
    let chars: Vec<char> = shown.chars().map(|c| if c == '\t' { ' ' } else { c }).collect();
    let start = column.saturating_sub(60).min(chars.len());
    let window: String = chars[start..(start + 100).min(chars.len())].iter().collect();
    let mark = " ".repeat(column.saturating_sub(1).saturating_sub(start).min(100));
    let number = line.to_string();
    let gap = " ".repeat(number.len());
    format!("{message}\n{gap} |\n{number} | {window}\n{gap} | {mark}^")
}
