//! The same world gives the same bits: on any number of threads, under any schedule, with any lanes, whatever
//! floating-point mode the caller left on, from a clone, on a second run, and in debug and release builds.
//!
//! The hash of every step is compared, so a failure names the first step that differs. `JOUNCE_PROVE=1` for full counts.

mod common;

use common::rng::Rng;
use common::storm::Storm;
use jounce::geometry::{Compound, TriMesh, TriMeshOptions};
use jounce::prelude::*;
use jounce::{AxisDesc, Command, MotorDesc, Width};
use std::sync::Arc;

/// Something to step.
#[derive(Clone)]
enum Scene {
    World(Box<World>),
    Storm(Box<Storm>),
    /// With what happens before each step.
    Led(Box<World>, fn(&mut World)),
}

impl Scene {
    fn world(&mut self) -> &mut World {
        match self {
            Self::World(w) | Self::Led(w, _) => w,
            Self::Storm(s) => &mut s.world,
        }
    }
    fn step(&mut self) {
        match self {
            Self::World(w) => w.step().expect("steps"),
            Self::Storm(s) => s.step(),
            Self::Led(w, lead) => {
                lead(w);
                w.step().expect("steps");
            }
        }
    }
    fn hashes(&mut self, steps: usize) -> Vec<u64> {
        let one = |_| {
            self.step();
            self.world().hash()
        };
        (0..steps).map(one).collect()
    }
}

type Make = fn() -> Scene;

const SCENES: [(&str, Make); 17] = [
    ("stacks", stacks),
    ("pile on a mesh", pile_on_a_mesh),
    ("bouncing balls", bouncing_balls),
    ("drum", drum),
    ("sensors", sensors),
    ("storm 7", || storm(7)),
    ("storm 39", || storm(39)),
    ("storm 130", || storm(130)),
    ("shower", shower),
    ("storm 52 with particles", || Scene::Storm(Box::new(Storm::new(52).with_particles(52)))),
    ("weather", || Scene::Led(Box::new(weather().0), change_the_weather)),
    ("storm 77 with fields and particles", || {
        Scene::Storm(Box::new(Storm::new(77).with_particles(77).with_fields(77)))
    }),
    ("linkages", linkages),
    ("traffic", || Scene::Led(Box::new(traffic()), drive)),
    ("crowd", || Scene::Led(Box::new(crowd()), walk)),
    ("dolls", dolls),
    ("storm 91 with joints, vehicles and characters", || {
        Scene::Storm(Box::new(Storm::new(91).with_movers(91).with_joints(91)))
    }),
];

fn steps() -> usize {
    if common::prove() { 600 } else { 120 }
}

fn empty() -> World {
    World::new(WorldDesc::default()).expect("valid")
}

fn add(world: &mut World, d: BodyDesc) -> BodyId {
    world.add_body(d).expect("valid")
}

fn storm(seed: u64) -> Scene {
    Scene::Storm(Box::new(Storm::new(seed)))
}

fn stacks() -> Scene {
    let mut world = empty();
    add(&mut world, BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y)));
    for i in 0..120 {
        let (x, y, z) = (f64::from(i % 4) * 1.1, 0.5 + f64::from(i / 12), f64::from(i / 4 % 3) * 1.02);
        add(&mut world, BodyDesc::dynamic().at([x, y, z]).shape(ShapeDesc::cuboid([0.5; 3])));
    }
    let cue = ShapeDesc::sphere(0.6).density(5000.0);
    add(&mut world, BodyDesc::dynamic().at([-8.0, 4.0, 1.0]).velocity([25.0, 0.0, 0.3]).shape(cue));
    Scene::World(Box::new(world))
}

fn mixed_shape(rng: &mut Rng) -> ShapeDesc {
    match rng.below(6) {
        0 => ShapeDesc::sphere(0.3),
        1 => ShapeDesc::capsule(0.3, 0.2),
        2 => ShapeDesc::cylinder(0.25, 0.3),
        3 => ShapeDesc::cone(0.35, 0.3),
        4 => {
            let arm = |p| (Pose::new(p, Quat::IDENTITY), Shape::Box { half: Vec3::new(0.4, 0.1, 0.1) });
            let cross = vec![arm(Vec3::new(0.3, 0.0, 0.0)), arm(Vec3::new(0.0, 0.2, 0.1))];
            ShapeDesc::new(Shape::Compound(Arc::new(Compound::new(cross).expect("convex"))))
        }
        _ => ShapeDesc::cuboid([0.3, 0.2, 0.4]),
    }
}

