//! The state hash: one `u64` over everything that a step, or a call between steps, leaves behind.
//!
//! Not cryptographic: a 64×64→128 multiply folds each word into the state (the idea of wyhash). Words are fed in a fixed order,
//! floats by their bits. The queue goes in by the text of its commands (`{:?}`), which has every number in full.

use crate::event::Event;
use crate::room::contacts::state::{Contact, Place, ShapeRecord};
use crate::room::rigid::state::{Body, BodyFrame};
use crate::world::World;
use core::fmt::Write;
use jounce_geometry::Aabb;
use jounce_math::{DVec3, Pose, Quat, Vec3};

/// Incremental 64-bit hash of words.
#[derive(Clone, Copy, Debug)]
pub struct StateHasher {
    state: u64,
}

impl Default for StateHasher {
    fn default() -> Self {
        Self { state: 0x6a6f_756e_6365_0001 }
    }
}

impl StateHasher {
    /// Folds in one word.
    #[inline(always)]
    pub fn word(&mut self, w: u64) {
        let a = u128::from(self.state ^ w ^ 0xa076_1d64_78bd_642f)
            * u128::from(w.rotate_left(32) ^ 0xe703_7ed1_a0b4_28db);
        self.state =
            (a as u64) ^ ((a >> 64) as u64) ^ self.state.rotate_left(23).wrapping_mul(0x8ebc_6af0_9c88_c6e3);
    }
    /// Two `u32`.
    #[inline(always)]
    pub fn pair(&mut self, a: u32, b: u32) {
        self.word((u64::from(a) << 32) | u64::from(b));
    }
    /// Two `f32` by their bits.
    #[inline(always)]
    pub fn floats(&mut self, a: f32, b: f32) {
        self.pair(a.to_bits(), b.to_bits());
    }
    /// An `f64` by its bits.
    pub fn double(&mut self, a: f64) {
        self.word(a.to_bits());
    }
    /// A vector.
    pub fn vec3(&mut self, v: Vec3) {
        self.floats(v.x, v.y);
        self.pair(v.z.to_bits(), 0);
    }
    /// A world position.
    pub fn dvec3(&mut self, v: DVec3) {
        self.double(v.x);
        self.double(v.y);
        self.double(v.z);
    }
    /// A rotation.
    pub fn quat(&mut self, q: Quat) {
        self.floats(q.x, q.y);
        self.floats(q.z, q.w);
    }
    /// A local pose.
    pub fn pose(&mut self, p: &Pose) {
        self.vec3(p.p);
        self.quat(p.q);
    }
    /// The hash so far.
    pub fn finish(&self) -> u64 {
        let mut h = *self;
        h.word(0x9e37_79b9_7f4a_7c15);
        h.state
    }
}

