//! Manifolds of every awake contact: recycled where the two bodies hardly moved against each other, tested anew otherwise.

use super::{Step, broadphase};
use crate::hooks::{ContactView, PairView};
use crate::room::contacts::crowd;
use crate::room::contacts::desc::{Combine, Material};
use crate::room::contacts::state::{Anchor, Contact, ContactManifold, PairHead, Point, ShapeRecord, Surface};
use crate::room::rigid::state::{BodyFrame, NONE};
use crate::world::World;
use jounce_geometry::{Batch, Manifold, ManifoldSet, Shape};
use jounce_lanes::prefetch;
use jounce_math::{Pose, Quat, Vec3, scalar::f32s};

/// Contacts per unit at most: the bits of a word.
const CHUNK: usize = 64;
/// Contacts per unit: few where there are few, since one on a mesh may take as long as many others.
pub(super) fn unit_of(contacts: usize) -> usize {
    (contacts / 64).clamp(8, CHUNK)
}
/// Pairs from the one that is looked at to the one that is asked for.
const AHEAD: usize = 4;
/// The same in the pass over all pairs, and in that over those that are tested.
const HEADS_AHEAD: usize = 8;
const TESTS_AHEAD: usize = 2;
/// sin²(θ/2) of the largest turn of a body over which a manifold is recycled (10°).
const RECYCLE_SIN_HALF_SQUARED: f32 = 0.007_6;
/// A little less than its root.
const RECYCLE_SIN_HALF: f32 = 0.087_1;
/// Part of the way over which a manifold is recycled that centres may go until the pair is looked at again.
const NEAR: f32 = 0.25;
/// Of the rounding of a pose, in parts of its distance: some thirty units in the last place.
const ROUNDING: f32 = 4e-6;

pub(crate) fn run(world: &mut World, step: &Step) {
    let (mut contacts, mut heads) = (core::mem::take(&mut world.contacts), core::mem::take(&mut world.heads));
    let unit = unit_of(contacts.len());
    let units = contacts.len().div_ceil(unit);
    world.scratch.news.at_least(units);
    let shared: &World = world;
    let recycles = recycles(shared);
    let columns = (&mut contacts[..], &mut heads[..]);
    shared.tasks.for_each_chunk2(columns, unit, |first, chunk, heads| {
        let (mut news, mut renewed) = (0, 0);
        // Three passes, each of which asks ahead for what its own pairs read: most pairs stay apart, most others hardly moved.
        let near = Picked::among(chunk.len(), |i| {
            call_head(shared, heads, i + HEADS_AHEAD);
            let h = &mut heads[i];
            h.kept = h.touching && recycles && is_kept(shared, h);
            !(h.kept || stays_apart(shared, h))
        });
        let mut tests = Picked::NONE;
        for k in 0..near.count + AHEAD {
            if let Some(i) = near.get(k) {
                call(shared, &chunk[i], &heads[i]);
            }
            let Some(i) = k.checked_sub(AHEAD).and_then(|k| near.get(k)) else { continue };
            let (c, h) = (&mut chunk[i], &mut heads[i]);
            match look(shared, c, step.dt) {
                Some(room) => news |= u64::from(finish(shared, c, h, room)) << i,
                None => tests.push(i),
            }
        }
        if tests.count > 0 {
            shared.scratch.batches.lend(|batch| {
                batch.clear();
                for k in 0..tests.count + TESTS_AHEAD {
                    if let Some(i) = tests.get(k) {
                        shared.shapes.call(chunk[i].shape_a);
                        shared.shapes.call(chunk[i].shape_b);
                    }
                    if let Some(i) = k.checked_sub(TESTS_AHEAD).and_then(|k| tests.get(k)) {
                        aim(shared, &mut chunk[i], batch, step.dt);
                    }
                }
                batch.run(shared.width);
                shared.scratch.sets.lend(|set| {
                    for (k, i) in (0..tests.count).filter_map(|k| tests.get(k)).enumerate() {
                        let (c, h) = (&mut chunk[i], &mut heads[i]);
                        test(shared, c, batch, k, set);
                        // How far ahead a bouncing pair looks changes from step to step.
                        let room = match (c.manifold.count > 0, c.bouncy) {
                            (true, _) => turns_left(c, between(shared, h.bodies), 0.0, [0.0; 2]),
                            (false, true) => 0.0,
                            (false, false) => c.spare,
                        };
                        news |= u64::from(finish(shared, c, h, room)) << i;
                        renewed |= u64::from(h.fixed && c.now_touching) << i;
                    }
                });
            });
        }
        shared.scratch.news.set(first / unit, news, renewed);
    });
    // Before rows change: ends of contacts close the gaps.
    let mut renewed = core::mem::take(&mut world.scratch.renewed);
    renewed.clear();
    world.scratch.news.renewed(units, |at, i| renewed.extend(heads[at * unit + i].bodies));
    world.scratch.renewed = renewed;
    (world.contacts, world.heads) = (contacts, heads);
}

