//! The published schema follows from the types. `JOUNCE_BLESS=1 cargo test -p jounce_scene --test schema` writes it.

use std::path::Path;

#[test]
fn the_committed_schema_is_that_of_the_types() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/schema.json");
    let now = jounce_scene::spec::schema();
    if std::env::var_os("JOUNCE_BLESS").is_some() {
        std::fs::write(&path, &now).expect("the schema can be written");
    }
    let there = std::fs::read_to_string(&path).expect("scenes/schema.json is there");
    assert!(
        there == now,
        "scenes/schema.json is out of date; run with JOUNCE_BLESS=1 and look at the difference"
    );
}

#[test]
fn the_schema_names_every_section() {
    let schema: serde_json::Value = serde_json::from_str(&jounce_scene::spec::schema()).expect("JSON");
    for key in
        ["jounce", "bodies", "meshes", "materials", "scatter", "timeline", "probes", "camera", "expect"]
    {
        assert!(schema["properties"][key].is_object(), "{key}");
    }
    assert_eq!(schema["additionalProperties"], false);
    assert_eq!(schema["required"], serde_json::json!(["jounce"]));
}

#[test]
fn every_example_of_the_docs_loads() {
    use jounce_scene::{LoadOptions, Scene, SceneError};
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = std::fs::read_to_string(root.join("docs/scenes.md")).expect("docs/scenes.md is there");
    let options = LoadOptions { assets: root.join("../shared/assets") };
    let blocks: Vec<&str> = text.split("```json\n").skip(1).filter_map(|b| b.split("```").next()).collect();
    assert!(blocks.len() >= 8, "{}", blocks.len());
    for (n, block) in blocks.iter().enumerate() {
        match Scene::from_str(block, &format!("docs/scenes.md#{n}"), &options) {
            Ok(_) => {}
            Err(SceneError::Skipped(why)) => eprintln!("skipped: {why}"),
            Err(e) => panic!("{e}"),
        }
    }
}

/// What `everything.json` leaves out: meshes, which need a file beside it. `shapes.rs` and `mesh` have tests of their own.
const LEFT_OUT: [&str; 15] = [
    "scene.meshes",
    "DecomposeSpec.concavity",
    "DecomposeSpec.mesh",
    "DecomposeSpec.parts_max",
    "DecomposeSpec.resolution",
    "EmitterShapeSpec.mesh",
    "HullSpec.mesh",
    "MeshFileSpec.double_sided",
    "MeshFileSpec.file",
    "MeshFileSpec.scale",
    "MeshFileSpec.up",
    "MeshFileSpec.weld_distance",
    "MeshSpec.mesh",
    "MeshSpec.triangle_materials",
    "ShapeSpec.decompose",
];

/// Marks the keys of `value` as seen, each as "Type.key" by the schema's own types.
fn look(
    root: &serde_json::Value,
    at: &str,
    schema: &serde_json::Value,
    value: &serde_json::Value,
    seen: &mut std::collections::BTreeSet<String>,
) {
    if let Some(name) = schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/")) {
        return look(root, name, &root["$defs"][name], value, seen);
    }
    for kind in ["anyOf", "oneOf", "allOf"] {
        for s in schema[kind].as_array().into_iter().flatten() {
            look(root, at, s, value, seen);
        }
    }
    match value {
        serde_json::Value::Object(entries) => {
            for (key, inner) in entries {
                let known = &schema["properties"][key];
                if known.is_null() {
                    look(root, at, &schema["additionalProperties"], inner, seen);
                } else {
                    seen.insert(format!("{at}.{key}"));
                    look(root, at, known, inner, seen);
                }
            }
        }
        serde_json::Value::Array(items) => {
            items.iter().for_each(|i| look(root, at, &schema["items"], i, seen))
        }
        _ => {}
    }
}

#[test]
fn everything_names_every_key_of_the_schema() {
    let root: serde_json::Value = serde_json::from_str(&jounce_scene::spec::schema()).expect("JSON");
    let scene: serde_json::Value = serde_json::from_str(include_str!("everything.json")).expect("JSON");
    let mut seen = std::collections::BTreeSet::new();
    look(&root, "scene", &root, &scene, &mut seen);
    let keys = |name: &str, of: &serde_json::Value| -> Vec<String> {
        let all = of["properties"].as_object().into_iter().flatten();
        all.map(|(k, _)| format!("{name}.{k}")).collect()
    };
    let mut all = keys("scene", &root);
    for (name, def) in root["$defs"].as_object().expect("types") {
        all.extend(keys(name, def));
        for s in def["oneOf"].as_array().into_iter().chain(def["anyOf"].as_array()).flatten() {
            all.extend(keys(name, s));
        }
    }
    assert!(all.len() > 200, "{}", all.len());
    let missing: Vec<&String> =
        all.iter().filter(|k| !seen.contains(*k) && !LEFT_OUT.contains(&k.as_str())).collect();
    assert!(missing.is_empty(), "{missing:#?}");
    for key in LEFT_OUT {
        assert!(all.iter().any(|k| k == key) && !seen.contains(key), "{key} is there, or no key any more");
    }
}

#[test]
fn everything_runs_to_its_end_as_it_expects() {
    use jounce::tasks::Tasks;
    use jounce_scene::{LoadOptions, Scene, Simulation};
    let scene = Scene::from_str(include_str!("everything.json"), "everything.json", &LoadOptions::default());
    let mut s = Simulation::new(&scene.expect("loads"), Tasks::serial()).expect("starts");
    for _ in 0..60 {
        s.step().expect("steps");
    }
    let report: serde_json::Value = serde_json::from_str(&s.finish().json()).expect("JSON");
    let all = report["expectations"].as_array().expect("expectations");
    assert!(all.len() == 6 && all.iter().all(|e| e["pass"] == true), "{all:#?}");
    assert!(s.systems().len() == 3 && s.systems().iter().all(|s| s.failed_at().is_none()));
    assert!(report["particles"].as_u64().is_some_and(|n| n > 50), "{report}");
}
