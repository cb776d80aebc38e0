//! The elementary rows that all joints are made of.
//!
//! Symbols: p_a, p_b anchors; d = p_b − p_a; r_a, r_b levers from the centres of mass; q_a, q_b rotations of the joint frames;
//! x, y, z their axes; u = (v_a, ω_a, v_b, ω_b). A row is J u with the error C, dC/dt = J u exactly:
//!
//! * along n, fixed in A: C = n·d, J = (−n, −(r_a + d) × n, n, r_b × n);
//! * x_b stays across y_a: C = y_a·x_b, J = (0, −j, 0, j), j = x_b × y_a;
//! * swing about y or z: Σ = θ n, n = x_a × x_b/sin θ, the rotation vector from x_a to x_b; C = e·Σ, and with t = n × x_a
//!   j = (e·n) n − (e·t) (θ/sin θ) x_b × n;
//! * no turn: q = q_a⁻¹ q_b = (v, w), C = 2 v_i, j = q_a (w e_i + v × e_i);
//! * twist about x: C = 2 atan2(v_x, w), j = (x_a + x_b) / (1 + x_a·x_b);
//!   where the two x may come to point apart: C = m + f (φ − m), f from 1 at a swing of 150° to 0 at 180°, with s = 1 + x_a·x_b,
//!   j = f j_φ + (φ − m) f′(s) x_b × x_a: φ turns ever faster there, and has no value at last;
//! * cone: C = angle of x_a and x_b, j = x_a × x_b / |x_a × x_b|.

use super::ball::TORN;
use super::state::Joint;
use crate::room::rigid::solve::turn;
use crate::room::rigid::state::{BodyFrame, Motion};
use jounce_math::{Quat, Vec3, scalar::f32s};

/// One row: directions for both bodies, and how far it is from where it should be (m or rad).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Row {
    pub la: Vec3,
    pub ja: Vec3,
    pub lb: Vec3,
    pub jb: Vec3,
    pub c: f32,
}

impl Row {
    /// J u.
    #[inline(always)]
    pub fn speed(&self, a: &Motion, b: &Motion) -> f32 {
        self.la.dot(a.v) + self.ja.dot(a.w) + self.lb.dot(b.v) + self.jb.dot(b.w)
    }
    fn turn(j: Vec3, c: f32) -> Self {
        Self { la: Vec3::ZERO, ja: -j, lb: Vec3::ZERO, jb: j, c }
    }
}

/// What does not change within a step: frames as they stood at its start, world axes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Start {
    /// Anchors from the centres of mass.
    pub ra: Vec3,
    pub rb: Vec3,
    pub qa: Quat,
    pub qb: Quat,
    /// From A's centre of mass to B's.
    pub offset: Vec3,
}

impl Start {
    pub fn new(j: &Joint, a: &BodyFrame, b: &BodyFrame) -> Self {
        Self {
            ra: a.rotation.rotate(j.frame_a.p - a.local_center),
            rb: b.rotation.rotate(j.frame_b.p - b.local_center),
            qa: a.rotation * j.frame_a.q,
            qb: b.rotation * j.frame_b.q,
            offset: (b.center - a.center).as_vec3(),
        }
    }
}

/// The two frames at some time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ends {
    pub ra: Vec3,
    pub rb: Vec3,
    pub qa: Quat,
    pub qb: Quat,
    pub d: Vec3,
    /// The anchors are too far apart to be pulled at one point.
    pub torn: bool,
}

