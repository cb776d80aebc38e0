//! Triangle meshes: what is kept, how edges are classed, rays and closest points against every triangle in turn.

mod common;
use common::Rng;
use jounce_geometry::{Aabb, GeometryError, NO_SUB, Shape, TriMesh, TriMeshOptions};
use jounce_math::{Vec3, scalar::f32s};

fn mesh(vertices: &[Vec3], triangles: &[[u32; 3]]) -> TriMesh {
    TriMesh::new(vertices, triangles, TriMeshOptions::default()).unwrap()
}

/// Wavy ground over n × n cells, with a few triangles of no area between the others.
fn ground(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let h = |i: u32, j: u32| 0.3 * f32s::sin(i as f32 * 0.7) * f32s::cos(j as f32 * 0.9);
    let vertices =
        (0..=n).flat_map(|j| (0..=n).map(move |i| Vec3::new(i as f32, h(i, j), j as f32))).collect();
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            triangles.push([a, a + n + 1, a + n + 2]);
            if (i + j) % 5 == 0 {
                triangles.push([a, a + 1, a]);
            }
            triangles.push([a, a + n + 2, a + 1]);
        }
    }
    (vertices, triangles)
}

#[test]
fn indices_are_those_of_the_given_list() {
    let (v, t) = ground(10);
    let m = mesh(&v, &t);
    assert_eq!(m.len() + m.dropped(), t.len());
    assert_eq!(m.dropped(), 20);
    let mut seen: Vec<u32> = (0..m.len() as u32).map(|i| m.original_index(i)).collect();
    for i in 0..m.len() as u32 {
        let given = t[m.original_index(i) as usize].map(|k| v[k as usize]);
        assert_eq!(m.triangle(i), given);
        assert!(m.normal(i).y > 0.0);
    }
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen.len(), m.len());
    let materials: Vec<u16> = (0..t.len() as u16).collect();
    let m = m.with_materials(&materials).unwrap();
    assert_eq!((m.material(7), m.material(100_000)), (7, 0));
    assert!(matches!(m.with_materials(&[1, 2]), Err(GeometryError::BadCount { .. })));
}

#[test]
fn rays_and_closest_points_agree_with_every_triangle_in_turn() {
    let (v, t) = ground(24);
    let one_by_one: Vec<Shape> = t
        .iter()
        .filter_map(|t| {
            let corners = t.map(|k| v[k as usize]);
            let single = TriMesh::new(&corners, &[[0, 1, 2]], TriMeshOptions::default()).ok()?;
            Some(Shape::Mesh(single.into()))
        })
        .collect();
    let shape = Shape::Mesh(mesh(&v, &t).into());
    let mut r = Rng(7);
    let mut hits = 0;
    for _ in 0..2000 {
        let o = Vec3::new(12.0, 0.0, 12.0) + r.vec(1.0).mul(Vec3::new(14.0, 3.0, 14.0));
        let d = r.vec(1.0);
        let got = shape.ray_cast(o, d, 10.0);
        let want = one_by_one.iter().filter_map(|s| s.ray_cast(o, d, 10.0)).map(|h| h.t);
        let want = want.fold(f32::INFINITY, f32s::min);
        assert_eq!(got.map_or(f32::INFINITY, |h| h.t), want);
        if let Some(h) = got {
            hits += 1;
            assert!(h.normal.dot(d) <= 0.0);
            let [a, b, c] = t[h.sub as usize].map(|k| v[k as usize]);
            let n = (b - a).cross(c - a).normalize_or(Vec3::Y);
            assert!(n.dot(o + d * h.t - a).abs() < 1e-4);
        }
        let got = shape.closest_point(o).unwrap();
        let want = one_by_one.iter().filter_map(|s| s.closest_point(o)).map(|h| h.distance);
        assert_eq!(got.distance, want.fold(f32::INFINITY, f32s::min));
        assert!((got.point + got.normal * got.distance - o).length() < 1e-4);
    }
    assert!(hits > 500);
    assert!(!shape.contains_point(Vec3::new(5.0, -10.0, 5.0)));
}

