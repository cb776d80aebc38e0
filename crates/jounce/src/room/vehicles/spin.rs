//! Turning parts: the engine and the wheels, and what couples them.
//!
//! Symbols: x = (Ω_engine, Ω_1 … Ω_n) relative to the chassis, M their inertias (diagonal), c a coupling's row, τ impulses (N m s).
//!
//! A coupling holds c·x = target with an impulse of at most cap: the clutch holds the engine to the gearbox, a locked differential its two
//! wheels to each other, a track all of its wheels, a brake (and the rolling resistance) a wheel to the chassis. Those that hold are
//! solved directly, all at once:
//!
//! S λ = target − C (x + M⁻¹ τ),  S = C M⁻¹ Cᵀ,  x′ = x + M⁻¹ (τ + Cᵀ λ);
//!
//! those that slip push with their cap against the slip. One that would not stop within its cap slips, and so does one that would need
//! more than its cap to hold, with the tyres' impulses of the last substep: the set of those that hold is found by letting go, round by
//! round. So clutch, brakes and differentials stick and slide as Coulomb's law has it, and a stiff drive-line has no
//! spring to blow up. The tyres come after with the inverse inertia B = M⁻¹ − M⁻¹ Cᵀ S⁻¹ C M⁻¹ of what holds together: a wheel in gear
//! feels the engine's inertia.
//!
//! Redundant couplings (all wheels braked and the differential locked) have pivots of zero and get nothing.

use jounce_math::scalar::f64s;

/// A pivot below this share of its diagonal is redundant.
const PIVOT_MIN: f64 = 1e-9;

/// What a coupling is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Clutch,
    Axle(usize),
    Center,
    Track,
    TrackSteer,
    Brake(usize),
}

/// Couplings and turning parts of a vehicle in a step. Memory, not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spin {
    /// Parts: engine (if any turns, else of infinite inertia) and wheels.
    pub n: usize,
    pub inv: Vec<f64>,
    pub parts: Vec<Part>,
    /// c, row by row.
    rows: Vec<f64>,
    pub target: Vec<f64>,
    /// Most impulse in a substep.
    pub cap: Vec<f64>,
    /// Which hold, as they were when factored.
    held: Vec<bool>,
    active: Vec<usize>,
    /// L and D of S, by active coupling.
    l: Vec<f64>,
    d: Vec<f64>,
    lambda: Vec<f64>,
    /// By coupling, over the substep.
    pub total: Vec<f64>,
    /// Σ_j |B_ij|.
    pub response: Vec<f64>,
    pub x: Vec<f64>,
    pub tau: Vec<f64>,
    column: Vec<f64>,
    spare: Vec<Vec<f64>>,
}

impl Spin {
    /// Starts a step with `n` parts.
    pub fn begin(&mut self, n: usize) {
        self.n = n;
        self.inv.clear();
        self.parts.clear();
        self.rows.clear();
        self.target.clear();
        self.held.clear();
        self.active.clear();
        for list in [&mut self.x, &mut self.tau, &mut self.response, &mut self.column] {
            list.clear();
            list.resize(n, 0.0);
        }
    }
    /// Adds a coupling with these coefficients.
    pub fn couple(&mut self, part: Part, target: f64, coefficients: &[(usize, f64)]) {
        let at = self.rows.len();
        self.rows.resize(at + self.n, 0.0);
        for &(i, c) in coefficients {
            self.rows[at + i] += c;
        }
        self.parts.push(part);
        self.target.push(target);
    }
    /// Adds to a coefficient of the last coupling.
    pub fn extend(&mut self, i: usize, c: f64) {
        let at = self.rows.len() - self.n;
        self.rows[at + i] += c;
    }
    /// After the last coupling.
    pub fn ready(&mut self) {
        let m = self.parts.len();
        for list in [&mut self.cap, &mut self.total, &mut self.lambda] {
            list.clear();
            list.resize(m, 0.0);
        }
    }
    fn row(&self, k: usize) -> &[f64] {
        &self.rows[k * self.n..(k + 1) * self.n]
    }
    /// c M⁻¹ c′ᵀ.
    fn meets(&self, a: usize, b: usize) -> f64 {
        let mut sum = 0.0;
        for ((x, y), m) in self.row(a).iter().zip(self.row(b)).zip(&self.inv) {
            sum += x * y * m;
        }
        sum
    }
    fn along(&self, k: usize, x: &[f64]) -> f64 {
        self.row(k).iter().zip(x).map(|(c, x)| c * x).sum()
    }

