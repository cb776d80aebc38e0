//! Whole pictures of a small world of balls over a plane, traced in closed form.

use super::*;
use jounce::math::{DVec3, Vec3};

struct Balls(Vec<(DVec3, f32)>);

impl Tracer for Balls {
    fn trace(&self, origin: DVec3, dir: Vec3, max_t: f32) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let mut keep = |t: f32, normal: Vec3, surface: u32| {
            if t > 0.0 && t <= best.map_or(max_t, |b| b.t) {
                best = Some(Hit { t, normal, surface });
            }
        };
        if dir.y < 0.0 {
            keep(-(origin.y as f32) / dir.y, Vec3::Y, 0);
        }
        for (i, (center, radius)) in self.0.iter().enumerate() {
            let o = (origin - *center).as_vec3();
            let b = o.dot(dir);
            let d = b * b - (o.length_squared() - radius * radius);
            if d >= 0.0 {
                let t = -b - d.sqrt();
                keep(t, (o + dir * t) / *radius, i as u32 + 1);
            }
        }
        best
    }
    fn skin(&self, surface: u32) -> Skin {
        match surface {
            0 => Skin { color: Vec3::splat(0.5), pattern: Pattern::Grid, gloss: 0.1 },
            i => Skin { color: palette(i), pattern: Pattern::Ball(self.0[i as usize - 1].1), gloss: 1.0 },
        }
    }
    fn to_local(&self, surface: u32, point: DVec3) -> Vec3 {
        match surface {
            0 => point.as_vec3(),
            i => (point - self.0[i as usize - 1].0).as_vec3(),
        }
    }
}

fn scene() -> Balls {
    let mut balls = vec![(DVec3::new(0.0, 1.0, 0.0), 1.0)];
    for i in 0..7 {
        balls.push((DVec3::new(f64::from(i) * 0.9 - 2.7, 0.4, 1.6), 0.4));
    }
    Balls(balls)
}

fn camera() -> Camera {
    Camera::new([2.0, 2.4, 7.0], [0.0, 0.8, 0.0])
}

fn small() -> RenderOptions {
    RenderOptions { width: 160, height: 90, ..RenderOptions::default() }
}

fn brightness(p: [u8; 3]) -> u32 {
    p.iter().map(|&c| u32::from(c)).sum()
}

#[test]
fn threads_do_not_change_a_byte() {
    let one = render(&scene(), &camera(), &Overlay::default(), &RenderOptions { threads: 1, ..small() });
    for threads in [2, 3, 8] {
        let many = render(&scene(), &camera(), &Overlay::default(), &RenderOptions { threads, ..small() });
        assert!(one.as_ref().expect("picture") == &many.expect("picture"), "{threads} threads");
    }
}

#[test]
fn the_shadow_lies_away_from_the_sun() {
    // A ball alone, seen from above; the sun's direction projected on the ground, times its height.
    let scene = Balls(vec![(DVec3::new(0.0, 2.0, 0.0), 0.7)]);
    let camera = Camera { up: -Vec3::Z, ..Camera::new([0.0, 14.0, 0.0], [0.0, 0.0, 0.0]) };
    let options = small();
    let picture = render(&scene, &camera, &Overlay::default(), &options).expect("picture");
    let view = camera.view(160, 90);
    let sun = options.look.sun;
    let at = |s: f64| {
        let p = DVec3::new(f64::from(-sun.x / sun.y) * 2.0 * s, 0.0, f64::from(-sun.z / sun.y) * 2.0 * s);
        let (x, y, _) = view.project(p).expect("in front");
        picture.get(x as u32, y as u32)
    };
    assert!(brightness(at(1.0)) * 3 < brightness(at(-1.2)) * 2, "{:?} {:?}", at(1.0), at(-1.2));
}

#[test]
fn edges_are_smoothed() {
    let sharp = RenderOptions { edge_samples: 0, ..small() };
    let fine = RenderOptions { edge_samples: 8, ..small() };
    let best = RenderOptions { edge_samples: 64, ..small() };
    let take = |o: &RenderOptions| render(&scene(), &camera(), &Overlay::default(), o).expect("picture");
    let (sharp, fine, best) = (take(&sharp), take(&fine), take(&best));
    let error = |a: &Image| -> u32 {
        let pairs = a.pixels().iter().zip(best.pixels());
        pairs.map(|(p, q)| (0..3).map(|k| u32::from(p[k].abs_diff(q[k])).pow(2)).sum::<u32>()).sum()
    };
    assert!(error(&fine) * 8 < error(&sharp), "{} {}", error(&fine), error(&sharp));
}

#[test]
fn overlays_hide_behind_bodies() {
    let mut overlay = Overlay::default();
    // On the line from the eye through the big ball's centre, behind it.
    overlay.line([-0.8, 0.6, -2.0], [-0.4, 0.6, -2.0], [255, 0, 255]);
    overlay.point([-0.6, 0.6, -2.0], [255, 0, 255]);
    let plain = render(&scene(), &camera(), &Overlay::default(), &small()).expect("picture");
    let hidden = render(&scene(), &camera(), &overlay, &small()).expect("picture");
    assert!(plain == hidden);
    overlay.on_top = true;
    assert!(plain != render(&scene(), &camera(), &overlay, &small()).expect("picture"));
    // Lines through the eye, from behind it, or with broken ends draw something or nothing.
    for (a, b) in [([2.0, 2.4, 7.0], [0.0, 0.0, 0.0]), ([9.0, 9.0, 90.0], [0.0, 1.0, 3.0])] {
        overlay.line(a, b, [0; 3]);
    }
    overlay.line([f64::NAN, 0.0, 0.0], [1.0, 0.0, 0.0], [0; 3]);
    overlay.point([f64::INFINITY, 0.0, 0.0], [0; 3]);
    render(&scene(), &camera(), &overlay, &small()).expect("picture");
}

#[test]
fn files_are_whole_or_absent() {
    let dir = std::env::temp_dir().join(format!("jounce_render_{}", std::process::id()));
    let path = dir.join("new/picture.png");
    let image = Image::new(4, 3, [1, 2, 3]).expect("small");
    image.write_png(&path).expect("written");
    let reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).expect("file")));
    let info = reader.read_info().expect("header");
    assert_eq!((info.info().width, info.info().height), (4, 3));
    assert!(image.write_png(&dir).is_err(), "a folder is no file");
    let left: Vec<_> = std::fs::read_dir(dir.join("new")).expect("folder").collect();
    assert_eq!(left.len(), 1, "no temporary file stays");
    std::fs::remove_dir_all(&dir).expect("removed");
}
