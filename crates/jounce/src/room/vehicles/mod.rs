//! Vehicles: what is between a body and the ground.
//!
//! The chassis is an ordinary dynamic body with the mass of the whole vehicle. In every substep its wheels look for the ground ([`crate::stage`]:
//! a cylinder, ball or ray along the travel), which gives each a plane: point, normal, body, friction. Then
//!
//! * [`suspension`]: travel of each wheel, with its own mass, between its spring and the tyre's; implicit where it is stiff;
//! * [`engine`], [`spin`]: torque curve, clutch, gears, differentials, tracks and brakes; stick and slip like Coulomb friction, solved
//!   directly where they stick;
//! * [`tyre`]: brush model, combined slip within the friction circle, relaxation; at a standstill a spring;
//! * [`solve`]: impulses on the chassis and, the other way, on what the wheel stands on; momentum is kept to rounding;
//! * [`board`]: edges of a snowboard instead of wheels.
//!
//! Axes: forward, up, left = up × forward. Travel s is down positive from rest, spin Ω forward positive, both against the chassis. Steering
//! is right positive for the driver ([`desc::VehicleInput`]), angles left positive.
//!
//! What the mass counts. The chassis' mass and inertia are those of the whole vehicle with its wheels at rest; a wheel's own mass m moves
//! within it: m u d is momentum *on top*. So weight, load transfer m a h/L and all that moves the vehicle as a whole are exact.
//!
//! Left out: camber thrust and aligning torque, gyroscopic torque of the engine, anti-dive geometry, temperature and wear.
//!
//! Sources: Pacejka, Tyre and Vehicle Dynamics, 2012; Milliken & Milliken, Race Car Vehicle Dynamics, 1995; Gillespie, Fundamentals of
//! Vehicle Dynamics, 1992; Howe, The New Skiing Mechanics, 2001.

pub(crate) mod board;
pub mod desc;
pub(crate) mod edit;
pub(crate) mod engine;
pub mod presets;
pub(crate) mod solve;
pub(crate) mod spin;
pub(crate) mod state;
pub(crate) mod suspension;
pub(crate) mod tyre;
pub mod view;
