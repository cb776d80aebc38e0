//! Driving a ragdoll to poses, in whole or in part, and back to an animation.

use super::desc::{Ragdoll, idle, kind};
use crate::error::{Result, check};
use crate::room::joints::desc::SpringDesc;
use crate::room::rigid::desc::{BodyKind, check_rotation, check_spin};
use crate::world::World;
use jounce_math::{Quat, Vec3, WorldPose, scalar::f32s, scalar::f64s};
use jounce_tasks::FloatEnv;

/// Where a bone should be against its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BonePose {
    /// Rotation of the bone in its parent's frame.
    pub rotation: Quat,
    /// Angular velocity against the parent, in its frame, rad/s.
    pub velocity: Vec3,
}

impl BonePose {
    /// At rest in this rotation.
    pub fn at(rotation: Quat) -> Self {
        Self { rotation, velocity: Vec3::ZERO }
    }
    /// Poses of all bones from their rotations in one frame (a root's own is kept as it is), at rest against each other.
    pub fn from_rotations(doll: &Ragdoll, rotations: &[Quat]) -> Vec<Self> {
        let _mode = FloatEnv::set_default();
        let parent = |i: usize| doll.links.get(i)?.as_ref().and_then(|j| rotations.get(j.parent));
        let against = |(i, q): (usize, &Quat)| Self::at(parent(i).map_or(*q, |p| p.inverse_mul(*q)));
        rotations.iter().enumerate().map(against).collect()
    }
}

/// How hard poses are held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseDrive {
    /// Stiffness of every joint.
    pub spring: SpringDesc,
    /// Part of each joint's own strength, 0 or more; 0 is limp but for friction.
    pub strength: f32,
}

impl Default for PoseDrive {
    fn default() -> Self {
        Self { spring: SpringDesc::hertz(8.0, 1.0), strength: 1.0 }
    }
}

/// Twist of a rotation about x, rad.
pub(crate) fn twist(q: Quat) -> f32 {
    let s = if q.w < 0.0 { -1.0 } else { 1.0 };
    2.0 * f32s::atan2(s * q.x, s * q.w)
}

impl Ragdoll {
    fn one_each(&self, given: usize) -> Result<()> {
        let ok = given == self.bodies.len();
        check(ok, "ragdoll", "poses", given, "one for each bone")
    }

    /// Drives every joint towards a pose from the next step on: one command for each joint. `strengths` scales single bones
    /// (all 1 where it is empty).
    ///
    /// # Errors
    /// Not one pose for each bone, a value out of range, or a joint that is gone.
    pub fn drive(
        &self,
        world: &mut World,
        poses: &[BonePose],
        drive: &PoseDrive,
        strengths: &[f32],
    ) -> Result<()> {
        let _mode = FloatEnv::set_default();
        self.one_each(poses.len())?;
        if !strengths.is_empty() {
            self.one_each(strengths.len())?;
        }
        for p in poses {
            check_rotation(p.rotation)?;
            check_spin(p.velocity)?;
        }
        for s in strengths.iter().chain([&drive.strength]) {
            check((0.0..=1e6).contains(s), "ragdoll", "strength", s, "0 to 1e6")?;
        }
        for (i, p) in poses.iter().enumerate() {
            let (Some(j), Some(id)) = (&self.links[i], self.joints[i]) else { continue };
            let (a, b) = (j.on_parent.q.normalize(), j.on_bone.q.normalize());
            let q = (a.conjugate() * p.rotation.normalize() * b).normalize();
            let velocity = a.inverse_rotate(p.velocity);
            let part = drive.strength * strengths.get(i).copied().unwrap_or(1.0);
            world.set_joint(id, kind(j, Some((q, velocity, drive.spring, part))))?;
        }
        Ok(())
    }

    /// Lets every joint go limp, but for its friction and its rest spring.
    ///
    /// # Errors
    /// A joint that is gone.
    pub fn relax(&self, world: &mut World) -> Result<()> {
        for (j, id) in self.links.iter().zip(&self.joints) {
            if let (Some(j), Some(id)) = (j, *id) {
                world.set_joint(id, idle(j))?;
            }
        }
        Ok(())
    }

    /// Makes a bone kinematic (led by [`Ragdoll::lead`]), or dynamic again: a part of the body follows its animation, the rest
    /// hangs on it.
    ///
    /// # Errors
    /// No such bone, or one that is gone.
    pub fn set_led(&self, world: &mut World, bone: usize, led: bool) -> Result<()> {
        let Some(&body) = self.bodies.get(bone) else {
            return check(false, "ragdoll", "bone", bone, "the place of a bone");
        };
        world.set_kind(body, if led { BodyKind::Kinematic } else { BodyKind::Dynamic })
    }

    /// Leads the kinematic bones to these poses within the next step; the others are left alone.
    ///
    /// # Errors
    /// Not one pose for each bone, a pose out of range, or a bone that is gone.
    pub fn lead(&self, world: &mut World, poses: &[WorldPose]) -> Result<()> {
        self.one_each(poses.len())?;
        for (&b, p) in self.bodies.iter().zip(poses) {
            if world.body(b)?.kind() == BodyKind::Kinematic {
                world.move_to(b, p.p, p.q)?;
            }
        }
        Ok(())
    }

    /// Where the bones are.
    ///
    /// # Errors
    /// A bone that is gone.
    pub fn poses(&self, world: &World) -> Result<Vec<WorldPose>> {
        self.bodies.iter().map(|&b| Ok(world.body(b)?.pose())).collect()
    }

    /// Puts all bones somewhere at once, at rest.
    ///
    /// # Errors
    /// Not one pose for each bone, a pose out of range, or a bone that is gone.
    pub fn place(&self, world: &mut World, poses: &[WorldPose]) -> Result<()> {
        self.one_each(poses.len())?;
        for (&b, p) in self.bodies.iter().zip(poses) {
            world.teleport(b, p.p, p.q)?;
            world.set_velocity(b, Vec3::ZERO)?;
            world.set_angular_velocity(b, Vec3::ZERO)?;
        }
        Ok(())
    }
}

/// Between two poses of a skeleton: 0 is the first (what physics made of it), 1 the second (what the animation wants). Lead the bones
/// there over some frames to get up.
pub fn blend_poses(from: &[WorldPose], to: &[WorldPose], weight: f32) -> Vec<WorldPose> {
    let _mode = FloatEnv::set_default();
    let t = f32s::clamp(weight, 0.0, 1.0);
    let mix = |(a, b): (&WorldPose, &WorldPose)| {
        WorldPose::new(a.p.lerp(b.p, f64s::clamp(f64::from(t), 0.0, 1.0)), a.q.nlerp(b.q, t))
    };
    from.iter().zip(to).map(mix).collect()
}
