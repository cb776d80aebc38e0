//! Restitution, after the last substep: passes over the rows that bounce until their rebound speeds hold together.
//!
//! The points of a face that lands flat depend on one another; one pass would leave it spinning, and with more energy than it
//! came with. First all points that will bounce come to rest (compression); then Newton's law at every point at once,
//! λ ≥ 0, v_n ≥ e V, is what the passes converge to, with no more impulse than e times that of the compression (Poisson). Between walls that push
//! from opposite sides there is no such velocity, and impulses would grow from pass to pass: what is squeezed does not bounce.

use super::{Step, substep};
use crate::limits;
use crate::room::contacts::rows::{Block, LANES};
use crate::room::contacts::solve::Pass;
use crate::world::World;
use jounce_math::{Vec3, scalar::f32s};

/// Change of a rebound speed that ends the passes, m/s.
const QUIET: f32 = 1e-4;
/// |Σ λ n| below this part of Σ λ: pushed from opposite sides. (Two walls at a right angle give 0.71.)
const SQUEEZED: f32 = 0.5;

pub(super) fn run(world: &mut World, step: &Step) {
    if !world.scratch.blocks.iter().flatten().any(bounces) {
        return;
    }
    hold_squeezed(world);
    // Only these go on.
    world.scratch.blocks.iter_mut().flatten().for_each(|b| b.any_rebound = bounces(b));
    passes(world, step, Pass::Compress);
    for block in world.scratch.blocks.iter_mut().flatten().filter(|b| b.any_rebound) {
        for l in 0..block.rows {
            block.compression[l] = compression(block, l);
        }
    }
    passes(world, step, Pass::Restitution);
}

fn passes(world: &mut World, step: &Step, pass: Pass) {
    world.scratch.blocks.iter_mut().flatten().for_each(|b| b.live = b.any_rebound);
    world.scratch.stirred.clear();
    world.scratch.stirred.resize(world.awake.state.len(), 0);
    for count in 1..=limits::RESTITUTION_PASSES_MAX as u32 {
        substep::sweep(world, pass, step);
        if stir(world, count) <= QUIET {
            return;
        }
    }
}

/// Finds what the next pass has to go over: a block none of whose bodies the last pass changed would change nothing. Gives the
/// largest change of a rebound speed.
fn stir(world: &mut World, count: u32) -> f32 {
    let scratch = &mut world.scratch;
    let (colors, stirred) = (&scratch.colors, &mut scratch.stirred);
    let mut change = 0.0;
    for (color, list) in scratch.blocks.iter().enumerate() {
        let rows = colors.rows(color).chunks(LANES);
        for (b, rows) in list.iter().zip(rows).filter(|(b, _)| b.live) {
            for (row, &by) in rows.iter().zip(&b.rebound_change).filter(|(_, by)| **by > 0.0) {
                change = f32s::max(change, by);
                for item in [row.a(), row.b()] {
                    if let Some(s) = stirred.get_mut(item as usize) {
                        *s = count;
                    }
                }
            }
        }
    }
    let is_stirred = |item: u32| stirred.get(item as usize) == Some(&count);
    for (color, list) in scratch.blocks.iter_mut().enumerate() {
        let rows = colors.rows(color).chunks(LANES);
        for (b, rows) in list.iter_mut().zip(rows).filter(|(b, _)| b.any_rebound) {
            b.live = rows.iter().any(|r| is_stirred(r.a()) || is_stirred(r.b()));
        }
    }
    change
}

fn points(b: &Block) -> usize {
    b.points_max.min(4)
}

/// Does some point of the block have speed to give back, and was it pushed?
fn bounces(b: &Block) -> bool {
    b.any_rebound
        && b.sums[..points(b)]
            .iter()
            .any(|p| p.rebound.iter().zip(&p.total).any(|(r, t)| *r > 0.0 && *t > 0.0))
}

/// Impulse that a row's points gave over the step.
fn compression(b: &Block, l: usize) -> f32 {
    b.sums[..points(b)].iter().map(|p| p.total[l]).sum()
}

