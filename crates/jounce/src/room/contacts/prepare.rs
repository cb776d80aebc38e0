//! From manifolds to solver rows, once per step: [`fill`] copies a manifold into its lane, [`Prepare`] then computes
//! Jacobians and effective masses for all lanes of a block at once.

use super::rows::{Block, LANES, Lane, Wide3};
use super::state::{Contact, ContactManifold};
use crate::room::rigid::state::{Awake, BodyFrame, BodyState, InvInertia};
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

/// One body as a row sees it.
fn side(awake: &Awake, frame: &BodyFrame) -> (BodyState, InvInertia, Vec3) {
    let row = frame.row as usize;
    match awake.state.get(row) {
        Some(state) => (*state, awake.inertia[row], awake.step[row].acceleration),
        None => (BodyState::FIXED, InvInertia::default(), Vec3::ZERO),
    }
}

/// Velocities of the two bodies of every row of a block, gathered while filling.
pub(crate) struct Speeds {
    va: super::rows::LaneVec,
    wa: super::rows::LaneVec,
    vb: super::rows::LaneVec,
    wb: super::rows::LaneVec,
}

impl Speeds {
    pub const ZERO: Self = Self {
        va: super::rows::LaneVec::ZERO,
        wa: super::rows::LaneVec::ZERO,
        vb: super::rows::LaneVec::ZERO,
        wb: super::rows::LaneVec::ZERO,
    };
}

/// Copies a manifold into a lane.
pub(crate) fn fill(
    block: &mut Block,
    speeds: &mut Speeds,
    l: usize,
    c: &Contact,
    m: &ContactManifold,
    frames: &[BodyFrame],
    awake: &Awake,
    k: &StepConstants,
) {
    let l = l % LANES;
    let (a, inertia_a, acceleration_a) = side(awake, &frames[c.body_a as usize]);
    let (b, inertia_b, acceleration_b) = side(awake, &frames[c.body_b as usize]);
    speeds.va.set(l, a.v());
    speeds.wa.set(l, a.w());
    speeds.vb.set(l, b.v());
    speeds.wb.set(l, b.w());
    block.normal.set(l, m.normal);
    block.offset.set(l, m.offset);
    block.acceleration.set(l, acceleration_b - acceleration_a);
    block.inv_mass_a[l] = inertia_a.inv_mass;
    block.inv_mass_b[l] = inertia_b.inv_mass;
    set_inertia(&mut block.inertia_a, l, &inertia_a);
    set_inertia(&mut block.inertia_b, l, &inertia_b);
    let soft = if inertia_a.inv_mass == 0.0 || inertia_b.inv_mass == 0.0 { k.fixed } else { k.moving };
    block.bias_rate[l] = soft.bias_rate * c.share;
    block.push_out[l] = -k.push_out_speed * c.share;
    block.mass_scale[l] = soft.mass_scale;
    block.impulse_scale[l] = soft.impulse_scale;
    let count = usize::from(m.count).min(4);
    block.points_max = block.points_max.max(count);
    for (rows, p) in block.points.iter_mut().zip(&m.points) {
        rows.j.a.set(l, p.arm);
        rows.separation[l] = p.separation;
        rows.impulse[l] = p.impulse * k.warm;
        rows.mass[l] = 1.0;
    }
    for rows in &mut block.points[count..] {
        rows.j.a.set(l, Vec3::ZERO);
        rows.separation[l] = 0.0;
        rows.impulse[l] = 0.0;
        rows.mass[l] = 0.0;
    }
    let s = &m.surface;
    block.restitution[l] = s.restitution;
    block.any_rebound |= s.restitution > 0.0;
    block.friction_world.set(l, m.friction * k.warm);
    block.surface_velocity.set(l, s.velocity);
    block.mu[l] = if m.stick { s.static_friction } else { s.kinetic_friction };
    block.twist_impulse[l] = m.twist * k.warm;
    block.twist_patch[l] = s.twist_friction;
    block.rolling[l] = s.rolling_friction;
    block.rolling_impulse.set(l, m.rolling * k.warm);
    let mut rolling_mass = Mat3::ZERO;
    if s.rolling_friction > 0.0 {
        block.any_rolling = true;
        let sum = inertia_a.to_mat3() + inertia_b.to_mat3();
        rolling_mass = sum.inverse().unwrap_or(Mat3::ZERO);
    }
    if block.any_rolling {
        let r = &rolling_mass;
        for (field, v) in block.rolling_mass.iter_mut().zip([r.cx.x, r.cy.y, r.cz.z, r.cy.x, r.cz.x, r.cz.y])
        {
            field[l] = v;
        }
    }
}

