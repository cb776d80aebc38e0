//! `jounce solve`: questions of the textbook, answered by `jounce_motion` without a world.
//!
//! "It cannot be reached" is an answer: it comes with the nearest approach, and with exit code 0.

use crate::args::{ProjectileArgs, Question, SolveArgs};
use crate::error::{Done, Failure};
use crate::output::{Table, number, print, print_json};
use jounce::prelude::DVec3;
use jounce_motion::ballistics::{
    Air, Event, Miss, Projectile, Reach, Shot, Target, aim, aim_in_air, angle_for_height,
    angle_for_height_in_air, angles_for_range, farthest_in_air, fly, lead, slowest,
};
use jounce_motion::collide::Plane;
use serde::Serialize;

pub fn solve(a: &SolveArgs) -> Done {
    match &a.question {
        Question::Projectile(a) => projectile(a),
    }
}

#[derive(Serialize)]
struct Report {
    question: &'static str,
    gravity: f64,
    speed: Option<f64>,
    target: Option<[f64; 3]>,
    moving: Option<[f64; 3]>,
    apex: Option<f64>,
    vacuum: Answer,
    air: Option<Answer>,
}

/// What holds in one medium.
#[derive(Serialize)]
struct Answer {
    reachable: bool,
    shots: Vec<ShotReport>,
    miss: Option<MissReport>,
}

#[derive(Serialize)]
struct ShotReport {
    name: String,
    angle_deg: f64,
    azimuth_deg: f64,
    speed: f64,
    velocity: [f64; 3],
    /// Until the target; until the landing where there is no target.
    time: Option<f64>,
    apex: Moment,
    landing: Option<Moment>,
}

#[derive(Serialize)]
struct Moment {
    time: f64,
    position: [f64; 3],
    /// Horizontal distance from the launch.
    distance: f64,
    speed: f64,
    /// Of the motion, above the horizontal.
    angle_deg: f64,
}

#[derive(Serialize)]
struct MissReport {
    distance: f64,
    closest: [f64; 3],
    time: f64,
    angle_deg: f64,
    azimuth_deg: f64,
    velocity: [f64; 3],
    speed_needed: Option<f64>,
}

/// What is asked, with everything that both media share.
struct Task {
    asked: Asked,
    speed: Option<f64>,
    gravity: DVec3,
    /// The ground below the launch, where the question has one.
    ground: Option<Plane>,
}

enum Asked {
    Angle(f64),
    Apex(f64),
    /// On the level of the launch, ahead: what falls short lands on the ground before it.
    Range(f64),
    Target(Target),
}

fn projectile(a: &ProjectileArgs) -> Done {
    let task = task(a)?;
    let air = air(a, &task)?;
    let vacuum = in_vacuum(&task)?;
    let in_air = air.map(|air| through_air(&task, &air, &vacuum)).transpose()?;
    let (target, moving) = match &task.asked {
        Asked::Target(t) => (Some(t.position.to_array()), a.moving),
        Asked::Range(r) => (Some([*r, 0.0, 0.0]), None),
        Asked::Angle(_) | Asked::Apex(_) => (None, None),
    };
    let report = Report {
        question: match (&task.asked, a.speed) {
            (Asked::Angle(_), _) => "angle",
            (Asked::Apex(_), _) => "apex",
            (Asked::Target(_) | Asked::Range(_), None) => "slowest",
            (Asked::Range(_), Some(_)) => "range",
            (Asked::Target(_), Some(_)) if a.moving.is_some() => "moving",
            (Asked::Target(_), Some(_)) if a.range.is_some() => "range",
            (Asked::Target(_), Some(_)) => "target",
        },
        gravity: a.gravity,
        speed: a.speed,
        target,
        moving,
        apex: a.apex,
        vacuum,
        air: in_air,
    };
    if a.json { print_json(&report) } else { print(&text(&report)) }
}

