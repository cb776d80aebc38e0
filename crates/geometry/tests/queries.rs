//! Distances, casts and times of impact against closed forms, direction sweeps and sampled motion.

mod common;
use common::{Rng, gap};
use jounce_geometry::{
    HeightField, Shape, Sweep, TimeOfImpact, cast_shape, distance, overlap, time_of_impact,
};
use jounce_math::{Pose, Quat, Vec3, scalar::f32s};
use std::sync::Arc;

fn cases() -> usize {
    if std::env::var_os("JOUNCE_PROVE").is_some() { 5_000 } else { 200 }
}

fn convex(rng: &mut Rng, kind: usize) -> Shape {
    let mut r = || rng.range(0.1, 1.0);
    match kind {
        0 => Shape::Sphere { radius: r() },
        1 => Shape::Capsule { half_height: r(), radius: r() },
        2 => Shape::Box { half: Vec3::new(r(), r(), r()) },
        3 => Shape::Cylinder { half_height: r(), radius: r() },
        _ => Shape::Cone { half_height: r(), radius: r() },
    }
}

fn hills(rng: &mut Rng) -> Shape {
    let heights = (0..81).map(|_| rng.range(-0.3, 0.3)).collect();
    Shape::HeightField(Arc::new(HeightField::new(9, 9, [0.7, 0.6], heights).unwrap()))
}

#[test]
fn distance_of_balls_and_boxes_is_exact() {
    let mut rng = Rng(0xD157);
    for _ in 0..cases() * 10 {
        let (a, b) = (rng.range(0.1, 2.0), rng.range(0.1, 2.0));
        let p = rng.vec(5.0);
        let pose = Pose::new(p, rng.rotation());
        let d =
            distance(&Shape::Sphere { radius: a }, &Shape::Sphere { radius: b }, &pose, f32::MAX).unwrap();
        assert!((d.distance - f32s::max(p.length() - a - b, 0.0)).abs() < 1e-5);
        let half = Vec3::new(0.5, 1.0, 1.5);
        let want = f32s::max((p - p.clamp(-half, half)).length() - b, 0.0);
        let s = (Shape::Box { half }, Shape::Sphere { radius: b });
        let d = distance(&s.0, &s.1, &pose, f32::MAX).unwrap();
        assert!((d.distance - want).abs() < 1e-5, "{d:?} {want}");
        let w = distance(&s.1, &s.0, &pose.inverse(), f32::MAX).unwrap();
        assert!((w.distance - want).abs() < 1e-5, "{w:?} {want}");
        assert!(distance(&s.0, &s.1, &pose, want * 0.99).is_none() || want == 0.0);
    }
}

#[test]
fn distance_is_the_largest_gap_of_any_direction() {
    let mut rng = Rng(0x6A9);
    for i in 0..5 {
        for j in 0..5 {
            for k in 0..cases() / 4 {
                let (a, b) = (convex(&mut rng, i), convex(&mut rng, j));
                let pose = Pose::new(rng.direction() * rng.range(1.0, 5.0), rng.rotation());
                let d = distance(&a, &b, &pose, f32::MAX).unwrap();
                let what = format!("#{k} {a:?} {b:?} {pose:?} {d:?}");
                let g = gap(&a, &b, &pose, 500, &[d.normal]);
                assert!((d.distance - f32s::max(g, 0.0)).abs() < 1e-4, "{g} {what}");
                assert_eq!(overlap(&a, &b, &pose), d.distance == 0.0, "{what}");
                if d.distance > 0.0 {
                    assert!(((d.point_b - d.point_a).length() - d.distance).abs() < 1e-4, "{what}");
                }
            }
        }
    }
}

/// What the search finds is the nearest of all triangles.
#[test]
fn surface_distance_does_not_depend_on_the_search() {
    let mut rng = Rng(0x5EA);
    for kind in 0..5 {
        for k in 0..cases() / 10 {
            let (ground, body) = (hills(&mut rng), convex(&mut rng, kind));
            let pose = Pose::new(rng.vec(6.0), rng.rotation());
            let d = distance(&ground, &body, &pose, f32::MAX).unwrap();
            let Shape::HeightField(h) = &ground else { unreachable!() };
            let brute = (0..h.triangle_count())
                .filter_map(|i| h.triangle(i))
                .map(|t| triangle_gap(&t, &body, &pose))
                .fold(f32::MAX, f32s::min);
            assert!(
                (d.distance - f32s::max(brute, 0.0)).abs() < 2e-3,
                "#{k} {brute} {d:?} {body:?} {pose:?}"
            );
        }
    }
}

