//! What a run came to.

use crate::load::Scene;
use crate::plan::Expect;
use crate::spec::ExpectSpec;
use jounce::World;
use serde::Serialize;

/// Summary of a run; as JSON it is what `jounce run --json` prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name of the scene.
    pub scene: String,
    /// Steps made.
    pub steps: u64,
    /// Simulated time, s.
    pub seconds_simulated: f64,
    /// Bodies at the end.
    pub bodies: usize,
    /// Joints at the end.
    pub joints: usize,
    /// Particles at the end.
    pub particles: usize,
    /// Pairs of shapes that touch at the end.
    pub contacts: usize,
    /// Awake bodies at the end.
    pub awake: usize,
    /// Time that the steps took, of the engine and of the systems of points and springs, ms.
    pub step_ms: StepMs,
    /// Mechanical energy, J.
    pub energy: StartEnd,
    /// Momentum at the end.
    pub momentum: Momentum,
    /// Hash of the world at the end: "0x" and 16 hexadecimal digits.
    pub hash: String,
    /// All expectations, in the order of the file.
    pub expectations: Vec<Expectation>,
    /// Limits that were reached and systems that stopped, each once with the time of the first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// Wall-clock time of steps, ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StepMs {
    /// Median.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Longest.
    pub max: f64,
}

/// A number at the start and at the end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StartEnd {
    /// Before the first step.
    pub start: f64,
    /// After the last step.
    pub end: f64,
}

/// Momentum of the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Momentum {
    /// kg m/s.
    pub linear: [f64; 3],
    /// About the origin, kg m²/s.
    pub angular: [f64; 3],
}

/// One expectation, judged.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expectation {
    /// Name.
    pub name: String,
    /// Name of the probe.
    pub probe: String,
    /// When, s.
    pub at: f64,
    /// The right number, or the accepted range in words.
    pub expected: Expected,
    /// The probe's number (over a time, the one farthest off); none where its body was not there, or before the time.
    pub got: Option<f64>,
    /// Largest accepted difference.
    pub tolerance: f64,
    /// Where the number comes from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Is it met? None (in JSON `null`) where the run was too short to tell.
    pub pass: Option<bool>,
}

/// What was expected.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Expected {
    /// A number.
    Value(f64),
    /// A range: "≥ 1", "≤ 2" or "1 … 2".
    Range(String),
}

impl std::fmt::Display for Expected {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Value(v) => v.fmt(f),
            Self::Range(r) => f.write_str(r),
        }
    }
}

impl Report {
    pub(crate) fn new(
        scene: &Scene,
        world: &World,
        times: &StepTimes,
        start_energy: f64,
        judges: &[Judge],
    ) -> Self {
        let (counts, p) = (world.counts(), world.momentum());
        Self {
            scene: scene.name.clone(),
            steps: world.step_count(),
            seconds_simulated: world.time(),
            bodies: counts.bodies,
            joints: counts.joints,
            particles: counts.particles,
            contacts: counts.touching,
            awake: counts.awake,
            step_ms: times.summary(),
            energy: StartEnd { start: start_energy, end: world.energy().total() },
            momentum: Momentum { linear: p.linear.to_array(), angular: p.angular.to_array() },
            hash: format!("{:#018x}", world.hash()),
            expectations: judges.iter().zip(&scene.spec.expect).map(|(j, e)| j.expectation(e)).collect(),
            warnings: Vec::new(),
        }
    }

    /// True when no expectation failed. Those that the run was too short to judge are in [`Report::not_judged`].
    pub fn passed(&self) -> bool {
        self.expectations.iter().all(|e| e.pass != Some(false))
    }

    /// Expectations whose time has not come.
    pub fn not_judged(&self) -> impl Iterator<Item = &Expectation> {
        self.expectations.iter().filter(|e| e.pass.is_none())
    }

