//! Points and springs of a scene file: the textbook's systems, which feel the world's fields and stay outside of its shapes.
//!
//! They are stepped after the world, by steps of their own. What pushes a cloth is computed once per such step: the flow on
//! every triangle, F = ½ρ A (n·u)|n·u| n with C = 1, a third to each corner.

use crate::bodies::color;
use crate::error::{Checked, Under, Wrong};
use crate::limits;
use crate::plan::SystemValue;
use crate::spec::{ElasticitySpec, MethodSpec, PinSpec, SpringSpec, SystemSpec};
use jounce::math::{DVec3, Vec3};
use jounce::{QueryFilter, StateHasher, World};
use jounce_motion::cloth::{Cloth, ClothDesc};
use jounce_motion::integrate::Method;
use jounce_motion::jelly::{Jelly, JellyDesc};
use jounce_motion::springs::{Elasticity, MassSpring};

/// A system of points and springs in motion.
#[derive(Clone, Debug)]
pub struct System {
    name: String,
    matter: MassSpring,
    /// Corners of the triangles of its skin.
    triangles: Vec<[u32; 3]>,
    start: Vec<DVec3>,
    step_s: f64,
    fields: bool,
    drag: f64,
    /// K_r and K_f.
    collide: Option<(f64, f64)>,
    radius: f32,
    color: [f32; 3],
    show_springs: bool,
    trail_s: Option<f64>,
    failed_at: Option<f64>,
}

impl From<jounce_motion::Error> for Wrong {
    fn from(e: jounce_motion::Error) -> Self {
        match e {
            jounce_motion::Error::BadValue { field, value, expected, .. } => {
                Wrong::new(format!("is {value}"), expected).key(field)
            }
            e => Wrong::new(e.to_string(), ""),
        }
    }
}

pub(crate) fn systems(all: &[SystemSpec], substep: f64) -> Checked<Vec<System>> {
    let mut out: Vec<System> = Vec::with_capacity(all.len());
    let mut points = 0;
    for (i, s) in all.iter().enumerate() {
        let under = |w: Wrong| w.index(i).key("systems");
        points += size(s).map_err(under)?;
        if points > limits::SYSTEM_POINTS_MAX {
            let expected = format!("at most {} points in all systems", limits::SYSTEM_POINTS_MAX);
            return Err(under(Wrong::new(format!("makes {points} points"), expected)));
        }
        let built = system(s, substep).map_err(under)?;
        if out.iter().any(|o| o.name == built.name) {
            let message = format!("\"{}\" is given to two systems", built.name);
            return Err(under(Wrong::new(message, "a name of its own").key("name")));
        }
        out.push(built);
    }
    Ok(out)
}

/// Points that a system will have, before any is made.
fn size(s: &SystemSpec) -> Checked<u64> {
    let given = [s.points.is_some(), s.cloth.is_some(), s.jelly.is_some()];
    if given.iter().filter(|g| **g).count() != 1 {
        return Err(Wrong::new("the system has no clear kind", "exactly one of points, cloth, jelly"));
    }
    if !s.springs.is_empty() && s.points.is_none() {
        return Err(Wrong::new("is given without `points`", "springs only beside points").key("springs"));
    }
    let product = |n: &[u32]| n.iter().fold(1u64, |p, &n| p.saturating_mul(u64::from(n)));
    Ok(match (&s.points, &s.cloth, &s.jelly) {
        (Some(p), ..) => p.len() as u64,
        (_, Some(c), _) => product(&[c.columns, c.rows]),
        (_, _, Some(j)) => product(&j.particles),
        _ => 0,
    })
}

