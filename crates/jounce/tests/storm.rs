//! Random worlds: bodies, shapes, surfaces, edits, queries, clones. Nothing panics, nothing becomes infinite or NaN, no body
//! is quarantined, no step hangs, and the tables agree with one another.
//!
//! `JOUNCE_PROVE=1` runs 2,000 seeds, `JOUNCE_STORM_SEED=123` one.

mod common;

use common::look::not_finite;
use common::storm::Storm;
use jounce::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

const STEPS: usize = 240;
/// Longest a step of at most 40 bodies may take, on a machine that does other things too.
const STEP_TIME_MAX: Duration = Duration::from_secs(5);

/// One seed, start to end; panics where something is wrong.
fn run(seed: u64) {
    let mut storm = Storm::new(seed);
    let mut twin: Option<Storm> = None;
    for step in 0..STEPS {
        let start = Instant::now();
        storm.step();
        let time = start.elapsed();
        assert!(time < STEP_TIME_MAX, "step {step} took {time:?}");
        if let Some(what) = not_finite(&storm.world) {
            panic!("step {step}: {what}");
        }
        for e in storm.world.events() {
            assert!(!matches!(e, Event::Quarantine { .. }), "step {step}: {e:?}");
        }
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
    }
}

fn message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned())).unwrap_or_default()
}

#[test]
fn random_worlds_stay_sane() {
    if let Ok(seed) = std::env::var("JOUNCE_STORM_SEED") {
        return run(seed.parse().expect("a number"));
    }
    let seeds = if common::prove() { 2000 } else { 200 };
    let next = AtomicU64::new(0);
    let failed = Mutex::new(Vec::new());
    let work = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds {
                return;
            }
            if let Err(panic) = catch_unwind(AssertUnwindSafe(|| run(seed))) {
                let line = format!(
                    "JOUNCE_STORM_SEED={seed} cargo test -p jounce --test storm  # {}",
                    message(panic.as_ref())
                );
                failed.lock().expect("no panic while held").push(line);
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
}
