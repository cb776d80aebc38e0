//! Records into blocks, once per step, and back. Impulses in the records are along A's axes, as the solver of sets has them.

use super::{Block, NO_CONE, Type};
use crate::room::contacts::rows::LANES;
use crate::room::joints::extra::gains;
use crate::room::joints::parts::{Parts, set_quat};
use crate::room::joints::rows::Start;
use crate::room::joints::state::Joint;
use crate::room::rigid::state::InvInertia;
use jounce_math::{Quat, Vec3, scalar::f32s};

impl Block {
    /// Lane `l` becomes this joint; `sides` are inverse mass and inertia of its bodies.
    pub fn fill(
        &mut self,
        l: usize,
        kind: Type,
        j: &Joint,
        s: &Start,
        sides: [(f32, InvInertia); 2],
        h: f32,
    ) {
        let l = l % LANES;
        self.ra.set(l, s.ra);
        self.rb.set(l, s.rb);
        self.offset.set(l, s.offset);
        let (qa, qb) = (s.qa.normalize(), s.qb.normalize());
        set_quat(&mut self.qa, l, qa);
        set_quat(&mut self.qb, l, qb);
        for (i, (inv_mass, t)) in sides.iter().enumerate() {
            self.inv_mass[i][l] = *inv_mass;
            for (to, from) in self.inertia[i].iter_mut().zip([t.xx, t.yy, t.zz, t.xy, t.xz, t.yz]) {
                to[l] = from;
            }
        }
        let [p, t] = [0, 3].map(|i: usize| Vec3::new(j.hard[i], j.hard[i + 1], j.hard[i + 2]));
        self.point.set(l, qa.rotate(p));
        self.turn.set(l, if kind == Type::Fixed { qa.rotate(t) } else { t });
        let parts = Parts::of(&j.desc.kind);
        let extra = |i: usize| j.extra.get(i).copied().unwrap_or(0.0);
        self.end_impulse.iter_mut().for_each(|e| e[l] = 0.0);
        self.cone[l] = NO_CONE;
        if let Some((at, angle)) = parts.cone {
            self.cone[l] = f32s::cos(angle);
            self.end_impulse[0][l] = f32s::max(-extra(at), 0.0);
        }
        let mut ends = [[0.0; 2]; 2];
        if let Some((at, limit)) = parts.twist {
            ends = [limit.min, limit.max].map(|x| [f32s::cos(0.5 * x), f32s::sin(0.5 * x)]);
            self.end_impulse[1][l] = f32s::max(extra(at), 0.0);
            self.end_impulse[2][l] = f32s::max(-extra(at), 0.0);
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
        self.pull_impulse.set(l, Vec3::ZERO);
        let (mut most, mut speed, mut impulse) = (0.0, Vec3::ZERO, Vec3::ZERO);
        if let Some((at, d)) = &parts.drive {
            (most, speed) = (d.max * h, d.speed);
            impulse.x = extra(*at);
            if kind == Type::Ball {
                (impulse.y, impulse.z) = (extra(at + 1), extra(at + 2));
            }
        }
        self.drive[l] = most;
        self.drive_speed.set(l, speed);
        self.drive_impulse.set(l, impulse);
        self.force.set(l, Vec3::ZERO);
        self.torque.set(l, Vec3::ZERO);
        for i in 0..2 {
            self.last[i][l] = j.last[i];
        }
        (self.bound[0][l], self.bound[1][l]) = (j.desc.break_force, j.desc.break_torque);
        self.broke[l] = 0.0;
        self.any_ends |= parts.cone.is_some() || parts.twist.is_some();
        self.any_pull |= parts.pull.is_some();
        self.any_drive |= parts.drive.is_some();
    }

    /// Lane `l` back to the joint, whose frame on A is `qa` now; tells whether it broke.
    pub fn store(&self, l: usize, kind: Type, j: &mut Joint, dt: f32, qa: Quat) -> bool {
        let l = l % LANES;
        let (p, t) = (qa.inverse_rotate(self.point.get(l)), self.turn.get(l));
        let t = if kind == Type::Fixed { qa.inverse_rotate(t) } else { t };
        j.hard = [p.x, p.y, p.z, t.x, t.y, t.z];
        let parts = Parts::of(&j.desc.kind);
        j.extra.clear();
        j.extra.resize(parts.count, 0.0);
        if let Some((at, _)) = parts.cone {
            j.extra[at] = -self.end_impulse[0][l];
        }
        if let Some((at, _)) = parts.twist {
            j.extra[at] = self.end_impulse[1][l] - self.end_impulse[2][l];
        }
        if let Some((at, _)) = parts.drive {
            let d = self.drive_impulse.get(l);
            j.extra[at] = d.x;
            if kind == Type::Ball {
                (j.extra[at + 1], j.extra[at + 2]) = (d.y, d.z);
            }
        }
        (j.force, j.torque) = (self.force.get(l) * (1.0 / dt), self.torque.get(l) * (1.0 / dt));
        j.last = [self.last[0][l], self.last[1][l]];
        self.broke[l] != 0.0
    }
}
