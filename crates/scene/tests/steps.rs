//! Every scene gives the same hash at every step, on 1, 2, 4 and 16 threads and under 50 shuffled schedules.
//!
//! `JOUNCE_PROVE=1` takes whole runs of all scenes, with `JOUNCE_ONLY=games,joints` of those folders; without it, the first steps of four. With
//! `JOUNCE_CHAINS=file` the hashes of all steps, folded into one number for each scene, are written to the file: builds
//! are compared by their files.

use jounce::tasks::Tasks;
use jounce_scene::{LoadOptions, Scene, SceneError, Simulation};
use std::fmt::Write;
use std::path::{Path, PathBuf};

const THREADS: [usize; 4] = [1, 2, 4, 16];
const SCHEDULES: u64 = 50;
/// Steps of a run where full counts are not asked for.
const SHORT: usize = 40;

fn prove() -> bool {
    std::env::var_os("JOUNCE_PROVE").is_some()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The scenes that can be loaded here, by name; those without their assets are told and left out.
fn scenes() -> Vec<(String, Scene)> {
    let mut folders = vec![root().join("scenes")];
    let mut files: Vec<(String, PathBuf)> = Vec::new();
    while let Some(folder) = folders.pop() {
        let name = folder.strip_prefix(root()).expect("a folder of the project").display().to_string();
        for entry in std::fs::read_dir(&folder).expect("the folder of scenes") {
            let path = entry.expect("a folder that can be listed").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "json") && !path.ends_with("schema.json") {
                files.push((name.clone(), path));
            }
        }
    }
    files.sort();
    assert!(files.len() >= 15, "only {} scenes", files.len());
    if !prove() {
        files.retain(|(_, p)| {
            ["cards", "drum", "spray", "tower"].iter().any(|n| p.ends_with(format!("{n}.json")))
        });
        assert_eq!(files.len(), 4);
    } else if let Ok(only) = std::env::var("JOUNCE_ONLY") {
        files.retain(|(folder, _)| only.split(',').any(|o| folder.ends_with(o)));
        assert!(!files.is_empty(), "no scenes in {only}");
    }
    let options = LoadOptions { assets: root().join("../shared/assets") };
    let load = |(folder, path): (String, PathBuf)| {
        let name = format!("{folder}/{}", path.file_name().unwrap_or_default().display());
        match Scene::load(&path, &options) {
            Ok(scene) => Some((name, scene)),
            Err(e @ SceneError::Skipped(_)) => {
                println!("{name}: skipped: {e}");
                None
            }
            Err(e) => panic!("{e}"),
        }
    };
    files.into_iter().filter_map(load).collect()
}

fn start(name: &str, scene: &Scene) -> Simulation {
    Simulation::new(scene, Tasks::serial()).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn steps_of(scene: &Scene, s: &Simulation) -> usize {
    let whole = s.steps_for(scene.seconds()) as usize;
    if prove() { whole } else { whole.min(SHORT) }
}

fn step(name: &str, s: &mut Simulation) -> u64 {
    s.step().unwrap_or_else(|e| panic!("{name}: {e}"));
    s.world().hash()
}

/// The hash of every step on the calling thread alone.
fn reference(name: &str, scene: &Scene) -> Vec<u64> {
    let mut s = start(name, scene);
    let hashes: Vec<u64> = (0..steps_of(scene, &s)).map(|_| step(name, &mut s)).collect();
    let distinct = hashes.windows(2).filter(|w| w[0] != w[1]).count();
    assert!(distinct + 1 >= hashes.len(), "{name}: the hash does not follow the steps");
    hashes
}

/// Asserts that the scene goes the reference's way, step by step.
fn agree(name: &str, what: &str, scene: &Scene, reference: &[u64], tasks: Tasks) {
    let mut s = start(name, scene);
    s.world_mut().set_tasks(tasks);
    for (k, expected) in reference.iter().enumerate() {
        assert_eq!(step(name, &mut s), *expected, "{name}, {what}: step {} differs", k + 1);
    }
}

/// All hashes in one: equal only where every step is.
fn chain(hashes: &[u64]) -> u64 {
    hashes.iter().fold(0x9e37_79b9_7f4a_7c15, |sum: u64, h| {
        (sum.rotate_left(5) ^ h).wrapping_mul(0xbf58_476d_1ce4_e5b9)
    })
}

#[test]
fn threads_change_no_step_of_any_scene() {
    let all = scenes();
    let mut chains = String::new();
    for (i, (name, scene)) in all.iter().enumerate() {
        let hashes = reference(name, scene);
        for threads in THREADS {
            agree(name, &format!("{threads} threads"), scene, &hashes, Tasks::pool(threads));
        }
        println!("threads [{}/{}] {name}: {} steps", i + 1, all.len(), hashes.len());
        writeln!(chains, "{:#018x}  {name}, {} steps", chain(&hashes), hashes.len()).expect("a string");
    }
    if let Some(file) = std::env::var_os("JOUNCE_CHAINS") {
        std::fs::write(&file, chains).expect("a file that can be written");
    }
}

#[test]
fn schedules_change_no_step_of_any_scene() {
    let all = scenes();
    let schedules = if prove() { SCHEDULES } else { 4 };
    for (i, (name, scene)) in all.iter().enumerate() {
        let hashes = reference(name, scene);
        for seed in 0..schedules {
            // Every fourth also runs on two threads.
            let tasks = if seed % 4 == 3 { Tasks::chaos_pool(2, seed) } else { Tasks::chaos(seed) };
            agree(name, &format!("schedule {seed}"), scene, &hashes, tasks);
        }
        println!("schedules [{}/{}] {name}: {schedules} × {} steps", i + 1, all.len(), hashes.len());
    }
}
