//! What a vehicle tells.

use super::desc::{VehicleDesc, VehicleInput};
use super::engine::{RPM, ratio};
use super::state::{Vehicle, WheelState};
use crate::error::{Result, check};
use crate::handle::{BodyId, ShapeId, VehicleId};
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_math::{DVec3, Pose, Quat, Vec3, WorldPose};

/// A vehicle, to be read.
#[derive(Clone, Copy)]
pub struct VehicleRef<'a> {
    world: &'a World,
    vehicle: &'a Vehicle,
}

impl core::fmt::Debug for VehicleRef<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("VehicleRef").field("telemetry", &self.telemetry()).finish_non_exhaustive()
    }
}

/// How a vehicle drives, after the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VehicleTelemetry {
    /// Speed along the vehicle, m/s; negative backwards.
    pub speed: f32,
    /// Engine speed, 1/min; 0 without engine.
    pub rpm: f32,
    /// Gear: −1 reverse, 0 neutral.
    pub gear: i32,
    /// A change of gear is under way.
    pub shifting: bool,
    /// Torque through the clutch, N m.
    pub clutch_torque: f32,
    /// Turns of the engine per turn of the wheels; 0 in neutral.
    pub ratio: f32,
    /// Share of the throttle that traction control lets through, 0 to 1.
    pub traction: f32,
    /// Lean to the right, rad.
    pub lean: f32,
    /// Wheels (or stations of a board) on the ground.
    pub grounded: u32,
}

/// A wheel (or a station of a board) after the last step; forces are those of its last substep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelTelemetry {
    /// Body it stands on.
    pub ground: Option<BodyId>,
    /// Shape it stands on.
    pub shape: Option<ShapeId>,
    /// Where, world.
    pub point: DVec3,
    /// Normal of the ground, world.
    pub normal: Vec3,
    /// Load N on the ground, N.
    pub load: f32,
    /// Force of the ground on the wheel along it, N.
    pub longitudinal_force: f32,
    /// And across, left positive, N.
    pub lateral_force: f32,
    /// Slip ratio: (Ω R − v)/max(|v|, |Ω R|, 1 m/s).
    pub slip_ratio: f32,
    /// Slip angle: atan of the velocity across over that along, rad.
    pub slip_angle: f32,
    /// μ in force.
    pub friction: f32,
    /// Spin against the chassis, rad/s; positive rolls forward.
    pub spin: f32,
    /// Angle it turned by, rad, within a turn.
    pub angle: f32,
    /// Angle of steering, rad, left positive.
    pub steer: f32,
    /// Travel from rest, m, down positive, and its speed, m/s.
    pub travel: f32,
    /// m/s.
    pub travel_speed: f32,
    /// Force of spring, damper and rubber on the chassis, N.
    pub suspension_force: f32,
    /// Torque of engine and brakes on it, N m.
    pub drive_torque: f32,
    /// Share of the brake's torque that ABS lets through, 0 to 1.
    pub abs: f32,
}

