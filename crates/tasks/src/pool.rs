//! The thread pool: units are claimed one by one, and a stage ends when its units are done.
//!
//! A stage is published in three steps: the job is written, `pending` is set to the number of units, and
//! `unclaimed` is set to the same number. A thread claims a unit by taking `unclaimed` from `n > 0` to `n - 1` with
//! a compare-and-swap, does it, and takes one from `pending`. The caller claims like everybody else; when nothing
//! is left to claim it waits for `pending` to reach zero. A worker that sleeps through a whole stage is therefore
//! never waited for.
//!
//! Why no stage number stands beside the counter: a claim that succeeds is a claim on the stage that is current at
//! that moment, however old the value the thread had read before, and the job is read only after the claim. That
//! stage cannot end before the claimed unit is done, so the job stays valid and unchanged until then. The swap
//! reads from the release sequence headed by the caller's store, so the job written before it is visible.
//!
//! One stage at a time owns the pool (`busy`). A call that finds it taken, from inside a unit or from another
//! thread, is told so and does its units itself: nobody ever waits for a stage other than their own, hence no
//! deadlock.
//!
//! Sleeping follows Dekker's pattern with sequentially consistent operations: the sleeper announces itself, then
//! looks again; the waker publishes, then looks for sleepers. One of the two sees the other.

use std::any::Any;
use std::cell::UnsafeCell;
use std::hint;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use crate::{FloatEnv, MAX_THREADS};

/// Turns of the spin loop before a thread goes to sleep: some ten microseconds, the length of a short stage.
const SPINS: usize = 2000;
/// The same where there are more threads than processors, and spinning takes time from those who work.
const SPINS_CROWDED: usize = 20;

/// Keeps counters that different threads hammer off each other's cache line (two lines: adjacent-line prefetch).
#[repr(align(128))]
struct Padded<T>(T);

#[derive(Clone, Copy)]
struct Job {
    f: *const (dyn Fn(usize) + Sync),
    units: usize,
}

/// The payload of a panic, and the unit it came from.
type Panicked = (usize, Box<dyn Any + Send>);

struct Shared {
    /// Units of the current stage that nobody has claimed.
    unclaimed: Padded<AtomicUsize>,
    /// Units of the current stage that are not done.
    pending: Padded<AtomicUsize>,
    /// Held by the call whose stage is current.
    busy: AtomicBool,
    /// Written by the holder of `busy` while nothing is claimed or unclaimed; read by holders of a claim.
    job: UnsafeCell<Job>,
    panicked: Mutex<Option<Panicked>>,
    /// Workers that sleep or are about to.
    sleepers: AtomicUsize,
    caller_sleeps: AtomicBool,
    shutdown: AtomicBool,
    gate: Mutex<()>,
    work_came: Condvar,
    stage_ended: Condvar,
    spins: usize,
}

// SAFETY: everything but `job` is Sync by itself. `job` is written only by the holder of `busy` at a moment when
// `pending` is zero, and read only by threads that hold a claim, that is while `pending` is not zero; both are ordered
// by `unclaimed` (publish, release; claim, acquire) and `pending` (done, release; end of stage, acquire). The
// closure behind the pointer is Sync, so it may be called from any thread.
unsafe impl Sync for Shared {}
// SAFETY: as above; the raw pointer is only followed under a claim.
unsafe impl Send for Shared {}

