//! Does a moving shape stay out of a surface, but for a depth?

use super::Sweep;
use super::core::Core;
use super::impact::swept_bounds;
use crate::pairs::{Surface, SweptSieve};
use crate::{Aabb, Shape};

/// Does each triangle of A (a mesh or a height field) have a direction in which B (convex) overlaps it by less than `depth`
/// metres, all along `sweep`? Then nothing passes through it. A quick look, made to spare [`crate::time_of_impact`]: where it
/// says no, that has to be asked; and it says no for all other shapes. Triangles of a one-sided surface that B's centre is
/// behind do not count.
pub fn stays_shallow(a: &Shape, b: &Shape, sweep: &Sweep, depth: f32) -> bool {
    let a = match a {
        Shape::Mesh(m) => Surface::Mesh(m),
        Shape::HeightField(h) => Surface::HeightField(h),
        _ => return false,
    };
    let Some((core, radius)) = Core::of(b) else { return false };
    let finite = sweep.local_center.is_finite()
        && sweep.center.iter().all(|c| c.is_finite())
        && sweep.rotation.iter().all(|q| q.is_finite());
    if !finite {
        return false;
    }
    let (first, motion, sagitta) = swept_bounds(sweep, b, -depth);
    let swept = first.union(&Aabb::new(first.min + motion, first.max + motion));
    let start = sweep.pose(0.0).transform_point(core.center());
    let mut sieve = None;
    a.all(&swept, |index| {
        let new = || SweptSieve::new(core, sweep, radius - depth, sagitta, &a.bounds());
        let sieve = sieve.get_or_insert_with(new);
        let Some(t) = a.corners(index).filter(|t| sieve.passes(t)) else { return true };
        let Some(n) = a.normal(index) else { return true };
        let height = n.dot(start - t[0]);
        if height < 0.0 && !a.is_two_sided() {
            return true;
        }
        // Most of the others are below B along their own normal; and so are their neighbours, then.
        sieve.parts(&t, if height < 0.0 { -n } else { n })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{TriMesh, TriMeshOptions};
    use jounce_math::Quat;
    use jounce_math::Vec3;
    use std::sync::Arc;

    /// A square of two triangles in the plane y = 0, 10 m wide.
    fn floor() -> Shape {
        let v = [-1.0, 1.0].map(|x| [-1.0, 1.0].map(|z| Vec3::new(5.0 * x, 0.0, 5.0 * z)));
        let v = [v[0][0], v[0][1], v[1][1], v[1][0]];
        Shape::Mesh(Arc::new(
            TriMesh::new(&v, &[[0, 1, 2], [0, 2, 3]], TriMeshOptions::default()).expect("two"),
        ))
    }

    fn slide(from: Vec3, to: Vec3, turn: f32) -> Sweep {
        let rotation = [Quat::IDENTITY, Quat::from_axis_angle(Vec3::Z, turn)];
        Sweep { local_center: Vec3::ZERO, center: [from, to], rotation }
    }

    #[test]
    fn depth_decides() {
        let b = Shape::Box { half: Vec3::splat(0.5) };
        let down = |y: f32| slide(Vec3::new(0.0, 0.5, 0.0), Vec3::new(1.0, y, 0.3), 0.0);
        assert!(stays_shallow(&floor(), &b, &down(0.5), 0.1));
        assert!(stays_shallow(&floor(), &b, &down(0.41), 0.1));
        assert!(!stays_shallow(&floor(), &b, &down(0.39), 0.1));
        assert!(!stays_shallow(&floor(), &b, &down(-3.0), 0.1));
        // A turn by 45° puts a corner 0.207 m under the floor.
        let turned = slide(Vec3::Y * 0.5, Vec3::Y * 0.5, core::f32::consts::FRAC_PI_4);
        assert!(!stays_shallow(&floor(), &b, &turned, 0.2));
        assert!(stays_shallow(&floor(), &b, &turned, 0.3));
    }

    /// Past the border by less than the depth, and from behind.
    #[test]
    fn borders_and_backs() {
        let b = Shape::Box { half: Vec3::splat(0.5) };
        let past = |x: f32| slide(Vec3::new(x, 2.0, 0.0), Vec3::new(x, -2.0, 0.0), 0.0);
        assert!(stays_shallow(&floor(), &b, &past(5.45), 0.1));
        assert!(!stays_shallow(&floor(), &b, &past(5.35), 0.1));
        let up = slide(Vec3::new(0.0, -2.0, 0.0), Vec3::new(0.0, 2.0, 0.0), 0.0);
        assert!(stays_shallow(&floor(), &b, &up, 0.1));
    }

    #[test]
    fn other_pairs_have_to_be_asked() {
        let (b, plane) = (Shape::Sphere { radius: 0.5 }, Shape::HalfSpace { normal: Vec3::Y, offset: 0.0 });
        let far = slide(Vec3::Y * 9.0, Vec3::Y * 8.0, 0.0);
        assert!(!stays_shallow(&plane, &b, &far, 0.1) && !stays_shallow(&floor(), &plane, &far, 0.1));
        let lost = slide(Vec3::splat(f32::NAN), Vec3::Y, 0.0);
        assert!(!stays_shallow(&floor(), &b, &lost, 0.1) && stays_shallow(&floor(), &b, &far, 0.1));
    }
}
