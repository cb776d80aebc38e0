//! Drawing a world's insides with lines, points and text: for games and tools under construction.
//!
//! The engine draws nothing itself. Whoever has a window implements [`DebugDraw`] and gives it to [`World::debug_draw`].

use crate::contact_info::ContactInfo;
use crate::limits;
use crate::query::QueryFilter;
use crate::room::joints::desc::JointKind;
use crate::room::joints::view::JointRef;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::BodyFrame;
use crate::room::vehicles::board::STATIONS;
use crate::room::vehicles::state::{Vehicle, WheelState};
use crate::world::World;
use jounce_geometry::Shape;
use jounce_math::{DVec3, Pose, Quat, Vec3, WorldPose, scalar::f32s};

/// Red, green, blue, 0…255.
pub type DebugColor = [u8; 3];

/// What can draw lines.
pub trait DebugDraw {
    /// A line from `a` to `b`, world.
    fn line(&mut self, a: DVec3, b: DVec3, color: DebugColor);
    /// A point. Default: nothing.
    fn point(&mut self, _at: DVec3, _color: DebugColor) {}
    /// A short text beside a point. Default: nothing.
    fn text(&mut self, _at: DVec3, _text: &str, _color: DebugColor) {}
}

/// What to draw, and of whom.
#[derive(Clone, Copy, Debug)]
pub struct DebugDrawOptions<'a> {
    /// Outlines of shapes. Default true.
    pub shapes: bool,
    /// Tight bounds of shapes. Default false.
    pub bounds: bool,
    /// Contact points and normals. Default true.
    pub contacts: bool,
    /// Contact forces: lines of `force_scale` metres per newton. Default false.
    pub forces: bool,
    /// Length of a newton, metres. Default 0.01.
    pub force_scale: f32,
    /// Joints: from point to point, with the axes of hinges, sliders and wheels, the ropes of pulleys, and paths. Default true.
    pub joints: bool,
    /// Vehicles: wheels where they are, the way of their travel, and what they stand on. With `forces` the force of the ground, too.
    /// Default true.
    pub vehicles: bool,
    /// Centres of mass with the body's axes. Default false.
    pub centers: bool,
    /// Velocities, a metre for a metre per second. Default false.
    pub velocities: bool,
    /// Names of bodies. Default false.
    pub names: bool,
    /// Length of axes and normals, metres. Default 0.25.
    pub size: f32,
    /// Triangles drawn of one mesh or height field, at most. Default 20 000.
    pub triangles_max: usize,
    /// Only shapes whose bounds meet this box. Default all.
    pub region: Option<[DVec3; 2]>,
    /// Only shapes that this filter sees. Default all, sensors too.
    pub filter: QueryFilter<'a>,
}

impl Default for DebugDrawOptions<'_> {
    fn default() -> Self {
        Self {
            shapes: true,
            bounds: false,
            contacts: true,
            forces: false,
            force_scale: 0.01,
            joints: true,
            vehicles: true,
            centers: false,
            velocities: false,
            names: false,
            size: 0.25,
            triangles_max: 20_000,
            region: None,
            filter: QueryFilter { sensors: true, ..QueryFilter::default() },
        }
    }
}

const FIXED: DebugColor = [120, 130, 120];
const KINEMATIC: DebugColor = [90, 130, 230];
const AWAKE: DebugColor = [235, 180, 80];
const ASLEEP: DebugColor = [140, 140, 150];
const SENSOR: DebugColor = [210, 210, 90];
const BOUNDS: DebugColor = [200, 90, 200];
const CONTACT: DebugColor = [230, 60, 60];
const FORCE: DebugColor = [255, 140, 140];
const VELOCITY: DebugColor = [90, 210, 210];
const JOINT: DebugColor = [70, 190, 160];
const WHEEL: DebugColor = [110, 200, 250];
const TRAVEL: DebugColor = [200, 200, 120];
const AXES: [DebugColor; 3] = [[220, 60, 60], [70, 190, 70], [70, 90, 230]];
/// Sides of a drawn circle.
const SIDES: usize = 24;
/// A half-space is drawn as a grid of this many cells to each side of its origin, a metre each.
const GRID: i32 = 10;