impl<'a> VehicleRef<'a> {
    /// Its description.
    pub fn desc(&self) -> &'a VehicleDesc {
        &self.vehicle.desc
    }
    /// What the driver does.
    pub fn input(&self) -> VehicleInput {
        self.vehicle.input
    }
    /// Its chassis.
    pub fn chassis(&self) -> BodyId {
        self.world.body_id(self.vehicle.chassis)
    }
    /// Its name.
    pub fn name(&self) -> Option<&'a str> {
        self.vehicle.desc.name.as_deref()
    }
    /// The caller's number.
    pub fn user_data(&self) -> u128 {
        self.vehicle.desc.user_data
    }
    /// Takes part in the simulation.
    pub fn is_enabled(&self) -> bool {
        self.vehicle.enabled
    }
    /// How it drives.
    pub fn telemetry(&self) -> VehicleTelemetry {
        let v = self.vehicle;
        let frame = &self.world.frames[v.chassis as usize];
        let (velocity, _) = self.world.velocities(&self.world.bodies[v.chassis]);
        let forward = frame.rotation.rotate(v.desc.forward);
        let (up, left) = (v.desc.up, v.desc.up.cross(v.desc.forward));
        let sky = -self.world.gravity.normalize_or(-Vec3::Y);
        let sky = frame.rotation.inverse_rotate(sky);
        VehicleTelemetry {
            speed: velocity.dot(forward),
            rpm: v.engine * RPM,
            gear: v.shifter.gear,
            shifting: v.shifter.is_shifting(),
            clutch_torque: v.clutch,
            ratio: v.desc.drive.as_ref().map_or(0.0, |d| ratio(&d.gearbox, v.shifter.gear)),
            traction: v.throttle,
            lean: jounce_math::scalar::f32s::atan2(sky.dot(left), sky.dot(up)),
            grounded: v.feet().filter(|w| w.seen.load > 0.0).count() as u32,
        }
    }
    /// Its wheels, in order, or the stations of its board: nose left, nose right, tail left, tail right.
    pub fn wheels(&self) -> impl Iterator<Item = WheelTelemetry> + 'a {
        let world = self.world;
        self.vehicle.feet().map(move |w| telemetry(world, w))
    }
    /// A wheel by its index.
    ///
    /// # Errors
    /// No such wheel.
    pub fn wheel(&self, index: usize) -> Result<WheelTelemetry> {
        let found = self.vehicle.feet().nth(index);
        check(found.is_some(), "vehicle", "wheel", index, "below the number of wheels")?;
        Ok(found.map_or_else(WheelTelemetry::default, |w| telemetry(self.world, w)))
    }
    /// Where a wheel stands in the world, to draw it: its x axis is the axle (to the left), turned by steering and spin.
    ///
    /// # Errors
    /// No such wheel.
    pub fn wheel_pose(&self, index: usize) -> Result<WorldPose> {
        let v = self.vehicle;
        check(index < v.wheels.len(), "vehicle", "wheel", index, "below the number of wheels")?;
        let (w, d) = (&v.wheels[index], &v.desc.wheels[index]);
        let left = v.desc.up.cross(v.desc.forward);
        let basis = jounce_math::Mat3::from_columns(left, v.desc.up, v.desc.forward);
        let q = Quat::from_axis_angle(v.desc.up, w.steer)
            * Quat::from_mat3(&basis)
            * Quat::from_axis_angle(Vec3::X, w.angle);
        let local = Pose::new(d.position - v.desc.up * w.s, q.normalize());
        Ok(self.world.frames[v.chassis as usize].pose().compose(&local))
    }
}

fn telemetry(world: &World, w: &WheelState) -> WheelTelemetry {
    let stands = w.ground != NONE && w.seen.load > 0.0 && world.bodies.get(w.ground).is_some();
    WheelTelemetry {
        ground: stands.then(|| world.body_id(w.ground)),
        shape: (stands && world.shapes.get(w.shape).is_some()).then(|| world.shape_id(w.shape)),
        point: w.seen.point,
        normal: w.seen.normal,
        load: w.seen.load,
        longitudinal_force: w.seen.force[0],
        lateral_force: w.seen.force[1],
        slip_ratio: w.seen.slip[0],
        slip_angle: w.seen.slip[1],
        friction: w.seen.friction,
        spin: w.x,
        angle: w.angle,
        steer: w.steer,
        travel: w.s,
        travel_speed: w.u,
        suspension_force: w.seen.suspension,
        drive_torque: w.seen.drive,
        abs: w.let_through,
    }
}

impl World {
    /// A vehicle, to be read.
    ///
    /// # Errors
    /// A stale handle.
    pub fn vehicle(&self, id: VehicleId) -> Result<VehicleRef<'_>> {
        let slot = self.vehicle_slot(id)?;
        Ok(VehicleRef { world: self, vehicle: &self.vehicles.table[slot] })
    }
    /// All vehicles, in slot order.
    pub fn vehicles(&self) -> impl Iterator<Item = VehicleId> + '_ {
        self.vehicles.table.iter().map(|(i, _)| self.vehicle_id(i))
    }
    /// The vehicle whose chassis a body is.
    ///
    /// # Errors
    /// A stale handle.
    pub fn vehicle_of(&self, body: BodyId) -> Result<Option<VehicleId>> {
        let slot = self.bodies[self.slot(body)?].vehicle;
        Ok((slot != NONE).then(|| self.vehicle_id(slot)))
    }
}
