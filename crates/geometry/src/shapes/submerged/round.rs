//! Solids of revolution below a plane.
//!
//! In the plane through the axis and the normal, u outward and y along the axis, the liquid is a u + c y ≤ d,
//! a ≥ 0, a² + c² = 1. The cut lies at (u, y) = d (a, c) + q (−c, a), q its arc length; there the solid of profile
//! radius R(y) is 2√Q wide, Q = R² − u² = (R + u)(R − u).
//!
//! ```text
//! cylinder, Y = y + h:  the field Y ŷ has divergence 1 and runs along the side
//!     V = 2h S₁ + c ∫Y dA     ∫Y dV = 2h² S₁ + c/2 ∫Y² dA     ∫u dV = 2h S_u + c ∫Y u dA
//! cone, x from its tip:  the field x/3 has divergence 1 and runs along the side
//!     V = 2h/3 S₁ + (d − c h)/3 W     ∫x dV = ¾ (2h/3 ∫x dS + (d − c h)/3 ∫x dA)
//! half ball r = 1, y ≥ 0, cut by |d| < a:  the field x/3 is 1/3 on the sphere and runs along the flat side
//!     V = (2β + 2αd + d W)/3     ∫x dV = ½ (ŷ J(1, d/a) − n J(ρ, d c/a))     ρ² = 1 − d²
//! ```
//!
//! dA = 2√Q dq over the cut, W = ∫dA; S₁ and S_u the area and u-moment of the end at y = h (the cone's base at −h)
//! that is below, a segment of its disc. Half ball: 2β + 2αd is the area of its spherical part by Gauss and Bonnet, β
//! the angle between the two planes' circles, 2α the cut circle's arc; the moment is that of the field
//! (|x|² − 1)/2, zero on the sphere, J(ρ, w) = ∫(ρ² − s²) dS over the segment u ≤ w of a disc.
//!
//! Terms of one sign make the cylinder's sums (c ≥ 0 by mirroring) and no difference is divided by a small a or c, so
//! a plane nearly along or nearly across the axis costs no digits. Integrating the segments A(R(y), u(y)) along the
//! axis instead needs an arc tangent at every node, and its integrand is singular near the cone's tip.

use core::f64::consts::PI;
use jounce_math::{DVec3, scalar::f64s};

/// Sine of the tilt below which the plane counts as square to the axis. What that changes is below a·size.
const SQUARE: f64 = 1e-12;

/// The plane a u + c y = d.
pub(super) struct Tilt {
    a: f64,
    c: f64,
    d: f64,
}

impl Tilt {
    /// And the unit vector along u in the shape's frame.
    pub fn new(n: DVec3, d: f64) -> (Self, DVec3) {
        match DVec3::new(n.x, 0.0, n.z).try_normalize() {
            Some((u, a)) if a >= SQUARE => (Self { a, c: n.y, d }, u),
            _ => (Self { a: 0.0, c: 1.0f64.copysign(n.y), d }, DVec3::X),
        }
    }
}

/// Volume, its moments along u and y, and the area of the cut.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub volume: f64,
    pub u: f64,
    pub y: f64,
    pub waterplane: f64,
}

pub(super) fn cylinder(h: f64, r: f64, tilt: &Tilt) -> Part {
    if tilt.c < 0.0 {
        let p = cylinder(h, r, &Tilt { c: -tilt.c, ..*tilt });
        return Part { y: -p.y, ..p };
    }
    let Tilt { a, c, d } = *tilt;
    let end = PI * r * r;
    if d >= a * r + c * h {
        return Part { volume: end * 2.0 * h, u: 0.0, y: 0.0, waterplane: 0.0 };
    }
    if d <= -(a * r + c * h) {
        return Part { volume: 0.0, u: 0.0, y: 0.0, waterplane: 0.0 };
    }
    if a == 0.0 {
        let level = f64s::clamp(d / c, -h, h);
        let volume = end * (level + h);
        return Part { volume, u: 0.0, y: 0.5 * volume * (level - h), waterplane: end };
    }
    let (s1, su) = segment(r, (d - c * h) / a);
    let cut = cut(tilt, r, 0.0, h);
    let level = cut.y + h;
    let y1 = level * cut.m0 + a * cut.m1;
    let y2 = level * level * cut.m0 + 2.0 * level * a * cut.m1 + a * a * cut.m2;
    let yu = level * cut.u * cut.m0 + (a * cut.u - c * level) * cut.m1 - a * c * cut.m2;
    let volume = 2.0 * h * s1 + c * y1;
    let y = 2.0 * h * h * s1 + 0.5 * c * y2 - h * volume;
    Part { volume, u: 2.0 * h * su + c * yu, y, waterplane: cut.m0 }
}

