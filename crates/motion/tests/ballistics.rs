//! Projectiles in vacuum and in air: closed forms, aiming, what cannot be reached.
#![expect(clippy::disallowed_methods, reason = "the reference side of a test may use std's functions")]

use jounce_math::DVec3;
use jounce_motion::ballistics::*;
use jounce_motion::collide::Plane;
use jounce_motion::integrate::{Integrator, Method};

const G: DVec3 = DVec3::new(0.0, -9.81, 0.0);

/// Numbers in 0…1, the same every time.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::new(self.next() - 0.5, self.next() - 0.5, self.next() - 0.5) * (2.0 * size)
    }
}

fn thrown(speed: f64, angle: f64) -> Projectile {
    let v = DVec3::new(angle.cos(), angle.sin(), 0.0) * speed;
    Projectile::new(DVec3::ZERO, v, G).expect("projectile")
}

#[test]
fn thirty_metres_a_second_at_45_degrees() {
    let p = thrown(30.0, 45f64.to_radians());
    assert!((p.level_range() - 91.743).abs() < 5e-4);
    let apex = p.apex();
    // v_y/g and v_y²/2g.
    let vy = 30.0 * 0.5f64.sqrt();
    assert!((apex.time - vy / 9.81).abs() < 1e-14 && (apex.position.y - vy * vy / 19.62).abs() < 1e-13);
    assert!(apex.velocity.y.abs() < 1e-14);
    let down = p.falls_to(0.0).expect("finite").expect("comes down");
    assert!((down.position.x - p.level_range()).abs() < 1e-12 && down.position.y.abs() < 1e-12);
    // Thrown downwards: no apex but the launch, no range, and the ground below is still found.
    let p = Projectile::new(DVec3::Y * 3.0, DVec3::new(1.0, -2.0, 0.0), G).expect("projectile");
    assert_eq!((p.apex().time, p.level_range()), (0.0, 0.0));
    let down = p.falls_to(-3.0).expect("finite").expect("falls");
    assert!(down.position.y.abs() < 1e-14 && down.time > 0.0);
    assert!(p.falls_to(1.0).expect("finite").is_none());
}

#[test]
fn angles_for_ranges_and_heights() {
    for range in [0.0, 1.0, 50.0, 91.0, 900.0 / 9.81] {
        let a = angles_for_range(30.0, range, 9.81).expect("numbers").yes().expect("in reach");
        for angle in [a.low, a.high] {
            assert!((thrown(30.0, angle).level_range() - range).abs() < 1e-6, "{range} {angle}");
        }
        assert!(a.low <= a.high);
    }
    let miss = angles_for_range(30.0, 100.0, 9.81).expect("numbers").no().expect("out of reach");
    assert!((miss.distance - (100.0 - 900.0 / 9.81)).abs() < 1e-12);
    let needed = miss.speed_needed.expect("known");
    assert!(angles_for_range(needed * (1.0 + 1e-12), 100.0, 9.81).expect("numbers").yes().is_some());
    for height in [0.0, 3.0, 45.0] {
        let a = angle_for_height(30.0, height, 9.81).expect("numbers").yes().expect("in reach");
        assert!((thrown(30.0, a).apex().position.y - height).abs() < 1e-12);
    }
    let miss = angle_for_height(30.0, 50.0, 9.81).expect("numbers").no().expect("out of reach");
    assert!((miss.distance - (50.0 - 900.0 / 19.62)).abs() < 1e-12);
    assert!((miss.speed_needed.expect("known") - (2.0f64 * 9.81 * 50.0).sqrt()).abs() < 1e-12);
}

