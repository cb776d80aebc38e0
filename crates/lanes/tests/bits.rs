//! Each operation gives the same bits in every width, on instructions and on arrays, as scalar code.
//! On 1e6 pairs of random bit patterns, and with `JOUNCE_PROVE=1` on 1e8.

mod common;

use common::Random;
use jounce_lanes::{Bits, Kernel, LANES_MAX, Lanes, Mask, Width, dispatch, dispatch_arrays};

/// Where implementations tend to differ: signed zeros, the ends of the subnormals, infinities, quiet and signalling NaN.
const SPECIAL: [u32; 24] = [
    0x0000_0000,
    0x8000_0000,
    0x0000_0001,
    0x8000_0001,
    0x007f_ffff,
    0x807f_ffff,
    0x0080_0000,
    0x8080_0000,
    0x3f80_0000,
    0xbf80_0000,
    0x3f7f_ffff,
    0x3f80_0001,
    0x4000_0000,
    0x3eaa_aaab,
    0x7f7f_ffff,
    0xff7f_ffff,
    0x7f80_0000,
    0xff80_0000,
    0x7fc0_0000,
    0xffc0_0000,
    0x7fc1_2345,
    0xffff_ffff,
    0x7f80_0001,
    0x5f37_59df,
];

/// Any bit pattern; one in four a special one, one in four of ordinary size.
fn float(random: &mut Random) -> f32 {
    let bits = random.next();
    f32::from_bits(match bits >> 62 {
        0 => SPECIAL[(bits % 24) as usize],
        1 => (bits as u32 & 0x807f_ffff) | ((120 + (bits >> 32) as u32 % 16) << 23),
        _ => bits as u32,
    })
}

const ARITHMETIC: [&str; 5] = ["+", "-", "*", "/", "sqrt"];
const EXACT: [&str; 21] = [
    "neg",
    "abs",
    "min",
    "max",
    "lt",
    "le",
    "eq",
    "gt",
    "ge",
    "and",
    "or",
    "not",
    "splat",
    "copy",
    "bits +",
    "bits *",
    "bits ^",
    "<<",
    ">>",
    "bits splat",
    "signed",
];
const OPS: usize = ARITHMETIC.len() + EXACT.len();

fn name(op: usize) -> &'static str {
    ARITHMETIC.iter().chain(&EXACT).nth(op).expect("an operation")
}

/// Every operation on `LANES_MAX` pairs of numbers.
struct Apply<'a> {
    a: &'a [f32; LANES_MAX],
    b: &'a [f32; LANES_MAX],
}

impl Kernel for Apply<'_> {
    type Output = [[f32; LANES_MAX]; OPS];

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let mut out = [[0.0; LANES_MAX]; OPS];
        for first in (0..LANES_MAX).step_by(L::WIDTH) {
            let (a, b) = (L::load(&self.a[first..]), L::load(&self.b[first..]));
            let pick = |mask| L::select(mask, a, b);
            let results = [
                a + b,
                a - b,
                a * b,
                a / b,
                a.sqrt(),
                -a,
                a.abs(),
                a.min(b),
                a.max(b),
                pick(a.lt(b)),
                pick(a.le(b)),
                pick(a.eq(b)),
                pick(a.gt(b)),
                pick(a.ge(b)),
                pick(a.lt(b) & a.gt(L::zero())),
                pick(a.lt(b) | a.gt(L::zero())),
                pick(!a.lt(b)),
                L::splat(self.a[0]),
                a,
                (a.to_bits() + b.to_bits()).as_floats(),
                (a.to_bits() * b.to_bits()).as_floats(),
                (a.to_bits() ^ b.to_bits()).as_floats(),
                a.to_bits().shl::<13>().as_floats(),
                a.to_bits().shr::<9>().as_floats(),
                L::Bits::splat(self.a[0].to_bits()).as_floats(),
                a.to_bits().signed_to_floats(),
            ];
            for (out, result) in out.iter_mut().zip(results) {
                result.store(&mut out[first..]);
            }
        }
        out
    }
}

