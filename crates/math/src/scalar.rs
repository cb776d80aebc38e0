//! Scalar functions with the same bits everywhere.
//!
//! `min`, `max` and `clamp` are compare-and-select: the IEEE functions differ between instruction
//! sets in what they do with ±0 and NaN. Transcendentals go through `libm`.

macro_rules! scalar_functions {
    ($module:ident, $t:ident, $sin:path, $cos:path, $tan:path, $asin:path, $acos:path, $atan2:path, $exp:path, $ln:path, $pow:path) => {
        /// Functions of one float type.
        pub mod $module {
            /// `if a < b { a } else { b }`: the second argument when either is NaN.
            #[inline(always)]
            pub fn min(a: $t, b: $t) -> $t {
                if a < b { a } else { b }
            }
            /// `if a > b { a } else { b }`: the second argument when either is NaN.
            #[inline(always)]
            pub fn max(a: $t, b: $t) -> $t {
                if a > b { a } else { b }
            }
            /// `min(max(x, lo), hi)`; gives `lo` for a NaN `x`.
            #[inline(always)]
            pub fn clamp(x: $t, lo: $t, hi: $t) -> $t {
                min(max(x, lo), hi)
            }
            /// Square root (IEEE: correctly rounded on every target).
            #[inline(always)]
            pub fn sqrt(x: $t) -> $t {
                x.sqrt()
            }
            /// Sine of `x` radians.
            pub fn sin(x: $t) -> $t {
                $sin(x)
            }
            /// Cosine of `x` radians.
            pub fn cos(x: $t) -> $t {
                $cos(x)
            }
            /// Tangent of `x` radians.
            pub fn tan(x: $t) -> $t {
                $tan(x)
            }
            /// Arc sine in radians; NaN outside −1…1.
            pub fn asin(x: $t) -> $t {
                $asin(x)
            }
            /// Arc cosine in radians; NaN outside −1…1.
            pub fn acos(x: $t) -> $t {
                $acos(x)
            }
            /// Angle of the point (x, y) in radians, −π…π.
            pub fn atan2(y: $t, x: $t) -> $t {
                $atan2(y, x)
            }
            /// eˣ.
            pub fn exp(x: $t) -> $t {
                $exp(x)
            }
            /// Natural logarithm.
            pub fn ln(x: $t) -> $t {
                $ln(x)
            }
            /// xʸ.
            pub fn pow(x: $t, y: $t) -> $t {
                $pow(x, y)
            }
        }
    };
}

scalar_functions!(
    f32s,
    f32,
    libm::sinf,
    libm::cosf,
    libm::tanf,
    libm::asinf,
    libm::acosf,
    libm::atan2f,
    libm::expf,
    libm::logf,
    libm::powf
);
scalar_functions!(
    f64s,
    f64,
    libm::sin,
    libm::cos,
    libm::tan,
    libm::asin,
    libm::acos,
    libm::atan2,
    libm::exp,
    libm::log,
    libm::pow
);
