//! Sleeping and waking: moving rows between the awake columns and the records.

use crate::event::Event;
use crate::room::contacts::state::{Contact, ContactPlace, PairHead, Place};
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::stage::broadphase::{may_meet, near_plane};
use crate::table::pair_key;
use crate::world::World;
use jounce_math::Vec3;

impl World {
    /// Gives the body, and all that sleeps with it, rows again.
    pub(crate) fn wake_body(&mut self, slot: u32) {
        let island = self.bodies[slot].island;
        if island != NONE {
            self.wake_island(island);
        }
        if let Some(step) = self.step_mut(slot) {
            step.sleep_timer = 0.0;
        }
    }

    pub(crate) fn wake_island(&mut self, island: u32) {
        let Some(mut bodies) = self.islands.remove(island) else { return };
        for &slot in &bodies {
            let b = &mut self.bodies[slot];
            b.island = NONE;
            if b.enabled {
                self.push_row(slot);
                self.events.push(Event::Wake { body: self.body_id(slot) });
            }
        }
        for &slot in &bodies {
            for i in 0..self.bodies[slot].contacts.len() {
                let id = self.bodies[slot].contacts[i];
                if let ContactPlace::Asleep(row) = self.places[id as usize] {
                    self.move_contact_awake(row);
                }
            }
            // A body that begins to push wakes what it holds up, and so on.
            if self.bodies[slot].kind == BodyKind::Kinematic {
                self.wake_touching(slot);
            }
        }
        bodies.clear();
        self.scratch.lists.push(bodies);
    }

    /// Wakes every body that touches this one, and the body itself.
    pub(crate) fn wake_neighbours(&mut self, slot: u32) {
        self.wake_body(slot);
        self.wake_touching(slot);
    }

    fn wake_touching(&mut self, slot: u32) {
        let mut others = Vec::new();
        let mut see = |c: &Contact| {
            if c.touching && (c.body_a == slot || c.body_b == slot) {
                others.push(if c.body_a == slot { c.body_b } else { c.body_a });
            }
        };
        if self.bodies[slot].kind == BodyKind::Fixed {
            self.contacts.iter().for_each(&mut see);
            self.asleep_contacts.iter().for_each(&mut see);
        } else {
            for &id in &self.bodies[slot].contacts {
                match self.places[id as usize] {
                    ContactPlace::Awake(row) => see(&self.contacts[row as usize]),
                    ContactPlace::Asleep(row) => see(&self.asleep_contacts[row as usize]),
                    ContactPlace::Free => {}
                }
            }
        }
        for &j in &self.bodies[slot].joints {
            let j = &self.joints.table[j];
            others.push(if j.body_a == slot { j.body_b } else { j.body_a });
        }
        self.vehicles_on(slot, &mut others);
        for other in others {
            self.wake_body(other);
        }
    }

    pub(crate) fn wake_all(&mut self) {
        let islands: Vec<u32> = self.islands.iter().map(|(i, _)| i).collect();
        for i in islands {
            self.wake_island(i);
        }
        for s in &mut self.awake.step {
            s.sleep_timer = 0.0;
        }
        for i in 0..self.awake.step.len() {
            self.refresh_row(self.awake.step[i].body);
        }
    }

    /// The dynamic bodies that touch this one, directly or through others.
    pub(crate) fn touching_group(&self, slot: u32) -> Vec<u32> {
        let mut group = vec![slot];
        let mut seen = std::collections::BTreeSet::from([slot]);
        let mut next = 0;
        while next < group.len() {
            let b = group[next];
            next += 1;
            if self.bodies[b].kind != BodyKind::Dynamic {
                continue;
            }
            for &id in &self.bodies[b].contacts {
                let ContactPlace::Awake(row) = self.places[id as usize] else { continue };
                let c = &self.contacts[row as usize];
                let other = if c.body_a == b { c.body_b } else { c.body_a };
                let dynamic = self.bodies[other].kind == BodyKind::Dynamic && self.bodies[other].row != NONE;
                if c.touching && dynamic && seen.insert(other) {
                    group.push(other);
                }
            }
            for &j in &self.bodies[b].joints {
                let j = &self.joints.table[j];
                let other = if j.body_a == b { j.body_b } else { j.body_a };
                let dynamic = self.bodies[other].kind == BodyKind::Dynamic && self.bodies[other].row != NONE;
                if j.acts() && dynamic && seen.insert(other) {
                    group.push(other);
                }
            }
        }
        group
    }

