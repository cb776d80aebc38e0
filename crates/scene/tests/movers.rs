//! Vehicles, characters and ragdolls of scene files: names, copies, actions, drivers, probes.

use jounce::tasks::Tasks;
use jounce_scene::{LoadOptions, Scene, Simulation};

const GROUND: &str =
    r#"{"name": "ground", "type": "fixed", "shapes": [{"half_space": {"normal": [0, 1, 0]}}]}"#;

fn scene(rest: &str) -> Result<Scene, String> {
    let text = format!(r#"{{"jounce": 1, "bodies": [{GROUND}], {rest}}}"#);
    Scene::from_str(&text, "movers.json", &LoadOptions::default()).map_err(|e| e.to_string())
}

fn start(rest: &str) -> Simulation {
    let scene = scene(rest).unwrap_or_else(|e| panic!("{e}"));
    Simulation::new(&scene, Tasks::serial()).unwrap_or_else(|e| panic!("{e}"))
}

fn run(s: &mut Simulation, seconds: f64) {
    for _ in 0..s.steps_for(seconds) {
        s.step().unwrap_or_else(|e| panic!("{e}"));
    }
}

fn value(s: &Simulation, probe: &str) -> f64 {
    let n = s.samples().names().iter().position(|p| p == probe).expect("a probe");
    s.values()[n]
}

#[test]
fn drivers_get_there_evenly() {
    let mut s = start(
        r#""vehicles": [{"name": "car", "preset": "car", "input": {"gear": 1}}],
        "timeline": [{"at": 1, "drive": {"vehicle": "car", "throttle": 0.8, "steer": -0.4, "duration": 1}},
                     {"at": 3, "drive": {"vehicle": "car", "throttle": 0, "brake": 1}}]"#,
    );
    let input = |s: &Simulation| s.world().vehicle(s.vehicles("car")[0]).expect("car").input();
    run(&mut s, 1.0);
    assert_eq!((input(&s).throttle, input(&s).gear), (0.0, 1));
    run(&mut s, 0.5);
    // Half of the way, and the gear stays.
    assert!(
        (input(&s).throttle - 0.4).abs() < 1e-6 && (input(&s).steer + 0.2).abs() < 1e-6,
        "{:?}",
        input(&s)
    );
    run(&mut s, 1.0);
    assert_eq!((input(&s).throttle, input(&s).steer, input(&s).gear), (0.8, -0.4, 1));
    run(&mut s, 0.6);
    assert_eq!((input(&s).throttle, input(&s).brake, input(&s).steer), (0.0, 1.0, -0.4));
}

#[test]
fn a_driver_follows_his_line_until_he_is_asked_otherwise() {
    let mut s = start(
        r#""vehicles": [{"name": "car", "preset": "car", "route": {"points": [[0, 0, 0], [0, 0, 40], [40, 0, 40], [40, 0, 90]],
            "speed": 8}}],
        "timeline": [{"at": 20, "drive": {"vehicle": "car", "steer": 1}}],
        "probes": {"way": {"vehicle": "car", "value": "route"}, "speed": {"vehicle": "car", "value": "speed"},
            "x": {"body": "car", "value": "position.x"}, "z": {"body": "car", "value": "position.z"}}"#,
    );
    run(&mut s, 5.0);
    assert!((value(&s, "speed") - 8.0).abs() < 0.5, "{}", value(&s, "speed"));
    run(&mut s, 14.5);
    // At the end it stands: 130 m along the line, on it.
    assert!(
        value(&s, "way") > 128.0 && value(&s, "speed").abs() < 0.1,
        "{} {}",
        value(&s, "way"),
        value(&s, "speed")
    );
    assert!((value(&s, "x") - 40.0).abs() < 1.0 && (value(&s, "z") - 90.0).abs() < 2.0);
    run(&mut s, 1.0);
    assert!(value(&s, "way").is_nan(), "the driver has got off");
    assert_eq!(s.world().vehicle(s.vehicles("car")[0]).expect("car").input().steer, 1.0);
}

