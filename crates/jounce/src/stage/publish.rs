//! Ends a step: bounds of what moved, sensors, hits; the clock.

use super::Step;
use super::flat::is_worth_it;
use crate::edit::margin_of;
use crate::event::Event;
use crate::room::contacts::state::{Contact, Place};
use crate::room::rigid::state::{BodyFrame, BodyStep};
use crate::world::World;
use jounce_geometry::Aabb;
use jounce_math::{Vec3, scalar::f32s};
use std::sync::{PoisonError, RwLock};

/// Bounds that are moved on one thread: another would come too late.
const FEW: usize = 64;

/// Bodies in a unit: few where there are few, since each may have many shapes.
fn unit_of(bodies: usize) -> usize {
    (bodies / 64).clamp(4, 128)
}

pub(crate) fn run(world: &mut World, step: &Step) {
    bounds(world, step);
    super::sensors::run(world);
    hits(world);
    world.step_count += 1;
    world.fields.time = world.time();
}

/// What left its bounds among a unit of bodies.
#[derive(Debug, Default)]
pub(crate) struct Moves(Vec<RwLock<Left>>);

impl Clone for Moves {
    /// Memory, not state: a clone starts without.
    fn clone(&self) -> Self {
        Self::default()
    }
}

#[derive(Debug, Default)]
struct Left {
    /// Shapes that left their fat bounds: slot, leaf and new bounds.
    bounded: Vec<(u32, u32, Aabb)>,
    unbounded: Vec<u32>,
}

/// Moves the fat bounds of shapes that left theirs.
fn bounds(world: &mut World, step: &Step) {
    let mut steps = core::mem::take(&mut world.awake.step);
    let mut moves = core::mem::take(&mut world.scratch.bounds);
    let unit = unit_of(steps.len());
    let units = steps.len().div_ceil(unit);
    moves.0.resize_with(units.max(moves.0.len()), RwLock::default);
    let shared: &World = world;
    let lists = &moves.0;
    shared.tasks.for_each_chunk(&mut steps, unit, |first, chunk| {
        // A unit locks its own list, so no lock is ever waited for.
        let mut left = lists[first / unit].write().unwrap_or_else(PoisonError::into_inner);
        left.bounded.clear();
        left.unbounded.clear();
        for (i, b) in chunk.iter_mut().enumerate() {
            b.moved = moved(&shared.frames[b.body as usize], b.radius, b.reach);
            b.room = look(shared, step, b, shared.awake.state[first + i].v(), &mut left);
        }
    });
    world.awake.step = steps;
    let count = moves.0[..units].iter_mut().map(|l| l.get_mut().unwrap_or_else(PoisonError::into_inner));
    let count = count.map(|l| l.bounded.len()).sum();
    // Where the next pair search does without the tree, it hears of this when somebody asks.
    let late = is_worth_it(world, count);
    // The tree and the columns beside it have nothing in common.
    let (mut tree, tasks) = (core::mem::take(&mut world.moving_tree), world.tasks.clone());
    let lists = &moves.0[..units];
    let left = || lists.iter().map(|l| l.read().unwrap_or_else(PoisonError::into_inner));
    let mut grow = || {
        if count > 0 {
            tree.put_off(|list| {
                for l in left() {
                    l.bounded.iter().for_each(|&(_, leaf, fat)| list(leaf, fat));
                }
            });
        }
        if !late {
            tree.get();
        }
    };
    let mut list = || {
        for l in left() {
            l.unbounded.iter().for_each(|&s| world.mark_moved(s));
            for &(s, _, fat) in &l.bounded {
                world.fat[s as usize] = fat;
                world.list_moved(s);
            }
        }
    };
    if count > FEW {
        tasks.join(grow, list);
    } else {
        grow();
        list();
    }
    world.moving_tree = tree;
    world.scratch.bounds = moves;
}

/// The room that a body still has; what left its bounds goes into the list. What has not moved as far as it has room is not looked at.
fn look(world: &World, step: &Step, b: &BodyStep, v: Vec3, left: &mut Left) -> f32 {
    let room = b.room - b.moved[0];
    let ahead = v * step.dt;
    // Room for a step ahead, which most have, will do for those that do not look ahead, too.
    if room > ahead.length() {
        return room;
    }
    // Bouncing pairs must be seen a step ahead.
    let far = world.bouncy > 0 || world.frames[b.body as usize].looks_ahead;
    if !far && room > 0.0 {
        return room;
    }
    let ahead = if far { ahead } else { Vec3::ZERO };
    let mut room = f32::INFINITY;
    for &s in &world.bodies[b.body].shapes {
        let r = &world.shapes[s];
        let leaf = match r.place {
            Place::MovingTree(leaf) => leaf,
            Place::Unbounded => {
                left.unbounded.push(s);
                room = 0.0;
                continue;
            }
            _ => continue,
        };
        let tight = world.tight_bounds(s);
        let next = tight.union(&Aabb::new(tight.min + ahead, tight.max + ahead));
        let mut fat = world.fat[s as usize];
        if !fat.contains(&next) {
            fat = next.expanded(margin_of(&next, world.settings.length_unit));
            left.bounded.push((s, leaf, fat));
        }
        // The radius is that of the solid shapes.
        room = f32s::min(room, if r.sensor { 0.0 } else { slack(&fat, &tight) });
    }
    room
}

