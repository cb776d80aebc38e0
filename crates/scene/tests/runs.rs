//! Scenes in motion: closed forms through the whole chain from the file to the report.

use jounce::tasks::Tasks;
use jounce_scene::{LoadOptions, Report, Scene, SceneError, Simulation};

fn scene(text: &str) -> Scene {
    Scene::from_str(text, "test.json", &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn run(text: &str) -> (Simulation, Report) {
    run_for(None, text)
}

/// Runs a scene for so long, or for its own length.
fn run_for(seconds: Option<f64>, text: &str) -> (Simulation, Report) {
    let scene = scene(text);
    let mut s = Simulation::new(&scene, Tasks::serial()).unwrap_or_else(|e| panic!("{e}"));
    for _ in 0..s.steps_for(seconds.unwrap_or_else(|| scene.seconds())) {
        s.step().unwrap_or_else(|e| panic!("{e}"));
    }
    let report = s.finish();
    (s, report)
}

/// A free ball: every number of the report has a closed form.
#[test]
fn free_fall_through_the_report() {
    let (s, r) = run_for(
        Some(2.0),
        r#"{"jounce": 1, "name": "fall", "step": {"rate_hz": 120},
        "bodies": [{"name": "ball", "type": "dynamic", "position": [1, 100, 0], "velocity": [3, 0, 0],
                    "shapes": [{"sphere": {"radius": 0.5}, "mass": 2}]}],
        "probes": {"y": {"body": "ball", "value": "position.y"}, "vx": {"body": "ball", "value": "velocity.x"},
                   "e": {"world": "energy"}, "d": {"body": "ball", "value": "distance"},
                   "ke": {"body": "ball", "value": "kinetic_energy"}},
        "expect": [{"name": "height", "probe": "y", "at": 2, "value": 80.38, "tolerance": 0.1},
                   {"name": "too low", "probe": "y", "at": 1, "max": 90},
                   {"name": "range", "probe": "y", "at": 2, "from": 0, "min": 80, "max": 100.001},
                   {"name": "later", "probe": "y", "at": 3, "min": 0}]}"#,
    );
    assert_eq!((r.scene.as_str(), r.steps, r.bodies, r.contacts), ("fall", 240, 1, 0));
    assert!((r.seconds_simulated - 2.0).abs() < 1e-12);
    // Semi-implicit Euler in 4 substeps falls at most g t h/2 = 0.02 m too far (h = 1/480 s).
    let y = s.values()[0];
    assert!((y - (100.0 - 0.5 * 9.81 * 4.0)).abs() <= 9.81 * 2.0 / 480.0, "{y}");
    assert_eq!(s.values()[1], 3.0);
    let p = r.momentum.linear;
    assert!((p[0] - 6.0).abs() < 1e-5 && (p[1] + 2.0 * 9.81 * 2.0).abs() < 1e-3, "{p:?}");
    assert!((r.energy.start - (0.5 * 2.0 * 9.0 + 2.0 * 9.81 * 100.0)).abs() < 1e-2, "{:?}", r.energy);
    let passed: Vec<(&str, Option<bool>)> =
        r.expectations.iter().map(|e| (e.name.as_str(), e.pass)).collect();
    assert_eq!(
        passed,
        [("height", Some(true)), ("too low", Some(false)), ("range", Some(true)), ("later", None)]
    );
    assert_eq!(r.not_judged().map(|e| (e.name.as_str(), e.got)).collect::<Vec<_>>(), [("later", None)]);
    assert!(!r.passed());
    assert_eq!(s.samples().times().len(), 241);
    assert_eq!(s.samples().column("y").expect("there")[0], 100.0);
    assert!((s.values()[3] - (36.0 + (y - 100.0) * (y - 100.0)).sqrt()).abs() < 1e-4);
    let json: serde_json::Value = serde_json::from_str(&r.json()).expect("JSON");
    let hash = json["hash"].as_str().expect("a string");
    assert!(hash.len() == 18 && hash.starts_with("0x"), "{hash}");
    for key in
        ["scene", "steps", "seconds_simulated", "bodies", "joints", "particles", "contacts", "momentum"]
    {
        assert!(!json[key].is_null(), "{key}");
    }
    assert_eq!(json["expectations"][0]["expected"], 80.38);
    assert_eq!(json["expectations"][1]["expected"], "≤ 90");
    assert!(json["expectations"][3]["pass"].is_null() && json["expectations"][3].get("pass").is_some());
}

#[test]
fn timed_actions_act_at_their_step() {
    let (s, r) = run(r#"{"jounce": 1, "gravity": [0, 0, 0], "seconds": 3,
        "bodies": [
          {"name": "a", "type": "dynamic", "position": [0, 0, 0], "shapes": [{"box": {"half": [0.5, 0.5, 0.5]}, "mass": 4}]},
          {"name": "b", "type": "dynamic", "position": [0, 10, 0], "shapes": [{"sphere": {"radius": 0.5}, "mass": 4}]},
          {"name": "c", "type": "dynamic", "position": [0, 20, 0], "shapes": [{"sphere": {"radius": 0.5}}]},
          {"name": "lift", "type": "kinematic", "position": [0, 30, 0], "shapes": [{"box": {"half": [1, 1, 1]}}]},
          {"name": "t", "type": "dynamic", "position": [0, 40, 0], "shapes": [{"sphere": {"radius": 0.5}}]}],
        "timeline": [
          {"at": 1, "push": {"body": "a", "impulse": [8, 0, 0]}},
          {"at": 0.5, "push": {"body": "b", "force": [8, 0, 0], "duration": 0.5}},
          {"at": 1, "remove": {"body": "c"}},
          {"at": 1, "move_to": {"body": "lift", "position": [5, 30, 0], "rotation_deg": [0, 90, 0], "duration": 1}},
          {"at": 0.5, "every": 0.5, "times": 3, "spawn": {"bodies": [
            {"name": "s", "type": "dynamic", "position": [0, -10, 0], "velocity": [1, 0, 0], "shapes": [{"sphere": {"radius": 0.1}}]}]}},
          {"at": 2, "set_velocity": {"body": "t", "velocity": [0, 0, 2], "angular_velocity": [0, 1, 0]}},
          {"at": 2.5, "teleport": {"body": "a", "position": [100, 0, 0]}}],
        "probes": {
          "a": {"body": "a", "value": "position.x"}, "av": {"body": "a", "value": "speed"},
          "b": {"body": "b", "value": "velocity.x"}, "c": {"body": "c", "value": "position.y"},
          "lift": {"body": "lift", "value": "position.x"}, "turn": {"body": "lift", "value": "angle"},
          "n": {"world": "bodies"}, "s0": {"body": "s[0]", "value": "position.x"},
          "far": {"body": "s", "value": "position.x", "aggregate": "max"},
          "late": {"body": "s", "value": "position.x", "aggregate": {"count_below": 1.9}},
          "t": {"body": "t", "value": "position.z"}, "tw": {"body": "t", "value": "angular_speed"}}}"#);
    let value = |name: &str, step: usize| s.samples().column(name).expect("a probe")[step];
    assert_eq!(value("a", 60), 0.0);
    assert!((value("a", 120) - 2.0).abs() < 1e-5, "{}", value("a", 120));
    assert!((value("av", 61) - 2.0).abs() < 1e-6);
    assert!((value("a", 180) - 101.0).abs() < 1e-5, "{}", value("a", 180));
    assert!(
        (value("b", 30)).abs() < 1e-9
            && (value("b", 60) - 1.0).abs() < 1e-5
            && (value("b", 180) - 1.0).abs() < 1e-5
    );
    assert!(value("c", 60) == 20.0 && value("c", 61).is_nan());
    assert!((value("lift", 90) - 2.5).abs() < 1e-4, "{}", value("lift", 90));
    assert!((value("turn", 90) - 45.0).abs() < 0.1, "{}", value("turn", 90));
    assert!((value("lift", 180) - 5.0).abs() < 1e-4 && (value("turn", 180) - 90.0).abs() < 0.1);
    assert_eq!((value("n", 0), r.bodies), (5.0, 7));
    assert!((value("s0", 180) - 2.5).abs() < 1e-4 && (value("far", 180) - 2.5).abs() < 1e-4);
    assert_eq!(value("late", 180), 1.0);
    assert!(value("s0", 10).is_nan());
    assert!((value("t", 180) - 2.0).abs() < 1e-4 && (value("tw", 180) - 1.0).abs() < 1e-4);
}

#[test]
fn copies_stand_where_the_format_says() {
    let s = scene(
        r#"{"jounce": 1, "bodies": [
        {"name": "crate", "type": "dynamic", "position": [10, 0, 0], "shapes": [{"box": {"half": [0.5, 0.5, 0.5]}}],
         "repeat": {"count": [2, 3, 2], "step": [1, 2, 3]}},
        {"name": "wall", "type": "dynamic", "position": [0, 0, 50], "shapes": [{"box": {"half": [0.5, 0.5, 0.5]}}],
         "repeat": {"count": [3, 3, 1], "step": [1, 1, 1], "pyramid": "x"}}]}"#,
    );
    let sim = Simulation::new(&s, Tasks::serial()).expect("runs");
    let at = |name: &str| {
        let id = sim.body(name).unwrap_or_else(|| panic!("{name}"));
        sim.world().body(id).expect("there").position().to_array()
    };
    assert_eq!(at("crate[0]"), [10.0, 0.0, 0.0]);
    assert_eq!(at("crate[1]"), [11.0, 0.0, 0.0]);
    assert_eq!(at("crate[2]"), [10.0, 2.0, 0.0]);
    assert_eq!(at("crate[11]"), [11.0, 4.0, 3.0]);
    assert!(sim.body("crate[12]").is_none());
    assert_eq!(
        [at("wall[2]"), at("wall[3]"), at("wall[5]")],
        [[2.0, 0.0, 50.0], [0.5, 1.0, 50.0], [1.0, 2.0, 50.0]]
    );
    assert!(sim.body("wall[6]").is_none());
    assert_eq!(s.bodies(), 18);
}

