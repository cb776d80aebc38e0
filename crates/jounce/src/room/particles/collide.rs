//! Particles meet shapes: the lecture's V_b = (1 − K_f) V_t − K_r V_n, at the time of the hit.
//!
//! A particle is a ball that moves along a line from its place to the next, x → x + h v′ ([`super::solve`]). The first shape
//! in its way stops it, gives it a new velocity, and it goes on with what is left of the step, up to
//! [`limits::PARTICLE_BOUNCES_MAX`] times; then it stays where it is and moves with the shape.
//!
//! # The velocity at a hit
//! v′ = v + h a is not the velocity on the way. The places of semi-implicit Euler lie on a parabola exactly, on which the
//! velocity at the start of a step is u = (v + v′)/2 and changes by a. The hit takes that one, bounces it, and the end of
//! the step turns it back, v = u − h a/2; so a bounce costs no height beyond K_r², whatever the step. (Bouncing v′ itself
//! loses or gains up to h a in every bounce, and a ball of K_r = 1 would sink or climb.)
//!
//! # Rest
//! Where the next bounce would last less than a step, K_r is 0, and the part of a that presses on the surface acts no more.
//! A particle that stays on a surface loses K_f of its tangential velocity 60 times a second, whatever the step, as long as what
//! it falls in a step (g h²) is more than the slack that counts as touching ([`super::ball`]): in steps below about 1/400 s a
//! ball of 5 cm sinks through the slack for several of them, and then hops (a known miss of `jounce verify`).
//!
//! Moving shapes are met in their own frame, in which the ball's way is taken to be straight.

use super::ball::{Around, Ball, Touch, between, plane, sweep};
use super::desc::HitResponse;
use super::prepare::Rules;
use super::solve::Next;
use super::state::{Block, get3};
use crate::limits;
use jounce_geometry::Shape;
use jounce_lanes::{Kernel, Lanes, Mask};
use jounce_math::{Pose, Vec3, scalar::f32s};

/// A shape near a block of particles. Places count from the emitter's origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Obstacle {
    /// Shape and body by slot.
    pub slot: u32,
    pub body: u32,
    /// At the start and the end of the step.
    pub start: Pose,
    pub end: Pose,
    pub moving: bool,
    /// A half-space at rest: normal and offset.
    pub plane: Option<(Vec3, f32)>,
    /// Bounds of its motion.
    pub lo: Vec3,
    pub hi: Vec3,
    /// Motion of its body.
    pub velocity: Vec3,
    pub spin: Vec3,
    pub center: Vec3,
    /// A dynamic body that hits push.
    pub pushed: bool,
    /// Lanes whose way comes near.
    pub near: u64,
}

impl Obstacle {
    pub fn velocity_at(&self, p: Vec3) -> Vec3 {
        self.velocity + self.spin.cross(p - self.center)
    }
    fn pose(&self, s: f32) -> Pose {
        if self.moving { between(&self.start, &self.end, s) } else { self.start }
    }
    /// Where a point that moves with it from the part `s` of the step on is at the end.
    pub fn carry(&self, p: Vec3, s: f32) -> Vec3 {
        if !self.moving {
            return p;
        }
        self.end.transform_point(self.pose(s).inverse_transform_point(p))
    }
    fn touch(&self, w: &Way, shape: &Shape, max_t: f32, around: &mut Around) -> Option<Touch> {
        if let Some((n, offset)) = self.plane {
            return plane(n, offset, w.from, w.to - w.from, w.ball(Vec3::ZERO), max_t);
        }
        if !self.moving {
            let from = self.start.inverse_transform_point(w.from);
            let motion = self.start.q.inverse_rotate(w.to - w.from);
            let hit = sweep((shape, self.slot), from, motion, w.ball(self.start.p), max_t, around)?;
            return Some(Touch { normal: self.start.q.rotate(hit.normal), ..hit });
        }
        let pose = self.pose(w.s);
        let from = pose.inverse_transform_point(w.from);
        let to = self.end.inverse_transform_point(w.to);
        let hit = sweep((shape, self.slot), from, to - from, w.ball(self.end.p), max_t, around)?;
        let then = between(&pose, &self.end, hit.t);
        Some(Touch { normal: then.q.rotate(hit.normal), ..hit })
    }
    pub fn meets(&self, lo: Vec3, hi: Vec3) -> bool {
        self.plane.is_some()
            || (lo.x <= self.hi.x
                && lo.y <= self.hi.y
                && lo.z <= self.hi.z
                && self.lo.x <= hi.x
                && self.lo.y <= hi.y
                && self.lo.z <= hi.z)
    }
}

