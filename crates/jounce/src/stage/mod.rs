//! The algorithm, in order: one file per stage.

mod alike;
mod articulated;
pub(crate) mod broadphase;
pub(crate) mod characters;
pub(crate) mod commands;
pub(crate) mod continuous;
pub(crate) mod fields;
mod flat;
mod footing;
pub(crate) mod forces;
pub(crate) mod guard;
pub(crate) mod islands;
pub(crate) mod joints;
pub(crate) mod narrowphase;
mod nets;
pub(crate) mod particles;
pub(crate) mod prepare;
pub(crate) mod publish;
mod reach;
pub(crate) mod restitution;
pub(crate) mod seams;
pub(crate) mod sensors;
mod siblings;
pub(crate) mod sleep;
pub(crate) mod substep;
pub(crate) mod vehicles;

use crate::room::contacts::impact::Impacts;
use crate::room::contacts::prepare::StepConstants;
use crate::room::contacts::rows::{Block, LANES};
use crate::room::rigid::state::NONE;
use jounce_geometry::{Batch, ManifoldSet};
use jounce_tasks::ColorSets;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError, RwLock, RwLockWriteGuard};

/// What every stage is given about the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Length of the step, seconds.
    pub dt: f32,
    pub substeps: u32,
    pub constants: StepConstants,
}

/// Memory that is reused from step to step and is not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    pub colors: ColorSets,
    /// (contact row, manifold) by payload.
    pub rows: Vec<(u32, u32)>,
    pub places: Places,
    /// By contact row: the block of the colour at hand that has a row of it; of some other, or of none, else.
    pub owners: Vec<u32>,
    /// What the colouring asks of contacts that touch, one list per unit.
    pub outlines: Lists<prepare::Outline>,
    /// Rows or bodies that a unit has found, one list per unit.
    pub found: Lists,
    pub blocks: Vec<Vec<Block>>,
    /// By awake row: velocities before a pass over contacts, and what those of the last substep added to them.
    pub pushed: Vec<crate::room::rigid::pass::Pushed>,
    /// By awake row: what the substeps ask of it.
    pub drives: Vec<crate::room::rigid::pass::Drive>,
    pub ways: Vec<crate::room::rigid::pass::Way>,
    /// What torque-free turns ask of each, row by row.
    pub tops: Vec<crate::room::rigid::free::Top>,
    /// Contact rows that are deep, and how many each awake body has.
    pub deep: Vec<u32>,
    pub crowd: Vec<u32>,
    /// Contact rows that are left a part of their push-out.
    pub shares: Vec<(u32, f32)>,
    pub sets: Lent<ManifoldSet>,
    pub batches: Lent<Batch>,
    pub news: News,
    /// Candidate pairs, one list per unit of the broad phase.
    pub candidates: Vec<Vec<u64>>,
    pub keys: Vec<u64>,
    pub flat: flat::Flat,
    /// Moved shapes that are not in it.
    pub aside: Vec<u32>,
    pub ends: Vec<u32>,
    /// Contact rows that the islands stage looks at.
    pub rows_told: Vec<u32>,
    /// New bounds, one list per unit.
    pub bounds: publish::Moves,
    /// Bodies to wake.
    pub wakes: Vec<u32>,
    /// Bodies of contacts with a fixed one that touch in a new way, or are new among the awake ones.
    pub renewed: Vec<u32>,
    /// What the search for islands at rest knows of each awake row, the island that it is at, and what stands on wheels.
    pub rest: Vec<sleep::Rest>,
    pub island: Vec<u32>,
    pub wheels: Vec<(u32, u32)>,
    /// (root, row, body) of what falls asleep.
    pub resting: Vec<(u32, u32, u32)>,
    /// Emptied lists of islands that woke.
    pub lists: Vec<Vec<u32>>,
    /// Emptied lists of contacts that ended.
    pub manifolds: Vec<Vec<crate::room::contacts::state::ContactManifold>>,
    pub patches: Lent<Vec<seams::Patch>>,
    pub seams: Lists<seams::Seam>,
    pub impacts: Impacts,
    /// Fast bodies and the time of their first hit.
    pub hits: Vec<(u32, f32)>,
    /// Who is inside a sensor.
    pub visitors: Vec<(u32, u32)>,
    pub loads: crate::room::contacts::load::Loads,
    pub fields: fields::FieldScratch,
    pub joints: joints::JointScratch,
    pub leanings: articulated::Leanings,
    /// Sets of joined bodies that turn far, by awake row.
    pub siblings: Vec<u32>,
    pub vehicles: vehicles::VehicleScratch,
    /// By awake row: how hard and which way it was pushed.
    pub squeeze: Vec<(f32, jounce_math::Vec3)>,
    /// By awake row: the last pass of restitution that changed its velocity.
    pub stirred: Vec<u32>,
}