const SCATTER: &str = r#"{"jounce": 1, "gravity": [0, 0, 0], "seconds": 0.5, "scatter": [
    {"name": "all", "count": 301, "seed": 7, "box": {"min": [-5, 0, -5], "max": [5, 10, 5]}, "min_distance": 0.9,
     "velocity": [1, 1, 1],
     "bodies": [{"name": "ball", "type": "dynamic", "shapes": [{"sphere": {"radius": 0.2}}]},
                {"name": "brick", "type": "dynamic", "shapes": [{"box": {"half": [0.1, 0.2, 0.3]}}]}]}]}"#;

#[test]
fn scattered_bodies_keep_their_distance_and_their_seed() {
    let start = |text: &str| {
        let s = scene(text);
        let sim = Simulation::new(&s, Tasks::serial()).expect("runs");
        assert!(sim.body("ball[150]").is_some() && sim.body("ball[151]").is_none());
        assert!(sim.body("brick[149]").is_some() && sim.body("brick[150]").is_none());
        let ids: Vec<_> = sim.world().bodies().collect();
        ids.iter().map(|b| sim.world().body(*b).expect("there").position()).collect::<Vec<_>>()
    };
    let (a, b, c) = (start(SCATTER), start(SCATTER), start(&SCATTER.replace("\"seed\": 7", "\"seed\": 8")));
    assert_eq!(a.len(), 301);
    assert!(a == b && a != c);
    for (i, p) in a.iter().enumerate() {
        assert!(p.x.abs() <= 5.0 && p.y >= 0.0 && p.y <= 10.0 && p.z.abs() <= 5.0);
        assert!(a[..i].iter().all(|q| (*p - *q).length() >= 0.9));
    }
}

