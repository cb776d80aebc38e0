//! Contact manifolds, one file per family of pairs.
//!
//! A pair is tested in one order only (the higher [`rank`] is A); the other order is the same test, flipped. Balls and capsules are tested in the order they
//! come in.

mod batch;
mod box_axes;
mod box_box;
mod capsule;
mod compound;
mod feature;
mod general;
mod half_space;
mod held;
mod hull_hull;
mod mesh;
mod near;
mod poly;
#[cfg(test)]
mod random;
mod reduce;
mod sieve;
mod sphere;
mod surface;
mod wide;

use crate::convex::core::Core;
use crate::limits::MANIFOLDS_PER_PAIR_MAX;
use crate::{Manifold, ManifoldPoint, ManifoldSet, NO_SUB, PairCache, Shape};
pub use batch::Batch;
use feature::Convex;
pub(crate) use general::Scratch;
use half_space::Plane;
use jounce_math::{Pose, Vec3};
pub(crate) use mesh::MeshScratch;
pub use near::Near;
pub(crate) use sieve::SweptSieve;
pub(crate) use surface::Surface;

/// A manifold of one point.
pub(crate) fn one_point(normal: Vec3, point: Vec3, separation: f32, feature: u32, faces: u8) -> Manifold {
    let mut m = Manifold { normal, count: 1, faces, sub_a: NO_SUB, sub_b: NO_SUB, ..Manifold::default() };
    m.points[0] = ManifoldPoint { point, separation, feature };
    m
}

/// Order of the shapes in a test: A is the one of higher rank.
pub(crate) fn rank(s: &Shape) -> u8 {
    match s {
        Shape::Sphere { .. } => 0,
        Shape::Capsule { .. } => 1,
        Shape::Box { .. } => 2,
        Shape::Cylinder { .. } => 3,
        Shape::Cone { .. } => 4,
        Shape::Hull(_) => 5,
        Shape::HalfSpace { .. } => 6,
        Shape::Mesh(_) => 7,
        Shape::HeightField(_) => 8,
        Shape::Compound(_) => 9,
    }
}

/// Half heights and radii of two capsules, or balls, in any order.
fn capsules_of(a: &Shape, b: &Shape) -> Option<[(f32, f32); 2]> {
    let one = |s: &Shape| match s {
        Shape::Sphere { radius } => Some((0.0, *radius)),
        Shape::Capsule { half_height, radius } => Some((*half_height, *radius)),
        _ => None,
    };
    Some([one(a)?, one(b)?])
}

/// Where two overlapping cores (with radii) touch and the direction from A to B that parts them soonest.
pub(crate) fn push_out((a, ra): (Core, f32), (b, rb): (Core, f32), pose: &Pose) -> (Vec3, Vec3) {
    let (a, b) = (Convex::of_core(a, ra), Convex::of_core(b, rb));
    match general::axis(&a, &b, pose, f32::MAX, &mut PairCache::default()) {
        Some(x) => ((x.a + x.normal * ra + x.b - x.normal * rb) * 0.5, x.normal),
        None => (pose.p, pose.p.normalize_or(Vec3::Y)),
    }
}

/// Manifolds of A and B (pose of B in A's frame) for all points closer than `margin` metres, written to
/// `out.manifolds` (cleared first).
/// At least one of the shapes must be solid; other pairs give nothing.
pub fn collide(
    a: &Shape,
    b: &Shape,
    b_in_a: &Pose,
    margin: f32,
    cache: &mut PairCache,
    out: &mut ManifoldSet,
) {
    whole(a, b, b_in_a, margin, cache, None, out);
}

/// The same for a pair that is tested again and again: `near` keeps what is near of a mesh. It changes no result, but must not be given to
/// another pair.
pub fn collide_again(
    a: &Shape,
    b: &Shape,
    b_in_a: &Pose,
    margin: f32,
    cache: &mut PairCache,
    near: &mut Option<Box<Near>>,
    out: &mut ManifoldSet,
) {
    let meets_mesh = |a: &Shape, b: &Shape| matches!(a, Shape::Mesh(_)) && b.is_convex();
    let near = (meets_mesh(a, b) || meets_mesh(b, a)).then(|| &mut **near.get_or_insert_default());
    whole(a, b, b_in_a, margin, cache, near, out);
}

