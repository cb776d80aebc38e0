//! Polyhedra below a plane.
//!
//! V = Σ (x − p)·A/3 over the triangles of the surface below the plane (A a triangle's area times its outward
//! normal), for any point p. With p on the plane the cut's own triangles add nothing, so they are never built. Each
//! triangle (a, b, c) seen from p is a tetrahedron of volume det/6, ∫(x − p) = det/24 (a + b + c), det = a·(b × c).
//! A closed surface has Σ A = 0: the cut's area is W = −n·Σ A over the rest. p is the point above the lowest corner, and
//! corners are reckoned from that one: the numbers of a sliver are then of the sliver's size and keep their digits.
//!
//! Faces go triangle by triangle, the fan that mass properties use: a face of a hull is flat only to rounding, and so
//! the two parts of it share one surface and add up to the whole.

use super::Part;
use crate::{Hull, limits};
use jounce_math::{DVec3, scalar::f64s};

/// A corner about p, and its height above the plane.
#[derive(Clone, Copy)]
struct Corner {
    x: DVec3,
    height: f64,
}

struct Sum {
    six_v: f64,
    first: DVec3,
    /// Twice n·Σ A.
    area: f64,
}

pub(super) fn cuboid(half: DVec3, n: DVec3, d: f64) -> Part {
    // Corner k lies on the + side of x, y, z where its bit 0, 1, 2 is set.
    const FACES: [[usize; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let lowest = DVec3::new(half.x.copysign(-n.x), half.y.copysign(-n.y), half.z.copysign(-n.z));
    let up = n * (d - n.dot(lowest));
    let corners: [Corner; 8] = core::array::from_fn(|k| {
        let side = |bit: usize, h: f64| if k & bit == 0 { -h } else { h };
        let x = DVec3::new(side(1, half.x), side(2, half.y), side(4, half.z)) - lowest - up;
        Corner { x, height: n.dot(x) }
    });
    let mut sum = Sum { six_v: 0.0, first: DVec3::ZERO, area: 0.0 };
    for f in FACES {
        let [a, b, c, e] = f.map(|k| corners[k]);
        sum.clipped(a, b, c, n);
        sum.clipped(a, c, e, n);
    }
    sum.part(lowest + up)
}

pub(super) fn hull(hull: &Hull, n: DVec3, d: f64) -> Part {
    if d > n.dot(hull.centroid) {
        // Less than half is dry: the smaller part has fewer triangles, and the larger keeps its digits.
        let dry = hull_below(hull, -n, -d);
        let whole = hull.centroid * hull.volume;
        return Part { volume: hull.volume - dry.volume, moment: whole - dry.moment, ..dry };
    }
    hull_below(hull, n, d)
}

fn hull_below(hull: &Hull, n: DVec3, d: f64) -> Part {
    let (mut lowest, mut low) = (hull.centroid, n.dot(hull.centroid));
    for v in &hull.vertices {
        let (v, height) = (v.as_dvec3(), n.dot(v.as_dvec3()));
        if height < low {
            (lowest, low) = (v, height);
        }
    }
    let up = n * (d - low);
    let mut heights = [0.0; limits::HULL_VERTICES_MAX];
    for (height, v) in heights.iter_mut().zip(&hull.vertices) {
        *height = n.dot(v.as_dvec3() - lowest - up);
    }
    let corner = |k: u16| {
        let k = usize::from(k);
        Corner { x: hull.vertices[k].as_dvec3() - lowest - up, height: heights[k] }
    };
    let mut sum = Sum { six_v: 0.0, first: DVec3::ZERO, area: 0.0 };
    for face in &hull.faces {
        let outline = hull.face_vertices(face);
        if outline.iter().all(|&k| heights[usize::from(k)] > 0.0) {
            continue;
        }
        let mut corners = outline.iter().map(|&k| corner(k));
        let (Some(a), Some(mut b)) = (corners.next(), corners.next()) else { continue };
        for c in corners {
            sum.clipped(a, b, c, n);
            b = c;
        }
    }
    sum.part(lowest + up)
}

impl Sum {
    fn part(&self, p: DVec3) -> Part {
        let volume = self.six_v / 6.0;
        Part { volume, moment: self.first * (1.0 / 24.0) + p * volume, waterplane: -0.5 * self.area }
    }

    /// Adds what of the triangle lies below the plane.
    #[inline(always)]
    fn clipped(&mut self, a: Corner, b: Corner, c: Corner, n: DVec3) {
        let below = [a, b, c].map(|p| p.height <= 0.0);
        if below == [true; 3] {
            return self.add(a.x, b.x, c.x, n);
        }
        if below == [false; 3] {
            return;
        }
        // The corner that is alone on its side comes first.
        let (a, b, c) = if below[1] == below[2] {
            (a, b, c)
        } else if below[2] == below[0] {
            (b, c, a)
        } else {
            (c, a, b)
        };
        let (on_ab, on_ca) = (meet(a, b), meet(a, c));
        if a.height <= 0.0 {
            self.add(a.x, on_ab, on_ca, n);
        } else {
            self.add(b.x, c.x, on_ab, n);
            self.add(c.x, on_ca, on_ab, n);
        }
    }

    #[inline]
    fn add(&mut self, a: DVec3, b: DVec3, c: DVec3, n: DVec3) {
        let twice_area = (b - a).cross(c - a);
        let det = a.dot(twice_area);
        self.six_v += det;
        self.first += (a + b + c) * det;
        self.area += n.dot(twice_area);
    }
}

/// Where an edge meets the plane, always reckoned from its end below, so that both its faces get the same bits.
#[inline(always)]
fn meet(a: Corner, b: Corner) -> DVec3 {
    let (low, high) = if a.height <= 0.0 { (a, b) } else { (b, a) };
    low.x + (high.x - low.x) * f64s::min(low.height / (low.height - high.height), 1.0)
}
