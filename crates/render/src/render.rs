//! One picture: rays from the eye, then light, then finer samples where edges are.
//!
//! 1. *Surfaces.* One ray per pixel.
//! 2. *Light.* Per pixel `light_samples` rays to the sun's disc and as many over the hemisphere. The
//!    directions are 16 · `light_samples` points of a Vogel spiral, dealt out over tiles of 4 × 4 pixels…
//! 3. *Gather.* …so that the mean over any 4 × 4 window, restricted to the same surface, sees all of them:
//!    soft shadows and ambient occlusion without noise for two rays per pixel. Two such windows with opposite
//!    offsets make a tent, which hides the tiles.
//! 4. *Shade.*
//! 5. *Edges.* A pixel that differs from a neighbour gets `edge_samples` more rays; they take their light from
//!    the neighbouring pixel that lies on the same surface.
//!
//! Each pass is a pure function of the one before, row by row, so the number of threads changes nothing; and
//! the directions do not change from frame to frame, so a film does not flicker.

use crate::camera::{Camera, View};
use crate::error::Result;
use crate::extras::{Bag, Extras, Props, is_extra};
use crate::image::Image;
use crate::look::{Encoder, Look, Spot};
use crate::overlay::Overlay;
use crate::parallel::rows;
use crate::tracer::{Hit, Tracer};
use crate::water::Waters;
use jounce::math::scalar::f32s;
use jounce::math::{DVec3, Vec3};

/// Size, quality and threads of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Rays to the sun and to the sky per pixel, each; 0 for neither shadow nor occlusion.
    pub light_samples: u32,
    /// Extra rays per pixel on an edge; 0 for no antialiasing.
    pub edge_samples: u32,
    /// Threads; 0 takes all cores.
    pub threads: usize,
    /// Light and sky.
    pub look: Look,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { width: 640, height: 360, light_samples: 1, edge_samples: 4, threads: 0, look: Look::default() }
    }
}

const NOTHING: u32 = u32::MAX;

#[derive(Clone, Copy)]
struct Pixel {
    /// Relative to the eye.
    pos: Vec3,
    t: f32,
    normal: Vec3,
    surface: u32,
}

const SKY: Pixel = Pixel { pos: Vec3::ZERO, t: f32::INFINITY, normal: Vec3::ZERO, surface: NOTHING };

/// Parts of sun and sky that a point sees.
#[derive(Clone, Copy)]
struct Light {
    sun: f32,
    open: f32,
}

const FULL: Light = Light { sun: 1.0, open: 1.0 };

/// Takes a picture.
///
/// # Errors
/// A camera or a size that no picture can have.
pub fn render(
    scene: &impl Tracer,
    camera: &Camera,
    overlay: &Overlay,
    options: &RenderOptions,
) -> Result<Image> {
    render_with(scene, camera, &Extras::default(), overlay, options)
}

