//! Every number of every description and call with every special value: refused by name with nothing changed, or taken with
//! an answer that is finite or an error. No panic (arithmetic is checked here), and no loop without end.
#![expect(clippy::disallowed_methods, reason = "a hang is a failure: the test reads the clock")]

use jounce_math::{DMat3, DQuat, DVec3};
use jounce_motion::ballistics::{
    Air, Projectile, Target, aim, aim_in_air, angle_for_height, angle_for_height_in_air, angles_for_range,
    farthest_in_air, fly, lead, slowest,
};
use jounce_motion::cloth::{Cloth, ClothDesc};
use jounce_motion::collide::{Ball, Plane, edge_face, edge_plane, faces_cut, plane_plane, respond, split};
use jounce_motion::integrate::{Dopri5, Integrator, Method, Options};
use jounce_motion::jelly::{Jelly, JellyDesc};
use jounce_motion::kinematics::{
    acceleration_of, constant_acceleration, constant_velocity, displacement, varying_acceleration,
    velocity_change, velocity_of,
};
use jounce_motion::momentum::{RigidBody, push, turn, world_inertia};
use jounce_motion::nbody::{NBody, NBodyDesc};
use jounce_motion::particles::{Particle, ParticleSystem, PointMass, Spring};
use jounce_motion::springs::{Elasticity, MassSpring};
use jounce_motion::{Error, force, limits};
use std::time::{Duration, Instant};

const SPECIALS: [f64; 24] = [
    0.0,
    -0.0,
    5e-324,
    -5e-324,
    f64::MIN_POSITIVE,
    1e-300,
    -1e-300,
    1e-150,
    1e-30,
    -1e-30,
    1e12,
    -1e12,
    1e30,
    -1e30,
    1e150,
    1e160,
    -1e160,
    1e300,
    f64::MAX,
    f64::MIN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    -1.0,
];

const G: DVec3 = DVec3::new(0.0, -9.81, 0.0);
/// Longest a call may take, on a machine that does other things too.
const CALL_MAX: Duration = Duration::from_secs(20);

fn at(x: f64) -> DVec3 {
    DVec3::new(0.0, x, 1.0)
}

fn chain(method: Method) -> MassSpring {
    let mut s = MassSpring::new(method);
    for i in 0..3 {
        s.add_point(1.0, DVec3::X * f64::from(i)).expect("point");
    }
    for i in 0..2 {
        s.add_spring([i, i + 1], Elasticity { stiffness: 100.0, damping: 0.1 }).expect("spring");
    }
    s.set_gravity(G).expect("gravity");
    s
}

fn finite(all: &[DVec3]) -> bool {
    all.iter().all(|v| v.is_finite())
}

