//! Adding, changing and removing joints.

use super::desc::{JointDesc, JointFrames, JointKind, check_kind};
use super::path::Curve;
use super::rows::{Ends, Start};
use super::solve;
use super::state::Joint;
use crate::error::{Error, Result, check};
use crate::event::Event;
use crate::handle::JointId;
use crate::limits;
use crate::room::contacts::state::Contact;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::BodyFrame;
use crate::world::World;
use jounce_math::{Pose, Quat, Vec3, WorldPose};
use std::sync::Arc;

impl World {
    pub(crate) fn joint_id(&self, index: u32) -> JointId {
        JointId { index, generation: self.joints.table.generation(index) }
    }
    pub(crate) fn joint_slot(&self, id: JointId) -> Result<u32> {
        if self.joints.table.is_live(id.index, id.generation) {
            return Ok(id.index);
        }
        Err(Error::Stale { what: "joint", index: id.index, generation: id.generation })
    }

    pub(crate) fn do_add_joint(&mut self, mut d: JointDesc) -> Result<JointId> {
        d.check()?;
        if self.joints.table.len() >= limits::JOINTS_MAX {
            return Err(Error::Limit { what: "joints", limit: limits::JOINTS_MAX });
        }
        let [a, b] = match self.geared(&d.kind)? {
            Some(pair) => pair,
            None => [self.slot(d.body_a)?, self.slot(d.body_b)?],
        };
        for s in [a, b] {
            if self.bodies[s].joints.len() >= limits::JOINTS_PER_BODY_MAX {
                return Err(Error::Limit { what: "joints of a body", limit: limits::JOINTS_PER_BODY_MAX });
            }
        }
        let [pa, pb] = [a, b].map(|s| self.frames[s as usize].pose());
        let (frame_a, frame_b) = match d.frames {
            JointFrames::World(w) => {
                let w = WorldPose::new(w.p, w.q.normalize());
                (pa.relative(&w), pb.relative(&w))
            }
            JointFrames::Anchors(x, y) => {
                let q = Quat::IDENTITY;
                (pa.relative(&WorldPose::new(x, q)), pb.relative(&WorldPose::new(y, q)))
            }
            JointFrames::Local(x, y) => (Pose::new(x.p, x.q.normalize()), Pose::new(y.p, y.q.normalize())),
        };
        d.frames = JointFrames::Local(frame_a, frame_b);
        if let JointKind::Pulley { wheel_a, wheel_b, ratio, length } = &mut d.kind
            && length.is_none()
        {
            let (x, y) = (pa.transform_point(frame_a.p) - *wheel_a, pb.transform_point(frame_b.p) - *wheel_b);
            *length = Some((x.length() + f64::from(*ratio) * y.length()) as f32);
        }
        let curve = match &d.kind {
            JointKind::Path(p) => Some(Arc::new(Curve::new(p))),
            _ => None,
        };
        let enabled = d.enabled;
        let mut joint = Joint {
            body_a: a,
            body_b: b,
            frame_a,
            frame_b,
            curve,
            enabled,
            broken: false,
            hard: [0.0; 6],
            extra: Vec::new(),
            coordinate: 0.0,
            force: Vec3::ZERO,
            torque: Vec3::ZERO,
            last: [0.0; 2],
            desc: d,
        };
        self.first_coordinate(&mut joint);
        let (index, generation) = self.joints.table.insert(joint);
        self.joints.version += 1;
        for s in [a, b] {
            let list = &mut self.bodies[s].joints;
            let at = list.partition_point(|&x| x < index);
            list.insert(at, index);
        }
        self.part(index);
        self.wake_ends(index);
        Ok(JointId { index, generation })
    }

    /// Where the main axis stands as the joint is made; of a gear, where its two joints stand against each other.
    fn first_coordinate(&self, j: &mut Joint) {
        j.coordinate = match &j.desc.kind {
            JointKind::Gear { a, b, ratio } => {
                let of = |id: JointId| self.joints.table.get(id.index).map_or(0.0, |j| self.coordinate(j));
                of(*a) + ratio * of(*b)
            }
            JointKind::Path(_) => {
                let e = self.ends(j);
                j.curve.as_ref().map_or(0.0, |c| c.first(e.qa.inverse_rotate(e.d)))
            }
            _ => 0.0,
        };
    }

