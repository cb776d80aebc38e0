//! Questions about one triangle.

use jounce_math::Vec3;

/// A ray made ready for many triangles: the frame is sheared so that the ray runs along +z from the origin
/// (Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection"). The edge functions of two triangles
/// that share an edge are exact negatives, so no ray slips through between them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleRay {
    origin: Vec3,
    kx: usize,
    ky: usize,
    kz: usize,
    sx: f32,
    sy: f32,
    sz: f32,
}

impl TriangleRay {
    pub fn new(origin: Vec3, dir: Vec3) -> Self {
        let kz = dir.abs().max_axis();
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let sz = 1.0 / dir[kz];
        Self { origin, kx, ky, kz, sx: dir[kx] * sz, sy: dir[ky] * sz, sz }
    }

    /// Ray parameter of the hit, either side, edges included; negative ones too.
    #[inline]
    pub fn hit(&self, t: &[Vec3; 3]) -> Option<f32> {
        let (a, b, c) = (t[0] - self.origin, t[1] - self.origin, t[2] - self.origin);
        let (ax, ay) = (a[self.kx] - self.sx * a[self.kz], a[self.ky] - self.sy * a[self.kz]);
        let (bx, by) = (b[self.kx] - self.sx * b[self.kz], b[self.ky] - self.sy * b[self.kz]);
        let (cx, cy) = (c[self.kx] - self.sx * c[self.kz], c[self.ky] - self.sy * c[self.kz]);
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let t = (u * a[self.kz] + v * b[self.kz] + w * c[self.kz]) * self.sz / det;
        t.is_finite().then_some(t)
    }
}

/// Point of the triangle nearest to `p`, by the Voronoi region `p` lies in (Ericson 2005, "Real-Time
/// Collision Detection", §5.1.5).
pub fn closest_point(t: &[Vec3; 3], p: Vec3) -> Vec3 {
    let [a, b, c] = *t;
    let (ab, ac) = (b - a, c - a);
    let ap = p - a;
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    let (e, f) = (d4 - d3, d5 - d6);
    if va <= 0.0 && e >= 0.0 && f >= 0.0 && e + f > 0.0 {
        return b + (c - b) * (e / (e + f));
    }
    let sum = va + vb + vc;
    if sum <= 0.0 {
        // Rounding of a sliver left no region: its corners are as near as anything.
        return [b, c].into_iter().fold(a, |q, r| if (r - p).length() < (q - p).length() { r } else { q });
    }
    a + ab * (vb / sum) + ac * (vc / sum)
}
