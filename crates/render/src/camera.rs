//! Where the picture is taken from.

use crate::error::{RenderError, Result};
use jounce::math::scalar::f32s;
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

    /// A camera that sees the whole box from the front, a little from the side and above, at the given
    /// ratio of width to height. An empty or broken box gives a view of the origin.
    pub fn framing(min: DVec3, max: DVec3, aspect: f32) -> Self {
        let ok = min.is_finite() && max.is_finite() && (max - min).min_component() >= 0.0;
        let (min, max) = if ok { (min, max) } else { (DVec3::splat(-2.0), DVec3::splat(2.0)) };
        let center = (min + max) * 0.5;
        let mut camera = Self::new(center, center);
        let back = DVec3::new(0.42, 0.30, 1.0).normalize_or(DVec3::Z);
        let right = DVec3::Y.cross(back).normalize_or(DVec3::X);
        let up = back.cross(right);
        let half_v = f64::from(f32s::tan(camera.fov_deg.to_radians() * 0.5)) * 0.86;
        let half_h = half_v * f64::from(aspect);
        // The eye stands where the corner that needs most distance still fits.
        let mut distance = 0.5;
        for i in 0..8 {
            let pick = |bit, a: f64, b: f64| if i & bit == 0 { a } else { b };
            let corner =
                DVec3::new(pick(1, min.x, max.x), pick(2, min.y, max.y), pick(4, min.z, max.z)) - center;
            let need =
                corner.dot(back) + (corner.dot(right).abs() / half_h).max(corner.dot(up).abs() / half_v);
            if need > distance {
                distance = need;
            }
        }
        camera.position = center + back * distance;
        camera
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
    fn framing_keeps_every_corner_inside() {
        for (min, max) in [
            (DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 20.0, 1.0)),
            (DVec3::new(1e6, 0.0, 0.0), DVec3::new(1e6 + 30.0, 1.0, 30.0)),
        ] {
            let c = Camera::framing(min, max, 16.0 / 9.0);
            c.check().expect("a usable camera");
            let v = c.view(160, 90);
            for i in 0..8 {
                let pick = |b, a: f64, c: f64| if i & b == 0 { a } else { c };
                let p = DVec3::new(pick(1, min.x, max.x), pick(2, min.y, max.y), pick(4, min.z, max.z));
                let (x, y, _) = v.project(p).expect("in front");
                assert!((0.0..160.0).contains(&x) && (0.0..90.0).contains(&y), "{x} {y}");
            }
        }
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
