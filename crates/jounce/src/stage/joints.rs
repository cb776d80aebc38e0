//! Joints in the step: gathers those that are awake into sets, and hands the sets out.

use super::{Step, alike, nets};
use crate::groups::{root, unite};
use crate::room::contacts::prepare::Softness;
use crate::room::joints::alike::Band;
use crate::room::joints::desc::JointKind;
use crate::room::joints::gear::Gear;
use crate::room::joints::local::Local;
use crate::room::joints::net::point::{PointBlock, is_point};
use crate::room::joints::net::{Rows, Type};
use crate::room::joints::place::NEAR;
use crate::room::joints::rows::Start;
use crate::room::joints::set::{Constants, JointSet};
use crate::room::joints::solve::Solve;
use crate::room::joints::state::Joint;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::free::{absorb, settle};
use crate::room::rigid::solve::turns_freely;
use crate::room::rigid::state::{BodyState, InvInertia, NONE};
use crate::world::World;
use jounce_math::{DVec3, Vec3, scalar::f32s};
use jounce_tasks::ColorSets;

/// Memory that is reused from step to step and is not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointScratch {
    pub sets: Vec<JointSet>,
    /// Those of them that are solved side by side.
    pub bands: Vec<Band>,
    pub(super) owners: alike::Owners,
    /// Joints of those that are solved as nets, by type.
    pub nets: [Rows; 3],
    pub points: Rows<PointBlock>,
    ids: Vec<u32>,
    /// Versions of joints and of the awake bodies that they were gathered for.
    of: (u64, u64, u64),
    /// A bit for each slot of the table.
    marks: Vec<u64>,
    /// Who was gathered, and which ends moved, when the sets were made.
    made_of: Vec<u64>,
    version: u64,
    /// What the blocks of nets were described by: edits of joints, and the substep.
    described: (u64, f32),
    pub(super) broke: Vec<(u32, f32, f32)>,
    wakes: Vec<u32>,
    /// Rows of bodies on which contacts push.
    touched: Vec<bool>,
}

impl JointScratch {
    fn forget_nets(&mut self) {
        self.nets.iter_mut().for_each(Rows::clear);
        self.points.clear();
    }
}

/// Once per step: the sets, and where everything stands.
pub(crate) fn prepare(world: &mut World, step: &Step) {
    let mut s = core::mem::take(&mut world.scratch.joints);
    let now = (world.joints.version, world.joints.edits, world.awake.changes);
    let still = s.of == now;
    if !still {
        s.of = now;
        s.ids.clear();
        if !world.joints.is_empty() {
            gather(world, &mut s.marks, &mut s.ids);
        }
    }
    if s.ids.is_empty() {
        s.sets.clear();
        s.bands.clear();
        s.forget_nets();
        s.made_of.clear();
        world.scratch.joints = s;
        return;
    }
    let moving = |body: u32| u64::from(dynamic_row(world, body) != NONE);
    let signature = |id: u32| {
        let j = &world.joints.table[id];
        (u64::from(id) << 2) | (moving(j.body_a) << 1) | moving(j.body_b)
    };
    let same = s.version == world.joints.version
        && s.made_of.len() == s.ids.len()
        && (still || s.made_of.iter().zip(&s.ids).all(|(m, id)| *m == signature(*id)));
    if !same {
        let made_of = s.ids.iter().map(|&id| signature(id)).collect();
        s.made_of = made_of;
        s.version = world.joints.version;
        make_sets(world, &s.ids, &mut s.sets);
        s.bands.clear();
    }
    let shared: &World = world;
    let now = (shared.joints.edits, step.constants.h);
    let again = !same || s.described != now;
    s.described = now;
    shared.tasks.for_each(&mut s.sets, 1, |_, set| {
        if again {
            if !same {
                begin_bodies(shared, set);
                set.arrange(&shared.joints, |slot| {
                    let b = &shared.bodies[slot];
                    if b.kind == BodyKind::Dynamic { b.mass.inv_mass } else { 0.0 }
                });
            }
            set.known = nets::knows(shared, set, step.constants.h);
        }
    });
    let changed = (again || !still) && choose_nets(shared, &mut s, step, again);
    shared.tasks.for_each(&mut s.sets, 1, |_, set| {
        if !set.net {
            begin(shared, set, |j| shared.start(j));
        }
    });
    alike::prepare(shared, &mut s.sets, &mut s.bands, &mut s.owners, step);
    find_pushed(shared, &mut s);
    nets::prepare(shared, &mut s, step, changed, still);
    world.scratch.joints = s;
}