fn bowl() -> ShapeDesc {
    let n = 12u32;
    let corner = |i: u32, j: u32| {
        let (x, z) = (i as f32 - 6.0, j as f32 - 6.0);
        Vec3::new(x, 0.05 * (x * x + z * z), z)
    };
    let vertices: Vec<Vec3> = (0..=n).flat_map(|j| (0..=n).map(move |i| corner(i, j))).collect();
    let cell = |i: u32, j: u32| {
        let a = j * (n + 1) + i;
        [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]
    };
    let triangles: Vec<[u32; 3]> = (0..n).flat_map(|j| (0..n).flat_map(move |i| cell(i, j))).collect();
    let mesh = TriMesh::new(&vertices, &triangles, TriMeshOptions::default()).expect("a bowl");
    ShapeDesc::mesh(Arc::new(mesh))
}

fn pile_on_a_mesh() -> Scene {
    let (mut world, mut rng) = (empty(), Rng::new(11));
    add(&mut world, BodyDesc::fixed().shape(bowl()));
    for i in 0..100 {
        let at = [rng.double(-1.5, 1.5), 1.0 + 0.25 * f64::from(i), rng.double(-1.5, 1.5)];
        let shape = mixed_shape(&mut rng);
        add(&mut world, BodyDesc::dynamic().at(at).rotated(rng.quat()).shape(shape));
    }
    Scene::World(Box::new(world))
}

fn bouncing_balls() -> Scene {
    let (mut world, mut rng) = (empty(), Rng::new(12));
    add(&mut world, BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).restitution(0.9)));
    for side in [Vec3::X, -Vec3::X, Vec3::Z, -Vec3::Z] {
        let wall = ShapeDesc::half_space(side).at(side * -3.0);
        add(&mut world, BodyDesc::fixed().shape(wall));
    }
    for _ in 0..150 {
        let at = [rng.double(-2.5, 2.5), rng.double(0.5, 6.0), rng.double(-2.5, 2.5)];
        let ball = ShapeDesc::sphere(rng.float(0.1, 0.3)).restitution(rng.float(0.0, 1.0)).hit_events(true);
        add(&mut world, BodyDesc::dynamic().at(at).velocity(rng.vec3(6.0)).bullet(rng.one_in(4)).shape(ball));
    }
    Scene::World(Box::new(world))
}

fn drum() -> Scene {
    let (mut world, mut rng) = (empty(), Rng::new(13));
    let mut d = BodyDesc::kinematic().angular_velocity([0.0, 0.0, 1.5]);
    for k in 0..8 {
        let turn = Quat::from_axis_angle(Vec3::Z, k as f32 * core::f32::consts::FRAC_PI_4);
        let wall = ShapeDesc::cuboid([1.4, 0.2, 2.0]).at(turn.rotate(Vec3::new(0.0, -3.0, 0.0)));
        d = d.shape(wall.rotated(turn));
    }
    for z in [-2.2, 2.2] {
        d = d.shape(ShapeDesc::cuboid([4.0, 4.0, 0.2]).at([0.0, 0.0, z]));
    }
    add(&mut world, d);
    for i in 0..120 {
        let at =
            [f64::from(i % 5) * 0.6 - 1.2, f64::from(i / 20) * 0.6 - 1.6, f64::from(i / 5 % 4) * 0.8 - 1.2];
        let shape = mixed_shape(&mut rng);
        add(&mut world, BodyDesc::dynamic().at(at).rotated(rng.quat()).shape(shape));
    }
    Scene::World(Box::new(world))
}

fn sensors() -> Scene {
    let (mut world, mut rng) = (empty(), Rng::new(14));
    add(&mut world, BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).friction(0.2)));
    let gate = ShapeDesc::cuboid([1.0, 2.0, 4.0]).sensor();
    let lift = add(&mut world, BodyDesc::kinematic().at([2.0, 1.0, 0.0]).shape(gate));
    world.move_to(lift, DVec3::new(2.2, 1.1, 0.0), Quat::IDENTITY).expect("kinematic");
    for i in 0..80 {
        let at = [rng.double(-4.0, 4.0), 0.5 + 0.2 * f64::from(i), rng.double(-3.0, 3.0)];
        let mut shape = mixed_shape(&mut rng);
        shape.hit_events = true;
        shape.material.rolling_friction = 0.02;
        let b = add(&mut world, BodyDesc::dynamic().at(at).rotated(rng.quat()).shape(shape));
        world.queue(Command::AddImpulse(b, rng.vec3(200.0), None)).expect("room in the queue");
    }
    let push: jounce::ContactHook = Arc::new(|c, s| {
        s.velocity = c.normal.cross(Vec3::X);
        true
    });
    world.set_contact_hook(Some(("belt", push)));
    Scene::World(Box::new(world))
}

