//! The scheduler does every unit once, whoever calls it from wherever, and always comes back.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "tests start threads and look at the clock"
)]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use jounce_tasks::{MAX_THREADS, Tasks};

fn schedulers() -> Vec<Tasks> {
    vec![
        Tasks::serial(),
        Tasks::pool(0),
        Tasks::pool(2),
        Tasks::pool(5),
        Tasks::chaos(1),
        Tasks::chaos_pool(1, 2),
        Tasks::chaos_pool(4, 3),
    ]
}

/// Fails instead of hanging.
fn within<R: Send + 'static>(limit: Duration, f: impl FnOnce() -> R + Send + 'static) -> R {
    let (done, wait) = mpsc::channel();
    thread::spawn(move || done.send(f()));
    wait.recv_timeout(limit).expect("hangs or panics")
}

const WATCHDOG: Duration = Duration::from_secs(60);

fn check_each_once(tasks: &Tasks, units: usize) {
    let counts: Vec<AtomicU32> = (0..units).map(|_| AtomicU32::new(0)).collect();
    tasks.run(units, &|unit| {
        counts[unit].fetch_add(1, Ordering::Relaxed);
    });
    assert!(counts.iter().all(|n| n.load(Ordering::Relaxed) == 1), "{tasks:?} {units}");
}

#[test]
fn every_unit_exactly_once() {
    within(WATCHDOG, || {
        for tasks in schedulers() {
            for units in (0..40).chain([63, 64, 65, 1000, 10_007]) {
                check_each_once(&tasks, units);
            }
        }
    });
}

#[test]
fn threads_counts_the_caller_and_is_limited() {
    assert_eq!(Tasks::serial().threads(), 1);
    assert_eq!(Tasks::default().threads(), 1);
    assert_eq!(Tasks::pool(0).threads(), 1);
    assert_eq!(Tasks::pool(1).threads(), 1);
    assert_eq!(Tasks::pool(3).threads(), 3);
    assert_eq!(Tasks::pool(usize::MAX).threads(), MAX_THREADS);
    assert_eq!(Tasks::chaos_pool(3, 0).threads(), 3);
}

#[test]
fn other_threads_take_part() {
    within(WATCHDOG, || {
        let tasks = Tasks::pool(2);
        // Two units that each wait for the other to begin: one thread alone could not finish them.
        let begun = AtomicUsize::new(0);
        tasks.run(2, &|_| {
            begun.fetch_add(1, Ordering::SeqCst);
            while begun.load(Ordering::SeqCst) < 2 {
                thread::yield_now();
            }
        });
    });
}

#[test]
fn a_stage_does_not_wait_for_workers_that_found_no_unit() {
    within(WATCHDOG, || {
        let tasks = Tasks::pool(2);
        let (tell, told) = mpsc::channel::<()>();
        let told = Mutex::new(told);
        let holder = {
            let tasks = tasks.clone();
            // Holds the pool with a unit that ends only after the other stage has ended.
            thread::spawn(move || {
                tasks.run(2, &|unit| {
                    if unit == 0 {
                        told.lock().unwrap().recv().unwrap();
                    }
                });
            })
        };
        thread::sleep(Duration::from_millis(20));
        check_each_once(&tasks, 100);
        tell.send(()).unwrap();
        holder.join().unwrap();
    });
}

#[test]
fn nested_stages() {
    within(WATCHDOG, || {
        for tasks in schedulers() {
            let sum = AtomicUsize::new(0);
            tasks.run(20, &|outer| {
                tasks.run(20, &|inner| {
                    tasks.run(2, &|_| {
                        sum.fetch_add(outer * 20 + inner, Ordering::Relaxed);
                    });
                });
            });
            assert_eq!(sum.into_inner(), 2 * (0..400).sum::<usize>(), "{tasks:?}");
        }
    });
}

#[test]
fn four_callers_at_once() {
    within(WATCHDOG, || {
        for tasks in schedulers() {
            thread::scope(|scope| {
                for caller in 0..4 {
                    let tasks = tasks.clone();
                    scope.spawn(move || {
                        for stage in 0..500 {
                            check_each_once(&tasks, (stage * 7 + caller) % 33);
                        }
                    });
                }
            });
        }
    });
}

