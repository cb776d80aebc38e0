//! Particles, spring systems, cloth, jelly and bodies that attract each other.
#![expect(clippy::disallowed_methods, reason = "the reference side of a test may use std's functions")]

use jounce_math::DVec3;
use jounce_motion::cloth::{Cloth, ClothDesc};
use jounce_motion::collide::{Ball, Plane};
use jounce_motion::force::G;
use jounce_motion::integrate::{Integrator, Method};
use jounce_motion::jelly::{Jelly, JellyDesc};
use jounce_motion::nbody::{NBody, NBodyDesc};
use jounce_motion::particles::{Particle, ParticleSystem, PointMass, Spring};
use jounce_motion::springs::{Elasticity, MassSpring};
use std::collections::BTreeMap;

const STIFF: Elasticity = Elasticity { stiffness: 100.0, damping: 0.0 };

/// Period of the distance of two masses on a spring, from crossings of the rest length.
fn period(method: Method, m1: f64, m2: f64, dt: f64) -> f64 {
    let mut s = MassSpring::new(method);
    let (a, b) = (s.add_point(m1, DVec3::ZERO).expect("point"), s.add_point(m2, DVec3::X).expect("point"));
    s.add_spring([a, b], STIFF).expect("spring");
    s.set_position(b, DVec3::X * 1.1).expect("position");
    let mut crossings = Vec::new();
    let mut before = 0.1;
    while crossings.len() < 21 {
        s.step(dt).expect("steps");
        let now = s.positions()[b].distance(s.positions()[a]) - 1.0;
        if before > 0.0 && now <= 0.0 {
            crossings.push(s.time() - dt * now / (now - before));
        }
        before = now;
    }
    (crossings[20] - crossings[0]) / 20.0
}

#[test]
fn a_spring_between_two_masses_has_its_period() {
    let (m1, m2) = (1.0, 3.0);
    let exact = std::f64::consts::TAU * (m1 * m2 / ((m1 + m2) * STIFF.stiffness)).sqrt();
    let w = std::f64::consts::TAU / exact;
    let dt = 1e-3;
    for method in Method::ALL {
        let got = period(method, m1, m2, dt);
        // Phase error: (ω Δt)²/24 of the symplectic and second-order methods, at most (ω Δt)²/3 of the Euler methods;
        // the adaptive one steps longer than Δt or not at all. Linear interpolation of crossings adds (ω Δt)²/100.
        let part = w * dt * w * dt;
        assert!((got / exact - 1.0).abs() < part, "{method}: {got} against {exact}");
    }
}

#[test]
fn springs_exchange_momentum_and_keep_energy() {
    let mut s = MassSpring::new(Method::VelocityVerlet);
    for i in 0..6 {
        let i = f64::from(i);
        s.add_point(1.0 + i, DVec3::new(i, (i * 2.3).sin(), (i * 1.7).cos())).expect("point");
    }
    for a in 0..6 {
        for b in a + 1..6 {
            s.add_spring_of_length([a, b], STIFF, 1.2).expect("spring");
        }
    }
    let (p, c, e) = (s.momentum(), s.center_of_mass(), s.energy().total());
    for _ in 0..10_000 {
        s.step(1e-3).expect("steps");
    }
    assert!((s.momentum() - p).length() < 1e-10, "{:?}", s.momentum());
    assert!((s.center_of_mass() - c).length() < 1e-10);
    // Verlet's energy oscillates by (ω Δt)² of itself: ω² ≤ 6·100.
    assert!((s.energy().total() - e).abs() < 600.0 * 1e-6 * e, "{} {e}", s.energy().total());
}

