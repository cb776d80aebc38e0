//! Colours the manifolds and fills the solver's rows.

use super::{Scratch, Step, narrowphase};
use crate::room::contacts::prepare::{Prepare, Sources, fill};
use crate::room::contacts::rows::{Block, LANES};
use crate::room::contacts::state::{Contact, ContactManifold, PairHead};
use crate::room::contacts::{crowd, load};
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_lanes::{dispatch, prefetch};
use jounce_tasks::{ColorSets, Row};

/// Contacts from the one that is looked at to the one that is asked for.
const AHEAD: usize = 8;
/// Contacts per unit.
const CONTACTS: usize = 256;

pub(crate) fn run(world: &mut World, step: &Step) {
    outline(world);
    color_and_raise(world, step);
    let Scratch { places, rows: manifolds, colors, shares, .. } = &mut world.scratch;
    if !(shares.is_empty() && world.joints.is_empty()) {
        places.find(world.contacts.len(), manifolds, colors);
    }
    let mut blocks = core::mem::take(&mut world.scratch.blocks);
    blocks.resize_with(ColorSets::COLORS + 1, Vec::new);
    for (color, list) in blocks.iter_mut().enumerate() {
        let rows = world.scratch.colors.rows(color);
        list.resize_with(rows.len().div_ceil(LANES), Block::default);
        let shared: &World = world;
        shared.tasks.for_each(list, 1, |unit, block| {
            let from = unit * LANES;
            let to = (from + LANES).min(rows.len());
            let next = &rows[to..(to + LANES).min(rows.len())];
            fill_block(shared, block, &rows[from..to], next, step);
        });
    }
    for &(contact, share) in &world.scratch.shares {
        for k in 0..world.contacts[contact as usize].manifold_count() {
            if let Some(place) = world.scratch.places.get(contact as usize, k) {
                let (block, lane) = place.lane();
                blocks[usize::from(place.color)][block].share[lane] = share;
            }
        }
    }
    world.scratch.blocks = blocks;
    super::joints::prepare(world, step);
    super::vehicles::prepare(world, step);
}

fn fill_block(world: &World, block: &mut Block, rows: &[Row], next: &[Row], step: &Step) {
    (block.any_rolling, block.any_surface, block.any_rebound, block.round) = (false, false, false, true);
    (block.rebound_change, block.share) = ([-1.0; LANES], [1.0; LANES]);
    (block.rows, block.points_max) = (rows.len(), 0);
    // What the next block reads lies anywhere.
    for row in next {
        let (contact, _) = world.scratch.rows[row.payload() as usize];
        let c = &world.contacts[contact as usize];
        c.manifold.prefetch();
        for item in [row.a(), row.b()].into_iter().filter_map(ColorSets::index) {
            prefetch(&world.awake.state[item]);
            prefetch(&world.awake.inertia[item]);
        }
    }
    let mut sources = Sources::NOTHING;
    for (l, row) in rows.iter().enumerate() {
        let (contact, manifold) = world.scratch.rows[row.payload() as usize];
        let c = &world.contacts[contact as usize];
        let bodies = [row.a(), row.b()].map(ColorSets::index);
        sources.put(l, c.get(manifold as usize), bodies, &world.awake);
        fill(block, l, &sources);
    }
    // The kernel makes lanes without a row zero; these come from rows alone.
    for l in rows.len()..LANES {
        (block.mu[l], block.share[l]) = (0.0, 0.0);
    }
    dispatch(world.width, Prepare { block, sources: &sources, constants: &step.constants });
}

/// What the colouring asks of a contact that touches, found on all threads: the contacts themselves lie anywhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    contact: u32,
    /// Its bodies as colours name them.
    items: [u32; 2],
    manifolds: u32,
    /// How many points each manifold has.
    points: Points,
    deep: bool,
    load: load::Load,
}

/// One to four points of each of a contact's manifolds, two bits each; of those that find no room, four.
#[derive(Clone, Copy, Debug)]
struct Points(u64);

impl Points {
    fn of(c: &Contact) -> Self {
        let fewer = |m: &ContactManifold| 4 - u64::from(m.count.clamp(1, 4));
        if !c.manifold.more {
            return Self(u64::MAX ^ fewer(&c.manifold));
        }
        Self(c.manifolds().enumerate().take(32).fold(u64::MAX, |bits, (k, m)| bits ^ (fewer(m) << (2 * k))))
    }
    /// Points of a manifold but one.
    fn kind(self, k: u32) -> usize {
        if k < 32 { (self.0 >> (2 * k)) as usize & 3 } else { 3 }
    }
}

