//! What can only be seen from inside: the flow of turbulence, sweeps of balls, schedules, curves, memory.

use super::ball::{Around, Ball, Touch, sweep};
use super::desc::{Curve, Gradient, Turbulence};
use super::noise::{Noise, at_point};
use super::solve::half_to_the;
use super::state::{Block, LANES, Newborn};
use jounce_geometry::{Compound, Hull, Shape, TriMesh, TriMeshOptions};
use jounce_lanes::{Kernel, Lanes, Width, dispatch};
use jounce_math::{DVec3, Pose, Quat, Vec3, scalar::f64s};
use std::sync::Arc;

fn turbulence(size: f32) -> Turbulence {
    Turbulence { speed: 3.0, size, time_s: 0.5, seed: 9 }
}

/// Places all over a few cells.
fn places(n: u64, extent: f32) -> impl Iterator<Item = Vec3> {
    let unit = |i, k| (super::birth::random(3, i, k) >> 40) as f32 / 16_777_216.0 - 0.5;
    (0..n).map(move |i| Vec3::new(unit(i, 1), unit(i, 2), unit(i, 3)) * extent)
}

#[test]
fn a_particle_takes_52_bytes() {
    // The rest is count, emitter and births, once for 64.
    let block = size_of::<Block>();
    assert!((52 * LANES..=52 * LANES + 48).contains(&block), "{block}");
}

/// Central differences of a flow that is smooth within cells are off by δ²; f32 leaves 2⁻²⁴ |u|/δ.
#[test]
fn turbulence_has_no_divergence() {
    let noise = Noise::new(&turbulence(1.0), DVec3::ZERO, 0.3);
    let d = 0.01;
    let (mut worst, mut steepest) = (0.0f32, 0.0f32);
    for p in places(2000, 20.0) {
        let u = |axis: Vec3| {
            let (a, b) =
                (at_point(&noise, p + axis * d, Width::X4), at_point(&noise, p - axis * d, Width::X4));
            (a - b) * (0.5 / d)
        };
        let (x, y, z) = (u(Vec3::X), u(Vec3::Y), u(Vec3::Z));
        worst = worst.max_of((x.x + y.y + z.z).abs());
        steepest = steepest.max_of(x.x.abs());
    }
    // δ² = 1e-4 of the third derivatives, which are some 50 times the first.
    assert!(worst < 0.01 * steepest, "{worst} of {steepest}");
}

trait Most {
    fn max_of(self, o: f32) -> f32;
}
impl Most for f32 {
    fn max_of(self, o: f32) -> f32 {
        if self > o { self } else { o }
    }
}

#[test]
fn turbulence_is_as_fast_as_asked_and_goes_nowhere() {
    for time in [0.0, 0.1, 0.25, 0.4] {
        let noise = Noise::new(&turbulence(0.5), DVec3::ZERO, time);
        let (mut square, mut mean) = (0.0f64, DVec3::ZERO);
        let n = 40_000;
        for p in places(n, 200.0) {
            let u = at_point(&noise, p, Width::X8).as_dvec3();
            square += u.length_squared();
            mean += u;
        }
        // 40,000 places in cells of their own: 1/√n of the spread, some parts in a hundred of the square.
        let rms = (square / n as f64).sqrt();
        assert!((rms - 3.0).abs() < 0.05, "{rms} at {time}");
        assert!(mean.length() / (n as f64) < 0.05, "{mean:?}");
    }
}

#[test]
fn turbulence_has_the_same_bits_in_every_width() {
    let noise = Noise::new(&turbulence(0.7), DVec3::new(1e6, -3e5, 12.5), 7.77);
    for p in places(3000, 3000.0) {
        let u = Width::ALL.map(|w| at_point(&noise, p, w));
        assert!(u.iter().all(|v| *v == u[0]), "{p:?}: {u:?}");
        assert!(u[0].is_finite());
    }
}

/// The flow belongs to the world: an emitter's own origin does not show. f32 from 1000 cells leaves 1e-4 of a cell.
#[test]
fn turbulence_is_the_same_from_every_origin() {
    let far = DVec3::new(1e6, -2e6, 3e6);
    let shift = DVec3::new(100.0, -30.0, 50.0);
    let a = Noise::new(&turbulence(1.5), far, 1.0);
    let b = Noise::new(&turbulence(1.5), far + shift, 1.0);
    for p in places(500, 50.0) {
        let (u, v) = (at_point(&a, p + shift.as_vec3(), Width::X1), at_point(&b, p, Width::X1));
        assert!((u - v).length() < 1e-2, "{u:?} {v:?}");
    }
}

