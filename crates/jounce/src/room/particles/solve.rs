//! One step of a block of particles: births, forces to velocities to positions, wide.
//!
//! In the lecture's order, per particle and step of h seconds (for a newborn, what is left of the step):
//!
//! ```text
//! a  = g + a_fields + a_heat + a_buoyancy
//! w* = v + h a − u                          u: flow of the medium and turbulence
//! w′ = w* · 2/(d + √(d² + 4 h k₂ |w*|))     d = 1 + h k₁
//! v′ = u + w′
//! x′ = x + h v′
//! ```
//!
//! with k₁ = linear drag + 6πηr/m and k₂ = ½ρ C_d πr²/m: s′ = 2s/(d + √…) is the root of s′ = s − h (k₁ s′ + k₂ s′²), so
//! drag is implicit, never turns a velocity round, and leaves a particle that falls at its terminal speed at just that.

use super::birth::born;
use super::collide::{Hit, Obstacle};
use super::prepare::{EmitterStep, Run, offset_of};
use super::state::{Block, Emitter, LANES, Lane, Lane3, get3, set3};
use crate::limits;
use crate::room::contacts::rows::Wide3;
use crate::room::fields::point::Sample;
use jounce_lanes::{Bits, Kernel, Lanes, Mask};
use jounce_math::Vec3;

/// Memory that is reused from step to step and is not state.
#[derive(Default)]
pub(crate) struct Scratch {
    /// By emitter slot.
    pub steps: Vec<Option<EmitterStep>>,
    pub runs: Vec<Run>,
    pub bursts: Vec<(f64, u32)>,
    /// By block.
    pub outs: Vec<Out>,
}

impl Clone for Scratch {
    /// Memory, not state: a clone starts without.
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl core::fmt::Debug for Scratch {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Scratch")
    }
}

/// What a block's step leaves for the stage to gather.
#[derive(Clone, Debug, Default)]
pub(crate) struct Out {
    pub slots: Vec<u32>,
    pub obstacles: Vec<Obstacle>,
    pub hits: Vec<Hit>,
    /// Particles whose numbers went bad.
    pub lost: u32,
    /// More obstacles than are looked at.
    pub crowded: bool,
}

/// Where a block's particles are at the end of the step, before anything is hit.
pub(crate) struct Next {
    pub p: Lane3,
    pub v: Lane3,
    pub age: Lane,
    /// Bounds of the ways of the living, without their radii.
    pub lo: Vec3,
    pub hi: Vec3,
    pub radius: f32,
    /// Bits of lanes.
    pub dead: u64,
    pub bad: u64,
}

impl Next {
    pub fn place(&self, l: usize) -> Vec3 {
        get3(&self.p, l)
    }
    pub fn velocity(&self, l: usize) -> Vec3 {
        get3(&self.v, l)
    }
    pub fn put(&mut self, l: usize, p: Vec3, v: Vec3) {
        set3(&mut self.p, l, p);
        set3(&mut self.v, l, v);
    }
}

/// Bits of the lanes in use.
pub(crate) fn in_use(count: usize) -> u64 {
    if count >= LANES { u64::MAX } else { (1 << count) - 1 }
}

/// Makes the particles that are born in this step.
pub(crate) fn births(block: &mut Block, e: &Emitter, step: &EmitterStep, runs: &[Run], dt: f64) {
    let runs = &runs[step.runs.0..step.runs.1];
    for k in 0..block.births {
        let birth = (block.first_birth + k) as u64;
        let n = born(e, &step.stand, step.first + birth, offset_of(runs, birth, dt), dt);
        block.push(&n);
    }
    block.births = 0;
}

/// What the fields say at each particle.
pub(crate) struct Medium {
    pub acceleration: Lane3,
    pub flow: Lane3,
    pub density: Lane,
    pub viscosity: Lane,
}

impl Medium {
    pub const NONE: Self = Self {
        acceleration: [[0.0; LANES]; 3],
        flow: [[0.0; LANES]; 3],
        density: [0.0; LANES],
        viscosity: [0.0; LANES],
    };

    /// Weight of the displaced liquid: a = −g ρV/m.
    pub fn set(&mut self, l: usize, s: &Sample, weight: Vec3, radius: f32, mass: f32) {
        let mut a = s.acceleration;
        if s.submerged {
            let volume = 4.0 / 3.0 * core::f32::consts::PI * radius * radius * radius;
            a -= weight * (s.density * volume / mass);
        }
        set3(&mut self.acceleration, l, a);
        set3(&mut self.flow, l, s.flow);
        (self.density[l % LANES], self.viscosity[l % LANES]) = (s.density, s.viscosity);
    }
}