fn system(s: &SystemSpec, substep: f64) -> Checked<System> {
    if s.name.is_empty() {
        return Err(Wrong::new("is empty", "a name").key("name"));
    }
    let method = s.method.map_or(Method::SemiImplicitEuler, method);
    let (matter, triangles) = if let Some(c) = &s.cloth {
        cloth(c, method).key("cloth")?
    } else if let Some(j) = &s.jelly {
        let d = JellyDesc::default();
        let jelly = Jelly::new(&JellyDesc {
            particles: j.particles.map(|n| n as usize),
            center: DVec3::from_array(j.center),
            size: DVec3::from_array(j.size),
            mass: j.mass,
            structural: elasticity(j.structural, d.structural),
            shear: elasticity(j.shear, d.shear),
            bend: elasticity(j.bend, d.bend),
            method,
        });
        let kinds = [("structural", j.structural), ("shear", j.shear), ("bend", j.bend)];
        let jelly = jelly.map_err(|e| placed(e, kinds)).key("jelly")?;
        (jelly.system.clone(), jelly.triangles().to_vec())
    } else {
        (points(s, method)?, Vec::new())
    };
    let step_s = s.step_s.unwrap_or(substep);
    if !(1e-6..=100.0).contains(&step_s) {
        return Err(Wrong::new(format!("is {step_s}"), "1e-6 to 100 s").key("step_s"));
    }
    let radius = s.radius.unwrap_or(0.01);
    if !(1e-6..=1e4).contains(&radius) {
        return Err(Wrong::new(format!("is {radius}"), "1e-6 to 10000 m").key("radius"));
    }
    let part = |v: Option<f64>, otherwise: f64, key: &str| match v.unwrap_or(otherwise) {
        v if (0.0..=1.0).contains(&v) => Ok(v),
        v => Err(Wrong::new(format!("is {v}"), "0 to 1").key(key).key("collide")),
    };
    let collide = match &s.collide {
        Some(c) => Some((part(c.restitution, 0.0, "restitution")?, part(c.friction, 0.1, "friction")?)),
        None => None,
    };
    let drag = s.drag.unwrap_or(0.0);
    if !(0.0..=1e9).contains(&drag) {
        return Err(Wrong::new(format!("is {drag}"), "0 to 1e9 N s/m").key("drag"));
    }
    if s.trail_s.is_some_and(|t| !(0.0..=1e4).contains(&t)) {
        let given = s.trail_s.unwrap_or_default();
        return Err(Wrong::new(format!("is {given}"), "0 to 10000 s").key("trail_s"));
    }
    Ok(System {
        name: s.name.clone(),
        start: matter.positions().to_vec(),
        matter,
        show_springs: s.show_springs.unwrap_or(triangles.is_empty()),
        triangles,
        step_s,
        fields: s.fields.unwrap_or(true),
        drag,
        collide,
        radius,
        color: s.color.as_deref().map(color).transpose().key("color")?.unwrap_or([0.85, 0.3, 0.25]),
        trail_s: s.trail_s,
        failed_at: None,
    })
}

/// The textbook's complaint about a cloth or a jelly, at the key that holds the value.
fn placed(e: jounce_motion::Error, kinds: [(&str, Option<ElasticitySpec>); 3]) -> Wrong {
    let jounce_motion::Error::BadValue { field, value, expected, .. } = &e else { return e.into() };
    let within = |key: &str| Wrong::new(format!("is {value}"), *expected).key(key);
    let bad = |e: &ElasticitySpec| match *field {
        "stiffness" => e.stiffness < 0.0,
        _ => e.damping.is_some_and(|d| d < 0.0),
    };
    match *field {
        "stiffness" | "damping" => {
            let kind = kinds.iter().find(|(_, e)| e.as_ref().is_some_and(bad));
            within(field).key(kind.map_or("structural", |k| k.0))
        }
        "size.x" | "size.y" | "size.z" => {
            let axis = ["size.x", "size.y", "size.z"].iter().position(|f| f == field).unwrap_or(0);
            Wrong::new(format!("is {value}"), *expected).index(axis).key("size")
        }
        _ => e.into(),
    }
}

fn elasticity(e: Option<ElasticitySpec>, otherwise: Option<Elasticity>) -> Option<Elasticity> {
    match e {
        Some(e) => Some(Elasticity { stiffness: e.stiffness, damping: e.damping.unwrap_or(0.0) }),
        None => otherwise,
    }
}

fn cloth(c: &crate::spec::ClothSpec, method: Method) -> Checked<(MassSpring, Vec<[u32; 3]>)> {
    let d = ClothDesc::default();
    let mut cloth = Cloth::new(&ClothDesc {
        columns: c.columns as usize,
        rows: c.rows as usize,
        origin: DVec3::from_array(c.origin),
        across: DVec3::from_array(c.across),
        down: DVec3::from_array(c.down),
        mass: c.mass,
        structural: elasticity(c.structural, d.structural),
        shear: elasticity(c.shear, d.shear),
        bend: elasticity(c.bend, d.bend),
        method,
    })
    .map_err(|e| placed(e, [("structural", c.structural), ("shear", c.shear), ("bend", c.bend)]))?;
    let (w, h) = (cloth.columns(), cloth.rows());
    let pinned: Vec<(usize, usize)> = match c.pin {
        None => Vec::new(),
        Some(PinSpec::FirstColumn) => (0..h).map(|r| (0, r)).collect(),
        Some(PinSpec::FirstRow) => (0..w).map(|c| (c, 0)).collect(),
        Some(PinSpec::TwoCorners) => vec![(0, 0), (w - 1, 0)],
        Some(PinSpec::FourCorners) => vec![(0, 0), (w - 1, 0), (0, h - 1), (w - 1, h - 1)],
    };
    for (column, row) in pinned {
        let index = cloth.index(column, row);
        cloth.system.freeze(index)?;
    }
    Ok((cloth.system.clone(), cloth.triangles().to_vec()))
}

