//! Joints of scene files: copies, timed actions, probes.

use jounce::tasks::Tasks;
use jounce_scene::{LoadOptions, Scene, Simulation};

fn run(text: &str, seconds: f64) -> Simulation {
    let scene = Scene::from_str(text, "joints", &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let mut s = Simulation::new(&scene, Tasks::serial()).unwrap_or_else(|e| panic!("{e}"));
    for _ in 0..s.steps_for(seconds) {
        s.step().unwrap_or_else(|e| panic!("{e}"));
    }
    s
}

#[test]
fn one_entry_joins_a_grid() {
    // 3 × 2 balls, rods along x and along y: 4 + 3; copy (i, j) joins n + i + 3 j.
    let s = run(
        r#"{"jounce": 1, "gravity": [0, 0, 0], "bodies": [
            {"name": "b", "type": "dynamic", "shapes": [{"sphere": {"radius": 0.1}}], "repeat": {"count": [3, 2, 1], "step": [1, 1, 1]}}],
          "joints": [
            {"name": "row", "a": "b[0]", "b": "b[1]", "distance": {},
             "repeat": {"count": [2, 2, 1], "a_step": [1, 3, 0], "b_step": [1, 3, 0]}},
            {"name": "column", "a": "b[0]", "b": "b[3]", "distance": {}, "repeat": {"count": 3}}]}"#,
        0.0,
    );
    let pair = |name: &str| {
        let j = s.world().joint(s.joints(name)[0]).expect("a joint");
        [j.body_a(), j.body_b()]
    };
    let b = s.bodies("b");
    assert_eq!(s.finish().joints, 7);
    assert_eq!(pair("row[3]"), [b[4], b[5]]);
    assert_eq!(pair("column[2]"), [b[2], b[5]]);
    let name = s.world().joint(s.joints("row[2]")[0]).expect("a joint").name();
    assert_eq!(name, Some("row[2]"));
}

#[test]
fn spawned_joints_join_what_was_made_with_them() {
    let s = run(
        r#"{"jounce": 1, "bodies": [{"name": "post", "type": "fixed"}],
          "timeline": [{"at": 0, "every": 0.5, "times": 3, "spawn": {
            "bodies": [{"name": "ball", "type": "dynamic", "position": [0, -1, 0], "shapes": [{"sphere": {"radius": 0.1}}],
                        "repeat": {"count": 2, "step": [0, -1, 0]}}],
            "joints": [{"name": "top", "a": "post", "b": "ball[0]", "distance": {}},
                       {"name": "low", "a": "ball[0]", "b": "ball[1]", "distance": {}}]}}]}"#,
        1.2,
    );
    let (ball, low) = (s.bodies("ball"), s.joints("low"));
    assert_eq!((ball.len(), low.len(), s.joints("top").len()), (6, 3, 3));
    for (n, id) in low.iter().enumerate() {
        let j = s.world().joint(*id).expect("a joint");
        assert_eq!([j.body_a(), j.body_b()], [ball[2 * n], ball[2 * n + 1]]);
    }
}

