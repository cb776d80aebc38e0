//! Motion by momentum.
//!
//! dP/dt = F, v = P/m; dL/dt = τ, ω = I⁻¹ L with I = R I₀ R⁻¹.
//!
//! P momentum, kg m/s; L angular momentum about the centre of mass, kg m²/s; F force, N; τ torque, N m; R rotation from
//! the body's frame to the world's; I₀ inertia tensor in the body's frame, kg m²; ω angular velocity, rad/s.
//!
//! [`RigidBody::update`] is the lecture's loop. Its L is as good as its arithmetic, but ω = I⁻¹ L is held over a step in
//! which I turns, so energy drifts with Δt. [`RigidBody::update_midpoint`] solves, in the body's frame with m = R⁻¹ L,
//!
//! m′ = m + Δt m̄ × ω̄, m̄ = ½ (m + m′), ω̄ = I₀⁻¹ m̄, and turns by Cayley's rotation of Δt ω̄, R′ = R Cay(Δt ω̄).
//!
//! Then |m|² and m·I₀⁻¹m are kept exactly, being quadratic, and since m′ = Cay(−Δt ω̄) m, so is R m = L as a vector.
//! Source: the lecture; D. Lewis and J. C. Simo, "Conserving algorithms for the dynamics of Hamiltonian systems on Lie
//! groups", J. Nonlinear Sci. 4 (1994).

use crate::error::{Result, bad, check, finite, finite_vector, positive};
use crate::limits::NEWTON_MAX;
use jounce_math::{DMat3, DQuat, DVec3};

/// P += F Δt, then v = P/m: the new momentum in kg m/s and the new velocity in m/s.
///
/// ```
/// use jounce_math::DVec3;
/// let (p, v) = jounce_motion::momentum::push(DVec3::X * 6.0, 2.0, DVec3::Y * 10.0, 0.5);
/// assert_eq!((p, v), (DVec3::new(6.0, 5.0, 0.0), DVec3::new(3.0, 2.5, 0.0)));
/// ```
#[inline]
pub fn push(momentum: DVec3, mass: f64, force: DVec3, dt: f64) -> (DVec3, DVec3) {
    let p = momentum + force * dt;
    (p, p / mass)
}

/// I = R I₀ R⁻¹ in kg m²: the inertia tensor of a body turned by R (R⁻¹ = Rᵀ).
///
/// ```
/// use jounce_math::{DMat3, DQuat, DVec3};
/// let quarter = DQuat::from_axis_angle(DVec3::Z, std::f64::consts::FRAC_PI_2);
/// let turned = jounce_motion::momentum::world_inertia(quarter, &DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0)));
/// assert!((turned.diagonal() - DVec3::new(2.0, 1.0, 3.0)).length() < 1e-15);
/// ```
pub fn world_inertia(rotation: DQuat, inertia: &DMat3) -> DMat3 {
    let r = rotation.to_mat3();
    r * *inertia * r.transpose()
}

/// The turn by `angle_vector` = ω Δt, in rad: about its direction, by its length. The slide's `Matrix.Rotate`.
///
/// ```
/// use jounce_math::DVec3;
/// let turn = jounce_motion::momentum::turn(DVec3::Z * std::f64::consts::FRAC_PI_2);
/// assert!((turn.rotate(DVec3::X) - DVec3::Y).length() < 1e-15);
/// ```
pub fn turn(angle_vector: DVec3) -> DQuat {
    match angle_vector.try_normalize() {
        Some((axis, angle)) => DQuat::from_axis_angle(axis, angle),
        None => DQuat::IDENTITY,
    }
}

/// A rigid body of the lecture: momentum and angular momentum are its state, velocities follow from them.
///
/// ```
/// use jounce_math::{DMat3, DVec3};
/// use jounce_motion::momentum::RigidBody;
/// let mut body = RigidBody::new(2.0, DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0)))?;
/// body.add_force(DVec3::X * 4.0);
/// body.update(0.5)?;
/// assert_eq!((body.velocity(), body.position()), (DVec3::X, DVec3::X * 0.5));
/// # Ok::<(), jounce_motion::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RigidBody {
    mass: f64,
    /// I₀ and its inverse.
    inertia: DMat3,
    inverse_inertia: DMat3,
    position: DVec3,
    rotation: DQuat,
    momentum: DVec3,
    angular_momentum: DVec3,
    force: DVec3,
    torque: DVec3,
}