    /// A joint's two frames as the bodies stand.
    pub(crate) fn ends(&self, j: &Joint) -> Ends {
        let still = crate::room::rigid::state::BodyState::FIXED.get();
        Ends::now(&self.start(j), &still, &still)
    }
    /// The same in the form that a step starts from.
    pub(crate) fn start(&self, j: &Joint) -> Start {
        Start::new(j, &self.frames[j.body_a as usize], &self.frames[j.body_b as usize])
    }
    /// As the step began; for what asks at its end.
    pub(crate) fn start_before(&self, j: &Joint) -> Start {
        let before = |slot: u32| {
            let f = &self.frames[slot as usize];
            BodyFrame { center: f.center0, rotation: f.rotation0, ..*f }
        };
        Start::new(j, &before(j.body_a), &before(j.body_b))
    }
    /// Angle of a hinge (turns counted), or length along a slider or path, as the bodies stand.
    pub(crate) fn coordinate(&self, j: &Joint) -> f32 {
        let e = self.ends(j);
        match &j.desc.kind {
            JointKind::Slider(_) => e.along(e.axis_a(0)).c,
            JointKind::Distance { .. } | JointKind::Spring { .. } => e.distance().c,
            JointKind::Path(_) => {
                j.curve.as_ref().map_or(0.0, |c| c.nearest(e.qa.inverse_rotate(e.d), j.coordinate))
            }
            JointKind::Gear { .. } => j.coordinate,
            JointKind::Ball(_) => e.cone().c,
            JointKind::Generic { angular, .. } => super::generic::coordinate(angular, &e, j.coordinate).c,
            _ => super::hinge::angle(e.twist(), j.coordinate).c,
        }
    }

    pub(crate) fn do_remove_joint(&mut self, id: JointId) -> Result<()> {
        let slot = self.joint_slot(id)?;
        self.drop_joint(slot);
        Ok(())
    }

    /// Removes a joint, and the gears on it.
    pub(crate) fn drop_joint(&mut self, slot: u32) {
        if self.joints.table.get(slot).is_none() {
            return;
        }
        let id = self.joint_id(slot);
        let on = |k: &JointKind| matches!(k, JointKind::Gear { a, b, .. } if *a == id || *b == id);
        let j = &self.joints.table[slot];
        // A gear is in the list of the body that each of its joints moves.
        let lists = [j.body_a, j.body_b].into_iter().filter_map(|s| self.bodies.get(s));
        let mut gears: Vec<u32> = lists
            .flat_map(|b| b.joints.iter().copied())
            .filter(|&i| on(&self.joints.table[i].desc.kind))
            .collect();
        gears.sort_unstable();
        gears.dedup();
        for g in gears {
            self.drop_joint(g);
        }
        self.wake_ends(slot);
        let Some(j) = self.joints.table.remove(slot) else { return };
        self.joints.version += 1;
        for s in [j.body_a, j.body_b] {
            if let Some(b) = self.bodies.get_mut(s) {
                b.joints.retain(|&x| x != slot);
            }
            self.note_outlook(s);
        }
        if !j.desc.collide {
            self.let_meet(j.body_a, j.body_b);
        }
    }

    pub(crate) fn do_set_joint(&mut self, id: JointId, kind: JointKind) -> Result<()> {
        let slot = self.joint_slot(id)?;
        check_kind(&kind)?;
        let now = &self.joints.table[slot].desc.kind;
        check(
            now.name() == kind.name(),
            "joint",
            "kind",
            kind.name(),
            "the kind that the joint has (remove it and add another)",
        )?;
        let _ = self.geared(&kind)?;
        if let (JointKind::Gear { a, b, .. }, JointKind::Gear { a: c, b: d, .. }) = (now, &kind) {
            check(a == c, "gear", "a", c, "the joint that it has (remove it and add another)")?;
            check(b == d, "gear", "b", d, "the joint that it has (remove it and add another)")?;
        }
        let same_rows = solve::counts(now) == solve::counts(&kind) && !matches!(kind, JointKind::Gear { .. });
        self.wake_ends(slot);
        let j = &mut self.joints.table[slot];
        if let JointKind::Path(p) = &kind {
            j.curve = Some(Arc::new(Curve::new(p)));
        }
        let length = match j.desc.kind {
            JointKind::Pulley { length, .. } => length,
            _ => None,
        };
        j.desc.kind = kind;
        if let JointKind::Pulley { length: l, .. } = &mut j.desc.kind {
            *l = (*l).or(length);
        }
        j.extra.clear();
        if matches!(j.desc.kind, JointKind::Gear { .. } | JointKind::Path(_)) {
            // Where it stands by the new ratio or curve is right.
            let mut joint = j.clone();
            self.first_coordinate(&mut joint);
            self.joints.table[slot].coordinate = joint.coordinate;
        }
        self.joints.edits += 1;
        if !same_rows {
            self.joints.version += 1;
        }
        Ok(())
    }

