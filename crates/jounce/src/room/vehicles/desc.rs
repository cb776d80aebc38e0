//! What users write about vehicles.

use crate::BodyId;
use crate::error::{Error, Result, check};
use crate::limits;
use jounce_math::Vec3;

/// How a wheel looks for the ground, in every substep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WheelCast {
    /// A cylinder of the wheel's size: sees kerbs and stairs as a wheel does.
    #[default]
    Cylinder,
    /// A ball of the wheel's radius: rounder on edges, but as wide as it is high.
    Sphere,
    /// A ray from the hub along the travel: cheap.
    Ray,
}

/// A tyre: springs on its way to the ground, and holds along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TyreDesc {
    /// Coulomb coefficient μ of the tread while it grips. It meets the ground's material by its rule
    /// ([`crate::Material::friction_combine`]; by default the geometric mean).
    pub static_friction: f32,
    /// The same once all of it slides; not above the static one.
    pub kinetic_friction: f32,
    /// C_x/N: longitudinal force per slip ratio and load, 1.
    pub slip_stiffness: f32,
    /// C_y/N: lateral force per slip angle and load, 1/rad.
    pub cornering_stiffness: f32,
    /// Way on which a force builds up, m.
    pub relaxation_length: f32,
    /// Spring against the ground, N/m.
    pub radial_stiffness: f32,
    /// Damper likewise, N s/m.
    pub radial_damping: f32,
    /// Torque against rolling ÷ (load × radius), 1.
    pub rolling_resistance: f32,
    /// Share of μ lost for each `nominal_load` beyond the first; 0 keeps Coulomb's law.
    pub load_sensitivity: f32,
    /// N.
    pub nominal_load: f32,
}

impl Default for TyreDesc {
    /// A passenger car's on dry asphalt.
    fn default() -> Self {
        Self {
            static_friction: 1.0,
            kinetic_friction: 0.8,
            slip_stiffness: 20.0,
            cornering_stiffness: 16.0,
            relaxation_length: 0.3,
            radial_stiffness: 200_000.0,
            radial_damping: 500.0,
            rolling_resistance: 0.012,
            load_sensitivity: 0.0,
            nominal_load: 4000.0,
        }
    }
}

/// A wheel on its suspension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelDesc {
    /// Hub at rest (travel 0), in the chassis' frame, m.
    pub position: Vec3,
    /// Radius, m; at most [`limits::WHEEL_SIZE_MAX`].
    pub radius: f32,
    /// Width, m, likewise; half of it is the radius of the tread's round.
    pub width: f32,
    /// Unsprung mass, kg. It is part of the chassis' mass, not added to it.
    pub mass: f32,
    /// About the axle, kg m².
    pub inertia: f32,
    /// How far it goes up from rest, m: a hard stop.
    pub bump: f32,
    /// How far it goes down, m.
    pub droop: f32,
    /// Force of the spring at rest, N: the wheel's share of the weight.
    pub preload: f32,
    /// Spring, N/m.
    pub stiffness: f32,
    /// Damper when the wheel goes up, N s/m.
    pub bump_damping: f32,
    /// Damper when it goes down, N s/m.
    pub rebound_damping: f32,
    /// Length of the rubber before the hard stop, m.
    pub bump_stop: f32,
    /// Spring of the rubber, N/m.
    pub bump_stop_stiffness: f32,
    /// Angle at full steering, rad; negative for wheels that steer the other way.
    pub steer: f32,
    /// Torque of the brake at full pedal, N m.
    pub brake: f32,
    /// Torque of the handbrake, N m.
    pub handbrake: f32,
    /// Its tyre.
    pub tyre: TyreDesc,
    /// How it looks for the ground.
    pub cast: WheelCast,
}

impl WheelDesc {
    /// A car's wheel: 0.3 m radius, 20 kg, a spring of 30 kN/m that carries `preload` (N) at rest, brakes but no steering.
    pub fn new(position: impl Into<Vec3>, preload: f32) -> Self {
        Self {
            position: position.into(),
            radius: 0.3,
            width: 0.2,
            mass: 20.0,
            inertia: 1.0,
            bump: 0.12,
            droop: 0.15,
            preload,
            stiffness: 30_000.0,
            bump_damping: 2500.0,
            rebound_damping: 3500.0,
            bump_stop: 0.04,
            bump_stop_stiffness: 150_000.0,
            steer: 0.0,
            brake: 2500.0,
            handbrake: 0.0,
            tyre: TyreDesc::default(),
            cast: WheelCast::default(),
        }
    }
}

