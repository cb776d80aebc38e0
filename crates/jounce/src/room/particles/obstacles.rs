//! The shapes near a block of particles.

use super::collide::Obstacle;
use super::edit::start_pose;
use super::prepare::{EmitterStep, Rules};
use super::solve::{Next, Out};
use super::state::Emitter;
use crate::edit::{round_down, round_up};
use crate::limits;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_geometry::{Aabb, Shape};
use jounce_math::{DVec3, Pose, Vec3, WorldPose, scalar::f32s};

/// Farthest that a point of the body moved in this step, m. A bound.
fn moved(world: &World, body: u32) -> f32 {
    let f = &world.frames[body as usize];
    if f.row == NONE {
        return 0.0;
    }
    let turn = f.rotation0.inverse_mul(f.rotation).xyz().length();
    // The chord of a turn by θ at distance R is 2 R sin(θ/2), and |xyz| is sin(θ/2).
    (f.center - f.center0).as_vec3().length() + 2.0 * turn * world.bodies[body].mass.outer_radius
}

/// Farthest that any point of any body moved: the trees know the bounds before that motion.
pub(crate) fn reach(world: &World) -> f32 {
    let far = world.awake.step.iter().fold(0.0, |m, b| f32s::max(moved(world, b.body), m));
    f32s::min(far, 1e6)
}

/// A shape as particles that count from `origin` meet it; `push`: dynamic bodies are pushed.
pub(crate) fn obstacle(world: &World, slot: u32, origin: DVec3, push: bool) -> Option<Obstacle> {
    let r = world.shapes.get(slot)?;
    let f = &world.frames[r.body as usize];
    let body = &world.bodies[r.body];
    let from_origin = |p: WorldPose| Pose::new((p.p - origin).as_vec3(), p.q);
    let moving = f.row != NONE && (f.center != f.center0 || f.rotation != f.rotation0);
    let pose = f.shape_pose(&r.pose);
    let plane = match r.shape {
        Shape::HalfSpace { normal, offset } if !moving => {
            let n = pose.q.rotate(normal);
            // In f64: the origins may be far apart.
            let there = n.as_dvec3().dot(origin - pose.p);
            Some((n, (f64::from(offset) - there) as f32))
        }
        _ => None,
    };
    let end = from_origin(pose);
    let start = if moving { from_origin(start_pose(f, &r.pose)) } else { end };
    let (velocity, spin) = if f.row == NONE { (Vec3::ZERO, Vec3::ZERO) } else { world.velocities(body) };
    let (lo, hi) = bounds(world, slot, origin);
    Some(Obstacle {
        slot,
        body: r.body,
        start,
        end,
        moving,
        plane,
        lo,
        hi,
        velocity,
        spin,
        center: (f.center - origin).as_vec3(),
        pushed: push && body.kind == BodyKind::Dynamic && body.mass.inv_mass > 0.0,
        near: 0,
    })
}

/// Bounds of a shape over the step, from the origin; everything for half-spaces.
fn bounds(world: &World, slot: u32, origin: DVec3) -> (Vec3, Vec3) {
    let r = &world.shapes[slot];
    if matches!(r.shape, Shape::HalfSpace { .. }) {
        return (Vec3::splat(f32::MIN), Vec3::splat(f32::MAX));
    }
    let by = Vec3::splat(moved(world, r.body));
    let fat = &world.fat[slot as usize];
    let (lo, hi) = (fat.min.as_dvec3() - origin, fat.max.as_dvec3() - origin);
    let down = Vec3::new(round_down(lo.x), round_down(lo.y), round_down(lo.z));
    let up = Vec3::new(round_up(hi.x), round_up(hi.y), round_up(hi.z));
    (down - by, up + by)
}

/// Finds the shapes that the particles of a block may meet in this step, by slot.
pub(crate) fn gather(
    world: &World,
    e: &Emitter,
    step: &EmitterStep,
    rules: &Rules,
    next: &Next,
    reach: f32,
    out: &mut Out,
) {
    out.obstacles.clear();
    out.slots.clear();
    if next.lo.x > next.hi.x {
        return;
    }
    let far = f32s::max(next.lo.abs().max_component(), next.hi.abs().max_component());
    let grow = 1.01 * next.radius * rules.desc.radius_scale + far * (1.0 / 262_144.0);
    let (lo, hi) = (next.lo - Vec3::splat(grow), next.hi + Vec3::splat(grow));
    let (low, high) = (step.origin + lo.as_dvec3(), step.origin + hi.as_dvec3());
    let bounds = Aabb::new(
        Vec3::new(round_down(low.x), round_down(low.y), round_down(low.z)),
        Vec3::new(round_up(high.x), round_up(high.y), round_up(high.z)),
    );
    let mut see = |slot: u32| {
        out.slots.push(slot);
        true
    };
    world.fixed_tree.query(&bounds, &mut see);
    world.moving_tree.get().query(&bounds.expanded(reach), &mut see);
    out.slots.extend_from_slice(&world.unbounded);
    // The order of the trees is theirs.
    out.slots.sort_unstable();
    let own = e.desc.body.and_then(|b| world.slot(b).ok());
    for i in 0..out.slots.len() {
        let slot = out.slots[i];
        let r = &world.shapes[slot];
        if r.sensor || own == Some(r.body) || !rules.desc.filter.allows(&r.filter) {
            continue;
        }
        let Some(o) = obstacle(world, slot, step.origin, rules.desc.push) else { continue };
        if !o.may_meet(lo, hi) {
            continue;
        }
        if out.obstacles.len() >= limits::PARTICLE_OBSTACLES_MAX {
            out.crowded = true;
            break;
        }
        out.obstacles.push(o);
    }
}

impl Obstacle {
    /// Does a box come near it?
    fn may_meet(&self, lo: Vec3, hi: Vec3) -> bool {
        let Some((n, offset)) = self.plane else { return self.meets(lo, hi) };
        let (center, half) = ((lo + hi) * 0.5, (hi - lo) * 0.5);
        n.dot(center) - half.dot(n.abs())
            <= offset + 1e-5 * (half.max_component() + center.abs().max_component())
    }
}
