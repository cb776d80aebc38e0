//! Coulomb friction of a block on a slope: the block holds while tan θ ≤ μ_s, and slides with g (sin θ − μ_k cos θ).

use super::{EPS, G, ShapeFriction, Slope, run, substep, threshold, world};
use crate::verify::{Law, Row, Rows};
use jounce::Result;
use jounce::prelude::*;

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "friction", name: "angle of repose", run: repose },
    Law { topic: "friction", name: "static against kinetic", run: between },
    Law { topic: "friction", name: "sliding acceleration", run: sliding },
    Law { topic: "friction", name: "slide up and stick", run: up_and_stick },
    Law { topic: "friction", name: "slide on the level", run: level },
];

/// Half extents of the block: flat, so that it slides rather than tips.
const HALF: [f32; 3] = [0.5, 0.1, 0.5];
/// The slop of a contact of this block: min(5 mm, 5 % of its thickness).
const SLOP: f64 = 0.005;

struct Block {
    world: World,
    id: BodyId,
    slope: Slope,
}

impl Block {
    /// On a slope, touching it, with a speed down the slope.
    fn new(angle: f64, friction: ShapeFriction, speed: f64) -> Result<Self> {
        let mut world = world(G, 60.0)?;
        let slope = Slope::new(&mut world, angle, friction)?;
        let id = world.add_body(
            BodyDesc::dynamic()
                .at(slope.normal * f64::from(HALF[1]))
                .rotated(slope.rotation)
                .velocity((slope.down * speed).as_vec3())
                .shape(ShapeDesc::cuboid(HALF).material(friction.material())),
        )?;
        Ok(Self { world, id, slope })
    }
    fn way(&self) -> Result<f64> {
        Ok(self.world.body(self.id)?.position().dot(self.slope.down))
    }
    fn speed(&self) -> Result<f64> {
        Ok(self.world.body(self.id)?.velocity().as_dvec3().dot(self.slope.down))
    }
}

fn repose() -> Rows {
    let mut rows = Vec::new();
    for mu in [0.1_f64, 0.5, 1.0] {
        let friction = ShapeFriction::same(mu);
        let angle = mu.atan();
        let holds = |a: f64| {
            let mut b = Block::new(a, friction, 0.0)?;
            run(&mut b.world, 4.0)?;
            // At 1 % above the angle it would have gone at least 8 g Δθ = 78 mm.
            Ok(b.way()? < 0.02)
        };
        let got = threshold(0.9 * angle, 1.1 * angle, 1e-3 * angle, holds)?;
        let name = format!("angle of repose, μ = {mu}");
        let (e, g) = (angle.to_degrees(), got.to_degrees());
        rows.push(Row::relative(&name, e, g, 0.01, "°", "tan θ = μ"));
        let mut b = Block::new(0.99 * angle, friction, 0.0)?;
        run(&mut b.world, 10.0)?;
        let name = format!("way in 10 s at 99 % of the angle, μ = {mu}");
        rows.push(Row::at_most(&name, SLOP, b.way()?.abs(), "m", "sticks: within the contact slop"));
    }
    Ok(rows)
}

fn between() -> Rows {
    let friction = ShapeFriction { hold: 0.6, slide: 0.4 };
    let angle = 0.5_f64.atan();
    let mut rest = Block::new(angle, friction, 0.0)?;
    run(&mut rest.world, 10.0)?;
    let holds = |a: f64| {
        let mut b = Block::new(a, friction, 0.0)?;
        run(&mut b.world, 4.0)?;
        Ok(b.way()? < 0.02)
    };
    let expected = 0.6_f64.atan();
    let breaks = threshold(0.9 * expected, 1.1 * expected, 1e-3 * expected, holds)?;
    let source = "holds while tan θ ≤ μs, μs = 0.6, μk = 0.4";
    Ok(vec![
        Row::at_most("block at rest between the two angles", SLOP, rest.way()?.abs(), "m", source),
        Row::relative(
            "angle at which it breaks loose",
            expected.to_degrees(),
            breaks.to_degrees(),
            0.01,
            "°",
            source,
        ),
    ])
}

/// Mean acceleration over the second after the first.
fn acceleration(b: &mut Block) -> Result<f64> {
    run(&mut b.world, 1.0)?;
    let v = b.speed()?;
    run(&mut b.world, 1.0)?;
    Ok(b.speed()? - v)
}

fn sliding() -> Rows {
    let mut rows = Vec::new();
    for (deg, hold, slide, speed) in
        [(30.0_f64, 0.3, 0.3, 0.0), (45.0, 0.5, 0.4, 0.0), (26.565, 0.6, 0.4, 1.0)]
    {
        let a = deg.to_radians();
        let mut b = Block::new(a, ShapeFriction { hold, slide }, speed)?;
        let expected = G * (a.sin() - slide * a.cos());
        let got = acceleration(&mut b)?;
        let name = format!("sliding at {deg}°, μs = {hold}, μk = {slide}, from {speed} m/s");
        rows.push(Row::relative(&name, expected, got, 0.01, "m/s²", "a = g (sin θ − μk cos θ)"));
    }
    Ok(rows)
}

fn up_and_stick() -> Rows {
    let friction = ShapeFriction { hold: 0.6, slide: 0.4 };
    let a = 0.5_f64.atan();
    let v = 3.0;
    let mut b = Block::new(a, friction, -v)?;
    let h = substep(&b.world);
    let brake = G * (a.sin() + 0.4 * a.cos());
    run(&mut b.world, 1.0)?;
    let top = -b.way()?;
    run(&mut b.world, 9.0)?;
    let drift = (b.way()? + top).abs();
    // Semi-implicit Euler stops v h/2 short, and the last step of the slide may be cut anywhere: v h in all. The slop
    // is where the block sinks in until it is carried.
    let tolerance = v * h + SLOP;
    let expected = v * v / (2.0 * brake);
    let source = "v²/(2 g (sin θ + μk cos θ)), then tan θ ≤ μs holds";
    Ok(vec![
        Row::new("way up at 3 m/s", expected, top, tolerance, "m", source),
        Row::at_most("way in the 9 s after", SLOP, drift, "m", source),
    ])
}

fn level() -> Rows {
    let (mu, v) = (0.5, 5.0);
    let mut b = Block::new(0.0, ShapeFriction::same(mu), v)?;
    let h = substep(&b.world);
    run(&mut b.world, 0.5)?;
    let at_half = b.speed()?;
    run(&mut b.world, 4.5)?;
    let expected = v * v / (2.0 * mu * G);
    let source = "v²/(2 μ g)";
    Ok(vec![
        Row::relative(
            "speed after 0.5 s, 5 m/s, μ = 0.5",
            v - mu * G * 0.5,
            at_half,
            0.01,
            "m/s",
            "v − μ g t",
        ),
        Row::new("way to a stop, 5 m/s, μ = 0.5", expected, b.way()?, v * h + SLOP, "m", source),
        Row::at_most("speed at rest", 2.0 * EPS * v, b.speed()?.abs(), "m/s", "sticks"),
    ])
}