/// Some of the pairs of a unit, in order.
struct Picked {
    items: [u8; CHUNK],
    count: usize,
}

impl Picked {
    const NONE: Self = Self { items: [0; CHUNK], count: 0 };
    fn among(n: usize, mut pick: impl FnMut(usize) -> bool) -> Self {
        let mut out = Self::NONE;
        // Written whether picked or not: no jump that cannot be foreseen.
        for i in 0..n.min(CHUNK) {
            out.items[out.count] = i as u8;
            out.count += usize::from(pick(i));
        }
        out
    }
    fn push(&mut self, i: usize) {
        self.items[self.count] = i as u8;
        self.count += 1;
    }
    fn get(&self, k: usize) -> Option<usize> {
        self.items[..self.count].get(k).map(|&i| usize::from(i))
    }
}

/// Asks for what says whether a pair stays apart.
fn call_head(world: &World, heads: &[PairHead], i: usize) {
    let Some(h) = heads.get(i) else { return };
    h.bodies.iter().for_each(|&b| prefetch(&world.travel[b as usize]));
    h.shapes.iter().for_each(|&s| prefetch(&world.fat[s as usize]));
}

/// Asks for what the look at a pair will read.
fn call(world: &World, c: &Contact, h: &PairHead) {
    h.bodies.iter().for_each(|&b| prefetch(&world.frames[b as usize]));
    if h.touching {
        prefetch(c);
    } else {
        prefetch(&c.id);
        prefetch(&c.edge);
        prefetch(&c.tested_rotations);
    }
}

/// Has the pair not come together as far as it was apart?
fn stays_apart(world: &World, h: &PairHead) -> bool {
    !h.touching && gone(world, h, false) < h.until && bounds_overlap(world, h)
}

fn bounds_overlap(world: &World, h: &PairHead) -> bool {
    world.fat[h.shapes[0] as usize].overlaps(&world.fat[h.shapes[1] as usize])
}

/// What the bodies of a pair have done, of which the head says up to where it is certain what a look would find: their ways, or, where they touch,
/// their turns.
fn gone(world: &World, h: &PairHead, touching: bool) -> f64 {
    let [a, b] = h.bodies.map(|b| world.travel[b as usize][usize::from(touching)]);
    a + b
}

/// Two points nearer than a centimetre (squared) may be one.
const NEAR_SQUARED: f32 = 1e-4;

/// Pose of body B's centre of mass in body A's.
pub(crate) fn relative_pose(world: &World, c: &Contact) -> Pose {
    let (fa, fb) = (&world.frames[c.body_a as usize], &world.frames[c.body_b as usize]);
    let d = (fb.center - fa.center).as_vec3();
    Pose::new(fa.rotation.inverse_rotate(d), fa.rotation.inverse_mul(fb.rotation))
}