/// What is left of a particle's step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub from: Vec3,
    pub to: Vec3,
    /// Velocity at `from`, acceleration, and the velocity to keep if nothing is hit.
    pub u: Vec3,
    pub a: Vec3,
    pub v: Vec3,
    /// Part of the step that is over.
    pub s: f32,
    pub radius: f32,
    pub mass: f32,
}

impl Way {
    fn ball(&self, frame: Vec3) -> Ball {
        let reach = f32s::max((self.from - frame).abs().max_component(), self.from.abs().max_component());
        Ball::new(self.radius, reach)
    }
}

/// How a particle's step ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    /// At a place with a velocity.
    Flies(Vec3, Vec3),
    /// On a shape, which it sticks to.
    Sticks(Vec3, Vec3, u32),
    /// Dead.
    Dies,
}

/// A hit that others want to know of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// The particle's lane, or none where it has died.
    pub lane: Option<u8>,
    /// Index of the obstacle.
    pub obstacle: u32,
    pub normal: Vec3,
    /// Speed along the normal, towards the surface, m/s.
    pub speed: f32,
    /// To be reported.
    pub told: bool,
    /// The body is to be pushed, and the particle's way goes on from here.
    pub push: bool,
    pub way: Way,
}

impl Hit {
    /// The lane after the dead have left their gaps.
    pub fn settle_on(&mut self, alive: u64) {
        self.lane = self.lane.filter(|l| alive >> l & 1 == 1);
        self.lane = self.lane.map(|l| (alive & ((1 << l) - 1)).count_ones() as u8);
    }
}

/// First obstacle in the way; the lowest slot of equals.
fn first<'a>(
    w: &Way,
    lane: Option<usize>,
    obstacles: &[Obstacle],
    shape: &impl Fn(u32) -> &'a Shape,
    around: &mut Around,
) -> Option<(usize, Touch)> {
    let mut best: Option<(usize, Touch)> = None;
    let grow = Vec3::splat(1.01 * w.radius);
    let (lo, hi) = (w.from.min(w.to) - grow, w.from.max(w.to) + grow);
    for (i, o) in obstacles.iter().enumerate() {
        let near = lane.map_or_else(|| o.meets(lo, hi), |l| o.near >> l & 1 == 1);
        if !near {
            continue;
        }
        let bound = best.map_or(1.0, |b| b.1.t);
        let hit = o.touch(w, shape(o.slot), bound, around);
        if let Some(h) = hit.filter(|h| best.is_none_or(|(_, b)| h.t < b.t)) {
            best = Some((i, h));
        }
    }
    best
}

/// Moves a particle through what is left of its step. `lane`: its lane, for the obstacles that were found near it.
pub(crate) fn fly<'a>(
    mut w: Way,
    lane: Option<usize>,
    rules: &Rules,
    obstacles: &[Obstacle],
    shape: &impl Fn(u32) -> &'a Shape,
    around: &mut Around,
    hits: &mut Vec<Hit>,
) -> End {
    let mut held: [Vec3; 2] = [Vec3::ZERO; 2];
    for round in 0..limits::PARTICLE_BOUNCES_MAX {
        // Later rounds go ways that nobody looked at before.
        let lane_of_round = if round == 0 { lane } else { None };
        let Some((i, touch)) = first(&w, lane_of_round, obstacles, shape, around) else {
            return End::Flies(w.to, w.v);
        };
        let o = &obstacles[i];
        w = at_touch(w, &touch, rules.dt);
        let speed = f32s::max(-touch.normal.dot(w.u - o.velocity_at(w.from)), 0.0);
        let rests = rests(&w, &touch, speed, rules);
        if o.pushed && !rules.desc.push {
            // Settled already: what would come back to it waits for the next step, so that no momentum is lost.
            return End::Flies(o.carry(w.from, w.s), w.u);
        }
        let push = o.pushed;
        let told = rules.desc.hit_events && !(rests && touch.t == 0.0);
        if push || told {
            let lane = lane.map(|l| l as u8);
            hits.push(Hit { lane, obstacle: i as u32, normal: touch.normal, speed, told, push, way: w });
        }
        match rules.desc.response {
            HitResponse::Kill => return End::Dies,
            HitResponse::Stick => return End::Sticks(o.carry(w.from, w.s), o.velocity_at(w.from), o.slot),
            // The body's share is settled one hit after the other, later.
            HitResponse::Bounce if push => return End::Flies(o.carry(w.from, w.s), w.u),
            HitResponse::Bounce => {}
        }
        let surface = o.velocity_at(w.from);
        let after = surface + bounced(w.u - surface, touch.normal, rests && touch.t == 0.0, rests, rules);
        w = onward(w, after, touch.normal, rests, rules.dt);
        if rests {
            w = along_crease(w, surface, touch.normal, held, rules.dt);
            held = [touch.normal, held[0]];
        }
        if round + 1 == limits::PARTICLE_BOUNCES_MAX {
            return End::Flies(o.carry(w.from, w.s), w.v);
        }
        // At rest: less than the next step would see.
        if !o.moving && (w.to - w.from).abs().max_component() <= 1e-4 * w.radius {
            return End::Flies(w.to, w.v);
        }
    }
    End::Flies(w.to, w.v)
}

