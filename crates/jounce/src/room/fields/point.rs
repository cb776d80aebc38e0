//! Fields at a point: what a centre of mass, a particle or any matter without shape feels.

use super::desc::{AIR_DENSITY, AIR_VISCOSITY, FieldLaw};
use super::gust;
use super::state::{FieldRecord, FieldView, Fields};
use crate::limits::FIELD_ACCELERATION_MAX;
use jounce_math::{DVec3, Vec3, scalar::f64s};
use jounce_motion::force;

/// What all fields together say at one place and time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FieldSample {
    /// Acceleration by uniform, point, user and frame fields, without the world's own gravity, m/s².
    pub acceleration: Vec3,
    /// Velocity of the medium, m/s.
    pub flow: Vec3,
    /// Density of the medium, kg/m³; 0 in a vacuum.
    pub density: f32,
    /// Viscosity of the medium, Pa s.
    pub viscosity: f32,
    /// Under a liquid's surface: the medium is that liquid, and buoyancy is not in `acceleration`.
    pub submerged: bool,
}

/// Accelerations by mass at a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pull {
    /// By gravity-like laws: scaled by a body's `gravity_scale`.
    pub gravity: Vec3,
    /// By frames (without Coriolis' part) and hooks.
    pub other: Vec3,
    /// Ω of the frame: v turns at −2Ω.
    pub spin: Vec3,
}

/// The medium in the open, and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Medium {
    pub density: f32,
    pub viscosity: f32,
    pub flow: Vec3,
}

/// An acceleration with components of at most [`FIELD_ACCELERATION_MAX`]: beside a mass without size a pull has no bound, and
/// what overflows in f32 would reach the neighbours of a body through its contacts. NaN stays.
pub(crate) fn bounded(a: DVec3) -> Vec3 {
    // NaN in the second place stays.
    let within = |x: f64| f64s::min(FIELD_ACCELERATION_MAX, f64s::max(-FIELD_ACCELERATION_MAX, x));
    DVec3::new(within(a.x), within(a.y), within(a.z)).as_vec3()
}

impl crate::World {
    /// What the fields say at a place now, for matter of these layers that moves with `velocity`. The world's own gravity
    /// ([`crate::World::gravity`]) is not in it.
    pub fn sample_fields(&self, at: DVec3, velocity: Vec3, layers: u32) -> FieldSample {
        let _mode = jounce_tasks::FloatEnv::set_default();
        self.fields.sample(at, velocity, layers)
    }
}

impl Fields {
    /// What acts on matter of these layers at `at`, moving with `velocity`.
    pub fn sample(&self, at: DVec3, velocity: Vec3, layers: u32) -> FieldSample {
        let view =
            FieldView { position: at, velocity, mass: 0.0, time_s: self.time, body: None, user_data: 0 };
        let pull = self.pull(&view, layers);
        let (m, submerged) = self.around(at, layers);
        FieldSample {
            acceleration: pull.gravity + pull.other - pull.spin.cross(velocity) * 2.0,
            flow: m.flow,
            density: m.density,
            viscosity: m.viscosity,
            submerged,
        }
    }

    /// What is at a place, in the open or under water, and whether that is water.
    pub fn around(&self, at: DVec3, layers: u32) -> (Medium, bool) {
        let mut m = self.medium(at, layers);
        let mut submerged = false;
        for f in self.acting(layers) {
            if let FieldLaw::Water { surface, normal, density, viscosity, velocity, .. } = f.desc.law {
                let below = normal.as_dvec3().dot(at - surface) < 0.0;
                if below && density > m.density && f.desc.region.weight(at) > 0.0 {
                    m = Medium { density, viscosity, flow: velocity };
                    submerged = true;
                }
            }
        }
        (m, submerged)
    }

    /// Accelerations, without the attraction of chosen bodies on one another.
    pub fn pull(&self, view: &FieldView, layers: u32) -> Pull {
        let mut pull = Pull::default();
        for f in self.acting(layers) {
            let w = f.desc.region.weight(view.position);
            if w > 0.0 {
                f.add_pull(view, w, self.time, &mut pull);
            }
        }
        pull
    }

    /// The medium in the open: the densest of the media, all flows together.
    pub fn medium(&self, at: DVec3, layers: u32) -> Medium {
        let mut m = Medium::default();
        let (mut any_flow, mut any_medium) = (false, false);
        for f in self.acting(layers) {
            let flows = matches!(f.desc.law, FieldLaw::Wind { .. } | FieldLaw::Vortex { .. });
            let drags = matches!(f.desc.law, FieldLaw::Drag { .. });
            any_medium |= drags;
            if !(flows || drags) {
                continue;
            }
            let w = f.desc.region.weight(at);
            if w <= 0.0 {
                continue;
            }
            match f.desc.law {
                FieldLaw::Drag { density, viscosity } if density * w >= m.density => {
                    (m.density, m.viscosity) = (density * w, viscosity * w);
                }
                FieldLaw::Drag { .. } => {}
                _ => {
                    m.flow += f.flow(at, self.time) * w;
                    any_flow = true;
                }
            }
        }
        if any_flow && !any_medium {
            (m.density, m.viscosity) = (AIR_DENSITY, AIR_VISCOSITY);
        }
        m
    }
}

impl FieldRecord {
    fn add_pull(&self, view: &FieldView, w: f32, time: f64, pull: &mut Pull) {
        match self.desc.law {
            FieldLaw::Uniform { acceleration } => pull.gravity += acceleration * w,
            FieldLaw::Point { center, mu, softening } => {
                let a = force::gravitation(mu, 1.0, 1.0, center - view.position, softening);
                pull.gravity += bounded(a) * w;
            }
            FieldLaw::RotatingFrame { origin, angular_acceleration, .. } => {
                let spin = self.frame_spin(time);
                let r = view.position - origin;
                let omega = spin.as_dvec3();
                let a = force::centrifugal(1.0, omega, r)
                    + force::euler_force(1.0, angular_acceleration.as_dvec3(), r);
                pull.other += bounded(a) * w;
                pull.spin += spin * w;
            }
            FieldLaw::User { .. } => {
                if let Some(h) = &self.hook {
                    pull.other += bounded((h.0)(view).as_dvec3()) * w;
                }
            }
            _ => {}
        }
    }

    /// Velocity of the medium that this field adds.
    fn flow(&self, at: DVec3, time: f64) -> Vec3 {
        match self.desc.law {
            FieldLaw::Wind { velocity, gust } => {
                velocity + gust.map_or(Vec3::ZERO, |g| gust::velocity(&g, velocity, at, time))
            }
            FieldLaw::Vortex { center, axis, speed, core_radius, inflow, updraft } => {
                let d = (at - center).as_vec3();
                let radial = d - axis * d.dot(axis);
                let Some((out, r)) = radial.try_normalize() else { return axis * updraft };
                // Rankine's vortex: solid turn in the core, potential flow outside.
                let x = r / core_radius;
                let swirl = if x < 1.0 { speed * x } else { speed / x };
                let up = if x < 1.0 { updraft } else { updraft / (x * x) };
                axis.cross(out) * swirl - out * (inflow * swirl) + axis * up
            }
            _ => Vec3::ZERO,
        }
    }
}
