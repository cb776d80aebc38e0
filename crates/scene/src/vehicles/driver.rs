//! A driver who follows a line.
//!
//! Pure pursuit (Coulter 1992): the circle that leaves the vehicle along its heading and goes through a point L ahead on the line has
//! the curvature κ = 2 x/L², x the point's distance aside. Front wheels steer for it by δ = atan(κ l), l the wheelbase; tracks by the
//! difference of their speeds κ v b, b their distance. The speed is the least of √(v_k² + 2 a d_k) over what is ahead: parts of
//! speed v_k that begin after d_k, a the deceleration counted on.

use crate::error::{Checked, Wrong};
use crate::spec::RouteSpec;
use jounce::limits::{POSITION_MAX, SPEED_MAX};
use jounce::math::scalar::{f32s, f64s};
use jounce::math::{DVec3, Vec3};
use jounce::{VehicleDesc, VehicleId, VehicleInput, World};

/// Most corners of a line.
const POINTS_MAX: usize = 4096;
/// How far the nearest point is looked for in a step, and in which pieces, m.
const STRIDE: f64 = 0.25;
const STRIDES_MAX: usize = 400;
/// Throttle and brake per error in speed, s/m.
const THROTTLE: f32 = 0.4;
const BRAKE: f32 = 0.25;
/// Throttle per error in speed and time, 1/m: what holds the speed against all that resists.
const CRUISE: f32 = 0.15;

/// A line to follow, and how.
#[derive(Clone, Debug)]
pub(crate) struct Route {
    /// Corners; of a closed line the first once more at the end.
    points: Vec<DVec3>,
    /// Way to each corner, m.
    ways: Vec<f64>,
    /// From each corner on, m/s.
    speeds: Vec<f64>,
    closed: bool,
    look: [f64; 2],
    deceleration: f64,
    steer: Steering,
}

/// How curvature becomes steering.
#[derive(Clone, Copy, Debug)]
enum Steering {
    /// Wheelbase, m, and largest angle, rad.
    Wheels { base: f32, most: f32 },
    /// Difference of speeds at full steering over the tracks' distance, m/s per m.
    Tracks(f32),
}

impl Route {
    pub(crate) fn new(s: &RouteSpec, d: &VehicleDesc) -> Checked<Self> {
        let n = s.points.len();
        if !(2..=POINTS_MAX).contains(&n) {
            return Err(Wrong::new(format!("has {n} points"), "2 to 4096 points").key("points"));
        }
        let mut points: Vec<DVec3> = Vec::with_capacity(n + 1);
        for (i, p) in s.points.iter().enumerate() {
            if p.iter().any(|x| x.abs() > POSITION_MAX) {
                return Err(Wrong::new(format!("is {p:?}"), "within ±1e9 m").index(i).key("points"));
            }
            points.push(DVec3::from_array(*p));
        }
        let closed = s.closed.unwrap_or(false);
        if closed {
            points.push(points[0]);
        }
        let mut ways = vec![0.0];
        for (i, w) in points.windows(2).enumerate() {
            let l = (w[1] - w[0]).length();
            if l < 1e-3 {
                let expected = "points at least 1 mm apart";
                return Err(Wrong::new("is where its neighbour is", expected)
                    .index((i + 1) % n)
                    .key("points"));
            }
            ways.push(ways[i] + l);
        }
        let parts = points.len() - 1;
        let speeds: Vec<f32> = match (&s.speed, &s.speeds) {
            (Some(v), None) => vec![*v; parts],
            (None, Some(all)) if all.len() == parts => all.clone(),
            (None, Some(all)) => {
                let message = format!("has {} speeds", all.len());
                return Err(
                    Wrong::new(message, format!("{parts}, one for each part of the line")).key("speeds")
                );
            }
            (Some(_), Some(_)) => {
                return Err(Wrong::new("is given beside `speed`", "speed or speeds, not both").key("speeds"));
            }
            (None, None) => return Err(Wrong::new("the key `speed` is missing", "speed or speeds, m/s")),
        };
        if let Some((i, v)) = speeds.iter().enumerate().find(|(_, v)| !(**v > 0.0 && **v <= SPEED_MAX)) {
            let wrong = Wrong::new(format!("is {v}"), "above 0, at most 1e5 m/s");
            return Err(if s.speed.is_some() { wrong.key("speed") } else { wrong.index(i).key("speeds") });
        }
        let positive = |v: Option<f32>, otherwise: f32, low: f32, key: &str| {
            let v = v.unwrap_or(otherwise);
            if !(low..=1e4).contains(&v) {
                return Err(Wrong::new(format!("is {v}"), format!("{low} to 10000")).key(key));
            }
            Ok(f64::from(v))
        };
        Ok(Self {
            points,
            ways,
            speeds: speeds.into_iter().map(f64::from).collect(),
            closed,
            look: [
                positive(s.look_ahead, 4.0, 0.1, "look_ahead")?,
                positive(s.look_ahead_s, 0.35, 0.0, "look_ahead_s")?,
            ],
            deceleration: positive(s.deceleration, 4.0, 0.01, "deceleration")?,
            steer: steering(d)?,
        })
    }

