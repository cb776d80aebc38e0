//! SSE2, AVX2 and AVX-512F.
//!
//! # Why the intrinsics are sound
//! The types of this module are private and [`Lanes`] is sealed, so code outside meets them only as the `L` of
//! [`Kernel::run`], inside one of the entry points below. [`crate::dispatch`] enters one only after it has detected the
//! instruction set on this machine. Whatever a kernel does with `L`, it does on a machine that has the instructions;
//! code that is not inlined into the entry point is slower and the same.

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use crate::{Bits, Doubles, Kernel, Lanes, Mask, sealed};

pub(crate) fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
}

pub(crate) fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
}

pub(crate) fn enter_sse2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<F32x4>()
}

#[target_feature(enable = "avx2")]
pub(crate) fn enter_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<F32x8>()
}

#[target_feature(enable = "avx512f")]
pub(crate) fn enter_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<F32x16>()
}

#[derive(Clone, Copy)]
pub(crate) struct F32x4(__m128);
#[derive(Clone, Copy)]
pub(crate) struct Mask4(__m128);
#[derive(Clone, Copy)]
pub(crate) struct F32x8(__m256);
#[derive(Clone, Copy)]
pub(crate) struct Mask8(__m256);
#[derive(Clone, Copy)]
pub(crate) struct F32x16(__m512);
#[derive(Clone, Copy)]
pub(crate) struct Mask16(__mmask16);
#[derive(Clone, Copy)]
pub(crate) struct F64x2(__m128d);
#[derive(Clone, Copy)]
pub(crate) struct MaskD2(__m128d);
#[derive(Clone, Copy)]
pub(crate) struct F64x4(__m256d);
#[derive(Clone, Copy)]
pub(crate) struct MaskD4(__m256d);
#[derive(Clone, Copy)]
pub(crate) struct F64x8(__m512d);
#[derive(Clone, Copy)]
pub(crate) struct MaskD8(__mmask8);
#[derive(Clone, Copy)]
pub(crate) struct U32x4(__m128i);
#[derive(Clone, Copy)]
pub(crate) struct U32x8(__m256i);
#[derive(Clone, Copy)]
pub(crate) struct U32x16(__m512i);

macro_rules! operators {
    ($type:ident, $set1:ident, $xor:expr, $($trait:ident $f:ident $op:ident),*) => {
        impl sealed::Sealed for $type {}
        $(impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $f(self, other: Self) -> Self {
                // SAFETY: the machine has the instructions (see the header).
                Self(unsafe { $op(self.0, other.0) })
            }
        })*
        impl Neg for $type {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: the machine has the instructions (see the header).
                Self(unsafe { $xor(self.0, $set1(-0.0)) })
            }
        }
    };
}
operators!(F32x4, _mm_set1_ps, _mm_xor_ps, Add add _mm_add_ps, Sub sub _mm_sub_ps, Mul mul _mm_mul_ps, Div div _mm_div_ps);
operators!(F32x8, _mm256_set1_ps, _mm256_xor_ps,
    Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps, Div div _mm256_div_ps);
operators!(F32x16, _mm512_set1_ps, xor512,
    Add add _mm512_add_ps, Sub sub _mm512_sub_ps, Mul mul _mm512_mul_ps, Div div _mm512_div_ps);

operators!(F64x2, _mm_set1_pd, _mm_xor_pd, Add add _mm_add_pd, Sub sub _mm_sub_pd, Mul mul _mm_mul_pd, Div div _mm_div_pd);
operators!(F64x4, _mm256_set1_pd, _mm256_xor_pd,
    Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);
operators!(F64x8, _mm512_set1_pd, xor512d,
    Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd);

/// The float form of this instruction needs AVX-512DQ.
///
/// # Safety
/// The machine has AVX-512F.
#[inline(always)]
unsafe fn xor512d(a: __m512d, b: __m512d) -> __m512d {
    // SAFETY: promised by the caller.
    unsafe { _mm512_castsi512_pd(_mm512_xor_si512(_mm512_castpd_si512(a), _mm512_castpd_si512(b))) }
}