/// A bar that resists two wheels' going up and down apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntiRollDesc {
    /// Index of the first wheel.
    pub left: usize,
    /// And of the second.
    pub right: usize,
    /// Force per difference of their travels, N/m.
    pub stiffness: f32,
}

/// An engine by its torque.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineDesc {
    /// Full torque: (1/min, N m), rising in 1/min; linear between, constant outside.
    pub torque: Vec<(f32, f32)>,
    /// Of crankshaft and flywheel, kg m².
    pub inertia: f32,
    /// Speed that it keeps by itself, 1/min.
    pub idle_rpm: f32,
    /// Speed from which it gets no fuel, 1/min.
    pub limit_rpm: f32,
    /// Torque against turning without throttle, N m.
    pub drag: f32,
}

/// The clutch between engine and gearbox.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClutchDesc {
    /// Most torque that it passes on, N m.
    pub torque: f32,
    /// Closes and opens by itself between these engine speeds, 1/min; `None` leaves it to the pedal.
    pub auto_rpm: Option<(f32, f32)>,
}

/// A gearbox.
#[derive(Clone, Debug, PartialEq)]
pub struct GearboxDesc {
    /// Ratios of the forward gears: turns of the engine per turn behind the gearbox.
    pub forward: Vec<f32>,
    /// Ratio of the reverse gear.
    pub reverse: f32,
    /// Ratio from there to the wheels.
    pub final_drive: f32,
    /// Time without drive in a change of gear, s.
    pub shift_s: f32,
    /// Changes up and down by itself at these speeds of its input, 1/min; `None`: by hand.
    pub auto_rpm: Option<(f32, f32)>,
}

/// What shares torque between two sides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum DifferentialKind {
    /// The same torque on both.
    #[default]
    Open,
    /// Holds the sides together with up to preload + lock × |torque in|.
    LimitedSlip {
        /// N m.
        preload: f32,
        /// 0 to 1 and above.
        lock: f32,
    },
    /// The same speed on both.
    Locked,
}

/// A driven axle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DifferentialDesc {
    /// Index of the left wheel.
    pub left: usize,
    /// Of the right one; the same index as `left` for a chain or shaft to one wheel.
    pub right: usize,
    /// How it shares torque.
    pub kind: DifferentialKind,
    /// Share of the torque that this axle gets, 0 to 1; together 1.
    pub share: f32,
}

/// From the engine to the wheels.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveDesc {
    /// Engine.
    pub engine: EngineDesc,
    /// Clutch.
    pub clutch: ClutchDesc,
    /// Gearbox.
    pub gearbox: GearboxDesc,
    /// Driven axles: one, or more for all-wheel drive.
    pub axles: Vec<DifferentialDesc>,
    /// Between neighbours of `axles`.
    pub center: DifferentialKind,
}

/// Wheels under one track: they turn at one surface speed.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackDesc {
    /// Indices of its wheels, at least two.
    pub wheels: Vec<usize>,
}

/// Steering by the difference of two tracks' speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackSteerDesc {
    /// Index of a wheel of the left track.
    pub left: usize,
    /// And of the right one.
    pub right: usize,
    /// Difference of the wheels' speeds at full steering, rad/s.
    pub speed: f32,
    /// Most torque for it, N m.
    pub torque: f32,
}

/// Keeps the slip of braked or driven wheels within bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlipControlDesc {
    /// Slip ratio from which it lets go.
    pub slip: f32,
    /// How fast it lets go and takes hold, full torques a second.
    pub rate: f32,
}

/// Air on the body, at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AeroSurfaceDesc {
    /// Where, in the chassis' frame, m.
    pub position: Vec3,
    /// C_d A, m²: drag is ½ ρ v² of it.
    pub drag_area: f32,
    /// C_l A, m²: the push down is ½ ρ v² of it, v along the vehicle.
    pub down_area: f32,
    /// ρ, kg/m³, where no field says: a wind or medium of the world's has its own, and its flow.
    pub density: f32,
}

