//! Seeded poses and a slow oracle: the gap of two convex shapes by trying directions.
#![allow(dead_code)]

use jounce_geometry::Shape;
use jounce_math::{Pose, Quat, Vec3, scalar::f32s};

/// xorshift64*.
pub struct Rng(pub u64);

impl Rng {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }
    /// Uniform in 0…1.
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u64 << 24) as f32
    }
    pub fn range(&mut self, lo: f32, hi: f32) -> f32 {
        lo + (hi - lo) * self.unit()
    }
    pub fn vec(&mut self, r: f32) -> Vec3 {
        Vec3::new(self.range(-r, r), self.range(-r, r), self.range(-r, r))
    }
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vec(1.0);
            let l = v.length();
            if l > 0.1 && l <= 1.0 {
                return v / l;
            }
        }
    }
    pub fn rotation(&mut self) -> Quat {
        loop {
            let q = Quat::new(
                self.range(-1.0, 1.0),
                self.range(-1.0, 1.0),
                self.range(-1.0, 1.0),
                self.range(-1.0, 1.0),
            );
            let l = q.dot(q);
            if l > 0.01 && l <= 1.0 {
                return q.normalize();
            }
        }
    }
}

/// Support point, written apart from the library's.
pub fn support(s: &Shape, d: Vec3) -> Vec3 {
    let sg = |x: f32| if x >= 0.0 { 1.0f32 } else { -1.0 };
    let flat = Vec3::new(d.x, 0.0, d.z).normalize_or(Vec3::X);
    match s {
        Shape::Sphere { radius } => d * *radius,
        Shape::Capsule { half_height, radius } => Vec3::new(0.0, sg(d.y) * half_height, 0.0) + d * *radius,
        Shape::Box { half } => Vec3::new(sg(d.x) * half.x, sg(d.y) * half.y, sg(d.z) * half.z),
        Shape::Cylinder { half_height, radius } => flat * *radius + Vec3::Y * (sg(d.y) * half_height),
        Shape::Cone { half_height, radius } => {
            let base = flat * *radius - Vec3::Y * *half_height;
            let tip = Vec3::Y * *half_height;
            if tip.dot(d) > base.dot(d) { tip } else { base }
        }
        Shape::Hull(h) => {
            let v = h.vertices();
            *v.iter().max_by(|a, b| a.dot(d).total_cmp(&b.dot(d))).unwrap()
        }
        _ => unreachable!(),
    }
}

/// Gap along the unit direction `n` (from A to B), metres.
pub fn gap_along(a: &Shape, b: &Shape, pose: &Pose, n: Vec3) -> f32 {
    let pa = support(a, n);
    let pb = pose.transform_point(support(b, pose.q.inverse_rotate(-n)));
    (pb - pa).dot(n)
}

/// The largest gap over all directions: the distance when apart, minus the depth when not. Starts from
/// `samples` directions (and `guesses`), then climbs from the best few. Apart it is exact; the depth is that of the
/// highest hill found.
pub fn gap(a: &Shape, b: &Shape, pose: &Pose, samples: usize, guesses: &[Vec3]) -> f32 {
    let golden = std::f32::consts::PI * (3.0 - 5.0f32.sqrt());
    let mut top: Vec<(f32, Vec3)> = Vec::new();
    let spiral = (0..samples).map(|i| {
        let y = 1.0 - 2.0 * (i as f32 + 0.5) / samples as f32;
        let r = (1.0 - y * y).sqrt();
        let turn = golden * i as f32;
        let (s, c) = (f32s::sin(turn), f32s::cos(turn));
        Vec3::new(r * c, y, r * s)
    });
    for n in spiral.chain(guesses.iter().copied()) {
        top.push((gap_along(a, b, pose, n), n));
    }
    top.sort_by(|x, y| y.0.total_cmp(&x.0));
    top.truncate(12);
    let mut best = (f32::NEG_INFINITY, Vec3::X);
    for (mut g, mut n) in top {
        let mut step = 0.2;
        while step > 1e-5 {
            let (u, v) = n.orthonormal_basis();
            let mut improved = false;
            for k in 0..8 {
                let turn = std::f32::consts::FRAC_PI_4 * k as f32;
                let (s, c) = (f32s::sin(turn), f32s::cos(turn));
                let m = (n + (u * c + v * s) * step).normalize_or(n);
                let h = gap_along(a, b, pose, m);
                if h > g {
                    (g, n) = (h, m);
                    improved = true;
                }
            }
            if !improved {
                step *= 0.5;
            }
        }
        if g > best.0 {
            best = (g, n);
        }
    }
    // Eight directions miss a ridge's way up where it is steep on both sides.
    loop {
        let found = highest_around(a, b, pose, best.1);
        if found.0 <= best.0 + 1e-7 {
            return best.0;
        }
        best = found;
    }
}

/// The direction within 45° or so of `n` along which the gap is largest, if the shapes are apart.
///
/// With W = {b − a} the gap along n + x u + y v is h(x, y)/|n + x u + y v|, where h, the least of linear functions, is
/// concave. Its level sets at and above 0 are convex, and so are those of h itself below: one search by golden
/// sections within another finds the top, ridges or not.
fn highest_around(a: &Shape, b: &Shape, pose: &Pose, n: Vec3) -> (f32, Vec3) {
    let (u, v) = n.orthonormal_basis();
    let at = |x: f32, y: f32| n + u * x + v * y;
    let score = |x: f32, y: f32| {
        let m = at(x, y);
        let g = gap_along(a, b, pose, m.normalize_or(n));
        if g < 0.0 { g * m.length() } else { g }
    };
    let along = |x: f32| highest(|y| score(x, y));
    let (x, _) = highest(|x| along(x).1);
    let m = at(x, along(x).0).normalize_or(n);
    (gap_along(a, b, pose, m), m)
}

/// Where in −1…1 a function of one top is highest, and how high, by golden sections.
fn highest(f: impl Fn(f32) -> f32) -> (f32, f32) {
    let section = 0.5 * (5.0f32.sqrt() - 1.0);
    let (mut lo, mut hi) = (-1.0f32, 1.0f32);
    let (mut x, mut y) = (hi - section * (hi - lo), lo + section * (hi - lo));
    let (mut fx, mut fy) = (f(x), f(y));
    while hi - lo > 1e-6 {
        if fx > fy {
            (hi, y, fy) = (y, x, fx);
            x = hi - section * (hi - lo);
            fx = f(x);
        } else {
            (lo, x, fx) = (x, y, fy);
            y = lo + section * (hi - lo);
            fy = f(y);
        }
    }
    if fx > fy { (x, fx) } else { (y, fy) }
}