fn task(a: &ProjectileArgs) -> Done<Task> {
    let gravity = DVec3::Y * -a.gravity;
    let (asked, ground) = if let Some(angle) = a.angle {
        let ground = Plane::new(DVec3::Y * -a.launch_height, DVec3::Y)?;
        (Asked::Angle(angle.to_radians()), Some(ground))
    } else if let Some(height) = a.apex {
        (Asked::Apex(height), Some(Plane::new(DVec3::ZERO, DVec3::Y)?))
    } else if let Some(range) = a.range.filter(|_| a.height == 0.0 && a.moving.is_none()) {
        (Asked::Range(range), None)
    } else if let Some(position) = a.target.or(a.range.map(|r| [r, a.height, 0.0])) {
        let velocity = DVec3::from(a.moving.unwrap_or_default());
        (Asked::Target(Target::moving(position.into(), velocity)), None)
    } else {
        return Err(Failure::bad(
            "nothing is asked; expected one of --angle DEG, --range R, --apex H or --target X,Y,Z",
        ));
    };
    Ok(Task { asked, speed: a.speed, gravity, ground })
}

/// The air, where the arguments speak of one.
fn air(a: &ProjectileArgs, task: &Task) -> Done<Option<Air>> {
    let Some(mass) = a.mass else { return Ok(None) };
    if a.drag.is_none() && a.linear_drag.is_none() {
        return Err(Failure::bad(
            "--mass speaks of air, but no drag is given; expected --diameter D with --drag CD, or --linear-drag B",
        ));
    }
    let mut air = match a.diameter {
        Some(d) => Air::ball(mass, 0.5 * d, a.drag.unwrap_or(0.0), a.density)?,
        None => Air { mass, ..Air::VACUUM },
    };
    air.linear = a.linear_drag.unwrap_or(0.0);
    air.wind = a.wind.unwrap_or_default().into();
    air.spin = match (a.spin, a.backspin) {
        (Some(spin), _) => spin.into(),
        (None, Some(rate)) => {
            let forward = match &task.asked {
                Asked::Target(t) => DVec3::new(t.position.x, 0.0, t.position.z).normalize_or(DVec3::X),
                _ => DVec3::X,
            };
            forward.cross(DVec3::Y) * rate
        }
        (None, None) => DVec3::ZERO,
    };
    Ok(Some(air))
}

fn flat(angle: f64, speed: f64) -> DVec3 {
    DVec3::new(angle.cos(), angle.sin(), 0.0) * speed
}

fn needed(task: &Task) -> Done<f64> {
    task.speed.ok_or_else(|| Failure::bad("--speed S is missing; expected the launch speed in m/s"))
}

fn in_vacuum(task: &Task) -> Done<Answer> {
    let g = task.gravity;
    let report = |name: &str, velocity: DVec3, time: Option<f64>| -> Done<ShotReport> {
        let p = Projectile::new(DVec3::ZERO, velocity, g)?;
        let landing = match &task.ground {
            Some(ground) => p.falls_to(ground.point().y)?,
            None => None,
        };
        Ok(shot_report(name, velocity, time.or(landing.map(|l| l.time)), p.apex(), landing))
    };
    Ok(match &task.asked {
        Asked::Angle(angle) => yes(vec![report("flight", flat(*angle, needed(task)?), None)?]),
        Asked::Apex(height) => {
            // Without a speed: straight up, just so high.
            let speed = task.speed.unwrap_or((2.0 * g.length() * height).sqrt());
            match angle_for_height(speed, *height, g.length())? {
                Reach::Yes(angle) => {
                    let velocity = flat(angle, speed);
                    yes(vec![report("apex", velocity, Some(velocity.y / g.length()))?])
                }
                Reach::No(miss) => no(&miss),
            }
        }
        Asked::Range(range) => {
            let speed = task.speed.unwrap_or((range * g.length()).sqrt());
            match angles_for_range(speed, *range, g.length())? {
                Reach::Yes(both) if both.low == both.high => {
                    let velocity = flat(both.low, speed);
                    yes(vec![report(ONLY, velocity, Some(2.0 * velocity.y / g.length()))?])
                }
                Reach::Yes(both) => yes([("low", both.low), ("high", both.high)]
                    .into_iter()
                    .map(|(name, angle)| {
                        let velocity = flat(angle, speed);
                        report(name, velocity, Some(2.0 * velocity.y / g.length()))
                    })
                    .collect::<Done<_>>()?),
                Reach::No(miss) => no(&miss),
            }
        }
        Asked::Target(t) => {
            let found = match task.speed {
                None => Reach::Yes(vec![slowest(t.position, g)?]),
                Some(speed) if t.velocity == DVec3::ZERO => match aim(t.position, speed, g)? {
                    Reach::Yes(s) => Reach::Yes(vec![s.low, s.high]),
                    Reach::No(miss) => Reach::No(miss),
                },
                Some(speed) => lead(t, speed, g)?,
            };
            match found {
                Reach::Yes(shots) => yes(named(&shots)
                    .map(|(name, s)| report(&name, s.velocity, Some(s.time)))
                    .collect::<Done<_>>()?),
                Reach::No(miss) => no(&miss),
            }
        }
    })
}

