//! Ragdolls: bodies joined as bones are, from a table; driven to poses; dragged by a limb.
//!
//! # Model
//! A bone is a rigid body, a joint holds it to its parent: a ball with a cone for the swing and two ends for the twist about the
//! bone's axis, or a hinge. Nothing here is new matter: a ragdoll is a list of handles, and all that is done to it are commands on
//! bodies and joints.
//!
//! *Pose matching.* The wanted rotation r of a bone in its parent's frame turns the joint's frames by q = q_a⁻¹ r q_b; a spring of
//! given frequency and bounded torque ([`crate::BallMotor`]) pulls the joint there and follows the wanted angular velocity. A hinge
//! follows the twist of q about its axis.
//!
//! *Blending back.* Positions and rotations are mixed bone by bone with an animation's; bones are made kinematic and led there.
//!
//! *Dragging.* A kinematic point and three springs of bounded force, one along each axis of the world, to a point of the body.
//!
//! Sources: Box3D's human (see [`human`]); Dobrowolski 2015 for swing and twist; Zordan and Hodgins, Motion capture-driven
//! simulations that hit and react, 2002, for tracking by springs.

pub(crate) mod desc;
pub(crate) mod grab;
pub(crate) mod human;
pub(crate) mod pose;