fn outline(world: &mut World) {
    let mut outlines = core::mem::take(&mut world.scratch.outlines);
    outlines.begin(world.contacts.len().div_ceil(CONTACTS), CONTACTS);
    let mut contacts = core::mem::take(&mut world.contacts);
    let shared: &World = world;
    let columns = (&mut contacts[..], &shared.heads[..]);
    shared.tasks.for_each_piece(columns, CONTACTS, |first, (contacts, heads)| {
        let mut out = outlines.of(first / CONTACTS);
        for (i, h) in heads.iter().enumerate() {
            if let Some(ahead) = contacts.get(i + AHEAD) {
                call(shared, ahead, &heads[i + AHEAD]);
            }
            if h.touching {
                let c = &mut contacts[i];
                if h.kept {
                    narrowphase::keep(shared, c);
                }
                out.push(Outline {
                    contact: (first + i) as u32,
                    items: h.bodies.map(|b| shared.items[b as usize]),
                    manifolds: c.manifold_count() as u32,
                    points: Points::of(c),
                    deep: c.deep,
                    load: load::Load::of(c),
                });
                // Its rows will say how fast it was in this step.
                c.hit_speed = 0.0;
            }
        }
    });
    (world.contacts, world.scratch.outlines) = (contacts, outlines);
}

/// Asks for what the outline of a contact reads.
fn call(world: &World, c: &Contact, h: &PairHead) {
    if h.touching {
        prefetch(&c.hit_speed);
        prefetch(&c.manifold.normal);
    }
    if h.kept {
        c.manifold.prefetch_gaps();
        h.bodies.iter().for_each(|&b| prefetch(&world.frames[b as usize]));
    }
}

/// Greedy colouring in contact order: cheap enough to do afresh every step, so that it is no state. Beside it what bodies bear is summed up, and what is
/// squeezed gets more mass for the step.
fn color_and_raise(world: &mut World, step: &Step) {
    let World { scratch, awake, contacts, bodies, frames, heads, places, items, settings, .. } = world;
    let rows = awake.state.len();
    let Scratch { outlines, colors, rows: manifolds, deep, loads, crowd, shares, .. } = scratch;
    let outlines = &*outlines;
    let color = || {
        colors.reset(rows);
        manifolds.clear();
        deep.clear();
        outlines.for_each(|o| {
            if o.deep {
                deep.push(o.contact);
            }
            let [a, b] = o.items;
            // A body asleep on a kinematic one that is awake: nothing for the contact to move.
            if a == ColorSets::shared(a) && b == ColorSets::shared(b) {
                return;
            }
            for k in 0..o.manifolds {
                // Rows with as many points lie together: a block is solved as its largest row.
                let place = colors.push_kind(o.points.kind(k), a, b, manifolds.len() as u32);
                manifolds.push((o.contact, k));
                debug_assert!(place.is_some(), "a contact of a body with itself");
            }
        });
        colors.close();
        crowd::share(contacts, deep, frames, crowd, rows, shares);
    };
    let gravity = world.gravity.length();
    let omega = 2.0 * core::f32::consts::PI * settings.contact_hertz;
    let numbers = [gravity, settings.slop(), omega, step.dt];
    let (bodies, heads, places, items, tasks) = (&*bodies, &*heads, &*places, &*items, &world.tasks);
    let raise = || {
        loads.begin(rows);
        outlines.for_each(|o| loads.add(o.items, &o.load));
        // Without weight nothing rests heavily on anything, and momentum is exact.
        if gravity == 0.0 {
            return;
        }
        let jointed = |body: u32| !bodies[body].joints.is_empty();
        let hangs = |body: u32| jointed(body) || bodies[body].vehicle != NONE;
        let touches = |body: u32| {
            bodies[body].contacts.iter().filter_map(move |&id| {
                let h = places[id as usize].head(heads).filter(|h| h.touching)?;
                Some(items[h.other(body) as usize])
            })
        };
        load::raise(tasks, touches, awake, jointed, hangs, loads, numbers);
    };
    tasks.join(color, raise);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BodyDesc, ShapeDesc, WorldDesc};

    /// Every manifold's row has as many points as its kind says, whether or not the contact has others.
    #[test]
    fn kinds_are_numbers_of_points() {
        let mut w = World::new(WorldDesc::default()).expect("valid");
        let ball = ShapeDesc::sphere(0.5);
        w.add_body(BodyDesc::fixed().shape(ball.clone())).expect("valid");
        w.add_body(BodyDesc::dynamic().at([0.0, 0.9, 0.0]).shape(ball)).expect("valid");
        w.step().expect("valid");
        let mut c = w.contacts[0].clone();
        let with = |count: usize| ContactManifold { count: count as u8, ..ContactManifold::NOTHING };
        for first in 1..=4 {
            c.manifold = ContactManifold { more: false, ..with(first) };
            assert_eq!(Points::of(&c).kind(0), first - 1);
            c.manifold.more = true;
            c.rest = (0..39).map(|i| with(1 + (i * 7 + first) % 4)).collect();
            let points = Points::of(&c);
            for (k, m) in c.manifolds().enumerate() {
                let expected = if k < 32 { usize::from(m.count) - 1 } else { 3 };
                assert_eq!(points.kind(k as u32), expected, "{first} {k}");
            }
        }
    }
}
