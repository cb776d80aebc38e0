//! Still water as the eye sees it from outside: its surface as a thin veil, and what lies below dimmed by its depth along
//! the ray.
//!
//! Light behind a way ℓ through water comes with (1 − s) e^{−ℓ/d}, the rest is the water's own colour; s: share of the
//! surface, d: the depth of sight, a part of the camera's distance from its target so that a tank and a sea both show
//! what floats in them. From within, water is clear.

use crate::camera::View;
use jounce::math::scalar::{f32s, f64s};
use jounce::math::{DVec3, Vec3};

/// Water below a plane, everywhere or within a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water {
    /// A point of the surface.
    pub surface: DVec3,
    /// Unit normal out of the water.
    pub normal: Vec3,
    /// Centre and half extents of the box that it fills; all below the plane where there is none.
    pub within: Option<(DVec3, DVec3)>,
}

/// Share of the light that the surface takes.
const VEIL: f32 = 0.4;
/// Depth of sight as a part of the camera's distance from its target.
const SIGHT: f32 = 0.25;
/// Linear light of deep water.
const COLOR: Vec3 = Vec3::new(0.05, 0.23, 0.36);

/// The waters of a picture, seen from its eye.
pub(crate) struct Waters {
    seen: Vec<Water>,
    eye: DVec3,
    sight: f32,
}

impl Waters {
    pub fn new(all: &[Water], view: &View, focus: f32) -> Self {
        let eye = view.origin;
        let seen = all.iter().filter(|w| !w.holds(eye)).copied().collect();
        Self { seen, eye, sight: f32s::max(SIGHT * focus, 1e-3) }
    }

    /// Light along a ray that ends `t` from the eye, where it comes with `behind`.
    pub fn over(&self, behind: Vec3, dir: Vec3, t: f32) -> Vec3 {
        let mut light = behind;
        for w in &self.seen {
            let Some((from, to)) = w.part(self.eye, dir, f64::from(t)) else { continue };
            let way = f32s::min((to - from) as f32 / self.sight, 50.0);
            let through = (1.0 - VEIL) * f32s::exp(-way);
            light = light * through + COLOR * (1.0 - through);
        }
        light
    }
}

impl Water {
    fn holds(&self, p: DVec3) -> bool {
        let below = (p - self.surface).dot(self.normal.as_dvec3()) < 0.0;
        let inside = self.within.is_none_or(|(center, half)| {
            let d = (p - center).abs();
            d.x <= half.x && d.y <= half.y && d.z <= half.z
        });
        below && inside
    }

    /// The part of a ray of length `t` that lies in the water.
    fn part(&self, eye: DVec3, dir: Vec3, t: f64) -> Option<(f64, f64)> {
        let dir = dir.as_dvec3();
        let mut part = (0.0, t);
        // Each side as a half-space n·(x − p) ≤ 0.
        let mut cut = |n: DVec3, p: DVec3| {
            let (height, rate) = (n.dot(eye - p), n.dot(dir));
            if rate == 0.0 {
                if height > 0.0 {
                    part.1 = -1.0;
                }
            } else if rate < 0.0 {
                part.0 = f64s::max(part.0, -height / rate);
            } else {
                part.1 = f64s::min(part.1, -height / rate);
            }
        };
        cut(self.normal.as_dvec3(), self.surface);
        if let Some((center, half)) = self.within {
            for n in [DVec3::X, DVec3::Y, DVec3::Z] {
                let reach = n * half.dot(n);
                cut(n, center + reach);
                cut(-n, center - reach);
            }
        }
        (part.0 < part.1).then_some(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;

    #[test]
    fn rays_know_their_way_through_water() {
        let sea = Water { surface: DVec3::ZERO, normal: Vec3::Y, within: None };
        let eye = DVec3::new(0.0, 3.0, 4.0);
        let down = Vec3::new(0.0, -0.6, -0.8);
        assert!(sea.part(eye, down, 15.0).is_some_and(|(a, b)| (a - 5.0).abs() < 1e-6 && b == 15.0));
        assert!(sea.part(eye, down, 4.0).is_none() && sea.part(eye, Vec3::Z, 50.0).is_none());
        let tank = Water { within: Some((DVec3::new(0.0, -1.0, 0.0), DVec3::new(2.0, 1.0, 2.0))), ..sea };
        let (a, b) = tank.part(eye, down, 15.0).expect("through it");
        assert!((a - 5.0).abs() < 1e-6 && (b - 7.5).abs() < 1e-6, "{a} {b}");
        assert!(tank.holds(DVec3::Y * -0.5) && !tank.holds(DVec3::Y * 0.5) && !tank.holds(DVec3::X * 3.0));
        // Deeper is darker, and above the water nothing changes.
        let view = Camera::new(eye, DVec3::ZERO).view(32, 32);
        let waters = Waters::new(&[sea], &view, 5.0);
        let look = |t: f32| waters.over(Vec3::ONE, down, t).x;
        assert!(look(4.9) == 1.0 && look(5.1) < 0.85 && look(7.0) < look(5.1) && look(1e6) < 0.06);
        let below = Camera::new(-eye, DVec3::ZERO).view(32, 32);
        assert!(Waters::new(&[sea], &below, 5.0).seen.is_empty(), "clear from within");
    }
}