#[test]
fn point_masses_and_a_spring_are_the_spring_system() {
    let mut points = [
        PointMass::new(1.0, DVec3::ZERO).expect("point"),
        PointMass::new(2.0, DVec3::X * 1.3).expect("point"),
    ];
    let spring = Spring::new([0, 1], 100.0, 0.5, 1.0).expect("spring");
    let mut s = MassSpring::new(Method::SemiImplicitEuler);
    let (a, b) = (s.add_point(1.0, DVec3::ZERO).expect("p"), s.add_point(2.0, DVec3::X * 1.3).expect("p"));
    s.add_spring_of_length([a, b], Elasticity { stiffness: 100.0, damping: 0.5 }, 1.0).expect("spring");
    for _ in 0..100 {
        for p in &mut points {
            p.clear_forces();
        }
        spring.update(&mut points).expect("spring");
        for p in &mut points {
            p.update(0.01).expect("moves");
        }
        s.step(0.01).expect("steps");
        assert_eq!(points[0].momentum() + points[1].momentum(), s.momentum());
        assert_eq!([points[0].position, points[1].position], [s.positions()[a], s.positions()[b]]);
    }
    assert!(points[0].kinetic_energy() > 0.0);
    points[0].freeze();
    let at = points[0].position;
    points[0].add_force(DVec3::X * 1e6);
    points[0].update(1.0).expect("stays");
    assert!(points[0].position == at && points[0].is_frozen() && points[0].acceleration() == DVec3::ZERO);
    points[0].thaw();
    points[0].update(1.0).expect("moves");
    assert!(points[0].position != at);
}

#[test]
fn a_force_added_to_a_point_lasts_one_step() {
    let mut s = MassSpring::new(Method::VelocityVerlet);
    let p = s.add_point(2.0, DVec3::ZERO).expect("point");
    s.add_force(p, DVec3::X * 3.0).expect("force");
    s.add_force(p, DVec3::X * 1.0).expect("force");
    for _ in 0..5 {
        s.step(0.5).expect("steps");
        assert_eq!(s.velocities()[p], DVec3::X, "4 N on 2 kg for half a second, once");
    }
}

#[test]
fn the_particle_system_steps_like_the_slide() {
    let mut system = ParticleSystem::default();
    for i in 1..5 {
        let i = f64::from(i);
        system.particles.push(Particle::new(i, DVec3::Y * i, DVec3::X * i).expect("particle"));
    }
    let mut by_hand: Vec<(f64, DVec3, DVec3)> =
        system.particles.iter().map(|p| (p.mass(), p.position, p.velocity)).collect();
    for _ in 0..50 {
        system.add_force(|p| DVec3::Y * (-9.8 * p.mass()));
        system.add_force(|p| p.velocity * -0.3);
        system.euler_step(0.02).expect("steps");
        for (m, x, v) in &mut by_hand {
            let a = (DVec3::Y * (-9.8 * *m) + *v * -0.3) / *m;
            let next = *v + a * 0.02;
            *x += *v * 0.02;
            *v = next;
        }
    }
    for (p, (_, x, v)) in system.particles.iter().zip(&by_hand) {
        assert!((p.position - *x).length() < 1e-12 && (p.velocity - *v).length() < 1e-12);
        assert_eq!(p.force_accumulator, DVec3::ZERO);
    }
    let floor = Plane::new(DVec3::ZERO, DVec3::Y).expect("plane");
    let inside = system.particles.iter().filter(|p| p.position.y < 0.0).count();
    assert!(inside > 0);
    assert_eq!(system.collide(&floor, 0.5, 0.0), inside);
    assert!(system.particles.iter().all(|p| p.position.y >= 0.0 && p.velocity.y.is_finite()));
    let mut rk4 = Integrator::new(Method::Rk4);
    system.step_by(&mut rk4, 0.1).expect("steps");
}

