//! Sets of joints that are alike: gathers them into bands and hands those out (see [`crate::room::joints::alike`]).

use super::Step;
use crate::room::contacts::rows::LANES;
use crate::room::joints::alike::{Band, Kind, Link, Pattern, Side};
use crate::room::joints::desc::JointKind;
use crate::room::joints::hinge;
use crate::room::joints::rows::Ends;
use crate::room::joints::set::{Constants, JointSet};
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::{BodyState, Motion, NONE, Turning};
use crate::table::Entry;
use crate::world::World;
use jounce_math::{Quat, scalar::f32s};
use jounce_tasks::{Owned, Owning};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Sets per unit, while it is found which fit.
const SETS: usize = 16;
/// Joints in a set up to which it is solved alone: that costs little.
const SMALL: usize = 4;
/// Joints of a set at most, and of a way through it: a row of n links that are all at their ends is a beam, with a condition number
/// that goes with n⁴ (thirty of them made 10 MJ of 16 kJ in f32).
const LARGE: usize = 32;
const LONG: usize = 10;
/// Ratio of two masses on one joint that f32 stands.
const RATIO: f32 = 20.0;

/// May the set go into a band? Then `out` gets its links: kinds that the kernels know, no loops, free of all that does not move, like masses.
fn fits(world: &World, set: &JointSet, h: f32, out: &mut Vec<Link>) -> bool {
    let n = set.joints.len();
    if !set.gears.is_empty() || n <= SMALL || n > LARGE || set.bodies.len() != n + 1 {
        return false;
    }
    let free = |row: u32| {
        world.awake.step.get(row as usize).is_some_and(|b| b.kind == BodyKind::Dynamic && b.locks == 0)
    };
    if set.plan.is_none() || !set.bodies.iter().all(|b| free(b.row)) {
        return false;
    }
    for s in &set.joints {
        let Some(kind) = Kind::of(&world.joints.table[s.id].desc, h) else { return false };
        let [a, b] = [s.a, s.b].map(|b| set.bodies[b].inv_mass.x);
        if f32s::max(a, b) > RATIO * f32s::min(a, b) {
            return false;
        }
        out.push(Link { kind, a: s.a as u16, b: s.b as u16 });
    }
    let (end, _) = farthest(out, 0);
    farthest(out, end).1 <= LONG
}

/// The body of a tree that is most joints away from another, and how many.
fn farthest(links: &[Link], from: usize) -> (usize, usize) {
    let mut away = [usize::MAX; LARGE + 1];
    away[from] = 0;
    for _ in 0..links.len() {
        let mut changed = false;
        for l in links {
            for (x, y) in [(l.a as usize, l.b as usize), (l.b as usize, l.a as usize)] {
                if away[x] != usize::MAX && away[y] > away[x] + 1 {
                    (away[y], changed) = (away[x] + 1, true);
                }
            }
        }
        if !changed {
            break;
        }
    }
    let reached = away.iter().enumerate().filter(|a| *a.1 != usize::MAX);
    reached.fold((from, 0), |best, (i, &n)| if n > best.1 { (i, n) } else { best })
}

