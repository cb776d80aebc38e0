//! Why a shape was refused.

use thiserror::Error;

/// A shape that cannot be built, and what to do about it.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GeometryError {
    /// A length, radius or extent that is not a positive finite number (or out of range).
    #[error("{shape}: {field} is {value}, expected {expected}")]
    BadNumber {
        /// Shape's name, as in scene files.
        shape: &'static str,
        /// Field of the shape.
        field: &'static str,
        /// What was given.
        value: f32,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A coordinate that is not finite.
    #[error("{shape}: {what} {index} is not finite, expected finite coordinates")]
    NotFinite {
        /// Shape's name.
        shape: &'static str,
        /// "vertex", "point", "height", …
        what: &'static str,
        /// Its index.
        index: usize,
    },
    /// Too few, too many, or wrong counts.
    #[error("{shape}: {what} is {count}, expected {expected}")]
    BadCount {
        /// Shape's name.
        shape: &'static str,
        /// What was counted.
        what: &'static str,
        /// How many there were.
        count: usize,
        /// What would be accepted.
        expected: String,
    },
    /// An index that points past the end.
    #[error("{shape}: triangle {triangle} names vertex {index}, expected less than {vertices}")]
    BadIndex {
        /// Shape's name.
        shape: &'static str,
        /// Which triangle.
        triangle: usize,
        /// The index.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A point set without volume.
    #[error("hull: the points are {what} (extent {extent:e} m), expected a body with volume")]
    Degenerate {
        /// "all one point", "collinear", "coplanar" or "too thin".
        what: &'static str,
        /// Largest extent of the points, metres.
        extent: f32,
    },
    /// A combination that is not supported, with advice.
    #[error("{shape}: {what}")]
    Unsupported {
        /// Shape's name.
        shape: &'static str,
        /// What is wrong and what to use instead.
        what: &'static str,
    },
}