#[test]
fn any_target_in_space_by_both_shots() {
    let mut random = Random(7);
    let (mut hits, mut misses) = (0, 0);
    for _ in 0..5000 {
        let (d, speed) = (random.vector(50.0), 5.0 + 30.0 * random.next());
        let gravity = if random.next() < 0.5 { G } else { random.vector(10.0) };
        let least = slowest(d, gravity).expect("numbers");
        assert!(
            (Projectile::new(DVec3::ZERO, least.velocity, gravity).expect("p").at(least.time).position - d)
                .length()
                < 1e-10
        );
        match aim(d, speed, gravity).expect("numbers") {
            Reach::Yes(s) => {
                hits += 1;
                assert!(least.velocity.length() <= speed * (1.0 + 1e-12));
                assert!(s.low.time <= s.high.time);
                for shot in [s.low, s.high] {
                    assert!((shot.velocity.length() - speed).abs() < 1e-9 * speed, "{d:?} {speed}");
                    let hit = Projectile::new(DVec3::ZERO, shot.velocity, gravity).expect("p").at(shot.time);
                    assert!((hit.position - d).length() < 1e-10 * (1.0 + d.length()));
                }
            }
            Reach::No(miss) => {
                misses += 1;
                assert!(least.velocity.length() > speed);
                let e =
                    Projectile::new(DVec3::ZERO, miss.shot.velocity, gravity).expect("p").at(miss.shot.time);
                assert!((miss.shot.velocity.length() - speed).abs() < 1e-9 * speed);
                assert!((e.position - miss.closest).length() < 1e-9);
                assert!((miss.distance - (d - miss.closest).length()).abs() < 1e-9);
                assert!((miss.speed_needed.expect("known") - least.velocity.length()).abs() < 1e-9);
            }
        }
    }
    assert!(hits > 500 && misses > 500, "{hits} {misses}");
}

#[test]
fn the_nearest_approach_is_the_nearest() {
    // Against all angles and times of a fine grid.
    for target in [DVec3::new(60.0, 20.0, 0.0), DVec3::new(3.0, 30.0, 0.0), DVec3::new(90.0, -30.0, 0.0)] {
        let miss = aim(target, 20.0, G).expect("numbers").no().expect("out of reach");
        let mut best = f64::MAX;
        for i in 0..2000 {
            let p = thrown(20.0, std::f64::consts::PI * (f64::from(i) / 2000.0 - 0.25));
            for k in 0..2000 {
                best = best.min((p.at(f64::from(k) * 0.004).position - target).length());
            }
        }
        // The grid's nearest is at most a quarter of its spacing away to second order.
        assert!(miss.distance <= best + 1e-12 && miss.distance > best - 0.01, "{miss:?} {best}");
    }
}

#[test]
fn straight_up_and_down() {
    let s = aim(DVec3::Y * 10.0, 20.0, G).expect("numbers").yes().expect("in reach");
    for shot in [s.low, s.high] {
        assert!((shot.velocity - DVec3::Y * 20.0).length() < 1e-9, "once rising, once falling: {shot:?}");
    }
    let s = aim(DVec3::Y * -10.0, 20.0, G).expect("numbers").yes().expect("in reach");
    assert!(
        (s.low.velocity + DVec3::Y * 20.0).length() < 1e-9
            && (s.high.velocity - DVec3::Y * 20.0).length() < 1e-9
    );
    let miss = aim(DVec3::Y * 100.0, 20.0, G).expect("numbers").no().expect("out of reach");
    assert!((miss.distance - (100.0 - 400.0 / 19.62)).abs() < 1e-9);
    let straight = aim(DVec3::X * 10.0, 20.0, DVec3::ZERO).expect("numbers").yes().expect("no gravity");
    assert_eq!((straight.low.velocity, straight.low.time), (DVec3::X * 20.0, 0.5));
    assert!((slowest(DVec3::Y * -5.0, G).expect("numbers").velocity).length() < 1e-12, "let go");
}

