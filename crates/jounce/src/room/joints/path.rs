//! A bead on a curve.
//!
//! Curve: centripetal-free (uniform) Catmull–Rom through points P_k in A's joint frame, P(s), tangent T(s) = P′/|P′|. The bead's
//! coordinate is the s at which P is nearest the anchor of B: T·(p_b − P) = 0. Rows along the two normals n of T: with p = P(s) as
//! the anchor on A, C = n·(p_b − P), J = (−n, −(r_p + d) × n, n, r_b × n); that s moves with the bead adds nothing, since n·T = 0.
//! Where it is aligned, the frame (T, up, ·) takes the place of A's axes in the rows that stop all turning.
//!
//! Symbols: s length from the first point, m. Source: Catmull & Rom, A class of local interpolating splines, 1974.

use super::desc::PathDesc;
use super::rows::{Ends, Hard};
use jounce_math::{Mat3, Quat, Vec3, scalar::f32s};

/// Pieces a segment of the curve is cut into to measure its length.
const PIECES: usize = 16;

/// A curve with its length measured.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    points: Vec<Vec3>,
    closed: bool,
    /// Length at the start of each piece, and in the end that of all.
    lengths: Vec<f32>,
}

impl Curve {
    pub fn new(desc: &PathDesc) -> Self {
        let mut c = Self { points: desc.points.clone(), closed: desc.closed, lengths: Vec::new() };
        let pieces = c.segments() * PIECES;
        let mut sum = 0.0_f64;
        let mut last = c.at(0.0).0;
        c.lengths.push(0.0);
        for i in 1..=pieces {
            let p = c.at(i as f32 / PIECES as f32).0;
            sum += f64::from((p - last).length());
            c.lengths.push(sum as f32);
            last = p;
        }
        c
    }
    fn segments(&self) -> usize {
        if self.closed { self.points.len() } else { self.points.len() - 1 }
    }
    pub fn length(&self) -> f32 {
        self.lengths.last().copied().unwrap_or(0.0)
    }
    fn point(&self, i: isize) -> Vec3 {
        let n = self.points.len() as isize;
        if self.closed {
            return self.points[i.rem_euclid(n) as usize];
        }
        // Beyond the ends the curve goes on straight.
        if i < 0 {
            return self.points[0] * 2.0 - self.points[1];
        }
        if i >= n {
            return self.points[n as usize - 1] * 2.0 - self.points[n as usize - 2];
        }
        self.points[i as usize]
    }
    /// Position and derivative at a parameter that counts segments.
    fn at(&self, t: f32) -> (Vec3, Vec3) {
        let last = self.segments() as f32;
        let t = f32s::clamp(t, 0.0, last);
        let k = f32s::min(t.floor(), last - 1.0);
        let (u, k) = (t - k, k as isize);
        let [a, b, c, d] = [k - 1, k, k + 1, k + 2].map(|i| self.point(i));
        let (m0, m1) = ((c - a) * 0.5, (d - b) * 0.5);
        let (u2, u3) = (u * u, u * u * u);
        let p = b * (2.0 * u3 - 3.0 * u2 + 1.0)
            + m0 * (u3 - 2.0 * u2 + u)
            + c * (3.0 * u2 - 2.0 * u3)
            + m1 * (u3 - u2);
        let v = (b - c) * (6.0 * (u2 - u)) + m0 * (3.0 * u2 - 4.0 * u + 1.0) + m1 * (3.0 * u2 - 2.0 * u);
        (p, v)
    }
    /// The ends of all pieces.
    pub fn points(&self) -> impl Iterator<Item = Vec3> + '_ {
        (0..self.lengths.len()).map(|i| self.at(i as f32 / PIECES as f32).0)
    }
    /// Parameter at a length.
    fn parameter(&self, s: f32) -> f32 {
        let i = self.lengths.partition_point(|&l| l <= s).clamp(1, self.lengths.len() - 1);
        let (a, b) = (self.lengths[i - 1], self.lengths[i]);
        let part = if b > a { (s - a) / (b - a) } else { 0.0 };
        ((i - 1) as f32 + f32s::clamp(part, 0.0, 1.0)) / PIECES as f32
    }
    fn length_at(&self, t: f32) -> f32 {
        let x = t * PIECES as f32;
        let i = (x.floor() as usize).min(self.lengths.len() - 2);
        self.lengths[i] + (self.lengths[i + 1] - self.lengths[i]) * (x - i as f32)
    }
    /// Length at the nearest point, sought from a length (turns around a closed curve are counted). Newton's method on
    /// T·(x − P) = 0 with the derivative −|P′|², a few rounds: the bead moves little in a substep.
    pub fn nearest(&self, x: Vec3, from: f32) -> f32 {
        let total = self.length();
        let (turns, from) = if self.closed && total > 0.0 {
            let k = (from / total).floor();
            (k, from - k * total)
        } else {
            (0.0, from)
        };
        let n = self.segments() as f32;
        let mut t = self.parameter(from);
        let mut whole = turns;
        for _ in 0..4 {
            let (p, v) = self.at(t);
            let v2 = v.length_squared();
            if v2 <= 0.0 {
                break;
            }
            t += f32s::clamp(v.dot(x - p) / v2, -0.5, 0.5);
            if self.closed && t < 0.0 {
                (t, whole) = (t + n, whole - 1.0);
            } else if self.closed && t >= n {
                (t, whole) = (t - n, whole + 1.0);
            }
            t = f32s::clamp(t, 0.0, n);
        }
        whole * total + self.length_at(t)
    }
    /// The nearest of all points, for the first time.
    pub fn first(&self, x: Vec3) -> f32 {
        let mut best = (f32::MAX, 0.0);
        for i in 0..self.lengths.len() {
            let d = (self.at(i as f32 / PIECES as f32).0 - x).length_squared();
            if d < best.0 {
                best = (d, self.lengths[i]);
            }
        }
        self.nearest(x, best.1)
    }
    /// Position and tangent at a length.
    pub fn place(&self, s: f32) -> (Vec3, Vec3) {
        let total = self.length();
        let s = if self.closed && total > 0.0 { s - (s / total).floor() * total } else { s };
        let (p, v) = self.at(self.parameter(s));
        let n = v.length();
        (p, if n > 0.0 { v / n } else { Vec3::X })
    }
}

/// The frame that slides along the curve with the bead, in place of A's: `s` is its coordinate.
pub(crate) fn slide(curve: &Curve, e: &Ends, s: &mut f32) -> Ends {
    *s = curve.nearest(e.qa.inverse_rotate(e.d), *s);
    let (p, t) = curve.place(*s);
    let lever = e.qa.rotate(p);
    let q = frame(t);
    Ends { ra: e.ra + lever, d: e.d - lever, qa: e.qa * q, ..*e }
}

/// x along the tangent, y as far up as it can be.
fn frame(t: Vec3) -> Quat {
    let up = if t.y.abs() < 0.999 { Vec3::Y } else { Vec3::X };
    let z = t.cross(up).normalize_or(Vec3::Z);
    Quat::from_mat3(&Mat3::from_columns(t, z.cross(t), z)).normalize()
}

/// Two rows across the curve, and three where it leads the frame too.
pub(crate) fn rows(aligned: bool, slid: &Ends, out: &mut Hard) {
    out.push(slid.along(slid.axis_a(1)));
    out.push(slid.along(slid.axis_a(2)));
    if aligned {
        slid.no_turn().into_iter().for_each(|r| out.push(r));
    }
}
