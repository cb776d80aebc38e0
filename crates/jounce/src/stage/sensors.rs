//! Who is inside the sensors: looked up after every step, compared with the step before.

use crate::event::Event;
use crate::handle::ShapeId;
use crate::room::contacts::state::Place;
use crate::world::World;
use jounce_geometry::overlap;

pub(crate) fn run(world: &mut World) {
    for i in 0..world.sensors.len() {
        let s = world.sensors[i];
        if world.shapes[s].place == Place::Nowhere {
            continue;
        }
        let mut before = core::mem::take(&mut world.scratch.visitors);
        before.clear();
        visitors(world, s, &mut before);
        core::mem::swap(&mut world.shapes[s].visitors, &mut before);
        let sensor = world.shape_id(s);
        let now = &world.shapes[s].visitors;
        let id = |&(index, generation): &(u32, u32)| ShapeId { index, generation };
        let gone = before.iter().filter(|v| now.binary_search(v).is_err());
        let gone = gone.map(|v| Event::SensorLeave { sensor, visitor: id(v) });
        let come = now.iter().filter(|v| before.binary_search(v).is_err());
        let come = come.map(|v| Event::SensorEnter { sensor, visitor: id(v) });
        world.events.extend(gone.chain(come));
        world.scratch.visitors = before;
    }
}

/// Finds the shapes that overlap a sensor, sorted by slot. Sensors do not see sensors, nor fixed shapes.
fn visitors(world: &World, sensor: u32, found: &mut Vec<(u32, u32)>) {
    let r = &world.shapes[sensor];
    let pose = world.frames[r.body as usize].shape_pose(&r.pose);
    let mut see = |other: u32| {
        let o = &world.shapes[other];
        if o.sensor || o.body == r.body || !r.filter.allows(&o.filter) {
            return true;
        }
        let other_pose = world.frames[o.body as usize].shape_pose(&o.pose);
        if overlap(&r.shape, &o.shape, &pose.relative(&other_pose)) {
            found.push((other, world.shapes.generation(other)));
        }
        true
    };
    if r.place == Place::Unbounded {
        for (i, _) in world.shapes.iter().filter(|(_, o)| matches!(o.place, Place::MovingTree(_))) {
            see(i);
        }
    } else {
        world.moving_tree.get().query(&world.tight_bounds(sensor), see);
    }
    found.sort_unstable();
}