/// The step of a block, without collisions.
pub(crate) struct Advance<'a> {
    pub block: &'a Block,
    pub step: &'a EmitterStep,
    pub medium: Option<&'a Medium>,
}

/// Largest change of a velocity component by forces within a step, m/s.
const DV_MAX: f32 = limits::SPEED_MAX;

impl Kernel for Advance<'_> {
    type Output = Next;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Next {
        let Self { block: b, step: s, medium } = self;
        let zero = [0.0; LANES];
        let mut next = Next {
            p: [zero; 3],
            v: [zero; 3],
            age: zero,
            lo: Vec3::splat(f32::INFINITY),
            hi: Vec3::splat(f32::NEG_INFINITY),
            radius: 0.0,
            dead: 0,
            bad: 0,
        };
        let far = L::splat(f32::INFINITY);
        let (mut lo, mut hi) = ([far; 3], [-far; 3]);
        let mut radius_max = L::zero();
        let mut at = 0;
        while at < b.count {
            let p = load3::<L>(&b.p, at);
            let v = load3::<L>(&b.v, at);
            let dt = L::splat(s.dt);
            let age = L::load(&b.age[at..]) + dt;
            let h = age.min(dt).max(L::zero());
            let radius = L::load(&b.radius[at..]);
            let v1 = velocity(b, s, medium, at, p, v, age, h, radius);
            let p1 = p.add(v1.scale(h));
            store3(v1, &mut next.v, at);
            store3(p1, &mut next.p, at);
            age.store(&mut next.age[at..]);
            let size = p1.x.abs() + p1.y.abs() + p1.z.abs() + v1.x.abs() + v1.y.abs() + v1.z.abs();
            let good = size.lt(L::splat(4.0 * limits::POSITION_MAX as f32));
            let inside = p1.x.ge(L::splat(s.lo.x))
                & p1.x.le(L::splat(s.hi.x))
                & p1.y.ge(L::splat(s.lo.y))
                & p1.y.le(L::splat(s.hi.y))
                & p1.z.ge(L::splat(s.lo.z))
                & p1.z.le(L::splat(s.hi.z));
            let lives = good & inside & age.lt(L::load(&b.life[at..]));
            let used = L::load(&LANE[at..]).lt(L::splat(b.count as f32));
            next.dead |= u64::from((!lives & used).bits()) << at;
            next.bad |= u64::from((!good & used).bits()) << at;
            let seen = lives & used;
            let (from, to) = ([p.x, p.y, p.z], [p1.x, p1.y, p1.z]);
            for i in 0..3 {
                lo[i] = L::select(seen, from[i].min(to[i]), far).min(lo[i]);
                hi[i] = L::select(seen, from[i].max(to[i]), -far).max(hi[i]);
            }
            radius_max = L::select(seen, radius, L::zero()).max(radius_max);
            at += L::WIDTH;
        }
        next.lo = Vec3::new(least(lo[0]), least(lo[1]), least(lo[2]));
        next.hi = -Vec3::new(least(-hi[0]), least(-hi[1]), least(-hi[2]));
        next.radius = -least(-radius_max);
        next
    }
}

/// Number of each lane.
const LANE: Lane = {
    let mut lane = [0.0; LANES];
    let mut i = 0;
    while i < LANES {
        lane[i] = i as f32;
        i += 1;
    }
    lane
};