impl Ends {
    #[inline(always)]
    pub fn now(s: &Start, a: &Motion, b: &Motion) -> Self {
        Self::at(s, a.dp, a.dq, b.dp, b.dq)
    }
    /// Where free motion with these velocities would take them in `h` seconds.
    #[inline(always)]
    pub fn predicted(s: &Start, a: &Motion, b: &Motion, h: f32) -> Self {
        let qa = turned(a.w * h) * a.dq;
        let qb = turned(b.w * h) * b.dq;
        Self::at(s, a.dp + a.v * h, qa, b.dp + b.v * h, qb)
    }
    #[inline(always)]
    fn at(s: &Start, pa: Vec3, qa: Quat, pb: Vec3, qb: Quat) -> Self {
        let (ra, rb) = (qa.rotate(s.ra), qb.rotate(s.rb));
        let d = s.offset + (pb - pa) + (rb - ra);
        Self { ra, rb, qa: qa * s.qa, qb: qb * s.qb, d, torn: d.length_squared() > TORN * TORN }
    }
    /// Rotation of B's frame in A's, the shorter way.
    #[inline(always)]
    pub fn relative(&self) -> Quat {
        let q = self.qa.inverse_mul(self.qb).normalize();
        if q.w < 0.0 { Quat::new(-q.x, -q.y, -q.z, -q.w) } else { q }
    }
    pub fn axis_a(&self, i: usize) -> Vec3 {
        self.qa.rotate(unit(i))
    }
    pub fn axis_b(&self, i: usize) -> Vec3 {
        self.qb.rotate(unit(i))
    }

    /// Along a unit vector that turns with A.
    #[inline(always)]
    pub fn along(&self, n: Vec3) -> Row {
        Row { la: -n, ja: -(self.ra + self.d).cross(n), lb: n, jb: self.rb.cross(n), c: n.dot(self.d) }
    }
    /// Along the line of the anchors; C is their distance.
    pub fn distance(&self) -> Row {
        let length = self.d.length();
        let n = if length > 1e-9 { self.d / length } else { Vec3::Y };
        Row { la: -n, ja: -self.ra.cross(n), lb: n, jb: self.rb.cross(n), c: length }
    }
    /// Speed of the anchors against each other along a direction of the world.
    pub fn beside(&self, t: Vec3) -> Row {
        Row { la: -t, ja: -self.ra.cross(t), lb: t, jb: self.rb.cross(t), c: 0.0 }
    }
    /// The three rows that stop all turning.
    #[inline(always)]
    pub fn no_turn(&self) -> [Row; 3] {
        let q = self.relative();
        let v = q.xyz();
        [0, 1, 2].map(|i| Row::turn(self.qa.rotate(unit(i) * q.w + v.cross(unit(i))), 2.0 * v[i]))
    }
    /// B's axis `axis` across A's axis `i`.
    #[inline(always)]
    pub fn across(&self, axis: usize, i: usize) -> Row {
        let (x, n) = (self.axis_b(axis), self.axis_a(i));
        Row::turn(x.cross(n), n.dot(x))
    }
    /// Twist of B against A about x, within ±π.
    #[inline(always)]
    pub fn twist(&self) -> Row {
        self.twist_about(0)
    }
    /// The same about another axis.
    #[inline(always)]
    pub fn twist_about(&self, axis: usize) -> Row {
        let q = self.relative();
        let (xa, xb) = (self.axis_a(axis), self.axis_b(axis));
        let s = 1.0 + xa.dot(xb);
        let j = if s > 1e-2 { (xa + xb) / s } else { xa };
        Row::turn(j, 2.0 * f32s::atan2(q.xyz()[axis], q.w))
    }
    /// The twist about `middle`, which fades out where the two x axes come to point apart.
    pub fn fading_twist(&self, middle: f32) -> Row {
        let row = self.twist();
        let (xa, xb) = (self.axis_a(0), self.axis_b(0));
        let s = 1.0 + xa.dot(xb);
        if s >= FADES {
            return row;
        }
        // Its own direction, without bound, as f falls faster than it grows.
        let j = if s > 1e-6 { (xa + xb) / s } else { Vec3::ZERO };
        let part = f32s::max(s / FADES, 0.0);
        let (f, slope) = (part * part * (3.0 - 2.0 * part), 6.0 * part * (1.0 - part) / FADES);
        let half = core::f32::consts::PI;
        let from = row.c - middle;
        let from = from - 2.0 * half * (from / (2.0 * half)).round();
        Row::turn(j * f + xb.cross(xa) * (from * slope), middle + f * from)
    }
    /// Do the x axes point apart so far that their twist is about to have no value?
    pub fn points_back(&self) -> bool {
        1.0 + self.axis_a(0).dot(self.axis_b(0)) < FADES
    }
    /// Swing about A's y (1) or z (2): that part of the rotation vector Σ that takes x_a to x_b the shorter way.
    pub fn swing(&self, i: usize) -> Row {
        let (xa, xb, e) = (self.axis_a(0), self.axis_b(0), self.axis_a(i));
        let across = xa.cross(xb);
        let s = across.length();
        if s < 1e-6 {
            return Row::turn(e, 0.0);
        }
        let (n, angle) = (across / s, f32s::atan2(s, xa.dot(xb)));
        let t = n.cross(xa);
        // Where they point apart, the way around has no end.
        let stretch = f32s::min(angle / s, STRETCHED);
        Row::turn(n * e.dot(n) - xb.cross(n) * (e.dot(t) * stretch), angle * e.dot(n))
    }
    /// Angle of the two x axes.
    pub fn cone(&self) -> Row {
        let (xa, xb) = (self.axis_a(0), self.axis_b(0));
        let n = xa.cross(xb);
        let s = n.length();
        let j = if s > 1e-6 { n / s } else { self.axis_a(1) };
        Row::turn(j, f32s::atan2(s, xa.dot(xb)))
    }
    /// Turn about A's axis `i` only as a direction: for motors that ask for a velocity, and friction.
    pub fn about(&self, i: usize) -> Row {
        Row::turn(self.axis_a(i), 0.0)
    }
    /// The rotation vector that is left from `wanted` (B's frame in A's), as rows about A's axes.
    pub fn turn_from(&self, wanted: Quat) -> [Row; 3] {
        let q = self.qa.inverse_mul(self.qb) * wanted.conjugate();
        let q = if q.w < 0.0 { Quat::new(-q.x, -q.y, -q.z, -q.w) } else { q };
        let v = q.xyz();
        let s = v.length();
        let k = if s > 1e-6 { 2.0 * f32s::atan2(s, q.w) / s } else { 2.0 };
        [0, 1, 2].map(|i| Row::turn(self.axis_a(i), v[i] * k))
    }
}

