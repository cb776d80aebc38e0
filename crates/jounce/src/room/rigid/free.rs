//! Torque-free turns of bodies with unequal moments.
//!
//! The angular momentum L is constant in the world, so in body axes ℓ = Rᵀ L turns with −ω, ω = I⁻¹ ℓ. With principal moments
//! Iᵢ and the middle one I_m the energy is
//!
//! |ℓ|²/2I_m + Σ ½ (1/Iᵢ − 1/I_m) ℓᵢ²   over the other two axes i.
//!
//! The first part turns the body about the fixed L by |ℓ| h/I_m and leaves ℓ; the others turn ℓ and the body about axis i by
//! φ = ℓᵢ h (1/Iᵢ − 1/I_m). All exactly, and the first commutes with the others: only the order of those two matters, and
//! symmetric composition (½ of i, k, ½ of i) makes it second order, symplectic, with |ℓ| kept by construction. A body with two
//! equal moments, however slender, turns exactly. (Splitting into three axes, Touma & Wisdom 1994 and Dullweber, Leimkuhler &
//! McLachlan 1997, errs by h² I_across/I_along: a rod of 1:50 lost its energy.)
//!
//! Impulses are momentum. Contacts, forces and fields change ω through the inverse inertia that is frozen within the step,
//! I₀⁻¹. A slender body turns away from it: read as a change of ω, a twist about what was its axis would be a throw across
//! it by now, with hundreds of times the energy. So what is taken over from them is ΔL = I₀ Δω, and ω follows from L.
//!
//! The usual implicit gyroscopic step loses |L|; this one does not. Rotations are rational: with t ≈ tan(φ/2) the
//! quaternion (t, 1)/√(1+t²) turns by 2 atan t; t = x(15 − x²)/(15 − 6x²), x = φ/2, is the [3/2] Padé form
//! of tan, so the phase error is of order x⁷ and no transcendental is needed.
//!
//! All of this is in `f64`: rounding to `f32` would leak momentum. Bodies turn several abreast ([`Doubles`]), each in a lane.

use super::state::{BodyState, BodyStep, Mass, Motion, Turning};
use jounce_lanes::{Array, Doubles, Kernel, Lanes, Mask};
use jounce_math::{DQuat, DVec3, Quat};

/// Below this spin (rad/s, squared) the gyroscopic turn is below f32 resolution over a substep.
pub(crate) const SPIN_MIN_SQUARED: f32 = 1e-10;

/// What a turn asks of a body, frozen within a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Top {
    /// Principal moments, and what damping leaves of the momentum.
    moments: [f64; 4],
}

impl Top {
    pub const NOTHING: Self = Self { moments: [1.0; 4] };
    pub fn new(b: &BodyStep, mass: &Mass, h: f32) -> Self {
        let damping = h * b.angular_damping;
        let keep = if damping == 0.0 { 1.0 } else { 1.0 / (1.0 + f64::from(damping)) };
        let m = mass.moments;
        Self { moments: [m.x, m.y, m.z, keep] }
    }
}

/// World from principal axes.
pub(super) fn principal_axes(rotation: Quat, mass: &Mass) -> DQuat {
    (rotation.as_dquat() * mass.principal).normalize()
}

/// The memory of a body whose rotation and momentum are known by the rounded ones alone.
fn start(s: &Motion, mass: &Mass, rotation: Quat) -> Turning {
    let frozen = principal_axes(rotation, mass);
    let q = (s.dq.as_dquat() * frozen).normalize();
    let momentum = q.rotate(q.inverse_rotate(s.w.as_dvec3()).mul(mass.moments));
    Turning { momentum, w: s.w, q, rotation, dq: s.dq, frozen }
}

