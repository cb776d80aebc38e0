//! What wheels and boards stand on. The shapes that a wheel may meet are gathered once a step; in every substep it is cast at them where all of
//! them are by then. So a curb is met at the substep in which the tread comes to it, and a mesh is followed triangle by triangle.

use super::Step;
use crate::handle::BodyId;
use crate::query::{QueryFilter, Ray};
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::{BodyFrame, NONE};
use crate::room::vehicles::board::STATIONS;
use crate::room::vehicles::desc::WheelCast;
use crate::room::vehicles::solve::KAPPA_MIN;
use crate::room::vehicles::state::Vehicle;
use crate::world::World;
use jounce_geometry::{Aabb, NO_SUB, Shape};
use jounce_math::{DVec3, Quat, Vec3, WorldPose, scalar::f32s};

/// Looks in one unit of work.
const UNIT: usize = 4;

/// A wheel's, or station's, look at the ground. Memory, not state.
#[derive(Clone, Debug, Default)]
pub(super) struct Look {
    pub vehicle: u32,
    /// Wheels first, then stations.
    pub foot: usize,
    /// Shapes that it may meet in this step.
    near: Vec<u32>,
    pub hit: Option<Hit>,
}

/// Where a foot meets the ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub shape: u32,
    /// Triangle or child.
    pub part: u32,
    pub point: DVec3,
    pub normal: Vec3,
}

/// All looks of a step; the first `count` are of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Looks {
    all: Vec<Look>,
    count: usize,
}

impl Looks {
    pub fn list(&self) -> &[Look] {
        &self.all[..self.count]
    }

    /// At the start of a step: what every foot may meet, and what it stands on.
    pub fn gather(&mut self, world: &World, step: &Step, acts: impl Fn(&Vehicle) -> bool) {
        self.count = 0;
        for (vehicle, v) in world.vehicles.table.iter().filter(|(_, v)| acts(v)) {
            for foot in 0..v.feet().count() {
                if self.all.len() == self.count {
                    self.all.push(Look::default());
                }
                let look = &mut self.all[self.count];
                (look.vehicle, look.foot, look.hit) = (vehicle, foot, None);
                self.count += 1;
            }
        }
        world.tasks.for_each(&mut self.all[..self.count], UNIT, |_, l| {
            let v = &world.vehicles.table[l.vehicle];
            l.near.clear();
            gather(world, v, l.foot, step.dt, &mut l.near);
            l.hit = look(world, v, l, step.dt, false);
        });
    }

    /// In a substep.
    pub fn renew(&mut self, world: &World, step: &Step) {
        world.tasks.for_each(&mut self.all[..self.count], UNIT, |_, l| {
            l.hit = look(world, &world.vehicles.table[l.vehicle], l, step.constants.h, true);
        });
    }
}

/// In the chassis' frame.
pub(super) fn station(v: &Vehicle, i: usize) -> Vec3 {
    let Some(d) = &v.desc.board else { return Vec3::ZERO };
    let left = v.desc.up.cross(v.desc.forward);
    let (x, y) = STATIONS[i];
    d.position + v.desc.forward * (0.5 * x * d.length) + left * (0.5 * y * d.width)
}

/// Shapes by the way of a foot in the step. What moves itself is found where it is as the step begins.
fn gather(world: &World, v: &Vehicle, foot: usize, dt: f32, near: &mut Vec<u32>) {
    let frame = &world.frames[v.chassis as usize];
    let up = frame.rotation.rotate(v.desc.up);
    let (local, above, below, radius) = match (v.desc.wheels.get(foot), &v.desc.board) {
        (Some(d), _) => {
            let (r, half) = (d.radius, 0.4 * d.width);
            (d.position, d.bump, d.droop + d.radius, (r * r + half * half).sqrt())
        }
        (None, Some(d)) => (station(v, foot - v.wheels.len()), d.reach, d.reach, 0.0),
        (None, None) => return,
    };
    let lever = frame.rotation.rotate(local - frame.local_center);
    let (velocity, w) = world.velocities(&world.bodies[v.chassis]);
    let way = (velocity + w.cross(lever)) * dt;
    let at = (frame.center + lever.as_dvec3()).as_vec3();
    // Brakes, and what it runs into, may turn its way: by half of it to all sides.
    let room = radius + 0.5 * way.length() + world.settings.slop() + 1e-6 * at.abs().max_component();
    let corners = [at + up * above, at - up * below, at + up * above + way, at - up * below + way];
    let (min, max) = corners.iter().fold((at, at), |(min, max), &c| (min.min(c), max.max(c)));
    let bounds = Aabb { min: min - Vec3::splat(room), max: max + Vec3::splat(room) };
    let apart = |s: crate::ShapeId| !world.are_parted(v.chassis, world.shapes[s.index].body);
    let exclude: BodyId = world.body_id(v.chassis);
    let filter = QueryFilter::default().layers(v.desc.ground_layers).excluding(exclude).only(&apart);
    near.extend(world.unbounded.iter().filter(|&&slot| world.sees(slot, &filter)));
    for tree in [&world.fixed_tree, world.moving_tree.get()] {
        tree.query(&bounds, |slot| {
            if world.sees(slot, &filter) {
                near.push(slot);
            }
            true
        });
    }
}

/// A body where it is: `moved` within a step.
fn placed(world: &World, body: u32, moved: bool) -> BodyFrame {
    let mut f = world.frames[body as usize];
    if let (true, Some(s)) = (moved && f.row != NONE, world.awake.state.get(f.row as usize)) {
        let m = s.get();
        f.center += m.dp.as_dvec3();
        if m.dq != Quat::IDENTITY {
            f.rotation = (m.dq * f.rotation).normalize();
        }
    }
    f
}

