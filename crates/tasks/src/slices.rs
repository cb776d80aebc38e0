//! Slices cut into chunks of fixed length, one unit each.
//!
//! Unit `u` owns the elements `u * chunk .. min(len, (u + 1) * chunk)`. These ranges do not overlap, every unit is
//! run exactly once, and the slice is borrowed for the whole stage: so each unit may hold its chunk mutably.

use std::ops::Range;

use crate::Tasks;

/// The base of a slice that units cut their own pieces from.
struct Base<T>(*mut T);

// SAFETY: units on other threads make `&mut T` to disjoint elements only, which is sending them: T is Send.
unsafe impl<T: Send> Sync for Base<T> {}

impl<T> Base<T> {
    /// # Safety
    /// `range` lies inside the slice, the slice is borrowed mutably for `'a`, and no other reference to these
    /// elements exists during `'a`.
    unsafe fn piece<'a>(&self, range: &Range<usize>) -> &'a mut [T] {
        // SAFETY: promised by the caller.
        unsafe { std::slice::from_raw_parts_mut(self.0.add(range.start), range.len()) }
    }
}

fn range(unit: usize, chunk: usize, len: usize) -> Range<usize> {
    let first = unit * chunk;
    first..(len - first).min(chunk) + first
}

impl Tasks {
    /// Calls `f(first index, chunk)` for every chunk of `chunk` elements (the last may be shorter; a `chunk` of 0
    /// counts as 1).
    pub fn for_each_chunk<T: Send>(&self, items: &mut [T], chunk: usize, f: impl Fn(usize, &mut [T]) + Sync) {
        let (len, chunk) = (items.len(), chunk.max(1));
        let base = Base(items.as_mut_ptr());
        let base = &base;
        self.run(len.div_ceil(chunk), &|unit| {
            let range = range(unit, chunk, len);
            // SAFETY: ranges of different units are disjoint and each unit is run once; `items` is borrowed until
            // `run` returns.
            f(range.start, unsafe { base.piece(&range) });
        });
    }

    /// Calls `f(index, element)` for every element; `chunk` elements make a unit.
    pub fn for_each<T: Send>(&self, items: &mut [T], chunk: usize, f: impl Fn(usize, &mut T) + Sync) {
        self.for_each_chunk(items, chunk, |first, part| {
            for (i, item) in part.iter_mut().enumerate() {
                f(first + i, item);
            }
        });
    }

    /// Fills `out` with `f(range)` for the chunks of `0..len`, in order of the chunks, whoever did them. What was in
    /// `out` is dropped; its allocation is kept.
    ///
    /// If `f` panics, `out` is left empty and the results that were made are leaked.
    pub fn map_chunks<R: Send>(
        &self,
        len: usize,
        chunk: usize,
        out: &mut Vec<R>,
        f: impl Fn(Range<usize>) -> R + Sync,
    ) {
        let chunk = chunk.max(1);
        let units = len.div_ceil(chunk);
        out.clear();
        out.reserve(units);
        let base = Base(out.spare_capacity_mut().as_mut_ptr());
        let base = &base;
        self.run(units, &|unit| {
            let result = f(range(unit, chunk, len));
            // SAFETY: `units` elements were reserved, each unit writes its own, and `out` is borrowed until `run`
            // returns.
            let [slot] = (unsafe { base.piece(&(unit..unit + 1)) }) else { return };
            slot.write(result);
        });
        // SAFETY: `run` returned without a panic, so every unit has written its element.
        unsafe { out.set_len(units) };
    }
}

