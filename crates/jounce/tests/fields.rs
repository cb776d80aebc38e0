//! Fields on bodies beside their closed forms, and what a bad description gets.

mod common;

use jounce::math::scalar::{f32s, f64s};
use jounce::prelude::*;
use jounce::{Error, FieldHook, Gust, Settings};
use std::sync::Arc;

const G: f64 = 9.81;

fn empty(gravity: f64, rate_hz: f64) -> World {
    let settings = Settings { sleep: false, ..Settings::default() };
    World::new(WorldDesc {
        gravity: Vec3::new(0.0, -gravity as f32, 0.0),
        rate_hz,
        settings,
        ..WorldDesc::default()
    })
    .unwrap()
}

fn ball_at(world: &mut World, at: [f64; 3], radius: f32, mass: f32, velocity: [f32; 3]) -> BodyId {
    let mut desc = BodyDesc::dynamic().at(at).shape(ShapeDesc::sphere(radius).mass(mass));
    desc.velocity = Vec3::from_array(velocity);
    world.add_body(desc).unwrap()
}

fn run(world: &mut World, seconds: f64) {
    for _ in 0..(seconds / world.dt()).round() as u32 {
        world.step().unwrap();
    }
}

fn height(world: &World, body: BodyId) -> f64 {
    world.body(body).unwrap().position().y
}

#[test]
fn a_uniform_field_adds_to_gravity_and_ends_with_its_region() {
    let mut w = empty(G, 60.0);
    w.add_field(
        FieldDesc::new(FieldLaw::Uniform { acceleration: Vec3::new(0.0, 9.81, 0.0) }).within(Region::Box {
            center: DVec3::ZERO,
            half: DVec3::splat(1.0),
            falloff: 0.0,
        }),
    )
    .unwrap();
    let inside = ball_at(&mut w, [0.0, 0.5, 0.0], 0.1, 1.0, [0.0; 3]);
    let outside = ball_at(&mut w, [3.0, 0.5, 0.0], 0.1, 1.0, [0.0; 3]);
    run(&mut w, 1.0);
    assert!((height(&w, inside) - 0.5).abs() < 1e-6, "weightless inside");
    // Semi-implicit Euler with h = 1/240: ½gt² + ½gth.
    let fallen = 0.5 - (0.5 * G + 0.5 * G / 240.0);
    assert!((height(&w, outside) - fallen).abs() < 1e-4, "{} {fallen}", height(&w, outside));
}

#[test]
fn layers_choose_who_feels_a_field() {
    let mut w = empty(0.0, 60.0);
    w.add_field(FieldDesc::new(FieldLaw::Uniform { acceleration: Vec3::X }).on_layers(2)).unwrap();
    let on = |layers| {
        let filter = Filter { layers, ..Filter::default() };
        BodyDesc::dynamic()
            .at([0.0, f64::from(layers) * 5.0, 0.0])
            .shape(ShapeDesc::sphere(0.5).filter(filter))
    };
    let (a, b) = (w.add_body(on(1)).unwrap(), w.add_body(on(2)).unwrap());
    run(&mut w, 1.0);
    assert_eq!(w.body(a).unwrap().velocity(), Vec3::ZERO);
    assert!((w.body(b).unwrap().velocity().x - 1.0).abs() < 1e-5);
}

#[test]
fn an_orbit_closes_after_its_period() {
    // a = μ = 1, e = 0.5: from periapsis at 0.5 with √3; T = 2π.
    let mut w = empty(0.0, 240.0);
    w.add_field(FieldDesc::new(FieldLaw::Point { center: DVec3::ZERO, mu: 1.0, softening: 0.0 })).unwrap();
    let b = ball_at(&mut w, [0.5, 0.0, 0.0], 0.01, 1.0, [0.0, 1.732_050_8, 0.0]);
    let energy = w.energy().total();
    assert!((energy + 0.5).abs() < 1e-6, "E = −μ/2a");
    let (mut previous, mut crossing, mut worst) = (1.0, 0.0, 0.0f64);
    while crossing == 0.0 && w.time() < 8.0 {
        w.step().unwrap();
        let y = height(&w, b);
        if previous < 0.0 && y >= 0.0 {
            crossing = w.time() - w.dt() * y / (y - previous);
        }
        previous = y;
        worst = f64s::max(worst, (w.energy().total() - energy).abs());
    }
    // Symplectic Euler, h = 1/960: the orbit's shadow differs by O(h ω_peri), ω_peri = 2√3.
    let h = 1.0 / 960.0;
    assert!((crossing - core::f64::consts::TAU).abs() < core::f64::consts::TAU * 3.47 * h, "{crossing}");
    assert!(worst < 4.0 * 3.47 * h, "energy stays within O(h): {worst}");
}