impl World {
    /// One number over the state: poses, velocities, forces, contacts with their impulses, who sleeps, sensors' visitors, fields,
    /// the events of the last step, the callers' numbers, and what waits for the next step (queued commands, events of edits).
    ///
    /// Worlds with the same state have the same hash; that two with different states have it too takes a collision of 64 bits. Of
    /// worlds that were made alike and edited alike, equal hashes therefore mean equal futures. Not in it is what only
    /// descriptions and edits set and no step changes: settings and step length, geometry, surfaces and filters of the shapes,
    /// names, hooks; nor the part of a step that [`World::advance`] has yet to make.
    pub fn hash(&self) -> u64 {
        let mut h = StateHasher::default();
        h.word(self.step_count);
        h.vec3(self.gravity);
        for w in self.bodies.allocator_words().chain(self.shapes.allocator_words()) {
            h.pair(w, 1);
        }
        for (i, b) in self.bodies.iter() {
            let (v, w) = self.velocities(b);
            h.pair(i, b.row);
            hash_body(&mut h, b, &self.frames[i as usize]);
            h.vec3(v);
            h.vec3(w);
        }
        for ((s, t), turning) in self.awake.step.iter().zip(&self.awake.inertia).zip(&self.awake.turning) {
            h.vec3(s.force);
            h.vec3(s.torque);
            h.floats(s.sleep_timer, t.xx);
            h.floats(s.raised, t.inv_mass);
            h.floats(s.moved[0], 0.0);
            h.pair(
                u32::from(s.guided) | (u32::from(s.halted) << 1),
                u32::from(turning.is_some()) | (u32::from(s.target.is_some()) << 1),
            );
            if let Some(t) = turning {
                h.dvec3(t.momentum);
                h.vec3(t.w);
                [t.q.x, t.q.y, t.q.z, t.q.w].into_iter().for_each(|x| h.double(x));
                h.quat(t.rotation);
                h.quat(t.dq);
            }
            for d in s.drift.into_iter().chain(s.swing).filter(|d| *d != Vec3::ZERO) {
                h.vec3(d);
            }
            if let Some(target) = s.target {
                h.dvec3(target.p);
                h.quat(target.q);
            }
        }
        for (i, s) in self.shapes.iter() {
            hash_shape(&mut h, i, s, &self.fat[i as usize]);
        }
        for (place, rows) in [(0, &self.contacts), (1, &self.asleep_contacts)] {
            h.pair(place, rows.len() as u32);
            rows.iter().for_each(|c| hash_contact(&mut h, c));
        }
        for x in &self.heads {
            let [a, b] = x.bodies.map(|b| self.travel[b as usize][0]);
            h.double(if x.until.is_finite() && !x.touching { x.until - (a + b) } else { -1.0 });
        }
        for &id in &self.free_contacts {
            h.pair(id, 2);
        }
        for (i, bodies) in self.islands.iter() {
            h.pair(i, bodies.len() as u32);
            bodies.iter().for_each(|&b| h.pair(b, 3));
        }
        if !self.fields.is_empty() {
            self.hash_fields(&mut h);
        }
        self.particles.hash(&mut h);
        self.joints.hash(&mut h);
        self.vehicles.hash(&mut h);
        self.characters.hash(&mut h);
        self.told.last().iter().for_each(|e| hash_event(&mut h, e));
        self.hash_waiting(&mut h);
        h.finish()
    }
}

impl World {
    /// What waits for the next step: events of edits, and the queue. Nothing waiting is no word.
    fn hash_waiting(&self, h: &mut StateHasher) {
        if !self.events.is_empty() {
            h.pair(self.events.len() as u32, 5);
            self.events.iter().for_each(|e| hash_event(h, e));
        }
        if !self.queue.is_empty() {
            h.pair(self.queue.len() as u32, 6);
            let mut words = Words { h, word: 0, bytes: 0 };
            for command in &self.queue {
                // A `Words` takes everything in.
                let _ = writeln!(words, "{command:?}");
            }
            words.h.word(words.word);
        }
    }
}

/// Text as words of eight bytes: of a command, the name of its kind and all its numbers, written so that they can be read back.
struct Words<'a> {
    h: &'a mut StateHasher,
    word: u64,
    bytes: u32,
}

impl core::fmt::Write for Words<'_> {
    fn write_str(&mut self, s: &str) -> core::fmt::Result {
        for b in s.bytes() {
            self.word = (self.word << 8) | u64::from(b);
            self.bytes += 1;
            if self.bytes.is_multiple_of(8) {
                self.h.word(self.word);
                self.word = 0;
            }
        }
        Ok(())
    }
}

/// The caller's number; zero, the default, is no word.
fn hash_user_data(h: &mut StateHasher, data: u128, what: u32) {
    if data != 0 {
        h.pair(7, what);
        h.word((data >> 64) as u64);
        h.word(data as u64);
    }
}

fn hash_body(h: &mut StateHasher, b: &Body, f: &BodyFrame) {
    let flags = [b.enabled, b.bullet, b.fast_rotation, b.can_sleep];
    h.pair(b.kind as u32, flags.iter().fold(0, |x, &f| (x << 1) | u32::from(f)));
    h.pair(b.island, u32::from(crate::room::rigid::state::lock_bits(&b.locks)));
    h.floats(b.linear_damping, b.angular_damping);
    h.floats(b.gravity_scale, b.sleep_speed.unwrap_or(-1.0));
    h.floats(b.mass.mass, b.mass.inertia.cx.x);
    h.dvec3(f.center);
    h.quat(f.rotation);
    h.vec3(f.local_center);
    for &id in &b.contacts {
        h.pair(id, 4);
    }
    hash_user_data(h, b.user_data, 0);
}

