use super::*;

fn no_files(uri: &str) -> Result<Vec<u8>, SceneError> {
    Err(SceneError::File { file: uri.into(), message: "there is no such file".into() })
}

fn parse(name: &str, bytes: &[u8]) -> Result<MeshData, SceneError> {
    MeshData::parse(name, bytes, &mut no_files)
}

fn refused(name: &str, bytes: &[u8]) -> String {
    parse(name, bytes).expect_err("refused").to_string()
}

/// Signed volume by the divergence theorem: right only if every face is covered once, facing out.
fn volume(m: &MeshData) -> f64 {
    let v = |i: u32| m.vertices[i as usize].as_dvec3();
    m.triangles.iter().map(|t| v(t[0]).cross(v(t[1])).dot(v(t[2])) / 6.0).sum()
}

/// A prism with a side in the shape of an L, as two hexagons and six quadrilaterals.
const PRISM: &str = "# an L\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n\
v 0 0 1\nv 2 0 1\nv 2 1 1\nv 1 1 1\nv 1 2 1\nv 0 2 1\n\
f 6 5 4 3 2 1\nusemtl top\nf 7/1/1 8/2/1 9//1 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\n\
f 5 6 12 11\nf -7 -12 -6 -1\n";

#[test]
fn concave_faces_and_negative_indices() {
    let m = parse("l.obj", PRISM.as_bytes()).expect("reads");
    assert_eq!((m.vertices.len(), m.triangles.len()), (12, 4 + 4 + 6 * 2));
    assert!((volume(&m) - 3.0).abs() < 1e-12, "{}", volume(&m));
    assert_eq!(m.groups, ["", "top"]);
    assert_eq!(m.triangle_groups[3..5], [0, 1]);
}

#[test]
fn obj_lines_continue_and_mistakes_have_a_place() {
    let m = parse("a.obj", b"v 0 0 0\r\nv 1 0 0\r\nv 0 \\\r\n 1 0\r\nf 1 2 \\\n3").expect("reads");
    assert_eq!(m.triangles, [[0, 1, 2]]);
    assert_eq!(m.vertices[2], Vec3::Y);
    let message = refused("a.obj", b"v 0 0 0\nv 1 0 x\n");
    assert!(message.starts_with("a.obj:2:7: found `x`; expected a finite number"), "{message}");
    let message = refused("a.obj", b"v 0 0 0\nv 1 0 0\nf 1 2 3\n");
    assert!(message.starts_with("a.obj:3:7: the face names vertex 3, of 2 so far"), "{message}");
    for bad in ["f 1 1", "f 0 1 1", "f 1 1 -2", "f 1 1 a", "v 1 2", "v 1 2 nan", "v 1 2 1e99"] {
        let message = refused("a.obj", format!("v 0 0 0\n{bad}\n").as_bytes());
        assert!(message.starts_with("a.obj:2:"), "{message}");
    }
    assert!(refused("a.obj", b"v 0 0 0").contains("no triangles"));
    assert!(refused("a.dae", b"").contains("the format is unknown"));
}

#[test]
fn polygons_of_many_corners_keep_their_area() {
    // A comb: every second corner is deep, so a fan would be wrong.
    let n = 200;
    let mut text = String::new();
    let mut area = 0.0;
    for i in 0..n {
        let y = if i % 2 == 0 { 1.0 } else { 0.1 };
        text += &format!("v {i} {y} 0\n");
        area += if i + 1 < n { 0.55 } else { 0.0 };
    }
    text += &format!("v {} 0 0\nv 0 0 0\nf", n - 1);
    (0..n + 2).for_each(|i| text += &format!(" {}", n + 2 - i));
    let m = parse("comb.obj", text.as_bytes()).expect("reads");
    assert_eq!(m.triangles.len(), n);
    let v = |i: u32| m.vertices[i as usize];
    let (mut signed, mut total) = (0.0, 0.0);
    for t in &m.triangles {
        let a = 0.5 * (v(t[1]) - v(t[0])).cross(v(t[2]) - v(t[0])).z;
        signed += f64::from(a);
        total += f64::from(a.abs());
    }
    assert!((signed - area).abs() < 1e-3 && (total - area).abs() < 1e-3, "{signed} {total} {area}");
}

