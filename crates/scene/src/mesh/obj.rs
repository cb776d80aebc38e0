//! Wavefront OBJ: `v`, `f` (any corners, any index form, negative indices) and `usemtl`; the rest is skipped.

use super::triangulate::polygon;
use super::{MeshData, MeshFile};
use crate::error::SceneError;
use crate::limits;
use jounce::math::Vec3;

struct Reader<'a> {
    file: MeshFile<'a>,
    mesh: MeshData,
    group: u16,
    line: usize,
    budget: u64,
    face: Vec<u32>,
    corners: Vec<Vec3>,
    cut: Vec<[usize; 3]>,
}

pub(super) fn parse(file: MeshFile, bytes: &[u8]) -> Result<MeshData, SceneError> {
    let budget = (16 << 20) + 64 * bytes.len() as u64;
    let mut r = Reader {
        file,
        mesh: MeshData::new(),
        group: 0,
        line: 1,
        budget,
        face: Vec::new(),
        corners: Vec::new(),
        cut: Vec::new(),
    };
    let mut start = 0;
    while start < bytes.len() {
        let (mut end, mut lines) = (start, 0);
        // A backslash at the end of a line continues it.
        loop {
            end += bytes[end..].iter().position(|&b| b == b'\n').unwrap_or(bytes.len() - end);
            lines += 1;
            let body = bytes[start..end].strip_suffix(b"\r").unwrap_or(&bytes[start..end]);
            if !body.ends_with(b"\\") || end >= bytes.len() {
                break;
            }
            end += 1;
        }
        let line = &bytes[start..end.min(bytes.len())];
        if line.len() > limits::MESH_LINE_MAX {
            let limit = format!("at most {} bytes", limits::MESH_LINE_MAX);
            return Err(file.at_line(r.line, 1, format!("a line of {} bytes", line.len()), limit));
        }
        r.statement(line)?;
        r.line += lines;
        start = end + 1;
    }
    Ok(r.mesh)
}

impl Reader<'_> {
    fn wrong(&self, line: &[u8], token: &[u8], message: String, expected: &str) -> SceneError {
        // Tokens are slices of the line, so their distance is the column.
        let column = (token.as_ptr() as usize).saturating_sub(line.as_ptr() as usize) + 1;
        self.file.at_line(self.line, column.min(line.len() + 1), message, expected)
    }

    fn statement(&mut self, line: &[u8]) -> Result<(), SceneError> {
        let body = line.split(|&b| b == b'#').next().unwrap_or(line);
        let mut tokens = body.split(u8::is_ascii_whitespace).filter(|t| !t.is_empty() && *t != b"\\");
        match tokens.next() {
            Some(b"v") => self.vertex(line, &mut tokens),
            Some(b"f") => self.face(line, &mut tokens),
            Some(b"usemtl") => {
                let name = String::from_utf8_lossy(tokens.next().unwrap_or(b"")).into_owned();
                self.group = self.mesh.group(self.file, &name)?;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn vertex<'t>(
        &mut self,
        line: &[u8],
        tokens: &mut impl Iterator<Item = &'t [u8]>,
    ) -> Result<(), SceneError> {
        let mut p = [0.0f32; 3];
        for x in &mut p {
            let Some(token) = tokens.next() else {
                return Err(self.wrong(
                    line,
                    line,
                    "a vertex with fewer than three numbers".into(),
                    "v x y z",
                ));
            };
            let number = std::str::from_utf8(token).ok().and_then(|t| t.parse::<f32>().ok());
            *x = number.filter(|v| v.is_finite()).ok_or_else(|| {
                let shown = String::from_utf8_lossy(token).chars().take(24).collect::<String>();
                self.wrong(line, token, format!("found `{shown}`"), "a finite number")
            })?;
        }
        self.mesh.vertices.push(Vec3::from_array(p));
        Ok(())
    }

    fn face<'t>(
        &mut self,
        line: &[u8],
        tokens: &mut impl Iterator<Item = &'t [u8]>,
    ) -> Result<(), SceneError> {
        let n = self.mesh.vertices.len() as i64;
        self.face.clear();
        self.corners.clear();
        for token in tokens {
            let index = token.split(|&b| b == b'/').next().unwrap_or(token);
            let index = std::str::from_utf8(index).ok().and_then(|t| t.parse::<i64>().ok());
            let vertex = match index {
                Some(i) if i > 0 && i <= n => i - 1,
                Some(i) if i < 0 && i >= -n => n + i,
                Some(i) => {
                    let message = format!("the face names vertex {i}, of {n} so far");
                    return Err(self.wrong(
                        line,
                        token,
                        message,
                        "1 to the number of vertices, or -1 for the last",
                    ));
                }
                None => {
                    let shown = String::from_utf8_lossy(token).chars().take(24).collect::<String>();
                    return Err(self.wrong(
                        line,
                        token,
                        format!("found `{shown}`"),
                        "a vertex number such as 7 or 7/1/2",
                    ));
                }
            };
            if self.face.len() >= limits::POLYGON_CORNERS_MAX {
                let limit = format!("at most {}", limits::POLYGON_CORNERS_MAX);
                return Err(self.wrong(line, token, "a face with too many corners".into(), &limit));
            }
            self.face.push(vertex as u32);
            self.corners.push(self.mesh.vertices[vertex as usize]);
        }
        if self.face.len() < 3 {
            let message = format!("a face with {} corners", self.face.len());
            return Err(self.wrong(line, line, message, "at least three"));
        }
        self.cut.clear();
        polygon(&self.corners, &mut self.budget, &mut self.cut);
        for t in &self.cut {
            self.mesh.push(self.file, t.map(|k| self.face[k]), self.group)?;
        }
        Ok(())
    }
}
