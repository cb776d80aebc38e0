//! Vehicles to start from: each a body and what is under it.
//!
//! The body's origin is on the ground under the vehicle's middle; it drives to +z. The numbers are those of common vehicles of each kind,
//! rounded (Gillespie 1992; data sheets), not of a make.

use super::desc::{
    AeroSurfaceDesc, AntiRollDesc, BoardDesc, ClutchDesc, DifferentialDesc, DifferentialKind, DriveDesc,
    EngineDesc, GearboxDesc, LeanDesc, SlipControlDesc, TrackDesc, TrackSteerDesc, TyreDesc, VehicleDesc,
    WheelDesc,
};
use crate::error::Result;
use crate::handle::{BodyId, VehicleId};
use crate::room::contacts::desc::ShapeDesc;
use crate::room::rigid::desc::BodyDesc;
use crate::world::World;
use jounce_geometry::MassProperties;
use jounce_math::{DVec3, Mat3, Quat, Vec3};
use jounce_tasks::FloatEnv;

/// A body and the vehicle on it, to be changed before they are added.
#[derive(Clone, Debug)]
pub struct VehicleKit {
    /// The chassis.
    pub body: BodyDesc,
    /// The rest; `chassis` is set by [`VehicleKit::add`].
    pub vehicle: VehicleDesc,
}

impl VehicleKit {
    /// Adds both, the body's origin at a place, turned.
    ///
    /// # Errors
    /// A description out of range, named; nothing is added then.
    ///
    /// ```
    /// use jounce::prelude::*;
    ///
    /// # fn main() -> jounce::Result<()> {
    /// let mut world = World::new(WorldDesc::default())?;
    /// world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).friction(1.0)))?;
    /// let car = jounce::vehicles::car().add(&mut world, [0.0; 3], Quat::IDENTITY)?;
    /// world.set_vehicle_input(car, VehicleInput::drive(1.0, 0.0))?;
    /// for _ in 0..120 {
    ///     world.step()?;
    /// }
    /// assert!(world.vehicle(car)?.telemetry().speed > 3.0);
    /// # Ok(())
    /// # }
    /// ```
    pub fn add(self, world: &mut World, at: impl Into<DVec3>, rotation: Quat) -> Result<VehicleId> {
        self.vehicle.check()?;
        let mut body = self.body;
        (body.position, body.rotation) = (at.into(), rotation);
        let chassis = world.add_body(body)?;
        let added = world.add_vehicle(VehicleDesc { chassis, ..self.vehicle });
        if added.is_err() {
            world.remove_body(chassis)?;
        }
        added
    }
}

/// Standard gravity that presets are balanced for, m/s².
const G: f32 = 9.81;

fn mass(mass: f32, center: [f32; 3], inertia: [f32; 3]) -> MassProperties {
    MassProperties { mass, center: Vec3::from(center), inertia: Mat3::from_diagonal(Vec3::from(inertia)) }
}

/// Springs of the wheels for a mass and its centre along +z: loads linear in z, and hubs lowered by what tyres give.
pub fn carry(wheels: &mut [WheelDesc], mass: f32, center_z: f32) {
    let _mode = FloatEnv::set_default();
    let n = wheels.len() as f32;
    if wheels.is_empty() {
        return;
    }
    let mean = wheels.iter().map(|w| w.position.z).sum::<f32>() / n;
    let spread: f32 = wheels.iter().map(|w| (w.position.z - mean) * (w.position.z - mean)).sum();
    for w in wheels {
        let share = 1.0 / n;
        let tilt = if spread > 0.0 { (center_z - mean) * (w.position.z - mean) / spread } else { 0.0 };
        w.preload = mass * G * (share + tilt);
        w.position.y = w.radius - w.preload / w.tyre.radial_stiffness;
    }
}

fn placeholder() -> VehicleDesc {
    VehicleDesc::new(BodyId::from_bits(u64::MAX))
}

