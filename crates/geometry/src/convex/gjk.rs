//! Distance of two convex cores by GJK.
//!
//! The Minkowski difference is W = {a − b}; the closest point v of W to the origin gives the distance |v| and,
//! through the barycentric weights of its simplex, the closest points. Each round adds the support point
//! w = s_A(−v) − s_B(v) and keeps the smallest sub-simplex that holds the new v. v·w/|v| is a lower bound
//! of the distance, so the loop ends when |v|² − v·w is small against |v|².
//!
//! Support points are `f32`; simplex arithmetic is `f64`, which removes the cancellation that makes
//! single-precision GJK cycle on thin simplices.
//!
//! E. G. Gilbert, D. W. Johnson, S. S. Keerthi, "A fast procedure for computing the distance between complex
//! objects", 1988; sub-simplex tests after C. Ericson, "Real-Time Collision Detection", 2005, ch. 5.

use super::core::Core;
use crate::limits::GJK_ITERATIONS_MAX;
use jounce_math::{DVec3, Pose, Vec3};

/// A support point of the Minkowski difference and the two points that made it (A's frame).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Vertex {
    pub w: DVec3,
    pub a: Vec3,
    pub b: Vec3,
}

/// Up to four vertices and the weights of the point nearest to the origin.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Simplex {
    pub vertices: [Vertex; 4],
    pub weights: [f64; 4],
    pub count: usize,
}

/// What GJK found.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Gjk {
    /// Farther apart than asked for: the direction A to B that separates them, and by how much at least.
    Far(Vec3, f32),
    /// Apart, with the closest points and the unit direction from A to B.
    Apart { distance: f32, a: Vec3, b: Vec3, normal: Vec3 },
    /// The cores touch or overlap; the simplex holds the origin (or is degenerate beside it).
    Overlap(Simplex),
}

/// Both cores, B placed in A's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Difference<'a> {
    pub a: Core<'a>,
    pub b: Core<'a>,
    pub pose: Pose,
}

impl Difference<'_> {
    /// The support point of A − B along `d`.
    #[inline]
    pub fn support(&self, d: Vec3) -> Vertex {
        let a = self.a.support(d);
        let b = self.pose.transform_point(self.b.support(self.pose.q.inverse_rotate(-d)));
        Vertex { w: a.as_dvec3() - b.as_dvec3(), a, b }
    }

    /// Distance, started from `axis` (a guess of the direction A to B; zero for none), given up beyond
    /// `max_distance`.
    pub fn gjk(&self, axis: Vec3, max_distance: f32) -> Gjk {
        let mut s = Simplex::default();
        let start = if axis.length_squared() > 0.0 { axis } else { self.pose.p };
        let start = start.normalize_or(Vec3::X);
        let first = self.support(start);
        // Last time's direction most likely separates them still.
        let gap = -start.as_dvec3().dot(first.w);
        if gap > f64::from(max_distance) {
            return Gjk::Far(start, gap as f32);
        }
        s.vertices[0] = first;
        s.weights[0] = 1.0;
        s.count = 1;
        let mut v = first.w;
        let mut size = v.length();
        for _ in 0..GJK_ITERATIONS_MAX {
            let vv = v.length_squared();
            // The support points carry f32 rounding: nearer than that is touching.
            let noise = size * 1e-7;
            if s.count == 4 || vv <= noise * noise {
                return Gjk::Overlap(s);
            }
            let length = vv.sqrt();
            let p = self.support(-(v / length).as_vec3());
            let vw = v.dot(p.w);
            if vw > f64::from(max_distance) * length {
                return Gjk::Far(-(v / length).as_vec3(), (vw / length) as f32);
            }
            let reach = p.w.length();
            size = if reach > size { reach } else { size };
            let known = s.vertices[..s.count].iter().any(|q| q.w == p.w);
            if known || vv - vw <= vv * 1e-7 + length * noise {
                break;
            }
            s.vertices[s.count] = p;
            s.count += 1;
            let (weights, next) = s.nearest();
            if weights[..s.count].iter().filter(|&&k| k > 0.0).count() < 4 && next.length_squared() >= vv {
                // No progress left in these digits.
                s.count -= 1;
                break;
            }
            s.keep(&weights);
            v = next;
        }
        if s.count == 4 {
            return Gjk::Overlap(s);
        }
        s.apart(v, max_distance)
    }
}

