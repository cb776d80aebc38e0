//! Every scene of the `scenes` folder loads, starts, and gives the same finite bits on one thread and on two. Their
//! expectations over the whole length are held by `cargo xtask ci scenes`.

use jounce::tasks::Tasks;
use jounce_scene::{LoadOptions, Scene, SceneError, Simulation};
use std::path::{Path, PathBuf};

/// Steps of each run: the first impacts of most scenes are inside.
const STEPS: u64 = 120;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn files() -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> =
        ["scenes", "scenes/course", "scenes/games", "scenes/joints", "scenes/outside"]
            .iter()
            .filter_map(|folder| std::fs::read_dir(root().join(folder)).ok())
            .flat_map(|entries| entries.map(|e| e.expect("a folder that can be listed").path()))
            .filter(|p| p.extension().is_some_and(|e| e == "json") && !p.ends_with("schema.json"))
            .collect();
    all.sort();
    all
}

/// The scene, or none where it needs meshes that are not on this machine.
fn load(path: &Path) -> Option<Scene> {
    let options = LoadOptions { assets: root().join("../shared/assets") };
    match Scene::load(path, &options) {
        Ok(scene) => Some(scene),
        Err(e @ SceneError::Skipped(_)) => {
            eprintln!("skipped: {e}");
            None
        }
        Err(e) => panic!("{e}"),
    }
}

#[test]
fn scenes_give_the_same_finite_bits_on_one_thread_and_two() {
    let files = files();
    assert!(files.len() >= 15, "only {} scenes", files.len());
    for path in files {
        let file = path.display();
        let Some(scene) = load(&path) else { continue };
        let start = |tasks| Simulation::new(&scene, tasks).unwrap_or_else(|e| panic!("{file}: {e}"));
        let (mut one, mut two) = (start(Tasks::serial()), start(Tasks::pool(2)));
        for step in 1..=STEPS {
            one.step().unwrap_or_else(|e| panic!("{file}: {e}"));
            two.step().unwrap_or_else(|e| panic!("{file}: {e}"));
            assert_eq!(one.world().hash(), two.world().hash(), "{file}: step {step}");
        }
        for id in one.world().bodies() {
            let body = one.world().body(id).expect("a listed body");
            let position = body.position().to_array();
            let finite = position.iter().all(|x| x.is_finite())
                && body.velocity().is_finite()
                && body.angular_velocity().is_finite();
            assert!(finite, "{file}: {position:?}");
        }
    }
}

/// An expectation is only worth something with its origin; a picture needs a camera.
#[test]
fn scenes_say_where_their_numbers_come_from() {
    for path in files() {
        let file = path.display();
        let Some(scene) = load(&path) else { continue };
        let spec = scene.spec();
        assert!(spec.description.is_some() && spec.camera.is_some(), "{file}: no description or camera");
        assert!(!spec.expect.is_empty(), "{file}: no expectations");
        for e in &spec.expect {
            assert!(e.source.as_ref().is_some_and(|s| s.len() > 4), "{file}: {} has no source", e.name);
            assert!(e.at <= scene.seconds() + 1e-9, "{file}: {} is after the end", e.name);
        }
    }
}
