//! Debug drawing: complete outlines, in the right place.

mod support;

use jounce::prelude::*;
use jounce::{DebugColor, DebugDraw, DebugDrawOptions};
use support::*;

#[derive(Default)]
struct Paper {
    lines: Vec<(DVec3, DVec3)>,
    points: Vec<DVec3>,
    texts: Vec<String>,
}

impl DebugDraw for Paper {
    fn line(&mut self, a: DVec3, b: DVec3, _: DebugColor) {
        self.lines.push((a, b));
    }
    fn point(&mut self, at: DVec3, _: DebugColor) {
        self.points.push(at);
    }
    fn text(&mut self, _: DVec3, text: &str, _: DebugColor) {
        self.texts.push(text.into());
    }
}

fn drawn(w: &World, options: &DebugDrawOptions<'_>) -> Paper {
    let mut paper = Paper::default();
    w.debug_draw(&mut paper, options);
    paper
}

#[test]
fn outlines_lie_on_the_surfaces() {
    // Every end of every line of every shape is a surface point of that shape.
    for seed in 0..40 {
        let mut r = Random::new(seed);
        let mut w = world();
        let at = r.vec(5.0).as_dvec3();
        let shape = any_shape(&mut r);
        let compound = shape.name() == "compound";
        let body = BodyDesc::fixed().at(at).rotated(r.turn()).shape(ShapeDesc::new(shape));
        w.add_body(body).expect("a body");
        let paper = drawn(&w, &DebugDrawOptions::default());
        assert!(paper.lines.len() >= 6);
        let everything = QueryFilter::default();
        for p in paper.lines.iter().flat_map(|l| [l.0, l.1]) {
            let d = w.closest_point(p, 9.0, &everything).expect("near").distance;
            // Children of a compound reach into each other.
            assert!(d < 1e-4 && (compound || d > -1e-4), "{d}");
        }
    }
}

#[test]
fn a_box_has_twelve_edges_and_what_is_switched_off_stays_away() {
    let mut w = world();
    ground(&mut w);
    let b = add_box(&mut w, [0.0, 0.5, 0.0], 0.5);
    w.set_name(b, Some("it".into())).expect("alive");
    step(&mut w, 5);
    let only = |s: ShapeId| s.index() == 1;
    let none = DebugDrawOptions {
        shapes: false,
        contacts: false,
        filter: QueryFilter::default().only(&only),
        ..DebugDrawOptions::default()
    };
    let count = |o: DebugDrawOptions<'_>| {
        let p = drawn(&w, &o);
        (p.lines.len(), p.points.len(), p.texts.len())
    };
    assert_eq!(count(none), (0, 0, 0));
    assert_eq!(count(DebugDrawOptions { shapes: true, ..none }), (12, 0, 0));
    assert_eq!(count(DebugDrawOptions { bounds: true, ..none }), (12, 0, 0));
    assert_eq!(count(DebugDrawOptions { contacts: true, ..none }), (4, 4, 0));
    assert_eq!(count(DebugDrawOptions { centers: true, names: true, ..none }), (3, 1, 1));
    let away = [DVec3::splat(50.0), DVec3::splat(60.0)];
    assert_eq!(
        count(DebugDrawOptions { shapes: true, contacts: true, region: Some(away), ..none }),
        (0, 0, 0)
    );
}

#[test]
fn joints_are_drawn_from_point_to_point_until_they_break() {
    let mut w = world();
    let post = w.add_body(BodyDesc::fixed()).expect("a post");
    let ball = BodyDesc::dynamic().at([0.0, -1.0, 0.0]).shape(ShapeDesc::sphere(0.1));
    let ball = w.add_body(ball).expect("a ball");
    let hinge = w.add_joint(JointDesc::hinge(post, ball, [0.0; 3], Vec3::Z)).expect("a hinge");
    let rod = w.add_joint(JointDesc::rod(post, ball, [0.0; 3], [0.0, -1.0, 0.0])).expect("a rod");
    let only = DebugDrawOptions { shapes: false, contacts: false, ..DebugDrawOptions::default() };
    let paper = drawn(&w, &only);
    let axis = (DVec3::new(0.0, 0.0, -0.25), DVec3::new(0.0, 0.0, 0.25));
    assert_eq!((paper.lines.len(), paper.points.len()), (2, 4));
    assert!((paper.lines[0].0 - axis.0).length() < 1e-6 && (paper.lines[0].1 - axis.1).length() < 1e-6);
    assert_eq!(paper.lines[1], (DVec3::ZERO, DVec3::new(0.0, -1.0, 0.0)));
    w.set_joint_enabled(rod, false).expect("out");
    assert_eq!(drawn(&w, &only).lines.len(), 1);
    w.remove_joint(hinge).expect("gone");
    assert!(drawn(&w, &only).lines.is_empty());
    w.set_joint_enabled(rod, true).expect("in");
    let off = DebugDrawOptions { joints: false, ..only };
    assert!(drawn(&w, &off).lines.is_empty());
}

#[test]
fn a_vehicle_shows_its_wheels_and_what_they_stand_on() {
    let mut w = world();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).expect("ground");
    let v = jounce::vehicles::car().add(&mut w, [0.0; 3], Quat::IDENTITY).expect("a car");
    (0..60).for_each(|_| w.step().expect("a step"));
    let alone = |vehicles, forces| DebugDrawOptions {
        shapes: false,
        contacts: false,
        joints: false,
        vehicles,
        forces,
        ..Default::default()
    };
    assert!(drawn(&w, &alone(false, false)).lines.is_empty());
    let paper = drawn(&w, &alone(true, false));
    // Two rims of 24 sides, a spoke, a travel and a normal for each of four wheels.
    assert_eq!(paper.lines.len(), 4 * (2 * 24 + 3), "{} lines", paper.lines.len());
    assert_eq!(paper.points.len(), 4);
    assert!(paper.points.iter().all(|p| p.y.abs() < 1e-3), "on the ground: {:?}", paper.points);
    let lowest = paper.lines.iter().map(|l| if l.0.y < l.1.y { l.0.y } else { l.1.y });
    let lowest = lowest.fold(1.0, |a, b| if b < a { b } else { a });
    assert!(lowest.abs() < 0.05, "rims end at the ground: {lowest}");
    // Forces: at rest up, with the weight in all.
    let pushed = drawn(&w, &alone(true, true)).lines;
    let up: f64 = pushed.iter().map(|l| l.1.y - l.0.y).sum::<f64>()
        - paper.lines.iter().map(|l| l.1.y - l.0.y).sum::<f64>();
    assert!((up / (0.01 * 1300.0 * 9.81) - 1.0).abs() < 0.05, "{up} m of force");
    w.set_vehicle_enabled(v, false).expect("off");
    assert!(drawn(&w, &alone(true, true)).lines.is_empty());
}