/// Colour and row of a manifold in the solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RowPlace {
    pub color: u8,
    /// Among the rows of the colour.
    pub row: u32,
}

impl RowPlace {
    const NOWHERE: Self = Self { color: 0, row: NONE };
    /// Which block of the colour, and the lane there.
    pub fn lane(&self) -> (usize, usize) {
        (self.row as usize / LANES, self.row as usize % LANES)
    }
}

/// Where in the solver the manifolds of this step are. Beside the contacts, so that to say it writes to none of them; found where somebody wants to
/// know.
#[derive(Clone, Debug, Default)]
pub(crate) struct Places {
    /// By payload of a row.
    rows: Vec<RowPlace>,
    /// By contact row: the payload of its first manifold. Those of the others follow it.
    firsts: Vec<u32>,
}

impl Places {
    /// Finds all: `manifolds` has by payload the contact and which of its manifolds, those of a contact one after the other.
    pub fn find(&mut self, contacts: usize, manifolds: &[(u32, u32)], colors: &ColorSets) {
        self.rows.clear();
        self.rows.resize(manifolds.len(), RowPlace::NOWHERE);
        for color in 0..=ColorSets::COLORS {
            for (row, r) in colors.rows(color).iter().enumerate() {
                self.rows[r.payload() as usize] = RowPlace { color: color as u8, row: row as u32 };
            }
        }
        self.firsts.clear();
        self.firsts.resize(contacts, NONE);
        for (payload, &(contact, manifold)) in manifolds.iter().enumerate() {
            if manifold == 0 {
                self.firsts[contact as usize] = payload as u32;
            }
        }
    }
    /// Where a manifold of a contact is, which must have it; `None` where its row cannot move anything.
    #[inline]
    pub fn get(&self, contact: usize, manifold: usize) -> Option<RowPlace> {
        let &first = self.firsts.get(contact).filter(|f| **f != NONE)?;
        self.rows.get(first as usize + manifold).copied().filter(|p| p.row != NONE)
    }
}

impl Scratch {
    pub fn colors_used(&self) -> usize {
        self.colors.colors()
    }
    pub fn overflow_rows(&self) -> usize {
        self.colors.overflow().len()
    }
}

/// A list per unit; a unit locks its own, so no lock is ever waited for.
#[derive(Debug)]
pub(crate) struct Lists<T = u32>(Vec<RwLock<Vec<T>>>);

impl<T: Copy> Lists<T> {
    /// Makes sure that there are lists for so many units, all empty, with room for so many items each.
    pub fn begin(&mut self, units: usize, room: usize) {
        self.0.resize_with(self.0.len().max(units), RwLock::default);
        for (i, list) in self.0.iter_mut().enumerate() {
            let list = list.get_mut().unwrap_or_else(PoisonError::into_inner);
            list.clear();
            list.reserve(if i < units { room } else { 0 });
        }
    }
    /// That of a unit.
    pub fn of(&self, unit: usize) -> RwLockWriteGuard<'_, Vec<T>> {
        self.0[unit].write().unwrap_or_else(PoisonError::into_inner)
    }
    /// All of them, in the order of units, into one.
    pub fn gather(&mut self, into: &mut Vec<T>) {
        for list in &mut self.0 {
            into.append(list.get_mut().unwrap_or_else(PoisonError::into_inner));
        }
    }
    /// Calls `f` with all items, in the order of units.
    pub fn for_each(&self, mut f: impl FnMut(&T)) {
        for list in &self.0 {
            list.read().unwrap_or_else(PoisonError::into_inner).iter().for_each(&mut f);
        }
    }
}

