//! What one shape says about itself, against integrals on a lattice, optimality conditions and brute force.

mod common;
use common::{Rng, support};
use jounce_geometry::{Compound, GeometryError, HeightField, Hull, NO_SUB, Shape, TriMesh, TriMeshOptions};
use jounce_math::{DMat3, DVec3, Pose, Vec3, scalar::f32s};
use std::sync::Arc;

fn random_hull(r: &mut Rng) -> Shape {
    let points: Vec<Vec3> = (0..12).map(|_| r.vec(1.0)).collect();
    Shape::Hull(Arc::new(Hull::new(&points).unwrap()))
}

/// Convex shapes of sizes about `scale`, thin and thick.
fn solids(r: &mut Rng, scale: f32) -> Vec<Shape> {
    let mut s = || scale * r.range(0.1, 1.5);
    let mut list = vec![
        Shape::Sphere { radius: s() },
        Shape::Capsule { half_height: s(), radius: s() },
        Shape::Box { half: Vec3::new(s(), s(), s()) },
        Shape::Cylinder { half_height: s(), radius: s() },
        Shape::Cone { half_height: s(), radius: s() },
    ];
    let points: Vec<Vec3> = (0..14).map(|_| r.vec(scale)).collect();
    list.push(Shape::Hull(Arc::new(Hull::new(&points).unwrap())));
    list
}

/// Membership written apart from the library's; `slack` in metres grows the shape.
fn inside(shape: &Shape, p: Vec3, slack: f32) -> bool {
    let rho = (p.x * p.x + p.z * p.z).sqrt();
    match shape {
        Shape::Sphere { radius } => p.length() <= radius + slack,
        Shape::Capsule { half_height, radius } => {
            let y = f32s::max(p.y.abs() - half_height, 0.0);
            (rho * rho + y * y).sqrt() <= radius + slack
        }
        Shape::Box { half } => (p.abs() - *half).max_component() <= slack,
        Shape::Cylinder { half_height, radius } => rho <= radius + slack && p.y.abs() <= half_height + slack,
        Shape::Cone { half_height, radius } => {
            let (h, r) = (2.0 * half_height, *radius);
            let side = (rho * h - r * (half_height - p.y)) / (h * h + r * r).sqrt();
            side <= slack && p.y >= -half_height - slack
        }
        Shape::Hull(h) => h.faces().iter().all(|f| f.normal.dot(p) <= f.offset + slack),
        _ => unreachable!(),
    }
}

/// Mass, centre and inertia about it, summed over n³ cells of the bounds.
fn integrate(shape: &Shape, n: usize, density: f64) -> (f64, DVec3, DMat3) {
    let b = shape.aabb(&Pose::IDENTITY);
    let step = (b.max - b.min).as_dvec3() * (1.0 / n as f64);
    let dm = density * step.x * step.y * step.z;
    let (mut m, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for i in 0..n * n * n {
        let cell = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) + DVec3::splat(0.5);
        let p = b.min.as_dvec3() + cell.mul(step);
        if inside(shape, p.as_vec3(), 0.0) {
            m += dm;
            first += p * dm;
            second = second + DMat3::outer(p, p).scale(dm);
        }
    }
    let c = first * (1.0 / m);
    let cov = second - DMat3::outer(c, c).scale(m);
    (m, c, DMat3::from_diagonal(DVec3::splat(cov.cx.x + cov.cy.y + cov.cz.z)) - cov)
}

fn entries(m: DMat3) -> [f64; 9] {
    core::array::from_fn(|k| m.at(k / 3, k % 3))
}

/// The lattice's own error falls with the number of cells: at 90 along each side it is below a third of a percent.
#[test]
fn mass_is_the_integral() {
    let mut r = Rng(11);
    for scale in [1e-3, 1.0, 50.0] {
        for shape in solids(&mut r, scale) {
            let got = shape.mass_properties(700.0).unwrap();
            let (m, c, i) = integrate(&shape, 90, 700.0);
            let what = format!("{shape:?}: {got:?}, {m} {c:?} {i:?}");
            assert!((f64::from(got.mass) - m).abs() < 5e-3 * m, "{what}");
            let size = f64::from(shape.outer_radius(got.center));
            assert!((got.center.as_dvec3() - c).length() < 3e-3 * size, "{what}");
            let largest = i.cx.x + i.cy.y + i.cz.z;
            for (a, b) in entries(got.inertia.as_dmat3()).into_iter().zip(entries(i)) {
                assert!((a - b).abs() < 5e-3 * largest, "{what}");
            }
        }
    }
}