/// A hinge between bodies that joints do not move is refused, unless a gear follows it.
#[test]
fn a_gear_follows_a_kinematic_wheel() {
    let text = |gear: &str| {
        format!(
            r#"{{"jounce": 1, "gravity": [0, 0, 0], "bodies": [{{"name": "post", "type": "fixed"}},
            {{"name": "led", "type": "kinematic", "angular_velocity": [0, 0, 2]}},
            {{"name": "wheel", "type": "dynamic", "position": [1, 0, 0], "shapes": [{{"box": {{"half": [0.4, 0.4, 0.1]}}}}]}}],
          "joints": [{{"name": "crank", "a": "post", "b": "led", "at": [0, 0, 0], "axis": [0, 0, 1], "hinge": {{}}}},
            {{"name": "shaft", "a": "post", "b": "wheel", "at": [1, 0, 0], "axis": [0, 0, 1], "hinge": {{}}}}{gear}]}}"#
        )
    };
    let s = run(&text(r#", {"gear": {"a": "crank", "b": "shaft", "ratio": -0.5}}"#), 2.0);
    let spin = s.world().body(s.body("wheel").expect("a wheel")).expect("alive").angular_velocity();
    assert!((spin.z - 4.0).abs() < 0.01, "{spin:?}");
    let told = Scene::from_str(&text(""), "joints", &LoadOptions::default()).expect_err("refused");
    assert!(told.to_string().contains("a joint moves neither"), "{told}");
}

#[test]
fn actions_cut_drive_and_switch_joints_and_probes_see_it() {
    let text = r#"{"jounce": 1, "bodies": [{"name": "post", "type": "fixed"},
            {"name": "ball", "type": "dynamic", "position": [0, -1, 0], "can_sleep": false, "shapes": [{"sphere": {"radius": 0.1}, "mass": 2}]},
            {"name": "wheel", "type": "dynamic", "position": [5, 0, 0], "shapes": [{"cylinder": {"half_height": 0.1, "radius": 0.5}}]}],
          "joints": [{"name": "rod", "a": "post", "b": "ball", "at_a": [0, 0, 0], "at_b": [0, -1, 0], "distance": {}},
            {"name": "shaft", "a": "post", "b": "wheel", "at": [5, 0, 0], "axis": [0, 1, 0], "hinge": {}}],
          "timeline": [{"at": 0.5, "set_motor": {"joint": "shaft", "velocity": 4}},
            {"at": 1, "set_motor": {"joint": "shaft", "position_deg": 90, "spring": {"hertz": 3}}},
            {"at": 1, "set_joint": {"joint": "rod", "distance": {"min": 0, "max": 1.5}}},
            {"at": 3, "enable_joint": {"joint": "shaft", "enabled": false}},
            {"at": 3, "cut": {"joint": "rod"}}],
          "probes": {"pull": {"joint": "rod", "value": "force"}, "up": {"joint": "rod", "value": "force.y"},
            "length": {"joint": "rod", "value": "length"}, "spin": {"body": "wheel", "value": "angular_velocity.y"},
            "angle": {"joint": "shaft", "value": "coordinate_deg"}, "on": {"joint": "shaft", "value": "enabled"},
            "joints": {"world": "joints"}}}"#;
    let at = |seconds: f64| run(text, seconds).values().to_vec();
    let v = at(0.5);
    assert!((v[0] - 19.62).abs() < 0.01 && (v[1] - 19.62).abs() < 0.01, "m g, upward: {v:?}");
    assert!(v[3] == 0.0 && v[5] == 1.0 && v[6] == 2.0, "{v:?}");
    assert!((at(1.0)[3] - 4.0).abs() < 1e-3);
    let v = at(3.0);
    assert!((v[2] - 1.5).abs() < 1e-3 && (v[4] - 90.0).abs() < 1.0, "let down, and turned: {v:?}");
    let v = at(3.5);
    assert!(v[0].is_nan() && v[5] == 0.0 && v[6] == 1.0, "{v:?}");
}

/// A hinge counts its turns: its ends may be more than one apart.
#[test]
fn a_steering_wheel_ends_beyond_a_turn() {
    let s = run(
        r#"{"jounce": 1, "gravity": [0, 0, 0], "bodies": [{"name": "post", "type": "fixed"},
            {"name": "wheel", "type": "dynamic", "shapes": [{"cylinder": {"half_height": 0.1, "radius": 0.5}}]}],
          "joints": [{"name": "column", "a": "post", "b": "wheel", "at": [0, 0, 0], "axis": [0, 1, 0],
             "hinge": {"limit": {"min_deg": -400, "max_deg": 400}, "motor": {"velocity": 5, "max_force": 100}}}],
          "probes": {"angle": {"joint": "column", "value": "coordinate_deg"}}}"#,
        3.0,
    );
    assert!((s.values()[0] - 400.0).abs() < 1.0, "{:?}", s.values());
}

#[test]
fn breaks_are_counted() {
    let s = run(
        r#"{"jounce": 1, "bodies": [{"name": "post", "type": "fixed"},
            {"name": "light", "type": "dynamic", "position": [0, -1, 0], "shapes": [{"sphere": {"radius": 0.1}, "mass": 9}]},
            {"name": "heavy", "type": "dynamic", "position": [2, -1, 0], "shapes": [{"sphere": {"radius": 0.1}, "mass": 11}]}],
          "joints": [{"name": "one", "a": "post", "b": "light", "at_a": [0, 0, 0], "at_b": [0, -1, 0], "distance": {}, "break_force": 98.1},
            {"name": "two", "a": "post", "b": "heavy", "at_a": [2, 0, 0], "at_b": [2, -1, 0], "distance": {}, "break_force": 98.1}],
          "probes": {"all": {"events": "joint_break"}, "light": {"events": "joint_break", "body": "light"},
            "one": {"joint": "one", "value": "broken"}, "two": {"joint": "two", "value": "broken"}}}"#,
        1.0,
    );
    assert_eq!(s.values(), [1.0, 0.0, 0.0, 1.0]);
}

/// The file that has every key once: it loads, runs, and its expectations hold.
#[test]
fn everything_runs() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/everything.json");
    let scene = Scene::load(file, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let mut s = Simulation::new(&scene, Tasks::serial()).unwrap_or_else(|e| panic!("{e}"));
    for _ in 0..s.steps_for(1.0) {
        s.step().unwrap_or_else(|e| panic!("{e}"));
    }
    let missed: Vec<_> = s.finish().expectations.into_iter().filter(|e| e.pass != Some(true)).collect();
    assert!(missed.is_empty(), "{missed:?}");
}
