//! Slabs around a convex shape. A triangle beyond one of them is apart from the shape; most that are near it are found to be so here,
//! without a look at their features.

use crate::Aabb;
use crate::convex::Sweep;
use crate::convex::core::Core;
use jounce_math::{Pose, Vec3, scalar::f32s};

/// Directions abreast.
const WIDE: usize = 4;
/// Most directions: of a hull with more faces only so many are asked.
const DIRECTIONS_MAX: usize = 16;
/// Directions that a sweep remembers.
const LEARNED: usize = 16;
/// Room for rounding, in the largest coordinate at hand.
const SLACK: f32 = 2e-6;
/// Half of √3.
const SIDE: f32 = 0.866_025_4;

/// x, y, z of unit directions, and how far along them the shape reaches.
type Block = [[f32; WIDE]; 4];

/// One of them.
pub(super) type Direction = [f32; 4];

/// No direction.
const NONE: Block = [[0.0; WIDE], [0.0; WIDE], [0.0; WIDE], [f32::INFINITY; WIDE]];

/// A shape's reach along its own face normals, in the surface's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sieve {
    blocks: [Block; DIRECTIONS_MAX / WIDE],
    used: usize,
}

/// Those of a [`Sieve`], one by one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Directions {
    all: [Direction; DIRECTIONS_MAX],
    used: usize,
}

impl Directions {
    pub fn all(&self) -> &[Direction] {
        &self.all[..self.used]
    }
}

impl Sieve {
    /// Around `core` and all within `reach` (its radius included) of it.
    pub fn new(core: &Core, pose: &Pose, reach: f32, surface: &Aabb) -> Self {
        let more = reach + slack(surface, core, pose.p.abs().max_component());
        Self::with(core, |d, far| {
            let n = pose.q.rotate(d);
            let far = far.unwrap_or_else(|| d.dot(core.support(d)));
            (n, far + n.dot(pose.p) + more)
        })
    }

    /// From a direction of the core's own, and how far it reaches along that where that is known, to the slab there.
    fn with(core: &Core, slab: impl Fn(Vec3, Option<f32>) -> (Vec3, f32)) -> Self {
        let mut s = Self { blocks: [NONE; DIRECTIONS_MAX / WIDE], used: 0 };
        let mut put = |i: usize, d: Vec3, far: Option<f32>| {
            set(&mut s.blocks[i / WIDE], i % WIDE, slab(d, far));
            s.used = i / WIDE + 1;
        };
        match core {
            Core::Hull(h) => {
                let count = h.faces.len().min(DIRECTIONS_MAX);
                for i in 0..count {
                    let f = i * h.faces.len() / count;
                    put(i, h.faces[f].normal, Some(h.reaches[f]));
                }
            }
            Core::Box(_) => {
                let axes = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
                axes.into_iter().enumerate().for_each(|(i, d)| put(i, d, None));
            }
            Core::Segment(_) | Core::Cylinder(..) | Core::Cone(..) => {
                let around =
                    [(1.0, 0.0), (0.5, SIDE), (-0.5, SIDE), (-1.0, 0.0), (-0.5, -SIDE), (0.5, -SIDE)];
                let around = around.map(|(x, z)| Vec3::new(x, 0.0, z));
                let all = [Vec3::Y, -Vec3::Y].into_iter().chain(around);
                all.enumerate().for_each(|(i, d)| put(i, d, None));
            }
            Core::Point | Core::Triangle(_) => {}
        }
        s
    }

    /// The directions one by one, with their limits.
    pub(super) fn directions(&self) -> Directions {
        let mut d = Directions { all: [[0.0; 4]; DIRECTIONS_MAX], used: 0 };
        for [x, y, z, limit] in &self.blocks[..self.used] {
            for i in (0..WIDE).filter(|&i| limit[i] < f32::INFINITY) {
                d.all[d.used] = [x[i], y[i], z[i], limit[i]];
                d.used += 1;
            }
        }
        d
    }

    /// May a contact lie on the triangle of normal `n`, under which the shape is at most `deep`? Points of the shape that are above the
    /// triangle's inside count for it however deep they are; under a face that leans over the triangle those are more than what is within
    /// reach.
    #[inline]
    pub fn passes(&self, t: &[Vec3; 3], n: Vec3, deep: f32) -> bool {
        self.blocks[..self.used].iter().all(|block| {
            let [x, y, z, limit] = block;
            let mut apart = 0_u32;
            for i in 0..WIDE {
                let h = |p: Vec3| x[i] * p.x + y[i] * p.y + z[i] * p.z;
                let low = f32s::min(f32s::min(h(t[0]), h(t[1])), h(t[2]));
                let lean = deep * f32s::max(h(n), 0.0);
                apart |= u32::from(low - lean > limit[i]);
            }
            apart == 0
        })
    }
}