#[test]
fn cloth_has_the_springs_of_the_slide() {
    let (w, h) = (7, 5);
    let none =
        ClothDesc { columns: w, rows: h, structural: None, shear: None, bend: None, ..ClothDesc::default() };
    let some = Some(Elasticity { stiffness: 1.0, damping: 0.0 });
    let count = |desc: ClothDesc| Cloth::new(&desc).expect("cloth").system.spring_ends().len();
    assert_eq!(count(none.clone()), 0);
    assert_eq!(count(ClothDesc { structural: some, ..none.clone() }), (w - 1) * h + w * (h - 1));
    assert_eq!(count(ClothDesc { shear: some, ..none.clone() }), 2 * (w - 1) * (h - 1));
    assert_eq!(count(ClothDesc { bend: some, ..none.clone() }), (w - 2) * h + w * (h - 2));
    let cloth = Cloth::new(&ClothDesc { bend: some, ..none }).expect("cloth");
    // "Connect to every other particle."
    for ends in cloth.system.spring_ends() {
        let [a, b] = ends.map(|e| e as usize);
        assert!(b - a == 2 || b - a == 2 * w);
    }
    let total: f64 = cloth.system.masses().iter().sum();
    assert!((total - 0.2).abs() < 1e-15);
    assert_eq!(cloth.index(7, 0), usize::MAX);
    let across = ClothDesc { across: DVec3::ZERO, ..ClothDesc::default() };
    assert!(Cloth::new(&across).is_err());
    assert!(Cloth::new(&ClothDesc { columns: 1, ..ClothDesc::default() }).is_err());
    assert!(Cloth::new(&ClothDesc { mass: -1.0, ..ClothDesc::default() }).is_err());
    assert!(Cloth::new(&ClothDesc { columns: usize::MAX, rows: 3, ..ClothDesc::default() }).is_err());
}

#[test]
fn a_hanging_cloth_hangs_by_its_weight() {
    let desc = ClothDesc { columns: 9, rows: 9, ..ClothDesc::default() };
    let mut cloth = Cloth::new(&desc).expect("cloth");
    cloth.system.set_gravity(DVec3::Y * -9.81).expect("gravity");
    cloth.system.set_drag(0.05).expect("drag");
    for c in 0..9 {
        cloth.system.freeze(cloth.index(c, 0)).expect("freezes");
    }
    let mut last = cloth.system.energy().total();
    for _ in 0..600 {
        cloth.system.step(0.02).expect("steps");
        let now = cloth.system.energy().total();
        // Implicit Euler of a convex part of the motion only loses energy; the solver's tolerance is all it can gain.
        assert!(now < last + 1e-9, "{now} after {last}");
        last = now;
    }
    let low = (0..9).map(|c| cloth.system.positions()[cloth.index(c, 8)].y).fold(0.0, f64::min);
    assert!(low < -1.0 && low > -1.2, "{low}");
    let speed = cloth.system.velocities().iter().map(|v| v.length()).fold(0.0, f64::max);
    assert!(speed < 1e-3, "at rest: {speed}");
}

#[test]
fn cloth_falls_over_a_ball_and_onto_a_floor() {
    let desc = ClothDesc {
        columns: 15,
        rows: 15,
        origin: DVec3::new(-0.5, 1.0, -0.5),
        down: DVec3::Z,
        ..ClothDesc::default()
    };
    let mut cloth = Cloth::new(&desc).expect("cloth");
    cloth.system.set_gravity(DVec3::Y * -9.81).expect("gravity");
    let ball = Ball::new(DVec3::Y * 0.5, 0.3).expect("ball");
    cloth.system.add_ball(ball, 0.0, 0.3).expect("ball");
    cloth.system.add_plane(Plane::new(DVec3::ZERO, DVec3::Y).expect("plane"), 0.0, 0.3).expect("floor");
    // The caller's own wall, by the hook.
    let mut seen = 0;
    for _ in 0..150 {
        cloth
            .system
            .step_with(
                0.01,
                |_, v, _| v * -0.5,
                |_, x, v| {
                    seen += 1;
                    if x.x > 0.55 {
                        (x.x, v.x) = (0.55, 0.0);
                    }
                },
            )
            .expect("steps");
    }
    assert_eq!(seen, 150 * 225);
    for p in cloth.system.positions() {
        assert!(p.y > -1e-12 && p.x <= 0.55 && p.distance(ball.center()) > 0.3 - 1e-9, "{p:?}");
    }
}

