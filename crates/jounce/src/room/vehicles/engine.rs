//! Engine and gearbox.
//!
//! Torque: T = a (T_full(n) + T_drag) − T_drag, a the throttle: full torque by the curve at a = 1, drag at a = 0. Below idle speed a governor
//! opens the throttle; above the limit there is no fuel. The clutch, where it works by itself, passes on more the faster the engine turns,
//! so that engine and clutch settle at the start where both torques are equal.

use super::desc::{ClutchDesc, EngineDesc, GearboxDesc};
use jounce_math::scalar::f32s;

/// 1/min per rad/s.
pub(crate) const RPM: f32 = 30.0 / core::f32::consts::PI;
/// Time between two changes of gear by an automatic gearbox, s.
const PATIENCE_S: f32 = 0.6;

/// Full torque at an engine speed, N m.
pub(crate) fn full_torque(e: &EngineDesc, rpm: f32) -> f32 {
    let Some(&(first, t)) = e.torque.first() else { return 0.0 };
    let mut last = (first, t);
    if rpm <= first {
        return t;
    }
    for &(r, t) in &e.torque[1..] {
        if rpm < r {
            return last.1 + (t - last.1) * (rpm - last.0) / (r - last.0);
        }
        last = (r, t);
    }
    last.1
}

/// Torque at an engine speed (rad/s) and throttle, N m.
pub(crate) fn torque(e: &EngineDesc, speed: f32, throttle: f32) -> f32 {
    let rpm = speed * RPM;
    let governor = if e.idle_rpm > 0.0 {
        f32s::clamp((1.05 * e.idle_rpm - rpm) / (0.1 * e.idle_rpm), 0.0, 1.0)
    } else {
        0.0
    };
    let a = if rpm >= e.limit_rpm { 0.0 } else { f32s::max(throttle, governor) };
    let drag = e.drag * f32s::clamp(speed * 0.05, 0.0, 1.0);
    a * (full_torque(e, rpm) + drag) - drag
}

/// What the clutch can pass on now, N m.
pub(crate) fn clutch_torque(c: &ClutchDesc, speed: f32, pedal: f32) -> f32 {
    let by_itself =
        c.auto_rpm.map_or(1.0, |(from, to)| f32s::clamp((speed * RPM - from) / (to - from), 0.0, 1.0));
    c.torque * by_itself * (1.0 - pedal)
}

/// Ratio of a gear, engine over wheels; 0 in neutral.
pub(crate) fn ratio(g: &GearboxDesc, gear: i32) -> f32 {
    match gear {
        0 => 0.0,
        -1 => -g.reverse * g.final_drive,
        n => g.forward.get(n as usize - 1).map_or(0.0, |r| r * g.final_drive),
    }
}

/// Where the gearbox stands. State.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Shifter {
    pub gear: i32,
    /// Gear to come, and time until then, s.
    pub next: i32,
    pub left_s: f32,
    /// Time since the last change, s.
    pub since_s: f32,
}

impl Shifter {
    pub fn is_shifting(&self) -> bool {
        self.gear != self.next
    }
    fn go(&mut self, gear: i32, g: &GearboxDesc) {
        if self.next != gear {
            self.next = gear;
            self.left_s = g.shift_s;
        }
    }
    /// One step of `dt`: `asked` by the driver, `input` the speed behind the clutch for a ratio of 1, rad/s.
    pub fn step(&mut self, g: &GearboxDesc, asked: i32, input: f32, dt: f32) {
        let most = g.forward.len() as i32;
        self.since_s = f32s::min(self.since_s + dt, 10.0);
        if self.is_shifting() {
            self.left_s -= dt;
            if self.left_s <= 0.0 {
                (self.gear, self.left_s, self.since_s) = (self.next, 0.0, 0.0);
            }
            return;
        }
        let asked = asked.min(most);
        let Some((up, down)) = g.auto_rpm.filter(|_| asked >= 1) else {
            self.go(asked, g);
            return;
        };
        if self.gear < 1 {
            self.go(1, g);
            return;
        }
        if self.since_s < PATIENCE_S {
            return;
        }
        let rpm = input * ratio(g, self.gear) * RPM;
        if rpm > up && self.gear < most {
            self.go(self.gear + 1, g);
        } else if rpm < down && self.gear > 1 {
            self.go(self.gear - 1, g);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn engine() -> EngineDesc {
        EngineDesc {
            torque: vec![(1000.0, 100.0), (3000.0, 200.0), (6000.0, 150.0)],
            inertia: 0.2,
            idle_rpm: 900.0,
            limit_rpm: 6500.0,
            drag: 30.0,
        }
    }

    #[test]
    fn the_curve_is_linear_between_its_points() {
        let e = engine();
        for (rpm, want) in [(0.0, 100.0), (1000.0, 100.0), (2000.0, 150.0), (3000.0, 200.0), (9000.0, 150.0)]
        {
            assert!((full_torque(&e, rpm) - want).abs() < 1e-3, "{rpm}");
        }
        assert!((torque(&e, 3000.0 / RPM, 1.0) - 200.0).abs() < 1e-2);
        assert!((torque(&e, 3000.0 / RPM, 0.0) + 30.0).abs() < 1e-3);
        assert!(torque(&e, 7000.0 / RPM, 1.0) < 0.0 && torque(&e, 300.0 / RPM, 0.0) > 0.0);
    }
}