pub(super) fn cone(h: f64, r: f64, tilt: &Tilt) -> Part {
    let Tilt { a, c, d } = *tilt;
    let (height, slope) = (2.0 * h, 0.5 * r / h);
    if a == 0.0 {
        let level = f64s::clamp(d / c, -h, h);
        let (t, k) = (h - level, PI * slope * slope);
        // The tip's side, or what is left below it: H³ − t³ and H⁴ − t⁴ without their differences.
        let (v, m) = if c < 0.0 {
            (t * t * t, t * t * t * t)
        } else {
            let w = (level + h) * (height * height + height * t + t * t);
            (w, (level + h) * (height + t) * (height * height + t * t))
        };
        let volume = k * v / 3.0;
        return Part { volume, u: 0.0, y: h * volume - 0.25 * k * m, waterplane: k * t * t };
    }
    let (s1, su) = segment(r, (d + c * h) / a);
    let cut = cut(tilt, slope * h, -slope, h);
    let (base, side) = (height / 3.0, (d - c * h) / 3.0);
    let volume = base * s1 + side * cut.m0;
    let u = 0.75 * (base * su + side * (cut.u * cut.m0 - c * cut.m1));
    let depth = 0.75 * (base * s1 * height + side * ((h - cut.y) * cut.m0 - a * cut.m1));
    Part { volume, u, y: h * volume - depth, waterplane: cut.m0 }
}

/// The cylinder and the two half balls.
pub(super) fn capsule(h: f64, r: f64, tilt: &Tilt) -> Part {
    let Tilt { a, c, d } = *tilt;
    let middle = cylinder(h, r, tilt);
    let upper = half_ball(&Tilt { a, c, d: (d - c * h) / r });
    let lower = half_ball(&Tilt { a, c: -c, d: (d + c * h) / r });
    let (r2, r3) = (r * r, r * r * r);
    Part {
        volume: middle.volume + (upper.volume + lower.volume) * r3,
        u: middle.u + (upper.u + lower.u) * r3 * r,
        y: middle.y + (upper.y - lower.y) * r3 * r + h * (upper.volume - lower.volume) * r3,
        waterplane: middle.waterplane + (upper.waterplane + lower.waterplane) * r2,
    }
}

/// Half ball y ≥ 0 of radius 1 around the origin.
fn half_ball(tilt: &Tilt) -> Part {
    let Tilt { a, c, d } = *tilt;
    let chord2 = (1.0 - d) * (1.0 + d);
    if d.abs() >= a {
        // The cut leaves the flat side alone, or is it: a whole cap above it (c > 0) or below it (c < 0), or none.
        let wet = d > 0.0 || (d == 0.0 && c > 0.0);
        if d.abs() >= 1.0 || (c > 0.0) != wet {
            let volume = if wet { PI / 1.5 } else { 0.0 };
            return Part { volume, u: 0.0, y: 0.375 * volume, waterplane: 0.0 };
        }
        let t = 1.0 - d.abs();
        let (v, m) = (PI / 3.0 * t * t * (3.0 - t), 0.25 * PI * chord2 * chord2);
        let (volume, y) = if wet { (PI / 1.5 - v, 0.25 * PI - c * m) } else { (v, -c * m) };
        return Part { volume, u: -a * m, y, waterplane: PI * chord2 };
    }
    // Half the chord in which the two planes meet within the ball, times a.
    let s = ((a - d) * (a + d)).sqrt();
    let (alpha, beta) = (f64s::atan2(s, -d * c), f64s::atan2(s, c));
    let waterplane = chord2 * alpha + d * c / a * (s / a);
    let sphere = 2.0 * (beta + d * alpha);
    let (on_flat, on_cut) = (dome(1.0, d / a, s / a), dome(chord2, d * c / a, s / a));
    Part {
        volume: (sphere + d * waterplane) / 3.0,
        u: -0.5 * a * on_cut,
        y: 0.5 * (on_flat - c * on_cut),
        waterplane,
    }
}

/// J(ρ, w) with `half` = √(ρ² − w²).
fn dome(rho2: f64, w: f64, half: f64) -> f64 {
    let angle = f64s::atan2(half, -w);
    (0.5 * rho2 * rho2 * angle) + w * half * (5.0 * rho2 - 2.0 * w * w) / 6.0
}

