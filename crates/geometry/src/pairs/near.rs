//! The triangles of a mesh near a shape, kept from test to test.
//!
//! They are gathered with room around the shape's bounds, and every test drops those that a search of the tree would not find
//! now: what is kept changes no result. Where a test finds none that could be touched, it says how far the shape may go before
//! one could be.

use super::sieve::{Direction, Directions, Sieve};
use crate::{Aabb, TriMesh};
use jounce_lanes::{Kernel, LANES_MAX, Lanes, Mask, Width, dispatch, three};
use jounce_math::{Quat, Vec3, scalar::f32s};

/// Least and most room around the bounds, as a part of their longest side.
const ROOM: [f32; 2] = [0.02, 0.1];
/// For so many tests at the pace of the last one, between those.
const TESTS: f32 = 8.0;
/// Most triangles that are kept.
const KEPT_MAX: usize = 256;
/// Of a way that was found free, so much is not counted on.
const ROUNDING: f32 = 1e-3;

/// Triangles that one convex shape has been near to, of one mesh.
#[derive(Debug)]
pub struct Near {
    /// Around all places of the shape for which the list holds, in the mesh's frame.
    bounds: Aabb,
    /// In rising order.
    indices: Vec<u32>,
    blocks: Vec<Block>,
    /// Where the shape's centre and its rotation were at the last test, and the margin.
    center: Vec3,
    rotation: Quat,
    margin: f32,
    /// How far any of its points may go from there before a triangle is within the margin; 0 where that is not known.
    free: f32,
}

type Lane = [f32; LANES_MAX];

/// Corners and normals of triangles, abreast. The last block is filled up with its last triangle.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Block {
    corners: [[Lane; 3]; 3],
    normal: [Lane; 3],
}

impl Default for Near {
    fn default() -> Self {
        Self {
            bounds: Aabb::EMPTY,
            indices: Vec::new(),
            blocks: Vec::new(),
            center: Vec3::splat(f32::INFINITY),
            rotation: Quat::IDENTITY,
            margin: 0.0,
            free: 0.0,
        }
    }
}

/// Memory, not state: a clone starts without.
impl Clone for Near {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// The shape of a test, as far as the triangles near it are concerned.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asker<'a> {
    pub sieve: &'a Sieve,
    /// With the margin.
    pub bounds: &'a Aabb,
    pub center: Vec3,
    pub rotation: Quat,
    pub margin: f32,
    /// No point of the shape is farther below a plane that its centre is over.
    pub deepest: f32,
}

impl Near {
    /// Is it known that a shape with its centre and rotation so, and no point farther than `reach` from its centre, touches nothing?
    pub(super) fn is_free(&self, center: Vec3, rotation: Quat, reach: f32, margin: f32) -> bool {
        if self.free <= 0.0 {
            return false;
        }
        let turn = self.rotation.inverse_mul(rotation).xyz().length();
        let moved = (center - self.center).length() + 2.0 * turn * reach;
        self.free * (1.0 - ROUNDING) > moved + f32s::max(margin - self.margin, 0.0)
    }

    /// Writes those triangles to `out`, in rising order, whose bounds overlap the shape's, that face its centre and that pass its sieve.
    /// False where there are too many to keep, or the shape is too fast: then the tree is to be searched.
    pub(super) fn find(&mut self, mesh: &TriMesh, shape: &Asker, out: &mut Vec<u32>) -> bool {
        let moved = (shape.center - self.center).length();
        (self.center, self.rotation, self.margin) = (shape.center, shape.rotation, shape.margin);
        self.free = 0.0;
        if !self.bounds.contains(shape.bounds) && !self.gather(mesh, shape.bounds, moved, out) {
            self.bounds = Aabb::EMPTY;
            return false;
        }
        out.clear();
        let directions = &shape.sieve.directions();
        let two_sided = mesh.double_sided;
        let Self { blocks, indices, .. } = &*self;
        dispatch(Width::detect(), Pick { blocks, indices, shape, directions, two_sided, out });
        if out.is_empty() {
            let (inner, outer) = (shape.bounds, &self.bounds);
            let sides = (inner.min - outer.min).min(outer.max - inner.max).min_component();
            let beyond = Beyond { blocks, deepest: shape.deepest, directions, two_sided };
            self.free = f32s::min(sides, dispatch(Width::detect(), beyond));
        }
        true
    }

