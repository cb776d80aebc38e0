//! Where the picture is taken from.

use crate::error::{RenderError, Result};
use jounce::math::scalar::{f32s, f64s};
use jounce::math::{DVec3, Vec3};

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the eye is, world metres.
    pub position: DVec3,
    /// What it looks at, world metres.
    pub target: DVec3,
    /// Which way is up.
    pub up: Vec3,
    /// Vertical field of view, degrees.
    pub fov_deg: f32,
}

impl Camera {
    /// A camera with y up and a field of view of 40°.
    pub fn new(position: impl Into<DVec3>, target: impl Into<DVec3>) -> Self {
        Self { position: position.into(), target: target.into(), up: Vec3::Y, fov_deg: 40.0 }
    }

    /// Refuses numbers that no camera can have.
    ///
    /// # Errors
    /// Names the field, its value and what was expected.
    pub fn check(&self) -> Result<()> {
        let invalid = |field, got: String, expected| Err(RenderError::Invalid { field, got, expected });
        if !(self.position.is_finite() && self.target.is_finite()) {
            return invalid("camera", format!("{self:?}"), "finite positions");
        }
        if (self.target - self.position).try_normalize().is_none() {
            return invalid("camera.target", format!("{:?}", self.target), "a point apart from the position");
        }
        if self.up.try_normalize().is_none() {
            return invalid("camera.up", format!("{:?}", self.up), "a direction");
        }
        if !(self.fov_deg >= 1.0 && self.fov_deg <= 150.0) {
            return invalid("camera.fov_deg", self.fov_deg.to_string(), "1 to 150 degrees");
        }
        Ok(())
    }

    /// A camera that sees all the points from the front, a little from the side and above, at the given ratio
    /// of width to height. Without a finite point it looks at the origin.
    pub fn framing(points: &[DVec3], aspect: f32) -> Self {
        let camera = Self::new(DVec3::ZERO, DVec3::ZERO);
        let back = DVec3::new(0.42, 0.30, 1.0).normalize_or(DVec3::Z);
        let right = DVec3::Y.cross(back).normalize_or(DVec3::X);
        let up = back.cross(right);
        let first = points.iter().copied().find(|p| p.is_finite()).unwrap_or(DVec3::ZERO);
        // In the frame of the eye, from the first point, so that far places lose no digits.
        let seen = |p: &DVec3| {
            let d = *p - first;
            DVec3::new(d.dot(right), d.dot(up), d.dot(back))
        };
        let finite = || points.iter().filter(|p| p.is_finite()).map(seen);
        let (mut lo, mut hi) = (DVec3::splat(-0.2), DVec3::splat(0.2));
        for p in finite() {
            (lo, hi) = (lo.min(p), hi.max(p));
        }
        let middle = (lo + hi) * 0.5;
        let half_v = f64::from(f32s::tan(camera.fov_deg.to_radians() * 0.5)) * 0.88;
        let half_h = half_v * f64::from(aspect);
        // The eye stands where the point that needs most distance still fits.
        let mut distance = 1.0;
        for p in finite() {
            let d = p - middle;
            let need = d.z + f64s::max(d.x.abs() / half_h, d.y.abs() / half_v);
            distance = f64s::max(distance, need);
        }
        let target = first + right * middle.x + up * middle.y + back * middle.z;
        Self { position: target + back * distance, target, ..camera }
    }

    pub(crate) fn view(&self, width: u32, height: u32) -> View {
        let forward = (self.target - self.position).normalize_or(-DVec3::Z).as_vec3();
        let up = self.up.normalize_or(Vec3::Y);
        let mut right = forward.cross(up);
        if right.length_squared() < 1e-12 {
            right = forward.orthonormal_basis().0;
        }
        let right = right.normalize_or(Vec3::X);
        let scale = f32s::tan(self.fov_deg.to_radians() * 0.5) * 2.0 / height as f32;
        View {
            origin: self.position,
            forward,
            right: right * scale,
            down: forward.cross(right) * scale,
            center: (width as f32 * 0.5, height as f32 * 0.5),
            pixel_angle: scale,
        }
    }
}

/// A camera ready to give rays; `right` and `down` are one pixel long at distance 1.
pub(crate) struct View {
    pub origin: DVec3,
    pub forward: Vec3,
    pub right: Vec3,
    pub down: Vec3,
    pub center: (f32, f32),
    pub pixel_angle: f32,
}

impl View {
    /// Unit direction through a point of the picture, pixels from the upper left corner.
    #[inline]
    pub fn dir(&self, x: f32, y: f32) -> Vec3 {
        let d = self.forward + self.right * (x - self.center.0) + self.down * (y - self.center.1);
        d / d.length()
    }
    /// Pixel and distance along the view axis of a point; `None` behind the eye.
    pub fn project(&self, p: DVec3) -> Option<(f32, f32, f32)> {
        let v = (p - self.origin).as_vec3();
        let depth = v.dot(self.forward);
        if depth.is_nan() || depth <= 1e-4 {
            return None;
        }
        let s = 1.0 / (self.pixel_angle * self.pixel_angle * depth);
        Some((self.center.0 + v.dot(self.right) * s, self.center.1 + v.dot(self.down) * s, depth))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn framing_keeps_every_point_inside() {
        for (min, max) in [
            (DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 20.0, 1.0)),
            (DVec3::new(1e6, 0.0, 0.0), DVec3::new(1e6 + 30.0, 1.0, 30.0)),
            (DVec3::ZERO, DVec3::ZERO),
        ] {
            let pick = |bit: bool, a: f64, b: f64| if bit { a } else { b };
            let corners: Vec<DVec3> = (0..8)
                .map(|i| {
                    let x = pick(i & 1 == 0, min.x, max.x);
                    DVec3::new(x, pick(i & 2 == 0, min.y, max.y), pick(i & 4 == 0, min.z, max.z))
                })
                .collect();
            let c = Camera::framing(&corners, 16.0 / 9.0);
            c.check().expect("a usable camera");
            let v = c.view(160, 90);
            for p in corners {
                let (x, y, _) = v.project(p).expect("in front");
                assert!((0.0..160.0).contains(&x) && (0.0..90.0).contains(&y), "{x} {y}");
            }
        }
        Camera::framing(&[DVec3::splat(f64::NAN)], 1.0).check().expect("a usable camera");
    }

    #[test]
    fn project_inverts_dir() {
        let c = Camera::new([3.0, 4.0, 10.0], [0.0, 1.0, 0.0]);
        let v = c.view(320, 180);
        let d = v.dir(100.5, 33.25);
        let (x, y, _) = v.project(c.position + (d * 7.0).as_dvec3()).expect("in front");
        assert!((x - 100.5).abs() < 1e-2 && (y - 33.25).abs() < 1e-2, "{x} {y}");
    }

    #[test]
    fn bad_cameras_are_refused() {
        let good = Camera::new([0.0, 1.0, 5.0], [0.0; 3]);
        assert!(good.check().is_ok());
        assert!(Camera { target: good.position, ..good }.check().is_err());
        assert!(Camera { up: Vec3::ZERO, ..good }.check().is_err());
        assert!(Camera { fov_deg: f32::NAN, ..good }.check().is_err());
        assert!(Camera { position: DVec3::splat(f64::NAN), ..good }.check().is_err());
    }
}
