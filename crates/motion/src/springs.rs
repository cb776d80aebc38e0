//! Point masses joined by springs, in any number and arrangement, by any method.
//!
//! m x″ = Σ F_spring + m g − b x′ + F + m a(x, x′, t), with F_spring = −(K_s (l − L) + c l′) n along each spring.
//!
//! l: length now, L: at rest, n: direction; K_s stiffness, N/m; c damping of a spring, N s/m; b drag of a point, kg/s;
//! g gravity and a an acceleration field of the caller's, m/s²; F the forces added since the last step, N.
//!
//! An explicit method is stable while Δt is below about 2/ω with ω² the largest 4 K_s/m of the mesh (times the number of
//! springs at a point over two); [`Method::ImplicitEuler`] at any step.
//! Source: the lecture; X. Provot, "Deformation constraints in a mass–spring model", Graphics Interface (1995).

use crate::collide::{Ball, Plane};
use crate::error::{Error, Result, check, finite_vector, not_negative, positive};
use crate::force;
use crate::integrate::{Integrator, Method, Report};
use crate::limits::POINTS_MAX;
use crate::particles::check_spring;
use jounce_math::DVec3;

/// What a spring is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elasticity {
    /// K_s, N/m.
    pub stiffness: f64,
    /// Damping along the spring, N s/m.
    pub damping: f64,
}

/// Energies of a system, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Σ ½ m v².
    pub kinetic: f64,
    /// Σ ½ K_s (l − L)².
    pub elastic: f64,
    /// −Σ m g·x.
    pub gravity: f64,
}

impl Energy {
    /// All of them.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravity
    }
}

/// Springs as columns, by the order in which they were added.
#[derive(Clone, Debug, Default)]
struct Springs {
    ends: Vec<[u32; 2]>,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    rest_length: Vec<f64>,
}

impl Springs {
    /// Adds every spring's force to both of its ends.
    fn add_forces(&self, x: &[DVec3], v: &[DVec3], f: &mut [DVec3]) {
        for (s, ends) in self.ends.iter().enumerate() {
            let [a, b] = ends.map(|e| e as usize);
            let pull = force::spring(
                self.stiffness[s],
                self.damping[s],
                self.rest_length[s],
                x[a] - x[b],
                v[a] - v[b],
            );
            f[a] += pull;
            f[b] -= pull;
        }
    }
}

/// What points stay out of.
#[derive(Clone, Copy, Debug)]
enum Obstacle {
    Plane(Plane),
    Ball(Ball),
}

/// A system of point masses and springs.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::integrate::Method;
/// use jounce_motion::springs::{Elasticity, MassSpring};
/// // A weight of 1 kg hangs from a spring and comes to rest m g/K_s below its rest length.
/// let mut system = MassSpring::new(Method::ImplicitEuler);
/// system.set_gravity(DVec3::Y * -9.81)?;
/// let hook = system.add_point(1.0, DVec3::ZERO)?;
/// let weight = system.add_point(1.0, DVec3::Y * -1.0)?;
/// system.freeze(hook)?;
/// system.add_spring([hook, weight], Elasticity { stiffness: 100.0, damping: 20.0 })?;
/// for _ in 0..1000 {
///     system.step(0.01)?;
/// }
/// assert!((system.positions()[weight].y + 1.0981).abs() < 1e-9);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct MassSpring {
    integrator: Integrator<DVec3>,
    time: f64,
    masses: Vec<f64>,
    positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
    forces: Vec<DVec3>,
    frozen: Vec<bool>,
    springs: Springs,
    gravity: DVec3,
    drag: f64,
    obstacles: Vec<(Obstacle, f64, f64)>,
}

impl MassSpring {
    /// Without points, gravity or drag, by this method.
    pub fn new(method: Method) -> Self {
        Self { integrator: Integrator::new(method), ..Self::default() }
    }

    /// Changes the method, or its options.
    pub fn set_integrator(&mut self, integrator: Integrator<DVec3>) {
        self.integrator = integrator;
    }

    /// Gravity in m/s².
    ///
    /// # Errors
    /// [`Error::BadValue`] where it is not finite.
    pub fn set_gravity(&mut self, gravity: DVec3) -> Result<()> {
        finite_vector("spring system", "gravity", gravity)?;
        self.gravity = gravity;
        Ok(())
    }

    /// Drag −b v on every point, b in kg/s.
    ///
    /// # Errors
    /// [`Error::BadValue`] where it is negative or not finite.
    pub fn set_drag(&mut self, drag: f64) -> Result<()> {
        not_negative("spring system", "drag", drag)?;
        self.drag = drag;
        Ok(())
    }

