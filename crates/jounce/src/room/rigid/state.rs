//! Columns of the rigid bodies.
//!
//! * [`Body`]: one per slot, cold: what the user described, and what a sleeping body needs to wake.
//! * [`BodyFrame`]: one per slot: where the body is; read by collision and queries for every body.
//! * [`BodyState`]: one per *awake* moving body, hot, 64 bytes: what the solver touches for every contact.
//! * [`BodyStep`]: one per awake body: read once per substep by the integrator.

use super::desc::{AxisLocks, BodyKind};
use jounce_geometry::MassProperties;
use jounce_math::{DQuat, DVec3, Mat3, Pose, Quat, Vec3, WorldPose};

/// "No row", "no island".
pub(crate) const NONE: u32 = u32::MAX;

/// Cold data of a body.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub kind: BodyKind,
    pub enabled: bool,
    pub bullet: bool,
    pub fast_rotation: bool,
    pub can_sleep: bool,
    pub locks: AxisLocks,
    pub linear_damping: f32,
    pub angular_damping: f32,
    pub gravity_scale: f32,
    pub sleep_speed: Option<f32>,
    pub user_data: u128,
    pub name: Option<String>,
    pub mass_override: Option<MassProperties>,
    /// Shape slots, in order of attachment.
    pub shapes: Vec<u32>,
    /// Contact ids; kept for moving bodies only (a floor may have tens of thousands).
    pub contacts: Vec<u32>,
    /// Joint slots, in order.
    pub joints: Vec<u32>,
    /// Vehicle whose chassis it is, or NONE.
    pub vehicle: u32,
    /// Row in the awake columns, or NONE.
    pub row: u32,
    /// Sleeping island, or NONE.
    pub island: u32,
    /// Velocity while there is no row.
    pub velocity: Vec3,
    pub angular_velocity: Vec3,
    pub mass: Mass,
}

impl Body {
    /// What it will meet must be known a step before: bullets, which may run after what runs away, and bodies on joints, which
    /// continuous collision would tear from the others by stopping them alone.
    pub fn looks_ahead(&self) -> bool {
        self.bullet || (self.kind == BodyKind::Dynamic && !self.joints.is_empty())
    }
}

/// Mass properties in the forms the solver wants. All zero inverse for fixed and kinematic bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Mass {
    pub mass: f32,
    pub inv_mass: f32,
    /// Inverse inertia about the centre of mass, body axes.
    pub inv_inertia: Mat3,
    /// Inertia likewise.
    pub inertia: Mat3,
    /// Principal moments and their inverses (f64: the torque-free turn needs them exact) and the principal frame in body axes.
    pub moments: DVec3,
    pub inv_moments: DVec3,
    pub principal: DQuat,
    /// All moments equal within 1e-5: no gyroscopic torque.
    pub isotropic: bool,
    /// Distance from the centre of mass to the nearest surface of the smallest shape, metres.
    pub inner_radius: f32,
    /// Distance from the centre of mass to the farthest point, metres.
    pub outer_radius: f32,
    /// The same along each of its axes.
    pub reach: Vec3,
}

/// Where a body is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct BodyFrame {
    /// Centre of mass in the world.
    pub center: DVec3,
    pub rotation: Quat,
    /// Centre of mass in the body's frame.
    pub local_center: Vec3,
    /// The same at the start of the last step, for interpolation and continuous collision.
    pub center0: DVec3,
    pub rotation0: Quat,
    /// Row in the awake columns, or NONE: a copy of `Body::row`, where collision reads it.
    pub row: u32,
    /// A copy of [`Body::looks_ahead`], likewise.
    pub looks_ahead: bool,
}

impl BodyFrame {
    pub fn pose(&self) -> WorldPose {
        WorldPose::new(self.center - self.rotation.rotate(self.local_center).as_dvec3(), self.rotation)
    }
    pub fn pose0(&self) -> WorldPose {
        WorldPose::new(self.center0 - self.rotation0.rotate(self.local_center).as_dvec3(), self.rotation0)
    }
    /// A shape's frame in the world.
    pub fn shape_pose(&self, local: &Pose) -> WorldPose {
        let p = self.rotation.rotate(local.p - self.local_center);
        WorldPose::new(self.center + p.as_dvec3(), self.rotation * local.q)
    }
    pub fn place(&mut self, origin: DVec3, rotation: Quat) {
        self.center = origin + rotation.rotate(self.local_center).as_dvec3();
        self.rotation = rotation;
        self.reset_interpolation();
    }
    pub fn reset_interpolation(&mut self) {
        (self.center0, self.rotation0) = (self.center, self.rotation);
    }
}

/// The hot line: velocities, and the motion since the start of the step, as two rows of eight floats that wide
/// kernels load and transpose.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct BodyState {
    /// v, ω, Δp.x, Δp.y.
    pub hot: [f32; 8],
    /// Δp.z, Δθ, Δq.
    pub motion: [f32; 8],
}

