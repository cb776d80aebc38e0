//! Joints as rods, balls and coils.

use crate::extras::{Ball, Extras, Rod};
use jounce::math::scalar::f32s;
use jounce::math::{DVec3, Vec3};
use jounce::{AxisDesc, JointId, JointKind, JointRef, World};

const STEEL: [f32; 3] = [0.58, 0.60, 0.63];
const ROPE: [f32; 3] = [0.66, 0.53, 0.36];
const DARK: [f32; 3] = [0.22, 0.24, 0.27];
/// Pieces of a hanging rope.
const SAG_PIECES: u32 = 16;
/// Pieces of a turn of a coil.
const TURN_PIECES: u32 = 10;

/// Adds a joint as it stands: rods and ropes from point to point (slack ones hang), springs as coils, axes of hinges, wheels and
/// sliders as ticks, ball joints as balls, pulleys with their wheels, paths as rails. Welds and gears do not show, nor do
/// joints that are broken or out of the simulation. `width` is the thickness of a rope, m; `color` is sRGB, `None` for the
/// joint's usual one.
pub fn add_joint(world: &World, id: JointId, width: f32, color: Option<[f32; 3]>, extras: &mut Extras) {
    let Ok(j) = world.joint(id) else { return };
    if !j.is_enabled() || width.is_nan() || width <= 0.0 {
        return;
    }
    let [a, b] = j.anchors();
    let r = 0.5 * width;
    let mut pen = Pen { extras, r };
    match j.kind() {
        JointKind::Distance { min, max } if min == max => pen.rod(a, b, color.unwrap_or(STEEL)),
        JointKind::Distance { max, .. } => {
            let down = world.gravity().normalize_or(Vec3::ZERO).as_dvec3();
            pen.rope(a, b, f64::from(*max), down, color.unwrap_or(ROPE));
        }
        JointKind::Spring { rest, .. } => pen.coil(a, b, *rest, color.unwrap_or(STEEL)),
        JointKind::Hinge(_) | JointKind::Wheel { .. } => {
            let x = j.frame_b().q.rotate(Vec3::X).as_dvec3() * f64::from(width * 4.0);
            pen.r = width;
            pen.rod(b - x, b + x, color.unwrap_or(DARK));
        }
        JointKind::Slider(axis) => pen.rail(&j, axis, color.unwrap_or(STEEL)),
        JointKind::Ball(_) | JointKind::Generic { .. } => pen.ball(b, 2.5, color.unwrap_or(DARK)),
        JointKind::Pulley { wheel_a, wheel_b, .. } => {
            let color = color.unwrap_or(ROPE);
            for (p, q) in [(a, *wheel_a), (*wheel_a, *wheel_b), (*wheel_b, b)] {
                pen.rod(p, q, color);
            }
            pen.ball(*wheel_a, 4.0, DARK);
            pen.ball(*wheel_b, 4.0, DARK);
        }
        JointKind::Path(_) => {
            let points = j.curve();
            for w in points.windows(2) {
                pen.rod(w[0], w[1], color.unwrap_or(STEEL));
            }
            pen.ball(b, 2.5, DARK);
        }
        _ => {}
    }
}

struct Pen<'a> {
    extras: &'a mut Extras,
    r: f32,
}