fn binary_stl(triangles: &[[Vec3; 3]], declared: u32) -> Vec<u8> {
    let mut b = b"solid but binary".to_vec();
    b.resize(80, 0);
    b.extend(declared.to_le_bytes());
    for t in triangles {
        b.extend([0; 12]);
        t.iter().flat_map(|p| p.to_array()).for_each(|x| b.extend(x.to_le_bytes()));
        b.extend([0; 2]);
    }
    b
}

#[test]
fn stl_in_both_forms() {
    let t = [[Vec3::ZERO, Vec3::X, Vec3::Y], [Vec3::ZERO, Vec3::Y, Vec3::Z]];
    let m = parse("a.stl", &binary_stl(&t, 2)).expect("reads");
    assert_eq!((m.vertices.len(), m.triangles[1]), (6, [3, 4, 5]));
    let text = "solid a\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n endloop\nendfacet\nendsolid a\n";
    let m = parse("a.STL", text.as_bytes()).expect("reads");
    assert_eq!(m.vertices, t[0]);
    let message = refused("a.stl", &binary_stl(&t, 4_000_000_000));
    assert!(message.contains("declares 4000000000 triangles, the file has 2"), "{message}");
    assert!(refused("a.stl", &text.as_bytes()[..69]).contains("ends inside a solid"));
    assert!(
        refused("a.stl", &text.replace("1 0 0", "1 inf 0").into_bytes())
            .starts_with("a.stl:5:1: found `inf`")
    );
    assert!(refused("a.stl", b"").contains("byte 0"));
}

/// A GLB of one unit square as two indexed triangles, under a node that is turned, scaled by −2 in x and shifted.
fn glb() -> Vec<u8> {
    let mut bin = Vec::new();
    let square = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    square.iter().flatten().for_each(|x| bin.extend(x.to_le_bytes()));
    [0u16, 1, 2, 0, 2, 3].iter().for_each(|i| bin.extend(i.to_le_bytes()));
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[1]}}],
"nodes":[{{"mesh":0,"scale":[-2,1,1]}},{{"children":[0],"translation":[0,0,5],"rotation":[0,0,0.7071067811865476,0.7071067811865476]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":7}},"indices":1,"material":0}}]}}],
"materials":[{{"name":"paint","extras":{{"a":[1]}}}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},{{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":12}}],
"buffers":[{{"byteLength":{}}}]}}"#,
        bin.len()
    );
    container(json.as_bytes(), &bin)
}

fn container(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut b = b"glTF".to_vec();
    let total = 12 + 8 + json.len() + 8 + bin.len();
    let words = [2, total as u32, json.len() as u32, 0x4E4F_534A];
    words.iter().for_each(|w| b.extend(w.to_le_bytes()));
    b.extend(&json);
    [bin.len() as u32, 0x004E_4942].iter().for_each(|w| b.extend(w.to_le_bytes()));
    b.extend(bin);
    b
}

#[test]
fn glb_with_nodes() {
    let m = parse("a.glb", &glb()).expect("reads");
    // x → −2x, then a quarter turn about z, then +5 in z.
    let want = [[0.0, 0.0, 5.0], [0.0, -2.0, 5.0], [-1.0, -2.0, 5.0], [-1.0, 0.0, 5.0]].map(Vec3::from_array);
    for (v, w) in m.vertices.iter().zip(want) {
        assert!((*v - w).length() < 1e-6, "{v:?} {w:?}");
    }
    let t = m.triangles[0].map(|i| m.vertices[i as usize]);
    assert!((t[1] - t[0]).cross(t[2] - t[0]).z > 0.0, "a mirror turns the corners round");
    assert_eq!(m.groups[usize::from(m.triangle_groups[0])], "paint");
}

#[test]
fn every_truncation_of_a_glb_is_refused() {
    let whole = glb();
    for n in 0..whole.len() {
        let message = refused("a.glb", &whole[..n]);
        assert!(message.starts_with("a.glb: ") || message.starts_with("a.glb:1:"), "{n}: {message}");
    }
    assert!(refused("a.glb", &whole[..whole.len() - 4]).contains("byte 8: truncated: the header declares"));
}

#[test]
fn gltf_finds_its_buffers() {
    let json = |uri: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":5}}]}}],
"accessors":[{{"bufferView":0,"componentType":5121,"normalized":true,"count":4,"type":"VEC3"}}],
"bufferViews":[{{"buffer":0,"byteLength":15,"byteStride":4}}],"buffers":[{{"uri":"{uri}","byteLength":15}}]}}"#
        )
    };
    let m = parse("a.gltf", json("data:application/octet-stream;base64,AAAAAP8AAAAA/wAA/wAAAAAA").as_bytes())
        .expect("reads");
    assert_eq!(m.vertices, [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X]);
    assert_eq!(m.triangles, [[0, 1, 2], [2, 1, 3]]);
    let mut beside = |uri: &str| {
        assert_eq!(uri, "my mesh.bin");
        Ok(vec![0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0, 255, 0, 0])
    };
    let other = MeshData::parse("a.gltf", json("my%20mesh.bin").as_bytes(), &mut beside).expect("reads");
    assert_eq!(other, m);
    assert!(refused("a.gltf", json("gone.bin").as_bytes()).starts_with("gone.bin: there is no such file"));
    assert!(refused("a.gltf", json("/etc/passwd").as_bytes()).contains("names `/etc/passwd`"));
    for outside in ["../secret.bin", "a/../../secret.bin", "%2e%2e/secret.bin"] {
        assert!(
            refused("a.gltf", json(outside).as_bytes()).contains("expected a file beside the glTF"),
            "{outside}"
        );
    }
    assert!(
        refused("a.gltf", json("data:;base64,AAAA").as_bytes()).contains("declares 15 bytes, 3 are there")
    );
    let huge = json("data:;base64,AAAA").replace("\"count\":4", "\"count\":4000000000");
    assert!(refused("a.gltf", huge.as_bytes()).contains("accessors[0]: 4000000000 records"));
    let cycle = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"children":[0]}]}"#;
    assert!(refused("a.gltf", cycle.as_bytes()).contains("nodes[0]: is reached twice"));
}

