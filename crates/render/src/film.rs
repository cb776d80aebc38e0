//! Animated GIFs: one palette for the whole film, ordered dither, and only what changed.
//!
//! The palette is cut by variance from a histogram of the first frames (Heckbert 1982, refined by k-means).
//! The dither pattern stands still, and a pixel keeps its colour while that is still within a few levels of
//! the truth, so what does not move costs nothing.

use crate::error::{RenderError, Result, encode};
use crate::image::Image;
use std::borrow::Cow;

/// Frames that the palette is made from; more only stream through.
const PALETTE_FRAMES: usize = 120;
/// Palette index that means "as before".
const KEEP: u8 = 255;

/// Collects frames into an animated GIF.
pub struct Film {
    width: u32,
    height: u32,
    fps: f64,
    frames: usize,
    waiting: Vec<Image>,
    open: Option<Open>,
}

/// State after the palette is fixed.
struct Open {
    encoder: gif::Encoder<Vec<u8>>,
    palette: Palette,
    /// Palette index that each pixel shows.
    shown: Vec<u8>,
    written: usize,
}

impl Film {
    /// An empty film, `fps` frames a second (0.1…50; GIF counts hundredths of a second).
    ///
    /// # Errors
    /// A frame rate out of range.
    pub fn new(fps: f64) -> Result<Self> {
        if !(0.1..=50.0).contains(&fps) {
            return Err(RenderError::Invalid {
                field: "fps",
                got: fps.to_string(),
                expected: "0.1 to 50 frames a second",
            });
        }
        Ok(Self { width: 0, height: 0, fps, frames: 0, waiting: Vec::new(), open: None })
    }

    /// Number of frames so far.
    pub fn len(&self) -> usize {
        self.frames
    }
    /// No frames yet?
    pub fn is_empty(&self) -> bool {
        self.frames == 0
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// A frame of another size than the first, or what the encoder said.
    pub fn push(&mut self, image: Image) -> Result<()> {
        if self.frames == 0 {
            (self.width, self.height) = (image.width(), image.height());
        } else if (image.width(), image.height()) != (self.width, self.height) {
            return Err(RenderError::Invalid {
                field: "frame",
                got: format!("{}x{}", image.width(), image.height()),
                expected: "the size of the first frame",
            });
        }
        self.frames += 1;
        match &mut self.open {
            Some(open) => open.write(&image, self.fps),
            None => {
                self.waiting.push(image);
                if self.waiting.len() >= PALETTE_FRAMES { self.start() } else { Ok(()) }
            }
        }
    }

    /// Bytes of the GIF file.
    ///
    /// # Errors
    /// An empty film, or what the encoder said.
    pub fn finish(mut self) -> Result<Vec<u8>> {
        if self.open.is_none() {
            self.start()?;
        }
        match self.open {
            Some(open) => open.encoder.into_inner().map_err(|e| encode("GIF", e)),
            None => Err(encode("GIF", "no frames")),
        }
    }

    fn start(&mut self) -> Result<()> {
        let waiting = std::mem::take(&mut self.waiting);
        if waiting.is_empty() {
            return Err(encode("GIF", "no frames"));
        }
        let palette = Palette::from_frames(&waiting);
        let side = |v: u32| u16::try_from(v).map_err(|e| encode("GIF", e));
        let mut encoder =
            gif::Encoder::new(Vec::new(), side(self.width)?, side(self.height)?, &palette.bytes())
                .map_err(|e| encode("GIF", e))?;
        encoder.set_repeat(gif::Repeat::Infinite).map_err(|e| encode("GIF", e))?;
        let shown = vec![KEEP; self.width as usize * self.height as usize];
        let mut open = Open { encoder, palette, shown, written: 0 };
        for image in &waiting {
            open.write(image, self.fps)?;
        }
        self.open = Some(open);
        Ok(())
    }
}

impl Open {
    fn write(&mut self, image: &Image, fps: f64) -> Result<()> {
        let (w, h) = (image.width() as usize, image.height() as usize);
        let first = self.written == 0;
        let mut out = vec![KEEP; w * h];
        let (mut x0, mut x1, mut y0, mut y1) = (w, 0, h, 0);
        for y in 0..h {
            for x in 0..w {
                let i = y * w + x;
                let c = image.pixels()[i];
                if !first && self.palette.near(self.shown[i], c) {
                    continue;
                }
                let k = self.palette.dithered(c, x, y);
                if first || k != self.shown[i] {
                    (out[i], self.shown[i]) = (k, k);
                    (x0, x1, y0, y1) = (x0.min(x), x1.max(x + 1), y0.min(y), y1.max(y + 1));
                }
            }
        }
        if x0 >= x1 {
            // Nothing changed: one pixel that says so keeps the time.
            (x0, x1, y0, y1) = (0, 1, 0, 1);
        }
        let rows = (y0..y1).flat_map(|y| out[y * w + x0..y * w + x1].iter().copied());
        let buffer: Vec<u8> = rows.collect();
        // The display times of all frames so far, rounded as a whole, so that no error adds up.
        let at = |n: usize| (n as f64 * 100.0 / fps).round() as u64;
        let frame = gif::Frame {
            delay: (at(self.written + 1) - at(self.written)).min(65_535) as u16,
            dispose: gif::DisposalMethod::Keep,
            transparent: (!first).then_some(KEEP),
            left: x0 as u16,
            top: y0 as u16,
            width: (x1 - x0) as u16,
            height: (y1 - y0) as u16,
            buffer: Cow::Owned(buffer),
            ..gif::Frame::default()
        };
        self.encoder.write_frame(&frame).map_err(|e| encode("GIF", e))?;
        self.written += 1;
        Ok(())
    }
}

/// 255 colours and a table of the nearest one.
struct Palette {
    colors: Vec<[u8; 3]>,
    /// Nearest colour by the upper bits of each channel; [`UNKNOWN`] until it is asked for.
    nearest: Vec<u16>,
}

/// Bits of a channel that the histogram and the table of nearest colours go by.
const BITS: usize = 6;
const UNKNOWN: u16 = u16::MAX;

/// A part of the histogram: mean colours of its bins with their weights.
struct Cut {
    bins: Vec<([f32; 3], f32)>,
}

impl Cut {
    fn mean(&self) -> [f32; 3] {
        let w: f32 = self.bins.iter().map(|b| b.1).sum();
        let mut m = [0.0; 3];
        for (c, weight) in &self.bins {
            for k in 0..3 {
                m[k] += c[k] * weight / w;
            }
        }
        m
    }
    /// Axis of the largest weighted variance, and that variance.
    fn spread(&self) -> (usize, f32) {
        let m = self.mean();
        let mut v = [0.0_f32; 3];
        for (c, weight) in &self.bins {
            for k in 0..3 {
                v[k] += (c[k] - m[k]) * (c[k] - m[k]) * weight;
            }
        }
        (0..3).fold((0, 0.0), |best, k| if v[k] > best.1 { (k, v[k]) } else { best })
    }
}

impl Palette {
    fn from_frames(frames: &[Image]) -> Self {
        let mut sums = vec![([0.0_f32; 3], 0.0_f32); 1 << (3 * BITS)];
        let stride = (frames.len() / 24).max(1);
        for image in frames.iter().step_by(stride) {
            for c in image.pixels() {
                let s = &mut sums[bin(*c)];
                for k in 0..3 {
                    s.0[k] += f32::from(c[k]);
                }
                s.1 += 1.0;
            }
        }
        let bins: Vec<_> = sums
            .into_iter()
            .filter(|s| s.1 > 0.0)
            // Less than proportional: small coloured things keep their colour beside large grey ones.
            .map(|(c, n)| (c.map(|v| v / n), n.sqrt()))
            .collect();
        let mut colors = cut(&bins);
        for _ in 0..6 {
            refine(&bins, &mut colors);
        }
        let colors: Vec<[u8; 3]> =
            colors.iter().map(|c| c.map(|v| v.round().clamp(0.0, 255.0) as u8)).collect();
        Self { colors, nearest: vec![UNKNOWN; 1 << (3 * BITS)] }
    }

