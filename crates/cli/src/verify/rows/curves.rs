//! A bead on a curve without friction: the straight line, the cycloid that is fastest, and the one that takes the same
//! time from everywhere.
//!
//! The bead is a ball of radius r whose centre follows the curve: the floor is the curve moved by r along its normal, as a strip
//! of triangles.

use super::{G, crossing, substep};
use crate::verify::{Law, Row, Rows};
use jounce::geometry::{TriMesh, TriMeshOptions};
use jounce::prelude::*;
use jounce::{Result, Settings};
use std::f64::consts::PI;
use std::sync::Arc;

pub(crate) const LAWS: &[Law] = &[
    Law { topic: "curves", name: "straight line", run: straight },
    Law { topic: "curves", name: "brachistochrone", run: brachistochrone },
    Law { topic: "curves", name: "tautochrone", run: tautochrone },
];

const RADIUS: f64 = 0.02;
const RATE_HZ: f64 = 480.0;

/// Point of a cycloid of rolling radius `r` that hangs from the origin: x = r (φ − sin φ), y = −r (1 − cos φ); and its unit
/// normal (cos φ/2, sin φ/2), from the tangent (sin φ/2, −cos φ/2).
fn cycloid(r: f64, phi: f64) -> (DVec3, DVec3) {
    let (s, c) = (0.5 * phi).sin_cos();
    (DVec3::new(r * (phi - phi.sin()), -r * (1.0 - phi.cos()), 0.0), DVec3::new(c, s, 0.0))
}

/// Time of a bead from rest at `curve(0)` until its x passes `end`.
fn descent(curve: impl Fn(f64) -> (DVec3, DVec3), end: f64) -> Result<(f64, f64)> {
    let gravity = Vec3::new(0.0, -G as f32, 0.0);
    let settings = Settings { sleep: false, ..Settings::default() };
    let mut w = World::new(WorldDesc { gravity, rate_hz: RATE_HZ, settings, ..WorldDesc::default() })?;
    let pieces = 1000_u32;
    let mut corners = Vec::new();
    for i in 0..=pieces {
        // The strip begins before the curve, straight on backwards, and ends behind it.
        let u = f64::from(i) / f64::from(pieces) * 1.04 - 0.02;
        let (mut p, n) = curve(u.max(0.0));
        p += DVec3::new(n.y, -n.x, 0.0) * u.min(0.0);
        let floor = (p - n * RADIUS).as_vec3();
        corners.extend([floor - Vec3::Z, floor + Vec3::Z]);
    }
    let triangles: Vec<[u32; 3]> = (0..pieces)
        .flat_map(|i| [[2 * i, 2 * i + 1, 2 * i + 2], [2 * i + 1, 2 * i + 3, 2 * i + 2]])
        .collect();
    let mesh = TriMesh::new(&corners, &triangles, TriMeshOptions::default())?;
    w.add_body(BodyDesc::fixed().shape(ShapeDesc::mesh(Arc::new(mesh)).friction(0.0)))?;
    let ball = ShapeDesc::sphere(RADIUS as f32).mass(1.0).friction(0.0);
    let id = w.add_body(BodyDesc::dynamic().at(curve(0.0).0).shape(ball))?;
    let t = crossing(&mut w, 5.0, |w| Ok(end - w.body(id)?.position().x))?;
    Ok((t, substep(&w)))
}

/// First order in the substep: along a path the bead is half a substep ahead (½ h), and at each kink and bend the contact
/// answers a substep late (h); 1 % at most.
fn tolerance(h: f64, t: f64) -> f64 {
    (1.5 * h + 0.005 * t).min(0.01 * t)
}

fn straight() -> Rows {
    let mut rows = Vec::new();
    for (x, expected) in [(1.0, 0.638_551), (2.0, 1.009_638)] {
        let length = f64::hypot(x, 1.0);
        let normal = DVec3::new(1.0, x, 0.0) / length;
        let (t, h) = descent(|u| (DVec3::new(x, -1.0, 0.0) * u, normal), x)?;
        let name = format!("straight line to ({x}, 1)");
        rows.push(Row::new(&name, expected, t, tolerance(h, expected), "s", "√(2 (x² + y²)/(g y))"));
    }
    Ok(rows)
}

fn brachistochrone() -> Rows {
    let mut rows = Vec::new();
    for (x, expected) in [(1.0, 0.582_895), (2.0, 0.805_564)] {
        // (φ − sin φ)/(1 − cos φ) = x/y by bisection; it grows with φ.
        let (mut lo, mut hi) = (0.1_f64, 2.0 * PI - 0.1);
        for _ in 0..80 {
            let mid = 0.5 * (lo + hi);
            if (mid - mid.sin()) / (1.0 - mid.cos()) < x { lo = mid } else { hi = mid }
        }
        let r = 1.0 / (1.0 - lo.cos());
        let (t, h) = descent(|u| cycloid(r, lo * u), x)?;
        let name = format!("cycloid to ({x}, 1)");
        rows.push(Row::new(&name, expected, t, tolerance(h, expected), "s", "φ √(r/g)"));
    }
    Ok(rows)
}

fn tautochrone() -> Rows {
    let mut rows = Vec::new();
    for start in [0.5, 1.5, 2.5] {
        let (t, h) = descent(|u| cycloid(1.0, start + (PI - start) * u), PI)?;
        let name = format!("cycloid r = 1 from φ = {start} to the bottom");
        rows.push(Row::new(&name, 1.003_033, t, tolerance(h, 1.003_033), "s", "π √(r/g) from everywhere"));
    }
    Ok(rows)
}
