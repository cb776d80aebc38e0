//! Mortar: welds between bodies that touch, as strong as the area they share.
//!
//! A joint with the face area A and the tensile strength σ holds the force σ A, and the moment σ A w/6, the bending strength of a
//! square section of the width w = √A (W = w³/6). While it holds, it bears pressure as it bears pull, and breaks by either; the two bodies
//! collide, so that what is pressed rests on its neighbour when it is broken.
//!
//! Source: Timoshenko, Strength of materials, section modulus.

use super::desc::{JointDesc, SpringDesc};
use crate::error::{Error, Result, check};
use crate::handle::{BodyId, JointId};
use crate::limits;
use crate::query::QueryFilter;
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_geometry::{ManifoldSet, PairCache, collide};
use jounce_math::{DVec3, Vec3};
use jounce_tasks::FloatEnv;
use std::collections::BTreeSet;

/// Describes mortar.
#[derive(Clone, Debug, PartialEq)]
pub struct GlueDesc {
    /// Tensile strength σ, Pa: lime mortar 1e5, cement 1e6, wood glue 1e7.
    pub strength: f32,
    /// Widest gap that it fills, m. Default 0.005.
    pub gap: f32,
    /// Smallest area that it holds on, m²; edges and corners that only touch stay loose. Default 1e-4.
    pub area_min: f32,
    /// Yields as a spring instead of holding rigidly.
    pub softness: Option<SpringDesc>,
}

impl GlueDesc {
    /// Mortar of a tensile strength, Pa.
    pub const fn new(strength: f32) -> Self {
        Self { strength, gap: 0.005, area_min: 1e-4, softness: None }
    }
    /// Refuses what no mortar can be. (Softness is checked as joints are added.)
    ///
    /// # Errors
    /// Names the field, its value and what was expected.
    pub fn check(&self) -> Result<()> {
        check(self.strength > 0.0, "glue", "strength", self.strength, "above 0 Pa")?;
        check((0.0..=1e3).contains(&self.gap), "glue", "gap", self.gap, "0 to 1000 m")?;
        check((0.0..=1e12).contains(&self.area_min), "glue", "area_min", self.area_min, "0 to 1e12 m²")
    }
}

/// Where two bodies share a face.
struct Face {
    center: DVec3,
    normal: Vec3,
    area: f32,
}

impl World {
    /// Joins all of these bodies that touch one another face to face, by welds that break: walls, towers, arches, anything that is
    /// to fall apart. Gives the joints, in the order of the bodies.
    ///
    /// ```
    /// use jounce::{GlueDesc, prelude::*};
    ///
    /// # fn main() -> jounce::Result<()> {
    /// let mut world = World::new(WorldDesc::default())?;
    /// let brick = ShapeDesc::cuboid(Vec3::new(0.12, 0.03, 0.06)).density(1800.0);
    /// let mut bricks = Vec::new();
    /// for i in 0..3 {
    ///     bricks.push(world.add_body(BodyDesc::dynamic().at([0.0, 0.03 + 0.06 * f64::from(i), 0.0]).shape(brick.clone()))?);
    /// }
    /// let mortar = world.glue(&bricks, &GlueDesc::new(1e5))?;
    /// assert_eq!(mortar.len(), 2);
    /// // 0.24 m × 0.12 m × 1e5 Pa.
    /// let holds = world.joint(mortar[0])?.desc().break_force;
    /// assert!((holds - 2880.0).abs() < 1.0);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// A stale handle, a number out of range, or too many joints; those made before that stay.
    pub fn glue(&mut self, bodies: &[BodyId], desc: &GlueDesc) -> Result<Vec<JointId>> {
        desc.check()?;
        let mut slots = BTreeSet::new();
        for &b in bodies {
            slots.insert(self.slot(b)?);
        }
        let mut pairs = Vec::new();
        {
            let _mode = FloatEnv::set_default();
            for &a in &slots {
                pairs.extend(self.touching_faces(a, &slots, desc));
                // Bodies that are all in one place touch in as many pairs as the square of their number.
                if pairs.len() > limits::JOINTS_MAX {
                    return Err(Error::Limit { what: "joints", limit: limits::JOINTS_MAX });
                }
            }
        }
        let mut joints = Vec::with_capacity(pairs.len());
        for (a, b, face) in pairs {
            let holds = desc.strength * face.area;
            let mut d = JointDesc::hinge(self.body_id(a), self.body_id(b), face.center, face.normal)
                .kind(super::desc::JointKind::Fixed)
                .collide(true)
                .breaks_at(holds, holds * face.area.sqrt() / 6.0);
            d.softness = desc.softness;
            joints.push(self.add_joint(d)?);
        }
        Ok(joints)
    }