#[test]
fn leads_on_moving_targets() {
    let mut random = Random(11);
    let (mut hits, mut misses) = (0, 0);
    for case in 0..3000 {
        let gravity = if case % 5 == 0 { DVec3::ZERO } else { G };
        let target = Target {
            position: random.vector(100.0),
            velocity: random.vector(25.0),
            acceleration: if case % 3 == 0 { random.vector(3.0) } else { DVec3::ZERO },
        };
        let speed = 5.0 + 40.0 * random.next();
        match lead(&target, speed, gravity).expect("numbers") {
            Reach::Yes(shots) => {
                hits += 1;
                assert!(shots.windows(2).all(|w| w[0].time < w[1].time) && shots.len() <= 4);
                for s in &shots {
                    let at = s.velocity * s.time + gravity * (0.5 * s.time * s.time);
                    let far = target.at(s.time).length() + 1.0;
                    assert!((at - target.at(s.time)).length() < 1e-9 * far, "{target:?} {s:?}");
                    assert!((s.velocity.length() - speed).abs() < 1e-6 * speed, "{target:?} {speed} {s:?}");
                }
                // No earlier meeting: until then the target is farther than a shot has gone.
                let first = shots[0].time;
                for k in 1..200 {
                    let t = first * f64::from(k) / 200.0 * (1.0 - 1e-9);
                    let free = target.at(t) - gravity * (0.5 * t * t);
                    assert!(free.length() > speed * t, "{target:?} {speed}: at {t} before {first}");
                }
            }
            Reach::No(miss) => {
                misses += 1;
                let left = |t: f64| (target.at(t) - gravity * (0.5 * t * t)).length() - speed * t;
                let horizon = 20.0 * (1.0 + target.position.length() / speed);
                for k in 0..4000 {
                    let t = horizon * f64::from(k) / 4000.0;
                    assert!(
                        left(t) > 0.0 && left(t) > miss.distance - 1e-7,
                        "{target:?} {speed} {miss:?} {t}"
                    );
                }
                let there = miss.shot.velocity * miss.shot.time + gravity * (0.5 * miss.shot.time.powi(2));
                assert!((there - miss.closest).length() < 1e-6 * (1.0 + there.length()));
            }
        }
    }
    assert!(hits > 500 && misses > 300, "{hits} {misses}");
    // Faster than the shot, braking and turning back: 100 − 30 t + 1.5 t² = ±5 t has four answers.
    let back = Target {
        velocity: DVec3::X * -30.0,
        acceleration: DVec3::X * 3.0,
        ..Target::fixed(DVec3::X * 100.0)
    };
    let shots = lead(&back, 5.0, DVec3::ZERO).expect("numbers").yes().expect("four");
    // t = (35 ∓ √625)/3 and (25 ∓ √25)/3.
    let exact = [10.0 / 3.0, 20.0 / 3.0, 10.0, 20.0];
    assert_eq!(shots.len(), 4);
    for (s, t) in shots.iter().zip(exact) {
        assert!((s.time - t).abs() < 1e-9, "{s:?} {t}");
    }
    // A target that stands is the fixed one.
    let (d, speed) = (DVec3::new(30.0, 5.0, 3.0), 25.0);
    let moving = lead(&Target::fixed(d), speed, G).expect("numbers").yes().expect("in reach");
    let fixed = aim(d, speed, G).expect("numbers").yes().expect("in reach");
    assert!((moving[0].velocity - fixed.low.velocity).length() < 1e-9);
    assert!((moving[1].velocity - fixed.high.velocity).length() < 1e-9);
    // One that falls with the shot is aimed at straight.
    let falls = Target { acceleration: G, ..Target::fixed(d) };
    let shots = lead(&falls, speed, G).expect("numbers").yes().expect("in reach");
    assert!((shots[0].velocity.normalize_or(DVec3::X) - d.normalize_or(DVec3::X)).length() < 1e-9);
}

fn football() -> Air {
    Air::ball(0.43, 0.11, 0.25, 1.2).expect("air")
}

fn floor() -> Plane {
    Plane::new(DVec3::ZERO, DVec3::Y).expect("plane")
}

/// The end of a flight by many small steps of RK4, which knows nothing of events and polynomials.
fn by_rk4(air: &Air, start: DVec3, velocity: DVec3, time: f64) -> DVec3 {
    let (mut x, mut v) = (start, velocity);
    let steps = 20_000;
    let dt = time / f64::from(steps);
    let mut rk4 = Integrator::new(Method::Rk4);
    for _ in 0..steps {
        rk4.step_point(0.0, dt, &mut x, &mut v, |_, _, v| G + air.acceleration(v)).expect("steps");
    }
    x
}

