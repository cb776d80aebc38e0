//! One substep of a vehicle.
//!
//! Symbols: V, W velocities of the chassis, of the whole vehicle's mass M; r_h, r_c levers of hub and patch from its centre of mass, ρ =
//! r_c − r_h; d = −up the travel, u its speed; a the axle (to the left), Ω spin about it; n normal of the ground, t along and b across the
//! wheel in its plane; P impulse of the ground.
//!
//! The velocity of the tread over the ground is V + W × r_c + u d + Ω a × ρ − v_ground. P acts at the patch on the *vehicle*: what of it went
//! into a wheel's travel and spin is subtracted from the chassis,
//!
//! M ΔV = Σ P − Σ m Δu d,   I ΔW = Σ r_c × P − Σ r_h × (m Δu d) − Σ I_w ΔΩ a,
//!
//! and the ground gets −P: linear and angular momentum, Σ (M V + m u d) and Σ (r × M V + I W + r_h × m u d + I_w Ω a), are kept to
//! rounding whatever springs, brakes, clutch and engine do inside. As the chassis turns, d and a turn with it; what that changes of the sums is
//! taken from the chassis at the start of the next substep: the wheels' gyroscopic torque. It cannot run away, since the sums stay.
//!
//! All wheels are solved from the same state and then applied at once, so left and right are alike to the bit. A wheel counts with the n-th
//! part of the chassis (and of what it stands on) where n wheels touch: together they cannot push too far (mass splitting, Tonge,
//! Benevolenski & Voroshilov 2012).

use super::board;
use super::desc::{DifferentialKind, VehicleDesc, VehicleInput};
use super::engine;
use super::spin::{Part, Spin};
use super::state::{Carried, Seen, Vehicle, WheelState};
use super::suspension::{self, Spring, Travel};
use super::tyre::{self, Hold, Patch};
use crate::room::rigid::state::{InvInertia, Motion, NONE, Turning};
use core::ops::Range;
use jounce_math::{DVec3, Quat, Vec3, scalar::f32s};

/// Speed up to which treads follow what contacts push out by, m/s.
const CRAWL: f32 = 0.05;
/// Least n·up at which a wheel stands on a surface.
pub(crate) const KAPPA_MIN: f32 = 0.1;

/// What a wheel may be in the ground without having moved there, in radii: a car that is put on the ground stands on its tyres.
const SLACK: f32 = 0.1;

/// A body in the solve: the chassis, or what a wheel stands on.
#[derive(Clone, Debug)]
pub(crate) struct Mover {
    pub slot: u32,
    /// Awake row, or NONE for what does not move.
    pub row: u32,
    pub m: Motion,
    /// Along each world axis: 0 along locked ones.
    pub inv_mass: Vec3,
    pub tensor: InvInertia,
    /// Both as the step began.
    pub start_inv_mass: Vec3,
    pub start_tensor: InvInertia,
    /// Torque-free memory; turns freely.
    pub turning: Option<Turning>,
    pub free: bool,
}

impl Mover {
    pub fn new(slot: u32) -> Self {
        Self {
            slot,
            row: NONE,
            m: crate::room::rigid::state::BodyState::FIXED.get(),
            inv_mass: Vec3::ZERO,
            tensor: InvInertia::default(),
            start_inv_mass: Vec3::ZERO,
            start_tensor: InvInertia::default(),
            turning: None,
            free: false,
        }
    }
    pub fn velocity_at(&self, r: Vec3) -> Vec3 {
        self.m.v + self.m.w.cross(r)
    }
    /// e · velocity at r by a unit impulse along f there.
    pub fn response(&self, r: Vec3, e: Vec3, f: Vec3) -> f32 {
        self.inv_mass.mul(e).dot(f) + r.cross(e).dot(self.tensor.mul(r.cross(f)))
    }
    /// e · velocity at r by a unit impulse along f at s.
    pub fn answer(&self, r: Vec3, e: Vec3, s: Vec3, f: Vec3) -> f32 {
        self.inv_mass.mul(e).dot(f) + r.cross(e).dot(self.tensor.mul(s.cross(f)))
    }
    pub fn push(&mut self, r: Vec3, j: Vec3) {
        self.m.v += self.inv_mass.mul(j);
        self.m.w += self.tensor.mul(r.cross(j));
    }
    pub fn turn(&mut self, l: Vec3) {
        self.m.w += self.tensor.mul(l);
    }
}

