//! What kernels over several pairs share: a pair's record, rotations in lanes.

use jounce_lanes::{Lanes, Wide3};
use jounce_math::{Pose, Quat, Vec3};

/// A pair of shapes that are known by a few lengths: a line of memory, of which kernels read several at a time.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct PairRow {
    /// Pose of B in A's frame, and the margin.
    place: [f32; 8],
    /// Those of A, those of B; what is known of the last test.
    lengths: [f32; 8],
}

impl PairRow {
    /// Where B is, and how far ahead to look, m.
    pub fn new(pose: &Pose, margin: f32, a: Vec3, b: Vec3, known: f32) -> Self {
        let (p, q) = (pose.p, pose.q);
        Self {
            place: [p.x, p.y, p.z, q.x, q.y, q.z, q.w, margin],
            lengths: [a.x, a.y, a.z, b.x, b.y, b.z, known, 0.0],
        }
    }
    pub fn pose(&self) -> Pose {
        let [x, y, z, qx, qy, qz, qw, _] = self.place;
        Pose::new(Vec3::new(x, y, z), Quat::new(qx, qy, qz, qw))
    }
    pub fn margin(&self) -> f32 {
        self.place[7]
    }
    pub fn a(&self) -> Vec3 {
        Vec3::new(self.lengths[0], self.lengths[1], self.lengths[2])
    }
    pub fn b(&self) -> Vec3 {
        Vec3::new(self.lengths[3], self.lengths[4], self.lengths[5])
    }
}

/// Pairs in registers.
pub(super) struct Pairs<L> {
    pub p: Wide3<L>,
    pub q: Rotations<L>,
    pub margin: L,
    pub a: Wide3<L>,
    pub b: Wide3<L>,
    pub known: L,
}

impl<L: Lanes> Pairs<L> {
    /// Lanes without a pair do what the last one does.
    ///
    /// # Panics
    /// Where there is none at all.
    #[inline(always)]
    pub fn load(rows: &[PairRow]) -> Self {
        let last = rows.len() - 1;
        let [x, y, z, qx, qy, qz, qw, margin] = L::gather8(
            #[inline(always)]
            |lane| &rows[lane.min(last)].place,
        );
        let [ax, ay, az, bx, by, bz, known, _] = L::gather8(
            #[inline(always)]
            |lane| &rows[lane.min(last)].lengths,
        );
        Self {
            p: Wide3::new(x, y, z),
            q: Rotations { v: Wide3::new(qx, qy, qz), w: qw },
            margin,
            a: Wide3::new(ax, ay, az),
            b: Wide3::new(bx, by, bz),
            known,
        }
    }
}

/// Unit quaternions.
#[derive(Clone, Copy)]
pub(super) struct Rotations<L> {
    v: Wide3<L>,
    w: L,
}

impl<L: Lanes> Rotations<L> {
    /// Of the y axis, as [`Quat::rotate`] gives it.
    #[inline(always)]
    pub fn rotate_y(&self) -> Wide3<L> {
        let (u, two) = (self.v, L::splat(2.0));
        let y = Wide3::new(L::zero(), L::splat(1.0), L::zero());
        let t = u.cross(y).scale(two);
        y.add(t.scale(self.w)).add(u.cross(t))
    }
    /// The columns of the matrices, as [`Quat::to_mat3`] has them.
    #[inline(always)]
    pub fn columns(&self) -> [Wide3<L>; 3] {
        let (Wide3 { x, y, z }, w) = (self.v, self.w);
        let (one, two) = (L::splat(1.0), L::splat(2.0));
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let (xy, xz, yz) = (x * y, x * z, y * z);
        let (xw, yw, zw) = (x * w, y * w, z * w);
        [
            Wide3::new(one - two * (yy + zz), two * (xy + zw), two * (xz - yw)),
            Wide3::new(two * (xy - zw), one - two * (xx + zz), two * (yz + xw)),
            Wide3::new(two * (xz + yw), two * (yz - xw), one - two * (xx + yy)),
        ]
    }
}
