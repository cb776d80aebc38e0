//! Triangle meshes: soup in, adjacency, edge flags and a tree out.

use crate::pairs::Surface;
use crate::{Aabb, Bvh, GeometryError, NO_SUB, limits};
use jounce_math::{
    Vec3,
    scalar::{f32s, f64s},
};
use std::collections::BTreeMap;

/// Sine of the angle up to which two neighbours count as flat: one degree.
const FLAT_SIN: f32 = 0.017_452_4;
/// A triangle whose height is less than this part of its longest side has no normal to speak of and is dropped.
const SLIVER: f64 = 1e-6;

/// How to build a [`TriMesh`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriMeshOptions {
    /// Vertices closer than this are one vertex, metres; 0 joins exact duplicates only.
    pub weld_distance: f32,
    /// Both sides of each triangle collide. Default: only the side that counter-clockwise corners face.
    pub double_sided: bool,
}

impl Default for TriMeshOptions {
    fn default() -> Self {
        Self { weld_distance: 0.0, double_sided: false }
    }
}

/// A triangle and all that is asked with it, in one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Patch {
    pub corners: [Vec3; 3],
    /// Unit, of the front.
    pub normal: Vec3,
    /// Neighbour across edge k (corner k to corner k+1), or `NO_SUB`.
    pub neighbors: [u32; 3],
    /// Its place in the given list.
    pub source: u32,
}

/// A static triangle mesh with adjacency, convex-edge flags and a bounding volume tree.
#[derive(Clone, Debug)]
pub struct TriMesh {
    pub(crate) vertices: Vec<Vec3>,
    /// The kept triangles, in the tree's order.
    pub(crate) patches: Vec<Patch>,
    /// Bit k: edge k is convex or a border (contacts on it may use edge normals); clear: flat or concave.
    /// Bit 3 + k: edge k is flat to within a degree. An edge of more than two triangles, or of two that
    /// disagree about inside and outside, is a border. Bits 6 and 7: only the face of the front, or the back, can be touched
    /// by bodies with faces.
    pub(crate) edge_flags: Vec<u8>,
    pub(crate) materials: Vec<u16>,
    pub(crate) tree: Bvh,
    pub(crate) aabb: Aabb,
    pub(crate) double_sided: bool,
    /// Length of the given list.
    given: usize,
}