#[test]
fn copies_have_numbers() {
    let mut s = start(
        r#""vehicles": [{"name": "taxi", "preset": "car", "repeat": {"count": [3, 1, 1], "step": [4, 0, 0]}}],
        "characters": [{"name": "crowd", "position": [0, 0, 9], "repeat": {"count": [1, 1, 4], "step": [0, 0, 1]}}],
        "ragdolls": [{"name": "doll", "preset": "human", "position": [0, 1, 20], "repeat": {"count": 2, "step": [2, 0, 0]}}],
        "timeline": [{"at": 1, "drive": {"vehicle": "taxi[1]", "throttle": 1, "gear": 1}},
                     {"at": 1, "walk": {"character": "crowd[3]", "velocity": [0, 0, 2]}}],
        "probes": {"driven": {"vehicle": "taxi", "value": "speed", "aggregate": {"count_above": 1}},
            "walking": {"character": "crowd", "value": "speed", "aggregate": {"count_above": 1}},
            "heads": {"body": "doll.head", "value": "position.x", "aggregate": "spread"},
            "all": {"body": "doll", "value": "mass", "aggregate": "sum"},
            "gaps": {"joint": "doll.neck[1]", "value": "gap"}}"#,
    );
    assert_eq!(
        (s.vehicles("taxi").len(), s.vehicles("taxi[2]").len(), s.vehicles("taxi[3]").len()),
        (3, 1, 0)
    );
    assert_eq!((s.bodies("doll").len(), s.bodies("doll.head").len(), s.joints("doll").len()), (28, 2, 26));
    assert_eq!(s.scene().bodies(), 1 + 3 + 4 + 28);
    assert_eq!(s.scene().joints(), 26);
    assert!((value(&s, "heads") - 2.0).abs() < 1e-6 && (value(&s, "all") - 2.0 * 137.17).abs() < 0.1);
    run(&mut s, 3.0);
    assert_eq!((value(&s, "driven"), value(&s, "walking")), (1.0, 1.0));
    assert!(value(&s, "gaps") < 0.05);
    // The names in the world are those of the file.
    let name = |id| s.world().body(id).expect("alive").name().map(str::to_owned);
    assert_eq!(name(s.bodies("doll.head[1]")[0]).as_deref(), Some("doll.head[1]"));
}