/// Takes over a change of ω that came through the inertia of the moment, not the frozen one.
pub(crate) fn absorb(s: &Motion, memory: &mut Option<Turning>, mass: &Mass, rotation: Quat) {
    if let Some(t) = memory
        && t.rotation == rotation
        && t.dq == s.dq
        && t.w != s.w
    {
        let change = t.q.inverse_rotate(s.w.as_dvec3() - t.w.as_dvec3()).mul(mass.moments);
        t.momentum += t.q.rotate(change);
        t.w = s.w;
    }
}

/// After the last substep: impulses that came since its turn become momentum, and ω follows.
pub(crate) fn settle(s: &mut Motion, memory: &mut Option<Turning>, mass: &Mass, rotation: Quat) {
    if let Some(t) = memory
        && t.rotation == rotation
        && t.dq == s.dq
        && t.w != s.w
    {
        let change = t.frozen.inverse_rotate(s.w.as_dvec3() - t.w.as_dvec3()).mul(mass.moments);
        t.momentum += t.frozen.rotate(change);
        s.w = t.q.rotate(t.q.inverse_rotate(t.momentum).mul(mass.inv_moments)).as_vec3();
        t.w = s.w;
    }
}

/// Forgets what belongs to another rotation than the body's.
pub(crate) fn check(memory: &mut Option<Turning>, rotation: Quat) {
    if memory.as_ref().is_some_and(|t| t.rotation != rotation) {
        *memory = None;
    }
}

/// Remembers what the next turn needs, if nothing else turned the body since the last.
#[inline(always)]
pub(crate) fn remember<'a>(
    s: &BodyState,
    memory: &mut Option<Turning>,
    of: impl FnOnce() -> (&'a Mass, Quat),
) {
    if memory.as_ref().is_none_or(|t| !t.is_of(s)) {
        let (mass, rotation) = of();
        *memory = Some(start(&s.get(), mass, rotation));
    }
}

/// Turns of some bodies of a chunk. Their memories are those of their rotations.
pub(crate) struct Turns<'a> {
    pub states: &'a mut [BodyState],
    pub turning: &'a mut [Option<Turning>],
    pub tops: &'a [Top],
    /// Which of them turn.
    pub rows: &'a [u8],
    /// Fastest spin of each of `rows`, rad/s.
    pub spin_most: &'a [f32],
    pub h: f32,
}

impl Kernel for Turns<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let mut at = 0;
        while at < self.rows.len() {
            self.turn::<L::Doubles>(at);
            at += L::Doubles::WIDTH;
        }
    }
}

