//! Births: random numbers without a generator, and what a newborn particle gets.
//!
//! Every random number is a hash of (key of the emitter, serial of the particle, purpose): nothing is drawn from a sequence,
//! so neither the order of births nor the thread that does them can be seen, and a rewound world repeats itself.

use super::desc::{EmitDirection, EmitterDesc, EmitterShape};
use super::state::{Emitter, Newborn};
use jounce_geometry::TriMesh;
use jounce_math::{DVec3, Quat, Vec3, WorldPose, scalar::f32s};

/// The finaliser of splitmix64 (Steele, Lea and Flood 2014).
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// 64 random bits of (key, serial, purpose).
pub(crate) fn random(key: u64, serial: u64, purpose: u64) -> u64 {
    mix(mix(key ^ serial.wrapping_mul(0x9e37_79b9_7f4a_7c15)) ^ purpose.wrapping_mul(0xd1b5_4a32_d192_ed03))
}

/// Start of an emitter's random numbers.
pub(crate) fn key(seed: u64, emitter: u64) -> u64 {
    random(seed, emitter, 0)
}

/// What random numbers are for.
#[derive(Clone, Copy)]
#[repr(u64)]
enum Purpose {
    Place = 1,
    Speed = 4,
    Spread = 5,
    Life = 7,
    Radius = 8,
    Way = 9,
}

/// Random numbers of one particle.
#[derive(Clone, Copy)]
struct Dice {
    key: u64,
    serial: u64,
}

impl Dice {
    /// 0 … 1, 1 excluded.
    fn unit(self, purpose: Purpose, n: u64) -> f32 {
        (random(self.key, self.serial, purpose as u64 + n) >> 40) as f32 * (1.0 / 16_777_216.0)
    }
    fn between(self, purpose: Purpose, [lo, hi]: [f32; 2]) -> f32 {
        if lo == hi { lo } else { f32s::min(lo + (hi - lo) * self.unit(purpose, 0), hi) }
    }
    /// A unit vector within `half_angle` of +y, evenly over the solid angle.
    fn in_cone(self, purpose: Purpose, half_angle: f32) -> Vec3 {
        let y = 1.0 - self.unit(purpose, 0) * (1.0 - f32s::cos(half_angle));
        let r = f32s::sqrt(f32s::max(1.0 - y * y, 0.0));
        let turn = core::f32::consts::TAU * self.unit(purpose, 1);
        Vec3::new(r * f32s::cos(turn), y, r * f32s::sin(turn))
    }
    /// A point of the unit disc in the x–z plane.
    fn in_disc(self, purpose: Purpose) -> Vec3 {
        let r = f32s::sqrt(self.unit(purpose, 0));
        let turn = core::f32::consts::TAU * self.unit(purpose, 1);
        Vec3::new(r * f32s::cos(turn), 0.0, r * f32s::sin(turn))
    }
}

/// Where an emitter is during a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stand {
    /// At the start and the end of the step.
    pub poses: [WorldPose; 2],
    /// The body's velocity, spin and centre, for what particles inherit.
    pub velocity: Vec3,
    pub spin: Vec3,
    pub center: DVec3,
    pub moving: bool,
}

impl Stand {
    pub fn still(pose: WorldPose) -> Self {
        Self { poses: [pose; 2], center: pose.p, ..Self::default() }
    }
    /// At a fraction of the step.
    fn at(&self, s: f64) -> WorldPose {
        if !self.moving {
            return self.poses[0];
        }
        let [a, b] = self.poses;
        WorldPose::new(a.p.lerp(b.p, s), a.q.nlerp(b.q, s as f32))
    }
}

/// The particle of a serial number, born `offset` seconds into a step of `dt`.
pub(crate) fn born(e: &Emitter, stand: &Stand, serial: u64, offset: f64, dt: f64) -> Newborn {
    let d = &e.desc;
    let dice = Dice { key: e.key, serial };
    let (place, normal) = place(d, &e.areas, dice);
    let way = way(d, normal, dice);
    let pose = stand.at(if dt > 0.0 { offset / dt } else { 1.0 });
    let lever = pose.q.rotate(place);
    let at = pose.p + lever.as_dvec3();
    let mut v = pose.q.rotate(way) * dice.between(Purpose::Speed, d.speed);
    if stand.velocity != Vec3::ZERO || stand.spin != Vec3::ZERO {
        let carried = stand.velocity + stand.spin.cross((at - stand.center).as_vec3());
        v += carried * d.inherit_velocity;
    }
    Newborn {
        p: (at - e.origin).as_vec3(),
        v,
        age: -offset as f32,
        life: dice.between(Purpose::Life, d.lifetime_s),
        mass: d.mass,
        radius: dice.between(Purpose::Radius, d.radius),
        serial: serial as u32,
    }
}

