//! Aiming through air.
//!
//! In the frame of a target that moves at constant velocity u the target stands still, the wind is w − u and the launch
//! velocity s e − u; so a moving target is no other problem than a fixed one.
//!
//! The direction e has two angles: α in the vertical plane through the target, over the whole circle (beyond 90° the
//! shot goes backwards and the wind brings it home), and β out of this plane. For each α, β is chosen so that the path
//! passes neither left nor right of the target (secant rule). What remains is one number: how far the path passes above
//! the target, where it crosses the vertical plane across the line of sight; or, negative, how far ahead of it the path
//! comes down to its height. The angles at which this changes sign are the shots. Newton's iteration on (α, β, t) then
//! takes each to rounding.

use super::aim::{Miss, Reach, Shot, Target, aim, lead};
use super::air::{Air, Budget, Path, Segment};
use super::roots::golden;
use super::{Event, check_gravity, up};
use crate::error::{Error, Result, check, positive};
use crate::limits::{BISECTIONS_MAX, FLIGHT_STEPS_MAX, FLIGHT_TIME_MAX_S, NEWTON_MAX};
use core::f64::consts::{FRAC_PI_2, TAU};
use jounce_math::scalar::f64s::{atan2, cos, max, sin};
use jounce_math::{DMat3, DVec3};

/// Angles that are tried on the circle, one every two degrees.
const TRIES: usize = 180;

/// All shots of `speed` in m/s through `air` that meet a target, fixed or of constant velocity, the earliest first.
///
/// `air.spin` is kept as it is for every direction. What cannot be reached is answered with the nearest approach; how
/// fast a shot would have to be is not known in air.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::ballistics::{aim_in_air, Air, Target};
/// // The football of the range above, 40 m: flat and steep.
/// let air = Air::ball(0.43, 0.11, 0.25, 1.2)?;
/// let target = Target::fixed(DVec3::X * 40.0);
/// let shots = aim_in_air(&target, 30.0, DVec3::Y * -9.81, &air)?.yes().expect("near enough");
/// assert_eq!(shots.len(), 2);
/// assert!(shots[0].angle.to_degrees() < 25.0 && shots[1].angle.to_degrees() > 60.0);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// [`Error::BadValue`] for a target at the launch, a speed not above 0, no gravity or an air that is not usable,
/// [`Error::Unsupported`] for a target that accelerates, [`Error::Failed`] where the paths turn too fast to be searched
/// within [`SEARCH_STEPS_MAX`](crate::limits::SEARCH_STEPS_MAX).
pub fn aim_in_air(target: &Target, speed: f64, gravity: DVec3, air: &Air) -> Result<Reach<Vec<Shot>>> {
    positive("projectile", "speed", speed)?;
    check_gravity(gravity)?;
    target.check()?;
    air.check()?;
    if target.acceleration != DVec3::ZERO {
        return Err(Error::Unsupported {
            what: "aim_in_air",
            advice: "the target accelerates; give one of constant velocity, or aim in vacuum with lead",
        });
    }
    let range = Range::new(target, speed, gravity, air)?;
    let mut shots = range.seeds(target)?;
    let scan = range.scan()?;
    for (alpha, beta) in range.turns(&scan)? {
        shots.extend(range.polish(alpha, beta, None)?);
    }
    shots.sort_by(|a, b| a.time.total_cmp(&b.time));
    let same = |a: &mut Shot, b: &mut Shot| {
        (a.velocity - b.velocity).length() < 1e-6 * speed
            && (a.time - b.time).abs() < 1e-6 * max(a.time, 1e-9)
    };
    shots.dedup_by(same);
    if shots.is_empty() { Ok(Reach::No(range.nearest(&scan)?)) } else { Ok(Reach::Yes(shots)) }
}

/// Where a path passes the target.
#[derive(Clone, Copy, Debug)]
struct Pass {
    /// Above it, m, or, negative, below or ahead of it.
    over: f64,
    /// To its side, m.
    side: f64,
}

/// One direction of the scan, with the β that goes with it.
#[derive(Clone, Copy, Debug)]
struct Try {
    alpha: f64,
    beta: f64,
    over: f64,
}

/// The problem in the frame of the target.
struct Range {
    air: Air,
    gravity: DVec3,
    speed: f64,
    /// Velocity of the launcher in this frame: −u.
    carrier: DVec3,
    /// The target.
    to: DVec3,
    /// Its distance, its horizontal distance and its height.
    far: f64,
    across: f64,
    height: f64,
    /// Farther away than any path that comes back: twenty times the target and the range in vacuum.
    beyond: f64,
    forward: DVec3,
    up: DVec3,
    left: DVec3,
    budget: Budget,
}

