//! When a moving and turning shape comes within a distance of another.
//!
//! At time t the closest points give a direction n that separates the shapes by their distance. The gap along that fixed n,
//! f(τ) = min over B(τ) of n·x − max over A of n·x, bounds the distance from below at every later τ. So nothing happens
//! before the first τ where f falls to the target; t moves there and the closest points are asked again. Each round costs
//! one GJK and some support points, and a body that rolls along a plane at a constant height is done in one.
//!
//! f is looked at in steps of the rotation (the lowest point of a turning body can dip in between), then its root is
//! bracketed from the side where the gap is still larger than the target.
//!
//! E. Catto, "Continuous collision", GDC 2013 (bilateral advancement).

use super::core::Core;
use super::distance::cores;
use super::{Sweep, TimeOfImpact};
use crate::limits::CAST_ITERATIONS_MAX;
use crate::pairs::{Surface, SweptSieve};
use crate::shapes::compound::Compound;
use crate::{Aabb, Shape};
use jounce_math::{Pose, Vec3, scalar::f32s};

/// Most looks at the gap over one interval; one for each 5° or so of rotation.
const LOOKS_MAX: usize = 32;
/// Most halvings of a bracket.
const BRACKET_ITERATIONS_MAX: usize = 32;

/// First time at which B (convex or a compound), moving along `sweep` in A's frame, comes to the distance `target` ±
/// `tolerance` of A (both positive, metres). Parts of A or B that start nearer than that are left out where there
/// are others; triangles of a one-sided surface that B's centre is behind do not count.
pub fn time_of_impact(a: &Shape, b: &Shape, sweep: &Sweep, target: f32, tolerance: f32) -> TimeOfImpact {
    let finite = sweep.local_center.is_finite()
        && sweep.center.iter().all(|c| c.is_finite())
        && sweep.rotation.iter().all(|q| q.is_finite());
    if !finite {
        return TimeOfImpact::Failed(0.0);
    }
    impact(a, b, sweep, target, tolerance, 1.0)
}

fn impact(a: &Shape, b: &Shape, sweep: &Sweep, target: f32, tolerance: f32, max_t: f32) -> TimeOfImpact {
    if let Shape::Compound(c) = b {
        let mut first = First::new(max_t);
        for (frame, child) in c.children() {
            let part = Sweep {
                local_center: frame.inverse_transform_point(sweep.local_center),
                center: sweep.center,
                rotation: sweep.rotation.map(|q| q * frame.q),
            };
            first.add(impact(a, child, &part, target, tolerance, first.max_t));
        }
        return first.answer();
    }
    let Some(core) = Core::of(b) else { return TimeOfImpact::Separated };
    let moving = Moving { core, sweep, target, tolerance };
    match a {
        Shape::HalfSpace { normal, offset } => moving.plane(*normal, *offset, max_t),
        Shape::Mesh(m) => moving.surface(&Surface::Mesh(m), b, max_t),
        Shape::HeightField(h) => moving.surface(&Surface::HeightField(h), b, max_t),
        Shape::Compound(c) => compound(c, b, sweep, target, tolerance, max_t),
        _ => Core::of(a).map_or(TimeOfImpact::Separated, |a| moving.convex(a, max_t)),
    }
}

/// The earliest of several results.
struct First {
    max_t: f32,
    hit: Option<TimeOfImpact>,
    overlapped: bool,
}

impl First {
    fn new(max_t: f32) -> Self {
        Self { max_t, hit: None, overlapped: false }
    }
    fn add(&mut self, r: TimeOfImpact) {
        match r {
            TimeOfImpact::Hit(t) | TimeOfImpact::Failed(t) => {
                if t < self.max_t || self.hit.is_none() {
                    self.max_t = t;
                    self.hit = Some(r);
                }
            }
            TimeOfImpact::Overlapped => self.overlapped = true,
            TimeOfImpact::Separated => {}
        }
    }
    fn answer(&self) -> TimeOfImpact {
        match self.hit {
            Some(r) => r,
            None if self.overlapped => TimeOfImpact::Overlapped,
            None => TimeOfImpact::Separated,
        }
    }
}

