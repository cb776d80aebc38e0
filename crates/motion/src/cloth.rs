//! Cloth as a mesh of springs of three kinds, after the lecture.
//!
//! | springs | join | against |
//! |---|---|---|
//! | structural | neighbours along rows and columns | stretching |
//! | shear | both diagonals of every square | shearing |
//! | bend | every other particle along rows and columns | folding along a line of particles |
//!
//! Source: the lecture; X. Provot, "Deformation constraints in a mass–spring model", Graphics Interface (1995).

use crate::error::{Error, Result, check, finite_vector, positive};
use crate::integrate::Method;
use crate::limits::POINTS_MAX;
use crate::springs::{Elasticity, MassSpring};
use jounce_math::DVec3;

/// What a cloth is like.
#[derive(Clone, Debug, PartialEq)]
pub struct ClothDesc {
    /// Particles along `across`, 2 or more.
    pub columns: usize,
    /// Particles along `down`, 2 or more.
    pub rows: usize,
    /// Corner of column 0 and row 0, m.
    pub origin: DVec3,
    /// The whole first row, from its first particle to its last, m.
    pub across: DVec3,
    /// The whole first column, m.
    pub down: DVec3,
    /// Mass of the cloth, kg; every particle has its share.
    pub mass: f64,
    /// Structural springs, if any.
    pub structural: Option<Elasticity>,
    /// Shear springs, if any.
    pub shear: Option<Elasticity>,
    /// Bend springs, if any.
    pub bend: Option<Elasticity>,
    /// How it is integrated.
    pub method: Method,
}

impl Default for ClothDesc {
    /// A metre square of 0.2 kg hanging from the origin in the plane z = 0.
    fn default() -> Self {
        Self {
            columns: 20,
            rows: 20,
            origin: DVec3::ZERO,
            across: DVec3::X,
            down: -DVec3::Y,
            mass: 0.2,
            structural: Some(Elasticity { stiffness: 200.0, damping: 0.02 }),
            shear: Some(Elasticity { stiffness: 100.0, damping: 0.02 }),
            bend: Some(Elasticity { stiffness: 10.0, damping: 0.01 }),
            method: Method::ImplicitEuler,
        }
    }
}

/// A cloth: its springs and its triangles.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::cloth::{Cloth, ClothDesc};
/// let mut flag = Cloth::new(&ClothDesc { columns: 12, rows: 8, ..ClothDesc::default() })?;
/// flag.system.set_gravity(DVec3::Y * -9.81)?;
/// for row in 0..8 {
///     flag.system.freeze(flag.index(0, row))?;
/// }
/// for _ in 0..30 {
///     flag.system.step(1.0 / 60.0)?;
/// }
/// assert_eq!(flag.triangles().len(), 2 * 11 * 7);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Cloth {
    /// Its points and springs: freeze, push, step and read them here.
    pub system: MassSpring,
    columns: usize,
    rows: usize,
    triangles: Vec<[u32; 3]>,
}

impl Cloth {
    /// Builds it flat and at rest.
    ///
    /// # Errors
    /// [`Error::BadValue`] for fewer than 2 × 2 particles, sides without length or a mass not above 0,
    /// [`Error::Limit`] for more than [`POINTS_MAX`] particles.
    pub fn new(desc: &ClothDesc) -> Result<Self> {
        let (w, h) = (desc.columns, desc.rows);
        check(w >= 2, "cloth", "columns", w, "2 or more")?;
        check(h >= 2, "cloth", "rows", h, "2 or more")?;
        let count = w.checked_mul(h).filter(|&n| n <= POINTS_MAX);
        let count = count.ok_or(Error::Limit { what: "particles of a cloth", limit: POINTS_MAX })?;
        finite_vector("cloth", "origin", desc.origin)?;
        for (field, side) in [("across", desc.across), ("down", desc.down)] {
            let length = side.length();
            let usable = length > 0.0 && length.is_finite();
            check(usable, "cloth", field, side.to_array(), "a vector of finite length, not zero")?;
        }
        positive("cloth", "mass", desc.mass)?;
        let mut system = MassSpring::new(desc.method);
        for row in 0..h {
            for column in 0..w {
                let (u, v) = (column as f64 / (w - 1) as f64, row as f64 / (h - 1) as f64);
                system.add_point(desc.mass / count as f64, desc.origin + desc.across * u + desc.down * v)?;
            }
        }
        let mut cloth = Self { system, columns: w, rows: h, triangles: Vec::new() };
        cloth.join(desc.structural, &[(1, 0), (0, 1)])?;
        cloth.join(desc.shear, &[(1, 1), (-1, 1)])?;
        cloth.join(desc.bend, &[(2, 0), (0, 2)])?;
        cloth.triangulate();
        Ok(cloth)
    }

    /// Joins every particle with those at the given distances in columns and rows.
    fn join(&mut self, elasticity: Option<Elasticity>, steps: &[(isize, usize)]) -> Result<()> {
        let Some(elasticity) = elasticity else { return Ok(()) };
        for &(dc, dr) in steps {
            for row in 0..self.rows.saturating_sub(dr) {
                for column in 0..self.columns {
                    let Some(c) = column.checked_add_signed(dc).filter(|&c| c < self.columns) else {
                        continue;
                    };
                    self.system.add_spring([self.index(column, row), self.index(c, row + dr)], elasticity)?;
                }
            }
        }
        Ok(())
    }

    /// Two triangles a square, all wound the same way round: counter-clockwise seen from `down` × `across`.
    fn triangulate(&mut self) {
        for row in 0..self.rows - 1 {
            for column in 0..self.columns - 1 {
                let [a, b, c, d] =
                    [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(dc, dr)| self.index(column + dc, row + dr) as u32);
                self.triangles.push([a, b, c]);
                self.triangles.push([a, c, d]);
            }
        }
    }

    /// Index of the particle in a column and a row. Beyond the cloth it is that of no particle.
    pub fn index(&self, column: usize, row: usize) -> usize {
        if column < self.columns && row < self.rows { row * self.columns + column } else { usize::MAX }
    }
    /// Particles in a row.
    pub fn columns(&self) -> usize {
        self.columns
    }
    /// Particles in a column.
    pub fn rows(&self) -> usize {
        self.rows
    }
    /// Triangles for drawing, as indices of particles.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
}
