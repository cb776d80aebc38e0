//! The thread pool: units are claimed one by one, and a stage ends when its units are done.
//!
//! Each thread has a *share* of the stage's units, a range of its own: it claims from the front of that, and when it is
//! empty from the back of the others'. So a stage that is run again over the same items, as the passes of a solver
//! are, finds most of them in the caches of the thread that had them last, and threads that claim at the same time
//! mostly do so on lines of their own.
//!
//! A stage is published in four steps: the job is written, `pending` is set to the number of units, the shares are
//! set, and `stage` is counted up. A thread claims a unit by taking it off a share that is not empty with a
//! compare-and-swap, does it, and goes on; when it finds nothing left to claim it takes what it did from `pending`. The
//! caller claims like everybody else, and then waits for `pending` to reach zero. A worker that sleeps through
//! a whole stage is therefore never waited for.
//!
//! Why no stage number stands in a share: a claim that succeeds is a claim on the stage that is current at
//! that moment, however old the value the thread had read before, and the job is read only after the claim. That
//! stage cannot end before the claimed unit is done and counted, so the job stays valid and unchanged until then, and
//! a thread that has done units of one stage and not counted them cannot claim one of another. The swap
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
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use crate::{FloatEnv, MAX_THREADS};

/// Turns of the spin loop before a thread goes to sleep: some ten microseconds, the length of a short stage.
const SPINS: usize = 2000;
/// The same between the stages of a step, where the caller may be busy alone for that long.
const SPINS_ATTENDED: usize = 20_000;
/// Both where there are more threads than processors, and spinning takes time from those who work.
const SPINS_CROWDED: usize = 20;

/// Keeps counters that different threads hammer off each other's cache line (two lines: adjacent-line prefetch).
#[repr(align(128))]
struct Padded<T>(T);

type Job = *const (dyn Fn(usize) + Sync);

/// The units `first..end` of a stage, in one word: `first` in the low half, `end` in the high.
struct Share(AtomicU64);

impl Share {
    fn empty() -> Self {
        Self(AtomicU64::new(0))
    }

    fn set(&self, first: usize, end: usize) {
        self.0.store(first as u64 | (end as u64) << 32, Ordering::Release);
    }

    fn take_first(&self) -> Option<usize> {
        self.take(|first, end| (first, first + 1, end))
    }

    fn take_last(&self) -> Option<usize> {
        self.take(|first, end| (end - 1, first, end - 1))
    }

    /// Claims a unit, unless none is left: `split` gives the one of `first..end` that is taken, and what then remains.
    fn take(&self, split: impl Fn(u64, u64) -> (u64, u64, u64)) -> Option<usize> {
        let mut now = self.0.load(Ordering::Acquire);
        loop {
            let (first, end) = (now & u64::from(u32::MAX), now >> 32);
            if first >= end {
                return None;
            }
            let (unit, first, end) = split(first, end);
            let then = first | end << 32;
            match self.0.compare_exchange_weak(now, then, Ordering::AcqRel, Ordering::Acquire) {
                Ok(_) => return Some(unit as usize),
                Err(other) => now = other,
            }
        }
    }
}

/// The payload of a panic, and the unit it came from.
type Panicked = (usize, Box<dyn Any + Send>);

struct Shared {
    /// By thread: units of the current stage that nobody has claimed.
    shares: Box<[Padded<Share>]>,
    /// Units of the current stage that are not done, or not counted yet.
    pending: Padded<AtomicUsize>,
    /// Counts stages: changed when the shares of one are set.
    stage: Padded<AtomicUsize>,
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
    /// Calls of [`Pool::attend`] whose guards live.
    attended: AtomicUsize,
    spins: usize,
    spins_attended: usize,
}

// SAFETY: everything but `job` is Sync by itself. `job` is written only by the holder of `busy` at a moment when
// `pending` is zero, and read only by threads that hold a claim, that is while `pending` is not zero; both are ordered
// by the shares (publish, release; claim, acquire) and `pending` (done, release; end of stage, acquire). The
// closure behind the pointer is Sync, so it may be called from any thread.
unsafe impl Sync for Shared {}
// SAFETY: as above; the raw pointer is only followed under a claim.
unsafe impl Send for Shared {}

