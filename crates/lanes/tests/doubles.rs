//! Each operation on `f64` lanes gives the same bits in every width as scalar code, and rows come back as they were gathered.

mod common;

use common::Random;
use jounce_lanes::{DOUBLES_MAX, Doubles, Kernel, Lanes, Mask, Width, dispatch, dispatch_arrays};

/// Where implementations tend to differ: signed zeros, subnormals, the ends of the range, infinities, quiet and signalling NaN.
const SPECIAL: [u64; 16] = [
    0x0000_0000_0000_0000,
    0x8000_0000_0000_0000,
    0x0000_0000_0000_0001,
    0x8000_0000_0000_0001,
    0x000f_ffff_ffff_ffff,
    0x0010_0000_0000_0000,
    0x3ff0_0000_0000_0000,
    0xbff0_0000_0000_0000,
    0x3fef_ffff_ffff_ffff,
    0x3fd5_5555_5555_5555,
    0x7fef_ffff_ffff_ffff,
    0xffef_ffff_ffff_ffff,
    0x7ff0_0000_0000_0000,
    0xfff0_0000_0000_0000,
    0x7ff8_0000_0000_0000,
    0x7ff0_0000_0000_0001,
];

/// Any bit pattern; one in four a special one, one in four of ordinary size.
fn double(random: &mut Random) -> f64 {
    let bits = random.next();
    f64::from_bits(match bits >> 62 {
        0 => SPECIAL[(bits % 16) as usize],
        1 => (bits & 0x800f_ffff_ffff_ffff) | ((1016 + (bits >> 52) % 16) << 52),
        _ => random.next(),
    })
}

const NAMES: [&str; 14] =
    ["+", "-", "*", "/", "sqrt", "neg", "abs", "lt", "le", "eq", "gt", "and or not", "splat", "zero"];
const ARITHMETIC: usize = 5;

/// Every operation on pairs of numbers, the bits of a comparison, and a row of four gathered and scattered.
struct Apply<'a> {
    a: &'a [f64; DOUBLES_MAX],
    b: &'a [f64; DOUBLES_MAX],
    rows: &'a [[f64; 4]; DOUBLES_MAX],
}

#[derive(Default)]
struct Got {
    results: [[f64; DOUBLES_MAX]; NAMES.len()],
    less: u32,
    all: u32,
    columns: [[f64; DOUBLES_MAX]; 4],
    rows: [[f64; 4]; DOUBLES_MAX],
    width: usize,
}

impl Kernel for Apply<'_> {
    type Output = Got;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Got {
        run::<L::Doubles>(self)
    }
}

#[inline(always)]
fn run<D: Doubles>(Apply { a: all_a, b: all_b, rows }: Apply<'_>) -> Got {
    let mut got = Got { width: D::WIDTH, ..Got::default() };
    for first in (0..DOUBLES_MAX).step_by(D::WIDTH) {
        let (a, b) = (D::load(&all_a[first..]), D::load(&all_b[first..]));
        let pick = |mask| D::select(mask, a, b);
        let results = [
            a + b,
            a - b,
            a * b,
            a / b,
            a.sqrt(),
            -a,
            a.abs(),
            pick(a.lt(b)),
            pick(a.le(b)),
            pick(a.eq(b)),
            pick(a.gt(b)),
            pick((a.lt(b) & b.gt(D::zero())) | !a.le(b)),
            D::splat(all_a[0]),
            D::zero(),
        ];
        for (out, result) in got.results.iter_mut().zip(results) {
            result.store(&mut out[first..]);
        }
        let less = a.lt(b);
        got.less |= less.bits() << first;
        got.all |= u32::from(less.all()) << first;
        let columns = D::gather4(|lane| rows[first + lane]);
        for (out, column) in got.columns.iter_mut().zip(columns) {
            column.store(&mut out[first..]);
        }
        D::scatter4(columns, |lane, row| got.rows[first + lane] = row);
    }
    got
}

fn scalar(a: f64, b: f64, first: f64) -> [f64; NAMES.len()] {
    let pick = |mask: bool| if mask { a } else { b };
    let after = !matches!(a.partial_cmp(&b), Some(std::cmp::Ordering::Less | std::cmp::Ordering::Equal));
    [
        a + b,
        a - b,
        a * b,
        a / b,
        a.sqrt(),
        f64::from_bits(a.to_bits() ^ (1 << 63)),
        f64::from_bits(a.to_bits() & !(1 << 63)),
        pick(a < b),
        pick(a <= b),
        pick(a == b),
        pick(a > b),
        pick((a < b && b > 0.0) || after),
        first,
        0.0,
    ]
}

fn check(a: &[f64; DOUBLES_MAX], b: &[f64; DOUBLES_MAX], rows: &[[f64; 4]; DOUBLES_MAX]) {
    for width in Width::ALL.into_iter().filter(|w| *w <= Width::native()) {
        for got in [dispatch(width, Apply { a, b, rows }), dispatch_arrays(width, Apply { a, b, rows })] {
            for lane in 0..DOUBLES_MAX {
                for (op, expected) in scalar(a[lane], b[lane], a[0]).into_iter().enumerate() {
                    let result = got.results[op][lane];
                    // Which NaN arithmetic makes is the hardware's choice.
                    let both_nan = op < ARITHMETIC && expected.is_nan() && result.is_nan();
                    let (name, x, y) = (NAMES[op], a[lane], b[lane]);
                    assert!(
                        both_nan || expected.to_bits() == result.to_bits(),
                        "{name} of {x} and {y} in {width} lanes: {result}, expected {expected}"
                    );
                }
                for c in 0..4 {
                    assert_eq!(got.columns[c][lane].to_bits(), rows[lane][c].to_bits(), "{width} lanes");
                    assert_eq!(got.rows[lane][c].to_bits(), rows[lane][c].to_bits(), "{width} lanes");
                }
            }
            let less = (0..DOUBLES_MAX).fold(0, |bits, i| bits | (u32::from(a[i] < b[i]) << i));
            assert_eq!(got.less, less, "{width} lanes");
            for first in (0..DOUBLES_MAX).step_by(got.width) {
                let ones = u32::MAX >> (32 - got.width);
                assert_eq!((got.all >> first) & 1 == 1, (less >> first) & ones == ones, "{width} lanes");
            }
        }
    }
}

#[test]
fn operations_on_special_values() {
    let special = |i: usize| f64::from_bits(SPECIAL[i % SPECIAL.len()]);
    let rows = std::array::from_fn(|i| std::array::from_fn(|c| special(i + 3 * c)));
    for i in 0..SPECIAL.len() {
        for j in (0..SPECIAL.len()).step_by(DOUBLES_MAX) {
            check(&[special(i); DOUBLES_MAX], &std::array::from_fn(|lane| special(j + lane)), &rows);
        }
    }
}

#[test]
fn operations_on_random_bits() {
    let mut random = Random(7);
    for round in 0..30_000 {
        let a: [f64; DOUBLES_MAX] = std::array::from_fn(|_| double(&mut random));
        // All less, all equal, mixed.
        let b = match round % 4 {
            0 => a.map(|_| f64::INFINITY),
            1 => a,
            _ => std::array::from_fn(|_| double(&mut random)),
        };
        check(&a, &b, &std::array::from_fn(|_| std::array::from_fn(|_| double(&mut random))));
    }
}
