//! Flight through air: drag, lift of spin, wind.
//!
//! m v′ = m g − b u − c |u| u + F_lift(ω, u), u = v − w.
//!
//! u: velocity relative to the air, m/s; w wind, m/s; b linear drag, kg/s; c quadratic drag, kg/m; ω spin, rad/s, kept
//! through the flight. Followed by Dormand–Prince to 1e-10 of the state; apex and landing are found on its polynomials
//! between the steps.
//!
//! v′ depends on v alone, and drag pulls neighbouring velocities together at λ = (b + c |u|)/m and more. No step is
//! longer than 1/λ, so that stiff drag costs some dozens of steps and no stability; and once v′ has died away v stays
//! for good: the rest of the flight is a straight line, followed in steps of any length.

use super::aim::{Miss, Reach, Shot};
use super::roots::{bisect, golden};
use super::{Event, Projectile, check_gravity, up};
use crate::collide::Plane;
use crate::error::{Error, Result, bad, check, finite_vector, not_negative, positive};
use crate::force;
use crate::integrate::{Dopri5, Options, dense_value};
use crate::limits::{FLIGHT_STEPS_MAX, FLIGHT_TIME_MAX_S, SEARCH_STEPS_MAX};
use core::cell::Cell;
use core::f64::consts::{FRAC_PI_2, PI};
use jounce_math::DVec3;
use jounce_math::scalar::f64s::{clamp, cos, max, min, sin};

/// How spin lifts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Lift {
    /// Not at all.
    #[default]
    None,
    /// k ω × u with this k in kg: [`force::magnus`].
    Factor(f64),
    /// As a sports ball: [`force::ball_magnus`].
    Ball {
        /// Density of the air, kg/m³.
        density: f64,
        /// Radius of the ball, m.
        radius: f64,
    },
}

/// A projectile's mass, and what the air does to it.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::ballistics::Air;
/// use jounce_motion::force::AIR_DENSITY;
/// // A football of .43 kg, 22 cm across, with back spin of 8 turns a second and a head wind.
/// let air = Air::ball(0.43, 0.11, 0.25, AIR_DENSITY)?.with_spin(DVec3::Z * 50.0).with_wind(DVec3::X * -5.0);
/// assert!(air.acceleration(DVec3::X * 30.0).y > 0.0);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// Mass, kg.
    pub mass: f64,
    /// b of linear drag, kg/s: [`force::stokes_coefficient`].
    pub linear: f64,
    /// c of quadratic drag, kg/m: [`force::quadratic_coefficient`].
    pub quadratic: f64,
    /// How spin lifts.
    pub lift: Lift,
    /// Spin, rad/s.
    pub spin: DVec3,
    /// Velocity of the air, m/s.
    pub wind: DVec3,
}

impl Air {
    /// No air at all, for a projectile of any mass.
    pub const VACUUM: Self = Self {
        mass: 1.0,
        linear: 0.0,
        quadratic: 0.0,
        lift: Lift::None,
        spin: DVec3::ZERO,
        wind: DVec3::ZERO,
    };

    /// A ball of `mass` in kg, `radius` in m and this drag coefficient, in air of `density` in kg/m³. It does not spin;
    /// once it does it lifts as a sports ball.
    ///
    /// # Errors
    /// [`Error::BadValue`](crate::Error::BadValue) for a mass or a radius not above 0, or a coefficient or density
    /// below 0.
    pub fn ball(mass: f64, radius: f64, drag_coefficient: f64, density: f64) -> Result<Self> {
        positive("projectile", "mass", mass)?;
        positive("projectile", "radius", radius)?;
        not_negative("projectile", "drag_coefficient", drag_coefficient)?;
        not_negative("air", "density", density)?;
        let quadratic = force::quadratic_coefficient(density, PI * radius * radius, drag_coefficient);
        Ok(Self { mass, quadratic, lift: Lift::Ball { density, radius }, ..Self::VACUUM })
    }

    /// The same with a spin, rad/s.
    pub fn with_spin(self, spin: DVec3) -> Self {
        Self { spin, ..self }
    }

    /// The same in a wind, m/s.
    pub fn with_wind(self, wind: DVec3) -> Self {
        Self { wind, ..self }
    }