fn hash_shape(h: &mut StateHasher, i: u32, s: &ShapeRecord, fat: &Aabb) {
    // The default is no word: worlds without fields keep their hashes.
    if s.aero != crate::Aero::default() {
        h.floats(s.aero.drag.unwrap_or(-1.0), s.aero.area.unwrap_or(-1.0));
        h.floats(s.aero.stokes_radius.unwrap_or(-1.0), s.aero.lift);
    }
    h.pair(i, s.body);
    h.pose(&s.pose);
    let place = match s.place {
        Place::Nowhere => 0,
        Place::FixedTree(_) => 1,
        Place::MovingTree(_) => 2,
        Place::Unbounded => 3,
    };
    h.pair(place, u32::from(s.sensor));
    h.vec3(fat.min);
    h.vec3(fat.max);
    for &(a, b) in &s.visitors {
        h.pair(a, b);
    }
    hash_user_data(h, s.user_data, 1);
}

fn hash_contact(h: &mut StateHasher, c: &Contact) {
    h.pair(c.shape_a, c.shape_b);
    h.pair(c.id, u32::from(c.touching) | (u32::from(c.tested) << 1));
    h.pose(&c.tested_pose);
    h.floats(c.spare, 0.0);
    c.tested_rotations.into_iter().for_each(|q| h.quat(q));
    for m in c.manifolds() {
        h.vec3(m.normal);
        h.vec3(m.offset);
        h.pair(u32::from(m.count), u32::from(m.stick));
        h.vec3(m.friction);
        h.vec3(m.rolling);
        h.vec3(m.slip);
        h.floats(m.twist, m.surface.static_friction);
        for ((p, at), total) in m.points().zip(m.totals) {
            h.vec3(at.on_a);
            h.vec3(at.on_b);
            h.vec3(p.arm);
            h.floats(p.separation, p.impulse);
            h.pair(at.feature, total.to_bits());
        }
    }
}

fn hash_event(h: &mut StateHasher, e: &Event) {
    match *e {
        Event::ContactBegin { a, b } => [1, a.to_bits(), b.to_bits()].into_iter().for_each(|w| h.word(w)),
        Event::ContactEnd { a, b } => [2, a.to_bits(), b.to_bits()].into_iter().for_each(|w| h.word(w)),
        Event::ContactHit { a, b, point, normal, speed, impulse } => {
            [3, a.to_bits(), b.to_bits()].into_iter().for_each(|w| h.word(w));
            h.dvec3(point);
            h.vec3(normal);
            h.floats(speed, impulse);
        }
        Event::SensorEnter { sensor, visitor } => {
            [4, sensor.to_bits(), visitor.to_bits()].into_iter().for_each(|w| h.word(w));
        }
        Event::SensorLeave { sensor, visitor } => {
            [5, sensor.to_bits(), visitor.to_bits()].into_iter().for_each(|w| h.word(w));
        }
        Event::Sleep { body } => [6, body.to_bits()].into_iter().for_each(|w| h.word(w)),
        Event::Wake { body } => [7, body.to_bits()].into_iter().for_each(|w| h.word(w)),
        Event::Quarantine { body } => [8, body.to_bits()].into_iter().for_each(|w| h.word(w)),
        Event::SpeedLimited { body } => [10, body.to_bits()].into_iter().for_each(|w| h.word(w)),
        Event::ParticleHit { emitter, shape, point, normal, speed } => {
            [11, emitter.to_bits(), shape.to_bits()].into_iter().for_each(|w| h.word(w));
            h.dvec3(point);
            h.vec3(normal);
            h.floats(speed, 0.0);
        }
        Event::JointBreak { joint, force, torque } => {
            h.word(13);
            h.word(joint.to_bits());
            h.floats(force, torque);
        }
        Event::EmitterFinished { emitter } => [12, emitter.to_bits()].into_iter().for_each(|w| h.word(w)),
        Event::LimitReached { what } => h.word(0x900 + what.len() as u64),
    }
}
