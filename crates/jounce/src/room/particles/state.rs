//! Columns of the particles.
//!
//! Particles lie in blocks of [`LANES`], every field an array over the lanes, 52 bytes a particle. An emitter lists its
//! blocks in order of birth, and lanes of a block are in order of birth; so "sorted by birth" is the list of blocks, read
//! through. Blocks come from one pool, so that one range of work covers all emitters; which block of the pool it is
//! cannot be seen.

use super::desc::EmitterDesc;
use crate::hash::StateHasher;
use crate::table::Table;
use jounce_math::{DVec3, Vec3};

/// Particles of a block. A multiple of the widest kernel.
pub(crate) const LANES: usize = 64;
/// One field over the lanes.
pub(crate) type Lane = [f32; LANES];
/// A vector field over the lanes.
pub(crate) type Lane3 = [Lane; 3];

/// "No shape".
pub(crate) const FREE: u32 = u32::MAX;

/// Particles of one emitter, next to one another in birth.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// From the emitter's origin, m.
    pub p: Lane3,
    pub v: Lane3,
    /// Seconds since birth; negative for those that are born within the step to come.
    pub age: Lane,
    pub life: Lane,
    pub mass: Lane,
    pub radius: Lane,
    pub serial: [u32; LANES],
    /// Shape that the particle sticks to, by slot and generation, or [`FREE`].
    pub anchor: [u32; LANES],
    pub anchor_generation: [u32; LANES],
    /// Lanes in use, from the first.
    pub count: usize,
    /// Slot of the emitter.
    pub emitter: u32,
    /// Births to come: lanes from `count` on, and which births of the emitter's step they are.
    pub births: usize,
    pub first_birth: usize,
}

impl Default for Block {
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            p: [zero; 3],
            v: [zero; 3],
            age: zero,
            life: zero,
            mass: [1.0; LANES],
            radius: [1.0; LANES],
            serial: [0; LANES],
            anchor: [FREE; LANES],
            anchor_generation: [0; LANES],
            count: 0,
            emitter: FREE,
            births: 0,
            first_birth: 0,
        }
    }
}

/// One particle, out of its block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Newborn {
    pub p: Vec3,
    pub v: Vec3,
    pub age: f32,
    pub life: f32,
    pub mass: f32,
    pub radius: f32,
    pub serial: u32,
}

#[inline(always)]
pub(crate) fn get3(of: &Lane3, l: usize) -> Vec3 {
    Vec3::new(of[0][l % LANES], of[1][l % LANES], of[2][l % LANES])
}

#[inline(always)]
pub(crate) fn set3(of: &mut Lane3, l: usize, v: Vec3) {
    (of[0][l % LANES], of[1][l % LANES], of[2][l % LANES]) = (v.x, v.y, v.z);
}

impl Block {
    /// Adds a particle after the last.
    pub fn push(&mut self, n: &Newborn) {
        let l = self.count % LANES;
        set3(&mut self.p, l, n.p);
        set3(&mut self.v, l, n.v);
        (self.age[l], self.life[l], self.mass[l], self.radius[l]) = (n.age, n.life, n.mass, n.radius);
        (self.serial[l], self.anchor[l], self.anchor_generation[l]) = (n.serial, FREE, 0);
        self.count += 1;
    }

    pub fn place(&self, l: usize) -> Vec3 {
        get3(&self.p, l)
    }
    pub fn velocity(&self, l: usize) -> Vec3 {
        get3(&self.v, l)
    }
    pub fn put(&mut self, l: usize, p: Vec3, v: Vec3) {
        set3(&mut self.p, l, p);
        set3(&mut self.v, l, v);
    }

    fn columns(&mut self) -> [&mut Lane; 10] {
        let Self { p: [px, py, pz], v: [vx, vy, vz], age, life, mass, radius, .. } = self;
        [px, py, pz, vx, vy, vz, age, life, mass, radius]
    }
    fn words(&mut self) -> [&mut [u32; LANES]; 3] {
        [&mut self.serial, &mut self.anchor, &mut self.anchor_generation]
    }

    /// Closes the gaps that dead particles leave; the others keep their order.
    pub fn keep(&mut self, alive: u64) {
        let all = if self.count == LANES { u64::MAX } else { (1 << self.count) - 1 };
        let alive = alive & all;
        if alive == all {
            return;
        }
        let (mut to, mut rest) = (0, alive);
        let mut moves = [0u8; LANES];
        while rest != 0 {
            moves[to] = rest.trailing_zeros() as u8;
            rest &= rest - 1;
            to += 1;
        }
        for column in self.columns() {
            (0..to).for_each(|i| column[i] = column[usize::from(moves[i])]);
        }
        for column in self.words() {
            (0..to).for_each(|i| column[i] = column[usize::from(moves[i])]);
        }
        self.count = to;
    }

