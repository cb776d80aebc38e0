//! Unit quaternions, `f32` and `f64`, stored x, y, z, w.

use crate::{DMat3, DVec3, Mat3, Vec3};
use core::ops::Mul;

macro_rules! quaternion {
    ($q:ident, $v:ident, $m:ident, $t:ident, $scalar:ident) => {
        /// A rotation as a unit quaternion (x, y, z, w).
        #[derive(Clone, Copy, PartialEq)]
        #[repr(C)]
        pub struct $q {
            /// Vector part, x.
            pub x: $t,
            /// Vector part, y.
            pub y: $t,
            /// Vector part, z.
            pub z: $t,
            /// Scalar part.
            pub w: $t,
        }

        /// [x, y, z, w]: messages show it.
        impl core::fmt::Debug for $q {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                [self.x, self.y, self.z, self.w].fmt(f)
            }
        }

        impl Default for $q {
            fn default() -> Self {
                Self::IDENTITY
            }
        }

        impl $q {
            /// No rotation.
            pub const IDENTITY: Self = Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };

            /// The quaternion (x, y, z, w), taken as it is.
            #[inline(always)]
            pub const fn new(x: $t, y: $t, z: $t, w: $t) -> Self {
                Self { x, y, z, w }
            }
            /// From an array [x, y, z, w].
            pub const fn from_array(a: [$t; 4]) -> Self {
                Self::new(a[0], a[1], a[2], a[3])
            }
            /// As an array [x, y, z, w].
            pub const fn to_array(self) -> [$t; 4] {
                [self.x, self.y, self.z, self.w]
            }
            /// Turn of `angle` radians about a unit `axis`.
            pub fn from_axis_angle(axis: $v, angle: $t) -> Self {
                use crate::scalar::$scalar::{cos, sin};
                let (s, c) = (sin(0.5 * angle), cos(0.5 * angle));
                Self::new(axis.x * s, axis.y * s, axis.z * s, c)
            }
            /// Turns about the fixed x, then y, then z axis, in radians.
            pub fn from_euler_xyz(angles: $v) -> Self {
                let x = Self::from_axis_angle($v::X, angles.x);
                let y = Self::from_axis_angle($v::Y, angles.y);
                let z = Self::from_axis_angle($v::Z, angles.z);
                z * y * x
            }
            /// The shortest turn that takes unit vector `a` to unit vector `b`.
            pub fn from_rotation_arc(a: $v, b: $v) -> Self {
                let w = 1.0 + a.dot(b);
                if w < 1e-6 {
                    let (u, _) = a.orthonormal_basis();
                    return Self::new(u.x, u.y, u.z, 0.0);
                }
                let c = a.cross(b);
                Self::new(c.x, c.y, c.z, w).normalize()
            }
            /// Vector part.
            #[inline(always)]
            pub fn xyz(self) -> $v {
                $v::new(self.x, self.y, self.z)
            }
            /// Four-component dot product.
            #[inline(always)]
            pub fn dot(self, o: Self) -> $t {
                self.x * o.x + self.y * o.y + self.z * o.z + self.w * o.w
            }
            /// Length of the four components (1 for a rotation).
            #[inline(always)]
            pub fn length(self) -> $t {
                self.dot(self).sqrt()
            }
            /// Scaled to length 1; the identity where that is undefined.
            #[inline]
            pub fn normalize(self) -> Self {
                let l = self.length();
                if !(l > $t::MIN_POSITIVE && l <= $t::MAX) {
                    return Self::IDENTITY;
                }
                let s = 1.0 / l;
                Self::new(self.x * s, self.y * s, self.z * s, self.w * s)
            }
            /// The opposite turn.
            #[inline(always)]
            pub fn conjugate(self) -> Self {
                Self::new(-self.x, -self.y, -self.z, self.w)
            }
            /// Rotates a vector.
            #[inline(always)]
            pub fn rotate(self, v: $v) -> $v {
                let u = self.xyz();
                let t = u.cross(v) * 2.0;
                v + t * self.w + u.cross(t)
            }
            /// Rotates a vector the opposite way.
            #[inline(always)]
            pub fn inverse_rotate(self, v: $v) -> $v {
                self.conjugate().rotate(v)
            }
            /// self⁻¹ · o.
            #[inline(always)]
            pub fn inverse_mul(self, o: Self) -> Self {
                self.conjugate() * o
            }
            /// One first-order step of q′ = ½ ω q by the rotation vector `w` = ω Δt (world frame), normalised.
            #[inline(always)]
            pub fn integrate(self, w: $v) -> Self {
                let d = Self::new(w.x, w.y, w.z, 0.0) * self;
                Self::new(self.x + 0.5 * d.x, self.y + 0.5 * d.y, self.z + 0.5 * d.z, self.w + 0.5 * d.w)
                    .normalize()
            }
            /// Normalised linear interpolation along the shorter arc.
            pub fn nlerp(self, o: Self, t: $t) -> Self {
                let s = if self.dot(o) < 0.0 { -1.0 } else { 1.0 };
                let u = 1.0 - t;
                Self::new(
                    u * self.x + t * s * o.x,
                    u * self.y + t * s * o.y,
                    u * self.z + t * s * o.z,
                    u * self.w + t * s * o.w,
                )
                .normalize()
            }
            /// Rotation angle in radians, 0…π.
            pub fn angle(self) -> $t {
                use crate::scalar::$scalar::atan2;
                2.0 * atan2(self.xyz().length(), self.w.abs())
            }
            /// The rotation matrix (columns are the rotated axes).
            #[inline]
            pub fn to_mat3(self) -> $m {
                let (x, y, z, w) = (self.x, self.y, self.z, self.w);
                let (xx, yy, zz) = (x * x, y * y, z * z);
                let (xy, xz, yz) = (x * y, x * z, y * z);
                let (xw, yw, zw) = (x * w, y * w, z * w);
                $m::from_columns(
                    $v::new(1.0 - 2.0 * (yy + zz), 2.0 * (xy + zw), 2.0 * (xz - yw)),
                    $v::new(2.0 * (xy - zw), 1.0 - 2.0 * (xx + zz), 2.0 * (yz + xw)),
                    $v::new(2.0 * (xz + yw), 2.0 * (yz - xw), 1.0 - 2.0 * (xx + yy)),
                )
            }
            /// The quaternion of a rotation matrix (Shepperd's method: the largest term is the pivot).
            pub fn from_mat3(m: &$m) -> Self {
                let (a, b, c) = (m.cx.x, m.cy.y, m.cz.z);
                let q = if a + b + c > 0.0 {
                    Self::new(m.cy.z - m.cz.y, m.cz.x - m.cx.z, m.cx.y - m.cy.x, 1.0 + a + b + c)
                } else if a > b && a > c {
                    Self::new(1.0 + a - b - c, m.cx.y + m.cy.x, m.cz.x + m.cx.z, m.cy.z - m.cz.y)
                } else if b > c {
                    Self::new(m.cx.y + m.cy.x, 1.0 - a + b - c, m.cy.z + m.cz.y, m.cz.x - m.cx.z)
                } else {
                    Self::new(m.cz.x + m.cx.z, m.cy.z + m.cz.y, 1.0 - a - b + c, m.cx.y - m.cy.x)
                };
                q.normalize()
            }
            /// True when no component is infinite or NaN.
            pub fn is_finite(self) -> bool {
                self.x.is_finite() && self.y.is_finite() && self.z.is_finite() && self.w.is_finite()
            }
        }

        impl Mul for $q {
            type Output = Self;
            /// Hamilton product: the turn `o`, then the turn `self`.
            #[inline(always)]
            fn mul(self, o: Self) -> Self {
                Self::new(
                    self.w * o.x + self.x * o.w + self.y * o.z - self.z * o.y,
                    self.w * o.y - self.x * o.z + self.y * o.w + self.z * o.x,
                    self.w * o.z + self.x * o.y - self.y * o.x + self.z * o.w,
                    self.w * o.w - self.x * o.x - self.y * o.y - self.z * o.z,
                )
            }
        }
    };
}

quaternion!(Quat, Vec3, Mat3, f32, f32s);
quaternion!(DQuat, DVec3, DMat3, f64, f64s);

impl Quat {
    /// The same rotation in double precision (not renormalised).
    pub fn as_dquat(self) -> DQuat {
        DQuat::new(f64::from(self.x), f64::from(self.y), f64::from(self.z), f64::from(self.w))
    }
}

impl DQuat {
    /// Rounded to single precision.
    pub fn as_quat(self) -> Quat {
        Quat::new(self.x as f32, self.y as f32, self.z as f32, self.w as f32)
    }
}
