//! Contacts of what is welded together, solved with all that is welded on (`room::joints::articulated`).
//!
//! Their normal rows leave the lanes: a few sweeps of Gauss and Seidel over the points of all sets in contact order, each before
//! the lanes' own. Friction stays in the lanes, bounded by what these rows push with.

use super::joints::{constants, load};
use super::{Places, RowPlace, Step};
use crate::room::contacts::prepare::StepConstants;
use crate::room::contacts::rows::Block;
use crate::room::contacts::solve::SPEED_MOST;
use crate::room::contacts::state::{Contact, ContactManifold};
use crate::room::joints::articulated::{Firm, Six};
use crate::room::joints::set::{Constants, JointSet};
use crate::room::rigid::state::{BodyFrame, BodyState, NONE};
use crate::world::World;
use jounce_math::scalar::{f32s, f64s};

/// A manifold of which a body is welded to others.
#[derive(Clone, Copy, Debug)]
struct Leaning {
    color: usize,
    block: usize,
    lane: usize,
    count: usize,
    sides: [Side; 2],
    points: [Point; 4],
}

#[derive(Clone, Copy, Debug, Default)]
struct Point {
    /// 1/(g R), kg.
    mass: f32,
    /// Wanted speed, and the part of the error and of the impulse so far that a soft row takes.
    bias: f32,
    scale: f32,
    soft: f32,
    /// Inverse mass that it would meet in each body of a set alone.
    alone: [f64; 2],
}

/// One of its bodies.
#[derive(Clone, Copy, Debug)]
struct Side {
    row: u32,
    /// Where it is part of a set: which, its place among those that contacts touch, its first point.
    set: u32,
    place: usize,
    first: usize,
}

/// Memory that is reused from step to step and is not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Leanings {
    rows: Vec<Leaning>,
    /// By awake row: set and body.
    owners: Vec<(u32, u32)>,
    /// By set: points of contacts.
    points: Vec<usize>,
}

/// Sweeps over the points in a pass, at most, and the change of a speed that ends them, m/s.
const SWEEPS: usize = 8;
const QUIET: f32 = 1e-4;
/// Turn of a body since the matrix of its set was made that makes another, rad.
const TURNED: f32 = 0.02;
/// Part of the bodies' own inverse mass below which the welds alone hold a point, as those on fixed ground do: what they leave of it is rounding, and
/// through that a contact would take thousands of newtons that move nothing, and break what is to break. It has the bodies' own then.
const LEAST: f64 = 1e-5;
/// Points times bodies that contacts touch, and times joints: beyond that a set's contacts are solved as others are.
const RESPONSES: usize = 4096;
const SOLVES: usize = 8192;

/// As a step starts, before anything moves.
pub(crate) fn prepare(world: &mut World) {
    let mut s = core::mem::take(&mut world.scratch.leanings);
    s.rows.clear();
    world.scratch.joints.sets.iter_mut().for_each(|set| set.leaned = false);
    if world.scratch.joints.sets.iter().any(JointSet::bears) {
        gather(world, &mut s);
    }
    world.scratch.leanings = s;
}