    /// Appends the particles of a later block, which must fit.
    pub fn append(&mut self, later: &mut Self) {
        debug_assert!(self.count + later.count <= LANES);
        let (at, n) = (self.count, later.count);
        for (a, b) in self.columns().into_iter().zip(later.columns()) {
            a[at..at + n].copy_from_slice(&b[..n]);
        }
        for (a, b) in self.words().into_iter().zip(later.words()) {
            a[at..at + n].copy_from_slice(&b[..n]);
        }
        self.count += n;
        later.count = 0;
    }

    /// Moves the origin that positions count from.
    pub fn shift(&mut self, by: Vec3) {
        for (column, d) in self.p.iter_mut().zip(by.to_array()) {
            column.iter_mut().for_each(|x| *x -= d);
        }
    }
}

/// An emitter with its particles.
#[derive(Clone, Debug)]
pub(crate) struct Emitter {
    pub desc: EmitterDesc,
    /// What positions count from.
    pub origin: DVec3,
    /// Steps that it has run.
    pub clock: u64,
    /// Particles born so far, those left out for want of room included.
    pub serial: u64,
    /// Of these, those left out for want of room. A count for people: it steers nothing, so it is not hashed.
    pub unborn: u64,
    /// Particles that were taken out because their numbers went bad.
    pub lost: u64,
    /// No more births by time.
    pub finished: bool,
    /// In order of birth, as indices of the pool.
    pub blocks: Vec<u32>,
    pub count: usize,
    /// Sums of the areas of a mesh's triangles.
    pub areas: Vec<f32>,
    /// Start of its random numbers.
    pub key: u64,
    /// Of its handle.
    pub generation: u32,
}

/// All emitters and particles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Particles {
    pub emitters: Table<Emitter>,
    pub pool: Vec<Block>,
    pub free: Vec<u32>,
    /// Particles of all emitters.
    pub count: usize,
    pub scratch: super::solve::Scratch,
}

impl Particles {
    /// An empty block, listed as the emitter's last.
    pub fn add_block(&mut self, slot: u32) -> u32 {
        let i = self.free.pop().unwrap_or_else(|| {
            self.pool.push(Block::default());
            self.pool.len() as u32 - 1
        });
        let b = &mut self.pool[i as usize];
        (b.count, b.births, b.first_birth, b.emitter) = (0, 0, 0, slot);
        self.emitters[slot].blocks.push(i);
        i
    }

    pub fn free_block(&mut self, i: u32) {
        let b = &mut self.pool[i as usize];
        (b.count, b.births, b.emitter) = (0, 0, FREE);
        self.free.push(i);
    }

    /// Removes all particles of an emitter.
    pub fn clear(&mut self, slot: u32) {
        for i in core::mem::take(&mut self.emitters[slot].blocks) {
            self.free_block(i);
        }
        self.count -= self.emitters[slot].count;
        self.emitters[slot].count = 0;
    }

    /// Appends a particle to an emitter.
    pub fn push(&mut self, slot: u32, n: &Newborn) {
        let last = self.emitters[slot].blocks.last().copied();
        let last = last.filter(|&i| self.pool[i as usize].count < LANES);
        let i = last.unwrap_or_else(|| self.add_block(slot));
        self.pool[i as usize].push(n);
        self.emitters[slot].count += 1;
        self.count += 1;
    }

    /// Nothing is hashed in a world that never had an emitter.
    pub fn hash(&self, h: &mut StateHasher) {
        for w in self.emitters.allocator_words() {
            h.pair(w, 5);
        }
        for (slot, e) in self.emitters.iter() {
            h.pair(slot, u32::from(e.finished) | (u32::from(e.desc.enabled) << 1));
            h.dvec3(e.origin);
            [e.clock, e.serial, e.lost, e.key, e.count as u64].into_iter().for_each(|w| h.word(w));
            for &i in &e.blocks {
                self.pool[i as usize].hash(h);
            }
        }
    }
}

impl Block {
    fn hash(&self, h: &mut StateHasher) {
        h.word(self.count as u64);
        for l in 0..self.count {
            h.floats(self.p[0][l], self.p[1][l]);
            h.floats(self.p[2][l], self.v[0][l]);
            h.floats(self.v[1][l], self.v[2][l]);
            h.floats(self.age[l], self.life[l]);
            h.floats(self.mass[l], self.radius[l]);
            h.pair(self.serial[l], self.anchor[l]);
        }
    }
}
