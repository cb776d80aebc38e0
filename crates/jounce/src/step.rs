//! THE STEP: one call per stage, nothing else.

use crate::error::{Result, check};
use crate::room::contacts::prepare::StepConstants;
use crate::stage::*;
use crate::world::{Advance, World};
use crate::{limits, validate};
use jounce_tasks::FloatEnv;

/// A stage of the step, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Stage {
    /// Queued commands.
    Commands,
    /// Characters walk.
    Characters,
    /// Forces to accelerations.
    Forces,
    /// New pairs.
    BroadPhase,
    /// Manifolds.
    NarrowPhase,
    /// Begin, end, wake.
    Islands,
    /// Seams between neighbours.
    Seams,
    /// Colours and solver rows.
    Prepare,
    /// Integrate and solve.
    Substeps,
    /// Restitution, impulses and poses back.
    Finish,
    /// Quarantine.
    Guard,
    /// Continuous collision.
    Continuous,
    /// Births, motion and hits of particles.
    Particles,
    /// Islands at rest.
    Sleep,
    /// Bounds, sensors, hits.
    Publish,
}

impl Stage {
    /// All stages, in order.
    pub const ALL: [Self; 15] = [
        Self::Commands,
        Self::Characters,
        Self::Forces,
        Self::BroadPhase,
        Self::NarrowPhase,
        Self::Islands,
        Self::Seams,
        Self::Prepare,
        Self::Substeps,
        Self::Finish,
        Self::Guard,
        Self::Continuous,
        Self::Particles,
        Self::Sleep,
        Self::Publish,
    ];
    /// Name for tables.
    pub fn name(self) -> &'static str {
        [
            "commands",
            "characters",
            "forces",
            "broad phase",
            "narrow phase",
            "islands",
            "seams",
            "prepare",
            "substeps",
            "finish",
            "guard",
            "continuous",
            "particles",
            "sleep",
            "publish",
        ][self as usize]
    }
}

/// Watches the stages of a step go by: timing, tracing, hashing. The core itself reads no clock. [`World::events`] has those of
/// the step after its last stage.
pub trait StageObserver {
    /// A stage has just ended.
    fn after(&mut self, stage: Stage, world: &World);
}

/// The state hash after every stage: where two runs part, the first stage that differs is the one to look at.
///
/// ```
/// use jounce::{StageHashes, prelude::*};
///
/// # fn main() -> jounce::Result<()> {
/// let (mut a, mut b) = (World::new(WorldDesc::default())?, World::new(WorldDesc::default())?);
/// let (mut seen_a, mut seen_b) = (StageHashes::default(), StageHashes::default());
/// a.step_observed(&mut seen_a)?;
/// b.step_observed(&mut seen_b)?;
/// assert_eq!(seen_a.hashes, seen_b.hashes);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StageHashes {
    /// Stage and hash, in order, over all steps observed.
    pub hashes: Vec<(Stage, u64)>,
}

impl StageObserver for StageHashes {
    fn after(&mut self, stage: Stage, world: &World) {
        self.hashes.push((stage, world.hash()));
    }
}

struct Nobody;

impl StageObserver for Nobody {
    fn after(&mut self, _: Stage, _: &World) {}
}

impl World {
    /// One step of 1/rate seconds. Forces added since the last step act during this one and are then cleared.
    ///
    /// # Errors
    /// None today: the `Result` is for the limits of rooms to come.
    pub fn step(&mut self) -> Result<()> {
        self.step_observed(&mut Nobody)
    }

    /// One step, watched.
    ///
    /// # Errors
    /// As [`World::step`].
    pub fn step_observed(&mut self, observer: &mut dyn StageObserver) -> Result<()> {
        self.told.begin();
        self.one_step(observer);
        Ok(())
    }

    /// Makes as many steps as a frame of `frame_dt` seconds is due, at most 8; what is due beyond that is dropped and
    /// told. Forces act during the first step; when no step is made they wait, as do the events of edits. Events gather over all
    /// steps of the call.
    ///
    /// # Errors
    /// `frame_dt` negative or not finite.
    pub fn advance(&mut self, frame_dt: f64) -> Result<Advance> {
        check((0.0..=1e9).contains(&frame_dt), "advance", "frame_dt", frame_dt, "0 to 1e9 s")?;
        let dt = self.dt();
        self.accumulator += frame_dt;
        let mut result = Advance::default();
        self.told.begin();
        while self.accumulator >= dt && result.steps < limits::ADVANCE_STEPS_MAX {
            self.accumulator -= dt;
            self.one_step(&mut Nobody);
            result.steps += 1;
        }
        if self.accumulator >= dt {
            let whole = (self.accumulator / dt).floor() * dt;
            result.dropped_s = whole;
            self.accumulator -= whole;
        }
        result.alpha = jounce_math::scalar::f64s::clamp(self.accumulator / dt, 0.0, 1.0);
        Ok(result)
    }

    fn one_step(&mut self, observer: &mut dyn StageObserver) {
        let _mode = FloatEnv::set_default();
        let tasks = self.tasks.clone();
        let _attention = tasks.attend();
        let dt = self.dt() as f32;
        let constants = StepConstants::new(&self.settings, dt, self.substeps);
        let step = Step { dt, substeps: self.substeps, constants };
        for (stage, run) in STAGES {
            run(self, &step);
            if stage == Stage::Publish {
                self.told.take(&mut self.events);
            }
            observer.after(stage, self);
            validate::check_after(self, stage);
        }
    }
}

type Run = fn(&mut World, &Step);

const STAGES: [(Stage, Run); 15] = [
    (Stage::Commands, commands::run),
    (Stage::Characters, characters::run),
    (Stage::Forces, forces::run),
    (Stage::BroadPhase, broadphase::run),
    (Stage::NarrowPhase, narrowphase::run),
    (Stage::Islands, islands::run),
    (Stage::Seams, seams::run),
    (Stage::Prepare, prepare::run),
    (Stage::Substeps, substep::run),
    (Stage::Finish, substep::finish),
    (Stage::Guard, guard::run),
    (Stage::Continuous, continuous::run),
    (Stage::Particles, particles::run),
    (Stage::Sleep, sleep::run),
    (Stage::Publish, publish::run),
];
