//! Triangles of a hull into planar faces.
//!
//! A face grows from its largest triangle, whose plane (it supports the whole hull: every vertex is behind it) becomes
//! the face's plane, over the neighbours that lie within the tolerance behind it. Depth behind a supporting plane is
//! a convex function over the hull's front, so such a region has no holes. A region whose outline is not one convex loop
//! (patches of neighbours can bite into each other where a surface curves by about the tolerance) is tried again
//! with less tolerance, at last as the triangle alone.

use super::quickhull::QuickHull;
use jounce_math::{DVec3, scalar::f64s};

const NONE: u32 = u32::MAX;

/// A face: its supporting triangle and its corners, counter-clockwise from outside.
pub(super) struct Outline {
    pub seed: u32,
    pub corners: Vec<u32>,
}

/// Merges within `tolerance` (grid steps). `None` where the outlines do not fit together.
pub(super) fn merge(hull: &QuickHull, tolerance: f64) -> Option<Vec<Outline>> {
    let mut owner = vec![NONE; hull.faces.len()];
    let mut order: Vec<u32> =
        (0..hull.faces.len() as u32).filter(|&f| hull.faces[f as usize].alive).collect();
    let area =
        |f: u32| -> i128 { hull.faces[f as usize].n.iter().map(|&c| i128::from(c) * i128::from(c)).sum() };
    order.sort_by_cached_key(|&f| (core::cmp::Reverse(area(f)), f));
    let mut outlines = Vec::new();
    for &seed in &order {
        if owner[seed as usize] != NONE {
            continue;
        }
        let me = outlines.len() as u32;
        // 0.5 of a grid step is exactly flat up to rounding of the unit normal.
        let levels = [tolerance, tolerance / 16.0, 0.5, -1.0];
        let found = levels.into_iter().find_map(|level| {
            let region = grow(hull, seed, level, &owner);
            Some((outline(hull, seed, &region, tolerance)?, region))
        });
        let (corners, region) = found?;
        for f in region {
            owner[f as usize] = me;
        }
        outlines.push(Outline { seed, corners });
    }
    drop_straight_corners(hull, &mut outlines, tolerance).then_some(outlines)
}

/// Triangles reachable from the seed within `level` behind its plane.
fn grow(hull: &QuickHull, seed: u32, level: f64, owner: &[u32]) -> Vec<u32> {
    let mut region = vec![seed];
    if level < 0.0 {
        return region;
    }
    let s = &hull.faces[seed as usize];
    let mut k = 0;
    while let Some(&f) = region.get(k) {
        k += 1;
        for g in hull.faces[f as usize].adj {
            let face = &hull.faces[g as usize];
            if owner[g as usize] == NONE
                && !region.contains(&g)
                && face.unit.dot(s.unit) > 0.0
                && face.v.iter().all(|&v| hull.depth(s, v) <= level)
            {
                region.push(g);
            }
        }
    }
    region
}

/// The loop around a region, if it is one loop through different vertices, and convex to within `tolerance`.
fn outline(hull: &QuickHull, seed: u32, region: &[u32], tolerance: f64) -> Option<Vec<u32>> {
    let mut edges = Vec::new();
    for &f in region {
        let face = &hull.faces[f as usize];
        for k in 0..3 {
            if !region.contains(&face.adj[k]) {
                edges.push((face.v[k], face.v[(k + 1) % 3]));
            }
        }
    }
    let mut corners = Vec::with_capacity(edges.len());
    let start = edges.first()?.0;
    let mut at = start;
    loop {
        let mut from = edges.iter().filter(|e| e.0 == at);
        let next = from.next()?.1;
        if from.next().is_some() {
            return None;
        }
        corners.push(at);
        at = next;
        if at == start {
            break;
        }
        if corners.len() > edges.len() {
            return None;
        }
    }
    if corners.len() != edges.len() {
        return None;
    }
    // A lone triangle needs no test, and a sliver would fail it.
    (region.len() == 1 || is_convex(hull, seed, &corners, tolerance)).then_some(corners)
}

/// No corner further than `tolerance` to the right of the line through any edge.
fn is_convex(hull: &QuickHull, seed: u32, corners: &[u32], tolerance: f64) -> bool {
    let n = hull.faces[seed as usize].unit;
    let p: Vec<DVec3> = corners.iter().map(|&c| hull.point(c)).collect();
    (0..p.len()).all(|k| {
        let (a, b) = (p[k], p[(k + 1) % p.len()]);
        let Some((inward, length)) = n.cross(b - a).try_normalize() else { return false };
        // The direction of an edge shorter than the tolerance means nothing.
        length <= tolerance || p.iter().all(|&q| inward.dot(q - a) >= -tolerance)
    })
}

/// Removes corners that only two faces share: they should lie on a straight edge. False where one does not (two
/// faces of a body about as thin as the tolerance that meet along a curved rim), or where no face is left.
fn drop_straight_corners(hull: &QuickHull, outlines: &mut [Outline], tolerance: f64) -> bool {
    let most = outlines.iter().flat_map(|o| o.corners.iter()).max().map_or(0, |&m| m as usize + 1);
    let mut faces = vec![0u32; most];
    for &c in outlines.iter().flat_map(|o| o.corners.iter()) {
        faces[c as usize] += 1;
    }
    outlines.iter_mut().all(|o| {
        let old = core::mem::take(&mut o.corners);
        o.corners = old.iter().copied().filter(|&c| faces[c as usize] > 2).collect();
        o.corners.len() >= 3 && is_straight(hull, &old, &faces, tolerance)
    })
}

/// Do the dropped corners lie within the tolerance of the lines between the kept ones?
fn is_straight(hull: &QuickHull, old: &[u32], faces: &[u32], tolerance: f64) -> bool {
    let kept = |c: u32| faces[c as usize] > 2;
    let Some(start) = old.iter().position(|&c| kept(c)) else { return false };
    let n = old.len();
    let mut from = old[start];
    let mut between = Vec::new();
    for k in 1..=n {
        let c = old[(start + k) % n];
        if !kept(c) {
            between.push(c);
            continue;
        }
        let (a, ab) = (hull.point(from), hull.point(c) - hull.point(from));
        for q in between.drain(..).map(|q| hull.point(q) - a) {
            let s = f64s::clamp(q.dot(ab) / ab.length_squared(), 0.0, 1.0);
            if (q - ab * s).length() > tolerance {
                return false;
            }
        }
        from = c;
    }
    true
}