/// A [`BodyState`] by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    /// Velocity of the centre of mass.
    pub v: Vec3,
    /// Angular velocity, world axes.
    pub w: Vec3,
    /// Displacement since the start of the step.
    pub dp: Vec3,
    /// Rotation vector since the start of the step, ∑ ω h.
    pub dr: Vec3,
    /// Rotation since the start of the step (world axes).
    pub dq: Quat,
}

impl BodyState {
    pub const FIXED: Self = Self { hot: [0.0; 8], motion: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0] };

    pub fn new(v: Vec3, w: Vec3) -> Self {
        let mut s = Self::FIXED;
        s.set_velocity(v, w);
        s
    }
    #[inline(always)]
    pub fn v(&self) -> Vec3 {
        Vec3::new(self.hot[0], self.hot[1], self.hot[2])
    }
    #[inline(always)]
    pub fn w(&self) -> Vec3 {
        Vec3::new(self.hot[3], self.hot[4], self.hot[5])
    }
    #[inline(always)]
    pub fn set_velocity(&mut self, v: Vec3, w: Vec3) {
        self.hot[..6].copy_from_slice(&[v.x, v.y, v.z, w.x, w.y, w.z]);
    }
    #[inline(always)]
    pub fn get(&self) -> Motion {
        let [_, _, _, _, _, _, px, py] = self.hot;
        let [pz, rx, ry, rz, qx, qy, qz, qw] = self.motion;
        Motion {
            v: self.v(),
            w: self.w(),
            dp: Vec3::new(px, py, pz),
            dr: Vec3::new(rx, ry, rz),
            dq: Quat::new(qx, qy, qz, qw),
        }
    }
    #[inline(always)]
    pub fn put(&mut self, m: &Motion) {
        self.hot = [m.v.x, m.v.y, m.v.z, m.w.x, m.w.y, m.w.z, m.dp.x, m.dp.y];
        self.motion = [m.dp.z, m.dr.x, m.dr.y, m.dr.z, m.dq.x, m.dq.y, m.dq.z, m.dq.w];
    }
    /// Starts a step: no motion yet.
    pub fn rewind(&mut self) {
        (self.hot[6], self.hot[7], self.motion) = (0.0, 0.0, Self::FIXED.motion);
    }
}

/// What the integrator reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BodyStep {
    /// Force accumulator, N, cleared by every step.
    pub force: Vec3,
    /// Torque accumulator, N m.
    pub torque: Vec3,
    /// Acceleration of the step without contacts: gravity and forces, m/s².
    pub acceleration: Vec3,
    pub inv_mass: f32,
    pub linear_damping: f32,
    pub angular_damping: f32,
    pub gravity_scale: f32,
    pub kind: BodyKind,
    /// Bits 0–2: linear locks; 3–5: angular locks.
    pub locks: u8,
    pub isotropic: bool,
    pub fast_rotation: bool,
    /// Body slot.
    pub body: u32,
    /// How many times its mass the body was given in the last step, for the load it carries; 1 as a rule.
    pub raised: f32,
    /// Continuous collision stopped the body where it was: two for each time, less one for each step.
    pub halted: u8,
    /// Seconds at rest.
    pub sleep_timer: f32,
    pub sleep_speed: f32,
    /// Of a body on joints: velocity and spin by the ways it made, averaged over the last [`super::finish::DRIFT_TIME`].
    pub drift: [Vec3; 2],
    /// The same over a longer time: what swings is between two ways where both are not alike.
    pub swing: [Vec3; 2],
    /// Kinematic target for the next step.
    pub target: Option<WorldPose>,
    /// The velocity came from a target: it ends with the step.
    pub guided: bool,
    /// How far any of its points may still go before one of its shapes could leave its fat bounds, m.
    pub room: f32,
    /// How far the farthest of its points went in the last step, at most, m, and 2 sin(θ/2) of its turn, at most; goes to `World::travel`.
    pub moved: [f32; 2],
    /// Copies of [`Mass::outer_radius`] and [`Mass::reach`].
    pub radius: f32,
    pub reach: Vec3,
}

/// Torque-free motion in full precision, of bodies with unequal moments: reused as long as the rounded values that the rest
/// of the step works with are still those it gave, so that rounding to f32 leaks neither momentum nor energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turning {
    /// Angular momentum, world axes, with the ω it gave.
    pub momentum: DVec3,
    pub w: Vec3,
    /// World from principal axes.
    pub q: DQuat,
    /// The body's rotation at the start of the step, and since then, that belong to `q`.
    pub rotation: Quat,
    pub dq: Quat,
    /// World from principal axes at the start of the step: that of `rotation`.
    pub frozen: DQuat,
}

