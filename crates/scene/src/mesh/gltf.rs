//! glTF 2.0 and GLB: the triangles of the default scene with their nodes' transforms, and material names. Textures,
//! skins, morphs and animations are skipped; compressed geometry is refused by name.

use super::{MeshData, MeshFile};
use crate::error::SceneError;
use crate::json::{Budget, Position, scan_within};
use crate::limits;
use jounce::math::Vec3;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Root {
    asset: Asset,
    scene: Option<usize>,
    #[serde(default)]
    scenes: Vec<Scene>,
    #[serde(default)]
    nodes: Vec<Node>,
    #[serde(default)]
    meshes: Vec<Mesh>,
    #[serde(default)]
    materials: Vec<Material>,
    #[serde(default)]
    accessors: Vec<Accessor>,
    #[serde(default)]
    buffer_views: Vec<View>,
    #[serde(default)]
    buffers: Vec<Buffer>,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
struct Asset {
    version: String,
}

#[derive(Deserialize)]
struct Scene {
    #[serde(default)]
    nodes: Vec<usize>,
}

#[derive(Deserialize)]
struct Node {
    #[serde(default)]
    children: Vec<usize>,
    mesh: Option<usize>,
    matrix: Option<Box<[f64; 16]>>,
    translation: Option<Box<[f64; 3]>>,
    rotation: Option<Box<[f64; 4]>>,
    scale: Option<Box<[f64; 3]>>,
}

#[derive(Deserialize)]
struct Mesh {
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: Attributes,
    indices: Option<usize>,
    material: Option<usize>,
    mode: Option<u32>,
}

#[derive(Deserialize)]
struct Attributes {
    #[serde(rename = "POSITION")]
    position: Option<usize>,
}

#[derive(Deserialize)]
struct Material {
    name: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    count: usize,
    #[serde(rename = "type")]
    kind: String,
    #[serde(default)]
    normalized: bool,
    sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct View {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Buffer {
    uri: Option<String>,
    byte_length: usize,
}

type Beside<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>, SceneError>;

pub(super) fn parse(file: MeshFile, bytes: &[u8], beside: Beside) -> Result<MeshData, SceneError> {
    let (json, binary) = if bytes.starts_with(b"glTF") { chunks(file, bytes)? } else { (bytes, None) };
    let text = std::str::from_utf8(json)
        .map_err(|e| file.at_byte(e.valid_up_to(), "the JSON part is not UTF-8", "UTF-8 text"))?;
    let budget = Budget { objects: 1 << 19, string: limits::MESH_BYTES_MAX as usize };
    scan_within(text, budget).map_err(|r| {
        let p = Position::of(text, r.offset);
        file.fault(r.path.to_string(), Some(p), r.message.clone(), r.expected.clone())
    })?;
    let root: Root = serde_path_to_error::deserialize(&mut serde_json::Deserializer::from_str(text))
        .map_err(|e| {
            let p = Position { line: e.inner().line(), column: e.inner().column() };
            file.fault(e.path().to_string(), Some(p), e.inner().to_string(), "glTF 2.0".into())
        })?;
    if !root.asset.version.starts_with("2.") {
        return Err(file.wrong("asset.version", format!("version {}", root.asset.version), "2.0"));
    }
    let known = ["KHR_mesh_quantization", "KHR_texture_transform", "KHR_materials_unlit"];
    if let Some(e) = root
        .extensions_required
        .iter()
        .find(|e| !known.contains(&e.as_str()) && !e.starts_with("KHR_materials_"))
    {
        return Err(file.wrong("extensionsRequired", format!("{e} is not read"), "plain glTF 2.0 geometry"));
    }
    let mut reader = Reader {
        file,
        root: &root,
        binary,
        beside,
        loaded: Vec::new(),
        input: bytes.len(),
        mesh: MeshData::new(),
    };
    reader.loaded.resize_with(root.buffers.len(), || None);
    reader.scene()?;
    Ok(reader.mesh)
}

/// The JSON and the binary chunk of a GLB.
fn chunks<'a>(file: MeshFile, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), SceneError> {
    let word = |at: usize| {
        bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize).ok_or_else(
            || {
                file.at_byte(
                    bytes.len(),
                    format!("the file ends after {} bytes", bytes.len()),
                    format!("a number at byte {at}"),
                )
            },
        )
    };
    if word(4)? != 2 {
        return Err(file.at_byte(4, format!("GLB version {}", word(4)?), "2"));
    }
    let length = word(8)?;
    if length > bytes.len() {
        let message = format!("truncated: the header declares {length} bytes, the file has {}", bytes.len());
        return Err(file.at_byte(8, message, "a complete file"));
    }
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at < length {
        let (size, kind) = (word(at)?, word(at + 4)?);
        let body =
            bytes.get(at + 8..).and_then(|b| b.get(..size)).filter(|_| at + 8 + size <= length).ok_or_else(
                || {
                    let message = format!(
                        "truncated: a chunk declares {size} bytes, {} are left",
                        length.saturating_sub(at + 8)
                    );
                    file.at_byte(at, message, "a complete file")
                },
            )?;
        match kind {
            0x4E4F_534A if json.is_none() => json = Some(body),
            0x004E_4942 if binary.is_none() => binary = Some(body),
            _ => {}
        }
        at += 8 + size.next_multiple_of(4);
    }
    let json = json.ok_or_else(|| file.at_byte(12, "there is no JSON chunk", "a JSON chunk first"))?;
    Ok((json, binary))
}

/// Affine map: columns of the linear part, then the translation.
type Affine = [[f64; 3]; 4];
const IDENTITY: Affine = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

fn apply(a: &Affine, p: [f64; 3], w: f64) -> [f64; 3] {
    core::array::from_fn(|k| a[0][k] * p[0] + a[1][k] * p[1] + a[2][k] * p[2] + a[3][k] * w)
}

fn compose(a: &Affine, b: &Affine) -> Affine {
    [apply(a, b[0], 0.0), apply(a, b[1], 0.0), apply(a, b[2], 0.0), apply(a, b[3], 1.0)]
}

fn local(node: &Node) -> Affine {
    if let Some(m) = &node.matrix {
        return core::array::from_fn(|c| core::array::from_fn(|r| m[4 * c + r]));
    }
    let [x, y, z, w] = node.rotation.as_deref().copied().unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let s = node.scale.as_deref().copied().unwrap_or([1.0; 3]);
    let q = jounce::math::DQuat::new(x, y, z, w).normalize().to_mat3();
    let t = node.translation.as_deref().copied().unwrap_or([0.0; 3]);
    [(q.cx * s[0]).to_array(), (q.cy * s[1]).to_array(), (q.cz * s[2]).to_array(), t]
}

struct Reader<'a> {
    file: MeshFile<'a>,
    root: &'a Root,
    binary: Option<&'a [u8]>,
    beside: Beside<'a>,
    loaded: Vec<Option<Vec<u8>>>,
    /// Bytes read so far, which bound what may come out.
    input: usize,
    mesh: MeshData,
}