/// Takes the rebound from rows of bodies that are pushed from opposite sides.
fn hold_squeezed(world: &mut World) {
    let mut pushed = core::mem::take(&mut world.scratch.squeeze);
    pushed.clear();
    pushed.resize(world.awake.state.len(), (0.0, Vec3::ZERO));
    let mut blocks = core::mem::take(&mut world.scratch.blocks);
    for (color, list) in blocks.iter().enumerate() {
        for (i, row) in world.scratch.colors.rows(color).iter().enumerate() {
            let (b, l) = (&list[i / LANES], i % LANES);
            let total = compression(b, l);
            let n = b.normal.get(l);
            for (item, sign) in [(row.a(), -1.0), (row.b(), 1.0)] {
                if let Some(p) = pushed.get_mut(item as usize) {
                    p.0 += total;
                    p.1 += n * (sign * total);
                }
            }
        }
    }
    let squeezed = |item: u32| pushed.get(item as usize).is_some_and(|p| p.1.length() < SQUEEZED * p.0);
    for (color, list) in blocks.iter_mut().enumerate() {
        for (i, row) in world.scratch.colors.rows(color).iter().enumerate() {
            let b = &mut list[i / LANES];
            if b.any_rebound && (squeezed(row.a()) || squeezed(row.b())) {
                let n = points(b);
                b.sums[..n].iter_mut().for_each(|p| p.rebound[i % LANES] = 0.0);
            }
        }
    }
    world.scratch.blocks = blocks;
    world.scratch.squeeze = pushed;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::room::contacts::prepare::StepConstants;
    use crate::stage::{broadphase, forces, islands, narrowphase, prepare, publish};
    use crate::{BodyDesc, ShapeDesc, WorldDesc};

    /// All passes over all that bounces.
    fn whole(world: &mut World, step: &Step) {
        hold_squeezed(world);
        for pass in [Pass::Compress, Pass::Restitution] {
            for _ in 0..limits::RESTITUTION_PASSES_MAX {
                world.scratch.blocks.iter_mut().flatten().for_each(|b| b.live = b.any_rebound);
                substep::sweep(world, pass, step);
                let all = world.scratch.blocks.iter().flatten().filter(|b| b.any_rebound);
                if all.flat_map(|b| b.rebound_change).fold(0.0, f32s::max) <= QUIET {
                    break;
                }
            }
            if pass == Pass::Compress {
                for block in world.scratch.blocks.iter_mut().flatten().filter(|b| b.any_rebound) {
                    for l in 0..block.rows {
                        block.compression[l] = compression(block, l);
                    }
                }
            }
        }
    }

    /// Heaps and single bodies that land at one time: what the passes leave out would have changed nothing.
    #[test]
    fn passes_leave_out_only_what_has_settled() {
        let mut w = World::new(WorldDesc::default()).expect("valid");
        w.add_body(BodyDesc::fixed().shape(ShapeDesc::cuboid([40.0, 1.0, 40.0]).restitution(0.5)))
            .expect("valid");
        for i in 0..80_u32 {
            let (x, z) = (1.1 * f64::from(i % 8), 1.1 * f64::from(i / 8 % 5));
            let y = 1.6 + 1.05 * f64::from(i / 40) + 0.3 * f64::from(i % 3);
            let shape = if i % 3 == 0 { ShapeDesc::sphere(0.5) } else { ShapeDesc::cuboid([0.5, 0.5, 0.5]) };
            let d = BodyDesc::dynamic().at([x, y, z]).velocity([0.1 * f64::from(i % 5) as f32, -3.0, 0.0]);
            w.add_body(d.shape(shape.restitution(0.6))).expect("valid");
        }
        let (mut bounced, mut left_out) = (0, 0);
        for n in 0..120 {
            let dt = w.dt() as f32;
            let constants = StepConstants::new(&w.settings, dt, w.substeps);
            let step = Step { dt, substeps: w.substeps, constants };
            for stage in
                [forces::run, broadphase::run, narrowphase::run, islands::run, prepare::run, substep::run]
            {
                stage(&mut w, &step);
            }
            let mut all = w.clone();
            run(&mut w, &step);
            let bounces = w.scratch.blocks.iter().flatten().filter(|b| b.any_rebound).count();
            if bounces > 0 {
                whole(&mut all, &step);
                bounced += 1;
                left_out += w.scratch.blocks.iter().flatten().filter(|b| b.any_rebound && !b.live).count();
            }
            for (a, b) in w.awake.state.iter().zip(&all.awake.state) {
                assert_eq!(a.hot, b.hot, "step {n}");
            }
            for (a, b) in w.scratch.blocks.iter().flatten().zip(all.scratch.blocks.iter().flatten()) {
                for (p, q) in a.points.iter().zip(&b.points) {
                    assert_eq!(p.impulse, q.impulse, "step {n}");
                }
                for (p, q) in a.sums.iter().zip(&b.sums) {
                    assert_eq!(p.total, q.total, "step {n}");
                }
                assert_eq!(a.friction_impulse, b.friction_impulse, "step {n}");
            }
            substep::finish(&mut w, &step);
            publish::run(&mut w, &step);
        }
        assert!(bounced > 20 && left_out > 5, "{bounced} steps, {left_out} blocks");
    }
}