#[test]
fn a_football_in_air() {
    let flight = fly(&thrown(30.0, 45f64.to_radians()), &football(), &floor()).expect("flies");
    let landing = flight.landing().expect("lands");
    assert!((landing.time - 3.589_42).abs() < 5e-6, "{landing:?}");
    assert!((landing.position.x - 50.012_7).abs() < 5e-5 && landing.position.y.abs() < 1e-9);
    assert!((flight.apex().position.y - 15.944_7).abs() < 5e-5);
    let check =
        by_rk4(&football(), DVec3::ZERO, thrown(30.0, 45f64.to_radians()).launch_velocity(), landing.time);
    assert!((check - landing.position).length() < 1e-7, "{check:?}");
    // Between the events, and beyond them.
    let t = 0.37 * landing.time;
    let there = by_rk4(&football(), DVec3::ZERO, thrown(30.0, 45f64.to_radians()).launch_velocity(), t);
    assert!((flight.at(t).position - there).length() < 1e-6);
    assert_eq!(flight.at(99.0).position, landing.position);
    assert_eq!(flight.at(-1.0).position, DVec3::ZERO);
}

#[test]
fn air_that_is_none_is_the_vacuum() {
    let p = thrown(30.0, 1.0);
    let flight = fly(&p, &Air::VACUUM, &floor()).expect("flies");
    let landing = flight.landing().expect("lands");
    assert!((landing.position.x - p.level_range()).abs() < 1e-9);
    assert!((flight.apex().position - p.apex().position).length() < 1e-9);
    assert!((flight.apex().time - p.apex().time).abs() < 1e-9);
}

#[test]
fn linear_drag_has_its_closed_form() {
    // x = v₀ τ (1 − e^{−t/τ}), y = (v₀ + g τ) τ (1 − e^{−t/τ}) − g τ t.
    let air = Air { mass: 2.0, linear: 0.8, ..Air::VACUUM };
    let (tau, p) = (2.5, thrown(20.0, 1.1));
    let flight = fly(&p, &air, &floor()).expect("flies");
    let v = p.launch_velocity();
    for part in [0.1, 0.5, 0.9, 1.0] {
        let t = part * flight.end().time;
        let e = 1.0 - (-t / tau).exp();
        let exact = DVec3::new(v.x * tau * e, (v.y + 9.81 * tau) * tau * e - 9.81 * tau * t, 0.0);
        assert!((flight.at(t).position - exact).length() < 1e-8);
    }
    // The apex: τ ln(1 + v_y/(g τ)).
    assert!((flight.apex().time - tau * (1.0 + v.y / (9.81 * tau)).ln()).abs() < 1e-8);
}

#[test]
fn spin_and_wind_do_what_they_are_known_for() {
    let range =
        |air: Air| fly(&thrown(30.0, 0.4), &air, &floor()).expect("flies").landing().expect("lands").position;
    let plain = range(football());
    assert!(range(football().with_wind(DVec3::X * 5.0)).x > plain.x, "tail wind");
    assert!(range(football().with_wind(DVec3::X * -5.0)).x < plain.x, "head wind");
    assert!(range(football().with_wind(DVec3::Z * 5.0)).z > 0.5, "cross wind");
    assert!(range(football().with_spin(DVec3::Z * 60.0)).x > plain.x, "back spin");
    assert!(range(football().with_spin(DVec3::Z * -60.0)).x < plain.x, "top spin");
    // Turning to the left, seen from above: the ball bends to the left of its flight, here −z.
    assert!(range(football().with_spin(DVec3::Y * 60.0)).z < -1.0);
    // A wind at the ball's own speed is no wind at all.
    let still = Air { quadratic: 0.1, ..Air::VACUUM }.with_wind(DVec3::new(3.0, 4.0, 0.0));
    assert_eq!(still.acceleration(DVec3::new(3.0, 4.0, 0.0)), DVec3::ZERO);
}

