//! What users write about particles.

use crate::error::{Error, Result, check};
use crate::room::contacts::desc::Filter;
use crate::{BodyId, limits};
use jounce_geometry::TriMesh;
use jounce_math::{DVec3, Quat, Vec3, WorldPose, scalar::f32s};
use std::sync::Arc;

/// A source of particles: where they are born, how they move, what ends them, how they look.
///
/// ```
/// use jounce::prelude::*;
///
/// # fn main() -> jounce::Result<()> {
/// let mut world = World::new(WorldDesc::default())?;
/// let fountain = world.add_emitter(EmitterDesc::new().rate(100.0).speed(4.0, 5.0).spread(0.2).lifetime(1.0, 2.0))?;
/// for _ in 0..60 {
///     world.step()?;
/// }
/// assert_eq!(world.emitter(fountain)?.born(), 100);
/// assert!(world.particles().all(|p| p.age < p.lifetime));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct EmitterDesc {
    /// Where in the emitter's frame particles are born. Default a point.
    pub shape: EmitterShape,
    /// The emitter's frame: in the world, or on [`EmitterDesc::body`] in the body's frame. Default the origin.
    pub pose: WorldPose,
    /// A body that carries the emitter. Its particles do not collide with it. When it is removed, emission ends.
    pub body: Option<BodyId>,
    /// Part of the body's velocity at the place of birth that a particle gets. Default 1.
    pub inherit_velocity: f32,
    /// Which way particles start. Default along the frame's y axis.
    pub direction: EmitDirection,
    /// Half angle of the cone around the direction in which they start, evenly over its solid angle, rad: 0…π. Default 0.
    pub spread: f32,
    /// Speed at birth, lowest and highest, m/s. Default 1, 1.
    pub speed: [f32; 2],
    /// Particles per second, born at their exact times within a step: the k-th at k/rate. Default 0.
    pub rate: f64,
    /// Many at once. At most [`limits::BURSTS_MAX`].
    pub bursts: Vec<Burst>,
    /// Time before the first particle, s. Default 0.
    pub delay_s: f64,
    /// How long particles are born, s. Default without end.
    pub duration_s: Option<f64>,
    /// Begins again when the duration is over: bursts recur, the rate goes on. Default false.
    pub looping: bool,
    /// Lifetime, shortest and longest, s. Default 1, 1.
    pub lifetime_s: [f32; 2],
    /// Mass of a particle, kg. Default 0.001.
    pub mass: f32,
    /// Radius in collisions, drag and buoyancy, smallest and largest, m. Default 0.01, 0.01.
    pub radius: [f32; 2],
    /// Factor on what is drawn, over the part of the lifetime that has passed: the radius that collides stays.
    pub size_over_life: Curve,
    /// Red, green, blue, opacity over the part of the lifetime that has passed.
    pub color_over_life: Gradient,
    /// Factor on the world's gravity. Default 1.
    pub gravity_scale: f32,
    /// Drag at a rate, whatever the medium: dv/dt = −k (v − flow), 1/s. Default 0.
    pub linear_drag: f32,
    /// C_d of quadratic drag in the medium of the world's fields (Stokes' drag comes with it). Default 0.47, a ball's.
    pub drag_coefficient: f32,
    /// Irregular flow that drag pulls the particles along with. Needs some drag. Default none.
    pub turbulence: Option<Turbulence>,
    /// Hot particles rise. Default none.
    pub heat: Option<Heat>,
    /// How particles meet shapes. Default not at all.
    pub collision: Option<ParticleCollision>,
    /// Particles below this y die, m.
    pub kill_below: Option<f64>,
    /// Particles outside of this box (lowest and highest corner, world) die, m.
    pub kill_outside: Option<[DVec3; 2]>,
    /// Particles for which the hook of this name says so die: [`crate::World::set_particle_hook`].
    pub kill_hook: Option<String>,
    /// Layers it is on (bits) for fields and blasts. Default 1.
    pub layers: u32,
    /// Most particles at a time; what would be born beyond is left out and told. Default 100 000.
    pub max_particles: usize,
    /// Which of the many random showers. The emitter's handle counts too, so equal emitters differ.
    pub seed: u64,
    /// Bears particles at all. Default true.
    pub enabled: bool,
    /// Goes away by itself when it has ended and its last particle has died. Default false.
    pub auto_remove: bool,
    /// For people and files.
    pub name: Option<String>,
}

