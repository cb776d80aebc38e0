//! Polygons into triangles by cutting ears (Meisters 1975), so that concave faces such as the side of a stair come
//! out right. Corners are projected along the largest component of Newell's normal.

use jounce::math::Vec3;

/// Appends the triangles of a polygon, as numbers of its corners. `budget` bounds the point-in-triangle tests of a
/// whole file: when it is spent, or no ear is left (self-crossing or flat polygons), the rest becomes a fan.
pub(super) fn polygon(corners: &[Vec3], budget: &mut u64, out: &mut Vec<[usize; 3]>) {
    let n = corners.len();
    if n <= 3 {
        if n == 3 {
            out.push([0, 1, 2]);
        }
        return;
    }
    let flat = project(corners);
    let mut rest: Vec<usize> = (0..n).collect();
    let mut start = 0;
    while rest.len() > 3 {
        let ear =
            (0..rest.len()).map(|k| (start + k) % rest.len()).find(|&k| is_ear(&flat, &rest, k, budget));
        let Some(k) = ear else { break };
        let m = rest.len();
        out.push([rest[(k + m - 1) % m], rest[k], rest[(k + 1) % m]]);
        rest.remove(k);
        start = k % rest.len();
    }
    for k in 1..rest.len() - 1 {
        out.push([rest[0], rest[k], rest[k + 1]]);
    }
}

/// Corners in a plane, counter-clockwise.
fn project(corners: &[Vec3]) -> Vec<[f64; 2]> {
    let at = |i: usize| corners[i % corners.len()].as_dvec3() - corners[0].as_dvec3();
    let mut normal = [0.0f64; 3];
    for i in 0..corners.len() {
        let c = at(i).cross(at(i + 1)).to_array();
        (0..3).for_each(|k| normal[k] += c[k]);
    }
    let axis = (0..3).fold(0, |best, k| if normal[k].abs() > normal[best].abs() { k } else { best });
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let flip = if normal[axis] < 0.0 { -1.0 } else { 1.0 };
    (0..corners.len())
        .map(|i| {
            let p = at(i).to_array();
            [p[u], flip * p[v]]
        })
        .collect()
}

fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn is_ear(flat: &[[f64; 2]], rest: &[usize], k: usize, budget: &mut u64) -> bool {
    let m = rest.len();
    let (i, j, l) = (rest[(k + m - 1) % m], rest[k], rest[(k + 1) % m]);
    let (a, b, c) = (flat[i], flat[j], flat[l]);
    if turn(a, b, c) <= 0.0 {
        return false;
    }
    rest.iter().filter(|&&p| p != i && p != j && p != l).all(|&p| {
        if *budget == 0 {
            return true;
        }
        *budget -= 1;
        let x = flat[p];
        // A corner that coincides with one of the ear's corners (a slit) does not block it.
        let same = x == a || x == b || x == c;
        same || turn(a, b, x) < 0.0 || turn(b, c, x) < 0.0 || turn(c, a, x) < 0.0
    })
}
