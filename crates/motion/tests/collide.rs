//! Particles, edges and faces against planes; the bounce.
#![expect(clippy::disallowed_methods, reason = "the reference side of a test may use std's functions")]

use jounce_math::DVec3;
use jounce_motion::collide::*;
use jounce_motion::integrate::{Integrator, Method};

#[test]
fn the_bounce_uses_the_normal_twice() {
    // The slide's (N·V) V would leave a component along the surface in V_n.
    let v = DVec3::new(3.0, -4.0, 12.0);
    let n = DVec3::new(0.6, 0.8, 0.0);
    let (normal, tangential) = split(v, n);
    assert!(normal.cross(n).length() < 1e-15 && tangential.dot(n).abs() < 1e-15);
    let b = respond(v, n, 0.7, 0.2);
    assert!((b.dot(n) + 0.7 * v.dot(n)).abs() < 1e-14);
    assert!((b - n * b.dot(n) - tangential * 0.8).length() < 1e-14);
    assert!((respond(v, n, 1.0, 0.0).length() - v.length()).abs() < 1e-14, "elastic: the speed is kept");
    assert_eq!(respond(v, n, 0.0, 1.0).length(), 0.0, "sticks");
}

#[test]
fn an_elastic_ball_returns_to_its_height() {
    let floor = Plane::new(DVec3::ZERO, DVec3::Y).expect("plane");
    let (h, g, dt) = (1.0, 9.81, 1e-4);
    let (mut x, mut v) = (DVec3::Y * h, DVec3::ZERO);
    let mut verlet = Integrator::new(Method::VelocityVerlet);
    let (mut bounces, mut apex) = (0u32, 0.0f64);
    while bounces < 5 {
        verlet.step_point(0.0, dt, &mut x, &mut v, |_, _, _| DVec3::Y * -g).expect("falls");
        if floor.collide(&mut x, &mut v, 1.0, 0.0) {
            if bounces > 0 {
                // Each push-out adds the energy of a depth of at most v Δt, and costs none.
                let slack = (2.0 * g * h).sqrt() * dt * f64::from(bounces) * 1.1;
                assert!(apex >= h - 1e-9 && apex <= h + slack, "{bounces}: {apex}");
            }
            (bounces, apex) = (bounces + 1, 0.0);
        }
        apex = apex.max(x.y);
    }
}

#[test]
fn the_path_of_bounces_is_that_of_the_series() {
    // h = 1, e = 1/2: between bounces the closed form holds, and `respond` gives the speeds. Rest after 1.354571 s and
    // a path of 1.66667 m.
    let (g, e) = (9.81, 0.5);
    let mut v = DVec3::Y * -(2.0f64 * g).sqrt();
    let (mut t, mut path) = ((2.0f64 / g).sqrt(), 1.0);
    for _ in 0..60 {
        v = respond(v, DVec3::Y, e, 0.0);
        t += 2.0 * v.y / g;
        path += v.y * v.y / g;
        v = -v;
    }
    assert!((t - 1.354_571).abs() < 5e-7 && (path - 5.0 / 3.0).abs() < 1e-12, "{t} {path}");
}

#[test]
fn sides_and_push_out() {
    let plane = Plane::new(DVec3::new(1.0, 1.0, 1.0), DVec3::new(1.0, 2.0, -2.0)).expect("plane");
    assert!((plane.normal().length() - 1.0).abs() < 1e-15);
    let inside = plane.point() - plane.normal() * 0.5 + plane.normal().cross(DVec3::X) * 3.0;
    assert_eq!(plane.side(inside), Side::Inside);
    assert_eq!(plane.side(plane.point()), Side::On);
    let out = plane.push_out(inside);
    assert!(plane.distance(out).abs() < 1e-15 && (out - inside).cross(plane.normal()).length() < 1e-15);
    let outside = plane.point() + plane.normal();
    assert_eq!(plane.push_out(outside), outside);
    let (mut x, mut v) = (outside, DVec3::Y);
    assert!(!plane.collide(&mut x, &mut v, 1.0, 0.0));
    assert_eq!((x, v), (outside, DVec3::Y));
}

#[test]
fn edges_and_planes() {
    let floor = Plane::new(DVec3::ZERO, DVec3::Y).expect("plane");
    assert_eq!(edge_plane(DVec3::X, DVec3::Z, &floor), EdgeHit::Within);
    let touches = edge_plane(DVec3::X, DVec3::new(1.0, 5.0, 0.0), &floor);
    assert_eq!(touches, EdgeHit::Crosses { t: 0.0, point: DVec3::X });
    assert_eq!(edge_plane(DVec3::Y * -1.0, DVec3::Y * -2.0, &floor), EdgeHit::Misses);
    // Distances whose product underflows still have a sign.
    assert_eq!(edge_plane(DVec3::Y * 1e-200, DVec3::Y * 2e-200, &floor), EdgeHit::Misses);
    assert!(matches!(edge_plane(DVec3::Y * 1e-200, DVec3::Y * -1e-200, &floor), EdgeHit::Crosses { .. }));
    assert_eq!(edge_plane(DVec3::Y * f64::NAN, DVec3::Y, &floor), EdgeHit::Misses);
    let face = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]].map(DVec3::from);
    let hit = edge_face(DVec3::new(0.5, 1.0, 0.0), DVec3::new(0.5, -1.0, 0.0), &face).expect("face");
    assert_eq!(hit, EdgeHit::Crosses { t: 0.5, point: DVec3::X * 0.5 });
    let miss = edge_face(DVec3::new(1.5, 1.0, 0.0), DVec3::new(1.5, -1.0, 0.0), &face).expect("face");
    assert_eq!(miss, EdgeHit::Misses);
}

#[test]
fn planes_and_faces() {
    let a = Plane::new(DVec3::new(0.3, 1.0, -2.0), DVec3::new(1.0, 2.0, 3.0)).expect("plane");
    let b = Plane::new(DVec3::new(-4.0, 0.0, 1.0), DVec3::new(-2.0, 0.5, 1.0)).expect("plane");
    let PlanePair::Meet { point, direction } = plane_plane(&a, &b) else { panic!("they meet") };
    for s in [-10.0, 0.0, 10.0] {
        let x = point + direction * s;
        assert!(a.distance(x).abs() < 1e-14 && b.distance(x).abs() < 1e-13);
    }
    assert_eq!(plane_plane(&a, &a), PlanePair::Parallel { distance: 0.0 });
    let square = |y: f64| [[-1.0, y, -1.0], [-1.0, y, 1.0], [1.0, y, 1.0], [1.0, y, -1.0]].map(DVec3::from);
    assert!(!faces_cut(&square(0.0), &square(0.1)).expect("faces"), "one above the other");
    let upright = [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 9.0], [0.0, -1.0, 9.0]].map(DVec3::from);
    assert!(faces_cut(&square(0.0), &upright).expect("faces"));
    assert!(faces_cut(&upright, &square(0.0)).expect("faces"));
}

#[test]
fn bad_geometry_is_refused() {
    assert!(Plane::new(DVec3::ZERO, DVec3::ZERO).is_err());
    assert!(Plane::new(DVec3::X * f64::NAN, DVec3::Y).is_err());
    assert!(Ball::new(DVec3::ZERO, 0.0).is_err());
    assert!(Ball::new(DVec3::ZERO, -1.0).is_err());
    assert!(faces_cut(&[DVec3::X, DVec3::Y], &[DVec3::ZERO; 3]).is_err());
    assert!(edge_face(DVec3::X, DVec3::Y, &[DVec3::ZERO, DVec3::X, DVec3::X * 2.0]).is_err());
}
