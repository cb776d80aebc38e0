//! Characters on a course: slopes, steps, seams, edges, ceilings, platforms, bodies in the way.
//!
//! What is expected follows from geometry: a slope of θ is walked iff θ ≤ `slope_max`; a step of h is climbed iff h ≤ `step_height`;
//! what stands keeps the gap `skin` to the ground.

use jounce::geometry::{HeightField, TriMesh, TriMeshOptions};
use jounce::math::scalar::{f32s, f64s};
use jounce::prelude::*;
use jounce::{
    CharacterDesc, CharacterId, CharacterInput, CharacterKind, CharacterMover, CharacterRef, Command,
    StageHashes,
};
use std::sync::Arc;

const SKIN: f64 = 0.01;

fn world() -> World {
    World::new(WorldDesc::default()).unwrap()
}

fn floor(w: &mut World) -> BodyId {
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).unwrap()
}

fn block(w: &mut World, at: [f64; 3], half: [f32; 3]) -> BodyId {
    w.add_body(BodyDesc::fixed().at(at).shape(ShapeDesc::cuboid(half))).unwrap()
}

fn hero(w: &mut World, at: [f64; 3]) -> CharacterId {
    w.add_character(CharacterDesc::at(at)).unwrap()
}

fn walk(w: &mut World, c: CharacterId, v: [f32; 3]) {
    w.set_character_input(c, CharacterInput::walk(v)).unwrap();
}

fn run(w: &mut World, seconds: f64) {
    for _ in 0..(seconds * 60.0).round() as usize {
        w.step().unwrap();
    }
}

fn at(w: &World, c: CharacterId) -> DVec3 {
    w.character(c).unwrap().position()
}

fn look(w: &World, c: CharacterId) -> CharacterRef<'_> {
    w.character(c).unwrap()
}

#[test]
fn it_stands_at_the_skin_and_does_not_move() {
    let mut w = world();
    floor(&mut w);
    let c = hero(&mut w, [0.0, 0.5, 0.0]);
    run(&mut w, 1.0);
    let p = at(&w, c);
    assert!((p.y - SKIN).abs() < 1e-4, "{p:?}");
    assert!(look(&w, c).is_grounded() && look(&w, c).air_time() == 0.0);
    let before = w.hash();
    let steps = w.step_count();
    run(&mut w, 2.0);
    assert_eq!(at(&w, c), p);
    // Nothing changes but the clock: not a bit of the state moves.
    assert!(w.step_count() > steps && w.hash() != before);
    let mut seen = StageHashes::default();
    w.step_observed(&mut seen).unwrap();
    assert_eq!(look(&w, c).velocity(), Vec3::ZERO);
}

/// A ramp of an angle that begins at x = 2.
fn ramp(w: &mut World, degrees: f32) {
    let t = degrees.to_radians();
    let q = Quat::from_axis_angle(Vec3::Z, t);
    // The top face goes through (2, 0).
    let middle = Vec3::new(2.0, 0.0, 0.0) + q.rotate(Vec3::new(10.0, -1.0, 0.0));
    let d = BodyDesc::fixed().at(middle.as_dvec3()).rotated(q).shape(ShapeDesc::cuboid([10.0, 1.0, 4.0]));
    w.add_body(d).unwrap();
}

#[test]
fn slopes_are_walked_or_refused_as_configured() {
    for degrees in [10.0, 20.0, 30.0, 40.0, 50.0, 60.0_f32] {
        let mut w = world();
        floor(&mut w);
        ramp(&mut w, degrees);
        let c = hero(&mut w, [0.0, SKIN, 0.0]);
        walk(&mut w, c, [3.0, 0.0, 0.0]);
        let mut sideways = 0.0;
        for _ in 0..180 {
            w.step().unwrap();
            sideways = f64s::max(sideways, at(&w, c).z.abs());
        }
        let p = at(&w, c);
        println!("slope {degrees}°: {p:?}, sideways {sideways:.1e}");
        assert!(sideways < 1e-4, "{degrees}°: {sideways}");
        if degrees < 45.0 {
            // 3 m/s along the ground: 9 m less the start.
            let along = p.y / f64::from(f32s::sin(degrees.to_radians()));
            assert!(along > 6.5 && along < 7.2, "{degrees}°: {along} m up the slope");
            assert!(look(&w, c).is_grounded());
        } else {
            // No higher than the step of its capsule's curve over the skin.
            assert!(p.y < 0.05 && p.x < 2.1, "{degrees}°: {p:?}");
        }
    }
}

/// Stands on what it may stand on, without creeping; slides down what is too steep as fast as free of friction.
#[test]
fn it_rests_on_slopes_and_slides_down_steep_ones() {
    let mut w = world();
    floor(&mut w);
    ramp(&mut w, 40.0);
    let c = hero(&mut w, [5.0, 3.0, 0.0]);
    run(&mut w, 1.0);
    let p = at(&w, c);
    run(&mut w, 5.0);
    assert!((at(&w, c) - p).length() < 1e-6, "{p:?} {:?}", at(&w, c));
    let mut w = world();
    floor(&mut w);
    ramp(&mut w, 60.0);
    let c = hero(&mut w, [5.0, 7.0, 0.0]);
    run(&mut w, 0.5);
    assert!(!look(&w, c).is_grounded());
    run(&mut w, 3.0);
    assert!(look(&w, c).is_grounded() && at(&w, c).y < 0.05, "{:?}", at(&w, c));
}

