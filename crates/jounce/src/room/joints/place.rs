//! Places alone: bodies are moved so that C = 0, by Newton's steps in which a velocity is a way and the substep lasts a second.
//! Each body's share is as its mass has it. Velocities and impulses are those of before.

use super::extra::{Extra, Sweep};
use super::rows::turned;
use super::set::{Constants, JointSet};
use super::solve::{HARD, Solve};
use super::state::Joints;
use crate::room::contacts::prepare::Softness;
use crate::room::rigid::state::{Motion, NONE};
use jounce_math::{Mat3, Vec3, scalar::f32s};

/// What [`JointSet::place`] would lose; memory, not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kept {
    motions: Vec<Motion>,
    joints: Vec<([f32; HARD], [f32; HARD], bool)>,
    extra: Vec<(f32, bool)>,
}

/// Of a free set.
struct Spin {
    centre: Vec3,
    angular: Vec3,
    inertia: Mat3,
}

impl JointSet {
    /// Bodies that were put elsewhere come together again, without a change of velocity. Velocities of the copies are lost. Gives the way
    /// of the last step, m or rad.
    pub fn place(&mut self, joints: &Joints) -> f32 {
        let k = Constants {
            h: 1.0,
            warm: 0.0,
            soft: Softness { bias_rate: 1.0, mass_scale: 1.0, impulse_scale: 0.0 },
            push_out: f32::INFINITY,
            correct: f32::INFINITY,
            speed_max: f32::INFINITY,
            spin_max: 2.0 * core::f32::consts::PI,
        };
        let direct = self.plan.is_some();
        let mut way = 0.0;
        // Ways that are cut short let springs between the bodies gain.
        let soft = self.joints.iter().any(|s| s.soft.is_some());
        let alone = if soft { PLACINGS } else { PLACINGS_ALONE };
        for _ in 0..if direct { alone } else { 4 * PLACINGS } {
            self.bodies.iter_mut().for_each(|b| (b.m.v, b.m.w) = (Vec3::ZERO, Vec3::ZERO));
            for s in self.joints.iter_mut().filter(|s| s.rod) {
                s.give_way[1..3].fill(f32::INFINITY);
            }
            self.refresh(joints);
            // Rows that are new have fetched the impulses of the last step.
            for s in &mut self.joints {
                s.lambda = [0.0; HARD];
                s.extra.iter_mut().for_each(|x| x.impulse = 0.0);
            }
            if direct {
                self.direct(joints, &k, Sweep::Place);
            } else {
                for s in &mut self.joints {
                    s.active = true;
                    s.hold(&mut self.bodies, &k, Sweep::Place, true);
                }
            }
            let moving = || self.bodies.iter().filter(|b| b.row != NONE);
            way = moving().map(|b| f32s::max(b.m.v.length(), b.m.w.length())).fold(0.0, f32s::max);
            let part = if soft { 1.0 } else { f32s::min(FARTHEST / way, 1.0) };
            for b in self.bodies.iter_mut().filter(|b| b.row != NONE) {
                let (v, w) = (b.m.v * part, b.m.w * part);
                b.m.dp += v;
                b.m.dr += w;
                b.m.dq = (turned(w) * b.m.dq).normalize();
            }
            if way < PLACED {
                break;
            }
        }
        way
    }

    /// Ends of turns that the motion of the substep has passed are put back at once, and points that it has parted: who runs along the rim
    /// of a narrow cone at 80 rad/s leaves it by ten degrees in a substep, which no velocity at its start foretells.
    pub(super) fn turn_back(&mut self, joints: &Joints, k: &Constants) {
        if self.plan.is_none() {
            return;
        }
        self.refresh(joints);
        let turns = |x: &&Extra| x.is_hard_end() && x.row.la == Vec3::ZERO;
        let beyond = |s: &Solve| s.extra[..s.taken()].iter().filter(turns).any(|x| x.gap() < -BEYOND);
        let gone = self.joints.iter().any(beyond) || self.is_open(GAP * k.correct);
        if !gone || self.is_open(OPEN * k.correct) {
            return;
        }
        self.keep();
        let before = self.spin();
        // What does not come to rest has no solution near by.
        let found = self.place(joints) < NEAR;
        self.recall(!found);
        if found && let (Some(before), Some(after)) = (before, self.spin()) {
            self.turn_all(&after, before.angular - after.angular);
        }
    }