impl Reader<'_> {
    fn scene(&mut self) -> Result<(), SceneError> {
        let root = self.root;
        if root.nodes.len() > limits::GLTF_NODES_MAX {
            let limit = format!("at most {}", limits::GLTF_NODES_MAX);
            return Err(self.file.wrong("nodes", format!("{} nodes", root.nodes.len()), limit));
        }
        let tops: Vec<usize> = match root.scenes.get(root.scene.unwrap_or(0)) {
            Some(s) => s.nodes.clone(),
            None if root.scene.is_some() => {
                let n = root.scenes.len();
                return Err(self.file.wrong(
                    "scene",
                    "names a scene that is not there",
                    format!("less than {n}"),
                ));
            }
            None => {
                let mut child = vec![false; root.nodes.len()];
                let mark = |c: &usize| child.get_mut(*c).map(|f| *f = true);
                let _: Vec<_> = root.nodes.iter().flat_map(|n| &n.children).map(mark).collect();
                (0..root.nodes.len()).filter(|&n| !child[n]).collect()
            }
        };
        if root.nodes.is_empty() {
            return (0..root.meshes.len()).try_for_each(|m| self.mesh(m, &IDENTITY));
        }
        let mut seen = vec![false; root.nodes.len()];
        let mut stack: Vec<(usize, Affine)> = tops.iter().rev().map(|&n| (n, IDENTITY)).collect();
        while let Some((n, parent)) = stack.pop() {
            let key = || format!("nodes[{n}]");
            let Some(node) = root.nodes.get(n) else {
                return Err(self.file.wrong(
                    key(),
                    "is not there",
                    format!("less than {}", root.nodes.len()),
                ));
            };
            if std::mem::replace(&mut seen[n], true) {
                return Err(self.file.wrong(key(), "is reached twice", "a tree of nodes"));
            }
            let frame = compose(&parent, &local(node));
            if let Some(m) = node.mesh {
                self.mesh(m, &frame)?;
            }
            if stack.len() + node.children.len() > limits::GLTF_NODES_MAX {
                return Err(self.file.wrong(key(), "too many children", "a tree of nodes"));
            }
            stack.extend(node.children.iter().rev().map(|&c| (c, frame)));
        }
        Ok(())
    }

    fn mesh(&mut self, m: usize, frame: &Affine) -> Result<(), SceneError> {
        let root = self.root;
        let Some(mesh) = root.meshes.get(m) else {
            return Err(self.file.wrong(
                format!("meshes[{m}]"),
                "is not there",
                format!("less than {}", root.meshes.len()),
            ));
        };
        for (k, p) in mesh.primitives.iter().enumerate() {
            self.primitive(p, frame, &format!("meshes[{m}].primitives[{k}]"))?;
        }
        Ok(())
    }

    fn primitive(&mut self, p: &Primitive, frame: &Affine, key: &str) -> Result<(), SceneError> {
        let mode = p.mode.unwrap_or(4);
        let (4..=6, Some(position)) = (mode, p.attributes.position) else { return Ok(()) };
        let vertices = self.accessor(position, "VEC3")?;
        let indices = p.indices.map(|i| self.accessor(i, "SCALAR")).transpose()?;
        let corners = indices.as_ref().map_or(vertices.count, |i| i.count);
        self.budget(vertices.count, if mode == 4 { corners / 3 } else { corners }, key)?;
        let first = self.mesh.vertices.len() as u32;
        let base = self.bytes(vertices.buffer)?;
        let mut placed = Vec::with_capacity(vertices.count);
        for n in 0..vertices.count {
            let at = apply(frame, core::array::from_fn(|k| vertices.number(base, n, k)), 1.0);
            let v = Vec3::new(at[0] as f32, at[1] as f32, at[2] as f32);
            if !v.is_finite() {
                return Err(self.file.wrong(key, format!("vertex {n} is not finite"), "finite coordinates"));
            }
            placed.push(v);
        }
        let mut list = Vec::with_capacity(corners);
        match &indices {
            None => list.extend(0..corners as u32),
            Some(i) => {
                let base = self.bytes(i.buffer)?;
                for n in 0..corners {
                    let v = i.number(base, n, 0);
                    if v < 0.0 || v >= vertices.count as f64 {
                        let message = format!("index {n} names vertex {v}");
                        return Err(self.file.wrong(key, message, format!("less than {}", vertices.count)));
                    }
                    list.push(v as u32);
                }
            }
        }
        self.mesh.vertices.append(&mut placed);
        let group = match p.material.and_then(|m| self.root.materials.get(m)).and_then(|m| m.name.as_deref())
        {
            Some(name) => self.mesh.group(self.file, name)?,
            None => 0,
        };
        self.triangles(mode, &list, first, mirrored(frame), group)
    }

    fn triangles(
        &mut self,
        mode: u32,
        list: &[u32],
        first: u32,
        mirrored: bool,
        group: u16,
    ) -> Result<(), SceneError> {
        let n = if mode == 4 { list.len() / 3 } else { list.len().saturating_sub(2) };
        for t in 0..n {
            let mut c = match mode {
                4 => [list[3 * t], list[3 * t + 1], list[3 * t + 2]],
                5 if t % 2 == 1 => [list[t + 1], list[t], list[t + 2]],
                5 => [list[t], list[t + 1], list[t + 2]],
                _ => [list[0], list[t + 1], list[t + 2]],
            };
            if mirrored {
                c.swap(1, 2);
            }
            self.mesh.push(self.file, c.map(|v| first + v), group)?;
        }
        Ok(())
    }

    /// Instances may share data, so what comes out is bounded by what went in.
    fn budget(&self, vertices: usize, triangles: usize, key: &str) -> Result<(), SceneError> {
        let v = self.mesh.vertices.len().saturating_add(vertices);
        let t = self.mesh.triangles.len().saturating_add(triangles);
        let limit = limits::MESH_EXPANSION_BYTES + 8 * self.input;
        let triangles_max = super::triangles_max(self.input);
        if t > triangles_max {
            let message = format!("expands to {t} triangles");
            return Err(self.file.wrong(key, message, format!("at most {triangles_max} for this file")));
        }
        if v.saturating_add(t).saturating_mul(12) > limit {
            let message = format!("expands to {v} vertices and {t} triangles");
            return Err(self.file.wrong(
                key,
                message,
                format!("at most {} in all for this file", limit / 12),
            ));
        }
        Ok(())
    }

    fn accessor(&mut self, a: usize, kind: &str) -> Result<Column, SceneError> {
        let (file, root) = (self.file, self.root);
        let key = format!("accessors[{a}]");
        let wrong = |message: String, expected: String| file.wrong(key.clone(), message, expected);
        let Some(acc) = root.accessors.get(a) else {
            return Err(wrong("is not there".into(), format!("less than {}", root.accessors.len())));
        };
        if acc.kind != kind {
            return Err(wrong(format!("has type {}", acc.kind), kind.into()));
        }
        if acc.sparse.is_some() {
            return Err(wrong("is sparse, which is not read".into(), "a dense accessor".into()));
        }
        let size = match acc.component_type {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            5125 | 5126 => 4,
            t => return Err(wrong(format!("component type {t}"), "5120 to 5123, 5125 or 5126".into())),
        };
        let record = size * if kind == "VEC3" { 3 } else { 1 };
        let Some(view) = acc.buffer_view.and_then(|v| root.buffer_views.get(v)) else {
            return Err(wrong("has no buffer view".into(), "a buffer view that is there".into()));
        };
        let stride = view.byte_stride.unwrap_or(record);
        if stride < record {
            return Err(wrong(format!("byte stride {stride}"), format!("at least {record}")));
        }
        let end = |offset: usize, count: usize| match count {
            0 => Some(offset),
            n => (n - 1).checked_mul(stride)?.checked_add(record)?.checked_add(offset),
        };
        if end(acc.byte_offset, acc.count).is_none_or(|e| e > view.byte_length) {
            let message = format!("{} records of {stride} bytes do not fit the buffer view", acc.count);
            return Err(wrong(message, format!("at most {} bytes", view.byte_length)));
        }
        let length = self.load(view.buffer)?;
        if view.byte_offset.checked_add(view.byte_length).is_none_or(|e| e > length) {
            let message = format!(
                "its buffer view ends after byte {}",
                view.byte_offset.saturating_add(view.byte_length)
            );
            return Err(wrong(message, format!("within buffer {} of {length} bytes", view.buffer)));
        }
        let offset = view.byte_offset + acc.byte_offset;
        let (component, normalized) = (acc.component_type, acc.normalized);
        Ok(Column { buffer: view.buffer, offset, stride, size, component, normalized, count: acc.count })
    }

    /// Makes a buffer's bytes present; gives their number.
    fn load(&mut self, b: usize) -> Result<usize, SceneError> {
        let key = format!("buffers[{b}]");
        let Some(buffer) = self.root.buffers.get(b) else {
            return Err(self.file.wrong(
                key,
                "is not there",
                format!("less than {}", self.root.buffers.len()),
            ));
        };
        if self.loaded.get(b).is_some_and(Option::is_none)
            && let Some(uri) = &buffer.uri
        {
            let bytes = match uri.strip_prefix("data:") {
                Some(data) => data_uri(data).ok_or_else(|| {
                    self.file.wrong(
                        format!("{key}.uri"),
                        "a data URI that cannot be decoded",
                        "data:…;base64,…",
                    )
                })?,
                None => {
                    let path = relative(uri).ok_or_else(|| {
                        self.file.wrong(
                            format!("{key}.uri"),
                            format!("names `{uri}`"),
                            "a file beside the glTF",
                        )
                    })?;
                    let bytes = (self.beside)(&path)?;
                    self.input += bytes.len();
                    self.file.triangles_max = super::triangles_max(self.input);
                    bytes
                }
            };
            self.loaded[b] = Some(bytes);
        }
        let there = self.bytes(b)?.len();
        if buffer.byte_length > there {
            let message = format!("declares {} bytes, {there} are there", buffer.byte_length);
            return Err(self.file.wrong(key, message, "a complete buffer"));
        }
        Ok(buffer.byte_length)
    }

    fn bytes(&self, b: usize) -> Result<&[u8], SceneError> {
        match self.loaded.get(b) {
            Some(Some(bytes)) => Ok(bytes),
            _ => match self.binary {
                Some(bytes) if b == 0 => Ok(bytes),
                _ => Err(self.file.wrong(format!("buffers[{b}]"), "has no uri and no binary chunk", "a uri")),
            },
        }
    }
}

