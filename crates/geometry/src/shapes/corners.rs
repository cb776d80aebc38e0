//! Corners of a hull, four abreast: what is asked of all of them (who is farthest, what box holds them) is asked in lanes, with the
//! same bits as one by one.

use crate::Aabb;
use jounce_math::{Mat3, Vec3, scalar::f32s};

/// Corners per block.
const WIDE: usize = 4;

/// x, y and z of four corners.
type Block = [[f32; WIDE]; 3];

/// Blocks of corners; the last one is filled up with its last corner.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Corners(Vec<Block>);

impl Corners {
    pub fn new(points: &[Vec3]) -> Self {
        let block = |part: &[Vec3]| {
            let at = |i: usize| part[i.min(part.len() - 1)];
            [0, 1, 2].map(|axis| core::array::from_fn(|i| at(i)[axis]))
        };
        Self(points.chunks(WIDE).map(block).collect())
    }

    /// The first of those farthest along `d`.
    #[inline]
    pub fn farthest(&self, d: Vec3) -> usize {
        let mut far = [f32::NEG_INFINITY; WIDE];
        let mut at = [0_u32; WIDE];
        for (k, [x, y, z]) in (0_u32..).zip(&self.0) {
            for i in 0..WIDE {
                let s = x[i] * d.x + y[i] * d.y + z[i] * d.z;
                let farther = s > far[i];
                far[i] = if farther { s } else { far[i] };
                at[i] = if farther { k } else { at[i] };
            }
        }
        let one = |i: usize| (far[i], at[i] as usize * WIDE + i);
        // Selects, no jumps: which lane wins cannot be foreseen.
        let farther = |x: (f32, usize), y: (f32, usize)| {
            let second = (y.0 > x.0) | ((y.0 == x.0) & (y.1 < x.1));
            (if second { y.0 } else { x.0 }, if second { y.1 } else { x.1 })
        };
        farther(farther(one(0), one(1)), farther(one(2), one(3))).1
    }

    /// The box around all corners, turned by `m`.
    pub fn bounds(&self, m: &Mat3) -> Aabb {
        let mut lo = [[f32::INFINITY; WIDE]; 3];
        let mut hi = [[f32::NEG_INFINITY; WIDE]; 3];
        for [x, y, z] in &self.0 {
            for axis in 0..3 {
                let (cx, cy, cz) = (m.cx[axis], m.cy[axis], m.cz[axis]);
                for i in 0..WIDE {
                    let s = cx * x[i] + cy * y[i] + cz * z[i];
                    lo[axis][i] = f32s::min(lo[axis][i], s);
                    hi[axis][i] = f32s::max(hi[axis][i], s);
                }
            }
        }
        let least = lo.map(|l| f32s::min(f32s::min(l[0], l[1]), f32s::min(l[2], l[3])));
        let most = hi.map(|h| f32s::max(f32s::max(h[0], h[1]), f32s::max(h[2], h[3])));
        Aabb::new(Vec3::from_array(least), Vec3::from_array(most))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use jounce_math::Quat;

    #[test]
    fn lanes_say_what_one_by_one_says() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            // Few values, so that many are equally far.
            (state >> 28) as f32 * 0.25 - 2.0
        };
        for n in 1..40 {
            let points: Vec<Vec3> = (0..n).map(|_| Vec3::new(random(), random(), random())).collect();
            let corners = Corners::new(&points);
            for _ in 0..50 {
                let d = Vec3::new(random(), random(), random());
                let mut want = 0;
                for (i, p) in points.iter().enumerate() {
                    if p.dot(d) > points[want].dot(d) {
                        want = i;
                    }
                }
                assert_eq!(corners.farthest(d), want, "{n}: {points:?} along {d:?}");
                let m = Quat::from_axis_angle(Vec3::new(1.0, random(), random()), random()).to_mat3();
                assert_eq!(corners.bounds(&m), Aabb::from_points(points.iter().map(|&p| m * p)));
            }
            assert!(corners.farthest(Vec3::splat(f32::NAN)) < n);
        }
    }
}
