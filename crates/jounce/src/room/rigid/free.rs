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

use super::state::{Body, BodyState, BodyStep, Mass, Motion, Turning};
use super::turn::{Turn, add, dot, normalize_doubles, scale, times};
use crate::table::Table;
use jounce_lanes::{Array, DOUBLES_MAX, Doubles, Kernel, Lanes, Mask as _};
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
fn principal_axes(rotation: Quat, mass: &Mass) -> DQuat {
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

/// Some bodies of a chunk that turn freely, with their memories.
pub(crate) struct Free<'a> {
    pub states: &'a mut [BodyState],
    pub turning: &'a mut [Option<Turning>],
    /// Which of them.
    pub rows: &'a [u8],
}

/// What memories know, a body in each lane.
struct Memories<D> {
    momentum: [D; 3],
    q: Turn<D>,
    frozen: Turn<D>,
    /// What came to ω since.
    change: [D; 3],
}

impl Free<'_> {
    /// The row of a lane; one that stands for nobody repeats the first.
    #[inline(always)]
    fn row(&self, at: usize) -> usize {
        usize::from(*self.rows.get(at).unwrap_or(&self.rows[0]))
    }
    #[inline(always)]
    fn memory(&self, at: usize) -> &Turning {
        self.turning[self.row(at)].as_ref().unwrap_or(&Turning::NOTHING)
    }
    #[inline(always)]
    fn recall<D: Doubles>(&self, at: usize) -> Memories<D> {
        let q = D::gather4(
            #[inline(always)]
            |lane| self.memory(at + lane).q.to_array(),
        );
        let frozen = D::gather4(
            #[inline(always)]
            |lane| self.memory(at + lane).frozen.to_array(),
        );
        let [lx, ly, lz, _] = D::gather4(
            #[inline(always)]
            |lane| {
                let l = self.memory(at + lane).momentum;
                [l.x, l.y, l.z, 0.0]
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
        Memories { momentum: [lx, ly, lz], q: Turn(q), frozen: Turn(frozen), change: [dx, dy, dz] }
    }
    /// Calls `put` with the state, the memory and a row of numbers of every lane from `at` that stands for a body.
    #[inline(always)]
    fn scatter<D: Doubles>(
        &mut self,
        at: usize,
        columns: [D; 4],
        put: impl Fn(usize, &mut BodyState, &mut Turning, [f64; 4]),
    ) {
        let Self { states, turning, rows } = self;
        D::scatter4(
            columns,
            #[inline(always)]
            |lane, numbers| {
                if let Some(&i) = rows.get(at + lane)
                    && let Some(t) = &mut turning[usize::from(i)]
                {
                    put(lane, &mut states[usize::from(i)], t, numbers);
                }
            },
        );
    }
}

impl<D: Doubles> Memories<D> {
    /// Momentum now: impulses came through the frozen inertia.
    #[inline(always)]
    fn momentum(&self, moments: [D; 3]) -> [D; 3] {
        let gain = times(self.frozen.back().rotate(self.change), moments);
        add(self.momentum, self.frozen.rotate(gain))
    }
}

/// Turns of some bodies. Their memories are those of their rotations.
pub(crate) struct Turns<'a> {
    pub free: Free<'a>,
    /// Of the chunk.
    pub tops: &'a [Top],
    /// Fastest spin of each of the rows, rad/s.
    pub spin_most: &'a [f32],
    pub h: f32,
}

