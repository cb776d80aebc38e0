//! How much light reaches each translucent thing through those before it: one sweep along the light's direction.
//!
//! The things are taken from the light on. Each reads, at its middle, what came through so far, and balls then dim what
//! comes after them, on grids that stand across the light. A ball writes to the grid whose cells fit its size (the
//! power of two below its radius), some twenty nodes; a reader multiplies what the grids of all sizes say. So the
//! cost is a few dozen reads a thing, however dense the cloud and however the sizes differ. That one ball is before
//! another is decided by their middles.

use super::layer::{Kind, Layer};
use jounce::math::Vec3;
use jounce::math::scalar::f32s;
use std::collections::HashMap;

/// Sizes below 2 to this power, metres, share a grid.
const LEVEL_MIN: i32 = -16;

/// Part of the light that comes through, by node; absent nodes have all of it. Only looked up, never walked: the
/// map's order does not matter.
#[derive(Default)]
struct Grid {
    level: i32,
    nodes: HashMap<(i64, i64), f32>,
}

impl Grid {
    fn cell(&self) -> f32 {
        f32::from_bits(((self.level + 127) as u32) << 23)
    }

    fn read(&self, x: f32, y: f32) -> f32 {
        let cell = self.cell();
        let (u, v) = (x / cell, y / cell);
        let (i, j) = (u.floor(), v.floor());
        let (a, b) = (u - i, v - j);
        let (i, j) = (i as i64, j as i64);
        let node = |di: i64, dj: i64| self.nodes.get(&(i + di, j + dj)).copied().unwrap_or(1.0);
        let low = node(0, 0) * (1.0 - a) + node(1, 0) * a;
        let high = node(0, 1) * (1.0 - a) + node(1, 1) * a;
        low * (1.0 - b) + high * b
    }

    fn dim(&mut self, x: f32, y: f32, layer: &Layer) {
        let cell = self.cell();
        let r = layer.radius;
        let first = |v: f32| ((v - r) / cell).ceil() as i64;
        let last = |v: f32| ((v + r) / cell).floor() as i64;
        for j in first(y)..=last(y) {
            for i in first(x)..=last(x) {
                let (dx, dy) = (i as f32 * cell - x, j as f32 * cell - y);
                let u = f32s::max(1.0 - (dx * dx + dy * dy) / (r * r), 0.0);
                let profile = match layer.kind {
                    Kind::Soft => u * u,
                    _ if u > 0.0 => 1.0,
                    _ => 0.0,
                };
                let alpha = layer.opacity * (1.0 - layer.glow) * profile;
                *self.nodes.entry((i, j)).or_insert(1.0) *= 1.0 - alpha;
            }
        }
    }
}

/// For each layer the part of the light from `towards` that the others let through to its middle.
pub(crate) fn sweep(layers: &[Layer], towards: Vec3) -> Vec<f32> {
    let (u, v) = towards.orthonormal_basis();
    let mut order: Vec<(f32, u32)> = layers.iter().map(|l| -l.middle().dot(towards)).zip(0..).collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut grids: Vec<Grid> = Vec::new();
    let mut through = vec![1.0; layers.len()];
    for (_, i) in order {
        let layer = &layers[i as usize];
        let at = layer.middle();
        let (x, y) = (at.dot(u), at.dot(v));
        through[i as usize] = grids.iter().map(|g| g.read(x, y)).product();
        if !layer.shades || !matches!(layer.kind, Kind::Soft | Kind::Hard) {
            continue;
        }
        let level = ((layer.radius.to_bits() >> 23) as i32 - 127).max(LEVEL_MIN);
        let place = grids.binary_search_by_key(&level, |g| g.level).unwrap_or_else(|place| {
            grids.insert(place, Grid { level, ..Grid::default() });
            place
        });
        grids[place].dim(x, y, layer);
    }
    through
}

#[cfg(test)]
mod tests {
    use super::super::layer::Tint;
    use super::*;

    fn soft(y: f32, radius: f32, opacity: f32) -> Layer {
        Layer {
            kind: Kind::Soft,
            a: Vec3::new(0.3, y, -4.0),
            ab: Vec3::ZERO,
            radius,
            color: Vec3::ONE,
            opacity,
            glow: 0.0,
            shades: true,
            tint: Tint::BLACK,
        }
    }

    #[test]
    fn what_is_behind_gets_less() {
        let glowing = Layer { glow: 1.0, shades: false, ..soft(9.0, 1.0, 1.0) };
        // Sizes that differ a lot, so that several grids are read.
        let layers = [soft(0.0, 0.5, 0.4), soft(1.0, 4.0, 0.5), soft(2.0, 0.4, 0.2), glowing];
        let through = sweep(&layers, Vec3::Y);
        for (got, want) in through.iter().zip([0.5 * 0.8, 0.8, 1.0, 1.0]) {
            // Between nodes a ball's profile is a chord of the curve: up to a fifth of its opacity off.
            assert!((got - want).abs() < 0.1, "{through:?}");
        }
        assert_eq!(sweep(&layers, -Vec3::Y)[0], 1.0);
        let tiny = [soft(0.0, 1e-30, 1.0), soft(1.0, 9e8, 1.0)];
        assert!(sweep(&tiny, Vec3::Y).iter().all(|t| (0.0..=1.0).contains(t)));
    }
}
