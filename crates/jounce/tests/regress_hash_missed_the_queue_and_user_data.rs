//! Two worlds of which one had a queued command, or a caller's number, that the other had not gave the same hash, though the next
//! step (or a hook) told them apart.

mod support;

use jounce::Command;
use jounce::prelude::*;
use support::*;

#[test]
fn queued_commands_are_hashed_in_full() {
    let mut w = world();
    let b = add_box(&mut w, [0.0, 5.0, 0.0], 0.5);
    let other = add_box(&mut w, [5.0, 5.0, 0.0], 0.5);
    step(&mut w, 3);
    let with = |commands: &[Command]| {
        let mut w = w.clone();
        commands.iter().for_each(|c| w.queue(c.clone()).expect("room"));
        w.hash()
    };
    let push = |b, y: f32| Command::AddImpulse(b, Vec3::new(0.0, y, 0.0), None);
    let all = [
        w.hash(),
        with(&[push(b, 1.0)]),
        with(&[push(b, f32::from_bits(1.0f32.to_bits() + 1))]),
        with(&[push(other, 1.0)]),
        with(&[push(b, 1.0), push(b, 1.0)]),
        with(&[Command::AddForce(b, Vec3::Y, None)]),
        with(&[push(b, 1.0), push(other, 1.0)]),
        with(&[push(other, 1.0), push(b, 1.0)]),
    ];
    for (i, h) in all.iter().enumerate() {
        assert!(!all[..i].contains(h), "case {i}");
    }
    assert_eq!(with(&[push(b, 1.0)]), all[1]);
    // Acted upon, the queue is empty again.
    let mut queued = w.clone();
    queued.queue(push(b, 1.0)).expect("room");
    queued.step().expect("steps");
    w.add_impulse(b, Vec3::Y, None).expect("alive");
    w.step().expect("steps");
    assert_eq!(queued.hash(), w.hash());
}

#[test]
fn the_callers_numbers_are_hashed() {
    let make = |body: u128, shape: u128| {
        let mut w = world();
        let mut ball = ShapeDesc::sphere(0.5);
        ball.user_data = shape;
        w.add_body(BodyDesc::dynamic().user_data(body).shape(ball)).expect("a ball");
        w.hash()
    };
    let all = [make(0, 0), make(1, 0), make(0, 1), make(1 << 64, 0), make(1, 1)];
    for (i, h) in all.iter().enumerate() {
        assert!(!all[..i].contains(h), "case {i}");
    }
}