fn car_like(body: BodyDesc, front_z: f32, rear_z: f32, half_track: f32, w: WheelDesc) -> VehicleKit {
    let mut vehicle = placeholder();
    for (z, x) in [(front_z, half_track), (front_z, -half_track), (rear_z, half_track), (rear_z, -half_track)]
    {
        let mut wheel = w;
        wheel.position = Vec3::new(x, w.radius, z);
        if z == front_z {
            wheel.steer = 0.6;
        } else {
            (wheel.brake, wheel.handbrake) = (0.6 * w.brake, 2500.0);
        }
        vehicle.wheels.push(wheel);
    }
    VehicleKit { body, vehicle }
}

fn slip(slip: f32) -> Option<SlipControlDesc> {
    Some(SlipControlDesc { slip, rate: 10.0 })
}

/// A front-wheel drive car: 1,300 kg, wheelbase 2.6 m, automatic gearbox, ABS and traction control. Wheels: front left, front right,
/// rear left, rear right.
pub fn car() -> VehicleKit {
    let _mode = FloatEnv::set_default();
    let m = mass(1300.0, [0.0, 0.5, 0.1], [1900.0, 2100.0, 480.0]);
    let body = BodyDesc::dynamic()
        .mass(m)
        .shape(ShapeDesc::cuboid([0.8, 0.28, 2.0]).at([0.0, 0.55, 0.0]).friction(0.4))
        .shape(ShapeDesc::cuboid([0.65, 0.25, 1.0]).at([0.0, 1.08, -0.2]).friction(0.4));
    let mut kit = car_like(body, 1.3, -1.3, 0.75, WheelDesc::new([0.0; 3], 0.0));
    carry(&mut kit.vehicle.wheels, 1300.0, 0.1);
    let v = &mut kit.vehicle;
    v.anti_roll = vec![
        AntiRollDesc { left: 0, right: 1, stiffness: 12_000.0 },
        AntiRollDesc { left: 2, right: 3, stiffness: 9000.0 },
    ];
    v.drive = Some(DriveDesc {
        engine: EngineDesc {
            torque: vec![(800.0, 90.0), (2000.0, 140.0), (4000.0, 160.0), (5500.0, 145.0), (6500.0, 110.0)],
            inertia: 0.15,
            idle_rpm: 850.0,
            limit_rpm: 6500.0,
            drag: 25.0,
        },
        clutch: ClutchDesc { torque: 280.0, auto_rpm: Some((900.0, 2400.0)) },
        gearbox: GearboxDesc {
            forward: vec![3.6, 2.1, 1.4, 1.05, 0.85],
            reverse: 3.4,
            final_drive: 4.0,
            shift_s: 0.25,
            auto_rpm: Some((5600.0, 2300.0)),
        },
        axles: vec![DifferentialDesc { left: 0, right: 1, kind: DifferentialKind::Open, share: 1.0 }],
        center: DifferentialKind::Open,
    });
    (v.abs, v.traction) = (slip(0.1), slip(0.1));
    let air = AeroSurfaceDesc {
        position: Vec3::new(0.0, 0.5, 0.0),
        drag_area: 0.65,
        down_area: 0.0,
        density: crate::AIR_DENSITY,
    };
    v.aero = vec![air];
    kit
}