/// A plane under a wheel, where its body was as the step began.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Plane {
    /// Place of the ground among the run's bodies.
    pub ground: usize,
    /// A point of it from the chassis' centre of mass, and from the ground's.
    pub point: Vec3,
    pub lever: Vec3,
    pub normal: Vec3,
    /// Static and kinetic friction.
    pub mu: [f32; 2],
    /// Velocity of the surface on its body, m/s.
    pub surface: Vec3,
}

/// A wheel or station in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Foot {
    /// Hub at rest, or station, from the chassis' centre of mass, as the step began.
    pub hub: Vec3,
    pub plane: Option<Plane>,
    /// It did not stand on that body in the last substep.
    pub met: bool,
}

/// A plane where everything is now.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Now {
    pub ground: usize,
    /// A point of it from the chassis' centre, and from the ground's.
    pub point: Vec3,
    pub lever: Vec3,
    pub normal: Vec3,
    pub surface: Vec3,
}

/// A vehicle in a step. Memory, not state.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub id: u32,
    pub chassis: Mover,
    pub grounds: Vec<Mover>,
    pub wheels: Vec<Foot>,
    pub stations: Vec<Foot>,
    /// Axes as the step began, world.
    pub up: Vec3,
    pub forward: Vec3,
    /// Mass, kg, and gravity, m/s².
    pub mass: f32,
    pub gravity: Vec3,
    /// Centre of mass as the step began.
    pub origin: DVec3,
    /// Rotation likewise.
    pub rotation: Quat,
    pub spin: Spin,
    /// Layers of the chassis, for fields; flow (m/s) and density (kg/m³) at the surfaces in the air, where fields have any.
    pub layers: u32,
    pub flows: Vec<(Vec3, f32)>,
    /// Its places among the step's looks at the ground.
    pub looks: Range<usize>,
    ahead: Vec<f64>,
    work: Vec<Work>,
}

/// What a wheel is about in a substep.
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    hub: Vec3,
    axle: Vec3,
    touches: bool,
    now: Now,
    arm: Vec3,
    rho: Vec3,
    kappa: f32,
    depth: f32,
    closing: f32,
    /// Tread over ground without spin and travel.
    slide: Vec3,
    spring: Spring,
    push: Vec3,
    /// Along, across, tread by spin, and the tyre's answer.
    t: Vec3,
    b: Vec3,
    roll: Vec3,
    held: Hold,
    /// Static friction.
    mu: f32,
    /// How the chassis goes over the ground in the substep.
    going: Vec3,
}

impl Run {
    pub fn new() -> Self {
        Self {
            id: NONE,
            chassis: Mover::new(NONE),
            grounds: Vec::new(),
            wheels: Vec::new(),
            stations: Vec::new(),
            up: Vec3::Y,
            forward: Vec3::Z,
            mass: 0.0,
            gravity: Vec3::ZERO,
            origin: DVec3::ZERO,
            rotation: Quat::IDENTITY,
            spin: Spin::default(),
            layers: 0,
            flows: Vec::new(),
            looks: 0..0,
            ahead: Vec::new(),
            work: Vec::new(),
        }
    }
    /// Up and forward now.
    pub fn axes(&self) -> (Vec3, Vec3) {
        let q = self.chassis.m.dq;
        (q.rotate(self.up), q.rotate(self.forward))
    }
    pub fn now(&self, p: &Plane) -> Now {
        let g = &self.grounds[p.ground].m;
        let lever = g.dq.rotate(p.lever);
        Now {
            ground: p.ground,
            point: p.point + g.dp + (lever - p.lever) - self.chassis.m.dp,
            lever,
            normal: g.dq.rotate(p.normal),
            surface: g.dq.rotate(p.surface),
        }
    }
    /// In the world.
    pub fn place(&self, arm: Vec3) -> DVec3 {
        self.origin + (self.chassis.m.dp + arm).as_dvec3()
    }
    /// Velocity of the chassis over the ground at a patch.
    pub fn over(&self, arm: Vec3, now: &Now) -> Vec3 {
        let lever = now.lever + (arm - now.point);
        self.chassis.velocity_at(arm) - self.grounds[now.ground].velocity_at(lever) - now.surface
    }
    pub fn push_ground(&mut self, arm: Vec3, now: &Now, j: Vec3) {
        self.grounds[now.ground].push(now.lever + (arm - now.point), -j);
    }
    pub fn ground_response(&self, arm: Vec3, now: &Now, e: Vec3, f: Vec3) -> f32 {
        self.grounds[now.ground].response(now.lever + (arm - now.point), e, f)
    }
}

