//! Convex hulls of kind and of hostile points.

mod common;
use common::Rng;
use jounce_geometry::{GeometryError, Hull, Shape, limits};
use jounce_math::{
    Quat, Vec3,
    scalar::{f32s, f64s},
};

fn below(r: &mut Rng, n: usize) -> usize {
    r.next() as usize % n
}

/// Every point is behind every face and every vertex was given.
fn check_holds(hull: &Hull, points: &[Vec3]) {
    hull.validate().unwrap();
    let extent = (hull.aabb().max - hull.aabb().min).max_component();
    let largest = points.iter().fold(0.0f32, |m, p| f32s::max(p.abs().max_component(), m));
    let tolerance = 40.0 * f64s::max(2e-6 * f64::from(extent), 4.0 * f64::from(f32::EPSILON * largest));
    let truncated = hull.vertices().len() == limits::HULL_VERTICES_MAX;
    for p in points {
        for f in hull.faces() {
            let h = f.normal.as_dvec3().dot(p.as_dvec3()) - f64::from(f.offset);
            assert!(
                h <= tolerance || truncated,
                "point {p:?} is {h:e} m in front of {f:?}, tolerance {tolerance:e}\n{hull:?}\n{points:?}"
            );
        }
    }
    for v in hull.vertices() {
        assert!(points.contains(v));
    }
}

fn cube(half: Vec3) -> Vec<Vec3> {
    (0..8u32)
        .map(|k| {
            let s = |bit| if k & bit == 0 { -1.0 } else { 1.0 };
            Vec3::new(s(1) * half.x, s(2) * half.y, s(4) * half.z)
        })
        .collect()
}

#[test]
fn box_has_six_faces_however_it_is_turned_scaled_or_crowded() {
    let mut r = Rng(1);
    for round in 0..200 {
        let half = Vec3::new(0.2 + r.unit(), 0.2 + r.unit(), 0.2 + r.unit());
        let scale = [1e-6, 1e-3, 1.0, 1e3, 3e5][round % 5];
        let q = r.rotation();
        let mut points = cube(half);
        // Points on edges, on faces, inside, and duplicates.
        for _ in 0..below(&mut r, 60) {
            let (a, b) = (points[below(&mut r, 8)], points[below(&mut r, 8)]);
            points.push(a.lerp(b, r.unit()));
        }
        let points: Vec<Vec3> = points.iter().map(|&p| q.rotate(p) * scale).collect();
        let hull = Hull::new(&points).unwrap();
        check_holds(&hull, &points);
        assert_eq!((hull.vertices().len(), hull.edges().len(), hull.faces().len()), (8, 12, 6));
        let inner = half.min_component() * scale;
        assert!((hull.inner_radius() - inner).abs() < 1e-4 * inner);
    }
    let hull = Hull::cuboid(Vec3::new(1.0, 2.0, 3.0)).unwrap();
    assert_eq!(hull.faces().len(), 6);
    let (a, b) = (
        Shape::Hull(hull.into()).mass_properties(7.0).unwrap(),
        Shape::Box { half: Vec3::new(1.0, 2.0, 3.0) }.mass_properties(7.0).unwrap(),
    );
    assert_eq!(a, b);
}

#[test]
fn round_bodies_keep_their_vertices_up_to_the_limit() {
    let mut r = Rng(2);
    for n in [20, 100, 250, 2000, 20_000] {
        let points: Vec<Vec3> = (0..n).map(|_| r.direction()).collect();
        let hull = Hull::new(&points).unwrap();
        check_holds(&hull, &points);
        assert_eq!(hull.vertices().len(), n.min(limits::HULL_VERTICES_MAX));
        // 255 of the most extreme points leave little of the ball out.
        if n >= 250 {
            let farthest =
                points.iter().flat_map(|p| hull.faces().iter().map(|f| f.normal.dot(*p) - f.offset));
            assert!(farthest.fold(0.0, f32s::max) < 0.05);
        }
    }
}

