//! Lines, points and words drawn over a picture.

use crate::camera::View;
use crate::image::Image;
use crate::text;
use jounce::math::{DVec3, Vec3};

/// A straight line in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// One end.
    pub a: DVec3,
    /// Other end.
    pub b: DVec3,
    /// sRGB.
    pub color: [u8; 3],
    /// Pixels.
    pub width: f32,
}

/// A dot in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Where.
    pub at: DVec3,
    /// sRGB.
    pub color: [u8; 3],
    /// World metres; 0 for a dot of `pixels`.
    pub radius: f32,
    /// Least radius on the picture, pixels.
    pub pixels: f32,
}

/// What is drawn over a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlay {
    /// Lines: springs, joints, contact normals.
    pub lines: Vec<Line>,
    /// Dots: contact points, particles.
    pub points: Vec<Dot>,
    /// Lines and points show through what is in front of them.
    pub on_top: bool,
    /// Words in the lower left corner.
    pub caption: Option<String>,
}

impl Overlay {
    /// Nothing to draw?
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty() && self.points.is_empty() && self.caption.is_none()
    }
    /// Adds a line two pixels wide.
    pub fn line(&mut self, a: impl Into<DVec3>, b: impl Into<DVec3>, color: [u8; 3]) {
        self.lines.push(Line { a: a.into(), b: b.into(), color, width: 2.0 });
    }
    /// Adds a dot of a few pixels.
    pub fn point(&mut self, at: impl Into<DVec3>, color: [u8; 3]) {
        self.points.push(Dot { at: at.into(), color, radius: 0.0, pixels: 2.5 });
    }

    /// Draws onto `image`; `depth(i)` is the depth of pixel i along the view axis.
    pub(crate) fn draw(&self, image: &mut Image, view: &View, depth: impl Fn(usize) -> f32) {
        let width = image.width() as usize;
        let hidden = |x: i32, y: i32, z: f32, image: &Image| {
            if x < 0 || y < 0 || x >= image.width() as i32 || y >= image.height() as i32 {
                return true;
            }
            // A little slack, so that lines on a surface show.
            !self.on_top && depth(y as usize * width + x as usize) < z * 0.995 - 0.01
        };
        for l in &self.lines {
            draw_line(image, view, l, &hidden);
        }
        for p in &self.points {
            draw_dot(image, view, p, &hidden);
        }
        if let Some(caption) = &self.caption {
            let size = (image.height() as f32 / 18.0).clamp(11.0, 40.0);
            let y = image.height() as f32 - size * 0.75;
            text::draw(image, caption, size * 0.6, y, size, [28, 36, 48]);
        }
    }
}

type Hidden<'a> = &'a dyn Fn(i32, i32, f32, &Image) -> bool;

fn draw_line(image: &mut Image, view: &View, l: &Line, hidden: Hidden<'_>) {
    // Cut at a plane just before the eye.
    let near = 0.02_f32;
    let depth = |p: DVec3| (p - view.origin).as_vec3().dot(view.forward);
    let (za, zb) = (depth(l.a), depth(l.b));
    if !(za.is_finite() && zb.is_finite()) || (za < near && zb < near) {
        return;
    }
    let cut = |from: DVec3, to: DVec3, zf: f32, zt: f32| {
        if zf >= near { from } else { from + (to - from) * f64::from((near - zf) / (zt - zf) * 1.001) }
    };
    let (a, b) = (cut(l.a, l.b, za, zb), cut(l.b, l.a, zb, za));
    let (Some(pa), Some(pb)) = (view.project(a), view.project(b)) else { return };
    let Some((t0, t1)) = clip(pa, pb, image) else { return };
    let (dx, dy) = (pb.0 - pa.0, pb.1 - pa.1);
    let length = (dx * dx + dy * dy).sqrt();
    // A sample every half pixel along the line, each a soft brush across it.
    let steps = ((t1 - t0) * length * 2.0).ceil().clamp(1.0, 40_000.0) as usize;
    let along_x = dx.abs() >= dy.abs();
    let reach = (l.width * 0.5 + 1.0).ceil() as i32;
    let slant = if length > 0.0 { dx.abs().max(dy.abs()) / length } else { 1.0 };
    let mut last = i32::MIN;
    for s in 0..=steps {
        let t = t0 + (t1 - t0) * s as f32 / steps as f32;
        let (x, y) = (pa.0 + dx * t, pa.1 + dy * t);
        let z = 1.0 / ((1.0 - t) / pa.2 + t / pb.2);
        let main = if along_x { x.floor() as i32 } else { y.floor() as i32 };
        if main == last {
            continue;
        }
        last = main;
        for k in -reach..=reach {
            let (px, py) = if along_x { (main, y.floor() as i32 + k) } else { (x.floor() as i32 + k, main) };
            let off = if along_x { py as f32 + 0.5 - y } else { px as f32 + 0.5 - x };
            let alpha = (l.width * 0.5 + 0.5 - off.abs() * slant).clamp(0.0, 1.0);
            if alpha > 0.0 && !hidden(px, py, z, image) {
                image.blend(px, py, l.color, alpha);
            }
        }
    }
}

/// Part of the segment inside the picture, with a margin, as a range of its parameter.
fn clip(a: (f32, f32, f32), b: (f32, f32, f32), image: &Image) -> Option<(f32, f32)> {
    let (mut t0, mut t1) = (0.0_f32, 1.0_f32);
    let margin = 16.0;
    let sides = [(a.0, b.0 - a.0, image.width() as f32), (a.1, b.1 - a.1, image.height() as f32)];
    for (p, d, size) in sides {
        if d.abs() < 1e-6 {
            if p < -margin || p > size + margin {
                return None;
            }
            continue;
        }
        let (u, v) = ((-margin - p) / d, (size + margin - p) / d);
        t0 = t0.max(u.min(v));
        t1 = t1.min(u.max(v));
    }
    (t0 <= t1).then_some((t0, t1))
}

fn draw_dot(image: &mut Image, view: &View, p: &Dot, hidden: Hidden<'_>) {
    let Some((x, y, z)) = view.project(p.at) else { return };
    let r = (p.radius / (z * view.pixel_angle)).max(p.pixels).min(400.0);
    let inside = |v: f32, size: u32| v > -r - 1.0 && v < size as f32 + r + 1.0;
    if !(r > 0.0 && inside(x, image.width()) && inside(y, image.height())) {
        return;
    }
    let front = z - p.radius;
    for py in (y - r - 1.0).floor() as i32..=(y + r + 1.0).ceil() as i32 {
        for px in (x - r - 1.0).floor() as i32..=(x + r + 1.0).ceil() as i32 {
            let (ox, oy) = (px as f32 + 0.5 - x, py as f32 + 0.5 - y);
            let alpha = (r + 0.5 - (ox * ox + oy * oy).sqrt()).clamp(0.0, 1.0);
            if alpha > 0.0 && !hidden(px, py, front, image) {
                image.blend(px, py, shade_dot(p.color, ox / r, oy / r), alpha);
            }
        }
    }
}

/// A dot is lit like a small ball from the upper right.
fn shade_dot(color: [u8; 3], x: f32, y: f32) -> [u8; 3] {
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    let n = Vec3::new(x, -y, z);
    let light = 0.72 + 0.28 * n.dot(Vec3::new(0.48, 0.64, 0.6)).max(0.0);
    color.map(|c| (f32::from(c) * light) as u8)
}