    /// Puts awake bodies to sleep as one island.
    pub(crate) fn sleep_bodies(&mut self, bodies: Vec<u32>) {
        for &slot in &bodies {
            if self.bodies[slot].row == NONE {
                continue;
            }
            self.remove_row(slot);
            let b = &mut self.bodies[slot];
            (b.velocity, b.angular_velocity) = (Vec3::ZERO, Vec3::ZERO);
            let vehicle = b.vehicle;
            if let Some(v) = self.vehicles.table.get_mut(vehicle) {
                v.wheels.iter_mut().for_each(|w| w.rest());
            }
            self.frames[slot as usize].reset_interpolation();
            self.events.push(Event::Sleep { body: self.body_id(slot) });
        }
        for &slot in &bodies {
            for i in 0..self.bodies[slot].contacts.len() {
                let id = self.bodies[slot].contacts[i];
                let ContactPlace::Awake(row) = self.places[id as usize] else { continue };
                let c = &self.contacts[row as usize];
                if self.bodies[c.body_a].row == NONE && self.bodies[c.body_b].row == NONE {
                    self.move_contact_asleep(row);
                }
            }
        }
        let (island, _) = self.islands.insert(Vec::new());
        for &slot in &bodies {
            self.bodies[slot].island = island;
        }
        self.islands[island] = bodies;
    }

    fn move_contact_awake(&mut self, row: u32) {
        let c = take_row(&mut self.asleep_contacts, &mut self.places, row, ContactPlace::Asleep);
        if c.fixed && c.touching {
            self.scratch.renewed.extend([c.body_a, c.body_b]);
        }
        self.places[c.id as usize] = ContactPlace::Awake(self.contacts.len() as u32);
        self.heads.push(PairHead::new(&c));
        self.contacts.push(c);
    }

    fn move_contact_asleep(&mut self, row: u32) {
        self.heads.swap_remove(row as usize);
        let c = take_row(&mut self.contacts, &mut self.places, row, ContactPlace::Awake);
        self.places[c.id as usize] = ContactPlace::Asleep(self.asleep_contacts.len() as u32);
        self.asleep_contacts.push(c);
    }

    /// Enters a new contact into the awake rows, the pair set and the bodies' lists.
    pub(crate) fn link_contact(&mut self, mut c: Contact) {
        let id = self.free_contacts.pop().unwrap_or_else(|| {
            self.places.push(ContactPlace::Free);
            self.places.len() as u32 - 1
        });
        c.id = id;
        for (k, body) in [c.body_a, c.body_b].into_iter().enumerate() {
            let b = &mut self.bodies[body];
            if b.kind != BodyKind::Fixed {
                c.edge[k] = b.contacts.len() as u32;
                if b.contacts.capacity() == 0 {
                    // More than a body in a pile has, so that a stirred pile does not go on allocating.
                    b.contacts.reserve(24);
                }
                b.contacts.push(id);
            }
        }
        self.pairs.insert(pair_key(c.shape_a, c.shape_b), id);
        // Two bodies that were made asleep: their contact sleeps with them.
        if self.bodies[c.body_a].row == NONE && self.bodies[c.body_b].row == NONE {
            self.places[id as usize] = ContactPlace::Asleep(self.asleep_contacts.len() as u32);
            self.asleep_contacts.push(c);
            return;
        }
        self.places[id as usize] = ContactPlace::Awake(self.contacts.len() as u32);
        self.heads.push(PairHead::new(&c));
        self.contacts.push(c);
    }

    /// Wakes sleeping bodies within reach of a fixed shape that was just put there: nobody else would notice.
    pub(crate) fn wake_near(&mut self, shape: u32) {
        if self.islands.len() == 0 || self.bodies[self.shapes[shape].body].kind != BodyKind::Fixed {
            return;
        }
        let mut near = Vec::new();
        if self.shapes[shape].place == Place::Unbounded {
            let moving = self.shapes.iter().filter(|(_, o)| matches!(o.place, Place::MovingTree(_)));
            near.extend(moving.map(|(i, _)| i).filter(|&i| near_plane(self, shape, i)));
        } else {
            self.moving_tree.get().query(&self.fat[shape as usize], |other| {
                near.push(other);
                true
            });
        }
        near.sort_unstable();
        for other in near {
            if may_meet(self, shape, other) {
                self.wake_body(self.shapes[other].body);
            }
        }
    }

    /// Removes a contact, wherever it is; tells of its end when it touched.
    /// [`World::unlink_contact`] of several that are awake.
    pub(crate) fn unlink_contacts(&mut self, ids: &[u32]) {
        let mut keys = core::mem::take(&mut self.scratch.keys);
        keys.clear();
        keys.extend(ids.iter().filter_map(|&id| {
            let [a, b] = self.places[id as usize].head(&self.heads)?.shapes;
            Some(pair_key(a, b))
        }));
        let (mut pairs, tasks) = (core::mem::take(&mut self.pairs), self.tasks.clone());
        let forget = || keys.iter().for_each(|&key| pairs.remove(key));
        let unlink = || {
            for &id in ids {
                self.unlink_row(id);
            }
        };
        tasks.join(unlink, forget);
        (self.pairs, self.scratch.keys) = (pairs, keys);
    }