#[inline(always)]
fn set_inertia(t: &mut [Lane; 6], l: usize, i: &InvInertia) {
    for (field, v) in t.iter_mut().zip([i.xx, i.yy, i.zz, i.xy, i.xz, i.yz]) {
        field[l % LANES] = v;
    }
}

/// Jacobians, effective masses, friction centre and rebound speeds of a filled block.
pub(crate) struct Prepare<'a> {
    pub block: &'a mut Block,
    pub speeds: &'a Speeds,
    pub constants: &'a StepConstants,
}

impl Kernel for Prepare<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut at = 0;
        while at < self.block.rows {
            prepare_lanes::<L>(self.block, self.speeds, self.constants, at);
            at += L::WIDTH;
        }
    }
}

/// Body terms shared by all directions of a row.
#[derive(Clone, Copy)]
struct Masses<L> {
    inv: L,
    at: usize,
}

/// Sets a direction's Jacobian; gives J M⁻¹ Jᵀ.
#[inline(always)]
fn set_jacobian<L: Lanes>(
    j: &mut super::rows::Jacobian,
    inertia: [&[Lane; 6]; 2],
    dir: Wide3<L>,
    ra: Wide3<L>,
    rb: Wide3<L>,
    m: Masses<L>,
) -> L {
    let (ja, jb) = (ra.cross(dir), rb.cross(dir));
    let (ia, ib) = (ja.times(inertia[0], m.at), jb.times(inertia[1], m.at));
    ja.store(&mut j.a, m.at);
    jb.store(&mut j.b, m.at);
    ia.store(&mut j.ia, m.at);
    ib.store(&mut j.ib, m.at);
    m.inv + ja.dot(ia) + jb.dot(ib)
}

/// 1/x, or 0 where x is not positive.
#[inline(always)]
fn invert<L: Lanes>(x: L) -> L {
    L::select(x.gt(L::zero()), L::splat(1.0) / x, L::zero())
}

/// Two unit vectors that make a right-handed basis with a unit vector (Duff et al. 2017), lane by lane.
#[inline(always)]
fn basis<L: Lanes>(n: Wide3<L>) -> (Wide3<L>, Wide3<L>) {
    let one = L::splat(1.0);
    let sign = L::select(n.z.ge(L::zero()), one, L::splat(-1.0));
    let a = L::splat(-1.0) / (sign + n.z);
    let b = n.x * n.y * a;
    (
        Wide3::new(one + sign * n.x * n.x * a, sign * b, -(sign * n.x)),
        Wide3::new(b, sign + n.y * n.y * a, -n.y),
    )
}