/// Largest gap between a triangle and a body over directions, by climbing.
fn triangle_gap(t: &[Vec3; 3], b: &Shape, pose: &Pose) -> f32 {
    let point = |n: Vec3| {
        let far = t.iter().map(|v| v.dot(n)).fold(f32::MIN, f32s::max);
        let q = pose.transform_point(common::support(b, pose.q.inverse_rotate(-n)));
        q.dot(n) - far
    };
    let mut n = (pose.p - t[0]).normalize_or(Vec3::Y);
    let mut g = point(n);
    let mut step = 0.5;
    while step > 1e-4 {
        let (u, v) = n.orthonormal_basis();
        let mut better = false;
        // Many directions: the gap has ridges, and along a ridge few of them go up.
        for k in 0..64 {
            let angle = std::f32::consts::TAU / 64.0 * k as f32;
            let (s, c) = (f32s::sin(angle), f32s::cos(angle));
            let m = (n + (u * c + v * s) * step).normalize_or(n);
            if point(m) > g {
                (g, n, better) = (point(m), m, true);
            }
        }
        if !better {
            step *= 0.5;
        }
    }
    g
}

fn check_cast(a: &Shape, b: &Shape, pose: &Pose, motion: Vec3, what: &str) {
    let at = |t: f32| Pose::new(pose.p + motion * t, pose.q);
    let gap_at = |t: f32| distance(a, b, &at(t), f32::MAX).unwrap().distance;
    let hit = cast_shape(a, b, pose, motion);
    let first = (0..=400).map(|k| k as f32 / 400.0).find(|&t| gap_at(t) == 0.0);
    match hit {
        None => assert!(first.is_none(), "missed at {first:?}: {what}"),
        Some(h) => {
            assert!((0.0..=1.0).contains(&h.t) && h.point.is_finite(), "{h:?} {what}");
            assert!((h.normal.length() - 1.0).abs() < 1e-4, "{h:?} {what}");
            assert!(gap_at(h.t) < 1e-4, "gap {} at {h:?}: {what}", gap_at(h.t));
            assert!(first.is_none_or(|t| t >= h.t - 1e-5), "late: {first:?} {h:?} {what}");
            assert!(h.t == 0.0 || motion.dot(h.normal) <= 1e-4, "{h:?} {what}");
        }
    }
}

#[test]
fn casts_stop_at_the_first_contact() {
    let mut rng = Rng(0xCA57);
    for i in 0..5 {
        for j in 0..5 {
            for k in 0..cases() / 10 {
                let (a, b) = (convex(&mut rng, i), convex(&mut rng, j));
                let pose = Pose::new(rng.direction() * rng.range(1.0, 5.0), rng.rotation());
                let motion = -pose.p * rng.range(0.5, 2.0) + rng.vec(1.5);
                check_cast(&a, &b, &pose, motion, &format!("#{k} {a:?} {b:?} {pose:?} {motion:?}"));
            }
        }
    }
}

#[test]
fn casts_on_surfaces_stop_at_the_first_contact() {
    let mut rng = Rng(0xCA58);
    for kind in 0..5 {
        for k in 0..cases() / 10 {
            let (ground, body) = (hills(&mut rng), convex(&mut rng, kind));
            let pose = Pose::new(Vec3::Y * 2.5 + rng.vec(2.0), rng.rotation());
            let motion = Vec3::new(0.0, -4.0, 0.0) + rng.vec(3.0);
            check_cast(&ground, &body, &pose, motion, &format!("#{k} {body:?} {pose:?} {motion:?}"));
            let plane = Shape::HalfSpace { normal: Vec3::Y, offset: 0.1 };
            check_cast(&plane, &body, &pose, motion, &format!("plane #{k} {body:?} {pose:?} {motion:?}"));
            let inverse = pose.inverse();
            let back = -pose.q.inverse_rotate(motion);
            let (h, w) =
                (cast_shape(&ground, &body, &pose, motion), cast_shape(&body, &ground, &inverse, back));
            assert_eq!(h.is_some(), w.is_some());
            if let (Some(h), Some(w)) = (h, w) {
                assert!((h.t - w.t).abs() < 1e-4, "{h:?} {w:?}");
            }
        }
    }
}

const TARGET: f32 = 0.004;
const TOLERANCE: f32 = 0.001;

fn check_impact(a: &Shape, b: &Shape, sweep: &Sweep, what: &str) {
    let gap_at = |t: f32| distance(a, b, &sweep.pose(t), f32::MAX).unwrap().distance;
    let until = match time_of_impact(a, b, sweep, TARGET, TOLERANCE) {
        TimeOfImpact::Overlapped => {
            assert!(gap_at(0.0) <= TARGET + 1.01 * TOLERANCE, "{} {what}", gap_at(0.0));
            return;
        }
        TimeOfImpact::Hit(t) => {
            let g = gap_at(t);
            assert!(g > TARGET - TOLERANCE && g < TARGET + 2.0 * TOLERANCE, "{g} at {t}: {what}");
            t
        }
        TimeOfImpact::Separated => 1.0,
        TimeOfImpact::Failed(t) => panic!("failed at {t}: {what}"),
    };
    for k in 0..200 {
        let g = gap_at(until * k as f32 / 200.0);
        assert!(g > TARGET - TOLERANCE, "{g} at {k} before {until}: {what}");
    }
}