    fn gather(&mut self, mesh: &TriMesh, bounds: &Aabb, moved: f32, list: &mut Vec<u32>) -> bool {
        let [least, most] = ROOM.map(|part| part * (bounds.max - bounds.min).max_component());
        let moved = if moved.is_finite() { moved } else { 0.0 };
        // What is gathered must serve some tests.
        if 2.0 * moved > most {
            return false;
        }
        let wide = bounds.expanded(f32s::clamp(TESTS * moved, least, most));
        list.clear();
        mesh.tree.query(&wide, |t| {
            list.push(t);
            list.len() <= KEPT_MAX
        });
        if list.len() > KEPT_MAX {
            return false;
        }
        // The tree's shape is an accident of its history.
        list.sort_unstable();
        self.bounds = wide;
        self.indices.clear();
        self.indices.extend_from_slice(list);
        self.blocks.clear();
        self.blocks.extend(list.chunks(LANES_MAX).map(|part| Block::new(mesh, part)));
        true
    }
}

impl Block {
    fn new(mesh: &TriMesh, part: &[u32]) -> Self {
        let mut block = Self { corners: [[[0.0; LANES_MAX]; 3]; 3], normal: [[0.0; LANES_MAX]; 3] };
        for i in 0..LANES_MAX {
            let patch = &mesh.patches[part[i.min(part.len() - 1)] as usize];
            for axis in 0..3 {
                for k in 0..3 {
                    block.corners[k][axis][i] = patch.corners[k][axis];
                }
                block.normal[axis][i] = patch.normal[axis];
            }
        }
        block
    }
}

/// Some of a block's triangles, in registers.
struct Triangles<L> {
    corners: [[L; 3]; 3],
    normal: [L; 3],
}

impl<L: Lanes> Triangles<L> {
    #[inline(always)]
    fn load(block: &Block, at: usize) -> Self {
        let point = |p: &[Lane; 3]| {
            three(
                #[inline(always)]
                |axis| L::load(&p[axis][at..]),
            )
        };
        let [a, b, c] = &block.corners;
        Self { corners: [point(a), point(b), point(c)], normal: point(&block.normal) }
    }

    /// Least and most of the corners along an axis.
    #[inline(always)]
    fn span(&self, axis: usize) -> (L, L) {
        let [a, b, c] = [self.corners[0][axis], self.corners[1][axis], self.corners[2][axis]];
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// Where the centre is behind.
    #[inline(always)]
    fn behind(&self, center: Vec3) -> L::Mask {
        let ([x, y, z], [nx, ny, nz]) = (self.corners[0], self.normal);
        let [cx, cy, cz] = [center.x, center.y, center.z].map(L::splat);
        (nx * (cx - x) + ny * (cy - y) + nz * (cz - z)).lt(L::zero())
    }

    /// The lowest corner, and the normal, along a direction.
    #[inline(always)]
    fn along(&self, &[x, y, z, _]: &Direction) -> (L, L) {
        let (x, y, z) = (L::splat(x), L::splat(y), L::splat(z));
        let h = |p: &[L; 3]| x * p[0] + y * p[1] + z * p[2];
        let [a, b, c] = [h(&self.corners[0]), h(&self.corners[1]), h(&self.corners[2])];
        (a.min(b).min(c), h(&self.normal))
    }
}

/// Triangles of which `Aabb::overlaps`, `Surface::facing` and `Sieve::passes` say yes.
struct Pick<'a> {
    blocks: &'a [Block],
    indices: &'a [u32],
    shape: &'a Asker<'a>,
    directions: &'a Directions,
    two_sided: bool,
    out: &'a mut Vec<u32>,
}

impl Kernel for Pick<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { blocks, indices, shape, directions, two_sided, out } = self;
        for (block, indices) in blocks.iter().zip(indices.chunks(LANES_MAX)) {
            for at in (0..indices.len()).step_by(L::WIDTH) {
                let mut left = picked(&Triangles::<L>::load(block, at), shape, directions.all(), two_sided);
                while left != 0 {
                    let i = at + left.trailing_zeros() as usize;
                    // Those that fill up the last block have no index.
                    out.extend(indices.get(i));
                    left &= left - 1;
                }
            }
        }
    }
}

