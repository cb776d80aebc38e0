//! Queries against the same question asked of every shape, one by one.

mod support;

use jounce::geometry::{self, Shape};
use jounce::math::scalar::f32s;
use jounce::prelude::*;
use jounce::{ClosestPoint, RayCastHit, ShapeCastHit, ShapeRef};
use support::*;

const CENTERS: [DVec3; 3] = [DVec3::ZERO, DVec3::new(1e4, -3e3, 2e4), DVec3::new(-1e6, 1e6, 1e6)];

/// What the filter says, in the words of its documentation.
fn visible<'a>(w: &'a World, f: &QueryFilter<'a>) -> impl Iterator<Item = ShapeRef<'a>> {
    w.shapes().map(|s| w.shape(s).expect("alive")).filter(move |s| {
        let body = w.body(s.body()).expect("alive");
        let kind = match body.kind() {
            BodyKind::Fixed => f.fixed,
            BodyKind::Kinematic => f.kinematic,
            BodyKind::Dynamic => f.dynamic,
        };
        kind && (f.sensors || !s.is_sensor())
            && s.filter().layers & f.layers != 0
            && f.exclude != Some(s.body())
            && f.predicate.is_none_or(|p| p(s.id()))
    })
}

fn random_filter(r: &mut Random, w: &World) -> QueryFilter<'static> {
    let mut f = QueryFilter::default();
    match r.below(5) {
        0 => f.layers = 1 << r.below(4),
        1 => f.exclude = w.bodies().nth(r.below(20)),
        2 => f.sensors = true,
        3 => (f.fixed, f.kinematic, f.dynamic) = (r.below(2) == 0, r.below(2) == 0, true),
        _ => {}
    }
    f
}

fn all_rays(w: &World, ray: &Ray, f: &QueryFilter<'_>) -> Vec<RayCastHit> {
    let mut hits: Vec<RayCastHit> = visible(w, f)
        .filter_map(|s| {
            let pose = s.world_pose();
            let dir = pose.q.inverse_rotate(ray.dir);
            let h = s.shape().ray_cast(pose.inverse_transform_point(ray.origin), dir, ray.max_t)?;
            Some(RayCastHit {
                shape: s.id(),
                body: s.body(),
                t: h.t,
                point: ray.origin + ray.dir.as_dvec3() * f64::from(h.t),
                normal: pose.q.rotate(h.normal),
                triangle: (h.sub != geometry::NO_SUB).then_some(h.sub),
            })
        })
        .collect();
    hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.shape.index().cmp(&b.shape.index())));
    hits
}

#[test]
fn rays_agree_with_every_shape_asked_alone() {
    let mut hits = 0;
    for (seed, center) in CENTERS.into_iter().enumerate() {
        let w = random_world(seed as u64, 120, center, 8.0);
        let mut r = Random::new(77);
        for _ in 0..600 {
            let f = random_filter(&mut r, &w);
            let mut ray = Ray::new(center + r.vec(12.0).as_dvec3(), r.dir() * r.range(0.2, 3.0));
            if r.below(3) == 0 {
                ray.max_t = r.range(0.0, 10.0);
            }
            if r.below(8) == 0 {
                ray.dir = [Vec3::X, -Vec3::Y, Vec3::Z][r.below(3)];
            }
            let brute = all_rays(&w, &ray, &f);
            assert_eq!(w.cast_ray_all(&ray, &f), brute, "{ray:?}");
            assert_eq!(w.cast_ray(&ray, &f), brute.first().copied(), "{ray:?}");
            assert_eq!(w.ray_blocked(&ray, &f), !brute.is_empty());
            hits += brute.len();
        }
    }
    assert!(hits > 1000, "only {hits} hits: the test sees too little");
}

#[test]
fn batches_give_what_single_queries_give_on_any_threads() {
    let mut w = random_world(5, 100, DVec3::ZERO, 8.0);
    let mut r = Random::new(6);
    let rays: Vec<Ray> = (0..500).map(|_| Ray::new(r.vec(12.0).as_dvec3(), r.dir())).collect();
    let points: Vec<DVec3> = rays.iter().map(|ray| ray.origin).collect();
    let f = QueryFilter::default();
    let single: Vec<_> = rays.iter().map(|ray| w.cast_ray(ray, &f)).collect();
    let near: Vec<_> = points.iter().map(|&p| w.closest_point(p, 2.0, &f)).collect();
    for tasks in [Tasks::serial(), Tasks::pool(3), Tasks::chaos(4)] {
        w.set_tasks(tasks);
        assert_eq!(w.cast_rays(&rays, &f), single);
        let blocked: Vec<bool> = single.iter().map(Option::is_some).collect();
        assert_eq!(w.rays_blocked(&rays, &f), blocked);
        assert_eq!(w.closest_points(&points, 2.0, &f), near);
    }
    assert!(w.cast_rays(&[], &f).is_empty());
}

