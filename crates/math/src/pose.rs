//! Rigid transforms: rotation then translation.

use crate::{DVec3, Quat, Vec3};

/// A frame relative to another local frame: x ↦ q x + p, all `f32`.
#[derive(Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub struct Pose {
    /// Translation, metres.
    pub p: Vec3,
    /// Rotation.
    pub q: Quat,
}

/// "p turned q": messages show it.
impl core::fmt::Debug for Pose {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?} turned {:?}", self.p, self.q)
    }
}

impl Pose {
    /// No translation, no rotation.
    pub const IDENTITY: Self = Self { p: Vec3::ZERO, q: Quat::IDENTITY };

    /// From translation and rotation.
    #[inline(always)]
    pub const fn new(p: Vec3, q: Quat) -> Self {
        Self { p, q }
    }
    /// A pure translation.
    pub const fn from_translation(p: Vec3) -> Self {
        Self { p, q: Quat::IDENTITY }
    }
    /// q x + p.
    #[inline(always)]
    pub fn transform_point(&self, x: Vec3) -> Vec3 {
        self.q.rotate(x) + self.p
    }
    /// q⁻¹ (x − p).
    #[inline(always)]
    pub fn inverse_transform_point(&self, x: Vec3) -> Vec3 {
        self.q.inverse_rotate(x - self.p)
    }
    /// The transform `o`, then `self`.
    #[inline(always)]
    pub fn compose(&self, o: &Self) -> Self {
        Self { p: self.transform_point(o.p), q: self.q * o.q }
    }
    /// self⁻¹ · o: the frame `o` as seen from the frame `self`.
    #[inline(always)]
    pub fn relative(&self, o: &Self) -> Self {
        Self { p: self.inverse_transform_point(o.p), q: self.q.inverse_mul(o.q) }
    }
    /// The inverse transform.
    #[inline(always)]
    pub fn inverse(&self) -> Self {
        let q = self.q.conjugate();
        Self { p: -q.rotate(self.p), q }
    }
    /// True when no component is infinite or NaN.
    pub fn is_finite(&self) -> bool {
        self.p.is_finite() && self.q.is_finite()
    }
}

/// A frame in the world: `f64` position, `f32` rotation.
#[derive(Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub struct WorldPose {
    /// Position in the world, metres.
    pub p: DVec3,
    /// Rotation.
    pub q: Quat,
}

/// "p turned q": messages show it.
impl core::fmt::Debug for WorldPose {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?} turned {:?}", self.p, self.q)
    }
}

impl WorldPose {
    /// At the origin, not rotated.
    pub const IDENTITY: Self = Self { p: DVec3::ZERO, q: Quat::IDENTITY };

    /// From position and rotation.
    #[inline(always)]
    pub const fn new(p: DVec3, q: Quat) -> Self {
        Self { p, q }
    }
    /// A local point in the world.
    #[inline(always)]
    pub fn transform_point(&self, x: Vec3) -> DVec3 {
        self.p + self.q.rotate(x).as_dvec3()
    }
    /// A world point in this frame. The subtraction is in `f64`.
    #[inline(always)]
    pub fn inverse_transform_point(&self, x: DVec3) -> Vec3 {
        self.q.inverse_rotate((x - self.p).as_vec3())
    }
    /// A local frame in the world.
    #[inline(always)]
    pub fn compose(&self, o: &Pose) -> Self {
        Self { p: self.transform_point(o.p), q: self.q * o.q }
    }
    /// The frame `o` as seen from this one. The subtraction is in `f64`.
    #[inline(always)]
    pub fn relative(&self, o: &Self) -> Pose {
        Pose { p: self.inverse_transform_point(o.p), q: self.q.inverse_mul(o.q) }
    }
    /// True when no component is infinite or NaN.
    pub fn is_finite(&self) -> bool {
        self.p.is_finite() && self.q.is_finite()
    }
}