#[test]
fn what_is_blown_away_and_what_hardly_moves_come_to_an_end() {
    // A feather in a wind upwards never lands; aiming it has an answer all the same.
    let feather = Air { mass: 0.001, linear: 0.01, ..Air::VACUUM }.with_wind(DVec3::new(1.0, 8.0, 0.0));
    let flight = fly(&thrown(3.0, 0.5), &feather, &floor()).expect("flies");
    assert!(flight.landing().is_none() && flight.end().position.y > 1000.0);
    let target = Target::fixed(DVec3::new(5.0, -5.0, 0.0));
    assert!(aim_in_air(&target, 3.0, G, &feather).expect("numbers").no().is_some());
    // Stopped within a micron, and down again at a micron a second.
    let treacle = Air { mass: 1.0, linear: 1e7, ..Air::VACUUM };
    let flight = fly(&thrown(3.0, 0.5), &treacle, &floor()).expect("flies");
    let (landing, tau) = (flight.landing().expect("it sinks"), 1e-7);
    assert!((landing.position.x / (3.0 * 0.5f64.cos() * tau) - 1.0).abs() < 1e-6, "{landing:?}");
    assert!((landing.time / (3.0 * 0.5f64.sin() / 9.81 + tau) - 1.0).abs() < 1e-6, "{landing:?}");
}

#[test]
fn flights_that_do_not_land() {
    let deep = Plane::new(DVec3::Y * 100.0, DVec3::Y).expect("plane");
    let flight = fly(&thrown(10.0, 1.0), &football(), &deep).expect("flies");
    assert!(flight.landing().is_none() && flight.end().time < 10.0, "{:?}", flight.end());
    let down = Projectile::new(DVec3::ZERO, DVec3::new(1.0, -1.0, 0.0), G).expect("projectile");
    assert_eq!(fly(&down, &football(), &floor()).expect("flies").landing().expect("at once").time, 0.0);
    // A wall in front: the ground may stand upright.
    let wall = Plane::new(DVec3::X * 10.0, -DVec3::X).expect("plane");
    let hit = fly(&thrown(30.0, 0.5), &football(), &wall).expect("flies").landing().expect("hits the wall");
    assert!((hit.position.x - 10.0).abs() < 1e-9 && hit.position.y > 0.0);
}

fn hits(air: &Air, target: &Target, shots: &[Shot], speed: f64) {
    for s in shots {
        assert!((s.velocity.length() - speed).abs() < 1e-9 * speed);
        let end = by_rk4(air, DVec3::ZERO, s.velocity, s.time);
        assert!((end - target.at(s.time)).length() < 1e-5, "{target:?} {s:?} ends at {end:?}");
    }
}

#[test]
fn aiming_through_air() {
    let mut random = Random(3);
    let (mut found, mut none) = (0, 0);
    for case in 0..40 {
        let mut air = football();
        if case % 2 == 1 {
            air = air.with_wind(random.vector(6.0).mul(DVec3::new(1.0, 0.0, 1.0)));
        }
        if case % 3 == 1 {
            air = air.with_spin(random.vector(60.0));
        }
        let velocity = if case % 4 == 3 { random.vector(5.0) } else { DVec3::ZERO };
        let target = Target::moving(random.vector(40.0).mul(DVec3::new(1.0, 0.3, 1.0)), velocity);
        match aim_in_air(&target, 25.0, G, &air).expect("numbers") {
            Reach::Yes(shots) => {
                found += 1;
                assert!(shots.windows(2).all(|w| w[0].time <= w[1].time));
                hits(&air, &target, &shots, 25.0);
            }
            Reach::No(miss) => {
                none += 1;
                let there = by_rk4(&air, DVec3::ZERO, miss.shot.velocity, miss.shot.time);
                assert!((there - miss.closest).length() < 1e-5, "{miss:?} {there:?}");
                let left = (there - target.at(miss.shot.time)).length();
                assert!((left - miss.distance).abs() < 1e-5 && left > 1e-3, "{miss:?}");
            }
        }
    }
    assert!(found > 15 && none > 2, "{found} {none}");
}