/// Stairs of five steps.
fn stairs(w: &mut World, rise: f64) {
    for i in 0..5 {
        let top = rise * f64::from(i + 1);
        block(w, [2.0 + 0.4 * f64::from(i) + 5.0, top * 0.5, 0.0], [5.0, (top * 0.5) as f32, 2.0]);
    }
}

#[test]
fn stairs_are_climbed_up_to_the_step_height_and_walked_down() {
    for rise in [0.1, 0.2, 0.3, 0.35, 0.4, 0.5] {
        for speed in [0.7_f32, 3.0] {
            let mut w = world();
            floor(&mut w);
            stairs(&mut w, rise);
            let c = hero(&mut w, [0.0, SKIN, 0.0]);
            walk(&mut w, c, [speed, 0.0, 0.0]);
            run(&mut w, 6.0 / f64::from(speed));
            let p = at(&w, c);
            println!("rise {rise} at {speed} m/s: {p:?}");
            if rise > 0.351 {
                assert!(p.y < 0.05 && p.x < 2.0, "{rise} m: {p:?}");
                continue;
            }
            assert!((p.y - 5.0 * rise - SKIN).abs() < 1e-3, "{rise} m at {speed} m/s: {p:?}");
            // Down again, without a moment in the air.
            walk(&mut w, c, [-speed, 0.0, 0.0]);
            let mut air = 0;
            for _ in 0..(6.5 / speed * 60.0) as usize {
                w.step().unwrap();
                air += usize::from(!look(&w, c).is_grounded());
            }
            assert!((at(&w, c).y - SKIN).abs() < 1e-3 && at(&w, c).x < 1.5, "{rise}: {:?}", at(&w, c));
            assert!(air == 0, "{rise} m at {speed} m/s: {air} steps in the air");
        }
    }
}

/// Flat floors of tiles of every make: sideways and vertical speed stay below 1 mm/s.
#[test]
fn flat_seams_are_not_felt() {
    let mut floors: Vec<(&str, World)> = Vec::new();
    let mut w = world();
    for i in -1..14 {
        for j in -2..5 {
            block(&mut w, [f64::from(i) + 0.5, -0.5, f64::from(j) + 0.5], [0.5, 0.5, 0.5]);
        }
    }
    floors.push(("boxes", w));
    let n = 15;
    let corners: Vec<Vec3> =
        (0..n).flat_map(|j| (0..n).map(move |i| Vec3::new(i as f32 - 1.0, 0.0, j as f32 - 7.0))).collect();
    let cell = |a: u32| [[a, a + n, a + 1], [a + 1, a + n, a + n + 1]];
    let triangles: Vec<_> = (0..n - 1).flat_map(|j| (0..n - 1).flat_map(move |i| cell(n * j + i))).collect();
    let mesh = TriMesh::new(&corners, &triangles, TriMeshOptions::default()).unwrap();
    let mut w = world();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::mesh(Arc::new(mesh)))).unwrap();
    floors.push(("mesh", w));
    let mut w = world();
    let field = HeightField::new(31, 31, [1.0, 1.0], vec![0.0; 31 * 31]).unwrap();
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::new(Shape::HeightField(Arc::new(field))))).unwrap();
    floors.push(("height field", w));
    for (name, mut w) in floors {
        let c = hero(&mut w, [0.3, 0.05, 0.2]);
        run(&mut w, 0.5);
        let dir = Vec3::new(f32s::cos(0.21), 0.0, f32s::sin(0.21));
        w.set_character_input(c, CharacterInput::walk(dir * 5.0)).unwrap();
        run(&mut w, 0.2);
        let across = Vec3::new(-dir.z, 0.0, dir.x).as_dvec3();
        let (mut side, mut rise, mut slow) = (0.0_f64, 0.0_f64, 9.0_f64);
        let mut last = at(&w, c);
        for _ in 0..110 {
            w.step().unwrap();
            let v = (at(&w, c) - last) * 60.0;
            last = at(&w, c);
            side = f64s::max(side, v.dot(across).abs());
            rise = f64s::max(rise, v.y.abs());
            slow = f64s::min(slow, v.dot(dir.as_dvec3()));
            assert!(look(&w, c).is_grounded(), "{name}");
        }
        println!("{name}: sideways {side:.2e}, up {rise:.2e} m/s, slowest {slow}");
        assert!(side < 1e-3 && rise < 1e-3, "{name}: {side} {rise}");
        assert!((slow - 5.0).abs() < 1e-3, "{name}: {slow}");
    }
}