/// Where particles are born, in the emitter's frame.
#[derive(Clone, Debug, Default)]
pub enum EmitterShape {
    /// The origin.
    #[default]
    Point,
    /// A ball around the origin, evenly by volume or by surface.
    Sphere {
        /// Radius, m.
        radius: f32,
        /// On the surface only.
        surface: bool,
    },
    /// A disc in the x–z plane, evenly by area.
    Disc {
        /// Radius, m.
        radius: f32,
    },
    /// A nozzle: a disc in the x–z plane from which particles fly along the lines of a cone about +y, those from the rim
    /// at the half angle. Sets the direction.
    Cone {
        /// Half angle at the tip, rad: 0…π/2.
        half_angle: f32,
        /// Radius of the nozzle, m; 0 for a tip, from which particles fly evenly over the solid angle.
        radius: f32,
    },
    /// A box around the origin, evenly by volume.
    Box {
        /// Half extents, m.
        half: Vec3,
    },
    /// The surface of a mesh, evenly by area.
    Mesh(Arc<TriMesh>),
}

/// Which way particles start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EmitDirection {
    /// Along a unit vector of the emitter's frame.
    Along(Vec3),
    /// Away from the shape: radially from balls, discs and boxes, along the normals of a mesh, from a point any way.
    Outward,
}

/// Many particles at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Burst {
    /// When, s after the delay (of each round, when looping).
    pub time_s: f64,
    /// How many.
    pub count: u32,
}

/// Irregular flow, smooth in space and time and free of divergence: the curl of a random potential.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turbulence {
    /// Root mean square of the flow's speed, m/s.
    pub speed: f32,
    /// Size of an eddy, m.
    pub size: f32,
    /// Time in which an eddy changes into another, s.
    pub time_s: f32,
    /// Which of the many flows; emitters with the same numbers share one.
    pub seed: u64,
}

/// Hot particles rise and cool: a = −g ΔT/T, ΔT = `excess` · e^(−age/`cooling_s`).
///
/// That is Boussinesq's approximation (density differences count in the weight only) with β = 1/T of an ideal gas, and
/// Newton's law of cooling. Boussinesq 1903, *Théorie analytique de la chaleur* II; Tritton, *Physical Fluid Dynamics*, §14.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heat {
    /// Temperature above the surroundings at birth, K; negative sinks.
    pub excess: f32,
    /// Temperature T of the surroundings, K. 293 is a room's.
    pub ambient: f32,
    /// Time in which the excess falls to 1/e, s.
    pub cooling_s: f32,
}

/// How particles meet shapes. Velocities are relative to the surface:
/// V_b = (1 − K_f) V_t − K_r V_n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleCollision {
    /// K_r, 0…1: 1 bounces without loss.
    pub restitution: f32,
    /// K_f, 0…1: part of the tangential velocity lost in a bounce. A particle that stays on a surface counts as one that
    /// bounces 60 times a second.
    pub friction: f32,
    /// What a hit does.
    pub response: HitResponse,
    /// Which shapes are met.
    pub filter: Filter,
    /// Hits push dynamic bodies: the momentum that a particle loses they gain, and they wake.
    pub push: bool,
    /// Hits are reported as [`crate::Event::ParticleHit`], at most [`limits::PARTICLE_HIT_EVENTS_MAX`] a step in all.
    pub hit_events: bool,
    /// Factor on the radius that collides, above 0, at most 1.
    pub radius_scale: f32,
}

/// What a hit does to a particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HitResponse {
    /// It bounces.
    #[default]
    Bounce,
    /// It stays where it hit and moves with the shape; a shape that goes away lets it go.
    Stick,
    /// It dies.
    Kill,
}

