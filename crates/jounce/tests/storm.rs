//! Random worlds: bodies, shapes, surfaces, edits, queries, clones; fields of every law in every second one, particles in two of
//! four, vehicles and characters in four of eight. Nothing panics, nothing that can be seen is infinite or NaN, nobody is quarantined,
//! no step hangs, and the tables agree with one another. A second storm has joints and ragdolls in every world.
//!
//! `JOUNCE_PROVE=1` runs 2,000 seeds of each, `JOUNCE_STORM_SEED=123` one.

mod common;

use common::look::not_finite;
use common::storm::Storm;
use jounce::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

const STEPS: usize = 240;
/// Longest a step of at most 80 bodies may take, on a machine that does other things too.
const STEP_TIME_MAX: Duration = Duration::from_secs(5);

/// What a world went through.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// Sum over the steps.
    touching: usize,
    /// Bodies whose state was no longer finite, and that were taken out.
    quarantined: usize,
}

/// One seed, start to end; panics where something is wrong.
#[expect(clippy::disallowed_methods, reason = "a hang is a failure")]
fn run(seed: u64, jointed: bool) -> Seen {
    let mut seen = Seen::default();
    let mut storm = Storm::new(seed);
    if jointed {
        storm = storm.with_joints(seed);
    }
    if seed % 4 >= 2 {
        storm = storm.with_particles(seed);
    }
    if seed % 2 == 1 {
        storm = storm.with_fields(seed);
    }
    if seed % 8 >= 4 {
        storm = storm.with_movers(seed);
    }
    let mut twin: Option<Storm> = None;
    for step in 0..STEPS {
        let start = Instant::now();
        storm.step();
        let time = start.elapsed();
        assert!(time < STEP_TIME_MAX, "step {step} took {time:?}");
        if let Some(what) = not_finite(&storm.world) {
            panic!("step {step}: {what}");
        }
        let poisoned = storm.world.events().iter().filter(|e| matches!(e, Event::Quarantine { .. }));
        seen.quarantined += poisoned.count();
        if step % 16 == 0 {
            storm.query();
            storm.world.validate();
        }
        if let Some(t) = &mut twin {
            t.step();
            if step % 16 == 0 {
                t.query();
            }
            assert_eq!(t.world.hash(), storm.world.hash(), "step {step}: the clone went another way");
        }
        if step == 100 {
            twin = Some(storm.clone());
        }
        if step == 140 {
            twin = None;
        }
        seen.touching += storm.world.counts().touching;
    }
    seen
}

fn message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned())).unwrap_or_default()
}

#[test]
fn random_worlds_stay_sane() {
    storms("random_worlds_stay_sane", false);
}

#[test]
fn random_worlds_with_joints_stay_sane() {
    storms("random_worlds_with_joints_stay_sane", true);
}

#[expect(clippy::disallowed_methods, reason = "worlds on one thread each, several at a time")]
fn storms(test: &str, jointed: bool) {
    if let Ok(seed) = std::env::var("JOUNCE_STORM_SEED") {
        let seen = run(seed.parse().expect("a number"), jointed);
        println!("{seen:?}");
        assert_eq!(seen.quarantined, 0);
        return;
    }
    let seeds = if common::prove() { 2000 } else { 200 };
    let next = AtomicU64::new(0);
    let all = Mutex::new(Vec::new());
    let failed = Mutex::new(Vec::new());
    let work = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds {
                return;
            }
            match catch_unwind(AssertUnwindSafe(|| run(seed, jointed))) {
                Ok(seen) => all.lock().expect("no panic while held").push((seed, seen)),
                Err(panic) => {
                    let why = message(panic.as_ref());
                    let line =
                        format!("JOUNCE_STORM_SEED={seed} cargo test -p jounce --test storm {test}  # {why}");
                    failed.lock().expect("no panic while held").push(line);
                }
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get().min(8));
    std::thread::scope(|s| {
        for _ in 0..threads {
            s.spawn(work);
        }
    });
    let failed = failed.into_inner().expect("no panic while held");
    assert!(failed.is_empty(), "{} of {seeds} seeds failed:\n{}", failed.len(), failed.join("\n"));
    let all = all.into_inner().expect("no panic while held");
    let mean = all.iter().map(|(_, s)| s.touching).sum::<usize>() / (STEPS * all.len());
    let poisoned: Vec<_> = all.iter().filter(|(_, s)| s.quarantined > 0).collect();
    println!("{seeds} worlds, {mean} touching pairs on average, quarantine in {poisoned:?}");
    assert!(mean >= 10, "{mean} touching pairs on average: too quiet to find anything");
    assert!(poisoned.is_empty(), "quarantine in {} worlds: {poisoned:?}", poisoned.len());
}
