//! Curves over time, as SVG text or as a picture.

use crate::error::{RenderError, Result, encode};
use crate::image::Image;
use crate::text;
use jounce::math::scalar::f64s;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::ops::Range;
use std::sync::Once;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// A line.
    #[default]
    Solid,
    /// A dashed line: closed forms and references.
    Dashed,
    /// Dots.
    Dots,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Name in the legend; without one it is not there.
    pub name: String,
    /// x, y. A point that is not finite breaks the line.
    pub points: Vec<[f64; 2]>,
    /// Look.
    pub style: Style,
    /// Which of the colours; by default each series has its own.
    pub color: Option<usize>,
}

/// A diagram.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Above the diagram; may be empty.
    pub title: String,
    /// Name and unit of x, such as "time (s)".
    pub x_label: String,
    /// Name and unit of y.
    pub y_label: String,
    /// Curves, first one below.
    pub series: Vec<Series>,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The y axis is logarithmic; points that are not above 0 break the line.
    pub log_y: bool,
}

impl Default for Plot {
    fn default() -> Self {
        Self {
            title: String::new(),
            x_label: "time (s)".into(),
            y_label: String::new(),
            series: Vec::new(),
            width: 960,
            height: 540,
            log_y: false,
        }
    }
}

/// Colours of curves, told apart also by the colour-blind (after Okabe and Ito 2008).
const COLORS: [u32; 8] = [0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0x56B4E9, 0xE69F00, 0x5B5B5B, 0x8C6BB1];

/// Pictures of more pixels are drawn without smoothing.
const FINE_PIXELS_MAX: u32 = 4_000_000;

/// Diagrams of this size and above have lengths of their own; in smaller ones all shrinks with them.
const FULL_PX: [f64; 2] = [800.0, 450.0];
/// Diagrams smaller than this part of that need the room of the title for the curves.
const TITLE_PART_MIN: f64 = 0.5;
/// Smaller letters cannot be read.
const FONT_MIN_PX: f64 = 10.0;

const INK: RGBColor = RGBColor(40, 48, 60);

fn color(i: usize) -> RGBColor {
    let c = COLORS[i % COLORS.len()];
    RGBColor((c >> 16) as u8, (c >> 8) as u8, c as u8)
}

impl Plot {
    /// The diagram as the text of an SVG file.
    ///
    /// # Errors
    /// Nothing to draw, or a size that no picture can have.
    pub fn svg(&self) -> Result<String> {
        let mut out = String::new();
        self.draw(&SVGBackend::with_string(&mut out, self.size()?).into_drawing_area(), 1)?;
        Ok(out)
    }

    /// The diagram as a picture.
    ///
    /// # Errors
    /// As [`Plot::svg`].
    pub fn image(&self) -> Result<Image> {
        let (w, h) = self.size()?;
        // Drawn three times as large and averaged: the library's own lines have stairs.
        let s = if w * h <= FINE_PIXELS_MAX { 3 } else { 1 };
        let mut bytes = vec![255_u8; (w * s) as usize * (h * s) as usize * 3];
        {
            let area = BitMapBackend::with_buffer(&mut bytes, (w * s, h * s)).into_drawing_area();
            self.draw(&area, s)?;
        }
        let row = (w * s * 3) as usize;
        let s = s as usize;
        let mean = |x: usize, y: usize, k: usize| {
            let cells = (0..s).flat_map(|j| (0..s).map(move |i| (i, j)));
            let sum: usize =
                cells.map(|(i, j)| usize::from(bytes[(y * s + j) * row + (x * s + i) * 3 + k])).sum();
            ((sum + s * s / 2) / (s * s)) as u8
        };
        let (columns, lines) = (w as usize, h as usize);
        let pixels = (0..lines).flat_map(|y| (0..columns).map(move |x| (x, y)));
        Image::from_pixels(w, h, pixels.map(|(x, y)| [0, 1, 2].map(|k| mean(x, y, k))).collect())
    }