impl Simplex {
    fn apart(&self, v: DVec3, max_distance: f32) -> Gjk {
        let length = v.length();
        let Some((n, _)) = (-v).try_normalize() else { return Gjk::Overlap(*self) };
        if length > f64::from(max_distance) {
            return Gjk::Far(n.as_vec3(), length as f32);
        }
        let (mut a, mut b) = (DVec3::ZERO, DVec3::ZERO);
        for i in 0..self.count {
            a += self.vertices[i].a.as_dvec3() * self.weights[i];
            b += self.vertices[i].b.as_dvec3() * self.weights[i];
        }
        Gjk::Apart { distance: length as f32, a: a.as_vec3(), b: b.as_vec3(), normal: n.as_vec3() }
    }

    /// The nearest point to the origin, and the weights that make it, positive for the smallest sub-simplex that holds it. All
    /// four are only where they enclose the origin.
    fn nearest(&self) -> Nearest {
        let w = self.vertices.map(|v| v.w);
        match self.count {
            1 => ([1.0, 0.0, 0.0, 0.0], w[0]),
            2 => segment(&w, 0, 1),
            3 => triangle(&w, 0, 1, 2),
            _ => tetrahedron(&w),
        }
    }

    /// Keeps the vertices of positive weight.
    fn keep(&mut self, weights: &[f64; 4]) {
        let mut count = 0;
        for i in 0..self.count {
            if weights[i] > 0.0 {
                self.vertices[count] = self.vertices[i];
                self.weights[count] = weights[i];
                count += 1;
            }
        }
        self.count = count;
    }
}

type Nearest = ([f64; 4], DVec3);

fn segment(w: &[DVec3; 4], i: usize, j: usize) -> Nearest {
    let mut k = [0.0; 4];
    let d = w[j] - w[i];
    let dd = d.length_squared();
    let t = -w[i].dot(d);
    if t <= 0.0 || dd <= 0.0 {
        k[i] = 1.0;
        return (k, w[i]);
    }
    if t >= dd {
        k[j] = 1.0;
        return (k, w[j]);
    }
    let t = t / dd;
    k[i] = 1.0 - t;
    k[j] = t;
    (k, w[i] + d * t)
}

/// Nearest of the triangle's three edges.
fn edges(w: &[DVec3; 4], i: usize, j: usize, k: usize) -> Nearest {
    let mut best = segment(w, i, j);
    for e in [segment(w, j, k), segment(w, k, i)] {
        if e.1.length_squared() < best.1.length_squared() {
            best = e;
        }
    }
    best
}

fn triangle(w: &[DVec3; 4], i: usize, j: usize, k: usize) -> Nearest {
    let (a, b, c) = (w[i], w[j], w[k]);
    let (ab, ac) = (b - a, c - a);
    let n = ab.cross(ac);
    let nn = n.length_squared();
    let longest = {
        let (x, y, z) = (ab.length_squared(), ac.length_squared(), (c - b).length_squared());
        let m = if x > y { x } else { y };
        if m > z { m } else { z }
    };
    // Height below 1e-10 of the longest edge: the plane is noise and the edges hold every answer.
    if nn <= longest * longest * 1e-20 {
        return edges(w, i, j, k);
    }
    // Twice the signed areas of the sub-triangles opposite to a, b, c, times |n|.
    let u = n.dot(b.cross(c));
    let v = n.dot(c.cross(a));
    let t = n.dot(a.cross(b));
    if u > 0.0 && v > 0.0 && t > 0.0 {
        let s = 1.0 / (u + v + t);
        let mut weights = [0.0; 4];
        (weights[i], weights[j], weights[k]) = (u * s, v * s, t * s);
        return (weights, n * (n.dot(a) / nn));
    }
    edges(w, i, j, k)
}

fn tetrahedron(w: &[DVec3; 4]) -> Nearest {
    let faces = [[0, 1, 2, 3], [0, 3, 1, 2], [0, 2, 3, 1], [1, 3, 2, 0]];
    let mut inside = true;
    let mut best: Option<Nearest> = None;
    for [i, j, k, opposite] in faces {
        let n = (w[j] - w[i]).cross(w[k] - w[i]);
        let o = -w[i].dot(n);
        let p = (w[opposite] - w[i]).dot(n);
        // A flat tetrahedron encloses nothing.
        let flat = p * p <= n.length_squared() * (w[opposite] - w[i]).length_squared() * 1e-20;
        if flat || o * p < 0.0 {
            inside = false;
            let f = triangle(w, i, j, k);
            if best.as_ref().is_none_or(|b| f.1.length_squared() < b.1.length_squared()) {
                best = Some(f);
            }
        }
    }
    match best {
        Some(b) if !inside => b,
        _ => ([0.25; 4], DVec3::ZERO),
    }
}
