//! Meshes and height fields against convex shapes, without ghost bumps.
//!
//! Each triangle near B is tested alone. A body that slides over a seam of two triangles would trip over it: seen alone,
//! a triangle's edge can be hit from the side. So a contact normal has to be one that the surface *as a whole* can give:
//! at an edge, a direction between the normals of its two triangles (`SurfaceTriangle::allows`). Others are replaced by
//! the contact with the triangle's face, or dropped where there is none. After that, face contacts come first, and an edge
//! or vertex contact that lies in the plane of one takes its normal: that covers seams which the mesh does not know
//! of, such as T-junctions. Points of nearly equal normal become one manifold of at most four.
//!
//! Idea of the admissible fan: P. Terdiman, "Contact generation for meshes", 2012; smooth contacts in Box3D.

use super::feature::Convex;
use super::general::{self, Scratch};
use super::near::{Asker, Near};
use super::one_point;
use super::poly::TrianglePoly;
use super::reduce::reduce;
use super::sieve::Sieve;
use super::surface::{Facing, Surface};
use crate::convex::core::Core;
use crate::limits::MANIFOLDS_PER_PAIR_MAX;
use crate::shapes::triangle::closest_point;
use crate::{Aabb, FACE_A, Manifold, ManifoldPoint, NO_SUB, PairCache};
use jounce_math::{Pose, Vec3, scalar::f32s};

/// Cosine of the angle up to which normals count as equal (1.1°).
const SAME_NORMAL: f32 = 0.9998;
/// Farthest distance of a point from a face's plane at which it belongs to the plane, metres.
const PLANE_SLOP: f32 = 0.005;

/// A contact point of one triangle before merging.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    normal: Vec3,
    /// In the list of triangles.
    facing: u32,
    faces: u8,
    triangle: u32,
    taken: bool,
    point: ManifoldPoint,
}

/// Memory of the test.
#[derive(Clone, Debug, Default)]
pub(crate) struct MeshScratch {
    triangles: Vec<u32>,
    candidates: Vec<Candidate>,
    /// Triangles of the candidates.
    faces: Vec<Facing>,
    group: Vec<ManifoldPoint>,
    /// Children of the compounds in work, a stack.
    pub children: Vec<u32>,
}

/// Points that there is room for from the first mesh on, and manifolds: lists that serve many pairs do not go on growing.
const ROOM: usize = 32;

/// Surface A against convex B with bounds `bounds()` in A's frame (margin included).
pub(crate) fn surface_convex(
    a: &Surface,
    b: &Convex,
    pose: &Pose,
    bounds: impl Fn() -> Aabb,
    margin: f32,
    (cache, near): (&mut PairCache, Option<&mut Near>),
    (scratch, mesh): (&mut Scratch, &mut MeshScratch),
    out: &mut Vec<Manifold>,
) {
    let center = pose.transform_point(b.center());
    if near.as_ref().is_some_and(|n| n.is_free(center, pose.q, b.core.reach() + b.radius, margin)) {
        return;
    }
    mesh.candidates.clear();
    mesh.faces.clear();
    scratch.forget();
    let sieve = Sieve::new(&b.core, pose, b.radius + margin, &a.bounds());
    // As deep as it can be with its centre in front.
    let deepest = b.core.reach() + b.radius;
    let bounds = bounds();
    let known = match (a, near) {
        (Surface::Mesh(m), Some(near)) => {
            let (sieve, bounds) = (&sieve, &bounds);
            let shape = Asker { sieve, bounds, center, rotation: pose.q, margin, deepest };
            near.find(m, &shape, &mut mesh.triangles)
        }
        _ => false,
    };
    if !known {
        mesh.triangles.clear();
        a.visit(&bounds, |index| {
            if a.facing(index, center).is_some_and(|t| sieve.passes(&t.corners, t.normal, deepest)) {
                mesh.triangles.push(index);
            }
        });
        // The tree's shape is an accident of its history.
        mesh.triangles.sort_unstable();
    }
    for &index in &mesh.triangles {
        let Some(t) = a.facing(index, center) else { continue };
        let Some(m) = triangle(a, &t, &sieve, b, pose, margin, scratch) else { continue };
        add(&mut mesh.candidates, &m, mesh.faces.len() as u32, a.name(index));
        mesh.faces.push(t);
    }
    let slop = f32s::min(PLANE_SLOP, 0.05 * b.thickness());
    snap_to_faces(&mut mesh.candidates, &mesh.faces, slop, |t| {
        // Balls touch a face in one point, and that is found.
        let round = matches!(b.core, Core::Point);
        if round { None } else { face_only(t, b, pose, margin, scratch) }
    });
    merge(mesh, cache, out);
}

