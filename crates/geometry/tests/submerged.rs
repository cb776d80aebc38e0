//! The part of a shape below a plane, against closed forms, slices, points thrown at random and itself cut elsewhere;
//! and the areas of shadows.

mod common;
use common::Rng;
use core::f64::consts::{FRAC_PI_2, PI};
use jounce_geometry::{Compound, HeightField, Hull, Shape, Submerged};
use jounce_math::{
    DQuat, DVec3, Pose, Quat, Vec3,
    scalar::{f32s, f64s},
};
use std::sync::Arc;

/// Random counts: all of them where every commit's promises are proved.
fn count(few: usize, many: usize) -> usize {
    if std::env::var_os("JOUNCE_PROVE").is_some() { many } else { few }
}

fn hull(points: &[Vec3]) -> Shape {
    Shape::Hull(Arc::new(Hull::new(points).unwrap()))
}

/// One of each solid, thick and thin, of sizes about `scale`; the last is a compound of two that do not overlap.
fn solids(r: &mut Rng, scale: f32) -> Vec<Shape> {
    let mut s = || scale * r.range(0.1, 1.5);
    let mut list = vec![
        Shape::Sphere { radius: s() },
        Shape::Capsule { half_height: s(), radius: s() },
        Shape::Box { half: Vec3::new(s(), s(), s()) },
        Shape::Cylinder { half_height: s(), radius: s() },
        Shape::Cone { half_height: s(), radius: s() },
    ];
    let points: Vec<Vec3> = (0..20).map(|_| r.vec(scale) + Vec3::X * (0.3 * scale)).collect();
    list.push(hull(&points));
    let far = Pose::new(Vec3::new(4.0, 1.0, 0.5) * scale, r.rotation());
    let pair = vec![(Pose::new(Vec3::ZERO, r.rotation()), list[3].clone()), (far, list[4].clone())];
    list.push(Shape::Compound(Arc::new(Compound::new(pair).unwrap())));
    list
}

fn size(shape: &Shape) -> f64 {
    f64::from(shape.outer_radius(Vec3::ZERO))
}

fn direction(r: &mut Rng) -> DVec3 {
    r.direction().as_dvec3().normalize_or(DVec3::Y)
}

/// A unit vector: any, or within 1e-1…1e-11 of a direction that is special for some shape.
fn normal(r: &mut Rng) -> DVec3 {
    let any = direction(r);
    let special = match r.next() % 6 {
        0 => DVec3::Y,
        1 => -DVec3::Y,
        2 => DVec3::new(any.x, 0.0, any.z),
        _ => return any,
    };
    let tilt = f64s::pow(10.0, f64::from(r.range(-11.0, -1.0)));
    (special.normalize_or(DVec3::X) + direction(r) * tilt).normalize_or(DVec3::Y)
}

fn near(got: f64, want: f64, tolerance: f64, what: &str) {
    assert!((got - want).abs() <= tolerance, "{what}: {got:e} is not {want:e} to {tolerance:e}");
}

/// The two parts of a shape are the shape. 1e-12 covers the rounding of sums of some hundred terms; the curved shapes'
/// sections are integrated with 20 nodes, whose error on analytic integrands is below rounding.
#[test]
fn parts_add_up() {
    let mut r = Rng(3);
    for round in 0..count(200, 2000) {
        let scale = [1e-3, 1.0, 1e3][round % 3];
        for shape in solids(&mut r, scale) {
            let (whole, size) = (shape.submerged(DVec3::Y, f64::INFINITY), size(&shape));
            for _ in 0..12 {
                let (n, d) = (normal(&mut r), f64::from(r.range(-1.2, 1.2)) * size);
                let (a, b) = (shape.submerged(n, d), shape.submerged(-n, -d));
                let what = format!("{shape:?} n {n:?} d {d:e}: {a:?} {b:?}");
                near(a.volume + b.volume, whole.volume, 1e-12 * whole.volume, &what);
                let moment = a.center * a.volume + b.center * b.volume - whole.center * whole.volume;
                near(moment.length(), 0.0, 2e-12 * whole.volume * size, &what);
                near(a.waterplane, b.waterplane, 1e-9 * size * size, &what);
            }
        }
    }
}

