//! Continuous collision: a body that moved far against its size is stopped where it first met a fixed shape (bullets: any
//! shape). It keeps its velocity; the next step's contact takes it from there, and if it cannot, the velocity goes.
//!
//! Where the body already touched the shape at the start (it rests or slides on it), its whole outline would stop at once;
//! then only a ball of half the inner radius at its centre is swept: it cannot get through. A ball that is in the surface
//! already stays where it is rather than go deeper. A part that goes nowhere deeper into a mesh than a sliding body may is let go.
//! And the body stops where an end of it that swings round gets deep.

use super::publish::swept;
use super::{Step, broadphase};
use crate::edit::world_bounds;
use crate::room::contacts::state::{Place, ShapeRecord};
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::{BodyFrame, Motion};
use crate::world::World;
use jounce_geometry::{
    Aabb, Manifold, ManifoldSet, PairCache, Shape, Sweep, TimeOfImpact, collide, stays_shallow,
    time_of_impact,
};
use jounce_math::{Pose, Vec3, WorldPose, scalar::f32s};

/// Bodies per unit, while the fast ones are looked for.
const BODIES: usize = 256;
/// Fast bodies per unit: few where there are few, since each may have many shapes.
fn unit_of(fast: usize) -> usize {
    (fast / 64).clamp(1, 32)
}
/// A body that moved less than this part of its inner radius cannot have passed anything.
const FAST: f32 = 0.5;
/// A turn over which an arc is hardly longer than its chord, rad.
const TURN_SMALL: f32 = 0.5;
/// Part of the inner radius that a sliding body may sink in within a step.
const GRAZE: f32 = 0.25;
/// Part of its way below which a body counts as stopped where it was.
const STOPPED: f32 = 0.01;
/// Halts that take a body's velocity, where every halt counts two and every step takes one: four steps in a row.
const HALTED: u8 = 5;
/// The part of that by which one that is deeper already may sink: with none, the least that a contact yields would hold it where it is.
const DEEPER: f32 = 0.1;
/// Halvings of the way of a body that goes too deep.
const HALVINGS: u32 = 6;

pub(crate) fn run(world: &mut World, _: &Step) {
    if !world.settings.continuous {
        return;
    }
    let mut hits = core::mem::take(&mut world.scratch.hits);
    hits.clear();
    let found = &mut world.scratch.found;
    found.begin(world.awake.step.len().div_ceil(BODIES), BODIES);
    let (bodies, frames, found) = (&world.bodies, &world.frames, &*found);
    // Only bullets look at what moves.
    let fixed = !(world.fixed_tree.is_empty() && world.unbounded.is_empty());
    let columns = (&world.awake.state[..], &mut world.awake.step[..]);
    world.tasks.for_each_piece(columns, BODIES, |first, (states, steps)| {
        for (s, b) in states.iter().zip(steps) {
            b.halted = b.halted.saturating_sub(1);
            let body = &bodies[b.body];
            if b.kind != BodyKind::Dynamic || !(fixed || body.bullet) {
                continue;
            }
            let mass = &body.mass;
            let s = s.get();
            // By the ball around it first, which is quickly asked.
            let limit = FAST * mass.inner_radius;
            let turn = s.dr.length();
            let moved = s.dp.length() + turn * (mass.outer_radius - mass.inner_radius);
            if !(moved > limit && moved.is_finite()) {
                continue;
            }
            let turned = frames[b.body as usize].rotation.inverse_rotate(s.dr);
            let swept = swept(turned, mass.outer_radius, mass.reach);
            if s.dp.length() + swept - turn * mass.inner_radius > limit {
                found.of(first / BODIES).push(b.body);
            }
        }
    });
    let mut fast = core::mem::take(&mut world.scratch.ends);
    fast.clear();
    world.scratch.found.gather(&mut fast);
    hits.extend(fast.iter().map(|&body| (body, 1.0)));
    world.scratch.ends = fast;
    let unit = unit_of(hits.len());
    let shared: &World = world;
    shared.tasks.for_each_chunk(&mut hits, unit, |_, chunk| {
        shared.scratch.sets.lend(|set| {
            for (slot, t) in chunk {
                *t = first_hit(shared, *slot, set);
            }
        });
    });
    hits.retain(|h| h.1 < 1.0);
    for &(slot, t) in &hits {
        let f = &mut world.frames[slot as usize];
        let turned = f.rotation;
        f.center = f.center0.lerp(f.center, f64::from(t));
        f.rotation = f.rotation0.nlerp(f.rotation, t);
        // The spin goes back with the body: in its own axes it stays, and with it energy and |L|.
        let back = f.rotation * turned.conjugate();
        let row = world.bodies[slot].row as usize;
        if let (Some(s), Some(b)) = (world.awake.state.get_mut(row), world.awake.step.get(row))
            && !b.isotropic
            && b.locks & 56 == 0
        {
            s.set_velocity(s.v(), back.rotate(s.w()));
        }
        halt(world, row, t);
        world.refresh_inertia(slot);
    }
    super::joints::follow(world, &hits);
    world.scratch.hits = hits;
}

