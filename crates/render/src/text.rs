//! Words on pictures, in DejaVu Sans (free licence, see the `dejavu` crate).

use crate::image::Image;
use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};

pub(crate) fn font_bytes() -> &'static [u8] {
    dejavu::sans::regular()
}

/// Draws a line of text with its baseline at `y`, over a soft light halo. `size` is the height in pixels.
pub fn draw(image: &mut Image, text: &str, x: f32, y: f32, size: f32, color: [u8; 3]) {
    let Ok(font) = FontRef::try_from_slice(font_bytes()) else { return };
    let scaled = font.as_scaled(PxScale::from(size));
    let (mut pen, mut last) = (x, None);
    let mut ink: Vec<(i32, i32, f32)> = Vec::new();
    for c in text.chars().filter(|c| !c.is_control()).take(400) {
        let id = scaled.glyph_id(c);
        if let Some(l) = last {
            pen += scaled.kern(l, id);
        }
        let glyph = id.with_scale_and_position(PxScale::from(size), point(pen, y));
        if let Some(outline) = font.outline_glyph(glyph) {
            let b = outline.px_bounds();
            outline.draw(|gx, gy, cover| {
                ink.push((b.min.x as i32 + gx as i32, b.min.y as i32 + gy as i32, cover));
            });
        }
        pen += scaled.h_advance(id);
        last = Some(id);
    }
    for &(px, py, cover) in &ink {
        for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1), (1, 1), (-1, -1), (1, -1), (-1, 1)] {
            image.blend(px + dx, py + dy, [255, 255, 255], cover.min(1.0) * 0.22);
        }
    }
    for &(px, py, cover) in &ink {
        image.blend(px, py, color, cover.min(1.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_leaves_ink_and_stays_inside() {
        let mut image = Image::new(120, 24, [255; 3]).expect("small");
        draw(&mut image, "θ = 30°, μ 0.5 and far too long for this picture", 2.0, 18.0, 14.0, [0; 3]);
        let dark = image.pixels().iter().filter(|p| p[0] < 128).count();
        assert!(dark > 100, "{dark}");
    }
}
