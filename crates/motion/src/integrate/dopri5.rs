//! Dormand and Prince's method of order 5 with an embedded one of order 4, and a state between the steps.
//!
//! Seven slopes kᵢ = f(t + cᵢ h, y + h Σ aᵢⱼ kⱼ), the last of which is the first of the next step. y₅ = y + h Σ bᵢ kᵢ,
//! err = h Σ eᵢ kᵢ. With sc = atol + rtol max(|y|, |y₅|) and E the root mean square of err/sc, a step with E ≤ 1 is
//! kept, and the next one is S E^{−1/5} h, within 0.2 to 5 times h.
//! Between the steps, θ = (t − t₀)/h and y(θ) = r₁ + θ (r₂ + (1−θ)(r₃ + θ (r₄ + (1−θ) r₅))), of order 4.
//!
//! Source: J. R. Dormand and P. J. Prince, J. Comput. Appl. Math. 6 (1980); E. Hairer, S. P. Nørsett and G. Wanner,
//! *Solving Ordinary Differential Equations I*, II.4–II.6 (`dopri5.f` for the dense output).

use super::adaptive::{TOO_MANY, not_finite};
use super::{Options, Report, Vector};
use crate::error::{Error, Result, check, finite};
use crate::limits::STEPS_MAX;
use jounce_math::scalar::f64s::{clamp, max, pow};

const C: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
const A: [[f64; 6]; 7] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// b of order 5 less b of order 4.
const E: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];
/// Dense output.
const D: [f64; 7] = [
    -12715105075.0 / 11282082432.0,
    0.0,
    87487479700.0 / 32700410799.0,
    -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0,
    -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0,
];

/// The seven slopes of a step; k₁ is there already. `out` is the new state, k₇ its slope.
pub(super) fn stages<V: Vector>(
    t: f64,
    h: f64,
    y: &[V],
    out: &mut [V],
    k: &mut [Vec<V>],
    f: &mut impl FnMut(f64, &[V], &mut [V]),
) {
    for stage in 1..7 {
        for i in 0..y.len() {
            let mut sum = V::default();
            for (j, &a) in A[stage].iter().enumerate().take(stage) {
                if a != 0.0 {
                    sum = sum + k[j][i] * a;
                }
            }
            out[i] = y[i] + sum * h;
        }
        f(t + C[stage] * h, out, &mut k[stage]);
    }
}

/// Σ wᵢ kᵢ of one component.
fn weighted<V: Vector>(w: &[f64; 7], k: &[Vec<V>], i: usize) -> V {
    let mut sum = V::default();
    for (w, k) in w.iter().zip(k) {
        if *w != 0.0 {
            sum = sum + k[i] * *w;
        }
    }
    sum
}

/// The solver with its own choice of steps.
///
/// ```
/// use jounce_motion::integrate::{Dopri5, Options};
/// // A harmonic oscillator, y = (x, v): after a period it is back, and half-way it is opposite.
/// let mut f = |_t: f64, y: &[f64], dy: &mut [f64]| (dy[0], dy[1]) = (y[1], -y[0]);
/// let mut solver = Dopri5::new(0.0, &[1.0, 0.0], Options::default())?;
/// let period = std::f64::consts::TAU;
/// while solver.time() < period {
///     solver.step(period, &mut f)?;
/// }
/// assert!((solver.state()[0] - 1.0).abs() < 1e-8);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Dopri5<V> {
    options: Options,
    t: f64,
    t_before: f64,
    /// Step to try next; 0: not known yet.
    next: f64,
    y: Vec<V>,
    fresh: Vec<V>,
    k: [Vec<V>; 7],
    dense: [Vec<V>; 5],
    /// k₁ is the slope at (t, y).
    slope_known: bool,
}

impl<V: Vector> Dopri5<V> {
    /// A solver at state `y` and time `t` in s.
    ///
    /// # Errors
    /// [`Error::BadValue`] for a state, a time or options that are not usable.
    pub fn new(t: f64, y: &[V], options: Options) -> Result<Self> {
        let mut solver = Self { options: options.checked()?, ..Self::default() };
        solver.restart(t, y)?;
        Ok(solver)
    }

    /// Begins again elsewhere, keeping the memory and the length of step: after an event such as a bounce.
    ///
    /// # Errors
    /// [`Error::BadValue`] for a state or a time that is not finite.
    pub fn restart(&mut self, t: f64, y: &[V]) -> Result<()> {
        finite("dopri5", "time", t)?;
        check(y.iter().all(|y| y.is_finite()), "dopri5", "state", "not finite", "finite components")?;
        (self.t, self.t_before, self.slope_known) = (t, t, false);
        let columns = [&mut self.y, &mut self.fresh].into_iter().chain(&mut self.k).chain(&mut self.dense);
        for c in columns {
            c.resize(y.len(), V::default());
        }
        self.y.copy_from_slice(y);
        self.dense[0].copy_from_slice(y);
        for d in &mut self.dense[1..] {
            d.fill(V::default());
        }
        Ok(())
    }

    /// Time that was reached, s.
    pub fn time(&self) -> f64 {
        self.t
    }

    /// Time at which the last step began, s.
    pub fn time_before(&self) -> f64 {
        self.t_before
    }

    /// State at [`Self::time`].
    pub fn state(&self) -> &[V] {
        &self.y
    }

    /// State at any time of the last step, s, to fourth order. A time outside is taken as the nearer end.
    pub fn state_at(&self, t: f64, out: &mut [V]) {
        let h = self.t - self.t_before;
        let s = if h != 0.0 { clamp((t - self.t_before) / h, 0.0, 1.0) } else { 0.0 };
        for (i, out) in out.iter_mut().enumerate().take(self.y.len()) {
            *out = dense_point(&self.dense, i, s);
        }
    }