#[test]
fn two_bodies_circle_their_common_centre_and_keep_momentum() {
    let mut w = empty(0.0, 240.0);
    let (a, b) = (
        ball_at(&mut w, [-0.25, 0.0, 0.0], 0.01, 3.0, [0.0, -0.5, 0.0]),
        ball_at(&mut w, [0.75, 0.0, 0.0], 0.01, 1.0, [0.0, 1.5, 0.0]),
    );
    // d = 1, ω² = G(m₁ + m₂)/d³ = 4: ω = 2.
    w.add_field(FieldDesc::new(FieldLaw::NBody { bodies: vec![a, b], g: 1.0, softening: 0.0 })).unwrap();
    run(&mut w, core::f64::consts::PI * 240.0 / 240.0);
    let d = w.body(b).unwrap().position() - w.body(a).unwrap().position();
    assert!((d.length() - 1.0).abs() < 0.01, "{}", d.length());
    let p = w.momentum().linear;
    assert!(p.length() < 1e-5, "{p:?}");
}

#[test]
fn a_falling_ball_reaches_exactly_its_terminal_speed() {
    // Air: m g = ½ρ C_d A v².
    let mut w = empty(G, 60.0);
    w.add_field(FieldDesc::new(FieldLaw::Drag { density: 1.2, viscosity: 0.0 })).unwrap();
    let b = ball_at(&mut w, [0.0, 5000.0, 0.0], 0.11, 0.43, [0.0; 3]);
    run(&mut w, 40.0);
    let c = 0.5 * 1.2 * 0.47 * core::f64::consts::PI * 0.11 * 0.11;
    let expected = (0.43 * G / c).sqrt();
    let got = -f64::from(w.body(b).unwrap().velocity().y);
    assert!((got / expected - 1.0).abs() < 1e-4, "{got} {expected}");
}

#[test]
fn stokes_drag_shorter_than_a_substep_gives_the_terminal_speed() {
    // Steel in glycerin, r = 1 mm: 0.0101115 m/s. Buoyancy by a water field of glycerin; no form drag, no calming.
    let mut w = empty(G, 60.0);
    let mut glycerin = FieldDesc::water(10.0);
    if let FieldLaw::Water { density, viscosity, linear_drag, .. } = &mut glycerin.law {
        (*density, *viscosity, *linear_drag) = (1260.0, 1.41, 0.0);
    }
    w.add_field(glycerin).unwrap();
    let aero = Aero { drag: Some(0.0), ..Aero::default() };
    let shape = ShapeDesc::sphere(0.001).density(7800.0).aero(aero);
    let b = w.add_body(BodyDesc::dynamic().at([0.0, 0.0, 0.0]).shape(shape)).unwrap();
    run(&mut w, 0.5);
    let got = -w.body(b).unwrap().velocity().y;
    assert!((got / 0.010_111_5 - 1.0).abs() < 1e-3, "{got}");
}

#[test]
fn drag_never_reverses_a_velocity() {
    for density in [1.0, 1e3, 1e6] {
        let mut w = empty(0.0, 60.0);
        w.add_field(FieldDesc::new(FieldLaw::Drag { density, viscosity: 1e3 })).unwrap();
        let b = ball_at(&mut w, [0.0; 3], 1.0, 0.001, [100.0, 0.0, 0.0]);
        for _ in 0..20 {
            w.step().unwrap();
            let v = w.body(b).unwrap().velocity();
            assert!(v.x >= 0.0 && v.x.is_finite() && v.y == 0.0, "{v:?}");
        }
    }
}

