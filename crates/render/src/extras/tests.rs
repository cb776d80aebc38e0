//! Pixels of simple pictures with extras.

use crate::tracer::{Hit, Tracer};
use crate::{
    Ball, Camera, Extras, Face, Image, Look, Overlay, Pattern, RenderOptions, Rod, Skin, render, render_with,
};
use jounce::math::{DVec3, Vec3};

/// A white wall across the view at this z, seen from in front; or nothing.
struct Wall(Option<f64>);

impl Tracer for Wall {
    fn trace(&self, origin: DVec3, dir: Vec3, max_t: f32) -> Option<Hit> {
        let t = (self.0? - origin.z) as f32 / dir.z;
        (t > 0.0 && t <= max_t).then_some(Hit { t, normal: Vec3::Z, surface: 0 })
    }
    fn skin(&self, _: u32) -> Skin {
        Skin { color: Vec3::splat(0.8), pattern: Pattern::Plain, gloss: 0.0 }
    }
    fn to_local(&self, _: u32, point: DVec3) -> Vec3 {
        point.as_vec3()
    }
}

const EMPTY: Wall = Wall(None);
const RED: [f32; 3] = [0.8, 0.1, 0.1];
const WHITE: [f32; 3] = [1.0; 3];

fn options() -> RenderOptions {
    let look = Look { background: Some(Vec3::splat(0.15)), ..Look::default() };
    RenderOptions { width: 64, height: 36, threads: 1, look, ..RenderOptions::default() }
}

/// From 10 m in front of the origin; a pixel is 0.2 m wide there.
fn camera() -> Camera {
    Camera::new([0.0, 0.0, 10.0], [0.0; 3])
}

fn take(scene: &Wall, extras: &Extras) -> Image {
    render_with(scene, &camera(), extras, &Overlay::default(), &options()).expect("picture")
}

fn middle(image: &Image) -> [i32; 3] {
    image.get(32, 18).map(i32::from)
}

fn one(ball: Ball) -> Extras {
    Extras { balls: vec![ball], ..Extras::default() }
}

/// Some of everything, with equal ones and crossing ones among them.
fn crowd(shift: DVec3) -> Extras {
    let mut e = Extras::default();
    for i in 0..60_u32 {
        let f = |k: u32| f64::from((i * k) % 17) / 4.0 - 2.0;
        let at = DVec3::new(f(5) * 1.5, f(7) * 0.75, f(11)) + shift;
        let color = [0.9, 0.2 + (i % 7) as f32 * 0.1, 0.3];
        e.balls.push(match i % 4 {
            0 => Ball::new(at, 0.3, color),
            1 => Ball::new(at, 0.8, color).soft().opacity(0.4),
            2 => Ball::new(at, 0.4, color).opacity(0.5),
            _ => Ball::new(at, 0.5, color).soft().opacity(0.5).glow(0.8),
        });
        let to = at + DVec3::new(f(3), f(13), 0.5);
        e.rods.push(Rod::new(at, to, 0.02 + (i % 3) as f32 * 0.1, color).opacity(0.4 + (i % 4) as f32 * 0.2));
        e.faces.push(Face::new(at, to, at + DVec3::new(0.5, -0.5, 0.25), color));
    }
    let again = e.balls[1];
    e.balls.push(again);
    e
}

#[test]
fn no_extras_leave_every_bit() {
    let plain = render(&Wall(Some(-1.0)), &camera(), &Overlay::default(), &options()).expect("picture");
    assert!(plain == take(&Wall(Some(-1.0)), &Extras::default()));
    // Behind the wall is as good as absent.
    assert!(plain == take(&Wall(Some(-1.0)), &one(Ball::new([0.0, 0.0, -4.0], 1.0, RED).glow(1.0))));
}

#[test]
fn what_glows_adds_its_colour() {
    let dark = middle(&take(&EMPTY, &Extras::default()));
    let lamp = middle(&take(&EMPTY, &one(Ball::new([0.0; 3], 1.5, RED).glow(1.0).opacity(0.3))));
    assert!(lamp[0] > dark[0] + 40 && (lamp[1] - dark[1]).abs() < 15, "{dark:?} {lamp:?}");
    // Two add more than one.
    let mut two = one(Ball::new([0.0; 3], 1.5, RED).glow(1.0).opacity(0.3));
    two.balls.push(Ball::new([0.0, 0.0, -3.0], 1.5, RED).glow(1.0).opacity(0.3));
    assert!(middle(&take(&EMPTY, &two))[0] > lamp[0] + 20);
}

