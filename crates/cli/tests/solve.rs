//! `jounce solve projectile` as its users call it.

use serde_json::Value;
use std::process::{Command, Output};

fn solve(words: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_jounce"));
    command.args(["solve", "projectile"]).args(words.split_whitespace()).output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The one JSON object of a call that ends well.
fn json(words: &str) -> Value {
    let o = solve(&format!("{words} --json"));
    assert_eq!(o.status.code(), Some(0), "{words}: {}", text(&o.stderr));
    let stdout = text(&o.stdout);
    assert_eq!(stdout.trim_end().lines().count(), 1, "{stdout}");
    serde_json::from_str(&stdout).expect("JSON")
}

fn near(v: &Value, expected: f64, tolerance: f64) {
    let got = v.as_f64().unwrap_or(f64::NAN);
    assert!((got - expected).abs() <= tolerance, "{got}, expected {expected}");
}

const FOOTBALL: &str = "--mass 0.43 --diameter 0.22 --drag 0.25";

#[test]
fn an_angle_gives_the_flight_in_vacuum_and_in_air() {
    let v = json(&format!("--speed 30 --angle 45 {FOOTBALL}"));
    assert_eq!(v["question"], "angle");
    let (vacuum, air) = (&v["vacuum"]["shots"][0], &v["air"]["shots"][0]);
    near(&vacuum["landing"]["distance"], 91.743, 5e-4);
    near(&vacuum["apex"]["position"][1], 22.936, 5e-4);
    near(&air["landing"]["distance"], 50.0127, 5e-5);
    near(&air["landing"]["time"], 3.58942, 5e-6);
    near(&air["apex"]["position"][1], 15.9447, 5e-5);
    // From a height, downwards: the fall of 20 m.
    let v = json("--speed 5 --angle -30 --launch-height 20");
    let t = (-2.5 + (6.25f64 + 2.0 * 9.81 * 20.0).sqrt()) / 9.81;
    near(&v["vacuum"]["shots"][0]["landing"]["time"], t, 1e-9);
    assert!(v["air"].is_null());
}

#[test]
fn a_range_gives_both_angles() {
    let v = json(&format!("--speed 30 --range 45 {FOOTBALL}"));
    let low = 0.5 * (45.0 * 9.81 / 900.0f64).asin().to_degrees();
    let shots = &v["vacuum"]["shots"];
    assert_eq!((shots[0]["name"].as_str(), shots[1]["name"].as_str()), (Some("low"), Some("high")));
    near(&shots[0]["angle_deg"], low, 1e-9);
    near(&shots[1]["angle_deg"], 90.0 - low, 1e-9);
    // What the air's angles do: flown, they land there.
    for shot in v["air"]["shots"].as_array().expect("shots") {
        let angle = shot["angle_deg"].as_f64().expect("a number");
        let flown = json(&format!("--speed 30 --angle {angle} {FOOTBALL}"));
        near(&flown["air"]["shots"][0]["landing"]["distance"], 45.0, 1e-5);
        near(&flown["air"]["shots"][0]["landing"]["time"], shot["time"].as_f64().expect("a number"), 1e-6);
    }
    assert_eq!(v["air"]["shots"].as_array().map(Vec::len), Some(2));
}

#[test]
fn what_cannot_be_reached_is_an_answer() {
    let v = json(&format!("--speed 30 --range 100 {FOOTBALL}"));
    for medium in ["vacuum", "air"] {
        assert_eq!(
            (v[medium]["reachable"].as_bool(), &v[medium]["shots"]),
            (Some(false), &Value::Array(vec![]))
        );
    }
    near(&v["vacuum"]["miss"]["distance"], 100.0 - 900.0 / 9.81, 1e-9);
    near(&v["vacuum"]["miss"]["angle_deg"], 45.0, 1e-9);
    near(&v["vacuum"]["miss"]["speed_needed"], 981f64.sqrt(), 1e-9);
    let (left, x) = (&v["air"]["miss"]["distance"], &v["air"]["miss"]["closest"][0]);
    near(left, 100.0 - x.as_f64().expect("a number"), 1e-9);
    assert!(x.as_f64().is_some_and(|x| x > 50.0127 && x < 51.0), "a little more than at 45°: {x}");
    let o = solve("--speed 30 --range 100");
    let out = text(&o.stdout);
    assert!(o.status.code() == Some(0) && out.contains("cannot be reached"), "{out}");
    assert!(out.contains("8.2569 m short") && out.contains("31.321 m/s would do"), "{out}");
    let out = text(&solve("--speed 30 --target 100,0,0").stdout);
    assert!(out.contains("comes within 5.9014 m"), "{out}");
    let v = json(&format!("--speed 20 --apex 30 {FOOTBALL}"));
    near(&v["vacuum"]["miss"]["distance"], 30.0 - 400.0 / 19.62, 1e-9);
    assert_eq!(v["air"]["reachable"].as_bool(), Some(false));
    let v = json("--speed 10 --target 0,50,0");
    near(&v["vacuum"]["miss"]["distance"], 50.0 - 100.0 / 19.62, 1e-9);
}

#[test]
fn targets_in_space_standing_and_moving() {
    let v = json(&format!("--speed 30 --target 30,5,-12 {FOOTBALL} --wind -3,0,2 --backspin 40"));
    for medium in ["vacuum", "air"] {
        let shots = v[medium]["shots"].as_array().expect("shots");
        assert_eq!(shots.len(), 2, "{medium}");
        for s in shots {
            near(&s["speed"], 30.0, 1e-9);
        }
    }
    // In vacuum the position after the time is the target.
    let s = &v["vacuum"]["shots"][1];
    let t = s["time"].as_f64().expect("a number");
    for (axis, target, g) in [(0, 30.0, 0.0), (1, 5.0, 9.81), (2, -12.0, 0.0)] {
        let v = s["velocity"][axis].as_f64().expect("a number");
        assert!((v * t - 0.5 * g * t * t - target).abs() < 1e-9);
    }
    let v = json("--speed 100 --target 200,80,50 --moving -30,0,10");
    let s = &v["vacuum"]["shots"][0];
    let t = s["time"].as_f64().expect("a number");
    for (axis, target, u, g) in [(0, 200.0, -30.0, 0.0), (1, 80.0, 0.0, 9.81), (2, 50.0, 10.0, 0.0)] {
        let v = s["velocity"][axis].as_f64().expect("a number");
        assert!((v * t - 0.5 * g * t * t - target - u * t).abs() < 1e-8);
    }
    let v = json("--range 40 --height 10");
    near(&v["vacuum"]["shots"][0]["speed"], (9.81 * (1700f64.sqrt() + 10.0)).sqrt(), 1e-9);
    let v = json("--range 40");
    near(&v["vacuum"]["shots"][0]["angle_deg"], 45.0, 1e-6);
    let v = json("--apex 20 --speed 25 --gravity 1.62");
    near(&v["vacuum"]["shots"][0]["apex"]["position"][1], 20.0, 1e-9);
    let v = json(&format!("--apex 12 --speed 30 {FOOTBALL}"));
    near(&v["air"]["shots"][0]["apex"]["position"][1], 12.0, 1e-6);
}

#[test]
fn mistakes_are_told() {
    for (words, message) in [
        ("--speed 30", "nothing is asked"),
        ("--speed -3 --range 10", "above 0"),
        ("--speed nan --range 10", "above 0"),
        ("--speed 30 --angle 100", "-90 to 90"),
        ("--speed 30 --target 1,2", "three numbers"),
        ("--speed 30 --target 0,0,0", "apart from the launch"),
        ("--speed 30 --range 5 --angle 3", "cannot be used"),
        ("--angle 30", "--speed"),
        ("--speed 30 --range 5 --wind 1,0,0", "--mass"),
        ("--speed 30 --range 5 --mass 1", "no drag is given"),
        ("--speed 30 --range 5 --mass 0 --diameter 0.1 --drag 0.5", "above 0"),
        ("--speed 30 --apex 5 --moving 1,0,0", "cannot be used"),
        ("--speed 30 --angle 45 --height 3", "cannot be used"),
        ("--speed 30 --apex 5 --height 3", "cannot be used"),
        ("--speed 30 --range 5 --launch-height 3", "cannot be used"),
        ("--speed 30 --range 5 --gravity 1e-300", "1e-12 to 1e9"),
        ("--speed 30 --range 5 --mass 1e-300 --diameter 0.1 --drag 0.5", "1e-12 to 1e9"),
        ("--speed 30 --range 20 --mass 0.43 --diameter 0.22 --drag 0.25 --spin 0,0,1e9", "stopped after"),
    ] {
        let o = solve(words);
        let (out, err) = (text(&o.stdout), text(&o.stderr));
        assert_eq!((o.status.code(), out.as_str()), (Some(2), ""), "{words}: {err}");
        assert!(err.starts_with("error:") && err.contains(message), "{words}: {err}");
    }
}

/// Numbers that no throw has: refused with the number, whichever question they are part of.
#[test]
fn numbers_that_are_none_are_told() {
    for (words, value) in [
        ("--speed inf --range 10", "inf"),
        ("--speed 0 --range 10", "0"),
        ("--speed 30 --range -5", "-5"),
        ("--speed 30 --range nan", "NaN"),
        ("--speed 30 --apex -1", "-1"),
        ("--speed 30 --target nan,0,0", "NaN"),
        ("--speed 30 --target 10,inf,0", "inf"),
        ("--speed 30 --range 5 --gravity 0", "0"),
        ("--speed 30 --range 5 --gravity nan", "NaN"),
        ("--speed 30 --range 5 --mass -1 --diameter 0.1 --drag 0.5", "-1"),
        ("--speed 30 --range 5 --mass 1 --diameter nan --drag 0.5", "NaN"),
        ("--speed 30 --range 5 --mass 1 --diameter 0.1 --drag -0.5", "-0.5"),
        ("--speed 30 --angle inf", "inf"),
    ] {
        let o = solve(words);
        let (out, err) = (text(&o.stdout), text(&o.stderr));
        assert_eq!((o.status.code(), out.as_str()), (Some(2), ""), "{words}: {err}");
        let told = err.to_lowercase();
        assert!(err.starts_with("error:") && told.contains(&value.to_lowercase()), "{words}: {err}");
        assert!(!told.contains("panicked") && told.contains("expected"), "{words}: {err}");
    }
    // Extreme, and still an answer: as far as the numbers go.
    for words in ["--speed 1e-9 --range 1e9", "--speed 1e9 --range 1e-9", "--speed 1e-3 --target 1e6,1e6,1e6"]
    {
        let o = solve(words);
        assert_eq!(o.status.code(), Some(0), "{words}: {}", text(&o.stderr));
    }
}

/// A shot straight up landed 4.9e-15 m away, and a lone shot was called by two names.
#[test]
fn no_rounding_is_printed_and_a_lone_shot_has_one_name() {
    let o = text(&solve(&format!("--speed 20 --angle 90 {FOOTBALL}")).stdout);
    assert!(!o.contains("e-1"), "{o}");
    for words in ["--range 40", "--range 40 --height 10", "--target 40,0,0"] {
        let v = json(words);
        assert_eq!(v["vacuum"]["shots"][0]["name"], "only", "{words}");
    }
}

/// Each of these took from eight seconds to minutes.
#[test]
fn far_targets_and_stiff_drag_are_answered_soon() {
    for words in [
        "--speed 30 --range 1e6 --mass 0.43 --diameter 0.22 --drag 0.25",
        "--speed 1e6 --range 1e6 --mass 0.43 --diameter 0.22 --drag 0.25",
        "--speed 30 --range 5 --mass 1 --linear-drag 1e3",
        "--speed 30 --range 40 --mass 1 --linear-drag 1e9",
        "--speed 30 --apex 3 --mass 1 --linear-drag 1e6",
        "--speed 30 --range 20 --mass 0.43 --diameter 0.22 --drag 0.25 --wind 0,1e3,0",
    ] {
        let start = std::time::Instant::now();
        let v = json(words);
        assert_eq!(v["air"]["reachable"].as_bool(), Some(false), "{words}");
        let (left, y) = (&v["air"]["miss"]["distance"], &v["air"]["miss"]["closest"][1]);
        assert!(left.as_f64().is_some_and(|d| d > 0.0), "{words}: {v}");
        // Blown up by the wind, it is nearest at the start, not where it was last seen.
        let near = !words.contains("wind") || left.as_f64().is_some_and(|d| d < 20.0);
        assert!(near && y.as_f64().is_some_and(|y| y == 0.0 || y.abs() > 1e-12), "{words}: {v}");
        assert!(start.elapsed().as_secs_f64() < 8.0, "{words}: {:?}", start.elapsed());
    }
}
