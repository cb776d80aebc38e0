//! Bodies that all attract each other.
//!
//! x″ᵢ = Σⱼ G mⱼ rᵢⱼ / (rᵢⱼ² + ε²)^{3/2}, E = Σ ½ m v² − Σ_{i<j} G mᵢ mⱼ / √(rᵢⱼ² + ε²).
//!
//! r: vector from one body to the other, m; ε: softening length, m. Up to a number of bodies every pair is summed, so
//! that momentum is kept to rounding; above it an octree groups distant ones, at an error of the forces of about a per
//! cent for an opening angle of 0.7 and a few parts in a thousand for 0.4.
//! Source: the lecture; J. Barnes and P. Hut, Nature 324 (1986).

use crate::error::{Error, Result, check, finite_vector, not_negative};
use crate::force::{G, gravitation};
use crate::integrate::{Integrator, Method, Report};
use crate::limits::POINTS_MAX;
use crate::octree::Octree;
use crate::springs::Energy;
use jounce_math::DVec3;

/// What a system of bodies is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NBodyDesc {
    /// Gravitational constant, m³/(kg s²); 1 in natural units.
    pub g: f64,
    /// Softening length ε, m; 0 for point masses.
    pub softening: f64,
    /// How it is integrated.
    pub method: Method,
    /// Opening angle θ of the tree, above 0, at most 1.
    pub opening_angle: f64,
    /// Above so many bodies the tree is used.
    pub tree_above: usize,
}

impl Default for NBodyDesc {
    fn default() -> Self {
        Self { g: G, softening: 0.0, method: Method::VelocityVerlet, opening_angle: 0.5, tree_above: 2000 }
    }
}

/// A system of bodies that attract each other.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::nbody::{NBody, NBodyDesc};
/// // Two equal bodies around each other, G = 1: each on a circle of radius 1/2 at speed √½.
/// let mut pair = NBody::new(NBodyDesc { g: 1.0, ..NBodyDesc::default() })?;
/// let v = 0.5f64.sqrt();
/// pair.add(1.0, DVec3::X * 0.5, DVec3::Y * v)?;
/// pair.add(1.0, DVec3::X * -0.5, DVec3::Y * -v)?;
/// let energy = pair.energy().total();
/// for _ in 0..1000 {
///     pair.step(0.001)?;
/// }
/// assert!((pair.positions()[0].length() - 0.5).abs() < 1e-6);
/// assert!((pair.energy().total() - energy).abs() < 1e-6);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct NBody {
    desc: NBodyDesc,
    integrator: Integrator<DVec3>,
    tree: Octree,
    time: f64,
    masses: Vec<f64>,
    positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
}

impl NBody {
    /// Without bodies.
    ///
    /// # Errors
    /// [`Error::BadValue`] for a constant or a softening that is negative, or an opening angle out of range.
    pub fn new(desc: NBodyDesc) -> Result<Self> {
        not_negative("n-body", "g", desc.g)?;
        not_negative("n-body", "softening", desc.softening)?;
        let angle = desc.opening_angle;
        check(angle > 0.0 && angle <= 1.0, "n-body", "opening_angle", angle, "above 0, at most 1")?;
        Ok(Self {
            desc,
            integrator: Integrator::new(desc.method),
            tree: Octree::default(),
            time: 0.0,
            masses: Vec::new(),
            positions: Vec::new(),
            velocities: Vec::new(),
        })
    }

    /// Changes the method, or its options.
    pub fn set_integrator(&mut self, integrator: Integrator<DVec3>) {
        self.integrator = integrator;
    }

    /// Adds a body: `mass` in kg (0: it is attracted and attracts nothing), `position` in m, `velocity` in m/s. Gives its
    /// index.
    ///
    /// # Errors
    /// [`Error::BadValue`] for a negative mass or numbers that are not finite, [`Error::Limit`] beyond [`POINTS_MAX`].
    pub fn add(&mut self, mass: f64, position: DVec3, velocity: DVec3) -> Result<usize> {
        not_negative("body", "mass", mass)?;
        finite_vector("body", "position", position)?;
        finite_vector("body", "velocity", velocity)?;
        if self.masses.len() >= POINTS_MAX {
            return Err(Error::Limit { what: "bodies", limit: POINTS_MAX });
        }
        self.masses.push(mass);
        self.positions.push(position);
        self.velocities.push(velocity);
        Ok(self.masses.len() - 1)
    }

    /// Takes a step of `dt` s.
    ///
    /// # Errors
    /// [`Error::BadValue`] for a bad step, [`Error::Failed`] where the motion does not stay finite. Nothing moved.
    pub fn step(&mut self, dt: f64) -> Result<Report> {
        let (desc, masses, tree) = (&self.desc, &self.masses, &mut self.tree);
        let (x, v) = (&mut self.positions, &mut self.velocities);
        let report = self
            .integrator
            .step_motion(self.time, dt, x, v, |_, x, _, a| accelerations(desc, masses, tree, x, a))?;
        self.time += dt;
        Ok(report)
    }

    /// Accelerations as they are now, m/s².
    pub fn accelerations(&mut self) -> Vec<DVec3> {
        let mut a = vec![DVec3::ZERO; self.masses.len()];
        accelerations(&self.desc, &self.masses, &mut self.tree, &self.positions, &mut a);
        a
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.time
    }
    /// Positions by index, m.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }
    /// Velocities by index, m/s.
    pub fn velocities(&self) -> &[DVec3] {
        &self.velocities
    }
    /// Masses by index, kg.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Energies, J, summed over all pairs.
    pub fn energy(&self) -> Energy {
        let mut e = Energy::default();
        for i in 0..self.masses.len() {
            e.kinetic += 0.5 * self.masses[i] * self.velocities[i].length_squared();
            for j in i + 1..self.masses.len() {
                let d2 = (self.positions[j] - self.positions[i]).length_squared();
                let s = (d2 + self.desc.softening * self.desc.softening).sqrt();
                if s > 0.0 {
                    e.gravity -= self.desc.g * (self.masses[i] * self.masses[j]) / s;
                }
            }
        }
        e
    }

    /// Σ m v, kg m/s.
    pub fn momentum(&self) -> DVec3 {
        self.masses.iter().zip(&self.velocities).fold(DVec3::ZERO, |p, (m, v)| p + *v * *m)
    }

    /// Σ m x × v about the origin, kg m²/s.
    pub fn angular_momentum(&self) -> DVec3 {
        let bodies = self.masses.iter().zip(&self.positions).zip(&self.velocities);
        bodies.fold(DVec3::ZERO, |l, ((m, x), v)| l + x.cross(*v) * *m)
    }
}

fn accelerations(desc: &NBodyDesc, masses: &[f64], tree: &mut Octree, x: &[DVec3], a: &mut [DVec3]) {
    // An explicit step that runs away can ask for forces at infinity; there is no cube around that.
    let finite = x.iter().all(|p| p.is_finite());
    if x.len() > desc.tree_above && finite {
        tree.build(x, masses, desc.opening_angle);
        for (i, a) in a.iter_mut().enumerate() {
            *a = tree.acceleration(i, x, masses, desc.g, desc.softening);
        }
        return;
    }
    a.fill(DVec3::ZERO);
    for i in 0..x.len() {
        for j in i + 1..x.len() {
            // Of two unit masses, so that a body without mass feels it too.
            let pull = gravitation(desc.g, 1.0, 1.0, x[j] - x[i], desc.softening);
            a[i] += pull * masses[j];
            a[j] -= pull * masses[i];
        }
    }
}