    /// Adds a point at rest, `mass` in kg, `position` in m; gives its index.
    ///
    /// # Errors
    /// [`Error::BadValue`] for a mass not above 0 or a position that is not finite, [`Error::Limit`] beyond
    /// [`POINTS_MAX`].
    pub fn add_point(&mut self, mass: f64, position: DVec3) -> Result<usize> {
        positive("point", "mass", mass)?;
        finite_vector("point", "position", position)?;
        if self.masses.len() >= POINTS_MAX {
            return Err(Error::Limit { what: "points", limit: POINTS_MAX });
        }
        self.masses.push(mass);
        self.positions.push(position);
        self.velocities.push(DVec3::ZERO);
        self.forces.push(DVec3::ZERO);
        self.frozen.push(false);
        Ok(self.masses.len() - 1)
    }

    /// Joins two points by a spring that is at rest as they are now; gives its index.
    ///
    /// # Errors
    /// As [`Self::add_spring_of_length`].
    pub fn add_spring(&mut self, ends: [usize; 2], elasticity: Elasticity) -> Result<usize> {
        let [a, b] = [self.get(ends[0])?, self.get(ends[1])?];
        self.add_spring_of_length(ends, elasticity, self.positions[a].distance(self.positions[b]))
    }

    /// Joins two points by a spring of this length at rest, m; gives its index.
    ///
    /// # Errors
    /// [`Error::NoSuch`] for a point that is not there, [`Error::BadValue`] for equal ends or numbers that are negative
    /// or not finite.
    pub fn add_spring_of_length(
        &mut self,
        ends: [usize; 2],
        elasticity: Elasticity,
        rest_length: f64,
    ) -> Result<usize> {
        let [a, b] = [self.get(ends[0])?, self.get(ends[1])?];
        check_spring(ends, elasticity.stiffness, elasticity.damping, rest_length)?;
        let s = &mut self.springs;
        // Below `POINTS_MAX`, hence within u32.
        s.ends.push([a as u32, b as u32]);
        s.stiffness.push(elasticity.stiffness);
        s.damping.push(elasticity.damping);
        s.rest_length.push(rest_length);
        Ok(s.ends.len() - 1)
    }

    /// A plane that points stay outside of; K_r and K_f as in [`respond`](crate::collide::respond).
    ///
    /// # Errors
    /// [`Error::BadValue`] for a K_r that is not 0 or more, or a K_f not within 0 and 1.
    pub fn add_plane(&mut self, plane: Plane, k_r: f64, k_f: f64) -> Result<()> {
        self.add_obstacle(Obstacle::Plane(plane), k_r, k_f)
    }

    /// A ball that points stay outside of.
    ///
    /// # Errors
    /// As [`Self::add_plane`].
    pub fn add_ball(&mut self, ball: Ball, k_r: f64, k_f: f64) -> Result<()> {
        self.add_obstacle(Obstacle::Ball(ball), k_r, k_f)
    }

    fn add_obstacle(&mut self, obstacle: Obstacle, k_r: f64, k_f: f64) -> Result<()> {
        not_negative("obstacle", "k_r", k_r)?;
        check((0.0..=1.0).contains(&k_f), "obstacle", "k_f", k_f, "0 to 1")?;
        self.obstacles.push((obstacle, k_r, k_f));
        Ok(())
    }

    /// Holds a point where it is.
    ///
    /// # Errors
    /// [`Error::NoSuch`] for a point that is not there.
    pub fn freeze(&mut self, point: usize) -> Result<()> {
        let i = self.get(point)?;
        (self.frozen[i], self.velocities[i]) = (true, DVec3::ZERO);
        Ok(())
    }

    /// Lets a point move again.
    ///
    /// # Errors
    /// [`Error::NoSuch`] for a point that is not there.
    pub fn thaw(&mut self, point: usize) -> Result<()> {
        let i = self.get(point)?;
        self.frozen[i] = false;
        Ok(())
    }

    /// Puts a point elsewhere, m: frozen ones can be led along a path this way.
    ///
    /// # Errors
    /// [`Error::NoSuch`] for a point that is not there, [`Error::BadValue`] for a position that is not finite.
    pub fn set_position(&mut self, point: usize, position: DVec3) -> Result<()> {
        let i = self.get(point)?;
        finite_vector("point", "position", position)?;
        self.positions[i] = position;
        Ok(())
    }

    /// Gives a point another velocity, m/s; a frozen one keeps 0.
    ///
    /// # Errors
    /// [`Error::NoSuch`] for a point that is not there, [`Error::BadValue`] for a velocity that is not finite.
    pub fn set_velocity(&mut self, point: usize, velocity: DVec3) -> Result<()> {
        let i = self.get(point)?;
        finite_vector("point", "velocity", velocity)?;
        if !self.frozen[i] {
            self.velocities[i] = velocity;
        }
        Ok(())
    }

    /// Adds a force in N on a point during the next step.
    ///
    /// # Errors
    /// [`Error::NoSuch`] for a point that is not there, [`Error::BadValue`] for a force that is not finite.
    pub fn add_force(&mut self, point: usize, force: DVec3) -> Result<()> {
        let i = self.get(point)?;
        finite_vector("point", "force", force)?;
        self.forces[i] += force;
        Ok(())
    }