#[test]
fn aiming_without_air_is_aiming_in_vacuum() {
    for d in [DVec3::new(40.0, 8.0, -20.0), DVec3::new(5.0, -30.0, 1.0), DVec3::X * 60.0] {
        let air =
            aim_in_air(&Target::fixed(d), 30.0, G, &Air::VACUUM).expect("numbers").yes().expect("in reach");
        let vacuum = aim(d, 30.0, G).expect("numbers").yes().expect("in reach");
        assert_eq!(air.len(), 2, "{d:?} {air:?}");
        for (a, v) in [(air[0], vacuum.low), (air[1], vacuum.high)] {
            assert!(
                (a.velocity - v.velocity).length() < 1e-6 && (a.time - v.time).abs() < 1e-7,
                "{a:?} {v:?}"
            );
        }
    }
    let d = DVec3::new(80.0, 30.0, 0.0);
    let (a, v) = (
        aim_in_air(&Target::fixed(d), 30.0, G, &Air::VACUUM).expect("numbers").no().expect("out of reach"),
        aim(d, 30.0, G).expect("numbers").no().expect("out of reach"),
    );
    assert!((a.distance - v.distance).abs() < 1e-5 && (a.closest - v.closest).length() < 1e-2, "{a:?} {v:?}");
}

#[test]
fn the_end_of_the_reach_in_air() {
    // The longest range by a search over the angle; just within it there are two shots, just beyond it none.
    let range = |angle: f64| {
        fly(&thrown(30.0, angle), &football(), &floor()).expect("flies").landing().expect("lands").position.x
    };
    let longest = (0..2000).map(|i| range(0.6 + 0.0002 * f64::from(i))).fold(0.0, f64::max);
    let at = |x: f64| aim_in_air(&Target::fixed(DVec3::X * x), 30.0, G, &football()).expect("numbers");
    let inside = at(longest - 1e-3).yes().expect("within reach");
    assert_eq!(inside.len(), 2, "{inside:?}");
    assert!((inside[0].angle - inside[1].angle).abs() < 0.1);
    let miss = at(longest + 0.5).no().expect("beyond it");
    // Below the ground the path goes on and comes a little nearer.
    assert!(miss.distance < 0.5 && miss.distance > 0.2, "{miss:?}");
}

#[test]
fn straight_up_through_air() {
    let target = Target::fixed(DVec3::Y * 15.0);
    let shots = aim_in_air(&target, 25.0, G, &football()).expect("numbers").yes().expect("in reach");
    assert_eq!(shots.len(), 2, "rising and falling: {shots:?}");
    hits(&football(), &target, &shots, 25.0);
    let windy = football().with_wind(DVec3::new(4.0, 0.0, 1.0));
    let shots = aim_in_air(&target, 25.0, G, &windy).expect("numbers").yes().expect("in reach");
    hits(&windy, &target, &shots, 25.0);
    assert!(shots.len() == 2 && shots[1].velocity.x < -0.5, "into the wind: {shots:?}");
    let below = Target::fixed(DVec3::Y * -15.0);
    let shots = aim_in_air(&below, 10.0, G, &football()).expect("numbers").yes().expect("in reach");
    hits(&football(), &below, &shots, 10.0);
    assert!(shots.len() == 2 && shots[0].velocity.y < 0.0 && shots[1].velocity.y > 0.0, "{shots:?}");
    let high = Target::fixed(DVec3::Y * 100.0);
    let miss = aim_in_air(&high, 25.0, G, &football()).expect("numbers").no().expect("out of reach");
    assert!(miss.distance > 70.0 && miss.distance < 85.0 && miss.shot.velocity.y > 24.99, "{miss:?}");
}