impl Turns<'_> {
    /// Turns one after another, where lanes are of no use.
    pub fn alone(self) {
        self.run::<Array<1>>();
    }

    /// The row of a lane; one that stands for nobody repeats the first.
    #[inline(always)]
    fn row(&self, at: usize) -> usize {
        usize::from(*self.rows.get(at).unwrap_or(&self.rows[0]))
    }
    #[inline(always)]
    fn memory(&self, at: usize) -> &Turning {
        self.turning[self.row(at)].as_ref().unwrap_or(&Turning::NOTHING)
    }

    /// Turns the rows from `at`.
    #[inline(always)]
    fn turn<D: Doubles>(&mut self, at: usize) {
        let q = Turn(D::gather4(
            #[inline(always)]
            |lane| self.memory(at + lane).q.to_array(),
        ));
        let frozen = Turn(D::gather4(
            #[inline(always)]
            |lane| self.memory(at + lane).frozen.to_array(),
        ));
        let [lx, ly, lz, most] = D::gather4(
            #[inline(always)]
            |lane| {
                let most = self.spin_most.get(at + lane).unwrap_or(&self.spin_most[0]);
                let l = self.memory(at + lane).momentum;
                [l.x, l.y, l.z, f64::from(*most)]
            },
        );
        let [dx, dy, dz, _] = D::gather4(
            #[inline(always)]
            |lane| {
                let w = self.states[self.row(at + lane)].w();
                let change = w.as_dvec3() - self.memory(at + lane).w.as_dvec3();
                [change.x, change.y, change.z, 0.0]
            },
        );
        let [mx, my, mz, keep] = D::gather4(
            #[inline(always)]
            |lane| self.tops[self.row(at + lane)].moments,
        );
        let body = Body { moments: [mx, my, mz], keep, most };
        let (world, q, before, w) = turn(&body, [lx, ly, lz], [dx, dy, dz], q, frozen, self.h);
        let half = D::splat(0.5 * f64::from(self.h));
        let way = scale(add(before, w), half);
        let dq = q.after(frozen.back());
        let Self { states, turning, rows, .. } = self;
        let rows = &rows[at..];
        let zero = D::zero();
        D::scatter4(
            [w[0], w[1], w[2], zero],
            #[inline(always)]
            |lane, row| {
                if let Some(&i) = rows.get(lane) {
                    for k in 0..3 {
                        states[usize::from(i)].hot[3 + k] = row[k] as f32;
                    }
                }
            },
        );
        D::scatter4(
            [way[0], way[1], way[2], zero],
            #[inline(always)]
            |lane, row| {
                if let Some(&i) = rows.get(lane) {
                    for k in 0..3 {
                        states[usize::from(i)].motion[1 + k] += row[k] as f32;
                    }
                }
            },
        );
        D::scatter4(
            dq.0,
            #[inline(always)]
            |lane, row| {
                if let Some(&i) = rows.get(lane) {
                    for k in 0..4 {
                        states[usize::from(i)].motion[4 + k] = row[k] as f32;
                    }
                }
            },
        );
        D::scatter4(
            q.0,
            #[inline(always)]
            |lane, row| {
                if let Some(&i) = rows.get(lane)
                    && let Some(t) = &mut turning[usize::from(i)]
                {
                    t.q = DQuat::from_array(row);
                    let m = states[usize::from(i)].get();
                    (t.w, t.dq) = (m.w, m.dq);
                }
            },
        );
        D::scatter4(
            [world[0], world[1], world[2], zero],
            #[inline(always)]
            |lane, row| {
                if let Some(&i) = rows.get(lane)
                    && let Some(t) = &mut turning[usize::from(i)]
                {
                    t.momentum = DVec3::new(row[0], row[1], row[2]);
                }
            },
        );
    }
}

/// Constants of the body in each lane.
struct Body<D> {
    moments: [D; 3],
    /// What damping leaves of the momentum.
    keep: D,
    /// Fastest spin, rad/s.
    most: D,
}

/// One turn: momentum, rotation of the principal axes, and the angular velocities before and after, world axes. `l` is the momentum that the
/// last turn left, `change` what came to ω since.
#[inline(always)]
fn turn<D: Doubles>(
    body: &Body<D>,
    l: [D; 3],
    change: [D; 3],
    q: Turn<D>,
    frozen: Turn<D>,
    h: f32,
) -> ([D; 3], Turn<D>, [D; 3], [D; 3]) {
    let one = D::splat(1.0);
    let m = body.moments;
    let inv = [one / m[0], one / m[1], one / m[2]];
    let gain = frozen.rotate(times(frozen.back().rotate(change), m));
    let mut world = scale(add(l, gain), body.keep);
    let mut l = q.back().rotate(world);
    let w = times(l, inv);
    let w2 = dot(w, w);
    let mut before = q.rotate(w);
    let over = w2.gt(body.most * body.most);
    if over.any() {
        let less = D::select(over, body.most / w2.sqrt(), one);
        (world, l, before) = (scale(world, less), scale(l, less), scale(before, less));
    }
    let h = f64::from(h);
    let axes = Axes::of(m);
    let [ii, ik, im] = axes.turned(inv);
    let (di, dk) = (ii - im, ik - im);
    let mut l = axes.turned(l);
    let mut q = Turn(axes.turned4(q.0));
    // With two equal moments there is one turn about an axis of the body, and it is exact.
    let unequal = (!di.eq(D::zero())).any();
    if unequal {
        turn_about::<D, 0>(&mut l, &mut q, di, D::splat(0.5 * h));
    }
    turn_about::<D, 1>(&mut l, &mut q, dk, D::splat(h));
    if unequal {
        turn_about::<D, 0>(&mut l, &mut q, di, D::splat(0.5 * h));
    }
    let q = Turn(axes.back(q.0));
    let q = turn_by(scale(world, D::splat(h) * im)).after(q).normalize();
    let w = q.rotate(times(q.back().rotate(world), inv));
    (world, q, before, w)
}

