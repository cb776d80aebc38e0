//! Layers: extras that let light through. What one looks like from a ray, and how many blend.
//!
//! Front to back, with T the part of the light from behind that still comes through:
//!
//! ```text
//! L += T · α · ((1 − glow) · lit + emitted),   T ← T · (1 − α · (1 − glow))
//! ```
//!
//! α of a soft ball of radius r for a ray that passes its centre at distance b: opacity · (1 − b²/r²)² · s, where s is
//! the part of the ray's chord in front of the solid behind and of the eye, smoothed: no hard line where smoke meets
//! the ground.
//!
//! Soft balls are taken in the order of their centres' distances from the eye, the same for every ray, so that a cloud
//! is sorted once per picture and a ray can end where nothing comes through any more. Hard things are taken where the
//! ray meets them.

use super::tiles::Near;
use jounce::geometry::{Aabb, Bvh};
use jounce::math::Vec3;
use jounce::math::scalar::f32s;

/// Most layers that count along one ray, the nearest first.
const LAYERS_MAX: usize = 512;
/// Layers behind less than this part of the light cannot be seen.
const HIDDEN: f32 = 0.004;
/// Least radius on the picture, pixels: thinner things are drawn this thick, and fainter.
const RADIUS_MIN_PX: f32 = 0.7;
/// Of soft balls, whose rim cannot be seen: no grain may slip between the rays of neighbouring pixels.
const SOFT_RADIUS_MIN_PX: f32 = 1.4;
/// However thin, this part of the opacity stays: of grains, and of lines.
const FAINTEST: f32 = 0.12;
const FAINTEST_ROD: f32 = 0.3;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Soft,
    Hard,
    /// A rod with round ends.
    Round,
    /// A rod with flat ends.
    Flat,
}

/// A translucent or thin extra, in the frame of the eye.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layer {
    pub kind: Kind,
    /// Centre of a ball, end of a rod.
    pub a: Vec3,
    /// To the rod's other end; zero for a ball.
    pub ab: Vec3,
    pub radius: f32,
    /// Linear.
    pub color: Vec3,
    pub opacity: f32,
    pub glow: f32,
    /// Does it dim the light itself? Opaque thin things are among the solids, which do.
    pub shades: bool,
    pub tint: Tint,
}

/// The light that a layer sends to the eye, apart from how it is turned to the sun.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tint {
    pub ambient: Vec3,
    pub sun: Vec3,
    pub emitted: Vec3,
}

impl Tint {
    pub const BLACK: Self = Self { ambient: Vec3::ZERO, sun: Vec3::ZERO, emitted: Vec3::ZERO };
}

/// Where a ray passes a layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Distance.
    pub t: f32,
    pub alpha: f32,
    /// Towards the ray.
    pub normal: Vec3,
}

/// A ray among layers.
#[derive(Clone, Copy)]
pub(crate) struct Probe {
    pub from: Vec3,
    pub dir: Vec3,
    /// Where the solid behind is.
    pub end: f32,
    /// Size of a pixel at distance 1; 0 for rays of light.
    pub pixel_angle: f32,
}

impl Layer {
    /// Radius and part of the opacity with which a thing at distance `t` is drawn.
    fn shown(&self, t: f32, pixel_angle: f32) -> (f32, f32) {
        let pixels = if self.kind == Kind::Soft { SOFT_RADIUS_MIN_PX } else { RADIUS_MIN_PX };
        let least = t * pixel_angle * pixels;
        if self.radius >= least {
            return (self.radius, 1.0);
        }
        let rod = matches!(self.kind, Kind::Round | Kind::Flat);
        (least, f32s::max(self.radius / least, if rod { FAINTEST_ROD } else { FAINTEST }))
    }

    /// Around what stops light.
    pub fn aabb(&self) -> Aabb {
        Aabb::from_points([self.a, self.a + self.ab]).expanded(self.radius)
    }

    /// Radius within which rays of the eye see an end that is at `p`.
    pub fn reach(&self, p: Vec3, pixel_angle: f32) -> f32 {
        let distance = p.length();
        self.shown(distance, pixel_angle).0 + distance * pixel_angle
    }