impl Turning {
    /// Of what does not turn.
    pub const NOTHING: Self = Self {
        momentum: DVec3::ZERO,
        w: Vec3::ZERO,
        q: DQuat::IDENTITY,
        rotation: Quat::IDENTITY,
        dq: Quat::IDENTITY,
        frozen: DQuat::IDENTITY,
    };
    /// Has nothing else turned the body since its last turn in this step? (What belongs to another step is forgotten at its start.)
    #[inline(always)]
    pub fn is_of(&self, s: &BodyState) -> bool {
        let [.., x, y, z, w] = s.motion;
        self.dq == Quat::new(x, y, z, w)
    }
}

/// World inverse inertia, frozen for contacts within a step: xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct InvInertia {
    pub xx: f32,
    pub yy: f32,
    pub zz: f32,
    pub xy: f32,
    pub xz: f32,
    pub yz: f32,
    /// Inverse mass rides along: whoever loads the tensor wants it too.
    pub inv_mass: f32,
    pub pad: f32,
}

impl InvInertia {
    /// Of what cannot be moved.
    pub const FIXED: Self =
        Self { xx: 0.0, yy: 0.0, zz: 0.0, xy: 0.0, xz: 0.0, yz: 0.0, inv_mass: 0.0, pad: 0.0 };
    /// All of it, in the order of memory.
    #[inline(always)]
    pub fn lanes(&self) -> [f32; 8] {
        [self.xx, self.yy, self.zz, self.xy, self.xz, self.yz, self.inv_mass, self.pad]
    }
    #[inline(always)]
    pub fn mul(&self, v: Vec3) -> Vec3 {
        Vec3::new(
            self.xx * v.x + self.xy * v.y + self.xz * v.z,
            self.xy * v.x + self.yy * v.y + self.yz * v.z,
            self.xz * v.x + self.yz * v.y + self.zz * v.z,
        )
    }
    /// Of the same for all axes: a number.
    pub fn round(k: f32, inv_mass: f32) -> Self {
        Self { xx: k, yy: k, zz: k, inv_mass, ..Self::FIXED }
    }
    /// Whether it is the same for all axes.
    #[inline(always)]
    pub fn is_round(&self) -> bool {
        self.xx == self.yy && self.xx == self.zz && self.xy == 0.0 && self.xz == 0.0 && self.yz == 0.0
    }
    /// R I⁻¹ Rᵀ with locked axes made immovable.
    pub fn new(rotation: Quat, inv_inertia: &Mat3, inv_mass: f32, locks: u8) -> Self {
        let mut t = if *inv_inertia == Mat3::IDENTITY.scale(inv_inertia.cx.x) {
            Self::round(inv_inertia.cx.x, inv_mass)
        } else {
            let r = rotation.to_mat3();
            let m = r * *inv_inertia * r.transpose();
            Self {
                xx: m.cx.x,
                yy: m.cy.y,
                zz: m.cz.z,
                xy: 0.5 * (m.cx.y + m.cy.x),
                xz: 0.5 * (m.cx.z + m.cz.x),
                yz: 0.5 * (m.cy.z + m.cz.y),
                inv_mass,
                pad: 0.0,
            }
        };
        if locks & 8 != 0 {
            (t.xx, t.xy, t.xz) = (0.0, 0.0, 0.0);
        }
        if locks & 16 != 0 {
            (t.yy, t.xy, t.yz) = (0.0, 0.0, 0.0);
        }
        if locks & 32 != 0 {
            (t.zz, t.xz, t.yz) = (0.0, 0.0, 0.0);
        }
        t
    }
    /// Turns less easily by a factor.
    pub fn scaled(self, k: f32) -> Self {
        Self {
            xx: self.xx * k,
            yy: self.yy * k,
            zz: self.zz * k,
            xy: self.xy * k,
            xz: self.xz * k,
            yz: self.yz * k,
            ..self
        }
    }
    pub fn to_mat3(self) -> Mat3 {
        Mat3::from_columns(
            Vec3::new(self.xx, self.xy, self.xz),
            Vec3::new(self.xy, self.yy, self.yz),
            Vec3::new(self.xz, self.yz, self.zz),
        )
    }
}

/// The awake moving bodies: dense columns of equal length.
#[derive(Clone, Debug, Default)]
pub(crate) struct Awake {
    pub state: Vec<BodyState>,
    pub step: Vec<BodyStep>,
    pub turning: Vec<Option<Turning>>,
    pub inertia: Vec<InvInertia>,
    /// Counts what makes rows other than they were: bodies that come, go or move to another row, their kinds, masses and locks.
    pub changes: u64,
}

pub(crate) fn lock_bits(l: &AxisLocks) -> u8 {
    (0..3).fold(0, |b, i| b | (u8::from(l.linear[i]) << i) | (u8::from(l.angular[i]) << (i + 3)))
}
