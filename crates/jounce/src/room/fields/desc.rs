//! What users write about fields.

use crate::error::{Error, Result, bad, check};
use crate::{BodyId, limits};
use jounce_math::{DVec3, Vec3};

/// Density of air at sea level that the course uses, kg/m³.
pub const AIR_DENSITY: f32 = 1.2;
/// Viscosity of air at 20 °C, Pa s.
pub const AIR_VISCOSITY: f32 = 1.81e-5;
/// Density of fresh water, kg/m³.
pub const WATER_DENSITY: f32 = 1000.0;
/// Viscosity of water at 20 °C, Pa s.
pub const WATER_VISCOSITY: f32 = 1.0e-3;

/// A law that acts on everything in a region: bodies, particles, and whatever rooms are added later.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldDesc {
    /// What it does.
    pub law: FieldLaw,
    /// Where it acts. Default everywhere.
    pub region: Region,
    /// Layers it acts on (bits): a shape (or emitter) on one of them feels it. Default all.
    pub layers: u32,
    /// Acts at all. Default true.
    pub enabled: bool,
    /// For people and files.
    pub name: Option<String>,
}

/// Where a field acts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Region {
    /// The whole world.
    #[default]
    Everywhere,
    /// A ball.
    Sphere {
        /// Centre, m.
        center: DVec3,
        /// Radius, m.
        radius: f64,
        /// Width of the rim in which the strength falls smoothly to zero, m; 0 for a sharp edge.
        falloff: f64,
    },
    /// A box along the world's axes.
    Box {
        /// Centre, m.
        center: DVec3,
        /// Half extents, m.
        half: DVec3,
        /// Width of the rim in which the strength falls smoothly to zero, m; 0 for a sharp edge.
        falloff: f64,
    },
}

/// Irregular part of a wind: a smooth random velocity, the same for everyone at one place and time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gust {
    /// Root mean square of each component of the irregular velocity, about, m/s.
    pub speed: f32,
    /// Size of an eddy, m.
    pub size: f32,
    /// Time in which an eddy changes, s.
    pub time_s: f32,
    /// Which of the many gusts.
    pub seed: u64,
}

/// The laws that a field can follow. Accelerations act on mass whatever the body's shape; flows and media act on
/// surfaces and volumes, by the drag, lift and buoyancy of each shape.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FieldLaw {
    /// Acceleration g everywhere alike, on top of the world's gravity, m/s².
    Uniform {
        /// g, m/s².
        acceleration: Vec3,
    },
    /// Attraction by a point: a = −μ d/(d² + ε²)^{3/2}, d from the centre.
    Point {
        /// The centre, m.
        center: DVec3,
        /// μ = G M, m³/s²; negative repels.
        mu: f64,
        /// ε, m: keeps a close passage finite.
        softening: f64,
    },
    /// The bodies named attract one another: a_i = Σ_j G m_j d_ij/(d_ij² + ε²)^{3/2}. Fixed and kinematic bodies attract
    /// with the mass of their shapes (or their override) and are not moved.
    NBody {
        /// Who.
        bodies: Vec<BodyId>,
        /// G, m³/(kg s²); 6.67430e-11 for nature's.
        g: f64,
        /// ε, m.
        softening: f64,
    },
    /// The medium moves: adds to the flow that drag and lift are counted against.
    Wind {
        /// Steady part, m/s.
        velocity: Vec3,
        /// Irregular part.
        gust: Option<Gust>,
    },
    /// The medium that bodies move through: drag ½ρ|u|²A C_d and Stokes' 6πηr|u|, lift of spinning balls. Without one,
    /// flows act in air of [`AIR_DENSITY`]; without flow either, there is a vacuum.
    Drag {
        /// ρ, kg/m³.
        density: f32,
        /// η, Pa s.
        viscosity: f32,
    },
    /// Still water (or any liquid) below a plane: buoyancy of the exact volume under the surface through its centroid, and
    /// drag of the part that is under. The surface is at right angles to gravity by right; the force is −ρ V g.
    Water {
        /// A point of the surface, m.
        surface: DVec3,
        /// Unit normal, out of the water.
        normal: Vec3,
        /// ρ, kg/m³.
        density: f32,
        /// η, Pa s.
        viscosity: f32,
        /// Extra linear drag per mass of displaced water, 1/s: F = −k ρ V u. Stands for waves and added mass; calms bobbing.
        linear_drag: f32,
        /// Velocity of the stream, m/s.
        velocity: Vec3,
    },
    /// A whirl around an axis: outside the core the speed falls as 1/r (potential vortex), inside it grows as r.
    Vortex {
        /// A point of the axis, m.
        center: DVec3,
        /// Unit direction of the axis; the flow turns right-handed about it.
        axis: Vec3,
        /// Speed at the rim of the core, m/s.
        speed: f32,
        /// Radius of the core, m.
        core_radius: f32,
        /// Part of the speed that points to the axis.
        inflow: f32,
        /// Speed along the axis in the core, m/s; falls off outside as (core radius / r)².
        updraft: f32,
    },
    /// The world's axes turn: everything feels −Ω×(Ω×r) − 2Ω×v − Ω′×r.
    RotatingFrame {
        /// A point of the axis, m.
        origin: DVec3,
        /// Ω, rad/s.
        angular_velocity: Vec3,
        /// Ω′, rad/s². Ω grows by it from the time that the field is added.
        angular_acceleration: Vec3,
    },
    /// The acceleration comes from a hook registered under this name: [`crate::World::set_field_hook`].
    User {
        /// Name of the hook.
        hook: String,
    },
}

