//! Graph colouring of constraint rows, and scattered writes that it makes safe.
//!
//! A *row* is a constraint between two *items* (bodies). Rows of one colour touch disjoint items, so all rows of a
//! colour may be solved at once, and in any order, with the same bits: Gauss-Seidel between colours, Jacobi within
//! one that has nothing to disagree about. (Tonge, "Solving rigid body contacts", GDC 2012; Smelyanskiy et al.,
//! "High-performance physical simulations on next-generation architecture with many cores", 2007.)
//!
//! The colour is the lowest free one of both items, found with one bit mask per item; it depends on the order of
//! [`ColorSets::push`] alone. Rows with one written item take the highest free colour instead, from a range whose top
//! rows with two written items may not use. Later colours win where constraints contradict each other, and a body
//! pressed into the ground should lose against the ground. Rows that find no colour go to the overflow list, which is
//! solved one after another.
//!
//! # Why scattered access is sound
//! Each item has a mask, written only here. `push` gives a row colour `c` only if bit `c` is clear in the masks of
//! all items it writes, and then sets it, and refuses a row that names one item twice: hence **within a colour, each
//! item is written by at most one row**. Bit 31 marks items that are only read: it is set by a row that names the item
//! as [`shared`](ColorSets::shared), and excludes every other bit: hence **no row reads an item that a row of the same
//! set writes, unless it is its own**. Rows and masks are private and change only through `push`, `close` (which moves
//! rows within a colour) and `reset`, which cannot be called during a stage because that borrows the set. `push` refuses indices outside `0..items`, and
//! [`ColorSets::scatter`] refuses a slice shorter than that. Each unit of the stage gets a [`Scatter`] for its own rows
//! alone, and [`Scatter`] checks every row it is asked for against them and hands out mutable access only through
//! `&mut self`. So no two threads, and no two live references, reach an item that one of them may write.

use std::marker::PhantomData;
use std::ops::Range;

use crate::Tasks;

/// A row: two items and whatever number the caller wants to find the constraint by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    a: u32,
    b: u32,
    payload: u32,
}

impl Row {
    /// First item, as pushed: an index, a [`shared`](ColorSets::shared) index or [`ColorSets::NONE`].
    pub fn a(&self) -> u32 {
        self.a
    }

    /// Second item, as pushed.
    pub fn b(&self) -> u32 {
        self.b
    }

    /// The caller's number.
    pub fn payload(&self) -> u32 {
        self.payload
    }
}

/// Rows by colour. See the module's text for what is promised.
#[derive(Clone, Debug)]
pub struct ColorSets {
    /// Per item: bits `0..COLORS` colours in use, `WRITTEN_LATE` written by an overflow row, `READ_ONLY`.
    masks: Vec<u32>,
    /// `COLORS` colours, then the overflow list.
    rows: [Vec<Row>; ColorSets::COLORS + 1],
    /// Of each colour the rows of kinds above 0, until they are put behind the others.
    behind: [[Vec<Row>; ColorSets::KINDS - 1]; ColorSets::COLORS],
}

const READ_ONLY: u32 = 1 << 31;
const WRITTEN_LATE: u32 = 1 << ColorSets::COLORS;
const COLOR_BITS: u32 = WRITTEN_LATE - 1;
/// Colours open to rows with two written items; those above are kept for rows with one.
const PAIR_COLORS: u32 = 20;

/// Rows to a unit of work, if blocks are smaller: the best part of a microsecond of contact solving, against a claim's tenth of one.
const ROWS_PER_UNIT: usize = 32;

/// What a row does with one of its items.
enum Access {
    Nothing,
    Read(usize),
    Write(usize),
}

impl Default for ColorSets {
    fn default() -> Self {
        Self::new()
    }
}

impl ColorSets {
    /// Number of regular colours.
    pub const COLORS: usize = 24;
    /// The colour that [`push`](Self::push) reports for overflow rows.
    pub const OVERFLOW: u8 = Self::COLORS as u8;
    /// Kinds of rows that may be told apart within a colour.
    pub const KINDS: usize = 4;
    /// In place of an item: nothing is written, and reading gives the `fixed` value of the stage.
    pub const NONE: u32 = u32::MAX;
    /// Items must be fewer than this.
    pub const ITEMS_MAX: usize = SHARED as usize - 1;

