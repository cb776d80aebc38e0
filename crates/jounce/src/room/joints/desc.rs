//! What users write to join two bodies.

use crate::error::{Error, Result, check};
use crate::{BodyId, JointId};
use jounce_math::{DVec3, Pose, Quat, Vec3, WorldPose};

/// Where a joint holds its two bodies.
///
/// A joint has a frame on each body. Their x axis is the joint's main axis: the hinge's, the slider's, the bone's (twist),
/// the wheel's axle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointFrames {
    /// One frame in the world, for both bodies, as they stand when the joint is added.
    World(WorldPose),
    /// A point in the world for each body, as they stand when the joint is added.
    Anchors(DVec3, DVec3),
    /// A frame in each body's own frame.
    Local(Pose, Pose),
}

/// How stiff a spring is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpringDesc {
    /// As an oscillation of the two bodies, free of everything else, along the spring.
    Hertz {
        /// Frequency without damping, Hz; above 0.
        hertz: f32,
        /// ζ: 1 is critical damping.
        damping_ratio: f32,
    },
    /// As Hooke's law: N/m and N s/m along a line, N m/rad and N m s/rad about an axis.
    Newton {
        /// k.
        stiffness: f32,
        /// c.
        damping: f32,
    },
}

impl SpringDesc {
    /// By frequency and damping ratio.
    pub const fn hertz(hertz: f32, damping_ratio: f32) -> Self {
        Self::Hertz { hertz, damping_ratio }
    }
    /// By Hooke's law.
    pub const fn newton(stiffness: f32, damping: f32) -> Self {
        Self::Newton { stiffness, damping }
    }
    fn check(&self) -> Result<()> {
        match *self {
            Self::Hertz { hertz, damping_ratio } => {
                check(hertz > 0.0 && hertz <= 1e5, "joint spring", "hertz", hertz, "above 0, to 1e5 Hz")?;
                let expected = "0 to 1000";
                check(
                    (0.0..=1e3).contains(&damping_ratio),
                    "joint spring",
                    "damping_ratio",
                    damping_ratio,
                    expected,
                )
            }
            Self::Newton { stiffness, damping } => {
                check(
                    (0.0..=1e18).contains(&stiffness),
                    "joint spring",
                    "stiffness",
                    stiffness,
                    "0 to 1e18 N/m",
                )?;
                check((0.0..=1e18).contains(&damping), "joint spring", "damping", damping, "0 to 1e18 N s/m")
            }
        }
    }
}

/// Between which coordinates (m or rad) an axis may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitDesc {
    /// Least.
    pub min: f32,
    /// Most.
    pub max: f32,
    /// Beyond it a spring pushes back; `None` is a hard stop.
    pub spring: Option<SpringDesc>,
}

impl LimitDesc {
    /// A hard stop at both ends.
    pub const fn new(min: f32, max: f32) -> Self {
        Self { min, max, spring: None }
    }
    /// Springs at both ends.
    pub const fn soft(min: f32, max: f32, spring: SpringDesc) -> Self {
        Self { min, max, spring: Some(spring) }
    }
    /// No room between its ends.
    pub(crate) fn holds_still(&self) -> bool {
        self.max - self.min <= 1e-6
    }
    fn check(&self) -> Result<()> {
        let ok = self.min.abs() <= 1e6 && self.max.abs() <= 1e6 && self.min <= self.max;
        check(ok, "joint limit", "min, max", [self.min, self.max], "min ≤ max, within ±1e6")?;
        self.spring.map_or(Ok(()), |s| s.check())
    }
}

/// What a motor is after.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotorTarget {
    /// A speed, m/s or rad/s.
    Velocity(f32),
    /// A coordinate, m or rad, by a spring that also follows `velocity`.
    Position {
        /// Where to, m or rad.
        position: f32,
        /// How fast it is there on its way, m/s or rad/s.
        velocity: f32,
        /// How stiff.
        spring: SpringDesc,
    },
}

