//! What can go wrong at the door, and how it is told.

use thiserror::Error;

/// A refused call. Nothing was changed by it.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A number out of range or not finite.
    #[error("{what}: {field} is {value}, expected {expected}")]
    BadValue {
        /// The thing described: "point", "spring", "projectile", ….
        what: &'static str,
        /// Field name.
        field: &'static str,
        /// What was given.
        value: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// An index beyond the end of its list.
    #[error("{what}: {field} is {index}, but there are {count}; indices count from 0")]
    NoSuch {
        /// The thing described.
        what: &'static str,
        /// Field name.
        field: &'static str,
        /// What was given.
        index: usize,
        /// Length of the list.
        count: usize,
    },
    /// A combination that has no meaning, with advice.
    #[error("{what}: {advice}")]
    Unsupported {
        /// What was asked.
        what: &'static str,
        /// What to do instead.
        advice: &'static str,
    },
    /// A number went bad, or an iteration found no answer, at this time.
    #[error("{what} failed at t = {time} s: {advice}")]
    Failed {
        /// What was being computed.
        what: &'static str,
        /// Time that was reached, s.
        time: f64,
        /// What to do about it.
        advice: &'static str,
    },
    /// A capacity of [`crate::limits`] is reached.
    #[error("{what}: the limit of {limit} is reached")]
    Limit {
        /// What was counted.
        what: &'static str,
        /// The limit.
        limit: usize,
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

/// A finite number above zero.
pub(crate) fn positive(what: &'static str, field: &'static str, value: f64) -> Result<()> {
    check(value > 0.0 && value.is_finite(), what, field, value, "a finite number above 0")
}

/// A finite number, zero or above.
pub(crate) fn not_negative(what: &'static str, field: &'static str, value: f64) -> Result<()> {
    check(value >= 0.0 && value.is_finite(), what, field, value, "a finite number, 0 or above")
}

/// A finite number.
pub(crate) fn finite(what: &'static str, field: &'static str, value: f64) -> Result<()> {
    check(value.is_finite(), what, field, value, "a finite number")
}

/// Three finite components.
pub(crate) fn finite_vector(
    what: &'static str,
    field: &'static str,
    value: jounce_math::DVec3,
) -> Result<()> {
    check(value.is_finite(), what, field, value.to_array(), "three finite numbers")
}
