//! Memory and time of the readers on hostile files: at most 64 MiB + 16 × input, at most 1 s per MiB (and 1 s).
//! Cutting a mesh into convex parts is work that a scene asks for: at most 192 MiB and 30 s for each of its 8 cuts.
//!
//! A count of the bytes that are allocated at a time, the file's own bytes included; the clock is given five times
//! as long, for machines that do other things too.

use jounce::math::scalar::f64s;
use jounce_scene::{LoadOptions, MeshData, Scene};
use std::alloc::{GlobalAlloc, Layout, System};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

struct Counting;

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn grown(by: usize) {
    let live = LIVE.fetch_add(by, Ordering::SeqCst) + by;
    PEAK.fetch_max(live, Ordering::SeqCst);
}

// SAFETY: forwards to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grown(layout.size());
        // SAFETY: promised by the caller.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Ordering::SeqCst);
        // SAFETY: promised by the caller.
        unsafe { System.dealloc(at, layout) }
    }
    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // The old block is there until the new one is filled.
        grown(size);
        // SAFETY: promised by the caller.
        let new = unsafe { System.realloc(at, layout, size) };
        LIVE.fetch_sub(if new.is_null() { size } else { layout.size() }, Ordering::SeqCst);
        new
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const MIB: f64 = 1024.0 * 1024.0;
/// MiB and seconds, whatever the input.
const LOADING: [f64; 2] = [64.0, 1.0];
const CUTTING: [f64; 2] = [192.0, 30.0];

/// Runs `load`, prints a line, and gives what is out of bounds.
fn measure<T>(
    what: &str,
    input: usize,
    [mib, seconds_least]: [f64; 2],
    load: impl FnOnce() -> Result<T, String>,
) -> Option<String> {
    let before = LIVE.load(Ordering::SeqCst);
    PEAK.store(before, Ordering::SeqCst);
    let start = Instant::now();
    let loaded = load();
    let seconds = start.elapsed().as_secs_f64();
    let peak = (PEAK.load(Ordering::SeqCst) - before) as f64 / MIB;
    let size = input as f64 / MIB;
    let (memory_max, seconds_max) = (mib + 16.0 * size, f64s::max(size, seconds_least));
    let told = loaded.err().map_or("loads".into(), |e| e.chars().take(90).collect::<String>());
    let line = format!(
        "{what}: {size:.2} MiB in, {peak:.1} MiB of {memory_max:.0}, {seconds:.2} s of {seconds_max:.1}: {told}"
    );
    println!("{line}");
    (peak > memory_max || seconds > 5.0 * seconds_max).then_some(line)
}

