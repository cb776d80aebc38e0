//! Extras made ready for one picture: checked, brought into the frame of the eye, sorted, put into trees and lit.

use super::layer::{Bag, Kind, Layer, Probe, Tint, transmitted};
use super::solid::{Form, Solid};
use super::sweep::sweep;
use super::tiles::Tiles;
use super::{Ball, Extras, Face, Rod};
use crate::camera::View;
use crate::look::{Look, Pattern, Skin};
use crate::parallel::rows;
use crate::tracer::{Hit, Tracer};
use jounce::geometry::{Aabb, Bvh};
use jounce::math::scalar::{f32s, f64s};
use jounce::math::{DVec3, Vec3};

/// Set in the surface number of an extra.
const EXTRA: u32 = 1 << 31;
/// Places and radii beyond are left out: their squares would overflow.
const FAR: f32 = 1e9;
/// Most items of a kind.
const ITEMS_MAX: usize = 1 << 30;
/// Opaque things thinner than this radius on the picture, pixels, are drawn as layers.
const SOLID_MIN_PX: f32 = 0.75;

/// Does a surface number name an extra?
pub(crate) fn is_extra(surface: u32) -> bool {
    surface & EXTRA != 0
}

/// Extras ready for rays. Positions are relative to the eye, so that places far from the world's origin are drawn as
/// exactly as near ones.
pub(crate) struct Props {
    eye: DVec3,
    pixel_angle: f32,
    solids: Vec<Solid>,
    solid_tree: Bvh,
    /// In the order of their depth.
    layers: Vec<Layer>,
    /// Of those that stop light.
    shade_tree: Bvh,
    tiles: Tiles,
}

impl Props {
    /// `None` where there is nothing to draw.
    pub fn new(extras: &Extras, view: &View, width: usize, height: usize) -> Option<Self> {
        let (eye, pixel_angle) = (view.origin, view.pixel_angle);
        let (mut solids, mut layers) = (Vec::new(), Vec::new());
        let sort = Sort { eye, pixel_angle };
        extras.balls.iter().take(ITEMS_MAX).for_each(|b| sort.ball(b, &mut solids, &mut layers));
        extras.rods.iter().take(ITEMS_MAX).for_each(|r| sort.rod(r, &mut solids, &mut layers));
        solids.extend(extras.faces.iter().take(ITEMS_MAX).filter_map(|f| sort.face(f)));
        if solids.is_empty() && layers.is_empty() {
            return None;
        }
        sort_by_key(&mut solids, Solid::key);
        sort_by_key(&mut layers, Layer::key);
        let solid_tree = tree(solids.iter().map(Solid::aabb).zip(0..));
        let shading = layers.iter().zip(0..).filter(|(l, _)| l.shades);
        let shade_tree = tree(shading.map(|(l, i)| (l.aabb(), i)));
        let tiles = Tiles::new(&layers, view, width, height);
        Some(Self { eye, pixel_angle, solids, solid_tree, layers, shade_tree, tiles })
    }

    /// The first solid on a ray; with `eye` only those wide enough for the eye's rays.
    pub fn trace(&self, from: DVec3, dir: Vec3, max_t: f32, eye: bool) -> Option<Hit> {
        if self.solids.is_empty() {
            return None;
        }
        let from = (from - self.eye).as_vec3();
        let mut best: Option<Hit> = None;
        self.solid_tree.ray(from, dir, Vec3::ZERO, max_t, |i, max_t| {
            let solid = &self.solids[i as usize];
            if eye && solid.thin {
                return max_t;
            }
            let Some((t, normal)) = solid.hit(from, dir, max_t) else { return max_t };
            let surface = EXTRA | i;
            // At one distance the first in the sorted list, whatever the tree's order.
            if best.is_none_or(|b| t < b.t || (t == b.t && surface < b.surface)) {
                best = Some(Hit { t, normal, surface });
            }
            t
        });
        best
    }