    /// No items, no rows.
    pub fn new() -> Self {
        Self {
            masks: Vec::new(),
            rows: [const { Vec::new() }; Self::COLORS + 1],
            behind: [const { [const { Vec::new() }; Self::KINDS - 1] }; Self::COLORS],
        }
    }

    /// In place of an item: `item` is read by this row and written by no row of the set (a kinematic body).
    pub const fn shared(item: u32) -> u32 {
        item | SHARED
    }

    /// The index that an item names, shared or not; `None` for [`NONE`](Self::NONE).
    #[inline]
    pub const fn index(item: u32) -> Option<usize> {
        if item == Self::NONE { None } else { Some((item & !SHARED) as usize) }
    }

    /// Forgets all rows and starts again with items `0..items` (at most [`ITEMS_MAX`](Self::ITEMS_MAX)). Allocations
    /// are kept.
    pub fn reset(&mut self, items: usize) {
        debug_assert!(items <= Self::ITEMS_MAX);
        self.masks.clear();
        self.masks.resize(items.min(Self::ITEMS_MAX), 0);
        self.rows.iter_mut().chain(self.behind.as_flattened_mut()).for_each(Vec::clear);
    }

    /// Adds a row between two items; each is an index, a [`shared`](Self::shared) index or [`NONE`](Self::NONE).
    /// Gives its colour ([`OVERFLOW`](Self::OVERFLOW) if none was free) and its place among the rows of that colour.
    ///
    /// `None`, and nothing is added, if the row writes no item, names one twice, names one out of range, or names an
    /// item as shared that another row writes (or the other way round).
    pub fn push(&mut self, a: u32, b: u32, payload: u32) -> Option<(u8, u32)> {
        self.push_kind(0, a, b, payload)
    }

    /// The same of a row of a kind below [`KINDS`](Self::KINDS) (others count as the last). Its colour does not depend on its kind, but within
    /// the colour rows of a kind lie together once [`close`](Self::close) was called, which matters to nobody who asks for one colour after the
    /// other: its rows are disjoint. Overflow rows keep their order. Gives the colour, and the place among the rows of both.
    pub fn push_kind(&mut self, kind: usize, a: u32, b: u32, payload: u32) -> Option<(u8, u32)> {
        let (access_a, access_b) = (self.access(a)?, self.access(b)?);
        let mask = |access: &Access| if let Access::Write(i) = access { self.masks[*i] } else { 0 };
        let free = !(mask(&access_a) | mask(&access_b)) & COLOR_BITS;
        let color = match (&access_a, &access_b) {
            (Access::Write(i), Access::Write(j)) if i == j => return None,
            (Access::Write(i), Access::Read(j)) | (Access::Read(i), Access::Write(j)) if i == j => {
                return None;
            }
            // Lowest first, and none of the reserved ones.
            (Access::Write(_), Access::Write(_)) => (free & ((1 << PAIR_COLORS) - 1)).trailing_zeros(),
            // Highest first. Colour 0 stays open to pairs, which fill the set from below.
            (Access::Write(_), _) | (_, Access::Write(_)) => {
                u32::BITS.wrapping_sub((free & !1).leading_zeros() + 1)
            }
            _ => return None,
        };
        let color = color.min(Self::COLORS as u32);
        for access in [access_a, access_b] {
            match access {
                Access::Write(i) => self.masks[i] |= 1 << color,
                Access::Read(i) => self.masks[i] |= READ_ONLY,
                Access::Nothing => {}
            }
        }
        let kind = if color == Self::COLORS as u32 { 0 } else { kind.min(Self::KINDS - 1) };
        let rows = match kind.checked_sub(1) {
            Some(k) => &mut self.behind[color as usize][k],
            None => &mut self.rows[color as usize],
        };
        rows.push(Row { a, b, payload });
        Some((color as u8, rows.len() as u32 - 1))
    }

    /// Puts the rows of each kind behind those of the kinds before it. Until then, [`rows`](Self::rows) gives those of kind 0.
    pub fn close(&mut self) {
        for (rows, kinds) in self.rows.iter_mut().zip(&mut self.behind) {
            kinds.iter_mut().for_each(|more| rows.append(more));
        }
    }