    /// The polynomial of the last step: r₁ … r₅ of component `i`.
    pub(crate) fn dense_of(&self, i: usize) -> [V; 5] {
        [0, 1, 2, 3, 4].map(|r| self.dense[r].get(i).copied().unwrap_or_default())
    }

    /// One step that is accepted, and that ends at `t_end` at the latest. Nothing happens at or beyond `t_end`.
    ///
    /// # Errors
    /// [`Error::Failed`] where the slope is not finite however short the step; the state stays as it was.
    pub fn step(&mut self, t_end: f64, f: &mut impl FnMut(f64, &[V], &mut [V])) -> Result<Report> {
        finite("dopri5", "t_end", t_end)?;
        let mut report = Report::default();
        if t_end <= self.t {
            return Ok(report);
        }
        let o = self.options;
        if !self.slope_known {
            f(self.t, &self.y, &mut self.k[0]);
            report.evaluations += 1;
        }
        if self.next <= 0.0 {
            self.next = self.first_step(t_end);
        }
        for _ in 0..STEPS_MAX {
            let wanted = clamp(self.next, o.dt_min, o.dt_max);
            let last = wanted >= t_end - self.t;
            let h = if last { t_end - self.t } else { wanted };
            stages(self.t, h, &self.y, &mut self.fresh, &mut self.k, f);
            report.evaluations += 6;
            let e = self.error(h);
            // The smallest step that still moves the time.
            let floor = max(o.dt_min, 4.0 * f64::EPSILON * self.t.abs());
            if e <= 1.0 || (h <= floor && e.is_finite()) {
                report.accept(h, e);
                report.forced += u64::from(e > 1.0);
                let factor = if e > 0.0 { clamp(o.safety * pow(e, -0.2), 0.2, 5.0) } else { 5.0 };
                // A step cut short by the end says nothing against the longer one that was wanted.
                self.next = if last { max(wanted, factor * h) } else { factor * h };
                self.accept(h, if last { t_end } else { self.t + h });
                return Ok(report);
            }
            if h <= floor || h <= f64::MIN_POSITIVE {
                return Err(not_finite(self.t));
            }
            report.rejected += 1;
            let factor = if e.is_finite() { clamp(o.safety * pow(e, -0.2), 0.1, 0.9) } else { 0.1 };
            self.next = max(factor * h, floor);
        }
        Err(Error::Failed { what: "dopri5", time: self.t, advice: TOO_MANY })
    }

    /// A first step of which the slope changes the state by a hundredth of its scale.
    fn first_step(&self, t_end: f64) -> f64 {
        let o = &self.options;
        let (mut state, mut slope) = (0.0, 0.0);
        for (y, k) in self.y.iter().zip(&self.k[0]) {
            let sc = o.absolute_tolerance + o.relative_tolerance * y.dot(*y).sqrt();
            state += y.dot(*y) / (sc * sc);
            slope += k.dot(*k) / (sc * sc);
        }
        let h = 0.01 * (state / slope).sqrt();
        if h > 0.0 && h < t_end - self.t { h } else { 0.01 * (t_end - self.t) }
    }

    /// E: the root mean square of err/sc.
    fn error(&self, h: f64) -> f64 {
        let o = &self.options;
        let mut sum = 0.0;
        for i in 0..self.y.len() {
            let e = weighted(&E, &self.k, i) * h;
            let size = max(self.y[i].dot(self.y[i]), self.fresh[i].dot(self.fresh[i])).sqrt();
            let sc = o.absolute_tolerance + o.relative_tolerance * size;
            sum += e.dot(e) / (sc * sc);
        }
        if self.y.is_empty() { 0.0 } else { (sum / self.y.len() as f64).sqrt() }
    }

    fn accept(&mut self, h: f64, t: f64) {
        for i in 0..self.y.len() {
            let change = self.fresh[i] - self.y[i];
            let bend = self.k[0][i] * h - change;
            self.dense[0][i] = self.y[i];
            self.dense[1][i] = change;
            self.dense[2][i] = bend;
            self.dense[3][i] = change - self.k[6][i] * h - bend;
            self.dense[4][i] = weighted(&D, &self.k, i) * h;
        }
        (self.t_before, self.t) = (self.t, t);
        core::mem::swap(&mut self.y, &mut self.fresh);
        self.k.swap(0, 6);
        self.slope_known = true;
    }

    /// Step that would be tried next, s; 0: not known yet.
    pub fn dt_next(&self) -> f64 {
        self.next
    }

    /// Other options and a step to try, before a restart.
    pub(super) fn prepare(&mut self, options: Options, next: f64) {
        (self.options, self.next) = (options, next);
    }
}

/// y(θ) of component `i`.
fn dense_point<V: Vector>(r: &[Vec<V>; 5], i: usize, s: f64) -> V {
    dense_value(&[r[0][i], r[1][i], r[2][i], r[3][i], r[4][i]], s)
}

/// y(θ) of one polynomial.
pub(crate) fn dense_value<V: Vector>(r: &[V; 5], s: f64) -> V {
    let u = 1.0 - s;
    r[0] + (r[1] + (r[2] + (r[3] + r[4] * u) * s) * u) * s
}

/// One step of the given length.
pub(super) fn fixed_step<V: Vector>(
    t: f64,
    h: f64,
    y: &mut [V],
    k: &mut [Vec<V>; 8],
    f: &mut impl FnMut(f64, &[V], &mut [V]),
) {
    let (slopes, fresh) = k.split_at_mut(7);
    f(t, y, &mut slopes[0]);
    stages(t, h, y, &mut fresh[0], slopes, f);
    y.copy_from_slice(&fresh[0]);
}
