//! Ragdolls of scene files: poses of a part, with velocities; bones that are led and given back. And mortar.

use jounce::BodyKind;
use jounce::math::DVec3;
use jounce::math::scalar::f64s;
use jounce::tasks::Tasks;
use jounce_scene::{LoadOptions, Scene, Simulation};

const GROUND: &str =
    r#"{"name": "ground", "type": "fixed", "shapes": [{"half_space": {"normal": [0, 1, 0]}}]}"#;

/// A trunk with two arms along z and −z, which turn about x.
const JACK: &str = r#""ragdolls": [{"name": "jack", "position": [0, 2, 0], "bones": [
    {"name": "trunk", "shapes": [{"sphere": {"radius": 0.1}}]},
    {"name": "fore", "parent": "trunk", "position": [0, 0, 0.5], "shapes": [{"sphere": {"radius": 0.1}}],
     "joint": {"hinge": {"range_deg": [-80, 80]}, "on_parent": {}, "on_bone": {"position": [0, 0, -0.5]}}},
    {"name": "aft", "parent": "trunk", "position": [0, 0, -0.5], "shapes": [{"sphere": {"radius": 0.1}}],
     "joint": {"hinge": {"range_deg": [-80, 80]}, "on_parent": {}, "on_bone": {"position": [0, 0, 0.5]}}}]}],
  "probes": {"fore": {"joint": "jack.fore", "value": "coordinate_deg"}, "aft": {"joint": "jack.aft", "value": "coordinate_deg"},
    "trunk": {"body": "jack.trunk", "value": "position.y"}}"#;
/// Yields by 0.4° under the weight of an arm, 20.5 N m.
const STIFF: &str = r#""spring": {"stiffness": 3000, "damping": 100}"#;
/// Holds the trunk where it is.
const HELD: &str = r#"{"at": 0, "lead": {"ragdoll": "jack", "bones": ["trunk"], "keys": [{"at": 0.1}]}}"#;

