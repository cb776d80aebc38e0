//! Wheels, boards and faces: what vehicles and characters have beside their bodies' shapes.

use crate::extras::{Ball, Extras, Face, Rod};
use jounce::math::scalar::f32s;
use jounce::math::{DVec3, Vec3, WorldPose};
use jounce::{CharacterId, QueryFilter, Ray, VehicleDesc, VehicleId, World};

const RUBBER: [f32; 3] = [0.13, 0.13, 0.15];
const RIM: [f32; 3] = [0.72, 0.74, 0.77];
const LINK: [f32; 3] = [0.24, 0.25, 0.24];
const BASE: [f32; 3] = [0.16, 0.42, 0.66];
const EYE: [f32; 3] = [0.08, 0.09, 0.11];
/// Sides of a wheel.
const SIDES: u32 = 28;
/// Spokes, so that spin shows.
const SPOKES: u32 = 5;

/// Adds what is under a vehicle as it stands: wheels, steered, sprung and turned by their spin, tracks about their wheels, boards
/// with their edges. The chassis is a body and shows by itself.
pub fn add_vehicle(world: &World, id: VehicleId, extras: &mut Extras) {
    let Ok(v) = world.vehicle(id) else { return };
    let d = v.desc();
    for (i, w) in d.wheels.iter().enumerate() {
        if let Ok(pose) = v.wheel_pose(i) {
            wheel(pose, w.radius, w.width, extras);
        }
    }
    for t in &d.tracks {
        let poses = t.wheels.iter().filter_map(|&i| Some((v.wheel_pose(i).ok()?, d.wheels.get(i)?)));
        let rims: Vec<_> = poses.map(|(p, w)| (p, w.radius, w.width)).collect();
        let Ok(chassis) = world.body(v.chassis()) else { continue };
        track(d, chassis.pose(), &rims, extras);
    }
    let (Some(b), Ok(chassis)) = (&d.board, world.body(v.chassis())) else { return };
    // Snow and legs are one spring: it shows in the legs, and the board lies on the snow.
    let (pose, up) = (chassis.pose(), chassis.rotation().rotate(d.up));
    let left = d.up.cross(d.forward);
    let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let filter = QueryFilter::default().layers(d.ground_layers).excluding(v.chassis());
    let lift = v.wheels().zip(corners).filter(|(t, _)| t.load > 0.0).filter_map(|(_, (x, y))| {
        let corner = b.position + d.forward * (0.5 * x * b.length) + left * (0.5 * y * b.width);
        let above = pose.transform_point(corner) + (up * b.reach).as_dvec3();
        let hit = world.cast_ray(&Ray { origin: above, dir: -up, max_t: b.reach }, &filter)?;
        Some(b.reach - hit.t)
    });
    let lift = lift.fold(0.0, f32s::max);
    board(d, pose, b.position + d.up * lift, b.length, b.width, b.sidecut, extras);
}

/// Adds which way a character looks: eyes before its head. Its capsule is a body and shows by itself.
pub fn add_character(world: &World, id: CharacterId, extras: &mut Extras) {
    let Ok(c) = world.character(id) else { return };
    let (Ok(body), d) = (world.body(c.body()), c.desc()) else { return };
    let height = if c.is_crouched() { d.crouch_height } else { d.mover.height };
    let r = d.mover.radius;
    for side in [-1.0, 1.0] {
        // On the upper cap, 20° to the side and 10° up.
        let (aside, ahead) = (0.34 * r * side, 0.92 * r);
        let eye = Vec3::new(aside, height - r + 0.17 * r, ahead);
        extras.balls.push(Ball::new(body.pose().transform_point(eye), 0.17 * r, EYE));
    }
}

/// The ring of a wheel at a distance along its axle; x is the axle.
fn ring(pose: &WorldPose, x: f32, r: f32, i: u32) -> (DVec3, Vec3) {
    let a = i as f32 * (core::f32::consts::TAU / SIDES as f32);
    let out = Vec3::new(0.0, f32s::cos(a), f32s::sin(a));
    (pose.transform_point(Vec3::new(x, 0.0, 0.0) + out * r), pose.q.rotate(out))
}

