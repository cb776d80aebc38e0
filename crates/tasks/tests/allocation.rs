//! A stage allocates nothing.

use std::alloc::{GlobalAlloc, Layout, System};
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use jounce_tasks::{ColorSets, Scatter, Tasks};

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: forwards to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::SeqCst);
        // SAFETY: promised by the caller.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: promised by the caller.
        unsafe { System.dealloc(at, layout) }
    }
    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::SeqCst);
        // SAFETY: promised by the caller.
        unsafe { System.realloc(at, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// A step's worth of everything, on buffers that are already large enough.
fn step(tasks: &Tasks, sets: &mut ColorSets, items: &mut [f32], sums: &mut Vec<f32>) {
    tasks.for_each(items, 16, |i, item| *item += i as f32);
    tasks.map_chunks(items.len(), 16, sums, |range: Range<usize>| range.len() as f32);
    sets.reset(items.len());
    for i in 0..items.len() as u32 - 1 {
        sets.push(i, i + 1, i);
    }
    for color in 0..sets.colors() {
        let blocks = &mut sums[..sets.rows(color).len().div_ceil(8)];
        let swap = |access: &mut Scatter<'_, f32>, rows: Range<usize>, _: &mut f32| {
            for row in rows {
                let (a, b) = access.load(row);
                access.store(row, b, a);
            }
        };
        sets.scatter(color, tasks, 8, items, 0.0, blocks, swap);
    }
}

/// Returns when every thread has started: starting one allocates.
fn meet(tasks: &Tasks) {
    let begun = AtomicUsize::new(0);
    tasks.run(tasks.threads(), &|_| {
        begun.fetch_add(1, Ordering::SeqCst);
        while begun.load(Ordering::SeqCst) < tasks.threads() {
            std::thread::yield_now();
        }
    });
}

fn main() {
    // One at a time, so that no other pool is starting its threads.
    let schedulers: [fn() -> Tasks; 4] =
        [Tasks::serial, || Tasks::pool(3), || Tasks::chaos(1), || Tasks::chaos_pool(3, 1)];
    for make in schedulers {
        let tasks = make();
        let (mut sets, mut items, mut sums) = (ColorSets::new(), vec![0.0; 3000], Vec::with_capacity(3000));
        meet(&tasks);
        step(&tasks, &mut sets, &mut items, &mut sums);
        let before = ALLOCATIONS.load(Ordering::SeqCst);
        for _ in 0..200 {
            step(&tasks, &mut sets, &mut items, &mut sums);
        }
        assert_eq!(ALLOCATIONS.load(Ordering::SeqCst) - before, 0, "{tasks:?}");
    }
}
