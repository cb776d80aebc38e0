//! A body of a set, and its inertia under tension.

use super::solve::wide;
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
    /// How many joints hold it, and the square of the last one's lever, m².
    pub(super) held: u32,
    pub(super) swung: f32,
    /// Σ of impulses in the pass, then the change that they make, f64: those of a heavy load through light links cancel to a millionth.
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
            held: 0,
            swung: 0.0,
            dv: [0.0; 6],
            before: [Vec3::ZERO; 2],
        }
    }
    /// Keeps of what tension would add only what explicit motion cannot stand. What hangs on one joint alone swings about that, with its mass: however
    /// small it is, a pendulum is no faster than its length.
    pub(super) fn raise_part(&mut self) {
        let Some(inertia) = &self.inertia else {
            self.added_inertia = Mat3::ZERO;
            return;
        };
        let g = 0.5 * trace(&self.added_inertia);
        let mass =
            if self.inv_mass.max_component() > 0.0 { 1.0 / self.inv_mass.max_component() } else { 0.0 };
        let own = 0.5 * trace(inertia) + if self.held == 1 { mass * self.swung } else { 0.0 };
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
    /// What an impulse along `l` and a moment about `j` change, m/s and rad/s: M⁻¹ in f64 throughout. A slender link turns 10⁶ times as
    /// easily about itself as the load at its end; rounded to f32 on the way, the load's part of the matrix would drown.
    pub(super) fn moved_by(&self, l: Vec3, j: Vec3) -> ([f64; 3], [f64; 3]) {
        self.moved(wide(l), wide(j))
    }
    fn moved(&self, l: [f64; 3], j: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let t = &self.tensor;
        let m = wide(self.inv_mass);
        let [xx, yy, zz, xy, xz, yz] = [t.xx, t.yy, t.zz, t.xy, t.xz, t.yz].map(f64::from);
        let turn = [
            xx * j[0] + xy * j[1] + xz * j[2],
            xy * j[0] + yy * j[1] + yz * j[2],
            xz * j[0] + yz * j[1] + zz * j[2],
        ];
        ([m[0] * l[0], m[1] * l[1], m[2] * l[2]], turn)
    }
    /// Adds an impulse to the sums of a pass.
    pub(super) fn push(&mut self, l: Vec3, j: Vec3, lambda: f64) {
        for (i, d) in wide(l).into_iter().chain(wide(j)).enumerate() {
            self.dv[i] += d * lambda;
        }
    }
    /// What the sums of impulses change.
    pub(super) fn changed(&self) -> ([f64; 3], [f64; 3]) {
        let [a, b, c, d, e, f] = self.dv;
        self.moved([a, b, c], [d, e, f])
    }
    /// Sums of impulses to the velocities that they change.
    pub(super) fn give(&mut self) {
        let ([a, b, c], [d, e, f]) = self.changed();
        self.dv = [a, b, c, d, e, f];
    }
    /// It moves along all axes as impulses have it.
    pub fn is_dynamic(&self) -> bool {
        self.row != NONE && self.inv_mass.min_component() > 0.0
    }
    /// Joints can change its velocity.
    pub fn moves(&self) -> bool {
        self.inv_mass != Vec3::ZERO || self.tensor.xx > 0.0 || self.tensor.yy > 0.0 || self.tensor.zz > 0.0
    }
}

fn trace(m: &Mat3) -> f32 {
    m.cx.x + m.cy.y + m.cz.z
}
