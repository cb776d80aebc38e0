//! Rays and solid extras, in the frame of the eye.

use jounce::geometry::Aabb;
use jounce::math::Vec3;
use jounce::math::scalar::f32s;

/// An opaque extra.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solid {
    pub form: Form,
    /// Linear.
    pub color: Vec3,
    /// Too thin for the eye's rays: drawn as a layer; still casts its shadow.
    pub thin: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Form {
    Ball { center: Vec3, radius: f32 },
    Rod { a: Vec3, b: Vec3, radius: f32 },
    Face { a: Vec3, b: Vec3, c: Vec3, normals: [Vec3; 3] },
}

impl Solid {
    pub fn aabb(&self) -> Aabb {
        match self.form {
            Form::Ball { center, radius } => Aabb::from_center(center, Vec3::splat(radius)),
            Form::Rod { a, b, radius } => Aabb::from_points([a, b]).expanded(radius),
            Form::Face { a, b, c, .. } => Aabb::from_points([a, b, c]),
        }
    }

    /// Numbers that tell solids apart: items are sorted by them, so that the order of the lists cannot be seen.
    pub fn key(&self) -> [f32; 23] {
        let (kind, radius, [a, b, c], [na, nb, nc]) = match self.form {
            Form::Ball { center, radius } => (0.0, radius, [center; 3], [Vec3::ZERO; 3]),
            Form::Rod { a, b, radius } => (1.0, radius, [a, b, a], [Vec3::ZERO; 3]),
            Form::Face { a, b, c, normals } => (2.0, 0.0, [a, b, c], normals),
        };
        let k = self.color;
        [
            a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, radius, kind, k.x, k.y, k.z, na.x, na.y, na.z, nb.x,
            nb.y, nb.z, nc.x, nc.y, nc.z,
        ]
    }

    /// Distance and normal of the first point on the ray `from` + t · `dir`, 0 < t ≤ `max_t`.
    pub fn hit(&self, from: Vec3, dir: Vec3, max_t: f32) -> Option<(f32, Vec3)> {
        let (t, normal) = match self.form {
            Form::Ball { center, radius } => hit_ball(center - from, radius, dir)?,
            Form::Rod { a, b, radius } => hit_rod(a - from, b - from, radius, dir)?,
            Form::Face { a, b, c, normals } => hit_face(a - from, b - from, c - from, &normals, dir)?,
        };
        (t > 0.0 && t <= max_t).then_some((t, normal))
    }
}

/// The ball around `c`, from the origin: by the point of the ray nearest to the centre, which keeps digits far away.
fn hit_ball(c: Vec3, radius: f32, dir: Vec3) -> Option<(f32, Vec3)> {
    let middle = c.dot(dir);
    let q = dir * middle - c;
    let half2 = radius * radius - q.length_squared();
    if half2 < 0.0 {
        return None;
    }
    let half = half2.sqrt();
    Some((middle - half, (q - dir * half) / radius))
}

/// The capsule around the segment `a` `b`, from the origin.
///
/// Cylinder: |p − a − ((p − a)·u) u| = r for p = t·dir with the unit axis u, a quadratic in t; beyond the ends the
/// balls around them.
fn hit_rod(a: Vec3, b: Vec3, radius: f32, dir: Vec3) -> Option<(f32, Vec3)> {
    let Some((axis, length)) = (b - a).try_normalize() else { return hit_ball(a, radius, dir) };
    // From a point just before the rod, so that far ones keep their digits.
    let skip = f32s::max((a + b).dot(dir) * 0.5 - length * 0.5 - radius * 2.0, 0.0);
    let from_a = dir * skip - a;
    let (dn, fn_) = (dir.dot(axis), from_a.dot(axis));
    let (dp, fp) = (dir - axis * dn, from_a - axis * fn_);
    let (aa, bb, cc) = (dp.length_squared(), dp.dot(fp), fp.length_squared() - radius * radius);
    if aa > 1e-9 {
        let disc = bb * bb - aa * cc;
        if disc < 0.0 {
            return None;
        }
        let t = (-bb - disc.sqrt()) / aa;
        let along = fn_ + dn * t;
        if along >= 0.0 && along <= length {
            return Some((t + skip, (fp + dp * t) / radius));
        }
        return hit_ball(if along < 0.0 { a } else { b }, radius, dir);
    }
    hit_ball(if dn > 0.0 { a } else { b }, radius, dir)
}