    /// Part of the light that reaches a point along a ray.
    pub fn light(&self, from: DVec3, dir: Vec3, max_t: f32) -> f32 {
        let from = (from - self.eye).as_vec3();
        if self.blocked(from, dir, max_t) {
            return 0.0;
        }
        transmitted(&self.shade_tree, &self.layers, &Probe { from, dir, end: max_t, pixel_angle: 0.0 })
    }

    fn blocked(&self, from: Vec3, dir: Vec3, max_t: f32) -> bool {
        let mut blocked = false;
        self.solid_tree.ray(from, dir, Vec3::ZERO, max_t, |i, max_t| {
            blocked = self.solids[i as usize].hit(from, dir, max_t).is_some();
            if blocked { -1.0 } else { max_t }
        });
        blocked
    }

    pub fn skin(&self, surface: u32) -> Skin {
        let solid = self.solids.get((surface & !EXTRA) as usize);
        let (color, face) =
            solid.map_or((Vec3::ZERO, false), |s| (s.color, matches!(s.form, Form::Face { .. })));
        Skin { color, pattern: Pattern::Plain, gloss: if face { 0.08 } else { 0.5 } }
    }

    /// What is behind, seen through the layers along a ray through pixel `at`; `end` is the distance of the solid.
    pub fn over(
        &self,
        behind: Vec3,
        at: (usize, usize),
        dir: Vec3,
        end: f32,
        sun: Vec3,
        bag: &mut Bag,
    ) -> Vec3 {
        let near = self.tiles.at(at.0, at.1);
        if near.list.is_empty() {
            return behind;
        }
        let probe = Probe { from: Vec3::ZERO, dir, end, pixel_angle: self.pixel_angle };
        bag.over(&self.layers, &near, &probe, sun, behind)
    }

    /// Finds out how much light each layer gets: through the others by a sweep from the sun and one from above, past
    /// solids by a ray to the sun.
    pub fn light_layers<T: Tracer>(&mut self, scene: &T, look: &Look, haze: f32, reach: f32, threads: usize) {
        const CHUNK: usize = 64;
        let sun = sweep(&self.layers, look.sun);
        let open = sweep(&self.layers, Vec3::Y);
        let mut tints = vec![Tint::BLACK; self.layers.len()];
        rows(&mut tints, CHUNK, threads, |chunk, tints| {
            for (k, tint) in tints.iter_mut().enumerate() {
                let i = chunk * CHUNK + k;
                let layer = &self.layers[i];
                let soft = layer.kind == Kind::Soft;
                // Hard things are lit at their surface.
                let lift = if soft { 0.0 } else { layer.radius * 1.01 + 1e-4 };
                let start = layer.middle() + look.sun * lift;
                let blocked = layer.glow < 1.0
                    && (scene.occluded(self.eye + start.as_dvec3(), look.sun, reach)
                        || self.blocked(start, look.sun, reach));
                // Light that is scattered on the way still arrives: it comes deeper than it shines straight.
                let sun = if blocked { 0.0 } else { sun[i].sqrt() };
                let open = 0.45 + 0.55 * open[i].sqrt();
                *tint = tint_of(layer, look, sun, open, haze);
            }
        });
        self.layers.iter_mut().zip(tints).for_each(|(l, t)| l.tint = t);
    }
}

fn tint_of(layer: &Layer, look: &Look, sun: f32, open: f32, haze: f32) -> Tint {
    let (ambient, sun) = look.dim_light(layer.color, sun, open);
    let at = layer.middle();
    let far = Look::haze(at.length(), haze);
    Tint {
        ambient: ambient.lerp(look.haze_color(at.normalize_or(Vec3::Z)), far),
        sun: sun * (1.0 - far),
        emitted: layer.color * (EMITTED * layer.glow * (1.0 - far)),
    }
}

/// Light of what glows; a white surface in the sun sends about 3.
const EMITTED: f32 = 3.5;

fn tree(boxes: impl Iterator<Item = (Aabb, u32)>) -> Bvh {
    Bvh::build(&boxes.collect::<Vec<_>>())
}