/// Takes a picture of a scene with extras among its shapes.
///
/// # Errors
/// As [`render`]. Extras with numbers that nothing can have are left out.
pub fn render_with(
    scene: &impl Tracer,
    camera: &Camera,
    extras: &Extras,
    overlay: &Overlay,
    options: &RenderOptions,
) -> Result<Image> {
    camera.check()?;
    let mut image = Image::new(options.width, options.height, [0; 3])?;
    let frame = Frame::new(scene, camera, extras, options);
    let (w, h) = (options.width as usize, options.height as usize);
    let threads = options.threads;

    let mut pixels = vec![SKY; w * h];
    rows(&mut pixels, w, threads, |y, row| {
        for (x, p) in row.iter_mut().enumerate() {
            *p = frame.first_hit(x as f32 + 0.5, y as f32 + 0.5);
        }
    });
    let mut raw = vec![FULL; w * h];
    if options.light_samples > 0 {
        rows(&mut raw, w, threads, |y, row| {
            for (x, l) in row.iter_mut().enumerate() {
                *l = frame.light(&pixels[y * w + x], x, y);
            }
        });
    }
    let mut light = raw;
    if options.light_samples > 0 {
        for before in [2, 1] {
            let from = light;
            light = vec![FULL; w * h];
            rows(&mut light, w, threads, |y, row| {
                for (x, l) in row.iter_mut().enumerate() {
                    *l = frame.gather(&pixels, &from, x, y, before);
                }
            });
        }
    }
    let mut colors = vec![Vec3::ZERO; w * h];
    rows(&mut colors, w, threads, |y, row| {
        let mut bag = Bag::default();
        for (x, c) in row.iter_mut().enumerate() {
            let i = y * w + x;
            let dir = frame.view.dir(x as f32 + 0.5, y as f32 + 0.5);
            *c = frame.color((x, y), &pixels[i], dir, light[i], &mut bag);
        }
    });
    let mut fine = colors.clone();
    if options.edge_samples > 0 {
        rows(&mut fine, w, threads, |y, row| {
            let mut bag = Bag::default();
            for (x, c) in row.iter_mut().enumerate() {
                if frame.is_edge(&pixels, &colors, x, y) {
                    *c = frame.supersample(&pixels, &light, colors[y * w + x], x, y, &mut bag);
                }
            }
        });
    }
    let encoder = Encoder::new();
    let bytes = fine.iter().map(|&c| encoder.bytes(c)).collect();
    image = Image::from_pixels(image.width(), image.height(), bytes)?;
    if !overlay.is_empty() {
        let depth: Vec<f32> = pixels.iter().map(|p| p.pos.dot(frame.view.forward)).collect();
        let depth = |i: usize| if pixels[i].surface == NOTHING { f32::INFINITY } else { depth[i] };
        overlay.draw(&mut image, &frame.view, depth);
    }
    Ok(image)
}

struct Frame<'a, T> {
    scene: &'a T,
    /// What there is beside the scene's shapes.
    props: Option<Props>,
    waters: Waters,
    view: View,
    look: &'a Look,
    width: usize,
    height: usize,
    light_samples: u32,
    edge_samples: u32,
    reach: f32,
    haze: f32,
    far: f32,
    /// Unit disc points for sun and hemisphere.
    spiral: Vec<(f32, f32)>,
    sun_basis: (Vec3, Vec3),
}

/// Order in which the 16 directions are dealt to a tile: neighbours get directions far apart.
const DEAL: [u32; 16] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];

impl<'a, T: Tracer> Frame<'a, T> {
    fn new(scene: &'a T, camera: &Camera, extras: &Extras, options: &'a RenderOptions) -> Self {
        let focus = (camera.target - camera.position).length() as f32;
        let look = &options.look;
        let choose = |given: f32, auto: f32| if given > 0.0 { given } else { auto };
        let n = 16 * options.light_samples.max(1);
        // Vogel's spiral: equal areas, golden angle.
        let spiral = (0..n)
            .map(|k| {
                let r = ((k as f32 + 0.5) / n as f32).sqrt();
                let a = k as f32 * 2.399_963;
                (r * f32s::cos(a), r * f32s::sin(a))
            })
            .collect();
        let view = camera.view(options.width, options.height);
        let haze = choose(look.haze_distance, f32s::max(focus * 8.0, 1.0));
        let far = f32s::max(focus * 150.0, 100.0);
        let mut props = Props::new(extras, &view, options.width as usize, options.height as usize);
        if let Some(props) = &mut props {
            props.light_layers(scene, look, haze, far, options.threads);
        }
        Self {
            scene,
            props,
            waters: Waters::new(&extras.waters, &view, focus),
            view,
            look,
            width: options.width as usize,
            height: options.height as usize,
            light_samples: options.light_samples,
            edge_samples: options.edge_samples,
            reach: choose(look.openness_reach, f32s::clamp(focus * 0.09, 0.05, 4.0)),
            haze,
            far,
            spiral,
            sun_basis: look.sun.orthonormal_basis(),
        }
    }

