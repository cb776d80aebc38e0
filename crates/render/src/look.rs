//! How things look: light, sky, surfaces and tone. All colours inside are linear, red, green, blue.
//!
//! L = albedo · (sun · max(n·l, 0) · visibility + ambient(n) · openness) + gloss, then fog, then a filmic
//! curve (Narkowicz 2015, "ACES filmic tone mapping curve") and the sRGB encoding.

use jounce::math::scalar::f32s;
use jounce::math::{DVec3, Vec3};

/// The marking of a surface, fixed in its own frame, so that turning can be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// One colour.
    Plain,
    /// Lines every metre and every ten metres on faces that look up; fixed in the world.
    Grid,
    /// Beach ball: six sectors about y, with caps, for a ball of this radius.
    Ball(f32),
    /// Two light stripes along y (cylinders, capsules, cones).
    Stripes,
    /// A border along the edges of a box with these half extents.
    Frame(Vec3),
}

/// Colour and marking of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skin {
    /// Linear colour.
    pub color: Vec3,
    /// Marking.
    pub pattern: Pattern,
    /// Strength of highlight and reflection, 0…1.
    pub gloss: f32,
}

/// Light, sky and ranges of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Unit direction towards the sun.
    pub sun: Vec3,
    /// Angular radius of the sun, radians (large: soft shadows).
    pub sun_radius: f32,
    /// Reach of the ambient occlusion, metres; 0 chooses by the camera's distance.
    pub openness_reach: f32,
    /// Distance at which half of a surface is lost in the haze, metres; 0 chooses by the camera's distance.
    pub haze_distance: f32,
    /// Factor on the sun's light.
    pub sun_strength: f32,
    /// Colour of the sky and of the haze; `None` is the blue one.
    pub background: Option<Vec3>,
    /// Factor on all light.
    pub exposure: f32,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            sun: Vec3::new(0.55, 0.78, 0.42).normalize_or(Vec3::Y),
            sun_radius: 0.045,
            openness_reach: 0.0,
            haze_distance: 0.0,
            sun_strength: 1.0,
            background: None,
            exposure: 1.0,
        }
    }
}

/// Linear colour of an sRGB hex number 0xRRGGBB.
pub fn srgb(hex: u32) -> Vec3 {
    let c = |shift: u32| {
        let v = ((hex >> shift) & 255) as f32 / 255.0;
        if v <= 0.04045 { v / 12.92 } else { f32s::pow((v + 0.055) / 1.055, 2.4) }
    };
    Vec3::new(c(16), c(8), c(0))
}

/// Colours of moving bodies, taken in turn.
pub const PALETTE: [u32; 10] =
    [0xE4572E, 0x2E86AB, 0xF6AE2D, 0x4FA16B, 0xC2497B, 0x3FB8AF, 0x7261A3, 0xF26B4E, 0x3D6FB6, 0xA8B545];

/// Colour of the n-th moving body.
pub fn palette(n: u32) -> Vec3 {
    srgb(PALETTE[n as usize % PALETTE.len()])
}

const SUN: Vec3 = Vec3::new(2.9, 2.6, 2.15);
const SKY_LIGHT: Vec3 = Vec3::new(0.52, 0.66, 0.92);
const GROUND_LIGHT: Vec3 = Vec3::new(0.36, 0.33, 0.30);
const ZENITH: Vec3 = Vec3::new(0.10, 0.30, 0.85);
const HORIZON: Vec3 = Vec3::new(0.74, 1.04, 1.50);

/// A point to shade.
pub(crate) struct Spot {
    /// World position.
    pub point: DVec3,
    /// In the surface's frame.
    pub local: Vec3,
    pub normal: Vec3,
    /// Unit view ray.
    pub dir: Vec3,
    pub t: f32,
    /// One pixel to the right and down at this point, on the surface, metres.
    pub dx: Vec3,
    pub dy: Vec3,
    /// Sun seen, 0…1.
    pub sun: f32,
    /// Sky seen, 0…1.
    pub open: f32,
}

