//! Rays that started away from a cone missed it: the start is moved along the ray to the point nearest the cone's
//! middle before the quadratic is solved, and the root was moved back in the wrong direction. Pictures showed scenes
//! without their cones. Boxes and the caps of cylinders gave normals into the solid.

use jounce_geometry::Shape;
use jounce_math::Vec3;

#[test]
fn rays_from_afar_hit_from_outside() {
    let shapes = [
        Shape::Cone { half_height: 0.8, radius: 1.0 },
        Shape::Cylinder { half_height: 0.8, radius: 1.0 },
        Shape::Box { half: Vec3::new(0.8, 0.5, 1.1) },
        Shape::Capsule { half_height: 0.8, radius: 1.0 },
    ];
    let target = Vec3::new(0.1, -0.2, 0.05);
    for shape in &shapes {
        for i in -3..=3 {
            for j in -3..=3 {
                for k in [-1, 1] {
                    let from = Vec3::new(i as f32 * 2.3, j as f32 * 1.9, k as f32 * 7.0);
                    let hit = shape.ray_cast(from, target - from, 2.0).expect("the target is inside");
                    let point = from + (target - from) * hit.t;
                    let surface = shape.closest_point(point).expect("finite");
                    assert!(surface.distance.abs() < 1e-4, "{shape:?} from {from:?}: {}", surface.distance);
                    assert!(
                        hit.t < 1.0 && hit.normal.dot(target - from) < 0.0,
                        "{shape:?} from {from:?}: {hit:?}"
                    );
                }
            }
        }
    }
}