impl World {
    /// Draws the world.
    pub fn debug_draw(&self, draw: &mut dyn DebugDraw, options: &DebugDrawOptions<'_>) {
        let everywhere = [DVec3::splat(-limits::POSITION_MAX), DVec3::splat(limits::POSITION_MAX)];
        let [min, max] = options.region.unwrap_or(everywhere);
        let mut bodies = Vec::new();
        for id in self.overlap_aabb(min, max, &options.filter) {
            let Ok(shape) = self.shape(id) else { continue };
            bodies.push(shape.body().index());
            let pose = shape.world_pose();
            if options.shapes {
                let color = self.debug_color(shape.body().index(), shape.is_sensor());
                let mut pen = Pen { draw, pose, color, triangles_max: options.triangles_max };
                pen.shape(shape.shape());
            }
            if options.bounds && !matches!(shape.shape(), Shape::HalfSpace { .. }) {
                let b = shape.shape().aabb(&Pose::new(Vec3::ZERO, pose.q));
                let pose = WorldPose::new(pose.p + b.center().as_dvec3(), Quat::IDENTITY);
                Pen { draw, pose, color: BOUNDS, triangles_max: 0 }.cuboid(b.half());
            }
        }
        bodies.sort_unstable();
        bodies.dedup();
        for slot in bodies {
            self.debug_body(slot, draw, options);
        }
        if options.joints {
            for j in self.joints().filter_map(|id| self.joint(id).ok()) {
                draw_joint(&j, draw, options.size, [min, max]);
            }
        }
        if options.vehicles {
            for (_, v) in self.vehicles.table.iter().filter(|(_, v)| v.enabled) {
                draw_vehicle(v, &self.frames[v.chassis as usize], draw, options, [min, max]);
            }
        }
        if options.contacts || options.forces {
            for c in self.contacts() {
                draw_contact(&c, draw, options, [min, max]);
            }
        }
    }

    fn debug_color(&self, slot: u32, sensor: bool) -> DebugColor {
        let body = &self.bodies[slot];
        match body.kind {
            _ if sensor => SENSOR,
            BodyKind::Fixed => FIXED,
            BodyKind::Kinematic => KINEMATIC,
            BodyKind::Dynamic if self.frames[slot as usize].row == crate::room::rigid::state::NONE => ASLEEP,
            BodyKind::Dynamic => AWAKE,
        }
    }

    fn debug_body(&self, slot: u32, draw: &mut dyn DebugDraw, options: &DebugDrawOptions<'_>) {
        let (body, f) = (&self.bodies[slot], &self.frames[slot as usize]);
        if options.centers {
            draw.point(f.center, AWAKE);
            for (axis, color) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().zip(AXES) {
                let tip = f.rotation.rotate(axis * options.size).as_dvec3();
                draw.line(f.center, f.center + tip, color);
            }
        }
        let v = self.velocities(body).0;
        if options.velocities && v != Vec3::ZERO {
            draw.line(f.center, f.center + v.as_dvec3(), VELOCITY);
        }
        if let Some(name) = body.name.as_deref().filter(|_| options.names) {
            draw.text(f.center, name, self.debug_color(slot, false));
        }
    }
}

/// A joint that acts and has a point in the region.
fn draw_joint(j: &JointRef<'_>, draw: &mut dyn DebugDraw, size: f32, [min, max]: [DVec3; 2]) {
    let [a, b] = j.anchors();
    let inside = |p: DVec3| (0..3).all(|i| min[i] <= p[i] && p[i] <= max[i]);
    if !j.is_enabled() || !(inside(a) || inside(b)) {
        return;
    }
    match j.kind() {
        JointKind::Gear { .. } => return,
        JointKind::Pulley { wheel_a, wheel_b, .. } => {
            draw.line(a, *wheel_a, JOINT);
            draw.line(*wheel_a, *wheel_b, JOINT);
            draw.line(*wheel_b, b, JOINT);
        }
        JointKind::Path(_) => {
            j.curve().windows(2).for_each(|w| draw.line(w[0], w[1], JOINT));
        }
        _ if a != b => draw.line(a, b, JOINT),
        _ => {}
    }
    if matches!(j.kind(), JointKind::Hinge(_) | JointKind::Slider(_) | JointKind::Wheel { .. }) {
        let x = j.frame_a().q.rotate(Vec3::X * size).as_dvec3();
        draw.line(a - x, a + x, JOINT);
    }
    draw.point(a, JOINT);
    draw.point(b, JOINT);
}

