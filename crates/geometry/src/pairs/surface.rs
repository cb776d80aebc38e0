//! Triangles of meshes and height fields with what lies across their edges.

use super::poly::TrianglePoly;
use crate::shapes::height_field::HeightField;
use crate::{Aabb, NO_SUB, TriMesh};
use jounce_math::Vec3;

/// Sine of the angle from which an edge counts as convex (0.5°); flatter ones are internal.
const CONVEX_SINE: f32 = 0.0087;

/// Most pieces that a sweep over a height field is cut into.
const SWEEP_STRETCHES_MAX: usize = 256;

/// Ridges up to this angle (cosine; 8°) are as good as flat for bodies with faces.
const GENTLE_COSINE: f32 = 0.990_27;

/// Bits of `TriMesh::edge_flags` that say so, of the front and of the back.
const GENTLE_BIT: [u8; 2] = [6, 7];

/// What continues the surface across an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Across {
    /// Nothing: the edge is a border.
    Nothing,
    /// A triangle of this normal, turned away from this one: the edge sticks out.
    Convex(Vec3),
    /// A triangle in the same plane, or turned towards this one: the edge cannot be touched.
    Internal,
}

/// A triangle turned to the body that asks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facing {
    index: u32,
    pub corners: [Vec3; 3],
    pub normal: Vec3,
    behind: bool,
}

/// The same with what lies across its edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceTriangle {
    pub poly: TrianglePoly,
    pub across: [Across; 3],
}

