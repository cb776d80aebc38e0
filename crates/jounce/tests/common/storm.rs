//! Random worlds and random edits of them, a function of the seed alone.

use super::rng::Rng;
use super::{fields, movers, particles};
use jounce::geometry::{Compound, HeightField, Hull, MassProperties, Shape, TriMesh, TriMeshOptions};
use jounce::math::Mat3;
use jounce::prelude::*;
use jounce::{Command, MassSpec, Output, Settings};
use std::sync::Arc;

/// A random world with the generator that goes on editing it.
#[derive(Clone)]
pub struct Storm {
    pub world: World,
    pub rng: Rng,
    /// Where everything happens.
    pub origin: DVec3,
    /// Half the width of the place.
    pub extent: f32,
    /// A usual size of a shape.
    pub size: f32,
    /// Edits accepted and refused.
    pub edits: [usize; 2],
    /// Called around every call that changes the world.
    pub around: fn(&mut dyn FnMut()),
    /// Draws emitters and edits of them, where there are any.
    pub emitters: Option<Rng>,
    /// Draws fields and edits of them, where there are any.
    pub fields: Option<Rng>,
    /// Draws vehicles and characters, and edits of them, where there are any.
    pub movers: Option<Rng>,
    /// Draws joints and ragdolls, and edits of them, where there are any.
    pub joints: Option<Rng>,
}

impl Storm {
    pub fn new(seed: u64) -> Self {
        let mut rng = Rng::new(seed);
        let size = *rng.pick(&[0.5, 0.5, 0.5, 0.05, 5.0]);
        let far = *rng.pick(&[0.0, 0.0, 0.0, 0.0, 1e4, 1e6, 1e7]);
        let origin = if far == 0.0 { DVec3::ZERO } else { DVec3::new(far, -0.37 * far, 0.71 * far) };
        let world = World::new(world_desc(&mut rng, size)).expect("in range");
        let mut storm = Self {
            world,
            rng,
            origin,
            extent: 4.0 * size,
            size,
            edits: [0, 0],
            around: |f| f(),
            emitters: None,
            fields: None,
            movers: None,
            joints: None,
        };
        storm.hooks();
        for _ in 0..1 + storm.rng.below(2) {
            let ground = storm.ground();
            storm.world.add_body(ground).expect("a ground");
        }
        if !storm.rng.one_in(3) {
            let room = storm.room();
            storm.world.add_body(room).expect("a room");
        }
        for _ in 0..12 + storm.rng.below(28) {
            let b = storm.body();
            storm.world.add_body(b).expect("in range");
        }
        storm
    }

    /// With emitters; their random numbers are their own, so the bodies are those of the same seed without.
    pub fn with_particles(mut self, seed: u64) -> Self {
        self.emitters = Some(Rng::new(seed ^ 0x7a2c));
        for _ in 0..3 {
            particles::edit(&mut self);
        }
        self
    }

    /// With fields, whose random numbers are their own too.
    pub fn with_fields(mut self, seed: u64) -> Self {
        self.fields = Some(Rng::new(seed ^ 0x31f7));
        fields::hooks(&mut self.world);
        for _ in 0..6 {
            fields::edit(&mut self);
        }
        self
    }

    /// With vehicles and characters, whose random numbers are their own too.
    pub fn with_movers(mut self, seed: u64) -> Self {
        self.movers = Some(Rng::new(seed ^ 0x5b1d));
        for _ in 0..24 {
            movers::edit(&mut self);
        }
        self
    }

    /// With joints and ragdolls, whose random numbers are their own too.
    pub fn with_joints(mut self, seed: u64) -> Self {
        self.joints = Some(Rng::new(seed ^ 0x64e9));
        for _ in 0..16 {
            movers::edit_joints(&mut self);
        }
        self
    }

    /// Some edits, then a step.
    pub fn step(&mut self) {
        if self.fields.as_mut().is_some_and(|r| r.one_in(5)) {
            fields::edit(self);
        }
        if self.movers.as_mut().is_some_and(|r| r.one_in(2)) {
            movers::edit(self);
        }
        if self.joints.as_mut().is_some_and(|r| r.one_in(3)) {
            movers::edit_joints(self);
        }
        if self.emitters.as_mut().is_some_and(|r| r.one_in(3)) {
            particles::edit(self);
        }
        if self.rng.one_in(4) {
            for _ in 0..1 + self.rng.below(3) {
                self.edit();
            }
        }
        (self.around)(&mut || self.world.step().expect("steps"));
    }

