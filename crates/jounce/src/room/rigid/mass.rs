//! Mass properties of a body from its shapes.
//!
//! m = Σ mᵢ, c = Σ mᵢ cᵢ / m, I = Σ Rᵢ Iᵢ Rᵢᵀ + mᵢ (|dᵢ|² 1 − dᵢ dᵢᵀ), dᵢ = cᵢ − c (parallel axes), summed in f64.

use super::desc::BodyKind;
use super::state::{Body, Mass};
use crate::room::contacts::desc::MassSpec;
use crate::room::contacts::state::ShapeRecord;
use jounce_geometry::MassProperties;
use jounce_math::{DMat3, DQuat, DVec3, Mat3, Pose, Vec3, scalar::f32s};

/// Mass properties of a shape at its pose on the body; `None` where it has no volume or no mass.
fn shape_mass(s: &ShapeRecord) -> Option<(f64, DVec3, DMat3)> {
    if s.sensor {
        return None;
    }
    // At unit density the mass is the volume, and all scales linearly.
    let unit = s.shape.mass_properties(1.0)?;
    let factor = match s.mass {
        MassSpec::Density(d) => f64::from(d),
        MassSpec::Mass(m) => f64::from(m) / f64::from(unit.mass),
    };
    let mass = f64::from(unit.mass) * factor;
    if !(mass > 0.0 && mass.is_finite()) {
        return None;
    }
    let r = s.pose.q.to_mat3().as_dmat3();
    let inertia = (r * unit.inertia.as_dmat3() * r.transpose()).scale(factor);
    Some((mass, s.pose.transform_point(unit.center).as_dvec3(), inertia))
}

/// Sum over the shapes; `None` when nothing has mass.
pub(crate) fn sum<'a>(shapes: impl Iterator<Item = &'a ShapeRecord>) -> Option<MassProperties> {
    let parts: Vec<_> = shapes.filter_map(shape_mass).collect();
    let mass: f64 = parts.iter().map(|p| p.0).sum();
    if parts.is_empty() {
        return None;
    }
    let center = parts.iter().fold(DVec3::ZERO, |c, p| c + p.1 * p.0) / mass;
    let inertia = parts.iter().fold(DMat3::ZERO, |i, (m, c, own)| {
        let d = *c - center;
        let shift = DMat3::IDENTITY.scale(d.length_squared()) - DMat3::outer(d, d);
        i + *own + shift.scale(*m)
    });
    Some(MassProperties { mass: mass as f32, center: center.as_vec3(), inertia: inertia.as_mat3() })
}

/// The solver's form. A body without mass neither falls nor is pushed.
pub(crate) fn prepare<'a>(
    body: &Body,
    shapes: impl Iterator<Item = &'a ShapeRecord> + Clone,
) -> (Mass, Vec3) {
    let props = body.mass_override.or_else(|| sum(shapes.clone()));
    let center = match (&props, body.kind) {
        (Some(p), BodyKind::Dynamic) => p.center,
        _ => Vec3::ZERO,
    };
    let mut m = Mass { principal: DQuat::IDENTITY, isotropic: true, ..Mass::default() };
    m.inner_radius = f32::MAX;
    for s in shapes.filter(|s| !s.sensor) {
        let c = s.pose.inverse_transform_point(center);
        m.inner_radius = f32s::min(m.inner_radius, s.shape.inner_radius());
        m.outer_radius = f32s::max(m.outer_radius, s.shape.outer_radius(c));
        let bounds = s.shape.aabb(&Pose::new(s.pose.p - center, s.pose.q));
        m.reach = m.reach.max(bounds.min.abs()).max(bounds.max.abs());
    }
    if m.inner_radius == f32::MAX {
        m.inner_radius = 0.0;
    }
    let (Some(p), BodyKind::Dynamic) = (props, body.kind) else {
        return (m, center);
    };
    let inertia = p.inertia.as_dmat3();
    let (moments, frame) = inertia.symmetric_eigen();
    m.mass = p.mass;
    m.inv_mass = 1.0 / p.mass;
    m.inertia = p.inertia;
    if let Some(inv) = inertia.inverse() {
        m.inv_inertia = inv.as_mat3();
    }
    let moments = level(moments);
    if moments.x == moments.y && moments.x == moments.z && moments.x > 0.0 {
        // Without rounding in it: the same for all axes, however the body is turned.
        m.inertia = Mat3::IDENTITY.scale(moments.x as f32);
        m.inv_inertia = Mat3::IDENTITY.scale((1.0 / moments.x) as f32);
    }
    m.moments = moments;
    m.inv_moments = DVec3::new(1.0 / moments.x, 1.0 / moments.y, 1.0 / moments.z);
    m.principal = DQuat::from_mat3(&frame).normalize();
    let (lo, hi) = (moments.min_component(), moments.max_component());
    m.isotropic = hi - lo <= 1e-5 * hi;
    (m, center)
}

/// Moments that differ by rounding alone are equal.
fn level(mut m: DVec3) -> DVec3 {
    let least = 1e-6 * m.max_component();
    for i in 0..3 {
        let j = (i + 1) % 3;
        if (m[i] - m[j]).abs() <= least {
            m[i] = 0.5 * (m[i] + m[j]);
            m[j] = m[i];
        }
    }
    m
}
