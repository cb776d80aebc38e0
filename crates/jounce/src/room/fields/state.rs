//! The table of fields, and the laws that need no more than a place and a time.

use super::desc::{FieldDesc, FieldLaw, Region};
use crate::BodyId;
use crate::table::Table;
use core::fmt;
use jounce_math::{DVec3, Vec3};
use std::sync::Arc;

/// The caller's own law: acceleration (m/s²) of what is at a place. A pure function: it may run on any thread, in any
/// order, several times a step.
pub type FieldHook = Arc<dyn Fn(&FieldView) -> Vec3 + Send + Sync>;

/// What a field hook is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldView {
    /// Where, m: a body's centre of mass, or a particle.
    pub position: DVec3,
    /// Its velocity, m/s.
    pub velocity: Vec3,
    /// Its mass, kg.
    pub mass: f32,
    /// Simulated time, s.
    pub time_s: f64,
    /// The body, if it is one.
    pub body: Option<BodyId>,
    /// The body's `user_data`; 0 for particles.
    pub user_data: u128,
}

/// A field with what it remembers.
#[derive(Clone, Debug)]
pub(crate) struct FieldRecord {
    pub desc: FieldDesc,
    /// Simulated time at which it was added, s: turning frames speed up from there.
    pub since: f64,
    /// The hook of a user field.
    pub hook: Option<Hook>,
}

/// A [`FieldHook`] that can be printed.
#[derive(Clone)]
pub(crate) struct Hook(pub FieldHook);

impl fmt::Debug for Hook {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("FieldHook")
    }
}

/// All fields, and the time they are asked at.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fields {
    pub table: Table<FieldRecord>,
    /// Simulated time of the substep, s.
    pub time: f64,
    /// Registered hooks, by name.
    pub hooks: Vec<(String, Hook)>,
}

impl Fields {
    /// No field acts: everything about them can be skipped.
    pub fn is_empty(&self) -> bool {
        self.table.len() == 0
    }
    /// The fields that act on some of these layers, in slot order.
    pub fn acting(&self, layers: u32) -> impl Iterator<Item = &FieldRecord> {
        self.table.iter().map(|(_, f)| f).filter(move |f| f.desc.enabled && f.desc.layers & layers != 0)
    }
    pub fn hook(&self, name: &str) -> Option<&Hook> {
        self.hooks.iter().find(|(n, _)| n == name).map(|(_, h)| h)
    }
}

impl FieldRecord {
    /// Can what acts on a body at rest grow by itself, so that it must not fall asleep?
    pub fn is_restless(&self) -> bool {
        match &self.desc.law {
            FieldLaw::NBody { .. } | FieldLaw::User { .. } => true,
            FieldLaw::RotatingFrame { angular_acceleration, .. } => *angular_acceleration != Vec3::ZERO,
            _ => false,
        }
    }
    /// Ω of a turning frame at a time.
    pub fn frame_spin(&self, time: f64) -> Vec3 {
        match self.desc.law {
            FieldLaw::RotatingFrame { angular_velocity, angular_acceleration, .. } => {
                angular_velocity + angular_acceleration * ((time - self.since) as f32)
            }
            _ => Vec3::ZERO,
        }
    }
}

impl Region {
    /// Strength at a point: 1 inside, 0 outside, a smooth ramp over the rim.
    pub(crate) fn weight(&self, p: DVec3) -> f32 {
        match *self {
            Self::Everywhere => 1.0,
            Self::Sphere { center, radius, falloff } => ramp(radius - (p - center).length(), falloff),
            Self::Box { center, half, falloff } => ramp((half - (p - center).abs()).min_component(), falloff),
        }
    }
}

/// 0 outside (depth ≤ 0), 1 from `rim` on, 3t² − 2t³ between.
fn ramp(depth: f64, rim: f64) -> f32 {
    if depth <= 0.0 {
        return 0.0;
    }
    if depth >= rim {
        return 1.0;
    }
    let t = depth / rim;
    (t * t * (3.0 - 2.0 * t)) as f32
}