/// Needles and plates, 1 cm and 100 m within one shape, cut at offsets of the scale of either. A place along the longest
/// side is known to 1e-16 of it, 1e-12 of the shortest; 1e-9 is what a needle may lose.
#[test]
fn needles_and_plates_add_up() {
    let mut r = Rng(41);
    for _ in 0..count(2000, 50_000) {
        let mut s = || f64s::pow(10.0, f64::from(r.range(-2.0, 2.0))) as f32;
        let (half_height, radius) = (s(), s());
        let half = Vec3::new(radius, half_height, s());
        for shape in [
            Shape::Capsule { half_height, radius },
            Shape::Box { half },
            Shape::Cylinder { half_height, radius },
            Shape::Cone { half_height, radius },
        ] {
            let n = normal(&mut r);
            let along = f64::from(r.range(-1.2, 1.2)) * f64::from(half_height) * n.y;
            let d = along + f64::from(r.range(-1.2, 1.2)) * f64::from(radius);
            let (whole, size) = (shape.volume(), size(&shape));
            let (a, b) = (shape.submerged(n, d), shape.submerged(-n, -d));
            let what = format!("{shape:?} n {n:?} d {d:e}: {a:?} {b:?}");
            near(a.volume + b.volume, whole, 1e-9 * whole, &what);
            let center = shape.submerged(n, f64::INFINITY).center;
            let moment = a.center * a.volume + b.center * b.volume - center * whole;
            near(moment.length(), 0.0, 1e-9 * whole * size, &what);
        }
    }
}

/// The waterplane is dV/dd. A central difference lies between the section's areas over its step, up to the bend of
/// their graph: allow the whole change over the step, and the rounding of V (1e-15) over the step.
#[test]
fn waterplane_is_the_slope_of_the_volume() {
    let mut r = Rng(5);
    for _ in 0..count(150, 1500) {
        for shape in solids(&mut r, 1.0) {
            let size = size(&shape);
            let step = 1e-4 * size;
            for _ in 0..8 {
                let (n, d) = (direction(&mut r), f64::from(r.range(-1.1, 1.1)) * size);
                let [a, b, c] = [d - step, d, d + step].map(|d| shape.submerged(n, d));
                let slope = (c.volume - a.volume) / (2.0 * step);
                let change = (c.waterplane - b.waterplane).abs() + (b.waterplane - a.waterplane).abs();
                // Where it bends, its curvature times step² (a smooth shape's: of the order of 1) remains.
                let tolerance = change + 1e-7 * size * size;
                near(b.waterplane, slope, tolerance, &format!("{shape:?} n {n:?} d {d}"));
            }
        }
    }
}

/// A part of a convex shape has its centroid below the plane and within the bounds, however thin it is.
#[test]
fn centroids_lie_in_their_parts() {
    let mut r = Rng(7);
    for round in 0..count(200, 2000) {
        for shape in solids(&mut r, [1e-3, 1.0, 1e3][round % 3]) {
            let Some(bounds) = shape.is_convex().then(|| shape.aabb(&Pose::IDENTITY)) else { continue };
            let size = size(&shape);
            for _ in 0..12 {
                let n = normal(&mut r);
                // Half of them slivers: just above the lowest point.
                let low = -support(&shape, -n);
                let depth = f64s::pow(10.0, f64::from(r.range(-16.0, 0.3))) * size;
                let s = shape.submerged(n, low + depth);
                let what = format!("{shape:?} n {n:?} depth {depth:e}: {s:?}");
                assert!(s.volume >= 0.0 && s.volume <= shape.volume() && s.waterplane >= 0.0, "{what}");
                if s.volume > 0.0 {
                    assert!(n.dot(s.center) <= low + depth + 1e-12 * size, "{what}");
                    // f32 bounds; and rounding, 1e-15 of the whole's moment, over a small volume.
                    let slack = DVec3::splat((1e-7 + 1e-15 * shape.volume() / s.volume) * size);
                    let (lo, hi) = (bounds.min.as_dvec3() - slack, bounds.max.as_dvec3() + slack);
                    assert!(s.center.clamp(lo, hi) == s.center, "{what}");
                }
            }
        }
    }
}

/// Largest n·x, in f64.
fn support(shape: &Shape, n: DVec3) -> f64 {
    let a = (n.x * n.x + n.z * n.z).sqrt();
    let (max, f) = (f64s::max, |x: f32| f64::from(x));
    match shape {
        Shape::Sphere { radius } => f(*radius),
        Shape::Capsule { half_height, radius } => f(*half_height) * n.y.abs() + f(*radius),
        Shape::Box { half } => half.as_dvec3().dot(n.abs()),
        Shape::Cylinder { half_height, radius } => f(*half_height) * n.y.abs() + f(*radius) * a,
        Shape::Cone { half_height, radius } => {
            max(f(*half_height) * n.y, f(*radius) * a - f(*half_height) * n.y)
        }
        Shape::Hull(h) => h.vertices().iter().fold(f64::NEG_INFINITY, |m, v| max(v.as_dvec3().dot(n), m)),
        _ => unreachable!(),
    }
}

