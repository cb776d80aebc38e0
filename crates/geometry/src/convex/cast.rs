//! The first contact of a shape that is pushed along a line.
//!
//! Two convex shapes: under pure translation the distance d(t) is a convex function, and its slope at t is
//! motion · n with n the unit direction between the closest points. Newton's method from the left, t ← t − d/(motion · n),
//! therefore never passes the first root, and a slope that is not negative means there is none.

use super::CastHit;
use super::core::Core;
use super::gjk::{Difference, Gjk};
use crate::limits::CAST_ITERATIONS_MAX;
use crate::pairs::{Surface, push_out, rank};
use crate::shapes::compound::Compound;
use crate::{NO_SUB, Shape};
use jounce_math::{Pose, Vec3, scalar::f32s};

/// B moves from `b_in_a` by `motion` (A's frame, no rotation): the first contact. An overlap at the start hits at
/// t = 0. Surfaces are hit from both sides. `None` for pairs without a solid shape.
pub fn cast_shape(a: &Shape, b: &Shape, b_in_a: &Pose, motion: Vec3) -> Option<CastHit> {
    if !(b_in_a.is_finite() && motion.is_finite()) {
        return None;
    }
    cast(a, b, b_in_a, motion, 1.0)
}

/// The same up to the fraction `max_t`.
fn cast(a: &Shape, b: &Shape, pose: &Pose, motion: Vec3, max_t: f32) -> Option<CastHit> {
    if rank(a) < rank(b) {
        let inverse = pose.inverse();
        let h = ordered(b, a, &inverse, -pose.q.inverse_rotate(motion), max_t)?;
        let there = Pose::new(pose.p + motion * h.t, pose.q);
        return Some(CastHit {
            t: h.t,
            point: there.transform_point(h.point),
            normal: -pose.q.rotate(h.normal),
            sub_a: h.sub_b,
            sub_b: h.sub_a,
        });
    }
    ordered(a, b, pose, motion, max_t)
}

fn ordered(a: &Shape, b: &Shape, pose: &Pose, motion: Vec3, max_t: f32) -> Option<CastHit> {
    if let Shape::Compound(c) = a {
        return compound(c, b, pose, motion, max_t);
    }
    let (core, radius) = Core::of(b)?;
    match a {
        Shape::HalfSpace { normal, offset } => plane(*normal, *offset, &core, radius, pose, motion, max_t),
        Shape::Mesh(m) => surface(&Surface::Mesh(m), b, (core, radius), pose, motion, max_t),
        Shape::HeightField(h) => surface(&Surface::HeightField(h), b, (core, radius), pose, motion, max_t),
        _ => cores(Core::of(a)?, (core, radius), pose, motion, max_t),
    }
}

fn cores(
    (a, ra): (Core, f32),
    (b, rb): (Core, f32),
    pose: &Pose,
    motion: Vec3,
    max_t: f32,
) -> Option<CastHit> {
    let r = ra + rb;
    let hit = |t, point, normal| Some(CastHit { t, point, normal, sub_a: NO_SUB, sub_b: NO_SUB });
    let mut w = Difference { a, b, pose: *pose };
    let mut t = 0.0f32;
    let mut last: Option<(Vec3, Vec3)> = None;
    let mut axis = Vec3::ZERO;
    // Closer than this is contact: the normal of closest points that coincide would be noise.
    let tolerance = 1e-6 * (pose.p.abs().max_component() + a.extent() + b.extent());
    for _ in 0..CAST_ITERATIONS_MAX {
        w.pose.p = pose.p + motion * t;
        let (d, pa, pb, n) = match w.gjk(axis, f32::MAX) {
            Gjk::Apart { distance, a, b, normal } if distance > r => (distance - r, a, b, normal),
            Gjk::Far(..) => return None,
            _ => {
                let (p, n) = last.unwrap_or_else(|| push_out((a, ra), (b, rb), &w.pose));
                return hit(t, p, n);
            }
        };
        axis = n;
        let p = (pa + n * ra + pb - n * rb) * 0.5;
        let slope = motion.dot(n);
        if slope >= 0.0 {
            return None;
        }
        last = Some((p, n));
        let next = t - d / slope;
        if next > max_t {
            return None;
        }
        if d <= tolerance || next <= t {
            return hit(next, pa + n * ra, n);
        }
        t = next;
    }
    last.and_then(|(p, n)| hit(t, p, n))
}

fn plane(
    n: Vec3,
    offset: f32,
    core: &Core,
    radius: f32,
    pose: &Pose,
    motion: Vec3,
    max_t: f32,
) -> Option<CastHit> {
    let low = pose.transform_point(core.support(pose.q.inverse_rotate(-n))) - n * radius;
    let s = n.dot(low) - offset;
    let slope = n.dot(motion);
    let t = if s <= 0.0 { 0.0 } else { -s / slope };
    // A motion along or away from the plane never meets it (t negative, infinite or NaN).
    (t >= 0.0 && t <= max_t).then(|| {
        let p = low + motion * t;
        CastHit { t, point: p - n * (n.dot(p) - offset), normal: n, sub_a: NO_SUB, sub_b: NO_SUB }
    })
}

/// The earlier; of equals the one with the lower part of A.
fn earlier(best: &Option<CastHit>, h: &CastHit) -> bool {
    best.is_none_or(|b| h.t < b.t || (h.t == b.t && h.sub_a < b.sub_a))
}

fn surface(
    a: &Surface,
    b: &Shape,
    core: (Core, f32),
    pose: &Pose,
    motion: Vec3,
    max_t: f32,
) -> Option<CastHit> {
    let mut best: Option<CastHit> = None;
    let bounds = b.aabb(pose);
    a.sweep(&bounds, motion, max_t, |index, bound| {
        let Some(t) = a.corners(index) else { return bound };
        match cores((Core::Triangle(t), 0.0), core, pose, motion, bound) {
            Some(h) => {
                let h = CastHit { sub_a: a.name(index), ..h };
                if earlier(&best, &h) {
                    best = Some(h);
                }
                f32s::min(h.t, bound)
            }
            None => bound,
        }
    });
    best
}

fn compound(a: &Compound, b: &Shape, pose: &Pose, motion: Vec3, max_t: f32) -> Option<CastHit> {
    let mut best: Option<CastHit> = None;
    let bounds = b.aabb(pose);
    a.tree.ray(bounds.center(), motion, bounds.half(), max_t, |index, bound| {
        let Some((frame, child)) = a.children().get(index as usize) else { return bound };
        let local = frame.q.inverse_rotate(motion);
        match cast(child, b, &frame.relative(pose), local, bound) {
            Some(h) => {
                let h = CastHit {
                    t: h.t,
                    point: frame.transform_point(h.point),
                    normal: frame.q.rotate(h.normal),
                    sub_a: index,
                    sub_b: h.sub_b,
                };
                if earlier(&best, &h) {
                    best = Some(h);
                }
                f32s::min(h.t, bound)
            }
            None => bound,
        }
    });
    best
}