#[test]
fn a_ball_comes_to_drift_with_the_wind() {
    let mut w = empty(0.0, 60.0);
    w.add_field(FieldDesc::wind([3.0, 0.0, -4.0])).unwrap();
    let b = ball_at(&mut w, [0.0; 3], 0.5, 0.05, [0.0; 3]);
    run(&mut w, 30.0);
    let v = w.body(b).unwrap().velocity();
    assert!((v - Vec3::new(3.0, 0.0, -4.0)).length() < 0.05, "{v:?}");
}

#[test]
fn floating_balls_sink_to_the_depth_of_their_density() {
    // Depth of the lowest point ÷ diameter for density ratios ¼, ½, ¾.
    let mut w = empty(G, 60.0);
    w.add_field(FieldDesc::water(0.0)).unwrap();
    for (i, (ratio, depth)) in [(0.25, 0.326_352), (0.5, 0.5), (0.75, 0.673_648)].into_iter().enumerate() {
        let shape = ShapeDesc::sphere(0.5).density(1000.0 * ratio);
        let b = w.add_body(BodyDesc::dynamic().at([3.0 * i as f64, 0.4, 0.0]).shape(shape)).unwrap();
        let mut other = w.clone();
        run(&mut other, 60.0);
        let got = 0.5 - height(&other, b);
        assert!((got - depth).abs() < 1e-3, "ratio {ratio}: {got} {depth}");
    }
}

#[test]
fn a_light_box_rises_and_stays_quiet() {
    // A waterplane spring far above what a substep can follow: h²k/m = g h²/(ratio · depth) > 1.
    let mut w = empty(G, 60.0);
    w.add_field(FieldDesc::water(0.0)).unwrap();
    let shape = ShapeDesc::cuboid([0.005, 0.005, 0.005]).density(1.0);
    let b = w.add_body(BodyDesc::dynamic().at([0.0, -0.5, 0.0]).shape(shape)).unwrap();
    run(&mut w, 20.0);
    let (y, v) = (height(&w, b), w.body(b).unwrap().velocity().length());
    assert!(y > 0.0 && y < 0.01 && v < 0.05, "{y} {v}");
}

#[test]
fn a_spinning_ball_curves_and_gains_no_speed() {
    let mut w = empty(0.0, 60.0);
    w.add_field(FieldDesc::new(FieldLaw::Drag { density: 1.2, viscosity: 0.0 })).unwrap();
    let aero = Aero { drag: Some(0.0), lift: 1.0, ..Aero::default() };
    let mut desc = BodyDesc::dynamic().shape(ShapeDesc::sphere(0.11).mass(0.43).aero(aero));
    (desc.velocity, desc.angular_velocity) = (Vec3::X * 20.0, Vec3::Y * 50.0);
    let b = w.add_body(desc).unwrap();
    run(&mut w, 1.0);
    let v = w.body(b).unwrap().velocity();
    // ω×v with ω = y, v = x points to −z; the turn rate is ½ρ A r ω/m.
    let rate = 0.5 * 1.2 * core::f32::consts::PI * 0.11 * 0.11 * 0.11 * 50.0 / 0.43;
    assert!((v.length() - 20.0).abs() < 1e-3, "{v:?}");
    assert!((f32s::atan2(-v.z, v.x) - rate).abs() < 2e-3, "{v:?} {rate}");
}

#[test]
fn a_free_ball_in_a_turning_frame_walks_a_straight_line_among_the_stars() {
    let mut w = empty(0.0, 240.0);
    let omega = 0.5;
    w.add_field(FieldDesc::new(FieldLaw::RotatingFrame {
        origin: DVec3::ZERO,
        angular_velocity: Vec3::Y * omega as f32,
        angular_acceleration: Vec3::ZERO,
    }))
    .unwrap();
    // At rest among the stars at (1, 0, 0): in the frame v = −Ω×r = (0, 0, ½).
    let b = ball_at(&mut w, [1.0, 0.0, 0.0], 0.01, 1.0, [0.0, 0.0, 0.5]);
    run(&mut w, 4.0);
    let p = w.body(b).unwrap().position();
    let (s, c) = (f64s::sin(omega * 4.0), f64s::cos(omega * 4.0));
    let stars = DVec3::new(c * p.x + s * p.z, p.y, -s * p.x + c * p.z);
    // First order: ½ (Ω²r + 2Ωv) t h.
    let bound = 0.5 * (omega * omega + 2.0 * omega * 0.5) * 4.0 / 960.0 * 4.0;
    assert!((stars - DVec3::X).length() < bound, "{stars:?} {bound}");
}