/// Along a wall of tiles, pressed against it: no catch at the seams.
#[test]
fn walls_of_tiles_are_slid_along() {
    let mut w = world();
    floor(&mut w);
    for i in -1..12 {
        for y in 0..2 {
            block(&mut w, [f64::from(i), f64::from(y) + 0.5, 1.0], [0.5, 0.5, 0.5]);
        }
    }
    let c = hero(&mut w, [0.0, SKIN, 0.0]);
    walk(&mut w, c, [3.0, 0.0, 3.0]);
    run(&mut w, 1.0);
    let (mut slow, mut last) = (9.0_f64, at(&w, c));
    for _ in 0..120 {
        w.step().unwrap();
        slow = f64s::min(slow, (at(&w, c).x - last.x) * 60.0);
        last = at(&w, c);
    }
    assert!(slow > 2.9, "{slow}");
    assert!((last.z - (0.5 - 0.3 - SKIN)).abs() < 2e-3, "{last:?}");
}

/// Standing half over an edge, or in a corner, nothing moves; walking off, it falls.
#[test]
fn edges_do_not_jitter() {
    for over in [0.0, 0.05, 0.1, 0.15, 0.2] {
        let mut w = world();
        floor(&mut w);
        block(&mut w, [0.0, 1.0, 0.0], [1.0, 1.0, 1.0]);
        let c = hero(&mut w, [1.0 + over, 2.2, 0.0]);
        run(&mut w, 1.0);
        let p = at(&w, c);
        assert!(look(&w, c).is_grounded() && p.y > 1.8, "{over}: {p:?}");
        for _ in 0..120 {
            w.step().unwrap();
            assert!((at(&w, c) - p).length() < 1e-6, "{over}: {p:?} {:?}", at(&w, c));
            assert!(look(&w, c).is_grounded(), "{over}");
        }
        walk(&mut w, c, [2.0, 0.0, 0.0]);
        run(&mut w, 1.5);
        assert!((at(&w, c).y - SKIN).abs() < 1e-3, "{over}: {:?}", at(&w, c));
    }
    // Pressed into a corner of 60°: still.
    let mut w = world();
    floor(&mut w);
    for s in [-1.0_f32, 1.0] {
        let q = Quat::from_axis_angle(Vec3::Y, s * 30.0_f32.to_radians());
        let at = q.rotate(Vec3::new(3.0, 1.0, s * 0.5)) + Vec3::new(-3.0, 0.0, 0.0);
        w.add_body(BodyDesc::fixed().at(at.as_dvec3()).rotated(q).shape(ShapeDesc::cuboid([3.0, 1.0, 0.5])))
            .unwrap();
    }
    let c = hero(&mut w, [3.0, SKIN, 0.0]);
    walk(&mut w, c, [-3.0, 0.0, 0.3]);
    run(&mut w, 2.0);
    let p = at(&w, c);
    let mut moved = 0.0;
    for _ in 0..120 {
        w.step().unwrap();
        moved = f64s::max(moved, (at(&w, c) - p).length());
    }
    println!("corner: {p:?}, moved {moved:.2e}");
    assert!(moved < 1e-3, "{moved}");
}

#[test]
fn ceilings_end_a_jump_and_low_passages_need_a_crouch() {
    let mut w = world();
    floor(&mut w);
    block(&mut w, [0.0, 2.5, 0.0], [1.0, 0.5, 1.0]);
    let c = hero(&mut w, [0.0, SKIN, 0.0]);
    run(&mut w, 0.1);
    w.set_character_input(c, CharacterInput::default().jump(6.0)).unwrap();
    let (mut top, mut hit) = (0.0, false);
    for _ in 0..60 {
        w.step().unwrap();
        top = f64s::max(top, at(&w, c).y);
        hit |= look(&w, c).hit_ceiling();
    }
    assert!(hit && top < 0.2 - SKIN + 1e-4 && top > 0.17, "{top}");
    assert!(look(&w, c).is_grounded());
    // A jump in the open is as high as v²/2g, from symplectic steps.
    let free = hero(&mut w, [5.0, SKIN, 0.0]);
    run(&mut w, 0.1);
    w.set_character_input(free, CharacterInput::default().jump(5.0)).unwrap();
    let mut top = 0.0;
    for _ in 0..60 {
        w.step().unwrap();
        top = f64s::max(top, at(&w, free).y);
    }
    let want = 25.0 / (2.0 * 9.81) + SKIN;
    assert!((top - want).abs() < 0.5 * 5.0 / 60.0 + 1e-3, "{top} for {want}");
    // A passage 1.2 m high.
    block(&mut w, [13.0, 2.2, 0.0], [2.0, 1.0, 4.0]);
    walk(&mut w, free, [3.0, 0.0, 0.0]);
    run(&mut w, 4.0);
    assert!((at(&w, free).x - (11.0 - 0.3 - SKIN)).abs() < 2e-3, "{:?}", at(&w, free));
    w.set_character_input(free, CharacterInput::walk([3.0, 0.0, 0.0]).crouch()).unwrap();
    run(&mut w, 0.5);
    assert!(look(&w, free).is_crouched());
    // It stays down until there is headroom.
    walk(&mut w, free, [3.0, 0.0, 0.0]);
    run(&mut w, 0.5);
    assert!(look(&w, free).is_crouched() && at(&w, free).x > 12.0, "{:?}", at(&w, free));
    run(&mut w, 2.0);
    assert!(!look(&w, free).is_crouched() && at(&w, free).x > 15.0, "{:?}", at(&w, free));
    let height = w.shape(look(&w, free).shape()).unwrap().shape().clone();
    assert!(
        matches!(height, Shape::Capsule { half_height, radius } if (half_height + radius - 0.9).abs() < 1e-6)
    );
}

