//! Wide `f64`s: half as many lanes in the same registers.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::{ArrayMask, Mask, sealed};

/// The most `f64`s abreast; every width divides it.
pub const DOUBLES_MAX: usize = 8;

/// `WIDTH` `f64`s, and operations on each of them: what [`Lanes`](crate::Lanes) is for `f32`s, with the same promise.
pub trait Doubles:
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
    /// Number of lanes: 1, 2, 4 or 8.
    const WIDTH: usize;

    /// `x` in every lane.
    fn splat(x: f64) -> Self;
    /// The first `WIDTH` elements.
    ///
    /// # Panics
    /// If there are fewer.
    fn load(from: &[f64]) -> Self;
    /// Writes the first `WIDTH` elements.
    ///
    /// # Panics
    /// If there are fewer.
    fn store(self, to: &mut [f64]);
    /// The square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// Clears the sign bit, of NaN too.
    fn abs(self) -> Self;
    /// `self < other`; false for NaN, as in all comparisons here.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self == other`.
    fn eq(self, other: Self) -> Self::Mask;
    /// Lanes of `yes` where the mask is true, of `no` where it is false.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// 0 in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// Loads one row of four per lane, transposed: lane `i` of column `c` is `row(i)[c]`.
    #[inline(always)]
    fn gather4(row: impl Fn(usize) -> [f64; 4]) -> [Self; 4] {
        let mut columns = [[0.0; DOUBLES_MAX]; 4];
        for lane in 0..Self::WIDTH {
            let row = row(lane);
            for c in 0..4 {
                columns[c][lane] = row[c];
            }
        }
        let [a, b, c, d] = &columns;
        [Self::load(a), Self::load(b), Self::load(c), Self::load(d)]
    }

    /// The reverse of [`gather4`](Self::gather4): calls `put(lane, row)` for every lane in order.
    #[inline(always)]
    fn scatter4(columns: [Self; 4], mut put: impl FnMut(usize, [f64; 4])) {
        let mut flat = [[0.0; DOUBLES_MAX]; 4];
        for c in 0..4 {
            columns[c].store(&mut flat[c]);
        }
        for lane in 0..Self::WIDTH {
            put(lane, [flat[0][lane], flat[1][lane], flat[2][lane], flat[3][lane]]);
        }
    }
}

/// One `f64` alone: what plain arrays of any width have.
#[derive(Clone, Copy, Debug)]
pub struct Double(f64);

impl sealed::Sealed for Double {}

macro_rules! operators {
    ($($trait:ident $f:ident $op:tt),*) => {$(
        impl $trait for Double {
            type Output = Self;
            #[inline(always)]
            fn $f(self, other: Self) -> Self {
                Self(self.0 $op other.0)
            }
        }
    )*};
}
operators!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Double {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Doubles for Double {
    type Mask = ArrayMask<1>;
    const WIDTH: usize = 1;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self(x)
    }
    #[inline(always)]
    fn load(from: &[f64]) -> Self {
        Self(from[0])
    }
    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        to[0] = self.0;
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn lt(self, other: Self) -> ArrayMask<1> {
        ArrayMask([self.0 < other.0])
    }
    #[inline(always)]
    fn le(self, other: Self) -> ArrayMask<1> {
        ArrayMask([self.0 <= other.0])
    }
    #[inline(always)]
    fn eq(self, other: Self) -> ArrayMask<1> {
        ArrayMask([self.0 == other.0])
    }
    #[inline(always)]
    fn select(mask: ArrayMask<1>, yes: Self, no: Self) -> Self {
        if mask.0[0] { yes } else { no }
    }
}
