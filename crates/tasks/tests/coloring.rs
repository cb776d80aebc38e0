//! Rows of one colour are disjoint, and scattering gives the same bits under every scheduler.
#![allow(clippy::disallowed_types, reason = "the oracle of a test may use a set")]

use std::collections::BTreeSet;
use std::ops::Range;

use jounce_tasks::{ColorSets, Scatter, Tasks};
use proptest::prelude::*;

const SHARED_BIT: u32 = 1 << 31;

fn written(item: u32) -> Option<u32> {
    (item & SHARED_BIT == 0).then_some(item)
}

fn shared(item: u32) -> Option<u32> {
    (item != ColorSets::NONE && item & SHARED_BIT != 0).then_some(item & !SHARED_BIT)
}

/// Mostly plain items, with all the special and wrong ones mixed in.
fn item(items: u32) -> impl Strategy<Value = u32> {
    prop_oneof![
        8 => 0..items,
        1 => Just(ColorSets::NONE),
        1 => (0..items).prop_map(ColorSets::shared),
        1 => any::<u32>(),
    ]
}

fn pushes(items: Range<u32>, rows: Range<usize>) -> impl Strategy<Value = (u32, Vec<(u32, u32)>)> {
    items.prop_flat_map(move |items| {
        (Just(items), prop::collection::vec((item(items), item(items)), rows.clone()))
    })
}

fn fill(items: u32, pushes: &[(u32, u32)]) -> (ColorSets, Vec<Option<(u8, u32)>>) {
    let mut sets = ColorSets::new();
    sets.reset(items as usize);
    let places = (0..).zip(pushes).map(|(i, &(a, b))| sets.push(a, b, i)).collect();
    (sets, places)
}

/// An order-dependent mixing of two numbers, so that a wrong order or a lost write shows.
fn blend(a: f32, b: f32, row: u32) -> (f32, f32) {
    let weight = 0.25 + (row % 7) as f32 * 0.1;
    (a + (b - a) * weight + 0.01, b + (a - b) * weight - 0.02)
}

fn solve(sets: &ColorSets, tasks: &Tasks, block: usize, items: &mut [f32]) -> Vec<f32> {
    let mut trace = Vec::new();
    for color in 0..sets.colors() {
        let mut sums = vec![0.0f32; sets.rows(color).len().div_ceil(block)];
        sets.scatter(
            color,
            tasks,
            block,
            items,
            0.5,
            &mut sums,
            |access: &mut Scatter<'_, f32>, rows: Range<usize>, sum| {
                for row in rows {
                    let (a, b) = access.load(row);
                    assert_eq!((*access.a(row), *access.b(row)), (a, b));
                    let (a, b) = blend(a, b, access.row(row).payload());
                    access.store(row, a, b);
                    *sum += a * b;
                }
            },
        );
        trace.extend(sums);
    }
    let mut late = vec![0.0f32; sets.overflow().len()];
    sets.scatter_overflow(1, items, 0.5, &mut late, |access, row, out| {
        let (a, b) = access.load(row);
        let (a, b) = blend(a, b, access.row(row).payload());
        access.store(row, a, b);
        *out = a * b;
    });
    trace.extend(late);
    trace
}

/// The same without the crate: rows in order, one after another.
fn solve_plainly(sets: &ColorSets, items: &mut [f32]) {
    let lists = (0..ColorSets::COLORS).map(|c| sets.rows(c)).chain([sets.overflow()]);
    for row in lists.flatten() {
        let read =
            |item: u32| if item == ColorSets::NONE { 0.5 } else { items[(item & !SHARED_BIT) as usize] };
        let (a, b) = blend(read(row.a()), read(row.b()), row.payload());
        for (item, value) in [(row.a(), a), (row.b(), b)] {
            if let Some(i) = written(item) {
                items[i as usize] = value;
            }
        }
    }
}