#[test]
fn shape_casts_agree_with_every_shape_asked_alone() {
    let mut hits = 0;
    for (seed, center) in CENTERS.into_iter().enumerate() {
        let w = random_world(10 + seed as u64, 80, center, 7.0);
        let mut r = Random::new(88);
        for _ in 0..150 {
            let f = random_filter(&mut r, &w);
            let shape = solid(&mut r);
            let from = WorldPose::new(center + r.vec(9.0).as_dvec3(), r.turn());
            let motion = r.dir() * r.range(0.0, 12.0);
            let unit = WorldPose::new(from.p, from.q.normalize());
            let mut brute: Vec<ShapeCastHit> = visible(&w, &f)
                .filter_map(|s| {
                    let pose = s.world_pose();
                    let b = pose.relative(&unit);
                    let h = geometry::cast_shape(s.shape(), &shape, &b, pose.q.inverse_rotate(motion))?;
                    Some(ShapeCastHit {
                        shape: s.id(),
                        body: s.body(),
                        t: h.t,
                        point: pose.transform_point(h.point),
                        normal: pose.q.rotate(h.normal),
                        triangle: (h.sub_a != geometry::NO_SUB).then_some(h.sub_a),
                    })
                })
                .collect();
            brute.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.shape.index().cmp(&b.shape.index())));
            assert_eq!(w.cast_shape_all(&shape, &from, motion, &f), brute, "{shape:?} {from:?} {motion:?}");
            assert_eq!(w.cast_shape(&shape, &from, motion, &f), brute.first().copied());
            hits += brute.len();
        }
    }
    assert!(hits > 300, "only {hits} hits: the test sees too little");
}

#[test]
fn overlaps_agree_with_every_shape_asked_alone() {
    let mut found = [0; 3];
    for (seed, center) in CENTERS.into_iter().enumerate() {
        let w = random_world(20 + seed as u64, 100, center, 6.0);
        let mut r = Random::new(99);
        for _ in 0..400 {
            let f = random_filter(&mut r, &w);
            let shape = solid(&mut r);
            let at = WorldPose::new(center + r.vec(7.0).as_dvec3(), r.turn());
            let unit = WorldPose::new(at.p, at.q.normalize());
            let brute: Vec<ShapeId> = visible(&w, &f)
                .filter(|s| geometry::overlap(s.shape(), &shape, &s.world_pose().relative(&unit)))
                .map(|s| s.id())
                .collect();
            assert_eq!(w.overlap_shape(&shape, &at, &f), brute);
            found[0] += brute.len();

            let brute: Vec<ShapeId> = visible(&w, &f)
                .filter(|s| s.shape().contains_point(s.world_pose().inverse_transform_point(at.p)))
                .map(|s| s.id())
                .collect();
            assert_eq!(w.overlap_point(at.p, &f), brute);
            found[1] += brute.len();

            let half = DVec3::splat(f64::from(r.range(0.01, 2.0)));
            let (min, max) = (at.p - half, at.p + half);
            let brute: Vec<ShapeId> = visible(&w, &f)
                .filter(|s| {
                    let pose = s.world_pose();
                    if matches!(s.shape(), Shape::HalfSpace { .. }) {
                        return min.y <= pose.p.y;
                    }
                    let b = s.shape().aabb(&Pose::new(Vec3::ZERO, pose.q));
                    let (lo, hi) = (b.min.as_dvec3() + pose.p, b.max.as_dvec3() + pose.p);
                    (0..3).all(|i| lo[i] <= max[i] && min[i] <= hi[i])
                })
                .map(|s| s.id())
                .collect();
            assert_eq!(w.overlap_aabb(min, max, &f), brute);
            found[2] += brute.len();
        }
    }
    assert!(found.iter().all(|&n| n > 100), "{found:?}: the test sees too little");
}

