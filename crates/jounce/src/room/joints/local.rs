//! A body of a set, and its inertia under tension.

use crate::room::rigid::state::{InvInertia, Motion, NONE, Turning};
use jounce_math::{Mat3, Quat, Vec3};

/// A body of a set.
#[derive(Clone, Debug)]
pub(crate) struct Local {
    pub slot: u32,
    /// Awake row, or NONE for what does not move.
    pub row: u32,
    pub m: Motion,
    /// Centre of mass at the start of the step, from that of the set's first body.
    pub at: Vec3,
    /// Inverse mass along each world axis: 0 along locked ones.
    pub inv_mass: Vec3,
    pub tensor: InvInertia,
    /// Torque-free memory, and the velocity it was told last.
    pub turning: Option<Turning>,
    /// Turns freely: inertia follows the rotation.
    pub free: bool,
    /// Both as the step began.
    pub start_inv_mass: Vec3,
    pub start_tensor: InvInertia,
    /// Turns are unlocked.
    pub turns: bool,
    /// World inertia now, where it may be raised: turns unlocked.
    pub inertia: Option<Mat3>,
    /// Rotation since the start of the step that it belongs to.
    pub loaded_dq: Quat,
    /// What tension adds to inertia in this substep.
    pub(super) added_inertia: Mat3,
    /// Σ of the pass, f64: impulses of a heavy load through light links cancel to a millionth.
    pub(super) dv: [f64; 6],
    /// Velocities that the rounds of the active set start from.
    pub(super) before: [Vec3; 2],
}

impl Local {
    pub fn new(slot: u32) -> Self {
        let m = crate::room::rigid::state::BodyState::FIXED.get();
        Self {
            slot,
            row: NONE,
            m,
            at: Vec3::ZERO,
            inv_mass: Vec3::ZERO,
            tensor: InvInertia::default(),
            turning: None,
            free: false,
            start_inv_mass: Vec3::ZERO,
            start_tensor: InvInertia::default(),
            turns: false,
            inertia: None,
            loaded_dq: Quat::IDENTITY,
            added_inertia: Mat3::ZERO,
            dv: [0.0; 6],
            before: [Vec3::ZERO; 2],
        }
    }
    /// Keeps of what tension would add only what explicit motion cannot stand.
    pub(super) fn raise_part(&mut self) {
        let Some(inertia) = &self.inertia else {
            self.added_inertia = Mat3::ZERO;
            return;
        };
        let g = 0.5 * trace(&self.added_inertia);
        let own = 0.5 * trace(inertia);
        let part = if g > own { 1.0 - own / g } else { 0.0 };
        self.added_inertia = self.added_inertia.scale(part);
    }
    /// Inertia with what tension adds.
    pub(super) fn apply_added(&mut self) {
        if self.added_inertia == Mat3::ZERO {
            return;
        }
        if let Some(inv) = self.inertia.and_then(|i| (i + self.added_inertia).inverse()) {
            self.tensor = InvInertia {
                xx: inv.cx.x,
                yy: inv.cy.y,
                zz: inv.cz.z,
                xy: 0.5 * (inv.cx.y + inv.cy.x),
                xz: 0.5 * (inv.cx.z + inv.cz.x),
                yz: 0.5 * (inv.cy.z + inv.cz.y),
                ..self.tensor
            };
        }
    }
    /// Joints can change its velocity.
    pub fn moves(&self) -> bool {
        self.inv_mass != Vec3::ZERO || self.tensor.xx > 0.0 || self.tensor.yy > 0.0 || self.tensor.zz > 0.0
    }
}

pub(super) fn add(b: &mut Local, l: Vec3, i: Vec3, lambda: f64) {
    for k in 0..3 {
        b.dv[k] += f64::from(l[k]) * f64::from(b.inv_mass[k]) * lambda;
        b.dv[k + 3] += f64::from(i[k]) * lambda;
    }
}

fn trace(m: &Mat3) -> f32 {
    m.cx.x + m.cy.y + m.cz.z
}