/// Carried along, up and down, and round, by kinematic bodies; velocity is taken along in a jump.
#[test]
fn platforms_carry() {
    let mut w = world();
    let lift = w
        .add_body(BodyDesc::kinematic().at([0.0, -0.5, 0.0]).shape(ShapeDesc::cuboid([2.0, 0.5, 2.0])))
        .unwrap();
    let c = hero(&mut w, [0.5, SKIN, 0.5]);
    run(&mut w, 0.1);
    w.set_velocity(lift, Vec3::new(2.0, 1.0, -1.0)).unwrap();
    for i in 0..120 {
        w.step().unwrap();
        let (p, l) = (at(&w, c), w.body(lift).unwrap().position());
        let d = p - l - DVec3::new(0.5, 0.5 + SKIN, 0.5);
        assert!(d.length() < 2e-3, "step {i}: {d:?}");
        assert!(look(&w, c).is_grounded(), "step {i}");
    }
    w.set_character_input(c, CharacterInput::default().jump(3.0)).unwrap();
    w.step().unwrap();
    let v = look(&w, c).velocity();
    assert!((v - Vec3::new(2.0, 4.0, -1.0)).length() < 0.05, "{v:?}");
    // By targets, downwards and fast.
    let mut w = world();
    let lift = w
        .add_body(BodyDesc::kinematic().at([0.0, -0.5, 0.0]).shape(ShapeDesc::cuboid([2.0, 0.5, 2.0])))
        .unwrap();
    let c = hero(&mut w, [0.5, SKIN, 0.5]);
    run(&mut w, 0.1);
    for i in 0..60 {
        let y = -0.5 - 0.05 * f64::from(i);
        w.move_to(lift, DVec3::new(0.0, y, 0.0), Quat::IDENTITY).unwrap();
        w.step().unwrap();
        assert!((at(&w, c).y - y - 0.5 - SKIN).abs() < 1e-3, "step {i}: {:?}", at(&w, c));
    }
    // A turntable: it stays where it stands on it, and turns with it.
    let mut w = world();
    let table =
        w.add_body(BodyDesc::kinematic().at([0.0, -0.5, 0.0]).shape(ShapeDesc::cylinder(0.5, 3.0))).unwrap();
    let c = hero(&mut w, [2.0, SKIN, 0.0]);
    run(&mut w, 0.1);
    w.set_angular_velocity(table, Vec3::new(0.0, 1.0, 0.0)).unwrap();
    run(&mut w, 3.0);
    let p = w.body(table).unwrap().pose().inverse_transform_point(at(&w, c));
    println!("turntable: {p:?}, heading {}", look(&w, c).heading());
    assert!((p - Vec3::new(2.0, 0.5 + SKIN as f32, 0.0)).length() < 0.01, "{p:?}");
    assert!((look(&w, c).heading() - 3.0).abs() < 0.02, "{}", look(&w, c).heading());
}

/// A wall that moves pushes it along; a lift that crushes it against a ceiling says so.
#[test]
fn moving_walls_push() {
    for speed in [1.0_f32, 20.0] {
        let mut w = world();
        floor(&mut w);
        let wall = w
            .add_body(BodyDesc::kinematic().at([-2.0, 1.5, 0.0]).shape(ShapeDesc::cuboid([0.5, 1.0, 2.0])))
            .unwrap();
        let c = hero(&mut w, [0.0, SKIN, 0.0]);
        run(&mut w, 0.1);
        w.set_velocity(wall, Vec3::new(speed, 0.0, 0.0)).unwrap();
        run(&mut w, 6.0 / f64::from(speed));
        let gap = at(&w, c).x - w.body(wall).unwrap().position().x - 0.5 - 0.3;
        assert!((gap - SKIN).abs() < 2e-3, "{speed} m/s: gap {gap}");
        assert!(at(&w, c).y < 0.02 && look(&w, c).is_grounded());
    }
    let mut w = world();
    floor(&mut w);
    let press = w
        .add_body(BodyDesc::kinematic().at([0.0, 3.0, 0.0]).shape(ShapeDesc::cuboid([1.0, 0.5, 1.0])))
        .unwrap();
    let c = hero(&mut w, [0.0, SKIN, 0.0]);
    run(&mut w, 0.1);
    assert!(!look(&w, c).is_squeezed());
    w.set_velocity(press, Vec3::new(0.0, -1.0, 0.0)).unwrap();
    run(&mut w, 1.2);
    println!("pressed: {:?} {:?}", at(&w, c), w.body(press).unwrap().position());
    assert!(look(&w, c).is_squeezed());
}

