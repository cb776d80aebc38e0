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
//! Bodies that touch one another and nothing that holds them (compounds in one place, in the air) carry nothing. If one of them is
//! squeezed all are raised by one factor, so that what they give one another stays equal and opposite, and gravity pulls at all of them:
//! they fall.
//!
//! What is given up: a squeezed body reacts to a *net* impulse as if it had the mass m′. Bodies on joints are never treated: joints
//! are solved rigidly, and a bone that weighs tons for a step throws those it hangs on.

use super::state::Contact;
use crate::room::rigid::state::Awake;
use jounce_math::{Vec3, scalar::f32s};
use jounce_tasks::Tasks;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ratio of load to weight from which a body counts as squeezed, and from which it is treated in full.
const RATIO: [f32; 2] = [20.0, 40.0];
/// Approach speed of a contact, m/s, from which the body counts as hit and not as squeezed: bodies that run into it would find
/// the raised mass, and lose momentum to it; and the impulses would start the next step of the true mass.
const HIT_SPEED: f32 = 0.5;
/// Most that a mass is raised by.
const RAISE_MAX: f32 = 1e4;

/// Bodies per unit.
const BODIES: usize = 256;

/// A raised mass falls by at most this factor a step: the impulses that balance it now start the next step, and would throw
/// the body away if it were light again at once.
const FALL: f32 = 0.5;

/// Memory that is reused from step to step and is not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Loads {
    /// By row: Σ|λ|, Σ λ n, fastest approach.
    sums: Vec<(f32, Vec3, f32)>,
    /// By row: what is known of those that it touches, and they; the rows that a search has met.
    group: Vec<Group>,
    met: Vec<u32>,
}

/// What is known of a body and those that hang together with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Group {
    Unknown,
    /// The search is at it, or has found nothing that holds it.
    Met,
    /// Something holds one of them.
    Held,
}

/// What a contact gave in the last step: Σ|λ|, Σ λ n, and how fast the two met.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Load {
    pub size: f32,
    pub along: Vec3,
    pub hit_speed: f32,
}

impl Load {
    pub fn of(c: &Contact) -> Self {
        let m = &c.manifold;
        if !m.more {
            // Without points it has given nothing.
            let size = if m.count == 0 { 0.0 } else { m.total };
            return Self { size, along: m.normal * size, hit_speed: c.hit_speed };
        }
        let mut load = Self { hit_speed: c.hit_speed, ..Self::default() };
        for m in c.manifolds() {
            load.size += m.total;
            load.along += m.normal * m.total;
        }
        load
    }
}

impl Loads {
    /// Starts a step of so many awake bodies.
    pub fn begin(&mut self, rows: usize) {
        self.sums.clear();
        self.sums.resize(rows, (0.0, Vec3::ZERO, 0.0));
    }
    /// What a contact gave its two bodies in the last step; rows beyond the awake ones are nobody's.
    pub fn add(&mut self, rows: [u32; 2], load: &Load) {
        if load.size == 0.0 {
            return;
        }
        for (row, sign) in [(rows[0], -1.0), (rows[1], 1.0)] {
            if let Some(s) = self.sums.get_mut(row as usize) {
                s.0 += load.size;
                s.1 += load.along * sign;
                s.2 = f32s::max(s.2, load.hit_speed);
            }
        }
    }
}