fn through_air(task: &Task, air: &Air, vacuum: &Answer) -> Done<Answer> {
    let g = task.gravity;
    let report = |name: &str, velocity: DVec3, time: Option<f64>| -> Done<ShotReport> {
        let p = Projectile::new(DVec3::ZERO, velocity, g)?;
        // Without a ground the flight is only followed for its apex.
        let ground = task.ground.map_or_else(|| Plane::new(DVec3::ZERO, DVec3::Y), Ok)?;
        let flight = fly(&p, air, &ground)?;
        let landing = task.ground.and(flight.landing());
        Ok(shot_report(name, velocity, time.or(landing.map(|l| l.time)), flight.apex(), landing))
    };
    Ok(match &task.asked {
        Asked::Angle(angle) => yes(vec![report("flight", flat(*angle, needed(task)?), None)?]),
        Asked::Apex(height) => {
            let speed = task.speed.or(vacuum.shots.first().map(|s| s.speed)).unwrap_or(0.0);
            match angle_for_height_in_air(speed, *height, g, DVec3::X, air)? {
                Reach::Yes(s) => yes(vec![report("apex", s.velocity, Some(s.time))?]),
                Reach::No(miss) => no(&miss),
            }
        }
        Asked::Target(_) | Asked::Range(_) => {
            // Without a speed: is the vacuum's least enough? It is not, and the answer says by how much.
            let speed = task.speed.or(vacuum.shots.first().map(|s| s.speed)).unwrap_or(0.0);
            let target = match &task.asked {
                Asked::Range(r) => Target::fixed(DVec3::X * *r),
                Asked::Target(t) => *t,
                Asked::Angle(_) | Asked::Apex(_) => Target::default(),
            };
            match (aim_in_air(&target, speed, g, air)?, &task.asked) {
                (Reach::Yes(shots), _) => yes(named(&shots)
                    .map(|(name, s)| report(&name, s.velocity, Some(s.time)))
                    .collect::<Done<_>>()?),
                (Reach::No(miss), Asked::Range(range)) => {
                    let (shot, landing) = farthest_in_air(speed, g, DVec3::X, air)?;
                    if landing.position.y.abs() > 1e-6 * range {
                        // Lift or a wind keeps it up: there is no landing to be short.
                        return Ok(no(&miss));
                    }
                    let distance = landing.position.distance(DVec3::X * *range);
                    no(&Miss { distance, shot, closest: landing.position, speed_needed: None })
                }
                (Reach::No(miss), _) => no(&miss),
            }
        }
    })
}

/// Name of a shot that is the only one.
const ONLY: &str = "only";

/// Two shots are the low and the high one; of any other number each has its place in time.
fn named(shots: &[Shot]) -> impl Iterator<Item = (String, &Shot)> {
    shots.iter().enumerate().map(move |(i, s)| {
        let name = match (shots.len(), i) {
            (1, _) => ONLY.into(),
            (2, 0) => "low".into(),
            (2, _) => "high".into(),
            (_, i) => format!("{}", i + 1),
        };
        (name, s)
    })
}

fn yes(shots: Vec<ShotReport>) -> Answer {
    Answer { reachable: true, shots, miss: None }
}