/// The same for a shape that moves: around all its places. It learns directions that parted it from a triangle; they part it from
/// neighbours too.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SweptSieve<'a> {
    own: Sieve,
    learned: [Block; LEARNED / WIDE],
    next: usize,
    core: Core<'a>,
    sweep: &'a Sweep,
    more: f32,
}

impl<'a> SweptSieve<'a> {
    /// All within `reach` (the radius included) of the moving core counts, where no point leaves the chord of its turn by more than
    /// `sagitta`.
    pub fn new(core: Core<'a>, sweep: &'a Sweep, reach: f32, sagitta: f32, surface: &Aabb) -> Self {
        let [from, to] = sweep.center;
        let far = f32s::max(from.abs().max_component(), to.abs().max_component());
        let more = reach + sagitta + slack(surface, &core, far + sweep.local_center.length());
        let q0 = sweep.rotation[0];
        let own = Sieve::with(&core, |d, _| {
            let n = q0.rotate(d);
            (n, swept_reach(&core, sweep, n) + more)
        });
        Self { own, learned: [NONE; LEARNED / WIDE], next: 0, core, sweep, more }
    }

    /// May any place of the shape be within reach of the triangle?
    #[inline]
    pub fn passes(&self, t: &[Vec3; 3]) -> bool {
        self.learned.iter().all(|b| passes(b, t))
            && self.own.blocks[..self.own.used].iter().all(|b| passes(b, t))
    }

    /// Does `n` (unit), from the triangle to the shape, part them? Then it is remembered.
    pub fn parts(&mut self, t: &[Vec3; 3], n: Vec3) -> bool {
        let limit = swept_reach(&self.core, self.sweep, -n) + self.more;
        let parts = t.iter().all(|&p| -n.dot(p) > limit);
        if parts {
            self.remember(-n, limit);
        }
        parts
    }

    /// Remembers that `n` (unit) pointed from a triangle to the shape and parted them.
    pub fn learn(&mut self, n: Vec3) {
        let limit = swept_reach(&self.core, self.sweep, -n) + self.more;
        self.remember(-n, limit);
    }

    fn remember(&mut self, d: Vec3, limit: f32) {
        let at = self.next % LEARNED;
        set(&mut self.learned[at / WIDE], at % WIDE, (d, limit));
        self.next += 1;
    }
}

/// How far the core's two places reach along `n`, and all that lies between their chords.
fn swept_reach(core: &Core, sweep: &Sweep, n: Vec3) -> f32 {
    let [start, end] = [0, 1].map(|k| {
        let d = sweep.rotation[k].inverse_rotate(n);
        (d.dot(core.support(d) - sweep.local_center), n.dot(sweep.center[k]))
    });
    f32s::max(start.0, end.0) + f32s::max(start.1, end.1)
}

#[inline]
fn passes([x, y, z, limit]: &Block, t: &[Vec3; 3]) -> bool {
    let mut apart = 0_u32;
    for i in 0..WIDE {
        let h = |p: Vec3| x[i] * p.x + y[i] * p.y + z[i] * p.z;
        let low = f32s::min(f32s::min(h(t[0]), h(t[1])), h(t[2]));
        apart |= u32::from(low > limit[i]);
    }
    apart == 0
}

fn set(block: &mut Block, lane: usize, (n, limit): (Vec3, f32)) {
    for (lanes, x) in block.iter_mut().zip([n.x, n.y, n.z, limit]) {
        lanes[lane] = x;
    }
}

