//! A blast on bodies, by exposed area.
//!
//! Seen from the centre, a shape lies within the cone that its bounding ball fills. Rays in rings of equal solid angle fill the
//! cone. A ray that meets the shape at the distance r before any wall stands for the solid angle dΩ, so for an exposed area
//! r² dΩ at right angles to the ray, and carries the impulse p f(r) r² dΩ along itself. Sums over the rays give impulse and spin together; what a wall covers gets nothing.

use super::desc::Explosion;
use crate::Ray;
use crate::error::Result;
use crate::query::QueryFilter;
use crate::room::rigid::desc::BodyKind;
use crate::world::World;
use jounce_math::{DVec3, Vec3, WorldPose, scalar::f32s};

/// Rings of rays, and rays in the first of them; ring k has (2k + 1) times as many.
const RINGS: usize = 4;
const RAYS_FIRST: usize = 4;

impl World {
    pub(crate) fn do_explode(&mut self, e: &Explosion) -> Result<()> {
        e.check()?;
        let reach = DVec3::splat(f64::from(e.radius));
        let filter =
            QueryFilter { fixed: false, kinematic: false, layers: e.layers, ..QueryFilter::default() };
        let mut pushes: Vec<(u32, Vec3, Vec3)> = Vec::new();
        for shape in self.overlap_aabb(e.center - reach, e.center + reach, &filter) {
            let record = &self.shapes[shape.index];
            if self.bodies[record.body].kind == BodyKind::Dynamic && record.shape.is_solid() {
                let (j, l) = self.blast_on(shape.index, e);
                if j != Vec3::ZERO || l != Vec3::ZERO {
                    pushes.push((record.body, j, l));
                }
            }
        }
        for (slot, j, l) in pushes {
            // Past the speed that a body may have at the door, the blast gives what it may.
            let body = self.body_id(slot);
            let fastest = j.length() * self.bodies[slot].mass.inv_mass;
            let scale = f32s::min(1.0, 0.5 * crate::limits::SPEED_MAX / f32s::max(fastest, 1e-30));
            if self.do_impulse(body, j * scale, l * scale, None).is_err() {
                self.do_impulse(body, j * scale, Vec3::ZERO, None)?;
            }
        }
        Ok(())
    }

    /// Impulse and angular impulse about the body's centre of mass.
    fn blast_on(&self, slot: u32, e: &Explosion) -> (Vec3, Vec3) {
        let record = &self.shapes[slot];
        let frame = &self.frames[record.body as usize];
        let pose = frame.shape_pose(&record.pose);
        let middle = record.shape.mass_properties(1.0).map_or(Vec3::ZERO, |m| m.center);
        let target = pose.transform_point(middle);
        let radius = record.shape.outer_radius(middle);
        let origin = pose.inverse_transform_point(e.center);
        let lever = (e.center - frame.center).as_vec3();
        let (dir, distance) = match (target - e.center).as_vec3().try_normalize() {
            Some((d, l)) if !record.shape.contains_point(origin) => (d, l),
            inside => {
                // From within: all of it is as near as can be, and goes the way its middle lies.
                let d = inside.map_or(Vec3::Y, |(d, _)| d);
                let area = record.shape.shadow_area(pose.q.inverse_rotate(d));
                return (d * (e.impulse * area), Vec3::ZERO);
            }
        };
        let (u, v) = dir.orthonormal_basis();
        let (mut impulse, mut spin) = (Vec3::ZERO, Vec3::ZERO);
        // Half angle of the cone that the bounding ball fills; from within it, look all around.
        let cos_max = if distance > radius {
            let x = radius / distance;
            (1.0 - x * x).sqrt()
        } else {
            -1.0
        };
        let solid = core::f32::consts::TAU * (1.0 - cos_max) / (RAYS_FIRST * RINGS * RINGS) as f32;
        for ring in 0..RINGS {
            let rays = RAYS_FIRST * (2 * ring + 1);
            // The angle that halves the ring's solid angle.
            let (a, b) = (ring as f32 / RINGS as f32, (ring + 1) as f32 / RINGS as f32);
            let cos = 1.0 - (1.0 - cos_max) * (0.5 * (a * a + b * b));
            let sin = f32s::max(1.0 - cos * cos, 0.0).sqrt();
            for k in 0..rays {
                let angle = core::f32::consts::TAU * (k as f32 + 0.5) / rays as f32;
                let side = u * f32s::cos(angle) + v * f32s::sin(angle);
                let ray = dir * cos + side * sin;
                let Some(r) = self.exposed(slot, e, &pose, origin, ray) else { continue };
                let f = 1.0 - r / e.radius;
                let j = ray * (e.impulse * f * f * r * r * solid);
                impulse += j;
                spin += (lever + ray * r).cross(j);
            }
        }
        (impulse, spin)
    }

    /// Distance along the ray to the shape, if it is in reach and nothing fixed stands before it.
    fn exposed(&self, slot: u32, e: &Explosion, pose: &WorldPose, origin: Vec3, ray: Vec3) -> Option<f32> {
        let hit = self.shapes[slot].shape.ray_cast(origin, pose.q.inverse_rotate(ray), e.radius)?;
        if e.occlusion {
            let walls = QueryFilter { kinematic: false, dynamic: false, ..QueryFilter::default() };
            let mut line = Ray::new(e.center.to_array(), ray.to_array());
            line.max_t = hit.t;
            if self.cast_ray(&line, &walls).is_some() {
                return None;
            }
        }
        Some(hit.t)
    }
}
