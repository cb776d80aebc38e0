//! Fields: laws that act on everything in a region.
//!
//! # Model
//! Three kinds of action, summed over all fields (w is a field's weight by its region):
//!
//! * *accelerations* a(x, v, t): uniform gravity, a point −μ d/(d² + ε²)^{3/2}, bodies on one another, a turning frame
//!   −Ω×(Ω×r) − 2Ω×v − Ω′×r, and the caller's own;
//! * *flow* u(x, t) of the medium: wind, gusts, a vortex, a stream;
//! * *medium*: density ρ and viscosity η, in the open or below a liquid's surface.
//!
//! A shape in a medium feels, with u = v + ω × r − flow at its centre:
//!
//! * drag −½ρ A C_d |u| u − 6πηr u, solved implicitly (Stokes times are shorter than a substep): along û with the effective
//!   mass m_e = 1/(1/m + (r × û)·I⁻¹(r × û)), the speed after is s′ = s − h (b s′ + c s′²)/m_e in closed form. It never
//!   reverses the speed, and its fixed point under gravity is the terminal speed exactly;
//! * lift C ½ρ A r ω × u, as a turn of u, so that it does no work;
//! * buoyancy −ρ V g through the centroid of the volume V under the surface, softened by the waterplane's stiffness:
//!   (m + h² ρ g A_w) Δv = h F (implicit in the depth).
//!
//! Everything acts once per substep, after forces and before contacts.
//!
//! # Sources
//! Course slides "Gravitational Force", "Buoyancy", "Drag", "Centrifugal Force"; Morrison, *An Introduction to Fluid
//! Mechanics* (2013) for C_d by shape; Boris 1970 for the turn by Coriolis' force.

pub(crate) mod bodies;
pub mod desc;
pub(crate) mod edit;
pub(crate) mod explosion;
pub(crate) mod gust;
pub mod point;
pub mod state;