/// θ/sin θ at most: at some 160°.
const STRETCHED: f32 = 8.0;
/// 1 + x_a·x_b from which a twist fades: a swing of 150°.
const FADES: f32 = 0.134;

/// The turn by a rotation vector, right at any angle.
#[inline(always)]
pub(super) fn turned(r: Vec3) -> Quat {
    if r.length_squared() > 1.0 {
        let angle = r.length();
        return if angle < 1e6 { Quat::from_axis_angle(r / angle, angle) } else { Quat::IDENTITY };
    }
    turn(r)
}

#[inline(always)]
pub(crate) fn unit(i: usize) -> Vec3 {
    [Vec3::X, Vec3::Y, Vec3::Z][i]
}

/// Rows that hold, at most six.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hard {
    pub rows: [Row; 6],
    pub n: usize,
}

impl Hard {
    #[inline(always)]
    pub fn push(&mut self, row: Row) {
        if let Some(slot) = self.rows.get_mut(self.n) {
            *slot = row;
            self.n += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// dC/dt = J u, where the twist is whole, fades and is nearly gone.
    #[test]
    fn a_fading_twist_is_the_integral_of_its_row() {
        let ends = |qb: Quat| Ends {
            ra: Vec3::ZERO,
            rb: Vec3::ZERO,
            qa: Quat::IDENTITY,
            qb,
            d: Vec3::ZERO,
            torn: false,
        };
        let about = |axis: Vec3, degrees: f32| Quat::from_axis_angle(axis, degrees.to_radians());
        let across = Vec3::new(0.0, 0.6, 0.8);
        for (swing, twist) in [(100.0, 20.0), (152.0, 35.0), (160.0, -50.0), (168.0, 25.0), (175.0, 10.0)] {
            let q = about(across, swing) * about(Vec3::X, twist);
            let row = ends(q).fading_twist(0.1);
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                let c = |degrees: f32| ends((about(axis, degrees) * q).normalize()).fading_twist(0.1).c;
                let slope = (c(0.1) - c(-0.1)) / 0.2_f32.to_radians();
                let told = row.jb.dot(axis);
                assert!((slope - told).abs() < 0.02, "{swing}°, {twist}°, {axis:?}: {slope} for {told}");
            }
        }
    }
}