/// Once per step: couplings of the drive, steering.
pub(crate) fn begin(v: &mut Vehicle, run: &mut Run) {
    steer(v, run);
    let d = &v.desc;
    let spin = &mut run.spin;
    spin.begin(d.wheels.len() + 1);
    let engine = d.drive.as_ref().map_or(0.0, |x| 1.0 / f64::from(x.engine.inertia));
    spin.inv.push(engine);
    spin.inv.extend(d.wheels.iter().map(|w| 1.0 / f64::from(w.inertia)));
    if let Some(drive) = &d.drive {
        let ratio = f64::from(engine::ratio(&drive.gearbox, v.shifter.gear));
        spin.couple(Part::Clutch, 0.0, &[(0, 1.0)]);
        for a in &drive.axles {
            let c = -0.5 * ratio * f64::from(a.share);
            spin.extend(a.left + 1, c);
            spin.extend(a.right + 1, c);
        }
        for (i, a) in drive.axles.iter().enumerate() {
            spin.couple(Part::Axle(i), 0.0, &[(a.left + 1, 1.0), (a.right + 1, -1.0)]);
        }
        for two in drive.axles.windows(2) {
            let [a, b] = [two[0], two[1]];
            let c = [(a.left + 1, 0.5), (a.right + 1, 0.5), (b.left + 1, -0.5), (b.right + 1, -0.5)];
            spin.couple(Part::Center, 0.0, &c);
        }
    }
    for t in &d.tracks {
        for two in t.wheels.windows(2) {
            let [a, b] = [two[0], two[1]].map(|i| (i, f64::from(d.wheels[i].radius)));
            spin.couple(Part::Track, 0.0, &[(a.0 + 1, a.1), (b.0 + 1, -b.1)]);
        }
    }
    if let Some(t) = &d.track_steer {
        let target = f64::from(v.input.steer * t.speed);
        spin.couple(Part::TrackSteer, target, &[(t.left + 1, 1.0), (t.right + 1, -1.0)]);
    }
    for i in 0..d.wheels.len() {
        spin.couple(Part::Brake(i), 0.0, &[(i + 1, 1.0)]);
    }
    spin.ready();
    v.locked.resize(spin.parts.len(), false);
    run.work.clear();
    run.work.resize(d.wheels.len(), Work::default());
    run.ahead.clear();
    run.ahead.resize(spin.n, 0.0);
}

/// Angles of the wheels: about one point (Ackermann), and no tighter than a motorcycle's lean allows.
fn steer(v: &mut Vehicle, run: &Run) {
    let d = &v.desc;
    let left = d.up.cross(d.forward);
    let (mut rear, mut fixed) = (0.0, 0.0);
    for w in d.wheels.iter().filter(|w| w.steer == 0.0) {
        (rear, fixed) = (rear + w.position.dot(d.forward), fixed + 1.0);
    }
    let mut input = v.input.steer;
    let mut most = f32::INFINITY;
    if let Some(l) = &d.lean {
        let speed = run.chassis.m.v.dot(run.forward);
        let g = run.gravity.length();
        let curve = g * f32s::tan(l.angle_max) / f32s::max(speed * speed, 1e-3);
        most = f32s::atan2(curve * l.wheelbase, 1.0);
    }
    if !input.is_finite() {
        input = 0.0;
    }
    for (w, s) in d.wheels.iter().zip(&mut v.wheels) {
        let angle = f32s::clamp(-input * w.steer, -most, most);
        let length = if fixed > 0.0 { w.position.dot(d.forward) - rear / fixed } else { 0.0 };
        if d.ackermann == 0.0 || length == 0.0 || angle == 0.0 {
            s.steer = angle;
            continue;
        }
        // The turn's centre is length/tan(angle) to the left of the middle.
        let (sin, cos) = (f32s::sin(angle), f32s::cos(angle));
        let across = w.position.dot(left) * d.ackermann;
        let sign = if length < 0.0 { -1.0 } else { 1.0 };
        s.steer = f32s::atan2(sign * length * sin, sign * (length * cos - across * sin));
    }
}