/// Wheels and stations of a vehicle whose chassis is in the region.
fn draw_vehicle(
    v: &Vehicle,
    f: &BodyFrame,
    draw: &mut dyn DebugDraw,
    options: &DebugDrawOptions<'_>,
    [min, max]: [DVec3; 2],
) {
    if !(0..3).all(|i| min[i] <= f.center[i] && f.center[i] <= max[i]) {
        return;
    }
    let (pose, up) = (f.pose(), v.desc.up);
    for (d, s) in v.desc.wheels.iter().zip(&v.wheels) {
        let axle = Quat::from_axis_angle(up, s.steer).rotate(up.cross(v.desc.forward));
        let hub = d.position - up * s.s;
        let (x, y) = (axle.cross(up) * d.radius, up * d.radius);
        let mut pen = Pen { draw: &mut *draw, pose, color: WHEEL, triangles_max: 0 };
        for side in [-0.5 * d.width, 0.5 * d.width] {
            pen.arc(hub + axle * side, x, y, SIDES);
        }
        // A spoke, that shows how it turns.
        pen.line(hub, hub + y * f32s::cos(s.angle) - x * f32s::sin(s.angle));
        pen.color = TRAVEL;
        pen.line(d.position + up * d.bump, d.position - up * d.droop);
        draw_stand(s, pose.q.rotate(axle), draw, options);
    }
    let Some(b) = &v.desc.board else { return };
    for ((x, y), s) in STATIONS.into_iter().zip(&v.stations) {
        let left = up.cross(v.desc.forward);
        let at = b.position + v.desc.forward * (0.5 * x * b.length) + left * (0.5 * y * b.width);
        let mut pen = Pen { draw: &mut *draw, pose, color: TRAVEL, triangles_max: 0 };
        pen.line(at + up * b.reach, at - up * b.reach);
        draw_stand(s, pose.q.rotate(left), draw, options);
    }
}

/// Where a wheel or station stands, and what the ground does to it.
fn draw_stand(s: &WheelState, axle: Vec3, draw: &mut dyn DebugDraw, options: &DebugDrawOptions<'_>) {
    let (n, at) = (s.seen.normal, s.seen.point);
    if n == Vec3::ZERO {
        return;
    }
    draw.point(at, CONTACT);
    draw.line(at, at + (n * options.size).as_dvec3(), CONTACT);
    if options.forces {
        let along = axle.cross(n).normalize_or(Vec3::ZERO);
        let [x, y] = s.seen.force;
        let force = n * s.seen.load + along * x + n.cross(along) * y;
        draw.line(at, at + (force * options.force_scale).as_dvec3(), FORCE);
    }
}

fn draw_contact(
    c: &ContactInfo,
    draw: &mut dyn DebugDraw,
    options: &DebugDrawOptions<'_>,
    [min, max]: [DVec3; 2],
) {
    for m in &c.manifolds {
        for p in &m.points {
            let inside = (0..3).all(|i| min[i] <= p.point[i] && p.point[i] <= max[i]);
            if !inside {
                continue;
            }
            if options.contacts {
                draw.point(p.point, CONTACT);
                draw.line(p.point, p.point + (m.normal * options.size).as_dvec3(), CONTACT);
            }
            if options.forces {
                let push = m.normal * (p.normal_force * options.force_scale);
                draw.line(p.point, p.point + push.as_dvec3(), FORCE);
            }
        }
        if let Some(p) = m.points.first().filter(|_| options.forces && m.friction_force != Vec3::ZERO) {
            draw.line(p.point, p.point + (m.friction_force * options.force_scale).as_dvec3(), FORCE);
        }
    }
}

/// Draws lines given in a frame.
struct Pen<'a> {
    draw: &'a mut dyn DebugDraw,
    pose: WorldPose,
    color: DebugColor,
    triangles_max: usize,
}

