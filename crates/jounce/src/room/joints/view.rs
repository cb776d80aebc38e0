//! What a joint tells.

use super::desc::{JointDesc, JointKind};
use super::state::Joint;
use crate::error::Result;
use crate::handle::{BodyId, JointId};
use crate::world::World;
use jounce_math::{DVec3, Vec3, WorldPose, scalar::f32s};

/// A joint, to be read.
#[derive(Clone, Copy)]
pub struct JointRef<'a> {
    world: &'a World,
    joint: &'a Joint,
}

impl core::fmt::Debug for JointRef<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("JointRef").field("desc", &self.joint.desc).finish_non_exhaustive()
    }
}

impl<'a> JointRef<'a> {
    /// Its description, with the frames in the bodies' own.
    pub fn desc(&self) -> &'a JointDesc {
        &self.joint.desc
    }
    /// Its kind, with ends, motors and springs.
    pub fn kind(&self) -> &'a JointKind {
        &self.joint.desc.kind
    }
    /// The first body.
    pub fn body_a(&self) -> BodyId {
        self.world.body_id(self.joint.body_a)
    }
    /// The second body.
    pub fn body_b(&self) -> BodyId {
        self.world.body_id(self.joint.body_b)
    }
    /// Its name.
    pub fn name(&self) -> Option<&'a str> {
        self.joint.desc.name.as_deref()
    }
    /// The caller's number.
    pub fn user_data(&self) -> u128 {
        self.joint.desc.user_data
    }
    /// Takes part in the simulation: enabled and not broken.
    pub fn is_enabled(&self) -> bool {
        self.joint.acts()
    }
    /// It was loaded beyond what it stands.
    pub fn is_broken(&self) -> bool {
        self.joint.broken
    }
    /// Force on body B at its anchor over the last step, N, world axes: everything the joint does, ends and motors too.
    pub fn force(&self) -> Vec3 {
        self.joint.force
    }
    /// Torque on body B about its anchor over the last step, N m, world axes.
    pub fn torque(&self) -> Vec3 {
        self.joint.torque
    }
    /// Where its main axis stands: the angle of a hinge or wheel (turns are counted) or the twist of a generic joint, rad; the place on a slider or path or
    /// the distance of the anchors, m; the angle between the x axes of a ball joint, rad.
    pub fn coordinate(&self) -> f32 {
        self.world.coordinate(self.joint)
    }
    /// The joint's frame on body A, in the world.
    pub fn frame_a(&self) -> WorldPose {
        self.world.frames[self.joint.body_a as usize].pose().compose(&self.joint.frame_a)
    }
    /// The joint's frame on body B, in the world.
    pub fn frame_b(&self) -> WorldPose {
        self.world.frames[self.joint.body_b as usize].pose().compose(&self.joint.frame_b)
    }
    /// The two anchors in the world, m.
    pub fn anchors(&self) -> [DVec3; 2] {
        [self.frame_a().p, self.frame_b().p]
    }
    /// Points along a path joint's curve in the world, sixteen to a segment; empty for other kinds.
    pub fn curve(&self) -> Vec<DVec3> {
        let Some(curve) = &self.joint.curve else { return Vec::new() };
        let frame = self.frame_a();
        curve.points().map(|p| frame.transform_point(p)).collect()
    }
    /// How far the joint is from holding, m: the part of the anchors' distance that it should keep at zero, or by which a rope is too
    /// long. Springs and gears have none.
    pub fn gap(&self) -> f32 {
        let e = self.world.ends(self.joint);
        let x = e.along(e.axis_a(0)).c;
        match &self.joint.desc.kind {
            JointKind::Fixed | JointKind::Ball(_) | JointKind::Hinge(_) => e.d.length(),
            JointKind::Slider(_) => (e.d - e.axis_a(0) * x).length(),
            JointKind::Distance { min, max } => {
                let l = e.d.length();
                if l < *min {
                    min - l
                } else if l > *max {
                    l - max
                } else {
                    0.0
                }
            }
            JointKind::Generic { linear, .. } => {
                let locked = |i: usize| if linear[i].locked { e.along(e.axis_a(i)).c } else { 0.0 };
                Vec3::new(locked(0), locked(1), locked(2)).length()
            }
            JointKind::Wheel { suspension, .. } => {
                let y = if suspension.locked { e.along(e.axis_a(1)).c } else { 0.0 };
                Vec3::new(x, y, e.along(e.axis_a(2)).c).length()
            }
            JointKind::Path(_) => self.joint.curve.as_ref().map_or(0.0, |curve| {
                let slid = super::path::slide(curve, &e, &mut { self.joint.coordinate }).ends;
                [1, 2].map(|i| slid.along(slid.axis_a(i)).c).iter().map(|c| c * c).sum::<f32>().sqrt()
            }),
            JointKind::Pulley { wheel_a, wheel_b, ratio, length } => {
                let [a, b] = self.anchors();
                let rope = (a - *wheel_a).length() + f64::from(*ratio) * (b - *wheel_b).length();
                f32s::max((rope - f64::from(length.unwrap_or(0.0))) as f32, 0.0)
            }
            JointKind::Spring { .. } | JointKind::Gear { .. } => 0.0,
        }
    }
}

impl World {
    /// A joint, to be read.
    ///
    /// # Errors
    /// A stale handle.
    pub fn joint(&self, id: JointId) -> Result<JointRef<'_>> {
        let slot = self.joint_slot(id)?;
        Ok(JointRef { world: self, joint: &self.joints.table[slot] })
    }
    /// All joints, in slot order.
    pub fn joints(&self) -> impl Iterator<Item = JointId> + '_ {
        self.joints.table.iter().map(|(i, _)| self.joint_id(i))
    }
    /// Joints of a body, in slot order.
    ///
    /// # Errors
    /// A stale handle.
    pub fn joints_of(&self, body: BodyId) -> Result<impl Iterator<Item = JointId> + '_> {
        let slot = self.slot(body)?;
        Ok(self.bodies[slot].joints.iter().map(|&i| self.joint_id(i)))
    }
}
