//! Convex hull of points as closed triangles (Barber, Dobkin and Huhdanpaa 1996, "The Quickhull Algorithm for
//! Convex Hulls").
//!
//! The points are rounded to a grid of 2²⁹ steps across their extent (finer than `f32` itself). Differences then
//! have 30 bits, normals 61 and plane tests 93: with integers the question "is p in front of this face" has
//! one answer, so the visible faces always form a disc, the horizon is always one loop, and no new face is ever
//! flat. What rounding does to other quickhulls cannot happen here; tolerance only decides which points are worth
//! a vertex.
//!
//! The farthest point of all is added first, so that stopping at the most vertices allowed keeps the most extreme.

use jounce_math::{DVec3, Vec3};

const NONE: u32 = u32::MAX;
/// Half the grid.
const GRID: f64 = (1u64 << 28) as f64;

/// A triangle of the hull.
#[derive(Clone, Debug)]
pub(super) struct Face {
    /// Corners (point indices), counter-clockwise from outside.
    pub v: [u32; 3],
    /// Face across the edge from corner k to corner k + 1.
    pub adj: [u32; 3],
    /// Exact normal, not unit, in grid steps squared.
    pub n: [i64; 3],
    /// Unit normal.
    pub unit: DVec3,
    /// Points in front, all farther than the tolerance.
    outside: Vec<u32>,
    /// The farthest of them and its distance.
    far: (f64, u32),
    pub alive: bool,
}

/// Hull in the making.
pub(super) struct QuickHull {
    /// Points in grid steps.
    pub grid: Vec<[i64; 3]>,
    points: Vec<DVec3>,
    pub faces: Vec<Face>,
    /// Distance below which a point is not worth a vertex, grid steps.
    pub tolerance: f64,
    visible: Vec<u32>,
    horizon: Vec<Edge>,
    mark: Vec<u32>,
    /// Points left out although some face had them in front by less than the tolerance.
    near: Vec<u32>,
}

/// A directed edge of the horizon: its left side was visible; `outer` is the face that stays.
#[derive(Clone, Copy)]
struct Edge {
    a: u32,
    b: u32,
    outer: u32,
    slot: usize,
}

/// Why there is no hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Flat {
    Point,
    Collinear,
    Coplanar,
    Thin,
}

impl QuickHull {
    /// Points on the grid: `center` and `half_extent` from their bounds, `tolerance` in metres.
    pub fn new(points: &[Vec3], center: DVec3, half_extent: f64, tolerance: f64) -> Self {
        let scale = GRID / half_extent;
        let grid: Vec<[i64; 3]> = points
            .iter()
            .map(|p| {
                let g = (p.as_dvec3() - center) * scale;
                [g.x.round_ties_even() as i64, g.y.round_ties_even() as i64, g.z.round_ties_even() as i64]
            })
            .collect();
        let points: Vec<DVec3> =
            grid.iter().map(|g| DVec3::new(g[0] as f64, g[1] as f64, g[2] as f64)).collect();
        let mark = vec![NONE; grid.len()];
        Self {
            grid,
            points,
            faces: Vec::new(),
            tolerance: tolerance * scale,
            visible: Vec::new(),
            horizon: Vec::new(),
            mark,
            near: Vec::new(),
        }
    }

    /// Builds the hull with at most `vertices_max` vertices.
    pub fn run(&mut self, vertices_max: usize) -> Result<(), Flat> {
        let corners = self.first_tetrahedron()?;
        self.start(corners);
        for _ in corners.len()..vertices_max {
            let next = self
                .faces
                .iter()
                .zip(0u32..)
                .filter(|(f, _)| f.alive && f.far.1 != NONE)
                .fold((0.0, NONE), |best, (f, i)| if f.far.0 > best.0 { (f.far.0, i) } else { best });
            if next.1 != NONE {
                self.add(next.1);
            } else if !self.reconsider() {
                break;
            }
        }
        Ok(())
    }