/// A ball a quarter, a half and three quarters as dense as the liquid floats at these fractions of its diameter: the
/// roots of t² (3 − 2t) = density ratio.
#[test]
fn balls_float_at_their_depths() {
    let shape = Shape::Sphere { radius: 1.5 };
    for (ratio, depth) in [(0.25, 0.326_351_822_333), (0.5, 0.5), (0.75, 0.673_648_177_667)] {
        let s = shape.submerged(DVec3::Z, (2.0 * depth - 1.0) * 1.5);
        near(s.volume / shape.volume(), ratio, 1e-11, "depth");
        near(s.waterplane, PI * 2.25 * 4.0 * depth * (1.0 - depth), 1e-10, "waterplane");
    }
    // Half a ball: 3/8 r below its flat side.
    near(shape.submerged(DVec3::Z, 0.0).center.z, -0.375 * 1.5, 1e-14, "centroid");
}

/// Volume below a plane through a box, by its corners: V = Σ ±(d − n·v)₊³ / (6 n_x n_y n_z) over the corners v, the
/// sign that of the product of the corner's signs times −1 (the octant at each corner, added and taken off again).
fn box_by_corners(half: DVec3, n: DVec3, d: f64) -> f64 {
    let mut sum = 0.0;
    for k in 0..8 {
        let s = |bit: u32| if k & bit == 0 { -1.0 } else { 1.0 };
        let v = DVec3::new(s(1) * half.x, s(2) * half.y, s(4) * half.z);
        let depth = f64s::max(d - n.dot(v), 0.0);
        sum -= s(1) * s(2) * s(4) * depth * depth * depth;
    }
    sum / (6.0 * n.x * n.y * n.z)
}

#[test]
fn box_is_the_sum_over_its_corners() {
    let mut r = Rng(9);
    for _ in 0..count(2000, 20_000) {
        let half = Vec3::new(r.range(0.2, 2.0), r.range(0.2, 2.0), r.range(0.2, 2.0));
        let (n, shape) = (direction(&mut r), Shape::Box { half });
        if f64s::min(n.abs().min_component(), 1.0) < 0.05 {
            continue;
        }
        let d = f64::from(r.range(-1.0, 1.0)) * n.abs().dot(half.as_dvec3());
        let s = shape.submerged(n, d);
        near(s.volume, box_by_corners(half.as_dvec3(), n, d), 1e-10, &format!("{half:?} {n:?} {d}"));
        let same = hull_of_box(half).submerged(n, d);
        near(s.volume, same.volume, 1e-13, "volume of the hull");
        near(s.waterplane, same.waterplane, 1e-12, "waterplane of the hull");
        near((s.center * s.volume - same.center * same.volume).length(), 0.0, 1e-12, "moment of the hull");
    }
    // A unit cube cut through its middle square to a space diagonal: a hexagon of area 3√3/4.
    let n = DVec3::splat(1.0).normalize_or(DVec3::Y);
    let s = Shape::Box { half: Vec3::splat(0.5) }.submerged(n, 0.0);
    near(s.waterplane, 0.75 * 3f64.sqrt(), 1e-14, "hexagon");
    near(s.volume, 0.5, 1e-14, "half");
    // A corner cut off at depth t: t³ √27/6, its centroid 3/4 t from the corner.
    let (t, corner) = (0.01, -0.5 * 3f64.sqrt());
    let s = Shape::Box { half: Vec3::splat(0.5) }.submerged(n, corner + t);
    near(s.volume, 27f64.sqrt() / 6.0 * t * t * t, 1e-17, "corner");
    near(n.dot(s.center), corner + 0.75 * t, 1e-12, "corner's centroid");
}

fn hull_of_box(half: Vec3) -> Shape {
    Shape::Hull(Arc::new(Hull::cuboid(half).unwrap()))
}