impl Range {
    fn new(target: &Target, speed: f64, gravity: DVec3, air: &Air) -> Result<Self> {
        let up = up(gravity);
        let height = target.position.dot(up);
        let flat = target.position - up * height;
        let far = target.position.length();
        let fastest = speed + target.velocity.length();
        check((far * far).is_finite(), "target", "position", target.position.to_array(), "a nearer point")?;
        // A bearing within rounding of straight up or down is none.
        let across = if flat.length() > 1e-9 * far { flat.length() } else { 0.0 };
        let forward = if across > 0.0 { flat / across } else { up.orthonormal_basis().0 };
        Ok(Self {
            air: air.with_wind(air.wind - target.velocity),
            gravity,
            speed,
            carrier: -target.velocity,
            to: target.position,
            far,
            across,
            height,
            beyond: 20.0 * (far + fastest * fastest / gravity.length()),
            forward,
            up,
            left: up.cross(forward),
            budget: Budget::new(),
        })
    }

    fn direction(&self, alpha: f64, beta: f64) -> DVec3 {
        (self.forward * cos(alpha) + self.up * sin(alpha)) * cos(beta) + self.left * sin(beta)
    }

    fn path(&self, alpha: f64, beta: f64) -> Result<Path<'_>> {
        let velocity = self.direction(alpha, beta) * self.speed + self.carrier;
        Path::new(&self.air, DVec3::ZERO, velocity, self.gravity)
    }

    /// True where a path was blown away from the target for good.
    fn is_gone(&self, e: &Event) -> bool {
        let away = e.position - self.to;
        away.length() > self.beyond && away.dot(e.velocity) > 0.0
    }

    /// True where a path has come down below the target for good, or is gone.
    fn is_past(&self, e: &Event) -> bool {
        if self.is_gone(e) {
            return true;
        }
        let below = self.height - e.position.dot(self.up);
        // Lift may bring it up again; not from as deep as the target is far.
        let enough = if self.air.lifts() || self.air.wind.dot(self.up) > 0.0 { 2.0 * self.far } else { 0.0 };
        below > enough && e.velocity.dot(self.up) < 0.0
    }

    /// Follows a path until it crosses the plane of the target, or comes down to its height.
    fn pass(&self, alpha: f64, beta: f64) -> Result<Option<Pass>> {
        let mut path = self.path(alpha, beta)?;
        let ahead = |e: &Event| self.across - e.position.dot(self.forward);
        let above = |e: &Event| e.position.dot(self.up) - self.height;
        let side = |e: &Event| e.position.dot(self.left);
        for _ in 0..FLIGHT_STEPS_MAX {
            if self.is_past(&path.now()) {
                let e = path.now();
                return Ok(Some(Pass { over: -ahead(&e).abs(), side: side(&e) }));
            }
            let segment = path.step_within(FLIGHT_TIME_MAX_S, &self.budget)?;
            let crossed = segment.falls(ahead);
            let fallen = segment.falls(above);
            match (crossed, fallen) {
                (Some(c), f) if f.is_none_or(|f| c.time <= f.time) => {
                    return Ok(Some(Pass { over: above(&c), side: side(&c) }));
                }
                (_, Some(f)) => return Ok(Some(Pass { over: -ahead(&f), side: side(&f) })),
                _ => {}
            }
            if path.now().time >= FLIGHT_TIME_MAX_S {
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// Chooses β so that the path passes neither left nor right.
    fn straighten(&self, alpha: f64, guess: f64) -> Result<Option<Try>> {
        let Some(mut pass) = self.pass(alpha, guess)? else { return Ok(None) };
        let (mut beta, mut before) = (guess, None::<(f64, f64)>);
        for _ in 0..16 {
            if pass.side.abs() <= 1e-10 * self.far {
                return Ok(Some(Try { alpha, beta, over: pass.over }));
            }
            let slope = match before {
                Some((b, s)) if s != pass.side && b != beta => (pass.side - s) / (beta - b),
                _ => self.far,
            };
            let next = beta - pass.side / slope;
            if !next.is_finite() || next.abs() > FRAC_PI_2 {
                return Ok(None);
            }
            before = Some((beta, pass.side));
            let Some(p) = self.pass(alpha, next)? else { return Ok(None) };
            (beta, pass) = (next, p);
        }
        Ok(None)
    }

    /// The whole circle, from straight down over forward, up and backward.
    fn scan(&self) -> Result<Vec<Option<Try>>> {
        let mut found = Vec::with_capacity(TRIES + 1);
        if self.across == 0.0 {
            return Ok(found);
        }
        // What the carrier drifts sideways has to be made up for.
        let drift = self.carrier.dot(self.left) / self.speed;
        let mut guess = if drift.abs() < 1.0 { -atan2(drift, (1.0 - drift * drift).sqrt()) } else { 0.0 };
        for i in 0..=TRIES {
            let alpha = -FRAC_PI_2 + TAU * i as f64 / TRIES as f64;
            let it = self.straighten(alpha, guess)?;
            guess = it.map_or(guess, |t| t.beta);
            found.push(it);
        }
        Ok(found)
    }

    /// Directions at which the path turns from passing below to passing above or back.
    fn turns(&self, scan: &[Option<Try>]) -> Result<Vec<(f64, f64)>> {
        let mut found = Vec::new();
        for pair in scan.windows(2) {
            if let [Some(a), Some(b)] = pair
                && (a.over < 0.0) != (b.over < 0.0)
            {
                found.extend(self.between(*a, *b)?);
            }
        }
        if found.is_empty()
            && let Some(best) = self.highest(scan)?
        {
            // Both shots lie between two directions of the scan: near the end of the reach.
            let step = TAU / TRIES as f64;
            for end in [best.alpha - step, best.alpha + step] {
                if let Some(t) = self.straighten(end, best.beta)?
                    && t.over < 0.0
                {
                    found.extend(self.between(t, best)?);
                }
            }
        }
        Ok(found)
    }

    /// The direction between two whose paths pass on different sides.
    fn between(&self, mut a: Try, mut b: Try) -> Result<Option<(f64, f64)>> {
        for _ in 0..BISECTIONS_MAX {
            if (b.alpha - a.alpha).abs() < 1e-7 {
                break;
            }
            let Some(mid) = self.straighten(0.5 * (a.alpha + b.alpha), 0.5 * (a.beta + b.beta))? else {
                return Ok(None);
            };
            if (mid.over < 0.0) == (a.over < 0.0) {
                a = mid;
            } else {
                b = mid;
            }
        }
        Ok(Some((0.5 * (a.alpha + b.alpha), 0.5 * (a.beta + b.beta))))
    }

    /// The direction that passes highest, where one passes above though none of the scan does.
    fn highest(&self, scan: &[Option<Try>]) -> Result<Option<Try>> {
        let tries = scan.iter().flatten();
        let Some(best) = tries.copied().reduce(|a, b| if b.over > a.over { b } else { a }) else {
            return Ok(None);
        };
        let step = TAU / TRIES as f64;
        let over = |alpha: f64| self.straighten(alpha, best.beta);
        let alpha = golden(best.alpha - step, best.alpha + step, |alpha| {
            over(alpha).map(|t| t.map_or(f64::INFINITY, |t| -t.over))
        })?;
        Ok(over(alpha)?.filter(|t| t.over >= 0.0))
    }

    /// Newton's iteration from a direction to the shot itself; none where it does not meet the target. A first guess of
    /// the time is the moment of the nearest approach.
    fn polish(&self, alpha: f64, beta: f64, time: Option<f64>) -> Result<Option<Shot>> {
        let mut time = match time {
            Some(t) => t,
            None => self.closest(alpha, beta)?.time,
        };
        let (mut alpha, mut beta) = (alpha, beta);
        let mut last = f64::INFINITY;
        for _ in 0..NEWTON_MAX {
            if !(time > 0.0 && time < FLIGHT_TIME_MAX_S) {
                return Ok(None);
            }
            let here = self.at(alpha, beta, time)?;
            let off = here.position - self.to;
            let left = off.length();
            if left <= 1e-9 * self.far && left >= 0.5 * last {
                break;
            }
            last = left;
            // Differences of 1e-6 rad: their error is quadratic, and Newton corrects for the rest.
            let d = 1e-6;
            let by_alpha = (self.at(alpha + d, beta, time)?.position - here.position) / d;
            let by_beta = (self.at(alpha, beta + d, time)?.position - here.position) / d;
            let change = DMat3::from_columns(by_alpha, by_beta, here.velocity).solve(off);
            if !change.is_finite() || change == DVec3::ZERO {
                break;
            }
            // Not further than a guess is worth.
            let part = 1.0 / max(1.0, max(change.x.abs(), change.y.abs()) / 0.3);
            (alpha, beta, time) = (alpha - part * change.x, beta - part * change.y, time - part * change.z);
        }
        if last <= 1e-6 * self.far {
            Ok(Some(Shot::new(self.direction(alpha, beta) * self.speed, self.up, time)))
        } else {
            Ok(None)
        }
    }

    fn at(&self, alpha: f64, beta: f64, time: f64) -> Result<Event> {
        let mut path = self.path(alpha, beta)?;
        for _ in 0..FLIGHT_STEPS_MAX {
            if path.now().time >= time {
                break;
            }
            path.step_within(time, &self.budget)?;
        }
        Ok(path.now())
    }

    /// Shots from guesses: those of the vacuum, and, for a target straight above or below, those straight up and down.
    fn seeds(&self, target: &Target) -> Result<Vec<Shot>> {
        let mut found = Vec::new();
        if self.across > 0.0 {
            return Ok(found);
        }
        let vacuum = if target.velocity == DVec3::ZERO {
            aim(target.position, self.speed, self.gravity)?.yes().map(|s| vec![s.low, s.high])
        } else {
            lead(target, self.speed, self.gravity)?.yes()
        };
        for shot in vacuum.unwrap_or_default() {
            let e = shot.velocity / self.speed;
            let beta = atan2(e.dot(self.left), (e - self.left * e.dot(self.left)).length());
            let alpha = atan2(e.dot(self.up), e.dot(self.forward));
            found.extend(self.polish(alpha, beta, Some(shot.time))?);
        }
        for alpha in [FRAC_PI_2, -FRAC_PI_2] {
            let mut path = self.path(alpha, 0.0)?;
            let above = |e: &Event| e.position.dot(self.up) - self.height;
            let mut times = Vec::new();
            for _ in 0..FLIGHT_STEPS_MAX {
                let s = path.step_within(FLIGHT_TIME_MAX_S, &self.budget)?;
                times.extend(s.falls(|e| -above(e)).map(|e| e.time));
                times.extend(s.falls(above).map(|e| e.time));
                if self.is_past(&path.now()) || path.now().time >= FLIGHT_TIME_MAX_S {
                    break;
                }
            }
            for t in times {
                found.extend(self.polish(alpha, 0.0, Some(t))?);
            }
        }
        Ok(found)
    }

    /// The moment at which a path is nearest to the target.
    fn closest(&self, alpha: f64, beta: f64) -> Result<Event> {
        let mut path = self.path(alpha, beta)?;
        let distance = |e: &Event| (e.position - self.to).length();
        let mut best = path.now();
        for _ in 0..FLIGHT_STEPS_MAX {
            let segment = path.step_within(FLIGHT_TIME_MAX_S, &self.budget)?;
            let e = nearest_of(&segment, distance);
            if distance(&e) < distance(&best) {
                best = e;
            }
            let now = path.now();
            let below = self.height - now.position.dot(self.up);
            let deep = below > distance(&best) && now.velocity.dot(self.up) < 0.0;
            if (deep && self.is_past(&now)) || self.is_gone(&now) || now.time >= FLIGHT_TIME_MAX_S {
                break;
            }
        }
        Ok(best)
    }

    /// The shot that comes nearest to what cannot be reached.
    fn nearest(&self, scan: &[Option<Try>]) -> Result<Miss> {
        let left = |alpha: f64, beta: f64| Ok((self.closest(alpha, beta)?.position - self.to).length());
        let mut best = (f64::INFINITY, FRAC_PI_2, 0.0);
        let straight = [(FRAC_PI_2, 0.0), (-FRAC_PI_2, 0.0)];
        for (alpha, beta) in scan.iter().flatten().map(|t| (t.alpha, t.beta)).chain(straight) {
            let it = left(alpha, beta)?;
            if it < best.0 {
                best = (it, alpha, beta);
            }
        }
        let (_, mut alpha, mut beta) = best;
        // One angle after the other, twice: they hardly depend on each other.
        let step = TAU / TRIES as f64;
        for _ in 0..2 {
            alpha = golden(alpha - step, alpha + step, |alpha| left(alpha, beta))?;
            beta = golden(beta - step, beta + step, |beta| left(alpha, beta))?;
        }
        let e = self.closest(alpha, beta)?;
        Ok(Miss {
            distance: (e.position - self.to).length(),
            shot: Shot::new(self.direction(alpha, beta) * self.speed, self.up, e.time),
            // Seen from the launcher and not from the target.
            closest: e.position - self.carrier * e.time,
            speed_needed: None,
        })
    }
}

/// The nearest moment of one step.
fn nearest_of(segment: &Segment, distance: impl Fn(&Event) -> f64) -> Event {
    const LOOKS: u32 = 8;
    let part = (segment.end() - segment.start()) / f64::from(LOOKS);
    let place = |i: u32| segment.at(segment.start() + part * f64::from(i));
    let best = (0..=LOOKS).map(place).reduce(|a, b| if distance(&b) < distance(&a) { b } else { a });
    let middle = best.map_or(segment.start(), |e| e.time);
    let (a, b) = (max(middle - part, segment.start()), middle + part);
    let t = golden(a, b, |t| Ok(distance(&segment.at(t)))).unwrap_or(middle);
    segment.at(t)
}