fn points(s: &SystemSpec, method: Method) -> Checked<MassSpring> {
    let mut m = MassSpring::new(method);
    for (i, p) in s.points.iter().flatten().enumerate() {
        let under = |e: jounce_motion::Error| Wrong::from(e).index(i).key("points");
        let at = m.add_point(p.mass.unwrap_or(1.0), DVec3::from_array(p.position)).map_err(under)?;
        m.set_velocity(at, DVec3::from_array(p.velocity.unwrap_or([0.0; 3]))).map_err(under)?;
        if p.frozen == Some(true) {
            m.freeze(at).map_err(under)?;
        }
    }
    for (i, p) in s.springs.iter().enumerate() {
        let ends = p.ends.map(|e| e as usize);
        let e = Elasticity { stiffness: p.stiffness, damping: p.damping.unwrap_or(0.0) };
        let added = match p.length {
            Some(l) => m.add_spring_of_length(ends, e, l),
            None => m.add_spring(ends, e),
        };
        added.map_err(|e| joined(e, p).index(i).key("springs"))?;
    }
    Ok(m)
}

/// The textbook's complaint about a spring, at the key that holds the value.
fn joined(e: jounce_motion::Error, p: &SpringSpec) -> Wrong {
    match &e {
        jounce_motion::Error::NoSuch { index, count, .. } => {
            let end = p.ends.iter().position(|&e| e as usize == *index).unwrap_or(0);
            let expected = format!("a number below {count}: there are so many points");
            Wrong::new(format!("there is no point {index}"), expected).index(end).key("ends")
        }
        jounce_motion::Error::BadValue { field: "rest_length", value, expected, .. } => {
            Wrong::new(format!("is {value}"), *expected).key("length")
        }
        _ => e.into(),
    }
}

fn method(m: MethodSpec) -> Method {
    match m {
        MethodSpec::ExplicitEuler => Method::ExplicitEuler,
        MethodSpec::LectureLoop => Method::LectureLoop,
        MethodSpec::SemiImplicitEuler => Method::SemiImplicitEuler,
        MethodSpec::VelocityVerlet => Method::VelocityVerlet,
        MethodSpec::Midpoint => Method::Midpoint,
        MethodSpec::Rk4 => Method::Rk4,
        MethodSpec::ImplicitEuler => Method::ImplicitEuler,
        MethodSpec::AdaptiveEuler => Method::AdaptiveEuler,
        MethodSpec::Dopri5 => Method::Dopri5,
        MethodSpec::AdaptiveDopri5 => Method::AdaptiveDopri5,
    }
}

/// To look at.
impl System {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Where its points are, m.
    pub fn positions(&self) -> &[DVec3] {
        self.matter.positions()
    }
    /// Which points its springs join, where they are to be drawn.
    pub fn springs(&self) -> &[[u32; 2]] {
        if self.show_springs { self.matter.spring_ends() } else { &[] }
    }
    /// Triangles of its skin.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
    /// Half the width of what is drawn, m.
    pub fn radius(&self) -> f32 {
        self.radius
    }
    /// Colour, sRGB.
    pub fn color(&self) -> [f32; 3] {
        self.color
    }
    /// Length of the trails behind its points, s.
    pub fn trail_s(&self) -> Option<f64> {
        self.trail_s
    }
    /// When its method gave up because its numbers were no longer finite; it stands still since then.
    pub fn failed_at(&self) -> Option<f64> {
        self.failed_at
    }

    pub(crate) fn points(&self) -> usize {
        self.matter.masses().len()
    }

    pub(crate) fn value(&self, v: SystemValue, point: Option<usize>) -> f64 {
        let (x, u) = (self.matter.positions(), self.matter.velocities());
        let energy = || self.matter.energy();
        match (v, point) {
            (SystemValue::Position(k), Some(i)) => x.get(i).map_or(f64::NAN, |p| p.to_array()[k]),
            (SystemValue::Position(k), None) => self.matter.center_of_mass().to_array()[k],
            (SystemValue::Velocity(k), Some(i)) => u.get(i).map_or(f64::NAN, |p| p.to_array()[k]),
            (SystemValue::Velocity(k), None) => {
                let mass: f64 = self.matter.masses().iter().sum();
                self.matter.momentum().to_array()[k] / mass
            }
            (SystemValue::Speed, Some(i)) => u.get(i).map_or(f64::NAN, |p| p.length()),
            (SystemValue::Speed, None) => u.iter().fold(0.0, |m: f64, p| larger(m, p.length())),
            (SystemValue::Distance, Some(i)) => {
                x.get(i).zip(self.start.get(i)).map_or(f64::NAN, |(a, b)| a.distance(*b))
            }
            (SystemValue::Distance, None) => {
                x.iter().zip(&self.start).fold(0.0, |m: f64, (a, b)| larger(m, a.distance(*b)))
            }
            (SystemValue::Radius, Some(i)) => x.get(i).map_or(f64::NAN, |p| p.length()),
            (SystemValue::Radius, None) => x.iter().fold(0.0, |m: f64, p| larger(m, p.length())),
            (SystemValue::KineticEnergy, _) => energy().kinetic,
            (SystemValue::ElasticEnergy, _) => energy().elastic,
            (SystemValue::Energy, _) => energy().kinetic + energy().elastic,
            (SystemValue::Momentum(k), _) => self.matter.momentum().to_array()[k],
            (SystemValue::Lowest, _) => x.iter().fold(f64::INFINITY, |m, p| if p.y < m { p.y } else { m }),
        }
    }