#[test]
fn a_hook_gives_its_own_law() {
    let mut w = empty(0.0, 240.0);
    let spring: FieldHook = Arc::new(|at| (at.position * -4.0).as_vec3());
    w.set_field_hook("spring", Some(spring));
    w.add_field(FieldDesc::new(FieldLaw::User { hook: "spring".into() })).unwrap();
    let b = ball_at(&mut w, [1.0, 0.0, 0.0], 0.1, 1.0, [0.0; 3]);
    run(&mut w, core::f64::consts::PI * 0.5 * 240.0 / 240.0);
    assert!(w.body(b).unwrap().position().x < -0.99, "half a period of ω = 2");
    assert!(matches!(
        w.add_field(FieldDesc::new(FieldLaw::User { hook: "unheard of".into() })),
        Err(Error::BadValue { field: "hook", .. })
    ));
}

#[test]
fn a_wall_shields_from_a_blast() {
    let mut w = empty(0.0, 60.0);
    w.add_body(BodyDesc::fixed().at([2.0, 0.0, 0.0]).shape(ShapeDesc::cuboid([0.1, 3.0, 3.0]))).unwrap();
    let shielded = ball_at(&mut w, [4.0, 0.0, 0.0], 0.5, 10.0, [0.0; 3]);
    let open = ball_at(&mut w, [-4.0, 0.0, 0.0], 0.5, 10.0, [0.0; 3]);
    let far = ball_at(&mut w, [0.0, 50.0, 0.0], 0.5, 10.0, [0.0; 3]);
    w.explode(Explosion::new([0.0, 0.0, 0.0], 10.0, 100.0)).unwrap();
    assert_eq!(w.body(shielded).unwrap().velocity(), Vec3::ZERO);
    assert_eq!(w.body(far).unwrap().velocity(), Vec3::ZERO);
    let v = w.body(open).unwrap().velocity();
    // ∫ p f r² cos θ dΩ over what is seen of the ball, r = d cos θ − √(a² − d² sin²θ).
    let (d, a, n) = (4.0f64, 0.5f64, 10_000);
    let sum: f64 = (0..n)
        .map(|i| {
            let cos_rim = (1.0 - a * a / (d * d)).sqrt();
            let cos = 1.0 - (1.0 - cos_rim) * (f64::from(i) + 0.5) / f64::from(n);
            let r = d * cos - f64s::max(a * a - d * d * (1.0 - cos * cos), 0.0).sqrt();
            let solid = core::f64::consts::TAU * (1.0 - cos_rim) / f64::from(n);
            100.0 * (1.0 - r / 10.0) * (1.0 - r / 10.0) * r * r * cos * solid
        })
        .sum();
    let rough = (sum / 10.0) as f32;
    assert!((-v.x / rough - 1.0).abs() < 0.02 && v.y.abs() < 1e-3 && v.z.abs() < 1e-3, "{v:?} {rough}");
}

#[test]
fn nothing_but_a_field_wakes_what_sleeps_and_gusts_keep_awake() {
    let mut w = World::new(WorldDesc::default()).unwrap();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space([0.0, 1.0, 0.0]))).unwrap();
    let b = ball_at(&mut w, [0.0, 0.5, 0.0], 0.5, 1.0, [0.0; 3]);
    run(&mut w, 2.0);
    assert!(!w.body(b).unwrap().is_awake());
    let gust = Gust { speed: 5.0, size: 5.0, time_s: 2.0, seed: 1 };
    let id = w.add_field(FieldDesc::new(FieldLaw::Wind { velocity: Vec3::X, gust: Some(gust) })).unwrap();
    assert!(w.body(b).unwrap().is_awake());
    run(&mut w, 5.0);
    assert!(w.body(b).unwrap().is_awake());
    w.remove_field(id).unwrap();
    assert!(w.remove_field(id).is_err());
    run(&mut w, 60.0);
    assert!(w.counts().islands_asleep <= 1);
}

