//! Rows that do not hold by themselves: ends, motors, springs, friction.
//!
//! Springs. A row of effective mass m with the error C and speed v is pushed by λ = −m (a C + b v), once per substep. With
//! semi-implicit Euler, v ← v + λ/m, C ← C + h v, that is a linear map with determinant 1 − b and trace 2 − b − h a. A damped
//! oscillator of ω and ζ maps over h with determinant e^(−2ζωh) and trace 2 e^(−ζωh) cos(ωh √(1−ζ²)) (cosh where ζ > 1). Hence
//!
//! b = 1 − e^(−2ζωh), h a = 1 + e^(−2ζωh) − trace:
//!
//! the row swings with exactly its frequency and decay at any substep, where the usual implicit spring loses energy by ωh/2 a
//! radian. From ωh = ½ on, where several springs on one body could drive one another unstable, the implicit one is used
//! (Catto, Soft constraints, GDC 2011): b = s/(1 + s), a = b ω/(2ζ + hω), s = hω (2ζ + hω). A stiffness k and damper c are
//! ω² = k/m, 2ζω = c/m.
//!
//! Implicit springs in the direct solve. By the mass of the row alone, a stiff spring on a light limb would carry no more than that limb,
//! though a heavy body hangs on it. So there it is a row that yields: λ = −h (k (C + h v⁺) + c (v⁺ − v₀)), hence
//! v⁺ + γ λ + (k C − c v₀)/(h k + c) = 0 with the compliance γ = 1/(h (h k + c)).

use super::desc::{AxisDesc, LimitDesc, MotorTarget, SpringDesc};
use super::rows::Row;
use super::set::Constants;
use super::solve::TOUCH;
use jounce_math::{Vec3, scalar::f32s};

/// What a row is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Duty {
    /// The coordinate stays within.
    Limit(LimitDesc),
    /// Holds a speed with bounded force; also dry friction.
    Speed { speed: f32, max: f32 },
    /// Pulls to a coordinate with bounded force.
    Spring { rest: f32, velocity: f32, spring: SpringDesc, max: f32 },
}

impl Duty {
    pub fn motor(target: MotorTarget, max: f32) -> Self {
        match target {
            MotorTarget::Velocity(speed) => Self::Speed { speed, max },
            MotorTarget::Position { position, velocity, spring } => {
                Self::Spring { rest: position, velocity, spring, max }
            }
        }
    }
}

/// A row with a duty, and its impulse in this substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extra {
    pub row: Row,
    pub duty: Duty,
    /// M⁻¹ Jᵀ of the turns.
    pub ia: Vec3,
    pub ib: Vec3,
    pub mass: f32,
    pub impulse: f32,
    /// The same as the rounds of the active set begin.
    pub before: f32,
    /// What the coordinate after the substep will be beyond c + h J u.
    pub bend: f32,
    /// Holds in the direct solve.
    pub acts: bool,
    /// Did so in some round of the pass.
    pub tried: bool,
}

/// Collects the rows of a joint. Which there are depends on its description alone, so that their impulses keep their places.
pub(crate) struct Extras<'a> {
    pub list: &'a mut Vec<Extra>,
}

impl Extras<'_> {
    pub fn push(&mut self, row: Row, duty: Duty) {
        let (ia, ib) = (Vec3::ZERO, Vec3::ZERO);
        self.list.push(Extra {
            row,
            duty,
            ia,
            ib,
            mass: 0.0,
            impulse: 0.0,
            before: 0.0,
            bend: 0.0,
            acts: false,
            tried: false,
        });
    }
    /// All that an axis has; `row.c` is its coordinate.
    pub fn axis(&mut self, axis: &AxisDesc, row: Row) {
        if axis.locked {
            return;
        }
        if let Some((rest, spring)) = axis.spring {
            self.push(row, Duty::Spring { rest, velocity: 0.0, spring, max: f32::INFINITY });
        }
        // The direct solve drops the later of two rows that say the same: an end goes before what only brakes.
        if let Some(limit) = axis.limit {
            self.push(row, Duty::Limit(limit));
        }
        if let Some(m) = axis.motor {
            self.push(row, Duty::motor(m.target, m.max_force));
        }
        if axis.friction > 0.0 {
            self.push(row, Duty::Speed { speed: 0.0, max: axis.friction });
        }
    }
}