/// Which sets are solved as nets, and the joints of those, by type; tells whether anything is another than before.
fn choose_nets(world: &World, s: &mut JointScratch, step: &Step, again: bool) -> bool {
    let mut changed = again;
    for set in &mut s.sets {
        let net = set.known && nets::is_unlocked(world, set);
        changed |= net != set.net;
        set.net = net;
    }
    if !changed {
        return false;
    }
    s.forget_nets();
    let JointScratch { sets, nets, points, .. } = s;
    for (i, set) in sets.iter().enumerate().filter(|s| s.1.net) {
        for joint in &set.joints {
            let desc = &world.joints.table[joint.id].desc;
            if is_point(desc) {
                points.push(joint.id, i);
            } else if let Some(kind) = Type::of(desc, step.constants.h) {
                nets[kind as usize].push(joint.id, i);
            }
        }
    }
    true
}

/// Which nets something else pushes in the substeps: contacts on any of their bodies, or vehicles, whose wheels stand anywhere.
fn find_pushed(world: &World, s: &mut JointScratch) {
    let JointScratch { sets, touched, .. } = s;
    let (contacts, vehicles) = (!world.scratch.rows.is_empty(), !world.vehicles.is_empty());
    if contacts && sets.iter().any(|s| s.net) {
        touched.clear();
        touched.resize(world.awake.state.len() + 1, false);
        for color in 0..=ColorSets::COLORS {
            for row in world.scratch.colors.rows(color) {
                for i in [row.a(), row.b()].into_iter().filter_map(ColorSets::index) {
                    touched[i] = true;
                }
            }
        }
    }
    for set in sets.iter_mut().filter(|s| s.net) {
        let pushed = |b: &Local| touched.get(world.frames[b.slot as usize].row as usize) == Some(&true);
        set.pushed = vehicles || (contacts && set.bodies.iter().any(pushed));
    }
}

/// Joints with an awake body, in slot order; and those of bodies that only go as they are led, where gears are on them.
fn gather(world: &World, marks: &mut Vec<u64>, ids: &mut Vec<u32>) {
    let table = &world.joints.table;
    let acts = |j: &Joint| j.acts() && [j.body_a, j.body_b].iter().all(|&b| world.bodies[b].enabled);
    marks.clear();
    marks.resize(table.slots() as usize / 64 + 1, 0);
    for &id in world.awake.step.iter().flat_map(|b| &world.bodies[b.body].joints) {
        marks[id as usize / 64] |= 1 << (id % 64);
    }
    let mut led = Vec::new();
    for (i, mark) in marks.iter().enumerate() {
        let mut left = *mark;
        while left != 0 {
            let id = i as u32 * 64 + left.trailing_zeros();
            left &= left - 1;
            let j = &table[id];
            if !acts(j) {
                continue;
            }
            if let JointKind::Gear { a, b, .. } = j.desc.kind {
                led.extend(
                    [a.index, b.index].into_iter().filter(|&id| is_led(world, id) && acts(&table[id])),
                );
                ids.push(id);
            } else if [j.body_a, j.body_b].iter().any(|&b| dynamic_row(world, b) != NONE) {
                ids.push(id);
            }
        }
    }
    if !led.is_empty() {
        ids.extend(led);
        ids.sort_unstable();
        ids.dedup();
    }
}

/// Is neither of a joint's bodies dynamic? It goes as they go, and so do the gears on it.
fn is_led(world: &World, id: u32) -> bool {
    let j = &world.joints.table[id];
    [j.body_a, j.body_b].iter().all(|&b| world.bodies[b].kind != BodyKind::Dynamic)
}

/// Row of a dynamic body that is awake.
fn dynamic_row(world: &World, body: u32) -> u32 {
    let row = world.frames[body as usize].row;
    if row != NONE && world.awake.step[row as usize].kind == BodyKind::Dynamic { row } else { NONE }
}