    fn length(&self) -> f64 {
        self.ways[self.ways.len() - 1]
    }
    /// The part that a way lies in, and the way within the line.
    fn part(&self, s: f64) -> (usize, f64) {
        let l = self.length();
        let s = if self.closed { s - l * (s / l).floor() } else { f64s::clamp(s, 0.0, l) };
        (self.ways.partition_point(|w| *w <= s).clamp(1, self.points.len() - 1) - 1, s)
    }
    fn at(&self, s: f64) -> DVec3 {
        let (i, s) = self.part(s);
        let t = (s - self.ways[i]) / (self.ways[i + 1] - self.ways[i]);
        self.points[i] + (self.points[i + 1] - self.points[i]) * t
    }
    /// The speed at a way, with what is ahead in mind.
    fn speed(&self, s: f64) -> f64 {
        let (i, at) = self.part(s);
        let mut v = self.speeds[i];
        let parts = self.speeds.len();
        let (mut ahead, mut n) = (self.ways[i + 1] - at, i);
        // What needs more way to brake for than the speed asked for here has is no matter yet.
        let reach = v * v / (2.0 * self.deceleration);
        for _ in 0..parts {
            n += 1;
            if n == parts && !self.closed {
                return f64s::min(v, (2.0 * self.deceleration * f64s::max(ahead, 0.0)).sqrt());
            }
            n %= parts;
            if ahead > reach {
                break;
            }
            v = f64s::min(v, (self.speeds[n] * self.speeds[n] + 2.0 * self.deceleration * ahead).sqrt());
            ahead += self.ways[n + 1] - self.ways[n];
        }
        v
    }
}

fn steering(d: &VehicleDesc) -> Checked<Steering> {
    let along = |p: Vec3| p.dot(d.forward);
    let steered: Vec<_> = d.wheels.iter().filter(|w| w.steer != 0.0).collect();
    if !steered.is_empty() {
        let rest: Vec<_> = d.wheels.iter().filter(|w| w.steer == 0.0).collect();
        let mean = |w: &[&jounce::WheelDesc]| {
            w.iter().map(|w| along(w.position)).sum::<f32>() / f32s::max(w.len() as f32, 1.0)
        };
        let front = steered.iter().filter(|w| w.steer > 0.0).map(|w| w.steer).fold(0.0, f32s::max);
        let base = mean(&steered) - mean(&rest);
        if !rest.is_empty() && base > 0.05 && front > 0.0 {
            return Ok(Steering::Wheels { base, most: front });
        }
    } else if let Some(t) = &d.track_steer {
        let (l, r) = (&d.wheels[t.left], &d.wheels[t.right]);
        let across = d.up.cross(d.forward);
        let apart = (l.position - r.position).dot(across).abs();
        let most = t.speed * 0.5 * (l.radius + r.radius);
        if apart > 1e-3 && most > 0.0 {
            return Ok(Steering::Tracks(most / apart));
        }
    }
    Err(Wrong::new("the vehicle is not one that follows a line", "front wheels that steer, or tracks"))
}

/// A driver on the way.
#[derive(Clone, Debug)]
pub(crate) struct Driver {
    pub vehicle: VehicleId,
    /// Number of the entry, whose route it is.
    pub entry: usize,
    /// How far along the line the nearest point is, m; of a closed line laps add up.
    pub way: f64,
    /// Throttle that holds the speed.
    pub hold: f32,
}

impl Driver {
    /// Looks on, and says what to do.
    pub(crate) fn drive(&mut self, route: &Route, world: &World) -> Option<VehicleInput> {
        let v = world.vehicle(self.vehicle).ok()?;
        let pose = world.body(v.chassis()).ok()?.pose();
        let d = v.desc();
        let from = |s: f64| (route.at(s) - pose.p).length();
        let mut best = from(self.way);
        for _ in 0..STRIDES_MAX {
            let next = from(self.way + STRIDE);
            if next >= best || (!route.closed && self.way >= route.length()) {
                break;
            }
            (self.way, best) = (self.way + STRIDE, next);
        }
        let speed = f64::from(v.telemetry().speed);
        let ahead = route.look[0] + route.look[1] * f64s::max(speed, 0.0);
        let target = pose.inverse_transform_point(route.at(self.way + ahead));
        let (x, y) = (target.dot(d.up.cross(d.forward)), target.dot(d.forward));
        let square = f32s::max(x * x + y * y, 1e-6);
        // What is behind is turned to as sharply as can be.
        let curve = if y > 0.0 { 2.0 * x / square } else { if x < 0.0 { -10.0 } else { 10.0 } };
        let steer = match route.steer {
            Steering::Wheels { base, most } => f32s::atan2(curve * base, 1.0) / most,
            Steering::Tracks(most) => curve * f32s::max(speed as f32, 1.0) / most,
        };
        let error = (route.speed(self.way) - speed) as f32;
        let done = !route.closed && self.way >= route.length() - STRIDE;
        // Held back while the pedal is down to the floor, and let go where the brake is needed.
        let wanted = THROTTLE * error + self.hold;
        if error < -1.0 {
            self.hold = 0.0;
        } else if wanted < 1.0 || error < 0.0 {
            self.hold = f32s::clamp(self.hold + CRUISE * error * world.dt() as f32, 0.0, 1.0);
        }
        let brake = if error < -0.5 { f32s::clamp(-BRAKE * (error + 0.5), 0.0, 1.0) } else { 0.0 };
        Some(VehicleInput {
            throttle: if done || brake > 0.0 { 0.0 } else { f32s::clamp(wanted, 0.0, 1.0) },
            brake: if done { 1.0 } else { brake },
            steer: f32s::clamp(-steer, -1.0, 1.0),
            gear: 1,
            ..VehicleInput::default()
        })
    }
}