    /// The nearest solid, of the scene or beside it; the eye's rays pass what is drawn as a layer.
    fn trace(&self, from: DVec3, dir: Vec3, max_t: f32, eye: bool) -> Option<Hit> {
        let hit = self.scene.trace(from, dir, max_t);
        let Some(props) = &self.props else { return hit };
        let max_t = hit.map_or(max_t, |h| h.t);
        props.trace(from, dir, max_t, eye).or(hit)
    }

    /// Part of the light that comes along a ray.
    fn reaches(&self, from: DVec3, dir: Vec3) -> f32 {
        if self.scene.occluded(from, dir, self.far) {
            return 0.0;
        }
        self.props.as_ref().map_or(1.0, |p| p.light(from, dir, self.far))
    }

    fn first_hit(&self, x: f32, y: f32) -> Pixel {
        let dir = self.view.dir(x, y);
        match self.trace(self.view.origin, dir, self.far, true) {
            Some(hit) => {
                let towards = hit.normal.dot(dir) <= 0.0;
                let normal = if towards { hit.normal } else { -hit.normal };
                Pixel { pos: dir * hit.t, t: hit.t, normal, surface: hit.surface }
            }
            None => SKY,
        }
    }

    /// A start for rays that leave a surface: lifted off it by more than the rounding of the hit.
    fn lifted(&self, p: &Pixel) -> DVec3 {
        let lift = 1e-4 + 4e-4 * p.t * self.view.pixel_angle.max(1e-3);
        self.view.origin + (p.pos + p.normal * lift).as_dvec3()
    }

    fn light(&self, p: &Pixel, x: usize, y: usize) -> Light {
        if p.surface == NOTHING {
            return FULL;
        }
        let start = self.lifted(p);
        let lit = p.normal.dot(self.look.sun) > 0.0;
        let dealt = DEAL[(y % 4) * 4 + x % 4];
        let (u, v) = p.normal.orthonormal_basis();
        let (mut sun, mut open) = (0.0, 0.0);
        for s in 0..self.light_samples {
            let (a, b) = self.spiral[(s * 16 + dealt) as usize];
            if lit {
                let r = self.look.sun_radius;
                let d = self.look.sun + self.sun_basis.0 * (a * r) + self.sun_basis.1 * (b * r);
                let d = d / d.length();
                if d.dot(p.normal) > 0.0 {
                    sun += self.reaches(start, d);
                }
            }
            // Points of the disc lifted to the hemisphere are cosine-weighted (Malley).
            let up = f32s::max(1.0 - a * a - b * b, 0.0).sqrt();
            let d = u * a + v * b + p.normal * up;
            open += match self.trace(start, d, self.reach, false) {
                Some(hit) => {
                    let near = 1.0 - hit.t / self.reach;
                    1.0 - near * (2.0 - near) * 0.85
                }
                None => 1.0,
            };
        }
        let n = self.light_samples as f32;
        Light { sun: sun / n, open: open / n }
    }

    /// Do two points lie on one smooth piece of surface, as seen at `a`'s distance?
    fn same_face(&self, a: &Pixel, b: &Pixel) -> bool {
        if a.surface == NOTHING || b.surface == NOTHING {
            return false;
        }
        let size = a.t * self.view.pixel_angle;
        a.normal.dot(b.normal) > 0.85 && (b.pos - a.pos).dot(a.normal).abs() < 2.5 * size + 1e-4
    }

    /// Mean over the 4 × 4 window that starts `before` pixels up and left.
    fn gather(&self, pixels: &[Pixel], raw: &[Light], x: usize, y: usize, before: usize) -> Light {
        let here = &pixels[y * self.width + x];
        if here.surface == NOTHING {
            return FULL;
        }
        let (mut sun, mut open, mut n) = (0.0, 0.0, 0.0);
        for j in y.saturating_sub(before)..(y + 4 - before).min(self.height) {
            for i in x.saturating_sub(before)..(x + 4 - before).min(self.width) {
                let k = j * self.width + i;
                if self.same_face(here, &pixels[k]) {
                    sun += raw[k].sun;
                    open += raw[k].open;
                    n += 1.0;
                }
            }
        }
        if n == 0.0 { raw[y * self.width + x] } else { Light { sun: sun / n, open: open / n } }
    }