/// The triangle from the origin (Möller & Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection"), with the
/// normal on the side that the ray comes from.
fn hit_face(a: Vec3, b: Vec3, c: Vec3, normals: &[Vec3; 3], dir: Vec3) -> Option<(f32, Vec3)> {
    // Neighbours overlap by this part of their edges, so that no ray slips between them.
    const SLACK: f32 = 1e-5;
    let (e1, e2) = (b - a, c - a);
    let p = dir.cross(e2);
    let det = e1.dot(p);
    if det == 0.0 {
        return None;
    }
    let inv = 1.0 / det;
    let u = -a.dot(p) * inv;
    let q = e1.cross(a);
    let v = dir.dot(q) * inv;
    if !(u >= -SLACK && v >= -SLACK && u + v <= 1.0 + SLACK) {
        return None;
    }
    let t = e2.dot(q) * inv;
    let flat = e1.cross(e2).try_normalize()?.0;
    let flat = if flat.dot(dir) > 0.0 { -flat } else { flat };
    let bent = normals[0] * (1.0 - u - v) + normals[1] * u + normals[2] * v;
    let bent = bent.normalize_or(flat);
    let bent = if bent.dot(flat) < 0.0 { -bent } else { bent };
    // Near an outline the bent normal may look away: it is turned until it just does not.
    let away = bent.dot(dir);
    let normal = if away > -0.02 { (bent - dir * (away + 0.02)).normalize_or(flat) } else { bent };
    Some((t, normal))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solid(form: Form) -> Solid {
        Solid { form, color: Vec3::ONE, thin: false }
    }

    #[test]
    fn rays_meet_where_they_should() {
        let ball = solid(Form::Ball { center: Vec3::new(0.0, 0.0, -5.0), radius: 1.0 });
        let (t, n) = ball.hit(Vec3::ZERO, -Vec3::Z, 100.0).expect("hit");
        assert!((t - 4.0).abs() < 1e-6 && (n - Vec3::Z).length() < 1e-6);
        assert!(
            ball.hit(Vec3::ZERO, -Vec3::Z, 3.9).is_none() && ball.hit(Vec3::ZERO, Vec3::Z, 100.0).is_none()
        );

        let rod =
            solid(Form::Rod { a: Vec3::new(-1.0, 0.0, -5.0), b: Vec3::new(1.0, 0.0, -5.0), radius: 0.25 });
        for (x, far) in [(0.0, 4.75), (0.9, 4.75), (1.2, 4.85), (-1.2, 4.85)] {
            let (t, n) = rod.hit(Vec3::new(x, 0.0, 0.0), -Vec3::Z, 100.0).expect("hit");
            assert!((t - far).abs() < 1e-4 && n.dot(-Vec3::Z) < 0.0, "{x}: {t} {n:?}");
            assert!((n.length() - 1.0).abs() < 1e-4);
        }
        assert!(rod.hit(Vec3::new(1.3, 0.0, 0.0), -Vec3::Z, 100.0).is_none());
        // Along the axis, from outside: the cap.
        let (t, _) = rod.hit(Vec3::new(-4.0, 0.0, -5.0), Vec3::X, 100.0).expect("hit");
        assert!((t - 2.75).abs() < 1e-5, "{t}");

        let corners = [[-1.0, -1.0, -2.0], [1.0, -1.0, -2.0], [0.0, 1.0, -2.0]].map(Vec3::from_array);
        let [a, b, c] = corners;
        let face = solid(Form::Face { a, b, c, normals: [Vec3::Z; 3] });
        for (from, dir) in [(Vec3::ZERO, -Vec3::Z), (Vec3::new(0.0, 0.0, -4.0), Vec3::Z)] {
            let (t, n) = face.hit(from, dir, 100.0).expect("both sides");
            assert!((t - 2.0).abs() < 1e-6 && n.dot(dir) < -0.99, "{t} {n:?}");
        }
        assert!(face.hit(Vec3::new(1.0, 1.0, 0.0), -Vec3::Z, 100.0).is_none());
    }
}
