//! Jounce: one deterministic world for everything that moves in a game.
//!
//! ```
//! use jounce::prelude::*;
//!
//! # fn main() -> jounce::Result<()> {
//! let mut world = World::new(WorldDesc::default())?;
//! world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
//! let ball = world.add_body(
//!     BodyDesc::dynamic().at([0.0, 5.0, 0.0]).shape(ShapeDesc::sphere(0.11).mass(0.43).restitution(0.8)),
//! )?;
//! for _ in 0..120 {
//!     world.step()?; // 1/60 s; `advance(frame_dt)` for a game loop, with interpolation
//! }
//! println!("{:?} {:#018x}", world.body(ball)?.position(), world.hash());
//! # Ok(())
//! # }
//! ```
//!
//! The same world gives the same bits on every machine and every thread count: see [`World::hash`].
#![forbid(unsafe_code)]

mod command;
mod contact_info;
mod debug_draw;
mod edit;
mod error;
mod event;
mod groups;
mod handle;
mod hash;
mod hooks;
mod islands;
pub mod limits;
mod moving;
mod query;
mod room;
mod settings;
mod stage;
mod step;
mod table;
mod validate;
mod view;
mod world;

pub use command::{Command, Output};
pub use contact_info::{ContactInfo, ContactPoint, ManifoldInfo};
pub use debug_draw::{DebugColor, DebugDraw, DebugDrawOptions};
pub use error::{Error, Result};
pub use event::Event;
pub use handle::{BodyId, CharacterId, EmitterId, FieldId, JointId, ShapeId, VehicleId};
pub use hash::StateHasher;
pub use hooks::{ContactHook, ContactView, FilterHook, PairView, ParticleHook};
pub use query::{ClosestPoint, QueryFilter, Ray, RayCastHit, ShapeCastHit};
pub use room::characters::desc::{
    CharacterDesc, CharacterGround, CharacterHit, CharacterInput, CharacterKind, CharacterMove,
    CharacterMover,
};
pub use room::characters::view::CharacterRef;
pub use room::contacts::desc::{Combine, Filter, MassSpec, Material, ShapeDesc};
pub use room::contacts::state::Surface;
pub use room::fields::desc::{
    AIR_DENSITY, AIR_VISCOSITY, Aero, Explosion, FieldDesc, FieldLaw, Gust, Region, WATER_DENSITY,
    WATER_VISCOSITY,
};
pub use room::fields::point::FieldSample;
pub use room::fields::state::{FieldHook, FieldView};
pub use room::joints::desc::{
    AxisDesc, BallDesc, BallMotor, JointDesc, JointFrames, JointKind, JointSolver, LimitDesc, MotorDesc,
    MotorTarget, PathDesc, SpringDesc,
};
pub use room::joints::glue::GlueDesc;
pub use room::joints::view::JointRef;
pub use room::particles::desc::{
    Burst, Curve, EmitDirection, EmitterDesc, EmitterShape, Gradient, Heat, HitResponse, ParticleCollision,
    ParticleSpawn, Turbulence,
};
pub use room::particles::presets as particles;
pub use room::particles::view::{EmitterRef, ParticleSlices, ParticleView};
pub use room::ragdoll::desc::{BoneDesc, BoneJoint, BoneJointKind, Ragdoll, RagdollDesc};
pub use room::ragdoll::grab::Grab;
pub use room::ragdoll::pose::{BonePose, PoseDrive, blend_poses};
pub use room::rigid::desc::{AxisLocks, BodyDesc, BodyKind};
pub use room::vehicles::desc::{
    AeroSurfaceDesc, AntiRollDesc, BoardDesc, ClutchDesc, DifferentialDesc, DifferentialKind, DriveDesc,
    EngineDesc, GearboxDesc, LeanDesc, SlipControlDesc, TrackDesc, TrackSteerDesc, TyreDesc, VehicleDesc,
    VehicleInput, WheelCast, WheelDesc,
};
pub use room::vehicles::presets as vehicles;
pub use room::vehicles::view::{VehicleRef, VehicleTelemetry, WheelTelemetry};
pub use settings::{Settings, WorldDesc};
pub use step::{Stage, StageHashes, StageObserver};
pub use view::{BodyRef, ShapeRef};
pub use world::{Advance, Counts, Energy, Momentum, World};

pub use jounce_geometry as geometry;
pub use jounce_lanes::Width;
pub use jounce_math as math;
pub use jounce_tasks as tasks;

/// What most programs need.
pub mod prelude {
    pub use crate::{
        Advance, Aero, AxisLocks, BodyDesc, BodyId, BodyKind, Combine, EmitterDesc, EmitterId, EmitterShape,
        Event, Explosion, FieldDesc, FieldId, FieldLaw, Filter, JointDesc, JointId, JointKind, Material,
        MotorDesc, ParticleCollision, QueryFilter, Ray, Region, ShapeDesc, ShapeId, SpringDesc, VehicleDesc,
        VehicleId, VehicleInput, WheelDesc, World, WorldDesc,
    };
    pub use jounce_geometry::Shape;
    pub use jounce_math::{DVec3, Pose, Quat, Vec3, WorldPose};
    pub use jounce_tasks::Tasks;
}

/// The README's program compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

/// The chapters of the course book that use the engine; the others are in `jounce_motion`.
#[cfg(doctest)]
mod book {
    #[doc = include_str!("../../../docs/book/src/euler.md")]
    struct Euler;
    #[doc = include_str!("../../../docs/book/src/newton.md")]
    struct Newton;
    #[doc = include_str!("../../../docs/book/src/buoyancy.md")]
    struct Buoyancy;
    #[doc = include_str!("../../../docs/book/src/every.md")]
    struct Every;
    #[doc = include_str!("../../../docs/book/src/joints.md")]
    struct Joints;
    #[doc = include_str!("../../../docs/book/src/vehicles.md")]
    struct Vehicles;
    #[doc = include_str!("../../../docs/book/src/characters.md")]
    struct Characters;
    #[doc = include_str!("../../../docs/book/src/breaking.md")]
    struct Breaking;
}
