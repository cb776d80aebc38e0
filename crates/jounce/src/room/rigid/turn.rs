//! Rotations in lanes, in the order of operations of `Quat` and `DQuat`: lanes turn bit for bit as one by one. (Those of the joints' lanes,
//! `WideQuat`, are others.)

use jounce_lanes::{Doubles, Lanes};
use std::ops::{Add, Mul, Neg, Sub};

/// What arithmetic alone needs of lanes.
pub(crate) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + Neg<Output = T>> Number for T {}

#[inline(always)]
pub(crate) fn add<T: Number>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
#[inline(always)]
pub(crate) fn times<T: Number>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}
#[inline(always)]
pub(crate) fn scale<T: Number>(a: [T; 3], k: T) -> [T; 3] {
    times(a, [k; 3])
}
#[inline(always)]
pub(crate) fn dot<T: Number>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
#[inline(always)]
pub(crate) fn cross<T: Number>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A rotation per lane, x, y, z, w.
#[derive(Clone, Copy)]
pub(crate) struct Turn<T>(pub [T; 4]);

impl<T: Number> Turn<T> {
    /// The opposite turn.
    #[inline(always)]
    pub fn back(self) -> Self {
        let [x, y, z, w] = self.0;
        Self([-x, -y, -z, w])
    }
    /// Vector part.
    #[inline(always)]
    pub fn xyz(self) -> [T; 3] {
        let [x, y, z, _] = self.0;
        [x, y, z]
    }
    #[inline(always)]
    pub fn rotate(self, v: [T; 3]) -> [T; 3] {
        let c = cross(self.xyz(), v);
        // Twice, exactly.
        let t = add(c, c);
        add(add(v, scale(t, self.0[3])), cross(self.xyz(), t))
    }
    /// The turn `o`, then this.
    #[inline(always)]
    pub fn after(self, o: Self) -> Self {
        let ([ax, ay, az, aw], [bx, by, bz, bw]) = (self.0, o.0);
        Self([
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ])
    }
}

macro_rules! normalize {
    ($name:ident, $wide:ident, $float:ident) => {
        /// As `normalize` of the quaternions.
        #[inline(always)]
        pub(crate) fn $name<L: $wide>(q: Turn<L>) -> Turn<L> {
            let [x, y, z, w] = q.0;
            let l = (x * x + y * y + z * z + w * w).sqrt();
            let fine = l.gt(L::splat($float::MIN_POSITIVE)) & l.le(L::splat($float::MAX));
            let (one, zero) = (L::splat(1.0), L::zero());
            let s = one / l;
            Turn([
                L::select(fine, x * s, zero),
                L::select(fine, y * s, zero),
                L::select(fine, z * s, zero),
                L::select(fine, w * s, one),
            ])
        }
    };
}
normalize!(normalize, Lanes, f32);
normalize!(normalize_doubles, Doubles, f64);