/// A body that cannot go at all, for several steps, has no velocity: contacts would have taken it, but they see nothing that it runs into (it leans on an edge,
/// and its end swings into the surface). With it, it would hang there for ever, and gravity would go on adding to it; without, it goes on slowly, in the
/// hands of its contacts.
fn halt(world: &mut World, row: usize, t: f32) {
    let Some(b) = world.awake.step.get_mut(row).filter(|_| t < STOPPED) else { return };
    b.halted += 2;
    if b.halted >= HALTED {
        b.halted = 0;
        world.awake.state[row].set_velocity(Vec3::ZERO, Vec3::ZERO);
        world.awake.turning[row] = None;
    }
}

/// Fraction of the step after which the body first meets something it must not pass.
fn first_hit(world: &World, slot: u32, set: &mut ManifoldSet) -> f32 {
    let body = &world.bodies[slot];
    let f = &world.frames[slot as usize];
    let mut first = 1.0;
    let mut core = Core::default();
    let Some(state) = world.awake.state.get(body.row as usize).map(|s| s.get()) else { return first };
    for &s in &body.shapes {
        let r = &world.shapes[s];
        if r.sensor || r.place == Place::Nowhere {
            continue;
        }
        // A part near the middle of a long body may move little while its end is fast.
        let way = way(r, f, &state);
        if way < FAST * 0.5 * r.thickness {
            continue;
        }
        let bounds = |c, q: jounce_math::Quat| {
            let p = q.rotate(r.pose.p - f.local_center);
            world_bounds(&r.shape, &WorldPose::new(c + p.as_dvec3(), q * r.pose.q))
        };
        let mut see = |other: u32| {
            if broadphase::may_meet(world, s, other) {
                first = f32s::min(first, meet(world, [s, other], &mut core, set));
            }
            true
        };
        // Most of what is fast has nothing near, and a box around all that it can reach is quickly made.
        let far = world.fat[s as usize].expanded(way * 1.001 + 0.001 * r.thickness);
        let mut alone = !body.bullet;
        world.fixed_tree.query(&far, |_| {
            alone = false;
            false
        });
        if !alone {
            let swept: Aabb = bounds(f.center0, f.rotation0).union(&bounds(f.center, f.rotation));
            world.fixed_tree.query(&swept, &mut see);
            if body.bullet {
                world.moving_tree.get().query(&swept, &mut see);
            }
        }
        for &plane in &world.unbounded {
            see(plane);
        }
    }
    first
}

/// No point of the shape moved farther than this in the step.
fn way(r: &ShapeRecord, f: &BodyFrame, state: &Motion) -> f32 {
    let arm = r.pose.transform_point(r.middle) - f.local_center;
    let turn = state.dr.length();
    if turn > TURN_SMALL {
        return state.dp.length() + turn * (arm.length() + r.reach);
    }
    (state.dp + f.rotation.rotate(arm) - f.rotation0.rotate(arm)).length() + turn * r.reach
}