#[test]
fn closest_points_agree_with_every_shape_asked_alone() {
    let mut inside = 0;
    for (seed, center) in CENTERS.into_iter().enumerate() {
        let w = random_world(30 + seed as u64, 60, center, 6.0);
        let mut r = Random::new(111);
        for _ in 0..300 {
            let f = random_filter(&mut r, &w);
            let p = center + r.vec(8.0).as_dvec3();
            let max = if r.below(2) == 0 { f32::MAX } else { r.range(0.0, 2.0) };
            let mut brute: Vec<ClosestPoint> = visible(&w, &f)
                .filter_map(|s| {
                    let pose = s.world_pose();
                    let h = s.shape().closest_point(pose.inverse_transform_point(p))?;
                    Some(ClosestPoint {
                        shape: s.id(),
                        body: s.body(),
                        point: pose.transform_point(h.point),
                        distance: h.distance,
                        normal: pose.q.rotate(h.normal),
                        triangle: (h.sub != geometry::NO_SUB).then_some(h.sub),
                    })
                })
                .filter(|h| h.distance <= max)
                .collect();
            brute.sort_by(|a, b| {
                a.distance.total_cmp(&b.distance).then(a.shape.index().cmp(&b.shape.index()))
            });
            let got = w.closest_point(p, max, &f);
            assert_eq!(got, brute.first().copied(), "{p:?} within {max}");
            inside += usize::from(got.is_some_and(|h| h.distance < 0.0));
        }
    }
    assert!(inside > 20, "only {inside} points inside");
}

#[test]
fn a_ray_at_the_edge_of_the_world_is_as_good_as_one_at_home() {
    let f = QueryFilter::default();
    for center in [DVec3::ZERO, DVec3::new(1e6, 1e6, -1e6), DVec3::new(1e8, 0.0, 0.0)] {
        let mut w = world();
        let ball = BodyDesc::fixed().at(center).shape(ShapeDesc::sphere(0.25));
        w.add_body(ball).expect("a ball");
        let hit = w.cast_ray(&Ray::new(center + DVec3::new(3.0, 0.0, 0.0), -Vec3::X), &f).expect("a hit");
        assert!((hit.t - 2.75).abs() < 1e-6, "{hit:?}");
        assert!(hit.point.distance(center + DVec3::new(0.25, 0.0, 0.0)) < 1e-6);
        assert!(hit.normal.distance(Vec3::X) < 1e-6);
        // Grazing by a millimetre, either way.
        let graze = |y: f64| Ray::new(center + DVec3::new(3.0, y, 0.0), -Vec3::X);
        assert!(w.cast_ray(&graze(0.249), &f).is_some());
        assert!(w.cast_ray(&graze(0.251), &f).is_none());
        let c = w.closest_point(center + DVec3::new(0.0, 2.0, 0.0), 10.0, &f).expect("a point");
        assert!((c.distance - 1.75).abs() < 1e-6 && c.normal.distance(Vec3::Y) < 1e-6);
    }
}

#[test]
fn a_ray_from_a_hundred_kilometres_away_hits_a_ball_where_it_is() {
    let mut w = world();
    let target = DVec3::new(60_000.123, 80_000.456, 0.0);
    w.add_body(BodyDesc::fixed().at(target).shape(ShapeDesc::sphere(0.5))).expect("a ball");
    let f = QueryFilter::default();
    // Along x from 60 km away: everything about the ray is exact in f32, and so is where it hits.
    let hit = w.cast_ray(&Ray::new([0.0, target.y, 0.3], Vec3::X), &f).expect("a hit");
    let depth = f64::from(0.3f32) * f64::from(0.3f32);
    let expected = target.x - (0.25 - depth).sqrt();
    // t itself is an f32: half its ulp at 6e4 is 2 mm.
    assert!((f64::from(hit.t) - expected).abs() < 0.003, "{} {expected}", hit.t);
    assert!((f64::from(hit.normal.z) - 0.6).abs() < 1e-5, "{:?}", hit.normal);
    assert!(w.cast_ray(&Ray::new([0.0, target.y, 0.501], Vec3::X), &f).is_none());
    assert!(w.cast_ray(&Ray::new([0.0, target.y, 0.499], Vec3::X), &f).is_some());
}