    /// Acceleration in m/s² by the air alone, of a projectile that moves at `velocity` in m/s.
    pub fn acceleration(&self, velocity: DVec3) -> DVec3 {
        let u = velocity - self.wind;
        let drag = force::stokes_drag(self.linear, u) + force::quadratic_drag(self.quadratic, u);
        let lift = match self.lift {
            Lift::None => DVec3::ZERO,
            Lift::Factor(k) => force::magnus(k, self.spin, u),
            Lift::Ball { density, radius } => force::ball_magnus(density, radius, self.spin, u),
        };
        (drag + lift) / self.mass
    }

    /// λ, 1/s, at a velocity in m/s: the least rate at which drag brings neighbouring velocities together.
    fn rate(&self, velocity: DVec3) -> f64 {
        (self.linear + self.quadratic * (velocity - self.wind).length()) / self.mass
    }

    pub(super) fn lifts(&self) -> bool {
        self.lift != Lift::None && self.spin != DVec3::ZERO
    }

    pub(super) fn check(&self) -> Result<()> {
        positive("projectile", "mass", self.mass)?;
        not_negative("air", "linear", self.linear)?;
        not_negative("air", "quadratic", self.quadratic)?;
        finite_vector("projectile", "spin", self.spin)?;
        finite_vector("air", "wind", self.wind)?;
        match self.lift {
            Lift::None => Ok(()),
            Lift::Factor(k) => crate::error::finite("air", "lift factor", k),
            Lift::Ball { density, radius } => {
                not_negative("air", "density", density)?;
                positive("projectile", "radius", radius)
            }
        }
    }
}

/// One step of a flight with the state within it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    start: f64,
    length: f64,
    position: [DVec3; 5],
    velocity: [DVec3; 5],
}

impl Segment {
    pub(super) fn at(&self, t: f64) -> Event {
        let part = if self.length > 0.0 { clamp((t - self.start) / self.length, 0.0, 1.0) } else { 0.0 };
        Event {
            time: t,
            position: dense_value(&self.position, part),
            velocity: dense_value(&self.velocity, part),
        }
    }

    pub(super) fn start(&self) -> f64 {
        self.start
    }

    pub(super) fn end(&self) -> f64 {
        self.start + self.length
    }

    /// The first moment at which `f` goes from above 0 to 0 or below. Looks at eight places, so that what dips and
    /// comes up again within an eighth of a step is missed: a step turns by much less than a radian.
    pub(super) fn falls(&self, f: impl Fn(&Event) -> f64) -> Option<Event> {
        const LOOKS: u32 = 8;
        let place = |i: u32| self.start + self.length * f64::from(i) / f64::from(LOOKS);
        let mut before = f(&self.at(self.start));
        for i in 1..=LOOKS {
            let now = f(&self.at(place(i)));
            if before > 0.0 && now <= 0.0 {
                return Some(self.at(bisect(place(i - 1), place(i), true, |t| f(&self.at(t)) > 0.0)));
            }
            before = now;
        }
        None
    }
}

/// What a search may still spend: steps along all its paths together.
#[derive(Debug)]
pub(super) struct Budget(Cell<usize>);

impl Budget {
    pub(super) fn new() -> Self {
        Self(Cell::new(SEARCH_STEPS_MAX))
    }

    fn spend(&self, path: &Path) -> Result<()> {
        let left = self.0.get();
        if left == 0 {
            return Err(Error::Failed {
                what: "search for a shot through air",
                time: path.now().time,
                advice: "it stopped after 400,000 steps along its paths, this far into one of them; give less spin, \
                         or a nearer target",
            });
        }
        self.0.set(left - 1);
        Ok(())
    }
}

/// A projectile under way.
#[derive(Clone, Debug)]
pub(super) struct Path<'a> {
    air: &'a Air,
    gravity: DVec3,
    solver: Dopri5<DVec3>,
    /// Longest step that is allowed at the speed of the launch, s.
    character: f64,
    /// From here on it goes straight on.
    settled: Option<Event>,
}