#[test]
fn bad_descriptions_are_refused_by_name() {
    let mut w = empty(G, 60.0);
    let nan = f32::NAN;
    let laws = [
        FieldLaw::Uniform { acceleration: Vec3::new(nan, 0.0, 0.0) },
        FieldLaw::Point { center: DVec3::new(f64::INFINITY, 0.0, 0.0), mu: 1.0, softening: 0.0 },
        FieldLaw::Point { center: DVec3::ZERO, mu: f64::NAN, softening: 0.0 },
        FieldLaw::Point { center: DVec3::ZERO, mu: 1.0, softening: -1.0 },
        FieldLaw::Wind { velocity: Vec3::splat(1e9), gust: None },
        FieldLaw::Wind {
            velocity: Vec3::ZERO,
            gust: Some(Gust { speed: 1.0, size: 0.0, time_s: 1.0, seed: 0 }),
        },
        FieldLaw::Drag { density: -1.0, viscosity: 0.0 },
        FieldLaw::Drag { density: nan, viscosity: 0.0 },
        FieldLaw::Vortex {
            center: DVec3::ZERO,
            axis: Vec3::ZERO,
            speed: 1.0,
            core_radius: 1.0,
            inflow: 0.0,
            updraft: 0.0,
        },
        FieldLaw::RotatingFrame {
            origin: DVec3::ZERO,
            angular_velocity: Vec3::splat(nan),
            angular_acceleration: Vec3::ZERO,
        },
        FieldLaw::NBody { bodies: vec![BodyId::from_bits(7)], g: 1.0, softening: 0.0 },
    ];
    let before = w.hash();
    for law in laws {
        let e = w.add_field(FieldDesc::new(law.clone())).unwrap_err();
        assert!(!format!("{e}").is_empty(), "{law:?}");
    }
    assert!(w.explode(Explosion::new([0.0; 3], 0.0, 1.0)).is_err());
    assert!(w.explode(Explosion::new([0.0; 3], 1.0, nan)).is_err());
    assert_eq!(before, w.hash(), "a refused command changes nothing");
}

#[test]
fn bits_do_not_depend_on_threads() {
    let build = |tasks: Tasks| {
        let mut w = World::new(WorldDesc::default()).unwrap();
        w.set_tasks(tasks);
        w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space([0.0, 1.0, 0.0]))).unwrap();
        let gust = Gust { speed: 4.0, size: 2.0, time_s: 1.0, seed: 9 };
        w.add_field(FieldDesc::new(FieldLaw::Wind { velocity: Vec3::X * 3.0, gust: Some(gust) })).unwrap();
        w.add_field(FieldDesc::water(1.0)).unwrap();
        let mut all = Vec::new();
        for i in 0..200u32 {
            let at = [f64::from(i % 10), 1.0 + f64::from(i / 100), f64::from(i / 10 % 10)];
            let shape = match i % 4 {
                0 => ShapeDesc::sphere(0.4),
                1 => ShapeDesc::cuboid([0.4, 0.2, 0.3]),
                2 => ShapeDesc::capsule(0.2, 0.2),
                _ => ShapeDesc::cone(0.4, 0.3),
            };
            all.push(w.add_body(BodyDesc::dynamic().at(at).shape(shape.density(300.0))).unwrap());
        }
        w.add_field(FieldDesc::new(FieldLaw::NBody { bodies: all, g: 1e-4, softening: 0.5 })).unwrap();
        let mut hashes = Vec::new();
        for i in 0..60 {
            if i == 30 {
                w.explode(Explosion::new([5.0, 0.5, 5.0], 6.0, 2000.0)).unwrap();
            }
            w.step().unwrap();
            hashes.push(w.hash());
        }
        hashes
    };
    let serial = build(Tasks::serial());
    for tasks in [Tasks::pool(2), Tasks::pool(4), Tasks::chaos(3), Tasks::chaos_pool(3, 5)] {
        assert_eq!(serial, build(tasks));
    }
}

#[test]
fn the_hash_knows_where_a_field_acts() {
    let with = |radius: f64| {
        let mut w = empty(G, 60.0);
        let region = Region::Sphere { center: DVec3::new(9.0, 0.0, 0.0), radius, falloff: 0.0 };
        w.add_field(FieldDesc::air().within(region)).unwrap();
        w.hash()
    };
    assert_eq!(with(1.0), with(1.0));
    assert_ne!(with(1.0), with(2.0), "neither reaches the origin");
}
