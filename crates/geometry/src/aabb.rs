//! Axis-aligned boxes.

use jounce_math::{Pose, Vec3, scalar::f32s};

/// An axis-aligned box, `min` ≤ `max` in every component.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Aabb {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Aabb {
    /// Contains nothing; the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// From two corners (min ≤ max is the caller's promise).
    pub const fn new(min: Vec3, max: Vec3) -> Self {
        Self { min, max }
    }
    /// Around `center` with half extents `half`.
    pub fn from_center(center: Vec3, half: Vec3) -> Self {
        Self { min: center - half, max: center + half }
    }
    /// Around points; [`Aabb::EMPTY`] for none.
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }
    /// The smallest box around both.
    #[inline(always)]
    pub fn union(&self, o: &Self) -> Self {
        Self { min: self.min.min(o.min), max: self.max.max(o.max) }
    }
    /// Touching counts.
    #[inline(always)]
    pub fn overlaps(&self, o: &Self) -> bool {
        self.min.x <= o.max.x
            && o.min.x <= self.max.x
            && self.min.y <= o.max.y
            && o.min.y <= self.max.y
            && self.min.z <= o.max.z
            && o.min.z <= self.max.z
    }
    /// Is `o` wholly inside?
    #[inline(always)]
    pub fn contains(&self, o: &Self) -> bool {
        self.min.x <= o.min.x
            && self.min.y <= o.min.y
            && self.min.z <= o.min.z
            && self.max.x >= o.max.x
            && self.max.y >= o.max.y
            && self.max.z >= o.max.z
    }
    /// Is the point inside or on the surface?
    pub fn contains_point(&self, p: Vec3) -> bool {
        self.contains(&Self::new(p, p))
    }
    /// Grown by `margin` on every side.
    #[inline(always)]
    pub fn expanded(&self, margin: f32) -> Self {
        Self { min: self.min - Vec3::splat(margin), max: self.max + Vec3::splat(margin) }
    }
    /// Centre.
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }
    /// Half extents.
    pub fn half(&self) -> Vec3 {
        (self.max - self.min) * 0.5
    }
    /// Surface area (the cost measure of trees).
    #[inline(always)]
    pub fn area(&self) -> f32 {
        let d = self.max - self.min;
        2.0 * (d.x * d.y + d.y * d.z + d.z * d.x)
    }
    /// The axis-aligned box around this box placed at `pose`.
    pub fn transformed(&self, pose: &Pose) -> Self {
        let m = pose.q.to_mat3();
        let (c, h) = (self.center(), self.half());
        let half = m.cx.abs() * h.x + m.cy.abs() * h.y + m.cz.abs() * h.z;
        Self::from_center(pose.transform_point(c), half)
    }
    /// Where the ray `origin + t·dir`, 0 ≤ t ≤ `max_t`, enters the box; `inv_dir` is 1/dir by component
    /// (±∞ for a zero component). `None` for a miss.
    #[inline]
    pub fn ray_entry(&self, origin: Vec3, inv_dir: Vec3, max_t: f32) -> Option<f32> {
        let mut t0 = 0.0f32;
        let mut t1 = max_t;
        for i in 0..3 {
            let (near, far) =
                if inv_dir[i] >= 0.0 { (self.min[i], self.max[i]) } else { (self.max[i], self.min[i]) };
            // 0·∞ is NaN where the ray runs inside a slab's plane: the selects then keep t0 and t1. The far
            // side gets the 3 roundings of its computation as slack, so that no ray slips between boxes that
            // touch (Ize 2013, "Robust BVH Ray Traversal").
            t0 = f32s::max((near - origin[i]) * inv_dir[i], t0);
            t1 = f32s::min((far - origin[i]) * inv_dir[i] * (1.0 + 3.0 * f32::EPSILON), t1);
        }
        (t0 <= t1).then_some(t0)
    }
    /// True when no corner is infinite or NaN.
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(b: &Aabb, origin: Vec3, dir: Vec3) -> Option<f32> {
        b.ray_entry(origin, Vec3::new(1.0 / dir.x, 1.0 / dir.y, 1.0 / dir.z), 10.0)
    }

    /// 0 · ∞ turns up where a ray runs in the plane of a side: touching counts, whatever the signs of the zeros.
    #[test]
    fn rays_in_the_plane_of_a_side_hit() {
        let cube = Aabb::new(Vec3::ZERO, Vec3::ONE);
        let flat = Aabb::new(Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0));
        for zero in [0.0, -0.0] {
            for (y, z) in [(0.0, 0.0), (1.0, 0.5), (0.0, 1.0), (1.0, 1.0)] {
                let o = Vec3::new(-2.0, y, z);
                assert_eq!(entry(&cube, o, Vec3::new(1.0, zero, zero)), Some(2.0));
                assert_eq!(entry(&cube, o, Vec3::new(-1.0, zero, zero)), None);
                assert_eq!(
                    entry(&cube, o + Vec3::new(5.0, 0.0, 0.0), Vec3::new(-1.0, zero, zero)),
                    Some(2.0)
                );
                assert_eq!(entry(&cube, o + Vec3::new(0.0, 0.0, 2.0), Vec3::new(1.0, zero, zero)), None);
            }
            assert_eq!(entry(&flat, Vec3::new(-2.0, 0.0, 0.5), Vec3::new(1.0, zero, zero)), Some(2.0));
            assert_eq!(entry(&flat, Vec3::new(0.5, 3.0, 0.5), Vec3::new(zero, -1.0, zero)), Some(3.0));
        }
        assert_eq!(entry(&cube, Vec3::splat(0.5), Vec3::X), Some(0.0));
    }

    #[test]
    fn transformed_box_holds_its_corners() {
        let b = Aabb::new(Vec3::new(-1.0, 2.0, 0.5), Vec3::new(3.0, 2.5, 4.0));
        let q = jounce_math::Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 1.1);
        let pose = Pose::new(Vec3::new(5.0, -3.0, 1.0), q);
        let corners = (0..8u32).map(|k| {
            let pick = |bit: u32, lo: f32, hi: f32| if k & bit == 0 { lo } else { hi };
            pose.transform_point(Vec3::new(
                pick(1, b.min.x, b.max.x),
                pick(2, b.min.y, b.max.y),
                pick(4, b.min.z, b.max.z),
            ))
        });
        let (want, got) = (Aabb::from_points(corners), b.transformed(&pose));
        assert!((want.min - got.min).length() < 1e-5 && (want.max - got.max).length() < 1e-5);
    }
}
