//! Random vehicles and characters, joints and ragdolls, and random edits of them.

use super::rng::Rng;
use super::storm::Storm;
use jounce::math::scalar::f32s;
use jounce::prelude::*;
use jounce::vehicles::{VehicleKit, car, carry, motorcycle, off_road, snowboard, sports_car, tank};
use jounce::{
    AxisDesc, CharacterDesc, CharacterId, CharacterInput, CharacterKind, CharacterMover, Command,
    DifferentialKind, JointKind, JointSolver, LimitDesc, MotorDesc, RagdollDesc, SpringDesc, VehicleDesc,
    WheelCast, WheelDesc,
};

/// Most of each kind.
const MOST: usize = 6;
/// Most joints that come one by one; ragdolls bring theirs.
const JOINTS: usize = 24;

/// Adds, changes, drives or removes a vehicle or a character; sometimes with what must be refused.
pub fn edit(storm: &mut Storm) {
    let Some(mut rng) = storm.movers.take() else { return };
    if rng.one_in(16) && storm.world.counts().bodies < 50 {
        preset(storm, &mut rng);
    } else {
        let command = command(storm, &mut rng);
        apply(storm, command);
    }
    storm.movers = Some(rng);
}

/// Adds, changes or removes a joint, or lets a ragdoll fall.
pub fn edit_joints(storm: &mut Storm) {
    let Some(mut rng) = storm.joints.take() else { return };
    if rng.one_in(12) && storm.world.counts().bodies < 50 {
        ragdoll(storm, &mut rng);
    } else {
        let command = link(storm, &mut rng);
        apply(storm, command);
    }
    storm.joints = Some(rng);
}

fn apply(storm: &mut Storm, command: Option<Command>) {
    let Some(command) = command else { return };
    (storm.around)(&mut || {
        let accepted = storm.world.apply(command.clone()).is_ok();
        storm.edits[usize::from(!accepted)] += 1;
    });
}

fn somewhere(storm: &Storm, rng: &mut Rng) -> DVec3 {
    let mut p = rng.vec3(storm.extent);
    p.y = p.y.abs();
    storm.origin + p.as_dvec3()
}

fn any_of(storm: &Storm, rng: &mut Rng) -> Option<BodyId> {
    let all: Vec<BodyId> = storm.world.bodies().collect();
    (!all.is_empty()).then(|| *rng.pick(&all))
}

fn preset(storm: &mut Storm, rng: &mut Rng) {
    if storm.world.counts().vehicles >= MOST {
        return;
    }
    let make: [fn() -> VehicleKit; 6] = [car, sports_car, off_road, motorcycle, tank, snowboard];
    let (kit, at, q) = (rng.pick(&make)(), somewhere(storm, rng), rng.quat());
    let q = if rng.one_in(3) { q } else { Quat::IDENTITY };
    (storm.around)(&mut || {
        kit.clone().add(&mut storm.world, at, q).expect("presets are in range");
    });
}

fn ragdoll(storm: &mut Storm, rng: &mut Rng) {
    let d = RagdollDesc::human().at(somewhere(storm, rng)).rotated(rng.quat()).velocity(rng.vec3(5.0));
    let d = d.group(-1 - rng.below(3) as i32);
    let d = if rng.one_in(3) { d.never_meets_itself() } else { d };
    (storm.around)(&mut || {
        storm.world.add_ragdoll(&d).expect("a human is in range");
    });
}

fn command(storm: &Storm, rng: &mut Rng) -> Option<Command> {
    let w = &storm.world;
    let vehicles: Vec<VehicleId> = w.vehicles().collect();
    let characters: Vec<CharacterId> = w.characters().collect();
    Some(match rng.below(16) {
        0 | 1 if vehicles.len() < MOST => Command::AddVehicle(Box::new(vehicle(storm, rng)?)),
        2..=5 => Command::SetVehicleInput(any(&vehicles, rng)?, input(rng)),
        6 => Command::SetVehicleEnabled(any(&vehicles, rng)?, rng.one_in(2)),
        7 => {
            let id = any(&vehicles, rng)?;
            let mut d = w.vehicle(id).ok()?.desc().clone();
            for x in &mut d.wheels {
                x.stiffness *= rng.decades(-1.0, 1.0);
                x.radius *= rng.float(0.5, 1.5);
                x.tyre.kinetic_friction *= rng.float(0.0, 1.2);
            }
            Command::SetVehicle(id, Box::new(d))
        }
        8 if rng.one_in(2) => Command::RemoveVehicle(any(&vehicles, rng)?),
        9 if characters.len() < MOST => Command::AddCharacter(Box::new(character(storm, rng))),
        10..=12 => Command::SetCharacterInput(any(&characters, rng)?, wish(storm, rng)),
        13 => {
            let id = any(&characters, rng)?;
            let mut d = character(storm, rng);
            if !rng.one_in(4) {
                d.kind = w.character(id).ok()?.desc().kind;
            }
            Command::SetCharacter(id, Box::new(d))
        }
        14 if rng.one_in(2) => Command::RemoveCharacter(any(&characters, rng)?),
        _ => return None,
    })
}