#[test]
fn turbulence_is_smooth_in_time_and_forgets() {
    let at = |time| {
        let noise = Noise::new(&turbulence(1.0), DVec3::ZERO, time);
        places(300, 30.0).map(|p| at_point(&noise, p, Width::X4)).collect::<Vec<_>>()
    };
    let off = |a: &[Vec3], b: &[Vec3]| {
        let sum: f32 = a.iter().zip(b).map(|(x, y)| (*x - *y).length_squared()).sum();
        (sum / a.len() as f32).sqrt()
    };
    for time in [0.2, 0.499, 0.5, 0.9999] {
        assert!(off(&at(time), &at(time + 0.002)) < 0.1, "{time}");
    }
    // Two independent flows differ by √2 of the speed.
    assert!(off(&at(0.0), &at(1.0)) > 3.5);
}

#[test]
fn halving_is_exponential() {
    struct Run(f32);
    impl Kernel for Run {
        type Output = f32;
        #[inline(always)]
        fn run<L: Lanes>(self) -> f32 {
            let mut out = [0.0; 16];
            half_to_the(L::splat(self.0)).store(&mut out);
            out[0]
        }
    }
    for i in 0..4000u32 {
        let x = i as f32 * 0.01;
        let exact = f64s::exp(-f64::from(x) * core::f64::consts::LN_2);
        let got = Width::ALL.map(|w| dispatch(w, Run(x)));
        assert!(got.iter().all(|g| *g == got[0]));
        assert!((f64::from(got[0]) / exact - 1.0).abs() < 1e-6, "{x}: {} {exact}", got[0]);
    }
}

fn touch(shape: &Shape, from: Vec3, motion: Vec3, radius: f32) -> Option<Touch> {
    sweep((shape, 0), from, motion, Ball::new(radius, from.abs().max_component()), 1.0, &mut Around::new())
}

fn shapes() -> Vec<Shape> {
    let corners = [
        Vec3::new(-1.0, -0.5, -1.0),
        Vec3::new(1.0, -0.4, -1.0),
        Vec3::new(0.0, 0.9, 1.0),
        Vec3::new(0.2, 0.1, -2.0),
    ];
    let mesh = TriMesh::new(&corners, &[[0, 1, 2], [0, 3, 1]], TriMeshOptions::default()).expect("a mesh");
    let children = vec![
        (Pose::new(Vec3::new(0.5, 0.0, 0.0), Quat::IDENTITY), Shape::Box { half: Vec3::new(0.4, 0.3, 0.2) }),
        (
            Pose::new(Vec3::new(-0.6, 0.1, 0.0), Quat::from_axis_angle(Vec3::Z, 0.4)),
            Shape::Sphere { radius: 0.4 },
        ),
    ];
    let points = corners.map(|c| c + Vec3::new(0.0, 0.0, 0.3));
    vec![
        Shape::Sphere { radius: 0.7 },
        Shape::Box { half: Vec3::new(0.6, 0.4, 0.8) },
        Shape::Capsule { half_height: 0.5, radius: 0.3 },
        Shape::Cylinder { half_height: 0.5, radius: 0.6 },
        Shape::Cone { half_height: 0.5, radius: 0.6 },
        Shape::HalfSpace { normal: Vec3::new(0.6, 0.8, 0.0), offset: 0.2 },
        Shape::Hull(Arc::new(Hull::new(&points).expect("a hull"))),
        Shape::Mesh(Arc::new(mesh)),
        Shape::Compound(Arc::new(Compound::new(children).expect("convex"))),
    ]
}

/// At the touch the gap is the radius, and before it, larger.
#[test]
fn a_swept_ball_stops_at_its_radius() {
    for shape in shapes() {
        let (mut hits, mut misses) = (0, 0);
        for (from, to) in places(4000, 6.0).zip(places(4000, 6.0).skip(17)) {
            let (motion, radius) = (to - from, 0.05);
            let gap = |t: f32| shape.closest_point(from + motion * t).map_or(9.0, |h| h.distance - radius);
            let Some(hit) = touch(&shape, from, motion, radius) else {
                let nearest =
                    (0..=50).map(|i| gap(i as f32 / 50.0)).fold(9.0, |m: f32, g| if g < m { g } else { m });
                assert!(nearest > -2e-4 || gap(0.0) < 0.0, "{} {from:?} {motion:?} {nearest}", shape.name());
                misses += 1;
                continue;
            };
            hits += 1;
            assert!((hit.normal.length() - 1.0).abs() < 1e-4);
            if hit.t > 0.0 {
                // The skin is a thousandth of the radius.
                assert!(gap(hit.t).abs() < 2e-4, "{} {} at {}", shape.name(), gap(hit.t), hit.t);
                for i in 0..20 {
                    assert!(gap(hit.t * i as f32 / 20.0) > -2e-4, "{}", shape.name());
                }
            }
        }
        assert!(hits > 30 && misses > 30, "{}: {hits} {misses}", shape.name());
    }
}

