//! A capsule whose axis just touched a cone was reported up to twice as deep as it was, and a ball whose centre lay on a
//! cylinder's surface up to a metre too deep. GJK had found the cores a tenth of a millimetre apart; the penetration
//! search was asked all the same, from a start that did not hold the origin, and gave up at a plane far from the
//! nearest one. Cores that are apart now keep the direction and the distance that GJK found.

mod common;
use common::Rng;
use jounce_geometry::{ManifoldSet, PairCache, Shape, collide, distance};
use jounce_math::{Pose, Quat, Vec3};

fn separation(a: &Shape, b: &Shape, pose: &Pose) -> f32 {
    let mut out = ManifoldSet::new();
    collide(a, b, pose, 0.02, &mut PairCache::default(), &mut out);
    let points = out.manifolds.iter().flat_map(|m| m.points());
    points.map(|p| p.separation).min_by(f32::total_cmp).expect("a contact")
}

#[test]
fn capsule_is_as_deep_as_its_radius_in_both_orders() {
    let cone = Shape::Cone { half_height: 0.110_629_43, radius: 0.489_417 };
    let capsule = Shape::Capsule { half_height: 0.514_436_24, radius: 0.195_497_96 };
    let pose = Pose {
        p: Vec3::new(-0.326_861_14, -0.231_368_32, -0.429_980_37),
        q: Quat { x: 0.866_305_23, y: -0.053_612_13, z: 0.388_802_98, w: -0.308_987_47 },
    };
    for s in [separation(&cone, &capsule, &pose), separation(&capsule, &cone, &pose.inverse())] {
        // The cores are 0.0967 mm apart.
        assert!((s + 0.195_497_96 - 9.67e-5).abs() < 1e-6, "{s}");
    }
}

#[test]
fn touching_cores_are_as_deep_as_their_radii() {
    let mut rng = Rng(0x70C4);
    let mut near = 0;
    for k in 0..4000 {
        let size = |rng: &mut Rng| rng.range(0.1, 1.0);
        let (half_height, radius) = (size(&mut rng), size(&mut rng));
        let a = if k % 2 == 0 {
            Shape::Cone { half_height, radius }
        } else {
            Shape::Cylinder { half_height, radius }
        };
        let (half_height, radius) = (size(&mut rng), size(&mut rng));
        let round = |radius: f32| match k % 4 {
            0 | 1 => Shape::Capsule { half_height, radius },
            _ => Shape::Sphere { radius },
        };
        // A hair instead of the core; bring it to a gap of 0.1 µm to 1 mm.
        let hair = round(1e-6);
        let mut pose = Pose::new(rng.vec(1.5), rng.rotation());
        let Some(d) = distance(&a, &hair, &pose, f32::MAX).filter(|d| d.distance > 0.0) else { continue };
        let gap = 1e-7 * [1.0, 10.0, 100.0, 1e3, 1e4][k % 5];
        pose.p -= d.normal * (d.distance - gap);
        let Some(d) = distance(&a, &hair, &pose, f32::MAX).filter(|d| d.distance > 0.0) else { continue };
        near += 1;
        // Points of a face or of two edges are taken while they are at most twice 0.5 mm less deep than the axis.
        let s = separation(&a, &round(radius), &pose);
        assert!((s + radius - d.distance).abs() < 1e-3, "#{k} {s} {d:?} {a:?} {radius} {pose:?}");
    }
    assert!(near > 2000, "{near}");
}