/// What a substep needs to know.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbers {
    pub h: f32,
    /// Length of the step, s.
    pub dt: f32,
    /// Fastest speed at which what is in the ground is pushed out, m/s.
    pub push_out_speed: f32,
}

/// Before the positions move.
pub(crate) fn substep(v: &mut Vehicle, run: &mut Run, k: &Numbers) {
    if !v.wheels.is_empty() {
        wheels(v, run, k);
    }
    air(&v.desc, run, k.h);
    if v.desc.lean.is_some() {
        lean(v, run, k.h);
    }
    if let Some(b) = v.desc.board {
        board::substep(v, &b, run, k);
    }
}

fn wheels(v: &mut Vehicle, run: &mut Run, k: &Numbers) {
    let h = k.h;
    let touching = places(v, run, k);
    carry_over(v, run);
    travel(v, run, h, touching as f32);
    drive(v, run, h);
    tyres(v, run, h, touching as f32);
    run.spin.roll(&mut v.locked);
    apply(v, run, h);
    moved(v, run);
    let (linear, angular) = inside(v, run);
    v.carried = Some(Carried { linear, angular, center: run.place(Vec3::ZERO), rotation: run.rotation });
}

/// Hubs after the travels went on.
fn moved(v: &Vehicle, run: &mut Run) {
    let (up, _) = run.axes();
    let q = run.chassis.m.dq;
    for (i, s) in v.wheels.iter().enumerate() {
        run.work[i].hub = q.rotate(run.wheels[i].hub) - up * s.s;
    }
}

/// Where hubs, patches and ground are now; how many touch.
fn places(v: &mut Vehicle, run: &mut Run, k: &Numbers) -> usize {
    let (up, forward) = run.axes();
    let left = up.cross(forward);
    let q = run.chassis.m.dq;
    let mut count = 0;
    for i in 0..v.wheels.len() {
        let (s, d, foot) = (&mut v.wheels[i], &v.desc.wheels[i], run.wheels[i]);
        let hub = q.rotate(foot.hub) - up * s.s;
        let axle =
            if s.steer == 0.0 { left } else { left * f32s::cos(s.steer) - forward * f32s::sin(s.steer) };
        let mut w = Work { hub, axle, arm: hub, ..Work::default() };
        if let Some(plane) = &foot.plane {
            let now = run.now(plane);
            let n = now.normal;
            // The round of the tread: a circle of radius R − r about the axle, fat by r.
            let r = f32s::min(0.5 * d.width, d.radius);
            let m = (n - axle * n.dot(axle)).normalize_or(up);
            let reach = (d.radius - r) * m.dot(n) + r;
            w.depth = reach - (hub - now.point).dot(n);
            w.kappa = n.dot(up);
            // The ground never meets it beyond the hub: levers of metres would throw what is deep in it.
            w.rho = n * f32s::min(w.depth, reach) - m * (d.radius - r) - n * r;
            w.arm = hub + w.rho;
            w.slide = run.over(w.arm, &now);
            w.closing = w.kappa * s.u - w.slide.dot(n);
            w.touches = w.depth > 0.0 && w.kappa > KAPPA_MIN;
            w.now = now;
            count += usize::from(w.touches);
        }
        // Deeper than by its own motion, and a little: it was put there, or the ground was.
        // Bodies that move themselves are seen where they were as the step began.
        let along = w.slide - w.now.normal * w.slide.dot(w.now.normal);
        let along = if s.depth > 0.0 { along.length() } else { 0.0 };
        let time = if foot.met { k.dt } else { k.h };
        let chassis = f32s::max(-w.slide.dot(w.now.normal), 0.0);
        let way = (along + chassis) * time + f32s::max(w.kappa * s.u, 0.0) * k.h;
        let slack = f32s::max(SLACK * d.radius, 2.0 * d.preload / d.tyre.radial_stiffness);
        let depth = if w.touches { w.depth } else { 0.0 };
        w.depth = s.entered(depth, way, slack, k.push_out_speed * k.h);
        run.work[i] = w;
    }
    count
}

