//! Particles that meet a half-space at rest and nothing else, wide.
//!
//! Most particles that touch anything lie on the ground. One hit is all that can happen to them in a step: a bounce that
//! would be over within it counts as rest ([`super::collide`]). The arithmetic is that of the scalar path, operation by
//! operation, so it cannot be seen which of them a particle took; a test holds them equal.

use super::collide::Obstacle;
use super::desc::HitResponse;
use super::prepare::Rules;
use super::solve::Next;
use super::state::{Block, LANES, Lane3};
use crate::room::contacts::rows::Wide3;
use jounce_lanes::{Kernel, Lanes, Mask, Width, dispatch};
use jounce_math::Vec3;

impl Obstacle {
    /// A plane that does not move and takes no notice.
    fn is_ground(&self) -> bool {
        self.plane.is_some() && !self.pushed && self.velocity == Vec3::ZERO && self.spin == Vec3::ZERO
    }
}

/// Steps those of `lanes` that meet one plane and nothing else, and gives their bits.
pub(crate) fn run(
    width: Width,
    block: &Block,
    next: &mut Next,
    rules: &Rules,
    obstacles: &[Obstacle],
    lanes: u64,
) -> u64 {
    if rules.desc.response != HitResponse::Bounce || rules.desc.hit_events {
        return 0;
    }
    let Some(k) = obstacles.iter().position(Obstacle::is_ground) else { return 0 };
    let others = obstacles.iter().enumerate().filter(|&(i, _)| i != k).map(|(_, o)| o);
    let lanes = others.clone().fold(lanes & obstacles[k].near, |l, o| l & !o.near);
    if lanes == 0 {
        return 0;
    }
    let Some((normal, offset)) = obstacles[k].plane else { return 0 };
    let mut bounce =
        OnPlane { block, next, rules, normal, offset, lanes, p: [[0.0; LANES]; 3], v: [[0.0; LANES]; 3] };
    let (p, v) = dispatch(width, &mut bounce);
    // Where a way went off to others, the long path looks at it from the start.
    let free = others.fold(lanes, |l, o| l & !dispatch(width, Reaches { block, p: &p, rules, o, lanes: l }));
    let mut rest = free;
    while rest != 0 {
        let l = rest.trailing_zeros() as usize;
        rest &= rest - 1;
        for i in 0..3 {
            (next.p[i][l], next.v[i][l]) = (p[i][l], v[i][l]);
        }
    }
    free
}

struct OnPlane<'a> {
    block: &'a Block,
    next: &'a Next,
    rules: &'a Rules,
    normal: Vec3,
    offset: f32,
    lanes: u64,
    p: Lane3,
    v: Lane3,
}

#[inline(always)]
fn load<L: Lanes>(from: &Lane3, at: usize) -> Wide3<L> {
    Wide3::new(L::load(&from[0][at..]), L::load(&from[1][at..]), L::load(&from[2][at..]))
}

#[inline(always)]
fn select<L: Lanes>(mask: L::Mask, a: Wide3<L>, b: Wide3<L>) -> Wide3<L> {
    Wide3::new(L::select(mask, a.x, b.x), L::select(mask, a.y, b.y), L::select(mask, a.z, b.z))
}

#[inline(always)]
fn store<L: Lanes>(v: Wide3<L>, to: &mut Lane3, at: usize) {
    v.x.store(&mut to[0][at..]);
    v.y.store(&mut to[1][at..]);
    v.z.store(&mut to[2][at..]);
}

impl Kernel for &mut OnPlane<'_> {
    type Output = (Lane3, Lane3);

    #[inline(always)]
    fn run<L: Lanes>(self) -> (Lane3, Lane3) {
        let mut at = 0;
        while at < self.block.count {
            if (self.lanes >> at) & ((1 << L::WIDTH) - 1) != 0 {
                let (p, v) = self.group::<L>(at);
                store(p, &mut self.p, at);
                store(v, &mut self.v, at);
            }
            at += L::WIDTH;
        }
        (self.p, self.v)
    }
}