    /// One JSON object, without line breaks.
    pub fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// An expectation on its way.
#[derive(Clone, Debug)]
pub(crate) struct Judge {
    value: Option<f64>,
    tolerance: f64,
    min: f64,
    max: f64,
    /// The number farthest outside (or least inside), and how far.
    worst: Option<(f64, f64)>,
    missing: bool,
    pub reached: bool,
}

impl Judge {
    pub(crate) fn new(_: &Expect, spec: &ExpectSpec) -> Self {
        Self {
            value: spec.value,
            tolerance: spec.tolerance.unwrap_or(0.0),
            min: spec.min.unwrap_or(f64::NEG_INFINITY),
            max: spec.max.unwrap_or(f64::INFINITY),
            worst: None,
            missing: false,
            reached: false,
        }
    }

    /// Takes in one number; `last` at the expectation's time.
    pub(crate) fn see(&mut self, got: f64, last: bool) {
        self.reached |= last;
        if !got.is_finite() {
            self.missing = true;
            return;
        }
        let off = [
            self.value.map_or(f64::NEG_INFINITY, |v| (got - v).abs() - self.tolerance),
            self.min - got,
            got - self.max,
        ]
        .into_iter()
        .fold(f64::NEG_INFINITY, |a, b| if b > a { b } else { a });
        if self.worst.is_none_or(|(_, w)| off >= w) {
            self.worst = Some((got, off));
        }
    }

    fn expectation(&self, spec: &ExpectSpec) -> Expectation {
        let expected = match (spec.value, spec.min, spec.max) {
            (Some(v), ..) => Expected::Value(v),
            (None, Some(a), Some(b)) => Expected::Range(format!("{} … {}", short(a), short(b))),
            (None, Some(a), None) => Expected::Range(format!("≥ {}", short(a))),
            (None, None, b) => Expected::Range(format!("≤ {}", short(b.unwrap_or(f64::INFINITY)))),
        };
        Expectation {
            name: spec.name.clone(),
            probe: spec.probe.clone(),
            at: spec.at,
            expected,
            got: self.worst.map(|w| w.0).filter(|_| self.reached && !self.missing),
            tolerance: self.tolerance,
            source: spec.source.clone(),
            pass: self.reached.then(|| !self.missing && self.worst.is_some_and(|(_, off)| off <= 0.0)),
        }
    }
}

/// A number without a row of zeros.
fn short(v: f64) -> String {
    if v != 0.0 && v.is_finite() && !(1e-4..1e9).contains(&v.abs()) {
        format!("{v:e}")
    } else {
        v.to_string()
    }
}

/// Times of steps with bounded memory: when full, every second one goes, so that the rest still spans the run. The
/// longest is kept apart.
#[derive(Clone, Debug, Default)]
pub(crate) struct StepTimes {
    ms: Vec<f64>,
    stride: u64,
    seen: u64,
    max: f64,
}

impl StepTimes {
    pub(crate) fn add(&mut self, ms: f64) {
        self.stride = self.stride.max(1);
        if ms > self.max {
            self.max = ms;
        }
        if self.seen.is_multiple_of(self.stride) {
            if self.ms.len() >= crate::limits::ROWS_MAX {
                let mut n = 0;
                self.ms.retain(|_| {
                    n += 1;
                    n % 2 == 1
                });
                self.stride *= 2;
            }
            self.ms.push(ms);
        }
        self.seen += 1;
    }

    fn summary(&self) -> StepMs {
        let mut sorted = self.ms.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let at = |part: f64| {
            let n = (part * sorted.len() as f64) as usize;
            sorted.get(n.min(sorted.len().saturating_sub(1))).copied().unwrap_or(0.0)
        };
        StepMs { median: at(0.5), p95: at(0.95), max: self.max }
    }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn ranges_are_short_and_true() {
        for (v, text) in
            [(-1e-9, "-1e-9"), (0.0, "0"), (0.15, "0.15"), (2.5e12, "2.5e12"), (f64::INFINITY, "inf")]
        {
            assert_eq!(short(v), text);
        }
    }
}