fn gather(world: &mut World, s: &mut Leanings) {
    let mut sets = core::mem::take(&mut world.scratch.joints.sets);
    s.owners.clear();
    s.owners.resize(world.awake.state.len(), (NONE, NONE));
    for (i, set) in sets.iter_mut().enumerate().filter(|(_, set)| set.bears()) {
        set.firm.clear(set.bodies.len());
        for (k, b) in set.bodies.iter().enumerate().filter(|(_, b)| b.moves()) {
            if let Some(owner) = s.owners.get_mut(b.row as usize) {
                *owner = (i as u32, k as u32);
            }
        }
    }
    s.points.clear();
    s.points.resize(sets.len(), 0);
    let (frames, places) = (&world.frames, &world.scratch.places);
    let contacts =
        || world.contacts.iter().enumerate().filter_map(|(i, c)| Some((i, c, owners(frames, &s.owners, c)?)));
    for (at, c, sides) in contacts() {
        for (set, body) in sides {
            if let Some(set) = sets.get_mut(set as usize) {
                set.firm.touch(body as usize);
            }
            if let Some(n) = s.points.get_mut(set as usize) {
                *n += points(places, at, c);
            }
        }
    }
    for (set, &n) in sets.iter_mut().zip(&s.points) {
        let bodies = set.firm.bodies.len();
        set.leaned = n > 0 && n * bodies <= RESPONSES && n * set.joints.len() <= SOLVES;
        if set.leaned {
            set.firm.reserve(n);
        }
    }
    s.points.fill(0);
    for (at, c, owners) in contacts() {
        if !owners.iter().any(|o| sets.get(o.0 as usize).is_some_and(|s| s.leaned)) {
            continue;
        }
        let bodies = [c.body_a, c.body_b].map(|b| frames[b as usize].row);
        for (place, m) in manifolds(places, at, c) {
            let count = usize::from(m.count).min(4);
            let (color, (block, lane)) = (usize::from(place.color), place.lane());
            let mut sides = bodies.map(|row| Side { row, set: NONE, place: 0, first: 0 });
            for (side, (set, body)) in sides.iter_mut().zip(owners) {
                if let Some(list) = sets.get(set as usize).filter(|s| s.leaned) {
                    side.set = set;
                    side.place = list.firm.place(body as usize);
                    side.first = s.points[set as usize];
                    s.points[set as usize] += count;
                }
            }
            let points = &mut world.scratch.blocks[color][block].points;
            points.iter_mut().for_each(|p| p.mass[lane] = 0.0);
            s.rows.push(Leaning { color, block, lane, count, sides, points: [Point::default(); 4] });
        }
    }
    world.scratch.joints.sets = sets;
}

/// Whether there is any such contact in this step.
pub(crate) fn any(world: &World) -> bool {
    !world.scratch.leanings.rows.is_empty()
}

/// As a substep starts: responses and masses, of sets that have turned since they were made.
pub(crate) fn renew(world: &mut World, step: &Step) {
    let mut sets = core::mem::take(&mut world.scratch.joints.sets);
    let shared: &World = world;
    shared.tasks.for_each(&mut sets, 1, |_, set| {
        if set.leaned {
            set.bodies.iter_mut().for_each(|b| load(shared, b));
            set.firm.stale = set.has_turned(TURNED);
            if set.firm.stale {
                set.firm(&shared.joints, step.constants.h);
            }
        }
    });
    let (rows, blocks) = (&mut world.scratch.leanings.rows, &world.scratch.blocks);
    for r in rows.iter_mut() {
        if !r.sides.iter().any(|s| sets.get(s.set as usize).is_some_and(|s| s.firm.stale)) {
            continue;
        }
        let block = &blocks[r.color][r.block];
        for (k, p) in r.points.iter_mut().enumerate().take(r.count) {
            let (mut inverse, mut apart) = (0.0, 0.0);
            for (i, side) in r.sides.iter().enumerate() {
                let g = row_of(block, r.lane, k, i);
                if let Some(set) = sets.get_mut(side.set as usize) {
                    if set.firm.stale {
                        p.alone[i] = set.respond(side.first + k, side.place, &g);
                    }
                    inverse += f64s::max(dot(&g, &set.firm.response(side.first + k)[side.place]), 0.0);
                    apart += p.alone[i];
                } else {
                    let (turn, inertia) = (block.turns(k, r.lane)[i], block.inertia(i, r.lane));
                    let own = f64::from(inertia.inv_mass + turn.dot(inertia.mul(turn)));
                    inverse += own;
                    apart += own;
                }
            }
            let inverse = if inverse > LEAST * apart { inverse } else { apart };
            p.mass = if inverse > 0.0 { (1.0 / inverse) as f32 } else { 0.0 };
        }
    }
    world.scratch.joints.sets = sets;
}

/// Those of a contact that are taken out of the lanes: what bounces stays there.
fn manifolds<'a>(
    places: &'a Places,
    at: usize,
    c: &'a Contact,
) -> impl Iterator<Item = (RowPlace, &'a ContactManifold)> {
    let all = c.manifolds().enumerate().filter_map(move |(k, m)| Some((places.get(at, k)?, m)));
    all.filter(|(_, m)| m.surface.restitution == 0.0)
}

fn points(places: &Places, at: usize, c: &Contact) -> usize {
    manifolds(places, at, c).map(|(_, m)| usize::from(m.count).min(4)).sum()
}