/// Two methods that walk several slices side by side, by chunks and by elements.
macro_rules! side_by_side {
    ($chunks:ident, $name:ident: $($column:ident $T:ident),+) => {
        impl Tasks {
            /// Calls `f(first index, …)` for the chunks of several slices side by side.
            ///
            /// # Panics
            /// If the lengths differ.
            pub fn $chunks<$($T: Send),+>(
                &self,
                ($($column),+): ($(&mut [$T]),+),
                chunk: usize,
                f: impl Fn(usize, $(&mut [$T]),+) + Sync,
            ) {
                let lens = [$($column.len()),+];
                assert!(lens.iter().all(|l| *l == lens[0]), "columns of different lengths");
                let (len, chunk) = (lens[0], chunk.max(1));
                $(let $column = &Base($column.as_mut_ptr());)+
                self.run(len.div_ceil(chunk), &|unit| {
                    let range = range(unit, chunk, len);
                    // SAFETY: as in `for_each_chunk`, for each of the slices; their lengths are equal.
                    f(range.start, $(unsafe { $column.piece(&range) }),+);
                });
            }

            /// Calls `f(index, …)` for the elements of several slices side by side; `chunk` elements make a unit.
            ///
            /// # Panics
            /// If the lengths differ.
            pub fn $name<$($T: Send),+>(
                &self,
                ($($column),+): ($(&mut [$T]),+),
                chunk: usize,
                f: impl Fn(usize, $(&mut $T),+) + Sync,
            ) {
                self.$chunks(($($column),+), chunk, |first, $($column),+| {
                    let len = [$($column.len()),+][0];
                    for i in 0..len {
                        f(first + i, $(&mut $column[i]),+);
                    }
                });
            }
        }
    };
}

side_by_side!(for_each_chunk2, for_each2: a A, b B);
side_by_side!(for_each_chunk3, for_each3: a A, b B, c C);
side_by_side!(for_each_chunk5, for_each5: a A, b B, c C, d D, e E);

#[cfg(test)]
mod tests {
    use crate::Tasks;

    fn schedulers() -> [Tasks; 4] {
        [Tasks::serial(), Tasks::pool(4), Tasks::chaos(3), Tasks::chaos_pool(3, 5)]
    }

    #[test]
    fn chunks_have_the_layout_asked_for() {
        for tasks in schedulers() {
            for (len, chunk) in [(0, 4), (1, 4), (4, 4), (5, 4), (1000, 7), (10, 0), (3, usize::MAX)] {
                let mut items = vec![(0, 0); len];
                tasks.for_each_chunk(&mut items, chunk, |first, part| {
                    let length = part.len();
                    part.iter_mut().enumerate().for_each(|(i, item)| *item = (first + i, length));
                });
                let chunk = chunk.max(1);
                for (i, &(index, length)) in items.iter().enumerate() {
                    let first = i / chunk * chunk;
                    assert_eq!((index, length), (i, chunk.min(len - first)), "{tasks:?} {len} {chunk}");
                }
            }
        }
    }

    #[test]
    fn columns_go_side_by_side() {
        for tasks in schedulers() {
            let (mut a, mut b, mut c) = (vec![1u64; 333], vec![2u32; 333], vec![3u8; 333]);
            let (mut d, mut e) = (vec![0u16; 333], vec![0i64; 333]);
            tasks.for_each(&mut a, 10, |i, a| *a += i as u64);
            tasks.for_each2((&mut a, &mut b), 10, |i, a, b| (*a, *b) = (*a * 2, *a as u32 + i as u32));
            tasks.for_each5((&mut a, &mut b, &mut c, &mut d, &mut e), 10, |i, a, b, c, d, e| {
                (*c, *d, *e) = ((*a + *b as u64 + i as u64) as u8, i as u16, -(*b as i64));
            });
            for i in 0..333u64 {
                let (x, y) = ((1 + i) * 2, 1 + 2 * i);
                let i = i as usize;
                assert_eq!((a[i], b[i] as u64), (x, y));
                assert_eq!((c[i], d[i], e[i]), ((x + y + i as u64) as u8, i as u16, -(y as i64)));
            }
        }
    }

    #[test]
    fn results_come_in_unit_order() {
        for tasks in schedulers() {
            let mut out = vec![String::from("old")];
            tasks.map_chunks(103, 10, &mut out, |range| format!("{range:?}"));
            assert_eq!(out.len(), 11);
            assert_eq!((out[0].as_str(), out[10].as_str()), ("0..10", "100..103"));
            tasks.map_chunks(0, 10, &mut out, |range| format!("{range:?}"));
            assert!(out.is_empty());
        }
    }
}