/// Straight down onto vertices and edges of the grid, where a careless test falls through.
#[test]
fn no_ray_slips_between_triangles() {
    let (v, t) = ground(16);
    let turned: Vec<[u32; 3]> = t.iter().map(|t| [t[0], t[2], t[1]]).collect();
    let shapes = [t, turned].map(|t| Shape::Mesh(mesh(&v, &t).into()));
    let mut r = Rng(9);
    for shape in (0..4000).map(|k| &shapes[k % 2]) {
        let (i, j) = (1 + r.next() as u32 % 15, 1 + r.next() as u32 % 15);
        let a = v[(j * 17 + i) as usize];
        let b = v[(j * 17 + i + [1, 17, 18, 0][r.next() as usize % 4]) as usize];
        let target = a.lerp(b, r.unit());
        let o = target + Vec3::new(r.unit() - 0.5, 3.0, r.unit() - 0.5);
        assert!(shape.ray_cast(o, target - o, 2.0).is_some(), "{o:?} {target:?}");
        for side in [5.0, -5.0] {
            let o = Vec3::new(target.x, side, target.z);
            assert!(shape.ray_cast(o, Vec3::Y * -side, 2.0).is_some(), "{o:?}");
        }
    }
}

#[test]
fn both_sides_are_hit_and_the_normal_faces_the_origin() {
    let m = mesh(&[Vec3::ZERO, Vec3::Z, Vec3::X], &[[0, 1, 2]]);
    assert_eq!(m.normal(0), Vec3::Y);
    let shape = Shape::Mesh(m.into());
    let p = Vec3::new(0.2, 0.0, 0.2);
    for (o, normal) in [(p + Vec3::Y, Vec3::Y), (p - Vec3::Y, -Vec3::Y)] {
        let h = shape.ray_cast(o, p - o, 2.0).unwrap();
        assert_eq!((h.t, h.normal, h.sub), (1.0, normal, 0));
    }
}

#[test]
fn welding_joins_what_is_near() {
    let e = 1e-4;
    let v = [
        Vec3::ZERO,
        Vec3::X,
        Vec3::Y,
        Vec3::new(1.0, e, 0.0),
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(-e, 1.0, 0.0),
        Vec3::new(-0.0, 0.0, -0.0),
    ];
    let t = [[0, 1, 2], [3, 4, 5], [6, 1, 2]];
    assert_eq!(mesh(&v, &t).vertices().len(), 6);
    let options = TriMeshOptions { weld_distance: 2.0 * e, double_sided: true };
    let m = TriMesh::new(&v, &t, options).unwrap();
    assert_eq!(m.vertices().len(), 4);
    assert!(m.is_double_sided());
}

#[test]
fn hostile_lists_are_refused_by_name() {
    let v = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let new = |v: &[Vec3], t: &[[u32; 3]]| TriMesh::new(v, t, TriMeshOptions::default()).map(|_| ());
    assert!(matches!(new(&v, &[]), Err(GeometryError::BadCount { .. })));
    assert!(matches!(
        new(&v, &[[0, 1, 2], [0, 1, 3]]),
        Err(GeometryError::BadIndex { triangle: 1, index: 3, .. })
    ));
    assert!(matches!(
        new(&[v[0], v[1], Vec3::splat(f32::NAN)], &[[0, 1, 2]]),
        Err(GeometryError::NotFinite { index: 2, .. })
    ));
    assert!(matches!(new(&v, &[[0, 1, 1]]), Err(GeometryError::Unsupported { .. })));
    assert!(matches!(new(&v.map(|p| p * 1e7), &[[0, 1, 2]]), Err(GeometryError::BadNumber { .. })));
    let options = TriMeshOptions { weld_distance: f32::NAN, double_sided: false };
    assert!(matches!(TriMesh::new(&v, &[[0, 1, 2]], options), Err(GeometryError::BadNumber { .. })));
}

#[test]
fn overlapping_finds_every_box() {
    let (v, t) = ground(12);
    let m = mesh(&v, &t);
    let mut r = Rng(11);
    for _ in 0..200 {
        let q = Aabb::from_center(Vec3::new(6.0, 0.0, 6.0) + r.vec(1.0) * 6.0, r.vec(1.0).abs());
        let mut got = Vec::new();
        m.overlapping(&q, |i| got.push(i));
        got.sort_unstable();
        let all = 0..m.len() as u32;
        let want: Vec<u32> = all.filter(|&i| Aabb::from_points(m.triangle(i)).overlaps(&q)).collect();
        assert_eq!(got, want);
    }
    assert_eq!(NO_SUB, u32::MAX);
}
