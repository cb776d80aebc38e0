//! STL, text and binary. Files that begin with "solid" may be either; the length decides.

use super::{MeshData, MeshFile};
use crate::error::SceneError;
use jounce::geometry::limits::MESH_TRIANGLES_MAX;
use jounce::math::Vec3;

const HEADER: usize = 84;
const RECORD: usize = 50;

pub(super) fn parse(file: MeshFile, bytes: &[u8]) -> Result<MeshData, SceneError> {
    let declared = bytes.get(80..HEADER).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let fits = declared.is_some_and(|n| n.checked_mul(RECORD).is_some_and(|l| l + HEADER == bytes.len()));
    // Text has no zero bytes, and a broken binary header nearly always has.
    let text_like =
        bytes.trim_ascii_start().starts_with(b"solid") && !bytes.iter().take(512).any(|&b| b == 0);
    if !fits && text_like {
        return text(file, bytes);
    }
    match declared {
        Some(n) => binary(file, bytes, n),
        None => Err(file.at_byte(
            bytes.len(),
            format!("the file ends after {} bytes", bytes.len()),
            "a text STL (solid …) or a binary one with a header of 84 bytes",
        )),
    }
}

fn binary(file: MeshFile, bytes: &[u8], n: usize) -> Result<MeshData, SceneError> {
    let there = (bytes.len() - HEADER) / RECORD;
    if n > there {
        let message = format!("the header declares {n} triangles, the file has {there}");
        return Err(file.at_byte(
            bytes.len(),
            message,
            format!("{} bytes", n.saturating_mul(RECORD) + HEADER),
        ));
    }
    if n > MESH_TRIANGLES_MAX {
        return Err(file.at_byte(80, format!("{n} triangles"), format!("at most {MESH_TRIANGLES_MAX}")));
    }
    let mut mesh = MeshData::new();
    mesh.vertices.reserve_exact(3 * n);
    mesh.triangles.reserve_exact(n);
    mesh.triangle_groups.reserve_exact(n);
    for t in 0..n {
        let record = &bytes[HEADER + t * RECORD..][..RECORD];
        for corner in 0..3 {
            let at = 12 + 12 * corner;
            let number = |k: usize| {
                let b = &record[at + 4 * k..];
                f32::from_le_bytes([b[0], b[1], b[2], b[3]])
            };
            let p = Vec3::new(number(0), number(1), number(2));
            if !p.is_finite() {
                let message = format!("triangle {t} has a coordinate that is not finite");
                return Err(file.at_byte(HEADER + t * RECORD + at, message, "finite numbers"));
            }
            mesh.vertices.push(p);
        }
        let first = 3 * t as u32;
        mesh.push(file, [first, first + 1, first + 2], 0)?;
    }
    Ok(mesh)
}

fn text(file: MeshFile, bytes: &[u8]) -> Result<MeshData, SceneError> {
    let mut mesh = MeshData::new();
    let mut corners = 0;
    let mut ended = false;
    let mut lines = 0;
    for (n, line) in bytes.split(|&b| b == b'\n').enumerate() {
        lines = n + 1;
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        match words.next() {
            Some(b"vertex") => {
                mesh.vertices.push(vertex(file, lines, words)?);
                corners += 1;
            }
            Some(b"endloop") => {
                if corners != 3 {
                    return Err(file.at_line(lines, 1, format!("a facet with {corners} corners"), "three"));
                }
                corners = 0;
                let first = (mesh.vertices.len() - 3) as u32;
                mesh.push(file, [first, first + 1, first + 2], 0)?;
            }
            Some(b"endsolid") => ended = true,
            Some(b"solid" | b"facet" | b"outer" | b"endfacet") | None => {}
            Some(word) => {
                let shown = String::from_utf8_lossy(word).chars().take(24).collect::<String>();
                let expected = "solid, facet, outer loop, vertex, endloop, endfacet or endsolid";
                return Err(file.at_line(lines, 1, format!("found `{shown}`"), expected));
            }
        }
    }
    if !ended || corners != 0 {
        return Err(file.at_line(lines, 1, "the file ends inside a solid", "endsolid"));
    }
    Ok(mesh)
}

fn vertex<'t>(
    file: MeshFile,
    line: usize,
    mut words: impl Iterator<Item = &'t [u8]>,
) -> Result<Vec3, SceneError> {
    let mut number = || {
        let word = words.next().unwrap_or(b"nothing");
        let value = std::str::from_utf8(word).ok().and_then(|t| t.parse::<f32>().ok());
        value.filter(|v| v.is_finite()).ok_or_else(|| {
            let shown = String::from_utf8_lossy(word).chars().take(24).collect::<String>();
            file.at_line(line, 1, format!("found `{shown}` in a vertex"), "three finite numbers")
        })
    };
    Ok(Vec3::new(number()?, number()?, number()?))
}