/// One bit for each.
#[inline(always)]
fn picked<L: Lanes>(t: &Triangles<L>, shape: &Asker, directions: &[Direction], two_sided: bool) -> u32 {
    let behind = t.behind(shape.center);
    let mut out = if two_sided { behind | !behind } else { !behind };
    for axis in 0..3 {
        let (least, most) = t.span(axis);
        out = out & least.le(L::splat(shape.bounds.max[axis]));
        out = out & L::splat(shape.bounds.min[axis]).le(most);
    }
    let deepest = L::splat(shape.deepest);
    for d in directions {
        if !out.any() {
            break;
        }
        let (low, along) = t.along(d);
        let facing = L::select(behind, -along, along);
        let lean = deepest * facing.max(L::zero());
        out = out & !(low - lean).gt(L::splat(d[3]));
    }
    out.bits()
}

/// How far the nearest of the triangles is beyond the sieve, whichever side it shows.
struct Beyond<'a> {
    blocks: &'a [Block],
    deepest: f32,
    directions: &'a Directions,
    two_sided: bool,
}

impl Kernel for Beyond<'_> {
    type Output = f32;
    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let mut nearest = L::splat(f32::INFINITY);
        for block in self.blocks {
            for at in (0..LANES_MAX).step_by(L::WIDTH) {
                let t = Triangles::<L>::load(block, at);
                let mut most = L::zero();
                for d in self.directions.all() {
                    let (low, along) = t.along(d);
                    let facing = if self.two_sided { along.abs() } else { along };
                    let lean = L::splat(self.deepest) * facing.max(L::zero());
                    most = (low - lean - L::splat(d[3])).max(most);
                }
                nearest = nearest.min(most);
            }
        }
        let mut lanes: Lane = [f32::INFINITY; LANES_MAX];
        nearest.store(&mut lanes);
        lanes.into_iter().fold(f32::INFINITY, f32s::min)
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;
    use crate::pairs::{Convex, Surface};
    use crate::{Hull, Manifold, ManifoldSet, PairCache, Shape, TriMeshOptions, collide, collide_again};
    use jounce_math::Pose;
    use std::sync::Arc;

    /// 20 × 20 quads of half a metre, bumpy.
    fn ground(r: &mut Random, double_sided: bool) -> Shape {
        let points: Vec<Vec3> = (0..441_u16)
            .map(|i| {
                let (x, z) = (f32::from(i % 21), f32::from(i / 21));
                Vec3::new(0.5 * x - 5.0, 0.2 * r.next(), 0.5 * z - 5.0)
            })
            .collect();
        let cell = |a: u32| [[a, a + 21, a + 1], [a + 1, a + 21, a + 22]];
        let triangles: Vec<_> = (0..20).flat_map(|z| (0..20).flat_map(move |x| cell(21 * z + x))).collect();
        let options = TriMeshOptions { double_sided, ..TriMeshOptions::default() };
        Shape::Mesh(Arc::new(TriMesh::new(&points, &triangles, options).expect("a ground")))
    }

    fn shapes(r: &mut Random) -> [Shape; 6] {
        let points: Vec<Vec3> = (0..40).map(|_| r.vec() * 0.6).collect();
        [
            Shape::Sphere { radius: 0.4 },
            Shape::Capsule { half_height: 0.6, radius: 0.3 },
            Shape::Box { half: Vec3::new(0.3, 0.2, 0.9) },
            Shape::Cylinder { half_height: 0.3, radius: 0.5 },
            Shape::Cone { half_height: 0.5, radius: 0.4 },
            Shape::Hull(Arc::new(Hull::new(&points).expect("a hull"))),
        ]
    }

    /// Shapes that roll, hop and jump over a ground: what is kept changes nothing, in either order of the two; and it is made use of.
    #[test]
    fn what_is_kept_changes_no_result() {
        let mut r = Random(7);
        let (mut touched, mut free, mut kept) = (0, 0, 0);
        for (double_sided, flipped) in [(false, false), (true, false), (false, true)] {
            let mesh = ground(&mut r, double_sided);
            for shape in shapes(&mut r) {
                let mut near: Option<Box<Near>> = None;
                let (mut again, mut anew) = (PairCache::default(), PairCache::default());
                let (mut at, mut q) = (Vec3::new(-2.0, 1.2, 0.0), Quat::IDENTITY);
                for step in 0..1500 {
                    let pace = [0.004, 0.03, 0.2][step / 60 % 3];
                    at = (at + r.vec() * pace - Vec3::Y * (0.1 * pace))
                        .clamp(Vec3::splat(-4.0), Vec3::splat(4.0));
                    at.y = f32s::clamp(at.y, if double_sided { -1.5 } else { -0.2 }, 1.5);
                    q = (Quat::from_axis_angle(r.vec().normalize_or(Vec3::Y), pace) * q).normalize();
                    if step % 400 == 399 {
                        at = r.vec() * 3.0;
                    }
                    let pose = Pose::new(at, q);
                    let margin = 0.02 + 0.05 * f32s::max(r.next(), 0.0);
                    let (mut got, mut want) = (ManifoldSet::new(), ManifoldSet::new());
                    let before = near.as_ref().map(|n| (n.center, n.bounds));
                    if flipped {
                        let pose = pose.inverse();
                        collide_again(&shape, &mesh, &pose, margin, &mut again, &mut near, &mut got);
                        collide(&shape, &mesh, &pose, margin, &mut anew, &mut want);
                    } else {
                        collide_again(&mesh, &shape, &pose, margin, &mut again, &mut near, &mut got);
                        collide(&mesh, &shape, &pose, margin, &mut anew, &mut want);
                    }
                    assert_eq!(got.manifolds, want.manifolds, "{shape:?}, step {step}, {pose:?}");
                    assert_eq!(again, anew, "{shape:?}, step {step}");
                    touched += usize::from(want.manifolds.iter().any(|m: &Manifold| m.count > 0));
                    if let (Some((center, bounds)), Some(n)) = (before, &near) {
                        free += usize::from(center == n.center);
                        kept += usize::from(center != n.center && bounds == n.bounds);
                    }
                }
            }
        }
        assert!(touched > 5000 && free > 1000 && kept > 5000, "{touched} touched, {free} free, {kept} kept");
    }

    /// What is picked, in every width, is what is said one by one; and nothing that is picked is nearer than it may be.
    #[test]
    fn lanes_pick_what_is_picked_one_by_one() {
        let mut r = Random(11);
        let (mut picked, mut free) = (0, 0);
        for double_sided in [false, true] {
            let ground = ground(&mut r, double_sided);
            let Shape::Mesh(mesh) = &ground else { unreachable!() };
            for shape in shapes(&mut r) {
                let b = Convex::of(&shape).expect("convex");
                for _ in 0..60 {
                    let pose = Pose::new(r.vec() * 2.0, r.quat(3.0));
                    let (margin, deepest) = (0.02, b.core.reach() + b.radius);
                    let sieve = Sieve::new(&b.core, &pose, b.radius + margin, &mesh.aabb());
                    let bounds = shape.aabb(&pose).expanded(margin);
                    let center = pose.transform_point(b.center());
                    let asker =
                        Asker { sieve: &sieve, bounds: &bounds, center, rotation: pose.q, margin, deepest };
                    let mut near = Near::default();
                    let mut found = Vec::new();
                    assert!(near.find(mesh, &asker, &mut found));
                    let surface = Surface::Mesh(mesh);
                    let passes = |&i: &u32| {
                        let overlaps = Aabb::from_points(mesh.patches[i as usize].corners).overlaps(&bounds);
                        let facing = surface.facing(i, center);
                        overlaps && facing.is_some_and(|t| sieve.passes(&t.corners, t.normal, deepest))
                    };
                    let want: Vec<u32> = (0..mesh.patches.len() as u32).filter(passes).collect();
                    let directions = &sieve.directions();
                    let Near { blocks, indices, .. } = &near;
                    let mut ways = Vec::new();
                    for width in Width::ALL {
                        let mut out = Vec::new();
                        let (shape, two_sided) = (&asker, double_sided);
                        let pick = Pick { blocks, indices, shape, directions, two_sided, out: &mut out };
                        dispatch(width, pick);
                        assert_eq!(out, want, "{shape:?}, {width}");
                        ways.push(
                            dispatch(width, Beyond { blocks, deepest, directions, two_sided }).to_bits(),
                        );
                    }
                    assert_eq!(found, want);
                    assert!(ways.iter().all(|w| *w == ways[0]), "{ways:?}");
                    picked += want.len();
                    free += usize::from(near.free > 0.0);
                }
            }
        }
        assert!(picked > 2000 && free > 20, "{picked} picked, {free} free");
    }
}