/// A surface made of triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Surface<'a> {
    Mesh(&'a TriMesh),
    HeightField(&'a HeightField),
}

impl Surface<'_> {
    /// Calls `f` with each of the triangles whose bounds overlap, in no order that matters.
    pub fn visit(&self, bounds: &Aabb, mut f: impl FnMut(u32)) {
        match self {
            Self::Mesh(m) => m.tree.query(bounds, |t| {
                f(t);
                true
            }),
            Self::HeightField(h) => h.overlapping(bounds, f),
        }
    }

    /// Does `f` hold for all of those triangles? Most of them are not asked after one for which it does not.
    pub fn all(&self, bounds: &Aabb, mut f: impl FnMut(u32) -> bool) -> bool {
        let mut all = true;
        match self {
            Self::Mesh(m) => m.tree.query(bounds, |t| {
                all = f(t);
                all
            }),
            Self::HeightField(h) => h.overlapping(bounds, |t| all = all && f(t)),
        }
        all
    }

    /// Around the whole surface.
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Mesh(m) => m.aabb(),
            Self::HeightField(h) => h.aabb(),
        }
    }

    /// Triangles that a box meets on its way along `motion`, up to the fraction `max_t` and roughly in the order of
    /// meeting. `f(triangle, max_t)` gives the new `max_t`.
    pub fn sweep(&self, start: &Aabb, motion: Vec3, max_t: f32, mut f: impl FnMut(u32, f32) -> f32) {
        let still = motion == Vec3::ZERO;
        match self {
            Self::Mesh(m) if !still => m.tree.ray(start.center(), motion, start.half(), max_t, f),
            _ => {
                // Stretch by stretch, so that a long diagonal does not ask all that lies around it.
                let size = (start.max - start.min).max_component();
                let stretches = 1 + ((motion.length() / (2.0 * size)) as usize).min(SWEEP_STRETCHES_MAX - 1);
                let mut bound = max_t;
                for k in 0..stretches {
                    let at = |k: usize| k as f32 / stretches as f32;
                    if at(k) > bound {
                        return;
                    }
                    let (from, to) = (motion * at(k), motion * at(k + 1));
                    let moved = |d: Vec3| Aabb::new(start.min + d, start.max + d);
                    self.visit(&moved(from).union(&moved(to)), |t| bound = f(t, bound));
                }
            }
        }
    }

    /// Is a triangle of these corners two-sided, or `center` not behind it?
    pub fn faces(&self, index: u32, t: &[Vec3; 3], center: Vec3) -> bool {
        self.is_two_sided() || self.normal(index).is_some_and(|n| n.dot(center - t[0]) >= 0.0)
    }

    /// Corners; `None` for a hole, a degenerate triangle or an index past the end.
    pub fn corners(&self, index: u32) -> Option<[Vec3; 3]> {
        match self {
            Self::Mesh(m) => m.patches.get(index as usize).map(|p| p.corners),
            Self::HeightField(h) => h.triangle(index),
        }
    }

    /// Unit normal of the front.
    pub fn normal(&self, index: u32) -> Option<Vec3> {
        match self {
            Self::Mesh(m) => m.patches.get(index as usize).map(|p| p.normal),
            Self::HeightField(_) => {
                let [a, b, c] = self.corners(index)?;
                // Never zero: the corners are apart in x and z.
                let n = (b - a).cross(c - a);
                Some(n * (1.0 / n.length()))
            }
        }
    }

    /// The triangle's number in the list that the surface was built from.
    pub fn name(&self, index: u32) -> u32 {
        match self {
            Self::Mesh(m) => m.patches.get(index as usize).map_or(index, |p| p.source),
            Self::HeightField(_) => index,
        }
    }

    /// Is an edge known to be flat or concave, seen from the front?
    fn is_internal(&self, index: u32, edge: usize) -> bool {
        matches!(self, Self::Mesh(m) if m.edge_flags.get(index as usize).is_some_and(|f| f >> edge & 1 == 0))
    }

    fn neighbor(&self, index: u32, edge: usize) -> u32 {
        match self {
            Self::Mesh(m) => m.patches.get(index as usize).map_or(NO_SUB, |p| p.neighbors[edge]),
            Self::HeightField(h) => height_field_neighbor(h, index, edge).unwrap_or(NO_SUB),
        }
    }

    pub fn is_two_sided(&self) -> bool {
        matches!(self, Self::Mesh(m) if m.double_sided)
    }

    /// The side of a triangle that looks at `center`; `None` where that is the back of a one-sided surface.
    pub fn facing(&self, index: u32, center: Vec3) -> Option<Facing> {
        let mut corners = self.corners(index)?;
        let mut normal = self.normal(index)?;
        let behind = normal.dot(center - corners[0]) < 0.0;
        if behind {
            if !self.is_two_sided() {
                return None;
            }
            corners.swap(1, 2);
            normal = -normal;
        }
        Some(Facing { index, corners, normal, behind })
    }

    /// What lies across edge `k`.
    fn across(&self, t: &Facing, k: usize) -> Across {
        if !t.behind && self.is_internal(t.index, k) {
            return Across::Internal;
        }
        // Edges 0, 1, 2 of a turned triangle are edges 2, 1, 0 of the given one.
        let other = self.neighbor(t.index, if t.behind { 2 - k } else { k });
        let Some(m) = (other != NO_SUB).then(|| self.normal(other)).flatten() else {
            return Across::Nothing;
        };
        let m = if t.behind { -m } else { m };
        let edge = t.corners[(k + 1) % 3] - t.corners[k];
        let out = edge.cross(t.normal);
        if m.dot(out) > CONVEX_SINE * out.length() { Across::Convex(m) } else { Across::Internal }
    }

    /// Nothing sticks out at any edge by more than a gentle slope: only the face can be touched.
    pub fn is_gentle(&self, t: &Facing) -> bool {
        match self {
            Self::Mesh(m) => m.edge_flags[t.index as usize] >> GENTLE_BIT[usize::from(t.behind)] & 1 != 0,
            Self::HeightField(_) => self.finds_gentle(t),
        }
    }

    /// Flags of a triangle's two sides that are gentle.
    pub fn gentle_flags(&self, index: u32) -> u8 {
        let (Some(corners), Some(normal)) = (self.corners(index), self.normal(index)) else { return 0 };
        let [a, b, c] = corners;
        let front = Facing { index, corners, normal, behind: false };
        let back = Facing { index, corners: [a, c, b], normal: -normal, behind: true };
        let bit = |t: &Facing| u8::from(self.finds_gentle(t)) << GENTLE_BIT[usize::from(t.behind)];
        bit(&front) | if self.is_two_sided() { bit(&back) } else { 0 }
    }

    fn finds_gentle(&self, t: &Facing) -> bool {
        (0..3).all(|k| match self.across(t, k) {
            Across::Internal => true,
            Across::Convex(m) => m.dot(t.normal) > GENTLE_COSINE,
            Across::Nothing => false,
        })
    }

    /// With all that contacts at its edges need.
    pub fn full(&self, t: &Facing) -> SurfaceTriangle {
        let across = core::array::from_fn(|k| self.across(t, k));
        SurfaceTriangle { poly: TrianglePoly::new(t.corners, t.normal), across }
    }
}

