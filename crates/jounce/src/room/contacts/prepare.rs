//! From manifolds to solver rows, once per step: [`Prepare`] transposes the manifolds and bodies of a block into lanes, and computes
//! Jacobians and effective masses for all of them at once; [`fill`] adds what is decided row by row.

use super::rows::{Block, LANES, Wide3, basis, coupling, velocity};
use super::state::ContactManifold;
use crate::room::rigid::state::{Awake, BodyState, InvInertia};
use crate::settings::Settings;
use jounce_lanes::{Kernel, Lanes};
use jounce_math::{Mat3, Vec3, scalar::f32s};

/// A soft constraint's three numbers; see the room's text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Softness {
    pub bias_rate: f32,
    pub mass_scale: f32,
    pub impulse_scale: f32,
}

impl Softness {
    pub fn new(hertz: f32, zeta: f32, h: f32) -> Self {
        let omega = 2.0 * core::f32::consts::PI * hertz;
        let a1 = 2.0 * zeta + h * omega;
        let a2 = h * omega * a1;
        let a3 = 1.0 / (1.0 + a2);
        Self { bias_rate: omega / a1, mass_scale: a2 * a3, impulse_scale: a3 }
    }
}

/// Constants of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepConstants {
    pub h: f32,
    pub inv_h: f32,
    pub moving: Softness,
    pub fixed: Softness,
    pub push_out_speed: f32,
    pub restitution_speed: f32,
    pub inv_margin: f32,
    pub warm: f32,
}

impl StepConstants {
    pub fn new(s: &Settings, dt: f32, substeps: u32) -> Self {
        let h = dt / substeps as f32;
        let inv_h = 1.0 / h;
        let moving = f32s::min(s.contact_hertz, 0.125 * inv_h);
        let fixed = f32s::min(s.static_contact_hertz, 0.25 * inv_h);
        Self {
            h,
            inv_h,
            moving: Softness::new(moving, s.contact_damping_ratio, h),
            fixed: Softness::new(fixed, s.static_contact_damping_ratio, h),
            push_out_speed: s.push_out_speed * s.length_unit,
            restitution_speed: s.restitution_speed,
            inv_margin: 1.0 / s.speculative_margin(),
            warm: if s.warm_starting { 1.0 } else { 0.0 },
        }
    }
}

/// Speed V at which two surfaces meet, and half a substep of their relative acceleration: restitution
/// leaves with e V + a h/2. Lane by lane.
///
/// The velocity of semi-implicit Euler is half a substep late: u²/2 + a s + (a h/2) u is what it keeps along a fall,
/// so V² = (u + a h/2)² + 2 a s for the approach speed u at the gap s. With the pre-step speed u alone, a ball loses 9 % of its
/// height at each bounce.
#[inline(always)]
pub(crate) fn impact_speed<L: Lanes>(approach: L, acceleration: L, gap: L, h: f32) -> (L, L) {
    let a = acceleration.max(L::zero());
    let half = L::splat(0.5 * h) * a;
    let u = approach + half;
    let v2 = u * u + L::splat(2.0) * a * gap;
    (v2.max(L::zero()).sqrt(), half)
}

