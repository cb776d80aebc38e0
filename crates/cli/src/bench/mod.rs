//! `jounce bench`: the comparison's scenes in this engine and, beside it in the same run, in others.
//!
//! Timing rule, the same in every engine: build; do what the scene does before step 0; step once untimed; time
//! steps 1 to N − 1 with what the scene does before each. The engines take turns, repeat by repeat, so that what
//! slows the machine for a while slows each of them. Of the repeats the fastest counts.

mod peers;
mod profile;
mod quality;
mod scenes;
mod terrain;

use crate::args::BenchArgs;
use crate::error::{Done, Failure};
use crate::output::{Table, note, number, print, print_json, progress};
use jounce::tasks::Tasks;
use peers::Peer;
use profile::Profile;
use quality::Figures;
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
    pub repeats: usize,
    /// Milliseconds of the timed steps in the fastest repeat.
    pub ms_min: f64,
    /// The same in the median repeat.
    pub ms_median: f64,
    /// Best rival's `ms_min` / ours, on our rows; ours / theirs on the others'.
    pub ratio_to_best: Option<f64>,
    pub bodies: u64,
    pub joints: u64,
    pub touching: u64,
    /// How well the scene stands at the end.
    pub quality: Figures,
    /// Milliseconds of each stage of our step in the fastest repeat, where they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stages: Option<Profile>,
    /// Which of these figures the table shows.
    #[serde(skip)]
    pub shown: &'static [&'static str],
}

/// One repeat of a scene in one engine: milliseconds of the timed steps, and what there was after the last.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sample {
    pub ms: f64,
    pub bodies: u64,
    pub joints: u64,
    pub touching: u64,
    pub quality: Figures,
    pub stages: Option<Profile>,
}

#[derive(Serialize)]
struct Report {
    rows: Vec<Row>,
}

/// How often and how far a scene is run.
#[derive(Clone, Copy)]
pub(crate) struct Plan {
    pub steps: usize,
    pub repeats: usize,
    pub threads: u32,
    /// Times the stages of our step.
    pub profile: bool,
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
    let peers = peers::build(&a.against)?;
    let repeats = a.repeats.map_or(if a.quick { 1 } else { 3 }, |n| n as usize);
    let mut rows = Vec::new();
    for scene in chosen {
        let own = if a.quick { (scene.steps / 5).max(20) } else { scene.steps };
        let steps = a.steps.map_or(own, |n| n as usize);
        for &threads in &a.threads {
            rows.extend(side_by_side(scene, &peers, Plan { steps, repeats, threads, profile: a.profile })?);
        }
    }
    if a.json {
        return print_json(&Report { rows });
    }
    note(
        "ratio: on our rows the best rival's time / ours (more is better for us); on theirs our time / theirs",
    );
    print(&table(&rows).markdown())?;
    if a.profile { print(&profile::table(&rows).markdown()) } else { Ok(()) }
}

/// A scene in this engine and in those of its rivals that know it, in turns.
fn side_by_side(scene: &Scene, peers: &[Peer], plan: Plan) -> Done<Vec<Row>> {
    let mut our = Vec::new();
    let mut theirs: Vec<(&Peer, Vec<Sample>)> = peers.iter().map(|p| (p, Vec::new())).collect();
    for _ in 0..plan.repeats {
        our.push(ours(scene, plan)?);
        let mut able = Vec::new();
        for (peer, mut samples) in theirs {
            if let Some(sample) = peer.run(scene.name, plan)? {
                samples.push(sample);
                able.push((peer, samples));
            }
        }
        theirs = able;
    }
    let mut rows = vec![row(scene, "jounce", plan, our)];
    rows.extend(theirs.into_iter().map(|(peer, samples)| row(scene, &peer.name, plan, samples)));
    ratios(&mut rows);
    Ok(rows)
}

/// What the repeats of one engine come to. Counts and quality are those of the last.
fn row(scene: &Scene, engine: &str, plan: Plan, samples: Vec<Sample>) -> Row {
    let mut totals: Vec<f64> = samples.iter().map(|s| s.ms).collect();
    totals.sort_by(f64::total_cmp);
    let fastest = samples.iter().min_by(|a, b| a.ms.total_cmp(&b.ms));
    let stages = fastest.and_then(|s| s.stages.clone());
    let end = samples.into_iter().last().unwrap_or_default();
    Row {
        scene: scene.name.into(),
        engine: engine.into(),
        threads: plan.threads,
        steps: plan.steps,
        repeats: plan.repeats,
        ms_min: totals.first().copied().unwrap_or(f64::NAN),
        ms_median: median(&totals),
        ratio_to_best: None,
        bodies: end.bodies,
        joints: end.joints,
        touching: end.touching,
        quality: end.quality,
        stages,
        shown: scene.quality.shown(),
    }
}