/// One triangle: the contact that the whole surface allows.
fn triangle(
    surface: &Surface,
    t: &Facing,
    sieve: &Sieve,
    b: &Convex,
    pose: &Pose,
    margin: f32,
    scratch: &mut Scratch,
) -> Option<Manifold> {
    let n = t.normal;
    let low = pose.transform_point(b.core.support(pose.q.inverse_rotate(-n)));
    let over = n.dot(low - t.corners[0]) - b.radius;
    if over > margin {
        return None;
    }
    if !sieve.passes(&t.corners, n, f32s::max(-over, 0.0)) {
        return None;
    }
    if matches!(b.core, Core::Point) {
        return sphere(surface, t, b.radius, pose.p, margin);
    }
    if surface.is_gentle(t) || is_within(t, low, -over - b.radius) {
        return face_only(t, b, pose, margin, scratch);
    }
    // Cores that the face parts are apart: GJK is asked at once.
    let kind = if over + b.radius > 0.0 { 0 } else { general::KIND_FACE_A };
    let mut cache = PairCache { axis: n, kind, ..PairCache::default() };
    let t = surface.full(t);
    let a = Convex::triangle(t.poly);
    let mut axis = general::axis(&a, b, pose, margin, &mut cache)?;
    cache.kind = general::KIND_FACE_A;
    if axis.normal.dot(n) < 0.0 {
        // The least push-out of a thin sheet may be through it; the body is in front, so it goes back there.
        axis = general_face_axis(&t.poly, low, b.radius + over);
    }
    let m = general::contact(&a, b, pose, margin, &axis, &mut cache, scratch)?;
    let depth = |m: &Manifold| m.points().iter().fold(f32::MAX, |d, p| f32s::min(p.separation, d));
    let up = n.dot(m.normal);
    let allowed = t.allows(m.normal);
    // At a border nobody knows whether the surface goes on; when in it, the face is the better guess.
    let border = t.is_border(m.normal) && up > 0.3 && depth(&m) < 0.0;
    if m.faces & FACE_A != 0 || (allowed && !border) {
        return Some(m);
    }
    let face = a.flat_face(n)?;
    let flat = general::face_contact(&a, &face, b, pose, margin, &mut cache, scratch);
    // Past a convex edge the neighbour answers; this face must not lift the body from far below.
    let level = |f: &Manifold| depth(f) > 2.0 * depth(&m) - 0.1 * b.thickness();
    match flat {
        Some(f) if (!allowed && up > 0.7) || level(&f) => Some(f),
        _ => allowed.then_some(m),
    }
}

/// Is B's core, `depth` deep at `low`, parted from the triangle soonest along its normal? It is where `low` is over the inside, no nearer
/// to an edge, r, than it is deep, d: along n cos θ + t sin θ the gap is −d cos θ − r sin θ at most, for θ up to 90° no more than −d. Beyond that it
/// is a push through the sheet, and that is never taken.
fn is_within(t: &Facing, low: Vec3, depth: f32) -> bool {
    let depth = f32s::max(depth, 0.0);
    (0..3).all(|k| {
        let (p, q) = (t.corners[k], t.corners[(k + 1) % 3]);
        // As long as the edge.
        let inwards = t.normal.cross(q - p);
        let r = inwards.dot(low - p);
        r >= 0.0 && r * r >= depth * depth * inwards.length_squared()
    })
}

/// What B shows to the face, clipped to the triangle.
fn face_only(t: &Facing, b: &Convex, pose: &Pose, margin: f32, scratch: &mut Scratch) -> Option<Manifold> {
    general::triangle_contact((&t.corners, t.normal), b, pose, margin, scratch)
}