fn travel(v: &Vehicle, run: &mut Run, h: f32, share: f32) {
    let (up, _) = run.axes();
    for i in 0..v.wheels.len() {
        let (s, w) = (&v.wheels[i], run.work[i]);
        let mut t = Travel { s: s.s, u: s.u, h, kappa: 1.0, ..Travel::default() };
        for b in v.desc.anti_roll.iter().filter(|b| b.left == i || b.right == i) {
            let other = if b.left == i { b.right } else { b.left };
            t.bar += b.stiffness * (v.wheels[other].s - s.s);
            t.bar_stiffness += b.stiffness;
        }
        t.chassis = f32s::max(share, 1.0) * run.chassis.response(w.hub, up, up);
        t.touches = w.touches;
        if w.touches {
            (t.depth, t.closing, t.kappa) = (w.depth, w.closing, w.kappa);
            let n = w.now.normal;
            t.ground = share * run.ground_response(w.arm, &w.now, n, n);
        }
        run.work[i].spring = suspension::solve(&v.desc.wheels[i], &t);
    }
}

/// Engine, clutch, differentials, brakes.
fn drive(v: &mut Vehicle, run: &mut Run, h: f32) {
    let spin = &mut run.spin;
    spin.x[0] = f64::from(v.engine);
    spin.tau.fill(0.0);
    run.ahead.fill(0.0);
    for (i, w) in v.wheels.iter().enumerate() {
        spin.x[i + 1] = f64::from(w.x);
        if run.work[i].touches {
            run.ahead[i + 1] = f64::from(w.tyre_torque);
        }
    }
    let input = v.input;
    let mut clutch = 0.0;
    let mut ratio = 0.0;
    if let Some(d) = &v.desc.drive {
        let shifting = v.shifter.is_shifting();
        let throttle = if shifting { 0.0 } else { input.throttle * v.throttle };
        spin.tau[0] = f64::from(engine::torque(&d.engine, v.engine, throttle) * h);
        ratio = engine::ratio(&d.gearbox, v.shifter.gear);
        if ratio != 0.0 && !shifting {
            clutch = engine::clutch_torque(&d.clutch, v.engine, input.clutch);
        }
    }
    for k in 0..spin.parts.len() {
        spin.cap[k] = f64::from(match spin.parts[k] {
            Part::Clutch => clutch * h,
            Part::Axle(a) => v
                .desc
                .drive
                .as_ref()
                .map_or(0.0, |d| h * strength(d.axles[a].kind, v.clutch * ratio * d.axles[a].share)),
            Part::Center => v.desc.drive.as_ref().map_or(0.0, |d| h * strength(d.center, v.clutch * ratio)),
            Part::Track => f32::INFINITY,
            Part::TrackSteer => v.desc.track_steer.map_or(0.0, |t| t.torque * h),
            Part::Brake(i) => h * brake(&v.desc, &v.wheels[i], &input, i),
        });
    }
    spin.drive(&mut v.locked, &run.ahead);
}

/// Most torque by which a differential holds its sides together.
fn strength(kind: DifferentialKind, torque: f32) -> f32 {
    match kind {
        DifferentialKind::Open => 0.0,
        DifferentialKind::LimitedSlip { preload, lock } => preload + lock * torque.abs(),
        DifferentialKind::Locked => f32::INFINITY,
    }
}

fn brake(d: &VehicleDesc, w: &WheelState, input: &VehicleInput, i: usize) -> f32 {
    let x = &d.wheels[i];
    let rolling = x.tyre.rolling_resistance * w.seen.load * x.radius;
    x.brake * input.brake * w.let_through + x.handbrake * input.handbrake + rolling
}

