//! Callbacks into the step: pure functions, registered by name.
//!
//! They may run on any thread in any order, so they must not depend on anything but their arguments.

use crate::room::contacts::state::Surface;
use crate::{BodyId, ParticleView, ShapeId};
use core::fmt;
use jounce_math::{DVec3, Vec3};
use std::sync::Arc;

/// May these two shapes meet? Asked once, when their bounds first overlap.
pub type FilterHook = Arc<dyn Fn(&PairView) -> bool + Send + Sync>;
/// Changes the surface of a manifold, or (by returning false) drops it for this step: one-way platforms, conveyors,
/// slippery spots.
pub type ContactHook = Arc<dyn Fn(&ContactView, &mut Surface) -> bool + Send + Sync>;

/// Does this particle die? Asked for every particle of an emitter that names the hook, at the end of a step.
pub type ParticleHook = Arc<dyn Fn(&ParticleView) -> bool + Send + Sync>;

/// Two shapes that might meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairView {
    /// Shapes.
    pub shapes: [ShapeId; 2],
    /// Their bodies.
    pub bodies: [BodyId; 2],
    /// The bodies' `user_data`.
    pub user_data: [u128; 2],
}

/// One manifold as the contact hook sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactView {
    /// The pair.
    pub pair: PairView,
    /// Unit normal from the first to the second shape, world axes.
    pub normal: Vec3,
    /// Deepest point, world.
    pub point: DVec3,
    /// Gap there, metres, negative for overlap.
    pub separation: f32,
    /// Velocity of the second body against the first at the point, m/s.
    pub relative_velocity: Vec3,
    /// Triangle or child of each shape.
    pub parts: [Option<u32>; 2],
}

/// The registered hooks.
#[derive(Clone, Default)]
pub(crate) struct Hooks {
    pub filter: Option<(String, FilterHook)>,
    pub contact: Option<(String, ContactHook)>,
    pub particle: Vec<(String, ParticleHook)>,
}

impl Hooks {
    pub fn particle(&self, name: &str) -> Option<ParticleHook> {
        self.particle.iter().find(|h| h.0 == name).map(|h| h.1.clone())
    }
}

impl fmt::Debug for Hooks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = (self.filter.as_ref().map(|h| &h.0), self.contact.as_ref().map(|h| &h.0));
        let particle: Vec<&String> = self.particle.iter().map(|h| &h.0).collect();
        f.debug_tuple("Hooks").field(&names).field(&particle).finish()
    }
}

impl crate::World {
    /// Registers (or with `None` removes) the filter hook under a name that recordings keep.
    pub fn set_filter_hook(&mut self, hook: Option<(&str, FilterHook)>) {
        self.hooks.filter = hook.map(|(n, h)| (n.to_owned(), h));
    }
    /// Registers (or with `None` removes) a particle hook under a name: emitters ask for it by
    /// [`crate::EmitterDesc::kill_hook`]. A name that is not registered kills nobody.
    pub fn set_particle_hook(&mut self, name: &str, hook: Option<ParticleHook>) {
        self.hooks.particle.retain(|h| h.0 != name);
        self.hooks.particle.extend(hook.map(|h| (name.to_owned(), h)));
    }
    /// Registers (or with `None` removes) the contact hook under a name that recordings keep.
    pub fn set_contact_hook(&mut self, hook: Option<(&str, ContactHook)>) {
        // It may make any surface run, and what it said stays in contacts that are not tested anew.
        self.running += usize::from(hook.is_some());
        self.hooks.contact = hook.map(|(n, h)| (n.to_owned(), h));
    }
}
