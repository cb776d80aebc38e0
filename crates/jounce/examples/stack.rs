//! scratch
use jounce::Settings;
use jounce::prelude::*;
fn main() -> jounce::Result<()> {
    let arg = |i: usize, d: u32| std::env::args().nth(i).and_then(|a| a.parse().ok()).unwrap_or(d);
    let (n, boxg, rec) = (arg(1, 20), arg(2, 0), arg(3, 1));
    let settings = Settings { sleep: false, recycle_contacts: rec == 1, ..Settings::default() };
    let mut world = World::new(WorldDesc { settings, ..WorldDesc::default() })?;
    if boxg == 1 {
        world.add_body(BodyDesc::fixed().at([0.0, -1.0, 0.0]).shape(ShapeDesc::cuboid([40.0, 1.0, 40.0])))?;
    } else {
        world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)))?;
    }
    let ids: Vec<_> = (0..n)
        .map(|i| {
            world
                .add_body(
                    BodyDesc::dynamic().at([0.0, 0.5 + f64::from(i), 0.0]).shape(ShapeDesc::cuboid([0.5; 3])),
                )
                .unwrap()
        })
        .collect();
    for s in 0..1500 {
        world.step()?;
        if s % 150 == 0 || (s < 100 && s % 8 == 0) {
            let b = world.body(ids[0])?;
            let t = world.body(ids[n as usize - 1])?;
            println!(
                "{s:5} {:?} v {:?} w {:?} | {:?} {:?}",
                b.position(),
                b.velocity(),
                b.angular_velocity(),
                t.position(),
                t.velocity()
            );
        }
    }
    Ok(())
}