fn make_sets(world: &World, ids: &[u32], sets: &mut Vec<JointSet>) {
    sets.clear();
    let place = |id: u32| ids.binary_search(&id).ok();
    let mut parent: Vec<u32> = (0..world.awake.state.len() as u32).collect();
    let mut unite = |a: u32, b: u32| {
        if a != NONE && b != NONE {
            unite(&mut parent, a, b);
        }
    };
    let rows = |id: u32| {
        let j = &world.joints.table[id];
        [dynamic_row(world, j.body_a), dynamic_row(world, j.body_b)]
    };
    let any = |id: u32| {
        let [a, b] = rows(id);
        if a != NONE { a } else { b }
    };
    for &id in ids {
        let [a, b] = rows(id);
        unite(a, b);
        if let JointKind::Gear { a, b, .. } = world.joints.table[id].desc.kind
            && place(a.index).is_some()
            && place(b.index).is_some()
        {
            unite(any(a.index), any(b.index));
        }
    }
    // Sets in the order of their first joints.
    let mut set_of = vec![NONE; world.awake.state.len()];
    let mut local = std::collections::BTreeMap::new();
    let mut set_at = std::collections::BTreeMap::new();
    let mut joint_at = std::collections::BTreeMap::new();
    let mut add = |sets: &mut Vec<JointSet>, at: usize, id: u32, led: bool| {
        *joint_at.entry((at, id)).or_insert_with(|| {
            let (j, set) = (&world.joints.table[id], &mut sets[at]);
            let [a, b] = [j.body_a, j.body_b].map(|slot| {
                *local.entry((at, slot)).or_insert_with(|| {
                    set.bodies.push(Local::new(slot));
                    set.bodies.len() - 1
                })
            });
            let mut solve = Solve::new(id, a, b);
            solve.led = led;
            set.joints.push(solve);
            set.joints.len() - 1
        })
    };
    for &id in ids.iter().filter(|&&id| !world.joints.table[id].is_gear() && any(id) != NONE) {
        let root = root(&mut parent, any(id)) as usize;
        if set_of[root] == NONE {
            set_of[root] = sets.len() as u32;
            sets.push(JointSet::default());
        }
        let at = set_of[root] as usize;
        add(sets, at, id, false);
        set_at.insert(id, at);
    }
    for &id in ids {
        let j = &world.joints.table[id];
        let JointKind::Gear { a, b, ratio } = j.desc.kind else { continue };
        let led = [a, b].map(|j| place(j.index).is_some() && is_led(world, j.index));
        let at = match ([a, b].map(|j| set_at.get(&j.index).copied()), led) {
            ([Some(x), Some(y)], _) if x == y => x,
            // What it is led by is in the set of each gear on it.
            ([Some(x), None], [_, true]) | ([None, Some(x)], [true, _]) => x,
            _ => continue,
        };
        let (a, b) = (add(sets, at, a.index, led[0]), add(sets, at, b.index, led[1]));
        sets[at].gears.push(Gear { id, a, b, ratio, rest: j.coordinate, impulse: 0.0 });
    }
}

/// The bodies of a set as a step starts.
fn begin_bodies(world: &World, set: &mut JointSet) {
    let first = set.bodies.first().map_or(DVec3::ZERO, |b| world.frames[b.slot as usize].center);
    for b in &mut set.bodies {
        b.row = world.frames[b.slot as usize].row;
        b.at = (world.frames[b.slot as usize].center - first).as_vec3();
        let Some(inertia) = world.awake.inertia.get(b.row as usize) else {
            b.m = BodyState::FIXED.get();
            continue;
        };
        let step = &world.awake.step[b.row as usize];
        let dynamic = step.kind == BodyKind::Dynamic;
        let inv = |i: u8| if dynamic && step.locks & (1 << i) == 0 { inertia.inv_mass } else { 0.0 };
        b.start_inv_mass = Vec3::new(inv(0), inv(1), inv(2));
        b.start_tensor = if dynamic { *inertia } else { InvInertia::default() };
        b.turns = dynamic && step.locks & 56 == 0;
        b.free = dynamic && turns_freely(step);
        (b.inv_mass, b.tensor) = (b.start_inv_mass, b.start_tensor);
    }
}

/// The start of a step for one set; `start` tells where a joint's frames stood then.
fn begin(world: &World, set: &mut JointSet, start: impl Fn(&Joint) -> Start) {
    begin_bodies(world, set);
    let JointSet { joints, gears, .. } = set;
    for s in joints.iter_mut() {
        let j = &world.joints.table[s.id];
        s.begin(j);
        s.start = start(j);
        if let JointKind::Pulley { wheel_a, wheel_b, .. } = j.desc.kind {
            let center = |slot: u32| world.frames[slot as usize].center;
            s.wheels = [(center(j.body_a) - wheel_a).as_vec3(), (center(j.body_b) - wheel_b).as_vec3()];
        }
    }
    for g in gears.iter_mut() {
        let j = &world.joints.table[g.id];
        (g.rest, g.impulse) = (j.coordinate, j.hard[0]);
    }
}

