//! Identities of rotations, matrices and poses.

use crate::scalar::f64s;
use crate::*;

fn sample(i: u32) -> Vec3 {
    let f = |k: u32| {
        let h = (i.wrapping_mul(2_654_435_761) ^ k.wrapping_mul(40_503)).wrapping_mul(2_246_822_519);
        (h >> 8) as f32 / 16_777_216.0 * 2.0 - 1.0
    };
    Vec3::new(f(1), f(2), f(3))
}

#[test]
fn quaternion_and_matrix_rotate_alike() {
    for i in 0..200 {
        let axis = sample(i).normalize_or(Vec3::X);
        let q = Quat::from_axis_angle(axis, 0.031 * i as f32);
        let v = sample(i + 1000);
        let d = q.rotate(v) - q.to_mat3() * v;
        assert!(d.length() < 1e-6, "{i}: {d:?}");
        let back = Quat::from_mat3(&q.to_mat3());
        assert!((back.dot(q).abs() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn euler_angles_turn_about_fixed_x_then_y_then_z() {
    let h = core::f32::consts::FRAC_PI_2;
    let q = Quat::from_euler_xyz(Vec3::new(h, h, 0.0));
    // y goes to z under the x turn, then z goes to x under the y turn.
    assert!((q.rotate(Vec3::Y) - Vec3::X).length() < 1e-6);
}

#[test]
fn basis_is_right_handed_and_orthonormal() {
    for i in 0..500 {
        let n = sample(i).normalize_or(Vec3::Y);
        let (u, v) = n.orthonormal_basis();
        assert!(u.dot(n).abs() < 2e-6 && v.dot(n).abs() < 2e-6 && u.dot(v).abs() < 2e-6);
        assert!((n.cross(u) - v).length() < 4e-6, "{n:?}");
    }
    for n in [Vec3::Z, -Vec3::Z, Vec3::X, -Vec3::Y] {
        let (u, v) = n.orthonormal_basis();
        assert!((n.cross(u) - v).length() < 1e-6);
    }
}

#[test]
fn inverse_and_solve_agree() {
    for i in 0..100 {
        let m = Mat3::from_columns(sample(i), sample(i + 500), sample(i + 900)) + Mat3::IDENTITY.scale(2.0);
        let b = sample(i + 77);
        let x = m.solve(b);
        assert!((m * x - b).length() < 1e-5);
        let inv = m.inverse().expect("well conditioned");
        assert!((inv * b - x).length() < 1e-5);
    }
    assert!(Mat3::ZERO.inverse().is_none());
}

#[test]
fn symmetric_eigen_rebuilds_the_matrix() {
    for i in 0..100 {
        let (a, b) = (sample(i).as_dvec3(), sample(i + 31).as_dvec3());
        let m = DMat3::outer(a, a)
            + DMat3::outer(b, b).scale(3.0)
            + DMat3::from_diagonal(DVec3::new(0.1, 0.2, 0.3));
        let (d, r) = m.symmetric_eigen();
        let back = r * DMat3::from_diagonal(d) * r.transpose();
        let e = back - m;
        assert!(e.cx.length() + e.cy.length() + e.cz.length() < 1e-12);
        assert!((r.determinant() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn poses_undo_themselves_far_away() {
    let far = WorldPose::new(DVec3::new(1e7, -2e7, 3e6), Quat::from_axis_angle(Vec3::Z, 1.0));
    let local = Vec3::new(0.25, -1.5, 3.0);
    let back = far.inverse_transform_point(far.transform_point(local));
    assert!((back - local).length() < 1e-6);
}

#[test]
fn normalising_works_at_extreme_scales() {
    for s in [1e-30f32, 1e-20, 1.0, 1e20, 1e30] {
        let (n, l) = (Vec3::new(3.0, 0.0, 4.0) * s).try_normalize().expect("has a direction");
        assert!((n - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-6);
        assert!((l / (5.0 * s) - 1.0).abs() < 1e-6);
    }
    assert!(Vec3::ZERO.try_normalize().is_none());
    assert!(Vec3::new(f32::NAN, 0.0, 0.0).try_normalize().is_none());
    assert!(Vec3::new(f32::INFINITY, 0.0, 0.0).try_normalize().is_none());
}

#[test]
fn transcendentals_are_the_pinned_ones() {
    // Golden bits of libm 0.2.16: a changed implementation changes every recording.
    assert_eq!(f64s::sin(1.0).to_bits(), 0x3fea_ed54_8f09_0cee);
    assert_eq!(f64s::cos(1.0).to_bits(), 0x3fe1_4a28_0fb5_068c);
    assert_eq!(f64s::exp(1.0).to_bits(), 0x4005_bf0a_8b14_576a);
}
