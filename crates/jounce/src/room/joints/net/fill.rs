//! Records into blocks, once per step, and back. Impulses in the records are along A's axes, as the solver of sets has them.

use super::{Block, NO_CONE, Places, Type};
use crate::room::contacts::rows::LANES;
use crate::room::joints::desc::JointDesc;
use crate::room::joints::extra::gains;
use crate::room::joints::parts::{Parts, set_quat};
use crate::room::joints::rows::Start;
use crate::room::joints::state::Joint;
use crate::room::rigid::state::InvInertia;
use jounce_math::{Quat, Vec3, scalar::f32s};

impl Places {
    fn of(parts: &Parts, kind: Type) -> Self {
        let at = |i: Option<usize>| i.and_then(|i| u8::try_from(i).ok()).unwrap_or(u8::MAX);
        Self {
            cone: at(parts.cone.map(|c| c.0)),
            twist: at(parts.twist.map(|t| t.0)),
            drive: at(parts.drive.as_ref().map(|d| d.0)),
            axes: if kind == Type::Ball { 3 } else { 1 },
            count: parts.count as u8,
        }
    }
}

impl Block {
    /// What a joint is, in lane `l`; `h`: the substep, s.
    pub fn describe(&mut self, l: usize, kind: Type, d: &JointDesc, h: f32) {
        let l = l % LANES;
        let parts = Parts::of(&d.kind);
        self.cone[l] = parts.cone.map_or(NO_CONE, |(_, angle)| f32s::cos(angle));
        let mut ends = [[0.0; 2]; 2];
        if let Some((_, limit)) = parts.twist {
            ends = [limit.min, limit.max].map(|x| [f32s::cos(0.5 * x), f32s::sin(0.5 * x)]);
        }
        for (to, [c, s]) in self.ends.iter_mut().zip(ends) {
            (to[0][l], to[1][l]) = (c, s);
        }
        let (gain, rest, speed) = parts.pull.as_ref().map_or(([0.0; 3], Quat::IDENTITY, Vec3::ZERO), |p| {
            let (a, b) = gains(&p.spring, 1.0, h);
            ([a, b, p.max * h], p.rest, p.speed)
        });
        for (to, from) in self.pull.iter_mut().zip(gain) {
            to[l] = from;
        }
        set_quat(&mut self.rest, l, rest);
        self.pull_speed.set(l, speed);
        let (most, speed) = parts.drive.as_ref().map_or((0.0, Vec3::ZERO), |(_, d)| (d.max * h, d.speed));
        self.drive[l] = most;
        self.drive_speed.set(l, speed);
        (self.bound[0][l], self.bound[1][l]) = (d.break_force, d.break_torque);
        self.places[l] = Places::of(&parts, kind);
        self.any_ends |= parts.cone.is_some() || parts.twist.is_some();
        self.any_pull |= parts.pull.is_some();
        self.any_drive |= parts.drive.is_some();
    }

    /// Where a joint stands as a step starts, and the impulses that it starts from; `sides` are inverse mass and inertia of its bodies.
    pub fn begin(&mut self, l: usize, kind: Type, j: &Joint, s: &Start, sides: [(f32, InvInertia); 2]) {
        let l = l % LANES;
        self.ra.set(l, s.ra);
        self.rb.set(l, s.rb);
        self.offset.set(l, s.offset);
        let (qa, qb) = (s.qa.normalize(), s.qb.normalize());
        set_quat(&mut self.qa, l, qa);
        set_quat(&mut self.qb, l, qb);
        self.now.ra.set(l, s.ra);
        self.now.rb.set(l, s.rb);
        self.now.d.set(l, s.offset + (s.rb - s.ra));
        set_quat(&mut self.now.qa, l, qa);
        set_quat(&mut self.now.qb, l, qb);
        for (i, (inv_mass, t)) in sides.iter().enumerate() {
            self.inv_mass[i][l] = *inv_mass;
            for (to, from) in self.inertia[i].iter_mut().zip([t.xx, t.yy, t.zz, t.xy, t.xz, t.yz]) {
                to[l] = from;
            }
        }
        let [p, t] = [0, 3].map(|i: usize| Vec3::new(j.hard[i], j.hard[i + 1], j.hard[i + 2]));
        self.point.set(l, qa.rotate(p));
        self.turn.set(l, if kind == Type::Fixed { qa.rotate(t) } else { t });
        self.force.set(l, Vec3::ZERO);
        self.torque.set(l, Vec3::ZERO);
        for i in 0..2 {
            self.last[i][l] = j.last[i];
        }
        self.broke[l] = 0.0;
        if !(self.any_ends || self.any_pull || self.any_drive) {
            return;
        }
        let Places { cone, twist, drive, axes, .. } = self.places[l];
        let extra = |i: u8| j.extra.get(usize::from(i)).copied().unwrap_or(0.0);
        self.end_impulse[0][l] = f32s::max(-extra(cone), 0.0);
        self.end_impulse[1][l] = f32s::max(extra(twist), 0.0);
        self.end_impulse[2][l] = f32s::max(-extra(twist), 0.0);
        self.pull_impulse.set(l, Vec3::ZERO);
        let axis = |i: u8| if i < axes { extra(drive.saturating_add(i)) } else { 0.0 };
        self.drive_impulse.set(l, Vec3::new(axis(0), axis(1), axis(2)));
    }

    /// Lane `l` back to the joint; tells whether it broke. The last pass has left its impulses along A's axes.
    pub fn store(&self, l: usize, j: &mut Joint, dt: f32) -> bool {
        let l = l % LANES;
        let (p, t) = (self.point.get(l), self.turn.get(l));
        j.hard = [p.x, p.y, p.z, t.x, t.y, t.z];
        let Places { cone, twist, drive, axes, count } = self.places[l];
        j.extra.clear();
        j.extra.resize(usize::from(count), 0.0);
        let mut put = |i: u8, x: f32| {
            if let Some(to) = j.extra.get_mut(usize::from(i)) {
                *to = x;
            }
        };
        put(cone, -self.end_impulse[0][l]);
        put(twist, self.end_impulse[1][l] - self.end_impulse[2][l]);
        let d = self.drive_impulse.get(l);
        for (i, x) in [d.x, d.y, d.z].into_iter().enumerate().take(usize::from(axes)) {
            put(drive.saturating_add(i as u8), x);
        }
        (j.force, j.torque) = (self.force.get(l) * (1.0 / dt), self.torque.get(l) * (1.0 / dt));
        j.last = [self.last[0][l], self.last[1][l]];
        self.broke[l] != 0.0
    }
}