fn quad(a: DVec3, b: DVec3, c: DVec3, d: DVec3, color: [f32; 3], extras: &mut Extras) {
    extras.faces.push(Face::new(a, b, c, color));
    extras.faces.push(Face::new(a, c, d, color));
}

fn wheel(pose: WorldPose, radius: f32, width: f32, extras: &mut Extras) {
    let half = 0.5 * width;
    let rim = 0.66 * radius;
    // The tread ends where its shoulders begin.
    let shoulder = 0.78 * half;
    for i in 0..SIDES {
        let (a, na) = ring(&pose, -shoulder, radius, i);
        let (b, nb) = ring(&pose, -shoulder, radius, i + 1);
        let (c, _) = ring(&pose, shoulder, radius, i + 1);
        let (d, _) = ring(&pose, shoulder, radius, i);
        extras.faces.push(Face::new(a, b, c, RUBBER).normals([na, nb, nb]));
        extras.faces.push(Face::new(a, c, d, RUBBER).normals([na, nb, na]));
        for side in [-1.0, 1.0] {
            let at = |x: f32, r: f32, i: u32| ring(&pose, x * side, r, i).0;
            let high = 0.94 * radius;
            quad(
                at(shoulder, radius, i),
                at(shoulder, radius, i + 1),
                at(half, high, i + 1),
                at(half, high, i),
                RUBBER,
                extras,
            );
            quad(
                at(half, high, i),
                at(half, high, i + 1),
                at(half, rim, i + 1),
                at(half, rim, i),
                RUBBER,
                extras,
            );
            let inner = 0.7 * half;
            quad(
                at(half, rim, i),
                at(half, rim, i + 1),
                at(inner, 0.9 * rim, i + 1),
                at(inner, 0.9 * rim, i),
                RIM,
                extras,
            );
        }
    }
    let hub = pose.transform_point(Vec3::ZERO);
    let axle = pose.q.rotate(Vec3::X).as_dvec3() * f64::from(0.72 * half);
    extras.rods.push(Rod::new(hub - axle, hub + axle, 0.16 * radius, RIM));
    for k in 0..SPOKES {
        let a = k as f32 * (core::f32::consts::TAU / SPOKES as f32);
        let out = Vec3::new(0.0, f32s::cos(a), f32s::sin(a)) * (0.92 * rim);
        for side in [-0.6, 0.6] {
            let x = Vec3::new(side * half, 0.0, 0.0);
            let (from, to) = (pose.transform_point(x), pose.transform_point(x + out));
            extras.rods.push(Rod::new(from, to, 0.055 * radius, RIM));
        }
    }
}

/// Links about the wheels of a track: the hull of their circles, seen from the side.
fn track(d: &VehicleDesc, chassis: WorldPose, rims: &[(WorldPose, f32, f32)], extras: &mut Extras) {
    let left = d.up.cross(d.forward);
    let mut flat: Vec<(f32, f32)> = Vec::new();
    let (mut x, mut width) = (0.0, 0.0);
    for (p, r, w) in rims {
        let hub = chassis.inverse_transform_point(p.p);
        (x, width) = (hub.dot(left), f32s::max(width, *w));
        for i in 0..SIDES {
            let a = i as f32 * (core::f32::consts::TAU / SIDES as f32);
            let at = hub + (d.forward * f32s::cos(a) + d.up * f32s::sin(a)) * (r * 1.06);
            flat.push((at.dot(d.forward), at.dot(d.up)));
        }
    }
    let outline = hull(flat);
    let at = |p: (f32, f32), aside: f32| {
        chassis.transform_point(d.forward * p.0 + d.up * p.1 + left * (x + aside))
    };
    let half = 0.52 * width;
    for i in 0..outline.len() {
        let (p, q) = (outline[i], outline[(i + 1) % outline.len()]);
        quad(at(p, -half), at(q, -half), at(q, half), at(p, half), LINK, extras);
        // A link every 15 cm and at each corner.
        let length = ((q.0 - p.0) * (q.0 - p.0) + (q.1 - p.1) * (q.1 - p.1)).sqrt();
        let pieces = (length / 0.15).ceil().clamp(1.0, 200.0) as u32;
        for k in 0..pieces {
            let t = k as f32 / pieces as f32;
            let m = (p.0 + (q.0 - p.0) * t, p.1 + (q.1 - p.1) * t);
            extras.rods.push(Rod::new(at(m, -half), at(m, half), 0.025, LINK));
        }
    }
}

