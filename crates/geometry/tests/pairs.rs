//! Contact manifolds of convex pairs against a direction sweep, their own mirror image, and closed forms.

mod common;
use common::{Rng, gap};
use jounce_geometry::{Hull, Manifold, ManifoldSet, PairCache, Shape, TriMesh, TriMeshOptions, collide};
use jounce_math::{Mat3, Pose, Quat, Vec3, scalar::f32s};
use std::sync::Arc;

const MARGIN: f32 = 0.02;

fn shapes(rng: &mut Rng) -> Vec<Shape> {
    let r = |rng: &mut Rng| rng.range(0.1, 1.0);
    vec![
        Shape::Sphere { radius: r(rng) },
        Shape::Capsule { half_height: r(rng), radius: r(rng) },
        Shape::Box { half: Vec3::new(r(rng), r(rng), r(rng)) },
        Shape::Cylinder { half_height: r(rng), radius: r(rng) },
        Shape::Cone { half_height: r(rng), radius: r(rng) },
        hull(rng),
    ]
}

/// Hull of a few points, some of them coplanar.
fn hull(rng: &mut Rng) -> Shape {
    let flat = rng.range(0.1, 0.5);
    loop {
        let points: Vec<Vec3> = (0..6 + rng.next() as usize % 14)
            .map(|_| {
                let p = rng.direction() * rng.range(0.3, 1.0);
                Vec3::new(p.x, f32s::clamp(p.y, -flat, flat), p.z)
            })
            .collect();
        if let Ok(h) = Hull::new(&points)
            && h.inner_radius() > 0.05
        {
            return Shape::Hull(Arc::new(h));
        }
    }
}

fn manifolds(a: &Shape, b: &Shape, pose: &Pose) -> Vec<Manifold> {
    let mut out = ManifoldSet::new();
    collide(a, b, pose, MARGIN, &mut PairCache::default(), &mut out);
    out.manifolds
}

fn deepest(m: &[Manifold]) -> Option<f32> {
    m.iter().flat_map(|m| m.points().iter().map(|p| p.separation)).min_by(f32::total_cmp)
}

fn poses_per_pair() -> usize {
    if std::env::var_os("JOUNCE_PROVE").is_some() { 100_000 } else { 100_000 / 36 }
}

fn sweeps_per_pair() -> usize {
    if std::env::var_os("JOUNCE_PROVE").is_some() { 2_000 } else { 100 }
}

/// A pose that overlaps or nearly touches, with B's centre on a random side.
fn near_pose(rng: &mut Rng, a: &Shape, b: &Shape) -> Pose {
    let q = rng.rotation();
    let n = rng.direction();
    let reach = common::support(a, n).dot(n) - q.rotate(common::support(b, q.inverse_rotate(-n))).dot(n);
    Pose::new(n * (reach * rng.range(0.3, 1.05)), q)
}

fn check_wellformed(m: &[Manifold], what: &str) {
    for m in m {
        assert!((m.normal.length() - 1.0).abs() < 1e-4, "{what}: normal {:?}", m.normal);
        assert!(m.count >= 1, "{what}: empty manifold");
        for (i, p) in m.points().iter().enumerate() {
            assert!(p.point.is_finite() && p.separation.is_finite(), "{what}: {p:?}");
            assert!(p.separation <= MARGIN, "{what}: {p:?}");
            assert!(m.points()[..i].iter().all(|q| q.feature != p.feature), "{what}: {m:?}");
        }
    }
}

#[test]
fn depth_agrees_with_a_direction_sweep() {
    let mut rng = Rng(0x51CE);
    let kinds = shapes(&mut rng).len();
    for i in 0..kinds {
        for j in 0..kinds {
            for k in 0..poses_per_pair() {
                let (a, b) = (shapes(&mut rng).swap_remove(i), shapes(&mut rng).swap_remove(j));
                let pose = near_pose(&mut rng, &a, &b);
                let what = format!("{} {} #{k} {a:?} {b:?} {pose:?}", a.name(), b.name());
                let m = manifolds(&a, &b, &pose);
                check_wellformed(&m, &what);
                let guesses: Vec<Vec3> = m.iter().map(|m| m.normal).collect();
                // The sweep is slow: some of the poses only.
                if k % (poses_per_pair() / sweeps_per_pair()) != 0 {
                    continue;
                }
                let g = gap(&a, &b, &pose, 1500, &guesses);
                match deepest(&m) {
                    // Apart, a point nearer than the shapes is a wrong one, whatever the face's tolerance.
                    Some(s) if g > 0.0 => {
                        assert!(s > g - 1e-4 && s < g + 1e-3, "{s} against {g}: {what}");
                    }
                    Some(s) => assert!((s - g).abs() < 1e-3, "{s} against {g}: {what}"),
                    None => assert!(g > MARGIN - 1e-4, "nothing at gap {g}: {what}"),
                }
            }
        }
    }
}