impl FieldDesc {
    /// A law that acts everywhere on everyone.
    pub fn new(law: FieldLaw) -> Self {
        Self { law, region: Region::Everywhere, layers: u32::MAX, enabled: true, name: None }
    }
    /// Air: drag and lift at [`AIR_DENSITY`], without wind.
    pub fn air() -> Self {
        Self::new(FieldLaw::Drag { density: AIR_DENSITY, viscosity: AIR_VISCOSITY })
    }
    /// A steady wind, m/s.
    pub fn wind(velocity: impl Into<Vec3>) -> Self {
        Self::new(FieldLaw::Wind { velocity: velocity.into(), gust: None })
    }
    /// Fresh water below the height `level` (y up).
    pub fn water(level: f64) -> Self {
        Self::new(FieldLaw::Water {
            surface: DVec3::new(0.0, level, 0.0),
            normal: Vec3::Y,
            density: WATER_DENSITY,
            viscosity: WATER_VISCOSITY,
            linear_drag: 0.5,
            velocity: Vec3::ZERO,
        })
    }
    /// Sets where it acts.
    pub fn within(mut self, region: Region) -> Self {
        self.region = region;
        self
    }
    /// Sets the layers it acts on.
    pub fn on_layers(mut self, layers: u32) -> Self {
        self.layers = layers;
        self
    }

    /// Refuses numbers that no field can have.
    ///
    /// # Errors
    /// Names the field.
    pub fn check(&self) -> Result<()> {
        let len = self.name.as_ref().map_or(0, String::len);
        check(len <= limits::NAME_MAX, "field", "name", len, "at most 256 bytes")?;
        self.region.check()?;
        self.law.check()
    }
}

fn point(field: &'static str, p: DVec3) -> Result<()> {
    let ok = p.is_finite() && p.abs().max_component() <= limits::POSITION_MAX;
    check(ok, "field", field, p, "finite, within 1e9 m")
}

fn vector(field: &'static str, v: Vec3, max: f32, expected: &'static str) -> Result<()> {
    check(v.is_finite() && v.abs().max_component() <= max, "field", field, v, expected)
}

fn unit(field: &'static str, v: Vec3) -> Result<()> {
    check((v.length() - 1.0).abs() < 1e-3, "field", field, v, "a unit vector")
}