proptest! {
    #[test]
    fn rows_of_a_color_are_disjoint((items, pushes) in pushes(1..40, 0..400)) {
        let (sets, places) = fill(items, &pushes);
        let (mut read, mut wrote) = (BTreeSet::new(), BTreeSet::new());
        for color in 0..=ColorSets::COLORS {
            let mut here = BTreeSet::new();
            for row in sets.rows(color) {
                prop_assert!(written(row.a()).is_some() || written(row.b()).is_some());
                for item in [row.a(), row.b()].into_iter().filter_map(written) {
                    prop_assert!(item < items);
                    let first = here.insert(item);
                    prop_assert!(first || color == ColorSets::COLORS, "item {item} twice in colour {color}");
                    wrote.insert(item);
                }
                prop_assert_ne!(row.a(), row.b());
                read.extend([row.a(), row.b()].into_iter().filter_map(shared));
            }
        }
        prop_assert!(read.is_disjoint(&wrote));
        prop_assert!(read.iter().all(|&item| item < items));
        // Every row that was accepted is where push said.
        for (i, place) in places.iter().enumerate() {
            if let &Some((color, row)) = place {
                let row = sets.rows(color as usize)[row as usize];
                prop_assert_eq!((row.payload() as usize, row.a(), row.b()), (i, pushes[i].0, pushes[i].1));
            }
        }
        let total: usize = (0..=ColorSets::COLORS).map(|c| sets.rows(c).len()).sum();
        prop_assert_eq!(total, places.iter().flatten().count());
    }

    #[test]
    fn scatter_gives_the_same_bits_under_every_scheduler(
        (items, pushes) in prop_oneof![pushes(1..40, 0..400), pushes(900..1000, 0..3000)],
        block in prop_oneof![1usize..9, Just(16), Just(100)],
    ) {
        let (sets, _) = fill(items, &pushes);
        let start: Vec<f32> = (0..items).map(|i| (i * i % 17) as f32 * 0.37).collect();
        let mut plain = start.clone();
        solve_plainly(&sets, &mut plain);
        let mut first_trace = None;
        for tasks in [Tasks::serial(), Tasks::pool(3), Tasks::chaos(9), Tasks::chaos_pool(2, 4)] {
            let mut end = start.clone();
            let trace = solve(&sets, &tasks, block, &mut end);
            prop_assert_eq!(&end, &plain, "{:?}", tasks);
            prop_assert_eq!(first_trace.get_or_insert_with(|| trace.clone()), &trace);
        }
    }
}

proptest! {
    /// Kinds change neither colours nor who is refused; within a colour the rows of a kind lie together, in the order in which they came, where
    /// they were said to be; overflow rows keep their order.
    #[test]
    fn rows_of_a_kind_lie_together((items, pushes) in pushes(1..40, 0..400), seed in any::<u32>()) {
        let kind_of = |i: usize| ((seed.wrapping_mul(2 * i as u32 + 1) >> 13) % 5) as usize;
        let (plain, colors) = fill(items, &pushes);
        let mut sets = ColorSets::new();
        for _ in 0..2 {
            sets.reset(items as usize);
            let push = |(i, &(a, b)): (usize, &(u32, u32))| sets.push_kind(kind_of(i), a, b, i as u32);
            let places: Vec<_> = pushes.iter().enumerate().map(push).collect();
            sets.close();
            for (i, (place, color)) in places.iter().zip(&colors).enumerate() {
                prop_assert_eq!(place.map(|p| p.0), color.map(|c| c.0));
                let Some((color, row)) = *place else { continue };
                let rows = sets.rows(usize::from(color));
                let kind = |i: usize| if rows == sets.overflow() { 0 } else { kind_of(i).min(ColorSets::KINDS - 1) };
                let before = rows.iter().filter(|r| kind(r.payload() as usize) < kind(i)).count();
                prop_assert_eq!(rows[before + row as usize].payload() as usize, i);
            }
            for color in 0..ColorSets::COLORS {
                let key = |r: &jounce_tasks::Row| (kind_of(r.payload() as usize).min(ColorSets::KINDS - 1), r.payload());
                prop_assert!(sets.rows(color).is_sorted_by_key(key));
                prop_assert_eq!(sets.rows(color).len(), plain.rows(color).len());
            }
            prop_assert_eq!(sets.overflow(), plain.overflow());
        }
    }
}

#[test]
fn rows_with_two_written_items_fill_from_below_and_those_with_one_from_above() {
    let mut sets = ColorSets::new();
    sets.reset(100);
    assert_eq!(sets.push(0, 1, 0), Some((0, 0)));
    assert_eq!(sets.push(2, 3, 0), Some((0, 1)));
    assert_eq!(sets.push(0, 3, 0), Some((1, 0)));
    assert_eq!(sets.push(0, ColorSets::NONE, 0), Some((23, 0)));
    assert_eq!(sets.push(ColorSets::NONE, 1, 0), Some((23, 1)));
    assert_eq!(sets.push(1, ColorSets::shared(50), 0), Some((22, 0)));
    assert_eq!(sets.colors(), 24);
}