impl SurfaceTriangle {
    /// May the surface push along the unit vector `c`? Not where `c` leans over an internal edge, nor where it leans
    /// further than the normal of the triangle across a convex one.
    pub fn allows(&self, c: Vec3) -> bool {
        let asked = self.edges_along(c);
        (0..3).all(|k| !asked[k] || self.allows_at(k, c))
    }

    /// Does `c` lean over a border?
    pub fn is_border(&self, c: Vec3) -> bool {
        let asked = self.edges_along(c);
        (0..3).any(|k| asked[k] && self.across[k] == Across::Nothing)
    }

    /// The edges that can be touched along `c`: those at the corner that lies farthest along it, or the one edge whose
    /// both ends do.
    fn edges_along(&self, c: Vec3) -> [bool; 3] {
        let n = self.poly.normal();
        let lean = c - n * c.dot(n);
        if lean.length_squared() < 1e-8 {
            return [false; 3];
        }
        let v = self.poly.vertices;
        let s = [0.0, lean.dot(v[1] - v[0]), lean.dot(v[2] - v[0])];
        let top = Vec3::from_array(s).max_component();
        let bottom = Vec3::from_array(s).min_component();
        let on = s.map(|x| top - x <= 0.01 * (top - bottom));
        let edge = (0..3).find(|&k| on[k] && on[(k + 1) % 3]);
        core::array::from_fn(|k| match edge {
            Some(e) => k == e,
            None => on[k] || on[(k + 1) % 3],
        })
    }

    fn allows_at(&self, k: usize, c: Vec3) -> bool {
        let side = self.poly.side(k);
        match self.across[k] {
            Across::Internal => c.dot(side) <= 1e-4,
            // Into the neighbour, along its plane: e × m with e the edge, as side = e × n.
            Across::Convex(m) => {
                let e = self.poly.normal().cross(side);
                c.dot(e.cross(m)) <= 0.01
            }
            Across::Nothing => c.dot(self.poly.normal()) >= -0.01,
        }
    }
}

/// Even triangles have corners (i, j), (i, j+1), (i+1, j+1), odd ones (i, j), (i+1, j+1), (i+1, j).
fn height_field_neighbor(h: &HeightField, index: u32, edge: usize) -> Option<u32> {
    let cells = h.columns() - 1;
    let cell = index as usize / 2;
    let (i, j) = (cell % cells, cell / cells);
    let at = |i: usize, j: usize, odd: usize| (2 * (j * cells + i) + odd) as u32;
    match (index % 2, edge) {
        (0, 0) => (i > 0).then(|| at(i - 1, j, 1)),
        (0, 1) => (j + 2 < h.rows()).then(|| at(i, j + 1, 1)),
        (0, _) => Some(index + 1),
        (_, 0) => Some(index - 1),
        (_, 1) => (i + 1 < cells).then(|| at(i + 1, j, 0)),
        _ => (j > 0).then(|| at(i, j - 1, 0)),
    }
}