/// The float form of this instruction needs AVX-512DQ.
///
/// # Safety
/// The machine has AVX-512F.
#[inline(always)]
unsafe fn xor512(a: __m512, b: __m512) -> __m512 {
    // SAFETY: promised by the caller.
    unsafe { _mm512_castsi512_ps(_mm512_xor_si512(_mm512_castps_si512(a), _mm512_castps_si512(b))) }
}

macro_rules! vector_mask {
    ($type:ident, $width:literal, $and:ident, $or:ident, $xor:ident, $ones:expr, $movemask:ident) => {
        impl sealed::Sealed for $type {}
        impl BitAnd for $type {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                // SAFETY: the machine has the instructions (see the header).
                Self(unsafe { $and(self.0, other.0) })
            }
        }
        impl BitOr for $type {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                // SAFETY: the machine has the instructions (see the header).
                Self(unsafe { $or(self.0, other.0) })
            }
        }
        impl Not for $type {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                // SAFETY: the machine has the instructions (see the header).
                Self(unsafe { $xor(self.0, $ones) })
            }
        }
        impl Mask for $type {
            #[inline(always)]
            fn bits(self) -> u32 {
                // SAFETY: the machine has the instructions (see the header).
                unsafe { $movemask(self.0) as u32 }
            }
            #[inline(always)]
            fn all(self) -> bool {
                self.bits() == (1 << $width) - 1
            }
        }
    };
}
vector_mask!(
    Mask4,
    4,
    _mm_and_ps,
    _mm_or_ps,
    _mm_xor_ps,
    _mm_castsi128_ps(_mm_set1_epi32(-1)),
    _mm_movemask_ps
);
vector_mask!(
    Mask8,
    8,
    _mm256_and_ps,
    _mm256_or_ps,
    _mm256_xor_ps,
    _mm256_castsi256_ps(_mm256_set1_epi32(-1)),
    _mm256_movemask_ps
);

vector_mask!(
    MaskD2,
    2,
    _mm_and_pd,
    _mm_or_pd,
    _mm_xor_pd,
    _mm_castsi128_pd(_mm_set1_epi32(-1)),
    _mm_movemask_pd
);
vector_mask!(
    MaskD4,
    4,
    _mm256_and_pd,
    _mm256_or_pd,
    _mm256_xor_pd,
    _mm256_castsi256_pd(_mm256_set1_epi32(-1)),
    _mm256_movemask_pd
);

macro_rules! word_mask {
    ($type:ident, $word:ident) => {
        impl sealed::Sealed for $type {}
        impl BitAnd for $type {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                Self(self.0 & other.0)
            }
        }
        impl BitOr for $type {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                Self(self.0 | other.0)
            }
        }
        impl Not for $type {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self(!self.0)
            }
        }
        impl Mask for $type {
            #[inline(always)]
            fn bits(self) -> u32 {
                u32::from(self.0)
            }
            #[inline(always)]
            fn all(self) -> bool {
                self.0 == $word::MAX
            }
        }
    };
}
word_mask!(Mask16, u16);
word_mask!(MaskD8, u8);

