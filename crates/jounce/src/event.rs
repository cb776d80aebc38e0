//! What happened in a step, in an order that is part of the hash.

use crate::{BodyId, EmitterId, JointId, ShapeId};
use jounce_math::{DVec3, Vec3};

/// Something that happened in a step, or by an edit between steps: that is told with the next step's events, before them. See
/// [`crate::World::events`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// Two shapes began to touch.
    ContactBegin {
        /// First shape (the older handle).
        a: ShapeId,
        /// Second shape.
        b: ShapeId,
    },
    /// Two shapes no longer touch, or one of them was removed or disabled.
    ContactEnd {
        /// First shape (may be stale by now).
        a: ShapeId,
        /// Second shape (may be stale by now).
        b: ShapeId,
    },
    /// Two shapes met faster than `Settings::hit_event_speed`.
    ContactHit {
        /// First shape.
        a: ShapeId,
        /// Second shape.
        b: ShapeId,
        /// Where, in the world.
        point: DVec3,
        /// Unit normal from a to b.
        normal: Vec3,
        /// Approach speed along the normal, m/s.
        speed: f32,
        /// Normal impulse of the contact over the step, N s.
        impulse: f32,
    },
    /// A shape entered a sensor.
    SensorEnter {
        /// The sensor.
        sensor: ShapeId,
        /// The visitor.
        visitor: ShapeId,
    },
    /// A shape left a sensor (or one of the two was removed or disabled).
    SensorLeave {
        /// The sensor (may be stale by now).
        sensor: ShapeId,
        /// The visitor (may be stale by now).
        visitor: ShapeId,
    },
    /// A body fell asleep.
    Sleep {
        /// The body.
        body: BodyId,
    },
    /// A body woke up.
    Wake {
        /// The body.
        body: BodyId,
    },
    /// A body's state was no longer finite, or left the world's bounds; it was put back to its last good pose
    /// and disabled. Everything else goes on.
    Quarantine {
        /// The body.
        body: BodyId,
    },
    /// A body reached the speed limit `Settings::linear_speed_max` or the spin limit `Settings::rotation_per_step_max` and was
    /// held to it; in every step in which that was so. Not told of kinematic bodies on their way to a pose
    /// ([`crate::World::move_to`]): those arrive.
    SpeedLimited {
        /// The body.
        body: BodyId,
    },
    /// A particle met a shape: [`crate::ParticleCollision::hit_events`].
    ParticleHit {
        /// Whose particle.
        emitter: EmitterId,
        /// What it met.
        shape: ShapeId,
        /// Where, in the world.
        point: DVec3,
        /// Unit normal out of the shape.
        normal: Vec3,
        /// Approach speed along the normal, m/s.
        speed: f32,
    },
    /// All births that time brings are over, or the emitter's body is gone.
    EmitterFinished {
        /// The emitter; removed by now if it was to remove itself and had no particle left.
        emitter: EmitterId,
    },
    /// A joint was loaded beyond what it stands, and let go. It stays in the world, broken, until it is removed or enabled again.
    JointBreak {
        /// The joint.
        joint: JointId,
        /// Mean force over the step, N.
        force: f32,
        /// Mean torque over the step, N m.
        torque: f32,
    },
    /// A bound of [`crate::limits`] was reached inside the step; the step went on without the excess.
    LimitReached {
        /// What was bounded.
        what: &'static str,
    },
}
