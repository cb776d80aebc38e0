//! The commands as their users call them: exit codes, what is printed where, and which files are left.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn jounce(words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_jounce"));
    command.args(words).current_dir(env!("CARGO_MANIFEST_DIR")).output().expect("the program starts")
}

fn out(o: &Output) -> String {
    String::from_utf8_lossy(&o.stdout).into_owned()
}

fn err(o: &Output) -> String {
    String::from_utf8_lossy(&o.stderr).into_owned()
}

fn code(o: &Output) -> i32 {
    o.status.code().unwrap_or_else(|| panic!("ended by a signal: {}", err(o)))
}

/// Refused: exit code 2, nothing on standard output, one message that holds these words.
fn refused(words: &[&str], message: &[&str]) {
    let o = jounce(words);
    assert_eq!(code(&o), 2, "{words:?}: {}", err(&o));
    assert_eq!(out(&o), "", "{words:?}");
    let text = err(&o);
    assert!(text.starts_with("error:") && !text.contains("panicked"), "{words:?}: {text}");
    for m in message {
        assert!(text.contains(m), "{words:?}: \"{m}\" is not in: {text}");
    }
}

/// An empty folder of a test's own.
fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("jounce_cli_{}_{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).expect("a folder");
    path
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// The one JSON object on standard output.
fn json(o: &Output) -> Value {
    let stdout = out(o);
    assert_eq!(stdout.trim_end().lines().count(), 1, "{stdout}");
    serde_json::from_str(&stdout).unwrap_or_else(|e| panic!("{e}: {stdout}{}", err(o)))
}

#[test]
fn run_prints_a_summary_and_exits_by_the_expectations() {
    let o = jounce(&["run", "tests/data/drop.json"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    for word in ["drop", "1.5 s in 90 steps", "hash", "rests", "ok"] {
        assert!(out(&o).contains(word), "{word}: {}", out(&o));
    }
    let o = jounce(&["run", "tests/data/misses.json"]);
    assert_eq!(code(&o), 1);
    assert!(out(&o).contains("MISS"));
}

#[test]
fn run_json_has_the_contracts_keys_and_one_hash_for_all_threads() {
    let o = jounce(&["run", "tests/data/drop.json", "--json"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let v = json(&o);
    for key in ["steps", "seconds_simulated", "bodies", "joints", "particles", "contacts"] {
        assert!(v[key].is_number(), "{key}: {v}");
    }
    for (key, parts) in [
        ("step_ms", &["median", "p95", "max"][..]),
        ("energy", &["start", "end"]),
        ("momentum", &["linear", "angular"]),
    ] {
        for part in parts {
            assert!(!v[key][part].is_null(), "{key}.{part}: {v}");
        }
    }
    assert_eq!(
        (v["scene"].as_str(), v["bodies"].as_u64(), v["steps"].as_u64()),
        (Some("drop"), Some(3), Some(90))
    );
    let hash = v["hash"].as_str().expect("a string");
    assert!(hash.len() == 18 && hash.starts_with("0x"), "{hash}");
    let e = &v["expectations"][0];
    assert_eq!(
        (e["name"].as_str(), e["expected"].as_f64(), e["pass"].as_bool()),
        (Some("rests"), Some(0.5), Some(true))
    );
    assert!(e["got"].is_number() && e["tolerance"].is_number());

    let many = json(&jounce(&["run", "tests/data/drop.json", "--json", "--threads", "3"]));
    assert_eq!(many["hash"].as_str(), Some(hash));
    // Too short a run: no failure, and no silence.
    let o = jounce(&["run", "tests/data/drop.json", "--json", "--seconds", "0.5"]);
    let short = json(&o);
    assert_eq!((code(&o), short["steps"].as_u64()), (0, Some(30)));
    let e = &short["expectations"][0];
    assert!(e["name"] == "rests" && e["pass"].is_null() && e["got"].is_null(), "{e}");
    assert!(err(&o).contains("warning: 0.5 s are too short to judge: rests (at 1.5 s)"), "{}", err(&o));
    let o = jounce(&["run", "tests/data/drop.json", "--seconds", "0.5"]);
    assert!(code(&o) == 0 && out(&o).contains("not judged") && err(&o).contains("warning:"), "{}", out(&o));
    let o = jounce(&["run", "tests/data/misses.json", "--json"]);
    assert_eq!((code(&o), json(&o)["expectations"][0]["pass"].as_bool()), (1, Some(false)));
}

#[test]
fn a_scene_without_its_meshes_is_skipped() {
    let words = ["run", "tests/data/absent.json", "--json", "--assets", "tests/no_such_folder"];
    let o = jounce(&words);
    assert_eq!(code(&o), 0, "{}", err(&o));
    assert!(json(&o)["skipped"].as_str().is_some_and(|why| why.contains("no_such_folder")));
    let o = jounce(&[words[0], words[1], words[3], words[4]]);
    assert!(code(&o) == 0 && out(&o).contains("skipped"));
}

#[test]
fn run_writes_probes_as_csv() {
    let dir = folder("csv");
    let csv = dir.join("new/probes.csv");
    let o = jounce(&["run", "tests/data/drop.json", "--csv", text(&csv), "--every", "10"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let csv = std::fs::read_to_string(csv).expect("written");
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!((lines[0], lines.len()), ("time,height,ball", 11));
    assert!(lines[1].starts_with("0,2,1"), "{}", lines[1]);
    std::fs::remove_dir_all(dir).expect("removed");
}

#[test]
fn render_writes_pictures_and_films() {
    let dir = folder("render");
    let (png, gif) = (dir.join("a.png"), dir.join("a.gif"));
    let o = jounce(&[
        "render",
        "tests/data/drop.json",
        "-o",
        text(&png),
        "--size",
        "64x36",
        "--at",
        "0.5",
        "--caption",
        "--contacts",
    ]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    assert!(std::fs::read(&png).expect("written").starts_with(b"\x89PNG"));
    let words = [
        "render",
        "tests/data/drop.json",
        "-o",
        text(&gif),
        "--size",
        "64x36",
        "--seconds",
        "0.5",
        "--fps",
        "20",
    ];
    let o = jounce(&words);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let first = std::fs::read(&gif).expect("written");
    assert!(first.starts_with(b"GIF89a"));
    // Twice the same film, with any number of threads.
    let mut again = words.to_vec();
    again.extend(["--threads", "3"]);
    assert_eq!(code(&jounce(&again)), 0);
    assert!(std::fs::read(&gif).expect("written") == first);
    let names: Vec<_> = std::fs::read_dir(&dir).expect("folder").collect();
    assert_eq!(names.len(), 2, "no temporary files stay");
    std::fs::remove_dir_all(dir).expect("removed");
}

#[test]
fn expectations_are_judged_between_samples() {
    let dir = folder("every");
    let csv = dir.join("probes.csv");
    // 40 does not divide the 90 steps, whose last one is judged.
    let o = jounce(&["run", "tests/data/drop.json", "--json", "--csv", text(&csv), "--every", "40"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let every = jounce(&["run", "tests/data/drop.json", "--json"]);
    assert_eq!(json(&o)["expectations"], json(&every)["expectations"]);
    let rows = std::fs::read_to_string(csv).expect("written");
    let times: Vec<f64> = rows.lines().skip(1).filter_map(|l| l.split(',').next()?.parse().ok()).collect();
    assert_eq!(times.len(), 3, "{rows}");
    for (row, t) in times.iter().enumerate() {
        assert!((t - row as f64 * 40.0 / 60.0).abs() < 1e-9, "{rows}");
    }
    std::fs::remove_dir_all(dir).expect("removed");
}

/// Frames of a GIF: its graphic control extensions.
fn frames(path: &Path) -> usize {
    let bytes = std::fs::read(path).expect("written");
    bytes.windows(4).filter(|w| *w == [0x21, 0xF9, 0x04, 0x04] || *w == [0x21, 0xF9, 0x04, 0x05]).count()
}

#[test]
fn films_draw_every_nth_step() {
    let dir = folder("frames");
    let gif = dir.join("a.gif");
    for (every, count) in [("10", 3), ("7", 5)] {
        let words =
            ["render", "tests/data/drop.json", "-o", text(&gif), "--size", "64x36", "--seconds", "0.5"];
        let o = jounce(&[&words[..], &["--every", every]].concat());
        assert_eq!(code(&o), 0, "{}", err(&o));
        assert_eq!(frames(&gif), count, "30 steps, every {every}");
    }
    let both = ["render", "tests/data/drop.json", "-o", text(&gif), "--every", "3", "--fps", "20"];
    refused(&both, &["--every", "--fps", "cannot be used with"]);
    std::fs::remove_dir_all(dir).expect("removed");
}

#[test]
fn trails_are_drawn() {
    let dir = folder("trails");
    let plain = dir.join("plain.json");
    let scene = std::fs::read_to_string("tests/data/throw.json").expect("there");
    let without = scene.replace(
        r#""render": {"trails": {"bodies": ["ball"], "seconds": 2, "width": 0.2}}"#,
        r#""render": {}"#,
    );
    assert_ne!(scene, without);
    std::fs::write(&plain, without).expect("written");
    let (a, b, c) = (dir.join("a.png"), dir.join("b.png"), dir.join("c.png"));
    for (scene, file, threads) in
        [("tests/data/throw.json", &a, "1"), ("tests/data/throw.json", &b, "4"), (text(&plain), &c, "1")]
    {
        let o = jounce(&["render", scene, "-o", text(file), "--size", "96x54", "--threads", threads]);
        assert_eq!(code(&o), 0, "{}", err(&o));
    }
    let [a, b, c] = [a, b, c].map(|p| std::fs::read(p).expect("written"));
    assert!(a == b, "the same at any number of threads");
    assert!(a != c, "the trail shows");
    std::fs::remove_dir_all(dir).expect("removed");
}

#[test]
fn plot_takes_several_scenes_and_powers() {
    let dir = folder("plots");
    let svg = dir.join("a.svg");
    let words = [
        "plot",
        "tests/data/drop.json",
        "tests/data/throw.json",
        "--y",
        "height",
        "-o",
        text(&svg),
        "--log-y",
    ];
    let o = jounce(&words);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let words = std::fs::read_to_string(&svg).expect("written");
    for word in ["drop: height", "throw: height", "height (m)", "drop, throw"] {
        assert!(words.contains(word), "{word}");
    }
    refused(
        &["plot", "tests/data/drop.json", "tests/data/throw.json", "--y", "ball", "-o", text(&svg)],
        &["throw.json", "ball", "height"],
    );
    std::fs::remove_dir_all(dir).expect("removed");
}

#[test]
fn plot_writes_diagrams() {
    let dir = folder("plot");
    let (svg, png) = (dir.join("a.svg"), dir.join("a.png"));
    let o = jounce(&["plot", "tests/data/drop.json", "--y", "height,ball", "-o", text(&svg)]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let words = std::fs::read_to_string(&svg).expect("written");
    for word in ["height", "ball", "time (s)", "(m)", "expected: rests"] {
        assert!(words.contains(word), "{word}");
    }
    let o = jounce(&["plot", "tests/data/drop.json", "--y", "height", "-o", text(&png), "--size", "400x300"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    assert!(std::fs::read(&png).expect("written").starts_with(b"\x89PNG"));
    refused(
        &["plot", "tests/data/drop.json", "--y", "heigth", "-o", text(&png)],
        &["heigth", "height, ball"],
    );
    std::fs::remove_dir_all(dir).expect("removed");
}

#[test]
fn check_points_at_the_mistake() {
    let o = jounce(&["check", "tests/data/drop.json", "tests/data/misses.json"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let o = jounce(&["check", "tests/data/drop.json", "tests/data/broken.json"]);
    assert_eq!(code(&o), 2);
    let message = err(&o);
    for word in ["tests/data/broken.json:4:", "positoin", "did you mean `position`", "4 |", "^"] {
        assert!(message.contains(word), "{word}: {message}");
    }
    let o = jounce(&["check", "tests/data/broken.json", "--json"]);
    assert_eq!(code(&o), 2);
    let v = json(&o);
    let e = &v["files"][0]["error"];
    assert_eq!((e["line"].as_u64(), e["suggestion"].as_str()), (Some(4), Some("position")), "{v}");
}

/// `run --json` of a refused scene printed nothing on standard output.
#[test]
fn a_refused_call_prints_one_json_object_where_that_was_asked_for() {
    let o = jounce(&["run", "tests/data/broken.json", "--json"]);
    assert_eq!(code(&o), 2);
    let e = &json(&o)["error"];
    assert_eq!((e["line"].as_u64(), e["suggestion"].as_str()), (Some(4), Some("position")), "{e}");
    assert!(err(&o).contains("4 |"), "{}", err(&o));
    for words in [
        &["run", "tests/data/none.json", "--json"][..],
        &["verify", "no_such_law_anywhere", "--json"],
        &["bench", "no_such_scene", "--json"],
    ] {
        let o = jounce(words);
        let v = json(&o);
        assert!(code(&o) == 2 && v["error"]["message"].is_string() && v["error"]["line"].is_null(), "{v}");
    }
}

/// A mistake in a mesh was shown with the line of that number of the scene, and without the scene's place.
#[test]
fn a_mistake_in_a_mesh_is_shown_where_the_scene_names_it() {
    let scene = "../scene/tests/broken/mesh_bad_line.json";
    let o = jounce(&["check", scene]);
    let message = err(&o);
    for word in [
        "mesh_bad_line.json:6:15: meshes.rock.file: mesh ",
        "bad_line.obj:3:7: found `nan`",
        "6 |       \"file\"",
    ] {
        assert!(message.contains(word), "{word}: {message}");
    }
    let v = json(&jounce(&["check", scene, "--json"]));
    let e = &v["files"][0]["error"];
    assert_eq!((e["line"].as_u64(), e["key"].as_str()), (Some(6), Some("meshes.rock.file")), "{v}");
    assert!(e["message"].as_str().is_some_and(|m| m.contains("bad_line.obj:3:7")), "{v}");
}

#[test]
fn verify_prints_rows() {
    let o = jounce(&["verify", "projectile", "--json"]);
    let v = json(&o);
    let rows = v["rows"].as_array().expect("rows");
    for r in rows {
        for key in ["name", "topic", "unit", "source"] {
            assert!(r[key].is_string(), "{key}: {r}");
        }
        assert!(r["pass"].is_boolean() && r["tolerance"].is_number(), "{r}");
    }
    let misses = rows.iter().any(|r| r["pass"] == false);
    assert_eq!(code(&o), i32::from(misses), "{}", err(&o));
    refused(&["verify", "no_such_law_anywhere"], &["no_such_law_anywhere", "topics"]);
}

#[test]
fn bench_times_scenes() {
    let o = jounce(&["bench", "heavy_on_light", "--quick", "--json"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let r = &json(&o)["rows"][0];
    assert_eq!((r["scene"].as_str(), r["engine"].as_str()), (Some("heavy_on_light"), Some("jounce")));
    for key in ["threads", "repeats", "ms_min", "ms_median", "bodies", "joints", "touching"] {
        assert!(r[key].is_number(), "{key}: {r}");
    }
    assert!(r["quality"]["sink_heavy_mm"].is_number(), "{r}");
    assert!(r.get("ratio_to_best").is_some());
    let table = out(&jounce(&["bench", "heavy_on_light", "--quick", "--repeats", "2"]));
    let lines: Vec<&str> = table.lines().collect();
    assert!(lines.len() == 3 && lines.iter().all(|l| l.starts_with('|') && l.ends_with('|')), "{table}");
    refused(&["bench", "no_such_scene"], &["no_such_scene", "large_pyramid"]);
    refused(&["bench", "heavy", "--against", "no_such_engine"], &["no_such_engine", "box3d, rapier"]);
    // Before the first engine is built.
    refused(&["bench", "heavy", "--against", "box3d,no_such_engine"], &["no_such_engine"]);
    refused(&["bench", "heavy", "--repeats", "0"], &["repeats"]);
    refused(&["bench", "heavy", "--steps", "1"], &["steps", "from 2"]);
}

#[test]
fn bad_input_is_one_clear_message() {
    let scene = "tests/data/drop.json";
    refused(&["run", "tests/data/none.json"], &["tests/data/none.json"]);
    refused(&["run", "tests/data"], &["tests/data"]);
    refused(&["run", "tests/data/broken.json"], &["positoin"]);
    refused(&["run", scene, "--seconds", "-1"], &["seconds"]);
    refused(&["run", scene, "--seconds", "NaN"], &["seconds"]);
    refused(&["run", scene, "--threads", "0"], &["threads"]);
    refused(&["run", scene, "--every", "0"], &["every"]);
    refused(&["run", scene, "--csv", "tests/data"], &["tests/data"]);
    refused(&["render", scene, "-o", "a.bmp"], &["a.bmp", ".png"]);
    refused(&["render", scene, "-o", "a.png", "--size", "0x9"], &["size"]);
    refused(&["render", scene, "-o", "a.gif", "--fps", "0"], &["fps"]);
    refused(&["render", scene, "-o", "a.gif", "--seconds", "900000"], &["frames"]);
    refused(&["render", scene, "-o", "tests/data/drop.json/a.png", "--size", "16x16"], &["drop.json/a.png"]);
    refused(&["plot", scene, "-o", "a.svg"], &["--y"]);
    refused(&["plot", scene, "--y", "height", "-o", "a.jpg"], &["a.jpg"]);
    refused(&["dance"], &["dance"]);
    refused(&["--threads", "2", "run", scene], &[]);
}

#[test]
fn a_failed_command_leaves_files_alone() {
    let dir = folder("alone");
    let png = dir.join("a.png");
    std::fs::write(&png, "mine").expect("written");
    refused(&["render", "tests/data/broken.json", "-o", text(&png)], &["positoin"]);
    assert_eq!(std::fs::read_to_string(&png).expect("there"), "mine");
    std::fs::remove_dir_all(dir).expect("removed");
}

#[test]
fn help_and_version_are_no_mistakes() {
    let o = jounce(&["--help"]);
    assert_eq!(code(&o), 0);
    for word in ["run", "render", "plot", "check", "verify", "bench"] {
        assert!(out(&o).contains(word), "{word}");
    }
    assert_eq!(code(&jounce(&["--version"])), 0);
}

#[test]
fn a_reader_that_goes_away_is_no_mistake() {
    for words in [
        &["run", "tests/data/drop.json"][..],
        &["verify", "projectile"],
        &["--help"],
        &["check", "tests/data/drop.json"],
    ] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_jounce"))
            .args(words)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        drop(child.stdout.take());
        let o = child.wait_with_output().expect("ends");
        assert_eq!(code(&o), 0, "{words:?}: {}", err(&o));
        assert!(!err(&o).contains("panicked"), "{words:?}: {}", err(&o));
    }
}

/// These were taken, and did nothing.
#[test]
fn words_without_effect_are_refused() {
    refused(&["render", "tests/data/drop.json", "-o", "x.png", "--every", "2"], &["films", ".gif"]);
    refused(&["render", "tests/data/drop.json", "-o", "x.png", "--fps", "5"], &["films", ".gif"]);
    refused(&["run", "tests/data/drop.json", "--every", "2"], &["--csv"]);
    refused(&["check", "tests/data/drop.json", "--threads", "2"], &["--threads"]);
    refused(&["run", "tests/data/drop.json", "--every", "0", "--csv", "x.csv"], &["1 or more"]);
    refused(&["run", "tests/data/drop.json", "--threads", "0"], &["1 to 256"]);
}

#[test]
fn an_unknown_topic_lists_each_topic_once() {
    let o = jounce(&["verify", "nosuch"]);
    let said = err(&o);
    let list = said.split("one of the topics ").nth(1).expect("a list").trim();
    let topics: Vec<&str> = list.split(", ").collect();
    let mut once = topics.clone();
    once.sort_unstable();
    once.dedup();
    assert!(topics.len() > 10 && once.len() == topics.len(), "{said}");
}

/// A name could clear the screen, or show another text than it is.
#[test]
fn names_reach_the_terminal_tame() {
    let dir = folder("tame");
    let file = dir.join("scene.json");
    let scene = r#"{"jounce": 1, "name": "a\u001b[2J\nb\u202ec", "bodies": [],
        "probes": {"p,q": {"world": "energy"}},
        "expect": [{"name": "x\u001b[31m", "probe": "p,q", "at": 0.1, "value": 0, "tolerance": 1}]}"#;
    std::fs::write(&file, scene).expect("written");
    let o = jounce(&["run", text(&file), "--seconds", "0.2"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let all = out(&o) + &err(&o);
    assert!(!all.contains('\u{1b}') && !all.contains('\u{202e}') && all.contains("\\u{202e}"), "{all}");
    // A probe whose name holds a comma can be plotted.
    let plot = dir.join("p.svg");
    let o = jounce(&["plot", text(&file), "--y", "p,q", "-o", text(&plot)]);
    assert!(code(&o) == 0 && plot.is_file(), "{}", err(&o));
}