/// Once per step: who stands beside whom, and all numbers.
pub(super) fn prepare(
    world: &World,
    sets: &mut [JointSet],
    bands: &mut Vec<Band>,
    owners: &mut Owners,
    step: &Step,
) {
    let h = step.constants.h;
    world.tasks.for_each(sets, SETS, |_, set| {
        core::mem::swap(&mut set.links, &mut set.links_before);
        let mut links = core::mem::take(&mut set.links);
        links.clear();
        if !fits(world, set, h, &mut links) {
            links.clear();
        }
        set.links = links;
    });
    let mut same = bands.iter().all(|b| b.sets.iter().all(|&s| (s as usize) < sets.len()));
    same &= sets.iter().all(|s| s.links == s.links_before);
    let banded: usize = bands.iter().map(|b| b.sets.len()).sum();
    if !same || banded != sets.iter().filter(|s| !s.links.is_empty()).count() {
        gather(sets, bands);
    }
    let sets = &*sets;
    owners.list(world, sets, bands);
    world.tasks.for_each(bands, 1, |_, band| {
        band.clear();
        for l in 0..band.sets.len() {
            let set = &sets[band.sets[l] as usize];
            for (i, b) in set.bodies.iter().enumerate() {
                let rotation = world.frames[b.slot as usize].rotation.to_mat3();
                let inertia = rotation * world.bodies[b.slot].mass.inertia * rotation.transpose();
                let (inv_mass, inverse) = (b.start_inv_mass.x, b.start_tensor);
                let side = Side { row: b.row, inv_mass, at: b.at, inertia, inverse };
                band.fill_body(i, l, &side);
            }
            for (i, s) in set.joints.iter().enumerate() {
                band.fill_joint(i, l, &world.joints.table[s.id], &s.start, h);
            }
        }
    });
}

/// Which band has a body, by awake row, and which a joint, by id.
#[derive(Clone, Debug, Default)]
pub(super) struct Owners {
    rows: Vec<u32>,
    joints: Vec<u32>,
}

impl Owners {
    fn list(&mut self, world: &World, sets: &[JointSet], bands: &[Band]) {
        self.rows.clear();
        self.joints.clear();
        if bands.is_empty() {
            return;
        }
        self.rows.resize(world.awake.state.len(), NONE);
        self.joints.resize(world.joints.table.slots() as usize, NONE);
        for (i, band) in bands.iter().enumerate() {
            for set in band.sets.iter().map(|&s| &sets[s as usize]) {
                for b in &set.bodies {
                    if let Some(owner) = self.rows.get_mut(b.row as usize) {
                        *owner = i as u32;
                    }
                }
                set.joints.iter().for_each(|s| self.joints[s.id as usize] = i as u32);
            }
        }
    }
}

/// Sets by their links; a band for every sixteen.
fn gather(sets: &[JointSet], bands: &mut Vec<Band>) {
    bands.clear();
    let mut patterns: BTreeMap<&[Link], (Option<Arc<Pattern>>, usize)> = BTreeMap::new();
    for (i, set) in sets.iter().enumerate().filter(|(_, s)| !s.links.is_empty()) {
        let (pattern, last) = patterns
            .entry(&set.links)
            .or_insert_with(|| (Pattern::new(&set.links, set.bodies.len()).map(Arc::new), usize::MAX));
        debug_assert!(pattern.is_some(), "a set that fits has a plan");
        let Some(pattern) = pattern else { continue };
        if bands.get(*last).is_none_or(|b| b.sets.len() == LANES) {
            *last = bands.len();
            bands.push(Band::new(pattern));
        }
        bands[*last].sets.push(i as u32);
    }
}

/// One pass over all bands.
fn pass(world: &mut World, f: impl Fn(&World, &mut Band) -> bool + Sync) {
    if world.scratch.joints.bands.is_empty() {
        return;
    }
    let mut bands = core::mem::take(&mut world.scratch.joints.bands);
    let shared: &World = world;
    shared.tasks.for_each(&mut bands, 1, |_, band| {
        band.changed = f(shared, band);
    });
    let (a, rows) = (&mut world.awake, &world.scratch.joints.owners.rows);
    let columns = (&bands[..], Owning(&mut a.state, rows), Owning(&mut a.turning, rows));
    world.tasks.for_each_piece(columns, 1, |first, (bands, mut states, mut turning)| {
        for (i, band) in bands.iter().enumerate().filter(|(_, b)| b.changed) {
            put(band, first + i, &mut states, &mut turning);
        }
    });
    world.scratch.joints.bands = bands;
}