    /// Faces that a body shares with those of a set that have higher slots.
    fn touching_faces(&self, a: u32, of: &BTreeSet<u32>, desc: &GlueDesc) -> Vec<(u32, u32, Face)> {
        let mut found: std::collections::BTreeMap<u32, Face> = std::collections::BTreeMap::new();
        let mut set = ManifoldSet::default();
        for &shape in &self.bodies[a].shapes {
            let bounds = self.tight_bounds(shape).expanded(desc.gap);
            if self.shapes[shape].sensor {
                continue;
            }
            let near =
                self.overlap_aabb(bounds.min.as_dvec3(), bounds.max.as_dvec3(), &QueryFilter::default());
            for other in near {
                let b = self.shapes[other.index].body;
                if b <= a || b == NONE || !of.contains(&b) {
                    continue;
                }
                let (ra, rb) = (&self.shapes[shape], &self.shapes[other.index]);
                let pose = self.frames[a as usize].shape_pose(&ra.pose);
                let b_in_a = pose.relative(&self.frames[b as usize].shape_pose(&rb.pose));
                collide(&ra.shape, &rb.shape, &b_in_a, desc.gap, &mut PairCache::default(), &mut set);
                for m in &set.manifolds {
                    let points: Vec<Vec3> = m.points().iter().map(|p| p.point).collect();
                    let (center, area) = polygon(&points, m.normal);
                    if area < desc.area_min {
                        continue;
                    }
                    let face =
                        Face { center: pose.transform_point(center), normal: pose.q.rotate(m.normal), area };
                    // Of several faces the largest gives the place; the areas add up.
                    match found.get_mut(&b) {
                        Some(f) if f.area >= area => f.area += area,
                        Some(f) => *f = Face { area: f.area + area, ..face },
                        None => {
                            found.insert(b, face);
                        }
                    }
                }
            }
        }
        found.into_iter().map(|(b, f)| (a, b, f)).collect()
    }
}

/// Middle and area of the convex polygon of up to four points, whatever their order, seen along `n`.
fn polygon(points: &[Vec3], n: Vec3) -> (Vec3, f32) {
    if points.is_empty() {
        return (Vec3::ZERO, 0.0);
    }
    let middle = points.iter().fold(Vec3::ZERO, |s, p| s + *p) / points.len() as f32;
    if points.len() < 3 {
        return (middle, 0.0);
    }
    let triangle = |a: Vec3, b: Vec3, c: Vec3| (b - a).cross(c - a).dot(n).abs() * 0.5;
    if points.len() == 3 {
        return (middle, triangle(points[0], points[1], points[2]));
    }
    // Half the cross product of the diagonals is the area; of the three ways to pair four points the right one gives the most.
    let [a, b, c, d] = [points[0], points[1], points[2], points[3]];
    let pairing = |p: Vec3, q: Vec3, r: Vec3, s: Vec3| (q - p).cross(s - r).dot(n).abs() * 0.5;
    let all = [pairing(a, c, b, d), pairing(a, b, c, d), pairing(a, d, b, c)];
    (middle, all.into_iter().fold(0.0, jounce_math::scalar::f32s::max))
}
