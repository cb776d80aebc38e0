//! Contacts as users see them: where shapes touch, and with which forces.
//!
//! Impulses are sums over the substeps of the last step; a force is such a sum divided by the length of the step, so that the
//! normal forces under a body at rest add up to its weight. A sleeping body keeps the numbers of its last step awake.

use crate::error::Result;
use crate::handle::{BodyId, ShapeId};
use crate::room::contacts::state::{Contact, ContactManifold};
use crate::room::rigid::state::NONE;
use crate::table::pair_key;
use crate::world::World;
use jounce_math::{DVec3, Vec3};

/// A touching pair of shapes.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactInfo {
    /// The shapes; normals and forces go from the first to the second.
    pub shapes: [ShapeId; 2],
    /// Their bodies.
    pub bodies: [BodyId; 2],
    /// One per pair of parts that touch (several for meshes and compounds).
    pub manifolds: Vec<ManifoldInfo>,
}

/// Up to four points with one normal.
#[derive(Clone, Debug, PartialEq)]
pub struct ManifoldInfo {
    /// Unit normal from the first to the second shape, world axes.
    pub normal: Vec3,
    /// The points, one to four.
    pub points: Vec<ContactPoint>,
    /// Friction on the second body over the last step, N s, world axes. The first body got the opposite.
    pub friction_impulse: Vec3,
    /// The same as a force, N: impulse ÷ step.
    pub friction_force: Vec3,
    /// Holds (static friction) rather than slides (kinetic friction).
    pub stick: bool,
    /// Triangle or child of each shape.
    pub parts: [Option<u32>; 2],
}

/// A contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Midway between the two surfaces, world.
    pub point: DVec3,
    /// Gap along the normal, metres; negative for overlap.
    pub separation: f32,
    /// What the point pushed the second body with along the normal over the last step, N s.
    pub normal_impulse: f32,
    /// The same as a force, N: impulse ÷ step.
    pub normal_force: f32,
}

impl ContactInfo {
    /// The force on the second body, N: normal forces and friction. The first body feels the opposite.
    pub fn force(&self) -> Vec3 {
        self.manifolds.iter().fold(Vec3::ZERO, |f, m| f + m.normal * m.normal_force() + m.friction_force)
    }
    /// Sum of the normal forces of all points, N.
    pub fn normal_force(&self) -> f32 {
        self.manifolds.iter().map(ManifoldInfo::normal_force).sum()
    }
}

impl ManifoldInfo {
    /// Sum of the normal forces of its points, N.
    pub fn normal_force(&self) -> f32 {
        self.points.iter().map(|p| p.normal_force).sum()
    }
}

impl World {
    /// All touching pairs, sorted by the slots of their shapes.
    pub fn contacts(&self) -> Vec<ContactInfo> {
        let all = self.contacts.iter().chain(&self.asleep_contacts);
        self.sorted(all.filter(|c| c.touching).collect())
    }

    /// The touching pairs of a body, sorted by the slots of their shapes.
    ///
    /// # Errors
    /// A stale handle.
    pub fn contacts_of(&self, body: BodyId) -> Result<Vec<ContactInfo>> {
        let slot = self.slot(body)?;
        let all = self.contacts.iter().chain(&self.asleep_contacts);
        // Fixed bodies keep no list of their contacts.
        let listed = self.bodies[slot].contacts.iter().filter_map(|&id| self.contact(id));
        let of_body = |c: &&Contact| c.touching && (c.body_a == slot || c.body_b == slot);
        let found = match self.bodies[slot].kind {
            crate::BodyKind::Fixed => all.filter(of_body).collect(),
            _ => listed.filter(of_body).collect(),
        };
        Ok(self.sorted(found))
    }

    /// The contact of two shapes, if they touch.
    ///
    /// # Errors
    /// A stale handle.
    pub fn contact_between(&self, a: ShapeId, b: ShapeId) -> Result<Option<ContactInfo>> {
        let (a, b) = (self.shape_slot(a)?, self.shape_slot(b)?);
        let contact = self.pairs.get(pair_key(a, b)).and_then(|id| self.contact(id));
        Ok(contact.filter(|c| c.touching).map(|c| self.contact_info(c)))
    }

    fn sorted(&self, mut contacts: Vec<&Contact>) -> Vec<ContactInfo> {
        contacts.sort_unstable_by_key(|c| pair_key(c.shape_a, c.shape_b));
        contacts.into_iter().map(|c| self.contact_info(c)).collect()
    }

    fn contact_info(&self, c: &Contact) -> ContactInfo {
        ContactInfo {
            shapes: [self.shape_id(c.shape_a), self.shape_id(c.shape_b)],
            bodies: [self.body_id(c.body_a), self.body_id(c.body_b)],
            manifolds: c.manifolds().map(|m| self.manifold_info(c, m)).collect(),
        }
    }

    fn manifold_info(&self, c: &Contact, m: &ContactManifold) -> ManifoldInfo {
        let (fa, fb) = (&self.frames[c.body_a as usize], &self.frames[c.body_b as usize]);
        let rate = self.rate_hz as f32;
        let part = |s: u32| (s != NONE).then_some(s);
        let points = m.anchors.iter().zip(m.totals).take(usize::from(m.count)).map(|(p, total)| {
            let a = fa.center + fa.rotation.rotate(p.on_a).as_dvec3();
            let b = fb.center + fb.rotation.rotate(p.on_b).as_dvec3();
            ContactPoint {
                point: a.lerp(b, 0.5),
                separation: (b - a).as_vec3().dot(m.normal),
                normal_impulse: total,
                normal_force: total * rate,
            }
        });
        ManifoldInfo {
            normal: m.normal,
            points: points.collect(),
            friction_impulse: m.total_friction,
            friction_force: m.total_friction * rate,
            stick: m.stick,
            parts: [part(m.sub_a), part(m.sub_b)],
        }
    }
}
