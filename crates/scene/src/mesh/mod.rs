//! Triangle meshes from files: Wavefront OBJ, STL (text and binary), glTF 2 and GLB. Geometry and material
//! names only.
//!
//! Every reader compares declared counts with the bytes that are there before it reserves memory, and every
//! refusal names the file and the place.

mod gltf;
mod obj;
mod stl;
mod triangulate;

use crate::error::{Fault, SceneError};
use crate::json::Position;
use crate::limits;
use jounce::geometry::limits::MESH_TRIANGLES_MAX;
use jounce::math::Vec3;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Vertices and triangles, as they are in the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Corner points.
    pub vertices: Vec<Vec3>,
    /// Vertex numbers, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Material names; the first is "" and means none.
    pub groups: Vec<String>,
    /// Index into `groups` of each triangle.
    pub triangle_groups: Vec<u16>,
}

impl MeshData {
    /// Reads a mesh file; the format follows from the extension.
    ///
    /// # Errors
    /// The file cannot be read or is too large, the format is unknown, or the content is wrong: with the place.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Self::load_counting(path, &mut 0)
    }

    /// As [`MeshData::load`]; adds the bytes read to `input`.
    pub(crate) fn load_counting(path: &Path, input: &mut usize) -> Result<Self, SceneError> {
        let name = path.display().to_string();
        let bytes = read_file(path)?;
        *input += bytes.len();
        let here = path.parent().unwrap_or(Path::new(""));
        Self::parse(&name, &bytes, &mut |uri| {
            let bytes = read_file(&here.join(uri))?;
            *input += bytes.len();
            Ok(bytes)
        })
    }

    /// Reads a mesh from memory. `name` is for messages, and its extension gives the format; `beside` reads the
    /// files that a glTF names.
    ///
    /// # Errors
    /// As [`MeshData::load`].
    pub fn parse(
        name: &str,
        bytes: &[u8],
        beside: &mut dyn FnMut(&str) -> Result<Vec<u8>, SceneError>,
    ) -> Result<Self, SceneError> {
        let extension =
            Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        let triangles_max = triangles_max(bytes.len());
        let file = MeshFile { name, triangles_max };
        let mesh = match extension.as_str() {
            "obj" => obj::parse(file, bytes)?,
            "stl" => stl::parse(file, bytes)?,
            "gltf" | "glb" => gltf::parse(file, bytes, beside)?,
            _ => {
                return Err(file.wrong(
                    "",
                    "the format is unknown",
                    "a file that ends in .obj, .stl, .gltf or .glb",
                ));
            }
        };
        if mesh.triangles.is_empty() {
            return Err(file.wrong("", "there are no triangles", "at least one face"));
        }
        Ok(mesh)
    }

    pub(crate) fn new() -> Self {
        Self { groups: vec![String::new()], ..Self::default() }
    }

    /// Index of a material name, added where it is new.
    fn group(&mut self, file: MeshFile, name: &str) -> Result<u16, SceneError> {
        if let Some(n) = self.groups.iter().position(|g| g == name) {
            return Ok(n as u16);
        }
        if self.groups.len() >= limits::MESH_GROUPS_MAX {
            let limit = format!("at most {}", limits::MESH_GROUPS_MAX);
            return Err(file.wrong("", "too many material names", limit));
        }
        self.groups.push(name.into());
        Ok((self.groups.len() - 1) as u16)
    }

    fn push(&mut self, file: MeshFile, triangle: [u32; 3], group: u16) -> Result<(), SceneError> {
        let limit = MESH_TRIANGLES_MAX.min(file.triangles_max);
        if self.triangles.len() >= limit {
            return Err(file.wrong(
                "",
                "too many triangles",
                format!("at most {limit} in a file of its size"),
            ));
        }
        self.triangles.push(triangle);
        self.triangle_groups.push(group);
        Ok(())
    }
}

/// Triangles that meshes of so many bytes may have.
pub(crate) fn triangles_max(input: usize) -> usize {
    limits::MESH_TRIANGLES_FREE + input / limits::MESH_BYTES_EACH
}

/// Reads a regular file of bounded size.
fn read_file(path: &Path) -> Result<Vec<u8>, SceneError> {
    let wrong = |message: String| SceneError::File { file: path.display().to_string(), message };
    let why = |e: std::io::Error| match e.kind() {
        std::io::ErrorKind::NotFound => wrong("there is no such file".into()),
        _ => wrong(format!("cannot be read: {e}")),
    };
    let meta = std::fs::metadata(path).map_err(why)?;
    if !meta.is_file() {
        return Err(wrong("is not a file".into()));
    }
    let too_large =
        |n: u64| wrong(format!("has {n} bytes; expected at most {} (256 MiB)", limits::MESH_BYTES_MAX));
    if meta.len() > limits::MESH_BYTES_MAX {
        return Err(too_large(meta.len()));
    }
    let mut bytes = Vec::with_capacity(meta.len() as usize);
    let file = File::open(path).map_err(why)?;
    file.take(limits::MESH_BYTES_MAX + 1).read_to_end(&mut bytes).map_err(why)?;
    if bytes.len() as u64 > limits::MESH_BYTES_MAX {
        return Err(too_large(bytes.len() as u64));
    }
    Ok(bytes)
}

/// The file being read, for messages.
#[derive(Clone, Copy)]
struct MeshFile<'a> {
    name: &'a str,
    triangles_max: usize,
}

impl MeshFile<'_> {
    fn fault(
        &self,
        key: String,
        position: Option<Position>,
        message: String,
        expected: String,
    ) -> SceneError {
        let file = self.name.into();
        SceneError::Fault(Box::new(Fault { file, position, key, message, expected, suggestion: None }))
    }

    fn wrong(
        &self,
        key: impl Into<String>,
        message: impl Into<String>,
        expected: impl Into<String>,
    ) -> SceneError {
        self.fault(key.into(), None, message.into(), expected.into())
    }

    fn at_line(
        &self,
        line: usize,
        column: usize,
        message: impl Into<String>,
        expected: impl Into<String>,
    ) -> SceneError {
        self.fault(String::new(), Some(Position { line, column }), message.into(), expected.into())
    }

    fn at_byte(&self, byte: usize, message: impl Into<String>, expected: impl Into<String>) -> SceneError {
        self.fault(format!("byte {byte}"), None, message.into(), expected.into())
    }
}

#[cfg(test)]
mod tests;