/// (a, b) of a spring on a row of effective mass `m`.
pub(crate) fn gains(spring: &SpringDesc, m: f32, h: f32) -> (f32, f32) {
    let (x, s) = match *spring {
        // ωh and ζωh.
        SpringDesc::Hertz { hertz, damping_ratio } => {
            let x = 2.0 * core::f32::consts::PI * hertz * h;
            (x, damping_ratio * x)
        }
        SpringDesc::Newton { stiffness, damping } => {
            if m <= 0.0 {
                return (0.0, 0.0);
            }
            (f32s::min((stiffness / m).sqrt() * h, 1e6), f32s::min(0.5 * damping * h / m, 1e6))
        }
    };
    if x > STIFF as f32 {
        let a1 = 2.0 * s / x + x;
        let a2 = x * a1;
        let b = a2 / (1.0 + a2);
        return (b * (x / a1) / h, b);
    }
    let decay = f32s::exp(-s);
    // 1 − e^(−2s) without cancellation for weak dampers.
    let b = if s < 1e-3 { 2.0 * s * (1.0 - s) } else { 1.0 - decay * decay };
    // 1 + E² − 2 E cos y = (1 − E)² + 2 E (1 − cos y), likewise.
    let y2 = x * x - s * s;
    let one_less = if s < 1e-3 { s * (1.0 - 0.5 * s) } else { 1.0 - decay };
    let bend = if y2 >= 0.0 {
        let half = f32s::sin(0.5 * y2.sqrt());
        4.0 * decay * half * half
    } else {
        let r = (-y2).sqrt();
        // E (cosh r − 1)·(−2), r < s.
        let (up, down) = (f32s::exp(0.5 * (r - s)), f32s::exp(-0.5 * (r + s)));
        -(up - down) * (up - down)
    };
    ((one_less * one_less + bend) / h, b)
}

/// ωh from which a spring is implicit.
const STIFF: f64 = 0.5;
/// Slip that is rounding, m/s or rad/s.
const SLOW: f32 = 1e-5;

/// Parts of their own diagonal that ends, and motors and friction, give way.
const END_COMPLIANCE: f64 = 1e-7;
const MOTOR_COMPLIANCE: f64 = 1e-5;

/// Which pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sweep {
    /// With springs, and ends that look ahead.
    Solve,
    /// Speeds alone.
    Relax,
    /// Places alone: a velocity is a way, and the substep lasts a second.
    Place,
}

/// Impulse that a row adds now, given its speed; `h` is the substep.
pub(crate) fn push(x: &mut Extra, speed: f32, sweep: Sweep, h: f32, push_out: f32) -> f32 {
    if x.mass <= 0.0 {
        return 0.0;
    }
    let old = x.impulse;
    match x.duty {
        Duty::Speed { speed: wanted, max } => {
            let most = max * h;
            x.impulse = f32s::clamp(old - x.mass * (speed - wanted), -most, most);
        }
        Duty::Spring { rest, velocity, spring, max } => {
            // Once per substep, with what the others have done by then.
            if sweep == Sweep::Relax || old != 0.0 {
                return 0.0;
            }
            let (a, b) = gains(&spring, x.mass, h);
            let most = max * h;
            x.impulse = f32s::clamp(-x.mass * (a * (x.row.c - rest) + b * (speed - velocity)), -most, most);
        }
        Duty::Limit(l) => {
            let (sign, gap) = x.end(&l);
            let toward = sign * speed;
            let pushed = sign * old;
            let new = match l.spring {
                Some(_) if sweep == Sweep::Relax => return 0.0,
                Some(spring) if gap < 0.0 => {
                    if old != 0.0 {
                        return 0.0;
                    }
                    let (a, b) = gains(&spring, x.mass, h);
                    f32s::max(-x.mass * (a * gap + b * toward), 0.0)
                }
                Some(_) => 0.0,
                None => {
                    let bias = if sweep == Sweep::Relax {
                        f32s::max(gap, 0.0) / h
                    } else if gap > 0.0 {
                        gap / h
                    } else {
                        f32s::max(0.2 * gap / h, -push_out)
                    };
                    f32s::max(pushed - x.mass * (toward + bias), 0.0)
                }
            };
            // Where the other end is the nearer one now, what this one pushed with goes.
            x.impulse = sign * new;
        }
    }
    x.impulse - old
}