fn any<T: Copy>(all: &[T], rng: &mut Rng) -> Option<T> {
    (!all.is_empty()).then(|| *rng.pick(all))
}

fn link(storm: &Storm, rng: &mut Rng) -> Option<Command> {
    let joints: Vec<JointId> = storm.world.joints().collect();
    Some(match rng.below(8) {
        0..=2 if joints.len() < JOINTS => Command::AddJoint(Box::new(joint(storm, rng)?)),
        3 => {
            let id = any(&joints, rng)?;
            let kind = changed(storm.world.joint(id).ok()?.kind(), rng);
            Command::SetJoint(id, Box::new(kind))
        }
        4 => Command::SetJointEnabled(any(&joints, rng)?, rng.one_in(2)),
        5 => Command::RemoveJoint(any(&joints, rng)?),
        _ => return None,
    })
}

fn input(rng: &mut Rng) -> VehicleInput {
    // One in sixty is out of range.
    let most = if rng.one_in(60) { 1.5 } else { 1.0 };
    let mut pedal = |n: usize| if rng.one_in(n) { rng.float(0.0, most) } else { 0.0 };
    let (throttle, brake, handbrake, clutch, jump) = (pedal(1), pedal(3), pedal(5), pedal(6), pedal(3));
    VehicleInput {
        throttle,
        brake,
        handbrake,
        clutch,
        jump,
        steer: rng.float(-most, most),
        lean: rng.float(-most, most),
        gear: rng.below(8) as i32 - 1,
    }
}

/// Wheels or a board under any body, as large as the world's things.
fn vehicle(storm: &Storm, rng: &mut Rng) -> Option<VehicleDesc> {
    let b = any_of(storm, rng)?;
    let mass = storm.world.body(b).ok()?.mass();
    let s = storm.size;
    let mut d = VehicleDesc::new(b);
    if rng.one_in(6) {
        d.board = snowboard().vehicle.board;
    } else {
        let n = 1 + rng.below(6);
        for _ in 0..n {
            let load = mass * 9.81 / n as f32;
            let mut w = WheelDesc::new(rng.vec3(s), load);
            w.radius = s * rng.float(0.2, 1.0);
            w.width = s * rng.float(0.05, 0.5);
            (w.bump, w.droop) = (s * rng.float(0.0, 0.5), s * rng.float(0.0, 0.5));
            w.mass = f32s::clamp(mass * rng.float(0.001, 0.3), 0.01, 1e6);
            w.inertia = f32s::clamp(w.mass * w.radius * w.radius, 1e-5, 1e9);
            w.stiffness = load / (s * rng.float(0.05, 1.0));
            w.tyre.radial_stiffness = f32s::clamp(load / (s * rng.float(0.01, 0.2)), 1.0, 1e10);
            w.tyre.nominal_load = f32s::clamp(load, 1e-3, 1e9);
            w.steer = rng.float(-0.7, 0.7);
            w.brake = load * s;
            w.cast = *rng.pick(&[WheelCast::Cylinder, WheelCast::Sphere, WheelCast::Ray]);
            d.wheels.push(w);
        }
        if rng.one_in(4) {
            carry(&mut d.wheels, mass, 0.0);
        }
        if rng.one_in(2) {
            d.drive = car().vehicle.drive;
            let kind = *rng.pick(&[
                DifferentialKind::Open,
                DifferentialKind::Locked,
                DifferentialKind::LimitedSlip { preload: 10.0, lock: 0.5 },
            ]);
            for a in d.drive.iter_mut().flat_map(|d| &mut d.axles) {
                (a.left, a.right, a.kind) = (rng.below(n), rng.below(n), kind);
            }
        }
        d.ackermann = rng.float(0.0, 1.0);
        if rng.one_in(3) {
            (d.abs, d.traction) = (car().vehicle.abs, car().vehicle.traction);
        }
        if rng.one_in(5) {
            d.lean = motorcycle().vehicle.lean;
        }
    }
    if rng.one_in(3) {
        d.aero = car().vehicle.aero;
    }
    Some(d)
}

fn character(storm: &Storm, rng: &mut Rng) -> CharacterDesc {
    let s = storm.size;
    let radius = s * rng.float(0.2, 0.8);
    let height = radius * rng.float(2.0, 6.0);
    let mut d = CharacterDesc::at(somewhere(storm, rng));
    d.mover = CharacterMover {
        radius,
        height,
        step_height: s * rng.float(0.0, 0.5),
        snap: s * rng.float(0.0, 0.6),
        skin: radius * rng.float(0.001, 0.2),
        slope_max: rng.float(0.0, 1.5),
        up: if rng.one_in(5) { rng.vec3(1.0) } else { Vec3::Y },
        one_way_layers: if rng.one_in(4) { 2 } else { 0 },
    };
    d.crouch_height = rng.float(2.0 * radius, height);
    d.heading = rng.float(-3.0, 3.0);
    d.mass = rng.decades(0.0, 3.0);
    d.push_force = rng.decades(0.0, 4.0);
    d.gravity_scale = if rng.one_in(5) { rng.float(0.0, 3.0) } else { 1.0 };
    if rng.one_in(2) {
        let (leg_hertz, leg_damping_ratio) = (rng.float(1.0, 12.0), rng.float(0.0, 2.0));
        d.kind = CharacterKind::Dynamic { leg_hertz, leg_damping_ratio, force: rng.decades(1.0, 4.0) };
    }
    d
}