    pub(crate) fn unlink_contact(&mut self, id: u32) {
        if let Some(key) = self.unlink_row(id) {
            self.pairs.remove(key);
        }
    }

    /// Takes a contact out of everything but the pair set; gives its pair.
    fn unlink_row(&mut self, id: u32) -> Option<u64> {
        let c = match self.places[id as usize] {
            ContactPlace::Free => return None,
            ContactPlace::Awake(row) => {
                self.heads.swap_remove(row as usize);
                take_row(&mut self.contacts, &mut self.places, row, ContactPlace::Awake)
            }
            ContactPlace::Asleep(row) => {
                take_row(&mut self.asleep_contacts, &mut self.places, row, ContactPlace::Asleep)
            }
        };
        self.places[id as usize] = ContactPlace::Free;
        self.free_contacts.push(id);
        for (k, body) in [c.body_a, c.body_b].into_iter().enumerate() {
            self.unlink_edge(body, c.edge[k]);
        }
        if c.touching {
            self.report_end(c.shape_a, c.shape_b);
        }
        let mut rest = c.rest;
        if rest.capacity() > 0 {
            rest.clear();
            self.scratch.manifolds.push(rest);
        }
        Some(pair_key(c.shape_a, c.shape_b))
    }

    fn unlink_edge(&mut self, body: u32, edge: u32) {
        if edge == NONE {
            return;
        }
        let list = &mut self.bodies[body].contacts;
        list.swap_remove(edge as usize);
        let Some(&moved) = list.get(edge as usize) else { return };
        let c = match self.places[moved as usize] {
            ContactPlace::Awake(row) => &mut self.contacts[row as usize],
            ContactPlace::Asleep(row) => &mut self.asleep_contacts[row as usize],
            ContactPlace::Free => return,
        };
        let side = usize::from(c.body_a != body);
        c.edge[side] = edge;
    }

    pub(crate) fn report_end(&mut self, shape_a: u32, shape_b: u32) {
        if self.shapes[shape_a].contact_events && self.shapes[shape_b].contact_events {
            let (a, b) = (self.shape_id(shape_a), self.shape_id(shape_b));
            self.events.push(Event::ContactEnd { a, b });
        }
    }

    pub(crate) fn remove_contacts_of_shape(&mut self, shape: u32) {
        let body = self.shapes[shape].body;
        let of_shape = |c: &Contact| c.shape_a == shape || c.shape_b == shape;
        let mut ids: Vec<u32> = if self.bodies[body].kind == BodyKind::Fixed {
            let all = self.contacts.iter().chain(&self.asleep_contacts);
            all.filter(|c| of_shape(c)).map(|c| c.id).collect()
        } else {
            self.bodies[body]
                .contacts
                .iter()
                .copied()
                .filter(|&id| self.contact(id).is_some_and(of_shape))
                .collect()
        };
        ids.sort_unstable();
        for id in ids {
            self.unlink_contact(id);
        }
    }

    pub(crate) fn contact(&self, id: u32) -> Option<&Contact> {
        match *self.places.get(id as usize)? {
            ContactPlace::Awake(row) => self.contacts.get(row as usize),
            ContactPlace::Asleep(row) => self.asleep_contacts.get(row as usize),
            ContactPlace::Free => None,
        }
    }

    /// Copies to the body's frame whether it looks ahead.
    pub(crate) fn note_outlook(&mut self, body: u32) {
        if let Some(b) = self.bodies.get(body) {
            self.frames[body as usize].looks_ahead = b.looks_ahead();
        }
    }

    /// Makes the next narrow phase test all contacts of a body afresh.
    pub(crate) fn forget_tests(&mut self, body: u32) {
        self.note_outlook(body);
        if self.bodies[body].kind == BodyKind::Fixed {
            for c in self.contacts.iter_mut().chain(&mut self.asleep_contacts) {
                c.tested &= c.body_a != body && c.body_b != body;
            }
            for h in self.heads.iter_mut().filter(|h| h.bodies.contains(&body)) {
                h.until = f64::NEG_INFINITY;
            }
            return;
        }
        for &id in &self.bodies[body].contacts {
            match self.places[id as usize] {
                ContactPlace::Awake(row) => {
                    self.contacts[row as usize].tested = false;
                    self.heads[row as usize].until = f64::NEG_INFINITY;
                }
                ContactPlace::Asleep(row) => self.asleep_contacts[row as usize].tested = false,
                ContactPlace::Free => {}
            }
        }
    }
}

fn take_row(
    rows: &mut Vec<Contact>,
    places: &mut [ContactPlace],
    row: u32,
    place: fn(u32) -> ContactPlace,
) -> Contact {
    let c = rows.swap_remove(row as usize);
    if let Some(moved) = rows.get(row as usize) {
        places[moved.id as usize] = place(row);
    }
    c
}