/// Time of impact of shape `s` against shape `other` over the last step.
fn meet(world: &World, [s, other]: [u32; 2], core: &mut Core, set: &mut ManifoldSet) -> f32 {
    let (rb, ra) = (&world.shapes[s], &world.shapes[other]);
    let (fb, fa) = (&world.frames[rb.body as usize], &world.frames[ra.body as usize]);
    let slop = world.settings.slop();
    let target = f32s::min(0.5 * slop, 0.05 * f32s::min(rb.thickness, ra.thickness));
    let at =
        |ca: jounce_math::DVec3, qa: jounce_math::Quat, cb: jounce_math::DVec3, qb: jounce_math::Quat| {
            let a = WorldPose::new(ca - qa.rotate(fa.local_center).as_dvec3(), qa).compose(&ra.pose);
            let b = WorldPose::new(cb - qb.rotate(fb.local_center).as_dvec3(), qb).compose(&rb.pose);
            a.relative(&b)
        };
    let start = at(fa.center0, fa.rotation0, fb.center0, fb.rotation0);
    let end = at(fa.center, fa.rotation, fb.center, fb.rotation);
    let local_center = rb.pose.inverse_transform_point(fb.local_center);
    let sweep = sweep_between(&start, &end, local_center);
    // What rolls, slides or rests goes nowhere deep.
    let limit = GRAZE * world.bodies[rb.body].mass.inner_radius;
    if stays_shallow(&ra.shape, &rb.shape, &sweep, limit) {
        return 1.0;
    }
    let first = match time_of_impact(&ra.shape, &rb.shape, &sweep, target, 0.25 * target) {
        TimeOfImpact::Separated => return 1.0,
        TimeOfImpact::Hit(t) if t > 1e-4 && grazes(world, [s, other], &sweep, (t, 2.0 * target), set) => 1.0,
        TimeOfImpact::Hit(t) | TimeOfImpact::Failed(t) if t > 1e-4 => t,
        _ => 1.0,
    };
    // A part that touches from the start is left out of the time of impact where there are others: the core sees it.
    let core = core.of(other, || core_hit(world, rb.body, &ra.shape, &sweep));
    shallow(world, [s, other], &sweep, f32s::min(first, core), set)
}

/// The last time up to `t` at which the body is no deeper in the shape than at the start or a part of its inner radius. A body
/// that touches with one end and turns quickly would swing the other, of which the contact does not know, deep in.
fn shallow(world: &World, [s, other]: [u32; 2], sweep: &Sweep, t: f32, set: &mut ManifoldSet) -> f32 {
    let (rb, ra) = (&world.shapes[s], &world.shapes[other]);
    // Of the points nearer than the margin.
    let mut deepest = |t: f32, margin: f32| {
        collide(&ra.shape, &rb.shape, &sweep.pose(t), margin, &mut PairCache::default(), set);
        let points = set.manifolds.iter().flat_map(Manifold::points);
        points.fold(0.0, |d, p| f32s::max(d, -p.separation))
    };
    let limit = GRAZE * world.bodies[rb.body].mass.inner_radius;
    // Nearly all of a surface is found not to be that deep at a first look.
    if deepest(t, -limit) <= limit {
        return t;
    }
    let mut depth = |t: f32| deepest(t, 0.0);
    let last = depth(t);
    if last <= limit {
        return t;
    }
    let limit = f32s::max(limit, depth(0.0) + DEEPER * limit);
    if last <= limit {
        return t;
    }
    let (mut lo, mut hi) = (0.0, t);
    for _ in 0..HALVINGS {
        let mid = 0.5 * (lo + hi);
        if depth(mid) <= limit { lo = mid } else { hi = mid }
    }
    lo
}

/// Does the body, from the time of impact on, only slide along the surface? Every point that touches then goes less deep
/// than a part of the inner radius: nothing passes, and the contacts of the next step push it out. Stopping it would take
/// away its way but not its speed, and gravity would go on adding to that.
fn grazes(
    world: &World,
    [s, other]: [u32; 2],
    sweep: &Sweep,
    (t, margin): (f32, f32),
    set: &mut ManifoldSet,
) -> bool {
    let (rb, ra) = (&world.shapes[s], &world.shapes[other]);
    let (then, end) = (sweep.pose(t), sweep.pose(1.0));
    collide(&ra.shape, &rb.shape, &then, margin, &mut PairCache::default(), set);
    let limit = GRAZE * world.bodies[rb.body].mass.inner_radius;
    let shallow = |m: &Manifold| {
        m.points().iter().all(|p| {
            let moved = end.transform_point(then.inverse_transform_point(p.point)) - p.point;
            -m.normal.dot(moved) < limit
        })
    };
    !set.manifolds.is_empty() && set.manifolds.iter().all(shallow)
}