/// Keeps a motorcycle at the lean that its turn asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeanDesc {
    /// Steepest lean, rad.
    pub angle_max: f32,
    /// How fast it gets there, Hz.
    pub hertz: f32,
    /// Damping ratio of that.
    pub damping_ratio: f32,
    /// From front to rear hub, m: steering is held to what the lean allows.
    pub wheelbase: f32,
}

/// A snowboard (or a pair of skis kept together) under the chassis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoardDesc {
    /// Middle of the base, in the chassis' frame, m.
    pub position: Vec3,
    /// Length of the edges on the snow, m.
    pub length: f32,
    /// Width at the waist, m.
    pub width: f32,
    /// Radius of the side-cut, m.
    pub sidecut: f32,
    /// Friction along the base, 1.
    pub friction: f32,
    /// Resistance of the snow against an edge that is set, ÷ load.
    pub edge_friction: f32,
    /// Edge angle from which the edge is set in full, rad.
    pub edge_angle: f32,
    /// Steepest edge angle of the rider, rad.
    pub lean_max: f32,
    /// How fast the rider gets there, Hz.
    pub hertz: f32,
    /// Damping ratio of that.
    pub damping_ratio: f32,
    /// Stiffness of snow and legs, N/m in all.
    pub stiffness: f32,
    /// Damping likewise, N s/m.
    pub damping: f32,
    /// How far above the base snow is looked for, m; also how far legs give.
    pub reach: f32,
    /// Speed of a jump off the snow, m/s.
    pub jump_speed: f32,
}

/// A vehicle: what is between a body and the ground.
///
/// All lengths in the chassis' frame. `forward` and `up` are its axes; left is up × forward.
#[derive(Clone, Debug, PartialEq)]
pub struct VehicleDesc {
    /// The body; dynamic, and of no other vehicle. Its mass is that of the whole vehicle, wheels too: these have at most 0.9 of it. A
    /// vehicle whose chassis is made lighter than that later does nothing until it is heavy enough again.
    pub chassis: BodyId,
    /// Where it drives to; unit. Default +z.
    pub forward: Vec3,
    /// Up; unit, across `forward`. Default +y.
    pub up: Vec3,
    /// Wheels, at most [`crate::limits::WHEELS_MAX`].
    pub wheels: Vec<WheelDesc>,
    /// Anti-roll bars.
    pub anti_roll: Vec<AntiRollDesc>,
    /// Engine and what follows it.
    pub drive: Option<DriveDesc>,
    /// Tracks.
    pub tracks: Vec<TrackDesc>,
    /// Steering by tracks.
    pub track_steer: Option<TrackSteerDesc>,
    /// 1: wheels are steered about one point (Ackermann); 0: all by the same angle.
    pub ackermann: f32,
    /// Keeps braked wheels from locking.
    pub abs: Option<SlipControlDesc>,
    /// Keeps driven wheels from spinning.
    pub traction: Option<SlipControlDesc>,
    /// Air.
    pub aero: Vec<AeroSurfaceDesc>,
    /// Lean of a motorcycle.
    pub lean: Option<LeanDesc>,
    /// A board, instead of wheels.
    pub board: Option<BoardDesc>,
    /// Layers of shapes to stand on (bits).
    pub ground_layers: u32,
    /// Takes part.
    pub enabled: bool,
    /// Name, at most 256 bytes.
    pub name: Option<String>,
    /// The caller's number.
    pub user_data: u128,
}

impl VehicleDesc {
    /// A vehicle without wheels.
    pub fn new(chassis: BodyId) -> Self {
        Self {
            chassis,
            forward: Vec3::Z,
            up: Vec3::Y,
            wheels: Vec::new(),
            anti_roll: Vec::new(),
            drive: None,
            tracks: Vec::new(),
            track_steer: None,
            ackermann: 1.0,
            abs: None,
            traction: None,
            aero: Vec::new(),
            lean: None,
            board: None,
            ground_layers: u32::MAX,
            enabled: true,
            name: None,
            user_data: 0,
        }
    }
    /// With one more wheel.
    pub fn wheel(mut self, wheel: WheelDesc) -> Self {
        self.wheels.push(wheel);
        self
    }
    /// With an engine.
    pub fn drive(mut self, drive: DriveDesc) -> Self {
        self.drive = Some(drive);
        self
    }
    /// With air on it.
    pub fn aero(mut self, aero: AeroSurfaceDesc) -> Self {
        self.aero.push(aero);
        self
    }