/// Gives how far the two may still come together, or turn, before they need to be looked at, m (0 where that is in the next step), or `None`
/// where they are to be tested in the pose that is noted.
fn look(world: &World, c: &mut Contact, dt: f32) -> Option<f32> {
    let apart = !bounds_meet(world, c);
    put(&mut c.apart, apart);
    if c.apart {
        return Some(0.0);
    }
    let pose = relative_pose(world, c);
    let mut room = 0.0;
    if recycle(world, c, &pose, &mut room, dt) {
        return Some(room);
    }
    let rotation = |b: u32| world.frames[b as usize].rotation;
    c.tested = true;
    c.tested_pose = pose;
    c.tested_rotations = [rotation(c.body_a), rotation(c.body_b)];
    None
}

/// Concludes the look at a pair; gives whether something changed that others must know.
fn finish(world: &World, c: &mut Contact, h: &mut PairHead, mut room: f32) -> bool {
    if c.apart {
        put(&mut c.now_touching, false);
    } else {
        if let Some((_, hook)) = &world.hooks.contact {
            ask_hook(world, c, hook.as_ref());
        }
        let touches = c.manifold.count > 0;
        put(&mut c.now_touching, touches);
        note_depth(c);
        // With a hook or without recycling every step tests; half-spaces have no bounds to tell when they part.
        if !recycles(world) || c.planes != [false; 2] {
            room = 0.0;
        }
    }
    (h.looked, h.near) = (between(world, h.bodies), NEAR * c.recycle_tolerance);
    h.until = if room > 0.0 {
        gone(world, h, c.now_touching) + f64::from(room) * 0.9999
    } else {
        f64::NEG_INFINITY
    };
    c.apart || c.now_touching != c.touching
}

/// Is some point of the contact deep?
fn note_depth(c: &mut Contact) {
    let limit = -crowd::DEEP_SLOPS * c.slop;
    let deep = |m: &ContactManifold| m.points.iter().take(usize::from(m.count)).any(|p| p.separation < limit);
    let deep = c.manifolds().any(deep);
    put(&mut c.deep, deep);
}

/// Writes what changes only: a line that nothing was written to need not go back to memory.
fn put(to: &mut bool, value: bool) {
    if *to != value {
        *to = value;
    }
}

fn bounds_meet(world: &World, c: &Contact) -> bool {
    match c.planes {
        [true, _] => broadphase::near_plane(world, c.shape_a, c.shape_b),
        [_, true] => broadphase::near_plane(world, c.shape_b, c.shape_a),
        _ => world.fat[c.shape_a as usize].overlaps(&world.fat[c.shape_b as usize]),
    }
}

/// How far B's shape has gone against A since the last test.
fn way(c: &Contact, pose: &Pose) -> f32 {
    let mut moved = pose.p - c.tested_pose.p;
    if c.middle_b != Vec3::ZERO {
        moved += pose.q.rotate(c.middle_b) - c.tested_pose.q.rotate(c.middle_b);
    }
    let turn = c.tested_pose.q.inverse_mul(pose.q).xyz().length();
    moved.length() + 2.0 * turn * c.extent_b
}

/// sin²(θ/2) of each body's turn in the world since then.
fn turns(world: &World, c: &Contact) -> [f32; 2] {
    let turned =
        |b: u32, then: Quat| then.inverse_mul(world.frames[b as usize].rotation).xyz().length_squared();
    [turned(c.body_a, c.tested_rotations[0]), turned(c.body_b, c.tested_rotations[1])]
}

/// Is what the last test found no longer true?
fn is_too_far(c: &Contact, moved: f32, turned: [f32; 2]) -> bool {
    turned.iter().any(|&t| t > RECYCLE_SIN_HALF_SQUARED) || moved > c.recycle_tolerance
}

fn recycles(world: &World) -> bool {
    world.settings.recycle_contacts && world.hooks.contact.is_none()
}

