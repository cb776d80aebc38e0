//! One view of everything with flat faces: boxes, hulls and (as two-faced flat polyhedra) triangles.

use crate::shapes::corners::Corners;
use crate::{Hull, HullEdge, HullFace};
use jounce_math::Vec3;

/// A polyhedron in its own frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Poly<'a> {
    pub vertices: &'a [Vec3],
    /// Those of a hull, four abreast.
    corners: Option<&'a Corners>,
    /// The normals of a hull's faces, likewise.
    normals: Option<&'a Corners>,
    pub faces: &'a [HullFace],
    pub loops: &'a [u16],
    pub edges: &'a [HullEdge],
    pub center: Vec3,
    /// The first so many faces are real; the others only close the fan of normals around an edge (triangles).
    pub real: usize,
}

impl<'a> Poly<'a> {
    /// Corners of face `f`, counter-clockwise from outside.
    pub fn face_loop(&self, f: usize) -> &'a [u16] {
        let face = &self.faces[f];
        &self.loops[face.first as usize..(face.first + face.count) as usize]
    }
    /// Faces that can be touched.
    pub fn real_faces(&self) -> &'a [HullFace] {
        &self.faces[..self.real]
    }
    /// The face whose normal is nearest to `n`.
    #[inline]
    pub fn face_along(&self, n: Vec3) -> usize {
        if let Some(normals) = self.normals {
            return normals.farthest(n);
        }
        let (mut best, mut at) = (f32::NEG_INFINITY, 0);
        for (i, f) in self.real_faces().iter().enumerate() {
            let d = f.normal.dot(n);
            if d > best {
                (best, at) = (d, i);
            }
        }
        at
    }
    /// A vertex farthest along `d`.
    #[inline]
    pub fn support(&self, d: Vec3) -> usize {
        if let Some(corners) = self.corners {
            return corners.farthest(d);
        }
        let (mut best, mut at) = (f32::NEG_INFINITY, 0);
        for (i, v) in self.vertices.iter().enumerate() {
            let s = v.dot(d);
            if s > best {
                (best, at) = (s, i);
            }
        }
        at
    }
}

impl<'a> From<&'a Hull> for Poly<'a> {
    fn from(h: &'a Hull) -> Self {
        Self {
            vertices: &h.vertices,
            corners: Some(&h.corners),
            normals: Some(&h.normals),
            faces: &h.faces,
            loops: &h.loops,
            edges: &h.edges,
            center: h.center,
            real: h.faces.len(),
        }
    }
}

/// The corners and faces of a box. Corner k has sign + in x, y, z where bits 0, 1, 2 of k are set; face
/// 2·axis is the negative one, 2·axis + 1 the positive one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxPoly {
    vertices: [Vec3; 8],
    faces: [HullFace; 6],
}

const BOX_LOOPS: [u16; 24] = [0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6];

const fn edge(a: u16, b: u16, left: u16, right: u16) -> HullEdge {
    HullEdge { a, b, left, right }
}

const BOX_EDGES: [HullEdge; 12] = [
    edge(0, 1, 2, 4),
    edge(2, 3, 4, 3),
    edge(4, 5, 5, 2),
    edge(6, 7, 3, 5),
    edge(0, 2, 4, 0),
    edge(1, 3, 1, 4),
    edge(4, 6, 0, 5),
    edge(5, 7, 5, 1),
    edge(0, 4, 0, 2),
    edge(1, 5, 2, 1),
    edge(2, 6, 3, 0),
    edge(3, 7, 1, 3),
];

impl BoxPoly {
    pub fn new(h: Vec3) -> Self {
        let vertices = core::array::from_fn(|k| {
            let s = |bit: usize| if k & bit != 0 { 1.0 } else { -1.0 };
            Vec3::new(s(1) * h.x, s(2) * h.y, s(4) * h.z)
        });
        let faces = core::array::from_fn(|f| {
            let mut n = Vec3::ZERO;
            n[f / 2] = if f % 2 == 1 { 1.0 } else { -1.0 };
            HullFace { normal: n, offset: h[f / 2], first: 4 * f as u32, count: 4 }
        });
        Self { vertices, faces }
    }
    pub fn view(&self) -> Poly<'_> {
        Poly {
            vertices: &self.vertices,
            corners: None,
            normals: None,
            faces: &self.faces,
            loops: &BOX_LOOPS,
            edges: &BOX_EDGES,
            center: Vec3::ZERO,
            real: 6,
        }
    }
}

/// One side of a triangle, as a polyhedron of one real face. Three more normals, outward in its plane, close the fan
/// at its edges: directions from the face's to those are the ones in which an edge can be touched.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TrianglePoly {
    pub vertices: [Vec3; 3],
    faces: [HullFace; 4],
}

const TRIANGLE_LOOP: [u16; 3] = [0, 1, 2];
const TRIANGLE_EDGES: [HullEdge; 3] = [edge(0, 1, 0, 1), edge(1, 2, 0, 2), edge(2, 0, 0, 3)];

impl TrianglePoly {
    /// Counter-clockwise corners around the unit `normal`.
    pub fn new(vertices: [Vec3; 3], normal: Vec3) -> Self {
        let face =
            |normal: Vec3, at: Vec3, count| HullFace { normal, offset: normal.dot(at), first: 0, count };
        let side = |k: usize| {
            let (a, b) = (vertices[k], vertices[(k + 1) % 3]);
            face((b - a).cross(normal).normalize_or(normal), a, 0)
        };
        Self { vertices, faces: [face(normal, vertices[0], 3), side(0), side(1), side(2)] }
    }
    pub fn normal(&self) -> Vec3 {
        self.faces[0].normal
    }
    /// Outward normal of edge `k` in the triangle's plane.
    pub fn side(&self, k: usize) -> Vec3 {
        self.faces[1 + k % 3].normal
    }
    pub fn view(&self) -> Poly<'_> {
        Poly {
            vertices: &self.vertices,
            corners: None,
            normals: None,
            faces: &self.faces,
            loops: &TRIANGLE_LOOP,
            edges: &TRIANGLE_EDGES,
            center: (self.vertices[0] + self.vertices[1] + self.vertices[2]) * (1.0 / 3.0),
            real: 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Loops run counter-clockwise, and each edge has its two faces on the sides it names.
    #[test]
    fn box_tables_agree() {
        let b = BoxPoly::new(Vec3::new(1.0, 2.0, 3.0));
        let p = b.view();
        for f in 0..6 {
            let l = p.face_loop(f);
            let v = |i: usize| p.vertices[usize::from(l[i])];
            let n = (v(1) - v(0)).cross(v(2) - v(1)).normalize_or(Vec3::ZERO);
            assert_eq!(n, p.faces[f].normal);
            for &k in l {
                assert_eq!(p.vertices[usize::from(k)].dot(n), p.faces[f].offset);
            }
        }
        for e in p.edges {
            let runs = |f: u16, a: u16, b: u16| {
                let l = p.face_loop(usize::from(f));
                (0..l.len()).any(|i| l[i] == a && l[(i + 1) % l.len()] == b)
            };
            assert!(runs(e.left, e.a, e.b) && runs(e.right, e.b, e.a), "{e:?}");
        }
    }
}
