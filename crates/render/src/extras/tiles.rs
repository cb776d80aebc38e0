//! Which layers each part of the picture may show.
//!
//! The picture is cut into tiles; a tile lists the layers whose bounds reach into it, in the order of their distance.

use super::layer::Layer;
use crate::camera::View;
use jounce::math::Vec3;
use jounce::math::scalar::f32s;

/// Tiles along the longer side of the picture.
const TILES: usize = 32;
/// Most entries of all lists together; tiles are made larger until they fit.
const ENTRIES_MAX: usize = 1 << 24;

/// A ball around all that the eye's rays see of a layer.
#[derive(Clone, Copy)]
pub(crate) struct Sphere {
    pub center: Vec3,
    pub radius2: f32,
    /// As [`Layer::depth`].
    pub depth: f32,
}

/// The layers that a ray may meet, by their numbers, nearest first.
pub(crate) struct Near<'a> {
    pub list: &'a [u32],
    pub spheres: &'a [Sphere],
}

/// Layers by tile.
pub(crate) struct Tiles {
    spheres: Vec<Sphere>,
    /// Pixels.
    side: usize,
    columns: usize,
    /// Where each tile's list begins, and the end.
    starts: Vec<u32>,
    lists: Vec<u32>,
}

/// Tiles that a layer reaches: first and last column and row.
type Span = [usize; 4];

impl Tiles {
    /// Lists for layers that stand in the order of their depth.
    pub fn new(layers: &[Layer], view: &View, width: usize, height: usize) -> Self {
        let reach = |l: &Layer| {
            let b = l.a + l.ab;
            (l.reach(l.a, view.pixel_angle), l.reach(b, view.pixel_angle))
        };
        let sphere = |l: &Layer| {
            let (ra, rb) = reach(l);
            let radius = l.ab.length() * 0.5 + f32s::max(ra, rb);
            Sphere { center: l.middle(), radius2: radius * radius, depth: l.depth() }
        };
        let rect = |l: &Layer| {
            let (ra, rb) = reach(l);
            let (p, q) = (bounds(view, l.a, ra), bounds(view, l.a + l.ab, rb));
            [f32s::min(p[0], q[0]), f32s::max(p[1], q[1]), f32s::min(p[2], q[2]), f32s::max(p[3], q[3])]
        };
        let rects: Vec<[f32; 4]> = layers.iter().map(rect).collect();
        let mut side = width.max(height).div_ceil(TILES).max(8);
        let mut spans = spans(&rects, side, width, height);
        while side < width.max(height) && spans.iter().flatten().map(count).sum::<usize>() > ENTRIES_MAX {
            side *= 2;
            spans = self::spans(&rects, side, width, height);
        }
        let (columns, lines) = (width.div_ceil(side), height.div_ceil(side));
        let mut starts = vec![0_u32; columns * lines + 1];
        let tiles = |s: Span| (s[2]..=s[3]).flat_map(move |y| (s[0]..=s[1]).map(move |x| y * columns + x));
        spans.iter().flatten().flat_map(|&s| tiles(s)).for_each(|t| starts[t + 1] += 1);
        for t in 0..columns * lines {
            starts[t + 1] += starts[t];
        }
        let mut ends = starts.clone();
        let mut lists = vec![0; starts[columns * lines] as usize];
        for (i, span) in spans.iter().enumerate() {
            for t in span.iter().flat_map(|&s| tiles(s)) {
                lists[ends[t] as usize] = i as u32;
                ends[t] += 1;
            }
        }
        Self { spheres: layers.iter().map(sphere).collect(), side, columns, starts, lists }
    }

    /// The layers that may be seen in a pixel.
    pub fn at(&self, x: usize, y: usize) -> Near<'_> {
        let t = y / self.side * self.columns + x / self.side;
        let list = &self.lists[self.starts[t] as usize..self.starts[t + 1] as usize];
        Near { list, spheres: &self.spheres }
    }
}

fn count(s: &Span) -> usize {
    (s[1] + 1 - s[0]) * (s[3] + 1 - s[2])
}

/// Tiles under each rectangle of pixels; `None` where it lies outside the picture.
fn spans(rects: &[[f32; 4]], side: usize, width: usize, height: usize) -> Vec<Option<Span>> {
    let span = |r: &[f32; 4]| {
        let outside = r[1] < 0.0 || r[0] > width as f32 || r[3] < 0.0 || r[2] > height as f32;
        let tile = |v: f32, size: usize| (f32s::max(v, 0.0) as usize).min(size - 1) / side;
        let [x0, x1] = [r[0], r[1]].map(|v| tile(v, width));
        let [y0, y1] = [r[2], r[3]].map(|v| tile(v, height));
        (!outside).then_some([x0, x1, y0, y1])
    };
    rects.iter().map(span).collect()
}

/// The rectangle of pixels around a ball: left, right, top, bottom.
fn bounds(view: &View, center: Vec3, radius: f32) -> [f32; 4] {
    let scale = 1.0 / view.pixel_angle;
    let z = center.dot(view.forward);
    let [x0, x1] = outline(center.dot(view.right) * scale, z, radius).map(|v| v * scale + view.center.0);
    let [y0, y1] = outline(center.dot(view.down) * scale, z, radius).map(|v| v * scale + view.center.1);
    [x0, x1, y0, y1]
}

/// The slopes x/z of the two lines from the origin that touch the circle around (x, z): with sin φ = r/d,
/// tan(θ ± φ) = (x h ± r z) / (z h ∓ r x), h² = d² − r². Infinite where the circle reaches behind the eye.
fn outline(x: f32, z: f32, r: f32) -> [f32; 2] {
    let h2 = x * x + z * z - r * r;
    if h2 <= 0.0 {
        return if z > -r { [f32::NEG_INFINITY, f32::INFINITY] } else { [f32::INFINITY, f32::NEG_INFINITY] };
    }
    if z <= -r {
        // All of it is behind: an empty range.
        return [f32::INFINITY, f32::NEG_INFINITY];
    }
    let h = h2.sqrt();
    let (low, high) = (z * h + r * x, z * h - r * x);
    let lo = if low > 0.0 { (x * h - r * z) / low } else { f32::NEG_INFINITY };
    let hi = if high > 0.0 { (x * h + r * z) / high } else { f32::INFINITY };
    [lo, hi]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_touch_the_circle() {
        for (x, z, r) in [(0.0, 5.0, 1.0), (3.0, 4.0, 0.5), (-7.0, 2.0, 1.5), (2.0, 1.0, 1.2)] {
            for slope in outline(x, z, r).into_iter().filter(|s| s.is_finite()) {
                let off = (x - slope * z).abs() / (1.0 + slope * slope).sqrt();
                assert!((off - r).abs() < 1e-4 * (1.0 + r), "{x} {z} {r}: {slope}");
            }
        }
        assert_eq!(outline(0.0, 0.5, 1.0), [f32::NEG_INFINITY, f32::INFINITY]);
        let [lo, hi] = outline(0.3, -4.0, 1.0);
        assert!(lo > hi);
    }
}