/// Whose the bodies of a contact are, where some set's are touched from outside.
fn owners(frames: &[BodyFrame], owners: &[(u32, u32)], c: &Contact) -> Option<[(u32, u32); 2]> {
    if !c.touching {
        return None;
    }
    let sides = [c.body_a, c.body_b]
        .map(|b| owners.get(frames[b as usize].row as usize).copied().unwrap_or((NONE, NONE)));
    (sides[0].0 != sides[1].0).then_some(sides)
}

/// g of a point for body A (0) or B (1).
fn row_of(block: &Block, lane: usize, point: usize, side: usize) -> Six {
    let (n, turn) = (block.normal.get(lane), block.turns(point, lane)[side]);
    let (n, turn) = if side == 0 { (-n, -turn) } else { (n, turn) };
    [n.x, n.y, n.z, turn.x, turn.y, turn.z].map(f64::from)
}

fn dot(a: &Six, b: &Six) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The rows of a pass, and what they act on.
struct Work<'a> {
    rows: &'a mut [Leaning],
    sets: &'a mut [JointSet],
    blocks: &'a mut [Vec<Block>],
    state: &'a mut [BodyState],
}

impl Work<'_> {
    /// Runs `f` over the world's rows between reading velocities and handing out what was given.
    fn run(world: &mut World, step: &Step, f: impl FnOnce(&mut Work<'_>)) {
        if world.scratch.leanings.rows.is_empty() {
            return;
        }
        let k = constants(world, step);
        let scratch = &mut world.scratch;
        let mut work = Work {
            rows: &mut scratch.leanings.rows,
            sets: &mut scratch.joints.sets,
            blocks: &mut scratch.blocks,
            state: &mut world.awake.state,
        };
        work.begin();
        f(&mut work);
        work.end(&k);
    }

    fn begin(&mut self) {
        for set in self.sets.iter_mut().filter(|s| s.leaned) {
            let Firm { bodies, u, given, .. } = &mut set.firm;
            for ((&b, u), given) in bodies.iter().zip(u).zip(given) {
                let s = &self.state[set.bodies[b].row as usize];
                let (v, w) = (s.v(), s.w());
                *u = [v.x, v.y, v.z, w.x, w.y, w.z].map(f64::from);
                *given = [0.0; 6];
            }
        }
    }

    /// Hands out what was given.
    fn end(&mut self, k: &Constants) {
        for set in self.sets.iter_mut().filter(|s| s.leaned) {
            set.spread(k, |row, dv, dw| {
                let s = &mut self.state[row as usize];
                s.set_velocity(s.v() + dv, s.w() + dw);
            });
        }
    }

    fn speed(&self, r: &Leaning, point: usize) -> f32 {
        let block = &self.blocks[r.color][r.block];
        let mut speed = 0.0;
        for (i, side) in r.sides.iter().enumerate() {
            let g = row_of(block, r.lane, point, i);
            if let Some(set) = self.sets.get(side.set as usize) {
                speed += dot(&g, &set.firm.u[side.place]);
            } else if let Some(s) = self.state.get(side.row as usize) {
                let (v, w) = (s.v(), s.w());
                speed += dot(&g, &[v.x, v.y, v.z, w.x, w.y, w.z].map(f64::from));
            }
        }
        speed as f32
    }

    fn push(&mut self, r: &Leaning, point: usize, d: f32) {
        if d == 0.0 {
            return;
        }
        let block = &self.blocks[r.color][r.block];
        for (i, side) in r.sides.iter().enumerate() {
            if let Some(set) = self.sets.get_mut(side.set as usize) {
                let g = row_of(block, r.lane, point, i);
                let d = f64::from(d);
                set.firm.given[side.place].iter_mut().zip(g).for_each(|(x, g)| *x += g * d);
                set.firm.react(side.first + point, d);
            } else if let Some(s) = self.state.get_mut(side.row as usize) {
                let (turn, inertia) = (block.turns(point, r.lane)[i], block.inertia(i, r.lane));
                let d = if i == 0 { -d } else { d };
                let (dv, dw) = (block.normal.get(r.lane) * (inertia.inv_mass * d), inertia.mul(turn) * d);
                s.set_velocity(s.v() + dv, s.w() + dw);
            }
        }
    }

    /// Impulse of a point so far.
    fn impulse(&mut self, r: &Leaning, point: usize) -> &mut f32 {
        &mut self.blocks[r.color][r.block].points[point].impulse[r.lane]
    }

    /// Gap of a point now, m.
    fn gap(&self, r: &Leaning, point: usize) -> f32 {
        let block = &self.blocks[r.color][r.block];
        let p = &block.points[point];
        let moved = |side: &Side| {
            let m = self.state.get(side.row as usize).unwrap_or(&BodyState::FIXED).get();
            (m.dp, m.dr)
        };
        let [(pa, ta), (pb, tb)] = [moved(&r.sides[0]), moved(&r.sides[1])];
        let [ja, jb] = block.turns(point, r.lane);
        let turned = jb.dot(tb) - ja.dot(ta);
        p.separation[r.lane] + block.normal.get(r.lane).dot(pb - pa) + turned
    }

    fn warm(&mut self) {
        for i in 0..self.rows.len() {
            let r = self.rows[i];
            for k in 0..r.count {
                let impulse = *self.impulse(&r, k);
                self.push(&r, k, impulse);
            }
        }
    }

    fn sweeps(&mut self) {
        for _ in 0..SWEEPS {
            let mut change = 0.0;
            for i in 0..self.rows.len() {
                let r = self.rows[i];
                for (k, p) in r.points.iter().enumerate().take(r.count) {
                    let (speed, old) = (self.speed(&r, k), *self.impulse(&r, k));
                    let wanted = old - p.mass * (p.scale * speed + p.bias) - p.soft * old;
                    let new = f32s::clamp(wanted, 0.0, p.mass * SPEED_MOST);
                    *self.impulse(&r, k) = new;
                    self.push(&r, k, new - old);
                    if p.mass > 0.0 {
                        change = f32s::max(change, (new - old).abs() / p.mass);
                    }
                }
            }
            if change < QUIET {
                return;
            }
        }
    }
}