/// What a block is made from: manifolds and their two bodies, lane by lane.
pub(crate) struct Sources<'a> {
    pub manifolds: [&'a ContactManifold; LANES],
    pub states: [[&'a BodyState; LANES]; 2],
    pub inertia: [[&'a InvInertia; LANES]; 2],
    /// Acceleration of B against A without contacts, m/s²; filled where something bounces.
    pub acceleration: super::rows::LaneVec,
}

static NO_MANIFOLD: ContactManifold = ContactManifold::NOTHING;
static NO_STATE: BodyState = BodyState::FIXED;
static NO_INERTIA: InvInertia = InvInertia::FIXED;

impl<'a> Sources<'a> {
    pub const NOTHING: Self = Self {
        manifolds: [&NO_MANIFOLD; LANES],
        states: [[&NO_STATE; LANES]; 2],
        inertia: [[&NO_INERTIA; LANES]; 2],
        acceleration: super::rows::LaneVec::ZERO,
    };
    /// Puts a manifold and its bodies' rows into a lane.
    pub fn put(&mut self, l: usize, m: &'a ContactManifold, rows: [Option<usize>; 2], awake: &'a Awake) {
        let l = l % LANES;
        self.manifolds[l] = m;
        for (i, row) in rows.into_iter().enumerate() {
            if let Some(row) = row {
                self.states[i][l] = &awake.state[row];
                self.inertia[i][l] = &awake.inertia[row];
            }
        }
        if m.surface.restitution > 0.0 {
            let acceleration = |row: Option<usize>| row.map_or(Vec3::ZERO, |r| awake.step[r].acceleration);
            self.acceleration.set(l, acceleration(rows[1]) - acceleration(rows[0]));
        }
    }
}

/// What of a row is no lane of its manifold's: friction by the stick bit, how it rolls.
pub(crate) fn fill(block: &mut Block, l: usize, s: &Sources<'_>) {
    let l = l % LANES;
    let m = s.manifolds[l];
    block.mu[l] = if m.stick { m.surface.static_friction } else { m.surface.kinetic_friction };
    // One, two or four: the passes are made for these.
    block.points_max = block.points_max.max(usize::from(m.count).min(4).next_power_of_two());
    block.round &= s.inertia[0][l].is_round() && s.inertia[1][l].is_round();
    block.any_rebound |= m.surface.restitution > 0.0;
    block.any_surface |= m.surface.velocity != Vec3::ZERO;
    if m.surface.rolling_friction > 0.0 {
        if !block.any_rolling {
            block.any_rolling = true;
            block.rolling_mass = [[0.0; LANES]; 6];
        }
        let [a, b] = [s.inertia[0][l], s.inertia[1][l]];
        let r = (a.to_mat3() + b.to_mat3()).inverse().unwrap_or(Mat3::ZERO);
        for (field, v) in block.rolling_mass.iter_mut().zip([r.cx.x, r.cy.y, r.cz.z, r.cy.x, r.cz.x, r.cz.y])
        {
            field[l] = v;
        }
    }
}

/// Lanes, Jacobians, effective masses, friction centre and rebound speeds of a block.
pub(crate) struct Prepare<'a, 'b> {
    pub block: &'a mut Block,
    pub sources: &'a Sources<'b>,
    pub constants: &'a StepConstants,
}

impl Kernel for Prepare<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut at = 0;
        // All lanes: those without a row become zero.
        while at < LANES {
            prepare_lanes::<L>(self.block, self.sources, self.constants, at);
            at += L::WIDTH;
        }
    }
}

/// The two bodies of a row, in registers.
#[derive(Clone, Copy)]
struct Bodies<L> {
    inertia: [[L; 6]; 2],
    round: bool,
    /// 1/m_A + 1/m_B.
    inv: L,
}

/// A direction's Jacobian by its angular parts r × d, and I⁻¹ times them, of both bodies.
#[derive(Clone, Copy)]
struct Jacobian<L> {
    turn: [Wide3<L>; 2],
    back: [Wide3<L>; 2],
}

impl<L: Lanes> Bodies<L> {
    /// I⁻¹ v of body A (0) or B (1).
    #[inline(always)]
    fn back(&self, side: usize, v: Wide3<L>) -> Wide3<L> {
        let t = &self.inertia[side];
        if self.round { v.scale(t[0]) } else { v.turned(t) }
    }
}

impl<L: Lanes> Jacobian<L> {
    #[inline(always)]
    fn new(m: &Bodies<L>, dir: Wide3<L>, [ra, rb]: [Wide3<L>; 2]) -> Self {
        let (a, b) = (ra.cross(dir), rb.cross(dir));
        Self { turn: [a, b], back: [m.back(0, a), m.back(1, b)] }
    }
    /// What one direction's impulse does to the speed along another: the turns' part of J M⁻¹ Jᵀ.
    #[inline(always)]
    fn dot(&self, o: &Self) -> L {
        self.turn[0].dot(o.back[0]) + self.turn[1].dot(o.back[1])
    }
}

/// 1/x, or 0 where x is not positive.
#[inline(always)]
fn invert<L: Lanes>(x: L) -> L {
    L::select(x.gt(L::zero()), L::splat(1.0) / x, L::zero())
}

#[inline(always)]
fn prepare_lanes<L: Lanes>(block: &mut Block, s: &Sources<'_>, k: &StepConstants, at: usize) {
    let [nx, ny, nz, dx, dy, dz, twist, _] = L::gather8_of(
        #[inline(always)]
        |l| s.manifolds[(at + l) % LANES].lanes(),
    );
    let (n, offset) = (Wide3::new(nx, ny, nz), Wide3::new(dx, dy, dz));
    n.store(&mut block.normal, at);
    let warm = L::splat(k.warm);
    (twist * warm).store(&mut block.twist_impulse[at..]);
    let [_, _, restitution, rolling, patch, vx, vy, vz] = L::gather8_of(
        #[inline(always)]
        |l| s.manifolds[(at + l) % LANES].surface.lanes(),
    );
    if block.any_rebound {
        restitution.store(&mut block.restitution[at..]);
    }
    let ((va, wa), (vb, wb)) = (velocity::<L>(&s.states[0], at), velocity(&s.states[1], at));
    let [axx, ayy, azz, axy, axz, ayz, ma, _] = inertia::<L>(&s.inertia[0], at);
    let [bxx, byy, bzz, bxy, bxz, byz, mb, _] = inertia::<L>(&s.inertia[1], at);
    ma.store(&mut block.inv_mass_a[at..]);
    mb.store(&mut block.inv_mass_b[at..]);
    let m = Bodies {
        inertia: [[axx, ayy, azz, axy, axz, ayz], [bxx, byy, bzz, bxy, bxz, byz]],
        round: block.round,
        inv: ma + mb,
    };
    let parts = if block.round { 1 } else { 6 };
    for i in 0..parts {
        m.inertia[0][i].store(&mut block.inertia_a[i][at..]);
        m.inertia[1][i].store(&mut block.inertia_b[i][at..]);
    }
    let dv = vb.sub(va);
    let closing = -n.dot(Wide3::load(&s.acceleration, at));
    let none = Wide3::new(L::zero(), L::zero(), L::zero());
    let (mut center, mut weights) = (none, L::zero());
    let mut arms = [none; 4];
    let mut jacobians = [Jacobian { turn: [none; 2], back: [none; 2] }; 4];
    let counts = counts::<L>(s, at);
    for i in 0..block.points_max.min(4) {
        let there = counts.gt(L::splat(i as f32));
        let [rx, ry, rz, separation, impulse, ..] = L::gather8_of(
            #[inline(always)]
            |l| s.manifolds[(at + l) % LANES].point_lanes(i),
        );
        let none = L::zero();
        let ra =
            Wide3::new(L::select(there, rx, none), L::select(there, ry, none), L::select(there, rz, none));
        let (gap, old) = (L::select(there, separation, none), L::select(there, impulse * warm, none));
        let present = L::select(there, L::splat(1.0), L::zero());
        let j = Jacobian::new(&m, n, [ra, ra.sub(offset)]);
        let mass = invert(m.inv + j.dot(&j)) * present;
        let (rows, sums) = (&mut block.points[i], &mut block.sums[i]);
        mass.store(&mut rows.mass[at..]);
        // What cannot be moved is not pushed, and keeps nothing of what it was.
        L::select(mass.gt(L::zero()), old, L::zero()).store(&mut rows.impulse[at..]);
        L::zero().store(&mut sums.total[at..]);
        gap.store(&mut rows.separation[at..]);
        let vn = n.dot(dv) + j.turn[1].dot(wb) - j.turn[0].dot(wa);
        (-vn).store(&mut sums.approach[at..]);
        (arms[i], jacobians[i]) = (ra, j);
        // A point about to open counts less, so that the friction centre moves smoothly; those beyond twice the
        // margin hardly count.
        let weight =
            (L::splat(2.0) - gap * L::splat(k.inv_margin)).max(L::splat(1e-10)).min(L::splat(1.0)) * present;
        center = center.add(ra.scale(weight));
        weights = weights + weight;
        if block.any_rebound {
            let (speed, half) = impact_speed(-vn, closing, gap, k.h);
            let e = restitution;
            let bounces = vn.lt(L::zero()) & speed.gt(L::splat(k.restitution_speed)) & e.gt(L::zero());
            L::select(bounces, e * speed + half, L::zero()).store(&mut sums.rebound[at..]);
        }
    }
    let center = center.scale(invert(weights));
    let (t1, t2) = basis(n);
    for j in 0..block.points_max.min(4) {
        let d = arms[j].sub(center);
        d.dot(t1).store(&mut block.points[j].x[at..]);
        d.dot(t2).store(&mut block.points[j].y[at..]);
        (d.dot(d).sqrt() + patch).store(&mut block.sums[j].lever[at..]);
        for i in 0..j {
            (m.inv + jacobians[i].dot(&jacobians[j])).store(&mut block.coupling[coupling(i, j)][at..]);
        }
    }
    let arm = [center, center.sub(offset)];
    arm[0].store(&mut block.arm_a, at);
    arm[1].store(&mut block.arm_b, at);
    let [fx, fy, fz, px, py, pz, ..] = L::gather8_of(
        #[inline(always)]
        |l| s.manifolds[(at + l) % LANES].friction_lanes(),
    );
    if block.any_rolling {
        rolling.store(&mut block.rolling[at..]);
        Wide3::new(px * warm, py * warm, pz * warm).store(&mut block.rolling_impulse, at);
    }
    let friction = Wide3::new(fx * warm, fy * warm, fz * warm);
    prepare_friction(block, &m, n, arm, friction, Wide3::new(vx, vy, vz), at);
}

#[inline(always)]
fn inertia<L: Lanes>(of: &[&InvInertia; LANES], at: usize) -> [L; 8] {
    L::gather8_of(
        #[inline(always)]
        |l| of[(at + l) % LANES].lanes(),
    )
}

/// Points of each row.
#[inline(always)]
fn counts<L: Lanes>(s: &Sources<'_>, at: usize) -> L {
    let mut counts = [0.0; LANES];
    for l in 0..L::WIDTH {
        counts[l % LANES] = f32::from(s.manifolds[(at + l) % LANES].count);
    }
    L::load(&counts)
}

#[inline(always)]
fn prepare_friction<L: Lanes>(
    block: &mut Block,
    m: &Bodies<L>,
    n: Wide3<L>,
    arms: [Wide3<L>; 2],
    impulse: Wide3<L>,
    velocity: Wide3<L>,
    at: usize,
) {
    let (t1, t2) = basis(n);
    let (j1, j2) = (Jacobian::new(m, t1, arms), Jacobian::new(m, t2, arms));
    let (xx, yy, xy) = (m.inv + j1.dot(&j1), m.inv + j2.dot(&j2), j1.dot(&j2));
    let inv = invert(xx * yy - xy * xy);
    (yy * inv).store(&mut block.friction_mass[0][at..]);
    (-(xy * inv)).store(&mut block.friction_mass[1][at..]);
    (xx * inv).store(&mut block.friction_mass[2][at..]);
    for (i, t) in [t1, t2].into_iter().enumerate() {
        impulse.dot(t).store(&mut block.friction_impulse[i][at..]);
        L::zero().store(&mut block.friction_total[i][at..]);
        if block.any_surface {
            velocity.dot(t).store(&mut block.surface_speed[i][at..]);
        }
    }
    let (ia, ib) = (m.back(0, n), m.back(1, n));
    invert(n.dot(ia) + n.dot(ib)).store(&mut block.twist_mass[at..]);
}