pub(super) fn constants(world: &World, step: &Step) -> Constants {
    let (s, k) = (&world.settings, &step.constants);
    let hertz = f32s::min(s.joint_hertz, 0.25 * k.inv_h);
    Constants {
        h: k.h,
        warm: k.warm,
        soft: Softness::new(hertz, s.joint_damping_ratio, k.h),
        push_out: k.push_out_speed,
        correct: 10.0 * s.length_unit,
        speed_max: s.linear_speed_max * s.length_unit,
        spin_max: 2.0 * core::f32::consts::PI / k.h,
    }
}

/// Before the positions move.
pub(crate) fn solve(world: &mut World, step: &Step, substep: u32) {
    let k = constants(world, step);
    nets::solve(world, step);
    alike::solve(world, &k, substep);
    pass(world, |world, set| {
        set.bodies.iter_mut().for_each(|b| load(world, b));
        set.solve(&world.joints, &k, substep == 0);
        set.bodies.iter_mut().for_each(|b| unload(world, b));
    });
}

/// What contacts have changed since, once more: so joints hold where the positions go, and what a landing gives one limb has reached
/// the others. The matrix is that of before.
pub(crate) fn answer(world: &mut World, step: &Step) {
    let k = constants(world, step);
    nets::answer(world, step);
    alike::answer(world, &k);
    pass(world, |world, set| {
        let same = |b: &Local| {
            let Some(s) = world.awake.state.get(b.row as usize) else { return true };
            s.v() == b.m.v && s.w() == b.m.w
        };
        if !set.bodies.iter().all(same) {
            set.bodies.iter_mut().for_each(|b| load(world, b));
            set.answer(&world.joints, &k);
            set.bodies.iter_mut().for_each(|b| unload(world, b));
        }
    });
}

/// After they moved.
pub(crate) fn relax(world: &mut World, step: &Step, last: bool) {
    let k = constants(world, step);
    nets::relax(world, step, last);
    alike::relax(world, &k);
    pass(world, |world, set| {
        set.bodies.iter_mut().for_each(|b| load(world, b));
        set.relax(&world.joints, &k);
        set.bodies.iter_mut().for_each(|b| unload(world, b));
    });
}

fn pass(world: &mut World, f: impl Fn(&World, &mut JointSet) + Sync) {
    if world.scratch.joints.sets.is_empty() {
        return;
    }
    let mut sets = core::mem::take(&mut world.scratch.joints.sets);
    let shared: &World = world;
    shared.tasks.for_each(&mut sets, 1, |_, set| {
        if set.is_alone() {
            f(shared, set);
        }
    });
    for b in
        sets.iter().filter(|s| s.is_alone()).flat_map(|s| &s.bodies).filter(|b| b.row != NONE && b.moves())
    {
        world.awake.state[b.row as usize].put(&b.m);
        world.awake.turning[b.row as usize] = b.turning;
    }
    world.scratch.joints.sets = sets;
}

pub(super) fn load(world: &World, b: &mut Local) {
    let Some(state) = world.awake.state.get(b.row as usize) else { return };
    b.m = state.get();
    (b.inv_mass, b.tensor) = (b.start_inv_mass, b.start_tensor);
    let frame = &world.frames[b.slot as usize];
    let mass = &world.bodies[b.slot].mass;
    (b.inertia, b.loaded_dq) = (None, b.m.dq);
    if b.turns && b.inv_mass.max_component() > 0.0 {
        let r = (b.m.dq * frame.rotation).to_mat3();
        let raised = world.awake.step[b.row as usize].raised;
        b.inertia = Some((r * mass.inertia * r.transpose()).scale(raised));
    }
    if !b.free {
        return;
    }
    b.turning = world.awake.turning[b.row as usize];
    settle(&mut b.m, &mut b.turning, mass, frame.rotation);
    let inertia = &world.awake.inertia[b.row as usize];
    let raised = if mass.inv_mass > 0.0 { inertia.inv_mass / mass.inv_mass } else { 1.0 };
    b.tensor = InvInertia::new((b.m.dq * frame.rotation).normalize(), &mass.inv_inertia, inertia.inv_mass, 0)
        .scaled(raised);
}

fn unload(world: &World, b: &mut Local) {
    if b.free {
        let frame = &world.frames[b.slot as usize];
        absorb(&b.m, &mut b.turning, &world.bodies[b.slot].mass, frame.rotation);
    }
}

