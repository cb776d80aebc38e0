//! Records of vehicles.

use super::desc::{VehicleDesc, VehicleInput};
use super::engine::Shifter;
use crate::hash::StateHasher;
use crate::room::rigid::state::{BodyFrame, NONE};
use crate::table::Table;
use crate::world::Momentum;
use jounce_math::{DVec3, Quat, Vec3, scalar::f32s};

/// A wheel, or a station of a board's edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WheelState {
    /// Travel (down positive), m, and its speed, m/s.
    pub s: f32,
    pub u: f32,
    /// Spin against the chassis, rad/s, and angle, rad.
    pub x: f32,
    pub angle: f32,
    /// Angle of steering, rad, left positive.
    pub steer: f32,
    /// Deflection of the tyre along and across, m.
    pub e: [f32; 2],
    /// From where all of the patch begins to slide (0) to a locked tyre (1), in the last substep.
    pub sliding: f32,
    /// Depth in the ground in the last substep, m, and the part of it that it did not come to by moving: that gives no spring's force,
    /// and goes at the speed of pushing out.
    pub depth: f32,
    pub sunk: f32,
    /// Share of the brake's torque that ABS lets through.
    pub let_through: f32,
    /// Impulse about the axle by the tyre in the last substep, N m s.
    pub tyre_torque: f32,
    /// What it stands on: body and shape slot, or NONE.
    pub ground: u32,
    pub shape: u32,
    pub seen: Seen,
}

/// What telemetry tells of a wheel; of the last substep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Seen {
    pub load: f32,
    pub force: [f32; 2],
    pub slip: [f32; 2],
    pub friction: f32,
    pub suspension: f32,
    pub drive: f32,
    pub point: DVec3,
    pub normal: Vec3,
}

impl Default for WheelState {
    fn default() -> Self {
        Self {
            s: 0.0,
            u: 0.0,
            x: 0.0,
            angle: 0.0,
            steer: 0.0,
            e: [0.0; 2],
            sliding: 0.0,
            depth: 0.0,
            sunk: 0.0,
            let_through: 1.0,
            tyre_torque: 0.0,
            ground: NONE,
            shape: NONE,
            seen: Seen::default(),
        }
    }
}

impl WheelState {
    /// Nothing moves any more; what holds it where it stands stays.
    pub fn rest(&mut self) {
        (self.u, self.x, self.tyre_torque, self.sliding) = (0.0, 0.0, 0.0, 0.0);
    }
    fn is_finite(&self) -> bool {
        let e = self.e;
        [
            self.s,
            self.u,
            self.x,
            self.angle,
            e[0],
            e[1],
            self.tyre_torque,
            self.sliding,
            self.depth,
            self.sunk,
        ]
        .iter()
        .all(|x| x.is_finite())
    }
    /// The depth that counts for springs: what was entered by moving, at most `way` (and `slack`) farther than in the last substep. The
    /// rest becomes depth that counts by at most `push_out` in a substep, less what it came up by itself, and only up to `slack`: so it lifts gently,
    /// and a jam stores nothing.
    pub fn entered(&mut self, depth: f32, way: f32, slack: f32, push_out: f32) -> f32 {
        let depth = f32s::max(depth, 0.0);
        let fresh = f32s::max(depth - self.depth - way - slack, 0.0);
        let sunk = f32s::min(self.sunk + fresh, depth);
        let lifts = f32s::clamp(push_out - (self.depth - depth), 0.0, push_out);
        let less = f32s::min(lifts, f32s::max(slack - (depth - sunk), 0.0));
        self.sunk = f32s::max(sunk - less, 0.0);
        self.depth = depth;
        depth - self.sunk
    }
}

/// Momentum of travels and spins as the last substep left it, and where and how the chassis was (so that a jump of it is seen).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Carried {
    pub linear: Vec3,
    pub angular: Vec3,
    pub center: DVec3,
    pub rotation: Quat,
}

/// A vehicle.
#[derive(Clone, Debug)]
pub(crate) struct Vehicle {
    pub chassis: u32,
    pub desc: VehicleDesc,
    pub enabled: bool,
    pub input: VehicleInput,
    pub wheels: Vec<WheelState>,
    /// Of a board: nose left, nose right, tail left, tail right.
    pub stations: Vec<WheelState>,
    /// rad/s.
    pub engine: f32,
    pub shifter: Shifter,
    /// Share of the throttle that traction control lets through.
    pub throttle: f32,
    /// Torque through the clutch in the last substep, N m.
    pub clutch: f32,
    /// Which couplings hold.
    pub locked: Vec<bool>,
    pub carried: Option<Carried>,
    /// The jump was asked for already.
    pub jumped: bool,
}