#[test]
fn a_ball_that_lies_on_something_touches_only_when_pressed() {
    let floor = Shape::Box { half: Vec3::new(1.0, 0.5, 1.0) };
    let at = Vec3::new(0.0, 0.6, 0.0);
    assert_eq!(touch(&floor, at, Vec3::new(0.3, 0.0, 0.0), 0.1), None);
    assert_eq!(touch(&floor, at, Vec3::new(0.0, 0.2, 0.0), 0.1), None);
    let pressed = touch(&floor, at, Vec3::new(0.3, -0.01, 0.0), 0.1).expect("pressed");
    assert!(pressed.t == 0.0 && pressed.normal == Vec3::Y && pressed.depth < 1e-6);
    let deep = touch(&floor, at - Vec3::Y * 0.03, Vec3::ZERO, 0.1).expect("too deep");
    assert!(deep.t == 0.0 && (deep.depth - 0.03).abs() < 1e-6);
}

#[test]
fn curves_go_through_their_keys() {
    let c = Curve::new([(0.2, 1.0), (0.5, 3.0), (0.5, 4.0), (1.0, 2.0)]);
    for (t, v) in [(0.0, 1.0), (0.2, 1.0), (0.35, 2.0), (0.5, 4.0), (0.75, 3.0), (1.0, 2.0), (2.0, 2.0)] {
        assert!((c.at(t) - v).abs() < 1e-6, "{t}: {}", c.at(t));
    }
    assert_eq!((Curve::default().at(0.3), Gradient::default().at(0.3)), (1.0, [1.0; 4]));
    let g = Gradient::new([(0.0, [0.0, 1.0, 2.0, 1.0]), (1.0, [1.0, 1.0, 0.0, 0.0])]);
    assert_eq!(g.at(0.5), [0.5, 1.0, 1.0, 0.5]);
}

#[test]
fn gaps_close_in_order() {
    let mut b = Block::default();
    let newborn = |serial| Newborn {
        p: Vec3::new(serial as f32, 0.0, 0.0),
        v: Vec3::ZERO,
        age: 0.0,
        life: 1.0,
        mass: 1.0,
        radius: 1.0,
        serial,
    };
    (0..LANES as u32).for_each(|i| b.push(&newborn(i)));
    let alive = 0x8000_0f0f_0000_0001;
    b.keep(alive);
    let left: Vec<u32> = (0..64).filter(|i| alive >> i & 1 == 1).collect();
    assert_eq!(b.serial[..b.count], left);
    assert!((0..b.count).all(|l| b.place(l).x == left[l] as f32));
    let mut later = Block::default();
    (100..105).for_each(|i| later.push(&newborn(i)));
    b.append(&mut later);
    assert_eq!((b.count, later.count, b.serial[b.count - 1]), (left.len() + 5, 0, 104));
}

/// Every preset is in range, bears particles and stays finite.
#[test]
fn presets_work_at_any_scale() {
    use super::presets::*;
    use crate::prelude::*;
    type Preset = fn(DVec3, f32, u64) -> Vec<EmitterDesc>;
    let all: [Preset; 9] = [explosion, smoke, fire, spray, fountain, sparks, dust, snow, genesis];
    for preset in all {
        for scale in [0.1, 1.0, 30.0] {
            let mut world = World::new(WorldDesc::default()).expect("valid");
            world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).expect("valid");
            let ids: Vec<_> = preset(DVec3::Y, scale, 4)
                .into_iter()
                .map(|d| world.add_emitter(d).expect("in range"))
                .collect();
            let mut most = 0;
            for _ in 0..40 {
                world.step().expect("steps");
                most = most.max(world.counts().particles);
                assert!(world.particles().all(|p| p.position.is_finite() && p.velocity.is_finite()));
            }
            // A flurry over 10 cm has a flake in ten seconds.
            assert!(most >= 5 || scale < 1.0, "{most} of {} emitters", ids.len());
        }
    }
}
