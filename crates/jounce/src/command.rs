//! Every edit of a world as plain data: recording, replay, rollback and the random-world tester use this
//! one path, and the methods of [`crate::World`] are thin sugar over it.

use crate::room::characters::desc::{CharacterDesc, CharacterInput};
use crate::room::contacts::desc::{Filter, Material, ShapeDesc};
use crate::room::fields::desc::{Aero, Explosion, FieldDesc};
use crate::room::joints::desc::{JointDesc, JointKind};
use crate::room::particles::desc::{EmitterDesc, ParticleSpawn};
use crate::room::rigid::desc::{AxisLocks, BodyDesc, BodyKind};
use crate::room::vehicles::desc::{VehicleDesc, VehicleInput};
use crate::settings::Settings;
use crate::{BodyId, CharacterId, EmitterId, FieldId, JointId, ShapeId, VehicleId};
use jounce_geometry::{MassProperties, Shape};
use jounce_math::{DVec3, Pose, Quat, Vec3};

/// One edit. Acts at once, between steps, by [`crate::World::apply`]; or at the start of the next step, by
/// [`crate::World::queue`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Command {
    /// Adds a body; gives [`Output::Body`].
    AddBody(Box<BodyDesc>),
    /// Removes a body with its shapes and contacts.
    RemoveBody(BodyId),
    /// Adds a shape to a body; gives [`Output::Shape`].
    AddShape(BodyId, Box<ShapeDesc>),
    /// Removes a shape.
    RemoveShape(ShapeId),
    /// Puts a body somewhere at once; resets interpolation; wakes what it touched.
    Teleport(BodyId, DVec3, Quat),
    /// Kinematic bodies: moves to a pose within the next step, pushing what is in the way.
    MoveTo(BodyId, DVec3, Quat),
    /// Sets the velocity of the centre of mass, m/s.
    SetVelocity(BodyId, Vec3),
    /// Sets the angular velocity, rad/s.
    SetAngularVelocity(BodyId, Vec3),
    /// Adds a force (N) for the next step; at a world point, or through the centre of mass.
    AddForce(BodyId, Vec3, Option<DVec3>),
    /// Adds a torque (N m) for the next step.
    AddTorque(BodyId, Vec3),
    /// Changes the momentum at once (N s); at a world point, or through the centre of mass.
    AddImpulse(BodyId, Vec3, Option<DVec3>),
    /// Changes the angular momentum at once (N m s).
    AddAngularImpulse(BodyId, Vec3),
    /// Changes how a body moves.
    SetKind(BodyId, BodyKind),
    /// Takes a body out of the simulation, or back in.
    SetBodyEnabled(BodyId, bool),
    /// Sets linear and angular damping, 1/s.
    SetDamping(BodyId, f32, f32),
    /// Sets the factor on gravity.
    SetGravityScale(BodyId, f32),
    /// Sets locked axes.
    SetLocks(BodyId, AxisLocks),
    /// Overrides the mass, or (`None`) goes back to the sum over the shapes.
    SetMass(BodyId, Option<MassProperties>),
    /// Continuous collision against moving bodies too.
    SetBullet(BodyId, bool),
    /// May the body sleep?
    SetCanSleep(BodyId, bool),
    /// Sets the caller's number.
    SetUserData(BodyId, u128),
    /// Sets the name.
    SetName(BodyId, Option<String>),
    /// Wakes a body and what sleeps with it.
    Wake(BodyId),
    /// Puts a body, and all that rests with it, to sleep at once.
    Sleep(BodyId),
    /// Swaps the geometry of a shape.
    SetShape(ShapeId, Box<Shape>),
    /// Moves a shape on its body.
    SetShapePose(ShapeId, Pose),
    /// Takes a shape out of the simulation, or back in.
    SetShapeEnabled(ShapeId, bool),
    /// Sets a shape's surface.
    SetMaterial(ShapeId, Material),
    /// Sets whom a shape meets.
    SetFilter(ShapeId, Filter),
    /// Sets how a shape meets the medium around it; wakes its body.
    SetAero(ShapeId, Aero),
    /// Adds a field; gives [`Output::Field`]; wakes everything.
    AddField(Box<FieldDesc>),
    /// Removes a field; wakes everything.
    RemoveField(FieldId),
    /// Replaces a field's description; wakes everything.
    SetField(FieldId, Box<FieldDesc>),
    /// Lets off a blast.
    Explode(Explosion),
    /// Adds an emitter of particles; gives [`Output::Emitter`].
    AddEmitter(Box<EmitterDesc>),
    /// Removes an emitter with its particles.
    RemoveEmitter(EmitterId),
    /// Replaces an emitter's description; its particles stay, and its clock goes on.
    SetEmitter(EmitterId, Box<EmitterDesc>),
    /// Stops an emitter's births and its clock, or lets them go on.
    SetEmitterEnabled(EmitterId, bool),
    /// So many births at once, of age 0 at the end of the last step.
    EmitBurst(EmitterId, u32),
    /// Adds particles as given.
    EmitParticles(EmitterId, Vec<ParticleSpawn>),
    /// Removes all particles of an emitter, or (`None`) of all.
    ClearParticles(Option<EmitterId>),
    /// Adds a joint; gives [`Output::Joint`]; wakes its bodies.
    AddJoint(Box<JointDesc>),
    /// Removes a joint, and the gears on it; wakes its bodies.
    RemoveJoint(JointId),
    /// Replaces a joint's kind by another of the same name: ends, motors, springs; wakes its bodies.
    SetJoint(JointId, Box<JointKind>),
    /// Takes a joint out of the simulation, or back in (a broken one too).
    SetJointEnabled(JointId, bool),
    /// Adds a vehicle to a body; gives [`Output::Vehicle`]; wakes it.
    AddVehicle(Box<VehicleDesc>),
    /// Removes a vehicle; its chassis stays.
    RemoveVehicle(VehicleId),
    /// Replaces a vehicle's description by another with as many wheels; wakes it.
    SetVehicle(VehicleId, Box<VehicleDesc>),
    /// What the driver does from now on; a change wakes the vehicle.
    SetVehicleInput(VehicleId, VehicleInput),
    /// Takes a vehicle out of the simulation, or back in; its wheels start anew.
    SetVehicleEnabled(VehicleId, bool),
    /// Adds a character with its body; gives [`Output::Character`].
    AddCharacter(Box<CharacterDesc>),
    /// Removes a character with its body.
    RemoveCharacter(CharacterId),
    /// What a character is asked to do from the next step on.
    SetCharacterInput(CharacterId, CharacterInput),
    /// Replaces a character's description, but for its kind, place, heading, name and number.
    SetCharacter(CharacterId, Box<CharacterDesc>),
    /// Sets the world's gravity, m/s²; wakes everything.
    SetGravity(Vec3),
    /// Sets the solver's constants; wakes everything.
    SetSettings(Box<Settings>),
}

/// What a command gives back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Nothing.
    Done,
    /// The new body.
    Body(BodyId),
    /// The new shape.
    Shape(ShapeId),
    /// The new field.
    Field(FieldId),
    /// The new emitter.
    Emitter(EmitterId),
    /// The new joint.
    Joint(JointId),
    /// The new vehicle.
    Vehicle(VehicleId),
    /// The new character.
    Character(CharacterId),
}
