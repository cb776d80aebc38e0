//! Who does the work: the stage scheduler of Jounce, and the two ways a stage may write in parallel.
//!
//! A *stage* is a number of *units* of work whose layout is fixed by the caller: it depends on the data and on a
//! chunk size, never on the number of threads. [`Tasks::run`] does each unit exactly once and returns when all
//! units are done. Because no unit reads what another unit of the same stage writes, the result is the same
//! bits for every [`Tasks`]: serial, pool or chaos.
//!
//! - [`Tasks`] hands out units, and contiguous chunks of slices (`for_each*`, `map_chunks`).
//! - [`ColorSets`] colours constraint rows so that rows of one colour touch disjoint items, and gives scattered
//!   read and write access to them ([`Scatter`]).
//! - [`FloatEnv`] sets the floating-point mode that the bits depend on, and restores the caller's.
//!
//! All atomics, thread starts and the `unsafe` that disjoint parallel writes need live in this crate, so that the
//! engine can forbid `unsafe`.

mod chaos;
mod color;
mod float_env;
mod pool;
mod slices;

use std::fmt;
use std::panic::{RefUnwindSafe, UnwindSafe};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

pub use color::{ColorSets, Row, Scatter};
pub use float_env::FloatEnv;
pub use slices::{Cut, Owned, Owning};

use chaos::Shuffle;
use pool::Pool;

/// The most threads a pool uses, the caller included.
pub const MAX_THREADS: usize = 64;

/// A handle to a scheduler. Clones share the threads; the threads are joined when the last handle drops.
#[derive(Clone, Default)]
pub struct Tasks(Mode);

#[derive(Clone, Default)]
enum Mode {
    #[default]
    Serial,
    Pool(Arc<Pool>),
    Chaos(Arc<Chaos>),
}

/// See [`Tasks::attend`].
pub struct Attention<'a>(#[expect(dead_code, reason = "dropped with it")] Option<pool::Attention<'a>>);

/// Stages are numbered so that each gets its own order. The number is taken by whoever calls `run`.
struct Chaos {
    seed: u64,
    stage: AtomicU64,
    pool: Option<Pool>,
}

// A panic in a unit leaves the scheduler as if the stage had ended.
impl UnwindSafe for Tasks {}
impl RefUnwindSafe for Tasks {}

impl Tasks {
    /// All units on the calling thread, in order. The default.
    pub fn serial() -> Self {
        Self(Mode::Serial)
    }

    /// A pool of `threads` threads, of which the caller of [`run`](Self::run) is one: `threads - 1` are started.
    ///
    /// `threads` is limited to 1..=[`MAX_THREADS`]; 1 is the serial path. Where the system refuses a thread (wasm
    /// without threads, a process limit) the pool goes on with those it got.
    pub fn pool(threads: usize) -> Self {
        if threads <= 1 { Self::serial() } else { Self(Mode::Pool(Arc::new(Pool::new(threads)))) }
    }

    /// For tests: serial, with the units of every stage in a seeded random order, another one each stage.
    pub fn chaos(seed: u64) -> Self {
        Self(Mode::Chaos(Arc::new(Chaos { seed, stage: AtomicU64::new(0), pool: None })))
    }

    /// For tests: a pool whose units come in a seeded random order and yield at random moments.
    pub fn chaos_pool(threads: usize, seed: u64) -> Self {
        let pool = (threads > 1).then(|| Pool::new(threads));
        Self(Mode::Chaos(Arc::new(Chaos { seed, stage: AtomicU64::new(0), pool })))
    }

    /// Runs everything on the calling thread, in order.
    pub fn is_serial(&self) -> bool {
        matches!(self.0, Mode::Serial)
    }

    /// Threads that take part in a stage, the caller included; at least 1.
    pub fn threads(&self) -> usize {
        match &self.0 {
            Mode::Serial => 1,
            Mode::Pool(pool) => pool.threads(),
            Mode::Chaos(chaos) => chaos.pool.as_ref().map_or(1, Pool::threads),
        }
    }

    /// Says that stages follow each other closely while the guard lives, as they do in a step: threads without work then wait awake for the next
    /// stage for a while, since to wake one takes as long as a short stage.
    #[must_use]
    pub fn attend(&self) -> Attention<'_> {
        let pool = match &self.0 {
            Mode::Serial => None,
            Mode::Pool(pool) => Some(&**pool),
            Mode::Chaos(chaos) => chaos.pool.as_ref(),
        };
        Attention(pool.map(Pool::attend))
    }

    /// Calls both, at the same time where there are threads for it: a stage of two units.
    pub fn join(&self, a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
        fn once(f: &Mutex<Option<impl FnOnce()>>) {
            let f = f.lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(f) = f {
                f();
            }
        }
        let (a, b) = (Mutex::new(Some(a)), Mutex::new(Some(b)));
        self.run(2, &|unit| if unit == 0 { once(&a) } else { once(&b) });
    }

    /// Calls `f(unit)` exactly once for every unit in `0..units` and returns when all are done.
    ///
    /// May be called from inside a unit and from several threads at once: while the pool is taken, such a call does
    /// its units itself, in order. Every unit runs under the default floating-point mode (see [`FloatEnv`]).
    ///
    /// # Panics
    /// A panic in a unit reaches the caller. On a pool all other units are done first, and of several panics that
    /// of the lowest unit is the one resumed; the serial path stops at the first.
    pub fn run(&self, units: usize, f: &(dyn Fn(usize) + Sync)) {
        if units == 0 {
            return;
        }
        let _env = FloatEnv::set_default();
        match &self.0 {
            Mode::Serial => serial(units, f),
            Mode::Pool(pool) => {
                if units == 1 || !pool.run(units, f) {
                    serial(units, f);
                }
            }
            Mode::Chaos(chaos) => {
                let stage = chaos.stage.fetch_add(1, Ordering::Relaxed);
                let shuffle = Shuffle::new(chaos.seed, stage, units);
                match &chaos.pool {
                    Some(pool) => {
                        let shuffled = |i: usize| {
                            shuffle.maybe_yield(i);
                            f(shuffle.unit(i));
                        };
                        if !pool.run(units, &shuffled) {
                            serial(units, &shuffled);
                        }
                    }
                    None => serial(units, &|i| f(shuffle.unit(i))),
                }
            }
        }
    }
}

fn serial(units: usize, f: &(dyn Fn(usize) + Sync)) {
    for unit in 0..units {
        f(unit);
    }
}

impl fmt::Debug for Tasks {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Mode::Serial => out.write_str("Tasks::serial()"),
            Mode::Pool(pool) => write!(out, "Tasks::pool({})", pool.threads()),
            Mode::Chaos(chaos) => write!(out, "Tasks::chaos_pool({}, {:#x})", self.threads(), chaos.seed),
        }
    }
}