#[inline(always)]
fn between<D: Doubles>(a: D, b: D, c: D) -> D::Mask {
    (b.le(a) & a.le(c)) | (a.lt(b) & c.lt(a))
}

/// Which axis has the middle moment, in each lane: neither the first nor the second nor the third.
struct Axes<D: Doubles> {
    first: D::Mask,
    second: D::Mask,
}

impl<D: Doubles> Axes<D> {
    /// Of two equal moments one is the middle one, and the other comes first of those that follow it.
    #[inline(always)]
    fn of([x, y, z]: [D; 3]) -> Self {
        let (xy, yz, zx) = (x.eq(y), y.eq(z), z.eq(x));
        let first = xy | (!yz & !zx & between(x, y, z));
        Self { first, second: !first & (yz | (!zx & between(y, x, z))) }
    }
    /// The two axes that follow the middle one, and it.
    #[inline(always)]
    fn turned(&self, [x, y, z]: [D; 3]) -> [D; 3] {
        [self.pick(y, z, x), self.pick(z, x, y), self.pick(x, y, z)]
    }
    #[inline(always)]
    fn turned4(&self, [x, y, z, w]: [D; 4]) -> [D; 4] {
        let [i, k, m] = self.turned([x, y, z]);
        [i, k, m, w]
    }
    /// The reverse of [`Self::turned4`].
    #[inline(always)]
    fn back(&self, [i, k, m, w]: [D; 4]) -> [D; 4] {
        [self.pick(m, k, i), self.pick(i, m, k), self.pick(k, i, m), w]
    }
    #[inline(always)]
    fn pick(&self, first: D, second: D, third: D) -> D {
        D::select(self.first, first, D::select(self.second, second, third))
    }
}

