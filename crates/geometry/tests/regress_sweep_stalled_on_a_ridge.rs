//! The direction sweep that the pair tests trust found a gap of 17.5 mm where a box and a capsule are 21.8 mm apart, and
//! the contact code was blamed for a miss. Along an edge's ridge of the gap, steep on both sides, none of the climb's
//! eight directions went up. Where shapes are apart the sweep now ends with a search that ridges do not stop.

mod common;
use common::gap;
use jounce_geometry::Shape;
use jounce_math::{DVec3, Pose, Quat, Vec3, scalar::f64s};

#[test]
fn sweep_finds_the_gap_of_box_and_capsule() {
    let (half_height, radius) = (0.605_517_6, 0.140_926_75);
    let half = Vec3::new(0.256_087_84, 0.518_237_65, 0.702_332_2);
    let (capsule, cuboid) = (Shape::Capsule { half_height, radius }, Shape::Box { half });
    let pose = Pose {
        p: Vec3::new(-0.777_739_1, 0.480_432_12, 0.012_668_716),
        q: Quat { x: -0.832_984_86, y: -0.508_324_1, z: 0.213_964_45, w: -0.044_295_47 },
    };
    // Distance of the capsule's axis from the box, a convex function of the place on the axis, by thirds.
    let end = |y: f32| pose.inverse_transform_point(Vec3::new(0.0, y, 0.0)).as_dvec3();
    let (from, to) = (end(-half_height), end(half_height));
    let outside = |x: f64, h: f32| f64s::max(x.abs() - f64::from(h), 0.0);
    let away = |t: f64| {
        let p = from + (to - from) * t;
        DVec3::new(outside(p.x, half.x), outside(p.y, half.y), outside(p.z, half.z)).length()
    };
    let (mut lo, mut hi) = (0.0, 1.0);
    for _ in 0..200 {
        let (s, t) = (lo + (hi - lo) / 3.0, hi - (hi - lo) / 3.0);
        if away(s) < away(t) { hi = t } else { lo = s }
    }
    let want = away(lo) - f64::from(radius);
    assert!((want - 0.021_764).abs() < 1e-6, "{want}");
    let g = gap(&capsule, &cuboid, &pose, 1500, &[]);
    assert!((f64::from(g) - want).abs() < 1e-5, "{g} against {want}");
}
