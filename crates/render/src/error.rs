//! What can go wrong when a picture is made.

use std::path::PathBuf;
use thiserror::Error;

/// Errors of this crate: what, where, and what was expected.
#[derive(Debug, Error)]
pub enum RenderError {
    /// A number or text that no picture can have.
    #[error("{field}: got {got}, expected {expected}")]
    Invalid {
        /// Which input.
        field: &'static str,
        /// Its value.
        got: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// An encoder or the plotting library refused.
    #[error("cannot make the {what}: {message}")]
    Encode {
        /// "PNG", "GIF", "plot".
        what: &'static str,
        /// What it said.
        message: String,
    },
}

/// Results of this crate.
pub type Result<T> = std::result::Result<T, RenderError>;

pub(crate) fn encode(what: &'static str, e: impl std::fmt::Display) -> RenderError {
    RenderError::Encode { what, message: e.to_string() }
}