    /// Is a chassis of this mass (kg) heavy enough for the wheels that are a part of it?
    pub(crate) fn is_carried_by(&self, mass: f32) -> bool {
        self.wheels.iter().map(|w| w.mass).sum::<f32>() <= limits::UNSPRUNG_PART_MAX * mass
    }

    /// Refuses what cannot be simulated.
    ///
    /// # Errors
    /// Names the field.
    pub fn check(&self) -> Result<()> {
        let unit = |v: Vec3| v.is_finite() && (v.length() - 1.0).abs() < 1e-3;
        check(unit(self.forward), V, "forward", self.forward, "a unit vector")?;
        check(unit(self.up), V, "up", self.up, "a unit vector")?;
        let across = self.up.dot(self.forward).abs() < 1e-3;
        check(across, V, "up", self.up, "across forward")?;
        let n = self.wheels.len();
        check(n <= limits::WHEELS_MAX, V, "wheels", n, "at most 32")?;
        let stands = n > 0 || self.board.is_some();
        check(stands, V, "wheels", n, "at least one, or a board")?;
        if n > 0 && self.board.is_some() {
            let (value, expected) = (format!("{n} beside a board"), "none: wheels or a board, not both");
            return Err(Error::BadValue { what: V, field: "wheels", value, expected });
        }
        self.wheels.iter().try_for_each(WheelDesc::check)?;
        self.check_places()?;
        let wheel = |field, i: usize| check(i < n, V, field, i, "the index of a wheel");
        for a in &self.anti_roll {
            wheel("anti_roll left", a.left)?;
            wheel("anti_roll right", a.right)?;
            check(a.left != a.right, V, "anti_roll right", a.right, "another wheel than left")?;
            range(V, "anti_roll stiffness", a.stiffness, 0.0, 1e9, "0 to 1e9 N/m")?;
        }
        check(
            self.anti_roll.len() <= limits::WHEELS_MAX,
            V,
            "anti_roll",
            self.anti_roll.len(),
            "at most 32",
        )?;
        if let Some(d) = &self.drive {
            d.check(n)?;
        }
        check(self.tracks.len() <= limits::WHEELS_MAX, V, "tracks", self.tracks.len(), "at most 32")?;
        for t in &self.tracks {
            let k = t.wheels.len();
            check((2..=n).contains(&k), V, "track wheels", k, "two or more wheels of the vehicle")?;
            t.wheels.iter().try_for_each(|&i| wheel("track wheels", i))?;
            let twice = t.wheels.iter().enumerate().any(|(k, i)| t.wheels[..k].contains(i));
            check(!twice, V, "track wheels", &t.wheels, "each wheel once")?;
        }
        if let Some(t) = &self.track_steer {
            wheel("track_steer left", t.left)?;
            wheel("track_steer right", t.right)?;
            check(t.left != t.right, V, "track_steer right", t.right, "another wheel than left")?;
            range(V, "track_steer speed", t.speed, 0.0, 1e3, "0 to 1000 rad/s")?;
            range(V, "track_steer torque", t.torque, 0.0, 1e9, "0 to 1e9 N m")?;
        }
        range(V, "ackermann", self.ackermann, 0.0, 1.0, "0 to 1")?;
        for s in self.abs.iter().chain(&self.traction) {
            range(V, "slip control slip", s.slip, 1e-3, 10.0, "0.001 to 10")?;
            range(V, "slip control rate", s.rate, 0.0, 1e4, "0 to 10000 1/s")?;
        }
        check(self.aero.len() <= limits::WHEELS_MAX, V, "aero", self.aero.len(), "at most 32")?;
        for a in &self.aero {
            near("aero position", a.position)?;
            range(V, "drag_area", a.drag_area, 0.0, 1e4, "0 to 10000 m²")?;
            range(V, "down_area", a.down_area, -1e4, 1e4, "within ±10000 m²")?;
            range(V, "density", a.density, 0.0, 1e4, "0 to 10000 kg/m³")?;
        }
        if let Some(l) = &self.lean {
            range(V, "lean angle_max", l.angle_max, 0.0, 1.4, "0 to 1.4 rad")?;
            range(V, "lean hertz", l.hertz, 0.0, 100.0, "0 to 100 Hz")?;
            range(V, "lean damping_ratio", l.damping_ratio, 0.0, 100.0, "0 to 100")?;
            range(V, "lean wheelbase", l.wheelbase, 0.05, 100.0, "0.05 to 100 m")?;
        }
        if let Some(b) = &self.board {
            b.check()?;
        }
        let len = self.name.as_ref().map_or(0, String::len);
        check(len <= limits::NAME_MAX, V, "name", len, "at most 256 bytes")
    }
}