/// Forces, acceleration, velocity.
#[inline(always)]
fn velocity<L: Lanes>(
    b: &Block,
    s: &EmitterStep,
    medium: Option<&Medium>,
    at: usize,
    p: Wide3<L>,
    v: Wide3<L>,
    age: L,
    h: L,
    radius: L,
) -> Wide3<L> {
    let mut a = splat3(s.gravity);
    let mut flow = splat3(Vec3::ZERO);
    let (mut k1, mut k2) = (L::splat(s.linear_drag), L::zero());
    let per_mass = L::splat(1.0) / L::load(&b.mass[at..]);
    if let Some(m) = medium {
        a = a.add(load3(&m.acceleration, at));
        flow = load3(&m.flow, at);
        k1 = k1 + L::splat(s.stokes) * L::load(&m.viscosity[at..]) * radius * per_mass;
        k2 = L::splat(s.quadratic) * L::load(&m.density[at..]) * radius * radius * per_mass;
    } else if let Some(m) = &s.medium {
        a = a.add(splat3(m.acceleration));
        flow = splat3(m.flow);
        k1 = k1 + L::splat(s.stokes) * L::splat(m.viscosity) * radius * per_mass;
        k2 = L::splat(s.quadratic) * L::splat(m.density) * radius * radius * per_mass;
    }
    if let Some((halvings, rise)) = s.heat {
        a = a.add(splat3(rise).scale(half_to_the(age * L::splat(halvings))));
    }
    if let Some(noise) = &s.noise {
        flow = flow.add(noise.at(p));
    }
    let dv = a.scale(h);
    let dv = Wide3::new(within(dv.x), within(dv.y), within(dv.z));
    let w = v.add(dv).sub(flow);
    let d = L::splat(1.0) + h * k1;
    let speed = w.dot(w).sqrt();
    let factor = L::splat(2.0) / (d + (d * d + L::splat(4.0) * h * k2 * speed).sqrt());
    let v = flow.add(w.scale(factor));
    Wide3::new(within(v.x), within(v.y), within(v.z))
}

#[inline(always)]
fn splat3<L: Lanes>(v: Vec3) -> Wide3<L> {
    Wide3::new(L::splat(v.x), L::splat(v.y), L::splat(v.z))
}

/// In this order a NaN stays one, and the particle is taken out.
#[inline(always)]
fn within<L: Lanes>(x: L) -> L {
    L::splat(DV_MAX).min(L::splat(-DV_MAX).max(x))
}

#[inline(always)]
fn load3<L: Lanes>(from: &Lane3, at: usize) -> Wide3<L> {
    Wide3::new(L::load(&from[0][at..]), L::load(&from[1][at..]), L::load(&from[2][at..]))
}

#[inline(always)]
fn store3<L: Lanes>(v: Wide3<L>, to: &mut Lane3, at: usize) {
    v.x.store(&mut to[0][at..]);
    v.y.store(&mut to[1][at..]);
    v.z.store(&mut to[2][at..]);
}

/// The least of the lanes.
#[inline(always)]
fn least<L: Lanes>(x: L) -> f32 {
    let mut lanes = [f32::INFINITY; jounce_lanes::LANES_MAX];
    x.store(&mut lanes);
    lanes.into_iter().fold(f32::INFINITY, |m, x| if x < m { x } else { m })
}

/// 2⁻ˣ for x ≥ 0, to a part in a million: a polynomial for the fraction (the series of eˣ), the whole part by the exponent's
/// bits.
#[inline(always)]
pub(crate) fn half_to_the<L: Lanes>(x: L) -> L {
    const MAGIC: f32 = 12_582_912.0;
    let y = -x.max(L::zero()).min(L::splat(126.0));
    let whole = y + L::splat(MAGIC) - L::splat(MAGIC);
    let f = (y - whole) * L::splat(core::f32::consts::LN_2);
    let mut sum = L::splat(1.0 / 720.0);
    for c in [1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        sum = sum * f + L::splat(c);
    }
    sum * (whole + L::splat(MAGIC + 127.0)).to_bits().shl::<23>().as_floats()
}

/// Writes a block's next state back.
pub(crate) fn commit(b: &mut Block, next: &Next) {
    (b.p, b.v, b.age) = (next.p, next.v, next.age);
}

/// Particles that stick move with their shape: `carry(slot, generation, place)` gives the new place and its velocity, or
/// nothing where the shape is gone.
pub(crate) fn carry(
    b: &mut Block,
    next: &mut Next,
    step: &EmitterStep,
    carry: impl Fn(u32, u32, Vec3) -> Option<(Vec3, Vec3)>,
) -> u64 {
    let mut held = 0;
    for l in 0..b.count {
        if b.anchor[l] == super::state::FREE {
            continue;
        }
        let Some((p, v)) = carry(b.anchor[l], b.anchor_generation[l], get3(&b.p, l)) else {
            b.anchor[l] = super::state::FREE;
            continue;
        };
        set3(&mut next.p, l, p);
        set3(&mut next.v, l, v);
        held |= 1 << l;
        let inside = p.x >= step.lo.x
            && p.y >= step.lo.y
            && p.z >= step.lo.z
            && p.x <= step.hi.x
            && p.y <= step.hi.y
            && p.z <= step.hi.z;
        if inside && next.age[l] < b.life[l] && next.bad >> l & 1 == 0 {
            next.dead &= !(1 << l);
        }
    }
    held
}
