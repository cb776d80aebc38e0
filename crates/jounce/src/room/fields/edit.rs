//! Adding, changing and asking for fields.

use super::desc::{FieldDesc, FieldLaw, Region};
use super::state::{FieldHook, FieldRecord, Hook};
use crate::error::{Error, Result, bad};
use crate::handle::FieldId;
use crate::hash::StateHasher;
use crate::limits;
use crate::world::World;
use jounce_math::{DVec3, Vec3};
use std::sync::Arc;

impl World {
    /// Registers (or with `None` removes) a hook that user fields name; recordings keep the name. Fields that already
    /// use the name follow.
    pub fn set_field_hook(&mut self, name: &str, hook: Option<FieldHook>) {
        self.fields.hooks.retain(|(n, _)| n != name);
        if let Some(h) = &hook {
            self.fields.hooks.push((name.to_owned(), Hook(Arc::clone(h))));
        }
        for i in 0..self.fields.table.slots() {
            if let Some(f) = self.fields.table.get_mut(i)
                && matches!(&f.desc.law, FieldLaw::User { hook } if hook == name)
            {
                f.hook = hook.clone().map(Hook);
            }
        }
        self.wake_all();
    }
    /// All fields, in slot order.
    pub fn fields(&self) -> impl Iterator<Item = FieldId> + '_ {
        self.fields.table.iter().map(|(index, _)| self.field_id(index))
    }
    /// A field's description.
    ///
    /// # Errors
    /// A stale handle.
    pub fn field(&self, id: FieldId) -> Result<&FieldDesc> {
        let slot = self.field_slot(id)?;
        Ok(&self.fields.table[slot].desc)
    }

    pub(crate) fn field_id(&self, index: u32) -> FieldId {
        FieldId { index, generation: self.fields.table.generation(index) }
    }
    fn field_slot(&self, id: FieldId) -> Result<u32> {
        if self.fields.table.is_live(id.index, id.generation) {
            return Ok(id.index);
        }
        Err(Error::Stale { what: "field", index: id.index, generation: id.generation })
    }

    fn field_record(&self, desc: FieldDesc) -> Result<FieldRecord> {
        desc.check()?;
        let mut hook = None;
        match &desc.law {
            FieldLaw::NBody { bodies, .. } => {
                for &b in bodies {
                    self.slot(b)?;
                }
            }
            FieldLaw::User { hook: name } => {
                hook = self.fields.hook(name).cloned();
                if hook.is_none() {
                    let expected = "the name of a registered hook: call set_field_hook first";
                    return Err(bad("field", "hook", name, expected));
                }
            }
            _ => {}
        }
        Ok(FieldRecord { desc, since: self.time(), hook })
    }

    pub(crate) fn do_add_field(&mut self, desc: FieldDesc) -> Result<FieldId> {
        let record = self.field_record(desc)?;
        if self.fields.table.len() >= limits::FIELDS_MAX {
            return Err(Error::Limit { what: "fields", limit: limits::FIELDS_MAX });
        }
        let (index, generation) = self.fields.table.insert(record);
        self.wake_all();
        Ok(FieldId { index, generation })
    }

    pub(crate) fn do_remove_field(&mut self, id: FieldId) -> Result<()> {
        let slot = self.field_slot(id)?;
        self.fields.table.remove(slot);
        self.wake_all();
        Ok(())
    }

    pub(crate) fn do_set_field(&mut self, id: FieldId, desc: FieldDesc) -> Result<()> {
        let slot = self.field_slot(id)?;
        let record = self.field_record(desc)?;
        self.fields.table[slot] = record;
        self.wake_all();
        Ok(())
    }

    /// Potential energy in the fields that have one, J: uniform, point, and bodies on one another.
    pub(crate) fn field_energy(&self) -> f64 {
        let mut sum = 0.0;
        for f in self.fields.acting(u32::MAX) {
            match &f.desc.law {
                FieldLaw::Uniform { acceleration } => {
                    let g = acceleration.as_dvec3();
                    sum += self.weigh(f, |c| -g.dot(c));
                }
                FieldLaw::Point { center, mu, softening } => {
                    sum += self.weigh(f, |c| {
                        let d = (c - *center).length_squared() + softening * softening;
                        // At the centre of an unsoftened point there is no pull and no depth that could be told.
                        if d > 0.0 { -mu / d.sqrt() } else { 0.0 }
                    });
                }
                FieldLaw::NBody { bodies, g, softening } => {
                    let at: Vec<(f64, DVec3)> = bodies
                        .iter()
                        .filter_map(|&b| self.slot(b).ok())
                        .map(|s| crate::stage::fields::attractor(self, s))
                        .map(|(_, p, m)| (m, p))
                        .collect();
                    for (i, a) in at.iter().enumerate() {
                        for b in &at[..i] {
                            let d = (b.1 - a.1).length_squared() + softening * softening;
                            sum -= if d > 0.0 { g * a.0 * b.0 / d.sqrt() } else { 0.0 };
                        }
                    }
                }
                _ => {}
            }
        }
        sum
    }

    /// Σ m w φ(c) over the dynamic bodies that a field acts on.
    fn weigh(&self, f: &FieldRecord, potential: impl Fn(DVec3) -> f64) -> f64 {
        let mut sum = 0.0;
        for (i, b) in self.bodies.iter().filter(|(_, b)| b.enabled && b.mass.inv_mass > 0.0) {
            let layers = b.shapes.iter().fold(0, |l, &s| l | self.shapes[s].filter.layers);
            if layers & f.desc.layers != 0 || b.shapes.is_empty() {
                let c = self.frames[i as usize].center;
                let w = f64::from(f.desc.region.weight(c)) * f64::from(b.gravity_scale);
                sum += f64::from(b.mass.mass) * w * potential(c);
            }
        }
        sum
    }

    pub(crate) fn hash_fields(&self, h: &mut StateHasher) {
        for w in self.fields.table.allocator_words() {
            h.pair(w, 5);
        }
        for (i, f) in self.fields.table.iter() {
            h.pair(i, f.desc.layers);
            h.pair(u32::from(f.desc.enabled), f.desc.law.name().len() as u32);
            h.double(f.since);
            hash_law(h, &f.desc.law);
            hash_region(h, &f.desc.region);
        }
    }
}