fn wish(storm: &Storm, rng: &mut Rng) -> CharacterInput {
    let s = storm.size;
    CharacterInput {
        walk: rng.vec3(8.0 * s),
        jump: rng.one_in(4).then(|| rng.float(0.0, 10.0 * s)),
        crouch: rng.one_in(4),
        drop_through: rng.one_in(6),
        heading: rng.one_in(3).then(|| rng.float(-3.0, 3.0)),
    }
}

fn spring(rng: &mut Rng) -> SpringDesc {
    if rng.one_in(3) {
        return SpringDesc::newton(rng.decades(0.0, 4.0), rng.decades(-2.0, 3.0));
    }
    SpringDesc::hertz(rng.decades(-1.0, 1.5), rng.float(0.0, 2.0))
}

fn axis(storm: &Storm, rng: &mut Rng) -> AxisDesc {
    let mut a = if rng.one_in(5) { AxisDesc::LOCKED } else { AxisDesc::FREE };
    if rng.one_in(2) {
        let mut limit = LimitDesc::new(-rng.float(0.0, 1.5), rng.float(0.0, 1.5));
        limit.spring = rng.one_in(4).then(|| spring(rng));
        a.limit = Some(limit);
    }
    if rng.one_in(3) {
        let most = rng.decades(-1.0, 4.0);
        a.motor = Some(if rng.one_in(2) {
            MotorDesc::velocity(rng.float(-5.0, 5.0), most)
        } else {
            MotorDesc::position(rng.float(-0.5, 0.5) * storm.size, spring(rng), most)
        });
    }
    if rng.one_in(4) {
        a.spring = Some((rng.float(-0.5, 0.5), spring(rng)));
    }
    if rng.one_in(4) {
        a.friction = rng.decades(-2.0, 2.0);
    }
    a
}

/// Between any two bodies, where they are.
fn joint(storm: &Storm, rng: &mut Rng) -> Option<JointDesc> {
    let (a, b) = (any_of(storm, rng)?, any_of(storm, rng)?);
    let w = &storm.world;
    let (pa, pb) = (w.body(a).ok()?.position(), w.body(b).ok()?.position());
    let at = pa + (pb - pa) * rng.double(0.0, 1.0);
    let length = (pb - pa).length() as f32;
    let mut d = match rng.below(8) {
        0 => JointDesc::fixed(a, b, at),
        1 => JointDesc::ball(a, b, at).cone_twist(
            rng.float(0.1, 2.0),
            -rng.float(0.0, 1.0),
            rng.float(0.0, 1.0),
        ),
        2 => JointDesc::hinge(a, b, at, rng.vec3(1.0).normalize_or(Vec3::X))
            .kind(JointKind::Hinge(unlocked(axis(storm, rng)))),
        3 => JointDesc::slider(a, b, at, rng.vec3(1.0).normalize_or(Vec3::X))
            .kind(JointKind::Slider(unlocked(axis(storm, rng)))),
        4 => JointDesc::rod(a, b, pa, pb),
        5 => JointDesc::rope(a, b, pa, pb, length * rng.float(1.0, 1.5)),
        6 => JointDesc::spring(a, b, pa, pb, spring(rng)),
        _ => {
            let three = |rng: &mut Rng| [axis(storm, rng), axis(storm, rng), axis(storm, rng)];
            let kind = JointKind::Generic { linear: three(rng), angular: three(rng) };
            JointDesc::ball(a, b, at).kind(kind)
        }
    };
    if rng.one_in(4) {
        d = d.soft(spring(rng));
    }
    if rng.one_in(6) {
        d = d.breaks_at(rng.decades(0.0, 4.0), rng.decades(0.0, 4.0));
    }
    d = d.collide(rng.one_in(2));
    d.solver = *rng.pick(&[JointSolver::Auto, JointSolver::Direct, JointSolver::Iterative]);
    Some(d)
}

fn unlocked(a: AxisDesc) -> AxisDesc {
    AxisDesc { locked: false, ..a }
}

/// The same kind with another motor or friction, where it has some.
fn changed(kind: &JointKind, rng: &mut Rng) -> JointKind {
    let mut kind = kind.clone();
    match &mut kind {
        JointKind::Hinge(a) | JointKind::Slider(a) => {
            a.motor =
                rng.one_in(2).then(|| MotorDesc::velocity(rng.float(-5.0, 5.0), rng.decades(-1.0, 3.0)));
            a.friction = rng.decades(-2.0, 2.0);
        }
        JointKind::Distance { max, .. } => *max *= rng.float(1.0, 1.2),
        JointKind::Spring { rest, .. } => *rest *= rng.float(0.5, 1.5),
        JointKind::Ball(b) => b.friction = rng.decades(-2.0, 2.0),
        _ => {}
    }
    kind
}
