//! Bodies that all overlap make pairs without end: 4,000 boxes of 1 m in a grid of 0.2 m took 9.3 GB. And one shape that many
//! bodies lie in made every list of the pair search as long as its own.

use jounce::prelude::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
/// Both tests count the same bytes.
static ALONE: Mutex<()> = Mutex::new(());

fn more(size: usize) {
    let now = NOW.fetch_add(size, Ordering::SeqCst) + size;
    PEAK.fetch_max(now, Ordering::SeqCst);
}

// SAFETY: forwards to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        more(layout.size());
        // SAFETY: promised by the caller.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Ordering::SeqCst);
        // SAFETY: promised by the caller.
        unsafe { System.dealloc(at, layout) }
    }
    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // While it is copied, both are there.
        more(size);
        NOW.fetch_sub(layout.size(), Ordering::SeqCst);
        // SAFETY: promised by the caller.
        unsafe { System.realloc(at, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Most bytes that `f` holds at a time.
fn peak_of<T>(f: impl FnOnce() -> T) -> (usize, T) {
    let before = NOW.load(Ordering::SeqCst);
    PEAK.store(before, Ordering::SeqCst);
    let result = f();
    (PEAK.load(Ordering::SeqCst) - before, result)
}

#[test]
fn a_pair_takes_a_bounded_number_of_bytes() {
    let _alone = ALONE.lock().expect("no panic while held");
    let side = std::env::var("JOUNCE_CROWD_SIDE").map_or(8, |s| s.parse().expect("a number"));
    let (peak, counts) = peak_of(|| {
        let mut w = World::new(WorldDesc::default()).expect("valid");
        for i in 0..side * side * side {
            let at = [i % side, i / side % side, i / (side * side)].map(|k| 0.2 * f64::from(k));
            w.add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid([0.5; 3]))).expect("a box");
        }
        for _ in 0..3 {
            w.step().expect("steps");
        }
        w.counts()
    });
    let each = peak / counts.contacts;
    println!("{} pairs, {} touch, {} MB: {each} bytes each", counts.contacts, counts.touching, peak >> 20);
    assert!(counts.touching > 180 * counts.bodies, "they overlap: {counts:?}");
    // Record about 0.5 KB and solver row 0.8 KB, with a quarter for growth and the old list while it is copied.
    assert!(each < 2000, "{each} bytes for each of {} pairs", counts.contacts);
}

/// A block around 20,000 bodies finds a pair with each, and its unit's list is long.
#[test]
fn a_long_list_of_pairs_leaves_the_others_short() {
    let _alone = ALONE.lock().expect("no panic while held");
    let build = |around: bool| {
        let mut w = World::new(WorldDesc::default()).expect("valid");
        let block = ShapeDesc::cuboid([100.0; 3]);
        let at = [0.0, if around { 0.0 } else { -500.0 }, 0.0];
        w.add_body(BodyDesc::fixed().at(at).shape(block)).expect("a block");
        for i in 0..20_000 {
            let at = [i % 200, i / 200 % 100, 0].map(|k| 0.5 * f64::from(k) - 40.0);
            let ball = ShapeDesc::sphere(0.05);
            w.add_body(BodyDesc::dynamic().at(at).shape(ball)).expect("a ball");
        }
        w
    };
    let step = |mut w: World| {
        let (peak, ()) = peak_of(|| w.step().expect("steps"));
        (peak, w.counts().contacts)
    };
    let (alone, none) = step(build(false));
    let (peak, pairs) = step(build(true));
    assert_eq!((none, pairs), (0, 20_000));
    let each = (peak - alone.min(peak)) / pairs;
    println!("{each} bytes for each of {pairs} pairs");
    assert!(each < 3000, "{each} bytes for each of {pairs} pairs");
}
