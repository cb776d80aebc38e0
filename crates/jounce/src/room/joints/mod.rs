//! Joints: what holds two bodies together, and how far it lets them move.
//!
//! A joint has rows. Some hold: J u = 0 on the velocities, C = 0 on the positions ([`rows`] has the elementary ones, a file for each
//! kind says which it takes). Others end, drive, spring or rub one axis ([`extra`]). Joints that hang together form a set and are
//! solved as one ([`set`]): directly where they are trees, chains or have few loops ([`direct`]), side by side in lanes where many are alike
//! ([`alike`]), row by row otherwise, in lanes where the kernels know the kinds ([`net`]). Nothing is tuned to the mass of the load: a chain of 20 g links holds tons.
//!
//! Symbols: p anchor, r lever from the centre of mass, d = p_b − p_a, x, y, z axes of A's joint frame, u = (v_a, ω_a, v_b, ω_b), λ
//! impulse, C error, h substep.
//!
//! Sources: Baraff 1996 (direct); Andersen 1983 (RATTLE); Catto, GDC 2009 and 2011, Solver2D 2024 (soft step, relax).

pub(crate) mod active;
pub(crate) mod alike;
pub(crate) mod articulated;
pub(crate) mod ball;
pub mod desc;
pub(crate) mod direct;
pub(crate) mod distance;
pub(crate) mod edit;
pub(crate) mod extra;
pub(crate) mod fixed;
pub(crate) mod gear;
pub(crate) mod generic;
pub mod glue;
pub(crate) mod hinge;
pub(crate) mod lanes;
pub(crate) mod local;
pub(crate) mod net;
pub(crate) mod parts;
pub(crate) mod path;
pub(crate) mod place;
pub(crate) mod pulley;
pub(crate) mod redundant;
pub(crate) mod rows;
pub(crate) mod set;
pub(crate) mod slider;
pub(crate) mod solve;
pub(crate) mod spring;
pub(crate) mod state;
pub(crate) mod stiff;
pub mod view;
pub(crate) mod wheel;
