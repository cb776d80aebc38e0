//! A hand that drags a body by a point.

use crate::error::{Error, Result};
use crate::handle::{BodyId, JointId};
use crate::limits;
use crate::room::joints::desc::{AxisDesc, JointDesc, JointFrames, JointKind, MotorDesc, SpringDesc};
use crate::room::rigid::desc::{BodyDesc, check_position};
use crate::world::World;
use jounce_math::{DVec3, Pose, Quat, WorldPose};
use jounce_tasks::FloatEnv;

/// A hold on a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grab {
    /// The kinematic point that leads.
    pub hand: BodyId,
    /// The springs between it and the body.
    pub joint: JointId,
}

impl World {
    /// Takes hold of a body at a world point: springs of `spring` along each axis, with at most `max_force` newtons each, to a
    /// hand that [`World::drag`] moves (as a mouse does). The point is within [`limits::GRAB_REACH_MAX`] of the centre of mass, or within
    /// ten times the distance of the body's outermost point, where that is more.
    ///
    /// # Errors
    /// A stale handle, or a value out of range, named; nothing is added then.
    pub fn grab(&mut self, body: BodyId, at: DVec3, spring: SpringDesc, max_force: f32) -> Result<Grab> {
        let _mode = FloatEnv::set_default();
        check_position(at)?;
        let pose = self.body(body)?.pose();
        let slot = body.index;
        let outermost = 10.0 * f64::from(self.bodies[slot].mass.outer_radius);
        let most = if outermost > limits::GRAB_REACH_MAX { outermost } else { limits::GRAB_REACH_MAX };
        let away = (at - self.frames[slot as usize].center).length();
        let expected = "within 10 m, or ten of its own radii, of the body's centre of mass";
        if away > most {
            let value = format!("{away} m away");
            return Err(Error::BadValue { what: "grab", field: "point", value, expected });
        }
        let hand = self.add_body(BodyDesc::kinematic().at(at).name("hand"))?;
        let axis = AxisDesc::FREE.motor(MotorDesc::position(0.0, spring, max_force));
        let kind = JointKind::Generic { linear: [axis; 3], angular: [AxisDesc::FREE; 3] };
        let mut d = JointDesc::ball(hand, body, at).kind(kind);
        let on_body = pose.relative(&WorldPose::new(at, Quat::IDENTITY));
        d.frames = JointFrames::Local(Pose::IDENTITY, on_body);
        match self.add_joint(d) {
            Ok(joint) => Ok(Grab { hand, joint }),
            Err(e) => {
                self.remove_body(hand)?;
                Err(e)
            }
        }
    }
    /// Moves the hand to a world point within the next step.
    ///
    /// # Errors
    /// A stale hold, or a point out of range.
    pub fn drag(&mut self, grab: Grab, to: DVec3) -> Result<()> {
        self.move_to(grab.hand, to, Quat::IDENTITY)
    }
    /// Lets go.
    ///
    /// # Errors
    /// A stale hold.
    pub fn let_go(&mut self, grab: Grab) -> Result<()> {
        self.remove_body(grab.hand)
    }
}