/// A rear-wheel drive sports car with a limited-slip differential, a gearbox by hand and wings; no electronics.
pub fn sports_car() -> VehicleKit {
    let _mode = FloatEnv::set_default();
    let m = mass(1200.0, [0.0, 0.42, -0.1], [1600.0, 1800.0, 420.0]);
    let body = BodyDesc::dynamic()
        .mass(m)
        .shape(ShapeDesc::cuboid([0.9, 0.22, 2.1]).at([0.0, 0.45, 0.0]).friction(0.4))
        .shape(ShapeDesc::cuboid([0.6, 0.2, 0.7]).at([0.0, 0.87, -0.3]).friction(0.4));
    let tyre = TyreDesc {
        static_friction: 1.3,
        kinetic_friction: 1.1,
        slip_stiffness: 25.0,
        cornering_stiffness: 22.0,
        radial_stiffness: 250_000.0,
        ..TyreDesc::default()
    };
    let w = WheelDesc {
        radius: 0.32,
        width: 0.26,
        mass: 18.0,
        bump: 0.08,
        droop: 0.1,
        stiffness: 60_000.0,
        bump_damping: 4000.0,
        rebound_damping: 6000.0,
        brake: 3500.0,
        tyre,
        ..WheelDesc::new([0.0; 3], 0.0)
    };
    let mut kit = car_like(body, 1.25, -1.25, 0.78, w);
    carry(&mut kit.vehicle.wheels, 1200.0, -0.1);
    let v = &mut kit.vehicle;
    v.anti_roll = vec![
        AntiRollDesc { left: 0, right: 1, stiffness: 20_000.0 },
        AntiRollDesc { left: 2, right: 3, stiffness: 12_000.0 },
    ];
    v.drive = Some(DriveDesc {
        engine: EngineDesc {
            torque: vec![(1000.0, 250.0), (3000.0, 380.0), (6000.0, 420.0), (8000.0, 350.0)],
            inertia: 0.12,
            idle_rpm: 1000.0,
            limit_rpm: 8000.0,
            drag: 40.0,
        },
        clutch: ClutchDesc { torque: 700.0, auto_rpm: Some((1100.0, 3000.0)) },
        gearbox: GearboxDesc {
            forward: vec![3.1, 2.2, 1.65, 1.3, 1.05, 0.88],
            reverse: 3.0,
            final_drive: 3.6,
            shift_s: 0.1,
            auto_rpm: None,
        },
        axles: vec![DifferentialDesc {
            left: 2,
            right: 3,
            kind: DifferentialKind::LimitedSlip { preload: 60.0, lock: 0.4 },
            share: 1.0,
        }],
        center: DifferentialKind::Open,
    });
    let air = |z: f32, drag_area, down_area| AeroSurfaceDesc {
        position: Vec3::new(0.0, 0.4, z),
        drag_area,
        down_area,
        density: crate::AIR_DENSITY,
    };
    v.aero = vec![air(1.25, 0.35, 0.5), air(-1.25, 0.35, 0.6)];
    kit
}

/// An all-wheel drive car for rough ground: long travel, locked differentials, automatic gearbox.
pub fn off_road() -> VehicleKit {
    let _mode = FloatEnv::set_default();
    let m = mass(2000.0, [0.0, 0.8, 0.0], [3200.0, 3400.0, 900.0]);
    let body = BodyDesc::dynamic()
        .mass(m)
        .shape(ShapeDesc::cuboid([0.85, 0.35, 2.0]).at([0.0, 0.95, 0.0]).friction(0.4))
        .shape(ShapeDesc::cuboid([0.75, 0.3, 1.2]).at([0.0, 1.6, -0.3]).friction(0.4));
    let tyre = TyreDesc {
        static_friction: 0.9,
        kinetic_friction: 0.8,
        cornering_stiffness: 12.0,
        ..TyreDesc::default()
    };
    let w = WheelDesc {
        radius: 0.4,
        width: 0.28,
        mass: 35.0,
        inertia: 2.8,
        bump: 0.2,
        droop: 0.25,
        stiffness: 32_000.0,
        bump_damping: 3000.0,
        rebound_damping: 4000.0,
        brake: 3500.0,
        tyre,
        ..WheelDesc::new([0.0; 3], 0.0)
    };
    let mut kit = car_like(body, 1.4, -1.4, 0.8, w);
    carry(&mut kit.vehicle.wheels, 2000.0, 0.0);
    let v = &mut kit.vehicle;
    let locked =
        |left, share| DifferentialDesc { left, right: left + 1, kind: DifferentialKind::Locked, share };
    v.drive = Some(DriveDesc {
        engine: EngineDesc {
            torque: vec![(700.0, 250.0), (1800.0, 420.0), (3500.0, 400.0), (4500.0, 300.0)],
            inertia: 0.3,
            idle_rpm: 750.0,
            limit_rpm: 4600.0,
            drag: 50.0,
        },
        clutch: ClutchDesc { torque: 700.0, auto_rpm: Some((800.0, 1800.0)) },
        gearbox: GearboxDesc {
            forward: vec![4.0, 2.3, 1.5, 1.1, 0.85],
            reverse: 3.8,
            final_drive: 4.1,
            shift_s: 0.3,
            auto_rpm: Some((3900.0, 1600.0)),
        },
        axles: vec![locked(0, 0.5), locked(2, 0.5)],
        center: DifferentialKind::Locked,
    });
    v.abs = slip(0.1);
    kit
}