impl TriMesh {
    /// Builds a mesh.
    ///
    /// ```
    /// use jounce_geometry::{Shape, TriMesh, TriMeshOptions};
    /// use jounce_math::Vec3;
    /// let corners = [Vec3::ZERO, Vec3::Z, Vec3::X];
    /// let mesh = TriMesh::new(&corners, &[[0, 1, 2]], TriMeshOptions::default())?;
    /// let hit = Shape::Mesh(mesh.into()).ray_cast(Vec3::new(0.2, 3.0, 0.2), -Vec3::Y, 10.0);
    /// assert!(hit.is_some_and(|h| (h.t - 3.0).abs() < 1e-6 && h.normal == Vec3::Y && h.sub == 0));
    /// # Ok::<(), jounce_geometry::GeometryError>(())
    /// ```
    ///
    /// Degenerate triangles are dropped (their number is `dropped()`), triangle indices in
    /// results refer to the *given* list.
    ///
    /// # Errors
    /// Non-finite vertices, indices out of range, nothing left, or too many triangles.
    pub fn new(
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
        options: TriMeshOptions,
    ) -> Result<Self, GeometryError> {
        check(vertices, triangles, options)?;
        let (vertices, index) = weld(vertices, options.weld_distance);
        let mut kept: Vec<([u32; 3], u32)> = triangles
            .iter()
            .map(|t| t.map(|v| index[v as usize]))
            .zip(0u32..)
            .filter(|(t, _)| !is_degenerate(t.map(|v| vertices[v as usize])))
            .collect();
        if kept.is_empty() {
            let what = "no triangle has an area; check the mesh's scale and its indices";
            return Err(GeometryError::Unsupported { shape: "mesh", what });
        }
        let corners = |t: &[u32; 3]| t.map(|v| vertices[v as usize]);
        let items: Vec<(Aabb, u32)> =
            kept.iter().zip(0u32..).map(|((t, _), i)| (Aabb::from_points(corners(t)), i)).collect();
        let mut tree = Bvh::build(&items);
        // Triangles in the tree's order: what a query finds together lies together.
        kept = tree.renumber().into_iter().map(|i| kept[i as usize]).collect();
        let places: Vec<[u32; 3]> = kept.iter().map(|k| k.0).collect();
        let patch = |((t, source), neighbors): (&([u32; 3], u32), [u32; 3])| {
            let corners = corners(t);
            Patch { corners, normal: normal_of(corners), neighbors, source: *source }
        };
        let patches = kept.iter().zip(neighbors(&places)).map(patch).collect();
        let mut mesh = Self {
            aabb: tree.bounds(),
            edge_flags: Vec::new(),
            materials: Vec::new(),
            tree,
            double_sided: options.double_sided,
            given: triangles.len(),
            patches,
            vertices,
        };
        mesh.edge_flags = (0..mesh.patches.len() as u32).map(|i| mesh.flags_of(i)).collect();
        let gentle: Vec<u8> =
            (0..mesh.patches.len() as u32).map(|i| Surface::Mesh(&mesh).gentle_flags(i)).collect();
        mesh.edge_flags.iter_mut().zip(gentle).for_each(|(flags, g)| *flags |= g);
        Ok(mesh)
    }
    /// With a material index per triangle (same length as the given list); looked up by results' `sub`.
    ///
    /// # Errors
    /// A wrong length.
    pub fn with_materials(mut self, materials: &[u16]) -> Result<Self, GeometryError> {
        if materials.len() != self.given {
            return Err(GeometryError::BadCount {
                shape: "mesh",
                what: "number of materials",
                count: materials.len(),
                expected: format!("one for each of the {} given triangles", self.given),
            });
        }
        self.materials = materials.to_vec();
        Ok(self)
    }
    /// Material index of a triangle of the given list; 0 where none were given.
    pub fn material(&self, triangle: u32) -> u16 {
        self.materials.get(triangle as usize).copied().unwrap_or(0)
    }
    /// Bounds.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }
    /// Corners of a kept triangle.
    #[inline]
    pub fn triangle(&self, i: u32) -> [Vec3; 3] {
        self.patches[i as usize].corners
    }
    /// Unit normal of a kept triangle.
    #[inline]
    pub fn normal(&self, i: u32) -> Vec3 {
        self.patches[i as usize].normal
    }
    /// Index of a kept triangle in the given list.
    #[inline]
    pub fn original_index(&self, i: u32) -> u32 {
        self.patches[i as usize].source
    }
    /// Number of kept triangles.
    pub fn len(&self) -> usize {
        self.patches.len()
    }
    /// Never: a mesh without triangles is refused.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }
    /// How many triangles of the given list were dropped for having no area.
    pub fn dropped(&self) -> usize {
        self.given - self.patches.len()
    }
    /// Do both sides collide?
    pub fn is_double_sided(&self) -> bool {
        self.double_sided
    }
    /// Vertices, welded.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }
    /// Calls `f` with every kept triangle whose box overlaps `aabb`.
    #[inline]
    pub fn overlapping(&self, aabb: &Aabb, mut f: impl FnMut(u32)) {
        self.tree.query(aabb, |i| {
            f(i);
            true
        });
    }

    fn flags_of(&self, i: u32) -> u8 {
        let (t, n) = (self.triangle(i), self.normal(i));
        (0..3).fold(0, |flags, k| {
            let other = self.patches[i as usize].neighbors[k];
            if other == NO_SUB {
                return flags | 1 << k;
            }
            let m = self.normal(other);
            // n × m runs along the edge on a ridge, against it in a valley.
            let edge = (t[(k + 1) % 3] - t[k]).normalize_or(Vec3::ZERO);
            let (sin, cos) = (n.cross(m).dot(edge), n.dot(m));
            if cos > 0.0 && sin.abs() <= FLAT_SIN {
                flags | 8 << k
            } else if sin > 0.0 || (cos < 0.0 && sin >= -FLAT_SIN) {
                // The second case is a fold onto itself: a knife's edge.
                flags | 1 << k
            } else {
                flags
            }
        })
    }
}

