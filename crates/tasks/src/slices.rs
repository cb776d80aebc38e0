//! Slices cut into chunks of fixed length, one unit each.
//!
//! Unit `u` owns the elements `u * chunk .. min(len, (u + 1) * chunk)`. These ranges do not overlap, every unit is
//! run exactly once, and the slice is borrowed for the whole stage: so each unit may hold its chunk mutably.
//!
//! Items that lie in another order than the rows they belong to go with them as [`Owning`]: a list says which row owns
//! each item, and the items of a unit are those that its rows own.

use std::marker::PhantomData;
use std::ops::Range;

use crate::Tasks;

/// The base of a slice that units cut their own pieces from.
pub struct Base<T>(*mut T);

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

/// What a stage cuts into one piece for each unit, by rows: slices with an element for each row, [`Owning`], and several of these together.
///
/// # Safety
/// Pieces of disjoint ranges within [`rows`](Self::rows) must be usable at the same time on different threads.
pub unsafe trait Cut {
    /// What all units share.
    type Whole: Sync;
    /// What a unit gets.
    type Piece;
    /// How many rows there are; `None` if that is for others to say.
    fn rows(&self) -> Option<usize>;
    /// Ready to be cut.
    fn whole(self) -> Self::Whole;
    /// The piece of a range of rows.
    ///
    /// # Safety
    /// `range` lies inside the rows, and no other piece with one of them exists.
    unsafe fn piece(whole: &Self::Whole, range: &Range<usize>) -> Self::Piece;
}

// SAFETY: elements of disjoint ranges are disjoint, and T is Send.
unsafe impl<'a, T: Send> Cut for &'a mut [T] {
    type Whole = Base<T>;
    type Piece = &'a mut [T];
    fn rows(&self) -> Option<usize> {
        Some(self.len())
    }
    fn whole(self) -> Base<T> {
        Base(self.as_mut_ptr())
    }
    #[inline(always)]
    unsafe fn piece(whole: &Base<T>, range: &Range<usize>) -> &'a mut [T] {
        // SAFETY: promised by the caller; the slice is borrowed for `'a`.
        unsafe { whole.piece(range) }
    }
}

// SAFETY: elements are only read, and T is Sync.
unsafe impl<'a, T: Sync> Cut for &'a [T] {
    type Whole = &'a [T];
    type Piece = &'a [T];
    fn rows(&self) -> Option<usize> {
        Some(self.len())
    }
    fn whole(self) -> &'a [T] {
        self
    }
    #[inline(always)]
    unsafe fn piece(whole: &&'a [T], range: &Range<usize>) -> &'a [T] {
        &whole[range.clone()]
    }
}

/// Items and, for each, the row that owns it; any other number where none does. Items beyond the shorter of both lists are out of reach.
pub struct Owning<'a, T>(pub &'a mut [T], pub &'a [u32]);

/// The items of a unit's rows.
pub struct Owned<'a, T> {
    items: *mut T,
    owners: &'a [u32],
    rows: Range<usize>,
    borrow: PhantomData<&'a mut [T]>,
}

impl<T> Owned<'_, T> {
    /// Item `item`, if row `row` owns it and is one of this unit's.
    #[inline(always)]
    pub fn get(&mut self, row: usize, item: usize) -> Option<&mut T> {
        if !self.rows.contains(&row) || self.owners.get(item).is_none_or(|o| *o as usize != row) {
            return None;
        }
        // SAFETY: `owners` is no longer than the items, so `item` lies inside. An item has one owner and rows of different pieces are disjoint, so
        // no other piece reaches it; of this one, the reference borrows `self`.
        Some(unsafe { &mut *self.items.add(item) })
    }
}

// SAFETY: an item has one owner, so items of disjoint ranges of rows are disjoint, and T is Send.
unsafe impl<'a, T: Send> Cut for Owning<'a, T> {
    type Whole = (Base<T>, &'a [u32]);
    type Piece = Owned<'a, T>;
    fn rows(&self) -> Option<usize> {
        None
    }
    fn whole(self) -> Self::Whole {
        let reach = self.0.len().min(self.1.len());
        (Base(self.0.as_mut_ptr()), &self.1[..reach])
    }
    #[inline(always)]
    unsafe fn piece((items, owners): &Self::Whole, range: &Range<usize>) -> Owned<'a, T> {
        Owned { items: items.0, owners, rows: range.clone(), borrow: PhantomData }
    }
}

