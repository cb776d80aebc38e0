//! Edits of emitters and particles: the arms of [`World::apply`].

use super::birth::{Stand, area_sums, born, key};
use super::desc::{EmitterDesc, ParticleSpawn};
use super::prepare::ends;
use super::state::{Emitter, Newborn};
use crate::error::{Error, Result};
use crate::event::Event;
use crate::handle::EmitterId;
use crate::limits;
use crate::room::rigid::state::BodyFrame;
use crate::world::World;
use jounce_math::{Pose, WorldPose};

impl World {
    pub(crate) fn do_add_emitter(&mut self, mut d: EmitterDesc) -> Result<EmitterId> {
        self.check_emitter(&mut d)?;
        if self.particles.emitters.len() >= limits::EMITTERS_MAX {
            return Err(Error::Limit { what: "emitters", limit: limits::EMITTERS_MAX });
        }
        let emitter = Emitter {
            areas: area_sums(&d.shape),
            desc: d,
            origin: Default::default(),
            clock: 0,
            serial: 0,
            unborn: 0,
            lost: 0,
            finished: false,
            blocks: Vec::new(),
            count: 0,
            key: 0,
            generation: 0,
        };
        let (index, generation) = self.particles.emitters.insert(emitter);
        let id = EmitterId { index, generation };
        let origin = self.emitter_stand(index).poses[1].p;
        let e = &mut self.particles.emitters[index];
        (e.origin, e.key, e.generation) = (origin, key(e.desc.seed, id.to_bits()), generation);
        Ok(id)
    }

    fn check_emitter(&self, d: &mut EmitterDesc) -> Result<()> {
        d.check()?;
        d.pose.q = d.pose.q.normalize();
        d.body.map_or(Ok(()), |b| self.slot(b).map(|_| ()))
    }

    pub(crate) fn do_remove_emitter(&mut self, id: EmitterId) -> Result<()> {
        let slot = self.emitter_slot(id)?;
        self.particles.clear(slot);
        self.particles.emitters.remove(slot);
        Ok(())
    }

    /// The particles stay, and so does the clock: what has been born counts.
    pub(crate) fn do_set_emitter(&mut self, id: EmitterId, mut d: EmitterDesc) -> Result<()> {
        let slot = self.emitter_slot(id)?;
        self.check_emitter(&mut d)?;
        let rate_hz = self.rate_hz;
        let e = &mut self.particles.emitters[slot];
        e.areas = area_sums(&d.shape);
        e.key = key(d.seed, id.to_bits());
        e.desc = d;
        e.finished = e.finished && ends(e, rate_hz);
        Ok(())
    }

    pub(crate) fn do_enable_emitter(&mut self, id: EmitterId, on: bool) -> Result<()> {
        let slot = self.emitter_slot(id)?;
        self.particles.emitters[slot].desc.enabled = on;
        Ok(())
    }

    pub(crate) fn do_emit_burst(&mut self, id: EmitterId, count: u32) -> Result<()> {
        let slot = self.emitter_slot(id)?;
        let stand = self.emitter_stand(slot);
        let room = self.particle_room(slot);
        let n = (count as usize).min(room);
        for k in 0..n as u64 {
            let e = &self.particles.emitters[slot];
            let newborn = born(e, &stand, e.serial + k, 0.0, 0.0);
            self.particles.push(slot, &newborn);
        }
        let e = &mut self.particles.emitters[slot];
        e.serial += u64::from(count);
        e.unborn += u64::from(count) - n as u64;
        if n < count as usize {
            self.events.push(Event::LimitReached { what: "particles" });
        }
        Ok(())
    }

    pub(crate) fn do_emit_particles(&mut self, id: EmitterId, spawns: &[ParticleSpawn]) -> Result<()> {
        let slot = self.emitter_slot(id)?;
        spawns.iter().try_for_each(ParticleSpawn::check)?;
        if spawns.len() > self.particle_room(slot) {
            return Err(Error::Limit {
                what: "particles",
                limit: self.particles.emitters[slot].desc.max_particles,
            });
        }
        for s in spawns {
            let e = &mut self.particles.emitters[slot];
            let newborn = Newborn {
                p: (s.position - e.origin).as_vec3(),
                v: s.velocity,
                age: 0.0,
                life: s.lifetime_s,
                mass: s.mass,
                radius: s.radius,
                serial: e.serial as u32,
            };
            e.serial += 1;
            self.particles.push(slot, &newborn);
        }
        Ok(())
    }

    pub(crate) fn do_clear_particles(&mut self, id: Option<EmitterId>) -> Result<()> {
        if let Some(id) = id {
            let slot = self.emitter_slot(id)?;
            self.particles.clear(slot);
            return Ok(());
        }
        let slots: Vec<u32> = self.particles.emitters.iter().map(|(i, _)| i).collect();
        slots.into_iter().for_each(|s| self.particles.clear(s));
        Ok(())
    }

    /// How many more particles an emitter may have.
    pub(crate) fn particle_room(&self, slot: u32) -> usize {
        let e = &self.particles.emitters[slot];
        let own = e.desc.max_particles.saturating_sub(e.count);
        own.min(limits::PARTICLES_MAX.saturating_sub(self.particles.count))
    }

    /// Where an emitter is: over the last step, that is the one under way.
    pub(crate) fn emitter_stand(&self, slot: u32) -> Stand {
        let d = &self.particles.emitters[slot].desc;
        let body = d.body.filter(|b| self.bodies.is_live(b.index, b.generation));
        let Some(body) = body else { return Stand::still(d.pose) };
        let f = &self.frames[body.index as usize];
        let local = Pose::new(d.pose.p.as_vec3(), d.pose.q);
        let poses = [start_pose(f, &local), f.shape_pose(&local)];
        let (velocity, spin) = self.velocities(&self.bodies[body.index]);
        Stand { poses, velocity, spin, center: f.center, moving: poses[0] != poses[1] }
    }
}

/// A frame on a body at the start of the step.
pub(crate) fn start_pose(f: &BodyFrame, local: &Pose) -> WorldPose {
    BodyFrame { center: f.center0, rotation: f.rotation0, ..*f }.shape_pose(local)
}
