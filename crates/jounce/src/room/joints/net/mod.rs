//! Dense nets of joints, row by row, in lanes.
//!
//! What has more loops than a direct solve bears (flags of chain mail, grids, walls laid in mortar), and what asks for it, gets what contacts
//! get: soft rows (`Settings::joint_hertz`, `joint_damping_ratio`), impulses of the last substep to start from, a biased pass before contacts
//! and one after them, and a relaxing one a substep, in colours of joints that share no moving body.
//!
//! Four types, each with a kernel and blocks of its own:
//!
//! * ball: d = p_b − p_a = 0; J = (−1, r_a×, 1, −r_b×), a 3×3 block; cone and twist as ends; motor and friction about A's axes;
//! * point: a ball with neither of these, which cannot break ([`point`]): the same rows, for which a pass goes through a quarter of the memory;
//! * hinge: the same, and x_b stays across y_a and z_a, a 2×2 block, j = x_b × n; ends, motor, spring and friction about x;
//! * fixed: the same, and no turn, C = 2 v of q_b q_a⁻¹ = (v, w) as a 3×3 block about the world's axes.
//!
//! Ends without transcendentals. The cone: C = (x_a·x_b − cos γ)/sin θ, j = x_b × x_a/sin θ, which is γ − θ to first order. The twist: with
//! q_a⁻¹ q_b = (x, …, w) and n = √(x² + w²), C = 2 (x cos ½l − w sin ½l)/n = 2 sin ½(φ − l).
//!
//! Springs are those of [`super::extra`]: λ = −M (a C + b (ω − ω₀)) once per substep, M the inverse of I_a⁻¹ + I_b⁻¹, C the rotation
//! vector that is left, 4 atan t · v/|v| with t = |v|/(1 + w).
//!
//! Sources: Catto, Soft constraints, GDC 2011; Solver2D 2024 (soft step, relax); blocks and masks as contacts have them.

pub(crate) mod fill;
pub(crate) mod point;
pub(crate) mod solve;
mod two;

use super::alike::Kind;
use super::desc::JointDesc;
use crate::room::contacts::rows::{LANES, Lane, LaneVec};
use jounce_tasks::ColorSets;

/// What a block is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Type {
    Ball,
    Hinge,
    Fixed,
}

impl Type {
    pub const ALL: [Self; 3] = [Self::Ball, Self::Hinge, Self::Fixed];

    /// The type of a joint all of whose parts the kernels know; `h`: the substep, s.
    pub fn of(d: &JointDesc, h: f32) -> Option<Self> {
        Some(match Kind::known(d, h)? {
            Kind::Ball { .. } => Self::Ball,
            Kind::Hinge { .. } => Self::Hinge,
            Kind::Fixed => Self::Fixed,
        })
    }
}

/// [`LANES`] joints of one type and colour, each field an array over them. Lanes without a joint are zero and change nothing.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// As the step began, world axes: levers, A to B, joint frames.
    pub ra: LaneVec,
    pub rb: LaneVec,
    pub offset: LaneVec,
    pub qa: [Lane; 4],
    pub qb: [Lane; 4],
    /// The same where the bodies have been since they last moved, with d instead of the offset.
    pub now: Now,
    pub inv_mass: [Lane; 2],
    pub inertia: [[Lane; 6]; 2],
    /// Impulses of this substep, world axes; of a hinge's turns, about y and z of A.
    pub point: LaneVec,
    pub turn: LaneVec,
    /// cos γ of the cone, 2 for none; cosine and sine of half of both ends of the twist.
    pub cone: Lane,
    pub ends: [[Lane; 2]; 2],
    pub end_impulse: [Lane; 3],
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
    pub places: [Places; LANES],
    pub any_ends: bool,
    pub any_pull: bool,
    pub any_drive: bool,
}

/// Levers, anchor to anchor, and joint frames.
#[derive(Clone, Debug)]
pub(crate) struct Now {
    pub ra: LaneVec,
    pub rb: LaneVec,
    pub d: LaneVec,
    pub qa: [Lane; 4],
    pub qb: [Lane; 4],
}