macro_rules! cut_together {
    ($($column:ident $C:ident),+) => {
        // SAFETY: as for each of them.
        unsafe impl<$($C: Cut),+> Cut for ($($C,)+) {
            type Whole = ($($C::Whole,)+);
            type Piece = ($($C::Piece,)+);
            fn rows(&self) -> Option<usize> {
                let ($($column,)+) = self;
                let mut rows = None;
                $(if let Some(n) = $column.rows() {
                    assert!(rows.is_none_or(|r| r == n), "columns of different lengths");
                    rows = Some(n);
                })+
                rows
            }
            fn whole(self) -> Self::Whole {
                let ($($column,)+) = self;
                ($($column.whole(),)+)
            }
            #[inline(always)]
            unsafe fn piece(($($column,)+): &Self::Whole, range: &Range<usize>) -> Self::Piece {
                // SAFETY: promised by the caller.
                unsafe { ($($C::piece($column, range),)+) }
            }
        }
    };
}

cut_together!(a A, b B);
cut_together!(a A, b B, c C);
cut_together!(a A, b B, c C, d D);
cut_together!(a A, b B, c C, d D, e E);

fn range(unit: usize, chunk: usize, len: usize) -> Range<usize> {
    let first = unit * chunk;
    first..(len - first).min(chunk) + first
}

impl Tasks {
    /// Calls `f(first row, piece)` for the pieces of `chunk` rows of whatever can be cut (the last may be shorter; a `chunk` of 0 counts as 1).
    ///
    /// # Panics
    /// If slices that are cut together differ in length.
    pub fn for_each_piece<C: Cut>(&self, columns: C, chunk: usize, f: impl Fn(usize, C::Piece) + Sync) {
        let (len, chunk) = (columns.rows().unwrap_or(0), chunk.max(1));
        let whole = &columns.whole();
        self.run(len.div_ceil(chunk), &|unit| {
            let range = range(unit, chunk, len);
            // SAFETY: ranges of different units are disjoint and each unit is run once.
            f(range.start, unsafe { C::piece(whole, &range) });
        });
    }

    /// Calls `f(first index, chunk)` for every chunk of `chunk` elements (the last may be shorter; a `chunk` of 0
    /// counts as 1).
    pub fn for_each_chunk<T: Send>(&self, items: &mut [T], chunk: usize, f: impl Fn(usize, &mut [T]) + Sync) {
        self.for_each_piece(items, chunk, f);
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
                self.for_each_piece(($($column),+), chunk, |first, ($($column),+)| f(first, $($column),+));
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

#[cfg(test)]
mod tests {
    use super::Owning;
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
            let columns = (&mut a[..], &mut b[..], &mut c[..], &mut d[..], &mut e[..]);
            tasks.for_each_piece(columns, 10, |first, (a, b, c, d, e)| {
                for i in 0..a.len() {
                    let n = (first + i) as u64;
                    (c[i], d[i], e[i]) = ((a[i] + u64::from(b[i]) + n) as u8, n as u16, -i64::from(b[i]));
                }
            });
            for i in 0..333u64 {
                let (x, y) = ((1 + i) * 2, 1 + 2 * i);
                let i = i as usize;
                assert_eq!((a[i], b[i] as u64), (x, y));
                assert_eq!((c[i], d[i], e[i]), ((x + y + i as u64) as u8, i as u16, -(y as i64)));
            }
        }
    }

    /// Items of a row are reached from that row and its unit, and from nowhere else.
    #[test]
    fn items_go_with_their_owners() {
        for tasks in schedulers() {
            let rows = 300;
            // Row r owns item (7 r + 3) mod 600; the others say a row that does not exist.
            let item = |row: usize| (7 * row + 3) % 600;
            let mut owners = vec![u32::MAX; 500];
            for row in (0..rows).filter(|r| item(*r) < 500) {
                owners[item(row)] = row as u32;
            }
            let mut items = vec![0usize; 600];
            let mut told = vec![false; rows];
            tasks.for_each_piece(
                (&mut told[..], Owning(&mut items, &owners)),
                9,
                |first, (told, mut own)| {
                    for (i, told) in told.iter_mut().enumerate() {
                        let row = first + i;
                        if let Some(mine) = own.get(row, item(row)) {
                            *mine += row + 1;
                            *told = true;
                        }
                        let other = (row + 1) % rows;
                        assert!(own.get(row, item(other)).is_none(), "of another row");
                        assert!(
                            own.get((row + 9) % rows, item((row + 9) % rows)).is_none(),
                            "of another unit"
                        );
                        assert!(own.get(row, usize::MAX).is_none());
                    }
                },
            );
            for row in 0..rows {
                assert_eq!(told[row], item(row) < 500);
                assert_eq!(items[item(row)], if told[row] { row + 1 } else { 0 });
            }
            assert_eq!(items.iter().filter(|i| **i > 0).count(), told.iter().filter(|t| **t).count());
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