impl VehicleDesc {
    /// No two wheels are one in the other.
    fn check_places(&self) -> Result<()> {
        for (j, w) in self.wheels.iter().enumerate() {
            let same = |o: &WheelDesc| (o.position - w.position).length() < limits::WHEELS_APART_MIN;
            let Some(i) = self.wheels[..j].iter().position(same) else { continue };
            let value = format!("{:?} of both wheel {i} and wheel {j}", w.position.to_array());
            let expected = "a place of its own for each wheel";
            return Err(Error::BadValue { what: V, field: "wheel position", value, expected });
        }
        Ok(())
    }
}

const V: &str = "vehicle";

fn range(what: &'static str, field: &'static str, v: f32, lo: f32, hi: f32, e: &'static str) -> Result<()> {
    check(v >= lo && v <= hi, what, field, v, e)
}

fn near(field: &'static str, p: Vec3) -> Result<()> {
    let ok = p.is_finite() && p.abs().max_component() <= 1e3;
    check(ok, V, field, p, "finite, within 1000 m of the chassis' origin")
}

impl WheelDesc {
    fn check(&self) -> Result<()> {
        let r = |field, v, lo, hi, e| range("wheel", field, v, lo, hi, e);
        near("wheel position", self.position)?;
        r("radius", self.radius, 0.01, limits::WHEEL_SIZE_MAX, "0.01 to 10 m")?;
        r("width", self.width, 0.001, limits::WHEEL_SIZE_MAX, "0.001 to 10 m")?;
        r("mass", self.mass, 0.01, 1e6, "0.01 to 1e6 kg")?;
        r("inertia", self.inertia, 1e-5, 1e9, "1e-5 to 1e9 kg m²")?;
        r("bump", self.bump, 0.0, 10.0, "0 to 10 m")?;
        r("droop", self.droop, 0.0, 10.0, "0 to 10 m")?;
        r("preload", self.preload, 0.0, 1e9, "0 to 1e9 N")?;
        r("stiffness", self.stiffness, 0.0, 1e9, "0 to 1e9 N/m")?;
        r("bump_damping", self.bump_damping, 0.0, 1e9, "0 to 1e9 N s/m")?;
        r("rebound_damping", self.rebound_damping, 0.0, 1e9, "0 to 1e9 N s/m")?;
        r("bump_stop", self.bump_stop, 0.0, 10.0, "0 to 10 m")?;
        r("bump_stop_stiffness", self.bump_stop_stiffness, 0.0, 1e10, "0 to 1e10 N/m")?;
        r("steer", self.steer, -1.5, 1.5, "within ±1.5 rad")?;
        r("brake", self.brake, 0.0, 1e9, "0 to 1e9 N m")?;
        r("handbrake", self.handbrake, 0.0, 1e9, "0 to 1e9 N m")?;
        self.tyre.check()
    }
}