#[test]
fn a_panic_reaches_the_caller_and_the_pool_lives_on() {
    within(WATCHDOG, || {
        for tasks in schedulers() {
            for round in 0..20 {
                let done = AtomicUsize::new(0);
                let caught = catch_unwind(AssertUnwindSafe(|| {
                    tasks.run(50, &|unit| {
                        if unit % 20 == 7 {
                            std::panic::resume_unwind(Box::new(unit));
                        }
                        done.fetch_add(1, Ordering::Relaxed);
                    });
                }));
                let unit =
                    *caught.expect_err("the panic is lost").downcast::<usize>().expect("another payload");
                assert_eq!(unit % 20, 7);
                if tasks.threads() > 1 {
                    assert_eq!(done.into_inner(), 47, "the other units are done: {tasks:?}");
                }
                check_each_once(&tasks, round);
            }
        }
        let tasks = Tasks::pool(4);
        let caught = catch_unwind(|| tasks.run(50, &|unit| std::panic::resume_unwind(Box::new(unit))));
        assert_eq!(*caught.unwrap_err().downcast::<usize>().unwrap(), 0, "the lowest unit's panic is kept");
    });
}

#[test]
fn a_panic_in_a_nested_stage() {
    within(WATCHDOG, || {
        for tasks in schedulers() {
            let caught = catch_unwind(AssertUnwindSafe(|| {
                tasks.run(8, &|_| tasks.run(8, &|_| std::panic::resume_unwind(Box::new("inner"))));
            }));
            assert_eq!(*caught.unwrap_err().downcast::<&str>().unwrap(), "inner");
            check_each_once(&tasks, 100);
        }
    });
}

#[test]
fn thirty_two_workers_on_few_processors() {
    within(WATCHDOG, || {
        let tasks = Tasks::pool(32);
        assert_eq!(tasks.threads(), 32);
        let end = Instant::now() + Duration::from_secs(3);
        let mut stages = 0usize;
        while Instant::now() < end {
            check_each_once(&tasks, stages % 70);
            stages += 1;
            if stages.is_multiple_of(1000) {
                // Long enough for everybody to fall asleep.
                thread::sleep(Duration::from_millis(5));
            }
        }
        assert!(stages > 100, "{stages} stages in three seconds");
    });
}

#[test]
fn dropping_the_last_handle_joins_the_workers() {
    within(WATCHDOG, || {
        let held = Arc::new(());
        for _ in 0..20 {
            let tasks = Tasks::pool(8);
            let clone = tasks.clone();
            tasks.run(64, &|_| {
                // Dropped when its thread ends, and not before.
                thread_local!(static KEPT: std::cell::RefCell<Option<Arc<()>>> = const { std::cell::RefCell::new(None) });
                if thread::current().name().is_some_and(|name| name.starts_with("jounce-")) {
                    KEPT.set(Some(Arc::clone(&held)));
                }
                thread::yield_now();
            });
            drop(tasks);
            check_each_once(&clone, 64);
            drop(clone);
            assert_eq!(Arc::strong_count(&held), 1, "a worker is still alive");
        }
    });
}

#[test]
fn chaos_changes_the_order_with_seed_and_stage_and_repeats_it() {
    let orders = |seed| {
        let tasks = Tasks::chaos(seed);
        [(); 3].map(|()| {
            let order = Mutex::new(Vec::new());
            tasks.run(50, &|unit| order.lock().unwrap().push(unit));
            order.into_inner().unwrap()
        })
    };
    let (one, again, two) = (orders(1), orders(1), orders(2));
    assert_eq!(one, again);
    assert_ne!(one, two);
    assert_ne!(one[0], one[1]);
    assert!(one.iter().all(|order| order.iter().enumerate().any(|(i, &unit)| i != unit)));
}

#[test]
fn handles_are_shared_and_printed() {
    fn is<T: Send + Sync + Clone + std::fmt::Debug>(_: &T) {}
    for tasks in schedulers() {
        is(&tasks);
    }
    assert_eq!(format!("{:?}", Tasks::pool(3)), "Tasks::pool(3)");
}

#[test]
fn both_of_a_join_are_done_once() {
    within(WATCHDOG, || {
        for tasks in schedulers() {
            for _ in 0..200 {
                let _attention = tasks.attend();
                let (mut a, mut b) = (0, vec![1, 2, 3]);
                tasks.join(|| a += 1, || b.push(4));
                assert_eq!((a, b), (1, vec![1, 2, 3, 4]), "{tasks:?}");
            }
            let caught = catch_unwind(AssertUnwindSafe(|| tasks.join(|| {}, || panic!("the second"))));
            assert!(caught.is_err(), "{tasks:?}");
            check_each_once(&tasks, 50);
        }
        // At the same time: each waits for the other.
        let begun = AtomicUsize::new(0);
        let wait = || {
            begun.fetch_add(1, Ordering::SeqCst);
            while begun.load(Ordering::SeqCst) < 2 {
                thread::yield_now();
            }
        };
        Tasks::pool(2).join(wait, wait);
    });
}