fn general_face_axis(t: &TrianglePoly, low: Vec3, gap: f32) -> super::hull_hull::Axis {
    let normal = t.normal();
    super::hull_hull::Axis { normal, gap, a: low - normal * gap, b: low, feature: 0 }
}

/// Ball of radius `r` at `p`, in front of the triangle.
fn sphere(surface: &Surface, t: &Facing, r: f32, p: Vec3, margin: f32) -> Option<Manifold> {
    let n = t.normal;
    let near = closest_point(&t.corners, p);
    let d = p - near;
    let reach = r + margin;
    if d.length_squared() > reach * reach {
        return None;
    }
    let height = n.dot(p - t.corners[0]);
    let face = |faces| {
        let s = height - r;
        (s <= margin).then(|| one_point(n, p - n * (r + 0.5 * s), s, 0, faces))
    };
    let Some((c, l)) = d.try_normalize() else { return face(FACE_A) };
    let cosine = c.dot(n);
    if cosine > 0.99999 || l < 1e-4 * r {
        return face(FACE_A);
    }
    if !surface.full(t).allows(c) {
        // The gap between the face and a neighbour of the same plane up to the edge's tolerance.
        return if cosine > 0.9985 { face(FACE_A) } else { None };
    }
    let s = l - r;
    (s <= margin).then(|| one_point(c, near + c * (0.5 * s), s, 1, 0))
}

fn add(candidates: &mut Vec<Candidate>, m: &Manifold, facing: u32, name: u32) {
    for p in m.points() {
        let feature = (name.wrapping_mul(0x9E37_79B1) ^ p.feature).wrapping_mul(0x85EB_CA6B);
        candidates.push(Candidate {
            normal: m.normal,
            facing,
            faces: m.faces,
            triangle: name,
            taken: false,
            point: ManifoldPoint { feature: feature ^ feature >> 15, ..*p },
        });
    }
}

/// Edge and vertex contacts in the plane of a face contact: where their own triangle continues that plane, its face
/// answers instead; where they only lean a little, they take the plane's normal.
fn snap_to_faces(
    candidates: &mut Vec<Candidate>,
    faces: &[Facing],
    slop: f32,
    mut face_only: impl FnMut(&Facing) -> Option<Manifold>,
) {
    let mut last = NO_SUB;
    for i in 0..candidates.len() {
        let c = candidates[i];
        if c.faces & FACE_A != 0 {
            continue;
        }
        let Some(own) = faces.get(c.facing as usize) else { continue };
        let surface = c.point.point - c.normal * (0.5 * c.point.separation);
        let face = candidates.iter().find(|f| {
            let on = f.point.point - f.normal * (0.5 * f.point.separation);
            let in_plane = |p: &Vec3| f.normal.dot(*p - on).abs() <= slop;
            f.faces & FACE_A != 0
                && (own.normal.dot(f.normal) > 0.99 && own.corners.iter().any(in_plane)
                    || c.normal.dot(f.normal) > 0.95 && in_plane(&surface))
        });
        let Some(normal) = face.map(|f| f.normal) else { continue };
        if own.normal.dot(normal) > 0.99 {
            candidates[i].taken = true;
            if c.triangle != last {
                last = c.triangle;
                if let Some(m) = face_only(own) {
                    add(candidates, &m, c.facing, c.triangle);
                }
            }
            continue;
        }
        let separation = c.point.separation * c.normal.dot(normal);
        let q = &mut candidates[i];
        q.point.separation = separation;
        q.point.point = surface + normal * (0.5 * separation);
        q.normal = normal;
    }
}

