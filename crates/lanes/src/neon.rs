//! NEON, which every ARM64 machine has, so its intrinsics need no detection.
//!
//! `FMIN` and `FMAX` are IEEE 754's minimum and maximum, not compare-and-select; hence the explicit selection.

use std::arch::aarch64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use crate::{Bits, Doubles, Lanes, Mask, sealed};

#[derive(Clone, Copy)]
pub(crate) struct F32x4(float32x4_t);
#[derive(Clone, Copy)]
pub(crate) struct Mask4(uint32x4_t);

#[derive(Clone, Copy)]
pub(crate) struct U32x4(uint32x4_t);

#[derive(Clone, Copy)]
pub(crate) struct F64x2(float64x2_t);
#[derive(Clone, Copy)]
pub(crate) struct MaskD2(uint64x2_t);

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
                // SAFETY: NEON is part of the target's baseline.
                Self(unsafe { $op(self.0, other.0) })
            }
        }
    )*};
}
operators!(F32x4 Add add vaddq_f32, F32x4 Sub sub vsubq_f32, F32x4 Mul mul vmulq_f32, F32x4 Div div vdivq_f32,
    F64x2 Add add vaddq_f64, F64x2 Sub sub vsubq_f64, F64x2 Mul mul vmulq_f64, F64x2 Div div vdivq_f64,
    MaskD2 BitAnd bitand vandq_u64, MaskD2 BitOr bitor vorrq_u64,
    Mask4 BitAnd bitand vandq_u32, Mask4 BitOr bitor vorrq_u32,
    U32x4 Add add vaddq_u32, U32x4 Mul mul vmulq_u32, U32x4 BitXor bitxor veorq_u32);

impl Neg for F32x4 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vnegq_f32(self.0) })
    }
}

impl Not for Mask4 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vmvnq_u32(self.0) })
    }
}

impl Mask for Mask4 {
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: NEON is part of the target's baseline, and the array is as long as the load.
        unsafe { vaddvq_u32(vandq_u32(self.0, vld1q_u32([1, 2, 4, 8].as_ptr()))) }
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
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vdupq_n_u32(x) })
    }
    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vshlq_u32(self.0, vdupq_n_s32(N as i32)) })
    }
    /// To the left by a negative number.
    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vshlq_u32(self.0, vdupq_n_s32(-(N as i32))) })
    }
    #[inline(always)]
    fn as_floats(self) -> F32x4 {
        // SAFETY: NEON is part of the target's baseline.
        F32x4(unsafe { vreinterpretq_f32_u32(self.0) })
    }
    #[inline(always)]
    fn signed_to_floats(self) -> F32x4 {
        // SAFETY: NEON is part of the target's baseline.
        F32x4(unsafe { vcvtq_f32_s32(vreinterpretq_s32_u32(self.0)) })
    }
}

impl Lanes for F32x4 {
    type Mask = Mask4;
    type Bits = U32x4;
    type Doubles = F64x2;

    #[inline(always)]
    fn to_bits(self) -> U32x4 {
        // SAFETY: NEON is part of the target's baseline.
        U32x4(unsafe { vreinterpretq_u32_f32(self.0) })
    }
    const WIDTH: usize = 4;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vdupq_n_f32(x) })
    }
    #[inline(always)]
    fn load(from: &[f32]) -> Self {
        let from = &from[..4];
        // SAFETY: the slice is as long as the load.
        Self(unsafe { vld1q_f32(from.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        let to = &mut to[..4];
        // SAFETY: the slice is as long as the store.
        unsafe { vst1q_f32(to.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vsqrtq_f32(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vabsq_f32(self.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vbslq_f32(vcltq_f32(self.0, other.0), self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vbslq_f32(vcgtq_f32(self.0, other.0), self.0, other.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask4 {
        // SAFETY: NEON is part of the target's baseline.
        Mask4(unsafe { vcltq_f32(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Mask4 {
        // SAFETY: NEON is part of the target's baseline.
        Mask4(unsafe { vcleq_f32(self.0, other.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Mask4 {
        // SAFETY: NEON is part of the target's baseline.
        Mask4(unsafe { vceqq_f32(self.0, other.0) })
    }
    #[inline(always)]
    fn select(mask: Mask4, yes: Self, no: Self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vbslq_f32(mask.0, yes.0, no.0) })
    }
}

impl Neg for F64x2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vnegq_f64(self.0) })
    }
}

impl Not for MaskD2 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { veorq_u64(self.0, vdupq_n_u64(u64::MAX)) })
    }
}

impl Mask for MaskD2 {
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: NEON is part of the target's baseline.
        let (a, b) = unsafe { (vgetq_lane_u64::<0>(self.0), vgetq_lane_u64::<1>(self.0)) };
        (a & 1 | b & 2) as u32
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
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vdupq_n_f64(x) })
    }
    #[inline(always)]
    fn load(from: &[f64]) -> Self {
        let from = &from[..2];
        // SAFETY: the slice is as long as the load.
        Self(unsafe { vld1q_f64(from.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        let to = &mut to[..2];
        // SAFETY: the slice is as long as the store.
        unsafe { vst1q_f64(to.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vsqrtq_f64(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vabsq_f64(self.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> MaskD2 {
        // SAFETY: NEON is part of the target's baseline.
        MaskD2(unsafe { vcltq_f64(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> MaskD2 {
        // SAFETY: NEON is part of the target's baseline.
        MaskD2(unsafe { vcleq_f64(self.0, other.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> MaskD2 {
        // SAFETY: NEON is part of the target's baseline.
        MaskD2(unsafe { vceqq_f64(self.0, other.0) })
    }
    #[inline(always)]
    fn select(mask: MaskD2, yes: Self, no: Self) -> Self {
        // SAFETY: NEON is part of the target's baseline.
        Self(unsafe { vbslq_f64(mask.0, yes.0, no.0) })
    }
}
