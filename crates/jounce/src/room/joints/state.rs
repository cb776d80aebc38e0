//! Records of joints.

use super::desc::{JointDesc, JointKind, JointSolver};
use super::path::Curve;
use crate::hash::StateHasher;
use crate::table::Table;
use jounce_math::{Pose, Vec3};
use std::sync::Arc;

/// A joint between two bodies.
// What a step writes lies in front.
#[derive(Clone, Debug)]
#[repr(C)]
pub(crate) struct Joint {
    pub body_a: u32,
    pub body_b: u32,
    /// Impulses of the last substep on the rows that hold (iterative solver), and on the others.
    pub hard: [f32; 6],
    pub extra: Vec<f32>,
    /// Size of force and torque in the last substep, for breaking.
    pub last: [f32; 2],
    /// Force, N, and torque about the anchor, N m, on B over the last step.
    pub force: Vec3,
    pub torque: Vec3,
    /// Coordinate of the main axis when last seen (turns of a hinge are counted; length along a path), m or rad.
    pub coordinate: f32,
    pub enabled: bool,
    pub broken: bool,
    /// In the bodies' own frames.
    pub frame_a: Pose,
    pub frame_b: Pose,
    pub desc: JointDesc,
    pub curve: Option<Arc<Curve>>,
}

impl Joint {
    pub fn solver(&self) -> JointSolver {
        self.desc.solver
    }
    /// Rows between the two bodies themselves (gears have theirs between four).
    pub fn is_gear(&self) -> bool {
        matches!(self.desc.kind, JointKind::Gear { .. })
    }
    pub fn acts(&self) -> bool {
        self.enabled && !self.broken
    }
    pub fn forget(&mut self) {
        self.hard = [0.0; 6];
        self.extra.iter_mut().for_each(|x| *x = 0.0);
        (self.force, self.torque, self.last) = (Vec3::ZERO, Vec3::ZERO, [0.0; 2]);
    }
}

/// All joints.
#[derive(Clone, Debug, Default)]
pub(crate) struct Joints {
    pub table: Table<Joint>,
    /// Grows with every change of who is joined to whom and how, and of masses and presence of what is; not state.
    pub version: u64,
    /// Grows with every other change of what a joint is; not state.
    pub edits: u64,
}

impl Joints {
    pub fn is_empty(&self) -> bool {
        self.table.len() == 0
    }
    pub fn hash(&self, h: &mut StateHasher) {
        if self.table.slots() == 0 {
            return;
        }
        for w in self.table.allocator_words() {
            h.pair(w, 8);
        }
        for (i, j) in self.table.iter() {
            h.pair(i, u32::from(j.enabled) | (u32::from(j.broken) << 1));
            h.pair(j.body_a, j.body_b);
            h.pose(&j.frame_a);
            h.pose(&j.frame_b);
            j.hard.iter().chain(&j.extra).for_each(|&x| h.floats(x, 0.0));
            h.floats(j.coordinate, 0.0);
            h.vec3(j.force);
            h.vec3(j.torque);
            h.floats(j.last[0], j.last[1]);
        }
    }
}