    fn size(&self) -> Result<(u32, u32)> {
        if (200..=4096).contains(&self.width) && (150..=4096).contains(&self.height) {
            return Ok((self.width, self.height));
        }
        Err(RenderError::Invalid {
            field: "plot size",
            got: format!("{}x{}", self.width, self.height),
            expected: "200x150 to 4096x4096 pixels",
        })
    }

    /// Can a point be drawn?
    fn fits(&self, p: &[f64; 2]) -> bool {
        p[0].is_finite() && p[1].is_finite() && (p[1] > 0.0 || !self.log_y)
    }

    /// Stretches of points that can be drawn.
    fn runs<'a>(&'a self, points: &'a [[f64; 2]]) -> impl Iterator<Item = &'a [[f64; 2]]> {
        points.split(|p| !self.fits(p)).filter(|r| !r.is_empty())
    }

    /// Range of a coordinate, widened by `margin` of itself.
    fn range(&self, axis: usize, margin: f64) -> Result<Range<f64>> {
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in self.series.iter().flat_map(|s| &s.points).filter(|p| self.fits(p)) {
            lo = if p[axis] < lo { p[axis] } else { lo };
            hi = if p[axis] > hi { p[axis] } else { hi };
        }
        if lo > hi {
            let what =
                if self.log_y { "no finite points above 0 to draw" } else { "no finite points to draw" };
            return Err(encode("plot", what));
        }
        if axis == 1 && self.log_y {
            // At least a factor of two, and a margin in the logarithm.
            let ratio = hi / lo;
            let factor = ratio.clamp(2.0, 1e300).powf(margin) * if ratio < 2.0 { 1.5 } else { 1.0 };
            return Ok((lo / factor).max(f64::MIN_POSITIVE)..(hi * factor).min(f64::MAX));
        }
        let span = hi - lo;
        // A constant needs some room, or rounding noise would fill the picture.
        let least = (lo.abs() + hi.abs()) * 1e-6 + 1e-9;
        let pad = if span > least { span * margin } else { (lo.abs() * 0.1).max(0.5 * least + 1e-3) };
        Ok(lo - pad..hi + pad)
    }

    /// Lengths for the size of the diagram.
    fn measure(&self, s: u32) -> Measure {
        let sides = [f64::from(self.width) / FULL_PX[0], f64::from(self.height) / FULL_PX[1]];
        Measure { part: f64s::clamp(f64s::min(sides[0], sides[1]), 0.3, 1.0), s: f64::from(s) }
    }