#[test]
fn mass_has_the_closed_forms() {
    let near = |a: f32, b: f32| assert!((a - b).abs() <= 1e-6 * b.abs(), "{a} {b}");
    let pi = core::f32::consts::PI;
    let m = Shape::Sphere { radius: 2.0 }.mass_properties(3.0).unwrap();
    near(m.mass, 32.0 * pi);
    near(m.inertia.cx.x, 0.4 * 4.0 * m.mass);
    // Right-angled tetrahedron: volume abc/6, centre (a, b, c)/4, I_xx = 3/80 m (b² + c²).
    let (a, b, c) = (1.0, 2.0, 3.0);
    let corners = [Vec3::ZERO, Vec3::X * a, Vec3::Y * b, Vec3::Z * c].map(|p| p + Vec3::splat(100.0));
    let m = Shape::Hull(Arc::new(Hull::new(&corners).unwrap())).mass_properties(2.0).unwrap();
    near(m.mass, 2.0);
    assert!((m.center - Vec3::splat(100.0) - Vec3::new(a, b, c) * 0.25).length() < 1e-5);
    near(m.inertia.cx.x, 2.0 * 3.0 / 80.0 * (b * b + c * c));
    near(m.inertia.cx.y, 2.0 / 80.0 * a * b);
    // Six pyramids of a cube seen from its centre: the sum over faces must not depend on the place.
    let half = Vec3::splat(0.5);
    let m = Shape::Box { half }.mass_properties(1.0).unwrap();
    near(m.mass, 1.0);
    near(m.inertia.cz.z, 1.0 / 6.0);
    assert!(Shape::HalfSpace { normal: Vec3::Y, offset: 0.0 }.mass_properties(1.0).is_none());
}

/// A box cut into eight turned pieces is the box.
#[test]
fn compound_adds_up_its_children() {
    let half = Vec3::new(1.0, 2.0, 0.5);
    let quarter_turn = jounce_math::Quat::from_axis_angle(Vec3::Y, core::f32::consts::FRAC_PI_2);
    let children = (0..8u32)
        .map(|k| {
            let side = |bit| if k & bit == 0 { -0.5 } else { 0.5 };
            let p = half.mul(Vec3::new(side(1), side(2), side(4)));
            let h = half * 0.5;
            (Pose::new(p, quarter_turn), Shape::Box { half: Vec3::new(h.z, h.y, h.x) })
        })
        .collect();
    let compound = Shape::Compound(Arc::new(Compound::new(children).unwrap()));
    let whole = Shape::Box { half };
    let (a, b) = (compound.mass_properties(5.0).unwrap(), whole.mass_properties(5.0).unwrap());
    assert!((a.mass - b.mass).abs() < 1e-5 * b.mass);
    assert!(a.center.length() < 1e-6);
    for (x, y) in entries(a.inertia.as_dmat3()).into_iter().zip(entries(b.inertia.as_dmat3())) {
        assert!((x - y).abs() < 1e-5 * f64::from(b.inertia.cx.x));
    }
    let mut r = Rng(5);
    for _ in 0..2000 {
        let (o, d) = (r.vec(3.0), r.direction());
        let (x, y) = (compound.ray_cast(o, d, 9.0), whole.ray_cast(o, d, 9.0));
        match (x, y) {
            (Some(x), Some(y)) => assert!((x.t - y.t).abs() < 1e-5 && x.sub < 8),
            (x, y) => assert!(x.is_none() == y.is_none(), "{o:?} {d:?} {x:?} {y:?}"),
        }
        let (x, y) = (compound.closest_point(o).unwrap(), whole.closest_point(o).unwrap());
        assert!(y.distance < 0.0 || (x.distance - y.distance).abs() < 1e-5);
    }
    let pose = Pose::new(r.vec(4.0), r.rotation());
    let (x, y) = (compound.aabb(&pose), whole.aabb(&pose));
    assert!((x.min - y.min).length() < 1e-5 && (x.max - y.max).length() < 1e-5);
    assert!((compound.outer_radius(Vec3::ZERO) - whole.outer_radius(Vec3::ZERO)).abs() < 1e-5);
}