/// The same on one pair in plain scalar code, in the order of the names.
fn scalar(a: f32, b: f32, first: f32) -> [f32; OPS] {
    let pick = |mask: bool| if mask { a } else { b };
    let less = matches!(a.partial_cmp(&b), Some(std::cmp::Ordering::Less));
    [
        a + b,
        a - b,
        a * b,
        a / b,
        a.sqrt(),
        f32::from_bits(a.to_bits() ^ 0x8000_0000),
        f32::from_bits(a.to_bits() & 0x7fff_ffff),
        pick(a < b),
        pick(a > b),
        pick(a < b),
        pick(a <= b),
        pick(a == b),
        pick(a > b),
        pick(a >= b),
        pick(a < b && a > 0.0),
        pick(a < b || a > 0.0),
        pick(!less),
        first,
        a,
        f32::from_bits(a.to_bits().wrapping_add(b.to_bits())),
        f32::from_bits(a.to_bits().wrapping_mul(b.to_bits())),
        f32::from_bits(a.to_bits() ^ b.to_bits()),
        f32::from_bits(a.to_bits() << 13),
        f32::from_bits(a.to_bits() >> 9),
        first,
        a.to_bits() as i32 as f32,
    ]
}

fn check(a: &[f32; LANES_MAX], b: &[f32; LANES_MAX]) {
    let expected: [[f32; OPS]; LANES_MAX] = std::array::from_fn(|lane| scalar(a[lane], b[lane], a[0]));
    for width in Width::ALL.into_iter().filter(|w| *w <= Width::native()) {
        for got in [dispatch(width, Apply { a, b }), dispatch_arrays(width, Apply { a, b })] {
            for (op, got) in got.iter().enumerate() {
                for lane in 0..LANES_MAX {
                    let (expected, got) = (expected[lane][op], got[lane]);
                    // Which NaN arithmetic makes is the hardware's choice.
                    let both_nan = op < ARITHMETIC.len() && expected.is_nan() && got.is_nan();
                    assert!(
                        both_nan || expected.to_bits() == got.to_bits(),
                        "{} of {:#010x} and {:#010x} in {width} lanes: {:#010x}, expected {:#010x}",
                        name(op),
                        a[lane].to_bits(),
                        b[lane].to_bits(),
                        got.to_bits(),
                        expected.to_bits(),
                    );
                }
            }
        }
    }
}

#[test]
fn operations_on_special_values() {
    let special = |i: usize| f32::from_bits(SPECIAL[i % SPECIAL.len()]);
    for i in 0..SPECIAL.len() {
        for j in (0..SPECIAL.len()).step_by(LANES_MAX) {
            check(&[special(i); LANES_MAX], &std::array::from_fn(|lane| special(j + lane)));
        }
    }
}

#[test]
#[expect(clippy::disallowed_methods, reason = "the test's own threads, with numbers of their own")]
fn operations_on_random_bits() {
    let pairs = if std::env::var_os("JOUNCE_PROVE").is_some() { 100_000_000 } else { 1_000_000 };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|s| {
        for thread in 0..threads {
            s.spawn(move || {
                let mut random = Random(1 + ((thread as u64) << 48));
                for _ in 0..(pairs / LANES_MAX).div_ceil(threads) {
                    check(
                        &std::array::from_fn(|_| float(&mut random)),
                        &std::array::from_fn(|_| float(&mut random)),
                    );
                }
            });
        }
    });
}

/// Bits, any and all of a comparison, for each group of lanes.
struct Compare<'a> {
    a: &'a [f32; LANES_MAX],
    b: &'a [f32; LANES_MAX],
}

impl Kernel for Compare<'_> {
    type Output = Vec<(usize, u32, bool, bool)>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let masks = (0..LANES_MAX).step_by(L::WIDTH).map(|first| {
            let mask = L::load(&self.a[first..]).le(L::load(&self.b[first..]));
            (L::WIDTH, mask.bits(), mask.any(), mask.all())
        });
        masks.collect()
    }
}

