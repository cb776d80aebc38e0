//! What can go wrong at the door, and how it is told.

use jounce_geometry::GeometryError;
use thiserror::Error;

/// A refused call. Nothing was changed by it.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A number out of range or not finite.
    #[error("{what}: {field} is {value}, expected {expected}")]
    BadValue {
        /// The thing described: "body", "shape", "material", "settings", ….
        what: &'static str,
        /// Field name.
        field: &'static str,
        /// What was given.
        value: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A handle that names nothing in this world: what it named was removed, or it was never given out here. A handle of another
    /// world that happens to name something here is taken for that; worlds do not sign their handles.
    #[error("{what} handle {index}v{generation} is stale: it names nothing in this world, or no longer")]
    Stale {
        /// "body", "shape" or "field".
        what: &'static str,
        /// Slot index of the handle.
        index: u32,
        /// Generation of the handle.
        generation: u32,
    },
    /// A shape that cannot be built.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A capacity of [`crate::limits`] is reached.
    #[error("{what}: the limit of {limit} is reached")]
    Limit {
        /// What was counted.
        what: &'static str,
        /// The limit.
        limit: usize,
    },
    /// A combination that the engine does not simulate, with advice.
    #[error("{what}: {advice}")]
    Unsupported {
        /// What was asked.
        what: &'static str,
        /// What to do instead.
        advice: &'static str,
    },
}

/// Result of calls at the door.
pub type Result<T, E = Error> = core::result::Result<T, E>;

pub(crate) fn bad(
    what: &'static str,
    field: &'static str,
    value: impl core::fmt::Debug,
    expected: &'static str,
) -> Error {
    Error::BadValue { what, field, value: format!("{value:?}"), expected }
}

pub(crate) fn check(
    ok: bool,
    what: &'static str,
    field: &'static str,
    value: impl core::fmt::Debug,
    expected: &'static str,
) -> Result<()> {
    if ok { Ok(()) } else { Err(bad(what, field, value, expected)) }
}