    /// Draws with every length multiplied by `s`.
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, s: u32) -> Result<()> {
        use_font()?;
        let fail = |e: DrawingAreaErrorKind<B::ErrorType>| encode("plot", e);
        let (x, y) = (self.range(0, 0.0)?, self.range(1, 0.06)?);
        let x = if x.end > x.start { x } else { x.start - 0.5..x.end + 0.5 };
        area.fill(&WHITE).map_err(fail)?;
        let corner = self.free_corner(&x, &y);
        if self.log_y {
            let ticks = powers(&y);
            self.chart(area, s, x, y.log_scale().with_key_points(ticks), &power, corner)?;
        } else {
            let digits = decimals(&y);
            self.chart(area, s, x, y, &|v| number(*v, digits), corner)?;
        }
        area.present().map_err(fail)
    }

    fn chart<B: DrawingBackend, Y>(
        &self,
        area: &DrawingArea<B, Shift>,
        s: u32,
        x: Range<f64>,
        y: Y,
        y_label: &dyn Fn(&f64) -> String,
        corner: SeriesLabelPosition,
    ) -> Result<()>
    where
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        let fail = |e: DrawingAreaErrorKind<B::ErrorType>| encode("plot", e);
        let m = self.measure(s);
        let font = |size: f64| ("sans-serif", m.font(size)).into_font().color(&INK);
        let x_digits = decimals(&x);
        let mut builder = ChartBuilder::on(area);
        builder.margin(m.px(14.0)).margin_right(m.px(26.0)).margin_left(m.words(14.0, 12.0));
        builder.x_label_area_size(m.words(46.0, 28.0)).y_label_area_size(m.words(78.0, 46.0));
        if !self.title.is_empty() && m.part >= TITLE_PART_MIN {
            builder.caption(&self.title, font(20.0));
        }
        let mut chart = builder.build_cartesian_2d(x, y).map_err(fail)?;
        chart
            .configure_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_labels(m.count(10))
            .y_labels(m.count(8))
            .x_label_formatter(&|v| number(*v, x_digits))
            .y_label_formatter(y_label)
            .label_style(font(14.0))
            .axis_desc_style(font(15.0))
            .set_all_tick_mark_size(m.px(5.0))
            .axis_style(ShapeStyle::from(&RGBColor(120, 128, 140)).stroke_width(s))
            .bold_line_style(RGBColor(222, 226, 232).stroke_width(s))
            .light_line_style(RGBColor(243, 245, 248).stroke_width(s))
            .max_light_lines(m.count(4).max(2))
            .draw()
            .map_err(fail)?;
        self.curves(&mut chart, m)?;
        let named = self.series.iter().filter(|s| !s.name.is_empty()).count();
        if named == 1 && m.part < TITLE_PART_MIN && self.y_label.contains(&self.series[0].name) {
            // The axis says it.
            return Ok(());
        }
        chart
            .configure_series_labels()
            .position(corner)
            .margin(m.px(10.0))
            .legend_area_size(m.px(32.0))
            .label_font(font(15.0))
            .background_style(WHITE.mix(0.88))
            .border_style(RGBColor(205, 210, 218).stroke_width(s))
            .draw()
            .map_err(fail)
    }

    fn curves<'a, B: DrawingBackend + 'a, Y: Ranged<ValueType = f64>>(
        &self,
        chart: &mut ChartContext<'a, B, Cartesian2d<RangedCoordf64, Y>>,
        m: Measure,
    ) -> Result<()> {
        let fail = |e: DrawingAreaErrorKind<B::ErrorType>| encode("plot", e);
        let px = move |length: f64| m.px(length) as i32;
        for (i, series) in self.series.iter().enumerate() {
            let c = color(series.color.unwrap_or(i));
            let line = c.stroke_width(m.line());
            let (dots, dashed) = (series.style == Style::Dots, series.style == Style::Dashed);
            let mut named = series.name.is_empty();
            for run in self.runs(&series.points) {
                let points = run.iter().map(|p| (p[0], p[1]));
                let drawn = if dots {
                    chart.draw_series(points.map(|p| Circle::new(p, m.dot(), c.filled())))
                } else if dashed {
                    chart.draw_series(DashedLineSeries::new(points, m.px(7.0), m.px(5.0), line))
                } else {
                    chart.draw_series(LineSeries::new(points, line))
                };
                let drawn = drawn.map_err(fail)?;
                if std::mem::replace(&mut named, true) {
                    continue;
                }
                let drawn = drawn.label(&series.name);
                if dots {
                    drawn.legend(move |(x, y)| Circle::new((x + px(12.0), y), m.dot(), c.filled()));
                } else {
                    let (end, second) = if dashed { (px(9.0), px(15.0)) } else { (px(24.0), 0) };
                    drawn.legend(move |(x, y)| {
                        let parts = [[(x, y), (x + end, y)], [(x + second, y), (x + px(24.0), y)]];
                        let element = EmptyElement::at((0, 0));
                        element + PathElement::new(parts[0], line) + PathElement::new(parts[1], line)
                    });
                }
            }
        }
        Ok(())
    }

    /// The corner with the fewest points, for the legend.
    fn free_corner(&self, x: &Range<f64>, y: &Range<f64>) -> SeriesLabelPosition {
        let level = |v: f64| if self.log_y { v.ln() } else { v };
        let part = |v: f64, lo: f64, hi: f64| (v - lo) / (hi - lo);
        let mut counts = [0_usize; 4];
        for p in self.series.iter().flat_map(|s| &s.points).filter(|p| self.fits(p)) {
            let u = part(p[0], x.start, x.end);
            let v = part(level(p[1]), level(y.start), level(y.end));
            if (0.4..=0.6).contains(&u) {
                continue;
            }
            // Upper right, upper left, lower right, lower left; the legend is about a third high.
            let corner = usize::from(u < 0.5) + if v > 0.64 { 0 } else { 2 };
            if !(0.36..=0.64).contains(&v) {
                counts[corner] += 1;
            }
        }
        let least = (0..4).min_by_key(|&k| counts[k]).unwrap_or(0);
        [
            SeriesLabelPosition::UpperRight,
            SeriesLabelPosition::UpperLeft,
            SeriesLabelPosition::LowerRight,
            SeriesLabelPosition::LowerLeft,
        ]
        .into_iter()
        .nth(least)
        .unwrap_or(SeriesLabelPosition::UpperRight)
    }
}

