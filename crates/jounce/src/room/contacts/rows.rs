//! Solver rows of manifolds: blocks of [`LANES`] rows of one colour, each field an array over the rows.
//!
//! The layout does not depend on the width of the kernels: a kernel of 1, 4, 8 or 16 lanes walks the same block in
//! 16, 4, 2 or 1 steps. Rows of a block touch disjoint bodies. Lanes without a row are zero throughout and change nothing.

use crate::room::rigid::state::BodyState;
use jounce_lanes::{Lanes, six};
use jounce_math::Vec3;

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

/// A vector per lane, in registers.
#[derive(Clone, Copy)]
pub(crate) struct Wide3<L> {
    pub x: L,
    pub y: L,
    pub z: L,
}

impl<L: Lanes> Wide3<L> {
    #[inline(always)]
    pub fn new(x: L, y: L, z: L) -> Self {
        Self { x, y, z }
    }
    #[inline(always)]
    pub fn load(v: &LaneVec, at: usize) -> Self {
        Self { x: L::load(&v.0[0][at..]), y: L::load(&v.0[1][at..]), z: L::load(&v.0[2][at..]) }
    }
    #[inline(always)]
    pub fn store(self, v: &mut LaneVec, at: usize) {
        self.x.store(&mut v.0[0][at..]);
        self.y.store(&mut v.0[1][at..]);
        self.z.store(&mut v.0[2][at..]);
    }
    #[inline(always)]
    pub fn dot(self, o: Self) -> L {
        self.x * o.x + self.y * o.y + self.z * o.z
    }
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self::new(self.y * o.z - self.z * o.y, self.z * o.x - self.x * o.z, self.x * o.y - self.y * o.x)
    }
    #[inline(always)]
    pub fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
    #[inline(always)]
    pub fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
    #[inline(always)]
    pub fn scale(self, s: L) -> Self {
        Self::new(self.x * s, self.y * s, self.z * s)
    }
    /// T v for a symmetric tensor stored xx, yy, zz, xy, xz, yz.
    #[inline(always)]
    pub fn times(self, t: &[Lane; 6], at: usize) -> Self {
        self.turned(&six(
            #[inline(always)]
            |i: usize| L::load(&t[i][at..]),
        ))
    }
    /// The same for a tensor in registers.
    #[inline(always)]
    pub fn turned(self, t: &[L; 6]) -> Self {
        let [xx, yy, zz, xy, xz, yz] = *t;
        Self::new(
            xx * self.x + xy * self.y + xz * self.z,
            xy * self.x + yy * self.y + yz * self.z,
            xz * self.x + yz * self.y + zz * self.z,
        )
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

/// A one-dimensional constraint direction: J by its angular parts, and I⁻¹ times them.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Jacobian {
    /// r_A × d.
    pub a: LaneVec,
    /// r_B × d.
    pub b: LaneVec,
    /// I_A⁻¹ (r_A × d).
    pub ia: LaneVec,
    /// I_B⁻¹ (r_B × d).
    pub ib: LaneVec,
}

impl Jacobian {
    const ZERO: Self = Self { a: LaneVec::ZERO, b: LaneVec::ZERO, ia: LaneVec::ZERO, ib: LaneVec::ZERO };
}

/// One point of each row.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct PointRows {
    pub j: Jacobian,
    /// s₀, metres.
    pub separation: Lane,
    /// Effective mass m; 0 for a point that is not there.
    pub mass: Lane,
    /// Accumulated impulse λ of this substep.
    pub impulse: Lane,
    /// Sum of λ over the substeps.
    pub total: Lane,
    /// Distance from the friction centre, metres.
    pub lever: Lane,
    /// Speed that restitution gives back (e V + a h/2), or 0.
    pub rebound: Lane,
    /// Approach speed at the start of the step, m/s, for hit events.
    pub approach: Lane,
}

impl PointRows {
    const ZERO: Self = Self {
        j: Jacobian::ZERO,
        separation: [0.0; LANES],
        mass: [0.0; LANES],
        impulse: [0.0; LANES],
        total: [0.0; LANES],
        lever: [0.0; LANES],
        rebound: [0.0; LANES],
        approach: [0.0; LANES],
    };
}

/// [`LANES`] manifolds of one colour.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block {
    pub normal: LaneVec,
    pub tangent: LaneVec,
    pub inv_mass_a: Lane,
    pub inv_mass_b: Lane,
    /// b, σ, ι of the soft constraint.
    pub bias_rate: Lane,
    pub mass_scale: Lane,
    pub impulse_scale: Lane,
    /// −v_push, m/s.
    pub push_out: Lane,
    pub points: [PointRows; 4],
    /// Friction along `tangent` and normal × tangent.
    pub friction: [Jacobian; 2],
    /// Inverse of the 2×2 friction matrix: xx, xy, yy.
    pub friction_mass: [Lane; 3],
    pub friction_impulse: [Lane; 2],
    pub friction_total: [Lane; 2],
    /// Wanted tangential velocity (conveyors).
    pub surface_speed: [Lane; 2],
    /// μ_s or μ_k, by the stick bit.
    pub mu: Lane,
    /// I⁻¹ n, for twist.
    pub twist_ia: LaneVec,
    pub twist_ib: LaneVec,
    pub twist_mass: Lane,
    pub twist_impulse: Lane,
    /// Patch radius of twist friction, metres.
    pub twist_patch: Lane,
    /// Rolling: coefficient as a length, 3×3 mass, impulse.
    pub rolling: Lane,
    pub rolling_mass: [Lane; 6],
    pub rolling_impulse: LaneVec,
    /// I⁻¹ of both bodies: xx, yy, zz, xy, xz, yz; filled where some row rolls.
    pub inertia_a: [Lane; 6],
    pub inertia_b: [Lane; 6],
    pub restitution: Lane,
    /// Rows, and most points of a row.
    pub rows: usize,
    pub points_max: usize,
    /// Some row has rolling friction / restitution.
    pub any_rolling: bool,
    pub any_rebound: bool,
    /// The pass of restitution at hand goes over it.
    pub live: bool,
    /// Largest change of a rebound speed in the last pass of restitution, m/s; negative where nothing bounces.
    pub rebound_change: Lane,
    /// Sum of the points' impulses over the step, before restitution.
    pub compression: Lane,
    /// What goes back to the manifolds.
    pub results: [Outcome; LANES],
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
    const ZERO: Self = Self { points: [0.0; 8], friction: [0.0; 8], slip: [0.0; 8] };
}

impl Default for Block {
    fn default() -> Self {
        const L: Lane = [0.0; LANES];
        const V: LaneVec = LaneVec::ZERO;
        Self {
            normal: V,
            tangent: V,
            inv_mass_a: L,
            inv_mass_b: L,
            bias_rate: L,
            mass_scale: L,
            impulse_scale: L,
            push_out: L,
            points: [PointRows::ZERO; 4],
            friction: [Jacobian::ZERO; 2],
            friction_mass: [L; 3],
            friction_impulse: [L; 2],
            friction_total: [L; 2],
            surface_speed: [L; 2],
            mu: L,
            twist_ia: V,
            twist_ib: V,
            twist_mass: L,
            twist_impulse: L,
            twist_patch: L,
            rolling: L,
            rolling_mass: [L; 6],
            rolling_impulse: V,
            inertia_a: [L; 6],
            inertia_b: [L; 6],
            restitution: L,
            rows: 0,
            points_max: 0,
            any_rolling: false,
            any_rebound: false,
            live: false,
            rebound_change: [-1.0; LANES],
            compression: L,
            results: [Outcome::ZERO; LANES],
        }
    }
}
