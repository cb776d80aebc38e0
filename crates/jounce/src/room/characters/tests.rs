//! The plane solver against its optimality conditions.

use super::planes::{Plane, nearest};
use jounce_math::{Vec3, scalar::f32s};

fn random(state: &mut u64) -> f32 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    ((*state >> 40) as f32) / (1u64 << 23) as f32 - 1.0
}

#[test]
fn corners_stop_and_walls_are_slid_along() {
    let wall = |x: f32, y: f32, z: f32| Plane { n: Vec3::new(x, y, z).normalize_or(Vec3::X), least: 0.0 };
    let (x, bad) = nearest(Vec3::new(-1.0, 0.0, 0.5), &[wall(1.0, 0.0, 0.0)]);
    assert_eq!((x, bad), (Vec3::new(0.0, 0.0, 0.5), 0.0));
    // Into a narrow corner: nothing is left.
    let narrow = [wall(1.0, 0.0, 0.1), wall(-1.0, 0.0, 0.1)];
    let (x, _) = nearest(Vec3::new(0.2, 0.0, -1.0), &narrow);
    assert!(x.length() < 1e-5, "{x:?}");
    // Squeezed: the least violation is told.
    let squeeze = [Plane { n: Vec3::X, least: 0.1 }, Plane { n: -Vec3::X, least: 0.3 }];
    assert!(nearest(Vec3::ZERO, &squeeze).1 > 0.05);
}

/// No point that the planes allow is nearer: tried with many points.
#[test]
fn no_allowed_point_is_nearer() {
    let mut s = 7;
    for _ in 0..500 {
        let mut v = || Vec3::new(random(&mut s), random(&mut s), random(&mut s));
        // All normals in one half of space, so that something is allowed.
        let planes: Vec<Plane> = (0..5)
            .map(|_| {
                let n = v();
                Plane { n: Vec3::new(n.x, n.y.abs() + 0.05, n.z).normalize_or(Vec3::Y), least: 0.3 * n.x }
            })
            .collect();
        let want = v() * 2.0;
        let (x, bad) = nearest(want, &planes);
        assert_eq!(bad, 0.0);
        let d = (x - want).length();
        for _ in 0..200 {
            let y = x + v() * 0.5;
            if planes.iter().all(|p| p.n.dot(y) >= p.least) {
                assert!((y - want).length() >= d - 1e-4 * f32s::max(d, 1.0), "{y:?} beats {x:?}");
            }
        }
    }
}

/// In a heap of characters each looked at all the others, in every round of pushing out, and at every pair of the planes they gave:
/// a thousand in one place never came to an end. What a character looks at is bounded now.
#[test]
fn a_crowd_in_one_place_is_looked_at_in_part() {
    use crate::limits::{CHARACTER_MOVERS_MAX, CHARACTER_PLANES_MAX};
    use crate::prelude::*;
    let mut w = World::new(WorldDesc::default()).unwrap();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap();
    let n = 10 * CHARACTER_MOVERS_MAX;
    let all: Vec<_> =
        (0..n).map(|_| w.add_character(crate::CharacterDesc::at([0.0, 0.02, 0.0])).unwrap()).collect();
    for _ in 0..3 {
        w.step().unwrap();
        let s = &w.characters.scratch;
        assert!(s.most_near <= CHARACTER_MOVERS_MAX + 1, "{} shapes near", s.most_near);
        assert!(s.most_planes <= CHARACTER_PLANES_MAX, "{} planes", s.most_planes);
        assert!(s.most_near > CHARACTER_MOVERS_MAX, "the bound was met: {}", s.most_near);
    }
    for c in all {
        let p = w.body(w.character(c).unwrap().body()).unwrap().position();
        assert!(p.is_finite() && p.y > -0.01, "{p:?}");
    }
}