#[test]
fn swapping_the_shapes_mirrors_the_contact() {
    let mut rng = Rng(0xB0B);
    let kinds = shapes(&mut rng).len();
    for i in 0..kinds {
        for j in 0..kinds {
            for k in 0..poses_per_pair() {
                let (a, b) = (shapes(&mut rng).swap_remove(i), shapes(&mut rng).swap_remove(j));
                let pose = near_pose(&mut rng, &a, &b);
                let what = format!("#{k} {a:?} {b:?} {pose:?}");
                let inverse = pose.inverse();
                let m = manifolds(&a, &b, &pose);
                let w = manifolds(&b, &a, &inverse);
                let (s, t) = (deepest(&m), deepest(&w));
                assert!(
                    s.is_some() == t.is_some() || s.or(t).is_some_and(|s| s > MARGIN - 1e-3),
                    "{s:?} {t:?} {what}"
                );
                if let (Some(s), Some(t)) = (s, t) {
                    assert!((s - t).abs() < 1e-3, "{s} {t} {what}");
                }
            }
        }
    }
}

#[test]
fn box_rests_on_box_with_its_corners() {
    let big = Shape::Box { half: Vec3::new(5.0, 0.5, 5.0) };
    let small = Shape::Box { half: Vec3::new(0.5, 0.5, 0.5) };
    for (a, b, pose) in [
        (&big, &small, Pose::from_translation(Vec3::new(0.3, 0.995, -0.2))),
        (&small, &small, Pose::from_translation(Vec3::new(0.0, 0.995, 0.0))),
        (&small, &small, Pose::from_translation(Vec3::new(0.25, 0.995, 0.1))),
        (&small, &small, Pose::new(Vec3::new(0.0, 0.995, 0.0), Quat::from_axis_angle(Vec3::Y, 0.7))),
    ] {
        let m = manifolds(a, b, &pose);
        assert_eq!(m.len(), 1);
        assert_eq!(m[0].count, 4, "{m:?}");
        assert!((m[0].normal - Vec3::Y).length() < 1e-6);
        for p in m[0].points() {
            assert!((p.separation + 0.005).abs() < 1e-5, "{m:?}");
            assert!((p.point.y - 0.4975).abs() < 1e-5 || a.name() == "box", "{m:?}");
        }
    }
}

#[test]
fn half_space_holds_every_low_corner() {
    let plane = Shape::HalfSpace { normal: Vec3::Y, offset: 1.0 };
    let b = Shape::Box { half: Vec3::new(0.5, 0.25, 1.0) };
    let m = manifolds(&plane, &b, &Pose::from_translation(Vec3::new(3.0, 1.24, 0.0)));
    assert_eq!(m[0].count, 4);
    for p in m[0].points() {
        assert!((p.separation + 0.01).abs() < 1e-5 && (p.point.y - 0.995).abs() < 1e-5);
    }
    let c = Shape::Capsule { half_height: 1.0, radius: 0.5 };
    let lying =
        Pose::new(Vec3::new(0.0, 1.5, 0.0), Quat::from_axis_angle(Vec3::Z, std::f32::consts::FRAC_PI_2));
    assert_eq!(manifolds(&plane, &c, &lying)[0].count, 2);
    let m = manifolds(&c, &plane, &lying.inverse());
    assert_eq!(m[0].count, 2);
    assert!(lying.q.rotate(m[0].normal).y < -0.999);
}

#[test]
fn features_stay_under_small_motion() {
    let mut rng = Rng(7);
    let b = Shape::Box { half: Vec3::splat(0.5) };
    let mut cache = PairCache::default();
    let mut out = ManifoldSet::new();
    let mut first = None;
    for k in 0..200 {
        let wobble = rng.vec(2e-5);
        let q = Quat::IDENTITY.integrate(rng.vec(2e-5));
        let pose = Pose::new(Vec3::new(0.1, 0.998, 0.2) + wobble, q);
        collide(&b, &b, &pose, MARGIN, &mut cache, &mut out);
        let ids: Vec<u32> = out.manifolds[0].points().iter().map(|p| p.feature).collect();
        assert_eq!(&ids, first.get_or_insert(ids.clone()), "step {k}");
    }
}

