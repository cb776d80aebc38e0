//! The part of a solid on one side of a plane: what a liquid with a flat surface holds up.
//!
//! ```text
//! S = { x ∈ shape : n·x ≤ d }     V = ∫_S dV     b = 1/V ∫_S x dV     W = area of shape ∩ { n·x = d }
//! ```
//!
//! n the surface's unit normal, d its offset, V the displaced volume, b the centre of buoyancy, W the waterplane's
//! area; dV/dd = W, so ρ g W is the stiffness that holds a floating body at its height. Exact to rounding for every
//! solid: each volume is turned into integrals over the faces by the divergence theorem (Mirtich 1996, "Fast and
//! Accurate Computation of Polyhedral Mass Properties"), with a field chosen so that the curved faces, or the cut,
//! add nothing. A ball has the closed forms of its cap of depth t = d + r: V = π t² (3r − t)/3,
//! ∫ n·x dV = −π/4 (r² − d²)², W = π (r² − d²).

mod flat;
mod round;

use super::{Compound, Shape, capsule, cone, cuboid, cylinder, sphere};
use core::f64::consts::PI;
use jounce_math::{DQuat, DVec3, scalar::f64s};
use round::Tilt;

/// Below this fraction of the whole, rounding may push a centroid off the sliver it belongs to.
const SLIVER: f64 = 1e-6;
/// Below this fraction of the whole, a round shape's part is all rounding.
const NOISE: f64 = 1e-15;

/// The part of a solid below a plane; see [`Shape::submerged`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Submerged {
    /// Volume of the part, m³.
    pub volume: f64,
    /// Centroid of the part in the shape's frame, metres; the whole shape's where the volume is 0.
    pub center: DVec3,
    /// Area of the shape's section with the plane, m²; 0 where the plane misses or only touches it.
    pub waterplane: f64,
}

/// Volume, first moment about the frame's origin, and area of the cut. Parts add up.
#[derive(Clone, Copy, Debug)]
struct Part {
    volume: f64,
    moment: DVec3,
    waterplane: f64,
}

impl Part {
    const NONE: Self = Self { volume: 0.0, moment: DVec3::ZERO, waterplane: 0.0 };

    fn whole(shape: &Shape) -> Self {
        let (volume, center) = shape.volume_and_center();
        Self { volume, moment: center * volume, waterplane: 0.0 }
    }
}

impl Shape {
    /// Volume, m³; 0 for shapes without inside. Overlapping children of a compound count twice.
    pub fn volume(&self) -> f64 {
        self.volume_and_center().0
    }

    /// The part with normal · x ≤ offset: its volume, its centroid and the area of the cut. `normal` is a unit
    /// vector in the shape's frame, `offset` in metres. Overlapping children of a compound count twice; shapes
    /// without inside give no volume, and so does a plane that is not finite. Volume and volume × centroid are good to
    /// some 1e-15 of the whole's.
    ///
    /// ```
    /// use jounce_geometry::Shape;
    /// use jounce_math::DVec3;
    /// // A ball a quarter as dense as water sinks to 0.326352 of its diameter.
    /// let s = Shape::Sphere { radius: 0.5 }.submerged(DVec3::Y, 0.326352 - 0.5);
    /// assert!((s.volume / Shape::Sphere { radius: 0.5 }.volume() - 0.25).abs() < 1e-6);
    /// ```
    pub fn submerged(&self, normal: DVec3, offset: f64) -> Submerged {
        // A normal that was turned in f32 is a few roundings off its length.
        let part = match normal.try_normalize() {
            Some((n, length)) if n.is_finite() => self.below(n, offset / length),
            _ => Part::NONE,
        };
        let center =
            if part.volume > 0.0 { part.moment * (1.0 / part.volume) } else { self.volume_and_center().1 };
        Submerged { volume: part.volume, center, waterplane: part.waterplane }
    }

    /// Volume and centroid of the whole, in `f64`.
    fn volume_and_center(&self) -> (f64, DVec3) {
        match self {
            Self::Sphere { radius } => sphere::volume(*radius),
            Self::Capsule { half_height, radius } => capsule::volume(*half_height, *radius),
            Self::Box { half } => cuboid::volume(*half),
            Self::Cylinder { half_height, radius } => cylinder::volume(*half_height, *radius),
            Self::Cone { half_height, radius } => cone::volume(*half_height, *radius),
            Self::Hull(h) => (h.volume, h.centroid),
            Self::Compound(c) => {
                let all = sum(c, |shape, _, _| Part::whole(shape));
                let center = if all.volume > 0.0 { all.moment * (1.0 / all.volume) } else { DVec3::ZERO };
                (all.volume, center)
            }
            Self::HalfSpace { .. } | Self::Mesh(_) | Self::HeightField(_) => (0.0, DVec3::ZERO),
        }
    }