/// Keeps the manifolds of the last test when the pair moved less than the tolerance since; only the gaps are new.
fn recycle(world: &World, c: &mut Contact, pose: &Pose, room: &mut f32, dt: f32) -> bool {
    if !c.tested || !recycles(world) {
        return false;
    }
    let moved = way(c, pose);
    if c.spare > moved * (1.0 + 1e-5) {
        if !c.bouncy {
            *room = if c.manifold.count == 0 { c.spare - moved } else { 0.0 };
            return true;
        }
        // How far ahead a bouncing pair looks changes from step to step.
        let farther = f32s::max(margin(world, c, true, dt) - c.margin, 0.0);
        if c.spare > (moved + farther) * (1.0 + 1e-5) {
            return true;
        }
    }
    let turned = turns(world, c);
    if is_too_far(c, moved, turned) {
        return false;
    }
    if c.manifold.count > 0 {
        let d = between(world, [c.body_a, c.body_b]);
        *room = turns_left(c, d, moved, turned.map(f32::sqrt));
    }
    renew_gaps(world, c);
    true
}

/// By how much, together, the two bodies of a pair that touches may turn before it could be tested again, where it has `moved` so far since the last test
/// and they have turned by half angles with these `sines`; the sum of 2 sin(θ/2).
///
/// With d from A's centre to B's, recycling is decided by |Δ(Rₐᵀ d + R m)| + 2 sin(φ/2) l, where R is B's rotation in A's axes and φ its angle. From a look
/// at d₁ on, that grows by no more than |d − d₁| + 2 sin(α/2) (|d₁| + l + |m|) + 2 sin(β/2) (l + |m|) for turns of A by α and of B by β. Part of what is
/// left of the tolerance is for the centres ([`PairHead::near`]), the rest for these.
fn turns_left(c: &Contact, d: Vec3, moved: f32, sines: [f32; 2]) -> f32 {
    if c.spare != 0.0 {
        return 0.0;
    }
    let reach = d.length() + c.extent_b + c.middle_b.length();
    // Poses are rounded.
    let left = (1.0 - NEAR) * c.recycle_tolerance - moved - ROUNDING * reach;
    let most = 2.0 * (RECYCLE_SIN_HALF - f32s::max(sines[0], sines[1]));
    f32s::max(f32s::min(left / reach, most), 0.0)
}

/// From A's centre of mass to B's, world axes.
fn between(world: &World, bodies: [u32; 2]) -> Vec3 {
    let [fa, fb] = bodies.map(|b| &world.frames[b as usize]);
    (fb.center - fa.center).as_vec3()
}

/// Is it certain that a look would keep the manifolds?
fn is_kept(world: &World, h: &PairHead) -> bool {
    gone(world, h, true) < h.until
        && (between(world, h.bodies) - h.looked).length_squared() < h.near * h.near
        && bounds_overlap(world, h)
}

/// What the narrow phase left undone of a pair whose manifolds it knew to be kept, without a look at them.
pub(super) fn keep(world: &World, c: &mut Contact) {
    debug_assert!(
        c.tested && c.spare == 0.0 && !is_too_far(c, way(c, &relative_pose(world, c)), turns(world, c)),
        "a look at contact {} would have tested it",
        c.id
    );
    renew_gaps(world, c);
    note_depth(c);
}

/// Gaps of all points, where the bodies are now: (d + R_b r_b − R_a r_a)·n, with the normal taken to the bodies' axes once for all points.
fn renew_gaps(world: &World, c: &mut Contact) {
    let (fa, fb) = (&world.frames[c.body_a as usize], &world.frames[c.body_b as usize]);
    let d = (fb.center - fa.center).as_vec3();
    for m in c.manifolds_mut() {
        let (along, in_a, in_b) =
            (d.dot(m.normal), fa.rotation.inverse_rotate(m.normal), fb.rotation.inverse_rotate(m.normal));
        for (p, at) in m.points.iter_mut().zip(&m.anchors).take(usize::from(m.count)) {
            p.separation = along - at.on_a.dot(in_a) + at.on_b.dot(in_b);
        }
    }
}

