//! What fields do to a rigid body in one substep. Equations in [`super`].

use super::desc::FieldLaw;
use super::point::{Medium, Pull};
use super::state::{FieldRecord, FieldView, Fields};
use crate::room::contacts::state::ShapeRecord;
use crate::room::rigid::solve::turn;
use crate::room::rigid::state::InvInertia;
use jounce_geometry::Shape;
use jounce_math::{DVec3, Pose, Quat, Vec3, scalar::f32s};
use jounce_motion::force;

/// What is known of an awake body for the whole step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Feel {
    /// Layers of its shapes, together; 0 for bodies that feel nothing.
    pub layers: u32,
    /// The acceleration that the step started with (and that contacts count with), m/s².
    pub at_start: Vec3,
}

/// A moving body as fields see it.
pub(crate) struct Mover<'a> {
    pub v: Vec3,
    pub w: Vec3,
    /// Centre of mass and rotation now.
    pub center: DVec3,
    pub rotation: Quat,
    pub local_center: Vec3,
    pub inertia: &'a InvInertia,
    /// Distance from the centre of mass to the farthest point, m.
    pub outer_radius: f32,
    /// Gravity at the body: the world's and that of fields, m/s².
    pub gravity: Vec3,
}

/// C_d of a shape at the Reynolds numbers of balls and crates (Morrison 2013, table; Hoerner 1965).
pub(crate) fn drag_coefficient(shape: &Shape) -> f32 {
    match shape {
        Shape::Sphere { .. } => 0.47,
        Shape::Capsule { .. } => 0.6,
        Shape::Box { .. } => 1.05,
        Shape::Cone { .. } => 0.7,
        _ => 0.9,
    }
}

