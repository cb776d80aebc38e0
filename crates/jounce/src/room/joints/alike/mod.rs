//! Sets of joints that are alike, side by side: the direct solver in lanes.
//!
//! Ragdolls of one table, and whatever else is joined in the same way, have the same matrix of blocks. Sixteen of them are a band: one set per
//! lane, all numbers in arrays over the lanes, f32. What is solved is what [`super::set`] solves (its text has the equations): rows that
//! hold at once, A λ = −C(t + h)/h, ends by an active set, places alone where the motion passed an end. No lane reads another, so a set
//! has the same bits whoever stands beside it, and in every width.
//!
//! Differences, all for speed:
//!
//! * f32, so only for sets whose masses are alike, that are free of all that does not move and that close no loop;
//! * the point is held in world axes: d = p_b − p_a = 0, J = (−1, (r_a + d)×, 1, −r_b×), which exchanges angular momentum exactly;
//! * motors of a velocity and friction push once per pass, joint by joint, ahead of the rows that hold, with a 3×3 mass.
//!
//! Rows of a joint: the point (3); a hinge's axis (2) or a weld's turns (3); the cone and the nearer end of the twist, as they are
//! described. Rows of ends point so that they push: λ ≥ 0. One that takes no part is zero but for a 1 on the diagonal.
//!
//! The pass over a band is a handful of kernels, each dispatched to the width of the machine, with the band between them in cache:
//! take (velocities, and inertia as it is now), refresh (rows), aim (right sides, who acts at first), factor (A = L D Lᵀ), try
//! (λ, and who acts after all), put.
//!
//! Sources: as for [`super::direct`] and [`super::active`]; lanes over independent systems as in batched factorizations (Dongarra et
//! al., Optimized batched linear algebra, 2016).

mod fill;
mod kernels;
mod matrix;
mod passes;
mod pattern;

pub(crate) use fill::Side;
use passes::Pass;
pub(crate) use pattern::{Kind, Link, Pattern};

use crate::room::contacts::rows::{LANES, Lane, LaneVec};
use std::sync::Arc;

const Z: Lane = [0.0; LANES];

/// Rows of a joint at most.
const ROWS: usize = 6;
/// Stands for no body.
pub(crate) const NOBODY: u32 = u32::MAX;

/// A body of each set.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Bodies {
    /// Awake rows.
    pub rows: [u32; LANES],
    pub inv_mass: Lane,
    /// Centre of mass at the start of the step, from that of the set's first body.
    pub at: LaneVec,
    /// World inertia and its inverse at the start of the step.
    pub inertia: [Lane; 6],
    pub inverse: [Lane; 6],
    /// Inverse as it is now.
    pub tensor: [Lane; 6],
    /// The same with what tension adds to inertia, and whether that is anything (1).
    raised: [Lane; 6],
    stiff: Lane,
    pub v: LaneVec,
    pub w: LaneVec,
    /// The same as the pass took them over, w by the inertia of the moment.
    pub v0: LaneVec,
    pub w0: LaneVec,
    /// The same with what the trial of a round adds.
    pub try_v: LaneVec,
    pub try_w: LaneVec,
    pub dp: LaneVec,
    pub dr: LaneVec,
    pub dq: [Lane; 4],
    /// Places as they were before [`Pass::Relax`] put them right.
    pub kept_dp: LaneVec,
    pub kept_dr: LaneVec,
    pub kept_dq: [Lane; 4],
    /// ω that the memory of its momentum knows, and whether there is one (1) or not (0).
    pub known_w: LaneVec,
    pub known: Lane,
    /// What its momentum gains in this pass.
    pub gain: LaneVec,
}

/// A row of a joint.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
struct Row {
    ja: LaneVec,
    jb: LaneVec,
    /// M⁻¹ Jᵀ of the turns.
    ia: LaneVec,
    ib: LaneVec,
    /// Error; of ends the gap.
    c: Lane,
    /// The right side is −(J u + bend).
    bend: Lane,
    /// What the way of the substep bends by, beyond C + h J u.
    curve: Lane,
    /// 1 where it takes part, else 0.
    acts: Lane,
    /// The same in the matrix as it is factored.
    factored: Lane,
    /// Impulses of this substep; as the pass began.
    lambda: Lane,
    before: Lane,
    /// Impulses and who acted, before places alone were put right.
    kept: [Lane; 2],
    /// Ends: +1 the lower one, −1 the upper one.
    sign: Lane,
    /// Right side, then what the round adds.
    x: Lane,
}

