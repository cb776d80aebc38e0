//! Wide floats: one kernel, written once, in 1, 4, 8 or 16 lanes, with the same bits in each.
//!
//! A kernel is generic over [`Lanes`] and is started with [`dispatch`], which picks the instruction set at run time:
//! SSE2, AVX2 or AVX-512F on x86-64, NEON on ARM64, simd128 on wasm, and the next narrower one where a width is
//! missing. All operations are the IEEE 754 ones, rounded once each: there is no fused multiply-add, no
//! approximation, no reduction across lanes. A lane never reads another lane, so the width cannot change a result as
//! long as a kernel gives each row a lane of its own. (The payload and sign of a NaN that arithmetic *makes* are the
//! hardware's; they are not part of the promise.)
//!
//! ```
//! use jounce_lanes::{Kernel, Lanes, Width, dispatch};
//!
//! struct Scale<'a> { factor: f32, values: &'a mut [f32] }
//!
//! impl Kernel for Scale<'_> {
//!     type Output = ();
//!     #[inline(always)]
//!     fn run<L: Lanes>(self) {
//!         for chunk in self.values.chunks_exact_mut(L::WIDTH) {
//!             (L::load(chunk) * L::splat(self.factor)).store(chunk);
//!         }
//!     }
//! }
//!
//! let mut values = [1.5; 32];
//! dispatch(Width::detect(), Scale { factor: 2.0, values: &mut values });
//! assert_eq!(values, [3.0; 32]);
//! ```
//!
//! A kernel, and all it calls with lanes in hand, is `#[inline(always)]`: code becomes wide by being inlined into the entry
//! point that has the instruction set switched on. A function that stays outside is correct and slow, and so is a
//! closure: write `#[inline(always)] |lane| …` (measured: 69.9 ns instead of 8.6 for a contact at 8 lanes).
//!
//! Data that kernels read should be laid out in groups of [`LANES_MAX`] whatever the width, so that the layout does
//! not depend on the machine.

mod array;
mod doubles;
#[cfg(target_arch = "aarch64")]
mod neon;
mod vectors;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod wasm;
mod width;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

pub use array::{Array, ArrayBits, ArrayMask};
pub use doubles::{DOUBLES_MAX, Double, Doubles};
pub use vectors::Wide3;
pub use width::Width;

/// The widest width; every width divides it.
pub const LANES_MAX: usize = 16;

mod sealed {
    /// Implementations stay in this crate: their soundness rests on [`crate::dispatch`].
    pub trait Sealed {}
}

/// One truth value per lane.
pub trait Mask:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> + sealed::Sealed
{
    /// Bit `i` is lane `i`; the bits above the width are zero.
    fn bits(self) -> u32;
    /// Whether any lane is true.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    /// Whether all lanes are true.
    fn all(self) -> bool;
}

/// `u32`s, one per lane; arithmetic wraps.
pub trait Bits:
    Copy + Add<Output = Self> + Mul<Output = Self> + BitXor<Output = Self> + sealed::Sealed
{
    /// The floats of as many lanes.
    type Floats: Lanes<Bits = Self>;

    /// `x` in every lane.
    fn splat(x: u32) -> Self;
    /// Shifted to the left by `N` < 32 bits.
    fn shl<const N: u32>(self) -> Self;
    /// Shifted to the right by `N` < 32 bits; zeros come in.
    fn shr<const N: u32>(self) -> Self;
    /// The floats with these bits.
    fn as_floats(self) -> Self::Floats;
    /// The value as an `i32`, rounded to the nearest float (ties to even).
    fn signed_to_floats(self) -> Self::Floats;
}

/// `WIDTH` floats, and operations on each of them.
pub trait Lanes:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + sealed::Sealed
{
    /// What comparisons give.
    type Mask: Mask;
    /// As many `u32`: for hashes.
    type Bits: Bits<Floats = Self>;
    /// `f64`s in registers of the same size: half as many.
    type Doubles: Doubles;
    /// Number of lanes: 1, 4, 8 or 16.
    const WIDTH: usize;