/// Particles of every kind over a heap: turbulence, heat, pushes, hits, a rider, one that sticks.
fn shower() -> Scene {
    let Scene::World(mut world) = pile_on_a_mesh() else { return bouncing_balls() };
    add(&mut world, BodyDesc::fixed().at([0.0, -2.0, 0.0]).shape(ShapeDesc::half_space(Vec3::Y)));
    let rider = world.bodies().nth(40).expect("a heap");
    let turbulence = jounce::Turbulence { speed: 2.0, size: 0.8, time_s: 0.5, seed: 3 };
    let c = ParticleCollision { push: true, hit_events: true, ..ParticleCollision::default() };
    let base = EmitterDesc::new()
        .at([0.0, 6.0, 0.0])
        .lifetime(0.5, 2.0)
        .spread(1.5)
        .speed(1.0, 4.0)
        .linear_drag(0.5);
    let mut emit = |d| world.add_emitter(d).expect("valid");
    emit(EmitterDesc { mass: 0.02, ..base.clone().rate(900.0).collision(c).turbulence(turbulence) });
    let heat = jounce::Heat { excess: 200.0, ambient: 293.0, cooling_s: 0.8 };
    emit(EmitterDesc {
        heat: Some(heat),
        ..base.clone().at([0.0, 0.5, 0.0]).on(rider).rate(700.0).turbulence(turbulence)
    });
    let stick = ParticleCollision { response: jounce::HitResponse::Stick, ..ParticleCollision::default() };
    emit(base.clone().rate(500.0).burst(0.7, 1500).collision(stick));
    emit(base.rate(500.0).collision(ParticleCollision::default()));
    Scene::World(world)
}