impl TyreDesc {
    fn check(&self) -> Result<()> {
        let r = |field, v, lo, hi, e| range("tyre", field, v, lo, hi, e);
        r("static_friction", self.static_friction, 0.0, 100.0, "0 to 100")?;
        r("kinetic_friction", self.kinetic_friction, 0.0, 100.0, "0 to 100")?;
        let below = self.kinetic_friction <= self.static_friction;
        check(below, "tyre", "kinetic_friction", self.kinetic_friction, "not above static_friction")?;
        r("slip_stiffness", self.slip_stiffness, 0.1, 1e4, "0.1 to 10000")?;
        r("cornering_stiffness", self.cornering_stiffness, 0.1, 1e4, "0.1 to 10000 1/rad")?;
        r("relaxation_length", self.relaxation_length, 1e-3, 100.0, "0.001 to 100 m")?;
        r("radial_stiffness", self.radial_stiffness, 1.0, 1e10, "1 to 1e10 N/m")?;
        r("radial_damping", self.radial_damping, 0.0, 1e9, "0 to 1e9 N s/m")?;
        r("rolling_resistance", self.rolling_resistance, 0.0, 10.0, "0 to 10")?;
        r("load_sensitivity", self.load_sensitivity, 0.0, 10.0, "0 to 10")?;
        r("nominal_load", self.nominal_load, 1e-3, 1e9, "0.001 to 1e9 N")
    }
}

impl DifferentialKind {
    fn check(&self) -> Result<()> {
        if let Self::LimitedSlip { preload, lock } = *self {
            range("differential", "preload", preload, 0.0, 1e9, "0 to 1e9 N m")?;
            range("differential", "lock", lock, 0.0, 100.0, "0 to 100")?;
        }
        Ok(())
    }
}

impl DriveDesc {
    fn check(&self, wheels: usize) -> Result<()> {
        let e = &self.engine;
        let n = e.torque.len();
        check((1..=limits::TORQUE_POINTS_MAX).contains(&n), "engine", "torque", n, "1 to 32 points")?;
        let rising = e.torque.windows(2).all(|w| w[0].0 < w[1].0);
        let sane = e.torque.iter().all(|p| (0.0..=1e6).contains(&p.0) && (0.0..=1e8).contains(&p.1));
        check(rising && sane, "engine", "torque", &e.torque, "rising 1/min up to 1e6, torques 0 to 1e8 N m")?;
        range("engine", "inertia", e.inertia, 1e-5, 1e6, "1e-5 to 1e6 kg m²")?;
        range("engine", "idle_rpm", e.idle_rpm, 0.0, 1e5, "0 to 1e5 1/min")?;
        let above = e.limit_rpm > e.idle_rpm && e.limit_rpm <= 1e6;
        check(above, "engine", "limit_rpm", e.limit_rpm, "above idle_rpm, to 1e6 1/min")?;
        range("engine", "drag", e.drag, 0.0, 1e8, "0 to 1e8 N m")?;
        range("clutch", "torque", self.clutch.torque, 0.0, 1e8, "0 to 1e8 N m")?;
        for (what, auto) in [("clutch", self.clutch.auto_rpm), ("gearbox", self.gearbox.auto_rpm)] {
            let Some((a, b)) = auto else { continue };
            let (lo, hi) = if what == "clutch" { (a, b) } else { (b, a) };
            let ok = lo >= 0.0 && lo < hi && hi <= 1e6;
            check(ok, what, "auto_rpm", (a, b), "clutch: from < to; gearbox: up > down; 0 to 1e6 1/min")?;
        }
        let g = &self.gearbox;
        let k = g.forward.len();
        check((1..=limits::GEARS_MAX).contains(&k), "gearbox", "forward", k, "1 to 32 gears")?;
        for &r in g.forward.iter().chain([&g.reverse, &g.final_drive]) {
            range("gearbox", "ratio", r, 1e-3, 1e4, "0.001 to 10000")?;
        }
        range("gearbox", "shift_s", g.shift_s, 0.0, 10.0, "0 to 10 s")?;
        let a = self.axles.len();
        check((1..=limits::WHEELS_MAX).contains(&a), "drive", "axles", a, "1 to 32")?;
        let mut sum = 0.0;
        for d in &self.axles {
            check(d.left < wheels, "differential", "left", d.left, "the index of a wheel")?;
            check(d.right < wheels, "differential", "right", d.right, "the index of a wheel")?;
            range("differential", "share", d.share, 0.0, 1.0, "0 to 1")?;
            d.kind.check()?;
            sum += d.share;
        }
        self.check_wheels()?;
        check((sum - 1.0).abs() < 1e-3, "differential", "share", sum, "shares that add up to 1")?;
        self.center.check()
    }