/// How far the farthest point of a body went in the step, at most, m; and 2 sin(θ/2) of its turn, at most.
pub(crate) fn moved(f: &BodyFrame, radius: f32, reach: Vec3) -> [f32; 2] {
    let way = (f.center - f.center0).length() as f32;
    // A turn by θ about u moves p by 2 sin(θ/2) |u × p|, and its quaternion has sin(θ/2) u.
    let turn = (f.rotation * f.rotation0.conjugate()).xyz();
    let way = 1.001 * (way + 2.0 * swept(f.rotation.inverse_rotate(turn), radius, reach));
    // Sums of many turns must not lose what is rounded away of each.
    [way, 2.002 * turn.length() + 2.0 * f32::EPSILON]
}

/// The most of |t × p| for the points of a body, which lie in a ball and in a box about its centre of mass; all in its own axes. What is long
/// and turns about its length goes nowhere far.
pub(crate) fn swept(t: Vec3, radius: f32, reach: Vec3) -> f32 {
    let t = t.abs();
    let ball = radius * t.length();
    let (x, y, z) =
        (t.y * reach.z + t.z * reach.y, t.z * reach.x + t.x * reach.z, t.x * reach.y + t.y * reach.x);
    // The rounding of t makes the axis lean.
    let boxed = Vec3::new(x, y, z).length() + 1e-5 * ball;
    if boxed < ball { boxed } else { ball }
}

/// The way in any direction that keeps `inner` in `outer`, but for the rounding of both.
fn slack(outer: &Aabb, inner: &Aabb) -> f32 {
    let least = f32s::min((inner.min - outer.min).min_component(), (outer.max - inner.max).min_component());
    let size = f32s::max(outer.min.abs().max_component(), outer.max.abs().max_component());
    least - 4.0 * f32::EPSILON * size
}

fn hits(world: &mut World) {
    if world.telling == 0 {
        return;
    }
    let threshold = world.settings.hit_event_speed;
    for row in 0..world.contacts.len() {
        let c = &world.contacts[row];
        if c.hit_speed >= threshold
            && (world.shapes[c.shape_a].hit_events || world.shapes[c.shape_b].hit_events)
        {
            let event = hit(world, c);
            world.events.push(event);
        }
    }
}

fn hit(world: &World, c: &Contact) -> Event {
    let fa = &world.frames[c.body_a as usize];
    let (mut impulse, mut most, mut at, mut normal) = (0.0, -1.0, jounce_math::Vec3::ZERO, c.manifold.normal);
    for m in c.manifolds() {
        for (anchor, total) in m.anchors.iter().zip(m.totals).take(usize::from(m.count)) {
            impulse += total;
            if total > most {
                (most, at, normal) = (total, anchor.on_a, m.normal);
            }
        }
    }
    Event::ContactHit {
        a: world.shape_id(c.shape_a),
        b: world.shape_id(c.shape_b),
        point: fa.center + fa.rotation.rotate(at).as_dvec3(),
        normal,
        speed: c.hit_speed,
        impulse,
    }
}

#[cfg(test)]
mod tests {
    use super::{moved, swept};
    use crate::room::rigid::state::BodyFrame;
    use jounce_math::{DVec3, Quat, Vec3, scalar::f32s};

    /// No point of a box goes farther than is said, however it turns; and what turns about its length is not said to go far.
    #[test]
    fn says_how_far_a_body_moves_at_most() {
        let half = Vec3::new(0.5, 20.0, 0.25);
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        for i in 0..500 {
            let mut v = || Vec3::new(random(), random(), random());
            let (axis, start, way) = (v(), v(), v());
            let axis = if i % 3 == 0 { Vec3::Y + axis * 1e-3 } else { axis };
            let rotation0 = Quat::from_axis_angle(start.normalize_or(Vec3::X), 3.0 * start.length());
            let turn =
                Quat::from_axis_angle(rotation0.rotate(axis.normalize_or(Vec3::Y)), 0.1 + start.x.abs());
            let mut f =
                BodyFrame { rotation0, rotation: (turn * rotation0).normalize(), ..BodyFrame::default() };
            f.center = way.as_dvec3();
            let [most, turned] = moved(&f, half.length(), half);
            assert!(turned >= 2.0 * f32s::sin(0.5 * (0.1 + start.x.abs())), "{turned}");
            for k in 0..8 {
                let sign = |bit: i32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let p = Vec3::new(half.x * sign(0), half.y * sign(1), half.z * sign(2));
                let went: DVec3 = f.center + (f.rotation.rotate(p) - rotation0.rotate(p)).as_dvec3();
                assert!(went.length() as f32 <= most, "{} of {most} at most", went.length());
            }
        }
        let along = swept(Vec3::Y * 0.1, half.length(), half);
        assert!(along < 0.1 * 0.6 && swept(Vec3::X * 0.1, half.length(), half) > 1.9);
    }
}