/// What a foot meets in the middle of a `time`: of the step that begins, or, where bodies have `moved` since it began, of a substep.
fn look(world: &World, v: &Vehicle, l: &Look, time: f32, moved: bool) -> Option<Hit> {
    let near = Near { world, shapes: &l.near, moved };
    let frame = placed(world, v.chassis, moved);
    if l.foot < v.wheels.len() {
        under_wheel(&near, v, l.foot, &frame, time)
    } else {
        under_station(&near, v, l.foot - v.wheels.len(), &frame)
    }
}

fn under_wheel(near: &Near<'_>, v: &Vehicle, i: usize, frame: &BodyFrame, time: f32) -> Option<Hit> {
    let (d, s) = (&v.desc.wheels[i], &v.wheels[i]);
    let q = frame.rotation;
    let up = q.rotate(v.desc.up);
    let (velocity, w) = near.world.velocities(&near.world.bodies[v.chassis]);
    let lever = q.rotate(d.position - frame.local_center);
    let ahead = (velocity + w.cross(lever)) * (0.5 * time);
    let top = frame.center + (lever + ahead + up * d.bump).as_dvec3();
    let way = d.bump + d.droop;
    let left = v.desc.up.cross(v.desc.forward);
    let axle = q.rotate(Quat::from_axis_angle(v.desc.up, s.steer).rotate(left));
    let shape = match d.cast {
        WheelCast::Ray => return near.ray(top, -up, way + d.radius, up),
        WheelCast::Sphere => Shape::Sphere { radius: d.radius },
        WheelCast::Cylinder => Shape::Cylinder { half_height: 0.4 * d.width, radius: d.radius },
    };
    let from = WorldPose::new(top, Quat::from_rotation_arc(Vec3::Y, axle));
    let motion = up * -(way + 0.1 * d.radius);
    if let Some((t, rough)) = near.cast(&shape, &from, motion, up) {
        let hub = top + (motion * t).as_dvec3();
        // A face gives its own plane, to the last bit.
        let fine = near.ray(hub, -rough.normal, 1.5 * d.radius, rough.normal);
        return fine.filter(|f| f.shape == rough.shape && f.normal.dot(rough.normal) > 0.999).or(Some(rough));
    }
    near.ray(top, -up, way + d.radius, up)
}

fn under_station(near: &Near<'_>, v: &Vehicle, i: usize, frame: &BodyFrame) -> Option<Hit> {
    let d = v.desc.board.as_ref()?;
    let up = frame.rotation.rotate(v.desc.up);
    let p = frame.pose().transform_point(station(v, i)) + (up * d.reach).as_dvec3();
    near.ray(p, -up, 2.0 * d.reach, up)
}

/// Shapes near a foot, where they are.
struct Near<'a> {
    world: &'a World,
    shapes: &'a [u32],
    moved: bool,
}

impl Near<'_> {
    fn pose(&self, slot: u32) -> WorldPose {
        let r = &self.world.shapes[slot];
        if self.moved { placed(self.world, r.body, true).shape_pose(&r.pose) } else { self.world.pose_of(r) }
    }

    /// The first that a shape meets on its way, and when (0 to 1), of what faces `up`: walls beside a wheel are passed by. The lowest slot
    /// of equals.
    fn cast(&self, shape: &Shape, from: &WorldPose, motion: Vec3, up: Vec3) -> Option<(f32, Hit)> {
        let mut best: Option<(f32, Hit)> = None;
        for &slot in self.shapes {
            let pose = self.pose(slot);
            let Some(h) = self.world.cast_on_shape(slot, &pose, shape, from, motion) else { continue };
            let normal = pose.q.rotate(h.normal);
            if normal.dot(up) > KAPPA_MIN && best.is_none_or(|(t, b)| (h.t, slot) < (t, b.shape)) {
                let point = pose.transform_point(h.point);
                best = Some((h.t, Hit { shape: slot, part: part(h.sub_a), point, normal }));
            }
        }
        best
    }

    /// The first that a ray meets; nothing where that does not face `up`.
    fn ray(&self, origin: DVec3, dir: Vec3, length: f32, up: Vec3) -> Option<Hit> {
        let ray = Ray { origin, dir, max_t: length };
        let mut best: Option<(f32, Hit)> = None;
        for &slot in self.shapes {
            let pose = self.pose(slot);
            let bound = best.map_or(length, |(t, _)| f32s::min(t * (1.0 + 8.0 * f32::EPSILON), length));
            let Some(h) = self.world.ray_on_shape_at(slot, &pose, &ray, bound) else { continue };
            if best.is_none_or(|(t, b)| (h.hit.t, slot) < (t, b.shape)) {
                let point = origin + dir.as_dvec3() * h.t;
                let normal = pose.q.rotate(h.hit.normal);
                best = Some((h.hit.t, Hit { shape: slot, part: part(h.hit.sub), point, normal }));
            }
        }
        best.filter(|(t, h)| *t > 0.0 && h.normal.dot(up) > KAPPA_MIN).map(|(_, h)| h)
    }
}

/// Of what has no parts, the first.
fn part(sub: u32) -> u32 {
    if sub == NO_SUB { 0 } else { sub }
}

/// Bodies that sleep under a foot.
pub(super) fn sleepers<'a>(world: &'a World, looks: &'a Looks) -> impl Iterator<Item = u32> + 'a {
    let bodies = looks.list().iter().filter_map(|l| l.hit).map(|h| world.shapes[h.shape].body);
    bodies.filter(|&b| world.bodies[b].kind == BodyKind::Dynamic && world.bodies[b].island != NONE)
}