#[test]
fn the_same_scene_gives_the_same_hash() {
    let (a, b) = (run(SCATTER).1, run(SCATTER).1);
    assert_eq!(a.hash, b.hash);
    assert_ne!(a.hash, run(&SCATTER.replace("\"seed\": 7", "\"seed\": 9")).1.hash);
}

#[test]
fn total_mass_is_scaled() {
    let (s, _) =
        run(r#"{"jounce": 1, "seconds": 0.1, "bodies": [{"name": "a", "type": "dynamic", "mass": 12,
        "shapes": [{"sphere": {"radius": 0.5}, "position": [1, 0, 0]},
                   {"box": {"half": [0.5, 0.5, 0.5]}, "position": [-1, 0, 0]}]}],
        "probes": {"m": {"body": "a", "value": "mass"}, "x": {"body": "a", "value": "center.x"}}}"#);
    let (ball, cube) = (core::f64::consts::PI / 6.0, 1.0);
    assert!((s.values()[0] - 12.0).abs() < 1e-4, "{}", s.values()[0]);
    assert!((s.values()[1] - (ball - cube) / (ball + cube)).abs() < 1e-5, "{}", s.values()[1]);
}

/// A crate at rest on a slope: the ground carries m g cos θ and friction holds m g sin θ.
#[test]
fn contact_forces_carry_the_weight() {
    let (s, _) = run(r#"{"jounce": 1, "seconds": 1, "gravity": [3, -9, 0], "settings": {"sleep": false},
        "bodies": [{"name": "ground", "type": "fixed", "shapes": [{"half_space": {"normal": [0, 1, 0]}}]},
                   {"name": "crate", "type": "dynamic", "position": [0, 0.5, 0],
                    "shapes": [{"box": {"half": [0.5, 0.5, 0.5]}, "mass": 2}]}],
        "probes": {"n": {"body": "crate", "value": "normal_force"}, "t": {"body": "crate", "value": "friction_force"},
                   "c": {"body": "crate", "value": "contacts"}}}"#);
    let v = s.values();
    assert!((v[0] - 18.0).abs() < 0.02 * 18.0 && (v[1] - 6.0).abs() < 0.02 * 6.0 && v[2] == 1.0, "{v:?}");
}