impl Default for ParticleCollision {
    fn default() -> Self {
        Self {
            restitution: 0.3,
            friction: 0.1,
            response: HitResponse::Bounce,
            filter: Filter::default(),
            push: false,
            hit_events: false,
            radius_scale: 1.0,
        }
    }
}

/// One particle made by the caller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleSpawn {
    /// Position in the world, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: Vec3,
    /// Lifetime, s.
    pub lifetime_s: f32,
    /// Mass, kg.
    pub mass: f32,
    /// Radius, m.
    pub radius: f32,
}

/// A number over a lifetime: straight lines between keys (time 0…1, value), constant beyond the ends; 1 without keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// The keys, in order of time; at most [`limits::CURVE_KEYS_MAX`].
    pub keys: Vec<(f32, f32)>,
}

/// A colour over a lifetime: straight lines between keys (time 0…1, [red, green, blue, opacity]), constant beyond the
/// ends; white without keys. Components are linear light; above 1 they glow.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gradient {
    /// The keys, in order of time; at most [`limits::CURVE_KEYS_MAX`].
    pub keys: Vec<(f32, [f32; 4])>,
}

impl Curve {
    /// From keys.
    pub fn new(keys: impl Into<Vec<(f32, f32)>>) -> Self {
        Self { keys: keys.into() }
    }
    /// The value at a time.
    pub fn at(&self, time: f32) -> f32 {
        between(&self.keys, time, 1.0, |a, b, t| a + (b - a) * t)
    }
    fn check(&self, field: &'static str) -> Result<()> {
        check_keys(field, self.keys.iter().map(|k| k.0))?;
        for &(_, v) in &self.keys {
            check((0.0..=1e4).contains(&v), "emitter", field, v, "values of 0 to 10000")?;
        }
        Ok(())
    }
}

impl Gradient {
    /// From keys.
    pub fn new(keys: impl Into<Vec<(f32, [f32; 4])>>) -> Self {
        Self { keys: keys.into() }
    }
    /// The colour at a time.
    pub fn at(&self, time: f32) -> [f32; 4] {
        between(&self.keys, time, [1.0; 4], |a, b, t| core::array::from_fn(|i| a[i] + (b[i] - a[i]) * t))
    }
    fn check(&self, field: &'static str) -> Result<()> {
        check_keys(field, self.keys.iter().map(|k| k.0))?;
        for &(_, c) in &self.keys {
            let ok = c.iter().all(|v| (0.0..=1e4).contains(v));
            check(ok, "emitter", field, c, "components of 0 to 10000")?;
        }
        Ok(())
    }
}

fn between<T: Copy>(keys: &[(f32, T)], time: f32, none: T, mix: impl Fn(T, T, f32) -> T) -> T {
    let after = keys.partition_point(|k| k.0 <= time);
    match (after.checked_sub(1).and_then(|i| keys.get(i)), keys.get(after)) {
        (None, None) => none,
        (None, Some(k)) | (Some(k), None) => k.1,
        // The later key is strictly later: the earlier one is the last at or before `time`.
        (Some(a), Some(b)) => mix(a.1, b.1, f32s::clamp((time - a.0) / (b.0 - a.0), 0.0, 1.0)),
    }
}

fn check_keys(field: &'static str, times: impl Iterator<Item = f32> + Clone) -> Result<()> {
    let n = times.clone().count();
    check(n <= limits::CURVE_KEYS_MAX, "emitter", field, n, "at most 8 keys")?;
    let mut last = 0.0;
    for t in times {
        check(t >= last && t <= 1.0, "emitter", field, t, "times of 0 to 1, in order")?;
        last = t;
    }
    Ok(())
}