impl Vehicle {
    pub fn is_finite(&self) -> bool {
        self.engine.is_finite() && self.wheels.iter().chain(&self.stations).all(WheelState::is_finite)
    }
    /// Everything that moves or remembers goes back to where it began.
    pub fn forget(&mut self) {
        for w in self.wheels.iter_mut().chain(&mut self.stations) {
            *w = WheelState { steer: w.steer, ..WheelState::default() };
        }
        self.engine = self.idle();
        self.locked.fill(false);
        (self.throttle, self.clutch, self.carried) = (1.0, 0.0, None);
    }
    /// Adds the momentum of its wheels on their travels and about their axles.
    pub fn add_momentum(&self, f: &BodyFrame, p: &mut Momentum) {
        // As the last substep left it: what turned since is taken from the chassis in the next one.
        if let Some(c) = self.carried.filter(|c| c.center == f.center && c.rotation == f.rotation) {
            let linear = c.linear.as_dvec3();
            p.linear += linear;
            p.angular += f.center.cross(linear) + c.angular.as_dvec3();
            return;
        }
        let (up, left) = (self.desc.up, self.desc.up.cross(self.desc.forward));
        for (w, d) in self.wheels.iter().zip(&self.desc.wheels) {
            let down = f.rotation.rotate(up * (-d.mass * w.u)).as_dvec3();
            let hub = f.center + f.rotation.rotate(d.position - up * w.s - f.local_center).as_dvec3();
            let axle = Quat::from_axis_angle(up, w.steer).rotate(left);
            p.linear += down;
            p.angular += hub.cross(down) + f.rotation.rotate(axle * (d.inertia * w.x)).as_dvec3();
        }
    }
    /// Idle speed, rad/s.
    pub fn idle(&self) -> f32 {
        self.desc.drive.as_ref().map_or(0.0, |d| d.engine.idle_rpm / super::engine::RPM)
    }
    /// Wheels and stations.
    pub fn feet(&self) -> impl Iterator<Item = &WheelState> {
        self.wheels.iter().chain(&self.stations)
    }
    pub fn stands_on(&self, body: u32) -> bool {
        self.feet().any(|w| w.ground == body)
    }
}

/// All vehicles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Vehicles {
    pub table: Table<Vehicle>,
}

impl Vehicles {
    pub fn is_empty(&self) -> bool {
        self.table.len() == 0
    }
    pub fn hash(&self, h: &mut StateHasher) {
        if self.table.slots() == 0 {
            return;
        }
        for w in self.table.allocator_words() {
            h.pair(w, 9);
        }
        for (i, v) in self.table.iter() {
            h.pair(i, v.chassis);
            let flags = u32::from(v.enabled) | (u32::from(v.jumped) << 1);
            h.pair(flags, v.input.gear as u32);
            let p = &v.input;
            h.floats(p.throttle, p.brake);
            h.floats(p.handbrake, p.steer);
            h.floats(p.clutch, p.lean);
            h.floats(p.jump, v.engine);
            h.floats(v.throttle, v.clutch);
            let s = &v.shifter;
            h.pair(s.gear as u32, s.next as u32);
            h.floats(s.left_s, s.since_s);
            v.locked.iter().for_each(|&l| h.pair(u32::from(l), 10));
            v.feet().for_each(|w| hash_wheel(h, w));
            if let Some(c) = &v.carried {
                h.vec3(c.linear);
                h.vec3(c.angular);
                h.dvec3(c.center);
                h.quat(c.rotation);
            }
        }
    }
}

fn hash_wheel(h: &mut StateHasher, w: &WheelState) {
    h.floats(w.s, w.u);
    h.floats(w.x, w.angle);
    h.floats(w.steer, w.let_through);
    h.floats(w.e[0], w.e[1]);
    h.pair(w.tyre_torque.to_bits(), w.ground);
    h.pair(w.shape, w.seen.load.to_bits());
    h.floats(w.seen.force[0], w.seen.force[1]);
    h.floats(w.seen.slip[0], w.seen.slip[1]);
    h.floats(w.seen.friction, w.seen.suspension);
    h.floats(w.seen.drive, w.sliding);
    h.floats(w.depth, w.sunk);
    h.dvec3(w.seen.point);
    h.vec3(w.seen.normal);
}