impl<'a> Path<'a> {
    pub(super) fn new(air: &'a Air, start: DVec3, velocity: DVec3, gravity: DVec3) -> Result<Self> {
        let dt_min = max(min(1e-12, 1e-6 / air.rate(velocity)), f64::MIN_POSITIVE);
        let options = Options { dt_min, ..Options::default() };
        let solver = Dopri5::new(0.0, &[start, velocity], options)?;
        let mut path = Self { air, gravity, solver, character: 0.0, settled: None };
        path.character = path.part_of_turn(velocity);
        Ok(path)
    }

    /// Where the air does next to nothing a step would be as long as the flight, and events would hide in it.
    fn part_of_turn(&self, velocity: DVec3) -> f64 {
        max(0.125 * (velocity.length() + self.air.wind.length()) / self.gravity.length(), 0.01)
    }

    /// One step, not beyond `until`.
    pub(super) fn step(&mut self, until: f64) -> Result<Segment> {
        if let Some(e) = self.settled {
            return Ok(self.straight_on(e, until));
        }
        let (air, gravity) = (self.air, self.gravity);
        let before = self.now();
        let rate = air.rate(before.velocity);
        let longest = min(max(self.character, self.part_of_turn(before.velocity)), 1.0 / rate);
        let near = before.time + longest;
        let until = if near > before.time { min(until, near) } else { until };
        let stepped = self.solver.step(until, &mut |_: f64, y: &[DVec3], dy: &mut [DVec3]| {
            dy[0] = y[1];
            dy[1] = gravity + air.acceleration(y[1]);
        });
        stepped.map_err(|_| Error::Failed {
            what: "flight through air",
            time: before.time,
            advice: "its numbers do not stay finite; give a mass, speed, drag or spin nearer to a real one",
        })?;
        let now = self.now();
        let left = (gravity + air.acceleration(now.velocity)).length();
        // The second term is what the rounding of u makes of it.
        let noise = 8.0 * f64::EPSILON * air.rate(now.velocity) * (now.velocity.length() + air.wind.length());
        if left <= 1e-12 * gravity.length() + noise {
            self.settled = Some(now);
        }
        let start = self.solver.time_before();
        Ok(Segment {
            start,
            length: self.solver.time() - start,
            position: self.solver.dense_of(0),
            velocity: self.solver.dense_of(1),
        })
    }

    /// A step at constant velocity, as long as the flight has been so far.
    fn straight_on(&mut self, e: Event, until: f64) -> Segment {
        let end = max(min(until, 2.0 * e.time), e.time);
        let (length, none) = (end - e.time, DVec3::ZERO);
        let way = e.velocity * length;
        self.settled = Some(Event { time: end, position: e.position + way, velocity: e.velocity });
        Segment {
            start: e.time,
            length,
            position: [e.position, way, none, none, none],
            velocity: [e.velocity, none, none, none, none],
        }
    }

    /// The same within what a search may spend.
    pub(super) fn step_within(&mut self, until: f64, budget: &Budget) -> Result<Segment> {
        budget.spend(self)?;
        self.step(until)
    }

    pub(super) fn now(&self) -> Event {
        let y = self.solver.state();
        self.settled.unwrap_or(Event { time: self.solver.time(), position: y[0], velocity: y[1] })
    }
}

/// A flight that was followed to its end.
#[derive(Clone, Debug)]
pub struct Flight {
    segments: Vec<Segment>,
    apex: Event,
    landing: Option<Event>,
    end: Event,
}

impl Flight {
    /// The highest point.
    pub fn apex(&self) -> Event {
        self.apex
    }
    /// Where it comes through the ground from above; `None` where it never does.
    pub fn landing(&self) -> Option<Event> {
        self.landing
    }
    /// The last moment that was followed: the landing, where there is one.
    pub fn end(&self) -> Event {
        self.end
    }
    /// Where it is `t` s after the launch. A time outside the flight is taken as the nearer end.
    pub fn at(&self, t: f64) -> Event {
        let t = clamp(t, 0.0, self.end.time);
        let i = self.segments.partition_point(|s| s.end() < t);
        self.segments.get(i).map_or(self.end, |s| s.at(t))
    }
}