/// Radius of a solid of revolution at y.
fn profile(shape: &Shape, y: f64) -> f64 {
    match *shape {
        Shape::Sphere { radius } => f64s::max(f64::from(radius) * f64::from(radius) - y * y, 0.0).sqrt(),
        Shape::Capsule { half_height, radius } => {
            let over = f64s::max(y.abs() - f64::from(half_height), 0.0);
            f64s::max(f64::from(radius) * f64::from(radius) - over * over, 0.0).sqrt()
        }
        Shape::Cylinder { radius, .. } => f64::from(radius),
        Shape::Cone { half_height, radius } => {
            f64::from(radius) * (f64::from(half_height) - y) / (2.0 * f64::from(half_height))
        }
        _ => unreachable!(),
    }
}

/// The same by slices square to the axis, each a segment of a disc, with a rule that does not mind what happens at the
/// ends of its interval (tanh and sinh; Takahasi and Mori 1974), between the places where a slice starts or stops to be
/// cut. A plane neither along nor across the axis.
fn by_slices(shape: &Shape, n: DVec3, d: f64) -> Submerged {
    let a = (n.x * n.x + n.z * n.z).sqrt();
    let (h, ends) = match *shape {
        Shape::Sphere { radius } => (f64::from(radius), vec![]),
        Shape::Capsule { half_height, radius } => (
            f64::from(half_height) + f64::from(radius),
            vec![-f64::from(half_height), f64::from(half_height)],
        ),
        Shape::Cylinder { half_height, .. } | Shape::Cone { half_height, .. } => {
            (f64::from(half_height), vec![])
        }
        _ => unreachable!(),
    };
    let w = |y: f64| (d - n.y * y) / a;
    let mut at = vec![-h, h];
    at.extend(ends);
    for side in [-1.0, 1.0] {
        let g = |y: f64| profile(shape, y) - side * w(y);
        for k in 0..4000 {
            let (mut lo, mut hi) = (h * (k as f64 / 2000.0 - 1.0), h * ((k + 1) as f64 / 2000.0 - 1.0));
            if (g(lo) > 0.0) != (g(hi) > 0.0) {
                for _ in 0..60 {
                    let mid = 0.5 * (lo + hi);
                    if (g(lo) > 0.0) == (g(mid) > 0.0) { lo = mid } else { hi = mid }
                }
                at.push(0.5 * (lo + hi));
            }
        }
    }
    at.sort_by(f64::total_cmp);
    let (mut volume, mut mu, mut my, mut waterplane) = (0.0, 0.0, 0.0, 0.0);
    for piece in at.windows(2) {
        let (mid, half) = (0.5 * (piece[0] + piece[1]), 0.5 * (piece[1] - piece[0]));
        for k in -160..=160 {
            let x = f64::from(k) * 0.025;
            let e = f64s::exp(x);
            let s = FRAC_PI_2 * 0.5 * (e - 1.0 / e);
            let (p, m) = (f64s::exp(s), f64s::exp(-s));
            let y = mid + half * (p - m) / (p + m);
            let dy = half * FRAC_PI_2 * 0.5 * (e + 1.0 / e) * 4.0 / ((p + m) * (p + m)) * 0.025;
            let (radius, w) = (profile(shape, y), w(y));
            let w = f64s::clamp(w, -radius, radius);
            let chord = ((radius - w) * (radius + w)).sqrt();
            let area = radius * radius * f64s::atan2(chord, -w) + w * chord;
            volume += area * dy;
            my += y * area * dy;
            mu -= chord * chord * chord / 1.5 * dy;
            waterplane += 2.0 * chord / a * dy;
        }
    }
    let u = DVec3::new(n.x / a, 0.0, n.z / a);
    Submerged { volume, center: (u * mu + DVec3::Y * my) * (1.0 / volume), waterplane }
}

/// The roots' own rounding (1e-16 of the size) under a square root bounds what slices can tell: 1e-8 of a slice that is
/// 1e-8 thick. 1e-11 stands well above it.
#[test]
fn round_shapes_are_the_sum_of_their_slices() {
    let mut r = Rng(11);
    for _ in 0..count(60, 1500) {
        for k in [0, 1, 3, 4] {
            let shape = &solids(&mut r, 1.0)[k];
            let n = direction(&mut r);
            let a = (n.x * n.x + n.z * n.z).sqrt();
            if a < 0.02 {
                continue;
            }
            // Among them planes that all but pass through a tip or a rim.
            let d = match r.next() % 3 {
                0 => {
                    let at = -support_of_caps(shape, n, r.next());
                    at + f64s::pow(10.0, f64::from(r.range(-9.0, -1.0)))
                }
                _ => f64::from(r.range(-1.0, 1.0)) * support(shape, n),
            };
            let (got, want, whole) = (shape.submerged(n, d), by_slices(shape, n, d), shape.volume());
            let size = size(shape);
            let what = format!("{shape:?} {n:?} {d:e}: {got:?} {want:?}");
            near(got.volume, want.volume, 1e-11 * whole, &what);
            if want.volume > 0.0 {
                let moment = got.center * got.volume - want.center * want.volume;
                near(moment.length(), 0.0, 1e-11 * whole * size, &what);
            }
            near(got.waterplane, want.waterplane, 1e-9 * size * size, &what);
        }
    }
}

