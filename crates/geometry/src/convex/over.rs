//! Does a shape stand out over a plane?

use super::core::Core;
use crate::pairs::Surface;
use crate::{Aabb, Shape};
use jounce_math::Vec3;

impl Shape {
    /// Does any part of the shape that reaches into `near` stand out over the plane `normal` · x = `offset` (its own frame,
    /// metres)? Convex parts and triangles are judged whole. Exact for unit normals.
    pub fn rises_over(&self, normal: Vec3, offset: f32, near: &Aabb) -> bool {
        let over = |t: [Vec3; 3]| t.iter().any(|p| normal.dot(*p) > offset);
        let surface = match self {
            Self::HalfSpace { normal: n, offset: o } => {
                // A hair's lean is none within `near`; any other plane stands out somewhere.
                let lean = *n - normal;
                let reach = near.min.abs().max(near.max.abs()).length();
                return n.dot(normal) < 0.9999 || o + lean.length() * reach > offset;
            }
            Self::Compound(c) => {
                let mut found = false;
                c.tree.query(near, |i| {
                    if let Some((frame, child)) = c.children.get(i as usize) {
                        let n = frame.q.inverse_rotate(normal);
                        found |= convex_rises(child, n, offset - normal.dot(frame.p));
                    }
                    !found
                });
                return found;
            }
            Self::Mesh(m) => Surface::Mesh(m),
            Self::HeightField(h) => Surface::HeightField(h),
            _ => return convex_rises(self, normal, offset),
        };
        let mut found = false;
        surface.visit(near, |index| found = found || surface.corners(index).is_some_and(over));
        found
    }
}

fn convex_rises(shape: &Shape, normal: Vec3, offset: f32) -> bool {
    Core::of(shape).is_some_and(|(core, radius)| normal.dot(core.support(normal)) + radius > offset)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Compound, TriMesh, TriMeshOptions};
    use jounce_math::{Pose, Quat};
    use std::sync::Arc;

    /// The highest point along a direction, from the closed form of each shape.
    #[test]
    fn stands_out_exactly_to_its_height() {
        let n = Vec3::new(0.36, 0.48, 0.8);
        let near = Aabb::from_center(Vec3::ZERO, Vec3::splat(10.0));
        let half = Vec3::new(1.0, 2.0, 3.0);
        let child = (Pose::new(Vec3::new(0.0, 5.0, 0.0), Quat::IDENTITY), Shape::Sphere { radius: 1.0 });
        let corners = [Vec3::ZERO, Vec3::X, Vec3::new(0.0, 0.0, 2.0)];
        let mesh = TriMesh::new(&corners, &[[0, 2, 1]], TriMeshOptions::default()).expect("a triangle");
        let plane = Shape::HalfSpace { normal: n, offset: 0.5 };
        for (shape, height) in [
            (Shape::Sphere { radius: 2.0 }, 2.0),
            (Shape::Box { half }, 0.36 + 0.96 + 2.4),
            (Shape::Capsule { half_height: 1.0, radius: 0.5 }, 0.48 + 0.5),
            (Shape::Compound(Arc::new(Compound::new(vec![child]).expect("one ball"))), 2.4 + 1.0),
            (Shape::Mesh(Arc::new(mesh)), 1.6),
            (plane, 0.5),
        ] {
            assert!(shape.rises_over(n, height - 1e-3, &near), "{shape:?}");
            assert!(!shape.rises_over(n, height + 1e-3, &near), "{shape:?}");
        }
    }

    /// Only what is near counts for shapes of many parts.
    #[test]
    fn far_parts_do_not_count() {
        let ball = |y| (Pose::new(Vec3::new(0.0, y, 0.0), Quat::IDENTITY), Shape::Sphere { radius: 1.0 });
        let two = Shape::Compound(Arc::new(Compound::new(vec![ball(0.0), ball(9.0)]).expect("two balls")));
        let near = Aabb::from_center(Vec3::ZERO, Vec3::splat(2.0));
        assert!(!two.rises_over(Vec3::Y, 1.5, &near));
        assert!(two.rises_over(Vec3::Y, 0.5, &near));
    }
}
