//! The lecture's classes: particles with a force accumulator, point masses, and a spring between two of them.
//!
//! The algorithm for each particle: sum the forces, a = F/m, then velocity and position. The particle system's
//! `EulerStep` takes both with the values of *now* (explicit Euler); the point mass's `Update` is the loop of the slide
//! on forces, velocity first (semi-implicit Euler). For systems worth simulating see
//! [`MassSpring`](crate::springs::MassSpring), where the method is chosen.

use crate::collide::Plane;
use crate::error::{Error, Result, check, finite, finite_vector, not_negative, positive};
use crate::force;
use crate::integrate::{Integrator, Method};
use jounce_math::DVec3;

/// A point with a mass, and the forces that have been added up for it.
#[derive(Clone, Debug, PartialEq)]
pub struct PointMass {
    mass: f64,
    /// Position, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    force: DVec3,
    frozen: bool,
}

impl PointMass {
    /// At rest at `position` in m, with `mass` in kg.
    ///
    /// ```
    /// use jounce_math::DVec3;
    /// use jounce_motion::particles::PointMass;
    /// let mut p = PointMass::new(2.0, DVec3::ZERO)?;
    /// p.add_force(DVec3::X * 4.0);
    /// p.update(0.5)?;
    /// assert_eq!((p.velocity, p.position), (DVec3::X, DVec3::X * 0.5));
    /// # Ok::<(), jounce_motion::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::BadValue`] for a mass not above 0 or a position that is not finite.
    pub fn new(mass: f64, position: DVec3) -> Result<Self> {
        positive("point mass", "mass", mass)?;
        finite_vector("point mass", "position", position)?;
        Ok(Self { mass, position, velocity: DVec3::ZERO, force: DVec3::ZERO, frozen: false })
    }

    /// Mass, kg.
    pub fn mass(&self) -> f64 {
        self.mass
    }
    /// Sum of the forces since they were cleared, N.
    pub fn force(&self) -> DVec3 {
        self.force
    }
    /// F/m, m/s²; zero where it is frozen.
    pub fn acceleration(&self) -> DVec3 {
        if self.frozen { DVec3::ZERO } else { self.force / self.mass }
    }
    /// Momentum m v, kg m/s.
    pub fn momentum(&self) -> DVec3 {
        self.velocity * self.mass
    }
    /// Kinetic energy ½ m v², J.
    pub fn kinetic_energy(&self) -> f64 {
        0.5 * self.mass * self.velocity.length_squared()
    }

    /// Forgets the forces.
    pub fn clear_forces(&mut self) {
        self.force = DVec3::ZERO;
    }
    /// Adds a force in N to the sum.
    pub fn add_force(&mut self, force: DVec3) {
        self.force += force;
    }
    /// Stops it where it is; forces then move nothing, until it is thawed.
    pub fn freeze(&mut self) {
        (self.frozen, self.velocity) = (true, DVec3::ZERO);
    }
    /// Lets it move again.
    pub fn thaw(&mut self) {
        self.frozen = false;
    }
    /// True while it is frozen.
    pub fn is_frozen(&self) -> bool {
        self.frozen
    }

    /// One step of `dt` s: Acc = F/M; Vel += Acc Δt; Pos += Vel Δt. Forces stay until they are cleared.
    ///
    /// # Errors
    /// [`Error::BadValue`] or [`Error::Failed`] where step, state or forces are not finite. Nothing moved.
    pub fn update(&mut self, dt: f64) -> Result<()> {
        self.update_by(&mut Integrator::new(Method::SemiImplicitEuler), dt)
    }

    /// One step of `dt` s by any method, under the forces that have been added.
    ///
    /// # Errors
    /// As [`Self::update`].
    pub fn update_by(&mut self, integrator: &mut Integrator<DVec3>, dt: f64) -> Result<()> {
        finite("point mass", "dt", dt)?;
        if !self.frozen {
            let a = self.acceleration();
            integrator.step_point(0.0, dt, &mut self.position, &mut self.velocity, |_, _, _| a)?;
        }
        Ok(())
    }
}

/// A spring between two of a list of point masses.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    /// Indices of its two ends.
    pub point_masses: [usize; 2],
    stiffness: f64,
    damping: f64,
    rest_length: f64,
}

impl Spring {
    /// Between the point masses of these indices: `stiffness` K_s in N/m, `damping` in N s/m, `rest_length` in m.
    ///
    /// # Errors
    /// [`Error::BadValue`] for two equal ends, or numbers that are negative or not finite.
    pub fn new(point_masses: [usize; 2], stiffness: f64, damping: f64, rest_length: f64) -> Result<Self> {
        check_spring(point_masses, stiffness, damping, rest_length)?;
        Ok(Self { point_masses, stiffness, damping, rest_length })
    }

    /// The force in N on its first end; the second feels the opposite.
    ///
    /// # Errors
    /// [`Error::NoSuch`] for an end that is not in the list.
    pub fn force(&self, points: &[PointMass]) -> Result<DVec3> {
        let [a, b] = self.point_masses;
        let get = |i: usize| {
            let none = Error::NoSuch { what: "spring", field: "point mass", index: i, count: points.len() };
            points.get(i).ok_or(none)
        };
        let (a, b) = (get(a)?, get(b)?);
        let (x, v) = (a.position - b.position, a.velocity - b.velocity);
        Ok(force::spring(self.stiffness, self.damping, self.rest_length, x, v))
    }