fn whole(
    a: &Shape,
    b: &Shape,
    b_in_a: &Pose,
    margin: f32,
    cache: &mut PairCache,
    near: Option<&mut Near>,
    out: &mut ManifoldSet,
) {
    out.clear();
    cache.gap = 0.0;
    if !b_in_a.is_finite() {
        return;
    }
    let ManifoldSet { manifolds, scratch, mesh } = out;
    append(a, b, b_in_a, margin, (cache, near), (scratch, mesh), manifolds);
    manifolds.truncate(MANIFOLDS_PER_PAIR_MAX);
}

/// Adds the manifolds of any two shapes.
fn append(
    a: &Shape,
    b: &Shape,
    b_in_a: &Pose,
    margin: f32,
    cache: (&mut PairCache, Option<&mut Near>),
    scratch: (&mut Scratch, &mut MeshScratch),
    out: &mut Vec<Manifold>,
) {
    if let Some(both) = capsules_of(a, b) {
        out.extend(capsule::capsules(&capsule::row(both, b_in_a, margin), cache.0));
        return;
    }
    if rank(a) >= rank(b) {
        ordered(a, b, b_in_a, margin, cache, scratch, out);
        return;
    }
    let a_in_b = b_in_a.inverse();
    let first = out.len();
    ordered(b, a, &a_in_b, margin, cache, scratch, out);
    for m in &mut out[first..] {
        *m = m.flipped(&a_in_b);
    }
}

/// The same with rank(a) ≥ rank(b).
fn ordered(
    a: &Shape,
    b: &Shape,
    pose: &Pose,
    margin: f32,
    (cache, near): (&mut PairCache, Option<&mut Near>),
    (scratch, mesh): (&mut Scratch, &mut MeshScratch),
    out: &mut Vec<Manifold>,
) {
    let bounds = || b.aabb(pose).expanded(margin);
    let surface = match a {
        Shape::Compound(c) => {
            compound::compound(c, b, pose, &bounds(), margin, (scratch, mesh), out);
            return;
        }
        Shape::HalfSpace { normal, offset } if b.is_convex() => {
            let plane = Plane { normal: *normal, offset: *offset };
            out.extend(half_space(&plane, b, pose, margin, cache, scratch));
            return;
        }
        Shape::Mesh(m) => Surface::Mesh(m),
        Shape::HeightField(h) => Surface::HeightField(h),
        _ if a.is_convex() && b.is_convex() => {
            out.extend(convex(a, b, pose, margin, cache, scratch));
            return;
        }
        _ => return,
    };
    if let Some(b) = Convex::of(b) {
        mesh::surface_convex(&surface, &b, pose, bounds, margin, (cache, near), (scratch, mesh), out);
    }
}

fn half_space(
    plane: &Plane,
    b: &Shape,
    pose: &Pose,
    margin: f32,
    cache: &mut PairCache,
    scratch: &mut Scratch,
) -> Option<Manifold> {
    match b {
        Shape::Sphere { radius } => half_space::sphere(plane, *radius, pose.p, margin),
        Shape::Capsule { half_height, radius } => {
            half_space::capsule(plane, (*half_height, *radius), pose, margin)
        }
        Shape::Box { half } => half_space::boxed(plane, *half, pose, margin),
        _ => half_space::general(plane, &Convex::of(b)?, pose, margin, cache, scratch),
    }
}

/// Two convex shapes, rank(a) ≥ rank(b).
fn convex(
    a: &Shape,
    b: &Shape,
    pose: &Pose,
    margin: f32,
    cache: &mut PairCache,
    scratch: &mut Scratch,
) -> Option<Manifold> {
    match (a, b) {
        (Shape::Box { half }, Shape::Sphere { radius }) => sphere::box_sphere(*half, *radius, pose.p, margin),
        (Shape::Box { half: ha }, Shape::Box { half: hb }) => {
            box_box::box_box(&box_box::row(*ha, *hb, pose, margin, cache), cache)
        }
        _ => general::convex(&Convex::of(a)?, &Convex::of(b)?, pose, margin, cache, scratch),
    }
}