    /// Engine's and brakes' part of a substep: `tau` are the impulses that are known, `ahead` those that the tyres will probably give.
    pub fn drive(&mut self, locked: &mut [bool], ahead: &[f64]) {
        let m = self.parts.len();
        for k in 0..m {
            let cap = self.cap[k];
            self.total[k] = 0.0;
            if cap <= 0.0 {
                locked[k] = false;
                continue;
            }
            if locked[k] {
                continue;
            }
            let own = self.meets(k, k);
            if own <= 0.0 {
                continue;
            }
            let mut speed = -self.target[k];
            for (i, c) in self.row(k).iter().enumerate() {
                speed += c * (self.x[i] + self.inv[i] * (self.tau[i] + ahead[i]));
            }
            let need = -speed / own;
            if need.abs() <= cap {
                locked[k] = true;
                continue;
            }
            let push = if need > 0.0 { cap } else { -cap };
            self.total[k] = push;
            for i in 0..self.n {
                self.tau[i] += self.rows[k * self.n + i] * push;
            }
        }
        // At least one lets go in each round.
        for _ in 0..=m {
            if self.held != *locked {
                self.factor(locked);
            }
            if !self.let_go(locked, ahead) {
                break;
            }
        }
        for i in 0..self.n {
            self.x[i] += self.inv[i] * self.tau[i];
        }
        self.hold();
    }

    /// Lets go of couplings that would have to hold more than they can; did any?
    fn let_go(&mut self, locked: &mut [bool], ahead: &[f64]) -> bool {
        if !self.active.iter().any(|&k| self.cap[k] < f64::INFINITY) {
            return false;
        }
        self.column.clear();
        self.column.extend_from_slice(&self.x);
        for i in 0..self.n {
            self.x[i] += self.inv[i] * (self.tau[i] + ahead[i]);
        }
        self.multipliers();
        core::mem::swap(&mut self.x, &mut self.column);
        let mut any = false;
        for a in 0..self.active.len() {
            let (k, push) = (self.active[a], self.lambda[a]);
            if push.abs() <= self.cap[k] {
                continue;
            }
            any = true;
            locked[k] = false;
            let push = if push > 0.0 { self.cap[k] } else { -self.cap[k] };
            self.total[k] = push;
            for i in 0..self.n {
                self.tau[i] += self.rows[k * self.n + i] * push;
            }
        }
        any
    }

    /// The tyres' impulses in `tau`; then who lets go.
    pub fn roll(&mut self, locked: &mut [bool]) {
        for i in 0..self.n {
            self.x[i] += self.inv[i] * self.tau[i];
        }
        self.hold();
        for (k, locked) in locked.iter_mut().enumerate() {
            if *locked && self.total[k].abs() > self.cap[k] {
                *locked = false;
            }
        }
    }

    /// Puts `x` where the couplings that hold want it.
    fn hold(&mut self) {
        self.multipliers();
        for a in 0..self.active.len() {
            let (k, push) = (self.active[a], self.lambda[a]);
            self.total[k] += push;
            for i in 0..self.n {
                self.x[i] += self.inv[i] * self.rows[k * self.n + i] * push;
            }
        }
    }

    /// λ of those that hold, for `x` as it is.
    fn multipliers(&mut self) {
        let m = self.active.len();
        for a in 0..m {
            let k = self.active[a];
            let mut sum = self.target[k] - self.along(k, &self.x);
            for b in 0..a {
                sum -= self.l[a * m + b] * self.lambda[b];
            }
            self.lambda[a] = sum;
        }
        for a in (0..m).rev() {
            let mut sum = if self.d[a] > 0.0 { self.lambda[a] / self.d[a] } else { 0.0 };
            for b in a + 1..m {
                sum -= self.l[b * m + a] * self.lambda[b];
            }
            self.lambda[a] = if self.d[a] > 0.0 { sum } else { 0.0 };
        }
    }

    fn factor(&mut self, locked: &[bool]) {
        self.held.clear();
        self.held.extend_from_slice(locked);
        self.active.clear();
        self.active.extend((0..locked.len()).filter(|&k| locked[k]));
        let m = self.active.len();
        self.l.clear();
        self.l.resize(m * m, 0.0);
        self.d.clear();
        self.d.resize(m, 0.0);
        for a in 0..m {
            let whole = self.meets(self.active[a], self.active[a]);
            let mut pivot = whole;
            for b in 0..a {
                let mut sum = self.meets(self.active[a], self.active[b]);
                for c in 0..b {
                    sum -= self.l[a * m + c] * self.l[b * m + c] * self.d[c];
                }
                self.l[a * m + b] = if self.d[b] > 0.0 { sum / self.d[b] } else { 0.0 };
                pivot -= self.l[a * m + b] * self.l[a * m + b] * self.d[b];
            }
            self.d[a] = if pivot > PIVOT_MIN * whole { pivot } else { 0.0 };
        }
        self.respond();
    }

