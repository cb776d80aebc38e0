//! Rows of a picture over threads.

use std::sync::{Mutex, PoisonError};

/// Number of threads for a request; 0 means all cores.
pub(crate) fn thread_count(asked: usize) -> usize {
    let all = || std::thread::available_parallelism().map_or(1, usize::from);
    if asked == 0 { all() } else { asked.min(256) }
}

/// Calls `f(y, row)` for every row of `width` items. Rows are handed out to whoever is free; a row's content
/// depends on nothing else, so the result does not depend on the number of threads.
pub(crate) fn rows<T: Send>(
    data: &mut [T],
    width: usize,
    threads: usize,
    f: impl Fn(usize, &mut [T]) + Sync,
) {
    let threads = thread_count(threads);
    if threads <= 1 {
        data.chunks_mut(width).enumerate().for_each(|(y, row)| f(y, row));
        return;
    }
    let todo = Mutex::new(data.chunks_mut(width).enumerate());
    let work = || {
        loop {
            let next = todo.lock().unwrap_or_else(PoisonError::into_inner).next();
            match next {
                Some((y, row)) => f(y, row),
                None => return,
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads {
            // Where the system gives no thread, this one does all rows.
            let _ = std::thread::Builder::new().spawn_scoped(scope, work);
        }
        work();
    });
}
