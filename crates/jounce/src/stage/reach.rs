//! Boxes against boxes, many at a time: which of a block meet one of a group, and did not meet it before.

use jounce_geometry::Aabb;
use jounce_lanes::{Lanes, Mask};

/// Boxes in a block: the bits of a mask.
pub(super) const BLOCK: usize = 64;
/// Shapes in a group.
const GROUP: usize = 16;
/// Area of the box around a group, in the sum of its members' areas, beyond which it would meet too much that none of them meets.
const LOOSE: f32 = 2.0;

/// Neighbours that moved.
pub(super) struct Group {
    slots: [u32; GROUP],
    fat: [Aabb; GROUP],
    before: [Aabb; GROUP],
    len: usize,
    /// Bit by member.
    pub dynamic: u32,
    bounds: Aabb,
    area: f32,
}

impl Group {
    pub fn new() -> Self {
        Self {
            slots: [0; GROUP],
            fat: [Aabb::EMPTY; GROUP],
            before: [Aabb::EMPTY; GROUP],
            len: 0,
            dynamic: 0,
            bounds: Aabb::EMPTY,
            area: 0.0,
        }
    }
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
    pub fn slots(&self) -> &[u32] {
        &self.slots[..self.len]
    }
    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }
    /// Is there room, and is the box near the others?
    pub fn takes(&self, fat: &Aabb) -> bool {
        self.len == 0
            || (self.len < GROUP && self.bounds.union(fat).area() <= LOOSE * (self.area + fat.area()))
    }
    pub fn push(&mut self, slot: u32, fat: &Aabb, before: &Aabb, dynamic: bool) {
        let i = self.len;
        (self.slots[i], self.fat[i], self.before[i]) = (slot, *fat, *before);
        self.dynamic |= u32::from(dynamic) << i;
        self.bounds = self.bounds.union(fat);
        self.area += fat.area();
        self.len += 1;
    }
    pub fn clear(&mut self) {
        (self.len, self.dynamic, self.bounds, self.area) = (0, 0, Aabb::EMPTY, 0.0);
    }
}

/// Boxes by column: the six sides as they are, and as they were.
#[repr(align(64))]
pub(super) struct Block {
    now: Sides<BLOCK>,
    before: Sides<BLOCK>,
    pub slots: [u32; BLOCK],
    len: usize,
}

impl Block {
    pub fn new() -> Self {
        Self { now: [[0.0; BLOCK]; 6], before: [[0.0; BLOCK]; 6], slots: [0; BLOCK], len: 0 }
    }
    pub fn len(&self) -> usize {
        self.len
    }
    pub fn clear(&mut self) {
        self.len = 0;
    }
    #[inline(always)]
    pub fn push(&mut self, slot: u32, fat: &Aabb, before: &Aabb) {
        let i = self.len;
        let put = |columns: &mut [[f32; BLOCK]; 6], b: &Aabb| {
            columns[0][i] = b.min.x;
            columns[1][i] = b.min.y;
            columns[2][i] = b.min.z;
            columns[3][i] = b.max.x;
            columns[4][i] = b.max.y;
            columns[5][i] = b.max.z;
        };
        put(&mut self.now, fat);
        put(&mut self.before, before);
        self.slots[i] = slot;
        self.len += 1;
    }
}

/// For each member of a group: the boxes of a block that it meets, and did not meet before, as bits.
pub(super) struct Kernel<'a> {
    pub block: &'a Block,
    pub group: &'a Group,
}

impl jounce_lanes::Kernel for Kernel<'_> {
    type Output = [u64; GROUP];
    #[inline(always)]
    fn run<L: Lanes>(self) -> [u64; GROUP] {
        let Self { block, group } = self;
        let mut out = [0; GROUP];
        if block.len == 0 {
            return out;
        }
        let filled = u64::MAX >> (BLOCK - block.len);
        for (m, hits) in out.iter_mut().enumerate().take(group.len) {
            let (now, before) = (sides(&group.fat[m]), sides(&group.before[m]));
            let mut at = 0;
            while at < block.len {
                let new =
                    meets::<L, BLOCK>(&block.now, at, &now) & !meets::<L, BLOCK>(&block.before, at, &before);
                *hits |= u64::from(new.bits()) << at;
                at += L::WIDTH;
            }
            *hits &= filled;
        }
        out
    }
}

/// The six sides of boxes, by column.
pub(super) type Sides<const N: usize> = [[f32; N]; 6];

/// The sides of one box, in the order of the columns.
#[inline(always)]
pub(super) fn sides(b: &Aabb) -> [f32; 6] {
    [b.min.x, b.min.y, b.min.z, b.max.x, b.max.y, b.max.z]
}

#[inline(always)]
pub(super) fn put<const N: usize>(columns: &mut Sides<N>, i: usize, b: &Aabb) {
    columns.iter_mut().zip(sides(b)).for_each(|(c, side)| c[i] = side);
}

/// Which boxes from `at` on meet another; touching counts, as for [`Aabb::overlaps`].
#[inline(always)]
pub(super) fn meets<L: Lanes, const N: usize>(columns: &Sides<N>, at: usize, b: &[f32; 6]) -> L::Mask {
    let side = jounce_lanes::six(
        #[inline(always)]
        |i| L::load(&columns[i][at..]),
    );
    side[0].le(L::splat(b[3]))
        & side[1].le(L::splat(b[4]))
        & side[2].le(L::splat(b[5]))
        & side[3].ge(L::splat(b[0]))
        & side[4].ge(L::splat(b[1]))
        & side[5].ge(L::splat(b[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::broadphase::NEVER;
    use jounce_lanes::{Width, dispatch, dispatch_arrays};
    use jounce_math::Vec3;

    /// Boxes on a coarse grid, so that many touch: in every width the same as one by one; what met nothing before is new.
    #[test]
    fn says_what_boxes_say_in_every_width() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 29) as f32
        };
        let mut boxed = || {
            let at = Vec3::new(random(), random(), random());
            Aabb::new(at, at + Vec3::new(random(), random(), random()) * 0.5)
        };
        for (members, len) in [(1, 1), (3, 17), (GROUP, BLOCK - 1), (GROUP, BLOCK), (5, 0)] {
            let (mut group, mut block) = (Group::new(), Block::new());
            let mut list = Vec::new();
            for i in 0..members {
                let before = if i % 5 == 4 { NEVER } else { boxed() };
                group.push(i as u32, &boxed(), &before, true);
            }
            for i in 0..len {
                let (now, before) = (boxed(), if i % 7 == 6 { NEVER } else { boxed() });
                block.push(i as u32, &now, &before);
                list.push((now, before));
            }
            let met = |a: &Aabb, b: &Aabb| a.min.x.is_finite() && b.min.x.is_finite() && a.overlaps(b);
            let mut want = [0_u64; GROUP];
            for m in 0..members {
                for (i, (now, before)) in list.iter().enumerate() {
                    let new = group.fat[m].overlaps(now) && !met(&group.before[m], before);
                    want[m] |= u64::from(new) << i;
                }
            }
            for w in Width::ALL {
                assert_eq!(dispatch(w, Kernel { block: &block, group: &group }), want, "{w}");
                assert_eq!(
                    dispatch_arrays(w, Kernel { block: &block, group: &group }),
                    want,
                    "arrays of {w}"
                );
            }
        }
    }
}
