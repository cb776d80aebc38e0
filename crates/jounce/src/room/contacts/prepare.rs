//! From manifolds to solver rows, once per step.

use super::rows::{Block, Jacobian, LANES, Lane};
use super::state::{Contact, ContactManifold};
use crate::room::rigid::state::{Awake, BodyFrame, BodyState, InvInertia};
use crate::settings::Settings;
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

/// One body as a row sees it.
#[derive(Clone, Copy)]
pub(crate) struct Side {
    pub state: BodyState,
    pub inertia: InvInertia,
    pub acceleration: Vec3,
}

impl Side {
    pub fn of(awake: &Awake, frame: &BodyFrame) -> Self {
        match awake.state.get(frame.row as usize) {
            Some(state) => Self {
                state: *state,
                inertia: awake.inertia[frame.row as usize],
                acceleration: awake.step[frame.row as usize].acceleration,
            },
            None => {
                Self { state: BodyState::FIXED, inertia: InvInertia::default(), acceleration: Vec3::ZERO }
            }
        }
    }
}

/// Speed V at which two surfaces meet, and half a substep of their relative acceleration: restitution
/// leaves with e V + a h/2.
///
/// The velocity of semi-implicit Euler is half a substep late: u²/2 + a s + (a h/2) u is what it keeps along a fall,
/// so V² = (u + a h/2)² + 2 a s for the approach speed u at the gap s. With the pre-step speed u alone, a ball loses 9 % of its
/// height at each bounce.
pub(crate) fn impact_speed(approach: f32, acceleration: f32, gap: f32, h: f32) -> (f32, f32) {
    let a = f32s::max(acceleration, 0.0);
    let u = approach + 0.5 * a * h;
    let v2 = u * u + 2.0 * a * gap;
    (f32s::max(v2, 0.0).sqrt(), 0.5 * a * h)
}

/// Fills one lane of a block from a manifold.
pub(crate) fn fill(
    block: &mut Block,
    l: usize,
    c: &Contact,
    m: &ContactManifold,
    frames: &[BodyFrame],
    awake: &Awake,
    k: &StepConstants,
) {
    let (fa, fb) = (&frames[c.body_a as usize], &frames[c.body_b as usize]);
    let (a, b) = (Side::of(awake, fa), Side::of(awake, fb));
    let normal = m.normal;
    let (tangent, bitangent) = normal.orthonormal_basis();
    let (ma, mb) = (a.inertia.inv_mass, b.inertia.inv_mass);
    block.normal.set(l, normal);
    block.tangent.set(l, tangent);
    block.inv_mass_a[l] = ma;
    block.inv_mass_b[l] = mb;
    let soft = if ma == 0.0 || mb == 0.0 { k.fixed } else { k.moving };
    block.bias_rate[l] = soft.bias_rate;
    block.mass_scale[l] = soft.mass_scale;
    block.impulse_scale[l] = soft.impulse_scale;
    block.count[l] = m.count;
    let center = fill_points(block, l, m, [&a, &b], k);
    fill_friction(block, l, m, [normal, tangent, bitangent], center, [&a, &b], k);
}

/// The points; gives the friction centre relative to A.
fn fill_points(
    block: &mut Block,
    l: usize,
    m: &ContactManifold,
    sides: [&Side; 2],
    k: &StepConstants,
) -> Vec3 {
    let [a, b] = sides;
    let normal = m.normal;
    let acceleration = -normal.dot(b.acceleration - a.acceleration);
    let (mut center, mut weights) = (Vec3::ZERO, 0.0);
    let mut levers = [Vec3::ZERO; 4];
    for (i, rows) in block.points.iter_mut().enumerate() {
        if i >= usize::from(m.count) {
            clear_point(rows, l);
            continue;
        }
        let p = &m.points[i];
        let s = p.separation;
        let ra = p.arm;
        let rb = ra - m.offset;
        levers[i] = ra;
        let mass = set_jacobian(&mut rows.j, l, normal, ra, rb, a, b);
        rows.separation[l] = s;
        rows.mass[l] = mass;
        rows.impulse[l] = p.impulse * k.warm;
        rows.total[l] = 0.0;
        let vn = normal.dot(b.state.v - a.state.v)
            + ra.cross(normal).dot(-a.state.w)
            + rb.cross(normal).dot(b.state.w);
        rows.rebound[l] = 0.0;
        rows.approach[l] = -vn;
        if m.surface.restitution > 0.0 && vn < 0.0 {
            let (speed, half) = impact_speed(-vn, acceleration, s, k.h);
            if speed > k.restitution_speed {
                rows.rebound[l] = m.surface.restitution * speed + half;
                block.any_rebound = true;
            }
        }
        // A point about to open counts less, so that the friction centre moves smoothly; those beyond twice the
        // margin are only there for continuous collision.
        let weight = f32s::clamp(2.0 - s * k.inv_margin, 1e-10, 1.0);
        center += ra * weight;
        weights += weight;
    }
    let center = center / weights;
    for (i, rows) in block.points.iter_mut().enumerate().take(usize::from(m.count)) {
        rows.lever[l] = (levers[i] - center).length();
    }
    center
}

