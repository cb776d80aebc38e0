//! Vectors in lanes.

use crate::{LANES_MAX, Lanes, six};

/// A vector a lane, in registers.
#[derive(Clone, Copy, Debug)]
pub struct Wide3<L> {
    /// Component along x.
    pub x: L,
    /// Component along y.
    pub y: L,
    /// Component along z.
    pub z: L,
}

impl<L: Lanes> Wide3<L> {
    /// The vectors with these components.
    #[inline(always)]
    pub fn new(x: L, y: L, z: L) -> Self {
        Self { x, y, z }
    }
    /// From three fields over [`LANES_MAX`] rows, row `at` in the first lane.
    ///
    /// # Panics
    /// If there are fewer rows from there than lanes.
    #[inline(always)]
    pub fn load(v: &[[f32; LANES_MAX]; 3], at: usize) -> Self {
        Self { x: L::load(&v[0][at..]), y: L::load(&v[1][at..]), z: L::load(&v[2][at..]) }
    }
    /// The reverse of [`load`](Self::load).
    ///
    /// # Panics
    /// Likewise.
    #[inline(always)]
    pub fn store(self, v: &mut [[f32; LANES_MAX]; 3], at: usize) {
        self.x.store(&mut v[0][at..]);
        self.y.store(&mut v[1][at..]);
        self.z.store(&mut v[2][at..]);
    }
    /// The scalar product.
    #[inline(always)]
    pub fn dot(self, o: Self) -> L {
        self.x * o.x + self.y * o.y + self.z * o.z
    }
    /// The vector product.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self::new(self.y * o.z - self.z * o.y, self.z * o.x - self.x * o.z, self.x * o.y - self.y * o.x)
    }
    /// The sum.
    #[inline(always)]
    #[expect(clippy::should_implement_trait, reason = "methods chain, and all of them are always inlined")]
    pub fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
    /// The difference.
    #[inline(always)]
    #[expect(clippy::should_implement_trait, reason = "methods chain, and all of them are always inlined")]
    pub fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
    /// Every component times `s`.
    #[inline(always)]
    pub fn scale(self, s: L) -> Self {
        Self::new(self.x * s, self.y * s, self.z * s)
    }
    /// Every component's absolute value.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self::new(self.x.abs(), self.y.abs(), self.z.abs())
    }
    /// T v for a symmetric tensor stored xx, yy, zz, xy, xz, yz.
    ///
    /// # Panics
    /// As [`load`](Self::load).
    #[inline(always)]
    pub fn times(self, t: &[[f32; LANES_MAX]; 6], at: usize) -> Self {
        self.turned(&six(
            #[inline(always)]
            |i: usize| L::load(&t[i][at..]),
        ))
    }
    /// The same for a tensor that may be `round`: xx times the unit matrix.
    ///
    /// # Panics
    /// As [`load`](Self::load).
    #[inline(always)]
    pub fn through(self, t: &[[f32; LANES_MAX]; 6], round: bool, at: usize) -> Self {
        if round { self.scale(L::load(&t[0][at..])) } else { self.times(t, at) }
    }
    /// The same for a tensor in registers.
    #[inline(always)]
    pub fn turned(self, t: &[L; 6]) -> Self {
        let [xx, yy, zz, xy, xz, yz] = *t;
        Self::new(
            xx * self.x + xy * self.y + xz * self.z,
            xy * self.x + yy * self.y + yz * self.z,
            xz * self.x + yz * self.y + zz * self.z,
        )
    }
}