/// Lengths on a diagram, multiplied for a drawing that is averaged later.
#[derive(Clone, Copy)]
struct Measure {
    /// Of the lengths of a full diagram.
    part: f64,
    s: f64,
}

impl Measure {
    fn px(self, full: f64) -> u32 {
        f64s::max((full * self.part * self.s).round(), 1.0) as u32
    }
    /// Height of letters.
    fn font(self, full: f64) -> u32 {
        (f64s::max(full * self.part, FONT_MIN_PX) * self.s).round() as u32
    }
    /// Room for words, which do not shrink below `least`.
    fn words(self, full: f64, least: f64) -> u32 {
        (f64s::max(full * self.part, least) * self.s).round() as u32
    }
    /// Thickness of a curve: thinner in a small diagram, but never a hair.
    fn line(self) -> u32 {
        ((1.0 + self.part) * self.s).round() as u32
    }
    fn dot(self) -> u32 {
        ((1.5 + 1.5 * self.part) * self.s).round() as u32
    }
    /// Of marks along an axis.
    fn count(self, full: usize) -> usize {
        ((full as f64 * self.part).round() as usize).max(5.min(full))
    }
}

/// Marks of a logarithmic axis: powers of ten, at most a dozen; between few of them also their multiples.
fn powers(y: &Range<f64>) -> Vec<f64> {
    let (lo, hi) = (y.start.log10(), y.end.log10());
    let decades = hi - lo;
    let multiples: &[f64] = match decades {
        d if d < 1.3 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0],
        d if d < 4.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let stride = (decades / 12.0).ceil().max(1.0) as usize;
    let exponents = (lo.floor() as i32..=hi.ceil() as i32).step_by(stride);
    let marks = exponents.flat_map(|e| multiples.iter().map(move |m| m * 10_f64.powi(e)));
    marks.filter(|v| y.contains(v)).collect()
}

/// Label of a logarithmic axis.
fn power(v: &f64) -> String {
    let plain = (1e-3..1e5).contains(v);
    if plain { format!("{}", (v * 1e6).round() / 1e6) } else { format!("{v:.0e}") }
}

/// Decimals that tell the labels of a range apart.
fn decimals(r: &Range<f64>) -> usize {
    let span = r.end - r.start;
    let mut step = span / 10.0;
    let mut n = 0;
    while step < 0.99 && n < 12 {
        step *= 10.0;
        n += 1;
    }
    n
}

fn number(v: f64, decimals: usize) -> String {
    let big = v.abs() >= 1e7;
    if big || (decimals > 6 && v != 0.0) {
        return format!("{v:.3e}");
    }
    let v = if v.abs() < 1e-12 { 0.0 } else { v };
    format!("{v:.decimals$}")
}

