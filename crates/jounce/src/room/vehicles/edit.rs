//! Adding, changing and removing vehicles.

use super::desc::{VehicleDesc, VehicleInput};
use super::engine::Shifter;
use super::state::{Vehicle, WheelState};
use crate::error::{Error, Result, check};
use crate::handle::VehicleId;
use crate::limits;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::world::World;

impl World {
    pub(crate) fn vehicle_id(&self, index: u32) -> VehicleId {
        VehicleId { index, generation: self.vehicles.table.generation(index) }
    }
    pub(crate) fn vehicle_slot(&self, id: VehicleId) -> Result<u32> {
        if self.vehicles.table.is_live(id.index, id.generation) {
            return Ok(id.index);
        }
        Err(Error::Stale { what: "vehicle", index: id.index, generation: id.generation })
    }

    pub(crate) fn do_add_vehicle(&mut self, d: VehicleDesc) -> Result<VehicleId> {
        d.check()?;
        let chassis = self.slot(d.chassis)?;
        if self.vehicles.table.len() >= limits::VEHICLES_MAX {
            return Err(Error::Limit { what: "vehicles", limit: limits::VEHICLES_MAX });
        }
        let body = &self.bodies[chassis];
        if body.kind != BodyKind::Dynamic {
            return Err(Error::Unsupported {
                what: "a vehicle on a body that is not dynamic",
                advice: "make the chassis dynamic; to hold it, lock its axes",
            });
        }
        let (told, expected) = ("the body of another vehicle", "a body that is of no other vehicle");
        check(body.vehicle == NONE, "vehicle", "chassis", told, expected)?;
        self.check_unsprung(chassis, &d)?;
        let mut v = Vehicle {
            chassis,
            enabled: d.enabled,
            input: VehicleInput::default(),
            wheels: vec![WheelState::default(); d.wheels.len()],
            stations: vec![WheelState::default(); if d.board.is_some() { 4 } else { 0 }],
            engine: 0.0,
            shifter: Shifter::default(),
            throttle: 1.0,
            clutch: 0.0,
            locked: Vec::new(),
            carried: None,
            jumped: false,
            desc: d,
        };
        v.engine = v.idle();
        let (index, generation) = self.vehicles.table.insert(v);
        self.bodies[chassis].vehicle = index;
        self.wake_body(chassis);
        Ok(VehicleId { index, generation })
    }

    fn check_unsprung(&self, chassis: u32, d: &VehicleDesc) -> Result<()> {
        let mass = self.bodies[chassis].mass.mass;
        let wheels: f32 = d.wheels.iter().map(|w| w.mass).sum();
        let expected = "in all at most 0.9 of the chassis' mass, of which it is a part";
        check(d.is_carried_by(mass), "wheel", "mass", wheels, expected)
    }

    pub(crate) fn do_remove_vehicle(&mut self, id: VehicleId) -> Result<()> {
        let slot = self.vehicle_slot(id)?;
        self.drop_vehicle(slot);
        Ok(())
    }

    /// Removes a vehicle; its chassis stays, as a body.
    pub(crate) fn drop_vehicle(&mut self, slot: u32) {
        let Some(v) = self.vehicles.table.remove(slot) else { return };
        if let Some(b) = self.bodies.get_mut(v.chassis) {
            b.vehicle = NONE;
            self.wake_body(v.chassis);
        }
    }

    pub(crate) fn do_set_vehicle(&mut self, id: VehicleId, d: VehicleDesc) -> Result<()> {
        let slot = self.vehicle_slot(id)?;
        d.check()?;
        let v = &self.vehicles.table[slot];
        let expected = "the chassis that it has (remove it and add another)";
        check(self.slot(d.chassis)? == v.chassis, "vehicle", "chassis", d.chassis, expected)?;
        let expected = "as many as it has (remove it and add another)";
        check(d.wheels.len() == v.wheels.len(), "vehicle", "wheels", d.wheels.len(), expected)?;
        let expected = "a board where it has one (remove it and add another)";
        check(d.board.is_some() != v.stations.is_empty(), "vehicle", "board", d.board.is_some(), expected)?;
        let chassis = v.chassis;
        self.check_unsprung(chassis, &d)?;
        let v = &mut self.vehicles.table[slot];
        v.enabled = d.enabled;
        v.desc = d;
        v.locked.clear();
        self.wake_body(chassis);
        Ok(())
    }

    pub(crate) fn do_set_vehicle_input(&mut self, id: VehicleId, input: VehicleInput) -> Result<()> {
        let slot = self.vehicle_slot(id)?;
        input.check()?;
        let v = &mut self.vehicles.table[slot];
        if v.input == input {
            return Ok(());
        }
        v.input = input;
        let chassis = v.chassis;
        self.wake_body(chassis);
        Ok(())
    }

    pub(crate) fn do_enable_vehicle(&mut self, id: VehicleId, on: bool) -> Result<()> {
        let slot = self.vehicle_slot(id)?;
        let v = &mut self.vehicles.table[slot];
        if v.enabled == on {
            return Ok(());
        }
        v.enabled = on;
        v.forget();
        let chassis = v.chassis;
        self.wake_body(chassis);
        Ok(())
    }

    /// Chassis of the vehicles that stand on a body.
    pub(crate) fn vehicles_on(&self, body: u32, out: &mut Vec<u32>) {
        if self.vehicles.is_empty() {
            return;
        }
        out.extend(self.vehicles.table.iter().filter(|(_, v)| v.stands_on(body)).map(|(_, v)| v.chassis));
    }
}