#[test]
fn a_hub_overflows_and_the_reserved_colors_stay_free_for_single_rows() {
    let mut sets = ColorSets::new();
    sets.reset(100);
    let colors: Vec<u8> = (1..30).map(|i| sets.push(0, i, 0).unwrap().0).collect();
    assert_eq!(colors[..20], (0..20).collect::<Vec<u8>>());
    assert!(colors[20..].iter().all(|&c| c == ColorSets::OVERFLOW));
    assert_eq!(sets.overflow().len(), 9);
    let singles: Vec<u8> = (0..6).map(|_| sets.push(ColorSets::NONE, 0, 0).unwrap().0).collect();
    assert_eq!(singles, [23, 22, 21, 20, ColorSets::OVERFLOW, ColorSets::OVERFLOW]);
}

#[test]
fn rows_that_could_not_be_kept_apart_are_refused() {
    let mut sets = ColorSets::new();
    sets.reset(10);
    let (none, shared) = (ColorSets::NONE, ColorSets::shared);
    for (a, b) in
        [(3, 3), (0, 10), (10, 0), (none, none), (none, shared(1)), (shared(1), shared(2)), (1, shared(1))]
    {
        assert_eq!(sets.push(a, b, 0), None, "{a:#x} {b:#x}");
    }
    assert_eq!(sets.push(1, shared(10), 0), None);
    assert!(sets.push(1, shared(2), 0).is_some());
    assert_eq!(sets.push(2, 4, 0), None, "written although another row reads it as shared");
    assert_eq!(sets.push(3, shared(1), 0), None, "shared although another row writes it");
    // An overflow row counts as well.
    (0..30).for_each(|_| assert!(sets.push(5, 6, 0).is_some()));
    assert_eq!(sets.push(3, shared(6), 0), None);
    sets.reset(10);
    assert!(sets.push(3, shared(1), 0).is_some(), "reset forgets");
    assert_eq!(sets.colors(), 24);
}

/// [`solve`] of the regular colours, four rows at a time: both items of each are asked for at once.
fn solve_gathered(sets: &ColorSets, tasks: &Tasks, block: usize, items: &mut [f32]) {
    for color in 0..sets.colors() {
        let mut blocks = vec![(); sets.rows(color).len().div_ceil(block)];
        sets.scatter(color, tasks, block, items, 0.5, &mut blocks, |access, rows, ()| {
            for row in rows.clone().step_by(4) {
                let read = access.gather::<4>(row, 4).map(|pair| pair.map(|x| *x));
                let mut new = [[0.0; 2]; 4];
                for i in 0..4 {
                    if row + i >= rows.end {
                        assert_eq!(read[i], [0.5; 2], "past the last row");
                        continue;
                    }
                    let (a, b) = blend(read[i][0], read[i][1], access.row(row + i).payload());
                    new[i] = [a, b];
                }
                for (i, pair) in access.gather_mut::<4>(row, 4).into_iter().enumerate() {
                    assert!(row + i < rows.end || pair.iter().all(Option::is_none), "past the last row");
                    for (to, x) in pair.into_iter().zip(new[i]) {
                        if let Some(to) = to {
                            *to = x;
                        }
                    }
                }
            }
        });
    }
}

proptest! {
    #[test]
    fn gathered_items_are_those_of_the_rows((items, pushes) in pushes(2..40, 0..60)) {
        let (sets, _) = fill(items, &pushes);
        let start: Vec<f32> = (0..items).map(|i| (i % 13) as f32 * 0.7).collect();
        // The overflow list is not gathered: both go without.
        prop_assume!(sets.overflow().is_empty());
        for block in [1, 3, 4, 16] {
            let (mut one_by_one, mut gathered) = (start.clone(), start.clone());
            solve(&sets, &Tasks::serial(), block, &mut one_by_one);
            solve_gathered(&sets, &Tasks::serial(), block, &mut gathered);
            prop_assert_eq!(&one_by_one, &gathered);
        }
    }
}

#[test]
fn a_row_of_another_unit_is_out_of_reach() {
    let mut sets = ColorSets::new();
    sets.reset(8);
    (0..4).for_each(|i| assert_eq!(sets.push(2 * i, 2 * i + 1, 0), Some((0, i))));
    let reach = |row: usize| {
        std::panic::catch_unwind(|| {
            let mut items = [0.0f32; 8];
            sets.scatter(0, &Tasks::serial(), 2, &mut items, 0.0, &mut [(), ()], |access, rows, ()| {
                if rows.start == 2 {
                    access.store_a(row, 1.0);
                }
            });
            items
        })
    };
    assert_eq!(reach(2).unwrap()[4], 1.0);
    assert_eq!(reach(3).unwrap()[6], 1.0);
    for row in [0, 1, 4, usize::MAX] {
        assert!(reach(row).is_err(), "row {row}");
    }
}