    /// Adds its force to both ends, equal and opposite.
    ///
    /// ```
    /// use jounce_math::DVec3;
    /// use jounce_motion::particles::{PointMass, Spring};
    /// let mut points = [PointMass::new(1.0, DVec3::ZERO)?, PointMass::new(1.0, DVec3::X * 1.5)?];
    /// Spring::new([0, 1], 10.0, 0.0, 1.0)?.update(&mut points)?;
    /// assert_eq!((points[0].force(), points[1].force()), (DVec3::X * 5.0, DVec3::X * -5.0));
    /// # Ok::<(), jounce_motion::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::force`].
    pub fn update(&self, points: &mut [PointMass]) -> Result<()> {
        let f = self.force(points)?;
        points[self.point_masses[0]].add_force(f);
        points[self.point_masses[1]].add_force(-f);
        Ok(())
    }
}

pub(crate) fn check_spring(ends: [usize; 2], stiffness: f64, damping: f64, rest_length: f64) -> Result<()> {
    check(ends[0] != ends[1], "spring", "ends", ends, "two different points")?;
    not_negative("spring", "stiffness", stiffness)?;
    not_negative("spring", "damping", damping)?;
    not_negative("spring", "rest_length", rest_length)
}

/// A particle of the slide: mass, position, velocity and the accumulator of its forces.
#[derive(Clone, Debug, PartialEq)]
pub struct Particle {
    mass: f64,
    /// Position, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Sum of the forces that act on it, N; whoever has one adds it here.
    pub force_accumulator: DVec3,
}

impl Particle {
    /// With `mass` in kg, at `position` in m, moving at `velocity` in m/s.
    ///
    /// # Errors
    /// [`Error::BadValue`] for a mass not above 0, or a position or velocity that is not finite.
    pub fn new(mass: f64, position: DVec3, velocity: DVec3) -> Result<Self> {
        positive("particle", "mass", mass)?;
        finite_vector("particle", "position", position)?;
        finite_vector("particle", "velocity", velocity)?;
        Ok(Self { mass, position, velocity, force_accumulator: DVec3::ZERO })
    }

    /// Mass, kg.
    pub fn mass(&self) -> f64 {
        self.mass
    }
}

/// The particle system of the slide.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::particles::{Particle, ParticleSystem};
/// let mut system = ParticleSystem::default();
/// system.particles.push(Particle::new(1.0, DVec3::ZERO, DVec3::X)?);
/// for _ in 0..10 {
///     system.add_force(|p| DVec3::Y * (-9.81 * p.mass()));
///     system.euler_step(0.1)?;
/// }
/// // Explicit Euler's fall is short by ½ a t Δt.
/// assert!((system.particles[0].position.y + 0.5 * 9.81 * (1.0 - 0.1)).abs() < 1e-12);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct ParticleSystem {
    /// The particles.
    pub particles: Vec<Particle>,
    /// Kept for its scratch; always [`Method::ExplicitEuler`].
    euler: Euler,
}

/// An explicit Euler integrator by default.
#[derive(Clone, Debug)]
struct Euler(Integrator<DVec3>);

impl Default for Euler {
    fn default() -> Self {
        Self(Integrator::new(Method::ExplicitEuler))
    }
}

impl ParticleSystem {
    /// Adds a force in N, computed from each particle, to its accumulator.
    pub fn add_force(&mut self, force: impl Fn(&Particle) -> DVec3) {
        for p in &mut self.particles {
            let f = force(p);
            p.force_accumulator += f;
        }
    }

    /// One step of `dt` s: v_next = v_now + Δt a, p_next = p_now + Δt v_now. The accumulators are emptied.
    ///
    /// # Errors
    /// [`Error::BadValue`] or [`Error::Failed`] where step, state or a force is not finite; particles up to that one
    /// have moved already.
    pub fn euler_step(&mut self, dt: f64) -> Result<()> {
        self.step_by_inner(dt, None)
    }

    /// One step of `dt` s by any method, under the forces that have been added. The accumulators are emptied.
    ///
    /// # Errors
    /// As [`Self::euler_step`].
    pub fn step_by(&mut self, integrator: &mut Integrator<DVec3>, dt: f64) -> Result<()> {
        self.step_by_inner(dt, Some(integrator))
    }

    fn step_by_inner(&mut self, dt: f64, integrator: Option<&mut Integrator<DVec3>>) -> Result<()> {
        finite("particle system", "dt", dt)?;
        let integrator = integrator.unwrap_or(&mut self.euler.0);
        for p in &mut self.particles {
            let a = p.force_accumulator / p.mass;
            integrator.step_point(0.0, dt, &mut p.position, &mut p.velocity, |_, _, _| a)?;
            p.force_accumulator = DVec3::ZERO;
        }
        Ok(())
    }

    /// Pushes particles out of a plane and lets them bounce; gives how many were inside. K_r and K_f as in
    /// [`respond`](crate::collide::respond).
    pub fn collide(&mut self, plane: &Plane, k_r: f64, k_f: f64) -> usize {
        let mut hits = 0;
        for p in &mut self.particles {
            hits += usize::from(plane.collide(&mut p.position, &mut p.velocity, k_r, k_f));
        }
        hits
    }
}