/// How far ahead the pair looks: the margin, or as far as a bouncing pair comes within the step.
fn margin(world: &World, c: &Contact, bouncy: bool, dt: f32) -> f32 {
    let base = world.settings.speculative_margin();
    if !bouncy {
        return base;
    }
    let motion = |body: u32| {
        let f = &world.frames[body as usize];
        world.awake.state.get(f.row as usize).map_or((Vec3::ZERO, 0.0), |s| {
            let b = &world.awake.step[f.row as usize];
            (s.v() + b.acceleration * dt, s.w().length() * b.radius)
        })
    };
    // What falls side by side does not meet.
    let ((va, wa), (vb, wb)) = (motion(c.body_a), motion(c.body_b));
    f32s::max(base, ((va - vb).length() + wa + wb) * dt)
}

/// Part of the thickness of a shape within which two shapes count as being in one place.
const NUDGE: f32 = 1e-4;
/// How far from there each is taken to be, as a part of the thickness: enough to choose between faces.
const ASIDE: f32 = 0.02;

/// A unit vector of a body's own, spread over the sphere. Bodies in one place have no direction to part in; with the same one
/// for all they would line up, and a line of n unfolds at n times the speed of a pair.
fn direction(body: u32) -> Vec3 {
    // Steps of the golden ratio and of the square root of 2 fill the unit square evenly (Weyl).
    let part = |x: u32| x as f32 * (1.0 / 4_294_967_296.0);
    let z = 1.0 - 2.0 * part(body.wrapping_mul(2_654_435_769));
    let turn = 2.0 * core::f32::consts::PI * part(body.wrapping_mul(1_779_033_703));
    let r = f32s::max(1.0 - z * z, 0.0).sqrt();
    Vec3::new(r * f32s::cos(turn), r * f32s::sin(turn), z)
}

/// A shape in the axes of its body, from the centre of mass.
fn place_of(world: &World, r: &ShapeRecord, body: u32) -> Pose {
    Pose::new(r.pose.p - world.frames[body as usize].local_center, r.pose.q)
}

/// Puts the pair, in its noted pose, among those to be tested.
fn aim(world: &World, c: &mut Contact, batch: &mut Batch, dt: f32) {
    let (ra, rb) = (&world.shapes[c.shape_a], &world.shapes[c.shape_b]);
    let (fa, fb) = (&world.frames[c.body_a as usize], &world.frames[c.body_b as usize]);
    let (in_a, in_b) = (place_of(world, ra, c.body_a), place_of(world, rb, c.body_b));
    let mut b_in_a = in_a.relative(&c.tested_pose.compose(&in_b));
    let thin = f32s::min(ra.thickness, rb.thickness);
    if b_in_a.p.length_squared() < NUDGE * NUDGE * thin * thin && ra.shape.is_convex() && rb.shape.is_convex()
    {
        b_in_a.p += (direction(c.body_b) - direction(c.body_a)) * (ASIDE * thin);
    }
    // Pairs that must be seen a step ahead: those that bounce, and bodies that must not be stopped between steps.
    c.bouncy =
        fa.looks_ahead || fb.looks_ahead || ra.material.restitution > 0.0 || rb.material.restitution > 0.0;
    c.margin = margin(world, c, c.bouncy, dt);
    batch.push(&ra.shape, &rb.shape, &b_in_a, c.margin, &c.cache);
}

