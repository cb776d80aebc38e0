//! Integrators: from a state and its derivative to the state a little later.
//!
//! Two kinds of system, and every method for both where it has a meaning:
//!
//! - mechanical, of second order: x″ = a(t, x, v), positions and velocities side by side ([`Integrator::step_motion`]);
//! - general, of first order: y′ = f(t, y) ([`Integrator::step`]).
//!
//! A mechanical system is also one of first order, y = (x, v), y′ = (v, a), and that is how most methods see it; those
//! that treat positions and velocities differently (semi-implicit Euler, Verlet) only take mechanical ones.
//!
//! A column holds any number of coupled unknowns, each an `f64` or a [`DVec3`]. The derivative is a closure that fills a
//! column. Scratch is kept in the integrator: after the first step nothing is allocated.

mod adaptive;
mod dopri5;
mod fixed;
mod implicit;
mod method;

pub use dopri5::Dopri5;
pub(crate) use dopri5::dense_value;
pub use method::Method;

use crate::error::{Error, Result, check, positive};
use crate::limits;
use core::ops::{Add, Mul, Range, Sub};
use implicit::Newton;
use jounce_math::DVec3;
use jounce_math::scalar::f64s::{max, min};

/// What integrators can add and scale: `f64` and [`DVec3`].
pub trait Vector: Copy + Default + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {
    /// Inner product.
    fn dot(self, o: Self) -> f64;
    /// True when no component is infinite or NaN.
    fn is_finite(self) -> bool;
}

impl Vector for f64 {
    fn dot(self, o: Self) -> f64 {
        self * o
    }
    fn is_finite(self) -> bool {
        self.is_finite()
    }
}

impl Vector for DVec3 {
    fn dot(self, o: Self) -> f64 {
        self.dot(o)
    }
    fn is_finite(self) -> bool {
        self.is_finite()
    }
}

/// What the adaptive Euler method compares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Measure {
    /// The velocities, as on the slide. It is blind where they come out right by chance: under a constant force, and in
    /// the first step of a spring from rest, E is 0 and the step grows to the ceiling. Set `dt_max`, or measure all.
    #[default]
    Velocity,
    /// Positions and velocities.
    State,
}

/// What adaptive and implicit methods are asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// E_tol of the adaptive Euler method: tolerated error of a step, in the unit of what is measured.
    pub tolerance: f64,
    /// What the adaptive Euler method measures in a mechanical system.
    pub measure: Measure,
    /// Error of a step relative to the state, for Dormand–Prince.
    pub relative_tolerance: f64,
    /// Error of a step where the state is near zero, for Dormand–Prince.
    pub absolute_tolerance: f64,
    /// Part of the ideal step that is taken, 0.1 to 1.
    pub safety: f64,
    /// Floor of the step, s: here a step is kept whatever its error.
    pub dt_min: f64,
    /// Ceiling of the step, s.
    pub dt_max: f64,
    /// Residual of an implicit step, relative to the state and its change.
    pub newton_tolerance: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            tolerance: 1e-3,
            measure: Measure::Velocity,
            relative_tolerance: 1e-10,
            absolute_tolerance: 1e-10,
            safety: 0.9,
            dt_min: 1e-9,
            dt_max: f64::MAX,
            newton_tolerance: 1e-10,
        }
    }
}

impl Options {
    /// Themselves, or what is wrong with them.
    pub(crate) fn checked(self) -> Result<Self> {
        let what = "integrator";
        positive(what, "tolerance", self.tolerance)?;
        positive(what, "relative_tolerance", self.relative_tolerance)?;
        positive(what, "absolute_tolerance", self.absolute_tolerance)?;
        positive(what, "newton_tolerance", self.newton_tolerance)?;
        positive(what, "dt_min", self.dt_min)?;
        check((0.1..=1.0).contains(&self.safety), what, "safety", self.safety, "0.1 to 1")?;
        check(self.dt_max >= self.dt_min, what, "dt_max", self.dt_max, "dt_min or more")?;
        Ok(self)
    }
}

/// What a call of an integrator did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Steps that were kept; 1 for methods of a given step, unless an implicit one had to be split.
    pub steps: u64,
    /// Steps that were taken again, shorter.
    pub rejected: u64,
    /// Steps at the floor that were kept although their error was above the tolerance.
    pub forced: u64,
    /// Calls of the derivative, where the method counts them.
    pub evaluations: u64,
    /// Largest error of a step that was kept: in the unit of the state (adaptive Euler) or of the tolerance (DOPRI5).
    pub error_max: f64,
    /// Shortest step that was kept, s.
    pub dt_shortest: f64,
    /// Longest step that was kept, s.
    pub dt_longest: f64,
}