/// Lowers inverse masses of squeezed bodies for this step, but for those on joints; who `hangs` on joints or wheels is held. `touches` gives the
/// rows in the awake columns of what a body touches, or numbers beyond them. `loads` has been given all contacts.
pub(crate) fn raise<I: Iterator<Item = u32>>(
    tasks: &Tasks,
    touches: impl Fn(u32) -> I,
    awake: &mut Awake,
    jointed: impl Fn(u32) -> bool + Sync,
    hangs: impl Fn(u32) -> bool,
    loads: &mut Loads,
    [gravity, slop, omega, dt]: [f32; 4],
) {
    let Loads { sums, group, met } = loads;
    let any = AtomicBool::new(false);
    tasks.for_each_piece((&sums[..], &mut awake.step[..]), BODIES, |_, (sums, steps)| {
        let mut treated = false;
        for (sum, step) in sums.iter().zip(steps) {
            let load = (sum.0 - sum.1.length()) * (0.5 / dt);
            let ratio = load * step.inv_mass / gravity;
            let mut raised = f32s::max(step.raised * FALL, 1.0);
            if ratio > RATIO[0] && sum.2 < HIT_SPEED && !jointed(step.body) {
                let part = f32s::min((ratio - RATIO[0]) / (RATIO[1] - RATIO[0]), 1.0);
                let full = f32s::clamp(load * step.inv_mass / (0.5 * slop * omega * omega), 1.0, RAISE_MAX);
                raised = f32s::max(raised, 1.0 + part * (full - 1.0));
            }
            if raised != step.raised {
                step.raised = raised;
            }
            treated |= raised > 1.0;
        }
        if treated {
            any.store(true, Ordering::Relaxed);
        }
    });
    if !any.into_inner() {
        return;
    }
    group.clear();
    let (steps, inertia) = (&mut awake.step, &mut awake.inertia);
    group.resize(steps.len(), Group::Unknown);
    let moves = |row: u32| inertia.get(row as usize).is_some_and(|t| t.inv_mass > 0.0);
    for first in 0..steps.len() {
        if steps[first].raised == 1.0 || group[first] != Group::Unknown || !moves(first as u32) {
            continue;
        }
        met.clear();
        met.push(first as u32);
        group[first] = Group::Met;
        // Until something is found that holds one of them: most lie on the ground, or near one that does.
        let mut next = 0;
        let held = loop {
            let Some(&row) = met.get(next) else { break false };
            next += 1;
            let body = steps[row as usize].body;
            // Those too that push for the first time in this step.
            let holds = |other: u32| {
                if !moves(other) || group[other as usize] == Group::Held {
                    return true;
                }
                if group[other as usize] == Group::Unknown {
                    group[other as usize] = Group::Met;
                    met.push(other);
                }
                false
            };
            if hangs(body) || touches(body).any(holds) {
                break true;
            }
        };
        if held {
            met.iter().for_each(|&row| group[row as usize] = Group::Held);
        } else {
            let most = met.iter().fold(1.0, |most, &row| f32s::max(most, steps[row as usize].raised));
            met.iter().for_each(|&row| steps[row as usize].raised = most);
        }
    }
    for ((step, inertia), group) in steps.iter_mut().zip(inertia).zip(&*group) {
        if step.raised == 1.0 || inertia.inv_mass == 0.0 {
            continue;
        }
        let factor = 1.0 / step.raised;
        for v in [&mut inertia.inv_mass, &mut inertia.xx, &mut inertia.yy, &mut inertia.zz] {
            *v *= factor;
        }
        for v in [&mut inertia.xy, &mut inertia.xz, &mut inertia.yz] {
            *v *= factor;
        }
        if *group == Group::Held {
            step.acceleration *= factor;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::room::rigid::state::NONE;
    use crate::{BodyDesc, ShapeDesc, World, WorldDesc};

    /// Bodies that touch one another at random, some of them the ground, some on joints: raised bodies that nothing holds take all they hang together
    /// with along, by the most of them; held ones are raised alone, and what pulls at them is divided. Found here by going over all pairs
    /// until nothing changes.
    #[test]
    fn what_is_held_is_raised_alone() {
        let mut w = World::new(WorldDesc::default()).expect("valid");
        for i in 0..60 {
            let at = [3.0 * f64::from(i), 0.0, 0.0];
            w.add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::sphere(0.5))).expect("valid");
        }
        let mut state = 5_u32;
        let mut random = |n: u32| {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 16) % n
        };
        let (mut alone, mut together) = (0, 0);
        for round in 0..40 {
            let mut awake = w.awake.clone();
            let n = awake.step.len() as u32;
            let mut pairs: Vec<[u32; 2]> =
                (0..20 + round).map(|_| [random(n), random(n)]).filter(|p| p[0] != p[1]).collect();
            pairs.extend((0..6).map(|_| [random(n), NONE]));
            let hung: Vec<u32> = (0..3).map(|_| random(n)).collect();
            for b in &mut awake.step {
                b.acceleration = Vec3::new(0.0, -8.0, 0.0);
                // Twice what is left of it now.
                b.raised = if random(4) == 0 { 2.0 * (2 + random(3)) as f32 } else { 1.0 };
            }
            let was: Vec<f32> = awake.step.iter().map(|b| f32s::max(b.raised * FALL, 1.0)).collect();
            let mut most = was.clone();
            let mut held: Vec<bool> = (0..n).map(|row| hung.contains(&row)).collect();
            for _ in 0..n {
                for p in &pairs {
                    let [a, b] = p.map(|row| row as usize);
                    if p[1] == NONE {
                        held[a] = true;
                        continue;
                    }
                    (held[a], held[b]) = (held[a] || held[b], held[a] || held[b]);
                    let more = f32s::max(most[a], most[b]);
                    (most[a], most[b]) = (more, more);
                }
            }
            let row_of: Vec<u32> = awake.step.iter().map(|b| b.body).collect();
            let row = |body: u32| row_of.iter().position(|&b| b == body).expect("a body") as u32;
            let touches = |body: u32| {
                let row = row(body);
                let other = move |p: &[u32; 2]| match *p {
                    [a, b] if a == row => Some(b),
                    [a, b] if b == row => Some(a),
                    _ => None,
                };
                pairs.iter().filter_map(other)
            };
            let mut loads = Loads::default();
            loads.begin(n as usize);
            let before = awake.inertia.clone();
            let hangs = |body| hung.contains(&row(body));
            let numbers = [10.0, 0.005, 200.0, 1.0 / 60.0];
            raise(&Tasks::serial(), touches, &mut awake, |_| true, hangs, &mut loads, numbers);
            for i in 0..n as usize {
                let expected = if held[i] { was[i] } else { most[i] };
                assert_eq!(awake.step[i].raised, expected, "{round} {i}");
                assert_eq!(awake.inertia[i].inv_mass, before[i].inv_mass * (1.0 / expected), "{round} {i}");
                let part = if held[i] { 1.0 / expected } else { 1.0 };
                assert_eq!(awake.step[i].acceleration.y, -8.0 * part, "{round} {i}");
                alone += i32::from(held[i] && was[i] > 1.0);
                together += i32::from(!held[i] && was[i] == 1.0 && expected > 1.0);
            }
        }
        assert!(alone > 100 && together > 30, "{alone} {together}");
    }
}