/// All nine laws at once, in regions and everywhere, over a heap in a pond, with emitters of several kinds among them.
/// Gives the fields in the order of the laws.
fn weather() -> (World, Vec<FieldId>) {
    let (mut world, mut rng) = (empty(), Rng::new(15));
    add(&mut world, BodyDesc::fixed().at([0.0, -1.0, 0.0]).shape(ShapeDesc::half_space(Vec3::Y)));
    let mut heap = Vec::new();
    for i in 0..90u32 {
        let at = [rng.double(-3.0, 3.0), 0.3 * f64::from(i % 30) - 0.5, rng.double(-3.0, 3.0)];
        let aero = Aero { lift: if i % 3 == 0 { 1.0 } else { 0.0 }, ..Aero::default() };
        let shape = mixed_shape(&mut rng).density(*rng.pick(&[150.0, 400.0, 2000.0])).aero(aero);
        let d = BodyDesc::dynamic().at(at).rotated(rng.quat()).velocity(rng.vec3(4.0)).shape(shape);
        heap.push(add(&mut world, BodyDesc { user_data: i.into(), ..d.angular_velocity(rng.vec3(5.0)) }));
    }
    let hook: jounce::FieldHook =
        Arc::new(|v| Vec3::Y.cross(v.velocity) * 0.3 + Vec3::X * ((v.user_data % 3) as f32 * 0.4 - 0.4));
    world.set_field_hook("odd ones", Some(hook));
    let near = |center: [f64; 3], radius: f64| Region::Sphere {
        center: DVec3::from_array(center),
        radius,
        falloff: 0.3 * radius,
    };
    let gust = jounce::Gust { speed: 4.0, size: 1.5, time_s: 0.7, seed: 6 };
    let box_ = Region::Box { center: DVec3::ZERO, half: DVec3::new(6.0, 20.0, 6.0), falloff: 1.0 };
    let (density, viscosity) = (1.2, 1.81e-5);
    let fields = [
        FieldDesc::new(FieldLaw::Uniform { acceleration: Vec3::new(0.4, 1.0, 0.0) })
            .within(near([2.0, 2.0, 0.0], 4.0)),
        FieldDesc::new(FieldLaw::Point { center: DVec3::new(0.0, 3.0, 0.0), mu: 8.0, softening: 0.5 }),
        FieldDesc::new(FieldLaw::NBody { bodies: heap[..30].to_vec(), g: 2e-4, softening: 0.2 }),
        FieldDesc::new(FieldLaw::Wind { velocity: Vec3::new(5.0, 0.0, -2.0), gust: Some(gust) }),
        FieldDesc::new(FieldLaw::Drag { density, viscosity }).within(box_),
        FieldDesc::water(0.2),
        FieldDesc::new(FieldLaw::Vortex {
            center: DVec3::new(-1.0, 0.0, 1.0),
            axis: Vec3::Y,
            speed: 8.0,
            core_radius: 0.8,
            inflow: 0.2,
            updraft: 3.0,
        })
        .within(near([-1.0, 2.0, 1.0], 5.0)),
        FieldDesc::new(FieldLaw::RotatingFrame {
            origin: DVec3::ZERO,
            angular_velocity: Vec3::Y * 0.3,
            angular_acceleration: Vec3::new(0.0, 0.05, 0.0),
        }),
        FieldDesc::new(FieldLaw::User { hook: "odd ones".to_owned() }),
    ];
    let fields = fields.map(|f| world.add_field(f).expect("valid")).to_vec();
    let turbulence = jounce::Turbulence { speed: 2.0, size: 0.8, time_s: 0.5, seed: 3 };
    let push = ParticleCollision { push: true, hit_events: true, ..ParticleCollision::default() };
    let base = EmitterDesc::new().at([0.0, 5.0, 0.0]).lifetime(0.5, 2.5).spread(1.0).speed(1.0, 4.0);
    let mut emit = |d| world.add_emitter(d).expect("valid");
    emit(EmitterDesc { mass: 0.02, ..base.clone().rate(800.0).collision(push).turbulence(turbulence) });
    emit(base.clone().at([0.0, 0.3, 0.0]).on(heap[40]).rate(600.0).linear_drag(0.5));
    let stick = ParticleCollision { response: jounce::HitResponse::Stick, ..ParticleCollision::default() };
    emit(
        base.shape(EmitterShape::Box { half: Vec3::splat(2.0) })
            .burst(0.4, 2000)
            .rate(300.0)
            .collision(stick),
    );
    (world, fields)
}

/// Blasts, and fields switched and replaced, at fixed times.
fn change_the_weather(world: &mut World) {
    let step = world.step_count();
    if step % 25 == 10 {
        let center = [0.2 * (step % 7) as f64 - 0.6, 0.0, 0.5];
        world.explode(Explosion::new(center, 4.0, 60.0)).expect("valid");
    }
    let all: Vec<FieldId> = world.fields().collect();
    if step % 40 == 30 {
        let id = all[(step / 40) as usize % all.len()];
        let mut desc = world.field(id).expect("alive").clone();
        desc.enabled = !desc.enabled;
        world.set_field(id, desc).expect("valid");
    }
    if step == 50 {
        let desc = world.field(all[1]).expect("alive").clone();
        world.remove_field(all[1]).expect("alive");
        world.queue(Command::AddField(Box::new(desc))).expect("room in the queue");
    }
}