/// n·x of the tip, or of a point of a rim.
fn support_of_caps(shape: &Shape, n: DVec3, pick: u64) -> f64 {
    let a = (n.x * n.x + n.z * n.z).sqrt();
    let (Shape::Capsule { half_height, radius }
    | Shape::Cylinder { half_height, radius }
    | Shape::Cone { half_height, radius }) = *shape
    else {
        return 0.0;
    };
    let (h, r) = (f64::from(half_height), f64::from(radius));
    match pick % 3 {
        0 => h * n.y,
        1 => h * n.y + r * a,
        _ => h * n.y - r * a,
    }
}

/// Wedges and caps with closed forms.
#[test]
fn round_shapes_have_the_closed_forms() {
    // Archimedes' hoof: a plane through a diameter of the base, V = 2/3 r² × its height, here 2h.
    let (h, r) = (1.25f32, 0.75f32);
    let shape = Shape::Cylinder { half_height: h, radius: r };
    let (h, r) = (f64::from(h), f64::from(r));
    let n = DVec3::new(-2.0 * h, r, 0.0).normalize_or(DVec3::Y);
    let s = shape.submerged(n, n.dot(DVec3::new(0.0, -h, 0.0)));
    near(s.volume, 2.0 / 3.0 * r * r * 2.0 * h, 1e-14, "hoof");
    // Half of an ellipse with the half axes r and √(r² + 4h²).
    near(s.waterplane, 0.5 * PI * r * (r * r + 4.0 * h * h).sqrt(), 1e-13, "hoof's section");
    near(s.center.x, 3.0 / 16.0 * PI * r, 1e-14, "hoof's centroid");
    // Plane along the axis: a segment.
    let s = shape.submerged(DVec3::Z, 0.5 * r);
    let segment = r * r * (PI - PI / 3.0) + 0.5 * r * r * 0.75f64.sqrt();
    near(s.volume, segment * 2.0 * h, 1e-14, "along the axis");
    near(s.waterplane, r * 3f64.sqrt() * 2.0 * h, 1e-14, "along the axis");
    // Across it.
    let s = shape.submerged(DVec3::Y, 0.25);
    near(s.volume, PI * r * r * (h + 0.25), 1e-14, "across the axis");
    near(s.center.y, 0.5 * (0.25 - h), 1e-15, "across the axis");
    // A cone cut half way up keeps an eighth above.
    let cone = Shape::Cone { half_height: 1.0, radius: 0.5 };
    let s = cone.submerged(-DVec3::Y, 0.0);
    near(s.volume, cone.volume() / 8.0, 1e-15, "tip");
    near(s.center.y, 0.25, 1e-15, "tip");
    // Along its axis through the tip: half of it, a triangle's section.
    let s = cone.submerged(DVec3::X, 0.0);
    near(s.volume, cone.volume() / 2.0, 1e-15, "half a cone");
    near(s.waterplane, 1.0, 1e-15, "triangle");
    near(s.center.x, -0.5 / PI, 1e-15, "half a cone");
    // A capsule at the seam of its cap, where three pieces meet.
    let capsule = Shape::Capsule { half_height: 1.0, radius: 0.5 };
    for y in [-1.0, 1.0] {
        let s = capsule.submerged(DVec3::Y, y);
        near(s.waterplane, PI * 0.25, 1e-15, "seam");
        near(s.volume, PI * 0.25 * (1.0 + y) + PI / 12.0, 1e-15, "seam");
    }
    let s = capsule.submerged(DVec3::X, 0.0);
    near(s.volume, capsule.volume() / 2.0, 1e-15, "half a capsule");
    near(s.waterplane, 2.0 + PI * 0.25, 1e-15, "half a capsule");
}