/// A joint of each set.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct JointLanes {
    /// As the step began, world axes: levers, A to B, joint frames.
    pub ra: LaneVec,
    pub rb: LaneVec,
    pub offset: LaneVec,
    pub qa: [Lane; 4],
    pub qb: [Lane; 4],
    /// Ends: angle of the cone, least and most twist, rad.
    pub cone: Lane,
    pub twist: [Lane; 2],
    /// Spring: gains, strength (impulse), wanted rotation and velocity (A's axes), impulse (world axes).
    pub pull: [Lane; 3],
    pub rest: [Lane; 4],
    pub pull_speed: LaneVec,
    pub pull_impulse: LaneVec,
    /// Motor of a velocity, or friction: strength (impulse) and speed, impulse, A's axes.
    pub drive: Lane,
    pub drive_speed: LaneVec,
    pub drive_impulse: LaneVec,
    /// Σ over the step on B; sizes in the last substep; bounds of force and torque; 1 where they were passed twice.
    pub force: LaneVec,
    pub torque: LaneVec,
    pub last: [Lane; 2],
    pub bound: [Lane; 2],
    pub broke: Lane,
    rows: [Row; ROWS],
}

/// Up to [`LANES`] sets alike.
#[derive(Clone, Debug)]
pub(crate) struct Band {
    pub pattern: Arc<Pattern>,
    /// Sets, by lane.
    pub sets: Vec<u32>,
    pub bodies: Vec<Bodies>,
    pub joints: Vec<JointLanes>,
    /// Blocks of the matrix, in the order of `matrix::Blocks`.
    matrix: Vec<f32>,
    /// By joint: rows that take part in some of the lanes that are walked together, at the first of these lanes.
    used: Vec<[u8; LANES]>,
    /// 1 in lanes that the pass has not finished.
    live: Lane,
    /// 1 where the matrix is that of the rows as they are.
    fresh: Lane,
    /// Some body of some set is stiffened.
    any_stiff: bool,
    /// Angular momentum of each set before places were put right.
    angular: LaneVec,
    pub any_pull: bool,
    pub any_drive: bool,
    /// Lanes whose bodies [`Pass::Relax`] put elsewhere.
    pub placed: [bool; LANES],
    /// The last pass did something.
    pub changed: bool,
}

impl Band {
    pub fn new(pattern: &Arc<Pattern>) -> Self {
        Self {
            pattern: pattern.clone(),
            sets: Vec::new(),
            bodies: vec![Bodies::default(); pattern.bodies],
            joints: vec![JointLanes::default(); pattern.joints.len()],
            matrix: vec![0.0; LANES * pattern.floats],
            used: vec![[0; LANES]; pattern.joints.len()],
            live: Z,
            fresh: Z,
            any_stiff: false,
            angular: LaneVec::ZERO,
            any_pull: false,
            any_drive: false,
            placed: [false; LANES],
            changed: false,
        }
    }
}

const ONE: [Lane; 4] = [Z, Z, Z, [1.0; LANES]];

impl Default for Bodies {
    fn default() -> Self {
        const V: LaneVec = LaneVec::ZERO;
        Self {
            rows: [NOBODY; LANES],
            inv_mass: Z,
            at: V,
            inertia: [Z; 6],
            inverse: [Z; 6],
            tensor: [Z; 6],
            raised: [Z; 6],
            stiff: Z,
            v: V,
            w: V,
            v0: V,
            w0: V,
            try_v: V,
            try_w: V,
            dp: V,
            dr: V,
            dq: ONE,
            kept_dp: V,
            kept_dr: V,
            kept_dq: ONE,
            known_w: V,
            known: Z,
            gain: V,
        }
    }
}

impl Default for Row {
    fn default() -> Self {
        const V: LaneVec = LaneVec::ZERO;
        Self {
            ja: V,
            jb: V,
            ia: V,
            ib: V,
            c: Z,
            bend: Z,
            curve: Z,
            acts: [1.0; LANES],
            factored: Z,
            lambda: Z,
            before: Z,
            kept: [Z; 2],
            sign: Z,
            x: Z,
        }
    }
}

impl Default for JointLanes {
    fn default() -> Self {
        const V: LaneVec = LaneVec::ZERO;
        Self {
            ra: V,
            rb: V,
            offset: V,
            qa: ONE,
            qb: ONE,
            cone: Z,
            twist: [Z; 2],
            pull: [Z; 3],
            rest: ONE,
            pull_speed: V,
            pull_impulse: V,
            drive: Z,
            drive_speed: V,
            drive_impulse: V,
            force: V,
            torque: V,
            last: [Z; 2],
            bound: [[f32::INFINITY; LANES]; 2],
            broke: Z,
            rows: core::array::from_fn(|_| Row::default()),
        }
    }
}