/// Chains, bridges and a dense net on a heap; hinges with motors, springs, ropes.
fn linkages() -> Scene {
    let Scene::World(mut world) = pile_on_a_mesh() else { return bouncing_balls() };
    let post = add(&mut world, BodyDesc::fixed().at([0.0, 9.0, 0.0]));
    let mut last = post;
    for i in 0..20u32 {
        let y = 8.8 - 0.3 * f64::from(i);
        let link = ShapeDesc::capsule(0.1, 0.05).density(if i == 19 { 50_000.0 } else { 1000.0 });
        let b = add(&mut world, BodyDesc::dynamic().at([0.0, y, 0.0]).velocity([0.5, 0.0, 0.2]).shape(link));
        let at = DVec3::new(0.0, y + 0.15, 0.0);
        let d = JointDesc::ball(last, b, at).cone_twist(1.0, -0.5, 0.5);
        world.add_joint(if i % 7 == 3 { JointDesc::fixed(last, b, at) } else { d }).expect("valid");
        last = b;
    }
    // A net of ropes between balls, and a motor that turns a bar through it.
    let mut net = Vec::new();
    for i in 0..36u32 {
        let at = DVec3::new(f64::from(i % 6) * 0.5 - 1.2, 5.0, f64::from(i / 6) * 0.5 - 1.2);
        net.push((add(&mut world, BodyDesc::dynamic().at(at).shape(ShapeDesc::sphere(0.08))), at));
    }
    let rope = |world: &mut World, a: (BodyId, DVec3), b: (BodyId, DVec3)| {
        world.add_joint(JointDesc::rope(a.0, b.0, a.1, b.1, 0.5)).expect("valid");
    };
    for i in 0..36usize {
        if i % 6 < 5 {
            rope(&mut world, net[i], net[i + 1]);
        }
        if i < 30 {
            rope(&mut world, net[i], net[i + 6]);
        }
    }
    for corner in [0, 5, 30, 35] {
        let p = net[corner].1;
        let spring =
            JointDesc::spring(post, net[corner].0, p + DVec3::Y * 2.0, p, SpringDesc::hertz(2.0, 0.2));
        world.add_joint(spring).expect("valid");
    }
    let bar = ShapeDesc::cuboid([1.2, 0.05, 0.05]);
    let bar = add(&mut world, BodyDesc::dynamic().at([0.0, 4.0, 0.0]).shape(bar));
    let mut motor = JointDesc::hinge(post, bar, [0.0, 4.0, 0.0], Vec3::Y);
    motor.kind = JointKind::Hinge(AxisDesc::FREE.motor(MotorDesc::velocity(3.0, 200.0)));
    world.add_joint(motor).expect("valid");
    Scene::World(world)
}

/// Every preset among boxes, on a bumpy road, two of each.
fn traffic() -> World {
    use jounce::vehicles;
    let (mut world, mut rng) = (empty(), Rng::new(16));
    add(&mut world, BodyDesc::fixed().shape(ShapeDesc::half_space(Vec3::Y).friction(0.9)));
    for _ in 0..40 {
        let at = [rng.double(-30.0, 30.0), 0.0, rng.double(-10.0, 40.0)];
        let kerb = ShapeDesc::cuboid([rng.float(0.3, 2.0), 0.08, rng.float(0.2, 1.0)]);
        add(&mut world, BodyDesc::fixed().at(at).shape(kerb));
    }
    for _ in 0..40 {
        let at = [rng.double(-25.0, 25.0), 0.5, rng.double(5.0, 30.0)];
        let d = BodyDesc::dynamic().at(at).shape(ShapeDesc::cuboid([0.4; 3]).density(200.0));
        add(&mut world, d);
    }
    let kits = [
        vehicles::car,
        vehicles::sports_car,
        vehicles::off_road,
        vehicles::motorcycle,
        vehicles::tank,
        vehicles::snowboard,
    ];
    for (i, kit) in kits.into_iter().enumerate() {
        for z in [0.0, -9.0] {
            let at = [7.0 * i as f64 - 18.0, 0.3, z];
            kit().add(&mut world, at, Quat::IDENTITY).expect("valid");
        }
    }
    world
}

/// Picks, computes nothing: it runs in the caller's floating-point mode.
fn drive(world: &mut World) {
    let step = world.step_count();
    if !step.is_multiple_of(10) {
        return;
    }
    let mut rng = Rng::new(step);
    for id in world.vehicles().collect::<Vec<_>>() {
        let input = VehicleInput {
            throttle: *rng.pick(&[0.3, 0.6, 1.0]),
            brake: if rng.one_in(6) { 1.0 } else { 0.0 },
            steer: *rng.pick(&[-1.0, -0.4, 0.0, 0.2, 0.7]),
            gear: 1 + rng.below(3) as i32,
            lean: *rng.pick(&[-0.5, -0.1, 0.0, 0.3]),
            jump: if rng.one_in(4) { 1.0 } else { 0.0 },
            ..VehicleInput::default()
        };
        world.set_vehicle_input(id, input).expect("alive");
    }
}