#[test]
fn shared_data_cannot_fill_memory() {
    let node = r#"{"mesh":0}"#;
    let nodes = vec![node; 60_000].join(",");
    let tops: Vec<String> = (0..60_000).map(|i| i.to_string()).collect();
    let body = "A".repeat(4 * 12 * 1000);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[{}]}}],"nodes":[{nodes}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3000,"type":"VEC3"}}],"bufferViews":[{{"buffer":0,"byteLength":36000}}],
"buffers":[{{"uri":"data:;base64,{body}","byteLength":36000}}]}}"#,
        tops.join(",")
    );
    assert!(refused("a.gltf", json.as_bytes()).contains("expands to"));
}

#[test]
fn shared_meshes_are_read() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets/box3d");
    if !assets.is_dir() {
        eprintln!("skipped: no ../shared/assets");
        return;
    }
    for (file, faces, closed) in
        [("test_map01.obj", 90, true), ("stairs.obj", 14, true), ("voxel_mesh_01.obj", 0, false)]
    {
        let m = MeshData::load(&assets.join(file)).expect("reads");
        assert!(m.triangles.len() > faces, "{file}: {}", m.triangles.len());
        if closed {
            assert!(volume(&m) > 0.0, "{file}: {}", volume(&m));
        }
    }
    let stairs = MeshData::load(&assets.join("stairs.obj")).expect("reads");
    // Six steps of equal tread on a block: the area under the profile times the depth of 2.
    let profile = [
        (-1.423823, 0.412575),
        (-0.889889, 0.787575),
        (-0.355956, 1.162575),
        (0.177978, 1.537575),
        (0.711911, 1.912575),
        (1.423823, 1.912575),
    ];
    let area: f64 = profile.windows(2).map(|w| (w[1].0 - w[0].0) * (w[0].1 + 0.087425)).sum();
    assert!((volume(&stairs) - 2.0 * area).abs() < 1e-4, "{} {}", volume(&stairs), 2.0 * area);
}