    /// No sample of the eye's rays is nearer; a soft ball's place in the order.
    pub fn depth(&self) -> f32 {
        match self.kind {
            Kind::Soft => self.a.length(),
            Kind::Hard => self.a.length() - self.radius,
            Kind::Round | Kind::Flat => {
                let dd = self.ab.length_squared();
                let s = if dd > 0.0 { f32s::clamp(-self.a.dot(self.ab) / dd, 0.0, 1.0) } else { 0.0 };
                (self.a + self.ab * s).length() * (1.0 - 1e-5)
            }
        }
    }

    pub fn middle(&self) -> Vec3 {
        self.a + self.ab * 0.5
    }

    /// Depth, and numbers that tell layers apart: they are sorted by them.
    pub fn key(&self) -> [f32; 14] {
        let kind = f32::from(self.kind as u8);
        let (a, d, k) = (self.a, self.ab, self.color);
        let depth = self.depth();
        [depth, a.x, a.y, a.z, d.x, d.y, d.z, self.radius, kind, k.x, k.y, k.z, self.opacity, self.glow]
    }

    pub fn sample(&self, p: &Probe) -> Option<Sample> {
        match self.kind {
            Kind::Soft => self.sample_soft(p),
            Kind::Hard => self.sample_hard(p),
            Kind::Round | Kind::Flat => self.sample_rod(p),
        }
    }

    fn sample_soft(&self, p: &Probe) -> Option<Sample> {
        let c = self.a - p.from;
        let t = c.dot(p.dir);
        let q = p.dir * t - c;
        let (r, part) = self.shown(t, p.pixel_angle);
        let u = 1.0 - q.length_squared() / (r * r);
        if u <= 0.0 {
            return None;
        }
        let half = r * u.sqrt();
        let seen = ramp((p.end - t) / half) - ramp(-t / half);
        let alpha = self.opacity * part * u * u * seen;
        (alpha > 0.0).then(|| Sample { t, alpha, normal: (q - p.dir * half) / r })
    }

    fn sample_hard(&self, p: &Probe) -> Option<Sample> {
        let c = self.a - p.from;
        let middle = c.dot(p.dir);
        let q = p.dir * middle - c;
        let (r, part) = self.shown(middle, p.pixel_angle);
        let b2 = q.length_squared();
        let pixel = middle * p.pixel_angle;
        if b2 >= (r + pixel) * (r + pixel) {
            return None;
        }
        let half = f32s::max(r * r - b2, 0.0).sqrt();
        let t = middle - half;
        if t <= 0.0 || t > p.end {
            return None;
        }
        let alpha = self.opacity * part * cover(r - b2.sqrt(), pixel);
        (alpha > 0.0).then(|| Sample { t, alpha, normal: (q - p.dir * half).normalize_or(-p.dir) })
    }

    /// The rod as a flat strip that faces the ray.
    fn sample_rod(&self, p: &Probe) -> Option<Sample> {
        let a = self.a - p.from;
        // Where ray and line are nearest: both gaps' squares have zero slope.
        let (dd, along) = (self.ab.length_squared(), self.ab.dot(p.dir));
        let across2 = dd - along * along;
        let s = if across2 > 1e-9 * dd { (a.dot(p.dir) * along - a.dot(self.ab)) / across2 } else { 0.5 };
        let held = f32s::clamp(s, 0.0, 1.0);
        let point = a + self.ab * held;
        let t = point.dot(p.dir);
        let (r, part) = self.shown(t, p.pixel_angle);
        let pixel = t * p.pixel_angle;
        if t <= 0.0 || t - r > p.end {
            return None;
        }
        let q = p.dir * t - point;
        let mut alpha = self.opacity * part;
        if self.kind == Kind::Flat {
            // Cut sharply: the pieces of a line share their pixels out, and none gets two or a gap.
            if !(0.0..1.0).contains(&s) {
                return None;
            }
            alpha *= cover(r - q.length(), pixel);
        } else {
            alpha *= cover(r - q.length(), pixel);
        }
        let half = f32s::max(r * r - q.length_squared(), 0.0).sqrt();
        (alpha > 0.0).then(|| Sample { t, alpha, normal: (q - p.dir * half).normalize_or(-p.dir) })
    }
}

