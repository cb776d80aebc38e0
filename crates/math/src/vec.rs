//! Three-component vectors, `f32` and `f64`.

use core::ops::{Add, AddAssign, Div, Index, Mul, MulAssign, Neg, Sub, SubAssign};

macro_rules! vector {
    ($v:ident, $t:ident, $scalar:ident, $doc:literal) => {
        #[doc = $doc]
        #[derive(Clone, Copy, Default, PartialEq)]
        #[repr(C)]
        pub struct $v {
            /// First component.
            pub x: $t,
            /// Second component (up, by default).
            pub y: $t,
            /// Third component.
            pub z: $t,
        }

        /// [x, y, z]: messages show it.
        impl core::fmt::Debug for $v {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                self.to_array().fmt(f)
            }
        }

        impl $v {
            /// (0, 0, 0).
            pub const ZERO: Self = Self::new(0.0, 0.0, 0.0);
            /// (1, 1, 1).
            pub const ONE: Self = Self::new(1.0, 1.0, 1.0);
            /// Unit x.
            pub const X: Self = Self::new(1.0, 0.0, 0.0);
            /// Unit y.
            pub const Y: Self = Self::new(0.0, 1.0, 0.0);
            /// Unit z.
            pub const Z: Self = Self::new(0.0, 0.0, 1.0);

            /// The vector (x, y, z).
            #[inline(always)]
            pub const fn new(x: $t, y: $t, z: $t) -> Self {
                Self { x, y, z }
            }
            /// All three components equal.
            #[inline(always)]
            pub const fn splat(v: $t) -> Self {
                Self::new(v, v, v)
            }
            /// From an array [x, y, z].
            #[inline(always)]
            pub const fn from_array(a: [$t; 3]) -> Self {
                Self::new(a[0], a[1], a[2])
            }
            /// As an array [x, y, z].
            #[inline(always)]
            pub const fn to_array(self) -> [$t; 3] {
                [self.x, self.y, self.z]
            }
            /// x·x′ + y·y′ + z·z′, summed left to right.
            #[inline(always)]
            pub fn dot(self, o: Self) -> $t {
                self.x * o.x + self.y * o.y + self.z * o.z
            }
            /// Cross product.
            #[inline(always)]
            pub fn cross(self, o: Self) -> Self {
                Self::new(
                    self.y * o.z - self.z * o.y,
                    self.z * o.x - self.x * o.z,
                    self.x * o.y - self.y * o.x,
                )
            }
            /// Squared length.
            #[inline(always)]
            pub fn length_squared(self) -> $t {
                self.dot(self)
            }
            /// Length.
            #[inline(always)]
            pub fn length(self) -> $t {
                self.dot(self).sqrt()
            }
            /// Distance to another point.
            #[inline(always)]
            pub fn distance(self, o: Self) -> $t {
                (self - o).length()
            }
            /// The unit vector, or `fallback` where the length is zero, subnormal or not finite.
            #[inline]
            pub fn normalize_or(self, fallback: Self) -> Self {
                self.try_normalize().map_or(fallback, |(n, _)| n)
            }
            /// The unit vector and the length, or `None` where the direction is undefined.
            /// Scaled by the largest component first, so 1e-30 and 1e30 both work.
            #[inline]
            pub fn try_normalize(self) -> Option<(Self, $t)> {
                let m = self.abs().max_component();
                if !(m > $t::MIN_POSITIVE && m <= $t::MAX) {
                    return None;
                }
                let s = self / m;
                let l = s.length();
                Some((s / l, l * m))
            }
            /// Component-wise product.
            #[inline(always)]
            pub fn mul(self, o: Self) -> Self {
                Self::new(self.x * o.x, self.y * o.y, self.z * o.z)
            }
            /// Component-wise absolute value.
            #[inline(always)]
            pub fn abs(self) -> Self {
                Self::new(self.x.abs(), self.y.abs(), self.z.abs())
            }
            /// Component-wise minimum (compare-and-select).
            #[inline(always)]
            pub fn min(self, o: Self) -> Self {
                use crate::scalar::$scalar::min;
                Self::new(min(self.x, o.x), min(self.y, o.y), min(self.z, o.z))
            }
            /// Component-wise maximum (compare-and-select).
            #[inline(always)]
            pub fn max(self, o: Self) -> Self {
                use crate::scalar::$scalar::max;
                Self::new(max(self.x, o.x), max(self.y, o.y), max(self.z, o.z))
            }
            /// Component-wise clamp between two vectors.
            #[inline(always)]
            pub fn clamp(self, lo: Self, hi: Self) -> Self {
                self.max(lo).min(hi)
            }
            /// The largest component.
            #[inline(always)]
            pub fn max_component(self) -> $t {
                use crate::scalar::$scalar::max;
                max(max(self.x, self.y), self.z)
            }
            /// The smallest component.
            #[inline(always)]
            pub fn min_component(self) -> $t {
                use crate::scalar::$scalar::min;
                min(min(self.x, self.y), self.z)
            }
            /// Index (0, 1, 2) of the largest component; the first of equals.
            #[inline]
            pub fn max_axis(self) -> usize {
                if self.x >= self.y && self.x >= self.z {
                    0
                } else if self.y >= self.z {
                    1
                } else {
                    2
                }
            }
            /// True when no component is infinite or NaN.
            #[inline(always)]
            pub fn is_finite(self) -> bool {
                self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
            }
            /// self + (o − self)·t.
            #[inline(always)]
            pub fn lerp(self, o: Self, t: $t) -> Self {
                self + (o - self) * t
            }
            /// Two unit vectors that make a right-handed basis (self, u, v) with this *unit* vector.
            /// Continuous except at −z (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
            #[inline]
            pub fn orthonormal_basis(self) -> (Self, Self) {
                let sign: $t = if self.z >= 0.0 { 1.0 } else { -1.0 };
                let a = -1.0 / (sign + self.z);
                let b = self.x * self.y * a;
                (
                    Self::new(1.0 + sign * self.x * self.x * a, sign * b, -sign * self.x),
                    Self::new(b, sign + self.y * self.y * a, -self.y),
                )
            }
        }

        impl Add for $v {
            type Output = Self;
            #[inline(always)]
            fn add(self, o: Self) -> Self {
                Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
            }
        }
        impl Sub for $v {
            type Output = Self;
            #[inline(always)]
            fn sub(self, o: Self) -> Self {
                Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
            }
        }
        impl Mul<$t> for $v {
            type Output = Self;
            #[inline(always)]
            fn mul(self, s: $t) -> Self {
                Self::new(self.x * s, self.y * s, self.z * s)
            }
        }
        impl Mul<$v> for $t {
            type Output = $v;
            #[inline(always)]
            fn mul(self, v: $v) -> $v {
                v * self
            }
        }
        impl Div<$t> for $v {
            type Output = Self;
            #[inline(always)]
            fn div(self, s: $t) -> Self {
                Self::new(self.x / s, self.y / s, self.z / s)
            }
        }
        impl Neg for $v {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self::new(-self.x, -self.y, -self.z)
            }
        }
        impl AddAssign for $v {
            #[inline(always)]
            fn add_assign(&mut self, o: Self) {
                *self = *self + o;
            }
        }
        impl SubAssign for $v {
            #[inline(always)]
            fn sub_assign(&mut self, o: Self) {
                *self = *self - o;
            }
        }
        impl MulAssign<$t> for $v {
            #[inline(always)]
            fn mul_assign(&mut self, s: $t) {
                *self = *self * s;
            }
        }
        impl Index<usize> for $v {
            type Output = $t;
            /// Component 0, 1 or (any other index) 2.
            #[inline(always)]
            fn index(&self, i: usize) -> &$t {
                match i {
                    0 => &self.x,
                    1 => &self.y,
                    _ => &self.z,
                }
            }
        }
        impl core::ops::IndexMut<usize> for $v {
            #[inline(always)]
            fn index_mut(&mut self, i: usize) -> &mut $t {
                match i {
                    0 => &mut self.x,
                    1 => &mut self.y,
                    _ => &mut self.z,
                }
            }
        }
        impl From<[$t; 3]> for $v {
            fn from(a: [$t; 3]) -> Self {
                Self::from_array(a)
            }
        }
        impl From<$v> for [$t; 3] {
            fn from(v: $v) -> Self {
                v.to_array()
            }
        }
    };
}

vector!(
    Vec3,
    f32,
    f32s,
    "A vector of three `f32`: anything local, such as a velocity, an anchor or a vertex."
);
vector!(DVec3, f64, f64s, "A vector of three `f64`: a position in the world.");

impl Vec3 {
    /// The same vector in double precision.
    #[inline(always)]
    pub fn as_dvec3(self) -> DVec3 {
        DVec3::new(f64::from(self.x), f64::from(self.y), f64::from(self.z))
    }
}

impl DVec3 {
    /// Rounded to single precision.
    #[inline(always)]
    pub fn as_vec3(self) -> Vec3 {
        Vec3::new(self.x as f32, self.y as f32, self.z as f32)
    }
}

impl From<Vec3> for DVec3 {
    fn from(v: Vec3) -> Self {
        v.as_dvec3()
    }
}
