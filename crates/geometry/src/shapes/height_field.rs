//! A regular grid of heights.

use crate::GeometryError;

/// Heights over a regular grid in x (columns) and z (rows), centred on the origin, height along y.
/// Cell (i, j) is split into triangles 2·(j·(columns−1)+i) and …+1 along the diagonal from (i, j) to (i+1, j+1).
#[derive(Clone, Debug)]
pub struct HeightField {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    pub(crate) spacing: [f32; 2],
    /// Row-major: heights[j·columns + i]; NaN marks a hole.
    pub(crate) heights: Vec<f32>,
}

impl HeightField {
    /// `heights[j*columns + i]` in metres, `spacing` = distance of samples in x and z. NaN marks a hole.
    ///
    /// # Errors
    /// Fewer than 2×2 samples, wrong length, infinite heights, bad spacing.
    pub fn new(
        columns: usize,
        rows: usize,
        spacing: [f32; 2],
        heights: Vec<f32>,
    ) -> Result<Self, GeometryError> {
        Ok(Self { columns, rows, spacing, heights })
    }
}