#[test]
fn ties_go_to_the_lowest_slot() {
    let mut w = world();
    // Four equal boxes at one place; the slots of the fixed and moving ones are mixed, so both trees hold equals.
    for kind in [BodyKind::Dynamic, BodyKind::Fixed, BodyKind::Kinematic, BodyKind::Fixed] {
        w.add_body(BodyDesc::new(kind).at([5.0, 0.0, 0.0]).shape(ShapeDesc::cuboid([1.0; 3])))
            .expect("a box");
    }
    let slots: Vec<ShapeId> = w.shapes().collect();
    let f = QueryFilter::default();
    let ray = Ray::new([0.0; 3], [0.3, 0.0, 0.0]);
    let all: Vec<ShapeId> = w.cast_ray_all(&ray, &f).iter().map(|h| h.shape).collect();
    assert_eq!(all, slots);
    assert_eq!(w.cast_ray(&ray, &f).map(|h| h.shape), Some(slots[0]));
    let here = WorldPose::default();
    let ball = Shape::Sphere { radius: 0.5 };
    let cast = w.cast_shape(&ball, &here, Vec3::X * 9.0, &f).expect("a hit");
    assert_eq!(cast.shape, slots[0]);
    assert!((cast.t * 9.0 - 3.5).abs() < 1e-5 && cast.normal.distance(-Vec3::X) < 1e-5);
    assert_eq!(w.closest_point(DVec3::ZERO, 9.0, &f).map(|h| h.shape), Some(slots[0]));
    // Without the first two, the third.
    let not = |s: ShapeId| s.index() > 1;
    assert_eq!(w.cast_ray(&ray, &QueryFilter::default().only(&not)).map(|h| h.shape), Some(slots[2]));
}

#[test]
fn sensors_are_seen_only_when_asked_for() {
    let mut w = world();
    let body = BodyDesc::fixed().shape(ShapeDesc::sphere(1.0).sensor());
    let id = w.add_body(body).expect("a sensor");
    let (hide, show) = (QueryFilter::default(), QueryFilter::default().with_sensors());
    let ray = Ray::new([-5.0, 0.0, 0.0], Vec3::X);
    assert!(w.cast_ray(&ray, &hide).is_none() && !w.ray_blocked(&ray, &hide));
    assert!(w.overlap_point(DVec3::ZERO, &hide).is_empty());
    assert!(w.closest_point(DVec3::ZERO, 9.0, &hide).is_none());
    assert_eq!(w.cast_ray(&ray, &show).map(|h| h.body), Some(id));
    assert_eq!(w.overlap_point(DVec3::ZERO, &show).len(), 1);
    // What was taken out of the simulation is not there.
    w.set_body_enabled(id, false).expect("alive");
    assert!(w.cast_ray(&ray, &show).is_none());
}

#[test]
fn input_that_is_not_finite_finds_nothing() {
    let mut w = random_world(40, 40, DVec3::ZERO, 4.0);
    ground(&mut w);
    let f = QueryFilter::default().with_sensors();
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let ball = Shape::Sphere { radius: 1.0 };
    let here = WorldPose::default();
    for bad in odd {
        for axis in 0..3 {
            let mut v = Vec3::ONE;
            v[axis] = bad;
            let p = v.as_dvec3();
            let rays = [Ray::new(p, Vec3::X), Ray::new(DVec3::ZERO, v)];
            for ray in rays {
                assert!(w.cast_ray(&ray, &f).is_none() && w.cast_ray_all(&ray, &f).is_empty());
                assert!(!w.ray_blocked(&ray, &f));
            }
            assert!(w.cast_shape(&ball, &here, v, &f).is_none());
            assert!(w.cast_shape(&ball, &WorldPose::new(p, Quat::IDENTITY), Vec3::X, &f).is_none());
            assert!(w.overlap_shape(&ball, &WorldPose::new(p, Quat::IDENTITY), &f).is_empty());
            assert!(w.overlap_point(p, &f).is_empty());
            assert!(w.overlap_aabb(p, DVec3::splat(9.0), &f).is_empty());
            assert!(w.closest_point(p, 9.0, &f).is_none());
        }
        let q = Quat::new(0.0, bad, 0.0, 1.0);
        assert!(w.overlap_shape(&ball, &WorldPose::new(DVec3::ZERO, q), &f).is_empty());
        assert!(w.overlap_shape(&Shape::Sphere { radius: bad }, &here, &f).is_empty());
    }
    assert!(w.cast_ray(&Ray::new(DVec3::ZERO, Vec3::ZERO), &f).is_none());
    let mut ray = Ray::new(DVec3::ZERO, Vec3::X);
    for max_t in [f32::NAN, -1.0, f32::NEG_INFINITY] {
        ray.max_t = max_t;
        assert!(w.cast_ray(&ray, &f).is_none());
    }
    ray.max_t = f32::INFINITY;
    w.cast_ray(&ray, &f);
    assert!(w.closest_point(DVec3::ZERO, f32::NAN, &f).is_none());
    assert!(w.overlap_aabb(DVec3::ONE, DVec3::ZERO, &f).is_empty());
}

