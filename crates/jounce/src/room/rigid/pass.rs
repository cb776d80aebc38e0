//! What a substep does with bodies alone: forces, the impulses of contacts once more, and the way; row by row, and abreast.
//!
//! Several of these stand one after the other where nothing else acts in between. They are done in one pass over the bodies then ([`Todo`]): a
//! pass costs what it reads. The way is that of `solve::integrate_position`, in its order of operations; bodies that lanes do not know (locks, turns of
//! more than a radian) go there one by one. What turns torque-free has its turn after its way, in lanes of its own ([`super::free`]).

use super::free::SPIN_MIN_SQUARED;
use super::solve::{SpeedLimits, turns_freely};
use super::state::{Body, BodyState, BodyStep, InvInertia};
use super::turn::{Turn, normalize};
use crate::room::contacts::rows::{LANES, Lane, Wide3};
use crate::room::rigid::desc::BodyKind;
use jounce_lanes::{Kernel, Lanes};

/// What is to be done with every body, in this order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Todo {
    /// What a pass over contacts changed of the velocity adds to what is pushed.
    pub count: bool,
    /// Forces, gravity, damping.
    pub drive: bool,
    /// What contacts gave in the last substep, once more.
    pub push: bool,
    /// Along the velocity.
    pub go: bool,
    /// The velocity is kept, for what the next pass over contacts will change.
    pub mark: bool,
}

/// Forces of a substep on a hot row: u ← (u + add) keep.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Drive {
    add: [f32; 8],
    keep: [f32; 8],
}

impl Drive {
    /// −0 and 1 change no bit.
    pub const NOTHING: Self = Self { add: [-0.0; 8], keep: [1.0; 8] };
    /// Forces, gravity and damping over `h` seconds. Gravity and forces per unit mass are in `step.acceleration`.
    pub fn new(b: &BodyStep, i: &InvInertia, h: f32) -> Self {
        let mut drive = Self::NOTHING;
        if b.kind != BodyKind::Dynamic {
            return drive;
        }
        let (v, w) = (b.acceleration * h, i.mul(b.torque) * h);
        drive.add = [v.x, v.y, v.z, w.x, w.y, w.z, -0.0, -0.0];
        drive.keep[..3].fill(1.0 / (1.0 + h * b.linear_damping));
        // Where the turn is free, it is the momentum that is damped.
        if !turns_freely(b) {
            drive.keep[3..6].fill(1.0 / (1.0 + h * b.angular_damping));
        }
        drive
    }
}

/// How a body goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Its fastest spin, rad/s.
    pub spin_most: f32,
    /// Not in lanes.
    alone: bool,
    /// Neither while it turns more than a radian a substep.
    fast: bool,
    /// Its turn is torque-free.
    pub free: bool,
}

impl Way {
    pub const NOTHING: Self = Self { spin_most: 0.0, alone: false, fast: false, free: false };
    pub fn new(b: &BodyStep, body: &Body, limits: &SpeedLimits) -> Self {
        let spin_most = limits.spin_of(b, body);
        Self { spin_most, alone: b.locks != 0, fast: b.fast_rotation, free: turns_freely(b) }
    }
    /// Does it have a torque-free turn in this substep, in lanes? (Its way does not change the answer.)
    #[inline(always)]
    pub fn turns(&self, s: &BodyState) -> bool {
        self.free && !self.alone && s.w().length_squared() >= SPIN_MIN_SQUARED
    }
    /// Does it go by itself in this substep? (What goes in lanes has the same answer after it.)
    #[inline(always)]
    pub fn goes_alone(&self, s: &BodyState, h: f32) -> bool {
        self.alone || (self.fast && (s.w() * h).length_squared() > 1.0 && !self.turns(s))
    }
}

/// What contacts give a body in a substep, and its velocity before the pass that is under way.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Pushed {
    pub sum: [f32; 8],
    pub before: [f32; 8],
}

impl Pushed {
    pub const NOTHING: Self = Self { sum: [0.0; 8], before: [0.0; 8] };
}

