//! Contacts with surfaces of triangles and with compounds: no ghost normals, whole manifolds, right heights.

mod common;
use common::Rng;
use jounce_geometry::{
    Compound, HeightField, Hull, Manifold, ManifoldSet, PairCache, Shape, TriMesh, TriMeshOptions, collide,
};
use jounce_math::{Pose, Quat, Vec3, scalar::f32s};
use std::sync::Arc;

const MARGIN: f32 = 0.02;

fn flat_field(spacing: f32) -> Shape {
    Shape::HeightField(Arc::new(HeightField::new(21, 21, [spacing; 2], vec![0.0; 441]).unwrap()))
}

/// A flat square as a mesh of the same cells, with each cell's diagonal at random.
fn flat_mesh(spacing: f32, rng: &mut Rng) -> Shape {
    let at = |i: u32, j: u32| Vec3::new((i as f32 - 10.0) * spacing, 0.0, (j as f32 - 10.0) * spacing);
    let vertices: Vec<Vec3> = (0..21).flat_map(|j| (0..21).map(move |i| at(i, j))).collect();
    let mut triangles = Vec::new();
    for j in 0..20 {
        for i in 0..20 {
            let [a, b, c, d] = [j * 21 + i, (j + 1) * 21 + i, (j + 1) * 21 + i + 1, j * 21 + i + 1];
            if rng.unit() < 0.5 {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    Shape::Mesh(Arc::new(TriMesh::new(&vertices, &triangles, TriMeshOptions::default()).unwrap()))
}

/// The same cells as tiles of their own that know nothing of each other: every edge is a border.
fn loose_mesh(spacing: f32) -> Shape {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for k in 0..400u32 {
        let (i, j) = ((k % 20) as f32 - 10.0, (k / 20) as f32 - 10.0);
        // Corners of neighbours differ in the last bits only, so nothing is joined.
        let e = 1e-6 * k as f32;
        for (x, z) in [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)] {
            vertices.push(Vec3::new((i + x) * spacing + e, 0.0, (j + z) * spacing + e));
        }
        triangles.extend([[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]]);
    }
    Shape::Mesh(Arc::new(TriMesh::new(&vertices, &triangles, TriMeshOptions::default()).unwrap()))
}

fn manifolds(a: &Shape, b: &Shape, pose: &Pose) -> Vec<Manifold> {
    let mut out = ManifoldSet::new();
    collide(a, b, pose, MARGIN, &mut PairCache::default(), &mut out);
    out.manifolds
}

/// A six-sided prism.
fn prism() -> Hull {
    let corner = |k: usize, y: f32| {
        let angle = std::f32::consts::FRAC_PI_3 * k as f32;
        let (s, c) = (f32s::sin(angle), f32s::cos(angle));
        Vec3::new(0.5 * c, y, 0.5 * s)
    };
    let points: Vec<Vec3> = (0..12).map(|k| corner(k % 6, if k < 6 { -0.35 } else { 0.35 })).collect();
    Hull::new(&points).unwrap()
}

fn bodies() -> Vec<(Shape, f32)> {
    vec![
        (Shape::Sphere { radius: 0.5 }, 0.5),
        (Shape::Box { half: Vec3::new(0.5, 0.3, 0.4) }, 0.3),
        (Shape::Capsule { half_height: 0.5, radius: 0.2 }, 0.7),
        (Shape::Cylinder { half_height: 0.4, radius: 0.5 }, 0.4),
        (Shape::Cone { half_height: 0.4, radius: 0.5 }, 0.4),
        (Shape::Hull(Arc::new(prism())), 0.35),
    ]
}

/// Every kind of flat ground with every body.
fn grounds(spacing: f32, rng: &mut Rng) -> Vec<(Shape, (Shape, f32))> {
    let grounds = [flat_field(spacing), flat_mesh(spacing, rng), loose_mesh(spacing)];
    grounds.iter().flat_map(|g| bodies().into_iter().map(|b| (g.clone(), b))).collect()
}

/// Bodies slide and spin over a flat grid, a little inside, touching or a little above: every normal is the grid's, every
/// separation the body's.
#[test]
fn sliding_over_flat_triangles_never_leaves_the_normal() {
    let mut rng = Rng(0xF1A7);
    for spacing in [0.15, 0.4, 1.0, 3.0] {
        for (ground, (body, height)) in grounds(spacing, &mut rng) {
            for k in 0..100 {
                let depth = [0.005, 0.05, -0.01, 0.0005][k % 4];
                let at = Vec3::new(rng.range(-0.6, 0.6), height - depth, rng.range(-0.6, 0.6));
                let q = Quat::from_axis_angle(Vec3::Y, rng.range(-3.0, 3.0));
                let m = manifolds(&ground, &body, &Pose::new(at, q));
                let what = format!("{spacing} {body:?} {at:?} {q:?} {m:?}");
                assert_eq!(m.len(), 1, "{what}");
                assert!((m[0].normal - Vec3::Y).length() < 1e-3, "{what}");
                let least = match body {
                    Shape::Sphere { .. } | Shape::Capsule { .. } => 1,
                    Shape::Box { .. } => 4,
                    _ => 3,
                };
                assert!(usize::from(m[0].count) >= least, "{what}");
                for p in m[0].points() {
                    assert!((p.separation + depth).abs() < 1e-4, "{what}");
                }
            }
        }
    }
}

/// The same bodies tilted at random, so that an edge or corner is lowest.
#[test]
fn tilted_bodies_on_flat_triangles_keep_the_normal() {
    let mut rng = Rng(0x711F);
    for spacing in [0.15, 0.4, 1.0, 3.0] {
        for (ground, (body, _)) in grounds(spacing, &mut rng) {
            for k in 0..200 {
                let q = rng.rotation();
                let low = -q.rotate(common::support(&body, q.inverse_rotate(-Vec3::Y))).y;
                let depth = [0.005, 0.03, -0.01, 0.0005][k % 4];
                let at = Vec3::new(rng.range(-0.6, 0.6), low - depth, rng.range(-0.6, 0.6));
                let m = manifolds(&ground, &body, &Pose::new(at, q));
                let what = format!("{spacing} #{k} {body:?} {at:?} {q:?} {m:?}");
                assert!(!m.is_empty(), "{what}");
                let mut deepest = f32::MAX;
                for m in &m {
                    assert!((m.normal - Vec3::Y).length() < 1e-3, "{what}");
                    deepest = m.points().iter().fold(deepest, |d, p| f32s::min(p.separation, d));
                }
                assert!((deepest + depth).abs() < 1e-3, "{deepest} {what}");
            }
        }
    }
}

/// A ball in a valley touches both slopes; on a ridge it takes a normal between them.
#[test]
fn valleys_and_ridges() {
    let field = |sign: f32| {
        let h = (0..9).map(|k| sign * ((k % 3) as f32 - 1.0).abs()).collect();
        Shape::HeightField(Arc::new(HeightField::new(3, 3, [1.0; 2], h).unwrap()))
    };
    let ball = Shape::Sphere { radius: 0.5 };
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let y = 0.5 / half - 0.005;
    let m = manifolds(&field(1.0), &ball, &Pose::from_translation(Vec3::new(0.0, y, 0.3)));
    assert_eq!(m.len(), 2, "{m:?}");
    for m in &m {
        assert!((m.normal.y - half).abs() < 1e-3 && (m.normal.x.abs() - half).abs() < 1e-3);
    }
    let m = manifolds(&field(-1.0), &ball, &Pose::from_translation(Vec3::new(0.05, 0.49, 0.3)));
    assert_eq!(m.len(), 1, "{m:?}");
    assert!(m[0].normal.y > 0.98, "{m:?}");
}

/// A body under a one-sided surface is left alone.
#[test]
fn behind_a_one_sided_surface_is_free() {
    let ground = flat_field(1.0);
    for (body, _) in bodies() {
        assert!(manifolds(&ground, &body, &Pose::from_translation(Vec3::new(0.2, -0.05, 0.3))).is_empty());
    }
}

/// A table of five boxes on a half-space, a field and a box: four feet down, in any order of the shapes.
#[test]
fn compound_stands_on_its_children() {
    let leg = |x: f32, z: f32| {
        (Pose::from_translation(Vec3::new(x, -0.5, z)), Shape::Box { half: Vec3::new(0.05, 0.5, 0.05) })
    };
    let top = (Pose::IDENTITY, Shape::Box { half: Vec3::new(1.0, 0.05, 1.0) });
    let children = vec![top, leg(0.9, 0.9), leg(-0.9, 0.9), leg(0.9, -0.9), leg(-0.9, -0.9)];
    let table = Shape::Compound(Arc::new(Compound::new(children).unwrap()));
    let grounds = [
        Shape::HalfSpace { normal: Vec3::Y, offset: 0.0 },
        flat_field(0.7),
        Shape::Box { half: Vec3::new(4.0, 1.0, 4.0) },
    ];
    for (k, ground) in grounds.iter().enumerate() {
        let lift = if k == 2 { 1.0 } else { 0.0 };
        let pose = Pose::from_translation(Vec3::new(0.0, 0.995 + lift, 0.0));
        let m = manifolds(ground, &table, &pose);
        assert_eq!(m.len(), 4, "{m:?}");
        for m in &m {
            assert!((m.normal - Vec3::Y).length() < 1e-4, "{m:?}");
            assert_eq!(m.count, 4);
            assert!((1..5).contains(&m.sub_b), "{m:?}");
            assert!(m.points().iter().all(|p| (p.separation + 0.005).abs() < 1e-5), "{m:?}");
        }
        let w = manifolds(&table, ground, &pose.inverse());
        assert_eq!(w.len(), 4);
        assert!(w.iter().all(|m| (m.normal + Vec3::Y).length() < 1e-4 && (1..5).contains(&m.sub_a)));
    }
    // Two tables, one on the other.
    let m = manifolds(&table, &table, &Pose::from_translation(Vec3::new(0.0, 1.045, 0.0)));
    assert_eq!(m.len(), 4, "{m:?}");
    assert!(m.iter().all(|m| m.sub_a == 0 && (1..5).contains(&m.sub_b)));
}