impl Mover<'_> {
    fn velocity_at(&self, r: Vec3) -> Vec3 {
        self.v + self.w.cross(r)
    }
    /// 1/mₑ against a push at the lever r along the unit vector n, and the spin that a unit impulse gives.
    fn response(&self, r: Vec3, n: Vec3) -> (f32, Vec3) {
        let rn = r.cross(n);
        let spin = self.inertia.mul(rn);
        (self.inertia.inv_mass + rn.dot(spin), spin)
    }
    fn push(&mut self, r: Vec3, j: Vec3) {
        self.v += j * self.inertia.inv_mass;
        self.w += self.inertia.mul(r.cross(j));
    }

    /// Drag b|u| + c|u|² against the flow at the lever r.
    fn drag(&mut self, r: Vec3, flow: Vec3, b: f64, c: f64, h: f32) {
        let u = self.velocity_at(r) - flow;
        let Some((n, speed)) = u.try_normalize() else { return };
        let (k, spin) = self.response(r, n);
        if !(k > 0.0 && b + c > 0.0) {
            return;
        }
        let (b, c) = (b * f64::from(k), c * f64::from(k));
        let after = force::implicit_drag(u.as_dvec3(), DVec3::ZERO, b, c, f64::from(h)).length() as f32;
        if spin == Vec3::ZERO {
            // Through the centre: scaled, so that no rounding turns it round.
            self.v = flow + u * (after / speed);
            return;
        }
        let j = (speed - after) / k;
        self.v -= n * (j * self.inertia.inv_mass);
        self.w -= spin * j;
    }

    /// Torque −(b + c|ω|) ω.
    fn spin_drag(&mut self, b: f64, c: f64, h: f32) {
        let Some((n, speed)) = self.w.try_normalize() else { return };
        let spin = self.inertia.mul(n);
        let k = n.dot(spin);
        if !(k > 0.0 && b + c > 0.0) {
            return;
        }
        let (b, c) = (b * f64::from(k), c * f64::from(k));
        let after = force::implicit_drag(self.w.as_dvec3(), DVec3::ZERO, b, c, f64::from(h)).length() as f32;
        self.w -= spin * ((speed - after) / k);
    }

    /// A shape in the open medium; `part` of it is there, the rest is under water.
    fn in_medium(&mut self, s: &ShapeRecord, r: Vec3, q: Quat, m: &Medium, part: f32, h: f32) {
        let u = self.velocity_at(r) - m.flow;
        let (area, cd) = (area_along(s, q, u), s.aero.drag.unwrap_or(drag_coefficient(&s.shape)));
        let radius = s.aero.stokes_radius.unwrap_or(s.ball_radius);
        let part = f64::from(part);
        let b = force::stokes_coefficient(f64::from(m.viscosity), f64::from(radius)) * part;
        let c = force::quadratic_coefficient(f64::from(m.density), f64::from(area), f64::from(cd)) * part;
        self.drag(r, m.flow, b, c, h);
        let (bw, cw) = self.spin_coefficients(s, m, area, cd, part);
        self.spin_drag(bw, cw, h);
        if s.aero.lift != 0.0 {
            // u turns about ω at C ½ρ A r / m; a turn does no work.
            let k = 0.5 * s.aero.lift * m.density * area * s.ball_radius * self.inertia.inv_mass;
            let u = self.v - m.flow;
            self.v = m.flow + turn(self.w * (k * h)).rotate(u);
        }
    }

    /// Torque of a spinning shape in a medium: a ball's 8πηr³, and for all but balls that of a bar turning about its
    /// middle, ¼ (½ρ A C_d) r³ |ω| (strip theory: ∫ ½ρ C_d w (ωx)² x dx).
    fn spin_coefficients(&self, s: &ShapeRecord, m: &Medium, area: f32, cd: f32, part: f64) -> (f64, f64) {
        let r = f64::from(s.ball_radius);
        let b = 8.0 * core::f64::consts::PI * f64::from(m.viscosity) * r * r * r * part;
        if matches!(s.shape, Shape::Sphere { .. }) {
            return (b, 0.0);
        }
        let reach = f64::from(self.outer_radius);
        let c = 0.25 * force::quadratic_coefficient(f64::from(m.density), f64::from(area), f64::from(cd));
        (b, c * reach * reach * reach * part)
    }

    /// Buoyancy and drag of the part of a shape that is under water; gives that part, 0…1.
    fn in_water(&mut self, s: &ShapeRecord, pose: &Pose, water: &FieldRecord, h: f32) -> f32 {
        let FieldLaw::Water { surface, normal, density, viscosity, linear_drag, velocity } = water.desc.law
        else {
            return 0.0;
        };
        // `pose` is about the centre of mass: the surface in the shape's frame.
        let from_center = (surface - self.center).dot(normal.as_dvec3()) - f64::from(pose.p.dot(normal));
        let n = pose.q.as_dquat().normalize().inverse_rotate(normal.as_dvec3());
        let under = s.shape.submerged(n, from_center);
        if under.volume <= 0.0 || s.volume <= 0.0 {
            return 0.0;
        }
        let part = f32s::min(under.volume as f32 / s.volume, 1.0);
        let r = pose.p + pose.q.rotate(under.center.as_vec3());
        let (rho, hf) = (f64::from(density), f64::from(h));
        let lift = force::buoyancy(rho, under.volume, self.gravity.as_dvec3());
        self.push(r, (lift * hf).as_vec3());
        self.calm(r, normal, rho * f64::from(self.gravity.length()) * under.waterplane, h);
        let m = Medium { density, viscosity, flow: velocity };
        let u = self.velocity_at(r) - velocity;
        let (area, cd) = (area_along(s, pose.q, u), s.aero.drag.unwrap_or(drag_coefficient(&s.shape)));
        let radius = f64::from(s.aero.stokes_radius.unwrap_or(s.ball_radius));
        let carried = f64::from(linear_drag) * rho * under.volume;
        let b = force::stokes_coefficient(f64::from(viscosity), radius) * f64::from(part) + carried;
        let c = force::quadratic_coefficient(rho, f64::from(area), f64::from(cd)) * f64::from(part);
        self.drag(r, velocity, b, c, h);
        let (bw, cw) = self.spin_coefficients(s, &m, area, cd, f64::from(part));
        self.spin_drag(bw + 0.4 * carried * radius * radius, cw, h);
        part
    }

    /// The waterplane's spring of stiffness k at the lever r: where a substep is too long for it (h²k/mₑ above 0.1), the
    /// depth is taken implicitly, which damps the motion along the normal.
    fn calm(&mut self, r: Vec3, n: Vec3, stiffness: f64, h: f32) {
        let (k, spin) = self.response(r, n);
        let x = (stiffness * f64::from(h) * f64::from(h)) as f32 * k;
        if x <= 0.1 || k <= 0.0 {
            return;
        }
        let v = n.dot(self.velocity_at(r));
        let j = (v - v / (1.0 + x)) / k;
        self.v -= n * (j * self.inertia.inv_mass);
        self.w -= spin * j;
    }

    /// All that media do to the body's shapes.
    pub fn media<'a>(
        &mut self,
        fields: &Fields,
        shapes: impl Iterator<Item = &'a ShapeRecord>,
        what: Acting,
        h: f32,
    ) {
        for s in shapes.filter(|s| s.enabled && !s.sensor) {
            let layers = s.filter.layers;
            let p = self.rotation.rotate(s.pose.p - self.local_center);
            let pose = Pose::new(p, self.rotation * s.pose.q);
            let at = self.center + p.as_dvec3();
            let mut dry = 1.0;
            if what.water && s.volume > 0.0 {
                for f in fields.acting(layers) {
                    if matches!(f.desc.law, FieldLaw::Water { .. }) && f.desc.region.weight(at) > 0.0 {
                        dry -= self.in_water(s, &pose, f, h);
                    }
                }
            }
            if what.medium && dry > 0.0 {
                let m = fields.medium(at, layers);
                if m.density > 0.0 || m.viscosity > 0.0 {
                    self.in_medium(s, p, pose.q, &m, dry, h);
                }
            }
        }
    }

    /// Accelerations by mass: what has changed since the step began, and Coriolis' turn.
    pub fn pulls(
        &mut self,
        pull: &Pull,
        gravity_scale: f32,
        attraction: Vec3,
        at_start: Vec3,
        scale: f32,
        h: f32,
    ) {
        let now = pull.gravity * gravity_scale + pull.other + attraction;
        // A hook that has no number any more: the next step begins with taking the body out.
        if now.is_finite() {
            self.v += (now - at_start) * (scale * h);
        }
        if pull.spin != Vec3::ZERO {
            self.v = turn(pull.spin * (-2.0 * h)).rotate(self.v);
            // The spin against the stars is ω + Ω; it keeps its direction there, so ω turns back here.
            self.w = turn(pull.spin * -h).rotate(self.w);
        }
    }
}