/// A motor along or about one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorDesc {
    /// What it is after.
    pub target: MotorTarget,
    /// Its strength, N or N m; infinite by default.
    pub max_force: f32,
}

impl MotorDesc {
    /// Holds a speed (m/s or rad/s) with at most so much force (N or N m).
    pub const fn velocity(speed: f32, max_force: f32) -> Self {
        Self { target: MotorTarget::Velocity(speed), max_force }
    }
    /// Goes to a coordinate (m or rad) by a spring with at most so much force (N or N m).
    pub const fn position(position: f32, spring: SpringDesc, max_force: f32) -> Self {
        Self { target: MotorTarget::Position { position, velocity: 0.0, spring }, max_force }
    }
    fn check(&self) -> Result<()> {
        check(self.max_force >= 0.0, "joint motor", "max_force", self.max_force, "0 or more, N or N m")?;
        match self.target {
            MotorTarget::Velocity(v) => {
                check(v.abs() <= 1e5, "joint motor", "velocity", v, "within ±1e5 m/s or rad/s")
            }
            MotorTarget::Position { position, velocity, spring } => {
                check(position.abs() <= 1e6, "joint motor", "position", position, "within ±1e6 m or rad")?;
                check(
                    velocity.abs() <= 1e5,
                    "joint motor",
                    "velocity",
                    velocity,
                    "within ±1e5 m/s or rad/s",
                )?;
                spring.check()
            }
        }
    }
}

/// One degree of freedom: along or about an axis of the joint's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisDesc {
    /// No motion at all.
    pub locked: bool,
    /// Where it ends.
    pub limit: Option<LimitDesc>,
    /// What drives it.
    pub motor: Option<MotorDesc>,
    /// A spring towards a coordinate (m or rad).
    pub spring: Option<(f32, SpringDesc)>,
    /// Dry friction, N or N m.
    pub friction: f32,
}

impl AxisDesc {
    /// Free to move.
    pub const FREE: Self = Self { locked: false, limit: None, motor: None, spring: None, friction: 0.0 };
    /// Not free to move.
    pub const LOCKED: Self = Self { locked: true, ..Self::FREE };

    /// With hard ends, m or rad.
    pub const fn limited(mut self, min: f32, max: f32) -> Self {
        self.limit = Some(LimitDesc::new(min, max));
        self
    }
    /// With an end of any kind.
    pub const fn limit(mut self, limit: LimitDesc) -> Self {
        self.limit = Some(limit);
        self
    }
    /// With a motor.
    pub const fn motor(mut self, motor: MotorDesc) -> Self {
        self.motor = Some(motor);
        self
    }
    /// With a spring towards a coordinate, m or rad.
    pub const fn spring(mut self, rest: f32, spring: SpringDesc) -> Self {
        self.spring = Some((rest, spring));
        self
    }
    /// With dry friction, N or N m.
    pub const fn friction(mut self, friction: f32) -> Self {
        self.friction = friction;
        self
    }
    /// Of an axis whose turns are counted, from ±π where it is added: its ends must leave it room there.
    fn check_counted(&self) -> Result<()> {
        self.check()?;
        let Some(l) = self.limit else { return Ok(()) };
        let ok = l.min <= HALF_TURN && l.max >= -HALF_TURN;
        let expected = "ends that leave room within ±π rad, from where turns are counted";
        check(ok, "joint limit", "min, max", [l.min, l.max], expected)
    }
    /// Of a swing, which is measured within ±π/2.
    fn check_swing(&self) -> Result<()> {
        self.check()?;
        let Some(l) = self.limit else { return Ok(()) };
        let ok = l.min.abs() <= QUARTER_TURN && l.max.abs() <= QUARTER_TURN;
        check(ok, "joint limit", "min, max", [l.min, l.max], "within ±π/2 rad, where a swing is measured")
    }
    fn check(&self) -> Result<()> {
        self.limit.map_or(Ok(()), |l| l.check())?;
        self.motor.map_or(Ok(()), |m| m.check())?;
        if let Some((rest, spring)) = &self.spring {
            check(rest.abs() <= 1e6, "joint spring", "rest", rest, "within ±1e6 m or rad")?;
            spring.check()?;
        }
        check((0.0..=1e25).contains(&self.friction), "joint", "friction", self.friction, "0 to 1e25 N or N m")
    }
}