    /// Takes a step of `dt` s.
    ///
    /// # Errors
    /// [`Error::BadValue`] for a bad step, [`Error::Failed`] where the motion does not stay finite (a method beyond its
    /// stable step) or an implicit step finds no answer. Nothing moved.
    pub fn step(&mut self, dt: f64) -> Result<Report> {
        self.step_with(dt, |_, _, _| DVec3::ZERO, |_, _, _| ())
    }

    /// Takes a step of `dt` s in an acceleration field, `field(position, velocity, t)` in m/s², and shows every point
    /// that is not frozen to `after(index, position, velocity)`, which may change them: there a caller lets points
    /// collide with a world of its own.
    ///
    /// ```
    /// use jounce_math::DVec3;
    /// use jounce_motion::integrate::Method;
    /// use jounce_motion::springs::MassSpring;
    /// let mut system = MassSpring::new(Method::VelocityVerlet);
    /// let p = system.add_point(1.0, DVec3::ZERO)?;
    /// for _ in 0..100 {
    ///     system.step_with(0.01, |_x, _v, t| DVec3::X * t, |_i, x, _v| x.y = 0.0)?;
    /// }
    /// assert!((system.velocities()[p].x - 0.5).abs() < 1e-12);
    /// # Ok::<(), jounce_motion::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn step_with(
        &mut self,
        dt: f64,
        field: impl Fn(DVec3, DVec3, f64) -> DVec3,
        mut after: impl FnMut(usize, &mut DVec3, &mut DVec3),
    ) -> Result<Report> {
        let (springs, masses, forces, frozen) = (&self.springs, &self.masses, &self.forces, &self.frozen);
        let (gravity, drag) = (self.gravity, self.drag);
        let (x, v) = (&mut self.positions, &mut self.velocities);
        let report = self.integrator.step_motion(self.time, dt, x, v, |t, x, v, a| {
            a.copy_from_slice(forces);
            springs.add_forces(x, v, a);
            for i in 0..a.len() {
                a[i] = if frozen[i] {
                    DVec3::ZERO
                } else {
                    (a[i] + force::stokes_drag(drag, v[i])) / masses[i] + gravity + field(x[i], v[i], t)
                };
            }
        })?;
        for i in (0..x.len()).filter(|&i| !frozen[i]) {
            for &(obstacle, k_r, k_f) in &self.obstacles {
                match obstacle {
                    Obstacle::Plane(p) => p.collide(&mut x[i], &mut v[i], k_r, k_f),
                    Obstacle::Ball(b) => b.collide(&mut x[i], &mut v[i], k_r, k_f),
                };
            }
            after(i, &mut x[i], &mut v[i]);
        }
        self.forces.fill(DVec3::ZERO);
        self.time += dt;
        Ok(report)
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
    /// The two ends of every spring.
    pub fn spring_ends(&self) -> &[[u32; 2]] {
        &self.springs.ends
    }
    /// True for a point that is frozen; false for one that is not, or is not there.
    pub fn is_frozen(&self, point: usize) -> bool {
        self.frozen.get(point).copied().unwrap_or(false)
    }

    /// Energies, J. Frozen points count for gravity.
    pub fn energy(&self) -> Energy {
        let mut e = Energy::default();
        for i in 0..self.masses.len() {
            e.kinetic += 0.5 * self.masses[i] * self.velocities[i].length_squared();
            e.gravity -= self.masses[i] * self.gravity.dot(self.positions[i]);
        }
        for (s, ends) in self.springs.ends.iter().enumerate() {
            let [a, b] = ends.map(|e| self.positions[e as usize]);
            let stretch = a.distance(b) - self.springs.rest_length[s];
            e.elastic += 0.5 * self.springs.stiffness[s] * stretch * stretch;
        }
        e
    }

    /// Σ m v, kg m/s.
    pub fn momentum(&self) -> DVec3 {
        self.masses.iter().zip(&self.velocities).fold(DVec3::ZERO, |p, (m, v)| p + *v * *m)
    }

    /// Σ m x / Σ m, m; the origin where there are no points.
    pub fn center_of_mass(&self) -> DVec3 {
        let mass: f64 = self.masses.iter().fold(0.0, |s, m| s + m);
        let sum = self.masses.iter().zip(&self.positions).fold(DVec3::ZERO, |s, (m, x)| s + *x * *m);
        if mass > 0.0 { sum / mass } else { DVec3::ZERO }
    }

    fn get(&self, point: usize) -> Result<usize> {
        let count = self.masses.len();
        let none = Error::NoSuch { what: "spring system", field: "point", index: point, count };
        if point < count { Ok(point) } else { Err(none) }
    }
}