    /// Σ_j |B_ij|: what a wheel's tyre may count on, with all that it is coupled to pulling at once.
    fn respond(&mut self) {
        // Into memory that stays: a step allocates nothing.
        let m = self.parts.len();
        self.spare.resize_with(3, Vec::new);
        let now = [&mut self.x, &mut self.target, &mut self.total];
        for (kept, now) in self.spare.iter_mut().zip(now) {
            core::mem::swap(kept, now);
        }
        for (list, len) in [(&mut self.x, self.n), (&mut self.target, m), (&mut self.total, m)] {
            list.clear();
            list.resize(len, 0.0);
        }
        for i in 0..self.n {
            self.column.clear();
            self.column.resize(self.n, 0.0);
            core::mem::swap(&mut self.x, &mut self.column);
            self.x[i] = self.inv[i];
            self.hold();
            let mut sum = 0.0;
            for (j, x) in self.x.iter().enumerate() {
                if j > 0 {
                    sum += x.abs();
                }
            }
            core::mem::swap(&mut self.x, &mut self.column);
            self.response[i] = f64s::max(sum, 0.0);
        }
        let now = [&mut self.x, &mut self.target, &mut self.total];
        for (kept, now) in self.spare.iter_mut().zip(now) {
            core::mem::swap(kept, now);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Engine 0.2 kg m², two wheels of 1 kg m², ratio 8 by a differential.
    fn car(kind_cap: f64) -> Spin {
        let mut s = Spin::default();
        s.begin(3);
        s.inv.extend([5.0, 1.0, 1.0]);
        s.couple(Part::Clutch, 0.0, &[(0, 1.0), (1, -4.0), (2, -4.0)]);
        s.couple(Part::Axle(0), 0.0, &[(1, 1.0), (2, -1.0)]);
        s.ready();
        s.cap.copy_from_slice(&[f64::INFINITY, kind_cap]);
        s
    }

    #[test]
    fn in_gear_the_engine_s_inertia_is_on_the_wheels() {
        let mut s = car(0.0);
        let mut locked = [true, false];
        s.tau[0] = 1.0;
        s.drive(&mut locked, &[0.0; 3]);
        // 1 N m s on 0.2 + 2·1/8² kg m² at the crank.
        let want = 1.0 / (0.2 + 2.0 / 64.0);
        assert!((s.x[0] - want).abs() < 1e-9, "{:?}", s.x);
        assert!((s.x[1] - want / 8.0).abs() < 1e-9 && (s.x[1] - s.x[2]).abs() < 1e-12);
    }

    #[test]
    fn an_open_differential_shares_torque_and_a_locked_one_speed() {
        for (cap, open) in [(0.0, true), (1e9, false)] {
            let mut s = car(cap);
            let mut locked = [true, !open];
            s.drive(&mut locked, &[0.0; 3]);
            s.tau.iter_mut().for_each(|t| *t = 0.0);
            // One wheel is held back by the road.
            s.tau[1] = -1.0;
            s.roll(&mut locked);
            if open {
                assert!(s.x[2] > 0.0, "the other one speeds up: {:?}", s.x);
            } else {
                assert!((s.x[1] - s.x[2]).abs() < 1e-12, "{:?}", s.x);
            }
            assert!((s.x[0] - 4.0 * (s.x[1] + s.x[2])).abs() < 1e-9);
        }
    }

    #[test]
    fn a_weak_coupling_slips_with_its_cap() {
        let mut s = car(0.25);
        let mut locked = [false, false];
        s.cap[0] = 0.0;
        (s.x[1], s.x[2]) = (3.0, 1.0);
        s.drive(&mut locked, &[0.0; 3]);
        assert!((s.x[1] - 2.75).abs() < 1e-12 && (s.x[2] - 1.25).abs() < 1e-12, "{:?}", s.x);
        assert!(!locked[1]);
    }

    #[test]
    fn many_weak_brakes_on_one_track_let_go_together() {
        let mut s = Spin::default();
        s.begin(4);
        s.inv.extend([0.0, 1.0, 1.0, 1.0]);
        s.couple(Part::Track, 0.0, &[(1, 1.0), (2, -1.0)]);
        s.couple(Part::Track, 0.0, &[(2, 1.0), (3, -1.0)]);
        (0..3).for_each(|i| s.couple(Part::Brake(i), 0.0, &[(i + 1, 1.0)]));
        s.ready();
        s.cap.copy_from_slice(&[f64::INFINITY, f64::INFINITY, 1.0, 1.0, 1.0]);
        let mut locked = [true; 5];
        s.tau[1] = 6.0;
        s.drive(&mut locked, &[0.0; 4]);
        // 6 − 3 N m s on 3 kg m².
        assert!(s.x[1..].iter().all(|x| (x - 1.0).abs() < 1e-9), "{:?}", s.x);
    }

    #[test]
    fn redundant_couplings_hold_together() {
        let mut s = Spin::default();
        s.begin(3);
        s.inv.extend([0.0, 1.0, 1.0]);
        s.couple(Part::Brake(0), 0.0, &[(1, 1.0)]);
        s.couple(Part::Brake(1), 0.0, &[(2, 1.0)]);
        s.couple(Part::Axle(0), 0.0, &[(1, 1.0), (2, -1.0)]);
        s.ready();
        s.cap.copy_from_slice(&[1e9; 3]);
        let mut locked = [true; 3];
        (s.x[1], s.x[2]) = (3.0, -1.0);
        s.drive(&mut locked, &[0.0; 3]);
        assert!(s.x.iter().all(|x| x.abs() < 1e-12), "{:?}", s.x);
        assert!(s.response[1].abs() < 1e-9);
    }
}