fn tyres(v: &mut Vehicle, run: &mut Run, h: f32, share: f32) {
    run.spin.tau.fill(0.0);
    let (up, _) = run.axes();
    for i in 0..v.wheels.len() {
        let (w, d) = (run.work[i], &v.desc.wheels[i]);
        let s = &mut v.wheels[i];
        s.seen = Seen {
            suspension: w.spring.spring / h,
            normal: Vec3::ZERO,
            point: s.seen.point,
            ..Seen::default()
        };
        s.tyre_torque = 0.0;
        run.work[i].push = Vec3::ZERO;
        if !(w.touches && w.spring.tyre > 0.0) {
            s.e = [0.0; 2];
            s.sliding = 0.0;
            continue;
        }
        let n = w.now.normal;
        let t = w.axle.cross(n).normalize_or(up.cross(w.axle));
        let b = n.cross(t);
        let x = run.spin.x[i + 1] as f32;
        let roll = w.axle.cross(w.rho);
        let slip = w.slide + roll * x - up * w.spring.u;
        // As it rolled in the last substep: now brakes have acted and the road has not.
        let rim = s.x * roll.length();
        let load = w.spring.tyre / h;
        let sensitive = 1.0 + d.tyre.load_sensitivity * f32s::max(load / d.tyre.nominal_load - 1.0, 0.0);
        let mus = run.wheels[i].plane.map_or([0.0; 2], |p| p.mu.map(|m| m / sensitive));
        let mu = tyre::friction(mus, s.sliding);
        let a = |e: Vec3, f: Vec3| {
            share * (run.chassis.response(w.arm, e, f) + run.ground_response(w.arm, &w.now, e, f))
                + run.spin.response[i + 1] as f32 * roll.dot(e) * roll.dot(f)
                + up.dot(e) * up.dot(f) / d.mass
        };
        let patch = Patch {
            v: [slip.dot(t), slip.dot(b)],
            e: s.e,
            rolling: rim.abs(),
            load: w.spring.tyre,
            mu,
            stiffness: [d.tyre.slip_stiffness * load, d.tyre.cornering_stiffness * load],
            length: d.tyre.relaxation_length,
            mass: run.mass / share,
            a: [a(t, t), a(t, b), a(b, t), a(b, b)],
            h,
        };
        let held = tyre::hold(&patch);
        (run.work[i].t, run.work[i].b, run.work[i].roll, run.work[i].held) = (t, b, roll, held);
        run.work[i].mu = mus[0];
        let push = t * held.impulse[0] + b * held.impulse[1];
        run.work[i].push = push;
        s.tyre_torque = w.axle.dot(w.rho.cross(push));
        run.spin.tau[i + 1] = f64::from(s.tyre_torque);
        s.seen = Seen {
            load,
            force: held.impulse.map(|j| j / h),
            friction: mu,
            normal: n,
            point: run.place(w.arm),
            ..s.seen
        };
    }
}

/// Lets go where the slip is too large, the faster the larger; takes hold again below.
fn control(limits: Option<(f32, f32)>, part: &mut f32, slip: f32, h: f32) {
    let Some((most, rate)) = limits else {
        *part = 1.0;
        return;
    };
    *part = f32s::clamp(*part + rate * h * f32s::clamp(1.0 - slip / most, -3.0, 1.0), 0.0, 1.0);
}

fn traction(v: &mut Vehicle, h: f32) {
    let Some(d) = &v.desc.drive else { return };
    let way = if v.shifter.gear < 0 { -1.0 } else { 1.0 };
    let mut slip = 0.0;
    for a in &d.axles {
        for i in [a.left, a.right] {
            slip = f32s::max(slip, way * v.wheels[i].seen.slip[0]);
        }
    }
    control(v.desc.traction.map(|t| (t.slip, t.rate)), &mut v.throttle, slip, h);
}