impl Default for EmitterDesc {
    fn default() -> Self {
        Self {
            shape: EmitterShape::Point,
            pose: WorldPose::IDENTITY,
            body: None,
            inherit_velocity: 1.0,
            direction: EmitDirection::Along(Vec3::Y),
            spread: 0.0,
            speed: [1.0, 1.0],
            rate: 0.0,
            bursts: Vec::new(),
            delay_s: 0.0,
            duration_s: None,
            looping: false,
            lifetime_s: [1.0, 1.0],
            mass: 1e-3,
            radius: [0.01, 0.01],
            size_over_life: Curve::default(),
            color_over_life: Gradient::default(),
            gravity_scale: 1.0,
            linear_drag: 0.0,
            drag_coefficient: 0.47,
            turbulence: None,
            heat: None,
            collision: None,
            kill_below: None,
            kill_outside: None,
            kill_hook: None,
            layers: 1,
            max_particles: 100_000,
            seed: 0,
            enabled: true,
            auto_remove: false,
            name: None,
        }
    }
}

/// Building a description step by step.
impl EmitterDesc {
    /// A point at the origin that bears nothing yet.
    pub fn new() -> Self {
        Self::default()
    }
    /// Sets the position, m.
    pub fn at(mut self, position: impl Into<DVec3>) -> Self {
        self.pose.p = position.into();
        self
    }
    /// Sets the rotation.
    pub fn rotated(mut self, rotation: Quat) -> Self {
        self.pose.q = rotation;
        self
    }
    /// Puts it on a body; the pose is in the body's frame.
    pub fn on(mut self, body: BodyId) -> Self {
        self.body = Some(body);
        self
    }
    /// Sets where particles are born.
    pub fn shape(mut self, shape: EmitterShape) -> Self {
        self.shape = shape;
        self
    }
    /// Sets which way they start.
    pub fn direction(mut self, direction: EmitDirection) -> Self {
        self.direction = direction;
        self
    }
    /// Sets the half angle of the cone around the direction, rad.
    pub fn spread(mut self, half_angle: f32) -> Self {
        self.spread = half_angle;
        self
    }
    /// Sets the speed at birth, m/s.
    pub fn speed(mut self, lowest: f32, highest: f32) -> Self {
        self.speed = [lowest, highest];
        self
    }
    /// Sets how many are born, 1/s.
    pub fn rate(mut self, rate: f64) -> Self {
        self.rate = rate;
        self
    }
    /// Adds a burst.
    pub fn burst(mut self, time_s: f64, count: u32) -> Self {
        self.bursts.push(Burst { time_s, count });
        self
    }
    /// Sets when it begins and how long it goes on, s.
    pub fn timing(mut self, delay_s: f64, duration_s: f64) -> Self {
        (self.delay_s, self.duration_s) = (delay_s, Some(duration_s));
        self
    }
    /// Sets the lifetime, s.
    pub fn lifetime(mut self, shortest: f32, longest: f32) -> Self {
        self.lifetime_s = [shortest, longest];
        self
    }
    /// Sets mass, kg, and radius, m.
    pub fn body_of_each(mut self, mass: f32, radius: f32) -> Self {
        (self.mass, self.radius) = (mass, [radius, radius]);
        self
    }
    /// Sets the rate of linear drag, 1/s.
    pub fn linear_drag(mut self, rate: f32) -> Self {
        self.linear_drag = rate;
        self
    }
    /// Sets the factor on gravity.
    pub fn gravity_scale(mut self, scale: f32) -> Self {
        self.gravity_scale = scale;
        self
    }
    /// Sets the irregular flow.
    pub fn turbulence(mut self, turbulence: Turbulence) -> Self {
        self.turbulence = Some(turbulence);
        self
    }
    /// Sets how particles meet shapes.
    pub fn collision(mut self, collision: ParticleCollision) -> Self {
        self.collision = Some(collision);
        self
    }
    /// Sets the most particles at a time.
    pub fn max_particles(mut self, n: usize) -> Self {
        self.max_particles = n;
        self
    }
    /// Sets the seed.
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }
    /// Sets colour over life.
    pub fn colors(mut self, keys: impl Into<Vec<(f32, [f32; 4])>>) -> Self {
        self.color_over_life = Gradient::new(keys);
        self
    }
    /// Sets size over life.
    pub fn sizes(mut self, keys: impl Into<Vec<(f32, f32)>>) -> Self {
        self.size_over_life = Curve::new(keys);
        self
    }
}

