//! The nearest point that a few planes allow.
//!
//! min |x − d|² subject to n_i·x ≥ b_i. In space at most three constraints are active at the optimum, so it is one of: d itself; d
//! projected onto a plane, onto the line of two planes, onto the point of three. Of those that all planes allow the nearest to d
//! wins. With few planes to try this is exact, where sweeps over the planes (Box3D's plane solver, Quake's clip planes) stop early
//! in narrow corners.

use jounce_math::{Vec3, scalar::f32s};

/// n·x ≥ least.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Plane {
    pub n: Vec3,
    pub least: f32,
}

/// Planes considered at once.
pub(crate) const PLANES_MAX: usize = 12;

/// Two directions whose sine squared is below this are one.
const PARALLEL: f32 = 1e-5;

/// The best point so far: what it violates, then how far from the wanted it is.
struct Best<'a> {
    want: Vec3,
    planes: &'a [Plane],
    slack: f32,
    found: (f32, f32, Vec3),
}

impl Best<'_> {
    fn offer(&mut self, x: Vec3) {
        let mut worst = 0.0;
        for p in self.planes {
            worst = f32s::max(worst, p.least - p.n.dot(x));
        }
        let bad = if worst <= self.slack { 0.0 } else { worst };
        let far = (x - self.want).length_squared();
        if bad < self.found.0 || (bad == self.found.0 && far < self.found.1) {
            self.found = (bad, far, x);
        }
    }
}

/// The point, and by how much the worst plane is violated where they contradict each other (else 0).
pub(crate) fn nearest(want: Vec3, planes: &[Plane]) -> (Vec3, f32) {
    let planes = &planes[..planes.len().min(PLANES_MAX)];
    let reach = planes.iter().fold(want.length(), |m, p| f32s::max(m, p.least.abs()));
    let mut best = Best { want, planes, slack: 1e-5 * reach, found: (f32::MAX, f32::MAX, Vec3::ZERO) };
    best.offer(want);
    if best.found.0 == 0.0 {
        return (want, 0.0);
    }
    for (i, a) in planes.iter().enumerate() {
        let ra = a.least - a.n.dot(want);
        best.offer(want + a.n * ra);
        for (j, b) in planes.iter().enumerate().skip(i + 1) {
            let rb = b.least - b.n.dot(want);
            let c = a.n.dot(b.n);
            let det = 1.0 - c * c;
            if det < PARALLEL {
                continue;
            }
            best.offer(want + a.n * ((ra - c * rb) / det) + b.n * ((rb - c * ra) / det));
            let line = a.n.cross(b.n);
            for p in &planes[j + 1..] {
                let det = line.dot(p.n);
                if det * det < PARALLEL {
                    continue;
                }
                let x = line * p.least + b.n.cross(p.n) * a.least + p.n.cross(a.n) * b.least;
                best.offer(x * (1.0 / det));
            }
        }
    }
    (best.found.2, best.found.0)
}