    pub(crate) fn hash(&self, h: &mut StateHasher) {
        for (x, v) in self.matter.positions().iter().zip(self.matter.velocities()) {
            h.dvec3(*x);
            h.dvec3(*v);
        }
    }
}

fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// In motion.
impl System {
    /// Catches up with the world's time.
    pub(crate) fn advance(&mut self, world: &World) {
        let end = world.time() + 1e-9 * self.step_s;
        while self.failed_at.is_none() && self.matter.time() + self.step_s <= end {
            self.push_by_flow(world);
            let (collide, radius, fields) = (self.collide, self.radius, self.fields);
            let gravity = world.gravity().as_dvec3();
            let all = u32::MAX;
            let field = |x: DVec3, v: DVec3, _: f64| match fields {
                true => gravity + world.sample_fields(x, v.as_vec3(), all).acceleration.as_dvec3(),
                false => DVec3::ZERO,
            };
            let stepped = self.matter.step_with(self.step_s, field, |_, x, v| {
                if let Some((k_r, k_f)) = collide {
                    keep_outside(world, x, v, f64::from(radius), k_r, k_f);
                }
            });
            if stepped.is_err() {
                self.failed_at = Some(world.time());
            }
        }
    }

    /// Forces of the flow: on the triangles of a skin, and on points by their drag.
    fn push_by_flow(&mut self, world: &World) {
        if !self.fields {
            return;
        }
        let (x, v) = (self.matter.positions().to_vec(), self.matter.velocities().to_vec());
        let flow = |at: DVec3| {
            let s = world.sample_fields(at, Vec3::ZERO, u32::MAX);
            (s.flow.as_dvec3(), f64::from(s.density))
        };
        let mut forces = vec![DVec3::ZERO; x.len()];
        if world.fields().next().is_some() {
            for t in &self.triangles {
                let [a, b, c] = t.map(|i| i as usize);
                let (wind, density) = flow((x[a] + x[b] + x[c]) / 3.0);
                let twice_area = (x[b] - x[a]).cross(x[c] - x[a]);
                let Some((n, area2)) = twice_area.try_normalize() else { continue };
                let u = n.dot(wind - (v[a] + v[b] + v[c]) / 3.0);
                let third = n * (0.5 * density * 0.5 * area2 * u * u.abs() / 3.0);
                for i in [a, b, c] {
                    forces[i] += third;
                }
            }
        }
        if self.drag > 0.0 {
            for i in 0..x.len() {
                forces[i] += (flow(x[i]).0 - v[i]) * self.drag;
            }
        }
        for (i, f) in forces.into_iter().enumerate() {
            // A force that is not finite belongs to a system that is about to fail.
            if f != DVec3::ZERO && self.matter.add_force(i, f).is_err() {
                self.failed_at = Some(world.time());
            }
        }
    }
}

/// X back to the surface, V_b = (1 − K_f) V_t − K_r V_n against the surface's own velocity.
fn keep_outside(world: &World, x: &mut DVec3, v: &mut DVec3, radius: f64, k_r: f64, k_f: f64) {
    let Some(hit) = world.closest_point(*x, radius as f32, &QueryFilter::default()) else { return };
    let (n, depth) = (hit.normal.as_dvec3(), radius - f64::from(hit.distance));
    if depth <= 0.0 {
        return;
    }
    *x += n * depth;
    let surface = world.body(hit.body).map_or(DVec3::ZERO, |b| {
        (b.velocity() + b.angular_velocity().cross((hit.point - b.center_of_mass()).as_vec3())).as_dvec3()
    });
    let u = *v - surface;
    let normal = n * n.dot(u);
    if n.dot(u) < 0.0 {
        *v = surface + (u - normal) * (1.0 - k_f) - normal * k_r;
    }
}