impl RigidBody {
    /// At the origin and at rest. `mass` in kg, `inertia` about the centre of mass in the body's frame, kg m².
    ///
    /// # Errors
    /// [`Error::BadValue`](crate::Error::BadValue) for a mass not above 0, or an inertia that is not symmetric with
    /// three eigenvalues above 0.
    pub fn new(mass: f64, inertia: DMat3) -> Result<Self> {
        let what = "rigid body";
        positive(what, "mass", mass)?;
        let expected = "a symmetric tensor with eigenvalues above 0";
        let skew = inertia - inertia.transpose();
        let size = inertia.diagonal().abs().max_component();
        let uneven = [skew.cx, skew.cy, skew.cz].map(|c| c.abs().max_component());
        let symmetric = inertia.is_finite() && uneven.into_iter().all(|u| u <= 1e-9 * size);
        let eigen = inertia.symmetric_eigen().0;
        let inverse = if symmetric && eigen.min_component() > 0.0 { inertia.inverse() } else { None };
        let Some(inverse_inertia) = inverse else {
            return Err(bad(what, "inertia", inertia, expected));
        };
        Ok(Self {
            mass,
            inertia,
            inverse_inertia,
            position: DVec3::ZERO,
            rotation: DQuat::IDENTITY,
            momentum: DVec3::ZERO,
            angular_momentum: DVec3::ZERO,
            force: DVec3::ZERO,
            torque: DVec3::ZERO,
        })
    }

    /// Puts the body somewhere: position in m and rotation, which is normalised.
    ///
    /// # Errors
    /// [`Error::BadValue`](crate::Error::BadValue) for a pose that is not finite.
    pub fn set_pose(&mut self, position: DVec3, rotation: DQuat) -> Result<()> {
        finite_vector("rigid body", "position", position)?;
        let usable = rotation.is_finite() && rotation.length() > 0.0;
        check(usable, "rigid body", "rotation", rotation.to_array(), "four finite numbers, not all 0")?;
        (self.position, self.rotation) = (position, rotation.normalize());
        Ok(())
    }

    /// Sets P = m v and L = I ω, from velocities in m/s and rad/s.
    ///
    /// # Errors
    /// [`Error::BadValue`](crate::Error::BadValue) for velocities that are not finite.
    pub fn set_velocities(&mut self, velocity: DVec3, angular_velocity: DVec3) -> Result<()> {
        finite_vector("rigid body", "velocity", velocity)?;
        finite_vector("rigid body", "angular_velocity", angular_velocity)?;
        self.momentum = velocity * self.mass;
        self.angular_momentum = self.world_inertia() * angular_velocity;
        Ok(())
    }

    /// Mass, kg.
    pub fn mass(&self) -> f64 {
        self.mass
    }
    /// Position of the centre of mass, m.
    pub fn position(&self) -> DVec3 {
        self.position
    }
    /// Rotation from the body's frame to the world's.
    pub fn rotation(&self) -> DQuat {
        self.rotation
    }
    /// P, kg m/s.
    pub fn momentum(&self) -> DVec3 {
        self.momentum
    }
    /// L about the centre of mass, kg m²/s.
    pub fn angular_momentum(&self) -> DVec3 {
        self.angular_momentum
    }
    /// v = P/m, m/s.
    pub fn velocity(&self) -> DVec3 {
        self.momentum / self.mass
    }
    /// ω = I⁻¹ L, rad/s.
    pub fn angular_velocity(&self) -> DVec3 {
        self.rotation.rotate(self.inverse_inertia * self.rotation.inverse_rotate(self.angular_momentum))
    }
    /// I = R I₀ R⁻¹, kg m².
    pub fn world_inertia(&self) -> DMat3 {
        world_inertia(self.rotation, &self.inertia)
    }
    /// ½ P·v + ½ L·ω, J.
    pub fn kinetic_energy(&self) -> f64 {
        0.5 * (self.momentum.dot(self.velocity()) + self.angular_momentum.dot(self.angular_velocity()))
    }
    /// Velocity of a point given in the world, m/s: v + ω × r.
    pub fn velocity_at(&self, point: DVec3) -> DVec3 {
        self.velocity() + self.angular_velocity().cross(point - self.position)
    }

    /// Adds a force in N that acts at the centre of mass, until the next update.
    pub fn add_force(&mut self, force: DVec3) {
        self.force += force;
    }
    /// Adds a force in N at a point of the world: also the torque r × F.
    pub fn add_force_at(&mut self, force: DVec3, point: DVec3) {
        self.force += force;
        self.torque += (point - self.position).cross(force);
    }
    /// Adds a torque in N m until the next update.
    pub fn add_torque(&mut self, torque: DVec3) {
        self.torque += torque;
    }