/// Turns a ball joint towards a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallMotor {
    /// Wanted rotation of B's frame in A's; `None` asks for the velocity alone.
    pub rotation: Option<Quat>,
    /// Wanted angular velocity of B against A, in A's frame, rad/s.
    pub velocity: Vec3,
    /// How stiff the pose is held.
    pub spring: SpringDesc,
    /// Strength about each axis, N m.
    pub max_torque: f32,
}

/// What a ball joint adds to holding a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BallDesc {
    /// Largest angle between the two x axes, rad, 0 to π.
    pub cone: Option<f32>,
    /// Twist about the x axis, rad, within ±π.
    pub twist: Option<LimitDesc>,
    /// The cone pushes back as a spring; `None` is a hard stop.
    pub cone_spring: Option<SpringDesc>,
    /// What turns it.
    pub motor: Option<BallMotor>,
    /// Dry friction about each axis, N m.
    pub friction: f32,
}

/// A curve through points, in body A's joint frame, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct PathDesc {
    /// Points that the curve (Catmull–Rom) goes through, 2 to 4096, none equal to the one before.
    pub points: Vec<Vec3>,
    /// The last point is joined to the first, which is not written again.
    pub closed: bool,
    /// B's frame keeps its x axis along the curve and its y axis up: no turn is free. Otherwise all are.
    pub aligned: bool,
    /// Along the curve; the coordinate is the length from the first point, m.
    pub axis: AxisDesc,
}

/// How two bodies are joined.
// Descriptions are few and short-lived; boxes would only be in the way of those who write them.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum JointKind {
    /// Nothing moves.
    Fixed,
    /// A point is held; all turns are free, within limits.
    Ball(BallDesc),
    /// Turns about x. Turns are counted, from an angle within ±π as it is added: ends may be several turns apart, but leave room
    /// within ±π.
    Hinge(AxisDesc),
    /// Slides along A's x.
    Slider(AxisDesc),
    /// The distance of the two anchors stays between two lengths, m: a rod where they are equal, a rope where `min` is 0.
    Distance {
        /// Least, m.
        min: f32,
        /// Most, m; may be infinite.
        max: f32,
    },
    /// A spring and damper between the anchors, with optional ends.
    Spring {
        /// Length without force, m.
        rest: f32,
        /// How stiff.
        spring: SpringDesc,
        /// Shortest and longest, m.
        limit: Option<LimitDesc>,
    },
    /// Spins about x (the axle), moves along A's y (the suspension), and is steered about A's y.
    Wheel {
        /// Along A's y, m.
        suspension: AxisDesc,
        /// About the axle, rad.
        spin: AxisDesc,
        /// About A's y, rad, with ends within ±π/2; locked by default.
        steer: AxisDesc,
    },
    /// Six axes, each locked or free, with limits, motors, springs. Turns are twist about x (counted, as a hinge's) and swing about y
    /// and z; swings that are not locked keep within ±90°, and so do their ends.
    Generic {
        /// Along A's x, y, z, m.
        linear: [AxisDesc; 3],
        /// About x, y, z, rad.
        angular: [AxisDesc; 3],
    },
    /// q_a + ratio · q_b stays, for the coordinates (rad or m) of two joints, hinges or sliders: gears (hinge and hinge, ratio =
    /// teeth of b ÷ teeth of a, turning opposite ways), rack and pinion (hinge and slider, ratio in rad/m). The four bodies share
    /// the reaction, so that momentum is kept.
    Gear {
        /// First joint.
        a: JointId,
        /// Second joint.
        b: JointId,
        /// q_a for one unit of −q_b.
        ratio: f32,
    },
    /// A rope over two wheels that hang in the world: |p_a − wheel a| + ratio |p_b − wheel b| ≤ length.
    Pulley {
        /// Where the rope leaves for body A, world, m.
        wheel_a: DVec3,
        /// Where the rope leaves for body B, world, m.
        wheel_b: DVec3,
        /// How many times as much rope B's side has (a block and tackle).
        ratio: f32,
        /// Rope in all, m; what it is when the joint is added if `None`.
        length: Option<f32>,
    },
    /// B's anchor follows a curve on A.
    Path(Box<PathDesc>),
}