/// Impulses back to the records; what breaks.
pub(crate) fn finish(world: &mut World, step: &Step) {
    if world.scratch.joints.sets.is_empty() {
        return;
    }
    let mut s = core::mem::take(&mut world.scratch.joints);
    s.broke.clear();
    alike::finish(world, &s.sets, &s.bands, &s.owners, step.dt, &mut s.broke);
    nets::finish(world, &mut s, step);
    for set in s.sets.iter().filter(|s| s.is_alone()) {
        for g in &set.gears {
            world.joints.table[g.id].hard[0] = g.impulse;
        }
        for solve in &set.joints {
            let j = &mut world.joints.table[solve.id];
            j.hard = solve.lambda;
            j.extra.clear();
            j.extra.extend(solve.extra.iter().map(|x| x.impulse));
            j.coordinate = solve.coordinate;
            (j.force, j.torque) = (solve.force * (1.0 / step.dt), solve.torque * (1.0 / step.dt));
            j.last = solve.last;
            if solve.broke {
                s.broke.push((solve.id, j.force.length(), j.torque.length()));
            }
        }
    }
    s.broke.sort_by_key(|b| b.0);
    for &(id, force, torque) in &s.broke {
        world.break_joint(id, force, torque);
    }
    world.scratch.joints = s;
}

/// Continuous collision stopped some bodies alone: those that hang on them by joints come after, and they themselves hardly give
/// way. Velocities stay, in each body's own axes.
pub(crate) fn follow(world: &mut World, stopped: &[(u32, f32)]) {
    if stopped.is_empty() || world.scratch.joints.sets.is_empty() {
        return;
    }
    let mut sets = core::mem::take(&mut world.scratch.joints.sets);
    let shared: &World = world;
    shared.tasks.for_each(&mut sets, 1, |_, set| {
        set.placed = set.bodies.iter().any(|b| stopped.iter().any(|s| s.0 == b.slot));
        if !set.placed {
            return;
        }
        if set.net {
            begin(shared, set, |j| shared.start_before(j));
        }
        let finite = |b: &Local| b.m.dp.is_finite() && b.m.dq.is_finite();
        // Where what was stopped cannot be where it is, the set keeps together: a load on light links drags them past what stopped them.
        set.placed = [STOPPED_PART, 1.0].into_iter().any(|part| {
            for b in &mut set.bodies {
                back_to_now(shared, b, if stopped.iter().any(|s| s.0 == b.slot) { part } else { 1.0 });
            }
            set.place(&shared.joints) < NEAR && set.bodies.iter().all(finite)
        });
    });
    for b in sets.iter().filter(|s| s.placed).flat_map(|s| &s.bodies).filter(|b| b.row != NONE && b.moves()) {
        let f = &mut world.frames[b.slot as usize];
        let turned = f.rotation;
        f.center = f.center0 + b.m.dp.as_dvec3();
        f.rotation = (b.m.dq * f.rotation0).normalize();
        let back = f.rotation * turned.conjugate();
        if b.free {
            let s = &mut world.awake.state[b.row as usize];
            s.set_velocity(s.v(), back.rotate(s.w()));
        }
        world.refresh_inertia(b.slot);
    }
    world.scratch.joints.sets = sets;
}

/// A body of a set where it stands after continuous collision, with part of its inverse mass.
fn back_to_now(world: &World, b: &mut Local, part: f32) {
    let f = &world.frames[b.slot as usize];
    b.m.dp = (f.center - f.center0).as_vec3();
    b.m.dq = (f.rotation * f.rotation0.conjugate()).normalize();
    // Who was put in quarantine has lost his row.
    b.row = f.row;
    (b.inv_mass, b.tensor) = match world.awake.inertia.get(b.row as usize) {
        Some(_) if b.start_tensor == InvInertia::default() => {
            (b.start_inv_mass * part, InvInertia::default())
        }
        Some(i) => (b.start_inv_mass * part, i.scaled(part)),
        None => (Vec3::ZERO, InvInertia::default()),
    };
}

/// Part of its inverse mass that a body has which continuous collision stopped: two of them on one joint still come together.
const STOPPED_PART: f32 = 1e-3;

/// Bodies on joints to kinematic bodies that move do not rest, and are woken. Nor do those rest themselves, however slow: one without
/// shapes that only turns has no point that moves.
pub(crate) fn stir(world: &mut World) {
    if world.joints.is_empty() {
        return;
    }
    let mut wakes = core::mem::take(&mut world.scratch.joints.wakes);
    wakes.clear();
    for (s, b) in world.awake.state.iter().zip(&world.awake.step) {
        if b.kind != BodyKind::Kinematic || (s.v() == Vec3::ZERO && s.w() == Vec3::ZERO) {
            continue;
        }
        for &id in &world.bodies[b.body].joints {
            let j = &world.joints.table[id];
            if j.acts() {
                wakes.extend([j.body_a, j.body_b]);
            }
        }
    }
    for &slot in &wakes {
        world.wake_body(slot);
    }
    world.scratch.joints.wakes = wakes;
}