    /// One edit, at once or queued; refusals are part of it.
    pub fn edit(&mut self) {
        let Some(command) = self.command() else { return };
        let queued = self.rng.one_in(4);
        let mut accepted = true;
        (self.around)(&mut || {
            let command = command.clone();
            accepted = if queued {
                self.world.queue(command).is_ok()
            } else {
                match self.world.apply(command) {
                    Ok(Output::Body(b)) => self.world.body(b).is_ok(),
                    Ok(Output::Shape(s)) => self.world.shape(s).is_ok(),
                    Ok(_) => true,
                    Err(_) => false,
                }
            };
        });
        self.edits[usize::from(!accepted)] += 1;
    }

    /// Questions of every kind; answers must be finite and name live bodies and shapes.
    pub fn query(&mut self) {
        let all = QueryFilter::default();
        for _ in 0..2 {
            let (from, dir, q) = (self.somewhere(), self.rng.vec3(2.0), self.rng.quat());
            let shape = self.convex();
            let pose = WorldPose::new(from, q);
            let near = 2.0 * self.size;
            let (rng, world) = (&mut self.rng, &self.world);
            let live = |b, s| world.body(b).is_ok() && world.shape(s).is_ok_and(|s| s.body() == b);
            let unit = |n: Vec3| (n.length() - 1.0).abs() < 1e-3;
            if let Some(h) = world.cast_ray(&Ray::new(from, dir), &all) {
                let ok = h.t.is_finite() && h.t >= 0.0 && h.point.is_finite() && unit(h.normal);
                assert!(ok && live(h.body, h.shape), "{h:?}");
            }
            if let Some(h) = world.cast_shape(&shape, &pose, dir * self.size, &all) {
                let ok = (0.0..=1.0).contains(&h.t) && h.point.is_finite() && h.normal.is_finite();
                assert!(ok && live(h.body, h.shape), "{h:?} of {shape:?} at {pose:?}");
            }
            if let Some(h) = world.closest_point(from, near, &all) {
                let ok = h.distance <= near && h.point.is_finite() && h.normal.is_finite();
                assert!(ok && live(h.body, h.shape), "{h:?}");
            }
            let found = world.overlap_shape(&shape, &pose, &all);
            assert!(found.iter().all(|&s| world.shape(s).is_ok()));
            let corner = from + rng.vec3(self.size).abs().as_dvec3();
            assert!(world.overlap_aabb(from, corner, &all).iter().all(|&s| world.shape(s).is_ok()));
        }
    }

    fn hooks(&mut self) {
        if self.rng.one_in(8) {
            let hook = |p: &jounce::PairView| (p.user_data[0] ^ p.user_data[1]) & 7 != 7;
            self.world.set_filter_hook(Some(("odd ones out", Arc::new(hook))));
        }
        if self.rng.one_in(8) {
            let hook = |c: &jounce::ContactView, s: &mut jounce::Surface| {
                s.kinetic_friction *= 0.5;
                c.normal.y > -0.9 || c.separation > -0.01
            };
            self.world.set_contact_hook(Some(("one way", Arc::new(hook))));
        }
    }

    pub fn somewhere(&mut self) -> DVec3 {
        let e = self.extent;
        let mut p = self.rng.vec3(e);
        p.y = p.y.abs();
        self.origin + p.as_dvec3()
    }

    fn any_size(&mut self) -> f32 {
        match self.rng.below(12) {
            0 => self.size * self.rng.decades(-2.0, 0.0),
            1 => self.size * self.rng.decades(0.0, 1.0),
            2 => self.rng.decades(-3.0, 0.0),
            _ => self.size * self.rng.float(0.2, 1.0),
        }
    }

    fn convex(&mut self) -> Shape {
        let s = self.any_size();
        match self.rng.below(6) {
            0 => Shape::Sphere { radius: s },
            1 => Shape::Capsule { half_height: s * self.rng.float(0.01, 2.0), radius: s },
            2 => Shape::Box { half: self.stretched(s) },
            3 => Shape::Cylinder { half_height: s * self.rng.float(0.01, 3.0), radius: s },
            4 => Shape::Cone { half_height: s * self.rng.float(0.1, 3.0), radius: s },
            _ => self.hull(s),
        }
    }

    fn stretched(&mut self, s: f32) -> Vec3 {
        let thin = self.rng.one_in(6);
        let f = |r: &mut Rng| s * r.float(0.3, 1.0);
        let (x, y, z) = (f(&mut self.rng), f(&mut self.rng), f(&mut self.rng));
        if thin { Vec3::new(x, 0.01 * y, z) } else { Vec3::new(x, y, z) }
    }

