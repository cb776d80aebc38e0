//! Runs the queue, in push order. A command that fails is dropped: its caller had `apply` to learn why.

use super::Step;
use crate::world::World;

pub(crate) fn run(world: &mut World, _: &Step) {
    let mut queue = core::mem::take(&mut world.queue);
    for command in queue.drain(..) {
        let _ = world.apply(command);
    }
    if world.queue.is_empty() {
        world.queue = queue;
    }
}
