//! Messages showed vectors as `DVec3 { x: 0.0, … }`, and the one about stale handles told of another world, whose handles nobody
//! can tell from one's own.

mod support;

use jounce::prelude::*;
use support::*;

#[test]
fn vectors_are_shown_as_lists() {
    let mut w = world();
    let b = add_box(&mut w, [0.0, 0.5, 0.0], 0.5);
    let told = |r: jounce::Result<()>| r.expect_err("refused").to_string();
    assert_eq!(
        told(w.teleport(b, DVec3::new(0.0, f64::NAN, 2e9), Quat::IDENTITY)),
        "body: position is [0.0, NaN, 2000000000.0], expected finite, within ±1e9 m"
    );
    assert!(
        told(w.set_velocity(b, Vec3::splat(1e9))).contains("is [1000000000.0, 1000000000.0, 1000000000.0],")
    );
    assert!(
        told(w.teleport(b, DVec3::ZERO, Quat::new(0.0, 0.0, 0.0, 0.0))).contains("is [0.0, 0.0, 0.0, 0.0],")
    );
    let mass = jounce::geometry::MassProperties {
        mass: 1.0,
        center: Vec3::ZERO,
        inertia: jounce::math::Mat3::from_diagonal(Vec3::new(1.0, -1.0, 1.0)),
    };
    assert!(
        told(w.set_mass(b, Some(mass))).contains("is [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]],")
    );
}

#[test]
fn a_stale_handle_is_called_no_more_than_that() {
    let mut w = world();
    let b = add_box(&mut w, [0.0, 0.5, 0.0], 0.5);
    w.remove_body(b).expect("alive");
    let told = w.remove_body(b).expect_err("stale").to_string();
    assert_eq!(told, "body handle 0v1 is stale: it names nothing in this world, or no longer");
    // Another world's handle is taken for one's own where it names something here.
    let mut other = world();
    add_box(&mut other, [0.0, 0.5, 0.0], 0.5);
    assert!(other.body(b).is_ok());
}