#[inline(always)]
fn add<D: Doubles>(a: [D; 3], b: [D; 3]) -> [D; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
#[inline(always)]
fn times<D: Doubles>(a: [D; 3], b: [D; 3]) -> [D; 3] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}
#[inline(always)]
fn scale<D: Doubles>(a: [D; 3], k: D) -> [D; 3] {
    times(a, [k; 3])
}
#[inline(always)]
fn dot<D: Doubles>(a: [D; 3], b: [D; 3]) -> D {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
#[inline(always)]
fn cross<D: Doubles>(a: [D; 3], b: [D; 3]) -> [D; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A rotation per lane, x, y, z, w, in the order of operations of `DQuat`.
#[derive(Clone, Copy)]
struct Turn<D>([D; 4]);

impl<D: Doubles> Turn<D> {
    /// The opposite turn.
    #[inline(always)]
    fn back(self) -> Self {
        let [x, y, z, w] = self.0;
        Self([-x, -y, -z, w])
    }
    #[inline(always)]
    fn rotate(self, v: [D; 3]) -> [D; 3] {
        let [x, y, z, w] = self.0;
        let t = scale(cross([x, y, z], v), D::splat(2.0));
        add(add(v, scale(t, w)), cross([x, y, z], t))
    }
    /// The turn `o`, then this.
    #[inline(always)]
    fn after(self, o: Self) -> Self {
        let ([ax, ay, az, aw], [bx, by, bz, bw]) = (self.0, o.0);
        Self([
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ])
    }
    /// As `DQuat::normalize`.
    #[inline(always)]
    fn normalize(self) -> Self {
        let [x, y, z, w] = self.0;
        let l = (x * x + y * y + z * z + w * w).sqrt();
        let fine = l.gt(D::splat(f64::MIN_POSITIVE)) & l.le(D::splat(f64::MAX));
        let (one, zero) = (D::splat(1.0), D::zero());
        let s = one / l;
        Self([
            D::select(fine, x * s, zero),
            D::select(fine, y * s, zero),
            D::select(fine, z * s, zero),
            D::select(fine, w * s, one),
        ])
    }
}

/// Most that an angle is halved.
const HALVINGS: usize = 6;

/// tan x = x y/z for |x| ≤ 1, rational; z within 0.6..1.
#[inline(always)]
fn tan<D: Doubles>(x2: D) -> (D, D) {
    let one = D::splat(1.0);
    (one - x2 * D::splat(1.0 / 15.0), one - x2 * D::splat(0.4))
}

/// Turns `l` (body axes) and `q` about axis `I` by the angle ℓᵢ h d. `q` is no unit quaternion afterwards: the turn by a half angle
/// of tangent y/z is (y, z), but for its length, which costs a root.
#[inline(always)]
fn turn_about<D: Doubles, const I: usize>(l: &mut [D; 3], q: &mut Turn<D>, d: D, h: D) {
    let (one, half) = (D::splat(1.0), D::splat(0.5));
    let mut x = half * l[I] * d * h;
    // A half angle within a radian, where the rational tan holds, and how often to repeat it.
    let mut turns = one;
    for _ in 0..HALVINGS {
        let far = x.abs().gt(one);
        if !far.any() {
            break;
        }
        x = D::select(far, x * half, x);
        turns = D::select(far, turns + turns, turns);
    }
    let (y, z) = tan(x * x);
    let y = x * y;
    let n = one / (z * z + y * y);
    let (c, s) = ((z * z - y * y) * n, D::splat(2.0) * y * z * n);
    let (j, k) = ((I + 1) % 3, (I + 2) % 3);
    let mut done = D::zero();
    for _ in 0..1 << HALVINGS {
        let more = done.lt(turns);
        if !more.any() {
            break;
        }
        // The body turns by +φ, so its view of the constant L turns by −φ.
        let (lj, lk) = (l[j], l[k]);
        l[j] = D::select(more, c * lj + s * lk, lj);
        l[k] = D::select(more, c * lk - s * lj, lk);
        let (qi, qj, qk, qw) = (q.0[I], q.0[j], q.0[k], q.0[3]);
        q.0[I] = D::select(more, qw * y + qi * z, qi);
        q.0[j] = D::select(more, qj * z + qk * y, qj);
        q.0[k] = D::select(more, qk * z - qj * y, qk);
        q.0[3] = D::select(more, qw * z - qi * y, qw);
        done = done + one;
    }
}

/// The turn by the rotation vector `r` (radians), rational, but for its length.
#[inline(always)]
fn turn_by<D: Doubles>(r: [D; 3]) -> Turn<D> {
    let (one, half, quarter) = (D::splat(1.0), D::splat(0.5), D::splat(0.25));
    let (mut part, mut x2, mut turns) = (scale(r, half), quarter * dot(r, r), one);
    for _ in 0..HALVINGS {
        let far = x2.gt(one);
        if !far.any() {
            break;
        }
        for x in &mut part {
            *x = D::select(far, *x * half, *x);
        }
        x2 = D::select(far, quarter * x2, x2);
        turns = D::select(far, turns + turns, turns);
    }
    let (y, z) = tan(x2);
    let step = Turn([part[0] * y, part[1] * y, part[2] * y, z]);
    let (mut q, mut done) = (step, one);
    for _ in 1..1 << HALVINGS {
        let more = done.lt(turns);
        if !more.any() {
            break;
        }
        let turned = step.after(q);
        for i in 0..4 {
            q.0[i] = D::select(more, turned.0[i], q.0[i]);
        }
        done = done + one;
    }
    q
}