/// Follows a projectile through the air until it lands on `ground`.
///
/// A launch below the ground, or one that never comes down to it, is followed until it can no longer land, at most for
/// [`FLIGHT_TIME_MAX_S`] or [`FLIGHT_STEPS_MAX`]; it then has no landing, and its end tells when that was.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::ballistics::{fly, Air, Projectile};
/// use jounce_motion::collide::Plane;
/// let v = 30.0 * 0.5f64.sqrt();
/// let kick = Projectile::new(DVec3::ZERO, DVec3::new(v, v, 0.0), DVec3::Y * -9.81)?;
/// let flight = fly(&kick, &Air::ball(0.43, 0.11, 0.25, 1.2)?, &Plane::new(DVec3::ZERO, DVec3::Y)?)?;
/// let landing = flight.landing().expect("it comes down");
/// assert!((landing.time - 3.589_42).abs() < 1e-5);
/// assert!((landing.position.x - 50.0127).abs() < 1e-4);
/// assert!((flight.apex().position.y - 15.9447).abs() < 1e-4);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// [`Error::BadValue`](crate::Error::BadValue) for an air that is not usable, [`Error::Failed`](crate::Error::Failed)
/// where the motion does not stay finite.
pub fn fly(projectile: &Projectile, air: &Air, ground: &Plane) -> Result<Flight> {
    fly_within(projectile, air, ground, &Budget::new())
}

fn fly_within(projectile: &Projectile, air: &Air, ground: &Plane, budget: &Budget) -> Result<Flight> {
    air.check()?;
    let up = projectile.up();
    let start = projectile.at(0.0);
    let mut path = Path::new(air, start.position, start.velocity, projectile.gravity())?;
    let mut flight = Flight { segments: Vec::new(), apex: start, landing: None, end: start };
    if ground.distance(start.position) == 0.0 && start.velocity.dot(ground.normal()) < 0.0 {
        flight.landing = Some(start);
        return Ok(flight);
    }
    // Without lift or a wind upwards, what sinks below the ground stays there.
    let lost = |e: &Event| {
        let sinks = e.velocity.dot(ground.normal()) < 0.0
            && projectile.gravity().dot(ground.normal()) <= 0.0
            && air.wind.dot(ground.normal()) <= 0.0;
        ground.distance(e.position) < 0.0 && sinks && !air.lifts()
    };
    for _ in 0..FLIGHT_STEPS_MAX {
        let segment = path.step_within(FLIGHT_TIME_MAX_S, budget)?;
        flight.segments.push(segment);
        flight.landing = segment.falls(|e| ground.distance(e.position));
        flight.end = flight.landing.unwrap_or(path.now());
        let top = segment.falls(|e| e.velocity.dot(up)).filter(|e| e.time <= flight.end.time);
        for e in [top, Some(flight.end)].into_iter().flatten() {
            if (e.position - flight.apex.position).dot(up) > 0.0 {
                flight.apex = e;
            }
        }
        if flight.landing.is_some() || lost(&flight.end) || flight.end.time >= FLIGHT_TIME_MAX_S {
            return Ok(flight);
        }
    }
    Ok(flight)
}

/// The shot along `forward` that lands farthest on level ground through the launch, and its landing. `forward` is any
/// vector that is not along gravity; only its horizontal part counts, and only the distance along it.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::ballistics::{farthest_in_air, Air};
/// let air = Air::ball(0.43, 0.11, 0.25, 1.2)?;
/// let (shot, landing) = farthest_in_air(30.0, DVec3::Y * -9.81, DVec3::X, &air)?;
/// // Drag makes it a flatter one than the 45° of the vacuum.
/// assert!(shot.angle.to_degrees() > 40.0 && shot.angle.to_degrees() < 44.0);
/// assert!(landing.position.x > 50.0127 && landing.position.x < 51.0);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// [`Error::BadValue`](crate::Error::BadValue) for a speed not above 0, no gravity, a direction that is none, or an
/// air that is not usable, [`Error::Failed`](crate::Error::Failed) where its paths turn too fast to be searched.
pub fn farthest_in_air(speed: f64, gravity: DVec3, forward: DVec3, air: &Air) -> Result<(Shot, Event)> {
    check_speed(speed, gravity)?;
    let up = up(gravity);
    let forward = level(forward, up)?;
    let ground = Plane::new(DVec3::ZERO, up)?;
    let budget = Budget::new();
    let fall = |angle: f64| -> Result<(Shot, Event)> {
        let velocity = (forward * cos(angle) + up * sin(angle)) * speed;
        let flight = fly_within(&Projectile::new(DVec3::ZERO, velocity, gravity)?, air, &ground, &budget)?;
        let end = flight.end();
        Ok((Shot::new(velocity, up, end.time), end))
    };
    let way = |angle: f64| Ok(-fall(angle)?.1.position.dot(forward));
    let mut best = (f64::INFINITY, 0.0);
    for degree in 1..=90 {
        let angle = FRAC_PI_2 * f64::from(degree) / 90.0;
        let here = way(angle)?;
        if here < best.0 {
            best = (here, angle);
        }
    }
    let degree = FRAC_PI_2 / 90.0;
    fall(golden(best.1 - degree, best.1 + degree, way)?)
}