    /// `x` in every lane.
    fn splat(x: f32) -> Self;
    /// The first `WIDTH` elements.
    ///
    /// # Panics
    /// If there are fewer.
    fn load(from: &[f32]) -> Self;
    /// Writes the first `WIDTH` elements.
    ///
    /// # Panics
    /// If there are fewer.
    fn store(self, to: &mut [f32]);
    /// The square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// Clears the sign bit, of NaN too.
    fn abs(self) -> Self;
    /// `if self < other { self } else { other }`: the other where either is NaN or both are zeros.
    fn min(self, other: Self) -> Self;
    /// `if self > other { self } else { other }`: the other where either is NaN or both are zeros.
    fn max(self, other: Self) -> Self;
    /// `self < other`; false for NaN, as in all comparisons here.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self == other`.
    fn eq(self, other: Self) -> Self::Mask;
    /// Lanes of `yes` where the mask is true, of `no` where it is false.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The bits of each float.
    fn to_bits(self) -> Self::Bits;

    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// 0 in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// Loads one row of eight floats per lane, transposed: lane `i` of column `c` is `row(i)[c]`.
    #[inline(always)]
    fn gather8<'a>(row: impl Fn(usize) -> &'a [f32; 8]) -> [Self; 8] {
        let mut columns = [[0.0; LANES_MAX]; 8];
        for lane in 0..Self::WIDTH {
            let row = row(lane);
            for c in 0..8 {
                columns[c][lane] = row[c];
            }
        }
        let mut out = [Self::zero(); 8];
        for c in 0..8 {
            out[c] = Self::load(&columns[c]);
        }
        out
    }

    /// [`gather8`](Self::gather8) of rows that are made, not lent.
    #[inline(always)]
    fn gather8_of(row: impl Fn(usize) -> [f32; 8]) -> [Self; 8] {
        let mut rows = [[0.0; 8]; LANES_MAX];
        for lane in 0..Self::WIDTH {
            rows[lane] = row(lane);
        }
        Self::gather8(
            #[inline(always)]
            |lane| &rows[lane],
        )
    }

    /// The reverse of [`gather8`](Self::gather8): calls `put(lane, row)` for every lane in order.
    #[inline(always)]
    fn scatter8(columns: [Self; 8], mut put: impl FnMut(usize, [f32; 8])) {
        let mut flat = [[0.0; LANES_MAX]; 8];
        for c in 0..8 {
            columns[c].store(&mut flat[c]);
        }
        for lane in 0..Self::WIDTH {
            let mut row = [0.0; 8];
            for c in 0..8 {
                row[c] = flat[c][lane];
            }
            put(lane, row);
        }
    }
}

/// Asks for the cache lines of `of`, which will be read soon. Changes nothing but time.
#[inline(always)]
pub fn prefetch<T>(of: &T) {
    #[cfg(target_arch = "x86_64")]
    for at in (0..size_of::<T>()).step_by(64) {
        // SAFETY: a prefetch reads nothing and cannot fault; the address lies within `of`. SSE is part of the target.
        unsafe {
            use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            _mm_prefetch::<_MM_HINT_T0>(core::ptr::from_ref(of).cast::<i8>().add(at));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = of;
}

/// A piece of work written for any width.
pub trait Kernel {
    /// What it returns.
    type Output;
    /// Does the work. Must be `#[inline(always)]` to be fast.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// f of 0, 1 and 2. What `[0, 1, 2].map(f)` gives; but that is a call where the compiler thinks it is large, and then its lanes go through
/// memory.
#[inline(always)]
pub fn three<T>(f: impl Fn(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

/// f of 0 to 5, like [`three`].
#[inline(always)]
pub fn six<T>(f: impl Fn(usize) -> T) -> [T; 6] {
    [f(0), f(1), f(2), f(3), f(4), f(5)]
}

/// Runs `kernel` in lanes of `width`, or of the next narrower width that this machine has instructions for: a kernel walks its data
/// by [`Lanes::WIDTH`], so it is complete at any. (Wide arrays in place of missing instructions are slower than narrow ones, and
/// every width that is compiled in costs as much compile time as all the others.)
pub fn dispatch<K: Kernel>(width: Width, kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    match width {
        Width::X1 => {}
        // SAFETY: the feature that the entry point needs was just detected.
        Width::X16 if x86::has_avx512() => return unsafe { x86::enter_avx512(kernel) },
        // SAFETY: likewise.
        Width::X8 | Width::X16 if x86::has_avx2() => return unsafe { x86::enter_avx2(kernel) },
        _ => return x86::enter_sse2(kernel),
    }
    #[cfg(target_arch = "aarch64")]
    if width != Width::X1 {
        return kernel.run::<neon::F32x4>();
    }
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    if width != Width::X1 {
        return kernel.run::<wasm::F32x4>();
    }
    let _ = width;
    kernel.run::<Array<1>>()
}

/// Runs `kernel` on plain arrays of `width` floats: what [`dispatch`] is tested against.
pub fn dispatch_arrays<K: Kernel>(width: Width, kernel: K) -> K::Output {
    match width {
        Width::X1 => kernel.run::<Array<1>>(),
        Width::X4 => kernel.run::<Array<4>>(),
        Width::X8 => kernel.run::<Array<8>>(),
        Width::X16 => kernel.run::<Array<16>>(),
    }
}