/// What a body's core has met: all its shapes ask about the same few others.
#[derive(Default)]
struct Core {
    met: [Option<(u32, f32)>; 4],
    next: usize,
}

impl Core {
    fn of(&mut self, other: u32, hit: impl FnOnce() -> f32) -> f32 {
        if let Some((_, t)) = self.met.iter().flatten().find(|m| m.0 == other) {
            return *t;
        }
        let t = hit();
        self.met[self.next % self.met.len()] = Some((other, t));
        self.next += 1;
        t
    }
}

fn core_hit(world: &World, body: u32, a: &Shape, sweep: &Sweep) -> f32 {
    let radius = 0.5 * world.bodies[body].mass.inner_radius;
    if radius <= 0.0 {
        return 1.0;
    }
    let core = Sweep { local_center: Vec3::ZERO, ..*sweep };
    match time_of_impact(a, &Shape::Sphere { radius }, &core, 0.1 * radius, 0.05 * radius) {
        TimeOfImpact::Hit(t) | TimeOfImpact::Failed(t) if t > 0.0 => t,
        TimeOfImpact::Separated => 1.0,
        _ if goes_deeper(a, sweep) => 0.0,
        _ => 1.0,
    }
}

/// The core is in the surface already: does this motion take it farther in?
fn goes_deeper(a: &Shape, sweep: &Sweep) -> bool {
    let [from, to] = sweep.center;
    let Some(near) = a.closest_point(from) else { return false };
    let out = if near.distance < 0.0 { near.normal } else { (from - near.point).normalize_or(near.normal) };
    out.dot(to - from) < 0.0
}

fn sweep_between(start: &Pose, end: &Pose, local_center: Vec3) -> Sweep {
    Sweep {
        local_center,
        center: [start.transform_point(local_center), end.transform_point(local_center)],
        rotation: [start.q, end.q],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BodyDesc, ShapeDesc, WorldDesc};
    use jounce_geometry::Hull;
    use jounce_math::{DVec3, Quat};
    use std::sync::Arc;

    /// No corner of a part that is far from the body's centre moves farther than is said; and a body that rolls about its own axis
    /// is not taken to be fast at its ends.
    #[test]
    fn says_how_far_a_part_moves() {
        let mut state = 5_u32;
        let mut random = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut vec = |s: f32| Vec3::new(random(), random(), random()) * s;
        for k in 0..400 {
            let middle = vec(10.0);
            let corners: Vec<Vec3> = (0..12).map(|_| middle + vec(1.0)).collect();
            let hull = Arc::new(Hull::new(&corners).expect("a hull"));
            let mut w = World::new(WorldDesc::default()).expect("valid");
            let d = BodyDesc::dynamic()
                .shape(ShapeDesc::new(Shape::Hull(hull.clone())))
                .shape(ShapeDesc::sphere(1.0));
            let slot = w.add_body(d).expect("valid").index;
            let r = &w.shapes[w.bodies[slot].shapes[0]];
            let (dp, dr) = (vec(1.0), vec([0.1, 0.4, 2.0][k % 3]));
            let turn = Quat::from_axis_angle(dr.normalize_or(Vec3::Y), dr.length());
            let f = &mut w.frames[slot as usize];
            f.center = f.center0 + dp.as_dvec3();
            f.rotation = turn * f.rotation0;
            let motion = Motion { dp, dr, ..w.awake.state[0].get() };
            let way = way(r, f, &motion);
            let mut most = 0.0;
            for c in hull.vertices() {
                let arm = *c - f.local_center;
                let at = |c: DVec3, q: Quat| c + q.rotate(arm).as_dvec3();
                let moved = at(f.center, f.rotation) - at(f.center0, f.rotation0);
                most = f32s::max(most, moved.length() as f32);
            }
            assert!(most <= way * 1.0001, "{most} {way}");
            assert!(dr.length() > 0.4 || way < most + 2.5 * dr.length(), "{most} {way}");
        }
    }
}