/// A speed and a gravity whose ranges in vacuum are numbers.
fn check_speed(speed: f64, gravity: DVec3) -> Result<()> {
    positive("projectile", "speed", speed)?;
    check_gravity(gravity)?;
    let time = speed / gravity.length();
    let expected = "a speed whose flight under this gravity stays within what f64 can hold";
    check(
        (time * time).is_finite() && (2.0 * time * speed).is_finite(),
        "projectile",
        "speed",
        speed,
        expected,
    )
}

/// The unit vector along the horizontal part of a direction.
fn level(forward: DVec3, up: DVec3) -> Result<DVec3> {
    let flat = (forward - up * forward.dot(up)).try_normalize();
    let Some((flat, _)) = flat else {
        let expected = "a finite vector that is not along gravity";
        return Err(bad("projectile", "forward", forward.to_array(), expected));
    };
    Ok(flat)
}

/// The flattest shot along the horizontal part of `forward` whose apex in air is `height` in m above the launch.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::ballistics::{angle_for_height_in_air, Air};
/// let air = Air::ball(0.43, 0.11, 0.25, 1.2)?;
/// let shot = angle_for_height_in_air(30.0, 15.9447, DVec3::Y * -9.81, DVec3::X, &air)?.yes().expect("high enough");
/// assert!((shot.angle.to_degrees() - 45.0).abs() < 1e-3);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// [`Error::BadValue`](crate::Error::BadValue) for a speed not above 0, a height below 0, no gravity, a direction
/// that is none, or an air that is not usable, [`Error::Failed`](crate::Error::Failed) where its paths turn too fast to
/// be searched.
pub fn angle_for_height_in_air(
    speed: f64,
    height: f64,
    gravity: DVec3,
    forward: DVec3,
    air: &Air,
) -> Result<Reach<Shot>> {
    not_negative("projectile", "height", height)?;
    check_speed(speed, gravity)?;
    let up = up(gravity);
    let forward = level(forward, up)?;
    let ground = Plane::new(DVec3::ZERO, up)?;
    let budget = Budget::new();
    let shot = |angle: f64| -> Result<(Shot, Event)> {
        let velocity = (forward * cos(angle) + up * sin(angle)) * speed;
        let p = Projectile::new(DVec3::ZERO, velocity, gravity)?;
        let apex = fly_within(&p, air, &ground, &budget)?.apex();
        Ok((Shot::new(velocity, up, apex.time), apex))
    };
    let mut best = shot(0.0)?;
    let mut before = 0.0;
    // The steeper the higher, but for lift, which can make a flatter shot climb more: the first degree that is enough.
    for degree in 0..=90 {
        let angle = FRAC_PI_2 * f64::from(degree) / 90.0;
        let here = shot(angle)?;
        if here.1.position.dot(up) >= height {
            let enough = |a: f64| shot(a).is_ok_and(|s| s.1.position.dot(up) >= height);
            let angle = if degree == 0 { 0.0 } else { bisect(before, angle, false, enough) };
            return Ok(Reach::Yes(shot(angle)?.0));
        }
        if here.1.position.dot(up) > best.1.position.dot(up) {
            best = here;
        }
        before = angle;
    }
    let (shot, apex) = best;
    let distance = height - apex.position.dot(up);
    Ok(Reach::No(Miss { distance, shot, closest: apex.position, speed_needed: None }))
}