/// Prisms over regular polygons with m corners come to the cylinder as 1/m²: areas differ by 2π²/(3m²) of the disc's.
#[test]
fn hulls_come_to_the_cylinder() {
    let mut r = Rng(13);
    let cylinder = Shape::Cylinder { half_height: 1.0, radius: 0.5 };
    for _ in 0..count(40, 400) {
        let (n, d) = (direction(&mut r), f64::from(r.range(-0.8, 0.8)));
        let want = cylinder.submerged(n, d);
        let mut errors = vec![];
        for m in [15, 30, 60, 120] {
            let corner = |k: u32| {
                let turn = 2.0 * PI * f64::from(k) / f64::from(m);
                let y = if k < m { -1.0 } else { 1.0 };
                DVec3::new(0.5 * f64s::cos(turn), y, 0.5 * f64s::sin(turn)).as_vec3()
            };
            let got = hull(&(0..2 * m).map(corner).collect::<Vec<_>>()).submerged(n, d);
            let bound = 2.0 * PI * PI / (3.0 * f64::from(m * m));
            let what = format!("{m} corners, n {n:?} d {d}: {got:?} {want:?}");
            // No part lacks more than the whole does; f32 corners are off by 1e-7.
            near(got.volume, want.volume, 1.01 * bound * cylinder.volume() + 1e-6, &what);
            near((got.center * got.volume - want.center * want.volume).length(), 0.0, 2.0 * bound, &what);
            near(got.waterplane, want.waterplane, 4.0 * f64s::max(bound, 1e-6), &what);
            errors.push(want.volume - got.volume);
        }
        let whole = cylinder.volume();
        assert!(want.volume < 0.2 * whole || errors[0] > 12.0 * errors[2].abs(), "{n:?} {d} {errors:?}");
    }
}

/// Points thrown at the bounds: the error of a share p of N points is √(p(1 − p)/N); five of those.
#[test]
fn parts_are_what_random_points_say() {
    let mut r = Rng(17);
    const POINTS: usize = 60_000;
    for _ in 0..count(2, 20) {
        for shape in solids(&mut r, 1.0) {
            let b = shape.aabb(&Pose::IDENTITY);
            let (n, d) = (direction(&mut r), f64::from(r.range(-0.6, 0.6)));
            let extent = (b.max - b.min).as_dvec3();
            let all = extent.x * extent.y * extent.z;
            let (mut hits, mut first) = (0.0, DVec3::ZERO);
            for _ in 0..POINTS {
                let p = b.min + Vec3::new(r.unit(), r.unit(), r.unit()).mul(b.max - b.min);
                if n.dot(p.as_dvec3()) <= d && shape.contains_point(p) {
                    hits += 1.0;
                    first += p.as_dvec3();
                }
            }
            let s = shape.submerged(n, d);
            let what = format!("{shape:?} n {n:?} d {d}: {s:?}");
            let sigma = 1.0 / (POINTS as f64).sqrt();
            near(s.volume, all * hits / POINTS as f64, 2.5 * sigma * all, &what);
            let moment = s.center * s.volume - first * (all / POINTS as f64);
            near(moment.length(), 0.0, 5.0 * sigma * all * extent.length(), &what);
        }
    }
}

