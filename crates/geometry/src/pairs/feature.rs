//! What a convex shape shows in a direction: a face, an edge or a point, as a polygon to clip.

use super::poly::{BoxPoly, Poly, TrianglePoly};
use crate::Shape;
use crate::convex::core::{Core, rim};
use jounce_math::{Vec3, scalar::f32s};

/// Corners of a cap's polygon. The first lies where the disc is lowest.
const CAP_CORNERS: usize = 8;
/// Half of √2.
const DIAGONAL: f32 = core::f32::consts::FRAC_1_SQRT_2;
const CAP: [(f32, f32); CAP_CORNERS] = [
    (1.0, 0.0),
    (DIAGONAL, DIAGONAL),
    (0.0, 1.0),
    (-DIAGONAL, DIAGONAL),
    (-1.0, 0.0),
    (-DIAGONAL, -DIAGONAL),
    (0.0, -1.0),
    (DIAGONAL, -DIAGONAL),
];

/// A corner of a polygon and the lines that meet there. Lines of the shape itself count from 0, those of the
/// reference face from [`REFERENCE_LINE`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Corner {
    pub p: Vec3,
    pub before: u16,
    pub after: u16,
}

pub(crate) const REFERENCE_LINE: u16 = 0x100;

/// Flat faces, where the shape has any.
#[derive(Clone, Copy, Debug)]
enum Flat<'a> {
    None,
    Box(BoxPoly),
    Poly(Poly<'a>),
    Triangle(TrianglePoly),
}

/// A convex shape as the pair tests see it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Convex<'a> {
    pub core: Core<'a>,
    pub radius: f32,
    flat: Flat<'a>,
}

/// A flat face: normal · x = offset (core surface), and its number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FlatFace {
    pub normal: Vec3,
    pub offset: f32,
    pub index: u32,
}

impl<'a> Convex<'a> {
    /// `None` for a shape that is not convex.
    #[inline]
    pub fn of(shape: &'a Shape) -> Option<Self> {
        let (core, radius) = Core::of(shape)?;
        Some(Self::of_core(core, radius))
    }
    /// From a core and a radius.
    #[inline]
    pub fn of_core(core: Core<'a>, radius: f32) -> Self {
        let flat = match core {
            Core::Box(h) => Flat::Box(BoxPoly::new(h)),
            Core::Hull(h) => Flat::Poly(Poly::from(h)),
            Core::Triangle([a, b, c]) => {
                let n = (b - a).cross(c - a).normalize_or(Vec3::Y);
                Flat::Triangle(TrianglePoly::new([a, b, c], n))
            }
            _ => Flat::None,
        };
        Self { core, radius, flat }
    }
    pub fn triangle(t: TrianglePoly) -> Self {
        Self { core: Core::Triangle(t.vertices), radius: 0.0, flat: Flat::Triangle(t) }
    }
    /// The polyhedron, where it is one.
    #[inline]
    pub fn poly(&self) -> Option<Poly<'_>> {
        match &self.flat {
            Flat::None => None,
            Flat::Box(b) => Some(b.view()),
            Flat::Poly(p) => Some(*p),
            Flat::Triangle(t) => Some(t.view()),
        }
    }
    /// A point well inside.
    pub fn center(&self) -> Vec3 {
        self.core.center()
    }
    /// A length of the order of the shape's thickness, for tolerances.
    pub fn thickness(&self) -> f32 {
        match self.core {
            Core::Point | Core::Segment(_) => self.radius,
            Core::Box(h) => h.min_component(),
            Core::Cylinder(h, r) | Core::Cone(h, r) => f32s::min(h, r),
            Core::Hull(h) => h.inner_radius(),
            Core::Triangle(_) => f32::MAX,
        }
    }
    /// The flat face that looks most along `d` (unit).
    pub fn flat_face(&self, d: Vec3) -> Option<FlatFace> {
        if let Some(p) = self.poly() {
            let index = p.face_along(d);
            let f = p.faces.get(index)?;
            return Some(FlatFace { normal: f.normal, offset: f.offset, index: index as u32 });
        }
        match self.core {
            Core::Cylinder(h, _) if d.y > 0.0 => Some(FlatFace { normal: Vec3::Y, offset: h, index: 1 }),
            Core::Cylinder(h, _) | Core::Cone(h, _) if d.y < 0.0 => {
                Some(FlatFace { normal: -Vec3::Y, offset: h, index: 0 })
            }
            _ => None,
        }
    }
    /// The face that [`Convex::feature`] would show of a hull.
    pub fn face_shown(&self, d: Vec3) -> Option<u32> {
        match &self.flat {
            Flat::Poly(p) => Some(shown(p, d) as u32),
            _ => None,
        }
    }
    /// The corners that the shape's core shows along `d` (unit), counter-clockwise seen from there; holds a support
    /// point. Returns a number for the feature.
    pub fn feature(&self, d: Vec3, out: &mut Vec<Corner>) -> u32 {
        out.clear();
        if let Some(p) = self.poly() {
            return poly_feature(&p, d, out);
        }
        let mut put = |p: Vec3, k: usize, n: usize| {
            out.push(Corner { p, before: ((k + n - 1) % n) as u16, after: k as u16 });
        };
        match self.core {
            Core::Segment(h) => {
                put(Vec3::new(0.0, -h, 0.0), 0, 2);
                put(Vec3::new(0.0, h, 0.0), 1, 2);
                0
            }
            Core::Cylinder(h, r) if d.y.abs() < DIAGONAL => {
                let (x, z) = rim(d, r);
                put(Vec3::new(x, -h, z), 0, 2);
                put(Vec3::new(x, h, z), 1, 2);
                2
            }
            Core::Cylinder(h, r) => cap(d, if d.y > 0.0 { h } else { -h }, r, out),
            Core::Cone(h, r) => {
                let lateral = (d.x * d.x + d.z * d.z).sqrt();
                let l = (4.0 * h * h + r * r).sqrt();
                if (lateral * 2.0 * h + d.y * r) < -d.y * l {
                    return cap(d, -h, r, out);
                }
                let (x, z) = rim(d, r);
                put(Vec3::new(x, -h, z), 0, 2);
                put(Vec3::new(0.0, h, 0.0), 1, 2);
                2
            }
            _ => {
                put(Vec3::ZERO, 0, 1);
                0
            }
        }
    }
}

