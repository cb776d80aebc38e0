//! Penetration of two overlapping cores by EPA.
//!
//! The Minkowski difference W holds the origin; its boundary point nearest to the origin is the least translation
//! that separates the cores. A polytope inside W grows towards that point: the support point along the normal of its
//! nearest face is added until it lies on that face.
//!
//! G. van den Bergen, "Proximity queries and penetration depth computation on 3D game objects", 2001. Arithmetic is
//! `f64` on `f32` support points.

use super::gjk::{Difference, Simplex, Vertex};
use crate::limits::EPA_ITERATIONS_MAX;
use jounce_math::{DVec3, Vec3};

const VERTICES_MAX: usize = EPA_ITERATIONS_MAX + 4;
/// A closed triangulation of V vertices has 2 V − 4 faces.
const FACES_MAX: usize = 2 * VERTICES_MAX;
const BORDER_MAX: usize = 3 * VERTICES_MAX;

/// The least push-out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Penetration {
    /// Unit direction from A to B along which B leaves.
    pub normal: Vec3,
    /// Overlap along it, ≥ 0.
    pub depth: f32,
    /// Deepest point of A in B, on A's surface.
    pub a: Vec3,
    /// Deepest point of B in A, on B's surface.
    pub b: Vec3,
}

#[derive(Clone, Copy, Default)]
struct Face {
    corners: [u8; 3],
    normal: DVec3,
    distance: f64,
}

struct Polytope {
    vertices: [Vertex; VERTICES_MAX],
    vertex_count: usize,
    faces: [Face; FACES_MAX],
    face_count: usize,
}

impl Polytope {
    fn face(&self, i: u8, j: u8, k: u8) -> Option<Face> {
        let [a, b, c] = [i, j, k].map(|x| self.vertices[usize::from(x)].w);
        let (normal, _) = (b - a).cross(c - a).try_normalize()?;
        Some(Face { corners: [i, j, k], normal, distance: normal.dot(a) })
    }
    fn push(&mut self, face: Option<Face>) {
        if let Some(f) = face
            && self.face_count < FACES_MAX
        {
            self.faces[self.face_count] = f;
            self.face_count += 1;
        }
    }
    fn nearest(&self) -> Option<Face> {
        let mut best: Option<Face> = None;
        for f in &self.faces[..self.face_count] {
            if best.is_none_or(|b| f.distance < b.distance) {
                best = Some(*f);
            }
        }
        best
    }
    /// Adds a vertex: the faces that see it and hang together with `seed` go, the hole's border is closed with new
    /// ones. (Slivers beyond that patch may see it too by rounding; taking them would tear the surface.)
    fn grow(&mut self, seed: &Face, v: Vertex, tolerance: f64) -> bool {
        if self.vertex_count == VERTICES_MAX {
            return false;
        }
        let new = self.vertex_count as u8;
        self.vertices[self.vertex_count] = v;
        self.vertex_count += 1;
        let mut border = [(0u8, 0u8); BORDER_MAX];
        let mut n = 0;
        for k in 0..3 {
            border[k] = (seed.corners[k], seed.corners[(k + 1) % 3]);
            n += 1;
        }
        self.remove(seed);
        // Each round takes the faces that see the vertex across the present border.
        let mut at = 0;
        while at < n {
            let (a, b) = border[at];
            let across = self.faces[..self.face_count].iter().copied().find(|f| {
                let [i, j, k] = f.corners;
                (i, j) == (b, a) || (j, k) == (b, a) || (k, i) == (b, a)
            });
            let Some(f) = across.filter(|f| f.normal.dot(v.w) - f.distance > tolerance) else {
                at += 1;
                continue;
            };
            self.remove(&f);
            for k in 0..3 {
                let (x, y) = (f.corners[k], f.corners[(k + 1) % 3]);
                if let Some(i) = border[..n].iter().position(|&e| e == (y, x)) {
                    n -= 1;
                    border[i] = border[n];
                } else if n < BORDER_MAX {
                    border[n] = (x, y);
                    n += 1;
                }
            }
            at = 0;
        }
        for &(a, b) in &border[..n] {
            self.push(self.face(a, b, new));
        }
        n > 0
    }
    fn remove(&mut self, face: &Face) {
        if let Some(i) = self.faces[..self.face_count].iter().position(|f| f.corners == face.corners) {
            self.face_count -= 1;
            self.faces[i] = self.faces[self.face_count];
        }
    }
}

