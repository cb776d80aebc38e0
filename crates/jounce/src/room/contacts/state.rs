//! Columns of shapes and contacts.

use super::desc::{Filter, MassSpec, Material};
use crate::room::fields::desc::Aero;
use crate::room::rigid::state::NONE;
use jounce_geometry::{Near, PairCache, Shape};
use jounce_lanes::prefetch;
use jounce_math::{Pose, Quat, Vec3};

/// Which tree a shape's bounds are in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// Disabled, or its body is.
    Nowhere,
    /// Bounds of fixed bodies.
    FixedTree(u32),
    /// Bounds of kinematic and dynamic bodies, awake or asleep.
    MovingTree(u32),
    /// Half-spaces: no bounds.
    Unbounded,
}

/// A shape on a body.
#[derive(Clone, Debug)]
pub(crate) struct ShapeRecord {
    pub body: u32,
    pub shape: Shape,
    /// In the body's frame.
    pub pose: Pose,
    pub mass: MassSpec,
    pub material: Material,
    pub triangle_materials: Vec<Material>,
    pub filter: Filter,
    pub sensor: bool,
    pub enabled: bool,
    pub contact_events: bool,
    pub hit_events: bool,
    pub user_data: u128,
    pub aero: Aero,
    /// Volume, m³, and radius of the ball that has it; 0 for surfaces.
    pub volume: f32,
    pub ball_radius: f32,
    pub place: Place,
    /// Smallest thickness, metres: sets the slop.
    pub thickness: f32,
    /// The middle of its bounds (its own frame), and how far from there it reaches.
    pub middle: Vec3,
    pub reach: f32,
    /// Sensors: visitor shape slots with generation, sorted.
    pub visitors: Vec<(u32, u32)>,
}

/// A contact point: what goes into the solver's lanes, in every step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub(crate) struct Point {
    /// Lever from A's centre of mass to the middle of the gap at the time of the test, world axes.
    pub arm: Vec3,
    /// Gap at the start of the step, metres.
    pub separation: f32,
    /// Normal impulse of the last substep, N s.
    pub impulse: f32,
}

/// Where a contact point is on the two bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub(crate) struct Anchor {
    /// On A's surface, from A's centre of mass, in body A's axes.
    pub on_a: Vec3,
    /// On B's surface, from B's centre of mass, in body B's axes.
    pub on_b: Vec3,
    pub feature: u32,
}

/// Up to four points with one normal, and what friction remembers.
///
/// The fields lie in the order in which they are asked for. The solver's lanes are filled from those down to `surface`: three lines of memory,
/// of a list that is larger than the caches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(crate) struct ContactManifold {
    /// Unit, A to B, world axes, as of the last test. Like the levers it stays while the contact is recycled, as it does
    /// over the substeps: only the gaps follow the bodies. A tall stack on soft contacts would buckle otherwise.
    pub normal: Vec3,
    /// From A's centre of mass to B's at the time of the test, world axes.
    pub offset: Vec3,
    pub twist: f32,
    /// Sum of what the points gave over the last step, N s.
    pub total: f32,
    /// Friction impulse of the last substep, world frame, N s.
    pub friction: Vec3,
    pub rolling: Vec3,
    pub count: u8,
    pub faces: u8,
    /// Holds up to μ_s N; sliding otherwise, at μ_k N.
    pub stick: bool,
    /// Others of the contact may follow it, in [`Contact::rest`].
    pub more: bool,
    pub points: [Point; 4],
    /// Slip velocity of B against A at the end of the last step, world frame, m/s.
    pub slip: Vec3,
    /// Surface coefficients of this manifold (triangles differ).
    pub surface: Surface,
    /// Sums over the substeps of the last step: of the points, and of friction, world frame, N s.
    pub totals: [f32; 4],
    pub total_friction: Vec3,
    pub anchors: [Anchor; 4],
    pub sub_a: u32,
    pub sub_b: u32,
}

const NO_POINT: Point = Point { arm: Vec3::ZERO, separation: 0.0, impulse: 0.0 };
const NO_ANCHOR: Anchor = Anchor { on_a: Vec3::ZERO, on_b: Vec3::ZERO, feature: 0 };