impl Report {
    fn accept(&mut self, dt: f64, error: f64) {
        self.dt_shortest = if self.steps == 0 { dt } else { min(self.dt_shortest, dt) };
        self.dt_longest = max(self.dt_longest, dt);
        self.error_max = max(self.error_max, error);
        self.steps += 1;
    }

    fn add(&mut self, o: &Self) {
        self.dt_shortest = if self.steps == 0 { o.dt_shortest } else { min(self.dt_shortest, o.dt_shortest) };
        self.dt_longest = max(self.dt_longest, o.dt_longest);
        self.error_max = max(self.error_max, o.error_max);
        self.steps += o.steps;
        self.rejected += o.rejected;
        self.forced += o.forced;
        self.evaluations += o.evaluations;
    }
}

/// A method with its memory.
///
/// ```
/// use jounce_motion::integrate::{Integrator, Method};
/// // A ball of 1 kg on a spring of 1 N/m, by the slide's RK4, for one period of 2π s.
/// let mut rk4 = Integrator::<f64>::new(Method::Rk4);
/// let (mut x, mut v) = (1.0, 0.0);
/// let dt = std::f64::consts::TAU / 100.0;
/// for n in 0..100 {
///     rk4.step_point(f64::from(n) * dt, dt, &mut x, &mut v, |_t, x, _v| -x)?;
/// }
/// assert!((x - 1.0).abs() < 1e-5);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Integrator<V> {
    method: Method,
    options: Options,
    /// The state under way: y, or x and v one after the other. The caller's is written when all went well.
    y: Vec<V>,
    k: [Vec<V>; 8],
    newton: Newton<V>,
    dopri5: Dopri5<V>,
    /// Step that an adaptive method wants next; 0: not known.
    dt_next: f64,
}

impl<V: Vector> Integrator<V> {
    /// A method with default options.
    pub fn new(method: Method) -> Self {
        Self { method, ..Self::default() }
    }