    /// 256 entries, the last one for "as before".
    fn bytes(&self) -> Vec<u8> {
        let mut b: Vec<u8> = self.colors.iter().flatten().copied().collect();
        b.resize(256 * 3, 0);
        b
    }

    /// Is the palette's colour still good enough for `c`?
    fn near(&self, shown: u8, c: [u8; 3]) -> bool {
        self.colors.get(usize::from(shown)).is_some_and(|s| (0..3).all(|k| s[k].abs_diff(c[k]) <= 5))
    }

    fn dithered(&mut self, c: [u8; 3], x: usize, y: usize) -> u8 {
        // Bayer's 4 × 4 matrix, ±1.9 levels: enough against bands, little enough for short runs.
        const BAYER: [i32; 16] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];
        let d = BAYER[(y % 4) * 4 + x % 4] * 2 - 15;
        let moved = c.map(|v| ((i32::from(v) * 8 + d) / 8).clamp(0, 255) as u8);
        let i = bin(moved);
        if self.nearest[i] == UNKNOWN {
            let half = 1 << (7 - BITS);
            let middle = moved.map(|v| i32::from(v >> (8 - BITS) << (8 - BITS)) + half);
            self.nearest[i] = u16::from(nearest(&self.colors, middle));
        }
        self.nearest[i] as u8
    }
}

fn bin(c: [u8; 3]) -> usize {
    c.iter().fold(0, |i, v| i << BITS | usize::from(v >> (8 - BITS)))
}

fn nearest(colors: &[[u8; 3]], c: [i32; 3]) -> u8 {
    let mut best = (i32::MAX, 0);
    for (i, p) in colors.iter().enumerate() {
        let d = [0, 1, 2].map(|k| i32::from(p[k]) - c[k]);
        // Weights of the eye: green most, blue least.
        let e = 3 * d[0] * d[0] + 5 * d[1] * d[1] + 2 * d[2] * d[2];
        if e < best.0 {
            best = (e, i);
        }
    }
    best.1 as u8
}