#[test]
fn bounds_touch_the_support_points() {
    let mut r = Rng(21);
    for round in 0..400 {
        let scale = [1e-3, 1.0, 1e3][round % 3];
        for shape in solids(&mut r, scale) {
            let pose = Pose::new(r.vec(scale), r.rotation());
            let b = shape.aabb(&pose);
            for (axis, sign) in (0..3).flat_map(|a| [(a, 1.0), (a, -1.0)]) {
                let mut d = Vec3::ZERO;
                d[axis] = sign;
                let far = pose.transform_point(support(&shape, pose.q.inverse_rotate(d)))[axis];
                let face = if sign > 0.0 { b.max[axis] } else { b.min[axis] };
                assert!((far - face).abs() < 2e-6 * scale * 3.0, "{shape:?} {axis} {far} {face}");
            }
        }
    }
}

#[test]
fn radii_hold_the_shape() {
    let mut r = Rng(22);
    for _ in 0..100 {
        for shape in solids(&mut r, 1.0) {
            let c = shape.mass_properties(1.0).unwrap().center;
            let (inner, outer) = (shape.inner_radius(), shape.outer_radius(c));
            let (mut least, mut most) = (f32::MAX, 0.0f32);
            for _ in 0..500 {
                let d = r.direction();
                let s = support(&shape, d);
                least = f32s::min((s - c).dot(d), least);
                most = f32s::max((s - c).length(), most);
            }
            assert!(inner > 0.0 && inner <= least + 1e-5, "{shape:?} {inner} {least}");
            assert!(most <= outer + 1e-5 && outer < 1.1 * most, "{shape:?} {outer} {most}");
            // The ball touches: the depth of its centre is its radius.
            let depth = -shape.closest_point(c).unwrap().distance;
            assert!((depth - inner).abs() < 1e-5, "{shape:?} {depth} {inner}");
        }
    }
}

/// A point q with p = q + d n is nearest exactly if q belongs to the shape and no point of the shape lies
/// farther along n; inside, moreover, no other direction leads out sooner.
#[test]
fn closest_point_satisfies_the_optimality_conditions() {
    let mut r = Rng(31);
    for round in 0..300 {
        let scale = [1e-3, 1.0, 1e3][round % 3];
        for shape in solids(&mut r, scale) {
            for k in 0..20 {
                let mut p = r.vec(scale * 2.0);
                match k {
                    0 => p = Vec3::ZERO,
                    1 => p = Vec3::Y * p.y,
                    2 => p.y = 0.0,
                    3 => p = support(&shape, r.direction()),
                    _ => {}
                }
                let h = shape.closest_point(p).unwrap();
                let e = 1e-5 * scale;
                let what = format!("{p:?} {h:?} {shape:?}");
                assert!((h.normal.length() - 1.0).abs() < 1e-5, "{what}");
                assert!((h.point + h.normal * h.distance - p).length() < e, "{what}");
                assert!(inside(&shape, h.point, e), "{what}");
                // Near an edge the direction p − q has lost the digits that p and q share.
                let turn = 5e-7 * scale / (h.distance.abs() + 1e-6 * scale);
                assert!((support(&shape, h.normal) - h.point).dot(h.normal) < e + turn * scale, "{what}");
                assert_eq!(h.distance <= 0.0, shape.contains_point(p));
                assert!(inside(&shape, p, e) == (h.distance <= e) || h.distance.abs() < 2.0 * e, "{what}");
                for _ in 0..50 {
                    let d = r.direction();
                    let out = (p - support(&shape, d)).dot(d);
                    assert!(out <= h.distance + e, "{what} {d:?}");
                }
            }
        }
    }
}