    fn hull(&mut self, s: f32) -> Shape {
        let n = 4 + self.rng.below(30);
        let points: Vec<Vec3> = (0..n).map(|_| self.rng.vec3(s)).collect();
        match Hull::new(&points) {
            Ok(h) => Shape::Hull(Arc::new(h)),
            Err(_) => Shape::Sphere { radius: s },
        }
    }

    fn compound(&mut self) -> Shape {
        let n = 2 + self.rng.below(4);
        let children = (0..n)
            .map(|_| {
                let (p, q) = (self.rng.vec3(self.size), self.rng.quat());
                (Pose::new(p, q), self.convex())
            })
            .collect();
        Shape::Compound(Arc::new(Compound::new(children).expect("convex children")))
    }

    fn mesh(&mut self, half: f32, n: usize) -> Shape {
        let mut vertices = Vec::new();
        let bump = *self.rng.pick(&[0.0, 0.05, 0.3]);
        for j in 0..=n {
            for i in 0..=n {
                let at = |k: usize| half * (2.0 * k as f32 / n as f32 - 1.0);
                vertices.push(Vec3::new(at(i), half * self.rng.float(-bump, bump), at(j)));
            }
        }
        let mut triangles = Vec::new();
        for j in 0..n as u32 {
            for i in 0..n as u32 {
                let w = n as u32 + 1;
                let a = j * w + i;
                triangles.push([a, a + w, a + 1]);
                triangles.push([a + 1, a + w, a + w + 1]);
            }
        }
        let options = TriMeshOptions { double_sided: self.rng.one_in(3), ..Default::default() };
        Shape::Mesh(Arc::new(TriMesh::new(&vertices, &triangles, options).expect("a mesh")))
    }

    fn height_field(&mut self, half: f32, n: usize) -> Shape {
        let step = 2.0 * half / (n - 1) as f32;
        let bump = *self.rng.pick(&[0.0, 0.05, 0.3]) * half;
        let hole = self.rng.below(2 * n * n);
        let heights =
            (0..n * n).map(|i| if i == hole { f32::NAN } else { self.rng.float(-bump, bump) }).collect();
        Shape::HeightField(Arc::new(HeightField::new(n, n, [step, step], heights).expect("a field")))
    }

    /// Four walls and a floor, so that what falls off the ground meets again.
    fn room(&mut self) -> BodyDesc {
        let mut d = BodyDesc::fixed().at(self.origin);
        for normal in [Vec3::Y, Vec3::X, -Vec3::X, Vec3::Z, -Vec3::Z] {
            let shape = Shape::HalfSpace { normal, offset: -1.05 * self.extent };
            let s = self.dressed(shape);
            d.shapes.push(ShapeDesc { sensor: false, enabled: true, filter: Filter::default(), ..s });
        }
        d
    }

    fn ground(&mut self) -> BodyDesc {
        let e = self.extent;
        let kind = if self.rng.one_in(8) { BodyKind::Kinematic } else { BodyKind::Fixed };
        let n = 2 + self.rng.below(10);
        let shape = match self.rng.below(5) {
            0 | 1 => Shape::HalfSpace { normal: Vec3::Y, offset: 0.0 },
            2 => self.mesh(e, n),
            3 => self.height_field(e, n + 1),
            _ => Shape::Box { half: Vec3::new(e, 0.3 * self.size, e) },
        };
        let mut d = BodyDesc::new(kind).at(self.origin).shape(self.dressed(shape));
        if self.rng.one_in(4) {
            let tilt = self.rng.float(-0.4, 0.4);
            d.rotation = Quat::from_axis_angle(Vec3::X, tilt);
        }
        d
    }

    /// A shape with a random surface, mass and filter.
    fn dressed(&mut self, shape: Shape) -> ShapeDesc {
        let r = &mut self.rng;
        let mut d = ShapeDesc::new(shape);
        d.mass = match r.below(8) {
            0 => MassSpec::Density(0.0),
            1 => MassSpec::Mass(r.decades(-3.0, 3.0)),
            2 => MassSpec::Density(r.decades(0.0, 4.0)),
            _ => MassSpec::Density(1000.0),
        };
        d.material = material(r);
        d.sensor = r.one_in(15);
        d.hit_events = r.one_in(3);
        d.contact_events = !r.one_in(4);
        d.enabled = !r.one_in(20);
        if r.one_in(8) {
            d.filter =
                Filter { layers: 1 << r.below(4), mask: r.bits() as u32, group: r.below(5) as i32 - 2 };
        }
        d
    }