    fn below(&self, n: DVec3, d: f64) -> Part {
        let round = |f: fn(f64, f64, &Tilt) -> round::Part, h: f32, r: f32| {
            let (tilt, u) = Tilt::new(n, d);
            let p = f(f64::from(h), f64::from(r), &tilt);
            let part = Part { volume: p.volume, moment: u * p.u + DVec3::Y * p.y, waterplane: p.waterplane };
            if p.volume > NOISE * self.volume() { part } else { Part { volume: 0.0, ..part } }
        };
        let (low, high) = self.reach(n);
        if d.is_nan() || d <= low {
            return Part::NONE;
        }
        if d >= high {
            return Part::whole(self);
        }
        let part = match self {
            Self::Sphere { radius } => ball(f64::from(*radius), n, d),
            Self::Capsule { half_height, radius } => round(round::capsule, *half_height, *radius),
            Self::Box { half } => flat::cuboid(half.as_dvec3(), n, d),
            Self::Cylinder { half_height, radius } => round(round::cylinder, *half_height, *radius),
            Self::Cone { half_height, radius } => round(round::cone, *half_height, *radius),
            Self::Hull(h) => flat::hull(h, n, d),
            Self::Compound(c) => {
                return sum(c, |shape, q, p| shape.below(q.inverse_rotate(n), d - n.dot(p)));
            }
            Self::HalfSpace { .. } | Self::Mesh(_) | Self::HeightField(_) => return Part::NONE,
        };
        self.settle(part, n, d)
    }

    /// Smallest and largest n·x of the shape: exact, except for a hull, that has its bounds', and a compound, whose
    /// children look for themselves.
    fn reach(&self, n: DVec3) -> (f64, f64) {
        let around = |half: f64| (-half, half);
        let a = (n.x * n.x + n.z * n.z).sqrt();
        match self {
            Self::Sphere { radius } => around(f64::from(*radius)),
            Self::Capsule { half_height, radius } => {
                around(n.y.abs() * f64::from(*half_height) + f64::from(*radius))
            }
            Self::Box { half } => around(n.abs().dot(half.as_dvec3())),
            Self::Cylinder { half_height, radius } => {
                around(n.y.abs() * f64::from(*half_height) + a * f64::from(*radius))
            }
            Self::Cone { half_height, radius } => {
                let (tip, rim) = (n.y * f64::from(*half_height), a * f64::from(*radius));
                (f64s::min(tip, -tip - rim), f64s::max(tip, -tip + rim))
            }
            Self::Hull(h) => {
                let (min, max) = (h.aabb.min.as_dvec3(), h.aabb.max.as_dvec3());
                let (mid, half) = (n.dot((min + max) * 0.5), n.abs().dot((max - min) * 0.5));
                (mid - half, mid + half)
            }
            Self::Compound(_) => (f64::NEG_INFINITY, f64::INFINITY),
            Self::HalfSpace { .. } | Self::Mesh(_) | Self::HeightField(_) => (0.0, 0.0),
        }
    }

    /// Keeps rounding from making a part negative or larger than the whole, and the centroid of a sliver where the
    /// sliver is.
    fn settle(&self, mut part: Part, n: DVec3, d: f64) -> Part {
        let whole = self.volume_and_center().0;
        if part.volume <= 0.0 {
            return Part { waterplane: f64s::max(part.waterplane, 0.0), ..Part::NONE };
        }
        part.volume = f64s::min(part.volume, whole);
        part.waterplane = f64s::max(part.waterplane, 0.0);
        if part.volume < SLIVER * whole {
            let c = part.moment * (1.0 / part.volume);
            let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| self.reach(axis));
            let c = c.clamp(DVec3::new(x.0, y.0, z.0), DVec3::new(x.1, y.1, z.1));
            part.moment = (c - n * f64s::max(n.dot(c) - d, 0.0)) * part.volume;
        }
        part
    }
}

fn ball(r: f64, n: DVec3, d: f64) -> Part {
    let t = d + r;
    let chord2 = t * (r - d);
    Part {
        volume: PI / 3.0 * t * t * (3.0 * r - t),
        moment: n * (-0.25 * PI * chord2 * chord2),
        waterplane: PI * chord2,
    }
}

/// A compound's parts, each found in its child's frame, where the child stands at (q, p).
fn sum(c: &Compound, part: impl Fn(&Shape, DQuat, DVec3) -> Part) -> Part {
    c.children.iter().fold(Part::NONE, |sum, (pose, shape)| {
        // A pose is f32 and so not quite a rotation; the children's volumes must not feel that.
        let (q, p) = (pose.q.as_dquat().normalize(), pose.p.as_dvec3());
        let part = part(shape, q, p);
        Part {
            volume: sum.volume + part.volume,
            moment: sum.moment + q.rotate(part.moment) + p * part.volume,
            waterplane: sum.waterplane + part.waterplane,
        }
    })
}