impl JointKind {
    /// Name for messages and tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Ball(_) => "ball",
            Self::Hinge(_) => "hinge",
            Self::Slider(_) => "slider",
            Self::Distance { .. } => "distance",
            Self::Spring { .. } => "spring",
            Self::Wheel { .. } => "wheel",
            Self::Generic { .. } => "generic",
            Self::Gear { .. } => "gear",
            Self::Pulley { .. } => "pulley",
            Self::Path(_) => "path",
        }
    }
}

/// How a joint's rows are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JointSolver {
    /// Directly where the joints that hang together form trees, chains, few loops or a small net (some 60 joints; some 300 where one of its
    /// bodies has ten times the mass of another); iteratively in dense nets. Trees of balls, hinges and welds that are free of everything fixed, with masses within 20:1, are solved in `f32`, many of them at a time.
    #[default]
    Auto,
    /// Directly, in `f64`: rigid, however heavy the load. All joints that hang together with this one follow.
    Direct,
    /// Row by row, soft (`Settings::joint_hertz`). All joints that hang together follow, unless one asks for `Direct`.
    Iterative,
}

/// Describes a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct JointDesc {
    /// First body. (Gears find theirs by their joints.) A joint of two bodies that are not dynamic does nothing but lead the gears
    /// on it, until one of them is made dynamic.
    pub body_a: BodyId,
    /// Second body.
    pub body_b: BodyId,
    /// Where.
    pub frames: JointFrames,
    /// How.
    pub kind: JointKind,
    /// Do the two bodies collide with each other? Default false.
    pub collide: bool,
    /// Takes part in the simulation. Default true.
    pub enabled: bool,
    /// The rows that hold are a spring of this stiffness; rigid by default.
    pub softness: Option<SpringDesc>,
    /// Force that breaks it, N; infinite by default. It must be exceeded in two substeps that follow one another.
    pub break_force: f32,
    /// Torque that breaks it, N m, likewise.
    pub break_torque: f32,
    /// How its rows are solved.
    pub solver: JointSolver,
    /// The caller's number.
    pub user_data: u128,
    /// A name, at most 256 bytes.
    pub name: Option<String>,
}