/// A plane that touches, misses, is turned by 1e-9 or is no plane at all.
#[test]
fn touching_tilted_and_broken_planes() {
    let mut r = Rng(19);
    for scale in [1e-3, 1.0, 1e3] {
        for shape in solids(&mut r, scale) {
            let (whole, center) = (shape.volume(), shape.submerged(DVec3::Y, f64::INFINITY).center);
            let size = size(&shape);
            for n in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z] {
                let (none, all) = (shape.submerged(n, -8.0 * size), shape.submerged(n, 8.0 * size));
                assert_eq!((none.volume, none.waterplane), (0.0, 0.0));
                assert_eq!((all.volume, all.waterplane), (whole, 0.0));
                near((none.center - center).length(), 0.0, 1e-14 * size, "whole");
                near((all.center - center).length(), 0.0, 1e-14 * size, "whole");
                if shape.is_convex() {
                    // At the very touch: nothing or all, up to what a rounding of the offset shifts.
                    let top = support(&shape, n);
                    near(shape.submerged(n, top).volume, whole, 1e-14 * whole, "touched from above");
                    let bottom = shape.submerged(n, -support(&shape, -n));
                    near(bottom.volume, 0.0, 1e-14 * whole, "touched from below");
                    near(bottom.waterplane, 0.0, 0.0, "touched from below");
                }
                // A turn by 1e-9 moves no point of the plane by more than 1e-9 sizes.
                for d in [-0.5, -0.1, 0.0, 0.1, 0.3] {
                    let d = d * size;
                    let straight = shape.submerged(n, d);
                    for turn in [1e-7, 1e-9, 1e-11, 1e-13, 1e-300] {
                        let m = (n + DVec3::new(1.0, -0.7, 0.4) * turn).normalize_or(n);
                        let s = shape.submerged(m, d);
                        let what = format!("{shape:?} {n:?} {d} turned by {turn}: {straight:?} {s:?}");
                        near(s.volume, straight.volume, (8.0 * turn + 1e-12) * size * size * size, &what);
                        let moved = s.center * s.volume - straight.center * straight.volume;
                        near(moved.length(), 0.0, (8.0 * turn + 1e-12) * size * size * size * size, &what);
                    }
                }
            }
            for (n, d) in [
                (DVec3::ZERO, 0.0),
                (DVec3::splat(f64::NAN), 0.0),
                (DVec3::splat(f64::INFINITY), 0.0),
                (DVec3::Y, f64::NAN),
                (DVec3::Y, f64::NEG_INFINITY),
            ] {
                let s = shape.submerged(n, d);
                assert_eq!((s.volume, s.waterplane), (0.0, 0.0));
                assert!(s.center.is_finite());
            }
        }
    }
    let half_space = Shape::HalfSpace { normal: Vec3::Y, offset: 0.0 };
    let field = HeightField::new(2, 2, [1.0, 1.0], vec![0.0; 4]).unwrap();
    for shape in [half_space, Shape::HeightField(Arc::new(field))] {
        assert_eq!(shape.submerged(DVec3::Y, 5.0).volume, 0.0);
        assert_eq!(
            (shape.volume(), shape.shadow_area(Vec3::Y), shape.equal_volume_radius()),
            (0.0, 0.0, 0.0)
        );
    }
}

/// Turning the plane about the axis turns the answer; scaling by a power of two scales it to the bit.
#[test]
fn turns_and_scales() {
    let mut r = Rng(23);
    for _ in 0..count(300, 3000) {
        for k in [0, 1, 3, 4] {
            let shape = &solids(&mut r, 1.0)[k];
            let (n, d) = (direction(&mut r), f64::from(r.range(-0.7, 0.7)));
            let q = DQuat::from_axis_angle(DVec3::Y, f64::from(r.range(-3.0, 3.0)));
            let (a, b) = (shape.submerged(n, d), shape.submerged(q.rotate(n), d));
            near(a.volume, b.volume, 1e-13, "turned");
            near((q.rotate(a.center) * a.volume - b.center * b.volume).length(), 0.0, 1e-12, "turned");
            near(
                f64::from(shape.shadow_area(n.as_vec3()) - shape.shadow_area(-n.as_vec3())),
                0.0,
                0.0,
                "back",
            );
        }
        for shape in solids(&mut r, 1.0) {
            let Some(big) = scaled(&shape, 1024.0) else { continue };
            let (n, d) = (normal(&mut r), f64::from(r.range(-0.7, 0.7)));
            let (a, b) = (shape.submerged(n, d), big.submerged(n, d * 1024.0));
            assert_eq!(a.volume * 1024.0 * 1024.0 * 1024.0, b.volume, "{shape:?} {n:?} {d}");
            assert_eq!((a.center * 1024.0, a.waterplane * 1024.0 * 1024.0), (b.center, b.waterplane));
        }
    }
}

fn scaled(shape: &Shape, s: f32) -> Option<Shape> {
    Some(match *shape {
        Shape::Sphere { radius } => Shape::Sphere { radius: radius * s },
        Shape::Capsule { half_height, radius } => {
            Shape::Capsule { half_height: half_height * s, radius: radius * s }
        }
        Shape::Box { half } => Shape::Box { half: half * s },
        Shape::Cylinder { half_height, radius } => {
            Shape::Cylinder { half_height: half_height * s, radius: radius * s }
        }
        Shape::Cone { half_height, radius } => {
            Shape::Cone { half_height: half_height * s, radius: radius * s }
        }
        _ => return None,
    })
}

#[test]
fn volumes_are_the_masses_and_equal_balls() {
    let mut r = Rng(29);
    for scale in [1e-3, 1.0, 1e3] {
        for shape in solids(&mut r, scale) {
            let v = shape.volume();
            let mass = shape.mass_properties(1.0).unwrap();
            near(f64::from(mass.mass), v, 2e-7 * v, "mass");
            let center = shape.submerged(DVec3::Y, f64::INFINITY).center;
            near((mass.center.as_dvec3() - center).length(), 0.0, 1e-6 * size(&shape), "centre");
            let radius = f64::from(shape.equal_volume_radius());
            near(4.0 / 3.0 * PI * radius * radius * radius, v, 3e-7 * v, "equal ball");
        }
    }
    assert_eq!(Shape::Sphere { radius: 0.3 }.equal_volume_radius(), 0.3);
}