impl Pen<'_> {
    fn rod(&mut self, a: DVec3, b: DVec3, color: [f32; 3]) {
        if a != b {
            self.extras.rods.push(Rod::new(a, b, self.r, color));
        }
    }

    fn ball(&mut self, at: DVec3, times: f32, color: [f32; 3]) {
        self.extras.balls.push(Ball::new(at, self.r * times, color));
    }

    /// A rope of a length: straight where it is taut, else a parabola. Of a flat one with chord c and sag s the length is
    /// c + 8 s²/3 c; a steep one is no deeper than half its length.
    fn rope(&mut self, a: DVec3, b: DVec3, length: f64, down: DVec3, color: [f32; 3]) {
        let chord = (b - a).length();
        let slack = length - chord;
        if !slack.is_finite() || slack < 0.005 * chord {
            return self.rod(a, b, color);
        }
        let flat = (3.0 * chord * slack / 8.0).sqrt();
        let sag = if flat < 0.5 * slack { 0.5 * slack } else { flat };
        let at = |i: u32| {
            let t = f64::from(i) / f64::from(SAG_PIECES);
            a + (b - a) * t + down * (4.0 * sag * t * (1.0 - t))
        };
        for i in 0..SAG_PIECES {
            self.rod(at(i), at(i + 1), color);
        }
    }

    /// As many turns as its length at rest asks for, so that they open and close with it.
    fn coil(&mut self, a: DVec3, b: DVec3, rest: f32, color: [f32; 3]) {
        let d = b - a;
        let length = d.length();
        let Some((axis, _)) = d.as_vec3().try_normalize() else { return };
        let (x, y) = axis.orthonormal_basis();
        let radius = self.r * 5.0;
        let turns = f32s::clamp((rest / (self.r * 7.0)).round(), 4.0, 30.0) as u32;
        // Straight ends lead to the two points.
        let end = 0.08;
        let (first, last) = (a + d * end, b - d * end);
        let pieces = turns * TURN_PIECES;
        let at = |i: u32| {
            let phi = i as f32 * (core::f32::consts::TAU / TURN_PIECES as f32);
            let round = (x * f32s::cos(phi) + y * f32s::sin(phi)) * radius;
            let along = end + (1.0 - 2.0 * end) * f64::from(i) / f64::from(pieces);
            a + axis.as_dvec3() * (length * along) + round.as_dvec3()
        };
        self.rod(a, first, color);
        self.rod(first, at(0), color);
        for i in 0..pieces {
            self.rod(at(i), at(i + 1), color);
        }
        self.rod(at(pieces), last, color);
        self.rod(last, b, color);
    }

    /// Between the ends of a slider, or a tick where it has none.
    fn rail(&mut self, j: &JointRef<'_>, axis: &AxisDesc, color: [f32; 3]) {
        let frame = j.frame_a();
        let x = frame.q.rotate(Vec3::X).as_dvec3();
        let reach = self.r * 20.0;
        let [lo, hi] = axis.limit.map_or([-reach, reach], |l| [l.min, l.max]).map(f64::from);
        self.rod(frame.p + x * lo, frame.p + x * hi, color);
        self.ball(j.frame_b().p, 2.5, DARK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use jounce::{BodyDesc, JointDesc, ShapeDesc, SpringDesc, WorldDesc};

    fn drawn(w: &World, id: JointId) -> Extras {
        let mut extras = Extras::default();
        add_joint(w, id, 0.02, None, &mut extras);
        extras
    }

    #[test]
    fn joints_become_rods_from_point_to_point() {
        let mut w = World::new(WorldDesc::default()).expect("defaults");
        let post = w.add_body(BodyDesc::fixed()).expect("post");
        let ball = BodyDesc::dynamic().at([2.0, 0.0, 0.0]).shape(ShapeDesc::sphere(0.1));
        let ball = w.add_body(ball).expect("ball");
        let (a, b) = (DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0));
        let rod = w.add_joint(JointDesc::rod(post, ball, a, b)).expect("rod");
        let one = drawn(&w, rod);
        assert_eq!((one.rods.len(), one.rods[0].a, one.rods[0].b), (1, a, b));
        // A slack rope hangs, from end to end in one line.
        let rope = w.add_joint(JointDesc::rope(post, ball, a, b, 2.5)).expect("rope");
        let hung = drawn(&w, rope).rods;
        assert_eq!((hung[0].a, hung[hung.len() - 1].b), (a, b));
        assert!(hung.windows(2).all(|p| p[0].b == p[1].a));
        let deepest = hung.iter().map(|r| r.b.y).fold(0.0, |m: f64, y| if y < m { y } else { m });
        // √(3 · 2 · 0.5 / 8).
        assert!((deepest + 0.612).abs() < 0.01, "{deepest}");
        let spring = JointDesc::spring(post, ball, a, b, SpringDesc::newton(10.0, 0.0));
        let spring = w.add_joint(spring).expect("spring");
        let coil = drawn(&w, spring).rods;
        assert_eq!((coil[0].a, coil[coil.len() - 1].b), (a, b));
        assert!(coil.windows(2).all(|p| p[0].b == p[1].a));
        // What is out does not show.
        w.set_joint_enabled(rod, false).expect("out");
        assert!(drawn(&w, rod).rods.is_empty());
    }
}