impl JointDesc {
    /// Any joint, with one frame in the world.
    pub fn new(body_a: BodyId, body_b: BodyId, frame: WorldPose, kind: JointKind) -> Self {
        Self {
            body_a,
            body_b,
            frames: JointFrames::World(frame),
            kind,
            collide: false,
            enabled: true,
            softness: None,
            break_force: f32::INFINITY,
            break_torque: f32::INFINITY,
            solver: JointSolver::Auto,
            user_data: 0,
            name: None,
        }
    }
    fn at(a: BodyId, b: BodyId, p: impl Into<DVec3>, axis: Vec3, kind: JointKind) -> Self {
        Self::new(a, b, WorldPose::new(p.into(), frame_of(axis)), kind)
    }
    fn between(a: BodyId, b: BodyId, pa: impl Into<DVec3>, pb: impl Into<DVec3>, kind: JointKind) -> Self {
        Self {
            frames: JointFrames::Anchors(pa.into(), pb.into()),
            ..Self::new(a, b, WorldPose::IDENTITY, kind)
        }
    }
    /// A weld at a point of the world.
    pub fn fixed(a: BodyId, b: BodyId, at: impl Into<DVec3>) -> Self {
        Self::at(a, b, at, Vec3::X, JointKind::Fixed)
    }
    /// A ball joint at a point of the world.
    pub fn ball(a: BodyId, b: BodyId, at: impl Into<DVec3>) -> Self {
        Self::at(a, b, at, Vec3::X, JointKind::Ball(BallDesc::default()))
    }
    /// A hinge at a point of the world about an axis of the world.
    pub fn hinge(a: BodyId, b: BodyId, at: impl Into<DVec3>, axis: Vec3) -> Self {
        Self::at(a, b, at, axis, JointKind::Hinge(AxisDesc::FREE))
    }
    /// A slider along an axis of the world; its coordinate is 0 as the bodies stand.
    pub fn slider(a: BodyId, b: BodyId, at: impl Into<DVec3>, axis: Vec3) -> Self {
        Self::at(a, b, at, axis, JointKind::Slider(AxisDesc::FREE))
    }
    /// A rod between two points of the world, of the length they have.
    pub fn rod(a: BodyId, b: BodyId, pa: impl Into<DVec3>, pb: impl Into<DVec3>) -> Self {
        let (pa, pb) = (pa.into(), pb.into());
        let length = (pb - pa).length() as f32;
        Self::between(a, b, pa, pb, JointKind::Distance { min: length, max: length })
    }
    /// A rope between two points of the world, of a length in metres.
    pub fn rope(a: BodyId, b: BodyId, pa: impl Into<DVec3>, pb: impl Into<DVec3>, length: f32) -> Self {
        Self::between(a, b, pa, pb, JointKind::Distance { min: 0.0, max: length })
    }
    /// A spring between two points of the world, at rest at the length (m) they have.
    pub fn spring(
        a: BodyId,
        b: BodyId,
        pa: impl Into<DVec3>,
        pb: impl Into<DVec3>,
        spring: SpringDesc,
    ) -> Self {
        let (pa, pb) = (pa.into(), pb.into());
        let rest = (pb - pa).length() as f32;
        Self::between(a, b, pa, pb, JointKind::Spring { rest, spring, limit: None })
    }
    /// Couples the coordinates of two hinges or sliders: see [`JointKind::Gear`].
    pub fn gear(joint_a: JointId, joint_b: JointId, ratio: f32) -> Self {
        let [a, b] = [0, 1].map(BodyId::from_bits);
        Self::new(a, b, WorldPose::IDENTITY, JointKind::Gear { a: joint_a, b: joint_b, ratio })
    }
    /// Replaces the frames by frames in the bodies' own.
    pub fn local(mut self, a: Pose, b: Pose) -> Self {
        self.frames = JointFrames::Local(a, b);
        self
    }
    /// Replaces the kind.
    pub fn kind(mut self, kind: JointKind) -> Self {
        self.kind = kind;
        self
    }
    /// Edits the main axis: a hinge's, a slider's, a path's, a wheel's spin. No effect on other kinds.
    pub fn axis(mut self, f: impl FnOnce(AxisDesc) -> AxisDesc) -> Self {
        if let Some(axis) = main_axis(&mut self.kind) {
            *axis = f(*axis);
        }
        self
    }
    /// Ends of the main axis, m or rad.
    pub fn limited(self, min: f32, max: f32) -> Self {
        self.axis(|a| a.limited(min, max))
    }
    /// A motor on the main axis.
    pub fn motor(self, motor: MotorDesc) -> Self {
        self.axis(|a| a.motor(motor))
    }
    /// Ball joints: largest angle of the x axes, and the least and largest twist, rad.
    pub fn cone_twist(mut self, cone: f32, twist_min: f32, twist_max: f32) -> Self {
        if let JointKind::Ball(b) = &mut self.kind {
            (b.cone, b.twist) = (Some(cone), Some(LimitDesc::new(twist_min, twist_max)));
        }
        self
    }
    /// Do the two bodies collide with each other?
    pub fn collide(mut self, on: bool) -> Self {
        self.collide = on;
        self
    }
    /// What it stands, N and N m.
    pub fn breaks_at(mut self, force: f32, torque: f32) -> Self {
        (self.break_force, self.break_torque) = (force, torque);
        self
    }
    /// How its rows are solved.
    pub fn solver(mut self, solver: JointSolver) -> Self {
        self.solver = solver;
        self
    }
    /// Holds as a spring instead of rigidly.
    pub fn soft(mut self, spring: SpringDesc) -> Self {
        self.softness = Some(spring);
        self
    }
    /// A name.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }

