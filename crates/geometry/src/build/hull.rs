//! Convex hulls: `quickhull.rs` finds the triangles, `merge.rs` the planar faces, here they become a [`Hull`].

use super::merge::{Outline, merge};
use super::quickhull::{Flat, QuickHull};
use crate::shapes::{corners::Corners, hull_mass};
use crate::{Aabb, GeometryError, limits};
use jounce_math::{
    DVec3, Vec3,
    scalar::{f32s, f64s},
};

/// Points nearer than this to the hull are not worth a vertex, relative to the largest extent.
const TOLERANCE: f64 = 2e-6;
/// And relative to the largest coordinate, for hulls far from their own origin.
const TOLERANCE_COORDINATE: f64 = 4.0 * f32::EPSILON as f64;

/// A planar face: its corners are `Hull::face_vertices(face)`, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullFace {
    /// Unit outward normal.
    pub normal: Vec3,
    /// normal · x = offset on the plane.
    pub offset: f32,
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// An edge between two faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullEdge {
    /// End vertices; `left` lies left of a→b seen from outside.
    pub a: u16,
    /// Other end.
    pub b: u16,
    /// Face whose loop runs a→b.
    pub left: u16,
    /// Face whose loop runs b→a.
    pub right: u16,
}

/// A closed convex polyhedron with merged coplanar faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    pub(crate) vertices: Vec<Vec3>,
    /// The same, for those who ask all of them.
    pub(crate) corners: Corners,
    pub(crate) faces: Vec<HullFace>,
    /// Their normals, likewise.
    pub(crate) normals: Corners,
    /// How far the corners reach along them, in the rounding of that product.
    pub(crate) reaches: Vec<f32>,
    pub(crate) loops: Vec<u16>,
    pub(crate) edges: Vec<HullEdge>,
    pub(crate) aabb: Aabb,
    pub(crate) center: Vec3,
    pub(crate) inner_radius: f32,
    /// m³.
    pub(crate) volume: f64,
    /// `center` before it was rounded.
    pub(crate) centroid: DVec3,
}

impl Hull {
    /// The convex hull of points (metres).
    ///
    /// ```
    /// use jounce_geometry::Hull;
    /// use jounce_math::Vec3;
    /// let hull = Hull::new(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::splat(0.1)])?;
    /// assert_eq!((hull.vertices().len(), hull.edges().len(), hull.faces().len()), (4, 6, 4));
    /// # Ok::<(), jounce_geometry::GeometryError>(())
    /// ```
    ///
    /// Survives duplicates, collinear and coplanar input;
    /// refuses sets without volume by name. At most [`crate::limits::HULL_VERTICES_MAX`] vertices are kept, the most
    /// extreme ones. Points nearer to the hull than 2·10⁻⁶ of its largest extent (or 4 roundings of its
    /// largest coordinate) make no vertex, and faces flat to that tolerance are one face.
    ///
    /// # Errors
    /// Non-finite points, fewer than four, too many, no volume, or an extent out of
    /// [`crate::limits::SIZE_MIN`]…[`crate::limits::SIZE_MAX`].
    pub fn new(points: &[Vec3]) -> Result<Self, GeometryError> {
        let extent = check_points(points)?;
        let bounds = Aabb::from_points(points.iter().copied());
        let center = (bounds.min.as_dvec3() + bounds.max.as_dvec3()) * 0.5;
        let largest = f32s::max(bounds.min.abs().max_component(), bounds.max.abs().max_component());
        let tolerance = f64s::max(TOLERANCE * extent, TOLERANCE_COORDINATE * f64::from(largest));
        let half = 0.5 * extent;
        let mut first = None;
        // Where the faces do not fit together, a coarser hull does without the vertices that were to blame.
        for coarser in [1.0, 4.0, 16.0] {
            let mut q = QuickHull::new(points, center, half, tolerance * coarser);
            match q.run(limits::HULL_VERTICES_MAX) {
                Ok(()) => {}
                Err(flat) if first.is_none() => return Err(degenerate(flat, extent)),
                Err(_) => break,
            }
            if let Some(outlines) = merge(&q, 2.0 * q.tolerance) {
                let hull = Self::assemble(points, &q, &outlines);
                if hull.validate().is_ok() {
                    return Ok(hull);
                }
            }
            first.get_or_insert(q);
        }
        // The triangles as they are: valid, if not pretty.
        first.map_or(Err(degenerate(Flat::Thin, extent)), |q| {
            let alive = q.faces.iter().zip(0u32..).filter(|(f, _)| f.alive);
            let outlines: Vec<Outline> =
                alive.map(|(f, seed)| Outline { seed, corners: f.v.to_vec() }).collect();
            Ok(Self::assemble(points, &q, &outlines))
        })
    }