fn compound(a: &Compound, b: &Shape, sweep: &Sweep, target: f32, tolerance: f32, max_t: f32) -> TimeOfImpact {
    let mut first = First::new(max_t);
    let (start, motion, _) = swept_bounds(sweep, b, target + tolerance);
    let swept = start.union(&Aabb::new(start.min + motion, start.max + motion));
    for (frame, child) in a.children() {
        if !child.aabb(frame).overlaps(&swept) {
            continue;
        }
        let part = Sweep {
            local_center: sweep.local_center,
            center: sweep.center.map(|c| frame.inverse_transform_point(c)),
            rotation: sweep.rotation.map(|q| frame.q.inverse_mul(q)),
        };
        first.add(impact(child, b, &part, target, tolerance, first.max_t));
    }
    first.answer()
}

/// A box and its way that cover all of B's positions; and how far a point may be off the chord of its turn.
///
/// About the centre of mass each point moves on an arc of the angle θ; between its ends it leaves the chord by no more than
/// r (1 − cos θ/2), with r its distance. So the boxes of the two rotations, and that much around them.
pub(super) fn swept_bounds(sweep: &Sweep, b: &Shape, margin: f32) -> (Aabb, Vec3, f32) {
    let [from, to] = sweep.center;
    let about = sweep.rotation.map(|q| b.aabb(&Pose::new(-q.rotate(sweep.local_center), q)));
    let cosine = f32s::min(sweep.rotation[0].dot(sweep.rotation[1]).abs(), 1.0);
    let sagitta = b.outer_radius(sweep.local_center) * (1.0 - cosine);
    let turned = about[0].union(&about[1]).expanded(margin + sagitta);
    (Aabb::new(turned.min + from, turned.max + from), to - from, sagitta)
}

struct Moving<'a> {
    core: (Core<'a>, f32),
    sweep: &'a Sweep,
    target: f32,
    tolerance: f32,
}

