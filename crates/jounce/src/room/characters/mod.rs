//! Characters: upright capsules that walk, climb steps, ride platforms and push what is in their way.
//!
//! # Model
//! A capsule of radius r stands on its foot point p along the unit vector u ("up"). It keeps a gap s (`skin`) to everything, so
//! that a motion along a floor touches nothing of the floor, and no edge between two tiles of it can be caught on. One move is
//!
//! 1. *push out*: every surface nearer than s gives a plane n·x ≥ s − gap; the shortest x that satisfies all of them is made;
//! 2. *across*: the wanted displacement is swept; each hit adds a plane, and the rest of the way is the nearest point to it that
//!    all planes allow ([`planes`]). Ground that may be walked on (n·u ≥ cos `slope_max`) turns the way along itself; steeper ground
//!    counts as a wall, n ← (n − u n·u)/|…|, so that walking never climbs it;
//! 3. *step up*: at a wall, up by at most `step_height`, on, and down again: kept where that ends on ground to walk on;
//! 4. *along u*: up until a ceiling; or down, sliding along what is too steep; or, standing, down onto the ground within `snap`.
//!
//! Whether an edge carries is asked of the face behind it: a contact on an edge has any normal between those of its faces.
//!
//! A character of the world ([`desc::CharacterDesc`]) is a kinematic body that this move leads, or a dynamic one on a leg: an
//! upright body that floats at its step height on a spring, x″ = −ω² x − 2ζω x′ taken implicitly, and is driven by a force of
//! bounded size, each with its reaction on what it stands on ([`leg`]).
//!
//! # Pushing
//! A walker meets a body of mass m with a closing speed c along −n: it gives the impulse min(c m_eff, F Δt), F its `push_force`, and
//! stops at the skin, so the body gives way by its own velocity. A body that comes on is slowed by as much; of what it has left the
//! character yields all to one heavier than itself, and the share m/M to a lighter one.
//!
//! # Sources
//! Collide and slide with clip planes: id Software, Quake, `SV_FlyMove`, 1996; Fauerby, Improved collision detection and response,
//! 2003. Planes and movers: Catto, Box2D v3.1 and Box3D, character movers. Steps: Rouwe, Jolt Physics, `CharacterVirtual`. Floating
//! leg: Toyful Games, Making a physics based character controller, 2021.

pub(crate) mod around;
pub(crate) mod desc;
pub(crate) mod edit;
pub(crate) mod leg;
pub(crate) mod planes;
pub(crate) mod solve;
pub(crate) mod state;
pub(crate) mod view;

#[cfg(test)]
mod tests;