/// What a call gave: nothing to look at, or numbers that must be finite.
type Answer = Result<Vec<DVec3>, Error>;
/// Name that is refused (empty: whatever is finite is taken), and the call.
type Row = (&'static str, fn(f64) -> Answer);

fn none<T>(r: Result<T, Error>) -> Answer {
    r.map(|_| Vec::new())
}

/// A chain that is changed, then takes a step.
fn stepped(change: impl FnOnce(&mut MassSpring) -> Result<(), Error>) -> Answer {
    let mut s = chain(Method::SemiImplicitEuler);
    let before = s.clone();
    if let Err(e) = change(&mut s) {
        assert_eq!((s.positions(), s.velocities()), (before.positions(), before.velocities()), "{e}");
        return Err(e);
    }
    // A step that overflows is an error, and moves nothing.
    let start = s.positions().to_vec();
    match s.step(0.01) {
        Ok(_) => Ok(s.positions().iter().chain(s.velocities()).copied().collect()),
        Err(Error::Failed { .. }) => {
            assert_eq!(s.positions(), start);
            Ok(Vec::new())
        }
        Err(e) => Err(e),
    }
}

fn cloth(change: impl FnOnce(&mut ClothDesc)) -> Answer {
    let mut d = ClothDesc { columns: 3, rows: 3, ..ClothDesc::default() };
    change(&mut d);
    none(Cloth::new(&d))
}

fn jelly(change: impl FnOnce(&mut JellyDesc)) -> Answer {
    let mut d = JellyDesc { particles: [2; 3], ..JellyDesc::default() };
    change(&mut d);
    none(Jelly::new(&d))
}

fn planets(change: impl FnOnce(&mut NBodyDesc), x: DVec3, v: DVec3, mass: f64) -> Answer {
    let mut d = NBodyDesc { g: 1.0, ..NBodyDesc::default() };
    change(&mut d);
    let mut n = NBody::new(d)?;
    n.add(1.0, DVec3::ZERO, DVec3::ZERO)?;
    n.add(mass, x, v)?;
    match n.step(0.01) {
        Ok(_) => Ok(n.positions().to_vec()),
        Err(Error::Failed { .. }) => Ok(Vec::new()),
        Err(e) => Err(e),
    }
}

const ROWS: &[Row] = &[
    ("mass", |x| stepped(|s| s.add_point(x, DVec3::Y).map(|_| ()))),
    ("position", |x| stepped(|s| s.add_point(1.0, at(x)).map(|_| ()))),
    ("position", |x| stepped(|s| s.set_position(1, at(x)))),
    ("velocity", |x| stepped(|s| s.set_velocity(1, at(x)))),
    ("force", |x| stepped(|s| s.add_force(1, at(x)))),
    ("gravity", |x| stepped(|s| s.set_gravity(at(x)))),
    ("drag", |x| stepped(|s| s.set_drag(x))),
    ("stiffness", |x| {
        stepped(|s| s.add_spring([0, 2], Elasticity { stiffness: x, damping: 0.0 }).map(|_| ()))
    }),
    ("damping", |x| stepped(|s| s.add_spring([0, 2], Elasticity { stiffness: 1.0, damping: x }).map(|_| ()))),
    ("rest_length", |x| {
        let e = Elasticity { stiffness: 1.0, damping: 0.0 };
        stepped(|s| s.add_spring_of_length([0, 2], e, x).map(|_| ()))
    }),
    ("k_r", |x| stepped(|s| s.add_plane(Plane::new(DVec3::ZERO, DVec3::Y)?, x, 0.5))),
    ("k_f", |x| stepped(|s| s.add_plane(Plane::new(DVec3::ZERO, DVec3::Y)?, 0.5, x))),
    ("k_r", |x| stepped(|s| s.add_ball(Ball::new(DVec3::ZERO, 1.0)?, x, 0.5))),
    ("dt", |x| {
        let mut s = chain(Method::Rk4);
        match s.step(x) {
            Ok(_) => Ok(s.positions().to_vec()),
            Err(Error::Failed { .. }) => Ok(Vec::new()),
            Err(e) => Err(e),
        }
    }),
    ("point", |x| none(Plane::new(at(x), DVec3::Y))),
    ("normal", |x| Plane::new(DVec3::ZERO, DVec3::Y * x).map(|p| vec![p.normal()])),
    ("center", |x| none(Ball::new(at(x), 1.0))),
    ("radius", |x| none(Ball::new(DVec3::ZERO, x))),
    ("origin", |x| cloth(|d| d.origin = at(x))),
    ("across", |x| cloth(|d| d.across = DVec3::X * x)),
    ("down", |x| cloth(|d| d.down = DVec3::Y * x)),
    ("mass", |x| cloth(|d| d.mass = x)),
    ("stiffness", |x| cloth(|d| d.shear = Some(Elasticity { stiffness: x, damping: 0.0 }))),
    ("damping", |x| cloth(|d| d.bend = Some(Elasticity { stiffness: 1.0, damping: x }))),
    ("center", |x| jelly(|d| d.center = at(x))),
    ("size", |x| jelly(|d| d.size.y = x)),
    ("mass", |x| jelly(|d| d.mass = x)),
    ("stiffness", |x| jelly(|d| d.structural = Some(Elasticity { stiffness: x, damping: 0.0 }))),
    ("g", |x| planets(|d| d.g = x, DVec3::X, DVec3::Y, 1.0)),
    ("softening", |x| planets(|d| d.softening = x, DVec3::X, DVec3::Y, 1.0)),
    ("opening_angle", |x| planets(|d| d.opening_angle = x, DVec3::X, DVec3::Y, 1.0)),
    ("mass", |x| planets(|_| (), DVec3::X, DVec3::Y, x)),
    ("position", |x| planets(|_| (), at(x), DVec3::Y, 1.0)),
    ("velocity", |x| planets(|_| (), DVec3::X, at(x), 1.0)),
    // The same through the tree.
    ("position", |x| planets(|d| d.tree_above = 0, at(x), DVec3::Y, 1.0)),
    ("mass", |x| none(PointMass::new(x, DVec3::ZERO))),
    ("position", |x| none(PointMass::new(1.0, at(x)))),
    ("mass", |x| none(Particle::new(x, DVec3::ZERO, DVec3::ZERO))),
    ("velocity", |x| none(Particle::new(1.0, DVec3::ZERO, at(x)))),
    ("stiffness", |x| none(Spring::new([0, 1], x, 0.0, 1.0))),
    ("damping", |x| none(Spring::new([0, 1], 1.0, x, 1.0))),
    ("rest_length", |x| none(Spring::new([0, 1], 1.0, 0.0, x))),
    ("mass", |x| none(RigidBody::new(x, DMat3::IDENTITY))),
    ("inertia", |x| none(RigidBody::new(1.0, DMat3::from_diagonal(DVec3::new(1.0, x, 1.0))))),
    ("position", |x| none(RigidBody::new(1.0, DMat3::IDENTITY)?.set_pose(at(x), DQuat::IDENTITY))),
    ("velocity", |x| none(RigidBody::new(1.0, DMat3::IDENTITY)?.set_velocities(at(x), DVec3::Y))),
    ("angular_velocity", |x| none(RigidBody::new(1.0, DMat3::IDENTITY)?.set_velocities(DVec3::Y, at(x)))),
    ("tolerance", |x| options(Options { tolerance: x, ..Options::default() })),
    ("relative_tolerance", |x| options(Options { relative_tolerance: x, ..Options::default() })),
    ("absolute_tolerance", |x| options(Options { absolute_tolerance: x, ..Options::default() })),
    ("safety", |x| options(Options { safety: x, ..Options::default() })),
    ("dt_min", |x| options(Options { dt_min: x, ..Options::default() })),
    ("newton_tolerance", |x| options(Options { newton_tolerance: x, ..Options::default() })),
    ("position", |x| none(Projectile::new(at(x), DVec3::X, G))),
    ("velocity", |x| Projectile::new(DVec3::ZERO, at(x), G).map(|_| Vec::new())),
    ("gravity", |x| none(Projectile::new(DVec3::ZERO, DVec3::X, DVec3::Y * x))),
    ("height", |x| none(Projectile::new(DVec3::ZERO, DVec3::new(3.0, 9.0, 0.0), G)?.falls_to(x))),
    ("speed", |x| none(angles_for_range(x, 10.0, 9.81))),
    ("range", |x| none(angles_for_range(30.0, x, 9.81))),
    ("speed", |x| none(angle_for_height(x, 10.0, 9.81))),
    ("height", |x| none(angle_for_height(30.0, x, 9.81))),
    ("speed", |x| none(aim(DVec3::X, x, G))),
    ("speed", |x| none(lead(&Target::fixed(DVec3::X), x, G))),
    ("speed", |x| none(aim_in_air(&Target::fixed(DVec3::X * 10.0), x, G, &football()))),
    ("mass", |x| none(Air::ball(x, 0.1, 0.4, 1.2))),
    ("radius", |x| none(Air::ball(1.0, x, 0.4, 1.2))),
    ("drag_coefficient", |x| none(Air::ball(1.0, 0.1, x, 1.2))),
    ("density", |x| none(Air::ball(1.0, 0.1, 0.4, x))),
    ("mass", |x| flown(Air { mass: x, ..football() })),
    ("linear", |x| flown(Air { linear: x, ..football() })),
    ("quadratic", |x| flown(Air { quadratic: x, ..football() })),
    ("spin", |x| flown(football().with_spin(at(x)))),
    ("wind", |x| flown(football().with_wind(at(x)))),
    ("speed", |x| none(farthest_in_air(x, G, DVec3::X, &football()))),
    ("height", |x| none(angle_for_height_in_air(30.0, x, G, DVec3::X, &football()))),
];

fn options(o: Options) -> Answer {
    none(Integrator::<f64>::with_options(Method::AdaptiveEuler, o))?;
    none(Dopri5::new(0.0, &[1.0], o))
}

fn football() -> Air {
    Air::ball(0.43, 0.11, 0.25, 1.2).expect("a football")
}

fn flown(air: Air) -> Answer {
    let kick = Projectile::new(DVec3::ZERO, DVec3::new(20.0, 20.0, 0.0), G)?;
    match fly(&kick, &air, &Plane::new(DVec3::ZERO, DVec3::Y)?) {
        Ok(f) => Ok(vec![f.end().position, f.end().velocity, f.apex().position]),
        Err(Error::Failed { .. }) => Ok(Vec::new()),
        Err(e) => Err(e),
    }
}

#[test]
fn every_number_with_every_special_value() {
    let mut wrong = Vec::new();
    let (mut taken, mut refused) = (0, 0);
    for (i, (name, call)) in ROWS.iter().enumerate() {
        let mut here = 0;
        for x in SPECIALS {
            let start = Instant::now();
            let what = format!("row {i}, {name} = {x:e}");
            match call(x) {
                Ok(numbers) => {
                    taken += 1;
                    if !x.is_finite() {
                        wrong.push(format!("{what} is taken"));
                    } else if !finite(&numbers) {
                        wrong.push(format!("{what} gives {numbers:?}"));
                    }
                }
                Err(e) => {
                    (refused, here) = (refused + 1, here + 1);
                    let named = match &e {
                        Error::BadValue { field, value, expected, .. } => {
                            field.starts_with(name) && !value.is_empty() && !expected.is_empty()
                        }
                        _ => !x.is_nan(),
                    };
                    if !named {
                        wrong.push(format!("{what}: {e}"));
                    }
                }
            }
            if start.elapsed() > CALL_MAX {
                wrong.push(format!("{what} took {:?}", start.elapsed()));
            }
        }
        assert!(here >= 3, "row {i}, {name}: only {here} values are refused");
    }
    assert!(wrong.is_empty(), "{} of them: {wrong:#?}", wrong.len());
    assert!(taken > 300 && refused > 500, "{taken} taken, {refused} refused");
}

/// Functions that answer with a number take anything; they must come back.
#[test]
fn plain_functions_come_back_from_anything() {
    for x in SPECIALS {
        for y in SPECIALS {
            let (a, b) = (at(x), DVec3::new(y, x, 0.0));
            let vectors = [
                force::uniform_gravity(x, a),
                force::gravitation(x, y, 1.0, a, y),
                force::buoyancy(x, y, a),
                force::stokes_drag(x, b),
                force::quadratic_drag(x, b),
                force::implicit_drag(a, b, x, y, 0.01),
                force::magnus(x, a, b),
                force::ball_magnus(x, y, a, b),
                force::kinetic_friction(x, y, a),
                force::spring(x, y, 1.0, a, b),
                force::point_velocity(a, b),
                force::point_acceleration(a, b, a),
                force::centripetal(x, a, b),
                force::centrifugal(x, a, b),
                force::coriolis(x, a, b),
                force::euler_force(x, a, b),
                respond(a, DVec3::Y, x, y),
                split(a, b).0,
                constant_velocity(a, b, x),
                constant_acceleration(a, b, a, x).0,
                velocity_of(|t| DVec3::X * (t * x), y, x),
                acceleration_of(|t| DVec3::X * (t * x), y, x),
                push(a, x, b, y).0,
            ];
            let numbers = [
                force::stokes_coefficient(x, y),
                force::quadratic_coefficient(x, y, x),
                force::terminal_speed(x, y, x),
                force::sphere_lift_factor(x, y),
                force::ball_lift_coefficient(x),
                force::friction_angle(x),
            ];
            let _ = (vectors, numbers, force::static_friction(x, y, a), turn(a));
            let _ = world_inertia(turn(b), &DMat3::from_diagonal(a));
            let plane = Plane::new(DVec3::ZERO, DVec3::Y).expect("a plane");
            let _ = (edge_plane(a, b, &plane), plane.side(a), plane.distance(a), plane.push_out(b));
            let face = [DVec3::ZERO, DVec3::X, a];
            let _ = (edge_face(a, b, &face), faces_cut(&face, &[a, b, DVec3::Z]));
            if let Ok(other) = Plane::new(a, b) {
                let _ = plane_plane(&plane, &other);
            }
            let _ = (aim(b, 30.0, G), slowest(b, G), lead(&Target::moving(a, b), 30.0, G));
        }
    }
    // Quadratures end, whatever they are asked for.
    for x in SPECIALS {
        let start = Instant::now();
        let _ = displacement(|t| DVec3::X * t.sin(), 0.0, x, 1e-9);
        let _ = displacement(|_| DVec3::X * x, 0.0, 1.0, 1e-9);
        let _ = displacement(|t| DVec3::X * t.sin(), 0.0, 1.0, x);
        let _ = velocity_change(|t| DVec3::X * (t * x), 0.0, 1.0, 1e-9);
        let _ = varying_acceleration(DVec3::ZERO, DVec3::X, |t| DVec3::X * t, x, 1e-9);
        assert!(start.elapsed() < CALL_MAX, "{x}: {:?}", start.elapsed());
    }
}

/// Counts beyond all memory are refused before anything is made; empty systems do nothing.
#[test]
fn counts_are_bounded_and_nothing_is_harmless() {
    let start = Instant::now();
    for n in [0, 1, usize::MAX, 1 << 40, limits::POINTS_MAX] {
        assert!(
            Cloth::new(&ClothDesc { columns: n, rows: 2.max(n), ..ClothDesc::default() }).is_err(),
            "{n}"
        );
        assert!(Jelly::new(&JellyDesc { particles: [n, 2, n], ..JellyDesc::default() }).is_err(), "{n}");
    }
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
    for method in Method::ALL {
        let mut s = MassSpring::new(method);
        s.step(0.1).expect("nothing to move");
        let e = Elasticity { stiffness: 1.0, damping: 0.0 };
        assert!(matches!(s.add_spring([0, 1], e), Err(Error::NoSuch { .. })));
        assert!(s.energy().total() == 0.0 && s.momentum() == DVec3::ZERO);
        let _ = s.center_of_mass();
    }
    let mut p = ParticleSystem::default();
    p.euler_step(0.1).expect("nothing to move");
    assert!(matches!(
        Spring::new([0, 1], 1.0, 0.0, 1.0).expect("spring").force(&[]),
        Err(Error::NoSuch { .. })
    ));
    let mut n = NBody::new(NBodyDesc::default()).expect("valid");
    n.step(0.1).expect("nothing to move");
}