/// What the test of the pair found, which is number `k` of those that were tested together.
fn test(world: &World, c: &mut Contact, batch: &Batch, k: usize, set: &mut ManifoldSet) {
    let pose = &{ c.tested_pose };
    let (ra, rb) = (&world.shapes[c.shape_a], &world.shapes[c.shape_b]);
    let (fa, fb) = (&world.frames[c.body_a as usize], &world.frames[c.body_b as usize]);
    let in_a = place_of(world, ra, c.body_a);
    batch.collide(k, &ra.shape, &rb.shape, &mut c.cache, &mut c.near, set);
    c.spare = f32s::max(c.cache.gap - c.margin, 0.0);
    if set.manifolds.is_empty() && c.manifold.count == 0 {
        return;
    }
    let offset = (fb.center - fa.center).as_vec3();
    let old_first = c.manifold;
    // The old ones stay in front until the new ones stand behind them: the list's memory is kept.
    let mut rest = core::mem::take(&mut c.rest);
    let kept = rest.len();
    let old_count = if old_first.count == 0 { 0 } else { 1 + kept };
    c.manifold = ContactManifold::NOTHING;
    for (i, m) in set.manifolds.iter().enumerate() {
        if i > 0 {
            rest.push(ContactManifold::NOTHING);
        }
        let (old_rest, new_rest) = rest.split_at_mut(kept);
        let new = if i == 0 { &mut c.manifold } else { &mut new_rest[i - 1] };
        place(m, &in_a, pose, fa.rotation, new);
        new.offset = offset;
        new.surface = surface(ra, rb, m, fa.rotation, fb.rotation);
        let old = |i: usize| if i == 0 { &old_first } else { &old_rest[i - 1] };
        if let Some(o) = (0..old_count).map(old).find(|o| same(o, new)) {
            inherit(new, o);
        } else {
            new.stick = starts_stuck(world, [fa, fb], new);
        }
    }
    rest.drain(..kept);
    c.manifold.more = !rest.is_empty();
    c.rest = rest;
}

/// A manifold from the shapes' frames to the bodies', into an empty one.
fn place(m: &Manifold, in_a: &Pose, pose: &Pose, rotation: Quat, out: &mut ContactManifold) {
    let normal = in_a.q.rotate(m.normal);
    out.normal = rotation.rotate(normal);
    out.count = m.count.min(4);
    out.faces = m.faces;
    (out.sub_a, out.sub_b) = (m.sub_a, m.sub_b);
    for ((p, at), q) in out.points.iter_mut().zip(&mut out.anchors).zip(m.points()) {
        let mid = in_a.transform_point(q.point);
        let half = normal * (0.5 * q.separation);
        *p = Point { arm: rotation.rotate(mid), separation: q.separation, impulse: 0.0 };
        *at = Anchor { on_a: mid - half, on_b: pose.inverse_transform_point(mid + half), feature: q.feature };
    }
}

/// Is this the same manifold as last step? Parts must match, and the normal may have turned by less than 30°.
fn same(old: &ContactManifold, new: &ContactManifold) -> bool {
    let part = old.sub_a == new.sub_a && old.sub_b == new.sub_b;
    let turned = old.normal.dot(new.normal);
    (part && turned > 0.866) || turned > 0.9995
}

/// Carries impulses over: point by point by feature, friction by manifold.
fn inherit(new: &mut ContactManifold, old: &ContactManifold) {
    for i in 0..usize::from(new.count) {
        // A feature's name may flip between two that meet in one place (aligned edges): the place counts then.
        let (at, anchors) = (&new.anchors[i], &old.anchors[..usize::from(old.count).min(4)]);
        let near = |o: &Anchor| (o.on_a - at.on_a).length_squared() < NEAR_SQUARED;
        let by_name = anchors.iter().position(|o| o.feature == at.feature);
        if let Some(o) = by_name.or_else(|| anchors.iter().position(near)) {
            new.points[i].impulse = old.points[o].impulse;
            new.totals[i] = old.totals[o];
            new.total += old.totals[o];
        }
    }
    new.friction = old.friction;
    new.twist = old.twist;
    new.rolling = old.rolling;
    new.stick = old.stick;
    new.slip = old.slip;
}

fn starts_stuck(world: &World, [fa, fb]: [&BodyFrame; 2], m: &ContactManifold) -> bool {
    let speed = |row: u32, r: Vec3| {
        world.awake.state.get(row as usize).map_or(Vec3::ZERO, |s| s.v() + s.w().cross(r))
    };
    let (pa, pb) = (fa.rotation.rotate(m.anchors[0].on_a), fb.rotation.rotate(m.anchors[0].on_b));
    let n = m.normal;
    let v = speed(fb.row, pb) - speed(fa.row, pa) - m.surface.velocity;
    let slip = v - n * n.dot(v);
    slip.length() < world.settings.stick_speed
}