fn sort_by_key<T, const N: usize>(items: &mut Vec<T>, key: impl Fn(&T) -> [f32; N]) {
    let mut keyed: Vec<([f32; N], T)> = items.drain(..).map(|i| (key(&i), i)).collect();
    keyed.sort_unstable_by(|(a, _), (b, _)| {
        let differ = a.iter().zip(b).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne());
        differ.unwrap_or(std::cmp::Ordering::Equal)
    });
    items.extend(keyed.into_iter().map(|(_, i)| i));
}

/// Decides what becomes of each item.
struct Sort {
    eye: DVec3,
    pixel_angle: f32,
}

impl Sort {
    fn place(&self, p: DVec3) -> Option<Vec3> {
        let v = (p - self.eye).as_vec3();
        // NaN compares false and is left out too.
        (v.abs().max_component() < FAR && v.is_finite()).then_some(v)
    }

    fn thin(&self, radius: f32, at: Vec3) -> bool {
        radius < at.length() * self.pixel_angle * SOLID_MIN_PX
    }

    fn ball(&self, b: &Ball, solids: &mut Vec<Solid>, layers: &mut Vec<Layer>) {
        let Some(a) = self.place(b.center) else { return };
        let kind = if b.soft { Kind::Soft } else { Kind::Hard };
        let Some(mut layer) = layer(kind, a, Vec3::ZERO, b.radius, b.color, b.opacity, b.glow) else {
            return;
        };
        if !b.soft && layer.opacity >= 1.0 && layer.glow == 0.0 {
            let thin = self.thin(b.radius, a);
            let form = Form::Ball { center: a, radius: b.radius };
            solids.push(Solid { form, color: layer.color, thin });
            if !thin {
                return;
            }
            layer.shades = false;
        }
        layers.push(layer);
    }

    fn rod(&self, r: &Rod, solids: &mut Vec<Solid>, layers: &mut Vec<Layer>) {
        let (Some(a), Some(b)) = (self.place(r.a), self.place(r.b)) else { return };
        let opaque = r.opacity >= 1.0 && r.glow.is_finite() && r.glow <= 0.0;
        let kind = if opaque { Kind::Round } else { Kind::Flat };
        let Some(mut layer) = layer(kind, a, b - a, r.radius, r.color, r.opacity, r.glow) else { return };
        if opaque {
            let thin = self.thin(r.radius, a) || self.thin(r.radius, b);
            solids.push(Solid { form: Form::Rod { a, b, radius: r.radius }, color: layer.color, thin });
            if !thin {
                return;
            }
            layer.shades = false;
        } else if a == b {
            return;
        }
        layers.push(layer);
    }

    fn face(&self, f: &Face) -> Option<Solid> {
        let (a, b, c) = (self.place(f.a)?, self.place(f.b)?, self.place(f.c)?);
        let flat = (b - a).cross(c - a).try_normalize()?.0;
        let normals = f.normals.map_or([flat; 3], |n| n.map(|n| if n.is_finite() { n } else { flat }));
        Some(Solid { form: Form::Face { a, b, c, normals }, color: linear(f.color)?, thin: false })
    }
}

fn layer(
    kind: Kind,
    a: Vec3,
    ab: Vec3,
    radius: f32,
    color: [f32; 3],
    opacity: f32,
    glow: f32,
) -> Option<Layer> {
    let fits = radius > 0.0 && radius < FAR && opacity > 0.0 && !glow.is_nan();
    let color = linear(color)?;
    let (opacity, glow) = (f32s::min(opacity, 1.0), f32s::clamp(glow, 0.0, 1.0));
    let shades = glow < 1.0;
    fits.then_some(Layer { kind, a, ab, radius, color, opacity, glow, shades, tint: Tint::BLACK })
}

/// sRGB 0…1 as linear light; `None` for NaN.
fn linear(color: [f32; 3]) -> Option<Vec3> {
    let c = |v: f32| {
        let v = f64::from(f32s::clamp(v, 0.0, 1.0));
        let l = if v <= 0.04045 { v / 12.92 } else { f64s::pow((v + 0.055) / 1.055, 2.4) };
        l as f32
    };
    color.iter().all(|v| !v.is_nan()).then(|| Vec3::new(c(color[0]), c(color[1]), c(color[2])))
}