    /// What a row may do with `item`, or `None` if the item is out of range or in use the other way.
    fn access(&self, item: u32) -> Option<Access> {
        if item == Self::NONE {
            return Some(Access::Nothing);
        }
        let index = (item & !SHARED) as usize;
        let mask = *self.masks.get(index)?;
        match item & SHARED != 0 {
            true => (mask & !READ_ONLY == 0).then_some(Access::Read(index)),
            false => (mask & READ_ONLY == 0).then_some(Access::Write(index)),
        }
    }

    /// One more than the highest regular colour that has rows.
    pub fn colors(&self) -> usize {
        (0..Self::COLORS).rev().find(|&c| !self.rows[c].is_empty()).map_or(0, |c| c + 1)
    }

    /// Rows of a colour in push order; empty for a colour that does not exist. The colour
    /// [`OVERFLOW`](Self::OVERFLOW) is the overflow list.
    pub fn rows(&self, color: usize) -> &[Row] {
        self.rows.get(color).map_or(&[], Vec::as_slice)
    }

    /// Rows that found no colour, in push order.
    pub fn overflow(&self) -> &[Row] {
        &self.rows[Self::COLORS]
    }

    /// Items given to [`reset`](Self::reset).
    pub fn items(&self) -> usize {
        self.masks.len()
    }

    /// Solves a colour: calls `f(access, rows, block)` for every block of `block` rows (the last may be shorter);
    /// several small blocks make a unit of the stage. `blocks[i]` belongs to rows `i * block ..`; `access` reaches the items of those rows
    /// and no others. Rows whose item is [`NONE`](Self::NONE) read `fixed`.
    ///
    /// # Panics
    /// If `block` is 0, `items` is shorter than [`items`](Self::items), `color` is not a regular colour, or
    /// `blocks.len()` is not the number of blocks.
    pub fn scatter<T: Copy + Send + Sync, R: Send>(
        &self,
        color: usize,
        tasks: &Tasks,
        block: usize,
        items: &mut [T],
        fixed: T,
        blocks: &mut [R],
        f: impl Fn(&mut Scatter<'_, T>, Range<usize>, &mut R) + Sync,
    ) {
        assert!(color < Self::COLORS, "colour {color} is not a regular colour");
        assert!(items.len() >= self.masks.len(), "{} items, but rows name {}", items.len(), self.masks.len());
        let rows = self.rows(color);
        assert!(block > 0, "blocks of no rows");
        assert_eq!(blocks.len(), rows.len().div_ceil(block), "blocks of {block} for {} rows", rows.len());
        let base = Items(items.as_mut_ptr());
        let (base, fixed) = (&base, &fixed);
        tasks.for_each(blocks, (ROWS_PER_UNIT / block).max(1), |i, data| {
            let first = i * block;
            let part = &rows[first..rows.len().min(first + block)];
            let mut access = Scatter { rows: part, first, items: base.0, fixed, borrow: PhantomData };
            f(&mut access, first..first + part.len(), data);
        });
    }

    /// Solves the overflow list: calls `f(access, row, block)` for its rows one after another, in push order; `blocks[i]`
    /// belongs to rows `i * block ..`.
    ///
    /// # Panics
    /// If `block` is 0, `items` is shorter than [`items`](Self::items), or `blocks.len()` is not the number of blocks.
    pub fn scatter_overflow<T: Copy, R>(
        &self,
        block: usize,
        items: &mut [T],
        fixed: T,
        blocks: &mut [R],
        mut f: impl FnMut(&mut Scatter<'_, T>, usize, &mut R),
    ) {
        assert!(items.len() >= self.masks.len(), "{} items, but rows name {}", items.len(), self.masks.len());
        let rows = self.overflow();
        assert!(block > 0, "blocks of no rows");
        assert_eq!(blocks.len(), rows.len().div_ceil(block), "blocks of {block} for the overflow list");
        let base = items.as_mut_ptr();
        for i in 0..rows.len() {
            let mut access =
                Scatter { rows: &rows[i..=i], first: i, items: base, fixed: &fixed, borrow: PhantomData };
            f(&mut access, i, &mut blocks[i / block]);
        }
    }
}

const SHARED: u32 = 1 << 31;

struct Items<T>(*mut T);

// SAFETY: threads reach items through `Scatter` only: written items by one thread (T is Send), items that are only read
// by several (T is Sync). The module's text says why.
unsafe impl<T: Send + Sync> Sync for Items<T> {}

/// Access to the items of the rows of one unit. Rows are named by their place in the colour.
///
/// Reading borrows the access, so references to items stay valid until the next store; wide code may gather from
/// them directly.
pub struct Scatter<'a, T> {
    rows: &'a [Row],
    first: usize,
    items: *mut T,
    fixed: &'a T,
    borrow: PhantomData<&'a mut [T]>,
}

impl<T: Copy> Scatter<'_, T> {
    /// The row itself.
    ///
    /// # Panics
    /// Like every access below: if the row is not one of this unit's.
    #[inline]
    pub fn row(&self, row: usize) -> Row {
        self.rows[row.wrapping_sub(self.first)]
    }