    fn moving_shape(&mut self) -> Shape {
        if self.rng.one_in(6) { self.compound() } else { self.convex() }
    }

    pub fn body(&mut self) -> BodyDesc {
        let kind = match self.rng.below(10) {
            0 => BodyKind::Fixed,
            1 => BodyKind::Kinematic,
            _ => BodyKind::Dynamic,
        };
        let mut d = BodyDesc::new(kind).at(self.somewhere()).rotated(self.rng.quat());
        for _ in 0..self.rng.below(12) / 10 + usize::from(!self.rng.one_in(20)) {
            let shape = match kind {
                BodyKind::Kinematic if self.rng.one_in(4) => self.mesh(self.size, 2),
                _ => self.moving_shape(),
            };
            let (p, q) = (self.rng.vec3(0.5 * self.size), self.rng.quat());
            let s = self.dressed(shape);
            d.shapes.push(if self.rng.one_in(3) { s.at(p).rotated(q) } else { s });
        }
        let r = &mut self.rng;
        let speed = if r.one_in(10) { 1000.0 } else { 10.0 } * self.size;
        d.velocity = r.vec3(speed);
        d.angular_velocity = if r.one_in(10) { r.vec3(300.0) } else { r.vec3(5.0) };
        if r.one_in(6) {
            (d.linear_damping, d.angular_damping) = (r.decades(-3.0, 3.0), r.decades(-3.0, 3.0));
        }
        if r.one_in(10) {
            d.gravity_scale = r.float(-2.0, 2.0);
        }
        if r.one_in(8) {
            d.locks = locks(r);
        }
        if r.one_in(12) {
            d.mass = Some(mass(r, self.size));
        }
        d.bullet = r.one_in(6);
        d.fast_rotation = r.one_in(6);
        d.can_sleep = !r.one_in(8);
        d.asleep = r.one_in(12);
        d.enabled = !r.one_in(20);
        d.user_data = u128::from(r.bits());
        d
    }

    fn any_body(&mut self) -> Option<BodyId> {
        let all: Vec<BodyId> = self.world.bodies().collect();
        (!all.is_empty()).then(|| *self.rng.pick(&all))
    }

    fn any_shape(&mut self) -> Option<ShapeId> {
        let all: Vec<ShapeId> = self.world.shapes().collect();
        (!all.is_empty()).then(|| *self.rng.pick(&all))
    }

    fn command(&mut self) -> Option<Command> {
        let which = self.rng.below(34);
        if which < 6 {
            return self.comes_or_goes(which);
        }
        if which >= 27 {
            return self.on_shape(which);
        }
        if which == 6 {
            let g = *self.rng.pick(&[0.0, -9.81, -9.81, -9.81, 3.0, -100.0]);
            return Some(Command::SetGravity(Vec3::new(0.0, g, 0.0)));
        }
        if which == 7 {
            let settings = settings(&mut self.rng, self.world.settings().length_unit);
            return Some(Command::SetSettings(Box::new(settings)));
        }
        self.on_body(which)
    }

    fn comes_or_goes(&mut self, which: usize) -> Option<Command> {
        Some(match which {
            0 | 1 if self.world.counts().bodies < 40 => Command::AddBody(Box::new(self.body())),
            2 => {
                let shape = self.moving_shape();
                let d = self.dressed(shape);
                Command::AddShape(self.any_body()?, Box::new(d))
            }
            3 => Command::RemoveShape(self.any_shape()?),
            _ => Command::RemoveBody(self.any_body()?),
        })
    }

    fn on_body(&mut self, which: usize) -> Option<Command> {
        let b = self.any_body()?;
        let m = self.world.body(b).ok()?.mass();
        let at = self.world.body(b).ok()?.position();
        let near = self.rng.one_in(2).then(|| at + self.rng.vec3(self.size).as_dvec3());
        let place = if self.rng.one_in(2) { self.somewhere() } else { at };
        let r = &mut self.rng;
        Some(match which {
            8 => Command::Teleport(b, place, r.quat()),
            9 | 10 => Command::MoveTo(b, at + r.vec3(0.3 * self.size).as_dvec3(), r.quat()),
            11 => Command::SetVelocity(b, r.vec3(20.0 * self.size)),
            12 => Command::SetAngularVelocity(b, r.vec3(30.0)),
            13 | 14 => Command::AddForce(b, r.vec3(100.0 * m), near),
            15 => Command::AddTorque(b, r.vec3(10.0 * m * self.size)),
            16 => Command::AddImpulse(b, r.vec3(5.0 * m), near),
            17 => Command::AddAngularImpulse(b, r.vec3(m * self.size)),
            18 => Command::SetKind(b, *r.pick(&[BodyKind::Fixed, BodyKind::Kinematic, BodyKind::Dynamic])),
            19 => Command::SetBodyEnabled(b, !r.one_in(2)),
            20 => Command::SetDamping(b, r.decades(-3.0, 2.0), r.decades(-3.0, 2.0)),
            21 => Command::SetGravityScale(b, r.float(-1.0, 2.0)),
            22 => Command::SetLocks(b, locks(r)),
            23 => Command::SetMass(b, r.one_in(2).then(|| mass(r, self.size))),
            24 => Command::SetBullet(b, r.one_in(2)),
            25 => Command::Wake(b),
            _ => Command::Sleep(b),
        })
    }

