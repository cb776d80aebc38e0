//! A ball that moves along a line: where it first touches a shape.
//!
//! Convex shapes: along a line the distance to a convex set is a convex function of the way, with slope motion · n where n
//! points from the nearest point to the ball. Newton's method from the left, t ← t − d/(motion · n), never passes the first
//! root (see `jounce_geometry::cast_shape`, which does the same for two shapes), and is exact after one step against a face.
//! Most shapes are told apart by the first distance alone. Surfaces are swept triangle by triangle.

use super::state::FREE;
use crate::limits::PARTICLE_SWEEP_ITERATIONS_MAX;
use jounce_geometry::{Aabb, Shape, closest_point_of_triangle};
use jounce_math::{Pose, Vec3, scalar::f32s};

/// First touch of a moving ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Touch {
    /// Part of the motion.
    pub t: f32,
    /// Out of the shape, unit.
    pub normal: Vec3,
    /// How deep the ball is in at the start, m.
    pub depth: f32,
}

/// The ball's radius as far as rounding lets it count, and the gap within which it touches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub radius: f32,
    pub skin: f32,
}

impl Ball {
    /// A ball this far from the origin of its coordinates.
    pub fn new(radius: f32, reach: f32) -> Self {
        // 2⁻²¹ is four units in the last place.
        let rounding = reach * (1.0 / 2_097_152.0);
        let radius = f32s::max(radius, 4.0 * rounding);
        Self { radius, skin: 1e-3 * radius + rounding }
    }
}

/// The ball starts at `from`, in the shape's frame, and moves by `motion`. A ball that touches at the start counts as
/// touching there when it goes on into the shape, or is in deeper than its skin.
///
/// `around` remembers the triangles of one surface between the sweeps of one ball.
pub(crate) fn sweep(
    (shape, slot): (&Shape, u32),
    from: Vec3,
    motion: Vec3,
    ball: Ball,
    max_t: f32,
    around: &mut Around,
) -> Option<Touch> {
    match shape {
        Shape::HalfSpace { normal, offset } => plane(*normal, *offset, from, motion, ball, max_t),
        Shape::Mesh(_) | Shape::HeightField(_) => {
            let mut best = None;
            let near = bounds(from, motion, ball);
            around.visit((shape, slot), &near, motion, |t| triangle(t, from, motion, ball, max_t, &mut best));
            best
        }
        Shape::Compound(c) => {
            let mut best: Option<Touch> = None;
            for (pose, child) in c.children() {
                let bound = best.map_or(max_t, |b| b.t);
                let (p, m) = (pose.inverse_transform_point(from), pose.q.inverse_rotate(motion));
                let hit = sweep((child, slot), p, m, ball, bound, around);
                if let Some(h) = hit.filter(|h| is_before(h, &best)) {
                    best = Some(Touch { normal: pose.q.rotate(h.normal), ..h });
                }
            }
            best
        }
        _ => convex(from, motion, ball, max_t, |p| {
            let hit = shape.closest_point(p)?;
            Some((hit.distance, hit.normal))
        }),
    }
}

/// Triangles that one call looks up and later ones use again.
const AROUND: usize = 16;

/// The triangles of a surface around a ball: a ball that rests is swept several times in one place.
#[derive(Clone, Debug)]
pub(crate) struct Around {
    /// Whose, by slot.
    of: u32,
    bounds: Aabb,
    triangles: [[Vec3; 3]; AROUND],
    count: usize,
}

impl Around {
    pub fn new() -> Self {
        let none = Vec3::ZERO;
        Self { of: FREE, bounds: Aabb::EMPTY, triangles: [[none; 3]; AROUND], count: 0 }
    }

    fn visit(
        &mut self,
        (shape, of): (&Shape, u32),
        near: &Aabb,
        motion: Vec3,
        mut f: impl FnMut(&[Vec3; 3]),
    ) {
        if self.of != of || !self.bounds.contains(near) {
            // What is left of the step after a bounce is about as long as what was before.
            let bounds = near.expanded(0.5 * motion.abs().max_component());
            self.count = 0;
            overlapping(shape, &bounds, |t| {
                if self.count < AROUND {
                    self.triangles[self.count] = *t;
                }
                self.count += 1;
            });
            (self.of, self.bounds) = (of, bounds);
        }
        if self.count > AROUND {
            overlapping(shape, near, f);
            return;
        }
        self.triangles[..self.count].iter().for_each(&mut f);
    }
}

