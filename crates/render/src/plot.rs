//! Curves over time, as SVG text or as a picture.

use crate::error::{RenderError, Result, encode};
use crate::image::Image;
use crate::text;
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
    /// Name in the legend.
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
        self.draw(&SVGBackend::with_string(&mut out, self.size()?).into_drawing_area())?;
        Ok(out)
    }

    /// The diagram as a picture.
    ///
    /// # Errors
    /// As [`Plot::svg`].
    pub fn image(&self) -> Result<Image> {
        let (w, h) = self.size()?;
        let mut bytes = vec![255_u8; w as usize * h as usize * 3];
        {
            let area = BitMapBackend::with_buffer(&mut bytes, (w, h)).into_drawing_area();
            self.draw(&area)?;
        }
        Image::from_pixels(w, h, bytes.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect())
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
            let factor = (hi / lo).max(2.0).min(1e300).powf(margin) * if hi / lo < 2.0 { 1.5 } else { 1.0 };
            return Ok((lo / factor).max(f64::MIN_POSITIVE)..(hi * factor).min(f64::MAX));
        }
        let span = hi - lo;
        // A constant needs some room, or rounding noise would fill the picture.
        let least = (lo.abs() + hi.abs()) * 1e-6 + 1e-9;
        let pad = if span > least { span * margin } else { (lo.abs() * 0.1).max(0.5 * least + 1e-3) };
        Ok(lo - pad..hi + pad)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<()> {
        use_font()?;
        let fail = |e: DrawingAreaErrorKind<B::ErrorType>| encode("plot", e);
        let (x, y) = (self.range(0, 0.0)?, self.range(1, 0.06)?);
        let x = if x.end > x.start { x } else { x.start - 0.5..x.end + 0.5 };
        area.fill(&WHITE).map_err(fail)?;
        if self.log_y {
            self.chart(area, x, y.log_scale(), &power)?;
        } else {
            let digits = decimals(&y);
            self.chart(area, x, y, &|v| number(*v, digits))?;
        }
        area.present().map_err(fail)
    }

    fn chart<B: DrawingBackend, Y>(
        &self,
        area: &DrawingArea<B, Shift>,
        x: Range<f64>,
        y: Y,
        y_label: &dyn Fn(&f64) -> String,
    ) -> Result<()>
    where
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        let fail = |e: DrawingAreaErrorKind<B::ErrorType>| encode("plot", e);
        let font = |size: i32| ("sans-serif", size).into_font().color(&INK);
        let x_digits = decimals(&x);
        let mut builder = ChartBuilder::on(area);
        builder.margin(14).margin_right(26).x_label_area_size(46).y_label_area_size(78);
        if !self.title.is_empty() {
            builder.caption(&self.title, font(20));
        }
        let mut chart = builder.build_cartesian_2d(x, y).map_err(fail)?;
        chart
            .configure_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_labels(10)
            .y_labels(8)
            .x_label_formatter(&|v| number(*v, x_digits))
            .y_label_formatter(y_label)
            .label_style(font(14))
            .axis_desc_style(font(15))
            .axis_style(ShapeStyle::from(&RGBColor(120, 128, 140)).stroke_width(1))
            .bold_line_style(RGBColor(222, 226, 232))
            .light_line_style(RGBColor(243, 245, 248))
            .max_light_lines(4)
            .draw()
            .map_err(fail)?;
        self.curves(&mut chart)?;
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .margin(10)
            .legend_area_size(32)
            .label_font(font(15))
            .background_style(WHITE.mix(0.88))
            .border_style(RGBColor(205, 210, 218))
            .draw()
            .map_err(fail)
    }

    fn curves<'a, B: DrawingBackend + 'a, Y: Ranged<ValueType = f64>>(
        &self,
        chart: &mut ChartContext<'a, B, Cartesian2d<RangedCoordf64, Y>>,
    ) -> Result<()> {
        let fail = |e: DrawingAreaErrorKind<B::ErrorType>| encode("plot", e);
        for (i, s) in self.series.iter().enumerate() {
            let c = color(s.color.unwrap_or(i));
            let line = c.stroke_width(2);
            match s.style {
                Style::Dots => {
                    let dots = self.runs(&s.points).flatten();
                    chart
                        .draw_series(dots.map(|p| Circle::new((p[0], p[1]), 2, c.filled())))
                        .map_err(fail)?
                        .label(&s.name)
                        .legend(move |(x, y)| Circle::new((x + 12, y), 3, c.filled()));
                }
                Style::Solid | Style::Dashed => {
                    let dashed = s.style == Style::Dashed;
                    let mut named = false;
                    for run in self.runs(&s.points) {
                        let points = run.iter().map(|p| (p[0], p[1]));
                        let drawn = if dashed {
                            chart.draw_series(DashedLineSeries::new(points, 7, 5, line)).map_err(fail)?
                        } else {
                            chart.draw_series(LineSeries::new(points, line)).map_err(fail)?
                        };
                        if !std::mem::replace(&mut named, true) {
                            drawn.label(&s.name).legend(move |(x, y)| {
                                let end = if dashed { x + 9 } else { x + 24 };
                                let second = if dashed { x + 15 } else { x };
                                let parts = [[(x, y), (end, y)], [(second, y), (x + 24, y)]];
                                let element = EmptyElement::at((0, 0));
                                element + PathElement::new(parts[0], line) + PathElement::new(parts[1], line)
                            });
                        }
                    }
                }
            }
        }
        Ok(())
    }
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