#[test]
fn jelly_has_its_springs_and_a_closed_skin() {
    let n = [3usize, 4, 5];
    let some = Some(Elasticity { stiffness: 1.0, damping: 0.0 });
    let none = JellyDesc { particles: n, structural: None, shear: None, bend: None, ..JellyDesc::default() };
    let count = |desc: JellyDesc| Jelly::new(&desc).expect("jelly").system.spring_ends().len();
    let [x, y, z] = n;
    let structural = (x - 1) * y * z + x * (y - 1) * z + x * y * (z - 1);
    let faces = (x - 1) * (y - 1) * z + (x - 1) * y * (z - 1) + x * (y - 1) * (z - 1);
    let cells = (x - 1) * (y - 1) * (z - 1);
    assert_eq!(count(JellyDesc { structural: some, ..none.clone() }), structural);
    assert_eq!(count(JellyDesc { shear: some, ..none.clone() }), 2 * faces + 4 * cells);
    assert_eq!(
        count(JellyDesc { bend: some, ..none.clone() }),
        (x - 2) * y * z + x * (y - 2) * z + x * y * (z - 2)
    );
    // Every edge of the skin belongs to two triangles that run along it in opposite directions, and the skin encloses
    // the volume of the block, which it does only if it is wound outwards.
    let jelly = Jelly::new(&JellyDesc { size: DVec3::new(1.0, 2.0, 3.0), ..none }).expect("jelly");
    let mut edges = BTreeMap::new();
    let mut volume = 0.0;
    for t in jelly.triangles() {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            *edges.entry((a, b)).or_insert(0) += 1;
        }
        let [a, b, c] = t.map(|i| jelly.system.positions()[i as usize]);
        volume += a.dot(b.cross(c)) / 6.0;
    }
    assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1)));
    assert!((volume - 6.0).abs() < 1e-12, "{volume}");
    assert!(Jelly::new(&JellyDesc { particles: [1, 2, 2], ..JellyDesc::default() }).is_err());
    assert!(Jelly::new(&JellyDesc { size: DVec3::ZERO, ..JellyDesc::default() }).is_err());
}

#[test]
fn jelly_falls_bounces_and_keeps_its_shape() {
    let desc = JellyDesc { particles: [4; 3], center: DVec3::Y, ..JellyDesc::default() };
    let mut jelly = Jelly::new(&desc).expect("jelly");
    jelly.system.set_gravity(DVec3::Y * -9.81).expect("gravity");
    jelly.system.add_plane(Plane::new(DVec3::ZERO, DVec3::Y).expect("plane"), 0.0, 0.2).expect("floor");
    for _ in 0..500 {
        jelly.system.step(0.01).expect("steps");
    }
    let tall = jelly.system.positions().iter().map(|p| p.y).fold(0.0, f64::max);
    assert!(tall > 0.35 && tall < 0.5, "it sags and stands: {tall}");
}

/// Two bodies of G M = a = 1 from the perihelion.
fn kepler(method: Method, e: f64) -> NBody {
    let mut system = NBody::new(NBodyDesc { g: 1.0, method, ..NBodyDesc::default() }).expect("system");
    system.add(1.0, DVec3::ZERO, DVec3::ZERO).expect("sun");
    let v = ((1.0 + e) / (1.0 - e)).sqrt();
    system.add(0.0, DVec3::X * (1.0 - e), DVec3::Y * v).expect("planet");
    system
}

/// Energy per kilogram of the planet.
fn planet_energy(s: &NBody) -> f64 {
    0.5 * s.velocities()[1].length_squared() - 1.0 / s.positions()[1].length()
}