/// Area of the part u ≤ w of a disc, and its moment along u.
fn segment(r: f64, w: f64) -> (f64, f64) {
    if w >= r {
        return (PI * r * r, 0.0);
    }
    if w <= -r {
        return (0.0, 0.0);
    }
    let half = ((r - w) * (r + w)).sqrt();
    (r * r * f64s::atan2(half, -w) + w * half, -half * half * half / 1.5)
}

/// Moments ∫ tⁱ 2√Q dt of the cut about the middle of its piece, t = q − q of the middle, and where that is.
struct Cut {
    u: f64,
    y: f64,
    m0: f64,
    m1: f64,
    m2: f64,
}

/// The cut of the solid of radius R(y) = r0 + r1 y, |y| ≤ h, by a plane that is not square to its axis.
///
/// √Q has branch points where R = ±u, at the piece's ends or just beyond. The map s = (3t − t³)/2 of the piece between
/// those near it makes √(1 − s²) dt analytic: √(1 ∓ s) = (1 ∓ t) √(1 ± t/2). Its inverse is t = 2 sin(asin(s)/3).
fn cut(tilt: &Tilt, r0: f64, r1: f64, h: f64) -> Cut {
    let Tilt { a, c, d } = *tilt;
    // Both ways give the same q; each divides by the larger of a and c. Through u the ends agree to the last bits with
    // the segments' w, however ill-conditioned w is: an error of both cancels to first order.
    let at = |y: f64| if c.abs() >= a { (a * d - (d - c * y) / a) / c } else { (y - c * d) / a };
    let (bottom, top) = (at(-h), at(h));
    let (mut q0, mut q1) = (bottom, top);
    // The two factors R ± u = p + s q.
    let (r, u) = (r0 + r1 * c * d, a * d);
    let factors = [(r - u, r1 * a + c), (r + u, r1 * a - c)];
    let (mut branch0, mut branch1) = (f64::NEG_INFINITY, f64::INFINITY);
    for (p, s) in factors {
        if s > 0.0 {
            branch0 = f64s::max(branch0, -p / s);
        } else if s < 0.0 {
            branch1 = f64s::min(branch1, -p / s);
        }
    }
    q0 = f64s::max(q0, branch0);
    q1 = f64s::min(q1, branch1);
    let length = q1 - q0;
    let q = 0.5 * (q0 + q1);
    let mut cut = Cut { u: u - c * q, y: c * d + a * q, m0: 0.0, m1: 0.0, m2: 0.0 };
    if length.is_nan() || length <= 0.0 {
        return cut;
    }
    // Branch points farther off than the piece is long do no harm, and would stretch the map.
    let (e0, e1) = (f64s::max(branch0, q0 - length), f64s::min(branch1, q1 + length));
    let (mid, half) = (0.5 * (e0 + e1) - q, 0.5 * (e1 - e0));
    let inverse = |t: f64| {
        let s = f64s::clamp((t - mid) / half, -1.0, 1.0);
        2.0 * f64s::sin(f64s::asin(s) / 3.0)
    };
    let (t0, t1) = (inverse(-0.5 * length), inverse(0.5 * length));
    let (center, scale) = (0.5 * (t0 + t1), 0.5 * (t1 - t0));
    let [(p0, s0), (p1, s1)] = factors.map(|(p, s)| (p + s * q, s));
    for (node, weight) in GAUSS {
        for x in [-node, node] {
            let t = center + scale * x;
            let at = mid + half * t * (1.5 - 0.5 * t * t);
            let chord2 = f64s::max((p0 + s0 * at) * (p1 + s1 * at), 0.0);
            let f = weight * (1.0 - t * t) * chord2.sqrt();
            cut.m0 += f;
            cut.m1 += f * at;
            cut.m2 += f * at * at;
        }
    }
    let all = 3.0 * half * scale;
    cut.m0 *= all;
    cut.m1 *= all;
    cut.m2 *= all;
    cut
}

/// Nodes in 0…1 (each also on the other side) and weights of Gauss and Legendre's rule with 20 nodes.
const GAUSS: [(f64, f64); 10] = [
    (0.076526521133497334, 0.152753387130725851),
    (0.227785851141645078, 0.149172986472603747),
    (0.373706088715419561, 0.142096109318382051),
    (0.510867001950827098, 0.131688638449176627),
    (0.636053680726515025, 0.118194531961518417),
    (0.746331906460150793, 0.101930119817240435),
    (0.839116971822218823, 0.083276741576704749),
    (0.912234428251325906, 0.062672048334109064),
    (0.963971927277913791, 0.040601429800386941),
    (0.993128599185094925, 0.017614007139152118),
];