/// ω that the memories of the momenta know.
fn know(world: &World, band: &mut Band) {
    let (ways, states, turning) = (&world.scratch.ways, &world.awake.state, &world.awake.turning);
    for b in &mut band.bodies {
        for l in 0..LANES {
            b.known[l] = 0.0;
            let row = b.rows[l] as usize;
            let Some(state) = states.get(row).filter(|_| ways[row].free) else { continue };
            if let Some(t) = turning[row].as_ref().filter(|t| t.is_of(state)) {
                b.known[l] = 1.0;
                b.known_w.set(l, t.w);
            }
        }
    }
}

/// Velocities, and places where those were put right, of band `at` back to the bodies.
fn put(band: &Band, at: usize, states: &mut Owned<'_, BodyState>, turning: &mut Owned<'_, Option<Turning>>) {
    for b in &band.bodies {
        for l in 0..band.sets.len() {
            let row = b.rows[l];
            let Some(state) = states.get(at, row as usize) else { continue };
            let (v, w) = (b.v.get(l), b.w.get(l));
            if band.placed[l] {
                let [x, y, z, s] = [0, 1, 2, 3].map(|i: usize| b.dq[i][l]);
                state.put(&Motion { v, w, dp: b.dp.get(l), dr: b.dr.get(l), dq: Quat::new(x, y, z, s) });
                continue;
            }
            state.set_velocity(v, w);
            if b.known[l] == 1.0
                && let Some(Some(t)) = turning.get(at, row as usize)
            {
                t.momentum += b.gain.get(l).as_dvec3();
                t.w = w;
            }
        }
    }
}

/// Before the positions move.
pub(super) fn solve(world: &mut World, k: &Constants, substep: u32) {
    pass(world, |world, band| {
        know(world, band);
        band.solve(world.width, &world.awake.state, k, substep == 0);
        true
    });
}

/// The same after contacts, where they changed anything.
pub(super) fn answer(world: &mut World, k: &Constants) {
    pass(world, |world, band| {
        let touched = band.touched(&world.awake.state);
        if touched {
            know(world, band);
            band.answer(world.width, &world.awake.state, k);
        }
        touched
    });
}

/// After they moved.
pub(super) fn relax(world: &mut World, k: &Constants) {
    pass(world, |world, band| {
        know(world, band);
        band.relax(world.width, &world.awake.state, k);
        true
    });
}

/// Impulses back to the records, and what broke: joint, force, torque.
pub(super) fn finish(
    world: &mut World,
    sets: &[JointSet],
    bands: &[Band],
    owners: &Owners,
    dt: f32,
    broke: &mut Vec<(u32, f32, f32)>,
) {
    world.scratch.found.begin(bands.len(), 0);
    let (states, found) = (&world.awake.state, &world.scratch.found);
    let table = &mut world.joints.table;
    let columns = (bands, Owning(table.entries_mut(), &owners.joints));
    world.tasks.for_each_piece(columns, 1, |first, (bands, mut table)| {
        for (at, band) in bands.iter().enumerate().map(|(i, b)| (first + i, b)) {
            for (l, &set) in band.sets.iter().enumerate() {
                let set = &sets[set as usize];
                for (i, s) in set.joints.iter().enumerate() {
                    let motion =
                        |b: usize| states.get(set.bodies[b].row as usize).unwrap_or(&BodyState::FIXED).get();
                    let Some(j) = table.get(at, s.id as usize).and_then(Entry::get_mut) else { continue };
                    let e = Ends::now(&s.start, &motion(s.a), &motion(s.b));
                    if band.store_joint(i, l, j, dt, e.qa) {
                        found.of(at).push(s.id);
                    }
                    if let JointKind::Hinge(_) = j.desc.kind {
                        j.coordinate = hinge::angle(e.twist(), j.coordinate).c;
                    }
                }
            }
        }
    });
    let mut ids = Vec::new();
    world.scratch.found.gather(&mut ids);
    broke.extend(ids.iter().map(|&id| (id, table[id].force.length(), table[id].torque.length())));
}
