//! A block of jelly as a lattice of springs.
//!
//! | springs | join | against |
//! |---|---|---|
//! | structural | neighbours along the three axes | stretching |
//! | shear | diagonals of every face and of every cell | shearing and collapse |
//! | bend | every other particle along the three axes | folding |
//!
//! Source: the lecture; X. Provot, "Deformation constraints in a mass–spring model", Graphics Interface (1995), carried
//! over to three dimensions.

use crate::error::{Error, Result, check, finite_vector, positive};
use crate::integrate::Method;
use crate::limits::POINTS_MAX;
use crate::springs::{Elasticity, MassSpring};
use jounce_math::DVec3;

/// What a block of jelly is like.
#[derive(Clone, Debug, PartialEq)]
pub struct JellyDesc {
    /// Particles along x, y and z, 2 or more each.
    pub particles: [usize; 3],
    /// Middle of the block, m.
    pub center: DVec3,
    /// Sides of the block, m.
    pub size: DVec3,
    /// Mass of the block, kg; every particle has its share.
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

impl Default for JellyDesc {
    /// A cube of 0.5 m and 1 kg, of 6 × 6 × 6 particles.
    fn default() -> Self {
        Self {
            particles: [6; 3],
            center: DVec3::ZERO,
            size: DVec3::splat(0.5),
            mass: 1.0,
            structural: Some(Elasticity { stiffness: 100.0, damping: 0.1 }),
            shear: Some(Elasticity { stiffness: 50.0, damping: 0.1 }),
            bend: Some(Elasticity { stiffness: 50.0, damping: 0.1 }),
            method: Method::ImplicitEuler,
        }
    }
}

/// Diagonals of the faces and of the cells of a lattice, one of each opposite pair.
const DIAGONALS: [[isize; 3]; 10] = [
    [1, 1, 0],
    [1, -1, 0],
    [1, 0, 1],
    [1, 0, -1],
    [0, 1, 1],
    [0, 1, -1],
    [1, 1, 1],
    [1, 1, -1],
    [1, -1, 1],
    [1, -1, -1],
];

/// A block of jelly: its springs and the triangles of its skin.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::collide::Plane;
/// use jounce_motion::jelly::{Jelly, JellyDesc};
/// let mut cube = Jelly::new(&JellyDesc { particles: [4; 3], center: DVec3::Y, ..JellyDesc::default() })?;
/// cube.system.set_gravity(DVec3::Y * -9.81)?;
/// cube.system.add_plane(Plane::new(DVec3::ZERO, DVec3::Y)?, 0.2, 0.5)?;
/// for _ in 0..60 {
///     cube.system.step(0.01)?;
/// }
/// assert!(cube.system.positions().iter().all(|p| p.y >= 0.0));
/// # Ok::<(), jounce_motion::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Jelly {
    /// Its points and springs: freeze, push, step and read them here.
    pub system: MassSpring,
    particles: [usize; 3],
    triangles: Vec<[u32; 3]>,
}

impl Jelly {
    /// Builds it at rest, with its sides along the axes.
    ///
    /// # Errors
    /// [`Error::BadValue`] for fewer than two particles along a side, a side or a mass not above 0, [`Error::Limit`] for
    /// more than [`POINTS_MAX`] particles.
    pub fn new(desc: &JellyDesc) -> Result<Self> {
        let n = desc.particles;
        check(n.iter().all(|&n| n >= 2), "jelly", "particles", n, "2 or more along each side")?;
        let count = n.iter().try_fold(1usize, |all, &n| all.checked_mul(n)).filter(|&all| all <= POINTS_MAX);
        let count = count.ok_or(Error::Limit { what: "particles of a jelly", limit: POINTS_MAX })?;
        finite_vector("jelly", "center", desc.center)?;
        for (field, side) in [("size.x", desc.size.x), ("size.y", desc.size.y), ("size.z", desc.size.z)] {
            positive("jelly", field, side)?;
        }
        // The longest diagonal is the rest length of a spring.
        let size = desc.size;
        check(size.length().is_finite(), "jelly", "size", size.to_array(), "a diagonal of finite length")?;
        positive("jelly", "mass", desc.mass)?;
        let mut system = MassSpring::new(desc.method);
        let corner = desc.center - desc.size * 0.5;
        for z in 0..n[2] {
            for y in 0..n[1] {
                for x in 0..n[0] {
                    let part = |i: usize, n: usize| i as f64 / (n - 1) as f64;
                    let at = DVec3::new(part(x, n[0]), part(y, n[1]), part(z, n[2])).mul(desc.size);
                    system.add_point(desc.mass / count as f64, corner + at)?;
                }
            }
        }
        let mut jelly = Self { system, particles: n, triangles: Vec::new() };
        jelly.join(desc.structural, &[[1, 0, 0], [0, 1, 0], [0, 0, 1]])?;
        jelly.join(desc.shear, &DIAGONALS)?;
        jelly.join(desc.bend, &[[2, 0, 0], [0, 2, 0], [0, 0, 2]])?;
        for axis in 0..3 {
            jelly.cover(axis, 0);
            jelly.cover(axis, n[axis] - 1);
        }
        Ok(jelly)
    }

    fn join(&mut self, elasticity: Option<Elasticity>, steps: &[[isize; 3]]) -> Result<()> {
        let Some(elasticity) = elasticity else { return Ok(()) };
        let n = self.particles;
        for step in steps {
            for z in 0..n[2] {
                for y in 0..n[1] {
                    for x in 0..n[0] {
                        let there = [(x, 0), (y, 1), (z, 2)].map(|(i, axis): (usize, usize)| {
                            i.checked_add_signed(step[axis]).filter(|&j| j < n[axis])
                        });
                        let [Some(i), Some(j), Some(k)] = there else { continue };
                        self.system.add_spring([self.index(x, y, z), self.index(i, j, k)], elasticity)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// The triangles of one side, counter-clockwise seen from outside.
    fn cover(&mut self, axis: usize, layer: usize) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for i in 0..self.particles[u] - 1 {
            for j in 0..self.particles[v] - 1 {
                let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| {
                    let mut at = [0; 3];
                    (at[axis], at[u], at[v]) = (layer, i + di, j + dj);
                    self.index(at[0], at[1], at[2]) as u32
                });
                if layer > 0 {
                    self.triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    self.triangles.extend([[a, c, b], [a, d, c]]);
                }
            }
        }
    }

    /// Index of the particle at a place of the lattice. Beyond the block it is that of no particle.
    pub fn index(&self, x: usize, y: usize, z: usize) -> usize {
        let n = self.particles;
        if x < n[0] && y < n[1] && z < n[2] { (z * n[1] + y) * n[0] + x } else { usize::MAX }
    }
    /// Particles along x, y and z.
    pub fn particles(&self) -> [usize; 3] {
        self.particles
    }
    /// Triangles of the skin, as indices of particles, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
}
