//! Several convex shapes as one.
//!
//! Mass properties add up by the parallel axis theorem: I = Σ Rᵢ Iᵢ Rᵢᵀ + mᵢ (|dᵢ|² 1 − dᵢ dᵢᵀ), dᵢ from the common
//! centre to the child's.

use super::{Hit, MassProperties, PointHit};
use crate::{Aabb, Bvh, GeometryError, Shape, limits};
use jounce_math::{DMat3, DVec3, Pose, Vec3, scalar::f32s};

/// Convex children at fixed poses, with a tree over them.
#[derive(Clone, Debug)]
pub struct Compound {
    pub(crate) children: Vec<(Pose, Shape)>,
    /// Bounds of the children in the compound's frame; the data is the child's index.
    pub(crate) tree: Bvh,
    pub(crate) aabb: Aabb,
}

impl Compound {
    /// From children, all convex.
    ///
    /// # Errors
    /// No children, too many, one that is not convex or fails [`Shape::check`], or a pose that is not finite or
    /// not a rotation.
    pub fn new(children: Vec<(Pose, Shape)>) -> Result<Self, GeometryError> {
        let max = limits::COMPOUND_CHILDREN_MAX;
        if children.is_empty() || children.len() > max {
            return Err(GeometryError::BadCount {
                shape: "compound",
                what: "number of children",
                count: children.len(),
                expected: format!("1 to {max}"),
            });
        }
        for (index, (pose, shape)) in children.iter().enumerate() {
            check_child(index, pose, shape)?;
        }
        let items: Vec<(Aabb, u32)> =
            children.iter().zip(0u32..).map(|((pose, shape), i)| (shape.aabb(pose), i)).collect();
        let aabb = items.iter().fold(Aabb::EMPTY, |b, (c, _)| b.union(c));
        Ok(Self { children, tree: Bvh::build(&items), aabb })
    }
    /// The children.
    pub fn children(&self) -> &[(Pose, Shape)] {
        &self.children
    }
    /// Bounds in the compound's frame.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }
    pub(super) fn aabb_at(&self, pose: &Pose) -> Aabb {
        self.children.iter().fold(Aabb::EMPTY, |b, (p, s)| b.union(&s.aabb(&pose.compose(p))))
    }
    pub(super) fn mass(&self, density: f32) -> MassProperties {
        let parts: Vec<(f64, DVec3, DMat3)> = self
            .children
            .iter()
            .filter_map(|(pose, shape)| {
                // At density 1: the centre must not depend on the density, not even where that is 0.
                let m = shape.mass_properties(1.0)?;
                let r = pose.q.as_dquat().normalize().to_mat3();
                let center = pose.p.as_dvec3() + r * m.center.as_dvec3();
                Some((f64::from(m.mass), center, r * m.inertia.as_dmat3() * r.transpose()))
            })
            .collect();
        let mass: f64 = parts.iter().map(|p| p.0).sum();
        let moment = parts.iter().fold(DVec3::ZERO, |s, p| s + p.1 * p.0);
        let center = if mass > 0.0 { moment * (1.0 / mass) } else { DVec3::ZERO };
        let inertia = parts.iter().fold(DMat3::ZERO, |s, &(m, c, i)| {
            let d = c - center;
            let steiner = DMat3::from_diagonal(DVec3::splat(d.length_squared())) - DMat3::outer(d, d);
            s + i + steiner.scale(m)
        });
        let rho = f64::from(density);
        MassProperties::from_f64(mass * rho, center, inertia.scale(rho))
    }
    pub(super) fn inner_radius(&self) -> f32 {
        self.children.iter().fold(f32::MAX, |m, (_, s)| f32s::min(s.inner_radius(), m))
    }
    pub(super) fn outer_radius(&self, center: Vec3) -> f32 {
        self.children
            .iter()
            .fold(0.0, |m, (p, s)| f32s::max(s.outer_radius(p.inverse_transform_point(center)), m))
    }
    pub(super) fn ray(&self, origin: Vec3, dir: Vec3, max_t: f32) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.tree.ray(origin, dir, Vec3::ZERO, max_t, |i, bound| {
            let Some((pose, shape)) = self.children.get(i as usize) else { return bound };
            let (o, d) = (pose.inverse_transform_point(origin), pose.q.inverse_rotate(dir));
            let Some(h) = shape.ray_unit(o, d, bound) else { return bound };
            let hit = Hit { t: h.t, normal: pose.q.rotate(h.normal), sub: i };
            if best.is_none_or(|b| hit.is_before(&b)) {
                best = Some(hit);
            }
            hit.t
        });
        best
    }
    pub(super) fn closest(&self, point: Vec3) -> Option<PointHit> {
        let mut best: Option<PointHit> = None;
        self.tree.nearest(point, f32::INFINITY, |i, bound| {
            let Some((pose, shape)) = self.children.get(i as usize) else { return bound };
            let Some(h) = shape.closest_point(pose.inverse_transform_point(point)) else { return bound };
            if best.is_none_or(|b| h.distance < b.distance || (h.distance == b.distance && i < b.sub)) {
                best = Some(PointHit {
                    point: pose.transform_point(h.point),
                    distance: h.distance,
                    normal: pose.q.rotate(h.normal),
                    sub: i,
                });
            }
            // Inside one child only boxes that hold the point can be deeper.
            let d = f32s::max(h.distance, 0.0);
            f32s::min(d * d, bound)
        });
        best
    }
}

fn check_child(index: usize, pose: &Pose, shape: &Shape) -> Result<(), GeometryError> {
    let unsupported = |what| Err(GeometryError::Unsupported { shape: "compound", what });
    match shape {
        Shape::Compound(_) => {
            return unsupported(
                "a child is itself a compound; give its children directly, with composed poses",
            );
        }
        Shape::HalfSpace { .. } | Shape::Mesh(_) | Shape::HeightField(_) => {
            return unsupported(
                "a child is not convex; give half-spaces, meshes and height fields a body of their own, \
                 or split the mesh into convex hulls",
            );
        }
        _ => {}
    }
    shape.check()?;
    if !pose.is_finite() {
        return Err(GeometryError::NotFinite { shape: "compound", what: "pose of child", index });
    }
    let length = pose.q.length();
    if (length - 1.0).abs() > 1e-3 {
        let (field, expected) = ("length of a child's rotation", "a unit quaternion");
        return Err(GeometryError::BadNumber { shape: "compound", field, value: length, expected });
    }
    Ok(())
}