/// Checks.
impl EmitterDesc {
    /// Refuses numbers that no emitter can have.
    ///
    /// # Errors
    /// Names the field.
    pub fn check(&self) -> Result<()> {
        let len = self.name.as_ref().map_or(0, String::len);
        check(len <= limits::NAME_MAX, "emitter", "name", len, "at most 256 bytes")?;
        point("position", self.pose.p)?;
        let q = self.pose.q;
        let ok = q.is_finite() && (q.length() - 1.0).abs() < 1e-2;
        check(ok, "emitter", "rotation", q, "a unit quaternion")?;
        self.shape.check()?;
        self.check_births()?;
        self.check_matter()?;
        self.check_ends()
    }

    fn check_births(&self) -> Result<()> {
        if let EmitDirection::Along(d) = self.direction {
            check((d.length() - 1.0).abs() < 1e-3, "emitter", "direction", d, "a unit vector")?;
        }
        range("inherit_velocity", self.inherit_velocity, -10.0, 10.0, "-10 to 10")?;
        range("spread", self.spread, 0.0, core::f32::consts::PI, "0 to π rad")?;
        pair("speed", self.speed, 0.0, 1e4, "0 to 10000 m/s, lowest first")?;
        let rate = self.rate;
        let ok = (0.0..=limits::EMITTER_RATE_MAX).contains(&rate);
        check(ok, "emitter", "rate", rate, "0 to 1e7 particles a second")?;
        let n = self.bursts.len();
        check(n <= limits::BURSTS_MAX, "emitter", "bursts", n, "at most 16")?;
        for b in &self.bursts {
            check((0.0..=1e9).contains(&b.time_s), "emitter", "burst.time_s", b.time_s, "0 to 1e9 s")?;
        }
        check((0.0..=1e9).contains(&self.delay_s), "emitter", "delay_s", self.delay_s, "0 to 1e9 s")?;
        if let Some(d) = self.duration_s {
            check((0.01..=1e9).contains(&d), "emitter", "duration_s", d, "0.01 to 1e9 s")?;
        }
        let ok = !self.looping || self.duration_s.is_some();
        check(ok, "emitter", "looping", self.looping, "a duration_s to begin again after")?;
        let n = self.max_particles;
        let ok = (1..=limits::PARTICLES_MAX).contains(&n);
        check(ok, "emitter", "max_particles", n, "1 to 4194304")
    }

    fn check_matter(&self) -> Result<()> {
        pair("lifetime_s", self.lifetime_s, 1e-3, 1e6, "0.001 to 1e6 s, shortest first")?;
        range("mass", self.mass, limits::MASS_MIN, limits::PARTICLE_MASS_MAX, "1e-12 to 1e6 kg")?;
        pair("radius", self.radius, 1e-6, 1e3, "1e-6 to 1000 m, smallest first")?;
        self.size_over_life.check("size_over_life")?;
        self.color_over_life.check("color_over_life")?;
        range("gravity_scale", self.gravity_scale, -1e3, 1e3, "-1000 to 1000")?;
        range("linear_drag", self.linear_drag, 0.0, 1e6, "0 to 1e6 1/s")?;
        range("drag_coefficient", self.drag_coefficient, 0.0, 1e6, "0 to 1e6")?;
        if let Some(t) = &self.turbulence {
            range("turbulence.speed", t.speed, 0.0, 1e4, "0 to 10000 m/s")?;
            range("turbulence.size", t.size, 1e-3, 1e6, "0.001 to 1e6 m")?;
            range("turbulence.time_s", t.time_s, 1e-3, 1e6, "0.001 to 1e6 s")?;
            if self.linear_drag == 0.0 && self.drag_coefficient == 0.0 {
                return Err(Error::Unsupported {
                    what: "emitter: turbulence without drag",
                    advice: "it is a flow that drag pulls particles along with: set linear_drag (1/s)",
                });
            }
        }
        if let Some(h) = &self.heat {
            range("heat.excess", h.excess, -1e5, 1e5, "-100000 to 100000 K")?;
            range("heat.ambient", h.ambient, 1.0, 1e5, "1 to 100000 K")?;
            range("heat.cooling_s", h.cooling_s, 1e-3, 1e9, "0.001 to 1e9 s")?;
        }
        Ok(())
    }