/// Rays along `dir` from a square that holds the shadow: the share that hits, to five sigma.
#[test]
fn shadows_are_what_random_rays_say() {
    let mut r = Rng(31);
    const RAYS: usize = 40_000;
    for round in 0..count(3, 30) {
        // The compound's children stand 4 apart and may shade each other: not in this test.
        for shape in solids(&mut r, 1.0).into_iter().filter(Shape::is_convex) {
            let dir = match round % 3 {
                0 => r.direction(),
                1 => Vec3::new(r.range(-0.2, 0.2), 1.0, 0.1).normalize_or(Vec3::Y),
                _ => Vec3::new(1.0, r.range(-0.2, 0.2), 0.1).normalize_or(Vec3::X),
            };
            let (u, v) = dir.orthonormal_basis();
            let size = shape.outer_radius(Vec3::ZERO);
            let hits = (0..RAYS)
                .filter(|_| {
                    let at = u * r.range(-size, size) + v * r.range(-size, size) - dir * (3.0 * size);
                    shape.ray_cast(at, dir, 9.0 * size).is_some()
                })
                .count();
            let square = f64::from(4.0 * size * size);
            let want = square * hits as f64 / RAYS as f64;
            let sigma = square * 0.5 / (RAYS as f64).sqrt();
            near(f64::from(shape.shadow_area(dir)), want, 5.0 * sigma, &format!("{shape:?} {dir:?}"));
        }
    }
}

#[test]
fn shadows_have_the_closed_forms() {
    let pi = core::f32::consts::PI;
    let area = |s: &Shape, d: Vec3| f64::from(s.shadow_area(d));
    let near = |a: f64, b: f32| near(a, f64::from(b), 1e-6, "shadow");
    let (h, r) = (1.0, 0.5);
    let cone = Shape::Cone { half_height: h, radius: r };
    near(area(&cone, Vec3::Y), pi * r * r);
    near(area(&cone, Vec3::X), 2.0 * h * r);
    // The tip's image reaches the base's rim where tan θ = r/2h: both forms agree.
    let rim = |more: f32| Vec3::new(r / (2.0 * h) + more, 1.0, 0.0).normalize_or(Vec3::Y);
    let at = rim(0.0);
    near(area(&cone, at), pi * r * r * at.y);
    assert!((area(&cone, rim(1e-4)) - area(&cone, rim(-1e-4))).abs() < 1e-4);
    let cylinder = Shape::Cylinder { half_height: h, radius: r };
    near(area(&cylinder, Vec3::Y), pi * r * r);
    near(area(&cylinder, Vec3::Z), 4.0 * h * r);
    let capsule = Shape::Capsule { half_height: h, radius: r };
    near(area(&capsule, -Vec3::Y), pi * r * r);
    near(area(&capsule, Vec3::Z), pi * r * r + 4.0 * h * r);
    // A cube along its diagonal: a regular hexagon, √3 × the face.
    let d = Vec3::splat(1.0).normalize_or(Vec3::X);
    near(area(&Shape::Box { half: Vec3::splat(0.5) }, d), 3f32.sqrt());
    near(area(&hull_of_box(Vec3::splat(0.5)), d), 3f32.sqrt());
    // Cauchy: over all directions a convex shadow's mean is a quarter of the surface.
    let mut rng = Rng(37);
    let n = 20_000;
    let mean = (0..n).map(|_| area(&cone, rng.direction())).sum::<f64>() / f64::from(n);
    let surface = pi * r * (r + (r * r + 4.0 * h * h).sqrt());
    assert!((mean - f64::from(surface) / 4.0).abs() < 0.005, "{mean} {}", surface / 4.0);
    // Children side by side, turned: their sum.
    let q = Quat::from_axis_angle(Vec3::Z, core::f32::consts::FRAC_PI_2);
    let pair = vec![(Pose::new(Vec3::X * 9.0, q), cylinder), (Pose::IDENTITY, capsule)];
    let pair = Shape::Compound(Arc::new(Compound::new(pair).unwrap()));
    near(area(&pair, Vec3::Y), 4.0 * h * r + pi * r * r);
    assert!(f32s::max(pair.equal_volume_radius(), 0.0) > r);
}
