//! A world of the engine as something to cast rays at.

use crate::camera::Camera;
use crate::look::{Pattern, Skin, palette, srgb};
use crate::tracer::{Hit, Tracer};
use jounce::geometry::Shape;
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