    fn check_ends(&self) -> Result<()> {
        if let Some(c) = &self.collision {
            range("collision.restitution", c.restitution, 0.0, 1.0, "0 to 1")?;
            range("collision.friction", c.friction, 0.0, 1.0, "0 to 1")?;
            let ok = c.radius_scale > 0.0 && c.radius_scale <= 1.0;
            check(ok, "emitter", "collision.radius_scale", c.radius_scale, "above 0, at most 1")?;
        }
        if let Some(y) = self.kill_below {
            check(y.abs() <= limits::POSITION_MAX, "emitter", "kill_below", y, "-1e9 to 1e9 m")?;
        }
        if let Some([lo, hi]) = self.kill_outside {
            point("kill_outside", lo)?;
            point("kill_outside", hi)?;
            let ordered = lo.x < hi.x && lo.y < hi.y && lo.z < hi.z;
            check(ordered, "emitter", "kill_outside", [lo, hi], "the lowest corner first")?;
        }
        let len = self.kill_hook.as_ref().map_or(1, String::len);
        check((1..=limits::NAME_MAX).contains(&len), "emitter", "kill_hook", len, "1 to 256 bytes")
    }
}

impl EmitterShape {
    fn check(&self) -> Result<()> {
        let size = |field, v, lo| range(field, v, lo, 1e6, "a length of at most 1e6 m");
        match self {
            Self::Point | Self::Mesh(_) => Ok(()),
            Self::Sphere { radius, .. } => size("radius of the sphere", *radius, 0.0),
            Self::Disc { radius } => size("radius of the disc", *radius, 0.0),
            Self::Cone { half_angle, radius } => {
                range("half_angle of the cone", *half_angle, 0.0, 1.570_797, "0 to π/2 rad")?;
                size("radius of the cone", *radius, 0.0)
            }
            Self::Box { half } => {
                half.to_array().into_iter().try_for_each(|v| size("half of the box", v, 0.0))
            }
        }
    }
}

impl ParticleSpawn {
    pub(crate) fn check(&self) -> Result<()> {
        point("position of a particle", self.position)?;
        let v = self.velocity;
        let ok = v.is_finite() && v.abs().max_component() <= limits::SPEED_MAX;
        check(ok, "emitter", "velocity of a particle", v, "finite, at most 1e5 m/s")?;
        range("lifetime_s of a particle", self.lifetime_s, 1e-3, 1e6, "0.001 to 1e6 s")?;
        range(
            "mass of a particle",
            self.mass,
            limits::MASS_MIN,
            limits::PARTICLE_MASS_MAX,
            "1e-12 to 1e6 kg",
        )?;
        range("radius of a particle", self.radius, 1e-6, 1e3, "1e-6 to 1000 m")
    }
}

fn point(field: &'static str, p: DVec3) -> Result<()> {
    let ok = p.is_finite() && p.abs().max_component() <= limits::POSITION_MAX;
    check(ok, "emitter", field, p, "finite, within 1e9 m")
}

fn range(field: &'static str, v: f32, lo: f32, hi: f32, expected: &'static str) -> Result<()> {
    check(v >= lo && v <= hi, "emitter", field, v, expected)
}

fn pair(field: &'static str, v: [f32; 2], lo: f32, hi: f32, expected: &'static str) -> Result<()> {
    check(v[0] >= lo && v[0] <= v[1] && v[1] <= hi, "emitter", field, v, expected)
}