impl Default for Block {
    fn default() -> Self {
        const Z: Lane = [0.0; LANES];
        Self {
            ra: LaneVec::ZERO,
            rb: LaneVec::ZERO,
            offset: LaneVec::ZERO,
            qa: [Z, Z, Z, [1.0; LANES]],
            qb: [Z, Z, Z, [1.0; LANES]],
            now: Now {
                ra: LaneVec::ZERO,
                rb: LaneVec::ZERO,
                d: LaneVec::ZERO,
                qa: [Z, Z, Z, [1.0; LANES]],
                qb: [Z, Z, Z, [1.0; LANES]],
            },
            inv_mass: [Z; 2],
            inertia: [[Z; 6]; 2],
            point: LaneVec::ZERO,
            turn: LaneVec::ZERO,
            cone: [NO_CONE; LANES],
            ends: [[Z; 2]; 2],
            end_impulse: [Z; 3],
            pull: [Z; 3],
            rest: [Z, Z, Z, [1.0; LANES]],
            pull_speed: LaneVec::ZERO,
            pull_impulse: LaneVec::ZERO,
            drive: Z,
            drive_speed: LaneVec::ZERO,
            drive_impulse: LaneVec::ZERO,
            force: LaneVec::ZERO,
            torque: LaneVec::ZERO,
            last: [Z; 2],
            bound: [[f32::INFINITY; LANES]; 2],
            broke: Z,
            places: [Places::default(); LANES],
            any_ends: false,
            any_pull: false,
            any_drive: false,
        }
    }
}

/// Where impulses are in the list of a joint's record (255: nowhere), on how many axes its motor or friction acts, and how long the list is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Places {
    pub cone: u8,
    pub twist: u8,
    pub drive: u8,
    pub axes: u8,
    pub count: u8,
}

/// Stands for the cosine of a cone that is not there.
pub(crate) const NO_CONE: f32 = -2.0;

/// All joints of one type.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows<B = Block> {
    pub ids: Vec<u32>,
    /// The set of each joint.
    pub sets: Vec<u32>,
    /// Bodies of each joint, and items of these as the colours have them.
    pub bodies: Vec<[u32; 2]>,
    pub items: Vec<[u32; 2]>,
    pub colors: ColorSets,
    /// Colour and row of each joint; and by joint id, which of them it is.
    pub places: Vec<(u8, u32)>,
    pub owners: Vec<u32>,
    /// By colour, the overflow last.
    pub blocks: Vec<Vec<B>>,
}

impl<B: Clone + Default> Rows<B> {
    /// Colours and empty blocks anew where the joints' items are others than they were; tells whether that was so. `of`: bodies of a joint, and
    /// their items; `awake`: how many bodies are.
    pub fn arrange(&mut self, awake: usize, of: impl Fn(u32) -> ([u32; 2], [u32; 2])) -> bool {
        let now = self.ids.iter().map(|&id| of(id));
        self.bodies.clear();
        self.bodies.extend(now.clone().map(|n| n.0));
        if self.colors.items() == awake && self.items.iter().copied().eq(now.clone().map(|n| n.1)) {
            return false;
        }
        let now = now.map(|n| n.1).collect();
        self.items = now;
        self.colors.reset(awake);
        self.places.clear();
        for (i, [a, b]) in self.items.iter().enumerate() {
            let place = self.colors.push(*a, *b, i as u32);
            debug_assert!(place.is_some(), "a joint of a body with itself, or of none that moves");
            self.places.push(place.unwrap_or((ColorSets::OVERFLOW, u32::MAX)));
        }
        self.blocks.resize(ColorSets::COLORS + 1, Vec::new());
        for (color, blocks) in self.blocks.iter_mut().enumerate() {
            blocks.clear();
            blocks.resize(self.colors.rows(color).len().div_ceil(LANES), B::default());
        }
        true
    }

    pub fn clear(&mut self) {
        self.ids.clear();
        self.sets.clear();
    }

    pub fn push(&mut self, id: u32, set: usize) {
        self.owners.resize(self.owners.len().max(id as usize + 1), u32::MAX);
        self.owners[id as usize] = self.ids.len() as u32;
        self.ids.push(id);
        self.sets.push(set as u32);
    }
}