    /// Asks the points that were left out for being near a face again: that face may be gone, or have been
    /// near only in the sense of its plane. True if one is in front of a face after all.
    fn reconsider(&mut self) -> bool {
        let near = core::mem::take(&mut self.near);
        let mut found = false;
        for p in near {
            found |= self.assign(p, 0);
        }
        found
    }

    /// Four points that span much: the two farthest apart along an axis, the one farthest from their line, the
    /// one farthest from that plane. Ordered so that the last lies behind the first three.
    fn first_tetrahedron(&self) -> Result<[u32; 4], Flat> {
        let p = &self.points;
        let (mut a, mut b, mut widest) = (0, 0, 0.0);
        for axis in 0..3 {
            let low = farthest(p, |q| -q[axis]).0;
            let high = farthest(p, |q| q[axis]).0;
            let width = (p[high as usize] - p[low as usize]).length();
            if width > widest {
                (a, b, widest) = (low, high, width);
            }
        }
        let (pa, Some((along, _))) = (p[a as usize], (p[b as usize] - p[a as usize]).try_normalize()) else {
            return Err(Flat::Point);
        };
        let (c, d2) = farthest(p, |q| (q - pa - along * (q - pa).dot(along)).length_squared());
        let thin = 1.5 * self.tolerance;
        let rounding = 64.0;
        if d2 <= thin * thin {
            return Err(if d2 <= rounding * rounding { Flat::Collinear } else { Flat::Thin });
        }
        let n = unit(cross(&self.grid, a, b, c));
        let (above, below) = (farthest(p, |q| n.dot(q - pa)), farthest(p, |q| -n.dot(q - pa)));
        let height = if above.1 > below.1 { above.1 } else { below.1 };
        if above.1 + below.1 <= thin {
            return Err(if height <= rounding { Flat::Coplanar } else { Flat::Thin });
        }
        Ok(if above.1 > below.1 { [a, c, b, above.0] } else { [a, b, c, below.0] })
    }

    fn start(&mut self, [a, b, c, d]: [u32; 4]) {
        // Edge k of a face runs from corner k to k + 1; the neighbours follow from the shared corners.
        for (v, adj) in
            [([a, b, c], [1, 2, 3]), ([b, a, d], [0, 3, 2]), ([c, b, d], [0, 1, 3]), ([a, c, d], [0, 2, 1])]
        {
            self.push_face(v, adj);
        }
        for p in 0..self.points.len() as u32 {
            self.assign(p, 0);
        }
    }

    fn push_face(&mut self, v: [u32; 3], adj: [u32; 3]) {
        let n = cross(&self.grid, v[0], v[1], v[2]);
        debug_assert!(n != [0; 3], "a face without area");
        let far = (0.0, NONE);
        self.faces.push(Face { v, adj, n, unit: unit(n), outside: Vec::new(), far, alive: true });
    }

    /// Distance in front of a face, grid steps.
    #[inline]
    fn height(&self, face: u32, p: u32) -> f64 {
        let f = &self.faces[face as usize];
        f.unit.dot(self.points[p as usize] - self.points[f.v[0] as usize])
    }

    /// Exactly in front?
    #[inline]
    fn sees(&self, p: u32, face: u32) -> bool {
        let f = &self.faces[face as usize];
        let (a, q) = (self.grid[f.v[0] as usize], self.grid[p as usize]);
        (0..3).map(|k| i128::from(f.n[k]) * i128::from(q[k] - a[k])).sum::<i128>() > 0
    }

    /// Gives a point to a face from `first` on that it stands in front of. A point that was in front of a removed
    /// face and is behind all new ones is inside; one in between, within the tolerance of a new face, may
    /// still be far in front of an old one and is kept for later.
    /// True if it was given.
    fn assign(&mut self, p: u32, first: usize) -> bool {
        let mut near = false;
        let end = self.faces.len();
        for f in first..end {
            if self.faces[f].alive {
                let h = self.height(f as u32, p);
                if h > self.tolerance {
                    self.give(f as u32, p, h);
                    return true;
                }
                near |= h > 1e-3;
            }
        }
        if near {
            self.near.push(p);
        }
        false
    }

