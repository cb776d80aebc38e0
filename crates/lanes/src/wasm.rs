//! WebAssembly's 128-bit SIMD, in builds that have it switched on.
//!
//! `f32x4_pmin(a, b)` is `if b < a { b } else { a }`: compare-and-select with the operands exchanged.

use std::arch::wasm32::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use crate::{Bits, Doubles, Lanes, Mask, sealed};

#[derive(Clone, Copy)]
pub(crate) struct F32x4(v128);
#[derive(Clone, Copy)]
pub(crate) struct Mask4(v128);

#[derive(Clone, Copy)]
pub(crate) struct U32x4(v128);

#[derive(Clone, Copy)]
pub(crate) struct F64x2(v128);
#[derive(Clone, Copy)]
pub(crate) struct MaskD2(v128);

impl sealed::Sealed for F64x2 {}
impl sealed::Sealed for MaskD2 {}
impl sealed::Sealed for F32x4 {}
impl sealed::Sealed for U32x4 {}
impl sealed::Sealed for Mask4 {}

macro_rules! operators {
    ($($type:ident $trait:ident $f:ident $op:ident),*) => {$(
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $f(self, other: Self) -> Self {
                Self($op(self.0, other.0))
            }
        }
    )*};
}
operators!(F32x4 Add add f32x4_add, F32x4 Sub sub f32x4_sub, F32x4 Mul mul f32x4_mul, F32x4 Div div f32x4_div,
    F64x2 Add add f64x2_add, F64x2 Sub sub f64x2_sub, F64x2 Mul mul f64x2_mul, F64x2 Div div f64x2_div,
    MaskD2 BitAnd bitand v128_and, MaskD2 BitOr bitor v128_or,
    Mask4 BitAnd bitand v128_and, Mask4 BitOr bitor v128_or,
    U32x4 Add add u32x4_add, U32x4 Mul mul u32x4_mul, U32x4 BitXor bitxor v128_xor);

impl Neg for F32x4 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(f32x4_neg(self.0))
    }
}

impl Not for Mask4 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(v128_not(self.0))
    }
}

impl Mask for Mask4 {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(i32x4_bitmask(self.0))
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.bits() == 15
    }
}

impl Bits for U32x4 {
    type Floats = F32x4;

    #[inline(always)]
    fn splat(x: u32) -> Self {
        Self(u32x4_splat(x))
    }
    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        Self(u32x4_shl(self.0, N))
    }
    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        Self(u32x4_shr(self.0, N))
    }
    #[inline(always)]
    fn as_floats(self) -> F32x4 {
        F32x4(self.0)
    }
    #[inline(always)]
    fn signed_to_floats(self) -> F32x4 {
        F32x4(f32x4_convert_i32x4(self.0))
    }
}

impl Lanes for F32x4 {
    type Mask = Mask4;
    type Bits = U32x4;
    type Doubles = F64x2;

    #[inline(always)]
    fn to_bits(self) -> U32x4 {
        U32x4(self.0)
    }
    const WIDTH: usize = 4;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(f32x4_splat(x))
    }
    #[inline(always)]
    fn load(from: &[f32]) -> Self {
        let from = &from[..4];
        Self(f32x4(from[0], from[1], from[2], from[3]))
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        let to = &mut to[..4];
        // SAFETY: the slice is as long as the store, and the store needs no alignment.
        unsafe { v128_store(to.as_mut_ptr().cast(), self.0) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(f32x4_sqrt(self.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(f32x4_abs(self.0))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(f32x4_pmin(other.0, self.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(f32x4_pmax(other.0, self.0))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask4 {
        Mask4(f32x4_lt(self.0, other.0))
    }
    #[inline(always)]
    fn le(self, other: Self) -> Mask4 {
        Mask4(f32x4_le(self.0, other.0))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Mask4 {
        Mask4(f32x4_eq(self.0, other.0))
    }
    #[inline(always)]
    fn select(mask: Mask4, yes: Self, no: Self) -> Self {
        Self(v128_bitselect(yes.0, no.0, mask.0))
    }
}

impl Neg for F64x2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(f64x2_neg(self.0))
    }
}

impl Not for MaskD2 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(v128_not(self.0))
    }
}

impl Mask for MaskD2 {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(i64x2_bitmask(self.0))
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.bits() == 3
    }
}

impl Doubles for F64x2 {
    type Mask = MaskD2;
    const WIDTH: usize = 2;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self(f64x2_splat(x))
    }
    #[inline(always)]
    fn load(from: &[f64]) -> Self {
        let from = &from[..2];
        Self(f64x2(from[0], from[1]))
    }
    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        let to = &mut to[..2];
        // SAFETY: the slice is as long as the store, and the store needs no alignment.
        unsafe { v128_store(to.as_mut_ptr().cast(), self.0) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(f64x2_sqrt(self.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(f64x2_abs(self.0))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> MaskD2 {
        MaskD2(f64x2_lt(self.0, other.0))
    }
    #[inline(always)]
    fn le(self, other: Self) -> MaskD2 {
        MaskD2(f64x2_le(self.0, other.0))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> MaskD2 {
        MaskD2(f64x2_eq(self.0, other.0))
    }
    #[inline(always)]
    fn select(mask: MaskD2, yes: Self, no: Self) -> Self {
        Self(v128_bitselect(yes.0, no.0, mask.0))
    }
}
