//! Where things have been: lines behind moving points, fading towards their tails.

use crate::extras::{Extras, Rod};
use jounce::math::DVec3;
use std::collections::{BTreeMap, VecDeque};

/// Most points of one trail.
const POINTS_MAX: usize = 1600;
/// Opacity of the young end.
const OPACITY: f32 = 0.9;
/// What is left of opacity and width at the old end of a trail that lasts.
const OLD: f32 = 0.35;

/// Trails of points that are told by numbers, such as [`jounce::BodyId::to_bits`].
///
/// Memory is bounded: a trail that fades keeps points evenly in time; one that lasts drops every second point when it
/// is full, and from then on takes half as many.
///
/// ```
/// use jounce_render::{Extras, Trails};
/// let mut trails = Trails::new(Some(2.0), 0.04);
/// for step in 0..120 {
///     let t = f64::from(step) / 60.0;
///     trails.record(7, t, [t, 5.0 * t - 4.9 * t * t, 0.0], [0.9, 0.3, 0.2]);
/// }
/// let mut extras = Extras::default();
/// trails.add_to(2.0, &mut extras);
/// assert!(extras.rods.len() > 100);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Trails {
    /// How long a point stays, s; `None` for ever.
    seconds: Option<f64>,
    radius: f32,
    paths: BTreeMap<u64, Path>,
}

#[derive(Clone, Debug, PartialEq)]
struct Path {
    color: [f32; 3],
    /// Least time from point to point, s.
    spacing: f64,
    points: VecDeque<(f64, DVec3)>,
    /// Where it is now.
    head: (f64, DVec3),
}

impl Trails {
    /// Trails `width` metres wide that fade within `seconds`, or last.
    pub fn new(seconds: Option<f64>, width: f32) -> Self {
        Self { seconds, radius: width * 0.5, paths: BTreeMap::new() }
    }

    /// Notes where a point is at a time; times of a point must rise. Places that are not finite are passed over.
    pub fn record(&mut self, key: u64, time: f64, at: impl Into<DVec3>, color: [f32; 3]) {
        let at = at.into();
        if !(at.is_finite() && time.is_finite()) {
            return;
        }
        let first = || {
            let spacing = self.seconds.map_or(0.0, |s| s * 1.5 / POINTS_MAX as f64);
            Path { color, spacing, points: VecDeque::from([(time, at)]), head: (time, at) }
        };
        let path = self.paths.entry(key).or_insert_with(first);
        path.head = (time, at);
        path.color = color;
        path.forget(self.seconds.map(|s| time - s));
        let Some(last) = path.points.back_mut() else {
            path.points.push_back((time, at));
            return;
        };
        if (at - last.1).length() < f64::from(self.radius) * 0.25 {
            // It stands still: it is still there.
            last.0 = time;
        } else if time - last.0 >= path.spacing {
            path.points.push_back((time, at));
            if path.points.len() > POINTS_MAX {
                path.thin();
            }
        }
    }

    /// Adds the trails as they look at a time.
    pub fn add_to(&self, now: f64, extras: &mut Extras) {
        for path in self.paths.values() {
            let ends = path.points.iter().chain([&path.head]);
            let start = path.points.front().map_or(now, |p| p.0);
            // Of something that is gone the trail fades where it is.
            let span = self.seconds.unwrap_or(now - start);
            let young = |t: f64| if span > 0.0 { (1.0 - (now - t) / span) as f32 } else { 1.0 };
            let floor = if self.seconds.is_some() { 0.0 } else { OLD };
            for (a, b) in ends.clone().zip(ends.skip(1)) {
                let fresh = young((a.0 + b.0) * 0.5).clamp(0.0, 1.0);
                let left = floor + (1.0 - floor) * fresh;
                if left > 0.0 && a.1 != b.1 {
                    let radius = self.radius * (0.4 + 0.6 * left);
                    extras.rods.push(Rod::new(a.1, b.1, radius, path.color).opacity(OPACITY * left));
                }
            }
        }
    }
}

impl Path {
    /// Drops what is older than a time, but for the point before it.
    fn forget(&mut self, before: Option<f64>) {
        let Some(before) = before else { return };
        while self.points.get(1).is_some_and(|p| p.0 < before) {
            self.points.pop_front();
        }
    }

    /// Drops every second point.
    fn thin(&mut self) {
        let mut n = 0;
        self.points.retain(|_| {
            n += 1;
            n % 2 == 1
        });
        let (first, last) =
            (self.points.front().map_or(0.0, |p| p.0), self.points.back().map_or(0.0, |p| p.0));
        self.spacing = (last - first) / self.points.len() as f64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rods(trails: &Trails, now: f64) -> Vec<Rod> {
        let mut extras = Extras::default();
        trails.add_to(now, &mut extras);
        extras.rods
    }

    #[test]
    fn trails_fade_and_stay_bounded() {
        for seconds in [Some(1.5), None] {
            let mut trails = Trails::new(seconds, 0.1);
            for step in 0..50_000_u32 {
                let t = f64::from(step) / 1000.0;
                trails.record(1, t, [20.0 * t, 0.0, 0.0], [1.0, 0.0, 0.0]);
            }
            let now = 49.999;
            let r = rods(&trails, now);
            assert!(r.len() > POINTS_MAX / 3 && r.len() <= POINTS_MAX + 1, "{}", r.len());
            let last = r.last().expect("some");
            assert!(last.b.x == 20.0 * now && last.opacity > 0.85 && last.radius <= 0.05);
            assert!(r[0].opacity < last.opacity * 0.45, "{}", r[0].opacity);
            let start = seconds.map_or(0.0, |s| now - s);
            assert!((r[0].a.x / 20.0 - start).abs() < 0.02, "{} {start}", r[0].a.x);
            for w in r.windows(2) {
                assert!(w[0].b == w[1].a && w[0].opacity <= w[1].opacity);
            }
            // What is gone fades where it is.
            assert_eq!(rods(&trails, now + 2.0).is_empty(), seconds.is_some());
        }
    }

    #[test]
    fn odd_points_are_no_matter() {
        let mut trails = Trails::new(None, 0.1);
        trails.record(1, 0.0, [f64::NAN, 0.0, 0.0], [0.0; 3]);
        assert!(rods(&trails, 0.0).is_empty());
        for t in 0..10 {
            trails.record(1, f64::from(t), [0.0; 3], [0.0; 3]);
            trails.record(2, f64::from(t), [0.0, f64::INFINITY, 0.0], [0.0; 3]);
        }
        assert!(rods(&trails, 9.0).is_empty(), "what stands still leaves no trail");
        trails.record(1, 10.0, [1.0, 0.0, 0.0], [0.0; 3]);
        assert_eq!(rods(&trails, 10.0).len(), 1);
    }
}
