//! Solver rows of manifolds: blocks of [`LANES`] rows of one colour, each field an array over the rows.
//!
//! The layout does not depend on the width of the kernels: a kernel of 1, 4, 8 or 16 lanes walks the same block in
//! 16, 4, 2 or 1 steps. Rows of a block touch disjoint bodies. Lanes without a row are zero throughout and change nothing.

use crate::room::rigid::state::{BodyState, InvInertia};
pub(crate) use jounce_lanes::Wide3;
use jounce_lanes::{Array, Lanes};
use jounce_math::Vec3;
use std::ops::{Deref, DerefMut};

/// Rows of a block.
pub(crate) const LANES: usize = jounce_lanes::LANES_MAX;
/// One field over the rows.
pub(crate) type Lane = [f32; LANES];

/// A vector field over the rows.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct LaneVec(pub [Lane; 3]);

impl LaneVec {
    pub const ZERO: Self = Self([[0.0; LANES]; 3]);
    #[inline(always)]
    pub fn get(&self, l: usize) -> Vec3 {
        Vec3::new(self.0[0][l % LANES], self.0[1][l % LANES], self.0[2][l % LANES])
    }
    #[inline(always)]
    pub fn set(&mut self, l: usize, v: Vec3) {
        self.0[0][l % LANES] = v.x;
        self.0[1][l % LANES] = v.y;
        self.0[2][l % LANES] = v.z;
    }
}

impl Deref for LaneVec {
    type Target = [Lane; 3];
    #[inline(always)]
    fn deref(&self) -> &[Lane; 3] {
        &self.0
    }
}

impl DerefMut for LaneVec {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [Lane; 3] {
        &mut self.0
    }
}

/// Velocity and spin of a body a lane.
#[inline(always)]
pub(crate) fn velocity<L: Lanes>(of: &[&BodyState; LANES], at: usize) -> (Wide3<L>, Wide3<L>) {
    let u = L::gather8(
        #[inline(always)]
        |l| &of[(at + l) % LANES].hot,
    );
    (Wide3::new(u[0], u[1], u[2]), Wide3::new(u[3], u[4], u[5]))
}

/// One point of each row: what every pass over normal rows reads.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct PointRows {
    /// From the friction centre along the two tangents, metres.
    pub x: Lane,
    pub y: Lane,
    /// s₀, metres.
    pub separation: Lane,
    /// Effective mass m; 0 for a point that is not there.
    pub mass: Lane,
    /// Accumulated impulse λ of this substep.
    pub impulse: Lane,
}

impl PointRows {
    const ZERO: Self = Self {
        x: [0.0; LANES],
        y: [0.0; LANES],
        separation: [0.0; LANES],
        mass: [0.0; LANES],
        impulse: [0.0; LANES],
    };
}

/// The rest of a point.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct PointSums {
    /// Sum of λ over the substeps.
    pub total: Lane,
    /// Lever of twist friction: distance from the friction centre, and the surface's own patch, metres.
    pub lever: Lane,
    /// Approach speed at the start of the step, m/s, for hit events.
    pub approach: Lane,
    /// Speed that restitution gives back (e V + a h/2), or 0; filled where something bounces.
    pub rebound: Lane,
}

impl PointSums {
    const ZERO: Self =
        Self { total: [0.0; LANES], lever: [0.0; LANES], approach: [0.0; LANES], rebound: [0.0; LANES] };
}

/// [`LANES`] manifolds of one colour.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block {
    pub normal: LaneVec,
    /// From A's and B's centre of mass to the friction centre.
    pub arm_a: LaneVec,
    pub arm_b: LaneVec,
    pub inv_mass_a: Lane,
    pub inv_mass_b: Lane,
    /// I⁻¹ of both bodies: xx, yy, zz, xy, xz, yz; xx alone where all bodies are `round`.
    pub inertia_a: [Lane; 6],
    pub inertia_b: [Lane; 6],
    /// Part of the push-out that is this contact's.
    pub share: Lane,
    /// A_ij = J_i M⁻¹ J_jᵀ of two points, at [`coupling`].
    pub coupling: [Lane; 6],
    pub points: [PointRows; 4],
    pub sums: [PointSums; 4],
    /// μ_s or μ_k, by the stick bit.
    pub mu: Lane,
    /// Inverse of the 2×2 friction matrix: xx, xy, yy.
    pub friction_mass: [Lane; 3],
    pub friction_impulse: [Lane; 2],
    pub friction_total: [Lane; 2],
    pub twist_mass: Lane,
    pub twist_impulse: Lane,
    /// Wanted tangential velocity (conveyors).
    pub surface_speed: [Lane; 2],
    /// Rolling: coefficient as a length, 3×3 mass, impulse.
    pub rolling: Lane,
    pub rolling_mass: [Lane; 6],
    pub rolling_impulse: LaneVec,
    pub restitution: Lane,
    /// Rows, and most points of a row: 1, 2 or 4.
    pub rows: usize,
    pub points_max: usize,
    /// Some row has rolling friction / a moving surface / restitution.
    pub any_rolling: bool,
    pub any_surface: bool,
    pub any_rebound: bool,
    /// The inertia of every body is the same for all axes: cubes, spheres.
    pub round: bool,
    /// The pass of restitution at hand goes over it.
    pub live: bool,
    /// Largest change of a rebound speed in the last pass of restitution, m/s; negative where nothing bounces.
    pub rebound_change: Lane,
    /// Sum of the points' impulses over the step, before restitution.
    pub compression: Lane,
}