/// What an action causes at once is counted, and once.
#[test]
fn ends_of_contact_by_a_removal_are_counted() {
    let (s, _) = run(r#"{"jounce": 1, "seconds": 1,
        "bodies": [{"name": "ground", "type": "fixed", "shapes": [{"half_space": {"normal": [0, 1, 0]}}]},
                   {"name": "a", "type": "dynamic", "position": [0, 0.5, 0], "shapes": [{"sphere": {"radius": 0.5}}]},
                   {"name": "b", "type": "dynamic", "position": [3, 0.5, 0], "shapes": [{"sphere": {"radius": 0.5}}]}],
        "timeline": [{"at": 0.5, "remove": {"body": "a"}}],
        "probes": {"begin": {"events": "contact_begin"}, "end": {"events": "contact_end"},
                   "of": {"events": "contact_end", "body": "ground"}}}"#);
    assert_eq!(s.values(), [2.0, 1.0, 1.0]);
}

#[test]
fn refusals_while_running_name_the_time() {
    let s = scene(
        r#"{"jounce": 1, "bodies": [{"name": "g", "type": "dynamic", "mass": 1, "shapes": [{"sphere": {"radius": 1}}]}],
        "timeline": [{"at": 0.5, "push": {"body": "g", "impulse": [0, 1e6, 0]}}]}"#,
    );
    let mut sim = Simulation::new(&s, Tasks::serial()).expect("starts");
    let e = (0..60).find_map(|_| sim.step().err()).expect("faster than any body may be");
    assert!(matches!(&e, SceneError::Run { time, .. } if (*time - 0.5).abs() < 1e-9), "{e}");
    assert!(e.to_string().contains("timeline[0]"), "which entry: {e}");
}

/// It stood still 8e35 m away, and nothing said so.
#[test]
fn a_system_whose_numbers_blow_up_is_told_once() {
    let (s, r) = run_for(
        Some(1.0),
        r#"{"jounce": 1, "systems": [{"name": "stiff", "method": "explicit_euler",
            "points": [{"position": [0, 0, 0]}, {"position": [1, 0, 0]}],
            "springs": [{"ends": [0, 1], "stiffness": 1e9, "length": 0.5}]}]}"#,
    );
    let stopped = s.systems()[0].failed_at().expect("it blows up");
    assert_eq!(r.warnings.len(), 1, "{:?}", r.warnings);
    let said = &r.warnings[0];
    assert!(said.contains("system \"stiff\" stopped at t = ") && stopped < 1.0, "{said}");
    assert!(said.contains(&format!("{stopped:.6}")) && said.contains("implicit_euler"), "{said}");
}

/// The particles that there was no room for were counted as born, and nothing said that they were not.
#[test]
fn emitters_without_room_are_told_once_and_count_what_lived() {
    let (s, r) = run_for(
        Some(0.5),
        r#"{"jounce": 1, "emitters": [
            {"name": "flood", "rate": 1e7, "max_particles": 1000, "lifetime_s": [100, 100]},
            {"name": "drip", "rate": 10, "lifetime_s": [100, 100]}],
        "timeline": [{"at": 0.25, "emit": {"emitter": "flood", "count": 4294967295}}],
        "probes": {"flood": {"emitter": "flood", "value": "born"}, "drip": {"emitter": "drip", "value": "born"}}}"#,
    );
    assert_eq!(s.values(), [1000.0, 5.0]);
    assert_eq!((r.particles, r.warnings.len()), (1005, 1), "{:?}", r.warnings);
    let said = &r.warnings[0];
    assert!(
        said.contains("emitter \"flood\"") && said.contains("1000") && said.contains("t = 0.016667"),
        "{said}"
    );
}

/// It was −∞, or NaN without a pull.
#[test]
fn a_body_at_the_centre_of_a_point_field_has_an_energy() {
    for mu in ["0", "1"] {
        let text = r#"{"jounce": 1, "gravity": [0, 0, 0], "fields": [{"point": {"center": [0, 2, 0], "mu": MU}}],
            "bodies": [{"type": "dynamic", "position": [0, 2, 0], "shapes": [{"sphere": {"radius": 0.5}, "mass": 1}]}]}"#;
        let (_, r) = run_for(Some(0.1), &text.replace("MU", mu));
        assert_eq!((r.energy.start, r.energy.end), (0.0, 0.0), "mu {mu}");
    }
}

