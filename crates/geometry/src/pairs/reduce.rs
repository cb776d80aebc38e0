//! Many contact points to four.
//!
//! Keeps the deepest point, the one farthest from it, and the two that span the largest triangles on
//! either side of that line. Points kept in the last step win against others by less than 5 %, so the choice does not
//! flicker.

use crate::{Manifold, ManifoldPoint, PairCache};
use jounce_math::Vec3;

/// Bonus of a point that was kept last time.
const KEEP: f32 = 1.0 / 0.95;

/// Sixteen bits of a feature id, for remembering four of them in a cache.
fn short(feature: u32) -> u32 {
    let h = feature.wrapping_mul(0x9E37_79B1) >> 16;
    if h == 0 { 1 } else { h }
}

fn kept(cache: &PairCache, feature: u32) -> bool {
    let h = short(feature);
    let [a, b] = cache.features;
    h == a & 0xFFFF || h == a >> 16 || h == b & 0xFFFF || h == b >> 16
}

fn remember(cache: &mut PairCache, m: &Manifold) {
    let h = |i: usize| if i < usize::from(m.count) { short(m.points[i].feature) } else { 0 };
    cache.features = [h(0) | h(1) << 16, h(2) | h(3) << 16];
}

/// Fills `m.points` with at most four of `points` (non-empty), in their given order.
pub(crate) fn reduce(points: &[ManifoldPoint], m: &mut Manifold, cache: &mut PairCache) {
    if points.len() <= 4 {
        m.points[..points.len()].copy_from_slice(points);
        m.count = points.len() as u8;
        return;
    }
    let mut chosen = choose(points, m.normal, cache);
    let n = chosen.iter().filter(|&&i| i != usize::MAX).count();
    chosen.sort_unstable();
    for k in 0..n {
        m.points[k] = points[chosen[k]];
    }
    m.count = n as u8;
    remember(cache, m);
}

fn choose(points: &[ManifoldPoint], normal: Vec3, cache: &PairCache) -> [usize; 4] {
    let mut out = [usize::MAX; 4];
    // Which were kept last time, one bit each; beyond 64 points nobody is favoured.
    let mut mask = 0u64;
    if cache.features != [0; 2] {
        for (i, p) in points.iter().enumerate().take(64) {
            mask |= u64::from(kept(cache, p.feature)) << i;
        }
    }
    let keep = |i: usize| if i < 64 && mask >> i & 1 != 0 { KEEP } else { 1.0 };
    let spread = extent(points);
    // Resting faces are equally deep up to rounding; the bonus is far below any slop.
    let first = best(points, |i, p| -p.separation + (keep(i) - 1.0) * spread * 2e-3);
    out[0] = first;
    let o = points[first].point;
    let second = best(points, |i, p| (p.point - o).length_squared() * keep(i));
    if second == first {
        return out;
    }
    out[1] = second;
    let side = normal.cross(points[second].point - o);
    let tiny = side.length() * spread * 1e-4;
    for (slot, s) in [(2, 1.0), (3, -1.0)] {
        let area = |i: usize, p: &ManifoldPoint| s * side.dot(p.point - o) * keep(i);
        let i = best(points, area);
        if area(i, &points[i]) > tiny {
            out[slot] = i;
        }
    }
    if out[2] == usize::MAX {
        out.swap(2, 3);
    }
    out
}

fn extent(points: &[ManifoldPoint]) -> f32 {
    let b = crate::Aabb::from_points(points.iter().map(|p| p.point));
    (b.max - b.min).max_component()
}

fn best(points: &[ManifoldPoint], score: impl Fn(usize, &ManifoldPoint) -> f32) -> usize {
    let mut at = 0;
    let mut high = f32::NEG_INFINITY;
    for (i, p) in points.iter().enumerate() {
        let s = score(i, p);
        if s > high {
            (high, at) = (s, i);
        }
    }
    at
}
