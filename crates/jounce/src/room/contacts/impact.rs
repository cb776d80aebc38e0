//! Simultaneous impacts, before the first substep.
//!
//! A soft step that lets one ball run into a row of touching balls makes them all move together and knows, afterwards, only
//! how fast the first pair met. So contacts between dynamic bodies that meet within this step, faster than the restitution
//! threshold, are first resolved pair by pair, Newton's law v_n⁺ = −e v_n⁻ at each, until none approaches
//! (Gauss–Seidel; for a row of equal balls this passes the momentum on exactly). The rounds are capped.
//!
//! Only contacts in a *cluster* are treated here (a body with two or more contacts between dynamic bodies): a lone pair is served by the
//! end-of-step restitution, which also knows where the surfaces met.

use super::state::{Contact, PairHead};
use crate::limits;
use crate::room::rigid::state::{Awake, BodyFrame, NONE};
use jounce_math::{Vec3, scalar::f32s};

/// Memory that is reused from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Impacts {
    list: Vec<Impact>,
    partner: Vec<u32>,
    shared: Vec<bool>,
}

/// A pair of points that may meet in this step.
#[derive(Clone, Copy, Debug)]
struct Impact {
    rows: [u32; 2],
    normal: Vec3,
    ra: Vec3,
    rb: Vec3,
    mass: f32,
    restitution: f32,
    /// Bit set once it has been resolved at least once: resolved contacts keep to e, untouched ones to the threshold.
    hit: bool,
}

/// Resolves clusters of impacts; gives false when the rounds ran out.
pub(crate) fn resolve(
    contacts: &[Contact],
    heads: &[PairHead],
    frames: &[BodyFrame],
    awake: &mut Awake,
    threshold: f32,
    dt: f32,
    memory: &mut Impacts,
) -> bool {
    let list = &mut memory.list;
    list.clear();
    let mut any_fast = false;
    // Most is told by the heads: what touches something fixed is not looked at.
    for (c, h) in contacts.iter().zip(heads).filter(|(_, h)| h.touching) {
        let [fa, fb] = h.bodies.map(|b| &frames[b as usize]);
        if fa.row == NONE || fb.row == NONE {
            continue;
        }
        for m in c.manifolds().filter(|m| m.surface.restitution > 0.0) {
            let normal = m.normal;
            for (p, at) in m.points() {
                let ra = fa.rotation.rotate(at.on_a);
                let rb = fb.rotation.rotate(at.on_b);
                let i = Impact {
                    rows: [fa.row, fb.row],
                    normal,
                    ra,
                    rb,
                    mass: 0.0,
                    restitution: m.surface.restitution,
                    hit: false,
                };
                let vn = approach(&i, awake);
                // Touching now, or reached within the step.
                if p.separation + f32s::min(vn, 0.0) * dt > 0.0 && p.separation > 1e-4 {
                    continue;
                }
                any_fast |= vn < -threshold;
                list.push(with_mass(i, awake));
            }
        }
    }
    if !any_fast || list.len() < 2 {
        return true;
    }
    keep_clusters(memory, awake.state.len());
    for _ in 0..limits::IMPACT_ROUNDS_MAX {
        let mut quiet = true;
        for i in &mut memory.list {
            let vn = approach(i, awake);
            let limit = if i.hit { 1e-4 } else { threshold };
            if vn < -limit {
                push(i, awake, -(1.0 + i.restitution) * vn * i.mass);
                i.hit = true;
                quiet = false;
            }
        }
        if quiet {
            return true;
        }
    }
    false
}

fn with_mass(mut i: Impact, awake: &Awake) -> Impact {
    let [a, b] = i.rows.map(|r| awake.inertia[r as usize]);
    let (ja, jb) = (i.ra.cross(i.normal), i.rb.cross(i.normal));
    let k = a.inv_mass + b.inv_mass + ja.dot(a.mul(ja)) + jb.dot(b.mul(jb));
    i.mass = if k > 0.0 { 1.0 / k } else { 0.0 };
    i
}

fn approach(i: &Impact, awake: &Awake) -> f32 {
    let [a, b] = i.rows.map(|r| awake.state[r as usize].get());
    i.normal.dot(b.v + b.w.cross(i.rb) - a.v - a.w.cross(i.ra))
}

fn push(i: &Impact, awake: &mut Awake, lambda: f32) {
    let p = i.normal * lambda;
    for (row, r, sign) in [(i.rows[0], i.ra, -1.0), (i.rows[1], i.rb, 1.0)] {
        let t = awake.inertia[row as usize];
        let s = &mut awake.state[row as usize];
        s.set_velocity(s.v() + p * (sign * t.inv_mass), s.w() + t.mul(r.cross(p)) * sign);
    }
}

/// Keeps impacts of which one body has another impact with a different body.
fn keep_clusters(memory: &mut Impacts, rows: usize) {
    let Impacts { list, partner, shared } = memory;
    partner.clear();
    partner.resize(rows, NONE);
    shared.clear();
    shared.resize(rows, false);
    for i in list.iter() {
        for (me, other) in [(i.rows[0], i.rows[1]), (i.rows[1], i.rows[0])] {
            let p = &mut partner[me as usize];
            if *p == NONE {
                *p = other;
            } else if *p != other {
                shared[me as usize] = true;
            }
        }
    }
    list.retain(|i| i.rows.iter().any(|&r| shared[r as usize]));
}
