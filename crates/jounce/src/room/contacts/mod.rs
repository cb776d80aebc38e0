//! Contacts: non-penetration, friction, restitution.
//!
//! # Model
//! A manifold has up to four points with one unit normal n from A to B. At a point with levers r_A, r_B from the
//! centres of mass, the gap and the normal velocity are
//!
//! * s = s₀ + n·(Δp_B − Δp_A) + (r_B × n)·Δθ_B − (r_A × n)·Δθ_A,
//! * v_n = n·(v_B − v_A) + (r_B × n)·ω_B − (r_A × n)·ω_A = J u,
//!
//! J = [−n, −(r_A × n), n, r_B × n], with levers and inertia frozen within a step and Δp, Δθ the motion since its
//! start. Complementarity: s ≥ 0, λ ≥ 0, s λ = 0.
//!
//! # Soft step (Catto 2022–2024)
//! Per substep h: one pass with a soft bias, one relaxing pass without it.
//!
//! * s > 0: v_n + s/h ≥ 0 (speculative: may close the gap, not more).
//! * s ≤ 0, first pass: λ ← max(λ − m (σ v_n + β) − ι λ, 0) with β = max(σ b s, −v_push), and
//!   b = ω/(2ζ + hω), σ = hω(2ζ + hω)/(1 + hω(2ζ + hω)), ι = 1/(1 + hω(2ζ + hω)), ω = 2π f.
//! * s ≤ 0, relaxing pass: σ = 1, β = ι = 0.
//! * m = 1/(J M⁻¹ Jᵀ).
//!
//! # Warm start
//! The first substep starts with the impulses of the last step, row by row. Levers and inertia are frozen within a step, so what the rows gave a body in one
//! substep, Δu = Σ M⁻¹ Jᵀ λ, they give it again in the next: one addition a body instead of a pass over all rows. Δu is summed as the passes change u,
//! Δu ← Δu + (u after the pass − u before it). Joints, which turn with their bodies, have a warm start of their own. (docs/decisions/0008-warm-start-by-body.md)
//!
//! # Friction
//! One row of two tangents at the weighted centre of the points, one about the normal (twist), one three-dimensional against
//! rolling; all in the relaxing pass, bounded by the normal impulse there. Static and kinetic: one stick bit per manifold; see
//! [`finish`].
//!
//! # Restitution
//! After the last substep, where the approach was faster than the threshold: all points that will bounce come to rest
//! (compression), then v_n ≥ e V + a h/2 with λ ≥ 0 at all of them together, in passes until it holds; see
//! [`prepare::impact_speed`]. What is given back is at most e times the compression (Poisson), and bodies squeezed from
//! opposite sides do not bounce. A row that bounced starts the next step without impulses.

pub(crate) mod crowd;
pub mod desc;
pub(crate) mod finish;
pub(crate) mod impact;
pub(crate) mod load;
pub(crate) mod prepare;
pub(crate) mod rows;
pub(crate) mod solve;
pub(crate) mod state;