#[test]
fn it_pushes_a_box_of_10_kg_but_not_one_of_1000_kg() {
    for (mass, goes) in [(10.0_f32, true), (1000.0, false)] {
        let mut w = world();
        floor(&mut w);
        let b = w
            .add_body(
                BodyDesc::dynamic().at([1.5, 0.5, 0.0]).shape(ShapeDesc::cuboid([0.5, 0.5, 0.5]).mass(mass)),
            )
            .unwrap();
        let c = hero(&mut w, [0.0, SKIN, 0.0]);
        walk(&mut w, c, [2.0, 0.0, 0.0]);
        let mut fastest = 0.0;
        for _ in 0..180 {
            w.step().unwrap();
            fastest = f32s::max(fastest, w.body(b).unwrap().velocity().length());
        }
        let (p, q) = (at(&w, c), w.body(b).unwrap().position());
        println!("{mass} kg: character {p:?}, box {q:?}, fastest {fastest}");
        assert!(p.y < 0.05 && (q.y - 0.5).abs() < 0.01, "{mass}: {p:?} {q:?}");
        if goes {
            assert!(q.x > 4.0 && fastest < 2.2, "{mass}: {q:?} {fastest}");
        } else {
            assert!((q.x - 1.5).abs() < 1e-3 && (p.x - (0.7 - SKIN)).abs() < 3e-3, "{mass}: {p:?} {q:?}");
        }
    }
}

/// 300 N against the friction of a crate, µ m g with µ = 0.6: what they move goes nearly as fast as it walks, at any rate of steps; what they do not stays.
/// Before, 20 kg went at 1.5 m/s at 60 Hz and at 0.4 at 240, and 60 kg crept by 5 cm in 6 s.
#[test]
fn a_push_is_a_force() {
    for (rate_hz, mass) in [(60.0, 20.0_f32), (240.0, 20.0), (60.0, 40.0), (240.0, 40.0), (60.0, 60.0)] {
        let mut w = World::new(WorldDesc { rate_hz, ..WorldDesc::default() }).unwrap();
        floor(&mut w);
        let crate_ = BodyDesc::dynamic().at([1.5, 0.4, 0.0]).shape(ShapeDesc::cuboid([0.4; 3]).mass(mass));
        let b = w.add_body(crate_).unwrap();
        let c = hero(&mut w, [0.0, SKIN, 0.0]);
        walk(&mut w, c, [2.0, 0.0, 0.0]);
        for _ in 0..(5.0 * rate_hz) as usize {
            w.step().unwrap();
        }
        let b = w.body(b).unwrap();
        let (speed, way) = (b.velocity().x, b.position().x - 1.5);
        println!("{mass} kg at {rate_hz} Hz: {speed:.3} m/s, {way:.4} m");
        if 0.6 * 9.81 * mass < 300.0 {
            // In every step he makes up for what friction took in the one before.
            let want = 2.0 - 0.6 * 9.81 / rate_hz as f32;
            assert!((speed - want).abs() < 0.02, "{mass} kg, {rate_hz} Hz: {speed} m/s for {want}");
        } else {
            assert!(way < 1e-3, "{mass} kg: {way} m");
        }
    }
}

/// Up a step that is loose: it goes at once, and takes nothing along. Before, the box went off at 4.6 m/s at 60 Hz and at 17 at 240.
#[test]
fn loose_steps_are_not_kicked() {
    for rate_hz in [60.0, 240.0] {
        let mut w = World::new(WorldDesc { rate_hz, ..WorldDesc::default() }).unwrap();
        floor(&mut w);
        let step =
            BodyDesc::dynamic().at([2.0, 0.15, 0.0]).shape(ShapeDesc::cuboid([0.5, 0.15, 0.5]).mass(80.0));
        let b = w.add_body(step).unwrap();
        let c = hero(&mut w, [0.0, SKIN, 0.0]);
        walk(&mut w, c, [2.0, 0.0, 0.0]);
        let (mut fastest, mut high) = (0.0, 0.0);
        for _ in 0..(2.0 * rate_hz) as usize {
            w.step().unwrap();
            fastest = f32s::max(fastest, w.body(b).unwrap().velocity().length());
            high = f64s::max(high, at(&w, c).y);
        }
        println!("{rate_hz} Hz: {fastest} m/s, {high} m up");
        assert!(high > 0.29 && fastest < 0.5, "{rate_hz} Hz: {fastest} m/s, {high} m up");
    }
}