impl Difference<'_> {
    /// Penetration of overlapping cores, from the simplex that GJK ended with. `None` where the difference is
    /// flat (two flat or thin cores that touch).
    pub fn epa(&self, simplex: &Simplex) -> Option<Penetration> {
        let start = self.tetrahedron(simplex)?;
        let mut p = Polytope {
            vertices: [Vertex::default(); VERTICES_MAX],
            vertex_count: 4,
            faces: [Face::default(); FACES_MAX],
            face_count: 0,
        };
        p.vertices[..4].copy_from_slice(&start);
        for [i, j, k] in [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]] {
            p.push(p.face(i, j, k));
        }
        let size =
            p.vertices[..4].iter().fold(0.0f64, |m, v| if v.w.length() > m { v.w.length() } else { m });
        let tolerance = size * 1e-5;
        let mut nearest = p.nearest()?;
        // The polytope bounds the depth from below, support planes from above; the answer is the best plane.
        let mut best = (nearest, f64::INFINITY);
        for _ in 0..EPA_ITERATIONS_MAX {
            let v = self.support(nearest.normal.as_vec3());
            let above = v.w.dot(nearest.normal);
            if above < best.1 {
                best = (nearest, above);
            }
            let known = p.vertices[..p.vertex_count].iter().any(|q| q.w == v.w);
            if best.1 - nearest.distance <= tolerance || known || !p.grow(&nearest, v, size * 1e-9) {
                break;
            }
            match p.nearest() {
                // Where the cores barely overlap or GJK's simplex is flat, the first tetrahedron may not hold the
                // origin: then it grows towards it, and new faces may lie farther beyond.
                Some(f) if nearest.distance < 0.0 => nearest = f,
                // From there on the lower bound can only rise; if it falls, rounding tore the surface of slivers.
                Some(f) if f.distance >= nearest.distance - tolerance => nearest = f,
                _ => {
                    nearest = best.0;
                    break;
                }
            }
        }
        // The witness points come from the face that the origin projects into: the last nearest.
        Some(p.answer(&nearest, best.0.normal, best.1))
    }

    /// Four support points that enclose the origin or lie beside it, starting from a simplex of any size.
    fn tetrahedron(&self, simplex: &Simplex) -> Option<[Vertex; 4]> {
        let mut v = [Vertex::default(); 4];
        let mut n = simplex.count.min(4);
        v[..n].copy_from_slice(&simplex.vertices[..n]);
        let axes = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
        // The difference holds the origin or nearly, so nothing of it is farther away than twice this.
        let size = f64::from(self.a.reach() + self.b.reach());
        let tiny = size * 1e-6;
        if n == 4 && volume(&v).abs() <= tiny * size * size {
            n = 3;
        }
        if n >= 3 && (v[1].w - v[0].w).cross(v[2].w - v[0].w).length() <= tiny * size {
            n = 2;
        }
        if n >= 2 && (v[1].w - v[0].w).length() <= tiny {
            n = 1;
        }
        if n <= 1 {
            if n == 0 {
                v[0] = self.support(Vec3::X);
            }
            v[1] = farthest(axes.map(|d| self.support(d)), |w| (w - v[0].w).length())?;
            n = 2;
        }
        if n == 2 {
            let line = (v[1].w - v[0].w).try_normalize()?.0;
            let (s, t) = line.as_vec3().normalize_or(Vec3::X).orthonormal_basis();
            let around = [s, -s, t, -t, s + t, -s - t].map(|d| self.support(d));
            let far = farthest(around, |w| (w - v[0].w).cross(line).length())?;
            if (far.w - v[0].w).cross(line).length() <= tiny {
                return None;
            }
            v[2] = far;
            n = 3;
        }
        if n == 3 {
            let normal = (v[1].w - v[0].w).cross(v[2].w - v[0].w).try_normalize()?.0;
            let d = normal.as_vec3();
            let far = farthest([self.support(d), self.support(-d)], |w| (w - v[0].w).dot(normal).abs())?;
            if (far.w - v[0].w).dot(normal).abs() <= tiny {
                return None;
            }
            v[3] = far;
        }
        if volume(&v) > 0.0 {
            v.swap(1, 2);
        }
        Some(v)
    }
}

/// Six times the signed volume: negative where face 0 1 2 looks away from 3.
fn volume(v: &[Vertex; 4]) -> f64 {
    (v[1].w - v[0].w).cross(v[2].w - v[0].w).dot(v[3].w - v[0].w)
}

fn farthest<const N: usize>(points: [Vertex; N], score: impl Fn(DVec3) -> f64) -> Option<Vertex> {
    let mut best: Option<(f64, Vertex)> = None;
    for p in points {
        let s = score(p.w);
        if best.is_none_or(|(b, _)| s > b) {
            best = Some((s, p));
        }
    }
    best.map(|(_, p)| p)
}

impl Polytope {
    fn answer(&self, f: &Face, normal: DVec3, depth: f64) -> Penetration {
        let [i, j, k] = f.corners.map(|c| self.vertices[usize::from(c)]);
        // The origin's projection on the face, in barycentric coordinates.
        let q = f.normal * f.distance;
        let area = |x: DVec3, y: DVec3| f.normal.dot((x - q).cross(y - q));
        let clip = |x: f64| if x > 0.0 { x } else { 0.0 };
        let (u, v, w) = (clip(area(j.w, k.w)), clip(area(k.w, i.w)), clip(area(i.w, j.w)));
        let sum = u + v + w;
        let (u, v, w) = if sum > 0.0 { (u / sum, v / sum, w / sum) } else { (1.0, 0.0, 0.0) };
        let mix = |x: Vec3, y: Vec3, z: Vec3| x.as_dvec3() * u + y.as_dvec3() * v + z.as_dvec3() * w;
        Penetration {
            normal: normal.as_vec3(),
            depth: clip(depth) as f32,
            a: mix(i.a, j.a, k.a).as_vec3(),
            b: mix(i.b, j.b, k.b).as_vec3(),
        }
    }
}