    /// A method with options.
    ///
    /// # Errors
    /// [`Error::BadValue`] for options out of range.
    pub fn with_options(method: Method, options: Options) -> Result<Self> {
        Ok(Self { method, options: options.checked()?, ..Self::default() })
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The options.
    pub fn options(&self) -> Options {
        self.options
    }

    /// The step that an adaptive method would try next, s; 0 where it has none yet.
    pub fn dt_next(&self) -> f64 {
        self.dt_next
    }

    /// Takes y′ = f(t, y) from `t` over `dt`, in s. `f(t, y, dy)` fills `dy`.
    ///
    /// Adaptive methods take as many steps within `dt` as they need; `dt` may be negative for all the others.
    ///
    /// ```
    /// use jounce_motion::integrate::{Integrator, Method};
    /// // Decay: y′ = −y.
    /// let mut y = [1.0];
    /// Integrator::new(Method::AdaptiveDopri5).step(0.0, 1.0, &mut y, |_t, y, dy| dy[0] = -y[0])?;
    /// assert!((y[0] - (-1.0f64).exp()).abs() < 1e-9);
    /// # Ok::<(), jounce_motion::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::BadValue`] for a bad time or state, [`Error::Unsupported`] for a method that needs positions and
    /// velocities, [`Error::Failed`] where the result would not be finite. `y` is then as it was.
    pub fn step(
        &mut self,
        t: f64,
        dt: f64,
        y: &mut [V],
        mut f: impl FnMut(f64, &[V], &mut [V]),
    ) -> Result<Report> {
        self.check_time(t, dt)?;
        if matches!(self.method, Method::SemiImplicitEuler | Method::VelocityVerlet) {
            return Err(Error::Unsupported {
                what: "integrator",
                advice: "this method needs positions and velocities: call step_motion, or choose another",
            });
        }
        self.load(&[&*y])?;
        let report = self.first_order(t, dt, 0..y.len(), &mut f)?;
        self.finish(t + dt)?;
        y.copy_from_slice(&self.y);
        Ok(report)
    }

    /// Takes x″ = a(t, x, v) from `t` over `dt`, in s. `a(t, x, v, out)` fills `out` with the accelerations.
    ///
    /// ```
    /// use jounce_math::DVec3;
    /// use jounce_motion::integrate::{Integrator, Method};
    /// // Two balls fall; one of them through treacle.
    /// let mut x = [DVec3::ZERO; 2];
    /// let mut v = [DVec3::ZERO; 2];
    /// let mut method = Integrator::new(Method::Midpoint);
    /// method.step_motion(0.0, 0.01, &mut x, &mut v, |_t, _x, v, a| {
    ///     a[0] = DVec3::Y * -9.81;
    ///     a[1] = DVec3::Y * -9.81 - v[1] * 5.0;
    /// })?;
    /// assert!(v[0].y < v[1].y && v[1].y < 0.0);
    /// # Ok::<(), jounce_motion::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::BadValue`] for a bad time or state or columns of two lengths, [`Error::Failed`] where the result would
    /// not be finite or an implicit step finds no answer. `x` and `v` are then as they were.
    pub fn step_motion(
        &mut self,
        t: f64,
        dt: f64,
        x: &mut [V],
        v: &mut [V],
        mut a: impl FnMut(f64, &[V], &[V], &mut [V]),
    ) -> Result<Report> {
        self.check_time(t, dt)?;
        let n = x.len();
        check(v.len() == n, "integrator", "velocities", v.len(), "as many velocities as positions")?;
        self.load(&[&*x, &*v])?;
        let report = {
            let (xs, vs) = self.y.split_at_mut(n);
            match self.method {
                Method::LectureLoop => {
                    fixed::lecture_loop(t, dt, xs, vs, &mut self.k[0][..n], &mut a);
                    one(dt, 1)
                }
                Method::SemiImplicitEuler => {
                    fixed::semi_implicit_euler(t, dt, xs, vs, &mut self.k[0][..n], &mut a);
                    one(dt, 1)
                }
                Method::VelocityVerlet => {
                    fixed::velocity_verlet(t, dt, xs, vs, &mut self.k, &mut a);
                    one(dt, 2)
                }
                Method::ImplicitEuler => self.implicit_motion(t, dt, n, &mut a)?,
                _ => {
                    let measured = match self.options.measure {
                        Measure::Velocity => n..2 * n,
                        Measure::State => 0..2 * n,
                    };
                    self.first_order(t, dt, measured, &mut |t: f64, y: &[V], dy: &mut [V]| {
                        let (x, v) = y.split_at(n);
                        let (dx, dv) = dy.split_at_mut(n);
                        dx.copy_from_slice(v);
                        a(t, x, v, dv);
                    })?
                }
            }
        };
        self.finish(t + dt)?;
        x.copy_from_slice(&self.y[..n]);
        v.copy_from_slice(&self.y[n..]);
        Ok(report)
    }

    /// The same for one point: `a(t, x, v)` gives its acceleration. With [`Method::Rk4`] this is the slide's
    /// `RK4Integration(pos, vel, t, dt)`.
    ///
    /// # Errors
    /// As [`Self::step_motion`].
    pub fn step_point(
        &mut self,
        t: f64,
        dt: f64,
        x: &mut V,
        v: &mut V,
        mut a: impl FnMut(f64, V, V) -> V,
    ) -> Result<Report> {
        let (x, v) = (core::slice::from_mut(x), core::slice::from_mut(v));
        self.step_motion(t, dt, x, v, |t, x, v, out| out[0] = a(t, x[0], v[0]))
    }

    fn check_time(&self, t: f64, dt: f64) -> Result<()> {
        let (what, adaptive) = ("integrator", self.method.is_adaptive());
        check((t + dt).is_finite(), what, "dt", dt, "a finite time and a finite step")?;
        check(!adaptive || dt > 0.0, what, "dt", dt, "more than 0 for a method that chooses its own steps")
    }

    fn load(&mut self, parts: &[&[V]]) -> Result<()> {
        let good = parts.iter().all(|p| p.iter().all(|y| y.is_finite()));
        check(good, "integrator", "state", "not finite", "finite positions and velocities")?;
        self.y.clear();
        for p in parts {
            self.y.extend_from_slice(p);
        }
        for k in &mut self.k {
            k.resize(self.y.len(), V::default());
        }
        Ok(())
    }

    fn finish(&self, t: f64) -> Result<()> {
        if self.y.iter().all(|y| y.is_finite()) { Ok(()) } else { Err(adaptive::not_finite(t)) }
    }

    fn first_order(
        &mut self,
        t: f64,
        dt: f64,
        measured: Range<usize>,
        f: &mut impl FnMut(f64, &[V], &mut [V]),
    ) -> Result<Report> {
        let (y, k) = (&mut self.y, &mut self.k);
        match self.method {
            Method::Midpoint => {
                fixed::midpoint(t, dt, y, k, f);
                Ok(one(dt, 2))
            }
            Method::Rk4 => {
                fixed::rk4(t, dt, y, k, f);
                Ok(one(dt, 4))
            }
            Method::Dopri5 => {
                dopri5::fixed_step(t, dt, y, k, f);
                Ok(one(dt, 7))
            }
            Method::AdaptiveEuler => {
                adaptive::adaptive_euler(t, dt, y, measured, &self.options, &mut self.dt_next, k, f)
            }
            Method::AdaptiveDopri5 => self.whole_dopri5(t, dt, f),
            Method::ImplicitEuler => {
                let (newton, tolerance) = (&mut self.newton, self.options.newton_tolerance);
                implicit_parts(t, dt, |t, h, calls| {
                    let y0 = &mut k[0];
                    y0.copy_from_slice(y);
                    let found = newton.solve(y, y0, h, tolerance, 0.0, &mut |u: &[V], out: &mut [V]| {
                        *calls += 1;
                        f(t + h, u, out);
                    });
                    if !found {
                        y.copy_from_slice(y0);
                    }
                    found
                })
            }
            Method::ExplicitEuler
            | Method::LectureLoop
            | Method::SemiImplicitEuler
            | Method::VelocityVerlet => {
                fixed::euler(t, dt, y, &mut k[0], f);
                Ok(one(dt, 1))
            }
        }
    }

    /// v′ = v + h a(t + h, x + h v′, v′), x′ = x + h v′: half as many unknowns as (x, v).
    fn implicit_motion(
        &mut self,
        t: f64,
        dt: f64,
        n: usize,
        a: &mut impl FnMut(f64, &[V], &[V], &mut [V]),
    ) -> Result<Report> {
        let [v0, moved, ..] = &mut self.k;
        let (x, v) = self.y.split_at_mut(n);
        let (v0, moved) = (&mut v0[..n], &mut moved[..n]);
        let (newton, tolerance) = (&mut self.newton, self.options.newton_tolerance);
        implicit_parts(t, dt, |t, h, calls| {
            v0.copy_from_slice(v);
            // Near rest, forces are differences of large ones, and their rounding is no fault of the answer: an error of
            // the velocities that moves nothing by more than 1e-10 of where it is.
            let floor = 1e-10 * implicit::norm(x) / h.abs();
            let found = newton.solve(v, v0, h, tolerance, floor, &mut |u: &[V], out: &mut [V]| {
                *calls += 1;
                fixed::sum_scaled(moved, x, h, u);
                a(t + h, moved, u, out);
            });
            if found {
                fixed::add_scaled(x, h, v);
            } else {
                v.copy_from_slice(v0);
            }
            found
        })
    }

    fn whole_dopri5(&mut self, t: f64, dt: f64, f: &mut impl FnMut(f64, &[V], &mut [V])) -> Result<Report> {
        self.dopri5.prepare(self.options, self.dt_next);
        self.dopri5.restart(t, &self.y)?;
        let mut report = Report::default();
        while self.dopri5.time() < t + dt {
            report.add(&self.dopri5.step(t + dt, f)?);
            if report.steps as usize >= limits::STEPS_MAX {
                return Err(Error::Failed {
                    what: "adaptive_dopri5",
                    time: self.dopri5.time(),
                    advice: adaptive::TOO_MANY,
                });
            }
        }
        self.dt_next = self.dopri5.dt_next();
        self.y.copy_from_slice(self.dopri5.state());
        Ok(report)
    }
}

fn one(dt: f64, evaluations: u64) -> Report {
    Report { steps: 1, evaluations, dt_shortest: dt, dt_longest: dt, ..Report::default() }
}

/// Takes `dt` in one implicit step, or, where Newton's iteration finds no answer (a mesh that was folded or pushed hard
/// since the last step), in as many equal parts as it takes: the shorter the step, the nearer is the guess. `solve(t, h)`
/// takes one part, or changes nothing and says so.
fn implicit_parts(t: f64, dt: f64, mut solve: impl FnMut(f64, f64, &mut u64) -> bool) -> Result<Report> {
    let mut report = Report::default();
    let (mut parts, mut done) = (1u32, 0u32);
    while done < parts {
        let h = dt / f64::from(parts);
        if solve(t + h * f64::from(done), h, &mut report.evaluations) {
            report.accept(h, 0.0);
            done += 1;
        } else if parts < limits::IMPLICIT_PARTS_MAX {
            report.rejected += 1;
            (parts, done) = (2 * parts, 2 * done);
        } else {
            let time = t + h * f64::from(done);
            let advice = "Newton's iteration finds no answer; shorten dt, or loosen newton_tolerance";
            return Err(Error::Failed { what: "implicit_euler", time, advice });
        }
    }
    Ok(report)
}