#[test]
fn masks_as_bits() {
    let mut random = Random(2);
    for round in 0..2000 {
        let a: [f32; LANES_MAX] = std::array::from_fn(|_| float(&mut random));
        // All true, all false and mixed.
        let b = match round % 3 {
            0 => a.map(|a| if a.is_nan() { a } else { f32::INFINITY }),
            1 => [f32::NAN; LANES_MAX],
            _ => std::array::from_fn(|_| float(&mut random)),
        };
        let whole = (0..LANES_MAX).fold(0, |bits, i| bits | u32::from(a[i] <= b[i]) << i);
        for width in Width::ALL.into_iter().filter(|w| *w <= Width::native()) {
            for got in
                [dispatch(width, Compare { a: &a, b: &b }), dispatch_arrays(width, Compare { a: &a, b: &b })]
            {
                for (group, (lanes, bits, any, all)) in got.into_iter().enumerate() {
                    let ones = u32::MAX >> (32 - lanes);
                    let expected = (whole >> (group * lanes)) & ones;
                    assert_eq!((lanes, bits), (width.lanes(), expected));
                    assert_eq!((any, all), (expected != 0, expected == ones));
                }
            }
        }
    }
}

/// Gathers rows and scatters them again, with the columns seen in between.
struct Transpose<'a>(&'a [[f32; 8]; LANES_MAX]);

impl Kernel for Transpose<'_> {
    type Output = ([[f32; LANES_MAX]; 8], [[f32; 8]; LANES_MAX]);

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (mut columns, mut rows) = ([[0.0; LANES_MAX]; 8], [[0.0; 8]; LANES_MAX]);
        for first in (0..LANES_MAX).step_by(L::WIDTH) {
            let gathered = L::gather8(|lane| &self.0[first + lane]);
            for (column, gathered) in columns.iter_mut().zip(gathered) {
                gathered.store(&mut column[first..]);
            }
            L::scatter8(gathered, |lane, row| rows[first + lane] = row);
        }
        (columns, rows)
    }
}

#[test]
fn gather_and_scatter_transpose() {
    let mut random = Random(3);
    for _ in 0..1000 {
        let rows: [[f32; 8]; LANES_MAX] =
            std::array::from_fn(|_| std::array::from_fn(|_| float(&mut random)));
        for width in Width::ALL.into_iter().filter(|w| *w <= Width::native()) {
            for (columns, back) in
                [dispatch(width, Transpose(&rows)), dispatch_arrays(width, Transpose(&rows))]
            {
                for lane in 0..LANES_MAX {
                    for c in 0..8 {
                        assert_eq!(columns[c][lane].to_bits(), rows[lane][c].to_bits(), "{width} lanes");
                        assert_eq!(back[lane][c].to_bits(), rows[lane][c].to_bits(), "{width} lanes");
                    }
                }
            }
        }
    }
}

struct CountLanes;

impl Kernel for CountLanes {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self) -> usize {
        L::WIDTH
    }
}

#[test]
fn dispatch_gives_the_width_asked_for_or_the_next_narrower_one() {
    for width in Width::ALL {
        assert_eq!(dispatch(width, CountLanes), width.min(Width::native()).lanes());
        assert_eq!(dispatch_arrays(width, CountLanes), width.lanes());
        assert_eq!(Width::from_lanes(width.lanes()), Some(width));
        assert_eq!(LANES_MAX % width.lanes(), 0);
    }
    assert_eq!(Width::from_lanes(2), None);
    assert_eq!(Width::native().to_string(), Width::native().lanes().to_string());
}

struct LoadShort;

impl Kernel for LoadShort {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut to = vec![0.0; L::WIDTH - 1];
        let load = std::panic::catch_unwind(|| L::load(&vec![0.0; L::WIDTH - 1]).lt(L::zero()).any());
        assert!(load.is_err());
        let store = std::panic::catch_unwind(move || L::zero().store(&mut to));
        assert!(store.is_err());
    }
}

#[test]
fn short_slices_are_refused() {
    for width in Width::ALL {
        dispatch(width, LoadShort);
        dispatch_arrays(width, LoadShort);
    }
}
