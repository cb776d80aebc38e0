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