#[test]
fn bad_input_is_refused() {
    assert!(Projectile::new(DVec3::X * f64::NAN, DVec3::X, G).is_err());
    assert!(Projectile::new(DVec3::ZERO, DVec3::X, DVec3::ZERO).is_err());
    for speed in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(angles_for_range(speed, 1.0, 9.81).is_err() && angle_for_height(speed, 1.0, 9.81).is_err());
        assert!(aim(DVec3::X, speed, G).is_err() && lead(&Target::fixed(DVec3::X), speed, G).is_err());
        assert!(aim_in_air(&Target::fixed(DVec3::X), speed, G, &football()).is_err());
        assert!(Air::ball(speed, 0.1, 0.5, 1.2).is_err() && Air::ball(1.0, speed, 0.5, 1.2).is_err());
    }
    assert!(angles_for_range(1.0, -1.0, 9.81).is_err() && angles_for_range(1.0, 1.0, 0.0).is_err());
    assert!(angle_for_height(1.0, f64::NAN, 9.81).is_err());
    let e = aim(DVec3::ZERO, 1.0, G).expect_err("at the launch").to_string();
    assert!(e.contains("position") && e.contains("apart from the launch"), "{e}");
    assert!(aim(DVec3::X * f64::INFINITY, 1.0, G).is_err() && slowest(DVec3::X, DVec3::ZERO).is_err());
    assert!(aim_in_air(&Target::fixed(DVec3::X), 1.0, DVec3::ZERO, &football()).is_err());
    let falls = Target { acceleration: G, ..Target::fixed(DVec3::X) };
    assert!(aim_in_air(&falls, 1.0, G, &football()).is_err());
    let heavy = Air { mass: -1.0, ..Air::VACUUM };
    assert!(fly(&thrown(1.0, 1.0), &heavy, &floor()).is_err());
    let windy = Air::VACUUM.with_wind(DVec3::X * f64::NAN);
    assert!(fly(&thrown(1.0, 1.0), &windy, &floor()).is_err());
    assert!(thrown(1.0, 1.0).falls_to(f64::NAN).is_err());
    // Extreme, and still an answer or an error.
    for (d, speed) in [(1e-300, 1e-300), (1e150, 1.0), (1.0, 1e150), (1e-150, 1e150), (1e200, 1e200)] {
        let _ = aim(DVec3::X * d, speed, G);
        let _ = lead(&Target::moving(DVec3::X * d, DVec3::Y * speed), speed, G);
    }
}

/// Every one of these took from seconds to minutes: a far target, or drag that no step could follow.
#[test]
fn far_targets_and_stiff_drag_are_answered_soon() {
    let stiff = |b: f64| Air { linear: b, ..Air::VACUUM };
    let ball = football();
    let at = |x: f64, y: f64| Target::fixed(DVec3::new(x, y, 0.0));
    let mote = Air::ball(1e-9, 5e-3, 0.5, 1.2).expect("air");
    let asked = [
        (at(1e5, 0.0), 30.0, ball),
        (at(1e6, 0.0), 30.0, ball),
        (at(1e6, 0.0), 1e6, ball),
        (at(1e6, 1e6), 30.0, ball),
        (at(1e39, 0.0), 30.0, ball),
        (at(1e39, 0.0), 30.0, Air::VACUUM),
        (at(5.0, 0.0), 30.0, stiff(1e3)),
        (at(40.0, 0.0), 30.0, stiff(1e9)),
        (at(40.0, 0.0), 30.0, stiff(1e30)),
        (at(1.0, 0.0), 30.0, mote),
        (Target::moving(DVec3::new(3.0, 3.0, 0.0), DVec3::X), 30.0, stiff(1e4)),
        (at(200.0, 0.0), 30.0, ball.with_wind(DVec3::Y * 1e3)),
    ];
    for (target, speed, air) in asked {
        let start = std::time::Instant::now();
        let miss = aim_in_air(&target, speed, G, &air).expect("an answer").no().expect("out of reach");
        assert!(start.elapsed().as_secs_f64() < 10.0, "{target:?} {air:?}: {:?}", start.elapsed());
        let all = [miss.distance, miss.shot.time, miss.closest.length()];
        assert!(all.iter().all(|x| x.is_finite()) && miss.distance > 0.0, "{target:?} {air:?}: {miss:?}");
        // No nearer than the stopping distance allows.
        if air.linear > 0.0 && target.velocity == DVec3::ZERO {
            let reach = air.mass * speed / air.linear;
            assert!(miss.closest.x <= reach * (1.0 + 1e-6), "{miss:?} beyond {reach}");
            let sure = (target.position.x - miss.closest.x).abs() <= miss.distance * (1.0 + 1e-9);
            assert!(sure && miss.distance >= (target.position.x - reach) * (1.0 - 1e-9), "{miss:?}");
        }
    }
    // A shot down a deep well: reached, at its terminal speed.
    let start = std::time::Instant::now();
    let shots = aim_in_air(&at(20.0, -1e6), 30.0, G, &ball).expect("an answer").yes().expect("in reach");
    let terminal = jounce_motion::force::terminal_speed(0.43 * 9.81, 0.0, ball.quadratic);
    assert!(shots.iter().all(|s| (s.time * terminal / 1e6 - 1.0).abs() < 1e-3), "{shots:?}");
    let shot = angle_for_height_in_air(30.0, 3.0, G, DVec3::X, &stiff(1e6)).expect("an answer");
    assert!((shot.no().expect("too high").closest.y / 3e-5 - 1.0).abs() < 1e-3, "the stopping distance");
    let (_, landing) = farthest_in_air(30.0, G, DVec3::X, &stiff(1e6)).expect("an answer");
    assert!((landing.position.x / 3e-5 - 1.0).abs() < 1e-2, "{landing:?}");
    // A path that turns a million times a second is not followed to its end: said, and soon.
    let spun = ball.with_spin(DVec3::Z * 1e9);
    let e = aim_in_air(&at(20.0, 0.0), 30.0, G, &spun).expect_err("too many turns").to_string();
    assert!(
        e.contains("it stopped after 400,000 steps") && jounce_motion::limits::SEARCH_STEPS_MAX == 400_000,
        "{e}"
    );
    assert!(farthest_in_air(30.0, G, DVec3::X, &spun).is_err());
    assert!(start.elapsed().as_secs_f64() < 20.0, "{:?}", start.elapsed());
}

