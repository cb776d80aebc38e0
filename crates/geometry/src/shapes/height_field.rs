//! A regular grid of heights.

use super::{Hit, PointHit, triangle};
use crate::{Aabb, Bvh, GeometryError, limits};
use jounce_math::{
    Vec3,
    scalar::{f32s, f64s},
};

/// Heights over a regular grid in x (columns) and z (rows), centred on the origin, height along y.
/// Cell (i, j) is split into triangles 2·(j·(columns−1)+i) and …+1 along the diagonal from (i, j) to (i+1, j+1).
/// Triangles face +y.
#[derive(Clone, Debug)]
pub struct HeightField {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    pub(crate) spacing: [f32; 2],
    /// Row-major: heights[j·columns + i]; NaN marks a hole.
    pub(crate) heights: Vec<f32>,
    /// Lowest and highest height.
    range: [f32; 2],
    /// Per cell, row-major; empty when none were given.
    materials: Vec<u16>,
    /// Bounds of blocks of [`BLOCK`]² cells; the data is the block's index, row-major.
    blocks: Bvh,
}

/// Cells along one side of a block.
const BLOCK: usize = 8;

impl HeightField {
    /// `heights[j*columns + i]` in metres, `spacing` = distance of samples in x and z. NaN marks a hole: a cell
    /// with a NaN corner has no triangles (those that use the corner).
    ///
    /// # Errors
    /// Fewer than 2×2 samples, too many, wrong length, infinite heights, bad spacing, nothing but holes.
    pub fn new(
        columns: usize,
        rows: usize,
        spacing: [f32; 2],
        heights: Vec<f32>,
    ) -> Result<Self, GeometryError> {
        let shape = "height_field";
        let max = limits::HEIGHT_FIELD_SIDE_MAX;
        for (what, count) in [("number of columns", columns), ("number of rows", rows)] {
            if !(2..=max).contains(&count) {
                let expected = format!("2 to {max}");
                return Err(GeometryError::BadCount { shape, what, count, expected });
            }
        }
        if heights.len() != columns * rows {
            let (what, expected) = ("number of heights", format!("columns × rows = {}", columns * rows));
            return Err(GeometryError::BadCount { shape, what, count: heights.len(), expected });
        }
        super::check_size(shape, "spacing.x", spacing[0])?;
        super::check_size(shape, "spacing.z", spacing[1])?;
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        for (index, &h) in heights.iter().enumerate() {
            if h.abs() > limits::SIZE_MAX {
                return Err(if h.is_infinite() {
                    GeometryError::NotFinite { shape, what: "height", index }
                } else {
                    let expected = "at most 1e6 m from zero";
                    GeometryError::BadNumber { shape, field: "height", value: h, expected }
                });
            }
            range = [f32s::min(h, range[0]), f32s::max(h, range[1])];
        }
        let (materials, blocks) = (Vec::new(), Bvh::new());
        let mut field = Self { columns, rows, spacing, heights, range, materials, blocks };
        field.blocks = Bvh::build(&field.block_bounds());
        if field.blocks.is_empty() {
            return Err(GeometryError::Unsupported {
                shape,
                what: "every cell is a hole; leave the shape out",
            });
        }
        Ok(field)
    }
    /// With a material index per cell, row-major (`(columns − 1)·(rows − 1)` of them).
    ///
    /// # Errors
    /// A wrong length.
    pub fn with_materials(mut self, materials: Vec<u16>) -> Result<Self, GeometryError> {
        let cells = (self.columns - 1) * (self.rows - 1);
        if materials.len() != cells {
            return Err(GeometryError::BadCount {
                shape: "height_field",
                what: "number of materials",
                count: materials.len(),
                expected: format!("one for each of the {cells} cells"),
            });
        }
        self.materials = materials;
        Ok(self)
    }
    /// Material index of a triangle's cell; 0 where none were given.
    pub fn material(&self, triangle: u32) -> u16 {
        self.materials.get(triangle as usize / 2).copied().unwrap_or(0)
    }
    /// Samples along x.
    pub fn columns(&self) -> usize {
        self.columns
    }
    /// Samples along z.
    pub fn rows(&self) -> usize {
        self.rows
    }
    /// Distance of samples in x and z, metres.
    pub fn spacing(&self) -> [f32; 2] {
        self.spacing
    }
    /// Height of sample (i, j), metres; NaN for a hole or outside the grid.
    pub fn height(&self, i: usize, j: usize) -> f32 {
        if i < self.columns && j < self.rows { self.heights[j * self.columns + i] } else { f32::NAN }
    }
    /// Bounds.
    pub fn aabb(&self) -> Aabb {
        let (x, z) = (self.x_of(self.columns - 1), self.z_of(self.rows - 1));
        Aabb::new(Vec3::new(-x, self.range[0], -z), Vec3::new(x, self.range[1], z))
    }
    /// Number of triangle indices, holes included.
    pub fn triangle_count(&self) -> u32 {
        2 * ((self.columns - 1) * (self.rows - 1)) as u32
    }
    /// Corners of a triangle, counter-clockwise seen from +y. `None` for a hole or an index past the end.
    #[inline]
    pub fn triangle(&self, index: u32) -> Option<[Vec3; 3]> {
        let cell = index as usize / 2;
        let (i, j) = (cell % (self.columns - 1), cell / (self.columns - 1));
        if j + 1 >= self.rows {
            return None;
        }
        let (a, d) = (self.vertex(i, j), self.vertex(i + 1, j + 1));
        let t = if index.is_multiple_of(2) {
            [a, self.vertex(i, j + 1), d]
        } else {
            [a, d, self.vertex(i + 1, j)]
        };
        (!(t[0].y + t[1].y + t[2].y).is_nan()).then_some(t)
    }
    /// Calls `f` with every present triangle whose box may overlap `aabb`, in rising order.
    pub fn overlapping(&self, aabb: &Aabb, mut f: impl FnMut(u32)) {
        if !self.aabb().overlaps(aabb) {
            return;
        }
        for j in self.cells_z(aabb.min.z, aabb.max.z) {
            for i in self.cells_x(aabb.min.x, aabb.max.x) {
                let cell = 2 * (j * (self.columns - 1) + i) as u32;
                for index in [cell, cell + 1] {
                    if let Some(t) = self.triangle(index) {
                        let (lo, hi) = (
                            f32s::min(f32s::min(t[0].y, t[1].y), t[2].y),
                            f32s::max(f32s::max(t[0].y, t[1].y), t[2].y),
                        );
                        if lo <= aabb.max.y && hi >= aabb.min.y {
                            f(index);
                        }
                    }
                }
            }
        }
    }
    /// Coordinate of a sample column; exactly antisymmetric about the middle.
    #[inline]
    fn x_of(&self, i: usize) -> f32 {
        (i as f32 - 0.5 * (self.columns - 1) as f32) * self.spacing[0]
    }
    #[inline]
    fn z_of(&self, j: usize) -> f32 {
        (j as f32 - 0.5 * (self.rows - 1) as f32) * self.spacing[1]
    }
    #[inline]
    fn vertex(&self, i: usize, j: usize) -> Vec3 {
        Vec3::new(self.x_of(i), self.heights[j * self.columns + i], self.z_of(j))
    }
    /// Columns of cells from x0 to x1, a little widened (touching counts, and rounding must lose none) and clamped to
    /// the grid (the saturating cast takes care of any float).
    fn cells_x(&self, x0: f32, x1: f32) -> core::ops::RangeInclusive<usize> {
        cells(x0 / self.spacing[0], x1 / self.spacing[0], self.columns - 1)
    }
    fn cells_z(&self, z0: f32, z1: f32) -> core::ops::RangeInclusive<usize> {
        cells(z0 / self.spacing[1], z1 / self.spacing[1], self.rows - 1)
    }
    fn block_columns(&self) -> usize {
        (self.columns - 1).div_ceil(BLOCK)
    }
    /// Indices of a block's triangles that are not holes, with their corners.
    fn block(&self, block: usize) -> impl Iterator<Item = (u32, [Vec3; 3])> {
        let (i0, j0) = (block % self.block_columns() * BLOCK, block / self.block_columns() * BLOCK);
        let (i1, j1) = ((i0 + BLOCK).min(self.columns - 1), (j0 + BLOCK).min(self.rows - 1));
        (j0..j1)
            .flat_map(move |j| (i0..i1).map(move |i| 2 * (j * (self.columns - 1) + i) as u32))
            .flat_map(|first| [first, first + 1])
            .filter_map(|index| Some((index, self.triangle(index)?)))
    }
    fn block_bounds(&self) -> Vec<(Aabb, u32)> {
        let count = self.block_columns() * (self.rows - 1).div_ceil(BLOCK);
        (0..count)
            .filter_map(|b| {
                let bounds = Aabb::from_points(self.block(b).flat_map(|(_, t)| t));
                (bounds != Aabb::EMPTY).then_some((bounds, b as u32))
            })
            .collect()
    }
    /// Marches over the slabs of cells along the grid axis that the ray crosses more of, and tests in each slab
    /// the cells the ray can be in, padded so that rounding loses none.
    pub(super) fn ray(&self, origin: Vec3, dir: Vec3, max_t: f32) -> Option<Hit> {
        const PAD: f64 = 1e-3;
        let (o, d) = (origin.as_dvec3(), dir.as_dvec3());
        let (t_in, t_out) = self.clip(origin, dir, max_t)?;
        let grid = [
            (o.x, d.x, f64::from(self.spacing[0]), self.columns),
            (o.z, d.z, f64::from(self.spacing[1]), self.rows),
        ]
        .map(|(o, d, s, n)| (o / s + 0.5 * (n - 1) as f64, d / s, (n - 2) as f64));
        let (main, cross) = if grid[0].1.abs() >= grid[1].1.abs() { (0, 1) } else { (1, 0) };
        // Saturating casts: −1 and less is cell 0.
        let cell = |axis: usize, g: f64| f64s::min(g, grid[axis].2) as usize;
        let at = |axis: usize, t: f64| grid[axis].0 + grid[axis].1 * t;
        let forward = grid[main].1 >= 0.0;
        let pad = if forward { PAD } else { -PAD };
        let (first, last) = (cell(main, at(main, t_in) - pad), cell(main, at(main, t_out) + pad));
        let triangle_ray = triangle::TriangleRay::new(origin, dir);
        let mut best: Option<Hit> = None;
        let mut slab = first;
        loop {
            // Parameters at which the ray enters and leaves this slab.
            let (near, far) = if forward { (slab, slab + 1) } else { (slab + 1, slab) };
            let cut =
                |g: f64| if grid[main].1 == 0.0 { None } else { Some((g - grid[main].0) / grid[main].1) };
            let t0 = f64s::max(cut(near as f64 - pad).unwrap_or(t_in), t_in);
            let t1 = f64s::min(cut(far as f64 + pad).unwrap_or(t_out), t_out);
            if best.is_some_and(|b| f64::from(b.t) < t0) {
                break;
            }
            let (a, b) = (at(cross, t0), at(cross, t1));
            for c in cell(cross, f64s::min(a, b) - PAD)..=cell(cross, f64s::max(a, b) + PAD) {
                let (i, j) = if main == 0 { (slab, c) } else { (c, slab) };
                self.ray_cell(&triangle_ray, dir, i, j, max_t, &mut best);
            }
            if slab == last {
                break;
            }
            slab = if forward { slab + 1 } else { slab - 1 };
        }
        best
    }
    /// Part of the ray inside the bounds, slightly widened. `None` for a miss.
    fn clip(&self, origin: Vec3, dir: Vec3, max_t: f32) -> Option<(f64, f64)> {
        let bounds = self.aabb();
        let (mut t0, mut t1) = (0.0, f64::from(max_t));
        for i in 0..3 {
            let (o, d) = (f64::from(origin[i]), f64::from(dir[i]));
            let pad = 1e-6 * f64::from(bounds.max[i] - bounds.min[i]);
            let (lo, hi) = (f64::from(bounds.min[i]) - pad, f64::from(bounds.max[i]) + pad);
            if d == 0.0 {
                if o < lo || o > hi {
                    return None;
                }
                continue;
            }
            let (a, b) = ((lo - o) / d, (hi - o) / d);
            t0 = f64s::max(f64s::min(a, b), t0);
            t1 = f64s::min(f64s::max(a, b), t1);
        }
        (t0 <= t1).then_some((t0, t1))
    }
    fn ray_cell(
        &self,
        ray: &triangle::TriangleRay,
        dir: Vec3,
        i: usize,
        j: usize,
        max_t: f32,
        best: &mut Option<Hit>,
    ) {
        let first = 2 * (j * (self.columns - 1) + i) as u32;
        for index in [first, first + 1] {
            let Some(t) = self.triangle(index) else { continue };
            let Some(s) = ray.hit(&t).filter(|&s| s >= 0.0 && s <= max_t) else { continue };
            let n = normal(&t);
            let hit = Hit { t: s, normal: if n.dot(dir) > 0.0 { -n } else { n }, sub: index };
            if best.is_none_or(|b| hit.is_before(&b)) {
                *best = Some(hit);
            }
        }
    }
    pub(super) fn closest(&self, point: Vec3) -> Option<PointHit> {
        let mut best: Option<(f32, u32, Vec3, Vec3)> = None;
        self.blocks.nearest(point, f32::INFINITY, |b, mut bound| {
            for (index, t) in self.block(b as usize) {
                let bounds = Aabb::from_points(t);
                if (point.clamp(bounds.min, bounds.max) - point).length_squared() > bound {
                    continue;
                }
                let q = triangle::closest_point(&t, point);
                let d2 = (point - q).length_squared();
                if best.is_none_or(|(s, k, ..)| d2 < s || (d2 == s && index < k)) {
                    best = Some((d2, index, q, normal(&t)));
                }
                bound = f32s::min(d2, bound);
            }
            bound
        });
        best.map(|(_, sub, q, n)| {
            let (normal, distance) = (point - q).try_normalize().unwrap_or((n, 0.0));
            PointHit { point: q, distance, normal, sub }
        })
    }
    pub(super) fn outer_radius(&self, center: Vec3) -> f32 {
        let samples = (0..self.rows).flat_map(|j| (0..self.columns).map(move |i| (i, j)));
        let d2 = samples.map(|(i, j)| (self.vertex(i, j) - center).length_squared());
        d2.fold(0.0f32, |m, d| f32s::max(d, m)).sqrt()
    }
}

fn cells(g0: f32, g1: f32, count: usize) -> core::ops::RangeInclusive<usize> {
    let cell = |g: f32| ((g + 0.5 * count as f32) as usize).min(count - 1);
    cell(g0 - 2e-3)..=cell(g1 + 2e-3)
}

fn normal(t: &[Vec3; 3]) -> Vec3 {
    (t[1] - t[0]).cross(t[2] - t[0]).normalize_or(Vec3::Y)
}