    #[inline]
    fn read(&self, item: u32) -> &T {
        if item == ColorSets::NONE {
            return self.fixed;
        }
        // SAFETY: `item` comes from a row of this unit, so its index is below the number of items, and nobody else
        // writes it during the stage; a store through this access needs `&mut self`, which ends this borrow.
        unsafe { &*self.items.add((item & !SHARED) as usize) }
    }

    #[inline]
    fn write(&mut self, item: u32, value: T) {
        // NONE has the shared bit as well.
        if item & SHARED == 0 {
            // SAFETY: `item` comes from a row of this unit and is written by no other row of the colour; no
            // reference to it is alive, because those borrow `self`. T is Copy, so nothing is dropped.
            unsafe { self.items.add(item as usize).write(value) };
        }
    }

    /// First item of a row.
    #[inline]
    pub fn a(&self, row: usize) -> &T {
        self.read(self.row(row).a)
    }

    /// Second item of a row.
    #[inline]
    pub fn b(&self, row: usize) -> &T {
        self.read(self.row(row).b)
    }

    /// Copies of both items of a row.
    #[inline]
    pub fn load(&self, row: usize) -> (T, T) {
        let row = self.row(row);
        (*self.read(row.a), *self.read(row.b))
    }

    /// Both items of the rows `row .. row + n`, or `fixed` past the last row and `N`: one check for all of them.
    #[inline(always)]
    pub fn gather<const N: usize>(&self, row: usize, n: usize) -> [[&T; 2]; N] {
        let mut items = [[self.fixed; 2]; N];
        let rows = &self.rows[row.wrapping_sub(self.first)..];
        let n = n.min(N);
        if let Some(rows) = rows.get(..n) {
            for i in 0..n {
                items[i] = [self.read(rows[i].a), self.read(rows[i].b)];
            }
        } else {
            for (items, row) in items.iter_mut().zip(rows) {
                *items = [self.read(row.a), self.read(row.b)];
            }
        }
        items
    }

    /// The same to be written; `None` also where an item is shared or [`ColorSets::NONE`].
    #[inline(always)]
    pub fn gather_mut<const N: usize>(&mut self, row: usize, n: usize) -> [[Option<&mut T>; 2]; N] {
        let mut items = [const { [None, None] }; N];
        let rows = &self.rows[row.wrapping_sub(self.first)..];
        let base = self.items;
        let of = |item: u32| {
            // SAFETY: `item` comes from a row of this unit and is written by no other row of the colour, nor by the other side of its own; no
            // other reference to it is alive, because those borrow `self`, which these do as well.
            (item & SHARED == 0).then(|| unsafe { &mut *base.add(item as usize) })
        };
        let n = n.min(N);
        if let Some(rows) = rows.get(..n) {
            for i in 0..n {
                items[i] = [of(rows[i].a), of(rows[i].b)];
            }
        } else {
            for (items, row) in items.iter_mut().zip(rows) {
                *items = [of(row.a), of(row.b)];
            }
        }
        items
    }

    /// Writes the first item of a row; nothing happens where it is shared or [`ColorSets::NONE`].
    #[inline]
    pub fn store_a(&mut self, row: usize, value: T) {
        self.write(self.row(row).a, value);
    }

    /// Writes the second item of a row; nothing happens where it is shared or [`ColorSets::NONE`].
    #[inline]
    pub fn store_b(&mut self, row: usize, value: T) {
        self.write(self.row(row).b, value);
    }

    /// Writes both items of a row; those that are shared or [`ColorSets::NONE`] are left alone.
    #[inline]
    pub fn store(&mut self, row: usize, a: T, b: T) {
        self.store_a(row, a);
        self.store_b(row, b);
    }
}