fn no(miss: &Miss) -> Answer {
    let (angle_deg, azimuth_deg) = angles(miss.shot.velocity);
    let miss = MissReport {
        distance: miss.distance,
        closest: tidy(miss.closest, miss.shot.time * miss.shot.velocity.length()),
        time: miss.shot.time,
        angle_deg,
        azimuth_deg,
        velocity: miss.shot.velocity.to_array(),
        speed_needed: miss.speed_needed,
    };
    Answer { reachable: false, shots: Vec::new(), miss: Some(miss) }
}

/// Above the horizontal, and from x towards z; degrees.
fn angles(v: DVec3) -> (f64, f64) {
    let across = v.x.hypot(v.z);
    // The direction of what goes straight up is noise.
    let azimuth = if across > 1e-9 * v.length() { v.z.atan2(v.x) } else { 0.0 };
    (v.y.atan2(across).to_degrees(), azimuth.to_degrees())
}

fn shot_report(
    name: &str,
    velocity: DVec3,
    time: Option<f64>,
    apex: Event,
    landing: Option<Event>,
) -> ShotReport {
    let (angle_deg, azimuth_deg) = angles(velocity);
    ShotReport {
        name: name.into(),
        angle_deg,
        azimuth_deg,
        speed: velocity.length(),
        velocity: velocity.to_array(),
        time,
        apex: moment(apex),
        landing: landing.map(moment),
    }
}

/// A place at the end of a way that is so long: what is far below its rounding is none.
fn tidy(place: DVec3, way: f64) -> [f64; 3] {
    place.to_array().map(|x| if x.abs() <= 1e-14 * way { 0.0 } else { x })
}

fn moment(e: Event) -> Moment {
    let position = tidy(e.position, e.time * e.velocity.length());
    Moment {
        time: e.time,
        position,
        distance: position[0].hypot(position[2]),
        speed: e.velocity.length(),
        angle_deg: angles(e.velocity).0,
    }
}

fn point(p: [f64; 3]) -> String {
    format!("({}, {}, {})", number(p[0]), number(p[1]), number(p[2]))
}

fn text(r: &Report) -> String {
    let mut t = Table::new([
        "in",
        "shot",
        "angle °",
        "azimuth °",
        "speed m/s",
        "time s",
        "apex m",
        "apex s",
        "landing m",
        "landing m/s",
    ])
    .left(1);
    let mut words = String::new();
    for (medium, answer) in [("vacuum", Some(&r.vacuum)), ("air", r.air.as_ref())] {
        let Some(answer) = answer else { continue };
        for s in &answer.shots {
            if r.question == "angle" && s.landing.is_none() {
                words += &format!("In {medium} it does not come down within what is followed.\n");
            }
            let landing = |f: fn(&Moment) -> f64| s.landing.as_ref().map_or("–".into(), |l| number(f(l)));
            t.row([
                medium.into(),
                s.name.clone(),
                number(s.angle_deg),
                number(s.azimuth_deg),
                number(s.speed),
                s.time.map_or("–".into(), number),
                number(s.apex.position[1]),
                number(s.apex.time),
                landing(|l| l.distance),
                landing(|l| l.speed),
            ]);
        }
        if let Some(m) = &answer.miss {
            words += &match r.question {
                // On level ground what counts is where it lands; in space it may come nearer below the ground.
                "range" | "slowest" if m.closest[1].abs() <= 1e-6 * m.closest[0].abs() => format!(
                    "In {medium} it cannot be reached. The farthest landing, of the shot at {}°, is {} m short, at {} \
                     after {} s.",
                    number(m.angle_deg),
                    number(m.distance),
                    point(m.closest),
                    number(m.time)
                ),
                _ => format!(
                    "In {medium} it cannot be reached. The shot at {}° (azimuth {}°) comes within {} m, at {} after {} s.",
                    number(m.angle_deg),
                    number(m.azimuth_deg),
                    number(m.distance),
                    point(m.closest),
                    number(m.time)
                ),
            };
            if let Some(s) = m.speed_needed {
                words += &format!(" {} m/s would do.", number(s));
            }
            words.push('\n');
        }
    }
    let any = [Some(&r.vacuum), r.air.as_ref()].into_iter().flatten().any(|a| !a.shots.is_empty());
    if any { t.text() + &words } else { words }
}
