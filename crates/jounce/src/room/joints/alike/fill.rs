//! Records into lanes, once per step, and back.

use super::pattern::Kind;
use super::{Band, JointLanes, NOBODY, Z};
use crate::room::contacts::rows::LANES;
use crate::room::joints::extra::gains;
use crate::room::joints::parts::{Parts, set_quat};
use crate::room::joints::rows::Start;
use crate::room::joints::state::Joint;
use crate::room::rigid::state::InvInertia;
use jounce_math::{Mat3, Quat, Vec3};

/// A body as a lane takes it.
pub(crate) struct Side {
    pub row: u32,
    pub inv_mass: f32,
    /// Centre of mass from that of the set's first body.
    pub at: Vec3,
    /// World inertia and inverse at the start of the step.
    pub inertia: Mat3,
    pub inverse: InvInertia,
}

impl Band {
    /// No set in any lane.
    pub fn clear(&mut self) {
        (self.any_pull, self.any_drive) = (false, false);
        for b in &mut self.bodies {
            b.rows = [NOBODY; LANES];
            b.inv_mass = Z;
            (b.inertia, b.inverse) = ([Z; 6], [Z; 6]);
        }
        for (j, link) in self.joints.iter_mut().zip(&self.pattern.joints) {
            for row in &mut j.rows[link.kind.first_end()..] {
                row.acts = Z;
            }
        }
    }

    pub fn fill_body(&mut self, body: usize, l: usize, s: &Side) {
        let (b, l) = (&mut self.bodies[body], l % LANES);
        b.rows[l] = s.row;
        b.inv_mass[l] = s.inv_mass;
        b.at.set(l, s.at);
        let (i, t) = (&s.inertia, &s.inverse);
        let whole = [i.cx.x, i.cy.y, i.cz.z, i.cy.x, i.cz.x, i.cz.y];
        for (to, from) in b.inertia.iter_mut().zip(whole) {
            to[l] = from;
        }
        for (to, from) in b.inverse.iter_mut().zip([t.xx, t.yy, t.zz, t.xy, t.xz, t.yz]) {
            to[l] = from;
        }
    }

    /// Lane `l` of joint `i` becomes this one; `h`: the substep, s.
    pub fn fill_joint(&mut self, i: usize, l: usize, j: &Joint, start: &Start, h: f32) {
        let kind = self.pattern.joints[i].kind;
        let [pulls, drives] = self.joints[i].fill(kind, l % LANES, j, start, h);
        self.any_pull |= pulls;
        self.any_drive |= drives;
    }

    /// Lane `l` of joint `i` back to its record; tells whether it broke.
    pub fn store_joint(&self, i: usize, l: usize, j: &mut Joint, dt: f32, qa: Quat) -> bool {
        self.joints[i].store(self.pattern.joints[i].kind, l % LANES, j, dt, qa)
    }
}

/// Rows of the cone and of the twist.
fn end_rows(kind: Kind) -> [usize; 2] {
    match kind {
        Kind::Ball { cone, .. } => [3, 3 + usize::from(cone)],
        _ => [0, 5],
    }
}

impl JointLanes {
    fn fill(&mut self, kind: Kind, l: usize, j: &Joint, start: &Start, h: f32) -> [bool; 2] {
        self.ra.set(l, start.ra);
        self.rb.set(l, start.rb);
        self.offset.set(l, start.offset);
        set_quat(&mut self.qa, l, start.qa.normalize());
        set_quat(&mut self.qb, l, start.qb.normalize());
        let e = Parts::of(&j.desc.kind);
        let extra = |i: usize| j.extra.get(i).copied().unwrap_or(0.0);
        for row in &mut self.rows {
            row.lambda[l] = 0.0;
            row.acts[l] = 1.0;
        }
        let pull = start.qa.rotate(Vec3::new(j.hard[0], j.hard[1], j.hard[2]));
        for i in 0..3 {
            self.rows[i].lambda[l] = pull[i];
        }
        let [cone, twist] = end_rows(kind);
        if let Some((at, angle)) = e.cone {
            self.cone[l] = angle;
            self.rows[cone].acts[l] = f32::from(u8::from(extra(at) != 0.0));
        }
        if let Some((at, limit)) = e.twist {
            (self.twist[0][l], self.twist[1][l]) = (limit.min, limit.max);
            let x = extra(at);
            self.rows[twist].acts[l] = f32::from(u8::from(x != 0.0));
            self.rows[twist].sign[l] = if x < 0.0 { -1.0 } else { 1.0 };
        }
        let (gain, rest, speed) = e.pull.as_ref().map_or(([0.0; 3], Quat::IDENTITY, Vec3::ZERO), |p| {
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
        if let Some((at, d)) = &e.drive {
            (most, speed) = (d.max * h, d.speed);
            impulse.x = extra(*at);
            if matches!(kind, Kind::Ball { .. }) {
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
        [e.pull.is_some(), e.drive.is_some()]
    }

    fn store(&self, kind: Kind, l: usize, j: &mut Joint, dt: f32, qa: Quat) -> bool {
        let lambda = |i: usize| self.rows[i].lambda[l];
        // The set's rows are along A's axes.
        let p = qa.inverse_rotate(Vec3::new(lambda(0), lambda(1), lambda(2)));
        j.hard = [p.x, p.y, p.z, 0.0, 0.0, 0.0];
        let e = Parts::of(&j.desc.kind);
        j.extra.clear();
        j.extra.resize(e.count, 0.0);
        let [cone, twist] = end_rows(kind);
        if let Some((at, _)) = e.cone {
            j.extra[at] = -lambda(cone);
        }
        if let Some((at, _)) = e.twist {
            j.extra[at] = self.rows[twist].sign[l] * lambda(twist);
        }
        if let Some((at, _)) = e.drive {
            let d = self.drive_impulse.get(l);
            j.extra[at] = d.x;
            if matches!(kind, Kind::Ball { .. }) {
                (j.extra[at + 1], j.extra[at + 2]) = (d.y, d.z);
            }
        }
        (j.force, j.torque) = (self.force.get(l) * (1.0 / dt), self.torque.get(l) * (1.0 / dt));
        j.last = [self.last[0][l], self.last[1][l]];
        self.broke[l] != 0.0
    }
}
