//! Random pairs of all kinds of shapes, sizes from millimetres to a hundred kilometres: every answer is finite and
//! well formed.

mod common;
use common::Rng;
use jounce_geometry::{
    Compound, HeightField, Hull, Manifold, ManifoldSet, PairCache, Shape, Sweep, TimeOfImpact, TriMesh,
    TriMeshOptions, cast_shape, collide, distance, time_of_impact,
};
use jounce_math::{Pose, Quat, Vec3, scalar::f32s};
use std::sync::Arc;

const SIZES: [f32; 6] = [1e-3, 1e-2, 1.0, 1.0, 100.0, 1e5];

fn shape(rng: &mut Rng, kind: usize, s: f32) -> Shape {
    let mut r = || rng.range(0.1, 1.0) * s;
    match kind {
        0 => Shape::Sphere { radius: r() },
        1 => Shape::Capsule { half_height: r(), radius: r() },
        2 => Shape::Box { half: Vec3::new(r(), r(), r()) },
        3 => Shape::Cylinder { half_height: r(), radius: r() },
        4 => Shape::Cone { half_height: r(), radius: r() },
        5 => loop {
            let points: Vec<Vec3> = (0..12).map(|_| rng.direction() * s).collect();
            if let Ok(h) = Hull::new(&points) {
                break Shape::Hull(Arc::new(h));
            }
        },
        6 => Shape::HalfSpace { normal: rng.direction(), offset: rng.range(-1.0, 1.0) * s },
        7 => {
            let heights = (0..81).map(|_| rng.range(-0.3, 0.3) * s).collect();
            Shape::HeightField(Arc::new(HeightField::new(9, 9, [0.7 * s, 0.6 * s], heights).unwrap()))
        }
        8 => {
            let vertices: Vec<Vec3> = (0..12).map(|_| rng.direction() * s).collect();
            let triangles: Vec<[u32; 3]> =
                (0..20).map(|_| [0; 3].map(|_: u32| rng.next() as u32 % 12)).collect();
            let options = TriMeshOptions { double_sided: rng.unit() < 0.5, ..TriMeshOptions::default() };
            Shape::Mesh(Arc::new(TriMesh::new(&vertices, &triangles, options).unwrap()))
        }
        _ => {
            let child = |i| (Pose::new(rng.vec(s), rng.rotation()), shape(rng, i, s * 0.5));
            Shape::Compound(Arc::new(Compound::new((1..5).map(child).collect()).unwrap()))
        }
    }
}

fn pose(rng: &mut Rng, size: f32) -> Pose {
    let p = match rng.next() % 4 {
        0 => Vec3::ZERO,
        1 => rng.vec(size),
        2 => rng.vec(2.0 * size),
        _ => Vec3::Y * (size * rng.range(0.0, 2.0)),
    };
    let q = match rng.next() % 3 {
        0 => Quat::IDENTITY,
        1 => Quat::from_axis_angle(Vec3::Y, std::f32::consts::FRAC_PI_2),
        _ => rng.rotation(),
    };
    Pose::new(p, q)
}

fn check(m: &Manifold, what: &str) {
    assert!((m.normal.length() - 1.0).abs() < 1e-3, "{m:?} {what}");
    assert!((1..=4).contains(&m.count), "{m:?} {what}");
    for (k, p) in m.points().iter().enumerate() {
        assert!(p.point.is_finite() && p.separation.is_finite(), "{m:?} {what}");
        assert!(m.points()[..k].iter().all(|q| q.feature != p.feature), "{m:?} {what}");
    }
}

#[test]
fn answers_are_finite_and_well_formed() {
    let mut rng = Rng(0xF022);
    let mut out = ManifoldSet::new();
    let cases = if std::env::var_os("JOUNCE_PROVE").is_some() { 1_000_000 } else { 20_000 };
    for n in 0..cases {
        let size = |rng: &mut Rng| SIZES[rng.next() as usize % 6];
        let e = size(&mut rng);
        let f = if rng.unit() < 0.5 { e } else { size(&mut rng) };
        let (i, j) = (rng.next() as usize % 10, rng.next() as usize % 10);
        let (a, b) = (shape(&mut rng, i, e), shape(&mut rng, j, f));
        let d = f32s::max(e, f);
        let pose = pose(&mut rng, d);
        let what = format!("#{n} {} of {e} m, {} of {f} m, {pose:?}", a.name(), b.name());
        collide(&a, &b, &pose, 0.02 * f32s::min(d, 1.0), &mut PairCache::default(), &mut out);
        out.manifolds.iter().for_each(|m| check(m, &what));
        let motion = rng.vec(3.0 * d);
        if let Some(h) = cast_shape(&a, &b, &pose, motion) {
            let good = (0.0..=1.0).contains(&h.t) && h.point.is_finite() && h.normal.is_finite();
            assert!(good, "{h:?} {what}");
        }
        if let Some(x) = distance(&a, &b, &pose, f32::MAX) {
            let good = x.distance >= 0.0 && x.point_a.is_finite() && x.point_b.is_finite();
            assert!(good && (x.normal.length() - 1.0).abs() < 1e-3, "{x:?} {what}");
        }
        let sweep = Sweep {
            local_center: Vec3::ZERO,
            center: [pose.p, pose.p + motion],
            rotation: [pose.q, rng.rotation()],
        };
        let toi = time_of_impact(&a, &b, &sweep, 1e-3 * f, 2.5e-4 * f);
        if let TimeOfImpact::Hit(t) | TimeOfImpact::Failed(t) = toi {
            assert!((0.0..=1.0).contains(&t), "{t} {what}");
        }
    }
}