fn range(field: &'static str, v: f32, lo: f32, hi: f32, expected: &'static str) -> Result<()> {
    check(v >= lo && v <= hi, "field", field, v, expected)
}

fn softness(softening: f64) -> Result<()> {
    check((0.0..=1e9).contains(&softening), "field", "softening", softening, "0 to 1e9 m")
}

impl Region {
    fn check(&self) -> Result<()> {
        let size = |field, v: f64| check(v > 0.0 && v <= 1e9, "field", field, v, "above 0, at most 1e9 m");
        let rim = |v: f64| check((0.0..=1e9).contains(&v), "field", "falloff", v, "0 to 1e9 m");
        match *self {
            Self::Everywhere => Ok(()),
            Self::Sphere { center, radius, falloff } => {
                point("center of the region", center)?;
                size("radius of the region", radius)?;
                rim(falloff)
            }
            Self::Box { center, half, falloff } => {
                point("center of the region", center)?;
                for v in half.to_array() {
                    size("half of the region", v)?;
                }
                rim(falloff)
            }
        }
    }
}

impl Gust {
    fn check(&self) -> Result<()> {
        range("gust.speed", self.speed, 0.0, 1e3, "0 to 1000 m/s")?;
        range("gust.size", self.size, 1e-3, 1e6, "0.001 to 1e6 m")?;
        range("gust.time_s", self.time_s, 1e-3, 1e6, "0.001 to 1e6 s")
    }
}

const SPEED: &str = "finite, at most 10000 m/s";

impl FieldLaw {
    /// The law's name in scene files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Uniform { .. } => "uniform",
            Self::Point { .. } => "point",
            Self::NBody { .. } => "n_body",
            Self::Wind { .. } => "wind",
            Self::Drag { .. } => "drag",
            Self::Water { .. } => "water",
            Self::Vortex { .. } => "vortex",
            Self::RotatingFrame { .. } => "rotating_frame",
            Self::User { .. } => "user",
        }
    }

    fn check(&self) -> Result<()> {
        let medium = |density: f32, viscosity: f32| {
            range("density", density, 0.0, 1e6, "0 to 1e6 kg/m³")?;
            range("viscosity", viscosity, 0.0, 1e6, "0 to 1e6 Pa s")
        };
        match self {
            Self::Uniform { acceleration } => {
                vector("acceleration", *acceleration, 1e6, "finite, at most 1e6 m/s²")
            }
            Self::Point { center, mu, softening } => {
                point("center", *center)?;
                check(mu.is_finite() && mu.abs() <= 1e30, "field", "mu", mu, "finite, at most 1e30 m³/s²")?;
                softness(*softening)
            }
            Self::NBody { bodies, g, softening } => {
                let (n, max) = (bodies.len(), limits::N_BODY_MAX);
                if n > max {
                    return Err(Error::Limit { what: "bodies of an n-body field", limit: max });
                }
                let mut sorted = bodies.clone();
                sorted.sort_unstable();
                if let Some(w) = sorted.windows(2).find(|w| w[0] == w[1]) {
                    return Err(bad("field", "bodies", w[0], "each body once"));
                }
                check(g.is_finite() && g.abs() <= 1e20, "field", "g", g, "finite, at most 1e20 m³/(kg s²)")?;
                softness(*softening)
            }
            Self::Wind { velocity, gust } => {
                vector("velocity", *velocity, 1e4, SPEED)?;
                gust.as_ref().map_or(Ok(()), Gust::check)
            }
            Self::Drag { density, viscosity } => medium(*density, *viscosity),
            Self::Water { surface, normal, density, viscosity, linear_drag, velocity } => {
                point("surface", *surface)?;
                unit("normal", *normal)?;
                medium(*density, *viscosity)?;
                range("linear_drag", *linear_drag, 0.0, 1e4, "0 to 10000 1/s")?;
                vector("velocity", *velocity, 1e4, SPEED)
            }
            Self::Vortex { center, axis, speed, core_radius, inflow, updraft } => {
                point("center", *center)?;
                unit("axis", *axis)?;
                range("speed", *speed, -1e4, 1e4, "-10000 to 10000 m/s")?;
                range("core_radius", *core_radius, 1e-3, 1e6, "0.001 to 1e6 m")?;
                range("inflow", *inflow, -10.0, 10.0, "-10 to 10")?;
                range("updraft", *updraft, -1e4, 1e4, "-10000 to 10000 m/s")
            }
            Self::RotatingFrame { origin, angular_velocity, angular_acceleration } => {
                point("origin", *origin)?;
                vector("angular_velocity", *angular_velocity, 1e3, "finite, at most 1000 rad/s")?;
                vector("angular_acceleration", *angular_acceleration, 1e3, "finite, at most 1000 rad/s²")
            }
            Self::User { hook } => {
                let len = hook.len();
                check((1..=limits::NAME_MAX).contains(&len), "field", "hook", len, "1 to 256 bytes")
            }
        }
    }
}

