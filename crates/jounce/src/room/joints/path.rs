//! A bead on a curve.
//!
//! Curve: centripetal-free (uniform) Catmull–Rom through points P_k in A's joint frame, P(s), tangent T(s) = P′/|P′|. The bead's
//! coordinate is the s at which P is nearest the anchor of B: T·(p_b − P) = 0. Rows along the two normals n of T: with p = P(s) as
//! the anchor on A, C = n·(p_b − P), J = (−n, −(r_p + d) × n, n, r_b × n); that s moves with the bead adds nothing, since n·T = 0.
//! Where it is aligned, the frame F = (T, up, ·) takes the place of A's axes in the rows that stop all turning, C = 2 v_i of F⁻¹ q_b. It turns
//! by Ω ds/dt as the bead moves: J = j·(ω_b − ω_a) − (j·Ω) ds/dt, ds/dt = T·d(p_b − P)/dt. (Without that term the rails did work.)
//!
//! Symbols: s length from the first point, m. Source: Catmull & Rom, A class of local interpolating splines, 1974.

use super::desc::PathDesc;
use super::rows::{Ends, Hard, Row};
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
        let (p, v, _) = self.bent(t);
        (p, v)
    }
    /// The same, and the second derivative.
    fn bent(&self, t: f32) -> (Vec3, Vec3, Vec3) {
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
        let bend = (b - c) * (12.0 * u - 6.0) + m0 * (6.0 * u - 4.0) + m1 * (6.0 * u - 2.0);
        (p, v, bend)
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
    /// Position, tangent and its derivative along the curve, at a length.
    pub fn place(&self, s: f32) -> (Vec3, Vec3, Vec3) {
        let total = self.length();
        let s = if self.closed && total > 0.0 { s - (s / total).floor() * total } else { s };
        let (p, v, bend) = self.bent(self.parameter(s));
        let n = v.length();
        if n <= 0.0 {
            return (p, Vec3::X, Vec3::ZERO);
        }
        let t = v / n;
        (p, t, (bend - t * t.dot(bend)) / (n * n))
    }
}

/// Where a bead is: the frame that slides along the curve with it, in place of A's, and how that turns along the way, rad/m.
pub(crate) struct Slid {
    pub ends: Ends,
    bend: Vec3,
}

/// `s` is the bead's coordinate.
pub(crate) fn slide(curve: &Curve, e: &Ends, s: &mut f32) -> Slid {
    *s = curve.nearest(e.qa.inverse_rotate(e.d), *s);
    let (p, t, dt) = curve.place(*s);
    let lever = e.qa.rotate(p);
    let (q, bend) = frame(t, dt);
    let ends = Ends { ra: e.ra + lever, d: e.d - lever, qa: e.qa * q, ..*e };
    Slid { ends, bend: e.qa.rotate(bend) }
}

/// x along the tangent, y as far up as it can be; and Ω = ½ Σ e_i × e_i′, by which it turns along the way.
fn frame(t: Vec3, dt: Vec3) -> (Quat, Vec3) {
    let up = if t.y.abs() < 0.999 { Vec3::Y } else { Vec3::X };
    let (across, d_across) = (t.cross(up), dt.cross(up));
    let size = across.length();
    if size <= 0.0 {
        return (Quat::IDENTITY, Vec3::ZERO);
    }
    let z = across / size;
    let dz = (d_across - z * z.dot(d_across)) / size;
    let (y, dy) = (z.cross(t), dz.cross(t) + z.cross(dt));
    let q = Quat::from_mat3(&Mat3::from_columns(t, y, z)).normalize();
    (q, (t.cross(dt) + y.cross(dy) + z.cross(dz)) * 0.5)
}

/// Two rows across the curve, and three where it leads the frame too: those turn by Ω ds/dt, and ds/dt is the bead's speed.
pub(crate) fn rows(aligned: bool, slid: &Slid, out: &mut Hard) {
    let e = &slid.ends;
    out.push(e.along(e.axis_a(1)));
    out.push(e.along(e.axis_a(2)));
    if aligned {
        let along = e.along(e.axis_a(0));
        for r in e.no_turn() {
            let part = -r.jb.dot(slid.bend);
            out.push(Row {
                la: along.la * part,
                ja: r.ja + along.ja * part,
                lb: along.lb * part,
                jb: r.jb + along.jb * part,
                c: r.c,
            });
        }
    }
}