/// A heavy box that slides against it takes it along; a ball bounces off.
#[test]
fn heavy_bodies_push_it_and_light_ones_do_not() {
    let mut w = world();
    floor(&mut w);
    let d = BodyDesc::dynamic().at([-2.0, 0.75, 0.0]).velocity([4.0, 0.0, 0.0]);
    w.add_body(d.shape(ShapeDesc::cuboid([0.5, 0.75, 0.5]).mass(2000.0).friction(0.2))).unwrap();
    let c = hero(&mut w, [0.0, SKIN, 0.0]);
    run(&mut w, 2.0);
    // µ = √(0.2·0.6). It meets it after 1.19 m with v² = 16 − 2µg·1.19, and then has µg + F/m against it.
    let g = 9.81 * (0.2 * 0.6_f64).sqrt();
    let want = (16.0 - 2.0 * g * 1.19) / (2.0 * (g + 300.0 / 2000.0));
    // One step of its way: what comes on is met a step ahead.
    assert!((at(&w, c).x - want).abs() < 4.0 / 60.0, "{:?} for {want}", at(&w, c));
    let c = hero(&mut w, [0.0, SKIN, 10.0]);
    let d = BodyDesc::dynamic().at([-2.0, 1.0, 10.0]).velocity([15.0, 0.0, 0.0]);
    let ball = w.add_body(d.shape(ShapeDesc::sphere(0.11).mass(0.43).restitution(0.5))).unwrap();
    run(&mut w, 0.5);
    assert!(at(&w, c).x < 0.05, "{:?}", at(&w, c));
    assert!(w.body(ball).unwrap().velocity().x < -1.0, "{:?}", w.body(ball).unwrap().velocity());
}

/// Its weight tips a seesaw.
#[test]
fn it_weighs_on_what_it_stands_on() {
    let mut w = world();
    let post = w.add_body(BodyDesc::fixed()).unwrap();
    let plank = w
        .add_body(
            BodyDesc::dynamic().at([0.0, 1.0, 0.0]).shape(ShapeDesc::cuboid([3.0, 0.1, 0.5]).mass(40.0)),
        )
        .unwrap();
    w.add_joint(JointDesc::hinge(post, plank, [0.0, 1.0, 0.0], Vec3::Z).limited(-0.3, 0.3)).unwrap();
    run(&mut w, 0.5);
    let c = hero(&mut w, [2.0, 1.2, 0.0]);
    run(&mut w, 2.0);
    let q = w.body(plank).unwrap().rotation();
    assert!(q.z < -0.14, "{q:?}");
    assert!(look(&w, c).is_grounded());
}

#[test]
fn one_way_platforms_carry_from_above_alone() {
    let mut w = world();
    floor(&mut w);
    let layer = Filter { layers: 2, ..Filter::default() };
    let platform = ShapeDesc::cuboid([2.0, 0.1, 2.0]).filter(layer);
    w.add_body(BodyDesc::fixed().at([0.0, 1.0, 0.0]).shape(platform.clone())).unwrap();
    let mover = CharacterMover { one_way_layers: 2, ..CharacterMover::default() };
    let c = w.add_character(CharacterDesc::at([0.0, SKIN, 0.0]).mover(mover)).unwrap();
    run(&mut w, 0.1);
    w.set_character_input(c, CharacterInput::default().jump(6.0)).unwrap();
    run(&mut w, 1.5);
    assert!((at(&w, c).y - 1.1 - SKIN).abs() < 1e-3, "{:?}", at(&w, c));
    w.set_character_input(c, CharacterInput { drop_through: true, ..CharacterInput::default() }).unwrap();
    run(&mut w, 1.0);
    assert!((at(&w, c).y - SKIN).abs() < 1e-3, "{:?}", at(&w, c));
    // From the side too: one at chest height is walked through.
    w.add_body(BodyDesc::fixed().at([5.0, 1.0, 0.0]).shape(platform)).unwrap();
    walk(&mut w, c, [3.0, 0.0, 0.0]);
    run(&mut w, 3.0);
    assert!(at(&w, c).x > 8.0 && at(&w, c).y < 0.05, "{:?}", at(&w, c));
}

#[test]
fn the_move_for_games_slides_climbs_and_pushes() {
    let mut w = world();
    floor(&mut w);
    stairs(&mut w, 0.3);
    let m = CharacterMover::default();
    let filter = QueryFilter::default();
    let mut p = DVec3::new(0.0, 0.5, 0.0);
    let mut grounded = false;
    let (mut fall, mut climbed) = (0.0, 0.0);
    for _ in 0..180 {
        fall = if grounded { 0.0 } else { fall - 9.81 / 60.0 };
        let motion = Vec3::new(3.0 / 60.0, fall / 60.0, 0.0);
        let made = w.move_character(&m, p, motion, grounded, &filter).unwrap();
        (p, grounded) = (made.position, made.ground.is_some());
        climbed += made.stepped;
    }
    assert!((p.y - 1.5 - SKIN).abs() < 1e-3 && grounded && climbed > 1.0, "{p:?} {climbed}");
    let b = w
        .add_body(
            BodyDesc::dynamic().at([-2.0, 0.5, 0.0]).shape(ShapeDesc::cuboid([0.5, 0.5, 0.5]).mass(10.0)),
        )
        .unwrap();
    let want = Vec3::new(-2.0, 0.0, 0.0);
    let made = w
        .move_character(&m, DVec3::new(-1.1, SKIN, 0.0), want, true, &filter.excluding(BodyId::from_bits(0)))
        .unwrap();
    let pushes = w.character_push(&made, Vec3::Y, want, 300.0);
    assert!(
        matches!(pushes[..], [Command::AddImpulse(x, j, _)] if x == b && (j.x + 5.0).abs() < 1e-3),
        "{pushes:?}"
    );
}

