//! Reading emitters and particles.

use super::desc::EmitterDesc;
use super::state::{Block, Emitter, LANES, get3};
use crate::error::{Error, Result};
use crate::handle::EmitterId;
use crate::world::World;
use jounce_math::{DVec3, Vec3};

/// A particle, as it is at the end of the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleView {
    /// Whose it is.
    pub emitter: EmitterId,
    /// Number among the emitter's particles, in order of birth; wraps after 2³².
    pub serial: u32,
    /// Position in the world, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: Vec3,
    /// Mass, kg.
    pub mass: f32,
    /// Radius in collisions and drag, m.
    pub radius: f32,
    /// Radius to draw: times the emitter's size over life, m.
    pub drawn_radius: f32,
    /// Red, green, blue (linear light), opacity.
    pub color: [f32; 4],
    /// Time since birth, s.
    pub age: f32,
    /// Age at which it dies, s.
    pub lifetime: f32,
}

/// Columns of up to 64 particles that lie next to one another, in order of birth.
#[derive(Clone, Copy, Debug)]
pub struct ParticleSlices<'a> {
    /// What positions count from, in the world, m.
    pub origin: DVec3,
    /// x, y and z, m.
    pub positions: [&'a [f32]; 3],
    /// x, y and z, m/s.
    pub velocities: [&'a [f32]; 3],
    /// s.
    pub ages: &'a [f32],
    /// s.
    pub lifetimes: &'a [f32],
    /// kg.
    pub masses: &'a [f32],
    /// In collisions, m.
    pub radii: &'a [f32],
    /// Numbers in order of birth.
    pub serials: &'a [u32],
}

/// An emitter, to look at.
#[derive(Clone, Copy, Debug)]
pub struct EmitterRef<'a> {
    world: &'a World,
    emitter: &'a Emitter,
    id: EmitterId,
}

impl World {
    /// An emitter by its handle.
    ///
    /// # Errors
    /// A stale handle.
    pub fn emitter(&self, emitter: EmitterId) -> Result<EmitterRef<'_>> {
        let slot = self.emitter_slot(emitter)?;
        Ok(EmitterRef { world: self, emitter: &self.particles.emitters[slot], id: emitter })
    }
    /// All emitters, in slot order.
    pub fn emitters(&self) -> impl Iterator<Item = EmitterId> + '_ {
        self.particles.emitters.iter().map(|(i, _)| self.emitter_id(i))
    }
    /// The first emitter (in slot order) with this name.
    pub fn emitter_named(&self, name: &str) -> Option<EmitterId> {
        let found = self.particles.emitters.iter().find(|(_, e)| e.desc.name.as_deref() == Some(name));
        found.map(|(i, _)| self.emitter_id(i))
    }
    /// All particles: emitter by emitter, the oldest first.
    pub fn particles(&self) -> impl Iterator<Item = ParticleView> + '_ {
        self.particles
            .emitters
            .iter()
            .flat_map(|(i, emitter)| EmitterRef { world: self, emitter, id: self.emitter_id(i) }.particles())
    }
    pub(crate) fn emitter_id(&self, index: u32) -> EmitterId {
        EmitterId { index, generation: self.particles.emitters.generation(index) }
    }
    pub(crate) fn emitter_slot(&self, id: EmitterId) -> Result<u32> {
        if self.particles.emitters.is_live(id.index, id.generation) {
            return Ok(id.index);
        }
        Err(Error::Stale { what: "emitter", index: id.index, generation: id.generation })
    }
}

impl<'a> EmitterRef<'a> {
    /// Its handle.
    pub fn id(&self) -> EmitterId {
        self.id
    }
    /// What it was described as.
    pub fn desc(&self) -> &'a EmitterDesc {
        &self.emitter.desc
    }
    /// Its living particles.
    pub fn len(&self) -> usize {
        self.emitter.count
    }
    /// Has no living particle.
    pub fn is_empty(&self) -> bool {
        self.emitter.count == 0
    }
    /// Particles born so far.
    pub fn born(&self) -> u64 {
        self.emitter.serial - self.emitter.unborn
    }
    /// Particles that were to be born and were not, for want of room.
    pub fn unborn(&self) -> u64 {
        self.emitter.unborn
    }
    /// Particles that were taken out because their numbers went bad.
    pub fn lost(&self) -> u64 {
        self.emitter.lost
    }
    /// Bears particles when its time has come.
    pub fn is_enabled(&self) -> bool {
        self.emitter.desc.enabled
    }
    /// All births that time brings are over.
    pub fn is_finished(&self) -> bool {
        self.emitter.finished
    }
    /// Its particles, the oldest first.
    pub fn particles(&self) -> impl Iterator<Item = ParticleView> + use<'a> {
        let Self { world, emitter, id } = *self;
        emitter.blocks.iter().flat_map(move |&i| {
            let b = &world.particles.pool[i as usize];
            (0..b.count).map(move |l| view(emitter, id, b, l))
        })
    }
    /// The same as columns, for speed.
    pub fn slices(&self) -> impl Iterator<Item = ParticleSlices<'a>> + use<'a> {
        let Self { world, emitter, .. } = *self;
        emitter.blocks.iter().map(move |&i| {
            let b = &world.particles.pool[i as usize];
            let n = b.count;
            ParticleSlices {
                origin: emitter.origin,
                positions: [&b.p[0][..n], &b.p[1][..n], &b.p[2][..n]],
                velocities: [&b.v[0][..n], &b.v[1][..n], &b.v[2][..n]],
                ages: &b.age[..n],
                lifetimes: &b.life[..n],
                masses: &b.mass[..n],
                radii: &b.radius[..n],
                serials: &b.serial[..n],
            }
        })
    }
}

pub(crate) fn view(e: &Emitter, id: EmitterId, b: &Block, l: usize) -> ParticleView {
    let l = l % LANES;
    let part = b.age[l] / b.life[l];
    ParticleView {
        emitter: id,
        serial: b.serial[l],
        position: e.origin + get3(&b.p, l).as_dvec3(),
        velocity: get3(&b.v, l),
        mass: b.mass[l],
        radius: b.radius[l],
        drawn_radius: b.radius[l] * e.desc.size_over_life.at(part),
        color: e.desc.color_over_life.at(part),
        age: b.age[l],
        lifetime: b.life[l],
    }
}