/// Ragdolls are made after vehicles, and have their names before those look for their bodies.
#[test]
fn a_vehicle_is_carried_by_a_bone() {
    let doll = |name: &str, x: f32| {
        format!(
            r#"{{"name": "{name}", "position": [{x}, 0.7, 0], "bones": [
            {{"name": "deck", "shapes": [{{"box": {{"half": [0.5, 0.1, 1]}}, "mass": 200}}]}},
            {{"name": "mast", "parent": "deck", "position": [0, 0.6, 0], "shapes": [{{"sphere": {{"radius": 0.1}}, "mass": 1}}],
             "joint": {{"fixed": {{}}, "on_parent": {{"position": [0, 0.6, 0]}}, "on_bone": {{}}}}}}]}}"#
        )
    };
    let kart = |name: &str, body: &str, mass: f32| {
        format!(
            r#"{{"name": "{name}", "body": "{body}", "wheel": {{"radius": 0.2, "preload": 490.5, "mass": {mass}}},
            "input": {{"throttle": 0.5, "gear": 1}}, "axles": [{{"left": 2, "right": 3}}],
            "wheels": [{{"position": [0.5, -0.45, 0.8]}}, {{"position": [-0.5, -0.45, 0.8]}},
                       {{"position": [0.5, -0.45, -0.8]}}, {{"position": [-0.5, -0.45, -0.8]}}]}}"#
        )
    };
    let (first, second) = (doll("cart", 0.0), doll("wagon", 4.0));
    let (a, b) = (kart("kart", "cart.deck", 10.0), kart("late", "wagon.deck", 10.0));
    let mut s = start(&format!(
        r#""vehicles": [{a}, {{"name": "car", "preset": "car", "position": [8, 0, 0]}}], "ragdolls": [{first}],
        "timeline": [{{"at": 0.5, "spawn": {{"vehicles": [{b}], "ragdolls": [{second}]}}}}],
        "probes": {{"grounded": {{"vehicle": "kart", "value": "grounded"}}, "speed": {{"vehicle": "kart", "value": "speed"}},
            "late": {{"vehicle": "late", "value": "speed"}}, "mast": {{"body": "cart.mast", "value": "velocity.z"}}}}"#
    ));
    run(&mut s, 3.0);
    assert!(value(&s, "grounded") >= 2.0);
    assert!(
        value(&s, "speed") > 1.0 && value(&s, "late") > 1.0,
        "{} {}",
        value(&s, "speed"),
        value(&s, "late")
    );
    assert!((value(&s, "mast") - value(&s, "speed")).abs() < 0.1);
    // What is wrong of it is told at its place, as of other bodies.
    let wrong = |v: &str| {
        scene(&format!(r#""vehicles": [{v}], "ragdolls": [{first}]"#)).map(|_| ()).expect_err("refused")
    };
    let told = wrong(&kart("kart", "cart.deck", 100.0));
    assert!(told.contains("vehicles[0].wheel: have 400"), "{told}");
    let told = wrong(&kart("kart", "cart", 10.0));
    assert!(told.contains("names 2 bodies; expected one, such as cart.deck"), "{told}");
    let told = wrong(&format!("{a}, {}", kart("other", "cart.deck", 10.0)));
    assert!(told.contains("vehicles[1].body: \"cart.deck\" is given to two vehicles"), "{told}");
}

/// Two groups of copies do not share the group of bones that never meet.
#[test]
fn dolls_meet_each_other() {
    let s = start(
        r#""ragdolls": [{"name": "a", "preset": "human", "repeat": {"count": 2, "step": [3, 0, 0]}}, {"name": "b", "preset": "human"}]"#,
    );
    let group = |body: &str| {
        let b = s.world().body(s.body(body).expect("a bone")).expect("alive");
        let shape = b.shapes().next().expect("a shape");
        s.world().shape(shape).expect("alive").filter().group
    };
    let all = [group("a.thigh_l[0]"), group("a.thigh_l[1]"), group("b.thigh_l")];
    assert!(
        all.iter().all(|g| *g < 0) && all[0] != all[1] && all[0] != all[2] && all[1] != all[2],
        "{all:?}"
    );
    assert_eq!(group("a.thigh_l[0]"), group("a.spine_01[0]"));
    assert_eq!(group("a.head[0]"), 0);
}

#[test]
fn poses_are_struck_and_let_go() {
    let rest = r#""gravity": [0, 0, 0], "ragdolls": [{"name": "doll", "preset": "human"}],
        "timeline": [{"at": 0, "pose": {"ragdoll": "doll", "strength": 5, "bones": {"lower_arm_l": {"rotation_deg": [-25, 0, 0]}}}},
                     {"at": 2, "relax": {"ragdoll": "doll"}},
                     {"at": 5, "pose": {"ragdoll": "doll", "strength": 5}}],
        "probes": {"elbow": {"joint": "doll.lower_arm_l", "value": "coordinate_deg"}}"#;
    let mut s = start(rest);
    run(&mut s, 2.0);
    let bent = value(&s, "elbow");
    run(&mut s, 3.0);
    let limp = value(&s, "elbow");
    run(&mut s, 2.0);
    let back = value(&s, "elbow");
    // Bent while it is held; its friction, 5 N m, is more than its weak spring, so it stays so when it is let go; then it is driven back.
    assert!(bent.abs() > 8.0 && (limp - bent).abs() < 0.5 && back.abs() < 3.0, "{bent} {limp} {back}");
}

#[test]
fn a_hand_holds_leads_and_lets_go() {
    let mut s = start(
        r#""vehicles": [{"name": "car", "preset": "car", "position": [0, 0, 30]}],
        "characters": [{"name": "hero", "position": [5, 0, 0], "dynamic": {}}],
        "timeline": [{"at": 0.5, "grab": {"body": "hero", "hand": "mouse", "point": [0, 1, 0], "spring": {"hertz": 6}}},
                     {"at": 0.5, "move_to": {"body": "mouse", "position": [5, 3, 0], "duration": 1}},
                     {"at": 2.5, "remove": {"body": "mouse"}}],
        "probes": {"y": {"body": "hero", "value": "position.y"}, "joints": {"world": "joints"},
            "vehicles": {"world": "vehicles"}, "characters": {"world": "characters"}}"#,
    );
    assert_eq!((value(&s, "vehicles"), value(&s, "characters")), (1.0, 1.0));
    run(&mut s, 2.4);
    assert_eq!(value(&s, "joints"), 1.0);
    // Springs of 6 Hz stretch by g/ω² = 7 mm under it.
    assert!((value(&s, "y") - 2.0).abs() < 0.1, "{}", value(&s, "y"));
    run(&mut s, 2.0);
    assert!(value(&s, "joints") == 0.0 && value(&s, "y") < 0.1, "{}", value(&s, "y"));
    assert!(s.body("mouse").is_none_or(|b| s.world().body(b).is_err()));
}

#[test]
fn a_preset_on_a_body_of_the_scene() {
    let text = r#"{"jounce": 1, "bodies": [
        {"name": "ground", "type": "fixed", "shapes": [{"half_space": {"normal": [0, 1, 0]}}]},
        {"name": "van", "type": "dynamic", "position": [0, 0, 0], "shapes": [
            {"box": {"half": [0.9, 0.7, 2.2]}, "position": [0, 1.1, 0], "mass": 1300}]}],
        "vehicles": [{"name": "delivery", "preset": "car", "body": "van", "traction": {"enabled": false}}],
        "probes": {"n": {"vehicle": "delivery", "value": "load", "aggregate": "sum"}}}"#;
    let scene = Scene::from_str(text, "van.json", &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let mut s = Simulation::new(&scene, Tasks::serial()).expect("starts");
    run(&mut s, 4.0);
    assert!((value(&s, "n") - 1300.0 * 9.81).abs() < 130.0, "{}", value(&s, "n"));
    assert!(s.world().vehicle(s.vehicles("delivery")[0]).expect("alive").desc().traction.is_none());
}