#[test]
fn the_dynamic_one_walks_climbs_and_is_pushed() {
    let mut w = world();
    floor(&mut w);
    stairs(&mut w, 0.2);
    let c = w.add_character(CharacterDesc::at([0.0, 0.3, 0.0]).dynamic()).unwrap();
    run(&mut w, 1.5);
    let p = at(&w, c);
    // The leg holds the foot at the ground: the weight is held besides the spring.
    assert!(p.y.abs() < 0.02 && look(&w, c).is_grounded(), "{p:?}");
    assert!(w.body(look(&w, c).body()).unwrap().velocity().length() < 1e-2);
    walk(&mut w, c, [3.0, 0.0, 0.0]);
    run(&mut w, 2.5);
    let p = at(&w, c);
    println!("dynamic on the stairs: {p:?}");
    assert!(p.x > 5.0 && (p.y - 1.0).abs() < 0.03, "{p:?}");
    // Too steep is refused.
    for (degrees, up) in [(30.0, true), (60.0, false)] {
        let mut w = world();
        floor(&mut w);
        ramp(&mut w, degrees);
        let c = w.add_character(CharacterDesc::at([0.0, 0.0, 0.0]).dynamic()).unwrap();
        walk(&mut w, c, [3.0, 0.0, 0.0]);
        run(&mut w, 3.0);
        println!("dynamic on {degrees}°: {:?}", at(&w, c));
        assert_eq!(at(&w, c).y > 1.5, up, "{degrees}: {:?}", at(&w, c));
        assert!(up || at(&w, c).y < 0.5, "{:?}", at(&w, c));
    }
    // A jump, and a push.
    let mut w = world();
    floor(&mut w);
    let c = w.add_character(CharacterDesc::at([0.0, 0.0, 0.0]).dynamic()).unwrap();
    run(&mut w, 0.5);
    w.set_character_input(c, CharacterInput::default().jump(5.0)).unwrap();
    let mut top = 0.0;
    for _ in 0..90 {
        w.step().unwrap();
        top = f64s::max(top, at(&w, c).y);
    }
    assert!((top - 1.27).abs() < 0.1, "{top}");
    let d = BodyDesc::dynamic().at([-2.0, 0.75, 0.0]).velocity([4.0, 0.0, 0.0]);
    w.add_body(d.shape(ShapeDesc::cuboid([0.5, 0.75, 0.5]).mass(500.0).friction(0.2))).unwrap();
    run(&mut w, 2.0);
    assert!(at(&w, c).x > 0.3, "{:?}", at(&w, c));
}

/// A light box that it walks into, and over, was kicked away at 106 m/s: the leg pushed as if the box were the ground.
#[test]
fn the_dynamic_one_does_not_kick_light_boxes() {
    for (mass, half) in [(0.5, 0.3), (0.5, 0.1), (5.0, 0.3)] {
        let mut w = world();
        floor(&mut w);
        let shape = ShapeDesc::cuboid([half; 3]).mass(mass);
        let b = w.add_body(BodyDesc::dynamic().at([3.0, f64::from(half), 0.0]).shape(shape)).unwrap();
        let c = w.add_character(CharacterDesc::at([0.0, 0.0, 0.0]).dynamic()).unwrap();
        walk(&mut w, c, [3.0, 0.0, 0.0]);
        let mut fastest: f32 = 0.0;
        for _ in 0..60 * 6 {
            w.step().unwrap();
            fastest = f32s::max(fastest, w.body(b).unwrap().velocity().length());
        }
        println!("{mass} kg, {half} m: {fastest:.1} m/s; {:?}", at(&w, c));
        assert!(fastest < 12.0, "{mass} kg, {half} m: {fastest} m/s");
        // What is higher than a step was pushed, by someone who walks at 3 m/s.
        assert!(half < 0.2 || fastest > 2.0, "{mass} kg, {half} m: {fastest} m/s");
        assert!(at(&w, c).x > 3.0, "{:?}", at(&w, c));
    }
}

/// A crowd on platforms, among boxes, for hashes.
fn crowd() -> (World, Vec<CharacterId>) {
    let mut w = world();
    floor(&mut w);
    stairs(&mut w, 0.25);
    let table =
        w.add_body(BodyDesc::kinematic().at([-4.0, 0.1, 0.0]).shape(ShapeDesc::cylinder(0.1, 2.5))).unwrap();
    w.set_angular_velocity(table, Vec3::new(0.0, 0.7, 0.0)).unwrap();
    for i in 0..12 {
        let at = [f64::from(i % 4) - 1.5, 0.3, f64::from(i / 4) * 0.8 - 4.0];
        w.add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid([0.2, 0.3, 0.25]).mass(8.0))).unwrap();
    }
    let ids = (0..10)
        .map(|i| {
            let mut d = CharacterDesc::at([f64::from(i) - 6.0, 0.4, f64::from(i % 3)]);
            if i % 4 == 3 {
                d.kind = CharacterKind::DYNAMIC;
            }
            w.add_character(d).unwrap()
        })
        .collect();
    (w, ids)
}