    /// Refuses numbers that no joint can have.
    ///
    /// # Errors
    /// Names the field.
    pub fn check(&self) -> Result<()> {
        check(self.body_a != self.body_b, "joint", "body_b", self.body_b, "another body than body_a")?;
        check_frames(&self.frames)?;
        check_kind(&self.kind)?;
        self.softness.map_or(Ok(()), |s| s.check())?;
        check(self.break_force > 0.0, "joint", "break_force", self.break_force, "above 0 N")?;
        check(self.break_torque > 0.0, "joint", "break_torque", self.break_torque, "above 0 N m")?;
        let len = self.name.as_ref().map_or(0, String::len);
        check(len <= crate::limits::NAME_MAX, "joint", "name", len, "at most 256 bytes")
    }
}

/// The axis that a kind has before all others.
pub(crate) fn main_axis(kind: &mut JointKind) -> Option<&mut AxisDesc> {
    match kind {
        JointKind::Hinge(a) | JointKind::Slider(a) => Some(a),
        JointKind::Wheel { spin, .. } => Some(spin),
        JointKind::Path(p) => Some(&mut p.axis),
        _ => None,
    }
}

/// A rotation that takes x to an axis.
fn frame_of(axis: Vec3) -> Quat {
    let n = axis.length();
    if n > 0.0 && n.is_finite() {
        Quat::from_rotation_arc(Vec3::X, axis / n)
    } else {
        Quat::new(0.0, 0.0, 0.0, f32::NAN)
    }
}

fn check_rotation(q: Quat) -> Result<()> {
    let n = q.length();
    check(
        n.is_finite() && n > 1e-3,
        "joint",
        "rotation of a frame",
        q,
        "a rotation of finite numbers (and an axis above 0)",
    )
}

fn check_frames(frames: &JointFrames) -> Result<()> {
    let far = |p: DVec3| {
        let ok = p.is_finite() && p.abs().max_component() <= crate::limits::POSITION_MAX;
        check(ok, "joint", "anchor", p, "finite, within ±1e9 m")
    };
    match frames {
        JointFrames::World(p) => far(p.p).and_then(|()| check_rotation(p.q)),
        JointFrames::Anchors(a, b) => far(*a).and_then(|()| far(*b)),
        JointFrames::Local(a, b) => [a, b].into_iter().try_for_each(|p| {
            far(p.p.as_dvec3())?;
            check_rotation(p.q)
        }),
    }
}

/// A stretch between two points of a path has a length.
fn check_apart(p: &PathDesc) -> Result<()> {
    let n = p.points.len();
    let next = |i: usize| (i, (i + 1) % n);
    let stretches = (0..if p.closed { n } else { n - 1 }).map(next);
    let Some((i, j)) = stretches.into_iter().find(|&(i, j)| (p.points[j] - p.points[i]).length() <= 1e-6)
    else {
        return Ok(());
    };
    let value = format!("{:?} at both points[{i}] and points[{j}]", p.points[i].to_array());
    let expected = match j {
        0 => "points that differ from the one before (a closed path goes back to points[0] by itself)",
        _ => "points that differ from the one before",
    };
    Err(Error::BadValue { what: "path joint", field: "points", value, expected })
}

/// π, and what rounding of degrees may add.
const HALF_TURN: f32 = core::f32::consts::PI + 1e-5;
/// π/2, likewise.
const QUARTER_TURN: f32 = core::f32::consts::FRAC_PI_2 + 1e-5;

