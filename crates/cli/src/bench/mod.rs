//! `jounce bench`: the comparison's scenes in this engine and, beside it in the same run, in others.
//!
//! Timing rule, the same in every engine: build; do what the scene does before step 0; step once untimed; time
//! steps 1 to N − 1 with what the scene does before each. Of the repeats the fastest counts.

mod peers;
mod scenes;
mod terrain;

use crate::args::BenchArgs;
use crate::error::{Done, Failure};
use crate::output::{Table, note, number, print, print_json, progress};
use jounce::tasks::Tasks;
use jounce::{BodyKind, World};
use peers::Peer;
use scenes::{SCENES, Scene};
use serde::Serialize;
use std::time::Instant;

/// One engine on one scene with one number of threads.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    pub scene: String,
    pub engine: String,
    pub threads: u32,
    pub steps: usize,
    /// Milliseconds of the timed steps in the fastest repeat.
    pub ms_min: f64,
    /// The same in the median repeat, as far as the engine's program tells.
    pub ms_median: f64,
    /// Best rival's `ms_min` / ours, on our rows; ours / theirs on the others'.
    pub ratio_to_best: Option<f64>,
    pub bodies: u64,
    pub touching: u64,
    /// Height of what stands highest at the end, metres.
    pub top_y: Option<f64>,
}

#[derive(Serialize)]
struct Report {
    rows: Vec<Row>,
}

pub fn bench(a: &BenchArgs) -> Done {
    let filter = a.filter.as_deref().unwrap_or("large_pyramid");
    let chosen: Vec<&Scene> = SCENES.iter().filter(|s| filter == "all" || s.name.contains(filter)).collect();
    if chosen.is_empty() {
        let names: Vec<&str> = SCENES.iter().map(|s| s.name).collect();
        return Err(Failure::bad(format!(
            "no scene holds \"{filter}\"; expected all or a part of {}",
            names.join(", ")
        )));
    }
    let peers = a.against.iter().map(|name| peers::find(name)).collect::<Done<Vec<Peer>>>()?;
    let mut rows = Vec::new();
    for scene in chosen {
        let steps = if a.quick { (scene.steps / 5).max(20) } else { scene.steps };
        let repeats = if a.quick { 1 } else { 3 };
        for &threads in &a.threads {
            let first = rows.len();
            rows.push(ours(scene, steps, repeats, threads)?);
            for peer in &peers {
                rows.extend(peer.run(scene.name, steps, repeats, threads)?);
            }
            ratios(&mut rows[first..]);
        }
    }
    if a.json { print_json(&Report { rows }) } else { print(&table(&rows)) }
}

/// Puts the ratios into the rows of one scene and thread count, of which the first is ours.
fn ratios(rows: &mut [Row]) {
    let Some((our, rivals)) = rows.split_first_mut() else { return };
    let best = rivals.iter().map(|r| r.ms_min).fold(f64::INFINITY, f64::min);
    our.ratio_to_best = best.is_finite().then(|| best / our.ms_min);
    for r in rivals {
        r.ratio_to_best = Some(our.ms_min / r.ms_min);
    }
}

fn ours(scene: &Scene, steps: usize, repeats: usize, threads: u32) -> Done<Row> {
    let mut totals = Vec::new();
    let mut end: Option<World> = None;
    let bar = progress((steps * repeats) as u64, scene.name);
    for _ in 0..repeats {
        let (total, world) = once(scene, steps, threads, &bar)?;
        totals.push(total);
        end = Some(world);
    }
    bar.finish_and_clear();
    totals.sort_by(f64::total_cmp);
    let counts = end.as_ref().map(World::counts).unwrap_or_default();
    let top = |w: &World| {
        let moving = w.bodies().filter_map(|b| w.body(b).ok()).filter(|b| b.kind() == BodyKind::Dynamic);
        let heights = moving.map(|b| b.position().y);
        heights.fold(f64::NEG_INFINITY, f64::max)
    };
    Ok(Row {
        scene: scene.name.into(),
        engine: "jounce".into(),
        threads,
        steps,
        ms_min: totals[0],
        ms_median: totals[totals.len() / 2],
        ratio_to_best: None,
        bodies: counts.bodies as u64,
        touching: counts.touching as u64,
        top_y: end.as_ref().map(top),
    })
}

fn once(scene: &Scene, steps: usize, threads: u32, bar: &indicatif::ProgressBar) -> Done<(f64, World)> {
    let (mut world, mut before) = (scene.build)()?;
    if threads > 1 {
        world.set_tasks(Tasks::pool(threads as usize));
    }
    before(&mut world, 0)?;
    world.step()?;
    let start = Instant::now();
    for k in 1..steps {
        before(&mut world, k)?;
        world.step()?;
        bar.inc(1);
    }
    Ok((start.elapsed().as_secs_f64() * 1e3, world))
}

fn table(rows: &[Row]) -> String {
    let mut t = Table::new([
        "scene", "engine", "threads", "steps", "total ms", "ms/step", "ratio", "bodies", "touching", "top y",
    ])
    .left(1);
    for r in rows {
        t.row([
            r.scene.clone(),
            r.engine.clone(),
            r.threads.to_string(),
            r.steps.to_string(),
            format!("{:.1}", r.ms_min),
            format!("{:.3}", r.ms_min / (r.steps.max(2) - 1) as f64),
            r.ratio_to_best.map_or_else(String::new, |v| format!("{v:.2}")),
            r.bodies.to_string(),
            r.touching.to_string(),
            r.top_y.map_or_else(String::new, number),
        ]);
    }
    note(
        "ratio: on our rows the best rival's time / ours (more is better for us); on theirs our time / theirs",
    );
    t.text()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratio_is_best_rival_over_ours() {
        let row = |engine: &str, ms: f64| Row {
            scene: "s".into(),
            engine: engine.into(),
            threads: 1,
            steps: 10,
            ms_min: ms,
            ms_median: ms,
            ratio_to_best: None,
            bodies: 0,
            touching: 0,
            top_y: None,
        };
        let mut rows = [row("jounce", 10.0), row("a", 30.0), row("b", 20.0)];
        ratios(&mut rows);
        assert_eq!(rows[0].ratio_to_best, Some(2.0));
        assert_eq!(rows[2].ratio_to_best, Some(0.5));
        let mut alone = [row("jounce", 10.0)];
        ratios(&mut alone);
        assert_eq!(alone[0].ratio_to_best, None);
    }

    #[test]
    fn scenes_are_built_as_specified() {
        for (name, bodies) in [("large_pyramid", 5051), ("many_pyramids", 10781), ("jolt_pyramid", 1241)] {
            let scene = SCENES.iter().find(|s| s.name == name).expect("listed");
            let (world, _) = (scene.build)().expect("built");
            assert_eq!(world.counts().bodies, bodies, "{name}");
        }
    }
}