impl Look {
    /// Colour of the sky in a direction.
    pub fn sky(&self, dir: Vec3) -> Vec3 {
        if let Some(c) = self.background {
            return c;
        }
        let up = f32s::clamp(dir.y, 0.0, 1.0);
        let k = 1.0 - (1.0 - up) * (1.0 - up);
        let base = HORIZON.lerp(ZENITH, k);
        let c = f32s::max(dir.dot(self.sun), 0.0);
        let c4 = c * c * c * c;
        base + Vec3::new(0.50, 0.38, 0.20) * (c4 * c4 * 0.45)
    }

    /// Light that leaves a spot towards the eye, haze included.
    pub(crate) fn shade(&self, skin: &Skin, s: &Spot, haze_distance: f32) -> Vec3 {
        let n = s.normal;
        let albedo = albedo(skin, s);
        let sun = f32s::max(n.dot(self.sun), 0.0) * s.sun * self.sun_strength;
        let ambient = GROUND_LIGHT.lerp(SKY_LIGHT, 0.5 + 0.5 * n.y) * s.open;
        let mut c = albedo.mul(SUN * sun + ambient);
        // Gloss: Schlick's Fresnel term on the sky, a Blinn highlight of the sun.
        let cos = f32s::clamp(-n.dot(s.dir), 0.0, 1.0);
        let r = 1.0 - cos;
        let fresnel = 0.04 + 0.5 * (r * r) * (r * r) * r;
        let mirrored = s.dir + n * (2.0 * cos);
        c += self.sky(mirrored) * (skin.gloss * fresnel * s.open * (0.35 + 0.65 * s.sun));
        if sun > 0.0 {
            let half = (self.sun - s.dir).normalize_or(n);
            let mut h = f32s::max(n.dot(half), 0.0);
            for _ in 0..6 {
                h *= h;
            }
            c += SUN * (h * skin.gloss * 0.30 * s.sun * self.sun_strength);
        }
        c.lerp(self.haze_color(s.dir), Self::haze(s.t, haze_distance))
    }

    /// Part of a surface at distance `t` that is lost in the haze.
    pub(crate) fn haze(t: f32, haze_distance: f32) -> f32 {
        let x = t / haze_distance;
        1.0 - 1.0 / (1.0 + x * x)
    }

    /// Colour of the haze in a direction.
    pub(crate) fn haze_color(&self, dir: Vec3) -> Vec3 {
        self.sky(Vec3::new(dir.x, f32s::max(dir.y, 0.0), dir.z))
    }

    /// Light of a translucent thing of this colour that sees these parts of the sun and the sky: from all around, and
    /// from the sun if turned to it.
    pub(crate) fn dim_light(&self, color: Vec3, sun: f32, open: f32) -> (Vec3, Vec3) {
        let around = GROUND_LIGHT.lerp(SKY_LIGHT, 0.65) * open;
        (color.mul(around), color.mul(SUN * (sun * self.sun_strength)))
    }