pub(crate) fn check_kind(kind: &JointKind) -> Result<()> {
    let length = |field, v: f32| check((0.0..=1e6).contains(&v), "joint", field, v, "0 to 1e6 m");
    match kind {
        JointKind::Fixed => Ok(()),
        JointKind::Ball(b) => {
            let cone = b.cone.unwrap_or(0.0);
            check((0.0..=HALF_TURN).contains(&cone), "ball joint", "cone", cone, "0 to π rad")?;
            if let Some(t) = &b.twist {
                t.check()?;
                let ok = t.min >= -HALF_TURN && t.max <= HALF_TURN;
                check(ok, "ball joint", "twist", [t.min, t.max], "within ±π rad")?;
            }
            b.cone_spring.map_or(Ok(()), |s| s.check())?;
            if let Some(m) = &b.motor {
                m.rotation.map_or(Ok(()), check_rotation)?;
                let v = m.velocity;
                check(
                    v.is_finite() && v.length() <= 1e5,
                    "ball joint",
                    "motor velocity",
                    v,
                    "at most 1e5 rad/s",
                )?;
                check(m.max_torque >= 0.0, "ball joint", "max_torque", m.max_torque, "0 or more, N m")?;
                m.spring.check()?;
            }
            check((0.0..=1e25).contains(&b.friction), "ball joint", "friction", b.friction, "0 to 1e25 N m")
        }
        JointKind::Hinge(a) | JointKind::Slider(a) => {
            check(
                !a.locked,
                "joint",
                "locked",
                true,
                "false for the axis of a hinge or slider (a fixed joint locks all)",
            )?;
            if matches!(kind, JointKind::Hinge(_)) { a.check_counted() } else { a.check() }
        }
        JointKind::Distance { min, max } => {
            length("min", *min)?;
            check(*max >= *min, "distance joint", "max", max, "at least min")
        }
        JointKind::Spring { rest, spring, limit } => {
            length("rest", *rest)?;
            limit.map_or(Ok(()), |l| l.check())?;
            spring.check()
        }
        JointKind::Wheel { suspension, spin, steer } => {
            check(!spin.locked, "wheel joint", "spin", "locked", "an axis that may turn")?;
            suspension.check()?;
            spin.check_counted()?;
            steer.check_swing()
        }
        JointKind::Generic { linear, angular } => {
            linear.iter().try_for_each(AxisDesc::check)?;
            if let Some(i) = super::generic::hinge(angular) {
                return angular[i].check_counted();
            }
            angular[0].check_counted()?;
            angular[1..].iter().try_for_each(AxisDesc::check_swing)
        }
        JointKind::Gear { a, b, ratio } => {
            check(a != b, "gear", "b", b, "another joint than a")?;
            let ok = ratio.is_finite() && ratio.abs() >= 1e-6 && ratio.abs() <= 1e6;
            check(ok, "gear", "ratio", ratio, "1e-6 to 1e6 in size")
        }
        JointKind::Pulley { wheel_a, wheel_b, ratio, length: l } => {
            for w in [wheel_a, wheel_b] {
                let ok = w.is_finite() && w.abs().max_component() <= crate::limits::POSITION_MAX;
                check(ok, "pulley", "wheel", w, "finite, within ±1e9 m")?;
            }
            check((1e-3..=1e3).contains(ratio), "pulley", "ratio", ratio, "0.001 to 1000")?;
            l.map_or(Ok(()), |l| length("length", l))
        }
        JointKind::Path(p) => {
            let n = p.points.len();
            let least = if p.closed { 3 } else { 2 };
            check(
                (least..=4096).contains(&n),
                "path joint",
                "points",
                n,
                "2 to 4096 points (3 where closed)",
            )?;
            let ok = p.points.iter().all(|p| p.is_finite() && p.abs().max_component() <= 1e6);
            check(ok, "path joint", "points", "a point", "finite, within ±1e6 m")?;
            check_apart(p)?;
            p.axis.check()
        }
    }
}