impl<T> Default for Lists<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Clone for Lists<T> {
    /// Memory, not state: a clone starts without.
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// Contacts that the narrow phase found apart, or that began or ended to touch: a bit each, a word per unit.
#[derive(Debug, Default)]
pub(crate) struct News(Vec<[AtomicU64; 2]>);

impl News {
    /// Makes sure that there are so many units.
    pub fn at_least(&mut self, n: usize) {
        self.0.resize_with(self.0.len().max(n), Default::default);
    }
    /// Contacts of a unit of which others must know, and those with a fixed body that touch in a new way.
    pub fn set(&self, unit: usize, told: u64, renewed: u64) {
        self.0[unit][0].store(told, Ordering::Relaxed);
        self.0[unit][1].store(renewed, Ordering::Relaxed);
    }
    /// Calls `f` with the unit of each contact that is told of, among so many units, and with its place there.
    pub fn told(&self, units: usize, f: impl FnMut(usize, usize)) {
        self.each(0, units, f);
    }
    /// The same of those that touch in a new way.
    pub fn renewed(&self, units: usize, f: impl FnMut(usize, usize)) {
        self.each(1, units, f);
    }
    fn each(&self, which: usize, units: usize, mut f: impl FnMut(usize, usize)) {
        for (unit, words) in self.0.iter().take(units).enumerate() {
            let mut left = words[which].load(Ordering::Relaxed);
            while left != 0 {
                f(unit, left.trailing_zeros() as usize);
                left &= left - 1;
            }
        }
    }
}

impl Clone for News {
    /// Memory, not state: a clone starts without.
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// Memory of units, as much as there ever were units at work at the same time: whoever takes one finds what the last who had it left in it, which
/// is scratch.
#[derive(Debug)]
pub(crate) struct Lent<T>(Mutex<Vec<Box<T>>>);

impl<T: Default> Lent<T> {
    /// Lends one for the time of a call.
    pub fn lend<R>(&self, f: impl FnOnce(&mut T) -> R) -> R {
        let list = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut one = list().pop().unwrap_or_default();
        let result = f(&mut one);
        list().push(one);
        result
    }
}

impl<T> Default for Lent<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T> Clone for Lent<T> {
    /// Memory, not state: a clone starts without.
    fn clone(&self) -> Self {
        Self::default()
    }
}

#[cfg(test)]
mod tests {
    use super::{ColorSets, Places, Scratch};
    use crate::{BodyDesc, Command, JointDesc, JointSolver, Material, ShapeDesc, World, WorldDesc};
    use jounce_math::{DVec3, Vec3};

    /// A world goes on as it would have, whatever earlier steps left in memory that is reused.
    #[test]
    fn scratch_is_no_state() {
        let mut w = World::new(WorldDesc::default()).expect("valid");
        for (x, y, at) in [(0.0, 1.0, 0.0), (0.8, 0.6, -2.0), (-0.8, 0.6, 2.0)] {
            let plane = ShapeDesc::half_space(Vec3::new(x, y, 0.0));
            w.add_body(BodyDesc::fixed().at([at, 0.0, 0.0]).shape(plane)).expect("valid");
        }
        let mut last = None;
        for i in 0..60_u32 {
            let x = f64::from(i * 7 % 5) * 0.5 - 1.0;
            let z = f64::from(i * 3 % 4) * 0.5 - 0.75;
            let surface = |restitution: f32, rolling_friction: f32| Material {
                restitution,
                rolling_friction,
                ..Material::default()
            };
            let shape = match i % 4 {
                0 => ShapeDesc::sphere(0.2).material(surface(0.6, 0.01)),
                1 => ShapeDesc::cuboid([0.2, 0.15, 0.25]).material(surface(0.3, 0.0)),
                2 => ShapeDesc::capsule(0.15, 0.12).material(surface(0.0, 0.02)),
                _ => ShapeDesc::cylinder(0.15, 0.2),
            };
            let d = BodyDesc::dynamic().at([x, 0.6 + 0.4 * f64::from(i / 4), z]).shape(shape);
            let at = d.position;
            let body = w.add_body(d).expect("valid");
            if let (true, Some((other, there))) = (i % 5 == 1, last) {
                w.add_joint(JointDesc::ball(other, body, at.lerp(there, 0.5_f64))).expect("valid");
            }
            last = Some((body, at));
        }
        goes_on_alike(w);
    }