fn clear_point(rows: &mut super::rows::PointRows, l: usize) {
    rows.mass[l] = 0.0;
    rows.impulse[l] = 0.0;
    rows.total[l] = 0.0;
    rows.separation[l] = 0.0;
    rows.rebound[l] = 0.0;
    rows.lever[l] = 0.0;
    for v in [&mut rows.j.a, &mut rows.j.b, &mut rows.j.ia, &mut rows.j.ib] {
        v.set(l, Vec3::ZERO);
    }
}

/// Sets a direction's Jacobian and gives its effective mass.
fn set_jacobian(j: &mut Jacobian, l: usize, dir: Vec3, ra: Vec3, rb: Vec3, a: &Side, b: &Side) -> f32 {
    let (ja, jb) = (ra.cross(dir), rb.cross(dir));
    let (ia, ib) = (a.inertia.mul(ja), b.inertia.mul(jb));
    j.a.set(l, ja);
    j.b.set(l, jb);
    j.ia.set(l, ia);
    j.ib.set(l, ib);
    let k = a.inertia.inv_mass + b.inertia.inv_mass + ja.dot(ia) + jb.dot(ib);
    if k > 0.0 { 1.0 / k } else { 0.0 }
}

fn fill_friction(
    block: &mut Block,
    l: usize,
    m: &ContactManifold,
    axes: [Vec3; 3],
    center: Vec3,
    sides: [&Side; 2],
    k: &StepConstants,
) {
    let [normal, t1, t2] = axes;
    let [a, b] = sides;
    let (ra, rb) = (center, center - m.offset);
    set_jacobian(&mut block.friction[0], l, t1, ra, rb, a, b);
    set_jacobian(&mut block.friction[1], l, t2, ra, rb, a, b);
    let [f1, f2] = &block.friction;
    let m0 = a.inertia.inv_mass + b.inertia.inv_mass;
    let xx = m0 + f1.a.get(l).dot(f1.ia.get(l)) + f1.b.get(l).dot(f1.ib.get(l));
    let yy = m0 + f2.a.get(l).dot(f2.ia.get(l)) + f2.b.get(l).dot(f2.ib.get(l));
    let xy = f1.a.get(l).dot(f2.ia.get(l)) + f1.b.get(l).dot(f2.ib.get(l));
    let det = xx * yy - xy * xy;
    let inv = if det > 0.0 { 1.0 / det } else { 0.0 };
    block.friction_mass[0][l] = yy * inv;
    block.friction_mass[1][l] = -xy * inv;
    block.friction_mass[2][l] = xx * inv;
    block.friction_impulse[0][l] = m.friction.dot(t1) * k.warm;
    block.friction_impulse[1][l] = m.friction.dot(t2) * k.warm;
    block.friction_total[0][l] = 0.0;
    block.friction_total[1][l] = 0.0;
    block.surface_speed[0][l] = m.surface.velocity.dot(t1);
    block.surface_speed[1][l] = m.surface.velocity.dot(t2);
    block.mu[l] = if m.stick { m.surface.static_friction } else { m.surface.kinetic_friction };
    let (ia, ib) = (a.inertia.mul(normal), b.inertia.mul(normal));
    let kt = normal.dot(ia) + normal.dot(ib);
    block.twist_ia.set(l, ia);
    block.twist_ib.set(l, ib);
    block.twist_mass[l] = if kt > 0.0 { 1.0 / kt } else { 0.0 };
    block.twist_impulse[l] = m.twist * k.warm;
    block.twist_patch[l] = m.surface.twist_friction;
    block.rolling[l] = m.surface.rolling_friction;
    if m.surface.rolling_friction > 0.0 {
        block.any_rolling = true;
        let sum = a.inertia.to_mat3() + b.inertia.to_mat3();
        set_symmetric(&mut block.rolling_mass, l, &sum.inverse().unwrap_or(Mat3::ZERO));
        set_symmetric(&mut block.rolling_ia, l, &a.inertia.to_mat3());
        set_symmetric(&mut block.rolling_ib, l, &b.inertia.to_mat3());
    }
    block.rolling_impulse.set(l, m.rolling * k.warm);
}

fn set_symmetric(t: &mut [Lane; 6], l: usize, m: &Mat3) {
    let values = [m.cx.x, m.cy.y, m.cz.z, m.cy.x, m.cz.x, m.cz.y];
    for (field, v) in t.iter_mut().zip(values) {
        field[l % LANES] = v;
    }
}