    /// A box as a hull.
    ///
    /// # Errors
    /// A half extent that is not a size.
    pub fn cuboid(half: Vec3) -> Result<Self, GeometryError> {
        crate::Shape::Box { half }.check()?;
        let corner = |k: u32| {
            let side = |bit: u32, h: f32| if k & bit == 0 { -h } else { h };
            Vec3::new(side(1, half.x), side(2, half.y), side(4, half.z))
        };
        Self::new(&core::array::from_fn::<Vec3, 8, _>(|k| corner(k as u32)))
    }

    /// The hull stretched along its axes; negative factors mirror it.
    ///
    /// # Errors
    /// Factors that leave no volume or are not finite.
    pub fn scaled(&self, scale: Vec3) -> Result<Self, GeometryError> {
        let points: Vec<Vec3> = self.vertices.iter().map(|v| v.mul(scale)).collect();
        Self::new(&points)
    }

    fn assemble(points: &[Vec3], q: &QuickHull, outlines: &[Outline]) -> Self {
        // Vertices keep the order of the given points.
        let mut used: Vec<u32> = outlines.iter().flat_map(|o| o.corners.iter().copied()).collect();
        used.sort_unstable();
        used.dedup();
        let vertices: Vec<Vec3> = used.iter().map(|&p| points[p as usize]).collect();
        let (mut faces, mut loops) = (Vec::new(), Vec::new());
        for o in outlines {
            let seed = &q.faces[o.seed as usize];
            // The offset goes with the normal as rounded: far from the origin its last bits are worth much.
            let normal = seed.unit.as_vec3();
            let offset = seed.v.iter().fold(f64::NEG_INFINITY, |m, &v| {
                f64s::max(normal.as_dvec3().dot(points[v as usize].as_dvec3()), m)
            });
            let (first, count) = (loops.len() as u32, o.corners.len() as u32);
            let index = |p: &u32| used.binary_search(p).unwrap_or(0) as u16;
            loops.extend(o.corners.iter().map(index));
            faces.push(HullFace { normal, offset: offset as f32, first, count });
        }
        let aabb = Aabb::from_points(vertices.iter().copied());
        let corners = Corners::new(&vertices);
        let directions: Vec<Vec3> = faces.iter().map(|f| f.normal).collect();
        let normals = Corners::new(&directions);
        let reaches = directions.iter().map(|n| n.dot(vertices[corners.farthest(*n)])).collect();
        let edges = edges_of(&faces, &loops);
        let center = aabb.center();
        let (volume, centroid) = (0.0, center.as_dvec3());
        let mut hull = Self {
            vertices,
            corners,
            faces,
            normals,
            reaches,
            loops,
            edges,
            aabb,
            center,
            inner_radius: 0.0,
            volume,
            centroid,
        };
        let (volume, center, _) = hull_mass(&hull, 1.0);
        let gap = |f: &HullFace| f64::from(f.offset) - f.normal.as_dvec3().dot(center);
        let inner = hull.faces.iter().map(gap).fold(f64::INFINITY, f64s::min);
        hull.center = center.as_vec3();
        (hull.volume, hull.centroid) = (volume, center);
        hull.inner_radius = f64s::max(inner, 0.0) as f32;
        hull
    }

    /// Corner points.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }
    /// Faces.
    pub fn faces(&self) -> &[HullFace] {
        &self.faces
    }
    /// Edges, each once.
    pub fn edges(&self) -> &[HullEdge] {
        &self.edges
    }
    /// Corners of a face, as indices into [`Hull::vertices`], counter-clockwise from outside.
    pub fn face_vertices(&self, face: &HullFace) -> &[u16] {
        &self.loops[face.first as usize..(face.first + face.count) as usize]
    }
    /// Bounds.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }
    /// Centre of mass at uniform density.
    pub fn center(&self) -> Vec3 {
        self.center
    }
    /// Distance from the centre to the nearest face plane.
    pub fn inner_radius(&self) -> f32 {
        self.inner_radius
    }
    /// Checks that this is a closed convex polyhedron: Euler's formula, edges and loops that agree, planar convex
    /// faces, no vertex in front of a face. For tests and debug builds.
    ///
    /// # Errors
    /// The first broken invariant, in words.
    pub fn validate(&self) -> Result<(), String> {
        let (v, e, f) = (self.vertices.len(), self.edges.len(), self.faces.len());
        if v + f != e + 2 || v < 4 || f < 4 {
            return Err(format!("{v} vertices − {e} edges + {f} faces is not 2"));
        }
        if v > limits::HULL_VERTICES_MAX || 2 * e != self.loops.len() {
            return Err(format!("{v} vertices, {e} edges, {} loop entries", self.loops.len()));
        }
        for (k, edge) in self.edges.iter().enumerate() {
            let runs = |face: u16, a: u16, b: u16| {
                self.faces.get(usize::from(face)).is_some_and(|f| {
                    let l = self.face_vertices(f);
                    (0..l.len()).any(|i| l[i] == a && l[(i + 1) % l.len()] == b)
                })
            };
            if !(runs(edge.left, edge.a, edge.b) && runs(edge.right, edge.b, edge.a)) {
                return Err(format!("edge {k} does not run between its faces"));
            }
        }
        let tolerance = self.tolerance();
        for (k, face) in self.faces.iter().enumerate() {
            self.validate_face(face, tolerance).map_err(|what| format!("face {k}: {what}"))?;
        }
        Ok(())
    }

