//! The end of a contact by `remove_body`, and who left a sensor that was removed, went into the list of the step before, which
//! the next `step` cleared: the usual loop (edit, step, read the events) never saw them. What edits cause now waits for the
//! next step, through any number of frames without one.

mod support;

use jounce::prelude::*;
use support::*;

fn shape_of(w: &World, b: BodyId) -> ShapeId {
    w.body(b).expect("alive").shapes().next().expect("a shape")
}

#[test]
fn the_end_of_a_contact_by_a_removal_comes_with_the_next_step() {
    let mut w = world();
    let floor = ground(&mut w);
    let b = add_box(&mut w, [0.0, 0.5, 0.0], 0.5);
    step(&mut w, 5);
    let end = Event::ContactEnd { a: shape_of(&w, floor), b: shape_of(&w, b) };
    let before = w.hash();
    w.remove_body(b).expect("alive");
    assert!(!w.events().contains(&end), "not yet: {:?}", w.events());
    assert_ne!(w.hash(), before);
    w.step().expect("steps");
    assert_eq!(w.events(), [end]);
    w.step().expect("steps");
    assert_eq!(w.events(), []);
}

#[test]
fn a_removed_sensor_is_left_by_whoever_was_inside() {
    let mut w = world();
    w.set_gravity(Vec3::ZERO).expect("valid");
    let zone = w.add_body(BodyDesc::fixed().shape(ShapeDesc::sphere(2.0).sensor())).expect("a zone");
    let b = add_box(&mut w, [0.5, 0.0, 0.0], 0.5);
    let leave = Event::SensorLeave { sensor: shape_of(&w, zone), visitor: shape_of(&w, b) };
    step(&mut w, 1);
    w.remove_body(zone).expect("alive");
    w.step().expect("steps");
    assert_eq!(w.events(), [leave]);
}

#[test]
fn frames_without_a_step_lose_nothing_and_repeat_nothing() {
    let mut w = world();
    let floor = ground(&mut w);
    let b = add_box(&mut w, [0.0, 0.5, 0.0], 0.5);
    let pair = (shape_of(&w, floor), shape_of(&w, b));
    let mut told = Vec::new();
    for frame in 0..40 {
        if frame == 20 {
            w.remove_body(b).expect("alive");
        }
        // Two frames in three make no step.
        w.advance(1.0 / 180.0).expect("valid");
        told.extend(w.events().iter().copied());
    }
    assert_eq!(
        told,
        [Event::ContactBegin { a: pair.0, b: pair.1 }, Event::ContactEnd { a: pair.0, b: pair.1 }]
    );
}

#[test]
fn how_frames_share_out_the_steps_is_not_in_the_hash() {
    let run = |frame_dt: f64, frames: u32| {
        let mut w = world();
        ground(&mut w);
        add_box(&mut w, [0.0, 0.5, 0.0], 0.5);
        for _ in 0..frames {
            w.advance(frame_dt).expect("valid");
        }
        (w.step_count(), w.hash())
    };
    // The contact begins in step 1: in a frame of its own, in a frame with others, and long ago.
    let one = run(1.001 / 60.0, 3);
    assert_eq!(one.0, 3);
    assert_eq!(run(3.001 / 60.0, 1), one);
    assert_eq!(run(0.5005 / 60.0, 6), one);
}