/// A motorcycle with its rider: 260 kg, leans into its turns. Wheels: front, rear.
pub fn motorcycle() -> VehicleKit {
    let _mode = FloatEnv::set_default();
    let m = mass(260.0, [0.0, 0.6, 0.0], [42.0, 30.0, 18.0]);
    let body = BodyDesc::dynamic()
        .mass(m)
        .shape(ShapeDesc::cuboid([0.15, 0.2, 0.6]).at([0.0, 0.6, 0.0]).friction(0.5))
        .shape(ShapeDesc::capsule(0.3, 0.2).at([0.0, 1.2, -0.15]).friction(0.5));
    let mut vehicle = placeholder();
    let tyre = TyreDesc {
        static_friction: 1.1,
        kinetic_friction: 0.9,
        cornering_stiffness: 18.0,
        radial_stiffness: 150_000.0,
        nominal_load: 1300.0,
        ..TyreDesc::default()
    };
    for front in [true, false] {
        vehicle.wheels.push(WheelDesc {
            radius: 0.3,
            width: if front { 0.12 } else { 0.18 },
            mass: 14.0,
            inertia: 0.6,
            bump: 0.1,
            droop: 0.08,
            stiffness: 20_000.0,
            bump_damping: 1200.0,
            rebound_damping: 1800.0,
            steer: if front { 0.5 } else { 0.0 },
            brake: if front { 600.0 } else { 300.0 },
            handbrake: if front { 0.0 } else { 300.0 },
            tyre,
            ..WheelDesc::new([0.0, 0.3, if front { 0.7 } else { -0.7 }], 0.0)
        });
    }
    carry(&mut vehicle.wheels, 260.0, 0.0);
    vehicle.lean = Some(LeanDesc { angle_max: 0.75, hertz: 2.0, damping_ratio: 1.0, wheelbase: 1.4 });
    vehicle.drive = Some(DriveDesc {
        engine: EngineDesc {
            torque: vec![(1500.0, 60.0), (5000.0, 85.0), (8000.0, 95.0), (11_000.0, 75.0)],
            inertia: 0.03,
            idle_rpm: 1200.0,
            limit_rpm: 11_000.0,
            drag: 10.0,
        },
        clutch: ClutchDesc { torque: 180.0, auto_rpm: Some((1400.0, 4000.0)) },
        gearbox: GearboxDesc {
            forward: vec![2.7, 2.0, 1.6, 1.35, 1.15, 1.0],
            reverse: 2.7,
            final_drive: 4.6,
            shift_s: 0.12,
            auto_rpm: Some((9000.0, 4500.0)),
        },
        axles: vec![DifferentialDesc { left: 1, right: 1, kind: DifferentialKind::Open, share: 1.0 }],
        center: DifferentialKind::Open,
    });
    (vehicle.abs, vehicle.traction) = (slip(0.1), slip(0.1));
    vehicle.aero = vec![AeroSurfaceDesc {
        position: Vec3::new(0.0, 0.6, 0.0),
        drag_area: 0.4,
        down_area: 0.0,
        density: crate::AIR_DENSITY,
    }];
    VehicleKit { body, vehicle }
}