#[test]
fn half_a_ball_mixes_with_what_is_behind() {
    let wall = Wall(Some(-2.0));
    // Linear light mixes: blend of bare wall and opaque ball, between the two and near the middle of their squares.
    let bare = middle(&take(&wall, &Extras::default()));
    let ball = |opacity: f32| middle(&take(&wall, &one(Ball::new([0.0; 3], 1.5, RED).opacity(opacity))));
    let (half, full) = (ball(0.5), ball(0.999));
    for k in 1..3 {
        let (lo, hi) = (full[k].min(bare[k]), full[k].max(bare[k]));
        assert!(half[k] > lo + 20 && half[k] < hi - 10, "{bare:?} {half:?} {full:?}");
    }
    // In the ball's shade the wall is darker, by half of the sun.
    let shade = |opacity: f32| {
        let sun = Look::default().sun;
        let at = DVec3::new(3.0, 1.5, -2.0) + (sun * 2.5).as_dvec3();
        let view = camera().view(64, 36);
        let (x, y, _) = view.project(DVec3::new(3.0, 1.5, -2.0)).expect("in front");
        let image = take(&wall, &one(Ball::new(at, 1.0, RED).opacity(opacity)));
        i32::from(image.get(x as u32, y as u32)[0])
    };
    let (none, half, full) = (shade(1e-6), shade(0.5), shade(1.0));
    assert!(none > half + 10 && half > full + 10, "{none} {half} {full}");
}

#[test]
fn solids_hide() {
    let wall = Wall(Some(-2.0));
    let ball = one(Ball::new([0.0; 3], 1.5, RED));
    let alone = middle(&take(&wall, &ball));
    assert!(alone[0] > 2 * alone[1], "{alone:?}");
    let mut more = ball.clone();
    more.balls.push(Ball::new([0.0, 0.0, -1.0], 0.4, WHITE).soft());
    more.rods.push(Rod::new([-1.0, 0.0, -0.2], [1.0, 0.0, -0.2], 0.1, WHITE).opacity(0.5));
    assert_eq!(middle(&take(&wall, &more)), alone, "what is inside or behind does not show");
    more.faces.push(Face::new([-4.0, -4.0, 3.0], [4.0, -4.0, 3.0], [0.0, 6.0, 3.0], [0.1, 0.1, 0.9]));
    let hidden = middle(&take(&wall, &more));
    assert!(hidden[2] > 2 * hidden[0], "{hidden:?}");
    // Turned round it looks the same: two sides.
    let f = more.faces[0];
    more.faces[0] = Face { b: f.c, c: f.b, ..f };
    assert_eq!(middle(&take(&wall, &more)), hidden);
}

#[test]
fn smoke_meets_a_wall_softly() {
    let bare = middle(&take(&Wall(Some(0.0)), &Extras::default()));
    let puff = |z: f64| {
        let off = Ball::new([0.0, 0.0, z], 1.0, [0.05; 3]).soft().opacity(0.9);
        middle(&take(&Wall(Some(0.0)), &one(off)))[0]
    };
    let row: Vec<i32> = (-10..=10).map(|k| puff(f64::from(k) * 0.1)).collect();
    assert!(row[0] == bare[0] && row[20] < bare[0] - 60, "{row:?}");
    for w in row.windows(2) {
        assert!((w[0] - w[1]).abs() < 30 && w[1] <= w[0] + 1, "no step from one place to the next: {row:?}");
    }
}

#[test]
fn small_things_still_show() {
    let bare = middle(&take(&EMPTY, &Extras::default()));
    let near = |image: &Image| {
        let cells = (31..34).flat_map(|x| (17..20).map(move |y| (x, y)));
        cells.map(|(x, y)| i32::from(image.get(x, y)[0])).max().unwrap_or(0)
    };
    for radius in [0.05, 0.005, 1e-6] {
        let hard = take(&EMPTY, &one(Ball::new([0.0; 3], radius, WHITE)));
        let spark = take(&EMPTY, &one(Ball::new([0.0; 3], radius, WHITE).soft().glow(1.0)));
        let rods = vec![Rod::new([-3.0, 0.05, 0.0], [3.0, 0.05, 0.0], radius, WHITE)];
        let rod = take(&EMPTY, &Extras { rods, ..Extras::default() });
        for (name, image) in [("ball", hard), ("spark", spark), ("rod", rod)] {
            assert!(near(&image) > bare[0] + 8, "{name} of {radius} m: {} {}", near(&image), bare[0]);
        }
    }
}

