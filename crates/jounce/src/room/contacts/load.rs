//! Heavy on light: bodies squeezed by far more than their own weight.
//!
//! A contact row is a spring of stiffness m ω² (m the effective mass of its two bodies), so a body of mass m that carries the
//! load W sags by W/(m ω²): 1,000 kg on 1 kg sinks 0.3 m, however well the rows converge; and Gauss–Seidel converges at a
//! rate of one over the mass ratio. Both come from the *inertia* of the light body, which the motion of a squeezed
//! body hardly depends on. So for one step at a time its inertia is raised until the load sags by half the slop:
//!
//! * squeeze W = (Σ|λ n| − |Σ λ n|)/(2 Δt) over its contacts in the last step: the force that passes *through* the body; 0 for a body
//!   that is only hit, falls, or rests under nothing;
//! * ratio r = W / (m |g|); nothing happens up to 20, all of it from 40 on;
//! * m′ = W/(½ slop · ω²), at most 10⁴ m; I′ = I m′/m. Forces stay as they are: gravity pulls with m g, so the weights that
//!   contacts report are the true ones.
//!
//! What is given up: a squeezed body reacts to a *net* impulse as if it had the mass m′. Bodies on joints are never treated: joints
//! are solved rigidly, and a bone that weighs tons for a step throws those it hangs on.

use super::state::Contact;
use crate::room::rigid::state::{Awake, BodyFrame};
use jounce_math::{Vec3, scalar::f32s};

/// Ratio of load to weight from which a body counts as squeezed, and from which it is treated in full.
const RATIO: [f32; 2] = [20.0, 40.0];
/// Approach speed of a contact, m/s, from which the body counts as hit and not as squeezed: bodies that run into it would find
/// the raised mass, and lose momentum to it; and the impulses would start the next step of the true mass.
const HIT_SPEED: f32 = 0.5;
/// Most that a mass is raised by.
const RAISE_MAX: f32 = 1e4;

/// A raised mass falls by at most this factor a step: the impulses that balance it now start the next step, and would throw
/// the body away if it were light again at once.
const FALL: f32 = 0.5;

/// Lowers inverse masses of squeezed bodies for this step. `sums` is scratch: (Σ|λ|, Σ λ n, fastest approach) by row.
pub(crate) fn raise(
    contacts: &[Contact],
    frames: &[BodyFrame],
    awake: &mut Awake,
    jointed: impl Fn(u32) -> bool,
    sums: &mut Vec<(f32, Vec3, f32)>,
    [gravity, slop, omega, dt]: [f32; 4],
) {
    sums.clear();
    sums.resize(awake.state.len(), (0.0, Vec3::ZERO, 0.0));
    for c in contacts.iter().filter(|c| c.touching) {
        let rows = [frames[c.body_a as usize].row, frames[c.body_b as usize].row];
        for m in c.manifolds() {
            let total: f32 = m.points[..usize::from(m.count).min(4)].iter().map(|p| p.total_impulse).sum();
            if total == 0.0 {
                continue;
            }
            for (row, sign) in [(rows[0], -1.0), (rows[1], 1.0)] {
                if let Some(s) = sums.get_mut(row as usize) {
                    s.0 += total;
                    s.1 += m.normal * (sign * total);
                    s.2 = f32s::max(s.2, c.hit_speed);
                }
            }
        }
    }
    for ((sum, step), inertia) in sums.iter().zip(&mut awake.step).zip(&mut awake.inertia) {
        let load = (sum.0 - sum.1.length()) * (0.5 / dt);
        let ratio = load * step.inv_mass / gravity;
        let mut raised = f32s::max(step.raised * FALL, 1.0);
        if ratio > RATIO[0] && sum.2 < HIT_SPEED && !jointed(step.body) {
            let part = f32s::min((ratio - RATIO[0]) / (RATIO[1] - RATIO[0]), 1.0);
            let full = f32s::clamp(load * step.inv_mass / (0.5 * slop * omega * omega), 1.0, RAISE_MAX);
            raised = f32s::max(raised, 1.0 + part * (full - 1.0));
        }
        step.raised = raised;
        if raised == 1.0 || inertia.inv_mass == 0.0 {
            continue;
        }
        let factor = 1.0 / raised;
        for v in [&mut inertia.inv_mass, &mut inertia.xx, &mut inertia.yy, &mut inertia.zz] {
            *v *= factor;
        }
        for v in [&mut inertia.xy, &mut inertia.xz, &mut inertia.yz] {
            *v *= factor;
        }
        step.acceleration *= factor;
    }
}