/// Impulses to chassis and ground; travels and angles on.
fn apply(v: &mut Vehicle, run: &mut Run, h: f32) {
    let (up, _) = run.axes();
    let (mut linear, mut angular) = (Vec3::ZERO, Vec3::ZERO);
    for i in 0..v.wheels.len() {
        let (w, d) = (run.work[i], &v.desc.wheels[i]);
        let s = &mut v.wheels[i];
        let push = w.push + w.now.normal * w.spring.tyre;
        let (low, high) = ((-d.bump - s.s) / h, (d.droop - s.s) / h);
        let u = f32s::clamp(w.spring.u - w.push.dot(up) / d.mass, low, high);
        let x = run.spin.x[i + 1] as f32;
        let kick = up * (-d.mass * (u - s.u));
        let spun = d.inertia * (x - s.x);
        linear += push - kick;
        angular += w.arm.cross(push) - w.hub.cross(kick) - w.axle * spun;
        s.seen.drive = (spun - s.tyre_torque) / h;
        (s.u, s.x) = (u, x);
        s.s = f32s::clamp(s.s + h * u, -d.bump, d.droop);
        s.angle = wrapped(s.angle + h * x);
        if w.touches {
            run.push_ground(w.arm, &w.now, push);
        }
    }
    v.engine = run.spin.x[0] as f32;
    for (part, total) in run.spin.parts.iter().zip(&run.spin.total) {
        if *part == Part::Clutch {
            v.clutch = *total as f32 / h;
        }
    }
    run.chassis.push(Vec3::ZERO, linear);
    run.chassis.turn(angular);
}

/// Once joints and contacts have answered: how the chassis will go. With what is hung on it left out, what its suspension turns it by alone would
/// pass for slip, and a parked car creep.
pub(crate) fn go(v: &Vehicle, run: &mut Run) {
    for i in 0..v.wheels.len() {
        let w = run.work[i];
        if w.touches {
            run.work[i].going = run.over(w.arm, &w.now);
        }
    }
}

/// Once it has gone.
pub(crate) fn follow(v: &mut Vehicle, run: &Run, h: f32) {
    slips(v, run, h);
    traction(v, h);
}

/// What the tread does over the ground after all impulses: deflection, slip, ABS.
fn slips(v: &mut Vehicle, run: &Run, h: f32) {
    let (up, _) = run.axes();
    let abs = v.desc.abs.map(|a| (a.slip, a.rate));
    for (i, s) in v.wheels.iter_mut().enumerate() {
        let w = run.work[i];
        if !(w.touches && w.spring.tyre > 0.0) {
            control(abs, &mut s.let_through, 0.0, h);
            continue;
        }
        // What contacts push out by in passing counts up to a crawl: wheels do not hold on to the ground in which a car is stuck.
        let over = run.over(w.arm, &w.now);
        let out = w.going - over;
        let over = over + out * (CRAWL / f32s::max(out.length(), CRAWL));
        let slip = over + w.roll * s.x - up * s.u;
        let flow = [slip.dot(w.t), slip.dot(w.b)];
        s.e = w.held.deflect(s.e, flow);
        let along = over.dot(w.t);
        let rim = -s.x * w.roll.dot(w.t);
        let speed = f32s::max(along.abs(), rim.abs());
        let tyre = &v.desc.wheels[i].tyre;
        s.sliding = tyre::sliding(flow, speed, [tyre.slip_stiffness, tyre.cornering_stiffness], w.mu);
        let ratio = (rim - along) / f32s::max(speed, 1.0);
        s.seen.slip = [ratio, f32s::atan2(flow[1], f32s::max(along.abs(), 1e-3))];
        let back = if along >= 0.0 { -ratio } else { ratio };
        let slow = speed < 2.0 || v.input.brake == 0.0;
        control(abs, &mut s.let_through, if slow { 0.0 } else { back }, h);
    }
}

/// Momentum of travels and spins, about the chassis' centre of mass: Σ m u d and Σ r_h × m u d + I_w Ω a.
fn inside(v: &Vehicle, run: &Run) -> (Vec3, Vec3) {
    let (up, _) = run.axes();
    let (mut p, mut l) = (Vec3::ZERO, Vec3::ZERO);
    for ((w, s), d) in run.work.iter().zip(&v.wheels).zip(&v.desc.wheels) {
        let down = up * (-d.mass * s.u);
        p += down;
        l += w.hub.cross(down) + w.axle * (d.inertia * s.x);
    }
    (p, l)
}