/// How a shape meets the medium around it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Aero {
    /// C_d of quadratic drag. Default by kind: sphere 0.47, capsule 0.6, box 1.05, cylinder 0.9, cone 0.7, hull 0.9.
    pub drag: Option<f32>,
    /// Reference area A, m². Default: the area of the shape's shadow along the flow, as it turns.
    pub area: Option<f32>,
    /// Lift of spinning bodies: F = C ½ρ A r ω×u, r the shape's radius; so C_L = C r ω/|u|. About 1 for balls.
    /// Default 0.
    pub lift: f32,
    /// r of Stokes' drag 6πηr u, m. Default: radius of the ball of equal volume.
    pub stokes_radius: Option<f32>,
}

impl Aero {
    /// Refuses coefficients out of range.
    ///
    /// # Errors
    /// Names the field.
    pub fn check(&self) -> Result<()> {
        let range = |field, v: Option<f32>, expected| match v {
            Some(v) => check((0.0..=1e6).contains(&v), "aero", field, v, expected),
            None => Ok(()),
        };
        range("drag", self.drag, "0 to 1e6")?;
        range("area", self.area, "0 to 1e6 m²")?;
        range("stokes_radius", self.stokes_radius, "0 to 1e6 m")?;
        check(self.lift.abs() <= 100.0, "aero", "lift", self.lift, "-100 to 100")
    }
}

/// A blast: one impulse on everything near, at once.
///
/// A surface of area A that faces the centre at distance r gets the impulse `impulse` · f(r) · A, f = (1 − r/radius)²,
/// along the line from the centre; what stands behind a wall gets none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explosion {
    /// Centre, m.
    pub center: DVec3,
    /// Reach, m.
    pub radius: f32,
    /// Impulse per exposed area at the centre, N s/m² (Pa s).
    pub impulse: f32,
    /// Fixed bodies shield what is behind them. Default true.
    pub occlusion: bool,
    /// Layers it acts on (bits). Default all.
    pub layers: u32,
}

impl Explosion {
    /// A blast that acts on all layers and is stopped by walls.
    pub fn new(center: impl Into<DVec3>, radius: f32, impulse: f32) -> Self {
        Self { center: center.into(), radius, impulse, occlusion: true, layers: u32::MAX }
    }

    /// Refuses numbers out of range.
    ///
    /// # Errors
    /// Names the field.
    pub fn check(&self) -> Result<()> {
        let p = self.center;
        let ok = p.is_finite() && p.abs().max_component() <= limits::POSITION_MAX;
        check(ok, "explosion", "center", p, "finite, within 1e9 m")?;
        let r = self.radius;
        check(r > 0.0 && r <= 1e5, "explosion", "radius", r, "above 0, at most 1e5 m")?;
        let i = self.impulse;
        check(i.is_finite() && i.abs() <= 1e12, "explosion", "impulse", i, "finite, at most 1e12 N s/m²")
    }
}
