//! What every program of the comparison shares: arguments, timing, the JSON lines, the scenes.
//!
//! A peer is a crate with a module `world` that makes its engine answer to the calls of `scenes`.
//!
//! Timing rule: build; act and step once untimed; then time the remaining steps, each with what the scene does
//! before it. Of several repeats the fastest counts.

pub mod human;
pub mod parts;
pub mod scenes;
pub mod terrain;

use crate::world::World;
use scenes::{SCENES, Scene};
use serde_json::{Value, json};
use std::process::ExitCode;
use std::time::Instant;

/// The program of one engine.
pub struct Program {
    /// The engine, as the lines and messages name it.
    pub engine: &'static str,
    /// The most threads that this build of it can use.
    pub threads: u32,
    /// Says so where this build must not be timed.
    pub check: fn() -> Result<(), String>,
}

struct Arguments {
    scene: String,
    steps: Option<usize>,
    repeats: usize,
    threads: u32,
}

impl Program {
    /// Runs what the command line asks for.
    pub fn main(&self) -> ExitCode {
        match self.run() {
            Ok(()) => ExitCode::SUCCESS,
            Err(message) => {
                eprintln!("{}-peer: {message}", self.engine);
                ExitCode::from(2)
            }
        }
    }

    fn run(&self) -> Result<(), String> {
        let arguments = self.parse(std::env::args().skip(1))?;
        let wanted: Vec<&Scene> =
            SCENES.iter().filter(|s| arguments.scene == "all" || arguments.scene == s.name).collect();
        if wanted.is_empty() {
            let names: Vec<_> = SCENES.iter().map(|s| s.name).collect();
            return Err(format!(
                "no scene \"{}\"; expected all, {}\n{}",
                arguments.scene,
                names.join(", "),
                self.usage()
            ));
        }
        (self.check)()?;
        for scene in wanted {
            println!("{}", self.report(scene, &arguments)?);
        }
        Ok(())
    }

    fn usage(&self) -> String {
        format!("usage: {}-peer SCENE|all [--steps N] [--repeats R] [--threads N]", self.engine)
    }

    fn parse(&self, mut words: impl Iterator<Item = String>) -> Result<Arguments, String> {
        let mut found = Arguments { scene: String::new(), steps: None, repeats: 3, threads: 1 };
        while let Some(word) = words.next() {
            let mut number = |least: usize, most: usize| {
                let text = words.next().ok_or(format!("{word} needs a number"))?;
                let number: usize =
                    text.parse().map_err(|_| format!("{word} {text}: expected a whole number"))?;
                if (least..=most).contains(&number) {
                    Ok(number)
                } else {
                    Err(format!("{word} {number}: expected {least} to {most}"))
                }
            };
            match word.as_str() {
                "--steps" => found.steps = Some(number(2, 1_000_000)?),
                "--repeats" => found.repeats = number(1, 1000)?,
                "--threads" => found.threads = number(1, self.threads as usize)? as u32,
                _ if word.starts_with('-') || !found.scene.is_empty() => {
                    return Err(format!("unexpected \"{word}\"\n{}", self.usage()));
                }
                _ => found.scene = word,
            }
        }
        Ok(found)
    }

    fn report(&self, scene: &Scene, arguments: &Arguments) -> Result<Value, String> {
        let steps = arguments.steps.unwrap_or(scene.steps);
        let mut best: Option<(f64, Vec<f64>)> = None;
        let mut totals = Vec::new();
        let mut counted = Value::Null;
        for repeat in 0..arguments.repeats {
            let (total, each, world) = run_once(scene, steps, arguments.threads)?;
            eprintln!("{} run {}: {total:.1} ms", scene.name, repeat + 1);
            totals.push(total);
            if best.as_ref().is_none_or(|(least, _)| total < *least) {
                best = Some((total, each));
            }
            if repeat == 0 {
                let (pairs, points) = world.touching();
                counted = json!({"bodies": world.body_count(), "joints": world.joint_count(),
                    "awake": world.awake_count(), "contacts": world.contact_count(), "touching": pairs,
                    "points": points, "quality": (scene.quality)(&world)});
            }
        }
        let (total, each) = best.ok_or("no run")?;
        let mut line = json!({"scene": scene.name, "engine": self.engine, "threads": arguments.threads,
            "steps": steps, "repeats": arguments.repeats, "ms_total_min": total,
            "ms_total_median": median(totals), "ms_median_step": median(each)});
        if let (Some(line), Value::Object(counted)) = (line.as_object_mut(), counted) {
            line.extend(counted);
        }
        Ok(line)
    }
}

/// One timed run: total milliseconds, milliseconds of each timed step, and the world as it ended.
fn run_once(scene: &Scene, steps: usize, threads: u32) -> Result<(f64, Vec<f64>, World), String> {
    let mut world = World::new(threads, scene.gravity_y, scene.capacity)?;
    let mut before = (scene.build)(&mut world)?;
    before(&mut world, 0);
    world.step();
    let mut each = Vec::with_capacity(steps - 1);
    let start = Instant::now();
    let mut last = start;
    for k in 1..steps {
        before(&mut world, k);
        world.step();
        let now = Instant::now();
        each.push((now - last).as_secs_f64() * 1e3);
        last = now;
    }
    Ok(((last - start).as_secs_f64() * 1e3, each, world))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    if values.len() % 2 == 1 { values[half] } else { 0.5 * (values[half - 1] + values[half]) }
}