/// A crate whose face lies across an edge that is longer than it is touches along the edge, however it leans: with one point, at the deeper end, it would
/// rock from end to end for ever.
#[test]
fn a_face_across_a_long_edge_has_two_points() {
    let block = |h: Vec3| {
        let corner = |k: i32| {
            let sign = |bit: i32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
            Vec3::new(h.x * sign(0), h.y * sign(1), h.z * sign(2))
        };
        Shape::Hull(Arc::new(Hull::new(&(0..8).map(corner).collect::<Vec<_>>()).expect("a hull")))
    };
    let (long, small) = (Vec3::new(0.5, 0.5, 10.0), Vec3::new(0.2, 0.25, 0.2));
    let roof = {
        let points = [
            [-0.5, 0.5, -9.0],
            [-0.5, 0.5, 11.0],
            [0.5, 0.5, 11.0],
            [0.5, 0.5, -9.0],
            [0.5, -0.5, -9.0],
            [0.5, -0.5, 11.0],
        ];
        let triangles = [[0, 1, 2], [0, 2, 3], [3, 2, 5], [3, 5, 4]];
        let points = points.map(Vec3::from);
        Shape::Mesh(Arc::new(TriMesh::new(&points, &triangles, TriMeshOptions::default()).expect("a roof")))
    };
    let walls = [Shape::Box { half: long }, block(long), roof];
    let crates = [Shape::Box { half: small }, block(small)];
    let (along, across) =
        (Vec3::new(1.0, 1.0, 0.0).normalize_or(Vec3::X), Vec3::new(1.0, -1.0, 0.0).normalize_or(Vec3::X));
    for (wall, b) in walls.iter().flat_map(|w| crates.iter().map(move |c| (w, c))) {
        for k in -12..=12 {
            let lean = 0.003 * k as f32;
            let flat = Quat::from_axis_angle(Vec3::Z, core::f32::consts::FRAC_PI_4);
            let q = Quat::from_axis_angle(across, lean) * flat;
            let p = Vec3::new(0.5, 0.5, 0.0) + q.rotate(Vec3::X) * (small.x - 0.002);
            let mut found = ManifoldSet::new();
            collide(wall, b, &Pose::new(p, q), MARGIN, &mut PairCache::default(), &mut found);
            let what = format!("{wall:?}, {b:?}, {lean}");
            let [m] = &found.manifolds[..] else { panic!("{what}: {:?}", found.manifolds) };
            assert_eq!(m.count, 2, "{what}: {m:?}");
            assert!(m.normal.dot(along) > 0.999, "{what}: {m:?}");
            let mut ends = [m.points[0], m.points[1]];
            ends.sort_by(|x, y| x.point.z.total_cmp(&y.point.z));
            // What the face leans over there, of the edge that it is 2 mm deep on in the middle.
            let over = f32s::sin(lean) * small.z;
            for (end, (z, s)) in ends.iter().zip([(-small.z, over), (small.z, -over)]) {
                assert!((end.point.z - z).abs() < 0.01, "{what}: {m:?}");
                assert!((end.separation - (s - 0.002)).abs() < 5e-4, "{what}: {m:?}, {s}");
            }
        }
    }
}

/// Edges that cross, with no face along the direction in which they touch, keep that direction, however thin the boxes are and however far they look.
#[test]
fn crossing_edges_keep_their_normal() {
    let mut rng = Rng(17);
    let halves = [Vec3::splat(0.25), Vec3::splat(0.05), Vec3::new(0.02, 0.02, 1.0)];
    let mut kept = 0;
    for (ha, hb) in halves.iter().flat_map(|a| halves.iter().map(move |b| (*a, *b))) {
        for margin in [0.02, 0.2] {
            for _ in 0..40 {
                // A's edge is along z; its faces, and B's, are 11° off or more.
                let [f, g] = [rng.range(0.2, 1.37), rng.range(0.2, 1.37)];
                let n = Vec3::new(f32s::cos(f), f32s::sin(f), 0.0);
                let turn = rng.range(0.5, 2.6);
                let edge = Vec3::Z * f32s::cos(turn) + n.cross(Vec3::Z) * f32s::sin(turn);
                let local = -Vec3::new(f32s::cos(g), f32s::sin(g), 0.0);
                let world = Mat3::from_columns(-n, edge, edge.cross(n));
                let own = Mat3::from_columns(local, Vec3::Z, local.cross(Vec3::Z));
                let q = Quat::from_mat3(&(world * own.transpose())).normalize();
                let depth = rng.range(1e-4, 1e-3);
                let p = Vec3::new(ha.x, ha.y, 0.0) - n * depth + q.rotate(Vec3::new(hb.x, hb.y, 0.0));
                let (a, b) = (Shape::Box { half: ha }, Shape::Box { half: hb });
                let mut found = ManifoldSet::new();
                collide(&a, &b, &Pose::new(p, q), margin, &mut PairCache::default(), &mut found);
                let [m] = &found.manifolds[..] else { panic!("{:?}", found.manifolds) };
                // Some other axis may part thin boxes sooner than this one.
                if (m.points[0].separation + depth).abs() < 1e-5 {
                    assert!(
                        m.count == 1 && m.normal.dot(n) > 0.9999,
                        "{n:?}: {m:?}, {ha:?}, {hb:?}, {margin}"
                    );
                    kept += 1;
                }
            }
        }
    }
    assert!(kept > 500, "{kept} of 720");
}
