//! The whole-world validator: every table agrees with every other. Debug builds only.

use crate::room::contacts::state::{ContactPlace, PairHead, Place};
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::stage::broadphase::may_meet;
use crate::step::Stage;
use crate::table::pair_key;
use crate::world::World;
use jounce_tasks::ColorSets;

/// Runs after the stages that move rows, in debug builds of worlds small enough.
pub(crate) fn check_after(world: &World, stage: Stage) {
    if cfg!(debug_assertions) && stage == Stage::Publish && world.contacts.len() < 20_000 {
        world.validate();
        world.validate_bounds();
        if world.step_count.is_multiple_of(8) {
            world.validate_pairs();
        }
    }
}

impl World {
    /// At the end of a step every shape is within its fat bounds, whether it was looked at or not.
    fn validate_bounds(&self) {
        for b in &self.awake.step {
            for &s in &self.bodies[b.body].shapes {
                if matches!(self.shapes[s].place, Place::MovingTree(_)) {
                    let (fat, tight) = (&self.fat[s as usize], self.tight_bounds(s));
                    assert!(fat.contains(&tight), "shape {s} of body {}: {tight:?} left {fat:?}", b.body);
                }
            }
        }
    }
    /// What met as of the last pair search, and may, has its contact: the search passes over it.
    fn validate_pairs(&self) {
        let marked = self.tags.iter().filter(|t| t.moved()).count();
        assert_eq!(marked, self.moved.len(), "marks of the move buffer");
        for (s, r) in self.shapes.iter() {
            let tag = self.tags[s as usize];
            let bounded = matches!(r.place, Place::MovingTree(_));
            assert_eq!(tag.bounded_mover(), bounded && !r.sensor, "tag of shape {s}");
            if tag.moved() || r.place == Place::Nowhere || self.pairs_missing || self.hooks.filter.is_some() {
                continue;
            }
            let fat = &self.fat[s as usize];
            assert!(
                r.place == Place::Unbounded || self.fat_before[s as usize] == *fat,
                "bounds of shape {s}"
            );
            if bounded {
                self.moving_tree.get().query(fat, |other| {
                    let known = self.tags[other as usize].moved()
                        || !may_meet(self, s, other)
                        || self.pairs.contains(pair_key(s, other));
                    assert!(known, "shapes {s} and {other} have no contact");
                    true
                });
            }
        }
    }
    /// Asserts that every table agrees with every other. For tests; costs about as much as a step.
    ///
    /// # Panics
    /// On an inconsistency, which is a bug of the engine.
    pub fn validate(&self) {
        for (row, b) in self.awake.step.iter().enumerate() {
            let body = &self.bodies[b.body];
            assert_eq!(body.row, row as u32, "row of body {}", b.body);
            assert_eq!(self.frames[b.body as usize].row, row as u32, "row of frame {}", b.body);
            assert!(body.enabled && body.island == NONE, "an awake body is enabled and in no island");
        }
        for (slot, body) in self.bodies.iter() {
            assert_eq!(self.frames[slot as usize].looks_ahead, body.looks_ahead(), "outlook of body {slot}");
            assert_eq!(self.row_of[slot as usize], body.row, "row listed of body {slot}");
            let item = match body.row {
                NONE => ColorSets::NONE,
                row if body.kind == BodyKind::Dynamic => row,
                row => ColorSets::shared(row),
            };
            assert_eq!(self.items[slot as usize], item, "item of body {slot}");
            if body.row != NONE {
                let b = &self.awake.step[body.row as usize];
                assert_eq!(b.body, slot);
                assert_eq!(
                    (b.radius, b.reach),
                    (body.mass.outer_radius, body.mass.reach),
                    "size of body {slot}"
                );
            }
            for &s in &body.shapes {
                assert_eq!(self.shapes[s].body, slot, "shape {s} is on body {slot}");
            }
            for &j in &body.joints {
                let joint = &self.joints.table[j];
                assert!(joint.body_a == slot || joint.body_b == slot, "joint {j} is of body {slot}");
            }
            for (i, &id) in body.contacts.iter().enumerate() {
                let Some(c) = self.contact(id) else { panic!("body {slot} lists dead contact {id}") };
                let side = usize::from(c.body_a != slot);
                assert_eq!(c.edge[side], i as u32, "edge of contact {id}");
            }
        }
        for (rows, asleep) in [(&self.contacts, false), (&self.asleep_contacts, true)] {
            for (row, c) in rows.iter().enumerate() {
                let place =
                    if asleep { ContactPlace::Asleep(row as u32) } else { ContactPlace::Awake(row as u32) };
                assert_eq!(self.places[c.id as usize], place, "place of contact {}", c.id);
                assert_eq!(
                    self.pairs.get(pair_key(c.shape_a, c.shape_b)),
                    Some(c.id),
                    "pair of contact {}",
                    c.id
                );
                let awake = self.bodies[c.body_a].row != NONE || self.bodies[c.body_b].row != NONE;
                assert_eq!(awake, !asleep, "contact {} sleeps exactly when no body of it is awake", c.id);
            }
        }
        assert_eq!(self.pairs.len(), self.contacts.len() + self.asleep_contacts.len());
        assert_eq!(self.heads.len(), self.contacts.len());
        for c in self.contacts.iter().chain(&self.asleep_contacts) {
            assert!(c.manifold.more || c.rest.is_empty(), "manifolds of contact {} are hidden", c.id);
        }
        for (c, h) in self.contacts.iter().zip(&self.heads) {
            assert_eq!(
                *h,
                PairHead { until: h.until, looked: h.looked, near: h.near, kept: h.kept, ..PairHead::new(c) },
                "head of contact {}",
                c.id
            );
        }
        for (slot, v) in self.vehicles.table.iter() {
            assert_eq!(self.bodies[v.chassis].vehicle, slot, "vehicle {slot} is of its chassis");
        }
        let mut particles = 0;
        for (slot, e) in self.particles.emitters.iter() {
            let blocks = e.blocks.iter().map(|&i| &self.particles.pool[i as usize]);
            let sum: usize = blocks.clone().map(|b| b.count).sum();
            assert_eq!(e.count, sum, "particles of emitter {slot}");
            assert!(blocks.clone().all(|b| b.emitter == slot && b.births == 0), "blocks of emitter {slot}");
            particles += sum;
        }
        assert_eq!(self.particles.count, particles, "particles of all emitters");
        for (island, bodies) in self.islands.iter() {
            for &b in bodies {
                assert_eq!(self.bodies[b].island, island, "island of body {b}");
                assert_eq!(self.bodies[b].row, NONE, "a sleeping body has no row");
            }
        }
    }
}
