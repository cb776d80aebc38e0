//! 3×3 matrices, `f32` and `f64`, stored by columns.

use crate::{DVec3, Vec3};
use core::ops::{Add, Mul, Sub};

macro_rules! matrix {
    ($m:ident, $v:ident, $t:ident) => {
        /// A 3×3 matrix, stored by columns.
        #[derive(Clone, Copy, Default, PartialEq)]
        #[repr(C)]
        pub struct $m {
            /// First column.
            pub cx: $v,
            /// Second column.
            pub cy: $v,
            /// Third column.
            pub cz: $v,
        }

        /// Row by row: messages show it.
        impl core::fmt::Debug for $m {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                let (x, y, z) = (self.cx, self.cy, self.cz);
                [[x.x, y.x, z.x], [x.y, y.y, z.y], [x.z, y.z, z.z]].fmt(f)
            }
        }

        impl $m {
            /// All zeros.
            pub const ZERO: Self = Self { cx: $v::ZERO, cy: $v::ZERO, cz: $v::ZERO };
            /// The identity.
            pub const IDENTITY: Self = Self { cx: $v::X, cy: $v::Y, cz: $v::Z };

            /// From three columns.
            #[inline(always)]
            pub const fn from_columns(cx: $v, cy: $v, cz: $v) -> Self {
                Self { cx, cy, cz }
            }
            /// A diagonal matrix.
            #[inline(always)]
            pub const fn from_diagonal(d: $v) -> Self {
                Self { cx: $v::new(d.x, 0.0, 0.0), cy: $v::new(0.0, d.y, 0.0), cz: $v::new(0.0, 0.0, d.z) }
            }
            /// The diagonal.
            pub const fn diagonal(&self) -> $v {
                $v::new(self.cx.x, self.cy.y, self.cz.z)
            }
            /// a bᵀ.
            pub fn outer(a: $v, b: $v) -> Self {
                Self::from_columns(a * b.x, a * b.y, a * b.z)
            }
            /// The matrix S with S v = a × v.
            pub const fn skew(a: $v) -> Self {
                Self { cx: $v::new(0.0, a.z, -a.y), cy: $v::new(-a.z, 0.0, a.x), cz: $v::new(a.y, -a.x, 0.0) }
            }
            /// Rows and columns exchanged.
            #[inline(always)]
            pub const fn transpose(&self) -> Self {
                Self {
                    cx: $v::new(self.cx.x, self.cy.x, self.cz.x),
                    cy: $v::new(self.cx.y, self.cy.y, self.cz.y),
                    cz: $v::new(self.cx.z, self.cy.z, self.cz.z),
                }
            }
            /// Mᵀ v.
            #[inline(always)]
            pub fn transpose_mul(&self, v: $v) -> $v {
                $v::new(self.cx.dot(v), self.cy.dot(v), self.cz.dot(v))
            }
            /// Determinant.
            pub fn determinant(&self) -> $t {
                self.cx.dot(self.cy.cross(self.cz))
            }
            /// The inverse, or `None` where the determinant is zero, subnormal or not finite.
            pub fn inverse(&self) -> Option<Self> {
                let r0 = self.cy.cross(self.cz);
                let r1 = self.cz.cross(self.cx);
                let r2 = self.cx.cross(self.cy);
                let det = self.cx.dot(r0);
                if !(det.abs() > $t::MIN_POSITIVE && det.is_finite()) {
                    return None;
                }
                let s = 1.0 / det;
                Some(Self::from_columns(r0 * s, r1 * s, r2 * s).transpose())
            }
            /// Every entry times `s`.
            #[inline(always)]
            pub fn scale(&self, s: $t) -> Self {
                Self::from_columns(self.cx * s, self.cy * s, self.cz * s)
            }
            /// Solves M x = b by Cramer's rule; zero where M is singular.
            #[inline]
            pub fn solve(&self, b: $v) -> $v {
                let r = self.cy.cross(self.cz);
                let det = self.cx.dot(r);
                let s = if det != 0.0 { 1.0 / det } else { 0.0 };
                $v::new(s * r.dot(b), s * self.cx.dot(b.cross(self.cz)), s * self.cx.dot(self.cy.cross(b)))
            }
            /// Eigenvalues (unordered) and the rotation R whose columns are the eigenvectors of a
            /// *symmetric* matrix: M = R diag(λ) Rᵀ. Cyclic Jacobi, fixed number of sweeps.
            pub fn symmetric_eigen(&self) -> ($v, Self) {
                let mut a = *self;
                let mut r = Self::IDENTITY;
                for _ in 0..12 {
                    for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                        let apq = a.at(p, q);
                        if apq == 0.0 {
                            continue;
                        }
                        let theta = (a.at(q, q) - a.at(p, p)) / (2.0 * apq);
                        let sign = if theta >= 0.0 { 1.0 } else { -1.0 };
                        let t = sign / (theta.abs() + (theta * theta + 1.0).sqrt());
                        let c = 1.0 / (t * t + 1.0).sqrt();
                        let s = t * c;
                        let mut g = Self::IDENTITY;
                        *g.at_mut(p, p) = c;
                        *g.at_mut(q, q) = c;
                        *g.at_mut(p, q) = s;
                        *g.at_mut(q, p) = -s;
                        a = g.transpose() * a * g;
                        *a.at_mut(p, q) = 0.0;
                        *a.at_mut(q, p) = 0.0;
                        r = r * g;
                    }
                }
                if r.determinant() < 0.0 {
                    r.cz = -r.cz;
                }
                (a.diagonal(), r)
            }
            /// Entry of row `r`, column `c`.
            #[inline(always)]
            pub fn at(&self, r: usize, c: usize) -> $t {
                match c {
                    0 => self.cx[r],
                    1 => self.cy[r],
                    _ => self.cz[r],
                }
            }
            fn at_mut(&mut self, r: usize, c: usize) -> &mut $t {
                match c {
                    0 => &mut self.cx[r],
                    1 => &mut self.cy[r],
                    _ => &mut self.cz[r],
                }
            }
            /// True when no entry is infinite or NaN.
            pub fn is_finite(&self) -> bool {
                self.cx.is_finite() && self.cy.is_finite() && self.cz.is_finite()
            }
        }

        impl Mul<$v> for $m {
            type Output = $v;
            #[inline(always)]
            fn mul(self, v: $v) -> $v {
                self.cx * v.x + self.cy * v.y + self.cz * v.z
            }
        }
        impl Mul for $m {
            type Output = Self;
            #[inline(always)]
            fn mul(self, o: Self) -> Self {
                Self::from_columns(self * o.cx, self * o.cy, self * o.cz)
            }
        }
        impl Add for $m {
            type Output = Self;
            #[inline(always)]
            fn add(self, o: Self) -> Self {
                Self::from_columns(self.cx + o.cx, self.cy + o.cy, self.cz + o.cz)
            }
        }
        impl Sub for $m {
            type Output = Self;
            #[inline(always)]
            fn sub(self, o: Self) -> Self {
                Self::from_columns(self.cx - o.cx, self.cy - o.cy, self.cz - o.cz)
            }
        }
    };
}

matrix!(Mat3, Vec3, f32);
matrix!(DMat3, DVec3, f64);

impl Mat3 {
    /// The same matrix in double precision.
    pub fn as_dmat3(self) -> DMat3 {
        DMat3::from_columns(self.cx.as_dvec3(), self.cy.as_dvec3(), self.cz.as_dvec3())
    }
}

impl DMat3 {
    /// Rounded to single precision.
    pub fn as_mat3(self) -> Mat3 {
        Mat3::from_columns(self.cx.as_vec3(), self.cy.as_vec3(), self.cz.as_vec3())
    }
}