// A row at a time, and not in a kernel: with wide instructions the compiler goes across bodies instead, and gathers.
impl Todo {
    /// What comes before the way, for a chunk of bodies.
    pub fn change(self, states: &mut [BodyState], pushed: &mut [Pushed], drives: &[Drive]) {
        if self.count {
            for (p, s) in pushed.iter_mut().zip(&*states) {
                // The last two are places, which no pass over contacts changes.
                p.sum = core::array::from_fn(|k| p.sum[k] + (s.hot[k] - p.before[k]));
            }
        }
        if self.drive {
            for (s, d) in states.iter_mut().zip(drives) {
                s.hot = core::array::from_fn(|k| (s.hot[k] + d.add[k]) * d.keep[k]);
            }
        }
        if self.push {
            for (s, p) in states.iter_mut().zip(&*pushed) {
                s.hot = core::array::from_fn(|k| s.hot[k] + p.sum[k]);
            }
        }
    }
    /// What comes after it.
    pub fn keep(self, states: &[BodyState], pushed: &mut [Pushed]) {
        if self.mark {
            pushed.iter_mut().zip(states).for_each(|(p, s)| p.before = s.hot);
        }
    }
}

/// The way of a chunk of bodies, but for those alone.
pub(crate) struct Go<'a> {
    pub states: &'a mut [BodyState],
    pub ways: &'a [Way],
    pub h: f32,
    pub speed_most: f32,
}

impl Kernel for Go<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { states, ways, h, speed_most } = self;
        let mut at = 0;
        while at < states.len() {
            let to = states.len().min(at + L::WIDTH);
            if ways[at..to].iter().zip(&states[at..to]).any(|(w, s)| !w.goes_alone(s, h)) {
                go::<L>(&mut states[at..to], &ways[at..to], h, speed_most);
            }
            at = to;
        }
    }
}

/// v, cut to a length.
#[inline(always)]
fn within<L: Lanes>(v: Wide3<L>, most: L) -> Wide3<L> {
    let size2 = v.dot(v);
    v.scale(L::select(size2.gt(most * most), most / size2.sqrt(), L::splat(1.0)))
}