impl ContactManifold {
    pub const NOTHING: Self = Self {
        normal: Vec3::ZERO,
        offset: Vec3::ZERO,
        twist: 0.0,
        total: 0.0,
        friction: Vec3::ZERO,
        rolling: Vec3::ZERO,
        count: 0,
        faces: 0,
        stick: true,
        more: false,
        points: [NO_POINT; 4],
        slip: Vec3::ZERO,
        surface: Surface::NOTHING,
        totals: [0.0; 4],
        total_friction: Vec3::ZERO,
        anchors: [NO_ANCHOR; 4],
        sub_a: NONE,
        sub_b: NONE,
    };
    /// Normal, offset, twist; one more in the order of memory.
    #[inline(always)]
    pub fn lanes(&self) -> [f32; 8] {
        let (n, d) = (self.normal, self.offset);
        [n.x, n.y, n.z, d.x, d.y, d.z, self.twist, self.total]
    }
    /// Arm, separation, impulse of a point.
    #[inline(always)]
    pub fn point_lanes(&self, i: usize) -> [f32; 8] {
        let p = &self.points[i];
        [p.arm.x, p.arm.y, p.arm.z, p.separation, p.impulse, 0.0, 0.0, 0.0]
    }
    /// Asks for the lines that the lanes are filled from.
    #[inline(always)]
    pub fn prefetch(&self) {
        prefetch(&self.normal);
        prefetch(&self.points);
        prefetch(&self.surface);
    }
    /// Asks for the lines that gaps are found from.
    #[inline(always)]
    pub fn prefetch_gaps(&self) {
        prefetch(&self.points);
        prefetch(&self.anchors);
        prefetch(&self.anchors[2]);
    }
    /// Points with where they are on the bodies.
    pub fn points(&self) -> impl Iterator<Item = (&Point, &Anchor)> {
        self.points.iter().zip(&self.anchors).take(usize::from(self.count))
    }
    /// Friction and rolling impulses, as the memory has them.
    #[inline(always)]
    pub fn friction_lanes(&self) -> [f32; 8] {
        let (f, r) = (self.friction, self.rolling);
        [f.x, f.y, f.z, r.x, r.y, r.z, 0.0, 0.0]
    }
}

impl Default for ContactManifold {
    fn default() -> Self {
        Self::NOTHING
    }
}

/// Two materials combined.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Surface {
    /// μ_s.
    pub static_friction: f32,
    /// μ_k.
    pub kinetic_friction: f32,
    /// e.
    pub restitution: f32,
    /// Length, metres.
    pub rolling_friction: f32,
    /// Length, metres.
    pub twist_friction: f32,
    /// Wanted velocity of B's surface against A's, world frame, m/s.
    pub velocity: Vec3,
}

impl Surface {
    pub(crate) const NOTHING: Self = Self {
        static_friction: 0.0,
        kinetic_friction: 0.0,
        restitution: 0.0,
        rolling_friction: 0.0,
        twist_friction: 0.0,
        velocity: Vec3::ZERO,
    };
    /// All of it, in the order of memory.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> [f32; 8] {
        let v = self.velocity;
        [
            self.static_friction,
            self.kinetic_friction,
            self.restitution,
            self.rolling_friction,
            self.twist_friction,
            v.x,
            v.y,
            v.z,
        ]
    }
}

/// What every step asks of every awake contact, in a column beside the contacts: most pairs are apart, and are not looked at further.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PairHead {
    pub shapes: [u32; 2],
    pub bodies: [u32; 2],
    /// Sum of the ways of the two bodies (`World::travel`) up to which the pair stays apart for certain, m; where it touches, of their turns up to
    /// which it keeps its manifolds while B stays near to where it was. −∞ where nothing is certain.
    pub until: f64,
    /// Of a pair that touches: from A's centre of mass to B's as it was last looked at, world axes.
    pub looked: Vec3,
    /// How far that may change, m.
    pub near: f32,
    /// Copies of [`Contact::touching`] and [`Contact::fixed`].
    pub touching: bool,
    pub fixed: bool,
    /// Manifolds are those of the last step for certain: the gaps are found as the solver's rows are.
    pub kept: bool,
}

impl PairHead {
    pub fn new(c: &Contact) -> Self {
        Self {
            shapes: [c.shape_a, c.shape_b],
            bodies: [c.body_a, c.body_b],
            until: f64::NEG_INFINITY,
            looked: Vec3::ZERO,
            near: 0.0,
            kept: false,
            touching: c.touching,
            fixed: c.fixed,
        }
    }
    /// The other body.
    pub fn other(&self, body: u32) -> u32 {
        self.bodies[usize::from(self.bodies[0] == body)]
    }
}