impl Extra {
    /// Hard ends and motors after a speed hold while they can; springs and soft ends push once per substep and start afresh.
    pub fn may_hold(&self) -> bool {
        matches!(self.duty, Duty::Speed { .. } | Duty::Limit(LimitDesc { spring: None, .. }))
    }
    /// Which end is the nearer one (+1 the lower), and the gap to it.
    pub fn end(&self, l: &LimitDesc) -> (f32, f32) {
        let (low, high) = (self.row.c - l.min, l.max - self.row.c);
        if low < high { (1.0, low) } else { (-1.0, high) }
    }
    /// k and c of a spring that the row's own mass would swing on faster than substeps follow.
    fn stiff(&self, h: f32) -> Option<[f64; 2]> {
        let Duty::Spring { spring, .. } = &self.duty else { return None };
        let m = f64::from(self.mass);
        let [k, c] = match *spring {
            SpringDesc::Hertz { hertz, damping_ratio } => {
                let w = core::f64::consts::TAU * f64::from(hertz);
                [w * w * m, 2.0 * f64::from(damping_ratio) * w * m]
            }
            SpringDesc::Newton { stiffness, damping } => [f64::from(stiffness), f64::from(damping)],
        };
        let h = f64::from(h);
        (m > 0.0 && h * h * k > STIFF * STIFF * m).then_some([k, c])
    }
    /// Takes part in the direct solve.
    pub fn in_direct(&self, h: f32) -> bool {
        self.may_hold() || self.stiff(h).is_some()
    }
    /// What the row gives way in the direct solve, velocity per impulse: an end and friction about all axes say more than the joint has
    /// freedoms, and without it some would be pushed against others by any amount.
    pub fn compliance(&self, h: f32) -> f64 {
        if let Some([k, c]) = self.stiff(h) {
            let h = f64::from(h);
            return 1.0 / (h * (h * k + c));
        }
        let part = if self.is_hard_end() { END_COMPLIANCE } else { MOTOR_COMPLIANCE };
        if self.mass > 0.0 { part / f64::from(self.mass) } else { 0.0 }
    }
    /// A motor or friction at its strength.
    pub fn gives_all(&self, h: f32) -> bool {
        matches!(self.duty, Duty::Speed { max, .. } if self.impulse.abs() >= max * h)
    }
    /// Hard ends.
    pub fn is_hard_end(&self) -> bool {
        matches!(self.duty, Duty::Limit(LimitDesc { spring: None, .. }))
    }
    /// From the nearer end, now.
    pub fn gap(&self) -> f32 {
        if let Duty::Limit(l) = &self.duty { self.end(l).1 } else { f32::INFINITY }
    }
    /// Speed away from the nearer end.
    pub fn away(&self, v: f32) -> f32 {
        if let Duty::Limit(l) = &self.duty { self.end(l).0 * v } else { v }
    }
    /// What the direct solve has to take from the speed `v` of the row.
    pub fn wanted(&self, v: f32, k: &Constants, sweep: Sweep) -> f32 {
        match &self.duty {
            Duty::Speed { speed, .. } => v - speed,
            Duty::Limit(l) => {
                let (sign, gap) = self.end(l);
                let to_end = sign * f32s::max(gap / k.h, -k.push_out);
                if sweep == Sweep::Relax { v } else { v + self.bend / k.h + to_end }
            }
            Duty::Spring { rest, velocity, .. } => self.stiff(k.h).map_or(0.0, |[stiffness, damping]| {
                let [c, v0] = [self.row.c - rest, *velocity].map(f64::from);
                let pull = (stiffness * c - damping * v0) / (f64::from(k.h) * stiffness + damping);
                (f64::from(v) + self.compliance(k.h) * f64::from(self.impulse) + pull) as f32
            }),
        }
    }
    /// A row that gives all it can, or nothing, has to hold again at the speed `v`: friction never pushes the way it slides, and an end
    /// is not passed.
    pub fn must_act(&self, v: f32, k: &Constants, sweep: Sweep) -> bool {
        match &self.duty {
            Duty::Speed { .. } if sweep == Sweep::Place => false,
            Duty::Speed { speed, .. } => self.impulse * (v - speed) > 0.0 && (v - speed).abs() > SLOW,
            Duty::Limit(_) if sweep == Sweep::Relax => {
                f32s::max(self.gap(), 0.0) + k.h * self.away(v) < -TOUCH
            }
            Duty::Limit(l) => self.end(l).0 * self.wanted(v, k, sweep) * k.h < -TOUCH,
            Duty::Spring { .. } => sweep == Sweep::Solve && self.impulse * self.wanted(v, k, sweep) > 0.0,
        }
    }
    /// The nearest impulse that it can give in a substep.
    pub fn allowed(&self, impulse: f32, h: f32) -> f32 {
        match &self.duty {
            Duty::Speed { max, .. } => f32s::clamp(impulse, -max * h, max * h),
            Duty::Limit(l) if l.holds_still() => impulse,
            Duty::Limit(l) => {
                let sign = self.end(l).0;
                sign * f32s::max(sign * impulse, 0.0)
            }
            Duty::Spring { max, .. } => f32s::clamp(impulse, -max * h, max * h),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spring_swings_and_decays_exactly() {
        let h = 1.0 / 240.0;
        for (hertz, zeta) in [(1.0, 0.0), (5.0, 0.1), (2.0, 0.7), (3.0, 1.0), (1.0, 4.0)] {
            let (a, b) = gains(&SpringDesc::hertz(hertz, zeta), 1.0, h);
            let (mut x, mut v) = (1.0_f64, 0.0_f64);
            let (a, b) = (f64::from(a), f64::from(b));
            // Start on the discrete mode of the continuous one: x₁ as it should be.
            let w = core::f64::consts::TAU * f64::from(hertz);
            let z = f64::from(zeta);
            let exact = |t: f64| {
                let s = z * w;
                let y2 = w * w - s * s;
                let e = jounce_math::scalar::f64s::exp(-s * t);
                if y2.abs() < 1e-6 {
                    e * (1.0 + s * t)
                } else if y2 > 0.0 {
                    let y = y2.sqrt();
                    e * (jounce_math::scalar::f64s::cos(y * t)
                        + s / y * jounce_math::scalar::f64s::sin(y * t))
                } else {
                    let r = (-y2).sqrt();
                    let (p, m) = (
                        jounce_math::scalar::f64s::exp((r - s) * t),
                        jounce_math::scalar::f64s::exp((-r - s) * t),
                    );
                    0.5 * (p + m) + s / r * 0.5 * (p - m)
                }
            };
            let dt = f64::from(h);
            v += ((exact(dt) - 1.0) / dt + a) / (1.0 - b);
            for i in 1..=480 {
                v -= a * x + b * v;
                x += dt * v;
                let want = exact(f64::from(i) * dt);
                assert!((x - want).abs() < 2e-4, "{hertz} Hz, ζ {zeta}, substep {i}: {x} for {want}");
            }
        }
    }
}