/// Gives the plotting library the embedded font, once.
fn use_font() -> Result<()> {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for style in [FontStyle::Normal, FontStyle::Bold] {
            // Only a broken font file fails here; drawing then names the font it lacks.
            let _ = register_font("sans-serif", style, text::font_bytes());
        }
    });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn falling() -> Plot {
        let y = |t: f64| 5.0 - 4.905 * t * t;
        let times = || (0..=60).map(|i| f64::from(i) / 60.0);
        Plot {
            title: "Free fall".into(),
            y_label: "height (m)".into(),
            series: vec![
                Series {
                    name: "engine".into(),
                    points: times().map(|t| [t, y(t)]).collect(),
                    ..Series::default()
                },
                Series {
                    name: "½ g t²".into(),
                    points: times().map(|t| [t, y(t) + 0.2]).collect(),
                    style: Style::Dashed,
                    color: None,
                },
            ],
            ..Plot::default()
        }
    }

    #[test]
    fn svg_holds_every_word() {
        let svg = falling().svg().expect("plot");
        for word in ["Free fall", "time (s)", "height (m)", "engine", "½ g t²"] {
            assert!(svg.contains(word), "{word}");
        }
        assert!(svg.contains("#0072B2") && svg.contains("#D55E00"));
    }

    #[test]
    fn picture_holds_both_curves_and_text() {
        let image = falling().image().expect("plot");
        let count = |want: [u8; 3]| {
            image.pixels().iter().filter(|p| (0..3).all(|k| p[k].abs_diff(want[k]) < 30)).count()
        };
        assert!(count([0x00, 0x72, 0xB2]) > 500);
        assert!(count([0xD5, 0x5E, 0x00]) > 300);
        assert!(count([40, 48, 60]) > 300, "text");
    }

    #[test]
    fn small_diagrams_keep_their_letters() {
        let small = Plot { width: 320, height: 180, ..falling() };
        let image = small.image().expect("plot");
        let dark = image.pixels().iter().filter(|p| p.iter().all(|&c| c < 110)).count();
        assert!(dark > 80, "{dark}");
        // Letters of 10 pixels, where full size has 14 and more.
        let svg = small.svg().expect("plot");
        let sizes =
            svg.split("font-size=\"").skip(1).filter_map(|s| s.split('"').next()?.parse::<f64>().ok());
        let sizes: Vec<f64> = sizes.collect();
        assert!(!sizes.is_empty() && sizes.iter().all(|s| (7.0..12.0).contains(s)), "{sizes:?}");
    }

    #[test]
    fn odd_data_is_no_panic() {
        let with = |points: Vec<[f64; 2]>| Plot {
            series: vec![Series { name: "a".into(), points, ..Series::default() }],
            ..Plot::default()
        };
        let log = |points: Vec<[f64; 2]>| Plot { log_y: true, ..with(points) };
        assert!(log(vec![[0.0, -1.0], [1.0, 0.0]]).svg().is_err());
        assert!(log(vec![[0.0, 3.0], [1.0, 0.0], [2.0, 3.0]]).svg().is_ok());
        assert!(log(vec![[0.0, 1e-300], [1.0, 1e300], [2.0, f64::NAN]]).svg().is_ok());
        assert!(log(vec![[0.0, 5e-324], [1.0, f64::MAX]]).svg().is_ok());
        assert!(with(vec![]).svg().is_err());
        assert!(with(vec![[f64::NAN, 1.0]]).svg().is_err());
        assert!(with(vec![[0.0, 1.0]]).svg().is_ok());
        assert!(with(vec![[0.0, 1.0], [1.0, 1.0]]).svg().is_ok());
        assert!(with(vec![[0.0, 1e300], [1.0, -1e300]]).svg().is_ok());
        assert!(with(vec![[0.0, 1e-300], [1e-9, 2e-300], [f64::INFINITY, 0.0]]).svg().is_ok());
    }
}