#[inline(always)]
fn go<L: Lanes>(states: &mut [BodyState], ways: &[Way], h: f32, speed_most: f32) {
    let len = states.len();
    let [vx, vy, vz, wx, wy, wz, px, py] = L::gather8(
        #[inline(always)]
        |l| if l < len { &states[l].hot } else { &BodyState::FIXED.hot },
    );
    let [pz, rx, ry, rz, qx, qy, qz, qw] = L::gather8(
        #[inline(always)]
        |l| if l < len { &states[l].motion } else { &BodyState::FIXED.motion },
    );
    let mut spin_most: Lane = [0.0; LANES];
    for (most, way) in spin_most.iter_mut().zip(ways) {
        *most = way.spin_most;
    }
    // Whether it goes at all, and whether it turns as well.
    let mut lanes = [(false, false); LANES];
    for ((goes, way), s) in lanes.iter_mut().zip(ways).zip(&*states) {
        *goes = (!way.goes_alone(s, h), !way.turns(s));
    }
    let h = L::splat(h);
    let v = within(Wide3::new(vx, vy, vz), L::splat(speed_most));
    let w = within(Wide3::new(wx, wy, wz), L::load(&spin_most));
    let p = Wide3::new(px, py, pz).add(v.scale(h));
    let r = w.scale(h);
    let turned = Wide3::new(rx, ry, rz).add(r);
    let x2 = L::splat(0.25) * r.dot(r);
    let f = L::splat(0.5) * (L::splat(15.0) - x2) / (L::splat(15.0) - L::splat(6.0) * x2);
    let turn = normalize(Turn([r.x * f, r.y * f, r.z * f, L::splat(1.0)]));
    let Turn(q) = normalize(turn.after(Turn([qx, qy, qz, qw])));
    L::scatter8(
        [v.x, v.y, v.z, w.x, w.y, w.z, p.x, p.y],
        #[inline(always)]
        |l, row| match lanes[l] {
            (true, true) => states[l].hot = row,
            (true, false) => {
                states[l].hot[..3].copy_from_slice(&row[..3]);
                states[l].hot[6..].copy_from_slice(&row[6..]);
            }
            (false, _) => {}
        },
    );
    L::scatter8(
        [p.z, turned.x, turned.y, turned.z, q[0], q[1], q[2], q[3]],
        #[inline(always)]
        |l, row| match lanes[l] {
            (true, true) => states[l].motion = row,
            (true, false) => states[l].motion[0] = row[0],
            (false, _) => {}
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::room::rigid::solve::{Substep, integrate_position};
    use crate::room::rigid::state::BodyFrame;
    use crate::{AxisLocks, BodyDesc, ShapeDesc, World, WorldDesc};
    use jounce_lanes::{Width, dispatch};
    use jounce_math::Vec3;

    /// Lanes of every width go where one by one goes, bit for bit.
    #[test]
    fn lanes_go_as_one_by_one() {
        let mut w = World::new(WorldDesc::default()).expect("valid");
        for i in 0..37_u32 {
            let x = |k: u32| ((i * 7 + k * 5) % 11) as f32 - 5.0;
            let size = if i % 5 == 0 { [0.5, 0.2, 0.1] } else { [0.5; 3] };
            let fast = if i % 7 == 0 { 400.0 } else { 3.0 };
            let shape = if i % 4 == 0 { ShapeDesc::sphere(0.5) } else { ShapeDesc::cuboid(size) };
            let d = BodyDesc::dynamic().at([f64::from(i) * 3.0, 0.0, 0.0]).shape(shape);
            let spin = if i % 7 == 0 { 400.0 } else { 1.0 };
            let d = d.velocity(Vec3::new(x(0), x(1), x(2)) * fast);
            let d = d.angular_velocity(Vec3::new(x(3), x(4), x(5)) * spin);
            let d = if i % 9 == 2 { d.locks(AxisLocks::PLANE_XY) } else { d };
            w.add_body(d).expect("valid");
        }
        let limits = SpeedLimits { speed: 1000.0, spin: 8.0, spin_jointed: 100.0 };
        let (h, a) = (1.0 / 240.0, &w.awake);
        let ways: Vec<Way> = a.step.iter().map(|b| Way::new(b, &w.bodies[b.body], &limits)).collect();
        assert!(ways.iter().any(|w| w.alone) && ways.iter().any(|w| !w.alone && !w.fast));
        let turns_far = |i: usize| ways[i].fast && ways[i].goes_alone(&a.state[i], h);
        assert!(
            (0..37).any(turns_far) && (0..37).any(|i| ways[i].fast && !turns_far(i)),
            "balls, fast and slow"
        );
        let mut expected = a.state.clone();
        let frames: &[BodyFrame] = &w.frames;
        let mut turned = 0;
        for _ in 0..3 {
            for (i, s) in expected.iter_mut().enumerate().filter(|(i, s)| !ways[*i].goes_alone(s, h)) {
                let (sub, mut to) = (Substep { h, limits }, *s);
                integrate_position(&mut to, &a.step[i], &mut None, &w.bodies, frames, &sub);
                if ways[i].turns(s) {
                    // Its turn comes after the way.
                    (to.hot[3..6]).copy_from_slice(&s.hot[3..6]);
                    (to.motion[1..]).copy_from_slice(&s.motion[1..]);
                    turned += 1;
                }
                *s = to;
            }
        }
        assert!(turned > 6);
        for width in Width::ALL {
            let mut states = a.state.clone();
            for _ in 0..3 {
                let go = Go { states: &mut states, ways: &ways, h, speed_most: limits.speed };
                dispatch(width, go);
            }
            for (a, b) in states.iter().zip(&expected) {
                let bits = |s: &BodyState| (s.hot.map(f32::to_bits), s.motion.map(f32::to_bits));
                assert_eq!(bits(a), bits(b), "{width}");
            }
        }
    }
}
