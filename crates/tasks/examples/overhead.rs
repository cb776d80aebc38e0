//! What a stage costs beside its work. `cargo run --release -p jounce_tasks --example overhead`
#![allow(clippy::disallowed_methods, reason = "a measurement looks at the clock")]

use std::hint::black_box;
use std::time::Instant;

use jounce_tasks::Tasks;

/// About so many nanoseconds of dependent multiplications.
fn work(nanoseconds: usize) {
    let mut x = 1.0f32;
    for _ in 0..nanoseconds {
        x = black_box(x) * 1.000_1;
    }
    black_box(x);
}

/// Median microseconds of a stage.
fn measure(tasks: &Tasks, units: usize, unit_ns: usize) -> f64 {
    let mut times: Vec<f64> = (0..2000)
        .map(|_| {
            let begun = Instant::now();
            tasks.run(units, &|_| work(unit_ns));
            begun.elapsed().as_secs_f64() * 1e6
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn main() {
    let schedulers = [Tasks::serial(), Tasks::pool(2), Tasks::pool(4)];
    println!("median microseconds of a stage\n{:>6} {:>9}   {schedulers:?}", "units", "unit (ns)");
    for (units, unit_ns) in
        [(1, 0), (2, 0), (16, 0), (256, 0), (2, 1000), (16, 1000), (256, 1000), (16, 10_000)]
    {
        let times: Vec<String> =
            schedulers.iter().map(|tasks| format!("{:10.2}", measure(tasks, units, unit_ns))).collect();
        println!("{units:>6} {unit_ns:>9}   {}", times.join(" "));
    }
}