/// Locks without poisoning: no state is left half-written under these locks.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    fn new(threads: usize, [spins, spins_attended]: [usize; 2]) -> Self {
        let nothing: &'static (dyn Fn(usize) + Sync) = &|_| {};
        Self {
            shares: (0..threads).map(|_| Padded(Share::empty())).collect(),
            pending: Padded(AtomicUsize::new(0)),
            stage: Padded(AtomicUsize::new(0)),
            busy: AtomicBool::new(false),
            job: UnsafeCell::new(nothing),
            panicked: Mutex::new(None),
            sleepers: AtomicUsize::new(0),
            caller_sleeps: AtomicBool::new(false),
            shutdown: AtomicBool::new(false),
            gate: Mutex::new(()),
            work_came: Condvar::new(),
            stage_ended: Condvar::new(),
            attended: AtomicUsize::new(0),
            spins,
            spins_attended,
        }
    }

    /// Claims and does units until none is left to claim, those of thread `me` first.
    fn work(&self, me: usize) {
        let mut done = 0;
        while let Some(unit) = self.shares[me].0.take_first() {
            self.run_claimed(unit);
            done += 1;
        }
        for i in 1..self.shares.len() {
            let other = (me + i) % self.shares.len();
            while let Some(unit) = self.shares[other].0.take_last() {
                self.run_claimed(unit);
                done += 1;
            }
        }
        if done > 0
            && self.pending.0.fetch_sub(done, Ordering::SeqCst) == done
            && self.caller_sleeps.load(Ordering::SeqCst)
        {
            drop(lock(&self.gate));
            self.stage_ended.notify_all();
        }
    }

    /// Does a claimed unit.
    fn run_claimed(&self, unit: usize) {
        // SAFETY: this thread holds a claim, so the job is published and is not rewritten before the claim is counted
        // in `pending` (see the header).
        let job = unsafe { *self.job.get() };
        // SAFETY: `Pool::run` does not return before `pending` is zero, so the closure outlives this call.
        let f = unsafe { &*job };
        if let Err(payload) = catch_unwind(AssertUnwindSafe(|| f(unit))) {
            self.note_panic(unit, payload);
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

    fn worker(&self, me: usize) {
        let _env = FloatEnv::set_default();
        let mut seen = 0;
        while !self.shutdown.load(Ordering::SeqCst) {
            self.work(me);
            seen = self.wait_for_stage(seen);
        }
    }

    /// Waits for a stage after stage `seen`, and gives its number.
    fn wait_for_stage(&self, seen: usize) -> usize {
        let idle = || self.stage.0.load(Ordering::SeqCst) == seen && !self.shutdown.load(Ordering::SeqCst);
        let spins = if self.attended.load(Ordering::Relaxed) > 0 { self.spins_attended } else { self.spins };
        for _ in 0..spins {
            if !idle() {
                return self.stage.0.load(Ordering::SeqCst);
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
        self.stage.0.load(Ordering::SeqCst)
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

/// While it lives, workers wait awake for a while longer.
pub(crate) struct Attention<'a>(&'a AtomicUsize);

impl Drop for Attention<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
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
        let spins = if threads <= processors { [SPINS, SPINS_ATTENDED] } else { [SPINS_CROWDED; 2] };
        let shared = Arc::new(Shared::new(threads, spins));
        let start = |i: usize| {
            let shared = Arc::clone(&shared);
            thread::Builder::new().name(format!("jounce-{i}")).spawn(move || shared.worker(i)).ok()
        };
        let workers = (1..threads).map_while(start).collect();
        Self { shared, workers }
    }

    pub(crate) fn threads(&self) -> usize {
        self.workers.len() + 1
    }

    /// Says that stages follow each other closely until the guard drops.
    pub(crate) fn attend(&self) -> Attention<'_> {
        self.shared.attended.fetch_add(1, Ordering::Relaxed);
        Attention(&self.shared.attended)
    }

    /// Runs a stage, or returns `false` at once if another stage has the pool.
    pub(crate) fn run(&self, units: usize, f: &(dyn Fn(usize) + Sync)) -> bool {
        let shared = &*self.shared;
        if units == 0 {
            return true;
        }
        if self.workers.is_empty() || units > u32::MAX as usize || shared.busy.swap(true, Ordering::Acquire) {
            return false;
        }
        // SAFETY: only the lifetime changes. The pointer is followed only under a claim of this stage, and this
        // function returns after all claims of this stage are done.
        let f = unsafe {
            std::mem::transmute::<&(dyn Fn(usize) + Sync), &'static (dyn Fn(usize) + Sync + 'static)>(f)
        };
        // SAFETY: this call holds `busy` and the stage before it has ended (`pending` is zero, and the shares are empty), so
        // nobody reads the job.
        unsafe { *shared.job.get() = f };
        shared.pending.0.store(units, Ordering::Relaxed);
        let threads = self.threads();
        for (t, share) in shared.shares.iter().enumerate().take(threads) {
            // The caller, who is there, has the larger ones.
            let upto = |t: usize| (t * units).div_ceil(threads);
            share.0.set(upto(t), upto(t + 1));
        }
        shared.stage.0.fetch_add(1, Ordering::SeqCst);
        shared.wake(units - 1);
        shared.work(0);
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

#[cfg(test)]
mod tests {
    use super::Share;

    #[test]
    fn a_share_is_taken_from_both_ends() {
        let share = Share::empty();
        assert_eq!((share.take_first(), share.take_last()), (None, None));
        share.set(3, 7);
        let taken = [share.take_first(), share.take_last(), share.take_first(), share.take_last()];
        assert_eq!(taken, [Some(3), Some(6), Some(4), Some(5)]);
        assert_eq!((share.take_last(), share.take_first()), (None, None));
        share.set(u32::MAX as usize - 1, u32::MAX as usize);
        assert_eq!(share.take_last(), Some(u32::MAX as usize - 1));
        assert_eq!(share.take_first(), None);
    }
}