#[test]
fn kepler_orbits() {
    for (e, v) in [(0.5, 1.732_050_8), (0.9, 4.358_898_9)] {
        let mut s = kepler(Method::AdaptiveDopri5, e);
        assert!((s.velocities()[1].y - v).abs() < 5e-8, "speed at the perihelion");
        let start = s.positions()[1];
        // Half a period: the aphelion, at 1 + e; a whole one, 2π: back.
        s.step(std::f64::consts::PI).expect("steps");
        assert!((s.positions()[1] + DVec3::X * (1.0 + e)).length() < 1e-6, "{e} {:?}", s.positions()[1]);
        s.step(std::f64::consts::PI).expect("steps");
        assert!((s.positions()[1] - start).length() < 1e-6, "{e} {:?}", s.positions()[1]);
        assert!((planet_energy(&s) + 0.5).abs() < 1e-8 && (s.energy().total() - 0.0).abs() < 1e-9);
    }
}

#[test]
fn verlets_energy_is_bounded_and_explicit_eulers_drifts() {
    let run = |method: Method, orbits: u32| {
        let mut s = kepler(method, 0.5);
        let dt = std::f64::consts::TAU / 1000.0;
        let mut worst = 0.0f64;
        for _ in 0..1000 * orbits {
            s.step(dt).expect("steps");
            worst = worst.max((planet_energy(&s) + 0.5).abs());
        }
        (worst, planet_energy(&s) + 0.5)
    };
    let (few, many) = (run(Method::VelocityVerlet, 2), run(Method::VelocityVerlet, 50));
    assert!(many.0 < 1.1 * few.0, "bounded: {few:?} {many:?}");
    let (few, many) = (run(Method::ExplicitEuler, 2), run(Method::ExplicitEuler, 8));
    assert!(few.1 > 0.0 && many.1 > 1.5 * few.1, "drifts outwards: {few:?} {many:?}");
}

/// A cloud of bodies of different masses; the same every time.
fn cloud(n: usize, desc: NBodyDesc) -> NBody {
    let mut s = NBody::new(desc).expect("system");
    let mut seed = 1u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    for _ in 0..n {
        let x = DVec3::new(random(), random(), random());
        s.add(1.0 + random(), x * (4.0 * x.length()), DVec3::new(random(), random(), random()))
            .expect("body");
    }
    s
}

#[test]
fn the_tree_pulls_like_the_sum_of_pairs() {
    let n = 3000;
    let desc = NBodyDesc { g: 1.0, softening: 0.01, tree_above: usize::MAX, ..NBodyDesc::default() };
    let exact = cloud(n, desc).accelerations();
    let rms = |a: &[DVec3]| {
        let off: f64 = a.iter().zip(&exact).map(|(a, e)| (*a - *e).length_squared()).sum();
        let size: f64 = exact.iter().map(|e| e.length_squared()).sum();
        (off / size).sqrt()
    };
    // The error of a cube's pull is its quadrupole, about θ²/12 of it in the mean, and random in sign.
    for (opening_angle, limit) in [(0.3, 0.002), (0.5, 0.006), (0.8, 0.02)] {
        let mut tree = cloud(n, NBodyDesc { opening_angle, tree_above: 0, ..desc });
        let (a, b) = (tree.accelerations(), tree.accelerations());
        // Far below the limit, cubes are opened that need not be.
        assert!(rms(&a) < limit && rms(&a) > 0.1 * limit, "{opening_angle}: {}", rms(&a));
        assert_eq!(a, b);
    }
    // Bodies on top of each other end in one leaf.
    let mut pile = NBody::new(NBodyDesc { tree_above: 0, ..desc }).expect("system");
    for _ in 0..100 {
        pile.add(1.0, DVec3::X, DVec3::ZERO).expect("body");
    }
    pile.add(1.0, DVec3::ZERO, DVec3::ZERO).expect("body");
    let a = pile.accelerations();
    assert!(a.iter().all(|a| a.is_finite()) && (a[100].x - 100.0).abs() < 0.1 && (a[0].x + 1.0).abs() < 0.01);
}

