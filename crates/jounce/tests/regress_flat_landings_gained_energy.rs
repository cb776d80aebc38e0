//! A cylinder that landed flat rebounded higher than it was dropped from, and cubes left spinning: restitution went once over
//! the points of a face, one after the other, though each changes what the others need. And a tilted cube gained 40 %: the impulses
//! of the impact started the next step, and the friction among them turned the body into the surface before it was taken back.

use jounce::math::scalar::{f32s, f64s};
use jounce::prelude::*;

/// Highest and lowest total energy over `seconds`, as parts of the first, and the largest spin.
fn bounce(shape: ShapeDesc, tilt: f32, e: f32, friction: f32, seconds: f64) -> (f64, f64, f32) {
    let mut w = World::new(WorldDesc::default()).unwrap();
    let ground = ShapeDesc::half_space([0.0, 1.0, 0.0]).restitution(e).friction(friction);
    w.add_body(BodyDesc::fixed().shape(ground)).unwrap();
    let mut body = BodyDesc::dynamic().at([0.0, 3.0, 0.0]).shape(shape.restitution(e).friction(friction));
    body.rotation = Quat::from_axis_angle(Vec3::Z, tilt);
    let id = w.add_body(body).unwrap();
    let start = w.energy().total();
    let (mut high, mut low, mut spin) = (1.0f64, 1.0f64, 0.0f32);
    for _ in 0..(seconds * 60.0) as u32 {
        w.step().unwrap();
        let part = w.energy().total() / start;
        (high, low) = (f64s::max(high, part), f64s::min(low, part));
        spin = f32s::max(spin, w.body(id).unwrap().angular_velocity().length());
    }
    (high, low, spin)
}

#[test]
fn what_lands_flat_leaves_flat() {
    for shape in [
        ShapeDesc::cylinder(0.5, 0.5),
        ShapeDesc::cuboid([0.5, 0.5, 0.5]),
        ShapeDesc::cuboid([1.0, 0.1, 1.0]),
        ShapeDesc::cuboid([0.1, 0.5, 1.0]),
    ] {
        let what = format!("{:?}", shape.shape);
        let (high, low, spin) = bounce(shape, 0.0, 1.0, 0.0, 6.0);
        assert!(high < 1.02 && low > 0.96, "{what}: {low} to {high}");
        assert!(spin < 0.25, "{what}: {spin} rad/s");
    }
}

#[test]
fn no_landing_adds_energy() {
    for (i, shape) in [
        ShapeDesc::cylinder(0.5, 0.5),
        ShapeDesc::cuboid([0.5, 0.5, 0.5]),
        ShapeDesc::cuboid([0.5, 0.2, 0.3]),
        ShapeDesc::cone(0.5, 0.4),
    ]
    .into_iter()
    .enumerate()
    {
        for tilt in [0.02, 0.3, 0.7, 1.2] {
            for friction in [0.0, 0.6] {
                let (high, ..) = bounce(shape.clone(), tilt, 1.0, friction, 4.0);
                // Levers and inertia are those of the start of the step, up to ω Δt = 0.1 rad ago: within that.
                assert!(high < 1.1, "shape {i}, tilt {tilt}, friction {friction}: {high}");
            }
        }
    }
}