/// Convex hull in the plane, counter-clockwise (Andrew 1979).
fn hull(mut p: Vec<(f32, f32)>) -> Vec<(f32, f32)> {
    p.retain(|q| q.0.is_finite() && q.1.is_finite());
    p.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    p.dedup();
    if p.len() < 3 {
        return p;
    }
    let turn =
        |a: (f32, f32), b: (f32, f32), c: (f32, f32)| (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    let half = |points: &mut dyn Iterator<Item = (f32, f32)>| {
        let mut chain: Vec<(f32, f32)> = Vec::new();
        for q in points {
            while chain.len() >= 2 && turn(chain[chain.len() - 2], chain[chain.len() - 1], q) <= 0.0 {
                chain.pop();
            }
            chain.push(q);
        }
        chain.pop();
        chain
    };
    let mut all = half(&mut p.iter().copied());
    all.extend(half(&mut p.iter().rev().copied()));
    all
}

/// Stations along a board's edge.
const STATIONS: usize = 12;

/// A board with its side-cut, tips turned up.
fn board(
    d: &VehicleDesc,
    chassis: WorldPose,
    middle: Vec3,
    length: f32,
    waist: f32,
    sidecut: f32,
    extras: &mut Extras,
) {
    let left = d.up.cross(d.forward);
    let thick = 0.02;
    let tip = 0.16 * length;
    // Along, half width, lift.
    let mut stations: Vec<(f32, f32, f32)> = Vec::with_capacity(STATIONS + 9);
    // The side-cut is an arc: half width w/2 + z²/2R.
    let wide = |z: f32| 0.5 * waist + 0.5 * z * z / sidecut;
    let end = 0.5 * length;
    let curve = |k: usize| k as f32 / 4.0;
    for k in (1..=4).rev() {
        let t = curve(k);
        stations.push((-end - tip * t, wide(end) * f32s::max(1.0 - t * t, 0.0).sqrt(), 0.35 * tip * t * t));
    }
    for k in 0..=STATIONS {
        let z = -end + length * k as f32 / STATIONS as f32;
        stations.push((z, wide(z), 0.0));
    }
    for k in 1..=4 {
        let t = curve(k);
        stations.push((end + tip * t, wide(end) * f32s::max(1.0 - t * t, 0.0).sqrt(), 0.35 * tip * t * t));
    }
    let at = |s: (f32, f32, f32), side: f32, up: f32| {
        chassis.transform_point(middle + d.forward * s.0 + left * (s.1 * side) + d.up * (s.2 + up))
    };
    for w in stations.windows(2) {
        for up in [0.0, thick] {
            quad(at(w[0], -1.0, up), at(w[1], -1.0, up), at(w[1], 1.0, up), at(w[0], 1.0, up), BASE, extras);
        }
        for side in [-1.0, 1.0] {
            quad(
                at(w[0], side, 0.0),
                at(w[1], side, 0.0),
                at(w[1], side, thick),
                at(w[0], side, thick),
                RIM,
                extras,
            );
        }
    }
    // Boots and shins, up to where a rider's body begins.
    for z in [-0.22, 0.22] {
        let foot = middle + d.forward * (z * length / 1.2) + d.up * (thick + 0.05);
        let knee = middle + d.forward * (0.5 * z * length / 1.2) + d.up * 0.5;
        let [foot, knee] = [foot, knee].map(|p| chassis.transform_point(p));
        extras.rods.push(Rod::new(foot, knee, 0.07, EYE));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use jounce::math::Quat;
    use jounce::{BodyDesc, CharacterDesc, ShapeDesc, VehicleInput, WorldDesc, vehicles};

    fn world() -> World {
        let mut w = World::new(WorldDesc::default()).expect("defaults");
        w.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).friction(1.0))).expect("ground");
        w
    }

    #[test]
    fn wheels_turn_and_stand_on_the_ground() {
        let mut w = world();
        let car = vehicles::car().add(&mut w, [0.0; 3], Quat::IDENTITY).expect("car");
        let drawn = |w: &World| {
            let mut e = Extras::default();
            add_vehicle(w, car, &mut e);
            e
        };
        for _ in 0..120 {
            w.step().expect("step");
        }
        let still = drawn(&w);
        let lowest = |e: &Extras| e.faces.iter().flat_map(|f| [f.a.y, f.b.y, f.c.y]).fold(1e9, f64::min);
        // A tyre gives a little, and its 28 sides cut corners.
        assert!(lowest(&still).abs() < 0.03, "{}", lowest(&still));
        assert_eq!(still.rods.len(), 4 * (1 + 2 * SPOKES as usize));
        w.set_vehicle_input(car, VehicleInput::drive(1.0, 1.0)).expect("input");
        for _ in 0..30 {
            w.step().expect("step");
        }
        let spin = w.vehicle(car).expect("car").wheel(0).expect("wheel");
        let moved = drawn(&w);
        // The second spoke's end has gone round with the spin: its place against the hub.
        let arm = |e: &Extras| (e.rods[1].b - e.rods[1].a).as_vec3();
        assert!(spin.spin > 0.5 && (arm(&moved) - arm(&still)).length() > 0.02, "{}", spin.spin);
    }

    #[test]
    fn tracks_go_about_their_wheels() {
        let mut w = world();
        let tank = vehicles::tank().add(&mut w, [0.0; 3], Quat::IDENTITY).expect("tank");
        let mut e = Extras::default();
        add_vehicle(&w, tank, &mut e);
        let ends = e.rods.iter().flat_map(|r| [r.a.z, r.b.z]).fold((1e9, -1e9), |(l, h): (f64, f64), z| {
            (if z < l { z } else { l }, if z > h { z } else { h })
        });
        // Five wheels of 0.35 m from −1.8 to 1.8 m, links 6 % beyond.
        assert!((ends.0 + 2.171).abs() < 0.01 && (ends.1 - 2.171).abs() < 0.01, "{ends:?}");
    }

    #[test]
    fn eyes_look_along_the_heading() {
        let mut w = world();
        let mut d = CharacterDesc::at([0.0; 3]);
        d.heading = core::f32::consts::FRAC_PI_2;
        let hero = w.add_character(d).expect("character");
        let mut e = Extras::default();
        add_character(&w, hero, &mut e);
        assert!(e.balls.len() == 2 && e.balls.iter().all(|b| b.center.x > 0.25 && b.center.y > 1.4), "{e:?}");
    }

    #[test]
    fn boards_have_their_side_cut() {
        let mut w = world();
        let rider = vehicles::snowboard().add(&mut w, [0.0; 3], Quat::IDENTITY).expect("rider");
        let mut e = Extras::default();
        add_vehicle(&w, rider, &mut e);
        let wide = |z: f64| {
            let near = e.faces.iter().flat_map(|f| [f.a, f.b, f.c]).filter(|p| (p.z - z).abs() < 0.01);
            near.fold(0.0, |m: f64, p| if p.x > m { p.x } else { m })
        };
        // 0.13 m at the waist, 0.6²/(2 · 8) m more at the ends of the edge.
        assert!(
            (wide(0.0) - 0.13).abs() < 1e-3 && (wide(0.6) - 0.1525).abs() < 1e-3,
            "{} {}",
            wide(0.0),
            wide(0.6)
        );
    }

    #[test]
    fn boards_lie_on_the_snow() {
        let mut w = world();
        let rider = vehicles::snowboard().add(&mut w, [0.0; 3], Quat::IDENTITY).expect("rider");
        for _ in 0..120 {
            w.step().expect("step");
        }
        let mut e = Extras::default();
        add_vehicle(&w, rider, &mut e);
        let lowest = e.faces.iter().flat_map(|f| [f.a.y, f.b.y, f.c.y]).fold(1e9, f64::min);
        // Under 80 kg it is some m g/k = 2 cm deep before it is lifted.
        let sunk = w.body(w.vehicle(rider).expect("rider").chassis()).expect("body").position().y;
        assert!(sunk < -0.015 && lowest.abs() < 1e-3, "{sunk} {lowest}");
    }

    #[test]
    fn hulls_turn_left() {
        let h = hull(vec![(0.0, 0.0), (1.0, 0.0), (0.5, 0.5), (1.0, 1.0), (0.0, 1.0), (0.5, 0.0)]);
        assert_eq!(h, [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        assert!(hull(vec![(f32::NAN, 0.0)]).is_empty());
    }
}