impl Pen<'_> {
    fn line(&mut self, a: Vec3, b: Vec3) {
        self.draw.line(self.pose.transform_point(a), self.pose.transform_point(b), self.color);
    }

    fn shape(&mut self, shape: &Shape) {
        match shape {
            Shape::Sphere { radius } => {
                for (x, y) in [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X)] {
                    self.arc(Vec3::ZERO, x * *radius, y * *radius, SIDES);
                }
            }
            Shape::Capsule { half_height, radius } => self.capsule(*half_height, *radius),
            Shape::Box { half } => self.cuboid(*half),
            Shape::Cylinder { half_height, radius } => self.frustum(*half_height, *radius, *radius),
            Shape::Cone { half_height, radius } => self.frustum(*half_height, *radius, 0.0),
            Shape::Hull(h) => {
                for f in h.faces() {
                    let corners = h.face_vertices(f);
                    for (i, &a) in corners.iter().enumerate() {
                        let b = corners[(i + 1) % corners.len()];
                        // Each edge has two faces: the one that goes up the indices draws it.
                        if a < b {
                            self.line(h.vertices()[usize::from(a)], h.vertices()[usize::from(b)]);
                        }
                    }
                }
            }
            Shape::HalfSpace { normal, offset } => self.grid(*normal, *offset),
            Shape::Mesh(m) => {
                (0..m.len().min(self.triangles_max)).for_each(|i| self.triangle(m.triangle(i as u32)));
            }
            Shape::HeightField(h) => {
                let n = (h.triangle_count() as usize).min(self.triangles_max);
                (0..n).filter_map(|i| h.triangle(i as u32)).for_each(|t| self.triangle(t));
            }
            Shape::Compound(c) => {
                for (at, child) in c.children() {
                    let (pose, color, triangles_max) =
                        (self.pose.compose(at), self.color, self.triangles_max);
                    Pen { draw: self.draw, pose, color, triangles_max }.shape(child);
                }
            }
        }
    }

    fn triangle(&mut self, t: [Vec3; 3]) {
        for i in 0..3 {
            self.line(t[i], t[(i + 1) % 3]);
        }
    }

    fn cuboid(&mut self, half: Vec3) {
        let corner = |i: usize| {
            let s = |bit: usize, h: f32| if i & bit == 0 { -h } else { h };
            Vec3::new(s(1, half.x), s(2, half.y), s(4, half.z))
        };
        for i in 0..8 {
            for bit in [1, 2, 4] {
                if i & bit == 0 {
                    self.line(corner(i), corner(i | bit));
                }
            }
        }
    }

    /// `sides`/[`SIDES`] of the ellipse c + x cos φ + y sin φ.
    fn arc(&mut self, c: Vec3, x: Vec3, y: Vec3, sides: usize) {
        let at = |i: usize| {
            let phi = i as f32 * (core::f32::consts::TAU / SIDES as f32);
            c + x * f32s::cos(phi) + y * f32s::sin(phi)
        };
        for i in 0..sides {
            self.line(at(i), at(i + 1));
        }
    }

    fn frustum(&mut self, half_height: f32, base: f32, top: f32) {
        for (y, r) in [(-half_height, base), (half_height, top)] {
            if r > 0.0 {
                self.arc(Vec3::Y * y, Vec3::X * r, Vec3::Z * r, SIDES);
            }
        }
        for side in [Vec3::X, Vec3::Z, -Vec3::X, -Vec3::Z] {
            self.line(side * base - Vec3::Y * half_height, side * top + Vec3::Y * half_height);
        }
    }

    fn capsule(&mut self, half_height: f32, radius: f32) {
        self.frustum(half_height, radius, radius);
        for up in [Vec3::Y, -Vec3::Y] {
            for side in [Vec3::X, Vec3::Z] {
                self.arc(up * half_height, side * radius, up * radius, SIDES / 2);
            }
        }
    }

    fn grid(&mut self, normal: Vec3, offset: f32) {
        let (x, y) = normal.orthonormal_basis();
        let (c, r) = (normal * offset, GRID as f32);
        for i in -GRID..=GRID {
            let t = i as f32;
            self.line(c + x * t - y * r, c + x * t + y * r);
            self.line(c + y * t - x * r, c + y * t + x * r);
        }
        self.line(c, c + normal);
    }
}
