//! Random numbers and random worlds for tests.
#![allow(dead_code)]

use jounce::geometry::{Compound, HeightField, Hull, Shape, TriMesh, TriMeshOptions};
use jounce::prelude::*;
use std::sync::Arc;

/// A linear congruential generator: enough for tests, the same everywhere.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        let mut r = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        r.bits();
        r
    }
    pub fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as u32
    }
    pub fn below(&mut self, n: usize) -> usize {
        self.bits() as usize % n
    }
    /// Uniform in 0…1.
    pub fn unit(&mut self) -> f32 {
        self.bits() as f32 / (1u64 << 31) as f32
    }
    pub fn range(&mut self, lo: f32, hi: f32) -> f32 {
        lo + (hi - lo) * self.unit()
    }
    pub fn vec(&mut self, r: f32) -> Vec3 {
        Vec3::new(self.range(-r, r), self.range(-r, r), self.range(-r, r))
    }
    pub fn dir(&mut self) -> Vec3 {
        self.vec(1.0).normalize_or(Vec3::X)
    }
    pub fn turn(&mut self) -> Quat {
        let v = self.vec(1.0);
        Quat::new(v.x, v.y, v.z, self.range(-1.0, 1.0)).normalize()
    }
}

pub fn world() -> World {
    World::new(WorldDesc::default()).expect("defaults are valid")
}

pub fn step(world: &mut World, n: usize) {
    for _ in 0..n {
        world.step().expect("steps");
    }
}

pub fn ground(world: &mut World) -> BodyId {
    world.add_body(BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y))).expect("a half-space")
}

pub fn add_box(world: &mut World, at: [f64; 3], half: f32) -> BodyId {
    world.add_body(BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid([half; 3]))).expect("a box")
}

pub fn solid(r: &mut Random) -> Shape {
    let (a, b) = (r.range(0.2, 1.0), r.range(0.2, 1.0));
    match r.below(6) {
        0 => Shape::Sphere { radius: a },
        1 => Shape::Capsule { half_height: a, radius: b },
        2 => Shape::Box { half: Vec3::new(a, b, r.range(0.2, 1.0)) },
        3 => Shape::Cylinder { half_height: a, radius: b },
        4 => Shape::Cone { half_height: a, radius: b },
        _ => {
            let points: Vec<Vec3> = (0..12).map(|_| r.vec(a)).collect();
            Shape::Hull(Arc::new(Hull::new(&points).expect("a hull")))
        }
    }
}

pub fn surface(r: &mut Random) -> Shape {
    let n = 9;
    if r.below(2) == 0 {
        let heights = (0..n * n).map(|_| r.range(-0.3, 0.3)).collect();
        return Shape::HeightField(Arc::new(HeightField::new(n, n, [0.5, 0.5], heights).expect("a field")));
    }
    let at = |i: usize, j: usize, y: f32| Vec3::new(i as f32 * 0.5 - 2.0, y, j as f32 * 0.5 - 2.0);
    let vertices: Vec<Vec3> = (0..n * n).map(|k| at(k / n, k % n, r.range(-0.3, 0.3))).collect();
    let mut triangles = Vec::new();
    for i in 0..n - 1 {
        for j in 0..n - 1 {
            let k = (i * n + j) as u32;
            let m = n as u32;
            triangles.push([k, k + 1, k + m]);
            triangles.push([k + 1, k + m + 1, k + m]);
        }
    }
    Shape::Mesh(Arc::new(TriMesh::new(&vertices, &triangles, TriMeshOptions::default()).expect("a mesh")))
}

pub fn any_shape(r: &mut Random) -> Shape {
    match r.below(8) {
        0 => surface(r),
        1 => {
            let children = (0..3).map(|_| (Pose::new(r.vec(1.0), r.turn()), solid(r))).collect();
            Shape::Compound(Arc::new(Compound::new(children).expect("a compound")))
        }
        _ => solid(r),
    }
}

/// `n` bodies of all kinds and shapes within `r` metres of `center`, a half-space below; a few steps old.
pub fn random_world(seed: u64, n: usize, center: DVec3, radius: f32) -> World {
    let mut r = Random::new(seed);
    let mut w = world();
    let below = center + DVec3::new(0.0, -f64::from(radius), 0.0);
    w.add_body(BodyDesc::fixed().at(below).shape(ShapeDesc::half_space(Vec3::Y))).expect("a half-space");
    for i in 0..n {
        let shape = any_shape(&mut r);
        let light = shape.is_solid();
        let kind = match r.below(4) {
            0 => BodyKind::Fixed,
            1 => BodyKind::Kinematic,
            _ if light => BodyKind::Dynamic,
            _ => BodyKind::Fixed,
        };
        let mut desc = ShapeDesc::new(shape);
        desc.sensor = r.below(6) == 0;
        desc.filter.layers = 1 << r.below(4);
        if r.below(3) == 0 {
            desc.pose = Pose::new(r.vec(0.5), r.turn());
        }
        let mut body = BodyDesc::new(kind).at(center + r.vec(radius).as_dvec3()).rotated(r.turn());
        body.user_data = i as u128;
        body = body.shape(desc);
        if kind == BodyKind::Dynamic && r.below(3) == 0 {
            body = body.shape(ShapeDesc::new(solid(&mut r)).at(r.vec(0.5)));
        }
        if kind == BodyKind::Kinematic {
            body = body.velocity(r.vec(1.0));
        }
        w.add_body(body).expect("a body");
    }
    step(&mut w, 20);
    w
}