/// Samples before the hit are outside, the hit is on the surface with the normal of the nearest point, and a ray
/// without a hit has no sample inside.
#[test]
fn rays_agree_with_samples_of_the_solid() {
    let mut r = Rng(41);
    let mut hits = [0; 6];
    for round in 0..600 {
        let scale = [1e-3, 1.0, 1e3][round % 3];
        let e = 2e-5 * scale;
        for (kind, shape) in solids(&mut r, scale).into_iter().enumerate() {
            let o = r.vec(scale * 3.0);
            let mut target = r.vec(scale);
            // Axial, level and grazing rays too.
            match round % 8 {
                0 => target = Vec3::new(o.x, target.y, o.z),
                1 => target.y = o.y,
                2 => target = support(&shape, r.direction()),
                _ => {}
            }
            let d = (target - o) * r.range(0.1, 3.0);
            let max_t = 8.0 * scale / d.length();
            let hit = shape.ray_cast(o, d, max_t);
            let what = format!("{o:?} {d:?} {hit:?} {shape:?}");
            let end = hit.map_or(max_t, |h| h.t);
            for k in (0..400).filter(|_| end > 0.0) {
                let p = o + d * (end * (k as f32 / 400.0));
                assert!(!inside(&shape, p, -e), "{what} {p:?}");
            }
            let Some(h) = hit else { continue };
            hits[kind] += 1;
            let p = o + d * h.t;
            if h.t == 0.0 {
                assert!(inside(&shape, o, e), "{what}");
                continue;
            }
            assert!(inside(&shape, p, e) && !inside(&shape, p, -e), "{what}");
            assert!(h.normal.dot(d) <= 0.0 && (h.normal.length() - 1.0).abs() < 1e-5, "{what}");
            assert!((support(&shape, h.normal) - p).dot(h.normal) < e, "{what}");
            assert_eq!(h.sub, NO_SUB);
        }
    }
    assert!(hits.iter().all(|&n| n > 100), "{hits:?}");
}

#[test]
fn rays_at_the_edge_of_sense() {
    let mut r = Rng(43);
    let mut shapes = solids(&mut r, 1.0);
    shapes.push(Shape::HalfSpace { normal: Vec3::Y, offset: -5.0 });
    let field = HeightField::new(3, 3, [1.0; 2], vec![0.0; 9]).unwrap();
    shapes.push(Shape::HeightField(Arc::new(field)));
    shapes
        .push(Shape::Compound(Arc::new(Compound::new(vec![(Pose::IDENTITY, random_hull(&mut r))]).unwrap())));
    let bad = Vec3::new(0.0, f32::NAN, 0.0);
    for s in &shapes {
        let o = Vec3::new(0.01, 9.0, 0.02);
        assert!(s.ray_cast(o, Vec3::ZERO, 1.0).is_none());
        assert!(s.ray_cast(o, bad, 1.0).is_none());
        assert!(s.ray_cast(bad, Vec3::X, 1.0).is_none());
        assert!(s.ray_cast(o, -Vec3::Y, f32::NAN).is_none());
        assert!(s.ray_cast(o, -Vec3::Y, -1.0).is_none());
        assert!(s.ray_cast(o, Vec3::splat(f32::INFINITY), 1.0).is_none());
        assert!(s.closest_point(bad).is_none());
        // Any length of the direction, without end and from far away.
        let one = s.ray_cast(o, -Vec3::Y, 100.0).unwrap();
        for length in [1e-20, 1e-3, 1e3, 1e20] {
            let h = s.ray_cast(o, Vec3::Y * -length, f32::INFINITY).unwrap();
            assert!((h.t * length - one.t).abs() < 1e-5, "{s:?} {length} {h:?}");
        }
        let h = s.ray_cast(o + Vec3::Y * 8192.0, -Vec3::Y, f32::INFINITY).unwrap();
        assert!((h.t - 8192.0 - one.t).abs() < 2e-3);
        assert!(s.ray_cast(o, -Vec3::Y, one.t * 0.99).is_none());
        assert!(s.ray_cast(o, Vec3::Y, 1e6).is_none());
    }
    for s in shapes.iter().filter(|s| s.is_convex()) {
        let h = s.ray_cast(s.mass_properties(1.0).unwrap().center, Vec3::X * 2.0, 1.0).unwrap();
        assert_eq!((h.t, h.normal), (0.0, -Vec3::X));
    }
}

/// Two-row ridges, a hole and flat parts.
fn field(columns: usize, rows: usize, r: &mut Rng) -> HeightField {
    let heights = (0..columns * rows)
        .map(|_| match r.next() % 20 {
            0 => f32::NAN,
            1..4 => 0.0,
            _ => r.range(-1.0, 1.0),
        })
        .collect();
    HeightField::new(columns, rows, [0.5, 0.75], heights).unwrap()
}