/// Smooth step from 0 at −1 to 1 at 1.
fn ramp(x: f32) -> f32 {
    let x = f32s::clamp(x * 0.5 + 0.5, 0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Part of a pixel within an edge that is `inside` metres away.
fn cover(inside: f32, pixel: f32) -> f32 {
    if pixel <= 0.0 {
        return if inside > 0.0 { 1.0 } else { 0.0 };
    }
    f32s::clamp(inside / pixel + 0.5, 0.0, 1.0)
}

/// What is seen along a ray so far.
struct Blend {
    sum: Vec3,
    through: f32,
    count: usize,
}

impl Blend {
    /// Adds a layer; false where nothing behind it counts.
    fn add(&mut self, layer: &Layer, s: &Sample, sun: Vec3) -> bool {
        let towards = s.normal.dot(sun);
        let facing = match layer.kind {
            // Light wanders inside a cloud: the far side is not dark.
            Kind::Soft => 0.42 + 0.28 * towards,
            _ => f32s::max(towards, 0.0),
        };
        let dull = 1.0 - layer.glow;
        let lit = layer.tint.ambient + layer.tint.sun * facing;
        self.sum += (lit * dull + layer.tint.emitted) * (self.through * s.alpha);
        self.through *= 1.0 - s.alpha * dull;
        self.count += 1;
        self.through > HIDDEN && self.count < LAYERS_MAX
    }
}

/// Hard layers met along a ray that wait for their turn; kept from ray to ray for its memory.
#[derive(Default)]
pub(crate) struct Bag {
    /// The nearest last.
    waiting: Vec<(u32, Sample)>,
}

impl Bag {
    /// What is behind, seen through the layers of `near`, which come in the order of [`Layer::depth`].
    pub fn over(
        &mut self,
        layers: &[Layer],
        near: &Near<'_>,
        probe: &Probe,
        sun: Vec3,
        behind: Vec3,
    ) -> Vec3 {
        self.waiting.clear();
        let mut blend = Blend { sum: Vec3::ZERO, through: 1.0, count: 0 };
        for &i in near.list {
            let sphere = &near.spheres[i as usize];
            let t = sphere.center.dot(probe.dir);
            if (probe.dir * t - sphere.center).length_squared() >= sphere.radius2 {
                continue;
            }
            while let Some((k, s)) = self.waiting.pop_if(|w| w.1.t <= sphere.depth) {
                if !blend.add(&layers[k as usize], &s, sun) {
                    return blend.sum;
                }
            }
            let layer = &layers[i as usize];
            let Some(s) = layer.sample(probe) else { continue };
            if layer.kind != Kind::Soft {
                // Equal distances keep the order of the list.
                let at = self.waiting.partition_point(|w| w.1.t > s.t);
                self.waiting.insert(at, (i, s));
            } else if !blend.add(layer, &s, sun) {
                return blend.sum;
            }
        }
        while let Some((k, s)) = self.waiting.pop() {
            if !blend.add(&layers[k as usize], &s, sun) {
                return blend.sum;
            }
        }
        blend.sum + behind * blend.through
    }
}

/// Part of the light that comes through the layers along a ray. Stops counting after some.
pub(crate) fn transmitted(tree: &Bvh, layers: &[Layer], probe: &Probe) -> f32 {
    let (mut through, mut seen) = (1.0_f32, 0);
    tree.ray(probe.from, probe.dir, Vec3::ZERO, probe.end, |i, max_t| {
        let layer = &layers[i as usize];
        if let Some(s) = layer.sample(probe) {
            through *= 1.0 - s.alpha * (1.0 - layer.glow);
            seen += 1;
        }
        if through < 0.02 || seen >= LAYERS_MAX { -1.0 } else { max_t }
    });
    through
}