fn check(vertices: &[Vec3], triangles: &[[u32; 3]], options: TriMeshOptions) -> Result<(), GeometryError> {
    let shape = "mesh";
    let max = limits::MESH_TRIANGLES_MAX;
    if triangles.is_empty() || triangles.len() > max {
        let expected = format!("1 to {max}");
        let (what, count) = ("number of triangles", triangles.len());
        return Err(GeometryError::BadCount { shape, what, count, expected });
    }
    if vertices.len() > 3 * max {
        let (what, count) = ("number of vertices", vertices.len());
        return Err(GeometryError::BadCount { shape, what, count, expected: format!("at most {}", 3 * max) });
    }
    let (field, value) = ("weld_distance", options.weld_distance);
    if !(0.0..=limits::SIZE_MAX).contains(&value) {
        let expected = "a length in metres from 0 to 1e6";
        return Err(GeometryError::BadNumber { shape, field, value, expected });
    }
    for (index, v) in vertices.iter().enumerate() {
        if !v.is_finite() {
            return Err(GeometryError::NotFinite { shape, what: "vertex", index });
        }
        let value = v.abs().max_component();
        if value > limits::SIZE_MAX {
            let (field, expected) = ("vertex coordinate", "at most 1e6 m from zero");
            return Err(GeometryError::BadNumber { shape, field, value, expected });
        }
    }
    for (triangle, t) in triangles.iter().enumerate() {
        if let Some(&index) = t.iter().find(|&&v| v as usize >= vertices.len()) {
            return Err(GeometryError::BadIndex { shape, triangle, index, vertices: vertices.len() });
        }
    }
    Ok(())
}

/// The vertices that stay, and for each given vertex which of them it became. The first of a group stays.
fn weld(vertices: &[Vec3], distance: f32) -> (Vec<Vec3>, Vec<u32>) {
    if distance == 0.0 {
        return weld_equal(vertices);
    }
    // Wide cells: the ball around a vertex touches two of them on average.
    let width = 4.0 * f64::from(distance);
    let cell = |c: f32, shift: f32| ((f64::from(c) + f64::from(shift)) / width).floor() as i64;
    let mut cells: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
    let (mut kept, mut index) = (Vec::new(), Vec::with_capacity(vertices.len()));
    for &v in vertices {
        let low = v.to_array().map(|c| cell(c, -distance));
        let high = v.to_array().map(|c| cell(c, distance));
        let touched = (low[0]..=high[0])
            .flat_map(|x| (low[1]..=high[1]).map(move |y| (x, y)))
            .flat_map(|(x, y)| (low[2]..=high[2]).map(move |z| [x, y, z]));
        let near = touched
            .filter_map(|c| cells.get(&c))
            .find_map(|group| group.iter().copied().find(|&i| v.distance(kept[i as usize]) <= distance));
        index.push(near.unwrap_or_else(|| {
            let i = kept.len() as u32;
            kept.push(v);
            cells.entry(v.to_array().map(|c| cell(c, 0.0))).or_default().push(i);
            i
        }));
    }
    (kept, index)
}

fn weld_equal(vertices: &[Vec3]) -> (Vec<Vec3>, Vec<u32>) {
    // −0 is 0: adding 0 makes it so. Equal floats then have equal bits.
    let key = |i: u32| vertices[i as usize].to_array().map(|c| (c + 0.0).to_bits());
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    order.sort_unstable_by_key(|&i| (key(i), i));
    let mut first: Vec<u32> = vec![0; vertices.len()];
    for group in order.chunk_by(|&a, &b| key(a) == key(b)) {
        for &i in group {
            first[i as usize] = group[0];
        }
    }
    let (mut kept, mut index) = (Vec::new(), vec![0; vertices.len()]);
    for i in 0..vertices.len() {
        if first[i] as usize == i {
            index[i] = kept.len() as u32;
            kept.push(vertices[i]);
        } else {
            index[i] = index[first[i] as usize];
        }
    }
    (kept, index)
}