    /// No wheel is turned by two axles; one axle may drive one wheel (by a chain).
    fn check_wheels(&self) -> Result<()> {
        for (j, d) in self.axles.iter().enumerate() {
            for (field, wheel) in [("left", d.left), ("right", d.right)] {
                let same = |o: &DifferentialDesc| o.left == wheel || o.right == wheel;
                let Some(i) = self.axles[..j].iter().position(same) else { continue };
                let value = format!("wheel {wheel} on axle {j}, and it is on axle {i} too");
                let expected = "each wheel on one axle";
                return Err(Error::BadValue { what: "differential", field, value, expected });
            }
        }
        Ok(())
    }
}

impl BoardDesc {
    fn check(&self) -> Result<()> {
        let r = |field, v, lo, hi, e| range("board", field, v, lo, hi, e);
        near("board position", self.position)?;
        r("length", self.length, 0.01, 100.0, "0.01 to 100 m")?;
        r("width", self.width, 0.001, 100.0, "0.001 to 100 m")?;
        r("sidecut", self.sidecut, 0.1, 1e6, "0.1 to 1e6 m")?;
        r("friction", self.friction, 0.0, 100.0, "0 to 100")?;
        r("edge_friction", self.edge_friction, 0.0, 100.0, "0 to 100")?;
        r("edge_angle", self.edge_angle, 1e-3, 1.5, "0.001 to 1.5 rad")?;
        r("lean_max", self.lean_max, 0.0, 1.4, "0 to 1.4 rad")?;
        r("hertz", self.hertz, 0.0, 100.0, "0 to 100 Hz")?;
        r("damping_ratio", self.damping_ratio, 0.0, 100.0, "0 to 100")?;
        r("stiffness", self.stiffness, 1.0, 1e10, "1 to 1e10 N/m")?;
        r("damping", self.damping, 0.0, 1e9, "0 to 1e9 N s/m")?;
        r("reach", self.reach, 1e-3, 100.0, "0.001 to 100 m")?;
        r("jump_speed", self.jump_speed, 0.0, 100.0, "0 to 100 m/s")
    }
}

/// What the driver does. Stays until changed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VehicleInput {
    /// Throttle, 0 to 1.
    pub throttle: f32,
    /// Brake pedal, 0 to 1.
    pub brake: f32,
    /// Handbrake, 0 to 1.
    pub handbrake: f32,
    /// Steering, −1 (full left) to 1 (full right).
    pub steer: f32,
    /// Clutch pedal, 0 (let go) to 1 (pressed).
    pub clutch: f32,
    /// Gear by hand: −1 reverse, 0 neutral, 1 and on. With an automatic gearbox any gear from 1 on means "drive".
    pub gear: i32,
    /// Boards: edge angle, −1 (left edge) to 1 (right edge), of the steepest.
    pub lean: f32,
    /// Boards: jumps off the snow as it goes from 0 to 1.
    pub jump: f32,
}

impl VehicleInput {
    /// Driving forward with so much throttle (0 to 1) and steering (−1 to 1).
    pub fn drive(throttle: f32, steer: f32) -> Self {
        Self { throttle, steer, gear: 1, ..Self::default() }
    }
    /// On the brake, 0 to 1.
    pub fn brake(brake: f32) -> Self {
        Self { brake, ..Self::default() }
    }
    /// Parked: the handbrake is on.
    pub fn park() -> Self {
        Self { handbrake: 1.0, ..Self::default() }
    }
    pub(crate) fn check(&self) -> Result<()> {
        let r = |field, v, lo, e| range("vehicle input", field, v, lo, 1.0, e);
        r("throttle", self.throttle, 0.0, "0 to 1")?;
        r("brake", self.brake, 0.0, "0 to 1")?;
        r("handbrake", self.handbrake, 0.0, "0 to 1")?;
        r("steer", self.steer, -1.0, "-1 to 1")?;
        r("clutch", self.clutch, 0.0, "0 to 1")?;
        r("lean", self.lean, -1.0, "-1 to 1")?;
        r("jump", self.jump, 0.0, "0 to 1")?;
        let gear = self.gear;
        let most = limits::GEARS_MAX as i32;
        check((-1..=most).contains(&gear), "vehicle input", "gear", gear, "-1 (reverse) to 32")
    }
}