/// Walkers and dynamic ones on a heap, a lift and a turntable.
fn crowd() -> World {
    let Scene::World(mut world) = pile_on_a_mesh() else { return empty() };
    let lift = ShapeDesc::cuboid([1.5, 0.1, 1.5]);
    let turn =
        BodyDesc::kinematic().at([3.0, 2.2, 0.0]).angular_velocity([0.0, 1.0, 0.0]).shape(lift.clone());
    add(&mut world, turn);
    add(&mut world, BodyDesc::kinematic().at([-3.0, 2.0, 0.0]).velocity([0.2, 0.5, 0.0]).shape(lift));
    for i in 0..24u32 {
        let at = [f64::from(i % 6) * 1.2 - 3.0, 2.5 + 0.5 * f64::from(i / 12), f64::from(i / 6) * 1.1 - 1.6];
        let d = jounce::CharacterDesc::at(at);
        world.add_character(if i % 2 == 0 { d } else { d.dynamic() }).expect("valid");
    }
    *world
}

/// Picks, computes nothing, too.
fn walk(world: &mut World) {
    let step = world.step_count();
    if !step.is_multiple_of(15) {
        return;
    }
    let mut rng = Rng::new(step);
    for id in world.characters().collect::<Vec<_>>() {
        let input = jounce::CharacterInput {
            walk: *rng.pick(&[Vec3::X, Vec3::new(-2.0, 0.0, 1.0), Vec3::new(0.5, 0.0, -3.0), Vec3::ZERO]),
            jump: rng.one_in(4).then_some(4.0),
            crouch: rng.one_in(5),
            ..jounce::CharacterInput::default()
        };
        world.set_character_input(id, input).expect("alive");
    }
}

/// People who fall on a heap.
fn dolls() -> Scene {
    let Scene::World(mut world) = pile_on_a_mesh() else { return bouncing_balls() };
    let mut rng = Rng::new(17);
    for i in 0..8u32 {
        let at = [rng.double(-1.5, 1.5), 3.0 + f64::from(i), rng.double(-1.5, 1.5)];
        let d = jounce::RagdollDesc::human().at(at).rotated(rng.quat()).group(-1 - i as i32);
        world.add_ragdoll(&d).expect("valid");
    }
    Scene::World(world)
}

/// Each law moves something: without it the world goes another way. So do the emitters and the blasts.
#[test]
fn every_law_of_the_weather_acts() {
    let run = |mut world: World, changing: bool| {
        for _ in 0..45 {
            if changing {
                change_the_weather(&mut world);
            }
            world.step().expect("steps");
        }
        assert!(world.counts().particles == 0 || world.counts().particles > 1000);
        world.bodies().map(|b| world.body(b).expect("alive").position()).collect::<Vec<_>>()
    };
    let reference = run(weather().0, true);
    assert_ne!(run(weather().0, false), reference, "blasts and switches");
    let (mut still, fields) = weather();
    for e in still.emitters().collect::<Vec<_>>() {
        still.remove_emitter(e).expect("alive");
    }
    assert_ne!(run(still, true), reference, "emitters push");
    for (i, id) in fields.iter().enumerate() {
        let (mut without, _) = weather();
        let law = without.field(*id).expect("alive").law.name();
        let mut desc = without.field(*id).expect("alive").clone();
        desc.enabled = false;
        without.set_field(*id, desc).expect("valid");
        assert_ne!(run(without, true), reference, "{i}: {law}");
    }
}

/// Asserts that a prepared scene gives the reference's hash at every step.
fn agree(name: &str, what: &str, reference: &[u64], mut scene: Scene) {
    for (step, &expected) in reference.iter().enumerate() {
        scene.step();
        let got = scene.world().hash();
        assert_eq!(got, expected, "{name}, {what}: step {} of {} differs", step + 1, reference.len());
    }
}

#[test]
fn a_second_run_gives_the_same_bits() {
    for (name, make) in SCENES {
        let reference = make().hashes(steps());
        let distinct = reference.windows(2).filter(|w| w[0] != w[1]).count();
        assert!(distinct + 1 >= reference.len(), "{name}: the hash does not follow the steps");
        agree(name, "second run", &reference, make());
    }
}

#[test]
fn scenes_are_worth_comparing() {
    for (name, make) in SCENES {
        let mut scene = make();
        let (mut touching, mut events) = (0, 0);
        for _ in 0..120 {
            scene.step();
            touching = touching.max(scene.world().counts().touching);
            events += scene.world().events().len();
        }
        assert!(touching >= 8 && events >= 8, "{name}: {touching} contacts, {events} events");
    }
}

#[test]
fn threads_do_not_change_bits() {
    for (name, make) in SCENES {
        let reference = make().hashes(steps());
        for threads in [1, 2, 4, 16] {
            let mut scene = make();
            scene.world().set_tasks(Tasks::pool(threads));
            agree(name, &format!("{threads} threads"), &reference, scene);
        }
    }
}