impl Moving<'_> {
    /// Gap between B at time `t` and the plane n · x = `offset`.
    fn gap(&self, n: Vec3, offset: f32, t: f32) -> f32 {
        let pose = self.sweep.pose(t);
        let low = pose.transform_point(self.core.0.support(pose.q.inverse_rotate(-n)));
        n.dot(low) - self.core.1 - offset
    }

    /// Steps in which to look at the gap.
    fn looks(&self) -> usize {
        let [p, q] = self.sweep.rotation;
        // Sine of half the angle between the rotations; the sign of a quaternion is no rotation.
        let d = p.dot(q);
        let sine = f32s::max(1.0 - d * d, 0.0).sqrt();
        (1 + (sine * 24.0) as usize).min(LOOKS_MAX)
    }

    /// The last time from `t` on, up to `max_t`, before the gap along `n` falls below the target: `None` if it never
    /// does.
    fn advance(&self, n: Vec3, offset: f32, t: f32, max_t: f32) -> Option<f32> {
        let looks = self.looks();
        let (mut lo, mut gap_lo) = (t, self.gap(n, offset, t));
        for k in 1..=looks {
            let hi = if k == looks { max_t } else { t + (max_t - t) * (k as f32 / looks as f32) };
            let gap_hi = self.gap(n, offset, hi);
            if gap_hi < self.target {
                return Some(self.bracket(n, offset, (lo, gap_lo), (hi, gap_hi)));
            }
            (lo, gap_lo) = (hi, gap_hi);
        }
        None
    }

    /// A time between `lo` (gap ≥ target) and `hi` (gap < target) where the gap is the target, from above.
    fn bracket(&self, n: Vec3, offset: f32, (lo, gap_lo): (f32, f32), (hi, gap_hi): (f32, f32)) -> f32 {
        let (mut lo, mut gap_lo, mut hi, mut gap_hi) = (lo, gap_lo, hi, gap_hi);
        // Between target and target + tolerance is found.
        let goal = self.target + 0.5 * self.tolerance;
        for k in 0..BRACKET_ITERATIONS_MAX {
            if gap_lo <= self.target + self.tolerance {
                break;
            }
            let secant = lo + (hi - lo) * ((gap_lo - goal) / (gap_lo - gap_hi));
            let mid = if k % 2 == 0 { secant } else { 0.5 * (lo + hi) };
            if !(mid > lo && mid < hi) {
                break;
            }
            let g = self.gap(n, offset, mid);
            if g >= self.target { (lo, gap_lo) = (mid, g) } else { (hi, gap_hi) = (mid, g) }
        }
        lo
    }

    fn plane(&self, n: Vec3, offset: f32, max_t: f32) -> TimeOfImpact {
        if self.gap(n, offset, 0.0) <= self.target + self.tolerance {
            return TimeOfImpact::Overlapped;
        }
        self.advance(n, offset, 0.0, max_t).map_or(TimeOfImpact::Separated, TimeOfImpact::Hit)
    }

    fn convex(&self, a: (Core, f32), max_t: f32) -> TimeOfImpact {
        self.convex_along(a, max_t).0
    }

    /// And the direction from A to B that was looked at last.
    fn convex_along(&self, a: (Core, f32), max_t: f32) -> (TimeOfImpact, Vec3) {
        let (mut t, mut n) = (0.0, Vec3::ZERO);
        for round in 0..CAST_ITERATIONS_MAX {
            let pose: Pose = self.sweep.pose(t);
            let Some(d) = cores(a, self.core, &pose, f32::MAX) else { return (TimeOfImpact::Failed(t), n) };
            n = d.normal;
            if d.distance <= self.target + self.tolerance {
                return (if round == 0 { TimeOfImpact::Overlapped } else { TimeOfImpact::Hit(t) }, n);
            }
            let offset = n.dot(a.0.support(n)) + a.1;
            match self.advance(n, offset, t, max_t) {
                None => return (TimeOfImpact::Separated, n),
                // No progress in these digits: as near as it gets.
                Some(next) if next <= t => return (TimeOfImpact::Hit(t), n),
                Some(next) => t = next,
            }
        }
        (TimeOfImpact::Failed(t), n)
    }

    /// The normal of a triangle in front of which all of B stays. Most that are near are passed over so, without a look at their edges.
    fn in_front(&self, a: &Surface, index: u32, t: &[Vec3; 3], start: Vec3, max_t: f32) -> Option<Vec3> {
        let n = a.normal(index)?;
        let n = if n.dot(start - t[0]) < 0.0 { -n } else { n };
        let offset = n.dot(t[0]);
        // The plane of a sliver is only as good as its normal.
        let slack = f32s::max(n.dot(t[1] - t[0]).abs(), n.dot(t[2] - t[0]).abs());
        let stays = self.gap(n, offset + slack, 0.0) > self.target + self.tolerance
            && self.advance(n, offset + slack, 0.0, max_t).is_none();
        stays.then_some(n)
    }

    fn surface(&self, a: &Surface, b: &Shape, max_t: f32) -> TimeOfImpact {
        let mut first = First::new(max_t);
        let near = self.target + self.tolerance;
        let (bounds, motion, sagitta) = swept_bounds(self.sweep, b, near);
        let start = self.sweep.pose(0.0).transform_point(self.core.0.center());
        let (core, radius) = self.core;
        let mut sieve = SweptSieve::new(core, self.sweep, radius + near, sagitta, &a.bounds());
        a.sweep(&bounds, motion, max_t, |index, bound| {
            let Some(t) = a.corners(index).filter(|t| sieve.passes(t) && a.faces(index, t, start)) else {
                return bound;
            };
            if let Some(n) = self.in_front(a, index, &t, start, bound) {
                sieve.learn(n);
                return bound;
            }
            let (r, n) = self.convex_along((Core::Triangle(t), 0.0), bound);
            if r == TimeOfImpact::Separated {
                sieve.learn(n);
            }
            first.add(r);
            f32s::min(first.max_t, bound)
        });
        first.answer()
    }
}