impl Kernel for Turns<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let mut at = 0;
        while at < self.free.rows.len() {
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

    /// Turns the rows from `at`.
    #[inline(always)]
    fn turn<D: Doubles>(&mut self, at: usize) {
        let memories = self.free.recall::<D>(at);
        let [mx, my, mz, keep] = D::gather4(
            #[inline(always)]
            |lane| self.tops[self.free.row(at + lane)].moments,
        );
        let mut most = [0.0; DOUBLES_MAX];
        for (most, spin) in most.iter_mut().zip(&self.spin_most[at..]) {
            *most = f64::from(*spin);
        }
        let body = Moments { moments: [mx, my, mz], keep, most: D::load(&most) };
        let (world, q, before, w) = turn(&body, &memories, self.h);
        let way = scale(add(before, w), D::splat(0.5 * f64::from(self.h)));
        let dq = q.after(memories.frozen.back());
        let (free, zero) = (&mut self.free, D::zero());
        free.scatter(
            at,
            [w[0], w[1], w[2], zero],
            #[inline(always)]
            |_, s, t, w| {
                for k in 0..3 {
                    s.hot[3 + k] = w[k] as f32;
                }
                t.w = s.w();
            },
        );
        free.scatter(
            at,
            [way[0], way[1], way[2], zero],
            #[inline(always)]
            |_, s, _, way| {
                for k in 0..3 {
                    s.motion[1 + k] += way[k] as f32;
                }
            },
        );
        free.scatter(
            at,
            dq.0,
            #[inline(always)]
            |_, s, t, dq| {
                for k in 0..4 {
                    s.motion[4 + k] = dq[k] as f32;
                }
                t.dq = Quat::new(s.motion[4], s.motion[5], s.motion[6], s.motion[7]);
            },
        );
        free.scatter(
            at,
            q.0,
            #[inline(always)]
            |_, _, t, q| t.q = DQuat::from_array(q),
        );
        free.scatter(
            at,
            [world[0], world[1], world[2], zero],
            #[inline(always)]
            |_, _, t, l| t.momentum = DVec3::new(l[0], l[1], l[2]),
        );
    }
}

/// Ends of a step: what came since the last turn becomes momentum, and ω follows, as in [`settle`]; memories are those of the rotations at the end,
/// from the precise ones.
pub(crate) struct Ends<'a> {
    pub free: Free<'a>,
    /// Of the chunk.
    pub steps: &'a [BodyStep],
    pub bodies: &'a Table<Body>,
}

impl Kernel for Ends<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let mut at = 0;
        while at < self.free.rows.len() {
            self.end::<L::Doubles>(at);
            at += L::Doubles::WIDTH;
        }
    }
}

impl Ends<'_> {
    #[inline(always)]
    fn mass(&self, at: usize) -> &Mass {
        &self.bodies[self.steps[self.free.row(at)].body].mass
    }

    #[inline(always)]
    fn end<D: Doubles>(&mut self, at: usize) {
        let memories = self.free.recall::<D>(at);
        let [mx, my, mz, _] = D::gather4(
            #[inline(always)]
            |lane| {
                let m = self.mass(at + lane).moments;
                [m.x, m.y, m.z, 0.0]
            },
        );
        let principal = Turn(D::gather4(
            #[inline(always)]
            |lane| self.mass(at + lane).principal.to_array(),
        ));
        let (m, q, one) = ([mx, my, mz], memories.q, D::splat(1.0));
        let world = memories.momentum(m);
        let inv = [one / m[0], one / m[1], one / m[2]];
        let w = q.rotate(times(q.back().rotate(world), inv));
        let rotation = normalize_doubles(q.after(principal.back()));
        let mut rounded = [[0.0; 4]; DOUBLES_MAX];
        D::scatter4(
            rotation.0,
            #[inline(always)]
            |lane, q| {
                for k in 0..4 {
                    rounded[lane][k] = q[k] as f32;
                }
            },
        );
        let rotation = Turn(D::gather4(
            #[inline(always)]
            |lane| rounded[lane].map(f64::from),
        ));
        let frozen = normalize_doubles(rotation.after(principal));
        let (free, zero) = (&mut self.free, D::zero());
        free.scatter(
            at,
            [world[0], world[1], world[2], zero],
            #[inline(always)]
            |_, s, t, l| {
                if t.w != s.w() {
                    t.momentum = DVec3::new(l[0], l[1], l[2]);
                }
            },
        );
        free.scatter(
            at,
            [w[0], w[1], w[2], zero],
            #[inline(always)]
            |_, s, t, w| {
                if t.w != s.w() {
                    for k in 0..3 {
                        s.hot[3 + k] = w[k] as f32;
                    }
                    t.w = s.w();
                }
            },
        );
        free.scatter(
            at,
            frozen.0,
            #[inline(always)]
            |lane, _, t, q| {
                t.frozen = DQuat::from_array(q);
                (t.rotation, t.dq) = (Quat::from_array(rounded[lane]), Quat::IDENTITY);
            },
        );
    }
}
/// Constants of the body in each lane.
struct Moments<D> {
    moments: [D; 3],
    /// What damping leaves of the momentum.
    keep: D,
    /// Fastest spin, rad/s.
    most: D,
}