macro_rules! bits {
    ($type:ident, $floats:ident, $set1:ident, $shl:expr, $shr:expr, $cast:ident, $convert:ident, $mul:ident,
        $add:ident, $xor:ident) => {
        impl sealed::Sealed for $type {}
        impl Add for $type {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                // SAFETY: the machine has the instructions (see the header).
                Self(unsafe { $add(self.0, other.0) })
            }
        }
        impl Mul for $type {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                // SAFETY: the machine has the instructions (see the header).
                Self(unsafe { $mul(self.0, other.0) })
            }
        }
        impl BitXor for $type {
            type Output = Self;
            #[inline(always)]
            fn bitxor(self, other: Self) -> Self {
                // SAFETY: the machine has the instructions (see the header).
                Self(unsafe { $xor(self.0, other.0) })
            }
        }
        impl Bits for $type {
            type Floats = $floats;

            #[inline(always)]
            fn splat(x: u32) -> Self {
                // SAFETY: the machine has the instructions (see the header).
                Self(unsafe { $set1(x as i32) })
            }
            #[inline(always)]
            fn shl<const N: u32>(self) -> Self {
                // SAFETY: the machine has the instructions (see the header).
                Self(unsafe { $shl(self.0, _mm_cvtsi32_si128(N as i32)) })
            }
            #[inline(always)]
            fn shr<const N: u32>(self) -> Self {
                // SAFETY: the machine has the instructions (see the header).
                Self(unsafe { $shr(self.0, _mm_cvtsi32_si128(N as i32)) })
            }
            #[inline(always)]
            fn as_floats(self) -> $floats {
                // SAFETY: the machine has the instructions (see the header).
                $floats(unsafe { $cast(self.0) })
            }
            #[inline(always)]
            fn signed_to_floats(self) -> $floats {
                // SAFETY: the machine has the instructions (see the header).
                $floats(unsafe { $convert(self.0) })
            }
        }
    };
}
// Shifts by a register that holds a constant: the compiler makes the immediate form of them.
bits!(
    U32x4,
    F32x4,
    _mm_set1_epi32,
    _mm_sll_epi32,
    _mm_srl_epi32,
    _mm_castsi128_ps,
    _mm_cvtepi32_ps,
    mul4,
    _mm_add_epi32,
    _mm_xor_si128
);
bits!(
    U32x8,
    F32x8,
    _mm256_set1_epi32,
    _mm256_sll_epi32,
    _mm256_srl_epi32,
    _mm256_castsi256_ps,
    _mm256_cvtepi32_ps,
    _mm256_mullo_epi32,
    _mm256_add_epi32,
    _mm256_xor_si256
);
bits!(
    U32x16,
    F32x16,
    _mm512_set1_epi32,
    _mm512_sll_epi32,
    _mm512_srl_epi32,
    _mm512_castsi512_ps,
    _mm512_cvtepi32_ps,
    _mm512_mullo_epi32,
    _mm512_add_epi32,
    _mm512_xor_si512
);

/// The low halves of the four products; SSE2 multiplies two at a time. ([`_mm_mullo_epi32`] is SSE4.1's.)
///
/// # Safety
/// The machine has SSE2.
#[inline(always)]
unsafe fn mul4(a: __m128i, b: __m128i) -> __m128i {
    // SAFETY: promised by the caller.
    unsafe {
        let even = _mm_mul_epu32(a, b);
        let odd = _mm_mul_epu32(_mm_srli_epi64::<32>(a), _mm_srli_epi64::<32>(b));
        const LOW: i32 = 0b00_00_10_00;
        _mm_unpacklo_epi32(_mm_shuffle_epi32::<LOW>(even), _mm_shuffle_epi32::<LOW>(odd))
    }
}