/// A folder that goes with the test.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        let path = std::env::temp_dir().join(format!("jounce_memory_{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }
    /// Loads a scene beside the files, from disk.
    fn scene(&self, what: &str, scene: &str, files: &[(&str, &[u8])], bounds: [f64; 2]) -> Option<String> {
        let put = |name: &str, bytes: &[u8]| std::fs::write(self.0.join(name), bytes).expect("a file");
        files.iter().for_each(|(name, bytes)| put(name, bytes));
        put("scene.json", scene.as_bytes());
        let input = scene.len() + files.iter().map(|f| f.1.len()).sum::<usize>();
        let path: &Path = &self.0.join("scene.json");
        measure(what, input, bounds, || Scene::load(path, &LoadOptions::default()).map_err(|e| e.to_string()))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const BALL: &str = r#"{"type": "dynamic", "shapes": [{"sphere": {"radius": 1}}]}"#;

fn bodies(list: &str) -> String {
    format!(r#"{{"jounce": 1, "bodies": [{list}]}}"#)
}

fn fixed(shape: &str) -> String {
    bodies(&format!(r#"{{"type": "fixed", "shapes": [{shape}]}}"#))
}

/// Scenes that are large in few bytes, or in many.
fn texts() -> Vec<(&'static str, String)> {
    let many = |piece: &str, n: usize| vec![piece; n].join(",");
    let ball = BALL.strip_suffix('}').expect("an object");
    let scatter = format!(
        r#"{{"jounce": 1, "scatter": [{{"count": 131072, "seed": 1, "box": {{"min": [-1e4, 0, -1e4], "max": [1e4, 9, 1e4]}},
        "min_distance": 0.1, "bodies": [{BALL}]}}]}}"#
    );
    let spawns = format!(
        r#"{{"jounce": 1, "timeline": [{{"at": 0, "every": 0.01, "times": 524288, "spawn": {{"bodies": [{BALL}]}}}}]}}"#
    );
    let noise = r#"{"height_field": {"columns": 2048, "rows": 2048, "function": "noise"}}"#;
    vec![
        ("deep", "[".repeat(1 << 20)),
        ("deep keys", "{\"a\":".repeat(1 << 20)),
        ("blanks", " ".repeat(16 << 20)),
        ("one long string", format!(r#"{{"jounce": 1, "name": "{}"}}"#, "x".repeat(8 << 20))),
        ("empty bodies", bodies(&many("{}", 1 << 17))),
        ("bodies without shapes", bodies(&many(r#"{"type":"fixed"}"#, 1 << 16))),
        ("balls", bodies(&many(BALL, 40_000))),
        ("shapes", fixed(&many(r#"{"sphere":{"radius":1}}"#, 60_000))),
        ("copies", bodies(&format!(r#"{ball}, "repeat": {{"count": 524288, "step": [3, 0, 0]}}}}"#))),
        ("scatter", scatter),
        ("spawns", spawns),
        ("zeros", format!(r#"{{"jounce": 1, "bodies": [{}]}}"#, many("0", 4 << 20))),
        ("points", fixed(&format!(r#"{{"hull": {{"points": [{}]}}}}"#, many("[0,0,0]", 1 << 19)))),
        (
            "heights",
            fixed(&format!(
                r#"{{"height_field": {{"columns": 1024, "rows": 1024, "heights": [{}]}}}}"#,
                many("0", 1 << 20)
            )),
        ),
        ("height function", fixed(noise)),
        ("height functions", fixed(&many(noise, 4))),
        (
            "probes",
            format!(
                r#"{{"jounce": 1, "bodies": [{}], "probes": {{{}}}}}"#,
                BALL.replacen('{', "{\"name\": \"a\", ", 1),
                (0..40_000)
                    .map(|i| format!(r#""p{i}":{{"body":"a","value":"speed"}}"#))
                    .collect::<Vec<_>>()
                    .join(",")
            ),
        ),
    ]
}

/// A closed grid of `n` × `n` cells on a sphere's surface, as OBJ.
fn globe(n: usize) -> String {
    let mut out = String::new();
    for j in 0..=n {
        let polar = core::f64::consts::PI * j as f64 / n as f64;
        let (s, c) = (f64s::sin(polar), f64s::cos(polar));
        for i in 0..n {
            let turn = core::f64::consts::TAU * i as f64 / n as f64;
            let (u, v) = (f64s::sin(turn), f64s::cos(turn));
            out += &format!("v {:.4} {:.4} {:.4}\n", s * u, c, s * v);
        }
    }
    for j in 0..n {
        for i in 0..n {
            let (a, b) = (j * n + i + 1, j * n + (i + 1) % n + 1);
            out += &format!("f {a} {} {} {b}\n", a + n, b + n);
        }
    }
    out
}

fn binary_stl(n: u32) -> Vec<u8> {
    let mut out = vec![0u8; 80];
    out.extend(n.to_le_bytes());
    for i in 0..n {
        out.extend([0u8; 12]);
        for k in 0..9u32 {
            out.extend(((i.wrapping_mul(2_654_435_761).rotate_left(k) >> 8) as f32).to_le_bytes());
        }
        out.extend([0u8; 2]);
    }
    out
}

/// One primitive drawn by `n` nodes.
fn instances(n: usize) -> String {
    let nodes = vec![r#"{"mesh":0}"#; n].join(",");
    let list = (0..n).map(|i| i.to_string()).collect::<Vec<_>>().join(",");
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{list}]}}],"nodes":[{nodes}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"mode":5}}]}}],
"accessors":[{{"bufferView":0,"componentType":5121,"count":4,"type":"VEC3"}},{{"bufferView":1,"componentType":5121,"count":4,"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteLength":15,"byteStride":4}},{{"buffer":0,"byteOffset":16,"byteLength":4}}],
"buffers":[{{"uri":"data:;base64,AAAAAP8AAAAA/wAA/wAAAAABAgM=","byteLength":20}}]}}"#
    )
}

fn meshes() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    let fans = format!("{corners}{}", format!("f{}\n", " 1 2 3 4".repeat(250)).repeat(1000));
    let groups = (0..4000).map(|i| format!("usemtl {i}\nf 1 2 3\n")).collect::<String>();
    vec![
        ("triangles", "a.obj", format!("{corners}{}", "f 1 2 3\n".repeat(1 << 18)).into_bytes()),
        ("polygons of 1,000 corners", "b.obj", fans.into_bytes()),
        ("vertices alone", "c.obj", "v 0 0 0\n".repeat(1 << 18).into_bytes()),
        ("materials", "d.obj", format!("{corners}{groups}").into_bytes()),
        ("globe", "e.obj", globe(300).into_bytes()),
        ("loose triangles", "f.stl", binary_stl(100_000)),
        ("declared, not there", "g.stl", binary_stl(2)[..90].to_vec()),
        ("instances", "h.gltf", instances(60_000).into_bytes()),
        (
            "text",
            "i.stl",
            "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
                .repeat(20_000)
                .into_bytes(),
        ),
    ]
}

/// One test, so that nothing else allocates meanwhile.
#[test]
fn hostile_files_stay_within_their_memory_and_time() {
    let folder = Folder::new();
    let mut wrong = Vec::new();
    for (what, text) in texts() {
        wrong.extend(folder.scene(what, &text, &[], LOADING));
    }
    for (what, name, bytes) in meshes() {
        wrong.extend(measure(what, bytes.len(), LOADING, || {
            MeshData::parse(name, &bytes, &mut |_| unreachable!()).map_err(|e| e.to_string())
        }));
        for kind in ["mesh", "hull", "decompose"] {
            let scene = format!(
                r#"{{"jounce": 1, "meshes": {{"m": {{"file": "{name}"}}}},
                "bodies": [{{"type": "fixed", "shapes": [{{"{kind}": {{"mesh": "m"}}}}]}}]}}"#
            );
            wrong.extend(folder.scene(&format!("{what}, as {kind}"), &scene, &[(name, &bytes)], LOADING));
        }
    }
    // The finest takes ten seconds and more.
    let cells = if std::env::var_os("JOUNCE_PROVE").is_some() { 40 } else { 8 };
    let cut = r#"{"jounce": 1, "meshes": {"m": {"file": "e.obj"}}, "bodies": [{"type": "dynamic", "shapes":
        [{"decompose": {"mesh": "m", "resolution": 128, "concavity": 0, "parts_max": 256}}]}]}"#;
    wrong.extend(folder.scene("cut finely", cut, &[("e.obj", globe(cells).as_bytes())], CUTTING));
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
