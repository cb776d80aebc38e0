//! A box that is held against many.

use crate::Aabb;

/// Like [`Aabb::overlaps`], without branches: of boxes near a query every third comparison decides, and which one is chance.
#[derive(Clone, Copy)]
pub(super) struct Probe {
    below: [f32; 4],
    above: [f32; 4],
}

impl Probe {
    #[inline(always)]
    pub fn new(b: &Aabb) -> Self {
        Self {
            below: [b.max.x, b.max.y, b.max.z, f32::INFINITY],
            above: [f32::NEG_INFINITY, b.min.x, b.min.y, b.min.z],
        }
    }
    /// Touching counts. Four numbers of the box at a time, as they lie in memory, twice: two loads and two comparisons.
    #[inline(always)]
    pub fn meets(&self, b: &Aabb) -> bool {
        let low = [b.min.x, b.min.y, b.min.z, b.max.x];
        let high = [b.min.z, b.max.x, b.max.y, b.max.z];
        let mut apart = 0_u32;
        for i in 0..4 {
            apart |= u32::from((low[i] > self.below[i]) | (high[i] < self.above[i]));
        }
        apart == 0
    }
}

#[cfg(test)]
mod tests {
    use super::Probe;
    use crate::Aabb;
    use jounce_math::Vec3;

    /// All ways in which two intervals may lie on each axis, ends and infinite ones too.
    #[test]
    fn says_what_boxes_say() {
        let ends = [f32::NEG_INFINITY, -1.0, 0.0, 1.0, 2.0, f32::INFINITY];
        let pairs: Vec<(f32, f32)> =
            ends.iter().flat_map(|&a| ends.map(|b| (a, b))).filter(|(a, b)| a <= b).collect();
        let on = |axis: usize, (lo, hi): (f32, f32)| {
            let mut b = Aabb::new(Vec3::ZERO, Vec3::ONE);
            (b.min[axis], b.max[axis]) = (lo, hi);
            b
        };
        for axis in 0..3 {
            for &p in &pairs {
                for &q in &pairs {
                    let (a, b) = (on(axis, p), on(axis, q));
                    assert_eq!(Probe::new(&a).meets(&b), a.overlaps(&b), "{a:?} {b:?}");
                }
                assert!(!Probe::new(&on(axis, (-1.0, 1.0))).meets(&Aabb::EMPTY));
            }
        }
    }
}