#[test]
fn refusals_name_the_reason() {
    let named = |points: &[Vec3]| match Hull::new(points) {
        Err(GeometryError::Degenerate { what, .. }) => what,
        other => panic!("{other:?}"),
    };
    let mut r = Rng(3);
    let (a, u, v) = (r.vec(1.0), r.direction(), r.direction());
    assert_eq!(named(&[a; 9]), "all one point");
    let line: Vec<Vec3> = (0..9).map(|i| u * i as f32).collect();
    assert!(["collinear", "too thin"].contains(&named(&line)));
    assert_eq!(named(&(0..9).map(|i| Vec3::X * i as f32).collect::<Vec<_>>()), "collinear");
    let plane: Vec<Vec3> = (0..30).map(|_| u * r.unit() + v * r.unit()).collect();
    assert!(["coplanar", "too thin"].contains(&named(&plane)));
    assert_eq!(named(&(0..9).map(|_| Vec3::new(r.unit(), 0.0, r.unit())).collect::<Vec<_>>()), "coplanar");
    assert_eq!(named(&cube(Vec3::new(1.0, 1e-6, 1.0))), "too thin");
    assert!(matches!(Hull::new(&[a, u, v]), Err(GeometryError::BadCount { .. })));
    let mut bad = cube(Vec3::ONE);
    bad[5].y = f32::NAN;
    assert!(matches!(Hull::new(&bad), Err(GeometryError::NotFinite { index: 5, .. })));
    for scale in [1e-8, 1e8] {
        assert!(matches!(Hull::new(&cube(Vec3::splat(scale))), Err(GeometryError::BadNumber { .. })));
    }
    assert!(Hull::cuboid(Vec3::new(1.0, 0.0, 1.0)).is_err());
}

#[test]
fn scaled_and_mirrored() {
    let hull = Hull::cuboid(Vec3::ONE).unwrap();
    let stretched = hull.scaled(Vec3::new(-2.0, 1.0, 3.0)).unwrap();
    stretched.validate().unwrap();
    assert_eq!(stretched.aabb().max, Vec3::new(2.0, 1.0, 3.0));
    assert!(hull.scaled(Vec3::new(1.0, 0.0, 1.0)).is_err());
}

/// Points that break hull builders: grids, clusters within rounding of each other, slivers, flats with
/// noise near the tolerance, rings, all far from the origin now and then.
fn hostile(r: &mut Rng) -> Vec<Vec3> {
    let n = 4 + below(r, 40);
    let noise = [0.0, 1e-8, 1e-7, 1e-6, 4e-6, 1e-5, 1e-4][below(r, 7)];
    let kind = below(r, 8);
    let clusters: Vec<Vec3> = (0..2 + below(r, 5)).map(|_| r.vec(1.0)).collect();
    let thin = [1.0, 1e-2, 1e-4, 1e-5, 1e-6][below(r, 5)];
    let mut points: Vec<Vec3> = (0..n)
        .map(|i| {
            let p = match kind {
                0 => Vec3::new(below(r, 3) as f32, below(r, 3) as f32, below(r, 3) as f32),
                1 => clusters[below(r, clusters.len())],
                2 => r.vec(1.0),
                3 => r.direction(),
                4 => {
                    let a = (i / 2) as f32 * 12.566_371 / n as f32;
                    Vec3::new(f32s::cos(a), if i % 2 == 0 { 1.0 } else { -1.0 }, f32s::sin(a))
                }
                5 => {
                    let mut p = r.vec(1.0);
                    let axis = below(r, 3);
                    p[axis] = p[axis].signum();
                    p
                }
                6 => clusters[0].lerp(clusters[1], r.unit()) + clusters[i % clusters.len()] * 1e-3,
                // A shallow dome: its curvature is about the tolerance.
                _ => {
                    let (x, z) = (r.unit() - 0.5, r.unit() - 0.5);
                    Vec3::new(x, 1e-5 * (1.0 - x * x - z * z) - if i < 4 { 0.5 } else { 0.0 }, z)
                }
            };
            Vec3::new(p.x, p.y * thin, p.z) + r.vec(1.0) * noise
        })
        .collect();
    let q = if below(r, 2) == 0 { r.rotation() } else { Quat::IDENTITY };
    let scale = [1e-6, 1e-3, 1.0, 1e5][below(r, 4)];
    let shift = if below(r, 4) == 0 { r.vec(1.0) * 100.0 } else { Vec3::ZERO };
    for p in &mut points {
        *p = (q.rotate(*p) + shift) * scale;
    }
    points
}

#[test]
fn hostile_points_make_a_valid_hull_or_a_named_refusal() {
    let count = if std::env::var_os("JOUNCE_PROVE").is_some() { 1_000_000 } else { 10_000 };
    let mut r = Rng(4);
    let (mut built, mut triangulated) = (0, 0);
    for k in 0..count {
        let points = hostile(&mut r);
        match Hull::new(&points) {
            Ok(hull) => {
                built += 1;
                triangulated += usize::from(hull.faces().iter().all(|f| hull.face_vertices(f).len() == 3));
                hull.validate().unwrap_or_else(|e| panic!("set {k}: {e}\n{points:?}"));
                check_holds(&hull, &points);
                assert_eq!(hull, Hull::new(&points).unwrap());
            }
            Err(GeometryError::Degenerate { .. } | GeometryError::BadNumber { .. }) => {}
            Err(e) => panic!("set {k}: {e}"),
        }
    }
    println!("{built} of {count} built, {triangulated} of triangles only");
    assert!(built > count / 2);
}