fn start_at(rate: u32, rest: &str) -> Simulation {
    let text = format!(
        r#"{{"jounce": 1, "step": {{"rate_hz": {rate}}}, "bodies": [{GROUND}], "seconds": 30, {rest}}}"#
    );
    let scene =
        Scene::from_str(&text, "dolls.json", &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    Simulation::new(&scene, Tasks::serial()).unwrap_or_else(|e| panic!("{e}"))
}

fn start(rest: &str) -> Simulation {
    start_at(60, rest)
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

fn at(s: &Simulation, body: &str) -> DVec3 {
    s.world().body(s.body(body).expect("a body")).expect("alive").position()
}

fn kind(s: &Simulation, body: &str) -> BodyKind {
    s.world().body(s.body(body).expect("a body")).expect("alive").kind()
}

/// Widest gap of a doll's joints, m.
fn gap(s: &Simulation, doll: &str) -> f64 {
    let gap = |j: &jounce::JointId| s.world().joint(*j).map_or(0.0, |j| f64::from(j.gap()));
    s.joints(doll).iter().map(gap).fold(0.0, f64s::max)
}

/// What a joint does that turns freely: its damping pulls at the velocity, its spring back to the pose. They are even where it is ahead by
/// c ω / k.
#[test]
fn a_pose_is_matched_in_velocity_too() {
    let ahead = 100.0 / 3000.0 * 1.5;
    for (spin, expected) in [("", 0.0), (r#""angular_velocity": [1.5, 0, 0]"#, ahead)] {
        let mut s = start(&format!(
            r#""gravity": [0, 0, 0], {JACK}, "timeline": [{HELD},
            {{"at": 0, "pose": {{"ragdoll": "jack", {STIFF}, "bones": {{"fore": {{{spin}}}}}}}}}]"#
        ));
        run(&mut s, 3.0);
        let [fore, aft] = ["fore", "aft"].map(|p| value(&s, p).to_radians());
        // The spring is that of a substep: within what the bone would turn in one.
        assert!((fore - expected).abs() < 1.5 / 240.0 && aft.abs() < 1e-3, "{fore} for {expected}, {aft}");
    }
}

/// Both arms are raised by 30°; then one alone is asked to rest, and the other does as `others` says.
#[test]
fn the_others_of_a_pose_rest_go_limp_or_keep_on() {
    // Twice what the spring yields.
    let (up, near) = (30.0, 0.8);
    for (others, low, high) in [
        ("", -near, near),
        (r#""others": "rest","#, -near, near),
        (r#""others": "keep","#, up - near, up + near),
        // It falls to its end, and 3° beyond at most.
        (r#""others": "limp","#, -83.0, -75.0),
    ] {
        let mut s = start(&format!(
            r#"{JACK}, "timeline": [{HELD},
            {{"at": 0, "pose": {{"ragdoll": "jack", {STIFF}, "bones": {{"fore": {{"rotation_deg": [-30, 0, 0]}}, "aft": {{"rotation_deg": [30, 0, 0]}}}}}}}},
            {{"at": 2, "pose": {{"ragdoll": "jack", {STIFF}, {others} "bones": {{"fore": {{}}}}}}}}]"#
        ));
        run(&mut s, 2.0);
        let [fore, aft] = ["fore", "aft"].map(|p| value(&s, p));
        assert!((fore + up).abs() < near && (aft - up).abs() < near, "{fore} {aft}");
        run(&mut s, 6.0);
        let [fore, aft] = ["fore", "aft"].map(|p| value(&s, p));
        assert!(fore.abs() < near && (low..=high).contains(&aft), "{others}: {fore} {aft}");
    }
}

#[test]
fn some_bones_go_limp() {
    let mut s = start(&format!(
        r#"{JACK}, "timeline": [{HELD}, {{"at": 0, "pose": {{"ragdoll": "jack", {STIFF}}}}},
        {{"at": 1, "relax": {{"ragdoll": "jack", "bones": ["aft"]}}}}]"#
    ));
    run(&mut s, 6.0);
    let [fore, aft] = ["fore", "aft"].map(|p| value(&s, p));
    assert!(fore.abs() < 0.8 && aft.abs() > 75.0, "{fore} {aft}");
}

/// A doll falls in a heap, is led up, along, round, and let go.
const GETS_UP: &str = r#""ragdolls": [{"name": "doll", "preset": "human", "position": [1, 1, 2], "rotation_deg": [70, 0, 0]}],
  "timeline": [{"at": 3, "lead": {"ragdoll": "doll", "here": true, "keys": [
      {"at": 0.5, "position": [0, 0, 0], "rotation_deg": [0, 0, 0]},
      {"at": 1, "position": [3, 0, 0], "rotation_deg": [0, 90, 0], "bones": {"upper_arm_l": {"rotation_deg": [0, 0, 40]}}}]}},
    {"at": 5, "release": {"ragdoll": "doll"}}],
  "probes": {"fastest": {"body": "doll", "value": "speed", "aggregate": "max"}}"#;

#[test]
fn a_doll_gets_up_where_it_lies() {
    let mut s = start(GETS_UP);
    run(&mut s, 3.0);
    let lying = at(&s, "doll.pelvis");
    assert!(lying.y < 0.5 && kind(&s, "doll.pelvis") == BodyKind::Dynamic, "{lying:?}");
    // The limbs keep their lengths on the way: no joint gapes more than where physics left it.
    let (left, mut most) = (gap(&s, "doll"), 0.0);
    for _ in 0..60 {
        s.step().expect("steps");
        most = f64s::max(most, gap(&s, "doll"));
        if s.world().step_count() == 3 * 60 + 15 {
            // Half of the way, straight.
            let half = 0.5 * (lying.y + 0.932087);
            assert!((at(&s, "doll.pelvis").y - half).abs() < 1e-4, "{:?}", at(&s, "doll.pelvis"));
        }
        if s.world().step_count() == 3 * 60 + 30 {
            // At rest above where it lay: the preset's own places, to six digits.
            let [pelvis, head] = ["doll.pelvis", "doll.head"].map(|b| at(&s, b));
            let up = DVec3::new(lying.x, 0.932087, lying.z);
            assert!((pelvis - up).length() < 1e-5, "{pelvis:?} {up:?}");
            // The preset's head is over its pelvis, 5 mm lower than in its table: anchors were pulled together.
            assert!((head.y - 1.6484).abs() < 1e-3 && (head.x - lying.x).abs() < 1e-4, "{head:?}");
        }
    }
    assert!(most < left + 1e-4, "{most} m, {left} m at the start");
    // Turned by 90° about y, so what was to the left (x) is behind (−z), and the frame has gone by 3 m.
    let [pelvis, calf] = ["doll.pelvis", "doll.calf_l"].map(|b| at(&s, b));
    assert!((pelvis.x - lying.x - 3.0).abs() < 1e-5 && calf.z < pelvis.z - 0.05, "{pelvis:?} {calf:?}");
    run(&mut s, 0.9);
    assert!(kind(&s, "doll.head") == BodyKind::Kinematic && value(&s, "fastest") == 0.0, "it stays");
    run(&mut s, 3.0);
    assert!(kind(&s, "doll.head") == BodyKind::Dynamic && at(&s, "doll.head").y < 0.6, "it has fallen");
    assert!(s.warnings().is_empty(), "{:?}", s.warnings());
}

/// At a key a bone is where the key says, whatever the steps before; the same on two threads and from a clone.
#[test]
fn ways_do_not_depend_on_steps_threads_or_clones() {
    let still = GETS_UP.replace(r#""at": 3, "lead""#, r#""at": 0, "lead""#);
    let ends: Vec<DVec3> = [30, 60, 240]
        .iter()
        .map(|rate| {
            let mut s = start_at(*rate, &still);
            run(&mut s, 1.0);
            at(&s, "doll.lower_arm_l")
        })
        .collect();
    assert!(ends.iter().all(|e| *e == ends[0]), "{ends:?}");
    let text = format!(r#"{{"jounce": 1, "bodies": [{GROUND}], {GETS_UP}}}"#);
    let scene = Scene::from_str(&text, "up.json", &LoadOptions::default()).expect("a scene");
    let mut one = Simulation::new(&scene, Tasks::serial()).expect("starts");
    let mut two = Simulation::new(&scene, Tasks::pool(2)).expect("starts");
    let mut twin = None;
    for step in 0..330 {
        one.step().expect("steps");
        two.step().expect("steps");
        assert_eq!(one.world().hash(), two.world().hash(), "step {step}");
        if step == 200 {
            twin = Some(one.clone());
        } else if let Some(twin) = &mut twin {
            twin.step().expect("steps");
            assert_eq!(one.world().hash(), twin.world().hash(), "clone, step {step}");
        }
    }
}

#[test]
fn a_part_is_led_and_the_rest_hangs_on_it() {
    let mut s = start(
        r#""ragdolls": [{"name": "doll", "preset": "human", "position": [0, 1, 0], "repeat": {"count": 2, "step": [3, 0, 0]}}],
        "timeline": [{"at": 0, "lead": {"ragdoll": "doll", "bones": ["lower_arm_l"], "keys": [{"at": 1, "position": [0, 2, 0]}]}},
          {"at": 2, "lead": {"ragdoll": "doll[1]", "bones": ["lower_arm_l"], "keys": [{"at": 9, "position": [0, 20, 0]}]}},
          {"at": 2.5, "lead": {"ragdoll": "doll[1]", "bones": ["lower_arm_l"], "keys": [{"at": 0.25, "position": [0, 3, 0]}]}},
          {"at": 3, "release": {"ragdoll": "doll[1]"}}]"#,
    );
    let arms = |s: &Simulation| [0, 1].map(|n| at(s, &format!("doll.lower_arm_l[{n}]")));
    let begun = arms(&s);
    run(&mut s, 2.0);
    for (n, (a, b)) in begun.iter().zip(arms(&s)).enumerate() {
        // Copies keep their places: 1 m up, each of them.
        assert!((b - *a - DVec3::Y).length() < 1e-5, "{n}: {a:?} {b:?}");
        assert_eq!(kind(&s, &format!("doll.upper_arm_l[{n}]")), BodyKind::Dynamic);
        // It hangs by its arm.
        let pelvis = at(&s, &format!("doll.pelvis[{n}]"));
        assert!(pelvis.y < b.y && pelvis.y > b.y - 1.5, "{n}: {pelvis:?} {b:?}");
    }
    assert!(gap(&s, "doll") < 0.01, "{}", gap(&s, "doll"));
    run(&mut s, 0.9);
    // A later way ends the one before, which would go on for long.
    let [_, b] = arms(&s);
    assert!((b - begun[1] - DVec3::Y * 2.0).length() < 1e-5, "{b:?}");
    run(&mut s, 3.1);
    // One hangs, the other was let go.
    let [a, b] = arms(&s);
    assert!((a - begun[0] - DVec3::Y).length() < 1e-5 && b.y < 1.0, "{a:?} {b:?}");
}

/// A way that is broken off is gone on with: what was led keeps its speed.
#[test]
fn what_is_released_on_its_way_flies_on() {
    let mut s = start(
        r#""ragdolls": [{"name": "doll", "preset": "human", "position": [0, 5, 0]}],
        "timeline": [{"at": 0, "lead": {"ragdoll": "doll", "keys": [{"at": 2, "position": [8, 5, 0]}]}},
          {"at": 1, "release": {"ragdoll": "doll"}}],
        "probes": {"fastest": {"body": "doll", "value": "speed", "aggregate": "max"}}"#,
    );
    run(&mut s, 1.0);
    assert!((at(&s, "doll.pelvis").x - 4.0).abs() < 1e-5, "{:?}", at(&s, "doll.pelvis"));
    s.step().expect("steps");
    // 4 m/s of the way; a step of gravity is 0.16 m/s, across it, and what the springs of the joints add.
    assert!((value(&s, "fastest") - 4.0).abs() < 0.5, "{}", value(&s, "fastest"));
    run(&mut s, 0.5);
    assert!((at(&s, "doll.pelvis").x - 6.0).abs() < 0.2, "{:?}", at(&s, "doll.pelvis"));
}

#[test]
fn lost_bones_are_left_out_and_told_once() {
    let mut s = start(
        r#""ragdolls": [{"name": "doll", "preset": "human", "position": [0, 1, 0], "repeat": {"count": 2, "step": [3, 0, 0]}}],
        "timeline": [{"at": 0, "remove": {"body": "doll.head"}}, {"at": 0, "remove": {"body": "doll.pelvis[1]"}},
          {"at": 0.1, "lead": {"ragdoll": "doll", "here": true, "keys": [{"at": 0.5, "position": [0, 2, 0]}]}},
          {"at": 1, "every": 0.1, "times": 2, "release": {"ragdoll": "doll", "bones": ["head", "neck"]}},
          {"at": 1, "lead": {"ragdoll": "doll", "bones": ["head"], "keys": [{"at": 0.5}]}}]"#,
    );
    run(&mut s, 2.0);
    let said = s.warnings();
    let what: Vec<&str> = said.iter().filter_map(|w| w.split(" not there").next()).collect();
    assert_eq!(
        what,
        [
            // The head of the first; the second as a whole, which has no pelvis to get up over.
            "timeline[2]: 2 things that it means were",
            "timeline[3]: 2 things that it means were",
            "timeline[4]: 2 things that it means were"
        ],
        "{said:?}"
    );
    assert!((at(&s, "doll.pelvis[0]").y - 2.932087).abs() < 1e-5, "{:?}", at(&s, "doll.pelvis[0]"));
    assert_eq!(kind(&s, "doll.neck[0]"), BodyKind::Dynamic);
    assert_eq!(kind(&s, "doll.thigh_l[1]"), BodyKind::Dynamic);
}

/// A wall of three by three, and a brick beside it.
fn wall(mortar: &str, rest: &str) -> String {
    format!(
        r#"{{"jounce": 1, "bodies": [{GROUND},
        {{"name": "brick", "type": "dynamic", "position": [0, 0.1, 0], "shapes": [{{"box": {{"half": [0.2, 0.1, 0.1]}}}}],
         "repeat": {{"count": [3, 3, 1], "step": [0.4, 0.2, 0]}}}},
        {{"name": "loose", "type": "dynamic", "position": [0, 0.1, 1], "shapes": [{{"box": {{"half": [0.2, 0.1, 0.1]}}}}]}}],
        "mortar": [{{"name": "mortar", {mortar}, "strength": 1e5}}]{rest}}}"#
    )
}

#[test]
fn mortar_holds_what_touches() {
    let load = |text: &str| Scene::from_str(text, "wall.json", &LoadOptions::default()).expect("a scene");
    let timeline = r#", "timeline": [{"at": 0.5, "cut": {"joint": "mortar[0]"}}, {"at": 0.6, "enable_joint": {"joint": "mortar", "enabled": false}}],
        "probes": {"n": {"world": "joints"}, "held": {"joint": "mortar", "value": "enabled", "aggregate": "sum"},
          "broken": {"joint": "mortar", "value": "broken", "aggregate": "sum"}}"#;
    let scene = load(&wall(r#""bodies": ["brick", "loose", "brick[0]"]"#, timeline));
    let mut s = Simulation::new(&scene, Tasks::serial()).expect("starts");
    // 2 · 3 perpends and 3 · 2 beds; edges alone hold nothing, and the loose one is 1 m off.
    assert_eq!((s.joints("mortar").len(), value(&s, "n"), value(&s, "held")), (12, 12.0, 12.0));
    // Faces of 0.2 × 0.2 m² in perpends, 0.4 × 0.2 m² in beds; force σ A, moment σ A √A / 6.
    let mut beds = 0;
    for j in s.joints("mortar") {
        let d = s.world().joint(*j).expect("there").desc();
        let (perpend, bed) = ((d.break_force - 4000.0).abs() < 4.0, (d.break_force - 8000.0).abs() < 8.0);
        assert!(perpend || bed, "{}", d.break_force);
        let moment = d.break_force * (d.break_force / 1e5).sqrt() / 6.0;
        assert!((d.break_torque / moment - 1.0).abs() < 1e-3 && d.collide, "{}", d.break_torque);
        beds += usize::from(bed);
    }
    assert_eq!(beds, 6);
    run(&mut s, 0.55);
    assert_eq!((value(&s, "n"), value(&s, "held"), value(&s, "broken")), (11.0, 11.0, 0.0));
    run(&mut s, 0.2);
    assert_eq!((value(&s, "n"), value(&s, "held")), (11.0, 0.0));
    // The ground is no different: each brick of the lowest course stands on it.
    let s = Simulation::new(&load(&wall(r#""bodies": ["brick", "ground"]"#, "")), Tasks::serial());
    assert_eq!(s.expect("starts").joints("mortar").len(), 15);
    // A bed of 0.08 m² counts, a perpend of 0.04 m² does not.
    let s = Simulation::new(&load(&wall(r#""bodies": ["brick"], "area_min": 0.06"#, "")), Tasks::serial());
    assert_eq!(s.expect("starts").joints("mortar").len(), 6);
}

#[test]
fn mortar_that_reaches_nobody_is_told() {
    let text = wall(r#""bodies": ["brick[0]", "loose"], "gap": 0.5"#, "");
    let scene = Scene::from_str(&text, "wall.json", &LoadOptions::default()).expect("a scene");
    let e = Simulation::new(&scene, Tasks::serial()).map(|_| ()).expect_err("refused").to_string();
    assert!(e.contains("mortar[0]: no two of its bodies share a face; expected at least 0.0001 m²"), "{e}");
    let text = wall(r#""bodies": ["brick[0]", "loose"], "gap": 0.85"#, "");
    let scene = Scene::from_str(&text, "wall.json", &LoadOptions::default()).expect("a scene");
    let s = Simulation::new(&scene, Tasks::serial()).expect("a gap of 0.8 m is filled");
    assert_eq!(s.joints("mortar").len(), 1);
}
