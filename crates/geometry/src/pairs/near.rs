//! The triangles of a mesh near a shape, kept from test to test.
//!
//! They are gathered with room around the shape's bounds, and every test drops those that a search of the tree would not find
//! now: what is kept changes no result. Where a test finds none that could be touched, it says how far the shape may go before
//! one could be.

use super::sieve::{Direction, Sieve, WIDE};
use crate::{Aabb, TriMesh};
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
    blocks: Vec<Four>,
    /// Where the shape's centre and its rotation were at the last test, and the margin.
    center: Vec3,
    rotation: Quat,
    margin: f32,
    /// How far any of its points may go from there before a triangle is within the margin; 0 where that is not known.
    free: f32,
}

/// Corners and normals of four triangles. The last block is filled up with its last triangle.
#[derive(Clone, Copy, Debug)]
struct Four {
    corners: [[[f32; WIDE]; 3]; 3],
    normal: [[f32; WIDE]; 3],
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
        let directions = shape.sieve.directions();
        for (four, indices) in self.blocks.iter().zip(self.indices.chunks(WIDE)) {
            let passed = four.passed(shape, directions.all(), mesh.double_sided);
            out.extend(indices.iter().zip(passed).filter(|(_, p)| *p).map(|(&i, _)| i));
        }
        if out.is_empty() {
            self.free = self.measure(shape, directions.all(), mesh.double_sided);
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
        self.blocks.extend(list.chunks(WIDE).map(|part| Four::new(mesh, part)));
        true
    }

    /// How far the shape may go before it touches one of the triangles, or one that is not in the list.
    fn measure(&self, shape: &Asker, directions: &[Direction], two_sided: bool) -> f32 {
        let (inner, outer) = (shape.bounds, &self.bounds);
        let sides = (inner.min - outer.min).min(outer.max - inner.max);
        let beyond = |four: &Four| four.beyond(shape.deepest, directions, two_sided);
        self.blocks.iter().map(beyond).fold(sides.min_component(), f32s::min)
    }
}

impl Four {
    fn new(mesh: &TriMesh, part: &[u32]) -> Self {
        let patch = |i: usize| &mesh.patches[part[i.min(part.len() - 1)] as usize];
        let lanes = |f: &dyn Fn(usize) -> f32| core::array::from_fn(f);
        Self {
            corners: [0, 1, 2].map(|k| [0, 1, 2].map(|axis| lanes(&|i| patch(i).corners[k][axis]))),
            normal: [0, 1, 2].map(|axis| lanes(&|i| patch(i).normal[axis])),
        }
    }

    /// What `Aabb::overlaps`, `Surface::facing` and `Sieve::passes` say of each.
    fn passed(&self, shape: &Asker, directions: &[Direction], two_sided: bool) -> [bool; WIDE] {
        let mut out = [0_u32; WIDE];
        let behind = self.behind(shape.center);
        for i in 0..WIDE {
            out[i] = u32::from(two_sided) | (1 - behind[i]);
        }
        for axis in 0..3 {
            let (lo, hi) = (shape.bounds.min[axis], shape.bounds.max[axis]);
            let [a, b, c] = [0, 1, 2].map(|k| &self.corners[k][axis]);
            for i in 0..WIDE {
                let least = f32s::min(f32s::min(a[i], b[i]), c[i]);
                let most = f32s::max(f32s::max(a[i], b[i]), c[i]);
                out[i] &= u32::from(least <= hi) & u32::from(lo <= most);
            }
        }
        for d in directions {
            if out == [0; WIDE] {
                break;
            }
            let (low, along) = self.along(d);
            for i in 0..WIDE {
                let facing = if behind[i] != 0 { -along[i] } else { along[i] };
                let lean = shape.deepest * f32s::max(facing, 0.0);
                out[i] &= 1 - u32::from(low[i] - lean > d[3]);
            }
        }
        out.map(|x| x != 0)
    }

    /// How far the nearest of the triangles is beyond the sieve, whichever side it shows.
    fn beyond(&self, deepest: f32, directions: &[Direction], two_sided: bool) -> f32 {
        let mut most = [0.0_f32; WIDE];
        for d in directions {
            let (low, along) = self.along(d);
            for i in 0..WIDE {
                let facing = if two_sided { along[i].abs() } else { along[i] };
                let lean = deepest * f32s::max(facing, 0.0);
                most[i] = f32s::max(low[i] - lean - d[3], most[i]);
            }
        }
        most.into_iter().fold(f32::INFINITY, f32s::min)
    }

    /// 1 where the centre is behind.
    #[inline(always)]
    fn behind(&self, center: Vec3) -> [u32; WIDE] {
        let ([x, y, z], [nx, ny, nz]) = (&self.corners[0], &self.normal);
        core::array::from_fn(|i| {
            let h = nx[i] * (center.x - x[i]) + ny[i] * (center.y - y[i]) + nz[i] * (center.z - z[i]);
            u32::from(h < 0.0)
        })
    }

    /// The lowest corner, and the normal, along a direction.
    #[inline(always)]
    fn along(&self, &[x, y, z, _]: &Direction) -> ([f32; WIDE], [f32; WIDE]) {
        let h = |p: &[[f32; WIDE]; 3]| -> [f32; WIDE] {
            let mut out = [0.0; WIDE];
            for i in 0..WIDE {
                out[i] = x * p[0][i] + y * p[1][i] + z * p[2][i];
            }
            out
        };
        let [a, b, c] = [h(&self.corners[0]), h(&self.corners[1]), h(&self.corners[2])];
        let mut low = [0.0; WIDE];
        for i in 0..WIDE {
            low[i] = f32s::min(f32s::min(a[i], b[i]), c[i]);
        }
        (low, h(&self.normal))
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;
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
}