#[test]
fn huge_and_tiny_finite_input_does_not_panic() {
    let mut w = random_world(41, 40, DVec3::ZERO, 4.0);
    ground(&mut w);
    let f = QueryFilter::default().with_sensors();
    let odd = [0.0, -0.0, f32::MIN_POSITIVE, 1e-45, 1e-30, 1e30, f32::MAX, -f32::MAX];
    for x in odd {
        for y in odd {
            let v = Vec3::new(x, y, 1.0);
            let p = DVec3::new(f64::from(x) * 1e10, f64::from(y), 0.0);
            for ray in [Ray::new(p, v), Ray::new(DVec3::ZERO, v), Ray { origin: p, dir: v, max_t: x.abs() }] {
                if let Some(h) = w.cast_ray(&ray, &f) {
                    assert!(h.t >= 0.0 && f32s::max(h.t, 0.0) <= ray.max_t, "{ray:?} {h:?}");
                }
                w.cast_ray_all(&ray, &f);
                w.ray_blocked(&ray, &f);
            }
            let at = WorldPose::new(p, Quat::new(x, y, 0.0, 1.0));
            let ball = Shape::Sphere { radius: 1.0 };
            w.cast_shape_all(&ball, &at, v, &f);
            w.cast_shape(&Shape::Sphere { radius: x }, &WorldPose::default(), v, &f);
            w.overlap_shape(&ball, &at, &f);
            w.overlap_point(p, &f);
            w.overlap_aabb(p, p + DVec3::ONE, &f);
            w.closest_point(p, x, &f);
        }
    }
}

#[test]
fn the_order_of_the_past_cannot_be_seen() {
    // The same shapes, entered in another order of moves: other trees, the same answers.
    let build = |detour: bool| {
        let mut w = world();
        let mut ids = Vec::new();
        let mut r = Random::new(3);
        for _ in 0..200 {
            let home = r.vec(10.0).as_dvec3();
            let id =
                w.add_body(BodyDesc::fixed().at(home).shape(ShapeDesc::new(solid(&mut r)))).expect("a body");
            ids.push((id, home));
        }
        if detour {
            for &(id, home) in ids.iter().rev() {
                w.teleport(id, home + DVec3::new(50.0, 3.0, 1.0), Quat::IDENTITY).expect("alive");
                w.teleport(id, home, Quat::IDENTITY).expect("alive");
            }
        }
        w
    };
    let (a, b) = (build(false), build(true));
    let mut r = Random::new(4);
    let f = QueryFilter::default();
    for _ in 0..300 {
        let ray = Ray::new(r.vec(14.0).as_dvec3(), r.dir());
        assert_eq!(a.cast_ray(&ray, &f), b.cast_ray(&ray, &f));
        assert_eq!(a.closest_point(ray.origin, 3.0, &f), b.closest_point(ray.origin, 3.0, &f));
        let at = WorldPose::new(ray.origin, r.turn());
        let s = solid(&mut r);
        assert_eq!(a.overlap_shape(&s, &at, &f), b.overlap_shape(&s, &at, &f));
    }
}

#[test]
fn no_rounded_box_hides_a_shape() {
    // Pebbles smaller than the spacing of f32 out there, and rays and points that are no f32 either.
    let center = DVec3::new(3e6, -2e6, 1e6);
    let mut w = world();
    let mut r = Random::new(12);
    for _ in 0..60 {
        let at = center + r.vec(1.0).as_dvec3();
        w.add_body(BodyDesc::fixed().at(at).shape(ShapeDesc::sphere(0.03))).expect("a pebble");
    }
    let f = QueryFilter::default();
    let mut hits = 0;
    for _ in 0..4000 {
        let axis = [Vec3::X, -Vec3::Y, Vec3::Z, r.dir()][r.below(4)];
        let ray = Ray::new(center + r.vec(1.0).as_dvec3() - axis.as_dvec3(), axis);
        let brute = all_rays(&w, &ray, &f);
        assert_eq!(w.cast_ray_all(&ray, &f), brute, "{ray:?}");
        hits += brute.len();
        let near = |s: ShapeRef<'_>| {
            let pose = s.world_pose();
            s.shape().closest_point(pose.inverse_transform_point(ray.origin)).expect("finite").distance
        };
        let least = visible(&w, &f).map(near).fold(f32::MAX, f32s::min);
        assert_eq!(w.closest_point(ray.origin, 9.0, &f).map(|h| h.distance), Some(least));
    }
    assert!(hits > 100, "only {hits} hits");
}