/// Impulses of the last substep once more, then normal rows with soft bias, as `room::contacts::solve` has them. In one pass: velocities that the
/// impulses alone would make are none that joints, whose errors are not linear, should look ahead with.
pub(crate) fn solve(world: &mut World, step: &Step) {
    let k = step.constants;
    Work::run(world, step, |w| {
        w.warm();
        w.aim(|block, l, s| soften(block, l, s, &k));
        w.sweeps();
    });
}

fn soften(block: &Block, l: usize, s: f32, k: &StepConstants) -> [f32; 3] {
    if s > 0.0 {
        return [s * k.inv_h, 1.0, 0.0];
    }
    let soft = if block.inv_mass_a[l] == 0.0 || block.inv_mass_b[l] == 0.0 { k.fixed } else { k.moving };
    let (sigma, share) = (soft.mass_scale, block.share[l]);
    [f32s::max(sigma * soft.bias_rate * share * s, -k.push_out_speed * share), sigma, soft.impulse_scale]
}

/// Without bias; then what joints gave in the substep is known.
pub(crate) fn relax(world: &mut World, step: &Step) {
    let k = step.constants;
    Work::run(world, step, |w| {
        w.aim(|_, _, s| [f32s::max(s, 0.0) * k.inv_h, 1.0, 0.0]);
        w.sweeps();
    });
    if world.scratch.leanings.rows.is_empty() {
        return;
    }
    let k = constants(world, step);
    let mut sets = core::mem::take(&mut world.scratch.joints.sets);
    sets.iter_mut().filter(|s| s.leaned).for_each(|s| s.account(&world.joints, &k));
    world.scratch.joints.sets = sets;
}

impl Work<'_> {
    fn aim(&mut self, f: impl Fn(&Block, usize, f32) -> [f32; 3]) {
        for i in 0..self.rows.len() {
            let mut r = self.rows[i];
            for k in 0..r.count {
                let s = self.gap(&r, k);
                let p = &mut r.points[k];
                [p.bias, p.scale, p.soft] = f(&self.blocks[r.color][r.block], r.lane, s);
            }
            self.rows[i] = r;
        }
    }
}