    /// One step of `dt` s, line by line as the lecture has it, and the forces are spent.
    ///
    /// # Errors
    /// [`Error::BadValue`](crate::Error::BadValue) for a step, a force or a torque that is not finite. Nothing moved.
    pub fn update(&mut self, dt: f64) -> Result<()> {
        self.check(dt)?;
        self.momentum += self.force * dt;
        let velocity = self.momentum / self.mass;
        self.position += velocity * dt;
        self.angular_momentum += self.torque * dt;
        let inertia = self.world_inertia();
        // The tensor was checked to have an inverse, and turning does not take it away.
        let angular_velocity = inertia.solve(self.angular_momentum);
        self.rotation = (turn(angular_velocity * dt) * self.rotation).normalize();
        self.clear_forces();
        Ok(())
    }

    /// One step of `dt` s of second order that keeps L and, without torque, the energy to rounding at any step: half
    /// of the push, free motion by the implicit midpoint rule, the other half. The forces are spent.
    ///
    /// ```
    /// use jounce_math::{DMat3, DVec3};
    /// use jounce_motion::momentum::RigidBody;
    /// let mut body = RigidBody::new(1.0, DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0)))?;
    /// body.set_velocities(DVec3::ZERO, DVec3::new(0.01, 1.0, 0.0))?;
    /// let energy = body.kinetic_energy();
    /// for _ in 0..1000 {
    ///     body.update_midpoint(0.02)?;
    /// }
    /// assert!((body.kinetic_energy() - energy).abs() < 1e-12);
    /// # Ok::<(), jounce_motion::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::update`].
    pub fn update_midpoint(&mut self, dt: f64) -> Result<()> {
        self.check(dt)?;
        let (half_push, half_twist) = (self.force * (0.5 * dt), self.torque * (0.5 * dt));
        self.momentum += half_push;
        self.angular_momentum += half_twist;
        self.position += self.momentum / self.mass * dt;
        // The rule has its answer for sure while a step turns by less than about a radian.
        let spin = self.angular_velocity().length() * dt.abs();
        let parts = if spin > 0.5 { (spin / 0.5).ceil() } else { 1.0 };
        for _ in 0..parts as u32 {
            self.turn_freely(dt / parts);
        }
        self.momentum += half_push;
        self.angular_momentum += half_twist;
        self.clear_forces();
        Ok(())
    }

    /// Turns without torque by the implicit midpoint rule.
    fn turn_freely(&mut self, dt: f64) {
        let m = self.rotation.inverse_rotate(self.angular_momentum);
        // Newton on the midpoint m̄ itself: r(m̄) = m̄ − m − Δt/2 m̄ × I₀⁻¹ m̄,
        // ∂r/∂m̄ = 1 − Δt/2 ([m̄]× I₀⁻¹ − [ω̄]×).
        let mut mid = m;
        let mut last = f64::INFINITY;
        for _ in 0..NEWTON_MAX {
            let w = self.inverse_inertia * mid;
            let r = mid - m - mid.cross(w) * (0.5 * dt);
            let size = r.length();
            // At the floor of rounding it stops getting smaller.
            if size == 0.0 || size >= last {
                break;
            }
            last = size;
            let slope = DMat3::skew(mid) * self.inverse_inertia - DMat3::skew(w);
            mid -= (DMat3::IDENTITY - slope.scale(0.5 * dt)).solve(r);
        }
        let half = (self.inverse_inertia * mid) * (0.5 * dt);
        self.rotation = (self.rotation * DQuat::new(half.x, half.y, half.z, 1.0)).normalize();
    }

    fn check(&self, dt: f64) -> Result<()> {
        finite("rigid body", "dt", dt)?;
        finite_vector("rigid body", "force", self.force)?;
        finite_vector("rigid body", "torque", self.torque)?;
        let turned = self.angular_velocity().length() * dt.abs();
        check(
            turned <= 1e6,
            "rigid body",
            "dt",
            dt,
            "a step that turns the body by less than a million radians",
        )
    }

    /// Forgets forces and torques; an update does so by itself, unless it was refused.
    pub fn clear_forces(&mut self) {
        (self.force, self.torque) = (DVec3::ZERO, DVec3::ZERO);
    }
}