/// Where A_ij lies, i < j: those of the first n points lie in front.
pub(crate) const fn coupling(i: usize, j: usize) -> usize {
    j * (j - 1) / 2 + i
}

/// Two unit vectors that make a right-handed basis with a unit vector (Duff et al. 2017), lane by lane.
#[inline(always)]
pub(crate) fn basis<L: Lanes>(n: Wide3<L>) -> (Wide3<L>, Wide3<L>) {
    let one = L::splat(1.0);
    let sign = L::select(n.z.ge(L::zero()), one, L::splat(-1.0));
    let a = L::splat(-1.0) / (sign + n.z);
    let b = n.x * n.y * a;
    (
        Wide3::new(one + sign * n.x * n.x * a, sign * b, -(sign * n.x)),
        Wide3::new(b, sign + n.y * n.y * a, -n.y),
    )
}

/// Wanted speeds along the tangents.
#[inline(always)]
pub(crate) fn surface<L: Lanes>(block: &Block, at: usize) -> [L; 2] {
    if !block.any_surface {
        return [L::zero(); 2];
    }
    [L::load(&block.surface_speed[0][at..]), L::load(&block.surface_speed[1][at..])]
}

impl Block {
    /// r × n of a point of a row, for body A and B.
    pub fn turns(&self, point: usize, l: usize) -> [Vec3; 2] {
        let n = self.normal.get(l);
        let (t1, t2) = basis::<Array<1>>(Wide3::new(Lanes::splat(n.x), Lanes::splat(n.y), Lanes::splat(n.z)));
        let p = &self.points[point];
        let e = t1.scale(Lanes::splat(p.x[l % LANES])).add(t2.scale(Lanes::splat(p.y[l % LANES])));
        let mut at = LaneVec::ZERO;
        e.store(&mut at, 0);
        let at = at.get(0);
        [(self.arm_a.get(l) + at).cross(n), (self.arm_b.get(l) + at).cross(n)]
    }
    /// Inverse mass and inertia of body A or B of a row.
    pub fn inertia(&self, side: usize, l: usize) -> InvInertia {
        let (t, m) =
            if side == 0 { (&self.inertia_a, &self.inv_mass_a) } else { (&self.inertia_b, &self.inv_mass_b) };
        let [xx, yy, zz, xy, xz, yz] = t.map(|lane| lane[l % LANES]);
        if self.round {
            return InvInertia::round(xx, m[l % LANES]);
        }
        InvInertia { xx, yy, zz, xy, xz, yz, inv_mass: m[l % LANES], pad: 0.0 }
    }
}

/// What a row gave, and how its two surfaces slip, at the end of a step.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Outcome {
    /// Impulses of the points in the last substep, and over the step.
    pub points: [f32; 8],
    /// Friction impulse in the last substep, and over the step, world axes; twist; fastest approach of a point that pushed.
    pub friction: [f32; 8],
    /// Slip velocity and rolling impulse, world axes; by how much friction squared exceeds 0.999 of its bound squared; 1 where it bounced.
    pub slip: [f32; 8],
}

impl Outcome {
    pub const ZERO: Self = Self { points: [0.0; 8], friction: [0.0; 8], slip: [0.0; 8] };
}

impl Default for Block {
    fn default() -> Self {
        const L: Lane = [0.0; LANES];
        const V: LaneVec = LaneVec::ZERO;
        Self {
            normal: V,
            arm_a: V,
            arm_b: V,
            inv_mass_a: L,
            inv_mass_b: L,
            inertia_a: [L; 6],
            inertia_b: [L; 6],
            share: L,
            coupling: [L; 6],
            points: [PointRows::ZERO; 4],
            sums: [PointSums::ZERO; 4],
            mu: L,
            friction_mass: [L; 3],
            friction_impulse: [L; 2],
            friction_total: [L; 2],
            twist_mass: L,
            twist_impulse: L,
            surface_speed: [L; 2],
            rolling: L,
            rolling_mass: [L; 6],
            rolling_impulse: V,
            restitution: L,
            rows: 0,
            points_max: 0,
            any_rolling: false,
            any_surface: false,
            any_rebound: false,
            round: false,
            live: false,
            rebound_change: [-1.0; LANES],
            compression: L,
        }
    }
}