    fn on_shape(&mut self, which: usize) -> Option<Command> {
        let s = self.any_shape()?;
        Some(match which {
            27 => Command::SetShape(s, Box::new(self.moving_shape())),
            28 => Command::SetShapePose(s, Pose::new(self.rng.vec3(self.size), self.rng.quat())),
            29 | 30 => Command::SetShapeEnabled(s, self.rng.one_in(2)),
            31 => Command::SetMaterial(s, material(&mut self.rng)),
            32 => Command::SetFilter(s, Filter { mask: self.rng.bits() as u32, ..Filter::default() }),
            _ => Command::SetCanSleep(self.any_body()?, self.rng.one_in(2)),
        })
    }
}

fn world_desc(rng: &mut Rng, size: f32) -> WorldDesc {
    let unit = if rng.one_in(3) { 2.0 * size } else { 1.0 };
    WorldDesc {
        gravity: Vec3::new(0.0, *rng.pick(&[-9.81, -9.81, -9.81, 0.0, -50.0]), 0.0),
        rate_hz: *rng.pick(&[60.0, 60.0, 60.0, 30.0, 120.0, 300.0]),
        substeps: *rng.pick(&[4, 4, 4, 1, 2, 8]),
        settings: settings(rng, unit),
    }
}

fn settings(rng: &mut Rng, length_unit: f32) -> Settings {
    Settings {
        length_unit,
        sleep: !rng.one_in(6),
        continuous: !rng.one_in(6),
        warm_starting: !rng.one_in(10),
        recycle_contacts: !rng.one_in(6),
        restitution_speed: *rng.pick(&[1.0, 1.0, 0.0]),
        ..Settings::default()
    }
}

fn material(r: &mut Rng) -> Material {
    let kinetic = *r.pick(&[0.0, 0.3, 0.6, 0.6, 1.0, 10.0]);
    Material {
        static_friction: kinetic + *r.pick(&[0.0, 0.0, 0.2]),
        kinetic_friction: kinetic,
        restitution: *r.pick(&[0.0, 0.0, 0.0, 0.3, 0.8, 1.0]),
        rolling_friction: if r.one_in(5) { r.decades(-3.0, 0.0) } else { 0.0 },
        twist_friction: if r.one_in(5) { r.decades(-3.0, 0.0) } else { 0.0 },
        surface_velocity: if r.one_in(10) { r.vec3(5.0) } else { Vec3::ZERO },
        friction_combine: *r.pick(&[Combine::GeometricMean, Combine::Min, Combine::Max, Combine::Average]),
        restitution_combine: *r.pick(&[Combine::Max, Combine::Multiply, Combine::Average]),
    }
}

fn locks(r: &mut Rng) -> AxisLocks {
    match r.below(4) {
        0 => AxisLocks::PLANE_XY,
        1 => AxisLocks::ROTATION,
        2 => AxisLocks::NONE,
        _ => {
            let b = r.bits();
            AxisLocks {
                linear: [b & 1 > 0, b & 2 > 0, b & 4 > 0],
                angular: [b & 8 > 0, b & 16 > 0, b & 32 > 0],
            }
        }
    }
}

/// Mass ratios up to 1e6, principal moments that a real body could have.
fn mass(r: &mut Rng, size: f32) -> MassProperties {
    let m = r.decades(-3.0, 3.0);
    let (a, b, c) = (r.float(0.05, 1.0), r.float(0.05, 1.0), r.float(0.05, 1.0));
    let d = Vec3::new(b + c, a + c, a + b) * (m * size * size);
    let inertia = Mat3::from_diagonal(d);
    MassProperties { mass: m, center: r.vec3(0.2 * size), inertia }
}