/// As the scene is read: a preset's, and those on a body of the scene.
#[test]
fn wheels_heavier_than_the_whole_are_refused() {
    let told = scene(r#""vehicles": [{"name": "car", "preset": "car", "wheel": {"mass": 400}}]"#)
        .expect_err("refused");
    assert!(told.contains("vehicles[0].wheel: have 1600 kg") && told.contains("0.9"), "{told}");
    let text = r#"{"jounce": 1, "bodies": [{"name": "b", "type": "dynamic", "shapes": [{"sphere": {"radius": 0.1}}]}],
        "vehicles": [{"body": "b", "preset": "car"}]}"#;
    let told = Scene::from_str(text, "light.json", &LoadOptions::default()).expect_err("refused").to_string();
    assert!(told.contains("vehicles[0].wheels: have 80") && told.contains("0.9 of the chassis"), "{told}");
}

/// The same bits from a clone as from the original, drivers and hands included.
#[test]
fn clones_drive_on() {
    let mut s = start(
        r#""vehicles": [{"name": "car", "preset": "car", "route": {"points": [[0, 0, 0], [0, 0, 40], [40, 0, 40]], "speed": 8, "closed": true}}],
        "ragdolls": [{"name": "doll", "preset": "human", "position": [10, 0.2, 0]}],
        "timeline": [{"at": 0.5, "grab": {"body": "doll.head", "hand": "mouse"}},
                     {"at": 0.5, "move_to": {"body": "mouse", "position": [12, 2, 0], "duration": 4}}]"#,
    );
    run(&mut s, 2.0);
    let mut twin = s.clone();
    for _ in 0..120 {
        s.step().expect("steps");
        twin.step().expect("steps");
        assert_eq!(s.world().hash(), twin.world().hash());
    }
}