/// What is spelt alike for all sets and both kinds of floats.
macro_rules! common {
    ($float:ident, $width:literal, $set1:ident, $load:ident, $store:ident, $sqrt:ident) => {
        const WIDTH: usize = $width;

        #[inline(always)]
        fn splat(x: $float) -> Self {
            // SAFETY: the machine has the instructions (see the header).
            Self(unsafe { $set1(x) })
        }
        #[inline(always)]
        fn load(from: &[$float]) -> Self {
            let from = &from[..$width];
            // SAFETY: the machine has the instructions (see the header), and the slice is as long as the load.
            Self(unsafe { $load(from.as_ptr()) })
        }
        #[inline(always)]
        fn store(self, to: &mut [$float]) {
            let to = &mut to[..$width];
            // SAFETY: the machine has the instructions (see the header), and the slice is as long as the store.
            unsafe { $store(to.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            // SAFETY: the machine has the instructions (see the header).
            Self(unsafe { $sqrt(self.0) })
        }
    };
}

/// `MINPS` and `MAXPS` give their second operand for NaN and for two zeros, which is compare-and-select.
macro_rules! extremes {
    ($min:ident, $max:ident) => {
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            // SAFETY: the machine has the instructions (see the header).
            Self(unsafe { $min(self.0, other.0) })
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: the machine has the instructions (see the header).
            Self(unsafe { $max(self.0, other.0) })
        }
    };
}

impl Lanes for F32x4 {
    type Mask = Mask4;
    type Bits = U32x4;
    type Doubles = F64x2;

    #[inline(always)]
    fn to_bits(self) -> U32x4 {
        // SAFETY: the machine has the instructions (see the header).
        U32x4(unsafe { _mm_castps_si128(self.0) })
    }
    common!(f32, 4, _mm_set1_ps, _mm_loadu_ps, _mm_storeu_ps, _mm_sqrt_ps);
    extremes!(_mm_min_ps, _mm_max_ps);

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: the machine has the instructions (see the header).
        Self(unsafe { _mm_andnot_ps(_mm_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask4 {
        // SAFETY: the machine has the instructions (see the header).
        Mask4(unsafe { _mm_cmplt_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Mask4 {
        // SAFETY: the machine has the instructions (see the header).
        Mask4(unsafe { _mm_cmple_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Mask4 {
        // SAFETY: the machine has the instructions (see the header).
        Mask4(unsafe { _mm_cmpeq_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn select(mask: Mask4, yes: Self, no: Self) -> Self {
        // SAFETY: the machine has the instructions (see the header).
        Self(unsafe { _mm_or_ps(_mm_and_ps(mask.0, yes.0), _mm_andnot_ps(mask.0, no.0)) })
    }
    #[inline(always)]
    fn gather8<'a>(row: impl Fn(usize) -> &'a [f32; 8]) -> [Self; 8] {
        let mut out = [Self::zero(); 8];
        for half in 0..2 {
            let mut rows = [Self::zero().0; 4];
            for i in 0..4 {
                rows[i] = Self::load(&row(i)[4 * half..]).0;
            }
            let columns = transpose4(rows);
            for c in 0..4 {
                out[4 * half + c] = Self(columns[c]);
            }
        }
        out
    }
    #[inline(always)]
    fn scatter8(columns: [Self; 8], mut put: impl FnMut(usize, [f32; 8])) {
        let [a, b, c, d, e, f, g, h] = columns;
        let low = transpose4([a.0, b.0, c.0, d.0]);
        let high = transpose4([e.0, f.0, g.0, h.0]);
        for lane in 0..4 {
            let mut row = [0.0; 8];
            Self(low[lane]).store(&mut row[..4]);
            Self(high[lane]).store(&mut row[4..]);
            put(lane, row);
        }
    }
}

impl Lanes for F32x8 {
    type Mask = Mask8;
    type Bits = U32x8;
    type Doubles = F64x4;

    #[inline(always)]
    fn to_bits(self) -> U32x8 {
        // SAFETY: the machine has the instructions (see the header).
        U32x8(unsafe { _mm256_castps_si256(self.0) })
    }
    common!(f32, 8, _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_sqrt_ps);
    extremes!(_mm256_min_ps, _mm256_max_ps);

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: the machine has the instructions (see the header).
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask8 {
        // SAFETY: the machine has the instructions (see the header).
        Mask8(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Mask8 {
        // SAFETY: the machine has the instructions (see the header).
        Mask8(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Mask8 {
        // SAFETY: the machine has the instructions (see the header).
        Mask8(unsafe { _mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn select(mask: Mask8, yes: Self, no: Self) -> Self {
        // SAFETY: the machine has the instructions (see the header).
        Self(unsafe { _mm256_blendv_ps(no.0, yes.0, mask.0) })
    }
    #[inline(always)]
    fn gather8<'a>(row: impl Fn(usize) -> &'a [f32; 8]) -> [Self; 8] {
        let mut rows = [Self::zero(); 8];
        for i in 0..8 {
            rows[i] = Self::load(row(i));
        }
        // SAFETY: the machine has the instructions (see the header).
        unsafe { transpose8(rows) }
    }
    #[inline(always)]
    fn gather8_of(row: impl Fn(usize) -> [f32; 8]) -> [Self; 8] {
        let mut rows = [Self::zero(); 8];
        for i in 0..8 {
            let [a, b, c, d, e, f, g, h] = row(i);
            // SAFETY: the machine has the instructions (see the header).
            rows[i] = whole(unsafe { _mm256_setr_ps(a, b, c, d, e, f, g, h) });
        }
        // SAFETY: likewise.
        unsafe { transpose8(rows) }
    }
    #[inline(always)]
    fn scatter8(columns: [Self; 8], mut put: impl FnMut(usize, [f32; 8])) {
        // SAFETY: the machine has the instructions (see the header).
        let rows = unsafe { transpose8(columns) };
        for lane in 0..8 {
            let mut row = [0.0; 8];
            rows[lane].store(&mut row);
            put(lane, row);
        }
    }
}

impl Lanes for F32x16 {
    type Mask = Mask16;
    type Bits = U32x16;
    type Doubles = F64x8;

    #[inline(always)]
    fn to_bits(self) -> U32x16 {
        // SAFETY: the machine has the instructions (see the header).
        U32x16(unsafe { _mm512_castps_si512(self.0) })
    }
    common!(f32, 16, _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_sqrt_ps);
    extremes!(_mm512_min_ps, _mm512_max_ps);

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: the machine has the instructions (see the header).
        Self(unsafe { _mm512_abs_ps(self.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask16 {
        // SAFETY: the machine has the instructions (see the header).
        Mask16(unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Mask16 {
        // SAFETY: the machine has the instructions (see the header).
        Mask16(unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Mask16 {
        // SAFETY: the machine has the instructions (see the header).
        Mask16(unsafe { _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn select(mask: Mask16, yes: Self, no: Self) -> Self {
        // SAFETY: the machine has the instructions (see the header).
        Self(unsafe { _mm512_mask_blend_ps(mask.0, no.0, yes.0) })
    }
    /// Two transpositions of eight rows, side by side.
    #[inline(always)]
    fn gather8<'a>(row: impl Fn(usize) -> &'a [f32; 8]) -> [Self; 8] {
        let low = F32x8::gather8(
            #[inline(always)]
            |lane| row(lane),
        );
        let high = F32x8::gather8(
            #[inline(always)]
            |lane| row(lane + 8),
        );
        side_by_side(low, high)
    }
    #[expect(clippy::redundant_closure, reason = "a closure can be told to inline")]
    #[inline(always)]
    fn gather8_of(row: impl Fn(usize) -> [f32; 8]) -> [Self; 8] {
        let low = F32x8::gather8_of(
            #[inline(always)]
            |lane| row(lane),
        );
        let high = F32x8::gather8_of(
            #[inline(always)]
            |lane| row(lane + 8),
        );
        side_by_side(low, high)
    }
    #[expect(
        clippy::redundant_closure,
        reason = "a closure can be told to inline; `FnMut for &mut F` cannot"
    )]
    #[inline(always)]
    fn scatter8(columns: [Self; 8], mut put: impl FnMut(usize, [f32; 8])) {
        let (mut low, mut high) = ([F32x8::zero(); 8], [F32x8::zero(); 8]);
        for c in 0..8 {
            // SAFETY: the machine has the instructions (see the header); AVX-512F includes AVX2.
            unsafe {
                low[c] = F32x8(_mm512_castps512_ps256(columns[c].0));
                high[c] =
                    F32x8(_mm256_castpd_ps(_mm512_extractf64x4_pd::<1>(_mm512_castps_pd(columns[c].0))));
            }
        }
        F32x8::scatter8(
            low,
            #[inline(always)]
            |lane, row| put(lane, row),
        );
        F32x8::scatter8(
            high,
            #[inline(always)]
            |lane, row| put(lane + 8, row),
        );
    }
}

/// A row that is loaded as a whole. Without this the compiler sees through the transposition that follows, and fetches the elements of a column
/// from eight places by one instruction, which takes several times as long as eight loads.
#[inline(always)]
fn whole(row: __m256) -> F32x8 {
    F32x8(core::hint::black_box(row))
}

/// Sixteen lanes of twice eight.
#[inline(always)]
fn side_by_side(low: [F32x8; 8], high: [F32x8; 8]) -> [F32x16; 8] {
    let mut out = [F32x16::zero(); 8];
    for c in 0..8 {
        // SAFETY: the machine has the instructions (see the header); AVX-512F includes AVX2.
        out[c] = F32x16(unsafe {
            let (low, high) = (_mm512_castps256_ps512(low[c].0), _mm256_castps_pd(high[c].0));
            _mm512_castpd_ps(_mm512_insertf64x4::<1>(_mm512_castps_pd(low), high))
        });
    }
    out
}

#[inline(always)]
fn transpose4(r: [__m128; 4]) -> [__m128; 4] {
    // SAFETY: SSE2 is part of the target's baseline.
    unsafe {
        let (a, b) = (_mm_unpacklo_ps(r[0], r[1]), _mm_unpackhi_ps(r[0], r[1]));
        let (c, d) = (_mm_unpacklo_ps(r[2], r[3]), _mm_unpackhi_ps(r[2], r[3]));
        [_mm_movelh_ps(a, c), _mm_movehl_ps(c, a), _mm_movelh_ps(b, d), _mm_movehl_ps(d, b)]
    }
}

/// Pairs of rows are interleaved, then pairs of pairs, then 128-bit halves are exchanged.
///
/// # Safety
/// The machine has AVX.
#[inline(always)]
unsafe fn transpose8(rows: [F32x8; 8]) -> [F32x8; 8] {
    let [a, b, c, d, e, f, g, h] = rows;
    // SAFETY: promised by the caller.
    unsafe {
        let (ab, ab_) = (_mm256_unpacklo_ps(a.0, b.0), _mm256_unpackhi_ps(a.0, b.0));
        let (cd, cd_) = (_mm256_unpacklo_ps(c.0, d.0), _mm256_unpackhi_ps(c.0, d.0));
        let (ef, ef_) = (_mm256_unpacklo_ps(e.0, f.0), _mm256_unpackhi_ps(e.0, f.0));
        let (gh, gh_) = (_mm256_unpacklo_ps(g.0, h.0), _mm256_unpackhi_ps(g.0, h.0));
        const LOW: i32 = 0b01_00_01_00;
        const HIGH: i32 = 0b11_10_11_10;
        let near = [
            _mm256_shuffle_ps::<LOW>(ab, cd),
            _mm256_shuffle_ps::<HIGH>(ab, cd),
            _mm256_shuffle_ps::<LOW>(ab_, cd_),
            _mm256_shuffle_ps::<HIGH>(ab_, cd_),
        ];
        let far = [
            _mm256_shuffle_ps::<LOW>(ef, gh),
            _mm256_shuffle_ps::<HIGH>(ef, gh),
            _mm256_shuffle_ps::<LOW>(ef_, gh_),
            _mm256_shuffle_ps::<HIGH>(ef_, gh_),
        ];
        let mut out = [a; 8];
        for c in 0..4 {
            out[c] = F32x8(_mm256_permute2f128_ps::<0x20>(near[c], far[c]));
            out[c + 4] = F32x8(_mm256_permute2f128_ps::<0x31>(near[c], far[c]));
        }
        out
    }
}

/// What of doubles is spelt alike for the three sets beside that.
macro_rules! doubles {
    ($mask:ident, $abs:expr, $lt:expr, $le:expr, $eq:expr, $select:expr) => {
        type Mask = $mask;

        #[inline(always)]
        fn abs(self) -> Self {
            // SAFETY: the machine has the instructions (see the header).
            Self(unsafe { $abs(self.0) })
        }
        #[inline(always)]
        fn lt(self, other: Self) -> $mask {
            // SAFETY: the machine has the instructions (see the header).
            $mask(unsafe { $lt(self.0, other.0) })
        }
        #[inline(always)]
        fn le(self, other: Self) -> $mask {
            // SAFETY: the machine has the instructions (see the header).
            $mask(unsafe { $le(self.0, other.0) })
        }
        #[inline(always)]
        fn eq(self, other: Self) -> $mask {
            // SAFETY: the machine has the instructions (see the header).
            $mask(unsafe { $eq(self.0, other.0) })
        }
        #[inline(always)]
        fn select(mask: $mask, yes: Self, no: Self) -> Self {
            // SAFETY: the machine has the instructions (see the header).
            Self(unsafe { $select(mask.0, yes.0, no.0) })
        }
    };
}

impl Doubles for F64x2 {
    common!(f64, 2, _mm_set1_pd, _mm_loadu_pd, _mm_storeu_pd, _mm_sqrt_pd);
    doubles!(
        MaskD2,
        |x| _mm_andnot_pd(_mm_set1_pd(-0.0), x),
        _mm_cmplt_pd,
        _mm_cmple_pd,
        _mm_cmpeq_pd,
        |mask, yes, no| _mm_or_pd(_mm_and_pd(mask, yes), _mm_andnot_pd(mask, no))
    );
}

impl Doubles for F64x4 {
    common!(f64, 4, _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_sqrt_pd);
    doubles!(
        MaskD4,
        |x| _mm256_andnot_pd(_mm256_set1_pd(-0.0), x),
        _mm256_cmp_pd::<_CMP_LT_OQ>,
        _mm256_cmp_pd::<_CMP_LE_OQ>,
        _mm256_cmp_pd::<_CMP_EQ_OQ>,
        |mask, yes, no| _mm256_blendv_pd(no, yes, mask)
    );
    #[inline(always)]
    fn gather4(row: impl Fn(usize) -> [f64; 4]) -> [Self; 4] {
        let mut rows = [Self::zero(); 4];
        for i in 0..4 {
            rows[i] = Self::load(&row(i));
        }
        // SAFETY: the machine has the instructions (see the header).
        unsafe { transpose4d(rows) }
    }
    #[inline(always)]
    fn scatter4(columns: [Self; 4], mut put: impl FnMut(usize, [f64; 4])) {
        // SAFETY: the machine has the instructions (see the header).
        let rows = unsafe { transpose4d(columns) };
        for lane in 0..4 {
            let mut row = [0.0; 4];
            rows[lane].store(&mut row);
            put(lane, row);
        }
    }
}

impl Doubles for F64x8 {
    common!(f64, 8, _mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd, _mm512_sqrt_pd);
    doubles!(
        MaskD8,
        _mm512_abs_pd,
        _mm512_cmp_pd_mask::<_CMP_LT_OQ>,
        _mm512_cmp_pd_mask::<_CMP_LE_OQ>,
        _mm512_cmp_pd_mask::<_CMP_EQ_OQ>,
        |mask, yes, no| _mm512_mask_blend_pd(mask, no, yes)
    );
    /// Two transpositions of four rows, side by side.
    #[expect(clippy::redundant_closure, reason = "a closure can be told to inline")]
    #[inline(always)]
    fn gather4(row: impl Fn(usize) -> [f64; 4]) -> [Self; 4] {
        let low = F64x4::gather4(
            #[inline(always)]
            |lane| row(lane),
        );
        let high = F64x4::gather4(
            #[inline(always)]
            |lane| row(lane + 4),
        );
        let mut out = [Self::zero(); 4];
        for c in 0..4 {
            // SAFETY: the machine has the instructions (see the header); AVX-512F includes AVX2.
            out[c] = Self(unsafe { _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low[c].0), high[c].0) });
        }
        out
    }
    #[expect(
        clippy::redundant_closure,
        reason = "a closure can be told to inline; `FnMut for &mut F` cannot"
    )]
    #[inline(always)]
    fn scatter4(columns: [Self; 4], mut put: impl FnMut(usize, [f64; 4])) {
        let (mut low, mut high) = ([F64x4::zero(); 4], [F64x4::zero(); 4]);
        for c in 0..4 {
            // SAFETY: the machine has the instructions (see the header); AVX-512F includes AVX2.
            unsafe {
                low[c] = F64x4(_mm512_castpd512_pd256(columns[c].0));
                high[c] = F64x4(_mm512_extractf64x4_pd::<1>(columns[c].0));
            }
        }
        F64x4::scatter4(
            low,
            #[inline(always)]
            |lane, row| put(lane, row),
        );
        F64x4::scatter4(
            high,
            #[inline(always)]
            |lane, row| put(lane + 4, row),
        );
    }
}

/// Pairs of rows are interleaved, then 128-bit halves are exchanged.
///
/// # Safety
/// The machine has AVX.
#[inline(always)]
unsafe fn transpose4d(rows: [F64x4; 4]) -> [F64x4; 4] {
    let [a, b, c, d] = rows;
    // SAFETY: promised by the caller.
    unsafe {
        let (ab, ab_) = (_mm256_unpacklo_pd(a.0, b.0), _mm256_unpackhi_pd(a.0, b.0));
        let (cd, cd_) = (_mm256_unpacklo_pd(c.0, d.0), _mm256_unpackhi_pd(c.0, d.0));
        [
            F64x4(_mm256_permute2f128_pd::<0x20>(ab, cd)),
            F64x4(_mm256_permute2f128_pd::<0x20>(ab_, cd_)),
            F64x4(_mm256_permute2f128_pd::<0x31>(ab, cd)),
            F64x4(_mm256_permute2f128_pd::<0x31>(ab_, cd_)),
        ]
    }
}