fn order(w: &mut World, ids: &[CharacterId], step: usize) {
    for (i, &c) in ids.iter().enumerate() {
        if (step + 7 * i).is_multiple_of(40) {
            let t = (step + 31 * i) as f32;
            let mut input = CharacterInput::walk([2.5 * f32s::cos(t), 0.0, 2.5 * f32s::sin(t)]);
            input.crouch = (step / 40 + i).is_multiple_of(3);
            input.jump = (step + i).is_multiple_of(5).then_some(4.0);
            w.queue(Command::SetCharacterInput(c, input)).unwrap();
        }
    }
}

#[test]
fn characters_have_the_same_bits_on_any_thread_count_and_as_clones() {
    let (mut one, ids) = crowd();
    let (mut four, _) = crowd();
    let (mut chaos, _) = crowd();
    four.set_tasks(Tasks::pool(4));
    chaos.set_tasks(Tasks::chaos(5));
    let mut copy = None;
    for i in 0..240 {
        for w in [&mut one, &mut four, &mut chaos] {
            order(w, &ids, i);
            w.step().unwrap();
        }
        assert_eq!(one.hash(), four.hash(), "step {i}");
        assert_eq!(one.hash(), chaos.hash(), "step {i}");
        if i == 90 {
            copy = Some(one.clone());
        } else if let Some(copy) = &mut copy {
            order(copy, &ids, i);
            copy.step().unwrap();
            assert_eq!(one.hash(), copy.hash(), "clone, step {i}");
        }
    }
    for &c in &ids {
        assert!(at(&one, c).is_finite() && at(&one, c).y > -0.05, "{:?}", at(&one, c));
    }
}

#[test]
fn bad_characters_are_refused_by_name() {
    let mut w = world();
    let good = CharacterDesc::default();
    let m = CharacterMover::default();
    let nan = f32::NAN;
    let bad: Vec<(&str, CharacterDesc)> = vec![
        ("radius", CharacterDesc { mover: CharacterMover { radius: nan, ..m }, ..good.clone() }),
        ("height", CharacterDesc { mover: CharacterMover { height: 0.3, ..m }, ..good.clone() }),
        ("up", CharacterDesc { mover: CharacterMover { up: Vec3::ZERO, ..m }, ..good.clone() }),
        ("slope_max", CharacterDesc { mover: CharacterMover { slope_max: 2.0, ..m }, ..good.clone() }),
        ("step_height", CharacterDesc { mover: CharacterMover { step_height: -1.0, ..m }, ..good.clone() }),
        ("snap", CharacterDesc { mover: CharacterMover { snap: f32::INFINITY, ..m }, ..good.clone() }),
        ("skin", CharacterDesc { mover: CharacterMover { skin: 0.0, ..m }, ..good.clone() }),
        ("position", CharacterDesc::at([f64::NAN, 0.0, 0.0])),
        ("mass", CharacterDesc { mass: 0.0, ..good.clone() }),
        ("push_force", CharacterDesc { push_force: nan, ..good.clone() }),
        ("crouch_height", CharacterDesc { crouch_height: 3.0, ..good.clone() }),
        ("acceleration", CharacterDesc { acceleration: -1.0, ..good.clone() }),
        ("heading", CharacterDesc { heading: nan, ..good.clone() }),
        ("name", CharacterDesc { name: Some("x".repeat(300)), ..good.clone() }),
    ];
    for (field, d) in bad {
        let e = w.add_character(d).expect_err(field).to_string();
        assert!(e.contains("character") && e.contains(field), "{field}: {e}");
    }
    assert_eq!((w.counts().characters, w.counts().bodies), (0, 0));
    let c = w.add_character(good.clone()).unwrap();
    let before = w.hash();
    assert!(w.set_character_input(c, CharacterInput::walk([nan, 0.0, 0.0])).is_err());
    assert!(w.set_character_input(c, CharacterInput::default().jump(-1.0)).is_err());
    assert!(w.set_character(c, good.clone().dynamic()).is_err());
    assert!(w.move_character(&m, DVec3::ZERO, Vec3::splat(nan), true, &QueryFilter::default()).is_err());
    assert_eq!(w.hash(), before);
    // Smaller from now on; and gone with its body.
    let small = CharacterDesc { mover: CharacterMover { height: 1.2, ..m }, ..good };
    w.set_character(c, small).unwrap();
    run(&mut w, 0.1);
    w.remove_body(w.character(c).unwrap().body()).unwrap();
    assert!(w.character(c).is_err() && w.set_character_input(c, CharacterInput::default()).is_err());
    let d = hero(&mut w, [0.0; 3]);
    assert_ne!(c, d);
    w.remove_character(d).unwrap();
    assert_eq!((w.counts().characters, w.counts().bodies), (0, 0));
    run(&mut w, 0.1);
}