fn mirrored(a: &Affine) -> bool {
    let v = |k: usize| jounce::math::DVec3::from_array(a[k]);
    v(0).cross(v(1)).dot(v(2)) < 0.0
}

/// A checked accessor: every record lies inside its buffer.
struct Column {
    buffer: usize,
    offset: usize,
    stride: usize,
    size: usize,
    component: u32,
    normalized: bool,
    count: usize,
}

impl Column {
    fn number(&self, bytes: &[u8], record: usize, component: usize) -> f64 {
        let at = self.offset + record * self.stride + component * self.size;
        let b = &bytes[at..at + self.size];
        let (value, full) = match self.component {
            5120 => (f64::from(b[0] as i8), 127.0),
            5121 => (f64::from(b[0]), 255.0),
            5122 => (f64::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            5123 => (f64::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            5125 => (f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])), 4_294_967_295.0),
            _ => return f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        };
        if self.normalized { (value / full).max(-1.0) } else { value }
    }
}

/// A path within the folder of the file, percent-decoded; none for other places.
fn relative(uri: &str) -> Option<String> {
    if uri.contains("://") || uri.contains('\\') || uri.contains('\0') {
        return None;
    }
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&b, tail)) = rest.split_first() {
        rest = tail;
        if b == b'%' {
            let hex = std::str::from_utf8(rest.get(..2)?).ok()?;
            bytes.push(u8::from_str_radix(hex, 16).ok()?);
            rest = &rest[2..];
        } else {
            bytes.push(b);
        }
    }
    let path = String::from_utf8(bytes).ok()?;
    // A mesh of strangers must not read what lies outside its folder.
    if std::path::Path::new(&path).components().any(|c| c == std::path::Component::ParentDir) {
        return None;
    }
    (!path.is_empty() && std::path::Path::new(&path).is_relative() && !path.contains('\0')).then_some(path)
}

fn data_uri(data: &str) -> Option<Vec<u8>> {
    let (head, body) = data.split_once(',')?;
    head.ends_with(";base64").then_some(())?;
    let mut out = Vec::with_capacity(body.len() / 4 * 3 + 3);
    let (mut bits, mut held) = (0u32, 0);
    for &b in body.trim_end_matches('=').as_bytes() {
        let digit = match b {
            b'A'..=b'Z' => b - b'A',
            b'a'..=b'z' => b - b'a' + 26,
            b'0'..=b'9' => b - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = (bits << 6) | u32::from(digit);
        held += 6;
        if held >= 8 {
            held -= 8;
            out.push((bits >> held) as u8);
            bits &= (1 << held) - 1;
        }
    }
    Some(out)
}
