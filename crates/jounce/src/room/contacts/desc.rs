//! What users write about surfaces: materials, filters, shapes on bodies.

use crate::error::{Error, Result, check};
use crate::limits;
use crate::room::fields::desc::Aero;
use crate::room::rigid::desc::BodyKind;
use jounce_geometry::{Shape, TriMesh};
use jounce_math::{Pose, Quat, Vec3, scalar::f32s};
use std::sync::Arc;

/// How the coefficients of two surfaces become one. When the two surfaces ask for different rules, the later in
/// this list wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Combine {
    /// √(a b).
    GeometricMean = 0,
    /// (a + b)/2.
    Average = 1,
    /// Smaller.
    Min = 2,
    /// a b.
    Multiply = 3,
    /// Larger.
    Max = 4,
}

impl Combine {
    /// Combines two coefficients.
    pub fn apply(self, a: f32, b: f32) -> f32 {
        match self {
            Self::GeometricMean => (a * b).sqrt(),
            Self::Average => 0.5 * (a + b),
            Self::Min => f32s::min(a, b),
            Self::Multiply => a * b,
            Self::Max => f32s::max(a, b),
        }
    }
    /// The rule for two surfaces that each ask for one.
    pub fn of(a: Self, b: Self) -> Self {
        if a > b { a } else { b }
    }
}

/// Surface of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Coulomb coefficient that holds a resting contact: |F_t| ≤ μ_s N. Default 0.6.
    pub static_friction: f32,
    /// Coulomb coefficient of a sliding contact: |F_t| = μ_k N. Default 0.6; not above the static one.
    pub kinetic_friction: f32,
    /// Speed after ÷ speed before a bounce, 0…1. Default 0.
    pub restitution: f32,
    /// Rolling friction as a length: |torque against rolling| ≤ c N, metres. Default 0.
    pub rolling_friction: f32,
    /// Friction against spinning on the spot, as an effective patch radius: |torque about the normal| ≤ μ c N,
    /// metres, on top of what the spread of the contact points gives. Default 0.
    pub twist_friction: f32,
    /// Velocity of the surface in the shape's frame (a conveyor), m/s. Contacts with one never sleep.
    pub surface_velocity: Vec3,
    /// How friction combines. Default geometric mean.
    pub friction_combine: Combine,
    /// How restitution combines. Default larger.
    pub restitution_combine: Combine,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            static_friction: 0.6,
            kinetic_friction: 0.6,
            restitution: 0.0,
            rolling_friction: 0.0,
            twist_friction: 0.0,
            surface_velocity: Vec3::ZERO,
            friction_combine: Combine::GeometricMean,
            restitution_combine: Combine::Max,
        }
    }
}

impl Material {
    /// Refuses coefficients out of range.
    ///
    /// # Errors
    /// Names the field.
    pub fn check(&self) -> Result<()> {
        let range =
            |field, v: f32, hi: f32, expected| check(v >= 0.0 && v <= hi, "material", field, v, expected);
        range("static_friction", self.static_friction, 1e4, "0 to 10000")?;
        range("kinetic_friction", self.kinetic_friction, 1e4, "0 to 10000")?;
        let (s, k) = (self.static_friction, self.kinetic_friction);
        check(k <= s, "material", "kinetic_friction", k, "not above static_friction")?;
        range("restitution", self.restitution, 1.0, "0 to 1")?;
        range("rolling_friction", self.rolling_friction, 1e4, "0 to 10000 m")?;
        range("twist_friction", self.twist_friction, 1e4, "0 to 10000 m")?;
        let v = self.surface_velocity;
        let ok = v.is_finite() && v.abs().max_component() <= limits::SPEED_MAX;
        check(ok, "material", "surface_velocity", v, "finite, at most 1e5 m/s")
    }
}

/// Which shapes may meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filter {
    /// Layers this shape is on (bits). Default 1.
    pub layers: u32,
    /// Layers it meets (bits). Two shapes meet when each is on a layer that the other meets. Default all.
    pub mask: u32,
    /// Two shapes of the same positive group always meet, of the same negative group never. Default 0.
    pub group: i32,
}

impl Default for Filter {
    fn default() -> Self {
        Self { layers: 1, mask: u32::MAX, group: 0 }
    }
}

impl Filter {
    /// May shapes with these filters meet?
    pub fn allows(&self, o: &Self) -> bool {
        if self.group != 0 && self.group == o.group {
            return self.group > 0;
        }
        self.mask & o.layers != 0 && o.mask & self.layers != 0
    }
}

/// Where a shape's mass comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MassSpec {
    /// kg/m³.
    Density(f32),
    /// kg.
    Mass(f32),
}

/// Describes a shape on a body.
#[derive(Clone, Debug)]
pub struct ShapeDesc {
    /// Geometry.
    pub shape: Shape,
    /// Pose in the body's frame.
    pub pose: Pose,
    /// Density or mass. Default 1000 kg/m³.
    pub mass: MassSpec,
    /// Surface.
    pub material: Material,
    /// Surfaces by the material index of a mesh's triangles; index 0 past the end is `material`.
    pub triangle_materials: Vec<Material>,
    /// Reports who is inside, touches nobody.
    pub sensor: bool,
    /// Whom it meets.
    pub filter: Filter,
    /// Takes part.
    pub enabled: bool,
    /// Reports contact begin and end. Default true.
    pub contact_events: bool,
    /// Reports hits. Default false.
    pub hit_events: bool,
    /// Drag and lift in the media that fields bring.
    pub aero: Aero,
    /// Free for the caller.
    pub user_data: u128,
}

