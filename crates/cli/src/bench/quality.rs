//! How well a scene stands after its last step: the figures that the other engines' programs read too
//! (`bench/shared/scenes.rs`), under the same names.

use jounce::{BodyKind, World};
use std::collections::BTreeMap;

/// Figures by name: heights in metres, speeds in m/s, sink in millimetres.
pub(crate) type Figures = BTreeMap<String, f64>;

/// What is read of a scene.
#[derive(Clone, Copy)]
pub(crate) enum Quality {
    /// One pile, whose last body is its top.
    Top,
    /// Piles of so many bodies each, of which the last is the top.
    Tops(usize),
    /// Bodies that lie or hang anywhere.
    Heights,
    /// A cube on a cube.
    Sink,
}

impl Quality {
    /// The figures that the table shows.
    pub fn shown(self) -> &'static [&'static str] {
        match self {
            Self::Top => &["top_y"],
            Self::Tops(_) => &["top_y_lowest"],
            Self::Heights => &["lowest_y", "mean_y"],
            Self::Sink => &["sink_light_mm", "sink_heavy_mm"],
        }
    }

    /// Reads all figures of a world, without those that nothing gives where nothing moves.
    pub fn read(self, world: &World) -> Figures {
        let (heights, speed_max) = moving(world);
        let mut figures = self.of(&heights);
        figures.push(("speed_max", speed_max));
        figures.retain(|(_, v)| v.is_finite());
        figures.into_iter().map(|(name, v)| (name.to_owned(), v)).collect()
    }

    fn of(self, heights: &[f64]) -> Vec<(&'static str, f64)> {
        let last = |all: &[f64]| all.last().copied().unwrap_or(f64::NAN);
        match self {
            Self::Top => vec![("top_y", last(heights)), ("mean_y", mean(heights))],
            Self::Tops(bodies) => {
                let tops: Vec<f64> = heights.chunks(bodies).map(last).collect();
                vec![("top_y_lowest", lowest(&tops)), ("top_y_mean", mean(&tops))]
            }
            Self::Heights => vec![
                ("lowest_y", lowest(heights)),
                ("mean_y", mean(heights)),
                ("highest_y", heights.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
            ],
            Self::Sink => {
                let sink = |i: usize, ideal: f64| (ideal - heights.get(i).copied().unwrap_or(f64::NAN)) * 1e3;
                vec![("sink_light_mm", sink(0, 0.5)), ("sink_heavy_mm", sink(1, 1.5))]
            }
        }
    }
}

/// Heights of the dynamic bodies in the order of their slots, and the greatest speed of one.
fn moving(world: &World) -> (Vec<f64>, f64) {
    let bodies = world.bodies().filter_map(|b| world.body(b).ok()).filter(|b| b.kind() == BodyKind::Dynamic);
    let each = bodies.map(|b| (b.position().y, f64::from(b.velocity().length())));
    let (heights, speeds): (Vec<f64>, Vec<f64>) = each.unzip();
    (heights, speeds.into_iter().fold(0.0, f64::max))
}

fn lowest(heights: &[f64]) -> f64 {
    heights.iter().copied().fold(f64::INFINITY, f64::min)
}

fn mean(heights: &[f64]) -> f64 {
    heights.iter().sum::<f64>() / heights.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_come_from_the_heights() {
        let heights = [0.5, 1.25, 0.5, 1.5];
        let of = |q: Quality| q.of(&heights);
        assert_eq!(of(Quality::Top), [("top_y", 1.5), ("mean_y", 0.9375)]);
        assert_eq!(of(Quality::Tops(2)), [("top_y_lowest", 1.25), ("top_y_mean", 1.375)]);
        assert_eq!(of(Quality::Heights), [("lowest_y", 0.5), ("mean_y", 0.9375), ("highest_y", 1.5)]);
        assert_eq!(of(Quality::Sink), [("sink_light_mm", 0.0), ("sink_heavy_mm", 250.0)]);
    }

    #[test]
    fn what_the_table_shows_is_read() {
        for q in [Quality::Top, Quality::Tops(1), Quality::Heights, Quality::Sink] {
            let names: Vec<&str> = q.of(&[1.0, 2.0]).into_iter().map(|(name, _)| name).collect();
            assert!(q.shown().iter().all(|s| names.contains(s)), "{:?} of {names:?}", q.shown());
        }
    }
}