impl OnPlane<'_> {
    #[inline(always)]
    fn group<L: Lanes>(&self, at: usize) -> (Wide3<L>, Wide3<L>) {
        let (b, rules) = (self.block, self.rules);
        let (zero, one, half) = (L::zero(), L::splat(1.0), L::splat(0.5));
        let dt = L::splat(rules.dt);
        let n = Wide3::new(L::splat(self.normal.x), L::splat(self.normal.y), L::splat(self.normal.z));
        // collide::way
        let (from, v0) = (load::<L>(&b.p, at), load::<L>(&b.v, at));
        let (to, v1) = (load::<L>(&self.next.p, at), load::<L>(&self.next.v, at));
        let h = L::load(&self.next.age[at..]).min(dt).max(zero);
        let a = v1.sub(v0).scale(one / h);
        let a = select::<L>(h.gt(zero), a, Wide3::new(zero, zero, zero));
        let u = v0.add(v1).scale(half);
        let s = one - h / dt;
        let radius = L::load(&b.radius[at..]) * L::splat(rules.desc.radius_scale);
        // Ball::new
        let reach = from.x.abs().max(from.y.abs()).max(from.z.abs());
        let rounding = reach * L::splat(1.0 / 2_097_152.0);
        let radius = radius.max(L::splat(4.0) * rounding);
        let skin = L::splat(1e-3) * radius + rounding;
        // ball::plane
        let motion = to.sub(from);
        let gap = n.dot(from) - L::splat(self.offset) - radius;
        let slope = n.dot(motion);
        let touching = gap.le(skin);
        let enters = (gap + slope).lt(-skin) | gap.lt(-skin);
        let later = -gap / slope;
        let hits = (touching & enters) | (!touching & slope.lt(zero) & later.le(one));
        let t = L::select(touching, zero, later);
        let depth = L::select(touching, (-gap).max(zero), zero);
        // collide::at_touch
        let left = (one - s) * dt;
        let place = from.add(motion.scale(t)).add(n.scale(depth));
        let u = u.add(a.scale(left * t));
        let s = s + (one - s) * t;
        // collide::rests and bounced
        let speed = (-n.dot(u)).max(zero);
        let pressed = (-n.dot(a)).max(zero);
        let rests = (L::splat(rules.desc.restitution) * speed).le(half * pressed * dt);
        let stays = rests & t.eq(zero);
        let normal = n.dot(u);
        let tangent = u.sub(n.scale(normal));
        let kept = L::select(stays, L::splat(rules.kept), L::splat(1.0 - rules.desc.friction));
        let back = L::select(rests, zero, L::splat(-rules.desc.restitution) * normal);
        let back = L::select(normal.gt(zero), normal, back);
        let u = tangent.scale(kept).add(n.scale(back));
        // collide::onward
        let left = (one - s) * dt;
        let into = n.dot(a).min(zero);
        let a = select::<L>(rests, a.sub(n.scale(into)), a);
        let end = place.add(u.scale(left)).add(a.scale(half * left * left));
        let v = u.add(a.scale(left - L::splat(0.5 * rules.dt)));
        (select::<L>(hits, end, to), select::<L>(hits, v, v1))
    }
}

/// Which lanes come near an obstacle on their ways to new places?
struct Reaches<'a> {
    block: &'a Block,
    p: &'a Lane3,
    rules: &'a Rules,
    o: &'a Obstacle,
    lanes: u64,
}

impl Kernel for Reaches<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u64 {
        let mut near = 0;
        let mut at = 0;
        while at < self.block.count {
            if (self.lanes >> at) & ((1 << L::WIDTH) - 1) != 0 {
                let bits = self.o.reached::<L>(self.block, self.p, self.rules.desc.radius_scale, at);
                near |= u64::from(bits.bits()) << at;
            }
            at += L::WIDTH;
        }
        near
    }
}

impl Obstacle {
    /// Which lanes come near on their ways from the block's places to others?
    #[inline(always)]
    pub fn reached<L: Lanes>(&self, b: &Block, to: &Lane3, radius_scale: f32, at: usize) -> L::Mask {
        // A touch within the skin, which grows with the distance from the origin, is one.
        let (scale, slack) = (L::splat(1.01 * radius_scale), L::splat(1.0 / 262_144.0));
        let radius = L::load(&b.radius[at..]) * scale;
        if let Some((n, offset)) = self.plane {
            let (mut height, mut far) = (L::splat(-offset), L::zero());
            for (n, axis) in n.to_array().into_iter().zip(to) {
                let x = L::load(&axis[at..]);
                height = height + L::splat(n) * x;
                far = far.max(x.abs());
            }
            return height.le(radius + far * slack);
        }
        let mut apart = L::zero();
        let (lo, hi) = (self.lo.to_array(), self.hi.to_array());
        for i in 0..3 {
            let (x, y) = (L::load(&b.p[i][at..]), L::load(&to[i][at..]));
            let reach = radius + x.abs().max(y.abs()) * slack;
            apart = apart.max(x.min(y) - reach - L::splat(hi[i]));
            apart = apart.max(L::splat(lo[i]) - x.max(y) - reach);
        }
        apart.le(L::zero())
    }
}