/// What turned since the last substep is taken from the chassis: gyroscopic torque of the wheels, and its like for travel.
fn carry_over(v: &Vehicle, run: &mut Run) {
    let Some(c) = v.carried else { return };
    let (p, l) = inside(v, run);
    let way = (run.place(Vec3::ZERO) - c.center).as_vec3();
    run.chassis.push(Vec3::ZERO, c.linear - p);
    run.chassis.turn(c.angular - l - way.cross(p));
}

/// Within a turn.
fn wrapped(x: f32) -> f32 {
    let turn = 2.0 * core::f32::consts::PI;
    x - turn * (x / turn).floor()
}

/// Where the surfaces in the air are now.
pub(crate) fn in_the_air<'a>(d: &'a VehicleDesc, run: &'a Run) -> impl Iterator<Item = (f32, DVec3)> + 'a {
    let first = d.board.map_or(0, |_| 4);
    let q = run.chassis.m.dq;
    let feet = run.stations.get(first..).unwrap_or_default();
    d.aero.iter().zip(feet).map(move |(a, foot)| (a.density, run.place(q.rotate(foot.hub))))
}

/// ½ ρ v² C A against the flow, and down, v against the wind; implicit, so that light vehicles stay calm.
fn air(d: &VehicleDesc, run: &mut Run, h: f32) {
    let (up, forward) = run.axes();
    let q = run.chassis.m.dq;
    for (i, a) in d.aero.iter().enumerate() {
        let Some(foot) = run.stations.get(d.board.map_or(0, |_| 4) + i) else { continue };
        let r = q.rotate(foot.hub);
        let (wind, density) = run.flows.get(i).copied().unwrap_or((Vec3::ZERO, a.density));
        let flow = run.chassis.velocity_at(r) - wind;
        if let Some((n, speed)) = flow.try_normalize() {
            let b = 0.5 * density * a.drag_area * speed * h;
            let m = run.chassis.response(r, n, n);
            run.chassis.push(r, n * (-b * speed / (1.0 + b * m)));
        }
        let along = flow.dot(forward);
        let weight = f32s::min(0.5 * density * along * along, 1e9);
        run.chassis.push(r, up * (-weight * a.down_area * h));
    }
}

/// Torque about the forward axis towards an angle: a damped spring of its own frequency, implicit. `height`: of the centre of mass above
/// what it turns about.
pub(crate) fn hold_roll(run: &mut Run, error: f32, hertz: f32, zeta: f32, height: f32, h: f32) {
    let (_, forward) = run.axes();
    let i = forward.dot(run.chassis.tensor.mul(forward));
    if i <= 0.0 {
        return;
    }
    let inertia = 1.0 / i + run.mass * height * height;
    let w = 2.0 * core::f32::consts::PI * hertz;
    let rate = run.chassis.m.w.dot(forward);
    let (a, b) = (w * w * h, 2.0 * zeta * w * h);
    let j = -inertia * (a * (error + h * rate) + b * rate) / (1.0 + b + a * h);
    run.chassis.turn(forward * j);
}

/// A motorcycle's rider: leans it to where the turn's centrifugal force and weight are in line.
fn lean(v: &Vehicle, run: &mut Run, h: f32) {
    let Some(l) = v.desc.lean else { return };
    let g = run.gravity.length();
    let (mut height, mut count) = (0.0, 0.0);
    let (up, forward) = run.axes();
    for w in run.work.iter().filter(|w| w.touches) {
        (height, count) = (height - w.arm.dot(up), count + 1.0);
    }
    if count == 0.0 || g == 0.0 {
        return;
    }
    let sky = run.gravity * (-1.0 / g);
    let left = up.cross(forward);
    let lean = f32s::atan2(sky.dot(left), sky.dot(up));
    let speed = run.chassis.m.v.dot(forward);
    let mut curve = 0.0;
    for w in &v.wheels {
        if w.steer.abs() > f32s::max(curve, -curve) {
            curve = w.steer;
        }
    }
    // Leaned, a front wheel steers by more on the ground.
    let curve = f32s::tan(curve) / (l.wheelbase * f32s::max(f32s::cos(lean), 0.3));
    let wanted = f32s::clamp(-f32s::atan2(speed * speed * curve, g), -l.angle_max, l.angle_max);
    hold_roll(run, lean - wanted, l.hertz, l.damping_ratio, height / count, h);
}
