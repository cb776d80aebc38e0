//! Pixels in memory, PNG files, and files that are never half written.

use crate::error::{RenderError, Result, encode};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Largest side of a picture, pixels.
pub const SIDE_MAX: u32 = 8192;

/// An image of 8-bit sRGB pixels, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 3]>,
}

impl Image {
    /// A picture of one colour.
    ///
    /// # Errors
    /// A side that is 0 or above [`SIDE_MAX`].
    pub fn new(width: u32, height: u32, color: [u8; 3]) -> Result<Self> {
        check_size(width, height)?;
        Ok(Self { width, height, pixels: vec![color; width as usize * height as usize] })
    }
    /// A picture from `width × height` pixels.
    ///
    /// # Errors
    /// A side out of range, or a count of pixels that does not fit.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<[u8; 3]>) -> Result<Self> {
        check_size(width, height)?;
        if pixels.len() != width as usize * height as usize {
            return Err(RenderError::Invalid {
                field: "pixels",
                got: pixels.len().to_string(),
                expected: "width × height of them",
            });
        }
        Ok(Self { width, height, pixels })
    }
    /// Pixels across.
    pub fn width(&self) -> u32 {
        self.width
    }
    /// Pixels down.
    pub fn height(&self) -> u32 {
        self.height
    }
    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }
    /// One pixel; black outside.
    pub fn get(&self, x: u32, y: u32) -> [u8; 3] {
        if x >= self.width || y >= self.height {
            return [0; 3];
        }
        self.pixels[y as usize * self.width as usize + x as usize]
    }
    /// Mixes `color` into a pixel with weight `alpha` (0…1); outside the picture nothing happens.
    pub fn blend(&mut self, x: i32, y: i32, color: [u8; 3], alpha: f32) {
        if x < 0 || y < 0 || x as u32 >= self.width || y as u32 >= self.height {
            return;
        }
        let p = &mut self.pixels[y as usize * self.width as usize + x as usize];
        for c in 0..3 {
            let (a, b) = (f32::from(p[c]), f32::from(color[c]));
            p[c] = (a + (b - a) * alpha + 0.5) as u8;
        }
    }
    /// Bytes of a PNG file with this picture.
    ///
    /// # Errors
    /// What the encoder said.
    pub fn png(&self) -> Result<Vec<u8>> {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header().map_err(|e| encode("PNG", e))?;
        let bytes: Vec<u8> = self.pixels.iter().flatten().copied().collect();
        writer.write_image_data(&bytes).map_err(|e| encode("PNG", e))?;
        writer.finish().map_err(|e| encode("PNG", e))?;
        Ok(out)
    }
    /// Writes a PNG file, whole or not at all.
    ///
    /// # Errors
    /// What the encoder or the file system said.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        write_whole(path, &self.png()?)
    }
}

fn check_size(width: u32, height: u32) -> Result<()> {
    if (1..=SIDE_MAX).contains(&width) && (1..=SIDE_MAX).contains(&height) {
        return Ok(());
    }
    Err(RenderError::Invalid {
        field: "size",
        got: format!("{width}x{height}"),
        expected: "sides of 1 to 8192 pixels",
    })
}

/// Writes a file under a temporary name beside the target and renames it, so that the target is either the
/// old file or the whole new one. Missing folders are made.
///
/// # Errors
/// Names the file and what the system said.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let fail = |source| RenderError::Write { path: path.to_path_buf(), source };
    let name = path.file_name().ok_or_else(|| fail(std::io::ErrorKind::InvalidFilename.into()))?;
    // A link is followed; a device or pipe is written to, never replaced.
    let followed = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let path = followed.as_path();
    if path.is_dir() {
        return Err(fail(std::io::ErrorKind::IsADirectory.into()));
    }
    if path.exists() && !path.is_file() {
        return std::fs::OpenOptions::new()
            .write(true)
            .open(path)
            .and_then(|mut f| f.write_all(bytes))
            .map_err(fail);
    }
    if let Some(dir) = path.parent().filter(|d| !d.as_os_str().is_empty()) {
        std::fs::create_dir_all(dir).map_err(fail)?;
    }
    let mut temporary = name.to_os_string();
    temporary.push(format!(".{}.part", std::process::id()));
    let temporary: PathBuf = path.with_file_name(temporary);
    let write = || {
        let mut f = std::fs::File::create(&temporary)?;
        f.write_all(bytes)?;
        f.sync_all()?;
        std::fs::rename(&temporary, path)
    };
    write().map_err(|e| {
        // The first error is the one to report; the leftover is removed if it can be.
        let _ = std::fs::remove_file(&temporary);
        fail(e)
    })
}