/// One turn: momentum, rotation of the principal axes, and the angular velocities before and after, world axes.
#[inline(always)]
fn turn<D: Doubles>(body: &Moments<D>, memories: &Memories<D>, h: f32) -> ([D; 3], Turn<D>, [D; 3], [D; 3]) {
    let one = D::splat(1.0);
    let (m, q) = (body.moments, memories.q);
    let inv = [one / m[0], one / m[1], one / m[2]];
    let mut world = scale(memories.momentum(m), body.keep);
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
    let q = turn_by(scale(world, D::splat(h) * im)).after(q);
    let q = normalize_doubles(q);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BodyDesc, ShapeDesc, World, WorldDesc};
    use jounce_lanes::{Width, dispatch};
    use jounce_math::Vec3;

    const H: f32 = 1.0 / 240.0;

    /// Boxes of three different moments, with each axis the middle one, and of two, slow, fast and faster than they may be.
    fn tops() -> World {
        let mut w = World::new(WorldDesc::default()).expect("valid");
        let sizes = [
            [0.5, 0.2, 0.1],
            [0.1, 0.5, 0.2],
            [0.2, 0.1, 0.5],
            [0.3, 0.3, 0.1],
            [0.3, 0.1, 0.3],
            [0.1, 0.3, 0.3],
        ];
        for i in 0..43_u32 {
            let x = |k: u32| ((i * 7 + k * 5) % 11) as f32 - 5.0;
            let spin = [1.0, 30.0, 400.0][i as usize % 3];
            let d = BodyDesc::dynamic().at([f64::from(i) * 3.0, 0.0, 0.0]);
            let d = d.shape(ShapeDesc::cuboid(sizes[i as usize % 6]));
            let d = d.rotated(Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), x(6)));
            let d = d.angular_velocity(Vec3::new(x(3), x(4), x(5) + 0.5) * spin);
            w.add_body(d).expect("valid");
        }
        w
    }

    struct Tops {
        w: World,
        tops: Vec<Top>,
        spin_most: Vec<f32>,
        rows: Vec<u8>,
    }

    impl Tops {
        fn new() -> Self {
            let mut w = tops();
            let n = w.awake.state.len();
            let tops = w.awake.step.iter().map(|b| Top::new(b, &w.bodies[b.body].mass, H)).collect();
            for row in 0..n {
                let slot = w.awake.step[row].body;
                let (mass, rotation) = (&w.bodies[slot].mass, w.frames[slot as usize].rotation);
                remember(&w.awake.state[row], &mut w.awake.turning[row], || (mass, rotation));
            }
            let spin_most = (0..n).map(|i| if i % 5 == 0 { 20.0 } else { 1e6 }).collect();
            Self { w, tops, spin_most, rows: (0..n as u8).collect() }
        }
        fn turn(&mut self, width: Width) {
            let Self { w, tops, spin_most, rows } = self;
            let free = Free { states: &mut w.awake.state, turning: &mut w.awake.turning, rows };
            dispatch(width, Turns { free, tops, spin_most, h: H });
        }
        fn end(&mut self, width: Width) {
            let free = Free {
                states: &mut self.w.awake.state,
                turning: &mut self.w.awake.turning,
                rows: &self.rows,
            };
            dispatch(width, Ends { free, steps: &self.w.awake.step, bodies: &self.w.bodies });
        }
        /// What a contact does.
        fn push(&mut self, i: usize) {
            let s = &mut self.w.awake.state[i];
            s.set_velocity(s.v(), s.w() + Vec3::new(0.3, -0.2, 0.1));
        }
        fn bits(&self) -> Vec<u64> {
            let mut out = Vec::new();
            for (s, t) in self.w.awake.state.iter().zip(&self.w.awake.turning) {
                out.extend(s.hot.iter().chain(&s.motion).map(|x| u64::from(x.to_bits())));
                let t = t.as_ref().expect("a memory");
                let f64s = [t.momentum.x, t.momentum.y, t.momentum.z];
                out.extend(
                    f64s.iter().chain(&t.q.to_array()).chain(&t.frozen.to_array()).map(|x| x.to_bits()),
                );
                let f32s =
                    t.rotation.to_array().into_iter().chain(t.dq.to_array()).chain([t.w.x, t.w.y, t.w.z]);
                out.extend(f32s.map(|x| u64::from(x.to_bits())));
            }
            out
        }
    }

    /// Lanes of every width turn, and end a step, as one by one: whoever stands beside whom, and whether all of a chunk turn or some.
    #[test]
    fn lanes_turn_as_one_by_one() {
        let run = |width: Width, groups: &[fn(usize) -> bool]| {
            let mut tops = Tops::new();
            let all = (tops.rows.clone(), tops.spin_most.clone());
            for round in 0..6 {
                for group in groups {
                    let picked: Vec<usize> = (0..all.0.len()).filter(|i| group(*i)).collect();
                    tops.rows = picked.iter().map(|&i| all.0[i]).collect();
                    tops.spin_most = picked.iter().map(|&i| all.1[i]).collect();
                    tops.turn(width);
                    if round == 3 {
                        picked.iter().filter(|&&i| i % 3 == 1).for_each(|&i| tops.push(i));
                        tops.end(width);
                    }
                }
                (0..all.0.len()).filter(|i| i % 4 == 1).for_each(|i| tops.push(i));
            }
            tops.bits()
        };
        let expected = run(Width::X1, &[|_| true]);
        for width in Width::ALL {
            assert_eq!(run(width, &[|_| true]), expected, "{width}");
            assert_eq!(run(width, &[|i| i % 2 == 0, |i| i % 2 == 1]), expected, "{width}");
            assert_eq!(run(width, &[|i| i < 5, |i| i >= 5]), expected, "{width}");
        }
    }

    /// Angular momentum and energy are those of the start; what comes through the frozen inertia is taken over as momentum; spin is cut.
    #[test]
    fn turns_keep_momentum_and_energy() {
        let mut tops = Tops::new();
        let momentum = |tops: &Tops, i: usize| tops.w.awake.turning[i].as_ref().expect("a memory").momentum;
        let moments = |tops: &Tops, i: usize| tops.w.bodies[tops.w.awake.step[i].body].mass.moments;
        let energy = |tops: &Tops, i: usize| {
            let t = tops.w.awake.turning[i].as_ref().expect("a memory");
            let l = t.q.inverse_rotate(t.momentum);
            let m = moments(tops, i);
            0.5 * (l.x * l.x / m.x + l.y * l.y / m.y + l.z * l.z / m.z)
        };
        let n = tops.rows.len();
        let before: Vec<_> = (0..n).map(|i| (momentum(&tops, i), energy(&tops, i))).collect();
        let spins: Vec<f32> = tops.w.awake.state.iter().map(|s| s.w().length()).collect();
        for _ in 0..240 {
            tops.turn(Width::native());
        }
        let (mut cut, mut slow) = (0, 0);
        for i in 0..n {
            let (l, e) = before[i];
            let (now, energy) = (momentum(&tops, i), energy(&tops, i));
            if spins[i] > tops.spin_most[i] {
                let size = (2.0 * energy / moments(&tops, i).min_component()).sqrt();
                assert!(now.length() < l.length() && size >= f64::from(tops.spin_most[i]) * 0.99, "{i}");
                cut += 1;
                continue;
            }
            assert!((now - l).length() <= 1e-12 * l.length(), "{i}: {l:?} {now:?}");
            // Splitting in two keeps energy within the square of the turn of a substep.
            let turn = f64::from(spins[i] * H);
            assert!((energy - e).abs() <= (0.02 * turn * turn + 1e-9) * e, "{i}: {e} {energy}, turn {turn}");
            slow += 1;
        }
        assert!(cut > 3 && slow > 25, "{cut} {slow}");
        let gain = Vec3::new(0.3, -0.2, 0.1).as_dvec3();
        for i in 0..n {
            let t = tops.w.awake.turning[i].as_ref().expect("a memory");
            let expected = t.momentum + t.frozen.rotate(t.frozen.inverse_rotate(gain).mul(moments(&tops, i)));
            tops.push(i);
            let at = tops.rows.clone();
            tops.rows = vec![i as u8];
            tops.end(Width::native());
            tops.rows = at;
            let now = momentum(&tops, i);
            assert!((now - expected).length() <= 1e-6 * expected.length(), "{i}: {now:?} {expected:?}");
        }
    }
}
