//! Lanes without instructions for them: the reference that the others are tested against.

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use crate::{Bits, Double, Lanes, Mask, sealed};

/// `N` floats, treated one after another.
#[derive(Clone, Copy, Debug)]
pub struct Array<const N: usize>([f32; N]);

/// `N` truth values.
#[derive(Clone, Copy, Debug)]
pub struct ArrayMask<const N: usize>(pub(crate) [bool; N]);

/// `N` words.
#[derive(Clone, Copy, Debug)]
pub struct ArrayBits<const N: usize>([u32; N]);

impl<const N: usize> sealed::Sealed for Array<N> {}
impl<const N: usize> sealed::Sealed for ArrayBits<N> {}
impl<const N: usize> sealed::Sealed for ArrayMask<N> {}

macro_rules! each {
    ($wrap:ident, $i:ident, $start:expr, $value:expr) => {{
        let mut out = [$start; N];
        for $i in 0..N {
            out[$i] = $value;
        }
        $wrap(out)
    }};
}

macro_rules! operators {
    ($($trait:ident $f:ident $op:tt),*) => {$(
        impl<const N: usize> $trait for Array<N> {
            type Output = Self;
            #[inline(always)]
            fn $f(self, other: Self) -> Self {
                each!(Array, i, 0.0, self.0[i] $op other.0[i])
            }
        }
    )*};
}
operators!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<const N: usize> Neg for Array<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        each!(Array, i, 0.0, -self.0[i])
    }
}

impl<const N: usize> BitAnd for ArrayMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        each!(ArrayMask, i, false, self.0[i] & other.0[i])
    }
}

impl<const N: usize> BitOr for ArrayMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        each!(ArrayMask, i, false, self.0[i] | other.0[i])
    }
}

impl<const N: usize> Not for ArrayMask<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        each!(ArrayMask, i, false, !self.0[i])
    }
}

impl<const N: usize> Mask for ArrayMask<N> {
    #[inline(always)]
    fn bits(self) -> u32 {
        let mut bits = 0;
        for i in 0..N {
            bits |= (self.0[i] as u32) << i;
        }
        bits
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.bits() == u32::MAX >> (32 - N)
    }
}

macro_rules! bit_operators {
    ($($trait:ident $f:ident $op:ident),*) => {$(
        impl<const N: usize> $trait for ArrayBits<N> {
            type Output = Self;
            #[inline(always)]
            fn $f(self, other: Self) -> Self {
                each!(ArrayBits, i, 0, self.0[i].$op(other.0[i]))
            }
        }
    )*};
}
bit_operators!(Add add wrapping_add, Mul mul wrapping_mul, BitXor bitxor bitxor);

impl<const N: usize> Bits for ArrayBits<N> {
    type Floats = Array<N>;

    #[inline(always)]
    fn splat(x: u32) -> Self {
        Self([x; N])
    }
    #[inline(always)]
    fn shl<const S: u32>(self) -> Self {
        each!(ArrayBits, i, 0, self.0[i] << S)
    }
    #[inline(always)]
    fn shr<const S: u32>(self) -> Self {
        each!(ArrayBits, i, 0, self.0[i] >> S)
    }
    #[inline(always)]
    fn as_floats(self) -> Array<N> {
        each!(Array, i, 0.0, f32::from_bits(self.0[i]))
    }
    #[inline(always)]
    fn signed_to_floats(self) -> Array<N> {
        each!(Array, i, 0.0, self.0[i] as i32 as f32)
    }
}

impl<const N: usize> Lanes for Array<N> {
    type Mask = ArrayMask<N>;
    type Bits = ArrayBits<N>;
    type Doubles = Double;
    const WIDTH: usize = N;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; N])
    }
    #[inline(always)]
    fn load(from: &[f32]) -> Self {
        let from = &from[..N];
        each!(Array, i, 0.0, from[i])
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        to[..N].copy_from_slice(&self.0);
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        each!(Array, i, 0.0, self.0[i].sqrt())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        each!(Array, i, 0.0, self.0[i].abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        each!(Array, i, 0.0, if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        each!(Array, i, 0.0, if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> ArrayMask<N> {
        each!(ArrayMask, i, false, self.0[i] < other.0[i])
    }
    #[inline(always)]
    fn le(self, other: Self) -> ArrayMask<N> {
        each!(ArrayMask, i, false, self.0[i] <= other.0[i])
    }
    #[inline(always)]
    fn eq(self, other: Self) -> ArrayMask<N> {
        each!(ArrayMask, i, false, self.0[i] == other.0[i])
    }
    #[inline(always)]
    fn select(mask: ArrayMask<N>, yes: Self, no: Self) -> Self {
        each!(Array, i, 0.0, if mask.0[i] { yes.0[i] } else { no.0[i] })
    }
    #[inline(always)]
    fn to_bits(self) -> ArrayBits<N> {
        each!(ArrayBits, i, 0, self.0[i].to_bits())
    }
}