#[inline(always)]
fn prepare_lanes<L: Lanes>(block: &mut Block, speeds: &Speeds, k: &StepConstants, at: usize) {
    let n = Wide3::<L>::load(&block.normal, at);
    let offset = Wide3::<L>::load(&block.offset, at);
    let m = Masses { inv: L::load(&block.inv_mass_a[at..]) + L::load(&block.inv_mass_b[at..]), at };
    let dv = Wide3::<L>::load(&speeds.vb, at).sub(Wide3::load(&speeds.va, at));
    let (wa, wb) = (Wide3::<L>::load(&speeds.wa, at), Wide3::<L>::load(&speeds.wb, at));
    let closing = -n.dot(Wide3::load(&block.acceleration, at));
    let mut center = Wide3::new(L::zero(), L::zero(), L::zero());
    let mut weights = L::zero();
    let mut arms = [center; 4];
    let inertia = [&block.inertia_a, &block.inertia_b];
    for (rows, arm) in block.points.iter_mut().zip(&mut arms).take(block.points_max) {
        let ra = Wide3::<L>::load(&rows.j.a, at);
        *arm = ra;
        let present = L::load(&rows.mass[at..]);
        let kn = set_jacobian(&mut rows.j, inertia, n, ra, ra.sub(offset), m);
        let mass = invert(kn) * present;
        mass.store(&mut rows.mass[at..]);
        // What cannot be moved is not pushed, and keeps nothing of what it was.
        let old = L::load(&rows.impulse[at..]);
        L::select(mass.gt(L::zero()), old, L::zero()).store(&mut rows.impulse[at..]);
        L::zero().store(&mut rows.total[at..]);
        let s = L::load(&rows.separation[at..]);
        let vn = n.dot(dv) + Wide3::load(&rows.j.b, at).dot(wb) - Wide3::load(&rows.j.a, at).dot(wa);
        (-vn).store(&mut rows.approach[at..]);
        // A point about to open counts less, so that the friction centre moves smoothly; those beyond twice the
        // margin hardly count.
        let weight =
            (L::splat(2.0) - s * L::splat(k.inv_margin)).max(L::splat(1e-10)).min(L::splat(1.0)) * present;
        center = center.add(ra.scale(weight));
        weights = weights + weight;
        if block.any_rebound {
            let (speed, half) = impact_speed(-vn, closing, s, k.h);
            let e = L::load(&block.restitution[at..]);
            let bounces = vn.lt(L::zero()) & speed.gt(L::splat(k.restitution_speed)) & e.gt(L::zero());
            L::select(bounces, e * speed + half, L::zero()).store(&mut rows.rebound[at..]);
        }
    }
    let center = center.scale(invert(weights));
    for (rows, arm) in block.points.iter_mut().zip(&arms).take(block.points_max) {
        let d = arm.sub(center);
        d.dot(d).sqrt().store(&mut rows.lever[at..]);
    }
    prepare_friction(block, n, center, center.sub(offset), m);
}

#[inline(always)]
fn prepare_friction<L: Lanes>(block: &mut Block, n: Wide3<L>, ra: Wide3<L>, rb: Wide3<L>, m: Masses<L>) {
    let at = m.at;
    let (t1, t2) = basis(n);
    t1.store(&mut block.tangent, at);
    let inertia = [&block.inertia_a, &block.inertia_b];
    let [f1, f2] = &mut block.friction;
    let xx = set_jacobian(f1, inertia, t1, ra, rb, m);
    let yy = set_jacobian(f2, inertia, t2, ra, rb, m);
    let xy = Wide3::<L>::load(&f1.a, at).dot(Wide3::load(&f2.ia, at))
        + Wide3::<L>::load(&f1.b, at).dot(Wide3::load(&f2.ib, at));
    let inv = invert(xx * yy - xy * xy);
    (yy * inv).store(&mut block.friction_mass[0][at..]);
    (-(xy * inv)).store(&mut block.friction_mass[1][at..]);
    (xx * inv).store(&mut block.friction_mass[2][at..]);
    let f = Wide3::<L>::load(&block.friction_world, at);
    let v = Wide3::<L>::load(&block.surface_velocity, at);
    for (i, t) in [t1, t2].into_iter().enumerate() {
        f.dot(t).store(&mut block.friction_impulse[i][at..]);
        v.dot(t).store(&mut block.surface_speed[i][at..]);
        L::zero().store(&mut block.friction_total[i][at..]);
    }
    let (ia, ib) = (n.times(&block.inertia_a, at), n.times(&block.inertia_b, at));
    ia.store(&mut block.twist_ia, at);
    ib.store(&mut block.twist_ib, at);
    invert(n.dot(ia) + n.dot(ib)).store(&mut block.twist_mass[at..]);
}
