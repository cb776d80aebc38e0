//! A car drives a lap and tells how: `cargo run --release -p jounce --example car_lap`.
//!
//! The driver looks at a point ahead on an oval of two straights and two half circles, brakes for the bends and steers towards it.

use jounce::prelude::*;
use jounce::vehicles;

/// Half the straight, and the radius of the bends, m.
const STRAIGHT: f64 = 60.0;
const RADIUS: f64 = 25.0;

/// The point of the oval nearest to a place, how far it is along the lap, and whether a bend comes within `ahead` metres.
fn along(s: f64) -> DVec3 {
    use jounce::math::scalar::f64s::{cos, sin};
    let bend = core::f64::consts::PI * RADIUS;
    let lap = 4.0 * STRAIGHT + 2.0 * bend;
    let s = s.rem_euclid(lap);
    if s < 2.0 * STRAIGHT {
        DVec3::new(RADIUS, 0.0, s - STRAIGHT)
    } else if s < 2.0 * STRAIGHT + bend {
        let a = (s - 2.0 * STRAIGHT) / RADIUS;
        DVec3::new(RADIUS * cos(a), 0.0, STRAIGHT + RADIUS * sin(a))
    } else if s < 4.0 * STRAIGHT + bend {
        DVec3::new(-RADIUS, 0.0, STRAIGHT - (s - 2.0 * STRAIGHT - bend))
    } else {
        let a = (s - 4.0 * STRAIGHT - bend) / RADIUS;
        DVec3::new(-RADIUS * cos(a), 0.0, -STRAIGHT - RADIUS * sin(a))
    }
}

fn main() -> jounce::Result<()> {
    let mut world = World::new(WorldDesc::default())?;
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).friction(1.0)))?;
    let car = vehicles::car().add(&mut world, [RADIUS, 0.0, -STRAIGHT], Quat::IDENTITY)?;
    let body = world.vehicle(car)?.chassis();
    let lap = 4.0 * STRAIGHT + 2.0 * core::f64::consts::PI * RADIUS;
    let (mut s, mut printed) = (0.0, 0.0);
    println!("   t s   lap m  km/h  gear    rpm  slip fl  fr load fl     fr     rl     rr N");
    while s < lap && world.time() < 120.0 {
        let at = world.body(body)?.position();
        // The nearest point moves on as long as the next one is nearer.
        while (along(s + 0.5) - at).length() < (along(s) - at).length() {
            s += 0.5;
        }
        let t = world.vehicle(car)?.telemetry();
        let speed = f64::from(t.speed);
        let target = world.body(body)?.pose().inverse_transform_point(along(s + 4.0 + 0.35 * speed));
        // Pure pursuit: the circle through the point ahead; right is −x.
        let curve = -2.0 * target.x / target.length_squared();
        let steer = (curve * 2.6 / 0.6).clamp_to(1.0);
        let straight = (along(s + 0.9 * speed + 5.0) - along(s)).length() > 0.999 * (0.9 * speed + 5.0);
        let wanted = if straight { 30.0 } else { 13.0 };
        let error = wanted - t.speed;
        let input = VehicleInput {
            throttle: (0.3 * error).clamp_to(1.0).max_zero(),
            brake: (-0.2 * error).clamp_to(1.0).max_zero(),
            ..VehicleInput::drive(0.0, steer)
        };
        world.set_vehicle_input(car, input)?;
        world.step()?;
        if world.time() >= printed {
            printed += 1.0;
            let w: Vec<_> = world.vehicle(car)?.wheels().collect();
            println!(
                "{:6.2} {s:7.1} {:5.1} {:5} {:6.0}   {:6.3} {:6.3} {:6.0} {:6.0} {:6.0} {:6.0}",
                world.time(),
                3.6 * t.speed,
                t.gear,
                t.rpm,
                w[0].slip_ratio,
                w[1].slip_ratio,
                w[0].load,
                w[1].load,
                w[2].load,
                w[3].load
            );
        }
    }
    println!("a lap of {lap:.0} m in {:.2} s, {:#018x}", world.time(), world.hash());
    Ok(())
}

/// Bounds by comparison, as the engine has them.
trait Bounded {
    fn clamp_to(self, most: f32) -> f32;
    fn max_zero(self) -> f32;
}

impl Bounded for f32 {
    fn clamp_to(self, most: f32) -> f32 {
        jounce::math::scalar::f32s::clamp(self, -most, most)
    }
    fn max_zero(self) -> f32 {
        jounce::math::scalar::f32s::max(self, 0.0)
    }
}