/// Locks without poisoning: no state is left half-written under these locks.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    fn new(spins: usize) -> Self {
        let nothing: &'static (dyn Fn(usize) + Sync) = &|_| {};
        Self {
            unclaimed: Padded(AtomicUsize::new(0)),
            pending: Padded(AtomicUsize::new(0)),
            busy: AtomicBool::new(false),
            job: UnsafeCell::new(Job { f: nothing, units: 0 }),
            panicked: Mutex::new(None),
            sleepers: AtomicUsize::new(0),
            caller_sleeps: AtomicBool::new(false),
            shutdown: AtomicBool::new(false),
            gate: Mutex::new(()),
            work_came: Condvar::new(),
            stage_ended: Condvar::new(),
            spins,
        }
    }

    /// Claims and does units until none is left to claim.
    fn work(&self) {
        let mut left = self.unclaimed.0.load(Ordering::Acquire);
        while left > 0 {
            match self.unclaimed.0.compare_exchange_weak(left, left - 1, Ordering::AcqRel, Ordering::Acquire)
            {
                Ok(_) => {
                    self.run_claimed(left);
                    left = self.unclaimed.0.load(Ordering::Acquire);
                }
                Err(now) => left = now,
            }
        }
    }

    /// Does the unit claimed by taking `unclaimed` from `left` to `left - 1`.
    fn run_claimed(&self, left: usize) {
        // SAFETY: this thread holds a claim, so the job is published and is not rewritten before `pending` falls
        // below (see the header).
        let job = unsafe { *self.job.get() };
        let unit = job.units - left;
        // SAFETY: `Pool::run` does not return before `pending` is zero, so the closure outlives this call.
        let f = unsafe { &*job.f };
        if let Err(payload) = catch_unwind(AssertUnwindSafe(|| f(unit))) {
            self.note_panic(unit, payload);
        }
        if self.pending.0.fetch_sub(1, Ordering::SeqCst) == 1 && self.caller_sleeps.load(Ordering::SeqCst) {
            drop(lock(&self.gate));
            self.stage_ended.notify_all();
        }
    }

    /// Keeps the panic of the lowest unit. The other payloads are leaked: a destructor could panic again, here where
    /// nobody catches it.
    fn note_panic(&self, unit: usize, payload: Box<dyn Any + Send>) {
        let mut kept = lock(&self.panicked);
        let other = match kept.take() {
            Some(first) if first.0 < unit => {
                *kept = Some(first);
                Some(payload)
            }
            replaced => {
                *kept = Some((unit, payload));
                replaced.map(|(_, payload)| payload)
            }
        };
        std::mem::forget(other);
    }

    /// Waits until units claimed by other threads are done.
    fn wait_for_end(&self) {
        for _ in 0..self.spins {
            if self.pending.0.load(Ordering::Acquire) == 0 {
                return;
            }
            hint::spin_loop();
        }
        self.caller_sleeps.store(true, Ordering::SeqCst);
        let mut gate = lock(&self.gate);
        while self.pending.0.load(Ordering::SeqCst) != 0 {
            gate = self.stage_ended.wait(gate).unwrap_or_else(PoisonError::into_inner);
        }
        drop(gate);
        self.caller_sleeps.store(false, Ordering::SeqCst);
    }

    fn worker(&self) {
        let _env = FloatEnv::set_default();
        while !self.shutdown.load(Ordering::SeqCst) {
            self.work();
            self.wait_for_work();
        }
    }

    fn wait_for_work(&self) {
        let idle = || self.unclaimed.0.load(Ordering::SeqCst) == 0 && !self.shutdown.load(Ordering::SeqCst);
        for _ in 0..self.spins {
            if !idle() {
                return;
            }
            hint::spin_loop();
        }
        self.sleepers.fetch_add(1, Ordering::SeqCst);
        let mut gate = lock(&self.gate);
        while idle() {
            gate = self.work_came.wait(gate).unwrap_or_else(PoisonError::into_inner);
        }
        drop(gate);
        self.sleepers.fetch_sub(1, Ordering::SeqCst);
    }

    /// Wakes as many sleeping workers as could find a unit.
    fn wake(&self, wanted: usize) {
        let sleepers = self.sleepers.load(Ordering::SeqCst);
        if sleepers == 0 {
            return;
        }
        drop(lock(&self.gate));
        if wanted >= sleepers {
            self.work_came.notify_all();
        } else {
            for _ in 0..wanted {
                self.work_came.notify_one();
            }
        }
    }
}

/// Threads that wait for stages; joined on drop.
pub(crate) struct Pool {
    shared: Arc<Shared>,
    workers: Vec<thread::JoinHandle<()>>,
}

impl Pool {
    /// Starts `threads - 1` workers, or as many as the system grants.
    pub(crate) fn new(threads: usize) -> Self {
        let threads = threads.min(MAX_THREADS);
        let processors = thread::available_parallelism().map_or(1, |n| n.get());
        let shared = Arc::new(Shared::new(if threads <= processors { SPINS } else { SPINS_CROWDED }));
        let start = |i: usize| {
            let shared = Arc::clone(&shared);
            thread::Builder::new().name(format!("jounce-{i}")).spawn(move || shared.worker()).ok()
        };
        let workers = (1..threads).map_while(start).collect();
        Self { shared, workers }
    }

    pub(crate) fn threads(&self) -> usize {
        self.workers.len() + 1
    }

    /// Runs a stage, or returns `false` at once if another stage has the pool.
    pub(crate) fn run(&self, units: usize, f: &(dyn Fn(usize) + Sync)) -> bool {
        let shared = &*self.shared;
        if units == 0 {
            return true;
        }
        if self.workers.is_empty() || shared.busy.swap(true, Ordering::Acquire) {
            return false;
        }
        // SAFETY: only the lifetime changes. The pointer is followed only under a claim of this stage, and this
        // function returns after all claims of this stage are done.
        let f = unsafe {
            std::mem::transmute::<&(dyn Fn(usize) + Sync), &'static (dyn Fn(usize) + Sync + 'static)>(f)
        };
        // SAFETY: this call holds `busy` and the stage before it has ended (`pending` and `unclaimed` are zero), so
        // nobody reads the job.
        unsafe { *shared.job.get() = Job { f, units } };
        shared.pending.0.store(units, Ordering::Relaxed);
        shared.unclaimed.0.store(units, Ordering::SeqCst);
        shared.wake(units - 1);
        shared.work();
        shared.wait_for_end();
        let panicked = lock(&shared.panicked).take();
        shared.busy.store(false, Ordering::Release);
        if let Some((_, payload)) = panicked {
            resume_unwind(payload);
        }
        true
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        self.shared.shutdown.store(true, Ordering::SeqCst);
        drop(lock(&self.shared.gate));
        self.shared.work_came.notify_all();
        for worker in self.workers.drain(..) {
            // A worker catches what units throw; there is nothing to learn from its result.
            let _ = worker.join();
        }
    }
}