/// One manifold for all candidates of nearly equal normal; face contacts lead.
fn merge(mesh: &mut MeshScratch, cache: &mut PairCache, out: &mut Vec<Manifold>) {
    let MeshScratch { candidates, group, .. } = mesh;
    let first = out.len();
    if group.capacity() == 0 {
        group.reserve(ROOM);
        out.reserve(ROOM);
    }
    for lead_faces in [true, false] {
        for i in 0..candidates.len() {
            let lead = candidates[i];
            if lead.taken || (lead.faces & FACE_A != 0) != lead_faces {
                continue;
            }
            if out.len() - first == MANIFOLDS_PER_PAIR_MAX {
                return;
            }
            group.clear();
            let mut deepest = lead;
            for c in candidates.iter_mut() {
                if c.taken || c.normal.dot(lead.normal) < SAME_NORMAL {
                    continue;
                }
                c.taken = true;
                if c.point.separation < deepest.point.separation {
                    deepest = *c;
                }
                group.push(c.point);
            }
            let mut m = Manifold {
                normal: lead.normal,
                faces: lead.faces,
                sub_a: deepest.triangle,
                sub_b: NO_SUB,
                ..Manifold::default()
            };
            if group.len() <= 4 {
                drop_twins(group);
            }
            reduce(group, &mut m, cache);
            part_features(&mut m);
            out.push(m);
        }
    }
}

/// Of two points at one place the deeper stays.
fn drop_twins(group: &mut Vec<ManifoldPoint>) {
    let mut n = 0;
    for i in 0..group.len() {
        let p = group[i];
        match group[..n].iter_mut().find(|q| (q.point - p.point).length_squared() < 1e-8) {
            Some(q) if p.separation < q.separation => *q = p,
            Some(_) => {}
            None => {
                group[n] = p;
                n += 1;
            }
        }
    }
    group.truncate(n);
}

/// Ids of different triangles are mixed and may, rarely, meet.
fn part_features(m: &mut Manifold) {
    for i in 1..usize::from(m.count) {
        while m.points[..i].iter().any(|q| q.feature == m.points[i].feature) {
            m.points[i].feature = m.points[i].feature.wrapping_add(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;
    use crate::{Hull, Shape, TriMesh, TriMeshOptions};
    use std::sync::Arc;

    /// Where a shape is said to be within a triangle, no other direction parts the two sooner, or it leads through the sheet.
    #[test]
    fn what_is_within_a_triangle_is_parted_by_its_face() {
        let mut r = Random(5);
        let points: Vec<Vec3> = (0..20).map(|_| r.vec() * 0.6).collect();
        let shapes = [
            Shape::Box { half: Vec3::new(0.3, 0.2, 0.9) },
            Shape::Capsule { half_height: 0.6, radius: 0.1 },
            Shape::Hull(Arc::new(Hull::new(&points).expect("a hull"))),
        ];
        let (mut within, mut not, mut through) = (0, 0, 0);
        for shape in &shapes {
            let b = Convex::of(shape).expect("convex");
            for _ in 0..3000 {
                let corners = [0; 3].map(|_| r.vec() * 1.5);
                let options = TriMeshOptions { double_sided: true, ..TriMeshOptions::default() };
                let Ok(mesh) = TriMesh::new(&corners, &[[0, 1, 2]], options) else { continue };
                let surface = Surface::Mesh(&mesh);
                let pose = Pose::new(r.vec(), r.quat(3.0));
                let Some(t) = surface.facing(0, pose.transform_point(b.center())) else { continue };
                let n = t.normal;
                let low = pose.transform_point(b.core.support(pose.q.inverse_rotate(-n)));
                let gap = n.dot(low - t.corners[0]);
                if !is_within(&t, low, -gap) {
                    not += 1;
                    continue;
                }
                let a = Convex::triangle(surface.full(&t).poly);
                let mut cache = PairCache { axis: n, kind: general::KIND_FACE_A, ..PairCache::default() };
                let best = general::axis(&a, &b, &pose, f32::MAX, &mut cache).expect("near");
                if best.normal.dot(n) < 0.0 {
                    through += 1;
                    continue;
                }
                within += 1;
                assert!((best.gap - gap).abs() < 1e-4, "{shape:?} {t:?} {pose:?}: {} for {gap}", best.gap);
                let sideways = best.normal - n;
                assert!(sideways.length() < 0.05 || gap.abs() < 0.01, "{shape:?} {t:?} {pose:?}: {best:?}");
            }
        }
        assert!(within > 300 && not > 3000 && through > 2, "{within}, {not}, {through}");
    }
}
