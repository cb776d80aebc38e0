//! Read-only views of bodies and shapes.

use crate::error::Result;
use crate::handle::{BodyId, ShapeId};
use crate::room::contacts::desc::{Filter, Material};
use crate::room::contacts::state::ShapeRecord;
use crate::room::rigid::desc::{AxisLocks, BodyKind};
use crate::room::rigid::state::{Body, BodyFrame, NONE};
use crate::world::World;
use jounce_geometry::{MassProperties, Shape};
use jounce_math::{DVec3, Pose, Quat, Vec3, WorldPose};

/// A body, to look at.
#[derive(Clone, Copy, Debug)]
pub struct BodyRef<'a> {
    world: &'a World,
    body: &'a Body,
    frame: &'a BodyFrame,
    id: BodyId,
}

/// A shape, to look at.
#[derive(Clone, Copy, Debug)]
pub struct ShapeRef<'a> {
    world: &'a World,
    shape: &'a ShapeRecord,
    id: ShapeId,
}

impl World {
    /// A body by its handle.
    ///
    /// # Errors
    /// A stale handle.
    pub fn body(&self, body: BodyId) -> Result<BodyRef<'_>> {
        let slot = self.slot(body)?;
        Ok(BodyRef { world: self, body: &self.bodies[slot], frame: &self.frames[slot as usize], id: body })
    }
    /// A shape by its handle.
    ///
    /// # Errors
    /// A stale handle.
    pub fn shape(&self, shape: ShapeId) -> Result<ShapeRef<'_>> {
        let slot = self.shape_slot(shape)?;
        Ok(ShapeRef { world: self, shape: &self.shapes[slot], id: shape })
    }
    /// The first body (in slot order) with this name.
    pub fn body_named(&self, name: &str) -> Option<BodyId> {
        let found = self.bodies.iter().find(|(_, b)| b.name.as_deref() == Some(name));
        found.map(|(i, _)| self.body_id(i))
    }
}

impl<'a> BodyRef<'a> {
    /// Its handle.
    pub fn id(&self) -> BodyId {
        self.id
    }
    /// Position of the body's origin in the world, m.
    pub fn position(&self) -> DVec3 {
        self.frame.pose().p
    }
    /// Rotation.
    pub fn rotation(&self) -> Quat {
        self.frame.rotation
    }
    /// Position of the origin and rotation.
    pub fn pose(&self) -> WorldPose {
        self.frame.pose()
    }
    /// Pose between the last two steps, `alpha` from [`crate::Advance`]: 0 is the step before, 1 the last.
    pub fn interpolated_pose(&self, alpha: f64) -> WorldPose {
        let (a, b) = (self.frame.pose0(), self.frame.pose());
        let alpha = jounce_math::scalar::f64s::clamp(alpha, 0.0, 1.0);
        WorldPose::new(a.p.lerp(b.p, alpha), a.q.nlerp(b.q, alpha as f32))
    }
    /// Centre of mass in the world, m.
    pub fn center_of_mass(&self) -> DVec3 {
        self.frame.center
    }
    /// Velocity of the centre of mass, m/s: at most `Settings::linear_speed_max`, as in contacts; so too of a kinematic body that
    /// [`World::move_to`] took farther in a step.
    pub fn velocity(&self) -> Vec3 {
        self.world.velocities(self.body).0
    }
    /// Angular velocity, world axes, rad/s; limited likewise, by `Settings::rotation_per_step_max`.
    pub fn angular_velocity(&self) -> Vec3 {
        self.world.velocities(self.body).1
    }
    /// Velocity of the body's material at a world point, m/s.
    pub fn velocity_at(&self, point: DVec3) -> Vec3 {
        let (v, w) = self.world.velocities(self.body);
        v + w.cross((point - self.frame.center).as_vec3())
    }
    /// How it moves.
    pub fn kind(&self) -> BodyKind {
        self.body.kind
    }
    /// Mass, kg; 0 for fixed and kinematic bodies.
    pub fn mass(&self) -> f32 {
        self.body.mass.mass
    }
    /// Mass, centre of mass (body frame) and inertia about it.
    pub fn mass_properties(&self) -> MassProperties {
        MassProperties {
            mass: self.body.mass.mass,
            center: self.frame.local_center,
            inertia: self.body.mass.inertia,
        }
    }
    /// Takes part in the steps at present.
    pub fn is_awake(&self) -> bool {
        self.body.row != NONE
    }
    /// Was not taken out of the simulation.
    pub fn is_enabled(&self) -> bool {
        self.body.enabled
    }
    /// Continuous collision against moving bodies too.
    pub fn is_bullet(&self) -> bool {
        self.body.bullet
    }
    /// Linear and angular damping, 1/s.
    pub fn damping(&self) -> (f32, f32) {
        (self.body.linear_damping, self.body.angular_damping)
    }
    /// Factor on gravity.
    pub fn gravity_scale(&self) -> f32 {
        self.body.gravity_scale
    }
    /// Locked axes.
    pub fn locks(&self) -> AxisLocks {
        self.body.locks
    }
    /// The caller's number.
    pub fn user_data(&self) -> u128 {
        self.body.user_data
    }
    /// Name, if one was given.
    pub fn name(&self) -> Option<&'a str> {
        self.body.name.as_deref()
    }
    /// Its shapes, in order of attachment.
    pub fn shapes(&self) -> impl Iterator<Item = ShapeId> + 'a {
        let world = self.world;
        self.body.shapes.iter().map(move |&s| world.shape_id(s))
    }
    /// Kinetic energy, J.
    pub fn kinetic_energy(&self) -> f64 {
        let (v, w) = self.world.velocities(self.body);
        let q = self.frame.rotation.as_dquat().normalize();
        let local = q.inverse_rotate(w.as_dvec3());
        let spin = local.dot(self.body.mass.inertia.as_dmat3() * local);
        0.5 * f64::from(self.body.mass.mass) * v.as_dvec3().length_squared() + 0.5 * spin
    }
}

impl<'a> ShapeRef<'a> {
    /// Its handle.
    pub fn id(&self) -> ShapeId {
        self.id
    }
    /// The body it is on.
    pub fn body(&self) -> BodyId {
        self.world.body_id(self.shape.body)
    }
    /// Geometry.
    pub fn shape(&self) -> &'a Shape {
        &self.shape.shape
    }
    /// Pose in the body's frame.
    pub fn pose(&self) -> Pose {
        self.shape.pose
    }
    /// Pose in the world.
    pub fn world_pose(&self) -> WorldPose {
        self.world.frames[self.shape.body as usize].shape_pose(&self.shape.pose)
    }
    /// Surface.
    pub fn material(&self) -> &'a Material {
        &self.shape.material
    }
    /// Whom it meets.
    pub fn filter(&self) -> Filter {
        self.shape.filter
    }
    /// Reports who is inside, touches nobody.
    pub fn is_sensor(&self) -> bool {
        self.shape.sensor
    }
    /// Was not taken out of the simulation.
    pub fn is_enabled(&self) -> bool {
        self.shape.enabled
    }
    /// The caller's number.
    pub fn user_data(&self) -> u128 {
        self.shape.user_data
    }
    /// Sensors: who is inside, by slot.
    pub fn visitors(&self) -> impl Iterator<Item = ShapeId> + 'a {
        self.shape.visitors.iter().map(|&(index, generation)| ShapeId { index, generation })
    }
}
