//! A scene without `seconds` ran up to the last `at` of its timeline, and actions act before the step that starts then: the last
//! one never acted, and what lasts or repeats was cut off.

use jounce::tasks::Tasks;
use jounce_scene::{LoadOptions, Scene, Simulation};

fn scene(rest: &str) -> Scene {
    let text = format!(
        r#"{{"jounce": 1, "gravity": [0, 0, 0],
        "bodies": [{{"name": "ball", "type": "dynamic", "mass": 2, "shapes": [{{"sphere": {{"radius": 0.5}}}}]}},
                   {{"name": "lift", "type": "kinematic", "position": [9, 0, 0], "shapes": [{{"sphere": {{"radius": 0.5}}}}]}}],
        "probes": {{"speed": {{"body": "ball", "value": "speed"}}, "lift": {{"body": "lift", "value": "position.y"}}}}{rest}}}"#
    );
    Scene::from_str(&text, "test.json", &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Speed of the ball and height of the lift at the end.
fn end(scene: &Scene) -> (f64, f64) {
    let mut s = Simulation::new(scene, Tasks::serial()).unwrap_or_else(|e| panic!("{e}"));
    for _ in 0..s.steps_for(scene.seconds()) {
        s.step().unwrap_or_else(|e| panic!("{e}"));
    }
    (s.values()[0], s.values()[1])
}

#[test]
fn the_default_length_holds_all_that_happens() {
    let s = scene(r#", "timeline": [{"at": 3, "push": {"body": "ball", "impulse": [2, 0, 0]}}]"#);
    assert_eq!((s.seconds(), end(&s).0), (4.0, 1.0));
    let s = scene(
        r#", "timeline": [{"at": 1, "every": 0.5, "times": 4, "push": {"body": "ball", "impulse": [2, 0, 0]}}]"#,
    );
    assert_eq!((s.seconds(), end(&s).0), (3.5, 4.0));
    let s = scene(
        r#", "timeline": [{"at": 1, "push": {"body": "ball", "force": [2, 0, 0], "duration": 2}},
                          {"at": 0, "move_to": {"body": "lift", "position": [9, 5, 0], "duration": 6}}]"#,
    );
    let (speed, height) = end(&s);
    assert_eq!((s.seconds(), height), (7.0, 5.0));
    // 480 sums in single precision.
    assert!((speed - 2.0).abs() < 480.0 * 1.2e-7, "{speed}");
}

#[test]
fn expectations_and_the_file_come_first() {
    let expect = r#""expect": [{"name": "late", "probe": "speed", "at": 9, "max": 1}]"#;
    let wake = r#""timeline": [{"at": 1, "wake": {"body": "ball"}}]"#;
    assert_eq!(scene("").seconds(), 5.0);
    assert_eq!(scene(&format!(", {expect}")).seconds(), 9.0);
    assert_eq!(scene(&format!(", {expect}, {wake}")).seconds(), 9.0);
    assert_eq!(scene(&format!(", {wake}, \"seconds\": 1.5")).seconds(), 1.5);
}