    /// Linear light to display values 0…1, still linear.
    pub(crate) fn tone(&self, c: Vec3) -> Vec3 {
        let f = |x: f32| {
            let x = x * self.exposure * 0.46;
            f32s::clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0)
        };
        let c = Vec3::new(f(c.x), f(c.y), f(c.z));
        // The curve bleaches bright colours: some of their saturation is given back.
        let grey = c.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        (Vec3::splat(grey) + (c - Vec3::splat(grey)) * 1.18).clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// Part of a window of `width` around a point that is at most `half` from the nearest line of a family with
/// this `period`; `x` is the point's coordinate across the lines.
fn line_cover(x: f64, period: f64, half: f32, width: f32) -> f32 {
    let u = x / period;
    let d = ((u - u.round()) * period).abs() as f32;
    let w = f32s::max(width, 1e-6);
    let inside = f32s::clamp((half + 0.5 * w - d) / w, 0.0, 1.0);
    let most = f32s::min(1.0, 2.0 * half / w);
    let cover = f32s::min(inside, most);
    // Where the window spans several lines only their mean remains.
    let mean = 2.0 * half / period as f32;
    let blur = f32s::clamp(w / (period as f32) * 2.0 - 0.5, 0.0, 1.0);
    cover + (mean - cover) * blur
}

/// Smooth step of `v` over zero with a ramp `width` wide.
fn edge(v: f32, width: f32) -> f32 {
    let x = f32s::clamp(v / f32s::max(width, 1e-6) + 0.5, 0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

fn albedo(skin: &Skin, s: &Spot) -> Vec3 {
    let c = skin.color;
    let pixel = f32s::max(s.dx.length(), s.dy.length());
    let light = c.lerp(Vec3::splat(0.86), 0.72);
    match skin.pattern {
        Pattern::Plain => c,
        Pattern::Grid => {
            if s.normal.y < 0.6 {
                return c;
            }
            let (wx, wz) = (s.dx.x.abs() + s.dy.x.abs(), s.dx.z.abs() + s.dy.z.abs());
            let lines = |period: f64, half: f32| {
                let a = line_cover(s.point.x, period, half, wx);
                let b = line_cover(s.point.z, period, half, wz);
                a + b - a * b
            };
            let fine = lines(1.0, 0.014) * 0.40;
            let coarse = lines(10.0, 0.035) * 0.65;
            c * (1.0 - f32s::max(fine, coarse))
        }
        Pattern::Ball(radius) => {
            let p = s.local / f32s::max(radius, 1e-9);
            let r2 = p.x * p.x + p.z * p.z;
            let r = f32s::max(r2.sqrt(), 1e-4);
            // sin 3φ = Im (cos φ + i sin φ)³: three coloured and three light sectors.
            let sin3 = (3.0 * p.x * p.x * p.z - p.z * p.z * p.z) / (r * r2.max(1e-8));
            let px = pixel / f32s::max(radius, 1e-9);
            let sector = edge(sin3, 3.0 * px * 1.2 / r);
            let cap = edge(0.22 - r, px * 1.2);
            let a = light.lerp(c, sector);
            a.lerp(c * 0.75, cap)
        }
        Pattern::Stripes => {
            let r2 = s.local.x * s.local.x + s.local.z * s.local.z;
            let r = f32s::max(r2.sqrt(), 1e-6);
            let cos2 = (s.local.x * s.local.x - s.local.z * s.local.z) / f32s::max(r2, 1e-12);
            c.lerp(light, edge(cos2 - 0.80, 2.0 * pixel * 1.2 / r) * 0.85)
        }
        Pattern::Frame(half) => {
            let inside = half - s.local.abs();
            // The two smaller gaps besides the face's own: distance to the nearest edge of the face.
            let (a, b, d) = (inside.x, inside.y, inside.z);
            let face = f32s::min(a, f32s::min(b, d));
            let gap = if face == a {
                f32s::min(b, d)
            } else if face == b {
                f32s::min(a, d)
            } else {
                f32s::min(a, b)
            };
            let border = 0.16 * half.min_component();
            c.lerp(c.lerp(Vec3::splat(0.80), 0.42), edge(border - gap, pixel * 1.2))
        }
    }
}

/// sRGB bytes of linear values 0…1, by table.
pub(crate) struct Encoder {
    table: Vec<u8>,
}

impl Encoder {
    pub fn new() -> Self {
        // The table runs over √value: even steps where the eye is keen.
        let n = 4096;
        let byte = |i: usize| {
            let r = i as f32 / (n - 1) as f32;
            let v = r * r;
            let e = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * f32s::pow(v, 1.0 / 2.4) - 0.055 };
            (e * 255.0 + 0.5) as u8
        };
        Self { table: (0..n).map(byte).collect() }
    }
    pub fn bytes(&self, c: Vec3) -> [u8; 3] {
        let f = |v: f32| {
            let i = (v.sqrt() * 4095.0 + 0.5) as usize;
            self.table[i.min(4095)]
        };
        [f(c.x), f(c.y), f(c.z)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_round_trip() {
        let e = Encoder::new();
        for v in 0..=255_u32 {
            let b = e.bytes(srgb(v * 0x010101));
            assert!(b[0].abs_diff(v as u8) <= 1, "{v} {b:?}");
        }
    }

    #[test]
    fn line_cover_keeps_the_mean() {
        // Over one period the covered part is 2·half/period, at any width of the window.
        for width in [0.01_f32, 0.1, 0.3, 1.0, 5.0] {
            let n = 20_000;
            let sum: f64 = (0..n).map(|i| f64::from(line_cover(i as f64 / n as f64, 1.0, 0.02, width))).sum();
            let mean = sum / n as f64;
            assert!((mean - 0.04).abs() < 0.006, "{width}: {mean}");
        }
    }
}