#[test]
fn a_cloud_keeps_momentum_angular_momentum_and_energy() {
    let mut s = cloud(60, NBodyDesc { g: 0.1, softening: 0.1, ..NBodyDesc::default() });
    let (p, l, e) = (s.momentum(), s.angular_momentum(), s.energy().total());
    for _ in 0..1000 {
        s.step(1e-3).expect("steps");
    }
    assert!((s.momentum() - p).length() < 1e-11, "all pairs: to rounding");
    assert!((s.angular_momentum() - l).length() < 1e-10);
    assert!((s.energy().total() - e).abs() < 1e-3 * e.abs());
    assert!((s.time() - 1.0).abs() < 1e-12);
}

#[test]
fn bad_input_is_refused() {
    let mut s = MassSpring::new(Method::Rk4);
    for mass in [0.0, -1.0, f64::NAN] {
        assert!(s.add_point(mass, DVec3::ZERO).is_err());
        assert!(PointMass::new(mass, DVec3::ZERO).is_err());
        assert!(Particle::new(mass, DVec3::ZERO, DVec3::ZERO).is_err());
    }
    let a = s.add_point(1.0, DVec3::ZERO).expect("point");
    let e = s.add_spring([a, 7], STIFF).expect_err("no such point").to_string();
    assert!(e.contains('7') && e.contains("there are 1"), "{e}");
    assert!(s.add_spring([a, a], STIFF).is_err());
    assert!(s.freeze(1).is_err() && s.thaw(1).is_err());
    assert!(s.set_position(0, DVec3::X * f64::NAN).is_err() && s.set_velocity(9, DVec3::X).is_err());
    assert!(s.add_force(0, DVec3::X * f64::INFINITY).is_err());
    assert!(s.set_gravity(DVec3::X * f64::NAN).is_err() && s.set_drag(-1.0).is_err());
    assert!(s.step(f64::NAN).is_err() && !s.is_frozen(5));
    let floor = Plane::new(DVec3::ZERO, DVec3::Y).expect("plane");
    assert!(s.add_plane(floor, -1.0, 0.0).is_err() && s.add_plane(floor, 1.0, 2.0).is_err());
    let b = s.add_point(1.0, DVec3::X).expect("point");
    let bad = Elasticity { stiffness: -1.0, damping: 0.0 };
    assert!(s.add_spring([a, b], bad).is_err() && s.add_spring_of_length([a, b], STIFF, -1.0).is_err());
    assert!(Spring::new([0, 0], 1.0, 0.0, 1.0).is_err());
    assert!(Spring::new([0, 3], 1.0, 0.0, 1.0).expect("spring").update(&mut []).is_err());
    // Far beyond the stable step: an error in the end, and nothing moved by the step that failed.
    s.add_spring_of_length([a, b], STIFF, 0.5).expect("spring");
    let failed = (0..10_000).find_map(|_| {
        let before = s.positions().to_vec();
        s.step(10.0).is_err().then_some(before)
    });
    assert_eq!(failed.as_deref(), Some(s.positions()));
    assert!(NBody::new(NBodyDesc { g: f64::NAN, ..NBodyDesc::default() }).is_err());
    assert!(NBody::new(NBodyDesc { opening_angle: 0.0, ..NBodyDesc::default() }).is_err());
    let mut n = NBody::new(NBodyDesc::default()).expect("system");
    assert!(n.add(-1.0, DVec3::ZERO, DVec3::ZERO).is_err());
    assert!(n.add(1.0, DVec3::X * f64::NAN, DVec3::ZERO).is_err());
    n.step(1.0).expect("nothing to move");
    assert!(NBodyDesc::default().g == G);
}