/// A tracked vehicle of 20 t with five road wheels a side (left side first, front to rear); turns on the spot.
pub fn tank() -> VehicleKit {
    let _mode = FloatEnv::set_default();
    let m = mass(20_000.0, [0.0, 1.1, 0.0], [60_000.0, 70_000.0, 25_000.0]);
    let body = BodyDesc::dynamic()
        .mass(m)
        .shape(ShapeDesc::cuboid([1.4, 0.4, 2.8]).at([0.0, 1.1, 0.0]).friction(0.5))
        .shape(ShapeDesc::cuboid([0.9, 0.35, 1.2]).at([0.0, 1.85, -0.2]).friction(0.5));
    let mut vehicle = placeholder();
    let tyre = TyreDesc {
        static_friction: 0.9,
        kinetic_friction: 0.8,
        slip_stiffness: 15.0,
        cornering_stiffness: 8.0,
        relaxation_length: 0.15,
        radial_stiffness: 1_500_000.0,
        radial_damping: 8000.0,
        rolling_resistance: 0.03,
        nominal_load: 20_000.0,
        ..TyreDesc::default()
    };
    for x in [1.2, -1.2] {
        for i in 0..5 {
            vehicle.wheels.push(WheelDesc {
                radius: 0.35,
                width: 0.5,
                mass: 150.0,
                inertia: 20.0,
                bump: 0.18,
                droop: 0.2,
                stiffness: 180_000.0,
                bump_damping: 15_000.0,
                rebound_damping: 20_000.0,
                bump_stop_stiffness: 1_000_000.0,
                brake: 12_000.0,
                handbrake: 12_000.0,
                tyre,
                ..WheelDesc::new([x, 0.35, 1.8 - 0.9 * i as f32], 0.0)
            });
        }
    }
    carry(&mut vehicle.wheels, 20_000.0, 0.0);
    vehicle.tracks = vec![TrackDesc { wheels: (0..5).collect() }, TrackDesc { wheels: (5..10).collect() }];
    vehicle.track_steer = Some(TrackSteerDesc { left: 0, right: 5, speed: 8.0, torque: 60_000.0 });
    vehicle.drive = Some(DriveDesc {
        engine: EngineDesc {
            torque: vec![(800.0, 1800.0), (1400.0, 2400.0), (2200.0, 2000.0)],
            inertia: 4.0,
            idle_rpm: 700.0,
            limit_rpm: 2300.0,
            drag: 200.0,
        },
        clutch: ClutchDesc { torque: 4500.0, auto_rpm: Some((750.0, 1400.0)) },
        gearbox: GearboxDesc {
            forward: vec![5.0, 3.2, 2.1, 1.4],
            reverse: 5.0,
            final_drive: 4.0,
            shift_s: 0.4,
            auto_rpm: Some((2050.0, 1000.0)),
        },
        axles: vec![DifferentialDesc { left: 0, right: 5, kind: DifferentialKind::Open, share: 1.0 }],
        center: DifferentialKind::Open,
    });
    VehicleKit { body, vehicle }
}

/// A snowboarder of 80 kg who rides along +z, on a board with a side-cut of 8 m.
pub fn snowboard() -> VehicleKit {
    let _mode = FloatEnv::set_default();
    let m = mass(80.0, [0.0, 0.8, 0.0], [12.0, 5.0, 10.0]);
    let body =
        BodyDesc::dynamic().mass(m).shape(ShapeDesc::capsule(0.45, 0.25).at([0.0, 0.85, 0.0]).friction(0.1));
    let mut vehicle = placeholder();
    vehicle.board = Some(BoardDesc {
        position: Vec3::ZERO,
        length: 1.2,
        width: 0.26,
        sidecut: 8.0,
        friction: 0.04,
        edge_friction: 1.5,
        edge_angle: 0.12,
        lean_max: 1.0,
        hertz: 2.5,
        damping_ratio: 1.0,
        stiffness: 40_000.0,
        damping: 2500.0,
        reach: 0.3,
        jump_speed: 3.0,
    });
    vehicle.aero = vec![AeroSurfaceDesc {
        position: Vec3::new(0.0, 0.8, 0.0),
        drag_area: 0.5,
        down_area: 0.0,
        density: crate::AIR_DENSITY,
    }];
    VehicleKit { body, vehicle }
}