/// The face that looks most along `d` and holds a support point.
fn shown(p: &Poly, d: Vec3) -> usize {
    let lowest = p.support(d);
    let far = p.vertices[lowest].dot(d);
    let tolerance = 1e-5 * (far - p.center.dot(d)).abs();
    let mut f = p.face_along(d);
    let reaches = |&v: &u16| p.vertices[usize::from(v)].dot(d) >= far - tolerance;
    if !p.face_loop(f).iter().any(reaches) {
        let mut best = f32::NEG_INFINITY;
        for (i, face) in p.real_faces().iter().enumerate() {
            let along = face.normal.dot(d);
            if along > best && p.face_loop(i).iter().any(|&v| usize::from(v) == lowest) {
                (best, f) = (along, i);
            }
        }
    }
    f
}

fn poly_feature(p: &Poly, d: Vec3, out: &mut Vec<Corner>) -> u32 {
    let f = shown(p, d);
    let l = p.face_loop(f);
    let n = l.len();
    for (k, &v) in l.iter().enumerate() {
        let p = p.vertices[usize::from(v)];
        out.push(Corner { p, before: ((k + n - 1) % n) as u16, after: k as u16 });
    }
    f as u32
}

/// The disc at height `y` as a polygon. Corners stay fixed on the shape while it stands upright, and turn with the
/// lowest point once it leans (by more than about half a degree).
fn cap(d: Vec3, y: f32, r: f32, out: &mut Vec<Corner>) -> u32 {
    let lateral = (d.x * d.x + d.z * d.z).sqrt();
    let (c, s) = if lateral > 0.01 { (d.x / lateral, d.z / lateral) } else { (1.0, 0.0) };
    for k in 0..CAP_CORNERS {
        // Counter-clockwise from above is z towards x.
        let (cos, sin) = if y > 0.0 { CAP[(CAP_CORNERS - k) % CAP_CORNERS] } else { CAP[k] };
        let p = Vec3::new(r * (c * cos - s * sin), y, r * (s * cos + c * sin));
        out.push(Corner { p, before: ((k + CAP_CORNERS - 1) % CAP_CORNERS) as u16, after: k as u16 });
    }
    u32::from(y > 0.0)
}
