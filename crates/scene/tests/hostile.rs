//! Hostile input: every answer is one clear error or a scene, in bounded time, never a panic.
//! `JOUNCE_PROVE=1` runs a hundred times as many mutants.

use jounce::tasks::Tasks;
use jounce_scene::{LoadOptions, MeshData, Scene, SceneError, Simulation};
use std::time::{Duration, Instant};

fn refused(text: &str) -> String {
    let start = Instant::now();
    let e = Scene::from_str(text, "x.json", &LoadOptions::default()).expect_err("refused").to_string();
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}: {e}", start.elapsed());
    assert!(!e.contains('\n') && e.starts_with("x.json:"), "{e}");
    e
}

#[test]
fn deep_nesting_is_refused_without_recursion() {
    for deep in [65, 1_000, 1_000_000] {
        assert!(
            refused(&format!("{{\"jounce\": 1, \"bodies\": {}", "[".repeat(deep)))
                .contains("nested too deeply")
        );
        assert!(refused(&"{\"a\":".repeat(deep)).contains("nested too deeply"));
    }
    // A compound in a compound is not convex, long before the limit of nesting.
    let inner = r#"{"sphere": {"radius": 1}}"#.to_string();
    let nested = (0..12).fold(inner, |s, _| format!(r#"{{"compound": {{"children": [{s}]}}}}"#));
    let text = format!(r#"{{"jounce": 1, "bodies": [{{"type": "dynamic", "shapes": [{nested}]}}]}}"#);
    assert!(refused(&text).contains("is not convex"));
}

#[test]
fn huge_counts_are_refused_before_anything_is_made() {
    let body = r#"{"type": "dynamic", "shapes": [{"sphere": {"radius": 1}}]"#;
    for count in
        ["1000000000", "18446744073709551615", "[2000000, 2000000, 2000000]", "[1, 18446744073709551615, 2]"]
    {
        let text = format!(
            r#"{{"jounce": 1, "bodies": [{body}, "repeat": {{"count": {count}, "step": [1, 1, 1]}}}}]}}"#
        );
        let e = refused(&text);
        assert!(e.contains("at most 524288 bodies"), "{e}");
    }
    let e = refused(&format!(
        r#"{{"jounce": 1, "scatter": [{{"count": 4000000000, "seed": 1,
        "box": {{"min": [0,0,0], "max": [1,1,1]}}, "bodies": [{body}}}]}}]}}"#
    ));
    assert!(e.contains("scatter[0].count: makes 4000000000 bodies"), "{e}");
    let none = refused(&format!(
        r#"{{"jounce": 1, "scatter": [{{"name": "a", "count": 0, "seed": 1, "box": {{"min": [0,0,0], "max": [1,1,1]}},
        "bodies": [{body}}}]}}], "probes": {{"p": {{"body": "a[0]", "value": "speed"}}}}}}"#
    ));
    assert!(none.contains("scatter[0].count: is 0"), "{none}");
    let unused = refused(&format!(
        r#"{{"jounce": 1, "scatter": [{{"count": 1, "seed": 1, "box": {{"min": [0,0,0], "max": [1,1,1]}},
        "bodies": [{body}}}, {{"name": "b", {}}}]}}], "probes": {{"p": {{"body": "b[0]", "value": "speed"}}}}}}"#,
        body.trim_start_matches('{')
    ));
    assert!(unused.contains("no body is made from \"b\""), "{unused}");
    let e = refused(&format!(
        r#"{{"jounce": 1, "timeline": [{{"at": 0, "every": 1, "times": 9000000000,
        "spawn": {{"bodies": [{body}}}]}}}}]}}"#
    ));
    assert!(e.contains("at most 524288 actions"), "{e}");
    for side in ["8192", "9000000000"] {
        let e = refused(&format!(
            r#"{{"jounce": 1, "bodies": [{{"type": "fixed", "shapes": [{{"height_field":
            {{"columns": {side}, "rows": {side}, "function": "noise"}}}}]}}]}}"#
        ));
        assert!(e.contains("height_field"), "{e}");
    }
    let many = vec!["{}"; 200_000].join(",");
    assert!(refused(&format!(r#"{{"jounce": 1, "bodies": [{many}]}}"#)).contains("too many objects"));
    let long = "x".repeat(5000);
    assert!(refused(&format!(r#"{{"jounce": 1, "name": "{long}"}}"#)).contains("a string of 5000 bytes"));
}

#[test]
fn a_full_box_is_told_in_time() {
    let e = refused(
        r#"{"jounce": 1, "scatter": [{"count": 100000, "seed": 1, "min_distance": 0.99,
        "box": {"min": [0, 0, 0], "max": [30, 30, 30]},
        "bodies": [{"type": "dynamic", "shapes": [{"sphere": {"radius": 0.4}}]}]}]}"#,
    );
    assert!(e.contains("the box has room for"), "{e}");
}

#[test]
fn other_encodings_and_folders_are_refused() {
    let dir = std::env::temp_dir().join(format!("jounce_scene_{}", std::process::id()));
    std::fs::create_dir_all(&dir).expect("a folder");
    let latin = dir.join("latin.json");
    std::fs::write(&latin, b"{\"jounce\": 1, \"name\": \"caf\xe9\"}").expect("a file");
    let told =
        |p: &std::path::Path| Scene::load(p, &LoadOptions::default()).expect_err("refused").to_string();
    assert!(told(&latin).contains("is not UTF-8 at byte 26"), "{}", told(&latin));
    assert!(told(&dir).contains("is not a file"));
    assert!(told(&dir.join("gone.json")).contains("there is no such file"));
    let marked = dir.join("marked.json");
    std::fs::write(&marked, "\u{feff}{\"jounce\": 1}").expect("a file");
    assert_eq!(Scene::load(&marked, &LoadOptions::default()).expect("loads").name(), "marked");
    // A truncated mesh is told with the mesh's name, not the scene's.
    std::fs::write(dir.join("rock.glb"), b"glTF\x02\0\0\0\xff\0\0\0").expect("a file");
    let scene = dir.join("rock.json");
    std::fs::write(&scene, r#"{"jounce": 1, "meshes": {"rock": {"file": "rock.glb"}}}"#).expect("a file");
    let e = told(&scene);
    assert!(e.contains("rock.glb: byte 8: truncated: the header declares 255 bytes, the file has 12"), "{e}");
    std::fs::remove_dir_all(&dir).expect("removed");
}

/// A small generator of its own, so that seeds mean the same for ever.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }
    fn below(&mut self, n: usize) -> usize {
        self.next() as usize % n.max(1)
    }
}

const TOKENS: [&[u8]; 24] = [
    b"1e999",
    b"-1",
    b"0",
    b"null",
    b"[",
    b"]",
    b"{",
    b"}",
    b"\"",
    b",",
    b":",
    b"true",
    b"1000000000",
    b"NaN",
    b"-0.0",
    b"1e-46",
    b"3.4e38",
    b"\\u0000",
    b"\xff",
    b"\"mesh\"",
    b"[0,0,0]",
    b"18446744073709551615",
    b"\n",
    b"//",
];

const NUMBERS: [&[u8]; 12] =
    [b"0", b"-1", b"1e-46", b"3.4e38", b"1e30", b"-1e9", b"0.001", b"65536", b"2", b"1e-7", b"-0.0", b"300"];

/// Puts another number in place of one somewhere in the text.
fn renumber(r: &mut Random, b: &mut Vec<u8>) {
    let from = r.below(b.len());
    let Some(at) = (from..b.len()).find(|&k| b[k].is_ascii_digit()) else { return };
    let end = (at..b.len()).find(|&k| !(b[k].is_ascii_digit() || b[k] == b'.')).unwrap_or(b.len());
    drop(b.splice(at..end, NUMBERS[r.below(NUMBERS.len())].iter().copied()));
}

fn mutate(r: &mut Random, source: &[u8]) -> Vec<u8> {
    let mut b = source.to_vec();
    if r.below(2) == 0 {
        (0..1 + r.below(3)).for_each(|_| renumber(r, &mut b));
        return b;
    }
    for _ in 0..1 + r.below(4) {
        let at = r.below(b.len() + 1);
        let end = at + r.below(12).min(b.len() - at);
        match r.below(7) {
            0 if at < b.len() => b[at] ^= 1 << r.below(8),
            1 => drop(b.drain(at..end)),
            2 => {
                let piece = b[at..end].to_vec();
                let to = r.below(b.len() + 1);
                drop(b.splice(to..to, piece));
            }
            3 => drop(b.splice(at..end, TOKENS[r.below(TOKENS.len())].iter().copied())),
            4 => drop(b.splice(at..at, TOKENS[r.below(TOKENS.len())].iter().copied())),
            5 if r.below(4) == 0 => b.truncate(at),
            _ if at < b.len() => b[at] = r.next() as u8,
            _ => {}
        }
    }
    b
}

fn rounds(n: usize) -> usize {
    if std::env::var_os("JOUNCE_PROVE").is_some() { 100 * n } else { n }
}

const EVERYTHING: &str = include_str!("everything.json");

#[test]
fn mutants_of_a_scene_load_or_are_refused() {
    assert!(Scene::from_str(EVERYTHING, "e.json", &LoadOptions::default()).is_ok());
    let mut accepted = 0;
    for seed in 0..rounds(3000) {
        let mut r = Random(seed as u64);
        let text = mutate(&mut r, EVERYTHING.as_bytes());
        let Ok(text) = String::from_utf8(text) else { continue };
        match Scene::from_str(&text, "e.json", &LoadOptions::default()) {
            Ok(scene) if scene.bodies() < 300 => {
                accepted += 1;
                // A body may start in an impossible place; the world must stand it.
                if let Ok(mut s) = Simulation::new(&scene, Tasks::serial()) {
                    for _ in 0..3 {
                        if s.step().is_err() {
                            break;
                        }
                    }
                    assert!(s.finish().json().starts_with('{'), "seed {seed}");
                }
            }
            Ok(_) => {}
            Err(e) => {
                let told = e.to_string();
                assert!(!told.is_empty() && !told.contains('\n'), "seed {seed}: {told}");
                if let SceneError::Fault(f) = &e {
                    assert!(f.position.is_some() || f.file != "e.json", "seed {seed}: {told}");
                }
            }
        }
    }
    assert!(accepted > 100, "{accepted}: the mutants are too wild to test much");
}

#[test]
fn mutants_of_meshes_load_or_are_refused() {
    let obj = b"# a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl a\nf 1 2 3\nf -1 -2 -3\nf 1/1 2/2 4/4 3/3\n"
        .to_vec();
    let text_stl = b"solid a\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n endloop\nendfacet\nendsolid a\n".to_vec();
    let mut binary_stl = vec![0u8; 80];
    binary_stl.extend(2u32.to_le_bytes());
    binary_stl.extend((0..100u8).map(|i| i.wrapping_mul(37)));
    let gltf = br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"children":[1]},{"mesh":0,"scale":[1,2,3]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":5}]}],
"accessors":[{"bufferView":0,"componentType":5121,"count":4,"type":"VEC3"},{"bufferView":1,"componentType":5121,"count":4,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":15,"byteStride":4},{"buffer":0,"byteOffset":16,"byteLength":4}],
"buffers":[{"uri":"data:;base64,AAAAAP8AAAAA/wAA/wAAAAABAgM=","byteLength":20}]}"#
        .to_vec();
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    let padded = gltf.len().next_multiple_of(4);
    glb.extend((20 + padded as u32).to_le_bytes());
    glb.extend((padded as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(&gltf);
    glb.resize(20 + padded, b' ');
    let mut beside = |uri: &str| Err(SceneError::File { file: uri.into(), message: "is not there".into() });
    let sources =
        [("a.obj", obj), ("a.stl", text_stl), ("b.stl", binary_stl), ("a.gltf", gltf), ("a.glb", glb)];
    for (name, source) in sources {
        let mut accepted = 0;
        assert!(MeshData::parse(name, &source, &mut beside).is_ok(), "{name}");
        for seed in 0..rounds(2000) {
            let mutant = mutate(&mut Random(seed as u64), &source);
            match MeshData::parse(name, &mutant, &mut beside) {
                Ok(m) => {
                    accepted += 1;
                    assert!(m.vertices.iter().all(|v| v.is_finite()), "{name}, seed {seed}");
                    let n = m.vertices.len() as u32;
                    assert!(m.triangles.iter().flatten().all(|i| *i < n), "{name}, seed {seed}");
                    assert_eq!(m.triangles.len(), m.triangle_groups.len());
                }
                Err(e) => assert!(!e.to_string().contains('\n'), "{name}, seed {seed}: {e}"),
            }
        }
        assert!(accepted > 20, "{name}: {accepted}");
    }
}