/// Middle of values in order, or the mean of the two in the middle.
fn median(sorted: &[f64]) -> f64 {
    let half = sorted.len() / 2;
    match sorted {
        [] => f64::NAN,
        _ if sorted.len() % 2 == 1 => sorted[half],
        _ => 0.5 * (sorted[half - 1] + sorted[half]),
    }
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

/// One repeat in this engine.
fn ours(scene: &Scene, plan: Plan) -> Done<Sample> {
    let (mut world, mut before) = (scene.build)()?;
    if plan.threads > 1 {
        world.set_tasks(Tasks::pool(plan.threads as usize));
    }
    let bar = progress(plan.steps as u64 - 1, scene.name);
    before(&mut world, 0)?;
    world.step()?;
    let mut stages = plan.profile.then(Profile::default);
    let start = Instant::now();
    for k in 1..plan.steps {
        before(&mut world, k)?;
        match &mut stages {
            Some(p) => p.step(&mut world)?,
            None => world.step()?,
        }
        bar.inc(1);
    }
    let ms = start.elapsed().as_secs_f64() * 1e3;
    bar.finish_and_clear();
    let counts = world.counts();
    Ok(Sample {
        ms,
        bodies: counts.bodies as u64,
        joints: counts.joints as u64,
        touching: counts.touching as u64,
        quality: scene.quality.read(&world),
        stages,
    })
}

fn table(rows: &[Row]) -> Table {
    let mut t = Table::new([
        "scene",
        "engine",
        "threads",
        "steps",
        "min ms",
        "median ms",
        "ms/step",
        "ratio",
        "bodies",
        "joints",
        "touching",
        "quality",
    ])
    .left(1)
    .left(11);
    for r in rows {
        let figure = |name: &&str| Some(format!("{name} {}", number(*r.quality.get(*name)?)));
        t.row([
            r.scene.clone(),
            r.engine.clone(),
            r.threads.to_string(),
            r.steps.to_string(),
            format!("{:.1}", r.ms_min),
            format!("{:.1}", r.ms_median),
            format!("{:.3}", r.ms_min / (r.steps.max(2) - 1) as f64),
            r.ratio_to_best.map_or_else(String::new, |v| format!("{v:.2}")),
            r.bodies.to_string(),
            r.joints.to_string(),
            r.touching.to_string(),
            r.shown.iter().filter_map(figure).collect::<Vec<_>>().join(", "),
        ]);
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(ms: &[f64]) -> Vec<Sample> {
        ms.iter().map(|&ms| Sample { ms, bodies: 3, ..Sample::default() }).collect()
    }

    fn timed(engine: &str, ms: &[f64]) -> Row {
        row(
            &SCENES[0],
            engine,
            Plan { steps: 11, repeats: ms.len(), threads: 1, profile: false },
            samples(ms),
        )
    }

    #[test]
    fn a_row_has_the_fastest_and_the_median_repeat() {
        let r = timed("jounce", &[3.0, 1.0, 7.0]);
        assert_eq!((r.ms_min, r.ms_median, r.bodies, r.repeats), (1.0, 3.0, 3, 3));
        assert_eq!(timed("jounce", &[3.0, 1.0]).ms_median, 2.0);
    }

    #[test]
    fn ratio_is_best_rival_over_ours() {
        let mut rows = [timed("jounce", &[10.0]), timed("a", &[30.0]), timed("b", &[20.0])];
        ratios(&mut rows);
        assert_eq!(rows[0].ratio_to_best, Some(2.0));
        assert_eq!(rows[2].ratio_to_best, Some(0.5));
        let mut alone = [timed("jounce", &[10.0])];
        ratios(&mut alone);
        assert_eq!(alone[0].ratio_to_best, None);
    }

    #[test]
    fn the_table_shows_times_counts_and_quality() {
        let mut r = timed("jounce", &[20.0, 40.0]);
        r.quality.insert("top_y".into(), 98.8);
        let text = table(&[r]).markdown();
        let cells = |line: usize| -> Vec<&str> {
            text.lines()
                .nth(line)
                .unwrap_or_default()
                .split('|')
                .map(str::trim)
                .filter(|c| !c.is_empty())
                .collect()
        };
        // No rival, no ratio.
        let row =
            ["large_pyramid", "jounce", "1", "11", "20.0", "30.0", "2.000", "3", "0", "0", "top_y 98.8"];
        assert_eq!((cells(0).len(), cells(2)), (12, row.to_vec()), "{text}");
    }

    #[test]
    fn scenes_are_built_as_specified() {
        for (name, bodies, joints) in [
            ("large_pyramid", 5051, 0),
            ("many_pyramids", 10_781, 0),
            ("joint_grid", 10_000, 19_800),
            ("rain", 100, 0),
            ("junkyard", 10_586, 0),
            ("washer", 8002, 0),
            ("convex_pile", 5121, 0),
            ("trees100", 51, 0),
            ("jolt_pyramid", 1241, 0),
            ("convex_vs_mesh", 1765, 0),
            ("heavy_on_light", 3, 0),
        ] {
            let scene = SCENES.iter().find(|s| s.name == name).expect("listed");
            let (world, _) = (scene.build)().expect("built");
            let counts = world.counts();
            assert_eq!((counts.bodies, counts.joints), (bodies, joints), "{name}");
        }
    }
}