#[test]
fn actions_leave_out_what_is_gone_and_say_so_once() {
    let mut s = start(
        r#""ragdolls": [{"name": "doll", "preset": "human", "position": [0, 2, 0]}],
        "vehicles": [{"name": "car", "preset": "car", "position": [9, 0, 0]}],
        "characters": [{"name": "hero", "position": [-5, 0.02, 0]}],
        "timeline": [{"at": 0.1, "remove": {"body": "doll.lower_arm_l"}},
            {"at": 0.1, "remove": {"body": "car"}}, {"at": 0.1, "remove": {"body": "hero"}},
            {"at": 0.2, "every": 0.1, "times": 3, "pose": {"ragdoll": "doll", "strength": 1}},
            {"at": 0.5, "relax": {"ragdoll": "doll"}},
            {"at": 0.6, "drive": {"vehicle": "car", "throttle": 1}},
            {"at": 0.6, "walk": {"character": "hero", "velocity": [1, 0, 0]}},
            {"at": 0.7, "remove": {"body": "doll.head"}},
            {"at": 0.8, "push": {"body": "doll.head", "impulse": [1, 0, 0]}},
            {"at": 0.9, "spawn": {"bodies": [{"name": "ball", "type": "dynamic", "position": [5, 5, 5],
                "shapes": [{"sphere": {"radius": 0.1}}]}],
                "joints": [{"a": "doll.head", "b": "ball", "fixed": {}, "at": [5, 5, 5]}]}}]"#,
    );
    run(&mut s, 1.2);
    let said = s.warnings();
    for entry in [3, 4, 5, 6, 8, 9] {
        let told = said.iter().filter(|w| w.starts_with(&format!("timeline[{entry}]:"))).count();
        assert_eq!(told, 1, "entry {entry}: {said:?}");
    }
    assert_eq!(said.len(), 6, "{said:?}");
    assert!(s.body("ball").is_some_and(|b| s.world().body(b).is_ok()), "the rest is done");
}

#[test]
fn actions_on_what_is_not_made_yet_say_so_once() {
    let mut s = start(
        r#""emitters": [{"name": "puff", "preset": "dust"}],
        "timeline": [{"at": 0.1, "every": 0.1, "times": 2, "move_to": {"body": "mouse", "position": [1, 1, 0]}},
            {"at": 0.1, "push": {"body": "ball", "force": [1, 0, 0], "duration": 0.1}},
            {"at": 0.1, "drive": {"vehicle": "car", "throttle": 1}},
            {"at": 0.1, "walk": {"character": "hero", "velocity": [1, 0, 0]}},
            {"at": 0.1, "pose": {"ragdoll": "doll"}},
            {"at": 0.1, "cut": {"joint": "pin"}},
            {"at": 0.5, "spawn": {"bodies": [{"name": "ball", "type": "dynamic", "position": [5, 5, 5], "shapes": [{"sphere": {"radius": 0.1}}]}],
                "joints": [{"name": "pin", "a": "ground", "b": "ball", "at": [5, 5, 5], "ball": {}}],
                "vehicles": [{"name": "car", "preset": "car"}], "characters": [{"name": "hero", "position": [-5, 0.02, 0]}],
                "ragdolls": [{"name": "doll", "preset": "human", "position": [-9, 2, 0]}]}},
            {"at": 0.6, "grab": {"body": "ball", "hand": "mouse", "point": [0, 9, 0]}},
            {"at": 0.7, "move_to": {"body": "mouse", "position": [5, 14, 0]}},
            {"at": 0.7, "push": {"body": "ball", "force": [1, 0, 0], "duration": 0.1}},
            {"at": 0.9, "emit": {"emitter": "puff", "count": 3}},
            {"at": 3.8, "emit": {"emitter": "puff", "count": 3}}]"#,
    );
    run(&mut s, 4.0);
    let mut entries: Vec<&str> = s.warnings().iter().filter_map(|w| w.split(':').next()).collect();
    entries.sort_unstable();
    let mut expected: Vec<String> = (0..6).map(|n| format!("timeline[{n}]")).collect();
    // The dust of entry 10 has settled, and its emitter with it.
    expected.push("timeline[11]".into());
    expected.sort_unstable();
    assert_eq!(entries, expected, "{:?}", s.warnings());
    assert!(s.warnings().iter().all(|w| w.contains(": one thing that it means was not there at t = ")));
}

