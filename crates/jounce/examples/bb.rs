use jounce::geometry::*;
use jounce::math::*;
fn main() {
    let a = Shape::Box { half: Vec3::splat(0.5) };
    let mut set = ManifoldSet::new();
    let mut cache = PairCache::default();
    for i in 0..6 {
        let e = 1e-4 * i as f32;
        let q = Quat::from_axis_angle(Vec3::new(1.0, 0.3, 0.7).normalize_or(Vec3::X), 1e-4 * i as f32);
        collide(&a, &a, &Pose::new(Vec3::new(e, 0.995, -e * 0.5), q), 0.02, &mut cache, &mut set);
        for m in &set.manifolds {
            println!("n {:?} faces {} cnt {}", m.normal, m.faces, m.count);
            for p in m.points() {
                println!("   {:?} {} {:#x}", p.point, p.separation, p.feature);
            }
        }
    }
}