/// The particle at the time of the touch, at its place (out of the shape) with its velocity then.
fn at_touch(w: Way, touch: &Touch, dt: f32) -> Way {
    let left = (1.0 - w.s) * dt;
    let from = w.from + (w.to - w.from) * touch.t + touch.normal * touch.depth;
    Way { from, u: w.u + w.a * (left * touch.t), s: w.s + (1.0 - w.s) * touch.t, ..w }
}

/// Would the next bounce last less than a step?
fn rests(w: &Way, touch: &Touch, speed: f32, rules: &Rules) -> bool {
    let pressed = f32s::max(-touch.normal.dot(w.a), 0.0);
    rules.desc.restitution * speed <= 0.5 * pressed * rules.dt
}

/// The relative velocity after a bounce.
pub(crate) fn bounced(relative: Vec3, n: Vec3, stays: bool, rests: bool, rules: &Rules) -> Vec3 {
    let normal = n.dot(relative);
    let tangent = relative - n * normal;
    let kept = if stays { rules.kept } else { 1.0 - rules.desc.friction };
    let back = if normal > 0.0 {
        normal
    } else if rests {
        0.0
    } else {
        -rules.desc.restitution * normal
    };
    tangent * kept + n * back
}

/// What is left of the step after a bounce to velocity `u`.
pub(crate) fn onward(w: Way, u: Vec3, n: Vec3, rests: bool, dt: f32) -> Way {
    let left = (1.0 - w.s) * dt;
    let a = if rests { w.a - n * f32s::min(n.dot(w.a), 0.0) } else { w.a };
    let to = w.from + u * left + a * (0.5 * left * left);
    Way { to, u, a, v: u + a * (left - 0.5 * dt), ..w }
}

/// A particle that rests on a surface and slides into another that it rested on before goes on along the crease between them,
/// or, held by a third, not at all. Going from one to the other and back would use up its hits.
fn along_crease(w: Way, surface: Vec3, n: Vec3, held: [Vec3; 2], dt: f32) -> Way {
    let enters = |m: Vec3, v: Vec3| m != Vec3::ZERO && m.dot(v) < -1e-6 * v.length();
    let (mut u, mut a) = (w.u - surface, w.a);
    if !enters(held[0], u) && !enters(held[0], a) && !enters(held[1], u) && !enters(held[1], a) {
        return w;
    }
    let m = if enters(held[0], u) || enters(held[0], a) { held[0] } else { held[1] };
    let crease = n.cross(m).normalize_or(Vec3::ZERO);
    (u, a) = (crease * crease.dot(u), crease * crease.dot(a));
    let other = if m == held[0] { held[1] } else { held[0] };
    if enters(other, u) || enters(other, a) {
        (u, a) = (Vec3::ZERO, Vec3::ZERO);
    }
    onward(Way { a, ..w }, surface + u, n, false, dt)
}

/// The way of a lane before it meets anything: from its place and velocity to the next ones.
pub(crate) fn way(b: &Block, l: usize, to: Vec3, v1: Vec3, age: f32, rules: &Rules) -> Way {
    let (from, v0) = (get3(&b.p, l), get3(&b.v, l));
    let h = f32s::max(f32s::min(age, rules.dt), 0.0);
    let a = if h > 0.0 { (v1 - v0) * (1.0 / h) } else { Vec3::ZERO };
    Way {
        from,
        to,
        u: (v0 + v1) * 0.5,
        a,
        v: v1,
        s: 1.0 - h / rules.dt,
        radius: b.radius[l] * rules.desc.radius_scale,
        mass: b.mass[l],
    }
}

/// Finds for every obstacle the lanes whose way comes near it.
pub(crate) struct Near<'a> {
    pub block: &'a Block,
    pub next: &'a Next,
    pub radius_scale: f32,
    pub obstacles: &'a mut [Obstacle],
}

impl Kernel for Near<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (b, next) = (self.block, self.next);
        for o in self.obstacles {
            o.near = 0;
            let mut at = 0;
            while at < b.count {
                let bits = o.reached::<L>(b, &next.p, self.radius_scale, at).bits();
                o.near |= u64::from(bits) << at;
                at += L::WIDTH;
            }
        }
    }
}