    /// Angular momentum about the centre of mass, of a set that is free and turns about all axes.
    fn spin(&self) -> Option<Spin> {
        let (mut mass, mut centre, mut p) = (0.0, Vec3::ZERO, Vec3::ZERO);
        for b in &self.bodies {
            if !b.is_dynamic() {
                return None;
            }
            let m = 1.0 / b.inv_mass.x;
            mass += m;
            centre += (b.at + b.m.dp) * m;
            p += b.m.v * m;
        }
        let (centre, mean) = (centre / mass, p / mass);
        let mut s = Spin { centre, angular: Vec3::ZERO, inertia: Mat3::ZERO };
        for b in &self.bodies {
            let (m, r) = (1.0 / b.inv_mass.x, b.at + b.m.dp - centre);
            // Since it was looked up.
            let r3 = (b.m.dq * b.loaded_dq.conjugate()).normalize().to_mat3();
            let turned = r3 * b.inertia? * r3.transpose();
            s.angular += r.cross(b.m.v - mean) * m + turned * b.m.w;
            s.inertia = s.inertia + turned + (Mat3::IDENTITY.scale(r.dot(r)) - Mat3::outer(r, r)).scale(m);
        }
        Some(s)
    }

    /// Gives a free set angular momentum as a rigid turn, which no joint notices: places that were put right have not kept it.
    fn turn_all(&mut self, s: &Spin, change: Vec3) {
        let Some(turn) = s.inertia.inverse().map(|i| i * change).filter(|t| t.is_finite()) else { return };
        for b in &mut self.bodies {
            b.m.v += turn.cross(b.at + b.m.dp - s.centre);
            b.m.w += turn;
        }
    }

    fn keep(&mut self) {
        let Self { kept, bodies, joints, .. } = self;
        kept.motions.clear();
        kept.motions.extend(bodies.iter().map(|b| b.m));
        kept.joints.clear();
        kept.joints.extend(joints.iter().map(|s| (s.lambda, s.give_way, s.active)));
        kept.extra.clear();
        kept.extra.extend(joints.iter().flat_map(|s| &s.extra).map(|x| (x.impulse, x.acts)));
    }

    fn recall(&mut self, places: bool) {
        let Self { kept, bodies, joints, .. } = self;
        for (b, m) in bodies.iter_mut().zip(&kept.motions) {
            if places {
                b.m = *m;
            }
            (b.m.v, b.m.w) = (m.v, m.w);
        }
        for (s, k) in joints.iter_mut().zip(&kept.joints) {
            (s.lambda, s.give_way, s.active) = *k;
        }
        for (x, k) in joints.iter_mut().flat_map(|s| &mut s.extra).zip(&kept.extra) {
            (x.impulse, x.acts) = *k;
        }
    }
}

/// How far beyond an end a turn may lead before it is put back, rad.
pub(super) const BEYOND: f32 = 0.01;
/// Sets with points further apart than errors are taken back in this time are put together, s: 2 mm; up to 20 cm.
pub(super) const GAP: f32 = 2e-4;
pub(super) const OPEN: f32 = 0.02;
/// The last of Newton's steps where they have a solution, m or rad.
pub(crate) const NEAR: f32 = 1e-3;
/// Newton's steps at most in lanes and alone, and the way that ends them, m and rad.
pub(super) const PLACINGS: usize = 8;
const PLACINGS_ALONE: usize = 24;
/// The way of one of them at most: what would go further is far from where its rows were measured.
const FARTHEST: f32 = 0.2;
const PLACED: f32 = 1e-6;