#[test]
fn linear_drag_of_any_stiffness_gives_its_closed_form() {
    // x = v τ (1 − e^{−t/τ}), y the same about −g τ; τ = m/b.
    for b in [0.1, 10.0, 1e3, 1e6, 1e12] {
        let air = Air { linear: b, ..Air::VACUUM };
        let tau = 1.0 / b;
        let p = thrown(30.0, 0.7);
        let v = p.launch_velocity();
        let flight = fly(&p, &air, &Plane::new(DVec3::Y * -1e-3, DVec3::Y).expect("plane")).expect("flies");
        for part in [0.1, 0.5, 0.9, 1.0] {
            let e = flight.at(flight.end().time * part);
            let faded = -(-e.time / tau).exp_m1();
            let x = v.x * tau * faded;
            let y = -9.81 * tau * e.time + (v.y + 9.81 * tau) * tau * faded;
            assert!((e.position.x / x - 1.0).abs() < 1e-6, "{b} {part}: {} {x}", e.position.x);
            assert!((e.position.y - y).abs() < 1e-6 * (y.abs() + 1e-3), "{b} {part}: {} {y}", e.position.y);
        }
    }
}

/// These came back as answers full of NaN and ∞.
#[test]
fn numbers_beyond_f64_are_refused_by_name() {
    let far = DVec3::new(1e300, 1.0, 0.0);
    let small = DVec3::new(1e-300, 1.0, 0.0);
    let said = [
        aim(far, 30.0, G).map(|_| ()),
        aim(small, 1e-300, G).map(|_| ()),
        slowest(far, G).map(|_| ()),
        Projectile::new(DVec3::ZERO, far, G).map(|_| ()),
        Projectile::new(DVec3::ZERO, DVec3::Y * 1e300, G).map(|_| ()),
        Projectile::new(DVec3::ZERO, DVec3::Y * 1e80, DVec3::Y * -1e-80).map(|_| ()),
        Projectile::new(DVec3::ZERO, DVec3::Y, DVec3::Y * -1e-300).map(|_| ()),
        thrown(30.0, 0.7).falls_to(-1e308).map(|_| ()),
        angle_for_height(1e300, 1e300, 1e300).map(|_| ()),
        angles_for_range(30.0, 1e308, 1e10).map(|_| ()),
        lead(&Target::moving(far, far), 30.0, G).map(|_| ()),
    ];
    for (i, answer) in said.into_iter().enumerate() {
        let e = answer.expect_err(&format!("row {i} was taken")).to_string();
        assert!(e.contains("expected") && e.contains("is "), "row {i}: {e}");
    }
}
