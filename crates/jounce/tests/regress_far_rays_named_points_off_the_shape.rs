//! A ray from 1e8 m above a box met its top, at y = 5.5, and told of the point y = 8: t was rounded to `f32` before the point was
//! computed from it.

mod support;

use jounce::prelude::*;
use support::*;

#[test]
fn the_point_of_a_hit_is_on_the_shape_from_any_distance() {
    let mut w = world();
    let floor = ground(&mut w);
    let b =
        w.add_body(BodyDesc::fixed().at([0.3, 5.0, 0.1]).shape(ShapeDesc::cuboid([0.5; 3]))).expect("a box");
    for far in [10.0, 1e4, 1e6, 1e8, 9e8] {
        for dir in [-Vec3::Y, -Vec3::Y * 3.0] {
            let hits = w.cast_ray_all(&Ray::new([0.3, far, 0.1], dir), &QueryFilter::default());
            let [top, ground] = hits[..] else { panic!("from {far}: {hits:?}") };
            assert_eq!((top.body, ground.body), (b, floor));
            for (hit, y) in [(top, 5.5), (ground, 0.0)] {
                // The top is computed near the box, in single precision.
                assert!((hit.point.y - y).abs() < 1e-5, "from {far}: {:?}", hit.point);
                assert_eq!((hit.point.x, hit.point.z), (0.3, 0.1));
                let t = (far - y) / f64::from(dir.length());
                assert!((f64::from(hit.t) - t).abs() <= 1e-7 * far + 1e-5, "from {far}: {}", hit.t);
                assert_eq!(hit.normal, Vec3::Y);
            }
            let first = w.cast_ray(&Ray::new([0.3, far, 0.1], dir), &QueryFilter::default());
            assert_eq!(first, Some(top));
        }
        // Aslant onto the plane, and from below it.
        let aslant = Ray::new([far, far, 0.0], Vec3::new(-1.0, -1.0, 0.0));
        let hit = w.cast_ray(&aslant, &QueryFilter::default()).expect("the ground");
        assert!(hit.point.length() < 1e-5 * (1.0 + 1e-9 * far), "from {far}: {:?}", hit.point);
        let below =
            w.cast_ray(&Ray::new([0.0, -far, 0.0], Vec3::Y), &QueryFilter::default()).expect("inside");
        assert!(below.t == 0.0 && below.normal == -Vec3::Y && below.body == floor);
        let up = w.cast_ray(&Ray::new([0.0, far, 0.0], Vec3::Y), &QueryFilter::default());
        assert_eq!(up, None);
    }
}