/// A step's time left out that of the systems, so that a cloth of minutes took no time at all.
#[test]
fn the_time_of_a_step_counts_its_systems() {
    let begin = std::time::Instant::now();
    let (_, r) = run_for(
        Some(0.1),
        r#"{"jounce": 1, "systems": [{"name": "sheet", "method": "rk4",
            "cloth": {"columns": 60, "rows": 60, "origin": [0, 0, 0], "across": [1, 0, 0], "down": [0, -1, 0], "mass": 1,
                      "structural": {"stiffness": 100}}}]}"#,
    );
    let all = begin.elapsed().as_secs_f64() * 1e3;
    assert!(
        r.step_ms.median * r.steps as f64 > 0.3 * all,
        "{:?} of {all} ms in {} steps",
        r.step_ms,
        r.steps
    );
}

/// A prism with a side in the shape of an L, volume 3.
const PRISM: &str = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 1\nv 2 0 1\nv 2 1 1\nv 1 1 1\nv 1 2 1\nv 0 2 1\n\
f 6 5 4 3 2 1\nf 7 8 9 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";

#[test]
fn a_concave_mesh_is_cut_into_convex_parts() {
    let dir = std::env::temp_dir().join(format!("jounce_scene_cut_{}", std::process::id()));
    std::fs::create_dir_all(&dir).expect("a folder");
    std::fs::write(dir.join("l.obj"), PRISM).expect("a file");
    let text = r#"{"jounce": 1, "seconds": 0.1, "gravity": [0, 0, 0],
        "meshes": {"l": {"file": "l.obj"}},
        "bodies": [{"name": "l", "type": "dynamic", "shapes": [{"decompose": {"mesh": "l"}, "density": 100}]},
                   {"name": "h", "type": "dynamic", "position": [9, 0, 0], "shapes": [{"hull": {"mesh": "l"}, "density": 100}]}],
        "probes": {"m": {"body": "l", "value": "mass"}, "x": {"body": "l", "value": "center.x"},
                   "h": {"body": "h", "value": "mass"}}}"#;
    std::fs::write(dir.join("l.json"), text).expect("a file");
    let scene = Scene::load(dir.join("l.json"), &LoadOptions::default());
    std::fs::remove_dir_all(&dir).expect("removed");
    let scene = scene.unwrap_or_else(|e| panic!("{e}"));
    let s = Simulation::new(&scene, Tasks::serial()).expect("starts");
    // The parts may overlap and overhang by one cell of 2/64 along the cut.
    let v = s.values();
    assert!((v[0] / 300.0 - 1.0).abs() < 0.05, "{v:?}");
    assert!((v[1] - 2.5 / 3.0).abs() < 0.05, "{v:?}");
    assert!((v[2] - 350.0).abs() < 0.01, "{v:?}");
}

/// Bodies dropped into a level that other people made, on one and on three threads.
#[test]
fn a_shared_mesh_carries_bodies() {
    let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets");
    let text = r#"{"jounce": 1, "seconds": 2,
        "meshes": {"level": {"file": "assets:box3d/test_map01.obj"}, "stairs": {"file": "assets:box3d/stairs.obj"}},
        "bodies": [{"name": "level", "type": "fixed", "shapes": [{"mesh": {"mesh": "level"}}]}],
        "scatter": [{"name": "rain", "count": 60, "seed": 1, "box": {"min": [-6, 6, -6], "max": [6, 9, 6]}, "min_distance": 1,
          "bodies": [{"type": "dynamic", "shapes": [{"sphere": {"radius": 0.3}}]},
                     {"type": "dynamic", "shapes": [{"box": {"half": [0.3, 0.2, 0.4]}}]}]}],
        "probes": {"lowest": {"body": "rain", "value": "position.y", "aggregate": "min"}}}"#;
    let options = LoadOptions { assets };
    let scene = match Scene::from_str(text, "test.json", &options) {
        Err(SceneError::Skipped(why)) => {
            eprintln!("skipped: {why}");
            return;
        }
        other => other.unwrap_or_else(|e| panic!("{e}")),
    };
    let run = |tasks: Tasks| {
        let mut s = Simulation::new(&scene, tasks).expect("starts");
        for _ in 0..s.steps_for(scene.seconds()) {
            s.step().unwrap_or_else(|e| panic!("{e}"));
        }
        (s.values()[0], s.finish())
    };
    let (lowest, report) = run(Tasks::serial());
    // The ground's top face is at y = 0.
    assert!(lowest > -0.05, "{lowest}");
    assert!(report.contacts > 30, "{}", report.contacts);
    assert_eq!(run(Tasks::pool(3)).1.hash, report.hash);
}