    /// How far vertices may be off their faces' planes, metres.
    fn tolerance(&self) -> f64 {
        let extent = f64::from((self.aabb.max - self.aabb.min).max_component());
        let largest = f32s::max(self.aabb.min.abs().max_component(), self.aabb.max.abs().max_component());
        // The coarsest of the three attempts, merged at twice its tolerance.
        33.0 * f64s::max(TOLERANCE * extent, TOLERANCE_COORDINATE * f64::from(largest))
    }

    fn validate_face(&self, face: &HullFace, tolerance: f64) -> Result<(), String> {
        let n = face.normal.as_dvec3();
        if (n.length() - 1.0).abs() > 1e-6 {
            return Err("the normal is not unit".into());
        }
        let height = |v: Vec3| n.dot(v.as_dvec3()) - f64::from(face.offset);
        if let Some(h) = self.vertices.iter().map(|&v| height(v)).find(|&h| h > 0.1 * tolerance) {
            return Err(format!("a vertex is {h:e} m in front"));
        }
        let corners: Vec<Vec3> =
            self.face_vertices(face).iter().map(|&v| self.vertices[usize::from(v)]).collect();
        if corners.len() < 3 {
            return Err("fewer than three corners".into());
        }
        for (k, &a) in corners.iter().enumerate() {
            if height(a) < -tolerance {
                return Err(format!("corner {k} is {:e} m behind the plane", -height(a)));
            }
            let (a, b) = (a.as_dvec3(), corners[(k + 1) % corners.len()].as_dvec3());
            let inward = n.cross(b - a);
            if inward.length() > tolerance
                && corners.iter().any(|c| inward.dot(c.as_dvec3() - a) < -tolerance * inward.length())
            {
                return Err(format!("not convex at corner {k}"));
            }
        }
        Ok(())
    }
}

/// Largest extent, if the points can be a hull's.
fn check_points(points: &[Vec3]) -> Result<f64, GeometryError> {
    let shape = "hull";
    if points.len() < 4 || points.len() > limits::HULL_POINTS_MAX {
        let expected = format!("4 to {}", limits::HULL_POINTS_MAX);
        return Err(GeometryError::BadCount {
            shape,
            what: "number of points",
            count: points.len(),
            expected,
        });
    }
    if let Some(index) = points.iter().position(|p| !p.is_finite()) {
        return Err(GeometryError::NotFinite { shape, what: "point", index });
    }
    let bounds = Aabb::from_points(points.iter().copied());
    let extent = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).max_component();
    if extent == 0.0 {
        return Err(degenerate(Flat::Point, extent));
    }
    // A whole side may be twice the largest half extent of a box.
    let max = 2.0 * f64::from(limits::SIZE_MAX);
    let largest = f64::from(f32s::max(bounds.min.abs().max_component(), bounds.max.abs().max_component()));
    for (field, value) in [("extent", extent), ("largest coordinate", largest)] {
        if value > max || (field == "extent" && value < f64::from(limits::SIZE_MIN)) {
            let expected = "1e-6 to 2e6 metres";
            return Err(GeometryError::BadNumber { shape, field, value: value as f32, expected });
        }
    }
    Ok(extent)
}

fn degenerate(flat: Flat, extent: f64) -> GeometryError {
    let what = match flat {
        Flat::Point => "all one point",
        Flat::Collinear => "collinear",
        Flat::Coplanar => "coplanar",
        Flat::Thin => "too thin",
    };
    GeometryError::Degenerate { what, extent: extent as f32 }
}

/// Each edge once, in the order in which the loops first name it.
fn edges_of(faces: &[HullFace], loops: &[u16]) -> Vec<HullEdge> {
    let mut directed: Vec<(u16, u16, u16)> = Vec::with_capacity(loops.len());
    for (f, face) in (0u16..).zip(faces) {
        let l = &loops[face.first as usize..(face.first + face.count) as usize];
        directed.extend((0..l.len()).map(|k| (l[k], l[(k + 1) % l.len()], f)));
    }
    let mut sorted = directed.clone();
    sorted.sort_unstable();
    let opposite = |a: u16, b: u16| {
        let i = sorted.partition_point(|&(x, y, _)| (x, y) < (b, a));
        sorted.get(i).filter(|&&(x, y, _)| (x, y) == (b, a)).map(|e| e.2)
    };
    let edges = directed.iter().filter_map(|&(a, b, left)| {
        let right = opposite(a, b)?;
        (left < right).then_some(HullEdge { a, b, left, right })
    });
    edges.collect()
}