impl ShapeDesc {
    /// A shape with default surface at the body's origin.
    pub fn new(shape: Shape) -> Self {
        Self {
            shape,
            pose: Pose::IDENTITY,
            mass: MassSpec::Density(1000.0),
            material: Material::default(),
            triangle_materials: Vec::new(),
            sensor: false,
            filter: Filter::default(),
            enabled: true,
            contact_events: true,
            hit_events: false,
            aero: Aero::default(),
            user_data: 0,
        }
    }
    /// A ball.
    pub fn sphere(radius: f32) -> Self {
        Self::new(Shape::Sphere { radius })
    }
    /// A box by half extents.
    pub fn cuboid(half: impl Into<Vec3>) -> Self {
        Self::new(Shape::Box { half: half.into() })
    }
    /// A capsule along y.
    pub fn capsule(half_height: f32, radius: f32) -> Self {
        Self::new(Shape::Capsule { half_height, radius })
    }
    /// A cylinder along y.
    pub fn cylinder(half_height: f32, radius: f32) -> Self {
        Self::new(Shape::Cylinder { half_height, radius })
    }
    /// A cone along y.
    pub fn cone(half_height: f32, radius: f32) -> Self {
        Self::new(Shape::Cone { half_height, radius })
    }
    /// Everything below a plane through the body's origin.
    pub fn half_space(normal: impl Into<Vec3>) -> Self {
        Self::new(Shape::HalfSpace { normal: normal.into().normalize_or(Vec3::ZERO), offset: 0.0 })
    }
    /// A triangle mesh.
    pub fn mesh(mesh: Arc<TriMesh>) -> Self {
        Self::new(Shape::Mesh(mesh))
    }
    /// Sets the position in the body's frame.
    pub fn at(mut self, p: impl Into<Vec3>) -> Self {
        self.pose.p = p.into();
        self
    }
    /// Sets the rotation in the body's frame.
    pub fn rotated(mut self, q: Quat) -> Self {
        self.pose.q = q;
        self
    }
    /// Sets the density, kg/m³.
    pub fn density(mut self, density: f32) -> Self {
        self.mass = MassSpec::Density(density);
        self
    }
    /// Sets the mass, kg.
    pub fn mass(mut self, mass: f32) -> Self {
        self.mass = MassSpec::Mass(mass);
        self
    }
    /// Sets the surface.
    pub fn material(mut self, material: Material) -> Self {
        self.material = material;
        self
    }
    /// Sets static and kinetic friction to the same value.
    pub fn friction(mut self, friction: f32) -> Self {
        (self.material.static_friction, self.material.kinetic_friction) = (friction, friction);
        self
    }
    /// Sets restitution.
    pub fn restitution(mut self, restitution: f32) -> Self {
        self.material.restitution = restitution;
        self
    }
    /// Makes it a sensor.
    pub fn sensor(mut self) -> Self {
        self.sensor = true;
        self
    }
    /// Sets whom it meets.
    pub fn filter(mut self, filter: Filter) -> Self {
        self.filter = filter;
        self
    }
    /// Sets drag and lift in the media that fields bring.
    pub fn aero(mut self, aero: Aero) -> Self {
        self.aero = aero;
        self
    }
    /// Reports hits.
    pub fn hit_events(mut self, on: bool) -> Self {
        self.hit_events = on;
        self
    }

    /// Refuses what no shape can be.
    ///
    /// # Errors
    /// Names the field.
    pub fn check(&self) -> Result<()> {
        self.shape.check()?;
        let ok = self.pose.is_finite() && self.pose.p.abs().max_component() <= 1e6;
        check(ok, "shape", "position", self.pose, "finite, within 1e6 m of the body")?;
        let l = self.pose.q.length();
        check(l > 1e-6 && l < 1e6, "shape", "rotation", self.pose.q, "a quaternion that is not zero")?;
        match self.mass {
            MassSpec::Density(d) => {
                check((0.0..=1e12).contains(&d), "shape", "density", d, "0 to 1e12 kg/m³")?
            }
            MassSpec::Mass(m) => {
                check((0.0..=limits::MASS_MAX).contains(&m), "shape", "mass", m, "0 to 1e15 kg")?
            }
        }
        self.aero.check()?;
        self.material.check()?;
        self.triangle_materials.iter().try_for_each(Material::check)
    }

    pub(crate) fn check_on(&self, kind: BodyKind) -> Result<()> {
        self.check()?;
        let moving = kind == BodyKind::Dynamic && !self.sensor;
        match &self.shape {
            Shape::Mesh(_) | Shape::HeightField(_) if moving => Err(Error::Unsupported {
                what: "a triangle mesh or height field on a dynamic body",
                advice: "use its convex hull, or a compound of convex parts (scene files offer \"decompose\")",
            }),
            Shape::HalfSpace { .. } if kind == BodyKind::Dynamic => Err(Error::Unsupported {
                what: "a half-space on a dynamic body",
                advice: "put it on a fixed or kinematic body",
            }),
            _ => Ok(()),
        }
    }
}