#[test]
fn height_field_is_the_mesh_of_its_triangles() {
    let mut r = Rng(51);
    for (columns, rows) in [(2, 2), (3, 40), (23, 17)] {
        let f = field(columns, rows, &mut r);
        let mut vertices = Vec::new();
        let mut index = Vec::new();
        for i in 0..f.triangle_count() {
            if let Some(t) = f.triangle(i) {
                vertices.extend(t);
                index.push(i);
                assert!((t[1] - t[0]).cross(t[2] - t[0]).y > 0.0);
            }
        }
        let triangles: Vec<[u32; 3]> =
            (0..index.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let mesh = TriMesh::new(&vertices, &triangles, TriMeshOptions::default()).unwrap();
        let (mesh, bounds) = (Shape::Mesh(Arc::new(mesh)), f.aabb());
        let mut found = Vec::new();
        let q = jounce_geometry::Aabb::from_center(Vec3::ZERO, Vec3::new(1.0, 0.1, 1.0));
        f.overlapping(&q, |i| found.push(i));
        for &i in &index {
            let b = jounce_geometry::Aabb::from_points(f.triangle(i).unwrap());
            assert!(!b.overlaps(&q) || found.contains(&i));
        }
        let f = Shape::HeightField(Arc::new(f));
        let half = bounds.max + Vec3::ONE;
        for k in 0..3000 {
            let o = r.vec(1.0).mul(half);
            let d = match k % 6 {
                0 => -Vec3::Y,
                1 => Vec3::X * r.range(-1.0, 1.0),
                2 => Vec3::new(0.0, r.range(-0.1, 0.1), 1.0),
                _ => r.direction(),
            };
            let (a, b) = (f.ray_cast(o, d, 30.0), mesh.ray_cast(o, d, 30.0));
            assert_eq!(
                a.map(|h| (h.t, index.iter().position(|&i| i == h.sub))),
                b.map(|h| (h.t, Some(h.sub as usize))),
                "{o:?} {d:?}"
            );
            let (a, b) = (f.closest_point(o).unwrap(), mesh.closest_point(o).unwrap());
            assert_eq!(a.distance, b.distance);
        }
    }
}

#[test]
fn bad_numbers_are_named() {
    let refused = |s: Shape, name: &str| match s.check() {
        Err(GeometryError::BadNumber { field, .. }) => assert_eq!(field, name),
        other => panic!("{s:?}: {other:?}"),
    };
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-7, 1e7] {
        refused(Shape::Sphere { radius: bad }, "radius");
        refused(Shape::Capsule { half_height: 1.0, radius: bad }, "radius");
        refused(Shape::Cylinder { half_height: bad, radius: 1.0 }, "half_height");
        refused(Shape::Cone { half_height: bad, radius: 1.0 }, "half_height");
        refused(Shape::Box { half: Vec3::new(1.0, bad, 1.0) }, "half.y");
    }
    refused(Shape::HalfSpace { normal: Vec3::new(0.0, 1.01, 0.0), offset: 0.0 }, "length of normal");
    refused(Shape::HalfSpace { normal: Vec3::Y, offset: f32::NAN }, "offset");
    assert!(Shape::Sphere { radius: 1e-6 }.check().is_ok());

    let sphere = || (Pose::IDENTITY, Shape::Sphere { radius: 1.0 });
    let nested = Shape::Compound(Arc::new(Compound::new(vec![sphere()]).unwrap()));
    assert!(matches!(Compound::new(vec![(Pose::IDENTITY, nested)]), Err(GeometryError::Unsupported { .. })));
    assert!(Compound::new(vec![]).is_err());
    let plane = Shape::HalfSpace { normal: Vec3::Y, offset: 0.0 };
    assert!(Compound::new(vec![sphere(), (Pose::IDENTITY, plane)]).is_err());
    assert!(Compound::new(vec![(Pose::IDENTITY, Shape::Sphere { radius: -1.0 })]).is_err());
    let lost = Pose::from_translation(Vec3::splat(f32::NAN));
    assert!(Compound::new(vec![(lost, Shape::Sphere { radius: 1.0 })]).is_err());

    let f = |c, r, s, h: Vec<f32>| HeightField::new(c, r, [s; 2], h).map(|_| ());
    assert!(f(2, 2, 1.0, vec![0.0; 4]).is_ok());
    assert!(f(1, 4, 1.0, vec![0.0; 4]).is_err());
    assert!(f(2, 2, 1.0, vec![0.0; 5]).is_err());
    assert!(f(2, 2, 0.0, vec![0.0; 4]).is_err());
    assert!(f(2, 2, 1.0, vec![f32::NAN; 4]).is_err());
    assert!(matches!(
        f(2, 2, 1.0, vec![0.0, f32::INFINITY, 0.0, 0.0]),
        Err(GeometryError::NotFinite { index: 1, .. })
    ));
}
