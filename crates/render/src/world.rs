//! A world of the engine as something to cast rays at.

use crate::camera::Camera;
use crate::look::{Pattern, Skin, palette, srgb};
use crate::overlay::Overlay;
use crate::tracer::{Hit, Tracer};
use jounce::geometry::Shape;
use jounce::math::scalar::f32s;
use jounce::math::{DVec3, Pose, Vec3, WorldPose};
use jounce::{BodyKind, QueryFilter, Ray, ShapeId, World};

/// A world with the colours of its shapes.
pub struct Stage<'a> {
    world: &'a World,
    /// By slot of the shape.
    surfaces: Vec<Surface>,
}

#[derive(Clone, Copy)]
struct Surface {
    skin: Skin,
    pose: WorldPose,
}

/// Chooses the look of a shape; `None` takes [`default_skin`].
pub type Paint<'a> = dyn Fn(&World, ShapeId) -> Option<Skin> + 'a;

impl<'a> Stage<'a> {
    /// A world as it is now, in the default colours.
    pub fn new(world: &'a World) -> Self {
        Self::painted(world, &|_, _| None)
    }

    /// A world as it is now, in colours of the caller's choice.
    pub fn painted(world: &'a World, paint: &Paint<'_>) -> Self {
        let nothing = Surface { skin: ground(), pose: WorldPose::IDENTITY };
        let mut surfaces = Vec::new();
        for id in world.shapes() {
            let Ok(shape) = world.shape(id) else { continue };
            let slot = id.index() as usize;
            if surfaces.len() <= slot {
                surfaces.resize(slot + 1, nothing);
            }
            let skin = paint(world, id).unwrap_or_else(|| default_skin(world, id));
            surfaces[slot] = Surface { skin, pose: shape.world_pose() };
        }
        Self { world, surfaces }
    }

    /// A camera that sees what moves, and the ground below it; what is fixed, where nothing moves.
    pub fn camera(world: &World, aspect: f32) -> Camera {
        let moving = corners(world, true);
        let points = if moving.is_empty() { corners(world, false) } else { moving };
        Camera::framing(&points, aspect)
    }
}

/// How many bodies the framing looks at; the rest of a larger crowd is taken to be among them.
const FRAMED_MAX: usize = 4000;

/// Corners of the shapes' boxes, and where they would fall.
fn corners(world: &World, moving: bool) -> Vec<DVec3> {
    let mut points = Vec::new();
    let stride = world.shapes().count() / FRAMED_MAX + 1;
    for id in world.shapes().step_by(stride) {
        let Ok(shape) = world.shape(id) else { continue };
        let Ok(body) = world.body(shape.body()) else { continue };
        if (body.kind() != BodyKind::Fixed) != moving || shape.is_sensor() {
            continue;
        }
        let pose = shape.world_pose();
        let b = shape.shape().aabb(&Pose { p: Vec3::ZERO, q: pose.q });
        // Planes and the like say nothing about where to look.
        if (b.max - b.min).max_component() > 1e4 {
            continue;
        }
        for i in 0..8 {
            let pick = |bit: usize, lo: f32, hi: f32| if i & bit == 0 { lo } else { hi };
            let x = pick(1, b.min.x, b.max.x);
            let corner = Vec3::new(x, pick(2, b.min.y, b.max.y), pick(4, b.min.z, b.max.z));
            points.push(pose.p + corner.as_dvec3());
        }
        if let Some((dir, _)) = world.gravity().try_normalize() {
            let filter = QueryFilter { dynamic: false, kinematic: false, ..QueryFilter::default() };
            let ray = Ray { origin: pose.p, dir, max_t: 100.0 };
            points.extend(world.cast_ray(&ray, &filter).map(|hit| hit.point));
        }
    }
    points
}

fn ground() -> Skin {
    Skin { color: srgb(0xB9BDC4), pattern: Pattern::Grid, gloss: 0.12 }
}

/// Fixed shapes are grey with a grid, kinematic ones dark, dynamic ones take colours in turn by their slot.
pub fn default_skin(world: &World, id: ShapeId) -> Skin {
    let Ok(shape) = world.shape(id) else { return ground() };
    let Ok(body) = world.body(shape.body()) else { return ground() };
    let pattern = match shape.shape() {
        Shape::Sphere { radius } => Pattern::Ball(*radius),
        Shape::Box { half } => Pattern::Frame(*half),
        Shape::Capsule { .. } | Shape::Cylinder { .. } | Shape::Cone { .. } => Pattern::Stripes,
        _ => Pattern::Plain,
    };
    match body.kind() {
        BodyKind::Fixed => ground(),
        BodyKind::Kinematic => Skin { color: srgb(0x4A5568), pattern, gloss: 0.6 },
        BodyKind::Dynamic => {
            // Mixed, so that rows of equal things do not fall into stripes.
            let mixed = shape.body().index().wrapping_mul(0x9E37_79B1) >> 16;
            Skin { color: palette(mixed), pattern, gloss: 0.8 }
        }
    }
}