fn overlapping(shape: &Shape, bounds: &Aabb, mut f: impl FnMut(&[Vec3; 3])) {
    match shape {
        Shape::Mesh(mesh) => mesh.overlapping(bounds, |i| f(&mesh.triangle(i))),
        Shape::HeightField(field) => field.overlapping(bounds, |i| {
            if let Some(t) = field.triangle(i) {
                f(&t);
            }
        }),
        _ => {}
    }
}

/// The earlier; at the start, the deeper.
fn is_before(h: &Touch, best: &Option<Touch>) -> bool {
    best.is_none_or(|b| h.t < b.t || (h.t == b.t && h.depth > b.depth))
}

fn bounds(from: Vec3, motion: Vec3, ball: Ball) -> Aabb {
    let to = from + motion;
    Aabb::new(from.min(to), from.max(to)).expanded(ball.radius + ball.skin)
}

/// Does a ball that touches already go on into the surface, or is it in too deep?
fn at_start(gap: f32, normal: Vec3, slope: f32, ball: Ball) -> Option<Touch> {
    let enters = gap + slope < -ball.skin || gap < -ball.skin;
    enters.then(|| Touch { t: 0.0, normal, depth: f32s::max(-gap, 0.0) })
}

pub(crate) fn plane(n: Vec3, offset: f32, from: Vec3, motion: Vec3, ball: Ball, max_t: f32) -> Option<Touch> {
    let gap = n.dot(from) - offset - ball.radius;
    let slope = n.dot(motion);
    if gap <= ball.skin {
        return at_start(gap, n, slope, ball);
    }
    let t = -gap / slope;
    (slope < 0.0 && t <= max_t).then_some(Touch { t, normal: n, depth: 0.0 })
}

/// Distance and direction from the shape come from `distance`.
#[inline]
fn convex(
    from: Vec3,
    motion: Vec3,
    ball: Ball,
    max_t: f32,
    distance: impl Fn(Vec3) -> Option<(f32, Vec3)>,
) -> Option<Touch> {
    let (d, mut n) = distance(from)?;
    let (mut gap, mut slope) = (d - ball.radius, motion.dot(n));
    if gap <= ball.skin {
        return at_start(gap, n, slope, ball);
    }
    let mut t = 0.0;
    for _ in 0..PARTICLE_SWEEP_ITERATIONS_MAX {
        if slope >= 0.0 {
            return None;
        }
        t -= gap / slope;
        if t > max_t {
            return None;
        }
        let (d, m) = distance(from + motion * t)?;
        (gap, n) = (d - ball.radius, m);
        slope = motion.dot(n);
        if gap <= 0.5 * ball.skin {
            break;
        }
    }
    Some(Touch { t, normal: n, depth: 0.0 })
}

/// Both sides of a triangle.
fn triangle(corners: &[Vec3; 3], from: Vec3, motion: Vec3, ball: Ball, max_t: f32, best: &mut Option<Touch>) {
    if stays_aside(corners, from, motion, ball) {
        return;
    }
    let bound = best.map_or(max_t, |b| b.t);
    let hit = convex(from, motion, ball, bound, |p| {
        let away = p - closest_point_of_triangle(corners, p);
        // A centre in the surface is pushed back to where it came from.
        let (n, d) = away.try_normalize().unwrap_or_else(|| {
            let n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or(Vec3::Y);
            (if n.dot(motion) > 0.0 { -n } else { n }, 0.0)
        });
        Some((d, n))
    });
    if let Some(h) = hit.filter(|h| is_before(h, best)) {
        *best = Some(h);
    }
}

/// Does the ball stay on one side of the triangle's plane, out of touch?
#[inline]
fn stays_aside([a, b, c]: &[Vec3; 3], from: Vec3, motion: Vec3, ball: Ball) -> bool {
    let n = (*b - *a).cross(*c - *a);
    let (h0, rise) = (n.dot(from - *a), n.dot(motion));
    let h1 = h0 + rise;
    // Heights times |n|.
    let reach = ball.radius + ball.skin;
    let limit = reach * reach * n.length_squared();
    (h0 > 0.0) == (h1 > 0.0) && h0 * h0 > limit && h1 * h1 > limit
}

/// Between two poses.
pub(crate) fn between(a: &Pose, b: &Pose, s: f32) -> Pose {
    Pose::new(a.p.lerp(b.p, s), a.q.nlerp(b.q, s))
}