/// A pair of shapes whose bounds overlap. The fields lie in the order in which they are asked for. Two lines say whether manifolds are kept; the next
/// three are what the solver reads, and begin with all that a pass over every contact that touches asks for.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Contact {
    pub id: u32,
    pub shape_a: u32,
    pub shape_b: u32,
    pub body_a: u32,
    pub body_b: u32,
    pub touching: bool,
    /// Result of the last narrow phase, committed serially.
    pub now_touching: bool,
    pub apart: bool,
    pub fixed: bool,
    /// Which of the two shapes has no bounds.
    pub planes: [bool; 2],
    pub tested: bool,
    /// How far ahead the pair looks changes from step to step.
    pub bouncy: bool,
    /// min(slop, 5 % of the thinner shape).
    pub slop: f32,
    /// More manifolds than the first, for meshes and compounds.
    pub rest: Vec<ContactManifold>,
    /// Memory, not state.
    pub near: Option<Box<Near>>,
    /// Positions in the two bodies' contact lists (NONE for a fixed body).
    pub edge: [u32; 2],
    /// What the shapes were apart beyond the margin at the last test, m: no part of either meets the other before it has moved so far.
    pub spare: f32,
    /// Largest distance of a point of B from `middle_b`, and that from B's centre of mass, in body B's axes.
    pub extent_b: f32,
    pub middle_b: Vec3,
    /// How far ahead the last test looked.
    pub margin: f32,
    pub recycle_tolerance: f32,
    /// Pose of body B's centre of mass in body A's at the last full test; valid while `tested`.
    pub tested_pose: Pose,
    /// Approach speed at which the two met, for hit events, m/s.
    pub hit_speed: f32,
    /// Some point is deep inside; see [`super::crowd`].
    pub deep: bool,
    pub manifold: ContactManifold,
    /// Rotations of the two bodies at the last full test.
    pub tested_rotations: [Quat; 2],
    pub cache: PairCache,
}

/// Calls: what a call reads, the compiler does not read before it knows that it is wanted.
#[cold]
#[inline(never)]
#[allow(clippy::ptr_arg)]
fn behind(rest: &Vec<ContactManifold>) -> &[ContactManifold] {
    rest
}

#[cold]
#[inline(never)]
#[allow(clippy::ptr_arg)]
fn behind_mut(rest: &mut Vec<ContactManifold>) -> &mut [ContactManifold] {
    rest
}

/// What the solver reads of a contact begins with a line, and ends with the third.
const _: () = {
    use core::mem::{offset_of, size_of};
    let first = offset_of!(Contact, hit_speed);
    assert!(first.is_multiple_of(64) && offset_of!(Contact, manifold) <= first + 8);
    let last = offset_of!(Contact, manifold) + offset_of!(ContactManifold, surface) + size_of::<Surface>();
    assert!(last <= first + 3 * 64);
};

impl Contact {
    pub fn manifold_count(&self) -> usize {
        if self.manifold.count == 0 { 0 } else { 1 + self.others().len() }
    }
    /// The manifolds behind the first. Where there are none, nothing beside the first is read to find that out.
    fn others(&self) -> &[ContactManifold] {
        if self.manifold.more { behind(&self.rest) } else { &[] }
    }
    pub fn manifolds(&self) -> impl Iterator<Item = &ContactManifold> {
        let n = self.manifold_count();
        core::iter::once(&self.manifold).take(n).chain(self.others())
    }
    pub fn manifolds_mut(&mut self) -> impl Iterator<Item = &mut ContactManifold> {
        let n = self.manifold_count();
        let others = if self.manifold.more { behind_mut(&mut self.rest) } else { &mut [] };
        core::iter::once(&mut self.manifold).take(n).chain(others)
    }
    pub fn get(&self, i: usize) -> &ContactManifold {
        if i == 0 { &self.manifold } else { &self.rest[i - 1] }
    }
    pub fn get_mut(&mut self, i: usize) -> &mut ContactManifold {
        if i == 0 { &mut self.manifold } else { &mut self.rest[i - 1] }
    }
}

/// Where a contact's row is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ContactPlace {
    Free,
    Awake(u32),
    Asleep(u32),
}

impl ContactPlace {
    /// What every step asks of the contact, if it is awake.
    pub fn head(self, heads: &[PairHead]) -> Option<&PairHead> {
        if let Self::Awake(row) = self { heads.get(row as usize) } else { None }
    }
}