/// Cuts the histogram into at most 255 parts, always the most spread one, at its mean.
fn cut(bins: &[([f32; 3], f32)]) -> Vec<[f32; 3]> {
    let first = Cut { bins: bins.to_vec() };
    let spread = first.spread();
    let mut parts = vec![(first, spread)];
    while parts.len() < 255 {
        let (mut worst, mut most) = (usize::MAX, 0.0);
        for (i, (_, (_, v))) in parts.iter().enumerate() {
            if *v > most {
                (worst, most) = (i, *v);
            }
        }
        if worst == usize::MAX {
            break;
        }
        let (part, (axis, _)) = parts.swap_remove(worst);
        let mean = part.mean()[axis];
        let (low, high): (Vec<_>, Vec<_>) = part.bins.into_iter().partition(|b| b.0[axis] < mean);
        for bins in [low, high] {
            if !bins.is_empty() {
                let c = Cut { bins };
                // A part whose side was empty must not be cut for ever.
                let s = if c.bins.len() == 1 { (0, 0.0) } else { c.spread() };
                parts.push((c, s));
            }
        }
    }
    parts.iter().map(|(c, _)| c.mean()).collect()
}

/// One round of k-means.
fn refine(bins: &[([f32; 3], f32)], colors: &mut [[f32; 3]]) {
    let whole: Vec<[u8; 3]> = colors.iter().map(|c| c.map(|v| v.round().clamp(0.0, 255.0) as u8)).collect();
    let mut sums = vec![([0.0_f32; 3], 0.0_f32); colors.len()];
    for (c, w) in bins {
        let k = usize::from(nearest(&whole, c.map(|v| v as i32)));
        for j in 0..3 {
            sums[k].0[j] += c[j] * w;
        }
        sums[k].1 += w;
    }
    for (color, (sum, w)) in colors.iter_mut().zip(sums) {
        if w > 0.0 {
            *color = sum.map(|v| v / w);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient(shift: u32) -> Image {
        let at = |x: u32, y: u32| [(x * 2) as u8, (y * 3) as u8, if x == shift && y < 9 { 255 } else { 90 }];
        let pixels = (0..64).flat_map(|y| (0..100).map(move |x| at(x, y))).collect();
        Image::from_pixels(100, 64, pixels).expect("small")
    }

    fn decode(bytes: &[u8]) -> (Vec<Vec<[u8; 3]>>, Vec<u16>) {
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut d = options.read_info(bytes).expect("header");
        let (w, mut screen) = (usize::from(d.width()), vec![[0; 3]; 100 * 64]);
        let (mut frames, mut delays) = (Vec::new(), Vec::new());
        while let Some(f) = d.read_next_frame().expect("frame") {
            for y in 0..usize::from(f.height) {
                for x in 0..usize::from(f.width) {
                    let p = &f.buffer[(y * usize::from(f.width) + x) * 4..][..4];
                    if p[3] > 0 {
                        screen[(y + usize::from(f.top)) * w + x + usize::from(f.left)] = [p[0], p[1], p[2]];
                    }
                }
            }
            frames.push(screen.clone());
            delays.push(f.delay);
        }
        (frames, delays)
    }

    #[test]
    fn a_film_shows_what_was_pushed() {
        let mut film = Film::new(15.0).expect("rate");
        for k in 0..9 {
            film.push(gradient(k * 7)).expect("frame");
        }
        let (frames, delays) = decode(&film.finish().expect("film"));
        assert_eq!(frames.len(), 9);
        // Nine frames at 15 a second are 60 hundredths.
        assert_eq!(delays.iter().sum::<u16>(), 60);
        for (k, frame) in frames.iter().enumerate() {
            let want = gradient(k as u32 * 7);
            for (got, want) in frame.iter().zip(want.pixels()) {
                for c in 0..3 {
                    assert!(got[c].abs_diff(want[c]) < 28, "frame {k}: {got:?} for {want:?}");
                }
            }
        }
    }

    #[test]
    fn a_still_film_costs_nothing() {
        let size = |n| {
            let mut film = Film::new(20.0).expect("rate");
            (0..n).for_each(|_| film.push(gradient(5)).expect("frame"));
            film.finish().expect("film").len()
        };
        assert!(size(30) < size(1) + 30 * 40, "{} {}", size(30), size(1));
    }

    #[test]
    fn bad_films_are_refused() {
        assert!(Film::new(f64::NAN).is_err());
        assert!(Film::new(10.0).expect("rate").finish().is_err());
        let mut film = Film::new(10.0).expect("rate");
        film.push(gradient(0)).expect("frame");
        assert!(film.push(Image::new(3, 3, [0; 3]).expect("small")).is_err());
    }
}