#[test]
fn schedules_do_not_change_bits() {
    let schedules = if common::prove() { 50 } else { 20 };
    for (name, make) in [1, 3, 5, 8, 10, 11, 12, 13, 14, 15, 16].map(|i| SCENES[i]) {
        let reference = make().hashes(steps());
        for seed in 0..schedules {
            let mut scene = make();
            let tasks = if seed % 4 == 3 { Tasks::chaos_pool(2, seed) } else { Tasks::chaos(seed) };
            scene.world().set_tasks(tasks);
            agree(name, &format!("schedule {seed}"), &reference, scene);
        }
    }
}

#[test]
fn lanes_do_not_change_bits() {
    for (name, make) in SCENES {
        let mut scene = make();
        scene.world().set_width(Width::X1);
        let reference = scene.hashes(steps());
        for width in Width::ALL {
            let mut scene = make();
            scene.world().set_width(width);
            agree(name, &format!("{width:?}"), &reference, scene);
        }
    }
}

#[test]
fn a_clone_has_the_same_future() {
    for (name, make) in SCENES {
        let mut scene = make();
        let mut clones = Vec::new();
        let mut reference = Vec::new();
        for step in 0..steps() {
            if step % 30 == 15 {
                clones.push((step, scene.clone()));
            }
            scene.step();
            reference.push(scene.world().hash());
        }
        for (step, clone) in clones {
            agree(name, &format!("clone after step {step}"), &reference[step..], clone);
        }
    }
}

#[test]
#[cfg(target_arch = "x86_64")]
fn the_callers_float_mode_does_not_change_bits() {
    for (name, make) in SCENES {
        let reference = make().hashes(steps());
        for mode in [|f: &mut dyn FnMut()| with_mode(FLUSH, f), |f: &mut dyn FnMut()| with_mode(ROUND_UP, f)]
        {
            let mut scene = make();
            for (step, &expected) in reference.iter().enumerate() {
                match &mut scene {
                    Scene::World(w) => mode(&mut || w.step().expect("steps")),
                    Scene::Led(w, lead) => mode(&mut || {
                        lead(w);
                        w.step().expect("steps");
                    }),
                    // Its own arithmetic is the test's, not the engine's.
                    Scene::Storm(s) => {
                        s.around = mode;
                        s.step();
                    }
                }
                assert_eq!(scene.world().hash(), expected, "{name}: step {} differs", step + 1);
            }
        }
    }
}

/// MXCSR: exceptions masked, denormals are zero (bit 6), flush to zero (bit 15).
#[cfg(target_arch = "x86_64")]
const FLUSH: u32 = 0x1f80 | 1 << 15 | 1 << 6;
/// The same, rounding up (bits 13 and 14: 2).
#[cfg(target_arch = "x86_64")]
const ROUND_UP: u32 = FLUSH | 2 << 13;

#[cfg(target_arch = "x86_64")]
fn with_mode(mode: u32, f: &mut dyn FnMut()) {
    let mut before = 0u32;
    // SAFETY: stores MXCSR in a variable of its size, then loads a mode with all exceptions masked.
    unsafe {
        core::arch::asm!("stmxcsr [{}]", in(reg) &raw mut before);
        core::arch::asm!("ldmxcsr [{}]", in(reg) &raw const mode);
    }
    f();
    // SAFETY: loads the mode that was found.
    unsafe { core::arch::asm!("ldmxcsr [{}]", in(reg) &raw const before) };
}

/// Debug and release builds, and every machine, end in these bits.
///
/// A change of the engine's arithmetic changes them. Mint them anew with
/// `JOUNCE_MINT=1 cargo test -p jounce --test determinism golden`, and give the reason in the commit.
#[test]
fn golden_hashes() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden_hashes.txt");
    let line = |i: usize| {
        let (name, make) = SCENES[i];
        format!("{:#018x}  {name}, 120 steps\n", make().hashes(120)[119])
    };
    let got = [1, 6, 10, 11, 13, 14, 15].map(line).concat();
    if std::env::var_os("JOUNCE_MINT").is_some() {
        std::fs::write(path, &got).expect("writable");
    }
    let golden = std::fs::read_to_string(path).expect("tests/golden_hashes.txt");
    assert_eq!(got, golden, "if the arithmetic was meant to change: see the comment of this test");
}