#[test]
fn pieces_of_a_translucent_line_do_not_show_twice() {
    let pieces = |n: u32| {
        let x = |k: u32| DVec3::new(f64::from(k) / f64::from(n) * 8.0 - 4.0, 0.05, 0.0);
        let rods = (0..n).map(|k| Rod::new(x(k), x(k + 1), 0.5, RED).opacity(0.5)).collect();
        take(&EMPTY, &Extras { rods, ..Extras::default() })
    };
    let (one, many) = (pieces(1), pieces(29));
    for x in 18..46 {
        let (a, b) = (one.get(x, 18), many.get(x, 18));
        assert!((0..3).all(|k| a[k].abs_diff(b[k]) <= 2), "{x}: {a:?} {b:?}");
    }
}

#[test]
fn order_and_threads_change_no_bit() {
    let e = crowd(DVec3::ZERO);
    let wall = Wall(Some(-3.0));
    let picture = take(&wall, &e);
    assert!(picture != take(&wall, &Extras::default()));
    let mut turned = e.clone();
    turned.balls.reverse();
    turned.rods.rotate_left(23);
    turned.faces.rotate_right(7);
    turned.faces.swap(3, 19);
    assert!(picture == take(&wall, &turned), "the order of the lists");
    for threads in [2, 4] {
        let options = RenderOptions { threads, ..options() };
        let many = render_with(&wall, &camera(), &e, &Overlay::default(), &options).expect("picture");
        assert!(picture == many, "{threads} threads");
    }
}

#[test]
fn far_pictures_equal_near_ones() {
    let shift = DVec3::new(1_048_576.0, -2_097_152.0, 4_194_304.0);
    let near = take(&Wall(Some(-3.0)), &crowd(DVec3::ZERO));
    let eye = camera();
    let eye = Camera { position: eye.position + shift, target: eye.target + shift, ..eye };
    let far = Wall(Some(-3.0 + shift.z));
    let far = render_with(&far, &eye, &crowd(shift), &Overlay::default(), &options()).expect("picture");
    assert!(near == far, "4,000 km away every bit is the same where the shifted places are exact");
}

#[test]
fn bad_numbers_are_left_out() {
    let wall = Wall(Some(-3.0));
    let good = crowd(DVec3::ZERO);
    let mut bad = good.clone();
    let ball = Ball::new([0.0; 3], 1.0, RED);
    let rod = Rod::new([0.0; 3], [1.0, 0.0, 0.0], 0.1, RED);
    let face = Face::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], RED);
    for x in [f32::NAN, -1.0, 0.0, f32::INFINITY, f32::NEG_INFINITY, 2e9] {
        for b in [ball, ball.soft(), ball.glow(0.5)] {
            bad.balls.push(Ball { radius: x, ..b });
            let at = DVec3::new(f64::from(x) * 1e30, f64::INFINITY, 0.0);
            bad.balls.push(Ball { center: at, ..b });
        }
        bad.rods.push(Rod { radius: x, ..rod });
        bad.rods.push(Rod { radius: x, ..rod }.opacity(0.5));
    }
    bad.balls.push(ball.opacity(f32::NAN));
    bad.balls.push(ball.opacity(-0.5));
    bad.balls.push(ball.glow(f32::NAN));
    bad.balls.push(Ball { color: [f32::NAN, 0.0, 0.0], ..ball });
    bad.balls.push(Ball { center: DVec3::splat(f64::NAN), ..ball });
    bad.rods.push(Rod { b: DVec3::splat(1e300), ..rod });
    bad.rods.push(Rod { b: rod.a, ..rod }.opacity(0.5));
    bad.faces.push(Face { a: DVec3::splat(f64::NAN), ..face });
    bad.faces.push(Face { b: face.a, ..face });
    bad.faces.push(Face { color: [0.0, f32::NAN, 0.0], ..face });
    assert!(take(&wall, &good) == take(&wall, &bad));
    // Odd but possible ones draw something.
    let mut odd = good;
    odd.balls.push(Ball { color: [7.0, -3.0, f32::INFINITY], ..ball }.opacity(9.0).glow(-4.0));
    odd.balls.push(Ball { center: camera().position, ..ball }.soft());
    odd.balls.push(Ball { center: camera().position, ..ball }.opacity(0.5));
    odd.balls.push(Ball { radius: 1e-38, ..ball }.soft());
    odd.balls.push(Ball { radius: 9e8, ..ball }.soft().opacity(0.01));
    odd.rods.push(Rod { a: camera().position, ..rod }.opacity(0.5));
    odd.rods.push(Rod { a: DVec3::splat(-8e8), b: DVec3::splat(8e8), ..rod });
    odd.rods.push(Rod { b: rod.a, ..rod });
    odd.faces.push(face.normals([Vec3::splat(f32::NAN), Vec3::ZERO, Vec3::splat(1e30)]));
    odd.skin(&[DVec3::ZERO, DVec3::X, DVec3::Y], &[[0, 1, 2], [0, 0, 0], [0, 1, 99]], RED);
    take(&wall, &odd);
}