pub(super) fn material(r: &ShapeRecord, sub: u32) -> &Material {
    let index = match &r.shape {
        Shape::Mesh(m) if !r.triangle_materials.is_empty() => m.material(sub),
        Shape::HeightField(h) if !r.triangle_materials.is_empty() => h.material(sub),
        _ => return &r.material,
    };
    r.triangle_materials.get(usize::from(index)).unwrap_or(&r.material)
}

fn surface(ra: &ShapeRecord, rb: &ShapeRecord, m: &Manifold, qa: Quat, qb: Quat) -> Surface {
    let (a, b) = (material(ra, m.sub_a), material(rb, m.sub_b));
    let f = Combine::of(a.friction_combine, b.friction_combine);
    let e = Combine::of(a.restitution_combine, b.restitution_combine);
    // A belt that runs along +x carries what lies on it along +x.
    let velocity =
        qa.rotate(ra.pose.q.rotate(a.surface_velocity)) - qb.rotate(rb.pose.q.rotate(b.surface_velocity));
    Surface {
        static_friction: f.apply(a.static_friction, b.static_friction),
        kinetic_friction: f.apply(a.kinetic_friction, b.kinetic_friction),
        restitution: e.apply(a.restitution, b.restitution),
        rolling_friction: f32s::max(a.rolling_friction, b.rolling_friction),
        twist_friction: f32s::max(a.twist_friction, b.twist_friction),
        velocity,
    }
}

fn ask_hook(
    world: &World,
    c: &mut Contact,
    hook: &(dyn Fn(&ContactView, &mut Surface) -> bool + Send + Sync),
) {
    if c.manifold.count == 0 {
        return;
    }
    let (fa, fb) = (&world.frames[c.body_a as usize], &world.frames[c.body_b as usize]);
    let pair = PairView {
        shapes: [world.shape_id(c.shape_a), world.shape_id(c.shape_b)],
        bodies: [world.body_id(c.body_a), world.body_id(c.body_b)],
        user_data: [world.bodies[c.body_a].user_data, world.bodies[c.body_b].user_data],
    };
    let speed = |row: u32, r: Vec3| {
        world.awake.state.get(row as usize).map_or(Vec3::ZERO, |s| s.v() + s.w().cross(r))
    };
    let part = |s: u32| (s != NONE).then_some(s);
    let keep = |m: &mut ContactManifold| {
        let deepest = m.points().min_by(|(x, _), (y, _)| x.separation.total_cmp(&y.separation));
        let Some((p, at)) = deepest.map(|(p, at)| (*p, *at)) else { return false };
        let (la, lb) = (fa.rotation.rotate(at.on_a), fb.rotation.rotate(at.on_b));
        let view = ContactView {
            pair,
            normal: m.normal,
            point: fa.center + la.as_dvec3(),
            separation: p.separation,
            relative_velocity: speed(fb.row, lb) - speed(fa.row, la),
            parts: [part(m.sub_a), part(m.sub_b)],
        };
        hook(&view, &mut m.surface)
    };
    let first = keep(&mut c.manifold);
    c.rest.retain_mut(keep);
    if !first {
        c.manifold = if c.rest.is_empty() { ContactManifold::default() } else { c.rest.remove(0) };
        c.manifold.more = !c.rest.is_empty();
    }
}

#[cfg(test)]
mod tests {
    use crate::{BodyDesc, Command, Settings, ShapeDesc, World, WorldDesc};
    use jounce_math::Vec3;