/// Place of birth and outward normal in the emitter's frame. The normal of a point is zero: any way is outward.
fn place(d: &EmitterDesc, areas: &[f32], dice: Dice) -> (Vec3, Vec3) {
    match &d.shape {
        EmitterShape::Point => (Vec3::ZERO, Vec3::ZERO),
        EmitterShape::Sphere { radius, surface } => {
            let n = dice.in_cone(Purpose::Place, core::f32::consts::PI);
            // A ball's volume within r grows as r³.
            let part = if *surface { 1.0 } else { f32s::pow(dice.unit(Purpose::Place, 2), 1.0 / 3.0) };
            (n * (radius * part), n)
        }
        EmitterShape::Disc { radius } => {
            let p = dice.in_disc(Purpose::Place);
            (p * *radius, p.normalize_or(Vec3::X))
        }
        EmitterShape::Cone { radius, .. } => {
            let p = if *radius > 0.0 { dice.in_disc(Purpose::Place) * *radius } else { Vec3::ZERO };
            (p, Vec3::Y)
        }
        EmitterShape::Box { half } => {
            let u = [0, 1, 2].map(|n| 2.0 * dice.unit(Purpose::Place, n) - 1.0);
            let p = Vec3::from_array(u).mul(*half);
            (p, p.normalize_or(Vec3::Y))
        }
        EmitterShape::Mesh(mesh) => on_mesh(mesh, areas, dice),
    }
}

/// Sums of the areas of the kept triangles.
pub(crate) fn area_sums(shape: &EmitterShape) -> Vec<f32> {
    let EmitterShape::Mesh(mesh) = shape else { return Vec::new() };
    let mut sum = 0.0f64;
    let area = |[a, b, c]: [Vec3; 3]| (b - a).as_dvec3().cross((c - a).as_dvec3()).length();
    (0..mesh.len() as u32)
        .map(|i| {
            sum += area(mesh.triangle(i));
            sum as f32
        })
        .collect()
}

fn on_mesh(mesh: &TriMesh, areas: &[f32], dice: Dice) -> (Vec3, Vec3) {
    let total = areas.last().copied().unwrap_or(0.0);
    let pick = dice.unit(Purpose::Place, 0) * total;
    let i = areas.partition_point(|&a| a <= pick).min(areas.len().saturating_sub(1)) as u32;
    let [a, b, c] = mesh.triangle(i);
    // The fold u + v > 1 ↦ 1 − u, 1 − v makes a triangle of the square.
    let (mut u, mut v) = (dice.unit(Purpose::Place, 1), dice.unit(Purpose::Place, 2));
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    (a + (b - a) * u + (c - a) * v, mesh.normal(i))
}

/// The way a particle starts, in the emitter's frame, a unit vector.
fn way(d: &EmitterDesc, normal: Vec3, dice: Dice) -> Vec3 {
    let axis = match (&d.shape, d.direction) {
        (EmitterShape::Cone { half_angle, radius }, _) => return nozzle(*half_angle, *radius, d, dice),
        (_, EmitDirection::Along(axis)) => axis,
        (_, EmitDirection::Outward) if normal == Vec3::ZERO => {
            return dice.in_cone(Purpose::Way, core::f32::consts::PI);
        }
        (_, EmitDirection::Outward) => normal,
    };
    spread(axis, d.spread, dice)
}

fn spread(axis: Vec3, half_angle: f32, dice: Dice) -> Vec3 {
    let axis = axis.normalize_or(Vec3::Y);
    if half_angle == 0.0 {
        return axis;
    }
    Quat::from_rotation_arc(Vec3::Y, axis).rotate(dice.in_cone(Purpose::Spread, half_angle))
}

fn nozzle(half_angle: f32, radius: f32, d: &EmitterDesc, dice: Dice) -> Vec3 {
    if radius == 0.0 {
        return spread(Vec3::Y, half_angle, dice);
    }
    // A point at the part r of the nozzle's radius flies at the part r of the half angle.
    let p = dice.in_disc(Purpose::Place);
    let (out, r) = p.try_normalize().unwrap_or((Vec3::X, 0.0));
    let angle = half_angle * r;
    spread(out * f32s::sin(angle) + Vec3::Y * f32s::cos(angle), d.spread, dice)
}