/// The bow of a ship is far from its middle, and near by its size.
#[test]
fn large_bodies_are_grabbed_at_their_ends() {
    let ship = r#"{"name": "ship", "type": "dynamic", "position": [0, 9, 0], "shapes": [{"box": {"half": [150, 4, 4]}}]}"#;
    let text = |x: u32| {
        format!(
            r#"{{"jounce": 1, "bodies": [{GROUND}, {ship}],
            "timeline": [{{"at": 0.1, "grab": {{"body": "ship", "hand": "mouse", "point": [{x}, 0, 0]}}}}]}}"#
        )
    };
    let load = |x| Scene::from_str(&text(x), "ship.json", &LoadOptions::default());
    assert!(load(150).is_ok());
    let told = load(1600).expect_err("far off").to_string();
    assert!(told.contains("timeline[0].grab.point: is 1600 m away"), "{told}");
}

#[test]
fn spawn_makes_vehicles_characters_and_ragdolls() {
    let mut s = start(
        r#""timeline": [{"at": 0.5, "every": 0.5, "times": 3, "spawn": {
                "bodies": [{"name": "cart", "type": "dynamic", "position": [0, 1, 20], "shapes": [{"box": {"half": [0.5, 0.1, 1]}, "mass": 200}]}],
                "vehicles": [{"name": "car", "preset": "car", "repeat": {"count": [2, 1, 1], "step": [4, 0, 0]}, "velocity": [0, 0, 16], "input": {"gear": 1}}],
                "characters": [{"name": "hero", "position": [-5, 0.02, 0], "velocity": [-2, 0, 0]}],
                "ragdolls": [{"name": "doll", "preset": "human", "position": [-9, 2, 0]}]}},
            {"at": 2.5, "drive": {"vehicle": "car[5]", "throttle": 1}},
            {"at": 2.5, "walk": {"character": "hero[2]", "velocity": [0, 0, 1]}},
            {"at": 2.6, "pose": {"ragdoll": "doll[1]", "strength": 1}},
            {"at": 2.6, "enable_vehicle": {"vehicle": "car[0]", "enabled": false}},
            {"at": 2.7, "remove": {"body": "doll.head[2]"}}],
        "probes": {"cars": {"world": "vehicles"}, "people": {"world": "characters"}, "joints": {"world": "joints"},
            "fast": {"vehicle": "car[5]", "value": "speed"}, "neck": {"joint": "doll.neck[1]", "value": "gap"},
            "far": {"character": "hero[0]", "value": "position.x"}}"#,
    );
    run(&mut s, 0.4);
    assert_eq!((value(&s, "cars"), value(&s, "people"), value(&s, "joints")), (0.0, 0.0, 0.0));
    run(&mut s, 2.0);
    let dolls = value(&s, "joints") / 3.0;
    assert_eq!((value(&s, "cars"), value(&s, "people")), (6.0, 3.0));
    assert!(dolls >= 10.0 && dolls.fract() == 0.0, "{dolls}");
    run(&mut s, 2.0);
    assert!(s.warnings().is_empty(), "{:?}", s.warnings());
    let [fast, far, neck] = ["fast", "far", "neck"].map(|p| value(&s, p));
    assert!(fast > 5.0 && far < -7.0, "a car of {fast} m/s, a hero at {far} m");
    assert!(neck.is_finite(), "doll 1 has a neck: {neck}");
    let car = |n: usize| s.world().vehicle(s.vehicles("car")[n]).expect("car");
    assert!(!car(0).is_enabled(), "taken out");
    assert_eq!(car(5).desc().name.as_deref(), Some("car[5]"));
}