    /// Bodies that fly and turn past one another, who become bullets on the way or not: the first two that touch, and when.
    fn first_touch(seed: u32, recycle_contacts: bool, bullets: bool) -> Option<(u32, u32, u64)> {
        let settings = Settings { recycle_contacts, ..Settings::default() };
        let desc = WorldDesc { gravity: Vec3::ZERO, settings, ..WorldDesc::default() };
        let mut w = World::new(desc).expect("valid");
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut all = Vec::new();
        for i in 0..12 {
            let mut v = |s: f32| Vec3::new(random(), random(), random()) * s;
            let shape = match i % 3 {
                0 => ShapeDesc::cuboid([0.5, 0.1, 0.3]),
                1 => ShapeDesc::cone(0.4, 0.3),
                _ => ShapeDesc::cylinder(0.4, 0.1),
            };
            let d = BodyDesc::dynamic().at(v(4.0).as_dvec3()).velocity(v(2.0)).angular_velocity(v(4.0));
            all.push(w.add_body(d.shape(shape)).expect("valid"));
        }
        for step in 0..240 {
            if bullets && step == 20 {
                all.iter().for_each(|&b| w.apply(Command::SetBullet(b, true)).map(|_| ()).expect("valid"));
            }
            w.step().expect("valid");
            if let Some(c) = w.contacts.iter().find(|c| c.touching) {
                return Some((c.shape_a, c.shape_b, step));
            }
        }
        None
    }

    /// What is apart is not tested before it could have met: no touch is found later by that.
    #[test]
    fn pairs_that_are_apart_are_found_in_time() {
        let mut touched = 0;
        for seed in 0..60 {
            for bullets in [false, true] {
                let (tested, skipped) = (first_touch(seed, false, bullets), first_touch(seed, true, bullets));
                touched += usize::from(tested.is_some_and(|t| t.2 > 20));
                assert_eq!(tested, skipped, "seed {seed}, bullets: {bullets}");
            }
        }
        assert!(touched > 30, "{touched}");
    }

    /// Where nothing is known for certain every pair that touches is looked at, and that changes nothing: a heap of boxes, planks and drums, on tiles
    /// and on a turntable.
    #[test]
    fn pairs_that_are_kept_unseen_are_as_if_looked_at() {
        let world = || {
            let mut w = World::new(WorldDesc::default()).expect("valid");
            for i in 0..36 {
                let at = [f64::from(i % 6) - 2.5, -0.5, f64::from(i / 6) - 2.5];
                w.add_body(BodyDesc::fixed().at(at).shape(ShapeDesc::cuboid([0.5; 3]))).expect("valid");
            }
            let turntable = BodyDesc::kinematic().at([0.0, 0.1, 0.0]).angular_velocity([0.0, 0.2, 0.0]);
            w.add_body(turntable.shape(ShapeDesc::cylinder(0.1, 0.8))).expect("valid");
            for i in 0..40 {
                let shape = match i % 3 {
                    0 => ShapeDesc::cuboid([0.25, 0.25, 0.25]),
                    1 => ShapeDesc::cuboid([0.8, 0.06, 0.12]),
                    _ => ShapeDesc::cylinder(0.2, 0.2),
                };
                let (x, z) = (0.7 * f64::from(i % 4) - 1.1, 0.7 * f64::from(i / 4 % 3) - 0.7);
                let d = BodyDesc::dynamic().at([x, 0.6 + 0.6 * f64::from(i / 12), z]).shape(shape);
                w.add_body(d).expect("valid");
            }
            w
        };
        let (mut w, mut looked) = (world(), world());
        let mut kept = 0;
        for step in 0..300 {
            let touching = looked.heads.iter_mut().filter(|h| h.touching);
            touching.for_each(|h| h.until = f64::NEG_INFINITY);
            w.step().expect("valid");
            looked.step().expect("valid");
            kept += w.heads.iter().filter(|h| h.kept).count();
            assert!(!looked.heads.iter().any(|h| h.kept));
            for (a, b) in w.awake.state.iter().zip(&looked.awake.state) {
                assert_eq!(a, b, "step {step}");
            }
            for (a, b) in w.contacts.iter().zip(&looked.contacts) {
                assert_eq!(a.manifold, b.manifold, "step {step}, contact {}", a.id);
                assert_eq!((a.deep, &a.rest), (b.deep, &b.rest), "step {step}, contact {}", a.id);
            }
        }
        assert!(kept > 2000, "{kept}");
    }
}