    /// Display colour along a ray through pixel `at` that ends at `p`.
    fn color(&self, at: (usize, usize), p: &Pixel, dir: Vec3, light: Light, bag: &mut Bag) -> Vec3 {
        let behind = self.waters.over(self.radiance(p, dir, light), dir, p.t);
        let light = match &self.props {
            Some(props) => props.over(behind, at, dir, p.t, self.look.sun, bag),
            None => behind,
        };
        self.look.tone(light)
    }

    /// Light from the solid or the sky.
    fn radiance(&self, p: &Pixel, dir: Vec3, light: Light) -> Vec3 {
        if p.surface == NOTHING {
            return self.look.sky(dir);
        }
        let extra = self.props.as_ref().filter(|_| is_extra(p.surface));
        let skin = extra.map_or_else(|| self.scene.skin(p.surface), |props| props.skin(p.surface));
        let point = self.view.origin + p.pos.as_dvec3();
        // Where the neighbouring pixels' rays meet the tangent plane.
        let slope = f32s::min(p.normal.dot(dir), -0.02);
        let on_plane = |step: Vec3| {
            let d = step * p.t;
            d - dir * (d.dot(p.normal) / slope)
        };
        let spot = Spot {
            point,
            local: if extra.is_some() { p.pos } else { self.scene.to_local(p.surface, point) },
            normal: p.normal,
            dir,
            t: p.t,
            dx: on_plane(self.view.right),
            dy: on_plane(self.view.down),
            sun: light.sun,
            open: light.open,
        };
        self.look.shade(&skin, &spot, self.haze)
    }

    fn is_edge(&self, pixels: &[Pixel], colors: &[Vec3], x: usize, y: usize) -> bool {
        let k = y * self.width + x;
        let here = &pixels[k];
        let differs = |i: usize| {
            let there = &pixels[i];
            let change = (colors[i] - colors[k]).abs().max_component();
            // A faint edge is not worth its rays.
            change > 0.03 && (here.surface != there.surface || !self.same_face(here, there))
        };
        (x > 0 && differs(k - 1))
            || (x + 1 < self.width && differs(k + 1))
            || (y > 0 && differs(k - self.width))
            || (y + 1 < self.height && differs(k + self.width))
    }

    fn supersample(
        &self,
        pixels: &[Pixel],
        light: &[Light],
        first: Vec3,
        x: usize,
        y: usize,
        bag: &mut Bag,
    ) -> Vec3 {
        let n = self.edge_samples;
        let mut sum = first;
        for s in 0..n {
            // Points of a rank-1 lattice: evenly spread, never on one row or column.
            let (a, b) = ((s as f32 + 0.5) / n as f32, (s as f32 * 0.618_034 + 0.31).fract());
            let (px, py) = (x as f32 + a, y as f32 + b);
            let p = self.first_hit(px, py);
            let near = self.borrowed(pixels, light, &p, x, y);
            sum += self.color((x, y), &p, self.view.dir(px, py), near, bag);
        }
        sum / (n + 1) as f32
    }

    /// Light of the nearest pixel around (x, y) on the same face as `p`; own rays where there is none.
    fn borrowed(&self, pixels: &[Pixel], light: &[Light], p: &Pixel, x: usize, y: usize) -> Light {
        if p.surface == NOTHING || self.light_samples == 0 {
            return FULL;
        }
        let (mut best, mut found) = (f32::INFINITY, None);
        for j in y.saturating_sub(1)..(y + 2).min(self.height) {
            for i in x.saturating_sub(1)..(x + 2).min(self.width) {
                let k = j * self.width + i;
                let d = (pixels[k].pos - p.pos).length_squared();
                if d < best && self.same_face(p, &pixels[k]) {
                    (best, found) = (d, Some(light[k]));
                }
            }
        }
        found.unwrap_or_else(|| self.light(p, x, y))
    }
}