impl Tracer for Stage<'_> {
    fn trace(&self, origin: DVec3, dir: Vec3, max_t: f32) -> Option<Hit> {
        let hit = self.world.cast_ray(&Ray { origin, dir, max_t }, &QueryFilter::default())?;
        // A compound's or mesh's parts share a surface: its normals tell them apart.
        Some(Hit { t: hit.t, normal: hit.normal, surface: hit.shape.index() })
    }
    fn skin(&self, surface: u32) -> Skin {
        self.surfaces.get(surface as usize).map_or_else(ground, |s| s.skin)
    }
    fn to_local(&self, surface: u32, point: DVec3) -> Vec3 {
        self.surfaces.get(surface as usize).map_or(Vec3::ZERO, |s| s.pose.inverse_transform_point(point))
    }
}

/// Draws a world's contacts: a dot at each point and a line along the normal, `longest` metres where the force is
/// the largest, shorter by the square root elsewhere.
pub fn contact_overlay(world: &World, overlay: &mut Overlay, longest: f32) {
    const COLOR: [u8; 3] = [214, 30, 70];
    let contacts = world.contacts();
    let manifolds = || contacts.iter().flat_map(|c| &c.manifolds);
    let points = || manifolds().flat_map(|m| m.points.iter().map(|p| (m.normal, p)));
    let most = points().fold(1e-9_f32, |most, (_, p)| f32s::max(most, p.normal_force));
    for (normal, p) in points().filter(|(_, p)| p.normal_force > 0.0) {
        let length = longest * (p.normal_force / most).sqrt();
        overlay.point(p.point, COLOR);
        overlay.line(p.point, p.point + (normal * length).as_dvec3(), COLOR);
    }
}

/// Draws the boxes around a world's sensors as lines.
pub fn sensor_overlay(world: &World, overlay: &mut Overlay) {
    for id in world.shapes() {
        let Ok(shape) = world.shape(id) else { continue };
        let b = shape.shape().aabb(&Pose::IDENTITY);
        if !shape.is_sensor() || (b.max - b.min).max_component() > 1e4 {
            continue;
        }
        let pose = shape.world_pose();
        let corner = |i: usize| {
            let pick = |bit: usize, lo: f32, hi: f32| if i & bit == 0 { lo } else { hi };
            let x = pick(1, b.min.x, b.max.x);
            pose.transform_point(Vec3::new(x, pick(2, b.min.y, b.max.y), pick(4, b.min.z, b.max.z)))
        };
        for i in 0..8 {
            for bit in [1, 2, 4] {
                if i & bit == 0 {
                    overlay.line(corner(i), corner(i | bit), [40, 150, 110]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RenderOptions, render};
    use jounce::{BodyDesc, ShapeDesc, WorldDesc};

    fn world() -> World {
        let mut w = World::new(WorldDesc::default()).expect("defaults");
        w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).expect("ground");
        w.add_body(BodyDesc::dynamic().at([0.0, 0.5, 0.0]).shape(ShapeDesc::cuboid([0.5; 3]))).expect("box");
        let gate = ShapeDesc::cuboid([1.0; 3]).sensor();
        w.add_body(BodyDesc::fixed().at([0.0, 1.0, 0.0]).shape(gate)).expect("gate");
        w
    }

    #[test]
    fn contacts_and_sensors_become_lines() {
        let mut w = world();
        for _ in 0..10 {
            w.step().expect("step");
        }
        let mut overlay = Overlay::default();
        contact_overlay(&w, &mut overlay, 0.5);
        assert_eq!((overlay.points.len(), overlay.lines.len()), (4, 4));
        for l in &overlay.lines {
            let length = (l.b - l.a).length();
            assert!(length > 0.3 && length < 0.501, "four corners carry about the same: {length}");
        }
        sensor_overlay(&w, &mut overlay);
        assert_eq!(overlay.lines.len(), 4 + 12);
    }

    #[test]
    fn far_worlds_look_the_same() {
        let small = RenderOptions { width: 96, height: 54, threads: 1, ..RenderOptions::default() };
        let picture = |shift: f64| {
            let mut w = World::new(WorldDesc::default()).expect("defaults");
            // A plane of its own body: its origin moves along, so that all but the grid is the same.
            w.add_body(BodyDesc::fixed().at([shift, 0.0, 0.0]).shape(ShapeDesc::cuboid([8.0, 0.1, 8.0])))
                .expect("ground");
            w.add_body(BodyDesc::dynamic().at([shift, 0.6, 0.0]).shape(ShapeDesc::cuboid([0.5; 3])))
                .expect("box");
            let camera = Stage::camera(&w, 96.0 / 54.0);
            render(&Stage::new(&w), &camera, &Overlay::default(), &small).expect("picture")
        };
        let (near, far) = (picture(0.0), picture(1e6));
        let differ = near.pixels().iter().zip(far.pixels());
        let differ = differ.filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > 24)).count();
        assert!(differ < 96 * 54 / 50, "{differ} pixels differ a million metres away");
    }
}