fn hash_region(h: &mut StateHasher, region: &Region) {
    match *region {
        Region::Everywhere => h.word(0),
        Region::Sphere { center, radius, falloff } => {
            h.word(1);
            h.dvec3(center);
            h.double(radius);
            h.double(falloff);
        }
        Region::Box { center, half, falloff } => {
            h.word(2);
            h.dvec3(center);
            h.dvec3(half);
            h.double(falloff);
        }
    }
}

fn hash_law(h: &mut StateHasher, law: &FieldLaw) {
    match law {
        FieldLaw::Uniform { acceleration } => h.vec3(*acceleration),
        FieldLaw::Point { center, mu, softening } => {
            h.dvec3(*center);
            h.double(*mu);
            h.double(*softening);
        }
        FieldLaw::NBody { bodies, g, softening } => {
            bodies.iter().for_each(|b| h.word(b.to_bits()));
            h.double(*g);
            h.double(*softening);
        }
        FieldLaw::Wind { velocity, gust } => {
            h.vec3(*velocity);
            if let Some(g) = gust {
                h.vec3(Vec3::new(g.speed, g.size, g.time_s));
                h.word(g.seed);
            }
        }
        FieldLaw::Drag { density, viscosity } => h.floats(*density, *viscosity),
        FieldLaw::Water { surface, normal, density, viscosity, linear_drag, velocity } => {
            h.dvec3(*surface);
            h.vec3(*normal);
            h.vec3(*velocity);
            h.floats(*density, *viscosity);
            h.floats(*linear_drag, 0.0);
        }
        FieldLaw::Vortex { center, axis, speed, core_radius, inflow, updraft } => {
            h.dvec3(*center);
            h.vec3(*axis);
            h.floats(*speed, *core_radius);
            h.floats(*inflow, *updraft);
        }
        FieldLaw::RotatingFrame { origin, angular_velocity, angular_acceleration } => {
            h.dvec3(*origin);
            h.vec3(*angular_velocity);
            h.vec3(*angular_acceleration);
        }
        FieldLaw::User { hook } => hook.bytes().for_each(|b| h.word(u64::from(b))),
    }
}
