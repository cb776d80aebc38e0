//! The 100-row pyramid: `cargo run --release -p jounce --example pyramid [ROWS] [STEPS] [THREADS]`.
//!
//! Prints milliseconds per step, the height of the top cube and the state hash.

use jounce::prelude::*;
use jounce::{Settings, Stage, StageObserver};
use std::time::{Duration, Instant};

struct Timer {
    last: Instant,
    total: [Duration; Stage::ALL.len()],
}

impl StageObserver for Timer {
    #[allow(clippy::disallowed_methods)]
    fn after(&mut self, stage: Stage, _: &World) {
        let now = Instant::now();
        self.total[stage as usize] += now - self.last;
        self.last = now;
    }
}

#[allow(clippy::disallowed_methods)]
fn main() -> jounce::Result<()> {
    let arg = |i: usize, d: u32| std::env::args().nth(i).and_then(|a| a.parse().ok()).unwrap_or(d);
    let (rows, steps, threads) = (arg(1, 100), arg(2, 200), arg(3, 1));
    let settings = Settings { sleep: false, ..Settings::default() };
    let mut world =
        World::new(WorldDesc { gravity: Vec3::new(0.0, -10.0, 0.0), settings, ..WorldDesc::default() })?;
    world.set_tasks(Tasks::pool(threads as usize));
    world.add_body(BodyDesc::fixed().at([0.0, -1.0, 0.0]).shape(ShapeDesc::cuboid([400.0, 1.0, 400.0])))?;
    let mut top = None;
    for i in 0..rows {
        for j in i..rows {
            let x = f64::from(i + 1) * 0.5 + f64::from(j - i) - 0.5 * f64::from(rows);
            let y = f64::from(2 * i + 1) * 0.5;
            let cube = ShapeDesc::cuboid([0.5, 0.5, 0.5]).density(100.0);
            top = Some(world.add_body(BodyDesc::dynamic().at([x, y, 0.0]).shape(cube))?);
        }
    }
    world.step()?;
    let mut timer = Timer { last: Instant::now(), total: [Duration::ZERO; Stage::ALL.len()] };
    let start = Instant::now();
    for _ in 1..steps {
        timer.last = Instant::now();
        world.step_observed(&mut timer)?;
    }
    let ms = start.elapsed().as_secs_f64() * 1e3;
    println!("{:?}", world.counts());
    for stage in Stage::ALL {
        println!(
            "{:>14} {:8.3} ms",
            stage.name(),
            timer.total[stage as usize].as_secs_f64() * 1e3 / f64::from(steps - 1)
        );
    }
    if let Some(top) = top {
        println!("top cube y = {:.4}", world.body(top)?.position().y);
    }
    println!("total {ms:.1} ms, {:.3} ms a step, hash {:#018x}", ms / f64::from(steps - 1), world.hash());
    Ok(())
}