fn slack(surface: &Aabb, core: &Core, far: f32) -> f32 {
    SLACK * (surface.min.abs().max(surface.max.abs()).max_component() + core.extent() + far)
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;
    use crate::convex::distance::cores;
    use crate::{Hull, Shape};
    use std::sync::Arc;

    fn shapes() -> [Shape; 6] {
        let mut r = Random(3);
        let points: Vec<Vec3> = (0..60).map(|_| r.vec()).collect();
        [
            Shape::Sphere { radius: 0.5 },
            Shape::Capsule { half_height: 0.7, radius: 0.3 },
            Shape::Box { half: Vec3::new(0.3, 0.5, 1.0) },
            Shape::Cylinder { half_height: 0.6, radius: 0.4 },
            Shape::Cone { half_height: 0.6, radius: 0.4 },
            Shape::Hull(Arc::new(Hull::new(&points).expect("a hull"))),
        ]
    }

    /// What a moving shape's sieve drops is never within reach, and of what is out of reach it drops most.
    #[test]
    fn a_swept_sieve_drops_only_what_stays_apart() {
        let mut r = Random(1);
        let far = Aabb::from_center(Vec3::ZERO, Vec3::splat(5.0));
        let (mut dropped, mut apart) = (0, 0);
        for shape in shapes() {
            let (core, radius) = Core::of(&shape).expect("convex");
            for _ in 0..300 {
                let local_center = r.vec();
                let center = [r.vec(), r.vec()];
                let q = r.quat(3.0);
                let sweep = Sweep { local_center, center, rotation: [q, r.quat(0.6) * q] };
                let cosine = f32s::min(sweep.rotation[0].dot(sweep.rotation[1]).abs(), 1.0);
                let sagitta = shape.outer_radius(local_center) * (1.0 - cosine);
                let mut sieve = SweptSieve::new(core, &sweep, radius + 0.01, sagitta, &far);
                for _ in 0..10 {
                    sieve.learn(r.vec().normalize_or(Vec3::Y));
                }
                for _ in 0..10 {
                    let at = r.vec() * 3.0;
                    let t = [at, at + r.vec(), at + r.vec()];
                    let near = (0..=40).map(|k| {
                        let pose = sweep.pose(k as f32 / 40.0);
                        let d = cores((Core::Triangle(t), 0.0), (core, radius), &pose, f32::MAX);
                        d.map_or(0.0, |d| d.distance)
                    });
                    let near = near.fold(f32::MAX, f32s::min);
                    let passes = sieve.passes(&t);
                    assert!(passes || near > 0.01, "{shape:?}: {near} {sweep:?} {t:?}");
                    apart += usize::from(near > 0.01);
                    dropped += usize::from(!passes);
                }
            }
        }
        assert!(2 * dropped > apart, "{dropped} of {apart}");
    }

    /// A triangle under a shape that is `deep` in its plane passes if any point of the shape is over its inside and not farther than the reach.
    #[test]
    fn what_is_over_a_triangle_passes() {
        let mut r = Random(2);
        let far = Aabb::from_center(Vec3::ZERO, Vec3::splat(5.0));
        let (mut dropped, mut over) = (0, 0);
        for shape in shapes() {
            let (core, radius) = Core::of(&shape).expect("convex");
            for _ in 0..2000 {
                let pose = Pose::new(r.vec(), r.quat(3.0));
                let sieve = Sieve::new(&core, &pose, radius + 0.01, &far);
                let at = r.vec() * 2.0;
                let mut t = [at, at + r.vec(), at + r.vec()];
                let Some((n, _)) = (t[1] - t[0]).cross(t[2] - t[0]).try_normalize() else { continue };
                let center = pose.transform_point(core.center());
                let n = if n.dot(center - at) < 0.0 { -n } else { n };
                t.swap(1, 2);
                let low = n.dot(pose.transform_point(core.support(pose.q.inverse_rotate(-n))) - at);
                let deep = f32s::max(radius - low, 0.0);
                assert!(deep <= core.reach() + radius + 1e-5, "{shape:?}");
                let passes = sieve.passes(&t, n, deep);
                dropped += usize::from(!passes);
                for _ in 0..20 {
                    // Points of the core: between its centre and a support point.
                    let point =
                        center.lerp(pose.transform_point(core.support(r.vec())), 0.5 + 0.5 * r.next());
                    let height = n.dot(point - at);
                    let foot = point - n * height;
                    let inside = (crate::shapes::triangle::closest_point(&t, foot) - foot).length() < 1e-6;
                    if inside && height <= radius + 0.01 {
                        over += 1;
                        assert!(passes, "{shape:?} {pose:?} {t:?}");
                        assert!(sieve.passes(&t, n, core.reach() + radius));
                    }
                }
            }
        }
        assert!(over > 50 && dropped > 5000, "{over} over, {dropped} dropped");
    }
}