/// Reference area against a flow, m².
fn area_along(s: &ShapeRecord, q: Quat, u: Vec3) -> f32 {
    if let Some(a) = s.aero.area {
        return a;
    }
    let dir = q.inverse_rotate(u).normalize_or(Vec3::Y);
    s.shape.shadow_area(dir)
}

/// Which kinds of field there are in a world, so that the others cost nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Acting {
    pub pull: bool,
    pub medium: bool,
    pub water: bool,
    pub attraction: bool,
    /// Gusts.
    pub gusts: bool,
}

impl Acting {
    pub fn of(fields: &Fields) -> Self {
        let mut a = Self::default();
        for f in fields.acting(u32::MAX) {
            match f.desc.law {
                FieldLaw::Wind { gust, .. } => {
                    a.medium = true;
                    a.gusts |= gust.is_some_and(|g| g.speed > 0.0);
                }
                FieldLaw::Drag { .. } | FieldLaw::Vortex { .. } => a.medium = true,
                FieldLaw::Water { .. } => a.water = true,
                FieldLaw::NBody { .. } => a.attraction = true,
                _ => a.pull = true,
            }
        }
        a
    }
    pub fn any(self) -> bool {
        self != Self::default()
    }
}

/// May a gust that is not blowing yet move this shape? Then its body must not fall asleep.
pub(crate) fn gust_can_move(fields: &Fields, s: &ShapeRecord, at: DVec3, inv_mass: f32) -> bool {
    /// Slower than a gentle push, m/s².
    const GENTLE: f32 = 0.5;
    let layers = s.filter.layers;
    let m = fields.medium(at, layers);
    let area = core::f32::consts::PI * s.ball_radius * s.ball_radius;
    let cd = s.aero.drag.unwrap_or(drag_coefficient(&s.shape));
    fields.acting(layers).any(|f| match f.desc.law {
        FieldLaw::Wind { velocity, gust: Some(g) } => {
            // Three times the root mean square is near the noise's bound of √3 √3.
            let u = velocity.length() + 3.0 * g.speed;
            let w = f.desc.region.weight(at);
            w > 0.0 && 0.5 * m.density * s.aero.area.unwrap_or(area) * cd * u * u * inv_mass > GENTLE
        }
        _ => false,
    })
}

/// What a field view says of a body.
pub(crate) fn view(
    position: DVec3,
    velocity: Vec3,
    mass: f32,
    time_s: f64,
    body: crate::BodyId,
    user_data: u128,
) -> FieldView {
    FieldView { position, velocity, mass, time_s, body: Some(body), user_data }
}