fn random_sweep(rng: &mut Rng, start: Vec3, turn: f32) -> Sweep {
    let q = rng.rotation();
    let d = Quat::from_axis_angle(rng.direction(), rng.range(0.0, turn));
    let motion = -start * rng.range(0.5, 2.0) + rng.vec(1.5);
    Sweep { local_center: rng.vec(0.1), center: [start, start + motion], rotation: [q, d * q] }
}

#[test]
fn impacts_come_before_contact_and_not_early() {
    let mut rng = Rng(0x701);
    for i in 0..5 {
        for j in 0..5 {
            for k in 0..cases() / 10 {
                let (a, b) = (convex(&mut rng, i), convex(&mut rng, j));
                let start = rng.direction() * rng.range(2.0, 5.0);
                let sweep = random_sweep(&mut rng, start, 1.5);
                check_impact(&a, &b, &sweep, &format!("#{k} {a:?} {b:?} {sweep:?}"));
            }
        }
    }
}

/// The end of a long body: it turns about a centre of mass metres away.
#[test]
fn impacts_of_parts_far_from_the_centre_come_before_contact() {
    let mut rng = Rng(0x7EE);
    for kind in 0..5 {
        for k in 0..cases() / 10 {
            let (ground, body) = (hills(&mut rng), convex(&mut rng, kind));
            let q = rng.rotation();
            let d = Quat::from_axis_angle(rng.direction(), rng.range(0.0, 0.8));
            let local_center = rng.direction() * rng.range(1.0, 4.0);
            // Where the part is at first, and from there its centre of mass.
            let part = Vec3::new(rng.range(-1.0, 1.0), rng.range(1.5, 2.5), rng.range(-1.0, 1.0));
            let start = part + q.rotate(local_center);
            let motion = Vec3::new(rng.range(-1.0, 1.0), rng.range(-3.0, 0.0), rng.range(-1.0, 1.0));
            let sweep = Sweep { local_center, center: [start, start + motion], rotation: [q, d * q] };
            check_impact(&ground, &body, &sweep, &format!("#{k} {body:?} {sweep:?}"));
        }
    }
}

/// A ball at 250 m/s, one step of 1/60 s, against a wall 0.1 m thick.
#[test]
fn fast_ball_meets_thin_wall() {
    let mut rng = Rng(0x250);
    let wall = Shape::Box { half: Vec3::new(0.05, 3.0, 3.0) };
    let sheet = Shape::HeightField(Arc::new(HeightField::new(9, 9, [0.75; 2], vec![0.0; 81]).unwrap()));
    let half_space = Shape::HalfSpace { normal: Vec3::X, offset: 0.05 };
    let ball = Shape::Sphere { radius: 0.05 };
    for _ in 0..cases() {
        let at = Vec3::new(rng.range(0.2, 3.0), rng.range(-2.0, 2.0), rng.range(-2.0, 2.0));
        let motion = Vec3::new(-250.0 / 60.0, rng.range(-0.5, 0.5), rng.range(-0.5, 0.5));
        let q = [rng.rotation(), rng.rotation()];
        let sweep = Sweep { local_center: Vec3::ZERO, center: [at, at + motion], rotation: q };
        let want = (at.x - 0.1 - TARGET) / -motion.x;
        for a in [&wall, &half_space] {
            let TimeOfImpact::Hit(t) = time_of_impact(a, &ball, &sweep, TARGET, TOLERANCE) else {
                panic!("missed {sweep:?}");
            };
            assert!((t - want).abs() < 1e-3, "{t} {want}");
        }
        let turned = |v: Vec3| Vec3::new(v.y, v.x - 0.05, -v.z);
        let sweep = Sweep { center: sweep.center.map(turned), ..sweep };
        let TimeOfImpact::Hit(t) = time_of_impact(&sheet, &ball, &sweep, TARGET, TOLERANCE) else {
            panic!("missed {sweep:?}");
        };
        assert!((t - want).abs() < 1e-3, "{t} {want}");
    }
}

/// A thin coin that tumbles and falls on a grid.
#[test]
fn coin_meets_grid() {
    let mut rng = Rng(0xC01);
    let coin = Shape::Cylinder { half_height: 0.01, radius: 0.2 };
    for k in 0..cases() {
        let ground = hills(&mut rng);
        let start = Vec3::new(rng.range(-1.0, 1.0), rng.range(0.6, 2.0), rng.range(-1.0, 1.0));
        let q = rng.rotation();
        let d = Quat::from_axis_angle(rng.direction(), rng.range(0.0, 2.0));
        let motion = Vec3::new(rng.range(-1.0, 1.0), -4.0, rng.range(-1.0, 1.0));
        let sweep = Sweep { local_center: Vec3::ZERO, center: [start, start + motion], rotation: [q, d * q] };
        assert!(
            matches!(time_of_impact(&ground, &coin, &sweep, TARGET, TOLERANCE), TimeOfImpact::Hit(_)),
            "{sweep:?}"
        );
        check_impact(&ground, &coin, &sweep, &format!("#{k} {sweep:?}"));
    }
}
