//! Pairs that are tested together against the same pairs one by one, and what a pair that is apart says of how far.

mod common;
use common::Rng;
use jounce_geometry::{Batch, Hull, ManifoldSet, PairCache, Shape, collide, collide_again, distance};
use jounce_lanes::Width;
use jounce_math::{Pose, Quat, Vec3, scalar::f32s};
use std::sync::Arc;

const MARGIN: f32 = 0.02;

fn shape(rng: &mut Rng, hull: &Shape) -> Shape {
    let r = |rng: &mut Rng| rng.range(0.1, 1.0);
    match rng.next() % 8 {
        0 | 1 => Shape::Sphere { radius: r(rng) },
        2 | 3 => Shape::Capsule { half_height: r(rng), radius: r(rng) },
        4..=6 => Shape::Box { half: Vec3::new(r(rng), r(rng), r(rng)) },
        _ => hull.clone(),
    }
}

/// Anywhere from deep inside to just apart; some with axes along one another, some of those in one line.
fn pose(rng: &mut Rng, a: &Shape, b: &Shape) -> Pose {
    let q = match rng.next() % 4 {
        0 => Quat::IDENTITY,
        1 => Quat::from_axis_angle(rng.direction(), 1e-4),
        _ => rng.rotation(),
    };
    let n = if rng.next().is_multiple_of(4) { Vec3::Y } else { rng.direction() };
    let reach = common::support(a, n).dot(n) - q.rotate(common::support(b, q.inverse_rotate(-n))).dot(n);
    let part = if rng.next().is_multiple_of(50) { 0.0 } else { rng.range(0.2, 1.1) };
    Pose::new(n * (reach * part), q)
}

fn corners(rng: &mut Rng) -> Shape {
    let points: Vec<Vec3> = (0..12).map(|_| rng.direction() * rng.range(0.3, 1.0)).collect();
    Shape::Hull(Arc::new(Hull::new(&points).expect("a hull")))
}

/// In every width, in batches of any size, as pairs move on: the same manifolds, and the same is known of each pair.
#[test]
fn together_is_as_one_by_one() {
    let mut rng = Rng(5);
    let hull = corners(&mut rng);
    let (mut touching, mut apart) = (0, 0);
    for round in 0..400 {
        let n = 1 + rng.next() as usize % 40;
        let pairs: Vec<[Shape; 2]> =
            (0..n).map(|_| [shape(&mut rng, &hull), shape(&mut rng, &hull)]).collect();
        let mut poses: Vec<Pose> = pairs.iter().map(|[a, b]| pose(&mut rng, a, b)).collect();
        if round % 7 == 0 {
            poses[0].p.x = f32::NAN;
        }
        let mut alone = vec![PairCache::default(); n];
        let mut caches = Width::ALL.map(|_| alone.clone());
        for _ in 0..4 {
            let mut want = Vec::new();
            for (k, [a, b]) in pairs.iter().enumerate() {
                let mut set = ManifoldSet::new();
                collide_again(a, b, &poses[k], MARGIN, &mut alone[k], &mut None, &mut set);
                touching += usize::from(!set.manifolds.is_empty());
                apart += usize::from(set.manifolds.is_empty());
                want.push(set.manifolds);
            }
            let mut batch = Batch::default();
            for (width, caches) in Width::ALL.into_iter().zip(&mut caches) {
                batch.clear();
                for (k, [a, b]) in pairs.iter().enumerate() {
                    assert_eq!(batch.push(a, b, &poses[k], MARGIN, &caches[k]), k);
                }
                batch.run(width);
                for (k, [a, b]) in pairs.iter().enumerate() {
                    let mut set = ManifoldSet::new();
                    batch.collide(k, a, b, &mut caches[k], &mut None, &mut set);
                    assert_eq!(set.manifolds, want[k], "{width}, {a:?}, {b:?}, {:?}", poses[k]);
                    assert_eq!(caches[k], alone[k], "{width}, {a:?}, {b:?}, {:?}", poses[k]);
                }
            }
            for p in &mut poses {
                p.p += rng.direction() * 0.01;
                p.q = (Quat::from_axis_angle(rng.direction(), 0.01) * p.q).normalize();
            }
        }
    }
    assert!(touching > 10_000 && apart > 3_000, "{touching} touching, {apart} apart");
}

/// A pair that is apart is as far apart as it says, or farther; balls and capsules say it whenever they are.
#[test]
fn gaps_are_no_larger_than_distances() {
    let mut rng = Rng(9);
    let hull = corners(&mut rng);
    let mut told = 0;
    for _ in 0..20_000 {
        let (a, b) = (shape(&mut rng, &hull), shape(&mut rng, &hull));
        let pose = pose(&mut rng, &a, &b);
        let (mut cache, mut set) = (PairCache::default(), ManifoldSet::new());
        collide(&a, &b, &pose, MARGIN, &mut cache, &mut set);
        let segment = |s: &Shape| match s {
            Shape::Sphere { .. } => Some(0.0),
            Shape::Capsule { half_height, .. } => Some(2.0 * half_height),
            _ => None,
        };
        if !set.manifolds.is_empty() {
            assert_eq!(cache.gap.to_bits(), 0, "{a:?}, {b:?}, {pose:?}");
            continue;
        }
        let real = distance(&a, &b, &pose, f32::MAX).expect("solid").distance;
        assert!(cache.gap <= real * 1.00001 + 1e-5, "{} for {real}: {a:?}, {b:?}, {pose:?}", cache.gap);
        if let (Some(la), Some(lb)) = (segment(&a), segment(&b)) {
            let least = real * 0.99999 - 1e-5 - 1e-3 * f32s::min(la, lb);
            assert!(cache.gap >= least, "{} for {real}: {a:?}, {b:?}, {pose:?}", cache.gap);
        }
        told += usize::from(cache.gap > MARGIN);
    }
    assert!(told > 1_000, "{told}");
}