    /// The same of a net of points, in the air and on the floor, with a joint that is let go and one that is held again.
    #[test]
    fn scratch_of_nets_is_no_state() {
        let mut w = World::new(WorldDesc::default()).expect("valid");
        w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).expect("valid");
        let (mut bodies, mut joints) = (Vec::new(), Vec::new());
        for i in 0..30_u32 {
            let at =
                DVec3::new(0.3 * f64::from(i / 6), 0.9 + 0.3 * f64::from(i % 6), 0.02 * f64::from(i % 4));
            let shape = if i % 2 == 0 { ShapeDesc::sphere(0.1) } else { ShapeDesc::capsule(0.05, 0.08) };
            let body = w.add_body(BodyDesc::dynamic().at(at).shape(shape)).expect("valid");
            let below = (i % 6 > 0).then(|| (i as usize - 1, at - DVec3::Y * 0.15));
            let beside = (i >= 6).then(|| (i as usize - 6, at - DVec3::X * 0.15));
            for (other, p) in below.into_iter().chain(beside) {
                let d = JointDesc::ball(bodies[other], body, p).solver(JointSolver::Iterative);
                joints.push(w.add_joint(d).expect("valid"));
            }
            bodies.push(body);
        }
        for half in [false, true] {
            w.apply(Command::SetJointEnabled(joints[7], half)).expect("valid");
            w = goes_on_alike(w);
        }
    }

    /// Steps the world beside one that has forgotten its scratch before each.
    fn goes_on_alike(mut w: World) -> World {
        for step in 0..240 {
            let mut fresh = w.clone();
            fresh.scratch = Scratch::default();
            w.step().expect("valid");
            fresh.step().expect("valid");
            assert_eq!(fresh.hash(), w.hash(), "step {step}");
        }
        w
    }

    /// Every manifold is found where its row is, and none of a contact without rows.
    #[test]
    fn manifolds_have_places() {
        let counts = [1, 0, 3, 1, 2, 0, 4];
        let (mut places, mut colors) = (Places::default(), ColorSets::new());
        for bodies in [2, 30] {
            colors.reset(bodies);
            let mut manifolds = Vec::new();
            for (contact, &n) in counts.iter().enumerate() {
                for k in 0..n {
                    let contact = contact as u32;
                    let (a, b) = (contact % 2, if bodies == 2 { ColorSets::NONE } else { 2 + contact });
                    assert!(colors.push_kind(k, a, b, manifolds.len() as u32).is_some());
                    manifolds.push((contact, k as u32));
                }
            }
            colors.close();
            places.find(counts.len(), &manifolds, &colors);
            let mut seen = 0;
            for (contact, &n) in counts.iter().enumerate() {
                for k in 0..n {
                    let p = places.get(contact, k).expect("a place");
                    let row = colors.rows(usize::from(p.color))[p.row as usize];
                    assert_eq!(manifolds[row.payload() as usize], (contact as u32, k as u32));
                    seen += 1;
                }
                assert!(n > 0 || places.get(contact, 0).is_none());
            }
            assert_eq!(seen, manifolds.len());
            assert!(places.get(counts.len(), 0).is_none());
        }
    }
}
