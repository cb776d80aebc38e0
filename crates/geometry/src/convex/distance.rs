//! Closest points of any two shapes of which one is solid.

use super::Distance;
use super::core::Core;
use super::gjk::{Difference, Gjk};
use crate::pairs::{Surface, rank};
use crate::shapes::compound::Compound;
use crate::{Aabb, NO_SUB, Shape};
use jounce_math::{Pose, Vec3, scalar::f32s};

/// Closest points of A and B, where `b_in_a` is the pose of B in A's frame. `max_distance` bounds the
/// search (`f32::MAX` for none): `None` when they are farther apart, and for pairs without a solid shape. Surfaces
/// count from both sides.
pub fn distance(a: &Shape, b: &Shape, b_in_a: &Pose, max_distance: f32) -> Option<Distance> {
    if !b_in_a.is_finite() {
        return None;
    }
    if rank(a) < rank(b) {
        let a_in_b = b_in_a.inverse();
        return ordered(b, a, &a_in_b, max_distance).map(|d| d.flipped(&a_in_b));
    }
    ordered(a, b, b_in_a, max_distance)
}

/// Do they overlap or touch?
pub fn overlap(a: &Shape, b: &Shape, b_in_a: &Pose) -> bool {
    distance(a, b, b_in_a, 0.0).is_some()
}

fn ordered(a: &Shape, b: &Shape, pose: &Pose, max: f32) -> Option<Distance> {
    if let Shape::Compound(c) = a {
        return compound(c, b, pose, max);
    }
    let (core, radius) = Core::of(b)?;
    match a {
        Shape::HalfSpace { normal, offset } => plane(*normal, *offset, &core, radius, pose, max),
        Shape::Mesh(m) => surface(&Surface::Mesh(m), b, &core, radius, pose, max),
        Shape::HeightField(h) => surface(&Surface::HeightField(h), b, &core, radius, pose, max),
        _ => {
            let (core_a, radius_a) = Core::of(a)?;
            cores((core_a, radius_a), (core, radius), pose, max)
        }
    }
}

/// Two convex shapes, each a core and a radius.
pub(crate) fn cores((a, ra): (Core, f32), (b, rb): (Core, f32), pose: &Pose, max: f32) -> Option<Distance> {
    let w = Difference { a, b, pose: *pose };
    let reach = if max < f32::MAX { max + ra + rb } else { f32::MAX };
    let at = |distance, point_a, point_b, normal| {
        Some(Distance { distance, point_a, point_b, normal, sub_a: NO_SUB, sub_b: NO_SUB })
    };
    match w.gjk(Vec3::ZERO, reach) {
        Gjk::Far(..) => None,
        Gjk::Apart { distance, a, b, normal } => {
            let d = distance - ra - rb;
            if d > 0.0 {
                return at(d, a + normal * ra, b - normal * rb, normal);
            }
            // In both: halfway between the two surfaces.
            let p = (a + normal * ra + b - normal * rb) * 0.5;
            at(0.0, p, p, normal)
        }
        Gjk::Overlap(s) => {
            let mut p = Vec3::ZERO;
            for i in 0..s.count {
                p += s.vertices[i].a * s.weights[i] as f32;
            }
            at(0.0, p, p, pose.p.normalize_or(Vec3::Y))
        }
    }
}

fn plane(n: Vec3, offset: f32, core: &Core, radius: f32, pose: &Pose, max: f32) -> Option<Distance> {
    let low = pose.transform_point(core.support(pose.q.inverse_rotate(-n))) - n * radius;
    let s = n.dot(low) - offset;
    let d = f32s::max(s, 0.0);
    (d <= max).then(|| Distance {
        distance: d,
        point_a: low - n * d,
        point_b: low,
        normal: n,
        sub_a: NO_SUB,
        sub_b: NO_SUB,
    })
}

/// The nearer; of equals the one with the lower part of A.
fn nearer(best: &Option<Distance>, d: &Distance) -> bool {
    best.is_none_or(|b| d.distance < b.distance || (d.distance == b.distance && d.sub_a < b.sub_a))
}

/// Triangles in boxes that grow until one holds the nearest.
fn surface(a: &Surface, b: &Shape, core: &Core, radius: f32, pose: &Pose, max: f32) -> Option<Distance> {
    let bounds = b.aabb(pose);
    let everything = a.bounds().union(&bounds);
    let farthest = (everything.max - everything.min).length();
    let max = f32s::min(max, farthest);
    let mut reach = f32s::min((bounds.max - bounds.min).max_component(), max);
    loop {
        let mut best: Option<Distance> = None;
        a.visit(&bounds.expanded(reach), |index| {
            let Some(t) = a.corners(index) else { return };
            let limit = best.map_or(reach, |b| b.distance);
            if let Some(mut d) = cores((Core::Triangle(t), 0.0), (*core, radius), pose, limit) {
                d.sub_a = a.name(index);
                if nearer(&best, &d) {
                    best = Some(d);
                }
            }
        });
        if best.is_some() || reach >= max {
            return best;
        }
        reach = f32s::min(f32s::max(4.0 * reach, 1e-3 * farthest), max);
    }
}

fn compound(a: &Compound, b: &Shape, pose: &Pose, max: f32) -> Option<Distance> {
    let bounds = b.aabb(pose);
    let mut best: Option<Distance> = None;
    for (index, (frame, child)) in a.children().iter().enumerate() {
        let limit = best.map_or(max, |b| b.distance);
        if box_distance(&child.aabb(frame), &bounds) > limit {
            continue;
        }
        if let Some(d) = distance(child, b, &frame.relative(pose), limit) {
            let d = Distance { sub_a: index as u32, ..d.moved(frame) };
            if nearer(&best, &d) {
                best = Some(d);
            }
        }
    }
    best
}

fn box_distance(a: &Aabb, b: &Aabb) -> f32 {
    (a.min - b.max).max(b.min - a.max).max(Vec3::ZERO).length()
}
