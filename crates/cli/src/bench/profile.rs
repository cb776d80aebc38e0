//! Where our step spends its time: milliseconds by stage.

use super::Row;
use crate::error::Done;
use crate::output::Table;
use jounce::{Stage, StageObserver, World};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::time::Instant;

/// Milliseconds of each stage over the steps watched.
#[derive(Clone, Debug, Default)]
pub(crate) struct Profile {
    ms: [f64; Stage::ALL.len()],
}

struct Clock<'a> {
    profile: &'a mut Profile,
    last: Instant,
}

impl StageObserver for Clock<'_> {
    fn after(&mut self, stage: Stage, _: &World) {
        let now = Instant::now();
        self.profile.ms[stage as usize] += (now - self.last).as_secs_f64() * 1e3;
        self.last = now;
    }
}

impl Profile {
    /// One step, watched.
    pub fn step(&mut self, world: &mut World) -> Done {
        let mut clock = Clock { profile: self, last: Instant::now() };
        Ok(world.step_observed(&mut clock)?)
    }
}

impl Serialize for Profile {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(Stage::ALL.len()))?;
        for stage in Stage::ALL {
            map.serialize_entry(stage.name(), &self.ms[stage as usize])?;
        }
        map.end()
    }
}

const COLUMNS: usize = Stage::ALL.len() + 2;

/// Milliseconds a step: a row for each scene and number of threads that was watched, a column for each stage.
pub(super) fn table(rows: &[Row]) -> Table {
    let head = |c: usize| match c {
        0 => "ms/step",
        1 => "threads",
        _ => Stage::ALL[c - 2].name(),
    };
    let mut t = Table::new(std::array::from_fn::<_, COLUMNS, _>(head));
    for (r, profile) in rows.iter().filter_map(|r| Some((r, r.stages.as_ref()?))) {
        t.row(std::array::from_fn::<_, COLUMNS, _>(|c| match c {
            0 => r.scene.clone(),
            1 => r.threads.to_string(),
            _ => format!("{:.3}", profile.ms[c - 2] / (r.steps.max(2) - 1) as f64),
        }));
    }
    t
}

#[cfg(test)]
mod tests {
    use super::super::{Plan, SCENES, ours};

    #[test]
    fn stages_add_up_to_the_time_of_the_steps() {
        let scene = SCENES.iter().find(|s| s.name == "heavy_on_light").expect("listed");
        let plan = Plan { steps: 100, repeats: 1, threads: 1, profile: true };
        let sample = ours(scene, plan).expect("runs");
        let stages = sample.stages.expect("watched");
        let sum: f64 = stages.ms.iter().sum();
        assert!(sum > 0.0 && sum <= sample.ms, "{sum} of {} ms", sample.ms);
        // Nothing of this scene flies about in particles, and all of it is solved.
        let of = |s: jounce::Stage| stages.ms[s as usize];
        let most = jounce::Stage::ALL.into_iter().max_by(|a, b| of(*a).total_cmp(&of(*b)));
        assert!(of(jounce::Stage::Substeps) > of(jounce::Stage::Particles), "most in {most:?}");
    }
}