    pub(crate) fn do_enable_joint(&mut self, id: JointId, on: bool) -> Result<()> {
        let slot = self.joint_slot(id)?;
        let j = &mut self.joints.table[slot];
        if j.acts() == on {
            return Ok(());
        }
        (j.enabled, j.broken) = (on, false);
        j.forget();
        self.joints.version += 1;
        if on {
            self.part(slot);
        } else {
            let (a, b) = (j.body_a, j.body_b);
            self.let_meet(a, b);
        }
        self.wake_ends(slot);
        Ok(())
    }

    /// Lets go of a joint that was loaded beyond what it stands.
    pub(crate) fn break_joint(&mut self, slot: u32, force: f32, torque: f32) {
        let joint = self.joint_id(slot);
        let j = &mut self.joints.table[slot];
        j.broken = true;
        j.forget();
        let (a, b) = (j.body_a, j.body_b);
        self.joints.version += 1;
        self.events.push(Event::JointBreak { joint, force, torque });
        self.let_meet(a, b);
        self.wake_ends(slot);
    }

    pub(crate) fn wake_ends(&mut self, slot: u32) {
        let j = &self.joints.table[slot];
        let (a, b) = (j.body_a, j.body_b);
        for s in [a, b] {
            if self.bodies.get(s).is_some() {
                self.wake_body(s);
            }
        }
    }

    /// Do two bodies hang together by a joint that keeps them from colliding?
    pub(crate) fn are_parted(&self, a: u32, b: u32) -> bool {
        if self.joints.is_empty() {
            return false;
        }
        let (x, y) = (&self.bodies[a].joints, &self.bodies[b].joints);
        let (list, other) = if x.len() <= y.len() { (x, b) } else { (y, a) };
        list.iter().any(|&j| {
            let j = &self.joints.table[j];
            j.acts() && !j.desc.collide && !j.is_gear() && (j.body_a == other || j.body_b == other)
        })
    }

    /// Contacts of bodies that a joint parts go; their others are tested anew.
    fn part(&mut self, slot: u32) {
        let j = &self.joints.table[slot];
        let (a, b) = (j.body_a, j.body_b);
        // Bodies on joints look ahead.
        for body in [a, b] {
            if self.bodies[body].kind == BodyKind::Dynamic {
                self.forget_tests(body);
            }
        }
        if !self.are_parted(a, b) {
            return;
        }
        let list = if self.bodies[a].contacts.is_empty() { b } else { a };
        let between = |c: &Contact| (c.body_a == a && c.body_b == b) || (c.body_a == b && c.body_b == a);
        let mut ids: Vec<u32> = [list, if list == a { b } else { a }]
            .into_iter()
            .flat_map(|s| self.bodies[s].contacts.iter().copied())
            .filter(|&id| self.contact(id).is_some_and(between))
            .collect();
        ids.sort_unstable();
        ids.dedup();
        for id in ids {
            self.unlink_contact(id);
        }
    }

    /// Bodies that were parted may meet: their shapes are looked up anew.
    fn let_meet(&mut self, a: u32, b: u32) {
        for s in [a, b] {
            let Some(body) = self.bodies.get(s) else { continue };
            for shape in body.shapes.clone() {
                if self.shapes[shape].place != crate::room::contacts::state::Place::Nowhere {
                    self.mark_moved(shape);
                }
            }
        }
    }
}