fn is_degenerate(t: [Vec3; 3]) -> bool {
    let [a, b, c] = t.map(Vec3::as_dvec3);
    let longest = [b - a, c - b, a - c].into_iter().fold(0.0, |m, e| f64s::max(e.length_squared(), m));
    let double_area = (b - a).cross(c - a).length();
    // Height over the longest side, against that side and against the rounding of the coordinates.
    let largest = t.iter().fold(0.0, |m, p| f32s::max(p.abs().max_component(), m));
    let rounding = f64::from(largest) * f64::from(f32::EPSILON);
    double_area <= f64s::max(SLIVER * longest, rounding * longest.sqrt())
}

/// In `f64`: a sliver's sides nearly cancel.
fn normal_of(t: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = t.map(Vec3::as_dvec3);
    (b - a).cross(c - a).normalize_or(jounce_math::DVec3::Y).as_vec3()
}

fn neighbors(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut edges: Vec<(u32, u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
    for (t, i) in triangles.iter().zip(0u32..) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            edges.push(if a < b { (a, b, i, k as u32) } else { (b, a, i, k as u32) });
        }
    }
    edges.sort_unstable();
    let mut out = vec![[NO_SUB; 3]; triangles.len()];
    for group in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        if let [(_, _, i, k), (_, _, j, l)] = *group {
            let start = |t: u32, k: u32| triangles[t as usize][k as usize];
            // Neighbours with the same sense of inside run along their edge in opposite directions.
            if start(i, k) != start(j, l) {
                out[i as usize][k as usize] = j;
                out[j as usize][l as usize] = i;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONVEX: u8 = 7;
    const FLAT: u8 = 7 << 3;

    fn mesh(vertices: &[Vec3], triangles: &[[u32; 3]]) -> TriMesh {
        TriMesh::new(vertices, triangles, TriMeshOptions::default()).unwrap()
    }

    /// Two triangles over the x axis, the second hanging down by `slope` (up for negative ones).
    fn roof(slope: f32) -> TriMesh {
        let v = [Vec3::ZERO, Vec3::X, -Vec3::Z, Vec3::new(0.0, -slope, 1.0)];
        mesh(&v, &[[0, 1, 2], [1, 0, 3]])
    }

    /// Flags of the shared edge of both triangles, moved to bit 0 (convex) and bit 3 (flat).
    fn shared(m: &TriMesh) -> [u8; 2] {
        [0, 1].map(|i| {
            let k = m.patches[i].neighbors.iter().position(|&n| n != NO_SUB).unwrap();
            assert_eq!(m.patches[i].neighbors[k], 1 - i as u32);
            m.edge_flags[i] >> k & 9
        })
    }

    #[test]
    fn edges_are_convex_flat_or_concave() {
        assert_eq!(shared(&roof(0.5)), [1, 1]);
        assert_eq!(shared(&roof(50.0)), [1, 1]);
        assert_eq!(shared(&roof(0.0)), [8, 8]);
        assert_eq!(shared(&roof(0.01)), [8, 8]);
        assert_eq!(shared(&roof(-0.01)), [8, 8]);
        assert_eq!(shared(&roof(-0.5)), [0, 0]);
    }

    #[test]
    fn closed_box_has_convex_and_flat_edges_only() {
        let v: Vec<Vec3> =
            (0..8u32).map(|k| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let t: Vec<[u32; 3]> = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let m = mesh(&v, &t);
        for i in 0..12 {
            assert!(m.patches[i].neighbors.iter().all(|&n| n != NO_SUB));
            assert_eq!((m.edge_flags[i] & CONVEX).count_ones(), 2);
            assert_eq!((m.edge_flags[i] & FLAT).count_ones(), 1);
            let out = m.triangle(i as u32)[0] - Vec3::splat(0.5);
            assert!(m.patches[i].normal.dot(out) > 0.0);
        }
    }

    /// Three triangles on one edge, and two that disagree about the side: borders.
    #[test]
    fn edges_without_one_clear_neighbor_are_borders() {
        let v = [Vec3::ZERO, Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z];
        for t in [&[[0, 1, 2], [1, 0, 3], [1, 0, 4]][..], &[[0, 1, 2], [0, 1, 3]][..]] {
            let m = mesh(&v, t);
            assert!(m.patches.iter().flat_map(|p| p.neighbors).all(|n| n == NO_SUB));
            assert!(m.edge_flags.iter().all(|&f| f == CONVEX));
        }
    }
}