    fn give(&mut self, face: u32, p: u32, height: f64) {
        let f = &mut self.faces[face as usize];
        f.outside.push(p);
        if height > f.far.0 {
            f.far = (height, p);
        }
    }

    /// Adds the farthest point of a face as a vertex.
    fn add(&mut self, face: u32) {
        let p = self.faces[face as usize].far.1;
        self.find_horizon(p, face);
        let first = self.faces.len();
        let count = self.horizon.len() as u32;
        // The new face that starts at each horizon vertex.
        for (e, k) in self.horizon.iter().zip(0u32..) {
            self.mark[e.a as usize] = first as u32 + k;
        }
        for k in 0..count {
            let e = self.horizon[k as usize];
            let me = first as u32 + k;
            let next = self.mark[e.b as usize];
            self.push_face([e.a, e.b, p], [e.outer, next, NONE]);
            self.faces[e.outer as usize].adj[e.slot] = me;
        }
        for k in first..self.faces.len() {
            let next = self.faces[k].adj[1];
            debug_assert!((first as u32..first as u32 + count).contains(&next));
            self.faces[next as usize].adj[2] = k as u32;
        }
        let visible = core::mem::take(&mut self.visible);
        for &f in &visible {
            for q in core::mem::take(&mut self.faces[f as usize].outside) {
                if q != p {
                    self.assign(q, first);
                }
            }
        }
        self.visible = visible;
    }

    /// Removes the faces that `p` sees and lists the edges around them.
    fn find_horizon(&mut self, p: u32, face: u32) {
        self.visible.clear();
        self.horizon.clear();
        self.faces[face as usize].alive = false;
        self.visible.push(face);
        let mut k = 0;
        while let Some(&f) = self.visible.get(k) {
            k += 1;
            for slot in 0..3 {
                let other = self.faces[f as usize].adj[slot];
                if !self.faces[other as usize].alive {
                    continue;
                }
                if self.sees(p, other) {
                    self.faces[other as usize].alive = false;
                    self.visible.push(other);
                } else {
                    let v = self.faces[f as usize].v;
                    let back = self.faces[other as usize].adj.iter().position(|&g| g == f).unwrap_or(0);
                    self.horizon.push(Edge { a: v[slot], b: v[(slot + 1) % 3], outer: other, slot: back });
                }
            }
        }
    }

    /// Depth of a point behind a face, grid steps.
    pub fn depth(&self, face: &Face, p: u32) -> f64 {
        -face.unit.dot(self.points[p as usize] - self.points[face.v[0] as usize])
    }
    pub fn point(&self, p: u32) -> DVec3 {
        self.points[p as usize]
    }
}

/// Index and value of the largest; the first of equals.
fn farthest(points: &[DVec3], value: impl Fn(DVec3) -> f64) -> (u32, f64) {
    points.iter().zip(0u32..).fold((0, f64::NEG_INFINITY), |best, (&p, i)| {
        let v = value(p);
        if v > best.1 { (i, v) } else { best }
    })
}

fn cross(grid: &[[i64; 3]], a: u32, b: u32, c: u32) -> [i64; 3] {
    let (a, b, c) = (grid[a as usize], grid[b as usize], grid[c as usize]);
    let u: [i64; 3] = core::array::from_fn(|k| b[k] - a[k]);
    let v: [i64; 3] = core::array::from_fn(|k| c[k] - a[k]);
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn unit(n: [i64; 3]) -> DVec3 {
    DVec3::new(n[0] as f64, n[1] as f64, n[2] as f64).normalize_or(DVec3::Y)
}
